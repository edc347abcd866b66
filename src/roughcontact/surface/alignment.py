"""Resampling of a map on the grid of another: offset, rotation, mirror, pixel.

The origin of a map is the center of its outline. The origin is placed on the center of the grid;
the map is mirrored in x, then rotated, then shifted. Angles are in degrees, counter-clockwise as a
map is printed and drawn, row 0 on top and y downwards: 90 rotates x to -y.

A placement is a pair ``(matrix, start)``: ``matrix @ (i, j) + start`` are the fractional indices on
the old grid of point ``[i, j]`` of the new one.

`cutoffs`: Waves shorter than two new pixels alias to longer ones when they are sampled. The
Gaussian filter of ISO 16610 with this nesting index transmits half of the amplitude of the shortest
wave that the new grid resolves, and 6 % at the wavelength of one new pixel. Unlike the mean over
the new pixel, which transmits 64 % and up to 22 %, it has no side lobes, does not depend on the
rotation of the grid, and is defined at holes. The pixel of a rotated grid is represented by its
root-mean-square edge along the axis of the map.

`sample`: Where the pixel of the grid is larger, waves that it cannot resolve are removed first, see
`cutoffs`; a least-squares plane is subtracted before the filter and added after it, because the
filter distorts slopes at the edges. Then the bicubic spline through the points is evaluated, with
not-a-knot ends: it reproduces cubics up to the edge of the map. Holes are filled harmonically
beforehand, so that the spline does not overshoot at their rim.

`common_rectangle`: The intersection of the maps is convex. The first common column is therefore a
convex function of the row, the last one a concave function, and over a range of rows both are
determined by its first and its last row.

`common_pixel`: Along an axis at the angle to its own, a grid with the edges dy, dx has the edge
``((cos/dy)² + (sin/dx)²)^(-1/2)``, half of its shortest wave.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Real

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array, Pixel, Shape
from roughcontact.errors import ArgumentRef, InputError, input_error, require_pixel
from roughcontact.surface import filters, form, grid

Placement = tuple[Array, Array]

MAX_PIXEL_RATIO = math.sqrt(2)
"""Largest ratio of pixels that are of similar size, so that interpolation needs no filter."""

# Relative difference up to which two pixels are equal, as in `contact.solve`; and the tolerance, in
# pixels, for a point on the edge of a map.
_EDGE_TOLERANCE = 1e-9
_SLACK = 1e-6
# Tolerance, in pixels, for coincident points and for points common to all maps. Both may be applied
# to a grid and again to a part of it, whose points must still be on the maps.
_POINT_TOLERANCE = _SLACK / 4


def cosine_sine(angle: float) -> tuple[float, float]:
    """Return cosine and sine of an angle in degrees, exact for multiples of 90."""
    if not isinstance(angle, Real) or isinstance(angle, bool) or not math.isfinite(angle):
        raise input_error("angle", angle, "must be a finite number of degrees")
    quarters = round(float(angle) / 90)
    rest = math.radians(float(angle) - 90 * quarters)
    c, s = math.cos(rest), math.sin(rest)
    turned = ((c, s), (-s, c), (-c, -s), (s, -c))[quarters % 4]
    # No negative zeros.
    return turned[0] + 0.0, turned[1] + 0.0


def grid_positions(
    shape: Shape,
    pixel: Pixel,
    new_shape: Shape,
    new_pixel: Pixel,
    offset: tuple[float, float] = (0.0, 0.0),
    angle: float = 0.0,
    mirrored: bool = False,
) -> Placement:
    """Return the positions of the points of a grid on a map."""
    require_pixel(pixel)
    require_pixel(new_pixel)
    c, s = cosine_sine(angle)
    # The inverse of the motion, from the grid to the map, in (y, x).
    turn = np.array([[c, s], [-s, c]])
    if mirrored:
        turn[1] *= -1
    matrix = turn * np.array(new_pixel) / np.array(pixel)[:, None]
    # Where the points of both grids coincide, rounding must not cause interpolation.
    whole = np.rint(matrix)
    singular = whole[0, 0] * whole[1, 1] == whole[0, 1] * whole[1, 0]
    if np.abs(matrix - whole).max() < _EDGE_TOLERANCE and not singular:
        matrix = whole
    shift = turn @ np.array(_checked_offset(offset)) / np.array(pixel)
    start = (np.array(shape) - 1) / 2 - shift - matrix @ ((np.array(new_shape) - 1) / 2)
    near = np.rint(start)
    start = np.where(np.abs(start - near) < _POINT_TOLERANCE, near, start)
    return matrix, start


def is_coincident(placement: Placement) -> bool:
    """Return whether every point of the grid is a point of the map or beyond its edge."""
    whole = all(bool((part == np.rint(part)).all()) for part in placement)
    return whole and bool((np.abs(placement[0]).sum(axis=1) == 1).all())


def cutoffs(placement: Placement) -> tuple[float, float]:
    """Return the nesting indices [pixels] for sampling a map on a coarser grid, or 0."""
    along_y, along_x = (math.hypot(*row) for row in placement[0])
    limit = MAX_PIXEL_RATIO * (1 + _EDGE_TOLERANCE)
    return 2 * along_y if along_y > limit else 0.0, 2 * along_x if along_x > limit else 0.0


def sample(heights: Array, placement: Placement, shape: Shape) -> Array:
    """Return a map interpolated at the points of another grid."""
    heights = np.asarray(heights, dtype=np.float64)
    if is_coincident(placement):
        return _gather_points(heights, placement, shape)
    if min(heights.shape) < 4:
        raise InputError(
            f"a spline needs at least 4 × 4 points, got {heights.shape[0]} × {heights.shape[1]}"
        )
    # Imported here, as SciPy would take most of the time of `import roughcontact`.
    from scipy import ndimage

    matrix, start = placement
    missing = np.isnan(heights)
    holes = bool(missing.any())
    smoothing = cutoffs(placement)
    values = heights
    if any(smoothing):
        residual = form.level(heights)
        values = filters.along_axes(residual, smoothing) + (heights - residual)
    if holes:
        from roughcontact.surface.cleaning import fill_missing

        values = fill_missing(values, (1.0, 1.0))
    coefficients = _coefficients(_coefficients(values).T).T
    # The first coefficient belongs to the point before the map.
    new: Array = ndimage.affine_transform(
        coefficients, matrix, start + 1, shape, order=3, mode="mirror", prefilter=False
    )
    if holes:
        weight = ndimage.affine_transform(
            missing.astype(np.float32), matrix, start, shape, order=1, mode="nearest"
        )
        new[weight > _SLACK] = np.nan
    first, last = spans(heights.shape, placement, shape)
    columns = np.arange(shape[1])
    new[(columns < first[:, None]) | (columns > last[:, None])] = np.nan
    return new


def spans(
    shape: tuple[int, ...], placement: Placement, new_shape: Shape, slack: float = _SLACK
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the first and the last point of each row of a grid that are on a map."""
    matrix, start = placement
    rows = np.arange(new_shape[0])
    low = np.zeros(new_shape[0])
    high = np.full(new_shape[0], float(new_shape[1] - 1))
    for axis, length in enumerate(shape):
        index = matrix[axis, 0] * rows + start[axis]
        step = matrix[axis, 1]
        # A shift smaller than the slack over the whole row is treated as zero.
        if abs(step) * new_shape[1] < slack:
            off = (index < -slack) | (index > length - 1 + slack)
            high[off] = -1.0
            continue
        ends = (-slack - index) / step, (length - 1 + slack - index) / step
        low = np.maximum(low, np.minimum(*ends))
        high = np.minimum(high, np.maximum(*ends))
    # Clipped, as positions far beyond the map exceed the range of integers.
    first = np.ceil(np.clip(low, 0, new_shape[1])).astype(np.int64)
    last = np.floor(np.clip(high, -1, new_shape[1] - 1)).astype(np.int64)
    return first, last


def common_rectangle(
    maps: Sequence[tuple[tuple[int, int], Placement]], new_shape: Shape
) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return the rows and columns of the largest rectangle of a grid that is on all maps."""
    first, last = np.zeros(new_shape[0], np.int64), np.full(new_shape[0], new_shape[1] - 1)
    for shape, placement in maps:
        one_first, one_last = spans(shape, placement, new_shape, _POINT_TOLERANCE)
        first, last = np.maximum(first, one_first), np.minimum(last, one_last)
    common = np.flatnonzero(last > first)
    best, rows, columns = 0, (0, 0), (0, 0)
    for row in common:
        left = np.maximum(first[row], first[row + 1 : common[-1] + 1])
        right = np.minimum(last[row], last[row + 1 : common[-1] + 1])
        width = right - left + 1
        points = np.where(width > 1, width * np.arange(2, width.size + 2), 0)
        end = int(np.argmax(points)) if points.size else 0
        if points.size and points[end] > best:
            best = int(points[end])
            rows = int(row), int(row) + end + 2
            columns = int(left[end]), int(right[end]) + 1
    if best == 0:
        raise InputError(
            "the maps do not overlap: they have no 2 × 2 points in common; check "
            f"{ArgumentRef('offset')} and {ArgumentRef('angle')}, and that the sizes are in meters"
        )
    return rows, columns


def common_pixel(
    pixel: Pixel, other: tuple[float, float], angle: float = 0.0
) -> tuple[float, float]:
    """Return the pixel, along the axes of the first map, that resolves the waves of both."""
    require_pixel(pixel)
    require_pixel(other)
    c, s = cosine_sine(angle)
    (dy, dx), limit = other, MAX_PIXEL_RATIO * (1 + _EDGE_TOLERANCE)
    seen = 1 / math.hypot(c / dy, s / dx), 1 / math.hypot(s / dy, c / dx)
    along_y, along_x = (
        own if own <= limit * edge else edge for own, edge in zip(pixel, seen, strict=True)
    )
    return along_y, along_x


def align(
    heights: Array,
    pixel: Pixel,
    new_shape: Shape,
    new_pixel: Pixel,
    offset: tuple[float, float] = (0.0, 0.0),
    angle: float = 0.0,
    mirrored: bool = False,
) -> Array:
    """Return a map resampled on another grid after mirroring, rotation and shift."""
    heights = np.asarray(heights, dtype=np.float64)
    ny, nx = heights.shape
    placement = grid_positions((ny, nx), pixel, new_shape, new_pixel, offset, angle, mirrored)
    grid.require_memory(new_shape, grid.RESAMPLED_ARRAYS)
    new = sample(heights, placement, new_shape)
    if np.isnan(new).all():
        old_size = ny * pixel[0], nx * pixel[1]
        new_size = new_shape[0] * new_pixel[0], new_shape[1] * new_pixel[1]
        raise InputError(
            f"the maps do not overlap: a map of {old_size[0]:.6g} × {old_size[1]:.6g} m, shifted "
            f"by {tuple(offset)} m, has no measured point on a grid of {new_size[0]:.6g} × "
            f"{new_size[1]:.6g} m; check {ArgumentRef('offset')} and {ArgumentRef('angle')}"
        )
    return new


def _checked_offset(offset: tuple[float, float]) -> tuple[float, float]:
    try:
        y, x = (float(shift) for shift in offset)
    except (TypeError, ValueError):
        raise input_error("offset", offset, "must be a pair (y, x) in meters") from None
    if not (math.isfinite(y) and math.isfinite(x)):
        raise input_error("offset", offset, "must be finite (y, x) [m]")
    return y, x


def _gather_points(heights: Array, placement: Placement, shape: Shape) -> Array:
    # Each axis of the map is parallel or antiparallel to an axis of the grid.
    matrix, start = placement
    along = np.abs(matrix).argmax(axis=1)
    index = []
    for axis in (0, 1):
        step = int(matrix[axis, along[axis]])
        index.append(int(start[axis]) + step * np.arange(shape[along[axis]]))
    there = [(i >= 0) & (i < length) for i, length in zip(index, heights.shape, strict=True)]
    part = heights[np.ix_(index[0][there[0]], index[1][there[1]])]
    new = np.full(shape, np.nan)
    if along[0] == 0:
        new[np.ix_(*there)] = part
    else:
        new[np.ix_(*there[::-1])] = part.T
    return new


def _coefficients(values: Array) -> Array:
    """Return the coefficients of the not-a-knot B-spline at points -1, 0, … n along y."""
    from scipy.linalg import solveh_banded

    n = values.shape[0]
    c = np.empty((n + 2, values.shape[1]))
    c[2] = (8 * values[1] - values[0] - values[2]) / 6
    c[-3] = (8 * values[-2] - values[-1] - values[-3]) / 6
    if n > 4:
        right = 6 * values[2:-2]
        right[0] -= c[2]
        right[-1] -= c[-3]
        # LAPACK's routine for tridiagonal systems does not accept a single equation.
        if n == 5:
            c[3] = right[0] / 4
        else:
            bands = np.ones((2, n - 4))
            bands[1] = 4
            c[3:-3] = solveh_banded(bands, right, overwrite_b=True, check_finite=False)
    c[1] = 6 * values[1] - 4 * c[2] - c[3]
    c[0] = 6 * values[0] - 4 * c[1] - c[2]
    c[-2] = 6 * values[-2] - 4 * c[-3] - c[-4]
    c[-1] = 6 * values[-1] - 4 * c[-2] - c[-3]
    return c
