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

# A load that differs by no more is the same.
_CARRIED = 1e-12
# Gaps are counted in so many bins where pixels are sought that can carry a load.
_BINS = 4096
# Certificate above which single precision is good enough, in itself and over the tolerance; and
# the part of it that rounding may make up.
_FAR, _TOLERANCES, _BLURRED = 3e-4, 30, 0.1


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
    # Whether in the arithmetic of the problem, not a coarser one.
    sharp: bool


class Viewer:
    """Evaluates pressures on the whole map.

    Far from the solution in single precision: what such a look shows is off in its last digits,
    and good enough to come nearer.
    """

    def __init__(self, problem: Problem, operator: Operator, tolerance: float) -> None:
        self.problem, self.operator = problem, operator
        # Of this size there is one: patches work with it too.
        self.rough = operator.in_single()
        self._tolerance = tolerance
        # Where single precision is still good enough, and how far away the last look was.
        self._far = max(_FAR, _TOLERANCES * tolerance)
        self._distance = math.inf if self.rough is not operator else 0.0
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
        self.seen = None
        pressure = without_dust(pressure, self.limit(index), self.sums)
        index, pressure = chosen(pressure > 0, index, pressure)
        if self._distance > self._far:
            seen = self._looked(self.rough, index, pressure)
            blurred = seen.floor > _BLURRED * seen.certificate
            self._distance = 0.0 if blurred else seen.certificate
            if seen.certificate > self._tolerance and not blurred:
                self.seen = seen
                return seen
        self.seen = self._looked(self.operator, index, pressure)
        self._distance = 0.0
        return self.seen

    def settle(self, now: Iterate) -> Iterate:
        """Return a pressure looked at before as the last thing seen, to all digits."""
        if self.seen is now and now.sharp:
            return now
        self._distance = 0.0
        return self.look(now.index, now.pressure)

    def _looked(
        self, operator: Operator, index: NDArray[np.int64], pressure: NDArray[np.float64]
    ) -> Iterate:
        total = self.problem.total
        starts = self._displaced(operator, index, pressure)
        approach = self.problem.approach or 0.0
        if total is not None:
            # More pixels can only lower the approach that carries the load: this one is a bound.
            approach = self._multiplier(index, pressure, total)
        loaded_pixels = self.sums.size(index)
        index, pressure = self._joined(operator, index, pressure, starts, approach)
        if total is not None and self.sums.size(index) > loaded_pixels:
            approach = self._multiplier(index, pressure, total)
        gap, moved, floor = self._judged(operator, index, pressure, approach)
        size = norm(pressure, self.sums)
        if operator.real is not np.float64:
            # Double precision would see it.
            moved = math.hypot(moved, floor)
        return Iterate(
            index=index,
            pressure=pressure,
            gap=gap,
            approach=approach,
            certificate=moved / size if size else (math.inf if moved else 0.0),
            floor=floor / size if size else 0.0,
            sharp=operator is self.operator,
        )

    def _displaced(
        self, operator: Operator, index: NDArray[np.int64], pressure: NDArray[np.float64]
    ) -> NDArray[np.int64]:
        """Keep displacement plus initial gap of the map; return where its row blocks begin."""
        initial_gap = self.problem.initial_gap

        def visit(number: int, rows: slice, displacement: NDArray[Any]) -> None:
            np.add(displacement, initial_gap[rows], out=self.open[rows])

        support = operator.support(index)
        operator.spread(support, pressure, visit)
        self.convolutions += 1
        return support.starts

    def carrying(self, index: NDArray[np.int64], pressure: NDArray[np.float64]) -> Loaded:
        """Return a pressure that can carry the load, near to that of another load.

        Changed in proportion; where the ceiling of these pixels is too low for it, or pixels would
        leave the ceiling alike as the load falls, by one step down the gradient, in which the
        pixels with the least gap take what is added, and those deepest in contact stay.
        """
        total, sums = self.problem.total, self.sums
        carried = sums.total(pressure)
        if total is None or not carried > 0:
            return index, pressure
        limit = self.limit(index)
        leaving = total < carried * (1 - _CARRIED) and self.sums.count(pressure >= limit)
        if not leaving and sums.total(np.broadcast_to(limit, index.shape)) > total:
            return index, pressure * (total / carried)
        starts = self._displaced(self.rough, index, pressure)
        approach = self._deep_enough(total)
        index, pressure = self._joined(self.rough, index, pressure, starts, approach)
        target = self.opened(index)
        target -= approach
        target /= -self.unit
        target += pressure
        return index, project(target, self.limit(index), total, sums)

    def _deep_enough(self, total: float) -> float:
        """Return an approach at which the pixels without gap can carry the load, hardly more."""
        limit, opened = self.problem.limit, self.open.ravel()
        touchable = np.isfinite(opened)
        opened = opened[touchable]
        most = limit.ravel()[touchable] if isinstance(limit, np.ndarray) else None
        low, high = self.sums.smallest(opened), self.sums.largest(opened)
        carried = self.sums.added(np.histogram(opened, _BINS, (low, high), weights=most)[0])
        if most is None:
            carried = carried * limit
        enough = int(np.searchsorted(np.cumsum(carried), total)) + 1
        return low + (high - low) * min(enough, _BINS) / _BINS

    def _judged(
        self,
        operator: Operator,
        index: NDArray[np.int64],
        pressure: NDArray[np.float64],
        approach: float,
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
        doubt *= 0.5 * float(np.finfo(operator.real).eps) / self.unit
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
        operator: Operator,
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

        operator.each_block(seek)
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
