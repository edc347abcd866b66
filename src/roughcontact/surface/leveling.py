"""Least-squares mean, plane or quadric, and three-point planes.

`level`: The normal equations are set up in Legendre polynomials over the bounding box of the
points. Their sums separate into a product over each row and one over the rows, so no array larger
than a few rows is needed. A second fit, to the residual, removes the rounding error of the first.

"robust" reweights least squares: first towards least absolute deviations, which gives a scale σ =
1.4826 × the median absolute residual, then with Tukey's biweight, which excludes points further
than 4.685 σ from the plane.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from roughcontact._tools.arrays import Array
from roughcontact.errors import InputError, input_error
from roughcontact.surface.form import Terms, subtract_terms

# Exponents (of y, of x) of the terms of each form.
_FORMS: dict[str, Terms] = {
    "mean": ((0, 0),),
    "plane": ((0, 0), (0, 1), (1, 0)),
    "quadric": ((0, 0), (0, 1), (1, 0), (0, 2), (1, 1), (2, 0)),
}

_LEVELS = (*_FORMS, "robust", "three-point")

# Tukey's constant, for 95 % of the efficiency of least squares on normal heights.
_TUKEY = 4.685


def level(
    heights: Array, form: str = "plane", points: Sequence[tuple[int, int]] | None = None
) -> Array:
    """Return the heights without a fitted mean, plane or quadric."""
    if form not in _LEVELS:
        raise input_error("form", form, f"must be one of {', '.join(sorted(_LEVELS))}")
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
    return subtract_terms(heights, _FORMS[form], form)


def _three_point(heights: Array, points: Sequence[tuple[int, int]]) -> Array:
    try:
        corners = np.array([[int(y), int(x)] for y, x in points])
    except (TypeError, ValueError):
        corners = np.empty((0, 2), dtype=np.int64)
    if corners.shape != (3, 2):
        raise input_error("points", points, "must be three pairs (y, x) of indices")
    ny, nx = heights.shape
    for y, x in corners:
        if not (0 <= y < ny and 0 <= x < nx):
            raise InputError(
                f"must be inside the map of {ny} × {nx} points, got ({y}, {x})", argument="points"
            )
        if not np.isfinite(heights[y, x]):
            raise InputError(
                f"must be measured, but the height at ({y}, {x}) is missing; choose another point",
                argument="points",
            )
    (ay, ax), (by, bx) = corners[1:] - corners[0]
    determinant = int(ay * bx - ax * by)
    if determinant == 0:
        raise input_error("points", points, "must not be on one line")
    origin, first, second = (float(heights[y, x]) for y, x in corners)
    slope_y = ((first - origin) * bx - (second - origin) * ax) / determinant
    slope_x = ((second - origin) * ay - (first - origin) * by) / determinant
    y, x = np.arange(ny) - corners[0, 0], np.arange(nx) - corners[0, 1]
    plane = slope_y * y[:, None] + slope_x * x
    return (heights - origin) - plane


def _robust_plane(heights: Array) -> Array:
    terms = _FORMS["plane"]
    residual = subtract_terms(heights, terms, "robust plane")
    there = np.isfinite(heights)
    rounding = 1e-15 * float(np.abs(heights[there]).max())
    # Weights of least absolute deviations, 1/|r|, bounded near the plane.
    for _ in range(100):
        size = np.abs(residual)
        sigma = 1.4826 * float(np.median(size[there]))
        if sigma <= rounding:
            return residual
        lower = 1e-3 * sigma
        # Weights of at most 1 keep the sums of the order of plain least squares.
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
    changed = subtract_terms(residual, terms, "robust plane", weights)
    return changed, float(np.nanmax(np.abs(changed - residual)))
