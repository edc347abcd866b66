"""NetCDF files with checksums, written atomically; damaged files raise an error.

`write`: HDF5 does not recover from a full disk: it fails again on closing, and ends the process
with a segmentation fault. So the file is first written to memory, and directly to the disk only if
the arrays take more than half of the free memory.
"""

from __future__ import annotations

import contextlib
import io
import math
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools import checkpoints, files, memory, processes
from roughcontact.errors import FormatError

if TYPE_CHECKING:
    import xarray


T = TypeVar("T")

# Largest compression ratio of deflate.
_DEFLATED = 1032

# Computing time of all but the values of a file [s], and more of it per bytes of the file.
_READING_SECONDS, _READING_RATE = 2, 2**20

# Attributes for the storage of values, which are no part of the content.
_MARKS = ("_FillValue", "missing_value")
_ENCODING = (*_MARKS, "scale_factor", "add_offset", "_Unsigned")


class StoredArray(NamedTuple):
    """Description of one stored array."""

    shape: tuple[int, ...]  # Points along each axis
    size: int  # Bytes of all points
    kind: str  # NumPy letter of the dtype


def check_hdf5(path: Path) -> dict[str, StoredArray]:
    """Return the arrays of an HDF5 file, or raise an error if it is unsafe to read.

    Unsafe are files that HDF5 would read forever, that exhaust the memory, or that refer to other
    files. A child process reads all except the values first, as HDF5 cannot be interrupted.
    """
    return _call_reader(_list_arrays, path)


def _call_reader(function: Callable[[Path], T], path: Path) -> T:
    """Return the result of a function that reads HDF5, in a child process."""
    # Imported before the fork, so that they are loaded once.
    import h5netcdf  # noqa: F401
    import h5py  # noqa: F401

    seconds = _READING_SECONDS + path.stat().st_size // _READING_RATE
    return processes.call_limited(function, path, seconds=seconds)


def _list_arrays(path: Path) -> dict[str, StoredArray]:
    """Return the arrays of an HDF5 file, after reading all attributes and texts."""
    import h5py

    with h5py.File(path, "r") as file:
        # HDF5 drops errors of its callback: first list the links. It follows hard links only,
        # and visits each object once.
        links: list[tuple[bytes, int]] = [(b"/", h5py.h5l.TYPE_HARD)]
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
                yield text, _require_stored(path, text, result)
            # The reader reports what is damaged.
            with contextlib.suppress(Exception):
                node = file[name]
                dict(node.attrs)
                if node.dtype == object:
                    node[...]
        # A soft link refers to an object in the same file.
        elif kind != h5l.TYPE_SOFT:
            raise _external_storage(path, text, "an external link")


def _require_stored(path: Path, name: str, array: Any) -> StoredArray:
    """Return an array, or raise `FormatError` if its data are in another file."""
    from h5py import Dataset, h5d

    layout = array.get_create_plist()
    if layout.get_layout() == h5d.VIRTUAL:
        raise _external_storage(path, name, "a virtual dataset")
    if layout.get_layout() == h5d.CONTIGUOUS and layout.get_external_count():
        raise _external_storage(path, name, "raw data outside")
    each = array.get_type().get_size()
    if layout.get_layout() == h5d.CHUNKED:
        memory.require_memory(
            math.prod(layout.get_chunk()) * each,
            f"one block of {name!r} in {path.name} needs",
            advice=("check that the file is complete",),
        )
        if layout.get_nfilters() and array.get_storage_size() > memory.free_bytes() // _DEFLATED:
            # Blocks that unpack to more than they state exceed the memory of the child process.
            values = Dataset(array)
            for block in values.iter_chunks():
                values[block]
    kind = ""
    with contextlib.suppress(TypeError):
        kind = array.dtype.kind
    size = math.prod(array.shape) * each
    # Blocks that are never written occupy no space; fields over the depth may be nearly all zero.
    if len(array.shape) <= 2:
        memory.require_packing(f"{name!r} in {path.name}", size, path.stat().st_size)
    return StoredArray(array.shape, size, kind)


def _external_storage(path: Path, name: str, how: str) -> FormatError:
    return FormatError(
        f"{path.name} keeps {name!r} in another file ({how}), which is not read; save it as one "
        "file"
    )


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
    values: Any  # Numbers or texts; in an open file, the array of h5py until it is loaded
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

    def add(self, name: str, dims: Any, values: Any, unit: str, text: str) -> None:
        """Set the axes, the values, the unit and the long name of a variable."""
        self[name] = dims, values, {"units": unit, "long_name": text}

    def __getitem__(self, name: str) -> Variable:
        """Return a variable."""
        if name not in self.variables:
            listed = ", ".join(map(repr, self.variables)) or "none"
            raise ValueError(f"no variable {name!r}; there are {listed}")
        return self.variables[name]

    def __contains__(self, name: str) -> bool:
        """Return whether there is a variable of this name."""
        return name in self.variables

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
        return sum(
            math.prod(values.shape) * np.dtype(values.dtype).itemsize
            for _, values, _ in self.variables.values()
        )

    def load(self, names: Iterable[str] | None = None) -> None:
        """Read values of an open file, by default all."""
        for name in list(self.variables if names is None else names):
            variable = self.variables[name]
            self.variables[name] = variable._replace(values=_read_values(variable.values))

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
        marked[name] = (dims, values, {**attrs, CHECKSUM: checkpoints.checksum_array(values)})
    marked.attrs[CHECKSUM] = checkpoints.checksum_json(_describe_dataset(marked))
    return marked


def changed_names(dataset: Dataset, names: Iterable[str] | None = None) -> tuple[str, ...] | None:
    """Return the names that differ from their checksums; None without any checksum."""
    variables = dataset.variables
    parts = (dataset.attrs, *(variable.attrs for variable in variables.values()))
    if not any(CHECKSUM in attributes for attributes in parts):
        return None
    result = [
        name
        for name in (variables if names is None else names)
        if checkpoints.checksum_array(variables[name].values) != variables[name].attrs.get(CHECKSUM)
    ]
    if checkpoints.checksum_json(_describe_dataset(dataset)) != dataset.attrs.get(CHECKSUM):
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


def _describe_dataset(dataset: Dataset) -> dict[str, Any]:
    """Return the attributes, names and dimensions of a dataset, without its checksum."""
    return {
        "attributes": {name: value for name, value in dataset.attrs.items() if name != CHECKSUM},
        "variables": {
            name: [list(variable.dims), variable.attrs]
            for name, variable in dataset.variables.items()
        },
    }


@contextmanager
def open_dataset(path: Path) -> Iterator[Dataset]:
    """Open a NetCDF file after a check of it; `Dataset.load` reads the values."""
    import h5py

    dataset = _call_reader(_read_header, path)
    with h5py.File(path, "r") as file:
        for name, variable in dataset.variables.items():
            dataset.variables[name] = variable._replace(values=file[name])
        yield dataset


def _read_header(path: Path) -> Dataset:
    """Return the content of a NetCDF file without values, after a check of the file."""
    arrays = _list_arrays(path)
    import h5netcdf
    import h5py

    # h5netcdf reads this attribute first. If that fails it leaves an incomplete object, which
    # prints a traceback when it is garbage collected.
    with h5py.File(path, "r") as file:
        file.attrs.get("_nc3_strict")
    # Arrays of other HDF5 files have no dimensions: h5netcdf adds phony ones.
    with h5netcdf.File(path, "r", phony_dims="access") as file:
        dataset = Dataset(_read_attributes(file))
        for name, variable in file.variables.items():
            # h5netcdf takes the shape from the dimensions, but reads the array.
            if name not in arrays:
                raise ValueError(f"{name} is not a separate array")
            if arrays[name].shape != variable.shape:
                raise ValueError(
                    f"{name} has {arrays[name].shape} points, its axes {variable.shape}"
                )
            attributes = _read_attributes(variable)
            content = {key: attributes[key] for key in attributes.keys() - set(_ENCODING)}
            dataset.variables[name] = Variable(variable.dimensions, None, content)
    return dataset


def _read_attributes(node: Any) -> dict[str, Any]:
    """Return the attributes of a file or a variable, with texts instead of bytes."""
    return {
        key: value.decode("utf-8") if isinstance(value, bytes) else value
        for key, value in node.attrs.items()
    }


def _read_values(array: Any) -> NDArray[Any]:
    """Return the values of an array of h5py, NaN where its attributes mark them missing."""
    if array.dtype == object:
        return np.asarray(array.asstr()[...])
    encoding = {key: array.attrs[key] for key in _ENCODING if key in array.attrs}
    values: NDArray[Any] = np.asarray(array[...])
    values = values.astype(values.dtype.newbyteorder("="), copy=False)
    marks = [mark for key in _MARKS for mark in np.ravel(encoding.get(key, []))]
    marked = [values == mark for mark in marks if mark == mark]
    if values.dtype.kind == "i" and encoding.get("_Unsigned") == "true":
        values = values.view(f"u{values.dtype.itemsize}")
    for missing in marked:
        if np.any(missing):
            values = np.where(missing, np.nan, values)
    if "scale_factor" in encoding or "add_offset" in encoding:
        values = values * encoding.get("scale_factor", 1) + encoding.get("add_offset", 0)
    return values
