"""Running a request: messages and files when it fails."""

from __future__ import annotations

import errno
import html
import json
import shlex
from pathlib import Path

import numpy as np
import pytest

from roughcontact.analyses.tasks import from_text
from roughcontact.cli import app
from roughcontact.report import phrases
from roughcontact.request.outcome import last_contact
from roughcontact.request.outputs import SavedSteps, UnfinishedError
from roughcontact.request.run import run_request
from roughcontact.solvers.progress import Progress

Capture = pytest.CaptureFixture[str]

BALL = (
    *shlex.split(
        "--body 'sphere 1 mm' --points 24x32 --size '60 um x 80 um' --young '210 GPa' "
        "--poisson 0.3 --yield-strength '1 GPa'"
    ),
)
FORM = {name[2:]: text for name, text in zip(BALL[::2], BALL[1::2], strict=True)}
SWEEP = ("sweep", *BALL, "--from", "0.1 N", "--to", "1 N", "--steps", "3")
HISTORY = ("history", *BALL, "--path", "1 N, 0 N")
STRESS = ("stress", *BALL, "--load", "0.5 N")


@pytest.mark.parametrize("command", [SWEEP, HISTORY, STRESS])
def test_unconverged_task_is_not_reported_as_solved(
    command: tuple[str, ...], tmp_path: Path, capsys: Capture
) -> None:
    report = tmp_path / "out.html"
    hard = ("--set", "max-iterations=1", "--set", "tolerance=1e-12", "--report", str(report))
    assert app.main([*command, *hard]) == app.NOT_CONVERGED
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert "not converged" in err
    assert "--set max-iterations" in err
    assert not report.exists()


@pytest.mark.parametrize("command", [SWEEP, HISTORY, STRESS])
def test_numbers_are_shown_where_a_file_cannot_be_written(
    command: tuple[str, ...], tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    suffix = "nc" if command is STRESS else "csv"
    output = tmp_path / f"out.{suffix}"
    for kind in ("result.Displayable", "analyses.stress.model.StressResult"):
        monkeypatch.setattr(f"roughcontact.{kind}.save", full)
    assert app.main([*command, "--output", str(output)]) == app.BAD_INPUT
    out, err = capsys.readouterr()
    assert "Solved: " in out
    assert f"out.{suffix} cannot be written (No space left on device)" in err
    assert err.count("\n") == 1


def test_interrupted_sweep_reports_steps_and_resumes(tmp_path: Path) -> None:
    folder = tmp_path / "steps"
    given = {**FORM, "from": "0.1 N", "to": "1 N", "steps": "3", "folder": str(folder)}
    request = from_text("sweep", None, given)

    def stop(at: Progress) -> None:
        if at.number == 3:
            raise KeyboardInterrupt

    with pytest.raises(UnfinishedError) as caught:
        run_request(request, lambda text: None, stop)
    kept = sorted(folder.glob("step-*.npz"))
    assert len(kept) == 2
    assert caught.value.written == kept
    assert caught.value.saved == SavedSteps(2, 3, "load", folder)
    seen: list[Progress] = []
    outcome = run_request(request, lambda text: None, seen.append)
    # The contact under the calibrated ceiling follows, one of one.
    assert {at.number for at in seen if not at.kept and at.count > 1} == {3}
    assert outcome.reused == 2
    assert len(outcome.record()["load"]) == 3


@pytest.mark.long
@pytest.mark.parametrize(
    ("task", "given", "words"),
    [
        ("solve", {"load": "1 N"}, "solving 24 × 32: "),
        ("sweep", {"from": "0.1 N", "to": "1 N", "steps": "2"}, "2 of 2: solving 24 × 32: "),
        ("history", {"path": "1 N, 0 N"}, "1 of 2: solving 24 × 32: "),
        (
            "solve",
            {"load": "2 N", "model": "elastoplastic", "increments": "2"},
            "iteration 1, residual",
        ),
    ],
)
def test_progress_is_formatted_as_text(task: str, given: dict[str, str], words: str) -> None:
    seen: list[Progress] = []
    outcome = run_request(from_text(task, None, {**FORM, **given}), lambda text: None, seen.append)
    assert outcome.converged
    assert any(words in phrases.progress_text(at) for at in seen)
    last = (outcome.request.task.last or last_contact)(outcome)
    assert {"load", "certificate"} <= last.keys()
    assert np.isfinite(last["load"])


@pytest.mark.long
@pytest.mark.parametrize(
    "more",
    [
        (),
        ("--set", "load-point=1 um, 0 um"),
        ("--model", "elastoplastic", "--set", "increments=1"),
        ("stress",),
    ],
    ids=["solve", "tilt", "volume", "stress"],
)
def test_nominal_pressure_matches_force_on_map(
    more: tuple[str, ...], tmp_path: Path, capsys: Capture
) -> None:
    task, words = ("stress", ()) if "stress" in more else ("solve", more)
    output = tmp_path / "out.nc"
    common = (task, *BALL, *words, "--output", str(output), "--json")
    # On 60 µm × 80 µm.
    assert app.main([*common, "--load", "0.24 N"]) == app.SOLVED
    force = json.loads(capsys.readouterr().out)
    assert app.main([*common, "--load", "50 MPa"]) == app.SOLVED
    pressure = json.loads(capsys.readouterr().out)
    assert pressure["load"] == pytest.approx(0.24, rel=1e-14)
    assert pressure["max_pressure"] == pytest.approx(force["max_pressure"], rel=1e-6)
    given = pressure["given_load"]
    assert given.pop("form") == "nominal pressure"
    assert given == pytest.approx({"value": 50e6, "unit": "Pa", "load": 0.24})
    assert force["given_load"] is None
    assert app.main([*common[:-1], "--load", "50 MPa", "--verbose"]) == app.SOLVED
    shown = " ".join(capsys.readouterr().out.split())
    assert "nominal pressure: 50 MPa on the whole map, 4800 µm², are 240 mN" in shown
    assert app.main(["verify", str(output)]) == app.SOLVED


@pytest.mark.usefixtures("quick")
@pytest.mark.long
def test_the_report_on_a_nominal_pressure_names_it_and_repeats_it(tmp_path: Path) -> None:
    path = tmp_path / "map.npy"
    y, x = np.mgrid[:24, :32]
    np.save(path, 0.02 * np.cos(y / 3) * np.cos(x / 4))
    report = tmp_path / "out.html"
    words = (
        *shlex.split(
            "--unit um --size '60 um x 80 um' --level none --crop 0:24,0:16 "
            "--counter-body 'cylinder 10 mm' --material 100Cr6 --load '20 MPa' --report"
        ),
        str(report),
    )
    assert app.main(["solve", str(path), *words, "--quiet"]) == app.SOLVED
    text = html.unescape(report.read_text(encoding="utf-8"))
    # The half of the map that is kept.
    assert "20 MPa on the whole map, 2400 µm², are 48 mN" in text
    assert "--load '20 MPa'" in text
    assert "Compared with the smooth bodies" in text
