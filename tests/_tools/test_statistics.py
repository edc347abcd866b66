"""Means, differences and shares of a scatter: intervals hold as often as they say."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats
from scipy.ndimage import gaussian_filter

from roughcontact._tools import statistics

GROUPS = 400
"""Synthetic groups over which intervals are counted."""


def is_coverage_near_95_percent(count: int, number: int = GROUPS) -> bool:
    """Return whether intervals of 95 % hold in 93 to 97 of a hundred cases."""
    return 0.93 <= count / number <= 0.97


@pytest.mark.long
def test_intervals_are_those_of_scipy() -> None:
    rng = np.random.default_rng(0)
    a, b, c = rng.normal(size=4), rng.normal(1, 2, size=6), rng.normal(2, 1, size=3)
    found = statistics.mean_with_interval(a)
    error = float(a.std(ddof=1)) / 2
    assert (found.low, found.high) == pytest.approx(stats.t.interval(0.95, 3, a.mean(), error))

    two = statistics.differences([a, b])[0, 1]
    welch = stats.ttest_ind(b, a, equal_var=False)
    assert two.p == pytest.approx(welch.pvalue)
    ends = welch.confidence_interval()
    assert (two.low, two.high) == pytest.approx((ends.low, ends.high))

    pairs = statistics.paired_difference(a, b[:4])
    student = stats.ttest_rel(b[:4], a)
    ends = student.confidence_interval()
    assert pairs.p == pytest.approx(student.pvalue)
    assert (pairs.low, pairs.high) == pytest.approx((ends.low, ends.high))

    three = statistics.differences([a, b, c])
    tukey = stats.tukey_hsd(a, b, c, equal_var=False)
    ends = tukey.confidence_interval()
    for (i, j), one in three.items():
        assert one.p == pytest.approx(tukey.pvalue[i, j])
        assert (one.low, one.high) == pytest.approx((-ends.high[i, j], -ends.low[i, j]))
        assert one.excludes_zero == (one.p < 0.05)


def test_several_p_are_corrected_as_in_the_literature() -> None:
    # Neuhaus et al. 1992, as in Benjamini and Hochberg 1995, section 4.1: three of 15 stay.
    p = [
        0.0001,
        0.0004,
        0.0019,
        0.0095,
        0.0201,
        0.0278,
        0.0298,
        0.0344,
        0.0459,
        0.3240,
        0.4262,
        0.5719,
        0.6528,
        0.7590,
        1.0,
    ]
    corrected = statistics.holm([*p[::-1], math.nan])
    assert corrected[14:10:-1] == pytest.approx([0.0015, 0.0056, 0.0247, 0.1140])
    assert np.count_nonzero(corrected < 0.05) == 3
    assert (corrected[0], math.isnan(corrected[15])) == (1.0, True)
    assert statistics.holm([0.04, 0.03, 0.01, 0.005]) == pytest.approx([0.06, 0.06, 0.03, 0.02])


def test_single_or_equal_values_have_no_interval() -> None:
    alone = statistics.mean_with_interval([2.0])
    assert alone.value == 2.0
    assert math.isnan(alone.low)
    alike = statistics.mean_with_interval([0.1] * 3)
    assert (alike.deviation, alike.low, alike.high) == (0.0, alike.value, alike.value)
    unknown = statistics.differences([[1.0], [2.0, 3.0]])[0, 1]
    assert unknown.value == 1.5
    assert not unknown.known
    assert not unknown.excludes_zero
    constant = statistics.differences([[1.0, 1.0], [2.0, 2.0]])[0, 1]
    assert (constant.low, constant.high, constant.excludes_zero) == (1.0, 1.0, True)
    same = statistics.differences([[1.0, 1.0], [1.0, 1.0]])[0, 1]
    assert (same.p, same.excludes_zero) == (1.0, False)
    assert not statistics.paired_difference([1.0], [2.0]).known
    assert math.isnan(statistics.components([[1.0, 1.0], [1.0, 1.0]]).share)
    assert statistics.components([[1.0, 1.0], [2.0, 2.0]]).share == 1.0


def test_intervals_of_means_and_differences_hold() -> None:
    rng = np.random.default_rng(1)
    means = pairs = differences = 0
    for _ in range(GROUPS):
        a, b = rng.normal(3, 1, size=4), rng.normal(5, 4, size=6)
        found = statistics.mean_with_interval(a)
        means += found.low <= 3 <= found.high
        apart = statistics.differences([a, b])[0, 1]
        differences += apart.low <= 2 <= apart.high
        common = rng.normal(0, 10, size=5)
        change = statistics.paired_difference(common, common + rng.normal(0.5, 1, size=5))
        pairs += change.low <= 0.5 <= change.high
    assert is_coverage_near_95_percent(means)
    assert is_coverage_near_95_percent(differences)
    assert is_coverage_near_95_percent(pairs)


def test_variance_components_match_generated_data() -> None:
    rng = np.random.default_rng(3)
    held_shares, between, within = 0, [], []
    for _ in range(GROUPS):
        groups = [level + rng.normal(0, 1, size=4) for level in rng.normal(0, 2, size=6)]
        found = statistics.components(groups)
        held_shares += found.low <= 0.8 <= found.high
        between.append(found.between**2)
        within.append(found.within**2)
    assert is_coverage_near_95_percent(held_shares)
    # Twice the standard error of the mean of 400 estimates.
    assert np.mean(between) == pytest.approx(4, rel=0.07)
    assert np.mean(within) == pytest.approx(1, rel=0.035)


# In pixels; parts have 16. Correlation has fallen to 1/e at twice the width.
@pytest.mark.parametrize("width", [0, 2, 6])
def test_error_of_whole_covers_correlated_parts(width: int) -> None:
    rng = np.random.default_rng(0)
    size, found, misses = 64, [], 0
    for _ in range(GROUPS):
        field = rng.normal(size=(size + 32, size + 32))
        field = gaussian_filter(field, width, mode="wrap")[:size, :size]
        levels = {
            n: field.reshape(n, size // n, n, size // n).mean((1, 3)).ravel() for n in (2, 4, 8)
        }
        found.append(statistics.parts_interval(levels))
        misses += abs(float(field.mean())) > found[-1].half
    assert is_coverage_near_95_percent(GROUPS - misses)
    falling = np.mean([one.falls for one in found])
    assert falling > 0.9 if width <= 2 else falling < 0.2


def test_interval_without_small_parts_uses_sixteen_parts() -> None:
    rng = np.random.default_rng(5)
    parts = rng.normal(size=16)
    found = statistics.parts_interval({2: rng.normal(size=4), 4: parts})
    assert found.half == pytest.approx(stats.t.ppf(0.975, 15) * parts.std(ddof=1) / 4)
    # Independence of the sixteen is not known.
    assert (found.parts, found.falls) == (16, False)
    assert math.isnan(found.scaling)


def test_interval_of_deviation_matches_chi_square() -> None:
    rng = np.random.default_rng(6)
    low, high = statistics.deviation_range(16)
    spreads = rng.normal(size=(GROUPS, 16)).std(axis=1, ddof=1)
    assert is_coverage_near_95_percent(
        int(np.count_nonzero((low * spreads <= 1) & (high * spreads >= 1)))
    )
