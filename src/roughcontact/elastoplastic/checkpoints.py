"""Checkpoints of a run in a folder, from which the same call resumes."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools import checkpoints, netcdf
from roughcontact._tools.checkpoints import RunFolder
from roughcontact.contact import archive as contact_archive
from roughcontact.elastoplastic import archive
from roughcontact.elastoplastic.problem import ElastoplasticProblem, Extent
from roughcontact.elastoplastic.volume_result import ElastoplasticResult, Increment, PathPoint
from roughcontact.errors import FormatError, InputError, OtherRunError

Array = NDArray[Any]

_BODY = ("places", "strain", "accumulated")


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """State from which the next point of a path starts."""

    extent: Extent  # Extent of the volume
    bodies: list[tuple[Array, Array]]
    pressure: Array  # Pressure on the map [Pa]
    increments: tuple[Increment, ...]  # Increments so far
    largest: tuple[float, Array | None] = (0.0, None)  # Largest load [N] and its pressure [Pa]
    seconds: float = 0.0  # Computing time so far
    carried: Mapping[str, Array] = field(default_factory=dict)
    result: ElastoplasticResult | None = None  # Complete state, if it is available

    @classmethod
    def from_result(
        cls, result: ElastoplasticResult, carried: Mapping[str, Array] | None = None
    ) -> Checkpoint:
        """Return the checkpoint of a result and the values carried to the next load."""
        bodies = [(body.plastic_strain, body.accumulated) for body in result.bodies]
        return cls(
            Extent.from_result(result),
            bodies,
            result.solution.pressure,
            result.increments,
            result.largest,
            result.seconds,
            carried or {},
            result,
        )


def write_checkpoint(checkpoint: Checkpoint, path: str | os.PathLike[str]) -> None:
    """Write a checkpoint to a NetCDF file: only yielded points, without stress."""
    dataset = netcdf.Dataset(
        {
            "margin": checkpoint.extent.margin,
            "largest_load": checkpoint.largest[0],
            "seconds": checkpoint.seconds,
            "bodies": len(checkpoint.bodies),
        }
    )
    arrays = {
        "thickness": checkpoint.extent.thickness,
        "grid": np.array(checkpoint.bodies[0][1].shape[1:]),
        "pressure": checkpoint.pressure,
    }
    if checkpoint.largest[1] is not None:
        arrays["largest_pressure"] = checkpoint.largest[1]
    for number, (strain, accumulated) in enumerate(checkpoint.bodies):
        places = np.flatnonzero(accumulated)
        by_component = np.moveaxis(strain, 1, 0).reshape(5, -1)
        held = places, by_component[:, places], accumulated.ravel()[places]
        arrays |= {f"{name}_{number}": part for name, part in zip(_BODY, held, strict=True)}
    archive.add_arrays(dataset, arrays)
    archive.add_arrays(dataset, checkpoint.carried, archive.CARRIED)
    archive.add_increments(dataset, checkpoint.increments)
    netcdf.write(dataset, path)


def read_checkpoint(path: Path) -> Checkpoint:
    """Read a checkpoint of `write_checkpoint`, equal to the bit."""
    dataset = contact_archive.open_archive(path)
    with contact_archive.as_format_error(path, "solve_elastoplastic"):
        arrays = {name: variable.values for name, variable in dataset.variables.items()}
        thickness, shape = arrays["thickness"], tuple(arrays["grid"].tolist())
        bodies = []
        for number in range(int(dataset.attrs["bodies"])):
            strain = np.zeros((5, thickness.size * shape[0] * shape[1]))
            accumulated = np.zeros(strain.shape[1])
            if f"places_{number}" in arrays:
                places, yielded, amount = (arrays[f"{name}_{number}"] for name in _BODY)
                strain[:, places], accumulated[places] = yielded, amount
            whole = strain.reshape(5, thickness.size, *shape).swapaxes(0, 1)
            bodies.append((whole, accumulated.reshape(thickness.size, *shape)))
        return Checkpoint(
            Extent(thickness, int(dataset.attrs["margin"])),
            bodies,
            arrays["pressure"],
            archive.increments_of(dataset),
            (float(dataset.attrs["largest_load"]), arrays.get("largest_pressure")),
            float(dataset.attrs["seconds"]),
            archive.carried_arrays(dataset),
        )


class CheckpointSeries:
    """Checkpoints of a run after each load, as files in a folder; empty without a folder."""

    def __init__(
        self, place: RunFolder | None, problem: ElastoplasticProblem, path: list[PathPoint]
    ) -> None:
        self._problem, self._path = problem, path
        # With a counter-surface that moves, only the data for the next step are kept.
        self._travels = any(any(point.offset) or point.friction for point in path)
        self._files: list[Path] = []
        self._note: Path | None = None
        self._mark: dict[str, Array] = {}
        if place is not None:
            names = (f"step-{number + 1:04d}.nc" for number in range(len(path)))
            self._files = [place.folder / name for name in names]
            self._note = place.folder / "latest.nc"
            # The checksum of the problem identifies the run of a state; files hold numbers only.
            self._mark = {"problem": np.frombuffer(bytes.fromhex(place.problem), np.uint8)}

    def __bool__(self) -> bool:
        """Whether checkpoints are saved."""
        return bool(self._files)

    def is_full(self, number: int, every: bool) -> bool:
        """Return whether to save the complete state after a load; ``every`` requires all."""
        return bool(self) and (every or not self._travels or number == len(self._files) - 1)

    def latest(self) -> tuple[int, Checkpoint | None]:
        """Return the number of completed loads, and the checkpoint of the last one."""
        done = self._done()
        noted = self._read_note(done)
        if noted is not None:
            return noted
        if not done:
            return 0, None
        file = self._files[done - 1]
        checkpoint = self._read_checkpoint(
            file, lambda: Checkpoint.from_result(*archive.load_step(file))
        )
        if checkpoint.result is not None:
            self._problem.check_same(str(file), checkpoint.result)
        return done, self._check_run(checkpoint, file, done)

    def _done(self) -> int:
        """Return the number of loads up to the last complete state."""
        there = [file.exists() for file in self._files]
        if self._travels:
            return max((n for n, result in enumerate(there, 1) if result), default=0)
        return [*there, False].index(False)

    def _read_note(self, done: int) -> tuple[int, Checkpoint] | None:
        """Return the intermediate checkpoint, if it is beyond a number of completed loads."""
        if self._note is None or not self._note.exists():
            return None
        file = self._note
        checkpoint = self._read_checkpoint(file, lambda: read_checkpoint(file))
        number = len(checkpoint.carried["path"])
        if not done < number <= len(self._path):
            return None
        return number, self._check_run(checkpoint, file, number)

    def _read_checkpoint(self, file: Path, read: Callable[[], Checkpoint]) -> Checkpoint:
        """Return the checkpoint in a file, or raise `FormatError` if it is of no run."""
        try:
            checkpoint = read()
        except FormatError as error:
            raise FormatError(*error.parts, f"; remove {file} to solve it again") from None
        if not {"path", "problem"} <= checkpoint.carried.keys():
            raise FormatError(f"{file} is no step of a run; remove it to solve it again")
        return checkpoint

    def _check_run(self, checkpoint: Checkpoint, file: Path, number: int) -> Checkpoint:
        """Return a checkpoint without its marks, or raise an error if it is of another run."""
        carried = dict(checkpoint.carried)
        requested, problem = carried.pop("path"), carried.pop("problem")
        if not np.array_equal(requested, self._rows(number)):
            raise OtherRunError(
                f"{file.parent} holds another run: loads differ; give another folder, or remove "
                "this one to start again",
                argument="folder",
            )
        if problem.tolist() != self._mark["problem"].tolist():
            raise FormatError(f"{file} is a step of another run; remove it to solve it again")
        return replace(checkpoint, carried=carried)

    def states(self, count: int) -> Iterator[tuple[int, ElastoplasticResult]]:
        """Yield number and state of the first loads whose complete state is saved."""
        for number, file in enumerate(self._files[:count], 1):
            if file.exists():
                yield number, archive.load_step(file)[0]

    def _rows(self, count: int) -> Array:
        """Return the first points of the path as rows of numbers."""
        path = self._path[:count]
        return np.array([(p.load, *p.offset, p.friction, p.direction) for p in path])

    def save(self, number: int, result: ElastoplasticResult, carried: dict[str, Array]) -> None:
        """Write the state after a load, and the arrays carried to the next load."""
        file, held = self._files[number], carried | self._run_attributes(number)
        self._write(file, lambda: archive.save_elastoplastic(result, file, held))
        if self._note is not None:
            self._note.unlink(missing_ok=True)

    def note(self, number: int, checkpoint: Checkpoint) -> None:
        """Replace the intermediate checkpoint."""
        file = self._note
        if file is not None:
            held = replace(
                checkpoint, carried={**checkpoint.carried, **self._run_attributes(number)}
            )
            self._write(file, lambda: write_checkpoint(held, file))

    def _run_attributes(self, number: int) -> dict[str, Array]:
        return self._mark | {"path": self._rows(number + 1)}

    def _write(self, file: Path, write: Callable[[], None]) -> None:
        try:
            write()
        except OSError as error:
            reason = error.strerror or " ".join(str(error).split())
            raise InputError(
                f"{file} cannot be written ({reason}); earlier loads are saved"
            ) from None


def run_record(
    problem: ElastoplasticProblem,
    start: ElastoplasticResult | None,
    volume: list[float],
    automatic: bool,
) -> dict[str, Any]:
    """Return the record of a run: all inputs on which its states depend."""
    described = problem.pair.record()
    described |= {
        "layers": checkpoints.digest_arrays(volume),
        "tolerance": float(problem.tolerance),
        "max_iterations": int(problem.max_iterations),
        "precision": problem.precision,
        "start": None,
    }
    if start is not None:
        layers = [strain for body in start.bodies for strain in body.plastic_strain]
        flowed = [layer for body in start.bodies for layer in body.accumulated]
        described["start"] = checkpoints.digest_arrays(start.solution.pressure, *layers, *flowed)
    if automatic:
        described["increments"] = "auto"
    return described
