"""Influence coefficients of the elastic half-space: displacement in closed form.

All functions return one quadrant, because each kernel is even or odd in x and in y. Components of
the displacement per traction are yy, xx, xy.
"""

from __future__ import annotations

import math

import numpy as np

from roughcontact._tools.arrays import Array, Pixel, Shape
from roughcontact.errors import require_pixel, require_positive

_BLOCK_BYTES = 1 << 18
# Distance in long pixel edges from which moments up to the fourth are exact to 1e-12.
_MOMENT_DISTANCE = 64
# Exponent beyond which a wave has decayed, and the step of the trapezoidal rule for K₀.
_DEAD = 40.0
_STEP = 0.25


def love(shape: Shape, pixel: Pixel, contact_modulus: float, first_row: int = 0) -> Array:
    """Return the displacement of pixels under unit pressure on the pixel ``[0, 0]``.

    Parameters
    ----------
    shape : (int, int)
        Number of offsets ``(ny, nx)``: ``nx`` from 0 in x, ``ny`` from ``first_row`` in y.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    contact_modulus : float
        E* [Pa], from 1/E* = (1 - ν₁²)/E₁ + (1 - ν₂²)/E₂.
    first_row : int
        Offset in y of the first row, for a table computed in bands.

    Returns
    -------
    ndarray, shape (ny, nx)
        Coefficients K [m/Pa]; the other quadrants follow from K(±y, ±x) = K(y, x).

    Raises
    ------
    InputError
        If a pixel edge or the modulus is not positive and finite.

    Notes
    -----
    With a = dx/2, b = dy/2 and the corners X = x ± a, Y = y ± b (Love 1929; Johnson 1985,
    eq. 3.25, for both bodies together)::

        π E* K = Σ± ± X [asinh(Y/X)] from y - b to y + b  +  Σ± ± Y [asinh(X/Y)] from x - a to x + a

    Every bracket is a difference of nearly equal logarithms far from the origin. Written as
    ``log1p`` of an exact small quotient, K keeps a relative error of about N × 10⁻¹⁶ at a
    distance of N pixels; the textbook form loses N² times more. From 64 pixels on, the integral
    of 1/r is expanded in the moments of the pixel, which is faster and as exact there.

    References
    ----------
    Love, Phil. Trans. R. Soc. A 228 (1929) 377, doi:10.1098/rsta.1929.0009;
    Johnson, Contact Mechanics (1985), p. 54, doi:10.1017/CBO9781139171731
    """
    require_pixel(pixel)
    require_positive(contact_modulus=contact_modulus)
    ny, nx = shape
    coefficients = np.empty((ny, nx))
    near = [math.ceil(_MOMENT_DISTANCE * max(pixel) / edge) for edge in pixel]
    near_rows = min(ny, max(0, near[0] - first_row))
    # Row blocks keep the temporaries in cache and out of the peak memory.
    rows = max(1, _BLOCK_BYTES // (8 * (nx + 1)))
    for top in range(0, ny, rows):
        bottom = min(top + rows, ny)
        offsets = np.arange(first_row + top, first_row + bottom, dtype=np.float64)
        near_columns = min(nx, near[1]) if top < near_rows else 0
        block = coefficients[top:bottom]
        if near_columns:
            block[:, :near_columns] = _closed_form(
                offsets, np.arange(near_columns, dtype=np.float64), pixel
            )
        if near_columns < nx:
            block[:, near_columns:] = _expansion(
                offsets, np.arange(near_columns, nx, dtype=np.float64), pixel
            )
    coefficients /= math.pi * contact_modulus
    return coefficients


def _closed_form(rows: Array, columns: Array, pixel: Pixel) -> Array:
    """Return the integral of 1/r over pixels at consecutive offsets, by Love's formula."""
    dy, dx = pixel
    y_center, y_corner = rows[:, None] * dy, _corners(rows)[:, None] * dy
    x_center, x_corner = columns * dx, _corners(columns) * dx
    radius = np.hypot(x_corner, y_corner)
    along_y = x_corner * _log_ratio(y_center, dy, radius[:-1], radius[1:], x_corner)
    along_x = y_corner * _log_ratio(x_center, dx, radius[:, :-1], radius[:, 1:], y_corner)
    return along_y[:, 1:] - along_y[:, :-1] + along_x[1:] - along_x[:-1]


def _corners(offsets: Array) -> Array:
    return np.append(offsets - 0.5, offsets[-1] + 0.5)


def _expansion(rows: Array, columns: Array, pixel: Pixel) -> Array:
    """Return the integral of 1/r over far pixels, by its moments up to the fourth."""
    a, b = (0.5 * edge for edge in (pixel[1], pixel[0]))
    y2, x2 = (rows[:, None] * pixel[0]) ** 2, (columns * pixel[1]) ** 2
    inverse = 1 / (x2 + y2)
    # u and v: squares of the direction cosines; every order is a polynomial in them over r².
    u, v = x2 * inverse, y2 * inverse
    second = a**2 * (2 * u - v) + b**2 * (2 * v - u)
    # ∂x⁴(1/r) = (105 u² - 90 u + 9)/r⁵, ∂x²∂y²(1/r) = (105 uv - 12)/r⁵ with u + v = 1
    fourth = a**4 * (105 * u * u - 90 * u + 9) + b**4 * (105 * v * v - 90 * v + 9)
    fourth *= 1 / 120
    fourth += a**2 * b**2 * (105 / 36 * u * v - 12 / 36)
    fourth *= inverse
    fourth += second / 6
    fourth *= inverse
    fourth += 1
    fourth *= np.sqrt(inverse)
    fourth *= 4 * a * b
    return fourth


def _log_ratio(center: Array, edge: float, near: Array, far: Array, other: Array) -> Array:
    """Return ln[(c + e/2 + r_far) / (c - e/2 + r_near)] without cancellation."""
    # r_far - r_near = (r_far² - r_near²) / (r_far + r_near) = 2 c e / (r_far + r_near)
    ratio = edge * (1 + 2 * center / (near + far)) / (center - edge / 2 + near)
    result = np.log1p(ratio, out=ratio)
    # At c = 0 the denominator above cancels; there the logarithm is an odd function of e/2.
    at_origin = np.broadcast_to(center == 0, result.shape)
    opposite = np.broadcast_to(np.abs(other), result.shape)[at_origin]
    result[at_origin] = 2 * np.arcsinh(edge / 2 / opposite)
    return result


def periodic(shape: Shape, pixel: Pixel, contact_modulus: float) -> Array:
    """Return the displacement per pressure of each wave on a periodic map.

    Parameters
    ----------
    shape : (int, int)
        Grid points ``(ny, nx)`` of one period.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    contact_modulus : float
        E* [Pa].

    Returns
    -------
    ndarray, shape (ny//2 + 1, nx//2 + 1)
        Symbol ``2/(E* |q|)`` [m/Pa] for wave numbers q ≥ 0 in both directions, and 0 at q = 0: the
        mean displacement of a periodic half-space is not defined, so the approach is measured
        from the mean plane of the deformed surface.

    Raises
    ------
    InputError
        If a pixel edge or the modulus is not positive and finite.

    References
    ----------
    Johnson, Contact Mechanics (1985), eq. (13.1), doi:10.1017/CBO9781139171731
    """
    require_pixel(pixel)
    require_positive(contact_modulus=contact_modulus)
    (ny, nx), (dy, dx) = shape, pixel
    qy = 2 * math.pi * np.arange(ny // 2 + 1) / (ny * dy)
    qx = 2 * math.pi * np.arange(nx // 2 + 1) / (nx * dx)
    symbol: Array = np.hypot(qy[:, None], qx)
    symbol[0, qx == 0] = np.inf
    np.divide(2 / contact_modulus, symbol, out=symbol)
    return symbol


def strip(
    shape: Shape, pixel: Pixel, contact_modulus: float, datum: float, waves: slice = slice(None)
) -> Array:
    """Return the displacement per pressure of each wave along x, at each offset along y.

    Parameters
    ----------
    shape : (int, int)
        Number of offsets in y, from 0, and grid points of one period in x.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    contact_modulus : float
        E* [Pa].
    datum : float
        Distance from a line load along x at which the displacement is zero [m].
    waves : slice
        Requested wave numbers of ``0 … nx//2``, for a table computed in parts.

    Returns
    -------
    ndarray, shape (ny, waves)
        Displacement [m/Pa] of the pixels at these offsets under a pressure ``cos(q x)`` on the
        row of pixels at offset 0, over ``cos(q x)``.

    Raises
    ------
    InputError
        If a pixel edge, the modulus or the datum is not positive and finite.

    Notes
    -----
    A line of pressure ``cos(q x)`` displaces the surface at a distance y by ``2/(π E*) K₀(|q y|)``:
    the transform along y of the half-space's ``2/(E* (q² + k²)^½)``. For q = 0 there is plane
    strain, ``-2/(π E*) ln(|y|/datum)``, which has no natural zero. Both are integrated over the
    pixel, whose edge in multiples of 1/q is w. From ``K₀(z) = ∫ exp(-z cosh t) dt`` over t > 0::

        ∫ K₀ over the m-th pixel = 1/q ∫ exp(-(m - ½) w c) (1 - exp(-w c)) / c dt,  c = cosh t,

    and twice this with w/2 for w and without the first factor if m = 0. No term cancels, and
    the trapezoidal rule converges as ``exp(-π²/step)``: all digits with a step of 1/4.

    References
    ----------
    Johnson, Contact Mechanics (1985), sec. 2.2 and eq. (13.1), doi:10.1017/CBO9781139171731;
    NIST Digital Library of Mathematical Functions, 10.32.9, https://dlmf.nist.gov/10.32
    """
    require_pixel(pixel)
    require_positive(contact_modulus=contact_modulus, datum=datum)
    (ny, nx), (dy, dx) = shape, pixel
    q: Array = 2 * math.pi * np.arange(nx // 2 + 1, dtype=np.float64)[waves] / (nx * dx)
    coefficients = np.zeros((ny, q.size))
    uniform = q == 0
    if uniform.any():
        coefficients[:, uniform] = -dy * _mean_logarithm(ny, dy / datum)[:, None]
    # Waves within a factor of two decay over about the same distance.
    first = int(np.count_nonzero(uniform))
    while first < q.size:
        last = int(np.searchsorted(q, 2 * q[first]))
        coefficients[:, first:last] = _bessel_pixels(ny, q[first:last] * dy) / q[first:last]
        first = last
    coefficients *= 2 / (math.pi * contact_modulus)
    return coefficients


def _mean_logarithm(offsets: int, edge: float) -> Array:
    """Return the mean of ln|y| over pixels at consecutive offsets from 0."""
    m = np.arange(1, offsets, dtype=np.float64)
    # (m + ½) ln(m + ½) - (m - ½) ln(m - ½) - 1, without cancellation far away
    beyond = (m + 0.5) * np.log1p(0.5 / m) - (m - 0.5) * np.log1p(-0.5 / m) - 1
    return np.concatenate([[math.log(0.5) - 1], np.log(m) + beyond]) + math.log(edge)


def _bessel_pixels(offsets: int, edges: Array) -> Array:
    """Return the integral of K₀(|z|) over pixels at consecutive offsets from 0.

    The edges are ascending and of similar size; the result has the shape ``(offsets, edges)``.
    """
    integrals = np.zeros((offsets, edges.size))
    cosh, weight = _nodes(math.log(4 / (1e-18 * edges[0])))
    integrals[0] = 2 * (-np.expm1(-0.5 * edges[:, None] * cosh) * weight).sum(axis=1)
    reach = min(offsets, math.ceil(_DEAD / edges[0] + 0.5) + 1)
    top = 1
    while top < reach:
        # Nodes that contribute to the nearest of these rows.
        cosh, weight = _nodes(math.acosh(max(2.0, _DEAD / ((top - 0.5) * edges[0]))))
        z = edges[:, None] * cosh
        bottom = min(reach, top + max(1, _BLOCK_BYTES // (8 * z.size)))
        decay = np.exp((0.5 - np.arange(top, bottom))[:, None, None] * z)
        integrals[top:bottom] = np.einsum("mqt,qt->mq", decay, -np.expm1(-z) * weight)
        top = bottom
    return integrals


def _nodes(end: float) -> tuple[Array, Array]:
    """Return cosh t and the weight of dt/cosh t in the trapezoidal rule from 0 to ``end``."""
    cosh = np.cosh(np.arange(0, end + _STEP, _STEP))
    weight = _STEP / cosh
    weight[0] *= 0.5
    return cosh, weight


def cerruti(
    shape: Shape, pixel: Pixel, contact_modulus: float, poisson: float, first_row: int = 0
) -> Array:
    """Return the tangential displacement by unit traction on the pixel ``[0, 0]``.

    Parameters
    ----------
    shape, pixel, contact_modulus, first_row
        As for `love`.
    poisson : float
        ν of both bodies together, Σ(ν/G)/Σ(1/G).

    Returns
    -------
    ndarray, shape (3, ny, nx)
        Coefficients K_yy, K_xx and K_xy [m/Pa]. The first two are even in x and in y, the third
        is odd in both.

    Notes
    -----
    The point force of Cerruti, with κ = ν/(1 - ν)::

        π E* K_xx = 1/r + κ x²/r³,   π E* K_xy = κ x y/r³,   K_yy by exchange,

    integrated over the pixel by ∫∫ x²/r³ = Σ± y ln(x + r), ∫∫ y²/r³ = Σ± x ln(y + r) and
    ∫∫ x y/r³ = -Σ± r. The sum of the two logarithms is Love's. No difference cancels far away.

    References
    ----------
    Johnson, Contact Mechanics (1985), sec. 3.6, doi:10.1017/CBO9781139171731;
    Pohrt and Li, Phys. Mesomech. 17 (2014) 334, doi:10.1134/S1029959914040109
    """
    require_pixel(pixel)
    require_positive(contact_modulus=contact_modulus)
    (ny, nx), (dy, dx) = shape, pixel
    rows, columns = np.arange(first_row, first_row + ny, dtype=float), np.arange(nx, dtype=float)
    y, y_corner = rows[:, None] * dy, _corners(rows)[:, None] * dy
    x, x_corner = columns * dx, _corners(columns) * dx
    radius = np.hypot(x_corner, y_corner)
    across = np.diff(x_corner * _log_ratio(y, dy, radius[:-1], radius[1:], x_corner))
    along = np.diff(y_corner * _log_ratio(x, dx, radius[:, :-1], radius[:, 1:], y_corner), axis=0)
    # r₊ - r₋ = 2 x dx/(r₊ + r₋) along x, and the same again along y.
    wide, high = radius[:, 1:] + radius[:, :-1], radius[1:] + radius[:-1]
    mixed = 4 * x * y * dx * dy * (1 / high[:, 1:] + 1 / high[:, :-1]) / (wide[1:] * wide[:-1])
    ratio = poisson / (1 - poisson)
    own = across + along
    table = np.stack([own + ratio * across, own + ratio * along, ratio * mixed])
    return table / (math.pi * contact_modulus)


def periodic_tangential(
    shape: Shape, pixel: Pixel, contact_modulus: float, poisson: float
) -> Array:
    """Return the tangential displacement per traction of each wave on a periodic map.

    Parameters
    ----------
    shape, pixel, contact_modulus
        As for `periodic`.
    poisson : float
        As for `cerruti`.

    Returns
    -------
    ndarray, shape (3, ny//2 + 1, nx//2 + 1)
        Symbols of K_yy, K_xx and K_xy [m/Pa], 0 at q = 0; the third is also 0 at Nyquist.

    Notes
    -----
    ``2/(E* q) [1 + κ (1 - q̂ q̂ᵀ)]``, κ = ν/(1 - ν): the normal symbol along a wave, and 1/(1 - ν)
    times it across the wave, which is the antiplane 1/G q of both bodies.

    References
    ----------
    Johnson, Contact Mechanics (1985), sec. 3.6 and eq. (13.1), doi:10.1017/CBO9781139171731
    """
    normal = periodic(shape, pixel, contact_modulus)
    (ny, nx), (dy, dx) = shape, pixel
    qy = np.arange(ny // 2 + 1)[:, None] / (ny * dy)
    qx = np.arange(nx // 2 + 1) / (nx * dx)
    square = qy**2 + qx**2
    square[0, 0] = np.inf
    ratio = poisson / (1 - poisson)
    mixed = -ratio * normal * qx * qy / square
    for axis, points in enumerate(shape):
        if points % 2 == 0:
            mixed[(-1, slice(None)) if axis == 0 else (slice(None), -1)] = 0
    return np.stack(
        [normal * (1 + ratio * qx**2 / square), normal * (1 + ratio * qy**2 / square), mixed]
    )
