"""Order of convergence with the grid, fitted on five or more grids."""

import math

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.surface import shapes
from roughcontact.theory import hertz, waves

STEEL = rc.Material(young=210e9, poisson=0.3)
MODULUS = 210e9 / 0.91
WAVELENGTH = 50e-6
AMPLITUDE = 0.2e-6
FULL = waves.wavy_full_contact_pressure(AMPLITUDE, WAVELENGTH, MODULUS)


def order(points, errors):
    return -np.polyfit(np.log(points), np.log(errors), 1)[0]


def strip(n, ratio):
    """Westergaard's wave on n points: errors of approach and pressure."""
    pixel = (WAVELENGTH / n, WAVELENGTH / n)
    surface = rc.Surface(shapes.wavy((2, n), pixel, AMPLITUDE, WAVELENGTH), pixel)
    mean = ratio * FULL
    result = rc.solve(
        surface,
        material=STEEL,
        load=mean * 2 * pixel[0] * WAVELENGTH,
        boundary="periodic",
        tolerance=1e-10,
    )
    approach = AMPLITUDE - waves.wavy_mean_gap(mean, FULL, AMPLITUDE)
    x = np.arange(n) * pixel[1]
    pressure = waves.wavy_pressure(x, mean, FULL, WAVELENGTH)
    return (
        abs(result.approach - approach) / AMPLITUDE,
        np.linalg.norm(result.pressure[0] - pressure) / np.linalg.norm(pressure),
    )


def test_a_smooth_periodic_contact_converges_with_the_square_of_the_pixel():
    # At half load the edges lie alike on every grid: no jumps. Measured 2.05, and 2.04 from 64 on.
    points = [32, 64, 128, 256, 512]
    approach, pressure = zip(*(strip(n, 0.5) for n in points), strict=True)
    assert order(points, approach) == pytest.approx(2, abs=0.1)
    assert order(points[1:], approach[1:]) == pytest.approx(2, abs=0.06)
    # The pressure falls like a root at the edges: half a pixel there is first order.
    assert order(points, pressure) == pytest.approx(1, abs=0.05)
    # The fit is one of errors, not of rounding.
    assert approach[-1] > 4e-8


@pytest.mark.parametrize("aspect", [1.0, 1.5])
def test_hertz_converges_with_the_square_of_the_pixel(aspect):
    load, radius = 5.0, 1e-2
    a = hertz.contact_radius(load, radius, MODULUS)
    points = [24, 32, 48, 64, 96, 128]
    errors = []
    for n in points:
        pixel = (3 * a / n * aspect, 3 * a / n)
        surface = rc.Surface(shapes.paraboloid((n, n), pixel, radius), pixel)
        result = rc.solve(surface, material=STEEL, load=load, tolerance=1e-9)
        # The summit is between four pixels, δ counts from the nearest.
        touch = (math.hypot(*pixel) / 2) ** 2 / (2 * radius)
        errors.append(abs((result.approach + touch) / hertz.approach(load, radius, MODULUS) - 1))
    # Measured 2.06 and 1.88: the area jumps by pixels.
    assert order(points, errors) == pytest.approx(2, abs=0.3)
    assert errors[-1] < 8e-5
