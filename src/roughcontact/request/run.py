"""Carry out a request: read, prepare, solve, write."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughcontact.contact import certainty
from roughcontact.contact.cautions import of_measurement
from roughcontact.errors import InputError, RoughcontactError, Sentence, parts_of
from roughcontact.formats import tables
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.fft import default_workers
from roughcontact.request import comparing, joints, memory, outputs, problem, rolling, studying
from roughcontact.request.maps import prepared_by, resolution_notes, surfaces
from roughcontact.request.options import (
    COMPARE,
    FIND,
    HISTORY,
    ROLL,
    SOLVE,
    STRESS,
    SWEEP,
    VOLUME,
    spell_option,
)
from roughcontact.request.outputs import Say
from roughcontact.request.request import Request
from roughcontact.solvers.progress import Progress

if TYPE_CHECKING:
    from roughcontact.contact.compared import Comparison
    from roughcontact.contact.curve import LoadCurve
    from roughcontact.contact.found import FoundLoads
    from roughcontact.contact.history import LoadHistory
    from roughcontact.contact.result import ContactResult
    from roughcontact.contact.sampling import SamplingStudy
    from roughcontact.contact.stress import StressResult
    from roughcontact.contact.study import ResolutionStudy
    from roughcontact.ranks import Ranks
    from roughcontact.surface.surface import Surface
    from roughcontact.volume.passes import Frame
    from roughcontact.volume.result import ElastoplasticResult
    from roughcontact.volume.rolling import Rolling

Look = Callable[[Progress], None]


@dataclass(frozen=True)
class Outcome:
    """What a request gave.

    Parameters
    ----------
    request : Request
        What was asked for.
    result : ContactResult or None
        The contact: the solution or the best found, that of the volume model, that below which the
        stress is, the last of a history, that under the largest load found; none of a sweep or a
        comparison.
    volume, stress, curve, history, rolling, loads, joint, comparison : optional
        What the task found besides.
    frames : tuple of Frame
        Pictures of the passes, if a movie was asked for.
    study : ResolutionStudy or None
        The same on other grids, if it was asked for.
    first_yield : StressResult or None
        The contact at the load of first yield, if it was asked for.
    reused : int
        Loads that stood in the folder from an earlier run.
    written : tuple of Path
        Files that are complete.
    failure : RoughcontactError or None
        Why a file could not be written.
    """

    request: Request
    result: ContactResult | None = None
    volume: ElastoplasticResult | None = None
    stress: StressResult | None = None
    curve: LoadCurve | None = None
    history: LoadHistory | None = None
    rolling: Rolling | None = None
    frames: tuple[Frame, ...] = ()
    loads: FoundLoads | None = None
    joint: joints.Joint | None = None
    comparison: Comparison | SamplingStudy | None = None
    study: ResolutionStudy | None = None
    first_yield: StressResult | None = None
    reused: int = 0
    written: tuple[Path, ...] = ()
    failure: RoughcontactError | None = None

    @property
    def found(self) -> Any:
        """What was asked for."""
        whole = (
            self.rolling, self.volume, self.stress, self.curve, self.history, self.loads,
            self.joint, self.comparison,
        )  # fmt: skip
        return next((found for found in whole if found is not None), self.result)

    @property
    def status(self) -> str:
        """``"converged"``, or why the solver stopped."""
        if self.volume is not None:
            return self.volume.status
        # Sweeps and histories end with an error where a step does not converge.
        return "converged" if self.result is None else self.result.status

    @property
    def converged(self) -> bool:
        """Whether files were to be written."""
        return self.status == "converged"

    @property
    def shortfall(self) -> Sentence:
        """How far a solver came that did not converge, and why it stopped."""
        reached = ""
        # The increments of the volume that are told of have settled; the status says which did not.
        if self.volume is None and self.result is not None:
            found = self.result
            reached = (
                f"certificate {found.certificate:.1e}, tolerance {found.tolerance:.0e}, "
                f"load error {found.load_error:.1e}; "
            )
        return Sentence(f"not converged: {reached}", *parts_of(self.status))

    @property
    def last(self) -> dict[str, Any]:
        """The contact in a few numbers, by the keys of `record`; the last one of several.

        None of maps that are compared.
        """
        if self.comparison is not None:
            return {}
        if self.curve is not None:
            step, area = self.curve.steps[-1], self.curve.nominal_area
            return {
                "load": step.load,
                "max_pressure": step.max_pressure,
                "contact_fraction": step.contact_area / area,
                "saturated_fraction": step.saturated_area / area,
                "certificate": step.certificate,
                "ceiling": None if self.curve.ceiling is None else "given",
            }
        assert self.result is not None
        told = self.result.summary()
        keys = ("load", "max_pressure", "contact_fraction", "saturated_fraction", "certificate")
        return {key: told[key] for key in (*keys, "ceiling")}

    def record(self) -> dict[str, Any]:
        """Return all numbers by name, in SI units, ready for JSON."""
        told: dict[str, Any]
        several = (
            self.curve, self.history, self.rolling, self.loads, self.joint, self.comparison,
        )  # fmt: skip
        whole = next((found for found in several if found is not None), None)
        if whole is not None:
            told = whole.summary()
        else:
            assert self.result is not None
            told = tables.record(self.volume or self.result)
        if self.stress is not None:
            told["stress"] = self.stress.summary()
        if self.first_yield is not None:
            told["first_yield"] = self.first_yield.summary()
        if self.study is not None:
            told["study"] = self.study.summary()
        if self.result is not None and self.found is self.result:
            found = certainty.intervals(self.result, self.study)
            told["intervals"] = {interval.name: interval.summary() for interval in found}
        return {**told, "written": [str(path) for path in self.written]}


def run(
    request: Request,
    say: Say,
    look: Look | None = None,
    known: Mapping[str, Any] | None = None,
) -> Outcome:
    """Read, prepare, solve, and write what was asked for.

    Parameters
    ----------
    request : Request
        What to do.
    say : callable
        Called with a few words before every stage.
    look : callable, optional
        Called with the `Progress` of the solver.
    known : mapping, optional
        What was found of each of the `pieces.of` of the request, by their words.

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
    request.check_places()
    if request.kind == COMPARE:
        found = comparing.compared(request, say, look or _nobody, known)
        return _written(Outcome(request, comparison=found), (), say)
    maps = prepared(request, say)
    return _written(solved(request, maps, say, look, known=known), maps, say)


@contextmanager
def together() -> Iterator[Callable[..., Outcome]]:
    """Give what carries out requests as `run` does, and shares what they have in common.

    Yields
    ------
    callable
        Called as `run`, which it does. Maps that several of them prepare in the same way are
        read once, and contacts of which they ask what a joint does are solved once.
    """
    with joints.once() as solve:
        read: dict[str, list[Surface]] = {}

        def carry_out(
            request: Request,
            say: Say,
            look: Look | None = None,
            known: Mapping[str, Any] | None = None,
        ) -> Outcome:
            if request.kind == COMPARE:
                return run(request, say, look, known)
            request.check_places()
            words = prepared_by(request)
            if words in read:
                memory.require(request, read[words][0].shape)
            else:
                read[words] = prepared(request, say)
            maps = read[words]
            return _written(solved(request, maps, say, look, solve, known), maps, say)

        yield carry_out


def prepared(request: Request, say: Say) -> list[Surface]:
    """Return the maps of a request: body and counter-body, or several maps of one surface."""
    single = [replace(request, file=path, files=()) for path in request.files] or [request]
    return [surface for one in single for surface in surfaces(one, say)]


def solved(
    request: Request,
    maps: Sequence[Surface],
    say: Say,
    look: Look | None = None,
    solve: joints.Solve = joints.fresh,
    known: Mapping[str, Any] | None = None,
) -> Outcome:
    """Carry out a request on maps that are prepared, and write nothing.

    Parameters
    ----------
    request : Request
        What to do; not to compare maps.
    maps : sequence of Surface
        From `surfaces`.
    say, look : callable
        As for `run`.
    solve : callable, optional
        What solves the contacts that are asked what a joint does; see `joints.once`.
    known : mapping, optional
        As for `run`.

    Returns
    -------
    Outcome
        The result.

    Raises
    ------
    RoughcontactError
        If the request cannot be done.
    """
    look = look or _nobody
    if request.kind in joints.ASKED:
        contacts = joints.Contacts(request, maps, look, solve)
        if len(request.files) > 1:
            contacts = replace(contacts, maps=maps[:1], more=maps[1:])
        found = joints.ASKED[request.kind](request, contacts)
        outcome = Outcome(request, found.largest, joint=found)
    else:
        outcome = _TASKS[request.kind](request, maps, say, look)
    if request.kind == SOLVE and request["study"] and outcome.converged:
        assert outcome.result is not None
        study = studying.studied(request, maps, outcome.result.load, look, known)
        outcome = replace(outcome, study=study)
    return remarked(outcome, maps)


def _written(outcome: Outcome, maps: Sequence[Surface], say: Say) -> Outcome:
    """Write the files of an outcome, and return it with their names."""
    if not outcome.converged:
        return outcome
    # The numbers are shown even where the files cannot be written.
    try:
        written = tuple(outputs.write(files(outcome, maps), say))
    except RoughcontactError as error:
        return replace(outcome, failure=error)
    return replace(outcome, written=written)


def remarked(outcome: Outcome, maps: Sequence[Surface]) -> Outcome:
    """Return an outcome whose results tell what is known from the measurement and the study."""
    remarks = of_measurement(resolution_notes(outcome.request, maps))
    if outcome.study is not None:
        remarks = (*remarks, *outcome.study.cautions)
    changed: dict[str, Any] = {}
    if outcome.result is not None:
        changed["result"] = result = replace(outcome.result, remarks=remarks)
        for name, whole in (("volume", outcome.volume), ("stress", outcome.stress)):
            if whole is not None:
                changed[name] = replace(whole, solution=result)
        if outcome.rolling is not None:
            changed["rolling"] = replace(outcome.rolling, result=changed["volume"])
        if outcome.history is not None:
            changed["history"] = replace(outcome.history, last=result, remarks=remarks)
        if outcome.loads is not None:
            changed["loads"] = replace(outcome.loads, remarks=remarks)
        if outcome.joint is not None:
            changed["joint"] = replace(outcome.joint, largest=result, remarks=remarks)
    if outcome.curve is not None:
        changed["curve"] = replace(outcome.curve, remarks=remarks)
    return replace(outcome, **changed)


def _nobody(progress: Progress) -> None:
    """Look at nothing."""


def _contact(request: Request, maps: Sequence[Surface], look: Look) -> ContactResult:
    from roughcontact.contact.solve import solve

    force, given = problem.pressed(request, maps, *request.load)
    found = solve(
        maps[0],
        **problem.arguments(request, maps, "tolerance", "max-iterations", "precision"),
        load=force,
        approach=request["approach"],
        moments=request.moments(force),
        calibrated=request.kind == SOLVE and not request["uncalibrated"],
        on_failure="return",
        progress=look,
    )
    return replace(found, given=given)


def _solve(request: Request, maps: Sequence[Surface], say: Say, look: Look) -> Outcome:
    return Outcome(request, _contact(request, maps, look))


def of_volume(
    request: Request, maps: Sequence[Surface], say: Say, look: Look, ranks: Ranks | None = None
) -> Outcome:
    """Solve with the volume model, whose volume may lie on several ranks."""
    from roughcontact.volume.path import PathPoint
    from roughcontact.volume.solve import solve_elastoplastic
    from roughcontact.volume.stepping import AUTO, between

    (load, given), steps = problem.pressed(request, maps, *request.load), request["increments"]
    way = between(PathPoint(0.0), PathPoint(load), 1 if steps == AUTO else steps)
    loads = [point.load for point in way]
    loads += [0.0] * request["unload"]
    options = problem.arguments(request, maps, "tolerance", "max-iterations", "precision")
    del options["ceiling"]
    with _kept(request, "step-*.nc", look) as (watch, reused):
        found = solve_elastoplastic(
            maps[0],
            **options,
            loads=loads,
            increments=steps,
            on_failure="return",
            folder=request["folder"],
            progress=watch,
            communicator=ranks,
        )
    found = replace(found, solution=replace(found.solution, given=given))
    # The last of them is told of.
    return Outcome(request, found.solution, volume=found, reused=max(reused, default=0))


def _roll(request: Request, maps: Sequence[Surface], say: Say, look: Look) -> Outcome:
    with _kept(request, "pass-*/step-*.nc", look) as (watch, reused):
        found, given, frames = rolling.rolled(request, maps, watch)
    last = replace(found.result, solution=replace(found.result.solution, given=given))
    found, reuse = replace(found, result=last), max(reused, default=0)
    return Outcome(request, last.solution, last, rolling=found, frames=frames, reused=reuse)


def _stress(request: Request, maps: Sequence[Surface], say: Say, look: Look) -> Outcome:
    from roughcontact.contact.first_yield import onset
    from roughcontact.contact.subsurface import subsurface_stress

    Boundary(request["boundary"]).require_stress()
    result = _contact(request, maps, look)
    if not result.converged:
        return Outcome(request, result)
    say("stress below the surface")
    below: dict[str, Any] = {
        "body": "body" if request["which"] == "body" else "counter_body",
        "friction": request["friction"],
        "direction": request["direction"],
    }
    with _naming(body="which"):
        stress = subsurface_stress(result, request["depths"], **below)
        if not request["onset"]:
            return Outcome(request, result, stress=stress)
        say("searching the load of first yield")
        return Outcome(request, result, stress=stress, first_yield=onset(result.pair, **below))


def _sweep(request: Request, maps: Sequence[Surface], say: Say, look: Look) -> Outcome:
    from roughcontact.contact.load_curve import load_curve

    control, values = request.steps
    if control == "load":
        problem.pressed(request, maps, values[-1], "from")
    with _kept(request, "step-*.npz", look) as (watch, reused):
        curve = load_curve(
            maps[0],
            **problem.arguments(request, maps, "tolerance", "max-iterations", "precision"),
            loads=values if control == "load" else None,
            approaches=values if control == "approach" else None,
            folder=request["folder"],
            progress=watch,
        )
    return Outcome(request, curve=curve, reused=len(reused))


def _history(request: Request, maps: Sequence[Surface], say: Say, look: Look) -> Outcome:
    from roughcontact.contact.history import Stage
    from roughcontact.contact.load_history import load_history

    with _kept(request, "step-*.npz", look) as (watch, reused):
        history = load_history(
            maps[0],
            [Stage(**{control: value}) for control, value in request["path"]],
            **problem.arguments(request, maps, "tolerance", "max-iterations"),
            passes=request["passes"],
            shift=request["shift"],
            folder=request["folder"],
            progress=watch,
        )
    return Outcome(request, history.last, history=history, reused=len(reused))


def _find(request: Request, maps: Sequence[Surface], say: Say, look: Look) -> Outcome:
    from roughcontact.contact.find import find_load

    loads = find_load(
        maps[0],
        **problem.arguments(request, maps, "tolerance", "max-iterations"),
        contact=request["contact"],
        saturated=request["saturated"],
        approach=request["approach"],
        mean_gap=request["mean-gap"],
        first_yield=request["first-yield"],
        progress=look,
    )
    return Outcome(request, loads.largest, loads=loads)


_TASKS: dict[str, Callable[[Request, Sequence[Surface], Say, Look], Outcome]] = {
    SOLVE: _solve,
    VOLUME: of_volume,
    STRESS: _stress,
    SWEEP: _sweep,
    HISTORY: _history,
    ROLL: _roll,
    FIND: _find,
}


@contextmanager
def _kept(request: Request, pattern: str, look: Look) -> Iterator[tuple[Look, list[int]]]:
    """Note which loads stood in the folder; after Ctrl-C, tell which stand complete in it."""
    reused: list[int] = []

    def watch(at: Progress) -> None:
        if at.kept:
            reused.append(at.number)
        look(at)

    try:
        yield watch, reused
    except KeyboardInterrupt:
        folder = request.get("folder")
        kept = () if folder is None else sorted(folder.glob(pattern))
        raise outputs.UnfinishedError(kept) from None


@contextmanager
def _naming(**options: str) -> Iterator[None]:
    """Let errors speak of options that have names of their own for an argument."""
    try:
        yield
    except InputError as error:
        error.argument = options.get(error.argument or "", error.argument)
        raise


def files(outcome: Outcome, maps: Sequence[Surface]) -> Iterator[outputs.Task]:
    """Yield the files that were asked for, with what writes them."""
    from roughcontact.report import figures

    request, found = outcome.request, outcome.found
    for path in request.outputs:
        yield path, found.save
    if outcome.history is not None and request["residual"] is not None:
        yield request["residual"], outcome.history.residual.save
    if outcome.frames and outcome.rolling is not None:
        from roughcontact.plots import movie

        yield request["movie"], partial(movie.save, outcome.rolling, outcome.frames)
    if request.get("report") is not None:
        yield request.get("report"), partial(report, outcome, maps)
    if outcome.comparison is not None:
        from roughcontact.report import comparison

        for _, _, path in request.figures():
            yield path, outputs.saver(partial(comparison.figure, outcome.comparison))
        return
    drawings = figures.drawings(found)
    for _, name, path in request.figures():
        # A profile has fewer of them than a map.
        if name and name not in drawings:
            continue
        yield path, outputs.saver(drawings[name or next(iter(drawings))])


def report(outcome: Outcome, maps: Sequence[Surface], path: Path) -> None:
    """Write the report on an outcome."""
    from roughcontact.report import additions, comparison, contact, rolling, steps, volume

    request = outcome.request
    told = _telling(request)
    if outcome.curve is not None:
        _curve_report(outcome.curve, request, maps, path)
    elif outcome.history is not None:
        steps.save_history(outcome.history, path, **told)
    elif outcome.loads is not None and outcome.result is not None:
        answers = additions.of_loads(outcome.loads)
        contact.save_compared(outcome.result, path, additions=[answers], study=None, **told)
    elif outcome.joint is not None and outcome.result is not None:
        chapter = additions.of_joint(outcome.joint)
        contact.save_compared(outcome.result, path, additions=[chapter], study=None, **told)
    elif outcome.comparison is not None:
        comparison.save(outcome.comparison, path, **told)
    elif outcome.stress is not None:
        below = additions.of_stress(outcome.stress, outcome.first_yield)
        solution = outcome.stress.solution
        contact.save_compared(solution, path, additions=[below], study=None, **told)
    elif outcome.rolling is not None:
        rolling.save(outcome.rolling, path, **told)
    elif outcome.volume is not None:
        volume.save(outcome.volume, path, **told)
    elif outcome.result is not None:
        contact.save_compared(outcome.result, path, additions=[], study=outcome.study, **told)


def _curve_report(curve: LoadCurve, request: Request, maps: Sequence[Surface], path: Path) -> None:
    """Write the report on a load curve, with the contact at its last load."""
    from roughcontact.contact.solve import solve
    from roughcontact.report import steps

    options = problem.arguments(request, maps, "tolerance", "max-iterations", "precision")
    result = solve(maps[0], **options, load=curve.steps[-1].load, calibrated=False)
    result = replace(result, remarks=curve.remarks)
    twin = result.elastic() if result.saturated_fraction else None
    steps.save_curve(curve, result, path, elastic=twin, **_telling(request))


def _telling(request: Request) -> dict[str, Any]:
    """Return what every report takes of a request, and of the cores there are."""
    return {
        "command": request.command,
        "spell": partial(spell_option, command=request.task),
        "processes": default_workers(),
    }
