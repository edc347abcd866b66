"""Work through the contacts of a project: local processes."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from multiprocessing import connection
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from typing import Any

from roughcontact import files, processes as own
from roughcontact.errors import Mention, RoughcontactError, worded
from roughcontact.fleet import plan
from roughcontact.fleet.plan import FAILED, KEPT, SOLVED, Entry, Report
from roughcontact.halfspace.fft import default_workers
from roughcontact.request import outputs, run as running


def run(
    entries: list[Entry], told: Callable[[Report], None], processes: int | None = None
) -> list[Report]:
    """Work through the contacts of a project, several at a time.

    Parameters
    ----------
    entries : list of Entry
        From `load`.
    told : callable
        Called with each `Report` as it comes.
    processes : int, optional
        How many at a time; by default one for each core. Cores that are left over are shared.

    Returns
    -------
    list of Report
        In the order of the entries. A contact that fails, even by a crash, does not stop the
        others; one that was solved before from the same options and files is kept.

    Notes
    -----
    The processes end within a second of this one, however it ends, and of the call.
    """
    cores = default_workers()
    folders = {entry.summary.parent for entry in entries}
    for folder in folders:
        folder.mkdir(parents=True, exist_ok=True)
    reports: dict[int, Report] = {}

    def tell(number: int, report: Report) -> None:
        reports[number] = report
        told(report)

    waiting = _contacts(entries)[::-1]
    at_once = max(1, min(processes or cores, len(waiting)))
    working: dict[Connection, _Worker] = {}
    try:
        while waiting or working:
            while waiting and len(working) < at_once:
                job = _left(waiting.pop(), tell)
                if job:
                    _begin(working, job, max(1, cores // at_once))
            for worker in _ready(working):
                found = worker.reports()
                if not found:
                    del working[worker.receiver]
                    found = worker.ended(reports)
                for number, report in found:
                    tell(number, report)
    except KeyboardInterrupt:
        own.end(worker.process for worker in working.values())
        done = {number for number, report in reports.items() if report.state != FAILED}
        # Some may have been about to tell.
        done |= {number for worker in working.values() for number in worker.complete()}
        summaries = [entries[number].summary for number in sorted(done)]
        raise outputs.UnfinishedError(summaries) from None
    finally:
        # Whatever came in between: what is under way ends, and leaves nothing half done.
        own.end(worker.process for worker in working.values())
        for folder in folders:
            files.clear(folder)
    return [reports[number] for number in range(len(entries))]


@dataclass(frozen=True)
class _Part:
    """One thing that is asked of a contact: its number among the entries, and its digest."""

    number: int
    entry: Entry
    digest: str


# What is asked of one contact.
Job = tuple[_Part, ...]


def _contacts(entries: list[Entry]) -> list[list[tuple[int, Entry]]]:
    """Return the entries with their numbers, contact by contact."""
    found: dict[int, list[tuple[int, Entry]]] = {}
    for number, entry in enumerate(entries):
        found.setdefault(entry.contact, []).append((number, entry))
    return list(found.values())


def _left(contact: list[tuple[int, Entry]], tell: Callable[[int, Report], None]) -> Job:
    """Return what is to be done of a contact, and tell of what was done before."""
    left = []
    for number, entry in contact:
        digest = plan.digest_of(entry)
        before = plan.complete(entry, digest)
        if before is None:
            left.append(_Part(number, entry, digest))
        else:
            tell(number, Report(entry.name, KEPT, before))
    return tuple(left)


@dataclass(frozen=True)
class _Worker:
    """A process that works on one contact, and where it tells how each part of it ended."""

    job: Job
    process: SpawnProcess
    receiver: Connection

    def complete(self) -> list[int]:
        """Return the parts that stand complete, told of or not."""
        return [
            part.number for part in self.job if plan.complete(part.entry, part.digest) is not None
        ]

    def reports(self) -> list[tuple[int, Report]]:
        """Return how the next part ended; nothing where no other follows."""
        try:
            number, state, told, reason = self.receiver.recv()
        except EOFError:
            return []
        (part,) = (part for part in self.job if part.number == number)
        return [(number, Report(part.entry.name, state, told, reason))]

    def ended(self, told: Mapping[int, Report]) -> list[tuple[int, Report]]:
        """Return the parts that are lost with the process, which is gone."""
        self.process.join()
        self.receiver.close()
        return [
            (part.number, Report(part.entry.name, FAILED, {}, own.lost(self.process)))
            for part in self.job
            if part.number not in told
        ]


def _begin(working: dict[Connection, _Worker], job: Job, threads: int) -> None:
    """Begin with one contact, in a process of its own."""
    receiver, sender = own.pipe()
    process = own.made(_work, job, threads, sender)
    working[receiver] = _Worker(job, process, receiver)
    own.start(process)
    sender.close()


def _ready(working: Mapping[Connection, _Worker]) -> list[_Worker]:
    """Wait until some have told how they ended, or are gone."""
    if not working:
        return []
    ready = connection.wait(list(working))
    return [worker for receiver, worker in working.items() if receiver in ready]


# In a process of its own


def _work(job: Job, threads: int, sender: Connection) -> None:
    """Do all that is asked of one contact."""
    with own.following(), running.together() as carry_out:
        _hold(threads)
        for part in job:
            try:
                how = _done(part, carry_out)
            except RoughcontactError as error:
                how = FAILED, {}, error.worded(_words(part.entry))
            except (OSError, MemoryError) as error:
                how = FAILED, {}, f"{type(error).__name__}: {error}"
            sender.send((part.number, *how))


def _hold(threads: int) -> None:
    """Keep to some of the cores: the transforms take a thread for each that one may use."""
    if hasattr(os, "sched_setaffinity"):
        cores = sorted(os.sched_getaffinity(0))
        first = os.getpid() * threads % len(cores)
        os.sched_setaffinity(0, {cores[(first + k) % len(cores)] for k in range(threads)})


def _words(entry: Entry) -> Callable[[Mention], str]:
    return partial(plan.spell_key, task=entry.request.task)


def _done(
    part: _Part, carry_out: Callable[..., running.Outcome]
) -> tuple[str, dict[str, Any], str]:
    entry, digest = part.entry, part.digest
    outcome = carry_out(entry.request, _nothing)
    if outcome.failure is not None:
        raise outcome.failure
    if not outcome.converged:
        return FAILED, {}, worded(outcome.shortfall.parts, _words(entry))
    # What is told of a single contact is at its own end.
    many = (outcome.curve, outcome.history, outcome.loads, outcome.joint, outcome.comparison)
    several = any(one is not None for one in many)
    last = {"last": outcome.last} if several else {}
    told = plan.sealed({**outcome.record(), **last}, digest, outcome.written)
    text = files.to_json(told) + "\n"
    outputs.write([(entry.summary, partial(files.write, content=text))], _nothing)
    return SOLVED, told, ""


def _nothing(text: str) -> None:
    """Say nothing."""
