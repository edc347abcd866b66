"""Stress in an elastic half-space under elementary surface loads, in closed form.

All functions return one quadrant, because each kernel is even or odd in x and in y.

The body fills z > 0 and tension is positive. Tensors hold xx, yy, zz, yz, xz, xy, in this order.
A pressure pushes into the body, σ_zz = -p at the surface; a traction q pulls on it along x or y,
σ_xz = -q_x and σ_yz = -q_y.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from roughcontact._tools.arrays import Array
from roughcontact.errors import input_error
from roughcontact.halfspace.tensors import XX, XY, XZ, YY, YZ, ZZ


def uniform_pressure(x_edges: Array, y_edges: Array, z: float, poisson: float) -> Iterator[Array]:
    """Yield the components of the stress under a unit pressure on the pixel at the origin.

    Parameters
    ----------
    x_edges, y_edges : ndarray, shape (nx + 1,) and (ny + 1,)
        Edges of consecutive pixels [m], relative to the center of the loaded pixel.
    z : float
        Depth [m].
    poisson : float
        Poisson's ratio ν.

    Yields
    ------
    ndarray, shape (nx, ny)
        xx, yy, zz, yz, xz, xy, one after the other: stress over pressure at the pixel centers [1].
        yz is odd in y, xz odd in x, xy odd in both, the others are even.

    Notes
    -----
    Every derivative is a signed sum over the corners of an elementary function. The functions
    here are odd in each corner coordinate, up to terms that cancel in the sum, and free of 0/0 and
    of cancelling logarithms at the surface. The limits at z = 0 are exact: σ_zz = -1 on the loaded
    pixel and 0 elsewhere. Errors are about 1e-15 of the unit pressure.

    With V = ∫∫ 1/ρ over the loaded rectangle and χ = ∫∫ ln(ρ + z) (Love 1929, sec. 4)::

        2π σ_xx = 2ν V_z - z V_xx - (1-2ν) χ_xx       2π σ_zz = V_z - z V_zz
        2π σ_xy = -(1-2ν) χ_xy - z V_xy               2π σ_xz = -z V_xz

    References
    ----------
    Love, Phil. Trans. R. Soc. A 228 (1929) 377, doi:10.1098/rsta.1929.0009;
    Johnson, Contact Mechanics (1985), secs. 3.2, 3.6, doi:10.1017/CBO9781139171731;
    Liu and Wang, J. Tribol. 124 (2002) 36, doi:10.1115/1.1401017
    """
    x, y = x_edges[:, None], y_edges
    a, b = x * x + z * z, y * y + z * z
    xy = x * y
    radius = np.sqrt(x * x + b)
    zr = z * radius
    # χ_xx and χ_yy; their sum is -V_z.
    chi_xx = np.arctan(xy / (a + zr))
    chi_yy = np.arctan(xy / (b + zr))
    ratio = xy / radius
    v_xx, v_yy = ratio * (z / a), ratio * (z / b)
    for corners in (
        v_xx - chi_xx - 2 * poisson * chi_yy,
        v_yy - chi_yy - 2 * poisson * chi_xx,
        -(chi_xx + chi_yy + v_xx + v_yy),
        v_yy * (z / y),
        v_xx * (z / x),
        -(1 - 2 * poisson) * np.log(radius + z) - z / radius,
    ):
        yield _over_pixels(corners)


def uniform_parts(x_edges: Array, y_edges: Array, z: float, poisson: float) -> Iterator[Array]:
    """Yield the parts of the stress under a uniform pressure and traction on the pixel.

    Parameters
    ----------
    x_edges, y_edges, z, poisson
        As for `uniform_pressure`.

    Yields
    ------
    ndarray, shape (nx, ny)
        The twelve parts of `sum_parts`, one after the other.

    Notes
    -----
    With V and χ as in `uniform_pressure`, and Ω = ∫∫ (z ln(ρ + z) - ρ), the parts are::

        χ_xx, χ_yy, -z V_xx, -z V_yy, -z V_yz, -z V_xz, χ_xy, -z V_xy,
        V_x, A = 2ν Ω_xyy - z χ_xyy, V_y, B = 2ν Ω_xxy - z χ_xxy

    all over 2π.
    """
    x, y = x_edges[:, None], y_edges
    a, b = x * x + z * z, y * y + z * z
    xy = x * y
    radius = np.sqrt(x * x + b)
    zr = z * radius
    yield _over_pixels(np.arctan(xy / (a + zr)))
    yield _over_pixels(np.arctan(xy / (b + zr)))
    ratio = xy / radius
    v_xx, v_yy = ratio * (z / a), ratio * (z / b)
    yield _over_pixels(v_xx)
    yield _over_pixels(v_yy)
    yield _over_pixels(v_yy * (z / y))
    yield _over_pixels(v_xx * (z / x))
    deeper, v_xy = radius + z, z / radius
    yield _over_pixels(np.log(deeper))
    yield _over_pixels(-v_xy)
    # Common part of Ω and χ: 2ν/(R+z) + z/(R (R+z)).
    common = (2 * poisson + v_xy) / deeper
    yield _over_pixels(np.arcsinh(y / np.sqrt(a)))
    yield _over_pixels(-y * common)
    yield _over_pixels(np.arcsinh(x / np.sqrt(b)))
    yield _over_pixels(-x * common)


_ODD_ALONG = (*("", "", "", ""), *("y", "x", "xy", "xy"), *("x", "x", "y", "y"))
PARTS_ODD = tuple(("y" in axes, "x" in axes) for axes in _ODD_ALONG)
"""Whether each of the twelve parts is odd in y, and in x."""


def shares_of_parts(
    poisson: float, pressure: float, pulls: Sequence[tuple[str, float]]
) -> list[tuple[tuple[int, float], ...]]:
    """Return the contribution of each part to the stress under a pressure and tractions.

    Parameters
    ----------
    poisson : float
        Poisson's ratio ν.
    pressure : float
        Pressure.
    pulls : sequence of (axis, float)
        Tractions on the body along "x" or "y".

    Returns
    -------
    list of tuples of (int, float)
        For each of the twelve parts the components of the stress and their factors.

    Notes
    -----
    A pressure gives (Love 1929, sec. 4)::

        σ_xx = -χ_xx - 2ν χ_yy - z V_xx               σ_zz = -χ_xx - χ_yy + z V_xx + z V_yy
        σ_xy = -(1-2ν) χ_xy - z V_xy                  σ_xz = -z V_xz

    and a traction along x (Cerruti; Johnson 1985, eq. 3.76, integrated)::

        σ_xx = 2 V_x + z V_xz - A                     σ_zz = -z V_xz
        σ_yy = 2ν V_x + A                             σ_xz = -χ_xx - χ_yy - z V_xx
        σ_xy = V_y + B                                σ_yz = -z V_xy

    The other components follow with x and y swapped. So tractions in any direction need no more
    parts than a traction along one axis.
    """
    p, nu, across = pressure, poisson, dict(pulls)
    qx, qy = across.get("x", 0.0), across.get("y", 0.0)
    tables = (
        {XX: -p, YY: -2 * nu * p, ZZ: -p, XZ: -qx, YZ: -qy},
        {XX: -2 * nu * p, YY: -p, ZZ: -p, XZ: -qx, YZ: -qy},
        {XX: p, ZZ: -p, XZ: qx},
        {YY: p, ZZ: -p, YZ: qy},
        {YZ: p, ZZ: qy, YY: -qy},
        {XZ: p, ZZ: qx, XX: -qx},
        {XY: -(1 - 2 * nu) * p},
        {XY: p, YZ: qx, XZ: qy},
        {XX: 2 * qx, YY: 2 * nu * qx, XY: qy},
        {XX: -qx, YY: qx, XY: qy},
        {YY: 2 * qy, XX: 2 * nu * qy, XY: qx},
        {YY: -qy, XX: qy, XY: qx},
    )
    return [tuple((number, share) for number, share in part.items() if share) for part in tables]


def sum_parts(
    parts: Iterable[Array], poisson: float, pressure: float, pulls: Sequence[tuple[str, float]]
) -> list[Array]:
    """Return the six components of the stress from its parts.

    Parameters
    ----------
    parts : iterable of ndarray
        The twelve parts.
    poisson, pressure, pulls
        As for `shares_of_parts`.
    """
    result: list[Array] = []
    for part, shares in zip(parts, shares_of_parts(poisson, pressure, pulls), strict=True):
        result = result or [np.zeros(part.shape) for _ in range(6)]
        for number, share in shares:
            result[number] += share * part
    return result


def _over_pixels(corners: Array) -> Array:
    """Return 1/2π times the signed sum over the four corners of each pixel."""
    strips = corners[1:] - corners[:-1]
    pixels = strips[:, 1:] - strips[:, :-1]
    pixels *= 1 / (2 * math.pi)
    return pixels


def normal_force(x: Array, y: Array, z: float, poisson: float) -> Iterator[Array]:
    """Yield the components of the stress under a unit normal force at the origin.

    Parameters
    ----------
    x, y : ndarray, shape (nx,) and (ny,)
        Positions [m].
    z : float
        Depth [m], not 0.
    poisson : float
        Poisson's ratio ν.

    Yields
    ------
    ndarray, shape (nx, ny)
        xx, yy, zz, yz, xz, xy, one after the other [1/m²]: the formulas of `uniform_pressure`
        with V = 1/ρ and χ = ln(ρ + z).

    References
    ----------
    Boussinesq 1885; Johnson, Contact Mechanics (1985), eq. 3.19, doi:10.1017/CBO9781139171731
    """
    x, k = x[:, None], 1 - 2 * poisson
    x2, y2, xy = x * x, y * y, x * y
    rho2 = x2 + y2 + z * z
    rho = np.sqrt(rho2)
    factor = 1 / (2 * math.pi * rho2 * rho)
    v_3 = 3 * z / rho2
    outer = 1 / (rho + z)
    # χ_xx = (1 - x² bend) slope, χ_xy = -xy bend slope, with both in units of 1/ρ³.
    slope = k * rho2 * outer
    bend = slope * (1 / rho2 + outer / rho)
    plain = k * z - slope
    side = bend - v_3
    yield (plain + x2 * side) * factor
    yield (plain + y2 * side) * factor
    yield (-z * z) * v_3 * factor
    yield (-z * y) * v_3 * factor
    yield (-z * x) * v_3 * factor
    yield xy * side * factor


def force_parts(x: Array, y: Array, z: float, poisson: float) -> Iterator[Array]:
    """Yield the parts of the stress under a unit normal or tangential force at the origin.

    Parameters
    ----------
    x, y, z, poisson
        As for `normal_force`.

    Yields
    ------
    ndarray, shape (nx, ny)
        The twelve parts of `uniform_parts` with V = 1/ρ, one after the other [1/m²].

    References
    ----------
    Cerruti 1882; Johnson, Contact Mechanics (1985), eq. 3.76, doi:10.1017/CBO9781139171731
    """
    x = x[:, None]
    x2, y2, xy = x * x, y * y, x * y
    rho2 = x2 + y2 + z * z
    rho = np.sqrt(rho2)
    factor = 1 / (2 * math.pi * rho2 * rho)
    outer = 1 / (rho + z)
    # χ_xx = slope - x² bend, χ_xy = -xy bend, in units of 1/ρ³.
    slope = rho2 * outer
    bend = slope * (1 / rho2 + outer / rho)
    slope *= factor
    bend *= factor
    yield slope - x2 * bend
    yield slope - y2 * bend
    # z/ρ³ and 3z/ρ⁵.
    plain, far = z * factor, (3 * z / rho2) * factor
    yield plain - x2 * far
    yield plain - y2 * far
    yield -y * (z * far)
    yield -x * (z * far)
    yield -xy * bend
    yield -xy * far
    # In units of 1/ρ³: (1-2ν) ρ²/(ρ+z)², and the factor of y² and of x².
    outer *= rho
    first = (1 - 2 * poisson) * outer * outer
    both = (first * (1 + 2 * outer) - 3) / rho2
    yield -x * factor
    yield x * (1 - first + y2 * both) * factor
    yield -y * factor
    yield y * (1 - first + x2 * both) * factor


def waves(
    qy: Array, qx: Array, z: float, poisson: float, pulls: Sequence[tuple[str, float]]
) -> list[Array]:
    """Return the components of the stress by waves of unit pressure, then of tractions.

    Parameters
    ----------
    qy, qx : ndarray, shape (ny, 1) and (nx,)
        Wave vectors [1/m].
    z : float
        Depth [m].
    poisson : float
        Poisson's ratio ν.
    pulls : sequence of (axis, float)
        Tractions on the body along "x" or "y", per pressure.

    Returns
    -------
    list of ndarray, shape (ny, nx)
        xx, yy, zz, yz, xz, xy for the pressure and for each traction: real numbers S, where the
        amplitude of exp(i (q_x x + q_y y)) is S for a component that is even in both directions,
        -i S if it is odd in one and -S if it is odd in both.

    Notes
    -----
    Along the wave vector (1), across it (2) and into the body (3), a wave of pressure has::

        σ_11 = (qz - 1) e^(-qz)    σ_22 = -2ν e^(-qz)    σ_33 = -(1 + qz) e^(-qz)
        σ_13 = i qz e^(-qz)

    (the potential V is e^(-qz)/q), a wave of traction along it::

        σ_11 = i (2 - qz) e^(-qz)   σ_22 = 2iν e^(-qz)   σ_33 = i qz e^(-qz)
        σ_13 = (qz - 1) e^(-qz)

    and across it σ_23 = -e^(-qz), σ_12 = i e^(-qz). A uniform pressure acts on a body that cannot
    expand sideways: σ_xx = σ_yy = -ν/(1-ν), σ_zz = -1.

    References
    ----------
    Johnson, Contact Mechanics (1985), sec. 13.2, doi:10.1017/CBO9781139171731
    """
    q = np.hypot(qy, qx)
    inverse = np.divide(1, q, out=np.zeros(q.shape), where=q > 0)
    # Direction cosines of the wave vector.
    c, s = qx * inverse, qy * inverse
    qz = q * z
    damping = np.exp(-qz)
    result = [
        c * c * (qz - 1) - 2 * poisson * s * s,
        s * s * (qz - 1) - 2 * poisson * c * c,
        -(1 + qz),
        -s * qz,
        -c * qz,
        -c * s * (qz - 1 + 2 * poisson),
    ]
    for number in (XX, YY):
        result[number][q == 0] = -poisson / (1 - poisson)
    for axis, share in pulls:
        result += [share * part for part in _amplitudes(axis, c, s, qz, poisson)]
    for part in result:
        part *= damping
    return result


def _amplitudes(axis: str, c: Array, s: Array, qz: Array, poisson: float) -> tuple[Array, ...]:
    """Return the amplitudes of `waves` for a unit traction along an axis, without damping."""
    # Direction cosines along the traction and across it.
    m, n = (c, s) if axis == "x" else (s, c)
    along = -m * (2 + 2 * poisson * n * n - m * m * qz)
    across = -m * (2 * poisson * m * m - n * n * qz)
    near, far = m * m * qz - 1, -m * n * qz
    in_plane = -n * (1 - 2 * poisson * m * m - m * m * qz)
    if axis == "x":
        return along, across, -m * qz, far, near, in_plane
    return across, along, -m * qz, near, far, in_plane


def require_poisson(poisson: float) -> None:
    """Raise `InputError` unless Poisson's ratio is in the range of stable isotropic bodies."""
    if not -1 < poisson <= 0.5:
        raise input_error("poisson", poisson, "must be in (-1, 0.5]")
