"""What has to hold before a path of loads is followed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from roughcontact import memory
from roughcontact.contact.validation import check_holes, row
from roughcontact.elastoplastic.increments import AUTO, between
from roughcontact.elastoplastic.path import PathPoint
from roughcontact.elastoplastic.problem import ContactSolver, Problem
from roughcontact.elastoplastic.result import ElastoplasticResult
from roughcontact.errors import (
    ArgumentRef,
    CapacityError,
    InputError,
    require_choice,
    require_count,
    require_positive,
    shown,
)
from roughcontact.units import Quantities, quantity

# Mean pressure over the yield strength that no flat punch with the outline of a map reaches: it
# flows at 2.97 on a strip and 3.28 on a disc (shear strength σ_Y/√3; Hill 1950, Shield 1955).
_PUNCH = 3.5


def check_arguments(
    problem: Problem,
    increments: int | str,
    depth: float | None,
    layers: ArrayLike | None,
    start: ElastoplasticResult | None,
    on_failure: str,
) -> None:
    """Raise `InputError` where an argument of `solve_elastoplastic` cannot be used."""
    pair = problem.pair
    pair.require_map("plasticity of the volume")
    precision, tolerance = problem.precision, problem.tolerance
    pair.boundary.require_volume()
    require_choice(("double", "single"), precision=precision)
    require_choice(("raise", "return"), on_failure=on_failure)
    if isinstance(increments, str) and increments != AUTO:
        raise InputError(
            f"must be a whole number, or {AUTO!r}, got {increments!r}",
            argument="increments",
            value=increments,
        )
    if not isinstance(increments, str):
        require_count(1, memory.STEPS, increments=increments)
    require_count(1, memory.ITERATIONS, max_iterations=problem.max_iterations)
    require_positive(tolerance=tolerance)
    if tolerance < 1e-6 and precision == "single":
        raise InputError(
            f"= {tolerance!r} lies below what single precision can reach; ask for 1e-6 or more, "
            "or for ",
            ArgumentRef("precision", "double"),
            argument="tolerance",
            value=tolerance,
        )
    _check_layers(depth, layers, min(pair.pixel))
    check_holes(pair)
    for body in (pair.material, pair.counter_material):
        if body.yield_strength is not None and math.isinf(body.young):
            raise InputError("a rigid material cannot yield: give it a Young's modulus")
    if min(pair.shape) < 8:
        raise InputError(f"has {pair.shape} pixels: give at least 8 × 8", argument="surface")
    if start is None:
        return
    if depth is not None or layers is not None:
        raise InputError(
            "brings its layers along: leave out ",
            ArgumentRef("depth"),
            " and ",
            ArgumentRef("layers"),
            argument="start",
        )
    problem.check_same("start", start)


def check_shared(**specified: Any) -> None:
    """Refuse what is not known of a volume on several ranks, by the name of its argument."""
    for name, value in specified.items():
        if value is not None:
            raise InputError(
                "is not available for a volume on several ranks: give a load or loads alone",
                argument=name,
            )


def _check_layers(depth: float | None, layers: ArrayLike | None, pixel: float) -> None:
    """Refuse a depth or layers that cannot be used, or both at once."""
    if depth is not None:
        require_positive(depth=depth)
        if depth < pixel:
            raise InputError(
                f"= {depth!r} m is less than a pixel, {pixel:.4g} m: give a few "
                "radii of a contact spot, or leave it out",
                argument="depth",
            )
        if layers is not None:
            raise InputError(
                "give either ", ArgumentRef("depth"), " or ", ArgumentRef("layers"), ", not both"
            )
    if layers is not None and not (row(layers, "layers") > 0).all():
        raise InputError(f"must be positive [m], got {shown(layers)}", argument="layers")


def check_capacity(problem: Problem, solver: ContactSolver, load: float) -> None:
    """Refuse a load under which a map that ends yields without limit."""
    if not problem.pair.boundary.free_axes:
        return
    strain = np.array(1e9)
    strongest = min(float(body.law.strength(strain)) for body in problem.yielding)
    capacity = _PUNCH * strongest * solver.area * np.count_nonzero(np.isfinite(solver.initial_gap))
    if load > capacity:
        raise CapacityError(
            f"= {load:.6g} N is more than the map can carry: even in full contact the body yields "
            f"without limit above {capacity:.4g} N, which is {_PUNCH} times the largest yield "
            "strength times the area",
            argument="load",
        )


def path_of(
    problem: Problem,
    requested: tuple[float | None, Quantities | None, Sequence[PathPoint] | None],
    increments: int | str,
    start: ElastoplasticResult | None,
) -> list[PathPoint]:
    """Return the points to visit, one after the other, of a load, of loads or of a path."""
    load, loads, path = requested[0], quantity(requested[1], "force", "loads"), requested[2]
    if sum(specified is not None for specified in (load, loads, path)) != 1:
        raise InputError(
            "give either ",
            ArgumentRef("load"),
            ", ",
            ArgumentRef("loads"),
            " or ",
            ArgumentRef("path"),
            ", and only one of them",
        )
    if path is not None:
        points = _points(path)
        _check_path(problem, points)
    else:
        # A counter-surface that has moved stays where it is.
        last = start.increments[-1].offset if start and start.increments else (0.0, 0.0)
        points = [PathPoint(value, last) for value in _asked(load, loads)]
    if not any(point.load for point in points) and (start is None or start.solution.load == 0):
        raise InputError(
            "are all zero: at least one must press the bodies together",
            argument="loads" if path is None else "path",
        )
    if load is None or isinstance(increments, str):
        return points
    before = start.increments[-1].point if start and start.increments else PathPoint(0.0)
    return between(before, points[0], int(increments))


def _check_path(problem: Problem, points: Sequence[PathPoint]) -> None:
    """Refuse a path on which a counter-surface moves that cannot, or slides off and yields."""
    pair = problem.pair
    if pair.counter_surface is None and any(any(point.offset) for point in points):
        raise InputError(
            "moves a counter-surface, and there is none but a flat: give its heights",
            argument="path",
        )
    yields = pair.counter_material.yield_strength is not None
    if yields and pair.boundary.free_axes and any(point.friction for point in points):
        raise InputError(
            "slides a counter-body that yields over a map that ends, and its strain with it: that "
            "is not in the model; give a periodic boundary, or leave out its yield strength or "
            "the friction",
            argument="path",
        )


def _points(path: Sequence[PathPoint]) -> list[PathPoint]:
    points = list(path) if isinstance(path, Sequence) else []
    if not points or not all(isinstance(point, PathPoint) for point in points):
        raise InputError(f"must be a row of PathPoint, got {path!r:.80}", argument="path")
    require_count(1, memory.STEPS, path=len(points))
    return points


def _asked(load: float | None, loads: Sequence[float] | None) -> list[float]:
    """Return the loads that are asked for."""
    if load is not None:
        require_positive(load=load)
        return [float(load)]
    try:
        path = np.array(loads, float)
    except (TypeError, ValueError):
        raise InputError("must be a row of numbers [N]", argument="loads") from None
    if path.ndim != 1 or not path.size or not ((path >= 0) & np.isfinite(path)).all():
        raise InputError(
            f"must be finite and not negative [N], got {loads!r}", argument="loads", value=loads
        )
    return [float(value) for value in path]
