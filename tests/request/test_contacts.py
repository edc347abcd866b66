import json
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughcontact as rc
from roughcontact._tools.files import to_json
from roughcontact.analyses.tasks import SHARED_TASKS as JOINTS, from_text
from roughcontact.batch import project
from roughcontact.cli import app
from roughcontact.contact.result import ContactResult
from roughcontact.request import contacts as joints, run as running
from roughcontact.request.request import Request
from roughcontact.surface import nominal_bodies
from roughcontact.surface.placement import drawn_pairs

STEEL = rc.Material(210e9, 0.3, 1e9)
COPPER = rc.Conductor(conductivity=400)
ROUGH = rc.Surface(*rc.reference_map(32, 3))


@pytest.fixture
def solves(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Return the loads that were solved, as they are."""
    found: list[float] = []
    solve = joints.solve_uncalibrated

    def record_load(surface: rc.Surface, **options: Any) -> ContactResult:
        found.append(options["load"])
        return solve(surface, **options)

    monkeypatch.setattr(joints, "solve_uncalibrated", record_load)
    return found


def solve_joint(surface: rc.Surface = ROUGH, **more: Any) -> ContactResult:
    return rc.solve(surface, **{"material": STEEL, "load": 0.3, "boundary": "periodic", **more})


def conducted(contacts: list[ContactResult]) -> rc.results.Conductance:
    return rc.conductance(contacts, COPPER, COPPER)


OF_ONE_PAIR = [rc.leakage, conducted]


@pytest.mark.parametrize("ask", [rc.interface_law, *OF_ONE_PAIR])
@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"surface": rc.Surface(ROUGH.heights, (2e-6, 2e-6))}, "grid"),
        ({"surface": rc.Surface(*rc.reference_map(64))}, "grid"),
        ({"boundary": "periodic-x"}, "boundary"),
        ({"material": rc.Material(70e9, 0.3, 1e9)}, "material of the body"),
        ({"material": rc.Material(210e9, 0.3, 2e9)}, "material of the body"),
        ({"counter_material": STEEL}, "material of the counter-body"),
        ({"ceiling": None}, "elastic"),
    ],
)
def test_contacts_of_a_joint_differ_in_nothing_but_the_load(
    ask: Any, more: dict[str, Any], words: str
) -> None:
    with pytest.raises(rc.InputError, match=words):
        ask([solve_joint(), solve_joint(**more, load=0.2)])


def test_faces_are_drawn_at_other_places_and_turns() -> None:
    flat = nominal_bodies.flat(shape=ROUGH.shape, pixel=ROUGH.pixel)
    other = rc.Surface(*rc.reference_map(40, 4))
    pairs = drawn_pairs([flat, ROUGH], [ROUGH, other], 8)
    # All pairs of maps come in turn, cropped to what both have.
    assert [first.Sq == 0 for first, _ in pairs] == [True, False] * 4
    assert all(first.shape == second.shape == (32, 32) for first, second in pairs)
    heights = np.sort(ROUGH.heights, axis=None)
    moved = [second for first, second in pairs if first.Sq == 0][::2]
    for second in moved:
        assert np.array_equal(np.sort(second.heights, axis=None), heights)
    assert not np.array_equal(moved[0].heights, moved[1].heights)
    # A flat feels nothing of it.
    still = solve_joint(flat, counter_surface=ROUGH)
    for second in moved:
        found = solve_joint(flat, counter_surface=second)
        assert found.contact_fraction == pytest.approx(still.contact_fraction)
        assert found.mean_gap == pytest.approx(still.mean_gap, rel=1e-6)


def test_faces_with_other_pixels_are_resampled() -> None:
    coarse = rc.Surface(ROUGH.heights, (1.3 * ROUGH.pixel[0], 1.3 * ROUGH.pixel[1]))
    for pair in ([ROUGH], [coarse]), ([coarse], [ROUGH]):
        for first, second in drawn_pairs(*pair, 2):
            assert first.shape == second.shape
            assert first.pixel == pytest.approx(second.pixel)
            assert first.Sq == pytest.approx(second.Sq, rel=0.3)


@pytest.mark.parametrize(
    ("task", "more", "number"),
    [
        (
            "conductance",
            ["--conductivity", "400 W/m/K", "--counter-conductivity", "400 W/m/K"],
            lambda record: record["length"][-1],
        ),
        ("leak", [], lambda record: record["permeability_tensor"][-1][1][1]),
    ],
)
def test_a_joint_of_two_rough_faces_is_the_mean_of_draws(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], task: str, more: list[str], number: Any
) -> None:
    other = rc.Surface(*rc.reference_map(32, 4))
    ROUGH.save(tmp_path / "one.nc")
    other.save(tmp_path / "two.nc")
    app.main(
        [
            task,
            str(tmp_path / "one.nc"),
            "--counter-maps",
            str(tmp_path / "two.nc"),
            *shlex.split(
                "--set draws=3 --level none --load '0.1 N, 0.3 N' --boundary periodic "
                "--young '210 GPa' --poisson 0.3 --yield-strength '1 GPa' --json"
            ),
            *more,
        ]
    )
    stored = json.loads(capsys.readouterr().out)
    values = []
    for first, second in drawn_pairs([ROUGH], [other], 3):
        contact = solve_joint(first, counter_surface=second)
        if task == "leak":
            values.append(float(rc.leakage([contact]).permeability(1)[-1]))
        else:
            values.append(conducted([contact]).steps[-1].length)
    assert min(values) > 0
    assert number(stored) == pytest.approx(np.mean(values), rel=1e-6)
    drawn = stored["draws"][-1]
    assert drawn["count"] == 3
    assert drawn["deviation"] == pytest.approx(np.std(values, ddof=1), rel=1e-6)


def test_gas_leak_of_joint_is_mean_of_pairs() -> None:
    fluid = {"gas": "helium", "inlet": "2 bar", "outlet": "1 mbar", "flow_axis": "x"}
    pairs = drawn_pairs([ROUGH], [rc.Surface(*rc.reference_map(32, 4))], 3)
    each = [
        rc.leakage(solve_joint(first, counter_surface=second), **fluid) for first, second in pairs
    ]
    rates = [item.throughput(1)[0] for item in each]
    assert max(rates) > 1.05 * min(rates) > 0
    assert each[0].with_draws(each[1:]).throughput(1)[0] == pytest.approx(np.mean(rates))


@pytest.mark.parametrize("ask", OF_ONE_PAIR)
@pytest.mark.parametrize(
    "more",
    [
        {"surface": rc.Surface(*rc.reference_map(32, 4))},
        {"counter_surface": rc.Surface(*rc.reference_map(32, 4))},
    ],
)
def test_only_a_law_is_of_several_maps(ask: Any, more: dict[str, Any]) -> None:
    with pytest.raises(rc.InputError, match="different maps"):
        ask([solve_joint(), solve_joint(**more, load=0.2)])
    # The same bodies, made again, with a name and another ceiling.
    again = solve_joint(
        rc.Surface(ROUGH.heights.copy(), ROUGH.pixel),
        ceiling=2e9,
        material=rc.Material(210e9, 0.3, 1e9, name="steel"),
        load=0.2,
    )
    assert len(ask([solve_joint(), again]).steps) == 2


def test_unloaded_maps_need_same_bodies_and_boundary() -> None:
    surface = rc.Surface(*rc.reference_map(64, 3))
    contacts = [solve_joint(surface, load=load) for load in (1.0, 3.0)]
    left = rc.indented_surface(contacts[-1])
    for more in ({"boundary": "free"}, {"counter_material": STEEL}):
        with pytest.raises(rc.InputError, match="differ in"):
            rc.interface_law(contacts, [solve_joint(left, ceiling=None, load=1.0, **more)])
    without_strength = solve_joint(left, material=rc.Material(210e9, 0.3), load=1.0)
    assert rc.interface_law(contacts, [without_strength]).branches == ("loading", "unloading")


def request(folder: Path, **more: str) -> Request:
    np.save(folder / "map.npy", ROUGH.heights * 1e6)
    given = {
        "unit": "um",
        "size": "0.1 mm x 0.1 mm",
        "level": "none",
        "material": "42CrMo4",
        "counter-material": "6061-T6",
        "boundary": "periodic",
        "load": "0.1 N, 0.3 N",
        **more,
    }
    given = {key: value for key, value in given.items() if value}
    return from_text("conductance", folder / "map.npy", given)


def test_cached_contact_is_identical(solves: list[float]) -> None:
    with joints.cached_solver() as solve:
        asked = {"material": STEEL, "boundary": "periodic"}
        first = solve(ROUGH, load=0.3, **asked)
        again = solve(ROUGH, load=0.3, **asked)
        other = solve(ROUGH, load=0.1, **asked)
        third = solve(ROUGH, load=0.3, **asked, ceiling=None)
    assert solves == [0.3, 0.1, 0.3]
    for one in (first, again):
        np.testing.assert_array_equal(one.pressure, first.pressure)
        np.testing.assert_array_equal(one.gap, first.gap)
        assert one.summary() == first.summary()
    assert other.load == 0.1
    assert third.ceiling is None


@pytest.mark.long
def test_combined_requests_match_separate_requests(tmp_path: Path, solves: list[float]) -> None:
    requests = [request(tmp_path), request(tmp_path, **{"electrical-film": "1e-12 ohm m^2"})]
    with running.shared_runner() as carry_out:
        both = [carry_out(one, lambda _: None) for one in requests]
    # The largest load again, under the calibrated ceiling.
    assert solves == [0.3, 0.1, 0.3]
    assert both[0].result.largest.surface is both[1].result.largest.surface
    for one, outcome in zip(requests, both, strict=True):
        assert running.run_request(one, lambda _: None).record() == outcome.record()
    # Another preparation is another map.
    with running.shared_runner() as carry_out:
        for one in (request(tmp_path), request(tmp_path, level="plane")):
            carry_out(one, lambda _: None)
    assert solves.count(0.1) == 3


def joint_project(folder: Path, tasks: str, *more: str) -> Path:
    np.save(folder / "map.npy", ROUGH.heights * 1e6)
    path = folder / "project.toml"
    lines = [
        'folder = "out"',
        'write = ["csv"]',
        "[[contact]]",
        'name = "joint"',
        'file = "map.npy"',
        f"task = {tasks}",
        'unit = "um"',
        'size = "0.1 mm x 0.1 mm"',
        'boundary = "periodic"',
        'material = "42CrMo4"',
        'counter-material = "6061-T6"',
        *more,
    ]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_a_contact_may_have_a_list_of_tasks_and_of_loads(tmp_path: Path) -> None:
    path = joint_project(tmp_path, '["conductance"]', 'load = ["0.1 N, 0.3 N", "1 N"]')
    entries = project.read_project(path)
    assert [entry.name for entry in entries] == ["joint 0.1 N, 0.3 N", "joint 1 N"]
    assert [entry.contact for entry in entries] == [1, 2]


@pytest.mark.parametrize(
    ("tasks", "more", "words"),
    [
        ('["conductance", "solve"]', (), "several tasks must be different ones of law"),
        ("[]", (), "several tasks must be different"),
        ('["conductance", "conductance"]', (), "several tasks must be different"),
        ("[1]", (), "several tasks must be different"),
        ('["conductance"]', ('depths = "1 um"',), 'depths needs task = "stress"'),
    ],
)
def test_invalid_task_lists_raise_input_error(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    tasks: str,
    more: tuple[str, ...],
    words: str,
) -> None:
    path = joint_project(tmp_path, tasks, 'load = "0.1 N"', *more)
    assert app.main(["run", str(path)]) == app.BAD_INPUT
    error = capsys.readouterr().err
    assert words in error
    assert "project.toml line" in error


@pytest.mark.long
def test_joint_tasks_under_same_pressures_share_contacts(
    tmp_path: Path, solves: list[float]
) -> None:
    # Elastic, so that the law has no second branch.
    more = ('from = "1 MPa"', 'to = "30 MPa"', "steps = 3", 'ceiling = "none"')
    listed = ", ".join(f'"{task}"' for task in JOINTS)
    entries = project.read_project(joint_project(tmp_path, f"[{listed}]", *more))
    assert [entry.name for entry in entries] == [f"joint {task}" for task in JOINTS]
    assert len({entry.contact for entry in entries}) == 1
    requests = [entry.request for entry in entries]
    (tmp_path / "out").mkdir()
    with running.shared_runner() as carry_out:
        together = [to_json(carry_out(one, lambda _: None).record()) for one in requests]
    assert len(solves) == len(set(solves)) == 3
    for one, record in zip(requests, together, strict=True):
        assert to_json(running.run_request(one, lambda _: None).record()) == record


@pytest.mark.long
def test_project_writes_outputs_of_each_task(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pressures = ('from = "1 MPa"', 'to = "30 MPa"', "steps = 3")
    listed = ", ".join(f'"{task}"' for task in JOINTS)
    path = joint_project(tmp_path, f"[{listed}]", *pressures)
    assert app.main(["run", str(path), "--json"]) == app.SOLVED
    record = json.loads(capsys.readouterr().out)["contacts"]
    assert [one["state"] for one in record] == ["solved"] * len(JOINTS)
    for task in JOINTS:
        assert (tmp_path / "out" / f"joint-{task}.csv").stat().st_size > 100
    assert app.main(["run", str(path), "--json"]) == app.SOLVED
    again = json.loads(capsys.readouterr().out)["contacts"]
    assert [one["state"] for one in again] == ["solved before"] * len(JOINTS)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"from": "1 MPa"}, "to is needed"),
        ({"from": "2 MPa", "to": "1 MPa"}, "from must be positive and below to"),
        (
            {"from": "1 MPa", "to": "2 MPa", "load": "1 N"},
            "load cannot be combined with from and to",
        ),
        ({}, "load is needed, such as '1 N'"),
    ],
)
def test_missing_loads_raise_input_error(tmp_path: Path, more: dict[str, str], words: str) -> None:
    with pytest.raises(rc.InputError, match=words):
        request(tmp_path, **{"load": "", **more})


@pytest.mark.parametrize(
    ("first", "second", "heading"),
    [
        (("one.nc",), ("two.nc", "three.nc"), "one.nc (E 210 GPa) against two.nc, three.nc"),
        # Maps of the counter-body are not maps of the surface, however many that one has.
        (("one.nc", "two.nc"), ("three.nc",), "one.nc, two.nc (E 210 GPa) against three.nc"),
    ],
)
def test_the_heading_of_a_law_names_the_maps_of_both_faces(
    first: Sequence[str],
    second: Sequence[str],
    heading: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    for seed, name in enumerate(("one.nc", "two.nc", "three.nc")):
        rc.Surface(*rc.reference_map(32, seed)).save(name)
    words = [word for name in second for word in ("--counter-maps", name)] + ["--set", "draws=4"]
    words += ["--from", "10 MPa", "--to", "50 MPa", "--steps", "2", "--boundary", "periodic"]
    words += ["--young", "210 GPa", "--poisson", "0.3", "--yield-strength", "1 GPa"]
    app.main(["law", *first, *words])
    found = " ".join(capsys.readouterr().out.split("\n\n")[0].split())
    assert found == f"{heading} (rigid), 4 pairs, periodic"
