"""Processes that work for this one: begun, and ended however it ends; none is left behind."""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from typing import Any

from roughcontact.interrupts import heard, quiet

# Seconds that a process has to remove what it has begun to write when it is told to end.
_GRACE = 0.5

# Parameters of the GNU C library's mallopt(3), and bytes: what is larger is mapped by itself, and
# more than that is not kept at the end of the heap.
_MAPPED, _KEPT = (-3, 2**25), (-1, 2**27)


def made(target: Callable[..., None], *args: Any) -> SpawnProcess:
    """Return a process of its own, which `start` starts.

    Parameters
    ----------
    target : callable
        A function of a module; it works within `following`.
    *args : object
        What it is called with.
    """
    return multiprocessing.get_context("spawn").Process(target=target, args=args, daemon=True)


def start(process: SpawnProcess) -> None:
    """Start a process that Ctrl-C does not reach."""
    with deaf():
        process.start()


def pipe(duplex: bool = False) -> tuple[Connection, Connection]:
    """Return the ends of a pipe: for this process and for another, of which the second sends."""
    return multiprocessing.get_context("spawn").Pipe(duplex)


def lost(process: SpawnProcess) -> str:
    """Return what to say of a process that is gone without a word."""
    process.join()
    return f"its process ended with status {process.exitcode}; is there enough memory?"


def end(begun: Iterable[SpawnProcess]) -> None:
    """End processes: asked to, then made to; all of them within a second."""
    begun = [process for process in begun if process.pid is not None]
    for process in begun:
        process.terminate()
    last = time.monotonic() + _GRACE
    for process in begun:
        process.join(max(0.0, last - time.monotonic()))
        process.kill()
        process.join()


@contextmanager
def deaf() -> Iterator[None]:
    """Keep Ctrl-C from what is begun, which it reaches too; the first process ends the others."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    # The first process begins one more, after which the signal is let through (Python 3.11).
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        with _later():
            yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _later() -> Iterator[None]:
    """Answer a Ctrl-C that another thread has let through when all has begun."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []
    handler = signal.signal(signal.SIGINT, lambda number, frame: came.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
        if came:
            signal.raise_signal(signal.SIGINT)


# In a process of its own


@contextmanager
def following() -> Iterator[None]:
    """Do the work of a process: it ends with the one that began it, and in good order if asked."""
    # Where it could not be blocked.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _leave)
    threading.Thread(target=_follow, daemon=True).start()
    try:
        with heard():
            yield
    except SystemExit:
        # What is half made goes now.
        sys.unraisablehook = lambda dropped: None
        raise
    finally:
        # Nothing is half written any more, and what Python does at its end tells of exceptions.
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


def _leave(number: int, frame: object) -> None:
    """End in good order: what is half written is removed."""
    quiet()
    sys.exit(128 + number)


def _follow() -> None:
    """End when the first process has ended, by whatever: nobody waits for the work any more."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


def keep_freed() -> None:
    """Have the memory of a freed array kept for the next one, where that can be asked for.

    Dask sets ``MALLOC_TRIM_THRESHOLD_`` for its workers, so that each array gives its pages back
    and the kernel clears those of the next: contacts of 512² and 1024² points took 1.4 and 1.6
    times as long.
    """
    if sys.platform == "linux" and "MALLOC_MMAP_THRESHOLD_" not in os.environ:
        # Other C libraries do not know it.
        with suppress(OSError, AttributeError):
            adjust = ctypes.CDLL(None).mallopt
            for parameter, size in (_MAPPED, _KEPT):
                adjust(parameter, size)
