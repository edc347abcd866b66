"""NetCDF files: written whole or not at all, opened with an error and in silence if damaged."""

from __future__ import annotations

import io
import mmap
import os
import struct
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughcontact import files

if TYPE_CHECKING:
    import xarray


def write(
    dataset: xarray.Dataset,
    path: str | os.PathLike[str],
    packed: Mapping[str, Mapping[str, Any]] | None = None,
) -> None:
    """Write a dataset to a NetCDF file: the one door for all that this program writes.

    Parameters
    ----------
    dataset : xarray.Dataset
        What the file shall hold.
    path : str or path
        File to write; an old one is replaced when the new one is complete.
    packed : mapping, optional
        How variables are compressed, by name, as xarray's ``encoding``.

    Raises
    ------
    InputError
        If the suffix is not ``.nc``.
    OSError
        If the file cannot be written; an old file survives.

    Notes
    -----
    HDF5 does not get over a full disk: it fails again when something is closed, and ends the
    process with a segmentation fault. So it writes to memory, as many bytes as the file will
    have; those of a contact are fewer than `solve` needed on the way.
    """
    files.require_suffix(path, ".nc")
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    content = io.BytesIO()
    with h5netcdf.File(content, "w") as file:
        dataset.dump_to_store(H5NetCDFStore(file), encoding=packed or {})
    files.write(path, content.getbuffer())


@contextmanager
def opened(path: Path) -> Iterator[xarray.Dataset]:
    """Give the dataset in a NetCDF file.

    Parameters
    ----------
    path : Path
        The file.

    Yields
    ------
    xarray.Dataset
        Read when it is looked at; read what is wanted inside the block.

    Raises
    ------
    ValueError
        If the file's collections of texts and references are damaged.
    Exception
        Of almost any kind for other damage: OSError, KeyError, RuntimeError and more.
    """
    check_heaps(path)
    import h5py
    import xarray

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        # h5netcdf looks this up first. Where that fails it leaves an unfinished object, which
        # writes a traceback to standard error when it is collected.
        with h5py.File(path, "r") as file:
            file.attrs.get("_nc3_strict")
        with xarray.open_dataset(path, engine="h5netcdf") as dataset:
            yield dataset


def check_heaps(path: Path) -> None:
    """Refuse an HDF5 file with a global heap that HDF5 would read for ever.

    Parameters
    ----------
    path : Path
        The file.

    Raises
    ------
    ValueError
        If a heap is damaged in that way.

    Notes
    -----
    A heap is ``GCOL``, version, its size, and objects: index, references, size, content. Index 0
    is the free space, which reaches to the end. HDF5 (2.0.0 among others) steps over it by its
    size, and a size of 0 lets it stand still.

    References
    ----------
    HDF5 File Format Specification Version 3.0, section III.E
    """
    with path.open("rb") as stream:
        stream.seek(0, 2)
        if stream.tell() == 0:
            return
        with mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as content:
            start = content.find(b"GCOL")
            while start >= 0:
                _check_heap(content, start)
                start = content.find(b"GCOL", start + 4)


def _check_heap(content: mmap.mmap, start: int) -> None:
    if start + 16 > len(content) or content[start + 4] != 1:
        return
    (size,) = struct.unpack_from("<Q", content, start + 8)
    place, end = start + 16, min(start + size, len(content))
    while place + 16 <= end:
        index, _, _, size = struct.unpack_from("<HHIQ", content, place)
        if index == 0:
            if place + size != end:
                raise ValueError(f"the free space of a heap at byte {start} has a wrong size")
            return
        place += 16 + (size + 7) // 8 * 8
