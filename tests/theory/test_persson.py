import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, strategies as st

from roughcontact.errors import InputError
from roughcontact.theory import persson


def diffused(mean: float, deviation: float, ceiling: float) -> tuple[float, float]:
    """Persson's diffusion by implicit finite differences: surviving and yielded shares."""
    n, steps = 800, 800
    p = np.linspace(0, ceiling, n + 1)
    # Started from the Green function of a free line at a tenth of a bound's distance.
    start = (0.15 * min(mean, ceiling - mean)) ** 2
    density = np.exp(-((p - mean) ** 2) / (2 * start)) / np.sqrt(2 * np.pi * start)
    step = (deviation**2 - start) / steps
    ratio = step / (2 * (ceiling / n) ** 2)
    lower = np.full(n - 1, -ratio / 2)
    bands = np.vstack([lower, np.full(n - 1, 1 + ratio), lower])
    inside, yielded = density[1:-1].copy(), 0.0
    for _ in range(steps):
        old = inside[-1]
        right = inside * (1 - ratio)
        right[1:] += ratio / 2 * inside[:-1]
        right[:-1] += ratio / 2 * inside[1:]
        inside = scipy.linalg.solve_banded((1, 1), bands, right)
        yielded += step / 2 * (old + inside[-1]) / 2 / (ceiling / n)
    return float(inside.sum() * ceiling / n), yielded


@pytest.mark.parametrize("mean", [0.5, 1.5, 2.6])
def test_persson_with_a_ceiling_is_the_diffusion_between_two_absorbers(mean: float) -> None:
    survived, yielded = diffused(mean, 1.1, 3.0)
    contact, saturated = persson.persson_fractions(mean, 2.2, 1.0, 3.0)
    # The finite differences are of second order in 1/800.
    assert saturated == pytest.approx(yielded, abs=2e-4)
    assert contact == pytest.approx(survived + yielded, abs=2e-4)


def test_persson_far_below_the_ceiling_is_elastic() -> None:
    elastic, none = persson.persson_fractions(2e6, 1e9, 0.02)
    contact, saturated = persson.persson_fractions(2e6, 1e9, 0.02, ceiling=1e9)
    assert none == 0
    assert contact == pytest.approx(elastic, rel=1e-12)
    assert saturated == pytest.approx(0, abs=1e-12)


@given(st.floats(1e-6, 1), st.floats(0.01, 100))
def test_persson_fractions_are_ordered(share: float, roughness: float) -> None:
    contact, saturated = persson.persson_fractions(share, roughness, 1.0, 1.0)
    assert 0 <= saturated <= contact <= 1
    # The area that carries the load at the ceiling cannot be smaller than this.
    assert contact >= share * (1 - 1e-9)


def test_persson_refuses_more_than_the_ceiling() -> None:
    with pytest.raises(
        InputError, match="mean_pressure = 2e-06 MPa exceeds the ceiling of 1e-06 MPa"
    ):
        persson.persson_fractions(2.0, 1.0, 1.0, 1.0)
