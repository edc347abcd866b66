"""HDF5 files that ask for too much, or reach beyond themselves: looked at before they are read."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from roughcontact import limits, memory
from roughcontact.errors import FormatError


class Stored(NamedTuple):
    """What a file says of one array.

    Parameters
    ----------
    shape : tuple of int
        Its points along each axis.
    size : int
        Bytes of all of them.
    kind : str
        NumPy's letter for its numbers; empty where NumPy has none.
    """

    shape: tuple[int, ...]
    size: int
    kind: str


def check(path: Path) -> dict[str, Stored]:
    """Refuse an HDF5 file that asks for too much, or in which another file is read.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    dict
        Every array in it by name; nothing of them has been read.

    Raises
    ------
    FormatError
        If an array or a group lies in another file: raw data outside, a virtual dataset, an
        external link; if a map or a line announces bytes that the file cannot hold, packed as
        measurements are.
    InsufficientMemoryError
        If one block of an array, which HDF5 reads as a whole, exceeds the memory that is free.
    Exception
        Of almost any kind for other damage: OSError, KeyError, RuntimeError and more.
    """
    import h5py

    with h5py.File(path, "r") as file:
        # Errors do not come out of what HDF5 calls: the links are listed first. It follows the
        # hard ones, each object once.
        links: list[tuple[bytes, int]] = []
        file.id.links.visit(lambda name, link: links.append((name, link.type)), info=True)
        return dict(_arrays(path, file, links))


def _arrays(path: Path, file: Any, links: list[tuple[bytes, int]]) -> Iterator[tuple[str, Stored]]:
    """Yield what a file says of its arrays, by name, if all of them lie in it."""
    from h5py import h5d, h5l, h5o

    for name, kind in links:
        text = name.decode("utf-8", "backslashreplace")
        if kind == h5l.TYPE_HARD:
            found = h5o.open(file.id, name)
            if isinstance(found, h5d.DatasetID):
                yield text, _stored(path, text, found)
        # A soft link leads to where the hard ones do.
        elif kind != h5l.TYPE_SOFT:
            raise _outside(path, text, "an external link")


def _stored(path: Path, name: str, array: Any) -> Stored:
    """Return what is said of an array, if it lies in the file."""
    from h5py import h5d

    layout = array.get_create_plist()
    if layout.get_layout() == h5d.VIRTUAL:
        raise _outside(path, name, "a virtual dataset")
    if layout.get_layout() == h5d.CONTIGUOUS and layout.get_external_count():
        raise _outside(path, name, "raw data outside")
    each = array.get_type().get_size()
    if layout.get_layout() == h5d.CHUNKED:
        memory.require(
            math.prod(layout.get_chunk()) * each,
            f"one block of {name!r} in {path.name} needs",
            advice=("check that the file is complete",),
        )
    kind = ""
    with contextlib.suppress(TypeError):
        kind = array.dtype.kind
    size = math.prod(array.shape) * each
    # What is never written takes no place; fields over the depth may be nearly all zero.
    if len(array.shape) <= 2:
        limits.require_packing(f"{name!r} in {path.name}", size, path.stat().st_size)
    return Stored(array.shape, size, kind)


def _outside(path: Path, name: str, how: str) -> FormatError:
    return FormatError(
        f"{path.name} keeps {name!r} in another file ({how}), which is not followed; save it as "
        "one file"
    )
