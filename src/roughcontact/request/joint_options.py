"""The options of what a joint does: a part of the table in `roughcontact.request.options`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from roughcontact import limits
from roughcontact.formats import export
from roughcontact.formats.export import Kind
from roughcontact.request import parsing
from roughcontact.request.option import (
    BODIES,
    CONDUCTANCE,
    JOINTS,
    LAW,
    LOADED,
    MAP,
    OUTPUT,
    PICTURES,
    TABLES,
    Option,
)


def _option(
    name: str, panel: str, metavar: str, text: str, parse: Callable[[str, str], Any], **more: Any
) -> Option:
    return Option(name, panel, metavar, text, parse, more.pop("fits", (CONDUCTANCE,)), **more)


LAWS = export.suffixes(Kind.LAW)
"""How files of laws may end."""

_resistivity = parsing.quantity("resistivity")
_conductivity = parsing.quantity("conductivity")

MAPS = (
    _option(
        "quarters", MAP, "", "Find the law of the quarters of each map, too: whether the maps are "
        "large enough.", parsing.flag, fits=(LAW,), default=False,
    ),
)  # fmt: skip
"""Of which maps."""

LOADS = (
    _option(
        "load", BODIES, "LOADS",
        'Normal load, as for solve, or several with commas: "1 N, 3 N, 10 N".', parsing.loads,
        fits=LOADED,
    ),
    _option(
        "from", BODIES, "PRESSURE", 'Smallest nominal pressure, such as "1 MPa".', parsing.nominal,
        fits=JOINTS,
    ),
    _option(
        "to", BODIES, "PRESSURE", 'Largest nominal pressure, such as "300 MPa".', parsing.nominal,
        fits=JOINTS,
    ),
    _option(
        "steps", BODIES, "NUMBER", "Pressures between them, in equal ratios; default: 13.",
        parsing.counted(2, limits.STEPS), fits=JOINTS, default=13,
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
        _conductivity, fits=(CONDUCTANCE, LAW),
    ),
    _option(
        "counter-resistivity", BODIES, "RESISTIVITY", "Resistivity of the counter-body.",
        _resistivity,
    ),
    _option(
        "counter-conductivity", BODIES, "CONDUCTIVITY", "Conductivity of the counter-body.",
        _conductivity, fits=(CONDUCTANCE, LAW),
    ),
    _option(
        "film", BODIES, "FILM",
        'Electrical resistance times area of a film on the contact, such as "1e-12 ohm m^2"; '
        "default: none.", parsing.quantity("film"),
    ),
    _option(
        "thermal-film", BODIES, "FILM",
        'Thermal resistance times area of a film on the contact, such as "1e-6 m^2 K/W"; default: '
        "none.", parsing.quantity("thermal film"), fits=(CONDUCTANCE, LAW),
    ),
)  # fmt: skip
"""What the bodies conduct."""

FILES = (
    _option(
        "output", OUTPUT, "FILE", f"Write the law: {export.told(Kind.LAW)}; may be repeated.",
        parsing.path, fits=(LAW,), default=(), many=True, suffixes=LAWS,
    ),
    _option(
        "figure", OUTPUT, "FILE", "Draw the law as PNG, SVG or PDF.", parsing.path, fits=(LAW,),
        suffixes=PICTURES,
    ),
    _option(
        "output", OUTPUT, "FILE.csv|json", "Write the table of loads.", parsing.path,
        fits=LOADED, suffixes=TABLES,
    ),
    _option(
        "figure", OUTPUT, "FILE", "Draw resistance over load as PNG, SVG or PDF.", parsing.path,
        suffixes=PICTURES,
    ),
)  # fmt: skip
"""What is written."""
