"""Stress below contacts against closed forms of the textbooks."""

import math

import numpy as np
import pytest

from roughcontact.halfspace import stress, stress_summary
from roughcontact.halfspace.tensors import XX, XY, XZ, YY, YZ, ZZ

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
