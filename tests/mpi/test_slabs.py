"""One contact on several ranks is the contact of one process."""

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import judge
import roughcontact as rc
from starting import assert_rejected, command, mpiexec

HERE = Path(__file__).parent

pytestmark = [pytest.mark.mpi, pytest.mark.process]


def case(count, task, folder):
    return mpiexec(count, HERE / "ranks_case.py", task, folder)


@pytest.fixture(scope="module")
def problems():
    pytest.importorskip("mpi4py", reason="mpi4py is not installed")
    import importlib.util

    spec = importlib.util.spec_from_file_location("ranks_case", HERE / "ranks_case.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def alone(problems):
    """The same by one process."""
    return {
        name: rc.solve(
            rc.Surface(problems.heights(name), problems.PIXEL, holes_masked=True),
            **problems.problem_arguments(name),
        )
        for name in problems.PROBLEMS
    }


@pytest.mark.parametrize(
    "count", [3, *(pytest.param(count, marks=pytest.mark.slow) for count in (1, 2, 4))]
)
def test_result_is_independent_of_rank_count(tmp_path, problems, alone, count):
    run = case(count, "solve", tmp_path)
    assert run.returncode == 0, run.stderr
    for name, expected in alone.items():
        found = rc.read_result(tmp_path / f"{name}.nc", verify=True)
        # Single precision promises a certificate of 1e-4, and that all the same.
        loose = 1e6 if name == "single" else 1
        np.testing.assert_array_equal(found.contact, expected.contact)
        np.testing.assert_array_equal(found.saturated, expected.saturated)
        largest = expected.max_pressure
        near = 1e-9 * loose
        np.testing.assert_allclose(found.pressure, expected.pressure, rtol=0, atol=near * largest)
        assert found.approach == pytest.approx(expected.approach, rel=near)
        load = problems.PROBLEMS[name].get("load")
        if name != "coated":  # The judge knows no layers
            assert judge.faults(found, load, problems.problem_arguments(name)["tolerance"]) == []
        assert found.regime == expected.regime
        # The last steps are those of rounding.
        assert found.convolutions <= expected.convolutions + 4
        told = np.load(tmp_path / f"{name}.npy")
        edge = [c.numbers["edge_load"] for c in expected.cautions if "edge_load" in c.numbers]
        numbers = [
            expected.contact_area,
            expected.perimeter_corrected_area,
            expected.mean_gap,
            expected.residual_indentation.max(),
            *(edge or [0.0]),
        ]
        np.testing.assert_allclose(told, numbers, rtol=10 * near, atol=1e-18)


@pytest.mark.parametrize("count", [1, 3])
def test_operator_inverse_and_level_match_one_process(tmp_path, count):
    run = case(count, "apply", tmp_path)
    assert run.returncode == 0, run.stderr


def test_whole_map_is_gathered_or_raises_error(tmp_path):
    run = case(2, "whole", tmp_path)
    assert run.returncode == 0, run.stderr
    assert (tmp_path / "out.html").read_text(encoding="utf-8").count("data:image/png") == 3


OPTIONS = ["--load", "0.5 N", "--material", "100Cr6", "--boundary", "periodic"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory, problems):
    place = tmp_path_factory.mktemp("maps")
    heights = problems.heights("free, ceiling")
    np.save(place / "map.npy", heights * 1e6)
    rc.Surface(heights, problems.PIXEL).save(place / "map.nc")
    h5py = pytest.importorskip("h5py")
    with h5py.File(place / "map.h5", "w") as file:
        file["heights"] = heights
        file["heights"].attrs["unit"] = "m"
    return place


SIZE = ["--size", "76.8 um x 75 um"]
GIVEN = {"npy": ["--unit", "um", *SIZE], "h5": SIZE, "nc": []}


@pytest.mark.slow
@pytest.mark.parametrize("suffix", GIVEN)
def test_the_command_reads_solves_and_writes_by_slabs(tmp_path, folder, suffix):
    words = ["solve", folder / f"map.{suffix}", *GIVEN[suffix], *OPTIONS]
    output, report = tmp_path / "out.nc", tmp_path / "out.html"
    run = command(2, *words, "--json", "--output", output, "--report", report)
    assert run.returncode == 0, run.stderr
    # One of them speaks.
    told = json.loads(run.stdout)
    assert told["ranks"] == 2
    assert told["written"] == [str(output), str(report)]
    single = subprocess.run(
        [sys.executable, "-m", "roughcontact", *map(str, words), "--json"],
        capture_output=True,
        text=True,
        check=True,
    )
    expected = json.loads(single.stdout)
    for key in (
        "load",
        "approach",
        "contact_area",
        "max_pressure",
        "mean_gap",
        "max_residual_indentation",
        "perimeter_corrected_area",
    ):
        assert told[key] == pytest.approx(expected[key], rel=1e-5), key
    assert told["shape"] == expected["shape"]
    assert told["pixel"] == pytest.approx(expected["pixel"])
    found = rc.read_result(output, verify=True)
    assert found.contact_area == told["contact_area"]
    assert "least-squares plane" in " ".join(found.surface.provenance.steps)
    page = report.read_text(encoding="utf-8")
    assert page.count("data:image/png") == 3
    assert '<th scope="row">Ranks</th><td>2</td>' in page


def test_nominal_pressure_is_shown_as_specified(tmp_path, folder):
    report = tmp_path / "out.html"
    words = ["solve", folder / "map.npy", *GIVEN["npy"], "--load", "80 MPa", *OPTIONS[2:]]
    run = command(2, *words, "--verbose", "--report", report)
    assert run.returncode == 0, run.stderr
    told = "nominal pressure: 80 MPa on the whole map, 5760 µm², are 460.8 mN"
    assert told in " ".join(run.stdout.split())
    assert told in report.read_text(encoding="utf-8")


@pytest.mark.slow
def test_command_and_script_of_the_page_run(tmp_path, problems, monkeypatch):
    text = (HERE.parents[1] / "docs" / "howto" / "mpi.md").read_text(encoding="utf-8")
    words, volume = re.findall(r"```sh\nmpiexec -n 4 roughcontact (.*?)```", text, re.DOTALL)
    (script,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    rng = np.random.default_rng(3)
    # Rough enough, in um over 2 mm, that 10 N press only some of it flat.
    rough = rng.normal(size=(64, 64))
    np.save(tmp_path / "map.npy", rough)
    monkeypatch.chdir(tmp_path)
    run = command(2, *shlex.split(words.replace("\\\n", " ")), "--verbose")
    assert run.returncode == 0, run.stderr
    assert "Parallel run" in run.stdout
    first = rc.read_result("contact.nc", verify=True)
    assert Path("contact.html").exists()
    Path("script.py").write_text(script)
    # A sphere of 20 mm on the same 2 mm.
    y, x = np.mgrid[-6:6, -6:6] / 6
    np.save("map.npy", -(x**2 + y**2) * 25)
    run = command(2, *shlex.split(volume.replace("\\\n", " ")))
    assert run.returncode == 0, run.stderr
    assert rc.read_result("contact.nc", verify=True).converged
    np.save("map.npy", rough)
    run = mpiexec(2, "-m", "mpi4py", "script.py")
    assert run.returncode == 0, run.stderr
    again = rc.read_result("contact.nc", verify=True)
    # One line, of the first rank; 100Cr6 is harder.
    assert len(run.stdout.splitlines()) == 1
    assert float(run.stdout.split()[0]) == again.max_pressure
    assert again.contact_area >= first.contact_area > 0


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["solve", "map.npy", *GIVEN["npy"], *OPTIONS, "--s-filter", "2 um"], "--s-filter"),
        (["solve", "map.npy", *GIVEN["npy"], *OPTIONS, "--output", "out.csv"], "written as .nc"),
        (["solve", "none.npy", *GIVEN["npy"], *OPTIONS], "does not exist"),
        (
            ["sweep", "map.npy", *GIVEN["npy"], "--from", "1 N", "--to", "2 N", *OPTIONS[2:]],
            "without mpiexec",
        ),
        (
            ["solve", "map.npy", *GIVEN["npy"], "--load", "1 MN", "--material", "100Cr6"],
            "more than the surface can carry",
        ),
        (["solve", "map.npy", *GIVEN["npy"], *OPTIONS, "--channel", "2"], "has no channels"),
        (
            ["solve", "map.npy", *GIVEN["npy"], "--load", "hertz 1 GPa", "--material", "100Cr6"],
            "needs a nominal sphere",
        ),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_options_for_whole_map_are_rejected_once(folder, monkeypatch, words, sentence):
    monkeypatch.chdir(folder)
    assert_rejected(command(2, *words), sentence)


def test_too_many_ranks_are_rejected(tmp_path):
    np.save(tmp_path / "small.npy", np.random.default_rng(0).normal(size=(4, 40)))
    run = command(
        3, "solve", tmp_path / "small.npy", "--unit", "nm", "--size", "4 um x 40 um", *OPTIONS
    )
    assert_rejected(run, "over at most 2 ranks, got 3")


@pytest.mark.parametrize("task", ["die_solving", "die_writing"])
def test_lost_rank_ends_all_without_partial_file(tmp_path, task):
    (tmp_path / "out.nc").write_text("what was there before")
    run = case(2, task, tmp_path)
    assert run.returncode != 0
    assert "TERMINATION" in run.stdout + run.stderr
    assert (tmp_path / "out.nc").read_text() == "what was there before"


def test_full_disk_raises_error_on_all_ranks(tmp_path):
    (tmp_path / "out.nc").write_text("what was there before")
    run = case(2, "fail_writing", tmp_path)
    assert run.returncode == 0, run.stderr
    told = [(tmp_path / f"told-{rank}").read_text() for rank in (0, 1)]
    assert told == ["No space left on device"] * 2
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out.nc", "told-0", "told-1"]
    assert (tmp_path / "out.nc").read_text() == "what was there before"


def test_failed_rank_ends_all(tmp_path):
    np.save(tmp_path / "map.npy", np.random.default_rng(0).normal(size=(64, 64)) * 1e-7)
    run = case(2, "fail_alone", tmp_path)
    assert run.returncode != 0
    assert "rank 1 failed, and with it all others" in run.stderr
