"""What is shown of repeated passes."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from roughcontact.elastoplastic import plausibility
from roughcontact.elastoplastic.rolling import RollingResult
from roughcontact.formats import export
from roughcontact.plots import rolling as plots
from roughcontact.references import cited
from roughcontact.report import (
    assumptions,
    blocks,
    chapters,
    citations,
    elastoplastic,
    figures,
    phrases,
    python_script,
    rolling_table,
)
from roughcontact.report.blocks import Blocks, Cautions
from roughcontact.report.fields import PROBLEM
from roughcontact.report.kind import Kind, Use
from roughcontact.report.page import Block


def question(rolling: RollingResult) -> str:
    """Return the question that repeated passes answer."""
    name = phrases.source(rolling.result.solution.surface.provenance)
    return f"Does {name} shake down in {rolling_table.counted(rolling)}?"


def _inputs(rolling: RollingResult) -> list[Block]:
    state = elastoplastic.KIND.rows(rolling.result, PROBLEM)
    kept = [row for row in state if row.key not in ("turns", "increments")]
    return elastoplastic.inputs_of(rolling.result, [*KIND.rows(rolling, PROBLEM), *kept])


def _checked(rolling: RollingResult) -> tuple[str, ...]:
    state = plausibility.checked(rolling.result)
    return ("steps, pixel and direction of the passes", *state)


def _method(rolling: RollingResult) -> list[Block]:
    state = elastoplastic.KIND
    return [*elastoplastic.method(rolling.result), *chapters.trust(state, rolling.result, ())]


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
    blocks=shown, question=question, meaning=rolling_table.criterion, inputs=_inputs,
    case=lambda rolling: assumptions.of_volume(rolling.result), method=_method, checked=_checked,
    script=lambda rolling: python_script.repeating_volume(rolling.result),
)  # fmt: skip
