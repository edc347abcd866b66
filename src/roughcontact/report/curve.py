"""What is told of a load curve."""

from __future__ import annotations

from dataclasses import replace

from roughcontact.contact.curve import LOW_LOAD, LoadCurve
from roughcontact.plots import curves, traces as draw
from roughcontact.report import chapters, figures, profile, sources, tables, traces
from roughcontact.report.kind import Kind
from roughcontact.report.page import Chapter, Table
from roughcontact.units import percent


def chapter(curve: LoadCurve) -> Chapter:
    """Return the chapter on a load curve."""
    kind = PROFILE_KIND if curve.is_profile else KIND
    found = Chapter("Load curve")
    found.add(
        "text",
        f"The same contact under {len(curve.steps)} "
        f"{'loads' if curve.control == 'load' else 'approaches'}. Every one is solved as if it "
        "were the first: the model keeps no history, so that this is loading, not unloading.",
    )
    if curve.low_loads.any() and not curve.is_profile:
        found.add(
            "text",
            f"At small loads (no more than {percent(LOW_LOAD)} in contact) the area grows as "
            "A = κ W/(E* h′), with h′ the root-mean-square slope. For elastic contacts of many "
            "spots theory has κ = 2.5 (Bush, Gibson and Thomas 1975) and 1.6 (Persson 2001), "
            "computations 1.8 to 2.3 (Hyun et al. 2004).",
        )
    found.add("table", Table(chapters.facts(kind, curve)))
    chapters.show(found, kind.figures, curve)
    head, rows = kind.listing(curve)
    found.add("table", Table(rows, head))
    return found


KIND = Kind(
    LoadCurve, tables.CURVE, tables.CURVE_COLUMNS, listed=True, figures=figures.CURVE,
    plots=(curves.load_curve,), works=sources.of_curve,
)  # fmt: skip
PROFILE_KIND = replace(
    KIND, table=profile.CURVE, columns=profile.CURVE_COLUMNS, when=lambda curve: curve.is_profile,
    figures=traces.CURVE, plots=(draw.load_curve,),
)  # fmt: skip
