"""Preparation of a measured map: level, form, outliers, crop, rotate."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from roughcontact.errors import InputError, require_pixel, require_positive

Array = NDArray[np.float64]

Terms = tuple[tuple[int, int], ...]

# What a shape says at the points y, x: heights, and their derivatives by each parameter.
_Model = Callable[[Array, Array, Array], tuple[Array, list[Array]]]

# Powers (of y, of x) of each form.
_FORMS: dict[str, Terms] = {
    "mean": ((0, 0),),
    "plane": ((0, 0), (0, 1), (1, 0)),
    "quadric": ((0, 0), (0, 1), (1, 0), (0, 2), (1, 1), (2, 0)),
}
_LEVELS = (*_FORMS, "robust", "three-point")

# Tukey's constant: 95 % of the efficiency of least squares on normal heights.
_TUKEY = 4.685

# Above this degree a map cannot tell form from roughness, and the sums grow with its fourth power.
_MAX_DEGREE = 20

# Scaled normal equations below this smallest eigenvalue are taken as singular. A full map has
# one of order 0.1; points on one line give rounding only.
_SINGULAR = 1e-10

# Values per block of rows: temporaries of 8 MiB, whatever the size of the map.
_BLOCK = 2**20


def level(
    heights: Array, form: str = "plane", points: Sequence[tuple[int, int]] | None = None
) -> Array:
    """Return the heights without a fitted mean, plane or quadric.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights, NaN where missing.
    form : {"plane", "quadric", "mean", "robust", "three-point"}
        What is fitted to the points that are there: by least squares a plane, a polynomial of
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
        If the form is unknown, if the points that are there do not determine it, or if the three
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
    return _without_terms(heights, _FORMS[form], form)


def remove_form(
    heights: Array, pixel: tuple[float, float], shape: str, degree: int | None = None
) -> tuple[Array, dict[str, float]]:
    """Return the heights without a least-squares shape, and what was fitted.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights [m], NaN where missing.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    shape : {"sphere", "cylinder", "polynomial"}
        A sphere; a circular cylinder with any direction of its axis in the plane of the map and
        any slope along it; or a polynomial of x and y.
    degree : int, optional
        Total degree of the polynomial, 0 to 20, and only of that.

    Returns
    -------
    residual : ndarray, shape (ny, nx)
        Heights less shape [m], with zero mean; NaN stays NaN.
    parameters : dict of str to float
        Sphere: ``radius`` [m], positive for a summit and negative for a bowl, and ``centre_y``,
        ``centre_x`` (from point ``[0, 0]``) and ``centre_z`` [m]. Cylinder: ``radius`` [m] with
        the same sign, ``angle`` of the axis [rad] from the x axis towards the y axis in
        (-π/2, π/2], ``slope`` of the axis along that direction. Polynomial: ``degree`` and
        ``removed_rms`` [m], the root-mean-square height of what was taken away about its mean.

    Raises
    ------
    InputError
        If the shape is unknown, or if the points that are there do not determine it: too few, in
        too few lines, flat within three standard errors of the curvature, no direction of an axis
        preferred, or not converged.

    Notes
    -----
    Minimises the sum of squares of the height differences (not of distances along the normal)
    over the sphere or cylinder itself, not over a paraboloid. The unknowns are height, slopes and
    curvature k at the middle of the map, in which the flat limit is regular: for the sphere the
    height w there solves k/2 (x² + y² + w²) + w - p x - q y = 0, and R = √(1 + p² + q²)/k.
    Levenberg–Marquardt steps start from the least-squares quadric.

    Examples
    --------
    >>> y, x = np.mgrid[-20:21, -30:31] * 1e-6
    >>> heights = np.sqrt(1e-3**2 - x**2 - y**2)
    >>> residual, parameters = remove_form(heights, (1e-6, 1e-6), "sphere")
    >>> round(parameters["radius"], 9)
    0.001
    """
    heights = np.asarray(heights, dtype=np.float64)
    require_pixel(pixel)
    if (degree is not None) != (shape == "polynomial"):
        raise InputError(
            "must be given with the shape 'polynomial' and only with it, "
            f"got shape {shape!r} and degree {degree!r}",
            argument="degree",
        )
    if degree is not None:
        if not isinstance(degree, (int, np.integer)) or not 0 <= degree <= _MAX_DEGREE:
            raise InputError(
                f"must be an integer from 0 to {_MAX_DEGREE}, got {degree!r}",
                argument="degree",
                value=degree,
            )
        terms = tuple((b, n - b) for n in range(degree + 1) for b in range(n + 1))
        residual = _without_terms(heights, terms, f"polynomial of degree {degree}")
        removed = float(np.nanstd(heights - residual))
        return residual, {"degree": float(degree), "removed_rms": removed}
    if shape == "sphere":
        return _remove_sphere(heights, pixel)
    if shape == "cylinder":
        return _remove_cylinder(heights, pixel)
    raise InputError(
        f"must be one of cylinder, polynomial, sphere, got {shape!r}", argument="shape", value=shape
    )


def remove_outliers(heights: Array, limit: float = 6.0, window: int = 5) -> Array:
    """Return the heights with spikes replaced by NaN.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights, NaN where missing.
    limit : float
        Largest deviation from the local median that is kept, in robust standard deviations.
    window : int
        Points along each side of the square whose median is taken; odd, 3 to 31.

    Returns
    -------
    ndarray, shape (ny, nx)
        A new array; what is kept keeps its bits.

    Raises
    ------
    InputError
        If the limit is not positive, or the window is even or out of bounds.

    Notes
    -----
    The median is that of the points of the window that are there; beyond the edge the map goes on
    by point reflection, so that a tilt alone makes no outliers. The robust standard deviation is
    1.4826 × the median of all absolute deviations; where that is zero, as when most points equal
    their local median, 1.2533 × their mean. A spike wider than about half a window is taken as
    part of the surface. Where a form bends more within a window than the map is rough, its summit
    would count as an outlier: remove the form first.
    """
    require_positive(limit=limit)
    if not isinstance(window, (int, np.integer)) or not (3 <= window <= 31 and window % 2):
        raise InputError(
            f"must be an odd number of points from 3 to 31, got {window!r}",
            argument="window",
            value=window,
        )
    heights = np.asarray(heights, dtype=np.float64)
    deviation = np.abs(heights - _local_median(heights, int(window)))
    there = deviation[np.isfinite(deviation)]
    sigma = 1.4826 * float(np.median(there))
    if sigma == 0:
        sigma = 1.2533 * float(np.mean(there))
    kept = heights.copy()
    # Comparing with NaN is false: holes stay as they are.
    kept[deviation > limit * sigma] = np.nan
    return kept


def largest_rectangle(heights: Array) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return the rows and columns of the largest rectangle without holes.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights, NaN where missing.

    Returns
    -------
    rows, columns : (int, int)
        First index and the index after the last, as `crop` takes them; most points, and of
        several such rectangles the one that ends first.

    Raises
    ------
    InputError
        If no 2 × 2 points without a hole are left.

    Notes
    -----
    One pass over the rows. For each point of a row: how far up it is free of holes, and how far
    to the left and right that whole strip can be moved. The largest rectangle is one of them.
    """
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
        points = np.where((depth > 1) & (width > 1), depth * width, 0)
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


def rotate(heights: Array, quarter_turns: int = 1) -> Array:
    """Return the map turned by multiples of 90°.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights.
    quarter_turns : int
        Number of quarter turns, counter-clockwise as the array prints, row 0 on top; negative
        for clockwise. One turn moves the last column to row 0: ``new[i, j] = old[j, nx - 1 - i]``.

    Returns
    -------
    ndarray, shape (ny, nx) or (nx, ny)
        The turned map, a new array with the same values to the bit.

    Raises
    ------
    InputError
        If the number of turns is not an integer.
    """
    if isinstance(quarter_turns, bool) or not isinstance(quarter_turns, (int, np.integer)):
        raise InputError(
            f"must be an integer, got {quarter_turns!r}",
            argument="quarter_turns",
            value=quarter_turns,
        )
    turned: Array = np.rot90(heights, int(quarter_turns) % 4).copy()
    return turned


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
            raise InputError(f"points: the height at ({y}, {x}) is missing; choose another point")
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
    residual = _without_terms(heights, terms, "robust plane")
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
    changed = _without_terms(residual, terms, "robust plane", weights)
    return changed, float(np.nanmax(np.abs(changed - residual)))


def _without_terms(heights: Array, terms: Terms, form: str, weights: Array | None = None) -> Array:
    """Return the heights without the least-squares sum of products of Legendre polynomials."""
    degree = max(max(powers) for powers in terms)
    rows, columns = _box(heights, terms, form)
    basis_y = _legendre(heights.shape[0], rows, degree)
    basis_x = _legendre(heights.shape[1], columns, degree)
    gram = _gram(heights, basis_y, basis_x, terms, weights)
    scale = 1 / np.sqrt(np.diag(gram))
    values, vectors = np.linalg.eigh(gram * scale[:, None] * scale)
    if values[0] < _SINGULAR:
        raise InputError(_too_few(heights, form))
    solve = (vectors / values) @ vectors.T * scale[:, None] * scale
    residual = heights.copy()
    table = np.zeros((degree + 1, degree + 1))
    index = tuple(np.array(terms).T)
    for _ in range(2):
        table[index] = solve @ _moments(residual, basis_y, basis_x, terms, weights)
        for block in _blocks(heights.shape):
            residual[block] -= basis_y[block] @ table @ basis_x.T
    return residual


def _box(heights: Array, terms: Terms, form: str) -> tuple[tuple[int, int], tuple[int, int]]:
    there = np.isfinite(heights)
    if np.count_nonzero(there) < len(terms):
        raise InputError(_too_few(heights, form))
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
    # sums[b, c, i, j] = Σ_y Y_b Y_c Σ_x X_i X_j w over the points that are there.
    count = basis_x.shape[1]
    pairs_y, pairs_x = (
        (basis[:, :, None] * basis[:, None, :]).reshape(-1, count**2)
        for basis in (basis_y, basis_x)
    )
    sums = np.zeros((count**2, count**2))
    for block in _blocks(heights.shape):
        sums += pairs_y[block].T @ (_weighted(heights, block, weights) @ pairs_x)
    b, i = np.array(terms).T
    gram: Array = sums.reshape((count,) * 4)[b[:, None], b, i[:, None], i]
    return gram


def _moments(
    heights: Array, basis_y: Array, basis_x: Array, terms: Terms, weights: Array | None
) -> Array:
    sums = np.zeros((basis_y.shape[1], basis_x.shape[1]))
    for block in _blocks(heights.shape):
        there = np.where(np.isfinite(heights[block]), heights[block], 0.0)
        if weights is not None:
            there *= _weighted(heights, block, weights)
        sums += basis_y[block].T @ (there @ basis_x)
    moments: Array = sums[tuple(np.array(terms).T)]
    return moments


def _local_median(heights: Array, window: int) -> Array:
    reach = window // 2
    # Odd reflection of a map of n points defines at most n - 1 beyond its edge at a time; NumPy
    # repeats it where the window is larger than the map.
    padded = np.pad(heights, reach, mode="reflect", reflect_type="odd")
    ny, nx = heights.shape
    median = np.empty_like(heights)
    step = max(1, 4 * _BLOCK // (nx * window**2))
    for start in range(0, ny, step):
        stop = min(start + step, ny)
        part = np.lib.stride_tricks.sliding_window_view(
            padded[start : stop + 2 * reach], (window, window)
        )
        # NaN sorts to the end, so the median of the n that are there sits among the first n.
        ordered = np.sort(part.reshape(stop - start, nx, -1), axis=-1)
        count = np.count_nonzero(np.isfinite(ordered), axis=-1)
        middle = [np.maximum(index, 0)[..., None] for index in ((count - 1) // 2, count // 2)]
        low, high = (
            np.take_along_axis(ordered, np.minimum(index, window**2 - 1), axis=-1)[..., 0]
            for index in middle
        )
        median[start:stop] = 0.5 * (low + high)
    return median


# --- sphere and cylinder: in units of half the diagonal of the map -----------------------------


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
    # Along the axis a straight line of slope m; each vertical section across it is an ellipse,
    # k/2 (t² + g w²) + w - q t = 0 with g = 1/(1 + m²).
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

    def __init__(self, heights: Array, pixel: tuple[float, float], name: str) -> None:
        there = np.isfinite(heights)
        self.count = int(np.count_nonzero(there))
        self.name = name
        self.failure = _too_few(heights, name)
        if self.count < 7:
            raise InputError(self.failure)
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
        for block in _blocks(self.heights.shape):
            heights = self.heights[block]
            there = np.isfinite(heights)
            row, column = np.nonzero(there)
            # Points beyond the equator of a trial sphere give NaN: the step is not taken.
            with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
                fitted, partials = model(values, self.y[block][row], self.x[column])
                difference = heights[there] - fitted
                jacobian = np.stack(partials)
                cost += float(difference @ difference)
                if not math.isfinite(cost):
                    return math.inf, matrix, right
                matrix += jacobian @ jacobian.T
                right += jacobian @ difference
        return cost, matrix, right

    def inverse(self, matrix: Array) -> Array:
        """Return the inverse of a normal matrix, or refuse a singular one."""
        diagonal = np.diag(matrix)
        if not (np.isfinite(matrix).all() and diagonal.min() > 0):
            raise InputError(self.failure)
        scale = 1 / np.sqrt(diagonal)
        eigenvalues, vectors = np.linalg.eigh(matrix * scale[:, None] * scale)
        if eigenvalues[0] < _SINGULAR:
            raise InputError(self.failure)
        inverse: Array = (vectors / eigenvalues) @ vectors.T * scale[:, None] * scale
        return inverse

    def quadric(self) -> tuple[Array, Array]:
        """Return the parameters of the least-squares quadric and their covariance."""
        values = np.zeros(6)
        _, matrix, right = self.sums(_quadric, values)
        inverse = self.inverse(matrix)
        values = inverse @ right
        cost = self.sums(_quadric, values)[0]
        # Rounding errors of the heights need not be independent: they do not average out.
        noise = cost / (self.count - 6) + self.count * self.rounding**2
        rounding = 1e-12 * float(np.abs(values[3:]).max())
        return values, inverse * noise + rounding**2 * np.eye(6)

    def require_curved(self, curvature: float, variance: float) -> None:
        if abs(curvature) <= 3 * math.sqrt(variance):
            raise InputError(
                f"heights is too flat to fit a {self.name}: its curvature is "
                f"{curvature / self.length:.3g} ± {math.sqrt(variance) / self.length:.2g} 1/m; "
                "level it instead, e.g. surface.leveled()"
            )

    def solve(self, model: _Model, values: Array) -> Array:
        """Return the parameters of least squares by Levenberg–Marquardt steps."""
        cost, matrix, right = self.sums(model, values)
        damping = 1e-4
        for _ in range(200):
            diagonal = np.diag(np.diag(matrix))
            try:
                step = np.linalg.solve(matrix + damping * diagonal, right)
            except np.linalg.LinAlgError:
                break
            # Root mean square of what the step changes in the heights.
            change = math.sqrt(max(float(step @ matrix @ step), 0.0) / self.count)
            trial = self.sums(model, values + step)
            # The sum cannot resolve the last steps: its rounding must not stop them.
            slack = 1e-12 * cost + self.count * (10 * self.rounding) ** 2
            if trial[0] <= cost + slack:
                values = values + step
                cost, matrix, right = trial
                damping = max(0.1 * damping, 1e-15)
            else:
                damping *= 10
            scatter = math.sqrt(cost / self.count)
            # A step that damping has shortened says nothing.
            if change <= max(1e-9 * scatter, 10 * self.rounding) and damping <= 10:
                self.inverse(matrix)
                return values
        raise InputError(
            f"no {self.name} fits the heights: the least-squares iteration did not settle; "
            "level the map or fit another shape"
        )

    def feasible(self, model: _Model, values: Array, curvature: int) -> Array:
        """Return start values flattened until every point lies on the shape."""
        values = values.copy()
        for _ in range(100):
            if math.isfinite(self.sums(model, values)[0]):
                break
            values[curvature] *= 0.7
        return values

    def residual(self, heights: Array, model: _Model, values: Array) -> Array:
        residual = heights - self.offset
        for block in _blocks(heights.shape):
            y, x = np.broadcast_arrays(self.y[block][:, None], self.x)
            # The corners of a map may lie beyond the equator, if nothing was measured there.
            with np.errstate(invalid="ignore", divide="ignore"):
                residual[block] -= self.length * model(values, y, x)[0]
        return residual


def _remove_sphere(heights: Array, pixel: tuple[float, float]) -> tuple[Array, dict[str, float]]:
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


def _remove_cylinder(heights: Array, pixel: tuple[float, float]) -> tuple[Array, dict[str, float]]:
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
            "is curved alike in both directions, which leaves the axis of a cylinder "
            "open; fit a sphere or a polynomial",
            argument="heights",
        )
    x, y = (float(value) for value in directions[:, axis])
    angle = math.atan2(y, x)
    slopes = (p * x + q * y, -p * y + q * x)
    start = fit.feasible(_cylinder, np.array([c, *slopes, -across, angle]), 3)
    values = fit.solve(_cylinder, start)
    m, slope, k, angle = (float(value) for value in values[1:])
    half_turns = math.ceil(angle / math.pi - 0.5)
    parameters = {
        "radius": fit.length * math.sqrt(1 + m * m + slope * slope) / k,
        "angle": angle - math.pi * half_turns,
        "slope": -m if half_turns % 2 else m,
    }
    return fit.residual(heights, _cylinder, values), parameters
