"""What holds of every result whatever file it comes from: ranges, and what numbers say of others.

Checksums tell whether a file is as it was written; these tell whether it can be a result at all.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.contact.result import ContactResult
from roughcontact.contact.solve import LOAD_TOLERANCE, MOMENT_TOLERANCE, TOO_STEEP, UNBALANCED
from roughcontact.errors import InputError, require_choice, require_positive
from roughcontact.solvers.bounded import Status

Array = NDArray[Any]

# How a solve may end; files hold these words.
_STATUSES = (*(str(status.value) for status in Status), UNBALANCED, TOO_STEEP)
# Sums and differences of the same numbers agree to this, in other orders and versions.
_ROUNDING = 1e-12


def check(result: ContactResult, stated: Mapping[str, Any]) -> None:
    """Raise `InputError` where numbers of a result contradict each other, or cannot be.

    Parameters
    ----------
    result : ContactResult
        As it was read.
    stated : mapping
        What the file says besides and what follows from the rest: ``contact_modulus`` [Pa], the
        maps ``initial_gap`` [m] and ``saturated``, the centres ``y`` and ``x`` of the pixels [m].

    Raises
    ------
    InputError
        The first that is found; it names what it is about.
    """
    _check_numbers(result)
    _check_maps(result)
    _check_load(result)
    _check_converged(result)
    _check_stated(result, stated)


def require_not_negative(**values: float) -> None:
    """Raise `InputError`, naming argument and value, unless all values are finite and not < 0."""
    for name, value in values.items():
        if not 0 <= value < math.inf:
            raise InputError(
                f"must be finite and not negative, got {value!r}", argument=name, value=value
            )


def require_finite(name: str, values: Any, shape: tuple[int, ...]) -> None:
    """Raise `InputError` unless numbers are finite and fill an array of this shape."""
    found = np.asarray(values)
    if found.shape != shape:
        raise InputError(f"has {found.shape} values instead of {shape}", argument=name)
    if not np.isfinite(found).all():
        raise InputError("must be finite everywhere", argument=name)


def _check_numbers(result: ContactResult) -> None:
    require_positive(tolerance=result.tolerance)
    names = ("load", "certificate", "load_error", "seconds", "iterations", "convolutions")
    require_not_negative(**{name: getattr(result, name) for name in names})
    require_finite("approach", result.approach, ())
    require_finite("tilt", result.tilt, (2,))
    if result.moments is not None:
        require_finite("moments", result.moments, (2,))
    require_choice(("double", "single"), precision=result.precision)
    require_choice(("load", "approach"), control=result.control)
    # Other versions may have other words; where checksums agree these are what was written.
    if result.unsealed and result.status not in _STATUSES:
        raise InputError(
            f"is none that a solve ends with, got {result.status!r}", argument="status"
        )
    if isinstance(result.ceiling, float):
        require_positive(ceiling=result.ceiling)


def _check_maps(result: ContactResult) -> None:
    pair = result.pair
    for body in (pair.surface, pair.counter_surface):
        if body is not None and body.missing and not body.holes_masked:
            raise InputError("is missing at points that were never masked", argument="height")
    for name in ("pressure", "gap", "ceiling"):
        values = getattr(result, name)
        if isinstance(values, np.ndarray) and values.shape != pair.shape:
            raise InputError(
                f"has {values.shape} pixels and the surface {pair.shape}", argument=name
            )
    there = ~np.isnan(pair.heights)
    pressure, ceiling = result.pressure, result.ceiling
    if isinstance(ceiling, np.ndarray) and not (ceiling >= 0).all():
        raise InputError("must be a number that is not negative everywhere", argument="ceiling")
    bound: Any = math.inf if ceiling is None else ceiling
    if not ((pressure >= 0) & (pressure <= bound) & (there | (pressure == 0))).all():
        raise InputError(
            "must lie between zero and the ceiling, and vanish where there is no height",
            argument="pressure",
        )
    if not (np.isfinite(pressure).all() and np.array_equal(np.isfinite(result.gap), there)):
        raise InputError("and pressure must be finite where there is a height", argument="gap")


def _check_load(result: ContactResult) -> None:
    """Refuse a load that the pressures do not carry, but for the error that is stated."""
    carried, load = float(result.pressure.sum()) * result.pixel_area, result.load
    error = abs(carried - load) / load if load else float(carried > 0)
    wanted = result.load_error if result.control == "load" else 0.0
    if not abs(error - wanted) <= _ROUNDING * (1 + wanted):
        raise InputError(
            f"= {load:.6g} {result.pair.load_unit} with an error of {wanted:.2g} contradicts the "
            f"pressures, which carry {carried:.6g} {result.pair.load_unit}",
            argument="load",
        )


def _check_converged(result: ContactResult) -> None:
    """Refuse a result that claims to be solved without the numbers of one."""
    if not result.converged:
        return
    for name, limit in (
        # Looked at twice, a contact may differ in the last digits.
        ("certificate", 1.01 * result.tolerance),
        ("load_error", LOAD_TOLERANCE),
        ("moment_error", 2 * MOMENT_TOLERANCE),
    ):
        value = getattr(result, name)
        if not value <= limit:
            raise InputError(
                f"= {value:.2g} is no converged one: it may be {limit:.2g}", argument=name
            )


def _check_stated(result: ContactResult, stated: Mapping[str, Any]) -> None:
    pair = result.pair
    modulus = stated["contact_modulus"]
    if not math.isclose(modulus, pair.contact_modulus, rel_tol=_ROUNDING):
        raise InputError(
            f"= {modulus:.6g} Pa is not that of the materials, {pair.contact_modulus:.6g} Pa",
            argument="contact_modulus",
        )
    for name, points, edge in zip("yx", pair.shape, pair.pixel, strict=True):
        centres = (np.arange(points) + 0.5) * edge
        if not _alike(stated[name], centres, float(centres[-1])):
            raise InputError(f"does not fit the centres of the pixels {name}", argument="pixel")
    gap = pair.initial_gap
    # Heights far from zero lose digits in the difference.
    size = max(float(np.nanmax(np.abs(pair.heights), initial=0)), float(np.nanmax(gap, initial=0)))
    if not _alike(stated["initial_gap"], gap, size):
        raise InputError("does not follow from the heights", argument="initial_gap")
    if not np.array_equal(np.asarray(stated["saturated"]) > 0, result.saturated):
        raise InputError("differs from the pixels at the ceiling", argument="saturated")


def _alike(found: Any, wanted: Array, size: float) -> bool:
    found = np.asarray(found)
    return found.shape == wanted.shape and np.allclose(
        found, wanted, rtol=0, atol=_ROUNDING * size, equal_nan=True
    )
