"""Files of NumPy: what is in them is told from their heads, and only what is wanted is read."""

from __future__ import annotations

import contextlib
import io
import math
import sys
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from roughcontact import limits
from roughcontact.errors import FormatError, RoughcontactError
from roughcontact.formats import archives
from roughcontact.formats.source import one_line

# Heads have a hundred bytes; NumPy takes none of more than ten thousand.
_LONGEST_HEAD = 2**16
_SUFFIX = ".npy"


class Head(NamedTuple):
    """What an array says of itself.

    Parameters
    ----------
    shape : tuple of int
        Points along each axis.
    dtype : dtype
        Kind of its numbers; void for what is no array.
    """

    shape: tuple[int, ...]
    dtype: np.dtype[Any]

    @property
    def size(self) -> int:
        """Bytes of its numbers."""
        return math.prod(self.shape) * self.dtype.itemsize


_NO_ARRAY = Head((), np.dtype("V"))


@dataclass(frozen=True)
class Arrays:
    """The arrays in a file of NumPy.

    Parameters
    ----------
    path : Path
        The file.
    heads : Mapping
        What they say of themselves, by name in their order; the only one of a ``.npy`` file has
        the name ``""``.
    """

    path: Path
    heads: Mapping[str, Head]

    def read(self, name: str) -> NDArray[Any]:
        """Return an array; that of a ``.npy`` file is mapped and not read.

        Raises
        ------
        FormatError
            If it is damaged, or larger than any map.
        InsufficientMemoryError
            If it is larger than the memory that is free.
        """
        limits.require_size(self.path.name, self.heads[name].size)
        with _refused(self.path):
            if not name:
                mapped: NDArray[Any] = np.load(self.path, mmap_mode="r", allow_pickle=False)
                return mapped
            # The checksum is compared where the last byte is read.
            with zipfile.ZipFile(self.path) as archive, archive.open(name + _SUFFIX) as stream:
                values: NDArray[Any] = npy.read_array(stream, allow_pickle=False)
                _check_letters(values)
                return values


def opened(path: Path, kind: str) -> Arrays:
    """Return what is in a file.

    Parameters
    ----------
    path : Path
        The file.
    kind : str
        ``"npy"`` for one array, ``"npz"`` for an archive of them.

    Raises
    ------
    FormatError
        If it is damaged, or no such file.
    """
    with _refused(path):
        if kind == "npz":
            return Arrays(path, dict(_members(path)))
        with path.open("rb") as stream:
            return Arrays(path, {"": _head(stream, path.stat().st_size)})


def _members(path: Path) -> Iterator[tuple[str, Head]]:
    """Yield the arrays in an archive."""
    with zipfile.ZipFile(path) as archive:
        for member in archive.infolist():
            archives.check_method(path, member)
            name = member.filename.removesuffix(_SUFFIX)
            if name == member.filename:
                yield name, _NO_ARRAY
                continue
            with archive.open(member) as stream:
                yield name, _head(stream, member.file_size)


def _head(stream: IO[bytes], size: int) -> Head:
    """Return what an array in a file, or in a member of an archive, of that size says of itself."""
    start = io.BytesIO(stream.read(_LONGEST_HEAD))
    version = npy.read_magic(start)
    if version == (3, 0):
        # Names of columns in Unicode, hence no matrix.
        return _NO_ARRAY
    read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
    shape, _, dtype = read(start)
    head = Head(shape, dtype)
    if dtype.hasobject:
        raise ValueError("Python objects instead of numbers")
    spare = size - start.tell() - head.size
    if spare:
        raise ValueError(f"shape {shape} of {dtype} leaves {spare} bytes of the file over")
    return head


def _check_letters(values: NDArray[Any]) -> None:
    """Raise `ValueError` for text with numbers that are no letters; NumPy takes any."""
    if values.dtype.kind == "U" and values.dtype.itemsize:
        numbers = np.atleast_1d(values).view(values.dtype.byteorder + "u4")
        if numbers.max(initial=0) > sys.maxunicode:
            raise ValueError("text with letters that do not exist")


@contextlib.contextmanager
def _refused(path: Path) -> Iterator[None]:
    """Turn whatever goes wrong with the content of a file into one error."""
    try:
        yield
    except RoughcontactError:
        raise
    # Damaged files raise ValueError, BadZipFile, EOFError, SyntaxError, MemoryError and more.
    except Exception as error:
        raise FormatError(
            f"{path.name} cannot be read as a file of NumPy ({one_line(error)}); save a real array "
            "with numpy.save or numpy.savez"
        ) from None
