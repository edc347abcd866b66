"""Root finding for functions of one variable.

The steps of `brentq` equal those of SciPy to the bit; the import of ``scipy.optimize`` takes
longer than most contacts.

`brentq`: Brent, Algorithms for Minimization Without Derivatives (1973), ch. 4

`bracket_crossing`: Crossing of a value by a quantity that grows with the load. Inverse
interpolation of the logarithms, aimed slightly beyond the crossing so that the bracket shrinks from
both sides; bisection if three steps do not halve the bracket. On a plateau of a piecewise constant
quantity each step is twice the previous one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from itertools import pairwise

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


ACCURACY = 1e-6
"""Relative accuracy of the value, or relative width of the bracket."""

# Logarithms of a load, and of the quantity over the requested value.
Point = tuple[float, float]

_STEP = math.log(1000.0)
_MAX_EXTRAPOLATION = math.log(10.0)
_SOLVES = 80


class NotPassedError(Exception):
    """Error for a quantity that does not cross the value up to an end of the loads."""

    def __init__(self, end: Point) -> None:
        super().__init__()
        self.end = end


def bracket_crossing(
    excess: Callable[[float], float],
    first: float,
    ends: tuple[float, float],
    *,
    accuracy: float,
    slope: float = 1.0,
    known: Iterable[Point] = (),
    adjacent: Callable[[float, float], bool] = lambda low, high: False,
) -> tuple[Point, Point]:
    """Return two neighboring points between which a quantity crosses a value."""
    points = sorted(known)
    widths: list[float] = []
    errors: list[float] = []
    beyond, last = 0.4 * accuracy, math.inf
    x = min(max(first, ends[0]), ends[1])
    for _ in range(_SOLVES):
        if all(x != index for index, _ in points):
            y = excess(x)
            points = sorted([*points, (x, y)])
            # Aim further beyond the crossing while steps stay on one side without coming closer.
            beyond = 10 * beyond if y == 0 or y / last > 0.3 else 0.4 * accuracy
            last = y or accuracy
        result = _bracket(points)
        if result is None:
            x = _next_outside(points, ends, beyond, slope)
            continue
        low, high = result
        widths.append(high[0] - low[0])
        errors.append(min(abs(low[1]), abs(high[1])))
        near = max(abs(low[1]), abs(high[1])) <= accuracy
        if near or widths[-1] <= ACCURACY or adjacent(low[0], high[0]):
            break
        x = _interpolate_crossing(points, beyond, slope)
        if not low[0] < x < high[0]:
            x = _interpolate_crossing([low, high], beyond, slope)
        slow = len(widths) > 3 and all(v[-1] > 0.5 * v[-4] for v in (widths, errors))
        middle = 0.5 * (low[0] + high[0])
        for a, b in pairwise(points):
            # On a plateau each step is twice the previous one.
            if a[1] == b[1] and b is low:
                x = min(low[0] + 2 * (b[0] - a[0]), middle)
            elif a[1] == b[1] and a is high:
                x = max(high[0] - 2 * (b[0] - a[0]), middle)
        if slow or not low[0] < x < high[0]:
            x = middle
            widths, errors = [], []
    return low, high


def _bracket(points: list[Point]) -> tuple[Point, Point] | None:
    """Return the neighbors below and above the value at the largest crossing, if any."""
    result = None
    for low, high in pairwise(points):
        if low[1] < 0 <= high[1]:
            result = low, high
    return result


def _interpolate_crossing(points: list[Point], beyond: float, slope: float) -> float:
    """Return the estimated crossing, aimed slightly beyond; NaN without finite points.

    Inverse interpolation through at most three nearest points that ascend: the error of the root
    is about the product of their errors (Brent 1973, Algorithms for Minimization, chap. 4).
    """
    finite = sorted((p for p in points if math.isfinite(p[1])), key=lambda p: abs(p[1]))
    if not finite:
        return math.nan
    chosen = finite[:1]
    for point in finite[1:]:
        # Points that are close together do not extrapolate well.
        distant = all(abs(point[1] - y) > 0.1 * abs(finite[0][1]) for _, y in chosen)
        ascending = all((point[0] - x) * (point[1] - y) > 0 for x, y in chosen)
        if len(chosen) < 3 and distant and ascending:
            chosen.append(point)
    aim = math.copysign(beyond, -finite[0][1])
    if len(chosen) == 1:
        return chosen[0][0] + (aim - chosen[0][1]) / slope
    return sum(
        x * math.prod((aim - other) / (y - other) for _, other in chosen if other != y)
        for x, y in chosen
    )


def _next_outside(
    points: list[Point], ends: tuple[float, float], beyond: float, slope: float
) -> float:
    """Return the next load while all points are on one side."""
    above = points[-1][1] >= 0
    end, edge = (points[0], ends[0]) if above else (points[-1], ends[1])
    if (end[0] <= edge) if above else (end[0] >= edge):
        raise NotPassedError(end)
    guess = _interpolate_crossing(points, beyond, slope)
    # Without a step forward, or with short steps, the search would stay on this side.
    ahead = (guess < end[0]) if above else (guess > end[0])
    step = min(abs(guess - end[0]), _STEP) if ahead else _MAX_EXTRAPOLATION
    return max(end[0] - step, edge) if above else min(end[0] + step, edge)
