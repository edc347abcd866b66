"""Load increments of yielding bodies: strain, contact and stress in one loop.

A load increment is one convex problem in the plastic strain that it adds: the elastic energy with
the contact solved for its pressure, plus the energy that plastic flow dissipates and hardening
stores. Its gradient is minus the stress, with Lipschitz constant 2μ on deviators, and the proximal
map of dissipation and hardening is the radial return. So one loop is sufficient::

    strain → displacement of the surface → pressure of the contact → stress → radial return

An iteration is a proximal gradient step with step size 1/(2μ), which always descends; Anderson
acceleration makes the loop fast. There is no relaxation and no nested loop except the contact
solver, which starts each time from the previous pressure.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughcontact.elastoplastic import plastic_flow
from roughcontact.elastoplastic.checkpoints import Checkpoint
from roughcontact.elastoplastic.plastic_flow import Parts
from roughcontact.elastoplastic.problem import (
    ContactSolver,
    ElastoplasticProblem,
    Extent,
    is_within_memory,
)
from roughcontact.elastoplastic.volume_result import CONVERGED, GUARD, Increment, PathPoint
from roughcontact.errors import ArgumentRef, Sentence
from roughcontact.halfspace.fft import Workspace
from roughcontact.halfspace.layers import Pull
from roughcontact.halfspace.tensors import WEIGHTS
from roughcontact.solvers.problem import Loaded

Array = NDArray[Any]

# Number of stored steps; growth of the defect at which they are cleared.
_MEMORY = 6
_GROWTH = 3.0
# Iterations without a smaller defect before plain steps follow, and the number of plain steps.
_MAX_FRUITLESS_STEPS = 10
_PLAIN_STEPS = 8
# Relative size below which directions of the memory are treated as linearly dependent.
_DEPENDENT = 1e-7


class Mixer:
    """Anderson acceleration of a fixed point y = x(y) with a growing number of unknowns.

    The next iterate is the combination of the last ones whose defect f = x - y would be the
    smallest if x were linear (Anderson 1965, doi:10.1145/321296.321305; Walker and Ni 2011,
    doi:10.1137/10078356X), in the norm of the energy: tensor product, thickness, modulus. If the
    defect grows, the memory is cleared and a plain step follows; if it has not fallen for several
    iterations, several plain steps. These never raise the defect: they are averaged nonexpansive.
    """

    def __init__(self, weights: list[float], workspace: Workspace) -> None:
        self._weights, self._workspace = weights, workspace
        self._last: tuple[Parts, Parts] | None = None
        self._steps: list[tuple[Parts, Parts]] = []
        self._gram = np.zeros((0, 0))
        self._smallest = self._best = math.inf
        self._fruitless = self._plain = 0

    def grow(self, part: int, old: Array, new: Array) -> None:
        """Extend the stored vectors by the new unknowns of a part, with values of zero."""
        place = np.searchsorted(new, old)
        pairs = list(self._steps) if self._last is None else [*self._steps, self._last]
        for pair in pairs:
            for parts in pair:
                parts[part] = embed_columns(parts[part], place, new.size)

    def mix(self, x: Parts, defect: Parts) -> Parts:
        """Return the next iterate."""
        each, count = self._workspace.each, range(len(x))
        size = math.sqrt(self._products([(defect, defect)])[0])
        self._fruitless = 0 if size < self._best else self._fruitless + 1
        self._best = min(self._best, size)
        if self._fruitless == _MAX_FRUITLESS_STEPS:
            self._fruitless, self._plain = 0, _PLAIN_STEPS
        if self._plain or not size <= _GROWTH * self._smallest:
            self._steps, self._last, self._gram = [], None, np.zeros((0, 0))
            self._smallest = math.inf
        if self._plain:
            self._plain -= 1
            return [part.copy() for part in x]
        self._smallest = min(self._smallest, size)
        if self._last is not None:
            old_x, old_defect = self._last
            if len(self._steps) == _MEMORY:
                del self._steps[0]
                self._gram = self._gram[1:, 1:]

            def subtract(part: int) -> None:
                np.subtract(x[part], old_x[part], out=old_x[part])
                np.subtract(defect[part], old_defect[part], out=old_defect[part])

            each(subtract, count)
            self._steps.append((old_x, old_defect))
            row = self._products([(old_defect, step[1]) for step in self._steps])
            gram = np.empty((len(row), len(row)))
            gram[:-1, :-1], gram[-1], gram[:, -1] = self._gram, row, row
            self._gram = gram
        self._last = x, defect
        if not self._steps:
            return [part.copy() for part in x]
        right = self._products([(defect, step[1]) for step in self._steps])
        share = _least_squares(self._gram, right)
        mixed: Parts = [np.empty(0)] * len(x)

        def combine(part: int) -> None:
            result = x[part].copy()
            for factor, (step, _) in zip(share, self._steps, strict=True):
                result -= result.dtype.type(factor) * step[part]
            mixed[part] = result

        each(combine, count)
        return mixed

    def _products(self, pairs: list[tuple[Parts, Parts]]) -> NDArray[np.float64]:
        """Return the inner products of pairs of vectors."""
        sums = np.zeros((len(self._weights), len(pairs)))
        tensor = np.array(WEIGHTS)

        def add(part: int) -> None:
            if pairs and pairs[0][0][part].size:
                for number, (item, other) in enumerate(pairs):
                    each = np.einsum("ki,ki->k", item[part], other[part], dtype=np.float64)
                    sums[part, number] = self._weights[part] * (tensor @ each)

        self._workspace.each(add, range(len(self._weights)))
        result: NDArray[np.float64] = sums.sum(axis=0)
        return result


def embed_columns(values: Array, place: Array, size: int) -> Array:
    """Return the columns at given places of a wider array that is zero elsewhere."""
    wider = np.zeros((5, size), values.dtype)
    wider[:, place] = values
    return wider


def _least_squares(gram: NDArray[np.float64], right: NDArray[np.float64]) -> NDArray[np.float64]:
    """Solve normal equations without linearly dependent directions."""
    scale = np.sqrt(np.diag(gram))
    scale[scale == 0] = 1
    value, vector = np.linalg.eigh(gram / scale / scale[:, None])
    keep = value > _DEPENDENT * value[-1]
    share = vector[:, keep] @ ((vector[:, keep].T @ (right / scale)) / value[keep])
    return share / scale


# Largest number of times that a load increment is halved.
_MAX_CUTS = 5


@dataclass(frozen=True)
class IterationInfo:
    """State of the loop after an iteration."""

    load: float  # Current load [N]
    target: float  # Last load of the path [N]
    iteration: int  # Iterations at this load so far
    residual: float  # Residual, see `Increment`
    tolerance: float  # Residual at which the iteration ends


class IncrementInfo(NamedTuple):
    """Increment of the path: change of the load [N], shift in whole pixels."""

    load: float = 0.0
    y: int = 0
    x: int = 0


@dataclass(frozen=True, eq=False)
class LoopState:
    """Snapshot of a loop: plastic strain, and the start values of the next increment."""

    extent: Extent
    bodies: list[plastic_flow.StrainSnapshot]
    loaded: Loaded | None
    places: list[Parts]
    added: list[Parts]
    stride: IncrementInfo
    point: PathPoint


class IncrementLoop:
    """Loop over load increments and their iterations."""

    def __init__(
        self,
        problem: ElastoplasticProblem,
        solver: ContactSolver,
        workspace: Workspace,
        extent: Extent,
        *,
        deepen: bool,
    ) -> None:
        self.problem, self.solver, self._workspace = problem, solver, workspace
        self._deepen, self._widen = deepen, bool(problem.pair.boundary.free_axes)
        pair = problem.pair
        both = (pair.material, 1.0), (pair.counter_material, -1.0)
        yielding = [(body, sign) for body, sign in both if body.yield_strength is not None]
        self.bodies = [
            plastic_flow.YieldingBody(
                material, pair.pixel, pair.boundary, problem.precision, workspace, pulled=sign
            )
            for material, sign in yielding
        ]
        # Where the counter-body slides its strain moves with it.
        self._sliding = [number for number, (_, sign) in enumerate(yielding) if sign < 0]
        self._point, self._slid = PathPoint(0.0), (0.0, 0.0)
        self._resize(extent)

    def _resize(self, extent: Extent) -> None:
        """Enlarge the volume of all bodies, and reset the increment."""
        self.extent = extent
        self.solver.resize(extent.margin)
        ny, nx = self.solver.initial_gap.shape
        for body in self.bodies:
            body.resize(extent.thickness, (ny, nx))
        self._reset_increment()

    def _reset_increment(self) -> None:
        # Strain and step of the previous increment: the initial guess of the next.
        self._places, self._added = self._empty_increment()
        self._stride = IncrementInfo()

    def _empty_increment(self) -> tuple[list[Parts], list[Parts]]:
        """Return the positions and strains of an increment without plastic flow, by body."""
        return (
            [[np.empty(0, np.int64)] * len(body.strain) for body in self.bodies],
            [[np.empty((5, 0), body.real)] * len(body.strain) for body in self.bodies],
        )

    def carried_values(self) -> dict[str, Array]:
        """Return the values carried to the next load in addition to the state."""
        held = {"stride": np.array(self._stride)}
        if self.solver.loaded is not None:
            held["index"], held["pressure"] = self.solver.loaded
        for body, (places, added) in enumerate(zip(self._places, self._added, strict=True)):
            held[f"sizes_{body}"] = np.array([place.size for place in places])
            held[f"places_{body}"] = np.concatenate(places)
            held[f"added_{body}"] = np.concatenate(added, axis=1)
        return held

    def checkpoint(
        self, done: Sequence[Increment], largest: tuple[float, Array | None], seconds: float
    ) -> Checkpoint:
        """Return the state from which the next point starts, valid until it is visited."""
        bodies = [body.strain_on_map() for body in self.bodies]
        pressure = self.solver.pressure[self.solver.inside]
        return Checkpoint(
            self.extent, bodies, pressure, tuple(done), largest, seconds, self.carried_values()
        )

    def resume(self, before: Checkpoint) -> None:
        """Resume from a checkpoint."""
        points = [step.point for step in before.increments]
        for start, end in itertools.pairwise(points):
            self._slid = self._slip_at(start, end)
        self._slide(self._slid)
        for yielding, old in zip(self.bodies, before.bodies, strict=True):
            yielding.resume(*old)
        self.solver.resume(before.pressure)
        if before.increments:
            self._point = before.increments[-1].point
            self.solver.set_gap(self.problem.gap_at(self._point.offset), (0, 0))
        held = before.carried
        if not held:
            return
        # Empty arrays are not stored.
        load, *way = held["stride"].tolist()
        self._stride = IncrementInfo(load, *map(int, way))
        if "index" in held:
            self.solver.loaded = held["index"], held["pressure"]
        for body in range(len(self.bodies)):
            if f"places_{body}" in held:
                cuts = np.cumsum(held[f"sizes_{body}"])[:-1]
                self._places[body] = np.split(held[f"places_{body}"], cuts)
                self._added[body] = np.split(held[f"added_{body}"], cuts, axis=1)

    def snapshot(self) -> LoopState:
        """Return a snapshot for `restore`."""
        return LoopState(
            self.extent,
            [body.snapshot() for body in self.bodies],
            self.solver.loaded,
            [list(places) for places in self._places],
            [list(added) for added in self._added],
            self._stride,
            self._point,
        )

    def restore(self, state: LoopState) -> None:
        """Restore a snapshot; layers and points added since are kept."""
        for body, held in zip(self.bodies, state.bodies, strict=True):
            body.restore(held)
        self._move_counter_surface(state.point)
        if self.extent is state.extent:
            self.solver.loaded = state.loaded
            self._places = [list(places) for places in state.places]
            self._added = [list(added) for added in state.added]
            self._stride = state.stride
        else:
            self._reset_increment()

    @property
    def pull(self) -> Pull:
        """Traction on the rough body over the pressure, at the current point of the path."""
        return self._point.traction

    @property
    def flowing(self) -> bool:
        """Whether any plastic strain was added in the last increment."""
        return any(part.any() for added in self._added for part in added)

    def unfreeze_strain(self, *, copy: bool) -> None:
        """Make the plastic strain writable again, or a copy of it, which a result then keeps."""
        for body in self.bodies:
            if copy:
                body.strain, body.accumulated = body.strain.copy(), body.accumulated.copy()
            body.strain.flags.writeable = True

    def displacement(self) -> Array:
        """Return the displacement by the accepted strain, and prepare the mean stress."""
        places, added = self._empty_increment()
        displacement = np.zeros(self.solver.initial_gap.shape)
        for body, place, strain in zip(self.bodies, places, added, strict=True):
            displacement += body.displacement(place, strain, trace=True)
        return displacement

    def _move_counter_surface(self, point: PathPoint) -> None:
        """Move the counter-surface to a point of the path."""
        if point.offset != self._point.offset:
            way = self._pixel_path(self._point, point)
            self.solver.set_gap(self.problem.gap_at(point.offset), way)
        self._point = point

    def _slip_at(self, before: PathPoint, point: PathPoint) -> plastic_flow.Way:
        """Return the sliding distance of the counter-body at a point [pixels]."""
        if not point.friction:
            return self._slid
        ways = zip(self._slid, point.offset, before.offset, self.problem.pair.pixel, strict=True)
        y, x = (slid + (end - start) / edge for slid, end, start, edge in ways)
        return y, x

    def _slide(self, way: plastic_flow.Way) -> None:
        for number in self._sliding:
            self.bodies[number].slid = way

    def _pixel_path(self, before: PathPoint, point: PathPoint) -> tuple[int, int]:
        """Return the shift between two points, rounded to whole pixels."""
        edges, ends = self.problem.pair.pixel, zip(before.offset, point.offset, strict=True)
        y, x = (round((end - start) / edge) for (start, end), edge in zip(ends, edges, strict=True))
        return y, x

    def reach(
        self, point: PathPoint, done: list[Increment], watch: Callable[[float, int, float], None]
    ) -> str:
        """Solve a point of the path, in smaller steps if required; return the status."""
        todo = [point]
        before = done[-1].point if done else PathPoint(0.0, point.offset)
        cuts = 0
        while todo:
            point = todo[-1]
            loaded = self.solver.loaded
            self._move_counter_surface(point)
            slid = self._slip_at(before, point)
            self._slide(slid)
            result = self._relax(before, watch)
            if result is None:
                self._move_counter_surface(before)
                self._slide(self._slid)
                self.solver.loaded = loaded
                self._reset_increment()
                if cuts == _MAX_CUTS or (not done and point.load == 0):
                    return self._reason(point.load, cuts)
                cuts += 1
                todo.append(before.interpolate(point, 1, 2))
                continue
            if self._enlarge_volume():
                self._move_counter_surface(before)
                self._slide(self._slid)
                continue
            todo.pop()
            cuts = max(0, cuts - 1)
            for body, places, added in zip(self.bodies, self._places, self._added, strict=True):
                body.accept(places, added)
            self._stride = IncrementInfo(point.load - before.load, *self._pixel_path(before, point))
            before, self._slid = point, slid
            done.append(self._make_increment(*result))
        return CONVERGED

    def _reason(self, load: float, cuts: int) -> str:
        what = "plastic strain" if self.solver.is_converged else "contact"
        return Sentence(
            f"stopped before {load:.6g} N: the {what} did not converge in "
            f"{int(self.problem.max_iterations)} iterations, although the step was halved {cuts} "
            f"times; increase {ArgumentRef('max_iterations')}, or set a larger "
            f"{ArgumentRef('tolerance')}"
        )

    def _make_increment(self, residuals: tuple[float, ...], convolutions: int) -> Increment:
        """Return the increment of the current point, whose strain is accepted."""
        pressure, (dy, dx) = self.solver.pressure, self.problem.pair.pixel
        return Increment(
            **asdict(self._point),
            approach=self.solver.approach,
            contact_area=int(np.count_nonzero(pressure)) * dy * dx,
            max_pressure=float(pressure.max()),
            max_plastic_strain=max(body.max_plastic_strain for body in self.bodies),
            plastic_volume=sum(body.plastic_volume for body in self.bodies),
            residuals=residuals,
            convolutions=convolutions,
        )

    def _enlarge_volume(self) -> bool:
        """Enlarge the volume if plastic strain has reached its bottom or its edge."""
        surface, old = self.problem.pair, self.extent
        new = old.enlarge(
            surface.shape,
            surface.pixel,
            deeper=self._deepen and any(parts[-1].any() for parts in self._added),
            wider=self._widen and self._has_reached_edge(),
        )
        sizes = [(item.grid(surface.shape), item.thickness.size) for item in (old, new)]
        # Without sufficient memory a caution of the result reports the plastic strain there.
        if sizes[0] == sizes[1] or not is_within_memory(self.problem, *sizes):
            return False
        self._resize(new)
        return True

    def _has_reached_edge(self) -> bool:
        ny, nx = self.bodies[0].shape
        edge = np.ones((ny, nx), bool)
        edge[GUARD:-GUARD, GUARD:-GUARD] = False
        flat = edge.ravel()
        return any(
            strain[:, flat[place]].any()
            for places, added in zip(self._places, self._added, strict=True)
            for place, strain in zip(places, added, strict=True)
        )

    def _relax(
        self, before: PathPoint, watch: Callable[[float, int, float], None]
    ) -> tuple[tuple[float, ...], int] | None:
        """Compute the plastic strain added by one increment; None without convergence."""
        solver, tolerance, load = self.solver, self.problem.tolerance, self._point.load
        self._guess(IncrementInfo(load - before.load, *self._pixel_path(before, self._point)))
        mixer = Mixer(self._weights(), self._workspace)
        convolutions = solver.convolutions
        residuals: list[float] = []
        for iteration in range(1, int(self.problem.max_iterations) + 1):
            displacement = sum(
                body.displacement(places, added)
                for body, places, added in zip(self.bodies, self._places, self._added, strict=True)
            )
            solver.solve(np.asarray(displacement), load)
            x, y = self._return_to_yield_surface(mixer)
            defect = [item - other for item, other in zip(x, y, strict=True)]
            residuals.append(self._residual(x, defect))
            watch(load, iteration, residuals[-1])
            settled = residuals[-1] <= tolerance and solver.is_converged
            self._store_strain(x if settled else mixer.mix(x, defect))
            if settled:
                return tuple(residuals), solver.convolutions - convolutions
        return None

    def _guess(self, stride: IncrementInfo) -> None:
        """Set the initial guess: the strain of the previous increment, scaled or shifted."""
        last, self._stride = self._stride, IncrementInfo()
        if stride[1:] != last[1:]:
            self._places, self._added = self._empty_increment()
        elif any(stride[1:]):
            # Equal shift: the strain increment moves with the contact.
            for number, body in enumerate(self.bodies):
                if number in self._sliding and self._point.friction:
                    continue
                for layer in range(len(body.strain)):
                    self._carry(number, layer, stride)
        elif last.load * stride.load > 0:
            factor = min(stride.load / last.load, 1.0)
            self._added = [[part * part.dtype.type(factor) for part in a] for a in self._added]
        elif last.load:
            self._places, self._added = self._empty_increment()

    def _carry(self, number: int, layer: int, stride: IncrementInfo) -> None:
        """Move the strain of the previous increment with the counter-surface."""
        place = self._places[number][layer]
        if not place.size:
            return
        shape, inside = self.bodies[number].shape, np.ones(place.size, bool)
        moved = [i + way for i, way in zip(np.unravel_index(place, shape), stride[1:], strict=True)]
        for axis in self.problem.pair.boundary.free_axes:
            inside &= (moved[axis] >= 0) & (moved[axis] < shape[axis])
        flat = np.ravel_multi_index([index[inside] for index in moved], shape, mode="wrap")
        order = np.argsort(flat)
        self._places[number][layer] = flat[order]
        self._added[number][layer] = self._added[number][layer][:, inside][:, order]

    def _weights(self) -> list[float]:
        """Return the weight of a squared strain in each layer, body by body."""
        first = self.bodies[0]
        return [
            body.shear_modulus / first.shear_modulus * float(h / first.thickness[0])
            for body in self.bodies
            for h in body.thickness
        ]

    def _return_to_yield_surface(self, mixer: Mixer) -> tuple[Parts, Parts]:
        """Return the strain after and before the return to the yield surface."""
        x: Parts = []
        y: Parts = []
        for number, body in enumerate(self.bodies):
            old_places, old = self._places[number], self._added[number]
            places, flowed = body.flow(self.solver.pressure, self.pull, old_places, old)
            for layer, place in enumerate(places):
                if place.size > old_places[layer].size:
                    mixer.grow(len(x) + layer, old_places[layer], place)
                    index = np.searchsorted(place, old_places[layer])
                    old[layer] = embed_columns(old[layer], index, place.size)
            self._places[number] = places
            x += flowed
            y += old
        return x, y

    def _store_strain(self, x: Parts) -> None:
        """Store the strain of all layers, body by body."""
        cut = 0
        for number, body in enumerate(self.bodies):
            self._added[number] = x[cut : cut + len(body.strain)]
            cut += len(body.strain)

    def _residual(self, x: Parts, defect: Parts) -> float:
        """Return the largest change over the larger of largest strain and yield strain."""
        changes, sizes = np.zeros(len(x)), np.zeros(len(x))

        def measure(part: int) -> None:
            if x[part].size:
                changes[part] = plastic_flow.equivalent_strain(defect[part]).max()
                sizes[part] = plastic_flow.equivalent_strain(x[part]).max()

        self._workspace.each(measure, range(len(x)))
        minimum = max(plastic_flow.yield_strain(body.material) for body in self.bodies)
        return float(changes.max()) / max(minimum, float(sizes.max()))


AUTO = "auto"
"""Keyword: choose the number of increments by an error estimate."""

STEP_ERROR = 0.01
"""Target of the error by the load steps of a whole path."""

# Steps of the first attempt from zero load, and the largest factor of their refinement.
_STEPS, _MOST = 6, 8
# Smallest factor of refinement: below it the difference of two solutions may be rounding.
_REFINEMENT = 1.5
# Gap over the approach above which a pixel is treated as open.
_OPEN_GAP_RATIO = 0.05


class _StateSample(NamedTuple):
    """Quantities by which states are compared."""

    approach: float
    near: float


def points_between(before: PathPoint, point: PathPoint, count: int) -> list[PathPoint]:
    """Return points in equal steps to a point, which is included without rounding."""
    return [*(before.interpolate(point, i, count) for i in range(1, count)), point]


def visit_load(
    loop: IncrementLoop,
    point: PathPoint,
    done: list[Increment],
    watch: Callable[[float, int, float], None],
) -> str:
    """Solve a load in the steps that the error estimate requires; return the status."""
    before, load = done[-1].load if done else 0.0, point.load
    allowed = STEP_ERROR * abs(load - before) / max(load, before, np.finfo(float).tiny)
    start, parts = loop.snapshot(), _first_subdivision(load, done)
    status, result, flowed = _visit_in_parts(loop, point, parts, done, watch)
    coarse = _sample_state(loop) if status == CONVERGED else None
    if coarse and not flowed:
        # Without plastic flow the steps have no effect.
        _append_increments(done, result, 0.0)
        return status
    maximum, more, error = _MOST * parts, 2 * parts, math.inf
    while True:
        loop.restore(start)
        status, result, _ = _visit_in_parts(loop, point, more, done, watch)
        if status != CONVERGED:
            _append_increments(done, result, None)
            return status
        fine = _sample_state(loop)
        if coarse:
            error = _relative_difference(coarse, fine) * parts / (more - parts)
        if error <= allowed or more == maximum:
            break
        wanted = max(_REFINEMENT * more, more * min(error / allowed, _MOST))
        coarse, parts, more = fine, more, min(math.ceil(wanted), maximum)
    _append_increments(done, result, error if coarse else None)
    return status


def _first_subdivision(load: float, done: list[Increment]) -> int:
    """Return the first number of steps to a load; 1 up to the largest load so far."""
    before = done[-1].load if done else 0.0
    if load <= max((step.load for step in done), default=0.0):
        return 1
    return max(1, math.ceil(_STEPS * (load - before) / load - 1e-9))


def _visit_in_parts(
    loop: IncrementLoop,
    point: PathPoint,
    parts: int,
    done: list[Increment],
    watch: Callable[[float, int, float], None],
) -> tuple[str, list[Increment], bool]:
    """Solve a load in equal steps; return status, increments and any plastic flow."""
    result, status, flowed = list(done), CONVERGED, False
    before = done[-1].point if done else PathPoint(0.0, point.offset)
    for step in points_between(before, point, parts):
        status = loop.reach(step, result, watch)
        flowed = flowed or loop.flowing
        if status != CONVERGED:
            break
    return status, result, flowed


def _sample_state(loop: IncrementLoop) -> _StateSample:
    solver = loop.solver
    near = 0.0
    if solver.solution is not None:
        reach = max(_OPEN_GAP_RATIO * abs(solver.approach), np.finfo(float).tiny)
        near = float(np.clip(1 - solver.solution.gap / reach, 0, 1).sum())
    return _StateSample(solver.approach, near)


def _relative_difference(coarse: _StateSample, fine: _StateSample) -> float:
    """Return the relative difference between two states of one load."""
    approach = abs(coarse.approach - fine.approach) / max(abs(fine.approach), 1e-300)
    return max(approach, abs(coarse.near - fine.near) / fine.near if fine.near else 0.0)


def _append_increments(done: list[Increment], result: list[Increment], error: float | None) -> None:
    """Add new increments to the completed ones, with the accumulated step error."""
    known = done[-1].step_error if done else 0.0
    total = None
    if known is not None and error is not None and math.isfinite(error):
        # Errors are relative to the approach, which grows along the path.
        old = max((step.approach for step in done), default=0.0)
        new = max(step.approach for step in result)
        total = known * (old / new if new > 0 else 1.0) + error
    done += [replace(step, step_error=total) for step in result[len(done) :]]
