import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.integrate import quad
from scipy.special import ellipkm1

from roughcontact.errors import InputError
from roughcontact.material.material import Material
from roughcontact.theory import hertz

LOAD, RADIUS, MODULUS = 2.0, 3e-3, 80e9
A = hertz.contact_radius(LOAD, RADIUS, MODULUS)
P0 = hertz.max_pressure(LOAD, RADIUS, MODULUS)

loads = st.floats(1e-6, 1e6)
radii = st.floats(1e-6, 1e1)
moduli = st.floats(1e6, 1e12)


def ring_integral(r, pressure, a, modulus):
    """Displacement under axisymmetric pressure by summing Boussinesq's rings; s = a sin t."""

    def ring(t):
        s = a * math.sin(t)
        kernel = 4 / (math.pi * modulus) * s / (r + s) * ellipkm1(((r - s) / (r + s)) ** 2)
        return float(pressure(s)) * kernel * a * math.cos(t)

    # The kernel has a logarithmic pole at s = r, where the interval is split.
    ends = [0, math.asin(r / a), math.pi / 2] if 0 < r < a else [0, math.pi / 2]
    return sum(quad(ring, *pair, epsabs=0, limit=200)[0] for pair in pairwise(ends))


def test_pressure_carries_the_load():
    total, _ = quad(lambda r: 2 * math.pi * r * float(hertz.pressure(r, A, P0)), 0, A)
    assert total == pytest.approx(LOAD, rel=1e-7)  # quad's own estimate


@pytest.mark.parametrize("rho", [0.05, 0.5, 0.95, 1.0, 1.05, 2.0, 30.0])
def test_displacement_is_the_half_space_response(rho):
    expected = ring_integral(rho * A, lambda r: hertz.pressure(r, A, P0), A, MODULUS)
    found = float(hertz.displacement(rho * A, A, P0, MODULUS))
    assert found == pytest.approx(expected, rel=1e-7)


def test_bodies_touch_inside_and_never_overlap():
    # gap = displacement + shape - approach: the three closed forms must agree.
    r = np.linspace(0, 5 * A, 1001)
    delta = hertz.approach(LOAD, RADIUS, MODULUS)
    expected = hertz.displacement(r, A, P0, MODULUS) + r**2 / (2 * RADIUS) - delta
    gap = hertz.gap(r, A, RADIUS)
    # 1e-14: rounding of r²/(2R), which is 12 δ at the end.
    np.testing.assert_allclose(gap, expected, rtol=0, atol=1e-14 * 12 * delta)
    assert (gap[r < A] == 0).all()
    assert (np.diff(gap[r > A]) > 0).all()


def test_gap_keeps_its_digits_next_to_the_rim():
    # (8√2/(3π)) ε^(3/2) a²/R at r = a (1 + ε); the next term is of relative order ε.
    rho = np.array([1 + 1e-6, 1 + 1e-4])
    leading = 8 * math.sqrt(2) / (3 * math.pi) * (rho - 1) ** 1.5 * A**2 / RADIUS
    np.testing.assert_allclose(hertz.gap(rho * A, A, RADIUS), leading, rtol=1e-3)


def test_far_displacement_is_that_of_a_point_load():
    # The next term is (a/r)²/10 of the first.
    found = float(hertz.displacement(100 * A, A, P0, MODULUS))
    assert found == pytest.approx(LOAD / (math.pi * MODULUS * 100 * A), rel=2e-5)


@given(load=loads, radius=radii, modulus=moduli)
def test_load_and_approach_are_inverse(load, radius, modulus):
    delta = hertz.approach(load, radius, modulus)
    assert hertz.load(delta, radius, modulus) == pytest.approx(load, rel=1e-12)


@given(load=loads, radius=radii, modulus=moduli)
def test_stiffness_is_that_of_a_punch_of_the_same_radius(load, radius, modulus):
    # dW/dδ = 2 E* a for every axisymmetric indenter; the central difference errs by 1e-7.
    delta, step = hertz.approach(load, radius, modulus), 1e-3
    above, below = (hertz.load(delta * (1 + s), radius, modulus) for s in (step, -step))
    stiffness = (above - below) / (2 * step * delta)
    expected = 2 * modulus * hertz.contact_radius(load, radius, modulus)
    assert stiffness == pytest.approx(expected, rel=1e-6)


@given(radius=radii, modulus=moduli, pressure=st.floats(1e5, 1e11))
def test_first_yield_load_makes_the_first_yield_pressure(radius, modulus, pressure):
    load = hertz.first_yield_load(radius, modulus, pressure)
    assert hertz.max_pressure(load, radius, modulus) == pytest.approx(pressure, rel=1e-12)


def test_ceiling_of_three_yield_strengths_is_far_above_first_yield():
    # DESIGN section 2: a 3σ_Y ceiling leaves Hertz elastic up to 6.4 times the first yield load.
    body = Material(young=210e9, poisson=0.3, yield_strength=1e9)
    first = hertz.first_yield_load(RADIUS, MODULUS, body.first_yield_pressure)
    saturated = hertz.first_yield_load(RADIUS, MODULUS, 3e9)
    assert saturated / first == pytest.approx(6.4, abs=0.05)


@given(ratio=st.floats(0.01, 0.66))
def test_saturated_disc_carries_the_load(ratio):
    a = hertz.saturated_radius_ratio(ratio) * A
    assert math.pi * a**2 * ratio * P0 == pytest.approx(LOAD, rel=1e-12)


@pytest.mark.parametrize("bad", [0.0, -1.0, math.nan, math.inf])
@pytest.mark.parametrize("name", ["load", "radius", "contact_modulus"])
def test_bad_argument_is_named(name, bad):
    good = {"load": LOAD, "radius": RADIUS, "contact_modulus": MODULUS}
    with pytest.raises(InputError, match=rf"^{name} must be positive.*{bad!r}"):
        hertz.contact_radius(**{**good, name: bad})
