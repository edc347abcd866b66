"""NetCDF files with checksums, written atomically; damaged files raise an error.

`write`: HDF5 does not recover from a full disk: it fails again on closing, and ends the process
with a segmentation fault. So the file is first written to memory, and directly to the disk only if
the arrays take more than half of the free memory.
"""

from __future__ import annotations

import contextlib
import io
import math
import mmap
import os
import struct
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools import checksums, files, memory
from roughcontact.errors import FormatError

if TYPE_CHECKING:
    import xarray


# Largest compression ratio of deflate.
_DEFLATED = 1032


class StoredArray(NamedTuple):
    """Description of one stored array."""

    shape: tuple[int, ...]  # Points along each axis
    size: int  # Bytes of all points
    kind: str  # NumPy letter of the dtype


def check_hdf5(path: Path) -> dict[str, StoredArray]:
    """Return the arrays of an HDF5 file, or raise an error if it is unsafe to read.

    Unsafe are files that HDF5 would read forever, that exhaust the memory, or that refer to other
    files.
    """
    _check_heaps(path)
    import h5py

    with h5py.File(path, "r") as file:
        # HDF5 drops errors of its callback: first list the links. It follows hard links only,
        # and visits each object once.
        links: list[tuple[bytes, int]] = []
        file.id.links.visit(lambda name, link: links.append((name, link.type)), info=True)
        return dict(_arrays(path, file, links))


def _arrays(
    path: Path, file: Any, links: list[tuple[bytes, int]]
) -> Iterator[tuple[str, StoredArray]]:
    """Yield the arrays of a file, or raise `FormatError` if data are in another file."""
    from h5py import h5d, h5l, h5o

    for name, kind in links:
        text = name.decode("utf-8", "backslashreplace")
        if kind == h5l.TYPE_HARD:
            result = h5o.open(file.id, name)
            if isinstance(result, h5d.DatasetID):
                yield text, _stored(path, text, result)
        # A soft link refers to an object in the same file.
        elif kind != h5l.TYPE_SOFT:
            raise _external_storage(path, text, "an external link")


def _stored(path: Path, name: str, array: Any) -> StoredArray:
    """Return an array, or raise `FormatError` if its data are in another file."""
    from h5py import h5d

    layout = array.get_create_plist()
    if layout.get_layout() == h5d.VIRTUAL:
        raise _external_storage(path, name, "a virtual dataset")
    if layout.get_layout() == h5d.CONTIGUOUS and layout.get_external_count():
        raise _external_storage(path, name, "raw data outside")
    each = array.get_type().get_size()
    if layout.get_layout() == h5d.CHUNKED:
        block = math.prod(layout.get_chunk()) * each
        memory.require_memory(
            block,
            f"one block of {name!r} in {path.name} needs",
            advice=("check that the file is complete",),
        )
        if layout.get_nfilters():
            _check_blocks(path, name, array, block)
    kind = ""
    with contextlib.suppress(TypeError):
        kind = array.dtype.kind
    size = math.prod(array.shape) * each
    # Blocks that are never written occupy no space; fields over the depth may be nearly all zero.
    if len(array.shape) <= 2:
        memory.require_packing(f"{name!r} in {path.name}", size, path.stat().st_size)
    return StoredArray(array.shape, size, kind)


def _check_blocks(path: Path, name: str, array: Any, block: int) -> None:
    """Raise `FormatError` for a packed array whose blocks unpack to more than a block."""
    if array.get_storage_size() <= memory.free_bytes() // _DEFLATED:
        return
    parts: list[Any] = []
    array.chunk_iter(parts.append)
    whole = path.stat().st_size
    for part in parts:
        if part.size > whole:
            raise FormatError(
                f"{path.name} states {part.size} bytes for a block of {name!r}, more than the file "
                "has; check that the file is complete"
            )
        if part.size > block // _DEFLATED:
            unpacked = b""
            # Blocks that are not deflated raise an error at once.
            with contextlib.suppress(zlib.error):
                packed = array.read_direct_chunk(part.chunk_offset)[1]
                unpacked = zlib.decompressobj().decompress(packed, block + 1)
            if len(unpacked) > block:
                raise FormatError(
                    f"{path.name} holds {name!r} in blocks that unpack to more than they state; "
                    "check where the file is from"
                )


def _external_storage(path: Path, name: str, how: str) -> FormatError:
    return FormatError(
        f"{path.name} keeps {name!r} in another file ({how}), which is not read; save it as one "
        "file"
    )


def _check_heaps(path: Path) -> None:
    """Raise `ValueError` for a file with a global heap that HDF5 would read forever."""
    size = path.stat().st_size
    if size == 0:
        return
    with (
        path.open("rb") as stream,
        mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as content,
    ):
        for first, last in _data_extents(stream.fileno(), size):
            start = content.find(b"GCOL", first, last)
            while start >= 0:
                _check_heap(content, start)
                start = content.find(b"GCOL", start + 4, last)


def _data_extents(descriptor: int, size: int) -> Iterator[tuple[int, int]]:
    """Yield the extents of the data in a file, which may have holes of terabytes."""
    if not hasattr(os, "SEEK_DATA"):
        yield 0, size
        return
    last = 0
    # An error means that no more data follow.
    with contextlib.suppress(OSError):
        while last < size:
            first = os.lseek(descriptor, last, os.SEEK_DATA)
            last = os.lseek(descriptor, first, os.SEEK_HOLE)
            yield first, last


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


# --- NetCDF files: complete, with checksums; damaged files raise an error ---


PACKED: Mapping[str, Any] = {"compression": "gzip", "compression_opts": 1}
"""Options of h5netcdf to compress a map that is mostly zero."""

SHUFFLED: Mapping[str, Any] = {**PACKED, "shuffle": True}
"""Options for a volume: with grouped bytes, half the time and 10 % less space."""

CHECKSUM = "checksum_sha256"
"""Name of the attribute of the file and of each variable with a checksum."""


ATTRIBUTES = "attributes"
"""Name in `changed_names` of all except values: attributes, names and dimensions."""


class Variable(NamedTuple):
    """Array of a NetCDF file."""

    dims: tuple[str, ...]  # Names of the axes
    values: NDArray[Any]  # Numbers or texts
    attrs: dict[str, Any]  # Attributes


class Dataset:
    """Content of a NetCDF file, in the form of xarray.

    xarray itself imports pandas, and dask and pint if installed, which takes a second.
    """

    def __init__(self, attrs: Mapping[str, Any] | None = None) -> None:
        self.variables: dict[str, Variable] = {}
        self.attrs = dict(attrs or {})

    def __setitem__(self, name: str, described: tuple[Any, ...]) -> None:
        """Set the axes, the values and, optionally, the attributes of a variable."""
        dims, values, *about = described
        axes = (dims,) if isinstance(dims, str) else tuple(dims)
        self.variables[name] = Variable(axes, np.asarray(values), dict(*about))

    @property
    def sizes(self) -> dict[str, int]:
        """Points along each axis."""
        return {
            axis: size
            for dims, values, _ in self.variables.values()
            for axis, size in zip(dims, values.shape, strict=True)
        }

    @property
    def nbytes(self) -> int:
        """Bytes of all arrays."""
        return sum(values.nbytes for _, values, _ in self.variables.values())

    def to_xarray(self) -> xarray.Dataset:
        """Return the content as a dataset of xarray."""
        import xarray

        return xarray.Dataset(dict(self.variables), attrs=self.attrs)


def write(
    dataset: Dataset,
    path: str | os.PathLike[str],
    packed: Mapping[str, Mapping[str, Any]] | None = None,
) -> None:
    """Write a dataset to a NetCDF file with checksums, atomically."""
    files.require_suffix(path, ".nc")
    import h5netcdf
    import h5py

    with files.atomic_write(path) as stream:
        place = io.BytesIO() if 2 * dataset.nbytes < memory.free_bytes() else stream
        with h5netcdf.File(place, "w") as file:
            whole = add_checksums(dataset)
            file.attrs.update(whole.attrs)
            file.dimensions = whole.sizes
            for name, (dims, values, attrs) in whole.variables.items():
                # h5py does not write the fixed-length texts of NumPy.
                kind = h5py.string_dtype() if values.dtype.kind == "U" else values.dtype
                missing = kind.type(np.nan) if kind.kind == "f" else None
                variable = file.create_variable(
                    name, dims, kind, fillvalue=missing, **(packed or {}).get(name, {})
                )
                variable.attrs.update(attrs)
                variable[...] = values
        if isinstance(place, io.BytesIO):
            stream.write(place.getbuffer())


def add_checksums(dataset: Dataset) -> Dataset:
    """Return a dataset with checksums of each variable and of all attributes."""
    marked = Dataset(dataset.attrs)
    for name, (dims, values, attrs) in dataset.variables.items():
        marked[name] = (dims, values, {**attrs, CHECKSUM: checksums.checksum_array(values)})
    marked.attrs[CHECKSUM] = checksums.checksum_json(_describe_dataset(marked))
    return marked


def changed_names(
    dataset: xarray.Dataset, names: Iterable[str] | None = None
) -> tuple[str, ...] | None:
    """Return the names that differ from their checksums; None without any checksum."""
    variables = {str(name): variable for name, variable in dataset.variables.items()}
    parts = (dataset.attrs, *(variable.attrs for variable in variables.values()))
    if not any(CHECKSUM in attributes for attributes in parts):
        return None
    result = [
        name
        for name in (variables if names is None else names)
        if checksums.checksum_array(variables[name].values) != variables[name].attrs.get(CHECKSUM)
    ]
    if checksums.checksum_json(_describe_dataset(dataset)) != dataset.attrs.get(CHECKSUM):
        result.append(ATTRIBUTES)
    return tuple(result)


def changed_file_error(name: str, changed: Sequence[str]) -> FormatError:
    """Return the error on a file that was damaged or changed."""
    listed = " and ".join([", ".join(changed[:-1]), changed[-1]] if changed[1:] else changed)
    verb = "do" if changed[1:] or changed[0] == ATTRIBUTES else "does"
    return FormatError(
        f"{name} was damaged or changed after it was written: {listed} {verb} not match the "
        f"checksum; take a copy of the file, or make it again"
    )


def _describe_dataset(dataset: Dataset | xarray.Dataset) -> dict[str, Any]:
    """Return the attributes, names and dimensions of a dataset, without its checksum."""
    return {
        "attributes": {name: value for name, value in dataset.attrs.items() if name != CHECKSUM},
        "variables": {
            str(name): [list(variable.dims), dict(variable.attrs)]
            for name, variable in dataset.variables.items()
        },
    }


@contextmanager
def open_dataset(path: Path) -> Iterator[xarray.Dataset]:
    """Open the dataset of a NetCDF file, after a check of the file."""
    arrays = check_hdf5(path)
    for name, stored in arrays.items():
        # xarray reads one-dimensional coordinates on opening a file.
        if len(stored.shape) == 1:
            memory.require_size(f"{name!r} in {path.name}", stored.size)
    import h5netcdf
    import h5py
    import xarray
    from xarray.backends import H5NetCDFStore
    from xarray.conventions import decode_cf_variable

    # h5netcdf reads this attribute first. If that fails it leaves an incomplete object, which
    # prints a traceback when it is garbage collected.
    with h5py.File(path, "r") as file:
        file.attrs.get("_nc3_strict")
    # Arrays of other HDF5 files have no dimensions: h5netcdf adds phony ones.
    with h5netcdf.File(path, "r", decode_vlen_strings=True, phony_dims="access") as file:
        for key, variable in file.variables.items():
            _check_marks(key, variable)
        variables, attributes = H5NetCDFStore(file).load()  # type: ignore[no-untyped-call]
        for key, variable in variables.items():
            # xarray takes the shape from the dimensions, but reads the array.
            result = arrays.get(str(key))
            if result is None:
                raise ValueError(f"{key} is not a separate array")
            if result.shape[: variable.ndim] != variable.shape:
                raise ValueError(f"{key} has {result.shape} points, its axes {variable.shape}")
        # One by one: the function of xarray for all variables changes the warning filters.
        decoded = {
            key: decode_cf_variable(key, variable, decode_times=False, decode_timedelta=False)
            for key, variable in variables.items()
        }
        yield xarray.Dataset(decoded, attrs=attributes)


def _check_marks(name: str, variable: Any) -> None:
    """Raise `ValueError` for attributes that xarray would ignore with a warning."""
    attributes, whole = variable.attrs, variable.dtype.kind in "iu"
    fills = [attributes[key] for key in ("missing_value", "_FillValue") if key in attributes]
    marks = {mark for fill in fills for mark in np.ravel(fill) if mark == mark}
    if whole and fills and not marks:
        raise ValueError(f"{name} holds integers, but marks missing values by {fills[0]}")
    if len(marks) > 1:
        raise ValueError(f"{name} has several marks of missing values")
    if "_Unsigned" in attributes and not whole:
        raise ValueError(f"{name} is declared unsigned, but holds no integers")
