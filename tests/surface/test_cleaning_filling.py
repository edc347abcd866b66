import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy import ndimage

from maps import rough
from roughcontact.errors import InputError
from roughcontact.surface import cleaning


@given(st.integers(0, 10_000), st.floats(0.05, 0.9), st.floats(0.2, 5.0), st.floats(-1e6, 1e6))
def test_fill_keeps_bits_and_stays_within_the_rim(
    seed: int, holes: float, ratio: float, offset: float
) -> None:
    heights = rough(seed, (12, 15), holes) + offset
    there = ~np.isnan(heights)
    if not there.any():
        return
    filled = cleaning.fill_missing(heights, (ratio, 1.0))
    assert filled[there].tobytes() == heights[there].tobytes()
    label, count = ndimage.label(~there)
    for hole in range(1, count + 1):
        inside = label == hole
        rim = heights[ndimage.binary_dilation(inside) & there]
        assert rim.min() <= filled[inside].min()
        assert filled[inside].max() <= rim.max()


@pytest.mark.parametrize("limit", [10**9, 0])
@pytest.mark.parametrize("pixel", [(1.0, 1.0), (2.0, 0.7)])
def test_fill_is_exact_for_discretely_harmonic_heights(
    monkeypatch: pytest.MonkeyPatch, limit: int, pixel: tuple[float, float]
) -> None:
    monkeypatch.setattr(cleaning, "_DIRECT_LIMIT", limit)
    monkeypatch.setattr(cleaning, "_COARSEST", 50)
    dy, dx = pixel
    y, x = np.mgrid[:90, :80] * np.array([dy, dx])[:, None, None]
    # Second differences of x², y² are exact, so this solves the five-point equation exactly;
    # swapped weights would miss it where dy differs from dx.
    expected = x * x - y * y + 3 * x * y - x + 5
    heights = expected.copy()
    heights[10:70, 20:75] = np.nan
    heights[80:85, 5:9] = np.nan
    filled = cleaning.fill_missing(heights, pixel)
    # The iteration stops at a residual of 1e-10 of the right-hand side.
    np.testing.assert_allclose(filled, expected, atol=1e-7 * np.ptp(expected))


def test_fill_has_no_slope_across_the_edge() -> None:
    heights = np.full((6, 9), np.nan)
    heights[:, 0], heights[:, 4] = 1.0, 3.0
    filled = cleaning.fill_missing(heights, (1.0, 2.0))
    # Between the columns a straight line; beyond the last one nothing pulls.
    expected = np.array([1, 1.5, 2, 2.5, 3, 3, 3, 3, 3]) + np.zeros((6, 1))
    np.testing.assert_allclose(filled, expected, atol=1e-12)


def test_fill_within_a_level_rim_is_level_to_the_bit() -> None:
    heights = np.full((20, 50), 1 / 3)
    heights[:, 25:] = 7.1
    expected = heights.copy()
    heights[3:17, 3:22] = heights[5:9, 30:45] = np.nan
    np.testing.assert_array_equal(cleaning.fill_missing(heights, (1.0, 0.3)), expected)


def test_fill_of_a_whole_map_and_of_nothing() -> None:
    heights = rough(7, (4, 4))
    assert cleaning.fill_missing(heights, (1.0, 1.0)).tobytes() == heights.tobytes()
    with pytest.raises(InputError, match="nothing to fill"):
        cleaning.fill_missing(np.full((4, 4), np.nan), (1.0, 1.0))
