"""Height maps in NetCDF of this package, and in classic NetCDF of SurfaceTopography."""

from __future__ import annotations

import io
import math
import os
from pathlib import Path

import numpy as np

from roughcontact._tools import memory, netcdf
from roughcontact._tools.arrays import Array
from roughcontact.errors import FormatError
from roughcontact.formats.source import (
    BoundedStream,
    Channel,
    ReadOptions,
    damage_as_error,
    make_surface,
    refuse_unit,
    unit_in_meters,
)
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface

SIGNATURE = b"CDF"
"""First bytes of classic NetCDF files."""

# Memory for reading, in bytes per point.
_BYTES_PER_POINT = 40


def _read_classic(path: Path, requested: ReadOptions) -> Surface:
    """Return the map in the variable ``heights`` of a classic NetCDF file."""
    result, unit = _read_classic_arrays(path, requested)
    if unit:
        refuse_unit(path, requested)
    metre = unit_in_meters(path, unit or requested.unit)
    values = result["heights"].values.astype(np.float64)
    if "mask" in result:
        values[result["mask"].values != 0] = np.nan
    nx, ny = values.shape
    stated = None
    if all("length" in result[axis].attrs for axis in "yx"):
        along_y, along_x = (float(result[axis].attrs["length"]) * metre for axis in "yx")
        stated = along_y / ny, along_x / nx
    about = Provenance(path.name, "SurfaceTopography NetCDF")
    # The first index is along x.
    return make_surface(path, values.T, metre, requested, about, stated)


def _read_classic_arrays(path: Path, requested: ReadOptions) -> tuple[netcdf.Dataset, str]:
    """Return the arrays of a file, and the unit of lengths; empty if the file has none."""
    memory.require_size(path.name, path.stat().st_size)
    result = netcdf.Dataset()
    advice = (
        "check that the file is complete: expected a variable 'heights' over (x, y), as "
        "SurfaceTopography writes it"
    )
    with damage_as_error(path, "classic NetCDF", advice), np.errstate(all="ignore"):
        from scipy.io import netcdf_file

        # A damaged header may announce terabytes, but the number of bytes of the file is a limit.
        with BoundedStream(io.FileIO(path)) as stream, netcdf_file(stream, mmap=False) as file:
            for name, variable in file.variables.items():
                described = {
                    key: text.decode("utf-8") if isinstance(text, bytes) else text
                    for key, text in variable._attributes.items()  # type: ignore[attr-defined]
                }
                result[name] = (variable.dimensions, variable.data, described)
        dims, heights, _ = result["heights"]
        if dims != ("x", "y"):
            raise ValueError(f"'heights' over ({', '.join(map(str, dims))}), no map")
        memory.require_points(path.name, heights.shape[::-1], _BYTES_PER_POINT)
        requested.check_shape(heights.shape[::-1])
        units = {str(result[name].attrs.get("unit", "")) for name in ("heights", "x", "y")} - {""}
        if len(units) > 1:
            raise ValueError(f"units differ: {', '.join(sorted(units))}")
    return result, units.pop() if units else ""


# Memory for reading, in bytes per point.
_NETCDF_EACH = 20


def save(surface: Surface, path: str | os.PathLike[str]) -> None:
    """Write a height map to a NetCDF file: heights, pixel and provenance."""
    # Imported here, as only writing needs the archive of contacts.
    from roughcontact.contact.archive import surface_to_dataset

    netcdf.write(surface_to_dataset(surface), path)


def read_netcdf(path: Path, name: str, requested: ReadOptions) -> Surface:
    """Return the map in a NetCDF file: ``height`` [m] over ``y`` and ``x`` [m]."""
    if _is_classic(path):
        return _read_classic(path, requested)
    refuse_unit(path, requested)
    return _map(path, requested)


def channels(path: Path, name: str) -> tuple[Channel, ...]:
    """Return the heights as the only channel."""
    if _is_classic(path):
        result, unit = _read_classic_arrays(path, ReadOptions())
        return (Channel("heights", unit, True, result["heights"].values.shape[::-1]),)
    return (Channel("height", "m", True, _map(path, ReadOptions()).shape),)


def _is_classic(path: Path) -> bool:
    with path.open("rb") as stream:
        return stream.read(3) == SIGNATURE


def _map(path: Path, requested: ReadOptions) -> Surface:
    expected = "expected a NetCDF file with a variable 'height' [m] over (y, x)"
    with damage_as_error(path, "NetCDF", expected), netcdf.open_dataset(path) as dataset:
        dims, stored, described = dataset["height"]
        unit = described.get("units")
        if dims != ("y", "x") or unit != "m" or np.dtype(stored.dtype).kind not in "fiu":
            raise FormatError(
                f"{path.name} has 'height' over {dims} with units {unit!r}; {expected}"
            )
        memory.require_points(path.name, stored.shape, _NETCDF_EACH)
        requested.check_shape(stored.shape)
        seen = [name for name in ("height", "y", "x") if name in dataset]
        dataset.load(seen)
        values = dataset["height"].values
        attributes = dataset.attrs
        coordinates = [np.asarray(dataset[name].values, dtype=float) for name in seen[1:]]
        changed = netcdf.changed_names(dataset, seen)
    if changed:
        raise netcdf.changed_file_error(path.name, changed)
    try:
        if "pixel_y" in attributes and "pixel_x" in attributes:
            pixel = float(attributes["pixel_y"]), float(attributes["pixel_x"])
        else:
            pixel = _spacing(coordinates[0]), _spacing(coordinates[1])
    except (IndexError, TypeError, ValueError):
        raise FormatError(
            f"{path.name} has neither attributes pixel_y and pixel_x [m] nor evenly spaced "
            f"coordinates y and x; {expected}"
        ) from None
    about = Provenance(path.name, "roughcontact NetCDF")
    return make_surface(path, values, 1.0, requested, about, pixel)


def _spacing(centres: Array) -> float:
    # Damaged numbers overflow, and an axis of one point has no steps.
    with np.errstate(all="ignore"):
        steps = np.diff(centres)
        mean = float(np.mean(steps)) if steps.size else math.nan
        if not np.allclose(steps, mean, rtol=1e-6, atol=0.0) or math.isnan(mean):
            raise ValueError("coordinates are not evenly spaced")
    return abs(mean)
