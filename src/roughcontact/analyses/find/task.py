"""The task ``find``: the loads at which a contact has requested values."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from roughcontact import units
from roughcontact.halfspace.boundary import Boundary
from roughcontact.request import options, parsing
from roughcontact.request.outcome import Outcome, TaskContext, last_contact
from roughcontact.request.request import Request
from roughcontact.request.task import Analysis, Task

CONTACT = options.Option(
    "contact-fraction", "SHARES", 'Contact fraction(s) to reach: "1 %, 5 %".', units.shares, None
)
SATURATED = options.Option(
    "saturated-fraction",
    "SHARES",
    'Saturated part of the contact to reach: "1 %".',
    units.shares,
    None,
)
APPROACH = options.Option(
    "approach",
    "LENGTHS",
    'Approach(es) from first contact to reach: "1 um".',
    parsing.lengths,
    None,
)
MEAN_GAP = options.Option(
    "mean-gap", "LENGTHS", 'Mean gap(s) to reach: "0.5 um".', parsing.lengths, None
)
FIRST_YIELD = options.flag_option(
    "first-yield", "Load of first yield of either body (elastic contact)."
)
OUTPUT = options.file_option("output", "FILE.csv|json", "Table of results.", options.TABLES)
_WANTED: tuple[options.Option[Any], ...] = (CONTACT, SATURATED, APPROACH, MEAN_GAP, FIRST_YIELD)


def _run(request: Request, work: TaskContext) -> Outcome:
    from roughcontact.analyses.find.model import find_load

    loads = find_load(
        work.maps[0],
        **request.arguments(work.maps, *options.SOLVER_DOUBLE),
        **{option.argument: request[option] for option in _WANTED},
        progress=work.look,
    )
    largest = replace(loads.largest, extra_cautions=work.extra_cautions)
    return Outcome(request, replace(loads, extra_cautions=work.extra_cautions), largest)


def _memory(request: Request, shape: tuple[int, int]) -> None:
    from roughcontact.analyses.find import model as load_search
    from roughcontact.analyses.stress import model as subsurface_stress

    request.require_contact(shape, load_search.MAX_HELD_RESULTS)
    if request[FIRST_YIELD]:
        boundary = Boundary(request[options.BOUNDARY])
        subsurface_stress.require_memory(shape, boundary=boundary, friction=0.0)


TASK = Task(
    "find",
    """Find the load for a given contact area, gap or first yield.

\b
Example:
roughcontact find ground.x3p --contact-fraction "5 %" --mean-gap "0.3 um" \\
    --boundary periodic --material 42CrMo4 --output loads.csv
""",
    (
        *options.MAP,
        *_WANTED,
        *options.BODIES,
        *options.COATINGS,
        *options.SOLVER_DOUBLE,
        OUTPUT,
        *options.OUTPUT,
    ),
    (
        CONTACT,
        SATURATED,
        MEAN_GAP,
        APPROACH,
        FIRST_YIELD,
        options.MATERIAL,
        options.CEILING,
        options.MISSING,
        OUTPUT,
        options.REPORT,
    ),
    run=_run,
    rules=(options.Rule(options.ANY_OF, *_WANTED),),
    last=last_contact,
    memory=_memory,
    questions=(
        Analysis(
            "Load search",
            "Load for a given contact area, gap or approach, or for first yield.",
            _WANTED,
            short_help=((CONTACT, "5 %"),),
        ),
    ),
    presentations={"LoadSearch": "analyses.find.report:SearchPresentation"},
)
