"""The whole program against Hertz, with and without a ceiling, and the demo's nested spots."""

import math

import pytest

import roughcontact as rc
from roughcontact.surface import shapes
from roughcontact.theory import hertz

STEEL = rc.Material(young=210e9, poisson=0.3)
MODULUS = 210e9 / 0.91
RADIUS = 10e-3
LOAD = 5.0
A = hertz.contact_radius(LOAD, RADIUS, MODULUS)
P0 = hertz.max_pressure(LOAD, RADIUS, MODULUS)


def ball(n, side, aspect=1.0):
    """A sphere's summit on n × n pixels, dy = aspect × dx."""
    pixel = (side * aspect / n, side / n)
    return rc.Surface(shapes.paraboloid((n, n), pixel, RADIUS), pixel)


def radius_of(area):
    return math.sqrt(area / math.pi)


def test_hertz_by_approach():
    delta = hertz.approach(LOAD, RADIUS, MODULUS)
    result = rc.solve(ball(256, 3 * A), material=STEEL, approach=delta)
    # W ~ δ^(3/2), and δ is met to 1e-3 on the grid above.
    assert result.load == pytest.approx(LOAD, rel=2e-3)


def test_two_balls_are_one_of_half_the_radius():
    surface = ball(128, 3 * A)
    copper = rc.Material(120e9, 0.34)
    pair = rc.solve(
        surface, counter_surface=surface, material=STEEL, counter_material=copper, load=LOAD
    )
    modulus = 1 / (0.91 / 210e9 + (1 - 0.34**2) / 120e9)
    p0 = hertz.max_pressure(LOAD, RADIUS / 2, modulus)
    # a is 41 pixels; the rim costs about 1/a² of the peak.
    assert pair.max_pressure == pytest.approx(p0, rel=3e-3)


def test_fully_saturated_limit(independent):
    ceiling_ratio = 0.2
    result = rc.solve(ball(256, 4.2 * A), material=STEEL, load=LOAD, ceiling=ceiling_ratio * P0)
    independent.assert_solved(result, LOAD)
    limit = hertz.saturated_radius_ratio(ceiling_ratio)
    assert limit == pytest.approx(math.sqrt(2 / 0.6))
    assert radius_of(result.contact_area) / A == pytest.approx(limit, rel=0.01)
    assert result.saturated_fraction > 0.97 * result.contact_fraction


def test_regime_of_a_ball_changes_at_first_yield():
    yielding = rc.Material(210e9, 0.3, yield_strength=0.5e9)
    first = hertz.first_yield_load(RADIUS, MODULUS, yielding.first_yield_pressure)
    a = hertz.contact_radius(first, RADIUS, MODULUS)
    surface = ball(128, 3 * a)
    # The peak is met to 0.3 %, the load to three times that.
    below = rc.solve(surface, material=yielding, load=0.97 * first)
    above = rc.solve(surface, material=yielding, load=1.03 * first)
    assert below.regime == "below first yield"
    assert above.regime == "yielding below the surface"
