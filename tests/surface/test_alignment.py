"""One map on the grid of another, against maps that are known in every point."""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st

from maps import rough
from roughcontact.errors import InputError
from roughcontact.surface import alignment, filters


def points(shape: tuple[int, int], pixel: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Positions y, x of all points from the middle of the map."""
    y, x = ((np.arange(n) - (n - 1) / 2) * d for n, d in zip(shape, pixel, strict=True))
    return np.broadcast_arrays(y[:, None], x)


def waves(y: np.ndarray, x: np.ndarray) -> np.ndarray:
    """A function without symmetry whose shortest wave is 2π/0.9 = 7 long."""
    return np.sin(0.7 * x + 0.3 * y + 0.4) + np.cos(0.5 * x - 0.6 * y) + 0.5 * np.sin(0.9 * y) + x


def moved_point(y, x, offset, angle, mirrored):
    """Where a point of the grid is on the map, by the plain rotation matrix."""
    # Counter-clockwise as drawn is from x towards -y.
    t = -math.radians(angle)
    y, x = y - offset[0], x - offset[1]
    y, x = y * math.cos(t) - x * math.sin(t), x * math.cos(t) + y * math.sin(t)
    return y, (-x if mirrored else x)


# --- angles ------------------------------------------------------------------------------------


@given(st.floats(-1e4, 1e4))
def test_cosine_and_sine(angle: float) -> None:
    c, s = alignment.cosine_sine(angle)
    # Reduced to 45° in degrees; radians of 1e4° are off by 1e-14.
    assert c == pytest.approx(math.cos(math.radians(angle)), abs=1e-13)
    assert s == pytest.approx(math.sin(math.radians(angle)), abs=1e-13)


@given(st.integers(-100, 100))
def test_quarter_turns_are_exact(quarters: int) -> None:
    expected = [(1, 0), (0, 1), (-1, 0), (0, -1)][quarters % 4]
    assert alignment.cosine_sine(90 * quarters) == expected


@pytest.mark.parametrize("angle", [np.nan, np.inf, "30 deg", None, True])
def test_invalid_angles_raise_input_error(angle) -> None:
    with pytest.raises(InputError, match="angle must be a finite number of degrees"):
        alignment.cosine_sine(angle)


# --- where the points come to lie ----------------------------------------------------------------


@given(st.tuples(st.floats(-5, 5), st.floats(-5, 5)), st.floats(-400, 400), st.booleans())
def test_every_point_is_where_it_belongs(offset, angle, mirrored) -> None:
    shape, pixel, new_shape, new_pixel = (20, 30), (2.0, 1.0), (17, 9), (0.7, 1.3)
    matrix, start = alignment.grid_positions(
        shape, pixel, new_shape, new_pixel, offset, angle, mirrored
    )
    y, x = points(new_shape, new_pixel)
    old_y, old_x = moved_point(y, x, offset, angle, mirrored)
    i, j = np.indices(new_shape)
    for axis, expected in ((0, old_y / 2.0 + 9.5), (1, old_x / 1.0 + 14.5)):
        got = matrix[axis, 0] * i + matrix[axis, 1] * j + start[axis]
        # `place` moves a point by up to 1e-6 pixels onto one of the map.
        np.testing.assert_allclose(got, expected, rtol=0, atol=1.1e-6)


@given(st.floats(-180, 180), st.tuples(st.floats(-9, 9), st.floats(-9, 9)), st.booleans())
def test_spans_are_the_points_on_the_map(angle, offset, mirrored) -> None:
    shape, new_shape = (9, 14), (16, 12)
    placement = alignment.grid_positions(
        shape, (1.0, 1.0), new_shape, (1.0, 1.0), offset, angle, mirrored
    )
    first, last = alignment.spans(shape, placement, new_shape)
    matrix, start = placement
    i, j = np.indices(new_shape)
    depth = np.full(new_shape, np.inf)
    for axis, length in enumerate(shape):
        index = matrix[axis, 0] * i + matrix[axis, 1] * j + start[axis]
        depth = np.minimum(depth, np.minimum(index, length - 1 - index))
    columns = np.arange(new_shape[1])
    inside = (columns >= first[:, None]) & (columns <= last[:, None])
    assert inside[depth > 1e-9].all()
    # The slack is 1e-6 pixels, but along a row.
    assert not inside[depth < -2e-6].any()


@given(
    st.floats(-180, 180),
    st.tuples(st.floats(-4, 4), st.floats(-4, 4)),
    st.tuples(st.integers(4, 14), st.integers(4, 14)),
)
@example(1.5719194357607559e-06, (0.0, 0.0), (5, 9))
# Two columns are enough.
@example(0.0, (0.0, 6.5), (11, 4))
def test_the_common_rectangle_is_the_largest(angle, offset, shape) -> None:
    new_shape = (11, 13)
    maps = [
        (new_shape, alignment.grid_positions(new_shape, (1.0, 1.0), new_shape, (1.0, 1.0))),
        (shape, alignment.grid_positions(shape, (1.0, 1.0), new_shape, (1.0, 1.0), offset, angle)),
    ]
    both = np.ones(new_shape, bool)
    for one, placement in maps:
        first, last = alignment.spans(one, placement, new_shape, alignment._POINT_TOLERANCE)
        columns = np.arange(new_shape[1])
        both &= (columns >= first[:, None]) & (columns <= last[:, None])
    best = 0
    for top in range(new_shape[0]):
        for bottom in range(top + 2, new_shape[0] + 1):
            free = both[top:bottom].all(axis=0)
            lengths = [len(run) for run in "".join("x" if f else " " for f in free).split()]
            best = max([best, *((bottom - top) * n for n in lengths if n > 1)])
    if best == 0:
        with pytest.raises(InputError, match="the maps do not overlap"):
            alignment.common_rectangle(maps, new_shape)
        return
    rows, columns = alignment.common_rectangle(maps, new_shape)
    assert both[slice(*rows), slice(*columns)].all()
    assert (rows[1] - rows[0]) * (columns[1] - columns[0]) == best
    assert min(rows[1] - rows[0], columns[1] - columns[0]) > 1


@pytest.mark.parametrize(
    ("pixel", "other", "angle", "expected"),
    [
        ((1.0, 2.0), (1.0, 2.0), 0, (1.0, 2.0)),
        # √2 is similar, more is not; coarser never matters.
        ((1.4, 1.5), (1.0, 1.0), 0, (1.4, 1.0)),
        ((1.0, 1.0), (7.0, 0.5), 0, (1.0, 0.5)),
        ((1.0, 1.0), (7.0, 0.5), 90, (0.5, 1.0)),
        # A square pixel looks the same from everywhere.
        ((3.0, 2.0), (1.0, 1.0), 33, (1.0, 1.0)),
        # Waves of 0.5 along one axis, turned by 45°, need 0.5 × √2 along both.
        ((9.0, 9.0), (1e9, 0.5), 45, (math.sqrt(0.5), math.sqrt(0.5))),
    ],
)
def test_common_pixel_is_finer_pixel(pixel, other, angle, expected) -> None:
    assert alignment.common_pixel(pixel, other, angle) == pytest.approx(expected, rel=1e-12)


# --- points that coincide -----------------------------------------------------------------------


@given(
    st.integers(0, 1000),
    st.tuples(st.integers(2, 7), st.integers(2, 7)),
    st.tuples(st.integers(2, 7), st.integers(2, 7)),
    st.integers(-5, 5),
    st.booleans(),
    st.integers(-3, 3),
    st.integers(-3, 3),
)
@settings(max_examples=200)
def test_coincident_points_keep_their_bits(
    seed, shape, new_shape, quarters, mirrored, down, right
) -> None:
    pixel = (2e-6, 3e-6)
    heights = rough(seed, shape, holes=0.1)
    turned = np.rot90(heights[:, ::-1] if mirrored else heights, quarters)
    new_pixel = pixel[::-1] if quarters % 2 else pixel
    # Centers between points make a shift of half a pixel.
    odd = [(n - m) % 2 for n, m in zip(turned.shape, new_shape, strict=True)]
    offset = ((down + odd[0] / 2) * new_pixel[0], (right + odd[1] / 2) * new_pixel[1])
    expected = np.full(new_shape, np.nan)
    for i in range(new_shape[0]):
        for j in range(new_shape[1]):
            row = i - down + (turned.shape[0] - new_shape[0] - odd[0]) // 2
            column = j - right + (turned.shape[1] - new_shape[1] - odd[1]) // 2
            if 0 <= row < turned.shape[0] and 0 <= column < turned.shape[1]:
                expected[i, j] = turned[row, column]
    motion = (new_shape, new_pixel, offset, 90.0 * quarters, mirrored)
    if np.isnan(expected).all():
        with pytest.raises(InputError, match="do not overlap"):
            alignment.align(heights, pixel, *motion)
        return
    new = alignment.align(heights, pixel, *motion)
    np.testing.assert_array_equal(new, expected)
    assert not np.shares_memory(new, heights)


def test_a_pixel_read_from_a_file_may_round() -> None:
    heights = rough(1, (2000, 30))
    pixel = (1e-6, 1e-6)
    other = (1e-6 * (1 + 3e-10), 1e-6 * (1 - 3e-10))
    new = alignment.align(heights, pixel, heights.shape, other)
    assert new.tobytes() == heights.tobytes()


# --- interpolation ------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(4, 4), (5, 6), (7, 4), (30, 40)])
def test_cubics_are_met_up_to_the_edge(shape: tuple[int, int]) -> None:
    def cubic(y: np.ndarray, x: np.ndarray) -> np.ndarray:
        return x**3 - 2 * x * y**2 + y**3 - 3 * x * y + 1

    pixel = (1.5 / shape[0], 2.0 / shape[1])
    heights = cubic(*points(shape, pixel))
    for angle, mirrored in ((17.0, False), (-100.0, True), (0.0, False)):
        motion = ((41, 43), (0.03, 0.04), (0.05, -0.1), angle, mirrored)
        new = alignment.align(heights, pixel, *motion)
        y, x = moved_point(*points((41, 43), (0.03, 0.04)), *motion[2:])
        on = (np.abs(y) <= 0.75 - pixel[0] / 2) & (np.abs(x) <= 1.0 - pixel[1] / 2)
        np.testing.assert_array_equal(np.isfinite(new), on)
        # The product of cubics in y and x holds every term; rounding is enlarged a little.
        np.testing.assert_allclose(new[on], cubic(y, x)[on], rtol=0, atol=1e-13)


@pytest.mark.parametrize("angle", [0.0, 90.0, 30.0, -137.0])
def test_the_motion_is_mirror_turn_shift(angle: float) -> None:
    shape, pixel, offset = (120, 150), (0.3, 0.25), (1.3, -2.2)
    for mirrored in (False, True):
        motion = ((40, 60), (0.35, 0.3), offset, angle, mirrored)
        new = alignment.align(waves(*points(shape, pixel)), pixel, *motion)
        y, x = moved_point(*points((40, 60), (0.35, 0.3)), *motion[2:])
        # 23 points a wave: the spline is off by 1e-4 of the waves.
        np.testing.assert_allclose(new, waves(y, x), rtol=0, atol=2e-4)


# --- holes -----------------------------------------------------------------------------------


@given(st.integers(0, 1000), st.floats(-180, 180), st.tuples(st.floats(-3, 3), st.floats(-3, 3)))
@example(140, 0.4765625, (-0.4794834837991333, -0.4765625))
@settings(max_examples=50)
def test_points_next_to_a_hole_are_missing(seed, angle, offset) -> None:
    heights = rough(seed, (9, 12), holes=0.1)
    shape = (11, 10)
    placement = alignment.grid_positions((9, 12), (1.0, 1.0), shape, (0.7, 0.8), offset, angle)
    new = alignment.sample(heights, placement, shape)
    matrix, start = placement
    for i in range(shape[0]):
        for j in range(shape[1]):
            y, x = matrix @ (i, j) + start
            if not (0 <= y <= 8 and 0 <= x <= 11):
                assert np.isnan(new[i, j]) or min(y, x, 8 - y, 11 - x) > -1e-5
                continue
            # Weight of missing points in between: below 1e-6 it is neglected.
            weight = sum(
                (1 - abs(y - row)) * (1 - abs(x - column)) * np.isnan(heights[row, column])
                for row in {math.floor(y), math.ceil(y)}
                for column in {math.floor(x), math.ceil(x)}
            )
            if not 0.5e-6 < weight < 2e-6:
                assert np.isnan(new[i, j]) == (weight > 1e-6)


# --- a coarser grid -------------------------------------------------------------------------------


def test_short_waves_do_not_become_long_ones() -> None:
    # Waves of 2.2 old pixels, sampled on every fourth point, would be waves of 22.
    x = np.arange(400)
    heights = np.tile(np.cos(2 * np.pi * x / 2.2), (40, 1))
    new = alignment.align(heights, (1.0, 1.0), (10, 100), (4.0, 4.0))
    inner = new[:, 5:-5]
    # 2^-(8/2.2)² = 1e-4 passes.
    assert np.abs(inner).max() < 3e-4
    # 32 pixels: 2^-(8/32)².
    heights = np.tile(np.cos(2 * np.pi * (x - 199.5) / 32), (40, 1))
    new = alignment.align(heights, (1.0, 1.0), (10, 100), (4.0, 4.0))
    expected = 2 ** -(1 / 16) * np.cos(2 * np.pi * 4 * (np.arange(100) - 49.5) / 32)
    np.testing.assert_allclose(new[5, 5:-5], expected[5:-5], rtol=0, atol=2e-5)


def test_only_the_axis_that_coarsens_is_filtered() -> None:
    # A profilometer with long pixels along y, in its own and in a turned frame.
    heights = rough(3, (60, 40))
    new = alignment.align(heights, (1.0, 1.0), (15, 40), (4.0, 1.0))
    assert new.std(axis=1).mean() > 0.3
    level = heights - heights.mean()
    along = filters.along_axes(level, (8.0, 0.0))
    between = (along[1:-1:4] + along[2::4]) / 2
    # Spline against the mean of two points, on waves of at least 8: some per cent.
    inner = slice(3, -3)
    assert np.corrcoef(new[inner].ravel(), between[inner].ravel())[0, 1] > 0.999
    turned = alignment.align(np.rot90(heights), (1.0, 1.0), (15, 40), (4.0, 1.0), angle=-90.0)
    np.testing.assert_allclose(turned, new, rtol=0, atol=1e-13)


@pytest.mark.parametrize(("ratio", "filtered"), [(1.0, False), (1.41, False), (1.42, True)])
@pytest.mark.parametrize("angle", [0.0, 30.0, 90.0])
def test_similar_pixels_are_not_filtered(ratio: float, filtered: bool, angle: float) -> None:
    placement = alignment.grid_positions(
        (50, 60), (1.0, 1.0), (30, 30), (ratio, ratio), angle=angle
    )
    expected = 2 * ratio if filtered else 0.0
    assert alignment.cutoffs(placement) == pytest.approx((expected, expected))


def test_holes_on_a_coarser_grid() -> None:
    heights = rough(4, (60, 60))
    heights[20:40, 20:40] = np.nan
    new = alignment.align(heights, (1.0, 1.0), (15, 15), (4.0, 4.0))
    hole = np.isnan(new)
    # The centers of the coarse pixels 5 to 9 are at 21.5 to 37.5.
    assert hole[5:10, 5:10].all()
    assert hole.sum() == 25
    assert np.abs(new[~hole]).max() < 1


# --- errors -----------------------------------------------------------------------------------


def test_invalid_alignments_raise_input_error() -> None:
    heights = rough(1, (6, 7))
    with pytest.raises(InputError, match=r"do not overlap: a map of 6 × 7 m, shifted by \(20"):
        alignment.align(heights, (1.0, 1.0), (5, 5), (0.5, 0.5), (20.0, 0.0))
    with pytest.raises(InputError, match="4 × 4 points, got 3 × 7"):
        alignment.align(heights[:3], (1.0, 1.0), (5, 5), (0.5, 0.5))
    with pytest.raises(InputError, match="pixel must be positive"):
        alignment.align(heights, (1.0, 1.0), (5, 5), (0.5, -0.5))
    for offset in (1.0, (1.0,), ("a", 1.0), None):
        with pytest.raises(InputError, match="offset must be a pair"):
            alignment.align(heights, (1.0, 1.0), (5, 5), (0.5, 0.5), offset)
    with pytest.raises(InputError, match="offset must be finite"):
        alignment.align(heights, (1.0, 1.0), (5, 5), (0.5, 0.5), (np.nan, 1.0))
