"""Carry out a request: read, prepare, solve, write."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from roughcontact import units
from roughcontact.errors import RoughcontactError
from roughcontact.report import figures, sections
from roughcontact.request import outputs
from roughcontact.request.outputs import FIGURES, Say
from roughcontact.request.request import Request

if TYPE_CHECKING:
    from roughcontact.contact.curve import LoadCurve
    from roughcontact.contact.result import ContactResult
    from roughcontact.contact.stress import StressResult
    from roughcontact.contact.study import ResolutionStudy
    from roughcontact.solvers.progress import Progress, Step
    from roughcontact.surface.surface import Surface
    from roughcontact.volume.loop import Look
    from roughcontact.volume.result import ElastoplasticResult


@dataclass(frozen=True)
class Outcome:
    """What a request gave.

    Parameters
    ----------
    result : ContactResult
        The solution, or the best found.
    volume : ElastoplasticResult or None
        What the volume model found, of which ``result`` is the contact.
    study : ResolutionStudy or None
        The same on other grids, if it was asked for.
    notes : tuple of str
        What limits the lateral resolution of the maps.
    written : tuple of Path
        Files that are complete.
    failure : RoughcontactError or None
        Why a file could not be written.
    """

    result: ContactResult
    volume: ElastoplasticResult | None = None
    study: ResolutionStudy | None = None
    notes: tuple[str, ...] = ()
    written: tuple[Path, ...] = ()
    failure: RoughcontactError | None = None

    @property
    def status(self) -> str:
        """``"converged"``, or why the solver stopped."""
        return self.result.status if self.volume is None else self.volume.status


def run(request: Request, say: Say, look: Callable[[Step], None] | None = None) -> Outcome:
    """Read, prepare, solve, and write what was asked for.

    Parameters
    ----------
    job : Request
        What to do.
    say : callable
        Called with a few words before every stage.
    look : callable, optional
        Called with every `Step` of the solver.

    Returns
    -------
    Outcome
        The result, even where its files could not be written. No file is written for one that
        did not converge.

    Raises
    ------
    RoughcontactError
        If the request cannot be done.
    """
    from roughcontact.contact import resolution_study as study
    from roughcontact.contact import solve as contact

    request.check_places()
    maps = request.surfaces(say)
    if request.model == "volume":
        return _run_volume(request, maps, say)
    result = contact.solve(
        maps[0],
        **request.problem(maps),
        load=request.load,
        approach=request.approach,
        moments=request.moments,
        max_iterations=request.max_iterations,
        on_failure="return",
        progress=look,
    )
    if not result.converged:
        return Outcome(result)
    looked_at = None
    if request.study:
        looked_at = study.resolution_study(
            maps[0],
            **request.problem(maps),
            load=result.load,
            progress=lambda text: say(f"study: {text}"),
        )
    notes = request.resolution_notes(maps)
    # The numbers are shown even where the files cannot be written.
    try:
        written = tuple(outputs.write(_tasks(request, result, looked_at, notes), say))
    except RoughcontactError as error:
        return Outcome(result, None, looked_at, notes, failure=error)
    return Outcome(result, None, looked_at, notes, written)


def _run_volume(request: Request, maps: Sequence[Surface], say: Say) -> Outcome:
    from roughcontact.volume import solve as elastoplastic

    assert request.load is not None
    load = request.load
    first, second = request.bodies()
    # Both models have defaults of their own.
    solver = {
        key.replace("-", "_"): getattr(request, key.replace("-", "_"))
        for key in ("tolerance", "max-iterations", "precision")
        if key in request.given
    }

    def look(at: Progress) -> None:
        step: Look = at.step
        state = f"iteration {step.iteration}, residual {step.residual:.1e}"
        say(
            f"{units.percent(step.load / load)} of the load: "
            f"{state if step.iteration else f'kept in {request.folder}'}"
        )

    steps = request.increments or 10
    loads = [*(load * i / steps for i in range(1, steps)), load, *([0.0] * request.unload)]
    try:
        found = elastoplastic.solve_elastoplastic(
            maps[0],
            material=first,
            counter_material=second,
            counter_surface=maps[1] if len(maps) > 1 else None,
            boundary=request.boundary,
            loads=loads,
            on_failure="return",
            folder=request.folder,
            progress=look,
            **solver,
        )
    except KeyboardInterrupt:
        kept = () if request.folder is None else sorted(request.folder.glob("step-*.nc"))
        raise outputs.UnfinishedError(kept) from None
    notes = request.resolution_notes(maps)
    if not found.converged:
        return Outcome(found.contact, found, notes=notes)
    tasks: list[outputs.Task] = [(path, found.save) for path in request.output]
    if request.report is not None:
        chapters, command = sections.sections(None, notes), request.command("solve")
        tasks.append((request.report, lambda path: found.report(path, command, chapters)))
    tasks += _figure_tasks(request, found.contact, found)
    try:
        written = tuple(outputs.write(tasks, say))
    except RoughcontactError as error:
        return Outcome(found.contact, found, notes=notes, failure=error)
    return Outcome(found.contact, found, notes=notes, written=written)


def _tasks(
    request: Request, result: ContactResult, study: ResolutionStudy | None, notes: tuple[str, ...]
) -> list[outputs.Task]:
    tasks: list[outputs.Task] = [(path, result.save) for path in request.output]
    if request.report is not None:
        chapters, command = sections.sections(study, notes), request.command("solve")
        tasks.append((request.report, lambda path: result.report(path, command, chapters)))
    return tasks + _figure_tasks(request, result)


def _figure_tasks(
    request: Request, result: ContactResult, volume: ElastoplasticResult | None = None
) -> list[outputs.Task]:
    files = outputs.figure_files(request.figures, FIGURES[request.model])
    drawings = figures.drawings(volume or result)
    return [(path, outputs.saver(drawings[name])) for name, path in files.items()]


def first_yield(stress: StressResult) -> StressResult:
    """Return the contact of the same bodies at the load at which the first point yields."""
    from roughcontact.contact.first_yield import yield_onset

    contact = stress.contact
    return yield_onset(
        contact.surface,
        material=contact.material,
        counter_material=contact.counter_material,
        counter_surface=contact.counter_surface,
        body=stress.body,
        friction=stress.friction,
        direction=stress.direction,
        boundary=contact.boundary,
    )


def curve_report(
    request: Request, maps: Sequence[Surface], curve: LoadCurve
) -> Callable[[Path], object]:
    """Return what writes the report of a load curve, with the contact at its last load."""
    from roughcontact.contact import solve as contact
    from roughcontact.report import contact as report

    def save(path: Path) -> None:
        result = contact.solve(
            maps[0],
            **request.problem(maps),
            load=curve.steps[-1].load,
            max_iterations=request.max_iterations,
        )
        chapters = sections.sections(None, request.resolution_notes(maps))
        twin = result.elastic() if result.saturated_fraction else None
        report.save(
            result, path, elastic=twin, curve=curve, sections=chapters,
            command=request.command("sweep"),
        )  # fmt: skip

    return save
