"""Projection on the admissible pressures: between zero and the ceiling, with a given sum."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_MAX_STEPS = 200
_ROUNDING = 1e-15
# Relative to the limit, or to the largest value: what this near to a bound is put on it.
_DUST = 1e-12


def shift_to_sum(
    values: NDArray[np.float64], limit: float | NDArray[np.float64], total: float
) -> float:
    """Return λ such that the sum of ``clip(values + λ, 0, limit)`` is ``total``.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Any real numbers.
    limit : float or ndarray, shape (n,)
        Upper bounds, positive; ``inf`` where there is none.
    total : float
        Sum wanted, between 0 and the sum of the limits.

    Returns
    -------
    float
        The shift. The sum is a piecewise linear, non-decreasing function of it; Newton's method
        on such a function ends after finitely many steps, and a bracket guards it.

    Notes
    -----
    ``clip(values + λ, 0, limit)`` is the Euclidean projection of ``values`` on the set, and λ the
    multiplier of its sum (Pardalos and Kovoor 1990, doi:10.1007/BF01585748).
    """
    low, high = _bracket(values, limit, total)
    if total <= 0:
        return low
    shift = min(max(0.0, low), high)
    tried: set[float] = set()
    halve = False
    while len(tried) < _MAX_STEPS and shift not in tried:
        tried.add(shift)
        moved = values + shift
        excess = float(np.clip(moved, 0, limit).sum()) - total
        # As exact as the sum of so many numbers is itself.
        if abs(excess) <= _ROUNDING * total:
            break
        width = high - low
        if excess > 0:
            high = shift
        else:
            low = shift
        free = int(np.count_nonzero((moved > 0) & (moved < limit)))
        step = shift - excess / free if free and not halve else np.nan
        # Newton's steps may creep along a staircase of values: then halve the bracket in between.
        halve = not halve and high - low > 0.5 * width
        usable = low <= step <= high and step not in tried
        shift = step if usable else 0.5 * (low + high)
    return shift


def _bracket(
    values: NDArray[np.float64], limit: float | NDArray[np.float64], total: float
) -> tuple[float, float]:
    """Return shifts below and above which the sum cannot lie on its way to ``total``."""
    limits = np.broadcast_to(limit, values.shape)
    unlimited = np.isinf(limits)
    if unlimited.any():
        # One value without limit can carry everything.
        high = total - float(values[unlimited].max())
    else:
        high = float((limits - values).max())
    low = -float(values.max())
    return min(low, high), max(low, high)


def project(
    values: NDArray[np.float64], limit: float | NDArray[np.float64], total: float
) -> NDArray[np.float64]:
    """Return the point nearest to ``values`` with entries in ``[0, limit]`` and sum ``total``.

    Parameters
    ----------
    values, limit, total
        As for `shift_to_sum`.

    Returns
    -------
    ndarray, shape (n,)
        The projection; entries at a bound are exactly the bound.
    """
    projected = np.clip(values + shift_to_sum(values, limit, total), 0, limit)
    # What the resolution of the shift leaves, if the values dwarf the limit.
    missing = total - float(projected.sum())
    free = (projected > 0) & (projected < limit)
    if missing and free.any():
        share = missing / np.count_nonzero(free)
        np.clip(projected + share, 0, limit, out=projected, where=free)
    return projected


def without_dust(
    pressure: NDArray[np.float64], limit: float | NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the pressure with what rounding left near a bound put on the bound.

    Parameters
    ----------
    pressure : ndarray, shape (n,)
        Values in ``[0, limit]``.
    limit : float or ndarray, shape (n,)
        Upper bounds.

    Returns
    -------
    ndarray, shape (n,)
        The values; whether a pixel touches or is saturated is no matter of rounding any more.
    """
    dust = _DUST * np.minimum(limit, pressure.max(initial=0))
    cleaned = np.where(pressure > limit - dust, limit, pressure)
    cleaned[cleaned < dust] = 0
    return cleaned
