"""How far a calculation is: what it tells whoever watches."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Step:
    """One look at the whole map while the solver runs.

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
    """Where a calculation of several parts stands.

    Parameters
    ----------
    number : int
        The load, stage or variant at work, from 1 on.
    count : int
        How many there are.
    step : Step, volume.loop.Look or None
        What its solver looked at last.
    label : str
        A name of the part for whoever reads along.
    kept : bool
        Whether this part stood in a folder already, and those before it if they are not told of.
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
