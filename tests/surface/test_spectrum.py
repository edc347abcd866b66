import math

import numpy as np
import pytest

from maps import gaussian_map
from roughcontact.errors import InputError
from roughcontact.surface import spectrum, surface


@pytest.mark.parametrize(("shape", "holes"), [((9, 12), 0.0), ((8, 5), 0.3), ((13, 6), 0.5)])
def test_autocorrelation_against_its_definition(shape: tuple[int, int], holes: float) -> None:
    rng = np.random.default_rng(5)
    heights = 1e3 + rng.normal(size=shape)
    heights[rng.random(shape) < holes] = np.nan
    z = heights - np.nanmean(heights)
    function = spectrum.autocorrelation(heights)
    ny, nx = shape
    assert function.shape == (2 * (ny // 2) + 1, nx // 2 + 1)
    for j in range(-(ny // 2), ny // 2 + 1):
        for i in range(nx // 2 + 1):
            here = z[max(0, -j) : ny - max(0, j), : nx - i]
            there = z[max(0, j) : ny - max(0, -j), i:]
            expected = np.nanmean(here * there) / np.nanmean(z * z)
            assert function[j + ny // 2, i] == pytest.approx(expected, abs=1e-10)


def test_autocorrelation_without_pairs_is_unknown() -> None:
    heights = np.full((8, 8), np.nan)
    heights[:2] = np.random.default_rng(6).normal(size=(2, 8))
    function = spectrum.autocorrelation(heights)
    assert np.isnan(function[[0, 1, 2, 6, 7, 8]]).all()
    assert np.isfinite(function[3:6]).all()


def test_correlation_lengths_of_a_cosine() -> None:
    # Forty periods: the overlap holds no whole number of them, an error of 1/(2π·2·40) = 0.2 %.
    wave = np.cos(2 * np.pi * np.arange(2000)[:, None] / 50) + np.zeros((1, 8))
    fastest, _, _ = spectrum.texture(wave, (2e-6, 5e-6))
    assert fastest == pytest.approx(100e-6 * math.acos(0.2) / (2 * math.pi), rel=5e-3)
    values = surface.summary(wave, (2e-6, 5e-6))
    assert values["Sal"] == fastest
    # Along the grooves nothing decays within the four points of half the map.
    assert math.isnan(values["Str"])
    assert values["Str_max"] <= 1


def test_a_texture_that_the_map_is_too_short_for_is_not_determined() -> None:
    # Hills longer than half the map: nothing decays along them on it.
    heights = gaussian_map((64, 640), (24.0, 3.0), seed=5)
    Sal, Str, largest = spectrum.texture(heights, (1.0, 1.0))
    assert math.isfinite(Sal)
    assert math.isnan(Str)
    # Along y the function stays above the threshold over the 32 points of half the map.
    assert Sal / 60 < largest <= Sal / 32 < 1
    assert surface.summary(heights, (1.0, 1.0))["Str_max"] == largest
    # The whole of a map that shows it is below the bound.
    longer = gaussian_map((640, 640), (24.0, 3.0), seed=5)
    _, whole, same = spectrum.texture(longer, (1.0, 1.0))
    assert whole == same < largest


def test_correlation_lengths_of_ridges_on_unequal_pixels() -> None:
    heights = gaussian_map((600, 600), (24.0, 3.0), seed=1)
    pixel = (0.5e-6, 1e-6)
    fastest, ratio, _ = spectrum.texture(heights, pixel)
    unit = 2 * math.sqrt(math.log(5))
    assert fastest == pytest.approx(3e-6 * unit, rel=0.06)
    # Along the ridges there are only some ten independent lengths times a hundred ridges.
    assert fastest / ratio == pytest.approx(12e-6 * unit, rel=0.15)


def test_correlation_lengths_of_oblique_ridges() -> None:
    y, x = np.mgrid[:512, :512]
    across = (2 * x + y) / math.sqrt(5)
    heights = np.interp(across, np.arange(-10, 1000), gaussian_map((1, 1010), (0.0, 4.0))[0])
    fastest, ratio, _ = spectrum.texture(heights, (1.0, 1.0))
    # One line of about 50 independent ridges, hence the tolerance.
    assert fastest == pytest.approx(2 * 4 * math.sqrt(math.log(5)), rel=0.25)
    assert math.isnan(ratio)


def test_a_large_threshold_is_met_sooner() -> None:
    heights = gaussian_map((200, 200), (4.0, 4.0))
    near = spectrum.texture(heights, (1.0, 1.0), threshold=0.5)
    far = spectrum.texture(heights, (1.0, 1.0), threshold=0.2)
    assert near[0] < far[0]
    with pytest.raises(InputError, match="threshold"):
        spectrum.texture(heights, (1.0, 1.0), threshold=1.0)


@pytest.mark.parametrize("shape", [(32, 48), (31, 48), (32, 47), (31, 45)])
def test_spectrum_holds_the_variance(shape: tuple[int, int]) -> None:
    heights = 5.0 + np.random.default_rng(10).normal(size=shape)
    pixel = (2e-6, 0.7e-6)
    q, C, waves = spectrum.radial_spectrum(heights, pixel)
    area = heights.size * pixel[0] * pixel[1]
    assert waves.sum() == heights.size - 1
    assert np.all(np.diff(q) > 0)
    assert np.sum(C * waves) / area == pytest.approx(heights.var(), rel=1e-12)


def test_spectrum_of_a_wave_is_one_shell() -> None:
    y, x = np.mgrid[:40, :60]
    heights = 2.0 * np.cos(2 * np.pi * (3 * y / 40 + 4 * x / 60))
    q, C, waves = spectrum.radial_spectrum(heights, (1.5, 1.0))
    top = int(np.argmax(C))
    assert q[top] * 60 / (2 * np.pi) == pytest.approx(5, abs=0.5)
    # Two of the wave vectors in the shell carry A²/4 each, times the area.
    assert C[top] * waves[top] == pytest.approx(2 * 60 * 60, rel=1e-9)


def test_spectrum_of_map_with_holes_raises_input_error() -> None:
    heights = np.ones((4, 4))
    heights[1, 2] = np.nan
    with pytest.raises(InputError, match=r"1 missing points; fill or crop.*filled\(\)"):
        spectrum.radial_spectrum(heights, (1.0, 1.0))


@pytest.mark.parametrize(("decay", "threshold"), [(0.24, 0.2), (0.22, 0.5), (0.18, 0.8)])
def test_correlation_lengths_are_those_of_the_transposed_map(
    decay: float, threshold: float
) -> None:
    # The slowest decay is met within the last of the eight lags along y.
    y, x = np.mgrid[:16, :32]
    heights = np.cos(decay * (y - 7.5)) * np.cos(0.9 * x)
    heights -= heights.mean()
    fastest, ratio, largest = spectrum.texture(heights, (1.0, 1.3), threshold)
    turned = spectrum.texture(heights.T, (1.3, 1.0), threshold)
    assert 7 < fastest / ratio < 8
    assert turned == pytest.approx((fastest, ratio, largest), rel=1e-9)
