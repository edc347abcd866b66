"""Analyses of a contact, run in a worker process."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import roughcontact as rc
from roughcontact import cautions as caution_types, units
from roughcontact.analyses import tasks
from roughcontact.analyses.solve import fields
from roughcontact.desk.session import SOLVE
from roughcontact.desk.workers import Tell
from roughcontact.drawing import export
from roughcontact.report import kind as quantities
from roughcontact.report.presentation import presentation_of
from roughcontact.request import run
from roughcontact.request.outcome import Outcome
from roughcontact.request.request import Request

Cells = tuple[str, ...]


JOINTS = tuple((task, item) for task in tasks.SHARED_TASKS.values() for item in task.questions)
"""Analyses of a joint, over a range of nominal pressures."""
# The analyses of the solve command come last.
ANALYSES = tuple(
    (task, item)
    for task in sorted(tasks.TASKS, key=lambda task: task is SOLVE)
    for item in task.questions
    if not task.shares_contacts
)
"""Analyses of a contact, and the task of each."""


@dataclass(frozen=True)
class AnalysisOutcome:
    """Outcome of an analysis."""

    outcome: Outcome  # The result itself
    facts: tuple[Cells, ...]  # Labels, values and meanings
    heads: Cells  # Column heads of the step table, if there is one
    steps: tuple[Cells, ...]  # Rows of the step table, if there is one
    cautions: tuple[caution_types.Caution, ...]  # Cautions
    figures: tuple[bytes, ...]  # Figures of the report (PNG)
    sentences: tuple[str, ...] = ()  # Meaning of the quantities
    lead: str = ""  # Main result in a sentence

    @property
    def result(self) -> Any:
        """Result of the analysis."""
        return self.outcome.extras.get("study", self.outcome.result)


def run_analysis(tell: Tell, request: Request, over_pressure: bool = False) -> AnalysisOutcome:
    """Run a request and draw its figures; a job for `workers.WorkerPool.submit`."""
    outcome = run.run_request(request, tell, tell)
    if outcome.failure is not None:
        raise outcome.failure
    result = outcome.extras.get("study", outcome.result)
    shown = presentation_of(result)
    rows = [*shown.rows(), *shown.rows(quantities.TRUST)]
    heads, steps = shown.listing()
    tell("drawing")
    drawings = shown.drawings() if outcome.converged else {}
    if drawings and isinstance(result, rc.results.LoadCurve):
        drawings = {"": partial(rc.plots.load_curve, result, over_pressure)}
    return AnalysisOutcome(
        outcome,
        tuple((row.title, row.text, row.meaning) for row in rows),
        heads,
        tuple(steps),
        tuple(result.cautions),
        tuple(export.png(draw()) for draw in drawings.values()),
        tuple(shown.sentences()),
        shown.answer(),
    )


@dataclass(frozen=True)
class ContactComparison:
    """Comparison of two contacts."""

    rows: tuple[Cells, ...]  # Labels, both values, differences in percent
    cautions: tuple[Sequence[caution_types.Caution], ...]  # Cautions of each
    figure: bytes  # Pressure and contact of both (PNG)


def compare_contacts(
    tell: Tell, first: Request, second: Request, names: tuple[str, str]
) -> ContactComparison:
    """Solve two contacts and compare them; a job for `workers.WorkerPool.submit`."""
    result = []
    for name, request in zip(names, (first, second), strict=True):
        tell(f"solving {name}")
        outcome = run.run_request(request, tell, tell)
        if outcome.contact is None or not outcome.converged:
            raise rc.ConvergenceError(f"{name}: {outcome.shortfall}", outcome.contact)
        result.append(outcome.contact)
    item, other = result
    table = fields.CONTACT
    text = [
        (
            row.title,
            *texts,
            _quantity_change(quantities.quantity_of(table, row.key), item, other)
            if part == quantities.ANSWER
            else "",
        )
        for part in (quantities.PROBLEM, quantities.ANSWER, quantities.TRUST)
        for row, texts in quantities.side_by_side(table, result, part)
    ]
    tell("drawing")
    figure = export.png(rc.plots.comparison(result, names))
    return ContactComparison(tuple(text), (item.cautions, other.cautions), figure)


def _quantity_change(
    quantity: quantities.Quantity, first: rc.ContactResult, second: rc.ContactResult
) -> str:
    """Return the first value minus the second, in percent of the second."""
    if not (quantity.is_shown(first) and quantity.is_shown(second)):
        return ""
    values = [quantity.value(result) for result in (first, second)]
    if not all(isinstance(value, (int, float)) and math.isfinite(value) for value in values):
        return ""
    change = values[0] - values[1]
    if not change or not values[1]:
        return ""
    return f"{'−' if change < 0 else '+'}{units.format_percent(abs(change / values[1]))}"
