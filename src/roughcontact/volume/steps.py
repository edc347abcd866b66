"""States of a run in a folder, so that the same call goes on where it was stopped."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from roughcontact.contact import resume
from roughcontact.errors import FormatError, InputError
from roughcontact.volume import archive
from roughcontact.volume.problem import Problem
from roughcontact.volume.result import ElastoplasticResult

Array = NDArray[Any]


def files(
    folder: str | os.PathLike[str],
    count: int,
    problem: Problem,
    start: ElastoplasticResult | None,
    volume: list[float],
) -> list[Path]:
    """Return the files of all loads, after a look at what stands in the folder.

    The volume is the margin, whether it may become deeper, and the thickness of its layers.
    """
    described = resume.contact(
        problem.surface, problem.counter_surface, problem.material, problem.counter_material
    )
    described |= {
        "boundary": problem.boundary,
        "layers": resume.digest(volume),
        "tolerance": float(problem.tolerance),
        "max_iterations": int(problem.max_iterations),
        "precision": problem.precision,
        "start": None,
    }
    if start is not None:
        layers = [strain for body in start.bodies for strain in body.plastic_strain]
        flowed = [layer for body in start.bodies for layer in body.accumulated]
        described["start"] = resume.digest(start.contact.pressure, *layers, *flowed)
    place = resume.claim(folder, described, kind="run", record="volume.json", pattern="step-*.nc")
    return [place / f"step-{number:04d}.nc" for number in range(1, count + 1)]


def kept(
    path: Path, loads: list[float], problem: Problem
) -> tuple[ElastoplasticResult, dict[str, Array]]:
    """Return the state after some loads, and what the loop carries on from it."""
    try:
        result, carried = archive.load_step(path)
        asked = carried.pop("loads")
    except FormatError as error:
        raise FormatError(f"{error}; remove {path} to solve it again") from None
    except KeyError:
        raise FormatError(f"{path} is no step of a run; remove it to solve it again") from None
    if asked.tolist() != loads:
        raise InputError(
            f"folder {path.parent} holds another run: loads differ; give another folder, or remove "
            "this one to start again"
        )
    problem.check_same(str(path), result)
    return result, carried


def save(result: ElastoplasticResult, path: Path, carried: Mapping[str, Array]) -> None:
    """Write the state after a load, and what the loop carries on from it."""
    try:
        archive.save_elastoplastic(result, path, carried)
    except OSError as error:
        reason = error.strerror or " ".join(str(error).split())
        raise InputError(
            f"{path} cannot be written ({reason}); the loads before it are kept"
        ) from None
