"""What is shown of a load curve and of a load history."""

from __future__ import annotations

from dataclasses import replace
from operator import attrgetter
from typing import Any

from roughcontact.plots import profiles as draw
from roughcontact.plots.load_curve import hysteresis, load_curve
from roughcontact.report import (
    assumptions,
    chapters,
    citations,
    contact_fields,
    figures,
    page,
    phrases,
)
from roughcontact.report.kind import Kind
from roughcontact.report.page import Block
from roughcontact.studies.load_curve import LOW_LOAD, LoadCurve
from roughcontact.studies.load_history import LoadHistory
from roughcontact.units import counted, engineering, percent, tiny


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


def _problem(curve: LoadCurve) -> str:
    name = curve.source or "an unnamed map"
    control = "loads" if curve.control == "load" else "approaches"
    first, last = (getattr(step, curve.control) for step in (curve.steps[0], curve.steps[-1]))
    unit = (contact_fields.LOAD if curve.is_profile else "N") if curve.control == "load" else "m"
    ends = phrases.between(first, last, lambda value: phrases.size(value, unit))
    text = f"{name}, {len(curve.steps)} {control} from {ends}"
    if curve.is_profile:
        return text
    first, last = (step.load / curve.nominal_area for step in (curve.steps[0], curve.steps[-1]))
    ends = phrases.between(first, last, lambda value: phrases.size(value, "Pa"))
    return f"{text} ({ends} nominal)"


def _answer(curve: LoadCurve) -> str:
    """Return how the contact grows from the first load to the last."""
    first, last = (curve.steps[n].contact_area / curve.nominal_area for n in (0, -1))
    what = "profile" if curve.is_profile else "face"
    ends = phrases.between(first, last, phrases.share)
    return f"The contact grows from {ends} of the {what}."


def _remarks(curve: LoadCurve) -> tuple[str, ...]:
    """Return the limits of the intervals, and how exactly the steps are solved."""
    most = max(step.certificate for step in curve.steps)
    limits = curve.intervals[-1].remarks if curve.intervals else ()
    return (*limits, f"Solved: {len(curve.steps)} contacts, certificate {tiny(most)} at most")


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


# --- A load history ---


def history_question(history: LoadHistory) -> str:
    """Return the question that a load history answers."""
    name = phrases.source(history.before.surface.provenance)
    load = engineering(history.under_largest.load, "N")
    return f"What does a load history up to {load} leave on {name}?"


def _details(history: LoadHistory, scene: Any, **more: Any) -> list[Block]:
    body = "body" if history.indented_body == "surface" else "counter-body"
    left = figures.MapScene(history.residual, f" of the {body}", "after the path, without load")
    return [
        Block("small", page.sentence(HISTORY_KIND.row(history, "volume_account").text)),
        *chapters.shown((figures.MAP,), left, figures.FILES),
    ]


def _history_method(history: LoadHistory) -> list[Block]:
    body = "body" if history.indented_body == "surface" else "counter-body"
    return [
        Block(
            "text",
            f"The pressure ceiling acts as perfect plasticity of the surface. The {body} keeps the "
            "indentation; unloading is elastic. Approaches count from first contact before the "
            "path.",
        )
    ]


def _history_problem(history: LoadHistory) -> str:
    largest = history.under_largest
    path = f"{counted(len(history.steps), 'step')}, largest load {phrases.load(largest)}"
    return f"{phrases.bodies(largest)}, {path}{phrases.boundary(largest)}"


def _history_answer(history: LoadHistory) -> str:
    """Return what the path leaves behind, and whether more of it would change it."""
    body = "body" if history.indented_body == "surface" else "counter-body"
    depth = float(history.indentation.max())
    if not depth:
        return f"The {body} keeps no indentation: no point reaches the pressure ceiling."
    settled = "; loading again adds none" if history.is_elastic_now else ""
    return f"The {body} keeps an indentation of {phrases.size(depth, 'm')} at most{settled}."


def _history_remarks(history: LoadHistory) -> tuple[str, ...]:
    """Return the energy that is lost, and how exactly the steps are solved."""
    row = HISTORY_KIND.row(history, "dissipated_energy")
    most = max(step.certificate for step in history.steps)
    return (
        f"Dissipated energy: {row.text}",
        phrases.worst(most, history.last.tolerance, len(history.steps)),
    )


HISTORY_KIND = Kind(
    LoadHistory, contact_fields.HISTORY, contact_fields.HISTORY_COLUMNS, figures=figures.HISTORY,
    plots=(hysteresis,), contact=attrgetter("under_largest"), question=history_question,
    problem=_history_problem, answer=_history_answer, remarks=_history_remarks, details=_details,
    method=_history_method,
    case=lambda history: assumptions.of_contact(history.under_largest, history),
)  # fmt: skip
