"""Contacts that repeat along one axis: plane strain, images, waves, and both neighbours."""

import math

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.halfspace import kernels
from roughcontact.halfspace.boundary import Boundary

STEEL = rc.Material(210e9, 0.3)
MODULUS = 210e9 / 0.91
RADIUS = 0.01
# Load per length [N/m] of the cylinder, its half width and its peak pressure: line Hertz.
LINE = 1e5
HALF_WIDTH = math.sqrt(4 * LINE * RADIUS / (math.pi * MODULUS))
PEAK = 2 * LINE / (math.pi * HALF_WIDTH)


def cylinder(pixels, shape, ratio=1.0):
    """A cylinder along x with so many pixels to the contact width; dx = ratio dy."""
    dy = 2 * HALF_WIDTH / pixels
    y = (np.arange(shape[0]) - (shape[0] - 1) / 2) * dy
    heights = np.repeat(-(y**2)[:, None] / (2 * RADIUS), shape[1], axis=1)
    return rc.Surface(heights, (dy, ratio * dy))


def transposed(surface):
    return rc.Surface(np.ascontiguousarray(surface.heights.T), surface.pixel[::-1])


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
    # However long the period, and whatever the aspect of the pixels.
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
    # Nothing tells one column from another.
    spread = np.ptp(result.pressure, axis=1).max()
    assert spread <= 1e-8 * PEAK
    datum = max(surface.size)
    assert result.approach == pytest.approx(approach_of_hertz(LINE, datum), rel=2e-4)


def test_neither_free_nor_periodic_is_line_hertz():
    surface = cylinder(32, (128, 128))
    assert solve_strip(surface).max_pressure == pytest.approx(PEAK, rel=6e-4)
    load = LINE * surface.size[1]
    free = solve_strip(surface, "free", load=load)
    # Rigid ends: the more pixels the higher.
    assert free.max_pressure > 3 * PEAK
    assert solve_strip(surface, "periodic", load=load).max_pressure > 1.01 * PEAK


def test_the_peak_converges_with_the_square_of_the_pixel():
    pixels = np.array([16, 24, 36, 54])
    errors = [1 - solve_strip(cylinder(n, (2 * n, 4))).max_pressure / PEAK for n in pixels]
    order = -np.polyfit(np.log(pixels), np.log(errors), 1)[0]
    assert order == pytest.approx(2, abs=0.05)


def test_approach_between_two_loads_is_that_of_plane_strain():
    surface = cylinder(64, (128, 8))
    datum = max(surface.size)
    more, less = (solve_strip(surface, line=line).approach for line in (LINE, LINE / 2))
    expected = approach_of_hertz(LINE, datum) - approach_of_hertz(LINE / 2, datum)
    # At half the load 45 pixels: 0.02 % each, about half as much on the difference.
    assert more - less == pytest.approx(expected, rel=2e-4)


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


def test_a_flat_strip_is_the_punch_of_plane_strain():
    # Sadowsky (Johnson 1985, eq. 2.64): p = W'/(π √(a² - y²)).
    ny, pixel = 256, 1e-6
    result = solve_strip(rc.Surface(np.zeros((ny, 6)), (pixel, pixel)))
    a = ny * pixel / 2
    edges = np.arange(ny + 1) * pixel - a
    mean = LINE / math.pi * np.diff(np.arcsin(np.clip(edges / a, -1, 1))) / pixel
    middle = slice(ny // 8, -ny // 8)
    # First order at the singular edge: half a percent at this distance from it.
    np.testing.assert_allclose(result.pressure[middle, 0], mean[middle], rtol=5e-3)
    expected = 2 * LINE / (math.pi * MODULUS) * math.log(2 * ny * pixel / a)
    assert result.approach == pytest.approx(expected, rel=2e-3)


def test_images_of_loves_kernel_add_up_to_the_strip(independent):
    # Love's pixel at all its places on a long free map, one wave along x after the other. A
    # pixel holds its waves q + 2πk/dx as well, in the proportion sin(q dx/2)/(q dx/2).
    (ny, nx), (dy, dx), modulus, images, aliases = (6, 8), (0.5, 0.7), 3.0, 1000, 256
    y, x = np.arange(ny)[:, None, None] * dy, np.arange(nx)[:, None] * dx
    places = np.arange(-images, images + 1) * nx * dx
    love = independent.love_coefficients(y, x + places, (dy, dx), modulus).sum(axis=-1)
    found = np.fft.fft(love, axis=1).real
    table = kernels.strip((ny, nx * aliases), (dy, dx / aliases), modulus, 10.0)
    for wave in range(nx // 2 + 1):
        waves = wave + nx * np.arange(-aliases // 2 + 1, aliases // 2)
        expected = table[:, np.abs(waves)] @ np.sinc(waves / nx)
        difference = found[:, wave] - expected
        if wave == 0:
            # The sum over ever more images grows without bound, alike everywhere.
            difference -= difference[-1]
        # Images left out, and waves: both fall with the square of their number.
        np.testing.assert_allclose(difference, 0, atol=1e-7 * found[0, 1])


@pytest.mark.parametrize("wave", [1, 3, 6])
def test_waves_along_the_strip(wave):
    # Far from the ends across, a pressure cos(qx) displaces by 2/(E* q) of itself.
    ny, nx, pixel, modulus = 400, 12, (0.3, 0.5), 3.0
    pressure = np.ones((ny, 1)) * np.cos(2 * np.pi * wave * np.arange(nx) / nx)
    moved = Boundary.PERIODIC_X.operator((ny, nx), pixel, modulus)(pressure)
    q = 2 * np.pi * wave / (nx * pixel[1])
    # The ends are 60 m away: exp(-q · 60 m) < 1e-27.
    np.testing.assert_allclose(
        moved[ny // 2], 2 / (modulus * q) * pressure[0], atol=1e-13 * moved.max()
    )
    # At an end it is half of that.
    ratio = moved[0, 0] / moved[ny // 2, 0]
    assert 0.5 < ratio < 0.9
    assert moved[-1, 0] == pytest.approx(moved[0, 0], rel=1e-12)


def test_periodic_x_is_periodic_y_of_the_transposed_map():
    rng = np.random.default_rng(0)
    heights = np.cumsum(np.cumsum(rng.standard_normal((48, 80)), 0), 1)
    surface = rc.Surface(1e-7 * heights / heights.std(), (2e-7, 3e-7))
    options = {"ceiling": 3e9, "load": 5e8 * surface.size[0] * surface.size[1]}
    along_x = solve_strip(surface, "periodic-x", **options)
    along_y = solve_strip(transposed(surface), "periodic-y", **options)
    np.testing.assert_allclose(
        along_x.pressure, along_y.pressure.T, rtol=0, atol=1e-7 * along_x.max_pressure
    )
    assert along_x.approach == pytest.approx(along_y.approach, rel=1e-8)
    # And it is another contact than that of the same map along the other axis.
    other = solve_strip(surface, "periodic-y", **options)
    assert np.abs(other.pressure - along_x.pressure).max() > 0.1 * along_x.max_pressure


def test_the_middle_of_a_wide_strip_is_a_periodic_contact():
    # Grooves across the strip: in its middle each groove is pressed as one of an endless
    # surface under the mean pressure there, and leaves the same mean gap.
    nx, ny, pixel, height = 64, 512, 1e-6, 0.05e-6
    x = (np.arange(nx) + 0.5) / nx
    heights = np.tile(height * np.cos(2 * np.pi * x), (ny, 1))
    closing = math.pi * MODULUS * height / (nx * pixel)
    load = 0.4 * closing * ny * nx * pixel**2
    wide = solve_strip(rc.Surface(heights, (pixel, pixel)), load=load)
    middle = wide.pressure[ny // 2]
    assert 0.2 * closing < middle.mean() < 0.35 * closing
    period = solve_strip(
        rc.Surface(heights[:nx], (pixel, pixel)), "periodic", load=middle.mean() * (nx * pixel) ** 2
    )
    # The mean pressure changes across the strip: some (wavelength/width)².
    np.testing.assert_allclose(middle, period.pressure[0], rtol=0, atol=1e-3 * middle.max())
    assert wide.gap[ny // 2].mean() == pytest.approx(period.gap[0].mean(), rel=1e-3)


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
