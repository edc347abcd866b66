"""Distributions of given skewness and kurtosis."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy import stats

from roughcontact.errors import InputError
from roughcontact.theory import height_distribution

Z = np.linspace(-9, 9, 20001)
DENSITY = np.exp(-(Z**2) / 2) / np.exp(-(Z**2) / 2).sum()


@settings(max_examples=40, deadline=None)
@given(skewness=st.floats(-3, 3), excess=st.floats(0.35, 12))
def test_the_translation_has_the_moments_and_rises(skewness: float, excess: float) -> None:
    kurtosis = skewness**2 + 1 + excess
    found = height_distribution.fit_johnson(skewness, kurtosis)
    heights = found.heights(Z)
    assert np.all(np.diff(heights) >= 0)
    # Beyond nine standard deviations lies less than the tolerance of these tails.
    assert height_distribution.moments(heights, DENSITY) == pytest.approx(
        (skewness, kurtosis), rel=4e-3, abs=4e-3
    )


@pytest.mark.parametrize(
    ("skewness", "kurtosis", "distribution"),
    [
        (0.0, 3.0, stats.norm()),
        # Close to the lognormal line, on either side of it.
        (1.0, 4.8293, stats.lognorm(1 / 3.18203814, scale=1.0)),
        (-1.2, 5.0, None),
    ],
)
def test_quantiles_are_those_of_the_known_distribution(
    skewness: float, kurtosis: float, distribution: stats.rv_frozen | None
) -> None:
    z = np.linspace(-3, 3, 7)
    found = height_distribution.fit_johnson(skewness, kurtosis)
    if distribution is None:
        # Of SciPy's own family, with the shapes found here.
        kinds = {"bounded": stats.johnsonsb, "unbounded": stats.johnsonsu}
        shapes = (found.gamma, found.delta)
        expected = -kinds[found.family](*shapes).ppf(stats.norm.cdf(-z))
    else:
        expected = distribution.ppf(stats.norm.cdf(z))
    heights = found.heights(z)
    # Johnson's families are known up to place and scale.
    slope, shift = np.polyfit(expected, heights, 1)
    np.testing.assert_allclose(slope * expected + shift, heights, rtol=1e-6, atol=1e-6)


def test_impossible_moments_raise_input_error() -> None:
    with pytest.raises(InputError, match=r"^Sku must exceed Ssk² \+ 1 = 5, as that of any"):
        height_distribution.require(2.0, 4.9)
    with pytest.raises(InputError, match=r"^Sku must be at least 5.3 with Ssk = 2, got 5.1: below"):
        height_distribution.require(2.0, 5.1)
    with pytest.raises(InputError, match="sum of two groove patterns"):
        height_distribution.require(1.0, 2.5, families=2)
    with pytest.raises(InputError, match="single points"):
        height_distribution.require(0.0, 70.0)
    with pytest.raises(InputError, match=r"^Ssk must be finite"):
        height_distribution.require(float("nan"), 3.0)
    height_distribution.require(1.0, 3.2, families=2)
