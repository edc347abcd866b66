"""The order at which the grid converges."""

import math

import numpy as np
import pytest

import roughcontact as rc
from roughcontact import analytic, convolution, generate, hertz

MODULUS = 230e9


def order(pixels: list[float], errors: list[float]) -> float:
    return float(np.polyfit(np.log(pixels), np.log(errors), 1)[0])


@pytest.mark.parametrize("aspect", [1, 3])
def test_displacement_of_a_smooth_pressure_is_of_second_order(aspect: int) -> None:
    # p = exp(-r²/w²) displaces its middle by √π w/E*; its tail at 6 w is e^(-36).
    width, errors, pixels = 1.0, [], []
    for points in (97, 145, 193, 289, 385):
        nx, ny = points, aspect * (points - 1) + 1
        dx, dy = 12 * width / (nx - 1), 12 * width / (ny - 1)
        y, x = (np.arange(ny) - ny // 2) * dy, (np.arange(nx) - nx // 2) * dx
        pressure = np.exp(-(y[:, None] ** 2 + x**2) / width**2)
        operator = convolution.free((ny, nx), (dy, dx), MODULUS, workers=1)
        found = operator(pressure)[ny // 2, nx // 2]
        errors.append(abs(found / (math.sqrt(math.pi) * width / MODULUS) - 1))
        pixels.append(dx)
    # The order nears 2 from below: 1.92 between 97 and 193 points, 1.96 from there to 385.
    assert order(pixels, errors) == pytest.approx(2, abs=0.1)


def test_mean_gap_of_a_wave_converges() -> None:
    # Westergaard at half of the full contact pressure; the rim moves by fractions of a pixel, so
    # that single steps jump: the trend over five grids is of about order 1.5 or better.
    wavelength, amplitude = 1e-4, 1e-7
    full = analytic.wavy_full_contact_pressure(amplitude, wavelength, 210e9 / 0.91)
    exact = analytic.wavy_mean_gap(0.5 * full, full, amplitude)
    pixels, errors = [], []
    for points in (32, 64, 128, 256, 512):
        pixel = (wavelength / 4, wavelength / points)
        heights = generate.wavy((4, points), pixel, amplitude, wavelength)
        load = 0.5 * full * wavelength**2
        result = rc.solve(
            rc.Surface(heights, pixel), load=load, material=rc.Material(210e9, 0.3),
            boundary="periodic", tolerance=1e-10,
        )  # fmt: skip
        pixels.append(pixel[1])
        errors.append(abs(result.mean_gap / exact - 1))
    assert errors[-1] < 1e-3
    assert order(pixels, errors) > 1.3


def test_approach_of_a_ball_converges() -> None:
    radius, load, side = 0.01, 1.0, 1.2e-4
    exact = hertz.approach(load, radius, 210e9 / 0.91)
    pixels, errors = [], []
    for points in (33, 65, 129, 257):
        pixel = (side / points, side / points)
        heights = generate.paraboloid((points, points), pixel, radius)
        result = rc.solve(
            rc.Surface(heights, pixel), load=load, material=rc.Material(210e9, 0.3),
            tolerance=1e-10,
        )  # fmt: skip
        pixels.append(pixel[0])
        errors.append(abs(result.approach / exact - 1))
    assert errors[-1] < 2e-4
    assert order(pixels, errors) > 1.3
