"""Run the contacts of a project on an executor."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Any, NamedTuple, TypeVar

from roughcontact._tools import files
from roughcontact._tools.processes import reject_mpi_run
from roughcontact.analyses.tasks import DASK, LOCAL
from roughcontact.batch import jobs, plan
from roughcontact.batch.executors import Engine, connect_cluster, local_processes
from roughcontact.batch.plan import FAILED, KEPT, SOLVED, ContactReport, Entry
from roughcontact.errors import ArgumentRef, InputError
from roughcontact.halfspace.fft import default_workers
from roughcontact.request.options import FOLDER
from roughcontact.request.outcome import ignore
from roughcontact.request.outputs import SavedSteps, UnfinishedError

T = TypeVar("T")

_MAX_TRIES = 3
"""Maximum number of submissions of a contact whose scheduler is lost."""
_RETRY_ALONE = 0
"""Mark of a retry without other contacts in parallel."""


@contextmanager
def open_project(
    load: Callable[[], T],
    count: Callable[[T], int],
    kind: str = LOCAL,
    workers: int | None = None,
    scheduler: str | None = None,
) -> Iterator[tuple[Engine, T]]:
    """Read a project, and yield an engine for it and the project."""
    if scheduler is not None and (kind != DASK or workers is not None):
        raise InputError(
            "is the address of a cluster with its workers: it needs "
            f"{ArgumentRef('engine', DASK)} and cannot be combined with {ArgumentRef('workers')}",
            argument="scheduler",
        )
    reject_mpi_run()
    read = load()
    several = _process_count(count(read), workers)
    connect = partial(connect_cluster, scheduler) if kind == DASK else local_processes
    with connect(several) as engine:
        yield engine, read


def _process_count(count: int, workers: int | None = None) -> int:
    """Return the number of local processes, at most one per task."""
    return max(1, min(workers or default_workers(), count))


def task_limit(entries: list[Entry]) -> int:
    """Return the number of tasks of a project that run in parallel."""
    return sum(max(1, len(_subtask_ids(contact))) for contact in _group_entries(entries))


def run_project(
    entries: list[Entry],
    text: Callable[[ContactReport], None],
    engine: Engine | None = None,
    *,
    say: Callable[[str], None] = ignore,
    warn: Callable[[str], None] = ignore,
) -> list[ContactReport]:
    """Run the contacts of a project in parallel, and return their reports."""
    with ExitStack() as stack:
        if engine is None:
            engine = stack.enter_context(local_processes(_process_count(task_limit(entries))))
        results = entries[0].summary.parent
        for folder in {entry.request.get(FOLDER) for entry in entries}:
            if folder is not None:
                stack.callback(_clear_checkpoints, folder)
        results.mkdir(parents=True, exist_ok=True)
        # An interruption leaves no partial file.
        stack.callback(files.remove_unfinished, results)
        mark = None
        if engine.is_remote:
            # No file that `remove_unfinished` removes: locks may not reach other machines.
            mark = Path(
                stack.enter_context(
                    NamedTemporaryFile(prefix=".roughcontact-", suffix=".mark", dir=results)
                ).name
            )
        return _ProjectRun(entries, _Callbacks(text, say, warn), engine, mark).run_all()


# Interval between checks of the engine without a result [s].
_POLL_SECONDS = 2.0
# Time without workers before a warning [s]: a worker that ended may be restarted.
_WORKER_LOSS_SECONDS = 5.0


class _Callbacks(NamedTuple):
    """Callbacks for reports, progress and warnings, see `run_project`."""

    report: Callable[[ContactReport], None]
    say: Callable[[str], None]
    warn: Callable[[str], None]


class _ProjectRun:
    """Run of a project: waiting and running contacts, and the reports of the others."""

    def __init__(
        self, entries: list[Entry], tell: _Callbacks, engine: Engine, mark: Path | None
    ) -> None:
        self._entries, self._tell, self._engine = entries, tell, engine
        # A file that remote workers must see, and their working folder.
        self._where: dict[str, Any] = {} if mark is None else {"mark": mark, "folder": Path.cwd()}
        self._reports: dict[int, ContactReport] = {}
        self._waiting = deque(_group_entries(entries))
        # Tasks to submit, with the number of the attempt.
        self._ready: deque[tuple[jobs.BatchTask, int]] = deque()
        # Results and failure reasons of subtasks, by index of the entry and name.
        self._pieces: dict[int, dict[str, Any]] = {}
        self._failed: dict[int, dict[str, str]] = {}
        # Time since which no worker is connected, whether it was reported, and the reason.
        self._lonely, self._warned, self._closed = math.inf, False, ""
        self._under_way: dict[Future[jobs.TaskResult], tuple[jobs.BatchTask, int]] = {}
        # Tasks lost with a shared worker: retried one by one at the end.
        self._suspects: deque[jobs.BatchTask] = deque()
        self._checksums: dict[object, str | None] = {}

    def run_all(self) -> list[ContactReport]:
        """Run all contacts, and return their reports in the order of the entries."""
        try:
            while self._waiting or self._ready or self._under_way or self._suspects:
                self._look_for_workers()
                self._submit_tasks()
                ended, _ = wait(self._under_way, _POLL_SECONDS, FIRST_COMPLETED)
                if self._closed or self._engine.is_lost():
                    ended = set(self._under_way)
                for future in ended:
                    future.cancel()
                    self._handle_result(future, *self._under_way.pop(future))
        except KeyboardInterrupt:
            self._engine.shut_down()
            raise UnfinishedError(*self._completed_summaries()) from None
        return [self._reports[number] for number in range(len(self._entries))]

    def _look_for_workers(self) -> None:
        """Warn if no worker is connected; close the run after a timeout."""
        if self._engine.slots():
            self._lonely, self._warned = math.inf, False
            return
        now = time.monotonic()
        self._lonely = min(self._lonely, now)
        whose, patience = self._engine.workers, self._engine.no_worker_timeout
        if now - self._lonely > patience:
            self._closed = f"there were no workers {whose} for {patience / 60:.3g} min"
        elif now - self._lonely > _WORKER_LOSS_SECONDS and not self._warned:
            self._tell.warn(f"waiting for workers {whose}, {patience / 60:.3g} min at most")
            self._warned = True

    def _submit_tasks(self) -> None:
        """Submit up to two tasks per parallel slot, so that no worker is idle."""
        maximum = 2 * max(1, self._engine.slots())
        while len(self._under_way) < maximum and (self._ready or self._waiting):
            if self._ready:
                self._submit(*self._ready.popleft())
            else:
                self._ready.extend(
                    (task, 1) for task in self._remaining_tasks(self._waiting.popleft())
                )
        if self._suspects and not self._under_way:
            self._submit(self._suspects.popleft(), _RETRY_ALONE)

    def _remaining_tasks(self, contact: Contact) -> list[jobs.BatchTask]:
        """Return the remaining tasks of a contact, and report its complete entries."""
        parts = []
        for number, entry in contact:
            digest = plan.request_digest(entry, self._cached_checksum)
            before = plan.find_complete(entry, digest)
            if before is None:
                parts.append(jobs.SubtaskRequest(number, entry, digest))
            else:
                self._record_report(number, ContactReport(entry.name, KEPT, before))
        if not parts:
            return []
        names = _subtask_ids(contact)
        if not names:
            return [self._make_task(tuple(parts))]
        (part,) = parts
        self._pieces[part.number] = {}
        return [self._make_task((part,), piece=name) for name in names]

    def _make_task(self, parts: tuple[jobs.SubtaskRequest, ...], **more: Any) -> jobs.BatchTask:
        """Return a task with the checksums of its input files."""
        task = jobs.BatchTask(parts, self._engine.threads, **self._where, **more)
        found = {path: self._cached_checksum(path) for path in task.inputs}
        known = {path: checksum for path, checksum in found.items() if checksum is not None}
        return replace(task, checksums=known)

    def _cached_checksum(self, path: Path) -> str | None:
        """Return the checksum of a file, cached until the file changes."""
        try:
            about = path.stat()
        except OSError:
            return None
        key = path, about.st_dev, about.st_ino, about.st_size, about.st_mtime_ns
        if key not in self._checksums:
            self._checksums[key] = plan.checksum_if_readable(path)
        return self._checksums[key]

    def _submit(self, task: jobs.BatchTask, tries: int) -> None:
        if self._closed:
            return self._report_parts(task, jobs.failed_answer(task, self._closed))
        try:
            self._under_way[self._engine.executor.submit(jobs.run_task, task)] = task, tries
        except Exception as error:
            # An engine that accepts no more tasks may raise any error.
            self._report_parts(task, jobs.failed_answer(task, self._engine.lost_task_text(error)))

    def _handle_result(
        self, future: Future[jobs.TaskResult], task: jobs.BatchTask, tries: int
    ) -> None:
        """Report the result of a task, or submit the task again."""
        try:
            answer = future.result()
        except CancelledError as error:
            if tries < _MAX_TRIES and not self._closed:
                return self._ready.append((task, tries + 1))
            answer = jobs.failed_answer(task, self._closed or self._engine.lost_task_text(error))
        except Exception as error:
            if tries != _RETRY_ALONE and self._engine.shared(error):
                return self._suspects.append(task)
            answer = jobs.failed_answer(task, self._engine.lost_task_text(error))
        return self._report_parts(task, answer)

    def _handle_piece(self, task: jobs.BatchTask, answer: jobs.TaskResult) -> None:
        """Keep the result of a subtask; queue the whole contact after the last subtask."""
        (part,) = task.parts
        number, entry = part.number, self._entries[part.number]
        result, failed = self._pieces[number], self._failed.setdefault(number, {})
        count = len(entry.request.subtask_ids())
        if answer.reports:
            failed[task.piece] = answer.reports[number].reason
        else:
            result[task.piece] = answer.result
            self._tell.say(f"{len(result)} of {count} subtasks of {entry.name} done")
        if len(result) + len(failed) < count:
            return
        if failed:
            self._record_report(
                number, ContactReport(entry.name, FAILED, {}, _failure_reasons(failed.values()))
            )
        else:
            final = self._make_task((part,), known_results=self._pieces.pop(number))
            self._ready.appendleft((final, 1))

    def _report_parts(self, task: jobs.BatchTask, answer: jobs.TaskResult) -> None:
        """Report the end of each part of a contact; complete output is treated as solved."""
        if task.piece:
            self._handle_piece(task, answer)
            return
        digests = {part.number: part.digest for part in task.parts}
        for number, report in answer.reports.items():
            if report.state == FAILED:
                before = plan.find_complete(self._entries[number], digests[number])
                report = report if before is None else ContactReport(report.name, SOLVED, before)
            self._record_report(number, report)

    def _record_report(self, number: int, report: ContactReport) -> None:
        self._reports[number] = report
        self._tell.report(report)

    def _completed_summaries(self) -> tuple[list[Path], SavedSteps]:
        """Return the files of complete contacts, and their count."""
        done_ = {number for number, report in self._reports.items() if report.state != FAILED}
        for task, _ in self._under_way.values():
            done_ |= {
                part.number
                for part in task.parts
                if plan.find_complete(part.entry, part.digest) is not None
            }
        whole = [self._entries[number].summary for number in sorted(done_)]
        folder = self._entries[0].summary.parent
        return whole, SavedSteps(len(whole), len(self._entries), "contact", folder)


# Entries of one contact, with their indices.
Contact = list[tuple[int, Entry]]


def _group_entries(entries: list[Entry]) -> list[Contact]:
    """Return the entries with their indices, grouped by contact."""
    result: dict[int, Contact] = {}
    for number, entry in enumerate(entries):
        result.setdefault(entry.contact, []).append((number, entry))
    return list(result.values())


def _subtask_ids(contact: Contact) -> tuple[str, ...]:
    """Return the names of the subtasks of a contact; none if it has several requests."""
    return contact[0][1].request.subtask_ids() if len(contact) == 1 else ()


# Maximum number of listed reasons.
_MAX_REASONS = 8


def _failure_reasons(text: Iterable[str]) -> str:
    """Return the distinct reasons of failed subtasks as text."""
    different = list(dict.fromkeys(text))
    more = len(different) - _MAX_REASONS
    return "; ".join(different[:_MAX_REASONS] + ([f"and {more} more"] if more > 0 else []))


def _clear_checkpoints(folder: Path) -> None:
    """Remove the unfinished files of killed processes from the folder of saved steps."""
    for place in (folder, *folder.glob("*/")):
        files.remove_unfinished(place)
