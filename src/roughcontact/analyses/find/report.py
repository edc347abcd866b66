"""Report of a load search."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import asdict
from typing import Any

from roughcontact.analyses.find import model as search
from roughcontact.analyses.solve import fields as contact_fields, uncertainty_report
from roughcontact.analyses.solve.fields import PAIR, stored_quantity
from roughcontact.analyses.sweep.report import certificates_of
from roughcontact.contact.nominal_hertz import has_nominal_body
from roughcontact.report import citations, phrases
from roughcontact.report.kind import (
    CAUTIONS,
    TRUST,
    CellTable,
    Column,
    Quantity,
    Use,
    plain_value,
    quantity_of,
)
from roughcontact.report.phrases import format_share, format_short, range_text
from roughcontact.report.presentation import Presentation
from roughcontact.units import format_engineering, format_percent, join_ends, order_of_magnitude

_NAMES = {
    search.CONTACT: "contact",
    search.SATURATED: "saturated contact",
    search.APPROACH: "approach",
    search.GAP: "mean gap",
    search.YIELD: "first yield",
}

# Digits of a load, for brackets of 1e-6.
_DIGITS = 7


def _unit(quantity: str) -> str:
    return "m" if quantity in (search.APPROACH, search.GAP) else "1"


def _value_text(quantity: str, value: float) -> str:
    if quantity in search.COUNTED:
        return format_percent(value)
    return f"{value:.7g}" if quantity == search.YIELD else format_engineering(value, "m", 7)


def _targets(loads: search.LoadSearch) -> list[str]:
    return [
        _NAMES[item.quantity]
        + ("" if item.quantity == search.YIELD else f" {_value_text(item.quantity, item.target)}")
        for item in loads.answers
    ]


def _format_bracket(bracket: tuple[float, float]) -> str:
    low, high = (format_engineering(load, "N", _DIGITS) for load in bracket)
    return join_ends(low, high)


def _bracket(loads: search.LoadSearch) -> list[str]:
    return [_format_bracket(answer.bracket) for answer in loads.answers]


def _answers(loads: search.LoadSearch) -> list[dict[str, Any]]:
    return [
        {
            "quantity": item.quantity,
            "unit": _unit(item.quantity),
            "target": item.target,
            "value": item.value,
            "load": item.load,
            "bracket_low": asdict(item.bracket_low),
            "bracket_high": asdict(item.bracket_high),
            "certificate": item.certificate,
            "contact": _contact(item.result),
        }
        for item in loads.answers
    ]


def _contact(result: Any) -> dict[str, Any]:
    """Return the stored quantities of the contact under a load that was found."""
    known = {key: quantity_of(contact_fields.CONTACT, key).value(result) for key in _KEPT}
    return {key: plain_value(value) for key, value in known.items()}


_KEPT = (
    "load_error",
    "approach",
    "contact_area",
    "perimeter_corrected_area",
    "contact_fraction",
    "saturated_fraction",
    "max_pressure",
    "mean_gap",
    "regime",
    "calibrated",
)


def _each(read: Callable[[Any], Any]) -> Callable[[search.LoadSearch], list[Any]]:
    return lambda loads: [read(item) for item in loads.answers]


FOUND = (
    *PAIR,
    Quantity("answers", of=_answers),
    Quantity("base_answers", of=lambda r: r.base and _answers(r.base)),
    Quantity(
        "solves",
        "contacts solved",
        part=TRUST,
        text=lambda r: f"{r.solves}, {r.convolutions} convolutions on the full grid",
    ),
    Quantity("convolutions"),
    Quantity("seconds", "time of the search [s]", part=TRUST),
    certificates_of("answers"),
    *CAUTIONS,
    stored_quantity("largest", "version"),
)
"""Quantities of a `LoadSearch`."""

FOUND_COLUMNS = (
    Column("quantity", of="answers.quantity"),
    Column("unit", of=_each(lambda item: _unit(item.quantity))),
    Column("wanted", "wanted", of=_targets, stored=False),
    Column("target", of="answers.target"),
    Column("load", "load [N]", digits=_DIGITS, of="answers.load"),
    Column("bracket", "bracket", of=_bracket, stored=False),
    Column("bracket_low", "[N]", of="answers.bracket_low.load"),
    Column("bracket_high", "[N]", of="answers.bracket_high.load"),
    Column(
        "value",
        "there",
        of="answers.value",
        shown=_each(lambda item: _value_text(item.quantity, item.value)),
    ),
    Column("certificate", of="answers.certificate", form=order_of_magnitude),
    Column("base_load", "load (base) [N]", digits=_DIGITS, of="base.answers.load"),
)
"""Columns of the answers of a `LoadSearch`."""


def _format_target(item: Any) -> str:
    if item.quantity == search.YIELD:
        return "first yield"
    value = item.target
    if item.quantity in search.COUNTED:
        state = "in contact" if item.quantity == search.CONTACT else "of the contact at the ceiling"
        return f"{format_share(value)} {state}"
    return f"{_NAMES[item.quantity]} {format_short(value, 'm')}"


def _pressure(loads: search.LoadSearch, force: float) -> str:
    contact = loads.largest
    return format_short(force / contact.nominal_area, "N/m" if contact.pair.is_profile else "Pa")


class SearchPresentation(Presentation):
    """Presentation of a load search."""

    result: search.LoadSearch
    table = FOUND
    columns = FOUND_COLUMNS
    contact_name = "largest"

    def question(self) -> str:
        """Return the question that a load search answers."""
        name = phrases.source(self.result.largest.surface.provenance)
        return f"Which load gives {' and '.join(_targets(self.result))} of {name}?"

    def answer(self) -> str:
        """Return the load of the first target as a sentence."""
        loads = self.result
        first, unit = loads.answers[0], loads.largest.pair.load_unit
        force = format_short(first.load, unit)
        wanted = _format_target(first)
        subject = wanted[:1].upper() + wanted[1:]
        pressure, under = _pressure(loads, first.load), ""
        pair = loads.largest.pair
        is_bounded = pair.is_profile or has_nominal_body(pair.origins)
        is_contact = first.quantity == search.CONTACT
        ends = uncertainty_report.area_ends(first.result) if is_contact else None
        if ends is not None and loads.base is None:
            ends = first.load * first.target / ends[1], first.load * first.target / ends[0]
            pressure = f"{pressure} ({range_text(*ends, lambda v: _pressure(loads, v))})"
            if is_bounded:
                force = f"{force} ({range_text(*ends, lambda v: format_short(v, unit))})"
        if loads.base is not None:
            other = loads.base.answers[0].load
            force = range_text(first.load, other, lambda v: format_short(v, unit))
            pressure = range_text(first.load, other, lambda v: _pressure(loads, v))
            under = ", from the ceiling of the coating to that of the base"
        if is_bounded:
            return f"{subject} needs {force}{under}."
        return f"{subject} needs {pressure} nominal pressure ({force}){under}."

    def numbers(self) -> CellTable:
        """Return nominal pressure, load and bracket of each target."""
        loads = self.result
        pair, rows = loads.largest.pair, []
        unit, is_bounded = pair.load_unit, has_nominal_body(pair.origins)
        searches = {"": loads.answers}
        if loads.base is not None:
            searches = {", coating": loads.answers, ", base": loads.base.answers}
        for ceiling, answers in searches.items():
            for item in answers:
                low, high = item.bracket
                half = (high - low) / 2 / item.load if item.load else 0.0
                row = (
                    _format_target(item) + ceiling,
                    *([] if is_bounded else [_pressure(loads, item.load)]),
                    format_short(item.load, unit),
                )
                rows.append((*row, f"± {100 * half:.1g} %"))
        return ("wanted", *([] if is_bounded else ["nominal pressure"]), "load", "bracket"), rows

    def remarks(self) -> Iterator[str]:
        """Yield the uncertainty of the load by the model, and the accuracy of the solution."""
        loads = self.result
        for item in loads.answers:
            is_contact = item.quantity == search.CONTACT
            interval = uncertainty_report.area_interval(item.result) if is_contact else None
            if interval is not None and (text := uncertainty_report.sources(interval, hint=False)):
                yield text
                break
        certificate = max(item.certificate for item in loads.answers)
        yield phrases.worst(certificate, loads.largest.tolerance, loads.solves)

    def method(self) -> Iterator[str]:
        """Yield the paragraphs on the method."""
        ends = "under the larger and not under the smaller"
        yield f"Each value is reached between two solved loads, {ends}."

    def works(self) -> Iterator[Use]:
        """Yield the works cited for the result."""
        if any(answer.quantity == search.YIELD for answer in self.result.answers):
            yield citations.stress_references(self.result.largest.boundary)

    def problem(self) -> str:
        """Return the bodies and the boundary."""
        return phrases.bodies(self.result.largest) + phrases.boundary(self.result.largest)
