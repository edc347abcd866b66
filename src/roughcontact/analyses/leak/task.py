"""The task ``leak``: leakage through the gap of a contact."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from roughcontact import units
from roughcontact.errors import InputError
from roughcontact.request import contacts as joints, options, parsing
from roughcontact.request.options import LENGTH, PICTURES, PRESSURE, Option, Panel, file_option
from roughcontact.request.outcome import Outcome, TaskContext, last_contact
from roughcontact.request.request import Request
from roughcontact.request.task import Analysis, Task

if TYPE_CHECKING:
    from roughcontact.analyses.leak.model import Seal
    from roughcontact.surface.surface import Surface

FLOW_AXIS = Option(
    "flow-axis",
    Panel.BODIES,
    "y|x",
    "Flow axis, y or x; default: both.",
    parsing.choice("y", "x"),
    None,
)
VISCOSITY = Option(
    "viscosity",
    Panel.BODIES,
    "VISCOSITY",
    'Dynamic viscosity: "1 mPa s".',
    parsing.quantity("viscosity"),
    None,
)
PRESSURE_DIFFERENCE = Option(
    "pressure-difference",
    Panel.BODIES,
    "PRESSURE",
    'Inlet minus outlet pressure: "1 bar".',
    PRESSURE,
    None,
)
SEAL_WIDTH = Option(
    "seal-width",
    Panel.BODIES,
    "LENGTH",
    "Seal face width across the flow; default: map.",
    LENGTH,
    None,
)
SEAL_LENGTH = Option(
    "seal-length",
    Panel.BODIES,
    "LENGTH",
    "Seal face length along the flow (land); default: map.",
    LENGTH,
    None,
)
RING = Option(
    "ring",
    Panel.BODIES,
    "LENGTH",
    'Mean diameter of a ring-shaped seal face: "40 mm".',
    LENGTH,
    None,
)
GAS = Option(
    "gas",
    Panel.BODIES,
    "GAS",
    "Gas that leaks: air, nitrogen, helium or argon.",
    parsing.choice("air", "nitrogen", "helium", "argon"),
    None,
)
INLET = Option(
    "inlet",
    Panel.BODIES,
    "PRESSURE",
    'Absolute pressure of the gas at the inlet: "2 bar".',
    PRESSURE,
    None,
)
OUTLET = Option(
    "outlet",
    Panel.BODIES,
    "PRESSURE",
    'Absolute pressure of the gas at the outlet: "1 mbar".',
    PRESSURE,
    None,
)
FIGURE = file_option("figure", "FILE", "Figure of gap and flow (PNG, SVG or PDF).", PICTURES)
_SEAL: tuple[Option[Any], ...] = (
    VISCOSITY,
    PRESSURE_DIFFERENCE,
    SEAL_WIDTH,
    SEAL_LENGTH,
    RING,
    GAS,
    INLET,
    OUTLET,
    joints.TEMPERATURE,
)
_FLUID = (FLOW_AXIS, *_SEAL)


def _run(request: Request, work: TaskContext) -> Outcome:
    from roughcontact.analyses.leak.model import LEAKAGE_NAME, leakage

    contacts = joints.JointContacts.from_request(request, work)
    contacts.require_map(LEAKAGE_NAME)
    loads = joints.loads(request)
    relief = _fluid_load(request, contacts.maps, loads)
    fluid = {option.argument: request[option] for option in _FLUID}
    result = contacts.over_draws(lambda pair: leakage(pair.solve_loads(loads, relief), **fluid))
    return joints.outcome(request, work, result.with_fluid_load(relief) if relief else result)


def _fluid_load(request: Request, maps: Sequence[Surface], loads: Sequence[Any]) -> float:
    """Return the load that the fluid carries [N]; 0 if it is a negligible share."""
    from roughcontact.analyses.leak.model import MIN_FLUID_SHARE

    seal = _seal(request)
    if seal is None:
        return 0.0
    height, width = request.pair(maps).size
    load = float(seal.mean_pressure * height * width)
    smallest = min(request.force(maps, load)[0] for load in loads)
    if load >= smallest:
        mean = units.format_engineering(seal.mean_pressure, "Pa", 3)
        raise InputError(
            f"is too small: the mean pressure of the fluid, {mean}, lifts the bodies",
            argument="load",
        )
    return load if load > MIN_FLUID_SHARE * smallest else 0.0


def _memory(request: Request, shape: tuple[int, int]) -> None:
    """Raise an error if the flows need more than the available memory."""
    # Maps in addition to the contact: the flow along each axis needs at most 250 bytes per point,
    # the flow of a gas 330.
    request.require_contact(shape, 64 if request[GAS] is None else 84)


def _seal(request: Request) -> Seal | None:
    from roughcontact.analyses.leak.model import seal_of

    return seal_of(*(request[option] for option in _SEAL))


def _check(request: Request) -> None:
    joints.check_loads(request)
    _seal(request)


TASK = Task(
    "leak",
    """Compute leak rate, permeability and flow factors of the gap.

Without a fluid only permeability is reported.

\b
Example:
roughcontact leak ground.x3p --load "30 MPa, 100 MPa" --boundary periodic \\
    --material 42CrMo4 --gas helium --inlet "2 bar" --outlet "1 mbar"
""",
    (
        *options.MAP,
        joints.LOAD,
        *joints.RANGE,
        *options.MATERIALS,
        *options.COATINGS,
        *_FLUID,
        *options.SHAPES,
        *joints.FACES,
        options.CEILING,
        options.BOUNDARY,
        *options.SOLVER,
        joints.OUTPUT,
        FIGURE,
        *options.OUTPUT,
    ),
    (
        joints.LOAD,
        VISCOSITY,
        PRESSURE_DIFFERENCE,
        GAS,
        INLET,
        OUTLET,
        RING,
        options.MATERIAL,
        options.BOUNDARY,
        options.REPORT,
    ),
    run=_run,
    rules=(*joints.LOAD_RULES, *joints.FACE_RULES),
    check=_check,
    last=last_contact,
    memory=_memory,
    questions=(
        Analysis(
            "Leakage",
            "Open paths through the gap, permeability, flow factors and leak rate.",
            _FLUID,
            short_help=((VISCOSITY, "1 mPa s"), (PRESSURE_DIFFERENCE, "1 bar")),
        ),
    ),
    shares_contacts=True,
    presentations={"Leakage": ("analyses.leak.report:KIND",)},
)
