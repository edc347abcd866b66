"""Report of a load curve."""

from __future__ import annotations

from dataclasses import replace

from roughcontact.analyses.solve import fields as contact_fields
from roughcontact.analyses.sweep import (
    fields as sweep_fields,
    illustrations as sweep_illustrations,
    profile_figures,
)
from roughcontact.analyses.sweep.figures import load_curve
from roughcontact.analyses.sweep.model import LOW_LOAD, LoadCurve
from roughcontact.contact.nominal_hertz import has_nominal_body
from roughcontact.report import phrases
from roughcontact.report.kind import Presentation
from roughcontact.report.page import Block
from roughcontact.units import format_engineering, format_percent, order_of_magnitude


def question(curve: LoadCurve) -> str:
    """Return the question that a load curve answers."""
    unit = "m" if curve.control == "approach" else "N/m" if curve.is_profile else "N"
    ends = [format_engineering(getattr(step, curve.control), unit) for step in curve.steps]
    name = curve.source or "the surface"
    return f"How does the contact of {name} grow from {phrases.span(ends)}?"


def _method(curve: LoadCurve) -> list[Block]:
    text = ["Each load is solved as a first loading; the model keeps no history."]
    if curve.low_loads.any() and not curve.is_profile:
        text.append(
            f"At small loads (up to {format_percent(LOW_LOAD)} in contact) the area is A = κ W/(E* "
            "h′). "
            "Theory gives κ = 2.5 (Bush, Gibson and Thomas 1975) and 1.6 (Persson 2001), "
            "computations 1.8 to 2.3 (Hyun et al. 2004)."
        )
    return [Block("text", " ".join(text))]


# --- Headline ---


def _problem(curve: LoadCurve) -> str:
    name = curve.source or "an unnamed map"
    control = "loads" if curve.control == "load" else "approaches"
    first, last = (getattr(step, curve.control) for step in (curve.steps[0], curve.steps[-1]))
    unit = (contact_fields.LOAD if curve.is_profile else "N") if curve.control == "load" else "m"
    ends = phrases.range_text(first, last, lambda value: phrases.format_short(value, unit))
    text = f"{name}, {len(curve.steps)} {control} from {ends}"
    if curve.is_profile or has_nominal_body(curve.origins):
        return text
    first, last = (step.load / curve.nominal_area for step in (curve.steps[0], curve.steps[-1]))
    ends = phrases.range_text(first, last, lambda value: phrases.format_short(value, "Pa"))
    return f"{text} ({ends} nominal)"


def _answer(curve: LoadCurve) -> str:
    """Return the growth of the contact from first to last load as a sentence."""
    what = "profile" if curve.is_profile else "face"
    if curve.base is None:
        return f"The contact grows from {_growth(curve)} of the {what}."
    return (
        f"The contact grows from {_growth(curve)} of the {what} under the ceiling of the coating, "
        f"from {_growth(curve.base)} under that of the base."
    )


def _growth(curve: LoadCurve) -> str:
    first, last = (curve.steps[n].contact_area / curve.nominal_area for n in (0, -1))
    return phrases.range_text(first, last, phrases.format_share)


def _remarks(curve: LoadCurve) -> tuple[str, ...]:
    """Return the remarks on the intervals, and the accuracy of the steps."""
    most = max(step.certificate for step in curve.steps)
    limits = curve.intervals[-1].remarks if curve.intervals else ()
    return (
        *limits,
        f"Solved: {len(curve.steps)} contacts, certificate {order_of_magnitude(most)} at most",
    )


KIND = Presentation(
    LoadCurve,
    sweep_fields.CURVE,
    sweep_fields.CURVE_COLUMNS,
    listed=True,
    figures=sweep_illustrations.CURVE,
    plots=(load_curve,),
    works=sweep_fields.curve_references,
    question=question,
    problem=_problem,
    answer=_answer,
    remarks=_remarks,
    method=_method,
    largest=lambda curve: curve.largest,
)
PROFILE_KIND = replace(
    KIND,
    table=sweep_fields.PROFILE_CURVE,
    columns=sweep_fields.PROFILE_CURVE_COLUMNS,
    when=lambda curve: curve.is_profile,
    figures=sweep_illustrations.PROFILE_CURVE,
    plots=(profile_figures.load_curve,),
)
