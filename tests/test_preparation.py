import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from roughcontact.errors import InputError
from roughcontact.surface import preparation

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
    with pytest.raises(InputError, match="mean, plane, quadric, robust, three-point, got 'cubic'"):
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
    from roughcontact.formats.read import read_surface

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


# --- three points, robust ---------------------------------------------------------------------


def test_three_points_end_at_zero() -> None:
    heights = rough(11, (9, 14), holes=0.2)
    points = [(0, 1), (8, 3), (2, 12)]
    for index, point in enumerate(points):
        heights[point] = index + 0.5
    levelled = preparation.level(heights, "three-point", points)
    assert max(abs(levelled[point]) for point in points) < 1e-14
    y, x = np.mgrid[:9, :14]
    tilted = preparation.level(heights + 3 + 0.2 * y - 0.7 * x, "three-point", points)
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
        preparation.level(heights, "three-point", points)
    with pytest.raises(InputError, match="only with it"):
        preparation.level(heights, "plane", [(0, 0), (1, 2), (3, 2)])


def test_a_robust_plane_does_not_follow_pits() -> None:
    rng = np.random.default_rng(12)
    y, x = np.mgrid[:60, :80]
    noise = 0.01 * rng.normal(size=y.shape)
    pits = rng.random(y.shape) < 0.3 * x / 40  # 30 %, most of them on the right
    heights = 5 + 0.02 * x - 0.03 * y + noise - np.where(pits, 3.0, 0.0)
    heights[rng.random(y.shape) < 0.1] = np.nan
    plane = heights - preparation.level(heights, "robust")
    there = np.isfinite(plane)
    # 3000 points of noise 0.01 leave a plane uncertain by 0.0004 at its corners; least squares
    # is off by 1.
    assert np.abs(plane - (5 + 0.02 * x - 0.03 * y))[there].max() < 2e-3
    assert np.abs(preparation.level(heights))[there & ~pits].max() > 0.5


def test_a_robust_plane_of_a_plane_with_spikes_is_that_plane() -> None:
    y, x = np.mgrid[:12, :9]
    plane = 1.0 + 0.25 * x - 0.5 * y
    spikes = np.zeros(plane.shape)
    spikes[3:6, 4:6] = 100
    np.testing.assert_allclose(preparation.level(plane + spikes, "robust"), spikes, atol=1e-9)
    np.testing.assert_allclose(preparation.level(plane, "robust"), 0, atol=1e-14)


def test_a_robust_plane_of_normal_heights_is_near_least_squares() -> None:
    heights = rough(13, (50, 40))
    difference = preparation.level(heights, "robust") - preparation.level(heights, "plane")
    # Uncertainty of either plane 0.02 in the middle, 0.05 at a corner.
    assert 0 < np.abs(difference).max() < 0.05


# --- form ---------------------------------------------------------------------------------------


def cap(shape, pixel, radius, centre, holes=0.0, noise=0.0, seed=0):
    """Heights of a sphere, positive radius for a summit, with its centre at (y, x) [m]."""
    rng = np.random.default_rng(seed)
    y, x = (np.arange(n) * edge for n, edge in zip(shape, pixel, strict=True))
    square = (y[:, None] - centre[0]) ** 2 + (x - centre[1]) ** 2
    heights = np.sign(radius) * np.sqrt(radius**2 - square) + noise * rng.normal(size=shape)
    heights[rng.random(shape) < holes] = np.nan
    return heights


@given(
    st.floats(0.62, 1000),
    st.sampled_from([-1, 1]),
    st.floats(-0.2, 0.2),
    st.floats(-0.2, 0.2),
)
def test_a_sphere_is_recovered_with_holes(radius: float, sign: int, y: float, x: float) -> None:
    # In units of a map of 0.8 × 0.5: from a cap that nearly reaches the equator to a flat one.
    shape, pixel = (41, 31), (0.02, 0.016)
    centre = (0.4 + 0.5 * y, 0.24 + 0.5 * x)
    heights = cap(shape, pixel, sign * radius, centre, holes=0.2)
    residual, found = preparation.remove_form(heights, pixel, "sphere")
    # Rounding of the heights over the sag, 0.1/R.
    assert found["radius"] == pytest.approx(sign * radius, rel=1e-11 * (1 + radius**2))
    rounding = 1e-11 * (1 + radius**3)
    assert (found["centre_y"], found["centre_x"]) == pytest.approx(centre, abs=rounding)
    assert abs(found["centre_z"]) < rounding
    np.testing.assert_array_equal(np.isnan(residual), np.isnan(heights))
    assert np.nanmax(np.abs(residual)) < 1e-13 * (1 + radius)


@pytest.mark.parametrize("radius", [0.01, -0.01])
def test_the_radius_of_a_rough_ball_within_a_thousandth(radius: float) -> None:
    # Radius 10 mm, side 1 mm: sag 12 µm at the sides, roughness 0.1 µm, 20 % holes.
    shape, pixel = (256, 200), (4e-6, 5e-6)
    heights = cap(shape, pixel, radius, (5.5e-4, 4.4e-4), holes=0.2, noise=1e-7, seed=3)
    residual, found = preparation.remove_form(heights, pixel, "sphere")
    assert found["radius"] == pytest.approx(radius, rel=1e-3)
    assert np.nanstd(residual) == pytest.approx(1e-7, rel=0.02)
    assert abs(np.nanmean(residual)) < 1e-15
    # A paraboloid would leave its fourth-order error.
    steep = cap(shape, pixel, radius / 10, (5.1e-4, 5.1e-4), holes=0.2)
    assert np.nanmax(np.abs(preparation.remove_form(steep, pixel, "sphere")[0])) < 1e-16
    assert np.nanmax(np.abs(preparation.level(steep, "quadric"))) > 1e-6


@given(st.floats(-1.5, 1.57), st.floats(0.7, 100), st.sampled_from([-1, 1]), st.floats(-0.3, 0.3))
def test_a_cylinder_is_recovered_whatever_its_axis(
    angle: float, radius: float, sign: int, slope: float
) -> None:
    shape, pixel = (37, 43), (0.02, 0.016)
    y, x = (np.arange(n) * edge for n, edge in zip(shape, pixel, strict=True))
    y, x = y[:, None] - 0.3, x - 0.37
    along = x * np.cos(angle) + y * np.sin(angle)
    across = y * np.cos(angle) - x * np.sin(angle) + 0.02
    heights = slope * along + sign * np.sqrt(1 + slope**2) * np.sqrt(radius**2 - across**2)
    heights[np.random.default_rng(1).random(shape) < 0.2] = np.nan
    residual, found = preparation.remove_form(heights, pixel, "cylinder")
    tolerance = 1e-11 * (1 + radius**2)
    assert found["radius"] == pytest.approx(sign * radius, rel=tolerance)
    assert -np.pi / 2 < found["angle"] <= np.pi / 2
    turn = (found["angle"] - angle + np.pi / 2) % np.pi - np.pi / 2
    assert abs(turn) < tolerance * (1 + radius)
    assert found["slope"] == pytest.approx(slope, abs=tolerance * (1 + radius))
    assert np.nanmax(np.abs(residual)) < 1e-12 * (1 + radius)


@settings(max_examples=40)
@given(st.integers(0, 8), st.integers(0, 1000))
def test_a_polynomial_of_its_degree_is_removed(degree: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    y, x = np.meshgrid(np.linspace(-1, 1, 29), np.linspace(-1, 1, 34), indexing="ij")
    form = sum(
        rng.normal() * y**power * x ** (total - power)
        for total in range(degree + 1)
        for power in range(total + 1)
    )
    heights = rough(seed, form.shape, holes=0.3)
    pixel = (1e-6, 2e-6)
    bare, _ = preparation.remove_form(heights, pixel, "polynomial", degree)
    residual, found = preparation.remove_form(heights + form, pixel, "polynomial", degree)
    np.testing.assert_allclose(residual, bare, atol=1e-11)
    assert found["degree"] == degree
    # One degree more than fitted is left in.
    higher = heights + 1e4 * x ** (degree + 1)
    left = preparation.remove_form(higher, pixel, "polynomial", degree)[0]
    assert np.nanstd(left) > 5 * np.nanstd(bare)


def test_a_polynomial_on_a_disk_agrees_with_least_squares() -> None:
    y, x = np.meshgrid(np.linspace(-1, 1, 60), np.linspace(-1, 1, 51), indexing="ij")
    heights = np.where(y**2 + x**2 < 1, rough(8, y.shape), np.nan)
    there = np.isfinite(heights)
    matrix = np.stack(
        [(y**b * x ** (n - b))[there] for n in range(7) for b in range(n + 1)], axis=1
    )
    fitted = matrix @ np.linalg.lstsq(matrix, heights[there], rcond=None)[0]
    residual = preparation.remove_form(heights, (1.0, 1.0), "polynomial", 6)[0]
    np.testing.assert_allclose(residual[there], heights[there] - fitted, atol=1e-11)


def test_form_is_refused_where_it_is_not_determined() -> None:
    pixel = (1.0, 1.0)
    y, x = np.mgrid[:20, :30] / 20
    flat = 1 + 0.1 * x + 0.2 * y
    noisy = flat + 0.01 * rough(2, y.shape)
    for shape in ("sphere", "cylinder"):
        for heights in (flat, noisy, np.zeros((20, 30))):
            with pytest.raises(InputError, match=f"too flat to fit a {shape}"):
                preparation.remove_form(heights, pixel, shape)
        line = np.full((9, 9), np.nan)
        np.fill_diagonal(line, np.arange(9) ** 2)
        with pytest.raises(InputError, match="9 points"):
            preparation.remove_form(line, pixel, shape)
        with pytest.raises(InputError, match="4 points"):
            preparation.remove_form(np.ones((2, 2)), pixel, shape)
        with pytest.raises(InputError, match="only with it"):
            preparation.remove_form(noisy, pixel, shape, 2)
    with pytest.raises(InputError, match="axis of a cylinder"):
        preparation.remove_form(-((x - 0.7) ** 2) - (y - 0.5) ** 2, pixel, "cylinder")
    with pytest.raises(InputError, match="too flat to fit a sphere"):
        preparation.remove_form((x - 0.7) ** 2 - (y - 0.5) ** 2, pixel, "sphere")
    with pytest.raises(InputError, match="only with it"):
        preparation.remove_form(noisy, pixel, "polynomial")
    for degree in (-1, 21, 2.5):
        with pytest.raises(InputError, match="from 0 to 20"):
            preparation.remove_form(noisy, pixel, "polynomial", degree)
    with pytest.raises(InputError, match="polynomial of degree 4"):
        preparation.remove_form(np.zeros((4, 40)), pixel, "polynomial", 4)
    with pytest.raises(InputError, match="sphere, got 'cone'"):
        preparation.remove_form(noisy, pixel, "cone")


# --- rectangle, outliers, rotation -----------------------------------------------------------


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
            preparation.largest_rectangle(heights)
        return
    part = preparation.crop(heights, *preparation.largest_rectangle(heights))
    assert np.isfinite(part).all()
    assert part.size == best


def test_the_largest_rectangle_of_a_million_points() -> None:
    heights = rough(1, (1000, 1000), 1e-3)
    start = time.perf_counter()
    preparation.largest_rectangle(heights)
    assert time.perf_counter() - start < 1


def test_outliers_go_and_the_rest_keeps_its_bits() -> None:
    rng = np.random.default_rng(2)
    y, x = np.mgrid[:80, :70]
    heights = 0.3 * x - 0.1 * y + np.sin(x / 9) + 0.01 * rng.normal(size=y.shape)
    heights[rng.random(y.shape) < 0.1] = np.nan
    spikes = np.zeros(y.shape, bool)
    spikes[[0, 0, 30, 31, 79, 50], [0, 40, 20, 20, 69, 0]] = True
    heights[spikes] = heights[spikes] + np.where(np.arange(spikes.sum()) % 2, 5, -5)
    there = np.isfinite(heights)
    kept = preparation.remove_outliers(heights)
    assert np.isnan(kept[spikes]).all()
    rest = np.isfinite(kept)
    assert kept[rest].tobytes() == heights[rest].tobytes()
    # Six sigma of the noise about a median of 25: one in a million, with the odd exception
    # where holes or edges thin the window.
    assert np.count_nonzero(there & ~spikes & ~rest) <= 3


def test_the_local_median_is_that_of_the_points_that_are_there() -> None:
    heights = rough(5, (13, 17), holes=0.4)
    median = preparation._local_median(heights, 5)
    for y in range(2, 11):
        for x in range(2, 15):
            part = heights[y - 2 : y + 3, x - 2 : x + 3]
            assert median[y, x] == np.nanmedian(part)


def test_outliers_of_smooth_maps() -> None:
    y, x = np.mgrid[:30, :20].astype(float)
    np.testing.assert_array_equal(preparation.remove_outliers(0 * x), 0 * x)
    assert not np.isnan(preparation.remove_outliers(0.5 * x - 0.25 * y)).any()
    spiked = 0 * x
    spiked[4, 5] = 1e-9
    assert np.argwhere(np.isnan(preparation.remove_outliers(spiked))).tolist() == [[4, 5]]


@pytest.mark.parametrize(
    ("limit", "window", "words"),
    [(0, 5, "limit"), (np.nan, 5, "limit"), (3, 4, "window"), (3, 1, "window"), (3, 33, "window")],
)
def test_outliers_refuses(limit: float, window: int, words: str) -> None:
    with pytest.raises(InputError, match=words):
        preparation.remove_outliers(np.zeros((5, 5)), limit, window)


@given(st.integers(0, 1000), st.integers(-9, 9))
def test_four_quarter_turns_are_none(seed: int, turns: int) -> None:
    heights = rough(seed, (5, 8), holes=0.3)
    turned = heights
    for _ in range(4):
        turned = preparation.rotate(turned, turns)
    assert turned.tobytes() == heights.tobytes()
    assert not np.shares_memory(preparation.rotate(heights, 0), heights)
    once, ny, nx = preparation.rotate(heights), *heights.shape
    assert once.shape == (nx, ny)
    for i, j in ((0, 0), (3, 2), (7, 4)):
        np.testing.assert_array_equal(once[i, j], heights[j, nx - 1 - i])


def test_rotate_refuses_part_turns() -> None:
    with pytest.raises(InputError, match=r"quarter_turns must be an integer, got 0\.5"):
        preparation.rotate(np.zeros((2, 2)), 0.5)
