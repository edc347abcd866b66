"""The options of maps that are compared: a part of the table in `roughcontact.request.options`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from roughcontact import limits
from roughcontact.request import parsing
from roughcontact.request.option import BODIES, COMPARE, MAP, OUTPUT, PICTURES, TABLES, Option


def _option(
    name: str, panel: str, metavar: str, text: str, parse: Callable[[str, str], Any], **more: Any
) -> Option:
    return Option(name, panel, metavar, text, parse, (COMPARE,), **more)


def _flag(name: str, text: str) -> Option:
    return _option(name, MAP, "", text, parsing.flag, default=False)


MAPS = (
    _option(
        "group", MAP, "NAME=FILE[,FILE…]",
        'Maps of one surface, such as ground=a.opd,b.opd or "ground=ground*.opd"; may be repeated. '
        "Files without a group are maps of one surface.", parsing.group, default=(), many=True,
        arguments=("maps",),
    ),
    _flag("quarters", "Make a group of each map: its four quarters, each leveled again."),
    _flag(
        "sampling",
        "Tell from 4, 16 and 64 parts of each map how sure its numbers are, and how large an area "
        "is needed for 5 %.",
    ),
    _flag(
        "paired", "Take the maps of two groups one by one, such as the same places before and "
        "after.",
    ),
)  # fmt: skip
"""What is compared with what."""

LOADS = (
    _option(
        "load", BODIES, "PRESSURE",
        'Nominal pressure on every map, such as "20 MPa": maps of all sizes have the same.',
        parsing.nominal, arguments=("pressure",),
    ),
    _option(
        "first-load", BODIES, "PRESSURE",
        'Compare each map with itself after a first loading to this nominal pressure, such as '
        '"200 MPa".', parsing.nominal, arguments=("first_pressure",),
    ),
    _option(
        "steps", BODIES, "NUMBER",
        "Pressures of the load curves, from a hundredth of the load up to it; 1 for no curve; "
        "default: 7.", parsing.counted(1, limits.STEPS), default=7,
    ),
)  # fmt: skip
"""Under which pressures."""

FILES = (
    _option(
        "output", OUTPUT, "FILE.csv|json", "Write the table of means and differences.",
        parsing.path, suffixes=TABLES,
    ),
    _option(
        "figure", OUTPUT, "FILE", "Draw load curves and numbers as PNG, SVG or PDF.", parsing.path,
        suffixes=PICTURES,
    ),
)  # fmt: skip
"""What is written."""
