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
from roughcontact.errors import FormatError, InputError
from roughcontact.formats.scale import asked_pixel, in_metres, is_length, unit_in_metres
from roughcontact.formats.source import Asked, surface_of
from roughcontact.surface.grid import WIDTH
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface
from roughcontact.units import engineering

Array = NDArray[np.float64]

FEWEST = 9
"""Points below which columns may as well be a narrow map."""

# Bytes that reading takes a point, and lines in front of the first numbers, at most.
_EACH, _HEAD = 200, 200
# Characters of a line, which has two numbers.
_LONGEST = 10_000
# Distance from an even grid that is rounding of what is printed, over the step; steps over the
# median from which nothing was measured in between.
_EVEN, _GAP = 0.02, 5.0

_NUMBER = r"[+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][+-]?\d+)?"
_BLANK = r"|nan|n/?a|bad|\*+|-{2,}"
_CELL = re.compile(rf"\s*(?:{_NUMBER}{_BLANK})\s*", re.IGNORECASE)
_OF_A_MAP = "# roughcontact map"
_FILLED = re.compile(rf"\s*{_NUMBER}\s*")
_BRACKETED = re.compile(r"[\[(]\s*([a-zA-Z\u00b5\u03bcÅ]+)\s*[\])]")
_UNIT = re.compile(r"[\[(/]\s*([a-zA-Z\u00b5\u03bcÅ]+)\s*[\])]?\s*$")


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

    Parameters
    ----------
    path : Path
        The file.
    """
    head: list[str] = []
    rows: list[tuple[float, float]] = []
    room = 0
    try:
        with path.open(encoding="utf-8-sig") as stream:
            while line := stream.readline(_LONGEST):
                text = line.split("#", 1)[0].strip(" \r\n") if rows else line.strip(" \r\n")
                cells = _cells(text)
                if len(cells) != 2 or not all(map(_CELL.fullmatch, cells)):
                    no_head = len(cells) != 2 and any(map(_FILLED.fullmatch, cells))
                    if (rows and text) or no_head or len(line) == _LONGEST or len(head) == _HEAD:
                        return None
                    if text.startswith(_OF_A_MAP):
                        return None
                    head.append(text)
                    continue
                if len(rows) >= room:
                    room = 2 * room + 1024
                    limits.require_points(path.name, (room, 2), _EACH)
                rows.append((_value(cells[0]), _value(cells[1])))
    # Whoever reads a map tells what is wrong with the file.
    except (UnicodeDecodeError, OSError):
        return None
    return in_columns(np.array(rows, dtype=np.float64).reshape(-1, 2), _units(head))


def in_columns(values: NDArray[Any], units: tuple[str, str] = ("", "")) -> Trace | None:
    """Return the trace in two columns of numbers; None unless the first only rises or only falls.

    Parameters
    ----------
    values : ndarray, shape (n, m)
        Numbers.
    units : (str, str)
        Of positions and heights, where they are known.
    """
    if values.shape[1] != 2 or len(values) < FEWEST:
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
        What is said of it: a unit of both columns, or those of positions and heights with a
        comma between them.

    Raises
    ------
    FormatError, InputError
        As for `roughcontact.read_surface`.
    """
    along, across = _metres(path, trace.units, asked)
    position, heights = trace.columns.T
    even, spacing, notes = evenly(position * along, heights)
    if asked.unit is not None and trace.units[0]:
        notes += (f"read: units {' and '.join(trace.units)} of the file replaced by {asked.unit}",)
    stated = (WIDTH, spacing)
    asked.expect((1, even.size))
    pixel = asked_pixel(path, stated, (1, even.size), asked)
    about = Provenance(path.name, "profile (text)", "", notes)
    return surface_of(path, in_metres(even[None], across), pixel, about, across, stated)


def evenly(position: Array, heights: Array) -> tuple[Array, float, tuple[str, ...]]:
    """Return the heights of a trace at equal distances.

    Parameters
    ----------
    position, heights : ndarray, shape (n,)
        Where the stylus was [m], rising or falling, and how high; NaN where missing.

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
    # Many programs end each row with the mark.
    return cells[:-1] if len(cells) > 2 and not cells[-1].strip() else cells


def _value(cell: str) -> float:
    text = cell.strip().replace(",", ".")
    return float(text) if re.fullmatch(_NUMBER, text) else math.nan


def _units(head: Sequence[str]) -> tuple[str, str]:
    """Return the units that the last line in front of the numbers gives its two columns."""
    for line in reversed(head):
        bracketed = _BRACKETED.findall(line)
        if len(bracketed) == 2 and all(is_length(Path(), word) for word in bracketed):
            return bracketed[0], bracketed[1]
        cells = _cells(line.lstrip("# "))
        if len(cells) == 2:
            named = [_UNIT.search(cell) for cell in cells]
            plain = [cell.strip() for cell in cells]
            words = [match[1] if match else cell for match, cell in zip(named, plain, strict=True)]
            if all(is_length(Path(), word) for word in words):
                return words[0], words[1]
    return "", ""


def _metres(path: Path, stated: tuple[str, str], asked: Asked) -> tuple[float, float]:
    """Return the units of positions and heights [m]."""
    words = list(stated) if stated[0] else []
    if asked.unit is not None:
        words = [word.strip() for word in asked.unit.split(",")]
    if not words or len(words) > 2:
        raise InputError(
            f"{path.name} is a profile and gives no units of its positions and heights; give them "
            "in this order, e.g. 'mm, um'",
            argument="unit",
        )
    return unit_in_metres(path, words[0]), unit_in_metres(path, words[-1])


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
