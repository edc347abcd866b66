"""The slider of the load: the forms in which a load is given, and how far each goes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from roughcontact import units
from roughcontact.contact.result import ContactResult
from roughcontact.desk.live import Prepared
from roughcontact.desk.state import Given
from roughcontact.material.material import contact_modulus, softer
from roughcontact.request.options import CEILING
from roughcontact.surface.surface import Surface

STEPS = 300
"""Positions of the slider, from 0 on."""

_DIGITS = 3
_DECADES = 5.0
# Part of the contact modulus beyond which nothing stays elastic, and part of the largest load that
# a ceiling carries.
_HIGHEST, _NEAR_CAPACITY = 0.05, 0.95
# Pressures of smooth bodies beside those that a whole map carries.
_PEAKS = 5.0


@dataclass(frozen=True)
class Form:
    """A form in which a load is given.

    Parameters
    ----------
    name : str
        What it is called.
    option : str
        The option that takes it.
    unit : str
        SI unit.
    example : str
        A text of it.
    """

    name: str
    option: str
    unit: str
    example: str


FORCE = Form("Force", "load", "N", "1 N")
NOMINAL = Form("Nominal pressure", "load", "Pa", "20 MPa")
LINE = Form("Line load", "load", "N/m", "600 N/mm")
HERTZ = Form("Hertz pressure", "hertz", "Pa", "1.5 GPa")
APPROACH = Form("Approach", "approach", "m", "1 um")
FORMS = (FORCE, NOMINAL, LINE, HERTZ, APPROACH)


def form_of(given: Given) -> Form:
    """Return the form in which the load is given; a nominal pressure where there is none."""
    for form in (HERTZ, APPROACH):
        if form.option in given:
            return form
    text = str(given.get("load", NOMINAL.example))
    if text.lower().startswith("hertz"):
        return HERTZ
    unit = text.lstrip("0123456789.+-eE ").replace(" ", "")
    if unit.endswith("Pa") or unit in ("bar", "psi"):
        return NOMINAL
    return LINE if "/" in unit else FORCE


def span(form: Form, prepared: Prepared) -> tuple[float, float]:
    """Return the smallest and the largest value that the slider gives [SI].

    Parameters
    ----------
    form : Form
        What it gives.
    prepared : Prepared
        The bodies.
    """
    request, surface = prepared.request, prepared.surfaces[0]
    bodies = request.bodies()
    pressure = _HIGHEST * contact_modulus(*bodies)
    softest, ceiling = softer(*bodies), request.get(CEILING)
    if isinstance(ceiling, str):
        ceiling = None if softest is None else softest.ceiling
    if ceiling is not None:
        pressure = min(pressure, _NEAR_CAPACITY * ceiling)
    if form is APPROACH:
        largest = sum(map(_height, prepared.surfaces))
    else:
        per_pressure = {
            FORCE: math.prod(surface.size), NOMINAL: 1.0, LINE: max(surface.size), HERTZ: _PEAKS,
        }  # fmt: skip
        largest = per_pressure[form] * pressure
    return _rounded(largest * 10.0**-_DECADES), _rounded(largest)


def text_at(position: int, ends: tuple[float, float], form: Form) -> str:
    """Return the text that a position of the slider stands for, as one would type it."""
    value = ends[0] * (ends[1] / ends[0]) ** (position / STEPS)
    return units.engineering(_rounded(value), form.unit, _DIGITS)


def position_of(value: float, ends: tuple[float, float]) -> int:
    """Return the position of the slider that is nearest to a value."""
    share = math.log(value / ends[0]) / math.log(ends[1] / ends[0]) if value > 0 else 0.0
    return round(STEPS * min(1.0, max(0.0, share)))


def text_of(result: ContactResult, form: Form) -> str | None:
    """Return the load of a result in another form; None where that is not known."""
    if form is FORCE:
        return units.engineering(result.load, "N", _DIGITS)
    if form is NOMINAL:
        area = result.pressure.size * result.pixel_area
        return units.engineering(result.load / area, "Pa", _DIGITS)
    if form is APPROACH and result.approach > 0:
        return units.engineering(result.approach, "m", _DIGITS)
    return None


def _height(surface: Surface) -> float:
    """Return how far the heights reach [m]."""
    return float(np.nanmax(surface.heights) - np.nanmin(surface.heights))


def _rounded(value: float) -> float:
    return float(f"{value:.{_DIGITS - 1}e}")
