"""How two rigid bodies come to rest on each other, under a ceiling of the pressure or without one.

Where heights differ far more than the pressure displaces them, the moment of the pressure is a
staircase over the tilt: a search that looks for its slope finds none. The tilt of rigid bodies lies
within some displacements of the one that is sought, and a linear programme gives it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.solvers.problem import Problem

Array = NDArray[np.float64]

# On more points than these the steps of the staircase have become too small to matter.
_MOST_POINTS = 1 << 20
# Parts of the load this near to a bound are on it.
_BOUND = 1e-12


def rigid_tilt(problem: Problem, levers: tuple[Array, Array], target: Array) -> Array | None:
    """Return the tilt at which rigid bodies rest under a load that acts at a point.

    Parameters
    ----------
    problem : Problem
        A problem under a given load; ``initial_gap`` is that without tilt.
    levers : (ndarray, ndarray), shapes (ny, 1) and (nx,)
        As `roughcontact.solvers.tilt.levers` gives them.
    target : ndarray, shape (2,)
        Mean lever (y, x) of the pressure.

    Returns
    -------
    ndarray, shape (2,), or None
        Differences in gap over the longer side [m], along y and x; None where none was found.

    Notes
    -----
    Of all parts q of the load that lie between 0 and what the ceiling allows, sum to 1 and have
    the mean lever wanted, those that lie lowest, ``min ⟨h₀, q⟩``: the multipliers of the three
    sums are the plane that touches the body from above, which is the counter-body at rest.
    """
    from scipy.optimize import linprog

    touchable = np.isfinite(problem.initial_gap)
    if problem.whole is not None or not 0 < np.count_nonzero(touchable) <= _MOST_POINTS:
        return None
    assert problem.total is not None
    gap = problem.initial_gap[touchable]
    arms = [np.broadcast_to(lever, touchable.shape)[touchable] for lever in levers]
    spans = np.array([float(np.ptp(arm)) or 1.0 for arm in arms])
    most = np.broadcast_to(problem.limit, touchable.shape)[touchable] / problem.total
    most = np.where(most < 1, most, np.inf)
    sums = np.stack(
        [np.ones(gap.size), *((a - t) / s for a, t, s in zip(arms, target, spans, strict=True))]
    )
    deepest = float(gap.max()) or 1.0
    # An array of bounds is what its documentation shows, but its types do not know.
    bounds: Any = np.stack([np.zeros(gap.size), most], axis=1)
    found = linprog(
        gap / deepest, A_eq=sums, b_eq=np.array([1.0, 0, 0]), bounds=bounds, method="highs-ds"
    )
    if found.status != 0:
        return None
    plane, parts = found.eqlin.marginals * deepest, np.asarray(found.x)
    # To the last digit: through the points that are neither empty nor full.
    between = (parts > _BOUND) & (parts < most * (1 - _BOUND))
    on = sums[:, between].T
    plane = plane + np.linalg.lstsq(on, gap[between] - on @ plane, rcond=_BOUND)[0]
    tilt: Array = -plane[1:] / spans
    return tilt if np.isfinite(tilt).all() else None
