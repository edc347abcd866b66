"""Common parts of all readers: options, channels, units and error messages.

`check_archive`: A member is read up to the size that the archive states, even if it unpacks to
more; with a damaged length, readers would stop before the checksum.
"""

from __future__ import annotations

import errno
import gzip
import io
import math
import os
import re
import tempfile
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact import units
from roughcontact._tools import files, memory
from roughcontact._tools.arrays import Array, Shape
from roughcontact._tools.text import join_words
from roughcontact.errors import (
    ArgumentRef,
    FormatError,
    InputError,
    RoughcontactError,
    input_error,
    shorten_value,
)
from roughcontact.formats.no_data import parse_no_data
from roughcontact.surface.grid import PROFILE_WIDTH
from roughcontact.surface.provenance import Operation, Provenance
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantities, to_si

_METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_XML = (b"<", b"\xef\xbb\xbf<", b"\xff\xfe<", b"\xfe\xff\0<")

_GZIP = b"\x1f\x8b"


def check_archive(path: Path) -> None:
    """Raise `FormatError` for an archive that is damaged or too large when unpacked."""
    check_sizes(path)
    with zipfile.ZipFile(path) as archive:
        for member in archive.infolist():
            with archive.open(member) as stream:
                is_xml = stream.read(len(_XML[1])).startswith(_XML)
            if is_xml and member.file_size > memory.TEXT:
                raise FormatError(
                    f"{path.name} holds the text {member.filename!r} of "
                    f"{member.file_size / 2**20:.0f} MiB, too long for a header; check where the "
                    "file is from"
                )
        damaged = archive.testzip()
    if damaged is not None:
        raise ValueError(f"the checksum of {damaged!r} in the archive is wrong")


def check_sizes(path: Path) -> int:
    """Raise `FormatError` for an archive with too large members or an unusual compression."""
    with zipfile.ZipFile(path) as archive:
        members = archive.infolist()
    size = sum(member.file_size for member in members)
    memory.require_size(path.name, size, packed=path.stat().st_size)
    for member in members:
        check_method(path, member)
    return size


@contextmanager
def open_gzip(path: Path) -> Iterator[Path]:
    """Yield the uncompressed file of a gzip file under its original name."""
    with path.open("rb") as stream:
        packed = stream.read(2) == _GZIP
    if not packed:
        yield path
        return
    with tempfile.TemporaryDirectory(prefix="roughcontact-") as folder:
        copy = Path(folder) / path.name
        _decompress(path, copy)
        yield copy


def _decompress(path: Path, target: Path) -> None:
    """Write the content of a gzip file to a file, up to the maximum size of a map."""
    packed, size = path.stat().st_size, 0
    maximum = min(memory.max_unpacked_bytes(packed), memory.free_bytes())
    try:
        with gzip.open(path) as source, target.open("xb") as copy:
            while size <= maximum and (block := source.read(BLOCK)):
                size += copy.write(block)
    except (EOFError, OSError, zlib.error) as error:
        require_space(path, error)
        raise FormatError(
            f"{path.name} cannot be unpacked ({error}); check that the file is complete"
        ) from None
    memory.require_size(path.name, size, packed=packed)


def check_method(path: Path, member: zipfile.ZipInfo) -> None:
    """Raise `FormatError` for a compression whose blocks may unpack to any size."""
    if member.compress_type not in _METHODS:
        raise FormatError(
            f"{path.name} holds {member.filename!r} packed by another method than deflate; pack "
            "it again as an ordinary ZIP archive"
        )


@dataclass(frozen=True)
class Channel:
    """One channel of a file."""

    name: str  # Name in the file
    unit: str  # Unit of the values as the file gives it
    is_height: bool  # Whether the channel contains heights, by name and unit
    shape: tuple[int, ...]  # Grid points `(ny, nx)`


@dataclass(frozen=True)
class ReadOptions:
    """Options for reading a file; see `roughcontact.read_surface`."""

    channel: str | int | None = None
    unit: str | None = None
    size: Quantities | str | None = None
    override_size: bool = False
    no_data: float | str | None = None
    announced: Callable[[tuple[int, int]], None] | None = None

    def __post_init__(self) -> None:
        """Convert a size to meters unless it is a text."""
        if not isinstance(self.size, str):
            object.__setattr__(self, "size", to_si(self.size, "length", "size"))
        object.__setattr__(self, "no_data", parse_no_data(self.no_data))

    def check_shape(self, shape: tuple[int, ...]) -> None:
        """Report the shape of the map to the caller before its heights are read."""
        if self.announced is not None:
            ny, nx = shape
            self.announced((ny, nx))


@dataclass(frozen=True)
class InputFormat:
    """Input format of maps: a row of the table in `roughcontact.formats.read`."""

    name: str  # Value of `format` of `roughcontact.read_surface`
    suffixes: tuple[str, ...]  # Suffixes of its files
    read: Callable[[Path, str, ReadOptions], Surface]  # Returns the map of a file, by format
    channels: Callable[[Path, str], tuple[Channel, ...]]
    has_codes: bool = False  # Whether values may encode missing points


@contextmanager
def open_existing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield an existing file that is not empty and can be opened again and searched."""
    path = Path(path)
    with ExitStack() as stack:
        try:
            if path.is_dir():
                raise FormatError(f"{path} is a directory; give the file with the height map")
            if not path.exists():
                raise FormatError(
                    f"{shorten_value(path)} does not exist; check the name of the file"
                )
            file = stack.enter_context(files.as_regular_file(path))
            with file.open("rb"):
                empty = not file.stat().st_size
            file = stack.enter_context(open_gzip(file))
        except FormatError:
            raise
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise FormatError(
                f"{shorten_value(path)} cannot be opened ({reason}); check the file"
            ) from None
        if empty:
            raise FormatError(f"{path} is empty; export or copy the measurement again")
        yield file


def make_surface(
    path: Path,
    values: NDArray[Any],
    metre: float,
    requested: ReadOptions,
    provenance: Provenance,
    stated: tuple[float, float] | None = None,
    **details: object,
) -> Surface:
    """Return a map from its values in a unit [m]; ``details`` are for `read.read_surface`."""
    pixel, heights = resolve_pixel(path, stated, values.shape, requested), to_meters(values, metre)
    result: dict[str, object] = {"unit": metre}
    if stated is not None and stated != pixel:
        sides = [n * edge for n, edge in zip(heights.shape, stated, strict=True)]
        result["stated_size"] = sides[heights.shape[0] == 1 :]
    origin = Operation("read_surface", {"path": path.name}, result | details)
    try:
        return Surface(heights, pixel, replace(provenance, origin=origin))
    except InputError as error:
        raise FormatError(f"{path.name} holds no height map that can be used: {error}") from None


@contextmanager
def damage_as_error(path: Path, kind: str, advice: str) -> Iterator[None]:
    """Convert any error in the content of a file into a `FormatError`."""
    try:
        yield
    except RoughcontactError:
        raise
    # Damaged files raise ValueError, BadZipFile, EOFError, KeyError, MemoryError and others.
    except Exception as error:
        require_space(path, error)
        raise FormatError(
            f"{path.name} cannot be read as {kind} ({one_line(error)}); {advice}"
        ) from None


def import_optional(path: Path, name: str) -> Any:
    """Return a module of the extra ``io``; raise `FormatError` if it cannot be imported."""
    try:
        return import_module(name)
    except ImportError as error:
        raise FormatError(
            f"{path.name} needs {name.partition('.')[0]}, which cannot be imported "
            f"({one_line(error)}); run pip install 'roughcontact[io]'"
        ) from None


def require_space(path: Path, error: BaseException) -> None:
    """Raise `FormatError` if an error while a file was unpacked is a full disk."""
    if isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT):
        raise FormatError(
            f"{path.name} cannot be unpacked: {tempfile.gettempdir()} has no space left; free some "
            "space, or set TMPDIR to another folder"
        ) from None


def one_line(error: BaseException) -> str:
    """Return the error message of another library in one line."""
    if isinstance(error, MemoryError):
        return "it needs more memory than is free"
    # Readers quote unexpected bytes.
    text = join_words(str(error)) or "no reason given"
    return f"{type(error).__name__}: {text if len(text) <= 160 else text[:159] + '…'}"


BLOCK = 2**20
"""Bytes per block; divisible by the size of every number."""


class BoundedStream(io.BufferedReader):
    """Stream that reserves no more memory for a read than the file can fill."""

    def read(self, size: int | None = -1, /) -> bytes:
        """Return the next bytes, or the remaining ones."""
        if size is not None and size > 0:
            remaining = os.fstat(self.fileno()).st_size - self.tell()
            size = min(size, max(remaining, 0))
        return super().read(size)


def little_endian(values: NDArray[Any]) -> memoryview:
    """Return the little-endian bytes of a map; without a copy on most machines."""
    little = np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("<"))
    return little.reshape(-1).view(np.uint8).data


def iter_blocks(content: bytes | memoryview) -> Iterator[memoryview]:
    """Yield bytes in blocks; the last one may be shorter."""
    view = memoryview(content)
    for start in range(0, len(view), BLOCK):
        yield view[start : start + BLOCK]


# Units of length in the spelling of instrument files, where pint has none or another meaning ("A"
# is the ampere in pint).
_FILE_UNITS = {"A": "angstrom", "Å": "angstrom"} | dict.fromkeys(
    # The micro sign, which other prefixes are not, lost, or in Japanese and Chinese encodings read
    # as Western characters.
    ("~m", "?m", "\ufffdm", "\u0192\u00cam", "\u00a6\u00ccm"),
    "um",
)

# Plausible scales [m]: from a few atoms to a machine bed.
_SIDE_RANGE = (1e-9, 10.0)
_PIXEL_RANGE = (1e-12, 1e-2)
_HEIGHT_OVER_SIDE = 100.0


def refuse_unit(path: Path, requested: ReadOptions) -> None:
    """Raise `InputError` for a unit in addition to the unit in the file."""
    if requested.unit is not None:
        raise InputError(
            f"{path.name} contains its unit; leave out ", ArgumentRef("unit", requested.unit)
        )


def resolve_pixel(
    path: Path, stated: tuple[float, float] | None, shape: tuple[int, ...], requested: ReadOptions
) -> tuple[float, float]:
    """Return the pixel of a map, from its file or from the caller."""
    if stated is not None and requested.size is None:
        return stated
    if stated is not None and not requested.override_size:
        raise InputError(
            f"{path.name} contains its size; leave out ",
            ArgumentRef("size", requested.size),
            ", or give ",
            ArgumentRef("override_size", True),
            " as well if the file is wrong",
        )
    ny, nx = shape
    return pixel_of(requested.size, (ny, nx), path.name)


def unit_in_meters(path: Path, unit: str | None) -> float:
    """Return a unit of length in the spelling of files [m]; raise without one."""
    if unit is None:
        raise InputError(
            f"{path.name} gives no unit of the heights; give it, e.g. {ArgumentRef('unit', 'um')}"
        )
    # The height of one count of an integer, "0.1 nm", is a unit as well.
    text = unit if re.match(r"\s*\.?\d", unit) else f"1 {_FILE_UNITS.get(unit, unit)}"
    return units.parse(text, "length", "unit")


def is_length(path: Path, unit: str) -> bool:
    """Return whether a unit in the spelling of files is a length."""
    try:
        unit_in_meters(path, unit)
    except InputError:
        return False
    return True


def pixel_of(
    size: units.Quantities | str | None, shape: Shape, name: str = "the map"
) -> tuple[float, float]:
    """Return the pixel of a grid over an outline."""
    ny, nx = shape
    if size is None and ny == 1:
        raise InputError(
            f"{name} is a profile and gives no length; give it, e.g. {ArgumentRef('size', '4 mm')}"
        )
    if size is None:
        raise InputError(
            f"{name} gives no lengths of its sides; give them in the order (y, x), e.g. "
            f"{ArgumentRef('size', '0.1 mm x 0.2 mm')}"
        )
    if isinstance(size, str):
        # An x that is not before a number is part of a unit.
        parts = re.split(r"\s*[x×]\s*(?=[-+\u2212.\d])", size.strip())
        sides = tuple(units.parse(part, "length", "size") for part in parts)
    else:
        try:
            specified = np.asarray(units.to_si(size, "length", "size"), dtype=float)
            sides = tuple(float(side) for side in np.atleast_1d(specified))
        except (TypeError, ValueError):
            raise input_error("size", size, "must be a pair (y, x) in meters") from None
    if ny == 1:
        # The length of a profile. A map that was cut off in its first row is not a profile.
        if len(sides) == 2 and sides[0] != PROFILE_WIDTH:
            length = units.format_engineering(sides[-1], "m")
            raise InputError(
                f"gives two sides, {size!r}, but {name} is a single line of heights; a profile has "
                "only its length, ",
                ArgumentRef("size", length),
                ", and a map more lines: was it cut off?",
                argument="size",
                value=size,
            )
        sides = (PROFILE_WIDTH, *sides[-1:])
    elif len(sides) == 1 and ny == nx:
        sides *= 2
    if len(sides) != 2:
        raise InputError(
            f"must give both sides (y, x) of a grid of {ny} × {nx} points, got {size!r}; "
            "write e.g. '0.1 mm x 0.2 mm'",
            argument="size",
            value=size,
        )
    if not all(0 < side < math.inf for side in sides):
        raise input_error("size", size, "must be positive and finite")
    return sides[0] / ny, sides[1] / nx


def to_meters(values: NDArray[Any], metre: float) -> Array:
    """Return values of a unit in meters, read-only, so that a `Surface` does not copy them."""
    # Damaged numbers overflow or are signaling NaN: `Surface` checks the values.
    with np.errstate(all="ignore"):
        heights: Array = np.array(values, dtype=np.float64, order="C")
        heights *= metre
    heights.flags.writeable = False
    return heights


def check_scale(path: Path, surface: Surface) -> None:
    """Raise `FormatError` for scales that no measured map has."""
    top, bottom = float(np.nanmax(surface.heights)), float(np.nanmin(surface.heights))
    first = int(surface.is_profile)
    sides, pixel = surface.size[first:], surface.pixel[first:]
    what = "check the unit and the size in the file"
    for name, counted, (low, high) in (
        ("sides (y, x)", sides, _SIDE_RANGE),
        ("pixel (dy, dx)", pixel, _PIXEL_RANGE),
    ):
        if not all(low <= value <= high for value in counted):
            raise FormatError(
                f"{path.name} was read with {name} of {units.format_lengths(counted)}, which is "
                f"outside {units.format_engineering(low, 'm')} to "
                f"{units.format_engineering(high, 'm')}; {what}, or replace a size that the file "
                f"has wrong by {ArgumentRef('size', '0.1 mm x 0.2 mm')} and "
                f"{ArgumentRef('override_size', True)}"
            )
    span, longest = top - bottom, max(sides)
    if span > _HEIGHT_OVER_SIDE * longest:
        raise FormatError(
            f"{path.name} was read with heights that span {units.format_engineering(span, 'm')} on "
            f"sides of {units.format_engineering(longest, 'm')}; {what}, or give the value of "
            f"points without data, e.g. {ArgumentRef('no_data', -9999.0)}"
        )
    if max(top, -bottom) > _SIDE_RANGE[1]:
        raise FormatError(
            f"{path.name} was read with heights from {units.format_engineering(bottom, 'm')} to "
            f"{units.format_engineering(top, 'm')}, further than "
            f"{units.format_engineering(_SIDE_RANGE[1], 'm')} from zero; {what}"
        )
