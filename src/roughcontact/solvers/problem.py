"""The bounded contact problem on one grid, and on coarser ones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.solvers.operator import Sums

Limit = float | NDArray[np.float64]
Loaded = tuple[NDArray[np.int64], NDArray[np.float64]]


@dataclass(frozen=True, eq=False)
class Problem:
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
    """

    initial_gap: NDArray[Any]
    limit: Limit
    total: float | None = None
    approach: float | None = None
    whole: tuple[int, int] | None = None

    @property
    def shape(self) -> tuple[int, int]:
        """Grid points of the whole map."""
        if self.whole is not None:
            return self.whole
        ny, nx = self.initial_gap.shape
        return ny, nx


def coarsened(problem: Problem) -> Problem:
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
    return Problem(
        initial_gap=gap,
        limit=limit,
        # A profile has a single row, on any grid.
        total=None if problem.total is None else problem.total / (4 if problem.shape[0] > 1 else 2),
        approach=problem.approach,
        whole=problem.whole and _halved(problem.whole),
    )


def prolonged(start: Loaded, width: int, shape: tuple[int, ...]) -> Loaded:
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


def _halved(shape: tuple[int, int]) -> tuple[int, int]:
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
_LEFT = 1e-12
_MOST_PASSES = 4
# Relative to the limit, or to the largest value: values this near to a bound are put on it.
_DUST = 1e-12


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
        # As exact as a sum of so many numbers can be.
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
    """Return shifts below and above which the sum cannot lie on its way to ``total``."""
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
        # What the resolution of the shift leaves, if the values dwarf the limit.
        missing = total - sums.total(projected)
        free = (projected > 0) & (projected < limit)
        count = sums.count(free)
        if missing and count:
            share = missing / count
            np.clip(projected + share, 0, limit, out=projected, where=free)
        off = abs(missing) > _LEFT * total and abs(total - sums.total(projected)) > _LEFT * total
        if not off:
            break
        # Where they dwarf the total, it may leave everything. Once they are shifted, the values
        # that matter lie near their bounds: among them a second shift is resolved.
        values = values + shift
    return projected


def without_dust(
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
    dust = _DUST * np.minimum(limit, sums.largest(pressure, floor=0))
    cleaned = np.where(pressure > limit - dust, limit, pressure)
    cleaned[cleaned < dust] = 0
    return cleaned
