"""What is shown of a load curve."""

from __future__ import annotations

from dataclasses import replace

from roughcontact.plots import profiles as draw
from roughcontact.plots.load_curve import load_curve
from roughcontact.report import citations, contact_fields, figures, phrases, problem
from roughcontact.report.fields import tiny
from roughcontact.report.kind import Kind
from roughcontact.report.page import Block
from roughcontact.studies.load_curve import LOW_LOAD, LoadCurve
from roughcontact.units import engineering, percent


def question(curve: LoadCurve) -> str:
    """Return the question that a load curve answers."""
    unit = "m" if curve.control == "approach" else "N/m" if curve.is_profile else "N"
    ends = [engineering(getattr(step, curve.control), unit) for step in curve.steps]
    name = curve.source or "the surface"
    return f"How does the contact of {name} grow from {phrases.span(ends)}?"


def _method(curve: LoadCurve) -> list[Block]:
    text = ["Each load is solved as a first loading; the model keeps no history."]
    if curve.low_loads.any() and not curve.is_profile:
        text.append(
            f"At small loads (up to {percent(LOW_LOAD)} in contact) the area is A = κ W/(E* h′). "
            "Theory gives κ = 2.5 (Bush, Gibson and Thomas 1975) and 1.6 (Persson 2001), "
            "computations 1.8 to 2.3 (Hyun et al. 2004)."
        )
    return [Block("text", " ".join(text))]


# --- What is said first ---


def _unit(curve: LoadCurve) -> str:
    return contact_fields.LOAD if curve.is_profile else "N"


def _problem(curve: LoadCurve) -> str:
    name = curve.source or "an unnamed map"
    control = "loads" if curve.control == "load" else "approaches"
    first, last = (getattr(step, curve.control) for step in (curve.steps[0], curve.steps[-1]))
    unit = _unit(curve) if curve.control == "load" else "m"
    ends = problem.between(first, last, lambda value: problem.size(value, unit))
    text = f"{name}, {len(curve.steps)} {control} from {ends}"
    if curve.is_profile:
        return text
    first, last = (step.load / curve.nominal_area for step in (curve.steps[0], curve.steps[-1]))
    ends = problem.between(first, last, lambda value: problem.size(value, "Pa"))
    return f"{text} ({ends} nominal)"


def _answer(curve: LoadCurve) -> str:
    """Return how the contact grows from the first load to the last."""
    first, last = (curve.steps[n].contact_area / curve.nominal_area for n in (0, -1))
    what = "profile" if curve.is_profile else "face"
    ends = problem.between(first, last, problem.share)
    return f"The contact grows from {ends} of the {what}."


def _remarks(curve: LoadCurve) -> tuple[str, ...]:
    """Return how exactly the steps are solved."""
    most = max(step.certificate for step in curve.steps)
    return (f"Solved: {len(curve.steps)} contacts, certificate {tiny(most)} at most",)


KIND = Kind(
    LoadCurve,
    contact_fields.CURVE,
    contact_fields.CURVE_COLUMNS,
    listed=True,
    figures=figures.CURVE,
    plots=(load_curve,),
    works=citations.of_curve,
    question=question,
    problem=_problem,
    answer=_answer,
    remarks=_remarks,
    method=_method,
    largest=lambda curve: curve.largest,
)
PROFILE_KIND = replace(
    KIND,
    table=contact_fields.PROFILE_CURVE,
    columns=contact_fields.PROFILE_CURVE_COLUMNS,
    when=lambda curve: curve.is_profile,
    figures=figures.PROFILE_CURVE,
    plots=(draw.load_curve,),
)
