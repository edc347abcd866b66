"""The task ``stress``: the elastic stress below a contact."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from roughcontact.analyses.solve import task as solve
from roughcontact.halfspace.boundary import Boundary
from roughcontact.request import options, parsing
from roughcontact.request.options import Option, Panel
from roughcontact.request.outcome import Outcome, TaskContext
from roughcontact.request.request import Request
from roughcontact.request.task import Analysis, Task

IN_BODY = Option(
    "in-body",
    parsing.choice("body", "counter-body"),
    "Body whose stress is computed; default: body.",
    "body",
)
FRICTION = Option(
    "friction", parsing.number, "Friction coefficient in full sliding; default: 0.", 0.0
)
DIRECTION = Option(
    "direction",
    parsing.DEGREES,
    "Traction direction, degrees counterclockwise from x; default: 0.",
    0.0,
)
DEPTHS = Option.value(
    "depths", parsing.lengths, 'Depths: "1 um, 2 um"; default: automatic.', Panel.SOLVER
)
FIRST_YIELD = Option.flag("first-yield", "Also compute the load of first yield.", Panel.SOLVER)
OUTPUT = Option.output("Contact and stress as NetCDF", (".nc",))


def _run(request: Request, work: TaskContext) -> Outcome:
    from roughcontact.analyses.stress.model import solve_first_yield, subsurface_stress
    from roughcontact.contact.ceiling import is_bracket

    Boundary(request[options.BOUNDARY]).require_known_below("the stress below the surface")
    contact = solve.contact(request, work, calibrated=False)
    solution = replace(contact, extra_cautions=work.extra_cautions)
    if not contact.converged:
        return Outcome(request, solution, solution)
    body = "body" if request[IN_BODY] == "body" else "counter_body"
    traction: dict[str, Any] = {"friction": request[FRICTION], "direction": request[DIRECTION]}
    stress = subsurface_stress(
        contact, request[DEPTHS], in_body=body, progress=work.look, **traction
    )
    other = solve.under_other_ceiling(request, work, contact)
    if other is not None:
        found = subsurface_stress(other, request[DEPTHS], in_body=body, **traction)
        is_base = is_bracket(contact.pair, request[options.CEILING])
        stress = replace(
            stress, base=found if is_base else None, calibrated=None if is_base else found
        )
    extras = {}
    if request[FIRST_YIELD]:
        work.say("searching the load of first yield")
        extras["first_yield"] = solve_first_yield(contact.pair, body, **traction)
    return Outcome(request, replace(stress, solution=solution), solution, extras)


def _memory(request: Request, shape: tuple[int, int]) -> None:
    from roughcontact.analyses.stress.model import require_memory

    request.require_contact(shape)
    require_memory(shape, boundary=Boundary(request[options.BOUNDARY]), friction=request[FRICTION])


def _record(outcome: Outcome) -> dict[str, Any]:
    from roughcontact.formats import tables

    if outcome.result is outcome.contact:
        return solve.record(outcome)
    record = {**tables.result_record(outcome.result.solution), "stress": outcome.result.summary()}
    if "first_yield" in outcome.extras:
        record["first_yield"] = outcome.extras["first_yield"].summary()
    return record


TASK = Task(
    "stress",
    """Compute subsurface stress and the load of first yield.

\b
Example:
roughcontact stress ground.x3p --load "100 MPa" --boundary periodic \\
    --material 42CrMo4 --output stress.nc --figures out
""",
    (
        *options.MAP,
        *options.LOADS,
        *options.BODIES,
        *options.COATINGS,
        IN_BODY,
        FRICTION,
        DIRECTION,
        DEPTHS,
        FIRST_YIELD,
        *options.SOLVER,
        OUTPUT,
        options.FIGURES,
        *options.OUTPUT,
    ),
    short_help="load material young poisson yield-strength friction first-yield missing "
    "output report",
    run=_run,
    rules=options.LOAD_RULES,
    record=_record,
    memory=_memory,
    figures=lambda _: "analyses.stress.report:FIGURES",
    questions=(
        Analysis(
            "Subsurface stress",
            "Elastic stress below this contact, and the point of first yield.",
            (IN_BODY, FRICTION, DIRECTION, DEPTHS, FIRST_YIELD),
        ),
    ),
    presentations={"StressResult": "analyses.stress.report:StressPresentation"},
)
