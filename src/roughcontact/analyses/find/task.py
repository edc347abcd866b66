"""The task ``find``: the loads at which a contact has requested values."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from roughcontact import units
from roughcontact.formats import export
from roughcontact.halfspace.boundary import Boundary
from roughcontact.request import options, parsing
from roughcontact.request.options import Option
from roughcontact.request.outcome import Outcome, TaskContext, last_contact
from roughcontact.request.request import Request
from roughcontact.request.task import Analysis, Task

SHARES = parsing.Parser(units.shares, "SHARES")
CONTACT = Option.value("contact-fraction", SHARES, 'Contact fraction(s) to reach: "1 %, 5 %".')
SATURATED = Option.value(
    "saturated-fraction", SHARES, 'Saturated part of the contact to reach: "1 %".'
)
APPROACH = Option.value(
    "approach", parsing.lengths, 'Approach(es) from first contact to reach: "1 um".'
)
MEAN_GAP = Option.value("mean-gap", parsing.lengths, 'Mean gap(s) to reach: "0.5 um".')
FIRST_YIELD = Option.flag("first-yield", "Load of first yield of either body (elastic contact).")
OUTPUT = Option.output("Table of results", export.TABLES)
_WANTED: tuple[Option[Any], ...] = (CONTACT, SATURATED, APPROACH, MEAN_GAP, FIRST_YIELD)


def _run(request: Request, work: TaskContext) -> Outcome:
    from roughcontact.analyses.find.model import find_load

    loads = find_load(
        work.maps[0],
        **request.arguments(work.maps),
        **{option.argument: request[option] for option in _WANTED},
        progress=work.look,
    )
    largest = loads.largest if loads.base else work.add_calibrated(loads.largest)
    answers = tuple(
        replace(item, result=largest) if item.result is loads.largest else item
        for item in loads.answers
    )
    loads = replace(loads, answers=answers, extra_cautions=work.extra_cautions)
    return Outcome(request, loads, replace(largest, extra_cautions=work.extra_cautions))


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
    short_help="contact-fraction saturated-fraction mean-gap approach first-yield material "
    "ceiling missing output report",
    run=_run,
    rules=(options.Rule(options.ANY_OF, *_WANTED),),
    last=last_contact,
    memory=_memory,
    questions=(
        Analysis(
            "Load search",
            "Load for a given contact area, gap or approach, or for first yield.",
            _WANTED,
            initial=((CONTACT, "5 %"),),
        ),
    ),
    presentations={"LoadSearch": "analyses.find.report:SearchPresentation"},
)
