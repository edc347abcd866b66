"""A contact on other grids, with other filters and ceilings, where that is asked for."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from roughcontact.request import options, problem
from roughcontact.request.option import Panel, flag
from roughcontact.request.outcome import Look, Work
from roughcontact.request.outputs import Say
from roughcontact.request.request import Request

if TYPE_CHECKING:
    from roughcontact.contact.study import ResolutionStudy

STUDY = flag(
    "study", Panel.SOLVER,
    "Solve again on coarser and finer grids, with filters and other ceilings, and tell what "
    "depends on them.",
)  # fmt: skip
_SOLVER = (options.TOLERANCE, options.PRECISION)


def studied(request: Request, work: Work, load: float) -> ResolutionStudy:
    """Return the study of a contact under a load [N], of its pieces where these are known."""
    from roughcontact.contact import resolution_study

    if work.known:
        return resolution_study.together([work.known[word] for word in apart(request)])
    return resolution_study.resolution_study(
        work.maps[0],
        **problem.arguments(request, work.maps, *_SOLVER),
        load=load,
        progress=lambda at: work.look(replace(at, label=f"study: {at.label}")),
    )


def apart(request: Request) -> tuple[str, ...]:
    """Return a word for each part of the study that can be solved by itself; none for no study.

    None as well where the contact comes first: with an approach it tells the load, and a ceiling
    that is recommended takes as long to find as half of the study.
    """
    from roughcontact.contact.advice import RECOMMENDED

    later = request.load[0] is None or request[options.CEILING] == RECOMMENDED
    if later or not request[STUDY]:
        return ()
    from roughcontact.contact.resolution_study import PARTS

    return PARTS


def found_of(request: Request, word: str, say: Say, look: Look) -> ResolutionStudy:
    """Return one part of the study, from maps that are read for it; see `studied`."""
    from roughcontact.contact.resolution_study import part_of
    from roughcontact.contact.terms import Terms
    from roughcontact.request.maps import surfaces

    maps = surfaces(request, say)
    load, _ = problem.pressed(request, maps, *request.load)
    terms = Terms(load, ceiling=request[options.CEILING], **request.solver(*_SOLVER))
    return part_of(word, problem.pair_of(request, maps), terms, look)
