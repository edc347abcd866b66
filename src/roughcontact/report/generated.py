"""What is told of generated surfaces: what was asked for beside what they have."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from roughcontact.report import inputs
from roughcontact.surface.generation import WITHIN, Parameter, compared
from roughcontact.surface.surface import Surface
from roughcontact.units import changed_by, engineering

HEADS = ("parameter", "asked for", "of the map", "difference")

_HURST = "Hurst exponent"


def rows(surface: Surface) -> list[tuple[str, str, str, str]]:
    """Return what was asked for of a generated map beside what it has.

    Parameters
    ----------
    surface : Surface
        As `roughcontact.generate` has made it.

    Returns
    -------
    list of tuple of str
        One row a parameter, under `HEADS`.
    """
    return [
        (_name(one), _told(one.name, one.asked), _told(one.name, one.found), _missed(one))
        for one in compared(surface)
    ]


def about(surface: Surface) -> list[tuple[str, str]]:
    """Return grid, waves and seed of a generated map, in rows."""
    made = surface.provenance.origin
    assert made is not None
    ny, nx = surface.shape
    size = " × ".join(engineering(side, "m") for side in surface.size)
    waves = [
        f"{engineering(made.found[f'{name}_wavelength'], 'm')} ({told})"
        for name, told in (("cutoff", "cut-off"), ("rolloff", "roll-off"))
    ]
    return [
        ("grid (y × x)", f"{ny} × {nx} points"),
        ("size (y × x)", size),
        ("waves", " to ".join(waves)),
        ("seed", str(made.arguments["seed"])),
    ]


def unmet(surface: Surface) -> list[str]:
    """Return why parameters of a generated map are not those asked for, one sentence each."""
    made = surface.provenance.origin
    assert made is not None
    return [_why(one, surface, made.found) for one in compared(surface) if not one.met]


def record(surface: Surface) -> dict[str, Any]:
    """Return the same as numbers in SI units."""
    made = surface.provenance.origin
    assert made is not None
    return {
        "shape": list(surface.shape),
        "pixel": list(surface.pixel),
        "seed": made.arguments["seed"],
        "rolloff_wavelength": made.found["rolloff_wavelength"],
        "cutoff_wavelength": made.found["cutoff_wavelength"],
        "parameters": [
            {"name": one.name, "asked": one.asked, "found": one.found, "met": one.met}
            for one in compared(surface)
        ],
        "reasons": unmet(surface),
        "roughness": {name: made.found.get(name) for name in inputs.ROUGHNESS},
    }


def _name(one: Parameter) -> str:
    return _HURST if one.name == "hurst" else one.name


def _told(name: str, value: float) -> str:
    if math.isnan(value):
        return "not determined"
    if name in inputs.ROUGHNESS and inputs.ROUGHNESS[name][0] == "m":
        return engineering(value, "m")
    # Of a skewness of 0 only what it is to the digits that it can be had to.
    return f"{value:.3g}" if value == 0 or abs(value) >= WITHIN / 2 else f"{value:.3f}"


# Smaller differences are rounding to who reads them.
_LEAST = 5e-4


def _missed(one: Parameter) -> str:
    if math.isnan(one.missed):
        return ""
    if one.name == "Ssk":
        return f"{one.found - one.asked:+.3f}"
    return changed_by(one.missed) if abs(one.missed) >= _LEAST else "below 0.05 %"


def _why(one: Parameter, surface: Surface, found: Mapping[str, Any]) -> str:
    """Return why a parameter is missed."""
    said = f"{_name(one)} is {_told(one.name, one.found)} instead of {_told(one.name, one.asked)}"
    if one.name == "Str" and math.isnan(one.found):
        most = found.get("Str_max", math.nan)
        return (
            f"Str is not determined, only at most {most:.2g}: along the lay the heights stay alike "
            "over more than half the map, and longer sides would show where it ends"
        )
    if one.name in ("Sal", "Str"):
        hills = math.prod(side / found["rolloff_wavelength"] for side in surface.size)
        return (
            f"{said}: with room for only about {max(hills, 1):.0f} hills the map has, by chance, a "
            "correlation of its own; longer sides or another seed come closer"
        )
    if one.name in ("Ssk", "Sku"):
        return (
            f"{said}: no translation of this map, with waves no shorter than the cut-off, came "
            "closer; a shorter cut-off, longer sides or a moderate pair does"
        )
    return f"{said}: the spectrum of a map of this grid comes no closer"
