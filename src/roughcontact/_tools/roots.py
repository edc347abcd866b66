"""Root finding for functions of one variable.

The steps equal those of ``brentq`` of SciPy to the bit; the import of ``scipy.optimize`` takes
longer than most contacts.

`brentq`: Brent, Algorithms for Minimization Without Derivatives (1973), ch. 4
"""

from __future__ import annotations

import math
from collections.abc import Callable

# Defaults of SciPy.
_XTOL, _RTOL = 2e-12, 4 * 2.0**-52
_MAX_STEPS = 100


def brentq(
    function: Callable[[float], float],
    low: float,
    high: float,
    *,
    xtol: float = _XTOL,
    rtol: float = _RTOL,
) -> float:
    """Return a zero in an interval, by Brent's method with inverse quadratic steps."""
    before, here = float(low), float(high)
    f_before, f_here = _value(function, before), _value(function, here)
    if f_before == 0:
        return before
    if f_here == 0:
        return here
    if (f_before < 0) == (f_here < 0):
        raise ValueError(f"the function has one sign at {low} and {high}")
    # The zero is between `here`, the best so far, and `across`.
    across, f_across, step_before, step = 0.0, 0.0, 0.0, 0.0
    for _ in range(_MAX_STEPS):
        if f_before != 0 and f_here != 0 and (f_before < 0) != (f_here < 0):
            across, f_across = before, f_before
            step_before = step = here - before
        if abs(f_across) < abs(f_here):
            before, here, across = here, across, here
            f_before, f_here, f_across = f_here, f_across, f_here
        minimum = (xtol + rtol * abs(here)) / 2
        half = (across - here) / 2
        if f_here == 0 or abs(half) < minimum:
            return here
        tried = math.inf
        if abs(step_before) > minimum and abs(f_here) < abs(f_before):
            tried = _interpolated_step((before, here, across), (f_before, f_here, f_across))
        if 2 * abs(tried) < min(abs(step_before), 3 * abs(half) - minimum):
            step_before, step = step, tried
        else:
            step_before = step = half
        before, f_before = here, f_here
        here += step if abs(step) > minimum else (minimum if half > 0 else -minimum)
        f_here = _value(function, here)
    raise RuntimeError(f"no zero was found to within {xtol} in {_MAX_STEPS} steps")


def _value(function: Callable[[float], float], place: float) -> float:
    result = float(function(place))
    if math.isnan(result):
        raise ValueError(f"the function is NaN at {place}")
    return result


def _interpolated_step(
    places: tuple[float, float, float], values: tuple[float, float, float]
) -> float:
    """Return the step to the zero of a line or an inverse parabola; infinite without one."""
    (before, here, across), (f_before, f_here, f_across) = places, values
    try:
        if before == across:
            return -f_here * (here - before) / (f_here - f_before)
        slope_before = (f_before - f_here) / (before - here)
        slope_across = (f_across - f_here) / (across - here)
        return (
            -f_here
            * (f_across * slope_across - f_before * slope_before)
            / (slope_across * slope_before * (f_across - f_before))
        )
    except ZeroDivisionError:
        return math.inf
