"""The task ``conductance``: electrical and thermal resistance of a contact."""

from __future__ import annotations

from typing import TYPE_CHECKING

from roughcontact.errors import ArgumentRef, InputError
from roughcontact.halfspace.boundary import Boundary
from roughcontact.request import contacts as joints, options, parsing
from roughcontact.request.options import PRESSURE, Option
from roughcontact.request.outcome import Outcome, TaskContext, last_contact
from roughcontact.request.parsing import quantity
from roughcontact.request.request import Request
from roughcontact.request.task import Analysis, Task

if TYPE_CHECKING:
    from roughcontact.analyses.conductance.model import Conductance

ELECTRICAL_FILM = Option.value(
    "electrical-film",
    quantity("film"),
    'Electrical film resistance × area: "1e-12 ohm m^2"; default: none.',
)
GAP = Option.value(
    "gap",
    parsing.as_text.with_metavar("FLUID"),
    'Fluid in the gap: air, helium, vacuum, oil, grease or "0.2 W/m/K"; default: none.',
)
GAP_PRESSURE = Option.value(
    "gap-pressure", PRESSURE, 'Pressure of a gas in the gap: "1 mbar"; default: 1 bar.'
)
CURRENT = Option.value(
    "current", quantity("current"), 'Current through the contact: "10 A"; default: none.'
)
FIGURE = Option.figure("resistance versus load")
_CONDUCTORS = (
    joints.RESISTIVITY,
    joints.CONDUCTIVITY,
    joints.COUNTER_RESISTIVITY,
    joints.COUNTER_CONDUCTIVITY,
    ELECTRICAL_FILM,
    joints.THERMAL_FILM,
    GAP,
    GAP_PRESSURE,
    joints.TEMPERATURE,
    CURRENT,
)


def _run(request: Request, work: TaskContext) -> Outcome:
    from roughcontact.analyses.conductance.model import SUBJECT, conductance

    contacts = joints.JointContacts.from_request(request, work)
    contacts.require_map(SUBJECT)
    loads = joints.loads(request)

    def compute(pair: joints.JointContacts) -> Conductance:
        return conductance(
            pair.solve_loads(loads),
            *joints.conductors(request),
            electrical_film=request[ELECTRICAL_FILM] or 0.0,
            thermal_film=request[joints.THERMAL_FILM] or 0.0,
            gap=request[GAP],
            gap_pressure=request[GAP_PRESSURE],
            temperature=request[joints.TEMPERATURE],
            current=request[CURRENT],
        )

    result = contacts.by_ceiling(lambda pairs: pairs.over_draws(compute))
    return joints.outcome(request, work, result)


def _check(request: Request) -> None:
    joints.check_loads(request)
    if (gap := request[GAP]) is not None:
        from roughcontact.analyses.conductance.model import filling_of

        filling_of(gap, request[GAP_PRESSURE], request[joints.TEMPERATURE])
        if request[options.BOUNDARY] != Boundary.PERIODIC:
            raise InputError("needs ", ArgumentRef("boundary", "periodic"), argument="gap")
    bodies = joints.conductors(request)
    kinds = ("resistivity", "conductivity")
    known = [all(getattr(body, kind) is not None for body in bodies) for kind in kinds]
    if not any(known):
        lacking, material = joints.CONDUCTIVITY, options.MATERIAL
        if bodies[0].conductivity is not None:
            lacking, material = joints.COUNTER_CONDUCTIVITY, options.COUNTER_MATERIAL
        named, example = request[material], ArgumentRef(lacking.argument, "46 W/m/K")
        if named is None:
            advice = f"give {example} or {ArgumentRef(material.argument, 'Cu-ETP')}"
        else:
            advice = f"{named.name} has none in the catalog; give it, such as {example}"
        raise InputError(f"is needed: {advice}", argument=lacking.argument)
    films = ELECTRICAL_FILM, joints.THERMAL_FILM, CURRENT, GAP
    for film, kind, there in zip(films, 2 * kinds, 2 * known, strict=True):
        if request[film] and not there:
            raise InputError(
                f"needs {ArgumentRef(kind)} and {ArgumentRef(f'counter_{kind}')}",
                argument=film.argument,
            )


TASK = Task(
    "conductance",
    """Compute thermal and electrical contact conductance.

\b
Example:
roughcontact conductance ground.x3p --load "20 MPa, 50 MPa" \\
    --boundary periodic --material 42CrMo4 --counter-material Cu-ETP
""",
    (
        *options.MAP,
        joints.LOAD,
        *joints.RANGE,
        *options.MATERIALS,
        *_CONDUCTORS,
        *options.COATINGS,
        *joints.CONTACT,
        joints.OUTPUT,
        FIGURE,
        *options.OUTPUT,
    ),
    short_help="load material counter-material conductivity counter-conductivity gap boundary "
    "missing output report",
    run=_run,
    rules=(
        *joints.LOAD_RULES,
        *joints.FACE_RULES,
        options.Rule(options.NEEDS, GAP_PRESSURE, GAP),
        options.Rule(options.NEEDS, joints.TEMPERATURE, GAP),
    ),
    check=_check,
    last=last_contact,
    held=2,
    questions=(
        Analysis(
            "Conductance",
            "Electrical and thermal resistance of the whole contact.",
            (*joints.RANGE, CURRENT, GAP, joints.TEMPERATURE),
            initial=joints.SHORT_RANGE,
            folded=tuple(
                option for option in _CONDUCTORS if option not in (CURRENT, GAP, joints.TEMPERATURE)
            ),
        ),
    ),
    shares_contacts=True,
    presentations={"Conductance": "analyses.conductance.report:ConductancePresentation"},
)
