"""Least-squares polynomials in x and y over the valid points of a map."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from roughcontact.errors import InputError
from roughcontact.surface import blocks

Array = NDArray[np.float64]

Terms = tuple[tuple[int, int], ...]

# Scaled normal equations below this smallest eigenvalue are taken as singular. A full map has
# one of order 0.1; points on one line give rounding only.
SINGULAR = 1e-10


def too_few(heights: Array, form: str) -> InputError:
    """Return the refusal of a map whose points do not determine a form."""
    count = int(np.count_nonzero(np.isfinite(heights)))
    return InputError(
        f"has {count} valid points, too few or in too few lines to fit a {form}; "
        "fit a simpler form",
        argument="heights",
    )


def without_terms(heights: Array, terms: Terms, form: str, weights: Array | None = None) -> Array:
    """Return the heights without the least-squares sum of products of Legendre polynomials.

    Of a single row nothing varies along y: terms that do are left out.
    """
    if heights.shape[0] == 1:
        terms = tuple((along_y, along_x) for along_y, along_x in terms if not along_y)
    degree = max(max(powers) for powers in terms)
    rows, columns = _box(heights, terms, form)
    basis_y = _legendre(heights.shape[0], rows, degree)
    basis_x = np.ascontiguousarray(_legendre(heights.shape[1], columns, degree).T)
    gram = _gram(heights, basis_y, basis_x, terms, weights)
    diagonal = np.diag(gram)
    # All points on one row or column leave nothing of a slope across it.
    if diagonal.min() <= 0:
        raise too_few(heights, form)
    scale = 1 / np.sqrt(diagonal)
    gram *= scale[:, None] * scale
    if np.linalg.eigvalsh(gram)[0] < SINGULAR:
        raise too_few(heights, form)
    solve = _inverse(gram) * scale[:, None] * scale
    residual = heights.copy()
    table = np.zeros((degree + 1, degree + 1))
    index = tuple(np.array(terms).T)
    for _ in range(2):
        moments = _moments(residual, basis_y, basis_x, terms, weights)
        table[index] = np.einsum("ij,j->i", solve, moments)
        for block in blocks.of_rows(heights.shape):
            along_x = np.einsum("yb,bi->yi", basis_y[block], table)
            residual[block] -= np.einsum("yi,ix->yx", along_x, basis_x)
    return residual


def _box(heights: Array, terms: Terms, form: str) -> tuple[tuple[int, int], tuple[int, int]]:
    there = np.isfinite(heights)
    if np.count_nonzero(there) < len(terms):
        raise too_few(heights, form)
    rows, columns = (np.flatnonzero(there.any(axis=axis)) for axis in (1, 0))
    return (int(rows[0]), int(rows[-1])), (int(columns[0]), int(columns[-1]))


def _legendre(length: int, box: tuple[int, int], degree: int) -> Array:
    # Coordinates from -1 to 1 over the box; outside it the values do not enter the fit.
    first, last = box
    t = (2.0 * np.arange(length) - first - last) / max(last - first, 1)
    # High powers far outside it would overflow.
    basis: Array = np.asarray(
        np.polynomial.legendre.legvander(np.clip(t, -1, 1), degree), dtype=np.float64
    )
    return basis


def _weighted(heights: Array, block: slice, weights: Array | None) -> Array:
    there = np.isfinite(heights[block])
    return there.astype(np.float64) if weights is None else np.where(there, weights[block], 0.0)


def _gram(
    heights: Array, basis_y: Array, basis_x: Array, terms: Terms, weights: Array | None
) -> Array:
    # sums[b, c, i, j] = Σ_y Y_b Y_c Σ_x X_i X_j w over the valid points.
    count = len(basis_x)
    pairs_y = (basis_y[:, :, None] * basis_y[:, None, :]).reshape(-1, count**2)
    pairs_x = (basis_x[:, None] * basis_x).reshape(count**2, -1)
    sums = np.zeros((count**2, count**2))
    for block in blocks.of_rows(heights.shape):
        sums += _projected(_weighted(heights, block, weights), pairs_y[block], pairs_x)
    b, i = np.array(terms).T
    gram: Array = sums.reshape((count,) * 4)[b[:, None], b, i[:, None], i]
    return gram


def _moments(
    heights: Array, basis_y: Array, basis_x: Array, terms: Terms, weights: Array | None
) -> Array:
    sums = np.zeros((basis_y.shape[1], len(basis_x)))
    for block in blocks.of_rows(heights.shape):
        there = np.where(np.isfinite(heights[block]), heights[block], 0.0)
        if weights is not None:
            there *= _weighted(heights, block, weights)
        sums += _projected(there, basis_y[block], basis_x)
    moments: Array = sums[tuple(np.array(terms).T)]
    return moments


def _inverse(matrix: Array) -> Array:
    """Return the inverse of a symmetric, positive definite matrix; see `_projected`."""
    swept = matrix.copy()
    for i in range(len(matrix)):
        column, pivot = swept[:, i].copy(), swept[i, i]
        row = column / pivot
        swept -= column[:, None] * row
        swept[i] = swept[:, i] = row
        swept[i, i] = -1 / pivot
    return -swept


def _projected(values: Array, along_y: Array, along_x: Array) -> Array:
    """Return the sums over a map of its products with functions of y (columns) and of x (rows).

    Not by BLAS: the last digits would depend on how many threads it has.
    """
    rows = np.einsum("by,yx->bx", np.ascontiguousarray(along_y.T), values)
    sums: Array = np.einsum("bx,ix->bi", rows, along_x)
    return sums
