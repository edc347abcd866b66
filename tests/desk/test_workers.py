"""Work in another process: what it tells, how it ends, and what it may take."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest

import roughcontact as rc
from roughcontact.analyses.tasks import from_text
from roughcontact.desk import workers
from roughcontact.desk.workers import JobResult, JobStage, Limits, WorkerPool
from roughcontact.errors import InputError, InsufficientMemoryError, RoughcontactError
from roughcontact.solvers.progress import Progress

pytestmark = pytest.mark.process

PATIENCE = 60.0
STEEL = {"young": "210 GPa", "poisson": "0.3"}
BALL = {"body": "sphere 1 mm", "points": "32", "size": "60 um", **STEEL}


@pytest.fixture(scope="module")
def bench() -> Iterator[WorkerPool]:
    bench = WorkerPool()
    yield bench
    bench.close()


# Jobs; the other process imports them from here.


def adding(tell: Callable[[Any], None], one: int, other: int) -> int:
    tell("adding")
    for number in (1, 2):
        tell(Progress(number, 2, None))
    return one + other


def refusing(tell: Callable[[Any], None]) -> None:
    raise InputError("must be less", argument="load")


def dying(tell: Callable[[Any], None]) -> None:
    os._exit(7)


def devouring(tell: Callable[[Any], None], size: int) -> int:
    return int(np.ones(size, np.uint8).size)


def lasting(tell: Callable[[Any], None], folder: Path | None = None) -> None:
    tell(str(os.getpid()))
    if folder is None:
        time.sleep(600)
        return
    from roughcontact._tools import files

    with files.atomic_write(folder / "whole.nc") as stream:
        stream.write(b"half")
        tell("writing")
        time.sleep(600)


def stubborn(tell: Callable[[Any], None]) -> None:
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    tell(str(os.getpid()))
    time.sleep(600)


def run_until_message(bench: WorkerPool, *work: Any, **more: Any) -> tuple[workers.Job, str]:
    """Start a job, and return it with its last message before it waits."""
    first = threading.Event()
    words: list[str] = []

    def record_message(stage: JobStage) -> None:
        words.append(str(stage.progress))
        if len(words) == len(work):
            first.set()

    job = bench.submit(*work, on_stage=record_message, **more)
    assert first.wait(PATIENCE)
    return job, words[0]


def ended(job: workers.Job) -> JobResult:
    end = job.wait(PATIENCE)
    assert end is not None
    return end


def test_job_reports_progress_and_result(bench: WorkerPool) -> None:
    stages: list[JobStage] = []
    ends: list[JobResult] = []
    end = ended(bench.submit(adding, 2, 3, on_stage=stages.append, ended=ends.append))
    assert end.value == 5
    assert ends == [end]
    assert end.error is None
    assert not end.canceled
    assert [stage.share for stage in stages] == [None, 0.0, 0.5]
    assert stages[0].progress == "adding"
    assert stages[0].remaining is stages[1].remaining is None
    assert stages[2].remaining == pytest.approx(stages[2].seconds)
    assert 0 <= stages[0].seconds <= stages[2].seconds <= end.seconds


def test_error_keeps_its_argument(bench: WorkerPool) -> None:
    error = ended(bench.submit(refusing)).error
    assert isinstance(error, InputError)
    assert error.argument == "load"
    assert str(error) == "load must be less"


def test_lost_process_is_reported(bench: WorkerPool) -> None:
    error = ended(bench.submit(dying)).error
    assert str(error) == "its process ended with status 7; is there enough memory?"


@pytest.mark.skipif(sys.platform != "linux", reason="limits of the address space are Linux's")
def test_job_exceeding_memory_limit_fails(bench: WorkerPool) -> None:
    limits = Limits(memory=2**28)
    assert ended(bench.submit(devouring, 2**24, limits=limits)).value == 2**24
    error = ended(bench.submit(devouring, 2**29, limits=limits)).error
    assert isinstance(error, InsufficientMemoryError)
    assert str(error) == "the memory of 0.25 GiB is exhausted; crop the map"


def test_job_exceeding_time_limit_fails(bench: WorkerPool) -> None:
    job = bench.submit(lasting, limits=Limits(seconds=0.05))
    error = ended(job).error
    assert isinstance(error, RoughcontactError)
    assert str(error) == "took longer than 0.05 s"


@pytest.mark.parametrize("work", [lasting, stubborn])
def test_canceled_job_ends(bench: WorkerPool, work: Any) -> None:
    job, number = run_until_message(bench, work)
    job.cancel()
    job.cancel()
    end = ended(job)
    assert end.canceled
    assert end.value is end.error is None
    assert not psutil.pid_exists(int(number))
    job.cancel()


def test_canceled_job_leaves_no_partial_file(bench: WorkerPool, tmp_path: Path) -> None:
    job, _ = run_until_message(bench, lasting, tmp_path, folders=(tmp_path,))
    assert list(tmp_path.iterdir()) != []
    job.cancel()
    assert ended(job).canceled
    assert list(tmp_path.iterdir()) == []


def test_close_ends_running_and_waiting_jobs() -> None:
    before = set(psutil.Process().children())
    bench = WorkerPool()
    job, number = run_until_message(bench, lasting)
    bench.close()
    assert ended(job).canceled
    assert not psutil.pid_exists(int(number))
    assert set(psutil.Process().children()) <= before


def test_error_in_callback_ends_job(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = WorkerPool(spare=False)

    def record_message(stage: JobStage) -> None:
        raise ValueError("not wanted")

    ignored: list[object] = []
    monkeypatch.setattr(threading, "excepthook", ignored.append)
    job = bench.submit(lasting, on_stage=record_message)
    assert job.wait(PATIENCE) is None
    bench.close()
    assert len(ignored) == 1


def test_request_in_worker_matches_local_run(bench: WorkerPool, tmp_path: Path) -> None:
    from roughcontact.request import run

    request = from_text(
        "sweep",
        None,
        {**BALL, "from": "0.5 N", "to": "1 N", "steps": "2", "output": str(tmp_path / "out.csv")},
    )
    stages: list[JobStage] = []
    job = bench.submit(
        workers.run_request,
        request,
        on_stage=stages.append,
        folders=workers.output_folders(request),
    )
    outcome = ended(job).value
    here = run.run_request(request, lambda text: None)
    for name in ("load", "contact_area", "max_pressure"):
        assert outcome.record()[name] == here.record()[name]
    assert outcome.written == (tmp_path / "out.csv",)
    assert any(isinstance(stage.progress, Progress) for stage in stages)
    assert {stage.share for stage in stages} <= {None, 0.0, 0.5}
    assert workers.output_folders(request) == [tmp_path]


def test_map_is_read_in_worker(bench: WorkerPool, tmp_path: Path) -> None:
    heights = np.random.default_rng(1).normal(0, 1e-6, (8, 9))
    np.save(tmp_path / "map.npy", heights)
    shapes: list[tuple[int, int]] = []
    read = workers.MapReader(bench)
    surface = read(tmp_path / "map.npy", shapes.append, None, None, "m", "8 um x 9 um", False)
    here = rc.read_surface(tmp_path / "map.npy", unit="m", size="8 um x 9 um")
    np.testing.assert_array_equal(surface.heights, here.heights)
    assert not surface.heights.flags.writeable
    assert surface.provenance == here.provenance
    assert shapes == [(8, 9)]
    with pytest.raises(InputError, match=r"map\.npy gives no unit"):
        read(tmp_path / "map.npy", shapes.append)
    found, channels = ended(
        bench.submit(workers.read_map, tmp_path / "map.npy", {"unit": "m", "size": "8 um x 9 um"})
    ).value
    assert found.shape == channels[0].shape == (8, 9)
    assert read.channels == {tmp_path / "map.npy": [item.name for item in channels if item.name]}


def test_checked_map_is_not_read_again(bench: WorkerPool, tmp_path: Path) -> None:
    path = tmp_path / "map.npz"
    rc.Surface(1e-7 * np.eye(8), (1e-6, 1e-6)).save(path)
    read = workers.MapReader(bench)
    ends: list[workers.JobResult] = []
    arrived = threading.Event()

    def end(result: workers.JobResult) -> None:
        ends.append(result)
        arrived.set()

    read.check(path, end)
    assert arrived.wait(60)
    assert ends[0].error is None
    here = rc.read_surface(path)
    path.unlink()
    surface = read(path, lambda shape: None, None, None, None, None, False, None)
    np.testing.assert_array_equal(surface.heights, here.heights)
    assert surface.provenance == here.provenance
    with pytest.raises(RoughcontactError):
        read(path, lambda shape: None)


def test_slow_file_raises_error(bench: WorkerPool, tmp_path: Path) -> None:
    np.save(tmp_path / "map.npy", np.ones((4, 4)))
    read = workers.MapReader(bench, Limits(seconds=0.0))
    with pytest.raises(RoughcontactError, match="took longer"):
        read(tmp_path / "map.npy", lambda shape: None)
