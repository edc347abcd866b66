"""Maps as matrices of numbers, and the summary of a result as JSON.

`save_csv`: Lines that start with # form a header with quantity, unit and pixel, from which
`read_surface` reads unit and size of heights. Numbers are written exactly; "nan" is a missing
point, and masks are 0 and 1. A profile has two columns, the position [m] first.
"""

from __future__ import annotations

import math
import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.files import atomic_write, require_suffix, to_json, write_atomically
from roughcontact.contact.result import ContactResult
from roughcontact.elastoplastic.volume_result import ElastoplasticResult
from roughcontact.errors import input_error
from roughcontact.formats.matrices import TEXT_MARK
from roughcontact.surface.surface import Surface

Result = ContactResult | ElastoplasticResult

UNITS = {
    "height": "m",
    "counter_height": "m",
    "initial_gap": "m",
    "pressure": "Pa",
    "gap": "m",
    "contact": "1",
    "saturated": "1",
    "residual_indentation": "m",
    "ceiling": "Pa",
    "residual_displacement": "m",
}
"""Maps that a result may have, with their units."""

# Maps that only one of the two models has.
_CEILING_ONLY = {"saturated", "residual_indentation", "ceiling"}
_VOLUME_ONLY = {"residual_displacement"}

# Constants of a body in the summary of a result.
_BODY = ("young", "poisson", "yield_strength", "hardness")


def surface_of(source: Surface | Result) -> Surface:
    """Return the map itself, or the map of the rough body of a result."""
    if isinstance(source, ElastoplasticResult):
        return source.solution.surface
    return source if isinstance(source, Surface) else source.surface


def map_names(source: Surface | Result) -> list[str]:
    """Return the names of the available maps."""
    if isinstance(source, Surface):
        return ["height"]
    if isinstance(source, ElastoplasticResult):
        pressed, absent = source.solution, set(_CEILING_ONLY)
    else:
        pressed, absent = source, set(_VOLUME_ONLY)
    if pressed.counter_surface is None:
        absent.add("counter_height")
    if not isinstance(pressed.ceiling, np.ndarray):
        absent.add("ceiling")
    return [name for name in UNITS if name not in absent]


def field_values(source: Surface | Result, name: str) -> NDArray[Any]:
    """Return one of the maps of `map_names`, in the unit of `UNITS`."""
    if isinstance(source, Surface):
        return source.heights
    if isinstance(source, ElastoplasticResult):
        if name in _VOLUME_ONLY:
            return source.residual_displacement
        return field_values(source.solution, name)
    if name == "height":
        return source.surface.heights
    if name == "counter_height" and source.counter_surface is not None:
        return source.counter_surface.heights
    return getattr(source, name)


def save_npz(surface: Surface, path: str | os.PathLike[str]) -> None:
    """Write a height map to a NumPy archive."""
    require_suffix(path, ".npz")
    with atomic_write(path) as stream:
        np.savez(stream, heights=surface.heights, pixel=np.array(surface.pixel), unit=np.array("m"))


def save_csv(
    source: Surface | Result, path: str | os.PathLike[str], field: str | None = None
) -> None:
    """Write one map as a matrix of numbers, one line per row of the map."""
    require_suffix(path, ".csv")
    if field is None:
        field = "height" if isinstance(source, Surface) else "pressure"
    known = map_names(source)
    if field not in known:
        raise input_error("field", field, f"must be one of {', '.join(known)}")
    (dy, dx), values = surface_of(source).pixel, field_values(source, field)
    if values.dtype == np.bool_:
        values = values.astype(np.uint8)
    head = (
        f"{TEXT_MARK}\n"
        f"# quantity: {field}\n"
        f"# unit: {UNITS[field]}\n"
        f"# pixel_y: {dy!r} m\n"
        f"# pixel_x: {dx!r} m\n"
        f"# {values.shape[0]} rows along y from the smallest y on, {values.shape[1]} columns "
        "along x; nan where missing\n"
    )
    if surface_of(source).is_profile:
        _save_columns(values[0], dx, f"{field} [{UNITS[field]}]", path)
        return
    with atomic_write(path) as stream:
        stream.write(head.encode("utf-8"))
        for row in values:
            stream.write((",".join(map(repr, row.tolist())) + "\n").encode("ascii"))


def _save_columns(
    values: NDArray[Any], spacing: float, name: str, path: str | os.PathLike[str]
) -> None:
    """Write the values of a profile at each of its points."""
    with atomic_write(path) as stream:
        stream.write(f"# x [m],{name}\n".encode())
        for number, value in enumerate(values.tolist()):
            stream.write(f"{(number + 0.5) * spacing!r},{value!r}\n".encode("ascii"))


def save_json(result: Result, path: str | os.PathLike[str]) -> None:
    """Write the summary of a result, see `result_record`, as JSON in SI units."""
    require_suffix(path, ".json")
    write_atomically(path, to_json(result_record(result)) + "\n")


def result_record(result: Result) -> dict[str, Any]:
    """Return the summary of a result with its bodies."""
    if isinstance(result, ElastoplasticResult):
        text = result.summary()
        # The contact without its volume has no plastic strain.
        own = {name: text[name] for name in ("status", "regime", "warnings", "cautions")}
        return {
            **result_record(result.solution),
            **own,
            "converged": result.converged,
            "volume": text,
        }
    bodies = {"material": result.material, "counter_material": result.counter_material}
    other = result.counter_surface
    return {
        **result.summary(),
        "converged": result.converged,
        "precision": result.precision,
        **{
            name: {"rigid": math.isinf(body.young), **{key: getattr(body, key) for key in _BODY}}
            for name, body in bodies.items()
        },
        "counter_source": None if other is None else other.provenance.source,
        "counter_preparation": None if other is None else list(other.provenance.steps),
    }
