"""The bounded contact problem on one grid, and on coarser ones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

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
            at = place + down * 2 * count[row] + right
            index[at] = fine_row * shape[1] + fine_column
            pressure[at] = coarse_pressure
            inside[at] = (fine_row < shape[0]) & (fine_column < shape[1])
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
