"""Closed forms against the textbook's point solutions, integrated numerically."""

import math

import numpy as np
import pytest

from pixel_stress import pixel_stress
from roughcontact.halfspace import stress_kernels
from roughcontact.halfspace.tensors import XX, XY, XZ, YY, YZ, ZZ

PIXEL = (0.8, 1.3)
POISSON = [-0.5, 0.0, 0.3, 0.5]
NODES, WEIGHTS = np.polynomial.legendre.leggauss(40)


def boussinesq(x, y, z, nu):
    """Johnson (1985), eq. (3.19), in the axes of that page; not along the axis itself."""
    rho, r2, k = np.sqrt(x * x + y * y + z * z), x * x + y * y, 1 - 2 * nu
    xx = (k / r2) * ((1 - z / rho) * (x * x - y * y) / r2 + z * y * y / rho**3)
    yy = (k / r2) * ((1 - z / rho) * (y * y - x * x) / r2 + z * x * x / rho**3)
    xy = (k / r2) * ((1 - z / rho) * 2 * x * y / r2 - x * y * z / rho**3)
    far = 3 * z / rho**5
    parts = (
        xx - far * x * x,
        yy - far * y * y,
        -far * z * z,
        -far * y * z,
        -far * x * z,
        xy - far * x * y,
    )
    return np.array(parts) / (2 * math.pi)


def cerruti(x, y, z, nu):
    """Johnson (1985), eq. (3.76)."""
    rho, k = np.sqrt(x * x + y * y + z * z), 1 - 2 * nu
    s = rho + z
    xx = x / rho**3 - 3 * x / (rho * s**2) + x**3 / (rho**3 * s**2) + 2 * x**3 / (rho**2 * s**3)
    yy = x / rho**3 - x / (rho * s**2) + x * y * y / (rho**3 * s**2)
    yy = yy + 2 * x * y * y / (rho**2 * s**3)
    xy = -y / (rho * s**2) + x * x * y / (rho**3 * s**2) + 2 * x * x * y / (rho**2 * s**3)
    far = 3 * x / rho**5
    parts = (
        k * xx - far * x * x,
        k * yy - far * y * y,
        -far * z * z,
        -far * y * z,
        -far * x * z,
        k * xy - far * x * y,
    )
    return np.array(parts) / (2 * math.pi)


def cerruti_y(x, y, z, nu):
    return cerruti(y, x, z, nu)[[YY, XX, ZZ, XZ, YZ, XY]]


POINT = {"z": boussinesq, "x": cerruti, "y": cerruti_y}


@pytest.mark.parametrize("direction", "zxy")
@pytest.mark.parametrize("poisson", POISSON)
@pytest.mark.parametrize("depth", [0.4, 1.0, 7.0])
def test_rectangle_is_the_integral_of_points(direction, poisson, depth):
    (dy, dx), shape = PIXEL, (4, 5)
    found = pixel_stress(shape, PIXEL, depth, poisson, direction)
    for row, column in np.ndindex(shape):
        y = (row * dy + dy / 2 * NODES)[:, None]
        x = column * dx + dx / 2 * NODES
        weight = np.outer(WEIGHTS, WEIGHTS) * dy * dx / 4
        expected = (POINT[direction](x, y, depth, poisson) * weight).sum(axis=(1, 2))
        # Gauss' rule converges like (pixel/depth)^80 at these depths: rounding is left.
        np.testing.assert_allclose(found[:, row, column], expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("poisson", POISSON)
def test_points_are_those_of_the_textbook(poisson):
    rng = np.random.default_rng(0)
    x, y = 3 * rng.standard_normal((2, 6))
    for depth in (0.2, 1.0, 30.0):
        for direction, point in POINT.items():
            if direction == "z":
                parts = stress_kernels.normal_force(x, y, depth, poisson)
            else:
                parts = stress_kernels.force_parts(x, y, depth, poisson)
                parts = stress_kernels.sum_parts(parts, poisson, 0.0, [(direction, 1.0)])
            expected = point(x[:, None], y, depth, poisson)
            # (1 - z/ρ)/r² of the textbook cancels by (z/r)² far below.
            atol = 1e-15 * (1 + depth**2) * np.abs(expected).max()
            np.testing.assert_allclose(np.array(list(parts)), expected, rtol=1e-13, atol=atol)
    on_axis = np.array(list(stress_kernels.normal_force(np.zeros(1), np.zeros(1), 2.0, poisson)))
    # -3/(2π z²) below the force, (1-2ν)/(4π z²) across.
    assert on_axis[ZZ, 0, 0] == pytest.approx(-3 / (8 * math.pi))
    assert on_axis[XX, 0, 0] == pytest.approx((1 - 2 * poisson) / (16 * math.pi))


@pytest.mark.parametrize("direction", "zxy")
def test_surface_is_the_limit(direction):
    shape = (5, 6)
    surface = pixel_stress(shape, PIXEL, 0.0, 0.3, direction)
    assert np.isfinite(surface).all()
    for depth in (1e-6, 1e-9, 1e-12, 1e-200):
        near = pixel_stress(shape, PIXEL, depth, 0.3, direction)
        # The stress grows linearly with depth, by a few per pixel.
        np.testing.assert_allclose(near, surface, rtol=0, atol=10 * depth + 1e-14)
    # Only the loaded pixel carries the traction.
    carried = {"z": ZZ, "x": XZ, "y": YZ}[direction]
    for component in (ZZ, XZ, YZ):
        expected = np.zeros(shape)
        if component == carried:
            expected[0, 0] = -1
        np.testing.assert_allclose(surface[component], expected, rtol=0, atol=1e-15)


@pytest.mark.parametrize("axis", [None, "x", "y"])
def test_waves_are_in_equilibrium(axis):
    # Divergence of the stress of one wave, z by central differences.
    qx, qy, nu, step = 0.7, -1.1, 0.3, 1e-5
    pulls = [(axis, 1.0)] if axis else []
    odd = [(0, 0), (0, 0), (0, 0), (1, 0), (0, 1), (1, 1)]
    flip = {None: (0, 0), "x": (0, 1), "y": (1, 0)}[axis]

    def stress(z):
        parts = stress_kernels.waves(np.array([[qy]]), np.array([qx]), z, nu, pulls)[-6:]
        turns = [(-1j) ** ((a ^ flip[0]) + (b ^ flip[1])) for a, b in odd]
        return np.array([turn * part[0, 0] for turn, part in zip(turns, parts, strict=True)])

    for z in (0.3, 1.0, 4.0):
        xx, yy, _, yz, xz, xy = stress(z)
        slope = (stress(z + step) - stress(z - step)) / (2 * step)
        for balance in (
            1j * qx * xx + 1j * qy * xy + slope[XZ],
            1j * qx * xy + 1j * qy * yy + slope[YZ],
            1j * qx * xz + 1j * qy * yz + slope[ZZ],
        ):
            # Truncation of the difference, about step².
            assert abs(balance) < 1e-9
    surface = stress(0.0)
    expected = {None: (0, 0, -1), "x": (-1, 0, 0), "y": (0, -1, 0)}[axis]
    np.testing.assert_allclose(surface[[XZ, YZ, ZZ]], expected, atol=1e-15)
    # Compatibility: the sum of the normal stresses is harmonic, its waves decay as e^(-qz).
    sums = [stress(z)[:3].sum() for z in (0.5, 1.5)]
    if sums[0]:
        assert abs(sums[1] / sums[0]) == pytest.approx(math.exp(-math.hypot(qx, qy)))


def test_waves_of_a_uniform_load():
    origin = np.zeros((1, 1)), np.zeros(1)
    found = stress_kernels.waves(*origin, 3.0, 0.25, [("x", 0.5), ("y", 0.2)])
    np.testing.assert_allclose(np.ravel(found[:6]), [-1 / 3, -1 / 3, -1, 0, 0, 0])
    np.testing.assert_allclose(np.ravel(found[6:12]), [0, 0, 0, 0, -0.5, 0], atol=0)
    np.testing.assert_allclose(np.ravel(found[12:]), [0, 0, 0, -0.2, 0, 0], atol=0)
