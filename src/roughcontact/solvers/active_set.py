"""One active-set step: the linear problem on the free pixels, by conjugate gradients."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from roughcontact.solvers.iterate import Iterate, Viewer
from roughcontact.solvers.operator import Sums, norm
from roughcontact.solvers.patches import Patches
from roughcontact.solvers.projection import project

# A linear solve stops at this reduction unless the set of free pixels is already right.
_REDUCTION = 0.1
# Curvature over K₀₀ below which the uniform pressure of a periodic map is not resisted.
_FLAT = 1e-12


def active_set_step(
    now: Iterate,
    viewer: Viewer,
    patches: Patches,
    tolerance: float,
    max_iterations: int,
) -> NDArray[np.float64]:
    """Solve on the free pixels by conjugate gradients; return the pressure, kept admissible."""
    pressure, gap, unit, sums = now.pressure, now.gap, viewer.unit, viewer.sums
    bound = np.broadcast_to(viewer.limit(now.index), pressure.shape)
    # Pixels with pressure stay free even where the gap opens: the solve will empty them.
    free = np.where(pressure > 0, (pressure < bound) | (gap > 0), gap < 0)
    place = np.flatnonzero(free)
    if not sums.size(place):
        return pressure
    limit = bound[place]
    centred = _centred if viewer.problem.total is not None else _as_it_is
    x = pressure[place]
    residual = centred(-gap[place], sums)
    first = norm(residual, sums) / unit
    size = norm(pressure, sums) or first
    enough = max(0.9 * tolerance, 0.1 * now.floor) * size
    patch = patches.around(now.index[place])
    free_index = patch.index(now.index[place])
    support = patch.operator.support(free_index)
    precondition = patch.inverse.on(free_index)
    direction: NDArray[np.float64] | None = None
    previous = 1.0
    while viewer.convolutions < max_iterations:
        z = centred(precondition(residual / unit), sums)
        product = sums.dot(residual, z)
        if not product > 0:
            break
        direction = z if direction is None else z + (product / previous) * direction
        previous = product
        response = patch.operator.gather(support, direction)
        viewer.convolutions += 1
        curvature = sums.dot(direction, response)
        if curvature <= _FLAT * unit * sums.dot(direction, direction):
            # A wave that nothing resists: only the bounds end the step.
            x += _way(x, direction, limit, sums) * direction
            break
        length = product / curvature
        x += length * direction
        residual -= length * centred(response, sums)
        error = norm(residual, sums) / unit
        violation = norm(x - np.clip(x, 0, limit), sums)
        if error <= enough or violation > error:
            break
        if error < _REDUCTION * first and violation > 0.1 * error:
            break
    return _restored(pressure, place, x, limit, bound, viewer)


def _centred(values: NDArray[np.float64], sums: Sums) -> NDArray[np.float64]:
    """Return values less their mean: what changes the load is the approach's to take up."""
    return values - sums.total(values) / sums.size(values)


def _as_it_is(values: NDArray[np.float64], sums: Sums) -> NDArray[np.float64]:
    return values


def _way(
    x: NDArray[np.float64],
    direction: NDArray[np.float64],
    limit: NDArray[np.float64],
    sums: Sums,
) -> float:
    """Return how far values within their bounds can move before the first of them meets one."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ways = np.where(direction > 0, limit - x, -x) / direction
    way = sums.smallest(ways[ways > 0])
    return way if math.isfinite(way) else 0.0


def _restored(
    pressure: NDArray[np.float64],
    place: NDArray[np.int64],
    x: NDArray[np.float64],
    limit: NDArray[np.float64],
    bound: NDArray[np.float64],
    viewer: Viewer,
) -> NDArray[np.float64]:
    """Return the pressure with the free values ``x`` back within the bounds and the load."""
    total, sums = viewer.problem.total, viewer.sums
    moved = pressure.copy()
    if total is None:
        moved[place] = np.clip(x, 0, limit)
        return moved
    moved[place] = 0
    left = total - sums.total(moved)
    # Moving only the free pixels keeps the others exactly on their bounds.
    if 0 <= left <= sums.total(limit):
        moved[place] = project(x, limit, left, sums)
        return moved
    moved[place] = x
    return project(moved, bound, total, sums)
