"""NetCDF files: sealed by checksums and whole; what is damaged opens with an error."""

from __future__ import annotations

import errno
import io
import math
import os
import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughcontact import checksums, files, hdf5, limits, memory
from roughcontact.errors import FormatError
from roughcontact.ranks import Ranks

if TYPE_CHECKING:
    import xarray

CHECKSUM = "checksum_sha256"
"""Attribute of every variable, and of the file, that holds a checksum."""

# Numbers of a map that are packed together.
_CHUNK = 1 << 18

ATTRIBUTES = "attributes"
"""What `mismatches` calls everything but the numbers: attributes, names and dimensions."""


def write(
    dataset: xarray.Dataset,
    path: str | os.PathLike[str],
    packed: Mapping[str, Mapping[str, Any]] | None = None,
) -> None:
    """Write a dataset to a NetCDF file with checksums: the one door for all that is written.

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
    process with a segmentation fault. So it writes to memory first, as many bytes as the file
    will have; straight to the disk only where they would take more than half of what is free.
    """
    files.require_suffix(path, ".nc")
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    with files.replacing(path) as stream:
        place = io.BytesIO() if 2 * dataset.nbytes < memory.free() else stream
        with h5netcdf.File(place, "w") as file:
            sealed(dataset).dump_to_store(H5NetCDFStore(file), encoding=packed or {})
        if isinstance(place, io.BytesIO):
            stream.write(place.getbuffer())


@dataclass(frozen=True, eq=False)
class Streamed:
    """A map, or a stack of them, that is written in parts, as they come.

    Parameters
    ----------
    name : str
        Of the variable.
    kind : str
        Of its numbers, as NumPy writes it, such as ``"<f8"``.
    shape : tuple of int
        Of the whole, such as ``(ny, nx)``.
    attributes : mapping
        What describes it.
    parts : iterable of ndarray, shape (rows, ...)
        What stands one below the other along the first axis, in its order.
    packed : bool
        Whether it is compressed.
    dims : tuple of str
        Names of the axes.
    """

    name: str
    kind: str
    shape: tuple[int, ...]
    attributes: Mapping[str, Any]
    parts: Iterable[NDArray[Any]] = ()
    packed: bool = False
    dims: tuple[str, ...] = ("y", "x")


def write_streamed(
    frame: xarray.Dataset, maps: Iterable[Streamed], path: str | os.PathLike[str]
) -> None:
    """Write maps that no process holds as a whole to a NetCDF file with checksums.

    Parameters
    ----------
    frame : xarray.Dataset
        All but the maps: axes such as ``(y, x)`` and the attributes.
    maps : iterable of Streamed
        The maps; one after the other is written.
    path : str or path
        File to write; an old one is replaced when the new one is complete.

    Raises
    ------
    InputError
        If the suffix is not ``.nc``.
    OSError
        If the file cannot be written, or the disk has no room for all maps; an old file survives.
    """
    files.require_suffix(path, ".nc")
    import h5netcdf
    import h5py

    maps = list(maps)
    needed = sum(math.prod(one.shape) * np.dtype(one.kind).itemsize for one in maps)
    # A disk that fills up while HDF5 writes would end the process.
    if needed > shutil.disk_usage(Path(path).absolute().parent).free:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
    whole = sealed(frame)
    with files.replacing(path) as stream, h5netcdf.File(stream, "w") as file:
        file.dimensions = dict(whole.sizes)
        for one in maps:
            for axis, size in zip(one.dims, one.shape, strict=True):
                if axis not in file.dimensions:
                    file.dimensions[axis] = size
        for name, values in whole.variables.items():
            # HDF5 knows no texts of a fixed number of letters.
            kind = h5py.string_dtype() if values.dtype.kind == "U" else values.dtype
            file.create_variable(str(name), values.dims, kind)[...] = values.values
            file.variables[name].attrs.update(values.attrs)
        described = _described(whole)
        for one in maps:
            attributes = {**one.attributes, CHECKSUM: _streamed(file, one)}
            file.variables[one.name].attrs.update(attributes)
            described["variables"][one.name] = [list(one.dims), attributes]
        file.attrs.update({**whole.attrs, CHECKSUM: checksums.of_words(described)})


class Part(NamedTuple):
    """A part of a map that one of several ranks has.

    Parameters
    ----------
    rank : int
        Which has it.
    length : int
        Entries along the first axis.
    take : callable
        Returns it, on that rank.
    """

    rank: int
    length: int
    take: Callable[[], NDArray[Any]]


def write_shared(
    frame: Callable[[], xarray.Dataset],
    maps: Mapping[Streamed, Sequence[Part]],
    path: str | os.PathLike[str],
    ranks: Ranks,
) -> None:
    """Write maps that several ranks hold to one NetCDF file with checksums; all of them call it.

    Parameters
    ----------
    frame : callable
        Returns all but the maps, as for `write_streamed`, on the first rank.
    maps : mapping of Streamed to sequence of Part
        The maps, without parts of their own, and who has which part.
    path : str or path
        File to write, by the first rank; the others send it their parts and need not see it.
    ranks : Ranks
        Those that hold the maps.

    Raises
    ------
    InputError
        If the suffix is not ``.nc``.
    OSError
        As for `write_streamed`, on all ranks.
    """

    def received(one: Streamed, parts: Sequence[Part]) -> Iterator[NDArray[Any]]:
        for rank, length, take in parts:
            ranks.told(True)
            there = np.empty((length, *one.shape[1:]), one.kind) if rank else take()
            yield ranks.sent_to_first(there, rank)

    def written() -> None:
        try:
            streamed = [replace(one, parts=received(one, parts)) for one, parts in maps.items()]
            write_streamed(frame(), streamed, path)
        except BaseException:
            # The others wait to be asked for their parts.
            ranks.told(False)
            raise

    def sent() -> None:
        for rank, _, take in (part for parts in maps.values() for part in parts):
            if not ranks.told(None):
                return
            if rank == ranks.number:
                ranks.sent_to_first(take(), rank)

    files.require_suffix(path, ".nc")
    ranks.agreed(written if ranks.first else sent)


def _streamed(file: Any, one: Streamed) -> str:
    """Write a map part by part; return its checksum."""
    options = {"compression": "gzip", "compression_opts": 1, "shuffle": True} if one.packed else {}
    count, *rest = one.shape
    # Rows as they come: chunks of many rows would be packed again and again.
    rows = max(1, min(count, _CHUNK // math.prod(rest)))
    chunks = (rows, *rest) if one.packed else None
    variable = file.create_variable(one.name, one.dims, one.kind, chunks=chunks, **options)
    found, top = checksums.Running(one.kind, one.shape), 0
    for part in one.parts:
        variable[top : top + len(part)] = part
        found.add(part)
        top += len(part)
    return found.digest()


def sealed(dataset: xarray.Dataset) -> xarray.Dataset:
    """Return a dataset with a checksum on every variable, and one on all that describes them.

    Parameters
    ----------
    dataset : xarray.Dataset
        As it will be read again.

    Returns
    -------
    xarray.Dataset
        The same with attributes `CHECKSUM`: of each variable that of its values
        (`checksums.of_array`), of the dataset that of all attributes, names and dimensions
        (`checksums.of_words`), the checksums of the variables among them.
    """
    marked = dataset.copy()
    for variable in marked.variables.values():
        variable.attrs[CHECKSUM] = checksums.of_array(variable.values)
    marked.attrs[CHECKSUM] = checksums.of_words(_described(marked))
    return marked


def mismatches(
    dataset: xarray.Dataset, names: Iterable[str] | None = None
) -> tuple[str, ...] | None:
    """Return what of a dataset is not as it was written.

    Parameters
    ----------
    dataset : xarray.Dataset
        As it was read.
    names : iterable of str, optional
        Variables to look into; all of them without it. The attributes are looked at in any case.

    Returns
    -------
    tuple of str or None
        Variables whose values differ from their checksum, and `ATTRIBUTES` if those do; nothing
        where all is as it was written, ``None`` where there are no checksums.
    """
    variables = {str(name): variable for name, variable in dataset.variables.items()}
    parts = (dataset.attrs, *(variable.attrs for variable in variables.values()))
    if not any(CHECKSUM in attributes for attributes in parts):
        return None
    found = [
        name
        for name in (variables if names is None else names)
        if checksums.of_array(variables[name].values) != variables[name].attrs.get(CHECKSUM)
    ]
    if checksums.of_words(_described(dataset)) != dataset.attrs.get(CHECKSUM):
        found.append(ATTRIBUTES)
    return tuple(found)


def altered(name: str, changed: Sequence[str]) -> FormatError:
    """Return the error about a file that is not as it was written.

    Parameters
    ----------
    name : str
        Of the file.
    changed : sequence of str
        From `mismatches`.
    """
    listed = " and ".join([", ".join(changed[:-1]), changed[-1]] if changed[1:] else changed)
    verb = "do" if changed[1:] or changed[0] == ATTRIBUTES else "does"
    return FormatError(
        f"{name} was damaged or changed after it was written: {listed} {verb} not match the "
        f"checksum; take a copy of the file, or make it again"
    )


def _described(dataset: xarray.Dataset) -> dict[str, Any]:
    """Return all of a dataset but the values of its variables and its own checksum."""
    return {
        "attributes": {name: value for name, value in dataset.attrs.items() if name != CHECKSUM},
        "variables": {
            str(name): [list(variable.dims), dict(variable.attrs)]
            for name, variable in dataset.variables.items()
        },
    }


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
    FormatError, InsufficientMemoryError, ValueError
        As `hdf5.check`; also if an axis has more values than fit into the memory, or a variable
        other points than its axes.
    Exception
        Of almost any kind for other damage: OSError, KeyError, RuntimeError and more.
    """
    arrays = hdf5.check(path)
    for name, stored in arrays.items():
        # xarray reads the axes as it opens a file.
        if len(stored.shape) == 1:
            limits.require_size(f"{name!r} in {path.name}", stored.size)
    import h5netcdf
    import h5py
    import xarray
    from xarray.backends import H5NetCDFStore
    from xarray.conventions import decode_cf_variable

    # h5netcdf looks this up first. Where that fails it leaves an unfinished object, which writes a
    # traceback to standard error when it is collected.
    with h5py.File(path, "r") as file:
        file.attrs.get("_nc3_strict")
    # Arrays without axes, of any other HDF5 file, get some.
    with h5netcdf.File(path, "r", decode_vlen_strings=True, phony_dims="access") as file:
        for key, variable in file.variables.items():
            _check_marks(key, variable)
        variables, attributes = H5NetCDFStore(file).load()  # type: ignore[no-untyped-call]
        for key, variable in variables.items():
            # xarray takes the shape from the axes; what is read, and how much, is the array.
            found = arrays.get(str(key))
            if found is None:
                raise ValueError(f"{key} is no array of its own")
            if found.shape[: variable.ndim] != variable.shape:
                raise ValueError(f"{key} has {found.shape} points, its axes {variable.shape}")
        # One by one: xarray's own function for all of them changes the process's warnings.
        decoded = {
            key: decode_cf_variable(key, variable, decode_times=False, decode_timedelta=False)
            for key, variable in variables.items()
        }
        yield xarray.Dataset(decoded, attrs=attributes)


def _check_marks(name: str, variable: Any) -> None:
    """Raise `ValueError` for attributes that xarray would leave out with a warning."""
    attributes, whole = variable.attrs, variable.dtype.kind in "iu"
    fills = [attributes[key] for key in ("missing_value", "_FillValue") if key in attributes]
    marks = {mark for fill in fills for mark in np.ravel(fill) if mark == mark}
    if whole and fills and not marks:
        raise ValueError(f"{name} holds integers, but {fills[0]} for what is missing")
    if len(marks) > 1:
        raise ValueError(f"{name} has several values for what is missing")
    if "_Unsigned" in attributes and not whole:
        raise ValueError(f"{name} holds no integers, but says that they have no sign")
