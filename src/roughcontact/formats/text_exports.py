"""Headers of text files, and those of exports that describe their values by position.

`parse_export`: Zygo's XYZ, format 1, as in the reference of MetroPro: 13 lines and ``#``, the pixel
[m] as seventh number of line 8, heights in micrometers. Keyence's CSV: lines ``"key","value"`` and
``"key","value","unit"``, then the name of the quantity and the rows; keys are translated, so that
the order and the units decide.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from roughcontact.errors import FormatError
from roughcontact.formats.source import is_length, unit_in_meters


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

    @property
    def is_map(self) -> bool:
        """Whether the header describes a matrix."""
        return bool(self.points or self.sides or self.pixel)

    def pixel_of(self, shape: tuple[int, int]) -> tuple[float, float] | None:
        """Return the pixel edges [m] of a matrix of this shape, if the header has them."""
        if self.sides is not None:
            return self.sides[0] / shape[0], self.sides[1] / shape[1]
        return self.pixel


_ZYGO = re.compile(r"Zygo \w+ Data File - Format (\d)", re.IGNORECASE)
# Line of the camera resolution [m], and its place.
_ZYGO_LINES, _ZYGO_CAMERA = 40, (7, 6)

_QUOTED = re.compile(r'"([^"]*)"')


def parse_export(path: Path, lines: Iterable[str], limit: int) -> tuple[Head | None, list[str]]:
    """Return the header of an export, if the lines are one, and the lines that were read."""
    first = next(iter(lines), "")
    zygo = _ZYGO.match(first)
    if zygo is not None:
        if zygo[1] != "1":
            raise FormatError(
                f"{path.name} holds phases of Zygo (format {zygo[1]}), no heights; export it as XYZ"
            )
        return _parse_zygo(lines), []
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
