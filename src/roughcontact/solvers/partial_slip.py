"""Tangential traction with Coulomb friction: a convex problem with one disc per pixel.

Minimize ½⟨q, K q⟩ - ⟨t + f, q⟩ over ``|q|`` ≤ b, where the rigid shift t is given, or the
multiplier of a given sum of q. The slip is s = t + f - K q: zero where ``|q|`` < b, along q where
``|q|`` = b.

On the coarsest grid a few projected-gradient steps find stick and slip roughly; each finer grid
starts from the ratio of traction to bound on the coarser grid. Semi-smooth Newton steps follow:
slipping pixels go to the rim of their disc and move along the rim, all others move freely. The
linear problem of each step is solved by preconditioned conjugate gradients, with the sum of q as a
constraint, no further than stick and slip are known. K q is computed in single precision, except
once near the solution and for the certificate.

References
----------
Kalker, Three-Dimensional Elastic Bodies in Rolling Contact (1990), doi:10.1007/978-94-015-7889-9;
Hintermüller, Ito and Kunisch 2002, SIAM J. Optim. 13, 865, doi:10.1137/S1052623401383558;
Birgin, Martínez and Raydan 2000, SIAM J. Optim. 10, 1196, doi:10.1137/S1052623497330963
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array
from roughcontact.solvers.operator import dot, norm
from roughcontact.solvers.preconditioner import block_edges, block_of, forces_on_blocks, own_part
from roughcontact.solvers.progress import Status

STICK = 1e-9
"""Relative distance of the traction from its bound below which a pixel slips."""

FORCE_TOLERANCE = 1e-10
"""Largest force error of a converged solution, over the largest force."""

# Projected-gradient steps on the coarsest grid, and after a failed Newton step.
_GRADIENT_STEPS = 10
# Maximum rounds of a solve, Newton steps of a round, and conjugate-gradient steps of each.
_ROUNDS, _NEWTON, _INNER = 4, 30, 200
# Reduction of the residual of the linear problem: in general, and if the error of stick and slip
# exceeds the residual by the third factor.
_FORCING, _ROUGH, _SETS = 0.05, 0.3, 1.5
# Approximate relative error of the energy of a stiffness.
_RESPONSE = 1e-5
# Certificate on coarse grids, and the certificate below which a sum of displacements in single
# precision is recomputed.
_COARSE, _NEAR = 1e-2, 1e-3
# Minimum response of the inverse to a uniform displacement.
_STIFFEST = 1e-6


class TangentialOperator(Protocol):
    """Operator from tractions, shape (2, n), to the tangential displacement of the pixels."""

    @property
    def shape(self) -> tuple[int, int]:
        """Grid points ``(ny, nx)`` of the map."""

    @property
    def self_displacement(self) -> float:
        """Largest displacement of a pixel under unit traction on itself, K₀₀ [m/Pa]."""

    def support(self, index: NDArray[np.int64]) -> Any:
        """Prepare the pixels with these ascending flat indices for `gather`."""

    def gather(self, support: Any, traction: Array) -> Array:
        """Return the displacement of the loaded pixels."""

    def to_single_precision(self) -> TangentialOperator:
        """Return the operator in single precision."""

    def approximate_inverse(self) -> TangentialOperator:
        """Return an approximate ``displacement / K₀₀ → traction``."""

    def coarser(self, times: tuple[int, int], /) -> TangentialOperator:
        """Return the operator on pixels ``times[0] × times[1]`` times as large."""


@dataclass(frozen=True, eq=False)
class PartialSlipProblem:
    """Bounds and driving terms of a traction; fields have shape (2, n), components (y, x)."""

    index: NDArray[np.int64]  # Flat indices of the pixels, ascending
    bound: Array  # Largest traction of each pixel [Pa], positive, shape (n,)
    offset: Array  # f [m]
    total: Array | None = None  # Sum of the traction over the pixels [Pa], shape (2,)
    shift: Array | None = None  # t [m], shape (2,), if the sum is not given
    start: Array | None = None  # Initial traction [Pa]
    scale: float = 0.0  # Minimum of the norm that residuals are compared with [Pa]


@dataclass(frozen=True, eq=False)
class PartialSlipSolution:
    """Traction with its certificate."""

    traction: Array  # q [Pa], shape (2, n)
    slip: Array  # s = t + f - K q [m], shape (2, n)
    shift: Array  # t [m], shape (2,)
    certificate: float  # ‖q - Π(q + s/K₀₀)‖ over the larger of ‖q‖ and the scale
    force_error: float  # |Σq - total| over Σb; 0 if the shift is given
    status: Status
    steps: int  # Newton steps
    applications: int  # Operator applications: two transforms forward and back each


def project_to_discs(values: Array, bound: Array) -> Array:
    """Return the projection of values onto the discs, shape (2, n)."""
    size = np.hypot(*values)
    outside = size > bound
    factor = np.ones_like(size)
    factor[outside] = bound[outside] / size[outside]
    return values * factor


def project_with_sum(values: Array, bound: Array, total: Array) -> tuple[Array, Array]:
    """Return the projection onto the discs with a given sum, and its shift.

    The shift c of Π(v + c) minimizes a smooth convex function, by damped Newton steps.
    """
    shift = np.zeros(2)
    limit = float(bound.sum())
    cap = 0.5 * (np.hypot(*values).max(initial=0.0) + bound.max(initial=0.0))
    clipped, lack, dual, matrix = _dual(values, bound, total, shift)
    for _ in range(100):
        if math.hypot(*lack) <= 1e-14 * limit:
            break
        matrix += 1e-12 * np.trace(matrix) * np.eye(2) + np.finfo(float).tiny * np.eye(2)
        step = np.linalg.solve(matrix, lack)
        step *= min(1.0, (cap + math.hypot(*shift)) / math.hypot(*step))
        for _ in range(30):
            tried = _dual(values, bound, total, shift + step)
            if tried[2] < dual or math.hypot(*tried[1]) < 0.5 * math.hypot(*lack):
                break
            step *= 0.5
        else:
            break
        shift = shift + step
        clipped, lack, dual, matrix = tried
    return clipped, shift


def _dual(
    values: Array, bound: Array, total: Array, shift: Array
) -> tuple[Array, Array, float, Array]:
    """Return Π(v + c), its missing sum, the dual function of c and its second derivative."""
    moved = values + shift[:, None]
    size = np.hypot(*moved)
    outside = size > bound
    ratio = np.ones_like(size)
    ratio[outside] = bound[outside] / size[outside]
    clipped = moved * ratio
    y, x = np.divide(moved, size, out=np.zeros_like(moved), where=outside)
    energy = np.where(outside, bound * (size - 0.5 * bound), 0.5 * size**2)
    mixed = -(ratio * y * x).sum()
    matrix = np.array([[(ratio * (1 - y * y)).sum(), mixed], [mixed, (ratio * (1 - x * x)).sum()]])
    return clipped, total - clipped.sum(axis=1), float(energy.sum() - total @ shift), matrix


def solve(
    operator: TangentialOperator, problem: PartialSlipProblem, tolerance: float = 1e-6
) -> PartialSlipSolution:
    """Return the traction under given bounds and a given sum or shift.

    Parameters
    ----------
    operator : TangentialOperator
        Operator from traction to displacement.
    problem : PartialSlipProblem
        Bounds, offset, and the sum or the shift. A sum must be less than the sum of the bounds.
    tolerance : float
        Certificate to reach.

    Returns
    -------
    PartialSlipSolution
        The traction, with a certificate computed from the traction alone.
    """
    return _Solver(operator, problem).solve(tolerance)


class _Iterate(NamedTuple):
    """Approximate solution of the linear problem of a step."""

    step: Array  # z
    moved: Array  # K times z and the change to the rim
    shift: Array  # t
    residual: Array
    square: float  # ⟨residual, M residual⟩


@dataclass(frozen=True, eq=False)
class _State:
    """Traction, its displacement and the shift, in the units of the solver."""

    traction: Array
    displacement: Array
    shift: Array

    def after(self, rim: Array, iterate: _Iterate, part: float = 1.0) -> _State:
        """Return the state after a fraction of a Newton step."""
        return _State(
            self.traction + part * (rim + iterate.step),
            self.displacement + part * iterate.moved,
            self.shift + part * iterate.shift,
        )


class _Space:
    """Admissible changes of traction: free if a pixel sticks, along the rim if it slips."""

    def __init__(self, target: Array, bound: Array) -> None:
        size = np.hypot(*target)
        self.slips = size > bound
        self.normal = np.divide(target, size, out=np.zeros_like(target), where=self.slips)
        self.stiffness = np.zeros_like(bound)
        outside = size[self.slips] - bound[self.slips]
        self.stiffness[self.slips] = outside / bound[self.slips]
        self.weight = 1 / np.sqrt(1 + self.stiffness)

    def along(self, values: Array) -> Array:
        """Return the projection of a field onto the space."""
        across: Array = (values * self.normal).sum(axis=0)
        return values - across * self.normal


class _Blocks:
    """Interaction of spots, which the wrapped inverse neglects.

    See `roughcontact.solvers.preconditioner.FreePixelInverse`; D is separate for each component.
    """

    def __init__(self, operator: TangentialOperator, index: NDArray[np.int64]) -> None:
        edges = block_edges(operator.shape)
        assert edges is not None
        self.blocks = operator.coarser(edges).to_single_precision()
        (by, bx), area = self.blocks.shape, edges[0] * edges[1]
        self.block = block_of(index, operator.shape[1], edges, bx)
        touching = np.bincount(self.block, minlength=by * bx)
        self.number, self.touching = by * bx, np.flatnonzero(touching)
        self.support = self.blocks.support(self.touching)
        self.own = own_part(touching[self.touching], edges)
        self.softness = 1 / (operator.self_displacement * area)

    def inverse_correction(self, weight: Array) -> Callable[[Array], Array]:
        """Return the correction of the wrapped inverse.

        Parameters
        ----------
        weight : ndarray, shape (2, n)
            Response of the wrapped inverse to a uniform displacement, by component.
        """
        yielding = 1 / self.block_sums(weight)
        own, itself = yielding * self.own, self.softness * self.blocks.self_displacement

        def shared(values: Array) -> Array:
            common = yielding * self.block_sums(weight * values)
            common -= yielding * forces_on_blocks(self.displacement, common, own, itself)
            spread = np.zeros((2, self.number))
            spread[:, self.touching] = common
            return weight * spread[:, self.block]

        return shared

    def block_sums(self, values: Array) -> Array:
        """Return the sums of both components over the pixels of each block in contact."""
        parts: Array = np.stack(
            [np.bincount(self.block, row, minlength=self.number) for row in values]
        )
        return parts[:, self.touching]

    def displacement(self, force: Array) -> Array:
        """Return C times the forces on the blocks."""
        return self.blocks.gather(self.support, force) * self.softness


class _Inverse:
    """Approximate solution of (K + Λ) z = values in the space of a step."""

    def __init__(
        self, wrapped: Callable[[Array], Array], blocks: _Blocks | None, space: _Space
    ) -> None:
        self.wrapped, self.space = wrapped, space
        shape = space.normal.shape
        units = [space.along(np.broadcast_to(unit[:, None], shape)) for unit in np.eye(2)]
        self.uniform = [self.apply_wrapped(unit) for unit in units]
        self.shared = None
        if blocks is not None:
            weight = np.maximum(np.stack([self.uniform[0][0], self.uniform[1][1]]), _STIFFEST)
            self.shared = blocks.inverse_correction(weight)
            self.uniform = [
                self.apply_corrected(*pair) for pair in zip(self.uniform, units, strict=True)
            ]

    def __call__(self, values: Array) -> Array:
        """Return the approximate solution z."""
        return self.apply_corrected(self.apply_wrapped(values), values)

    def apply_wrapped(self, values: Array) -> Array:
        """Return z by the wrapped inverse alone."""
        return self.space.along(self.space.weight * self.wrapped(self.space.weight * values))

    def apply_corrected(self, answer: Array, values: Array) -> Array:
        """Return z corrected for the interaction of spots."""
        return answer if self.shared is None else answer - self.space.along(self.shared(values))


class _Solver:
    """Solver in units of the largest bound, with K₀₀ = 1."""

    def __init__(self, operator: TangentialOperator, problem: PartialSlipProblem) -> None:
        self.operator, self.problem = operator, problem
        self.pressure = float(problem.bound.max())
        self.length = self.pressure * operator.self_displacement
        self.bound = problem.bound / self.pressure
        self.offset = problem.offset / self.length
        self.total = None if problem.total is None else problem.total / self.pressure
        self.support = operator.support(problem.index)
        self.rough = operator.to_single_precision()
        self.rough_support = self.rough.support(problem.index)
        wrapped = operator.approximate_inverse()
        self.wrapped = partial(wrapped.gather, wrapped.support(problem.index))
        small = block_edges(operator.shape) is None
        self.blocks = None if small else _Blocks(operator, problem.index)
        self.applications = 0
        self.points = self.bound.size

    def apply(self, traction: Array) -> Array:
        """Return K q."""
        self.applications += 1
        return self.operator.gather(self.support, traction) / self.operator.self_displacement

    def apply_single(self, traction: Array) -> Array:
        """Return K q in single precision."""
        self.applications += 1
        displacement = self.rough.gather(self.rough_support, traction)
        return displacement / self.operator.self_displacement

    def dot(self, first: Array, second: Array) -> float:
        """Return the inner product of two fields."""
        return dot(first.ravel(), second.ravel())

    def compute_slip(self, state: _State) -> Array:
        """Return s = t + f - K q."""
        return state.shift[:, None] + self.offset - state.displacement

    def project(self, values: Array) -> tuple[Array, Array]:
        """Return the nearest admissible traction, and its shift."""
        if self.total is None:
            return project_to_discs(values, self.bound), np.zeros(2)
        return project_with_sum(values, self.bound, self.total)

    def merit(self, state: _State) -> float:
        """Return the residual of the friction conditions and of the force."""
        change = state.traction - project_to_discs(
            state.traction + self.compute_slip(state), self.bound
        )
        square = self.dot(change, change)
        if self.total is not None:
            lack = self.total - state.traction.sum(axis=1)
            square += float(lack @ lack) / self.points
        return math.sqrt(square)

    def solve(self, tolerance: float) -> PartialSlipSolution:
        """Return the solution."""
        state, newton, near = self.start(), 0, False
        for _ in range(_ROUNDS):
            size = self.norm(state)
            for _ in range(_NEWTON):
                merit = self.merit(state)
                if not near and merit <= max(_NEAR, tolerance) * size:
                    # Later changes are small, and so is their rounding in single precision.
                    state, near = self.make_state(state.traction, state.shift), True
                    continue
                if merit <= 0.5 * tolerance * size:
                    break
                tried = self.newton_step(state, merit, 0.5 * tolerance * size)
                newton += 1
                state = self.descend(state) if tried is None else tried
            solution = self.certify(state, newton)
            if solution.certificate <= tolerance and solution.force_error <= FORCE_TOLERANCE:
                return replace(solution, status=Status.CONVERGED)
            # The projection onto the discs has moved the traction.
            state = self.make_state(solution.traction / self.pressure, state.shift)
        return solution

    def norm(self, state: _State) -> float:
        """Return the reference norm of residuals."""
        return max(norm(state.traction.ravel()), self.problem.scale / self.pressure)

    def start(self) -> _State:
        """Return the initial state."""
        given = self.problem.shift
        shift = np.zeros(2) if given is None else given / self.length
        rough = self.problem.start is None and self.blocks is None
        if self.problem.start is not None:
            traction = self.project(self.problem.start / self.pressure)[0]
        elif not rough:
            traction = self.from_coarser()
        else:
            part = np.zeros(2) if self.total is None else self.total / float(self.bound.sum())
            traction = part[:, None] * self.bound
        state = _State(traction, self.apply_single(traction), shift)
        if rough:
            return self.descend(state)
        if self.total is not None:
            # Estimate the shift first: from far away the projection does not find it.
            shift = -(self.bound * self.compute_slip(state)).sum(axis=1) / float(self.bound.sum())
            state = replace(state, shift=shift)
        return replace(state, shift=shift + self.project(traction + self.compute_slip(state))[1])

    def from_coarser(self) -> Array:
        """Return the traction with the ratio to its bound from a grid of doubled pixels."""
        problem, shape = self.problem, self.operator.shape
        times = (min(2, shape[0]), 2)
        coarse = self.operator.coarser(times)
        block = block_of(problem.index, shape[1], times, coarse.shape[1])
        pixels, number = times[0] * times[1], coarse.shape[0] * coarse.shape[1]

        def mean(values: Array) -> Array:
            return np.bincount(block, values, minlength=number) / pixels

        bound = mean(problem.bound)
        index = np.flatnonzero(bound)
        offset = np.stack([mean(problem.bound * row)[index] for row in problem.offset])
        solution = solve(
            coarse,
            PartialSlipProblem(
                index,
                bound[index],
                offset / bound[index],
                total=None if problem.total is None else problem.total / pixels,
                shift=problem.shift,
                scale=problem.scale,
            ),
            _COARSE,
        )
        part = np.zeros((2, number))
        part[:, index] = solution.traction / bound[index]
        return part[:, block] * self.bound

    def make_state(self, traction: Array, shift: Array) -> _State:
        """Return the state of a traction, in the precision of the operator."""
        return _State(traction, self.apply(traction), shift)

    def descend(self, state: _State) -> _State:
        """Return the state after some projected-gradient steps of Barzilai and Borwein."""
        length = 1.0
        for _ in range(_GRADIENT_STEPS):
            slip = self.compute_slip(state)
            traction, moved = self.project(state.traction + length * slip)
            following = _State(traction, self.apply_single(traction), state.shift + moved / length)
            change = traction - state.traction
            square = self.dot(change, change)
            work = self.dot(change, following.displacement - state.displacement)
            state = following
            if not (square > 0 and work > 0):
                break
            length = square / work
        return state

    def newton_step(self, state: _State, merit: float, enough: float) -> _State | None:
        """Return the state after a Newton step, or None if no fraction of it is better."""
        slip = self.compute_slip(state)
        space = _Space(state.traction + slip, self.bound)
        rim = np.where(space.slips, self.bound * space.normal - state.traction, 0.0)
        lack = None if self.total is None else self.total - (state.traction + rim).sum(axis=1)
        first = 0.0
        for iterate in self.iterates(space, slip, rim, lack):
            first = first or iterate.square
            value = self.merit(state.after(rim, iterate))
            left = iterate.residual + space.along(
                np.broadcast_to(iterate.shift[:, None], slip.shape)
            )
            blurred = value > _SETS * norm(left.ravel())
            forcing = _ROUGH if blurred else _FORCING
            if value <= enough or iterate.square <= forcing**2 * first:
                break
        best = None
        for part in (1.0, 0.5, 0.25):
            tried = state.after(rim, iterate, part)
            value = self.merit(tried)
            if value < 0.9 * merit:
                return tried
            if value < merit and best is None:
                best = tried
        return best

    def iterates(
        self, space: _Space, driving: Array, rim: Array, lack: Array | None
    ) -> Iterator[_Iterate]:
        """Yield improving solutions z in the space of (K + Λ) z = driving + t - K rim.

        Parameters
        ----------
        space : _Space
            Space of z, with Λ.
        driving : ndarray, shape (2, n)
            Slip to remove.
        rim : ndarray, shape (2, n)
            Change of the traction before z.
        lack : ndarray, shape (2,), or None
            Required sum of z, with t as its multiplier; without it t is 0.
        """
        invert = _Inverse(self.wrapped, self.blocks, space)
        step, inverse, shift = np.zeros_like(driving), np.zeros((2, 2)), np.zeros(2)
        if lack is not None:
            sums = np.array([field.sum(axis=1) for field in invert.uniform]).T
            inverse = np.linalg.pinv(sums, rcond=1e-9)
            step = _combine_fields(invert.uniform, inverse @ lack)
        moved = self.apply_single(rim + step)
        residual: Array = space.along(driving - moved) - space.stiffness * step
        response, last = residual, 1.0
        direction: Array = np.zeros_like(step)
        for _ in range(_INNER):
            gradient = invert(residual)
            if lack is not None:
                shift = -inverse @ gradient.sum(axis=1)
                gradient += _combine_fields(invert.uniform, shift)
            square = self.dot(residual, gradient)
            yield _Iterate(step, moved, shift, residual, square)
            if square <= 0:
                return
            # The inverse is not quite linear: see `roughcontact.solvers.active_set`.
            direction = gradient - self.dot(response, gradient) / last * direction
            last = square
            displaced = self.apply_single(direction)
            response = space.along(displaced) + space.stiffness * direction
            length = square / self.dot(direction, response)
            step = step + length * direction
            moved = moved + length * displaced
            response *= length
            residual = residual - response

    def certify(self, state: _State, steps: int) -> PartialSlipSolution:
        """Return the nearest admissible traction and the certificate computed from it."""
        traction, _ = self.project(state.traction)
        final = self.make_state(traction, state.shift)
        slip = self.compute_slip(final)
        change = norm((traction - project_to_discs(traction + slip, self.bound)).ravel())
        force_error = 0.0
        if self.total is not None:
            force_error = math.hypot(*(self.total - traction.sum(axis=1)))
        size = self.norm(final)
        return PartialSlipSolution(
            traction=traction * self.pressure,
            slip=slip * self.length,
            shift=state.shift * self.length,
            certificate=change / size if size else 0.0,
            force_error=force_error / float(self.bound.sum()),
            status=Status.STALLED,
            steps=steps,
            applications=self.applications,
        )


def _combine_fields(fields: list[Array], factors: Array) -> Array:
    """Return the sum of two fields times factors."""
    return factors[0] * fields[0] + factors[1] * fields[1]


def stiffness(
    operator: TangentialOperator,
    index: NDArray[np.int64],
    direction: Array,
    solution: tuple[Array, Array, Array] | None = None,
) -> float:
    """Return the derivative of the traction sum by the shift along a direction [Pa/m].

    Parameters
    ----------
    operator : TangentialOperator
        Operator from traction to displacement.
    index : ndarray of int, shape (n,)
        Flat indices of the pixels in contact.
    direction : ndarray, shape (2,)
        Unit vector of the growing force.
    solution : (traction, slip, bound), optional
        A solved state; by default the whole contact sticks.
    """
    bound = np.ones(index.size)
    traction = slip = np.zeros((2, index.size))
    if solution is not None:
        traction, slip, bound = solution
    solver = _Solver(operator, PartialSlipProblem(index, bound, np.zeros((2, index.size))))
    space = _Space((traction / solver.pressure + slip / solver.length), solver.bound * (1 - STICK))
    none = np.zeros_like(slip)
    for step, moved, _, _, square in solver.iterates(space, none, none, direction):
        energy = solver.dot(step, moved + space.stiffness * step)
        if square <= _RESPONSE * energy:
            break
    force = float(direction @ step.sum(axis=1))
    return force**2 / (energy * operator.self_displacement) if energy > 0 else 0.0
