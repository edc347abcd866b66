"""Height maps in classic NetCDF, as SurfaceTopography writes them.

``heights`` over (x, y), both with the attribute ``length``, and ``unit`` with each; a variable
``mask`` marks what is missing.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from roughcontact import limits
from roughcontact.errors import FormatError, RoughcontactError
from roughcontact.formats.binary import Bounded
from roughcontact.formats.scale import asked_pixel, in_metres, refuse_unit, unit_in_metres
from roughcontact.formats.source import Asked, Channel, one_line, surface_of
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface

SIGNATURE = b"CDF"
"""First bytes of such a file."""

# Bytes that reading takes a point.
_EACH = 40
_EXPECTED = "expected a variable 'heights' over (x, y), as SurfaceTopography writes it"


def read(path: Path, asked: Asked) -> Surface:
    """Return the variable ``heights`` of a classic NetCDF file."""
    with _opened(path) as file:
        found = file.variables
        ny, nx = _shape(path, found)
        asked.expect((ny, nx))
        unit = _unit(found)
        if unit:
            refuse_unit(path, asked)
        metre = unit_in_metres(path, unit or asked.unit)
        values = np.array(found["heights"][:], dtype=np.float64)
        if "mask" in found:
            values[np.asarray(found["mask"][:]) != 0] = np.nan
        sides = [getattr(found.get(axis), "length", None) for axis in "yx"]
    stated = None
    if None not in sides:
        along_y, along_x = (float(side) * metre for side in sides if side is not None)
        stated = along_y / ny, along_x / nx
    pixel = asked_pixel(path, stated, (ny, nx), asked)
    about = Provenance(path.name, "SurfaceTopography NetCDF")
    # Its first index runs along x.
    heights = in_metres(values.T, metre)
    return surface_of(path, heights, pixel, about, metre, stated)


def channels(path: Path) -> tuple[Channel, ...]:
    """Return the heights as the only channel."""
    with _opened(path) as file:
        return (Channel("heights", _unit(file.variables), True, _shape(path, file.variables)),)


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """Give SciPy's reader of a file, with one kind of error."""
    limits.require_size(path.name, path.stat().st_size)
    try:
        from scipy.io import netcdf_file

        with (
            np.errstate(all="ignore"),
            Bounded(io.FileIO(path)) as stream,
            netcdf_file(stream, "r", mmap=False, maskandscale=False) as file,
        ):
            yield file
    except RoughcontactError:
        raise
    # A damaged header makes it fail with anything.
    except Exception as error:
        raise FormatError(
            f"{path.name} cannot be read as classic NetCDF ({one_line(error)}); check that the "
            f"file is complete: {_EXPECTED}"
        ) from None


def _shape(path: Path, found: dict[str, Any]) -> tuple[int, int]:
    """Return the points ``(ny, nx)`` of the heights."""
    if "heights" not in found:
        listed = ", ".join(sorted(found)) or "nothing"
        raise FormatError(f"{path.name} holds {listed}; {_EXPECTED}")
    dimensions, shape = found["heights"].dimensions, found["heights"].shape
    if dimensions != ("x", "y"):
        raise FormatError(
            f"{path.name} has 'heights' over ({', '.join(dimensions)}), no map; {_EXPECTED}"
        )
    nx, ny = shape
    limits.require_points(path.name, (ny, nx), _EACH)
    return ny, nx


def _unit(found: dict[str, Any]) -> str:
    """Return the unit of lengths; empty if the file gives none."""
    units = [getattr(found.get(name), "unit", b"") for name in ("heights", "x", "y")]
    named = {unit.decode("utf-8", "replace") if isinstance(unit, bytes) else str(unit)
             for unit in units} - {""}  # fmt: skip
    if len(named) > 1:
        raise ValueError(f"units differ: {', '.join(sorted(named))}")
    return named.pop() if named else ""
