"""Processes that live on from task to task, and of which one may die alone."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from concurrent.futures import wait

import pytest

from fleets import ended, wait_for
from roughcontact.batch.executors import LocalExecutor, LostWorkerError
from roughcontact.errors import InputError

pytestmark = pytest.mark.process


@pytest.fixture
def pool() -> Iterator[LocalExecutor]:
    executor = LocalExecutor(2)
    yield executor
    executor.shutdown(cancel_futures=True)


def test_processes_live_on(pool: LocalExecutor) -> None:
    found = [pool.submit(os.getpid) for _ in range(20)]
    assert os.getpid() not in {future.result() for future in found}
    assert len({future.result() for future in found}) <= 2


def test_lost_process_fails_its_task_only(pool: LocalExecutor) -> None:
    before = [pool.submit(abs, -number) for number in range(4)]
    dead = pool.submit(os._exit, 7)
    after = [pool.submit(abs, -number) for number in range(8)]
    with pytest.raises(LostWorkerError, match="status 7; is there enough memory"):
        dead.result()
    assert [future.result() for future in (*before, *after)] == [0, 1, 2, 3, *range(8)]


def test_one_that_is_killed_is_begun_again(pool: LocalExecutor) -> None:
    first = pool.submit(os.getpid).result()
    os.kill(first, signal.SIGKILL)
    # Waiting tasks receive it with the next task.
    found = [pool.submit(os.getpid) for _ in range(8)]
    lost = [future for future in found if future.exception() is not None]
    assert len(lost) <= 1
    assert first not in {future.result() for future in found if future not in lost}


def test_an_error_of_a_task_is_raised_with_its_argument(pool: LocalExecutor) -> None:
    from roughcontact.errors import require_positive

    with pytest.raises(InputError, match="load must be positive") as caught:
        pool.submit(require_positive, load=-1.0).result()
    assert caught.value.argument == "load"


def test_shutdown_is_fast_and_fails_running_tasks() -> None:
    pool = LocalExecutor(2)
    pids = {pool.submit(os.getpid).result() for _ in range(4)}
    # Enough that those that wait cannot all be taken up and failed while the pool is being closed.
    tasks = [pool.submit(time.sleep, 60) for _ in range(1000)]
    assert wait_for(lambda: all(task.running() for task in tasks[:2]))
    begun = time.monotonic()
    pool.shutdown(cancel_futures=True)
    assert time.monotonic() - begun < 5
    assert wait_for(lambda: all(map(ended, pids)), 1.0)
    assert wait(tasks, 0).not_done == set()
    # The second process may not have been begun yet.
    assert all(isinstance(task.exception(), LostWorkerError | RuntimeError) for task in tasks[:2])
    assert all(task.cancelled() for task in tasks[2:])


def test_an_end_after_the_tasks_lets_them_end() -> None:
    with LocalExecutor(1) as pool:
        tasks = [pool.submit(abs, -number) for number in range(3)]
    assert [task.result() for task in tasks] == [0, 1, 2]


def test_shutdown_without_waiting_returns_while_tasks_run() -> None:
    pool = LocalExecutor(1)
    pid = pool.submit(os.getpid).result()
    tasks = [pool.submit(time.sleep, 0.3), pool.submit(abs, -3)]
    begun = time.monotonic()
    pool.shutdown(wait=False)
    assert time.monotonic() - begun < 0.2
    with pytest.raises(RuntimeError, match="after shutdown"):
        pool.submit(abs, 1)
    assert [task.result() for task in tasks] == [None, 3]
    assert wait_for(lambda: ended(pid), 5.0)
