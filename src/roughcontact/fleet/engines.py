"""Work through the contacts of a project: local processes."""

from __future__ import annotations

import json
import multiprocessing
import os
import signal
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed
from functools import partial
from multiprocessing.connection import Connection
from typing import Any

from roughcontact.errors import Mention, RoughcontactError, worded
from roughcontact.files import to_json, write
from roughcontact.fleet import plan
from roughcontact.fleet.plan import FAILED, KEPT, SOLVED, Entry, Report
from roughcontact.halfspace.fft import default_workers
from roughcontact.request import run as running


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
    """
    cores = default_workers()
    at_once = max(1, min(processes or cores, len(entries)))
    for folder in {entry.summary.parent for entry in entries}:
        folder.mkdir(parents=True, exist_ok=True)
    children: set[Any] = set()
    reports: dict[int, Report] = {}
    pool = ThreadPoolExecutor(at_once)
    try:
        futures = {
            pool.submit(_finish, entry, max(1, cores // at_once), children): number
            for number, entry in enumerate(entries)
        }
        for future in as_completed(futures):
            report = future.result()
            reports[futures[future]] = report
            told(report)
    finally:
        # After Ctrl-C nothing new is begun, and what is under way ends.
        pool.shutdown(wait=False, cancel_futures=True)
        for child in list(children):
            child.terminate()
    return [reports[number] for number in range(len(entries))]


def _finish(entry: Entry, threads: int, children: set[Any]) -> Report:
    digest = plan.digest_of(entry)
    before = plan.complete(entry, digest)
    if before is not None:
        return Report(entry.name, KEPT, before)
    context = multiprocessing.get_context("spawn")
    receiver, sender = context.Pipe(duplex=False)
    child = context.Process(target=_work, args=(entry, digest, threads, sender), daemon=True)
    child.start()
    children.add(child)
    sender.close()
    try:
        state, told, reason = receiver.recv()
    except EOFError:
        child.join()
        state, told = FAILED, {}
        reason = f"its process ended with status {child.exitcode}; is there enough memory?"
    child.join()
    children.discard(child)
    return Report(entry.name, state, told, reason)


def _work(entry: Entry, digest: str, threads: int, sender: Connection) -> None:
    """Do one contact in a process of its own."""
    # Ctrl-C reaches every process of the terminal; the first one ends the others.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "sched_setaffinity"):
        # The transforms take a thread for each core that the process may use.
        cores = sorted(os.sched_getaffinity(0))
        first = os.getpid() * threads % len(cores)
        os.sched_setaffinity(0, {cores[(first + k) % len(cores)] for k in range(threads)})
    try:
        sender.send(_done(entry, digest))
    except RoughcontactError as error:
        sender.send((FAILED, {}, error.worded(_words(entry))))
    except (OSError, MemoryError) as error:
        sender.send((FAILED, {}, f"{type(error).__name__}: {error}"))


def _words(entry: Entry) -> Callable[[Mention], str]:
    return partial(plan.spell_key, task=entry.request.task)


def _done(entry: Entry, digest: str) -> tuple[str, dict[str, Any], str]:
    outcome = running.run(entry.request, lambda text: None)
    if outcome.failure is not None:
        raise outcome.failure
    if not outcome.converged:
        return FAILED, {}, worded(outcome.shortfall.parts, _words(entry))
    # What is told of a single contact is at its own end.
    several = outcome.curve is not None or outcome.history is not None
    last = {"last": outcome.last} if several else {}
    text = to_json({**outcome.record(), **last, "run": digest})
    write(entry.summary, text + "\n")
    return SOLVED, json.loads(text), ""
