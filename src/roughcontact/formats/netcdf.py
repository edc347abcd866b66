"""Height maps in NetCDF, as this program writes them; the classic kind is SurfaceTopography's."""

from __future__ import annotations

import math
import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from roughcontact import limits, netcdf
from roughcontact.errors import FormatError, RoughcontactError
from roughcontact.formats import netcdf_classic
from roughcontact.formats.scale import asked_pixel, refuse_unit
from roughcontact.formats.source import Asked, Channel, one_line, surface_of
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface

Array = NDArray[np.float64]

# Bytes that reading takes a point.
_EACH = 20


def save(surface: Surface, path: str | os.PathLike[str]) -> None:
    """Write a height map to a NetCDF file: heights, pixel and provenance.

    Parameters
    ----------
    surface : Surface
        The map.
    path : str or path
        File to write; it must end in ``.nc``.

    Raises
    ------
    InputError
        If the suffix is another.
    OSError
        If the file cannot be written; an old file survives.
    """
    # What keeps contacts is loaded by who writes one of their surfaces.
    from roughcontact.contact.archive import surface_to_dataset

    netcdf.write(surface_to_dataset(surface), path)


def read(path: Path, name: str, asked: Asked) -> Surface:
    """Return the variable ``height`` [m] over ``y`` and ``x`` [m] of a NetCDF file."""
    if _is_classic(path):
        return netcdf_classic.read(path, asked)
    refuse_unit(path, asked)
    return _map(path, asked)


def channels(path: Path, name: str) -> tuple[Channel, ...]:
    """Return the heights as the only channel."""
    if _is_classic(path):
        return netcdf_classic.channels(path)
    return (Channel("height", "m", True, _map(path, Asked()).shape),)


def _is_classic(path: Path) -> bool:
    with path.open("rb") as stream:
        return stream.read(3) == netcdf_classic.SIGNATURE


def _map(path: Path, asked: Asked) -> Surface:
    expected = "expected a NetCDF file with a variable 'height' [m] over (y, x)"
    try:
        with netcdf.opened(path) as dataset:
            height = dataset["height"]
            dimensions, unit = height.dims, height.attrs.get("units")
            if dimensions != ("y", "x") or unit != "m" or height.dtype.kind not in "fiu":
                raise FormatError(
                    f"{path.name} has 'height' over {dimensions} with units {unit!r}; {expected}"
                )
            limits.require_points(path.name, height.shape, _EACH)
            asked.expect(height.shape)
            values = np.asarray(height.values)
            attributes = dict(dataset.attrs)
            coordinates = [
                np.asarray(dataset[name].values, dtype=float)
                for name in ("y", "x")
                if name in dataset.coords
            ]
            seen = [name for name in ("height", "y", "x") if name in dataset.variables]
            changed = netcdf.mismatches(dataset, seen)
    except RoughcontactError:
        raise
    # h5py and xarray fail on damaged files with OSError, KeyError, ValueError and more.
    except Exception as error:
        raise FormatError(f"{path.name} cannot be read ({one_line(error)}); {expected}") from None
    if changed:
        raise netcdf.altered(path.name, changed)
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
    chosen = asked_pixel(path, pixel, values.shape, asked)
    about = Provenance(path.name, "roughcontact NetCDF")
    return surface_of(path, values, chosen, about, stated=pixel)


def _spacing(centres: Array) -> float:
    # Damaged numbers overflow, and an axis of one point has no steps.
    with np.errstate(all="ignore"):
        steps = np.diff(centres)
        mean = float(np.mean(steps)) if steps.size else math.nan
        if not np.allclose(steps, mean, rtol=1e-6, atol=0.0) or math.isnan(mean):
            raise ValueError("coordinates are not evenly spaced")
    return abs(mean)
