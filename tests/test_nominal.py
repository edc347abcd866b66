"""Nominal bodies as surfaces, as text, and two maps on one grid."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from roughcontact.errors import InputError
from roughcontact.surface import nominal, shapes
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface

SHAPE, PIXEL = (31, 44), (2e-6, 3e-6)
GRID = {"shape": SHAPE, "pixel": PIXEL}


def waves(shape, pixel, offset=(0.0, 0.0), angle=0.0, mirrored=False):
    """Heights whose shortest wave is 35 µm, as a map laid there would show them."""
    y, x = ((np.arange(n) - (n - 1) / 2) * d for n, d in zip(shape, pixel, strict=True))
    y, x = np.broadcast_arrays(y[:, None] - offset[0], x - offset[1])
    t = -math.radians(angle)
    y, x = y * math.cos(t) - x * math.sin(t), x * math.cos(t) + y * math.sin(t)
    x = -x if mirrored else x
    y, x = 2e5 * y, 2e5 * x
    return 1e-7 * (np.sin(0.7 * x + 0.3 * y + 0.4) + np.cos(0.5 * x - 0.6 * y) + 0.05 * y)


# --- bodies -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("body", "heights", "source"),
    [
        (nominal.flat(**GRID), np.zeros(SHAPE), "nominal flat"),
        (
            nominal.sphere(radius=1e-3, **GRID),
            shapes.sphere(SHAPE, PIXEL, 1e-3),
            "nominal sphere of radius 1 mm",
        ),
        (
            nominal.ellipsoid(radii=(1e-3, 5e-4), angle=30, **GRID),
            shapes.ellipsoid(SHAPE, PIXEL, (1e-3, 5e-4), 30),
            "nominal ellipsoid of the radii of curvature 1 mm along y and 500 µm along x, turned "
            "by 30 degrees counter-clockwise",
        ),
        (
            nominal.cylinder(radius=1e-3, angle=90, **GRID),
            shapes.cylinder(SHAPE, PIXEL, 1e-3, 90),
            "nominal cylinder of radius 1 mm, axis at 90 degrees counter-clockwise from x",
        ),
        (
            nominal.punch(radius=2.5e-5, edge_radius=1e-6, **GRID),
            shapes.punch(SHAPE, PIXEL, 2.5e-5, 1e-6),
            "nominal round punch of radius 25 µm with an edge radius of 1 µm",
        ),
        (
            nominal.rectangular_punch(sides=(2e-5, 4e-5), **GRID),
            shapes.rectangular_punch(SHAPE, PIXEL, (2e-5, 4e-5)),
            "nominal rectangular punch of 20 µm along y by 40 µm along x",
        ),
        (
            nominal.cone(slope=0.01, **GRID),
            shapes.cone(SHAPE, PIXEL, 0.01),
            "nominal cone of slope 0.01",
        ),
        (
            nominal.wedge(slope=0.01, angle=45, **GRID),
            shapes.wedge(SHAPE, PIXEL, 0.01, 45),
            "nominal wedge of slope 0.01, ridge at 45 degrees counter-clockwise from x",
        ),
    ],
)
def test_a_body_is_a_surface_that_says_what_it_is(body, heights, source) -> None:
    np.testing.assert_array_equal(body.heights, heights)
    assert body.pixel == PIXEL
    assert body.provenance.source == source
    outside = np.isnan(heights).sum()
    # Nobody has to mask the outside of a nominal body.
    assert body.holes_masked == (outside > 0)
    steps = (f"{outside} points outside the body never touch",) if outside else ()
    assert body.provenance.steps == steps


def test_a_body_may_stand_aside() -> None:
    for make, sizes in (
        (nominal.sphere, {"radius": 1e-3}),
        (nominal.cylinder, {"radius": 1e-3}),
        (nominal.punch, {"radius": 1e-5}),
        (nominal.rectangular_punch, {"sides": (1e-5, 1e-5)}),
        (nominal.ellipsoid, {"radii": (1e-3, 1e-3)}),
        (nominal.cone, {"slope": 0.1}),
        (nominal.wedge, {"slope": 0.1}),
    ):
        body = make(**sizes, **GRID, center=(7, 12))
        assert body.heights[7, 12] == 0 == np.nanmax(body.heights)
        assert "(7, 12) (y, x)" in body.provenance.steps[0]


# --- as text ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("flat", nominal.flat(**GRID)),
        ("sphere 10 mm", nominal.sphere(radius=0.01, **GRID)),
        ("  Sphere 10mm ", nominal.sphere(radius=0.01, **GRID)),
        ("sphere 1e-2 m", nominal.sphere(radius=0.01, **GRID)),
        (
            "ellipsoid 10 mm 4 mm 30 deg",
            nominal.ellipsoid(radii=(0.01, 0.004), angle=30, **GRID),
        ),
        ("ellipsoid 10 mm 4 mm", nominal.ellipsoid(radii=(0.01, 0.004), **GRID)),
        ("cylinder 5 mm", nominal.cylinder(radius=0.005, **GRID)),
        ("cylinder 5 mm 90 deg", nominal.cylinder(radius=0.005, angle=90, **GRID)),
        ("cylinder 5 mm -12.5°", nominal.cylinder(radius=0.005, angle=-12.5, **GRID)),
        ("punch 20 um", nominal.punch(radius=2e-5, **GRID)),
        ("punch 20 \u03bcm edge 2 \u00b5m", nominal.punch(radius=2e-5, edge_radius=2e-6, **GRID)),
        ("punch 20 um 10 um", nominal.rectangular_punch(sides=(2e-5, 1e-5), **GRID)),
        (
            "punch 20 um 10 um edge 500 nm",
            nominal.rectangular_punch(sides=(2e-5, 1e-5), edge_radius=5e-7, **GRID),
        ),
        ("cone 0.01", nominal.cone(slope=0.01, **GRID)),
        ("cone 1e-2", nominal.cone(slope=0.01, **GRID)),
        ("wedge 0.01 90 deg", nominal.wedge(slope=0.01, angle=90, **GRID)),
        ("wedge .01", nominal.wedge(slope=0.01, **GRID)),
    ],
)
def test_texts_that_are_bodies(text: str, expected: Surface) -> None:
    body = nominal.parse(text)(**GRID)
    np.testing.assert_array_equal(body.heights, expected.heights)
    assert body.provenance == expected.provenance


def test_every_form_shown_is_taken_and_may_stand_aside() -> None:
    for form in nominal.FORMS:
        body = nominal.parse(form)(**GRID, center=(7, 12))
        assert body.heights[7, 12] == 0 == np.nanmax(body.heights)


@pytest.mark.parametrize(
    "text",
    [
        "", "  ", "spere 10 mm", "sphere", "sphere 10 mm 5 mm", "sphere 10 mm 30 deg",
        "sphere 10,5 mm", "sphere 10 mm!", "10 mm sphere", "flat 3 mm", "ellipsoid 3 mm",
        "cone 0.01 30 deg", "cylinder deg", "cylinder 5 mm 1e999 deg", "punch",
        "cone 0.1 edge 1 um", None, 5,
    ],
)  # fmt: skip
def test_texts_that_are_none(text) -> None:
    with pytest.raises(InputError) as caught:
        nominal.parse(text, "--body")
    message = str(caught.value)
    assert message.startswith("--body must read like one of 'flat', 'sphere 10 mm', ")
    assert message.endswith(f"got {text!r}")
    assert "\n" not in message


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("sphere 10", "--body: the radius of the sphere needs a length .*got '10' .*no unit"),
        ("sphere 10 N", "--body: the radius of the sphere needs a length .*got '10 N'"),
        ("cylinder 30 deg", "--body: the radius of the cylinder needs a length .*got '30 deg'"),
        ("cylinder -1 mm", "--body: the radius of the cylinder must be positive"),
        ("ellipsoid 1 mm 0 mm", "--body: each radius of curvature of the ellipsoid must be pos"),
        ("punch 1 mm 2", "--body: each side of the punch needs a length"),
        ("punch 1 mm edge", "--body: the edge radius of the punch needs a length"),
        ("punch 1 mm edge 2", "--body: the edge radius of the punch needs a length"),
        ("cone 1 mm", "--body: the slope of the cone must be a number without a unit, got '1 mm'"),
        ("cone -0.1", "--body: the slope of the cone must be positive"),
        ("wedge 0", "--body: the slope of the wedge must be positive"),
    ],
)
def test_sizes_that_are_none(text: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        nominal.parse(text, "--body")


@given(st.text(alphabet="flatspherconewdgpuy 0123456789.-+emk°", max_size=30))
def test_no_text_makes_another_error(text: str) -> None:
    try:
        body = nominal.parse(text)
    except InputError:
        return
    assert callable(body)


# --- two maps on one grid ------------------------------------------------------------------------


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("angle", [0.0, 90.0, 25.0])
def test_two_maps_meet_where_they_overlap(angle: float, mirrored: bool) -> None:
    offset = (2.3e-5, -3.1e-5)
    first = Surface(waves((80, 100), (2e-6, 2e-6)), (2e-6, 2e-6), Provenance("a"))
    second = Surface(waves((90, 70), (2.5e-6, 2.2e-6)), (2.5e-6, 2.2e-6), Provenance("b"))
    one, two = nominal.matched(first, second, offset, angle, mirrored)
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
    one, two = nominal.matched(coarse, fine, (1e-5, 1e-5))
    # 2.5 µm is similar to 3 µm, 1 µm is not to 4 µm.
    assert one.pixel == two.pixel == (1e-6, 3e-6)
    # All of the fine map lies on the coarse one: only its rim may be lost.
    assert one.shape[0] >= 88
    assert one.size[1] >= fine.size[1] - 2 * 3e-6
    other, same = nominal.matched(fine, coarse, (-1e-5, -1e-5))
    assert same.pixel == fine.pixel
    assert other.heights.tobytes() == fine.heights.tobytes()
    # Seen from the other map it is the same contact, within half a pixel of its cut.
    assert one.size == pytest.approx(same.size, abs=6e-6)


def test_equal_maps_stay_as_they_are() -> None:
    surface = Surface(waves(SHAPE, PIXEL), PIXEL)
    other = Surface(surface.heights[::-1], PIXEL)
    one, two = nominal.matched(surface, other)
    assert one.heights.tobytes() == surface.heights.tobytes()
    assert two.heights.tobytes() == other.heights.tobytes()
    assert nominal.matched(surface, other, mirrored=True)[1].heights.tobytes() == (
        other.heights[:, ::-1].tobytes()
    )


def test_holes_are_neither_lost_nor_accepted() -> None:
    heights = waves((60, 60), (2e-6, 2e-6))
    heights[30:33, 30:33] = np.nan
    holed = Surface(heights, (2e-6, 2e-6))
    other = Surface(waves((90, 90), (1.5e-6, 1.5e-6)), (1.5e-6, 1.5e-6))
    one, two = nominal.matched(holed, other, angle=10)
    assert one.missing == 9
    assert two.missing == 0
    assert not one.holes_masked
    one, two = nominal.matched(other, holed.masked(), angle=10)
    assert two.missing > 9
    assert two.holes_masked
    assert not one.holes_masked


@settings(max_examples=30)
@given(
    st.tuples(st.floats(-6e-5, 6e-5), st.floats(-6e-5, 6e-5)),
    st.floats(-180, 180),
    st.booleans(),
    st.tuples(st.floats(5e-7, 6e-6), st.floats(5e-7, 6e-6)),
)
def test_what_two_maps_share_is_never_missing(offset, angle, mirrored, pixel) -> None:
    first = Surface(waves((40, 50), (2e-6, 2e-6)), (2e-6, 2e-6))
    second = Surface(waves((40, 30), pixel), pixel)
    try:
        one, two = nominal.matched(first, second, offset, angle, mirrored)
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
    one, two = nominal.matched(coarse, fine, (1e-3, -2e-3), 30)
    assert one.pixel == pytest.approx((1e-7, 1e-7))
    assert one.shape == two.shape
    assert 20 < min(one.shape) < max(one.shape) < 60


def test_maps_that_do_not_meet() -> None:
    surface = Surface(waves(SHAPE, PIXEL), PIXEL)
    with pytest.raises(InputError, match="the maps do not overlap"):
        nominal.matched(surface, surface, (1e-3, 0.0))
    with pytest.raises(InputError, match="second must be a Surface, got ndarray"):
        nominal.matched(surface, surface.heights)
