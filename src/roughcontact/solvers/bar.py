"""A line that tells how far a calculation is, in terminals and notebooks alike."""

from __future__ import annotations

import functools
import math
import sys
from collections.abc import Callable
from typing import ParamSpec, TextIO, TypeVar

from roughcontact.solvers.progress import Progress

P = ParamSpec("P")
R = TypeVar("R")

_WIDTH = 24


class Bar:
    """Draws a `Progress` on one line, over the one before.

    Parameters
    ----------
    stream : file
        Where to; carriage returns begin the line anew in a terminal as in a notebook.

    Examples
    --------
    >>> bar = Bar(sys.stdout)
    >>> bar(Progress(3, 4, None, "", kept=True))  # doctest: +SKIP
    ██████████████████       3 of 4, kept from before
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream, self._length = stream, 0
        # Certificate or residual at the beginning of each part, from which it falls.
        self._first: dict[int, float] = {}

    def __call__(self, at: Progress) -> None:
        """Draw the line anew."""
        part = 1.0 if at.kept else self._part(at)
        done = (at.number - 1 + part) / max(at.count, 1)
        told = [at.label] if at.label else []
        if at.count > 1:
            told.append(f"{at.number} of {at.count}")
        if at.kept:
            told.append("kept from before")
        elif at.step is not None:
            told.append(f"{_error(at):.0e}, target {at.step.tolerance:.0e}")
        filled = round(_WIDTH * min(max(done, 0.0), 1.0))
        self._draw(f"{'█' * filled:{_WIDTH}} {', '.join(told)}")

    def close(self) -> None:
        """Leave the line as it is, and the next one to others."""
        if self._length:
            self._write("\n")
        self._length = 0

    def _part(self, at: Progress) -> float:
        """Return how much of a part is done: errors fall by about as much each time."""
        if at.step is None:
            return 0.0
        error, tolerance = _error(at), at.step.tolerance
        first = self._first.setdefault(at.number, max(error, 2 * tolerance))
        if not (0 < error < math.inf and first < math.inf):
            return 0.0
        return min(max(math.log(first / error) / math.log(first / tolerance), 0.0), 1.0)

    def _draw(self, line: str) -> None:
        self._write("\r" + line.ljust(self._length))
        self._length = len(line)

    def _write(self, text: str) -> None:
        # Nobody may look; that is no reason to stop.
        try:
            self._stream.write(text)
            self._stream.flush()
        except (OSError, ValueError):
            self._length = 0


def _error(at: Progress) -> float:
    """Return the certificate of a contact, or the residual of the volume."""
    known = at.step.residual if hasattr(at.step, "residual") else at.step.certificate
    return float(known)


def drawn(function: Callable[P, R]) -> Callable[P, R]:
    """Let a function that takes ``progress`` draw a `Bar` on standard error if it is ``True``."""

    @functools.wraps(function)
    def call(*positional: P.args, **named: P.kwargs) -> R:
        if named.get("progress") is not True:
            return function(*positional, **named)
        bar = Bar(sys.stderr)
        named["progress"] = bar
        try:
            return function(*positional, **named)
        finally:
            bar.close()

    return call
