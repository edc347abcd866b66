"""What is told of a load curve."""

from __future__ import annotations

from dataclasses import replace

from roughcontact.plots import profiles as draw
from roughcontact.plots.load_curve import load_curve
from roughcontact.report import chapters, citations, contact_fields, figures
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


KIND = Kind(
    LoadCurve,
    contact_fields.CURVE,
    contact_fields.CURVE_COLUMNS,
    listed=True,
    figures=figures.CURVE,
    plots=(load_curve,),
    works=citations.of_curve,
)
PROFILE_KIND = replace(
    KIND,
    table=contact_fields.PROFILE_CURVE,
    columns=contact_fields.PROFILE_CURVE_COLUMNS,
    when=lambda curve: curve.is_profile,
    figures=figures.PROFILE_CURVE,
    plots=(draw.load_curve,),
)
