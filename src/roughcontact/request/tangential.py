"""The task ``tangential``: stick, slip and stiffness under a tangential force."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from typing import Any

from roughcontact.errors import InputError
from roughcontact.halfspace.boundary import Boundary
from roughcontact.request import options, solve
from roughcontact.request.contacts import FRICTION
from roughcontact.request.options import (
    LENGTH,
    NEEDED,
    ONE_OF,
    PICTURES,
    Option,
    Panel,
    Rule,
    file,
    flag,
)
from roughcontact.request.outcome import Outcome, Work, last_contact
from roughcontact.request.request import Request
from roughcontact.request.subsurface_stress import DIRECTION
from roughcontact.request.task import Question, Task
from roughcontact.units import parse

# Maps of the tangential solver beside the contact: two spectra, three symbols, some fields.
_HELD = 16


def _forces(text: str, argument: str) -> tuple[str, ...]:
    """Return forces, or line loads of a profile, as texts that have been read once."""
    parts = tuple(part.strip() for part in text.split(","))
    for part in parts:
        with suppress(InputError):
            parse(part, "line load", argument, positive=False)
            continue
        parse(part, "force", argument, positive=False)
    return parts


FORCE = Option(
    "force", Panel.BODIES, "FORCES",
    'Tangential force, or several in turn: "0.05 N, -0.05 N".', _forces, None,
)  # fmt: skip
SHIFT = Option(
    "shift", Panel.BODIES, "LENGTH", 'Rigid tangential shift, instead of a force: "20 nm".',
    LENGTH, None,
)  # fmt: skip
OUTPUT = file(
    "output", "FILE.nc|csv|json", "Maps (NetCDF) or table of the steps.", (".nc", ".csv", ".json")
)
FIGURE = file("figure", "FILE", "Figure of traction, slip and curve (PNG, SVG or PDF).", PICTURES)
STRESS = flag("stress", Panel.BODIES, "Also compute subsurface stress and Ruiz parameters.")
_ASKED: tuple[Option[Any], ...] = (FRICTION, FORCE, SHIFT, DIRECTION, STRESS)


def _run(request: Request, work: Work) -> Outcome:
    from roughcontact.joint.tangential import tangential

    if not request.pair(work.maps).is_profile:
        Boundary(request[options.BOUNDARY]).require_tangential()
    contact = solve.contact(request, work, calibrated=False)
    contact = replace(contact, extra_cautions=work.extra_cautions)
    if not contact.converged:
        return Outcome(request, contact, contact)
    work.say("tangential loading")
    result = tangential(contact, **{option.argument: request[option] for option in _ASKED})
    return Outcome(request, result, result.solution)


def _memory(request: Request, shape: tuple[int, int]) -> None:
    from roughcontact.contact.subsurface_stress import require_memory

    request.require_contact(shape, _HELD)
    if request[STRESS]:
        require_memory(shape, boundary=request[options.BOUNDARY], partial_slip=True)


TASK = Task(
    "tangential",
    """Compute stick, slip and shift under a tangential force.

Several forces are applied in turn, such as a cycle of fretting.

\b
Example:
roughcontact tangential ground.x3p --load "100 MPa" --boundary periodic \\
    --material 42CrMo4 --friction 0.15 --force "0.05 N" --report slip.html
""",
    (
        *options.MAP, *options.LOADS, *options.BODIES, *_ASKED, *options.SOLVER, OUTPUT,
        options.REPORT, FIGURE, *options.SHOWN,
    ),
    (
        options.LOAD, FRICTION, FORCE, SHIFT, options.MATERIAL, options.COUNTER_MATERIAL,
        options.BOUNDARY, options.MISSING, OUTPUT, options.REPORT,
    ),
    run=_run,
    rules=(
        *options.LOAD_RULES,
        Rule(NEEDED, FRICTION, text="a coefficient such as 0.15"),
        Rule(ONE_OF, FORCE, SHIFT, text="0.05 N"),
    ),
    last=last_contact,
    memory=_memory,
    questions=(
        Question(
            "Tangential loading",
            "Shift, stick and slip of this contact under a tangential force.",
            _ASKED,
            first=((FRICTION, "0.15"),),
        ),
    ),
)  # fmt: skip
