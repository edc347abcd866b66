"""Problem of a load path: the inputs that all its loads share."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._tools import memory
from roughcontact._tools.arrays import Array, Pixel, Shape
from roughcontact.contact.pair import Pair
from roughcontact.contact.validation import touchable_gap
from roughcontact.elastoplastic.volume_result import (
    GUARD,
    ElastoplasticResult,
    move_counter_surface,
)
from roughcontact.errors import InputError
from roughcontact.halfspace import plastic_halfspace
from roughcontact.halfspace.fft import Workspace, default_workers
from roughcontact.halfspace.layers import SWEEP_POINTS, graded_layers
from roughcontact.material.material import CEILING_FACTOR, Material
from roughcontact.solvers import bounded
from roughcontact.solvers.operator import Family
from roughcontact.solvers.problem import BoundedProblem, Loaded
from roughcontact.solvers.progress import Status


@dataclass(frozen=True, eq=False)
class ElastoplasticProblem:
    """Inputs that all loads of a path share; see `solve_elastoplastic`."""

    pair: Pair
    tolerance: float
    max_iterations: int
    precision: str

    @property
    def contact_tolerance(self) -> float:
        """Tolerance of the contact: a hundredth of the tolerance, from 1e-10 to 1e-6."""
        return max(1e-10, min(1e-6, self.tolerance / 100))

    @property
    def yielding(self) -> list[Material]:
        """Materials with a yield strength, the rough body first."""
        both = self.pair.material, self.pair.counter_material
        return [body for body in both if body.yield_strength is not None]

    def pair_at(self, offset: tuple[float, float]) -> Pair:
        """Return the pair with the counter-surface moved along ``(y, x)`` [m]."""
        return move_counter_surface(self.pair, offset)

    def gap_at(self, offset: tuple[float, float]) -> Array:
        """Return the gap at first touch [m] for an offset, infinite at missing points."""
        return touchable_gap(self.pair_at(offset))

    def check_same(self, what: str, before: ElastoplasticResult) -> None:
        """Raise `InputError` if a result has other bodies or another boundary."""
        last = before.increments[-1].offset if before.increments else (0.0, 0.0)
        old, new = before.solution.pair, self.pair_at(last)
        same = {
            "surface": old.shape == new.shape
            and np.array_equal(old.initial_gap, new.initial_gap, equal_nan=True),
            "pixel": old.pixel == new.pixel,
            "material": old.material == new.material,
            "counter_material": old.counter_material == new.counter_material,
            "boundary": old.boundary == new.boundary,
        }
        for name, agrees in same.items():
            if not agrees:
                raise InputError(
                    f"{what} was solved with another {name}, to which its plastic strain belongs"
                )


# Contact on surfaces displaced by plastic strain, solved in each iteration.


_CONTACT_CONVOLUTIONS = 500


class ContactSolver:
    """Contact solver that starts each time from the previous pressure."""

    def __init__(self, gap: Array, make: Family, area: float, tolerance: float) -> None:
        self._map = gap
        self._make, self.area, self.tolerance = make, area, tolerance
        self.resize(0)
        self.approach = 0.0
        self.convolutions = 0
        self.solution: bounded.BoundedSolution | None = None

    def resize(self, margin: int) -> None:
        """Add points that never touch around the map, and reset the pressure."""
        self.initial_gap = np.pad(self._map, margin, constant_values=np.inf)
        self.inside = tuple(slice(margin, margin + n) for n in self._map.shape)
        self.loaded: Loaded | None = None
        self.pressure = np.zeros(self.initial_gap.shape)

    def set_gap(self, gap: Array, moved: tuple[int, int]) -> None:
        """Set the gap of a counter-surface that has moved by some pixels."""
        self._map = gap
        self.initial_gap = np.pad(gap, self.inside[0].start, constant_values=np.inf)
        if self.loaded is None or not any(moved):
            return
        pressure = np.zeros(self.initial_gap.shape)
        pressure.ravel()[self.loaded[0]] = self.loaded[1]
        # An initial guess need not be exact: the solver removes pressure that wraps around.
        pressure = np.roll(pressure, moved, (0, 1))
        pressure[np.isinf(self.initial_gap)] = 0
        index = np.flatnonzero(pressure)
        self.loaded = (index, pressure.ravel()[index]) if index.size else None

    def resume(self, pressure: Array) -> None:
        """Set the initial pressure on the map."""
        self.pressure[self.inside] = pressure
        index = np.flatnonzero(self.pressure)
        if index.size:
            self.loaded = index, self.pressure.ravel()[index]

    def first_contact(self, load: float, strength: float) -> NDArray[np.bool_]:
        """Return the approximate contact under a ceiling of three yield strengths."""
        total = load / self.area
        limit = CEILING_FACTOR * strength
        if total > 0.9 * limit * np.count_nonzero(np.isfinite(self.initial_gap)):
            return np.isfinite(self.initial_gap)
        problem = BoundedProblem(self.initial_gap, limit, total)
        rough = bounded.solve(problem, self._make, tolerance=1e-2, max_iterations=200)
        pressed = np.zeros(self.initial_gap.shape, bool)
        pressed.ravel()[rough.index] = True
        return pressed

    @property
    def is_converged(self) -> bool:
        """Whether the last contact is within its tolerance; True without a load."""
        return self.solution is None or self.solution.status is Status.CONVERGED

    def solve(self, displacement: Array, load: float) -> None:
        """Solve the contact under a load on the surface displaced by plastic strain."""
        gap = self.initial_gap + displacement
        self.pressure = np.zeros(gap.shape)
        if load == 0:
            self.loaded, self.solution = None, None
            self.approach = float(gap.min())
            return
        solution = bounded.solve(
            BoundedProblem(gap, np.inf, load / self.area),
            self._make,
            tolerance=self.tolerance,
            max_iterations=_CONTACT_CONVOLUTIONS,
            start=self.loaded,
        )
        self.convolutions += solution.convolutions
        self.loaded = solution.index, solution.pressure
        self.pressure.ravel()[solution.index] = solution.pressure
        self.approach, self.solution = solution.approach, solution


def solve_without_load(problem: ElastoplasticProblem, workspace: Workspace) -> ContactSolver:
    """Return the contact solver without pressure, or raise `InputError` if no body yields."""
    if not problem.yielding:
        raise InputError(
            "neither material has a yield strength: nothing can yield; give one, or use solve"
        )
    gap = touchable_gap(problem.pair)
    # The contact is solved repeatedly on the same few grids.
    make = lru_cache(maxsize=12)(problem.pair.operators("double", workspace))
    return ContactSolver(gap, make, problem.pair.pixel_area, problem.contact_tolerance)


LAYER_RATIO = 1.08
"""Ratio of the thickness of a layer to the layer above."""

MIN_LAYERS = 10
"""Smallest number of layers of a volume unless layers are given."""

# Thickness of the first layer over the shorter edge of a pixel; depth of all layers over the radius
# of the largest contact spot; smallest depth in pixels.
_FIRST_LAYER = 0.5
_DEPTH = 3.0
_MIN_DEPTH = 8.0
# Factor of the depth when plastic strain has reached the lowest layer; growth of the volume at each
# side over its shorter side when plastic strain has reached the edge.
_DEEPER = 1.3
_WIDER = 0.1
# Distance of the edge of the volume from the contact, over the radius of the largest spot.
_MAX_SPAN = 0.8


class Extent(NamedTuple):
    """Layers of the volume, and its margin beyond the map."""

    thickness: Array  # (nz,) Thickness of each layer [m]
    margin: int  # Rows and columns beyond each edge of the map

    @classmethod
    def from_result(cls, result: ElastoplasticResult) -> Extent:
        """Return the extent of a result."""
        body = result.bodies[0]
        return cls(body.thickness, body.margin)

    def grid(self, shape: Shape) -> tuple[int, int]:
        """Return the grid of a layer below a map of some shape."""
        return shape[0] + 2 * self.margin, shape[1] + 2 * self.margin

    def enlarge(self, shape: Shape, pixel: Pixel, *, deeper: bool, wider: bool) -> Extent:
        """Return a deeper or wider extent, up to a maximum depth and margin."""
        thickness, margin = list(self.thickness), self.margin
        (ny, nx), (dy, dx) = self.grid(shape), pixel
        if deeper:
            depth = min(_DEEPER * sum(thickness), 2 * max(ny * dy, nx * dx))
            while sum(thickness) < depth:
                thickness.append(thickness[-1] * LAYER_RATIO)
        if wider and 4 * margin < max(ny, nx):
            margin += max(GUARD, math.ceil(_WIDER * min(ny, nx)))
        return Extent(np.array(thickness), margin)


def first_extent(
    problem: ElastoplasticProblem,
    solver: ContactSolver,
    load: float,
    depth: float | None,
    layers: ArrayLike | None,
) -> Extent:
    """Return the initial extent of the volume for loads up to a given load."""
    pixel = problem.pair.pixel
    weaker = problem.pair.softer
    radius, margin = _spot_extent(solver, load, weaker, pixel)
    margin = margin if problem.pair.boundary.free_axes else 0
    if layers is None:
        if depth is None:
            depth = max(_DEPTH * radius, _MIN_DEPTH * max(pixel))
        return Extent(graded_layers(_FIRST_LAYER * min(pixel), depth, LAYER_RATIO), margin)
    thickness = np.array(layers, float)
    if thickness.sum() < radius:
        raise InputError(
            f"reach {thickness.sum():.4g} m deep, less than the radius {radius:.4g} m of "
            "the largest contact spot: plastic strain would be deeper; make them "
            f"{_DEPTH * radius:.4g} m deep, or leave them out",
            argument="layers",
        )
    return Extent(thickness, margin)


def _spot_extent(
    solver: ContactSolver, load: float, body: Material | None, pixel: Pixel
) -> tuple[float, int]:
    """Return the radius of the largest contact spot [m] and the margin of its volume."""
    from scipy import ndimage

    pressed = solver.first_contact(load, (body.yield_strength or math.inf) if body else math.inf)
    spots, number = ndimage.label(pressed, np.ones((3, 3)))
    largest = int(np.bincount(spots.ravel())[1:].max()) if number else 0
    radius = math.sqrt(largest * pixel[0] * pixel[1] / math.pi)
    margin = 0
    for axis, edge in enumerate(pixel):
        lines = np.flatnonzero(pressed.any(axis=1 - axis))
        if lines.size:
            near = min(int(lines[0]), pressed.shape[axis] - 1 - int(lines[-1]))
            margin = max(margin, math.ceil(_MAX_SPAN * radius / edge) - near)
    return radius, margin


def memory_estimate(
    shape: Shape, layers: int, *, bodies: int = 1, boundary: str = "free", precision: str = "single"
) -> int:
    """Return an estimate of the memory that `solve_elastoplastic` needs [bytes]."""
    real = 8 if precision == "double" else 4
    points = shape[0] * shape[1]
    padded = plastic_halfspace.points_transformed(shape, boundary)
    # Spectra of strain and mean stress and the tables; strain, stresses, and the history of the
    # acceleration for a quarter of the points. The bodies share the work arrays of the threads.
    swept = min(default_workers() * SWEEP_POINTS, padded / 4)
    volume = bodies * layers * (7.5 * padded + 35 * points) + (6 * layers + 56) * swept
    return int(real * volume) + 200 * points


def require_memory(shape: Shape, layers: int, **terms: Any) -> None:
    """Raise `InsufficientMemoryError` unless a volume fits into free memory."""
    needed = memory_estimate(shape, layers, **terms)
    points = memory.square_side(needed, shape)
    memory.require_memory(
        needed,
        f"{shape[0]} × {shape[1]} points in {layers} layers need",
        advice=(f"a square grid of up to about {points} × {points} points fits, or fewer layers",),
    )


def is_within_memory(
    problem: ElastoplasticProblem,
    old: tuple[tuple[int, int], int],
    new: tuple[tuple[int, int], int],
) -> bool:
    """Return whether a volume can grow from one grid and number of layers to another."""
    more, less = (memory_estimate(*size, **memory_terms(problem)) for size in (new, old))
    return more - less < memory.free_bytes()


def memory_terms(problem: ElastoplasticProblem) -> dict[str, Any]:
    """Return the arguments of `require_memory` for a problem, except its grid."""
    return {
        "bodies": max(len(problem.yielding), 1),
        "boundary": problem.pair.boundary,
        "precision": problem.precision,
    }
