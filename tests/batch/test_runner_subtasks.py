"""Comparisons in pieces: the bits of one process, and one failure for all of them."""

from __future__ import annotations

import pickle
import shutil
from concurrent.futures import Executor, Future
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from items import items_of_file, normalize_text
from roughcontact.batch import jobs, plan, project, runner
from roughcontact.batch.executors import Engine
from roughcontact.request import outputs
from roughcontact.request.request import Request

pytestmark = pytest.mark.process

HEAD = """\
folder = "results"
write = ["csv"]

[defaults]
unit = "um"
size = "0.1 mm"
material = "bearing steel"

[[contact]]
name = "one"
"""
COMPARED = HEAD + 'task = "compare"\nload = "20 MPa"\nsteps = 2\n'
PROBLEMS = {
    "groups": (COMPARED + 'groups = { a = ["r?.npy"], b = ["s0.npy", "s1.npy"] }\n', 5),
    "quarters and sampling": (
        COMPARED + 'files = ["r0.npy", "s0.npy"]\nquarters = true\nsampling = true\n',
        2,
    ),
    "a first loading": (COMPARED + 'files = ["r0.npy", "r1.npy"]\npreload = "2 GPa"\n', 2),
}


class Backwards(Executor):
    """Calls the tasks that were sent, the last first: only when an answer is requested."""

    def __init__(self) -> None:
        self.tasks: list[jobs.BatchTask] = []

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        self.tasks.append(args[0])
        future: Future[Any] = Future()
        sent = pickle.dumps((fn, args, kwargs))
        waiting.append((future, sent))
        return future


waiting: list[tuple[Future[Any], bytes]] = []


def run_waiting_tasks(slots: int) -> int:
    """Answer what was handed out, and say how many continue at a time."""
    while waiting:
        future, sent = waiting.pop()
        function, args, kwargs = pickle.loads(sent)
        future.set_result(pickle.loads(pickle.dumps(function(*args, **kwargs))))
    return slots


def write_subtask_project(folder: Path, text: str, points: int = 32) -> Path:
    folder.mkdir(parents=True)
    y, x = np.mgrid[:points, :points] / points
    for number, name in enumerate(("r0", "r1", "r2", "s0", "s1")):
        noise = np.random.default_rng(number).standard_normal(y.shape)
        np.save(folder / f"{name}.npy", np.cos(7 * y + number) * np.cos(5 * x) + 0.03 * noise)
    (folder / "project.toml").write_text(text, encoding="utf-8")
    return folder / "project.toml"


def bits(folder: Path) -> dict[str, dict[str, str]]:
    return {
        file.name: {
            name: normalize_text(text, folder.resolve())
            for name, text in items_of_file(file).items()
        }
        for file in sorted((folder / "results").iterdir())
        if file.is_file()
    }


def run(
    path: Path, slots: int = 10
) -> tuple[list[plan.ContactReport], list[jobs.BatchTask], list[str]]:
    far, said = Backwards(), []
    engine = Engine(far, partial(run_waiting_tasks, slots), 1, far.shutdown)
    with pytest.MonkeyPatch.context() as patch:
        # Requests are answered at the next poll.
        patch.setattr(runner, "_POLL_SECONDS", 0.0)
        reports = runner.run_project(
            project.read_project(path), lambda report: None, engine, say=said.append
        )
    return reports, far.tasks, said


@pytest.mark.parametrize("problem", PROBLEMS)
def test_subtasks_in_any_order_give_identical_result(
    problem: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text, count = PROBLEMS[problem]
    path = write_subtask_project(tmp_path / "apart", text, 64)
    reports, tasks, said = run(path)
    assert [report.state for report in reports] == [plan.SOLVED]
    words = [task.piece for task in tasks]
    assert words == [*tasks[0].parts[0].entry.request.subtask_ids(), ""]
    assert len(words) == count + 1
    assert said[-1] == f"{count} of {count} subtasks of one done"
    alone = write_subtask_project(tmp_path / "whole", text, 64)
    monkeypatch.setattr(Request, "subtask_ids", lambda request: ())
    reports, tasks, _ = run(alone)
    assert [report.state for report in reports] == [plan.SOLVED]
    assert [task.piece for task in tasks] == [""]
    whole, apart = bits(alone.parent), bits(path.parent)
    assert whole.keys() == apart.keys()
    assert [name for name in whole if whole[name] != apart[name]] == []
    assert len(whole) == 2
    # Complete subtasks are not solved again.
    monkeypatch.undo()
    reports, tasks, _ = run(path)
    assert ([report.state for report in reports], tasks) == ([plan.KEPT], [])


def test_each_subtask_reads_one_map(tmp_path: Path) -> None:
    text, _ = PROBLEMS["groups"]
    path = write_subtask_project(tmp_path / "here", text)
    _, tasks, _ = run(path)
    names = [[file.name for file in task.inputs] for task in tasks]
    assert names == [["r0.npy"], ["r1.npy"], ["r2.npy"], ["s0.npy"], ["s1.npy"], []]


def test_failed_subtask_fails_contact_once(tmp_path: Path) -> None:
    more = '\n[[contact]]\nname = "two"\nfile = "r2.npy"\nload = "1 N"\n'
    text = PROBLEMS["groups"][0].replace('"r?.npy"', '"r0.npy", "r1.npy"') + more
    path = write_subtask_project(tmp_path / "here", text)
    for name in ("r0.npy", "s0.npy"):
        path.with_name(name).rename(path.with_name(f"kept-{name}"))
    (bad, good), tasks, said = run(path, slots=1)
    assert (bad.state, good.state) == (plan.FAILED, plan.SOLVED)
    # Each of them is reported; the whole is not started.
    assert all(bad.reason.count(name) == 1 for name in ("r0.npy", "s0.npy"))
    assert "2 of 4 subtasks of one done" in said
    assert [task.piece for task in tasks] == ["0", "1", "2", "3", ""]
    assert tasks[-1].parts[0].entry.name == "two"
    for name in ("r0.npy", "s0.npy"):
        path.with_name(f"kept-{name}").rename(path.with_name(name))
    reports, tasks, _ = run(path)
    assert [report.state for report in reports] == [plan.SOLVED, plan.KEPT]
    assert [task.piece for task in tasks] == ["0", "1", "2", "3", ""]


def test_map_changed_during_run_is_excluded(tmp_path: Path) -> None:
    path = write_subtask_project(tmp_path / "here", PROBLEMS["groups"][0])
    other = np.load(path.with_name("r0.npy"))[::-1]

    class Changing(Backwards):
        def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
            if args[0].piece == "1":
                np.save(path.with_name("r1.npy"), other)
            return super().submit(fn, *args, **kwargs)

    far = Changing()
    engine = Engine(far, partial(run_waiting_tasks, 10), 1, far.shutdown)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(runner, "_POLL_SECONDS", 0.0)
        (report,) = runner.run_project(project.read_project(path), lambda report: None, engine)
    assert report.state == plan.FAILED
    assert "r1.npy changed while the project ran; run it again" in report.reason
    (again,), _, _ = run(path)
    assert again.state == plan.SOLVED
    found = bits(path.parent)
    shutil.rmtree(path.parent / "results")
    run(path)
    assert found == bits(path.parent)


def test_maps_of_one_content_keep_their_names(tmp_path: Path) -> None:
    text = PROBLEMS["groups"][0].replace('"r?.npy"', '"r0.npy", "r1.npy"')
    path = write_subtask_project(tmp_path / "here", text)
    path.with_name("r1.npy").write_bytes(path.with_name("r0.npy").read_bytes())
    (report,), tasks, _ = run(path)
    assert report.state == plan.SOLVED
    assert [task.piece for task in tasks] == ["0", "1", "2", "3", ""]
    names = [one["name"] for group in report.summary["groups"] for one in group["maps"]]
    assert names == ["r0.npy", "r1.npy", "s0.npy", "s1.npy"]


def test_interrupted_comparison_is_solved_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_subtask_project(tmp_path / "here", PROBLEMS["groups"][0])

    def interrupt_at_second(text: str) -> None:
        if text.startswith("2 of 5"):
            raise KeyboardInterrupt

    far = Backwards()
    with monkeypatch.context() as patch:
        patch.setattr(runner, "_POLL_SECONDS", 0.0)
        engine = Engine(far, partial(run_waiting_tasks, 1), 1, far.shutdown)
        with pytest.raises(outputs.UnfinishedError) as caught:
            runner.run_project(
                project.read_project(path), lambda report: None, engine, say=interrupt_at_second
            )
    assert caught.value.written == []
    waiting.clear()
    _, tasks, _ = run(path)
    assert [task.piece for task in tasks] == ["0", "1", "2", "3", "4", ""]


def test_subtasks_are_shared_between_processes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_subtask_project(tmp_path / "here", PROBLEMS["groups"][0])
    counts = []
    monkeypatch.setattr(runner, "default_workers", lambda: 4)
    monkeypatch.setattr(
        runner, "local_processes", lambda count: pytest.fail(str(counts.append(count)))
    )
    with pytest.raises(pytest.fail.Exception):
        runner.run_project(project.read_project(path), lambda report: None)
    assert counts == [4]
