"""A contact on other grids, with other filters and ceilings, where that is asked for."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from roughcontact.contact.advice import RECOMMENDED
from roughcontact.request import problem
from roughcontact.request.maps import surfaces
from roughcontact.request.outputs import Say
from roughcontact.request.request import Request
from roughcontact.solvers.progress import Progress

if TYPE_CHECKING:
    from roughcontact.contact.study import ResolutionStudy
    from roughcontact.surface.surface import Surface

Look = Callable[[Progress], None]


def studied(
    request: Request,
    maps: Sequence[Surface],
    load: float,
    look: Look,
    known: Mapping[str, ResolutionStudy] | None = None,
) -> ResolutionStudy:
    """Return the study of a contact.

    Parameters
    ----------
    request : Request
        What was asked for.
    maps : sequence of Surface
        The prepared maps.
    load : float
        Load on the contact [N].
    look : callable
        Called with the `Progress` of the solver.
    known : mapping, optional
        Its parts, found before by `found_of`, by the words of `apart`.
    """
    from roughcontact.contact import resolution_study

    if known:
        return resolution_study.together([known[word] for word in apart(request)])
    return resolution_study.resolution_study(
        maps[0],
        **problem.arguments(request, maps, "tolerance", "precision"),
        load=load,
        progress=lambda at: look(replace(at, label=f"study: {at.label}")),
    )


def apart(request: Request) -> tuple[str, ...]:
    """Return a word for each part of the study that can be solved by itself; none for no study.

    None as well where the contact comes first: with an approach it tells the load, and a ceiling
    that is recommended takes as long to find as half of the study.
    """
    later = request.load[0] is None or request["ceiling"] == RECOMMENDED
    if later or not request["study"]:
        return ()
    from roughcontact.contact.resolution_study import PARTS

    return PARTS


def found_of(request: Request, word: str, say: Say, look: Look) -> ResolutionStudy:
    """Return one part of the study, from maps that are read for it; see `studied`."""
    from roughcontact.contact.resolution_study import part_of
    from roughcontact.contact.terms import Terms

    maps = surfaces(request, say)
    load, _ = problem.pressed(request, maps, *request.load)
    terms = Terms(load, ceiling=request["ceiling"], **request.solver("tolerance", "precision"))
    return part_of(word, problem.pair_of(request, maps), terms, look)
