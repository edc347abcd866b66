"""Stress below contacts against closed forms of the textbooks."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from roughcontact.halfspace import stress, stress_summary
from roughcontact.halfspace.tensors import XX, XY, XZ, YY, YZ, ZZ, von_mises
from roughcontact.material.material import Material

NU = 0.3


def axes(shape, pixel=(1.0, 1.0)):
    """Pixel centres from the middle of the map."""
    y, x = ((np.arange(n) - (n - 1) / 2) * d for n, d in zip(shape, pixel, strict=True))
    return y[:, None], x


def hertz(points, radius):
    y, x = axes((points, points))
    return np.sqrt(np.maximum(1 - (y**2 + x**2) / radius**2, 0))


def volume(pressure, depths, poisson=NU, pixel=(1.0, 1.0), **options):
    return np.array([s.stress for s in stress.slices(pressure, pixel, depths, poisson, **options)])


@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.5])
def test_hertz_on_the_axis(poisson):
    a = 40
    zeta = np.array([0.0, 0.05, 0.2, 0.48, 0.8, 1.5, 3.0])
    found = volume(hertz(129, a), a * zeta, poisson)[:, :, 64, 64]
    # Johnson (1985), eqs. (3.45).
    with np.errstate(divide="ignore"):
        bracket = 1 - zeta * np.arctan(1 / zeta)
    radial = -(1 + poisson) * bracket + 0.5 / (1 + zeta**2)
    # Pixels at the rim are in or out as a whole: some 1e-3 of the peak at 40 pixels.
    np.testing.assert_allclose(found[:, XX], radial, rtol=0.005, atol=1e-4)
    np.testing.assert_allclose(found[:, YY], radial, rtol=0.005, atol=1e-4)
    np.testing.assert_allclose(found[:, ZZ], -1 / (1 + zeta**2), rtol=0.005)
    np.testing.assert_allclose(found[:, [YZ, XZ, XY]], 0, atol=1e-6)


def test_hertz_at_the_rim_and_outside():
    # Johnson (1985), eq. (3.42): outside, σ_r = -σ_θ = (1-2ν) p0 a²/(3r²) at the surface.
    a, n = 40, 201
    found = volume(hertz(n, a), [0.0])[0]
    middle = n // 2
    for distance in (45, 60, 90):
        expected = (1 - 2 * NU) * a**2 / (3 * distance**2)
        assert found[XX, middle, middle + distance] == pytest.approx(expected, rel=0.005)
        assert found[YY, middle, middle + distance] == pytest.approx(-expected, rel=0.005)
        assert found[XX, middle + distance, middle] == pytest.approx(-expected, rel=0.005)


def test_largest_equivalent_stress_under_a_sphere():
    a = 40
    found = stress_summary.summarize(hertz(129, a), (1.0, 1.0), NU)
    # Johnson (1985), sec. 4.2; on the axis Tresca and von Mises agree.
    assert found.max_von_mises == pytest.approx(0.620, rel=0.01)
    assert found.max_tresca == pytest.approx(0.620, rel=0.01)
    assert found.depth_of_max / a == pytest.approx(0.48, rel=0.01)
    assert found.pixel_of_max == (64, 64)
    # Harris, Rolling Bearing Analysis: τ_0 = 0.214 p0 at 0.35 a for a circular contact.
    amplitude = found.orthogonal_shear[:, 1]
    assert amplitude.max() == pytest.approx(0.214, rel=0.01)
    np.testing.assert_allclose(found.orthogonal_shear[:, 0], amplitude, rtol=1e-4)
    # The graded depths are a quarter apart.
    assert found.depths[amplitude.argmax()] / a == pytest.approx(0.35, rel=0.15)


@pytest.mark.parametrize("poisson", [0.2, 0.3, 0.4])
def test_yield_onset_of_a_sphere(poisson):
    found = stress_summary.summarize(hertz(129, 40), (1.0, 1.0), poisson, yield_strength=1.0)
    expected = Material(1.0, poisson, yield_strength=1.0).first_yield_pressure
    if poisson == 0.3:
        assert expected == pytest.approx(1.615, rel=1e-3)
    # The fit of Jackson and Green is itself good to 1 %.
    assert found.yield_factor == pytest.approx(expected, rel=0.01)


@pytest.mark.long
def test_yielded_volume_under_a_sphere():
    # Where the closed forms exceed two thirds of the maximum, by a sum over a fine (r, z) grid of
    # slices twice as fine: independent of the trapezoidal rule, not of the slices.
    a, strength = 20, 0.42
    depths = np.linspace(0, 2 * a, 81)
    fine = volume(hertz(2 * 64 + 1, 2 * a), 2 * depths)
    cells = (von_mises(fine.swapaxes(0, 1)) > strength).sum()
    expected = cells / 4 * (depths[1] - depths[0])
    found = stress_summary.summarize(hertz(65, a), (1.0, 1.0), NU, yield_strength=strength)
    # Graded depths: the trapezoidal rule of a bell-shaped curve with a dozen points.
    assert found.yielded_volume == pytest.approx(expected, rel=0.05)


def test_uniform_pressure_on_a_circle():
    a = 60.2
    y, x = axes((151, 151))
    pressure = (y**2 + x**2 < a**2).astype(float)
    # The circle of the same area as its pixels.
    a = math.sqrt(pressure.sum() / math.pi)
    z = a * np.array([0.0, 0.3, 1.0, 2.5])
    found = volume(pressure, z)[:, :, 75, 75]
    # Johnson (1985), eqs. (3.33).
    slant = z / np.hypot(a, z)
    radial = -0.5 * (1 + 2 * NU - 2 * (1 + NU) * slant + slant**3)
    np.testing.assert_allclose(found[:, ZZ], -(1 - slant**3), rtol=1e-3)
    np.testing.assert_allclose(found[:, XX], radial, rtol=2e-3, atol=1e-4)
    np.testing.assert_allclose(found[:, YY], radial, rtol=2e-3, atol=1e-4)


def test_uniform_pressure_on_a_rectangle():
    pixel = (0.5, 0.8)
    pressure = np.zeros((81, 61))
    pressure[20:61, 15:46] = 1
    width, length = 31 * pixel[1], 41 * pixel[0]
    z = np.array([1.0, 4.0, 12.0, 40.0])
    found = volume(pressure, z, pixel=pixel)[:, ZZ, 40, 30]
    # Newmark's chart for the corner of a rectangle, four times half the sides.
    m, n = width / 2 / z, length / 2 / z
    s = m**2 + n**2 + 1
    angle = np.arctan2(2 * m * n * np.sqrt(s), s - (m * n) ** 2)
    chart = (2 * m * n * np.sqrt(s) / (s + (m * n) ** 2) * (s + 1) / s + angle) / (4 * np.pi)
    np.testing.assert_allclose(found, -4 * chart, atol=1e-6)


def strip(shape, a):
    _, x = axes(shape)
    return np.tile(np.sqrt(np.maximum(1 - (x / a) ** 2, 0)), (shape[0], 1))


def test_line_contact():
    a, shape = 20, (1001, 121)
    zeta = np.array([0.05, 0.5, 0.786, 1.2])
    found = volume(strip(shape, a), a * zeta)[:, :, 500, 60]
    root = np.sqrt(1 + zeta**2)
    across, down = -((1 + 2 * zeta**2) / root - 2 * zeta), -1 / root
    # The ends that are missing would add -(1-2ν)/(2π) times the integral of the load over 1/y².
    missing = (1 - 2 * NU) * a / 1001
    # Johnson (1985), eqs. (4.46); the rim is a twentieth of the half-width uncertain.
    np.testing.assert_allclose(found[:, XX], across + missing, atol=2e-3)
    np.testing.assert_allclose(found[:, ZZ], down, atol=2e-3)
    # Along the strip the ends count to the next order as well, z a/l² or 2e-3.
    np.testing.assert_allclose(found[:, YY], NU * (across + down) - missing, atol=4e-3)
    summary = stress_summary.summarize(
        strip(shape, a), (1.0, 1.0), NU, depths=a * np.array([0.4, 0.5, 0.6])
    )
    # Lundberg and Palmgren: half the range of the orthogonal shear is p0/4, at a/2.
    assert summary.depths[summary.orthogonal_shear[:, 1].argmax()] == a / 2
    assert summary.max_orthogonal_shear[1] == pytest.approx(0.25, rel=0.005)


def test_sliding_line_contact():
    # Johnson (1985), sec. 7.1: σ_x = -2 q0 x/a in the contact on top of -p, and 2 q0 behind it.
    a, shape, mu = 40, (2001, 121), 0.25
    found = volume(strip(shape, a), [0.0], friction=mu)[0, :, 1000]
    _, x = axes(shape)
    inside = np.abs(x) < 0.9 * a
    pressure = np.sqrt(np.maximum(1 - (x / a) ** 2, 0))
    expected = -pressure - 2 * mu * x / a + (1 - 2 * NU) * a / 2001
    np.testing.assert_allclose(found[XX, inside], expected[inside], atol=4e-3)
    np.testing.assert_allclose(found[XZ], -mu * pressure, atol=1e-6)
    # The body is pulled along +x, so that it is stretched at -a.
    assert x[found[XX].argmax()] == pytest.approx(-a, abs=1.5)


def test_sliding_sphere_is_stretched_behind():
    # Hamilton (1983), doi:10.1243/PIME_PROC_1983_197_076_02: at the trailing edge
    # σ = p0 [(1-2ν)/3 + (4+ν) π μ/8] along the direction of sliding.
    mu = 0.3
    expected = (1 - 2 * NU) / 3 + (4 + NU) * math.pi * mu / 8
    for angle, component in ((0.0, XX), (0.5 * math.pi, YY)):
        peaks = []
        for a in (60.25, 120.25):
            n = 2 * int(1.15 * a) + 1
            found = volume(hertz(n, a), [0.0], friction=mu, direction=angle)[0, component]
            profile = found[n // 2] if component == XX else found[:, n // 2]
            assert profile.argmax() - n // 2 == pytest.approx(-a, abs=1)
            peaks.append(profile.max())
        # A cusp like the square root of the distance: the error is one of the pixel.
        limit = (math.sqrt(2) * peaks[1] - peaks[0]) / (math.sqrt(2) - 1)
        assert limit == pytest.approx(expected, rel=0.01)


def test_friction_brings_first_yield_to_the_surface():
    # Johnson (1985), sec. 7.1: below μ of about 0.3 a sphere yields first below the surface.
    pressure = hertz(97, 30)
    low = stress_summary.summarize(pressure, (1.0, 1.0), NU, friction=0.2)
    high = stress_summary.summarize(pressure, (1.0, 1.0), NU, friction=0.4)
    assert low.depth_of_max > 0.2 * 30
    assert high.depth_of_max < 1
    assert high.max_von_mises > low.max_von_mises > 0.62


@pytest.mark.long
def test_every_slice_carries_the_load():
    n, a, pixel, mu = 512, 16, (0.9, 1.1), 0.2
    pressure = hertz(n, a)
    load = pressure.sum()
    # Of a point load, (1 + (R/z)²)^(-3/2) passes outside a circle of radius R: 3e-4 here.
    for depth in (0.0, 0.3, 2.0, 9.0, 15.0):
        for direction, (x, y) in ((0.0, (1, 0)), (0.5 * math.pi, (0, 1))):
            found = volume(pressure, [depth], pixel=pixel, friction=mu, direction=direction)[0]
            assert found[ZZ].sum() == pytest.approx(-load, rel=1e-3)
            # The shear of the normal load cancels by symmetry; of a tangential force, no more
            # than 3z/(2R) passes outside.
            slack = mu * load * (1.5 * depth / 230 + 1e-4)
            assert found[XZ].sum() == pytest.approx(-mu * x * load, abs=slack)
            assert found[YZ].sum() == pytest.approx(-mu * y * load, abs=slack)


def test_every_periodic_slice_carries_the_load():
    pressure = np.random.default_rng(0).random((30, 41))
    for depth in (0.0, 1.0, 7.0, 100.0):
        found = volume(pressure, [depth], boundary="periodic", friction=0.3)[0]
        means = found.mean(axis=(1, 2), dtype=float) / pressure.mean()
        side = -NU / (1 - NU)
        # Single precision.
        np.testing.assert_allclose(means, [side, side, -1, 0, -0.3, 0], atol=1e-6)


def test_periodic_wave_in_closed_form():
    # Johnson (1985), sec. 13.2, on a long and narrow map.
    shape, pixel = (6, 32), (1.7, 0.5)
    _, x = axes(shape, pixel)
    q = 2 * math.pi * 3 / (32 * 0.5)
    pressure = np.tile(1 + np.cos(q * x), (6, 1))
    for z in (0.0, 0.4, 2.0):
        found = volume(pressure, [z], pixel=pixel, boundary="periodic")[0, :, 2]
        damping = math.exp(-q * z)
        across = -NU / (1 - NU) - (1 - q * z) * damping * np.cos(q * x)
        down = -1 - (1 + q * z) * damping * np.cos(q * x)
        np.testing.assert_allclose(found[XX], across, atol=2e-6)
        np.testing.assert_allclose(found[ZZ], down, atol=2e-6)
        np.testing.assert_allclose(found[YY], NU * (across + down), atol=2e-6)
        np.testing.assert_allclose(found[XZ], -q * z * damping * np.sin(q * x), atol=2e-6)


def test_distant_images_do_not_matter():
    # The same contact, free and as one period of side 20 a: stresses differ by about (a/L)².
    a, n = 8, 160
    pressure = hertz(n, a)
    depths = [0.0, 4.0, 12.0]
    free = volume(pressure, depths)
    periodic = volume(pressure, depths, boundary="periodic")
    near = slice(n // 2 - 10, n // 2 + 10)
    assert np.abs(free - periodic)[:, :, near, near].max() < 0.01


def test_error_falls_with_the_second_power_of_the_pixel():
    # A smooth pressure, exp(-r²/2); its stress on the axis is an integral over rings of
    # Boussinesq's (Johnson 1985, eq. 3.19).
    z = 2.0

    def ring(r, weight):
        return r * math.exp(-0.5 * r * r) * weight(r, math.hypot(r, z))

    down, _ = quad(ring, 0, 9, args=(lambda r, rho: -3 * z**3 / rho**5,))
    across, _ = quad(
        ring, 0, 9, args=(lambda r, rho: 0.5 * z * ((1 - 2 * NU) / rho**3 - 3 * r * r / rho**5),)
    )
    grids = np.array([27, 45, 81, 135])
    errors = []
    for points in grids:
        # An odd number of pixels: the middle one is on the axis.
        pixel = (12 / points, 12 / points)
        y, x = axes((points, points), pixel)
        pressure = np.exp(-0.5 * (y**2 + x**2))
        found = volume(pressure, [z], pixel=pixel, precision="double")[
            0, :, points // 2, points // 2
        ]
        errors.append([abs(found[XX] - across), abs(found[YY] - across), abs(found[ZZ] - down)])
    orders = -np.polyfit(np.log(grids), np.log(errors), 1)[0]
    # The finest grids see the end of the map at six standard deviations.
    np.testing.assert_allclose(orders, 2, atol=0.1)
