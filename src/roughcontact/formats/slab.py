"""Reading of maps by several ranks, each its rows of the file."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools import netcdf
from roughcontact._tools.arguments import validate_arguments
from roughcontact._tools.ranks import Ranks
from roughcontact.contact.share import Slab, slab_rows
from roughcontact.errors import ArgumentRef, FormatError, InputError, RoughcontactError
from roughcontact.formats import matrices
from roughcontact.formats.matrices import choose_array
from roughcontact.formats.no_data import NONE, describe_codes, mark_missing
from roughcontact.formats.source import (
    ReadOptions,
    check_lengths,
    one_line,
    open_existing,
    pixel_of,
    refuse_unit,
    resolve_pixel,
    unit_in_meters,
)
from roughcontact.halfspace.distributed import SlabSums
from roughcontact.surface.provenance import Operation, Provenance
from roughcontact.units import Quantities

FORMATS = {".npy": "npy", ".h5": "hdf5", ".hdf5": "hdf5", ".nc": "netcdf"}
"""Formats whose rows can be read separately, by suffix of the file."""


class _Found(NamedTuple):
    """Rows of a map on this rank, and properties of the whole map in the file."""

    values: NDArray[Any]
    shape: tuple[int, int]
    metre: float
    pixel: tuple[float, float]
    format: str
    kind: str


@validate_arguments
def read_slab(
    path: str | os.PathLike[str],
    ranks: Any,
    channel: str | int | None = None,
    unit: str | None = None,
    size: Quantities | str | None = None,
    override_size: bool = False,
    no_data: float | str | None = None,
    mask_missing: bool = False,
) -> Slab:
    """Read the rows of this rank of a map of heights; all ranks call it.

    Parameters
    ----------
    path : str or path
        Matrix as ``.npy`` or ``.h5``, or map as NetCDF of this package, ``.nc``; readable by all
        ranks.
    ranks : Ranks or mpi4py communicator
        Those that will hold the map.
    channel, unit, size, override_size, no_data
        As in `roughcontact.read_surface`.
    mask_missing : bool
        Whether missing points are accepted as points without contact.

    Returns
    -------
    Slab
        The rows of this rank.

    Raises
    ------
    FormatError, InputError
        As in `roughcontact.read_surface`, on all ranks.

    Notes
    -----
    No rank reads the whole file, so checksums of its maps are not verified.
    """
    ranks = ranks if isinstance(ranks, Ranks) else Ranks(ranks)
    requested = ReadOptions(channel, unit, size, override_size, no_data)
    result = ranks.run_on_all(lambda: _rows(Path(path), ranks, requested))
    heights = np.array(result.values, np.float64, order="C")
    heights *= result.metre
    sums = SlabSums(ranks)
    no_data = NONE if requested.no_data is None and result.format == "netcdf" else requested.no_data
    heights, marked = mark_missing(Path(path).name, heights, result.metre, no_data, sums)
    slab = Slab(heights, result.shape, result.pixel, ranks, holes_masked=mask_missing)
    about = _about(Path(path).name, requested, result, slab, describe_codes(marked))
    slab = Slab(slab.heights, slab.shape, slab.pixel, ranks, about, mask_missing)
    finite = slab.heights[np.isfinite(slab.heights)]
    lowest = slab.sums.smallest(finite)
    check_lengths(Path(path), slab.size, slab.pixel, (lowest, slab.highest))
    return slab


def _about(
    name: str, requested: ReadOptions, result: _Found, slab: Slab, notes: tuple[str, ...]
) -> Provenance:
    """Return where a map came from and how it was read."""
    specified: dict[str, object] = {
        "path": name,
        "format": None,
        "channel": requested.channel,
        "unit": requested.unit,
        "size": requested.size,
    }
    if requested.override_size:
        specified["override_size"] = True
    if requested.no_data is not None:
        specified["no_data"] = requested.no_data
    read = {"format": result.format, "size": slab.size, "notes": notes, "unit": result.metre}
    masked = (Operation("masked", found={"missing": slab.missing}),) if slab.missing else ()
    about = Provenance(name, f"{result.kind}, rows by rank")
    return replace(about, origin=Operation("read_surface", specified, read), operations=masked)


def _rows(path: Path, ranks: Ranks, requested: ReadOptions) -> _Found:
    kind = FORMATS.get(path.suffix.lower())
    if kind is None:
        raise InputError(
            f"{path.name}: ranks read their own rows of {', '.join(FORMATS)}; save the map as one "
            "of these first, with surface.save or numpy.save",
            argument="path",
        )
    with open_existing(path) as file:
        if kind == "npy":
            return _open_npy(file, ranks, requested)
        try:
            return (_open_hdf5 if kind == "hdf5" else _open_netcdf)(file, ranks, requested)
        except RoughcontactError:
            raise
        # h5py and xarray raise OSError, KeyError, ValueError and others on damaged files.
        except Exception as error:
            raise FormatError(
                f"{path.name} cannot be read ({one_line(error)}); check that the file is complete"
            ) from None


def _own(shape: tuple[int, ...], path: Path, ranks: Ranks) -> tuple[slice, tuple[int, int]]:
    """Return the rows of this rank, and the shape of the map."""
    if len(shape) != 2 or min(shape) < 2:
        raise FormatError(f"{path.name} holds no map of at least 2 × 2 points, but {shape}")
    whole = shape[0], shape[1]
    return slab_rows(whole, ranks), whole


def _open_npy(path: Path, ranks: Ranks, requested: ReadOptions) -> _Found:
    if requested.channel is not None:
        raise InputError(
            f"{path.name} has no channels; leave out ", ArgumentRef("channel", requested.channel)
        )
    arrays = matrices.open_arrays(path, "npy")
    head = arrays.heads[""]
    if head.dtype.kind not in "fiu":
        raise FormatError(f"{path.name} holds {head.dtype}, not real numbers")
    rows, shape = _own(head.shape, path, ranks)
    metre = unit_in_meters(path, requested.unit)
    pixel = pixel_of(requested.size, shape, path.name)
    return _Found(arrays.load_array("")[rows], shape, metre, pixel, "npy", "matrix (npy)")


def _open_hdf5(path: Path, ranks: Ranks, requested: ReadOptions) -> _Found:
    import h5py

    result = matrices.channels(path, "hdf5")
    listed = [entry.name for entry in result]
    channel = result[listed.index(choose_array(path, listed, requested.channel))]
    rows, shape = _own(channel.shape, path, ranks)
    if channel.unit:
        refuse_unit(path, requested)
    metre = unit_in_meters(path, channel.unit or requested.unit)
    pixel = pixel_of(requested.size, shape, path.name)
    with h5py.File(path, "r") as file:
        return _Found(file[channel.name][rows], shape, metre, pixel, "hdf5", "matrix (hdf5)")


def _open_netcdf(path: Path, ranks: Ranks, requested: ReadOptions) -> _Found:
    refuse_unit(path, requested)
    with netcdf.open_dataset(path) as dataset:
        height = dataset["height"]
        if height.dims != ("y", "x") or height.attrs.get("units") != "m":
            raise FormatError(f"{path.name} has no variable 'height' [m] over (y, x)")
        rows, shape = _own(height.shape, path, ranks)
        stated = float(dataset.attrs["pixel_y"]), float(dataset.attrs["pixel_x"])
        pixel = resolve_pixel(path, stated, shape, requested)
        return _Found(height[rows].values, shape, 1.0, pixel, "netcdf", "roughcontact NetCDF")
