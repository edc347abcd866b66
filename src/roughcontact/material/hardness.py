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
from typing import Any, NamedTuple

import numpy as np

from roughcontact import units
from roughcontact._tools.arguments import validate_arguments
from roughcontact.errors import ArgumentRef, InputError, input_error, require_positive

STANDARD_GRAVITY = 9.80665
"""Standard gravity [m/s²]: one kilogram-force in newtons."""

_HALF_ANGLE = math.radians(68)
_MAX_DIAMETER_RATIO = 0.6

# ISO 18265:2013, table A.1: unalloyed and low-alloy steel and cast steel. HBW is measured with a
# hard-metal ball and 0.102 F/D² = 30. Values in brackets in the table are omitted for HRB, as the
# Rockwell scale is not defined there; for HRB, only rows that are in two prints of the table.
_VICKERS_OF_HBW = (*range(80, 300, 5), *range(300, 651, 10))
_HBW = (
    76.0,
    80.7,
    85.5,
    90.2,
    95.0,
    99.8,
    105,
    109,
    114,
    119,
    124,
    128,
    133,
    138,
    143,
    147,
    152,
    156,
    162,
    166,
    171,
    176,
    181,
    185,
    190,
    195,
    199,
    204,
    209,
    214,
    219,
    223,
    228,
    233,
    238,
    242,
    247,
    252,
    257,
    261,
    266,
    271,
    276,
    280,
    285,
    295,
    304,
    314,
    323,
    333,
    342,
    352,
    361,
    371,
    380,
    390,
    399,
    409,
    418,
    428,
    437,
    447,
    456,
    466,
    475,
    485,
    494,
    504,
    513,
    523,
    532,
    542,
    551,
    561,
    570,
    580,
    589,
    599,
    608,
    618,
)
_VICKERS_OF_HRB = (*range(100, 200, 10), *range(200, 231, 5), 240, 250)
_HRB = (
    56.2,
    62.3,
    66.7,
    71.2,
    75.0,
    78.7,
    81.7,
    85.0,
    87.1,
    89.5,
    91.5,
    92.5,
    93.5,
    94.0,
    95.0,
    96.0,
    96.7,
    98.1,
    99.5,
)
_VICKERS_OF_HRC = (*range(240, 300, 5), *range(300, 700, 10), *range(700, 941, 20))
_HRC = (
    20.3,
    21.3,
    22.2,
    23.1,
    24.0,
    24.8,
    25.6,
    26.4,
    27.1,
    27.8,
    28.5,
    29.2,
    29.8,
    31.0,
    32.2,
    33.3,
    34.4,
    35.5,
    36.6,
    37.7,
    38.8,
    39.8,
    40.8,
    41.8,
    42.7,
    43.6,
    44.5,
    45.3,
    46.1,
    46.9,
    47.7,
    48.4,
    49.1,
    49.8,
    50.5,
    51.1,
    51.7,
    52.3,
    53.0,
    53.6,
    54.1,
    54.7,
    55.2,
    55.7,
    56.3,
    56.8,
    57.3,
    57.8,
    58.3,
    58.8,
    59.2,
    59.7,
    60.1,
    61.0,
    61.8,
    62.5,
    63.3,
    64.0,
    64.7,
    65.3,
    65.9,
    66.4,
    67.0,
    67.5,
    68.0,
)
_STEEL = {
    "HBW": (_HBW, _VICKERS_OF_HBW),
    "HRB": (_HRB, _VICKERS_OF_HRB),
    "HRC": (_HRC, _VICKERS_OF_HRC),
}

_SPELLINGS = {"HV": "HV", "HBW": "HBW", "HB": "HBW", "HRB": "HRB", "HRBW": "HRB", "HRC": "HRC"}
_NUMBER = r"\d+(?:\.\d+)?"
_SCALE = r"(?P<scale>HV|HBW|HB|HRBW|HRB|HRC)"
_SCALED = re.compile(r"\bH(V|B|BW|RB|RC)\d*\b", re.IGNORECASE)
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


@validate_arguments
def vickers(value: float, scale: str) -> float:
    """Return the Vickers number of a steel from another scale."""
    require_positive(value=value)
    if scale == "HV":
        return float(value)
    if scale not in _STEEL:
        raise input_error("scale", scale, f"must be one of HV, {', '.join(_STEEL)}")
    numbers, equivalents = _STEEL[scale]
    if not numbers[0] <= value <= numbers[-1]:
        raise InputError(
            f"{value:g} {scale} is outside the table for steel "
            f"({numbers[0]:g} to {numbers[-1]:g} {scale}, ISO 18265 table A.1); "
            "give the Vickers number",
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
