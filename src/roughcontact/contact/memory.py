"""Memory of a contact: a fixed part, a part per pixel, and a part per pixel in contact."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from roughcontact._tools import memory
from roughcontact.contact.load_case import LoadCase, ProblemUnits
from roughcontact.contact.pair import Pair
from roughcontact.contact.result import ContactResult
from roughcontact.errors import ArgumentRef, Part
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.convolution import MAX_CACHE_BYTES
from roughcontact.halfspace.fft import Workspace, default_workers
from roughcontact.solvers import bounded
from roughcontact.solvers.operator import Operator
from roughcontact.solvers.problem import BoundedProblem, coarsen_problem

# Numbers of 8 bytes per pixel in contact. The conjugate gradients need thirteen: index, pressure
# and gap of the iterate; unknown, residual and direction; index on the patch and in its padded
# rows, block and weight of the preconditioner, its input, its output, and the part of the spots.
# Projected gradients need up to twenty-one: four iterates, the step, and eight for a check of the
# whole map.
_BYTES_PER_CONTACT_PIXEL = 23


# Bytes of the preconditioner per pixel of the map: weight, symbol with its rows of zeros, and
# eleven numbers per block of 8 × 8.
_PRECONDITIONER = 5


# The C library leaves gaps between arrays below this size: one of the map, three of the contact.
_ALLOCATOR_BYTES = 2**25


# Additional maps of bodies that tilt (the moments are checked first, and each tilt has its gap in
# addition to the last one), and of a map of ceilings.
_TILTED, _CEILINGS = 5, 2


# Buffers of libraries and the collective modes of the spots; blocks of each thread.
_FIXED_BYTES = 2**24


_BYTES_PER_THREAD = 2**21


# Maximum number of pixels of the coarse grid that estimates a contact.
_PREVIEW_PIXELS = 512**2


def fixed_bytes() -> int:
    """Return the bytes that a solve needs for a map of any size."""
    return _FIXED_BYTES + _BYTES_PER_THREAD * default_workers()


@dataclass(frozen=True)
class MemoryNeed:
    """Memory need of a solve, beyond the surface itself."""

    shape: tuple[int, int]
    boundary: Boundary = Boundary.FREE
    precision: str = "double"
    maps: int = 0  # Further maps of 8 bytes per pixel that are kept meanwhile

    @classmethod
    def from_pair(cls, pair: Pair, terms: LoadCase, held: int = 0) -> MemoryNeed:
        """Return the memory need of a solve of a pair, with further maps in memory."""
        maps = held + (_TILTED if terms.moments is not None else 0)
        if isinstance(terms.ceiling, np.ndarray):
            maps += _CEILINGS
        return cls(pair.shape, pair.boundary, terms.precision, maps)

    def estimate(self, contact_fraction: float = 1.0) -> int:
        """Return the bytes for a given fraction of the map in contact."""
        real = 8 if self.precision == "double" else 4
        pixels = self.shape[0] * self.shape[1]
        touching = math.ceil(8 * contact_fraction * pixels)
        # Initial gap and open gap.
        arrays = (2 * real + _PRECONDITIONER + 8 * self.maps) * pixels
        gaps = min(8 * pixels, _ALLOCATOR_BYTES) + 3 * min(touching, _ALLOCATOR_BYTES)
        kernel = self.boundary.kernel_memory(self.shape)
        # The solver also checks in single precision; the kernels of coarser grids, each a quarter
        # of the next, are kept for the next solve.
        kernels = kernel // 2 if self.precision == "double" else 0
        if self.boundary.free_axes:
            kernels += min(kernel // 3, MAX_CACHE_BYTES)
        operator = self.boundary.operator_memory(self.shape, self.precision) + kernels
        return operator + arrays + _BYTES_PER_CONTACT_PIXEL * touching + gaps + fixed_bytes()

    def require(self, contact_fraction: float = 0.0, there: int | None = None) -> None:
        """Raise an error with a suggestion if the solve does not fit."""
        needed = self.estimate(contact_fraction)
        if there is None:
            there = memory.free_bytes()
        if needed <= there:
            return
        what, full = f"a map of {self.shape[0]} × {self.shape[1]} points", 0
        side = self._largest_side(contact_fraction, there)
        advice: tuple[Part, ...] = (f"a square grid of up to about {side} × {side} points fits",)
        if contact_fraction:
            what += f" in contact on {100 * contact_fraction:.3g} % of it"
        else:
            full = self.estimate(1.0)
            side = self._largest_side(1.0, there)
            advice += (f", in full contact one of {side} × {side}",)
        single = replace(self, precision="single")
        if self.precision == "double" and single.estimate(contact_fraction) <= there:
            advice += ("; ", ArgumentRef("precision", "single"), " fits the whole map")
        memory.require_memory(
            needed, f"{what} needs", worst_case=("in full contact", full), advice=advice
        )

    def _largest_side(self, contact_fraction: float, there: int) -> int:
        """Return the points along the side of the largest square grid that fits."""
        minimum, maximum = 0, 1 + math.isqrt(math.prod(self.shape))
        while maximum - minimum > 1:
            side = (minimum + maximum) // 2
            fits = replace(self, shape=(side, side)).estimate(contact_fraction) <= there
            minimum, maximum = (side, maximum) if fits else (minimum, side)
        return minimum


def start_fraction(
    problem: BoundedProblem, start: ContactResult | ArrayLike | None, series: bool
) -> float:
    """Return the fraction of a map that is in contact in the initial guess."""
    limited = problem.total is not None and not np.isinf(problem.limit).all()
    if start is None:
        return 1.0 if series and limited else 0.0
    pressure = start.pressure if isinstance(start, ContactResult) else np.asarray(start)
    limit = np.broadcast_to(problem.limit, pressure.shape)[pressure > 0]
    if limited and float(limit.sum()) < (problem.total or 0.0):
        return 1.0
    return limit.size / pressure.size


def coarse_contact_guess(pair: Pair, problem: BoundedProblem, units: ProblemUnits) -> float:
    """Return the approximate contact fraction, from a coarse grid."""
    coarseness = 1
    while math.prod(problem.shape) > _PREVIEW_PIXELS and min(problem.shape) > 1:
        problem, coarseness = coarsen_problem(problem), 2 * coarseness
    make = pair.operators("single", Workspace(), units.pressure / units.length)

    def operator(shape: tuple[int, int], pixel: tuple[int, int]) -> Operator:
        return make(shape, (coarseness * pixel[0], coarseness * pixel[1]))

    result = bounded.solve(problem, operator, tolerance=1e-2, max_iterations=100)
    return result.index.size / math.prod(problem.shape)
