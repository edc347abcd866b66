"""Panel of the load: its form, its value with unit, and a slider."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import panel as pn

from roughcontact import units
from roughcontact.contact.result import ContactResult
from roughcontact.desk import controls, style
from roughcontact.desk.controls import Give
from roughcontact.desk.live_solver import PreparedMaps
from roughcontact.desk.session import Session
from roughcontact.desk.widgets import Slider
from roughcontact.errors import RoughcontactError
from roughcontact.material.material import contact_modulus, softer_material
from roughcontact.request.options import APPROACH, CEILING, LOAD
from roughcontact.surface.surface import Surface

STEPS = 300
"""Last position of the slider; the first is 0."""

_DIGITS = 3
_DECADES = 5.0
# Largest nominal pressure of the slider, over the contact modulus and over a pressure ceiling.
_HIGHEST, _NEAR_CAPACITY = 0.05, 0.95
# Largest Hertz pressure of the slider over its largest nominal pressure.
_PEAKS = 5.0


@dataclass(frozen=True)
class LoadForm:
    """Form of a load, such as force or nominal pressure."""

    name: str  # Label
    option: str  # Option of the command
    unit: str  # SI unit
    example: str  # Example with unit
    lead: str = ""  # Text before the value


FORCE = LoadForm("Force", "load", "N", "1 N")
NOMINAL = LoadForm("Nominal pressure", "load", "Pa", "20 MPa")
LINE = LoadForm("Line load", "load", "N/m", "600 N/mm")
HERTZ = LoadForm("Hertz pressure", "load", "Pa", "hertz 1.5 GPa", "hertz ")
APPROACH_AXIS = LoadForm("Approach", "approach", "m", "1 um")
FORMS = (FORCE, NOMINAL, LINE, HERTZ, APPROACH_AXIS)


def form_of(specified: Mapping[str, object]) -> LoadForm:
    """Return the form of the given load; nominal pressure without a load."""
    if APPROACH_AXIS.option in specified:
        return APPROACH_AXIS
    text = str(specified.get("load", NOMINAL.example))
    if text.lower().startswith("hertz"):
        return HERTZ
    unit = text.lstrip("0123456789.+-eE ").replace(" ", "")
    if unit.endswith("Pa") or unit in ("bar", "psi"):
        return NOMINAL
    return LINE if "/" in unit else FORCE


def slider_range(form: LoadForm, prepared: PreparedMaps) -> tuple[float, float]:
    """Return the smallest and the largest value of the slider [SI]."""
    request, surface = prepared.request, prepared.surfaces[0]
    bodies = request.bodies
    pressure = _HIGHEST * contact_modulus(*bodies)
    softest, ceiling = softer_material(*bodies), request.get(CEILING)
    if isinstance(ceiling, str):
        ceiling = None if softest is None else softest.ceiling
    if ceiling is not None:
        pressure = min(pressure, _NEAR_CAPACITY * ceiling)
    if form is APPROACH_AXIS:
        largest = sum(map(_height, prepared.surfaces))
    else:
        per_pressure = {
            FORCE: math.prod(surface.size),
            NOMINAL: 1.0,
            LINE: max(surface.size),
            HERTZ: _PEAKS,
        }
        largest = per_pressure[form] * pressure
    return _rounded(largest * 10.0**-_DECADES), _rounded(largest)


def text_at_position(position: int, ends: tuple[float, float], form: LoadForm) -> str:
    """Return the load at a position of the slider, as text with unit."""
    value = ends[0] * (ends[1] / ends[0]) ** (position / STEPS)
    return form.lead + units.format_engineering(_rounded(value), form.unit, _DIGITS)


def slider_ticks(ends: tuple[float, float], form: LoadForm) -> list[tuple[float, str]]:
    """Return the ticks of the scale: places from 0 to 1, labels at every second decade."""
    first, last = (math.floor(math.log10(end)) for end in ends)
    decades, odd = math.log(ends[1] / ends[0]), last % 2
    values = [
        (digit, power, digit * 10.0**power)
        for power in range(first, last + 1)
        for digit in range(1, 10)
    ]
    return [
        (
            math.log(value / ends[0]) / decades,
            units.format_engineering(value, form.unit, _DIGITS)
            if digit == 1 and power % 2 == odd
            else "",
        )
        for digit, power, value in values
        if ends[0] <= value <= ends[1]
    ]


def position_of_value(value: float, ends: tuple[float, float]) -> int:
    """Return the slider position nearest to a value."""
    share = math.log(value / ends[0]) / math.log(ends[1] / ends[0]) if value > 0 else 0.0
    return round(STEPS * min(1.0, max(0.0, share)))


def load_text(result: ContactResult, form: LoadForm, digits: int = _DIGITS) -> str | None:
    """Return the load of a result in a form, as text with unit; None if unknown."""
    if form in (FORCE, LINE):
        return units.format_engineering(result.load, result.pair.load_unit, digits)
    if form is NOMINAL:
        return units.format_engineering(result.load / result.nominal_area, "Pa", digits)
    if form is APPROACH_AXIS and result.approach > 0:
        return units.format_engineering(result.approach, "m", digits)
    return None


def _height(surface: Surface) -> float:
    """Return the range of the heights [m]."""
    return float(np.nanmax(surface.heights) - np.nanmin(surface.heights))


def _rounded(value: float) -> float:
    return float(f"{value:.{_DIGITS - 1}e}")


class LoadPanel:
    """Panel of the load; ``drag`` receives the values while the slider is dragged."""

    def __init__(self, session: Session, give: Give, drag: Give) -> None:
        self._session, self._give, self._drag = session, give, drag
        self._prepared: PreparedMaps | None = None
        self._form = NOMINAL
        self._silent = False
        self._scale: tuple[LoadForm, tuple[float, float]] | None = None
        self.form = pn.widgets.Select(
            label="Load given as",
            options={form.name: form for form in FORMS},
            value=self._form,
            **{**style.CONTROL, "sizing_mode": None},
            width=138,
        )
        self.text = pn.widgets.TextInput(
            label="Value with unit", **{**style.CONTROL, "sizing_mode": None}, width=96
        )
        self.slider = Slider(
            words="Drag the load (logarithmic), or press arrow keys",
            end=STEPS,
            value=-1,
            sizing_mode="stretch_width",
            margin=(0, 12),
            min_width=150,
        )
        self._wrong = pn.pane.HTML("", visible=False, **style.SHEET)
        self.form.param.watch(self._reform, "value")
        self.text.param.watch(self._typed, "value")
        self.slider.param.watch(self._slid, "moved")
        row = pn.Row(self.form, self.text, self.slider, **style.BLOCK, styles={"gap": "8px"})
        self.root = pn.Column(
            row,
            self._wrong,
            css_classes=["step-load"],
            sizing_mode="stretch_width",
            styles={"flex": "1 1 400px", "min-width": "400px"},
            margin=0,
        )

    def refresh(self, prepared: PreparedMaps | None) -> None:
        """Show the load of the state, on the scale of the prepared maps."""
        self._prepared = prepared
        specified = self._session.state.specified
        self._form = form_of(specified)
        text = str(specified.get(self._form.option, ""))
        self._silent = True
        try:
            if self.form.value is not self._form:
                self.form.value = self._form
            if self.text.value != text:
                self.text.value = text
            self.text.placeholder = self._form.example
            self.slider.text = text
            self._rule()
            ends, value = self._ends(), self._value()
            if value is None:
                self.slider.value = -1
            elif ends is not None:
                texts = self.slider.texts
                position = position_of_value(value, ends)
                self.slider.value = texts.index(text) if text in texts else position
        finally:
            self._silent = False

    def _rule(self) -> None:
        """Set the texts and ticks of the slider."""
        ends = self._ends()
        scale = None if ends is None else (self._form, ends)
        if scale == self._scale:
            return
        self._scale = scale
        if ends is None:
            self.slider.param.update(texts=[], ticks=[])
        else:
            texts = [text_at_position(position, ends, self._form) for position in range(STEPS + 1)]
            self.slider.param.update(texts=texts, ticks=slider_ticks(ends, self._form))

    def _ends(self) -> tuple[float, float] | None:
        return None if self._prepared is None else slider_range(self._form, self._prepared)

    def _value(self) -> float | None:
        """Return the value of the load [SI]; None if it is missing or invalid."""
        try:
            request = self._session.state.request()
            value = request.get(LOAD)
            result = request.needed(APPROACH) if value is None else value
        except RoughcontactError:
            return None
        return result if isinstance(result, float) else result.value

    def _reform(self, event: Any) -> None:
        if self._silent:
            return
        outcome, form = self._session.outcome, event.new
        text = None
        if outcome is not None and outcome.contact is not None:
            text = load_text(outcome.contact, form)
        self._form = form
        if text is None:
            ends = self._ends()
            text = form.example if ends is None else text_at_position(STEPS // 2, ends, form)
        self._set(text, self._give)

    def _typed(self, event: Any) -> None:
        if not self._silent:
            self._set(event.new, self._give)

    def _slid(self, event: Any) -> None:
        place = int(event.new["value"])
        if 0 <= place < len(self.slider.texts):
            self._set(self.slider.texts[place], self._give if event.new["done"] else self._drag)

    def _set(self, text: str, give: Give) -> None:
        with style.batch_changes(pn.state.curdoc):
            try:
                give(self._form.option, text)
            except RoughcontactError as error:
                controls.show_alert(self._wrong, controls.error_text(error))
            else:
                self._wrong.visible = False
