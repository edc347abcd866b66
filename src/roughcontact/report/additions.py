"""Chapters of a report that its result does not hold by itself."""

from __future__ import annotations

from typing import Any

from roughcontact.contact.found import FoundLoads
from roughcontact.contact.stress import StressResult
from roughcontact.report import figures, results, sources
from roughcontact.report.page import Addition, sentence
from roughcontact.units import engineering


def of_stress(stress: StressResult, onset: StressResult | None = None) -> Addition:
    """Return the chapter on the stress below the surface, and on the load of first yield."""
    told = results.rows(stress)
    if onset is not None:
        told += results.first_yield(onset)
    rows = (("quantity", "value"), *((row.title, row.text) for row in told))
    own = tuple(c for c in stress.cautions if c not in stress.solution.cautions)
    text = (
        "Elastic stress under the pressure found. Tension is positive.",
        *(sentence(c.text) for c in own),
    )
    drawn = figures.drawn(figures.of_stress(stress), stress)
    works = sources.added(stress)
    return Addition("Stress below the surface", text, rows, drawn, cautions=own, references=works)


def of_loads(loads: FoundLoads) -> Addition:
    """Return the chapter on the loads that were asked for; the report is on the largest of them."""
    head, rows = results.listing(loads)
    told = (results.row(loads, key) for key in ("solves", "worst_certificate"))
    text = (
        "Each load is one of its bracket, two neighboring loads that were solved: under the "
        "smaller the value is not reached, under the larger it is.",
        *(sentence(f"{row.name}: {row.text}") for row in told),
        f"The report is on the largest of these loads, {engineering(loads.largest.load, 'N')}.",
    )
    return Addition("Loads that were asked for", text, (head, *rows))


def of_joint(found: Any) -> Addition:
    """Return the chapter on what a joint does; the report is on the largest load."""
    head, rows = results.listing(found)
    told = results.rows(found)
    # The others stand with the contact.
    known = {caution.kind for caution in found.largest.cautions}
    own = tuple(caution for caution in found.cautions if caution.kind not in known)
    text = (
        *(sentence(f"{row.title}: {row.text}") for row in told),
        *results.sentences(found),
        *(sentence(caution.text) for caution in own),
        f"The report is on the largest of the loads, {engineering(found.largest.load, 'N')}.",
    )
    drawn = figures.drawn(figures.of_joint(found), found)
    return Addition(
        results.title(found), text, (head, *rows), drawn, cautions=own,
        references=sources.added(found),
    )  # fmt: skip
