"""Active-set step: the linear problem on the free pixels, by conjugate gradients."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array
from roughcontact.solvers.operator import Family, Operator, dot, norm
from roughcontact.solvers.preconditioner import Patches
from roughcontact.solvers.problem import (
    BoundedProblem,
    Limit,
    Loaded,
    remove_rounding,
    shift_to_balance,
    shift_to_sum,
)

# Relative difference up to which loads are treated as equal.
_MIN_LOAD_SHARE = 1e-12
# Number of bins of the gaps of pixels that can carry the load.
_BINS = 4096
# Certificate above which single precision suffices, absolute and over the tolerance; and the
# largest part of the certificate due to rounding.
_FAR, _TOLERANCES, _BLURRED = 3e-4, 30, 0.1


@dataclass(frozen=True, eq=False)
class Iterate:
    """Admissible pressure with its gap and certificate, on the active pixels.

    ``index`` holds all pixels with pressure or with a negative gap, ascending; ``pressure`` and
    ``gap`` are their values.
    """

    index: NDArray[np.int64]
    pressure: Array
    gap: Array
    approach: float
    certificate: float
    # Part of the certificate that rounding alone may cause; included in single precision.
    floor: float
    # Whether evaluated in the arithmetic of the problem, and not in a coarser one.
    sharp: bool
    # Tilt included in the gap.
    tilt: tuple[float, float]


class Evaluator:
    """Evaluator of pressures on the whole map.

    Far from the solution it uses single precision, which is accurate enough to approach the
    solution.
    """

    def __init__(
        self,
        problem: BoundedProblem,
        operator: Operator,
        family: Family,
        pixel: tuple[int, int],
        tolerance: float,
        max_iterations: int,
    ) -> None:
        self.problem, self.operator = problem, operator
        # The only single-precision operator of this size: patches use it too.
        self.rough = operator.to_single_precision()
        self.patches = Patches(self.rough, family, pixel)
        self.tolerance, self.max_iterations = tolerance, max_iterations
        # Certificate above which single precision suffices, and certificate of the last evaluation.
        self._far = max(_FAR, _TOLERANCES * tolerance)
        self._distance = math.inf if self.rough is not operator else 0.0
        self.unit = operator.self_displacement
        self.convolutions = 0
        # Last evaluation: displacement plus initial gap without the approach, and the active
        # pixels.
        self.open: NDArray[Any] = np.empty(problem.initial_gap.shape, operator.real)
        self._tilt = np.zeros(2)
        self.seen: Iterate | None = None

    @property
    def is_within_limit(self) -> bool:
        """Whether another convolution is allowed."""
        return self.convolutions < self.max_iterations

    def limit(self, index: NDArray[np.int64]) -> Limit:
        """Return the ceiling on some pixels."""
        limit = self.problem.limit
        return limit.ravel()[index] if isinstance(limit, np.ndarray) else limit

    def evaluate(self, index: NDArray[np.int64], pressure: Array) -> Iterate:
        """Return the iterate of a pressure, evaluated on the whole map."""
        self.seen = None
        pressure = remove_rounding(pressure, self.limit(index))
        index, pressure = select_entries(pressure > 0, index, pressure)
        if self._distance > self._far:
            seen = self._evaluate(self.rough, index, pressure)
            blurred = seen.floor > _BLURRED * seen.certificate
            self._distance = 0.0 if blurred else seen.certificate
            if seen.certificate > self.tolerance and not blurred:
                self.seen = seen
                return seen
        self.seen = self._evaluate(self.operator, index, pressure)
        self._distance = 0.0
        return self.seen

    def confirm(self, now: Iterate) -> Iterate:
        """Return an earlier iterate, evaluated last and in the arithmetic of the problem."""
        if self.seen is now and now.sharp:
            return now
        self._distance = 0.0
        return self.evaluate(now.index, now.pressure)

    def _evaluate(self, operator: Operator, index: NDArray[np.int64], pressure: Array) -> Iterate:
        total = self.problem.total
        starts = self._displace(operator, index, pressure)
        approach = self.problem.approach or 0.0
        if total is not None:
            # More pixels can only lower the approach that carries the load: this is a bound.
            approach = self._multiplier(index, pressure, total)
        loaded_pixels = index.size
        index, pressure = self._add_penetrating(operator, index, pressure, starts, approach)
        if total is not None and index.size > loaded_pixels:
            approach = self._multiplier(index, pressure, total)
        gap, moved, floor = self._pixel_residual(operator, index, pressure, approach)
        size = norm(pressure)
        if operator.real is not np.float64 or self._tilt.any():
            # Double precision would resolve this part; a tilt is returned to its last digit only.
            moved = math.hypot(moved, floor)
        return Iterate(
            index=index,
            pressure=pressure,
            gap=gap,
            approach=approach,
            certificate=moved / size if size else (math.inf if moved else 0.0),
            floor=floor / size if size else 0.0,
            sharp=operator is self.operator,
            tilt=(float(self._tilt[0]), float(self._tilt[1])),
        )

    def _displace(
        self, operator: Operator, index: NDArray[np.int64], pressure: Array
    ) -> NDArray[np.int64]:
        """Store displacement plus initial gap of the map; return the starts of the row blocks."""
        initial_gap = self.problem.initial_gap

        def visit(number: int, rows: slice, displacement: NDArray[Any]) -> None:
            np.add(displacement, initial_gap[rows], out=self.open[rows])

        support = operator.support(index)
        operator.spread(support, pressure, visit)
        self.convolutions += 1
        self._tilt = np.zeros(2)
        return support.starts

    def scale_to_load(self, index: NDArray[np.int64], pressure: Array) -> Loaded:
        """Return a pressure that can carry the load, near the pressure of another load.

        The pressure is scaled. If the ceiling of these pixels is too low, or if all saturated
        pixels would leave the ceiling as the load falls, it takes one gradient step instead, in
        which the pixels with the smallest gap receive the added load, and those deepest in contact
        stay at the ceiling.
        """
        total = self.problem.total
        carried = float(pressure.sum())
        if total is None or not carried > 0:
            return index, pressure
        limit = self.limit(index)
        leaving = total < carried * (1 - _MIN_LOAD_SHARE) and (pressure >= limit).any()
        if not leaving and np.broadcast_to(limit, index.shape).sum() > total:
            return index, pressure * (total / carried)
        starts = self._displace(self.rough, index, pressure)
        approach = self._deep_enough(total)
        index, pressure = self._add_penetrating(self.rough, index, pressure, starts, approach)
        target = self.displacement_plus_gap(index)
        target -= approach
        target /= -self.unit
        target += pressure
        carrying = self.problem.project(index, target, self.limit(index))
        return index, pressure if carrying is None else carrying

    def _deep_enough(self, total: float) -> float:
        """Return an approach at which the pixels without gap can just carry the load."""
        limit, opened = self.problem.limit, self.open.ravel()
        touchable = np.isfinite(opened)
        opened = opened[touchable]
        maximum = limit.ravel()[touchable] if isinstance(limit, np.ndarray) else None
        low, high = float(opened.min()), float(opened.max())
        carried = np.histogram(opened, _BINS, (low, high), weights=maximum)[0]
        if maximum is None:
            carried = carried * limit
        enough = int(np.searchsorted(np.cumsum(carried), total)) + 1
        return low + (high - low) * min(enough, _BINS) / _BINS

    def _pixel_residual(
        self, operator: Operator, index: NDArray[np.int64], pressure: Array, approach: float
    ) -> tuple[Array, float, float]:
        """Return the gap on some pixels, the norm of their step, and its rounding error.

        The step is ``p - clip(p - g/K₀₀, 0, limit)``. Its rounding error follows from the last
        digit of displacement, initial gap and tilt, which has no effect on pixels far beyond a
        bound.
        """
        bound, doubt = self.limit(index), self.displacement_plus_gap(index)
        gap = doubt - approach
        reach = gap / self.unit
        np.subtract(pressure, reach, out=reach)
        step = np.clip(reach, 0, bound)
        np.subtract(pressure, step, out=step)
        moved = norm(step)
        # In place: in full contact every array is as large as the map.
        np.abs(doubt, out=doubt)
        initial = self.problem.initial_gap.ravel()[index]
        doubt += np.abs(initial, out=initial)
        del initial
        if (moments := self.problem.moments) is not None:
            row, column = np.divmod(index, self.open.shape[1])
            doubt += np.abs(self._tilt[0] * moments.arms[0])[row]
            doubt += np.abs(self._tilt[1] * moments.arms[1])[column]
        doubt *= 0.5 * float(np.finfo(operator.real).eps) / self.unit
        np.add(reach, doubt, out=step)
        np.clip(step, 0, bound, out=step)
        reach -= doubt
        np.clip(reach, 0, bound, out=reach)
        step -= reach
        return gap, moved, 0.5 * norm(step)

    def displacement_plus_gap(self, index: NDArray[np.int64]) -> Array:
        """Return displacement plus initial gap of the last evaluation on some pixels."""
        return self.open.ravel()[index].astype(np.float64)

    def _multiplier(self, index: NDArray[np.int64], pressure: Array, total: float) -> float:
        values = self.displacement_plus_gap(index)
        # Subtract an offset first, so that the root finder works on values of the size of pressure.
        offset = float(values.sum()) / values.size
        values -= offset
        values /= self.unit
        np.subtract(pressure, values, out=values)
        limit, moments = self.limit(index), self.problem.moments
        if moments is None:
            return offset + self.unit * shift_to_sum(values, limit, total)
        rest = np.array([total, 0.0, 0.0])
        plane = self.unit * shift_to_balance(values, limit, moments.rows(index), rest)[1]
        self._tilt -= plane[1:]
        self.open -= plane[1] * moments.arms[0][:, None] + plane[2] * moments.arms[1]
        tilted = plane[1] * moments.target[0] + plane[2] * moments.target[1]
        return float(offset + plane[0] - tilted)

    def _add_penetrating(
        self,
        operator: Operator,
        index: NDArray[np.int64],
        pressure: Array,
        starts: NDArray[np.int64],
        approach: float,
    ) -> Loaded:
        """Add the pixels without pressure whose gap is negative."""
        nx = self.open.shape[1]
        result: dict[int, NDArray[np.int64]] = {}

        def seek(number: int, rows: slice) -> None:
            wanted = self.open[rows] < approach
            wanted.ravel()[index[starts[number] : starts[number + 1]] - rows.start * nx] = False
            pixels = np.flatnonzero(wanted)
            if pixels.size:
                result[number] = pixels + rows.start * nx

        operator.each_block(seek)
        if not result:
            return index, pressure
        new = np.concatenate([result[number] for number in sorted(result)])
        if isinstance(self.problem.limit, np.ndarray):
            new = new[self.problem.limit.ravel()[new] > 0]
        position = np.searchsorted(index, new)
        return np.insert(index, position, new), np.insert(pressure, position, 0.0)


def project_admissible(problem: BoundedProblem, start: Loaded) -> Loaded:
    """Return a pressure within bounds and load near the given one."""
    index, pressure = start
    touchable = np.isfinite(problem.initial_gap)
    if isinstance(problem.limit, np.ndarray):
        touchable &= problem.limit > 0
    index, pressure = select_entries((pressure > 0) & touchable.ravel()[index], index, pressure)
    bound = problem.limit.ravel()[index] if isinstance(problem.limit, np.ndarray) else problem.limit
    if problem.total is None:
        return index, np.clip(pressure, 0, bound)
    if index.size:
        kept = problem.project(index, pressure, bound, doubtful=True)
        if kept is not None:
            return index, kept
    # The loaded pixels cannot carry the load: start from all pixels that can touch.
    index = np.flatnonzero(touchable)
    pressure = np.zeros(index.size)
    pressure += problem.total / index.size
    if isinstance(problem.limit, np.ndarray):
        bound = problem.limit.ravel()[index]
    kept = problem.project(index, pressure, bound)
    return index, pressure if kept is None else kept


def select_entries(wanted: NDArray[np.bool_], index: NDArray[np.int64], pressure: Array) -> Loaded:
    """Return the selected entries, or the arrays themselves if all are selected."""
    return (index, pressure) if wanted.all() else (index[wanted], pressure[wanted])


def slopes(now: Iterate, moved: Array, viewer: Evaluator) -> tuple[float, float]:
    """Return the slopes of the energy at both ends of the last evaluated step.

    The energy is quadratic: its change is the mean of the slopes, its curvature their difference.
    """
    direction = moved - now.pressure
    # A shift of the approach cancels under a given load, as the step sums to zero.
    gap = viewer.displacement_plus_gap(now.index) - now.approach
    return dot(direction, now.gap), dot(direction, gap)


def project_step(now: Iterate, viewer: Evaluator, rate: float) -> Array:
    """Return the projection of a gradient step onto the admissible pressures."""
    bound, problem = viewer.limit(now.index), viewer.problem
    target = now.pressure - rate * now.gap
    if problem.total is None:
        return np.clip(target, 0, bound)
    kept = problem.project(now.index, target, bound)
    return now.pressure if kept is None else kept


def snap_to_bounds(now: Iterate, viewer: Evaluator) -> Iterate:
    """Return a solution with its pixels exactly on their bounds.

    The certificate does not distinguish a pixel at the ceiling from one just below the ceiling,
    and is insensitive to pixels with a tiny ceiling; areas are not. The last active-set step puts
    nearly all pixels on their bounds, a good start may not.
    """
    bound = viewer.limit(now.index)
    target = project_step(now, viewer, 1 / viewer.unit)
    falls = (target <= 0) & (now.pressure > 0)
    rises = (target >= bound) & (now.pressure < bound)
    if not (falls | rises).any():
        return now
    settled = viewer.evaluate(now.index, target)
    return settled if settled.certificate <= viewer.tolerance else now


# Reduction at which a linear solve stops unless the set of free pixels is already right.
_REDUCTION = 0.3
# Relative tolerance of the forces of blocks within the bounds, and maximum number of shifts.
_MISSING, _SHIFTS = 1e-3, 20
# Factor that shortens a step along the bounds, and its length below which the step is straight.
_SHORTER, _SHORTEST = 0.4, 0.1
# Curvature over K₀₀ below which there is no resistance (uniform pressure on a periodic map).
_FLAT = 1e-12
# Part of the largest mean square below which levers are treated as collinear.
_COLLINEAR_TOLERANCE = 1e-13


class _Free(NamedTuple):
    """Solution on the free pixels, which may be outside their bounds."""

    free: NDArray[np.bool_]
    x: Array
    limit: Limit
    # Block of each pixel, if the force of each block is to be preserved.
    block: NDArray[np.int64] | None = None


def active_set_step(now: Iterate, viewer: Evaluator) -> Array:
    """Return the admissible pressure after a linear solve on the free pixels."""
    result = _solve_free(now, viewer)
    return now.pressure if result is None else _restore_feasible(now, result, viewer)


def step_along_arc(now: Iterate, viewer: Evaluator) -> Iterate:
    """Return the iterate after a step along the bounds to the unbounded solution.

    The step on the free pixels is shortened until the energy or the certificate falls: the
    solution may be far outside the bounds if pixels are so narrow that differences between them
    meet hardly any resistance. The shortest step is taken straight to the minimum along its line
    (Moré and Toraldo 1991, doi:10.1137/0801008).
    """
    result = _solve_free(now, viewer, bounded=False)
    if result is None:
        return now
    first, way = now.pressure[result.free], 1.0
    while viewer.is_within_limit:
        part = result._replace(x=first + way * (result.x - first))
        moved = _restore_feasible(now, part, viewer)
        after = viewer.evaluate(now.index, moved)
        start, end = slopes(now, moved, viewer)
        if start + end < 0 or after.certificate < now.certificate:
            return after
        if way < _SHORTEST:
            if not start < 0:
                return now
            cut = start / (start - end)
            return viewer.evaluate(now.index, now.pressure + cut * (moved - now.pressure))
        way *= _SHORTER
    return now


def _solve_free(now: Iterate, viewer: Evaluator, *, bounded: bool = True) -> _Free | None:
    """Return the solution on the free pixels by conjugate gradients, or None without these.

    If ``bounded``, the iteration ends when the violation of the bounds exceeds the residual.
    """
    pressure, gap, unit = now.pressure, now.gap, viewer.unit
    bound = viewer.limit(now.index)
    # Pixels with pressure stay free even where the gap opens: the solve removes their pressure.
    free = np.where(pressure > 0, (pressure < bound) | (gap > 0), gap < 0)
    if not free.any():
        return None
    # In place where possible: in full contact every array is as large as the map.
    limit = bound[free] if isinstance(bound, np.ndarray) else bound
    centred = _centering_function(viewer, now.index[free])
    x = pressure[free]
    residual = gap[free]
    np.negative(residual, out=residual)
    centred(residual)
    first = norm(residual) / unit
    size = norm(pressure) or first
    enough = max(0.9 * viewer.tolerance, 0.1 * now.floor) * size
    free_index = now.index[free]
    patch = viewer.patches.make_patch(free_index)
    free_index = patch.index(free_index)
    support = patch.operator.support(free_index)
    precondition = patch.inverse.restrict_inverse(free_index)
    direction: Array | None = None
    response, previous = residual, 1.0
    while viewer.is_within_limit:
        z = centred(precondition(residual / unit))
        product = dot(residual, z)
        if not product > 0:
            break
        if direction is None:
            direction = z
        else:
            # Flexible conjugate gradients, because the inverse is not quite linear
            # (Golub and Ye 1999, doi:10.1137/S1064827597323415).
            direction *= -dot(response, z) / previous
            direction += z
        del z
        previous = product
        response = patch.operator.gather(support, direction)
        viewer.convolutions += 1
        curvature = dot(direction, response)
        if curvature <= _FLAT * unit * dot(direction, direction):
            # A wave without resistance: only the bounds end the step.
            x += _feasible_length(x, direction, limit) * direction
            break
        length = product / curvature
        x += length * direction
        response = centred(response)
        response *= length
        residual -= response
        error = norm(residual) / unit
        violation = _excess(x, limit) if bounded else math.inf
        if error <= enough or (bounded and violation > error):
            break
        if error < _REDUCTION * first and violation > 0.1 * error:
            break
    block = patch.inverse.block_of(free_index) if patch.operator.is_long_wave_soft else None
    return _Free(free, x, limit, block)


def _remove_mean(values: Array) -> Array:
    """Subtract the mean in place, since the approach controls the load; return the values."""
    values -= float(values.sum()) / values.size
    return values


def _centering_function(viewer: Evaluator, index: NDArray[np.int64]) -> Callable[[Array], Array]:
    """Return a function that subtracts the parts of approach and tilt on some pixels."""
    if viewer.problem.total is None:
        return lambda values: values
    if viewer.problem.moments is None:
        return _remove_mean
    return partial(_remove_projection, _orthonormal(viewer.problem.moments.rows(index)))


def _orthonormal(rows: Array) -> Array:
    """Return orthonormal rows with the same span."""
    products = np.array([[dot(one, two) for two in rows] for one in rows])
    squares, axes = np.linalg.eigh(products)
    apart = squares > _COLLINEAR_TOLERANCE * squares[-1]
    return np.array(
        [
            axis[0] * rows[0] + axis[1] * rows[1] + axis[2] * rows[2]
            for axis in (axes[:, apart] / np.sqrt(squares[apart])).T
        ]
    )


def _remove_projection(rows: Array, values: Array) -> Array:
    """Subtract the parts of approach and tilt in place; return the values."""
    for row in rows:
        values -= dot(row, values) * row
    return values


def _excess(x: Array, limit: Limit) -> float:
    """Return the norm of the violation of the bounds."""
    outside = np.clip(x, 0, limit)
    np.subtract(x, outside, out=outside)
    return norm(outside)


def _feasible_length(x: Array, direction: Array, limit: Limit) -> float:
    """Return the length of a step at which the first value reaches a bound."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ways = np.where(direction > 0, limit - x, -x) / direction
    way = float(ways[ways > 0].min(initial=math.inf))
    return way if math.isfinite(way) else 0.0


def _restore_feasible(now: Iterate, result: _Free, viewer: Evaluator) -> Array:
    """Return the pressure with the solution projected onto the bounds and the load."""
    total = viewer.problem.total
    free, x, limit, block = result
    if block is not None:
        x = _clip_by_block(x, limit, block)
    moved = now.pressure.copy()
    if total is None:
        moved[free] = np.clip(x, 0, limit)
        return moved
    # Moving only the free pixels keeps the others exactly on their bounds.
    moved[free] = 0
    held = now.index, moved
    kept = viewer.problem.project(now.index[free], x, limit, held=held, doubtful=True)
    if kept is not None:
        moved[free] = kept
        return moved
    moved[free] = x
    kept = viewer.problem.project(now.index, moved, viewer.limit(now.index))
    return now.pressure if kept is None else kept


def _clip_by_block(x: Array, limit: Limit, block: NDArray[np.int64]) -> Array:
    """Return the nearest values within the bounds that keep the force of each block.

    Approximate: if a force displaces the surface much more when moved far away than when moved
    nearby, neighbors must balance the load that the bounds change, and not all pixels alike.
    """
    number = int(block.max(initial=0)) + 1

    def sum_blocks(values: NDArray[Any]) -> NDArray[Any]:
        return np.bincount(block, values, minlength=number)

    force = np.maximum(sum_blocks(x), 0)
    kept: Array = np.clip(x, 0, limit)
    missing, shift = force - sum_blocks(kept), np.zeros(number)
    enough = _MISSING * np.abs(missing).sum()
    for _ in range(_SHIFTS):
        if np.abs(missing).sum() <= enough:
            break
        between = sum_blocks((kept > 0) & (kept < limit))
        shift += np.divide(missing, between, out=np.zeros(number), where=between > 0)
        kept = np.clip(x + shift[block], 0, limit)
        missing = force - sum_blocks(kept)
    return kept
