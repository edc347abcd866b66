"""Jobs in worker processes: progress, cancellation and limits.

A process takes a second to start: `WorkerPool` keeps a spare one, which takes about 100 MiB.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

import roughcontact as rc
from roughcontact._tools import files, processes
from roughcontact.request import options
from roughcontact.request.request import Request

# Interval between checks whether a job was canceled [s].
_POLL_SECONDS = 0.1


@dataclass(frozen=True)
class Limits:
    """Limits of a job."""

    memory: int | None = None  # Memory in addition to that of an idle process [bytes]
    seconds: float = math.inf  # Duration [s]


@dataclass(frozen=True)
class JobStage:
    """Progress of a job."""

    progress: rc.results.Progress | str  # Solver progress, or a stage as text
    share: float | None  # Completed share, if known
    seconds: float  # Time since the start of the job [s]

    @property
    def remaining(self) -> float | None:
        """Estimated remaining time [s], if known."""
        return self.seconds * (1.0 / self.share - 1.0) if self.share else None


@dataclass(frozen=True)
class JobResult:
    """Result of a job."""

    value: Any = None  # Returned value
    error: rc.RoughcontactError | None = None  # Reason of a failure
    canceled: bool = False  # Whether the job was canceled
    seconds: float = 0.0  # Duration [s]


Tell: TypeAlias = "Callable[[rc.results.Progress | str], None]"
"""``tell(progress)`` reports the progress of a job."""

OnStage = Callable[[JobStage], None]
OnEnd = Callable[[JobResult], None]


class WorkerPool:
    """Pool that runs jobs in separate processes, with a spare process for the next job."""

    def __init__(self, spare: bool = True) -> None:
        self._lock = threading.Lock()
        self._keeps = spare
        self._spare: processes.Worker | None = None
        self._jobs: set[Job] = set()
        # Each solve takes all cores: more than two in parallel only delay each other.
        self.turns = threading.Semaphore(2)

    def submit(
        self,
        work: Callable[..., Any],
        *args: Any,
        on_stage: OnStage | None = None,
        ended: OnEnd | None = None,
        limits: Limits | None = None,
        folders: Sequence[Path] = (),
    ) -> Job:
        """Start a job."""
        with self._lock:
            worker, self._spare = self._spare, None
        if worker is None or not worker.process.is_alive():
            worker = processes.Worker(_NEEDED)
        job = Job(
            worker, (work, args, limits or Limits()), on_stage, self._forget_job(ended), folders
        )
        with self._lock:
            self._jobs.add(job)
        job.begin()
        # The spare process starts after the job, without delaying it.
        threading.Thread(target=self.prestart, daemon=True).start()
        return job

    def prestart(self) -> None:
        """Start the spare process, if there is none."""
        with self._lock:
            if self._keeps and (self._spare is None or not self._spare.process.is_alive()):
                self._spare = processes.Worker(_NEEDED)

    def close(self) -> None:
        """End all jobs and processes."""
        with self._lock:
            self._keeps = False
            spare, self._spare = self._spare, None
            jobs = list(self._jobs)
        for job in jobs:
            job.cancel()
        if spare is not None:
            processes.end_processes([spare.process])
        for job in jobs:
            job.wait()

    def _forget_job(self, ended: OnEnd | None) -> Callable[[Job, JobResult], None]:
        def parted(job: Job, end: JobResult) -> None:
            with self._lock:
                self._jobs.discard(job)
            if ended is not None:
                ended(end)

        return parted


class Job:
    """Job in another process; `WorkerPool.submit` creates it."""

    def __init__(
        self,
        worker: processes.Worker,
        task: tuple[Callable[..., Any], tuple[Any, ...], Limits],
        on_stage: OnStage | None,
        ended: Callable[[Job, JobResult], None],
        folders: Sequence[Path],
    ) -> None:
        self._worker, self._task = worker, task
        self._on_stage, self._ended, self._folders = on_stage, ended, folders
        self._canceled = threading.Event()
        self._over = threading.Event()
        self._share: float | None = None
        self._end: JobResult | None = None

    def begin(self) -> None:
        """Start to run the task, in a thread that watches its process."""
        self._begun = time.monotonic()
        threading.Thread(target=self._watch_job, name="job", daemon=True).start()

    def cancel(self) -> None:
        """Cancel the job within a second, without unfinished files."""
        self._canceled.set()

    def wait(self, seconds: float | None = None) -> JobResult | None:
        """Wait for the result of the job; return None on timeout."""
        self._over.wait(seconds)
        return self._end

    # In the thread of the job

    def _watch_job(self) -> None:
        try:
            try:
                end = self._watch_process()
            finally:
                processes.end_processes([self._worker.process])
                for folder in self._folders:
                    files.remove_unfinished(folder)
            self._end = replace(end, seconds=self._seconds)
            self._ended(self, self._end)
        finally:
            self._over.set()

    @property
    def _seconds(self) -> float:
        return time.monotonic() - self._begun

    def _watch_process(self) -> JobResult:
        maximum = self._task[2].seconds
        try:
            self._worker.send(_run_limited, *self._task, reports=True)
            while not self._canceled.is_set():
                remaining = maximum - self._seconds
                message = self._worker.receive(max(0.0, min(remaining, _POLL_SECONDS)))
                if message is None and remaining <= 0:
                    return JobResult(error=rc.RoughcontactError(f"took longer than {maximum:g} s"))
                match message:
                    case (processes.RESULT, value):
                        return JobResult(value=value)
                    case (processes.ERROR, error):
                        return JobResult(error=error)
                    case (processes.REPORT, state):
                        self._notify(state)
        except processes.LostWorkerError as lost:
            if not self._canceled.is_set():
                return JobResult(error=rc.RoughcontactError(str(lost)))
        return JobResult(canceled=True)

    def _notify(self, state: rc.results.Progress | str) -> None:
        if not isinstance(state, str) and state.count > 1:
            done = (state.number - 1 + state.kept) / state.count
            self._share = max(self._share or 0.0, done)
        if self._on_stage is not None:
            self._on_stage(JobStage(state, self._share, self._seconds))


# In the separate process

# Modules that every job needs.
_NEEDED = ("roughcontact.contact.solve", "roughcontact.formats.read", "roughcontact.request.run")


def _run_limited(
    tell: Tell, work: Callable[..., Any], args: tuple[Any, ...], limits: Limits
) -> Any:
    """Execute a job within its limit of memory."""
    try:
        with processes.limit_memory(limits.memory):
            return work(tell, *args)
    except rc.RoughcontactError:
        raise
    except MemoryError:
        limit = "" if limits.memory is None else f" of {limits.memory / 2**30:.3g} GiB"
        words = f"the memory{limit} is exhausted; crop the map"
        raise rc.InsufficientMemoryError(words) from None
    except OSError as error:
        words = f"{error.filename or 'a file'}: {error.strerror or error}"
        raise rc.RoughcontactError(words) from None
    except Exception as error:
        raise rc.RoughcontactError(f"{type(error).__name__}: {error}") from error


# Jobs


def run_request(tell: Tell, request: Request) -> Any:
    """Execute a request, and return its `Outcome`; a job for `WorkerPool.submit`."""
    from roughcontact.request import run

    return run.run_request(request, tell, tell)


def output_folders(request: Request) -> list[Path]:
    """Return the folders that a request writes into."""
    result = {path.parent for _, path in request.places}
    folder = request.get(options.FOLDER)
    return sorted(result if folder is None else result | {folder})


def read_map(tell: Tell, path: Path, reading: dict[str, Any]) -> tuple[rc.Surface, Any]:
    """Read a map and the channels of its file, as `formats.read.read_with_channels`; a job."""
    from roughcontact.formats import read

    return read.read_with_channels(path, **reading)


READING = Limits(memory=4 * 2**30, seconds=60.0)
"""Limits of reading an uploaded file."""


class MapReader:
    """Reader in another process, called like `formats.read.read_announced`."""

    def __init__(self, bench: WorkerPool, limits: Limits = READING) -> None:
        self._bench, self._limits = bench, limits
        self._checked: tuple[Path, rc.Surface] | None = None
        self.channels: dict[Path, list[str]] = {}

    def check(self, path: Path, ended: OnEnd) -> None:
        """Read a file without options, and keep its map for the next call."""

        def keep_map(end: JobResult) -> None:
            if end.value is not None:
                self._checked = path, self._list_channels(path, *end.value)
            ended(end)

        work = partial(read_map, path=path, reading={})
        self._bench.submit(work, ended=keep_map, limits=self._limits)

    def __call__(self, path: Path, announced: Callable[..., None], *reading: Any) -> rc.Surface:
        """Read a map; a checked file is not read again."""
        checked, self._checked = self._checked, None
        if checked is not None and checked[0] == path and not any(reading):
            surface = checked[1]
        else:
            names = ("format", "channel", "unit", "size", "override_size", "no_data")
            requested = dict(zip(names, reading, strict=False))
            work = partial(read_map, path=path, reading=requested)
            end = self._bench.submit(work, limits=self._limits).wait()
            assert end is not None
            if end.canceled:
                raise rc.RoughcontactError(f"the reading of {path.name} was ended")
            if end.error is not None:
                raise end.error
            surface = self._list_channels(path, *end.value)
        announced(surface.shape)
        # Arrays lose their read-only flag in transit.
        return replace(surface)

    def _list_channels(
        self, path: Path, surface: rc.Surface, channels: Iterable[Any]
    ) -> rc.Surface:
        self.channels = {path: [channel.name for channel in channels if channel.name]}
        return surface
