"""HDF5 files that may be damaged, or reach beyond themselves: looked at before they are read."""

from __future__ import annotations

import contextlib
import math
import mmap
import os
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from roughcontact import limits, memory
from roughcontact.errors import FormatError

# Deflate packs 1032 to 1 at most.
_DEFLATED = 1032


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
    """Refuse an HDF5 file that would be read for ever, or in which another file is read.

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
    ValueError
        If its collections of texts and references are damaged.
    Exception
        Of almost any kind for other damage: OSError, KeyError, RuntimeError and more.
    """
    _check_heaps(path)
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
        block = math.prod(layout.get_chunk()) * each
        memory.require(
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
    # What is never written takes no place; fields over the depth may be nearly all zero.
    if len(array.shape) <= 2:
        limits.require_packing(f"{name!r} in {path.name}", size, path.stat().st_size)
    return Stored(array.shape, size, kind)


def _check_blocks(path: Path, name: str, array: Any, block: int) -> None:
    """Refuse a packed array of which a block unpacks to more than a block.

    HDF5 would go on to the end of what is packed, whatever that takes. Looked at only where it
    could take more than the memory that is free.
    """
    if array.get_storage_size() <= memory.free() // _DEFLATED:
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
            # What is not deflated ends here at once.
            with contextlib.suppress(zlib.error):
                packed = array.read_direct_chunk(part.chunk_offset)[1]
                unpacked = zlib.decompressobj().decompress(packed, block + 1)
            if len(unpacked) > block:
                raise FormatError(
                    f"{path.name} holds {name!r} in blocks that unpack to more than they state; "
                    "check where the file is from"
                )


def _outside(path: Path, name: str, how: str) -> FormatError:
    return FormatError(
        f"{path.name} keeps {name!r} in another file ({how}), which is not followed; save it as "
        "one file"
    )


def _check_heaps(path: Path) -> None:
    """Refuse a file with a global heap that HDF5 would read for ever.

    A heap is ``GCOL``, version, its size, and objects: index, references, size, content. Index 0
    is the free space, which reaches to the end. HDF5 (2.0.0 among others) steps over it by its
    size, and a size of 0 lets it stand still. See the HDF5 File Format Specification Version 3.0,
    section III.E.
    """
    size = path.stat().st_size
    if size == 0:
        return
    with (
        path.open("rb") as stream,
        mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as content,
    ):
        for first, last in _filled(stream.fileno(), size):
            start = content.find(b"GCOL", first, last)
            while start >= 0:
                _check_heap(content, start)
                start = content.find(b"GCOL", start + 4, last)


def _filled(descriptor: int, size: int) -> Iterator[tuple[int, int]]:
    """Yield where a file holds anything: it may have holes of terabytes."""
    if not hasattr(os, "SEEK_DATA"):
        yield 0, size
        return
    last = 0
    # An error says that nothing more follows.
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
