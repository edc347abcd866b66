"""What is shown of repeated passes."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from roughcontact.elastoplastic import plausibility
from roughcontact.elastoplastic.rolling import RollingResult, Shakedown, to_dataset
from roughcontact.formats import export
from roughcontact.plots import rolling as plots
from roughcontact.references import cited
from roughcontact.report import (
    assumptions,
    chapters,
    citations,
    elastoplastic,
    figures,
    phrases,
    problem,
    python_script,
    rolling_table,
)
from roughcontact.report.fields import PROBLEM, some, tiny
from roughcontact.report.kind import CellTable, Kind, Use
from roughcontact.report.page import Block
from roughcontact.units import counted


def question(rolling: RollingResult) -> str:
    """Return the question that repeated passes answer."""
    name = phrases.source(rolling.result.solution.surface.provenance)
    return f"Does {name} shake down in {rolling_table.counted(rolling)}?"


def _inputs(rolling: RollingResult, drawn: bool) -> list[Block]:
    state = elastoplastic.KIND.rows(rolling.result, PROBLEM)
    kept = [row for row in state if row.key not in ("turns", "increments")]
    specified = [*KIND.rows(rolling, PROBLEM), *kept]
    return elastoplastic.inputs_of(rolling.result, specified, drawn)


def _checked(rolling: RollingResult) -> tuple[str, ...]:
    state = plausibility.checked(rolling.result)
    return ("steps, pixel and direction of the passes", *state)


def _method(rolling: RollingResult) -> list[Block]:
    state = elastoplastic.KIND
    return [*elastoplastic.method(rolling.result), *chapters.trust(state, rolling.result, ())]


def _works(rolling: RollingResult) -> Iterator[Use]:
    yield from citations.of_volume(rolling.result)
    yield cited("passes and shakedown", "Johnson1985", "Boucly2007")


# --- What is said first ---


def _problem(rolling: RollingResult) -> str:
    return problem.line(rolling.result.solution)


def _answer(rolling: RollingResult) -> str:
    """Return whether the passes come to an end of plastic strain."""
    count, last = len(rolling.passes), rolling.passes[-1]
    strain = rolling_table.strain(last.strain_added)
    match rolling.shakedown:
        case Shakedown.ELASTIC:
            return "Nothing yields: no pass adds plastic strain."
        case Shakedown.ELASTIC_SHAKEDOWN:
            settled = counted(rolling.settled_after or 0, "pass")
            return f"Shakes down after {settled}: the last one adds {strain} plastic strain."
        case Shakedown.PLASTIC_SHAKEDOWN:
            return f"Plastic shakedown: each pass strains by {strain} and back. Expect fatigue."
        case Shakedown.RATCHETING:
            net = rolling_table.strain(last.strain_net)
            return f"Ratchets: each pass adds {net} of net plastic strain."
        case Shakedown.NOT_SETTLED:
            return f"Not settled after {counted(count, 'pass')}: the last one adds {strain}."
    return "Not resolved: the steps are longer than the half-width of the contact."


def _numbers(rolling: RollingResult) -> CellTable:
    """Return what each pass adds, of many the first and the last ones."""
    rows = [
        (
            str(number), rolling_table.strain(item.strain_added),
            rolling_table.strain(item.strain_net), problem.size(item.max_pressure, "Pa"),
            problem.size(item.in_plane_stress, "Pa"), problem.size(item.Sq, "m"),
        )
        for number, item in enumerate(rolling.passes, 1)
    ]  # fmt: skip
    heads = ("pass", "strain added", "net strain", "peak pressure", "residual stress", "Sq")
    return heads, some(rows)


def _remarks(rolling: RollingResult) -> tuple[str, ...]:
    """Return what counts as no strain, and how exactly the passes are solved."""
    state = rolling.result
    count = counted(len(state.increments), "increment")
    least = rolling_table.strain(rolling.strain_threshold)
    return (
        f"No strain added: below {least} (1 % of the yield strain)",
        f"Solved: residual {tiny(state.residual)} (limit {state.tolerance:.0e}), {count}",
    )


def _save(rolling: RollingResult, path: str | os.PathLike[str]) -> None:
    of_passes = Path(path).suffix.lower() in (".csv", ".json")
    (KIND.write if of_passes else export.save_rolling)(rolling, path)


KIND = Kind(
    RollingResult, rolling_table.ROLLING, rolling_table.PASSES, figures=figures.ROLLING,
    plots=(plots.passes, plots.depths, plots.heights), works=_works, save=_save,
    dataset=lambda rolling: to_dataset(rolling)[0],
    problem=_problem, answer=_answer, numbers=_numbers, remarks=_remarks,
    question=question, meaning=rolling_table.criterion, inputs=_inputs,
    case=lambda rolling: assumptions.of_volume(rolling.result), method=_method, checked=_checked,
    script=lambda rolling: python_script.repeating_volume(rolling.result),
)  # fmt: skip
