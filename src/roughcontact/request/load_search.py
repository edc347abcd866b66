"""The task ``find``: the loads at which a contact has wanted values."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from roughcontact.halfspace.boundary import Boundary
from roughcontact.request import memory, options, parsing, solve_arguments
from roughcontact.request.option import ANY_OF, TABLES, Option, Panel, Rule, file, flag
from roughcontact.request.outcome import Outcome, Work, last_contact
from roughcontact.request.request import Request
from roughcontact.request.task import Question, Task

CONTACT = Option(
    "contact-fraction", Panel.BODIES, "SHARES",
    'Find the load at which this part of the map touches, such as "5 %", or several: '
    '"1 %, 5 %".', parsing.shares, None,
)  # fmt: skip
SATURATED = Option(
    "saturated-fraction", Panel.BODIES, "SHARES",
    'Find the load at which this part of the contact is at the ceiling, such as "1 %".',
    parsing.shares, None,
)  # fmt: skip
APPROACH = Option(
    "approach", Panel.BODIES, "LENGTHS",
    'Find the load of this approach from first touch, such as "1 um", or several.',
    parsing.lengths, None,
)  # fmt: skip
MEAN_GAP = Option(
    "mean-gap", Panel.BODIES, "LENGTHS",
    'Find the load at which the mean gap is this, such as "0.5 um", or several.',
    parsing.lengths, None,
)  # fmt: skip
FIRST_YIELD = flag(
    "first-yield", Panel.BODIES,
    "Find the load at which the first point of either body yields, at the surface or below "
    "it; that contact is elastic.",
)  # fmt: skip
OUTPUT = file("output", "FILE.csv|json", "Write the table of answers.", TABLES)
_WANTED: tuple[Option[Any], ...] = (CONTACT, SATURATED, APPROACH, MEAN_GAP, FIRST_YIELD)


def _run(request: Request, work: Work) -> Outcome:
    from roughcontact.studies.load_search import find_load

    loads = find_load(
        work.maps[0],
        **solve_arguments.arguments(request, work.maps, *options.SOLVER_DOUBLE),
        **{option.argument: request[option] for option in _WANTED},
        progress=work.look,
    )
    largest = replace(loads.largest, extra_cautions=work.extra_cautions)
    return Outcome(request, replace(loads, extra_cautions=work.extra_cautions), largest)


def _memory(request: Request, shape: tuple[int, int]) -> None:
    from roughcontact.contact import subsurface_stress
    from roughcontact.studies import load_search

    memory.require_contact(request, shape, load_search.HELD)
    if request[FIRST_YIELD]:
        boundary = Boundary(request[options.BOUNDARY])
        subsurface_stress.require_memory(shape, boundary=boundary, friction=0.0)


TASK = Task(
    "find",
    """Find the loads at which a contact has the values asked for, each with its bracket.

\b
Example:
roughcontact find ground.opd --contact-fraction "5 %" --first-yield \\
    --material 100Cr6 --missing fill --output loads.csv
""",
    (
        *options.MAP, *_WANTED, *options.BODIES, *options.SOLVER_DOUBLE, OUTPUT, *options.OUTPUT,
    ),
    (
        CONTACT, SATURATED, MEAN_GAP, APPROACH, FIRST_YIELD, options.MATERIAL, options.CEILING,
        options.MISSING, OUTPUT, options.REPORT,
    ),
    run=_run,
    rules=(Rule(ANY_OF, *_WANTED),),
    last=last_contact,
    memory=_memory,
    questions=(
        Question(
            "Loads that give …",
            "The load at which the contact has an area, a gap or an approach, or first yields.",
            _WANTED,
            first=((CONTACT, "5 %"),),
        ),
    ),
)  # fmt: skip
