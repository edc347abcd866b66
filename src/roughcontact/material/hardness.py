"""Hardness numbers: their mean pressure, and conversion between scales for steel.

A Vickers or Brinell number is the load over the *curved or slanted* area of the indentation
[kgf/mm²]. The load over the *projected* area is the mean pressure under the indenter, which is the
ceiling of a contact. Tabor (1951) found about three times the yield stress of a metal that does not
harden. In a metal that hardens, this yield stress is the flow stress at a strain of about 8 %, the
strain under both indenters: the hardness of annealed stainless steel or of cast iron is at least
five times its 0.2 % proof stress, and three times the proof stress underestimates the ceiling.

References
----------
Tabor, The Hardness of Metals (1951), ISBN 978-0-19-850776-5
ISO 6507-1 (Vickers), ISO 6506-1 (Brinell), ISO 18265:2013 (conversion)

`vickers`: The table is for unalloyed and low-alloy steel and cast steel. ASTM E140-12, table 1,
whose scope includes tool steel, differs by at most 0.4 % in the C scale and 1.4 % in HBW; its
table 2 by up to 5.3 % in the B scale. Austenitic steel and all other metals need separate tables.
Conversion scatters by ±25 HV.

ISO 18265:2013, Metallic materials - Conversion of hardness values, table A.1; ASTM E140-12b,
Standard hardness conversion tables for metals, tables 1 and 2

`pressure`: Opposite faces of the pyramid enclose 136°, so that the projected area is sin 68° =
0.927 of the area of the faces.

ISO 6507-1:2018, Metallic materials - Vickers hardness test - Part 1; Tabor, The Hardness of
Metals (1951), ch. VII

`brinell_pressure`: The cap of a ball of diameter D and depth h has the area πDh = F/HBW and the
projected area πh(D - h), so that the pressure is HBW / (1 - F/(π D² HBW)). Under a pyramid the
same steel carries 3 % more at 100 HBW and 11 % more at 600 HBW (by the table of `vickers`).

ISO 6506-1:2014, Metallic materials - Brinell hardness test - Part 1; Tabor, The Hardness of
Metals (1951), ch. II

`ceiling`: HV and HBW are pressures by definition and need no conversion for any material. HRB and
HRC are depths: they are converted by the table for steel (`vickers`).
"""

from __future__ import annotations

import math
import re
import tomllib
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from roughcontact import units
from roughcontact._tools.arguments import validate_arguments
from roughcontact.errors import ArgumentRef, InputError, input_error, require_positive

STANDARD_GRAVITY = 9.80665
"""Standard gravity [m/s²]: one kilogram-force in newtons."""

_HALF_ANGLE = math.radians(68)
_MAX_DIAMETER_RATIO = 0.6

STORED = Path(__file__).with_name("hardness.toml")

_SPELLINGS = {"HV": "HV", "HBW": "HBW", "HB": "HBW", "HRB": "HRB", "HRBW": "HRB", "HRC": "HRC"}
_NUMBER = r"\d+(?:\.\d+)?"
_SCALE = r"(?P<scale>HV|HBW|HB|HRBW|HRB|HRC)"
_SCALED = re.compile(r"(?<![A-Z])H(V|B|BW|RB|RC)\d*\b", re.IGNORECASE)
_TEST = rf"(?P<test>{_NUMBER}(?:/{_NUMBER})*)?"
_VALUE_FIRST = re.compile(rf"(?P<value>{_NUMBER})\s*{_SCALE}\s*{_TEST}", re.IGNORECASE)
_VALUE_LAST = re.compile(rf"{_SCALE}{_TEST}\s+(?P<value>{_NUMBER})", re.IGNORECASE)


class Reading(NamedTuple):
    """Hardness number with its scale."""

    value: float  # The number
    scale: str  # Vickers, Brinell with a hard-metal ball, Rockwell B or C
    force_index: float = 30.0  # Brinell test: load over squared diameter of the ball [kgf/mm²]


def parse(text: str) -> Reading:
    """Return the number and the scale of a hardness in common notation."""
    wanted = "needs a number and a scale (HV, HBW, HRB or HRC) such as '62 HRC'"
    if not isinstance(text, str):
        raise input_error("hardness", text, f"{wanted}")
    shown = repr(text if len(text) <= 60 else text[:59] + "…")
    plain = text.strip()
    match = _VALUE_FIRST.fullmatch(plain) or _VALUE_LAST.fullmatch(plain)
    if match is None:
        raise InputError(f"{wanted}, got {shown}", argument="hardness", value=text)
    scale = _SPELLINGS[match["scale"].upper()]
    value = float(match["value"])
    if not 0 < value < math.inf:
        raise InputError(
            f"must be positive and finite, got {shown}", argument="hardness", value=text
        )
    if match["test"] is None or scale == "HV":
        return Reading(value, scale)
    conditions = [float(number) for number in match["test"].split("/")]
    if scale != "HBW" or len(conditions) < 2 or not all(conditions):
        raise InputError(
            f"{wanted}, got {shown}; only a Brinell test has a ball and a load, "
            "written as '95 HBW 10/500' (mm, kgf)",
            argument="hardness",
            value=text,
        )
    return Reading(value, scale, conditions[1] / conditions[0] ** 2)


@cache
def _steel_tables() -> dict[str, dict[str, list[float]]]:
    """Return the numbers of each scale, and the Vickers numbers of the same steel."""
    return tomllib.loads(STORED.read_text(encoding="utf-8"))


@validate_arguments
def vickers(value: float, scale: str) -> float:
    """Return the Vickers number of a steel from another scale."""
    require_positive(value=value)
    if scale == "HV":
        return float(value)
    steel = _steel_tables()
    if scale not in steel:
        raise input_error("scale", scale, f"must be one of HV, {', '.join(steel)}")
    numbers, equivalents = steel[scale]["number"], steel[scale]["vickers"]
    if not numbers[0] <= value <= numbers[-1]:
        raise InputError(
            f"{value:g} {scale} is outside the table for steel ({numbers[0]:g} to {numbers[-1]:g} "
            f"{scale}, ISO 18265 table A.1); give the Vickers number",
            argument="hardness",
            value=value,
        )
    return float(np.interp(value, numbers, equivalents))


@validate_arguments
def pressure(vickers: float) -> float:
    """Return the mean pressure under a Vickers pyramid, ``g HV / sin 68°`` [Pa]."""
    require_positive(vickers=vickers)
    return vickers * STANDARD_GRAVITY * 1e6 / math.sin(_HALF_ANGLE)


@validate_arguments
def brinell_pressure(brinell: float, force_index: float = 30.0) -> float:
    """Return the mean pressure under a Brinell ball (Meyer hardness) [Pa]."""
    require_positive(brinell=brinell, force_index=force_index)
    depth = force_index / (math.pi * brinell)
    # d² = 4h(D - h), with lengths in units of D.
    if depth >= 0.5 or 2 * math.sqrt(depth * (1 - depth)) > _MAX_DIAMETER_RATIO:
        raise InputError(
            f"{brinell:g} HBW at a force index of {force_index:g} kgf/mm² is an indentation wider "
            "than 0.6 of the ball; give ball and load, as in '60 HBW 10/1000'"
        )
    return brinell * STANDARD_GRAVITY * 1e6 / (1 - depth)


# Hardness [Pa] to which the correlation of microhardness refers, and its range.
_REFERENCE, _CORRELATED = 3.178e9, (1.3e9, 7.6e9)


def vickers_correlation(hardness: float) -> tuple[float, float] | None:
    """Return c₁ [Pa] and c₂ of the microhardness; None outside 1.3 to 7.6 GPa.

    The pressure under a Vickers pyramid with the diagonal d is ``c₁ (d/1 µm)^c₂``, a fit to metals
    by their Brinell hardness (Sridhar and Yovanovich 1996, Empirical methods to predict Vickers
    microhardness, Wear 193, 91).
    """
    if not _CORRELATED[0] <= hardness <= _CORRELATED[1]:
        return None
    k = hardness / _REFERENCE
    c1 = _REFERENCE * (4.0 - 5.77 * k + 4.0 * k**2 - 0.61 * k**3)
    return c1, -0.57 + 0.82 * k - 0.41 * k**2 + 0.06 * k**3


def stress(value: Any, name: str) -> Any:
    """Return a pressure [Pa] from a pressure or a hardness with its scale."""
    if not isinstance(value, str):
        return units.to_si(value, "pressure", name)
    if not _SCALED.search(value):
        return units.parse(value, "pressure", name)
    try:
        return ceiling(value)
    except InputError as error:
        own = () if error.argument in (None, name) else (ArgumentRef(str(error.argument)), " ")
        raise InputError(ArgumentRef(name), ": ", *own, *error.parts) from None


@validate_arguments
def ceiling(hardness: str | float) -> float:
    """Return the pressure ceiling of a body from its hardness [Pa]."""
    if not isinstance(hardness, str):
        return pressure(hardness)
    value, scale, force_index = parse(hardness)
    if scale == "HBW":
        return brinell_pressure(value, force_index)
    return pressure(vickers(value, scale))
