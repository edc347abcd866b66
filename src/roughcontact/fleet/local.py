"""An executor of processes that live on from task to task, and of which one may die alone."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from typing import Any, ParamSpec, TypeVar
from weakref import WeakSet

from roughcontact import processes as own
from roughcontact.fleet.engine import Engine
from roughcontact.halfspace.fft import default_workers

P = ParamSpec("P")
T = TypeVar("T")


class LostWorkerError(Exception):
    """A process ended in the midst of a task; the sentence says how."""


class LocalExecutor(Executor):
    """Processes of this machine.

    Parameters
    ----------
    workers : int
        How many there are. Each is begun with its first task, and begun again for the next one
        where it has died.

    Notes
    -----
    ``concurrent.futures.ProcessPoolExecutor`` gives up all tasks where one process dies; here that
    task alone fails, with `LostWorkerError`. The processes end within a second of this one,
    however it ends.
    """

    def __init__(self, workers: int) -> None:
        # Each thread waits for a process of its own.
        self._threads = ThreadPoolExecutor(workers)
        self._own = threading.local()
        self._lock = threading.Lock()
        self._begun: list[SpawnProcess] = []
        self._futures: WeakSet[Future[Any]] = WeakSet()
        self._closed = False

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Have a function of a module called in one of the processes."""
        with self._lock:
            future = self._threads.submit(self._called, (fn, args, kwargs))
            self._futures.add(future)
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes, after the tasks, or where these are cancelled at once."""
        if cancel_futures:
            # The threads come upon those that are cancelled and tell who waits for them; a
            # ThreadPoolExecutor that cancels them itself tells nobody (Python 3.11).
            with self._lock:
                waiting = list(self._futures)
            for future in waiting:
                future.cancel()
            self._end()
        self._threads.shutdown(wait)
        self._end()

    def _end(self) -> None:
        with self._lock:
            self._closed = True
        own.end(self._begun)

    def _called(self, task: Any) -> Any:
        """Have the process of this thread work, and return what it found."""
        process, pipe = self._process()
        try:
            pipe.send(task)
            failed, found = pipe.recv()
        except (EOFError, OSError):
            del self._own.process
            pipe.close()
            raise LostWorkerError(own.lost(process)) from None
        if failed:
            raise found
        return found

    def _process(self) -> tuple[SpawnProcess, Connection]:
        if not hasattr(self._own, "process"):
            here, there = own.pipe(duplex=True)
            process = own.made(_work, there)
            with self._lock:
                if self._closed:
                    raise RuntimeError("the processes have been ended")
                own.start(process)
                self._begun.append(process)
            # The only other end is the process's own: it is closed when that ends.
            there.close()
            self._own.process = process, here
        found: tuple[SpawnProcess, Connection] = self._own.process
        return found


@contextmanager
def processes(workers: int) -> Iterator[Engine]:
    """Give processes of this machine.

    Parameters
    ----------
    workers : int
        How many. Cores that are left over are shared.

    Yields
    ------
    Engine
        Its processes are begun as they are needed, live on from contact to contact, and end with
        the block within a second.
    """
    executor = LocalExecutor(workers)
    stop = partial(executor.shutdown, cancel_futures=True)
    try:
        yield Engine(executor, lambda: workers, max(1, default_workers() // workers), stop)
    finally:
        stop()


# In a process of its own


def _work(pipe: Connection) -> None:
    """Carry out tasks until no more can come."""
    with own.following():
        while True:
            try:
                function, args, kwargs = pipe.recv()
            except EOFError:
                return
            try:
                answer = False, function(*args, **kwargs)
            except Exception as error:
                answer = True, error
            pipe.send(answer)
