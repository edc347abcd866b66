"""Child processes: start, interrupt and termination; none outlives this process."""

from __future__ import annotations

import _thread
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
from multiprocessing.process import BaseProcess
from typing import Any

from roughcontact.errors import InputError

# Environment variables with the number of processes of an MPI run (MPICH, Open MPI, PMIx).
_MPI_SIZES = ("PMI_SIZE", "OMPI_COMM_WORLD_SIZE", "MPI_LOCALNRANKS")

# Seconds after which a dropped interrupt is raised again.
_RETRY_SECONDS = 0.01


@contextmanager
def redeliver_interrupts() -> Iterator[None]:
    """Raise an interrupt again that Python dropped in a callback."""
    before = sys.unraisablehook
    soon: list[threading.Timer] = []
    main = threading.current_thread() is threading.main_thread()
    undecided = main and signal.getsignal(signal.SIGINT) is signal.default_int_handler

    def again(dropped: Any) -> None:
        if not _is_exit_exception(dropped):
            before(dropped)
            return
        requested = signal.SIGINT if dropped.exc_type is KeyboardInterrupt else signal.SIGTERM
        while True:
            soon.append(threading.Timer(_RETRY_SECONDS, _send_signal, (requested,)))
            soon[-1].daemon = True
            try:
                soon[-1].start()
            except (KeyboardInterrupt, SystemExit):
                # On a busy machine the signal comes while this waits for the thread to start.
                continue
            return

    sys.unraisablehook = again
    if undecided:
        signal.signal(signal.SIGINT, _raise_interrupt)
    try:
        yield
    finally:
        for timer in soon:
            timer.cancel()
        if undecided:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        sys.unraisablehook = before


def silence_unraisable() -> None:
    """Suppress messages on other dropped exceptions, until `redeliver_interrupts` ends."""
    before = sys.unraisablehook
    sys.unraisablehook = lambda dropped: before(dropped) if _is_exit_exception(dropped) else None


def _is_exit_exception(dropped: Any) -> bool:
    return issubclass(dropped.exc_type, KeyboardInterrupt | SystemExit)


def _send_signal(number: signal.Signals) -> None:
    """Send a signal to the main thread; wake the thread if the system supports it."""
    first = threading.main_thread().ident
    if first is not None and hasattr(signal, "pthread_kill"):
        signal.pthread_kill(first, number)
    else:
        _thread.interrupt_main(number)


def _raise_interrupt(number: int, frame: object) -> None:
    """Raise `KeyboardInterrupt`, as Python does at Ctrl-C."""
    silence_unraisable()
    raise KeyboardInterrupt


# --- Child processes: started, and ended even if this process is killed ---


# Time [s] for a terminated process to remove unfinished files.
_EXIT_SECONDS = 0.5

# Parameters of mallopt(3) of the GNU C library, and bytes: larger blocks are mapped separately, and
# free memory at the end of the heap beyond the second size is returned to the system.
_MAPPED, _KEPT = (-3, 2**25), (-1, 2**27)


def create_process(target: Callable[..., None], *args: Any) -> SpawnProcess:
    """Return a new process, which `start_process` starts."""
    return multiprocessing.get_context("spawn").Process(target=target, args=args, daemon=True)


def start_process(process: SpawnProcess) -> None:
    """Start a process that Ctrl-C does not reach."""
    with sigint_blocked():
        process.start()


def open_pipe(duplex: bool = False) -> tuple[Connection, Connection]:
    """Return the ends of a pipe; the second sends, and with ``duplex`` both do."""
    return multiprocessing.get_context("spawn").Pipe(duplex)


def died_message(process: SpawnProcess) -> str:
    """Return the message on a process that ended without a report."""
    process.join()
    return f"its process ended with status {process.exitcode}; is there enough memory?"


def end_processes(begun: Iterable[BaseProcess]) -> None:
    """Terminate processes, and kill those that still run after half a second."""
    begun = [process for process in begun if process.pid is not None]
    for process in begun:
        process.terminate()
    last = time.monotonic() + _EXIT_SECONDS
    for process in begun:
        process.join(max(0.0, last - time.monotonic()))
        process.kill()
        process.join()


@contextmanager
def sigint_blocked() -> Iterator[None]:
    """Block Ctrl-C for processes started in the block; the parent process ends them."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    # The first start also starts the resource tracker, which unblocks the signal (Python 3.11).
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        with _delayed_interrupt():
            yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _delayed_interrupt() -> Iterator[None]:
    """Delay a Ctrl-C that another thread receives until the block ends."""
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


# In a separate process


@contextmanager
def exit_with_parent() -> Iterator[None]:
    """Run a child process, which ends with its parent and cleans up on SIGTERM."""
    # For systems where the parent cannot block the signal.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _leave)
    threading.Thread(target=_exit_with_parent, daemon=True).start()
    try:
        with redeliver_interrupts():
            yield
    except SystemExit:
        # From here on objects are cleaned up: suppress messages on dropped exceptions.
        sys.unraisablehook = lambda dropped: None
        raise
    finally:
        # Unfinished files are removed; an exception while Python shuts down would be reported.
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


def _leave(number: int, frame: object) -> None:
    """Exit by `SystemExit`, so that unfinished files are removed."""
    silence_unraisable()
    sys.exit(128 + number)


def _exit_with_parent() -> None:
    """Exit when the parent process has ended."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


def keep_freed() -> None:
    """Keep the memory of freed arrays for later ones; only on Linux with glibc."""
    if sys.platform == "linux" and "MALLOC_MMAP_THRESHOLD_" not in os.environ:
        # Other C libraries have no mallopt.
        with suppress(OSError, AttributeError):
            adjust = ctypes.CDLL(None).mallopt
            for parameter, size in (_MAPPED, _KEPT):
                adjust(parameter, size)


def release_memory() -> None:
    """Return freed memory to the system; only on Linux with glibc."""
    if sys.platform == "linux":
        with suppress(OSError, AttributeError):
            ctypes.CDLL(None).malloc_trim(0)


def reject_mpi_run() -> None:
    """Raise `InputError` if ``mpiexec`` started this process together with others."""
    if any(os.environ.get(name, "1") not in ("", "1") for name in _MPI_SIZES):
        raise InputError(
            "mpiexec started several processes, each of which would do all of the work: start a "
            "single one, which uses all cores"
        )
