"""Run the contacts of a project on an executor."""

from __future__ import annotations

import math
import os
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from roughcontact._tools import files, ranks
from roughcontact.analyses.tasks import DASK, LOCAL
from roughcontact.batch import jobs, plan
from roughcontact.batch.executors import AWAY, GONE, THERE, Engine, local_processes
from roughcontact.batch.plan import FAILED, KEPT, SOLVED, Entry, Report
from roughcontact.errors import ArgumentRef, InputError
from roughcontact.halfspace.fft import default_workers
from roughcontact.request.options import FOLDER
from roughcontact.request.outputs import Saved, UnfinishedError

T = TypeVar("T")

_TRIES = 3
"""How often a contact is handed out whose scheduler is lost."""
_ALONE = 0
"""Marks a retry without other contacts in parallel."""


@contextmanager
def opened(
    load: Callable[[], T],
    count: Callable[[T], int],
    kind: str = LOCAL,
    workers: int | None = None,
    scheduler: str | None = None,
) -> Iterator[tuple[Engine, T]]:
    """Read what is to be done, and give an engine for it."""
    if scheduler is not None and (kind != DASK or workers is not None):
        raise InputError(
            "is that of a cluster with workers of its own: it needs ", ArgumentRef("engine", DASK),
            " and goes without ", ArgumentRef("workers"), argument="scheduler",
        )  # fmt: skip
    if ranks.is_parallel_run():
        raise InputError(
            "mpiexec started several of these, each of which would do all of it: start a single one"
        )
    read = load()
    several = _at_once(count(read), workers)
    if kind == DASK:
        from roughcontact.batch import executors

        with executors.connected(scheduler, several) as engine:
            yield engine, read
    else:
        with local_processes(several) as engine:
            yield engine, read


def _at_once(count: int, workers: int | None = None) -> int:
    """Return how many processes of this machine have something to do."""
    return max(1, min(workers or default_workers(), count))


def tasks(entries: list[Entry]) -> int:
    """Return how many tasks of a project may go on at a time."""
    return sum(max(1, len(_subtask_ids(contact))) for contact in _contacts(entries))


def _silent(text: str) -> None:
    """Say nothing."""


def run(
    entries: list[Entry],
    text: Callable[[Report], None],
    engine: Engine | None = None,
    *,
    say: Callable[[str], None] = _silent,
    warn: Callable[[str], None] = _silent,
) -> list[Report]:
    """Work through the contacts of a project, several at a time."""
    with ExitStack() as stack:
        if engine is None:
            engine = stack.enter_context(local_processes(_at_once(tasks(entries))))
        folders = {entry.summary.parent for entry in entries}
        for folder in {entry.request.get(FOLDER) for entry in entries}:
            if folder is not None:
                stack.callback(_clear, folder)
        marks = {}
        for folder in folders:
            folder.mkdir(parents=True, exist_ok=True)
            # Whatever comes in between leaves nothing half done.
            stack.callback(files.clear, folder)
            if engine.far:
                marks[folder] = _resolved(stack.enter_context(files.marked(folder)))
        return _Run(entries, _Tell(text, say, warn), engine, marks).reports()


# Seconds after which it is looked whether an engine that is silent is there.
_LOOKS = 2.0
# Seconds from look to look at one that is away.
_PAUSE = 0.1
# Seconds without workers that are not worth a word: one that has died is begun again.
_UNNOTICED = 5.0


class _Tell(NamedTuple):
    """Whom to tell how it goes, see `run`."""

    report: Callable[[Report], None]
    say: Callable[[str], None]
    warn: Callable[[str], None]


class _Run:
    """The contacts of a project that are under way, and how those ended that are not."""

    def __init__(
        self,
        entries: list[Entry],
        tell: _Tell,
        engine: Engine,
        marks: Mapping[Path, Path],
    ) -> None:
        self._entries, self._tell, self._engine, self._marks = entries, tell, engine, marks
        self._reports: dict[int, Report] = {}
        self._waiting = deque(_contacts(entries))
        # With how often they were handed out before.
        self._ready: deque[tuple[jobs.Task, int]] = deque()
        # What is found of contacts in pieces, and why others could not be, by number and word.
        self._pieces: dict[int, dict[str, Any]] = {}
        self._failed: dict[int, dict[str, str]] = {}
        # Checksums of the files that each contact reads.
        self._read: dict[int, dict[Path, str | None]] = {}
        # What each of them depends on.
        self._digests: dict[int, dict[str, str]] = {}
        # Time since which no worker is connected, whether it was reported, and the reason.
        self._lonely, self._warned, self._closed = math.inf, False, ""
        self._under_way: dict[Future[jobs.Answer], tuple[jobs.Task, int]] = {}
        # Lost with a worker that had others, too: tried again one by one in the end.
        self._suspects: deque[jobs.Task] = deque()
        # Files that some worker does not see are sent to all of them.
        self._sent: set[Path] = set()
        self._checksums: dict[object, str | None] = {}

    def reports(self) -> list[Report]:
        """Work through all contacts."""
        try:
            while self._waiting or self._ready or self._under_way or self._suspects:
                state = self._engine.state()
                self._look_for_workers(state)
                if state != AWAY:
                    self._fill()
                if not self._under_way:
                    time.sleep(_PAUSE if state == AWAY else 0)
                    continue
                ended, _ = wait(self._under_way, _LOOKS, FIRST_COMPLETED)
                if state == GONE or self._closed:
                    ended = set(self._under_way)
                for future in ended:
                    future.cancel()
                    self._take(future, *self._under_way.pop(future))
        except KeyboardInterrupt:
            self._engine.stop()
            raise UnfinishedError(*self._complete()) from None
        return [self._reports[number] for number in range(len(self._entries))]

    def _look_for_workers(self, state: str) -> None:
        """Warn where there are no workers, and end the work where none has come for long."""
        if state != THERE or self._engine.slots():
            self._lonely, self._warned = math.inf, False
            return
        now = time.monotonic()
        self._lonely = min(self._lonely, now)
        whose, patience = self._engine.workers, self._engine.patience
        if now - self._lonely > patience:
            self._closed = f"there were no workers {whose} for {patience / 60:.3g} min"
        elif now - self._lonely > _UNNOTICED and not self._warned:
            self._tell.warn(f"waiting for workers {whose}, {patience / 60:.3g} min at most")
            self._warned = True

    def _fill(self) -> None:
        """Submit up to twice as many contacts as run in parallel, so that no worker is idle."""
        maximum = 2 * max(1, self._engine.slots())
        while len(self._under_way) < maximum and (self._ready or self._waiting):
            if self._ready:
                self._hand_out(*self._ready.popleft())
            else:
                self._ready.extend(
                    (task, 1) for task in self._remaining_tasks(self._waiting.popleft())
                )
        if self._suspects and not self._under_way:
            self._hand_out(self._suspects.popleft(), _ALONE)

    def _remaining_tasks(self, contact: Contact) -> list[jobs.Task]:
        """Return the remaining parts of a contact, and report the finished ones."""
        parts = []
        for number, entry in contact:
            digest = plan.digest_of(entry, self._content)
            before = plan.complete(entry, digest)
            if before is None:
                places = tuple(str(path) for _, path in entry.request.places)
                self._read[number] = {path: self._content(path) for path in entry.request.inputs}
                parts.append(jobs.Part(number, entry, digest, places))
            else:
                self._record(number, Report(entry.name, KEPT, before))
        if not parts:
            return []
        whole = jobs.Task(tuple(parts), self._engine.threads)
        words = _subtask_ids(contact)
        if not words:
            return [self._equipped(whole)]
        (part,) = parts
        digests = {word: plan.digest_of(part.entry, self._content, word) for word in words}
        self._digests[part.number] = digests
        known = self._pieces[part.number] = plan.load_subtasks(part.entry, digests)
        if known:
            self._tell.say(f"{len(known)} of {len(words)} pieces of {part.entry.name} kept")
        separately = [replace(whole, piece=word) for word in words if word not in known]
        return [self._equipped(task) for task in separately] or [self._joined(part)]

    def _content(self, path: Path) -> str | None:
        """Return the checksum of a file, of one that many contacts read once."""
        try:
            about = path.stat()
        except OSError:
            return None
        key = path, about.st_dev, about.st_ino, about.st_size, about.st_mtime_ns
        if key not in self._checksums:
            self._checksums[key] = plan.content_of(path)
        return self._checksums[key]

    def _equipped(self, task: jobs.Task) -> jobs.Task:
        """Return a task with all that a worker needs that may be on another machine."""
        if not self._engine.far:
            return task
        entries = [part.entry for part in task.parts]
        read = {path: _resolved(path) for path in task.inputs}
        sums = {lies: self._content(path) for path, lies in read.items()}
        folders = {folder for item in entries if (folder := item.request.get(FOLDER)) is not None}
        outputs = (
            path for folder in folders for path in sorted(folder.rglob("*")) if path.is_file()
        )
        parts = tuple(
            replace(part, entry=replace(
                part.entry, summary=_resolved(part.entry.summary),
                request=part.entry.request.with_relocated_files(_resolved, _resolved),
            ))
            for part in task.parts
        )  # fmt: skip
        known = {path: checksum for path, checksum in sums.items() if checksum is not None}
        mark = self._marks[entries[0].summary.parent]
        return replace(
            task,
            parts=parts,
            journey=jobs.FileTransfer(mark, known, tuple(map(_resolved, outputs))),
        )

    def _hand_out(self, task: jobs.Task, tries: int) -> None:
        if self._closed:
            return self._end(task, jobs.failed_answer(task, self._closed))
        try:
            task = self._packed(task)
            self._under_way[self._engine.executor.submit(jobs.run_task, task)] = task, tries
        except OSError as error:
            self._end(task, jobs.failed_answer(task, f"{type(error).__name__}: {error}"))
        except Exception as error:
            # Whatever an engine says that takes no more.
            self._end(task, jobs.failed_answer(task, self._engine.lost(error)))

    def _packed(self, task: jobs.Task) -> jobs.Task:
        """Return a task with the content of those of its files that not all workers see."""
        if task.journey is None:
            return task
        needed = [
            path for path in (*task.journey.sums, *task.journey.checkpoints) if path in self._sent
        ]
        size = sum(path.stat().st_size for path in needed)
        if size > jobs.MOST:
            raise OSError(jobs.too_large("its files", size))
        content = {path: path.read_bytes() for path in needed}
        return replace(task, journey=replace(task.journey, content=content))

    def _take(self, future: Future[jobs.Answer], task: jobs.Task, tries: int) -> None:
        """Handle the result of a worker."""
        try:
            answer = future.result()
        except CancelledError as error:
            if tries < _TRIES and not self._closed:
                return self._ready.append((task, tries + 1))
            answer = jobs.failed_answer(task, self._closed or self._engine.lost(error))
        except Exception as error:
            if tries != _ALONE and self._engine.shared(error):
                return self._suspects.append(task)
            answer = jobs.failed_answer(task, self._engine.lost(error))
        if answer.lacking:
            self._sent.update(answer.lacking)
            return self._ready.append((task, tries))
        return self._end(task, answer)

    def _collect(self, task: jobs.Task, answer: jobs.Answer) -> None:
        """Store the result of a piece; submit the whole contact after its last piece."""
        (part,) = task.parts
        number, entry = part.number, self._entries[part.number]
        result, failed = self._pieces[number], self._failed.setdefault(number, {})
        if answer.reports:
            failed[task.piece] = answer.reports[number].reason
        else:
            result[task.piece] = answer.result
            plan.keep(entry, self._digests[number][task.piece], answer.result)
            few = f"{len(result)} of {len(self._digests[number])}"
            self._tell.say(f"{few} pieces of {entry.name} found")
        if len(result) + len(failed) < len(self._digests[number]):
            return
        if failed:
            self._record(number, Report(entry.name, FAILED, {}, _reasons(failed.values())))
        else:
            self._ready.appendleft((self._joined(part), 1))

    def _joined(self, part: jobs.Part) -> jobs.Task:
        """Return the rest of a contact of which all pieces are found."""
        own = replace(part, entry=self._entries[part.number])
        known = self._pieces.pop(part.number)
        return self._equipped(jobs.Task((own,), self._engine.threads, known=known))

    def _end(self, task: jobs.Task, answer: jobs.Answer) -> None:
        """Report the end of each part of a contact; complete output counts as solved."""
        changed = self._changed(task)
        if changed is not None:
            answer = jobs.failed_answer(
                task, f"{changed} changed while the project ran; run it again"
            )
        if task.piece:
            self._collect(task, answer)
            return
        try:
            for part in task.parts if changed is not None else ():
                self._entries[part.number].summary.unlink(missing_ok=True)
            # The summaries last: with them a contact is complete.
            summaries = {part.entry.summary for part in task.parts}
            for path in sorted(answer.content, key=lambda path: path in summaries):
                path.parent.mkdir(parents=True, exist_ok=True)
                files.write(path, answer.content[path])
        except OSError as error:
            answer = jobs.failed_answer(task, f"{type(error).__name__}: {error}")
        for number, report in answer.reports.items():
            (part,) = (part for part in task.parts if part.number == number)
            if report.state == FAILED:
                before = plan.complete(self._entries[number], part.digest)
                report = report if before is None else Report(report.name, SOLVED, before)
            self._record(number, report)

    def _changed(self, task: jobs.Task) -> Path | None:
        """Return a file that changed since the run began."""
        for part in task.parts:
            for path, checksum in self._read[part.number].items():
                if checksum is not None and self._content(path) != checksum:
                    return path
        return None

    def _record(self, number: int, report: Report) -> None:
        self._reports[number] = report
        if report.state == SOLVED:
            entry = self._entries[number]
            # A later version may compare further maps.
            pieces = entry.request.task.pieces
            of_maps = pieces is not None and pieces.file_of is not None
            lasting = self._digests.get(number, {}) if of_maps else {}
            plan.drop(entry, lasting.values())
        self._tell.report(report)

    def _complete(self) -> tuple[list[Path], Saved]:
        """Return the summaries of complete contacts, and the contacts that are in pieces."""
        done_ = {number for number, report in self._reports.items() if report.state != FAILED}
        for task, _ in self._under_way.values():
            done_ |= {
                part.number for part in task.parts
                if plan.complete(part.entry, part.digest) is not None
            }  # fmt: skip
        places = {number: plan.place_of(entry) for number, entry in enumerate(self._entries)}
        begun = [place for number, place in places.items() if number not in done_]
        whole = [self._entries[number].summary for number in sorted(done_)]
        saved = Saved(len(whole), len(places), "contact", self._entries[0].summary.parent)
        return whole + [place for place in begun if place.exists()], saved


# The entries of one contact with their numbers.
Contact = list[tuple[int, Entry]]


def _contacts(entries: list[Entry]) -> list[Contact]:
    """Return the entries, contact by contact."""
    result: dict[int, Contact] = {}
    for number, entry in enumerate(entries):
        result.setdefault(entry.contact, []).append((number, entry))
    return list(result.values())


def _subtask_ids(contact: Contact) -> tuple[str, ...]:
    """Return the pieces of a contact; none of one of which several things are asked."""
    return contact[0][1].request.subtask_ids() if len(contact) == 1 else ()


# Reasons that are named one by one.
_FEW = 8


def _reasons(text: Iterable[str]) -> str:
    """Return why pieces of a contact failed, each reason once."""
    different = list(dict.fromkeys(text))
    more = len(different) - _FEW
    return "; ".join(different[:_FEW] + ([f"and {more} more"] if more > 0 else []))


def _clear(folder: Path) -> None:
    """Remove what killed processes left in the folder of the steps or passes of a contact."""
    for place in (folder, *folder.glob("*/")):
        files.clear(place)


def _resolved(path: Path) -> Path:
    """Return where a file lies, from the root on and under its own name."""
    # A link to itself stays as it is; the reader reports the error.
    return Path(os.path.realpath(path.parent)) / path.name
