"""Signals that ask the program to end do what Ctrl-C does, and leave nothing half written."""

import json
import os
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.cli import app

pytestmark = [
    pytest.mark.process,
    pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="no such signals here"),
]

STEEL = ["--material", "bearing steel", "--quiet"]
MAP = ["rough.npy", "--unit", "m", "--size", "32 um x 32 um", *STEEL]
BALL = [
    *shlex.split("--body 'sphere 10 mm' --points 16 --size '0.4 mm'"),
    *STEEL,
    *shlex.split("--model elastoplastic --load '60 N' --set increments=2 --set tolerance=1e-3"),
]

# The command, the file that is being written when the signal comes, and what stays.
CASES = {
    "solve": (
        ["solve", *MAP, "--load", "1 mN", "--output", "out.nc", "--output", "out.csv"],
        "out.csv",
        ["out.nc"],
    ),
    "sweep": (
        ["sweep", *MAP, "--from", "1 mN", "--to", "9 mN", "--steps", "3", "--folder", "kept"],
        "kept/step-0002.npz",
        ["kept/step-0001.npz"],
    ),
    "history": (
        [
            "history",
            *MAP,
            *shlex.split("--path '1 mN, 0 N' --output out.csv --indented-surface out.x3p"),
        ],
        "out.x3p",
        ["out.csv"],
    ),
    "volume": (["solve", *BALL, "--folder", "kept"], "kept/step-0002.nc", ["kept/step-0001.nc"]),
}

TOLD = {
    "sweep": "1 of 3 loads saved in kept; the same command resumes",
    "volume": "1 of 2 loads saved in kept; the same command resumes",
}

# Sends the signal, twice, while a file is written that is whole but has no name yet.
CHILD = """
import json, os, signal, sys
from roughcontact._tools import files
from roughcontact.cli import app

command, wanted, number, ignored = json.loads(sys.argv[1])
if ignored:
    signal.signal(number, signal.SIG_IGN)
replace = os.replace

def stopped(source, target):
    if str(target) == wanted:
        os.kill(os.getpid(), number)
        os.kill(os.getpid(), number)
    replace(source, target)

files.os.replace = stopped
status = app.main(command)
assert signal.getsignal(number) == (signal.SIG_IGN if ignored else signal.SIG_DFL)
sys.exit(status)
"""


def run_until_signal(
    folder: Path, name: str, number: int, ignored: bool = False
) -> tuple[int, str]:
    """Run a command that gets a signal, and return its status and what it said."""
    noise = np.random.default_rng(3).standard_normal((32, 32))
    np.save(folder / "rough.npy", 1e-8 * noise)
    command, wanted, _ = CASES[name]
    ran = subprocess.run(
        [sys.executable, "-c", CHILD, json.dumps((command, wanted, number, ignored))],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(Path(rc.__file__).parents[1])},
        capture_output=True,
        text=True,
    )
    assert ran.stdout == ""
    return ran.returncode, ran.stderr


def left(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [name if name == "sweep" else pytest.param(name, marks=pytest.mark.process) for name in CASES],
)
def test_sigterm_keeps_complete_files(name: str, tmp_path: Path) -> None:
    status, err = run_until_signal(tmp_path, name, signal.SIGTERM)
    kept = CASES[name][2]
    assert (status, err) == (
        128 + signal.SIGTERM,
        f"roughcontact: interrupted; {TOLD.get(name, f'only {kept[0]} was written')}\n",
    )
    records = {"sweep": {"kept/sweep.json"}, "volume": {"kept/volume.json"}}.get(name, set())
    assert left(tmp_path) == {"rough.npy", *kept, *records}


def test_closed_terminal_keeps_complete_files(tmp_path: Path) -> None:
    status, err = run_until_signal(tmp_path, "sweep", signal.SIGHUP)
    assert (status, err.count("\n")) == (128 + signal.SIGHUP, 1)
    assert left(tmp_path) == {"rough.npy", "kept/sweep.json", "kept/step-0001.npz"}


def test_a_signal_that_is_to_be_ignored_is_ignored(tmp_path: Path) -> None:
    assert run_until_signal(tmp_path, "sweep", signal.SIGHUP, ignored=True) == (app.SOLVED, "")
    assert "kept/step-0003.npz" in left(tmp_path)
