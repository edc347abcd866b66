"""One active-set step: the linear problem on the free pixels, by conjugate gradients."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughcontact.solvers.iterate import Iterate, Viewer, slopes
from roughcontact.solvers.operator import Sums, norm
from roughcontact.solvers.patches import Patches
from roughcontact.solvers.problem import Limit
from roughcontact.solvers.projection import project

# A linear solve stops at this reduction unless the set of free pixels is already right.
_REDUCTION = 0.3
# How a way along the bounds is shortened, and down to where.
_SHORTER, _SHORTEST = 0.4, 0.1
# Curvature over K₀₀ below which the uniform pressure of a periodic map is not resisted.
_FLAT = 1e-12


class _Free(NamedTuple):
    """Values found on the free pixels, which may lie outside their bounds."""

    free: NDArray[np.bool_]
    x: NDArray[np.float64]
    limit: Limit


def active_set_step(
    now: Iterate,
    viewer: Viewer,
    patches: Patches,
    tolerance: float,
    max_iterations: int,
) -> NDArray[np.float64]:
    """Solve on the free pixels by conjugate gradients; return the pressure, kept admissible."""
    found = _solved(now, viewer, patches, tolerance, max_iterations)
    return now.pressure if found is None else _restored(now, found, viewer)


def step_along_arc(
    now: Iterate,
    viewer: Viewer,
    patches: Patches,
    tolerance: float,
    max_iterations: int,
) -> Iterate:
    """Solve on the free pixels, bounds or not, and go that way along the bounds.

    As far as the energy, or the certificate, falls: the solution itself may be far outside of the
    bounds where pixels are so narrow that hardly anything resists what differs between them.
    Straight on, in the end: a step that short goes down (Moré and Toraldo 1991,
    doi:10.1137/0801008).
    """
    found = _solved(now, viewer, patches, tolerance, max_iterations, bounded=False)
    if found is None:
        return now
    first, way = now.pressure[found.free], 1.0
    while viewer.convolutions < max_iterations:
        part = found._replace(x=first + way * (found.x - first))
        moved = _restored(now, part, viewer)
        after = viewer.look(now.index, moved)
        start, end = slopes(now, moved, viewer)
        if start + end < 0 or after.certificate < now.certificate:
            return after
        if way < _SHORTEST:
            if not start < 0:
                return now
            cut = start / (start - end)
            return viewer.look(now.index, now.pressure + cut * (moved - now.pressure))
        way *= _SHORTER
    return now


def _solved(
    now: Iterate,
    viewer: Viewer,
    patches: Patches,
    tolerance: float,
    max_iterations: int,
    *,
    bounded: bool = True,
) -> _Free | None:
    """Return what conjugate gradients find on the free pixels; None where there are none.

    Where ``bounded``, they end as soon as the bounds matter more than the residual.
    """
    pressure, gap, unit, sums = now.pressure, now.gap, viewer.unit, viewer.sums
    bound = viewer.limit(now.index)
    # Pixels with pressure stay free even where the gap opens: the solve will empty them.
    free = np.where(pressure > 0, (pressure < bound) | (gap > 0), gap < 0)
    if not sums.count(free):
        return None
    # From here on in place where that can be: in full contact every array is as large as the map.
    limit = bound[free] if isinstance(bound, np.ndarray) else bound
    centred = _centred if viewer.problem.total is not None else _as_it_is
    x = pressure[free]
    residual = gap[free]
    np.negative(residual, out=residual)
    centred(residual, sums)
    first = norm(residual, sums) / unit
    size = norm(pressure, sums) or first
    enough = max(0.9 * tolerance, 0.1 * now.floor) * size
    free_index = now.index[free]
    patch = patches.around(free_index)
    free_index = patch.index(free_index)
    support = patch.operator.support(free_index)
    precondition = patch.inverse.on(free_index)
    direction: NDArray[np.float64] | None = None
    response, previous = residual, 1.0
    while viewer.convolutions < max_iterations:
        z = centred(precondition(residual / unit), sums)
        product = sums.dot(residual, z)
        if not product > 0:
            break
        if direction is None:
            direction = z
        else:
            # The inverse is not quite linear: what z shares with the residual before is taken off
            # (Golub and Ye 1999, doi:10.1137/S1064827597323415).
            direction *= -sums.dot(response, z) / previous
            direction += z
        del z
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
        response = centred(response, sums)
        response *= length
        residual -= response
        error = norm(residual, sums) / unit
        violation = _excess(x, limit, sums) if bounded else math.inf
        if error <= enough or (bounded and violation > error):
            break
        if error < _REDUCTION * first and violation > 0.1 * error:
            break
    return _Free(free, x, limit)


def _centred(values: NDArray[np.float64], sums: Sums) -> NDArray[np.float64]:
    """Return values, changed to be less their mean: what changes the load is the approach's."""
    values -= sums.total(values) / sums.size(values)
    return values


def _as_it_is(values: NDArray[np.float64], sums: Sums) -> NDArray[np.float64]:
    return values


def _excess(x: NDArray[np.float64], limit: Limit, sums: Sums) -> float:
    """Return how far values lie outside their bounds."""
    outside = np.clip(x, 0, limit)
    np.subtract(x, outside, out=outside)
    return norm(outside, sums)


def _way(
    x: NDArray[np.float64],
    direction: NDArray[np.float64],
    limit: Limit,
    sums: Sums,
) -> float:
    """Return how far values within their bounds can move before the first of them meets one."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ways = np.where(direction > 0, limit - x, -x) / direction
    way = sums.smallest(ways[ways > 0])
    return way if math.isfinite(way) else 0.0


def _restored(now: Iterate, found: _Free, viewer: Viewer) -> NDArray[np.float64]:
    """Return the pressure with the values found back within the bounds and the load."""
    total, sums = viewer.problem.total, viewer.sums
    free, x, limit = found
    moved = now.pressure.copy()
    if total is None:
        moved[free] = np.clip(x, 0, limit)
        return moved
    moved[free] = 0
    left = total - sums.total(moved)
    # Moving only the free pixels keeps the others exactly on their bounds.
    if 0 <= left <= sums.total(np.broadcast_to(limit, x.shape)):
        moved[free] = project(x, limit, left, sums)
        return moved
    moved[free] = x
    return project(moved, viewer.limit(now.index), total, sums)
