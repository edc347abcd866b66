"""Figures as PNG files, shared out to several processes: Matplotlib draws on one core."""

from __future__ import annotations

import contextlib
import os
import pickle
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from roughcontact import memory
from roughcontact.plots.saving import png

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Drawing = Callable[[], "Figure"]

# Their numbers are single bytes.
_MOST = 256


def pngs(drawings: Sequence[Drawing], processes: int = 1) -> list[bytes]:
    """Draw figures and return each as the content of a PNG file.

    Parameters
    ----------
    drawings : sequence of callable
        What draws each of them.
    processes : int
        How many may draw at a time: forks of this one, where there are such and memory for them.
        They are for a program of its own, which knows its threads; others stay with one.

    Returns
    -------
    list of bytes
        The same bytes with any number of processes.
    """
    found: dict[int, bytes] = {}
    many = min(processes, len(drawings), _affordable() if processes > 1 else 1)
    if many > 1 and len(drawings) <= _MOST:
        found = _shared(drawings, many)
    # What a process has failed in is drawn here, to the same error.
    return [
        found[number] if number in found else png(draw()) for number, draw in enumerate(drawings)
    ]


def _affordable() -> int:
    """Return how many processes may draw, even if each comes to need a copy of all that is here."""
    # Libraries of macOS do not bear it.
    if not hasattr(os, "fork") or sys.platform == "darwin":
        return 1
    return 1 + memory.free() // memory.held()


def _shared(drawings: Sequence[Drawing], processes: int) -> dict[int, bytes]:
    """Return what this process and its forks have drawn, by number."""
    # Before it forks: loaded once.
    import matplotlib.backends.backend_agg  # noqa: F401 - for what it loads

    left, numbers = os.pipe()
    # Closed with this process, however it ends: nobody waits for figures any more.
    here, alive = os.pipe()
    # The last figures are the largest ones, and the small ones fill up the end.
    os.write(numbers, bytes(reversed(range(len(drawings)))))
    os.close(numbers)
    helpers: dict[int, int] = {}
    try:
        for _ in range(processes - 1):
            _fork(helpers, left, (here, alive), drawings)
        found = _drawn(left, drawings)
        for helper, answer in list(helpers.items()):
            with os.fdopen(answer, "rb", closefd=False) as stream:
                told = stream.read()
            del helpers[helper]
            os.close(answer)
            if os.waitpid(helper, 0)[1] == 0:
                found |= pickle.loads(told)
        return found
    finally:
        for end in (left, here, alive):
            os.close(end)
        _end(helpers)


def _fork(
    helpers: dict[int, int], left: int, life: tuple[int, int], drawings: Sequence[Drawing]
) -> None:
    """Begin a process that draws, and keep by its number where it answers."""
    answer, told = os.pipe()
    # Python warns developers of forks beside threads, which may hold a lock that a fork then waits
    # for. Those that solve are at rest, and what draws has nothing to do with them.
    with _deaf() as before:
        helper = os.fork()
        if helper == 0:
            _help(left, told, life, drawings, before)
        helpers[helper] = answer
    os.close(told)


def _help(
    left: int,
    told: int,
    life: tuple[int, int],
    drawings: Sequence[Drawing],
    before: set[signal.Signals],
) -> None:
    """Draw in a process of its own, tell what, and end without a word, whatever happens."""
    status = 1
    try:
        os.close(life[1])
        threading.Thread(target=_follow, args=(life[0],), daemon=True).start()
        # The first process ends it.
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        for asking in (signal.SIGTERM, signal.SIGHUP):
            signal.signal(asking, signal.SIG_DFL)
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        with os.fdopen(told, "wb") as stream:
            stream.write(pickle.dumps(_drawn(left, drawings)))
        status = 0
    finally:
        os._exit(status)


def _follow(here: int) -> None:
    """End with the process that began this one, in the midst of a figure."""
    os.read(here, 1)
    os._exit(1)


def _drawn(left: int, drawings: Sequence[Drawing]) -> dict[int, bytes]:
    """Draw what is left, one after the other; all processes read their numbers from one pipe."""
    found = {}
    while number := os.read(left, 1):
        found[number[0]] = png(drawings[number[0]]())
    return found


@contextmanager
def _deaf() -> Iterator[set[signal.Signals]]:
    """Put off the signals that end the program, and give which were put off before."""
    asking = {signal.SIGINT, signal.SIGTERM, signal.SIGHUP}
    before = signal.pthread_sigmask(signal.SIG_BLOCK, asking)
    try:
        yield {signal.Signals(number) for number in before}
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _end(helpers: Mapping[int, int]) -> None:
    """End processes whose figures nobody waits for; they write no files."""
    for helper, answer in helpers.items():
        os.close(answer)
        with contextlib.suppress(ProcessLookupError):
            os.kill(helper, signal.SIGKILL)
        with contextlib.suppress(ChildProcessError):
            os.waitpid(helper, 0)
