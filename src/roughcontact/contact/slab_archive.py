"""A contact on several ranks in one file, as `archive` writes it: row by row, rank by rank."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact import files, netcdf
from roughcontact.contact import archive
from roughcontact.contact.slab_result import SlabResult

# Bytes that travel to the rank that writes at a time.
_PART = 1 << 25


def save_slabs(result: SlabResult, path: str | os.PathLike[str]) -> None:
    """Write a contact that lies on several ranks to one NetCDF file; all of them call it.

    Parameters
    ----------
    result : SlabResult
        The rows of this rank.
    path : str or path
        File to write; the first rank writes it and the others send it their rows, so that it need
        not be seen by them. It appears only once it is complete, with the checksums of all files
        of this program; `roughcontact.load_result` reads it where its maps fit into the memory.

    Raises
    ------
    InputError
        If the suffix is not ``.nc``.
    OSError
        If the file cannot be written, on all ranks; an old file survives.
    """
    files.require_suffix(path, ".nc")
    maps = _maps(result)
    result.slab.ranks.agreed(
        lambda: _written(result, maps, path) if result.slab.ranks.first else _sent(result, maps)
    )


Here = Callable[[slice], NDArray[Any]]


def _maps(result: SlabResult) -> dict[str, tuple[str, Here]]:
    """Return the kind of number of each map, and its values on rows of this rank."""
    slab = result.slab
    highest = slab.highest
    return {
        "height": ("<f8", lambda rows: slab.heights[rows]),
        "initial_gap": ("<f8", lambda rows: highest - slab.heights[rows]),
        "pressure": ("<f8", lambda rows: result.pressure[rows]),
        "gap": ("<f8", lambda rows: result.gap[rows]),
        "saturated": ("|i1", lambda rows: result.saturated[rows].astype(np.int8)),
    }


def _pieces(result: SlabResult, kind: str) -> Iterator[tuple[int, slice]]:
    """Yield the rank and its rows, counted from its first, of what travels together."""
    edges, nx = result.slab.edges, result.shape[1]
    step = max(1, _PART // (nx * np.dtype(kind).itemsize))
    for rank in range(result.slab.ranks.count):
        height = edges[rank + 1] - edges[rank]
        for top in range(0, height, step):
            yield rank, slice(top, min(top + step, height))


def _sent(result: SlabResult, maps: dict[str, tuple[str, Here]]) -> None:
    """Send the first rank what it asks for, until it has all or gives up."""
    ranks = result.slab.ranks
    for kind, here in maps.values():
        for rank, rows in _pieces(result, kind):
            if not ranks.told(None):
                return
            if rank == ranks.number:
                ranks.sent_to_first(here(rows), rank)


def _written(
    result: SlabResult, maps: dict[str, tuple[str, Here]], path: str | os.PathLike[str]
) -> None:
    ranks, nx = result.slab.ranks, result.shape[1]

    def parts(kind: str, here: Here) -> Iterator[NDArray[Any]]:
        for rank, rows in _pieces(result, kind):
            ranks.told(True)
            if rank == 0:
                yield here(rows)
                continue
            part = np.empty((rows.stop - rows.start, nx), kind)
            yield ranks.sent_to_first(part, rank)

    streamed = [
        netcdf.Streamed(
            name, kind, result.shape, parts(kind, here), archive.described(name),
            packed=name in archive.PACKED,
        )
        for name, (kind, here) in maps.items()
    ]  # fmt: skip
    try:
        netcdf.write_streamed(archive.frame(result), streamed, path)
    except BaseException:
        # The others wait to be asked for their rows.
        ranks.told(False)
        raise
