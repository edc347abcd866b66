"""The bounded contact problem on one grid, and on coarser ones."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.solvers.operator import Sums

Limit = float | NDArray[np.float64]
Loaded = tuple[NDArray[np.int64], NDArray[np.float64]]


@dataclass(frozen=True, eq=False)
class Moments:
    """Where the load acts on bodies that tilt until the pressure balances it.

    Parameters
    ----------
    arms : (ndarray, ndarray), shapes (ny,) and (nx,)
        Levers of the rows and of the columns.
    target : (float, float)
        Mean lever (y, x) of the pressure wanted.
    """

    arms: tuple[NDArray[np.float64], NDArray[np.float64]]
    target: tuple[float, float]

    def within(self, rows: slice) -> Moments:
        """Return the problem of some rows."""
        return replace(self, arms=(self.arms[0][rows], self.arms[1]))

    def rows(self, index: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return ones and both distances from the target of some pixels, shape (3, n)."""
        row, column = np.divmod(index, self.arms[1].size)
        result = np.ones((3, index.size))
        result[1] = self.arms[0][row] - self.target[0]
        result[2] = self.arms[1][column] - self.target[1]
        return result


@dataclass(frozen=True, eq=False)
class BoundedProblem:
    """A bounded contact problem on one grid.

    Parameters
    ----------
    initial_gap : ndarray, shape (ny, nx)
        h₀ [m]; ``inf`` where the bodies never touch.
    limit : float or ndarray, shape (ny, nx)
        Ceiling of the pressure [Pa]; ``inf`` without one.
    total : float, optional
        Sum of the pressures wanted [Pa]: load over pixel area.
    approach : float, optional
        ω [m]; exactly one of ``total`` and ``approach`` is given.
    whole : (int, int), optional
        Grid points of the whole map, where other processes hold a part of it; the maps above have
        the rows of this process.
    moments : Moments, optional
        Where ``total`` acts; the bodies then tilt.
    """

    initial_gap: NDArray[Any]
    limit: Limit
    total: float | None = None
    approach: float | None = None
    whole: tuple[int, int] | None = None
    moments: Moments | None = None

    def project(
        self,
        index: NDArray[np.int64],
        values: NDArray[np.float64],
        limit: Limit,
        sums: Sums,
        held: Loaded | None = None,
        doubtful: bool = False,
    ) -> NDArray[np.float64] | None:
        """Return the nearest pressure on some pixels that keeps bounds, load and moments.

        Beside pressures ``held`` on other pixels; None where no pressure does, which of a load
        alone is looked at only where it is ``doubtful``.
        """
        assert self.total is not None
        if self.moments is not None:
            rest = np.array([self.total, 0.0, 0.0])
            if held is not None:
                rest -= [sums.dot(row, held[1]) for row in self.moments.rows(held[0])]
            return shift_to_balance(values, limit, self.moments.rows(index), rest, sums)[0]
        remaining = self.total if held is None else self.total - sums.total(held[1])
        if doubtful and not 0 <= remaining <= sums.total(np.broadcast_to(limit, values.shape)):
            return None
        return project(values, limit, remaining, sums)

    @property
    def shape(self) -> tuple[int, int]:
        """Grid points of the whole map."""
        if self.whole is not None:
            return self.whole
        ny, nx = self.initial_gap.shape
        return ny, nx


def coarsen_problem(problem: BoundedProblem) -> BoundedProblem:
    """Return the problem on pixels of twice the length; odd edges are repeated."""
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
        # Infinite times zero is not zero: where nothing touches nothing is carried.
        limit = np.where(touchable, limit, 0)
    if isinstance(limit, np.ndarray):
        limit = _block_mean(limit)
    return BoundedProblem(
        initial_gap=gap,
        limit=limit,
        # A profile has a single row, on any grid.
        total=None if problem.total is None else problem.total / (4 if problem.shape[0] > 1 else 2),
        approach=problem.approach,
        whole=problem.whole and _halve_map(problem.whole),
        moments=problem.moments and _thin_pixels(problem.moments, _halve_map(problem.shape)),
    )


def prolong_pressure(start: Loaded, width: int, shape: tuple[int, ...]) -> Loaded:
    """Return each pressure on the four pixels that make up its coarse pixel."""
    coarse_index, coarse_pressure = start
    row, column = np.divmod(coarse_index, width)
    count = np.bincount(row)
    first = np.cumsum(count) - count
    # A coarse row becomes two fine rows: this is where its pixels begin in ascending order.
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
    if inside.all():
        return index, pressure
    return index[inside], pressure[inside]


def _thin_pixels(moments: Moments, shape: tuple[int, ...]) -> Moments:
    """Return the problem on fewer pixels; blocks end at the edges, so that balance is kept."""
    y, x = (
        np.linspace(arms[0], arms[-1], points)
        for arms, points in zip(moments.arms, shape, strict=True)
    )
    return replace(moments, arms=(y, x))


def _halve_map(shape: tuple[int, int]) -> tuple[int, int]:
    return -(-shape[0] // 2), -(-shape[1] // 2)


def _block_mean(values: NDArray[Any]) -> NDArray[np.float64]:
    ny, nx = values.shape
    if ny % 2 or nx % 2:
        values = np.pad(values, ((0, ny % 2), (0, nx % 2)), mode="edge")
    mean: NDArray[np.float64] = values[::2, ::2] + values[1::2, ::2]
    mean += values[::2, 1::2]
    mean += values[1::2, 1::2]
    mean *= 0.25
    return mean


# --- Projection on the admissible pressures: between zero and the ceiling, with a given sum ---


# Enough to halve the largest number, every other step, down to the smallest.
_MAX_STEPS = 4300
_ROUNDING = 1e-15
# Part of the sum that may be left after a shift, and how often one is added to another.
_BALANCE_TOLERANCE = 1e-12
_MOST_PASSES = 4
# Steps of Newton's method for load and moments that may gain nothing, the least slope relatively;
# what may be missing of the load before the last digits, and how fast values grow.
_MOST_FRUITLESS, _FLATTEST, _ROUGH, _STEEPER = 10, 1e-13, 1e-6, 4.0
# Part of the slope left at the end of a step, and the longest step.
_NEARLY, _LONGEST = 0.1, 1e60
# Relative to the limit, or to the largest value: values this near to a bound are put on it.
_ROUNDING_SHARE = 1e-12


def shift_to_sum(
    values: NDArray[np.float64], limit: float | NDArray[np.float64], total: float, sums: Sums
) -> float:
    """Return λ such that the sum of ``clip(values + λ, 0, limit)`` is ``total``.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Any real numbers.
    limit : float or ndarray, shape (n,)
        Upper bounds, positive; ``inf`` where there is none.
    total : float
        Sum wanted, between 0 and the sum of the limits.
    sums : Sums
        Sums over all values, those of other processes included.

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
    low, high = _bracket(values, limit, total, sums)
    if total <= 0:
        return low
    shift = min(max(0.0, low), high)
    tried: set[float] = set()
    halve = False
    while len(tried) < _MAX_STEPS and shift not in tried:
        tried.add(shift)
        moved = values + shift
        excess = sums.total(np.clip(moved, 0, limit)) - total
        # Precision of a sum of this number of terms.
        if abs(excess) <= _ROUNDING * total:
            break
        width = high - low
        if excess > 0:
            high = shift
        else:
            low = shift
        free = sums.count((moved > 0) & (moved < limit))
        step = shift - excess / free if free and not halve else np.nan
        # Newton's steps may creep along a staircase of values: then halve the bracket in between.
        halve = not halve and high - low > 0.5 * width
        usable = low <= step <= high and step not in tried
        shift = step if usable else 0.5 * (low + high)
    return shift


def _bracket(
    values: NDArray[np.float64], limit: float | NDArray[np.float64], total: float, sums: Sums
) -> tuple[float, float]:
    """Return a bracket of the shift at which the sum is ``total``."""
    limits = np.broadcast_to(limit, values.shape)
    unlimited = np.isinf(limits)
    if sums.count(unlimited):
        # One value without limit can carry everything.
        high = total - sums.largest(values[unlimited])
    else:
        high = sums.largest(limits - values)
    low = -sums.largest(values)
    return min(low, high), max(low, high)


def project(
    values: NDArray[np.float64], limit: float | NDArray[np.float64], total: float, sums: Sums
) -> NDArray[np.float64]:
    """Return the point nearest to ``values`` with entries in ``[0, limit]`` and sum ``total``.

    Parameters
    ----------
    values, limit, total, sums
        As for `shift_to_sum`.

    Returns
    -------
    ndarray, shape (n,)
        The projection; entries at a bound are exactly the bound.
    """
    for _ in range(_MOST_PASSES):
        shift = shift_to_sum(values, limit, total, sums)
        projected = values + shift
        np.clip(projected, 0, limit, out=projected)
        # Resolution limit of the shift, if the values dwarf the limit.
        missing = total - sums.total(projected)
        free = (projected > 0) & (projected < limit)
        count = sums.count(free)
        if missing and count:
            share = missing / count
            np.clip(projected + share, 0, limit, out=projected, where=free)
        off = (
            abs(missing) > _BALANCE_TOLERANCE * total
            and abs(total - sums.total(projected)) > _BALANCE_TOLERANCE * total
        )
        if not off:
            break
        # Where they dwarf the total, it may leave everything. Once they are shifted, the values
        # that matter lie near their bounds: among them a second shift is resolved.
        values = values + shift
    return projected


def shift_to_balance(
    values: NDArray[np.float64],
    limit: Limit,
    rows: NDArray[np.float64],
    rest: NDArray[np.float64],
    sums: Sums,
) -> tuple[NDArray[np.float64] | None, NDArray[np.float64]]:
    """Return the nearest point with entries in ``[0, limit]`` and given sums, and its multipliers.

    Parameters
    ----------
    values, limit, sums
        As for `shift_to_sum`.
    rows : ndarray, shape (3, n)
        Weights of the entries in the three sums; those of the first are one.
    rest : ndarray, shape (3,)
        The sums wanted.

    Returns
    -------
    ndarray, shape (n,), or None
        ``clip(values + λ rows, 0, limit)``; None where it does not have these sums.
    ndarray, shape (3,)
        λ.

    Notes
    -----
    The sums are the gradient of a convex function of λ, piecewise quadratic, whose minimum is
    found by Newton's method. Where the values dwarf what the entries may be, hardly an entry is
    between its bounds: then values of the size of the entries come first, and grow.
    """
    kept, enough = np.zeros(3), _BALANCE_TOLERANCE * rest[0]
    if not (sums.size(values) and rest[0] > 0):
        return None, kept
    shift, error = _balance_multipliers(values, limit, rows, rest, sums, kept)
    if error > _ROUGH * rest[0]:
        steep = sums.largest(values) - sums.smallest(values)
        steep = max(steep * sums.size(values) / rest[0], 1.0)
        shift, error = _balance_multipliers(values / steep, limit, rows, rest, sums, kept)
        if error > _ROUGH * rest[0]:
            return None, kept
        while steep > 1:
            flatter = max(steep / _STEEPER, 1.0)
            shift *= steep / flatter
            steep = flatter
            shift = _balance_multipliers(values / steep, limit, rows, rest, sums, shift)[0]
    for _ in range(_MOST_PASSES):
        kept += shift
        # Where the values dwarf the sums, only among those shifted before a shift is resolved.
        values = values + _combined(rows, shift)
        shift, error = _balance_multipliers(values, limit, rows, rest, sums, np.zeros(3))
        if error <= enough:
            break
    kept += shift
    result = np.clip(values + _combined(rows, shift), 0, limit)
    return (result if error <= enough else None), kept


def _balance_multipliers(
    values: NDArray[np.float64],
    limit: Limit,
    rows: NDArray[np.float64],
    rest: NDArray[np.float64],
    sums: Sums,
    shift: NDArray[np.float64],
) -> tuple[NDArray[np.float64], float]:
    """Return the multipliers of `shift_to_balance` by Newton's method, and what is missing."""
    best, least, fruitless = shift, math.inf, 0
    while fruitless < _MOST_FRUITLESS:
        moved = values + _combined(rows, shift)
        clipped = np.clip(moved, 0, limit)
        error = np.array([sums.dot(row, clipped) for row in rows]) - rest
        size = float(np.abs(error).max())
        fruitless += 1
        if size < least:
            fruitless = fruitless if size > 0.9 * least else 0
            best, least = shift, size
        if size <= _ROUNDING * rest[0]:
            break
        free = rows[:, (clipped == moved) & (moved > 0)]
        slope = np.array([[sums.dot(one, two) for two in free] for one in free])
        # Flatter than this nothing is resolved; no entry may be free.
        slope[np.diag_indices(3)] += _FLATTEST * max(float(np.trace(slope)), 1.0)
        step = -np.linalg.solve(slope, error)
        length = _length(float(step @ error), moved, _combined(rows, step), limit, sums)
        if not length < math.inf:
            break
        shift = shift + length * step
    return best, least


def _combined(rows: NDArray[np.float64], factors: NDArray[np.float64]) -> NDArray[np.float64]:
    result: NDArray[np.float64] = factors[0] * rows[0]
    result += factors[1] * rows[1]
    result += factors[2] * rows[2]
    return result


def _length(
    start: float, moved: NDArray[np.float64], along: NDArray[np.float64], limit: Limit, sums: Sums
) -> float:
    """Return where the slope along a step is nearly zero, ``start`` at its beginning.

    It never falls along the step; infinite where it stays below zero.
    """
    beginning = sums.dot(along, np.clip(moved, 0, limit))
    low, high = 0.0, math.inf
    length = 1.0
    while high - low > _ROUNDING * length and length < _LONGEST:
        slope = start + sums.dot(along, np.clip(moved + length * along, 0, limit)) - beginning
        if abs(slope) <= _NEARLY * abs(start):
            return length
        low, high = (low, length) if slope > 0 else (length, high)
        if high == math.inf:
            length *= 4
        else:
            length = 0.5 * (low + high) if low > 0.1 * high else 0.25 * high
    return length if length < _LONGEST else math.inf


def remove_rounding(
    pressure: NDArray[np.float64], limit: float | NDArray[np.float64], sums: Sums
) -> NDArray[np.float64]:
    """Return the pressure with what rounding left near a bound put on the bound.

    Parameters
    ----------
    pressure : ndarray, shape (n,)
        Values in ``[0, limit]``.
    limit : float or ndarray, shape (n,)
        Upper bounds.
    sums : Sums
        Sums over all pixels, those of other processes included.

    Returns
    -------
    ndarray, shape (n,)
        The values, in which rounding no longer decides whether a pixel touches or is saturated.
    """
    dust = _ROUNDING_SHARE * np.minimum(limit, sums.largest(pressure, floor=0))
    cleaned = np.where(pressure > limit - dust, limit, pressure)
    cleaned[cleaned < dust] = 0
    return cleaned
