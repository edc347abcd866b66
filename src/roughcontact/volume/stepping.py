"""Load steps that are as small as an estimate of their error asks for.

Plastic flow is followed by implicit steps: in each, strain flows in the direction that the stress
has at its end. Where that direction turns on the way, as it does in a contact that grows, a step
makes an error that falls with its size. So the way to each load is gone twice, the second time in
twice as many steps: to first order, the ends differ by the error that is left, and where it is too
large, the way is gone once more in as many steps as it takes. Loads one after the other add up.

What is compared is the approach and the area that all but touches: each pixel in contact counts
one, and one with a gap counts less, nothing from 5 % of the approach on. Unlike the area in contact
it does not jump by whole pixels.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from roughcontact.volume.loop import Loop
from roughcontact.volume.path import PathPoint
from roughcontact.volume.result import CONVERGED, Increment

AUTO = "auto"
"""In place of a number of increments: as many as an estimate of their error asks for."""

STEP_ERROR = 0.01
"""Error by the load steps of a whole path that is aimed at."""

# Steps of the first way from nothing to a load; and how many times as many there are at most.
_STEPS, _MOST = 6, 8
# The ends of two ways tell more than rounding where one has so many times the steps of the other.
_FINER = 1.5
# Gap, over the approach, from which on a pixel does not count as touching.
_NEAR = 0.05


class _Look(NamedTuple):
    """What is compared of a state."""

    approach: float
    near: float


def between(before: PathPoint, point: PathPoint, count: int) -> list[PathPoint]:
    """Return points in equal steps; the last is as given, and not what rounding makes of it."""
    return [*(before.between(point, i, count) for i in range(1, count)), point]


def reach(
    loop: Loop, point: PathPoint, done: list[Increment], watch: Callable[[float, int, float], None]
) -> str:
    """Visit a load in as many steps as the error asks for; return why it stopped.

    Parameters
    ----------
    loop : Loop
        The loop, in the state after ``done``.
    point, done, watch
        As for `Loop.reach`; the increments added tell of their error.

    Returns
    -------
    str
        `CONVERGED`, or a reason in words.
    """
    before, load = done[-1].load if done else 0.0, point.load
    allowed = STEP_ERROR * abs(load - before) / max(load, before, np.finfo(float).tiny)
    start, parts = loop.held(), _first(load, done)
    status, found, flowed = _tried(loop, point, parts, done, watch)
    coarse = _look(loop) if status == CONVERGED else None
    if coarse and not flowed:
        # Nothing flows, so nothing turns.
        _add(done, found, 0.0)
        return status
    most, more, error = _MOST * parts, 2 * parts, math.inf
    while True:
        loop.restore(start)
        status, found, _ = _tried(loop, point, more, done, watch)
        if status != CONVERGED:
            _add(done, found, None)
            return status
        fine = _look(loop)
        if coarse:
            error = _change(coarse, fine) * parts / (more - parts)
        if error <= allowed or more == most:
            break
        wanted = max(_FINER * more, more * min(error / allowed, _MOST))
        coarse, parts, more = fine, more, min(math.ceil(wanted), most)
    _add(done, found, error if coarse else None)
    return status


def _first(load: float, done: list[Increment]) -> int:
    """Return in how many steps to go to a load at first: up to the largest so far little flows."""
    before = done[-1].load if done else 0.0
    if load <= max((step.load for step in done), default=0.0):
        return 1
    return max(1, math.ceil(_STEPS * (load - before) / load - 1e-9))


def _tried(
    loop: Loop,
    point: PathPoint,
    parts: int,
    done: list[Increment],
    watch: Callable[[float, int, float], None],
) -> tuple[str, list[Increment], bool]:
    """Visit a load in so many parts.

    Returns why it stopped, all increments up to there, and whether anything flowed in these.
    """
    found, status, flowed = list(done), CONVERGED, False
    before = done[-1].point if done else PathPoint(0.0, point.offset)
    for step in between(before, point, parts):
        status = loop.reach(step, found, watch)
        flowed = flowed or loop.flowing
        if status != CONVERGED:
            break
    return status, found, flowed


def _look(loop: Loop) -> _Look:
    solver = loop.solver
    near = 0.0
    if solver.solution is not None:
        reach = max(_NEAR * abs(solver.approach), np.finfo(float).tiny)
        near = float(np.clip(1 - solver.solution.gap / reach, 0, 1).sum())
    return _Look(solver.approach, near)


def _change(coarse: _Look, fine: _Look) -> float:
    """Return by how much two states of one load differ, relatively."""
    approach = abs(coarse.approach - fine.approach) / max(abs(fine.approach), 1e-300)
    return max(approach, abs(coarse.near - fine.near) / fine.near if fine.near else 0.0)


def _add(done: list[Increment], found: list[Increment], error: float | None) -> None:
    """Add the increments that came to those done, with the error up to there."""
    known = done[-1].step_error if done else 0.0
    total = None
    if known is not None and error is not None and math.isfinite(error):
        # Errors are shares of what grows on the way.
        old = max((step.approach for step in done), default=0.0)
        new = max(step.approach for step in found)
        total = known * (old / new if new > 0 else 1.0) + error
    done += [replace(step, step_error=total) for step in found[len(done) :]]
