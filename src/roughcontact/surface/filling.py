"""Holes of a measured map, filled by a harmonic surface."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import csgraph
from scipy.sparse.linalg import SuperLU, splu

from roughcontact.errors import InputError, Mention
from roughcontact.units import percent

Array = NDArray[np.float64]

# Above this number of missing points the factors of the direct solver outgrow the map.
_DIRECT_LIMIT = 50_000

# Points on the coarsest level of the iterative solver, and its relative residual.
_COARSEST = 20_000
_TOLERANCE = 1e-10
_MOST_STEPS = 500


def fill(heights: Array, pixel: tuple[float, float], most: float = 1.0) -> Array:
    """Return the heights with missing points replaced by a harmonic surface.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights, NaN where missing.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    most : float
        Largest share of missing points that is filled.

    Returns
    -------
    ndarray, shape (ny, nx)
        A new array without NaN. Points that were there keep their bits; each hole stays between
        the lowest and the highest point of its rim.

    Raises
    ------
    InputError
        If every point is missing, or more than ``most`` of them.

    Notes
    -----
    Solves the five-point Laplace equation, weights 1/dy² and 1/dx², on the missing points alone,
    with the measured rim as boundary values and zero slope across the edge of the map. Up to
    50 000 missing points are solved directly, more by conjugate gradients with a multigrid
    preconditioner to a residual of 1e-10 of the right-hand side.
    """
    heights = np.asarray(heights, dtype=np.float64)
    missing = np.isnan(heights)
    if missing.all():
        raise InputError(
            "has no finite value: there is nothing to fill the holes from", argument="heights"
        )
    share = float(missing.mean())
    if not share <= most:
        raise InputError(
            f"has no height at {percent(share)} of its points, and at most {percent(most)} are "
            "filled: crop it, let the missing points never touch (masked), or fill them all with ",
            Mention("most", 1.0),
            argument="surface",
            value=share,
        )
    filled = heights.copy()
    if not missing.any():
        return filled
    matrix, right, low, high = _laplace(heights, missing, pixel)
    # Heights far from zero would cost digits; the equation does not mind a constant.
    offset = 0.5 * (float(low.min()) + float(high.max()))
    right -= offset * np.asarray(matrix.sum(axis=1)).ravel()
    if matrix.shape[0] <= _DIRECT_LIMIT:
        solution = np.asarray(_factorised(matrix).solve(right))
    else:
        solution = _solve_iteratively(matrix, right, missing)
    filled[missing] = np.clip(solution + offset, low, high)
    return filled


def _laplace(
    heights: Array, missing: NDArray[np.bool_], pixel: tuple[float, float]
) -> tuple[sparse.csr_array, Array, Array, Array]:
    """Return matrix, right-hand side, and the rim's bounds for each missing point."""
    count = int(np.count_nonzero(missing))
    number = np.full(missing.shape, -1, dtype=np.int64)
    number[missing] = np.arange(count)
    right, diagonal = np.zeros(count), np.zeros(count)
    low, high = np.full(count, np.inf), np.full(count, -np.inf)
    first, second, weights = [], [], []
    # Only the ratio of the weights matters; near one they keep the matrix near one.
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
    """Return the solution by conjugate gradients.

    Not SciPy's: they take their inner products by BLAS, whose last digits depend on how many
    threads it has.
    """
    precondition = _multigrid(matrix, *np.nonzero(missing))
    solution, residual = np.zeros(right.size), right.copy()
    direction, previous = np.zeros(right.size), 1.0
    enough = _TOLERANCE**2 * _dot(right, right)
    for _ in range(_MOST_STEPS):
        if _dot(residual, residual) <= enough:
            return solution
        preconditioned = precondition(residual)
        product = _dot(residual, preconditioned)
        direction = preconditioned + (product / previous) * direction
        previous = product
        image = matrix @ direction
        length = product / _dot(direction, image)
        solution += length * direction
        residual -= length * image
    raise InputError(
        f"the {right.size} missing points could not be filled; crop the map or mask them"
    )


def _dot(first: Array, second: Array) -> float:
    return float(np.einsum("i,i->", first, second))


def _multigrid(
    matrix: sparse.csr_array, row: NDArray[np.int64], column: NDArray[np.int64]
) -> Callable[[Array], Array]:
    """Return one V-cycle of smoothed aggregation over squares of 3 × 3 points.

    After Vaněk, Mandel and Brezina (1996), doi:10.1007/BF02238511, with the squares of the map in
    place of aggregates sought in the graph.
    """
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
    coarsest = _factorised(matrix)

    def cycle(residual: Array, depth: int = 0) -> Array:
        if depth == len(levels):
            return np.asarray(coarsest.solve(residual))
        operator, damping, interpolation = levels[depth]
        # One step before and one after the correction keep the cycle symmetric, as
        # conjugate gradients need it.
        solution = damping @ residual
        rest = interpolation.T @ (residual - operator @ solution)
        solution += interpolation @ cycle(rest, depth + 1)
        solution += damping @ (residual - operator @ solution)
        return np.asarray(solution)

    return cycle


def _factorised(matrix: sparse.csr_array) -> SuperLU:
    return splu(matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
