"""What is told of a load curve."""

from __future__ import annotations

from dataclasses import replace

from roughcontact.plots import profiles as draw
from roughcontact.plots.load_curve import load_curve
from roughcontact.report import chapters, citations, contact_fields, figures, problem
from roughcontact.report.fields import tiny
from roughcontact.report.kind import Kind
from roughcontact.report.page import Chapter, PageTable
from roughcontact.studies.load_curve import LOW_LOAD, LoadCurve
from roughcontact.units import percent


def chapter(curve: LoadCurve) -> Chapter:
    """Return the chapter on a load curve."""
    kind = PROFILE_KIND if curve.is_profile else KIND
    result = Chapter("Load curve")
    result.add(
        "text",
        f"The same contact under {len(curve.steps)} "
        f"{'loads' if curve.control == 'load' else 'approaches'}. Every one is solved as if it "
        "were the first: the model keeps no history, so that this is loading, not unloading.",
    )
    if curve.low_loads.any() and not curve.is_profile:
        result.add(
            "text",
            f"At small loads (no more than {percent(LOW_LOAD)} in contact) the area grows as "
            "A = κ W/(E* h′), with h′ the root-mean-square slope. For elastic contacts of many "
            "spots theory has κ = 2.5 (Bush, Gibson and Thomas 1975) and 1.6 (Persson 2001), "
            "computations 1.8 to 2.3 (Hyun et al. 2004).",
        )
    result.add("table", PageTable(chapters.facts(kind, curve)))
    chapters.show(result, kind.figures, curve)
    head, rows = kind.listing(curve)
    result.add("table", PageTable(rows, head))
    return result


# --- What is said first ---


def _unit(curve: LoadCurve) -> str:
    return contact_fields.LOAD if curve.is_profile else "N"


def _problem(curve: LoadCurve) -> str:
    name = curve.source or "an unnamed map"
    control = "loads" if curve.control == "load" else "approaches"
    first, last = (getattr(step, curve.control) for step in (curve.steps[0], curve.steps[-1]))
    unit = _unit(curve) if curve.control == "load" else "m"
    ends = problem.between(first, last, lambda value: problem.size(value, unit))
    return f"{name}, {len(curve.steps)} {control} from {ends}"


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
    problem=_problem,
    answer=_answer,
    remarks=_remarks,
)
PROFILE_KIND = replace(
    KIND,
    table=contact_fields.PROFILE_CURVE,
    columns=contact_fields.PROFILE_CURVE_COLUMNS,
    when=lambda curve: curve.is_profile,
    figures=figures.PROFILE_CURVE,
    plots=(draw.load_curve,),
)
