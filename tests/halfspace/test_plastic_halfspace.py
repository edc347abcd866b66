"""The volume operator against closed forms, quadrature, Mindlin's solution and its own laws."""

import itertools

import numpy as np
import pytest

from roughcontact.errors import InputError
from roughcontact.halfspace import layers, plastic_halfspace, tensors
from roughcontact.halfspace.fft import Workspace

MU, NU = 2.0, 0.3


def boussinesq(x, y, z, nu):
    """Return the stress, shape (..., 3, 3), of a unit force into the body (Johnson 1985, 3.19).

    From the potentials ln(ρ + z) and 1/ρ, written out with no help of the closed forms below.
    """
    rho = np.sqrt(x * x + y * y + z * z)
    r2 = x * x + y * y
    k = 1 - 2 * nu
    bracket = (1 - z / rho) / r2
    xx = k * (bracket * (x * x - y * y) / r2 + z * y * y / (rho**3 * r2)) - 3 * z * x * x / rho**5
    yy = k * (bracket * (y * y - x * x) / r2 + z * x * x / (rho**3 * r2)) - 3 * z * y * y / rho**5
    zz = -3 * z**3 / rho**5
    xy = k * (bracket * 2 * x * y / r2 - x * y * z / (rho**3 * r2)) - 3 * x * y * z / rho**5
    xz, yz = -3 * x * z * z / rho**5, -3 * y * z * z / rho**5
    rows = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    return np.array(rows).transpose(*range(2, 2 + np.ndim(rho)), 0, 1) / (2 * np.pi)


def under_rectangle(x, y, z, half_y, half_x, nu):
    """Return the stress of unit pressure on |x| ≤ half_x, |y| ≤ half_y (Love 1929)."""
    total = np.zeros((*np.broadcast(x, y, z).shape, 3, 3))
    for sx, sy in itertools.product((1, -1), repeat=2):
        X, Y = x + sx * half_x, y + sy * half_y
        R = np.sqrt(X * X + Y * Y + z * z)
        v_z = -np.arctan(X * Y / (z * R))
        v_xx, v_yy = X / (R * (R + Y)), Y / (R * (R + X))
        chi_xx = np.arctan(Y / X) - np.arctan(z * Y / (X * R))
        chi_yy = np.arctan(X / Y) - np.arctan(z * X / (Y * R))
        k = 1 - 2 * nu
        xx = 2 * nu * v_z - z * v_xx - k * chi_xx
        yy = 2 * nu * v_z - z * v_yy - k * chi_yy
        zz = v_z + z * (v_xx + v_yy)
        xy = -k * np.log(R + z) - z / R
        xz, yz = -z * z / (R * (R + Y)), -z * z / (R * (R + X))
        rows = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        total += sx * sy * np.moveaxis(rows, (0, 1), (-2, -1)) / (2 * np.pi)
    return total


def layers_of(operator, strain, pressure=None, trace=False):
    """Return displacement, stress deviator and mean stress of one operator."""
    shape = strain.shape[-2:]
    pressure = np.zeros(shape) if pressure is None else pressure

    def fill(layer, out):
        out[...] = strain[layer]
        return slice(0, shape[0]) if strain[layer].any() else None

    displacement = operator.displacement(fill, trace=trace)
    stress, mean = np.empty(strain.shape), np.empty((len(strain), *shape))
    operator.stress(pressure, lambda layer, values: stress.__setitem__(layer, values))
    if trace:
        operator.mean_stress(pressure, lambda layer, values: mean.__setitem__(layer, values))
    return displacement, stress, mean


def operator_of(shape, pixel, thickness, **more):
    arguments = dict(shear_modulus=MU, poisson=NU, workspace=Workspace(2)) | more
    return plastic_halfspace.PlasticHalfSpace(
        shape, pixel, np.asarray(thickness, float), **arguments
    )


CASES = [
    dict(boundary="periodic"),
    dict(boundary="free"),
    dict(boundary="free", poisson=0.5),
    dict(boundary="free", precision="single"),
]


@pytest.mark.parametrize("case", CASES, ids=str)
def test_betti_symmetry_and_bounds(case) -> None:
    shape, pixel, thickness = (10, 7), (0.7, 1.0), [0.5, 0.6, 0.9, 1.5, 2.0]
    operator = operator_of(shape, pixel, thickness, **case)
    rng = np.random.default_rng(3)
    first, second = rng.normal(size=(2, len(thickness), 5, *shape))
    pressure = rng.normal(size=shape)
    u, s_first, _ = layers_of(operator, first)
    _, s_second, _ = layers_of(operator, second)
    _, by_pressure, _ = layers_of(operator, np.zeros_like(first), pressure)
    weights = np.array(tensors.WEIGHTS)[:, None, None] * np.array(thickness)[:, None, None, None]
    scale = np.linalg.norm(first) * np.linalg.norm(second) * MU
    # Rounding of the arithmetic, over some 10³ terms.
    tolerance = 1e-5 if case.get("precision") == "single" else 1e-13
    one, other = np.sum(weights * s_first * second), np.sum(weights * s_second * first)
    assert abs(one - other) < tolerance * scale
    work, back = np.sum(weights * by_pressure * first), np.sum(u * pressure)
    assert abs(work - back) < tolerance * np.linalg.norm(first) * np.linalg.norm(pressure)
    energy = -np.sum(weights * s_first * first)
    assert 0 <= energy <= 2 * MU * np.sum(weights * first**2) * (1 + tolerance)
    # Linear: both at once are the sum of both.
    _, together, _ = layers_of(operator, first, pressure)
    np.testing.assert_allclose(
        together, s_first + by_pressure, atol=tolerance * np.abs(together).max() * 10
    )


def test_stress_by_pressure_against_love() -> None:
    # A Gaussian pressure 5 pixels wide, as pixels of constant pressure in the closed form; a
    # thin layer, so that its average is the value in the middle.
    shape, pixel, width = (48, 40), (0.2, 0.25), 1.0
    y = (np.arange(shape[0]) - 23.5) * pixel[0]
    x = (np.arange(shape[1]) - 19.5) * pixel[1]
    pressure = np.exp(-(y[:, None] ** 2 + x**2) / width**2)
    operator = operator_of(shape, pixel, [0.99, 0.02, 1.0])
    _, deviator, mean = layers_of(operator, np.zeros((3, 5, *shape)), pressure, trace=True)
    found = tensors.tensor(deviator.swapaxes(0, 1), mean)
    for row, column in ((23, 19), (30, 12), (40, 33)):
        exact = np.einsum(
            "yx,yxij->ij",
            pressure,
            under_rectangle(
                x[column] - x + 1e-12,
                y[row] - y[:, None] + 1e-12,
                1.0,
                pixel[0] / 2,
                pixel[1] / 2,
                NU,
            ),
        )
        # Pixels of constant pressure against a smooth one: the error is
        # p″ (dx² + dy²)/24 = 8e-3 at the surface, less below.
        np.testing.assert_allclose(found[1, row, column], exact, atol=4e-3)


@pytest.mark.parametrize("count", [(40, 36), (80, 72)], ids=str)
def test_displacement_by_smooth_strain(count) -> None:
    # A Gaussian, deep enough that the sum over pixels of Betti's integrand is exact to e^(-2πz/dx).
    extent = 9.6, 7.2
    pixel = extent[0] / count[0], extent[1] / count[1]
    y = (np.arange(count[0]) - (count[0] - 1) / 2) * pixel[0]
    x = (np.arange(count[1]) - (count[1] - 1) / 2) * pixel[1]
    bell = np.exp(-(y[:, None] ** 2 + x**2))
    matrix = np.array([[0.3, 0.5, -0.4], [0.5, 0.5, 0.7], [-0.4, 0.7, -0.8]])
    strain = np.zeros((3, 5, *count))
    strain[1] = tensors.components(matrix)[:, None, None] * bell
    found, _, _ = layers_of(operator_of(count, pixel, [1.5, 0.5, 1.0]), strain)
    node, weight = np.polynomial.legendre.leggauss(8)
    for row, column in ((count[0] // 2, count[1] // 3), (3, 5), (count[0] - 4, count[1] // 2)):
        exact = 0.0
        for z, w in zip(1.75 + 0.25 * node, 0.25 * weight, strict=True):
            kernel = boussinesq(x - x[column] + 1e-9, y[:, None] - y[row] + 1e-9, np.float64(z), NU)
            exact += w * pixel[0] * pixel[1] * np.einsum("yx,yxij,ij->", bell, kernel, matrix)
        # Rest of the image correction, see `test_far_images`.
        assert found[row, column] == pytest.approx(exact, abs=5e-4 * np.abs(found).max())


PLACES = {
    "wide": ((0, 0, 5), 5),
    "at the surface": ((0, 0, 0.5), 2),
    "at an edge": ((8, -9, 1), 2.5),
}


@pytest.mark.long
@pytest.mark.parametrize("place", PLACES.values(), ids=PLACES)
def test_distant_images_are_subtracted(place) -> None:
    # Strain and pressure, against the same on a period of sixteen maps.
    (row, column, level), width = place
    points = 32
    y, x = np.mgrid[:points, :points] - (points - 1) / 2
    flat = (y - row) ** 2 + (x - column) ** 2
    thickness = layers.graded_layers(0.5, 14.0)
    depth = np.cumsum(thickness) - thickness / 2
    blob = np.exp(-(flat + (depth[:, None, None] - level) ** 2) / width**2)
    five = np.array([0.4, -0.7, 0.3, 0.5, -0.2])
    strain = five[:, None, None] * blob[:, None]
    pressure = np.exp(-flat / width**2)
    shape = (points, points)
    whole = layers.PeriodicHalfSpace(
        shape,
        (1, 1),
        thickness,
        MU,
        NU,
        (16 * points, 16 * points),
        isolated=True,
        workspace=Workspace(2),
    )
    corrected = operator_of(shape, (1, 1), thickness)
    for some, load in ((strain, 0 * pressure), (0 * strain, pressure)):
        exact = layers_of(whole, some, load, trace=True)
        found = layers_of(corrected, some, load, trace=True)
        for one, other in zip(found, exact, strict=True):
            # 4 % without the correction. What is left is the far period and the interpolation.
            np.testing.assert_allclose(one, other, atol=4e-4 * max(np.abs(other).max(), 1e-30))


@pytest.mark.long
@pytest.mark.parametrize("points", [48, 60])
def test_no_strain_gives_energy_away(points) -> None:
    # Lanczos: extreme Rayleigh quotients of -S, with three points per coarse cell. Below zero,
    # plastic strain would grow by itself.
    shape = (points, points)
    thickness = layers.graded_layers(0.5, 25.0, 1.3)
    operator = operator_of(shape, (1, 1), thickness, shear_modulus=0.5)
    weights = np.array(tensors.WEIGHTS)[:, None, None] * thickness[:, None, None, None]
    v = np.random.default_rng(0).normal(size=(thickness.size, 5, *shape))
    known, matrix = [v / np.sqrt(np.sum(weights * v * v))], np.zeros((20, 20))
    for step in range(20):
        _, stress, _ = layers_of(operator, known[-1])
        v = -stress
        for number, other in enumerate(known):
            matrix[number, step] = share = np.sum(weights * v * other)
            v -= share * other
        known.append(v / np.sqrt(np.sum(weights * v * v)))
    values = np.linalg.eigvalsh(np.triu(matrix) + np.triu(matrix, 1).T)
    assert -1e-4 < values[0] < values[-1] < 1 + 1e-4


def test_strain_cut_off_at_the_edge_of_the_map() -> None:
    # It has waves up to Nyquist, which even periods must not treat otherwise than odd ones.
    y, x = np.mgrid[:20, :20]
    thickness = layers.graded_layers(0.5, 8.0)
    depth = np.cumsum(thickness) - thickness / 2
    blob = np.exp(-((x - 2) ** 2 + (y - 3) ** 2 + (depth[:, None, None] - 3) ** 2) / 3**2)
    five = np.array([0.4, -0.7, 0.3, 0.5, -0.2])
    strain = five[:, None, None] * blob[:, None]
    even, odd = (
        layers_of(
            layers.PeriodicHalfSpace(
                (20, 20),
                (1, 1),
                thickness,
                MU,
                NU,
                (period, period),
                isolated=True,
                workspace=Workspace(2),
            ),
            strain,
            blob[0],
            trace=True,
        )
        for period in (160, 161)
    )
    for one, other in zip(even, odd, strict=True):
        # The images move by 1/160, what they do by three times that; 0.3 % and 0.8 % of the
        # stress if the waves at Nyquist were left out.
        np.testing.assert_allclose(one, other, rtol=0, atol=5e-4 * np.abs(other).max())


def test_a_checkerboard_is_not_relieved() -> None:
    # It is as steep one way as the other at every point: nothing around gives way to it.
    shape, strain = (8, 12), np.zeros((3, 5, 8, 12))
    strain[1] = np.array([1.0, -0.4, 0.3, 0.7, -0.2])[:, None, None] * (
        1 - 2 * (np.indices(shape).sum(axis=0) % 2)
    )
    _, stress, _ = layers_of(operator_of(shape, (1, 1), [0.5] * 3, boundary="periodic"), strain)
    np.testing.assert_allclose(stress, -2 * MU * strain, rtol=0, atol=1e-12)


def test_threads_do_not_change_the_bits() -> None:
    strain = np.random.default_rng(0).normal(size=(4, 5, 12, 10))
    pressure = np.random.default_rng(1).normal(size=(12, 10))
    results = [
        layers_of(
            operator_of((12, 10), (1, 1), [0.5, 0.5, 1, 2], workspace=Workspace(workers)),
            strain,
            pressure,
            trace=True,
        )
        for workers in (1, 3)
    ]
    for one, other in zip(*results, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (dict(pixel=(1.0, 0.0)), "pixel must be positive"),
        (dict(thickness=[]), "thickness must be a row"),
        (dict(thickness=[1.0, -1.0]), "thickness must be a row"),
        (dict(thickness=3.0), "thickness must be a row"),
        (dict(shear_modulus=0.0), "shear_modulus must be positive"),
        (dict(boundary="open"), "boundary must be"),
    ],
)
def test_bad_arguments(change, message) -> None:
    arguments = dict(shape=(8, 8), pixel=(1.0, 1.0), thickness=[1.0]) | change
    with pytest.raises(InputError, match=message):
        operator_of(**arguments)


def test_layers_grow_with_depth() -> None:
    thickness = layers.graded_layers(0.5, 20.0, 1.1)
    np.testing.assert_allclose(thickness[1:] / thickness[:-1], 1.1)
    assert 20 <= thickness.sum() < 20 + thickness[-1]
