"""Executors of tasks: processes of this machine, or the workers of a Dask cluster.

`LocalExecutor`: ``concurrent.futures.ProcessPoolExecutor`` gives up all tasks if one process
ends; here only the task of that process fails, with `LostWorkerError`. The processes end within
a second of the parent process, however it ends.
"""

from __future__ import annotations

import gc
import logging
import math
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Executor, Future, ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar, cast
from weakref import WeakSet

from roughcontact._tools import processes
from roughcontact._tools.processes import ERROR, LostWorkerError, Worker
from roughcontact.errors import InputError
from roughcontact.halfspace.fft import default_workers
from roughcontact.units import count_noun

if TYPE_CHECKING:
    from distributed import Client, LocalCluster, Security


@dataclass(frozen=True)
class Engine:
    """Executor with its capacity, its state and its error messages."""

    executor: Executor  # Receives the tasks
    slots: Callable[[], int]  # Returns the current number of parallel tasks
    threads: int  # Cores per task
    shut_down: Callable[[], None]  # Cancels running tasks where the executor supports it
    is_remote: bool = False  # Whether workers may have another working folder or file system
    is_lost: Callable[[], bool] = lambda: False  # Whether no task can return any longer
    lost_task_text: Callable[[BaseException], str] = (
        str  # Returns the reason why a task has no result, from its exception
    )
    shared: Callable[[BaseException], bool] = lambda error: False
    dashboard: str = ""  # Address of the dashboard
    workers: str = ""  # Text of messages: whose workers are missing, and their command
    no_worker_timeout: float = math.inf  # Time without workers after which a run stops [s]


# Timeout of the connection to a scheduler, also after its loss [s].
_CONNECT_TIMEOUT = 30
# Time that a scheduler may be without workers [s].
_NO_WORKER_TIMEOUT = 600
_LARGE_GRAPH_OPTION = "distributed.admin.large-graph-warning-threshold"
# Lifetime of the cached number of worker threads [s].
_WORKER_INFO_AGE = 1.0
# Timeout for the end of terminated worker processes, and interval between polls [s].
_DYING, _LOOK = 2.0, 0.005


@contextmanager
def connect_cluster(scheduler: str | None, workers: int) -> Iterator[Engine]:
    """Connect to a Dask scheduler, or start a local cluster; yield its engine."""
    try:
        import dask
        from distributed import Client, Security
        from distributed.utils import silence_logging_cmgr

        # A client of a scheduler can execute any code: a local scheduler serves only this run.
        security = None if scheduler else Security.temporary()
    except ImportError:
        raise InputError(
            "dask needs Dask and cryptography; run pip install 'roughcontact[cluster]'",
            argument="engine",
        ) from None
    with ExitStack() as stack:
        # One sentence summarizes the log of Dask; results of subtasks may be large.
        stack.enter_context(silence_logging_cmgr(logging.CRITICAL))
        stack.enter_context(dask.config.set({_LARGE_GRAPH_OPTION: "1GiB"}))
        own = None if scheduler else stack.enter_context(_start_local_cluster(workers, security))
        address = own.scheduler_address if own is not None else scheduler
        # Collect clients that failed to connect now: their finalizer waits for a lock that the
        # start of a new client holds.
        gc.collect()
        try:
            # A default client would hold the locks of files that xarray writes in this process.
            client = stack.enter_context(
                Client(address, timeout=_CONNECT_TIMEOUT, security=security, set_as_default=False)
            )
        except (OSError, ValueError, TypeError, ImportError) as error:
            # Protocols with missing packages or arguments raise more than OSError.
            raise InputError(
                f"does not answer at {scheduler!r} ({' '.join(str(error).split())}); is it the "
                "address that dask scheduler has printed?",
                argument="scheduler",
                value=scheduler,
            ) from None
        executor = client.get_executor(pure=False)
        yield Engine(
            executor,
            _count_threads(client),
            1 if scheduler else max(1, default_workers() // workers),
            shut_down=partial(_shut_down, executor, own),
            is_remote=scheduler is not None,
            is_lost=lambda: _is_lost(client),
            lost_task_text=partial(_lost_task_text, client, f"the scheduler at {address}"),
            shared=_shared_a_worker,
            dashboard=client.dashboard_link or "",
            workers=f"of the scheduler at {address} (dask worker {address})",
            no_worker_timeout=_NO_WORKER_TIMEOUT,
        )


@contextmanager
def _start_local_cluster(workers: int, security: Security) -> Iterator[LocalCluster]:
    """Start a Dask cluster of processes on this machine."""
    from distributed import LocalCluster

    with ExitStack() as stack:
        # Worker processes ignore Ctrl-C; this process handles it and ends them.
        with processes.sigint_blocked():
            cluster = LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                processes=True,
                # Each contact checks its memory need before its solve.
                memory_limit=0,
                host="127.0.0.1",
                security=security,
                dashboard_address="127.0.0.1:0",
                silence_logs=logging.CRITICAL,
            )
            stack.enter_context(cluster)
        yield cluster


def _shut_down(executor: Executor, own: LocalCluster | None) -> None:
    """Reject further tasks, and stop local worker processes."""
    executor.shutdown(wait=False)
    # A list, because the cluster drops workers that have ended.
    nannies = [] if own is None else list(own.workers.values())
    for nanny in nannies:
        # Otherwise the nanny restarts its worker.
        nanny.close_gracefully()
        with suppress(OSError, TypeError):
            os.kill(nanny.pid, signal.SIGTERM)
    # Their unfinished files can be removed only after their end.
    last = time.monotonic() + _DYING
    while any(nanny.is_alive() for nanny in nannies) and time.monotonic() < last:
        time.sleep(_LOOK)


def _count_threads(client: Client) -> Callable[[], int]:
    """Return a function that counts the worker threads, cached for a second."""
    known = [0, -_WORKER_INFO_AGE]

    def slots() -> int:
        if time.monotonic() - known[1] > _WORKER_INFO_AGE and client.status == "running":
            # The loss of the scheduler is reported elsewhere.
            with suppress(OSError, AttributeError):
                known[:] = sum(client.nthreads().values()), time.monotonic()
        return int(known[0])

    return slots


def _is_lost(client: Client) -> bool:
    # A client connects again by itself for a while.
    return client.status not in ("running", "connecting")


def _shared_a_worker(error: BaseException) -> bool:
    """Return whether another task on the same workers may have caused the failure."""
    from distributed import KilledWorker

    return isinstance(error, KilledWorker)


def _lost_task_text(client: Client, scheduler: str, error: BaseException) -> str:
    """Return the reason why a contact has no result."""
    from distributed import KilledWorker

    if isinstance(error, KilledWorker):
        times = count_noun(error.allowed_failures + 1, "time")
        return (
            f"its worker ended {times}, the last one at {error.last_worker.address}; is there "
            "enough memory?"
        )
    if _is_lost(client):
        return f"{scheduler} does not answer any longer"
    if isinstance(error, CancelledError):
        return f"{scheduler} was lost during the run"
    return f"{type(error).__name__} ({' '.join(str(error).split())}) from {scheduler}"


P = ParamSpec("P")
T = TypeVar("T")


class LocalExecutor(Executor):
    """Executor of processes on this machine."""

    def __init__(self, workers: int) -> None:
        # Each thread waits for its process.
        self._threads = ThreadPoolExecutor(workers)
        self._own = threading.local()
        self._lock = threading.Lock()
        self._begun: list[Worker] = []
        self._futures: WeakSet[Future[Any]] = WeakSet()
        self._closed = False

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Submit a call of a module-level function to one of the processes."""
        with self._lock:
            future = self._threads.submit(self._call_in_process, partial(fn, *args, **kwargs))
            self._futures.add(future)
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes: after the tasks, or at once if canceled."""
        if cancel_futures:
            # The threads notify the waiters of futures canceled here; a ThreadPoolExecutor that
            # cancels its futures itself notifies no waiter (Python 3.11).
            with self._lock:
                waiting = list(self._futures)
            for future in waiting:
                future.cancel()
            self._end()
        self._threads.shutdown(wait=False)
        if wait:
            self._end_after_tasks()
        else:
            threading.Thread(target=self._end_after_tasks).start()

    def _end_after_tasks(self) -> None:
        self._threads.shutdown()
        self._end()

    def _end(self) -> None:
        with self._lock:
            self._closed = True
        processes.end_processes(worker.process for worker in self._begun)

    def _call_in_process(self, call: Callable[[], T]) -> T:
        """Execute a call in the process of this thread, and return the result."""
        worker = self._start_worker()
        try:
            worker.send(call)
            message = worker.receive()
        except LostWorkerError:
            del self._own.worker
            raise
        assert message is not None
        kind, result = message
        if kind == ERROR:
            raise result
        return cast("T", result)

    def _start_worker(self) -> Worker:
        if not hasattr(self._own, "worker"):
            with self._lock:
                if self._closed:
                    raise RuntimeError("the processes have been ended")
                self._own.worker = Worker()
                self._begun.append(self._own.worker)
        return cast("Worker", self._own.worker)


@contextmanager
def local_processes(workers: int) -> Iterator[Engine]:
    """Yield an engine of processes on this machine, and end them afterwards."""
    executor = LocalExecutor(workers)
    stop = partial(executor.shutdown, cancel_futures=True)
    try:
        yield Engine(executor, lambda: workers, max(1, default_workers() // workers), stop)
    finally:
        stop()
