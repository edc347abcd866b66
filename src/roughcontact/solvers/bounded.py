"""The bounded contact problem: which pressures close the gap without passing the ceiling.

Minimise ½⟨p, K p⟩ + ⟨h₀, p⟩ over 0 ≤ p ≤ limit, with a given sum of p or a given approach ω.
How the method differs from its textbook parents (Polonsky and Keer 1999,
doi:10.1016/S0043-1648(99)00113-1; Hintermüller, Ito and Kunisch 2003,
doi:10.1137/S1052623401383558):

- The set of free pixels is read off the pressure and the gap (active-set, or semi-smooth Newton,
  step); the linear problem on it is solved by preconditioned conjugate gradients just far enough
  that the error of the set and the error on the set are alike. One convolution each.
- The approach is the multiplier of an exact projection, never the mean gap over the free pixels:
  with a ceiling there may be few of them, or none.
- A step that raises the energy is cut at the minimum along its line and followed by projected
  gradient steps, which find the set of free pixels more slowly but surely.
- Everything but the transforms works on the pixels in or near contact; the only whole-map passes
  ride on the transforms, while a block of rows is in cache.
- The first pressure comes from the same problem on a grid of half the points, and so on down.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.halfspace.convolution import Convolution
from roughcontact.solvers.preconditioner import FreePixelInverse
from roughcontact.solvers.projection import project, shift_to_sum, without_dust

Limit = float | NDArray[np.float64]
Loaded = tuple[NDArray[np.int64], NDArray[np.float64]]

Operator = Callable[[tuple[int, int], tuple[int, int]], Convolution]

# Reached on coarse grids: below it the error of the grid outweighs that of the solver.
_COARSE_TOLERANCE = 3e-3
_COARSEST = 32
# Blocks per side for the collective modes of the contact spots, and the fewest points in one.
_BLOCKS = 24
_BLOCK_POINTS = 64
# A linear solve stops at this reduction unless the set of free pixels is already right.
_REDUCTION = 0.1
# Steps without a better certificate before projected gradients take over; their number after a
# step that overshoots, doubled every time that they take over; how often before giving up; over
# how many the energy may rise.
_PATIENCE = 3
_BURST = 8
_BURSTS = 10
_NONMONOTONE = 5
# Curvature over K₀₀ below which the uniform pressure of a periodic map is not resisted.
_FLAT = 1e-12


class Status(Enum):
    """Why the solver stopped; each value is its own advice."""

    CONVERGED = "converged"
    CONVOLUTION_LIMIT = "stopped at max_iterations; allow more, or start from a nearby solution"
    STALLED = (
        "no further progress; the tolerance may lie below the rounding error of this problem "
        "(single precision promises 1e-4)"
    )


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


@dataclass(frozen=True, eq=False)
class Problem:
    """A bounded contact problem on one grid.

    Parameters
    ----------
    initial_gap : ndarray, shape (ny, nx)
        h₀ [m]; ``inf`` where the bodies never touch.
    limit : float or ndarray, shape (ny, nx)
        Ceiling of the pressure [Pa]; ``inf`` without one.
    total : float, optional
        Sum of the pressures wanted [Pa]: load over pixel area.
    approach : float, optional
        ω [m]; exactly one of ``total`` and ``approach`` is given.
    """

    initial_gap: NDArray[Any]
    limit: Limit
    total: float | None = None
    approach: float | None = None


@dataclass(frozen=True, eq=False)
class Solution:
    """What the solver found.

    Parameters
    ----------
    index : ndarray of int, shape (n,)
        Flat indices of the pixels with pressure, ascending.
    pressure : ndarray, shape (n,)
        Pressure on them [Pa].
    gap : ndarray, shape (ny, nx)
        Gap computed afresh from this pressure [m]; ``inf`` where the bodies never touch.
    approach : float
        ω [m].
    certificate : float
        ε of this pressure and gap.
    status : Status
        Why the solver stopped.
    iterations, convolutions : int
        On the finest grid.
    history : tuple of Step
        Every look at the whole map, coarse grids included.
    """

    index: NDArray[np.int64]
    pressure: NDArray[np.float64]
    gap: NDArray[Any]
    approach: float
    certificate: float
    status: Status
    iterations: int
    convolutions: int
    history: tuple[Step, ...]


def solve(
    problem: Problem,
    operator: Operator,
    *,
    tolerance: float,
    max_iterations: int,
    start: Loaded | None = None,
    progress: Callable[[Step], None] | None = None,
) -> Solution:
    """Return the pressure that solves a bounded contact problem.

    Parameters
    ----------
    problem : Problem
        What to solve; it must be feasible.
    operator : callable
        ``operator(shape, (ky, kx))`` returns ``pressure → displacement`` on a grid of that shape
        whose pixels are as large as ``ky × kx`` pixels of the map.
    tolerance : float
        Certificate ε at which the solution counts as converged.
    max_iterations : int
        Most convolutions on any one grid.
    start : (ndarray of int, ndarray), shapes (n,), optional
        Pixels, ascending, and pressure [Pa] to start from, such as those of a neighbouring
        load; without it the first pressure comes from coarser grids.
    progress : callable, optional
        Called with each `Step`.

    Returns
    -------
    Solution
        The solution, or the best approximation with a status that says why it is none.
    """
    history: list[Step] = []

    def note(step: Step) -> None:
        history.append(step)
        if progress is not None:
            progress(step)

    levels = [problem]
    if start is None:
        while min(levels[-1].initial_gap.shape) >= 2 * _COARSEST:
            levels.append(_coarsened(levels[-1]))
        pixels = levels[-1].initial_gap.size
        mean = (levels[-1].total or 0.0) / pixels
        start = np.arange(pixels), np.full(pixels, mean)
    # The largest operator first: the coarse ones then work in its memory.
    finest_operator = operator(_shape(problem), (1, 1))
    for depth in range(len(levels) - 1, -1, -1):
        level = levels[depth]
        finest = depth == 0
        pixel = (2**depth, 2**depth)
        level_operator = finest_operator if finest else operator(_shape(level), pixel)
        solution = _solve_level(
            level,
            level_operator,
            _Patches(level_operator, operator, pixel),
            start,
            max(tolerance, _COARSE_TOLERANCE) if not finest else tolerance,
            max_iterations,
            note,
        )
        if not finest:
            start = _prolonged(solution, levels[depth - 1].initial_gap.shape)
            del levels[depth], solution
    return Solution(**{**vars(solution), "history": tuple(history)})


def _shape(problem: Problem) -> tuple[int, int]:
    ny, nx = problem.initial_gap.shape
    return ny, nx


def _prolonged(coarse: Solution, shape: tuple[int, ...]) -> Loaded:
    """Return each pressure on the four pixels that make up its coarse pixel."""
    row, column = np.divmod(coarse.index, coarse.gap.shape[1])
    count = np.bincount(row, minlength=coarse.gap.shape[0])
    first = np.cumsum(count) - count
    # A coarse row becomes two fine rows: this is where its pixels begin in ascending order.
    place = 4 * first[row] + 2 * (np.arange(row.size) - first[row])
    index = np.empty(4 * row.size, np.int64)
    pressure = np.empty(4 * row.size)
    inside = np.empty(4 * row.size, bool)
    for down in (0, 1):
        for right in (0, 1):
            fine_row, fine_column = 2 * row + down, 2 * column + right
            at = place + down * 2 * count[row] + right
            index[at] = fine_row * shape[1] + fine_column
            pressure[at] = coarse.pressure
            inside[at] = (fine_row < shape[0]) & (fine_column < shape[1])
    return index[inside], pressure[inside]


def _coarsened(problem: Problem) -> Problem:
    """Return the problem on pixels of twice the length; odd edges are repeated."""
    gap, limit = problem.initial_gap, problem.limit
    touchable = np.isfinite(gap)
    if touchable.all():
        gap = _block_mean(gap)
    else:
        weight = _block_mean(touchable.astype(np.float32))
        gap = _block_mean(np.where(touchable, gap, 0))
        with np.errstate(divide="ignore", invalid="ignore"):
            gap = np.where(weight > 0, gap / weight, np.inf)
        if not isinstance(limit, np.ndarray):
            limit = np.full(touchable.shape, limit)
        # Infinite times zero is not zero: where nothing touches nothing is carried.
        limit = np.where(touchable, limit, 0)
    if isinstance(limit, np.ndarray):
        limit = _block_mean(limit)
    total = None if problem.total is None else problem.total / 4
    return Problem(gap, limit, total, problem.approach)


def _block_mean(values: NDArray[Any]) -> NDArray[np.float64]:
    ny, nx = values.shape
    if ny % 2 or nx % 2:
        values = np.pad(values, ((0, ny % 2), (0, nx % 2)), mode="edge")
    mean: NDArray[np.float64] = values[::2, ::2] + values[1::2, ::2]
    mean += values[::2, 1::2]
    mean += values[1::2, 1::2]
    mean *= 0.25
    return mean


@dataclass(frozen=True, eq=False)
class _Iterate:
    """A pressure that keeps bounds and load, with what it does; only pixels that matter.

    ``index`` holds all pixels with pressure and all that want some, ascending; ``pressure`` and
    ``gap`` their values.
    """

    index: NDArray[np.int64]
    pressure: NDArray[np.float64]
    gap: NDArray[np.float64]
    approach: float
    certificate: float
    # What rounding alone may cause of the certificate, which counts it in in single precision.
    floor: float


class _Viewer:
    """Looks at what a pressure does on the whole map."""

    def __init__(self, problem: Problem, operator: Convolution) -> None:
        self.problem, self.operator = problem, operator
        self.unit = operator.self_displacement
        self.convolutions = 0
        # The last look: displacement plus initial gap before the approach is taken off, and the
        # pixels that matter.
        self.open: NDArray[Any] = np.empty(problem.initial_gap.shape, operator.real)
        self.seen: _Iterate | None = None

    def limit(self, index: NDArray[np.int64]) -> Limit:
        limit = self.problem.limit
        return limit.ravel()[index] if isinstance(limit, np.ndarray) else limit

    def look(self, index: NDArray[np.int64], pressure: NDArray[np.float64]) -> _Iterate:
        """Return what a pressure does, computed afresh over the whole map."""
        initial_gap, total = self.problem.initial_gap, self.problem.total
        pressure = without_dust(pressure, self.limit(index))
        loaded = pressure > 0
        index, pressure = index[loaded], pressure[loaded]

        def visit(number: int, rows: slice, displacement: NDArray[Any]) -> None:
            np.add(displacement, initial_gap[rows], out=self.open[rows])

        support = self.operator.support(index)
        self.operator.spread(support, pressure, visit)
        self.convolutions += 1
        approach = self.problem.approach or 0.0
        if total is not None:
            # More pixels can only lower the approach that carries the load: this one is a bound.
            approach = self._multiplier(index, pressure, total)
        loaded_pixels = index.size
        index, pressure = self._joined(index, pressure, support.starts, approach)
        if total is not None and index.size > loaded_pixels:
            approach = self._multiplier(index, pressure, total)
        opened = self.opened(index)
        gap = opened - approach
        bound = self.limit(index)
        reach = pressure - gap / self.unit
        step = pressure - np.clip(reach, 0, bound)
        # How far the last digit of displacement and initial gap may change that step; no matter on
        # pixels that are far beyond a bound.
        doubt = np.abs(opened) + np.abs(initial_gap.ravel()[index])
        doubt *= 0.5 * float(np.finfo(self.operator.real).eps) / self.unit
        doubt = np.clip(reach + doubt, 0, bound) - np.clip(reach - doubt, 0, bound)
        size, moved, floor = _norm(pressure), _norm(step), 0.5 * _norm(doubt)
        if self.operator.real is not np.float64:
            # Double precision would see it.
            moved = math.hypot(moved, floor)
        self.seen = _Iterate(
            index=index,
            pressure=pressure,
            gap=gap,
            approach=approach,
            certificate=moved / size if size else (math.inf if moved else 0.0),
            floor=floor / size if size else 0.0,
        )
        return self.seen

    def opened(self, index: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return displacement plus initial gap of the last look on some pixels."""
        return self.open.ravel()[index].astype(np.float64)

    def _multiplier(
        self, index: NDArray[np.int64], pressure: NDArray[np.float64], total: float
    ) -> float:
        opened = self.opened(index)
        # Offset first, so that the root find works on numbers of the size of the pressure.
        offset = float(opened.mean())
        values = pressure - (opened - offset) / self.unit
        return offset + self.unit * shift_to_sum(values, self.limit(index), total)

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


@dataclass(frozen=True, eq=False)
class _Patch:
    """A part of the map with an operator and an approximate inverse of its own."""

    first: tuple[int, int]
    map_width: int
    operator: Convolution
    inverse: FreePixelInverse

    def holds(self, low: tuple[int, int], high: tuple[int, int]) -> bool:
        """Return whether the rows and columns from ``low`` to ``high`` lie on it."""
        return all(
            first <= start and end < first + points
            for first, points, start, end in zip(
                self.first, self.operator.shape, low, high, strict=True
            )
        )

    def index(self, index: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return flat indices on the patch for flat indices on the map."""
        width = self.operator.shape[1]
        if width == self.map_width:
            return index - self.first[0] * width
        row, column = np.divmod(index, self.map_width)
        local: NDArray[np.int64] = (row - self.first[0]) * width + (column - self.first[1])
        return local


class _Patches:
    """The smallest patch worth having that holds the pixels of a linear solve.

    A pressure displaces a pixel alike on any map that holds both, unless the map is periodic:
    where the contact is confined, so are the transforms.
    """

    def __init__(self, operator: Convolution, family: Operator, pixel: tuple[int, int]) -> None:
        self._family, self._pixel, self._width = family, pixel, operator.shape[1]
        self._whole = self._patch((0, 0), operator)
        self._periodic = operator.padded == operator.shape
        self._last = self._whole

    def around(self, index: NDArray[np.int64]) -> _Patch:
        """Return a patch that holds these pixels."""
        ny, nx = shape = self._whole.operator.shape
        if self._periodic or not index.size:
            return self._whole
        column = index % nx
        low = int(index[0] // nx), int(column.min())
        high = int(index[-1] // nx), int(column.max())
        if self._last is not self._whole and self._last.holds(low, high):
            return self._last
        first, points = [], []
        for start, end, most in zip(low, high, shape, strict=True):
            # Room for the contact to grow by a few pixels from step to step.
            margin = 2 + (end - start) // 32
            first.append(max(0, start - margin))
            points.append(min(most, end + 1 + margin) - first[-1])
        if 2 * points[0] * points[1] > ny * nx:
            return self._whole
        operator = self._family((points[0], points[1]), self._pixel)
        self._last = self._patch((first[0], first[1]), operator)
        return self._last

    def _patch(self, first: tuple[int, int], operator: Convolution) -> _Patch:
        response = _responses(operator.shape, self._family, self._pixel)
        if response is not None:
            response /= operator.self_displacement
        inverse = FreePixelInverse(operator.approximate_inverse(), response)
        return _Patch(first, self._width, operator, inverse)


def _solve_level(
    problem: Problem,
    operator: Convolution,
    patches: _Patches,
    first: Loaded,
    tolerance: float,
    max_iterations: int,
    note: Callable[[Step], None],
) -> Solution:
    shape = _shape(problem)
    viewer = _Viewer(problem, operator)
    now = best = viewer.look(*_admissible(problem, first))
    iteration, fruitless, bursts = 0, 0, 0
    while True:
        note(Step(shape, iteration, viewer.convolutions, now.certificate, tolerance))
        if now.certificate <= tolerance:
            now = _settled(now, viewer, tolerance)
            status = Status.CONVERGED
            break
        if viewer.convolutions >= max_iterations:
            status = Status.CONVOLUTION_LIMIT
            break
        if fruitless >= _PATIENCE and (best.certificate <= 10 * best.floor or bursts == _BURSTS):
            status = Status.STALLED
            break
        iteration += 1
        if fruitless < _PATIENCE:
            moved = _active_set_step(now, viewer, patches, tolerance, max_iterations)
            after = viewer.look(now.index, moved)
            if after.certificate > now.certificate and viewer.convolutions < max_iterations:
                start, end = _slopes(now, moved, viewer)
                # Where the set of free pixels is far off, the step overshoots: the energy rises.
                if start < 0 < start + end:
                    cut = start / (start - end)
                    now = viewer.look(now.index, now.pressure + cut * (moved - now.pressure))
                    after = _projected_gradient(now, viewer, _BURST, max_iterations)
        else:
            after = _projected_gradient(now, viewer, _BURST << min(bursts, 5), max_iterations)
            bursts, fruitless = bursts + 1, -1
        fruitless = 0 if after.certificate < 0.9 * best.certificate else fruitless + 1
        now = after
        if now.certificate < best.certificate:
            best = now
    if now.certificate > best.certificate and status is not Status.CONVERGED:
        now = best
    if viewer.seen is not now:
        now = viewer.look(now.index, now.pressure)
    loaded = now.pressure > 0
    viewer.open -= viewer.open.dtype.type(now.approach)
    return Solution(
        index=now.index[loaded],
        pressure=now.pressure[loaded],
        gap=viewer.open,
        approach=now.approach,
        certificate=now.certificate,
        status=status,
        iterations=iteration,
        convolutions=viewer.convolutions,
        history=(),
    )


def _slopes(now: _Iterate, moved: NDArray[np.float64], viewer: _Viewer) -> NDArray[np.float64]:
    """Return the slopes of the energy at both ends of the step that was looked at last.

    The energy is quadratic: its change is the mean of the two, its curvature their difference.
    """
    direction = moved - now.pressure
    # Whatever approach is taken off cancels under a given load, where the step sums to zero.
    gap = viewer.opened(now.index) - now.approach
    return np.array([_dot(direction, now.gap), _dot(direction, gap)])


def _responses(
    shape: tuple[int, int], operator: Operator, pixel: tuple[int, int]
) -> NDArray[np.float64] | None:
    """Return the displacement [m] of blocks of pixels by unit pressure on one pixel of the first.

    None where the map is too small for blocks to be of use.
    """
    blocks = [min(_BLOCKS, points // _BLOCK_POINTS) for points in shape]
    if min(blocks) < 2:
        return None
    size = [-(-points // number) for points, number in zip(shape, blocks, strict=True)]
    unit = np.zeros(blocks)
    unit[0, 0] = 1 / (size[0] * size[1])
    return operator((blocks[0], blocks[1]), (size[0] * pixel[0], size[1] * pixel[1]))(unit)


def _admissible(problem: Problem, start: Loaded) -> Loaded:
    """Return a pressure that keeps bounds and load, near the one given."""
    index, pressure = start
    touchable = np.isfinite(problem.initial_gap)
    if isinstance(problem.limit, np.ndarray):
        touchable &= problem.limit > 0
    keep = (pressure > 0) & touchable.ravel()[index]
    index, pressure = index[keep], pressure[keep]
    bound = problem.limit.ravel()[index] if isinstance(problem.limit, np.ndarray) else problem.limit
    if problem.total is None:
        return index, np.clip(pressure, 0, bound)
    if not index.size or float(np.broadcast_to(bound, index.shape).sum()) < problem.total:
        # What is loaded cannot carry the load: start from everything that can touch.
        index = np.flatnonzero(touchable)
        pressure = np.zeros(index.size)
        pressure += problem.total / index.size
        if isinstance(problem.limit, np.ndarray):
            bound = problem.limit.ravel()[index]
    return index, project(pressure, bound, problem.total)


def _active_set_step(
    now: _Iterate,
    viewer: _Viewer,
    patches: _Patches,
    tolerance: float,
    max_iterations: int,
) -> NDArray[np.float64]:
    """Solve on the free pixels by conjugate gradients; return the pressure, kept admissible."""
    pressure, gap, unit = now.pressure, now.gap, viewer.unit
    bound = np.broadcast_to(viewer.limit(now.index), pressure.shape)
    # Pixels with pressure stay free even where the gap opens: the solve will empty them.
    free = np.where(pressure > 0, (pressure < bound) | (gap > 0), gap < 0)
    place = np.flatnonzero(free)
    if not place.size:
        return pressure
    limit = bound[place]
    centre = viewer.problem.total is not None
    x = pressure[place]
    residual = _centred(-gap[place], centre)
    first = _norm(residual) / unit
    size = _norm(pressure) or first
    enough = max(0.9 * tolerance, 0.1 * now.floor) * size
    patch = patches.around(now.index[place])
    free_index = patch.index(now.index[place])
    support = patch.operator.support(free_index)
    precondition = patch.inverse.on(free_index)
    direction: NDArray[np.float64] | None = None
    previous = 1.0
    while viewer.convolutions < max_iterations:
        z = _centred(precondition(residual / unit), centre)
        product = _dot(residual, z)
        if not product > 0:
            break
        direction = z if direction is None else z + (product / previous) * direction
        previous = product
        response = patch.operator.gather(support, direction)
        viewer.convolutions += 1
        curvature = _dot(direction, response)
        if curvature <= _FLAT * unit * _dot(direction, direction):
            # A wave that nothing resists: only the bounds end the step.
            x += _way(x, direction, limit) * direction
            break
        length = product / curvature
        x += length * direction
        residual -= length * _centred(response, centre)
        error = _norm(residual) / unit
        violation = _norm(x - np.clip(x, 0, limit))
        if error <= enough or violation > error:
            break
        if error < _REDUCTION * first and violation > 0.1 * error:
            break
    return _restored(pressure, place, x, limit, bound, viewer.problem.total)


def _dot(first: NDArray[np.float64], second: NDArray[np.float64]) -> float:
    # Not by BLAS: its threads spin for a while after each call, and the transforms need the cores.
    return float(np.einsum("i,i->", first, second))


def _norm(values: NDArray[Any]) -> float:
    values = values.astype(np.float64, copy=False)
    return math.sqrt(_dot(values, values))


def _centred(values: NDArray[np.float64], centre: bool) -> NDArray[np.float64]:
    return values - values.mean() if centre and values.size else values


def _way(
    x: NDArray[np.float64], direction: NDArray[np.float64], limit: NDArray[np.float64]
) -> float:
    """Return how far values within their bounds can move before the first of them meets one."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ways = np.where(direction > 0, limit - x, -x) / direction
    ahead = ways[ways > 0]
    return float(ahead.min()) if ahead.size and np.isfinite(ahead).any() else 0.0


def _restored(
    pressure: NDArray[np.float64],
    place: NDArray[np.int64],
    x: NDArray[np.float64],
    limit: NDArray[np.float64],
    bound: NDArray[np.float64],
    total: float | None,
) -> NDArray[np.float64]:
    """Return the pressure with the free values ``x`` back within the bounds and the load."""
    moved = pressure.copy()
    if total is None:
        moved[place] = np.clip(x, 0, limit)
        return moved
    moved[place] = 0
    left = total - float(moved.sum())
    # Moving only the free pixels keeps the others exactly on their bounds.
    if 0 <= left <= float(limit.sum()):
        moved[place] = project(x, limit, left)
        return moved
    moved[place] = x
    return project(moved, bound, total)


def _projected(now: _Iterate, viewer: _Viewer, rate: float) -> NDArray[np.float64]:
    """Return the admissible pressure nearest to a step down the gradient."""
    bound, total = viewer.limit(now.index), viewer.problem.total
    target = now.pressure - rate * now.gap
    return np.clip(target, 0, bound) if total is None else project(target, bound, total)


def _settled(now: _Iterate, viewer: _Viewer, tolerance: float) -> _Iterate:
    """Return a solution whose pixels are on the bounds that they belong to.

    The certificate does not tell a pixel at the ceiling from one a hair's breadth below it, nor
    where a pixel with a tiny ceiling belongs; the counted areas do. The last active-set step
    settles nearly all pixels, a good start need not.
    """
    bound = viewer.limit(now.index)
    target = _projected(now, viewer, 1 / viewer.unit)
    falls = (target <= 0) & (now.pressure > 0)
    rises = (target >= bound) & (now.pressure < bound)
    if not (falls | rises).any():
        return now
    settled = viewer.look(now.index, target)
    return settled if settled.certificate <= tolerance else now


def _projected_gradient(
    now: _Iterate, viewer: _Viewer, steps: int, max_iterations: int
) -> _Iterate:
    """Follow projected gradients with Barzilai–Borwein lengths; return the best pressure seen.

    A step may raise the energy above that before, but not above the highest of the last few, else
    it is cut at the minimum along its line; so pressures cannot be visited in a circle (Birgin,
    Martínez and Raydan 2000, doi:10.1137/S1052623497330963).
    """
    best = now
    rate = 1 / viewer.unit
    energies = [0.0]
    for _ in range(steps):
        if viewer.convolutions + 2 > max_iterations:
            break
        target = _projected(now, viewer, rate)
        after = viewer.look(now.index, target)
        start, end = _slopes(now, target, viewer)
        if not start < end:
            if not start < 0:
                break
            # Nothing resists this step.
            rate *= 10
            energies.append(energies[-1] + 0.5 * (start + end))
            now = after
            continue
        rate = _norm(target - now.pressure) ** 2 / (end - start)
        cut = 1.0
        if 0.5 * (start + end) + energies[-1] > max(energies[-_NONMONOTONE:]):
            cut = -start / (end - start)
            after = viewer.look(now.index, now.pressure + cut * (target - now.pressure))
        energies.append(energies[-1] + cut * start + 0.5 * cut**2 * (end - start))
        now = after
        if now.certificate < best.certificate:
            best = now
    return best
