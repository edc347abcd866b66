import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from maps import rough
from roughcontact.errors import InputError
from roughcontact.surface import grid
from roughcontact.surface.form import level


@pytest.mark.parametrize("form", ["mean", "plane", "quadric"])
def test_level_agrees_with_least_squares(form: str) -> None:
    heights = rough(3, (20, 31), holes=0.4)
    y, x = (axis / 30 for axis in np.mgrid[:20, :31])
    columns = {"mean": [1 + 0 * x], "plane": [1 + 0 * x, x, y]}
    columns["quadric"] = [*columns["plane"], x * x, x * y, y * y]
    there = np.isfinite(heights)
    matrix = np.stack([column[there] for column in columns[form]], axis=1)
    fitted = matrix @ np.linalg.lstsq(matrix, heights[there], rcond=None)[0]
    levelled = level(heights, form)
    np.testing.assert_allclose(levelled[there], heights[there] - fitted, atol=1e-13)
    assert np.isnan(levelled[~there]).all()
    assert abs(np.nanmean(levelled)) < 1e-15


def test_level_is_well_conditioned_in_a_corner_of_a_large_map() -> None:
    heights = np.full((2000, 1500), np.nan)
    y, x = np.mgrid[:20, :20]
    bump = 1e-9 * rough(4, (20, 20))
    heights[-20:, -20:] = 1e-3 + 1e-6 * (x + 2 * y) + 1e-8 * x * y + bump
    expected = level(bump, "quadric")
    levelled = level(heights, "quadric")[-20:, -20:]
    # Heights of 1e-3 carry rounding of 2e-19.
    np.testing.assert_allclose(levelled, expected, atol=1e-17)


def test_level_of_heights_far_from_zero_has_zero_mean() -> None:
    y, x = np.mgrid[:30, :50]
    heights = 1e9 + 1e7 * x + 3e6 * y + rough(9, (30, 50), holes=0.1)
    # One fit leaves its rounding, of order 1e-7, as the mean.
    assert abs(np.nanmean(level(heights, "plane"))) < 1e-12


def test_level_by_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    heights = rough(5, (37, 23), holes=0.1)
    whole = level(heights, "quadric")
    monkeypatch.setattr(grid, "VALUES", 23 * 4)
    np.testing.assert_allclose(level(heights, "quadric"), whole, atol=1e-14)


def test_level_refuses_unknown_forms_and_too_few_points() -> None:
    with pytest.raises(InputError, match="mean, plane, quadric, robust, three-point, got 'cubic'"):
        level(np.zeros((4, 4)), "cubic")
    on_a_line = np.full((9, 9), np.nan)
    np.fill_diagonal(on_a_line, 1.0)
    with pytest.raises(InputError, match="9 valid points"):
        level(on_a_line, "plane")
    in_a_column = np.full((9, 9), np.nan)
    in_a_column[:, 3] = 1.0
    with pytest.raises(InputError, match="9 valid points"):
        level(in_a_column, "plane")
    with pytest.raises(InputError, match="fit a quadric"):
        level(np.zeros((2, 6)), "quadric")
    with pytest.raises(InputError, match="0 valid points"):
        level(np.full((3, 3), np.nan), "mean")


def test_three_points_end_at_zero() -> None:
    heights = rough(11, (9, 14), holes=0.2)
    points = [(0, 1), (8, 3), (2, 12)]
    for index, point in enumerate(points):
        heights[point] = index + 0.5
    levelled = level(heights, "three-point", points)
    assert max(abs(levelled[point]) for point in points) < 1e-14
    y, x = np.mgrid[:9, :14]
    tilted = level(heights + 3 + 0.2 * y - 0.7 * x, "three-point", points)
    np.testing.assert_allclose(tilted, levelled, atol=1e-13)


@pytest.mark.parametrize(
    ("points", "words"),
    [
        ([(0, 0), (1, 1), (2, 2)], "one line"),
        ([(0, 0), (1, 1), (5, 2)], r"5 × 6 points, got \(5, 2\)"),
        ([(0, 0), (1, -1), (3, 2)], r"got \(1, -1\)"),
        ([(0, 0), (3, 3), (1, 2)], r"height at \(3, 3\) is missing"),
        ([(0, 0), (1, 2)], "three pairs"),
        (None, "only with it"),
    ],
)
def test_three_points_that_make_no_plane(points, words: str) -> None:
    heights = np.ones((5, 6))
    heights[3, 3] = np.nan
    with pytest.raises(InputError, match=words):
        level(heights, "three-point", points)
    with pytest.raises(InputError, match="only with it"):
        level(heights, "plane", [(0, 0), (1, 2), (3, 2)])


def test_a_robust_plane_of_a_plane_with_spikes_is_that_plane() -> None:
    y, x = np.mgrid[:12, :9]
    plane = 1.0 + 0.25 * x - 0.5 * y
    spikes = np.zeros(plane.shape)
    spikes[3:6, 4:6] = 100
    np.testing.assert_allclose(level(plane + spikes, "robust"), spikes, atol=1e-9)
    np.testing.assert_allclose(level(plane, "robust"), 0, atol=1e-14)


@pytest.mark.parametrize("seed", range(4))
def test_a_robust_plane_is_tukey_s(seed: int) -> None:
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:40, :50]
    heights = 0.3 * x - 0.2 * y + rng.normal(size=y.shape)
    heights -= np.where(rng.random(y.shape) < 0.01 * x, rng.exponential(3, y.shape), 0)
    found = level(heights, "robust")

    def pull(scale: float) -> float:
        # Of the biweight on the plane, per point, over that of one point a scale away.
        weight = np.square(1 - np.minimum(np.square(found / (4.685 * scale)), 1))
        terms = (1, x / 50, y / 40)
        return max(abs(np.mean(weight * found * term)) for term in terms) / scale

    # The scale is that of the least absolute deviations: nearly that of this plane.
    near = 1.4826 * np.median(np.abs(found))
    best = minimize_scalar(
        pull, bounds=(0.9 * near, 1.1 * near), method="bounded", options={"xatol": 1e-12 * near}
    )
    assert best.fun < 1e-6
