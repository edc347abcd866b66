"""One active-set step: the linear problem on the free pixels, by conjugate gradients."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from roughcontact.solvers.iterate import Iterate, Viewer, dot, norm
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
    pressure, gap, unit = now.pressure, now.gap, viewer.unit
    bound = np.broadcast_to(viewer.limit(now.index), pressure.shape)
    # Pixels with pressure stay free even where the gap opens: the solve will empty them.
    free = np.where(pressure > 0, (pressure < bound) | (gap > 0), gap < 0)
    place = np.flatnonzero(free)
    if not place.size:
        return pressure
    limit = bound[place]
    centre = viewer.problem.total is not None
    x = pressure[place]
    residual = _centred(-gap[place], centre)
    first = norm(residual) / unit
    size = norm(pressure) or first
    enough = max(0.9 * tolerance, 0.1 * now.floor) * size
    patch = patches.around(now.index[place])
    free_index = patch.index(now.index[place])
    support = patch.operator.support(free_index)
    precondition = patch.inverse.on(free_index)
    direction: NDArray[np.float64] | None = None
    previous = 1.0
    while viewer.convolutions < max_iterations:
        z = _centred(precondition(residual / unit), centre)
        product = dot(residual, z)
        if not product > 0:
            break
        direction = z if direction is None else z + (product / previous) * direction
        previous = product
        response = patch.operator.gather(support, direction)
        viewer.convolutions += 1
        curvature = dot(direction, response)
        if curvature <= _FLAT * unit * dot(direction, direction):
            # A wave that nothing resists: only the bounds end the step.
            x += _way(x, direction, limit) * direction
            break
        length = product / curvature
        x += length * direction
        residual -= length * _centred(response, centre)
        error = norm(residual) / unit
        violation = norm(x - np.clip(x, 0, limit))
        if error <= enough or violation > error:
            break
        if error < _REDUCTION * first and violation > 0.1 * error:
            break
    return _restored(pressure, place, x, limit, bound, viewer.problem.total)


def _centred(values: NDArray[np.float64], centre: bool) -> NDArray[np.float64]:
    return values - values.mean() if centre and values.size else values


def _way(
    x: NDArray[np.float64], direction: NDArray[np.float64], limit: NDArray[np.float64]
) -> float:
    """Return how far values within their bounds can move before the first of them meets one."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ways = np.where(direction > 0, limit - x, -x) / direction
    ahead = ways[ways > 0]
    return float(ahead.min()) if ahead.size and np.isfinite(ahead).any() else 0.0


def _restored(
    pressure: NDArray[np.float64],
    place: NDArray[np.int64],
    x: NDArray[np.float64],
    limit: NDArray[np.float64],
    bound: NDArray[np.float64],
    total: float | None,
) -> NDArray[np.float64]:
    """Return the pressure with the free values ``x`` back within the bounds and the load."""
    moved = pressure.copy()
    if total is None:
        moved[place] = np.clip(x, 0, limit)
        return moved
    moved[place] = 0
    left = total - float(moved.sum())
    # Moving only the free pixels keeps the others exactly on their bounds.
    if 0 <= left <= float(limit.sum()):
        moved[place] = project(x, limit, left)
        return moved
    moved[place] = x
    return project(moved, bound, total)
