"""Rows that compare a contact with its estimate by formulas."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from roughcontact.contact.result import ContactResult
from roughcontact.report.kind import REPORT_ONLY, Quantity
from roughcontact.report.phrases import range_text
from roughcontact.units import format_engineering, format_percent


def with_ends(result: Any, form: Callable[[float], str]) -> str:
    """Return a value with its interval."""
    return f"{form(result.value)} ({range_text(result.low, result.high, form)})"


def share(result: Any) -> str:
    """Return a share with its interval."""
    return with_ends(result, format_percent)


def length_of(result: Any) -> str:
    """Return a length with its interval."""
    return with_ends(result, lambda value: format_engineering(value, "m", 3))


def _side(by: float) -> str:
    return "above" if by > 0 else "below"


def _compare_contact(result: ContactResult) -> str:
    answer = result.estimate
    assert answer is not None
    nominal = result.pressure.size * result.pixel_area
    by = result.perimeter_corrected_area / nominal / answer.contact.value - 1
    own = f"perimeter-corrected, this one is {format_percent(abs(by))} {_side(by)} it"
    return f"{share(answer.contact)}; {own}"


def _compare_gap(result: ContactResult) -> str:
    answer = result.estimate
    assert answer is not None
    by = (result.mean_gap - answer.gap.value) / answer.roughness.Sq
    return f"{length_of(answer.gap)}; this one is {format_percent(abs(by))} of Sq {_side(by)} it"


BY_FORMULA = (
    Quantity(
        "estimated_contact",
        "real contact by formula: of nominally flat surfaces like it, with the interval of 90 in "
        "100",
        of="estimate.contact.value",
        text=_compare_contact,
        **REPORT_ONLY,
    ),
    Quantity(
        "estimated_gap",
        "mean gap by formula [m]: the same",
        of="estimate.gap.value",
        text=_compare_gap,
        **REPORT_ONLY,
    ),
)
"""Estimates for a nominally flat `ContactResult`, compared with the solution."""
