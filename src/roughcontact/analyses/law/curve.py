"""Interpolation of pressure over separation, and its tables for other programs.

`Asperities`: η = m₄/(6π√3 m₂) and R = 3√π/(8√m₄) are those of an isotropic Gaussian surface.

Greenwood and Tripp 1970, doi:10.1243/PIME_PROC_1970_185_069_02 Nayak 1971,
doi:10.1115/1.3451608; McCool 1987, J. Tribol. 109, 264
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._tools.arrays import Array
from roughcontact.cautions import (
    MIN_MAPS,
    Caution,
    CautionTag,
    as_caution,
    as_note,
    as_warning,
    few_maps,
)
from roughcontact.units import format_engineering, format_percent

ERROR = 0.01
"""Relative pressure error of straight lines between the rows of a table."""

# Number of interpolated points per solved interval, from which table rows are selected.
_FINE = 64
# Minimum number of points for an error estimate, which leaves out every second point.
_MIN_THINNED_POINTS = 3
# Error reduction at half the point distance, with computed slopes and without.
_COMPUTED, _FROM_NEIGHBORS = 8.0, 3.0
# Minimum difference in separation of two points, over the separation at first touch.
_MIN_SEPARATION_STEP = 1e-7


@dataclass(frozen=True, eq=False)
class Curve:
    """Branch of a law: nominal pressure over the separation of the mean planes."""

    pressure: Array  # (n,) p̄ [Pa], ascending and positive
    separation: Array  # (n,) ū [m], descending
    compliance: Array | None  # (n,) -dū/dp̄ [m/Pa]
    first_touch: float  # ū at which the bodies first touch [m]

    @property
    def slope(self) -> Array:
        """-dū/d ln p̄ at the solved points [m], shape (n,)."""
        if self.compliance is not None:
            return self.pressure * self.compliance
        count = self.pressure.size
        if count == 1:
            return np.zeros(1)
        log = np.log(self.pressure)
        return -np.gradient(self.separation, log, edge_order=1 if count == 2 else 2)

    def separation_at(self, pressure: ArrayLike) -> Array:
        """Return the separation ū [m] at nominal pressures [Pa] within the range."""
        x, y = np.log(self.pressure), self.separation
        slope = _monotone(x, y, -self.slope)
        logarithm = np.log(np.asarray(pressure, dtype=np.float64))
        k = np.clip(np.searchsorted(x, logarithm, side="right") - 1, 0, max(x.size - 2, 0))
        if x.size == 1:
            return np.full(logarithm.shape, y[0])
        step = x[k + 1] - x[k]
        t = (logarithm - x[k]) / step
        return (
            (1 + 2 * t) * (1 - t) ** 2 * y[k]
            + t * (1 - t) ** 2 * step * slope[k]
            + t**2 * (3 - 2 * t) * y[k + 1]
            - t**2 * (1 - t) * step * slope[k + 1]
        )

    @property
    def error(self) -> float:
        """Relative pressure error between solved points; NaN for fewer than three points."""
        if self.pressure.size < _MIN_THINNED_POINTS:
            return math.nan
        inner = np.arange(1, self.pressure.size - 1)
        worst = 0.0
        for odd in (inner[::2], inner[1::2]):
            others = np.setdiff1d(np.arange(self.pressure.size), odd)
            known = None if self.compliance is None else self.compliance[others]
            rest = Curve(self.pressure[others], self.separation[others], known, self.first_touch)
            off = np.abs(rest.separation_at(self.pressure[odd]) - self.separation[odd])
            slope = self.slope[odd]
            worst = max(worst, float((off[slope > 0] / slope[slope > 0]).max(initial=0.0)))
        return worst / (_FROM_NEIGHBORS if self.compliance is None else _COMPUTED)

    def fine(self) -> tuple[Array, Array]:
        """Return pressures and separations of closely spaced points, strictly monotone."""
        p = refine_geometrically(self.pressure)
        u = self.separation_at(p)
        chosen = [0]
        minimum = _MIN_SEPARATION_STEP * abs(self.first_touch)
        for number in range(1, p.size):
            if u[chosen[-1]] - u[number] > minimum:
                chosen.append(number)
        return p[chosen], u[chosen]

    def table(self, error: float = ERROR) -> tuple[Array, Array]:
        """Return the rows of a table: pressures [Pa] and separations [m]."""
        p, u = self.fine()
        rows = thin_points(-u, p, error)
        return np.concatenate([[0.0], p[rows]]), np.concatenate([[self.first_touch], u[rows]])


def refine_geometrically(values: Array, number: int = _FINE) -> Array:
    """Return positive values, refined by values in equal ratios."""
    parts = [np.geomspace(first, last, number, endpoint=False) for first, last in pairwise(values)]
    return np.concatenate([*parts, values[-1:]])


def thin_points(x: Array, y: Array, error: float) -> NDArray[np.int64]:
    """Return the indices of the points that a table needs, including both ends."""
    chosen = [0]
    while chosen[-1] < x.size - 1:
        first = chosen[-1]
        # Bisection: the next point is always within the error, which grows with the line length.
        holding, failing = first + 1, x.size
        while failing - holding > 1:
            middle = (holding + failing) // 2
            if _is_within_error(x[first : middle + 1], y[first : middle + 1], error):
                holding = middle
            else:
                failing = middle
        chosen.append(holding)
    return np.array(chosen)


def _is_within_error(x: Array, y: Array, error: float) -> bool:
    line = y[0] + (y[-1] - y[0]) * (x - x[0]) / (x[-1] - x[0])
    return bool((np.abs(line - y) <= error * y).all())


def _monotone(x: Array, y: Array, slope: Array) -> Array:
    """Return slopes limited for a monotone descending cubic (Fritsch, Carlson)."""
    if x.size < 2:
        return np.zeros_like(slope)
    secant = np.diff(y) / np.diff(x)
    steepest = np.maximum(np.append(secant, -math.inf), np.append(-math.inf, secant))
    return np.clip(slope, 3 * steepest, 0.0)


@dataclass(frozen=True)
class Asperities:
    """Greenwood-Tripp parameters of a rough surface, for programs of mixed lubrication."""

    m0: float  # Mean square of height [m²]
    m2: float  # Mean square of slope along profiles
    m4: float  # Mean square of curvature along profiles [1/m²]

    @property
    def deviation(self) -> float:
        """Standard deviation of the heights σ [m]."""
        return math.sqrt(self.m0)

    @property
    def density(self) -> float:
        """Summit density η [1/m²]."""
        return self.m4 / (6 * math.pi * math.sqrt(3) * self.m2)

    @property
    def radius(self) -> float:
        """Mean radius of the summits R [m]."""
        return 3 * math.sqrt(math.pi) / (8 * math.sqrt(self.m4))

    @property
    def bandwidth(self) -> float:
        """Nayak parameter α = m₀ m₄/m₂²: 1.5 for one wavelength, larger for broad spectra."""
        return self.m0 * self.m4 / self.m2**2

    @property
    def roughness_parameter(self) -> float:
        """Roughness parameter η R σ."""
        return self.density * self.radius * self.deviation


def asperities(heights: Array, pixel: tuple[float, float]) -> Asperities:
    """Return the spectral moments of a map."""
    slopes, curvatures = [], []
    for axis, edge in enumerate(pixel):
        slopes.append(np.nanmean((np.diff(heights, axis=axis) / edge) ** 2))
        curvatures.append(np.nanmean((np.diff(heights, 2, axis=axis) / edge**2) ** 2))
    return Asperities(float(np.nanvar(heights)), float(np.mean(slopes)), float(np.mean(curvatures)))


# Resolved range of an interface law.


MIN_SPOTS = 10
"""Minimum number of contact spots; with fewer, the law scatters between maps."""

MIN_POINTS = 100
"""Minimum numbers of points in contact and of open points; fewer depend on the pixel."""

MAX_CONTACT_FRACTION = 0.9
"""Maximum contact fraction; above it, the open dales are not resolved by the pixel."""

# Relative pressure difference up to which whole maps and parts agree.
_PARTS_TOLERANCE = 0.05

SPOTS, POINTS, CONTACT, SLOPE = "spots", "points", "contact", "slope"


@dataclass(frozen=True)
class Resolved:
    """Range of nominal pressures that maps resolve."""

    low: float  # Lowest [Pa]
    high: float  # Highest [Pa]
    low_by: str = ""  # Limit at the low end
    high_by: str = ""  # Limit at the high end


def resolved_range(pressures: Array, means: Mapping[str, Array], scatter: float) -> Resolved:
    """Return the range of pressures that maps resolve."""
    from_below = (
        (SPOTS, means["spots"] >= MIN_SPOTS),
        (POINTS, means["contact_points"] >= MIN_POINTS),
    )
    from_above = (
        (CONTACT, means["contact_fraction"] <= MAX_CONTACT_FRACTION),
        (POINTS, means["open_points"] >= MIN_POINTS),
        (SLOPE, pressures <= scatter),
    )
    # Spots merge as the contact closes: only the first pressure with enough spots is decisive.
    first = [
        (int(np.argmax(good)) if good.any() else pressures.size, by) for by, good in from_below
    ]
    last = [(int(good.sum()) - 1, by) for by, good in from_above]
    (low, low_by), (high, high_by) = max(first), min(last)
    if low > high:
        return Resolved(math.nan, math.nan, low_by if low else "", high_by)
    return Resolved(
        float(pressures[low]),
        float(pressures[high]),
        low_by if low else "",
        high_by if high < pressures.size - 1 else "",
    )


_BELOW = {SPOTS: f"fewer than {MIN_SPOTS} spots", POINTS: f"fewer than {MIN_POINTS} contact pixels"}
_ABOVE = {
    CONTACT: f"more than {100 * MAX_CONTACT_FRACTION:.0f} % contact",
    POINTS: f"fewer than {MIN_POINTS} open pixels",
    SLOPE: "pressure over E*h'/2",
}
"""Reasons why a law is not resolved below and above a pressure."""


def cautions(maps: int, result: Resolved, rim: float) -> Iterator[Caution]:
    """Yield cautions on the number of maps, the resolved range and the margin."""
    if math.isnan(result.low):
        yield as_warning(
            CautionTag.LAW_RANGE,
            "No pressure is resolved by these maps. Use larger or finer maps, or other pressures.",
        )
    elif result.low_by or result.high_by:
        why = [f"{_BELOW[result.low_by]} below"] if result.low_by else []
        why += [f"{_ABOVE[result.high_by]} above"] if result.high_by else []
        yield as_caution(
            CautionTag.LAW_RANGE,
            f"Reliable from {format_engineering(result.low, 'Pa', 3)} to "
            f"{format_engineering(result.high, 'Pa', 3)}: {', '.join(why)}.",
            low=result.low,
            high=result.high,
        )
    if maps < MIN_MAPS:
        yield few_maps(maps)
    if rim:
        yield as_note(
            CautionTag.LAW_MARGIN,
            f"A {format_engineering(rim, 'm', 3)} margin at each free edge is excluded.",
            rim=rim,
        )


@dataclass(frozen=True)
class PartSize:
    """Difference between the law of parts of the maps and the law of the whole maps."""

    off: float  # Largest relative pressure difference at one separation
    chance: float  # Relative difference that is explained by chance
    sufficient: bool  # Whether no difference exceeds chance

    @property
    def caution(self) -> Caution | None:
        """Caution on maps that are too small."""
        if self.sufficient:
            return None
        return as_caution(
            CautionTag.LAW_SIZE,
            f"Quarter maps differ by {format_percent(self.off)} (chance "
            f"{format_percent(self.chance)}): the law depends on map size. Use larger maps.",
            off=self.off,
            chance=self.chance,
        )


def judge_part_size(whole: Curve, parts: Curve, error: Array, within: Resolved) -> PartSize | None:
    """Return the difference of the laws of parts and whole maps; None without common range."""
    low = max(within.low, parts.pressure[0])
    inside = (whole.pressure >= low) & (whole.pressure <= min(within.high, parts.pressure[-1]))
    pressures = whole.pressure[inside]
    # Convert a difference of separations to a relative difference of pressures, by the slope.
    slope = 1 / np.maximum(whole.slope[inside], 1e-300)
    off = np.abs(parts.separation_at(pressures) - whole.separation[inside]) * slope
    chance = np.interp(np.log(pressures), np.log(parts.pressure), error) * slope
    if not off.size:
        return None
    worst = int(np.argmax(off))
    alike = not (off > np.maximum(_PARTS_TOLERANCE, chance)).any()
    return PartSize(float(off[worst]), float(chance[worst]), alike)
