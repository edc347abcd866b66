"""What is told of generated surfaces: what was asked for beside what they have."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from roughcontact.report import inputs
from roughcontact.report.fields import Headline
from roughcontact.surface.generation import WITHIN, Parameter, compared
from roughcontact.surface.surface import Surface
from roughcontact.units import changed_by, engineering, lengths

HEADS = ("parameter", "requested", "map", "difference")

_HURST = "Hurst exponent"


def rows(surface: Surface) -> list[tuple[str, str, str, str]]:
    """Return what was asked for of a generated map beside what it has."""
    return [
        (_name(item), _told(item.name, item.asked), _told(item.name, item.found), _missed(item))
        for item in compared(surface)
    ]


def headline(surface: Surface) -> Headline:
    """Return what is said first of a generated map."""
    created = surface.provenance.origin
    assert created is not None
    ny, nx = surface.shape
    waves = [
        engineering(created.found[f"{name}_wavelength"], "m") for name in ("cutoff", "rolloff")
    ]
    grid = f"{ny} × {nx} points, {lengths(surface.size)}, waves {' to '.join(waves)}"
    missed = [_name(item) for item in compared(surface) if not item.met]
    return Headline(
        f"Generated map, {grid}, seed {created.arguments['seed']}",
        f"The map differs in {', '.join(missed)}." if missed else "The map has what was requested.",
        HEADS, rows(surface), (),
    )  # fmt: skip


def unmet(surface: Surface) -> list[str]:
    """Return why parameters of a generated map are not those asked for, one sentence each."""
    created = surface.provenance.origin
    assert created is not None
    return [_why(item, surface, created.found) for item in compared(surface) if not item.met]


def record(surface: Surface) -> dict[str, Any]:
    """Return the same as numbers in SI units."""
    created = surface.provenance.origin
    assert created is not None
    return {
        "shape": list(surface.shape),
        "pixel": list(surface.pixel),
        "seed": created.arguments["seed"],
        "rolloff_wavelength": created.found["rolloff_wavelength"],
        "cutoff_wavelength": created.found["cutoff_wavelength"],
        "parameters": [
            {"name": item.name, "asked": item.asked, "found": item.found, "met": item.met}
            for item in compared(surface)
        ],
        "reasons": unmet(surface),
        "roughness": {name: created.found.get(name) for name in inputs.ROUGHNESS},
    }


def _name(item: Parameter) -> str:
    return _HURST if item.name == "hurst" else item.name


def _told(name: str, value: float) -> str:
    if math.isnan(value):
        return "not determined"
    if name in inputs.ROUGHNESS and inputs.ROUGHNESS[name][0] == "m":
        return engineering(value, "m")
    # Of a skewness of 0 only what it is to the digits that it can be had to.
    return f"{value:.3g}" if value == 0 or abs(value) >= WITHIN / 2 else f"{value:.3f}"


# Smaller differences are rounding to who reads them.
_LEAST = 5e-4


def _missed(item: Parameter) -> str:
    if math.isnan(item.missed):
        return ""
    if item.name == "Ssk":
        return f"{item.found - item.asked:+.3f}"
    return changed_by(item.missed) if abs(item.missed) >= _LEAST else "below 0.05 %"


def _why(item: Parameter, surface: Surface, result: Mapping[str, Any]) -> str:
    """Return why a parameter is missed."""
    said = (
        f"{_name(item)} is {_told(item.name, item.found)} instead of {_told(item.name, item.asked)}"
    )
    if item.name == "Str" and math.isnan(item.found):
        maximum = result.get("Str_max", math.nan)
        return (
            f"Str is not determined, only at most {maximum:.2g}: along the lay the heights stay "
            "alike over more than half the map, and longer sides would show where it ends"
        )
    if item.name in ("Sal", "Str"):
        hills = math.prod(side / result["rolloff_wavelength"] for side in surface.size)
        return (
            f"{said}: with room for only about {max(hills, 1):.0f} hills the map has, by chance, a "
            "correlation of its own; longer sides or another seed come closer"
        )
    if item.name in ("Ssk", "Sku"):
        return (
            f"{said}: no translation of this map, with waves no shorter than the cut-off, came "
            "closer; a shorter cut-off, longer sides or a moderate pair does"
        )
    return f"{said}: the spectrum of a map of this grid comes no closer"
