"""Header of the page: load with slider, key quantities, state, checklist, and cautions."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import panel as pn

import roughcontact as rc
from roughcontact import cautions as caution_types, errors, units
from roughcontact.analyses.solve import fields, report as contact_report, uncertainty_report
from roughcontact.desk import controls, style
from roughcontact.desk.controls import (
    Give,
    escape_markup,
    gravest_first,
    make_button,
    markup_table,
    spell_sentence,
)
from roughcontact.desk.live_solver import PreparedMaps
from roughcontact.desk.session import PAGE, SOLVE, Session
from roughcontact.desk.widgets import Slider
from roughcontact.report import kind as quantities
from roughcontact.report.presentation import presentation_of
from roughcontact.request import options

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
    pressure = _HIGHEST * rc.contact_modulus(*bodies)
    ceiling = request.get(options.CEILING)
    if isinstance(ceiling, str):
        known = [body.ceiling for body in bodies if body.ceiling is not None]
        # No single value is valid for a coated body.
        ceiling = None if any(body.coating for body in bodies) else min(known, default=None)
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
    return _round_load(largest * 10.0**-_DECADES), _round_load(largest)


def text_at_position(position: int, ends: tuple[float, float], form: LoadForm) -> str:
    """Return the load at a position of the slider, as text with unit."""
    value = ends[0] * (ends[1] / ends[0]) ** (position / STEPS)
    return form.lead + units.format_engineering(_round_load(value), form.unit, _DIGITS)


def slider_ticks(ends: tuple[float, float], form: LoadForm) -> list[tuple[float, str]]:
    """Return the ticks of the scale: a place from 0 to 1 a decade, every second with a label."""
    first, last = (math.floor(math.log10(end)) for end in ends)
    return [
        (
            math.log(value / ends[0]) / math.log(ends[1] / ends[0]),
            units.format_engineering(value, form.unit, _DIGITS) if power % 2 == last % 2 else "",
        )
        for power, value in ((power, 10.0**power) for power in range(first, last + 1))
        if ends[0] <= value <= ends[1]
    ]


def position_of_value(value: float, ends: tuple[float, float]) -> int:
    """Return the slider position nearest to a value."""
    share = math.log(value / ends[0]) / math.log(ends[1] / ends[0]) if value > 0 else 0.0
    return round(STEPS * min(1.0, max(0.0, share)))


def load_text(result: rc.ContactResult, form: LoadForm, digits: int = _DIGITS) -> str | None:
    """Return the load of a result in a form, as text with unit; None if unknown."""
    if form in (FORCE, LINE):
        return units.format_engineering(result.load, result.pair.load_unit, digits)
    if form is NOMINAL:
        return units.format_engineering(result.load / result.nominal_area, "Pa", digits)
    if form is APPROACH_AXIS and result.approach > 0:
        return units.format_engineering(result.approach, "m", digits)
    return None


def _height(surface: rc.Surface) -> float:
    """Return the range of the heights [m]."""
    return float(np.nanmax(surface.heights) - np.nanmin(surface.heights))


def _round_load(value: float) -> float:
    return float(f"{value:.{_DIGITS - 1}e}")


class LoadPanel:
    """Panel of the load; ``drag`` receives the values while the slider is dragged."""

    def __init__(self, session: Session, give: Give, drag: Give) -> None:
        self._session, self._give, self._drag = session, give, drag
        self._form = NOMINAL
        self._silent = False
        self._shown = ""
        self._scale: tuple[LoadForm, tuple[float, float] | None] = NOMINAL, None
        unlabeled = {**style.BLOCK, "stylesheets": [style.TEXT, style.CSS["UNLABELED"]]}
        self.form = pn.widgets.Select(
            label="Load given as",
            options={form.name: form for form in FORMS},
            value=self._form,
            **unlabeled,
        )
        self.text = pn.widgets.TextInput(label="Value with unit", **{**unlabeled, "margin": 0})
        self.slider = Slider(
            words="Drag the load (logarithmic), or press arrow keys",
            end=STEPS,
            value=-1,
            sizing_mode="stretch_width",
            align="center",
            margin=(0, 12),
        )
        self._wrong = pn.pane.HTML("", visible=False, **style.SHEET)
        self.form.param.watch(self._reform, "value")
        self.text.param.watch(self._handle_input, "value")
        self.slider.param.watch(self._slid, "moved")
        fields = pn.Column(self.form, self.text, width=150, margin=0)
        self.root = pn.Column(
            pn.Row(fields, self.slider, sizing_mode="stretch_width", margin=0),
            self._wrong,
            css_classes=["step-load"],
            sizing_mode="stretch_width",
            styles={"flex": "1 1 320px", "min-width": "320px"},
            margin=0,
        )

    def refresh(self) -> None:
        """Show the load of the state, on the scale of the prepared maps."""
        specified = self._session.state.specified
        self._form = form_of(specified)
        text = str(specified.get(self._form.option, ""))
        self._silent = True
        try:
            if self.form.value is not self._form:
                self.form.value = self._form
            # An invalid text stays, with its error, until the load changes.
            if text != self._shown:
                self._shown = self.text.value = text
                self._show_error("")
            self.text.placeholder = f"e.g. {self._form.example}"
            self.slider.text = text
            ends, value = self._ends(), self._value()
            self._rule(ends)
            if value is None:
                self.slider.value = -1
            elif ends is not None:
                texts = self.slider.texts
                position = position_of_value(value, ends)
                self.slider.value = texts.index(text) if text in texts else position
        finally:
            self._silent = False

    def _rule(self, ends: tuple[float, float] | None) -> None:
        """Set the texts and ticks of the slider."""
        if (self._form, ends) == self._scale:
            return
        self._scale = self._form, ends
        if ends is None:
            self.slider.param.update(texts=[], ticks=[])
        else:
            texts = [text_at_position(position, ends, self._form) for position in range(STEPS + 1)]
            self.slider.param.update(texts=texts, ticks=slider_ticks(ends, self._form))

    def _ends(self) -> tuple[float, float] | None:
        prepared = self._session.prepared
        return None if prepared is None else slider_range(self._form, prepared)

    def _value(self) -> float | None:
        """Return the value of the load [SI]; None if it is missing or invalid."""
        try:
            request = self._session.state.request()
            value = request.get(options.LOAD)
            result = request.require(options.APPROACH) if value is None else value
        except rc.RoughcontactError:
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

    def _handle_input(self, event: Any) -> None:
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
            except rc.RoughcontactError as error:
                self._show_error(controls.error_text(error))
            else:
                self._show_error("")

    def _show_error(self, text: str) -> None:
        controls.mark_field(self.text, text)
        controls.show_alert(self._wrong, text)


_KEYS = ("load", "contact_fraction", "saturated_fraction", "mean_pressure", "mean_gap", "approach")

_CHECKS: dict[str, list[str]] = PAGE["checks"]
"""Required inputs of a contact by option: label, step where it is entered, and what to do."""


def key_numbers(result: rc.ContactResult, form: LoadForm = FORCE) -> str:
    """Return the key quantities with intervals, or values under the calibrated ceiling.

    A load that is given as nominal pressure is shown as such, with its force below.
    """
    ends = uncertainty_report.brief_ends(result)
    calibrated = contact_report.calibrated_numbers(result)
    table = fields.PROFILE_CONTACT if result.pair.is_profile else fields.CONTACT
    cells = []
    for key in _KEYS:
        if result.ceiling is None and key == "saturated_fraction":
            continue
        quantity = quantities.quantity_of(table, key)
        row = quantity.row(result)
        other = ends.get(key) or (f"calibrated {calibrated[key]}" if key in calibrated else "")
        name, value = row.name[:1].upper() + row.name[1:], quantity.format_value(row.value)
        if key == "load" and form is NOMINAL:
            value, other = str(load_text(result, form, 4)), value
        cells.append(
            f"<div><dt>{escape_markup(name)}</dt><dd>{escape_markup(value)}</dd>"
            f"<small>{escape_markup(other)}</small></div>"
        )
    return f'<dl class="numbers">{"".join(cells)}</dl>'


def trust_line(result: rc.ContactResult) -> str:
    """Return the status, certificate and regime of a result as one line."""
    rows = {row.key: row for row in presentation_of(result).rows(quantities.TRUST, brief=True)}
    shown = (rows[key] for key in ("status", "certificate") if key in rows)
    texts = ", ".join(f"{row.name} {spell_sentence(row.text)}" for row in shown)
    texts = texts.removeprefix("status ")
    kind = "good" if result.converged else "bad"
    return (
        f'<span class="{kind}">●</span> {escape_markup(texts)}; regime: '
        f"{escape_markup(result.regime)}"
    )


def suggested_settings(caution: caution_types.Caution) -> Iterable[tuple[str, str, str | bool]]:
    """Yield the settings that a caution suggests: text, option and value."""
    for part in caution.parts:
        if not isinstance(part, errors.ArgumentRef) or part.value is None:
            continue
        option = SOLVE.option_of_argument(part.name)
        if option is not None:
            value = True if part.value is True else option.text(part.value)
            yield f"Use {option.label.lower()} {value}", option.name, value


class Header:
    """Second line of the page header, and the drawer that it opens."""

    def __init__(self, load: Any, give: Give, seek: Callable[[str], None]) -> None:
        self._give = give
        sheets = [style.TEXT, style.CSS["NUMBERS"]]
        self.numbers = pn.pane.HTML("", margin=0, align="center", stylesheets=sheets)
        self._checks = {
            name: make_button("", partial(seek, place)) for name, (_, place, _) in _CHECKS.items()
        }
        self.checklist = pn.Row(*self._checks.values(), margin=0, visible=False, align="center")
        sheets = [style.TEXT, style.CSS["CHIP"]]
        self.state = pn.pane.HTML("", width=150, margin=(2, 0), stylesheets=sheets)
        self.count = make_button("", partial(self._open, "Cautions"), margin=0, visible=False)
        self._cautions: Sequence[caution_types.Caution] = ()
        self._topic = self.next_step = ""
        self.drawer = pn.Column(
            visible=False, stylesheets=[style.TEXT, style.CSS["DRAWER"]], margin=0
        )
        status = pn.Column(
            self.state, self.count, width=150, margin=0, align="center", styles={"flex": "none"}
        )
        self.root = pn.Row(
            load,
            self.numbers,
            self.checklist,
            status,
            sizing_mode="stretch_width",
            margin=0,
            stylesheets=[style.CSS["BAR"]],
        )

    def show_state(self, text: str, kind: str = "quiet") -> None:
        """Show the state as text: solving, up to date, out of date."""
        text = escape_markup(text)
        self.state.object = f'<span role="status" class="chip {kind}" title="{text}">{text}</span>'

    def show_numbers(self, text: str, cautions: Iterable[caution_types.Caution]) -> None:
        """Show the key quantities of a contact and the number of its cautions."""
        self.checklist.visible, self.numbers.visible = False, True
        self.numbers.object = text
        self.show_cautions(cautions)

    def show_lacking(self, lacking: Collection[str]) -> None:
        """Show the checklist of required inputs, with a check mark on complete ones."""
        self.numbers.visible, self.checklist.visible = False, True
        self.numbers.object = ""
        self.show_cautions(())
        first = next((name for name in _CHECKS if name in lacking), "")
        shown = [name for name in _CHECKS if name != "missing" or name in lacking]
        for name, check in self._checks.items():
            check.visible = name in shown
            mark = shown.index(name) + 1 if name in lacking else "✓"
            check.label = f"{mark} {_CHECKS[name][0]}"
            check.color = "primary" if name == first else "default"
        self.next_step = f"Next: {_CHECKS[first][2]}" if first else "No contact"

    def show_cautions(self, cautions: Iterable[caution_types.Caution]) -> None:
        """Show the number of cautions by severity; an open drawer lists the cautions."""
        self._cautions = gravest_first(cautions)
        self.count.visible = bool(self._cautions)
        if self._cautions:
            gravest = self._cautions[0].severity
            count = sum(item.severity == gravest for item in self._cautions)
            rest = len(self._cautions) - count
            self.count.label = units.count_noun(count, str(gravest)) + (rest > 0) * f", {rest} more"
            severe = gravest == caution_types.Severity.WARNING
            self.count.styles = {"--text": "var(--severe)"} if severe else {}
        if self._topic == "Cautions":
            self._fill()

    def handle_key(self, key: str) -> None:
        """Handle a key: ``?`` toggles the list of keys, any other key closes the drawer."""
        if key == "?":
            self._open("Keys")
        elif self._topic:
            self.close()

    def close(self) -> None:
        """Close the drawer."""
        self._topic, self.drawer.visible = "", False

    def _open(self, topic: str) -> None:
        if self._topic == topic:
            self.close()
            return
        self._topic = topic
        self._fill()
        self.drawer.visible = True

    def _fill(self) -> None:
        head = pn.Row(
            pn.pane.HTML(f"<h2>{self._topic}</h2>", sizing_mode="stretch_width", **style.SHEET),
            make_button("Close", self.close, margin=0),
            **style.BLOCK,
        )
        if self._topic == "Keys":
            parts = [pn.pane.HTML(markup_table(PAGE["keys"].items()), **style.SHEET)]
        else:
            parts = [part for caution in self._cautions for part in self._caution(caution)]
        self.drawer[:] = [head, *(parts or [pn.pane.HTML("No cautions.")])]

    def _caution(self, caution: caution_types.Caution) -> list[Any]:
        name = caution.kind.replace("-", " ")
        text = (
            f'<p><b class="{caution.severity}">{caution.severity} · {escape_markup(name)}</b></p>'
            f"<p>{escape_markup(spell_sentence(caution.text))}</p>"
        )
        todo = [
            make_button(words, partial(self._give, option, value), margin=(0, 6, 12, 0))
            for words, option, value in suggested_settings(caution)
        ]
        return [pn.pane.HTML(text, sizing_mode="stretch_width", **style.SHEET), *todo]
