"""Conversion of text with units to SI values and back; the only module that uses pint."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from decimal import Decimal
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Protocol

from roughcontact.errors import InputError, input_error

if TYPE_CHECKING:
    import pint

# Unit in SI, and an example, of each dimension.
_DIMENSIONS = {
    "length": ("m", "'0.1 mm'"),
    "force": ("N", "'1 N'"),
    "pressure": ("Pa", "'210 GPa'"),
    "moment": ("N m", "'1 N mm'"),
    "line load": ("N/m", "'600 N/mm'"),
    "resistivity": ("ohm m", "'17 nohm m'"),
    "conductivity": ("W/m/K", "'46 W/m/K'"),
    "film": ("ohm m^2", "'1e-12 ohm m^2'"),
    "thermal film": ("m^2 K/W", "'1e-5 m^2 K/W'"),
    "viscosity": ("Pa s", "'1 mPa s'"),
    "temperature": ("K", "'20 °C'"),
    "current": ("A", "'10 A'"),
    "voltage": ("V", "'0.1 V'"),
    "wear coefficient": ("m^2/N", "'1e-15 m2/N' or '1e-6 mm3/Nm'"),
}
_NAMED_DIMENSIONS = {
    "": "a pure number",
    "[length]": "a length",
    "[length] ** 2": "an area",
    "[length] ** 3": "a volume",
    "[mass]": "a mass",
    "[time]": "a time",
    "[current]": "an electric current",
    "[temperature]": "a temperature",
    "[length] * [mass] / [time] ** 2": "a force",
    "[mass] / [length] / [time] ** 2": "a pressure",
    "[mass] / [time] ** 2": "a force per length",
    "[length] ** 2 * [mass] / [time] ** 2": "a moment or an energy",
}


class WithUnit(Protocol):
    """Quantity of pint."""

    @property
    def units(self) -> Any:
        """Unit of the quantity."""

    def m_as(self, units: str, /) -> Any:
        """Return the value or values in another unit."""


Quantity = float | str | WithUnit
"""Number in SI units, text with a unit such as ``"50 N"``, or a quantity of pint."""

Quantities = Sequence[Quantity] | WithUnit
"""Several quantities: a sequence, or one quantity of an array."""

_END = re.compile(r"([-−+]?[\d,]+(?:\.\d+)?)((?:e[-+]?\d+)?(?: .*)?)")
_NUMBER = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?")
_NOT_FINITE = re.compile(r"[+-]?(?:inf(?:inity)?|nan)\b", re.IGNORECASE)
_SHARE = re.compile(r"\s*([0-9.]+(?:[eE][+-]?[0-9]+)?)\s*%\s*")
_CELSIUS = re.compile(r"([+-]?\d+(?:\.\d*)?)\s*(?:°C|degC)")
_ZERO_CELSIUS = 273.15
_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d")
# pint evaluates arithmetic; it gets only names with one-digit powers, joined by * / or a space.
_FACTOR = r"[A-Za-z_µÅΩ]+(?:(?:\^|\*\*)-?[1-9]|[23²³])?"
# In pint "mm2" is another name, and "mil" an angle.
_BARE_POWER = re.compile(r"(?<=[A-Za-z_µÅΩ])(?=[23])")
_MIL = re.compile(r"\bmil\b")
_UNIT = re.compile(rf"{_FACTOR}(?:\s*[*/·]\s*{_FACTOR}|\s+{_FACTOR})*")
# Spellings that pint does not read: m2, and N m as a single divisor.
_PLAIN_POWER = re.compile(r"(?<=[A-Za-zµÅΩ])(?=[1-9])")
_NEWTON_METER = re.compile(r"/(?:Nm|\(N[ *·]?m\))$")
_MAX_TEXT = 60
# Factor of a unit that gets the prefix; its power applies to the prefix as well.
_FIRST = re.compile(r"[A-Za-zÅΩ°]+([²³]?)(?=$|[ /])")
# Lengths in pint (a CSS pixel is 1/96 inch), but not meant as a length in "5 px".
_PRINTERS_UNIT = re.compile(r"pixel|point|pica|didot|cicero")

# The common spellings need no registry, whose creation takes a third of a second.
_PLAIN = {
    "length": {
        "m": 1.0,
        "cm": 1e-2,
        "mm": 1e-3,
        "µm": 1e-6,
        "um": 1e-6,
        "nm": 1e-9,
        "pm": 1e-12,
        "Å": 1e-10,
        "angstrom": 1e-10,
        "inch": 25.4e-3,
        "in": 25.4e-3,
    },
    "force": {"N": 1.0, "kN": 1e3, "MN": 1e6, "mN": 1e-3, "µN": 1e-6, "uN": 1e-6, "nN": 1e-9},
    "pressure": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9},
}

# Largest number of digits before the decimal point without a comma.
_UNGROUPED = 4

# Smallest meaningful length [m]: a hundredth of an atom.
_MIN_LENGTH = 1e-12

# Letter case decides in SI (mN, MN), yet some spellings can only mean one thing.
_LIKELY_UNITS = {"pa": "Pa", "kpa": "kPa", "mpa": "MPa", "gpa": "GPa", "n": "N", "kn": "kN"}

_PREFIXES = dict(zip(range(-15, 18, 3), (*"fpnµm", "", *"kMGTP"), strict=True))


def parse(
    text: str, dimension: str, name: str, positive: bool = True, needs: str | None = None
) -> float:
    """Return the SI value of a number with its unit."""
    if dimension not in _DIMENSIONS:
        raise ValueError(f"dimension must be one of {', '.join(_DIMENSIONS)}, got {dimension!r}")
    wanted = f"needs {needs or f'a {dimension} with its unit such as {_DIMENSIONS[dimension][1]}'}"

    def refused(result: str) -> InputError:
        return InputError(f"{wanted}, got {result}", argument=name, value=text)

    if not isinstance(text, str):
        raise refused(f"{text!r} which has no unit")
    shown = repr(text if len(text) <= _MAX_TEXT else text[: _MAX_TEXT - 1] + "…")
    celsius = _CELSIUS.fullmatch(_plain(text)) if dimension == "temperature" else None
    if celsius is not None:
        value = float(celsius[1]) + _ZERO_CELSIUS
    else:
        number, unit = _number_and_unit(_plain(text), shown, refused)
        value = _times(number, _unit_factor(unit, dimension, shown, refused))
    if not math.isfinite(value):
        raise refused(f"{shown} which is not a finite number")
    if positive and not value > 0:
        remedy = f"; write {_plain(text).lstrip('-−').strip()!r}" if value < 0 else ""
        raise InputError(f"must be positive, got {shown}{remedy}", argument=name, value=text)
    return value


def shares(text: str, argument: str) -> tuple[float, ...]:
    """Return shares above 0 and up to 1, given in per cent with commas between them."""
    matches = [_SHARE.fullmatch(part) for part in text.split(",")]
    result = tuple(float(match[1]) / 100 for match in matches if match)
    if len(result) < len(matches) or not all(0 < share <= 1 for share in result):
        raise input_error(
            argument, text, "must be above 0 and up to 100 per cent, such as '5 %' or '1 %, 5 %'"
        )
    return result


def to_si(value: Any, dimension: str, name: str) -> Any:
    """Return an argument in SI units: the single conversion function of the public API."""
    if isinstance(value, (list, tuple)):
        return type(value)(_single(item, dimension, name) for item in value)
    return _single(value, dimension, name)


def _single(value: Any, dimension: str, name: str) -> Any:
    if isinstance(value, str):
        return parse(value, dimension, name, positive=False)
    if not hasattr(value, "m_as"):
        return value
    try:
        if dimension == "temperature":
            return value.m_as("K")
        # Convert only the factor, so that 300 nm is exactly 3e-07 m, as from text.
        factor = float((1.0 * value.units).m_as(_DIMENSIONS[dimension][0]))
        numbers = value.m_as(value.units)
    # The errors of pint have no common base class and are not imported here.
    except (AttributeError, ValueError, TypeError):
        raise InputError(
            f"needs a {dimension} with its unit such as {_DIMENSIONS[dimension][1]}, got "
            f"a quantity in {value.units}",
            argument=name,
            value=value,
        ) from None
    return _times(numbers, factor) if isinstance(numbers, (int, float)) else numbers * factor


def _times(number: float | str, factor: float) -> float:
    """Return the product of two factors as decimals, rounded once."""
    value = float(number)
    if value == 0 or not math.isfinite(value):
        return value
    # Values beyond the range of floats were returned above: `Decimal` raises on overflow.
    return float(Decimal(str(number)) * Decimal(repr(factor)))


def format_engineering(value: float, unit: str, digits: int = 4) -> str:
    """Return a quantity as text with an SI prefix."""
    if digits < 1:
        raise ValueError(f"digits must be at least 1, got {digits}")
    return _with_prefix(0.0 if unit == "m" and abs(value) < _MIN_LENGTH else value, unit, digits)


def _with_prefix(value: float, unit: str, digits: int = 4) -> str:
    if not math.isfinite(value) or value == 0:
        return f"{abs(value) if value == 0 else value:g} {unit}".rstrip()
    # Decimal, so that 999.96 rounds up before the prefix is chosen and no digits appear from
    # the division by a power of ten.
    rounded = Decimal(f"{value:.{digits - 1}e}")
    first = _FIRST.match(unit)
    power = {"²": 2, "³": 3}.get(first[1], 1) if first else 1
    prefix = 3 * ((rounded.adjusted() + (power == 2)) // (3 * power))
    if first is None or prefix not in _PREFIXES:
        return f"{value:.{digits}g} {unit}".rstrip()
    scaled = _decimals(format(rounded.scaleb(-prefix * power), "f"))
    return f"{scaled} {_PREFIXES[prefix]}{unit}"


def _decimals(number: str) -> str:
    """Return decimals without trailing zeros."""
    return number.rstrip("0").rstrip(".") if "." in number else number


def group_digits(text: str) -> str:
    """Return a number, with or without a unit, with commas from 10,000 on and a minus sign.

    For display alone: a comma is not read back.
    """
    number, space, unit = text.partition(" ")
    whole, point, rest = number.partition(".")
    if whole.lstrip("-").isdigit() and len(whole.lstrip("-")) > _UNGROUPED:
        whole = f"{int(whole):,}"
    return f"{whole}{point}{rest}".replace("-", "−") + space + unit


def format_lengths(values: Sequence[float], between: str = " × ") -> str:
    """Return lengths as text, each with its SI prefix."""
    # No lower limit: a wrong unit of the input must remain visible.
    return between.join(_with_prefix(value, "m") for value in values)


def join_ends(low: str, high: str, digits: int = 0) -> str:
    """Return both ends of an interval with equal digits, a common unit only once.

    ``digits`` is the least number of digits of both.
    """
    ends = [_END.fullmatch(text) for text in (low, high)]
    if None not in ends:
        digits = max(digits, *(_significant(end[1]) for end in ends if end))
        low, high = (_with_digits(end, digits) for end in ends if end)
    number, _, unit = low.partition(" ")
    return f"{number if number and high.endswith(f' {unit}') else low} to {high}"


def _significant(number: str) -> int:
    """Return the significant digits of a number with decimals; those of an integer are unknown."""
    return len(number.replace(".", "").lstrip("-−+0")) if "." in number else 0


def _with_digits(end: re.Match[str], digits: int) -> str:
    """Return a number with the trailing zeros that `_decimals` removed."""
    number, rest = end[1], end[2]
    shown = len(number.replace(".", "").replace(",", "").lstrip("-−+0"))
    if 0 < shown < digits:
        number = f"{number}{'' if '.' in number else '.'}{'0' * (digits - shown)}"
    return number + rest


def format_percent(share: float) -> str:
    """Return a share as text in per cent."""
    rest = min(share, 1 - share)
    if rest <= 1e-12:
        return f"{100 * share:.0f} %"
    if share < 5e-7:
        return "< 0.0001 %"
    if 1 - share < 5e-7:
        return "> 99.9999 %"
    decimals = min(max(2 - math.floor(math.log10(100 * rest)), 0), 4)
    return f"{100 * share:.{decimals}f} %"


def plain_decimal(value: float, digits: int = 4) -> str:
    """Return a number as text without a power of ten, down to a millionth."""
    if value == 0 or not math.isfinite(value):
        return f"{abs(value):g}" if value == 0 else f"{value:g}"
    if 0 < value < 1e-6:
        return "< 0.000001"
    return group_digits(_decimals(format(Decimal(f"{value:.{digits - 1}e}"), "f")))


def format_change(change: float) -> str:
    """Return a relative change as text."""
    if math.isinf(change):
        return "from zero"
    if change >= 9:
        return f"{float(f'{1 + change:.2g}'):.7g}-fold"
    whole, tenths = round(100 * change), round(1000 * change)
    text = f"{whole:+d} %" if whole else f"{tenths / 10:+.1f} %" if tenths else "0 %"
    return text.replace("-", "−")


def format_duration(seconds: float) -> str:
    """Return a duration as text, in days, h, min or s."""
    for unit, size in (("days", 86400), ("h", 3600), ("min", 60)):
        if seconds >= 1.5 * size:
            return f"{seconds / size:.0f} {unit}"
    return f"{max(1.0, seconds):.0f} s"


def count_noun(number: int, noun: str) -> str:
    """Return a number with its noun."""
    plural = f"{noun}es" if noun.endswith("s") else f"{noun}s"
    return f"{group_digits(str(number))} {noun if number == 1 else plural}"


def _plain(text: str) -> str:
    # Neither pint nor the patterns include the micro, minus and spaces of word processors.
    for special, usual in (("\u03bc", "µ"), ("\u2212", "-"), ("\u00a0", " "), ("\u202f", " ")):
        text = text.replace(special, usual)
    return text.strip()


def _number_and_unit(
    plain: str, shown: str, refused: Callable[[str], InputError]
) -> tuple[str, str]:
    """Return the number and the unit of a text."""
    if not plain:
        raise refused("an empty text")
    if _DECIMAL_COMMA.match(plain):
        raise refused(f"{shown}: write the number with a decimal point, no comma")
    if _NOT_FINITE.match(plain):
        raise refused(f"{shown} which is not a finite number")
    number = _NUMBER.match(plain)
    if number is None or len(plain) > _MAX_TEXT:
        raise refused(shown)
    unit = _PLAIN_POWER.sub("^", _NEWTON_METER.sub("/N/m", plain[number.end() :].strip()))
    if not unit:
        raise refused(f"{shown} which has no unit")
    if not _UNIT.fullmatch(unit):
        raise refused(f"{shown} which is not one number and one unit")
    return number.group(), unit


def _unit_factor(
    unit: str, dimension: str, shown: str, refused: Callable[[str], InputError]
) -> float:
    for measured, factors in _PLAIN.items():
        if unit in factors:
            if measured != dimension:
                raise refused(f"{shown} (a {measured})")
            return factors[unit]
    registry = _registry()
    likely = _LIKELY_UNITS.get(unit.lower())
    hint = f"; did you mean {likely!r}?" if likely and likely != unit else ""
    try:
        named = _MIL.sub("thou", unit.replace("·", "*"))
        parsed = registry.parse_units(_BARE_POWER.sub("^", named))
        got: Any = parsed.dimensionality
    # The errors of pint have no common base class; after `_UNIT`, only unknown names fail.
    except (AttributeError, ValueError, TypeError, ArithmeticError):
        raise refused(f"{shown} whose unit {unit!r} is unknown{hint}") from None
    if _PRINTERS_UNIT.search(str(parsed)):
        raise refused(f"{shown} (a printer's unit); give a length such as '5 um'")
    wanted = registry.parse_units(_DIMENSIONS[dimension][0])
    if got != wanted.dimensionality:
        raise refused(f"{shown} ({_describe_dimension(got)}){hint}")
    if registry.convert(0.0, parsed, wanted):
        raise refused(f"{shown} whose zero is another")
    return float(registry.convert(1.0, parsed, wanted))


def _describe_dimension(dimensionality: Any) -> str:
    # Sorted, since pint preserves the order in which units were given.
    above: list[str] = []
    below: list[str] = []
    for name, power in sorted(dimensionality.items()):
        size = abs(power)
        (above if power > 0 else below).append(name if size == 1 else f"{name} ** {size:g}")
    text = " / ".join([" * ".join(above) or ("1" if below else ""), *below])
    return _NAMED_DIMENSIONS.get(text, f"of dimension {text.replace('**', '^')}")


@lru_cache(maxsize=1)
def _registry() -> pint.UnitRegistry[float]:
    # Imported late: pint takes 0.3 s to import and build, and most commands never need it.
    import pint

    return pint.UnitRegistry()


def order_of_magnitude(value: float) -> str:
    """Return an error as text with two significant digits."""
    return f"{value:.1e}" if value else "0"
