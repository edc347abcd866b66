"""The task ``history``: loading and unloading along a path."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from roughcontact._tools.memory import STEPS
from roughcontact.errors import require_count
from roughcontact.formats import export
from roughcontact.request import options, parsing
from roughcontact.request.options import NEEDED, Option, Rule
from roughcontact.request.outcome import Outcome, TaskContext, last_contact
from roughcontact.request.request import Request
from roughcontact.request.task import Analysis, Task

_SURFACES = export.SURFACE.suffixes
PATH = Option.value(
    "path", parsing.stages, 'Loads or approaches in order: "1 N, 0 N, 1 N", "20 MPa, 0 N".'
)
PASSES = Option(
    "passes",
    parsing.int_parser(1, STEPS),
    "Maximum number of repetitions of the path; default: 1.",
    1,
)
SHIFT = Option(
    "shift",
    parsing.offset,
    'Counter-body shift (y, x) per pass: "0 um, 5 um"; default: none.',
    (0.0, 0.0),
)
OUTPUT = Option.output("Table of steps", export.TABLES)
INDENTED_SURFACE = Option.file(
    "indented-surface", f"Indented surface: {', '.join(_SURFACES)}.", _SURFACES, metavar="FILE"
)
FIGURE = Option.figure("the load history")


def _run(request: Request, work: TaskContext) -> Outcome:
    from roughcontact.analyses.history.model import Stage, history as load_history

    ends: tuple[tuple[str, Any], ...] = request.require(PATH)
    stages = [Stage(**{control: value}) for control, value in ends]
    with work.report_saved_steps_on_interrupt("step-*.npz", "stage") as (watch, reused):
        history = load_history(
            work.maps[0],
            stages,
            **request.arguments(work.maps),
            passes=request[PASSES],
            shift=request[SHIFT],
            folder=request[options.FOLDER],
            progress=watch,
        )
        largest = history.largest
        if not any(request[SHIFT]):
            other = work.add_calibrated(history.under_largest).calibrated
            largest = replace(largest, calibrated=other)
    last = replace(history.last, extra_cautions=work.extra_cautions)
    history = replace(history, last=last, largest=largest, extra_cautions=work.extra_cautions)
    return Outcome(request, history, last, {"reused": len(reused)})


def _check(request: Request) -> None:
    from roughcontact.analyses.history.model import most_passes

    require_count(1, most_passes(len(request.require(PATH))), passes=request[PASSES])


TASK = Task(
    "history",
    """Follow loading and unloading, including permanent indentation.

The pressure ceiling represents perfect plasticity of the surface: indentation is permanent.

\b
Example:
roughcontact history ground.x3p --path "1 N, 0 N, 1 N" --boundary periodic \\
    --material 42CrMo4 --output history.csv --indented-surface indented.x3p
""",
    (
        *options.MAP,
        PATH,
        PASSES,
        SHIFT,
        *options.BODIES,
        *options.SOLVER_DOUBLE,
        OUTPUT,
        INDENTED_SURFACE,
        options.FOLDER,
        FIGURE,
        *options.OUTPUT,
    ),
    short_help="path passes material young poisson yield-strength missing indented-surface "
    "output report",
    run=_run,
    rules=(Rule(NEEDED, PATH, text="loads in their order, such as '1 N, 0 N, 1 N'"),),
    check=_check,
    last=last_contact,
    held="analyses.history.model:MAX_HELD_RESULTS",
    writes=((INDENTED_SURFACE, lambda outcome, path: outcome.result.residual.save(path)),),
    questions=(
        Analysis(
            "Load history",
            "Loading and unloading, once or repeatedly, with permanent indentation.",
            (PATH, PASSES, SHIFT),
            initial=((PATH, "10 MPa, 0 N, 10 MPa"),),
        ),
    ),
    uncoated="the layers under an indentation are not followed",
    presentations={"LoadHistory": "analyses.history.report:HistoryPresentation"},
)
