"""Tilt of one body on another at which the contact pressure balances given moments.

All quantities are dimensionless except lengths: a lever is a distance from the center of the map
over its longer side, a moment the mean lever of the pressure, and a tilt the difference in gap
over the longer side [m].
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array, Pixel, Shape
from roughcontact.solvers import bounded
from roughcontact.solvers.bounded import BoundedSolution
from roughcontact.solvers.operator import Family, dot
from roughcontact.solvers.preconditioner import Patches
from roughcontact.solvers.problem import BoundedProblem, Moments
from roughcontact.solvers.progress import Status

# Curvature over K₀₀ below which a pressure meets no resistance.
_FLAT = 1e-12
# Relative increase of the load in the last step: the remaining increase is far smaller.
_GAIN = 1e-7
_MAX_STEPS = 2000


@dataclass(frozen=True, eq=False)
class Punch:
    """Flat punch that displaces some pixels by a unit length.

    Parameters
    ----------
    total : float
        Sum of the pressures [Pa/m]; infinite without resistance, as on a whole periodic map.
    pressure : ndarray, shape (n,)
        Pressure on the pixels [Pa/m].
    displacement : ndarray, shape (ny, nx)
        Displacement of the map [1], 1 on the pixels.
    unit : float
        K₀₀, the displacement of a pixel under unit pressure on itself [m/Pa].
    """

    total: float
    pressure: NDArray[np.float64]
    displacement: NDArray[Any]
    unit: float


def flat_punch(shape: Shape, index: NDArray[np.int64], family: Family) -> Punch | None:
    """Return the pressures that displace some pixels by a unit length.

    Parameters
    ----------
    shape : (int, int)
        Grid points ``(ny, nx)`` of the map.
    index : ndarray of int, shape (n,)
        Flat indices of the pixels, ascending, at least one.
    family : callable
        As for `roughcontact.solvers.bounded.solve`.

    Returns
    -------
    Punch or None
        None if the iteration does not converge.

    Notes
    -----
    Conjugate gradients from zero pressure, in single precision. The total is a maximum,
    ``(Σp)² / ⟨p, K p⟩``, so its error is the square of the pressure error: evaluated once in the
    arithmetic of the problem, it has more digits than the pressure.
    """
    operator = family(shape, (1, 1))
    patch = Patches(operator, family, (1, 1)).make_patch(index)
    local = patch.index(index)
    support, precondition = patch.operator.support(local), patch.inverse.restrict_inverse(local)
    unit = operator.self_displacement
    pressure, residual = np.zeros(index.size), np.ones(index.size)
    direction, response = pressure, residual
    previous, carried, first = math.inf, 0.0, 0.0
    for _ in range(_MAX_STEPS):
        z = precondition(residual)
        product = dot(residual, z)
        if not product > 0:
            # Only rounding is left, or the inverse is not positive: steepest descent.
            z, product = residual.copy(), dot(residual, residual)
        first = first or product
        if product <= _GAIN**2 * first:
            break
        # The inverse is not quite linear: see `roughcontact.solvers.active_set`.
        direction = z - dot(response, z) / previous * direction
        previous = product
        response = patch.operator.gather(support, direction) / unit
        curvature = dot(direction, response)
        if curvature <= _FLAT * dot(direction, direction):
            return Punch(math.inf, direction, residual, unit)
        length = product / curvature
        pressure += length * direction
        response *= length
        residual -= response
        carried += length * product
        if length * product <= _GAIN * carried:
            break
    else:
        return None
    displacement: NDArray[Any] = np.empty(shape, operator.real)

    def store_rows(number: int, rows: slice, block: NDArray[Any]) -> None:
        displacement[rows] = block

    pressure /= unit
    operator.spread(operator.support(index), pressure, store_rows)
    work = dot(pressure, displacement.ravel()[index].astype(np.float64))
    return Punch(float(pressure.sum()) ** 2 / work, pressure, displacement, unit)


# Maximum number of points: with more, the steps of the staircase are negligible.
_MAX_POINTS = 1 << 20
# Distance from a bound up to which parts of the load are at the bound.
_BOUND = 1e-12


def rigid_tilt(problem: BoundedProblem, levers: tuple[Array, Array], target: Array) -> Array | None:
    """Return the tilt at which rigid bodies rest under a load that acts at a point.

    Parameters
    ----------
    problem : BoundedProblem
        Problem under a given load; ``initial_gap`` is without tilt.
    levers : (ndarray, ndarray), shapes (ny, 1) and (nx,)
        Result of `roughcontact.solvers.rigid_tilt.moment_arms`.
    target : ndarray, shape (2,)
        Mean lever (y, x) of the pressure.

    Returns
    -------
    ndarray, shape (2,), or None
        Differences in gap over the longer side [m], along y and x; None if no tilt was found.

    Notes
    -----
    Among all parts q of the load between 0 and the ceiling, with a sum of 1 and the required mean
    lever, the lowest ones, ``min ⟨h₀, q⟩``, are found: the multipliers of the three sums are the
    plane that touches the body from above, which is the counter-body at rest.
    """
    from scipy.optimize import linprog

    touchable = np.isfinite(problem.initial_gap)
    if not 0 < np.count_nonzero(touchable) <= _MAX_POINTS:
        return None
    assert problem.total is not None
    gap = problem.initial_gap[touchable]
    arms = [np.broadcast_to(lever, touchable.shape)[touchable] for lever in levers]
    spans = np.array([float(np.ptp(arm)) or 1.0 for arm in arms])
    maximum = np.broadcast_to(problem.limit, touchable.shape)[touchable] / problem.total
    maximum = np.where(maximum < 1, maximum, np.inf)
    sums = np.stack(
        [np.ones(gap.size), *((a - t) / s for a, t, s in zip(arms, target, spans, strict=True))]
    )
    deepest = float(gap.max()) or 1.0
    # An array of bounds is documented by SciPy, but missing in its types.
    bounds: Any = np.stack([np.zeros(gap.size), maximum], axis=1)
    result = linprog(
        gap / deepest, A_eq=sums, b_eq=np.array([1.0, 0, 0]), bounds=bounds, method="highs-ds"
    )
    if result.status != 0:
        return None
    plane, parts = result.eqlin.marginals * deepest, np.asarray(result.x)
    # Refine to the last digit: the plane through the points that are neither empty nor full.
    between = (parts > _BOUND) & (parts < maximum * (1 - _BOUND))
    on = sums[:, between].T
    plane = plane + np.linalg.lstsq(on, gap[between] - on @ plane, rcond=_BOUND)[0]
    tilt: Array = -plane[1:] / spans
    return tilt if np.isfinite(tilt).all() else None


# Distance outside the admissible moments that is treated as rounding.
_EDGE = 1e-9
_MAX_CUTS = 60


def moment_arms(shape: tuple[int, ...], pixel: Pixel) -> tuple[Array, Array]:
    """Return the levers of the rows and of the columns of a map.

    Parameters
    ----------
    shape : (int, int)
        Grid points ``(ny, nx)``.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].

    Returns
    -------
    (ndarray, ndarray), shapes (ny, 1) and (nx,)
        Distance of the pixel centers from the center of the map, over its longer side.

    Examples
    --------
    >>> moment_arms((2, 4), (1e-6, 1e-6))[1]
    array([-0.375, -0.125,  0.125,  0.375])
    """
    side = max(points * edge for points, edge in zip(shape, pixel, strict=True))
    y, x = (
        (np.arange(points, dtype=np.float64) - (points - 1) / 2) * (edge / side)
        for points, edge in zip(shape, pixel, strict=True)
    )
    return y[:, None], x


def excess(target: Array, y: Array, x: Array, share: float | Array) -> float:
    """Return the distance of a moment from those that admissible pressures can balance.

    Parameters
    ----------
    target : ndarray, shape (2,)
        Required moment (y, x).
    y, x : ndarray, shape (n,)
        Levers of the pixels that can touch.
    share : float or ndarray, shape (n,)
        Largest part of the load that a pixel can carry; ``inf`` without a ceiling.

    Returns
    -------
    float
        Distance of the moment from the nearest one that can be balanced; 0 if it can be balanced.

    Notes
    -----
    The moments that can be balanced form a convex set. Its outermost points in successive
    directions, found by loading the furthest pixels up to the ceiling, span a growing part of the
    set towards the moment, until the moment is inside, or no point is as far out in a direction
    (Gilbert, Johnson and Keerthi 1988, doi:10.1109/56.2083).

    Examples
    --------
    >>> y, x = np.array([0.0, 0.0]), np.array([-0.5, 0.5])
    >>> round(excess(np.array([0.0, 0.7]), y, x, math.inf), 9)
    0.2
    >>> round(excess(np.array([0.0, 0.7]), y, x, 0.5), 9)
    0.7
    """
    nearest = _outermost(np.array([1.0, 0.0]), y, x, share) - target
    cuts = [nearest]
    while True:
        distance = math.hypot(*nearest)
        if distance <= _EDGE or len(cuts) == _MAX_CUTS:
            return 0.0
        cut = _outermost(-nearest, y, x, share) - target
        # No point of the set is closer in this direction.
        if float(cut @ nearest) >= (distance - _EDGE) * distance:
            return distance
        cuts.append(cut)
        nearest = _nearest(np.array(cuts))


def _outermost(direction: Array, y: Array, x: Array, share: float | Array) -> Array:
    """Return the furthest moment in a direction that can be balanced."""
    along = direction[0] * y + direction[1] * x
    if np.isinf(share).all():
        best = int(along.argmax())
        return np.array([y[best], x[best]])
    order = np.argsort(-along)
    carried = np.cumsum(np.broadcast_to(share, along.shape)[order])
    # The furthest points first, each at its maximum; the last takes the remainder.
    part = np.diff(np.minimum(carried, 1.0), prepend=0.0)
    return np.einsum("pn,n->p", np.stack([y[order], x[order]]), part)


def _nearest(points: Array) -> Array:
    """Return the point of the convex hull of some points that is nearest to the origin."""
    angles = np.sort(np.arctan2(points[:, 0], points[:, 1]))
    if np.diff(angles, append=angles[0] + 2 * math.pi).max() <= math.pi:
        return np.zeros(2)
    first, second = (points[index] for index in np.triu_indices(len(points)))
    edge = second - first
    length = (edge**2).sum(axis=1)
    along = -(first * edge).sum(axis=1) / np.where(length > 0, length, 1)
    nearest = first + np.clip(along, 0, 1)[:, None] * edge
    return nearest[(nearest**2).sum(axis=1).argmin()]


def solve(
    problem: BoundedProblem,
    family: Family,
    target: Array,
    pixel: Pixel,
    *,
    max_iterations: int,
    **options: Any,
) -> tuple[BoundedSolution, tuple[float, float]]:
    """Return the pressure and the tilt that balance a moment.

    Parameters
    ----------
    problem : BoundedProblem
        Problem under a given load on a map with free boundary; ``initial_gap`` is without tilt.
    family, max_iterations, **options
        As for `roughcontact.solvers.bounded.solve`.
    target : ndarray, shape (2,)
        Required mean lever (y, x); `excess` returns whether a pressure can have it.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].

    Returns
    -------
    BoundedSolution
        The solution at this tilt; if the first solve stalls, started from the tilt of rigid bodies.
    (float, float)
        Slopes of the gap along y and x added by the tilt.

    Notes
    -----
    Approach and tilt are the multipliers of load and moments: the solver keeps all three sums.
    """
    side = max(points * edge for points, edge in zip(problem.shape, pixel, strict=True))
    y, x = moment_arms(problem.shape, pixel)
    moments = Moments((y[:, 0], x), (float(target[0]), float(target[1])))
    tilt = np.zeros(2)
    solution = bounded.solve(
        replace(problem, moments=moments), family, max_iterations=max_iterations, **options
    )
    left = max_iterations - solution.convolutions
    if solution.status is Status.STALLED and left > 0:
        rest = rigid_tilt(problem, (y, x), target)
        if rest is not None:
            tilt = rest
            gap = problem.initial_gap + tilt[0] * y + tilt[1] * x
            solution = bounded.solve(
                replace(problem, initial_gap=gap, moments=moments),
                family,
                max_iterations=left,
                **options,
            )
    slope_y, slope_x = (tilt + solution.tilt) / side
    return solution, (float(slope_y), float(slope_x))
