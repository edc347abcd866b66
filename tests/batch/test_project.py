import json
import os
import signal
import subprocess
import threading
from multiprocessing import resource_tracker
from pathlib import Path

import numpy as np
import psutil
import pytest

import roughcontact as rc
from fleets import wait_for
from roughcontact.batch import plan, project, runner
from roughcontact.cli import app
from roughcontact.elastoplastic.archive import load_elastoplastic
from roughcontact.request import measurement, outputs
from roughcontact.request.options import CEILING, HEAD, LOAD

Capture = pytest.CaptureFixture[str]

HEADER = """\
folder = "results"
write = ["nc", "csv"]

[materials.steel]
young = "210 GPa"
poisson = 0.3
yield-strength = "1 GPa"

[defaults]
unit = "um"
size = "0.1 mm x 0.2 mm"
material = "steel"
"""
PROJECT = f"""{HEADER}
[[contact]]
name = "one"
file = "rough.npy"
load = ["0.1 N", "1 N"]

[[contact]]
name = "two"
file = "rough.npy"
load = "0.5 N"
ceiling = "none"
counter-material = "alumina"
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    y, x = np.mgrid[:40, :64] / 40
    noise = np.random.default_rng(3).standard_normal(y.shape)
    np.save(tmp_path / "rough.npy", np.cos(7 * y) * np.cos(5 * x) + 0.1 * noise)
    (tmp_path / "project.toml").write_text(PROJECT, encoding="utf-8")
    return tmp_path


def write_changed_project(folder: Path, old: str, new: str) -> Path:
    assert old in PROJECT
    path = folder / "project.toml"
    path.write_text(PROJECT.replace(old, new, 1), encoding="utf-8")
    return path


def widest(out: str) -> int:
    """Return the length of the longest line but for paths, which are not wrapped."""
    return max(len(line) for line in out.splitlines() if not line.startswith("/"))


@pytest.mark.process
def test_a_ceiling_can_be_recommended(folder: Path, capsys: Capture) -> None:
    path = write_changed_project(folder, 'ceiling = "none"', 'ceiling = "calibrated"')
    assert app.main(["run", str(path), "--json"]) == app.SOLVED
    two = next(c for c in json.loads(capsys.readouterr().out)["contacts"] if c["name"] == "two")
    assert two["state"] == "solved"
    found = rc.read_result(folder / "results" / "two.nc")
    assert found.calibration.factor == pytest.approx(found.ceiling / 1e9)


def test_keys_with_underscores_are_read_as_with_hyphens(folder: Path) -> None:
    path = folder / "project.toml"
    before = [entry.request for entry in project.read_project(path)]
    changed = PROJECT.replace("yield-strength", "yield_strength")
    path.write_text(changed.replace("counter-material", "counter_material"), encoding="utf-8")
    assert [entry.request for entry in project.read_project(path)] == before
    wrong = changed.replace("counter-material = ", "counter_material = true #")
    path.write_text(wrong, encoding="utf-8")
    with pytest.raises(rc.InputError, match=rf"line {line_of('counter-material')}: counter-mat"):
        project.read_project(path)


def line_of(text: str) -> int:
    return PROJECT[: PROJECT.index(text)].count("\n") + 1


VOLUME = """\
write = ["vtr", "vti"]

[defaults]
unit = "um"
size = "0.4 mm"
body = "sphere 10 mm"
young = "210 GPa"
poisson = 0.3
yield-strength = "1 GPa"
hardening = "linear 20 GPa"
model = "elastoplastic"
increments = 2
tolerance = 1e-3
folder = "steps"

[[contact]]
name = "ball"
file = "flat.npy"
load = ["60 N", "100 N"]
"""


@pytest.mark.slow
@pytest.mark.process
def test_contacts_of_volume_model_have_separate_folders(tmp_path: Path, capsys: Capture) -> None:
    np.save(tmp_path / "flat.npy", np.zeros((24, 24)))
    path = tmp_path / "volume.toml"
    path.write_text(VOLUME, encoding="utf-8")
    assert app.main(["run", str(path), "--json"]) == app.SOLVED
    for load in (60, 100):
        steps = tmp_path / "steps" / f"ball-{load}-N"
        assert {file.name for file in steps.iterdir()} == {
            "volume.json",
            "step-0001.nc",
            "step-0002.nc",
        }
        last = load_elastoplastic(steps / "step-0002.nc")
        assert last.contact.load == load
        record = json.loads((tmp_path / "volume" / f"ball-{load}-N.json").read_text("utf-8"))
        assert record["volume"]["max_plastic_strain"] == last.max_plastic_strain
        assert record["regime"] == last.regime
        assert all((tmp_path / "volume" / f"ball-{load}-N.{s}").exists() for s in ("vtr", "vti"))
    capsys.readouterr()
    assert app.main(["run", str(path)]) == app.SOLVED
    assert capsys.readouterr().out.startswith("2 contacts: 2 solved before\n")
    # A changed contact is solved again; its previous steps are moved to another folder.
    steps = tmp_path / "steps" / "ball-60-N"
    for strength in ("30 GPa", "40 GPa"):
        before = {file.name: file.read_bytes() for file in steps.iterdir()}
        path.write_text(VOLUME.replace("20 GPa", strength), encoding="utf-8")
        assert app.main(["run", str(path)]) == app.SOLVED
        aside = steps.with_name("ball-60-N.before")
        assert {file.name: file.read_bytes() for file in aside.iterdir()} == before
        assert {file.name for file in steps.iterdir()} == before.keys()
        assert (steps / "step-0002.nc").read_bytes() != before["step-0002.nc"]


def test_a_project_names_contacts_materials_and_files(folder: Path) -> None:
    entries = project.read_project(folder / "project.toml")
    assert [entry.name for entry in entries] == ["one 0.1 N", "one 1 N", "two"]
    one, other, two = (entry.request for entry in entries)
    assert (one[LOAD], other[LOAD], two[LOAD]) == (0.1, 1.0, 0.5)
    assert one.bodies == (rc.Material(210e9, 0.3, 1e9), rc.RIGID)
    assert two[CEILING] is None
    assert two.bodies[1].hardness is not None
    assert one.outputs == tuple(folder / "results" / f"one-0.1-N.{s}" for s in ("nc", "csv"))
    assert entries[2].summary == folder / "results" / "two.json"


@pytest.mark.process
def test_contacts_are_solved_saved_and_solved_again_after_change(
    folder: Path, capsys: Capture
) -> None:
    assert app.main(["run", str(folder / "project.toml"), "--json"]) == app.SOLVED
    record = json.loads(capsys.readouterr().out)["contacts"]
    assert [report["state"] for report in record] == ["solved"] * 3
    surface = rc.read_surface(folder / "rough.npy", unit="um", size=(1e-4, 2e-4)).leveled()
    steel = rc.Material(210e9, 0.3, 1e9)
    for name, load in (("one-0.1-N", 0.1), ("one-1-N", 1.0)):
        result = rc.solve(surface, load=load, material=steel)
        stored = rc.read_result(folder / "results" / f"{name}.nc")
        assert stored.max_pressure == pytest.approx(result.max_pressure, rel=1e-6)
        summary = json.loads((folder / "results" / f"{name}.json").read_text(encoding="utf-8"))
        assert summary["load"] == load
    before = {path: path.stat().st_mtime_ns for path in (folder / "results").iterdir()}
    assert app.main(["run", str(folder / "project.toml")]) == app.SOLVED
    out = capsys.readouterr().out
    assert out.startswith("3 contacts: 3 solved before\n")
    assert before == {path: path.stat().st_mtime_ns for path in (folder / "results").iterdir()}
    write_changed_project(folder, 'load = "0.5 N"', 'load = "0.6 N"')
    (folder / "results" / "one-1-N.nc").unlink()
    assert app.main(["run", str(folder / "project.toml"), "--json"]) == app.SOLVED
    record = json.loads(capsys.readouterr().out)["contacts"]
    assert [report["state"] for report in record] == ["solved before", "solved", "solved"]


INSTRUMENT = """\
uncertainty = true
instrument = "measured itf.csv"
noise = "./second.npy"
also = ["fine.npy=CSI 100x", "finer.npy"]
"""


def test_files_of_the_instrument_are_relative_to_the_project(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (folder / "itf.csv").write_text("0,1\n250,0.5\n500,0\n", encoding="utf-8")
    for name in ("second", "fine", "finer"):
        np.save(folder / f"{name}.npy", np.load(folder / "rough.npy"))
    path = write_changed_project(folder, 'load = "0.5 N"\n', f'load = "0.5 N"\n{INSTRUMENT}')
    (folder / "elsewhere").mkdir()
    monkeypatch.chdir(folder / "elsewhere")
    entry = project.read_project(path)[-1]
    assert entry.request[measurement.NOISE] == folder / "second.npy"
    assert [place for place, _ in entry.request[measurement.ALSO]] == [
        folder / "fine.npy",
        folder / "finer.npy",
    ]
    read = ("rough.npy", "second.npy", "fine.npy", "finer.npy", "itf.csv")
    assert set(entry.request.read_files) == {folder / name for name in read}
    # A changed second map changes the intervals.
    before = plan.request_digest(entry)
    np.save(folder / "second.npy", np.zeros((40, 64)))
    assert plan.request_digest(entry) != before


def test_report_table_heads_the_reports(folder: Path) -> None:
    head = '[report]\nproject = "P 7"\nauthor = "A. Sample"\n\n[materials'
    path = write_changed_project(folder, "[materials", head)
    with pytest.raises(rc.InputError, match=r'report needs write = \["html"\]'):
        project.read_project(path)
    text = PROJECT.replace('"csv"]', '"html"]')
    path.write_text(text.replace("[materials", head), encoding="utf-8")
    for entry in project.read_project(path):
        assert [entry.request.get(option) for option in HEAD] == ["P 7", None, "A. Sample"]
    path.write_text(text.replace("[materials", head.replace("author", "autor")), encoding="utf-8")
    with pytest.raises(rc.InputError, match="did you mean author"):
        project.read_project(path)


def test_material_of_contact_overrides_defaults(folder: Path) -> None:
    text = PROJECT.replace('material = "steel"', 'young = "70 GPa"\npoisson = 0.2')
    soft = '[materials.soft]\nyoung = "1 GPa"\npoisson = 0.4\n\n[defaults]'
    own = '\n[[contact]]\nname = "{0}"\nfile = "rough.npy"\nload = "1 mN"\n{1}\n'
    text = text.replace("[defaults]", soft) + own.format("soft", 'material = "soft"')
    text += own.format("known", 'material = "6061-T6"')
    text += own.format("part", 'material = "soft"\npoisson = 0.3')
    (folder / "project.toml").write_text(text, encoding="utf-8")
    entries = project.read_project(folder / "project.toml")
    found = {entry.name: entry.request.bodies[0] for entry in entries}
    constants = {name: (body.young, body.poisson) for name, body in found.items()}
    assert constants["two"] == (70e9, 0.2)
    assert constants["soft"] == (1e9, 0.4)
    assert constants["part"] == (1e9, 0.3)
    assert found["known"].young == pytest.approx(69e9, rel=0.02)


@pytest.mark.process
def test_one_failure_does_not_stop_the_rest(folder: Path, capsys: Capture) -> None:
    path = write_changed_project(folder, '"0.1 N", "1 N"', '"0.1 N", "99 N"')
    with path.open("a", encoding="utf-8") as stream:
        stream.write('\n[[contact]]\nname = "none"\nfile = "absent.opd"\nload = "1 N"\n')
    assert app.main(["run", str(path)]) == app.NOT_CONVERGED
    out, err = capsys.readouterr()
    assert widest(out) <= 80
    assert err.count("\n") == 2
    assert "one 99 N: load = 99 N is more than the surface can carry" in err
    assert "none: " in err
    assert "does not exist" in err
    assert (folder / "results" / "two.json").exists()
    assert not (folder / "results" / "one-99-N.json").exists()
    assert not (folder / "results" / "one-99-N.nc").exists()


def test_a_process_that_dies_is_a_failure(folder: Path) -> None:
    child = "import os; os._exit(9)"
    entries = project.read_project(folder / "project.toml")[:1]
    # A spawned process imports this module first.
    (folder / "sitecustomize.py").write_text(child, encoding="utf-8")
    before = os.environ.get("PYTHONPATH")
    # Python's own helper would die of it, too, and be missed by the next test.
    resource_tracker.ensure_running()
    os.environ["PYTHONPATH"] = str(folder)
    try:
        reports = runner.run_project(entries, lambda report: None)
    finally:
        if before is None:
            del os.environ["PYTHONPATH"]
        else:
            os.environ["PYTHONPATH"] = before
    assert [report.state for report in reports] == [plan.FAILED]
    assert "status 9" in reports[0].reason


def run_project(start, path: Path) -> subprocess.Popen[str]:
    """Start to work through a project in a separate process."""

    def listen() -> None:
        # A shell that runs the tests in the background has Ctrl-C ignored.
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    environment = {**os.environ, "PYTHONPATH": str(Path(rc.__file__).parents[1])}
    return start("-m", "roughcontact", "run", path, env=environment, preexec_fn=listen)


def hidden_files(folder: Path) -> list[str]:
    return [file.name for file in folder.rglob(".*")]


@pytest.mark.slow
@pytest.mark.process
@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no SIGKILL on this system")
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT, signal.SIGTERM])
def test_interrupted_project_resumes(folder: Path, number: int, start) -> None:
    many = ", ".join(f'"{load} mN"' for load in range(1, 41))
    path = write_changed_project(folder, '"0.1 N", "1 N"', many)
    run = run_project(start, path)
    results = folder / "results"
    assert wait_for(lambda: len(list(results.glob("*.json"))) >= 2)
    run.send_signal(number)
    err = run.communicate()[1]
    if number != signal.SIGKILL:
        assert run.returncode == 128 + number
        assert "of 41 contacts saved in" in err.splitlines()[-1]
        assert hidden_files(folder) == []
    done = {p: p.stat().st_mtime_ns for p in results.glob("*.json")}
    assert 2 <= len(done) < 41
    entries = project.read_project(path)[: len(done) + 1]
    reports = runner.run_project(entries, lambda report: None)
    assert all(report.state != plan.FAILED for report in reports)
    assert {plan.KEPT, plan.SOLVED} == {report.state for report in reports}
    assert all(p.stat().st_mtime_ns == stamp for p, stamp in done.items())
    assert hidden_files(folder) == []


LONG = """
[defaults]
unit = "um"
size = "0.1 mm x 0.2 mm"
material = "bearing steel"
task = "sweep"
folder = "kept"
from = "1 mN"
to = "1 N"
steps = 10000

[[contact]]
name = "one"
file = "rough.npy"

[[contact]]
name = "two"
file = "rough.npy"
"""


@pytest.mark.long
def test_files_of_killed_step_are_removed(folder: Path) -> None:
    pytest.importorskip("fcntl")
    path = folder / "short.toml"
    path.write_text(LONG.replace("10000", "2"), encoding="utf-8")
    left = ".roughcontact-0123456789abcdef.part"
    for state in (plan.SOLVED, plan.KEPT):
        # A pass has a separate folder in that of the contact.
        kept = folder / "kept" / "one"
        (kept / "pass-0001").mkdir(parents=True, exist_ok=True)
        for place in (kept, kept / "pass-0001"):
            (place / left).touch()
        reports = runner.run_project(project.read_project(path), lambda report: None)
        assert {report.state for report in reports} == {state}
        assert hidden_files(folder) == []


@pytest.mark.process
@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no SIGKILL on this system")
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_no_process_outlives_the_first(folder: Path, number: int, start) -> None:
    path = folder / "long.toml"
    path.write_text(LONG, encoding="utf-8")
    run = run_project(start, path)
    kept = folder / "kept"
    assert wait_for(lambda: list(kept.rglob("step-*.npz")))
    children = psutil.Process(run.pid).children()
    assert children
    run.send_signal(number)
    run.wait()
    # They would continue for minutes, and the pipe is theirs, too.
    ended = wait_for(lambda: not any(alive(child) for child in children), 20.0)
    for child in filter(alive, children):
        child.kill()
    assert ended
    if number == signal.SIGTERM:
        assert hidden_files(folder) == []


def alive(process: psutil.Process) -> bool:
    return process.is_running() and process.status() != psutil.STATUS_ZOMBIE


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('young = "210 GPa"', "young = 210", ("young needs a pressure", "no unit")),
        ("poisson = 0.3", "poisson = 0.9", ("poisson must be in",)),
        ('yield-strength = "1 GPa"', 'yeild = "1 GPa"', ("unknown key yeild",)),
        ('unit = "um"', 'units = "um"', ("unknown key units; did you mean unit?", "unit, size")),
        ('material = "steel"', 'material = "stele"', ("material", "not in the catalog")),
        ('load = "0.5 N"', 'load = "0.5 mm"', ("load needs a load", "(a length)")),
        ('load = "0.5 N"', "load = [1, []]", ("load",)),
        ('load = "0.5 N"', "load = []", ("load is an empty list",)),
        ('load = "0.5 N"', 'level = "plane"', ("give one of load and approach",)),
        ('load = "0.5 N"', 'load = "0.5 N"\nstudy = 1', ("study must be true or false",)),
        ('load = "0.5 N"', 'load = "0.5 N"\noutput = "a.nc"', ("unknown key output",)),
        ('name = "two"', 'name = "one 1 N"', ("'one 1 N' is taken",)),
        ('name = "two"', "name = 2", ("needs a name",)),
        ("[defaults]", "[default]", ("unknown key default; did you mean defaults?",)),
        ('write = ["nc", "csv"]', 'write = ["doc"]', ("write must be a list of nc",)),
        (
            'write = ["nc", "csv"]',
            'write = ["png", "nc", "svg"]',
            ('write has png, svg, of which task = "solve" writes one',),
        ),
        ('folder = "results"', "folder = 1", ("folder must be a text",)),
        ('folder = "results"', 'folder = "rough.npy"', ("is a file",)),
        ('folder = "results"', "folder = ", ("is no TOML file", "line 1")),
    ],
)
def test_messages_name_key_and_line(
    old: str, new: str, words: tuple[str, ...], folder: Path, capsys: Capture
) -> None:
    path = write_changed_project(folder, old, new)
    assert app.main(["run", str(path)]) == app.BAD_INPUT
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert "--" not in err
    for word in words:
        assert word in err
    if "TOML" not in words[0]:
        # The line of the key itself, or of the contact where the key is missing.
        found = int(err.split(" line ")[1].split(":")[0])
        first = line_of(old)
        assert found in range(
            first - (4 if "give one of" in words[0] or "name" in old else 0), first + 2
        )
    assert not (folder / "results").exists()


@pytest.mark.parametrize(
    "text",
    [
        '[defaults]\n{}\n[[contact]]\nname="a"\nfile="m"\nload="1 N"\n'
        '[[contact]]\nname="b"\nfile="m"\ntask="law"',
        '[[contact]]\n{}\nname="a"\nfile="m"\ntask=["law", "leak"]',
    ],
)
def test_coating_is_rejected_by_tasks_of_bare_bodies(text: str, tmp_path: Path) -> None:
    values = 'material = "42CrMo4"\nfrom = "1 MPa"\nto = "2 MPa"\n'
    path = tmp_path / "coated.toml"
    path.write_text(text.format(values))
    assert len(project.read_project(path)) == 2
    path.write_text(text.format(f'{values}coating = "DLC 2 um"\nceiling = "coating"'))
    with pytest.raises(
        rc.InputError, match=r"line \d: coating needs task = .*, got \"law\": the unloaded"
    ):
        project.read_project(path)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ("no [[contact]]",)),
        ("contact = 3", ("no [[contact]]",)),
        ("contact = [3]", ("must be a table",)),
        ("materials = 3\n[[contact]]\nname='a'\nfile='b'", ("materials must be tables",)),
        ("defaults = 3\n[[contact]]\nname='a'\nfile='b'", ("defaults must be a table",)),
        ("[[contact]]\nname='a'\nfile='b'\ntask=[['law']]", ("different ones of",)),
        ("[[contact]]\nname='a'\nfile=\"b\\u0000\"", ("null character",)),
        (f"contact = {'[' * 3000}{']' * 3000}", ("too deep",)),
        (f"[{'.'.join('a' * 1200)}]", ("too deep",)),
        (f"[[contact]]\nname='a'\nfile='b'\n{'.'.join('a' * 1200)} = 1", ("too deep",)),
    ],
)
def test_invalid_project_file_raises_error(
    text: str, words: tuple[str, ...], tmp_path: Path, capsys: Capture
) -> None:
    path = tmp_path / "p.toml"
    path.write_text(text, encoding="utf-8")
    assert app.main(["run", str(path)]) == app.BAD_INPUT
    err = capsys.readouterr().err
    assert all(word in err for word in words)
    assert app.main(["run", str(tmp_path / "absent.toml")]) == app.BAD_INPUT
    assert "cannot be read" in capsys.readouterr().err


def test_a_byte_order_mark_is_no_part_of_a_project(folder: Path) -> None:
    path = folder / "project.toml"
    expected = project.read_project(path)
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert project.read_project(path) == expected


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('name = "two"', f'name = "{300 * "x"}"'),
        ('name = "two"', f'name = "{251 * "x"}"'),
        ('folder = "results"', f'folder = "{300 * "y"}"'),
        ('folder = "results"', f'folder = "{"/".join(30 * [200 * "y"])}"'),
    ],
)
def test_too_long_names_raise_input_error_before_solve(old: str, new: str, folder: Path) -> None:
    with pytest.raises(rc.InputError, match="too many for the file system"):
        project.read_project(write_changed_project(folder, old, new))
    with pytest.raises(rc.InputError, match="303 characters"):
        outputs.check_place(folder / f"{300 * 'x'}.nc", "output")


TASKS = f"""{HEADER.replace('"csv"]', '"csv", "svg", "html"]')}\
load = "0.5 N"
friction = 0.2
folder = "kept"

[[contact]]
name = "curve"
file = "rough.npy"
task = "sweep"
from = "0.1 N"
to = "0.5 N"
steps = 3

[[contact]]
name = "below"
file = "rough.npy"
task = "stress"

[[contact]]
name = "path"
file = "rough.npy"
task = "history"
path = "0.5 N, 0 N"
passes = 2

[[contact]]
name = "ball"
body = "sphere 1 mm"
points = 32
"""


@pytest.mark.slow
@pytest.mark.process
def test_project_runs_every_task(folder: Path, capsys: Capture) -> None:
    path = folder / "tasks.toml"
    path.write_text(TASKS, encoding="utf-8")
    assert app.main(["run", str(path)]) == app.SOLVED
    out = capsys.readouterr().out
    assert widest(out) <= 80
    left = {file.name for file in (folder / "results").iterdir()}
    assert left == {
        "curve.json",
        "curve.csv",
        "curve.svg",
        "curve.html",
        "below.json",
        "below.nc",
        "below.html",
        *(f"below-stress-{name}.svg" for name in ("depth", "section", "map")),
        "path.json",
        "path.csv",
        "path.nc",
        "path.svg",
        "path.html",
        "ball.json",
        "ball.nc",
        "ball.csv",
        "ball.html",
        *(f"ball-{name}.svg" for name in ("surface", "pressure", "contact", "gap", "histogram")),
    }
    assert {file.name for file in (folder / "kept" / "curve").iterdir()} == {
        "sweep.json",
        *(f"step-{number:04d}.npz" for number in (1, 2, 3)),
    }
    record = {
        name: json.loads((folder / "results" / f"{name}.json").read_text("utf-8"))
        for name in ("curve", "below", "path", "ball")
    }
    surface = rc.read_surface(folder / "rough.npy", unit="um", size=(1e-4, 2e-4)).leveled()
    steel = rc.Material(210e9, 0.3, 1e9)
    result = rc.solve(surface, load=0.5, material=steel)
    assert record["curve"]["load"] == pytest.approx(np.geomspace(0.1, 0.5, 3))
    assert record["curve"]["last"]["contact_fraction"] == pytest.approx(result.contact_fraction)
    stress = rc.subsurface_stress(result, friction=0.2)
    assert record["below"]["stress"]["max_von_mises"] == pytest.approx(stress.max_von_mises)
    history = rc.history(surface, [0.5, 0.0] * 2, material=steel)
    assert record["path"]["steps"]["load"] == [0.5, 0.0, 0.5, 0.0]
    assert record["path"]["indentation_volume"] == pytest.approx(history.indentation_volume)
    assert record["ball"]["shape"] == [32, 32]
    # The same commands, kept; what has changed is done again, the others not.
    assert app.main(["run", str(path), "--json"]) == app.SOLVED
    states = [entry["state"] for entry in json.loads(capsys.readouterr().out)["contacts"]]
    assert states == [plan.KEPT] * 4
    path.write_text(TASKS.replace("passes = 2", "passes = 1"), encoding="utf-8")
    (folder / "results" / "curve.csv").unlink()
    before = (folder / "kept" / "curve" / "step-0001.npz").stat().st_mtime_ns
    assert app.main(["run", str(path), "--json"]) == app.SOLVED
    states = [entry["state"] for entry in json.loads(capsys.readouterr().out)["contacts"]]
    assert states == [plan.SOLVED, plan.KEPT, plan.SOLVED, plan.KEPT]
    assert (folder / "kept" / "curve" / "step-0001.npz").stat().st_mtime_ns == before


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('task = "sweep"', 'task = "swep"', ("task must be one of solve, sweep",)),
        (
            'task = "sweep"',
            'task = "history"',
            ('from needs task = "sweep" or "law" or "conductance" or "leak", got "history"',),
        ),
        ('from = "0.1 N"', 'from = "0.1 J"', ("from needs a load such as",)),
        ('from = "0.1 N"', 'from = "0.1 MPa"', ("from and to must both be loads of one form",)),
        ('from = "0.1 N"', 'from = "1 um"', ("from and to must both be loads of one form or",)),
        ("steps = 3", "steps = 1", ("steps must be a whole number from 2 to 10000, got 1",)),
        ("steps = 3", "step = 1", ("unknown key step; did you mean steps?", "from, to, steps")),
        ("steps = 3", "load = '1 N'", ('load needs task = "solve" or "stress"',)),
        ("steps = 3", "figure = 'a.png'", ("unknown key figure",)),
        ("passes = 2", "passes = 0", ("passes must be a whole number from 1 to 10000, got 0",)),
        ("passes = 2", "max-iterations = 'many'", ("max-iterations must be a whole number",)),
        ('path = "0.5 N, 0 N"', 'path = "0.5 N, 1 J"', ("path needs a load such as",)),
        ("friction = 0.2", "unload = true", ("unload fits none of the contacts",)),
        ("friction = 0.2", "friction = 'much'", ("friction must be a number",)),
        ("points = 32", "points = 1", ("points must be a number of points",)),
        ("points = 32", "level = 'none'", ("this contact needs a file",)),
    ],
)
def test_messages_of_tasks_name_key_and_line(
    old: str, new: str, words: tuple[str, ...], folder: Path, capsys: Capture
) -> None:
    assert old in TASKS
    path = folder / "tasks.toml"
    path.write_text(TASKS.replace(old, new, 1), encoding="utf-8")
    assert app.main(["run", str(path)]) == app.BAD_INPUT
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert "--" not in err
    for word in words:
        assert word in err
    line = TASKS[: TASKS.index(old)].count("\n") + 1
    found = int(err.split(" line ")[1].split(":")[0])
    assert found in ((line, line + 1) if "this contact" not in err else (line - 3,))


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes")
def test_project_is_read_from_pipe(folder: Path) -> None:
    path = folder / "piped.toml"
    os.mkfifo(path)
    text = (folder / "project.toml").read_text(encoding="utf-8")
    threading.Thread(target=path.write_text, args=(text,), daemon=True).start()
    assert [entry.name for entry in project.read_project(path)] == ["one 0.1 N", "one 1 N", "two"]


def test_endless_project_file_raises_format_error(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if Path("/dev/zero").exists():
        with pytest.raises(rc.FormatError, match="/dev/zero is not a regular file"):
            project.read_project("/dev/zero")
    with (folder / "project.toml").open("ab") as stream:
        stream.truncate(2**40)
    with pytest.raises(rc.FormatError, match=r"project\.toml has more than 16 million characters"):
        project.read_project(folder / "project.toml")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes")
def test_endless_file_has_no_stable_digest(folder: Path) -> None:
    os.mkfifo(folder / "fifo.npy")
    for file in ("fifo.npy", "/dev/zero"):
        path = write_changed_project(folder, 'file = "rough.npy"', f'file = "{file}"')
        first, _, last = project.read_project(path)
        assert plan.request_digest(first) != plan.request_digest(last)


# Nothing that is read is written


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        # The map of the other contact, by its name and by a link.
        ('name = "one"', 'name = "m"', "output 'results/m.csv' is an input file"),
        ('name = "one"', 'name = "soft"', "output 'results/soft.csv' is an input file"),
        ('name = "one"', 'name = "hard"', "output 'results/hard.csv' is an input file"),
        # One that is not there yet.
        ('"results/m.csv"', '"results/one.csv"', "output 'results/one.csv' is an input file"),
        ('name = "one"', 'name = "p"', "output 'results/p.json' is an input file"),
        (
            'name = "one"',
            'name = "two-surface"',
            "figure 'results/two-surface.png' is a file of 'two', too",
        ),
    ],
)
def test_output_over_input_of_other_contact_raises_error(
    old: str, new: str, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    monkeypatch.chdir(tmp_path)
    results = tmp_path / "results"
    results.mkdir()
    np.savetxt(results / "m.csv", np.eye(8), delimiter=",")
    (results / "soft.csv").symlink_to("m.csv")
    (results / "hard.csv").hardlink_to(results / "m.csv")
    (results / "p.json").symlink_to("../p.toml")
    text = """\
write = ["csv", "png"]
[defaults]
material = "bearing steel"
unit = "um"
size = "0.1 mm"

[[contact]]
name = "two"
file = "results/m.csv"
load = "0.1 N"

[[contact]]
name = "one"
task = "sweep"
file = "other.csv"
from = "0.1 N"
to = "1 N"
steps = 2
"""
    text = 'folder = "results"\n' + text.replace(old, new)
    Path("p.toml").write_text(text, encoding="utf-8")
    before = {path: path.read_bytes() for path in results.iterdir()}
    assert app.main(["run", "p.toml"]) == app.BAD_INPUT
    out, err = capsys.readouterr()
    line = text[: text.index(new if "name" in new else 'name = "one"')].count("\n") + 1
    assert (out, err) == (
        "",
        f"roughcontact: error: p.toml line {line}: {words}; give another name\n",
    )
    assert before == {path: path.read_bytes() for path in results.iterdir()}
