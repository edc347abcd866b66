"""A pressure on its way to the solution, and what it does to the whole map."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.solvers.operator import Operator, Sums, norm
from roughcontact.solvers.problem import Limit, Loaded, Problem
from roughcontact.solvers.projection import project, shift_to_sum, without_dust


@dataclass(frozen=True, eq=False)
class Iterate:
    """A pressure that keeps bounds and load, with what it does; only pixels that matter.

    ``index`` holds all pixels with pressure and all that want some, ascending; ``pressure`` and
    ``gap`` their values.
    """

    index: NDArray[np.int64]
    pressure: NDArray[np.float64]
    gap: NDArray[np.float64]
    approach: float
    certificate: float
    # Part of the certificate that rounding alone may cause; in single precision it is included.
    floor: float


class Viewer:
    """Evaluates pressures on the whole map."""

    def __init__(self, problem: Problem, operator: Operator) -> None:
        self.problem, self.operator = problem, operator
        self.unit, self.sums = operator.self_displacement, operator.sums
        self.convolutions = 0
        # The last look: displacement plus initial gap before the approach is taken off, and the
        # pixels that matter.
        self.open: NDArray[Any] = np.empty(problem.initial_gap.shape, operator.real)
        self.seen: Iterate | None = None

    def limit(self, index: NDArray[np.int64]) -> Limit:
        """Return the ceiling on some pixels."""
        limit = self.problem.limit
        return limit.ravel()[index] if isinstance(limit, np.ndarray) else limit

    def look(self, index: NDArray[np.int64], pressure: NDArray[np.float64]) -> Iterate:
        """Return what a pressure does, computed afresh over the whole map."""
        initial_gap, total = self.problem.initial_gap, self.problem.total
        self.seen = None
        pressure = without_dust(pressure, self.limit(index), self.sums)
        index, pressure = chosen(pressure > 0, index, pressure)

        def visit(number: int, rows: slice, displacement: NDArray[Any]) -> None:
            np.add(displacement, initial_gap[rows], out=self.open[rows])

        support = self.operator.support(index)
        self.operator.spread(support, pressure, visit)
        self.convolutions += 1
        approach = self.problem.approach or 0.0
        if total is not None:
            # More pixels can only lower the approach that carries the load: this one is a bound.
            approach = self._multiplier(index, pressure, total)
        loaded_pixels, starts = self.sums.size(index), support.starts
        del support
        index, pressure = self._joined(index, pressure, starts, approach)
        if total is not None and self.sums.size(index) > loaded_pixels:
            approach = self._multiplier(index, pressure, total)
        gap, moved, floor = self._judged(index, pressure, approach)
        size = norm(pressure, self.sums)
        if self.operator.real is not np.float64:
            # Double precision would see it.
            moved = math.hypot(moved, floor)
        self.seen = Iterate(
            index=index,
            pressure=pressure,
            gap=gap,
            approach=approach,
            certificate=moved / size if size else (math.inf if moved else 0.0),
            floor=floor / size if size else 0.0,
        )
        return self.seen

    def _judged(
        self, index: NDArray[np.int64], pressure: NDArray[np.float64], approach: float
    ) -> tuple[NDArray[np.float64], float, float]:
        """Return the gap on some pixels, how far their pressure would move, and rounding's part.

        Norms of ``p - clip(p - g/K₀₀, 0, limit)``, and of how far the last digit of displacement
        and initial gap may change that step, which does not matter on pixels far beyond a bound.
        """
        bound, doubt = self.limit(index), self.opened(index)
        gap = doubt - approach
        reach = gap / self.unit
        np.subtract(pressure, reach, out=reach)
        step = np.clip(reach, 0, bound)
        np.subtract(pressure, step, out=step)
        moved = norm(step, self.sums)
        # In place: where all of the map touches, every array is as large as the map.
        np.abs(doubt, out=doubt)
        initial = self.problem.initial_gap.ravel()[index]
        doubt += np.abs(initial, out=initial)
        del initial
        doubt *= 0.5 * float(np.finfo(self.operator.real).eps) / self.unit
        np.add(reach, doubt, out=step)
        np.clip(step, 0, bound, out=step)
        reach -= doubt
        np.clip(reach, 0, bound, out=reach)
        step -= reach
        return gap, moved, 0.5 * norm(step, self.sums)

    def opened(self, index: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return displacement plus initial gap of the last look on some pixels."""
        return self.open.ravel()[index].astype(np.float64)

    def _multiplier(
        self, index: NDArray[np.int64], pressure: NDArray[np.float64], total: float
    ) -> float:
        values = self.opened(index)
        # Offset first, so that the root find works on numbers of the size of the pressure.
        offset = self.sums.total(values) / self.sums.size(values)
        values -= offset
        values /= self.unit
        np.subtract(pressure, values, out=values)
        return offset + self.unit * shift_to_sum(values, self.limit(index), total, self.sums)

    def _joined(
        self,
        index: NDArray[np.int64],
        pressure: NDArray[np.float64],
        starts: NDArray[np.int64],
        approach: float,
    ) -> Loaded:
        """Add the pixels without pressure whose gap is negative."""
        nx = self.open.shape[1]
        found: dict[int, NDArray[np.int64]] = {}

        def seek(number: int, rows: slice) -> None:
            wanted = self.open[rows] < approach
            wanted.ravel()[index[starts[number] : starts[number + 1]] - rows.start * nx] = False
            pixels = np.flatnonzero(wanted)
            if pixels.size:
                found[number] = pixels + rows.start * nx

        self.operator.each_block(seek)
        if not found:
            return index, pressure
        new = np.concatenate([found[number] for number in sorted(found)])
        if isinstance(self.problem.limit, np.ndarray):
            new = new[self.problem.limit.ravel()[new] > 0]
        at = np.searchsorted(index, new)
        return np.insert(index, at, new), np.insert(pressure, at, 0.0)


def admissible(problem: Problem, start: Loaded, sums: Sums) -> Loaded:
    """Return a pressure that keeps bounds and load, near the one given."""
    index, pressure = start
    touchable = np.isfinite(problem.initial_gap)
    if isinstance(problem.limit, np.ndarray):
        touchable &= problem.limit > 0
    index, pressure = chosen((pressure > 0) & touchable.ravel()[index], index, pressure)
    bound = problem.limit.ravel()[index] if isinstance(problem.limit, np.ndarray) else problem.limit
    if problem.total is None:
        return index, np.clip(pressure, 0, bound)
    if not sums.size(index) or sums.total(np.broadcast_to(bound, index.shape)) < problem.total:
        # What is loaded cannot carry the load: start from everything that can touch.
        index = np.flatnonzero(touchable)
        pressure = np.zeros(index.size)
        pressure += problem.total / sums.size(index)
        if isinstance(problem.limit, np.ndarray):
            bound = problem.limit.ravel()[index]
    return index, project(pressure, bound, problem.total, sums)


def chosen(
    wanted: NDArray[np.bool_], index: NDArray[np.int64], pressure: NDArray[np.float64]
) -> Loaded:
    """Return the entries that are wanted: the arrays themselves where all are."""
    if wanted.all():
        return index, pressure
    return index[wanted], pressure[wanted]


def slopes(now: Iterate, moved: NDArray[np.float64], viewer: Viewer) -> tuple[float, float]:
    """Return the slopes of the energy at both ends of the step that was looked at last.

    The energy is quadratic: its change is the mean of the two, its curvature their difference.
    """
    direction = moved - now.pressure
    # Whatever approach is taken off cancels under a given load, where the step sums to zero.
    gap = viewer.opened(now.index) - now.approach
    sums = viewer.sums
    return sums.dot(direction, now.gap), sums.dot(direction, gap)


def projected(now: Iterate, viewer: Viewer, rate: float) -> NDArray[np.float64]:
    """Return the admissible pressure nearest to a step down the gradient."""
    bound, total = viewer.limit(now.index), viewer.problem.total
    target = now.pressure - rate * now.gap
    if total is None:
        return np.clip(target, 0, bound)
    return project(target, bound, total, viewer.sums)


def settled(now: Iterate, viewer: Viewer, tolerance: float) -> Iterate:
    """Return a solution whose pixels are on the bounds that they belong to.

    The certificate does not tell a pixel at the ceiling from one a hair's breadth below it, nor
    where a pixel with a tiny ceiling belongs; the counted areas do. The last active-set step
    settles nearly all pixels, a good start need not.
    """
    bound = viewer.limit(now.index)
    target = projected(now, viewer, 1 / viewer.unit)
    falls = (target <= 0) & (now.pressure > 0)
    rises = (target >= bound) & (now.pressure < bound)
    if not viewer.sums.count(falls | rises):
        return now
    settled = viewer.look(now.index, target)
    return settled if settled.certificate <= tolerance else now
