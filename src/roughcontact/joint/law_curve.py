"""Pressure over separation between solved points, and tables of it for other programs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

ERROR = 0.01
"""Part of the pressure to which a straight line between two rows of a table is right."""

# Points between two solved ones among which the rows of a table are chosen.
_FINE = 64
# Points from which every second can be left out.
_FEWEST = 3
# What half the distance makes of an error, with slopes that were computed and without.
_COMPUTED, _FROM_NEIGHBORS = 8.0, 3.0
# Two points whose separations differ by less than this part of the first touch are one.
_LEAST_STEP = 1e-7


@dataclass(frozen=True, eq=False)
class Curve:
    """One branch of a law: nominal pressure over the separation of the mean planes.

    Between two solved points the separation is a cubic of ln p̄ with the computed stiffness at both
    ends, held monotone.

    Parameters
    ----------
    pressure : ndarray, shape (n,)
        p̄ [Pa], ascending and positive.
    separation : ndarray, shape (n,)
        ū [m], descending.
    compliance : ndarray, shape (n,), or None
        -dū/dp̄ [m/Pa]; without it the slopes are those of parabolas through the neighbors.
    first_touch : float
        ū at which the bodies first touch [m].
    """

    pressure: Array
    separation: Array
    compliance: Array | None
    first_touch: float

    @property
    def slope(self) -> Array:
        """-dū/d ln p̄ at the solved points [m], shape (n,)."""
        if self.compliance is not None:
            return self.pressure * self.compliance
        count = self.pressure.size
        if count == 1:
            return np.zeros(1)
        log = np.log(self.pressure)
        slope: Array = -np.gradient(self.separation, log, edge_order=1 if count == 2 else 2)
        return slope

    def separation_at(self, pressure: ArrayLike) -> Array:
        """Return ū [m] at nominal pressures [Pa] between the first and the last."""
        x, y = np.log(self.pressure), self.separation
        slope = _monotone(x, y, -self.slope)
        at = np.log(np.asarray(pressure, dtype=np.float64))
        k = np.clip(np.searchsorted(x, at, side="right") - 1, 0, max(x.size - 2, 0))
        if x.size == 1:
            return np.full(at.shape, y[0])
        step = x[k + 1] - x[k]
        t = (at - x[k]) / step
        found: Array = (
            (1 + 2 * t) * (1 - t) ** 2 * y[k] + t * (1 - t) ** 2 * step * slope[k]
            + t**2 * (3 - 2 * t) * y[k + 1] - t**2 * (1 - t) * step * slope[k + 1]
        )  # fmt: skip
        return found

    @property
    def error(self) -> float:
        """By what part the pressure between two solved ones may be off.

        What every second point is off on the curve through the others, as pressure at the same
        separation, less what half the distance makes of it; NaN of fewer than three points. On
        Westergaard's law it is 0.6 to 1.6 of the error.
        """
        if self.pressure.size < _FEWEST:
            return math.nan
        inner = np.arange(1, self.pressure.size - 1)
        worst = 0.0
        for odd in (inner[::2], inner[1::2]):
            left = np.setdiff1d(np.arange(self.pressure.size), odd)
            known = None if self.compliance is None else self.compliance[left]
            rest = Curve(self.pressure[left], self.separation[left], known, self.first_touch)
            off = np.abs(rest.separation_at(self.pressure[odd]) - self.separation[odd])
            slope = self.slope[odd]
            told = off[slope > 0] / slope[slope > 0]
            worst = max(worst, float(told.max(initial=0.0)))
        return worst / (_FROM_NEIGHBORS if self.compliance is None else _COMPUTED)

    def fine(self) -> tuple[Array, Array]:
        """Return pressures and separations of closely spaced points, strictly monotone."""
        p = between(self.pressure)
        u = self.separation_at(p)
        kept = [0]
        least = _LEAST_STEP * abs(self.first_touch)
        for number in range(1, p.size):
            if u[kept[-1]] - u[number] > least:
                kept.append(number)
        return p[kept], u[kept]

    def table(self, error: float = ERROR) -> tuple[Array, Array]:
        """Return the rows of a table: pressures [Pa] and separations [m].

        Parameters
        ----------
        error : float
            Part of the pressure that straight lines between the rows may be off.

        Returns
        -------
        (ndarray, ndarray), shape (m,)
            The first row is zero pressure at the first touch; a straight line joins it to the
            smallest pressure that was solved. Pressures ascend and separations descend strictly.
        """
        p, u = self.fine()
        rows = thinned(-u, p, error)
        return np.concatenate([[0.0], p[rows]]), np.concatenate([[self.first_touch], u[rows]])


def between(values: Array, number: int = _FINE) -> Array:
    """Return positive values with others in equal ratios between each two of them."""
    parts = [np.geomspace(first, last, number, endpoint=False) for first, last in pairwise(values)]
    return np.concatenate([*parts, values[-1:]])


def thinned(x: Array, y: Array, error: float) -> NDArray[np.int64]:
    """Return which points of a curve a table needs, the first and the last among them.

    Parameters
    ----------
    x, y : ndarray, shape (n,)
        The curve, x ascending and y positive.
    error : float
        Part of y by which straight lines between the points kept may be off at the others.

    Returns
    -------
    ndarray of int
        Numbers of the points, ascending.
    """
    kept = [0]
    while kept[-1] < x.size - 1:
        first = kept[-1]
        # The next point always holds; the longer a line, the less it does.
        holding, failing = first + 1, x.size
        while failing - holding > 1:
            middle = (holding + failing) // 2
            if _holds(x[first : middle + 1], y[first : middle + 1], error):
                holding = middle
            else:
                failing = middle
        kept.append(holding)
    return np.array(kept)


def _holds(x: Array, y: Array, error: float) -> bool:
    line = y[0] + (y[-1] - y[0]) * (x - x[0]) / (x[-1] - x[0])
    return bool((np.abs(line - y) <= error * y).all())


def _monotone(x: Array, y: Array, slope: Array) -> Array:
    """Return slopes of a descending cubic, no steeper than keeps it monotone (Fritsch, Carlson)."""
    if x.size < 2:
        return np.zeros_like(slope)
    secant = np.diff(y) / np.diff(x)
    steepest = np.maximum(np.append(secant, -math.inf), np.append(-math.inf, secant))
    limited: Array = np.clip(slope, 3 * steepest, 0.0)
    return limited
