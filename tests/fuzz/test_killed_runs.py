"""A small part of `tests/fuzz/killed_runs.py`, and that its judge sees what is wrong."""

import subprocess
import sys
from pathlib import Path
from signal import SIGINT, SIGKILL, SIGTERM

import pytest

import killed_runs
from killed_runs import ENDED, RESUMED, WRONG, Case, Command, Kill, Outcome, Reference

pytestmark = pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="needs /proc")


@pytest.mark.process
def test_killed_sweep_resumes_to_identical_result(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write = killed_runs.inputs
    monkeypatch.setattr(killed_runs, "inputs", lambda folder: write(folder, 64))
    whole = killed_runs.reference("sweep", tmp_path / "whole")
    assert "kept/step-0010.npz" in whole.files
    kill = Kill(0, "sweep", SIGTERM, False, 0.0, 0.0, steps=4)
    outcome = killed_runs.killed(Case(kill, tmp_path / "killed", whole))
    assert outcome.verdict in (RESUMED, ENDED), str(outcome)
    assert outcome.kept >= 4


# A program that writes a file a second after it has begun.
FAKE = """
import os, pathlib, signal, subprocess, sys, time

mode = sys.argv[1]
out = pathlib.Path("out.txt")
again = pathlib.Path("state").exists()
pathlib.Path("state").write_text("")

def stop(number, frame):
    if mode == "deaf":
        return
    if mode == "leaves a file":
        pathlib.Path(".out.part").write_text("")
    if mode == "leaves one outside":
        pathlib.Path(os.environ["TMPDIR"], "more").write_text("")
    if mode == "torn":
        out.write_text("who")
    if mode == "says too much":
        print("Traceback:\\n roughcontact/cli.py\\nKeyboardInterrupt", file=sys.stderr)
    elif mode != "says nothing":
        print("roughcontact: interrupted", file=sys.stderr)
    sys.stderr.flush()
    os._exit(0 if mode == "is content" else 128 + number)

signal.signal(signal.SIGTERM, stop)
signal.signal(signal.SIGINT, stop)
if mode == "has children":
    sleep = "import time; time.sleep(30)"
    subprocess.Popen([sys.executable, "-c", sleep], stdout=-3, stderr=-3)
if not again:
    for _ in range(200):
        time.sleep(0.01)
out.write_text("other" if mode == "differs" and again else "whole")
if mode == "leaves more" and again:
    pathlib.Path("out.part").write_text("")
sys.exit(3 if mode == "fails" and again else 0)
"""


def attempt(mode: str, number: int, folder: Path, monkeypatch: pytest.MonkeyPatch) -> Outcome:
    """Return the outcome of a kill of the program above in one of its modes."""

    def started(words: str, place: Path) -> "subprocess.Popen[bytes]":
        (place / "tmp").mkdir(exist_ok=True)
        return subprocess.Popen(
            [sys.executable, "-c", FAKE, words],
            cwd=place,
            start_new_session=True,
            env={"TMPDIR": str(place / "tmp")},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )

    monkeypatch.setattr(killed_runs, "started", started)
    monkeypatch.setattr(killed_runs, "inputs", lambda place: place.mkdir())
    monkeypatch.setattr(killed_runs, "ENDS", 1.0)
    monkeypatch.setitem(killed_runs.COMMANDS, "fake", Command(mode, ("out.txt",), "state"))
    whole = Reference({"out.txt": {"": "whole"}, "state": {"": ""}}, 1.0, 0.1)
    return killed_runs.killed(Case(Kill(1, "fake", number, False, 0.6, 0.0), folder, whole))


@pytest.mark.process
@pytest.mark.parametrize("number", [SIGTERM, SIGINT, SIGKILL])
def test_stopped_run_resumes(number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    outcome = attempt("", number, tmp_path / "here", monkeypatch)
    assert (outcome.verdict, outcome.words, outcome.kept) == (RESUMED, "", 1)


@pytest.mark.process
@pytest.mark.parametrize(
    ("mode", "words"),
    [
        ("deaf", "had not ended after 1 s"),
        ("leaves a file", "killed, .out.part is left"),
        ("leaves one outside", "killed, tmp/more is left"),
        ("torn", "killed, out.txt holds something else"),
        ("says too much", "a traceback, 'KeyboardInterrupt' at its end"),
        ("says nothing", "said nothing"),
        ("has children", "1 children were alive 1 s later"),
        ("differs", "run again, out.txt holds something else"),
        ("leaves more", "run again, out.part left over"),
        ("fails", "run again, it ends with status 3"),
    ],
)
def test_the_judge_sees_it(
    mode: str, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    outcome = attempt(mode, SIGTERM, tmp_path / "here", monkeypatch)
    assert outcome.verdict == WRONG
    assert words in outcome.words
