"""What a request gives to a solve: bodies, load, solver; and the memory that it needs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from roughcontact.errors import InputError
from roughcontact.halfspace.boundary import Boundary
from roughcontact.request import options
from roughcontact.request.option import Option
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
        "ceiling": request.get(options.CEILING),
        "boundary": request[options.BOUNDARY],
        **request.solver(*solver),
    }


def pair_of(request: Request, maps: Sequence[Surface]) -> Pair:
    """Return the bodies that are pressed together."""
    from roughcontact.contact.pair import Pair

    material, counter_material = request.bodies()
    counter = maps[1] if len(maps) > 1 else None
    boundary = Boundary(request[options.BOUNDARY])
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


# --- The memory that a request needs, asked for before its maps are made ---


def require_prepared(request: Request, shape: tuple[int, int]) -> None:
    """Raise `InsufficientMemoryError` unless a map can be read, prepared and worked with."""
    from roughcontact.surface.grid import PREPARED, require_memory

    grid = cropped(request, shape)
    require_memory(grid, PREPARED, "preparing a map")
    # Where heights or sides decide it, the grid is known once the map is there.
    if request[options.MISSING] == "crop" or request[options.PIXEL] is not None or request.aligned:
        return
    require(request, grid)


def require(request: Request, shape: tuple[int, int]) -> None:
    """Raise `InsufficientMemoryError` unless what is asked for can be done on a grid."""
    if request.task.memory is None:
        require_contact(request, shape, request.task.held)
    else:
        request.task.memory(request, shape)
    if request.get(options.REPORT) is not None:
        from roughcontact.surface.grid import CORRELATED, require_memory

        # Beside the bodies: pressure, gap, and what the roughness takes.
        require_memory(shape, _bodies(request) + 2 + CORRELATED, "the report on a map")


def require_contact(request: Request, shape: tuple[int, int], held: int = 0) -> None:
    """Raise `InsufficientMemoryError` unless a contact fits, with so many maps beside it."""
    from roughcontact.contact.memory import Room

    boundary = Boundary(request[options.BOUNDARY])
    precision = str(request.get(options.PRECISION) or "double")
    Room(shape, boundary, precision, _bodies(request) + held).require()


def require_volume(request: Request, shape: tuple[int, int]) -> None:
    """Raise `InsufficientMemoryError` unless plasticity of the volume fits."""
    from roughcontact.elastoplastic import problem, problem as volume

    volume.require(
        shape,
        problem.LEAST_LAYERS,
        boundary=Boundary(request[options.BOUNDARY]),
        precision=str(request.get(options.PRECISION) or "single"),
    )


def _bodies(request: Request) -> int:
    return 1 + any(map(request.is_given, (options.COUNTER_SURFACE, options.COUNTER_BODY)))


def cropped(request: Request, shape: tuple[int, int]) -> tuple[int, int]:
    """Return the points that are kept of a map."""
    crop = request[options.CROP]
    if crop is None:
        return shape
    rows, columns = (len(range(points)[part]) for part, points in zip(crop, shape, strict=True))
    return rows, columns
