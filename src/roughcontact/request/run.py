"""Execution of a request: read, prepare, solve, write."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from roughcontact.errors import RoughcontactError
from roughcontact.halfspace.fft import default_workers
from roughcontact.request import contacts, outputs
from roughcontact.request.options import DEVICE, HEAD, REPORT
from roughcontact.request.outcome import (
    OnPreview,
    OnProgress,
    Outcome,
    Solve,
    TaskContext,
    ignore,
    solve_uncalibrated,
)
from roughcontact.request.outputs import Say
from roughcontact.request.preparation import preparation_key, surfaces
from roughcontact.request.request import Request
from roughcontact.solvers.progress import each_part

if TYPE_CHECKING:
    from roughcontact.report.page import Edition
    from roughcontact.surface.surface import Surface


def run_request(
    request: Request,
    say: Say,
    look: OnProgress | None = None,
    known: Mapping[str, Any] | None = None,
    *,
    read: Callable[[Request, Say], Sequence[Surface]] | None = None,
    solve: Solve = solve_uncalibrated,
) -> Outcome:
    """Run a request: read and prepare its maps, solve, and write its files."""
    request.check_places()
    reads = partial(read or prepare_maps, request, say)
    work = TaskContext(request, reads, say, look or ignore, solve, known or {})
    from roughcontact.halfspace.gpu import use_device

    with use_device(request.get(DEVICE)):
        outcome: Outcome = request.task.run(request, work)
    if not outcome.converged:
        return outcome
    # The result is shown even if the files cannot be written.
    try:
        written = tuple(outputs.write_files(files(outcome, work), say))
    except RoughcontactError as error:
        return replace(outcome, failure=error)
    return replace(outcome, written=written)


@contextmanager
def shared_runner() -> Iterator[Callable[..., Outcome]]:
    """Yield a function like `run_request` that caches data shared by several requests."""
    with contacts.cached_solver() as solve:
        known: dict[str, Sequence[Surface]] = {}

        def read_maps(request: Request, say: Say) -> Sequence[Surface]:
            words = preparation_key(request)
            if words in known:
                request.require_memory(known[words][0].shape)
            else:
                known[words] = prepare_maps(request, say)
            return known[words]

        yield partial(run_request, read=read_maps, solve=solve)


def prepare_maps(request: Request, say: Say) -> list[Surface]:
    """Return the maps of a request: body and counter-body, or several maps of one surface."""
    if not request.files:
        return surfaces(request, say)
    *others, last = (replace(request, file=path, files=()) for path in request.files)
    # The maps of the counter-body are read once, after those of the surface.
    faces = {option.name for option in contacts.FACES}
    values = {name: value for name, value in request.values.items() if name not in faces}
    single = [*(replace(item, values=values) for item in others), last]
    return [surface for item in single for surface in surfaces(item, say)]


def solve_request(
    request: Request,
    maps: Sequence[Surface],
    say: Say,
    look: OnProgress = ignore,
    show: OnPreview = ignore,
) -> Outcome:
    """Run a request on prepared maps, without writing files."""
    return request.task.run(request, TaskContext(request, lambda: maps, say, look, show=show))


def files(outcome: Outcome, work: TaskContext) -> Iterator[outputs.Writing]:
    """Yield the requested files with their writers."""
    from roughcontact.report.presentation import presentation_of

    request, result = outcome.request, outcome.result
    for path in request.outputs:
        yield path, result.save
    for option, save in request.task.writes:
        if request[option] is not None:
            yield request[option], partial(save, outcome)
    report = request.get(REPORT)
    if report is not None:
        edition = make_edition(request, each_part(work.look, f"writing {report}, figures"))
        shown = presentation_of(result, **outcome.extra_results)
        yield report, partial(shown.report, edition=edition)
    requested = list(request.figures())
    drawings = presentation_of(result).drawings() if requested else {}
    for _, name, path in requested:
        # A profile has fewer figures than a map.
        if not name or name in drawings:
            yield path, outputs.figure_saver(drawings[name or next(iter(drawings))])


def make_edition(request: Request, tell: Callable[[int, int], None] | None) -> Edition:
    """Return the edition of the reports of a request."""
    from roughcontact.report.page import Edition

    return Edition(
        request.command,
        spell=request.task.spell_argument,
        processes=default_workers(),
        tell=tell,
        head=[(option.name.capitalize(), text) for option in HEAD if (text := request.get(option))],
    )
