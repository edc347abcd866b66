"""Cleaning of a measured map: outliers, holes, cropping, rotation.

`remove_outliers`: The median is that of the valid points of the window; beyond the edge the map is
continued by point reflection, so that a tilt alone makes no outliers. The robust standard deviation
is 1.4826 × the median of all absolute deviations; where that is zero, as when most points equal
their local median, 1.2533 × their mean. A spike wider than about half a window is treated as part
of the surface. Where the form deviates more within a window than the roughness, its summit would be
an outlier: remove the form first.

`largest_rectangle`: One pass over the rows. Each point of a row gives the height of the strip above
it that is free of holes, and the width over which that strip can be moved. The largest rectangle is
one of them.

`fill_missing`: The five-point Laplace equation, with weights 1/dy² and 1/dx², is solved on the
missing points, with the measured rim as boundary values and zero slope across the edge of the map.
Up to 50 000 missing points are solved directly, more by conjugate gradients with a multigrid
preconditioner to a residual of 1e-10 of the right-hand side.
"""

from __future__ import annotations

from collections.abc import Callable
from numbers import Real
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array, Pixel
from roughcontact.errors import ArgumentRef, InputError, input_error, require_positive
from roughcontact.solvers.operator import dot
from roughcontact.surface import grid
from roughcontact.units import format_percent

if TYPE_CHECKING:
    from scipy import sparse
    from scipy.sparse.linalg import SuperLU


MAX_FILLED_SHARE = 0.3
"""Share of missing points above which a map is filled only on request."""


def fill_mode(share: float) -> str:
    """Return the choice for missing points that fills this share of a map."""
    return "fill" if share <= MAX_FILLED_SHARE else "fill-all"


def remove_outliers(heights: Array, limit: float = 6.0, window: int = 5) -> Array:
    """Return the heights with spikes replaced by NaN."""
    require_positive(limit=limit)
    if not isinstance(window, (int, np.integer)) or not (3 <= window <= 31 and window % 2):
        raise input_error("window", window, "must be an odd number of points from 3 to 31")
    heights = np.asarray(heights, dtype=np.float64)
    deviation = np.abs(heights - _local_median(heights, int(window)))
    there = deviation[np.isfinite(deviation)]
    sigma = 1.4826 * float(np.median(there))
    if sigma == 0:
        sigma = 1.2533 * float(np.mean(there))
    cleaned = heights.copy()
    # A comparison with NaN is false: holes remain.
    cleaned[deviation > limit * sigma] = np.nan
    return cleaned


def largest_rectangle(heights: Array) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return the rows and columns of the largest rectangle without holes."""
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


def rotate_map(heights: Array, angle: int = 90) -> Array:
    """Return the map rotated by multiples of 90°."""
    if isinstance(angle, bool) or not isinstance(angle, Real) or angle % 90 != 0:
        raise input_error("angle", angle, "must be a multiple of 90 degrees")
    return np.rot90(heights, int(angle) // 90 % 4).copy()


def crop_map(
    heights: NDArray[Any], rows: tuple[int, int], columns: tuple[int, int]
) -> NDArray[Any]:
    """Return the part of a map between two rows and two columns."""
    for name, (start, stop), length in (
        ("rows", rows, heights.shape[0]),
        ("columns", columns, heights.shape[1]),
    ):
        minimum = min(2, length)
        if not (0 <= start and start + minimum <= stop <= length):
            raise InputError(
                f"must be within 0 to {length} and keep at least {minimum}, got {start}:{stop}",
                argument=name,
                value=(start, stop),
            )
    return heights[slice(*rows), slice(*columns)].copy()


def _local_median(heights: Array, window: int) -> Array:
    reach = window // 2
    # The odd reflection of a map of n points defines at most n - 1 beyond its edge; NumPy repeats
    # it where the window is larger than the map.
    padded = np.pad(heights, reach, mode="reflect", reflect_type="odd")
    nx = heights.shape[1]
    median = np.empty_like(heights)
    for rows in grid.row_blocks(heights.shape, window**2 // 4):
        start, stop = rows.start, rows.stop
        part = np.lib.stride_tricks.sliding_window_view(
            padded[start : stop + 2 * reach], (window, window)
        )
        # NaN is sorted to the end, so the median of n valid points is among the first n.
        ordered = np.sort(part.reshape(stop - start, nx, -1), axis=-1)
        count = np.count_nonzero(np.isfinite(ordered), axis=-1)
        middle = [np.maximum(index, 0)[..., None] for index in ((count - 1) // 2, count // 2)]
        low, high = (
            np.take_along_axis(ordered, np.minimum(index, window**2 - 1), axis=-1)[..., 0]
            for index in middle
        )
        median[start:stop] = 0.5 * (low + high)
    return median


# Above this number of missing points the factors of the direct solver need more memory than the
# map.
_DIRECT_LIMIT = 50_000

# Maximum number of points on the coarsest level of the iterative solver, relative residual, and
# maximum number of steps.
_COARSEST = 20_000
_TOLERANCE = 1e-10
_MAX_STEPS = 500


def fill_missing(heights: Array, pixel: Pixel, maximum: float = 1.0) -> Array:
    """Return the heights with missing points replaced by a harmonic surface."""
    heights = np.asarray(heights, dtype=np.float64)
    missing = np.isnan(heights)
    if missing.all():
        raise InputError(
            "has no finite value: there is nothing to fill the holes from", argument="heights"
        )
    share = float(missing.mean())
    if not share <= maximum:
        raise InputError(
            f"has no height at {format_percent(share)} of its points, and at most "
            f"{format_percent(maximum)} are filled: crop it, exclude the missing points from "
            f"contact (masked), or fill them all with {ArgumentRef('most', 1.0)}",
            argument="surface",
            value=share,
        )
    filled = heights.copy()
    if not missing.any():
        return filled
    matrix, right, low, high = _laplace(heights, missing, pixel)
    # A large offset would cost digits; the equation is invariant to a constant.
    offset = 0.5 * (float(low.min()) + float(high.max()))
    right -= offset * np.asarray(matrix.sum(axis=1)).ravel()
    if matrix.shape[0] <= _DIRECT_LIMIT:
        solution = np.asarray(_factorize(matrix).solve(right))
    else:
        solution = _solve_iteratively(matrix, right, missing)
    filled[missing] = np.clip(solution + offset, low, high)
    return filled


def _laplace(
    heights: Array, missing: NDArray[np.bool_], pixel: Pixel
) -> tuple[sparse.csr_array, Array, Array, Array]:
    """Return matrix and right-hand side, and the rim's bounds for each missing point."""
    from scipy import sparse
    from scipy.sparse import csgraph

    count = int(np.count_nonzero(missing))
    number = np.full(missing.shape, -1, dtype=np.int64)
    number[missing] = np.arange(count)
    right, diagonal = np.zeros(count), np.zeros(count)
    low, high = np.full(count, np.inf), np.full(count, -np.inf)
    first, second, weights = [], [], []
    # Only the ratio of the weights matters; weights near one keep the matrix near one.
    larger = max(pixel)
    for axis, edge in enumerate(pixel):
        weight = (larger / edge) ** 2
        before = (slice(None, -1), slice(None)) if axis == 0 else (slice(None), slice(None, -1))
        after = (slice(1, None), slice(None)) if axis == 0 else (slice(None), slice(1, None))
        for here, there in ((before, after), (after, before)):
            hole = missing[here]
            own, other = number[here][hole], number[there][hole]
            # Each point occurs once per direction, so plain indexing adds correctly.
            diagonal[own] += weight
            inside = other >= 0
            first.append(own[inside])
            second.append(other[inside])
            weights.append(np.full(first[-1].size, -weight))
            rim, values = own[~inside], heights[there][hole][~inside]
            right[rim] += weight * values
            low[rim] = np.minimum(low[rim], values)
            high[rim] = np.maximum(high[rim], values)
    points = np.arange(count)
    matrix = sparse.csr_array(
        (
            np.concatenate([diagonal, *weights]),
            (np.concatenate([points, *first]), np.concatenate([points, *second])),
        ),
        shape=(count, count),
    )
    holes, label = csgraph.connected_components(matrix, directed=False)
    lowest, highest = np.full(holes, np.inf), np.full(holes, -np.inf)
    np.minimum.at(lowest, label, low)
    np.maximum.at(highest, label, high)
    return matrix, right, lowest[label], highest[label]


def _solve_iteratively(matrix: sparse.csr_array, right: Array, missing: NDArray[np.bool_]) -> Array:
    """Return the solution of conjugate gradients with the multigrid preconditioner."""
    precondition = _multigrid(matrix, *np.nonzero(missing))
    solution, residual = np.zeros(right.size), right.copy()
    direction, previous = np.zeros(right.size), 1.0
    enough = _TOLERANCE**2 * dot(right, right)
    for _ in range(_MAX_STEPS):
        if dot(residual, residual) <= enough:
            return solution
        preconditioned = precondition(residual)
        product = dot(residual, preconditioned)
        direction = preconditioned + (product / previous) * direction
        previous = product
        image = matrix @ direction
        length = product / dot(direction, image)
        solution += length * direction
        residual -= length * image
    raise InputError(
        f"the {right.size} missing points could not be filled; crop the map or mask them"
    )


def _multigrid(
    matrix: sparse.csr_array, row: NDArray[np.int64], column: NDArray[np.int64]
) -> Callable[[Array], Array]:
    """Return a V-cycle of smoothed aggregation over squares of 3 × 3 points, as a function."""
    from scipy import sparse

    levels = []
    while matrix.shape[0] > _COARSEST:
        # Jacobi steps with 2/3 damp the short waves; the largest eigenvalue of D⁻¹A is below 2.
        damping = sparse.diags_array(2 / 3 / matrix.diagonal())
        row, column = row // 3, column // 3
        width = int(column.max()) + 1
        squares, aggregate = np.unique(row * width + column, return_inverse=True)
        size = aggregate.size
        members = sparse.csr_array(
            (np.ones(size), (np.arange(size), aggregate)), shape=(size, squares.size)
        )
        interpolation = sparse.csr_array(members - damping @ (matrix @ members))
        levels.append((matrix, damping, interpolation))
        matrix = sparse.csr_array(interpolation.T @ matrix @ interpolation)
        row, column = squares // width, squares % width
    coarsest = _factorize(matrix)

    def cycle(residual: Array, depth: int = 0) -> Array:
        if depth == len(levels):
            return np.asarray(coarsest.solve(residual))
        operator, damping, interpolation = levels[depth]
        # One step before and one after the correction keep the cycle symmetric, which conjugate
        # gradients require.
        solution = damping @ residual
        rest = interpolation.T @ (residual - operator @ solution)
        solution += interpolation @ cycle(rest, depth + 1)
        solution += damping @ (residual - operator @ solution)
        return np.asarray(solution)

    return cycle


def _factorize(matrix: sparse.csr_array) -> SuperLU:
    from scipy.sparse.linalg import splu

    return splu(matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
