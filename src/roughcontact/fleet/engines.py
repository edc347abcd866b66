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
    at_once = max(1, min(processes or cores, len(entries)))
    folders = {entry.summary.parent for entry in entries}
    for folder in folders:
        folder.mkdir(parents=True, exist_ok=True)
    waiting = list(enumerate(entries))[::-1]
    working: dict[Connection, _Worker] = {}
    reports: dict[int, Report] = {}
    try:
        while waiting or working:
            while waiting and len(working) < at_once:
                number, entry = waiting.pop()
                digest = plan.digest_of(entry)
                before = plan.complete(entry, digest)
                if before is None:
                    _begin(working, number, entry, digest, max(1, cores // at_once))
                else:
                    reports[number] = Report(entry.name, KEPT, before)
                    told(reports[number])
            for worker in _ready(working):
                reports[worker.number] = worker.report()
                del working[worker.receiver]
                told(reports[worker.number])
    except KeyboardInterrupt:
        own.end(worker.process for worker in working.values())
        done = {number for number, report in reports.items() if report.state != FAILED}
        # Some may have been about to tell.
        done |= {worker.number for worker in working.values() if worker.is_complete()}
        summaries = [entries[number].summary for number in sorted(done)]
        raise outputs.UnfinishedError(summaries) from None
    finally:
        # Whatever came in between: what is under way ends, and leaves nothing half done.
        own.end(worker.process for worker in working.values())
        for folder in folders:
            files.clear(folder)
    return [reports[number] for number in range(len(entries))]


@dataclass(frozen=True)
class _Worker:
    """A process that works on one contact, and where it tells how that ended."""

    number: int
    entry: Entry
    digest: str
    process: SpawnProcess
    receiver: Connection

    def is_complete(self) -> bool:
        """Return whether the contact stands complete, told of or not."""
        return plan.complete(self.entry, self.digest) is not None

    def report(self) -> Report:
        """Return how it ended, once it has told or is gone."""
        try:
            state, told, reason = self.receiver.recv()
        except EOFError:
            state, told, reason = FAILED, {}, own.lost(self.process)
        self.process.join()
        self.receiver.close()
        return Report(self.entry.name, state, told, reason)


def _begin(
    working: dict[Connection, _Worker], number: int, entry: Entry, digest: str, threads: int
) -> None:
    """Begin with one contact, in a process of its own."""
    receiver, sender = own.pipe()
    process = own.made(_work, entry, digest, threads, sender)
    working[receiver] = _Worker(number, entry, digest, process, receiver)
    own.start(process)
    sender.close()


def _ready(working: Mapping[Connection, _Worker]) -> list[_Worker]:
    """Wait until some have told how they ended, or are gone."""
    if not working:
        return []
    ready = connection.wait(list(working))
    return [worker for receiver, worker in working.items() if receiver in ready]


# In a process of its own


def _work(entry: Entry, digest: str, threads: int, sender: Connection) -> None:
    """Do one contact."""
    with own.following():
        _hold(threads)
        try:
            sender.send(_done(entry, digest))
        except RoughcontactError as error:
            sender.send((FAILED, {}, error.worded(_words(entry))))
        except (OSError, MemoryError) as error:
            sender.send((FAILED, {}, f"{type(error).__name__}: {error}"))


def _hold(threads: int) -> None:
    """Keep to some of the cores: the transforms take a thread for each that one may use."""
    if hasattr(os, "sched_setaffinity"):
        cores = sorted(os.sched_getaffinity(0))
        first = os.getpid() * threads % len(cores)
        os.sched_setaffinity(0, {cores[(first + k) % len(cores)] for k in range(threads)})


def _words(entry: Entry) -> Callable[[Mention], str]:
    return partial(plan.spell_key, task=entry.request.task)


def _done(entry: Entry, digest: str) -> tuple[str, dict[str, Any], str]:
    outcome = running.run(entry.request, _nothing)
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
