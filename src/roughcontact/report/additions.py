"""Chapters of a report that its result does not hold by itself."""

from __future__ import annotations

from typing import Any

from roughcontact.report import contact, figures, sources
from roughcontact.report.kind import Kind
from roughcontact.report.page import Addition, Edition, sentence
from roughcontact.units import engineering


def of_joint(kind: Kind, found: Any) -> Addition:
    """Return the chapter on what a joint does; the report is on the largest load."""
    head, rows = kind.listing(found)
    told = kind.rows(found)
    # The others stand with the contact.
    known = {caution.kind for caution in found.largest.cautions}
    own = tuple(caution for caution in found.cautions if caution.kind not in known)
    text = (
        *(sentence(f"{row.title}: {row.text}") for row in told),
        *kind.sentences(found),
        *(sentence(caution.text) for caution in own),
        f"The report is on the largest of the loads, {engineering(found.largest.load, 'N')}.",
    )
    drawn = figures.drawn(kind.figures, found)
    return Addition(
        kind.title, text, (head, *rows), drawn, cautions=own,
        references=sources.added(kind, found),
    )  # fmt: skip


def report(kind: Kind, found: Any, edition: Edition) -> str:
    """Return the report on a joint: that on its contact, with a chapter on it."""
    return contact.compared(found.largest, edition, [of_joint(kind, found)])
