"""A volume on several ranks is the volume of one process, to the bit."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from starting import assert_rejected, command, mpiexec

HERE = Path(__file__).parent
FIELDS = (
    "thickness",
    "plastic_strain",
    "accumulated",
    "stress",
    "mean_stress",
    "residual_stress",
    "mean_residual_stress",
)

pytestmark = [pytest.mark.mpi, pytest.mark.process]


def case(count, task, folder):
    return mpiexec(count, "-m", "mpi4py", HERE / "volume_case.py", task, folder)


@pytest.fixture(scope="module")
def problems():
    pytest.importorskip("mpi4py", reason="mpi4py is not installed")
    import importlib.util

    spec = importlib.util.spec_from_file_location("volume_case", HERE / "volume_case.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def alone(problems):
    """The same by one process."""
    return {
        name: rc.solve_elastoplastic(problems.surface(name), **problems.problem_arguments(name))
        for name in problems.PROBLEMS
    }


@pytest.mark.parametrize(
    "count", [3, *(pytest.param(count, marks=pytest.mark.slow) for count in (1, 2, 4))]
)
def test_result_is_identical_for_any_rank_count(tmp_path, problems, alone, count):
    run = case(count, "solve", tmp_path)
    assert run.returncode == 0, run.stderr
    for name, expected in alone.items():
        found = rc.read_result(tmp_path / f"{name}.nc", verify=True)
        for maps in ("pressure", "gap"):
            mine, theirs = (getattr(one.solution, maps) for one in (found, expected))
            np.testing.assert_array_equal(mine, theirs)
        np.testing.assert_array_equal(found.residual_displacement, expected.residual_displacement)
        for body, other in zip(found.bodies, expected.bodies, strict=True):
            for field in FIELDS:
                np.testing.assert_array_equal(getattr(body, field), getattr(other, field))
        words = json.loads((tmp_path / f"{name}.json").read_text())
        assert words == problems.numbers_of_result(expected)
    (body,) = alone["grows"].bodies
    assert body.thickness.sum() > 4e-6, "the case was to grow deeper"


@pytest.mark.parametrize("count", [2, 3])
def test_operators_match_one_process(tmp_path, count):
    run = case(count, "apply", tmp_path)
    assert run.returncode == 0, run.stderr


@pytest.fixture(scope="module")
def folder(tmp_path_factory, problems):
    place = tmp_path_factory.mktemp("maps")
    y, x = np.mgrid[-14:14, -16:16] * 1.4
    rough = 3e-3 * np.random.default_rng(1).normal(size=y.shape)
    np.save(place / "map.npy", rough - (x**2 + y**2) / 210)
    return place


UNLOADED = [
    "--unit",
    "um",
    "--size",
    "39.2 um x 48 um",
    "--model",
    "elastoplastic",
    "--increments",
    "2",
    "--young",
    "210 GPa",
    "--poisson",
    "0.3",
    "--yield-strength",
    "1.6 GPa",
]
WORDS = [*UNLOADED, "--load", "0.2 N"]


@pytest.mark.slow
def test_command_output_matches_one_process(tmp_path, folder):
    words = ["solve", folder / "map.npy", *WORDS, "--crop", "2:22,4:26", "--json"]
    output, report, figure = (tmp_path / f"out{suffix}" for suffix in (".nc", ".html", ".png"))
    run = command(2, *words, "--output", output, "--report", report, "--figures", figure)
    assert run.returncode == 0, run.stderr
    # One of them speaks.
    told = json.loads(run.stdout)
    assert told["written"][:2] == [str(output), str(report)]
    assert all(Path(path).exists() for path in told["written"])
    single = subprocess.run(
        [sys.executable, "-m", "roughcontact", *map(str, words)],
        capture_output=True,
        text=True,
        check=True,
    )
    expected = json.loads(single.stdout)
    for one in (told, expected):
        assert one.pop("seconds") > 0
        assert one["volume"].pop("seconds") > 0
        del one["written"]
    assert told == expected
    found = rc.read_result(output, verify=True)
    assert found.max_plastic_strain == told["volume"]["max_plastic_strain"]
    assert report.read_text(encoding="utf-8").count("data:image/png") > 5


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--folder", "kept"], "--folder needs all states in one process"),
        (["--output", "out.vtr"], "written as .nc"),
        (["--load", "1 MN"], "more than the map can carry"),
        (["--crop", "2:99,0:9"], "rows must be"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_unsupported_options_are_rejected_once(folder, monkeypatch, words, sentence):
    monkeypatch.chdir(folder)
    known = [] if "--load" in words else ["--load", "0.2 N"]
    assert_rejected(command(2, "solve", "map.npy", *UNLOADED, *known, *words), sentence)


def test_error_is_raised_on_all_ranks(tmp_path):
    run = case(2, "refuse", tmp_path)
    assert run.returncode == 0, run.stderr
    for name, sentence in (
        ("folder", "not available for a volume on several ranks"),
        ("on_step", "not available for a volume on several ranks"),
        ("layers", "2 ranks share 1 layers"),
        ("load", "more than the map can carry"),
    ):
        told = [(tmp_path / f"{name}-{rank}").read_text() for rank in (0, 1)]
        assert sentence in told[0]
        assert told[0] == told[1]


@pytest.mark.parametrize("task", ["die_solving", "die_writing"])
def test_lost_rank_ends_all_without_partial_file(tmp_path, task):
    (tmp_path / "out.nc").write_text("what was there before")
    run = case(2, task, tmp_path)
    assert run.returncode != 0
    assert "TERMINATION" in run.stdout + run.stderr
    assert (tmp_path / "out.nc").read_text() == "what was there before"
