"""A contact on a worker that sees its files, or has them sent."""

from __future__ import annotations

from concurrent.futures import Executor, Future
from pathlib import Path
from typing import Any

import pytest

from fleets import items, write_project
from roughcontact.batch import jobs, plan, project, runner
from roughcontact.batch.executors import Engine
from roughcontact.batch.plan import FAILED, KEPT, SOLVED


class Here(Executor):
    """Calls at once."""

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


class Elsewhere(Here):
    """Calls at once, on a machine of another root: what lies in one folder is not there."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self._folder, self._patch = folder.resolve(), monkeypatch
        self.tasks: list[jobs.BatchTask] = []

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        self.tasks.append(args[0])
        hidden = self._folder.with_name("hidden")
        self._folder.rename(hidden)
        try:
            return super().submit(fn, *args, **kwargs)
        finally:
            # Whatever was written here is lost.
            assert not self._folder.exists()
            hidden.rename(self._folder)


GROUPS = """
[[contact]]
name = "compared"
task = "compare"
load = "1 MPa"
groups = { a = ["maps/r*.npy"], b = ["maps/rough.npy", "maps/rough.npy"] }
"""


def states(reports: list[plan.ContactReport]) -> list[str]:
    return [report.state for report in reports]


@pytest.mark.slow
@pytest.mark.process
def test_files_that_are_sent_give_the_same_bits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here, there = tmp_path / "here", tmp_path / "there"
    for folder in (here, there):
        text = write_project(folder, 2, GROUPS).read_text(encoding="utf-8")
        # One contact that is drawn, in several files.
        text = text[: text.index('[[contact]]\nname = "curve"')]
        for old, new in (('"results"', '"drawn"'), ('"nc", "csv"', '"svg"'), ('"1 mN", ', "")):
            assert old in text
            text = text.replace(old, new)
        (folder / "drawn.toml").write_text(text, encoding="utf-8")
    # Paths as they are given on a command line.
    monkeypatch.chdir(here)
    near = Here()
    engine = Engine(near, lambda: 1, 1, near.shutdown)
    for name, count in (("project.toml", 4), ("drawn.toml", 1)):
        entries = project.read_project(name)
        assert states(runner.run_project(entries, lambda report: None, engine)) == [SOLVED] * count
    monkeypatch.chdir(there)
    far = Elsewhere(there, monkeypatch)
    engine = Engine(far, lambda: 1, 1, far.shutdown, is_remote=True)
    (drawn,), entries = project.read_project("drawn.toml"), project.read_project("project.toml")
    assert states(runner.run_project([drawn], lambda report: None, engine)) == [SOLVED]
    far.tasks.clear()
    assert states(runner.run_project(entries, lambda report: None, engine)) == [SOLVED] * 4
    told, same = items(here), items(there)
    assert told.keys() == same.keys()
    assert len([name for name in told if name.endswith(".svg")]) > 3
    assert len(told) > 15
    assert [name for name in told if told[name] != same[name]] == []
    # What waits already is asked for its files; then they go along at once.
    # The comparison needs no file where all of its maps are pressed.
    ways = [task.transfer for task in far.tasks if not task.known_results]
    sent = [bool(way.content) for way in ways if way is not None]
    assert sent == sorted(sent)
    assert sent.count(False) == 2
    assert states(runner.run_project(entries, lambda report: None, engine)) == [KEPT] * 4


def test_steps_of_sweep_are_sent_and_returned(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_project(tmp_path / "there", 1)
    far = Elsewhere(tmp_path / "there", monkeypatch)
    engine = Engine(far, lambda: 1, 1, far.shutdown, is_remote=True)
    entries = project.read_project(path)[1:]
    runner.run_project(entries, lambda report: None, engine)
    steps = tmp_path / "there" / "kept" / "curve"
    first = steps / "step-0001.npz"
    stamp, before = first.stat().st_mtime_ns, first.read_bytes()
    (steps / "step-0002.npz").unlink()
    (tmp_path / "there" / "results" / "curve.csv").unlink()
    assert states(runner.run_project(entries, lambda report: None, engine)) == [SOLVED]
    assert (first.stat().st_mtime_ns, first.read_bytes()) == (stamp, before)
    assert (steps / "step-0002.npz").exists()


def test_too_large_transfer_fails_with_advice(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_project(tmp_path / "there", 1)
    far = Elsewhere(tmp_path / "there", monkeypatch)
    engine = Engine(far, lambda: 1, 1, far.shutdown, is_remote=True)
    monkeypatch.setattr(jobs, "MAX_TRANSFER_BYTES", 1000)
    (report,) = runner.run_project(project.read_project(path)[:1], lambda report: None, engine)
    assert report.state == FAILED
    assert "put the project where all workers see it" in report.reason
    monkeypatch.setattr(jobs, "MAX_TRANSFER_BYTES", 2**15)
    (report,) = runner.run_project(project.read_project(path)[:1], lambda report: None, engine)
    assert "the files that it leaves have" in report.reason


@pytest.fixture
def task(tmp_path: Path) -> jobs.BatchTask:
    """One contact, and what a worker of another machine has to know of it."""
    entry = project.read_project(write_project(tmp_path, 1))[0]
    entry.summary.parent.mkdir()
    (tmp_path / "mark").touch()
    sums = {path: str(plan.checksum_if_readable(path)) for path in entry.request.inputs}
    places = tuple(str(path) for _, path in entry.request.places)
    part = jobs.SubtaskRequest(0, entry, plan.request_digest(entry), places)
    return jobs.BatchTask((part,), 1, jobs.FileTransfer(tmp_path / "mark", sums))


def test_a_file_of_other_content_is_another_file(task: jobs.BatchTask) -> None:
    (path,) = task.parts[0].entry.request.inputs
    content = path.read_bytes()
    path.write_bytes(content[:-1] + b"\0")
    assert task.transfer is not None
    assert jobs.run_task(task).lacking == (path,)
    sent = jobs.FileTransfer(
        task.transfer.mark, task.transfer.sums, (), {path: content[:-1] + b"\1"}
    )
    answer = jobs.run_task(jobs.BatchTask(task.parts, 1, sent))
    assert "changed while the project ran; run it again" in answer.reports[0].reason
    path.write_bytes(content)
    assert jobs.run_task(task).reports[0].state == SOLVED


def test_a_worker_of_another_version_refuses(task: jobs.BatchTask) -> None:
    other = jobs.BatchTask(task.parts, 1, None, "0.0.1")
    assert "not 0.0.1; install the same" in jobs.run_task(other).reports[0].reason
    assert not task.parts[0].entry.summary.exists()


def test_a_contact_keeps_to_its_cores(
    task: jobs.BatchTask, monkeypatch: pytest.MonkeyPatch
) -> None:
    from roughcontact.halfspace import fft

    monkeypatch.setattr(fft.os, "sched_getaffinity", lambda _: set(range(8)), raising=False)
    monkeypatch.setattr(fft.os, "cpu_count", lambda: 8)
    assert fft.default_workers() == 8
    with fft.limit_threads(3):
        with fft.limit_threads(2):
            assert fft.default_workers() == 2
        assert fft.Workspace().workers == 3
    with fft.limit_threads(99):
        assert fft.default_workers() == 8
    assert fft.default_workers() == 8


class Nobody(Executor):
    """Takes calls that no one answers."""

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        return Future()


def test_workers_are_not_waited_for_without_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_project(tmp_path, 3)
    monkeypatch.setattr(runner, "_POLL_SECONDS", 0.02)
    monkeypatch.setattr(runner, "_WORKER_LOSS_SECONDS", 0.05)
    executor, warned = Nobody(), []
    engine = Engine(
        executor,
        lambda: 0,
        1,
        executor.shutdown,
        workers="of tcp://head:8786",
        no_worker_timeout=0.3,
    )
    reports = runner.run_project(
        project.read_project(path), lambda report: None, engine, warn=warned.append
    )
    assert {report.reason for report in reports} == {
        "there were no workers of tcp://head:8786 for 0.005 min"
    }
    assert states(reports) == [FAILED] * 4
    assert warned == ["waiting for workers of tcp://head:8786, 0.005 min at most"]
