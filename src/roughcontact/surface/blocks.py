"""A map taken in blocks of rows, so that what is made on the way stays small."""

from __future__ import annotations

from collections.abc import Iterator

VALUES = 2**20
"""Values per block: temporaries of 8 MiB, whatever the size of the map."""


def of_rows(shape: tuple[int, ...], values: int = 1) -> Iterator[slice]:
    """Yield the rows of a map in blocks.

    Parameters
    ----------
    shape : (int, int)
        Points ``(ny, nx)``.
    values : int
        Values that are made for each point at a time.

    Yields
    ------
    slice
        Rows of one block; at least one row.
    """
    step = max(1, VALUES // max(1, shape[1] * values))
    for start in range(0, shape[0], step):
        yield slice(start, min(start + step, shape[0]))
