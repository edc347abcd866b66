"""Terminal output: progress line, error messages, and closed pipes."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from enum import Enum, auto
from typing import TYPE_CHECKING, TextIO

from roughcontact._tools import processes
from roughcontact._tools.text import join_words, replace_unprintable
from roughcontact.analyses.solve import task as solve
from roughcontact.errors import message_parts, render_message, shorten_message
from roughcontact.request.task import Command
from roughcontact.solvers.progress import Forecast, Progress
from roughcontact.units import format_duration

if TYPE_CHECKING:
    from rich.text import Text

SOLVED, NOT_CONVERGED, BAD_INPUT = 0, 1, 2
"""Exit status of a command."""

# Last file descriptor of the standard streams.
_LAST_STREAM = 2


def open_streams() -> None:
    """Redirect closed standard streams to the null device; escape unencodable text."""
    if sys.stdin is None or sys.stdout is None or sys.stderr is None:
        while (null := os.open(os.devnull, os.O_RDWR)) <= _LAST_STREAM:
            os.set_inheritable(null, True)
        os.close(null)
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: PTH123, SIM115
    for stream in (sys.stdout, sys.stderr):
        # The encoding of the terminal may lack characters of a file name.
        with contextlib.suppress(AttributeError, ValueError):
            stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]


PROGRESS_INTERVAL = 10.0
"""Interval between progress lines without a terminal [s]."""

PROGRESS_PREFIX = "progress: "
"""Prefix of progress lines without a terminal."""


class DisplayOptions(Enum):
    """Console output of a result."""

    BRIEF = auto()
    VERBOSE = auto()
    JSON = auto()
    QUIET = auto()


class ProgressLine:
    """Line that shows the running step and the remaining time."""

    def __init__(self) -> None:
        self._text, self._end, self._forecast = "", 0.0, Forecast()

    def set_stage(self, text: str, seconds: float = 0.0) -> None:
        """Set the text of the current stage, and its remaining time [s], 0 if unknown."""
        self._text, self._end = text, time.monotonic() + seconds if seconds else 0.0

    def update(self, state: Progress) -> None:
        """Show the progress of a calculation."""
        from roughcontact.report import phrases

        self.set_stage(phrases.progress_text(state), self._forecast(state))

    @property
    def seconds(self) -> float:
        """Remaining time [s]; 0 if unknown."""
        return max(self._end - time.monotonic(), 0.0)

    def __str__(self) -> str:
        """Return the line as text."""
        left = f", about {format_duration(self.seconds)} left" if self.seconds else ""
        return replace_unprintable(self._text) + left

    def __rich__(self) -> Text:
        """Return the line for Rich, which redraws it a few times a second."""
        from rich.text import Text

        return Text(str(self))


@contextlib.contextmanager
def show_progress(quiet: bool = False) -> Iterator[ProgressLine]:
    """Show progress on standard error, as a live line, or as lines without a terminal."""
    line = ProgressLine()
    if quiet:
        yield line
    elif sys.stderr.isatty():
        from rich.console import Console

        with Console(stderr=True, highlight=False).status(line):
            yield line
    else:
        ended = threading.Event()
        # A separate thread prints also while a calculation reports no progress.
        printing = threading.Thread(target=_print_lines, args=(line, ended), daemon=True)
        printing.start()
        try:
            yield line
        finally:
            ended.set()
            printing.join()


def _print_lines(line: ProgressLine, ended: threading.Event) -> None:
    """Print a line early if at least 2 s remain, and then every 10 s."""
    soon, waited, printed = PROGRESS_INTERVAL / 5, 0.0, False
    while not ended.wait(soon):
        waited += soon
        if waited < PROGRESS_INTERVAL and (printed or line.seconds < soon):
            continue
        waited, printed = 0.0, True
        with contextlib.suppress(OSError, ValueError):
            print(f"{PROGRESS_PREFIX}{join_words(str(line))}", file=sys.stderr, flush=True)


@contextlib.contextmanager
def handle_stop_signals() -> Iterator[list[int]]:
    """Raise KeyboardInterrupt on termination signals; yield the list of those received."""
    came: list[int] = []

    def stop(number: int, frame: object) -> None:
        # `timeout` sends it twice; the second signal must not interrupt the handling of the first.
        for asking in ours:
            signal.signal(asking, signal.SIG_IGN)
        came.append(number)
        processes.silence_unraisable()
        raise KeyboardInterrupt

    ours = _unhandled_signals()
    for asking in ours:
        signal.signal(asking, stop)
    try:
        yield came
    finally:
        for asking in ours:
            signal.signal(asking, signal.SIG_DFL)


def _unhandled_signals() -> list[signal.Signals]:
    """Return the termination signals that neither `nohup` nor the caller handles."""
    if threading.current_thread() is not threading.main_thread():
        return []
    known = [number for number in signal.Signals if number.name in ("SIGTERM", "SIGHUP")]
    return [number for number in known if signal.getsignal(number) is signal.SIG_DFL]


def spell_options(text: str, command: Command = solve.TASK) -> str:
    """Return a text with its arguments spelled as options of a command."""
    return render_message(message_parts(text), command.spell_argument)


def print_error(sentence: str) -> None:
    """Flush standard output, and print one sentence on standard error."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        sys.stdout.flush()
    try:
        print(f"roughcontact: {shorten_message(join_words(sentence))}", file=sys.stderr, flush=True)
    except (OSError, ValueError):
        _discard_output(sys.stderr)


def discard_output() -> None:
    """Discard standard output if it is closed, so that the exit does not fail again."""
    try:
        sys.stdout.flush()
    except (OSError, ValueError):
        _discard_output(sys.stdout)


def _discard_output(stream: TextIO) -> None:
    with contextlib.suppress(OSError, ValueError, AttributeError):
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, stream.fileno())
        os.close(null)
