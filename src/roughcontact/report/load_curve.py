"""What is shown of a load curve."""

from __future__ import annotations

from dataclasses import replace

from roughcontact.plots import profiles as draw
from roughcontact.plots.load_curve import load_curve
from roughcontact.report import citations, contact_fields, figures, phrases
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


KIND = Kind(
    LoadCurve,
    contact_fields.CURVE,
    contact_fields.CURVE_COLUMNS,
    listed=True,
    figures=figures.CURVE,
    plots=(load_curve,),
    works=citations.of_curve,
    question=question,
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
