"""A report on repeated passes: that on their last state, with the passes first."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from roughcontact.elastoplastic.rolling import RollingResult
from roughcontact.formats import export
from roughcontact.plots import rolling as plots
from roughcontact.references import cited
from roughcontact.report import blocks, chapters, citations, elastoplastic, figures, rolling_table
from roughcontact.report.blocks import Blocks, Cautions
from roughcontact.report.fields import PROBLEM
from roughcontact.report.kind import Kind, Use
from roughcontact.report.page import PLAIN, Chapter, Edition, PageTable, sentence
from roughcontact.units import engineering


def render(rolling: RollingResult, edition: Edition = PLAIN) -> str:
    """Return a report as the text of an HTML file."""
    lead = elastoplastic.Lead(
        _title(rolling),
        chapters.headlines(KIND, rolling, rolling_table.HEADLINES),
        _of(rolling),
        citations.of(KIND, rolling),
        rolling.cautions,
        ("steps, pixel and direction of the passes",),
    )
    return elastoplastic.render(rolling.result, edition, lead=lead)


def _title(rolling: RollingResult) -> str:
    name = rolling.result.solution.surface.provenance.source or "an unnamed surface"
    load = engineering(rolling.result.solution.load, "N")
    return f"{rolling_table.counted(rolling)} over {name} under {load}"


def _of(rolling: RollingResult) -> Chapter:
    chapter = Chapter("Passes")
    chapter.add(
        "text",
        f"{sentence(f'the passes come to: {rolling.outcome_text}')} "
        f"{rolling_table.criterion(rolling)}",
    )
    chapter.add("table", chapters.quantities(KIND.rows(rolling)))
    head, rows = KIND.listing(rolling)
    chapter.add("table", PageTable(rows, head))
    chapters.show(chapter, rolling_table.FIGURES, rolling)
    return chapter


def _works(rolling: RollingResult) -> Iterator[Use]:
    yield from citations.of_volume(rolling.result)
    yield cited("passes and shakedown", "Johnson1985", "Boucly2007")


def shown(rolling: RollingResult) -> Blocks:
    """Return what the console shows: problem, passes, answer; how exactly the end is solved."""
    state = rolling.result
    requested = blocks.cells(KIND.rows(rolling, PROBLEM, brief=True))
    return [
        *blocks.table(blocks.problem(elastoplastic.KIND, state, state.solution), requested),
        *blocks.steps(KIND, rolling),
        *blocks.table(blocks.trust(elastoplastic.KIND, state)),
        Cautions(rolling.cautions),
    ]


def _save(rolling: RollingResult, path: str | os.PathLike[str]) -> None:
    of_passes = Path(path).suffix.lower() in (".csv", ".json")
    (KIND.write if of_passes else export.save_rolling)(rolling, path)


KIND = Kind(
    RollingResult, rolling_table.ROLLING, rolling_table.PASSES, figures=figures.ROLLING,
    plots=(plots.passes, plots.depths, plots.heights), works=_works, save=_save,
    report=render, blocks=shown,
)  # fmt: skip
