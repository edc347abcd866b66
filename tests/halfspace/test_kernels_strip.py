"""Contacts that repeat along one axis: plane strain, images, waves, and both neighbours."""

import math

import numpy as np
import pytest

import roughcontact as rc

STEEL = rc.Material(210e9, 0.3)
MODULUS = 210e9 / 0.91
RADIUS = 0.01
# Load per length [N/m] of the cylinder, its half width and its peak pressure: line Hertz.
LINE = 1e5
HALF_WIDTH = math.sqrt(4 * LINE * RADIUS / (math.pi * MODULUS))
PEAK = 2 * LINE / (math.pi * HALF_WIDTH)


def cylinder(pixels, shape, ratio=1.0):
    """A cylinder along x with a number of pixels to the contact width; dx = ratio dy."""
    dy = 2 * HALF_WIDTH / pixels
    y = (np.arange(shape[0]) - (shape[0] - 1) / 2) * dy
    heights = np.repeat(-(y**2)[:, None] / (2 * RADIUS), shape[1], axis=1)
    return rc.Surface(heights, (dy, ratio * dy))


def solve_strip(surface, boundary="periodic-x", line=LINE, **options):
    options = {"material": STEEL, "ceiling": None, "tolerance": 1e-9, **options}
    length = surface.size[1 if boundary == "periodic-x" else 0]
    if "approach" not in options and "load" not in options:
        options["load"] = line * length
    return rc.solve(surface, boundary=boundary, **options)


def approach_of_hertz(line, datum):
    """Rigid cylinder: the displacement in the middle of a semi-ellipse of pressure.

    u = 2/(π E*) ∫ p ln(datum/|y|) dy (Johnson 1985, secs. 2.2 and 4.2(c)).
    """
    half_width = math.sqrt(4 * line * RADIUS / (math.pi * MODULUS))
    return line / (math.pi * MODULUS) * (2 * math.log(2 * datum / half_width) + 1)


@pytest.mark.parametrize(
    ("shape", "ratio"), [((128, 4), 1.0), ((128, 96), 1.0), ((128, 300), 1.0), ((96, 7), 3.0)]
)
def test_a_cylinder_is_line_hertz(shape, ratio):
    # However long the period, and for any aspect of the pixels.
    surface = cylinder(64, shape, ratio)
    result = solve_strip(surface)
    # The error falls with the square of the pixel: 0.013 % here.
    assert result.max_pressure == pytest.approx(PEAK, rel=2e-4)
    half_width = np.count_nonzero(result.pressure[:, 0]) * surface.pixel[0] / 2
    assert half_width == pytest.approx(HALF_WIDTH, abs=0.51 * surface.pixel[0])
    y = (np.arange(shape[0]) - (shape[0] - 1) / 2) * surface.pixel[0]
    profile = PEAK * np.sqrt(np.maximum(0, 1 - (y / HALF_WIDTH) ** 2))
    inner = np.abs(y) < 0.9 * HALF_WIDTH
    np.testing.assert_allclose(result.pressure[inner, 0], profile[inner], rtol=1e-3)
    # All columns are equal.
    spread = np.ptp(result.pressure, axis=1).max()
    assert spread <= 1e-8 * PEAK
    datum = max(surface.size)
    assert result.approach == pytest.approx(approach_of_hertz(LINE, datum), rel=2e-4)


def test_approach_control_and_stiffness_of_a_line():
    surface = cylinder(64, (128, 8))
    loaded = solve_strip(surface)
    moved = solve_strip(surface, approach=loaded.approach)
    assert moved.load == pytest.approx(loaded.load, rel=1e-8)
    # dω/dW' of the closed form; a punch of whole pixels is up to half a pixel too wide.
    line_stiffness = math.pi * MODULUS / (2 * math.log(2 * max(surface.size) / HALF_WIDTH))
    assert loaded.stiffness() == pytest.approx(line_stiffness * surface.size[1], rel=5e-3)


def test_a_ceiling_on_a_line():
    # Full plasticity of a strip: all pixels that touch at the ceiling carry the load.
    surface = cylinder(32, (256, 6))
    result = solve_strip(surface, ceiling=0.3 * PEAK, load=LINE * surface.size[1])
    assert result.max_pressure == 0.3 * PEAK
    assert result.saturated_fraction > 0.8 * result.contact_fraction
    # Certified: what sinks in sinks in everywhere at the ceiling.
    assert result.gap[result.saturated].max() <= 1e-12
    assert result.residual_indentation.max() > 0


@pytest.mark.parametrize("boundary", ["periodic-x", "periodic-y"])
@pytest.mark.parametrize("ceiling", [None, 1.5e9])
@pytest.mark.parametrize("precision", ["double", "single"])
def test_rough_strips_pass_the_independent_judge(independent, boundary, ceiling, precision):
    rng = np.random.default_rng(3)
    heights = np.cumsum(np.cumsum(rng.standard_normal((70, 129)), 0), 1)
    surface = rc.Surface(1e-7 * heights / heights.std(), (2e-7, 3e-7))
    load = 3e8 * surface.size[0] * surface.size[1]
    result = rc.solve(
        surface, material=STEEL, load=load, ceiling=ceiling, boundary=boundary, precision=precision
    )
    independent.assert_solved(result, load, 1e-6 if precision == "double" else 1e-4)
