"""The memory that a request needs, asked for before its maps are made."""

from __future__ import annotations

from roughcontact.halfspace.boundary import Boundary
from roughcontact.request.options import (
    COMPARE,
    CONDUCTANCE,
    ESTIMATE,
    FIND,
    HISTORY,
    ROLL,
    STRESS,
    SWEEP,
    VOLUME,
)
from roughcontact.request.request import Request
from roughcontact.request.tasks import TASKS
from roughcontact.surface import memory

# Maps that a report needs beside those of the bodies: pressure, gap, and what the roughness takes.
_REPORTED = 2 + memory.CORRELATED


def require_prepared(request: Request, shape: tuple[int, int]) -> None:
    """Raise `InsufficientMemoryError` unless a map can be read, prepared and worked with.

    Parameters
    ----------
    request : Request
        What was asked for.
    shape : (int, int)
        Points ``(ny, nx)`` in the file.
    """
    grid = cropped(request, shape)
    memory.require(grid, memory.PREPARED, "preparing a map")
    # Where heights or sides decide it, the grid is known once the map is there.
    if request["holes"] == "crop" or request["pixel"] is not None or request.aligned:
        return
    require(request, grid)


def require(request: Request, shape: tuple[int, int]) -> None:
    """Raise `InsufficientMemoryError` unless what is asked for can be done on a grid.

    Parameters
    ----------
    request : Request
        What was asked for.
    shape : (int, int)
        Points ``(ny, nx)``; no map of them has been made yet.
    """
    if request.task == ESTIMATE:
        # What a map shows asks for its memory itself.
        return
    from roughcontact.contact import find, load_curve, load_history, subsurface
    from roughcontact.contact.memory import Room

    counter = any(request.get(name) is not None for name in ("counter-surface", "counter-body"))
    bodies = 2 if counter else 1
    boundary, precision = Boundary(request["boundary"]), request.get("precision")
    if request.kind in (VOLUME, ROLL):
        from roughcontact.volume import extent, memory as volume

        volume.require(
            shape, extent.LEAST_LAYERS, boundary=boundary, precision=precision or "single"
        )
    else:
        series = {SWEEP: load_curve.HELD, COMPARE: load_curve.HELD, HISTORY: load_history.HELD,
                  FIND: find.HELD, CONDUCTANCE: 2,
                  **{task.name: task.held for task in TASKS}}  # fmt: skip
        held = series.get(request.kind, 0)
        Room(shape, boundary, precision or "double", bodies + held).require()
    if request.kind == STRESS or request.get("first-yield"):
        subsurface.require_memory(shape, boundary=boundary, friction=request.get("friction") or 0.0)
    if request.get("report") is not None:
        memory.require(shape, bodies + _REPORTED, "the report on a map")


def cropped(request: Request, shape: tuple[int, int]) -> tuple[int, int]:
    """Return the points that are kept of a map."""
    if request["crop"] is None:
        return shape
    rows, columns = (
        len(range(points)[part]) for part, points in zip(request["crop"], shape, strict=True)
    )
    return rows, columns
