"""Repeated passes that a request asks for."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from roughcontact.request import problem
from roughcontact.request.request import Request

if TYPE_CHECKING:
    from roughcontact.contact.loads import GivenLoad
    from roughcontact.solvers.progress import Progress
    from roughcontact.surface.surface import Surface
    from roughcontact.volume.passes import Frame
    from roughcontact.volume.rolling import Rolling


def rolled(
    request: Request, maps: Sequence[Surface], look: Callable[[Progress], None]
) -> tuple[Rolling, GivenLoad | None, tuple[Frame, ...]]:
    """Pass the counter-body as often as a request asks for.

    Parameters
    ----------
    request : Request
        What was asked for.
    maps : sequence of Surface
        Body and counter-body, prepared.
    look : callable
        Called with the `Progress` of the solver.

    Returns
    -------
    (Rolling, GivenLoad or None, tuple of Frame)
        The passes, how their load was given, and the pictures of a movie if one is wanted.
    """
    from roughcontact.plots.movie import along_of
    from roughcontact.volume.passes import frame
    from roughcontact.volume.rolling import roll

    force, given = problem.pressed(request, maps, *request.load)
    options = problem.arguments(request, maps, "tolerance", "max-iterations", "precision")
    del options["ceiling"]
    frames: list[Frame] = []
    along = along_of(request["direction"])

    def picture(number: int, step: int, state: Any) -> None:
        if request["movie"] is not None:
            frames.append(frame(state, number, step, along))

    # What is shown is kept whole, as a series for ParaView needs it.
    shown = request["movie"] is not None or any(path.suffix == ".pvd" for path in request.outputs)

    found = roll(
        maps[0],
        **options,
        load=force,
        passes=request["passes"],
        steps=request["steps"],
        way=request["way"],
        direction=request["direction"],
        to_and_fro=request["to-and-fro"],
        centered=request["way"] is not None,
        friction=request["friction"],
        folder=request["folder"],
        progress=look,
        each=picture if shown else None,
    )
    return found, given, tuple(frames)
