"""Bodies, load and boundary of a contact in one line, and how it was solved in another."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from roughcontact.contact.load_case import GivenLoad, HertzPressure, LineLoad, NominalPressure
from roughcontact.contact.result import ContactResult
from roughcontact.material.material import Material
from roughcontact.report.fields import tiny
from roughcontact.report.phrases import is_rigid
from roughcontact.units import engineering, grouped, percent

DIGITS = 3
"""Significant digits of what is said first."""


def share(value: float) -> str:
    """Return a share with two digits, as a sentence has it."""
    text = f"{100 * value:.2g}"
    return percent(value) if "e" in text else f"{text} %"


def size(value: float, unit: str) -> str:
    """Return a quantity as what is said first has it."""
    return grouped(engineering(value, unit, DIGITS))


def between(low: float, high: float, form: Any) -> str:
    """Return both ends of an interval, the unit once where it is the same."""
    first, last = form(low), form(high)
    number, _, unit = first.partition(" ")
    return f"{number if number and last.endswith(f' {unit}') else first} to {last}"


def map_name(surface: Any) -> str:
    """Return the file of a map, or its nominal form."""
    source = str(surface.provenance.source)
    made = source.partition(", ")[0]
    if made.startswith("nominal "):
        return f"a {made.removeprefix('nominal ')}"
    if made.startswith("generated "):
        return f"a {made}"
    return source or "an unnamed map"


def _material(body: Material) -> str:
    return body.name or f"E {engineering(body.young, 'Pa', DIGITS)}"


def _counter(contact: ContactResult) -> str:
    other = contact.counter_material
    rigid = is_rigid(other)
    if contact.counter_surface is None:
        return "a rigid flat" if rigid else f"a flat ({_material(other)})"
    name = map_name(contact.counter_surface)
    return f"{name} ({'rigid' if rigid else _material(other)})"


def bodies(contact: ContactResult, name: str = "") -> str:
    """Return both bodies and their materials; the first by its file, or by another name."""
    against = "on" if contact.counter_surface is None else "against"
    name = name or map_name(contact.share)
    return f"{name} ({_material(contact.material)}) {against} {_counter(contact)}"


def force(value: float, unit: str) -> str:
    """Return a force, or one per length [N/m] as engineers write it."""
    return f"{size(1e-3 * value, 'N')}/mm" if unit == "N/m" else size(value, unit)


def load(contact: ContactResult) -> str:
    """Return the load as it was given, and the force where that is another number."""
    if contact.control == "approach":
        return f"approach {size(contact.approach, 'm')}"
    specified = contact.specified_load
    # Of a body that is unloaded it is the largest load.
    largest = contact.load if specified is None else specified.force
    return load_text(specified, largest, contact.pair.load_unit)


def load_text(specified: GivenLoad | None, load: float, unit: str) -> str:
    """Return a load in its own form, with the force."""
    total = force(load, unit)
    match None if specified is None else specified.form:
        case NominalPressure(value=value):
            return f"{size(value, 'Pa')} nominal ({total})"
        case HertzPressure(value=value):
            return f"Hertz pressure {size(value, 'Pa')} ({total})"
        case LineLoad(value=value):
            return f"{force(value, 'N/m')} ({total})"
    return total


def boundary(contact: ContactResult) -> str:
    """Return the boundary where it is not free, after a comma."""
    return "" if str(contact.boundary) == "free" else f", {contact.boundary}"


def line(contact: ContactResult) -> str:
    """Return the problem of a contact."""
    return f"{bodies(contact)}, {load(contact)}{boundary(contact)}"


def of_loads(contact: ContactResult, loads: Sequence[float]) -> str:
    """Return the problem of a contact under several loads, smallest and largest."""
    if len(loads) == 1:
        return line(contact)
    ends = (min(loads), max(loads))
    if contact.specified_load is not None and isinstance(
        contact.specified_load.form, NominalPressure
    ):
        area = contact.nominal_area
        span = between(ends[0] / area, ends[1] / area, lambda value: size(value, "Pa"))
        what = f"nominal pressures from {span}"
    else:
        unit = contact.pair.load_unit
        what = f"loads from {between(*ends, lambda value: force(value, unit))}"
    return f"{bodies(contact)}, {len(loads)} {what}{boundary(contact)}"


def status(contact: ContactResult) -> str:
    """Return how exactly a contact is solved."""
    limit = f"{tiny(contact.certificate)} (limit {contact.tolerance:.0e})"
    if not contact.converged:
        return f"Not converged: certificate {limit}. Do not use these numbers."
    return f"Solved: certificate {limit}, {size(contact.seconds, 's')}"


def worst(certificate: float, tolerance: float, count: int) -> str:
    """Return how exactly several contacts are solved."""
    return f"Solved: {count} contacts, certificate {tiny(certificate)} (limit {tolerance:.0e})"
