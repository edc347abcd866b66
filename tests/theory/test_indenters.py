"""A sphere beyond first yield, between Hertz and full plasticity."""

from __future__ import annotations

import numpy as np
import pytest

from roughcontact.theory import hertz, indenters

RADIUS, MODULUS, LIMIT = 2e-3, 115e9, 3e9


def index_of(load: float) -> float:
    """Return E*a/(p R) of a Hertz contact."""
    return MODULUS * hertz.contact_radius(load, RADIUS, MODULUS) / (LIMIT * RADIUS)


@pytest.mark.parametrize("share", [0.05, 0.3, 0.7, 0.99])
def test_below_the_ceiling_it_is_hertz(share: float) -> None:
    # Two thirds of the peak.
    load = hertz.load_at_pressure(share * LIMIT, RADIUS, MODULUS)
    assert indenters.mean_under_ceiling(index_of(load)) == pytest.approx(2 / 3 * share)
    first_yield = 1.6
    assert indenters.mean_pressure(index_of(load), first_yield) == pytest.approx(2 / 3 * share)


def test_the_ceiling_is_reached_without_a_kink() -> None:
    first = np.pi / 2
    around = first * (1 + np.linspace(-1e-3, 1e-3, 5))
    values = np.array([indenters.mean_under_ceiling(index) for index in around])
    assert values[2] == pytest.approx(2 / 3)
    slopes = np.diff(values) / np.diff(around)
    np.testing.assert_allclose(slopes, 4 / (3 * np.pi), rtol=5e-3)


@pytest.mark.parametrize("mean", [indenters.mean_under_ceiling, indenters.mean_pressure])
def test_the_mean_pressure_rises_to_its_plateau(mean) -> None:
    values = [mean(index) for index in np.geomspace(0.1, 1e4, 60)]
    plateau = indenters.PLATEAU if mean is indenters.mean_pressure else 1.0
    assert (np.diff(values) >= 0).all()
    assert values[-1] == pytest.approx(plateau, rel=1e-3)
    assert max(values) <= plateau


def test_residual_indentation_starts_at_ceiling_and_grows_faster_than_load() -> None:
    assert indenters.residual_indentation(0.9) == (0.0, 0.0)
    assert max(indenters.residual_indentation(1 + 1e-9)) < 1e-3
    ratios = np.geomspace(1.2, 100, 20)
    left = np.array([indenters.residual_indentation(ratio) for ratio in ratios])
    assert (np.diff(left / ratios[:, None], axis=0) > 0).all()
    # Of the approach and the work of a fully saturated contact, which rise as λ and λ²: 1/3, 1/6.
    assert (left < np.stack([ratios / 3, ratios**2 / 6], axis=1)).all()
