"""Mean, plane, polynomial, sphere or cylinder of a map, fitted and removed.

`remove_form`: Minimizes the sum of squares of the height differences (not of distances along the
normal) over the sphere or cylinder itself, not over a paraboloid. The unknowns are height, slopes
and curvature k at the center of the map, in which the flat limit is regular: for the sphere the
height w there solves k/2 (x² + y² + w²) + w - p x - q y = 0, and R = √(1 + p² + q²)/k.
Levenberg–Marquardt steps start from the least-squares quadric.

`level`: The normal equations are set up in Legendre polynomials over the bounding box of the
points. Their sums separate into a product over each row and one over the rows, so no array larger
than a few rows is needed. A second fit, to the residual, removes the rounding error of the first.

"robust" reweights least squares: first towards least absolute deviations, which gives a scale σ =
1.4826 × the median absolute residual, then with Tukey's biweight, which excludes points further
than 4.685 σ from the plane.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from roughcontact._tools.arrays import Array, Pixel
from roughcontact.errors import InputError, input_error, require_pixel
from roughcontact.surface import grid

Terms = tuple[tuple[int, int], ...]

# Smallest eigenvalue of the scaled normal equations below which they are singular: a full map has
# about 0.1, points on one line only rounding.
SINGULAR = 1e-10


def too_few(heights: Array, form: str) -> InputError:
    """Return the error for a map whose points do not determine a form."""
    count = int(np.count_nonzero(np.isfinite(heights)))
    return InputError(
        f"has {count} valid points, too few or in too few lines to fit a {form}; "
        "fit a simpler form",
        argument="heights",
    )


def subtract_terms(heights: Array, terms: Terms, form: str, weights: Array | None = None) -> Array:
    """Return the heights without the least-squares sum of products of Legendre polynomials."""
    if heights.shape[0] == 1:
        terms = tuple((along_y, along_x) for along_y, along_x in terms if not along_y)
    degree = max(max(powers) for powers in terms)
    rows, columns = _box(heights, terms, form)
    basis_y = _legendre(heights.shape[0], rows, degree)
    basis_x = np.ascontiguousarray(_legendre(heights.shape[1], columns, degree).T)
    gram = _gram(heights, basis_y, basis_x, terms, weights)
    diagonal = np.diag(gram)
    # Points on a single row or column do not determine a slope across it.
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
        for block in grid.row_blocks(heights.shape):
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
    # Coordinates from -1 to 1 over the box; values outside it do not enter the fit.
    first, last = box
    t = (2.0 * np.arange(length) - first - last) / max(last - first, 1)
    # High powers far outside the box would overflow.
    return np.asarray(np.polynomial.legendre.legvander(np.clip(t, -1, 1), degree), dtype=np.float64)


def _point_weights(heights: Array, block: slice, weights: Array | None) -> Array:
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
    for block in grid.row_blocks(heights.shape):
        sums += _project(_point_weights(heights, block, weights), pairs_y[block], pairs_x)
    b, i = np.array(terms).T
    return sums.reshape((count,) * 4)[b[:, None], b, i[:, None], i]


def _moments(
    heights: Array, basis_y: Array, basis_x: Array, terms: Terms, weights: Array | None
) -> Array:
    sums = np.zeros((basis_y.shape[1], len(basis_x)))
    for block in grid.row_blocks(heights.shape):
        there = np.where(np.isfinite(heights[block]), heights[block], 0.0)
        if weights is not None:
            there *= _point_weights(heights, block, weights)
        sums += _project(there, basis_y[block], basis_x)
    return sums[tuple(np.array(terms).T)]


def _inverse(matrix: Array) -> Array:
    """Return the inverse of a symmetric, positive definite matrix, without LAPACK."""
    swept = matrix.copy()
    for i in range(len(matrix)):
        column, pivot = swept[:, i].copy(), swept[i, i]
        row = column / pivot
        swept -= column[:, None] * row
        swept[i] = swept[:, i] = row
        swept[i, i] = -1 / pivot
    return -swept


def _project(values: Array, along_y: Array, along_x: Array) -> Array:
    """Return the sums of products of a map with functions of y (columns) and x (rows)."""
    rows = np.einsum("by,yx->bx", np.ascontiguousarray(along_y.T), values)
    return np.einsum("bx,ix->bi", rows, along_x)


# Function for the heights of a shape at the points y, x, and their derivatives with respect to the
# parameters.
_Model = Callable[[Array, Array, Array], tuple[Array, list[Array]]]

# Above this degree form and roughness cannot be distinguished, and the cost grows with degree⁴.
_MAX_DEGREE = 20


def remove_form(
    heights: Array, pixel: Pixel, shape: str, degree: int | None = None
) -> tuple[Array, dict[str, float]]:
    """Return the heights without a least-squares shape, and the parameters of the shape."""
    heights = np.asarray(heights, dtype=np.float64)
    require_pixel(pixel)
    if (degree is not None) != (shape == "polynomial"):
        raise InputError(
            "must be given with the shape 'polynomial' and only with it, "
            f"got shape {shape!r} and degree {degree!r}",
            argument="degree",
        )
    if degree is not None:
        return _remove_polynomial(heights, degree)
    if heights.shape[0] == 1:
        return _remove_circle(heights, pixel, shape)
    if shape == "sphere":
        return _remove_sphere(heights, pixel)
    if shape == "cylinder":
        return _remove_cylinder(heights, pixel)
    raise input_error("shape", shape, "must be one of cylinder, polynomial, sphere")


def _remove_circle(heights: Array, pixel: Pixel, shape: str) -> tuple[Array, dict[str, float]]:
    """Remove the circle of a profile, fitted as a cylinder along y."""
    if shape != "cylinder":
        raise input_error("shape", shape, "must be cylinder or polynomial of a profile")
    square = 0.5 * (heights.shape[1] - 1) * pixel[1], pixel[1]
    residual, parameters = _remove_cylinder(np.repeat(heights, 3, axis=0), square)
    return residual[:1].copy(), parameters


def _quadric(values: Array, y: Array, x: Array) -> tuple[Array, list[Array]]:
    c, p, q, xx, xy, yy = values
    partials = [np.ones_like(x), x, y, 0.5 * x * x, x * y, 0.5 * y * y]
    return c + p * x + q * y + 0.5 * (xx * x * x + yy * y * y) + xy * x * y, partials


def _sphere(values: Array, y: Array, x: Array) -> tuple[Array, list[Array]]:
    c, p, q, k = values
    square = x * x + y * y
    constant = 0.5 * k * square - p * x - q * y
    root = np.sqrt(1 - 2 * k * constant)
    w = -2 * constant / (1 + root)
    return c + w, [np.ones_like(x), x / root, y / root, -0.5 * (square + w * w) / root]


def _cylinder(values: Array, y: Array, x: Array) -> tuple[Array, list[Array]]:
    # Along the axis the surface is a straight line of slope m; each vertical section across it is
    # an ellipse, k/2 (t² + g w²) + w - q t = 0 with g = 1/(1 + m²).
    c, m, q, k, angle = values
    along = x * math.cos(angle) + y * math.sin(angle)
    t = y * math.cos(angle) - x * math.sin(angle)
    g = 1 / (1 + m * m)
    constant = 0.5 * k * t * t - q * t
    root = np.sqrt(1 - 2 * k * g * constant)
    w = -2 * constant / (1 + root)
    partials = [
        np.ones_like(x),
        along + k * m * (g * w) ** 2 / root,
        t / root,
        -0.5 * (t * t + g * w * w) / root,
        m * t - along * (q - k * t) / root,
    ]
    return c + m * along + w, partials


class _Fit:
    """Sums of squares of a model over the points of a map, in units of half its diagonal."""

    def __init__(self, heights: Array, pixel: Pixel, name: str) -> None:
        there = np.isfinite(heights)
        self.count = int(np.count_nonzero(there))
        self.name = name
        self.failure = too_few(heights, name)
        if self.count < 7:
            raise self.failure
        ny, nx = heights.shape
        self.middle = (0.5 * (ny - 1) * pixel[0], 0.5 * (nx - 1) * pixel[1])
        self.length = math.hypot(*self.middle)
        self.y = (np.arange(ny) * pixel[0] - self.middle[0]) / self.length
        self.x = (np.arange(nx) * pixel[1] - self.middle[1]) / self.length
        self.offset = 0.5 * (float(np.nanmin(heights)) + float(np.nanmax(heights)))
        self.heights = (heights - self.offset) / self.length
        self.rounding = 1e-15 * float(np.nanmax(np.abs(heights))) / self.length

    def sums(self, model: _Model, values: Array) -> tuple[float, Array, Array]:
        """Return the sum of squares, the normal matrix and the right-hand side."""
        cost, matrix = 0.0, np.zeros((values.size, values.size))
        right = np.zeros(values.size)
        for block in grid.row_blocks(self.heights.shape):
            heights = self.heights[block]
            there = np.isfinite(heights)
            row, column = np.nonzero(there)
            # Points beyond the equator of a trial sphere give NaN, and the step is rejected.
            with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
                fitted, partials = model(values, self.y[block][row], self.x[column])
                difference = heights[there] - fitted
                jacobian = np.stack(partials)
                cost += float(np.einsum("n,n->", difference, difference))
                if not math.isfinite(cost):
                    return math.inf, matrix, right
                matrix += np.einsum("pn,qn->pq", jacobian, jacobian)
                right += np.einsum("pn,n->p", jacobian, difference)
        return cost, matrix, right

    def inverse(self, matrix: Array) -> Array:
        """Return the inverse of a normal matrix, or raise if it is singular."""
        diagonal = np.diag(matrix)
        if not (np.isfinite(matrix).all() and diagonal.min() > 0):
            raise self.failure
        scale = 1 / np.sqrt(diagonal)
        eigenvalues, vectors = np.linalg.eigh(matrix * scale[:, None] * scale)
        if eigenvalues[0] < SINGULAR:
            raise self.failure
        return (vectors / eigenvalues) @ vectors.T * scale[:, None] * scale

    def quadric(self) -> tuple[Array, Array]:
        """Return the parameters of the least-squares quadric and their covariance."""
        values = np.zeros(6)
        _, matrix, right = self.sums(_quadric, values)
        inverse = self.inverse(matrix)
        values = inverse @ right
        cost = self.sums(_quadric, values)[0]
        # Rounding errors of the heights may be dependent, and then do not average out.
        noise = cost / (self.count - 6) + self.count * self.rounding**2
        rounding = 1e-12 * float(np.abs(values[3:]).max())
        return values, inverse * noise + rounding**2 * np.eye(6)

    def require_curved(self, curvature: float, variance: float) -> None:
        if abs(curvature) <= 3 * math.sqrt(variance):
            raise InputError(
                f"is too flat to fit a {self.name}: its curvature is "
                f"{curvature / self.length:.3g} ± {math.sqrt(variance) / self.length:.2g} 1/m; "
                "level it instead, e.g. surface.leveled()",
                argument="heights",
            )

    def solve(self, model: _Model, values: Array) -> Array:
        """Return the least-squares parameters by Levenberg–Marquardt steps."""
        cost, matrix, right = self.sums(model, values)
        damping = 1e-4
        for _ in range(200):
            diagonal = np.diag(np.diag(matrix))
            try:
                step = np.linalg.solve(matrix + damping * diagonal, right)
            except np.linalg.LinAlgError:
                break
            # Root mean square of the change of the heights by the step.
            change = math.sqrt(max(float(step @ matrix @ step), 0.0) / self.count)
            trial = self.sums(model, values + step)
            # The sum cannot resolve the last steps, and its rounding must not stop them.
            slack = 1e-12 * cost + self.count * (10 * self.rounding) ** 2
            if trial[0] <= cost + slack:
                values = values + step
                cost, matrix, right = trial
                damping = max(0.1 * damping, 1e-15)
            else:
                damping *= 10
            scatter = math.sqrt(cost / self.count)
            # A step shortened by damping is no sign of convergence.
            if change <= max(1e-9 * scatter, 10 * self.rounding) and damping <= 10:
                self.inverse(matrix)
                return values
        raise InputError(
            f"no {self.name} fits the heights: the least-squares iteration did not converge; level "
            "the map or fit another shape"
        )

    def feasible(self, model: _Model, values: Array, curvature: int) -> Array:
        """Return start values flattened until every measured point is on the shape."""
        values = values.copy()
        for _ in range(100):
            if math.isfinite(self.sums(model, values)[0]):
                break
            values[curvature] *= 0.7
        return values

    def residual(self, heights: Array, model: _Model, values: Array) -> Array:
        residual = heights - self.offset
        for block in grid.row_blocks(heights.shape):
            y, x = np.broadcast_arrays(self.y[block][:, None], self.x)
            # Corners of the map that were not measured may be beyond the equator.
            with np.errstate(invalid="ignore", divide="ignore"):
                residual[block] -= self.length * model(values, y, x)[0]
        return residual


def _remove_polynomial(heights: Array, degree: int) -> tuple[Array, dict[str, float]]:
    if not isinstance(degree, (int, np.integer)) or not 0 <= degree <= _MAX_DEGREE:
        raise input_error("degree", degree, f"must be an integer from 0 to {_MAX_DEGREE}")
    terms = tuple((b, n - b) for n in range(degree + 1) for b in range(n + 1))
    residual = subtract_terms(heights, terms, f"polynomial of degree {degree}")
    removed = float(np.nanstd(heights - residual))
    return residual, {"degree": float(degree), "removed_rms": removed}


def _remove_sphere(heights: Array, pixel: Pixel) -> tuple[Array, dict[str, float]]:
    fit = _Fit(heights, pixel, "sphere")
    (c, p, q, xx, _, yy), covariance = fit.quadric()
    variance = 0.25 * (covariance[3, 3] + covariance[5, 5] + 2 * covariance[3, 5])
    fit.require_curved(-0.5 * (xx + yy), variance)
    start = fit.feasible(_sphere, np.array([c, p, q, -0.5 * (xx + yy)]), 3)
    values = fit.solve(_sphere, start)
    c, p, q, k = (float(value) for value in values)
    if k == 0:
        fit.require_curved(0.0, variance)
    parameters = {
        "radius": fit.length * math.sqrt(1 + p * p + q * q) / k,
        "centre_y": fit.middle[0] + fit.length * q / k,
        "centre_x": fit.middle[1] + fit.length * p / k,
        "centre_z": fit.offset + fit.length * (c - 1 / k),
    }
    return fit.residual(heights, _sphere, values), parameters


def _remove_cylinder(heights: Array, pixel: Pixel) -> tuple[Array, dict[str, float]]:
    fit = _Fit(heights, pixel, "cylinder")
    (c, p, q, xx, xy, yy), covariance = fit.quadric()
    # The axis is the direction of the smaller principal curvature.
    curvatures, directions = np.linalg.eigh([[xx, xy], [xy, yy]])
    axis = int(np.argmin(np.abs(curvatures)))
    along, across = (float(curvatures[index]) for index in (axis, 1 - axis))
    normal_x, normal_y = (float(value) for value in directions[:, 1 - axis])
    weights = np.array([0, 0, 0, normal_x**2, 2 * normal_x * normal_y, normal_y**2])
    fit.require_curved(-across, float(weights @ covariance @ weights))
    if abs(along) > 0.95 * abs(across):
        raise InputError(
            "has equal curvatures in both directions, so the axis of a cylinder is undefined; fit "
            "a sphere or a polynomial",
            argument="heights",
        )
    x, y = (float(value) for value in directions[:, axis])
    angle = math.atan2(y, x)
    slopes = (p * x + q * y, -p * y + q * x)
    start = fit.feasible(_cylinder, np.array([c, *slopes, -across, angle]), 3)
    values = fit.solve(_cylinder, start)
    m, slope, k, angle = (float(value) for value in values[1:])
    # In the fit the angle runs from x towards y, which points down.
    angle = -angle
    half_turns = math.ceil(angle / math.pi - 0.5)
    parameters = {
        "radius": fit.length * math.sqrt(1 + m * m + slope * slope) / k,
        "angle": math.degrees(angle - math.pi * half_turns),
        "slope": -m if half_turns % 2 else m,
    }
    return fit.residual(heights, _cylinder, values), parameters


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
