"""Progress of a calculation, as passed to callbacks."""

from __future__ import annotations

import functools
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any, ParamSpec, TextIO, TypeVar

from roughcontact.errors import ArgumentRef, Sentence


class Status(Enum):
    """Reason why the solver stopped; each value is a message for the user."""

    CONVERGED = "converged"
    CONVOLUTION_LIMIT = Sentence(
        f"stopped at {ArgumentRef('max_iterations')}; allow more, or start from a nearby solution"
    )
    STALLED = (
        "no further progress; the tolerance may be below the rounding error of this problem "
        "(single precision guarantees 1e-4)"
    )
    INTERRUPTED = "interrupted"


@dataclass(frozen=True)
class Step:
    """State of the solver after a check of the whole map.

    Parameters
    ----------
    shape : (int, int)
        Grid of the current level; coarser than the map while the first pressure is computed.
    iteration : int
        Active-set steps on this level so far.
    convolutions : int
        Convolutions on this level so far.
    certificate : float
        ε of the current pressure.
    tolerance : float
        ε at which this level ends.
    done : float
        Completed share of the solve.
    """

    shape: tuple[int, int]
    iteration: int
    convolutions: int
    certificate: float
    tolerance: float
    done: float = 0.0


@dataclass(frozen=True)
class Progress:
    """Progress of a calculation in several parts.

    Parameters
    ----------
    number : int
        Number of the current load, stage or variant, from 1.
    count : int
        Number of all loads, stages or variants.
    step : Step, IterationInfo or None
        Last check of its solver.
    label : str
        Name of the part.
    kept : bool
        Whether this part, and earlier ones without a report, were already in the folder.
    """

    number: int
    count: int
    step: Any
    label: str = ""
    kept: bool = False

    @property
    def done(self) -> float:
        """Completed share of this part; 0 if unknown."""
        if self.kept:
            return 1.0
        if isinstance(self.step, Step):
            return self.step.done
        # The load of a single part increases in steps towards its target.
        known = self.count == 1 and self.step is not None and self.step.target
        return min(self.step.load / self.step.target, 1.0) if known else 0.0


class Forecast:
    """Estimate of the remaining time of a calculation, called with every `Progress`.

    Parts are assumed to take the same time. The completed share of a part gives an estimate before
    the part ends; each grid has a separate pace.
    """

    def __init__(self) -> None:
        self._state = Progress(0, 0, None)
        # First part that was not kept, its start time, and the start time of the current part.
        self._first, self._start, self._begun = 1, 0.0, 0.0
        # Start time on the current grid, the share at that time, and the estimated end of the part.
        self._since, self._share, self._end = 0.0, 0.0, 0.0

    def __call__(self, state: Progress) -> float:
        """Return the remaining time [s], or 0 if unknown."""
        now, before = time.monotonic(), self._state
        other_grid = _grid(state) != _grid(before)
        again = other_grid and state.number == before.number and state.done < before.done
        series = state.kept or state.count != before.count or state.number < before.number or again
        part = series or state.number > before.number
        self._state = state
        if series:
            # Saved steps give no time estimate.
            self._first, self._start = state.number + state.kept, now
        if part:
            self._begun, self._end = now, 0.0
        if part or other_grid:
            self._since, self._share = now, state.done
        elif state.done > max(self._share, _MIN_SHARE) and state.step.iteration > 1:
            pace = (now - self._since) / (state.done - self._share)
            self._end = now + pace * (1.0 - state.done)
        parts = state.number - self._first
        if parts > 0:
            each = (self._begun - self._start) / parts
            end = self._end or self._begun + each
        elif self._end:
            each, end = self._end - self._begun, self._end
        else:
            return 0.0
        return max(end - now, 0.0) + each * (state.count - state.number)


# Minimum share of a solve for a time estimate: small grids and first steps give none.
_MIN_SHARE = 0.02


def _grid(state: Progress) -> tuple[int, int] | None:
    return state.step.shape if isinstance(state.step, Step) else None


Tell = Callable[[Progress], None] | bool | None
"""Type of ``progress``; ``True`` is replaced by a callback before the work starts."""


def progress_callback(
    progress: Tell, number: int, count: int, label: str = ""
) -> Callable[[Step], None] | None:
    """Return a solver callback that converts each `Step` to a `Progress`, or ``None``.

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


def each_part(progress: Tell, label: str) -> Callable[[int, int], None] | None:
    """Return a callback for the number and the count of parts without a solver.

    Parameters
    ----------
    progress : callable or None
        Called with a `Progress`.
    label : str
        Name of all parts.
    """
    if not callable(progress):
        return None
    return lambda number, count: progress(Progress(number, count, None, label))


def one_of_several(
    progress: Callable[[Progress], None], number: int, count: int
) -> Callable[[Progress], None]:
    """Return the progress callback of one of several calculations with equal part counts.

    Parameters
    ----------
    progress : callable
        Called with the `Progress` of all calculations.
    number, count : int
        Number of this calculation, from 1, and number of all calculations.
    """

    def report_progress(state: Progress) -> None:
        before = (number - 1) * state.count
        progress(replace(state, number=before + state.number, count=count * state.count))

    return report_progress


P = ParamSpec("P")
R = TypeVar("R")

_WIDTH = 24


class ProgressBar:
    """Progress bar on one line, redrawn for each `Progress`.

    Parameters
    ----------
    stream : file
        Output; carriage returns restart the line in terminals and notebooks.

    Examples
    --------
    >>> bar = ProgressBar(sys.stdout)
    >>> bar(Progress(3, 4, None, "", kept=True))  # doctest: +SKIP
    ██████████████████       3 of 4, kept from before
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream, self._length = stream, 0

    def __call__(self, state: Progress) -> None:
        """Redraw the line."""
        done = (state.number - 1 + state.done) / max(state.count, 1)
        parts = [state.label] if state.label else []
        if state.count > 1:
            parts.append(f"{state.number} of {state.count}")
        if state.kept:
            parts.append("from an earlier run")
        elif state.step is not None:
            parts.append(f"{_error(state):.0e}, target {state.step.tolerance:.0e}")
        filled = round(_WIDTH * min(max(done, 0.0), 1.0))
        self._draw(f"{'█' * filled:{_WIDTH}} {', '.join(parts)}")

    def close(self) -> None:
        """End the line."""
        if self._length:
            self._write("\n")
        self._length = 0

    def _draw(self, line: str) -> None:
        self._write("\r" + line.ljust(self._length))
        self._length = len(line)

    def _write(self, text: str) -> None:
        # A closed stream must not stop the calculation.
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
    """Return a function that draws a `ProgressBar` on standard error if ``progress=True``."""

    @functools.wraps(function)
    def call(*positional: P.args, **named: P.kwargs) -> R:
        if named.get("progress") is not True:
            return function(*positional, **named)
        bar = ProgressBar(sys.stderr)
        named["progress"] = bar
        try:
            return function(*positional, **named)
        finally:
            bar.close()

    return call
