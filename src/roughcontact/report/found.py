"""What is told of loads that were asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import asdict
from operator import attrgetter
from typing import Any

from roughcontact.contact.found import APPROACH, CONTACT, COUNTED, GAP, SATURATED, YIELD, FoundLoads
from roughcontact.report import contact, sources, tables
from roughcontact.report.kind import Kind, Use
from roughcontact.report.largest import PAIR, of_largest
from roughcontact.report.page import PLAIN, Addition, Edition, sentence
from roughcontact.report.quantities import (
    TRUST,
    Column,
    Columns,
    Quantity,
    Table,
    quantity_of,
    tiny,
)
from roughcontact.units import engineering, percent

_NAMES = {
    CONTACT: "contact",
    SATURATED: "saturated contact",
    APPROACH: "approach",
    GAP: "mean gap",
    YIELD: "first yield",
}

# Digits of a load that a bracket of a millionth shows.
_DIGITS = 7


def _unit(quantity: str) -> str:
    return "m" if quantity in (APPROACH, GAP) else "1"


def _told(quantity: str, value: float) -> str:
    if quantity in COUNTED:
        return percent(value)
    return f"{value:.7g}" if quantity == YIELD else engineering(value, "m", 7)


def _asked(loads: FoundLoads) -> list[str]:
    return [
        _NAMES[one.quantity]
        + ("" if one.quantity == YIELD else f" {_told(one.quantity, one.target)}")
        for one in loads.answers
    ]


def _between(bracket: tuple[float, float]) -> str:
    (low, unit), (high, other) = (engineering(load, "N", _DIGITS).split() for load in bracket)
    return f"{low} to {high} {unit}" if unit == other else f"{low} {unit} to {high} {other}"


def _bracket(loads: FoundLoads) -> list[str]:
    return [_between(answer.bracket) for answer in loads.answers]


def _answers(loads: FoundLoads) -> list[dict[str, Any]]:
    return [
        {
            "quantity": one.quantity,
            "unit": _unit(one.quantity),
            "target": one.target,
            "value": one.value,
            "load": one.load,
            "below": asdict(one.below),
            "above": asdict(one.above),
            "certificate": one.certificate,
            "contact": _contact(one.result),
        }
        for one in loads.answers
    ]


def _contact(result: Any) -> dict[str, Any]:
    """Return the numbers of the contact under a load that was found."""
    return {key: quantity_of(tables.CONTACT, key).value(result) for key in _KEPT}


_KEPT = (
    "load_error", "approach", "contact_area", "corrected_contact_area", "contact_fraction",
    "saturated_fraction", "max_pressure", "mean_gap", "regime",
)  # fmt: skip


def _each(read: Callable[[Any], Any]) -> Callable[[FoundLoads], list[Any]]:
    return lambda loads: [read(one) for one in loads.answers]


FOUND: Table = (
    *PAIR,
    Quantity("answers", of=_answers),
    Quantity(
        "solves", "contacts solved", part=TRUST,
        text=lambda r: f"{r.solves}, {r.convolutions} convolutions on the full grid",
    ),
    Quantity("convolutions"),
    Quantity("seconds", "time of the search", unit="s", part=TRUST),
    Quantity(
        "worst_certificate", "certificates", symbol="ε", part=TRUST, stored=False,
        of=lambda r: max(one.certificate for one in r.answers), form=lambda v: f"{v:.1e} at most",
    ),
    *(quantity_of(tables.CONTACT, key) for key in ("warnings", "cautions")),
    of_largest("version"),
)  # fmt: skip
"""Of `FoundLoads`."""

FOUND_COLUMNS: Columns = (
    Column("quantity", of=_each(lambda one: one.quantity)),
    Column("unit", of=_each(lambda one: _unit(one.quantity))),
    Column("asked", "asked for", of=_asked, stored=False),
    Column("target", of=_each(lambda one: one.target)),
    Column("load", "load", unit="N", digits=_DIGITS, of=_each(lambda one: one.load)),
    Column("bracket", "passed between", of=_bracket, stored=False),
    Column("below", unit="N", of=_each(lambda one: one.below.load)),
    Column("above", unit="N", of=_each(lambda one: one.above.load)),
    Column(
        "value", "there", of=_each(lambda one: one.value),
        shown=_each(lambda one: _told(one.quantity, one.value)),
    ),
    Column("certificate", of=_each(lambda one: one.certificate), form=tiny, brief=False),
)  # fmt: skip
"""Of the answers of `FoundLoads`."""


def addition(loads: FoundLoads) -> Addition:
    """Return the chapter on the loads that were asked for; the report is on the largest of them."""
    head, rows = KIND.listing(loads)
    told = (KIND.row(loads, key) for key in ("solves", "worst_certificate"))
    text = (
        "Each load is one of its bracket, two neighboring loads that were solved: under the "
        "smaller the value is not reached, under the larger it is.",
        *(sentence(f"{row.name}: {row.text}") for row in told),
        f"The report is on the largest of these loads, {engineering(loads.largest.load, 'N')}.",
    )
    return Addition("Loads that were asked for", text, (head, *rows))


def _works(loads: FoundLoads) -> Iterator[Use]:
    if any(answer.quantity == YIELD for answer in loads.answers):
        yield sources.below(loads.largest.boundary)


def render(loads: FoundLoads, edition: Edition = PLAIN) -> str:
    """Return the report on the contact under the largest load, with a chapter on all of them."""
    return contact.compared(loads.largest, edition, [addition(loads)])


KIND = Kind(
    FoundLoads, FOUND, FOUND_COLUMNS, contact=attrgetter("largest"), works=_works, report=render,
)  # fmt: skip
