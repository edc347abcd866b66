"""Matrices of plain numbers: NumPy files, and text with one row of the map a line."""

from __future__ import annotations

import contextlib
import itertools
import math
import re
from array import array
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TextIO

import numpy as np
from numpy.typing import NDArray

from roughcontact import limits, units
from roughcontact.errors import FormatError, InputError, Mention
from roughcontact.formats import numpy_files, traces
from roughcontact.formats.numpy_files import Arrays
from roughcontact.formats.scale import asked_pixel, in_metres, refuse_unit, unit_in_metres
from roughcontact.formats.source import Asked, Channel, one_line, surface_of
from roughcontact.surface.grid import WIDTH
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface

Array = NDArray[np.float64]
# Unit [m] and pixel [m].
Scale = tuple[float, tuple[float, float]]

TEXT_MARK = "# roughcontact map"
"""First line of a text matrix whose head names its quantity, unit and pixel."""

# Characters of a line, and bytes that reading takes a point.
_LONGEST_LINE = 32 * 2**20
_EACH = 20

_MISSING = re.compile(r"|nan|n/?a|bad|\*+|-{2,}", re.IGNORECASE)
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?")


def read_text(path: Path, name: str, asked: Asked) -> Surface:
    """Return the map in a text matrix."""
    if asked.channel is not None:
        raise InputError(
            f"{path.name} has no channels; leave out ", Mention("channel", asked.channel)
        )
    trace = traces.found(path)
    if trace is not None:
        return traces.read(path, trace, asked)
    scale = _scale_in_text(path)
    values, steps = _read_text(path, points_possible=scale is None)
    if scale is None and min(values.shape) == 1 and values.size >= traces.FEWEST:
        return traces.column(path, values.ravel(), asked)
    asked.expect(values.shape)
    return _scaled(path, values, Provenance(path.name, f"matrix ({name})", "", steps), scale, asked)


def text_channels(path: Path, name: str) -> tuple[Channel, ...]:
    """Return the matrix or the profile in a text file as the only channel."""
    trace = traces.found(path)
    if trace is not None:
        return (Channel("", trace.units[1], True, (1, len(trace.columns))),)
    stated = _head_of_text(path)
    quantity, unit = stated.get("quantity", ""), stated.get("unit", "")
    is_height = not stated or quantity == "height"
    values, _ = _read_text(path, points_possible=not stated)
    shape = values.shape if stated or values.shape[1] > 1 else values.shape[::-1]
    return (Channel(quantity, unit, is_height, shape),)


def read_arrays(path: Path, name: str, asked: Asked) -> Surface:
    """Return the map in a NumPy file; ``name`` says whether it is one array or an archive."""
    arrays = numpy_files.opened(path, name)
    scale = _scale_in_arrays(path, arrays) if asked.channel in (None, "heights") else None
    channel = _chosen_array(path, arrays, asked.channel if scale is None else "heights")
    head = arrays.heads[channel]
    line = len(head.shape) == 1 and head.shape[0] >= traces.FEWEST
    if scale is None and line and head.dtype.kind in "fiu":
        limits.require_points(path.name, head.shape, _EACH)
        return traces.column(path, arrays.read(channel), asked)
    _require_map(path, head.shape, head.dtype, scale)
    limits.require_points(path.name, head.shape, _EACH)
    asked.expect(head.shape)
    provenance = Provenance(path.name, f"matrix ({name})", channel)
    values = arrays.read(channel)
    if scale is None:
        trace = traces.in_columns(values)
        if trace is not None:
            return traces.read(path, trace, asked)
        _refuse_points(path, values)
    return _scaled(path, values, provenance, scale, asked)


def array_channels(path: Path, name: str) -> tuple[Channel, ...]:
    """Return the arrays in a NumPy file."""
    heads = numpy_files.opened(path, name).heads
    return tuple(
        Channel(name, "", len(head.shape) == 2, head.shape) for name, head in heads.items()
    )


def _require_map(
    path: Path, shape: tuple[int, ...], dtype: np.dtype[Any], scale: Scale | None
) -> None:
    if shape[:1] == (1,) and scale is not None and scale[1][0] == WIDTH:
        # A profile as the program keeps it.
        shape = (2, *shape[1:])
    if dtype.kind not in "fiu" or len(shape) != 2 or min(shape) < 2:
        raise FormatError(
            f"{path.name} must hold a matrix of at least 2 × 2 real numbers, got {dtype} of shape "
            f"{shape}"
        )


def _scaled(
    path: Path, values: NDArray[Any], provenance: Provenance, scale: Scale | None, asked: Asked
) -> Surface:
    """Return the map of numbers whose scale the file states, or whoever reads it."""
    _require_map(path, values.shape, values.dtype, scale)
    if scale is None:
        metre, stated = unit_in_metres(path, asked.unit), None
    else:
        refuse_unit(path, asked)
        metre, stated = scale
    pixel = asked_pixel(path, stated, values.shape, asked)
    return surface_of(path, in_metres(values, metre), pixel, provenance, metre, stated)


@contextlib.contextmanager
def _naming(path: Path) -> Iterator[None]:
    """Turn the complaint about a quantity into one about the file that states it."""
    try:
        yield
    except InputError as error:
        raise FormatError(f"{path.name} states its scale wrongly: {error}") from None


def _head_of_text(path: Path) -> dict[str, str]:
    """Return what the head of a text matrix states; nothing if it has no head of this program."""
    try:
        with path.open(encoding="utf-8-sig", errors="replace") as stream:
            lines = _lines(path, stream)
            if next(lines, "").strip() != TEXT_MARK:
                return {}
            head = itertools.takewhile(lambda line: line.startswith("#"), lines)
            parts = (line[1:].partition(":") for line in head)
            return {name.strip(): value.strip() for name, mark, value in parts if mark}
    except OSError as error:
        raise FormatError(f"{path.name} cannot be read ({one_line(error)})") from None


def _lines(path: Path, stream: TextIO) -> Iterator[str]:
    """Yield the lines of a text, none of which fills the memory."""
    number = 0
    while line := stream.readline(_LONGEST_LINE):
        number += 1
        if len(line) == _LONGEST_LINE:
            raise FormatError(
                f"{path.name} has more than {_LONGEST_LINE // 2**20} million characters in line "
                f"{number}; a text matrix has one row of the map a line"
            )
        yield line


def _scale_in_text(path: Path) -> Scale | None:
    """Return the unit [m] and the pixel [m] that the head of a text matrix states."""
    stated = _head_of_text(path)
    if not stated:
        return None
    absent = [name for name in ("quantity", "unit", "pixel_y", "pixel_x") if name not in stated]
    if absent:
        raise FormatError(
            f"{path.name} lacks {', '.join(absent)} in its head; complete it, or remove the line "
            f"{TEXT_MARK!r} and give ",
            Mention("unit"),
            " and ",
            Mention("size"),
        )
    if stated["quantity"] != "height":
        raise FormatError(f"{path.name} holds {stated['quantity']!r}, no heights")
    with _naming(path):
        metre = unit_in_metres(path, stated["unit"])
        dy, dx = (units.parse(stated[name], "length", name) for name in ("pixel_y", "pixel_x"))
    return metre, (dy, dx)


def _scale_in_arrays(path: Path, arrays: Arrays) -> Scale | None:
    """Return the unit [m] and the pixel [m] that a NumPy archive holds beside its heights."""
    heads = arrays.heads
    if not {"heights", "pixel", "unit"} <= heads.keys():
        return None
    edges, word = heads["pixel"], heads["unit"]
    if edges.shape != (2,) or edges.dtype.kind not in "fiu" or word.dtype.kind != "U" or word.shape:
        raise FormatError(
            f"{path.name} must hold two numbers (dy, dx) as pixel and a word as unit, got "
            f"{edges.dtype} of shape {edges.shape} and {word.dtype} of shape {word.shape}"
        )
    pixel, unit = arrays.read("pixel"), arrays.read("unit")
    with _naming(path):
        metre = unit_in_metres(path, str(unit))
    return metre, (float(pixel[0]) * metre, float(pixel[1]) * metre)


def _chosen_array(path: Path, arrays: Arrays, channel: str | int | None) -> str:
    names = list(arrays.heads)
    if channel is None and len(names) == 1:
        return names[0]
    listing = "; ".join(f"{index}: {name!r}" for index, name in enumerate(names)) or "none"
    if channel is None:
        raise InputError(
            f"{path.name} holds the arrays {listing}; choose one with ", Mention("channel")
        )
    if channel in names:
        return str(channel)
    if not isinstance(channel, bool) and re.fullmatch(r"\d{1,6}", str(channel)):
        index = int(channel)
        if index < len(names):
            return names[index]
    raise InputError(f"{path.name} has no array {channel!r}; it holds {listing}")


def _read_text(path: Path, points_possible: bool = True) -> tuple[Array, tuple[str, ...]]:
    """Return the matrix in a text file, and what was decided in reading it."""
    values, trailing, ended = array("d"), True, True
    first, columns, room = 0, 0, 0
    delimiter: str | None = None
    try:
        with path.open(encoding="utf-8-sig") as stream:
            for number, line in enumerate(_lines(path, stream), start=1):
                ended = line.endswith("\n")
                text = line.split("#", 1)[0].strip(" \r\n")
                if not text.strip():
                    continue
                if not first:
                    delimiter = _delimiter(path, text, number)
                cells = text.split(delimiter)
                trailing = trailing and delimiter is not None and not cells[-1].strip()
                row = _row(path, cells, number, delimiter)
                if not first:
                    first, columns = number, len(row)
                if len(row) != columns:
                    raise FormatError(
                        f"{path.name} has {len(row)} numbers in line {number} but {columns} in "
                        f"line {first}; all rows must be of one length"
                    )
                if len(values) >= room:
                    # As many rows as there are such lines left, or a tenth more than expected.
                    rows = len(values) // columns
                    more = 1 + (rows // 10 if rows else path.stat().st_size // len(line))
                    room = (rows + more) * columns
                    limits.require_points(path.name, (rows + more, columns), _EACH)
                values.extend(row)
    except UnicodeDecodeError:
        raise FormatError(
            f"{path.name} is no text in UTF-8; save it as a plain text matrix, or give its ",
            Mention("format"),
        ) from None
    except OSError as error:
        raise FormatError(f"{path.name} cannot be read ({one_line(error)})") from None
    if not values:
        raise FormatError(f"{path.name} holds no numbers; a matrix of heights was expected")
    return _judged(
        path, np.frombuffer(values).reshape(-1, columns), trailing, ended, points_possible
    )


def _judged(
    path: Path, matrix: Array, trailing: bool, ended: bool, points_possible: bool
) -> tuple[Array, tuple[str, ...]]:
    """Return a matrix as it was meant, and what was decided about it."""
    steps: tuple[str, ...] = ()
    # Many programs end each row with the delimiter; that is no column.
    if trailing and matrix.shape[1] > 1:
        matrix = matrix[:, :-1]
        steps = ("read: the delimiter at the end of every row is no column",)
    if not ended:
        # Rows are missing without a trace where a file was cut off, and the sides are given for
        # all of them.
        steps += ("read: the last row has no line end; check that the file was not cut off",)
    if points_possible:
        _refuse_points(path, matrix)
    return matrix, steps


def _delimiter(path: Path, line: str, number: int) -> str | None:
    for mark in (";", "\t"):
        if mark in line:
            return mark
    words = line.split()
    if "," in line and len(words) > 1 and all(_DECIMAL_COMMA.fullmatch(word) for word in words):
        raise _comma_error(path, words[0], number)
    # None splits at any run of white space.
    return "," if "," in line else None


def _row(path: Path, cells: list[str], number: int, delimiter: str | None) -> list[float]:
    values = []
    for position, cell in enumerate(cells, start=1):
        try:
            value = float(cell)
        except ValueError:
            word = cell.strip()
            if not _MISSING.fullmatch(word):
                if delimiter != "," and _DECIMAL_COMMA.fullmatch(word):
                    raise _comma_error(path, word, number) from None
                raise FormatError(
                    f"{path.name} has {word[:40]!r} in line {number}, cell {position}, where a "
                    "number was expected; start lines that are no data with #"
                ) from None
            value = math.nan
        else:
            # Python's float() takes 1_0 for ten; no instrument writes that.
            if "_" in cell or math.isinf(value):
                raise FormatError(
                    f"{path.name} has {cell.strip()[:40]!r} in line {number}, cell {position}; "
                    "write finite numbers, and nan for missing points"
                )
        values.append(value)
    return values


def _comma_error(path: Path, word: str, number: int) -> FormatError:
    return FormatError(
        f"{path.name} has the decimal comma {word!r} in line {number}; write decimal points"
    )


def _refuse_points(path: Path, matrix: NDArray[Any]) -> None:
    """Refuse coordinates beside the heights, which would pass for heights of a narrow map."""
    for pairs in (matrix, matrix.T):
        if traces.in_columns(pairs) or traces.in_columns(pairs[:, ::-1]):
            raise FormatError(
                f"{path.name} looks like a profile, {pairs.shape[0]} points x, z: write them in "
                "two columns, the positions first"
            )
    # Three columns of which two count through a grid would pass for a narrow map.
    if matrix.shape[1] == 3 and matrix.shape[0] >= 9:
        first, second = (np.unique(matrix[:, column]).size for column in (0, 1))
        if min(first, second) > 1 and first * second == matrix.shape[0]:
            raise FormatError(
                f"{path.name} looks like a list of points x, y, z; write the heights as a matrix "
                "with one row of the map per line"
            )
