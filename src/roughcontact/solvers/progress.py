"""How far a calculation is: what it tells whoever watches."""

from __future__ import annotations

import functools
import math
import sys
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Any, ParamSpec, TextIO, TypeVar

from roughcontact.errors import ArgumentRef, Sentence


class Status(Enum):
    """Why the solver stopped; each value is its own advice."""

    CONVERGED = "converged"
    CONVOLUTION_LIMIT = Sentence(
        f"stopped at {ArgumentRef('max_iterations')}; allow more, or start from a nearby solution"
    )
    STALLED = (
        "no further progress; the tolerance may lie below the rounding error of this problem "
        "(single precision promises 1e-4)"
    )
    INTERRUPTED = "interrupted"


@dataclass(frozen=True)
class Step:
    """State of the solver after a check of the whole map.

    Parameters
    ----------
    shape : (int, int)
        Grid of the level at work; coarser than the map while the first pressure is sought.
    iteration : int
        Active-set steps on this level so far.
    convolutions : int
        Convolutions on this level so far.
    certificate : float
        ε of the pressure at hand.
    tolerance : float
        ε at which this level ends.
    """

    shape: tuple[int, int]
    iteration: int
    convolutions: int
    certificate: float
    tolerance: float


@dataclass(frozen=True)
class Progress:
    """Progress of a calculation in several parts.

    Parameters
    ----------
    number : int
        The load, stage or variant at work, from 1 on.
    count : int
        How many there are.
    step : Step, IterationInfo or None
        Last check of its solver.
    label : str
        Name of the part.
    kept : bool
        Whether this part, and earlier ones that are not reported, were already in the folder.
    """

    number: int
    count: int
    step: Any
    label: str = ""
    kept: bool = False


Tell = Callable[[Progress], None] | bool | None
"""What ``progress`` may be. Where the work is done, ``True`` has become a function already."""


def numbered(
    progress: Tell, number: int, count: int, label: str = ""
) -> Callable[[Step], None] | None:
    """Return what a solver calls with each `Step`, so that a `Progress` is told; or ``None``.

    Parameters
    ----------
    progress : callable or None
        Called with a `Progress`.
    number, count, label
        As for `Progress`.
    """
    if not callable(progress):
        return None
    return lambda step: progress(Progress(number, count, step, label))


# --- A line that tells how far a calculation is, in terminals and notebooks alike ---


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

    def __call__(self, state: Progress) -> None:
        """Draw the line anew."""
        part = 1.0 if state.kept else self._part(state)
        done = (state.number - 1 + part) / max(state.count, 1)
        parts = [state.label] if state.label else []
        if state.count > 1:
            parts.append(f"{state.number} of {state.count}")
        if state.kept:
            parts.append("kept from before")
        elif state.step is not None:
            parts.append(f"{_error(state):.0e}, target {state.step.tolerance:.0e}")
        filled = round(_WIDTH * min(max(done, 0.0), 1.0))
        self._draw(f"{'█' * filled:{_WIDTH}} {', '.join(parts)}")

    def close(self) -> None:
        """Leave the line as it is, and the next one to others."""
        if self._length:
            self._write("\n")
        self._length = 0

    def _part(self, state: Progress) -> float:
        """Return how much of a part is done: errors fall by about as much each time."""
        if state.step is None:
            return 0.0
        error, tolerance = _error(state), state.step.tolerance
        first = self._first.setdefault(state.number, max(error, 2 * tolerance))
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


def _error(state: Progress) -> float:
    """Return the certificate of a contact, or the residual of the volume."""
    known = state.step.residual if hasattr(state.step, "residual") else state.step.certificate
    return float(known)


def shows_progress_bar(function: Callable[P, R]) -> Callable[P, R]:
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
