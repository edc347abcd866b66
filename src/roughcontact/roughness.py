"""Roughness parameters of a height map, after ISO 25178-2."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from roughcontact.errors import InputError

# Values per block of rows: temporaries of 8 MiB, whatever the size of the map.
_BLOCK = 2**20


def rms_height(heights: NDArray[np.float64]) -> float:
    """Return the root-mean-square height about the mean, Sq.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights, NaN where missing; missing points are left out of the sums.

    Returns
    -------
    float
        Sq, in the unit of the heights.

    Raises
    ------
    InputError
        If every point is missing.

    References
    ----------
    ISO 25178-2:2021, root mean square height; the mean is subtracted here, nothing else.

    Examples
    --------
    >>> rms_height(np.array([[1.0, 3.0], [np.nan, 2.0]])) ** 2  # doctest: +ELLIPSIS
    0.666...
    """
    total, count = 0.0, 0
    for rows in _blocks(heights.shape):
        count += int(np.count_nonzero(~np.isnan(heights[rows])))
        total += float(np.nansum(heights[rows]))
    if count == 0:
        raise InputError("heights has no finite value: every point is missing")
    mean = total / count
    squares, rest = 0.0, 0.0
    for rows in _blocks(heights.shape):
        deviation = heights[rows] - mean
        rest += float(np.nansum(deviation))
        squares += float(np.nansum(np.square(deviation, out=deviation)))
    # The second term takes out the rounding of the mean of a map far from zero height.
    return float(np.sqrt(max(squares / count - (rest / count) ** 2, 0.0)))


def rms_gradient(heights: NDArray[np.float64], pixel: tuple[float, float]) -> float:
    """Return the root-mean-square gradient, Sdq.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights [m], NaN where missing.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].

    Returns
    -------
    float
        Sdq, a slope without unit. A point counts where both of its differences are defined.

    Raises
    ------
    InputError
        If no point has both differences.

    Notes
    -----
    The standard defines Sdq² as the mean of ``(∂z/∂x)² + (∂z/∂y)²`` and leaves the differences
    open. Here they are the first differences to the neighbours before,
    ``(z[j, i] - z[j, i-1])/dx`` and ``(z[j, i] - z[j-1, i])/dy``, over the (ny - 1)(nx - 1) points
    that have both: the shortest distance measured counts in full, where central differences
    would pass over it.

    References
    ----------
    ISO 25178-2:2021, root mean square gradient; the differences after Stout et al., The
    development of methods for the characterisation of roughness in three dimensions (1993),
    EUR 15178 EN.

    Examples
    --------
    >>> x = np.arange(4.0)
    >>> rms_gradient(3.0 * x + 4.0 * x[:, None], (1.0, 1.0))
    5.0
    """
    dy, dx = pixel
    total, count = 0.0, 0
    for rows in _blocks((heights.shape[0] - 1, heights.shape[1])):
        here = heights[rows.start + 1 : rows.stop + 1]
        slope_y = (here[:, 1:] - heights[rows, 1:]) / dy
        slope_x = np.diff(here, axis=1) / dx
        squares = slope_x * slope_x + slope_y * slope_y
        count += int(np.count_nonzero(~np.isnan(squares)))
        total += float(np.nansum(squares))
    if count == 0:
        raise InputError("heights has no point with both neighbours there: no gradient is defined")
    return float(np.sqrt(total / count))


def _blocks(shape: tuple[int, ...]) -> Iterator[slice]:
    step = max(1, _BLOCK // max(1, shape[1]))
    for start in range(0, shape[0], step):
        yield slice(start, min(start + step, shape[0]))
