"""Solved contacts of smooth nominal bodies and Hertz's closed forms, through the public face."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.cautions import CautionTag
from roughcontact.contact import hertz_comparison
from roughcontact.contact.nominal_hertz import CIRCLE, ELLIPSE, LINE, SmoothContact, is_smooth
from roughcontact.errors import ArgumentRef
from roughcontact.surface import nominal_bodies
from roughcontact.uncertainty.intervals import uncertainty_intervals

STEEL = rc.Material(210e9, 0.3)
PEAK = "1 GPa"


def solve_under_peak(body: rc.Surface, **options: Any) -> tuple[rc.ContactResult, SmoothContact]:
    result = rc.solve(
        body, **{"material": STEEL, "load": f"hertz {PEAK}", "ceiling": None} | options
    )
    assert result.hertz is not None
    return result, result.hertz


def ball(points: int = 96, pixel: float = 1.2e-6, **options: Any) -> rc.Surface:
    return nominal_bodies.sphere(
        radius=0.005, shape=(points, points), pixel=(pixel, pixel), **options
    )


def test_a_ball_under_the_load_of_a_peak_has_that_peak() -> None:
    # The radius of contact, 34 µm, is 28 pixels; the error falls with their square.
    result, smooth = solve_under_peak(ball())
    assert smooth.shape.kind == CIRCLE
    assert smooth.max_pressure == pytest.approx(1e9, rel=1e-12)
    assert result.max_pressure == pytest.approx(1e9, rel=1e-3)
    assert result.approach == pytest.approx(smooth.approach, rel=1e-3)
    assert result.perimeter_corrected_area == pytest.approx(smooth.area, rel=0.01)
    assert hertz_comparison.equivalent_hertz_size(result) == pytest.approx(
        smooth.semi_axes, rel=1e-3
    )
    assert hertz_comparison.comparison_limits(result) == ()


@pytest.mark.parametrize("angle", [0, 30])
def test_an_ellipsoid_under_the_load_of_a_peak_has_that_peak(angle: float) -> None:
    body = nominal_bodies.ellipsoid(
        radii=(0.008, 0.003), angle=angle, shape=(128, 128), pixel=(0.9e-6, 0.9e-6)
    )
    result, smooth = solve_under_peak(body)
    assert smooth.shape.kind == ELLIPSE
    assert smooth.shape.angle == pytest.approx(90 + angle)
    # The shorter semi-axis is 26 pixels.
    assert result.max_pressure == pytest.approx(1e9, rel=1e-3)
    assert result.approach == pytest.approx(smooth.approach, rel=1e-3)
    assert hertz_comparison.equivalent_hertz_size(result) == pytest.approx(
        smooth.semi_axes, rel=2e-3
    )
    inside = np.argwhere(result.contact)
    reach = (inside.max(axis=0) - inside.min(axis=0) + 1) / 2 * 0.9e-6
    assert smooth.reach == pytest.approx(tuple(reach), abs=0.9e-6)


@pytest.mark.parametrize(("angle", "axis"), [(0, "x"), (90, "y")])
def test_a_roller_under_the_load_of_a_peak_has_that_peak(angle: float, axis: str) -> None:
    shape, pixel = ((128, 6), (1e-6, 2e-6)) if axis == "x" else ((6, 128), (2e-6, 1e-6))
    body = nominal_bodies.cylinder(radius=0.005, angle=angle, shape=shape, pixel=pixel)
    result, smooth = solve_under_peak(body, boundary=f"periodic-{axis}")
    assert smooth.shape.kind == LINE
    # 43 pixels to the half-width.
    assert result.max_pressure == pytest.approx(1e9, rel=5e-4)
    assert result.approach == pytest.approx(smooth.approach, rel=5e-4)
    assert hertz_comparison.equivalent_hertz_size(result) == pytest.approx(
        smooth.semi_axes, rel=5e-4
    )
    assert hertz_comparison.comparison_limits(result) == ()
    line = rc.solve(
        body,
        material=STEEL,
        boundary=f"periodic-{axis}",
        ceiling=None,
        load=rc.LineLoad(result.load / smooth.length),
    )
    assert line.load == pytest.approx(result.load)


def test_a_roller_in_profile_is_the_roller_on_a_strip() -> None:
    x = (np.arange(128) - 63.5) * 1e-6
    flat = rc.Surface(np.zeros(x.size), 1e-6)
    roller = nominal_bodies.cylinder(radius=0.005, angle=90, shape=(1, 128), pixel=(1.0, 1e-6))
    result, smooth = solve_under_peak(flat.with_form(roller))
    assert smooth.shape.kind == LINE
    assert result.max_pressure == pytest.approx(1e9, rel=5e-4)


def kinds(result: rc.ContactResult) -> str:
    return "; ".join(
        f"{limit.severity}: {limit.text}" for limit in hertz_comparison.comparison_limits(result)
    )


def test_contact_beyond_map_gives_warning() -> None:
    result, _ = solve_under_peak(ball(points=48))
    assert "warning: Hertz contact (±" in kinds(result)
    # The source of the load is wrong here: a warning of the result, not of the page alone.
    assert any(c.kind == CautionTag.HERTZ for c in result.cautions)
    plain = rc.solve(ball(points=48), material=STEEL, load=result.load, ceiling=None)
    assert not any(c.kind == CautionTag.HERTZ for c in plain.cautions)


def test_ends_images_size_and_ceiling_limit_comparison() -> None:
    roller = nominal_bodies.cylinder(radius=0.005, shape=(128, 6), pixel=(1e-6, 2e-6))
    free, smooth = solve_under_peak(roller)
    (ends,) = hertz_comparison.comparison_limits(free)
    assert ArgumentRef("boundary", "periodic-x") in ends.parts
    assert smooth.approach is None
    copies, _ = solve_under_peak(roller, boundary="periodic")
    (near,) = hertz_comparison.comparison_limits(copies)
    assert near.numbers["period"] < 4 * near.numbers["width"]
    assert copies.hertz is not None
    assert copies.hertz.approach is None
    small = nominal_bodies.sphere(radius=100e-6, shape=(64, 64), pixel=(1e-6, 1e-6))
    large, _ = solve_under_peak(small, load="hertz 20 GPa")
    assert "half-space theory is inaccurate" in kinds(large)
    yielding = rc.Material(210e9, 0.3, 0.3e9)
    limited, _ = solve_under_peak(ball(), material=yielding, ceiling="auto")
    (first,) = hertz_comparison.comparison_limits(limited)
    assert first.severity == "note"
    assert first.numbers["peak"] > first.numbers["first_yield"]


def test_flat_and_conical_bodies_have_no_smooth_contact() -> None:
    for body in (
        nominal_bodies.cone(slope=0.01, shape=(32, 32), pixel=(1e-6, 1e-6)),
        rc.Surface(*rc.reference_map(32)),
        nominal_bodies.cylinder(radius=0.01, angle=30, shape=(32, 32), pixel=(1e-6, 1e-6)),
    ):
        assert rc.solve(body, material=STEEL, load=0.01).hertz is None


@pytest.mark.parametrize("body", ["sphere", "cylinder"])
@pytest.mark.parametrize("points", [12, 16, 32, 64])
def test_the_interval_of_a_smooth_contact_contains_hertz(body: str, points: int) -> None:
    # A radius of contact of 34 µm, from a fifth of a pixel to two pixels.
    pixel = (2e-3 / points,) * 2
    shape = (points, points)
    boundary = "free"
    surface = nominal_bodies.sphere(radius=0.005, shape=shape, pixel=pixel)
    if body == "cylinder":
        surface = nominal_bodies.cylinder(radius=0.005, shape=shape, pixel=pixel, angle=0)
        boundary = "periodic-x"
    result, smooth = solve_under_peak(surface, boundary=boundary)
    answer = str(result)
    assert "Roughness" not in answer
    assert ("does not resolve" in answer) is hertz_comparison.is_unresolved(result)
    intervals = {item.name: item for item in uncertainty_intervals(result)}
    truth = {
        "contact_fraction": smooth.area / result.nominal_area,
        "max_pressure": smooth.max_pressure,
        "approach": smooth.approach,
    }
    for name, value in truth.items():
        item = intervals[name]
        assert item.low * (1 - 1e-9) <= value <= item.high * (1 + 1e-9), name


def test_a_measured_map_under_a_nominal_body_is_rough() -> None:
    heights = np.random.default_rng(0).normal(size=(64, 64)) * 1e-9
    measured = rc.Surface(heights, (2e-6, 2e-6)).with_form(ball(64, 2e-6))
    assert not is_smooth(solve_under_peak(measured)[0].pair)
    assert is_smooth(solve_under_peak(ball())[0].pair)


def test_a_hertz_contact_larger_than_the_map_is_named() -> None:
    steel = rc.Material(210e9, 0.3, 1e9)
    # The contact radius under 3 GPa is 102 µm, the half side of the map 16 µm.
    with pytest.raises(rc.CapacityError, match=r"Hertz contact \(±102 µm\) larger than the map"):
        rc.solve(ball(32, 1e-6), material=steel, load="hertz 3 GPa")


def test_answer_names_a_hertz_contact_larger_than_the_map() -> None:
    # The contact radius is 34 µm, the half side of the map 16 µm.
    result, _ = solve_under_peak(ball(32, 1e-6))
    assert hertz_comparison.is_beyond_map(result)
    assert "is larger than the map; solved" in " ".join(str(result).split())
    assert not hertz_comparison.is_beyond_map(solve_under_peak(ball())[0])


def test_edge_caution_recommends_no_boundary_that_is_set() -> None:
    # A strip narrower than the line contact, endless along the roller.
    roller = nominal_bodies.cylinder(radius=0.005, angle=0, shape=(16, 32), pixel=(1e-6, 1e-6))
    result, smooth = solve_under_peak(roller, boundary="periodic-x")
    assert smooth.shape.axis == 1
    found = next(item for item in result.cautions if item.kind == CautionTag.EDGE)
    assert "Measure a larger map." in str(found)
    assert "periodic" not in str(found)


@pytest.mark.parametrize(("radius", "form"), [(0.02, "cylinder"), (np.inf, None)])
def test_measured_map_with_a_form_gives_caution(radius: float, form: str | None) -> None:
    rng = np.random.default_rng(1)
    x = 2e-6 * (np.arange(64) - 31.5)
    heights = -(x**2) / (2 * radius) + 5e-9 * rng.normal(size=(64, 64))
    measured = rc.Surface(heights, (2e-6, 2e-6))
    counter = nominal_bodies.cylinder(radius=0.005, shape=(64, 64), pixel=(2e-6, 2e-6), angle=90.0)
    result = rc.solve(
        measured, counter_surface=counter, material=STEEL, load="10 N/mm", boundary="periodic-y"
    )
    caution = hertz_comparison.measured_form_caution(result)
    assert (caution is None) == (form is None)
    assert (caution in result.cautions) == (form is not None)
    if caution is not None:
        assert ArgumentRef("form", form) in caution.parts
        assert caution.numbers["radius"] == pytest.approx(radius, rel=0.01)
