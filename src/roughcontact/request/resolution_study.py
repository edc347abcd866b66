"""A contact on other grids, with other filters and ceilings, where that is asked for."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from roughcontact.request import options
from roughcontact.request.option import Panel, flag
from roughcontact.request.outcome import Look, Work
from roughcontact.request.outputs import Say
from roughcontact.request.request import Request
from roughcontact.request.solve_arguments import arguments, pair_of, pressed

if TYPE_CHECKING:
    from roughcontact.studies.resolution_study import ResolutionStudy

STUDY = flag(
    "study", Panel.SOLVER,
    "Check dependence on grid, filter and ceiling.",
)  # fmt: skip
_SOLVER = (options.TOLERANCE, options.PRECISION)


def studied(request: Request, work: Work, load: float) -> ResolutionStudy:
    """Return the study of a contact under a load [N], of its pieces where these are known."""
    from roughcontact.studies import resolution_study

    if work.known:
        return resolution_study.together([work.known[word] for word in apart(request)])
    return resolution_study.resolution_study(
        work.maps[0],
        **arguments(request, work.maps, *_SOLVER),
        load=load,
        progress=lambda state: work.look(replace(state, label=f"study: {state.label}")),
    )


def apart(request: Request) -> tuple[str, ...]:
    """Return a word for each part of the study that can be solved by itself; none for no study."""
    from roughcontact.contact.result import CALIBRATED

    later = request.load[0] is None or request[options.CEILING] == CALIBRATED
    if later or not request[STUDY]:
        return ()
    from roughcontact.studies.resolution_study import PARTS

    return PARTS


def found_of(request: Request, word: str, say: Say, look: Look) -> ResolutionStudy:
    """Return one part of the study, from maps that are read for it; see `studied`."""
    from roughcontact.contact.load_case import LoadCase
    from roughcontact.request.maps import surfaces
    from roughcontact.studies.resolution_study import part_of

    maps = surfaces(request, say)
    load, _ = pressed(request, maps, *request.load)
    terms = LoadCase(load, ceiling=request[options.CEILING], **request.solver(*_SOLVER))
    return part_of(word, pair_of(request, maps), terms, look)
