"""Task of one contact or one subtask: input, execution and result, local or remote."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from roughcontact._tools import checksums, files, processes
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
from roughcontact.request import outputs, run as running
from roughcontact.request.options import FOLDER
from roughcontact.request.outcome import Outcome

MAX_TRANSFER_BYTES = 2**28
"""Maximum size of the files sent to or from a remote worker per contact [bytes]."""


@dataclass(frozen=True)
class SubtaskRequest:
    """Request for a contact, with its digest and output files."""

    number: int  # Index among the entries of the project
    entry: Entry  # Name, request and summary file
    digest: str  # Digest of its inputs, from `plan.request_digest`
    places: tuple[str, ...]  # Output files as named by the project


@dataclass(frozen=True)
class FileTransfer:
    """Files that a worker on another machine needs."""

    mark: Path  # Marker file in the results folder: a worker that finds it writes there
    sums: Mapping[Path, str]  # Checksum of each input file, by path
    checkpoints: tuple[Path, ...] = ()  # Files of an earlier run from which the contact may resume
    content: Mapping[Path, bytes] = field(default_factory=dict)


@dataclass(frozen=True)
class BatchTask:
    """All requests for one contact, or one subtask of it."""

    parts: tuple[SubtaskRequest, ...]  # Requests of one contact, which share cached maps
    threads: int  # Maximum number of cores
    transfer: FileTransfer | None = None
    version: str = __version__  # Version of the program that submits the task
    piece: str = ""  # Name of the subtask; empty for whole requests
    known_results: Mapping[str, Any] = field(default_factory=dict)  # Of finished subtasks, by name

    @property
    def inputs(self) -> list[Path]:
        """Input files of the task."""
        if self.piece or self.known_results:
            return [*self.parts[0].entry.request.subtask_inputs(self.piece)]
        return [path for part in self.parts for path in part.entry.request.inputs]


@dataclass(frozen=True)
class TaskResult:
    """Result of the parts of a contact, or of one subtask."""

    reports: Mapping[int, ContactReport] = field(default_factory=dict)  # By index of the entry
    lacking: tuple[Path, ...] = ()  # Files that the worker cannot read
    content: Mapping[Path, bytes] = field(default_factory=dict)
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
        if task.transfer is None:
            return _run_parts(task)
        try:
            return _run_on_worker(task, task.transfer)
        except (RoughcontactError, OSError) as error:
            return failed_answer(task, str(error))


def failed_answer(task: BatchTask, reason: str) -> TaskResult:
    """Return the result of a task of which all parts failed for one reason."""
    return TaskResult(
        {part.number: ContactReport(part.entry.name, FAILED, {}, reason) for part in task.parts}
    )


def _run_parts(task: BatchTask) -> TaskResult:
    """Execute all parts of a contact one after the other, or one subtask."""
    reports, result = {}, None
    with running.shared_runner() as carry_out:
        for part in task.parts:
            try:
                if task.piece:
                    result = part.entry.request.solve_subtask(task.piece, _ignore, _ignore)
                else:
                    seen = task.transfer is None or task.transfer.mark.exists()
                    reports[part.number] = _run_part(
                        part, carry_out, task.known_results, renew=seen
                    )
            except RoughcontactError as error:
                reports[part.number] = _failed_report(
                    part, error.message_for(_error_text(part.entry))
                )
            except MemoryError as error:
                reports[part.number] = _failed_report(part, _out_of_memory_text(error))
            except OSError as error:
                reports[part.number] = _failed_report(part, f"{type(error).__name__}: {error}")
    return TaskResult(reports, result=result)


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
    part: SubtaskRequest,
    carry_out: Callable[..., Outcome],
    known: Mapping[str, Any],
    *,
    renew: bool,
) -> ContactReport:
    """Execute one part; if ``renew``, move saved steps of another request aside."""
    entry = part.entry
    try:
        outcome = carry_out(entry.request, _ignore, None, known)
    except OtherRunError:
        if not renew:
            raise
        # Only this contact uses the folder; steps may have taken hours, so keep the old ones.
        folder = entry.request.get(FOLDER)
        assert folder is not None
        before = folder.with_name(f"{folder.name}.before")
        shutil.rmtree(before, ignore_errors=True)
        folder.rename(before)
        outcome = carry_out(entry.request, _ignore, None, known)
    if outcome.failure is not None:
        raise outcome.failure
    if not outcome.converged:
        return _failed_report(part, render_message(outcome.shortfall.parts, _error_text(entry)))
    # Without `last`, the record itself has the main quantities.
    last_of = entry.request.task.last
    last = {} if last_of is None else {"last": last_of(outcome)}
    called = dict(zip((path for _, path in entry.request.places), part.places, strict=True))
    written = {"written": [called[path] for path in outcome.written]}
    record = plan.seal_summary(
        {**outcome.record(), **written, **last}, part.digest, outcome.written
    )
    text = files.to_json(record) + "\n"
    outputs.write_files([(entry.summary, partial(files.write_atomically, content=text))], _ignore)
    return ContactReport(entry.name, SOLVED, record)


def _ignore(of: object) -> None:
    """Ignore a message, a progress state or a preview."""


# Execution on a worker that may be on another machine


def _run_on_worker(task: BatchTask, journey: FileTransfer) -> TaskResult:
    """Execute a task; replace input files that differ here by their sent content."""
    seen = journey.mark.exists()
    needed = [path for path, wanted in journey.sums.items() if not _is_same_file(path, wanted)]
    needed += [] if seen else journey.checkpoints
    lacking = tuple(path for path in needed if path not in journey.content)
    if lacking:
        return TaskResult(lacking=lacking)
    if seen and not needed:
        return _run_parts(task)
    with tempfile.TemporaryDirectory(prefix="roughcontact-") as folder:
        leftovers = None if seen else Path(folder) / "left"
        lie = _unpack_files(journey, needed, Path(folder) / "read", leftovers)
        parts = tuple(_relocate_part(part, lie, leftovers) for part in task.parts)
        answer = _run_parts(replace(task, parts=parts))
        left_ = {} if leftovers is None else _pack_outputs(leftovers)
    content = {path: held for path, held in left_.items() if journey.content.get(path) != held}
    if (size := sum(map(len, content.values()))) > MAX_TRANSFER_BYTES:
        return failed_answer(task, too_large("the files that it leaves", size))
    return replace(answer, content=content)


def too_large(what: str, size: int) -> str:
    """Return the message for content that is too large to be sent."""
    return (
        f"{what} have {size / 1e6:.0f} MB, and at most {MAX_TRANSFER_BYTES / 1e6:.0f} MB travel "
        "with a contact; "
        "put the project where all workers see it under the same path"
    )


def _is_same_file(path: Path, wanted: str) -> bool:
    try:
        return checksums.checksum_file(path) == wanted
    except OSError:
        return False


def _unpack_files(
    journey: FileTransfer, needed: Iterable[Path], read: Path, leftovers: Path | None
) -> dict[Path, Path]:
    """Write sent content into local files, and return the local paths of the inputs."""
    lie = {}
    for number, path in enumerate(needed):
        if path in journey.sums:
            # Inputs from different folders may have the same name.
            lie[path] = place = read / str(number) / path.name
        else:
            assert leftovers is not None
            place = _path_below(leftovers, path)
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_bytes(journey.content[path])
        if path in journey.sums and not _is_same_file(place, journey.sums[path]):
            raise InputError(f"{path} changed while the project ran; run it again")
    return lie


def _relocate_part(
    part: SubtaskRequest, lie: Mapping[Path, Path], leftovers: Path | None
) -> SubtaskRequest:
    """Return a part with local input and output files."""

    def written(path: Path) -> Path:
        if leftovers is None:
            return path
        place = _path_below(leftovers, path)
        place.parent.mkdir(parents=True, exist_ok=True)
        return place

    entry = part.entry
    request = entry.request.with_relocated_files(lambda path: lie.get(path, path), written)
    return replace(part, entry=replace(entry, request=request, summary=written(entry.summary)))


def _path_below(folder: Path, path: Path) -> Path:
    """Return a path, relative to its root, below a folder."""
    return folder / path.relative_to(path.anchor)


def _pack_outputs(leftovers: Path) -> dict[Path, bytes]:
    """Return the content of all files below a folder, by destination."""
    root = Path(Path.cwd().anchor)
    return {
        root / path.relative_to(leftovers): path.read_bytes()
        for path in sorted(leftovers.rglob("*"))
        if path.is_file()
    }
