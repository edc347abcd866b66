import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.integrate import quad
from scipy.special import ellipkm1

from roughcontact.errors import InputError
from roughcontact.theory import indenters

MODULUS = 80e9
A, SLOPE = 4e-6, 0.1


def ring_integral(r, pressure, a):
    """Displacement under axisymmetric pressure by summing Boussinesq's rings; s = a sin t."""

    def ring(t):
        s = a * math.sin(t)
        kernel = 4 / (math.pi * MODULUS) * s / (r + s) * ellipkm1(((r - s) / (r + s)) ** 2)
        return float(pressure(s)) * kernel * a * math.cos(t)

    # The kernel has a logarithmic pole at s = r, where the interval is split.
    ends = [0, math.asin(r / a), math.pi / 2] if r < a else [0, math.pi / 2]
    return sum(quad(ring, *pair, epsabs=0, limit=200)[0] for pair in pairwise(ends))


@pytest.mark.parametrize("rho", [0.1, 0.6, 0.99, 1.01, 2.0, 20.0])
def test_displacement_is_the_half_space_response(rho):
    delta = 1e-8
    load = indenters.punch_load(delta, A, MODULUS)
    mean = indenters.cone_mean_pressure(SLOPE, MODULUS)
    for pressure, found in (
        (
            lambda r: indenters.punch_pressure(r, load, A),
            indenters.punch_displacement(rho * A, delta, A),
        ),
        (
            lambda r: indenters.cone_pressure(r, A, mean),
            indenters.cone_displacement(rho * A, A, SLOPE),
        ),
    ):
        assert float(found) == pytest.approx(ring_integral(rho * A, pressure, A), rel=1e-6)


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


def test_singular_points_match_docstrings():
    assert indenters.punch_pressure([A, 2 * A], 1.0, A).tolist() == [0, 0]
    assert indenters.cone_pressure([0, A, 2 * A], A, 1.0).tolist() == [math.inf, 0, 0]


@pytest.mark.parametrize("bad", [0.0, -1.0, math.nan])
def test_bad_argument_is_named(bad):
    with pytest.raises(InputError, match=r"^slope must be positive"):
        indenters.cone_mean_pressure(bad, 1.0)
