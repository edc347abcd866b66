"""Analyses of a contact, run in a worker process."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import Any

from roughcontact.analyses.solve import fields as contact_fields
from roughcontact.analyses.solve.task import STUDY, TASK as SOLVE
from roughcontact.analyses.sweep.figures import load_curve
from roughcontact.analyses.sweep.model import LoadCurve
from roughcontact.analyses.tasks import SHARED_TASKS, TASKS
from roughcontact.cautions import Caution
from roughcontact.contact.result import ContactResult
from roughcontact.drawing.export import png
from roughcontact.drawing.maps import comparison
from roughcontact.errors import ConvergenceError
from roughcontact.report import kind, kinds
from roughcontact.request.outcome import Outcome
from roughcontact.request.request import Request
from roughcontact.request.run import run_request
from roughcontact.request.task import Analysis, Task
from roughcontact.solvers.progress import Progress
from roughcontact.units import format_percent

Cells = tuple[str, ...]
Tell = Callable[[Progress | str], None]


def _list_analyses(tasks: Iterable[Task]) -> tuple[tuple[Task, Analysis], ...]:
    return tuple((task, question) for task in tasks for question in task.questions)


JOINTS = _list_analyses(SHARED_TASKS.values())
"""Analyses of a joint, over a range of nominal pressures."""
# The analyses of the solve command come last.
ANALYSES = (
    *(item for item in _list_analyses(TASKS) if item not in JOINTS and item[0] is not SOLVE),
    *_list_analyses([SOLVE]),
)
"""Analyses of a contact, and the task of each."""


@dataclass(frozen=True)
class AnalysisOutcome:
    """Outcome of an analysis."""

    outcome: Outcome  # The result itself
    facts: tuple[Cells, ...]  # Labels, values and meanings
    heads: Cells  # Column heads of the step table, if there is one
    steps: tuple[Cells, ...]  # Rows of the step table, if there is one
    cautions: tuple[Caution, ...]  # Cautions
    figures: tuple[bytes, ...]  # Figures of the report (PNG)
    sentences: tuple[str, ...] = ()  # Meaning of the quantities
    lead: str = ""  # Main result in a sentence

    @property
    def result(self) -> Any:
        """Result of the analysis."""
        return self.outcome.extras.get(STUDY.name, self.outcome.result)


def run_analysis(tell: Tell, request: Request, over_pressure: bool = False) -> AnalysisOutcome:
    """Run a request and draw its figures; a job for `workers.WorkerPool.submit`."""
    outcome = run_request(request, tell, tell)
    if outcome.failure is not None:
        raise outcome.failure
    result = outcome.extras.get(STUDY.name, outcome.result)
    rows = [*kinds.rows(result), *kinds.rows(result, kind.TRUST)]
    heads, steps = kinds.listing(result)
    tell("drawing")
    drawings = kinds.drawings(result) if outcome.converged else {}
    if drawings and isinstance(result, LoadCurve):
        drawings = {"": partial(load_curve, result, over_pressure)}
    return AnalysisOutcome(
        outcome,
        tuple((row.title, row.text, row.meaning) for row in rows),
        heads,
        tuple(steps),
        tuple(result.cautions),
        tuple(png(draw()) for draw in drawings.values()),
        kinds.sentences(result),
        kinds.presentation_of(result).answer(),
    )


@dataclass(frozen=True)
class ContactComparison:
    """Comparison of two contacts."""

    rows: tuple[Cells, ...]  # Labels, both values, differences, also in percent
    cautions: tuple[tuple[Caution, ...], tuple[Caution, ...]]  # Cautions of each
    figure: bytes  # Pressure and contact of both (PNG)


def compare_contacts(
    tell: Tell, first: Request, second: Request, names: tuple[str, str]
) -> ContactComparison:
    """Solve two contacts and compare them; a job for `workers.WorkerPool.submit`."""
    result = []
    for name, request in zip(names, (first, second), strict=True):
        tell(f"solving {name}")
        outcome = run_request(request, tell, tell)
        if outcome.contact is None or not outcome.converged:
            raise ConvergenceError(f"{name}: {outcome.shortfall}", outcome.contact)
        result.append(outcome.contact)
    item, other = result
    text = [
        (
            row.title,
            *texts,
            *(
                _quantity_change(kind.quantity_of(contact_fields.CONTACT, row.key), item, other)
                if part == kind.ANSWER
                else ("", "")
            ),
        )
        for part in (kind.PROBLEM, kind.ANSWER, kind.TRUST)
        for row, texts in kind.side_by_side(contact_fields.CONTACT, result, part)
    ]
    tell("drawing")
    figure = png(comparison(result, names))
    return ContactComparison(tuple(text), (item.cautions, other.cautions), figure)


def _quantity_change(
    quantity: kind.Quantity, first: ContactResult, second: ContactResult
) -> tuple[str, str]:
    """Return the first value minus the second, as text and in percent of the second."""
    if not (quantity.is_shown(first) and quantity.is_shown(second)):
        return "", ""
    values = [quantity.value(result) for result in (first, second)]
    if not all(isinstance(value, (int, float)) and math.isfinite(value) for value in values):
        return "", ""
    change = values[0] - values[1]
    if not change:
        return "", ""
    sign = "−" if change < 0 else "+"
    share = f"{sign}{format_percent(abs(change / values[1]))}" if values[1] else ""
    size = abs(change)
    text = (
        quantity.format_value(size)
        if quantity.unit == "1"
        else kind.format_value(size, quantity.unit, quantity.digits)
    )
    return f"{sign}{text}", share
