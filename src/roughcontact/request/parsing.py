"""Parsers of option values from text, one for every type of option.

Parameters are the text and the name of the argument, which errors contain.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Generic, NamedTuple, TypeVar, cast
from urllib.parse import urlsplit

from roughcontact import units
from roughcontact._tools import memory
from roughcontact.errors import ArgumentRef, InputError, input_error, require_count

if TYPE_CHECKING:
    from roughcontact.contact.load_case import Load
    from roughcontact.material.material import Layer, Material
    from roughcontact.surface.nominal_bodies import NominalBody


T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)


@dataclass(frozen=True)
class Parser(Generic[T_co]):
    """Function that returns the value of a text, with what help and page show of it."""

    function: Callable[[str, str], T_co]
    metavar: str = ""  # Placeholder of the value in the help; empty for flags
    unit: str = ""  # SI unit in which values are shown as text
    known: tuple[str, ...] = ()  # The only accepted texts, if any

    def __call__(self, text: str, argument: str) -> T_co:
        """Return the value of a text; errors name the argument."""
        return self.function(text, argument)

    def with_metavar(self, metavar: str) -> Parser[T_co]:
        """Return the parser with another placeholder of its value."""
        return replace(self, metavar=metavar)


def parser(metavar: str, unit: str = "") -> Callable[[Callable[[str, str], T]], Parser[T]]:
    """Return a decorator that makes a function a parser."""
    return lambda function: Parser(function, metavar, unit)


class Hardening(NamedTuple):
    """Hardening: name and constants of the law of the strength, modulus of the back stress."""

    law: str = ""
    constants: tuple[float, ...] = ()
    kinematic: float | None = None


# Name of a group, optionally in double quotes, and its files.
_GROUP = re.compile(r'\s*("(?:[^"]|"")*"\s*|[^="]*)=(.*)', re.DOTALL)
_NO_FORCE = re.compile(r"0+(\.0*)?\s*\w*N")
_DATA = re.compile(r"([0-9]+(?:\.[0-9]*)?)\s*(|[kMGT]|[KMGT]i)B")


def as_argument_error(argument: str, error: InputError) -> InputError:
    """Return an error of the library as an error of the argument that got the text."""
    own = () if error.argument is None else (ArgumentRef(error.argument), " ")
    return InputError(ArgumentRef(argument), ": ", *own, *error.parts)


def quantity(dimension: str) -> Parser[float]:
    """Return a parser of values with a unit of a dimension."""
    unit = {"length": "m", "pressure": "Pa"}.get(dimension, "")
    return Parser(
        lambda text, argument: units.parse(text, dimension, argument),
        dimension.upper().split()[-1],
        unit,
    )


@parser("NAME")
def as_text(text: str, argument: str) -> str:
    """Return the text unchanged."""
    return text


@parser("FILE")
def path(text: str, argument: str) -> Path:
    """Return a path."""
    return Path(text)


@parser("")
def flag(text: str, argument: str) -> bool:
    """Return the value of a flag, true or false."""
    if text.lower() not in ("true", "false"):
        raise input_error(argument, text, "must be true or false")
    return text.lower() == "true"


@parser("NUMBER")
def number(text: str, argument: str) -> float:
    """Return a number without a unit."""
    try:
        return float(text)
    except ValueError:
        raise input_error(argument, text, "must be a number without a unit") from None


DEGREES = number.with_metavar("DEGREES")


@parser("VALUE")
def no_data(text: str, argument: str) -> float | str | None:
    """Return the value of points without data, or the name of a rule for it."""
    from roughcontact.formats.no_data import parse_no_data

    return parse_no_data(text, argument)


def parse_int(text: str, argument: str) -> int:
    """Return an integer."""
    try:
        return int(text)
    except ValueError:
        raise input_error(argument, text, "must be a whole number") from None


def int_parser(minimum: int, maximum: int) -> Parser[int]:
    """Return a parser of integers from ``minimum`` to ``maximum``."""

    @parser("NUMBER")
    def parsed(text: str, argument: str) -> int:
        count = parse_int(text, argument)
        require_count(minimum, maximum, **{argument: count})
        return count

    return parsed


def count_or_auto(minimum: int, maximum: int) -> Parser[int | str]:
    """Return a parser of integers from ``minimum`` to ``maximum``, or ``"auto"``."""

    @parser("NUMBER|auto")
    def parsed(text: str, argument: str) -> int | str:
        if text == "auto":
            return text
        try:
            return int_parser(minimum, maximum)(text, argument)
        except InputError:
            if text.strip("+-").isdecimal():
                raise
        raise input_error(argument, text, "must be a whole number, or auto")

    return parsed


def choice(*known: str) -> Parser[str]:
    """Return a parser of one of several known texts."""

    def parsed(text: str, argument: str) -> str:
        if text not in known:
            raise input_error(argument, text, f"must be one of {', '.join(known)}")
        return text

    return Parser(parsed, "|".join(known), known=known)


@parser("PRESSURE", "Pa")
def ceiling(text: str, argument: str) -> str | float | None:
    """Return a pressure [Pa] (also from a hardness), the name of a ceiling, or None."""
    from roughcontact.contact.result import BASE, BRACKET, CALIBRATED, COATING
    from roughcontact.material import hardness

    plain = text.strip()
    if plain == "none":
        return None
    if plain in ("auto", CALIBRATED, COATING, BASE, BRACKET):
        return plain
    return hardness.stress(plain, argument)


@parser("NAME")
def material(text: str, argument: str) -> Material:
    """Return a material of the catalog."""
    from roughcontact.material import catalog

    try:
        return catalog.material(text)
    except InputError as error:
        error.argument = argument
        raise


@parser("LAYER")
def coating(text: str, argument: str) -> Layer:
    """Return a layer: name in the catalog or elastic constants, and thickness."""
    from roughcontact.material import catalog
    from roughcontact.material.material import Layer

    *words, thickness = text.replace(",", " ,").rsplit(maxsplit=2)
    thickness = f"{words.pop()} {thickness}" if len(words) > 1 else thickness
    name = " ".join(words).rstrip(" ,")
    try:
        if "=" not in name:
            return catalog.layer(name, units.parse(thickness, "length", argument))
        values = dict(part.split("=", 1) for part in name.replace(" ", "").split(",") if part)
        known = {_CONSTANTS[key.lower()]: value for key, value in values.items()}
        return Layer(thickness=thickness, poisson=float(known.pop("poisson")), **known)
    except InputError as error:
        if error.argument not in (None, argument):
            raise as_argument_error(argument, error) from None
        error.argument = argument
        raise
    except (KeyError, ValueError, TypeError):
        raise InputError(
            f"= {text!r}: give a name and a thickness, as 'DLC 2 um', or values, as "
            "'E=200 GPa, nu=0.2, 2 um'; further ones: Y (yield "
            "strength), H (hardness), S (residual stress), name",
            argument=argument,
            value=text,
        ) from None


_CONSTANTS = {
    "e": "young",
    "nu": "poisson",
    "y": "yield_strength",
    "h": "hardness",
    "name": "name",
    "s": "residual_stress",
}


@parser("LOADS")
def loads(text: str, argument: str) -> tuple[float | Load, ...]:
    """Return loads, separated by commas, in any order."""
    return tuple(load(part.strip(), argument) for part in text.split(","))


@parser("LAW")
def hardening(text: str, argument: str) -> Hardening:
    """Return the hardening law of the strength, the back stress, or both."""
    result = Hardening()
    for part in text.split(","):
        law, *rest = part.split() or [""]
        law = law.lower()
        if law == "linear" and len(rest) == 2 and not result.law:
            result = result._replace(law=law, constants=(_modulus(rest, argument),))
        elif law == "swift" and len(rest) == 4 and not result.law:
            constants = (_modulus(rest[:2], argument), *(number(n, argument) for n in rest[2:]))
            result = result._replace(law=law, constants=constants)
        elif law == "kinematic" and len(rest) == 2 and result.kinematic is None:
            result = result._replace(kinematic=_modulus(rest, argument))
        else:
            raise input_error(
                argument,
                text,
                "must read like 'linear 2 GPa', 'swift 945 MPa 20 0.121', 'kinematic 10 GPa' or "
                "two of them with a comma",
            )
    return result


def _modulus(words: list[str], argument: str) -> float:
    return units.parse(" ".join(words), "pressure", argument)


@parser("FORM")
def body(text: str, argument: str) -> NominalBody:
    """Return a nominal body."""
    from roughcontact.surface import nominal_bodies

    return nominal_bodies.parse(text, argument)


@parser("NUMBER|NYxNX")
def points(text: str, argument: str) -> tuple[int, int]:
    """Return the number of points ``(ny, nx)`` of a grid."""
    match = re.fullmatch(r"\s*(\d{1,18})(?:\s*[x×]\s*(\d{1,18}))?\s*", text)
    if match is None or int(match[1]) < 2:
        raise input_error(argument, text, "must be a number of points such as 256 or 256x512")
    grid = int(match[1]), int(match[2] or match[1])
    memory.require_grid(argument, grid)
    return grid


@parser("LENGTHS")
def offset(text: str, argument: str) -> tuple[float, float]:
    """Return two lengths (y, x)."""
    parts = text.split(",")
    if len(parts) != 2:
        raise input_error(argument, text, "needs two lengths (y, x) such as '0 um, 5 um'")
    y, x = (units.parse(part, "length", argument, positive=False) for part in parts)
    return y, x


@parser("LENGTHS")
def lengths(text: str, argument: str) -> tuple[float, ...]:
    """Return positive lengths, separated by commas."""
    return tuple(units.parse(part.strip(), "length", argument) for part in text.split(","))


@parser("ROWS,COLUMNS")
def window(text: str, argument: str) -> tuple[slice, slice]:
    """Return the rows and columns to keep."""
    match = re.fullmatch(
        r"\s*(\d{0,18})\s*:\s*(\d{0,18})\s*,\s*(\d{0,18})\s*:\s*(\d{0,18})\s*", text
    )
    if match is None:
        raise input_error(
            argument,
            text,
            "needs the first row and the row after the last, and the same of the columns, such as "
            "0:256,100:356",
        )
    ends = [int(digits) if digits else None for digits in match.groups()]
    return slice(ends[0], ends[1]), slice(ends[2], ends[3])


@parser("FORM")
def form(text: str, argument: str) -> tuple[str, int | None]:
    """Return the form to remove, and its degree, if any."""
    words = text.split()
    if words in (["sphere"], ["cylinder"]):
        return words[0], None
    if len(words) == 2 and words[0] == "polynomial" and re.fullmatch("[0-9]{1,18}", words[1]):
        return "polynomial", int(words[1])
    raise input_error(argument, text, "must be sphere, cylinder or 'polynomial N'")


@parser("LOAD", "N")
def load(text: str, argument: str) -> float | Load:
    """Return a force [N], or another form of load."""
    from roughcontact.contact import load_case

    return cast("float | Load", load_case.parse_required_load(text, argument))


@parser("PRESSURE", "Pa")
def nominal(text: str, argument: str) -> float:
    """Return a nominal pressure [Pa]."""
    needs = "a nominal pressure such as '20 MPa', the same for maps of all sizes"
    return units.parse(text, "pressure", argument, needs=needs)


@parser("SIZE")
def parse_bytes(text: str, argument: str) -> int:
    """Return a number of bytes: ``"1 GiB"``, ``"500 MB"``."""
    result = _DATA.fullmatch(text.strip())
    size = 0.0
    if result is not None:
        base = 1024 if result[2].endswith("i") else 1000
        size = float(result[1]) * base ** " kMGT".index((result[2][:1] or " ").replace("K", "k"))
    if size < 1:
        raise input_error(argument, text, "must be a size such as '500 MB' or '2 GiB'")
    return int(size)


@parser("URL")
def origin(text: str, argument: str) -> str:
    """Return an origin in the form of browsers: scheme, host, and non-default port."""
    try:
        parts = urlsplit(text.strip().lower())
        port = parts.port
    except ValueError:
        parts, port = urlsplit(""), None
    rest = parts.path.strip("/") or parts.query or parts.fragment or parts.username
    if parts.scheme not in ("http", "https") or not parts.hostname or rest or "*" in parts.hostname:
        raise input_error(argument, text, "must be an address such as 'http://lab-pc:5106'")
    name = f"[{parts.hostname}]" if ":" in parts.hostname else parts.hostname
    usual = {"http": 80, "https": 443}[parts.scheme]
    return f"{parts.scheme}://{name}" + (f":{port}" if port not in (None, usual) else "")


@parser("NAME=FILE[,FILE…]")
def group(text: str, argument: str) -> tuple[str, tuple[str, ...]]:
    """Return the name of a group of maps, and its files as text."""
    match = _GROUP.fullmatch(text)
    name, listed = (match[1].strip(), match[2]) if match else ("", "")
    try:
        words = next(csv.reader([listed], skipinitialspace=True), [])
        name = next(csv.reader([name]), [""])[0] if name.startswith('"') else name
    except csv.Error:
        words = []
    files = tuple(word.strip() for word in words)
    if not name.strip() or not files or not all(files):
        raise input_error(argument, text, "must be a name and files, such as 'ground=a.opd,b.opd'")
    return name.strip(), files


def group_text(name: str, files: Iterable[str]) -> str:
    """Return a name and files as the option of groups takes them."""

    def quoted(word: str) -> str:
        plain = not set(word) & set(',="\n\r') and word == word.strip()
        return word if plain else '"' + word.replace('"', '""') + '"'

    return f"{quoted(name)}={','.join(map(quoted, files))}"


@parser("LOAD|APPROACH")
def load_or_approach(text: str, argument: str) -> tuple[str, float | Load]:
    """Return ``"load"`` or ``"approach"``, by the unit of the text, and the value."""
    from roughcontact.contact import load_case

    try:
        return "approach", units.parse(text, "length", argument)
    except InputError:
        needs = f"{load_case.LOAD_EXAMPLES}, or an approach such as '1 um'"
        return "load", cast("float | Load", load_case.parse_required_load(text, argument, needs))


@parser("LOADS")
def stages(text: str, argument: str) -> tuple[tuple[str, float | Load], ...]:
    """Return loads and approaches in order; a load may be zero."""
    plain = [word.strip() for word in text.split(",")]
    return tuple(
        ("load", 0.0) if _NO_FORCE.fullmatch(word) else load_or_approach(word, argument)
        for word in plain
    )


@parser("DEGREES")
def parse_quarter_turns(text: str, argument: str) -> int:
    """Return a multiple of 90 degrees."""
    degrees = number(text, argument)
    if degrees % 90:
        raise input_error(argument, text, "must be a multiple of 90 degrees")
    return int(degrees)
