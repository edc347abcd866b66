"""A contact whose maps lie on several ranks: its numbers, and a report with reduced maps."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from roughcontact.contact.slab_result import SlabResult
from roughcontact.plots import reduced
from roughcontact.report import blocks, page, sources
from roughcontact.report.blocks import Blocks, Cautions
from roughcontact.report.kind import Kind
from roughcontact.report.page import Chapter, Edition
from roughcontact.report.quantities import (
    ANSWER,
    PROBLEM,
    TRUST,
    Quantity,
    Table,
    quantity_of,
    rows_of,
)
from roughcontact.report.tables import CONTACT
from roughcontact.units import lengths, percent

_SAME = (
    "status", "certificate", "load_error", "tolerance", "load", "approach", "control",
    "given_load", "boundary", "contact_modulus", "contact_area", "contact_fraction",
    "corrected_contact_area", "saturated_fraction", "saturated_share", "max_pressure",
    "mean_pressure", "mean_gap", "regime", "warnings", "cautions", "iterations", "convolutions",
    "seconds", "precision", "version",
)  # fmt: skip
"""Quantities that are told as those of a contact on one machine."""


SLABS: Table = (
    *(quantity_of(CONTACT, key) for key in _SAME),
    replace(quantity_of(CONTACT, "ceiling"), of="ceiling"),
    replace(quantity_of(CONTACT, "nominal_area"), of="nominal_area"),
    replace(
        quantity_of(CONTACT, "nominal_pressure"), of=lambda r: r.load / r.nominal_area
    ),
    replace(quantity_of(CONTACT, "max_residual_indentation"), of="totals.max_indentation"),
    Quantity("shape", "points", of=lambda r: list(r.shape), part=PROBLEM,
             form=lambda v: f"{v[0]} × {v[1]}"),
    Quantity("pixel", unit="m", of=lambda r: list(r.slab.pixel)),
    Quantity("source", of=lambda r: r.slab.provenance.source),
    Quantity("preparation", of=lambda r: list(r.slab.provenance.steps)),
    Quantity("ranks", "ranks", of="slab.ranks.count", part=TRUST),
    Quantity(
        "communication", "communication", unit="s", part=TRUST,
        meaning="of ranks with each other, waiting included, on average",
        text=lambda r: f"{percent(r.communication / r.seconds)} of the time",
    ),
    Quantity("sent", of="sent"),
)  # fmt: skip
"""Of a `SlabResult`."""


def save(
    result: SlabResult,
    maps: Sequence[Any],
    path: str | os.PathLike[str],
    edition: Edition,
) -> None:
    """Write a report on a contact that lies on several ranks; the first of them alone calls it.

    Parameters
    ----------
    result : SlabResult
        The contact.
    maps : sequence of ndarray
        From `roughcontact.contact.slab_result.reduced`.
    path : str or path
        HTML file to write; it appears only once it is complete.
    edition : Edition
        Command, date, and how it is drawn and worded.

    Raises
    ------
    InputError
        If it has no name of a report.
    OSError
        If it cannot be written.
    """
    told = [row for part in (ANSWER, TRUST) for row in rows_of(SLABS, result, part)]
    by_key = {row.key: row for row in told}
    headlines = ("mean_pressure", "contact_area", "saturated_fraction", "mean_gap")
    text = page.render(
        [
            _problem(result),
            _chapter("Contact", result),
            _pictures(result, maps),
            _trust(result, edition.command),
            sources.chapter(sources.of(KIND, result)),
        ],
        title="Contact of a rough surface",
        subtitle=f"{result.slab.provenance.source}, {result.shape[0]} × {result.shape[1]} points, "
        f"solved by {result.slab.ranks.count} ranks",
        edition=edition,
        status=result.status,
        key_numbers=[
            (row.title, row.text, row.meaning)
            for row in (by_key.get(key) for key in headlines)
            if row is not None
        ],
        regime=str(result.regime),
        regime_text="",
        certificate=f"Certificate {by_key['certificate'].text}.",
        cautions=result.cautions,
        checked=("contact at the edge of the map", "pressure beyond the ceiling"),
    )
    page.save(text, path)


def _chapter(title: str, result: SlabResult, part: str = ANSWER) -> Chapter:
    rows = rows_of(SLABS, result, part)
    chapter = Chapter(title)
    chapter.add("table", page.Table([(row.title, row.text, row.meaning) for row in rows]))
    return chapter


def _problem(result: SlabResult) -> Chapter:
    chapter = _chapter("What is pressed", result, PROBLEM)
    chapter.add("text", f"Pixel {lengths(result.slab.pixel)} (y, x).")
    chapter.add("text", "Preparation: " + "; ".join(map(str, result.slab.provenance.steps)) + ".")
    return chapter


def _pictures(result: SlabResult, maps: Sequence[Any]) -> Chapter:
    chapter = Chapter("Maps in blocks of points")
    for name, draw in reduced.figures(result.slab.size, *maps).items():
        chapter.add("figure", page.picture(draw, name, f"{name}."))
    return chapter


def _trust(result: SlabResult, command: str) -> Chapter:
    chapter = _chapter("How exactly it is solved", result, TRUST)
    chapter.add("code", command)
    return chapter


def shown(result: SlabResult) -> Blocks:
    """Return what the console shows: problem, answer and trust, then cautions."""
    bodies = (("body", result.material), ("counter-body", result.counter_material))
    problem = [
        ("map", result.slab.provenance.source),
        *((name, blocks.body(material)) for name, material in bodies),
        *blocks.cells(KIND.rows(result, PROBLEM, brief=True)),
    ]
    answer = blocks.cells(KIND.rows(result, brief=True))
    return [*blocks.table(problem, answer, blocks.trust(KIND, result)), Cautions(result.cautions)]


KIND = Kind(SlabResult, SLABS, works=sources.of_slab, blocks=shown)
