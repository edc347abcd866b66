"""How sure the headline numbers are, in rows."""

from __future__ import annotations

import math

from roughcontact.contact import certainty
from roughcontact.contact.certainty import Cause, Interval
from roughcontact.contact.result import ContactResult
from roughcontact.contact.study import ResolutionStudy
from roughcontact.report import profile, tables
from roughcontact.report.quantities import Quantity, Table, quantity_of
from roughcontact.units import changed_by, percent

HEADS = ("as measured", "between", "because of")

WHAT = (
    "Where the numbers of what was measured lie, as far as is known: what whole pixels at the "
    "rim of spots add, what finer grids change, what yielding in the volume changes, and the "
    "tolerance. What the measurement left out is in none of them."
)

NOT_BOUNDED = (
    "The certificate is the tolerance and bounds none of the others: it says how exactly the "
    "problem as stated is solved."
)

# Smaller changes say nothing beside the others.
_LEAST = 5e-4


def rows(result: ContactResult, study: ResolutionStudy | None = None) -> list[tuple[str, str, str]]:
    """Return name, ends and causes of what a result says first.

    Parameters
    ----------
    result : ContactResult
        A solution.
    study : ResolutionStudy, optional
        The same contact on other grids.
    """
    table = profile.CONTACT if result.pair.is_profile else tables.CONTACT
    return [_row(interval, table) for interval in certainty.intervals(result, study)]


def _row(interval: Interval, table: Table) -> tuple[str, str, str]:
    quantity = quantity_of(table, interval.name)
    return quantity.name, _ends(quantity, interval), "; ".join(_causes(interval))


def _ends(quantity: Quantity, interval: Interval) -> str:
    if math.isinf(interval.high):
        return f"{quantity.told(interval.value)}, not bounded"
    low, high = (quantity.told(value) for value in (interval.low, interval.high))
    if interval.unknown and low == high:
        return f"{low}, not bounded"
    told = low if low == high else f"{low} to {high}"
    return f"{told} or beyond" if interval.unknown else told


def _causes(interval: Interval) -> list[str]:
    found = []
    for doubt in interval.doubts:
        if not doubt.known:
            unknown = "not studied" if doubt.cause is Cause.GRID else "not known"
            found.append(f"{doubt.cause} {unknown}")
        elif math.isinf(doubt.high):
            found.append(f"{doubt.cause}: no limit")
        elif max(-doubt.low, doubt.high) >= _LEAST:
            ends = [changed_by(end) for end in (doubt.low, doubt.high) if abs(end) >= _LEAST]
            found.append(f"{doubt.cause} {' to '.join(ends)}")
        elif doubt.cause is Cause.TOLERANCE:
            found.append(f"{doubt.cause} {percent(doubt.high)}")
        elif doubt.low or doubt.high:
            sign, size = ("-", -doubt.low) if -doubt.low > doubt.high else ("+", doubt.high)
            found.append(f"{doubt.cause} {sign}{percent(size)}")
    return found
