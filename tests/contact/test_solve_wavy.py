"""Periodic maps against Westergaard's strips and Johnson's crossed waves."""

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.surface import shapes
from roughcontact.theory import waves

STEEL = rc.Material(young=210e9, poisson=0.3)
MODULUS = 210e9 / 0.91
WAVELENGTH = 50e-6
AMPLITUDE = 0.2e-6
FULL = waves.wavy_full_contact_pressure(AMPLITUDE, WAVELENGTH, MODULUS)
CROSSED = waves.crossed_full_contact_pressure(AMPLITUDE, WAVELENGTH, MODULUS)


def strips(nx=512, ny=6, waves=1, along="x"):
    pixel = (2e-6, waves * WAVELENGTH / nx)
    heights = shapes.wavy((ny, nx), pixel, AMPLITUDE, WAVELENGTH)
    if along == "y":
        return rc.Surface(np.ascontiguousarray(heights.T), pixel[::-1])
    return rc.Surface(heights, pixel)


def area(surface):
    return surface.size[0] * surface.size[1]


@pytest.mark.parametrize("along", ["x", "y"])
@pytest.mark.parametrize("ratio", [0.02, 0.2, 0.5, 0.8, 0.98])
def test_westergaard(independent, ratio, along):
    surface = strips(along=along)
    mean = ratio * FULL
    result = rc.solve(surface, material=STEEL, load=mean * area(surface), boundary="periodic")
    independent.assert_solved(result)
    pressure, gap = result.pressure, result.gap
    if along == "y":
        pressure, gap = pressure.T, gap.T
    assert np.ptp(pressure, axis=0).max() < 1e-3 * pressure.max()
    nx = pressure.shape[1]
    x = np.arange(nx) * WAVELENGTH / nx
    half_width = waves.wavy_half_width(mean, FULL, WAVELENGTH)
    # Either edge of the strip is known to a pixel.
    assert abs(result.contact_fraction - 2 * half_width / WAVELENGTH) <= 2 / nx
    expected = waves.wavy_pressure(x, mean, FULL, WAVELENGTH)
    error = np.linalg.norm(pressure[0] - expected) / np.linalg.norm(expected)
    # At the edges p falls like a root, so half a pixel there costs (h/a)^1 of the norm: at the
    # lightest load the strip is 46 pixels wide.
    assert error < 0.02
    assert result.max_pressure == pytest.approx(expected.max(), rel=5e-3)
    gaps = waves.wavy_gap(x, mean, FULL, WAVELENGTH, AMPLITUDE)
    np.testing.assert_allclose(gap[0], gaps, rtol=0, atol=2e-3 * AMPLITUDE)
    # Both mean planes: the approach and the mean gap add up to the mean of the initial gap.
    mean_gap = waves.wavy_mean_gap(mean, FULL, AMPLITUDE)
    assert result.approach == pytest.approx(AMPLITUDE - mean_gap, abs=2e-3 * AMPLITUDE)


@pytest.mark.parametrize("ratio", [1.001, 1.5, 30.0])
def test_full_contact(independent, ratio):
    surface = strips(nx=128, waves=2)
    mean = ratio * FULL
    result = rc.solve(surface, material=STEEL, load=mean * area(surface), boundary="periodic")
    independent.assert_solved(result)
    assert result.contact_fraction == 1
    x = np.arange(128) * 2 * WAVELENGTH / 128
    expected = waves.wavy_pressure(x, mean, FULL, WAVELENGTH)
    # The periodic kernel is exact for the one wave there is: only the certificate is left.
    np.testing.assert_allclose(
        result.pressure, np.tile(expected, (6, 1)), rtol=0, atol=1e-4 * FULL * ratio
    )


def test_mean_pressure_never_exceeds_a_ceiling_below_full_contact():
    surface = strips(nx=128)
    ceiling = 0.5 * FULL
    result = rc.solve(
        surface,
        material=STEEL,
        load=0.4 * FULL * area(surface),
        boundary="periodic",
        ceiling=ceiling,
    )
    elastic = waves.wavy_half_width(0.4 * FULL, FULL, WAVELENGTH) * 2 / WAVELENGTH
    # By equilibrium the strip is at least 0.4/0.5 of the wave.
    assert result.contact_fraction >= 0.8
    assert result.contact_fraction > elastic
    assert result.max_pressure == ceiling


def crossed(n):
    pixel = (WAVELENGTH / n, WAVELENGTH / n)
    heights = shapes.crossed_waves((n, n), pixel, AMPLITUDE, WAVELENGTH)
    return rc.Surface(heights, pixel)


def press_crossed(n, ratio):
    surface = crossed(n)
    load = ratio * CROSSED * area(surface)
    return rc.solve(surface, material=STEEL, load=load, boundary="periodic")


@pytest.mark.parametrize(
    ("points", "ratio", "asymptote", "tolerance"),
    [
        # Two spots of 26 pixels radius: 1.2 % more than the asymptote here, 5 % on half the grid.
        (512, 0.003, waves.crossed_contact_fraction_light, 0.02),
        # Two holes of about 12 pixels radius: their area to some per cent.
        (256, 0.97, lambda *p: 1 - waves.crossed_contact_fraction_heavy(*p), 0.05),
    ],
    ids=["light load", "near full contact"],
)
def test_crossed_waves_meet_their_asymptotes(points, ratio, asymptote, tolerance):
    found = press_crossed(points, ratio).contact_fraction
    expected = asymptote(ratio * CROSSED, CROSSED)
    assert (found if ratio < 0.5 else 1 - found) == pytest.approx(expected, rel=tolerance)


def test_crossed_waves_close_at_the_closing_pressure():
    assert press_crossed(64, 1.001).contact_fraction == 1
    assert press_crossed(64, 0.98).contact_fraction < 1
    # In between the area is between the two asymptotes, and grows with the load.
    ratios = (0.1, 0.3, 0.5, 0.7, 0.9)
    fractions = [press_crossed(64, ratio).contact_fraction for ratio in ratios]
    assert (np.diff(fractions) > 0).all()
    for ratio, found in zip(ratios[1:-1], fractions[1:-1], strict=True):
        light = waves.crossed_contact_fraction_light(ratio * CROSSED, CROSSED)
        heavy = waves.crossed_contact_fraction_heavy(ratio * CROSSED, CROSSED)
        assert light < found < heavy
