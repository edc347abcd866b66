"""The task ``leak``: what leaks through the gap of a contact."""

from __future__ import annotations

from typing import Any

from roughcontact.request import options, parsing
from roughcontact.request.contacts import (
    LOAD,
    LOAD_RULES,
    OUTPUT,
    RANGE,
    Contacts,
    check_loads,
    loads,
    outcome,
)
from roughcontact.request.option import LENGTH, PICTURES, PRESSURE, Option, Panel, file
from roughcontact.request.outcome import Outcome, Work, last_contact
from roughcontact.request.request import Request
from roughcontact.request.task import Question, Task

FLOW_AXIS = Option(
    "flow-axis", Panel.BODIES, "y|x", "Along which the fluid flows; default: both.",
    parsing.choice("y", "x"), None,
)  # fmt: skip
VISCOSITY = Option(
    "viscosity", Panel.BODIES, "VISCOSITY", 'Viscosity of the fluid, such as "1 mPa s".',
    parsing.quantity("viscosity"), None,
)  # fmt: skip
PRESSURE_DIFFERENCE = Option(
    "pressure-difference", Panel.BODIES, "PRESSURE", 'Between inlet and outlet, such as "1 bar".',
    PRESSURE, None,
)  # fmt: skip
SEAL_WIDTH = Option(
    "seal-width", Panel.BODIES, "LENGTH",
    "Of the face that leaks, across the flow: of a ring its circumference; default: that of "
    "the map.", LENGTH, None,
)  # fmt: skip
SEAL_LENGTH = Option(
    "seal-length", Panel.BODIES, "LENGTH",
    "Of the face that leaks, along the flow; default: that of the map.", LENGTH, None,
)  # fmt: skip
FIGURE = file(
    "figure", "FILE", "Draw the gap and what flows through it as PNG, SVG or PDF.", PICTURES
)
_SEAL: tuple[Option[Any], ...] = (VISCOSITY, PRESSURE_DIFFERENCE, SEAL_WIDTH, SEAL_LENGTH)
_FLUID = (FLOW_AXIS, *_SEAL)


def _run(request: Request, work: Work) -> Outcome:
    from roughcontact.joint.leakage import OF, leakage

    contacts = Contacts(request, work, work.maps)
    contacts.require_map(OF)
    result = leakage(
        contacts.under(loads(request)),
        **{option.argument: request[option] for option in _FLUID},
    )
    coarser = contacts.coarser(result.largest)
    return outcome(request, work, result if coarser is None else result.with_coarser_grid(coarser))


def _check(request: Request) -> None:
    from roughcontact.joint.leakage import seal_of

    check_loads(request)
    seal_of(*(request[option] for option in _SEAL))


TASK = Task(
    "leak",
    """Find what leaks through the gap under one load or several, and the flow factors.

Whether a way leads through is found first. The rate needs a fluid; without one it is told how
permeable the gap is.

\b
Example:
roughcontact leak ground.opd --load "1 N, 3 N" --material 42CrMo4 \\
    --missing fill --boundary periodic --viscosity "1 mPa s" \\
    --pressure-difference "1 bar"
""",
    (
        *options.MAP, LOAD, *RANGE, *options.MATERIALS, *_FLUID, *options.SHAPES,
        options.CEILING, options.BOUNDARY, *options.SOLVER, OUTPUT, FIGURE, *options.OUTPUT,
    ),
    (LOAD, *_FLUID, options.MATERIAL, options.BOUNDARY, options.MISSING, options.REPORT),
    run=_run,
    rules=LOAD_RULES,
    check=_check,
    last=last_contact,
    # Maps that a flow through the gap takes beside the contact, at most 250 bytes a point.
    held=32,
    questions=(
        Question(
            "What leaks through it",
            "Whether the gap is open, its permeability and flow factors, and how much of a fluid "
            "leaks.",
            _FLUID,
            first=((VISCOSITY, "1 mPa s"), (PRESSURE_DIFFERENCE, "1 bar")),
        ),
    ),
    shares_contacts=True,
)  # fmt: skip
