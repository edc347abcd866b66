"""The options of what a joint does: a part of the table in `roughcontact.request.options`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from roughcontact.request import parsing
from roughcontact.request.option import BODIES, CONDUCTANCE, OUTPUT, PICTURES, TABLES, Option


def _option(
    name: str, panel: str, metavar: str, text: str, parse: Callable[[str, str], Any], **more: Any
) -> Option:
    return Option(name, panel, metavar, text, parse, (CONDUCTANCE,), **more)


_resistivity = parsing.quantity("resistivity")
_conductivity = parsing.quantity("conductivity")

LOADS = (
    _option(
        "load", BODIES, "LOADS",
        'Normal load, as for solve, or several with commas: "1 N, 3 N, 10 N".', parsing.loads,
    ),
)  # fmt: skip
"""Under which loads."""

CONDUCTORS = (
    _option(
        "resistivity", BODIES, "RESISTIVITY",
        'Electrical resistivity of the body, such as "17 nohm m"; default: that of --material.',
        _resistivity,
    ),
    _option(
        "conductivity", BODIES, "CONDUCTIVITY",
        'Thermal conductivity of the body, such as "46 W/m/K"; default: that of --material.',
        _conductivity,
    ),
    _option(
        "counter-resistivity", BODIES, "RESISTIVITY", "Resistivity of the counter-body.",
        _resistivity,
    ),
    _option(
        "counter-conductivity", BODIES, "CONDUCTIVITY", "Conductivity of the counter-body.",
        _conductivity,
    ),
    _option(
        "film", BODIES, "FILM",
        'Electrical resistance times area of a film on the contact, such as "1e-12 ohm m^2"; '
        "default: none.", parsing.quantity("film"),
    ),
    _option(
        "thermal-film", BODIES, "FILM",
        'Thermal resistance times area of a film on the contact, such as "1e-6 m^2 K/W"; default: '
        "none.", parsing.quantity("thermal film"),
    ),
)  # fmt: skip
"""What the bodies conduct."""

FILES = (
    _option(
        "output", OUTPUT, "FILE.csv|json", "Write the table of loads.", parsing.path,
        suffixes=TABLES,
    ),
    _option(
        "figure", OUTPUT, "FILE", "Draw resistance over load as PNG, SVG or PDF.", parsing.path,
        suffixes=PICTURES,
    ),
)  # fmt: skip
"""What is written."""
