"""Profiles: positions and heights in two columns of text, brought to equal distances."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact import limits
from roughcontact.errors import FormatError, InputError, Mention
from roughcontact.formats import content
from roughcontact.formats.scale import asked_pixel, in_metres, is_length, unit_in_metres
from roughcontact.formats.source import Asked, surface_of
from roughcontact.surface.grid import WIDTH
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface
from roughcontact.units import engineering

Array = NDArray[np.float64]

FEWEST = 9
"""Points below which columns may as well be a narrow map, where nothing names their units."""

_FEWEST_NAMED = 3

# Bytes that reading takes a point, and lines in front of the first numbers, at most.
_EACH, _HEAD = 200, 200
# Characters of a line, which has two numbers.
_LONGEST = 10_000
# Distance from an even grid that is rounding of what is printed, over the step; steps over the
# median from which nothing was measured in between.
_EVEN, _GAP = 0.02, 5.0
# Share of steps unlike the median, and deviation from an even grid over the last digit, by which
# positions are rounded.
_MIXED, _ROUNDED = 0.1, 1.2

_NUMBER = r"[+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][+-]?\d+)?"
_BLANK = r"|nan|n/?a|bad|\*+|-{2,}"
_CELL = re.compile(rf"\s*(?:{_NUMBER}{_BLANK})\s*", re.IGNORECASE)
_OF_A_MAP = "# roughcontact map"
_FILLED = re.compile(rf"\s*{_NUMBER}\s*")
_BRACKETED = re.compile(r"[\[(]\s*([a-zA-Z\u00b5\u03bcÅ]+)\s*[\])]")
_UNIT = re.compile(r"[\[(/]\s*([a-zA-Z\u00b5\u03bcÅ]+)\s*[\])]?\s*$")
# A unit without brackets, where nothing else could be meant: "x in um", "Raw Micrometer".
_WORD = re.compile(
    r"(?:^|[\s_])([munp\u00b5\u03bc]?m|Å|microns?|(?:[Mm]illi|[Mm]icro|[Nn]ano)?[Mm]et(?:er|re)s?)\s*$"
)

# Names of a third column: behind the heights, or in front of the positions.
_VALID = re.compile(r"\s*valid\s*", re.IGNORECASE)
_NUMBERED = re.compile(r"\W*(?:index|number|point|sample|nr|no|n|i)?\W*", re.IGNORECASE)


@dataclass(frozen=True)
class Trace:
    """Two columns of a text.

    Parameters
    ----------
    columns : ndarray, shape (n, 2)
        Positions and heights, in their units; NaN where missing.
    units : (str, str)
        Of either, as the head of the columns names it; empty where it does not.
    """

    columns: Array
    units: tuple[str, str]


def found(path: Path) -> Trace | None:
    """Return the trace in a text; None if it holds no two columns of which the first advances.

    A third column may number the points in front of them, or mark behind them which are valid.

    Parameters
    ----------
    path : Path
        The file.
    """
    head: list[str] = []
    rows: list[tuple[float, ...]] = []
    room, count = 0, ""
    try:
        with content.opened(path) as stream:
            while line := stream.readline(_LONGEST):
                text = line.split("#", 1)[0].strip(" \r\n") if rows else line.strip(" \r\n")
                cells = _cells(text)
                numbers = all(map(_CELL.fullmatch, cells))
                if not (numbers and len(cells) in (2, 3)):
                    no_head = numbers and any(map(_FILLED.fullmatch, cells))
                    if no_head and len(cells) == 1 and not rows and not count:
                        # How many follow.
                        count = cells[0].strip()
                        continue
                    if (rows and text) or no_head or len(line) == _LONGEST or len(head) == _HEAD:
                        return None
                    if text.startswith(_OF_A_MAP):
                        return None
                    head.append(text)
                    continue
                if len(cells) != (len(rows[0]) if rows else 3 if _third(head) else 2):
                    return None
                if len(rows) >= room:
                    room = 2 * room + 1024
                    limits.require_points(path.name, (room, len(cells)), _EACH)
                rows.append(tuple(map(_value, cells)))
    # Whoever reads a map tells what is wrong with the file.
    except (UnicodeDecodeError, OSError):
        return None
    if not rows or (count and count not in (str(len(rows)), str(len(rows) - 1))):
        return None
    return _of_rows(np.array(rows, dtype=np.float64), head)


def _third(head: Sequence[str]) -> str:
    """Return what the third column of a trace is by its name; empty if nothing names one."""
    named = [cells for line in head if len(cells := _cells(line.lstrip("# "))) == 3]
    if any(_VALID.fullmatch(cells[2]) for cells in named):
        return "valid"
    return "number" if any(_NUMBERED.fullmatch(cells[0]) for cells in named) else ""


def _of_rows(values: Array, head: Sequence[str]) -> Trace | None:
    """Return the trace in rows of two or three numbers below a head."""
    third = _third(head) if values.shape[1] == 3 else ""
    if third == "valid":
        values[values[:, 2] != 1.0, 1] = np.nan
    first = int(third == "number")
    return in_columns(values[:, first : first + 2], _units(head, values.shape[1], first))


def in_columns(values: NDArray[Any], units: tuple[str, str] = ("", "")) -> Trace | None:
    """Return the trace in two columns of numbers; None unless the first only rises or only falls.

    Parameters
    ----------
    values : ndarray, shape (n, m)
        Numbers.
    units : (str, str)
        Of positions and heights, where they are known.
    """
    if values.shape[1] != 2 or len(values) < (_FEWEST_NAMED if any(units) else FEWEST):
        return None
    columns = values.astype(np.float64)
    steps = np.diff(columns[:, 0])
    return Trace(columns, units) if (steps > 0).all() or (steps < 0).all() else None


def read(path: Path, trace: Trace, asked: Asked) -> Surface:
    """Return the profile of a trace.

    Parameters
    ----------
    path : Path
        The file it is from.
    trace : Trace
        What it holds.
    asked : Asked
        What is said of it: units of positions and heights with a comma between them, or that of
        the heights where the file gives that of the positions.

    Raises
    ------
    FormatError, InputError
        As for `roughcontact.read_surface`.
    """
    along, across = _metres(path, trace.units, asked)
    position, heights = trace.columns.T
    even, spacing, notes = evenly(position * along, heights, _last_digit(position) * along)
    if asked.unit is not None and all(trace.units):
        notes += (f"read: units {' and '.join(trace.units)} of the file replaced by {asked.unit}",)
    stated = (WIDTH, spacing)
    asked.expect((1, even.size))
    pixel = asked_pixel(path, stated, (1, even.size), asked)
    about = Provenance(path.name, "profile (text)", "", notes)
    return surface_of(path, in_metres(even[None], across), pixel, about, across, stated)


def evenly(
    position: Array, heights: Array, digit: float = 0.0
) -> tuple[Array, float, tuple[str, ...]]:
    """Return the heights of a trace at equal distances.

    Parameters
    ----------
    position, heights : ndarray, shape (n,)
        Where the stylus was [m], rising or falling, and how high; NaN where missing.
    digit : float
        What the positions are rounded to [m]: steps that differ by no more are equal ones.

    Returns
    -------
    heights : ndarray, shape (m,)
        At equal distances, by linear interpolation where those of the file are not equal; NaN
        where two positions lie further apart than five times the median distance.
    spacing : float
        Their distance [m].
    notes : tuple of str
        What was done, in sentences.
    """
    if position[0] > position[-1]:
        position, heights = position[::-1], heights[::-1]
    steps = np.diff(position)
    length, median = float(position[-1] - position[0]), float(np.median(steps))
    mean = length / steps.size
    off = position - position[0] - mean * np.arange(position.size)
    if np.abs(off).max() <= _EVEN * mean:
        return np.ascontiguousarray(heights), mean, ()
    # Equal steps rounded are short and long ones in turn; one that is missing is a single long one.
    if digit and np.mean(np.abs(steps - median) > 0.5 * digit) > _MIXED:
        index = np.arange(position.size) - 0.5 * steps.size
        slope = float(np.sum(index * off) / np.sum(index**2)) + mean
        if np.ptp(position - slope * index) <= _ROUNDED * digit:
            text = (engineering(value, "m", 3) for value in (digit, slope))
            note = "read: positions rounded to {} are taken as {} apart".format(*text)
            return np.ascontiguousarray(heights), slope, (note,)
    count = round(length / median) + 1
    limits.require_points("the profile", (1, count), _EACH)
    spacing = length / (count - 1)
    place = position[0] + spacing * np.arange(count)
    even = np.interp(place, position, heights)
    left = np.clip(np.searchsorted(position, place, "right") - 1, 0, steps.size - 1)
    beside = np.minimum(place - position[left], position[left + 1] - place)
    even[(steps[left] > _GAP * median) & (beside > 0.5 * spacing)] = np.nan
    few, many = (engineering(float(end), "m", 3) for end in (steps.min(), steps.max()))
    note = (
        f"read: {heights.size} points {few} to {many} apart, brought to {count} at equal distances "
        f"of {engineering(spacing, 'm')} by linear interpolation"
    )
    return even, spacing, (note,)


def _last_digit(position: Array) -> float:
    """Return the decimal place that positions are rounded to; 0 where they have many digits."""
    places = (p for p in range(7) if np.array_equal(np.round(position, p), position))
    return next((10.0**-p for p in places), 0.0)


def _cells(text: str) -> list[str]:
    for mark in (";", "\t"):
        if mark in text:
            cells = text.split(mark)
            break
    else:
        # A comma beside white space is a decimal one.
        words = text.split()
        cells = words if len(words) > 1 and all(map(_CELL.fullmatch, words)) else text.split(",")
        if len(cells) == 1:
            cells = words
    # Many programs end each row with the mark, some with several.
    while len(cells) > 2 and not cells[-1].strip():
        cells = cells[:-1]
    return cells


def _value(cell: str) -> float:
    text = cell.strip().replace(",", ".")
    return float(text) if re.fullmatch(_NUMBER, text) else math.nan


def _units(head: Sequence[str], count: int = 2, first: int = 0) -> tuple[str, str]:
    """Return the units that the last line in front of the numbers gives positions and heights.

    They are in the column ``first`` of ``count``, and in the next.
    """
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
    """Return the unit of length with which the name of a column ends; empty if with none."""
    match = _UNIT.search(cell) or _WORD.search(cell)
    if match is None:
        return ""
    word = match[1] if len(match[1]) < 4 else match[1].lower()
    return word if is_length(Path(), word) else ""


def _metres(path: Path, stated: tuple[str, str], asked: Asked) -> tuple[float, float]:
    """Return the units of positions and heights [m]: as said of the file, or else by its head.

    A single unit is that of the heights.
    """
    said = [] if asked.unit is None else [word.strip() for word in asked.unit.split(",")]
    if len(said) == 1:
        said = [stated[0], *said]
    words = said or list(stated)
    if len(words) == 2 and all(words):
        return unit_in_metres(path, words[0]), unit_in_metres(path, words[1])
    if asked.unit is None and stated[0]:
        raise InputError(
            f"{path.name} is a profile with positions in {stated[0]}, but gives no unit of its "
            "heights; give it, e.g. ", Mention("unit", "um"),
        )  # fmt: skip
    problem = "gives no units of its positions and heights"
    if asked.unit is not None:
        problem = f"needs two units, of its positions and heights, got {asked.unit!r}"
    raise InputError(
        f"{path.name} is a profile and {problem}; give both in this order, e.g. ",
        Mention("unit", "mm, um"),
    )


def column(path: Path, heights: Array, asked: Asked) -> Surface:
    """Return the profile that a single column or a single row of heights is.

    Parameters
    ----------
    path : Path
        The file it is from.
    heights : ndarray, shape (n,)
        Heights in their unit.
    asked : Asked
        What is said of it, its unit and its length.
    """
    if heights.size < 2:
        raise FormatError(f"{path.name} holds one number, no heights of a map or a profile")
    metre = unit_in_metres(path, asked.unit)
    asked.expect((1, heights.size))
    pixel = asked_pixel(path, None, (1, heights.size), asked)
    about = Provenance(path.name, "profile (text)")
    return surface_of(path, in_metres(heights[None], metre), pixel, about, metre)
