import csv
import dataclasses
import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import roughcontact as rc
from roughcontact.analyses.history import report as history_report
from roughcontact.analyses.history.model import (
    TOLERANCE,
    HistoryStep,
    LoadHistory,
    Stage,
    history,
    repeat_stages,
)
from roughcontact.contact import solve
from roughcontact.halfspace.boundary import Boundary

STEEL = rc.Material(210e9, 0.3, 1e9, "steel")
HARD = rc.Material(210e9, 0.3, 3e9, "hard steel")


def rough(n: int = 48, seed: int = 3) -> rc.Surface:
    return rc.Surface(*rc.reference_map(n, seed))


def ball(n: int = 64, radius: float = 2e-4, side: float = 64e-6) -> rc.Surface:
    x = (np.arange(n) - n // 2) * side / n
    return rc.Surface(-(x**2 + x[:, None] ** 2) / (2 * radius), (side / n, side / n))


def no_solve(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("solved something")

    monkeypatch.setattr(solve, "solve", refuse)


def test_repeated_load_saturates_same_points() -> None:
    # They are there to within rounding only: three quarters of them were counted on a real map.
    first, _, again = history(rough(), [1.0, 0.1, 1.0], material=STEEL).steps
    assert first.saturated_area > 0
    assert again.indentation_volume < 1e-6 * first.indentation_volume
    assert again.saturated_area == first.saturated_area


# --- one position ----------------------------------------------------------------------------


@pytest.mark.parametrize("boundary", Boundary)
@pytest.mark.parametrize("control", ["load", "approach"])
def test_first_loading_is_solve(control: str, boundary: str) -> None:
    options = {"material": STEEL, "boundary": boundary, "tolerance": 1e-9}
    value = {"load": 1.0} if control == "load" else {"approach": 2e-7}
    found = history(rough(), [Stage(**value)], **options)
    alone = rc.solve(rough(), **value, **options)
    assert alone.saturated.any()
    step = found.steps[0]
    assert found.last.pressure.tobytes() == alone.pressure.tobytes()
    assert found.last.gap.tobytes() == alone.gap.tobytes()
    assert (step.load, step.approach) == (alone.load, alone.approach)
    assert (step.contact_area, step.max_pressure) == (alone.contact_area, alone.max_pressure)
    assert step.certificate == alone.certificate
    assert found.indentation.tobytes() == alone.residual_indentation.tobytes()


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_reloading_finds_the_same_pressure_and_no_new_saturation(boundary: str) -> None:
    options = {"material": STEEL, "boundary": boundary}
    first = history(rough(), [1.0], **options)
    again = history(rough(), [1.0, 0.4, 0.0, 0.7, 1.0], **options)
    # An error of ε ‖p‖ in the projected pressure is at most a few times that in the pressure.
    off = np.linalg.norm(again.last.pressure - first.last.pressure)
    assert off <= 10 * TOLERANCE * np.linalg.norm(first.last.pressure)
    assert again.steps[-1].approach == pytest.approx(first.steps[0].approach, rel=1e-8)
    volume = again.column("indentation_volume")
    assert volume[0] > 0
    assert (volume[1:] <= 1e-8 * volume[0]).all()
    assert again.indentation == pytest.approx(
        first.indentation, rel=0, abs=1e-8 * first.indentation.max()
    )
    # Nothing is pressed at zero load, and the bodies touch again deeper than at first.
    assert again.steps[2].contact_area == again.steps[2].max_pressure == 0
    assert 0 < again.steps[2].approach < again.steps[0].approach
    # Unloading is stiffer than loading: at 0.4 N the indented body still lies deeper.
    alone = rc.solve(rough(), load=0.4, **options)
    assert again.steps[1].approach > alone.approach
    assert again.steps[1].contact_area > alone.contact_area
    assert again.is_elastic_now


def test_touch_after_unloading_is_where_the_deformed_bodies_touch() -> None:
    surface = rough()
    found = history(surface, [1.0, 0.0], material=STEEL)
    touch = surface.heights.max() - found.residual.heights.max()
    assert found.steps[1].approach == pytest.approx(touch, rel=1e-12)
    gap = found.last.gap
    assert gap.min() == 0
    assert found.last.status == "converged"
    assert found.last.stiffness() == 0
    # Just above it there is load, just below there is none.
    near = [Stage(load=1.0), Stage(approach=touch * 0.99), Stage(approach=touch * 1.01)]
    loads = history(surface, near, material=STEEL).column("load")
    assert loads[1] == 0
    assert loads[2] > 0
    below = history(surface, [*near[:2]], material=STEEL)
    assert below.steps[1].approach == pytest.approx(touch * 0.99, rel=1e-12)
    assert below.last.gap.min() == pytest.approx(0.01 * touch, rel=1e-9)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_elastic_paths_close(boundary: str) -> None:
    loads = [0.2, 0.6, 1.0, 0.6, 0.0, 0.2, 1.0, 1e-3, 0.6]
    found = history(rough(), loads, material=STEEL, ceiling=None, boundary=boundary)
    approach = found.column("approach")
    for load in set(loads):
        same = approach[np.array(loads) == load]
        assert np.ptp(same) <= 1e-8 * same.max()
    assert found.dissipated_energy == found.indentation_volume == 0
    assert found.is_elastic_now


@pytest.mark.parametrize("ceiling", [None, 1e15])
@pytest.mark.parametrize("on_counter", [False, True])
def test_a_ceiling_far_above_leaves_every_bit(ceiling: float | None, on_counter: bool) -> None:
    heights = rough().heights.copy()
    heights[0, 0] = -0.0
    bodies = rc.Surface(heights, rough().pixel), rough(seed=5)
    materials = (HARD, STEEL) if on_counter else (STEEL, HARD)
    found = history(
        bodies[0],
        [1.0, 0.0, Stage(load=2.0, shift=(0.0, 2 * rough().pixel[1]))],
        counter_surface=bodies[1],
        material=materials[0],
        counter_material=materials[1],
        ceiling=ceiling,
    )
    assert found.residual.heights.tobytes() == bodies[on_counter].heights.tobytes()
    assert found.residual.provenance == bodies[on_counter].provenance


def test_conditions_hold_on_the_indented_surface(independent) -> None:
    # The law itself, judged from the maps alone: pressure, indentation before and after.
    surface, counter = rough(), rough(seed=5)
    dy, dx = surface.pixel
    stages = [1.0, 0.2, Stage(load=1.7, shift=(2 * dy, -dx))]
    options = {"counter_surface": counter, "material": STEEL, "boundary": "periodic"}
    before = history(surface, stages[:2], **options)
    after = history(surface, stages, **options)
    pressure = after.last.pressure
    displacement, unit = independent.periodic_displacement(
        pressure, surface.pixel, after.last.contact_modulus
    )
    touch = (surface.heights + counter.heights).max()
    heights = surface.heights - after.indentation + np.roll(counter.heights, (2, -1), (0, 1))
    gap = displacement + touch - heights - after.steps[-1].approach
    new = after.indentation - before.indentation
    scale = 1e-7 * unit * 3e9
    assert new.min() >= 0
    assert gap.min() >= -scale
    assert np.abs(gap[pressure > 0]).max() <= scale
    assert (pressure[new > 0] == 3e9).all()
    # A pixel indented before may be below the ceiling now, and keeps what it lost.
    kept = (before.indentation > 0) & (pressure < 3e9)
    assert kept.any()
    assert (after.indentation[kept] == before.indentation[kept]).all()


def test_a_ceiling_per_pixel_indents_only_where_it_is_reached() -> None:
    ceiling = np.full((48, 48), math.inf)
    ceiling[:, :24] = 2e9
    found = history(rough(), [1.0, 0.0, 1.0], material=STEEL, ceiling=ceiling)
    assert found.indentation[:, :24].any()
    assert not found.indentation[:, 24:].any()
    assert found.summary()["ceiling"] == "per pixel"


# --- energy and volume -----------------------------------------------------------------------


@settings(max_examples=20, deadline=None)
@given(
    n=st.sampled_from([16, 24, 32]),
    seed=st.integers(0, 20),
    fraction=st.floats(0.2, 2.0),
    boundary=st.sampled_from(Boundary),
    path=st.lists(
        st.tuples(st.just(0.0) | st.floats(1e-9, 0.8), st.integers(-4, 4), st.integers(-4, 4)),
        min_size=1,
        max_size=4,
    ),
)
def test_no_path_gives_energy_or_volume_back(
    n: int, seed: int, fraction: float, boundary: str, path: list[tuple[float, int, int]]
) -> None:
    part = (0, n), (0, n)
    surface, counter = rough(32, seed).cropped(*part), rough(32, seed + 1).cropped(*part)
    dy, dx = surface.pixel
    stages = [Stage(load=load, shift=(y * dy, x * dx)) for load, y, x in path]
    found = history(
        surface,
        stages,
        counter_surface=counter,
        material=STEEL,
        ceiling=fraction * 3e9,
        boundary=boundary,
    )
    assert (found.column("dissipated_energy") >= 0).all()
    assert (found.column("indentation_volume") >= 0).all()
    assert (found.column("elastic_energy") >= 0).all()
    assert (found.indentation >= 0).all()
    # All that is dissipated is the ceiling times the volume lost, and nothing is raised.
    volume = found.column("indentation_volume").sum()
    assert found.indentation_volume == pytest.approx(volume, rel=1e-12, abs=1e-40)
    assert found.dissipated_energy == pytest.approx(fraction * 3e9 * volume, rel=1e-12)
    lost = surface.heights - found.residual.heights
    assert float(lost.sum()) * dy * dx == pytest.approx(volume, rel=1e-6, abs=1e-9 * lost.size)
    untouched = found.indentation == 0
    assert (found.residual.heights[untouched] == surface.heights[untouched]).all()


# --- several positions -----------------------------------------------------------------------


def test_distant_indentations_are_identical() -> None:
    # A hard ball on a soft flat without end: the second indentation does not depend on the first.
    surface = ball()
    pixel = surface.pixel[1]
    one = history(surface, [1.0], material=rc.RIGID, counter_material=STEEL)
    two = history(
        surface,
        [1.0, 0.0, Stage(load=1.0, shift=(0.0, 40 * pixel)), 0.0],
        material=rc.RIGID,
        counter_material=STEEL,
    )
    assert one.indented_body == two.indented_body == "counter_surface"
    assert two.origin == (0, 40)
    assert two.indentation.shape == (64, 104)
    expected = np.zeros((64, 104))
    expected[:, 40:] += one.indentation
    # The ball moved over the flat to smaller x, as the flat moved to larger.
    expected[:, :64] += one.indentation
    np.testing.assert_allclose(two.indentation, expected, atol=1e-8 * expected.max())
    assert two.residual.heights.min() == -two.indentation.max()
    assert two.residual.provenance.source == "flat"
    assert two.indentation_volume == pytest.approx(2 * one.indentation_volume, rel=1e-8)
    assert not two.is_elastic_now


def test_an_overlapping_pass_hits_the_indented_surface() -> None:
    surface = ball()
    pixel = surface.pixel[1]
    options = {"material": rc.RIGID, "counter_material": STEEL}
    one = history(surface, [1.0], **options)
    width = math.sqrt(np.count_nonzero(one.indentation) / math.pi)
    half = round(width / 2) * pixel
    two = history(surface, [1.0, 0.0, Stage(load=1.0, shift=(0.0, half))], **options)
    first, _, second = two.column("indentation_volume")
    # It finds part of its imprint made, is carried by more area, and makes the rest.
    assert 0.2 * first < second < 0.95 * first
    # The first indentation is kept.
    made = two.indentation[:, two.origin[1] :]
    assert (made >= one.indentation * (1 - 1e-8)).all()
    # Back at the first position, and forth again: a rolled track shakes down.
    stages = [Stage(load=1.0, shift=(0.0, half * (n % 2))) for n in range(12)]
    track = history(surface, stages, **options)
    volume = track.column("indentation_volume")
    assert volume[2] > 0
    assert volume[-1] < 0.05 * volume[2]


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_swapped_bodies_are_the_same_contact(boundary: str) -> None:
    # The indentation on either body: shifting one to the right is shifting the other to the left.
    first, second = rough(32, 1), rough(32, 2)
    dy, dx = first.pixel
    shifts = [(0, 0), (3, -5), (-2, 4), (3, -5)]
    here = [Stage(load=0.8, shift=(y * dy, x * dx)) for y, x in shifts]
    there = [Stage(load=0.8, shift=(-y * dy, -x * dx)) for y, x in shifts]
    options = {"boundary": boundary}
    one = history(
        first, here, counter_surface=second, material=STEEL, counter_material=HARD, **options
    )
    two = history(
        second, there, counter_surface=first, material=HARD, counter_material=STEEL, **options
    )
    assert (one.indented_body, two.indented_body) == ("surface", "counter_surface")
    for name in ("approach", "indentation_volume", "dissipated_energy", "elastic_energy"):
        np.testing.assert_allclose(one.column(name), two.column(name), rtol=1e-6, atol=1e-30)
    deepest = one.indentation.max()
    np.testing.assert_allclose(one.indentation, two.indentation, atol=1e-6 * deepest)
    assert one.column("indentation_volume")[1] > 0


def test_points_shifted_off_map_have_no_contact_and_return() -> None:
    surface, counter = rough(32, 1), rough(32, 2)
    dy, _ = surface.pixel
    away = Stage(load=0.5, shift=(20 * dy, 0.0))
    options = {"counter_surface": counter, "material": HARD, "counter_material": STEEL}
    first = history(surface, [0.5], **options)
    moved = history(surface, [0.5, away], **options)
    found = history(surface, [0.5, away, 0.5], **options)
    assert np.isnan(moved.last.gap[:20]).all()
    assert np.isfinite(moved.last.gap[20:]).all()
    assert not moved.last.pressure[:20].any()
    # The rows that were off the map are as they were left, the others were indented again.
    np.testing.assert_array_equal(moved.indentation[12:], first.indentation[12:])
    assert (moved.indentation[:12] > first.indentation[:12]).any()
    # Back at the first position the first imprint is there again: little is new.
    assert found.steps[2].indentation_volume <= 0.05 * found.steps[0].indentation_volume


@pytest.mark.parametrize("boundary", ["periodic-x", "periodic-y"])
def test_a_strip_rolls_along_its_period_and_ends_across(boundary: str) -> None:
    surface, counter = rough(), rough(seed=5)
    along = 1 if boundary == "periodic-x" else 0
    options = {"counter_surface": counter, "material": STEEL, "boundary": boundary}

    def shifted(axis: int, pixels: int) -> LoadHistory:
        shift = [0.0, 0.0]
        shift[axis] = pixels * surface.pixel[axis]
        return history(surface, [Stage(load=1.0, shift=(shift[0], shift[1]))], **options)

    # Five pixels along: the counter-body is rolled; across: five rows face nothing.
    moved, back = shifted(along, 5), shifted(along, 5 - 48)
    np.testing.assert_array_equal(moved.last.pressure, back.last.pressure)
    rolled = rc.Surface(np.roll(counter.heights, 5, along), counter.pixel)
    alone = history(surface, [1.0], **{**options, "counter_surface": rolled})
    np.testing.assert_array_equal(moved.last.pressure, alone.last.pressure)
    lost = np.isnan(shifted(1 - along, 5).last.gap).all(axis=along)
    assert lost.tolist() == 5 * [True] + 43 * [False]


@pytest.mark.parametrize("boundary", ["periodic-x", "periodic-y"])
def test_strip_indents_flat_extended_across_period(boundary: str) -> None:
    # The flat is one period long, and as wide as what will face the map.
    surface = ball()
    across = 0 if boundary == "periodic-x" else 1
    shift = [9 * edge for edge in surface.pixel]
    found = history(
        surface,
        [1.0, Stage(load=1.0, shift=(shift[0], shift[1]))],
        material=rc.RIGID,
        counter_material=STEEL,
        boundary=boundary,
    )
    expected = [64, 64]
    expected[across] += 9
    assert found.indentation.shape == tuple(expected)
    first, second = (step.indentation_volume for step in found.steps)
    # It sinks in deeper where the first imprint no longer carries.
    assert 0 < first < second < 1.5 * first


def test_shifts_are_measured_from_one_first_touch() -> None:
    # Two flats with one peak each: they touch deeper once the peaks miss each other.
    heights = np.zeros((8, 8))
    heights[4, 4] = 1e-7
    surface = rc.Surface(heights, (1e-6, 2e-6))
    stages = [1e-6, Stage(load=0.0, shift=(0.0, 4e-6)), Stage(approach=0.5e-7, shift=(1e-6, 0.0))]
    found = history(
        surface, stages, counter_surface=surface, material=STEEL, ceiling=None, boundary="periodic"
    )
    assert found.steps[1].approach == pytest.approx(1e-7, rel=1e-12)
    assert found.steps[2].load == 0
    assert found.last.gap.min() == pytest.approx(0.5e-7, rel=1e-12)


def test_passes() -> None:
    stages = repeat_stages([1.0, 2.0, 0.0], 3, (1e-6, -2e-6))
    assert [stage.load for stage in stages] == [1.0, 2.0, 0.0] * 3
    assert [stage.shift for stage in stages[::3]] == [(0, 0), (1e-6, -2e-6), (2e-6, -4e-6)]
    for count in (0, 1.5):
        with pytest.raises(rc.InputError, match="count"):
            repeat_stages([1.0], count)


def test_repeated_passes_shake_down() -> None:
    surface = rough(32)
    first = history(surface, repeat_stages([0.5, 1.0, 0.0], 1), material=STEEL)
    assert not first.is_elastic_now
    second = history(surface, repeat_stages([0.5, 1.0, 0.0], 2), material=STEEL)
    assert second.is_elastic_now
    # A lower load afterwards shows nothing about the higher one.
    lower = history(surface, [1.0, 0.0, 0.9], material=STEEL)
    assert not lower.is_elastic_now
    higher = history(surface, [1.0, 0.0, 1.0, 1.1], material=STEEL)
    assert not higher.is_elastic_now
    by_depth = [Stage(approach=value) for value in (2e-7, 0.0, 2e-7)]
    assert history(surface, by_depth, material=STEEL).is_elastic_now
    assert not history(surface, by_depth[:1], material=STEEL).is_elastic_now


# --- the table -------------------------------------------------------------------------------


def test_passes_end_without_new_indentation() -> None:
    ended = history(rough(), [0.5, 1.0, 0.0], passes=1000, material=STEEL)
    assert (ended.passes, ended.requested_passes) == (2, 1000)
    assert ended.is_elastic_now
    # Those that were followed are the same, to the bit.
    followed = history(rough(), repeat_stages([0.5, 1.0, 0.0], 2), material=STEEL)
    assert [same(step) for step in ended.steps] == [same(step) for step in followed.steps]
    assert ended.indentation.tobytes() == followed.indentation.tobytes()
    assert ended.path == followed.path
    # Elsewhere the surface has not been pressed yet.
    pixel = rough().pixel[1]
    moved = history(rough(), [1.0], passes=4, shift=(0.0, pixel), material=STEEL)
    assert (moved.passes, len(moved.steps), moved.path[3].shift) == (4, 4, (0.0, 3 * pixel))
    elastic = history(rough(), [1.0, 0.0], passes=3, material=STEEL, ceiling=None)
    assert elastic.passes == 1


def same(step: HistoryStep) -> HistoryStep:
    return dataclasses.replace(step, seconds=0.0)


@pytest.mark.parametrize("counter", [None, rough(48, 5)])
def test_interrupted_history_resumes_with_same_numbers(
    counter: rc.Surface | None, tmp_path: Path
) -> None:
    pixel = rough().pixel[0]
    options: dict[str, object] = {
        "material": HARD,
        "counter_material": STEEL,
        "counter_surface": counter,
        "passes": 3,
        "shift": (0.0, pixel),
    }
    whole = history(rough(), [0.5, 1.0], **options)
    assert whole.indented_body == "counter_surface"

    def stop(at: rc.results.Progress) -> None:
        if at.number == 4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        history(rough(), [0.5, 1.0], **options, folder=tmp_path, progress=stop)
    assert len(list(tmp_path.glob("step-*.npz"))) == 3
    kept: list[int] = []
    for _ in range(2):
        # The second time all of it is there.
        again = history(
            rough(),
            [0.5, 1.0],
            **options,
            folder=tmp_path,
            progress=lambda at: kept.append(at.number) if at.kept else None,
        )
        assert [same(step) for step in again.steps] == [same(step) for step in whole.steps]
        assert again.indentation.tobytes() == whole.indentation.tobytes()
        for one, other in ((again.last, whole.last), (again.largest, whole.largest)):
            assert one.pressure.tobytes() == other.pressure.tobytes()
            assert one.gap.tobytes() == other.gap.tobytes()
    assert kept == [1, 2, 3, 1, 2, 3, 4, 5, 6]
    with pytest.raises(rc.InputError, match="holds another history: path differs"):
        history(rough(), [0.5, 0.9], **options, folder=tmp_path)


def test_more_passes_resume_in_same_folder(tmp_path: Path) -> None:
    once = history(rough(), [1.0, 0.0], material=STEEL, folder=tmp_path)
    more = history(rough(), [1.0, 0.0], passes=9, material=STEEL, folder=tmp_path)
    assert more.steps[:2] == once.steps
    assert more.passes == 2


@pytest.fixture(scope="module")
def two_passes() -> LoadHistory:
    return history(
        rough(32),
        repeat_stages([0.5, 1.0, 0.0], 2, (2 * 100e-6 / 32, 0.0)),
        counter_surface=rough(32, 9),
        material=STEEL,
    )


def test_saved_csv_keeps_every_number(two_passes: LoadHistory, tmp_path: Path) -> None:
    two_passes.save(tmp_path / "history.csv")
    with (tmp_path / "history.csv").open(newline="", encoding="utf-8") as stream:
        head, *rows = csv.reader(stream)
    columns = [column for column in history_report.HISTORY_COLUMNS if column.stored]
    assert head == [f"{column.key} [{column.unit}]" for column in columns]
    names = [field.name for field in dataclasses.fields(HistoryStep)]
    assert [column.key for column in columns] == names
    for number, name in enumerate(names):
        assert [float(row[number]) for row in rows] == two_passes.column(name).tolist()


def test_saved_json_holds_dissipated_energy(two_passes: LoadHistory, tmp_path: Path) -> None:
    two_passes.save(tmp_path / "history.json")
    read = json.loads((tmp_path / "history.json").read_text(encoding="utf-8"))
    assert read == two_passes.summary()
    assert read["steps"]["shift_y"] == [0, 0, 0, *[2 * 100e-6 / 32] * 3]
    assert read["dissipated_energy"] == pytest.approx(3e9 * read["indentation_volume"], rel=1e-12)
    assert "no pile-up" in read["volume_account"]
    with pytest.raises(rc.InputError, match=r"\.xlsx or \.json"):
        two_passes.save(tmp_path / "history.txt")
    assert [path.name for path in tmp_path.iterdir()] == ["history.json"]


def test_residual_surface_is_a_surface_like_any_other(two_passes: LoadHistory) -> None:
    assert two_passes.residual.shape == (32, 32)
    assert two_passes.residual.provenance.steps[-1].startswith("indented: by up to")
    again = rc.solve(two_passes.residual, material=STEEL, load=0.5)
    assert again.converged
    approach, load = two_passes.hysteresis
    assert load.tolist() == [0.5, 1.0, 0.0] * 2
    assert approach.shape == (6,)
    with pytest.raises(rc.InputError, match="name must be one of"):
        two_passes.column("colour")


# --- bad input -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("path", "error", "message"),
    [
        ([1.0, 0.0, 40.0, 1.0], rc.CapacityError, "stage 3 of 4: load = 40 N is more than"),
        ([1.0, Stage(load=1.0, shift=(1e-4, 0.0))], rc.InputError, "stage 2.*beyond the map"),
        (
            [1.0, Stage(load=1.0, shift=(3.3e-6, 0.0))],
            rc.InputError,
            r"stage 2.*no whole number.*nearest is '4166.66667 nm, 0 nm'",
        ),
        ([1.0, -1.0], rc.InputError, "stage 2: load must be finite and not negative"),
        ([1.0, math.nan], rc.InputError, "stage 2: load must be finite"),
        ([1.0, None], rc.InputError, "path must be a list, each a Stage .* got None as number 2"),
        ([1.0, "heavy"], rc.InputError, "stage 2: load needs a load such as"),
        ([], rc.InputError, "path is empty"),
    ],
)
def test_invalid_path_raises_error_before_solve(
    path: list[Stage | float], error: type[Exception], message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    no_solve(monkeypatch)
    # No pixel of this map is a round number of metres.
    surface = rc.Surface(rough().heights, (1e-4 / 24, 1e-4 / 48))
    if path and path[-1] == Stage(load=1.0, shift=(1e-4, 0.0)):
        surface = rc.Surface(surface.heights, (1e-4 / 48, 1e-4 / 48))
    with pytest.raises(error, match=message):
        history(surface, path, material=STEEL, ceiling=3e9 / 2)


@pytest.mark.parametrize(
    "arguments",
    [
        {},
        {"load": 1.0, "approach": 1e-7},
        {"load": -1.0},
        {"load": math.inf},
        {"load": "1"},
        {"approach": math.nan},
        {"load": 1.0, "shift": (1e-6,)},
        {"load": 1.0, "shift": 1e-6},
        {"load": 1.0, "shift": (math.inf, 0)},
    ],
)
def test_invalid_stage_raises_error(arguments: dict[str, object]) -> None:
    with pytest.raises(rc.InputError):
        Stage(**arguments)


def test_capacity_counts_overlap_of_bodies(monkeypatch: pytest.MonkeyPatch) -> None:
    no_solve(monkeypatch)
    surface = rough(32)
    far = Stage(load=20.0, shift=(20 * surface.pixel[0], 0.0))
    with pytest.raises(rc.CapacityError, match="stage 2 of 3"):
        history(surface, [20.0, far, 20.0], counter_surface=surface, material=STEEL)
    holed = surface.heights.copy()
    holed[16:] = np.nan
    upper = rc.Surface(holed, surface.pixel).masked()
    with pytest.raises(rc.CapacityError, match="no valid point"):
        history(
            upper,
            [1.0, Stage(load=0.0, shift=(16 * surface.pixel[0], 0.0))],
            counter_surface=surface,
            material=STEEL,
        )


def test_invalid_arguments_raise_same_errors_as_solve(monkeypatch: pytest.MonkeyPatch) -> None:
    no_solve(monkeypatch)
    surface = rough(32)
    for arguments, message in (
        ({"boundary": "mirror"}, "boundary"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"counter_surface": rough(48)}, "same grid"),
        ({"ceiling": -1.0}, "ceiling"),
        ({"material": "stone"}, "material"),
    ):
        with pytest.raises(rc.InputError, match=message):
            history(surface, [0.0], **{"material": STEEL, **arguments})
    moving = [Stage(load=1.0, shift=(surface.pixel[0], 0.0))]
    with pytest.raises(rc.InputError, match="ceiling per pixel"):
        history(
            surface,
            moving,
            material=rc.RIGID,
            counter_material=STEEL,
            ceiling=np.full((32, 32), 3e9),
        )


def test_a_step_that_does_not_converge_is_named() -> None:
    with pytest.raises(rc.ConvergenceError, match="stage 2 of 3: not converged") as caught:
        history(rough(32), [0.0, 1.0, 2.0], material=STEEL, max_iterations=2)
    assert caught.value.result.load == 1.0


def test_calibrated_ceiling_of_an_approach_is_that_of_a_first_loading() -> None:
    # The approach was that from the indented body, with 97 % less contact.
    path = [Stage(load=2.0), Stage(load=0.0), Stage(approach=5e-7)]
    terms = {"material": STEEL, "boundary": "periodic"}
    found = history(rough(), path, **terms)
    usual = found.under_largest
    assert usual.approach == pytest.approx(5e-7, rel=1e-6)
    calibrated = solve.add_calibrated(usual).calibrated
    alone = rc.solve(rough(), approach=5e-7, **terms).calibrated
    assert calibrated is not None
    assert alone is not None
    assert calibrated.contact_fraction == pytest.approx(alone.contact_fraction, rel=0.02)
    deepest = float(found.indentation.max())
    assert calibrated.max_indentation == pytest.approx(deepest, rel=0.2)
