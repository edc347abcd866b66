"""Mean, plane or quadric of a map, subtracted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from roughcontact.errors import InputError
from roughcontact.surface.polynomials import Terms, without_terms

Array = NDArray[np.float64]

# Powers (of y, of x) of each form.
_FORMS: dict[str, Terms] = {
    "mean": ((0, 0),),
    "plane": ((0, 0), (0, 1), (1, 0)),
    "quadric": ((0, 0), (0, 1), (1, 0), (0, 2), (1, 1), (2, 0)),
}

_LEVELS = (*_FORMS, "robust", "three-point")

# Tukey's constant: 95 % of the efficiency of least squares on normal heights.
_TUKEY = 4.685


def level(
    heights: Array, form: str = "plane", points: Sequence[tuple[int, int]] | None = None
) -> Array:
    """Return the heights without a fitted mean, plane or quadric.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights, NaN where missing.
    form : {"plane", "quadric", "mean", "robust", "three-point"}
        What is fitted to the valid points: by least squares a plane, a polynomial of
        second degree in x and y, or a constant; a plane that outliers do not tilt; or the plane
        through three points. The pixel does not matter to any of them.
    points : three pairs of int, optional
        Indices ``(y, x)`` of the points of "three-point", and only of that.

    Returns
    -------
    ndarray, shape (ny, nx)
        The residual, a new array; NaN stays NaN. Its mean is zero to rounding for the forms of
        least squares only; for "three-point" the three points are at zero.

    Raises
    ------
    InputError
        If the form is unknown, if the valid points do not determine it, or if the three
        points are missing, off the map or on one line.

    Notes
    -----
    The normal equations are set up in Legendre polynomials over the box that holds the points.
    Their sums separate into a product over each row and one over the rows, so no array larger
    than a few rows is made. A second fit, to the residual, takes out what the first one lost by
    rounding.

    "robust" reweights least squares: first towards least absolute deviations, which gives a scale
    σ = 1.4826 × the median absolute residual, then with Tukey's biweight, which leaves out points
    further than 4.685 σ from the plane.

    Examples
    --------
    >>> y, x = np.mgrid[:3, :4]
    >>> bool(np.allclose(level(1.0 + 2 * x - y, "plane"), 0))
    True
    """
    if form not in _LEVELS:
        raise InputError(
            f"must be one of {', '.join(sorted(_LEVELS))}, got {form!r}",
            argument="form",
            value=form,
        )
    if (points is not None) != (form == "three-point"):
        raise InputError(
            "must be given with the form 'three-point' and only with it, "
            f"got form {form!r} and points {points!r}",
            argument="points",
        )
    heights = np.asarray(heights, dtype=np.float64)
    if points is not None:
        return _three_point(heights, points)
    if form == "robust":
        return _robust_plane(heights)
    return without_terms(heights, _FORMS[form], form)


def _three_point(heights: Array, points: Sequence[tuple[int, int]]) -> Array:
    try:
        corners = np.array([[int(y), int(x)] for y, x in points])
    except (TypeError, ValueError):
        corners = np.empty((0, 2), dtype=np.int64)
    if corners.shape != (3, 2):
        raise InputError(
            f"must be three pairs (y, x) of indices, got {points!r}",
            argument="points",
            value=points,
        )
    ny, nx = heights.shape
    for y, x in corners:
        if not (0 <= y < ny and 0 <= x < nx):
            raise InputError(
                f"must lie on the map of {ny} × {nx} points, got ({y}, {x})", argument="points"
            )
        if not np.isfinite(heights[y, x]):
            raise InputError(
                f"must be measured, but the height at ({y}, {x}) is missing; choose another point",
                argument="points",
            )
    (ay, ax), (by, bx) = corners[1:] - corners[0]
    determinant = int(ay * bx - ax * by)
    if determinant == 0:
        raise InputError(
            f"must not lie on one line, got {points!r}", argument="points", value=points
        )
    origin, first, second = (float(heights[y, x]) for y, x in corners)
    slope_y = ((first - origin) * bx - (second - origin) * ax) / determinant
    slope_x = ((second - origin) * ay - (first - origin) * by) / determinant
    y, x = np.arange(ny) - corners[0, 0], np.arange(nx) - corners[0, 1]
    plane = slope_y * y[:, None] + slope_x * x
    residual: Array = (heights - origin) - plane
    return residual


def _robust_plane(heights: Array) -> Array:
    terms = _FORMS["plane"]
    residual = without_terms(heights, terms, "robust plane")
    there = np.isfinite(heights)
    rounding = 1e-15 * float(np.abs(heights[there]).max())
    # Least absolute deviations: weights 1/|r|, bounded near the plane.
    for _ in range(100):
        size = np.abs(residual)
        sigma = 1.4826 * float(np.median(size[there]))
        if sigma <= rounding:
            return residual
        lower = 1e-3 * sigma
        # Weights of at most 1 keep the sums near those of plain least squares.
        residual, change = _step(residual, terms, lower / np.maximum(size, lower))
        if change < 1e-3 * sigma:
            break
    sigma = 1.4826 * float(np.median(np.abs(residual[there])))
    if sigma <= rounding:
        return residual
    for _ in range(100):
        weights = np.square(1 - np.minimum(np.square(residual / (_TUKEY * sigma)), 1))
        residual, change = _step(residual, terms, weights)
        if change < 1e-7 * sigma:
            break
    return residual


def _step(residual: Array, terms: Terms, weights: Array) -> tuple[Array, float]:
    changed = without_terms(residual, terms, "robust plane", weights)
    return changed, float(np.nanmax(np.abs(changed - residual)))
