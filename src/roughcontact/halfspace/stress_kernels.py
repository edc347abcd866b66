"""Stress in an elastic half-space under elementary loads on its surface, in closed form.

The body fills z > 0 and tension is positive. Tensors hold xx, yy, zz, yz, xz, xy, in this order.
A pressure pushes into the body, σ_zz = -p at the surface; a traction q pulls on it along x or y,
σ_xz = -q_x and σ_yz = -q_y.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from roughcontact.errors import InputError, require_pixel
from roughcontact.halfspace.tensors import XX, XY, XZ, YY, YZ, ZZ

Array = NDArray[np.float64]


def coefficients(
    shape: tuple[int, int],
    pixel: tuple[float, float],
    depth: float,
    poisson: float,
    direction: str = "z",
) -> Array:
    """Return the stress at one depth under a unit traction on the pixel ``[0, 0]``.

    Parameters
    ----------
    shape : (int, int)
        Offsets ``(ny, nx)`` wanted, from 0 on.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    depth : float
        z ≥ 0 [m].
    poisson : float
        Poisson's ratio ν of the body.
    direction : {"z", "x", "y"}
        Of the traction on the body: "z" is a pressure.

    Returns
    -------
    ndarray, shape (6, ny, nx)
        Stress over traction at the pixel centres [1]. Under a pressure yz is odd in y, xz odd in
        x, xy odd in both, the others are even; a traction along x or y flips this in that
        direction.

    Raises
    ------
    InputError
        If an argument is outside its range.

    Notes
    -----
    Closed forms: those of `uniform_pressure` and of `uniform_traction`.

    Every derivative is a signed sum over the corners of an elementary function. The functions
    here are odd in each corner coordinate as far as the sum can tell, and free of 0/0 and of
    cancelling logarithms at the surface. The limits at z = 0 are exact: σ_zz = -1 on the loaded
    pixel and 0 elsewhere. Errors are about 1e-15 of the unit traction.

    References
    ----------
    Love, Phil. Trans. R. Soc. A 228 (1929) 377, doi:10.1098/rsta.1929.0009;
    Johnson, Contact Mechanics (1985), secs. 3.2, 3.6, doi:10.1017/CBO9781139171731;
    Liu and Wang, J. Tribol. 124 (2002) 36, doi:10.1115/1.1401017

    Examples
    --------
    >>> coefficients((1, 1), (1.0, 1.0), depth=0.0, poisson=0.3)[:3, 0, 0].round(12)
    array([-0.8, -0.8, -1. ])
    """
    require_pixel(pixel)
    require_poisson(poisson)
    _require_load(depth, direction)
    y = (np.arange(shape[0] + 1, dtype=np.float64) - 0.5) * pixel[0]
    x = (np.arange(shape[1] + 1, dtype=np.float64) - 0.5) * pixel[1]
    if direction == "z":
        kernels = uniform_pressure(x, y, depth, poisson)
    else:
        kernels = uniform_traction(x, y, depth, poisson, direction)
    return np.stack([kernel.T for kernel in kernels])


def uniform_pressure(x_edges: Array, y_edges: Array, z: float, poisson: float) -> Iterator[Array]:
    """Yield the components of the stress under a unit pressure on the pixel at the origin.

    Parameters
    ----------
    x_edges, y_edges : ndarray, shape (nx + 1,) and (ny + 1,)
        Edges of consecutive pixels [m], relative to the centre of the loaded one.
    z : float
        Depth [m].
    poisson : float
        Poisson's ratio ν.

    Yields
    ------
    ndarray, shape (nx, ny)
        xx, yy, zz, yz, xz, xy, one after the other; see `coefficients`.

    Notes
    -----
    With V = ∫∫ 1/ρ over the loaded rectangle and χ = ∫∫ ln(ρ + z) (Love 1929, sec. 4)::

        2π σ_xx = 2ν V_z - z V_xx - (1-2ν) χ_xx       2π σ_zz = V_z - z V_zz
        2π σ_xy = -(1-2ν) χ_xy - z V_xy               2π σ_xz = -z V_xz
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


def uniform_traction(
    x_edges: Array, y_edges: Array, z: float, poisson: float, axis: str
) -> Iterator[Array]:
    """Yield the components of the stress under a unit traction on the pixel at the origin.

    Parameters
    ----------
    x_edges, y_edges, z, poisson
        As for `uniform_pressure`.
    axis : {"x", "y"}
        Direction of the traction on the body.

    Yields
    ------
    ndarray, shape (nx, ny)
        xx, yy, zz, yz, xz, xy, one after the other; see `coefficients`.

    Notes
    -----
    With V and χ as in `uniform_pressure`, and Ω = ∫∫ (z ln(ρ + z) - ρ), a traction along x gives
    (Cerruti; Johnson 1985, eq. 3.76, integrated)::

        2π σ_xx = 2 V_x - 2ν Ω_xyy - z χ_xxx          2π σ_zz = -z V_xz
        2π σ_yy = 2ν V_x + 2ν Ω_xyy - z χ_xyy         2π σ_xz = V_z - z V_xx
        2π σ_xy = V_y + 2ν Ω_xxy - z χ_xxy            2π σ_yz = -z V_xy
    """
    if axis == "y":
        swapped = [part.T for part in uniform_traction(y_edges, x_edges, z, poisson, "x")]
        yield from (swapped[number] for number in (YY, XX, ZZ, XZ, YZ, XY))
        return
    x, y = x_edges[:, None], y_edges
    a, b = x * x + z * z, y * y + z * z
    xy = x * y
    radius = np.sqrt(x * x + b)
    # 2ν/(R+z) + z/(R (R+z)), the part that Ω and χ have in common.
    common = (2 * poisson + z / radius) / (radius + z)
    along = np.arcsinh(y / np.sqrt(a))
    v_xz = y / radius * (z * z / a)
    # -V_z by the two angles of `uniform_pressure`, which have a limit at the surface.
    v_z = -np.arctan(xy / (a + z * radius)) - np.arctan(xy / (b + z * radius))
    for corners in (
        2 * along + y * common - v_xz,
        2 * poisson * along - y * common,
        v_xz,
        -z / radius,
        v_z + xy / radius * (z / a),
        np.arcsinh(x / np.sqrt(b)) - x * common,
    ):
        yield _over_pixels(corners)


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


def tangential_force(x: Array, y: Array, z: float, poisson: float, axis: str) -> Iterator[Array]:
    """Yield the components of the stress under a unit tangential force at the origin.

    Parameters
    ----------
    x, y, z, poisson
        As for `normal_force`.
    axis : {"x", "y"}
        Direction of the force on the body.

    Yields
    ------
    ndarray, shape (nx, ny)
        xx, yy, zz, yz, xz, xy, one after the other [1/m²].

    References
    ----------
    Cerruti 1882; Johnson, Contact Mechanics (1985), eq. 3.76, doi:10.1017/CBO9781139171731
    """
    if axis == "y":
        swapped = [part.T for part in tangential_force(y, x, z, poisson, "x")]
        yield from (swapped[number] for number in (YY, XX, ZZ, XZ, YZ, XY))
        return
    x, k = x[:, None], 1 - 2 * poisson
    x2, y2 = x * x, y * y
    rho2 = x2 + y2 + z * z
    rho = np.sqrt(rho2)
    factor = 1 / (2 * math.pi * rho2 * rho)
    # In units of 1/ρ³: ρ²/(ρ+z)² and 1/(ρ+z)² + 2ρ/(ρ+z)³.
    outer = rho / (rho + z)
    first = k * outer * outer
    second = first * (1 + 2 * outer) / rho2
    both = second - 3 / rho2
    yield x * (k - 3 * first + x2 * both) * factor
    yield x * (k - first + y2 * both) * factor
    yield x * (-3 * z * z / rho2) * factor
    yield x * (-3 * z * y / rho2) * factor
    yield x2 * (-3 * z / rho2) * factor
    yield y * (x2 * both - first) * factor


def waves(
    qy: Array, qx: Array, z: float, poisson: float, pulls: Sequence[tuple[str, float]]
) -> list[Array]:
    """Return the components of the stress of waves of unit pressure, then of tractions.

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
        xx, yy, zz, yz, xz, xy for the pressure and for each traction: real amplitudes S, where
        that of exp(i (q_x x + q_y y)) is S if a component is even in both directions, -i S if it
        is odd in one and -S if it is odd in both.

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
    found = [
        c * c * (qz - 1) - 2 * poisson * s * s,
        s * s * (qz - 1) - 2 * poisson * c * c,
        -(1 + qz),
        -s * qz,
        -c * qz,
        -c * s * (qz - 1 + 2 * poisson),
    ]
    for number in (XX, YY):
        found[number][q == 0] = -poisson / (1 - poisson)
    for axis, share in pulls:
        found += [share * part for part in _pulled(axis, c, s, qz, poisson)]
    for part in found:
        part *= damping
    return found


def _pulled(axis: str, c: Array, s: Array, qz: Array, poisson: float) -> tuple[Array, ...]:
    """Return the amplitudes of `waves` for a unit traction along an axis, not damped yet."""
    # Direction cosines along the traction and across it.
    m, n = (c, s) if axis == "x" else (s, c)
    along = -m * (2 + 2 * poisson * n * n - m * m * qz)
    across = -m * (2 * poisson * m * m - n * n * qz)
    near, far = m * m * qz - 1, -m * n * qz
    in_plane = -n * (1 - 2 * poisson * m * m - m * m * qz)
    if axis == "x":
        return along, across, -m * qz, far, near, in_plane
    return across, along, -m * qz, near, far, in_plane


def _require_load(depth: float, direction: str) -> None:
    if not 0 <= depth < math.inf:
        raise InputError(
            f"must be finite and ≥ 0 [m], got {depth!r}", argument="depth", value=depth
        )
    if direction not in ("x", "y", "z"):
        raise InputError(
            f"must be 'z', 'x' or 'y', got {direction!r}", argument="direction", value=direction
        )


def require_poisson(poisson: float) -> None:
    """Raise `InputError` unless Poisson's ratio is that of a stable isotropic body."""
    if not -1 < poisson <= 0.5:
        raise InputError(
            f"must lie in (-1, 0.5], got {poisson!r}", argument="poisson", value=poisson
        )
