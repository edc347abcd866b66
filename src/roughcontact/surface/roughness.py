"""Heights, slopes and developed area of a map, after ISO 25178-2."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from roughcontact.errors import InputError
from roughcontact.surface import blocks

Array = NDArray[np.float64]


def height_parameters(heights: Array) -> dict[str, float]:
    """Return the height parameters Sq, Sa, Ssk, Sku, Sp, Sv and Sz.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights, NaN where missing.

    Returns
    -------
    dict
        ``Sq, Sa, Sp, Sv, Sz`` in the unit of the heights; ``Ssk, Sku`` without unit, NaN if
        all heights are equal.

    Raises
    ------
    InputError
        If every point is missing.

    Notes
    -----
    With z the height above the mean and ⟨ ⟩ the average over the valid points:
    Sq = √⟨z²⟩, ``Sa = ⟨|z|⟩``, Ssk = ⟨z³⟩/Sq³, Sku = ⟨z⁴⟩/Sq⁴ (3 for a Gaussian surface),
    Sp = max z, Sv = -min z, Sz = Sp + Sv.

    References
    ----------
    ISO 25178-2:2021, section 4.2

    Examples
    --------
    >>> height_parameters(np.array([[0.0, 0.0], [0.0, 4.0]]))["Sz"]
    4.0
    """
    Sq = rms_height(heights)
    mean, count = mean_and_count(heights)
    top, bottom = float(np.nanmax(heights)), float(np.nanmin(heights))
    flat = top == bottom
    absolute, third, fourth = 0.0, 0.0, 0.0
    for rows in blocks.of_rows(heights.shape):
        z = heights[rows] - mean
        absolute += float(np.nansum(np.abs(z)))
        if not flat:
            z /= Sq
            square = z * z
            third += float(np.nansum(square * z))
            fourth += float(np.nansum(np.square(square, out=square)))
    return {
        "Sq": Sq,
        "Sa": absolute / count,
        "Ssk": math.nan if flat else third / count,
        "Sku": math.nan if flat else fourth / count,
        "Sp": top - mean,
        "Sv": mean - bottom,
        "Sz": top - bottom,
    }


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
    for rows in blocks.of_rows(heights.shape):
        count += int(np.count_nonzero(~np.isnan(heights[rows])))
        total += float(np.nansum(heights[rows]))
    if count == 0:
        raise InputError("has no finite value: every point is missing", argument="heights")
    mean = total / count
    squares, rest = 0.0, 0.0
    for rows in blocks.of_rows(heights.shape):
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
    if heights.shape[0] == 1:
        # Beyond a profile the body goes on alike.
        heights = np.repeat(heights, 2, axis=0)
    total, count = 0.0, 0
    for rows in blocks.of_rows((heights.shape[0] - 1, heights.shape[1])):
        here = heights[rows.start + 1 : rows.stop + 1]
        slope_y = (here[:, 1:] - heights[rows, 1:]) / dy
        slope_x = np.diff(here, axis=1) / dx
        squares = slope_x * slope_x + slope_y * slope_y
        count += int(np.count_nonzero(~np.isnan(squares)))
        total += float(np.nansum(squares))
    if count == 0:
        raise InputError(
            "has no point with both neighbours there: no gradient is defined", argument="heights"
        )
    return float(np.sqrt(total / count))


def developed_area_ratio(heights: Array, pixel: tuple[float, float]) -> float:
    """Return the developed interfacial area ratio, Sdr, by triangulation.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights [m], NaN where missing.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].

    Returns
    -------
    float
        Sdr, area of the surface over its projection, minus 1; a fraction, not per cent.

    Raises
    ------
    InputError
        If no cell has all four corners.

    Notes
    -----
    The standard defines Sdr as the mean of ``√(1 + (∂z/∂x)² + (∂z/∂y)²) - 1``. Here every cell
    between four points is cut into two triangles along either diagonal, and both cuts are
    averaged, so that mirroring the map changes nothing. A triangle with the slopes s_x and s_y
    along its two edges on the grid has ``√(1 + s_x² + s_y²)`` times its projected area, hence a
    cell the mean of that over its two s_x and its two s_y.

    References
    ----------
    ISO 25178-2:2021, section 4.4; the triangles after Stout et al., The development of methods
    for the characterisation of roughness in three dimensions (1993), EUR 15178 EN.

    Examples
    --------
    >>> x = np.arange(4.0)
    >>> round(developed_area_ratio(x + 0 * x[:, None], (1.0, 1.0)) + 1, 6)
    1.414214
    """
    dy, dx = pixel
    total, count = 0.0, 0
    for rows in blocks.of_rows((heights.shape[0] - 1, heights.shape[1])):
        part = heights[rows.start : rows.stop + 1]
        squares_x = np.square(np.diff(part, axis=1) / dx)
        squares_y = np.square(np.diff(part, axis=0) / dy)
        excess = np.zeros((part.shape[0] - 1, part.shape[1] - 1))
        for along_x in (squares_x[:-1], squares_x[1:]):
            for along_y in (squares_y[:, :-1], squares_y[:, 1:]):
                square = along_x + along_y
                # √(1 + s²) - 1 without cancellation at small slopes.
                excess += square / (1 + np.sqrt(1 + square))
        count += int(np.count_nonzero(~np.isnan(excess)))
        total += float(np.nansum(excess)) / 4
    if count == 0:
        raise InputError(
            "has no cell with all four corners there: no area is defined", argument="heights"
        )
    return total / count


def mean_and_count(heights: Array) -> tuple[float, int]:
    """Return the mean height, and the number of valid points.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights, NaN where missing.

    Returns
    -------
    mean : float
        In the unit of the heights.
    count : int
        Valid points.

    Raises
    ------
    InputError
        If every point is missing.
    """
    total, count = 0.0, 0
    for rows in blocks.of_rows(heights.shape):
        count += int(np.count_nonzero(~np.isnan(heights[rows])))
        total += float(np.nansum(heights[rows]))
    if count == 0:
        raise InputError("has no finite value: every point is missing", argument="heights")
    mean = total / count
    # Once more, for what rounding took from the mean of a map far from zero height.
    rest = sum(float(np.nansum(heights[rows] - mean)) for rows in blocks.of_rows(heights.shape))
    return mean + rest / count, count
