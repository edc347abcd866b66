"""The task ``leak``: leakage through the gap of a contact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from roughcontact.request import contacts as joints, options, parsing
from roughcontact.request.options import LENGTH, PRESSURE, Option
from roughcontact.request.outcome import Outcome, TaskContext, last_contact
from roughcontact.request.request import Request
from roughcontact.request.task import Analysis, Task

if TYPE_CHECKING:
    from roughcontact.analyses.leak.model import Leakage, Seal
    from roughcontact.surface.surface import Surface

FLOW_AXIS = Option.value("flow-axis", parsing.choice("y", "x"), "Flow axis, y or x; default: both.")
VISCOSITY = Option.value(
    "viscosity", parsing.quantity("viscosity"), 'Dynamic viscosity: "1 mPa s".'
)
PRESSURE_DIFFERENCE = Option.value(
    "pressure-difference", PRESSURE, 'Inlet minus outlet pressure: "1 bar".'
)
SEAL_WIDTH = Option.value("seal-width", LENGTH, "Seal face width across the flow; default: map.")
SEAL_LENGTH = Option.value(
    "seal-length", LENGTH, "Seal face length along the flow (land); default: map."
)
RING = Option.value("ring", LENGTH, 'Mean diameter of a ring-shaped seal face: "40 mm".')
GAS = Option.value(
    "gas",
    parsing.choice("air", "nitrogen", "helium", "argon").with_metavar("GAS"),
    "Gas that leaks: air, nitrogen, helium or argon.",
)
INLET = Option.value("inlet", PRESSURE, 'Absolute pressure of the gas at the inlet: "2 bar".')
OUTLET = Option.value("outlet", PRESSURE, 'Absolute pressure of the gas at the outlet: "1 mbar".')
FIGURE = Option.figure("gap and flow")
_FACE: tuple[Option[Any], ...] = (SEAL_WIDTH, SEAL_LENGTH, RING)
_SEAL = (VISCOSITY, PRESSURE_DIFFERENCE, *_FACE, GAS, INLET, OUTLET, joints.TEMPERATURE)
_FLUID = (FLOW_AXIS, *_SEAL)


def _run(request: Request, work: TaskContext) -> Outcome:
    from roughcontact.analyses.leak.model import LEAKAGE_NAME

    contacts = joints.JointContacts.from_request(request, work)
    contacts.require_map(LEAKAGE_NAME)
    return joints.outcome(request, work, contacts.by_ceiling(_leakage))


def _leakage(contacts: joints.JointContacts) -> Leakage:
    """Return the leakage of contacts under one ceiling."""
    from roughcontact.analyses.leak.model import AXES, flow_axes, leakage, require_land

    request = contacts.request
    require_land(_seal(request), request.pair(contacts.maps), flow_axes(request[FLOW_AXIS]))
    loads = joints.loads(request)
    fluid = {option.argument: request[option] for option in _FLUID}

    def along(axes: str | None, contacts: joints.JointContacts) -> Any:
        requested = fluid | {FLOW_AXIS.argument: axes}
        return contacts.over_draws(lambda pair: leakage(pair.solve_loads(loads), **requested))

    axes: list[str | None] = [request[FLOW_AXIS]]
    if not _carries_load(request, contacts.maps, loads):
        return along(axes[0], contacts)
    # Unless it is uniform, the pressure of a fluid along y opens another gap than along x.
    if axes == [None] and request.pair(contacts.maps).boundary.free_axes:
        axes = list(AXES)
    results = [along(axis, _with_fluid(contacts, axis)) for axis in axes]
    return results[0].with_axis(results[1]) if len(results) > 1 else results[0]


def _with_fluid(contacts: joints.JointContacts, axis: str | None) -> joints.JointContacts:
    """Return contacts of which the fluid carries a part of the load."""
    from roughcontact.analyses.leak.fluid_load import solve_with_fluid
    from roughcontact.analyses.leak.model import AXES

    seal, work = _seal(contacts.request), contacts.work
    assert seal is not None
    solve = solve_with_fluid(work.solve, AXES.index(axis or "y"), seal.mean_pressure, seal.excess)
    return replace(contacts, work=replace(work, solve=solve))


def _carries_load(request: Request, maps: Sequence[Surface], loads: Sequence[Any]) -> bool:
    """Return whether the fluid carries a relevant share of the smallest load."""
    from roughcontact.analyses.leak.fluid_load import nominal_contact, require_solid_load
    from roughcontact.analyses.leak.model import MIN_FLUID_SHARE

    seal = _seal(request)
    if seal is None:
        return False
    pair = request.pair(maps)
    load = min(request.force(pair, load)[0] for load in loads)
    contact = nominal_contact(pair, load, request[options.CEILING])
    share = 1.0 if contact is None else float(contact.mean())
    carried = seal.mean_pressure * pair.size[0] * pair.size[1] * share
    require_solid_load(carried, load)
    return carried > MIN_FLUID_SHARE * load


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
        *joints.CONTACT,
        joints.OUTPUT,
        FIGURE,
        *options.OUTPUT,
    ),
    short_help="load viscosity pressure-difference gas inlet outlet ring material boundary report",
    run=_run,
    rules=(
        *joints.LOAD_RULES,
        *joints.FACE_RULES,
        options.Rule(options.NEEDS, joints.TEMPERATURE, GAS),
    ),
    check=_check,
    last=last_contact,
    memory=_memory,
    questions=(
        Analysis(
            "Leak of a liquid",
            "Open paths through the gap, permeability, flow factors and leak rate.",
            (*joints.RANGE, VISCOSITY, PRESSURE_DIFFERENCE, RING),
            initial=(*joints.SHORT_RANGE, (VISCOSITY, "1 mPa s"), (PRESSURE_DIFFERENCE, "1 bar")),
            folded=(SEAL_WIDTH, SEAL_LENGTH, FLOW_AXIS),
        ),
        Analysis(
            "Leak of a gas",
            "Leak rate of a gas, which slips along walls that are closer than its free path.",
            (*joints.RANGE, GAS, INLET, OUTLET),
            initial=(*joints.SHORT_RANGE, (GAS, "helium"), (INLET, "2 bar"), (OUTLET, "1 bar")),
            folded=(joints.TEMPERATURE, RING, SEAL_WIDTH, SEAL_LENGTH, FLOW_AXIS),
        ),
    ),
    shares_contacts=True,
    presentations={"Leakage": "analyses.leak.report:LeakagePresentation"},
)
