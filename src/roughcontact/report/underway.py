"""What is done while one waits, in words."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from roughcontact import units
from roughcontact.solvers.progress import Progress, Step

if TYPE_CHECKING:
    from roughcontact.volume.loop import Look


def described(at: Progress) -> str:
    """Return what a solver is doing, in one line.

    Parameters
    ----------
    at : Progress
        What it tells.
    """
    part = f"{at.number} of {at.count}: " if at.count > 1 else ""
    label = f"{at.label}: " if at.label else ""
    if at.kept:
        return f"{label}{part}kept from before"
    return f"{label}{part}{_step(at.step) if isinstance(at.step, Step) else _look(at.step)}"


def _step(step: Step) -> str:
    ny, nx = step.shape
    return (
        f"solving {ny} × {nx}: {step.convolutions} convolutions, "
        f"certificate {step.certificate:.1e}, target {step.tolerance:.0e}"
    )


def _look(look: Look) -> str:
    load = units.engineering(look.load, "N")
    return f"at {load}: iteration {look.iteration}, residual {look.residual:.1e}"


class Forecast:
    """How long parts that are alike will take, from those that are done."""

    def __init__(self) -> None:
        self._first = self._at = self._count = 0
        self._start = self._begun = 0.0

    def __call__(self, at: Progress) -> str:
        """Return the words of `left`; called with every `Progress`."""
        now = time.monotonic()
        if at.kept or at.count != self._count or at.number < self._at:
            # What was kept tells no time.
            self._first, self._count, self._start = at.number + at.kept, at.count, now
            self._at, self._begun = self._first, now
        elif at.number > self._at:
            self._at, self._begun = at.number, now
        done, to_do = self._at - self._first, self._count - self._at + 1
        return left(done, to_do, self._begun - self._start)


def left(done: int, to_do: int, seconds: float) -> str:
    """Return how long it will take until all of many like things are done.

    Parameters
    ----------
    done : int
        How many were done in these seconds.
    to_do : int
        How many are left.
    seconds : float
        Time since the first was begun [s].

    Returns
    -------
    str
        Words to go on with; none as long as nothing is known.

    Examples
    --------
    >>> left(3, 40, 9.0)
    ', about 2 min left'
    """
    if not done or not to_do:
        return ""
    guess = seconds / done * to_do
    for unit, size in (("h", 3600), ("min", 60)):
        if guess >= 1.5 * size:
            return f", about {guess / size:.0f} {unit} left"
    return f", about {max(1.0, guess):.0f} s left"
