import numpy as np
import pytest
from hypothesis import given, strategies as st

from maps import rough
from roughcontact.errors import InputError
from roughcontact.surface import cleaning


def test_crop() -> None:
    heights = np.arange(20.0).reshape(4, 5)
    part = cleaning.crop_map(heights, (1, 3), (0, 4))
    np.testing.assert_array_equal(part, [[5, 6, 7, 8], [10, 11, 12, 13]])
    part[:] = 0
    assert heights[1, 0] == 5


@pytest.mark.parametrize("rows", [(-1, 3), (0, 5), (2, 3), (3, 1)])
def test_crop_outside_map_raises_input_error(rows: tuple[int, int]) -> None:
    with pytest.raises(InputError, match="rows must be"):
        cleaning.crop_map(np.zeros((4, 5)), rows, (0, 5))
    with pytest.raises(InputError, match="columns must be"):
        cleaning.crop_map(np.zeros((5, 4)), (0, 5), rows)


@given(st.integers(0, 10**6), st.integers(2, 7), st.integers(2, 7), st.floats(0, 0.7))
def test_the_largest_rectangle_is_the_largest(seed: int, ny: int, nx: int, holes: float) -> None:
    heights = rough(seed, (ny, nx), holes)
    there = np.isfinite(heights)
    best = max(
        (
            (b - a) * (d - c)
            for a in range(ny)
            for b in range(a + 2, ny + 1)
            for c in range(nx)
            for d in range(c + 2, nx + 1)
            if there[a:b, c:d].all()
        ),
        default=0,
    )
    if best == 0:
        with pytest.raises(InputError, match="2 × 2"):
            cleaning.largest_rectangle(heights)
        return
    part = cleaning.crop_map(heights, *cleaning.largest_rectangle(heights))
    assert np.isfinite(part).all()
    assert part.size == best


def test_outliers_go_and_the_rest_keeps_its_bits() -> None:
    rng = np.random.default_rng(2)
    y, x = np.mgrid[:80, :70]
    heights = 0.3 * x - 0.1 * y + np.sin(x / 9) + 0.01 * rng.normal(size=y.shape)
    heights[rng.random(y.shape) < 0.1] = np.nan
    spikes = np.zeros(y.shape, bool)
    spikes[[0, 0, 30, 31, 79, 50], [0, 40, 20, 20, 69, 0]] = True
    heights[spikes] = heights[spikes] + np.where(np.arange(spikes.sum()) % 2, 5, -5)
    there = np.isfinite(heights)
    kept = cleaning.remove_outliers(heights)
    assert np.isnan(kept[spikes]).all()
    rest = np.isfinite(kept)
    assert kept[rest].tobytes() == heights[rest].tobytes()
    # Six sigma of the noise about a median of 25: one in a million, with the odd exception
    # where holes or edges thin the window.
    assert np.count_nonzero(there & ~spikes & ~rest) <= 3


def test_local_median_ignores_missing_points() -> None:
    heights = rough(5, (13, 17), holes=0.4)
    median = cleaning._local_median(heights, 5)
    for y in range(2, 11):
        for x in range(2, 15):
            part = heights[y - 2 : y + 3, x - 2 : x + 3]
            assert median[y, x] == np.nanmedian(part)


def test_outliers_of_smooth_maps() -> None:
    y, x = np.mgrid[:30, :20].astype(float)
    np.testing.assert_array_equal(cleaning.remove_outliers(0 * x), 0 * x)
    assert not np.isnan(cleaning.remove_outliers(0.5 * x - 0.25 * y)).any()
    spiked = 0 * x
    spiked[4, 5] = 1e-9
    assert np.argwhere(np.isnan(cleaning.remove_outliers(spiked))).tolist() == [[4, 5]]


@pytest.mark.parametrize(
    ("limit", "window", "words"),
    [(0, 5, "limit"), (np.nan, 5, "limit"), (3, 4, "window"), (3, 1, "window"), (3, 33, "window")],
)
def test_outliers_refuses(limit: float, window: int, words: str) -> None:
    with pytest.raises(InputError, match=words):
        cleaning.remove_outliers(np.zeros((5, 5)), limit, window)


@given(st.integers(0, 1000), st.integers(-9, 9))
def test_four_quarter_rotations_keep_map(seed: int, turns: int) -> None:
    heights = rough(seed, (5, 8), holes=0.3)
    turned = heights
    for _ in range(4):
        turned = cleaning.rotate_map(turned, 90 * turns)
    assert turned.tobytes() == heights.tobytes()
    assert not np.shares_memory(cleaning.rotate_map(heights, 0), heights)
    once, ny, nx = cleaning.rotate_map(heights), *heights.shape
    assert once.shape == (nx, ny)
    for i, j in ((0, 0), (3, 2), (7, 4)):
        np.testing.assert_array_equal(once[i, j], heights[j, nx - 1 - i])


def test_rotate_refuses_part_turns() -> None:
    for angle in (1, 45.0, np.nan, True, "90"):
        with pytest.raises(InputError, match="angle must be a multiple of 90 degrees, got"):
            cleaning.rotate_map(np.zeros((2, 2)), angle)
