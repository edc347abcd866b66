import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from roughcontact import roughness
from roughcontact.errors import InputError


def test_rms_height_of_a_sine() -> None:
    x = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    heights = 3e-6 * np.sin(x) + np.zeros((5, 1))
    assert roughness.rms_height(heights) == pytest.approx(3e-6 / np.sqrt(2), rel=1e-14)


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


@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(0.1, 10), st.floats(0.1, 10))
def test_rms_gradient_of_a_plane(slope_y: float, slope_x: float, dy: float, dx: float) -> None:
    y, x = np.mgrid[:7, :11]
    heights = slope_y * dy * y + slope_x * dx * x
    expected = np.hypot(slope_y, slope_x)
    # Heights up to 400 carry rounding of 5e-14, divided by a pixel of 0.1 at least.
    assert roughness.rms_gradient(heights, (dy, dx)) == pytest.approx(expected, abs=2e-12)


def test_rms_gradient_counts_points_with_both_differences() -> None:
    heights = np.array([[0.0, 1.0, 5.0], [0.0, 2.0, np.nan], [0.0, 0.0, 0.0]])
    # Point (1, 1): 2 along x, 1 along y; (2, 1): 0 and -2; (1, 2) and (2, 2) lack a neighbour.
    assert roughness.rms_gradient(heights, (1.0, 1.0)) == pytest.approx(np.sqrt((5 + 4) / 2))


def test_blocks_do_not_change_the_result(monkeypatch: pytest.MonkeyPatch) -> None:
    heights = np.random.default_rng(2).normal(size=(37, 23))
    whole = roughness.rms_height(heights), roughness.rms_gradient(heights, (1.0, 2.0))
    monkeypatch.setattr(roughness, "_BLOCK", 23 * 5)
    blocked = roughness.rms_height(heights), roughness.rms_gradient(heights, (1.0, 2.0))
    assert blocked == pytest.approx(whole, rel=1e-13)


@pytest.mark.parametrize(
    "heights", [np.full((3, 3), np.nan), np.array([[1.0, np.nan], [np.nan, 1.0]])]
)
def test_no_gradient_without_neighbours(heights: np.ndarray) -> None:
    with pytest.raises(InputError, match="no gradient"):
        roughness.rms_gradient(heights, (1.0, 1.0))


def test_no_height_without_points() -> None:
    with pytest.raises(InputError, match="missing"):
        roughness.rms_height(np.full((3, 3), np.nan))
