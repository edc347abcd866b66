"""Matrices of plain numbers: NumPy and HDF5 files, and text with one line per row."""

from __future__ import annotations

import io
import itertools
import math
import re
import sys
import zipfile
from array import array
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import IO, Any, NamedTuple, TextIO

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from roughcontact import units
from roughcontact._tools import memory, netcdf
from roughcontact._tools.arrays import Array
from roughcontact.errors import ArgumentRef, FormatError, InputError
from roughcontact.formats import content, source, text_files
from roughcontact.formats.source import (
    Channel,
    ReadOptions,
    damage_as_error,
    is_length,
    make_surface,
    one_line,
    refuse_unit,
    unit_in_meters,
)
from roughcontact.formats.text_files import Head
from roughcontact.surface.grid import PROFILE_WIDTH
from roughcontact.surface.provenance import Operation, Provenance
from roughcontact.surface.surface import Surface
from roughcontact.units import count_noun

# Headers have a hundred bytes; NumPy rejects those of more than ten thousand.
_MAX_HEAD_BYTES = 2**16
_SUFFIX = ".npy"


class NumpyHead(NamedTuple):
    """Header of a NumPy array."""

    shape: tuple[int, ...]  # Points along each axis
    dtype: np.dtype[Any]  # Type of its numbers

    @property
    def size(self) -> int:
        """Bytes of its numbers."""
        return math.prod(self.shape) * self.dtype.itemsize


_NO_ARRAY = NumpyHead((), np.dtype("V"))


@dataclass(frozen=True)
class Arrays:
    """Arrays in a NumPy file."""

    path: Path  # The file
    heads: Mapping[str, NumpyHead]  # Headers by name, in the order of the file

    def load_array(self, name: str) -> NDArray[Any]:
        """Return an array; a ``.npy`` file is memory-mapped."""
        memory.require_size(self.path.name, self.heads[name].size)
        with _errors(self.path):
            if not name:
                return np.load(self.path, mmap_mode="r", allow_pickle=False)
            # The checksum is verified when the last byte is read.
            with zipfile.ZipFile(self.path) as archive, archive.open(name + _SUFFIX) as stream:
                values: NDArray[Any] = npy.read_array(stream, allow_pickle=False)
                _check_letters(values)
                return values


# Last part of the name of an array of the same shape -> its value at missing points.
_MASKS = {"mask": True, "invalid": True, "missing": True, "valid": False}


def _mask_value(name: str) -> bool | None:
    """Return the value at missing points of an array that is a mask; None for other arrays."""
    return _MASKS.get(name.rpartition("/")[2].lower())


def _mask_missing(
    values: NDArray[Any],
    name: str,
    shapes: Mapping[str, tuple[int, ...]],
    load: Callable[[str], NDArray[Any]],
) -> NDArray[Any]:
    """Return an array with NaN where a mask next to it, and of its shape, marks missing points."""
    for other in shapes.keys() - {name}:
        value = _mask_value(other)
        is_near = other.rpartition("/")[0] == name.rpartition("/")[0]
        if value is not None and is_near and shapes[other] == shapes[name]:
            values = np.where(load(other).astype(bool) == value, np.nan, values)
    return values


def open_arrays(path: Path, kind: str) -> Arrays:
    """Return the arrays of a file."""
    with _errors(path):
        if kind == "npz":
            return Arrays(path, dict(_members(path)))
        with path.open("rb") as stream:
            return Arrays(path, {"": _head(stream, path.stat().st_size)})


def _members(path: Path) -> Iterator[tuple[str, NumpyHead]]:
    """Yield name and header of the arrays in an archive."""
    with zipfile.ZipFile(path) as archive:
        for member in archive.infolist():
            source.check_method(path, member)
            name = member.filename.removesuffix(_SUFFIX)
            if name == member.filename:
                yield name, _NO_ARRAY
                continue
            with archive.open(member) as stream:
                yield name, _head(stream, member.file_size)


def _head(stream: IO[bytes], size: int) -> NumpyHead:
    """Return the header of an array in a file or archive member of the given size."""
    start = io.BytesIO(stream.read(_MAX_HEAD_BYTES))
    version = npy.read_magic(start)
    if version == (3, 0):
        # Field names in Unicode, hence not a matrix.
        return _NO_ARRAY
    read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
    shape, _, dtype = read(start)
    head = NumpyHead(shape, dtype)
    if dtype.hasobject:
        raise ValueError("Python objects instead of numbers")
    spare = size - start.tell() - head.size
    if spare:
        raise ValueError(f"shape {shape} of {dtype} leaves {spare} bytes of the file unused")
    return head


def _check_letters(values: NDArray[Any]) -> None:
    """Raise `ValueError` for text with invalid code points; NumPy accepts any number."""
    if values.dtype.kind == "U" and values.dtype.itemsize:
        numbers = np.atleast_1d(values).view(values.dtype.byteorder + "u4")
        if numbers.max(initial=0) > sys.maxunicode:
            raise ValueError("text with invalid characters")


def _errors(path: Path) -> AbstractContextManager[None]:
    return damage_as_error(
        path, "a file of NumPy", "save a real array with numpy.save or numpy.savez"
    )


# Unit [m] and pixel [m].
Scale = tuple[float, tuple[float, float]]

TEXT_MARK = "# roughcontact map"
"""First line of a text matrix whose header gives its quantity, unit and pixel."""

# Maximum number of characters of a line, and memory for reading in bytes per point.
_MAX_LINE_BYTES = 32 * 2**20
_BYTES_PER_POINT = 20

_NO_DATA = re.compile(r"no\s+data", re.IGNORECASE)
_MISSING = re.compile(r"|nan|n/?a|bad|\*+|-{2,}", re.IGNORECASE)
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?")
# Exponents of Fortran; minus sign and thousands separator of spreadsheets, Japanese parentheses.
_FORTRAN = re.compile(r"([+-]?\d*\.?\d+\.?)[dD]([+-]?\d+)")
_TYPED = str.maketrans({"\u2212": "-", "\u202f": None, "\uff08": "(", "\uff09": ")"})
# A decimal comma, or an integer or missing point in the same row.
_WITH_COMMA = re.compile(rf"{_DECIMAL_COMMA.pattern}|[+-]?\d+|nan|bad", re.IGNORECASE)
# Suffix of files that list points x, y, z.
_POINTS = ".xyz"


def read_text(path: Path, name: str, requested: ReadOptions) -> Surface:
    """Return the map in a text: a matrix, or points x, y, z on a grid."""
    if requested.channel is not None:
        raise InputError(
            f"{path.name} has no channels; leave out ", ArgumentRef("channel", requested.channel)
        )
    scale = _scale_in_text(path)
    if scale is not None:
        values, steps = _read_text(path)
        requested.check_shape(values.shape)
        about = Provenance(path.name, f"matrix ({name})", "", steps)
        return _scale_matrix(path, values, about, scale, requested)
    head, values, steps, trace = _read_table(path)
    if trace is not None:
        return text_files.read_trace(path, trace, requested)
    if head.skipped:
        steps += (f"read: {count_noun(head.lines, 'line')} above the numbers skipped",)
    if _lists_points(path, values, head):
        return map_of_points(path, name, values, head, steps, requested)
    if min(values.shape) == 1 and values.size >= text_files.MIN_POINTS:
        return text_files.read_single_column(path, values.ravel(), requested)
    values = _apply_head(path, values, head)
    requested.check_shape(values.shape)
    metre, text = _height_unit(path, head, requested)
    _require_map(path, values.shape, values.dtype, None)
    ny, nx = values.shape
    about = Provenance(path.name, f"matrix ({name})", head.channel, (*steps, *text))
    stated = head.pixel_of((ny, nx))
    return make_surface(path, values, metre * head.factor, requested, about, stated)


def text_channels(path: Path, name: str) -> tuple[Channel, ...]:
    """Return the map or profile in a text file as its only channel."""
    stated = _head_of_text(path)
    if stated:
        quantity, unit = stated.get("quantity", ""), stated.get("unit", "")
        values, _ = _read_text(path)
        return (Channel(quantity, unit, quantity == "height", values.shape),)
    head, values, _, trace = _read_table(path)
    if trace is not None:
        return (Channel("", trace.units[1], True, (1, len(trace.columns))),)
    if _lists_points(path, values, head):
        values = text_files.grid_points(path, values)[0]
    elif values.shape[1] == 1:
        values = values.T
    else:
        values = _apply_head(path, values, head)
    return (Channel(head.channel, head.unit, True, values.shape),)


def _read_table(path: Path) -> tuple[Head, Array, tuple[str, ...], text_files.Trace | None]:
    """Return header, values and notes of a text of another program, and its profile, if any."""
    with _open_lines(path, errors="replace") as lines:
        head = text_files.parse_head(path, lines)
    if head.values is not None:
        return head, head.values, (), None
    try:
        values, steps = _read_text(path, head.lines)
        trace = None if head.is_map else text_files.find_trace(path, values, head)
    except FormatError:
        if not head.doubtful:
            raise
        trace = None
    if trace is None and head.doubtful:
        # A damaged row above the numbers raises an error here.
        head = replace(head, lines=head.lines - head.doubtful)
        values, steps = _read_text(path, head.lines)
    return head, values, steps, trace


def _lists_points(path: Path, values: Array, head: Head) -> bool:
    """Return whether a text lists points x, y, z, by its header or by its numbers."""
    is_named = path.suffix.lower() == _POINTS
    if values.shape[1] > 3 and (is_named or text_files.look_like_points(values[:, :3])):
        raise FormatError(
            f"{path.name} lists points in {values.shape[1]} columns; keep x, y and the heights"
        )
    if values.shape[1] != 3 or head.sides or head.pixel:
        return False
    is_named = is_named or head.columns or head.lateral is not None
    return is_named or text_files.look_like_points(values)


def map_of_points(
    path: Path, name: str, values: Array, head: Head, steps: tuple[str, ...], requested: ReadOptions
) -> Surface:
    """Return the map of points x, y, z on a grid; the header may give different units."""
    heights, steps_apart, absent = text_files.grid_points(path, values)
    requested.check_shape(heights.shape)
    said = [] if requested.unit is None else [word.strip() for word in requested.unit.split(",")]
    if len(said) > 1:
        # As for profiles, the unit of the coordinates comes first.
        requested = replace(requested, unit=",".join(said[1:]))
        head = replace(head, lateral=unit_in_meters(path, said[0]))
    metre, text = _height_unit(path, head, requested)
    lateral = metre if head.lateral is None else head.lateral
    stated = (steps_apart[0] * lateral, steps_apart[1] * lateral) if lateral else None
    note = f"read: {values.shape[0]} points x, y, z placed on their grid"
    if absent:
        note += f", {absent} of it without a point"
    about = Provenance(path.name, f"points ({name})", head.channel, (*steps, *text, note))
    return make_surface(path, heights, metre * head.factor, requested, about, stated)


def _apply_head(path: Path, values: Array, head: Head) -> Array:
    """Return a matrix as described by its header, with rows along y; raise for a profile."""
    if not head.is_map:
        _refuse_points(path, values)
    if head.turned:
        values = np.ascontiguousarray(values.T)
    if head.points is not None and head.points != values.shape:
        ny, nx = head.points
        raise FormatError(
            f"{path.name} announces {ny} × {nx} points, but has {values.shape[0]} × "
            f"{values.shape[1]}; check that the file is complete"
        )
    return values


def _height_unit(path: Path, head: Head, requested: ReadOptions) -> tuple[float, tuple[str, ...]]:
    """Return the unit [m] of the heights, and notes; the caller's unit overrides the file."""
    if requested.unit is None or not head.unit:
        return unit_in_meters(path, head.unit or requested.unit), ()
    metre = unit_in_meters(path, requested.unit)
    if metre == unit_in_meters(path, head.unit):
        return metre, ()
    return metre, (
        f"read: heights in {requested.unit}, as given, instead of {head.unit} in the file",
    )


def read_arrays(path: Path, name: str, requested: ReadOptions) -> Surface:
    """Return the map in a NumPy file; ``name`` is the format, an array or an archive."""
    arrays = open_arrays(path, name)
    scale = _scale_in_arrays(path, arrays) if requested.channel in (None, "heights") else None
    names = list(arrays.heads)
    if requested.channel is None:
        names = [name for name in names if _mask_value(name) is None] or names
    channel = choose_array(path, names, requested.channel if scale is None else "heights")
    head = arrays.heads[channel]
    line = len(head.shape) == 1 and head.shape[0] >= text_files.MIN_POINTS
    if scale is None and line and head.dtype.kind in "fiu":
        memory.require_points(path.name, head.shape, _BYTES_PER_POINT)
        return text_files.read_single_column(path, arrays.load_array(channel), requested)
    _require_map(path, head.shape, head.dtype, scale)
    memory.require_points(path.name, head.shape, _BYTES_PER_POINT)
    requested.check_shape(head.shape)
    provenance = Provenance(path.name, f"matrix ({name})", channel)
    values = arrays.load_array(channel)
    shapes = {name: found.shape for name, found in arrays.heads.items()}
    values = _mask_missing(values, channel, shapes, arrays.load_array)
    if scale is None:
        trace = text_files.read_columns(values)
        if trace is not None:
            return text_files.read_trace(path, trace, requested)
        return scale_array(path, values, provenance, "", requested)
    return _scale_matrix(path, values, provenance, scale, requested)


def array_channels(path: Path, name: str) -> tuple[Channel, ...]:
    """Return the arrays in a NumPy file."""
    heads = open_arrays(path, name).heads
    return tuple(
        Channel(name, "", len(head.shape) == 2, head.shape) for name, head in heads.items()
    )


def _require_map(
    path: Path, shape: tuple[int, ...], dtype: np.dtype[Any], scale: Scale | None
) -> None:
    if shape[:1] == (1,) and scale is not None and scale[1][0] == PROFILE_WIDTH:
        # A profile, as this package stores it.
        shape = (2, *shape[1:])
    if dtype.kind not in "fiu" or len(shape) != 2 or min(shape) < 2:
        raise FormatError(
            f"{path.name} must hold a matrix of at least 2 × 2 real numbers, got {dtype} of shape "
            f"{shape}"
        )


def scale_array(
    path: Path,
    values: NDArray[Any],
    provenance: Provenance,
    unit: str,
    requested: ReadOptions,
    stated: tuple[float, float] | None = None,
) -> Surface:
    """Return the map of an array with or without a unit and a pixel [m]."""
    _require_map(path, values.shape, values.dtype, None)
    _refuse_points(path, values)
    _refuse_list(path, values)
    metre, notes = _height_unit(path, Head(0, unit=unit), requested)
    for text in notes:
        provenance = provenance.then(Operation.note(text))
    return make_surface(path, values, metre, requested, provenance, stated)


def _scale_matrix(
    path: Path, values: NDArray[Any], provenance: Provenance, scale: Scale, requested: ReadOptions
) -> Surface:
    """Return the map of a matrix whose scale is given by the file."""
    _require_map(path, values.shape, values.dtype, scale)
    refuse_unit(path, requested)
    # Files of this program have NaN for missing points.
    return make_surface(path, values, scale[0], requested, provenance, scale[1], marks_missing=True)


@contextmanager
def _name_file_in_errors(path: Path) -> Iterator[None]:
    """Convert an error about a quantity into one about the file that contains it."""
    try:
        yield
    except InputError as error:
        raise FormatError(f"{path.name} states its scale wrongly: {error}") from None


def _head_of_text(path: Path) -> dict[str, str]:
    """Return the header of a text matrix; empty without a header of this package."""
    with _open_lines(path, errors="replace") as lines:
        if next(lines, "").strip() != TEXT_MARK:
            return {}
        head = itertools.takewhile(lambda line: line.startswith("#"), lines)
        parts = (line[1:].partition(":") for line in head)
        return {name.strip(): value.strip() for name, mark, value in parts if mark}


@contextmanager
def _open_lines(path: Path, errors: str = "strict") -> Iterator[Iterator[str]]:
    """Yield the lines of a text; raise `FormatError` if it cannot be read."""
    try:
        with content.open_text(path, errors=errors) as stream:
            yield _lines(path, stream)
    except OSError as error:
        raise FormatError(f"{path.name} cannot be read ({one_line(error)})") from None


def _lines(path: Path, stream: TextIO) -> Iterator[str]:
    """Yield the lines of a text; raise for lines beyond the memory, or that are no text."""
    number = 0
    while line := stream.readline(_MAX_LINE_BYTES):
        number += 1
        if len(line) == _MAX_LINE_BYTES:
            raise FormatError(
                f"{path.name} has more than {_MAX_LINE_BYTES // 2**20} million characters in line "
                f"{number}; a text matrix has one row of the map a line"
            )
        if "\0" in line:
            raise FormatError(
                f"{path.name} is no plain text, or damaged: line {number} has a character of code "
                "zero; copy it again"
            )
        yield line if line.isascii() else line.translate(_TYPED)


def _scale_in_text(path: Path) -> Scale | None:
    """Return unit [m] and pixel [m] in the header of a text matrix."""
    stated = _head_of_text(path)
    if not stated:
        return None
    absent = [name for name in ("quantity", "unit", "pixel_y", "pixel_x") if name not in stated]
    if absent:
        raise FormatError(
            f"{path.name} lacks {', '.join(absent)} in its head; complete it, or remove the line "
            f"{TEXT_MARK!r} and give {ArgumentRef('unit')} and {ArgumentRef('size')}"
        )
    if stated["quantity"] != "height":
        raise FormatError(f"{path.name} holds {stated['quantity']!r}, no heights")
    with _name_file_in_errors(path):
        metre = unit_in_meters(path, stated["unit"])
        dy, dx = (units.parse(stated[name], "length", name) for name in ("pixel_y", "pixel_x"))
    return metre, (dy, dx)


def _scale_in_arrays(path: Path, arrays: Arrays) -> Scale | None:
    """Return unit [m] and pixel [m] stored in a NumPy archive with its heights."""
    heads = arrays.heads
    if not {"heights", "pixel", "unit"} <= heads.keys():
        return None
    edges, word = heads["pixel"], heads["unit"]
    if edges.shape != (2,) or edges.dtype.kind not in "fiu" or word.dtype.kind != "U" or word.shape:
        raise FormatError(
            f"{path.name} must hold two numbers (dy, dx) as pixel and a word as unit, got "
            f"{edges.dtype} of shape {edges.shape} and {word.dtype} of shape {word.shape}"
        )
    pixel, unit = arrays.load_array("pixel"), arrays.load_array("unit")
    with _name_file_in_errors(path):
        metre = unit_in_meters(path, str(unit))
    return metre, (float(pixel[0]) * metre, float(pixel[1]) * metre)


def choose_array(path: Path, names: list[str], channel: str | int | None) -> str:
    """Return the name of the requested array of a file: by name, by index, or the only one."""
    if channel is None and len(names) == 1:
        return names[0]
    listing = "; ".join(f"{index}: {name!r}" for index, name in enumerate(names)) or "none"
    if channel is None:
        raise InputError(
            f"{path.name} holds the arrays {listing}; choose one with {ArgumentRef('channel')}"
        )
    if channel in names:
        return str(channel)
    if not isinstance(channel, bool) and re.fullmatch(r"\d{1,6}", str(channel)):
        index = int(channel)
        if index < len(names):
            return names[index]
    raise InputError(f"{path.name} has no array {channel!r}; it holds {listing}")


def _read_text(path: Path, head: int = 0) -> tuple[Array, tuple[str, ...]]:
    """Return the matrix in a text file below its header, and notes on reading it."""
    values, trailing, ended = array("d"), True, True
    marks: set[str] = set()
    first, columns, room = 0, 0, 0
    delimiter: str | None = None
    try:
        with _open_lines(path) as lines:
            for number, line in enumerate(lines, start=1):
                ended = line.endswith("\n")
                if number <= head:
                    continue
                if head and line.startswith("#") and text_files.starts_new_map(line):
                    raise FormatError(
                        f"{path.name} holds several maps, another from line {number} on; export "
                        "each into its own file"
                    )
                text = _unquote(line.split("#", 1)[0].strip(" \r\n"))
                if not text.strip():
                    continue
                if not first:
                    delimiter = _delimiter(text)
                cells = text.split(delimiter)
                trailing = trailing and delimiter is not None and not cells[-1].strip()
                commas = bool(marks)
                row = _row(path, cells, number, delimiter, marks)
                # Earlier fractions, before the first decimal comma, had decimal points.
                if marks and not commas and any(z % 1 for z in values if not math.isnan(z)):
                    raise _mixed_separators(path, number)
                if not first:
                    first, columns = number, len(row)
                if len(row) != columns:
                    raise FormatError(
                        f"{path.name} has {len(row)} numbers in line {number} but {columns} in "
                        f"line {first}; all rows must be of one length"
                    )
                if len(values) >= room:
                    # One row per remaining line, or a tenth more than expected.
                    rows = len(values) // columns
                    more = 1 + (rows // 10 if rows else path.stat().st_size // len(line))
                    room = (rows + more) * columns
                    memory.require_points(path.name, (rows + more, columns), _BYTES_PER_POINT)
                values.extend(row)
    except UnicodeDecodeError:
        raise FormatError(
            f"{path.name} is no plain text; save it as a plain text matrix, or give its "
            f"{ArgumentRef('format')}"
        ) from None
    if not values:
        raise FormatError(f"{path.name} holds no numbers; a matrix of heights was expected")
    return _interpret_matrix(
        np.frombuffer(values).reshape(-1, columns), trailing, ended, "," in marks
    )


def _interpret_matrix(
    matrix: Array, trailing: bool, ended: bool, commas: bool
) -> tuple[Array, tuple[str, ...]]:
    """Return a matrix after interpretation of its text, and notes."""
    steps: tuple[str, ...] = ("read: decimal commas",) if commas else ()
    if math.isnan(matrix[0, 0]) and all(map(_is_even, (matrix[0, 1:], matrix[1:, 0]))):
        matrix = np.ascontiguousarray(matrix[1:, 1:])
        steps += ("read: the numbers or coordinates of rows and columns are no heights",)
    # Many programs end each row with the delimiter, which is not a column.
    if trailing and matrix.shape[1] > 1:
        matrix = matrix[:, :-1]
        steps += ("read: the delimiter at the end of every row is no column",)
    if not ended:
        # A file that was cut off misses rows without a sign, while the sides are for all rows.
        steps += ("read: the last row has no line end; check that the file was not cut off",)
    return matrix, steps


def _is_even(line: Array) -> bool:
    """Return whether numbers rise in equal steps, to their printed digits."""
    steps = np.diff(line)
    return line.size > 1 and bool(steps.min() > 0.9 * steps.max() > 0)


def _unquote(text: str) -> str:
    """Return a line without quotation marks and with one word for missing points."""
    if '"' in text:
        # The delimiter between quoted cells is no decimal comma.
        text = text.replace('","', '";"').replace('"', "")
    return _NO_DATA.sub("nan", text) if "o" in text.lower() else text


def _delimiter(line: str) -> str | None:
    for mark in (";", "\t"):
        if mark in line:
            return mark
    words = line.split()
    # None splits at any white space.
    if "," in line and len(words) > 1 and all(map(_WITH_COMMA.fullmatch, words)):
        return None
    return "," if "," in line else None


def _row(
    path: Path, cells: list[str], number: int, delimiter: str | None, marks: set[str]
) -> list[float]:
    """Return the numbers of a line; ``marks`` collects the decimal marks of the file."""
    values = []
    for position, cell in enumerate(cells, start=1):
        try:
            value = float(cell)
        except ValueError:
            value = _parse_cell(path, cell.strip(), number, position, delimiter, marks)
        else:
            # Python's float() reads 1_0 as ten; no instrument writes that.
            if "_" in cell or math.isinf(value):
                raise FormatError(
                    f"{path.name} has {cell.strip()[:40]!r} in line {number}, cell {position}; "
                    "write finite numbers, and nan for missing points"
                )
            if marks and "." in cell:
                raise _mixed_separators(path, number)
        values.append(value)
    return values


def _parse_cell(
    path: Path, word: str, number: int, position: int, delimiter: str | None, marks: set[str]
) -> float:
    """Return the value of a cell that is not a number with a decimal point."""
    if _MISSING.fullmatch(word):
        return math.nan
    if delimiter != "," and _DECIMAL_COMMA.fullmatch(word):
        marks.add(",")
        return float(word.replace(",", "."))
    if (fortran := _FORTRAN.fullmatch(word)) is not None:
        return float("e".join(fortran.groups()))
    raise FormatError(
        f"{path.name} has {word[:40]!r} in line {number}, cell {position}, where a number was "
        "expected; correct it, or write nan where a height is missing"
    )


def _mixed_separators(path: Path, number: int) -> FormatError:
    return FormatError(
        f"{path.name} has decimal points and, by line {number}, decimal commas; write one of both"
    )


def _refuse_points(path: Path, matrix: NDArray[Any]) -> None:
    """Raise `InputError` for coordinates next to the heights, which resemble a narrow map."""
    for pairs in (matrix, matrix.T):
        if text_files.read_columns(pairs) or text_files.read_columns(pairs[:, ::-1]):
            raise FormatError(
                f"{path.name} looks like a profile, {pairs.shape[0]} points x, z: write them in "
                "two columns, the positions first"
            )


def _refuse_list(path: Path, matrix: NDArray[Any]) -> None:
    """Raise `InputError` for an array of points x, y, z, which resembles a narrow map."""
    if text_files.look_like_points(matrix.astype(np.float64)):
        raise FormatError(
            f"{path.name} looks like a list of points x, y, z; write the heights as a matrix with "
            "one row of the map per line, or the points as text"
        )


# Names of attributes with the unit.
_UNIT_NAMES = ("unit", "units", "Unit", "Units")


def read_hdf5(path: Path, name: str, requested: ReadOptions) -> Surface:
    """Return a matrix of an HDF5 file; its rows run along y."""
    result = hdf5_channels(path, name)
    listed = [entry.name for entry in result]
    heights = [entry.name for entry in result if entry.is_height]
    names = listed if requested.channel is not None else heights or listed
    index = listed.index(choose_array(path, names, requested.channel))
    shape, unit = result[index].shape, result[index].unit
    memory.require_points(path.name, shape, _BYTES_PER_POINT)
    requested.check_shape(shape)
    values = _values(path, listed[index])
    shapes = {entry.name: entry.shape for entry in result}
    values = _mask_missing(values, listed[index], shapes, partial(_values, path))
    about = Provenance(path.name, "matrix (hdf5)", listed[index] if len(listed) > 1 else "")
    return scale_array(path, values, about, unit, requested)


def hdf5_channels(path: Path, name: str) -> tuple[Channel, ...]:
    """Return the matrices of real numbers in an HDF5 file."""
    with content.hdf5_errors(path):
        stored = netcdf.check_hdf5(path)
        import h5py

        with h5py.File(path, "r") as file:
            listed = tuple(
                Channel(array, _unit(file[array]), _mask_value(array) is None, said.shape)
                for array, said in stored.items()
                if len(said.shape) == 2 and min(said.shape) > 1 and said.kind in tuple("fiub")
            )
    if not listed:
        raise FormatError(f"{path.name} holds no matrix of at least 2 × 2 real numbers")
    return listed


def _values(path: Path, array: str) -> Any:
    import h5py

    with content.hdf5_errors(path), h5py.File(path, "r") as file:
        return np.asarray(file[array][()])


def _unit(array: Any) -> str:
    """Return the unit of length of an array; empty if it has none."""
    for name in _UNIT_NAMES:
        said = array.attrs.get(name)
        text = said.decode("utf-8", "replace") if isinstance(said, bytes) else said
        if isinstance(text, str) and is_length(Path(), text):
            return text
    return ""
