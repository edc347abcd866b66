"""Text to values: one parser for every kind of option."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from roughcontact import units
from roughcontact.errors import InputError

if TYPE_CHECKING:
    from roughcontact.material.material import Material
    from roughcontact.surface.nominal import Body

_HARDNESS = re.compile(r"\bH(V|B|BW|RB|RC)\d*\b", re.IGNORECASE)


def quantity(dimension: str) -> Callable[[str, str], float]:
    """Return a parser of numbers with a unit of that dimension."""
    return lambda text, name: units.parse(text, dimension, name)


def words(text: str, name: str) -> str:
    """Return the text as it is."""
    return text


def path(text: str, name: str) -> Path:
    """Return a path."""
    return Path(text)


def flag(text: str, name: str) -> bool:
    """Return whether it is true."""
    if text.lower() not in ("true", "false"):
        raise InputError(f"{name} must be true or false, got {text!r}")
    return text.lower() == "true"


def number(text: str, name: str) -> float:
    """Return a number without a unit."""
    try:
        return float(text)
    except ValueError:
        raise InputError(f"{name} must be a number without a unit, got {text!r}") from None


def whole(text: str, name: str) -> int:
    """Return a whole number."""
    try:
        return int(text)
    except ValueError:
        raise InputError(f"{name} must be a whole number, got {text!r}") from None


def choice(*known: str) -> Callable[[str, str], str]:
    """Return a parser that takes one of the words known."""

    def chosen(text: str, name: str) -> str:
        if text not in known:
            raise InputError(f"{name} must be one of {', '.join(known)}, got {text!r}")
        return text

    return chosen


def ceiling(text: str, name: str) -> str | float | None:
    """Return a pressure, ``"auto"``, or None for none; a hardness becomes its pressure."""
    from roughcontact.material import hardness

    plain = text.strip()
    if plain == "none":
        return None
    if plain == "auto":
        return plain
    if _HARDNESS.search(plain):
        try:
            return hardness.ceiling(plain)
        except InputError as error:
            raise InputError(f"{name}: {error}") from None
    return units.parse(text, "pressure", name)


def material(text: str, name: str) -> Material:
    """Return a material of the catalogue."""
    from roughcontact.material import catalogue

    try:
        return catalogue.material(text)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def hardening(text: str, name: str) -> tuple[str, tuple[float, ...]]:
    """Return a law of hardening by name, and its constants."""
    words = text.split()
    law, rest = (words[0].lower(), words[1:]) if words else ("", [])
    if law == "linear" and len(rest) == 2:
        return law, (units.parse(" ".join(rest), "pressure", name),)
    if law == "swift" and len(rest) == 4:
        strength = units.parse(" ".join(rest[:2]), "pressure", name)
        return law, (strength, number(rest[2], name), number(rest[3], name))
    raise InputError(
        f"{name} must read like 'linear 2 GPa' or 'swift 945 MPa 20 0.121', got {text!r}"
    )


def body(text: str, name: str) -> Body:
    """Return a nominal body."""
    from roughcontact.surface import nominal as bodies

    return bodies.parse(text, name)


def points(text: str, name: str) -> tuple[int, int]:
    """Return the points ``(ny, nx)`` of a grid."""
    match = re.fullmatch(r"\s*(\d+)(?:\s*[x×]\s*(\d+))?\s*", text)
    if match is None or int(match[1]) < 2:
        raise InputError(f"{name} must be a number of points such as 256 or 256x512, got {text!r}")
    return int(match[1]), int(match[2] or match[1])


def offset(text: str, name: str) -> tuple[float, float]:
    """Return two lengths (y, x)."""
    parts = text.split(",")
    if len(parts) != 2:
        raise InputError(f"{name} needs two lengths (y, x) such as '0 um, 5 um', got {text!r}")
    y, x = (units.parse(part, "length", name, positive=False) for part in parts)
    return y, x


def window(text: str, name: str) -> tuple[slice, slice]:
    """Return rows and columns to keep."""
    match = re.fullmatch(r"\s*(\d*)\s*:\s*(\d*)\s*,\s*(\d*)\s*:\s*(\d*)\s*", text)
    if match is None:
        raise InputError(
            f"{name} needs the first row and the row after the last, and the same of the columns, "
            f"such as 0:256,100:356, got {text!r}"
        )
    ends = [int(digits) if digits else None for digits in match.groups()]
    return slice(ends[0], ends[1]), slice(ends[2], ends[3])


def form(text: str, name: str) -> tuple[str, int | None]:
    """Return a form to remove and its degree, if it has one."""
    words = text.split()
    if words in (["sphere"], ["cylinder"]):
        return words[0], None
    if len(words) == 2 and words[0] == "polynomial" and words[1].isdigit():
        return "polynomial", int(words[1])
    raise InputError(f"{name} must be sphere, cylinder or 'polynomial N', got {text!r}")


def load_or_approach(text: str, name: str) -> tuple[str, float]:
    """Return which of the two a text with a unit is, and its value."""
    try:
        return "approach", units.parse(text, "length", name)
    except InputError:
        pass
    try:
        return "load", units.parse(text, "force", name)
    except InputError as error:
        reason = str(error)
    # Only where neither fits: a number that is not positive has its dimension.
    start, mark, found = reason.partition(", got ")
    if "needs a force" in start and mark:
        reason = f"{name} needs a load such as '1 N', or an approach such as '1 um', got {found}"
    raise InputError(reason)


def stage(text: str, name: str) -> tuple[str, float]:
    """Return which of load and approach a text is, and its value; a load may be zero."""
    plain = text.strip()
    if re.fullmatch(r"0+(\.0*)?\s*\w*N", plain):
        return "load", 0.0
    return load_or_approach(plain, name)


def turns(text: str, name: str) -> int:
    """Return a multiple of 90 degrees."""
    degrees = number(text, name)
    if degrees % 90:
        raise InputError(f"{name} must be a multiple of 90 degrees, got {text!r}")
    return int(degrees)
