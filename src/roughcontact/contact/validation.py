"""Checks before a contact is solved, and its memory.

The memory has a fixed part, a part per pixel, and a part per pixel in contact.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from roughcontact._tools import memory
from roughcontact._tools.arrays import Array
from roughcontact._tools.memory import ITERATIONS
from roughcontact.contact import load_case
from roughcontact.contact.ceiling import resolve_ceiling
from roughcontact.contact.load_case import LoadCase, ProblemUnits
from roughcontact.contact.nominal_hertz import solve_smooth
from roughcontact.contact.pair import Pair
from roughcontact.contact.result import CALIBRATED, ContactResult
from roughcontact.errors import (
    ArgumentRef,
    CapacityError,
    InputError,
    Part,
    input_error,
    require_choice,
    require_count,
    require_positive,
)
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.convolution import MAX_CACHE_BYTES
from roughcontact.halfspace.fft import Workspace, default_workers
from roughcontact.solvers import bounded, rigid_tilt
from roughcontact.solvers.operator import Operator
from roughcontact.solvers.problem import BoundedProblem, coarsen_problem
from roughcontact.units import format_engineering

# Smallest ceiling in units of the pressures, as a positive ceiling must not become zero.
_MIN_VALUE = 1e-300


@dataclass
class ContactProblem:
    """Problem that passed all checks; the solver may reuse its arrays."""

    problem: BoundedProblem  # Problem of the solver, in the units of `scale`
    scale: ProblemUnits  # Units of the problem
    ceiling: float | Array | None  # (ny, nx) Largest pressure [Pa]
    holes: bool  # Whether some points have no contact
    target: Array | None  # Point of action of the load, as a fraction of the longer side


def build_problem(
    pair: Pair,
    terms: LoadCase,
    start: ContactResult | ArrayLike | None = None,
    *,
    held: int = 0,
    series: bool = False,
) -> ContactProblem:
    """Return the problem of a solve; raise an error if it is invalid."""
    check_terms(terms)
    # The memory of any contact on this grid is checked before large arrays are created.
    room, there = MemoryNeed.from_pair(pair, terms, held), memory.free_bytes()
    room.require(there=there)
    if terms.moments is not None:
        terms = replace(terms, moments=check_moments(terms, pair.boundary))
    check_holes(pair)
    ceiling = resolve_ceiling(terms.ceiling, pair)
    if start is not None:
        check_start(start, pair.shape)
    gap = touchable_gap(pair)
    total, target = None, None
    if terms.load is not None:
        require_positive(load=terms.load)
        total = min(terms.load, load_capacity(terms.load, ceiling, gap, pair)) / pair.pixel_area
        if terms.moments is not None:
            target = np.array(terms.moments) / (terms.load * max(pair.size))
            check_balance(target, terms.load, ceiling, gap, pair)
    holes = pair.has_holes
    if terms.approach is not None:
        require_positive(approach=terms.approach)
        if not (pair.boundary.free_axes or holes) and ceiling is None:
            full = float(gap.sum()) / math.prod(pair.shape)
            require_below(terms.approach, full)
    units = load_case.units_of_problem(pair, terms, gap)
    gap /= units.length
    if terms.precision == "single":
        gap = gap.astype(np.float32)
    problem = BoundedProblem(
        gap,
        limit=np.inf if ceiling is None else np.maximum(ceiling / units.pressure, _MIN_VALUE),
        total=None if total is None else total / units.pressure,
        approach=None if terms.approach is None else terms.approach / units.length,
    )
    # If the memory holds a light contact but not a full one, the expected contact decides.
    if room.estimate(1.0) > there:
        touching = start_fraction(problem, start, series)
        room.require(max(touching, coarse_contact_guess(pair, problem, units)), there)
    return ContactProblem(problem, units, ceiling, holes, target)


def check_problem(pair: Pair, terms: LoadCase, *, held: int = 0, series: bool = False) -> None:
    """Raise the errors that a solve would raise before it starts."""
    build_problem(pair, terms, held=held, series=series)


def check_terms(terms: LoadCase) -> None:
    """Raise `InputError` for terms that are invalid for all bodies."""
    require_choice(("double", "single"), precision=terms.precision)
    require_positive(tolerance=terms.certificate)
    require_count(1, ITERATIONS, max_iterations=terms.max_iterations)
    if (terms.load is None) == (terms.approach is None):
        raise InputError(
            f"give either {ArgumentRef('load')} or {ArgumentRef('approach')}, and only one of them"
        )


def check_profile(pair: Pair, terms: LoadCase) -> None:
    """Raise `InputError` for arguments that require a map."""
    if terms.moments is not None:
        pair.require_map("a tilt")
    if isinstance(terms.ceiling, str) and terms.ceiling == CALIBRATED:
        pair.require_map("a calibrated ceiling")


def check_holes(pair: Pair) -> None:
    """Raise `InputError` for missing points that are neither filled nor accepted."""
    for name, body in (("surface", pair.surface), ("counter_surface", pair.counter_surface)):
        if body is not None and body.missing and not body.holes_masked:
            raise InputError(
                f"has {body.missing} missing points: fill them (.filled()), crop them away "
                "(.cropped(...)) or exclude them from contact (.masked())",
                argument=name,
            )


def touchable_gap(pair: Pair) -> Array:
    """Return the gap at first touch [m], shape (ny, nx); infinite at holes."""
    gap = pair.initial_gap
    if pair.has_holes:
        gap[np.isnan(gap)] = np.inf
        if np.isinf(gap).all():
            raise CapacityError(
                "no contact is possible: the holes of both bodies together leave no valid point"
            )
    return gap


def as_finite_row(values: ArrayLike, argument: str) -> Array:
    """Return numbers in a row as an array; raise `InputError` unless they are finite."""
    try:
        result = np.atleast_1d(np.array(values, dtype=np.float64))
    except (TypeError, ValueError, OverflowError):
        result = np.empty(0)
    if result.ndim != 1 or not result.size or not np.isfinite(result).all():
        raise input_error(argument, values, "must be a row of finite numbers [m]")
    return result


def require_below(approach: float, full: float) -> None:
    """Raise `CapacityError` if a periodic map is approached beyond full contact [m]."""
    if approach >= full:
        raise CapacityError(
            f"= {approach:.6g} m is beyond full contact of this periodic surface at {full:.6g} m, "
            f"where the load is undefined; give a {ArgumentRef('load')} instead",
            argument="approach",
        )


def check_moments(terms: LoadCase, boundary: Boundary) -> tuple[float, float]:
    """Return the moments as two numbers, or raise `InputError` if they cannot be balanced."""
    moments: Any = terms.moments
    try:
        about_y, about_x = (float(moment) for moment in moments)
    except (TypeError, ValueError):
        about_y = about_x = math.nan
    if not (math.isfinite(about_y) and math.isfinite(about_x)):
        raise input_error("moments", moments, "must be a pair (y, x) of numbers [N m]")
    if terms.load is None:
        raise InputError(
            f"need a load to balance; give {ArgumentRef('load')} instead of "
            f"{ArgumentRef('approach')}",
            argument="moments",
        )
    if boundary.periodic_axes:
        raise InputError(
            f"need {ArgumentRef('boundary', 'free')}: a tilt has no period", argument="moments"
        )
    if terms.precision == "single":
        raise InputError(
            f"need {ArgumentRef('precision', 'double')} to be balanced to 1e-8", argument="moments"
        )
    return about_y, about_x


def check_balance(
    target: Array, load: float, ceiling: float | Array | None, gap: Array, pair: Pair
) -> None:
    """Raise `CapacityError` if no admissible pressure is centered at the point of the load."""
    touchable = np.isfinite(gap)
    y, x = (
        np.broadcast_to(v, gap.shape)[touchable]
        for v in rigid_tilt.moment_arms(gap.shape, pair.pixel)
    )
    share: float | Array = math.inf
    if ceiling is not None:
        part = np.asarray(ceiling) * (pair.pixel_area / load)
        share = part[touchable] if part.ndim else float(part)
    side = max(pair.size)
    outside = rigid_tilt.excess(target, y, x, share) * side
    if outside > 0:
        at_y, at_x = target * side
        what = "points that can touch" if ceiling is None else "pressures up to the ceiling"
        raise CapacityError(
            f"= ({target[0] * load * side:.6g}, {target[1] * load * side:.6g}) N m put the "
            f"load of {load:.6g} N at ({at_y:.6g}, {at_x:.6g}) m from the center of the map, "
            f"{outside:.3g} m beyond what {what} can balance; move it inwards",
            argument="moments",
        )


def check_start(start: ContactResult | ArrayLike, shape: tuple[int, int]) -> None:
    """Raise `InputError` if an initial guess is invalid."""
    pressure = np.asarray(start.pressure if isinstance(start, ContactResult) else start)
    if pressure.dtype.kind not in "fiu":
        raise InputError(
            f"must be a ContactResult or a map of pressures [Pa], got {type(start).__name__}",
            argument="initial_guess",
        )
    if pressure.shape != shape:
        raise InputError(
            f"has {pressure.shape} pixels and the surface {shape}; "
            "start from a solution on the same grid",
            argument="initial_guess",
        )
    if not (np.isfinite(pressure).all() and (pressure >= 0).all()):
        raise InputError(
            "must hold finite pressures that are not negative", argument="initial_guess"
        )


def load_capacity(load: float, ceiling: float | Array | None, gap: Array, pair: Pair) -> float:
    """Return the largest load that can be carried, or raise if the given load is larger."""
    if ceiling is None:
        return math.inf
    touchable = np.isfinite(gap)
    if isinstance(ceiling, np.ndarray):
        largest = float(ceiling[touchable].sum()) * pair.pixel_area
    else:
        largest = ceiling * int(np.count_nonzero(touchable)) * pair.pixel_area
    require_capacity(load, largest, pair)
    return largest


def _require_hertz_within_map(load: float, pair: Pair) -> None:
    """Raise `CapacityError` if the smooth bodies would touch beyond the edges of the map."""
    smooth = solve_smooth(pair, load)
    if smooth is None:
        return
    for axis in pair.boundary.free_axes:
        reach, half = smooth.reach[axis], pair.size[axis] / 2
        if axis != smooth.shape.axis and reach > half:
            raise CapacityError(
                f"= {load:.6g} {pair.load_unit} makes the Hertz contact "
                f"(±{format_engineering(reach, 'm', 3)}) larger than the map "
                f"(±{format_engineering(half, 'm', 3)}); measure a larger map or reduce the load",
                argument="load",
            )


def require_capacity(load: float, largest: float, pair: Pair) -> None:
    """Raise `CapacityError` for a load above the largest that can be carried."""
    # The full capacity is valid; rounding must not reject it.
    if load > largest * (1 + 1e-12):
        _require_hertz_within_map(load, pair)
        body = pair.softer
        advice: tuple[Part, ...] = ()
        if body is not None and body.yield_strength and not pair.boundary.free_axes:
            advice = (
                "; it carries more where spots confine each other: use ",
                ArgumentRef("ceiling", CALIBRATED),
            )
        raise CapacityError(
            f"= {load:.6g} {pair.load_unit} is more than the surface can carry: the ceiling times "
            f"the {'length' if pair.is_profile else 'area'} of its valid pixels is {largest:.6g} "
            f"{pair.load_unit}",
            *advice,
            argument="load",
        )


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
    loaded = pressure > 0
    limit = np.broadcast_to(problem.limit, pressure.shape)[loaded]
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
