"""Tilt of one body on another: which angles let the contact pressure balance given moments.

Everything here is dimensionless but for lengths: a lever is a distance from the centre of the
map over its longer side, a moment the mean lever of the pressure, and a tilt the difference in
gap over the longer side [m].
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.solvers import bounded
from roughcontact.solvers.bounded import Solution
from roughcontact.solvers.operator import Family, Operator
from roughcontact.solvers.preconditioner import Patches
from roughcontact.solvers.problem import Loaded, Problem
from roughcontact.solvers.progress import Status, Step

# Curvature over K₀₀ below which nothing resists a pressure.
_FLAT = 1e-12
# Part of the load that the last step may have added: what is left to add is far less.
_GAIN = 1e-7
_MOST_STEPS = 2000


@dataclass(frozen=True, eq=False)
class Punch:
    """What displaces some pixels alike, by a unit length.

    Parameters
    ----------
    total : float
        Sum of the pressures [Pa/m]; infinite where nothing resists, as on all of a periodic map.
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


def flat_punch(shape: tuple[int, int], index: NDArray[np.int64], family: Family) -> Punch | None:
    """Return the pressures that displace some pixels by a unit length.

    Parameters
    ----------
    shape : (int, int)
        Grid points ``(ny, nx)`` of the map.
    index : ndarray of int, shape (n,)
        Flat indices of the pixels, ascending, one at least.
    family : callable
        As for `roughcontact.solvers.bounded.solve`.

    Returns
    -------
    Punch or None
        None where the search ends too early.

    Notes
    -----
    Conjugate gradients from no pressure on, in single precision. The total is a maximum,
    ``(Σp)² / ⟨p, K p⟩``, and so off by the square of what the pressure is off by: taken once in
    the arithmetic of the problem, it is good to more digits than the pressure.
    """
    operator = family(shape, (1, 1))
    patch = Patches(operator, family, (1, 1)).around(index)
    local = patch.index(index)
    support, precondition = patch.operator.support(local), patch.inverse.on(local)
    sums, unit = operator.sums, operator.self_displacement
    pressure, residual = np.zeros(index.size), np.ones(index.size)
    direction, response = pressure, residual
    previous, carried, first = math.inf, 0.0, 0.0
    for _ in range(_MOST_STEPS):
        z = precondition(residual)
        product = sums.dot(residual, z)
        if not product > 0:
            # Hardly more than rounding is left, or the inverse is none there: straight down.
            z, product = residual.copy(), sums.dot(residual, residual)
        first = first or product
        if product <= _GAIN**2 * first:
            break
        # The inverse is not quite linear: see `roughcontact.solvers.active_set`.
        direction = z - sums.dot(response, z) / previous * direction
        previous = product
        response = patch.operator.gather(support, direction) / unit
        curvature = sums.dot(direction, response)
        if curvature <= _FLAT * sums.dot(direction, direction):
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
    rows = operator.rows.stop - operator.rows.start
    displacement: NDArray[Any] = np.empty((rows, shape[1]), operator.real)

    def keep(number: int, rows: slice, block: NDArray[Any]) -> None:
        displacement[rows] = block

    pressure /= unit
    operator.spread(operator.support(index), pressure, keep)
    work = sums.dot(pressure, displacement.ravel()[index].astype(np.float64))
    return Punch(sums.total(pressure) ** 2 / work, pressure, displacement, unit)


# How two rigid bodies come to rest on each other, under a ceiling of the pressure or without …


Array = NDArray[np.float64]

# On more points than these the steps of the staircase have become too small to matter.
_MOST_POINTS = 1 << 20
# Parts of the load this near to a bound are on it.
_BOUND = 1e-12


def rigid_tilt(problem: Problem, levers: tuple[Array, Array], target: Array) -> Array | None:
    """Return the tilt at which rigid bodies rest under a load that acts at a point.

    Parameters
    ----------
    problem : Problem
        A problem under a given load; ``initial_gap`` is that without tilt.
    levers : (ndarray, ndarray), shapes (ny, 1) and (nx,)
        As `roughcontact.solvers.rigid_tilt.moment_arms` gives them.
    target : ndarray, shape (2,)
        Mean lever (y, x) of the pressure.

    Returns
    -------
    ndarray, shape (2,), or None
        Differences in gap over the longer side [m], along y and x; None where none was found.

    Notes
    -----
    Of all parts q of the load that lie between 0 and what the ceiling allows, sum to 1 and have
    the mean lever wanted, those that lie lowest, ``min ⟨h₀, q⟩``: the multipliers of the three
    sums are the plane that touches the body from above, which is the counter-body at rest.
    """
    from scipy.optimize import linprog

    touchable = np.isfinite(problem.initial_gap)
    if problem.whole is not None or not 0 < np.count_nonzero(touchable) <= _MOST_POINTS:
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
    # An array of bounds is what its documentation shows, but its types do not know.
    bounds: Any = np.stack([np.zeros(gap.size), maximum], axis=1)
    result = linprog(
        gap / deepest, A_eq=sums, b_eq=np.array([1.0, 0, 0]), bounds=bounds, method="highs-ds"
    )
    if result.status != 0:
        return None
    plane, parts = result.eqlin.marginals * deepest, np.asarray(result.x)
    # To the last digit: through the points that are neither empty nor full.
    between = (parts > _BOUND) & (parts < maximum * (1 - _BOUND))
    on = sums[:, between].T
    plane = plane + np.linalg.lstsq(on, gap[between] - on @ plane, rcond=_BOUND)[0]
    tilt: Array = -plane[1:] / spans
    return tilt if np.isfinite(tilt).all() else None


# --- Tilt of one body on another: which angles let the contact pressure balance given moments ---


# A moment this far outside what can be balanced is taken as rounding.
_EDGE = 1e-9
_MOST_CUTS = 60
# A step may overshoot by this fraction of the slope at its beginning.
_OVERSHOOT = 0.8
# Accuracy asked of a moment, as a fraction of the error before, and at the first tilt.
_PART, _BEGINNING = 0.03, 1e-2
_HALVINGS = 60
_FLATTEST = 1e-10
# About ten steps suffice, except for contacts of a few pixels, which take dozens.
_TILT_MOST_STEPS = 200


def moment_arms(shape: tuple[int, ...], pixel: tuple[float, float]) -> tuple[Array, Array]:
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
        Distance of the pixel centres from the centre of the map, over its longer side.

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
    """Return how far a moment lies outside what admissible pressures can balance.

    Parameters
    ----------
    target : ndarray, shape (2,)
        Moment (y, x) wanted.
    y, x : ndarray, shape (n,)
        Levers of the pixels that can touch.
    share : float or ndarray, shape (n,)
        Largest part of the load that a pixel can carry; ``inf`` without a ceiling.

    Returns
    -------
    float
        Distance of the moment from the nearest that can be balanced; 0 where it can be.

    Notes
    -----
    The moments that can be balanced are convex. Their outermost points in one direction after
    the other, found by loading the pixels furthest that way up to the ceiling, span more and
    more of them: towards the moment, until it is inside, or a direction has no point as far out
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
        if distance <= _EDGE or len(cuts) == _MOST_CUTS:
            return 0.0
        cut = _outermost(-nearest, y, x, share) - target
        # No point lies closer than this along the way.
        if float(cut @ nearest) >= (distance - _EDGE) * distance:
            return distance
        cuts.append(cut)
        nearest = _nearest(np.array(cuts))


def _outermost(direction: Array, y: Array, x: Array, share: float | Array) -> Array:
    """Return the moment that lies furthest in a direction."""
    along = direction[0] * y + direction[1] * x
    if np.isinf(share).all():
        best = int(along.argmax())
        return np.array([y[best], x[best]])
    order = np.argsort(-along)
    carried = np.cumsum(np.broadcast_to(share, along.shape)[order])
    # Furthest out first, each as much as it can; the last takes what is left.
    part = np.diff(np.minimum(carried, 1.0), prepend=0.0)
    return np.einsum("pn,n->p", np.stack([y[order], x[order]]), part)


def _nearest(points: Array) -> Array:
    """Return the point nearest to the origin of the convex hull of some points."""
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
    problem: Problem,
    family: Family,
    target: Array,
    pixel: tuple[float, float],
    slope: tuple[float, float],
    *,
    moment_tolerance: float,
    tolerance: float,
    max_iterations: int,
    start: Loaded | None = None,
    progress: Callable[[Step], None] | None = None,
) -> tuple[Solution, tuple[float, float]]:
    """Return the pressure and the tilt that balance a moment.

    Parameters
    ----------
    problem : Problem
        A problem under a given load on a map with free boundary; ``initial_gap`` is that
        without tilt.
    family, tolerance, max_iterations, start, progress
        As for `roughcontact.solvers.bounded.solve`.
    target : ndarray, shape (2,)
        Mean lever (y, x) wanted; `excess` tells whether any pressure has it.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    slope : (float, float)
        Slopes of the gap along y and x to start from.
    moment_tolerance : float
        Largest error of the mean lever.

    Returns
    -------
    Solution
        The solution at that tilt, with the work of all; the last one tried if none balances.
        The search starts again from where rigid bodies rest if it fails from ``slope``.
    (float, float)
        Slopes of the gap along y and x that the tilt adds.
    """
    side = max(points * edge for points, edge in zip(problem.shape, pixel, strict=True))
    response = _Response(
        problem, family, moment_arms(problem.shape, pixel), target,
        tolerance=tolerance, max_iterations=max_iterations, start=start, progress=progress,
    )  # fmt: skip
    tolerable = 0.9 * moment_tolerance
    result = response.search(np.array(slope) * side, tolerable)
    if not result and response.solution().status is not Status.CONVOLUTION_LIMIT:
        tilt = rigid_tilt(problem, moment_arms(problem.shape, pixel), target)
        if tilt is not None:
            response.search(tilt, tolerable)
    tilt = response.tilt
    return response.solution(), (float(tilt[0]) / side, float(tilt[1]) / side)


class _Response:
    """The moment at a tilt less the moment wanted, each time from the pressure before."""

    def __init__(
        self,
        problem: Problem,
        family: Family,
        levers: tuple[Array, Array],
        target: Array,
        *,
        tolerance: float,
        max_iterations: int,
        start: Loaded | None,
        progress: Callable[[Step], None] | None,
    ) -> None:
        self._problem, self._family, self._target = problem, family, target
        self._levers, self._tolerance = levers, tolerance
        self._maximum, self._start, self._progress = max_iterations, start, progress
        # Made once for all tilts.
        self._finest = family(problem.shape, (1, 1))
        self._last: Solution
        self._error: Array | None = None
        self._enough = 0.0
        self._iterations = self._convolutions = 0
        self.tilt = np.zeros(2)

    def _operator(self, shape: tuple[int, int], coarsening: tuple[int, int]) -> Operator:
        known = coarsening == (1, 1) and shape == self._finest.shape
        return self._finest if known else self._family(shape, coarsening)

    def __call__(self, tilt: Array, accuracy: float) -> Array | None:
        """Return the error of the moment, or None where no pressure was found; see `balance`."""
        self.tilt, self._error = tilt, None
        error = self._solved(accuracy)
        if error is not None and np.abs(error).max() <= self._enough and accuracy > self._tolerance:
            # This is the tilt: the result needs more accuracy than the search.
            error = self._solved(self._tolerance)
        self._error = error
        return error

    def _solved(self, accuracy: float) -> Array | None:
        (y, x), tilt = self._levers, self.tilt
        gap = self._problem.initial_gap + tilt[0] * y[self._finest.rows] + tilt[1] * x
        last = self._last = bounded.solve(
            replace(self._problem, initial_gap=gap),
            self._operator,
            tolerance=accuracy,
            max_iterations=self._maximum,
            start=self._start,
            progress=self._progress,
        )
        self._start = last.index, last.pressure
        self._iterations += last.iterations
        self._convolutions += last.convolutions
        # More accuracy than the result needs may be out of reach; less would lead nowhere.
        if last.certificate > max(accuracy, self._tolerance):
            return None
        return _mean(last, y, x, self._finest) - self._target

    def search(self, tilt: Array, moment_tolerance: float) -> bool:
        """Change the tilt from here on until the moment is right; return whether it is."""
        self._enough = moment_tolerance
        error = self(tilt, max(_BEGINNING, self._tolerance))
        if error is None:
            return False
        steepness, reach = _guess(self._problem, self._last, self.tilt, *self._levers, self._finest)
        balance(self, tilt, error, steepness, reach, tolerance=moment_tolerance)
        if self._error is not None and self._last.certificate > self._tolerance:
            # Not balanced, but a contact at this tilt.
            self._error = self._solved(self._tolerance)
        return self._error is not None and float(np.abs(self._error).max()) <= moment_tolerance

    def solution(self) -> Solution:
        """Return the last solution, with the work of all."""
        converged = self._last.certificate <= self._tolerance
        return replace(
            self._last,
            status=Status.CONVERGED if converged else self._last.status,
            iterations=self._iterations,
            convolutions=self._convolutions,
        )


def _arms(solution: Solution, y: Array, x: Array, operator: Operator) -> tuple[Array, Array, Array]:
    """Return the levers of the pixels with pressure, and the part of the load that each carries."""
    row, column = np.divmod(solution.index, x.size)
    row += operator.rows.start
    return y[row, 0], x[column], solution.pressure / operator.sums.total(solution.pressure)


def _mean(solution: Solution, y: Array, x: Array, operator: Operator) -> Array:
    """Return the mean lever of the pressure."""
    arm_y, arm_x, share = _arms(solution, y, x, operator)
    return np.array([operator.sums.dot(share, arm) for arm in (arm_y, arm_x)])


def _guess(
    problem: Problem, solution: Solution, tilt: Array, y: Array, x: Array, operator: Operator
) -> tuple[Array, float]:
    """Return how fast the moment may fall with the tilt, and how far that may hold.

    A flat circle of radius a has the vertical stiffness 2 E* a, the tilting stiffness 4/3 E* a³
    and the mean square lever a²/3 of its pressure: twice their product.
    """
    added = operator.sums.added
    *levers_of_pixels, share = _arms(solution, y, x, operator)
    arms = np.stack(levers_of_pixels)
    opened = problem.initial_gap.ravel()[solution.index] + tilt[0] * arms[0] + tilt[1] * arms[1]
    displacement = solution.gap.ravel()[solution.index] + solution.approach - opened
    # A pixel sinks by its own pressure at least; the difference loses that on steep heights.
    alone = operator.self_displacement * operator.sums.dot(share, solution.pressure)
    sunk = max(operator.sums.dot(share, displacement), alone)
    arms = arms - added(np.einsum("pn,n->p", arms, share))[:, None]
    # A pixel has some width even where it is alone.
    width = np.diag([np.ptp(y) / y.size, np.ptp(x) / x.size])
    spread = added(np.einsum("pn,qn->pq", share * arms, arms)) + width**2 / 12
    return 2 * spread / sunk, sunk / math.sqrt(np.trace(spread))


def balance(
    respond: Callable[[Array, float], Array | None],
    tilt: Array,
    error: Array,
    steepness: Array,
    reach: float,
    *,
    tolerance: float,
) -> None:
    """Change the tilt until the moment of the pressure is what it should be.

    Parameters
    ----------
    respond : callable
        ``respond(tilt, accuracy)`` returns the moment at a tilt less the moment wanted, shape
        (2,), about as exactly as asked for, or None to give up. The last call is the solution
        if the search succeeds.
    tilt : ndarray, shape (2,)
        Where to start.
    error : ndarray, shape (2,)
        What ``respond`` returned there.
    steepness : ndarray, shape (2, 2)
        A guess of how fast the moment falls with the tilt; symmetric, positive definite.
    reach : float
        Longest first step that the guess is good for.
    tolerance : float
        Largest component of the error at the end.

    Notes
    -----
    The least energy at a given tilt is a concave function of the tilt, and the moment its
    gradient: it never rises along a step. Its maximum less ``target · tilt`` is sought by
    quasi-Newton steps in a trust region, with the symmetric rank-one formula where that keeps the
    steepness positive and the BFGS formula elsewhere (Nocedal and Wright 2006, Numerical
    Optimization, secs. 4.1 and 6.2, doi:10.1007/978-0-387-40065-5).
    """
    for _ in range(_TILT_MOST_STEPS):
        size = float(np.abs(error).max())
        if size <= tolerance:
            return
        # Flatter than this it would be lost in the rounding of the other direction.
        values, axes = np.linalg.eigh(steepness)
        values = np.maximum(values, _FLATTEST * values[1])
        steepness = (axes * values) @ axes.T
        step = axes @ _step(values, axes.T @ error, reach)
        after = respond(tilt + step, _PART * size)
        if after is None:
            return
        slope, end = float(error @ step), float(after @ step)
        predicted = slope - 0.5 * float(step @ steepness @ step)
        steepness = _updated(steepness, step, error - after)
        # Along a step the gradient falls: the gain is positive as long as it is not negative at
        # the end, and about the mean of both ends times the step where it is.
        if end < -_OVERSHOOT * slope:
            reach = 0.3 * math.hypot(*step)
            continue
        if 0.5 * (slope + end) >= 0.5 * predicted:
            reach = max(reach, 3 * math.hypot(*step))
        tilt, error = tilt + step, after


def _step(steepness: Array, error: Array, reach: float) -> Array:
    """Return the step at which the error vanishes, or the best one no longer than the reach.

    Along the principal axes of the steepness.
    """
    low, high = 0.0, math.hypot(*error) / reach
    if math.hypot(*(error / steepness)) <= reach:
        return error / steepness
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if math.hypot(*(error / (steepness + middle))) > reach:
            low = middle
        else:
            high = middle
    return error / (steepness + high)


def _updated(steepness: Array, step: Array, fall: Array) -> Array:
    """Return the steepness with what was learnt from the fall of the moment along a step."""
    image = steepness @ step
    rest = fall - image
    product = float(rest @ step)
    if abs(product) > 1e-8 * math.hypot(*rest) * math.hypot(*step):
        updated: Array = steepness + np.outer(rest, rest) / product
        if np.linalg.eigvalsh(updated)[0] > 1e-4 * np.linalg.eigvalsh(steepness)[0]:
            return updated
    # Where the moment hardly falls, the steepness shrinks, but not to nothing at once.
    curvature = float(step @ image)
    lacking = max(1e-3 * curvature - float(fall @ step), 0.0)
    fall = fall + lacking / float(step @ step) * step
    return (
        steepness - np.outer(image, image) / curvature + np.outer(fall, fall) / float(fall @ step)
    )
