import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.integrate import quad
from scipy.special import ellipkm1

from roughcontact.errors import InputError
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


@given(load=loads, radius=radii, modulus=moduli)
def test_load_and_approach_are_inverse(load, radius, modulus):
    delta = hertz.approach(load, radius, modulus)
    assert hertz.load(delta, radius, modulus) == pytest.approx(load, rel=1e-12)


@given(radius=radii, modulus=moduli, pressure=st.floats(1e5, 1e11))
def test_first_yield_load_makes_the_first_yield_pressure(radius, modulus, pressure):
    load = hertz.first_yield_load(radius, modulus, pressure)
    assert hertz.max_pressure(load, radius, modulus) == pytest.approx(pressure, rel=1e-12)


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


# --- two radii of curvature ---------------------------------------------------------------------

RATIOS = [1.0, 1 + 1e-9, 1.001, 1.7, 5.0, 40.0, 1e4]


def displaced(contact, x, y, modulus):
    """Displacement at a point of the ellipse under its pressure, by rays through the point.

    Along a ray the pressure is half of an ellipse, whose area is known; one integral is left.
    """
    a, b = contact.semi_axes

    def ray(t):
        c, s = math.cos(t), math.sin(t)
        square = (c / a) ** 2 + (s / b) ** 2
        middle = (x * c / a**2 + y * s / b**2) / square
        chord2 = (1 - (x / a) ** 2 - (y / b) ** 2) / square + middle**2
        return math.pi / 2 * chord2 * math.sqrt(square)

    # Steep rays of slender ellipses: split where they turn into the short axis.
    bend = math.atan2(b, a)
    ends = sorted({0.0, bend, math.pi / 2, math.pi - bend, math.pi})
    total = sum(quad(ray, *pair, epsabs=0, epsrel=1e-12, limit=400)[0] for pair in pairwise(ends))
    return contact.max_pressure * total / (math.pi * modulus)


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("turned", [False, True])
def test_the_pressure_on_an_ellipse_presses_the_bodies_together(ratio, turned):
    radii = (RADIUS, ratio * RADIUS) if turned else (ratio * RADIUS, RADIUS)
    contact = hertz.elliptic_contact(LOAD, radii, MODULUS)
    a, b = contact.semi_axes
    assert (a >= b) is (radii[0] >= radii[1])
    # Displacement plus gap is the approach all over the ellipse, not in its middle alone.
    for x, y in [(0.0, 0.0), (0.6 * a, 0.0), (0.0, 0.7 * b), (0.5 * a, -0.4 * b)]:
        shape = x**2 / (2 * radii[0]) + y**2 / (2 * radii[1])
        found = displaced(contact, x, y, MODULUS) + shape
        assert found == pytest.approx(contact.approach, rel=1e-9)
    assert 2 / 3 * contact.max_pressure * contact.area == pytest.approx(LOAD, rel=1e-12)
    assert contact.mean_pressure == pytest.approx(2 / 3 * contact.max_pressure, rel=1e-12)


def test_nearly_a_circle_keeps_its_digits():
    # To first order the ratio of the semi-axes is that of the radii to the power 2/3.
    contact = hertz.elliptic_contact(LOAD, ((1 + 1e-7) * RADIUS, RADIUS), MODULUS)
    a, b = contact.semi_axes
    assert a / b - 1 == pytest.approx(2 / 3 * 1e-7, rel=1e-6)


@given(loads, radii, radii, moduli)
def test_the_load_of_a_peak_is_the_inverse(load, first, second, modulus):
    if max(first, second) / min(first, second) > 1e6:
        return
    peak = hertz.elliptic_contact(load, (first, second), modulus).max_pressure
    assert hertz.elliptic_load(peak, (first, second), modulus) == pytest.approx(load, rel=1e-12)
    round_peak = hertz.max_pressure(load, first, modulus)
    assert hertz.load_at_pressure(round_peak, first, modulus) == pytest.approx(load, rel=1e-12)
    line = hertz.line_contact(load, first, modulus)
    assert hertz.line_load(line.max_pressure, first, modulus) == pytest.approx(load, rel=1e-12)


def test_a_line_of_pressure_presses_the_cylinder_in():
    line, datum = 2e4, 0.3
    contact = hertz.line_contact(line, RADIUS, MODULUS)
    a, p0 = contact.half_width, contact.max_pressure
    assert line == pytest.approx(math.pi / 2 * a * p0, rel=1e-13)
    assert contact.mean_pressure == pytest.approx(math.pi / 4 * p0, rel=1e-13)

    def displacement(x):
        # Flamant: 2/(π E*) ∫ p(s) ln(d/|x - s|) ds with s = a sin t.
        def part(t):
            s = a * math.sin(t)
            return p0 * math.cos(t) ** 2 * a * math.log(datum / abs(x - s))

        ends = [-math.pi / 2, math.asin(x / a), math.pi / 2]
        total = sum(quad(part, *pair, epsabs=0, limit=400)[0] for pair in pairwise(ends))
        return 2 / (math.pi * MODULUS) * total

    expected = hertz.line_approach(line, RADIUS, MODULUS, datum)
    for x in (0.0, 0.4 * a, 0.9 * a):
        assert displacement(x) + x**2 / (2 * RADIUS) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("call", "argument"),
    [
        (lambda: hertz.elliptic_contact(1.0, (1.0, 0.0), 1.0), "radii[1]"),
        (lambda: hertz.elliptic_load(-1.0, (1.0, 1.0), 1.0), "max_pressure"),
        (lambda: hertz.line_contact(1.0, math.inf, 1.0), "radius"),
        (lambda: hertz.line_load(1.0, 1.0, 0.0), "contact_modulus"),
        (lambda: hertz.line_approach(1.0, 1.0, 1.0, 0.5), "datum"),
        (lambda: hertz.load_at_pressure(0.0, 1.0, 1.0), "max_pressure"),
    ],
)
def test_two_radii_and_lines_refuse_nonsense(call, argument):
    with pytest.raises(InputError) as refused:
        call()
    assert refused.value.argument == argument
