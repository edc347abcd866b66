"""A contact on a worker, which sees the files of the run or not."""

from __future__ import annotations

import contextlib
import threading
from concurrent.futures import Executor, Future
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from fleets import items, write_project
from roughcontact.batch import jobs, plan, project, runner
from roughcontact.batch.executors import Engine
from roughcontact.batch.plan import FAILED, SOLVED


class Here(Executor):
    """Calls at once."""

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        future.set_result(fn(*args, **kwargs))
        return future


class Elsewhere(Here):
    """Calls at once, in another working folder."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        with contextlib.chdir(self._folder):
            return super().submit(fn, *args, **kwargs)


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
def test_worker_in_another_folder_gives_the_same_bits(
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
    for folder, executor in ((here, Here()), (there, Elsewhere(tmp_path))):
        # Paths as they are given on a command line.
        monkeypatch.chdir(folder)
        engine = Engine(executor, lambda: 1, 1, executor.shutdown, is_remote=folder is there)
        for name, count in (("project.toml", 4), ("drawn.toml", 1)):
            entries = project.read_project(name)
            reports = runner.run_project(entries, lambda report: None, engine)
            assert states(reports) == [SOLVED] * count
    result, same = items(here), items(there)
    assert result.keys() == same.keys()
    assert len([name for name in result if name.endswith(".svg")]) > 3
    assert len(result) > 15
    assert [name for name in result if result[name] != same[name]] == []


def test_worker_without_the_files_of_the_run_fails_with_advice(
    task: jobs.BatchTask, tmp_path: Path
) -> None:
    before = Path.cwd()
    (tmp_path / "mark").touch()
    for folder, mark in ((tmp_path, "absent"), (tmp_path / "absent", "mark")):
        other = replace(task, folder=folder, mark=Path(mark))
        (report,) = jobs.run_task(other).reports.values()
        assert report.reason == (
            f"its worker does not see the files in {folder}; put the project on a file system "
            "that all workers see under the same path, and start the run there"
        )
        assert Path.cwd() == before
    assert not task.parts[0].entry.summary.exists()
    assert (
        jobs.run_task(replace(task, folder=tmp_path, mark=Path("mark"))).reports[0].state == SOLVED
    )


def test_tasks_of_other_runs_wait_for_the_working_folder(tmp_path: Path) -> None:
    before, order, entered = Path.cwd(), [], threading.Event()
    folders = tmp_path.resolve() / "a", tmp_path.resolve() / "b"
    for folder in folders:
        folder.mkdir()

    def work(folder: Path) -> None:
        with jobs._working_folder(folder):
            entered.set()
            order.append(Path.cwd())

    other = threading.Thread(target=work, args=folders[1:])
    with jobs._working_folder(folders[0]):
        # A task of the same run does not wait.
        work(folders[0])
        entered.clear()
        other.start()
        assert not entered.wait(0.05)
        assert Path.cwd() == folders[0]
    other.join()
    assert order == [*folders]
    assert Path.cwd() == before


@pytest.fixture
def task(tmp_path: Path) -> jobs.BatchTask:
    """One contact with the checksums of its files."""
    entry = project.read_project(write_project(tmp_path, 1))[0]
    entry.summary.parent.mkdir()
    sums = {path: str(plan.checksum_if_readable(path)) for path in entry.request.inputs}
    part = jobs.SubtaskRequest(0, entry, plan.request_digest(entry))
    return jobs.BatchTask((part,), 1, sums)


def test_a_file_of_other_content_is_another_file(task: jobs.BatchTask) -> None:
    (path,) = task.parts[0].entry.request.inputs
    content = path.read_bytes()
    path.write_bytes(content[:-1] + b"\0")
    assert jobs.run_task(task).reports[0].reason == (
        f"{path} changed while the project ran; run it again"
    )
    assert not task.parts[0].entry.summary.exists()
    path.write_bytes(content)
    assert jobs.run_task(task).reports[0].state == SOLVED


def test_a_worker_of_another_version_refuses(task: jobs.BatchTask) -> None:
    other = replace(task, version="0.0.1")
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
