"""Arguments of a solve that a request gives: the bodies, their load, the solver."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from roughcontact.errors import InputError
from roughcontact.halfspace.boundary import Boundary
from roughcontact.request.option import Option
from roughcontact.request.options import BOUNDARY, CEILING
from roughcontact.request.request import Request

if TYPE_CHECKING:
    from roughcontact.contact.load_case import GivenLoad
    from roughcontact.contact.pair import Pair
    from roughcontact.surface.surface import Surface


def arguments(request: Request, maps: Sequence[Surface], *solver: Option[Any]) -> dict[str, Any]:
    """Return the arguments that `contact.solve` and its relatives share, but for the load."""
    material, counter_material = request.bodies()
    return {
        "material": material,
        "counter_material": counter_material,
        "counter_surface": maps[1] if len(maps) > 1 else None,
        "ceiling": request.get(CEILING),
        "boundary": request[BOUNDARY],
        **request.solver(*solver),
    }


def pair_of(request: Request, maps: Sequence[Surface]) -> Pair:
    """Return the bodies that are pressed together."""
    from roughcontact.contact.pair import Pair

    material, counter_material = request.bodies()
    counter = maps[1] if len(maps) > 1 else None
    boundary = Boundary(request[BOUNDARY])
    return Pair(maps[0], material, counter, counter_material, boundary)


def pressed(
    request: Request, maps: Sequence[Surface], load: Any, argument: str = "load"
) -> tuple[Any, GivenLoad | None]:
    """Return the force that a load is on the bodies, and how it was given."""
    from roughcontact.contact import load_case

    pair = pair_of(request, maps)
    if pair.is_profile and isinstance(load, float):
        raise InputError(
            "is a force, and the file holds a profile: give a load per length such as '600 N/mm'",
            argument=argument,
        )
    return load_case.resolve_force(load, pair, argument)
