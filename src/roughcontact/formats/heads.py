"""Heads of text files: what other programs write above a matrix or a list of points.

Understood are those of Gwyddion (matrix and points, in its languages), SPIP, Attocube, Nova, Koala
and Wyko, and the names of three columns. Whatever else stands there is left alone.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from roughcontact import units
from roughcontact.errors import FormatError, InputError
from roughcontact.formats.scale import is_length, unit_in_metres

MOST_LINES = 200
"""Lines in which a head must end."""

# Characters of a line of a head.
_LONGEST = 4096

_NUMBER = r"[-+]?\d*[.,]?\d+(?:[eE][-+]?\d+)?"
_IS = r"\s*[:=：]\s*"

# Gwyddion translates what it writes.
_CHANNEL = "Channel|Kanál|Kanal|Canal|Canale|チャネル|채널|Канал"
_WIDTH = "Width|Šířka|Breite|Anchura|Largeur|Larghezza|幅|폭|Largura|Ширина"
_HEIGHT = "Height|Výška|Höhe|Altura|Hauteur|Altezza|高さ|높이|Высота"
_VALUES = (
    "Value units|Jednotky hodnot|Einheiten|Unités|unità valore|値の単位|값 단위"
    "|Unidades de valor|Единицы измерения"
)

# Key of a line -> pattern with its value.
_KEYS = {
    key: re.compile(pattern, re.IGNORECASE)
    for key, pattern in {
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
    }.items()
}

# A number, or what stands where one is missing; a decimal comma parts it into two.
_CELL = re.compile(
    r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|nan|bad|n/?a|\*+|-{2,}", re.IGNORECASE
)

# Names of three columns, each perhaps with its unit: X [mm], y (um), z/nm.
_COLUMN = re.compile(r"\s*([xyz])\w*\s*(?:[\[(/]\s*([^\])\s]+)\s*[\])]?)?\s*", re.IGNORECASE)

# What tells that a head describes a map: without one of these it is a remark.
_TELLING = {
    "side_x", "points", "points_x", "pixel", "pixel_x", "wyko", "unit_x", "columns",
}  # fmt: skip


@dataclass(frozen=True)
class Head:
    """What a text file says of its numbers.

    Parameters
    ----------
    lines : int
        Lines that it takes.
    channel : str
        Name of what is in the file; empty if it is not named.
    unit : str
        Unit of the heights as the file spells it; empty if it gives none.
    factor : float
        What the numbers are multiplied with to be in that unit.
    lateral : float or None
        Unit [m] of coordinates of points; None if there is none.
    pixel : (float, float) or None
        Pixel edges ``(dy, dx)`` [m].
    sides : (float, float) or None
        Sides ``(y, x)`` [m].
    points : (int, int) or None
        Rows and columns of the matrix.
    turned : bool
        Whether a line of the file runs along y.
    columns : bool
        Whether it names three columns x, y and z.
    """

    lines: int
    channel: str = ""
    unit: str = ""
    factor: float = 1.0
    lateral: float | None = None
    pixel: tuple[float, float] | None = None
    sides: tuple[float, float] | None = None
    points: tuple[int, int] | None = None
    turned: bool = False
    columns: bool = False

    @property
    def is_map(self) -> bool:
        """Whether it describes a matrix."""
        return bool(self.points or self.sides or self.pixel)

    def pixel_of(self, shape: tuple[int, int]) -> tuple[float, float] | None:
        """Return the pixel edges [m] of a matrix of so many points, if the head tells."""
        if self.sides is not None:
            return self.sides[0] / shape[0], self.sides[1] / shape[1]
        return self.pixel


def head_of(path: Path, lines: Iterable[str]) -> Head | None:
    """Return what the first lines of a text say of its numbers.

    Parameters
    ----------
    path : Path
        The file, for messages.
    lines : iterable of str
        Its lines, as far as they are needed.

    Returns
    -------
    Head or None
        None where nothing is said, or in words that are not known.

    Raises
    ------
    FormatError
        If what is said contradicts itself, or is of something else than heights.
    """
    found: dict[str, tuple[str, ...]] = {}
    count = 0
    for line in itertools.islice(lines, MOST_LINES):
        if is_data(line):
            break
        text = line[:_LONGEST].strip()
        count += 1
        for key, pattern in _KEYS.items():
            match = pattern.search(text)
            if match is not None:
                found.setdefault(key, match.groups())
        columns = _columns(text)
        if columns:
            found["columns"] = columns
    else:
        return None
    if not _TELLING & found.keys():
        return None
    try:
        return _understood(path, found, count)
    except InputError as error:
        raise FormatError(f"{path.name} states its scale wrongly: {error}") from None


def begins(line: str) -> bool:
    """Return whether a line between numbers begins another map."""
    return any(_KEYS[key].search(line) for key in ("channel", "side_x"))


def is_data(text: str) -> bool:
    """Return whether a line holds numbers, or words for missing points, and nothing else.

    Of a long one only the beginning is looked at.
    """
    cells = re.split(r"[;,\s]+", text[:_LONGEST].strip())
    if len(text) > _LONGEST:
        cells = cells[:-1]
    return any(cells) and all(_CELL.fullmatch(cell) for cell in cells if cell)


def _columns(text: str) -> tuple[str, ...]:
    """Return the units of columns named x, y and z, empty where there is none; () for others."""
    cells = re.split(r"[;,\t]", text.lstrip("# "))
    matches = [_COLUMN.fullmatch(cell) for cell in cells]
    if len(cells) != 3 or not all(matches):
        return ()
    named = [(match[1].lower(), match[2] or "") for match in matches if match is not None]
    if [name for name, _ in named] != ["x", "y", "z"]:
        return ()
    return tuple(unit for _, unit in named)


def _understood(path: Path, found: dict[str, tuple[str, ...]], lines: int) -> Head:
    """Return the head that was found in words."""
    head = Head(lines, channel=_first(found, "channel").strip())
    if "wyko" in found:
        return _wyko(head, found)
    head = replace(head, points=_points(found))
    head = _heights(path, head, found)
    if "columns" in found:
        x, y, z = found["columns"]
        lateral = unit_in_metres(path, x) if x and x == y else None
        return replace(head, unit=z or head.unit, lateral=lateral, columns=True)
    lateral = _lateral(path, found)
    if "side_x" in found and "side_y" in found:
        # Of SPIP, whose lengths have no unit, they are nanometers.
        default = lateral or (1e-9 if "ascii" in found else None)
        if default is None and not all(_has_unit(found[f"side_{axis}"][0]) for axis in "yx"):
            # Points rather than lengths, for all that is known.
            return head
        sides = [_length(found, f"side_{axis}", default) for axis in "yx"]
        return replace(head, sides=(sides[0], sides[1]))
    if "pixel" in found:
        edge = _length(found, "pixel", None)
        return replace(head, pixel=(edge, edge))
    if "pixel_x" in found and "pixel_y" in found:
        dy, dx = (_length(found, f"pixel_{axis}", lateral) for axis in "yx")
        return replace(head, pixel=(dy, dx))
    return replace(head, lateral=lateral)


def _heights(path: Path, head: Head, found: dict[str, tuple[str, ...]]) -> Head:
    """Return a head with the unit of its heights, and the factor to it."""
    unit = _first(found, "unit").strip()
    if "koala" in found and not (unit and is_length(path, unit)):
        unit, factor = found["koala"]
        return replace(head, unit=unit, factor=_float(factor))
    if not unit and "spip" in found:
        return replace(head, unit="nm", factor=_float(_first(found, "spip")))
    if unit and not is_length(path, unit):
        named = f" {head.channel!r}" if head.channel else ""
        raise FormatError(f"{path.name} holds{named} in {unit!r}, no heights; export the heights")
    return replace(head, unit=unit, factor=_float(_first(found, "factor") or "1"))


def _wyko(head: Head, found: dict[str, tuple[str, ...]]) -> Head:
    """Return the head of Wyko: a line for each x, pixels in mm, heights in nm or wavelengths."""
    factor = 1.0
    if _first(found, "wyko") == "0" and {"wyko_wave", "wyko_mult"} <= found.keys():
        factor = _float(_first(found, "wyko_wave")) / _float(_first(found, "wyko_mult"))
    pixel = None
    if "wyko_pixel" in found:
        edge = 1e-3 * _float(_first(found, "wyko_pixel"))
        pixel = edge, edge * _float(_first(found, "wyko_aspect") or "1")
    points = None
    if {"wyko_x", "wyko_y"} <= found.keys():
        points = int(_first(found, "wyko_y")), int(_first(found, "wyko_x"))
    return replace(head, unit="nm", factor=factor, pixel=pixel, points=points, turned=True)


def _points(found: dict[str, tuple[str, ...]]) -> tuple[int, int] | None:
    if "points" in found:
        rows, columns = found["points"]
        return int(rows), int(columns)
    if {"points_x", "points_y"} <= found.keys():
        return int(_first(found, "points_y")), int(_first(found, "points_x"))
    return None


def _lateral(path: Path, found: dict[str, tuple[str, ...]]) -> float | None:
    """Return the unit [m] of lengths along x and y."""
    along_x, along_y = _first(found, "unit_x").strip(), _first(found, "unit_y").strip()
    if not along_x:
        return None
    if along_y and along_y != along_x:
        raise FormatError(
            f"{path.name} has lengths along x in {along_x!r} and along y in {along_y!r}; export it "
            "with one unit"
        )
    return unit_in_metres(path, along_x)


def _length(found: dict[str, tuple[str, ...]], key: str, metre: float | None) -> float:
    text = _first(found, key).strip()
    number = re.match(_NUMBER, text)
    assert number is not None
    unit = text[number.end() :].strip()
    if unit or metre is None:
        return units.parse(f"{_float(number[0])!r} {unit}", "length", key)
    return _float(number[0]) * metre


def _has_unit(text: str) -> bool:
    return re.fullmatch(_NUMBER, text.strip()) is None


def _first(found: dict[str, tuple[str, ...]], key: str) -> str:
    return found.get(key, ("",))[0]


def _float(text: str) -> float:
    return float(text.replace(",", "."))
