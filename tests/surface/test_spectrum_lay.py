"""Direction of the lay, Std."""

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.surface.spectrum import lay_direction

Y, X = np.mgrid[:128, :128].astype(float)
PIXEL = 1.0, 1.0


def difference(first: float, second: float) -> float:
    return abs((first - second + 90) % 180 - 90)


def rough(
    lay: float,
    aspect: float,
    pixel: tuple[float, float],
    points: int = 256,
    reach: float = 0.15,
    seed: int = 3,
) -> np.ndarray:
    """Return part of a Gaussian map whose spectrum is stretched across the lay."""
    noise = np.random.default_rng(seed).normal(size=(512, 512))
    # As drawn, row 0 on top: y against the rows.
    qy, qx = -np.fft.fftfreq(512, pixel[0])[:, None], np.fft.fftfreq(512, pixel[1])[None]
    cosine, sine = np.cos(np.radians(lay)), np.sin(np.radians(lay))
    along, across = qx * cosine + qy * sine, qy * cosine - qx * sine
    q = np.hypot(across, along / aspect)
    spectrum = np.where(q < reach, (q**2 + 0.03**2) ** -0.9, 0.0)
    return np.fft.ifft2(np.fft.fft2(noise) * spectrum).real[:points, :points]


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


@pytest.mark.parametrize(
    ("points", "aspect", "limit"), [(64, 0.1, 1.0), (64, 0.3, 1.3), (128, 0.3, 0.8)]
)
def test_lay_direction_of_small_maps(points: int, aspect: float, limit: float) -> None:
    errors = [
        difference(lay_direction(rough(lay, aspect, PIXEL, points, 0.4, seed), PIXEL), lay)
        for lay in (0, 30, 60, 120)
        for seed in range(3)
    ]
    assert np.sqrt(np.mean(np.square(errors))) < limit


@pytest.mark.parametrize("lay", [20.0, 70.0])
def test_lay_direction_of_honed_map_is_one_of_both(lay: float) -> None:
    for seed in range(2):
        surface = rc.generate(
            (128, 128),
            (1e-6, 1e-6),
            Sq=1e-6,
            rolloff_wavelength=2e-5,
            honing=60.0,
            lay=lay,
            rng=seed,
        )
        found = lay_direction(surface.heights, surface.pixel)
        assert min(difference(found, lay + 30), difference(found, lay - 30)) < 1.5


def test_lay_direction_of_crossed_grooves_is_that_of_the_deeper() -> None:
    heights = np.sin(0.8 * (X + Y)) + 0.7 * np.sin(0.8 * (X - Y))
    assert difference(lay_direction(heights, (1.0, 1.0)), 45) < 1.0


def test_lay_direction_of_flat_map_is_not_defined() -> None:
    assert np.isnan(lay_direction(np.ones((16, 16)), (1.0, 1.0)))
    assert np.isnan(lay_direction(np.eye(3), (1.0, 1.0)))
