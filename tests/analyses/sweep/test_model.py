import dataclasses
import json
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

import roughcontact as rc
from roughcontact.analyses.sweep.model import LoadStep
from roughcontact.contact import load_case
from roughcontact.contact.stiffness import contact_growth, predict_pressure, stiffness
from roughcontact.halfspace.convolution import Convolution
from roughcontact.halfspace.fft import Workspace
from roughcontact.solvers.progress import Progress
from roughcontact.theory import hertz, persson

STEEL = rc.Material(210e9, 0.3, 1e9, "steel")
LOADS = [0.02, 0.1, 0.5, 2.0]


def rough(n: int = 64, seed: int = 3) -> rc.Surface:
    return rc.Surface(*rc.reference_map(n, seed))


def ball(n: int, radius: float = 0.01, side: float = 64e-6) -> rc.Surface:
    pixel = side / n
    x = (np.arange(n) - (n - 1) / 2) * pixel
    return rc.Surface(-(x**2 + x[:, None] ** 2) / (2 * radius), (pixel, pixel))


def numbers(curve: rc.results.LoadCurve) -> list[tuple[float, ...]]:
    names = [f.name for f in dataclasses.fields(LoadStep) if f.name != "seconds"]
    return [tuple(curve.column(name).tolist()) for name in names]


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("ceiling", ["auto", None])
def test_every_step_matches_solve(ceiling: str | None, boundary: str) -> None:
    surface = rough()
    curve = rc.sweep(surface, material=STEEL, loads=LOADS, ceiling=ceiling, boundary=boundary)
    assert curve.column("load").tolist() == LOADS
    for step in curve.steps:
        alone = rc.solve(
            surface, material=STEEL, load=step.load, ceiling=ceiling, boundary=boundary
        )
        assert step.certificate <= 1e-6
        assert step.approach == pytest.approx(alone.approach, rel=1e-5)
        assert step.mean_gap == pytest.approx(alone.mean_gap, rel=1e-5)
        assert step.max_pressure == pytest.approx(alone.max_pressure, rel=1e-4)
        # A pixel at the rim may change sides within the certificate.
        assert step.contact_area == pytest.approx(alone.contact_area, abs=2.5 * alone.pixel_area)
        assert step.spots == pytest.approx(alone.spots().count, abs=1)
    area = curve.column("contact_area")
    assert (np.diff(area) > 0).all()
    if ceiling is None:
        assert (curve.column("saturated_area") == 0).all()
    else:
        assert (curve.column("saturated_area") <= area).all()


def test_approaches_and_loads_are_one_curve() -> None:
    surface = rough()
    by_load = rc.sweep(surface, material=STEEL, loads=LOADS)
    by_depth = rc.sweep(surface, material=STEEL, approaches=by_load.column("approach").tolist())
    assert by_depth.column("load") == pytest.approx(LOADS, rel=1e-5)
    assert by_depth.control == "approach"


@pytest.mark.parametrize("boundary", ["free", "periodic"])
@pytest.mark.parametrize("ceiling", [None, 3e9])
def test_stiffness_is_the_slope_of_the_curve(ceiling: float | None, boundary: str) -> None:
    surface = rough()
    options = {"material": STEEL, "ceiling": ceiling, "boundary": boundary, "tolerance": 1e-10}
    here = rc.solve(surface, load=1.0, **options)
    near = rc.solve(surface, load=1.0 + 1e-5, initial_guess=here, **options)
    assert (near.contact == here.contact).all()
    assert (near.saturated == here.saturated).all()
    slope = (near.load - here.load) / (near.approach - here.approach)
    assert stiffness(here) == pytest.approx(slope, rel=1e-4)


def test_stiffness_of_a_circle_is_twice_modulus_times_radius() -> None:
    result = rc.solve(ball(128), load=0.1, material=STEEL, ceiling=None)
    a = hertz.contact_radius(0.1, 0.01, result.contact_modulus)
    # The pixels of a rim of radius 23 make the punch a little too large.
    assert result.stiffness() == pytest.approx(2 * result.contact_modulus * a, rel=0.01)
    curve = rc.sweep(ball(128), loads=[0.1], material=STEEL, ceiling=None)
    assert curve.constriction_length[0] == pytest.approx(4 * a, rel=0.01)


@pytest.mark.parametrize("boundary", ["free", "periodic-x"])
def test_saturated_points_conduct(boundary: str) -> None:
    surface = ball(160, side=0.8e-3)
    options = {"material": STEEL, "ceiling": 0.6e9, "boundary": boundary}
    curve = rc.sweep(surface, loads=[1.0, 100.0], **options)
    elastic, saturated = curve.steps
    assert elastic.saturated_area == 0
    assert elastic.unloading_stiffness == elastic.stiffness
    assert saturated.saturated_area > 0.9 * saturated.contact_area
    result = rc.solve(surface, load=100.0, **options)
    whole = dataclasses.replace(result, ceiling=None)
    assert saturated.unloading_stiffness == pytest.approx(stiffness(whole), rel=1e-6)
    if boundary == "free":
        a = math.sqrt(saturated.contact_area / math.pi)
        # Of 46 pixels; the exact radius is not known, that of the area of the pixels is near.
        assert curve.constriction_length[1] == pytest.approx(4 * a, rel=0.01)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_stiffness_needs_few_convolutions(monkeypatch: pytest.MonkeyPatch, boundary: str) -> None:
    result = rc.solve(rough(), load=1.0, material=STEEL, ceiling=None, boundary=boundary)
    shape = result.surface.shape
    operator = result.pair.operators("double", Workspace())(shape, (1, 1))
    applied: list[type] = []
    apply = Convolution._apply

    def record_transform(self: Convolution, *arguments: Any) -> None:
        # Neither blocks of pixels nor the approximate inverse.
        if math.isclose(self.self_displacement, operator.self_displacement, rel_tol=1e-4):
            applied.append(self.real)
        apply(self, *arguments)

    with monkeypatch.context() as patched:
        patched.setattr(Convolution, "_apply", record_transform)
        found = stiffness(result)
    assert applied.count(np.float64) == 1
    assert len(applied) <= 6
    # All pixels that touch displaced by a unit length, without iteration.
    index = np.flatnonzero(result.contact)
    units = np.eye(result.pressure.size)[index].reshape(-1, *shape)
    matrix = np.array([operator(unit).ravel()[index] for unit in units])
    resisted = np.linalg.solve(matrix, np.ones(index.size)).sum()
    assert found == pytest.approx(resisted * result.pixel_area, rel=1e-8)


@pytest.mark.parametrize("boundary", ["free", "periodic-x"])
@pytest.mark.parametrize("ceiling", [None, 3e9])
def test_contact_growth_matches_stiffness(ceiling: float | None, boundary: str) -> None:
    options = {"material": STEEL, "ceiling": ceiling, "boundary": boundary, "tolerance": 1e-10}
    here = rc.solve(rough(), load=1.0, **options)
    there = rc.solve(rough(), load=1.001, **options)
    grown = contact_growth(here)
    change = np.linalg.norm(there.pressure - here.pressure)
    for start in (
        predict_pressure(here, grown, load=1.001),
        predict_pressure(here, grown, approach=there.approach),
    ):
        assert start.min() == 0
        assert ceiling is None or start.max() <= ceiling
        assert np.linalg.norm(start - there.pressure) < 0.1 * change
    assert predict_pressure(here, grown, load=1.001).sum() * here.pixel_area == pytest.approx(
        1.001, rel=1e-12
    )


@pytest.mark.long
@pytest.mark.parametrize(("ceiling", "boundary"), [(3e9, "free"), (None, "periodic")])
def test_sweep_needs_fewer_convolutions_than_chained_solves(
    ceiling: float | None, boundary: str
) -> None:
    surface, loads = rough(128), load_case.space_values(0.5, 1.0, 12)
    options = {"material": STEEL, "ceiling": ceiling, "boundary": boundary}
    curve = rc.sweep(surface, loads=loads, **options)
    last, each = None, 0
    for load in loads:
        last = rc.solve(surface, load=load, initial_guess=last, **options)
        each += last.convolutions
    assert curve.column("convolutions").sum() < 0.9 * each


@pytest.mark.parametrize("ceiling", ["calibrated", 1.05e9])
def test_loads_near_capacity_are_solved(ceiling: Any) -> None:
    # Steps that are saturated all over, or whose own ceiling cannot carry the next load.
    soft = rc.Material(210e9, 0.3, 3.5e8)
    surface = rough(32)
    most = 1.05e9 * surface.shape[0] ** 2 * surface.pixel[0] ** 2
    loads = [share * most for share in (0.02, 0.3, 0.7, 0.99, 0.9999, 1.0)]
    if ceiling == "calibrated":
        loads = loads[:3]
    curve = rc.sweep(surface, material=soft, loads=loads, ceiling=ceiling)
    assert curve.column("certificate").max() <= 1e-6
    assert curve.column("load").tolist() == loads


def test_stiffness_without_elastic_pixels_is_zero_and_in_full_contact_infinite() -> None:
    surface = rough(32)
    full = rc.solve(surface, load=1e3, material=STEEL, ceiling=None, boundary="periodic")
    assert full.contact_fraction == 1
    assert np.isinf(full.stiffness())
    soft = rc.solve(surface, load=1.0, material=STEEL, ceiling=1.0 / full.pixel_area / 32**2)
    assert soft.saturated.all()
    assert soft.stiffness() == 0
    assert soft.perimeter_corrected_area == soft.contact_area


@pytest.mark.parametrize("n", [32, 64, 128])
def test_corrected_area_of_hertz(n: int) -> None:
    result = rc.solve(ball(n), load=0.1, material=STEEL, ceiling=None)
    a = hertz.contact_radius(0.1, 0.01, result.contact_modulus)
    exact = np.pi * a**2
    # A rim of 2πa/Δx pixels, each known to some tenths: measured below a sixth of it.
    assert (
        abs(result.perimeter_corrected_area - exact) < 0.2 * 2 * np.pi * a * result.pixel_area**0.5
    )
    assert abs(result.perimeter_corrected_area - exact) < abs(result.contact_area - exact)


def test_corrected_area_counts_the_seam_of_a_period() -> None:
    surface = rough()
    options = {"load": 3.0, "material": STEEL, "boundary": "periodic", "ceiling": None}
    result = rc.solve(surface, **options)
    moved = rc.Surface(np.roll(surface.heights, (11, 23), (0, 1)), surface.pixel)
    shifted = rc.solve(moved, **options)
    assert shifted.perimeter_corrected_area == pytest.approx(
        result.perimeter_corrected_area, rel=1e-3
    )


def test_two_saturated_loads_have_low_load_slope() -> None:
    curve = rc.sweep(rough(64), material=STEEL, loads=[1.0, 2.0])
    assert not curve.low_loads.any()
    secant = curve.steps[0].perimeter_corrected_area / curve.steps[0].load
    expected = secant * curve.contact_modulus * curve.rms_gradient
    assert curve.low_load_slope == pytest.approx(expected)
    assert curve.summary()["low_load_slope"] == pytest.approx(expected)
    # That of no theory, it is not drawn as one.
    assert not any("κ" in line.get_label() for line in curve.plot().axes[0].lines)


def test_low_load_slope_and_persson() -> None:
    surface = rough(128)
    curve = rc.sweep(
        surface, material=STEEL, loads=load_case.space_values(0.1, 30, 6), ceiling=None
    )
    # No more than 5 % of the map: theory 1.6 to 2.5, few and small spots at this size.
    assert 1.5 < curve.low_load_slope < 2.6
    contact_area, saturated = curve.persson
    mean = curve.column("load") / curve.nominal_area
    expected = [
        persson.persson_fractions(p, curve.contact_modulus, curve.rms_gradient)[0] for p in mean
    ]
    assert contact_area / curve.nominal_area == pytest.approx(expected)
    assert (saturated == 0).all()


def test_resumed_sweep_ends_with_the_same_numbers(tmp_path: Path) -> None:
    surface = rough()
    whole = rc.sweep(surface, material=STEEL, loads=LOADS, folder=tmp_path / "whole")

    class StopError(Exception):
        pass

    def stop(at: Progress) -> None:
        if at.number == 3:
            raise StopError

    folder = tmp_path / "cut"
    with pytest.raises(StopError):
        rc.sweep(surface, material=STEEL, loads=LOADS, folder=folder, progress=stop)
    assert sorted(path.name for path in folder.iterdir()) == [
        "step-0001.npz",
        "step-0002.npz",
        "sweep.json",
    ]
    before = {path: path.stat().st_mtime_ns for path in folder.iterdir()}
    calls = []
    resumed = rc.sweep(
        surface,
        material=STEEL,
        loads=LOADS,
        folder=folder,
        progress=lambda at: calls.append((at.number, at.kept)),
    )
    assert calls[:2] == [(1, True), (2, True)]
    assert {number for number, kept in calls if not kept} == set(range(3, len(LOADS) + 1))
    assert all(path.stat().st_mtime_ns == stamp for path, stamp in before.items())
    assert numbers(resumed) == numbers(whole)


CHILD = """
import sys
import roughcontact as rc
steel = rc.Material(210e9, 0.3, 1e9, "steel")
surface = rc.Surface(*rc.reference_map(128, 3))
rc.sweep(surface, material=steel, loads={loads}, folder=sys.argv[1])
"""


@pytest.mark.process
@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no SIGKILL on this system")
def test_killed_sweep_resumes(tmp_path: Path) -> None:
    loads = load_case.space_values(0.01, 10, 25)
    surface = rough(128)
    folder = tmp_path / "sweep"
    code = CHILD.format(loads=loads)
    child = subprocess.Popen([sys.executable, "-c", code, str(folder)], env={**os.environ})
    try:
        for _ in range(6000):
            if len(list(folder.glob("step-*.npz"))) >= 3 or child.poll() is not None:
                break
            time.sleep(0.01)
    finally:
        child.send_signal(signal.SIGKILL)
        child.wait()
    done = len(list(folder.glob("step-*.npz")))
    assert 3 <= done < len(loads)
    resumed = rc.sweep(surface, material=STEEL, loads=loads, folder=folder)
    whole = rc.sweep(surface, material=STEEL, loads=loads)
    assert numbers(resumed) == numbers(whole)


def test_folder_of_another_sweep_raises_input_error(tmp_path: Path) -> None:
    surface = rough(32)
    folder = tmp_path / "s"
    rc.sweep(surface, material=STEEL, loads=[0.1], folder=folder)
    before = sorted((p.name, p.read_bytes()) for p in folder.iterdir())
    with pytest.raises(rc.InputError, match="another sweep: values differ"):
        rc.sweep(surface, material=STEEL, loads=[0.2], folder=folder)
    with pytest.raises(rc.InputError, match="another sweep: surface differ"):
        rc.sweep(rough(32, 4), material=STEEL, loads=[0.1], folder=folder)
    with pytest.raises(rc.InputError, match="another sweep: ceiling differ"):
        rc.sweep(surface, material=STEEL, loads=[0.1], folder=folder, ceiling=None)
    assert before == sorted((p.name, p.read_bytes()) for p in folder.iterdir())
    (folder / "step-0001.npz").write_bytes(b"broken")
    with pytest.raises(rc.FormatError, match="remove it to solve it again"):
        rc.sweep(surface, material=STEEL, loads=[0.1], folder=folder)
    (folder / "sweep.json").write_text("{")
    with pytest.raises(rc.FormatError, match=r"sweep\.json is damaged"):
        rc.sweep(surface, material=STEEL, loads=[0.1], folder=folder)
    (folder / "sweep.json").unlink()
    with pytest.raises(rc.InputError, match=r"without sweep\.json"):
        rc.sweep(surface, material=STEEL, loads=[0.1], folder=folder)
    with pytest.raises(rc.InputError, match="is a file"):
        rc.sweep(surface, material=STEEL, loads=[0.1], folder=folder / "step-0001.npz")


def test_changed_step_raises_format_error(tmp_path: Path) -> None:
    surface, folder = rough(32), tmp_path / "s"
    arguments = dict(material=STEEL, loads=[0.1, 0.2, 0.3], folder=folder)
    whole = rc.sweep(surface, **arguments)
    first, second = folder / "step-0001.npz", folder / "step-0002.npz"
    sound = second.read_bytes()

    def assert_step_rejected(words: str) -> None:
        with pytest.raises(rc.FormatError, match=rf"step-0002\.npz {words}.*solve it again"):
            rc.sweep(surface, **arguments)

    for size in (0, 100, len(sound) // 2, len(sound) - 1):
        second.write_bytes(sound[:size])
        assert_step_rejected("cannot be read as a step")
    second.write_bytes(sound)
    with np.load(second) as stored:
        arrays = dict(stored)
    for name, value in (("load", 0.25), ("pressure", 1.001 * arrays["pressure"]), ("asked", 0.25)):
        np.savez(second, **(arrays | {name: value}))
        assert_step_rejected("was damaged or changed")
    # Sound steps, but of another load, and of a sweep with other loads.
    second.write_bytes(first.read_bytes())
    assert_step_rejected("is a step of another sweep or of another load")
    rc.sweep(surface, **(arguments | dict(loads=[0.1, 0.2], folder=tmp_path / "other")))
    second.write_bytes((tmp_path / "other" / second.name).read_bytes())
    assert_step_rejected("is a step of another sweep or of another load")
    second.unlink()
    assert numbers(rc.sweep(surface, **arguments)) == numbers(whole)


def test_two_sweeps_do_not_share_a_folder(tmp_path: Path) -> None:
    # Both saw an empty folder: the steps of one were taken for those of the other.
    surface, seen = rough(32), []

    def meanwhile(at: Progress) -> None:
        for loads in ([0.2], [0.1, 0.2]):
            with pytest.raises(rc.InputError, match="is in use: another sweep is writing to it"):
                rc.sweep(surface, material=STEEL, loads=loads, folder=tmp_path / "s")
        seen.append(at.number)

    rc.sweep(surface, material=STEEL, loads=[0.1, 0.2], folder=tmp_path / "s", progress=meanwhile)
    assert seen
    names = {path.name for path in (tmp_path / "s").iterdir()}
    assert names == {"sweep.json", "step-0001.npz", "step-0002.npz"}


def test_the_largest_load_is_checked_first(tmp_path: Path) -> None:
    with pytest.raises(rc.CapacityError, match="load = 1000 N"):
        rc.sweep(rough(32), material=STEEL, loads=[1.0, 1e3], folder=tmp_path / "s")
    assert not (tmp_path / "s").exists()


def test_a_step_that_fails_names_itself_and_keeps_the_others(tmp_path: Path) -> None:
    with pytest.raises(rc.ConvergenceError, match=r"step 1 of 2, load = 0\.1 N: .* are saved in"):
        rc.sweep(
            rough(),
            material=STEEL,
            loads=[0.1, 1.0],
            ceiling=None,
            max_iterations=1,
            tolerance=1e-12,
            folder=tmp_path / "s",
        )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "either loads or approaches"),
        ({"loads": [1.0], "approaches": [1e-7]}, "either loads or approaches"),
        ({"loads": []}, "loads is empty"),
        ({"loads": [1.0, 0.5]}, "loads must ascend"),
        ({"loads": [1.0, 1.0]}, "loads must ascend"),
        ({"loads": [-1.0]}, "loads must be positive"),
        ({"approaches": [float("nan")]}, "approaches must be positive"),
        ({"loads": ["1 m"]}, "loads needs a load such as"),
        ({"loads": ["0 N"]}, "loads must be positive"),
    ],
)
def test_bad_loads(arguments: dict, message: str) -> None:
    with pytest.raises(rc.InputError, match=message):
        rc.sweep(rough(32), material=STEEL, **arguments)


@given(st.floats(1e-9, 1e3), st.floats(1.001, 1e6), st.integers(2, 50))
def test_spacing(first: float, ratio: float, number: int) -> None:
    last = first * ratio
    for spacing in ("log", "linear"):
        values = np.array(load_case.space_values(first, last, number, spacing))
        assert values[0] == first
        assert values[-1] == last
        steps = np.diff(np.log(values) if spacing == "log" else values)
        assert (steps > 0).all()
        assert steps == pytest.approx(np.full(number - 1, steps.mean()), rel=1e-6)


def test_curve_on_disk(tmp_path: Path) -> None:
    curve = rc.sweep(rough(32), material=STEEL, loads=[0.1, 1.0])
    curve.save(tmp_path / "curve.csv")
    curve.save(tmp_path / "curve.json")
    table = np.genfromtxt(tmp_path / "curve.csv", delimiter=",", names=True, deletechars="")
    assert table["load_[N]"].tolist() == [0.1, 1.0]
    assert table["stiffness_[N/m]"].tolist() == curve.column("stiffness").tolist()
    read = json.loads((tmp_path / "curve.json").read_text(encoding="utf-8"))
    assert read["contact_area"] == curve.column("contact_area").tolist()
    with pytest.raises(rc.InputError, match=r"\.xlsx or \.json"):
        curve.save(tmp_path / "curve.xls")
    with pytest.raises(rc.InputError, match="name must be one of"):
        curve.column("area")


def test_loads_are_parsed_from_one_text() -> None:
    surface, steel = rc.Surface(*rc.reference_map(32)), rc.Material(210e9, 0.3)
    found = rc.sweep(surface, material=steel, loads="5 MPa, 10 MPa")
    same = rc.sweep(surface, material=steel, loads=["5 MPa", "10 MPa"])
    assert found.column("load").tolist() == same.column("load").tolist()


def test_a_bracket_is_the_curves_of_coating_and_base(tmp_path: Path) -> None:
    film = rc.Layer(83e9, 0.37, 5e-6, hardness="264 MPa", name="silver")
    tool = rc.Material(124e9, 0.34, 180e6, coating=[film])
    problem = {"material": tool, "boundary": "periodic", "loads": "5 MPa, 20 MPa"}
    surface = rc.Surface(*rc.reference_map(64))
    both = rc.sweep(surface, ceiling="bracket", folder=tmp_path, **problem)
    assert both.base is not None
    for curve, name in ((both, "coating"), (both.base, "base")):
        alone = rc.sweep(surface, ceiling=name, **problem)
        assert curve.ceiling == alone.ceiling
        for key in ("contact_area", "mean_gap", "approach"):
            np.testing.assert_array_equal(curve.column(key), alone.column(key))
    assert both.ceiling < both.base.ceiling
    again = rc.sweep(surface, ceiling="bracket", folder=tmp_path, **problem)
    np.testing.assert_array_equal(both.base.column("load"), again.base.column("load"))
    record = both.summary()
    assert record["base_contact_area"] == list(both.base.column("contact_area"))
    assert "under that of the base" in str(both)
