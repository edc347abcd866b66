"""Standard streams, interruptions and settings of the process, as a terminal or a pipe has them."""

import os
import re
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.batch.plan import ContactReport
from roughcontact.cli import app, console, terminal

SOURCE = Path(rc.__file__).parents[1]
SOLVE = 'solve map.npy --unit m --size "24 um" --load "1 mN" --young "210 GPa" --poisson 0.3'
UNIX = pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")

# Loaded wherever it is on the path, before anything else: sends Ctrl-C when a module is sought.
HOOK = """
import os, signal, sys

class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == os.environ.get("STOP_AT"):
            del os.environ["STOP_AT"]
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Finder())
"""

# Has every load take a while, and sends Ctrl-C during the fourth.
SLOW = """
import os, signal, time
from roughcontact.cli import terminal
from roughcontact.solvers import bounded

terminal.PROGRESS_INTERVAL, solve, solved = 0.5, bounded.solve, []

def slowly(*given, **options):
    solved.append(time.sleep(0.3))
    if len(solved) == 4:
        os.kill(os.getpid(), signal.SIGINT)
    return solve(*given, **options)

bounded.solve = slowly
"""

Ran = subprocess.CompletedProcess[str]
Run = Callable[..., Ran]


@pytest.fixture
def run(tmp_path: Path) -> Run:
    """Run the program in a shell, in a separate folder that holds a map."""
    heights = np.random.default_rng(0).standard_normal((24, 24)).cumsum(axis=0)
    np.save(tmp_path / "map.npy", 1e-8 * heights)

    def run(arguments: str, streams: str = "", **settings: str) -> Ran:
        path = os.pathsep.join([str(tmp_path), str(SOURCE)])
        return subprocess.run(
            f"{shlex.quote(sys.executable)} -m roughcontact {arguments} {streams}",
            shell=True,
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=False,
            env={**os.environ, "PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1", **settings},
        )

    return run


@UNIX
@pytest.mark.process
@pytest.mark.parametrize(
    ("arguments", "streams", "status", "expected"),
    [
        (SOLVE, ">&-", app.SOLVED, ""),
        (SOLVE, "2>&-", app.SOLVED, None),
        (f"{SOLVE} --output out.nc --quiet", "<&- >&- 2>&-", app.SOLVED, ""),
        ("--help", ">/dev/full", app.BAD_INPUT, "standard output: No space left on device"),
        ("info none.npy", "2>/dev/full", app.BAD_INPUT, ""),
        ("solve --laod 1", "2>/dev/full >&-", app.BAD_INPUT, ""),
    ],
)
def test_streams_that_are_closed_or_full(
    run: Run, tmp_path: Path, arguments: str, streams: str, status: int, expected: str | None
) -> None:
    done = run(arguments, streams)
    assert done.returncode == status
    if expected is not None:
        error = f"roughcontact: error: {expected}\n" if expected else ""
        assert (done.stdout, done.stderr) == ("", error)
    if "out.nc" in arguments:
        # Nothing that was printed has gone into the file.
        assert rc.read_result(tmp_path / "out.nc").converged


@pytest.mark.parametrize("arguments", ["--help", "materials"])
def test_closed_output_pipe_ends_quietly(arguments: str) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    done = subprocess.run(
        [sys.executable, "-m", "roughcontact", *arguments.split()],
        stdout=writing,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": str(SOURCE)},
    )
    os.close(writing)
    assert (done.returncode, done.stderr) == (app.PIPE_CLOSED, "")


@pytest.mark.skipif(os.name == "nt", reason="no process can send Ctrl-C to itself there")
@pytest.mark.parametrize(
    "module", ["roughcontact.cli", "numpy", "roughcontact.request.run", "h5netcdf"]
)
def test_ctrl_c_while_modules_are_loaded(run: Run, tmp_path: Path, module: str) -> None:
    (tmp_path / "sitecustomize.py").write_text(HOOK)
    before = set(tmp_path.iterdir())
    done = run(f"{SOLVE} --quiet --output out.nc", STOP_AT=module)
    # As a shell has it; a process that has died of the signal itself is treated as the same.
    assert done.returncode in (app.INTERRUPTED, -2)
    assert (done.stdout, done.stderr) == ("", "roughcontact: interrupted; nothing was written\n")
    assert set(tmp_path.iterdir()) == before


@pytest.mark.slow
@pytest.mark.long
def test_settings_of_matplotlib_do_not_reach_the_program(run: Run, tmp_path: Path) -> None:
    (tmp_path / "settings").write_text("text.usetex: True\nbackend: nonsense\n")
    options = "--points 32 --folder out"
    done = run(f"demo {options}", MATPLOTLIBRC="settings", MPLBACKEND="nonsense")
    assert done.returncode == app.SOLVED
    # A slow machine shows its progress.
    assert all(line.startswith(terminal.PROGRESS_PREFIX) for line in done.stderr.splitlines())
    assert (tmp_path / "out" / "overview.png").stat().st_size > 10_000


@pytest.mark.long
@pytest.mark.parametrize(
    "settings",
    [
        {"LC_ALL": "C", "PYTHONIOENCODING": "ascii:strict"},
        {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
        {"COLUMNS": "1", "TERM": "dumb", "NO_COLOR": "1"},
    ],
    ids=str,
)
def test_poor_terminals(run: Run, settings: dict[str, str]) -> None:
    done = run(
        f"{SOLVE} && {shlex.quote(sys.executable)} -m roughcontact info grüße.npy", **settings
    )
    assert done.returncode == app.BAD_INPUT
    assert "Contact pressure" in done.stdout
    assert done.stderr.startswith("roughcontact: error: gr")
    assert done.stderr.count("\n") == 1


def test_long_name_is_shortened_before_answer(capsys: pytest.CaptureFixture[str]) -> None:
    values = {"answer": "3.5 % of the face is in contact (3.4 to 4.2 %)."}
    long = "the sample that was ground twice, lapped once and measured in the middle"
    names = ["short", "x" * 45, long, "é" * 200]
    console.show_reports([ContactReport(name, "solved", values) for name in names], Path("results"))
    out = capsys.readouterr().out
    assert max(map(len, out.splitlines())) <= 80
    assert out.startswith("4 contacts: 4 solved\n")
    assert "".join(out.split()).count("x") == 45
    assert out.endswith("written to:\nresults\n\n")
    assert all(word in out for word in long.replace(",", "").split())
    console.show_reports([ContactReport("one", "failed", {}, "why")], Path("results"))
    assert "results" not in capsys.readouterr().out


THROUGH_C = """
import ctypes, sys
from roughcontact import __main__
from roughcontact.cli import app
run = ctypes.pythonapi.PyRun_String
run.restype = ctypes.py_object
run.argtypes = [ctypes.c_char_p, ctypes.c_int, ctypes.py_object, ctypes.py_object]
try:
    run(b"raise KeyboardInterrupt", 257, {}, {})
except KeyboardInterrupt:
    app.main = lambda: 143
    sys.exit(__main__.main())
"""


@pytest.mark.skipif(os.name == "nt", reason="no status for signals there")
def test_exit_status_names_signal_caught_in_c_code(tmp_path: Path) -> None:
    # CPython remembers an interrupt that C code has seen, and a module ends by SIGINT at last.
    (tmp_path / "through_c.py").write_text(THROUGH_C)
    done = subprocess.run(
        [sys.executable, "-m", "through_c"],
        cwd=tmp_path,
        check=False,
        env={**os.environ, "PYTHONPATH": str(SOURCE)},
    )
    assert done.returncode == app.SIGNALED + signal.SIGTERM


def test_progress_without_terminal_prints_lines(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(terminal, "PROGRESS_INTERVAL", 2.0)

    def lines() -> set[str]:
        result = ""
        while not result:
            time.sleep(0.1)
            result = capsys.readouterr().err
        return set(result.splitlines())

    began = time.monotonic()
    with terminal.show_progress() as line:
        line.set_stage("a solve", 4000.0)
        assert lines() == {"progress: a solve, about 67 min left"}
        assert time.monotonic() - began >= 0.4
    began = time.monotonic()
    with terminal.show_progress() as line:
        # As long as nothing takes long, nothing is said; what takes long need say nothing.
        line.set_stage("a map")
        assert lines() == {"progress: a map"}
        assert time.monotonic() - began >= 2.0
    with terminal.show_progress(quiet=True) as line:
        line.set_stage("nothing", 40.0)
        time.sleep(0.3)
    assert capsys.readouterr().err == ""


@pytest.mark.skipif(os.name == "nt", reason="there are no pseudo-terminals")
def test_terminal_counts_down_time_left(monkeypatch: pytest.MonkeyPatch) -> None:
    import pty

    reading, writing = pty.openpty()
    with os.fdopen(writing, "w") as stream:
        monkeypatch.setattr(sys, "stderr", stream)
        monkeypatch.setenv("TERM", "xterm")
        with terminal.show_progress() as line:
            line.set_stage("a solve", 40.4)
            time.sleep(1.2)
    shown = os.read(reading, 100_000).decode()
    os.close(reading)
    assert "a solve, about 40 s left" in shown
    assert re.search(r"a solve, about 3\d s left", shown)


def test_long_sweep_prints_time_left_and_saved_steps_at_interrupt(run: Run, tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text(SLOW)
    sweep = SOLVE.replace("solve", "sweep").replace('--load "1 mN"', '--from "1 mN" --to "9 mN"')
    done = run(f"{sweep} --steps 13 --folder kept")
    assert (done.returncode, done.stdout) == (app.INTERRUPTED, "")
    *lines, last = done.stderr.splitlines()
    # A slow machine says something before its first load is done.
    result = re.compile(r"progress: \d of 13: .*, about \d+ s left")
    assert any(map(result.fullmatch, lines)), lines
    assert last == (
        "roughcontact: interrupted; 3 of 13 loads saved in kept; the same command resumes"
    )
