"""The task ``leak``: what leaks through the gap of a contact."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from roughcontact.request import parsing
from roughcontact.request.option import BODIES, LENGTH, OUTPUT, PICTURES, Option
from roughcontact.request.task import Asked, Question, Task

if TYPE_CHECKING:
    from roughcontact.joint.leakage import Leakage

NAME = "leak"


def _check(request: Asked) -> None:
    from roughcontact.joint.leakage import seal_of

    seal_of(*(request[name] for name in _FLUID[1:]))


def _run(request: Asked, contacts: Any) -> Leakage:
    from roughcontact.joint.leakage import OF, leakage

    contacts.require_map(OF)
    found = leakage(
        contacts.under(request.loads), **{name.replace("-", "_"): request[name] for name in _FLUID}
    )
    coarser = contacts.coarser(found.largest)
    return found if coarser is None else found.beside(coarser)


_OPTIONS = (
    Option(
        "direction", BODIES, "y|x", "Along which the fluid flows; default: both.",
        parsing.choice("y", "x"),
    ),
    Option(
        "viscosity", BODIES, "VISCOSITY", 'Viscosity of the fluid, such as "1 mPa s".',
        parsing.quantity("viscosity"),
    ),
    Option(
        "pressure-difference", BODIES, "PRESSURE", 'Between inlet and outlet, such as "1 bar".',
        parsing.quantity("pressure"),
    ),
    Option(
        "seal-width", BODIES, "LENGTH",
        "Of the face that leaks, across the flow: of a ring its circumference; default: that of "
        "the map.", LENGTH,
    ),
    Option(
        "seal-length", BODIES, "LENGTH",
        "Of the face that leaks, along the flow; default: that of the map.", LENGTH,
    ),
    Option(
        "figure", OUTPUT, "FILE", "Draw the gap and what flows through it as PNG, SVG or PDF.",
        parsing.path, suffixes=PICTURES,
    ),
)  # fmt: skip
_FLUID = ("direction", "viscosity", "pressure-difference", "seal-width", "seal-length")

TASK = Task(
    NAME,
    """Find what leaks through the gap under one load or several, and the flow factors.

Whether a way leads through is found first. The rate needs a fluid; without one it is told how
permeable the gap is.

\b
Example:
roughcontact leak ground.opd --load "1 N, 3 N" --material 42CrMo4 \\
    --holes fill --boundary periodic --viscosity "1 mPa s" \\
    --pressure-difference "1 bar"
""",
    _OPTIONS,
    common=("load", *_FLUID, "material", "boundary", "holes", "report"),
    run=_run,
    check=_check,
    # Maps that a flow through the gap takes beside the contact, at most 250 bytes a point.
    held=32,
    question=Question(
        "What leaks through it",
        "Whether the gap is open, its permeability and flow factors, and how much of a fluid "
        "leaks.",
        _FLUID,
        first=(("viscosity", "1 mPa s"), ("pressure-difference", "1 bar")),
    ),
)  # fmt: skip
