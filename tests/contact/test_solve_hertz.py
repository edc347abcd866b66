"""The whole program against Hertz, with and without a ceiling, and the demo's nested spots."""

import math

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.surface import shapes
from roughcontact.theory import hertz, indenters

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


def distance(surface):
    (ny, nx), (dy, dx) = surface.shape, surface.pixel
    y = (np.arange(ny) - (ny - 1) / 2) * dy
    x = (np.arange(nx) - (nx - 1) / 2) * dx
    return np.hypot(y[:, None], x)


def radius_of(area):
    return math.sqrt(area / math.pi)


@pytest.mark.long
@pytest.mark.parametrize("aspect", [1.0, 1.3])
def test_hertz_on_512(independent, aspect):
    surface = ball(512, 3 * A, aspect)
    result = rc.solve(surface, material=STEEL, load=LOAD)
    independent.assert_solved(result, LOAD)
    assert abs(radius_of(result.contact_area) - A) <= surface.pixel[1]
    assert result.max_pressure == pytest.approx(P0, rel=1e-3)
    expected = hertz.pressure(distance(surface), A, P0)
    error = np.linalg.norm(result.pressure - expected) / np.linalg.norm(expected)
    assert error < 3e-3
    # The approach is an integral of the pressure: better than the pressure.
    assert result.approach == pytest.approx(hertz.approach(LOAD, RADIUS, MODULUS), rel=1e-3)
    # Outside, the gap of the closed form; one pixel's displacement is about its error.
    gap = hertz.gap(distance(surface), A, RADIUS)
    assert np.abs(result.gap - gap).max() < 1e-3 * gap.max()


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


# DESIGN section 3: domain 4 a_H, 128², radii by pixel count.
TABLE = {
    None: (1.005, None),
    0.9: (1.007, 0.532),
    0.8: (1.014, 0.737),
    0.7: (1.038, 0.887),
    0.6: (1.086, 1.015),
    0.5: (1.164, 1.142),
    0.4: (1.297, 1.287),
    0.3: (1.494, 1.487),
}


@pytest.mark.parametrize("ratio", TABLE)
def test_ceiling_table(independent, ratio):
    surface = ball(128, 4 * A)
    result = rc.solve(
        surface, material=STEEL, load=LOAD, ceiling=None if ratio is None else ratio * P0
    )
    independent.assert_solved(result, LOAD)
    touching, saturated = TABLE[ratio]
    # One ring of pixels is A/32 wide; counting them all does three times better: ±1 %.
    assert radius_of(result.contact_area) / A == pytest.approx(touching, rel=0.01)
    if saturated is not None:
        area = np.count_nonzero(result.saturated) * result.pixel_area
        assert radius_of(area) / A == pytest.approx(saturated, rel=0.01)
        assert result.max_pressure == ratio * P0
        # The saturated pixels are a disc around the summit.
        r = distance(surface)
        assert r[result.saturated].max() <= r[~result.saturated].min() + surface.pixel[1]


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


def test_flat_round_punch():
    n, side = 256, 1e-4
    pixel = (side / n, side / n)
    a = 0.3 * side
    r = distance(rc.Surface(np.zeros((n, n)), pixel))
    surface = rc.Surface(np.where(r < a, 0.0, -1e-5), pixel)
    result = rc.solve(surface, material=STEEL, load=1.0)
    inside = r < a
    np.testing.assert_array_equal(result.contact, inside)
    # The stepped rim is a pixel uncertain, 1/77 of the radius, and the load ends there.
    stiffness = 1.0 / result.approach
    assert stiffness == pytest.approx(indenters.punch_load(1.0, a, MODULUS), rel=0.01)
    expected = indenters.punch_pressure(r, 1.0, a)
    core = r < 0.7 * a
    np.testing.assert_allclose(result.pressure[core], expected[core], rtol=0.015)


def test_cone():
    n, slope, load = 256, 0.02, 1.0
    a = indenters.cone_contact_radius(load, slope, MODULUS)
    side = 3 * a
    pixel = (side / n, 1.2 * side / n)
    r = distance(rc.Surface(np.zeros((n, n)), pixel))
    result = rc.solve(rc.Surface(-slope * r, pixel), material=STEEL, load=load)
    assert abs(radius_of(result.contact_area) - a) <= max(pixel)
    # The summit lies between four pixels, δ counts from the nearest: 0.8 pixels times the slope.
    blunt = slope * r.min()
    assert result.approach == pytest.approx(indenters.cone_approach(a, slope) - blunt, rel=5e-3)
    expected = indenters.cone_pressure(r, a, indenters.cone_mean_pressure(slope, MODULUS))
    # Off the logarithmic tip and the rim.
    ring = (r > 0.1 * a) & (r < 0.9 * a)
    np.testing.assert_allclose(result.pressure[ring], expected[ring], rtol=0.02)


@pytest.mark.long
@pytest.mark.parametrize("n", [512, pytest.param(1024, marks=pytest.mark.slow)])
def test_elastic_spots_lie_inside_the_contact_with_a_ceiling(independent, n):
    heights, pixel = rc.reference_map(n)
    surface = rc.Surface(heights, pixel)
    steel = rc.Material(210e9, 0.3, yield_strength=1e9)
    elastic = rc.solve(surface, material=steel, load=1.0, ceiling=None)
    ceiling = rc.solve(surface, material=steel, load=1.0)
    independent.assert_solved(elastic, 1.0)
    independent.assert_solved(ceiling, 1.0)
    assert ceiling.saturated_fraction > 0
    assert elastic.max_pressure > 3e9
    assert ceiling.contact_area > 1.05 * elastic.contact_area
    assert not (elastic.contact & ~ceiling.contact).any()
