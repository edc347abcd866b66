"""Contacts of nominal bodies against their closed forms, and of two maps brought together."""

import math
from functools import partial

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

import roughcontact as rc
from roughcontact.surface import nominal_bodies, placement
from roughcontact.theory import hertz

STEEL = rc.Material(young=210e9, poisson=0.3)
MODULUS = 210e9 / 0.91
RADIUS = 10e-3
LOAD = 5.0
A = hertz.contact_radius(LOAD, RADIUS, MODULUS)
P0 = hertz.max_pressure(LOAD, RADIUS, MODULUS)

solve = partial(rc.solve, material=STEEL, load=LOAD)


def grid(shape, side):
    return {"shape": shape, "pixel": (side[0] / shape[0], side[1] / shape[1])}


def from_center(surface):
    (ny, nx), (dy, dx) = surface.shape, surface.pixel
    y = (np.arange(ny) - (ny - 1) / 2) * dy
    x = (np.arange(nx) - (nx - 1) / 2) * dx
    return np.broadcast_arrays(y[:, None], x)


def misfit(pressure, expected):
    return np.linalg.norm(pressure - expected) / np.linalg.norm(expected)


def axes_of(mask, surface):
    """Semi-axes and direction [degrees counter-clockwise] of a mask, by its moments."""
    y, x = (position[mask] for position in from_center(surface))
    covariance = np.cov(np.vstack([y, x]), bias=True)
    variances, vectors = np.linalg.eigh(covariance)
    # A uniform ellipse has the variance a²/4 along its axis.
    b, a = 2 * np.sqrt(variances)
    return a, b, math.degrees(math.atan2(-vectors[0, 1], vectors[1, 1])) % 180


def elliptic(load, larger, smaller):
    """Semi-axes a > b, peak pressure and approach of Hertz's ellipse: Johnson (4.26) to (4.28)."""

    def ratio_of_curvatures(k):
        # B/A with k = b/a, e² = 1 - k²; SciPy's parameter is e².
        e2 = 1 - k**2
        K, E = ellipk(e2), ellipe(e2)
        return (E / k**2 - K) / (K - E)

    k = brentq(lambda k: ratio_of_curvatures(k) - larger / smaller, 1e-3, 1 - 1e-9, xtol=1e-14)
    e2 = 1 - k**2
    K, E = ellipk(e2), ellipe(e2)
    # A = 1/(2R') = p0 b (K - E)/(E* a² e²) with p0 = 3W/(2πab).
    a = (3 * load * larger * (K - E) / (math.pi * MODULUS * e2)) ** (1 / 3)
    b = k * a
    p0 = 3 * load / (2 * math.pi * a * b)
    return a, b, p0, p0 * b * K / MODULUS


@pytest.mark.parametrize("angle", [0.0, 30.0])
def test_crossed_cylinders_are_a_sphere(independent, angle):
    on = grid((150, 130), (3 * A, 3 * A))
    first = nominal_bodies.cylinder(radius=RADIUS, angle=angle, **on)
    second = nominal_bodies.cylinder(radius=RADIUS, angle=angle + 90, **on)
    pair = solve(first, counter_surface=second)
    independent.assert_solved(pair, LOAD)
    # 46 pixels a radius: the peak is met to 1e-4, the area to a tenth of a pixel ring.
    assert pair.max_pressure == pytest.approx(P0, rel=5e-4)
    assert math.sqrt(pair.contact_area / math.pi) == pytest.approx(A, rel=5e-3)
    assert pair.approach == pytest.approx(hertz.approach(LOAD, RADIUS, MODULUS), rel=5e-4)
    # The two bodies differ by the fourth order, (a/2R)² = 6e-6 of the heights.
    ball = solve(nominal_bodies.sphere(radius=RADIUS, **on))
    assert misfit(pair.pressure, ball.pressure) < 1e-4


def test_ball_in_groove_has_hertz_ellipse():
    # Across the groove along x the curvatures subtract; along it there is that of the ball.
    groove = -1.5 * RADIUS
    a, b, p0, approach = elliptic(LOAD, 1 / (1 / RADIUS + 1 / groove), RADIUS)
    on = grid((160, 160), (2.6 * a, 2.6 * a))
    result = solve(nominal_bodies.sphere(radius=RADIUS, **on), counter_surface=rc.cylinder(groove))
    got = axes_of(result.contact, result.surface)
    assert got[:2] == pytest.approx((a, b), rel=0.015)
    assert got[2] == pytest.approx(90, abs=1)
    assert result.max_pressure == pytest.approx(p0, rel=1e-3)
    assert result.approach == pytest.approx(approach, rel=1e-3)
    assert result.hertz.max_pressure == pytest.approx(p0, rel=1e-6)


def test_hollow_narrower_than_the_ball_has_no_hertz_contact():
    on = grid((32, 32), (3 * A, 3 * A))
    ball = nominal_bodies.sphere(radius=RADIUS, **on)
    assert solve(ball, counter_surface=rc.sphere(-0.9 * RADIUS)).hertz is None


@pytest.mark.parametrize(("ratio", "angle"), [(2.5, 0.0), (2.5, 30.0), (5.0, 90.0)])
def test_an_ellipsoid_makes_hertz_s_ellipse(independent, ratio, angle):
    larger, smaller = ratio * 4e-3, 4e-3
    a, b, p0, approach = elliptic(LOAD, larger, smaller)
    on = grid((170, 150), (2.6 * a, 2.6 * a))
    # The larger radius along x, then turned.
    result = solve(nominal_bodies.ellipsoid(radii=(smaller, larger), angle=angle, **on))
    independent.assert_solved(result, LOAD)
    got = axes_of(result.contact, result.surface)
    # A pixel of the rim counts whole or not at all: a tenth of a pixel in b = 19 pixels.
    assert got[:2] == pytest.approx((a, b), rel=0.015)
    assert got[2] == pytest.approx(angle, abs=1.0)
    assert result.max_pressure == pytest.approx(p0, rel=1e-3)
    assert result.approach == pytest.approx(approach, rel=1e-3)
    y, x = from_center(result.surface)
    t = -math.radians(angle)
    along, across = x * math.cos(t) + y * math.sin(t), y * math.cos(t) - x * math.sin(t)
    expected = p0 * np.sqrt(np.maximum(1 - (along / a) ** 2 - (across / b) ** 2, 0))
    assert misfit(result.pressure, expected) < 0.01


def test_a_round_punch(independent):
    side = 1e-4
    a = 0.3 * side
    surface = nominal_bodies.punch(radius=a, **grid((200, 220), (side, side)))
    result = solve(surface, load=1.0)
    independent.assert_solved(result, 1.0)
    # No pixel outside, none inside left out.
    np.testing.assert_array_equal(result.contact, np.isfinite(surface.heights))
    # The stepped rim is a fraction of a pixel uncertain, and a pixel is 1/60 of the radius.
    # Johnson 1985, eqs. 3.34 and 3.36.
    assert 1.0 / result.approach == pytest.approx(2 * a * MODULUS, rel=5e-3)
    r = np.hypot(*from_center(surface))
    core = r < 0.7 * a
    expected = 1 / (2 * math.pi * a**2 * np.sqrt(1 - (r[core] / a) ** 2))
    np.testing.assert_allclose(result.pressure[core], expected, rtol=0.01)
    # Nothing outside of it is treated as open gap.
    assert np.isnan(result.gap[r > a * 1.001]).all()


def test_a_punch_with_a_rounded_edge():
    # Sneddon 1965 for the profile f: δ = a ∫ f'(r) (a² - r²)^(-1/2) dr and
    # W = 2 E* ∫ r² f'(r) (a² - r²)^(-1/2) dr, over 0 to a; r = a sin t.
    radius, rho, a = 3e-5, 1e-5, 2.5e-5

    def slope(t):
        d = max(a * math.sin(t) - (radius - rho), 0)
        return d / math.sqrt(rho**2 - d**2)

    start = math.asin((radius - rho) / a)
    approach = a * quad(slope, start, math.pi / 2)[0]
    load = 2 * MODULUS * quad(lambda t: (a * math.sin(t)) ** 2 * slope(t), start, math.pi / 2)[0]
    on = grid((220, 200), (7e-5, 7e-5))
    result = solve(nominal_bodies.punch(radius=radius, edge_radius=rho, **on), load=load)
    # 75 pixels a radius.
    assert math.sqrt(result.contact_area / math.pi) == pytest.approx(a, rel=5e-3)
    assert result.approach == pytest.approx(approach, rel=5e-4)
    # The peak lies over the edge of the flat, the middle of a sharp punch of radius a is lower.
    r = np.hypot(*from_center(result.surface))
    assert 1.5e-5 < r.ravel()[result.pressure.argmax()] < 2.5e-5


def test_a_cone():
    slope, load = 0.02, 1.0
    # Love 1939: mean pressure, approach and pressure under a cone.
    mean = MODULUS * slope / 2
    a = math.sqrt(load / (math.pi * mean))
    # The tip on a point; coarse as it is there, the contact around it does not feel it.
    surface = nominal_bodies.cone(slope=slope, **grid((201, 211), (3 * a, 3 * a)))
    result = solve(surface, load=load)
    assert abs(math.sqrt(result.contact_area / math.pi) - a) <= max(surface.pixel)
    assert result.approach == pytest.approx(math.pi * a * slope / 2, rel=1e-3)
    r = np.hypot(*from_center(surface))
    # Off the logarithmic tip, blunted to a pixel, and the rim.
    ring = (r > 0.15 * a) & (r < 0.9 * a)
    np.testing.assert_allclose(result.pressure[ring], mean * np.arccosh(a / r[ring]), rtol=2e-3)


@pytest.mark.parametrize("axis", [0, 90])
def test_a_wedge(axis):
    # Johnson sec. 5.2: half-width a = P/(E* m), pressure (E* m/π) arcosh(a/x); neighbours at the
    # period L change it by (a/L)².
    slope, period = 0.01, 1e-3
    a = 0.04 * period
    line_load = a * MODULUS * slope
    n = 1536
    shape, sides = ((4, n), (1e-5, period)) if axis == 90 else ((n, 4), (period, 1e-5))
    surface = nominal_bodies.wedge(slope=slope, angle=axis, **grid(shape, sides))
    result = solve(surface, load=line_load * 1e-5, boundary="periodic")
    profile = result.pressure[0] if axis == 90 else result.pressure[:, 0]
    position = np.abs(np.arange(n) - (n - 1) / 2) * period / n
    assert np.count_nonzero(profile) * period / n == pytest.approx(2 * a, rel=0.015)
    ring = (position > 0.15 * a) & (position < 0.9 * a)
    expected = MODULUS * slope / math.pi * np.arccosh(a / position[ring])
    np.testing.assert_allclose(profile[ring], expected, rtol=0.01)


# --- roughness on a body --------------------------------------------------------------------------


def test_a_rough_ball_touches_within_the_smooth_one_and_a_little_around(independent):
    n, side = 128, 4 * A
    pixel = (side / n, side / n)
    rough = rc.self_affine(
        (n, n),
        pixel,
        rms_height=0.1 * A**2 / RADIUS,
        rolloff_wavelength=side / 4,
        cutoff_wavelength=4 * pixel[0],
        rng=np.random.default_rng(5),
    )
    roughness = rc.Surface(rough, pixel)
    ball = nominal_bodies.parse("sphere 10 mm")(shape=(n, n), pixel=pixel)
    on_the_ball = solve(ball.with_form(roughness))
    independent.assert_solved(on_the_ball, LOAD)
    # Roughness on one body or on the other is the same contact.
    opposite = solve(ball, counter_surface=roughness)
    np.testing.assert_allclose(
        opposite.pressure, on_the_ball.pressure, rtol=0, atol=1e-5 * on_the_ball.max_pressure
    )
    smooth = solve(ball)
    r = np.hypot(*from_center(ball))
    assert r[on_the_ball.contact].max() > r[smooth.contact].max()
    assert on_the_ball.max_pressure > smooth.max_pressure
    # Greenwood and Tripp: at a roughness of a tenth of the approach the mean pressure at a
    # distance is near Hertz's; its second moment grows by some ten per cent.
    moments = [(f.pressure * r**2).sum() / f.pressure.sum() for f in (smooth, on_the_ball)]
    assert moments[0] == pytest.approx(0.4 * A**2, rel=0.01)
    assert 1.0 < moments[1] / moments[0] < 1.3


# --- two measured maps ----------------------------------------------------------------------------


def peaks(y, x, phase):
    """Heights with waves of 20 µm and more."""
    k = 2 * math.pi / 20e-6
    return 0.1e-6 * (
        np.cos(k * (0.8 * x + 0.5 * y) + phase)
        + np.sin(k * (0.6 * y - 0.7 * x))
        + np.cos(0.4 * k * x - phase) * np.cos(0.3 * k * y)
    )


def map_on_points(shape, pixel, phase, offset=(0.0, 0.0), angle=0.0, mirrored=False):
    y, x = ((np.arange(n) - (n - 1) / 2) * d for n, d in zip(shape, pixel, strict=True))
    y, x = np.broadcast_arrays(y[:, None] - offset[0], x - offset[1])
    t = -math.radians(angle)
    y, x = y * math.cos(t) - x * math.sin(t), x * math.cos(t) + y * math.sin(t)
    return peaks(y, -x if mirrored else x, phase)


def test_two_maps_of_other_pixels_make_the_contact_of_one_grid(independent):
    first = rc.Surface(map_on_points((100, 120), (1e-6, 1e-6), 0.3), (1e-6, 1e-6))
    motion = ((4e-6, -7e-6), 20.0, True)
    other_pixel = (1.1e-6, 1.2e-6)
    second = rc.Surface(map_on_points((90, 110), other_pixel, 1.1), other_pixel)
    one, two = placement.match_grids(first, second, *motion)
    got = solve(one, counter_surface=two, load=0.2)
    independent.assert_solved(got, 0.2)
    # The sum of both on the grid of the first.
    (row,), (column,) = np.nonzero(first.heights == one.heights[0, 0])
    part = np.s_[row : row + one.shape[0], column : column + one.shape[1]]
    exact = rc.Surface(map_on_points(first.shape, first.pixel, 1.1, *motion)[part], first.pixel)
    # 17 points a wave: a cubic spline is off by (2π/17)⁴/384 = 5e-5 of the amplitude.
    assert np.abs(two.heights - exact.heights).max() < 3e-11
    expected = solve(one, counter_surface=exact, load=0.2)
    assert misfit(got.pressure, expected.pressure) < 1e-3
    assert got.approach == pytest.approx(expected.approach, rel=1e-3)
    assert got.contact_fraction == pytest.approx(expected.contact_fraction, rel=0.01)
    # Not by chance: another angle is another contact.
    one, two = placement.match_grids(first, second, motion[0], 25.0, True)
    wrong = solve(one, counter_surface=two, load=0.2)
    assert abs(wrong.approach / expected.approach - 1) > 0.01
