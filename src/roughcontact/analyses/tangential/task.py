"""The task ``tangential``: stick, slip and stiffness under a tangential force."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from roughcontact.analyses.solve import task as solve
from roughcontact.analyses.stress.task import DIRECTION
from roughcontact.errors import InputError
from roughcontact.formats import export
from roughcontact.halfspace.boundary import Boundary
from roughcontact.request import options, parsing
from roughcontact.request.contacts import FRICTION
from roughcontact.request.options import LENGTH, Option
from roughcontact.request.outcome import Outcome, TaskContext, last_contact
from roughcontact.request.request import Request
from roughcontact.request.task import Analysis, Task
from roughcontact.units import parse

if TYPE_CHECKING:
    from roughcontact.contact.load_case import Load

# Maps of the tangential solver in addition to the contact: two spectra, two sets of symbols, the
# symbols of coarser grids, some fields.
_HELD = 21


def _force(text: str, argument: str) -> str:
    """Check the text of a force, or of a line load of a profile, and return it."""
    with suppress(InputError):
        parse(text, "line load", argument, positive=False)
        return text
    parse(text, "force", argument, positive=False)
    return text


@parsing.parser("FORCES")
def _forces(text: str, argument: str) -> tuple[str, ...]:
    return tuple(_force(part.strip(), argument) for part in text.split(","))


@parsing.parser("STAGES")
def _stages(text: str, argument: str) -> tuple[tuple[float | Load, str], ...]:
    """Return the stages of a text: pairs of a load and a tangential force."""
    result = []
    for part in text.split(","):
        load, colon, force = part.partition(":")
        if not colon:
            raise InputError(
                f"needs a load and a force in each stage, such as '1 N: 50 mN', got {part!r}",
                argument=argument,
                value=text,
            )
        result.append((parsing.load(load.strip(), argument), _force(force.strip(), argument)))
    return tuple(result)


FORCE = Option.value("force", _forces, 'Tangential force, or several in turn: "0.05 N, -0.05 N".')
SHIFT = Option.value("shift", LENGTH, 'Rigid tangential shift, instead of a force: "20 nm".')
STAGES = Option.value(
    "stages", _stages, 'Loads and forces together, from no contact on: "1 N: 0 N, 2 N: 0.1 N".'
)
OUTPUT = Option.output("Maps (NetCDF) or table of the steps", (".nc", *export.TABLES))
FIGURE = Option.figure("traction, slip and curve")
STRESS = Option.flag("stress", "Also compute subsurface stress and Ruiz parameters.")
_ASKED: tuple[Option[Any], ...] = (FRICTION, FORCE, SHIFT, DIRECTION, STRESS)


def _run(request: Request, work: TaskContext) -> Outcome:
    from roughcontact.analyses.tangential.model import tangential

    if not request.pair(work.maps).is_profile:
        Boundary(request[options.BOUNDARY]).require_known_below("tangential loading")
    stages = request[STAGES]
    load = None if stages is None else (stages[-1][0], STAGES.argument)
    contact = solve.contact(request, work, calibrated=False, load=load)
    contact = replace(contact, extra_cautions=work.extra_cautions)
    if not contact.converged:
        return Outcome(request, contact, contact)
    work.say("tangential loading")
    asked = {option.argument: request[option] for option in (*_ASKED, STAGES)}
    result = tangential(contact, **asked)
    other = solve.under_other_ceiling(request, work, contact, load=load)
    if other is not None:
        result = replace(result, calibrated=tangential(other, **asked))
    return Outcome(request, result, result.solution)


def _memory(request: Request, shape: tuple[int, int]) -> None:
    from roughcontact.analyses.stress.model import require_memory

    request.require_contact(shape, _HELD)
    if request[STRESS]:
        require_memory(shape, boundary=request[options.BOUNDARY], partial_slip=True)


TASK = Task(
    "tangential",
    """Compute stick, slip and shift under a tangential force.

Several forces are applied in turn, such as a cycle of fretting; stages change the load, too.

\b
Example:
roughcontact tangential ground.x3p --load "100 MPa" --boundary periodic \\
    --material 42CrMo4 --friction 0.15 --force "0.05 N" --report slip.html
""",
    (
        *options.MAP,
        *options.LOADS,
        *options.BODIES,
        *_ASKED,
        STAGES,
        *options.SOLVER,
        OUTPUT,
        FIGURE,
        *options.OUTPUT,
    ),
    short_help="load friction force shift material counter-material boundary missing output report",
    run=_run,
    rules=(
        options.Rule(options.ONE_OF, *options.LOADS[:-1], STAGES, text="1 N"),
        *options.LOAD_RULES[1:],
        options.Rule(options.NEEDED, FRICTION, text="a coefficient such as 0.15"),
        options.Rule(options.ONE_OF, FORCE, SHIFT, STAGES, text="0.05 N"),
    ),
    last=last_contact,
    memory=_memory,
    questions=(
        Analysis(
            "Tangential loading",
            "Shift, stick and slip of this contact under a tangential force.",
            _ASKED,
            initial=((FRICTION, "0.15"),),
        ),
    ),
    uncoated="the response of layers to a traction is not computed",
    presentations={"Tangential": "analyses.tangential.report:TangentialPresentation"},
)
