"""The task ``leak``: what leaks through the gap of a contact."""

from __future__ import annotations

from typing import Any

from roughcontact.request import contacts as joints, options, parsing
from roughcontact.request.options import LENGTH, PICTURES, PRESSURE, Option, Panel, file
from roughcontact.request.outcome import Outcome, Work, last_contact
from roughcontact.request.request import Request
from roughcontact.request.task import Question, Task

FLOW_AXIS = Option(
    "flow-axis", Panel.BODIES, "y|x", "Flow axis, y or x; default: both.",
    parsing.choice("y", "x"), None,
)  # fmt: skip
VISCOSITY = Option(
    "viscosity", Panel.BODIES, "VISCOSITY", 'Dynamic viscosity: "1 mPa s".',
    parsing.quantity("viscosity"), None,
)  # fmt: skip
PRESSURE_DIFFERENCE = Option(
    "pressure-difference", Panel.BODIES, "PRESSURE", 'Inlet minus outlet pressure: "1 bar".',
    PRESSURE, None,
)  # fmt: skip
SEAL_WIDTH = Option(
    "seal-width", Panel.BODIES, "LENGTH",
    "Seal face width across the flow (ring: circumference); default: map.", LENGTH, None,
)  # fmt: skip
SEAL_LENGTH = Option(
    "seal-length", Panel.BODIES, "LENGTH",
    "Seal face length along the flow (land); default: map.", LENGTH, None,
)  # fmt: skip
FIGURE = file("figure", "FILE", "Figure of gap and flow (PNG, SVG or PDF).", PICTURES)
_SEAL: tuple[Option[Any], ...] = (VISCOSITY, PRESSURE_DIFFERENCE, SEAL_WIDTH, SEAL_LENGTH)
_FLUID = (FLOW_AXIS, *_SEAL)


def _run(request: Request, work: Work) -> Outcome:
    from roughcontact.joint.leakage import OF, leakage

    contacts = joints.Contacts(request, work, work.maps)
    contacts.require_map(OF)
    result = leakage(
        contacts.under(joints.loads(request)),
        **{option.argument: request[option] for option in _FLUID},
    )
    return joints.outcome(request, work, contacts.with_variants(result))


def _check(request: Request) -> None:
    from roughcontact.joint.leakage import seal_of

    joints.check_loads(request)
    seal_of(*(request[option] for option in _SEAL))


TASK = Task(
    "leak",
    """Compute leak rate, permeability and flow factors of the gap.

Without a fluid only permeability is reported.

\b
Example:
roughcontact leak ground.x3p --load "30 MPa, 100 MPa" --boundary periodic \\
    --material 42CrMo4 --viscosity "1 mPa s" --pressure-difference "1 bar"
""",
    (
        *options.MAP, joints.LOAD, *joints.RANGE, *options.MATERIALS,
        *options.COATINGS, *_FLUID, *options.SHAPES,
        options.CEILING, options.BOUNDARY, *options.SOLVER, joints.OUTPUT, FIGURE, *options.OUTPUT,
    ),
    (joints.LOAD, *_FLUID, options.MATERIAL, options.BOUNDARY, options.MISSING, options.REPORT),
    run=_run,
    rules=joints.LOAD_RULES,
    check=_check,
    last=last_contact,
    # Maps that the flows along both axes take beside the contact, at most 250 bytes a point each.
    held=64,
    questions=(
        Question(
            "Leakage",
            "Open paths through the gap, permeability, flow factors and leak rate.",
            _FLUID,
            first=((VISCOSITY, "1 mPa s"), (PRESSURE_DIFFERENCE, "1 bar")),
        ),
    ),
    shares_contacts=True,
)  # fmt: skip
