"""Matrices of plain numbers: NumPy files, and text with one row of the map a line."""

from __future__ import annotations

import contextlib
import itertools
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact import units
from roughcontact.errors import FormatError, InputError, Mention
from roughcontact.formats.scale import in_metres, pixel_of, refuse_given, unit_in_metres
from roughcontact.formats.source import Asked, Channel, check_container, one_line, surface_of
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface

Array = NDArray[np.float64]
# Unit [m] and pixel [m].
Scale = tuple[float, tuple[float, float]]

TEXT_MARK = "# roughcontact map"
"""First line of a text matrix whose head names its quantity, unit and pixel."""

_MISSING = re.compile(r"|nan|n/?a|bad|\*+|-{2,}", re.IGNORECASE)
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?")


def read_text(path: Path, name: str, asked: Asked) -> Surface:
    """Return the map in a text matrix."""
    if asked.channel is not None:
        raise InputError(
            f"{path.name} has no channels; leave out ", Mention("channel", asked.channel)
        )
    scale = _scale_in_text(path)
    values, steps = _read_text(path, points_possible=scale is None)
    return _scaled(path, values, Provenance(path.name, f"matrix ({name})", "", steps), scale, asked)


def text_channels(path: Path, name: str) -> tuple[Channel, ...]:
    """Return the matrix in a text file as the only channel."""
    stated = _head_of_text(path)
    quantity, unit = stated.get("quantity", ""), stated.get("unit", "")
    is_height = not stated or quantity == "height"
    return (Channel(quantity, unit, is_height, _read_text(path)[0].shape),)


def read_arrays(path: Path, name: str, asked: Asked) -> Surface:
    """Return the map in a NumPy file; ``name`` says whether it is one array or an archive."""
    arrays = _read_arrays(path, name)
    scale = _scale_in_arrays(path, arrays) if asked.channel in (None, "heights") else None
    channel, values = _chosen_array(path, arrays, asked.channel if scale is None else "heights")
    return _scaled(path, values, Provenance(path.name, f"matrix ({name})", channel), scale, asked)


def array_channels(path: Path, name: str) -> tuple[Channel, ...]:
    """Return the arrays in a NumPy file."""
    return tuple(
        Channel(channel, "", array.ndim == 2, array.shape)
        for channel, array in _read_arrays(path, name).items()
    )


def _scaled(
    path: Path, values: NDArray[Any], provenance: Provenance, scale: Scale | None, asked: Asked
) -> Surface:
    """Return the map of numbers whose scale the file states, or whoever reads it."""
    if values.dtype.kind not in "fiu" or values.ndim != 2 or min(values.shape) < 2:
        raise FormatError(
            f"{path.name} must hold a matrix of at least 2 × 2 real numbers, got {values.dtype} "
            f"of shape {values.shape}"
        )
    if scale is None:
        metre = unit_in_metres(path, asked.unit)
        ny, nx = values.shape
        pixel = pixel_of(asked.size, (ny, nx), path.name)
    else:
        refuse_given(path, unit=asked.unit, size=asked.size)
        metre, pixel = scale
    return surface_of(path, in_metres(values, metre), pixel, provenance, metre)


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
            if stream.readline().strip() != TEXT_MARK:
                return {}
            lines = itertools.takewhile(lambda line: line.startswith("#"), stream)
            parts = (line[1:].partition(":") for line in lines)
            return {name.strip(): value.strip() for name, mark, value in parts if mark}
    except OSError as error:
        raise FormatError(f"{path.name} cannot be read ({one_line(error)})") from None


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


def _scale_in_arrays(path: Path, arrays: dict[str, NDArray[Any]]) -> Scale | None:
    """Return the unit [m] and the pixel [m] that a NumPy archive holds beside its heights."""
    if not {"heights", "pixel", "unit"} <= arrays.keys():
        return None
    pixel, unit = arrays["pixel"], arrays["unit"]
    if pixel.shape != (2,) or pixel.dtype.kind not in "fiu" or unit.dtype.kind != "U" or unit.ndim:
        raise FormatError(
            f"{path.name} must hold two numbers (dy, dx) as pixel and a word as unit, got "
            f"{pixel.dtype} of shape {pixel.shape} and {unit.dtype} of shape {unit.shape}"
        )
    with _naming(path):
        metre = unit_in_metres(path, str(unit))
    return metre, (float(pixel[0]) * metre, float(pixel[1]) * metre)


def _read_arrays(path: Path, kind: str) -> dict[str, NDArray[Any]]:
    try:
        if kind == "npy":
            # Mapped, not read: a header that announces more than the file holds fails at once.
            array = np.load(path, mmap_mode="r", allow_pickle=False)
            spare = path.stat().st_size - array.offset - array.nbytes
            if array.size and spare:
                raise ValueError(
                    f"shape {array.shape} of {array.dtype} leaves {spare} bytes of the file over"
                )
            return {"": array}
        # Our own stream: NumPy leaves a damaged archive open.
        check_container(path)
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as archive:
            return {name: np.asarray(archive[name]) for name in archive.files}
    # Damaged files raise ValueError, BadZipFile, EOFError, SyntaxError, MemoryError and more.
    except Exception as error:
        raise FormatError(
            f"{path.name} cannot be read as NumPy file {kind!r} ({one_line(error)}); save a real "
            "array with numpy.save or numpy.savez"
        ) from None


def _chosen_array(
    path: Path, arrays: dict[str, NDArray[Any]], channel: str | int | None
) -> tuple[str, NDArray[Any]]:
    names = list(arrays)
    if channel is None and len(names) == 1:
        return names[0], arrays[names[0]]
    listing = "; ".join(f"{index}: {name!r}" for index, name in enumerate(names)) or "none"
    if channel is None:
        raise InputError(
            f"{path.name} holds the arrays {listing}; choose one with ", Mention("channel")
        )
    if channel in arrays:
        return str(channel), arrays[str(channel)]
    if not isinstance(channel, bool) and re.fullmatch(r"\d{1,6}", str(channel)):
        index = int(channel)
        if index < len(names):
            return names[index], arrays[names[index]]
    raise InputError(f"{path.name} has no array {channel!r}; it holds {listing}")


def _read_text(path: Path, points_possible: bool = True) -> tuple[Array, tuple[str, ...]]:
    """Return the matrix in a text file, and what was decided in reading it."""
    rows: list[Array] = []
    numbers: list[int] = []
    delimiter: str | None = ""
    trailing = ended = True
    try:
        with path.open(encoding="utf-8-sig") as stream:
            for number, line in enumerate(stream, start=1):
                ended = line.endswith("\n")
                line = line.split("#", 1)[0].strip(" \r\n")
                if not line.strip():
                    continue
                if delimiter == "":
                    delimiter = _delimiter(path, line, number)
                cells = line.split(delimiter)
                trailing = trailing and delimiter is not None and not cells[-1].strip()
                rows.append(_row(path, cells, number, delimiter))
                numbers.append(number)
                if rows[-1].size != rows[0].size:
                    raise FormatError(
                        f"{path.name} has {rows[-1].size} numbers in line {number} but "
                        f"{rows[0].size} in line {numbers[0]}; all rows must be of one length"
                    )
    except UnicodeDecodeError:
        raise FormatError(
            f"{path.name} is no text in UTF-8; save it as a plain text matrix, or give its ",
            Mention("format"),
        ) from None
    except OSError as error:
        raise FormatError(f"{path.name} cannot be read ({one_line(error)})") from None
    if not rows:
        raise FormatError(f"{path.name} holds no numbers; a matrix of heights was expected")
    matrix = np.stack(rows)
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
        _refuse_point_list(path, matrix)
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


def _row(path: Path, cells: list[str], number: int, delimiter: str | None) -> Array:
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
    return np.array(values)


def _comma_error(path: Path, word: str, number: int) -> FormatError:
    return FormatError(
        f"{path.name} has the decimal comma {word!r} in line {number}; write decimal points"
    )


def _refuse_point_list(path: Path, matrix: Array) -> None:
    # Three columns of which two count through a grid would pass for a narrow map.
    if matrix.shape[1] == 3 and matrix.shape[0] >= 9:
        first, second = (np.unique(matrix[:, column]).size for column in (0, 1))
        if min(first, second) > 1 and first * second == matrix.shape[0]:
            raise FormatError(
                f"{path.name} looks like a list of points x, y, z; write the heights as a matrix "
                "with one row of the map per line"
            )
