"""Outliers, holes and turns of a measured map: what is kept, and which way it lies."""

from __future__ import annotations

from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.errors import InputError, require_positive
from roughcontact.surface import blocks

Array = NDArray[np.float64]


MOST_FILLED = 0.3
"""Share of missing points above which a map is filled on request only."""


def remove_outliers(heights: Array, limit: float = 6.0, window: int = 5) -> Array:
    """Return the heights with spikes replaced by NaN.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights, NaN where missing.
    limit : float
        Largest deviation from the local median that is kept, in robust standard deviations.
    window : int
        Points along each side of the square whose median is taken; odd, 3 to 31.

    Returns
    -------
    ndarray, shape (ny, nx)
        A new array; what is kept keeps its bits.

    Raises
    ------
    InputError
        If the limit is not positive, or the window is even or out of bounds.

    Notes
    -----
    The median is that of the valid points of the window; beyond the edge the map goes on
    by point reflection, so that a tilt alone makes no outliers. The robust standard deviation is
    1.4826 × the median of all absolute deviations; where that is zero, as when most points equal
    their local median, 1.2533 × their mean. A spike wider than about half a window is taken as
    part of the surface. Where a form bends more within a window than the map is rough, its summit
    would count as an outlier: remove the form first.
    """
    require_positive(limit=limit)
    if not isinstance(window, (int, np.integer)) or not (3 <= window <= 31 and window % 2):
        raise InputError(
            f"must be an odd number of points from 3 to 31, got {window!r}",
            argument="window",
            value=window,
        )
    heights = np.asarray(heights, dtype=np.float64)
    deviation = np.abs(heights - _local_median(heights, int(window)))
    there = deviation[np.isfinite(deviation)]
    sigma = 1.4826 * float(np.median(there))
    if sigma == 0:
        sigma = 1.2533 * float(np.mean(there))
    kept = heights.copy()
    # Comparing with NaN is false: holes stay as they are.
    kept[deviation > limit * sigma] = np.nan
    return kept


def largest_rectangle(heights: Array) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return the rows and columns of the largest rectangle without holes.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights, NaN where missing.

    Returns
    -------
    rows, columns : (int, int)
        First index and the index after the last, as `crop` takes them; most points, and of
        several such rectangles the one that ends first.

    Raises
    ------
    InputError
        If no 2 × 2 points without a hole are left.

    Notes
    -----
    One pass over the rows. For each point of a row: how far up it is free of holes, and how far
    to the left and right that whole strip can be moved. The largest rectangle is one of them.
    """
    there = np.isfinite(heights)
    ny, nx = there.shape
    column = np.arange(nx)
    depth, left, right = (np.full(nx, start) for start in (0, 0, nx))
    best, rows, columns = 0, (0, 0), (0, 0)
    for y in range(ny):
        free = there[y]
        first = np.maximum.accumulate(np.where(free, 0, column + 1))
        last = np.minimum.accumulate(np.where(free, nx, column)[::-1])[::-1]
        depth = np.where(free, depth + 1, 0)
        left = np.where(free, np.maximum(left, first), 0)
        right = np.where(free, np.minimum(right, last), nx)
        width = right - left
        points = np.where((depth > (ny > 1)) & (width > 1), depth * width, 0)
        x = int(np.argmax(points))
        if points[x] > best:
            best = int(points[x])
            rows = (y + 1 - int(depth[x]), y + 1)
            columns = (int(left[x]), int(right[x]))
    if best == 0:
        raise InputError(
            "has no 2 × 2 points without a hole; fill the holes instead, e.g. surface.filled()",
            argument="heights",
        )
    return rows, columns


def rotate(heights: Array, angle: int = 90) -> Array:
    """Return the map turned by multiples of 90°.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights.
    angle : int
        Angle [degrees], a multiple of 90, counter-clockwise as the map is printed and drawn, row 0
        on top; negative for clockwise. 90 moves the last column to row 0:
        ``new[i, j] = old[j, nx - 1 - i]``.

    Returns
    -------
    ndarray, shape (ny, nx) or (nx, ny)
        The turned map, a new array with the same values to the bit.

    Raises
    ------
    InputError
        If the angle is not a multiple of 90.
    """
    if isinstance(angle, bool) or not isinstance(angle, Real) or angle % 90 != 0:
        raise InputError(
            f"must be a multiple of 90 degrees, got {angle!r}", argument="angle", value=angle
        )
    turned: Array = np.rot90(heights, int(angle) // 90 % 4).copy()
    return turned


def crop(heights: NDArray[Any], rows: tuple[int, int], columns: tuple[int, int]) -> NDArray[Any]:
    """Return the part of a map between two rows and two columns.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights.
    rows, columns : (int, int)
        First index and the index after the last, as in a slice but not negative.

    Returns
    -------
    ndarray, shape (rows[1] - rows[0], columns[1] - columns[0])
        The part, a new array.

    Raises
    ------
    InputError
        If the part does not lie on the map or has fewer than two rows or columns.
    """
    for name, (start, stop), length in (
        ("rows", rows, heights.shape[0]),
        ("columns", columns, heights.shape[1]),
    ):
        least = min(2, length)
        if not (0 <= start and start + least <= stop <= length):
            raise InputError(
                f"must be (start, stop) with 0 <= start, stop <= {length} and at least {least} "
                f"between them, got ({start}, {stop})",
                argument=name,
                value=(start, stop),
            )
    return heights[slice(*rows), slice(*columns)].copy()


def _local_median(heights: Array, window: int) -> Array:
    reach = window // 2
    # Odd reflection of a map of n points defines at most n - 1 beyond its edge at a time; NumPy
    # repeats it where the window is larger than the map.
    padded = np.pad(heights, reach, mode="reflect", reflect_type="odd")
    nx = heights.shape[1]
    median = np.empty_like(heights)
    for rows in blocks.of_rows(heights.shape, window**2 // 4):
        start, stop = rows.start, rows.stop
        part = np.lib.stride_tricks.sliding_window_view(
            padded[start : stop + 2 * reach], (window, window)
        )
        # NaN sorts to the end, so the median of the n valid ones sits among the first n.
        ordered = np.sort(part.reshape(stop - start, nx, -1), axis=-1)
        count = np.count_nonzero(np.isfinite(ordered), axis=-1)
        middle = [np.maximum(index, 0)[..., None] for index in ((count - 1) // 2, count // 2)]
        low, high = (
            np.take_along_axis(ordered, np.minimum(index, window**2 - 1), axis=-1)[..., 0]
            for index in middle
        )
        median[start:stop] = 0.5 * (low + high)
    return median
