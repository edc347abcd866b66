"""The task ``law``: the law of an interface."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from roughcontact.analyses.law.formats import LAW_FORMATS
from roughcontact.errors import ArgumentRef, InputError
from roughcontact.formats import export
from roughcontact.request import contacts as joints, options
from roughcontact.request.contacts import JointContacts
from roughcontact.request.options import Option
from roughcontact.request.outcome import Outcome, TaskContext, last_contact
from roughcontact.request.request import Request
from roughcontact.request.task import Analysis, Task

if TYPE_CHECKING:
    from roughcontact.analyses.law.model import InterfaceLaw
    from roughcontact.contact.result import ContactResult

QUARTERS = Option.flag(
    "quarters", "Repeat on map quarters to check the map size.", options.Panel.MAP
)
OUTPUT = Option.output(f"Law: {export.list_formats(LAW_FORMATS)}", LAW_FORMATS.suffixes)
FIGURE = Option.figure("the law")
_CONDUCTORS = (joints.CONDUCTIVITY, joints.COUNTER_CONDUCTIVITY, joints.THERMAL_FILM)


def _run(request: Request, work: TaskContext) -> Outcome:
    from roughcontact.analyses.law.model import LAW_NAME
    from roughcontact.surface.placement import partition

    contacts = JointContacts.from_request(request, work)
    contacts.require_map(LAW_NAME)
    maps = list(contacts.iter_maps())
    result = maps[0].with_variants(_law_of(request, maps))
    if request[QUARTERS]:
        level = request[options.LEVEL]
        parts = [
            item.replace_map(part) for item in maps for part in partition(item.maps[0], 2, level)
        ]
        result = replace(result, parts=_law_of(request, parts))
    return joints.outcome(request, work, result)


def _law_of(request: Request, maps: Sequence[JointContacts]) -> InterfaceLaw:
    """Return the law of some maps, with an unloading branch if points are saturated."""
    from roughcontact.analyses.history.model import indented_surface
    from roughcontact.analyses.law.model import interface_law

    remaining: list[JointContacts] = []
    flowed: list[bool] = []
    loads = joints.loads(request)

    def loading() -> Iterator[ContactResult]:
        for item in maps:
            # The first contact is under the largest load.
            for number, result in enumerate(item.solve_loads(loads)):
                if number == 0:
                    remaining.append(item.replace_map(indented_surface(result)))
                    flowed.append(result.saturated_fraction > 0)
                yield result

    def unloading() -> Iterator[ContactResult]:
        # Saturated points stay elastic up to the largest load, at any ceiling.
        elastic = replace(request, values={**request.values, options.CEILING.name: None})
        for item in remaining if any(flowed) else ():
            yield from replace(item, request=elastic).solve_loads(loads)

    body, counter_body = joints.conductors(request)
    both = body.conductivity is not None and counter_body.conductivity is not None
    return interface_law(
        loading(),
        unloading(),
        conductor=body if both else None,
        counter_conductor=counter_body if both else None,
        thermal_film=request[joints.THERMAL_FILM] or 0.0,
        friction=request[joints.FRICTION],
    )


def _check(request: Request) -> None:
    joints.check_pressures(request)
    for option in (options.COUNTER_SURFACE, options.COUNTER_BODY):
        if len(request.files) > 1 and request.is_given(option):
            raise InputError(
                "needs a single map; several maps are pressed by a flat", argument=option.argument
            )
    known = all(body.conductivity is not None for body in joints.conductors(request))
    if request[joints.THERMAL_FILM] and not known:
        raise InputError(
            f"needs {ArgumentRef('conductivity')} and {ArgumentRef('counter_conductivity')}",
            argument="thermal_film",
        )


TASK = Task(
    "law",
    """Compute the pressure-separation law; write Abaqus/CalculiX decks.

Several files are maps of one surface; the mean and its 95 % interval are reported. Above the
ceiling, unloading is a separate branch.

\b
Example:
roughcontact law ground-?.x3p --from "30 MPa" --to "300 MPa" \\
    --boundary periodic --material 42CrMo4 --output law.inp
""",
    (
        QUARTERS,
        *options.MAP,
        *joints.RANGE,
        *options.MATERIALS,
        joints.FRICTION,
        *_CONDUCTORS,
        *joints.CONTACT,
        OUTPUT,
        FIGURE,
        *options.OUTPUT,
    ),
    short_help="from to steps material friction ceiling boundary missing output report",
    run=_run,
    rules=(
        *joints.PRESSURE_RULES,
        *joints.FACE_RULES,
        options.Rule(options.EXCLUDES, QUARTERS, options.COUNTER_MAPS),
    ),
    check=_check,
    last=last_contact,
    questions=(
        Analysis(
            "Interface law",
            "Separation, contact and stiffness over pressure, with tables for other programs.",
            (*joints.RANGE, QUARTERS),
            initial=joints.SHORT_RANGE,
        ),
    ),
    maps=("file", "files"),
    shares_contacts=True,
    uncoated="the unloaded faces of a law are indented, and their layers are not followed",
    presentations={"InterfaceLaw": "analyses.law.report:LawPresentation"},
)
