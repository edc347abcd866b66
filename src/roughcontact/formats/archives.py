"""What is packed in files: judged by what it says of itself, and unpacked no further than that."""

from __future__ import annotations

import gzip
import mmap
import re
import tempfile
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from roughcontact import limits, memory
from roughcontact.errors import FormatError

_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_BLOCK = 2**20

_XML = (b"<", b"\xef\xbb\xbf<", b"\xff\xfe<", b"\xfe\xff\0<")

_GZIP = b"\x1f\x8b"

# How a stream of zlib starts.
_ZLIB = re.compile(rb"\x78[\x01\x5e\x9c\xda]")


def check(path: Path) -> None:
    """Refuse an archive that is damaged, or unpacks to more than a map may take.

    Parameters
    ----------
    path : Path
        The file.

    Raises
    ------
    FormatError
        If it unpacks to more than `limits.BYTES`, holds a text too long for a header, or a member
        that is packed in a way in which it could unpack to any size.
    InsufficientMemoryError
        If it unpacks to more than the memory that is free.
    ValueError
        If a checksum is wrong.
    BadZipFile
        If it is no archive, or damaged in another way.

    Notes
    -----
    A member is read to the size that the archive states and no further, whatever it unpacks to;
    readers of a damaged length would stop before they come to the checksum.
    """
    check_sizes(path)
    with zipfile.ZipFile(path) as archive:
        for member in archive.infolist():
            _check_member(path, archive, member)


def check_sizes(path: Path) -> int:
    """Refuse an archive that states more than a map may take, or is packed in an unusual way.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    int
        Bytes that it unpacks to, as it states.

    Raises
    ------
    FormatError, InsufficientMemoryError, BadZipFile
        As `check`.
    """
    with zipfile.ZipFile(path) as archive:
        members = archive.infolist()
    size = sum(member.file_size for member in members)
    limits.require_size(path.name, size, packed=path.stat().st_size)
    for member in members:
        check_method(path, member)
    return size


@contextmanager
def unpacked(path: Path) -> Iterator[Path]:
    """Give what is in a file packed by gzip as a file, under the name that it has packed.

    Parameters
    ----------
    path : Path
        The file.

    Yields
    ------
    Path
        The file itself if it is not packed.

    Raises
    ------
    FormatError
        If it is damaged, or unpacks to more than a map may take.
    InsufficientMemoryError
        If it unpacks to more than the memory that is free.
    """
    with path.open("rb") as stream:
        packed = stream.read(2) == _GZIP
    if not packed:
        yield path
        return
    with tempfile.TemporaryDirectory(prefix="roughcontact-") as folder:
        copy = Path(folder) / path.name
        _unpack(path, copy)
        yield copy


def _unpack(path: Path, target: Path) -> None:
    """Write what gzip has packed into a file, as far as a map may go."""
    packed, size = path.stat().st_size, 0
    most = min(limits.most_unpacked(packed), memory.free())
    try:
        with gzip.open(path) as source, target.open("xb") as copy:
            while size <= most and (block := source.read(_BLOCK)):
                size += copy.write(block)
    except (EOFError, gzip.BadGzipFile, zlib.error) as error:
        raise FormatError(
            f"{path.name} cannot be unpacked ({error}); check that the file is complete"
        ) from None
    limits.require_size(path.name, size, packed=packed)


def check_method(path: Path, member: zipfile.ZipInfo) -> None:
    """Refuse a member that is packed in a way in which a block may unpack to any size."""
    if member.compress_type not in _METHODS:
        raise FormatError(
            f"{path.name} holds {member.filename!r} packed by another method than deflate; pack "
            "it again as an ordinary ZIP archive"
        )


def _check_member(path: Path, archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> None:
    try:
        with archive.open(member) as stream:
            start = stream.read(_BLOCK)
            if member.file_size > limits.TEXT and start.startswith(_XML):
                raise FormatError(
                    f"{path.name} holds the text {member.filename!r} of "
                    f"{member.file_size / 2**20:.0f} MiB, too long for a header; check where the "
                    "file is from"
                )
            while stream.read(_BLOCK):
                pass
    except zipfile.BadZipFile:
        raise ValueError(f"the checksum of {member.filename!r} in the archive is wrong") from None


def check_streams(path: Path) -> None:
    """Refuse a file in which streams of zlib unpack to more than a map may take.

    Parameters
    ----------
    path : Path
        The file: of a format that packs without an archive and states no sizes that bind, such as
        compressed TIFF.

    Raises
    ------
    FormatError, InsufficientMemoryError
        As `limits.require_size`.
    """
    packed, unpacked, place = path.stat().st_size, 0, 0
    most = limits.most_unpacked(packed)
    with (
        path.open("rb") as stream,
        mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as content,
    ):
        while unpacked <= most and (found := _ZLIB.search(content, place)):
            # Two bytes of a height may look like a start; what follows soon shows that they are
            # none.
            size, end = _unpacked(content, found.start(), most - unpacked)
            unpacked, place = unpacked + size, end
    limits.require_size(path.name, unpacked, packed=packed)


def _unpacked(content: mmap.mmap, start: int, most: int) -> tuple[int, int]:
    """Return the size of what is packed in a stream, and where to go on."""
    unpacking, size, place = zlib.decompressobj(), 0, start
    rest = b""
    try:
        while size <= most and not unpacking.eof and (rest or place < len(content)):
            if not rest:
                rest = content[place : place + _BLOCK]
                place += len(rest)
            size += len(unpacking.decompress(rest, _BLOCK))
            rest = unpacking.unconsumed_tail
    except zlib.error:
        return size, start + 1
    if unpacking.eof:
        return size, place - len(unpacking.unused_data)
    return size, start + 1
