"""Checks before a contact is solved; each error states the fault and a remedy."""

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
from roughcontact.contact.memory import MemoryNeed, coarse_contact_guess, start_fraction
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
from roughcontact.solvers import rigid_tilt
from roughcontact.solvers.problem import BoundedProblem
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
            require_below(terms.approach, float(gap.sum()) / math.prod(pair.shape))
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
