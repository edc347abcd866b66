from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

from roughcontact.errors import InputError
from roughcontact.surface import roughness
from roughcontact.surface.form import level
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface

PIXEL = (2e-6, 3e-6)
ORIGIN = Provenance("map.opd", "Wyko", "height", ("made",))


def rough(shape: tuple[int, int] = (6, 9)) -> np.ndarray:
    return 1e-6 * np.random.default_rng(4).standard_normal(shape)


def surface_with_holes() -> Surface:
    heights = rough()
    heights[2:4, 5] = np.nan
    return Surface(heights, PIXEL, ORIGIN)


# --- what is kept ----------------------------------------------------------------------------


def test_heights_are_read_only_float64() -> None:
    surface = Surface(rough(), PIXEL)
    assert surface.heights.dtype == np.float64
    with pytest.raises(ValueError, match="read-only"):
        surface.heights[0, 0] = 1
    with pytest.raises(FrozenInstanceError):
        surface.heights = rough()
    with pytest.raises(FrozenInstanceError):
        surface.pixel = (1.0, 1.0)


def test_surface_copies_array_of_caller() -> None:
    heights = rough()
    surface = Surface(heights, PIXEL)
    kept = heights.copy()
    heights[:] = 7
    np.testing.assert_array_equal(surface.heights, kept)
    assert heights.flags.writeable


@pytest.mark.parametrize(
    "given",
    [
        lambda base: base[:],
        lambda base: base.T,
        lambda base: base[::2, 1:],
        lambda base: np.asfortranarray(base),
        lambda base: np.broadcast_to(base[0], (4, 9)),
    ],
)
def test_views_of_a_writeable_array_are_copied(given) -> None:
    base = rough()
    view = given(base)
    view.flags.writeable = False
    surface = Surface(view, PIXEL)
    kept = view.copy()
    base[:] = 7
    np.testing.assert_array_equal(surface.heights, kept)


def test_the_surface_of_a_surface_shares_its_heights() -> None:
    # Large maps: a change of pixel or provenance must not double the memory.
    surface = Surface(rough(), PIXEL)
    assert np.shares_memory(replace(surface, pixel=(1.0, 1.0)).heights, surface.heights)


@pytest.mark.parametrize("dtype", [np.int8, np.uint16, np.int64, np.float32, ">f8"])
def test_other_numbers_become_float64(dtype) -> None:
    heights = np.array([[1, 2, 3], [4, 5, 6]], dtype)
    surface = Surface(heights, PIXEL)
    assert surface.heights.dtype == np.float64
    assert surface.heights.dtype.isnative
    np.testing.assert_array_equal(surface.heights, [[1, 2, 3], [4, 5, 6]])
    assert surface.heights[0, 2] == 3  # [y, x]


def test_lists_are_accepted() -> None:
    surface = Surface([[1, 2], [3, 4.5]], [1, 2])
    np.testing.assert_array_equal(surface.heights, [[1, 2], [3, 4.5]])
    assert surface.pixel == (1.0, 2.0)
    assert all(type(edge) is float for edge in surface.pixel)


def test_shape_and_size_are_y_x() -> None:
    surface = Surface(rough((6, 9)), (2e-6, 3e-6))
    assert surface.shape == (6, 9)
    assert surface.size == pytest.approx((12e-6, 27e-6), rel=1e-15)
    assert surface.missing == 0
    assert surface.provenance == Provenance("", "", "", ())
    assert not surface.holes_masked


# --- bad input -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("heights", "words"),
    [
        (np.zeros((1, 7)), "heights of one row are a profile: give the 7 heights as a 1-D array"),
        (np.zeros((7, 1)), r"heights must be a 2-D array.*at least 2 × 2.*got shape \(7, 1\)"),
        (np.zeros((7, 0)), r"heights.*got shape \(7, 0\)"),
        (np.zeros((0, 0)), r"heights.*got shape \(0, 0\)"),
        (np.zeros((2, 3, 4)), r"heights.*\(2, 3, 4\)"),
        (np.zeros((3, 3), bool), "heights.*bool"),
        (3.0, "heights must be an array of numbers"),
        (np.zeros((2, 2), np.complex64), "heights must be real.*got dtype complex64"),
        ([["a", "b"], ["c", "d"]], "heights must be real numbers.*got dtype <U1"),
        ([[1.0, None], [2.0, 3.0]], "heights must be real numbers.*got dtype object"),
        (np.zeros((2, 2), "M8[s]"), "heights must be real numbers.*datetime64"),
        ([[1.0, np.inf], [-np.inf, 3.0]], "heights has 2 infinite values; mark.*NaN"),
        (np.full((2, 3), np.nan), "heights has no finite value: every point is missing"),
    ],
)
def test_invalid_heights_raise_input_error(heights, words: str) -> None:
    with pytest.raises(InputError, match=words) as caught:
        Surface(heights, PIXEL)
    assert isinstance(caught.value, ValueError)


def test_ragged_heights() -> None:
    with pytest.raises(InputError, match="heights"):
        Surface([[1.0, 2.0], [3.0]], PIXEL)


def test_a_masked_array_does_not_lose_its_mask() -> None:
    heights = np.ma.masked_array(rough(), mask=False)
    heights[2, 3] = np.ma.masked
    heights.data[2, 3] = 1.0  # what lies under a mask is anything
    try:
        surface = Surface(heights, PIXEL)
    except InputError:
        return  # refusing is as good
    assert np.isnan(surface.heights[2, 3])
    assert surface.missing == 1


@pytest.mark.parametrize(
    "pixel", [(0, 1e-6), (1e-6, 0.0), (-1e-6, 1e-6), (1e-6, np.nan), (np.nan, 1e-6), (1, -np.inf)]
)
def test_a_pixel_is_positive(pixel: tuple[float, float]) -> None:
    with pytest.raises(InputError, match=r"pixel must be positive and finite \(dy, dx\)"):
        Surface(rough(), pixel)


@pytest.mark.parametrize("pixel", [1e-6, (1e-6,), (1e-6, 1e-6, 1e-6), ("1 um",)])
def test_a_pixel_is_a_pair(pixel) -> None:
    with pytest.raises(InputError, match=r"pixel must be a pair \(dy, dx\)"):
        Surface(rough(), pixel)


# --- preparation -----------------------------------------------------------------------------


def assert_prepared(before: Surface, after: Surface, step: str) -> None:
    """A new, read-only surface of the same origin with one more step; the old one untouched."""
    assert after is not before
    assert not after.heights.flags.writeable
    assert after.pixel == before.pixel == PIXEL
    assert before.provenance == ORIGIN
    assert replace(after.provenance, origin=None, operations=ORIGIN.operations) == ORIGIN
    assert after.provenance.steps[:-1] == ("made",)
    assert after.provenance.steps[-1].startswith(step)


@pytest.mark.parametrize("form", ["plane", "quadric", "mean"])
def test_leveled(form: str) -> None:
    before = surface_with_holes()
    kept = before.heights.copy()
    after = before.leveled(form)
    assert_prepared(before, after, "leveled")
    assert form in after.provenance.steps[-1]
    np.testing.assert_array_equal(after.heights, level(kept, form))
    np.testing.assert_array_equal(before.heights, kept)
    assert after.missing == before.missing == 2


def test_filled() -> None:
    before = surface_with_holes()
    after = before.filled()
    assert_prepared(before, after, "filled: 2 missing points")
    assert (before.missing, after.missing) == (2, 0)
    there = ~np.isnan(before.heights)
    np.testing.assert_array_equal(after.heights[there], before.heights[there])
    rim = before.heights[1:5, 4:7]
    assert (after.heights[~there] <= np.nanmax(rim)).all()
    assert (after.heights[~there] >= np.nanmin(rim)).all()


def test_filled_uses_pixel_of_each_axis() -> None:
    # With dy ≫ dx the heights to the left and right count, those above and below do not.
    heights = surface_with_holes().heights
    filled = Surface(heights, (1e-3, 1e-6)).filled().heights
    beside = (heights[2:4, 4] + heights[2:4, 6]) / 2
    np.testing.assert_allclose(filled[2:4, 5], beside, atol=1e-5 * np.nanmax(heights))


def test_masked() -> None:
    before = surface_with_holes()
    after = before.masked()
    assert_prepared(before, after, "masked: 2 missing points")
    assert after.holes_masked
    assert not before.holes_masked
    np.testing.assert_array_equal(after.heights, before.heights)
    # Later steps keep it.
    assert after.leveled().holes_masked
    assert after.cropped((0, 4), (0, 9)).holes_masked


def test_cropped() -> None:
    before = surface_with_holes()
    after = before.cropped((1, 4), (2, 7))
    assert_prepared(before, after, "cropped: rows 1:4, columns 2:7")
    np.testing.assert_array_equal(after.heights, before.heights[1:4, 2:7])
    assert after.shape == (3, 5)
    assert after.missing == 2
    # A view would keep the whole map in memory.
    assert not np.shares_memory(after.heights, before.heights)
    with pytest.raises(InputError, match=r"columns.*9.*got 2:10"):
        before.cropped((1, 4), (2, 10))


def test_fill_and_mask_of_whole_map_add_no_step() -> None:
    whole = Surface(rough(), PIXEL, ORIGIN)
    assert whole.filled().provenance == ORIGIN
    assert whole.masked().provenance == ORIGIN
    assert not whole.masked().holes_masked


# --- roughness -------------------------------------------------------------------------------


def test_roughness_is_that_of_the_heights() -> None:
    surface = surface_with_holes()
    assert surface.Sq == roughness.rms_height(surface.heights)
    assert surface.Sdq == roughness.rms_gradient(surface.heights, PIXEL)


# --- a form, another grid ------------------------------------------------------------------------


def punch(shape: tuple[int, int] = (6, 9)) -> Surface:
    heights = np.full(shape, np.nan)
    heights[1:5, 2:7] = 0.0
    origin = Provenance("nominal punch", steps=("the outside never touches",))
    return Surface(heights, PIXEL, origin, holes_masked=True)


def test_with_form_adds_the_heights() -> None:
    before = Surface(rough(), PIXEL, ORIGIN)
    form = Surface(rough()[::-1], PIXEL, Provenance("nominal sphere"))
    after = before.with_form(form)
    assert_prepared(before, after, "form added: nominal sphere")
    np.testing.assert_array_equal(after.heights, before.heights + form.heights)
    np.testing.assert_array_equal(form.with_form(before).heights, after.heights)
    assert not after.holes_masked
    assert before.with_form(Surface(rough(), PIXEL)).provenance.steps[-1].endswith("another map")


def test_the_outside_of_a_body_needs_no_mask() -> None:
    before = Surface(rough(), PIXEL, ORIGIN)
    for after in (before.with_form(punch()), punch().with_form(before)):
        assert after.holes_masked
        np.testing.assert_array_equal(np.isnan(after.heights), np.isnan(punch().heights))
    assert before.with_form(punch()).provenance.steps[-1] == (
        "form added: nominal punch (the outside never touches)"
    )


def test_holes_of_a_measurement_are_not_accepted_by_a_form() -> None:
    whole = Surface(np.zeros((6, 9)), PIXEL)
    assert not surface_with_holes().with_form(whole).holes_masked
    assert surface_with_holes().with_form(whole).missing == 2
    assert surface_with_holes().masked().with_form(whole).holes_masked
    # Next to the outside they would be filled, or masked, together with it.
    for one, other in ((surface_with_holes(), punch()), (punch(), surface_with_holes())):
        with pytest.raises(InputError, match="2 missing points of one map lie inside the other"):
            one.with_form(other)
    masked = surface_with_holes().masked().with_form(punch())
    assert masked.holes_masked
    assert masked.missing == 6 * 9 - 4 * 5 + 2
    # A body that is not said to end there has holes like any other.
    holes = replace(punch(), holes_masked=False)
    assert not Surface(rough(), PIXEL).with_form(holes).holes_masked


def test_holes_outside_of_a_body_do_not_matter() -> None:
    heights = rough()
    heights[0, :] = np.nan
    after = Surface(heights, PIXEL).with_form(punch())
    assert after.holes_masked
    assert after.missing == punch().missing


def test_a_form_needs_the_grid() -> None:
    surface = Surface(rough(), PIXEL)
    with pytest.raises(InputError, match=r"form has \(5, 9\) pixels.*shape=surface.shape"):
        surface.with_form(Surface(rough((5, 9)), PIXEL))
    with pytest.raises(InputError, match=r"form has .*aligned"):
        surface.with_form(Surface(rough(), (2e-6, 3.1e-6)))
    with pytest.raises(InputError, match=r"form must be a Surface, got 0\.0"):
        surface.with_form(1e-3)
    outside = np.full((6, 9), np.nan)
    outside[0, 0] = 1.0
    with pytest.raises(InputError, match="every point is missing"):
        surface.with_form(punch()).with_form(Surface(outside, PIXEL, None, True))


@pytest.mark.parametrize("quarters", [0, 1, 2, 3])
def test_aligned_by_quarter_turns_is_rotated(quarters: int) -> None:
    before = Surface(rough((7, 7)), (2e-6, 2e-6), ORIGIN)
    after = before.aligned(before, angle=90 * quarters)
    assert after.heights.tobytes() == before.rotated(90 * quarters).heights.tobytes()
    assert after.pixel == before.pixel


def test_aligned_without_motion_keeps_the_bits() -> None:
    before = surface_with_holes()
    after = before.aligned(Surface(np.zeros((6, 9)), PIXEL))
    assert_prepared(before, after, "aligned: point by point onto 6 × 9 points of 2 µm × 3 µm")
    assert after.heights.tobytes() == before.heights.tobytes()
    assert not after.holes_masked
    assert before.masked().aligned(before).holes_masked


def test_aligned_adds_step() -> None:
    grid = Surface(np.zeros((8, 8)), (1.5e-6, 4e-6))
    before = Surface(rough((30, 40)), PIXEL, ORIGIN)
    after = before.aligned(grid, (4e-6, -5e-6), 30, mirrored=True)
    assert after.provenance.steps[-1] == (
        "aligned: mirrored in x, turned by 30 degrees counter-clockwise, shifted by "
        "(4 µm, -5 µm) (y, x), by a bicubic spline onto 8 × 8 points of 1.5 µm × 4 µm"
    )
    assert after.shape == grid.shape
    assert after.pixel == grid.pixel
    coarse = before.aligned(Surface(np.zeros((6, 6)), (1.6e-5, 6e-6)))
    assert (
        "after a Gaussian S-filter at 32 µm along y and 12 µm along x onto"
        in (coarse.provenance.steps[-1])
    )
    assert coarse.provenance.steps[-1].endswith("12 of them off the map")
    assert coarse.missing == 12


def test_points_aligned_off_map_are_not_masked() -> None:
    grid = Surface(np.zeros((6, 9)), PIXEL)
    after = surface_with_holes().masked().aligned(grid, offset=(0, 3e-6))
    assert not after.holes_masked
    assert after.missing == 6 + 2


def test_aligned_refuses() -> None:
    surface = Surface(rough(), PIXEL)
    with pytest.raises(InputError, match="do not overlap"):
        surface.aligned(surface, offset=(1.2e-5, 0))
    with pytest.raises(InputError, match="grid must be a Surface"):
        surface.aligned((6, 9))
    with pytest.raises(InputError, match="angle must be"):
        surface.aligned(surface, angle=np.nan)


def test_inverted_and_flipped_map() -> None:
    heights = np.array([[1.0, 2.0, 3.0], [4.0, np.nan, 6.0]])
    surface = Surface(heights, (2e-6, 1e-6))
    np.testing.assert_array_equal(surface.inverted().heights, -heights)
    np.testing.assert_array_equal(surface.flipped().heights, heights[:, ::-1])
    np.testing.assert_array_equal(surface.flipped("y").heights, heights[::-1])
    assert surface.flipped("y").pixel == surface.pixel
    # Two mirror images are half a turn, and a replica of a replica is the surface.
    turned = surface.flipped("x").flipped("y")
    np.testing.assert_array_equal(turned.heights, surface.rotated(180).heights)
    np.testing.assert_array_equal(surface.inverted().inverted().heights, heights)
    with pytest.raises(InputError, match="axis must be 'x' or 'y'"):
        surface.flipped("z")
