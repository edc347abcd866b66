"""What is told of the stress below a contact."""

from __future__ import annotations

from dataclasses import replace
from operator import attrgetter
from typing import Any

from roughcontact.contact.subsurface_stress import StressResult
from roughcontact.plots import subsurface_stress as draw
from roughcontact.report import (
    blocks,
    chapters,
    citations,
    contact,
    contact_fields,
    figures,
    phrases,
)
from roughcontact.report.blocks import Blocks, Cautions
from roughcontact.report.fields import Row, rows_of
from roughcontact.report.kind import Kind
from roughcontact.report.page import Block


def first_yield(onset: StressResult, brief: bool = False) -> list[Row]:
    """Return what is told of the contact at the load of first yield."""
    of_profile = onset.solution.pair.is_profile
    return rows_of(
        contact_fields.PROFILE_FIRST_YIELD if of_profile else contact_fields.FIRST_YIELD,
        onset,
        brief=brief,
    )


def question(stress: StressResult) -> str:
    """Return the question that a stress answers."""
    contact = stress.solution
    name = phrases.source(contact.share.provenance)
    return f"How large is the stress below {name} {phrases.under(contact)}?"


def _details(
    stress: StressResult, scene: Any, onset: StressResult | None = None, **more: Any
) -> list[Block]:
    return [] if onset is None else chapters.quantities(first_yield(onset))


def _method(_: StressResult) -> list[Block]:
    return [Block("text", "Elastic stress below the contact pressure. Tension is positive.")]


def shown(stress: StressResult, onset: StressResult | None = None) -> Blocks:
    """Return what the console shows: the contact, then the largest stresses and where it yields."""
    rows = _kind(stress).rows(stress, brief=True)
    if onset is not None:
        rows += first_yield(onset, brief=True)
    # Those of the contact stand above, with its numbers.
    own = tuple(c for c in stress.cautions if c not in stress.solution.cautions)
    return [*contact.shown(stress.solution), *blocks.table(blocks.cells(rows)), Cautions(own)]


KIND = Kind(
    StressResult, contact_fields.STRESS, figures=figures.STRESS,
    plots=(draw.stress_section, draw.stress_depth, draw.stress_map),
    contact=attrgetter("solution"), works=citations.of_stress, blocks=shown,
    question=question, details=_details, method=_method,
)  # fmt: skip
PROFILE_KIND = replace(
    KIND, table=contact_fields.PROFILE_STRESS, when=lambda stress: stress.solution.pair.is_profile,
    # A profile is not seen from above.
    figures=figures.STRESS[:2], plots=KIND.plots[:2],
)  # fmt: skip


def _kind(stress: StressResult) -> Kind:
    return PROFILE_KIND if stress.solution.pair.is_profile else KIND
