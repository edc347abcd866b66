"""What is asked of a contact beside its solution, worked out apart from the page."""

from __future__ import annotations

import tempfile
import zipfile
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from roughcontact import files
from roughcontact.contact.cautions import Caution
from roughcontact.contact.curve import LoadCurve
from roughcontact.contact.history import LoadHistory
from roughcontact.contact.stress import StressResult
from roughcontact.contact.study import ResolutionStudy
from roughcontact.errors import ConvergenceError
from roughcontact.plots import maps
from roughcontact.plots.saving import png
from roughcontact.report import results, tables
from roughcontact.report.quantities import ANSWER, PROBLEM, TRUST, beside
from roughcontact.request.outcome import Outcome
from roughcontact.request.request import Request
from roughcontact.request.run import run, together
from roughcontact.request.solve import TASK as SOLVE
from roughcontact.request.studying import STUDY
from roughcontact.request.task import Question, Task
from roughcontact.request.tasks import SHARED_TASKS, TASKS
from roughcontact.solvers.progress import Progress

Cells = tuple[str, ...]
Tell = Callable[[Progress | str], None]


def _questions(tasks: Iterable[Task]) -> tuple[tuple[Task, Question], ...]:
    return tuple((task, question) for task in tasks for question in task.questions)


JOINTS = _questions(SHARED_TASKS.values())
"""What is asked of a joint; all that is asked at once shares its contacts."""
# What is a solve of its own comes last.
QUESTIONS = (
    *(one for one in _questions(TASKS) if one not in JOINTS and one[0] is not SOLVE),
    *_questions([SOLVE]),
)
"""What is asked of a contact beside its solution, and the task that answers it."""

LIVELY = (LoadCurve, LoadHistory, ResolutionStudy, StressResult)
"""Results that the page draws itself."""


@dataclass(frozen=True)
class Answer:
    """What came out.

    Parameters
    ----------
    outcome : Outcome
        The result itself.
    facts : tuple of (str, str, str)
        Names, values and meanings.
    heads, steps : tuples of str
        A table of many steps, if it has one.
    cautions : tuple of Caution
        What has to be known.
    pictures : tuple of (str, bytes)
        Figures with their names, as PNG; none of what the page draws itself.
    sentences : tuple of str
        What the numbers mean.
    """

    outcome: Outcome
    facts: tuple[Cells, ...]
    heads: Cells
    steps: tuple[Cells, ...]
    cautions: tuple[Caution, ...]
    pictures: tuple[tuple[str, bytes], ...]
    sentences: tuple[str, ...] = ()

    @property
    def found(self) -> Any:
        """What was asked for."""
        return self.outcome.extras.get(STUDY.name, self.outcome.found)


def answer(tell: Tell, request: Request) -> Answer:
    """Carry out a request, and draw what came out; a job for `apart.Bench.begin`.

    Parameters
    ----------
    tell : callable
        Called with what is done.
    request : Request
        What is asked.

    Raises
    ------
    RoughcontactError
        If it cannot be done, or its files cannot be written.
    """
    return _answer(tell, run(request, tell, tell))


def answers(tell: Tell, *requests: Request) -> tuple[Answer, ...]:
    """Carry out requests on one contact, which is solved once; a job for `apart.Bench.begin`.

    Parameters
    ----------
    tell : callable
        Called with what is done.
    *requests : Request
        What is asked.

    Raises
    ------
    RoughcontactError
        If one of them cannot be done.
    """
    with together() as carry_out:
        return tuple(_answer(tell, carry_out(request, tell, tell)) for request in requests)


def _answer(tell: Tell, outcome: Outcome) -> Answer:
    if outcome.failure is not None:
        raise outcome.failure
    found = outcome.extras.get(STUDY.name, outcome.found)
    rows = [*results.rows(found), *results.rows(found, TRUST)]
    heads, steps = results.listing(found)
    tell("drawing")
    return Answer(
        outcome,
        tuple((row.title, row.text, row.meaning) for row in rows),
        heads,
        tuple(steps),
        tuple(found.cautions),
        _pictures(found) if outcome.converged and not isinstance(found, LIVELY) else (),
        results.sentences(found),
    )


def _pictures(found: Any) -> tuple[tuple[str, bytes], ...]:
    return tuple((name, png(draw())) for name, draw in results.drawings(found).items())


@dataclass(frozen=True)
class Pair:
    """Two contacts side by side.

    Parameters
    ----------
    rows : tuple of (str, str, str)
        Names of numbers, and those of both.
    cautions : pair of tuple of Caution
        What has to be known of each.
    picture : bytes
        Pressure and contact of both, in the same colours, as PNG.
    """

    rows: tuple[Cells, ...]
    cautions: tuple[tuple[Caution, ...], tuple[Caution, ...]]
    picture: bytes


def compare(tell: Tell, first: Request, second: Request, names: tuple[str, str]) -> Pair:
    """Solve two contacts and set them side by side; a job for `apart.Bench.begin`.

    Parameters
    ----------
    tell : callable
        Called with what is done.
    first, second : Request
        The contacts.
    names : (str, str)
        What they are called.

    Raises
    ------
    RoughcontactError
        If one cannot be solved.
    """
    found = []
    for name, request in zip(names, (first, second), strict=True):
        tell(f"solving {name}")
        outcome = run(request, tell, tell)
        if outcome.contact is None or not outcome.converged:
            raise ConvergenceError(f"{name}: {outcome.shortfall}", outcome.contact)
        found.append(outcome.contact)
    tell("drawing")
    one, other = found
    told = [
        (row.title, *texts)
        for part in (PROBLEM, ANSWER, TRUST)
        for row, texts in beside(tables.CONTACT, found, part)
    ]
    return Pair(tuple(told), (one.cautions, other.cautions), png(maps.comparison(found, names)))


def draw(tell: Tell, request: Request, folder: Path, packed: Path) -> Outcome:
    """Carry out a request and pack its figures; a job for `apart.Bench.begin`.

    Parameters
    ----------
    tell : callable
        Called with what is done.
    request : Request
        A task ``"solve"``.
    folder : Path
        Where nothing is kept: for the figures one by one.
    packed : Path
        The ZIP file for all of them.

    Returns
    -------
    Outcome
        With the ZIP file as what was written.
    """
    with tempfile.TemporaryDirectory(dir=folder) as place:
        given = {**request.given, "figures": place}
        outcome = run(Request.from_text(request.task, request.file, given), tell, tell)
        if not outcome.written:
            return outcome
        with files.replacing(packed) as stream, zipfile.ZipFile(stream, "w") as archive:
            for path in outcome.written:
                archive.write(path, path.name)
    return replace(outcome, written=(packed,))
