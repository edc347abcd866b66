"""What is told of the stress below a contact."""

from __future__ import annotations

from dataclasses import replace
from operator import attrgetter

from roughcontact.contact.subsurface_stress import StressResult
from roughcontact.plots import subsurface_stress as draw
from roughcontact.report import blocks, citations, contact, contact_fields, figures
from roughcontact.report.blocks import Blocks, Cautions
from roughcontact.report.fields import Row, rows_of
from roughcontact.report.kind import Kind
from roughcontact.report.page import PLAIN, Edition, ExtraChapter


def first_yield(onset: StressResult, brief: bool = False) -> list[Row]:
    """Return what is told of the contact at the load of first yield."""
    of_profile = onset.solution.pair.is_profile
    return rows_of(
        contact_fields.PROFILE_FIRST_YIELD if of_profile else contact_fields.FIRST_YIELD,
        onset,
        brief=brief,
    )


def addition(stress: StressResult, onset: StressResult | None = None) -> ExtraChapter:
    """Return the chapter on the stress below the surface, and on the load of first yield."""
    kind = _kind(stress)
    quantities = kind.rows(stress)
    if onset is not None:
        quantities += first_yield(onset)
    rows = (("quantity", "value"), *((row.title, row.text) for row in quantities))
    own = stress.own_cautions
    text = (
        "Elastic stress under the pressure found. Tension is positive.",
        *(c.text for c in own),
    )
    drawn = figures.drawn(kind.figures, stress)
    works = citations.added(kind, stress)
    return ExtraChapter(
        "Stress below the surface", text, rows, drawn, cautions=own, references=works
    )


def render(
    stress: StressResult, edition: Edition = PLAIN, *, onset: StressResult | None = None
) -> str:
    """Return the report on the contact, with a chapter on the stress below it."""
    return contact.compared(stress.solution, edition, [addition(stress, onset)])


def shown(stress: StressResult, onset: StressResult | None = None) -> Blocks:
    """Return what the console shows: the contact, then the largest stresses and where it yields."""
    rows = _kind(stress).rows(stress, brief=True)
    if onset is not None:
        rows += first_yield(onset, brief=True)
    # Those of the contact are printed with its numbers.
    return [
        *contact.shown(stress.solution),
        *blocks.table(blocks.cells(rows)),
        Cautions(stress.own_cautions),
    ]


KIND = Kind(
    StressResult, contact_fields.STRESS, figures=figures.STRESS,
    plots=(draw.stress_section, draw.stress_depth, draw.stress_map),
    contact=attrgetter("solution"), works=citations.of_stress, report=render,
    blocks=shown,
)  # fmt: skip
PROFILE_KIND = replace(
    KIND, table=contact_fields.PROFILE_STRESS, when=lambda stress: stress.solution.pair.is_profile,
    # A profile is not seen from above.
    figures=figures.STRESS[:2], plots=KIND.plots[:2],
)  # fmt: skip


def _kind(stress: StressResult) -> Kind:
    return PROFILE_KIND if stress.solution.pair.is_profile else KIND
