"""All kinds of results: one row each."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from roughcontact.errors import InputError
from roughcontact.references import References
from roughcontact.report import (
    blocks,
    citations,
    comparison,
    conductance,
    contact,
    elastoplastic,
    estimate,
    figures,
    interface_law,
    leakage,
    load_curve,
    load_history,
    load_search,
    page,
    rolling,
    subsurface_stress,
    surface,
    uncertainty,
)
from roughcontact.report.blocks import Blocks
from roughcontact.report.fields import ANSWER, Headline, Row
from roughcontact.report.kind import Kind
from roughcontact.report.page import Edition, ExtraChapter, sentence
from roughcontact.units import engineering

if TYPE_CHECKING:
    from matplotlib.figure import Figure


KINDS = (
    surface.PROFILE_KIND,
    surface.KIND,
    contact.PROFILE_KIND,
    contact.SHARED_KIND,
    contact.KIND,
    elastoplastic.KIND,
    rolling.KIND,
    subsurface_stress.PROFILE_KIND,
    subsurface_stress.KIND,
    load_curve.PROFILE_KIND,
    load_curve.KIND,
    load_history.KIND,
    load_search.KIND,
    conductance.KIND,
    interface_law.KIND,
    leakage.KIND,
    comparison.KIND,
    comparison.SAMPLING_KIND,
    uncertainty.KIND,
    estimate.KIND,
)


def of(result: Any) -> Kind:
    """Return the kind of a result; `TypeError` for what is none."""
    for kind in KINDS:
        if isinstance(result, kind.result) and kind.when(result):
            return kind
    raise TypeError(f"there is no kind of results for a {type(result).__name__}")


# --- Chapters of a report that its result does not hold by itself ---


def of_joint(kind: Kind, result: Any) -> ExtraChapter:
    """Return the chapter on what a joint does; the report is on the largest load."""
    head, rows = kind.listing(result)
    quantities = kind.rows(result)
    # The others stand with the contact.
    known = {caution.kind for caution in result.largest.cautions}
    own = tuple(caution for caution in result.cautions if caution.kind not in known)
    text = (
        *(sentence(f"{row.title}: {row.text}") for row in quantities),
        *kind.sentences(result),
        *(caution.text for caution in own),
        f"The report is on the largest of the loads, {engineering(result.largest.load, 'N')}.",
    )
    drawn = figures.drawn(kind.figures, result)
    return ExtraChapter(
        kind.title, text, (head, *rows), drawn, cautions=own,
        references=citations.added(kind, result),
    )  # fmt: skip


def render_with_chapter(kind: Kind, result: Any, edition: Edition) -> str:
    """Return the report on a joint: that on its contact, with a chapter on it."""
    return contact.compared(result.largest, edition, [of_joint(kind, result)])


# --- What is told of any result, by its kind ---


def rows(result: Any, part: str = ANSWER, brief: bool = False) -> list[Row]:
    """Return what is told of a result; see `fields.rows_of`."""
    return of(result).rows(result, part, brief)


def listing(result: Any, brief: bool = False) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Return the head and the rows of the steps of a result; see `fields.listing_of`."""
    return of(result).listing(result, brief)


def sentences(result: Any) -> tuple[str, ...]:
    """Return what a reader of a result has to know before its numbers."""
    return of(result).sentences(result)


def summary(result: Any) -> dict[str, Any]:
    """Return a result by name, in SI units, ready for JSON."""
    return of(result).summary(result)


def references(result: Any) -> References:
    """Return the papers behind a result."""
    return citations.of(of(result), result)


def headline(result: Any, **more: Any) -> Headline:
    """Return what is said first of a result."""
    return blocks.headline(of(result), result, **more)


def shown(result: Any, **more: Any) -> Blocks:
    """Return all that the console shows of a result."""
    kind = of(result)
    show = kind.blocks or partial(blocks.usual, kind)
    return show(result, **more)


def drawings(result: Any) -> dict[str, Callable[[], Figure]]:
    """Return what draws the figures of a result that are written to files, by name."""
    return figures.drawings(of(result), result)


def save(result: Any, path: str | os.PathLike[str]) -> None:
    """Write a map or a result in the format that the suffix of the file names."""
    kind = of(result)
    (kind.save or kind.write)(result, path)


def report(result: Any, path: str | os.PathLike[str], edition: Edition, **more: Any) -> None:
    """Write the report on a result to an HTML file."""
    page.check_path(path)
    kind = of(result)
    render = kind.report or (partial(render_with_chapter, kind) if kind.title else None)
    if render is None:
        raise InputError(f"there is no report on a {type(result).__name__} alone")
    more = {name: item for name, item in more.items() if item}
    text, ranks = render(result, edition, **more), kind.ranks(result)
    if ranks is None:
        page.save(text, path)
    else:
        ranks.agreed(lambda: page.save(text, path) if ranks.first else None)
