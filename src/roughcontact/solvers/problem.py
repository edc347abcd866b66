"""Bounded contact problem on one grid, and on coarser grids."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array
from roughcontact.solvers.operator import dot

Limit = float | Array
Loaded = tuple[NDArray[np.int64], Array]


@dataclass(frozen=True, eq=False)
class Moments:
    """Point of action of a load on bodies that tilt until the pressure balances the load.

    Parameters
    ----------
    arms : (ndarray, ndarray), shapes (ny,) and (nx,)
        Levers of the rows and of the columns.
    target : (float, float)
        Required mean lever (y, x) of the pressure.
    """

    arms: tuple[Array, Array]
    target: tuple[float, float]

    def rows(self, index: NDArray[np.int64]) -> Array:
        """Return ones and both distances from the target of some pixels, shape (3, n)."""
        row, column = np.divmod(index, self.arms[1].size)
        result = np.ones((3, index.size))
        result[1] = self.arms[0][row] - self.target[0]
        result[2] = self.arms[1][column] - self.target[1]
        return result


@dataclass(frozen=True, eq=False)
class BoundedProblem:
    """Bounded contact problem on one grid.

    Parameters
    ----------
    initial_gap : ndarray, shape (ny, nx)
        h₀ [m]; ``inf`` where the bodies never touch.
    limit : float or ndarray, shape (ny, nx)
        Ceiling of the pressure [Pa]; ``inf`` without one.
    total : float, optional
        Required sum of the pressures [Pa]: load over pixel area.
    approach : float, optional
        ω [m]; exactly one of ``total`` and ``approach`` is given.
    moments : Moments, optional
        Point of action of ``total``; the bodies then tilt.
    """

    initial_gap: NDArray[Any]
    limit: Limit
    total: float | None = None
    approach: float | None = None
    moments: Moments | None = None

    def project(
        self,
        index: NDArray[np.int64],
        values: Array,
        limit: Limit,
        held: Loaded | None = None,
        doubtful: bool = False,
    ) -> Array | None:
        """Return the nearest pressure on some pixels that keeps bounds, load and moments.

        The pressures ``held`` on other pixels contribute to load and moments. None if there is no
        such pressure; with a load alone, this is checked only if ``doubtful``.
        """
        assert self.total is not None
        if self.moments is not None:
            rest = np.array([self.total, 0.0, 0.0])
            if held is not None:
                rest -= [dot(row, held[1]) for row in self.moments.rows(held[0])]
            return shift_to_balance(values, limit, self.moments.rows(index), rest)[0]
        remaining = self.total if held is None else self.total - float(held[1].sum())
        if doubtful and not 0 <= remaining <= np.broadcast_to(limit, values.shape).sum():
            return None
        return project(values, limit, remaining)

    @property
    def shape(self) -> tuple[int, int]:
        """Grid points of the map."""
        ny, nx = self.initial_gap.shape
        return ny, nx


def coarsen_problem(problem: BoundedProblem) -> BoundedProblem:
    """Return the problem on pixels of twice the edge length; odd edges are repeated."""
    gap, limit = problem.initial_gap, problem.limit
    touchable = np.isfinite(gap)
    if touchable.all():
        gap = _block_mean(gap)
    else:
        weight = _block_mean(touchable.astype(np.float32))
        gap = _block_mean(np.where(touchable, gap, 0))
        with np.errstate(divide="ignore", invalid="ignore"):
            gap = np.where(weight > 0, gap / weight, np.inf)
        if not isinstance(limit, np.ndarray):
            limit = np.full(touchable.shape, limit)
        # Infinity times zero is not zero: pixels that never touch carry no load.
        limit = np.where(touchable, limit, 0)
    if isinstance(limit, np.ndarray):
        limit = _block_mean(limit)
    return BoundedProblem(
        initial_gap=gap,
        limit=limit,
        # A profile has a single row, on any grid.
        total=None if problem.total is None else problem.total / (4 if problem.shape[0] > 1 else 2),
        approach=problem.approach,
        moments=problem.moments and _thin_pixels(problem.moments, gap.shape),
    )


def prolong_pressure(start: Loaded, width: int, shape: tuple[int, ...]) -> Loaded:
    """Return the pressure of each coarse pixel on its four fine pixels."""
    coarse_index, coarse_pressure = start
    row, column = np.divmod(coarse_index, width)
    count = np.bincount(row)
    first = np.cumsum(count) - count
    # A coarse row becomes two fine rows: positions of its pixels in ascending order.
    place = 4 * first[row] + 2 * (np.arange(row.size) - first[row])
    index = np.empty(4 * row.size, np.int64)
    pressure = np.empty(4 * row.size)
    inside = np.empty(4 * row.size, bool)
    for down in (0, 1):
        for right in (0, 1):
            fine_row, fine_column = 2 * row + down, 2 * column + right
            position = place + down * 2 * count[row] + right
            index[position] = fine_row * shape[1] + fine_column
            pressure[position] = coarse_pressure
            inside[position] = (fine_row < shape[0]) & (fine_column < shape[1])
    return (index, pressure) if inside.all() else (index[inside], pressure[inside])


def _thin_pixels(moments: Moments, shape: tuple[int, ...]) -> Moments:
    """Return the moments on a coarser grid with the same outermost levers."""
    y, x = (
        np.linspace(arms[0], arms[-1], points)
        for arms, points in zip(moments.arms, shape, strict=True)
    )
    return replace(moments, arms=(y, x))


def _block_mean(values: NDArray[Any]) -> Array:
    ny, nx = values.shape
    if ny % 2 or nx % 2:
        values = np.pad(values, ((0, ny % 2), (0, nx % 2)), mode="edge")
    mean: Array = values[::2, ::2] + values[1::2, ::2]
    mean += values[::2, 1::2]
    mean += values[1::2, 1::2]
    mean *= 0.25
    return mean


# Enough to halve the largest number down to the smallest, every other step.
_MAX_STEPS = 4300
_ROUNDING = 1e-15
# Relative error of the sum after a shift, and maximum number of added shifts.
_BALANCE_TOLERANCE = 1e-12
_MAX_PASSES = 4
# Newton's method for load and moments: maximum steps without gain, minimum relative slope, relative
# error before the last digits, and growth of scaled values per step.
_MOST_FRUITLESS, _FLATTEST, _ROUGH, _STEEPER = 10, 1e-13, 1e-6, 4.0
# Relative slope at the end of a step, and the longest step.
_NEARLY, _LONGEST = 0.1, 1e60
# Relative to the limit, or to the largest value: values closer to a bound are set to the bound.
_ROUNDING_SHARE = 1e-12
# Part of a sum up to which it is nearly that of the limits.
_NEARLY_FULL = 1e-3


def shift_to_sum(values: Array, limit: float | Array, total: float) -> float:
    """Return λ such that the sum of ``clip(values + λ, 0, limit)`` is ``total``.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Any real numbers.
    limit : float or ndarray, shape (n,)
        Upper bounds, positive; ``inf`` without a bound.
    total : float
        Required sum, between 0 and the sum of the limits.

    Returns
    -------
    float
        The shift. The sum is a piecewise linear, non-decreasing function of it; Newton's method
        on such a function ends after finitely many steps, and a bracket guards it.

    Notes
    -----
    ``clip(values + λ, 0, limit)`` is the Euclidean projection of ``values`` on the set, and λ the
    multiplier of its sum (Pardalos and Kovoor 1990, doi:10.1007/BF01585748).
    """
    low, high = _bracket(values, limit, total)
    if total <= 0:
        return low
    shift = min(max(0.0, low), high)
    tried: set[float] = set()
    halve = False
    while len(tried) < _MAX_STEPS and shift not in tried:
        tried.add(shift)
        moved = values + shift
        excess = float(np.clip(moved, 0, limit).sum()) - total
        # Precision of a sum of this number of terms.
        if abs(excess) <= _ROUNDING * total:
            break
        width = high - low
        if excess > 0:
            high = shift
        else:
            low = shift
        free = int(np.count_nonzero((moved > 0) & (moved < limit)))
        step = shift - excess / free if free and not halve else np.nan
        # Newton steps may creep along a staircase of values: then halve the bracket in between.
        halve = not halve and high - low > 0.5 * width
        usable = low <= step <= high and step not in tried
        shift = step if usable else 0.5 * (low + high)
    return shift


def _bracket(values: Array, limit: float | Array, total: float) -> tuple[float, float]:
    """Return a bracket of the shift at which the sum is ``total``."""
    limits = np.broadcast_to(limit, values.shape)
    unlimited = np.isinf(limits)
    if unlimited.any():
        # One value without limit can carry everything.
        high = total - float(values[unlimited].max(initial=-math.inf))
    else:
        high = float((limits - values).max(initial=-math.inf))
    low = -float(values.max(initial=-math.inf))
    return min(low, high), max(low, high)


def project(values: Array, limit: float | Array, total: float) -> Array:
    """Return the nearest point to ``values`` in ``[0, limit]`` with the sum ``total``.

    Parameters
    ----------
    values, limit, total
        As for `shift_to_sum`.

    Returns
    -------
    ndarray, shape (n,)
        The projection; entries at a bound are exactly the bound.
    """
    for _ in range(_MAX_PASSES):
        shift = shift_to_sum(values, limit, total)
        projected = values + shift
        np.clip(projected, 0, limit, out=projected)
        # Resolution limit of the shift, if the values are much larger than the limit.
        missing = total - float(projected.sum())
        free = (projected > 0) & (projected < limit)
        count = int(np.count_nonzero(free))
        if missing and count:
            share = missing / count
            np.clip(projected + share, 0, limit, out=projected, where=free)
        off = (
            abs(missing) > _BALANCE_TOLERANCE * total
            and abs(total - float(projected.sum())) > _BALANCE_TOLERANCE * total
        )
        if not off:
            break
        # If the values are much larger than the total, one shift may leave all of it. After the
        # shift, the relevant values are near their bounds, where a second shift is resolved.
        values = values + shift
    return projected


def shift_to_balance(
    values: Array, limit: Limit, rows: Array, rest: Array
) -> tuple[Array | None, Array]:
    """Return the nearest point in ``[0, limit]`` with given sums, and its multipliers.

    Parameters
    ----------
    values, limit
        As for `shift_to_sum`.
    rows : ndarray, shape (3, n)
        Weights of the entries in the three sums; those of the first are one.
    rest : ndarray, shape (3,)
        Required sums.

    Returns
    -------
    ndarray, shape (n,), or None
        ``clip(values + λ rows, 0, limit)``; None if it does not have these sums.
    ndarray, shape (3,)
        λ.

    Notes
    -----
    The sums are the gradient of a convex function of λ, piecewise quadratic, whose minimum is
    found by Newton's method. Where this fails for sums that are nearly those of the limits, what
    the entries lack of their limits is found, which has more digits.
    """
    result, shift = _balance(values, limit, rows, rest)
    limits = np.broadcast_to(limit, values.shape)
    if result is None and limits.sum() - rest[0] < _NEARLY_FULL * rest[0]:
        missing = np.array([dot(row, limits) for row in rows]) - rest
        lack, opposite = _balance(limits - values, limit, rows, missing)
        if lack is not None:
            return limits - lack, -opposite
    return result, shift


def _balance(values: Array, limit: Limit, rows: Array, rest: Array) -> tuple[Array | None, Array]:
    """Return the result of `shift_to_balance` by Newton's method.

    If the values are much larger than the sums, hardly any entry is between its bounds: then the
    values are scaled down first, and grow in steps.
    """
    kept, enough = np.zeros(3), _BALANCE_TOLERANCE * rest[0]
    if not (values.size and rest[0] > 0):
        return None, kept
    shift, error = _balance_multipliers(values, limit, rows, rest, kept)
    if error > _ROUGH * rest[0]:
        # Pixels of a start that never touch are infinitely far from it.
        known = values[np.isfinite(values)]
        steep = float(known.max(initial=-math.inf)) - float(known.min(initial=math.inf))
        steep = max(steep * values.size / rest[0], 1.0)
        shift, error = _balance_multipliers(values / steep, limit, rows, rest, kept)
        if error > _ROUGH * rest[0]:
            return None, kept
        while steep > 1:
            flatter = max(steep / _STEEPER, 1.0)
            shift *= steep / flatter
            steep = flatter
            shift = _balance_multipliers(values / steep, limit, rows, rest, shift)[0]
    for _ in range(_MAX_PASSES):
        kept += shift
        # If the values are much larger than the sums, a shift is resolved only after a first one.
        values = values + _combine(rows, shift)
        shift, error = _balance_multipliers(values, limit, rows, rest, np.zeros(3))
        if error <= enough:
            break
    kept += shift
    result = np.clip(values + _combine(rows, shift), 0, limit)
    return (result if error <= enough else None), kept


def _balance_multipliers(
    values: Array, limit: Limit, rows: Array, rest: Array, shift: Array
) -> tuple[Array, float]:
    """Return the multipliers of `shift_to_balance` by Newton's method, and their error."""
    best, least, fruitless = shift, math.inf, 0
    while fruitless < _MOST_FRUITLESS:
        moved = values + _combine(rows, shift)
        clipped = np.clip(moved, 0, limit)
        error = np.array([dot(row, clipped) for row in rows]) - rest
        size = float(np.abs(error).max())
        fruitless += 1
        if size < least:
            fruitless = fruitless if size > 0.9 * least else 0
            best, least = shift, size
        if size <= _ROUNDING * rest[0]:
            break
        free = rows[:, (clipped == moved) & (moved > 0)]
        slope = np.array([[dot(one, two) for two in free] for one in free])
        # A smaller slope is not resolved, and there may be no free entry.
        slope[np.diag_indices(3)] += _FLATTEST * max(float(np.trace(slope)), 1.0)
        step = -np.linalg.solve(slope, error)
        length = _length(float(step @ error), moved, _combine(rows, step), limit)
        if not length < math.inf:
            break
        shift = shift + length * step
    return best, least


def _combine(rows: Array, factors: Array) -> Array:
    result: Array = factors[0] * rows[0]
    result += factors[1] * rows[1]
    result += factors[2] * rows[2]
    return result


def _length(start: float, moved: Array, along: Array, limit: Limit) -> float:
    """Return the length of a step at which its slope is nearly zero.

    The slope is ``start`` at zero length and never decreases; infinite if it stays negative.
    """
    beginning = dot(along, np.clip(moved, 0, limit))
    low, high = 0.0, math.inf
    length = 1.0
    while high - low > _ROUNDING * length and length < _LONGEST:
        slope = start + dot(along, np.clip(moved + length * along, 0, limit)) - beginning
        if abs(slope) <= _NEARLY * abs(start):
            return length
        low, high = (low, length) if slope > 0 else (length, high)
        if high == math.inf:
            length *= 4
        else:
            length = 0.5 * (low + high) if low > 0.1 * high else 0.25 * high
    return length if length < _LONGEST else math.inf


def remove_rounding(pressure: Array, limit: float | Array) -> Array:
    """Return the pressure with values within rounding of a bound set to the bound.

    Parameters
    ----------
    pressure : ndarray, shape (n,)
        Values in ``[0, limit]``.
    limit : float or ndarray, shape (n,)
        Upper bounds.

    Returns
    -------
    ndarray, shape (n,)
        The values, in which rounding does not decide whether a pixel is in contact or saturated.
    """
    dust = _ROUNDING_SHARE * np.minimum(limit, float(pressure.max(initial=0)))
    cleaned = np.where(pressure > limit - dust, limit, pressure)
    cleaned[cleaned < dust] = 0
    return cleaned
