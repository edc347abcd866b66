"""Tangential influence coefficients and their operator, against quadrature and plain sums."""

from __future__ import annotations

import numpy as np
import pytest

from roughcontact.errors import InputError
from roughcontact.halfspace import kernels, tangential
from roughcontact.halfspace.boundary import Boundary

PIXEL, MODULUS, POISSON = (1.0, 0.7), 2.0, 0.3
KAPPA = POISSON / (1 - POISSON)


def quadrature(row: int, column: int) -> list[float]:
    """Integrate the point force of Cerruti over a pixel that does not hold the origin."""
    nodes, weights = np.polynomial.legendre.leggauss(60)
    y = row * PIXEL[0] + nodes[:, None] * PIXEL[0] / 2
    x = column * PIXEL[1] + nodes * PIXEL[1] / 2
    weight = weights[:, None] * weights * PIXEL[0] * PIXEL[1] / 4 / (np.pi * MODULUS)
    r = np.hypot(x, y)
    densities = 1 / r + KAPPA * y**2 / r**3, 1 / r + KAPPA * x**2 / r**3, KAPPA * x * y / r**3
    return [float((weight * density).sum()) for density in densities]


@pytest.mark.parametrize("place", [(0, 3), (4, 0), (3, 5), (8, 8), (90, 70)])
def test_coefficients_are_the_integrals_of_the_point_force(place: tuple[int, int]) -> None:
    row, column = place
    table = kernels.cerruti((1, column + 1), PIXEL, MODULUS, POISSON, first_row=row)
    assert table[:, 0, column] == pytest.approx(quadrature(row, column), rel=1e-12, abs=1e-15)


def test_without_poisson_ratio_the_coefficients_are_those_of_pressure() -> None:
    along_y, along_x, mixed = kernels.cerruti((100, 100), PIXEL, MODULUS, 0.0)
    normal = kernels.love((100, 100), PIXEL, MODULUS)
    np.testing.assert_allclose(along_y, normal, rtol=1e-12)
    np.testing.assert_allclose(along_x, normal, rtol=1e-12)
    assert not mixed.any()


def test_a_wave_is_displaced_along_and_across_by_its_own_moduli() -> None:
    shape = 12, 16
    symbol = kernels.periodic_tangential(shape, PIXEL, MODULUS, POISSON)
    q = 2 * np.pi * 3 / (shape[1] * PIXEL[1])
    along, across = 2 / (MODULUS * q), 2 / (MODULUS * q * (1 - POISSON))
    assert symbol[:, 0, 3] == pytest.approx([across, along, 0], rel=1e-12)
    q = np.array([2 / (shape[0] * PIXEL[0]), 3 / (shape[1] * PIXEL[1])]) * 2 * np.pi
    yy, xx, xy = symbol[:, 2, 3]
    stiffness, directions = np.linalg.eigh([[yy, xy], [xy, xx]])
    size = np.linalg.norm(q)
    softer = 2 / (MODULUS * size * (1 - POISSON))
    assert stiffness == pytest.approx([2 / (MODULUS * size), softer], rel=1e-12)
    assert abs(directions[:, 0] @ q) == pytest.approx(size, rel=1e-12)


def plain(boundary: str, traction: np.ndarray) -> np.ndarray:
    """Return the displacement under a traction by sums over all pixels, or over full spectra."""
    shape = traction.shape[1:]
    if boundary == "free":
        yy, xx, xy = kernels.cerruti(shape, PIXEL, MODULUS, POISSON)
        displacement = np.zeros_like(traction)
        for row, column in np.ndindex(shape):
            dy, dx = np.arange(shape[0])[:, None] - row, np.arange(shape[1]) - column
            at, sign = (abs(dy), abs(dx)), np.sign(dy) * np.sign(dx)
            qy, qx = traction[:, row, column]
            displacement += [yy[at] * qy + sign * xy[at] * qx, sign * xy[at] * qy + xx[at] * qx]
        return displacement
    ky = np.fft.fftfreq(shape[0], PIXEL[0])[:, None] * 2 * np.pi
    kx = np.fft.fftfreq(shape[1], PIXEL[1]) * 2 * np.pi
    k = np.hypot(ky, kx)
    k[0, 0] = np.inf
    mixed = -KAPPA * kx * ky / k**2
    mixed[shape[0] // 2] = 0
    qy, qx = np.fft.fft2(traction)
    moved = [
        (1 + KAPPA * kx**2 / k**2) * qy + mixed * qx,
        mixed * qy + (1 + KAPPA * ky**2 / k**2) * qx,
    ]
    return np.fft.ifft2(2 / (MODULUS * k) * np.array(moved)).real


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_the_operator_sums_over_all_loaded_pixels(boundary: str) -> None:
    rng = np.random.default_rng(1)
    shape = 10, 13
    traction = rng.normal(size=(2, *shape)) * (rng.random(shape) < 0.6)
    operator = tangential.operator(Boundary(boundary), shape, PIXEL, MODULUS, POISSON)
    index = np.flatnonzero(traction[0])
    loaded = traction.reshape(2, -1)[:, index]
    displacement = operator.gather(operator.support(index), loaded)
    expected = plain(boundary, traction).reshape(2, -1)[:, index]
    np.testing.assert_allclose(displacement, expected, rtol=0, atol=1e-13 * abs(expected).max())


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_the_approximate_inverse_undoes_waves(boundary: str) -> None:
    shape = 32, 30
    operator = tangential.operator(Boundary(boundary), shape, PIXEL, MODULUS, POISSON)
    inverse = operator.approximate_inverse()
    traction = np.random.default_rng(2).normal(size=(2, shape[0] * shape[1]))
    traction -= traction.mean(axis=1)[:, None]
    index = np.arange(traction.shape[1])
    displacement = operator.gather(operator.support(index), traction)
    displacement /= operator.self_displacement
    again = inverse.gather(inverse.support(index), displacement)
    error = np.linalg.norm(again - traction) / np.linalg.norm(traction)
    assert error < (0.1 if boundary == "free" else 1e-5)


def test_a_profile_is_displaced_in_its_plane_as_by_pressure() -> None:
    boundary, shape = Boundary("periodic-y"), (1, 40)
    operator = tangential.operator(boundary, shape, PIXEL, MODULUS, POISSON)
    traction = np.zeros((2, 40))
    traction[1] = np.random.default_rng(3).random(40)
    displacement = operator.gather(operator.support(np.arange(40)), traction)
    normal = boundary.operator(shape, PIXEL, MODULUS)(traction[1:])
    np.testing.assert_allclose(displacement[1], normal[0], rtol=1e-12)
    assert not displacement[0].any()


def test_strip_raises_input_error() -> None:
    with pytest.raises(InputError, match="tangential loading"):
        tangential.operator(Boundary("periodic-x"), (8, 8), PIXEL, MODULUS, POISSON)
