"""Text files: their headers, points on a grid, and profiles in columns or in records.

`parse_export`: Zygo's texts, as in the reference of MetroPro: 13 lines and ``#``, the pixel [m] as
seventh number of line 8. XYZ, format 1, has heights in micrometers; ASCII, format 2, intensities,
``#``, and phases row by row, whose height is ``S W O / R``, numbers 2, 3 and 5 of line 8, with R by
the first number of line 11. Keyence's CSV: lines ``"key","value"`` and
``"key","value","unit"``, then the name of the quantity and the rows; keys are translated, so that
the order and the units decide.

SMD and PRF describe the axes by lines ``CX`` and ``CZ``: kind of axis, number of points, unit,
factor, type of number, and in SMD the spacing; PRF gives it in a line ``SPACING``. Records end with
the control character ETX or ``EOR``. SigmaSurf, of OmniSurf's maker, names spacing and heights
``…_UM``.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact import units
from roughcontact._tools import memory
from roughcontact._tools.arrays import Array, Shape
from roughcontact.errors import ArgumentRef, FormatError, InputError
from roughcontact.formats.no_data import mark_missing
from roughcontact.formats.source import (
    Channel,
    ReadOptions,
    damage_as_error,
    is_length,
    make_surface,
    refuse_unit,
    unit_in_meters,
)
from roughcontact.surface.grid import PROFILE_WIDTH
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface
from roughcontact.units import format_engineering

MAX_HEAD_LINES = 200
"""Maximum number of lines of a header."""

# Maximum number of characters of a line of a header.
_MAX_LINE_LENGTH = 4096

_NUMBER = r"[-+]?\d*[.,]?\d+(?:[eE][-+]?\d+)?"
_IS = r"\s*[:=：]\s*"

# Gwyddion translates this word.
_CHANNEL = "Channel|Kanál|Kanal|Canal|Canale|チャネル|채널|Канал"
_WIDTH = "Width|Šířka|Breite|Anchura|Largeur|Larghezza|幅|폭|Largura|Ширина"
_HEIGHT = "Height|Výška|Höhe|Altura|Hauteur|Altezza|高さ|높이|Высота"
_VALUES = (
    "Value units|Jednotky hodnot|Einheiten|Unités|unità valore|値の単位|값 단위"
    "|Unidades de valor|Единицы измерения"
)

# Key of a line -> pattern with its value; compiled for the first text file.
_KEYS = {
    "channel": rf"^\W*(?:{_CHANNEL}){_IS}(.+)$",
    "side_x": rf"^\W*(?:{_WIDTH}|x-length){_IS}({_NUMBER}\s*\D*)$",
    "side_y": rf"^\W*(?:{_HEIGHT}|y-length){_IS}({_NUMBER}\s*\D*)$",
    "unit": rf"^\W*(?:{_VALUES}|z-unit|Unit Data|data unit){_IS}(.*)$",
    "unit_x": rf"^\W*(?:Lateral units|x-unit|Unit X){_IS}(.*)$",
    "unit_y": rf"^\W*(?:y-unit|Unit Y){_IS}(.*)$",
    "points_x": rf"^\W*(?:x-pixels|NX){_IS}(\d+)\s*$",
    "points_y": rf"^\W*(?:y-pixels|NY){_IS}(\d+)\s*$",
    "points": r"^\W*h\s*=\s*(\d+)\s+w\s*=\s*(\d+)\s*$",
    "pixel": rf"^\W*pixel\s+size\s*=\s*({_NUMBER}\s*\S*)\s*$",
    "pixel_x": rf"^\W*Scale X{_IS}({_NUMBER})\s*$",
    "pixel_y": rf"^\W*Scale Y{_IS}({_NUMBER})\s*$",
    "factor": rf"^\W*Scale Data{_IS}({_NUMBER})\s*$",
    "spip": rf"^\W*Bit2nm{_IS}({_NUMBER})\s*$",
    "koala": rf"^\W*height\s+conversion\s+factor\s+\(->\s*(\S+)\)\s*=\s*({_NUMBER})\s*$",
    "wyko": r"^Wyko ASCII Data File Format\s+\d+\s+(\d+)",
    "wyko_x": r"^X Size\s+(\d+)\s*$",
    "wyko_y": r"^Y Size\s+(\d+)\s*$",
    "wyko_pixel": rf"^Pixel_size\s+\d+\s+\d+\s+({_NUMBER})\s*$",
    "wyko_aspect": rf"^Aspect\s+\d+\s+\d+\s+({_NUMBER})\s*$",
    "wyko_wave": rf"^Wavelength\s+\d+\s+\d+\s+({_NUMBER})\s*$",
    "wyko_mult": rf"^Mult\s+\d+\s+\d+\s+({_NUMBER})\s*$",
    "ascii": r"^\W*File Format\s*=\s*(ASCII)\s*$",
}

# A number or the mark of a missing one; a decimal comma separates its two parts.
_CELL = re.compile(
    r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[ed][-+]?\d+)?|nan|bad|n/?a|\*+|-{2,}", re.IGNORECASE
)

_RULE = re.compile(r"[-*=_]{5,}")

# Name of a column, optionally with its unit: X [mm], Y position (um), z/nm.
_COLUMN = re.compile(r"\s*([^\[(/]*?)\s*(?:[\[(/]\s*([^\])\s]+)\s*[\])]?)?\s*")

# Keys of the header of a map: a text without any of these is a remark.
_TELLING = {"side_x", "points", "points_x", "pixel", "pixel_x", "wyko", "unit_x"}


def parse_head(path: Path, lines: Iterable[str]) -> Head:
    """Return the properties that the first lines of a text state."""
    result: dict[str, str] = {}
    columns: tuple[str, ...] = ()
    texts: list[str] = []
    named, announced = True, ""
    lines = iter(lines)
    export, read = parse_export(path, lines, MAX_HEAD_LINES)
    if export is not None:
        return export
    for quoted in itertools.islice(itertools.chain(read, lines), MAX_HEAD_LINES):
        line = quoted.replace('"', "")
        text = line[:_MAX_LINE_LENGTH].strip()
        if is_data(line) and not _RULE.fullmatch(text):
            # Some programs write the number of values first; others only one column.
            if texts and texts[-1] == announced and len(_cells(text)) == 1:
                announced, _ = "", texts.pop()
            elif not announced and text.isdecimal():
                announced = text
                texts.append(text)
                continue
            break
        texts.append(text)
        named = named and _is_remark(text)
        for key, pattern in _KEYS.items():
            match = re.search(pattern, text, re.IGNORECASE)
            if match is not None:
                result.setdefault(key, " ".join(match.groups()))
        columns = _columns(text) or columns
    else:
        return Head(0)
    head = Head(len(texts), texts=tuple(texts), announced=announced)
    if not (columns or _TELLING & result.keys()):
        certain = (texts.index(announced) if announced else len(texts)) if named else 0
        return replace(head, skipped=certain > 0, doubtful=len(texts) - certain)
    try:
        return _parse_head_text(path, result, columns, head)
    except InputError as error:
        raise FormatError(f"{path.name} states its scale wrongly: {error}") from None


def starts_new_map(line: str) -> bool:
    """Return whether a line between numbers is the start of another map."""
    return any(re.search(_KEYS[key], line, re.IGNORECASE) for key in ("channel", "side_x"))


def is_data(text: str) -> bool:
    """Return whether a line contains only numbers, or words for missing points."""
    cells = re.split(r"[;,\s]+", text[:_MAX_LINE_LENGTH].strip())
    if len(text) > _MAX_LINE_LENGTH:
        cells = cells[:-1]
    return any(cells) and all(_CELL.fullmatch(cell) for cell in cells if cell)


def _is_remark(text: str) -> bool:
    """Return whether a line above the numbers cannot be a row with a damaged number."""
    words = [word for word in re.split(r"[;,\s]+", text.split("#", 1)[0]) if word]
    # Two rows below x and y are a short profile rather than a matrix.
    named = all(word.lower() in ("x", "y", "z") for word in words)
    return not (words and (named or words[0][0].isdigit() or sum(map(is_data, words)) > 1))


def _columns(text: str) -> tuple[str, ...]:
    """Return the units of columns named x, y and z, empty if missing; () for other columns."""
    text = text.lstrip("# ")
    cells = re.split(r"[;,\t]" if re.search(r"[;,\t]", text) else r"\s+(?![\[(/])", text)
    matches = [_COLUMN.fullmatch(cell) for cell in cells]
    if len(cells) != 3 or not all(matches):
        return ()
    if all(is_length(Path(), cell.strip(" []()")) for cell in cells):
        return tuple(cell.strip(" []()") for cell in cells)
    names, words = zip(*((m[1].lower(), m[2] or "") for m in matches if m), strict=True)
    is_height = names[2].startswith("z") or is_length(Path(), words[2])
    return words if names[0][:1] == "x" and names[1][:1] == "y" and is_height else ()


def _parse_head_text(
    path: Path, result: dict[str, str], columns: tuple[str, ...], head: Head
) -> Head:
    """Return the header with the properties found in its lines."""
    head = replace(head, channel=result.get("channel", "").strip())
    if "wyko" in result:
        return _wyko(head, result)
    head = replace(head, points=_points(result))
    head = _heights(path, head, result)
    if columns:
        x, y, z = columns
        lateral = _lateral(path, {"unit_x": x, "unit_y": y})
        return replace(head, unit=z or head.unit, lateral=lateral, columns=True)
    lateral = _lateral(path, result)
    if "side_x" in result and "side_y" in result:
        # Lengths without a unit of SPIP are in nanometers.
        default = lateral or (1e-9 if "ascii" in result else None)
        texts = [result[f"side_{axis}"].strip() for axis in "yx"]
        if default is None and any(re.fullmatch(_NUMBER, text) for text in texts):
            # The lengths may be numbers of points.
            return head
        sides = [_length(result, f"side_{axis}", default) for axis in "yx"]
        return replace(head, sides=(sides[0], sides[1]))
    if "pixel" in result:
        edge = _length(result, "pixel", None)
        return replace(head, pixel=(edge, edge))
    if "pixel_x" in result and "pixel_y" in result:
        dy, dx = (_length(result, f"pixel_{axis}", lateral) for axis in "yx")
        return replace(head, pixel=(dy, dx))
    return replace(head, lateral=lateral)


def _heights(path: Path, head: Head, result: dict[str, str]) -> Head:
    """Return a header with the unit of its heights, and the factor to it."""
    unit = result.get("unit", "").strip()
    if "koala" in result and not (unit and is_length(path, unit)):
        unit, factor = result["koala"].split()
        return replace(head, unit=unit, factor=_float(factor))
    if not unit and "spip" in result:
        return replace(head, unit="nm", factor=_float(result["spip"]))
    if unit and not is_length(path, unit):
        named = f" {head.channel!r}" if head.channel else ""
        raise FormatError(f"{path.name} holds{named} in {unit!r}, no heights; export the heights")
    return replace(head, unit=unit, factor=_float(result.get("factor", "1")))


def _wyko(head: Head, result: dict[str, str]) -> Head:
    """Return the header of Wyko: a line per x, pixels in mm, heights in nm or wavelengths."""
    factor = 1.0
    if result["wyko"] == "0" and {"wyko_wave", "wyko_mult"} <= result.keys():
        factor = _float(result["wyko_wave"]) / _float(result["wyko_mult"])
    pixel = None
    if "wyko_pixel" in result:
        edge = 1e-3 * _float(result["wyko_pixel"])
        pixel = edge, edge * _float(result.get("wyko_aspect", "1"))
    points = None
    if {"wyko_x", "wyko_y"} <= result.keys():
        points = int(result["wyko_y"]), int(result["wyko_x"])
    return replace(head, unit="nm", factor=factor, pixel=pixel, points=points, turned=True)


def _points(result: dict[str, str]) -> tuple[int, int] | None:
    listed = result.get("points", "").split()
    if {"points_x", "points_y"} <= result.keys():
        listed = listed or [result["points_y"], result["points_x"]]
    return (int(listed[0]), int(listed[1])) if listed else None


def _lateral(path: Path, result: dict[str, str]) -> float | None:
    """Return the unit [m] of lengths along x and y."""
    along_x, along_y = (result.get(f"unit_{axis}", "").strip() for axis in "xy")
    if not along_x:
        return None
    if along_y and along_y != along_x:
        raise FormatError(
            f"{path.name} has lengths along x in {along_x!r} and along y in {along_y!r}; export it "
            "with one unit"
        )
    return unit_in_meters(path, along_x)


def _length(result: dict[str, str], key: str, metre: float | None) -> float:
    text = result[key].strip()
    number = re.match(_NUMBER, text)
    assert number is not None
    unit = text[number.end() :].strip()
    if unit or metre is None:
        return units.parse(f"{_float(number[0])!r} {unit}", "length", key)
    return _float(number[0]) * metre


def _float(text: str) -> float:
    return float(text.replace(",", "."))


# Maximum deviation of coordinates from the grid, in steps, due to their printed digits.
_GRID_TOLERANCE = 0.05
# Maximum number of grid points per point of the list: more are missing than measured.
_SPARSE = 4
# Memory for placing the points on the grid, in bytes per point.
_BYTES_PER_POINT = 40


def look_like_points(matrix: Array) -> bool:
    """Return whether three columns are coordinates and heights rather than a narrow map."""
    if matrix.shape[1] != 3 or matrix.shape[0] < 9:
        return False
    x, y = matrix[:, 0], matrix[:, 1]
    if not (np.isfinite(x).all() and np.isfinite(y).all()):
        return False
    counts = [np.unique(values).size for values in (x, y)]
    pairs = np.unique(matrix[:, :2], axis=0).shape[0]
    # Heights of a narrow map are not repeated in all combinations.
    return min(counts) > 1 and pairs == matrix.shape[0] <= counts[0] * counts[1] <= 2 * pairs


def grid_points(path: Path, matrix: Array) -> tuple[Array, tuple[float, float], int]:
    """Return the heights of points on their grid."""
    if not np.isfinite(matrix[:, :2]).all():
        raise FormatError(f"{path.name} lists points whose x or y is missing; export it again")
    (columns, dx), (rows, dy) = (_steps(path, axis, matrix[:, i]) for i, axis in enumerate("xy"))
    shape = int(rows.max()) + 1, int(columns.max()) + 1
    if shape[0] * shape[1] > _SPARSE * matrix.shape[0] or min(shape) < 2:
        raise FormatError(
            f"{path.name} lists {matrix.shape[0]} points x, y, z that fill no grid (steps of "
            f"{dy:.6g} and {dx:.6g} would make {shape[0]} × {shape[1]}); interpolate them to a "
            "grid first"
        )
    memory.require_points(path.name, shape, _BYTES_PER_POINT)
    place = rows * shape[1] + columns
    counted = np.bincount(place, minlength=shape[0] * shape[1])
    if counted.max() > 1:
        raise FormatError(
            f"{path.name} lists {int((counted > 1).sum())} points of its grid more than once; "
            "export it again"
        )
    heights = np.full(shape, np.nan)
    heights.reshape(-1)[place] = matrix[:, 2]
    return heights, (dy, dx), int((counted == 0).sum())


def _steps(path: Path, axis: str, values: Array) -> tuple[NDArray[np.int64], float]:
    """Return the grid index of each coordinate, and the length of a step."""
    known = np.unique(values)
    extent = float(known[-1] - known[0])
    gaps = np.diff(known)
    # Digits are cut off: coordinates within a millionth of the map are one position.
    steps = gaps[gaps > 1e-6 * extent]
    if steps.size == 0:
        raise FormatError(
            f"{path.name} lists points that all have the same {axis}; a map was expected"
        )
    step = extent / max(round(extent / float(steps.min())), 1)
    # The smallest step has the largest rounding error: the mean of similar steps is more accurate.
    alike = steps[steps < 1.5 * step]
    step = extent / max(round(extent / float(alike.mean())), 1)
    place = (values - known[0]) / step
    nearest = np.rint(place)
    if np.abs(place - nearest).max() > _GRID_TOLERANCE:
        raise FormatError(
            f"{path.name} lists points x, y, z whose {axis} is not evenly spaced; interpolate them "
            "to a grid first"
        )
    return nearest.astype(np.int64), step


MIN_POINTS = 9
"""Minimum number of points of a profile without named units; fewer may be a narrow map."""

_MIN_NAMED_POINTS = 3

# Memory for resampling, in bytes per point.
_BYTES_PER_TRACE_POINT = 200
# Deviation from an even grid due to printed digits, in steps; ratio of a step to the median from
# which the points in between are missing.
_EVEN, _GAP = 0.02, 5.0
# Share of steps that differ from the median, and deviation from an even grid over the last digit,
# for positions that are rounded.
_MIXED, _ROUNDED = 0.1, 1.2

_BRACKETED = re.compile(r"[\[(]\s*([?~a-zA-Z\u00b5\u03bcÅ\ufffd]+)\s*[\])]")
_UNIT = re.compile(r"[\[(/]\s*([?~a-zA-Z\u00b5\u03bcÅ\ufffd]+)\s*[\])]?\s*$")
# A unit without brackets, if unambiguous: "x in um", "Raw Micrometer".
_WORD = re.compile(
    r"(?:^|[\s_])([munp\u00b5\u03bc]?m|Å|microns?|(?:[Mm]illi|[Mm]icro|[Nn]ano)?[Mm]et(?:er|re)s?)\s*$"
)

# Names of a third column, after the heights or before the positions.
_VALID = re.compile(r"\s*valid\s*", re.IGNORECASE)
_NUMBERED = re.compile(r"\W*(?:index|number|point|sample|nr|no|n|i)?\W*", re.IGNORECASE)


@dataclass(frozen=True)
class Trace:
    """Two columns of a text."""

    columns: Array  # (n, 2) Positions and heights, in their units
    units: tuple[str, str]  # Units of positions and heights in the header of the columns


def _third_column_name(head: Sequence[str]) -> str:
    """Return the quantity of the third column of a profile by its name; empty without one."""
    named = [cells for line in head if len(cells := _cells(line.lstrip("# "))) == 3]
    if any(_VALID.fullmatch(cells[2]) for cells in named):
        return "valid"
    return "number" if any(_NUMBERED.fullmatch(cells[0]) for cells in named) else ""


def find_trace(path: Path, values: Array, head: Head) -> Trace | None:
    """Return the trace in rows of two or three numbers below a header."""
    if head.announced and head.announced not in (str(len(values)), str(len(values) - 1)):
        return None
    # Some programs end each row with several delimiters.
    while values.shape[1] > 2 and np.isnan(values[:, -1]).all():
        values = values[:, :-1]
    third = _third_column_name(head.texts) if values.shape[1] == 3 else ""
    if values.shape[1] > 3 and all(_units(head.texts, values.shape[1])):
        raise FormatError(
            f"{path.name} lists {values.shape[1]} columns; keep the positions and the heights"
        )
    if values.shape[1] != 2 and not third:
        return None
    first = int(third == "number")
    pair = values[:, first : first + 2]
    if third == "valid":
        pair = np.stack((pair[:, 0], np.where(values[:, 2] == 1.0, pair[:, 1], np.nan)), axis=1)
    return read_columns(pair, _units(head.texts, values.shape[1], first))


def read_columns(values: NDArray[Any], units: tuple[str, str] = ("", "")) -> Trace | None:
    """Return the trace in two columns of numbers."""
    if values.shape[1] != 2 or len(values) < (_MIN_NAMED_POINTS if any(units) else MIN_POINTS):
        return None
    columns = values.astype(np.float64)
    steps = np.diff(columns[:, 0])
    return Trace(columns, units) if (steps > 0).all() or (steps < 0).all() else None


def read_trace(path: Path, trace: Trace, requested: ReadOptions) -> Surface:
    """Return the profile of a trace."""
    along, across = _metres(path, trace.units, requested)
    position, heights = trace.columns.T
    # Before heights are interpolated between points.
    heights, marked = mark_missing(path.name, heights, 1.0, requested.no_data)
    even, spacing, notes = resample_evenly(position * along, heights, _last_digit(position) * along)
    if requested.unit is not None and all(trace.units):
        notes += (
            f"read: units {' and '.join(trace.units)} of the file replaced by {requested.unit}",
        )
    stated = (PROFILE_WIDTH, spacing)
    requested.check_shape((1, even.size))
    about = Provenance(path.name, "profile (text)", "", notes)
    codes: dict[str, Any] = {"no_data": list(marked.items())} if marked else {}
    return make_surface(path, even[None], across, requested, about, stated, **codes)


def resample_evenly(
    position: Array, heights: Array, digit: float = 0.0
) -> tuple[Array, float, tuple[str, ...]]:
    """Return the heights of a trace at equal distances."""
    if position[0] > position[-1]:
        position, heights = position[::-1], heights[::-1]
    steps = np.diff(position)
    length, median = float(position[-1] - position[0]), float(np.median(steps))
    mean = length / steps.size
    off = position - position[0] - mean * np.arange(position.size)
    if np.abs(off).max() <= _EVEN * mean:
        return np.ascontiguousarray(heights), mean, ()
    # Equal steps that are rounded alternate between short and long; a missing point gives a single
    # long step.
    if digit and np.mean(np.abs(steps - median) > 0.5 * digit) > _MIXED:
        index = np.arange(position.size) - 0.5 * steps.size
        slope = float(np.sum(index * off) / np.sum(index**2)) + mean
        if np.ptp(position - slope * index) <= _ROUNDED * digit:
            text = (format_engineering(value, "m", 3) for value in (digit, slope))
            note = "read: positions rounded to {} are taken as {} apart".format(*text)
            return np.ascontiguousarray(heights), slope, (note,)
    count = round(length / median) + 1
    memory.require_points("the profile", (1, count), _BYTES_PER_TRACE_POINT)
    spacing = length / (count - 1)
    place = position[0] + spacing * np.arange(count)
    even = np.interp(place, position, heights)
    left = np.clip(np.searchsorted(position, place, "right") - 1, 0, steps.size - 1)
    reference = np.minimum(place - position[left], position[left + 1] - place)
    even[(steps[left] > _GAP * median) & (reference > 0.5 * spacing)] = np.nan
    few, many = (format_engineering(float(end), "m", 3) for end in (steps.min(), steps.max()))
    note = (
        f"read: {heights.size} points {few} to {many} apart, resampled to {count} at equal "
        f"distances of {format_engineering(spacing, 'm')} by linear interpolation"
    )
    return even, spacing, (note,)


def _last_digit(position: Array) -> float:
    """Return the decimal place to which positions are rounded; 0 if they have many digits."""
    places = (p for p in range(7) if np.array_equal(np.round(position, p), position))
    return next((10.0**-p for p in places), 0.0)


def _cells(text: str) -> list[str]:
    mark = next((mark for mark in ";\t," if mark in text), None)
    cells = text.split(mark)
    # Many programs end each row with the delimiter, some with several.
    while len(cells) > 2 and not cells[-1].strip():
        cells = cells[:-1]
    return cells


def _units(head: Sequence[str], count: int = 2, first: int = 0) -> tuple[str, str]:
    """Return the units of positions and heights in the last line before the numbers."""
    partly = ("", "")
    lines = [line for line in head if line.strip()]
    for line in reversed(lines):
        bracketed = _BRACKETED.findall(line)
        if len(bracketed) == 2 and all(is_length(Path(), word) for word in bracketed):
            return bracketed[0], bracketed[1]
        cells = _cells(line.lstrip("# "))
        if len(cells) != count:
            continue
        x, z = cells[first : first + 2]
        named = _unit_named(x), _unit_named(z)
        plain = named[0] or x.strip(), named[1] or z.strip()
        if all(is_length(Path(), word) for word in plain):
            return plain
        if line is lines[-1]:
            partly = named
    return partly


def _unit_named(cell: str) -> str:
    """Return the unit of length at the end of the name of a column; empty without one."""
    match = _UNIT.search(cell) or _WORD.search(cell)
    if match is None:
        return ""
    word = match[1] if len(match[1]) < 4 else match[1].lower()
    return word if is_length(Path(), word) else ""


def _metres(path: Path, stated: tuple[str, str], requested: ReadOptions) -> tuple[float, float]:
    """Return the units of positions and heights [m], given by the caller or in the header."""
    said = [] if requested.unit is None else [word.strip() for word in requested.unit.split(",")]
    if len(said) == 1:
        said = [stated[0], *said]
    words = said or list(stated)
    if len(words) == 2 and all(words):
        return unit_in_meters(path, words[0]), unit_in_meters(path, words[1])
    if requested.unit is None and stated[0]:
        raise InputError(
            f"{path.name} is a profile with positions in {stated[0]}, but gives no unit of its "
            f"heights; give it, e.g. {ArgumentRef('unit', 'um')}"
        )
    problem = "gives no units of its positions and heights"
    if requested.unit is not None:
        problem = f"needs two units, of its positions and heights, got {requested.unit!r}"
    raise InputError(
        f"{path.name} is a profile and {problem}; give both in this order, e.g. "
        f"{ArgumentRef('unit', 'mm, um')}"
    )


def read_single_column(path: Path, heights: Array, requested: ReadOptions) -> Surface:
    """Return the profile in a single column or a single row of heights."""
    if heights.size < 2:
        raise FormatError(f"{path.name} holds one number, no heights of a map or a profile")
    metre = unit_in_meters(path, requested.unit)
    requested.check_shape((1, heights.size))
    about = Provenance(path.name, "profile (text)")
    return make_surface(path, heights[None], metre, requested, about)


@dataclass(frozen=True)
class Head:
    """Properties of the values that a text file states."""

    lines: int  # Number of lines of the header
    channel: str = ""  # Name of the channel
    unit: str = ""  # Unit of the heights as the file spells it
    factor: float = 1.0  # Factor to this unit
    lateral: float | None = None  # Unit [m] of coordinates of points; 0 if unknown
    pixel: tuple[float, float] | None = None  # Pixel edges `(dy, dx)` [m]
    sides: tuple[float, float] | None = None  # Sides `(y, x)` [m]
    points: tuple[int, int] | None = None  # Rows and columns of the matrix
    turned: bool = False  # Whether a line of the file is along y
    columns: bool = False  # Whether three columns are named x, y and z
    skipped: bool = False  # Whether its lines were not understood
    doubtful: int = 0  # Number of its last lines that may be rows with a damaged number
    texts: tuple[str, ...] = ()  # Its lines
    announced: str = ""  # Number of values that a separate line states
    values: Array | None = None  # Heights in the unit, where the file has no rows of them

    @property
    def is_map(self) -> bool:
        """Whether the header describes a matrix."""
        return bool(self.points or self.sides or self.pixel)

    def pixel_of(self, shape: Shape) -> tuple[float, float] | None:
        """Return the pixel edges [m] of a matrix of this shape, if the header has them."""
        if self.sides is not None:
            return self.sides[0] / shape[0], self.sides[1] / shape[1]
        return self.pixel


_ZYGO = re.compile(r"Zygo (\w+) Data File - Format (\d)", re.IGNORECASE)
# Line of the camera resolution [m], and its place.
_ZYGO_LINES, _ZYGO_CAMERA = 40, (7, 6)
# Phases of a wave by the code of their resolution, and phases from which points are missing.
_PHASES, _NO_PHASE = (4096, 32768, 131072), 2147483640

_QUOTED = re.compile(r'"([^"]*)"')


def parse_export(path: Path, lines: Iterable[str], limit: int) -> tuple[Head | None, list[str]]:
    """Return the header of an export, if the lines are one, and the lines that were read."""
    first = next(iter(lines), "")
    zygo = _ZYGO.match(first)
    if zygo is not None:
        kind = zygo[1].lower(), zygo[2]
        if kind not in (("xyz", "1"), ("ascii", "2")):
            raise FormatError(
                f"{path.name} holds Zygo's {zygo[1]} in format {zygo[2]}; export it as XYZ or .dat"
            )
        return (_parse_zygo(lines) if kind[0] == "xyz" else _parse_phases(path, lines)), []
    read = [first]
    entries: list[list[str]] = []
    while len(read) < limit and (cells := _QUOTED.findall(read[-1])):
        entries.append(cells)
        if len(cells) == 1 and len(entries) > 1:
            break
        read.append(next(iter(lines), ""))
        while len(read) < limit and read[-1] and not read[-1].strip():
            read.append(next(iter(lines), ""))
    return _parse_entries(path, entries, len(read)), read


def _parse_zygo(lines: Iterable[str]) -> Head:
    """Return the header of Zygo's points, whose coordinates are counted in pixels."""
    rows = [
        line.split()
        for line in itertools.takewhile(
            lambda line: line.strip() != "#", itertools.islice(lines, _ZYGO_LINES)
        )
    ]
    # The first line was read before.
    line, place = _ZYGO_CAMERA
    try:
        camera = float(rows[line - 1][place])
    except (IndexError, ValueError):
        camera = 0.0
    return Head(len(rows) + 2, unit="um", lateral=camera, columns=True)


def _parse_phases(path: Path, lines: Iterable[str]) -> Head:
    """Return scale and heights of Zygo's phases."""
    with damage_as_error(path, "phases of Zygo (format 2)", "copy or export it again"):
        parts = [
            list(itertools.takewhile(lambda line: line.strip() != "#", part))
            for part in (itertools.islice(lines, _ZYGO_LINES), lines, lines)
        ]
        rows = [line.split() for line in parts[0]]
        nx, ny = map(int, rows[2][2:4])
        scale, wave, _, obliquity, _, camera = map(float, rows[6][1:7])
        memory.require_points(path.name, (ny, nx), _BYTES_PER_POINT)
        phases = np.array(" ".join(parts[2]).split(), dtype=np.float64).reshape(ny, nx)
        phases[phases >= _NO_PHASE] = np.nan
        step = scale * wave * obliquity / _PHASES[int(rows[9][0])]
    pixel = (camera, camera) if camera > 0 else None
    return Head(1, unit="m", factor=step, pixel=pixel, points=(ny, nx), values=phases)


def _parse_entries(path: Path, entries: list[list[str]], lines: int) -> Head | None:
    """Return the header in quoted entries that end in the name of a quantity."""
    place = next((i for i, cells in enumerate(entries) if len(cells) == 3 and "XY" in cells[0]), 0)
    if not place or len(entries[-1]) != 1:
        return None
    (_, edge, unit), channel = entries[place], entries[-1][0]
    heights = [cells[1] for cells in entries[place:] if len(cells) == 2]
    found = next((word for word in reversed(heights) if word and is_length(path, word)), None)
    if found is None:
        raise FormatError(f"{path.name} holds {channel!r}, no heights; export the heights")
    try:
        pixel = float(edge.replace(",", ".")) * unit_in_meters(path, unit)
    except ValueError:
        raise FormatError(f"{path.name} states its pixel wrongly: {edge!r} {unit}") from None
    counts = next(
        (
            (int(below), int(word))
            for word, below in itertools.pairwise(heights)
            if word.isdecimal() and below.isdecimal()
        ),
        None,
    )
    return Head(lines, channel=channel, unit=found, pixel=(pixel, pixel), points=counts)


_END = re.compile(r"^\s*(?:EOR|\x03)\s*$", re.MULTILINE)
_MISSING = re.compile(r"^\s*(?:BAD|NaN|-+)\s*$", re.IGNORECASE | re.MULTILINE)
# Heights in their unit, NaN where missing, the unit [m], and the distance of the points [m].
_Profile = tuple[Array, float, float]


def _load(path: Path) -> _Profile:
    memory.require_size(path.name, path.stat().st_size)
    with damage_as_error(path, "a profile in records", "copy or export it again"):
        text = path.read_text(encoding="latin-1").replace("\0", " ")
        profile = _sigma_surf(text) if text.startswith("SigmaSurf") else _records(path, text)
    heights, _, spacing = profile
    if heights.size < 2 or not spacing > 0:
        raise FormatError(
            f"{path.name} lists {heights.size} points {spacing:g} m apart, no profile; export it "
            "again"
        )
    return profile


def _records(path: Path, text: str) -> _Profile:
    records = _END.split(text)
    lines = [line.split() for line in itertools.chain(*(part.splitlines() for part in records[:2]))]
    (_, _, count, unit, factor, *_) = axis = next(line for line in lines if line[:1] == ["CZ"])
    along = next(line for line in lines if line[:1] == ["CX"])
    spacing = next((line[2] for line in lines if line[:2] == ["SPACING", "CX"]), along[-1])
    if axis[1] == "R":
        raise FormatError(f"{path.name} holds heights relative to each other; export it again")
    heights = _numbers(records[2])
    if heights.size != round(float(count)):
        raise ValueError(f"{heights.size} heights, {count} announced")
    return (
        heights,
        float(factor) * unit_in_meters(path, unit.lower()),
        float(spacing) * float(along[4]) * unit_in_meters(path, along[3].lower()),
    )


def _sigma_surf(text: str) -> _Profile:
    head, _, body = text.partition("PROFILE_UM:")
    found = re.search(r"SPACING_UM:\s*(\S+)", head)
    if found is None:
        raise ValueError("no SPACING_UM")
    return _numbers(body), 1e-6, float(found[1]) * 1e-6


def _numbers(text: str) -> Array:
    return np.array(_MISSING.sub("nan", text).split(), dtype=np.float64)


def read_profile(path: Path, name: str, requested: ReadOptions) -> Surface:
    """Return the profile in a file."""
    heights, unit, spacing = _load(path)
    refuse_unit(path, requested)
    requested.check_shape((1, heights.size))
    about = Provenance(path.name, f"profile ({name})")
    return make_surface(path, heights[None], unit, requested, about, (PROFILE_WIDTH, spacing))


def profile_channels(path: Path, name: str) -> tuple[Channel, ...]:
    """Return the profile as the only channel."""
    return (Channel("", "", True, (1, _load(path)[0].size)),)
