"""Profiles: contacts in plane strain against line Hertz, Westergaard, and uniform maps."""

import math

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.theory import waves

STEEL = rc.Material(210e9, 0.3)
MODULUS = 210e9 / 0.91
RADIUS = 0.01
# Load per length [N/m] of a cylinder, its half width and its peak pressure: line Hertz.
LINE = 1e5
HALF_WIDTH = math.sqrt(4 * LINE * RADIUS / (math.pi * MODULUS))
PEAK = 2 * LINE / (math.pi * HALF_WIDTH)
# A wave and the pressure that closes it.
AMPLITUDE, WAVELENGTH = 1e-7, 1e-4
CLOSING = math.pi * MODULUS * AMPLITUDE / WAVELENGTH


def cylinder(points, sides=3.0):
    """The profile of a cylinder over a number of half widths."""
    spacing = sides * HALF_WIDTH / points
    x = (np.arange(points) - (points - 1) / 2) * spacing
    return x, rc.Surface(-(x**2) / (2 * RADIUS), spacing)


def solve_profile(surface, **options):
    return rc.solve(
        surface, **{"material": STEEL, "ceiling": None, "tolerance": 1e-9, "load": LINE, **options}
    )


def hertz(x):
    return PEAK * np.sqrt(np.maximum(0, 1 - (x / HALF_WIDTH) ** 2))


def test_a_cylinder_is_line_hertz():
    x, surface = cylinder(4096)
    result = solve_profile(surface)
    assert result.pressure.shape == (1, 4096)
    assert result.max_pressure == pytest.approx(PEAK, rel=1e-6)
    # Where the pressure rises steeply it differs most: within a pixel of the rim.
    np.testing.assert_allclose(result.pressure[0], hertz(x), atol=1e-2 * PEAK)
    error = math.sqrt(np.mean((result.pressure[0] - hertz(x)) ** 2)) / PEAK
    assert error < 1e-4
    assert result.contact_area == pytest.approx(2 * HALF_WIDTH, abs=2 * surface.pixel[1])
    assert result.pressure.sum() * surface.pixel[1] == pytest.approx(LINE, rel=1e-10)


@pytest.mark.parametrize("sides", [9.0, 18.0])
def test_row_of_cylinders_has_higher_peak_pressure(sides):
    # The kernel -ln|2 sin(πx/L)| is -ln|2πx/L| + (πx/L)²/6: the neighbors add curvature.
    _, surface = cylinder(2048, sides)
    found = solve_profile(surface, boundary="periodic").max_pressure
    assert found / PEAK - 1 == pytest.approx(math.pi**2 / (12 * sides**2), rel=0.02)


def test_the_approach_counts_from_the_length_of_the_profile():
    # A line load displaces nothing at that distance: u = 2 w/(π E*) ln(L/|x|).
    for sides in (3.0, 12.0):
        # A point on the summit: there the approach begins.
        _, surface = cylinder(2047, sides)
        length = surface.size[1]
        expected = LINE / (math.pi * MODULUS) * (2 * math.log(2 * length / HALF_WIDTH) + 1)
        assert solve_profile(surface).approach == pytest.approx(expected, rel=1e-6)
    # The same pressures follow from it.
    again = solve_profile(surface, load=None, approach=expected)
    assert again.load == pytest.approx(LINE, rel=1e-6)


def test_the_stiffness_is_that_of_a_strip_seen_from_the_length():
    # A rigid flat strip: p = w/(π √(a² - x²)) sinks by 2 w/(π E*) ln(2 L/a).
    _, surface = cylinder(4096)
    expected = math.pi * MODULUS / (2 * math.log(2 * surface.size[1] / HALF_WIDTH))
    assert solve_profile(surface).stiffness() == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("part", [0.05, 0.3, 0.8])
def test_a_wave_is_westergaard(part):
    points = 4096
    x = np.arange(points) * WAVELENGTH / points
    surface = rc.Surface(AMPLITUDE * np.cos(2 * np.pi * x / WAVELENGTH), WAVELENGTH / points)
    mean = part * CLOSING
    result = solve_profile(surface, load=mean * WAVELENGTH, boundary="periodic")
    pressure = waves.wavy_pressure(x, mean, CLOSING, WAVELENGTH)
    error = np.sqrt(np.mean((result.pressure[0] - pressure) ** 2)) / pressure.max()
    assert error < 1e-4
    assert result.max_pressure == pytest.approx(pressure.max(), rel=1e-5)
    width = 2 * waves.wavy_half_width(mean, CLOSING, WAVELENGTH)
    assert result.contact_area == pytest.approx(width, abs=2 * surface.pixel[1])
    gap = waves.wavy_mean_gap(mean, CLOSING, AMPLITUDE)
    assert result.mean_gap == pytest.approx(gap, rel=1e-4)


def test_a_wave_in_full_contact_is_exact():
    points = 64
    x = np.arange(points) * WAVELENGTH / points
    surface = rc.Surface(AMPLITUDE * np.cos(2 * np.pi * x / WAVELENGTH), WAVELENGTH / points)
    result = solve_profile(surface, load=1.5 * CLOSING * WAVELENGTH, boundary="periodic")
    expected = CLOSING * (1.5 + np.cos(2 * np.pi * x / WAVELENGTH))
    np.testing.assert_allclose(result.pressure[0], expected, rtol=1e-8)
    assert result.contact_fraction == 1


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_profile_matches_extruded_map(boundary):
    heights = 1e-7 * np.random.default_rng(4).standard_normal(192)
    spacing, rows = 2e-6, 5
    profile = solve_profile(rc.Surface(heights, spacing), load=2e3, boundary=boundary)
    beyond = {"free": "periodic-y", "periodic": "periodic"}[boundary]
    surface = rc.Surface(np.tile(heights, (rows, 1)), (spacing, spacing))
    wide = solve_profile(surface, load=2e3 * rows * spacing, boundary=beyond)
    np.testing.assert_allclose(profile.pressure[0], wide.pressure[2], atol=1e-8 * wide.max_pressure)
    assert profile.approach == pytest.approx(wide.approach, rel=1e-8)
    assert profile.stiffness() * rows * spacing == pytest.approx(wide.stiffness(), rel=1e-5)


def test_a_ceiling_is_three_yield_strengths_and_keeps_the_load():
    _, surface = cylinder(1024)
    steel = rc.Material(210e9, 0.3, yield_strength=PEAK / 4.5)
    result = solve_profile(surface, material=steel, ceiling="auto")
    assert result.max_pressure == result.ceiling == pytest.approx(PEAK / 1.5)
    assert result.pressure.sum() * surface.pixel[1] == pytest.approx(LINE, rel=1e-10)
    # In plane strain too, the saturated part is in the middle and the contact is wider.
    assert result.saturated[0, 512]
    assert result.contact_area > 2 * HALF_WIDTH


def test_first_yield_is_that_of_a_cylinder():
    # Largest von Mises stress on the axis below a line contact (McEwen 1949; Johnson 1985, (4.46)).
    z = np.linspace(0, 3, 30001)
    root = np.sqrt(1 + z**2)
    along, down = 2 * z - (1 + 2 * z**2) / root, -1 / root
    for ratio in (0.0, 0.1, 0.25, 0.3, 0.45):
        across = ratio * (along + down)
        squares = (along - across) ** 2 + (across - down) ** 2 + (down - along) ** 2
        expected = 1 / math.sqrt(float(squares.max()) / 2)
        steel = rc.Material(210e9, ratio, yield_strength=1.0)
        assert steel.line_yield_pressure == pytest.approx(expected, rel=2e-3)
    # 1.79 yield strengths at ν = 0.3, where a sphere has 1.62: between the two it is elastic.
    _, surface = cylinder(512)
    for part, regime in ((1.7, "below first yield"), (1.9, "yielding below the surface")):
        steel = rc.Material(210e9, 0.3, yield_strength=PEAK / part)
        assert solve_profile(surface, material=steel).regime == regime


def test_map_options_raise_input_error_for_profile():
    _, surface = cylinder(128)
    result = solve_profile(surface)
    steel = rc.Material(210e9, 0.3, 1e9)
    for ask, what in (
        (lambda: solve_profile(surface, moments=(0, 0)), "a tilt"),
        (
            lambda: solve_profile(surface, material=steel, ceiling="calibrated"),
            "a calibrated ceiling",
        ),
        (lambda: rc.history(surface, [LINE], material=steel), "a load history"),
        (lambda: rc.find_load(surface, material=steel, contact_fraction=0.1), "a search of loads"),
        (lambda: rc.resolution_study(surface, material=steel, load=LINE), "a study"),
        (lambda: rc.solve_elastoplastic(surface, material=steel, loads=[LINE]), "plasticity"),
        (lambda: surface.rotated(90), "a quarter turn"),
        (lambda: surface.aligned(surface), "alignment"),
    ):
        with pytest.raises(rc.InputError, match=f"surface is a profile; {what}.* needs a map"):
            ask()
    with pytest.raises(rc.InputError, match="line load with its unit"):
        solve_profile(surface, load="1 N")
    with pytest.raises(rc.CapacityError, match=r"1e\+09 N/m is more .* length of its valid pixels"):
        solve_profile(surface, ceiling=1e9, load="1e6 N/mm")
    assert result.converged
