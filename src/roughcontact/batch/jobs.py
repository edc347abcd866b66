"""Task of one contact or one subtask: input, execution and result."""

from __future__ import annotations

import os
import shutil
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from roughcontact._tools import files, processes
from roughcontact._version import __version__
from roughcontact.batch import plan
from roughcontact.batch.plan import FAILED, SOLVED, ContactReport, Entry
from roughcontact.errors import (
    ArgumentRef,
    InputError,
    OtherRunError,
    RoughcontactError,
    render_message,
)
from roughcontact.halfspace import fft
from roughcontact.request import outputs, run
from roughcontact.request.options import FOLDER
from roughcontact.request.outcome import Outcome, ignore


@dataclass(frozen=True)
class SubtaskRequest:
    """Request for a contact, with its digest."""

    number: int  # Index among the entries of the project
    entry: Entry  # Name, request and summary file
    digest: str  # Digest of its inputs, from `plan.request_digest`


@dataclass(frozen=True)
class BatchTask:
    """All requests for one contact, or one subtask of it."""

    parts: tuple[SubtaskRequest, ...]  # Requests of one contact, which share cached maps
    threads: int  # Maximum number of cores
    checksums: Mapping[Path, str] = field(default_factory=dict)  # Of its readable input files
    mark: Path | None = None  # File that the workers of a cluster must see
    folder: Path | None = None  # Working folder of the run, for the workers of a cluster
    version: str = __version__  # Version of the program that submits the task
    piece: str = ""  # Name of the subtask; empty for whole requests
    known_results: Mapping[str, Any] = field(default_factory=dict)  # Of finished subtasks, by name

    @property
    def inputs(self) -> list[Path]:
        """Input files of the task."""
        if self.piece or self.known_results:
            return [*self.parts[0].entry.request.subtask_inputs(self.piece)]
        return [path for part in self.parts for path in part.entry.request.read_files]


@dataclass(frozen=True)
class TaskResult:
    """Result of the parts of a contact, or of one subtask."""

    reports: Mapping[int, ContactReport] = field(default_factory=dict)  # By index of the entry
    result: Any = None  # Result of a subtask, if it did not fail


def run_task(task: BatchTask) -> TaskResult:
    """Execute all requests for one contact, or one of its subtasks."""
    if task.version != __version__:
        return failed_answer(
            task,
            f"the worker runs roughcontact {__version__}, not {task.version}; install the same",
        )
    processes.keep_freed()
    with fft.limit_threads(task.threads):
        if task.folder is None:
            return _run_parts(task)
        try:
            with _working_folder(task.folder):
                if task.mark is None or task.mark.exists():
                    return _run_parts(task)
        except OSError:
            # The folder does not exist on this machine.
            pass
    return failed_answer(
        task,
        f"its worker does not see the files in {task.folder}; put the project on a file system "
        "that all workers see under the same path, and start the run there",
    )


# Working folders before the running tasks of this process, whose threads share one.
_folders: list[Path] = []
_folder_change = threading.Condition()


@contextmanager
def _working_folder(folder: Path) -> Iterator[None]:
    """Change the working folder during the block; wait for tasks of other runs."""
    with _folder_change:
        _folder_change.wait_for(lambda: not _folders or Path.cwd() == folder.resolve())
        before = Path.cwd()
        os.chdir(folder)
        _folders.append(before)
    try:
        yield
    finally:
        with _folder_change:
            os.chdir(_folders.pop())
            _folder_change.notify_all()


def failed_answer(task: BatchTask, reason: str) -> TaskResult:
    """Return the result of a task of which all parts failed for one reason."""
    return TaskResult(
        {part.number: ContactReport(part.entry.name, FAILED, {}, reason) for part in task.parts}
    )


def _run_parts(task: BatchTask) -> TaskResult:
    """Execute all parts of a contact one after the other, or one subtask."""
    reports, result = {}, None
    with run.shared_runner() as carry_out:
        for part in task.parts:
            try:
                if task.piece:
                    result = part.entry.request.solve_subtask(task.piece, ignore, ignore)
                    _require_unchanged(task)
                else:
                    reports[part.number] = _run_part(part, task, carry_out)
            except RoughcontactError as error:
                reports[part.number] = _failed_report(
                    part, error.message_for(_error_text(part.entry))
                )
            except MemoryError as error:
                reports[part.number] = _failed_report(part, _out_of_memory_text(error))
            except OSError as error:
                reports[part.number] = _failed_report(part, f"{type(error).__name__}: {error}")
    return TaskResult(reports, result)


def _require_unchanged(task: BatchTask) -> None:
    """Raise `InputError` if an input file is not the one that the run has found."""
    for path, checksum in task.checksums.items():
        if plan.checksum_if_readable(path) != checksum:
            raise InputError(f"{path} changed while the project ran; run it again")


def _out_of_memory_text(error: MemoryError) -> str:
    """Return the message for a worker that ran out of memory."""
    text = f" ({error})" if str(error) else ""
    return (
        f"its worker ran out of memory{text}; give each worker more, with fewer of them on a "
        "machine, or the map a larger pixel"
    )


def _failed_report(part: SubtaskRequest, reason: str) -> ContactReport:
    return ContactReport(part.entry.name, FAILED, {}, reason)


def _error_text(entry: Entry) -> Callable[[ArgumentRef], str]:
    return partial(plan.spell_key, task=entry.request.task)


def _run_part(
    part: SubtaskRequest, task: BatchTask, carry_out: Callable[..., Outcome]
) -> ContactReport:
    """Execute one part; move saved steps of another request aside."""
    entry = part.entry
    try:
        outcome = carry_out(entry.request, ignore, None, task.known_results)
    except OtherRunError:
        # Only this contact uses the folder; steps may have taken hours, so keep the old ones.
        folder = entry.request.get(FOLDER)
        assert folder is not None
        before = folder.with_name(f"{folder.name}.before")
        shutil.rmtree(before, ignore_errors=True)
        folder.rename(before)
        outcome = carry_out(entry.request, ignore, None, task.known_results)
    if outcome.failure is not None:
        raise outcome.failure
    if not outcome.converged:
        return _failed_report(part, render_message(outcome.shortfall.parts, _error_text(entry)))
    # Without `last`, the record itself has the main quantities.
    last_of = entry.request.task.last
    last = {} if last_of is None else {"last": last_of(outcome)}
    _require_unchanged(task)
    record = plan.seal_summary({**outcome.record(), **last}, part.digest, outcome.written)
    text = files.to_json(record) + "\n"
    outputs.write_files([(entry.summary, partial(files.write_atomically, content=text))], ignore)
    return ContactReport(entry.name, SOLVED, record)
