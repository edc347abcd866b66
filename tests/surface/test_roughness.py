import math

import numpy as np
import pytest
from scipy import integrate, stats

from roughcontact.errors import InputError
from roughcontact.surface import grid, roughness, spectrum


def test_rms_height_far_from_zero() -> None:
    # The naive mean of squares would return noise of order 1 here.
    heights = 1e8 + np.tile([-1.0, 1.0], (50, 50))
    assert roughness.rms_height(heights) == pytest.approx(1.0, rel=1e-12)


def test_rms_height_leaves_out_missing_points() -> None:
    rng = np.random.default_rng(1)
    heights = rng.normal(size=(30, 40))
    heights[rng.random(heights.shape) < 0.3] = np.nan
    there = heights[~np.isnan(heights)]
    assert roughness.rms_height(heights) == pytest.approx(there.std(), rel=1e-14)


def test_rms_gradient_counts_points_with_both_differences() -> None:
    heights = np.array([[0.0, 1.0, 5.0], [0.0, 2.0, np.nan], [0.0, 0.0, 0.0]])
    # Point (1, 1): 2 along x, 1 along y; (2, 1): 0 and -2; (1, 2) and (2, 2) lack a neighbour.
    assert roughness.rms_gradient(heights, (1.0, 1.0)) == pytest.approx(np.sqrt((5 + 4) / 2))


def test_blocks_do_not_change_the_result(monkeypatch: pytest.MonkeyPatch) -> None:
    heights = np.random.default_rng(2).normal(size=(37, 23))
    whole = roughness.rms_height(heights), roughness.rms_gradient(heights, (1.0, 2.0))
    monkeypatch.setattr(grid, "VALUES", 23 * 5)
    blocked = roughness.rms_height(heights), roughness.rms_gradient(heights, (1.0, 2.0))
    assert blocked == pytest.approx(whole, rel=1e-13)


@pytest.mark.parametrize(
    "heights", [np.full((3, 3), np.nan), np.array([[1.0, np.nan], [np.nan, 1.0]])]
)
def test_no_gradient_without_neighbours(heights: np.ndarray) -> None:
    with pytest.raises(InputError, match="gradient is undefined"):
        roughness.rms_gradient(heights, (1.0, 1.0))


def test_no_height_without_points() -> None:
    with pytest.raises(InputError, match="missing"):
        roughness.rms_height(np.full((3, 3), np.nan))


def test_height_parameters_of_a_wave() -> None:
    # Power sums over whole periods are exact up to the order of points per period; |cos| and the
    # crests need the limit of many points: 1024 leave an error of order (2π/1024)²/24 = 2e-6.
    wave = 3e-6 * np.cos(2 * np.pi * np.arange(4096) / 1024) + np.zeros((3, 1)) + 0.5
    values = roughness.height_parameters(wave)
    assert values["Sq"] == pytest.approx(3e-6 / math.sqrt(2), rel=1e-9)
    assert values["Sa"] == pytest.approx(2 * 3e-6 / math.pi, rel=1e-5)
    assert values["Ssk"] == pytest.approx(0, abs=1e-9)
    assert values["Sku"] == pytest.approx(1.5, rel=1e-9)
    assert values["Sp"] == pytest.approx(3e-6, rel=1e-9)
    assert values["Sv"] == pytest.approx(3e-6, rel=1e-9)
    assert values["Sz"] == values["Sp"] + values["Sv"] == pytest.approx(6e-6, rel=1e-9)


def test_height_parameters_against_scipy_with_holes() -> None:
    rng = np.random.default_rng(4)
    heights = rng.gamma(2.0, size=(70, 50))
    heights[rng.random(heights.shape) < 0.2] = np.nan
    there = heights[~np.isnan(heights)]
    values = roughness.height_parameters(heights)
    assert values["Ssk"] == pytest.approx(stats.skew(there), rel=1e-12)
    assert values["Sku"] == pytest.approx(stats.kurtosis(there, fisher=False), rel=1e-12)
    assert values["Sa"] == pytest.approx(np.abs(there - there.mean()).mean(), rel=1e-12)
    assert values["Sp"] == pytest.approx(there.max() - there.mean(), rel=1e-12)


@pytest.mark.parametrize("amplitude", [1e-9, 1e-2, 1.0, 20.0])
def test_gradient_and_developed_area_of_a_wave(amplitude: float) -> None:
    n, wavelength = 2048, 100.0
    dx = wavelength / n
    q = 2 * math.pi / wavelength
    wave = amplitude * np.cos(q * dx * np.arange(n + 1)) + np.zeros((2, 1))
    slope = amplitude * q
    # Differences shorten the slope by sinc(π/n): 4e-7.
    assert roughness.rms_gradient(wave, (3.0, dx)) == pytest.approx(slope / 2**0.5, rel=1e-6)
    exact = integrate.quad(lambda t: math.sqrt(1 + (slope * math.sin(t)) ** 2), 0, math.pi)[0]
    if slope > 0.1:
        expected = exact / math.pi - 1
        tolerance = 2e-6
    else:
        expected = slope**2 / 4  # to second order; the next is -3/64 slope⁴
        tolerance = 2e-6 + slope**2
    ratio = roughness.developed_area_ratio(wave, (3.0, dx))
    assert ratio == pytest.approx(expected, rel=tolerance, abs=0)


def test_developed_area_leaves_out_cells_with_a_hole() -> None:
    heights = np.array([[0.0, 1.0, 2.0], [0.0, 1.0, np.nan]])
    assert roughness.developed_area_ratio(heights, (1.0, 1.0)) == pytest.approx(2**0.5 - 1)
    with pytest.raises(InputError, match="area is undefined"):
        roughness.developed_area_ratio(heights[:, 1:], (1.0, 1.0))


@pytest.mark.parametrize(
    "function",
    [roughness.height_parameters, spectrum.autocorrelation, roughness.material_ratio_curve],
)
def test_map_without_points_raises_input_error(function) -> None:
    with pytest.raises(InputError, match="every point is missing"):
        function(np.full((3, 3), np.nan))
