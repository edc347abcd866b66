"""A roller that passes over a body that yields, against what must hold; see `test_shakedown`."""

from __future__ import annotations

import contextlib
import html
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import roughcontact as rc
from rollers import PIXEL, STRENGTH, Line
from roughcontact.analyses.roll.model import Pass, RollingResult, Shakedown
from roughcontact.cautions import Caution, CautionTag, Severity
from roughcontact.elastoplastic import plausibility
from roughcontact.errors import ArgumentRef, InputError
from roughcontact.halfspace import tensors
from roughcontact.halfspace.boundary import Boundary
from roughcontact.report import python_script
from roughcontact.report.presentation import presentation_of
from roughcontact.surface import nominal_bodies
from roughcontact.surface.placement import shift_surface


def strain_of(result: rc.ElastoplasticResult) -> NDArray[np.float64]:
    return tensors.tensor(result.bodies[0].plastic_strain.swapaxes(0, 1))


def test_reciprocating_pass_without_yield_is_elastic() -> None:
    line = Line(2.0)
    result = line.solve_path([line.point_at(x) for x in (0, 5, 9.5, 5, 0)], tolerance=1e-8)
    assert result.plastic_volume == 0
    assert not result.residual_displacement.any()
    alone = line.solve_path([line.point_at(0)], tolerance=1e-8)
    largest = alone.solution.pressure.max()
    # The tolerance of the contact follows that of the strain.
    np.testing.assert_allclose(
        result.solution.pressure, alone.solution.pressure, rtol=0, atol=1e-8 * largest
    )
    assert [step.offset[1] for step in result.increments] == [
        pytest.approx(x * PIXEL[1]) for x in (0, 5, 9.5, 5, 0)
    ]
    assert result.increments[2].approach == pytest.approx(alone.increments[0].approach, rel=1e-2)


@pytest.mark.long
def test_result_is_independent_of_start_position() -> None:
    line = Line(4.3, half_width=5, points=32)
    first = line.solve_path([line.point_at(x) for x in (0, 3, 6)])
    later = line.solve_path([line.point_at(x) for x in (10, 13, 16)])
    moved = np.roll(first.bodies[0].plastic_strain, 10, axis=-1)
    np.testing.assert_allclose(
        later.bodies[0].plastic_strain, moved, atol=1e-5 * first.max_plastic_strain
    )


@pytest.mark.long
def test_friction_shears_along_its_direction() -> None:
    line = Line(3.5, half_width=6, points=48)
    found = {}
    for direction in (0.0, 90.0, 180.0):
        result = line.solve_path([line.point_at(0, 0.3, direction)])
        found[direction] = (strain_of(result) * line.layers[:, None, None, None, None]).sum(0)
    along, across, back = found[0.0], found[90.0], found[180.0]
    # The body is dragged along: its surface moves with the traction, u' = 2 ε_xz < 0 with depth.
    assert along[..., 0, 2].sum() < 0
    assert abs(along[..., 1, 2]).max() < 1e-9
    assert across[..., 1, 2].sum() < 0
    np.testing.assert_allclose(back[..., 0, 2].sum(), -along[..., 0, 2].sum(), rtol=1e-3)


@pytest.mark.long
def test_equal_rolling_bodies_yield_equally() -> None:
    line = Line(4.3, half_width=5, points=32)
    # Twice as soft together, at the same pressure: the radius halves.
    roller = rc.Surface(2 * line.roller.heights, PIXEL, holes_masked=True)
    result = rc.solve_elastoplastic(
        line.flat,
        material=line.steel,
        counter_material=line.steel,
        counter_surface=roller,
        path=[line.point_at(x) for x in (0, 3, 6)],
        boundary="periodic",
        layers=line.layers,
        precision="double",
    )
    first, second = (body.accumulated for body in result.bodies)
    assert first.max() > 1e-3
    np.testing.assert_allclose(second, first, rtol=1e-9)


@pytest.mark.usefixtures("quick")
@pytest.mark.long
def test_path_appears_in_listing_report_and_script(tmp_path: Path) -> None:
    line = Line(4.3, half_width=5, points=32)
    result = line.solve_path([line.point_at(x, 0.1, 180.0) for x in (0, 3)], None, "single", 1e-3)
    text = str(presentation_of(result).listing(brief=True))
    assert "moved along x" in text
    assert "180 degree" in text
    result.report(tmp_path / "out.html")
    page = (tmp_path / "out.html").read_text("utf-8")
    assert "Rolling without slip zones" in page
    result.save(tmp_path / "result.nc")
    np.save(tmp_path / "surface.npy", line.flat.heights)
    names: dict[str, Any] = {}
    with contextlib.chdir(tmp_path):
        exec(python_script.repeating_volume(result), names)
    again = names["result"].bodies[0].plastic_strain
    np.testing.assert_allclose(
        again, result.bodies[0].plastic_strain, atol=2e-3 * result.max_plastic_strain
    )


@pytest.mark.parametrize(
    ("path", "words"),
    [([], "row of PathPoint"), ([1.0], "each a PathPoint"), ([rc.PathPoint(0.0)], "all zero")],
)
def test_bad_paths(path: list[rc.PathPoint], words: str) -> None:
    line = Line(3.0, points=32)
    with pytest.raises(InputError, match=words):
        line.solve_path(path)


def test_invalid_paths_raise_input_error() -> None:
    line = Line(3.0, points=32)
    options = dict(material=line.steel, boundary="periodic")
    with pytest.raises(InputError, match="moves a counter-surface, but the counter-body is flat"):
        rc.solve_elastoplastic(line.flat, path=[line.point_at(1)], **options)
    with pytest.raises(InputError, match="load must be finite and not negative"):
        rc.PathPoint(-1.0)
    with pytest.raises(InputError, match="offset must be two finite numbers"):
        rc.PathPoint(1.0, (1.0,))
    with pytest.raises(InputError, match="friction must be a number"):
        rc.PathPoint(1.0, friction="much")
    with pytest.raises(InputError, match="direction must be finite, got nan"):
        rc.PathPoint(1.0, direction=math.nan)
    with pytest.raises(InputError, match="offset"):
        rc.PathPoint(1.0, (None, 1e-6))


def roll_line(line: Line, passes: int, steps: int = 10, **more: Any) -> RollingResult:
    return rc.roll(
        line.flat,
        counter_surface=line.roller,
        material=line.steel,
        load=line.load,
        passes=passes,
        steps=steps,
        boundary="periodic",
        layers=line.layers,
        tolerance=1e-3,
        **more,
    )


@pytest.mark.slow
def test_passes_that_shake_down(tmp_path: Path) -> None:
    line = Line(3.7, half_width=5, points=40)
    first = roll_line(line, 2, folder=tmp_path / "kept")
    assert first.shakedown is Shakedown.NOT_SETTLED
    found = roll_line(line, 3, folder=tmp_path / "kept")
    assert found.passes[:2] == first.passes
    assert found.outcome_text == "shaken down after 2 passes"
    assert found.passes[0].strain_added == found.passes[0].max_plastic_strain > 1e-3
    assert found.passes[2].max_residual_stress > 0.05 * STRENGTH


def test_reciprocating_elastic_pass_has_expected_offsets() -> None:
    line = Line(1.5, half_width=5, points=40)
    found = roll_line(line, 2, steps=3, reciprocating=True, friction=0.1, travel="9 um")
    assert found.shakedown is Shakedown.ELASTIC
    lines = [(round(s.offset[1] * 1e6), s.direction) for s in found.result.increments]
    assert lines == [(0, 0), (3, 0), (6, 0), (6, 180), (3, 180), (0, 180)]


@pytest.mark.parametrize(
    ("flows", "gains", "answer"),
    [
        ([0, 0], [0, 0], "elastic"),
        ([5e-3, 1e-5, 1e-6], [5e-3, 1e-5, 1e-6], "shaken down after 1 pass"),
        ([5e-3, 1e-3, 1e-5], [5e-3, 1e-3, 1e-5], "shaken down after 2 passes"),
        ([5e-3, 4e-3, 3.9e-3], [5e-3, 1e-3, 1e-5], "plastic shakedown"),
        (
            [5e-3, 4e-3, 3.9e-3],
            [5e-3, 1e-3, 9.5e-4],
            "ratchets by a plastic strain of 0.00095 a pass",
        ),
        ([5e-3, 4e-3, 3.9e-3], [5e-3, 1e-3, 5e-4], "not settled after 3: use more passes"),
        ([5e-3, 4e-3], [5e-3, 1e-3], "not settled after 2: use more passes"),
        ([5e-3], [5e-3], "not settled after 1: use more passes"),
    ],
)
def test_answers(flows: list[float], gains: list[float], answer: str) -> None:
    line = Line(1.5, half_width=5, points=40)
    result = line.solve_path([line.point_at(0)])
    passes = tuple(
        Pass(flow, gain, 1e9, 0.0, 0.0, 0.0) for flow, gain in zip(flows, gains, strict=True)
    )
    assert RollingResult(result, passes).outcome_text == answer


def test_bad_passes() -> None:
    line = Line(1.5, half_width=5, points=40)
    with pytest.raises(InputError, match=r"travel is needed where the map is not periodic"):
        roll_line(line, 1, direction=45.0)
    with pytest.raises(InputError, match="travel must be positive"):
        roll_line(line, 1, travel=-1e-6)
    with pytest.raises(InputError, match="passes must be"):
        roll_line(line, 0)
    options = dict(counter_surface=line.roller, material=line.steel, boundary="periodic", steps=2)
    with pytest.raises(InputError, match=r"high = .* still shakes down in 1 passes"):
        rc.shakedown_load(line.flat, low=1e-3, high=2e-3, passes=1, **options)
    with pytest.raises(InputError, match="low must be positive and below high"):
        rc.shakedown_load(line.flat, low=1.0, high=0.5, **options)


@pytest.mark.slow
def test_limit_by_bisection() -> None:
    line = Line(1.0, half_width=7, points=64)
    # The pressure is proportional to the root of the load; the radius is that for 1 k.
    low, high = rc.shakedown_load(
        line.flat,
        low=9 * line.load,
        high=25 * line.load,
        rel_tol=0.06,
        passes=4,
        steps=16,
        counter_surface=line.roller,
        material=line.steel,
        boundary="periodic",
        tolerance=1e-3,
    )
    assert math.sqrt(low / line.load) < 4.0 * 1.06
    assert math.sqrt(high / line.load) > 4.0 * 0.94


def test_surfaces_that_move() -> None:
    heights = np.random.default_rng(5).random((6, 7))
    surface = rc.Surface(heights, PIXEL)
    around = shift_surface(surface, (2e-6, -3e-6), (0, 1))
    np.testing.assert_array_equal(around.heights, np.roll(heights, (2, -3), (0, 1)))
    out = shift_surface(surface, (2e-6, 0.0), (1,))
    assert np.isnan(out.heights[:2]).all()
    assert out.holes_masked
    np.testing.assert_array_equal(out.heights[2:], heights[:-2])
    ball = nominal_bodies.sphere(radius=1e-3, shape=(9, 9), pixel=PIXEL)
    exact = nominal_bodies.sphere(radius=1e-3, shape=(9, 9), pixel=PIXEL, center=(4.3, 3.6))
    np.testing.assert_allclose(
        shift_surface(ball, (0.3e-6, -0.4e-6)).heights, exact.heights, atol=1e-20
    )
    # It does not end where the map does.
    assert not shift_surface(ball, (3e-6, -2e-6)).missing
    x = np.arange(48) * 2 * math.pi / 48
    wave = rc.Surface(np.tile(np.sin(x), (4, 1)), PIXEL)
    half = shift_surface(wave, (0.0, 0.5e-6), (0, 1)).heights
    np.testing.assert_allclose(half, np.tile(np.sin(x - math.pi / 48), (4, 1)), atol=1e-5)
    with pytest.raises(InputError, match="missing points"):
        shift_surface(out, (0.5e-6, 0.0))


@pytest.mark.parametrize(
    ("way", "unknown"),
    [
        ((0.3, 0.0), np.s_[:1]),
        ((-0.3, 0.0), np.s_[-1:]),
        ((0.0, 0.4), np.s_[:, :1]),
        ((0.0, -2.4), np.s_[:, -3:]),
    ],
)
def test_shifted_measured_map_has_missing_points_at_edge(way, unknown):
    heights = np.random.default_rng(2).normal(size=(12, 16))
    moved = shift_surface(rc.Surface(heights, PIXEL), (way[0] * PIXEL[0], way[1] * PIXEL[1]))
    expected = np.zeros(heights.shape, bool)
    expected[unknown] = True
    np.testing.assert_array_equal(np.isnan(moved.heights), expected)
    assert moved.holes_masked


def test_a_map_that_moves_by_part_of_a_pixel_is_a_cubic_spline():
    from scipy.interpolate import make_interp_spline

    heights = np.random.default_rng(2).normal(size=(6, 16))
    moved = shift_surface(rc.Surface(heights, (1e-6, 1e-6)), (0.0, 0.3e-6), (0, 1)).heights
    x = np.arange(17)
    for row, found in zip(heights, moved, strict=True):
        spline = make_interp_spline(x, np.append(row, row[0]), k=3, bc_type="periodic")
        np.testing.assert_allclose(found, spline((x[:16] - 0.3) % 16), atol=1e-9)


# Cautions of passes


def cautions_of(found: RollingResult) -> dict[str, Caution]:
    return {caution.kind: caution for caution in found.cautions}


@pytest.mark.slow
@pytest.mark.long
def test_separate_dents_are_not_resolved(tmp_path: Path) -> None:
    line = Line(4.5, half_width=4, points=32)
    found = roll_line(line, 3, steps=3)
    # Each indentation carries the roller, which ratchets where they overlap.
    assert found.passes[-1].strain_added < found.strain_threshold
    assert found.shakedown is Shakedown.NOT_RESOLVED
    assert found.outcome_text.startswith("not evaluated: the steps are longer than the contact")
    assert found.settled_after is None
    caution = cautions_of(found)[CautionTag.STEP_LENGTH]
    assert caution.severity is Severity.WARNING
    # 8 to 10 of the 32 pixels touch.
    assert caution.numbers["half_width"] == pytest.approx(4.5 * PIXEL[1], rel=0.12)
    assert caution.numbers["step_over_half_width"] == pytest.approx(2.4, rel=0.12)
    found.save(tmp_path / "out.nc")
    again = rc.read_result(tmp_path / "out.nc")
    assert again.cautions == found.cautions
    assert again.outcome_text == found.outcome_text
    assert caution.text in found.summary()["warnings"]
    found.report(tmp_path / "out.html")
    page = " ".join(html.unescape((tmp_path / "out.html").read_text("utf-8")).split())
    assert "contact half-widths: strain is meaningless" in page
    assert "steps, pixel and direction of the passes" in page


@pytest.mark.long
@pytest.mark.parametrize(("steps", "expected"), [(16, None), (10, Severity.CAUTION)])
def test_steps_above_half_the_half_width_give_caution(steps, expected) -> None:
    found = cautions_of(roll_line(Line(3.7, half_width=4, points=32), 1, steps=steps))
    assert (
        found[CautionTag.STEP_LENGTH].severity if expected else found.get(CautionTag.STEP_LENGTH)
    ) is expected
    assert CautionTag.ROLLING_PIXEL not in found


@pytest.mark.long
@pytest.mark.parametrize("points", [16, 48])
def test_roller_near_its_periodic_copies_gives_caution(points: int) -> None:
    found = cautions_of(roll_line(Line(3.7, half_width=4, points=points), 1, steps=16))
    if points == 48:
        assert CautionTag.HERTZ not in found
    else:
        numbers = found[CautionTag.HERTZ].numbers
        assert numbers["period"] / numbers["width"] == pytest.approx(16 / 8, rel=0.15)


@pytest.mark.long
def test_roller_on_few_pixels_gives_caution() -> None:
    found = cautions_of(roll_line(Line(3.7, half_width=2, points=16), 1, steps=16))
    assert found[CautionTag.ROLLING_PIXEL].numbers["pixels"] < 3
    # There is no place between those of pixels.
    assert CautionTag.STEP_LENGTH not in found


@pytest.mark.long
def test_limit_with_separate_dents_raises_input_error() -> None:
    line = Line(4.5, half_width=4, points=32)
    with pytest.raises(InputError, match="steps must be larger: at"):
        rc.shakedown_load(
            line.flat,
            low=line.load,
            high=2 * line.load,
            passes=1,
            steps=3,
            layers=line.layers,
            counter_surface=line.roller,
            material=line.steel,
            boundary="periodic",
            tolerance=1e-3,
        )


@pytest.mark.parametrize(
    ("axis", "direction", "slides"),
    [
        (0.0, 0.0, True),
        (176.0, 0.0, True),
        (6.0, 0.0, False),
        (90.0, 0.0, False),
        (90.0, -90.0, True),
        (30.0, 212.0, True),
        (None, 0.0, False),
    ],
)
def test_sliding_along_roller_axis_gives_caution(axis, direction, slides) -> None:
    line = Line(1.5, half_width=5, points=40)
    result = line.solve_path([line.point_at(0)])
    found = RollingResult(result, (Pass(0.0, 0.0, 1e9, 0, 0, 0),), direction, axis=axis)
    assert (CautionTag.CYLINDER_SLIDES in cautions_of(found)) == slides


def test_axis_is_known_for_nominal_cylinders_only() -> None:
    line = Line(3.0, half_width=5, points=40)
    lying = nominal_bodies.cylinder(radius=1e-3, shape=(8, 40), pixel=PIXEL)
    found = rc.roll(
        line.flat,
        counter_surface=lying,
        material=line.steel,
        load=1e-3,
        passes=1,
        steps=2,
        boundary="periodic",
        layers=line.layers,
    )
    (caution,) = found.cautions
    assert caution.kind == CautionTag.CYLINDER_SLIDES
    assert ArgumentRef("direction", 90.0) in caution.parts
    measured = rc.Surface(lying.heights, PIXEL)
    for other in (line.flat, measured, lying.rotated(90), shift_surface(lying, (0, 1e-6))):
        assert plausibility.cylinder_axis(other.provenance) is None


@pytest.mark.parametrize(
    ("boundary", "direction", "pixels"),
    [
        ("periodic", 0.0, 3.5),
        ("free", 0.0, 16),
        ("periodic-x", 90.0, 2),
        ("periodic-y", 180.0, 16),
        ("periodic", 45.0, 5.5 / math.sqrt(2)),
    ],
)
def test_the_half_width_is_that_of_the_patch_round_the_period(boundary, direction, pixels) -> None:
    line = Line(1.5, half_width=5, points=32)
    result = line.solve_path([line.point_at(0)])
    pressure = np.zeros((8, 32))
    # Spots with gaps between them, across the edge of the period.
    pressure[3, [30, 31, 0]] = pressure[6, [2, 4]] = 1e8
    pair = replace(result.solution.pair, boundary=Boundary(boundary))
    patch = replace(result, solution=replace(result.solution, pressure=pressure, pair=pair))
    found = plausibility.half_width(patch, direction) / PIXEL[1]
    assert found == pytest.approx(pixels)
    # One pixel alone: a step to the next is fine, though it is two half-widths.
    single = np.zeros((8, 32))
    single[3, 5] = 1e8
    alone = replace(result, solution=replace(result.solution, pressure=single))
    assert plausibility.half_width(alone, 0.0) == pytest.approx(0.5 * PIXEL[1])
    assert not plausibility.too_long(alone, PIXEL[1], 0.0)
    assert plausibility.too_long(alone, 2 * PIXEL[1], 0.0)
    whole = replace(result, solution=replace(result.solution, pressure=np.ones((8, 32))))
    assert plausibility.half_width(whole, direction) == math.inf
