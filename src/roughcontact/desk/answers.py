"""What is asked of a contact beside its solution, worked out apart from the page."""

from __future__ import annotations

import tempfile
import zipfile
from collections.abc import Callable
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
from roughcontact.request.options import (
    CONDUCTANCE,
    FIND,
    HISTORY,
    LAW,
    SOLVE,
    STRESS,
    SWEEP,
    VOLUME,
)
from roughcontact.request.request import Request, from_text
from roughcontact.request.run import Outcome, run, together
from roughcontact.request.tasks import TASKS
from roughcontact.solvers.progress import Progress

Cells = tuple[str, ...]
Tell = Callable[[Progress | str], None]


@dataclass(frozen=True)
class Question:
    """Something to ask of a contact.

    Parameters
    ----------
    name : str
        What it is called.
    about : str
        What it answers, in a sentence.
    task : str
        The task that answers it.
    options : tuple of str
        What can be told of it, by the names of options.
    fixed : tuple of (str, str or bool)
        Options that make the task this question.
    first : tuple of (str, str or bool)
        What is proposed for some of the options.
    """

    name: str
    about: str
    task: str
    options: tuple[str, ...] = ()
    fixed: tuple[tuple[str, str | bool], ...] = ()
    first: tuple[tuple[str, str | bool], ...] = ()


CURVE = Question(
    "Load curve",
    "Contact area, gap, stiffness and spots from a small load to a large one.",
    SWEEP,
    ("from", "to", "steps", "spacing"),
    first=(("from", "1 MPa"), ("to", "100 MPa")),
)
BELOW = Question(
    "Stress below the surface",
    "The elastic stress under this contact, and where it yields first.",
    STRESS,
    ("which", "friction", "direction", "depths", "onset"),
)
PATH = Question(
    "Load history",
    "Loading and unloading, once or again and again: what stays indented.",
    HISTORY,
    ("path", "passes", "shift"),
    first=(("path", "10 MPa, 0 N, 10 MPa"),),
)
LOADS = Question(
    "Loads that give …",
    "The load at which the contact has an area, a gap or an approach, or first yields.",
    FIND,
    ("contact", "saturated", "approach", "mean-gap", "first-yield"),
    first=(("contact", "5 %"),),
)
GRID = Question(
    "What hangs on the grid",
    "The same contact on coarser and finer grids, with filters and other ceilings.",
    SOLVE,
    fixed=(("study", True),),
)
RECOMMENDED = Question(
    "Recommended ceiling",
    "The ceiling that gives the contact area of plasticity in the volume.",
    SOLVE,
    fixed=(("ceiling", "recommended"),),
)
YIELDING = Question(
    "Plasticity of the volume",
    "Plastic strain in the body itself, instead of a ceiling: seconds to minutes.",
    SOLVE,
    ("increments", "unload", "hardening"),
    fixed=(("model", VOLUME),),
)
QUESTIONS = (CURVE, BELOW, PATH, LOADS, GRID, RECOMMENDED, YIELDING)

CONDUCTS = Question(
    "What it conducts",
    "Electrical and thermal resistance of the whole contact.",
    CONDUCTANCE,
    (
        "resistivity", "conductivity", "counter-resistivity", "counter-conductivity", "film",
        "thermal-film",
    ),
)  # fmt: skip
OBEYS = Question(
    "Which law it obeys",
    "Separation, contact and stiffness over the pressure, with tables for other programs.",
    LAW,
    ("quarters",),
)
JOINTS = (
    OBEYS, CONDUCTS,
    *(Question(q.name, q.about, task.name, q.options, first=q.first)
      for task in TASKS if (q := task.question) is not None),
)  # fmt: skip
"""What is asked of a joint; all that is asked at once shares its contacts."""


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
        return self.outcome.found if self.outcome.study is None else self.outcome.study


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
    found = outcome.found if outcome.study is None else outcome.study
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
        if outcome.result is None or not outcome.converged:
            raise ConvergenceError(f"{name}: {outcome.shortfall}", outcome.result)
        found.append(outcome.result)
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
        outcome = run(from_text(request.task, request.file, given), tell, tell)
        if not outcome.written:
            return outcome
        with files.replacing(packed) as stream, zipfile.ZipFile(stream, "w") as archive:
            for path in outcome.written:
                archive.write(path, path.name)
    return replace(outcome, written=(packed,))
