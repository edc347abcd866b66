"""Preparation of a measured map: level, crop."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from roughcontact.errors import InputError

Array = NDArray[np.float64]

# Powers (of y, of x) of each form.
_FORMS: dict[str, tuple[tuple[int, int], ...]] = {
    "mean": ((0, 0),),
    "plane": ((0, 0), (0, 1), (1, 0)),
    "quadric": ((0, 0), (0, 1), (1, 0), (0, 2), (1, 1), (2, 0)),
}

# Values per block of rows: temporaries of 8 MiB, whatever the size of the map.
_BLOCK = 2**20


def level(heights: Array, form: str = "plane") -> Array:
    """Return the heights without their least-squares form.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights, NaN where missing.
    form : {"plane", "quadric", "mean"}
        What is fitted to the points that are there: a constant, a plane, or a polynomial of
        second degree in x and y. The pixel does not matter to any of them.

    Returns
    -------
    ndarray, shape (ny, nx)
        The residual, a new array; NaN stays NaN and the mean of the rest is zero to rounding.

    Raises
    ------
    InputError
        If the form is unknown, or if the points that are there do not determine it.

    Notes
    -----
    The normal equations are set up in Legendre polynomials over the box that holds the points.
    Their sums separate into a product over each row and one over the rows, so no array larger
    than a few rows is made. A second fit, to the residual, takes out what the first one lost by
    rounding.

    Examples
    --------
    >>> y, x = np.mgrid[:3, :4]
    >>> bool(np.allclose(level(1.0 + 2 * x - y, "plane"), 0))
    True
    """
    if form not in _FORMS:
        raise InputError(f"form must be one of {', '.join(sorted(_FORMS))}, got {form!r}")
    terms = _FORMS[form]
    heights = np.asarray(heights, dtype=np.float64)
    rows, columns = _box(heights, terms, form)
    basis_y = _legendre(heights.shape[0], rows)
    basis_x = _legendre(heights.shape[1], columns)
    gram = _gram(heights, basis_y, basis_x, terms)
    scale = 1 / np.sqrt(np.diag(gram))
    values, vectors = np.linalg.eigh(gram * scale[:, None] * scale)
    # A full map has a smallest eigenvalue of order 0.1; points on one line give rounding only.
    if values[0] < 1e-10:
        raise InputError(_too_few(heights, form))
    solve = (vectors / values) @ vectors.T * scale[:, None] * scale
    residual = heights.copy()
    for _ in range(2):
        coefficients = solve @ _moments(residual, basis_y, basis_x, terms)
        for block in _blocks(heights.shape):
            for (power_y, power_x), coefficient in zip(terms, coefficients, strict=True):
                residual[block] -= np.outer(coefficient * basis_y[block, power_y],
                                            basis_x[:, power_x])  # fmt: skip
    return residual


def crop(heights: Array, rows: tuple[int, int], columns: tuple[int, int]) -> Array:
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
        if not (0 <= start and start + 2 <= stop <= length):
            raise InputError(
                f"{name} must be (start, stop) with 0 <= start, stop <= {length} and at least 2 "
                f"between them, got ({start}, {stop})"
            )
    return heights[slice(*rows), slice(*columns)].copy()


def _blocks(shape: tuple[int, ...]) -> Iterator[slice]:
    step = max(1, _BLOCK // shape[1])
    for start in range(0, shape[0], step):
        yield slice(start, min(start + step, shape[0]))


def _too_few(heights: Array, form: str) -> str:
    count = int(np.count_nonzero(np.isfinite(heights)))
    return (
        f"heights has {count} points that are there, too few or in too few lines to fit a {form}; "
        "fit a simpler form"
    )


def _box(
    heights: Array, terms: tuple[tuple[int, int], ...], form: str
) -> tuple[tuple[int, int], tuple[int, int]]:
    there = np.isfinite(heights)
    if np.count_nonzero(there) < len(terms):
        raise InputError(_too_few(heights, form))
    rows, columns = (np.flatnonzero(there.any(axis=axis)) for axis in (1, 0))
    return (int(rows[0]), int(rows[-1])), (int(columns[0]), int(columns[-1]))


def _legendre(length: int, box: tuple[int, int]) -> Array:
    # Coordinates from -1 to 1 over the box; outside it the values do not enter the fit.
    first, last = box
    t = (2.0 * np.arange(length) - first - last) / max(last - first, 1)
    return np.stack([np.ones_like(t), t, 1.5 * t * t - 0.5], axis=1)


def _gram(
    heights: Array, basis_y: Array, basis_x: Array, terms: tuple[tuple[int, int], ...]
) -> Array:
    # sums[b, c, i, j] = Σ_y Y_b Y_c Σ_x X_i X_j over the points that are there.
    pairs_x = (basis_x[:, :, None] * basis_x[:, None, :]).reshape(-1, 9)
    sums = np.zeros((3, 3, 3, 3))
    for block in _blocks(heights.shape):
        there = np.isfinite(heights[block]).astype(np.float64)
        along = (there @ pairs_x).reshape(-1, 3, 3)
        sums += np.einsum("yb,yc,yij->bcij", basis_y[block], basis_y[block], along)
    return np.array([[sums[b, c, i, j] for c, j in terms] for b, i in terms])


def _moments(
    heights: Array, basis_y: Array, basis_x: Array, terms: tuple[tuple[int, int], ...]
) -> Array:
    sums = np.zeros((3, 3))
    for block in _blocks(heights.shape):
        there = np.where(np.isfinite(heights[block]), heights[block], 0.0)
        sums += basis_y[block].T @ (there @ basis_x)
    return np.array([sums[b, i] for b, i in terms])
