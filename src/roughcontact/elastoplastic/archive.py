"""Archive of results with plasticity of the volume, and reader of all result files."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools import netcdf
from roughcontact.contact import archive
from roughcontact.contact.archive import Verification, verify_solution
from roughcontact.contact.result import ContactResult
from roughcontact.elastoplastic.volume_result import ElastoplasticResult, Increment, PlasticBody
from roughcontact.errors import FormatError, InsufficientMemoryError

_COMPONENTS = ("zz", "(xx-yy)/2", "xy", "xz", "yz")
_TENSORS = {
    "plastic_strain": ("1", "plastic strain"),
    "stress": ("Pa", "deviator of the stress under load, average over the layer"),
    "residual_stress": ("Pa", "deviator of the stress by the plastic strain alone"),
}
_FIELDS = {
    "accumulated": ("1", "accumulated plastic strain"),
    "mean_stress": ("Pa", "a third of the trace of the stress under load"),
    "mean_residual_stress": ("Pa", "a third of the trace of the stress by plastic strain alone"),
}
_STEPS = {
    "load": "N",
    "approach": "m",
    "contact_area": "m2",
    "max_pressure": "Pa",
    "max_plastic_strain": "1",
    "plastic_volume": "m3",
    "convolutions": "1",
}

# Fields of increments with a counter-surface that moves or slides.
_PLACES = {
    "offset": ("m", "how far the counter-surface has moved along y and x"),
    "friction": ("1", "traction over pressure"),
    "direction": ("degree", "of the traction on the rough body, counter-clockwise from x"),
}

CARRIED = "carried_"


def save_elastoplastic(
    result: ElastoplasticResult,
    path: str | os.PathLike[str],
    carried: Mapping[str, NDArray[Any]] | None = None,
) -> None:
    """Write an elastic-plastic result to a NetCDF file; `load_result` reads it."""
    dataset, packed = to_dataset(result)
    packed |= dict.fromkeys(add_arrays(dataset, carried or {}, CARRIED), netcdf.SHUFFLED)
    netcdf.write(dataset, path, packed)


def add_arrays(
    dataset: netcdf.Dataset, arrays: Mapping[str, NDArray[Any]], prefix: str = ""
) -> list[str]:
    """Add arrays with separate axes to a dataset, and return their names in it."""
    # HDF5 cannot compress empty arrays.
    held = {f"{prefix}{name}": array for name, array in arrays.items() if array.size}
    for name, array in held.items():
        dataset[name] = ([f"{name}_{axis}" for axis in range(array.ndim)], array)
    return list(held)


def to_dataset(result: ElastoplasticResult) -> tuple[netcdf.Dataset, dict[str, Any]]:
    """Return a result as a dataset, and the compression options of its variables."""
    dataset = archive.to_dataset(result.solution)
    text = "displacement of the surface by plastic strain"
    dataset.add("residual_displacement", ("y", "x"), result.residual_displacement, "m", text)
    packed = {"pressure": netcdf.SHUFFLED}
    if result.largest_pressure is not None:
        text = "contact pressure at the largest load of the path"
        dataset.add("largest_pressure", ("y", "x"), result.largest_pressure, "Pa", text)
        packed["largest_pressure"] = netcdf.SHUFFLED
    for name, body in zip(yielding_materials(result.solution), result.bodies, strict=True):
        packed |= _add_body(dataset, name, body)
    dataset["component"] = ("component", list(_COMPONENTS))
    add_increments(dataset, result.increments)
    dataset.attrs |= {
        "elastoplastic_status": str(result.status),
        "elastoplastic_precision": result.precision,
        "elastoplastic_tolerance": result.tolerance,
        "elastoplastic_seconds": result.seconds,
        "elastoplastic_version": result.version,
        "yield_excess": result.yield_excess,
        # The contact alone has no plastic strain: its regime and warnings would be wrong.
        "regime": str(result.regime),
        "warnings": "\n".join(result.warnings),
    }
    return dataset, packed


def _add_body(dataset: netcdf.Dataset, name: str, body: PlasticBody) -> dict[str, Any]:
    """Add the arrays of a body; return compression options."""
    dataset.add(f"{name}_thickness", "layer", body.thickness, "m", "thickness of the layer")
    dataset.attrs["volume_margin"] = body.margin
    packed = {}
    for field, (unit, text) in (_TENSORS | _FIELDS).items():
        axes = ("layer", *["component"] * (field in _TENSORS), "volume_y", "volume_x")
        dataset.add(f"{name}_{field}", axes, getattr(body, field), unit, text)
        packed[f"{name}_{field}"] = netcdf.SHUFFLED
    return packed


def add_increments(dataset: netcdf.Dataset, increments: Sequence[Increment]) -> None:
    """Add the increments of a path to a dataset; `increments_of` reads them."""
    for field, unit in _STEPS.items():
        values = np.array([getattr(step, field) for step in increments])
        dataset[f"increment_{field}"] = ("increment", values, {"units": unit})
    unknown = [math.nan if step.step_error is None else step.step_error for step in increments]
    text = "error by the load steps so far, NaN where not estimated"
    dataset.add("increment_step_error", "increment", np.array(unknown), "1", text)
    if any(step.has_moved for step in increments):
        for field, (unit, text) in _PLACES.items():
            values = np.array([getattr(step, field) for step in increments])
            dims = ("increment", "axis")[: values.ndim]
            dataset.add(f"increment_{field}", dims, values, unit, text)
    counts = [step.iterations for step in increments]
    residuals = [residual for step in increments for residual in step.residuals]
    dataset.add("increment_iterations", "increment", counts, "1", "iterations of the loop")
    text = "residual after each iteration, increment by increment"
    dataset.add("iteration_residual", "iteration", residuals, "1", text)


def load_elastoplastic(path: str | os.PathLike[str]) -> ElastoplasticResult:
    """Read a result that ``ElastoplasticResult.save`` wrote."""
    return load_step(path)[0]


def load_step(path: str | os.PathLike[str]) -> tuple[ElastoplasticResult, dict[str, NDArray[Any]]]:
    """Read a result of `save_elastoplastic`, and the arrays carried to the next load."""
    dataset = archive.open_archive(path)
    with archive.as_format_error(path, "ElastoplasticResult"):
        return from_dataset(dataset), carried_arrays(dataset)


def load_result(
    path: str | os.PathLike[str], dataset: netcdf.Dataset | None = None, *, verify: bool = False
) -> ContactResult | ElastoplasticResult:
    """Read a result of either type from a file."""
    dataset = archive.open_archive(path) if dataset is None else dataset
    is_volume = "elastoplastic_status" in dataset.attrs
    with archive.as_format_error(path, "ElastoplasticResult" if is_volume else "ContactResult"):
        result = from_dataset(dataset) if is_volume else archive.from_dataset(dataset)
    if verify:
        verify_result(result).require(Path(path).name)
    return result


def verify_result(result: ContactResult | ElastoplasticResult) -> Verification:
    """Return the stored and the recomputed values of a result."""
    if isinstance(result, ContactResult):
        return verify_solution(result)
    return verify_solution(result.solution, result.residual_displacement)


def from_dataset(dataset: netcdf.Dataset) -> ElastoplasticResult:
    """Return the result in a dataset of `to_dataset`."""
    pressed = archive.from_dataset(dataset)
    attributes = dataset.attrs
    bodies = []
    for name in yielding_materials(pressed):
        arrays = {
            field: np.array(dataset[f"{name}_{field}"].values)
            for field in ("thickness", *_TENSORS, *_FIELDS)
        }
        body = PlasticBody(
            material=getattr(pressed, name),
            pixel_area=pressed.pixel_area,
            margin=int(attributes["volume_margin"]),
            **arrays,
        )
        bodies.append(body)
    largest = dataset.variables.get("largest_pressure")
    return ElastoplasticResult(
        solution=pressed,
        residual_displacement=np.array(dataset["residual_displacement"].values),
        bodies=tuple(bodies),
        increments=increments_of(dataset),
        yield_excess=float(attributes["yield_excess"]),
        precision=str(attributes["elastoplastic_precision"]),
        tolerance=float(attributes["elastoplastic_tolerance"]),
        status=str(attributes["elastoplastic_status"]),
        seconds=float(attributes["elastoplastic_seconds"]),
        version=str(attributes["elastoplastic_version"]),
        largest_pressure=None if largest is None else np.array(largest.values),
    )


def increments_of(dataset: netcdf.Dataset) -> tuple[Increment, ...]:
    """Return the increments of a path from a dataset."""
    columns = {field: dataset[f"increment_{field}"].values.tolist() for field in _STEPS}
    residuals = iter(dataset["iteration_residual"].values.tolist())
    columns["residuals"] = [
        tuple(islice(residuals, count)) for count in dataset["increment_iterations"].values.tolist()
    ]
    # Files older than the estimate have no step errors.
    if "increment_step_error" in dataset:
        errors = dataset["increment_step_error"].values.tolist()
    else:
        errors = [math.nan] * len(columns["load"])
    if "increment_offset" in dataset:
        columns |= {field: dataset[f"increment_{field}"].values.tolist() for field in _PLACES}
        columns["offset"] = [tuple(way) for way in columns["offset"]]
    columns["step_error"] = [None if math.isnan(error) else error for error in errors]
    rows = zip(*columns.values(), strict=True)
    return tuple(Increment(**dict(zip(columns, row, strict=True))) for row in rows)


def carried_arrays(dataset: netcdf.Dataset) -> dict[str, NDArray[Any]]:
    """Return the arrays that a run carried on to the next load."""
    return {
        name.removeprefix(CARRIED): variable.values
        for name, variable in dataset.variables.items()
        if name.startswith(CARRIED)
    }


def yielding_materials(pressed: ContactResult) -> list[str]:
    """Return the argument names of the yielding materials of a contact."""
    return [name for name in archive.MATERIALS if getattr(pressed, name).yield_strength is not None]


# Checks of result files: checksums, and solutions recomputed from the stored fields.


@dataclass(frozen=True)
class CheckedFile:
    """Result of checking a file."""

    file: str  # Path of the file
    sealed: bool  # Whether the file has checksums that agree
    verification: Verification | None  # Stored and recomputed values
    reason: str  # Reason why the file is invalid, or empty

    def record(self) -> dict[str, Any]:
        """Return the result of the check as JSON values."""
        found = self.verification and asdict(self.verification)
        return {"file": self.file, "sealed": self.sealed, "found": found, "reason": self.reason}


def check_file(path: str | os.PathLike[str]) -> CheckedFile:
    """Check the checksums and the solution of a result file."""
    sealed, answer = False, None
    try:
        result = load_result(path)
        pressed = result if isinstance(result, ContactResult) else result.solution
        answer, sealed = verify_result(result), not pressed.without_checksums
        answer.require(Path(path).name)
    except (FormatError, InsufficientMemoryError) as error:
        return CheckedFile(str(path), sealed, answer, str(error))
    return CheckedFile(str(path), sealed, answer, "")
