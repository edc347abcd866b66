import math

import numpy as np
import pytest
import scipy.fft
from hypothesis import given, strategies as st

from roughcontact.errors import InputError
from roughcontact.theory import waves

AMPLITUDE, WAVELENGTH, MODULUS = 2e-7, 3e-5, 80e9
WAVY = waves.wavy_full_contact_pressure(AMPLITUDE, WAVELENGTH, MODULUS)
CROSSED = waves.crossed_full_contact_pressure(AMPLITUDE, WAVELENGTH, MODULUS)

ratios = st.floats(1e-4, 1.5)


def periodic_symbol(shape):
    """2/(E*|q|) for one period λ per axis, and 0 at q = 0."""
    axes = [2 * math.pi / WAVELENGTH * n * scipy.fft.fftfreq(n) for n in shape]
    q = np.sqrt(sum(np.square(axis) for axis in np.meshgrid(*axes, indexing="ij")))
    return np.divide(2 / MODULUS, q, out=np.zeros_like(q), where=q > 0)


def response(pressure, symbol):
    return scipy.fft.ifftn(symbol * scipy.fft.fftn(pressure)).real


def grid(n):
    return WAVELENGTH / n * np.arange(n)


def wave(n):
    return np.cos(2 * math.pi * np.arange(n) / n)


@pytest.mark.parametrize("ratio", [0.1, 0.5, 0.9, 1.0, 1.3])
def test_wavy_pressure_and_gap_solve_the_contact(ratio):
    # Pressure ≥ 0, gap ≥ 0, pressure·gap = 0 and the half-space law are the whole problem.
    # Sampling the root at the edge of a strip on N = 2^14 points errs by 10 N^(-3/2) = 5e-6.
    n = 2**14
    x, mean = grid(n), ratio * WAVY
    pressure = waves.wavy_pressure(x, mean, WAVY, WAVELENGTH)
    gap = waves.wavy_gap(x, mean, WAVY, WAVELENGTH, AMPLITUDE)
    a = waves.wavy_half_width(mean, WAVY, WAVELENGTH)
    distance = np.minimum(x, WAVELENGTH - x)
    assert (pressure[distance < 0.999 * a] > 0).all()
    assert (pressure[distance > 1.001 * a] == 0).all()
    assert (gap >= 0).all()
    assert (pressure * gap == 0).all()
    assert pressure.mean() == pytest.approx(mean, rel=1e-5)
    free = response(pressure, periodic_symbol((n,))) - AMPLITUDE * wave(n)
    np.testing.assert_allclose(gap - gap[0], free - free[0], rtol=0, atol=1e-5 * AMPLITUDE)


@given(ratio=ratios)
def test_wavy_mean_gap_is_the_mean_of_the_gap(ratio):
    n, mean = 4096, ratio * WAVY
    gap = waves.wavy_gap(grid(n), mean, WAVY, WAVELENGTH, AMPLITUDE)
    expected = waves.wavy_mean_gap(mean, WAVY, AMPLITUDE)
    # The kink (distance)^(3/2) at the edge leaves the midpoint sum an error of N^(-5/2).
    assert gap.mean() == pytest.approx(expected, abs=1e-7 * AMPLITUDE)


@pytest.mark.parametrize(
    ("heights", "closing"),
    [
        (AMPLITUDE * np.tile(wave(32), (32, 1)), WAVY),
        (AMPLITUDE * wave(32)[:, None] * wave(32), CROSSED),
    ],
)
def test_full_contact_pressure_flattens_the_wave(heights, closing):
    # In full contact the pressure p*(1 + heights/Δ) just vanishes in the troughs.
    pressure = closing * (1 + heights / AMPLITUDE)
    assert pressure.min() == pytest.approx(0, abs=1e-12 * closing)
    gap = response(pressure, periodic_symbol(heights.shape)) - heights
    np.testing.assert_allclose(gap, 0, atol=1e-12 * AMPLITUDE)


@pytest.mark.parametrize("bad", [0.0, -1.0, math.nan])
def test_bad_argument_is_named(bad):
    with pytest.raises(InputError, match=r"^mean_pressure must be positive"):
        waves.wavy_half_width(bad, 1.0, 1.0)
    with pytest.raises(InputError, match=r"^wavelength must be positive"):
        waves.crossed_full_contact_pressure(1.0, bad, 1.0)
