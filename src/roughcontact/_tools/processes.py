"""Child processes: start, interrupt and termination; none outlives this process."""

from __future__ import annotations

import _thread
import ctypes
import multiprocessing
import os
import pickle
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from typing import Any, TypeVar, cast

from roughcontact._tools import memory
from roughcontact.errors import InputError, RoughcontactError

T = TypeVar("T")

# Environment variables with the number of processes of an MPI run (MPICH, Open MPI, PMIx).
_MPI_SIZES = ("PMI_SIZE", "OMPI_COMM_WORLD_SIZE", "MPI_LOCALNRANKS")

# Seconds after which a dropped interrupt is raised again.
_RETRY_SECONDS = 0.01


@contextmanager
def redeliver_interrupts() -> Iterator[None]:
    """Raise an interrupt again that Python dropped in a callback."""
    before, running = sys.unraisablehook, [True]
    main = threading.current_thread() is threading.main_thread()
    undecided = main and signal.getsignal(signal.SIGINT) is signal.default_int_handler

    def send_later(number: signal.Signals) -> None:
        time.sleep(_RETRY_SECONDS)
        if running:
            _send_signal(number)

    def again(dropped: Any) -> None:
        if not _is_exit_exception(dropped):
            before(dropped)
            return
        requested = signal.SIGINT if dropped.exc_type is KeyboardInterrupt else signal.SIGTERM
        # Objects of threads wait for their start, in which another signal may come.
        _thread.start_new_thread(send_later, (requested,))

    sys.unraisablehook = again
    if undecided:
        signal.signal(signal.SIGINT, _raise_interrupt)
    try:
        yield
    finally:
        running.clear()
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


# Time [s] for a terminated process to remove unfinished files.
_EXIT_SECONDS = 0.5

# Parameters of mallopt(3) of the GNU C library, and bytes: larger blocks are mapped separately, and
# free memory at the end of the heap beyond the second size is returned to the system.
_MAPPED, _KEPT = (-3, 2**25), (-1, 2**27)


class LostWorkerError(Exception):
    """Error of a call whose process ended; the message gives the exit reason."""


REPORT, RESULT, ERROR = "report", "result", "error"
"""Kinds of messages of a worker: progress of a call, its result or its error."""


class Worker:
    """Process that executes calls one after the other, and ends with this process."""

    def __init__(self, modules: Sequence[str] = ()) -> None:
        context = multiprocessing.get_context("spawn")
        self._connection, theirs = context.Pipe()
        self.process = context.Process(target=_serve, args=(theirs, modules), daemon=True)
        with sigint_blocked():
            self.process.start()
        # Only the process keeps this end open, so that it closes when the process ends.
        theirs.close()

    def send(self, function: Callable[..., Any], *args: Any, reports: bool = False) -> None:
        """Send a call; with ``reports`` its first argument is a callback, which sends messages."""
        with self._loss_as_error():
            self._connection.send((function, args, reports))

    def receive(self, timeout: float | None = None) -> tuple[str, Any] | None:
        """Return the kind and the value of the next message; None after a timeout [s]."""
        with self._loss_as_error():
            return self._connection.recv() if self._connection.poll(timeout) else None

    @contextmanager
    def _loss_as_error(self) -> Iterator[None]:
        try:
            yield
        except (EOFError, OSError):
            self.process.join()
            raise LostWorkerError(
                f"its process ended with status {self.process.exitcode}; is there enough memory?"
            ) from None


def end_processes(begun: Iterable[SpawnProcess]) -> None:
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


# Largest time of a call on a busy machine over its computing time, and its least memory [bytes].
_WAITING, _MIN_BYTES = 20, 2**28

# Interval between checks whether the parent process is running [s].
_PARENT_SECONDS = 0.2


def can_fork() -> bool:
    """Return whether the system and its libraries support forks; those of macOS do not."""
    return hasattr(os, "fork") and sys.platform != "darwin"


class ForkedCall:
    """Call of a function in a fork of this process; it must use no lock of another thread."""

    def __init__(
        self, function: Callable[..., Any], *args: Any, seconds: int | None = None
    ) -> None:
        # Imported here: in the fork it might wait for an import of another thread.
        import resource

        free = max(memory.free_bytes(), _MIN_BYTES)
        parent = os.getpid()
        receiver, sender = os.pipe()
        self._child = os.fork()
        if self._child == 0:
            try:
                if seconds is None:
                    threading.Thread(target=_exit_without, args=(parent,), daemon=True).start()
                else:
                    # There may be a lower limit.
                    with suppress(ValueError):
                        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
                with limit_memory(None if seconds is None else free):
                    _send_answer(sender, function, args)
            finally:
                os._exit(0)
        os.close(sender)
        self._seconds, self._stream = seconds, os.fdopen(receiver, "rb")

    def result(self) -> Any:
        """Wait for the result and return it, or raise the error of the call."""
        timeout = None if self._seconds is None else _WAITING * self._seconds
        try:
            came = wait([self._stream.fileno()], timeout)
            answer = self._stream.read() if came else b""
        finally:
            self.end()
        if not answer:
            raise ValueError(
                f"reading it crashes or takes more than {self._seconds} s of computing"
            )
        result, error = pickle.loads(answer)
        if error is not None:
            raise error
        return result

    def end(self) -> None:
        """End the process."""
        if self._stream.closed:
            return
        # Another thread may wait for all children.
        with suppress(ProcessLookupError, ChildProcessError):
            os.kill(self._child, signal.SIGKILL)
            os.waitpid(self._child, 0)
        self._stream.close()


def call_limited(function: Callable[..., T], *args: Any, seconds: int) -> T:
    """Return the result of a call that may crash or not end, in a fork if the system supports it.

    The fork has a limit of computing time [s], and the memory that is free.
    """
    if not can_fork():
        return function(*args)
    return cast("T", ForkedCall(function, *args, seconds=seconds).result())


@contextmanager
def limit_memory(maximum: int | None) -> Iterator[None]:
    """Limit the additional memory of this process [bytes]."""
    try:
        import resource
    except ImportError:
        # Windows has no such limit.
        maximum = None
    if maximum is None:
        yield
        return
    before = resource.getrlimit(resource.RLIMIT_AS)
    limit = memory.address_space_bytes() + maximum
    if before[1] != resource.RLIM_INFINITY:
        limit = min(limit, before[1])
    resource.setrlimit(resource.RLIMIT_AS, (limit, before[1]))
    try:
        yield
    finally:
        # The result is sent without the limit.
        resource.setrlimit(resource.RLIMIT_AS, before)


def _send_answer(sender: int, function: Callable[..., Any], args: tuple[Any, ...]) -> None:
    """Send the result and the error of a call through a pipe."""
    try:
        answer: tuple[Any, Exception | None] = function(*args), None
    except RoughcontactError as error:
        answer = None, error
    except MemoryError:
        answer = None, ValueError("reading it takes more memory than is free")
    except Exception as error:
        answer = None, error
    with os.fdopen(sender, "wb") as stream:
        stream.write(pickle.dumps(answer))


def _exit_without(parent: int) -> None:
    """Exit when the parent process has ended."""
    while os.getppid() == parent:
        time.sleep(_PARENT_SECONDS)
    os._exit(1)


# In a separate process


def _serve(connection: Connection, modules: Sequence[str]) -> None:
    """Execute calls until the pipe is closed."""
    # Imported while the process is idle.
    for name in modules:
        import_module(name)
    with _exit_with_parent():
        while True:
            try:
                function, args, reports = connection.recv()
            except EOFError:
                return
            if reports:
                args = (lambda report: connection.send((REPORT, report)), *args)
            try:
                reply = RESULT, function(*args)
            except Exception as error:
                reply = ERROR, error
            connection.send(reply)


@contextmanager
def _exit_with_parent() -> Iterator[None]:
    """Run a child process, which ends with its parent and cleans up on SIGTERM."""
    # For systems where the parent cannot block the signal.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _leave)
    threading.Thread(target=_wait_for_parent, daemon=True).start()
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


def _wait_for_parent() -> None:
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
