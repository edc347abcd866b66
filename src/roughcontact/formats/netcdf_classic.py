"""Height maps in classic NetCDF, as SurfaceTopography writes them.

``heights`` over (x, y), both with the attribute ``length``, and ``unit`` with each; a variable
``mask`` marks what is missing.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from roughcontact import limits
from roughcontact.errors import FormatError, RoughcontactError
from roughcontact.formats.scale import asked_pixel, in_metres, refuse_unit, unit_in_metres
from roughcontact.formats.source import Asked, Channel, one_line, surface_of
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface

if TYPE_CHECKING:
    import xarray

SIGNATURE = b"CDF"
"""First bytes of such a file."""

# Bytes that reading takes a point.
_EACH = 40


def read(path: Path, asked: Asked) -> Surface:
    """Return the variable ``heights`` of a classic NetCDF file."""
    found, unit = _read(path, asked)
    if unit:
        refuse_unit(path, asked)
    metre = unit_in_metres(path, unit or asked.unit)
    values = found["heights"].values.astype(np.float64)
    if "mask" in found:
        values[found["mask"].values != 0] = np.nan
    ny, nx = shape = values.shape[::-1]
    stated = None
    if all("length" in found[axis].attrs for axis in "yx"):
        along_y, along_x = (float(found[axis].attrs["length"]) * metre for axis in "yx")
        stated = along_y / ny, along_x / nx
    pixel = asked_pixel(path, stated, shape, asked)
    about = Provenance(path.name, "SurfaceTopography NetCDF")
    # Its first index runs along x.
    return surface_of(path, in_metres(values.T, metre), pixel, about, metre, stated)


def channels(path: Path) -> tuple[Channel, ...]:
    """Return the heights as the only channel."""
    found, unit = _read(path, Asked())
    return (Channel("heights", unit, True, found["heights"].shape[::-1]),)


def _read(path: Path, asked: Asked) -> tuple[xarray.Dataset, str]:
    """Return heights and mask, and the unit of lengths; empty if the file gives none."""
    limits.require_size(path.name, path.stat().st_size)
    try:
        import xarray

        content = io.BytesIO(path.read_bytes())
        with (
            np.errstate(all="ignore"),
            # Bytes are all that a damaged header can have; of a file it may ask for terabytes.
            xarray.open_dataset(content, engine="scipy", decode_cf=False) as whole,
        ):
            heights = whole["heights"]
            if heights.dims != ("x", "y"):
                raise ValueError(f"'heights' over ({', '.join(map(str, heights.dims))}), no map")
            limits.require_points(path.name, heights.shape[::-1], _EACH)
            asked.expect(heights.shape[::-1])
            found = whole[[name for name in ("heights", "mask") if name in whole]].load()
        units = {str(found[name].attrs.get("unit", "")) for name in ("heights", "x", "y")} - {""}
        if len(units) > 1:
            raise ValueError(f"units differ: {', '.join(sorted(units))}")
        return found, units.pop() if units else ""
    except RoughcontactError:
        raise
    # A damaged header makes it fail with anything.
    except Exception as error:
        raise FormatError(
            f"{path.name} cannot be read as classic NetCDF ({one_line(error)}); check that the "
            "file is complete: expected a variable 'heights' over (x, y), as SurfaceTopography "
            "writes it"
        ) from None
