"""The task ``sweep``: the contact under ascending loads."""

from __future__ import annotations

from typing import TYPE_CHECKING

from roughcontact.request.contacts import check_range
from roughcontact.request.measurement import how
from roughcontact.request.outcome import OnProgress

if TYPE_CHECKING:
    from roughcontact.analyses.sweep.model import LoadCurve

from dataclasses import replace
from typing import Any

from roughcontact._tools import memory
from roughcontact.errors import ArgumentRef, InputError
from roughcontact.formats import export
from roughcontact.request import measurement, options, parsing
from roughcontact.request.options import NEEDED, Option, Rule
from roughcontact.request.outcome import Outcome, TaskContext
from roughcontact.request.request import Request
from roughcontact.request.task import Analysis, Task

FROM = Option.value(
    "from",
    parsing.load_or_approach,
    'First load or approach: "10 mN", "1 MPa", "hertz 0.5 GPa" or "0.1 um".',
)
TO = Option.value("to", parsing.load_or_approach, "Last load or approach, in the same form.")
STEPS = Option("steps", parsing.int_parser(2, memory.STEPS), "Number of loads; default: 13.", 13)
SPACING = Option(
    "spacing",
    parsing.choice("log", "linear"),
    "log (equal ratios) or linear (equal differences); default: log.",
    "log",
)
OUTPUT = Option.output("Table of loads", export.TABLES)
FIGURE = Option.figure("the curve")
_RANGE = (FROM, TO, STEPS, SPACING)


def _steps(request: Request) -> tuple[str, list[Any]]:
    """Return the control (load or approach) and the values, in the form of the ends."""
    from roughcontact.contact.load_case import space_values

    (control, first), (_, last) = _ends(request)
    form, ends = type(first), (first, last)
    if form is not float:
        ends = first.value, last.value
    check_range(request, *ends)
    return control, [form(value) for value in space_values(*ends, request[STEPS], request[SPACING])]


def _ends(request: Request) -> tuple[tuple[str, Any], tuple[str, Any]]:
    return request.require(FROM), request.require(TO)


def _run(request: Request, work: TaskContext) -> Outcome:
    from roughcontact.analyses.sweep.model import sweep

    control, values = _steps(request)
    if control == "load":
        request.force(request.pair(work.maps), values[-1], "from")
    with work.report_saved_steps_on_interrupt("step-*.npz", "load") as (watch, reused):
        curve = sweep(
            work.maps[0],
            **request.arguments(work.maps),
            loads=values if control == "load" else None,
            approaches=values if control == "approach" else None,
            folder=request[options.FOLDER],
            progress=watch,
        )
        if curve.ceiling is not None and curve.base is None:
            curve = replace(curve, contact=work.add_calibrated(curve.largest))
    if request[measurement.UNCERTAINTY]:
        curve = measured_curve(request, curve, work.look)
    curve = replace(curve, extra_cautions=work.extra_cautions)
    return Outcome(request, curve, extras={"reused": len(reused)})


def _check(request: Request) -> None:
    first, last = _ends(request)
    if (first[0], type(first[1])) != (last[0], type(last[1])):
        raise InputError(
            f"{ArgumentRef('from')} and {ArgumentRef('to')} must both be loads of one form or both "
            f"approaches, got {request.specified[FROM.name]!r} and {request.specified[TO.name]!r}"
        )
    _steps(request)


def _last(outcome: Outcome) -> dict[str, Any]:
    curve = outcome.result
    step, area = curve.steps[-1], curve.nominal_area
    return {
        "load": step.load,
        "max_pressure": step.max_pressure,
        "contact_fraction": step.contact_area / area,
        "saturated_fraction": step.saturated_area / area,
        "certificate": step.certificate,
        "ceiling": None if curve.ceiling is None else "given",
    }


TASK = Task(
    "sweep",
    """Compute the load curve: area, gap and stiffness over many loads.

With --folder every step is saved; the same command resumes.

\b
Example:
roughcontact sweep ground.x3p --from "10 MPa" --to "300 MPa" \\
    --boundary periodic --material 42CrMo4 --output curve.csv
""",
    (
        *options.MAP,
        *_RANGE,
        *options.BODIES,
        *options.COATINGS,
        *options.SOLVER,
        *measurement.OPTIONS,
        OUTPUT,
        options.FOLDER,
        FIGURE,
        *options.OUTPUT,
    ),
    short_help="from to steps material young poisson yield-strength missing output report",
    run=_run,
    rules=(
        *(
            Rule(NEEDED, end, text="a load such as '1 N' or an approach such as '1 um'")
            for end in (FROM, TO)
        ),
        *measurement.RULES,
    ),
    check=_check,
    last=_last,
    held="analyses.sweep.model:MAX_HELD_RESULTS",
    questions=(
        Analysis(
            "Load curve",
            "Contact area, gap, stiffness and spots from a small load to a large one.",
            _RANGE,
            initial=((FROM, "1 MPa"), (TO, "100 MPa")),
        ),
    ),
    presentations={"LoadCurve": "analyses.sweep.report:CurvePresentation"},
)


def measured_curve(request: Request, curve: LoadCurve, look: OnProgress) -> LoadCurve:
    """Return a load curve with the intervals of each load."""
    from roughcontact.analyses.sweep.model import curve_uncertainty

    return curve_uncertainty(curve, **how(request), progress=look)
