"""Nominal bodies as surfaces, as text, and two maps on one grid."""

import pickle
import re

import numpy as np
import pytest
from hypothesis import given, strategies as st

import roughcontact as rc
from roughcontact.errors import InputError
from roughcontact.surface import nominal_bodies, shapes
from roughcontact.surface.surface import Surface

SHAPE, PIXEL = (31, 44), (2e-6, 3e-6)
GRID = {"shape": SHAPE, "pixel": PIXEL}


# --- bodies -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("body", "heights", "source"),
    [
        (nominal_bodies.flat(**GRID), np.zeros(SHAPE), "nominal flat"),
        (
            nominal_bodies.sphere(radius=1e-3, **GRID),
            shapes.sphere(SHAPE, PIXEL, 1e-3),
            "nominal sphere of radius 1 mm",
        ),
        (
            nominal_bodies.ellipsoid(radii=(1e-3, 5e-4), angle=30, **GRID),
            shapes.ellipsoid(SHAPE, PIXEL, (1e-3, 5e-4), 30),
            "nominal ellipsoid of the radii of curvature 1 mm along y and 500 µm along x, turned "
            "by 30 degrees counter-clockwise",
        ),
        (
            nominal_bodies.cylinder(radius=1e-3, angle=90, **GRID),
            shapes.cylinder(SHAPE, PIXEL, 1e-3, 90),
            "nominal cylinder of radius 1 mm, axis at 90 degrees counter-clockwise from x",
        ),
        (
            nominal_bodies.punch(radius=2.5e-5, edge_radius=1e-6, **GRID),
            shapes.punch(SHAPE, PIXEL, 2.5e-5, 1e-6),
            "nominal round punch of radius 25 µm with an edge radius of 1 µm",
        ),
        (
            nominal_bodies.rectangular_punch(sides=(2e-5, 4e-5), **GRID),
            shapes.rectangular_punch(SHAPE, PIXEL, (2e-5, 4e-5)),
            "nominal rectangular punch of 20 µm along y by 40 µm along x",
        ),
        (
            nominal_bodies.cone(slope=0.01, **GRID),
            shapes.cone(SHAPE, PIXEL, 0.01),
            "nominal cone of slope 0.01",
        ),
        (
            nominal_bodies.wedge(slope=0.01, angle=45, **GRID),
            shapes.wedge(SHAPE, PIXEL, 0.01, 45),
            "nominal wedge of slope 0.01, ridge at 45 degrees counter-clockwise from x",
        ),
    ],
)
def test_body_is_surface_with_provenance(body, heights, source) -> None:
    np.testing.assert_array_equal(body.heights, heights)
    assert body.pixel == PIXEL
    assert body.provenance.source == source
    outside = np.isnan(heights).sum()
    # The outside of a nominal body is masked.
    assert body.holes_masked == (outside > 0)
    steps = (f"{outside} points outside the body never touch",) if outside else ()
    assert body.provenance.steps == steps


def test_body_may_be_outside_map() -> None:
    for make, sizes in (
        (nominal_bodies.sphere, {"radius": 1e-3}),
        (nominal_bodies.cylinder, {"radius": 1e-3}),
        (nominal_bodies.punch, {"radius": 1e-5}),
        (nominal_bodies.rectangular_punch, {"sides": (1e-5, 1e-5)}),
        (nominal_bodies.ellipsoid, {"radii": (1e-3, 1e-3)}),
        (nominal_bodies.cone, {"slope": 0.1}),
        (nominal_bodies.wedge, {"slope": 0.1}),
    ):
        body = make(**sizes, **GRID, center=(7, 12))
        assert body.heights[7, 12] == 0 == np.nanmax(body.heights)
        assert "(7, 12) (y, x)" in body.provenance.steps[0]


# --- as text ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("flat", nominal_bodies.flat(**GRID)),
        ("sphere 10 mm", nominal_bodies.sphere(radius=0.01, **GRID)),
        ("  Sphere 10mm ", nominal_bodies.sphere(radius=0.01, **GRID)),
        ("sphere 1e-2 m", nominal_bodies.sphere(radius=0.01, **GRID)),
        (
            "ellipsoid 10 mm 4 mm 30 deg",
            nominal_bodies.ellipsoid(radii=(0.01, 0.004), angle=30, **GRID),
        ),
        ("ellipsoid 10 mm 4 mm", nominal_bodies.ellipsoid(radii=(0.01, 0.004), **GRID)),
        ("cylinder 5 mm", nominal_bodies.cylinder(radius=0.005, **GRID)),
        ("cylinder 5 mm 90 deg", nominal_bodies.cylinder(radius=0.005, angle=90, **GRID)),
        ("cylinder 5 mm -12.5°", nominal_bodies.cylinder(radius=0.005, angle=-12.5, **GRID)),
        ("punch 20 um", nominal_bodies.punch(radius=2e-5, **GRID)),
        (
            "punch 20 \u03bcm edge 2 \u00b5m",
            nominal_bodies.punch(radius=2e-5, edge_radius=2e-6, **GRID),
        ),
        ("punch 20 um 10 um", nominal_bodies.rectangular_punch(sides=(2e-5, 1e-5), **GRID)),
        (
            "punch 20 um 10 um edge 500 nm",
            nominal_bodies.rectangular_punch(sides=(2e-5, 1e-5), edge_radius=5e-7, **GRID),
        ),
        ("cone 0.01", nominal_bodies.cone(slope=0.01, **GRID)),
        ("cone 1e-2", nominal_bodies.cone(slope=0.01, **GRID)),
        ("wedge 0.01 90 deg", nominal_bodies.wedge(slope=0.01, angle=90, **GRID)),
        ("wedge .01", nominal_bodies.wedge(slope=0.01, **GRID)),
    ],
)
def test_texts_that_are_bodies(text: str, expected: Surface) -> None:
    body = nominal_bodies.parse(text)(**GRID)
    np.testing.assert_array_equal(body.heights, expected.heights)
    assert body.provenance == expected.provenance


def test_every_listed_form_is_parsed_with_any_center() -> None:
    for form in nominal_bodies.FORMS:
        body = nominal_bodies.parse(form)(**GRID, center=(7, 12))
        ends = np.nanmin(body.heights), np.nanmax(body.heights)
        assert body.heights[7, 12] == 0 == ends["-" not in form]


@pytest.mark.parametrize(
    "text",
    [
        "",
        "  ",
        "spere 10 mm",
        "sphere",
        "sphere 10 mm 5 mm",
        "sphere 10 mm 30 deg",
        "sphere 10,5 mm",
        "sphere 10 mm!",
        "10 mm sphere",
        "flat 3 mm",
        "ellipsoid 3 mm",
        "cone 0.01 30 deg",
        "cylinder deg",
        "cylinder 5 mm 1e999 deg",
        "punch",
        "cone 0.1 edge 1 um",
        None,
        5,
    ],
)
def test_invalid_texts_raise_input_error(text) -> None:
    with pytest.raises(InputError) as caught:
        nominal_bodies.parse(text, "--body")
    message = str(caught.value)
    assert message.startswith("--body must read like one of 'flat', 'sphere 10 mm', ")
    assert message.endswith(f"got {' '.join(repr(text).split())}")
    assert "\n" not in message


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("sphere 10", "--body: the radius of the sphere needs a length .*got '10' .*no unit"),
        ("sphere 10 N", "--body: the radius of the sphere needs a length .*got '10 N'"),
        ("cylinder 30 deg", "--body: the radius of the cylinder needs a length .*got '30 deg'"),
        ("cylinder 0 mm", "--body: the radius of the cylinder must not be 0; negative is conc"),
        ("ellipsoid 1 mm 0 mm", "--body: each radius of curvature of the ellipsoid must not be 0"),
        ("punch -1 mm", "--body: the radius of the punch must be positive"),
        ("punch 1 mm 2", "--body: each side of the punch needs a length"),
        ("punch 1 mm edge", "--body: the edge radius of the punch needs a length"),
        ("punch 1 mm edge 2", "--body: the edge radius of the punch needs a length"),
        ("cone 1 mm", "--body: the slope of the cone must be a number without a unit, got '1 mm'"),
        ("cone -0.1", "--body: the slope of the cone must be positive"),
        ("wedge 0", "--body: the slope of the wedge must be positive"),
    ],
)
def test_invalid_sizes_raise_input_error(text: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        nominal_bodies.parse(text, "--body")


@pytest.mark.parametrize("text", ["sphere 10 mm", "cylinder 5 mm 90 deg", "ellipsoid 4 mm 9 mm"])
def test_negative_radius_is_the_hollow_of_a_body(text: str) -> None:
    grid = {"shape": (9, 12), "pixel": (1e-5, 2e-5)}
    hollow = nominal_bodies.parse(re.sub(r" (?=\d+ mm)", " -", text))(**grid)
    np.testing.assert_array_equal(hollow.heights, -nominal_bodies.parse(text)(**grid).heights)


@given(st.text(alphabet="flatspherconewdgpuy 0123456789.-+emk°", max_size=30))
def test_no_text_makes_another_error(text: str) -> None:
    try:
        body = nominal_bodies.parse(text)
    except InputError:
        return
    assert callable(body)


# --- without a grid -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        (rc.sphere("6 mm"), nominal_bodies.sphere(radius=6e-3, **GRID)),
        (rc.sphere(radius=6e-3), nominal_bodies.sphere(radius=6e-3, **GRID)),
        (rc.sphere(6e-3, center=(7, 12)), nominal_bodies.sphere("6 mm", **GRID, center=(7, 12))),
        (rc.cylinder("5 mm", angle=90), nominal_bodies.cylinder(radius=5e-3, angle=90, **GRID)),
        (nominal_bodies.ellipsoid(("10 mm", "4 mm")), nominal_bodies.parse("ellipsoid 10 mm 4 mm")),
    ],
)
def test_body_without_grid_uses_grid_of_map(body, expected) -> None:
    made = body.sample_body(rc.Surface(np.zeros(SHAPE), PIXEL))
    expected = expected if isinstance(expected, rc.Surface) else expected(**GRID)
    np.testing.assert_array_equal(made.heights, expected.heights)
    assert made.provenance == expected.provenance
    again = pickle.loads(pickle.dumps(body))
    np.testing.assert_array_equal(again(**GRID).heights, expected.heights)


def test_profile_accepts_bodies_uniform_across_it() -> None:
    trace = rc.Surface(np.zeros(40), 1e-6)
    made = rc.cylinder("5 mm").sample_body(trace)
    assert made.is_profile
    assert made.provenance.origin.arguments["angle"] == 90.0
    assert not nominal_bodies.parse("flat").sample_body(trace).heights.any()
    for body in (rc.sphere("5 mm"), rc.cylinder("5 mm", angle=30)):
        with pytest.raises(rc.InputError, match="a profile takes"):
            body.sample_body(trace)


@pytest.mark.parametrize(
    ("size", "given", "message"),
    [
        ((), {}, "sphere takes radius, got nothing"),
        (("6 mm",), {"radius": "6 mm"}, "sphere takes radius, got radius, radius"),
        (("6 mm",), {"angle": 90}, "sphere takes radius, got radius, angle"),
        (("6 mm",), {"shape": SHAPE}, "pixel is needed"),
        (("6 mm",), {"pixel": PIXEL}, "shape is needed"),
        (("6 N",), {}, "radius needs a length"),
    ],
)
def test_invalid_arguments_raise_input_error(size, given, message: str) -> None:
    with pytest.raises(rc.InputError, match=message):
        rc.sphere(*size, **given)
