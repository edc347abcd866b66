import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from roughcontact import preparation
from roughcontact.errors import InputError

MEASUREMENTS = Path(__file__).parents[1] / ".." / "shared" / "measurements"


def rough(seed: int, shape: tuple[int, int], holes: float = 0.0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    heights = rng.normal(size=shape)
    heights[rng.random(shape) < holes] = np.nan
    return heights


@given(
    st.integers(0, 1000),
    st.floats(-100, 100),
    st.floats(-10, 10),
    st.floats(-10, 10),
    st.sampled_from(["plane", "quadric"]),
)
def test_level_removes_any_added_plane(
    seed: int, offset: float, slope_y: float, slope_x: float, form: str
) -> None:
    heights = rough(seed, (13, 17), holes=0.2)
    y, x = np.mgrid[:13, :17]
    tilted = heights + offset + slope_y * y + slope_x * x
    # Rounding of heights of up to 400.
    np.testing.assert_allclose(
        preparation.level(tilted, form), preparation.level(heights, form), atol=1e-11
    )


@pytest.mark.parametrize("form", ["mean", "plane", "quadric"])
def test_level_agrees_with_least_squares(form: str) -> None:
    heights = rough(3, (20, 31), holes=0.4)
    y, x = (axis / 30 for axis in np.mgrid[:20, :31])
    columns = {"mean": [1 + 0 * x], "plane": [1 + 0 * x, x, y]}
    columns["quadric"] = [*columns["plane"], x * x, x * y, y * y]
    there = np.isfinite(heights)
    matrix = np.stack([column[there] for column in columns[form]], axis=1)
    fitted = matrix @ np.linalg.lstsq(matrix, heights[there], rcond=None)[0]
    levelled = preparation.level(heights, form)
    np.testing.assert_allclose(levelled[there], heights[there] - fitted, atol=1e-13)
    assert np.isnan(levelled[~there]).all()
    assert abs(np.nanmean(levelled)) < 1e-15


def test_level_is_well_conditioned_in_a_corner_of_a_large_map() -> None:
    heights = np.full((2000, 1500), np.nan)
    y, x = np.mgrid[:20, :20]
    bump = 1e-9 * rough(4, (20, 20))
    heights[-20:, -20:] = 1e-3 + 1e-6 * (x + 2 * y) + 1e-8 * x * y + bump
    expected = preparation.level(bump, "quadric")
    levelled = preparation.level(heights, "quadric")[-20:, -20:]
    # Heights of 1e-3 carry rounding of 2e-19.
    np.testing.assert_allclose(levelled, expected, atol=1e-17)


def test_level_of_heights_far_from_zero_has_zero_mean() -> None:
    y, x = np.mgrid[:30, :50]
    heights = 1e9 + 1e7 * x + 3e6 * y + rough(9, (30, 50), holes=0.1)
    # One fit leaves its rounding, of order 1e-7, as the mean.
    assert abs(np.nanmean(preparation.level(heights, "plane"))) < 1e-12


def test_level_by_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    heights = rough(5, (37, 23), holes=0.1)
    whole = preparation.level(heights, "quadric")
    monkeypatch.setattr(preparation, "_BLOCK", 23 * 4)
    np.testing.assert_allclose(preparation.level(heights, "quadric"), whole, atol=1e-14)


def test_level_leaves_its_argument_alone() -> None:
    heights = rough(6, (5, 5))
    before = heights.copy()
    preparation.level(heights)
    np.testing.assert_array_equal(heights, before)


def test_level_refuses_unknown_forms_and_too_few_points() -> None:
    with pytest.raises(InputError, match="mean, plane, quadric, got 'cubic'"):
        preparation.level(np.zeros((4, 4)), "cubic")
    on_a_line = np.full((9, 9), np.nan)
    np.fill_diagonal(on_a_line, 1.0)
    with pytest.raises(InputError, match="9 points"):
        preparation.level(on_a_line, "plane")
    with pytest.raises(InputError, match="fit a quadric"):
        preparation.level(np.zeros((2, 6)), "quadric")
    with pytest.raises(InputError, match="0 points"):
        preparation.level(np.full((3, 3), np.nan), "mean")


def test_fill_of_a_measured_map_with_large_holes() -> None:
    path = MEASUREMENTS / "bullet_land_fixed.x3p"
    if not path.exists():
        pytest.skip("shared/measurements is absent")
    pytest.importorskip("SurfaceTopography.IO", exc_type=ImportError)
    from roughcontact.formats import read_surface

    surface = read_surface(path)
    start = time.perf_counter()
    filled = surface.filled()
    assert time.perf_counter() - start < 2
    assert surface.missing == 25292
    assert filled.missing == 0
    there = ~np.isnan(surface.heights)
    assert filled.heights[there].tobytes() == surface.heights[there].tobytes()


def test_crop() -> None:
    heights = np.arange(20.0).reshape(4, 5)
    part = preparation.crop(heights, (1, 3), (0, 4))
    np.testing.assert_array_equal(part, [[5, 6, 7, 8], [10, 11, 12, 13]])
    part[:] = 0
    assert heights[1, 0] == 5


@pytest.mark.parametrize("rows", [(-1, 3), (0, 5), (2, 3), (3, 1)])
def test_crop_refuses_what_is_not_on_the_map(rows: tuple[int, int]) -> None:
    with pytest.raises(InputError, match="rows must be"):
        preparation.crop(np.zeros((4, 5)), rows, (0, 5))
    with pytest.raises(InputError, match="columns must be"):
        preparation.crop(np.zeros((5, 4)), (0, 5), rows)
