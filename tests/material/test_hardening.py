"""Hardening laws and radial return against their definitions and a bracketed root find."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.optimize import brentq

from roughcontact.errors import InputError
from roughcontact.material.hardening import (
    Kinematic,
    Linear,
    Perfect,
    Swift,
    Tabulated,
    flow_stress,
    from_text,
    plastic_increment,
    to_text,
)

LAWS = [
    Perfect(1e9),
    Linear(1e9, 20e9),
    Swift(1240e6, 30, 0.085),
    Tabulated((0.0, 0.002, 0.01, 0.1), (1.0e9, 1.1e9, 1.1e9, 1.5e9)),
    Kinematic(Perfect(1e9), 15e9),
    Kinematic(Swift(1240e6, 30, 0.085), 15e9),
]
MU = 80e9


@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_slope_is_the_derivative(law) -> None:
    strain = np.array([1e-4, 1e-3, 5e-3, 0.03, 0.2])
    step = 1e-8
    difference = (law.strength(strain + step) - law.strength(strain - step)) / (2 * step)
    # Central differences of values of 1e9 with a step of 1e-8: rounding leaves 1e9·1e-16/1e-8.
    np.testing.assert_allclose(law.slope(strain), difference, rtol=1e-6, atol=100)
    assert law.strength(np.zeros(1))[0] == pytest.approx(law.initial, rel=1e-14)


def test_swift_of_a_bearing_steel() -> None:
    # 1240 MPa · 30^0.085 = 1655.7 MPa, by logarithms.
    assert Swift(1240e6, 30, 0.085).initial == pytest.approx(
        1240e6 * math.exp(0.085 * math.log(30)), rel=1e-14
    )


@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
@given(trial=st.floats(min_value=1e6, max_value=1e12), before=st.floats(min_value=0, max_value=0.5))
def test_return_ends_on_the_yield_surface(law, trial, before) -> None:
    step = float(plastic_increment(np.array([trial]), np.array([before]), law, MU)[0])

    def miss(size):
        back = law.modulus if isinstance(law, Kinematic) else 0.0
        strength = float(law.strength(np.array([before + size]))[0])
        return trial - (3 * MU + back) * size - strength

    if miss(0.0) <= 0:
        assert step == 0
        return
    exact = brentq(miss, 0.0, trial / (3 * MU), xtol=1e-300, rtol=1e-14)
    assert step == pytest.approx(exact, rel=1e-9, abs=1e-15 * trial / MU)


def test_single_precision_stays_single() -> None:
    for law in LAWS:
        q, e = np.array([2e9, 3e9], np.float32), np.array([0, 0.01], np.float32)
        single = plastic_increment(q, e, law, MU)
        assert single.dtype == np.float32
        double = plastic_increment(q.astype(float), e.astype(float), law, MU)
        np.testing.assert_allclose(single, double, rtol=1e-5)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_text_keeps_every_bit(law) -> None:
    assert from_text(to_text(law)) == law


@pytest.mark.parametrize("text", ["", "{}", '{"law": "Chaboche"}', '{"law": "Perfect", "x": 1}'])
def test_text_that_is_no_law(text) -> None:
    with pytest.raises(InputError, match="hardening must be JSON"):
        from_text(text)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Perfect(0.0), "initial must be positive"),
        (lambda: Perfect(math.nan), "initial must be positive"),
        (lambda: Linear(1e9, -1.0), "modulus must be zero or positive"),
        (lambda: Linear(1e9, math.inf), "modulus must be zero or positive"),
        (lambda: Swift(0.0, 30, 0.1), "coefficient must be positive"),
        (lambda: Swift(1e9, -1, 0.1), "offset must be positive"),
        (lambda: Swift(1e9, 30, -0.1), "exponent must be in"),
        (lambda: Swift(1e9, 30, 1.1), "exponent must be in"),
        (lambda: Tabulated((0.0,), (1e9,)), "two or more"),
        (lambda: Tabulated((0.0, 0.1), (1e9,)), "same length"),
        (lambda: Tabulated("ab", (1e9, 2e9)), "must be a list"),
        (lambda: Tabulated((0.1, 0.2), (1e9, 2e9)), "increase from 0"),
        (lambda: Tabulated((0.0, 0.0), (1e9, 2e9)), "increase from 0"),
        (lambda: Tabulated((0.0, 0.1), (1e9, 0.9e9)), "must not decrease"),
        (lambda: Tabulated((0.0, 0.1), (0.0, 0.9e9)), "positive and finite"),
        (lambda: Kinematic(Perfect(1e9), -1.0), "modulus must be zero or positive"),
        (lambda: Kinematic(Kinematic(Perfect(1e9), 1e9), 1e9), "isotropic must be"),
    ],
)
def test_laws_that_no_material_has(make, message) -> None:
    with pytest.raises(InputError, match=message):
        make()


def cycled(law, amplitude, turns, steps=400):
    """Return strain and stress of a bar at each turn between ±amplitude, step by step."""
    young, plastic, accumulated = 200e9, 0.0, 0.0
    ends, before = [], 0.0
    for turn in range(turns):
        end = amplitude if turn % 2 == 0 else -amplitude
        for strain in np.linspace(before, end, steps + 1)[1:]:
            relative = young * (strain - plastic) - law.modulus * plastic
            # In a bar the stress falls by E, not by 3μ, for what flows at frozen strain.
            step = plastic_increment(
                np.array([abs(relative)]), np.array([accumulated]), law, young / 3
            )
            plastic += math.copysign(float(step[0]), relative)
            accumulated += float(step[0])
        ends.append((plastic, young * (end - plastic)))
        before = end
    return ends


def test_bar_that_is_pulled_and_pushed() -> None:
    """Closed form of a bilinear loop: elastic over 2 σ_Y, then along the tangent modulus."""
    strength, modulus, young, amplitude = 1e9, 25e9, 200e9, 0.015
    tangent = young * modulus / (young + modulus)
    top = strength + tangent * (amplitude - strength / young)
    ends = cycled(Kinematic(Perfect(strength), modulus), amplitude, 6)
    for turn, (plastic, stress) in enumerate(ends):
        sign = 1 if turn % 2 == 0 else -1
        # By symmetry the loop is closed from the first reversal on.
        assert stress == pytest.approx(sign * top, rel=1e-9)
        assert plastic == pytest.approx(sign * (amplitude - top / young), rel=1e-9)


def test_bar_that_hardens_both_ways() -> None:
    """Each half cycle solves a linear equation where strength and back stress are linear."""
    strength, rise, back, young, amplitude = 1e9, 5e9, 25e9, 200e9, 0.015
    plastic = accumulated = 0.0
    for turn, found in enumerate(
        cycled(Kinematic(Linear(strength, rise), back), amplitude, 8, steps=50)
    ):
        sign = 1 if turn % 2 == 0 else -1
        # E (a - p) - C p = Y + H (e + |p - before|), everything in the direction of flow.
        now = sign * young * amplitude - sign * (strength + rise * accumulated)
        now = (now + rise * plastic) / (young + back + rise)
        accumulated += abs(now - plastic)
        plastic = now
        assert found[0] == pytest.approx(plastic, rel=1e-9)
        assert found[1] == pytest.approx(young * (sign * amplitude - plastic), rel=1e-9)


def test_first_way_is_that_of_the_sum_of_both_moduli() -> None:
    strain = np.linspace(0, 0.05, 7)
    split = flow_stress(Kinematic(Linear(1e9, 5e9), 15e9), strain)
    np.testing.assert_allclose(split, flow_stress(Linear(1e9, 20e9), strain), rtol=1e-15)


def test_beyond_its_last_point_a_table_is_perfectly_plastic() -> None:
    law = Tabulated((0.0, 0.01, 0.02), (1e9, 1.1e9, 1.15e9))
    strain = np.array([0.0, 0.005, 0.01, 0.02, 0.5])
    assert law.slope(strain).tolist() == pytest.approx([1e10, 1e10, 5e9, 0.0, 0.0], abs=1e-3)
    assert law.strength(strain)[-1] == 1.15e9
