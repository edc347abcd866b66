import math

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st

from roughcontact.errors import InputError
from roughcontact.surface import placement
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface

SHAPE, PIXEL = (31, 44), (2e-6, 3e-6)


def waves(shape, pixel, offset=(0.0, 0.0), angle=0.0, mirrored=False):
    """Heights whose shortest wave is 35 µm, as a map laid there would show them."""
    y, x = ((np.arange(n) - (n - 1) / 2) * d for n, d in zip(shape, pixel, strict=True))
    y, x = np.broadcast_arrays(y[:, None] - offset[0], x - offset[1])
    t = -math.radians(angle)
    y, x = y * math.cos(t) - x * math.sin(t), x * math.cos(t) + y * math.sin(t)
    x = -x if mirrored else x
    y, x = 2e5 * y, 2e5 * x
    return 1e-7 * (np.sin(0.7 * x + 0.3 * y + 0.4) + np.cos(0.5 * x - 0.6 * y) + 0.05 * y)


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("angle", [0.0, 90.0, 25.0])
def test_two_maps_meet_where_they_overlap(angle: float, mirrored: bool) -> None:
    offset = (2.3e-5, -3.1e-5)
    first = Surface(waves((80, 100), (2e-6, 2e-6)), (2e-6, 2e-6), Provenance("a"))
    second = Surface(waves((90, 70), (2.5e-6, 2.2e-6)), (2.5e-6, 2.2e-6), Provenance("b"))
    one, two = placement.match_grids(first, second, offset, angle, mirrored)
    assert one.shape == two.shape
    assert one.pixel == two.pixel == first.pixel
    assert one.missing == two.missing == 0
    # The part of the first map is found by its bits.
    (row,), (column,) = np.nonzero(first.heights == one.heights[0, 0])
    part = np.s_[row : row + one.shape[0], column : column + one.shape[1]]
    assert first.heights[part].tobytes() == one.heights.tobytes()
    # The second as it would have been measured there: 14 points a wave, 5e-4 of it.
    expected = waves(first.shape, first.pixel, offset, angle, mirrored)[part]
    np.testing.assert_allclose(two.heights, expected, rtol=0, atol=1e-10)
    assert one.heights.size > 2000
    assert (one.provenance.source, two.provenance.source) == ("a", "b")
    assert "point by point" in one.provenance.steps[-1]
    assert "bicubic spline" in two.provenance.steps[-1]


def test_the_finer_pixel_decides() -> None:
    coarse = Surface(waves((60, 70), (4e-6, 3e-6)), (4e-6, 3e-6))
    fine = Surface(waves((90, 70), (1e-6, 2.5e-6)), (1e-6, 2.5e-6))
    one, two = placement.match_grids(coarse, fine, (1e-5, 1e-5))
    # 2.5 µm is similar to 3 µm, 1 µm is not to 4 µm.
    assert one.pixel == two.pixel == (1e-6, 3e-6)
    # All of the fine map is on the coarse one: only its rim may be lost.
    assert one.shape[0] >= 88
    assert one.size[1] >= fine.size[1] - 2 * 3e-6
    other, same = placement.match_grids(fine, coarse, (-1e-5, -1e-5))
    assert same.pixel == fine.pixel
    assert other.heights.tobytes() == fine.heights.tobytes()
    # Seen from the other map it is the same contact, within half a pixel of its cut.
    assert one.size == pytest.approx(same.size, abs=6e-6)


def test_fine_grid_reaches_the_outer_points_of_a_coarse_map() -> None:
    coarse = Surface(waves((60, 70), (4e-6, 4e-6)), (4e-6, 4e-6))
    fine = Surface(waves((260, 300), (1e-6, 1e-6)), (1e-6, 1e-6))
    one, two = placement.match_grids(coarse, fine)
    assert one.shape == two.shape == (4 * 59 + 1, 4 * 69 + 1)
    np.testing.assert_allclose(one.heights[::4, ::4], coarse.heights, rtol=1e-9, atol=1e-15)


def test_equal_maps_stay_as_they_are() -> None:
    surface = Surface(waves(SHAPE, PIXEL), PIXEL)
    other = Surface(surface.heights[::-1], PIXEL)
    one, two = placement.match_grids(surface, other)
    assert one.heights.tobytes() == surface.heights.tobytes()
    assert two.heights.tobytes() == other.heights.tobytes()
    assert placement.match_grids(surface, other, mirrored=True)[1].heights.tobytes() == (
        other.heights[:, ::-1].tobytes()
    )


def test_holes_are_neither_lost_nor_accepted() -> None:
    heights = waves((60, 60), (2e-6, 2e-6))
    heights[30:33, 30:33] = np.nan
    holed = Surface(heights, (2e-6, 2e-6))
    other = Surface(waves((90, 90), (1.5e-6, 1.5e-6)), (1.5e-6, 1.5e-6))
    one, two = placement.match_grids(holed, other, angle=10)
    assert one.missing == 9
    assert two.missing == 0
    assert not one.holes_masked
    one, two = placement.match_grids(other, holed.masked(), angle=10)
    assert two.missing > 9
    assert two.holes_masked
    assert not one.holes_masked


# All of them, and such as are next to what is exact.
SHIFTS = st.floats(-6e-5, 6e-5) | st.floats(-1e-11, 1e-11)
EDGES = st.floats(5e-7, 6e-6) | st.floats(-1e-12, 1e-12).map(lambda part: 2e-6 + part)


@settings(max_examples=30)
@given(
    st.tuples(SHIFTS, SHIFTS),
    st.floats(-180, 180) | st.floats(-1e-4, 1e-4) | st.sampled_from([0.0, 90.0]),
    st.booleans(),
    st.tuples(EDGES, EDGES),
)
# Turned by 1e-6 of a pixel over the map: on its edge as a whole, beyond it in a part.
@example((0.0, 0.0), 1.2651743795826855e-06, False, (5e-7, 1.2651743795826855e-06))
@example((0.0, 2e-12), 1e-06, True, (2e-6, 2e-6))
def test_overlap_of_matched_grids_has_no_missing_points(offset, angle, mirrored, pixel) -> None:
    first = Surface(waves((40, 50), (2e-6, 2e-6)), (2e-6, 2e-6))
    second = Surface(waves((40, 30), pixel), pixel)
    try:
        one, two = placement.match_grids(first, second, offset, angle, mirrored)
    except InputError as error:
        if "do not overlap" not in str(error):
            raise
        return
    assert one.shape == two.shape
    assert one.missing == two.missing == 0


def test_a_small_fine_map_on_a_large_coarse_one_needs_little_memory() -> None:
    # On the whole coarse map the fine grid would have 10¹⁰ points.
    coarse = Surface(np.zeros((1000, 1000)), (1e-5, 1e-5))
    fine = Surface(waves((50, 60), (1e-7, 1e-7)), (1e-7, 1e-7))
    one, two = placement.match_grids(coarse, fine, (1e-3, -2e-3), 30)
    assert one.pixel == pytest.approx((1e-7, 1e-7))
    assert one.shape == two.shape
    assert 20 < min(one.shape) < max(one.shape) < 60


def test_maps_that_do_not_meet() -> None:
    surface = Surface(waves(SHAPE, PIXEL), PIXEL)
    with pytest.raises(InputError, match="the maps do not overlap"):
        placement.match_grids(surface, surface, (1e-3, 0.0))
    with pytest.raises(InputError, match="second must be a Surface, got ndarray"):
        placement.match_grids(surface, surface.heights)
