"""Numbers as bytes, little-endian and in blocks, for files too large for a second copy."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

BLOCK = 2**20
"""Bytes handled at a time; divisible by the size of every number."""


class Bounded(io.BufferedReader):
    """A stream that reserves no more memory for a read than the file can fill.

    A damaged header may ask for terabytes, which ``io.BufferedReader`` reserves before it reads.
    """

    def read(self, size: int | None = -1, /) -> bytes:
        """Return so many bytes, or those that are left."""
        if size is not None and size > 0:
            left = os.fstat(self.fileno()).st_size - self.tell()
            size = min(size, max(left, 0))
        return super().read(size)


def little_endian(values: NDArray[Any]) -> memoryview:
    """Return the little-endian bytes of a map; nothing is copied on most machines."""
    little = np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("<"))
    return little.reshape(-1).view(np.uint8).data


def blocks(content: bytes | memoryview) -> Iterator[memoryview]:
    """Yield bytes in blocks, the last of them shorter."""
    view = memoryview(content)
    for start in range(0, len(view), BLOCK):
        yield view[start : start + BLOCK]
