"""A report on repeated passes: that on their last state, with the passes first."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from roughcontact.formats import export
from roughcontact.plots import rolling as plots
from roughcontact.references import cited
from roughcontact.report import blocks, chapters, figures, rolled, sources, volume
from roughcontact.report.blocks import Blocks, Cautions
from roughcontact.report.kind import Kind, Use
from roughcontact.report.page import PLAIN, Chapter, Edition, Table, sentence
from roughcontact.report.quantities import PROBLEM
from roughcontact.units import engineering
from roughcontact.volume.rolling import Rolling


def render(rolling: Rolling, edition: Edition = PLAIN) -> str:
    """Return a report as the text of an HTML file.

    Parameters
    ----------
    rolling : Rolling
        What the report is on.
    edition : Edition
        Command, date, and how it is drawn and worded.

    Returns
    -------
    str
        HTML with its figures inside.
    """
    lead = volume.Lead(
        _title(rolling),
        chapters.headlines(KIND, rolling, rolled.HEADLINES),
        _of(rolling),
        sources.of(KIND, rolling),
        rolling.cautions,
        ("steps, pixel and direction of the passes",),
    )
    return volume.render(rolling.result, edition, lead=lead)


def _title(rolling: Rolling) -> str:
    name = rolling.result.solution.surface.provenance.source or "an unnamed surface"
    load = engineering(rolling.result.solution.load, "N")
    return f"{rolled.counted(rolling)} over {name} under {load}"


def _of(rolling: Rolling) -> Chapter:
    chapter = Chapter("Passes")
    chapter.add(
        "text", f"{sentence(f'the passes come to: {rolling.answer}')} {rolled.criterion(rolling)}"
    )
    chapter.add("table", chapters.quantities(KIND.rows(rolling)))
    head, rows = KIND.listing(rolling)
    chapter.add("table", Table(rows, head))
    chapters.show(chapter, rolled.FIGURES, rolling)
    return chapter


def _works(rolling: Rolling) -> Iterator[Use]:
    yield from sources.of_volume(rolling.result)
    yield cited("passes and shakedown", "Johnson1985", "Boucly2007")


def shown(rolling: Rolling) -> Blocks:
    """Return what the console shows: problem, passes, answer; how exactly the end is solved."""
    state = rolling.result
    asked = blocks.cells(KIND.rows(rolling, PROBLEM, brief=True))
    return [
        *blocks.table(blocks.problem(volume.KIND, state, state.solution), asked),
        *blocks.steps(KIND, rolling),
        *blocks.table(blocks.trust(volume.KIND, state)),
        Cautions(rolling.cautions),
    ]


def _save(rolling: Rolling, path: str | os.PathLike[str]) -> None:
    of_passes = Path(path).suffix.lower() in (".csv", ".json")
    (KIND.write if of_passes else export.save_rolling)(rolling, path)


KIND = Kind(
    Rolling, rolled.ROLLING, rolled.PASSES, figures=figures.ROLLING,
    plots=(plots.passes, plots.depths, plots.heights), works=_works, save=_save,
    report=render, blocks=shown,
)  # fmt: skip
