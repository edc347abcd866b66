"""Checksums of files, and of arrays and JSON values independent of their storage."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike


def checksum_array(values: ArrayLike) -> str:
    """Return the checksum of the dtype, the shape and the values of an array."""
    array = np.asarray(values)
    if array.dtype.kind not in "biufc":
        return checksum_json(["text", array.shape, array.tolist()])
    little = np.ascontiguousarray(array, array.dtype.newbyteorder("<"))
    result = hashlib.sha256(f"{little.dtype.str} {array.shape} ".encode())
    result.update(little.reshape(-1).view(np.uint8).data)
    return result.hexdigest()


def checksum_arrays(arrays: Mapping[str, ArrayLike]) -> str:
    """Return the checksum of arrays with their names, independent of their order."""
    return checksum_json({name: checksum_array(values) for name, values in arrays.items()})


def checksum_file(path: str | os.PathLike[str]) -> str:
    """Return the checksum of the bytes of a file."""
    with Path(path).open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def checksum_json(words: Any) -> str:
    """Return the checksum of JSON values, independent of the order of mappings."""
    text = json.dumps(words, sort_keys=True, default=_to_json_value)
    return hashlib.sha256(text.encode("ascii")).hexdigest()


def _to_json_value(value: Any) -> Any:
    """Return a JSON value for an object that JSON does not support."""
    return value.tolist() if isinstance(value, (np.generic, np.ndarray)) else repr(value)
