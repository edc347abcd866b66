"""Checksums: of arrays and words, however a file stores them, and of files."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike


def of_array(values: ArrayLike) -> str:
    """Return the checksum of an array: kind of number, shape, and every bit of it.

    Parameters
    ----------
    values : array_like
        Numbers or texts of any shape.

    Returns
    -------
    str
        SHA-256 in hexadecimal digits, of ``"<f8 (ny, nx) "`` (kind and shape as NumPy writes
        them) followed by the numbers row by row, little-endian. Texts count as a JSON list.

    Examples
    --------
    >>> of_array([1.0, 2.0]) == of_array((1.0, 2.0)), of_array([1.0, 2.0]) == of_array([[1.0, 2.0]])
    (True, False)
    >>> import hashlib
    >>> ones = np.ones((2, 3))
    >>> of_array(ones) == hashlib.sha256(b"<f8 (2, 3) " + ones.tobytes()).hexdigest()
    True
    """
    array = np.asarray(values)
    if array.dtype.kind not in "biufc":
        return of_words(["text", array.shape, array.tolist()])
    little = np.ascontiguousarray(array, array.dtype.newbyteorder("<"))
    found = hashlib.sha256(f"{little.dtype.str} {array.shape} ".encode())
    found.update(little.reshape(-1).view(np.uint8).data)
    return found.hexdigest()


class Running:
    """The checksum of an array that comes in parts, as `of_array` would find it.

    Parameters
    ----------
    kind : str
        Of its numbers, little-endian, as NumPy writes it.
    shape : tuple of int
        Of the whole array.

    Examples
    --------
    >>> ones, found = np.ones((3, 2)), Running("<f8", (3, 2))
    >>> found.add(ones[:1])
    >>> found.add(ones[1:])
    >>> found.digest() == of_array(ones)
    True
    """

    def __init__(self, kind: str, shape: tuple[int, ...]) -> None:
        self._kind = np.dtype(kind)
        self._found = hashlib.sha256(f"{self._kind.str} {shape} ".encode())

    def add(self, part: ArrayLike) -> None:
        """Go on with the next rows."""
        little = np.ascontiguousarray(part, self._kind)
        self._found.update(little.reshape(-1).view(np.uint8).data)

    def digest(self) -> str:
        """Return the checksum of all that has come."""
        return self._found.hexdigest()


def of_arrays(arrays: Mapping[str, ArrayLike]) -> str:
    """Return the checksum of arrays with their names, whatever their order.

    Parameters
    ----------
    arrays : mapping of array_like
        Numbers or texts by name.

    Returns
    -------
    str
        SHA-256 in hexadecimal digits.
    """
    return of_words({name: of_array(values) for name, values in arrays.items()})


def of_file(path: str | os.PathLike[str]) -> str:
    """Return the checksum of a file as it stands on the disk.

    Parameters
    ----------
    path : str or path
        The file.

    Returns
    -------
    str
        SHA-256 in hexadecimal digits, of its bytes.
    """
    with open(path, "rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def of_words(words: Any) -> str:
    """Return the checksum of words and numbers, whatever their order in mappings.

    Parameters
    ----------
    words : object
        Texts and numbers, those of NumPy included, lists and mappings of them.

    Returns
    -------
    str
        SHA-256 in hexadecimal digits, of their JSON in ASCII with sorted keys.

    Examples
    --------
    >>> of_words({"a": 1, "b": np.float64(0.1)}) == of_words({"b": 0.1, "a": np.int64(1)})
    True
    """
    text = json.dumps(words, sort_keys=True, default=_plain)
    return hashlib.sha256(text.encode("ascii")).hexdigest()


def _plain(value: Any) -> Any:
    """Return what JSON knows for what it does not know."""
    return value.tolist() if isinstance(value, (np.generic, np.ndarray)) else repr(value)
