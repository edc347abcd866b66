"""Direction of the lay, Std."""

import numpy as np
import pytest

from roughcontact.surface.spectrum import lay_direction

Y, X = np.mgrid[:128, :128].astype(float)


def difference(first: float, second: float) -> float:
    return abs((first - second + 90) % 180 - 90)


def rough(lay: float, aspect: float, pixel: tuple[float, float]) -> np.ndarray:
    """Return part of a Gaussian map whose spectrum is stretched across the lay."""
    noise = np.random.default_rng(3).normal(size=(512, 512))
    # As drawn, row 0 on top: y against the rows.
    qy, qx = -np.fft.fftfreq(512, pixel[0])[:, None], np.fft.fftfreq(512, pixel[1])[None]
    cosine, sine = np.cos(np.radians(lay)), np.sin(np.radians(lay))
    along, across = qx * cosine + qy * sine, qy * cosine - qx * sine
    q = np.hypot(across, along / aspect)
    spectrum = np.where(q < 0.15, (q**2 + 0.03**2) ** -0.9, 0.0)
    return np.fft.ifft2(np.fft.fft2(noise) * spectrum).real[:256, :256]


@pytest.mark.parametrize("lay", [0, 30, 60, 90, 120, 145.3])
def test_lay_direction_of_grooves(lay: float) -> None:
    # A groove runs along the lay: to the right, and upwards against the rows.
    across = X * np.sin(np.radians(lay)) + Y * np.cos(np.radians(lay))
    rng = np.random.default_rng(1)
    for wave in (4.3, 11.0, 25.0):
        heights = np.sin(2 * np.pi * across / wave) + 0.2 * rng.normal(size=X.shape) + 0.01 * X
        assert difference(lay_direction(heights, (1.0, 1.0)), lay) < 1.0
        heights[20:30, 40:70] = np.nan
        assert difference(lay_direction(heights, (1.0, 1.0)), lay) < 1.0


@pytest.mark.parametrize("lay", [0, 30, 60, 120])
@pytest.mark.parametrize("pixel", [(1.0, 1.0), (1.0, 0.7)])
def test_lay_direction_of_random_roughness(lay: float, pixel: tuple[float, float]) -> None:
    assert difference(lay_direction(rough(lay, 0.1, pixel), pixel), lay) < 1.2


def test_lay_direction_of_crossed_grooves_is_that_of_the_deeper() -> None:
    heights = np.sin(0.8 * (X + Y)) + 0.7 * np.sin(0.8 * (X - Y))
    assert difference(lay_direction(heights, (1.0, 1.0)), 45) < 1.0


def test_lay_direction_of_flat_map_is_not_defined() -> None:
    assert np.isnan(lay_direction(np.ones((16, 16)), (1.0, 1.0)))
    assert np.isnan(lay_direction(np.eye(3), (1.0, 1.0)))
