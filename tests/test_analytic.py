import math
from itertools import pairwise

import numpy as np
import pytest
import scipy.fft
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.special import ellipkm1

from roughcontact.errors import InputError
from roughcontact.theory import indenters, persson, waves

AMPLITUDE, WAVELENGTH, MODULUS = 2e-7, 3e-5, 80e9
WAVY = waves.wavy_full_contact_pressure(AMPLITUDE, WAVELENGTH, MODULUS)
CROSSED = waves.crossed_full_contact_pressure(AMPLITUDE, WAVELENGTH, MODULUS)
A, SLOPE = 4e-6, 0.1

ratios = st.floats(1e-4, 1.5)


def periodic_symbol(shape):
    """2/(E*|q|) for one period λ per axis, and 0 at q = 0."""
    axes = [2 * math.pi / WAVELENGTH * n * scipy.fft.fftfreq(n) for n in shape]
    q = np.sqrt(sum(np.square(axis) for axis in np.meshgrid(*axes, indexing="ij")))
    return np.divide(2 / MODULUS, q, out=np.zeros_like(q), where=q > 0)


def response(pressure, symbol):
    return scipy.fft.ifftn(symbol * scipy.fft.fftn(pressure)).real


def brute_force(heights, mean_pressure, iterations=150):
    """Polonsky and Keer's conjugate gradients, good enough for a smooth wave."""
    symbol = periodic_symbol(heights.shape)
    pressure = np.full(heights.shape, mean_pressure)
    direction, old, restart = np.zeros_like(heights), 1.0, True
    for _ in range(iterations):
        touching = pressure > 0
        gap = response(pressure, symbol) - heights
        gap -= gap[touching].mean()
        new = np.sum(gap[touching] ** 2)
        direction = np.where(touching, gap + (0 if restart else new / old) * direction, 0)
        old = new
        change = response(direction, symbol)
        change -= change[touching].mean()
        step = np.sum(gap * direction) / np.sum(change * direction)
        pressure = np.where(touching, np.maximum(pressure - step * direction, 0), 0)
        overlap = (pressure == 0) & (gap < 0)
        pressure[overlap] -= step * gap[overlap]
        restart = bool(overlap.any())
        pressure *= mean_pressure / pressure.mean()
    return pressure


def ring_integral(r, pressure, a):
    """Displacement under axisymmetric pressure by summing Boussinesq's rings; s = a sin t."""

    def ring(t):
        s = a * math.sin(t)
        kernel = 4 / (math.pi * MODULUS) * s / (r + s) * ellipkm1(((r - s) / (r + s)) ** 2)
        return float(pressure(s)) * kernel * a * math.cos(t)

    # The kernel has a logarithmic pole at s = r, where the interval is split.
    ends = [0, math.asin(r / a), math.pi / 2] if r < a else [0, math.pi / 2]
    return sum(quad(ring, *pair, epsabs=0, limit=200)[0] for pair in pairwise(ends))


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


def test_wavy_pressure_matches_brute_force():
    # First-order errors at the edges of the strip: half a pixel there is 0.5 % of the peak.
    n, mean = 512, 0.3 * WAVY
    found = brute_force(AMPLITUDE * wave(n), mean)
    expected = waves.wavy_pressure(grid(n), mean, WAVY, WAVELENGTH)
    inner = expected > 0.2 * expected.max()
    np.testing.assert_allclose(found[inner], expected[inner], rtol=0, atol=5e-3 * WAVY)
    width = WAVELENGTH / n * np.count_nonzero(found)
    expected_width = 2 * waves.wavy_half_width(mean, WAVY, WAVELENGTH)
    assert width == pytest.approx(expected_width, abs=2 * WAVELENGTH / n)


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


@pytest.mark.parametrize(
    ("ratio", "asymptote"),
    [
        (0.005, waves.crossed_contact_fraction_light),
        (0.95, waves.crossed_contact_fraction_heavy),
    ],
)
def test_crossed_contact_fraction_matches_brute_force(ratio, asymptote):
    # What is small is compared: the area in contact, or the area out of it. The next order adds
    # 2 % and 0.6 % there (512²), counting pixels about 1 %; on both sides the difference was seen
    # to shrink with the distance from the limit.
    n = 256
    pressure = brute_force(AMPLITUDE * wave(n)[:, None] * wave(n), ratio * CROSSED)
    found, expected = np.count_nonzero(pressure) / n**2, asymptote(ratio * CROSSED, CROSSED)
    if ratio > 0.5:
        found, expected = 1 - found, 1 - expected
    assert found == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize("rho", [0.1, 0.6, 0.99, 1.01, 2.0, 20.0])
def test_punch_displacement_is_the_half_space_response(rho):
    delta = 1e-8
    load = indenters.punch_load(delta, A, MODULUS)
    expected = ring_integral(rho * A, lambda r: indenters.punch_pressure(r, load, A), A)
    found = float(indenters.punch_displacement(rho * A, delta, A))
    assert found == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("rho", [0.1, 0.6, 0.99, 1.01, 2.0, 20.0])
def test_cone_displacement_is_the_half_space_response(rho):
    mean = indenters.cone_mean_pressure(SLOPE, MODULUS)
    expected = ring_integral(rho * A, lambda r: indenters.cone_pressure(r, A, mean), A)
    found = float(indenters.cone_displacement(rho * A, A, SLOPE))
    assert found == pytest.approx(expected, rel=1e-6)


def test_cone_touches_inside_and_never_overlaps():
    r = np.linspace(0, 5 * A, 1001)
    delta = indenters.cone_approach(A, SLOPE)
    gap = indenters.cone_displacement(r, A, SLOPE) + SLOPE * r - delta
    np.testing.assert_allclose(gap[r <= A], 0, atol=1e-15 * 10 * delta)
    assert (gap[r > A] > 0).all()


@pytest.mark.parametrize(
    "pressure",
    [
        lambda load, a: lambda r: indenters.punch_pressure(r, load, a),
        lambda load, a: lambda r: indenters.cone_pressure(r, a, load / (math.pi * a**2)),
    ],
)
def test_pressure_carries_the_load(pressure):
    load = 3.0
    profile = pressure(load, A)

    def ring(t):  # r = a sin t
        return float(profile(A * math.sin(t))) * math.pi * A**2 * math.sin(2 * t)

    assert quad(ring, 0, math.pi / 2)[0] == pytest.approx(load, rel=1e-7)


@given(load=st.floats(1e-6, 1e3), slope=st.floats(1e-3, 1.0), modulus=st.floats(1e6, 1e12))
def test_cone_relations_agree(load, slope, modulus):
    a = indenters.cone_contact_radius(load, slope, modulus)
    delta = indenters.cone_approach(a, slope)
    assert indenters.cone_load(delta, slope, modulus) == pytest.approx(load, rel=1e-12)
    # dW/dδ = 2 E* a for every axisymmetric indenter; here W is quadratic in δ, so 2W/δ.
    assert 2 * load / delta == pytest.approx(2 * modulus * a, rel=1e-12)
    assert indenters.punch_load(delta, a, modulus) == pytest.approx(2 * load, rel=1e-12)


def test_singular_points_are_what_the_docstrings_say():
    assert indenters.punch_pressure([A, 2 * A], 1.0, A).tolist() == [0, 0]
    assert indenters.cone_pressure([0, A, 2 * A], A, 1.0).tolist() == [math.inf, 0, 0]


@pytest.mark.parametrize("bad", [0.0, -1.0, math.nan])
def test_bad_argument_is_named(bad):
    with pytest.raises(InputError, match=r"^mean_pressure must be positive"):
        waves.wavy_half_width(bad, 1.0, 1.0)
    with pytest.raises(InputError, match=r"^slope must be positive"):
        indenters.cone_mean_pressure(bad, 1.0)
    with pytest.raises(InputError, match=r"^wavelength must be positive"):
        waves.crossed_full_contact_pressure(1.0, bad, 1.0)


def diffused(mean: float, deviation: float, ceiling: float) -> tuple[float, float]:
    """Persson's diffusion by implicit finite differences: surviving and yielded shares."""
    n, steps = 800, 800
    p = np.linspace(0, ceiling, n + 1)
    # Started from the Green function of a free line at a tenth of a bound's distance.
    start = (0.15 * min(mean, ceiling - mean)) ** 2
    density = np.exp(-((p - mean) ** 2) / (2 * start)) / np.sqrt(2 * np.pi * start)
    step = (deviation**2 - start) / steps
    ratio = step / (2 * (ceiling / n) ** 2)
    lower = np.full(n - 1, -ratio / 2)
    bands = np.vstack([lower, np.full(n - 1, 1 + ratio), lower])
    inside, yielded = density[1:-1].copy(), 0.0
    for _ in range(steps):
        old = inside[-1]
        right = inside * (1 - ratio)
        right[1:] += ratio / 2 * inside[:-1]
        right[:-1] += ratio / 2 * inside[1:]
        inside = scipy.linalg.solve_banded((1, 1), bands, right)
        yielded += step / 2 * (old + inside[-1]) / 2 / (ceiling / n)
    return float(inside.sum() * ceiling / n), yielded


@pytest.mark.parametrize("mean", [0.5, 1.5, 2.6])
def test_persson_with_a_ceiling_is_the_diffusion_between_two_absorbers(mean: float) -> None:
    survived, yielded = diffused(mean, 1.1, 3.0)
    contact, saturated = persson.persson_fractions(mean, 2.2, 1.0, 3.0)
    # The finite differences are of second order in 1/800.
    assert saturated == pytest.approx(yielded, abs=2e-4)
    assert contact == pytest.approx(survived + yielded, abs=2e-4)


def test_persson_far_below_the_ceiling_is_elastic() -> None:
    elastic, none = persson.persson_fractions(2e6, 1e9, 0.02)
    contact, saturated = persson.persson_fractions(2e6, 1e9, 0.02, ceiling=1e9)
    assert none == 0
    assert contact == pytest.approx(elastic, rel=1e-12)
    assert saturated == pytest.approx(0, abs=1e-12)


@given(st.floats(1e-6, 1), st.floats(0.01, 100))
def test_persson_fractions_are_ordered(share: float, roughness: float) -> None:
    contact, saturated = persson.persson_fractions(share, roughness, 1.0, 1.0)
    assert 0 <= saturated <= contact <= 1
    # What carries the load at no more than the ceiling cannot be smaller than this.
    assert contact >= share * (1 - 1e-9)


def test_persson_refuses_more_than_the_ceiling() -> None:
    with pytest.raises(InputError, match="mean_pressure = 2 Pa exceeds the ceiling of 1 Pa"):
        persson.persson_fractions(2.0, 1.0, 1.0, 1.0)
