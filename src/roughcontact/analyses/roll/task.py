"""The task ``roll``: repeated passes of a counter-body over a yielding body."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughcontact._tools import memory
from roughcontact.analyses.roll.formats import ROLLING_FORMATS
from roughcontact.errors import ArgumentRef, InputError
from roughcontact.formats import export
from roughcontact.request import options, parsing
from roughcontact.request.options import LENGTH, Option
from roughcontact.request.outcome import OnProgress, Outcome, TaskContext
from roughcontact.request.request import Request
from roughcontact.request.task import Analysis, Task
from roughcontact.solvers.progress import Forecast, Progress
from roughcontact.units import format_duration

if TYPE_CHECKING:
    from roughcontact.analyses.roll.model import MovieFrame

PASSES = Option(
    "passes",
    parsing.int_parser(1, memory.STEPS),
    "Maximum number of passes (forward and back are two); default: 5.",
    5,
)
STEPS = Option("steps", parsing.int_parser(1, memory.STEPS), "Positions per pass; default: 32.", 32)
TRAVEL = Option.value(
    "travel", LENGTH, 'Travel per pass, centered: "80 um"; default: one period of the map.'
)
DIRECTION = Option(
    "direction",
    parsing.DEGREES,
    "Travel direction, degrees counterclockwise from x; default: 0.",
    0.0,
)
RECIPROCATING = Option.flag("reciprocating", "Reciprocate: alternate the travel direction.")
FRICTION = Option(
    "friction",
    parsing.number,
    "Friction coefficient in full sliding, in travel direction; default: 0.",
    0.0,
)
OUTPUT = Option.output(
    f"Passes: {export.list_formats(ROLLING_FORMATS)}, .csv or .xlsx table, .json numbers",
    (*ROLLING_FORMATS.suffixes, *export.TABLES),
)
MOVIE = Option.file("movie", "Animated GIF of pressure and plastic strain.", (".gif",))
YES = Option.flag("yes", "Run for more than a day.", options.Panel.OUTPUT)

# Run time [s] above which a run needs confirmation.
_LONG = 86400.0


def _run(request: Request, work: TaskContext) -> Outcome:
    """Roll the counter-body for the requested number of passes."""
    from roughcontact.analyses.roll.figures import along_of
    from roughcontact.analyses.roll.model import make_frame, roll

    force, specified = request.force(request.pair(work.maps), request[options.LOAD])
    arguments = request.arguments(work.maps)
    del arguments["ceiling"]
    frames: list[MovieFrame] = []
    along = along_of(request[DIRECTION])

    def picture(number: int, step: int, state: Any) -> None:
        if request[MOVIE] is not None:
            frames.append(make_frame(state, number, step, along))

    # A series for ParaView needs all steps: the callback makes `roll` store them.
    shown = request[MOVIE] is not None or _leaves_series(request)
    with work.report_saved_steps_on_interrupt("pass-*/step-*.nc", "step") as (watch, reused):
        result = roll(
            work.maps[0],
            **arguments,
            load=force,
            passes=request[PASSES],
            steps=request[STEPS],
            travel=request[TRAVEL],
            direction=request[DIRECTION],
            reciprocating=request[RECIPROCATING],
            start_at_center=request[TRAVEL] is not None,
            friction=request[FRICTION],
            folder=request[options.FOLDER],
            progress=watch if request[YES] else _limit_time(watch),
            on_step=picture if shown else None,
        )
    last = replace(
        result.result.solution, specified_load=specified, extra_cautions=work.extra_cautions
    )
    result = replace(result, result=replace(result.result, solution=last))
    extras = {"frames": tuple(frames), "reused": max(reused, default=0)}
    return Outcome(request, result, last, extras)


def _limit_time(look: OnProgress) -> OnProgress:
    """Return a callback that stops a run if its estimated time is too long."""
    forecast = Forecast()

    def watch(state: Progress) -> None:
        seconds = forecast(state)
        if seconds > _LONG:
            took = f"{state.count} steps take about {format_duration(seconds)}"
            raise InputError(
                f"is needed: {took}. Crop, coarsen ({ArgumentRef('pixel')}) or reduce "
                f"{ArgumentRef('passes')}",
                argument="yes",
            )
        look(state)

    return watch


def _leaves_series(request: Request) -> bool:
    return any(path.suffix == ".pvd" for path in request[OUTPUT])


def _check(request: Request) -> None:
    if not any(map(request.is_given, (options.COUNTER_BODY, options.COUNTER_SURFACE))):
        raise InputError(
            "is needed: the body that rolls over the map, such as "
            f"{ArgumentRef('counter_body', 'cylinder 5 mm 90 deg')}; or a "
            f"{ArgumentRef('counter_surface')}",
            argument="counter_body",
        )
    request.require_yield(ArgumentRef("task", request.task.name))
    if not 0 <= request[FRICTION] < math.inf:
        raise InputError(
            f"must not be negative, got {request.specified[FRICTION.name]!r}", argument="friction"
        )
    if request[options.FOLDER] is None and _leaves_series(request):
        raise InputError("is needed for .pvd, which holds its steps", argument="folder")


def _movie(outcome: Outcome, path: Path) -> None:
    from roughcontact.analyses.roll import figures as rolling

    rolling.save(outcome.result, outcome.extras["frames"], path)


TASK = Task(
    "roll",
    """Simulate repeated rolling; report shakedown or ratcheting.

An elastoplastic step takes seconds, or minutes on large maps. With --folder every step is saved;
the same command resumes.

\b
Example:
roughcontact roll ground.x3p --counter-body "cylinder 5 mm 90 deg" \\
    --load "hertz 2.5 GPa" --boundary periodic --passes 5 --material 100Cr6 \\
    --report rolled.html
""",
    (
        *options.MAP,
        options.LOAD,
        PASSES,
        STEPS,
        TRAVEL,
        DIRECTION,
        RECIPROCATING,
        FRICTION,
        *options.MATERIALS,
        *options.SHAPES,
        options.HARDENING,
        options.BOUNDARY,
        *(options.TOLERANCE, options.MAX_ITERATIONS, options.PRECISION),
        YES,
        OUTPUT,
        options.FOLDER,
        MOVIE,
        options.FIGURES,
        *options.OUTPUT,
    ),
    short_help="load counter-body passes travel material hardening friction missing output report",
    run=_run,
    rules=(options.Rule(options.NEEDED, options.LOAD, text="such as '1 N' or 'hertz 1.5 GPa'"),),
    check=_check,
    memory=Request.require_volume,
    writes=((MOVIE, _movie),),
    figures=lambda _: "analyses.roll.report:FIGURES",
    questions=(
        Analysis(
            "Repeated passes",
            "A counter-body passes over the map: plastic strain, shakedown, roughness. Seconds a "
            "step.",
            fixed=((PASSES, "2"), (STEPS, "8")),
            is_command=True,
        ),
    ),
    presentations={"RollingResult": "analyses.roll.report:RollingPresentation"},
)
