"""Bounded contact problem: pressures that close the gap without exceeding the ceiling.

Minimize ½⟨p, K p⟩ + ⟨h₀, p⟩ over 0 ≤ p ≤ limit, with a given sum of p or a given approach ω.
Differences from the textbook methods (Polonsky and Keer 1999,
doi:10.1016/S0043-1648(99)00113-1; Hintermüller, Ito and Kunisch 2002,
doi:10.1137/S1052623401383558):

- The set of free pixels follows from the pressure and the gap (active-set, or semi-smooth Newton,
  step); the linear problem on the set is solved by preconditioned conjugate gradients just far
  enough that the error of the set and the error on the set are similar. One convolution each.
- The approach is the multiplier of an exact projection, never the mean gap over the free pixels:
  with a ceiling there may be few of them, or none.
- A step that raises the energy is cut at the minimum along its line and followed by projected
  gradient steps, which find the set of free pixels more slowly but reliably. If these stall,
  solutions on the free pixels are approached along the bounds that they violate.
- Everything but the transforms works on the pixels in or near contact; the only whole-map passes
  are part of the transforms, while a block of rows is in cache.
- The first pressure comes from the same problem with half the points along each axis, recursively.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array, Shape
from roughcontact.solvers import active_set
from roughcontact.solvers.operator import Family, Operator, norm
from roughcontact.solvers.problem import BoundedProblem, Loaded, coarsen_problem, prolong_pressure
from roughcontact.solvers.progress import Status, Step

# Tolerance on coarse grids: below it the discretization error exceeds the solver error.
_COARSE_TOLERANCE = 3e-3
_COARSEST = 32
# Steps without a better certificate before bursts of projected gradients and steps along an arc
# alternate; number of projected-gradient steps after an overshoot, doubled with every burst;
# maximum number of bursts; number of steps over which the energy may rise.
_MAX_STALLS = 3
_BURST = 6
_BURSTS = 20
_NONMONOTONE = 5


@dataclass(frozen=True, eq=False)
class BoundedSolution:
    """Solution of a bounded problem.

    Parameters
    ----------
    index : ndarray of int, shape (n,)
        Flat indices of the pixels with pressure, ascending.
    pressure : ndarray, shape (n,)
        Pressure on these pixels [Pa].
    gap : ndarray, shape (ny, nx)
        Gap recomputed from this pressure [m]; ``inf`` where the bodies never touch.
    approach : float
        ω [m].
    certificate : float
        ε of this pressure and gap.
    status : Status
        Why the solver stopped.
    iterations, convolutions : int
        Numbers on the finest grid.
    history : tuple of Step
        Every evaluation of the whole map, including coarse grids.
    tilt : (float, float)
        Increase of the gap per lever along y and x, if the bodies tilt [m].
    """

    index: NDArray[np.int64]
    pressure: Array
    gap: NDArray[Any]
    approach: float
    certificate: float
    status: Status
    iterations: int
    convolutions: int
    history: tuple[Step, ...]
    tilt: tuple[float, float] = (0.0, 0.0)


def solve(
    problem: BoundedProblem,
    family: Family,
    *,
    tolerance: float,
    max_iterations: int,
    start: Loaded | None = None,
    progress: Callable[[Step], None] | None = None,
    interruptible: bool = False,
) -> BoundedSolution:
    """Return the pressure that solves a bounded contact problem.

    Parameters
    ----------
    problem : BoundedProblem
        Problem to solve; it must be feasible.
    family : callable
        ``family(shape, (ky, kx))`` returns the `Operator` ``pressure → displacement`` on a map of
        this shape whose pixels are as large as ``ky × kx`` pixels of the finest map.
    tolerance : float
        Certificate ε at which the solution is converged.
    max_iterations : int
        Maximum number of convolutions on each grid.
    start : (ndarray of int, ndarray), shapes (n,), optional
        Pixels, ascending, and pressure [Pa] to start from, such as those of a neighboring
        load; by default the first pressure comes from coarser grids.
    progress : callable, optional
        Called with each `Step`.
    interruptible : bool
        Whether a ``KeyboardInterrupt`` ends the solve and returns the best result.

    Returns
    -------
    BoundedSolution
        The solution, or the best approximation with a status that gives the reason.
    """
    history: list[Step] = []
    levels = [problem] if start is not None else _levels(problem)
    shapes = [level.shape for level in levels]

    def note(step: Step) -> None:
        history.append(replace(step, done=_share_done((*history, step), shapes, tolerance)))
        if progress is not None:
            progress(history[-1])

    # Created and released where needed: in full contact it is twice as large as the map.
    first: Callable[[], Loaded] = partial(_initial_pressure, levels[-1], start)
    # The largest operator first: coarse operators then use its memory.
    finest_operator = family(problem.shape, (1, 1))
    for depth in range(len(levels) - 1, -1, -1):
        level = levels[depth]
        finest = depth == 0
        pixel = (2**depth if problem.shape[0] > 1 else 1, 2**depth)
        level_operator = finest_operator if finest else family(level.shape, pixel)
        solution = _solve_level(
            level,
            level_operator,
            family,
            pixel,
            first,
            tolerance if finest else max(tolerance, _COARSE_TOLERANCE),
            max_iterations,
            note,
            warm=start is not None,
            interruptible=interruptible,
        )
        if solution.status is Status.INTERRUPTED:
            max_iterations = 0  # Only evaluate the pressure on finer grids
        if not finest:
            loaded = solution.index, solution.pressure
            finer = levels[depth - 1].initial_gap.shape
            first = partial(prolong_pressure, loaded, solution.gap.shape[1], finer)
            del levels[depth], solution, loaded
    near = solution.status is Status.INTERRUPTED and solution.certificate <= tolerance
    status = Status.CONVERGED if near else solution.status
    return replace(solution, status=status, history=tuple(history))


def _share_done(
    history: Sequence[Step], shapes: Sequence[tuple[int, int]], tolerance: float
) -> float:
    """Return the completed share of a solve, from points and digits gained on each grid."""
    now = history[-1]
    first = next(step.certificate for step in history if step.shape == now.shape)
    gained = 1.0
    if now.certificate > now.tolerance:
        ratios = first / now.certificate, first / now.tolerance
        known = all(1 < ratio < math.inf for ratio in ratios)
        gained = math.log(ratios[0]) / math.log(ratios[1]) if known else 0.0
    goals = [tolerance, *[_COARSE_TOLERANCE] * (len(shapes) - 1)]
    work = [
        math.prod(shape) * math.log(1 / min(goal, 0.1))
        for shape, goal in zip(shapes, goals, strict=True)
    ]
    number = shapes.index(now.shape)
    return math.fsum([*work[number + 1 :], gained * work[number]]) / math.fsum(work)


def coarser_grids(shape: Shape) -> int:
    """Return the number of coarser grids, each with doubled pixel edges."""
    # A profile of this number of points is treated as a small map.
    minimum = 2 * (_COARSEST if shape[0] > 1 else _COARSEST**2)
    points, number = min(shape[shape[0] == 1 :]), 0
    while points >= minimum:
        points, number = -(-points // 2), number + 1
    return number


def _levels(problem: BoundedProblem) -> list[BoundedProblem]:
    """Return the problem on its grid and on successively coarser grids."""
    levels = [problem]
    for _ in range(coarser_grids(problem.shape)):
        levels.append(coarsen_problem(levels[-1]))
    return levels


def _initial_pressure(problem: BoundedProblem, start: Loaded | None) -> Loaded:
    """Return the given initial pressure, or else a uniform one."""
    if start is not None:
        return start
    pixels = problem.initial_gap.size
    mean = (problem.total or 0.0) / math.prod(problem.shape)
    return np.arange(pixels), np.full(pixels, mean)


def _is_stagnant(certificate: float, floor: float, bursts: int) -> bool:
    """Return whether the certificate is near its rounding error, or no burst is left."""
    return certificate <= 10 * floor or bursts == _BURSTS


def _solve_level(
    problem: BoundedProblem,
    operator: Operator,
    family: Family,
    pixel: tuple[int, int],
    first: Callable[[], Loaded],
    tolerance: float,
    max_iterations: int,
    note: Callable[[Step], None],
    *,
    warm: bool,
    interruptible: bool,
) -> BoundedSolution:
    viewer = active_set.Evaluator(problem, operator, family, pixel, tolerance, max_iterations)
    loaded = first()
    if warm:
        loaded = viewer.scale_to_load(*loaded)
    now = best = viewer.evaluate(*active_set.project_admissible(viewer.problem, loaded))
    del loaded
    iteration, fruitless, bursts = 0, 0, 0
    try:
        while True:
            note(Step(problem.shape, iteration, viewer.convolutions, now.certificate, tolerance))
            if now.certificate <= tolerance:
                now = active_set.snap_to_bounds(now, viewer)
                status = Status.CONVERGED
                break
            if not viewer.is_within_limit:
                status = Status.CONVOLUTION_LIMIT if max_iterations else Status.INTERRUPTED
                break
            if fruitless >= _MAX_STALLS and _is_stagnant(best.certificate, best.floor, bursts):
                status = Status.STALLED
                break
            iteration += 1
            if fruitless < _MAX_STALLS:
                after = _next_iterate(now, viewer)
            else:
                after = (
                    active_set.step_along_arc(best, viewer)
                    if bursts % 2
                    else projected_gradient(now, viewer, _BURST << min(bursts // 2, 6))
                )
                bursts, fruitless = bursts + 1, -1
            fruitless = 0 if after.certificate < 0.9 * best.certificate else fruitless + 1
            now = after
            if now.certificate < best.certificate:
                best = now
    except KeyboardInterrupt:
        if not interruptible:
            raise
        status = Status.INTERRUPTED
    if now.certificate > best.certificate and status is not Status.CONVERGED:
        now = best
    now = viewer.confirm(now)
    index, pressure = active_set.select_entries(now.pressure > 0, now.index, now.pressure)
    viewer.open -= viewer.open.dtype.type(now.approach)
    return BoundedSolution(
        index=index,
        pressure=pressure,
        gap=viewer.open,
        approach=now.approach,
        certificate=now.certificate,
        status=status,
        iterations=iteration,
        convolutions=viewer.convolutions,
        history=(),
        tilt=now.tilt,
    )


def _next_iterate(now: active_set.Iterate, viewer: active_set.Evaluator) -> active_set.Iterate:
    """Return the iterate after an active-set step, or after its fallback if it overshoots."""
    moved = active_set.active_set_step(now, viewer)
    after = viewer.evaluate(now.index, moved)
    if after.certificate > now.certificate and viewer.is_within_limit:
        start, end = active_set.slopes(now, moved, viewer)
        # Where the set of free pixels is far off, the step overshoots: the energy rises.
        if start < 0 < start + end:
            # Release the iterate: each holds three arrays of the contact.
            del after
            moved = _interpolate_iterates(now.pressure, moved, start / (start - end))
            return projected_gradient(viewer.evaluate(now.index, moved), viewer, _BURST)
    return after


def _interpolate_iterates(start: Array, end: Array, cut: float) -> Array:
    """Return the point at a fraction of a step, in the memory of its end."""
    end -= start
    end *= cut
    end += start
    return end


def projected_gradient(
    now: active_set.Iterate, viewer: active_set.Evaluator, steps: int
) -> active_set.Iterate:
    """Return the best iterate of projected gradient steps with Barzilai–Borwein lengths.

    A step may raise the energy, but not above the highest of the last few values; otherwise it is
    cut at the minimum along its line, so that iterates cannot cycle (Birgin, Martínez and Raydan
    2000, doi:10.1137/S1052623497330963).
    """
    best = now
    rate = 1 / viewer.unit
    energies = [0.0]
    for _ in range(steps):
        if viewer.convolutions + 2 > viewer.max_iterations:
            break
        target = active_set.project_step(now, viewer, rate)
        after = viewer.evaluate(now.index, target)
        start, end = active_set.slopes(now, target, viewer)
        if not start < end:
            if not start < 0:
                break
            # A step without resistance.
            rate *= 10
            energies.append(energies[-1] + 0.5 * (start + end))
        else:
            rate = norm(target - now.pressure) ** 2 / (end - start)
            cut = 1.0
            if 0.5 * (start + end) + energies[-1] > max(energies[-_NONMONOTONE:]):
                cut = -start / (end - start)
                del after
                target = _interpolate_iterates(now.pressure, target, cut)
                after = viewer.evaluate(now.index, target)
            energies.append(energies[-1] + cut * start + 0.5 * cut**2 * (end - start))
        now = after
        if now.certificate < best.certificate:
            best = now
    return best
