"""Means, differences between groups, and their confidence intervals.

Intervals follow Student, Welch, and Games and Howell: the values of a group are assumed to be
normally distributed, and the variances of two groups may differ.

`differences`: Two groups: Welch's t, with its degrees of freedom. More: simultaneous intervals
of confidence `LEVEL` for all pairs (Games and Howell 1976, doi:10.3102/10769986001002113), from the
distribution of the studentized range; for two groups both agree.

`components`: The interval of the share follows from F, exact for groups of equal size; for others
it uses the mean size of Searle, Casella and McCulloch (1992), section 3.6.

`parts_interval`: Long waves correlate neighboring parts. The variance of means over squares of
side L is S/L² (1 - a/L) if the waves are short compared with L: two sizes of parts give S, which
is used if it is larger. If the variance of the sixteen parts exceeds that of the 64 by more than
chance explains (at 10 %), the waves are not short, and the quarters are used if their interval is
wider.

Over Gaussian fields whose correlation has fallen to 1/e within three quarters of the width of a
sixteenth, the intervals cover 93 to 97 % of maps. Without 64 parts the independence of neighbors
is unknown: the half-width is a lower bound.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from roughcontact._tools.arrays import Array

LEVEL = 0.95
"""Confidence of every interval."""

MIN_COUNT = 4
"""Parts along a side whose scatter gives the error of the whole."""

# Probability that chance alone leads from sixteen parts to four.
_CHANCE_PROBABILITY = 0.1


@dataclass(frozen=True)
class Mean:
    """Mean of measurements, and the confidence interval of the true mean."""

    count: int  # Measurements
    value: float  # Their mean
    deviation: float  # Standard deviation, n - 1 in the denominator
    low: float  # Lower end of the interval of confidence `LEVEL`
    high: float  # Upper end


@dataclass(frozen=True)
class Difference:
    """Difference of two means."""

    value: float  # Second mean less first
    low: float  # Lower end of the interval of confidence `LEVEL`, shared by all pairs of groups
    high: float  # Upper end
    p: float  # Probability that some pair of equal groups would differ as much by chance

    @property
    def known(self) -> bool:
        """Whether there is an interval."""
        return not math.isnan(self.low)

    @property
    def excludes_zero(self) -> bool:
        """Whether the interval is on one side of zero."""
        return self.known and (self.low > 0 or self.high < 0)


@dataclass(frozen=True)
class Components:
    """Components of variance: between groups and within groups."""

    between: float  # Standard deviation between groups
    within: float  # Standard deviation within groups
    share: float  # Share of the variance that is between groups
    low: float  # Lower end of the interval of the share, of confidence `LEVEL`, cut at 0
    high: float  # Upper end, cut at 1
    groups: int  # Number of groups
    count: int  # Measurements in all groups


@dataclass(frozen=True)
class WholeError:
    """Uncertainty of the value of a whole map, from the scatter of its parts."""

    half: float  # Half-width of the interval of confidence `LEVEL`
    divisions: int  # Parts along a side
    parts: int  # Number of all parts whose scatter is used
    scaling: float
    falls: bool  # Whether chance alone explains a scaling other than 1


def mean_with_interval(values: ArrayLike) -> Mean:
    """Return the mean of measurements with its interval (Student)."""
    x = np.asarray(values, dtype=np.float64)
    average = float(x.mean())
    if x.size < 2:
        return Mean(x.size, average, math.nan, math.nan, math.nan)
    spread = _deviation(x)
    half = student(x.size - 1) * spread / math.sqrt(x.size)
    return Mean(x.size, average, spread, average - half, average + half)


def paired_difference(first: ArrayLike, second: ArrayLike) -> Difference:
    """Return the mean difference of paired measurements (Student)."""
    from scipy.special import stdtr

    result = mean_with_interval(np.subtract(np.asarray(second, float), np.asarray(first, float)))
    if math.isnan(result.low):
        return Difference(result.value, math.nan, math.nan, math.nan)
    error = result.deviation / math.sqrt(result.count)
    p = 2 * float(stdtr(result.count - 1, -_ratio(result.value, error)))
    return Difference(result.value, result.low, result.high, p)


def differences(groups: Sequence[ArrayLike]) -> dict[tuple[int, int], Difference]:
    """Return the differences of all pairs of groups (Welch, or Games and Howell)."""
    taken = [np.asarray(group, dtype=np.float64) for group in groups]
    return {
        (i, j): _difference(taken[i], taken[j], len(taken))
        for i, j in combinations(range(len(taken)), 2)
    }


def _difference(first: Array, second: Array, groups: int) -> Difference:
    value = float(second.mean() - first.mean())
    if min(first.size, second.size) < 2:
        return Difference(value, math.nan, math.nan, math.nan)
    parts = [_deviation(x) ** 2 / x.size for x in (first, second)]
    variance = sum(parts)
    if not variance:
        return Difference(value, value, value, float(not value))
    freedom = variance**2 / sum(
        part**2 / (x.size - 1) for part, x in zip(parts, (first, second), strict=True)
    )
    error = math.sqrt(variance)
    if groups == 2:
        from scipy.special import stdtr

        width, p = student(freedom), 2 * float(stdtr(freedom, -abs(value) / error))
    else:
        width, p = _studentized_range(groups, freedom, abs(value) / error)
    return Difference(value, value - width * error, value + width * error, p)


def holm(p: ArrayLike) -> Array:
    """Return p-values corrected for multiple tests (Holm 1979); NaN stays NaN."""
    values = np.asarray(p, dtype=np.float64)
    order, count = np.argsort(values), np.count_nonzero(~np.isnan(values))
    raised = values[order] * np.maximum(count - np.arange(values.size), 1)
    result = np.empty_like(values)
    result[order] = np.minimum(np.maximum.accumulate(raised), 1.0)
    return result


@lru_cache(maxsize=1024)
def _studentized_range(groups: int, freedom: float, ratio: float) -> tuple[float, float]:
    """Return the half-width of simultaneous intervals in standard errors, and a p-value."""
    from scipy.stats import studentized_range

    width = float(studentized_range.ppf(LEVEL, groups, freedom)) / math.sqrt(2)
    return width, float(studentized_range.sf(math.sqrt(2) * ratio, groups, freedom))


def components(groups: Sequence[ArrayLike]) -> Components:
    """Return the components of variance of groups (one-way random effects)."""
    from scipy.special import fdtri

    taken = [np.asarray(group, dtype=np.float64) for group in groups]
    sizes = np.array([x.size for x in taken])
    total, number = int(sizes.sum()), len(taken)
    whole = float(np.concatenate(taken).mean())
    outer = sum(x.size * (float(x.mean()) - whole) ** 2 for x in taken) / (number - 1)
    inner = sum((x.size - 1) * _deviation(x) ** 2 for x in taken if x.size > 1) / (total - number)
    size = (total - float((sizes**2).sum()) / total) / (number - 1)
    between = max(outer - inner, 0.0) / size
    if not outer and not inner:
        return Components(0.0, 0.0, math.nan, math.nan, math.nan, number, total)
    ends = []
    for tail in ((1 + LEVEL) / 2, (1 - LEVEL) / 2):
        ratio = _ratio(outer, inner) / float(fdtri(number - 1, total - number, tail))
        share = 1.0 if math.isinf(ratio) else (ratio - 1) / (ratio + size - 1)
        ends.append(min(max(share, 0.0), 1.0))
    share, (low, high) = between / (between + inner), ends
    return Components(math.sqrt(between), math.sqrt(inner), share, low, high, number, total)


def prediction_half_width(values: ArrayLike) -> float:
    """Return the half-width of the interval about the true mean for one measurement."""
    x = np.asarray(values, dtype=np.float64)
    return student(x.size - 1) * _deviation(x)


def parts_interval(levels: Mapping[int, ArrayLike]) -> WholeError:
    """Return the uncertainty of the value of a map, from the scatter of its equal parts."""
    many, few = (np.asarray(levels[n], dtype=np.float64) for n in (MIN_COUNT, MIN_COUNT // 2))
    variance = _deviation(many) ** 2 / many.size
    if 2 * MIN_COUNT not in levels:
        half = student(many.size - 1) * math.sqrt(variance)
        return WholeError(half, MIN_COUNT, many.size, math.nan, falls=False)
    small = np.asarray(levels[2 * MIN_COUNT], dtype=np.float64)
    variance += max(variance - _deviation(small) ** 2 / small.size, 0.0)
    half = student(many.size - 1) * math.sqrt(variance)
    ratio, minimum, maximum = variance_scaling(many, small)
    falls = minimum <= ratio <= maximum
    if ratio > variance_scaling(many, small, 1 - 2 * _CHANCE_PROBABILITY)[2]:
        coarse = student(few.size - 1) * _deviation(few) / math.sqrt(few.size)
        if coarse > half:
            return WholeError(coarse, MIN_COUNT // 2, few.size, ratio, falls)
    return WholeError(half, MIN_COUNT, many.size, ratio, falls)


def deviation_range(count: int) -> tuple[float, float]:
    """Return the factors to the deviation of n values that enclose the true deviation."""
    from scipy.special import chdtri

    freedom = count - 1
    # `chdtri` uses the upper tail.
    tails = (1 - LEVEL) / 2, (1 + LEVEL) / 2
    low, high = (math.sqrt(freedom / float(chdtri(freedom, tail))) for tail in tails)
    return low, high


def variance_scaling(
    coarse: ArrayLike, fine: ArrayLike, level: float = LEVEL
) -> tuple[float, float, float]:
    """Return the variance of large parts over that expected from small ones, and its range."""
    from scipy.special import fdtri

    large, small = (np.asarray(x, dtype=np.float64) for x in (coarse, fine))
    ratio = _ratio(_deviation(large) ** 2 * small.size / large.size, _deviation(small) ** 2)
    ends = (
        float(fdtri(large.size - 1, small.size - 1, tail))
        for tail in ((1 - level) / 2, (1 + level) / 2)
    )
    low, high = ends
    return ratio, low, high


def _deviation(x: Array) -> float:
    # Exactly zero for equal values, independent of the rounding of their mean.
    return float((x - x[0]).std(ddof=1)) if x.size > 1 else math.nan


def _ratio(value: float, error: float) -> float:
    """Return an absolute value over its error; infinite for a zero error."""
    if error:
        return abs(value) / error
    return math.inf if value else 0.0


def student(freedom: float) -> float:
    """Return the half-width of the interval of confidence `LEVEL`, in standard deviations."""
    from scipy.special import stdtrit

    return float(stdtrit(freedom, (1 + LEVEL) / 2))
