"""What is told of loads that were asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import asdict
from operator import attrgetter
from typing import Any

from roughcontact.report import citations, contact_fields, phrases
from roughcontact.report.contact_fields import PAIR, of_largest
from roughcontact.report.fields import TRUST, Column, Columns, Quantity, Table, quantity_of, tiny
from roughcontact.report.kind import Kind, Use
from roughcontact.report.page import Block
from roughcontact.studies.load_search import (
    APPROACH,
    CONTACT,
    COUNTED,
    GAP,
    SATURATED,
    YIELD,
    LoadSearch,
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


def _asked(loads: LoadSearch) -> list[str]:
    return [
        _NAMES[item.quantity]
        + ("" if item.quantity == YIELD else f" {_told(item.quantity, item.target)}")
        for item in loads.answers
    ]


def _between(bracket: tuple[float, float]) -> str:
    (low, unit), (high, other) = (engineering(load, "N", _DIGITS).split() for load in bracket)
    return f"{low} to {high} {unit}" if unit == other else f"{low} {unit} to {high} {other}"


def _bracket(loads: LoadSearch) -> list[str]:
    return [_between(answer.bracket) for answer in loads.answers]


def _answers(loads: LoadSearch) -> list[dict[str, Any]]:
    return [
        {
            "quantity": item.quantity,
            "unit": _unit(item.quantity),
            "target": item.target,
            "value": item.value,
            "load": item.load,
            "below": asdict(item.below),
            "above": asdict(item.above),
            "certificate": item.certificate,
            "contact": _contact(item.result),
        }
        for item in loads.answers
    ]


def _contact(result: Any) -> dict[str, Any]:
    """Return the numbers of the contact under a load that was found."""
    return {key: quantity_of(contact_fields.CONTACT, key).value(result) for key in _KEPT}


_KEPT = (
    "load_error", "approach", "contact_area", "corrected_contact_area", "contact_fraction",
    "saturated_fraction", "max_pressure", "mean_gap", "regime",
)  # fmt: skip


def _each(read: Callable[[Any], Any]) -> Callable[[LoadSearch], list[Any]]:
    return lambda loads: [read(item) for item in loads.answers]


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
        of=lambda r: max(item.certificate for item in r.answers), form=lambda v: f"{v:.1e} at most",
    ),
    *(quantity_of(contact_fields.CONTACT, key) for key in ("warnings", "cautions")),
    of_largest("version"),
)  # fmt: skip
"""Of `LoadSearch`."""

FOUND_COLUMNS: Columns = (
    Column("quantity", of=_each(lambda item: item.quantity)),
    Column("unit", of=_each(lambda item: _unit(item.quantity))),
    Column("asked", "asked for", of=_asked, stored=False),
    Column("target", of=_each(lambda item: item.target)),
    Column("load", "load", unit="N", digits=_DIGITS, of=_each(lambda item: item.load)),
    Column("bracket", "passed between", of=_bracket, stored=False),
    Column("below", unit="N", of=_each(lambda item: item.below.load)),
    Column("above", unit="N", of=_each(lambda item: item.above.load)),
    Column(
        "value", "there", of=_each(lambda item: item.value),
        shown=_each(lambda item: _told(item.quantity, item.value)),
    ),
    Column("certificate", of=_each(lambda item: item.certificate), form=tiny, brief=False),
)  # fmt: skip
"""Of the answers of `LoadSearch`."""


def question(loads: LoadSearch) -> str:
    """Return the question that a load search answers."""
    name = phrases.source(loads.largest.share.provenance)
    return f"Which load gives {' and '.join(_asked(loads))} of {name}?"


def _method(_: LoadSearch) -> list[Block]:
    return [
        Block(
            "text",
            "Each load is one of its bracket, two neighboring loads that were solved: the value is "
            "reached under the larger, not under the smaller.",
        )
    ]


def _works(loads: LoadSearch) -> Iterator[Use]:
    if any(answer.quantity == YIELD for answer in loads.answers):
        yield citations.below(loads.largest.boundary)


KIND = Kind(
    LoadSearch, FOUND, FOUND_COLUMNS, contact=attrgetter("largest"), works=_works,
    question=question, method=_method,
)  # fmt: skip
