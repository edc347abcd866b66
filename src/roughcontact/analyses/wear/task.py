"""The task ``wear``: how a finish runs in."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from roughcontact.formats import export
from roughcontact.request import options, parsing
from roughcontact.request.contacts import FRICTION
from roughcontact.request.options import Option, Rule
from roughcontact.request.outcome import Outcome, TaskContext, last_contact
from roughcontact.request.request import Request
from roughcontact.request.task import Analysis, Task

_SURFACES = export.SURFACE.suffixes


def _coefficient(name: str, text: str) -> Option[float]:
    argument = f"{name.replace('-', '_')}_coefficient"
    return Option(name, parsing.quantity("wear coefficient"), text, 0.0, arguments=(argument,))


WEAR = _coefficient(
    "wear", 'Wear coefficient, volume per load and distance: "1e-15 m2/N", "1e-6 mm3/Nm".'
)
COUNTER_WEAR = _coefficient("counter-wear", "Wear coefficient of the counter-body; default: 0.")
DISTANCE = Option.value("distance", parsing.lengths, 'Sliding distance(s): "3.5 m" or "1 m, 10 m".')
_MOTIONS = ("sliding", "fretting")
MOTION = Option(
    "motion",
    parsing.choice(*_MOTIONS),
    "On a smooth counter-body, or with slip below the asperities; default: sliding.",
    _MOTIONS[0],
)
OUTPUT = Option.output("Steps; .nc: also maps", (*export.TABLES, ".nc"))
WORN_SURFACE = Option.file(
    "worn-surface", f"Worn surface: {', '.join(_SURFACES)}.", _SURFACES, metavar="FILE"
)
WORN_COUNTER = Option.file("worn-counter-surface", "Worn counter-body.", _SURFACES, metavar="FILE")
FIGURE = Option.figure("running-in")
_PLAIN: tuple[Option[Any], ...] = (options.LOAD, DISTANCE, MOTION, FRICTION, options.FOLDER)
_ARGUMENTS = (WEAR, DISTANCE, COUNTER_WEAR, MOTION, FRICTION)
_FILES = (OUTPUT, WORN_SURFACE, WORN_COUNTER, options.FOLDER, *options.REPORTING, FIGURE)


def _run(request: Request, work: TaskContext) -> Outcome:
    from roughcontact.analyses.wear.model import FILES, wear

    arguments: dict[str, Any] = {item.arguments[0]: request[item] for item in (WEAR, COUNTER_WEAR)}
    arguments |= {item.argument: request[item] for item in _PLAIN}
    arguments |= request.arguments(work.maps)
    with work.report_saved_steps_on_interrupt(FILES, "step") as (watch, reused):
        result = wear(work.maps[0], progress=watch, **arguments)
        first = work.add_calibrated(result.first)
    last = replace(result.last, extra_cautions=work.extra_cautions)
    return Outcome(request, replace(result, first=first, last=last), last, {"reused": len(reused)})


TASK = Task(
    "wear",
    """Wear a surface in: contact and roughness over the sliding distance.

Archard's law at each point. Contact and roughness at a wear depth do not depend on the wear
coefficient; the distance does.

\b
Example:
roughcontact wear ground.x3p --load "50 MPa" --wear "1e-15 m2/N" \\
    --distance "3.5 m" --boundary periodic --material 42CrMo4 \\
    --output running-in.csv --worn-surface worn.x3p
""",
    (
        *options.MAP,
        options.LOAD,
        *_ARGUMENTS,
        *options.BODIES,
        *options.COATINGS,
        *options.SOLVER_DOUBLE,
        *_FILES,
        *options.SHOWN,
    ),
    short_help="load wear distance material young poisson yield-strength missing "
    "output worn-surface",
    run=_run,
    rules=(
        Rule(options.NEEDED, options.LOAD, text="such as '1 N' or '20 MPa'"),
        Rule(options.NEEDED, WEAR, COUNTER_WEAR, text="a wear coefficient such as '1e-15 m2/N'"),
        Rule(options.NEEDS, WORN_COUNTER, COUNTER_WEAR),
        Rule(options.NEEDS, WORN_COUNTER, MOTION, value="fretting"),
        Rule(options.NEEDED, DISTANCE, text="the sliding distance, such as '3.5 m'"),
    ),
    last=last_contact,
    held="analyses.wear.model:MAX_HELD_RESULTS",
    writes=(
        (WORN_SURFACE, lambda outcome, path: export.save_surface(outcome.result.worn, path)),
        (
            WORN_COUNTER,
            lambda outcome, path: export.save_surface(outcome.result.worn_counter, path),
        ),
    ),
    questions=(
        Analysis(
            "Wear",
            "How the surface runs in: contact, pressure and roughness over the sliding distance.",
            _ARGUMENTS,
            initial=((WEAR, "1e-15 m2/N"), (DISTANCE, "1 m")),
        ),
    ),
    presentations={"Wear": "analyses.wear.report:WearPresentation"},
)
