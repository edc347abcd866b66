"""Roughness parameters of a map after ISO 25178-2: heights and gradients.

`height_parameters`: With z the height above the mean and ⟨ ⟩ the average over the valid points:
Sq = √⟨z²⟩, ``Sa = ⟨|z|⟩``, Ssk = ⟨z³⟩/Sq³, Sku = ⟨z⁴⟩/Sq⁴ (3 for a Gaussian surface), Sp = max
z, Sv = -min z, Sz = Sp + Sv.

ISO 25178-2:2021, section 4.2

`rms_height`: ISO 25178-2:2021, root mean square height; only the mean is subtracted here.

`rms_gradient`: The standard defines Sdq² as the mean of ``(∂z/∂x)² + (∂z/∂y)²`` and does not
specify the differences. Here they are the first differences to the preceding neighbors,
``(z[j, i] - z[j, i-1])/dx`` and ``(z[j, i] - z[j-1, i])/dy``, over the (ny - 1)(nx - 1) points
that have both: they include the shortest measured distance in full, which central differences
would skip.

ISO 25178-2:2021, root mean square gradient; the differences after Stout et al., The development
of methods for the characterisation of roughness in three dimensions (1993), EUR 15178 EN.

`developed_area_ratio`: The standard defines Sdr as the mean of ``√(1 + (∂z/∂x)² + (∂z/∂y)²) - 1``.
Here every cell between four points is divided into two triangles along either diagonal, and both
divisions are averaged, so that mirroring the map changes nothing. A triangle with the slopes s_x
and s_y along its two edges on the grid has ``√(1 + s_x² + s_y²)`` times its projected area, hence a
cell has the mean of this factor over its two s_x and its two s_y.

ISO 25178-2:2021, section 4.4; the triangles after Stout et al., The development of methods for
the characterisation of roughness in three dimensions (1993), EUR 15178 EN.

`mean_slope`: Mean of the absolute slopes along x and along y, over the same differences as Sdq, and
their root-mean-square: the slope m along a profile of an isotropic surface. Of a Gaussian one it is
Sdq/√π.

Cooper, Mikic and Yovanovich 1969, Int. J. Heat Mass Transfer 12, 279,
doi:10.1016/0017-9310(69)90011-8
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array
from roughcontact.errors import InputError
from roughcontact.surface import grid


def height_parameters(heights: Array) -> dict[str, float]:
    """Return the height parameters Sq, Sa, Ssk, Sku, Sp, Sv and Sz."""
    Sq = rms_height(heights)
    mean, count = mean_and_count(heights)
    top, bottom = float(np.nanmax(heights)), float(np.nanmin(heights))
    flat = top == bottom
    absolute, third, fourth = 0.0, 0.0, 0.0
    for rows in grid.row_blocks(heights.shape):
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
    """Return the root-mean-square height about the mean, Sq."""
    mean, count = _rounded_mean(heights)
    squares, rest = 0.0, 0.0
    for rows in grid.row_blocks(heights.shape):
        deviation = heights[rows] - mean
        rest += float(np.nansum(deviation))
        squares += float(np.nansum(np.square(deviation, out=deviation)))
    # The second term corrects for the rounding of the mean of a map with a large offset.
    return float(np.sqrt(max(squares / count - (rest / count) ** 2, 0.0)))


def rms_gradient(heights: NDArray[np.float64], pixel: tuple[float, float]) -> float:
    """Return the root-mean-square gradient, Sdq."""
    total, count = 0.0, 0
    for squares in squared_gradients(heights, pixel):
        count += int(np.count_nonzero(~np.isnan(squares)))
        total += float(np.nansum(squares))
    if count == 0:
        raise InputError(
            "has no point with two valid neighbors: the gradient is undefined", argument="heights"
        )
    return float(np.sqrt(total / count))


def mean_slope(heights: Array, pixel: tuple[float, float]) -> float:
    """Return the mean absolute slope along a profile, m."""
    slopes = (np.diff(heights, axis=axis) / pixel[axis] for axis in (0, 1))
    means = [float(np.nanmean(np.abs(s))) for s in slopes if s.size and not np.isnan(s).all()]
    return math.sqrt(float(np.mean(np.square(means)))) if means else math.nan


def median_gradient(heights: Array, pixel: tuple[float, float]) -> float:
    """Return the median of the gradients, which holes, steps and spikes hardly change."""
    squares = np.concatenate([part.ravel() for part in squared_gradients(heights, pixel)])
    known = squares[~np.isnan(squares)]
    return math.sqrt(float(np.median(known))) if known.size else math.nan


def squared_gradients(heights: Array, pixel: tuple[float, float]) -> Iterator[Array]:
    """Yield blocks of rows of the squared gradient, without the first row and column."""
    dy, dx = pixel
    if heights.shape[0] == 1:
        # A profile is uniform across its direction.
        heights = np.repeat(heights, 2, axis=0)
    for rows in grid.row_blocks((heights.shape[0] - 1, heights.shape[1])):
        here = heights[rows.start + 1 : rows.stop + 1]
        slope_y = (here[:, 1:] - heights[rows, 1:]) / dy
        slope_x = np.diff(here, axis=1) / dx
        yield slope_x * slope_x + slope_y * slope_y


def developed_area_ratio(heights: Array, pixel: tuple[float, float]) -> float:
    """Return the developed interfacial area ratio, Sdr, by triangulation."""
    dy, dx = pixel
    total, count = 0.0, 0
    for rows in grid.row_blocks((heights.shape[0] - 1, heights.shape[1])):
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
            "has no cell with four valid corners: the area is undefined", argument="heights"
        )
    return total / count


def _rounded_mean(heights: Array) -> tuple[float, int]:
    """Return the mean height, with rounding errors, and the number of valid points."""
    total, count = 0.0, 0
    for rows in grid.row_blocks(heights.shape):
        count += int(np.count_nonzero(~np.isnan(heights[rows])))
        total += float(np.nansum(heights[rows]))
    if count == 0:
        raise InputError("has no finite value: every point is missing", argument="heights")
    return total / count, count


def mean_and_count(heights: Array) -> tuple[float, int]:
    """Return the mean height and the number of valid points."""
    mean, count = _rounded_mean(heights)
    # A second pass, for the rounding of the mean of a map with a large offset.
    rest = sum(float(np.nansum(heights[rows] - mean)) for rows in grid.row_blocks(heights.shape))
    return mean + rest / count, count
