"""Projection on the admissible pressures: between zero and the ceiling, with a given sum."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_MAX_STEPS = 200


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
    low, high = -np.inf, np.inf
    shift = 0.0
    for _ in range(_MAX_STEPS):
        moved = values + shift
        clipped = np.clip(moved, 0, limit)
        excess = float(clipped.sum()) - total
        if excess > 0:
            high = shift
        elif excess < 0:
            low = shift
        else:
            break
        free = int(np.count_nonzero((moved > 0) & (moved < limit)))
        if free:
            proposal = shift - excess / free
        elif excess < 0:
            # Nothing moves yet: go to the first value that does.
            proposal = -float(moved[moved <= 0].max(initial=-np.inf)) + shift
            proposal += -excess / values.size
        else:
            over = (moved - limit)[moved >= limit]
            proposal = shift - float(over.min(initial=np.inf)) - excess / values.size
        if not low < proposal < high:
            if not (np.isfinite(low) and np.isfinite(high)):
                break
            proposal = 0.5 * (low + high)
        if proposal in (low, high, shift):
            break
        shift = proposal
    return shift


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
    return np.clip(values + shift_to_sum(values, limit, total), 0, limit)
