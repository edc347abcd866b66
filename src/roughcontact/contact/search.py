"""Where a quantity that grows with the load passes a value."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from itertools import pairwise

# Logarithms of a load, and of the quantity there over the value wanted.
Point = tuple[float, float]

_STEP = math.log(1000.0)
_BLIND = math.log(10.0)
_SOLVES = 80


class NotPassedError(Exception):
    """The quantity stays on one side of the value, up to an end of the loads."""

    def __init__(self, end: Point) -> None:
        super().__init__()
        self.end = end


def passage(
    excess: Callable[[float], float],
    first: float,
    ends: tuple[float, float],
    *,
    accuracy: float,
    known: Iterable[Point] = (),
    adjacent: Callable[[float, float], bool] = lambda low, high: False,
) -> tuple[Point, Point]:
    """Return two neighboring points between which a quantity passes a value.

    Parameters
    ----------
    excess : callable
        ``excess(x)`` returns by what part the quantity exceeds the value at the load exp(x), as
        ln(quantity / value): negative where it is not reached, -inf where there is none of it.
    first : float
        Where to begin.
    ends : (float, float)
        Smallest and largest x.
    accuracy : float
        The points are neighbors when the quantity is so close to the value at both, or their
        loads so close to each other, relatively.
    known : iterable of Point
        What was looked at before.
    adjacent : callable
        ``adjacent(low, high)`` says of two x that nothing lies between their quantities: whole
        pixels that differ by one.

    Returns
    -------
    (Point, Point)
        The first below the value, the second not. Where the quantity passes it more than once,
        the passage at the largest load that was seen.

    Raises
    ------
    NotPassedError
        If there is no passage between the ends.

    Notes
    -----
    Secants of the logarithms, each a little longer than needed so that it lands beyond the
    passage and the points close in from both sides; halves where two of them do not halve the
    bracket. On the tread of a staircase each step is twice the one before.
    """
    points = sorted(known)
    widths: list[float] = []
    x = min(max(first, ends[0]), ends[1])
    for _ in range(_SOLVES):
        if all(x != at for at, _ in points):
            points = sorted([*points, (x, excess(x))])
        found = _bracket(points)
        if found is None:
            x = _beyond(points, ends, accuracy)
            continue
        low, high = found
        width = high[0] - low[0]
        near = max(abs(low[1]), abs(high[1])) <= accuracy
        if near or width <= accuracy or adjacent(low[0], high[0]):
            break
        widths.append(width)
        x = _between(points, low, high, accuracy)
        slow = len(widths) > 2 and widths[-1] > 0.5 * widths[-3]
        middle = 0.5 * (low[0] + high[0])
        for a, b in pairwise(points):
            if a[1] == b[1] and b is low:
                x = min(low[0] + 2 * (b[0] - a[0]), middle)
            elif a[1] == b[1] and a is high:
                x = max(high[0] - 2 * (b[0] - a[0]), middle)
        if slow or not low[0] < x < high[0]:
            x = middle
            widths = []
    return low, high


def _bracket(points: list[Point]) -> tuple[Point, Point] | None:
    """Return the uppermost neighbors below and above."""
    found = None
    for low, high in pairwise(points):
        if low[1] < 0 <= high[1]:
            found = low, high
    return found


def _secant(points: list[Point], accuracy: float) -> tuple[float, float] | None:
    """Return the nearest point's x and where the passage should be, a little beyond."""
    finite = sorted((p for p in points if math.isfinite(p[1])), key=lambda p: abs(p[1]))
    if not finite:
        return None
    (at, value), *others = finite
    other = others[0] if others else None
    slope = 1.0 if other is None else (other[1] - value) / (other[0] - at)
    if not slope > 0:
        slope = 1.0
    beyond = 0.1 if other is None else min(0.1, abs(other[1]))
    aim = math.copysign(max(beyond * abs(value), 0.4 * accuracy), -value)
    return at, at + (aim - value) / slope


def _between(points: list[Point], low: Point, high: Point, accuracy: float) -> float:
    guess = _secant(points, accuracy)
    if guess is None or not low[0] < guess[1] < high[0]:
        guess = _secant([low, high], accuracy)
    return math.nan if guess is None else guess[1]


def _beyond(points: list[Point], ends: tuple[float, float], accuracy: float) -> float:
    """Return where to look next while all points lie on one side."""
    above = points[-1][1] >= 0
    end, edge = (points[0], ends[0]) if above else (points[-1], ends[1])
    if (end[0] <= edge) if above else (end[0] >= edge):
        raise NotPassedError(end)
    guess = _secant(points, accuracy)
    step = _BLIND if guess is None else abs(guess[1] - end[0])
    # A secant that points back, or creeps, would never leave this side.
    ahead = guess is not None and ((guess[1] < end[0]) if above else (guess[1] > end[0]))
    step = min(step, _STEP) if ahead else _BLIND
    if len(points) > 4:
        step = max(step, 0.5 * abs(points[-1][0] - points[0][0]))
    return max(end[0] - step, edge) if above else min(end[0] + step, edge)
