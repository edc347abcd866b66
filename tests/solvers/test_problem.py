import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

from roughcontact.solvers.problem import project, shift_to_sum

EPS = np.finfo(float).eps


@st.composite
def problems(draw, spread=1e3):
    """Values, limits and a total that can be met, at any scale."""
    n = draw(st.integers(1, 300))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    kind = draw(st.sampled_from(["normal", "ties", "equal", "wide", "ramp"]))
    width = draw(st.floats(0.01, spread))
    values = {
        "normal": rng.standard_normal(n),
        "ties": rng.integers(-2, 3, n) / 2.0,
        "equal": np.full(n, rng.standard_normal()),
        "wide": rng.standard_normal(n) * 10 ** rng.uniform(-6, 0, n),
        "ramp": np.linspace(-1, 1, n),
    }[kind] * width
    which = draw(st.sampled_from(["scalar", "map", "none", "some"]))
    if which == "scalar":
        limit = 1.0
    elif which == "none":
        limit = math.inf
    else:
        limit = 10 ** rng.uniform(-1, 1, n)
        if which == "some":
            limit[rng.random(n) < 0.5] = math.inf
    capacity = float(np.broadcast_to(limit, n).sum())
    part = draw(st.one_of(st.floats(0, 1), st.sampled_from([0.0, 1.0, 0.01, 0.5, 0.99, 0.999])))
    total = part * (capacity if math.isfinite(capacity) else n)
    scale = 10.0 ** draw(st.integers(-20, 20))
    return values * scale, np.multiply(limit, scale)[()], total * scale, scale


def assert_projection(values, limit, total, scale):
    found = project(values, limit, total)
    limits = np.broadcast_to(limit, values.shape)
    assert found.shape == values.shape
    assert (found >= 0).all()
    assert (found <= limits).all()
    # The shift carries the rounding of the largest value, and n of them are summed.
    rounding = 4 * EPS * values.size * float(np.abs(values).max())
    assert abs(math.fsum(found) - total) <= 1e-12 * total + rounding
    # Optimality: one multiplier λ, with p - v = λ between the bounds, ≥ λ at zero, ≤ λ at the
    # limit.
    moved = found - values
    empty, full = found <= 0, found >= limits
    between = ~empty & ~full
    low = np.max(moved[full & ~empty], initial=-math.inf)
    high = np.min(moved[empty & ~full], initial=math.inf)
    slack = 8 * EPS * (float(np.abs(values).max()) + float(found.max()) + total)
    if between.any():
        assert np.ptp(moved[between]) <= slack
        low = max(low, float(moved[between].max()))
        high = min(high, float(moved[between].min()))
    assert low <= high + slack
    return found


@given(problems())
def test_projection_is_admissible_and_optimal(problem):
    assert_projection(*problem)


@given(problems(spread=1e9))
def test_projection_of_values_far_beyond_the_limit(problem):
    # Gap over K₀₀ on a steep map under a low ceiling: the values dwarf the limit.
    assert_projection(*problem)


@given(problems())
def test_the_shift_makes_the_sum(problem):
    values, limit, total, _ = problem
    shift = shift_to_sum(values, limit, total)
    assert math.isfinite(shift)
    rounding = 4 * EPS * values.size * float(np.abs(values).max())
    assert abs(math.fsum(np.clip(values + shift, 0, limit)) - total) <= 1e-12 * total + rounding


@pytest.mark.parametrize("limit", [2.0, np.array([1.0, 2.0, 4.0])])
def test_total_zero_and_full_capacity_are_exact(limit):
    values = np.array([-1.0, 0.5, 3.0])
    np.testing.assert_array_equal(project(values, limit, 0.0), 0)
    limits = np.broadcast_to(limit, 3)
    np.testing.assert_array_equal(project(values, limit, float(limits.sum())), limits)


def test_equal_values_share_equally():
    np.testing.assert_array_equal(project(np.full(4, 7.0), 1.0, 2.0), 0.5)
    np.testing.assert_array_equal(project(np.full(4, -7.0), math.inf, 2.0), 0.5)


def test_bounds_are_met_exactly():
    found = project(np.array([-3.0, 0.2, 0.3, 9.0]), 1.0, 1.5)
    assert found[0] == 0
    assert found[3] == 1
    np.testing.assert_allclose(found[1:3], [0.2, 0.3], atol=1e-15)


@pytest.mark.parametrize("total", [0.5, 99.5, 250.5, 499.5, 499.9999])
@pytest.mark.parametrize("width", [1.0, 1e3, 1e5, 1e8])
def test_values_spread_wider_than_the_limit(total, width):
    # One value after another comes to its limit: Newton's method alone goes one at a time.
    values = np.linspace(-width, width, 500)
    found = assert_projection(values, 1.0, total, 1.0)
    assert (np.diff(found) >= 0).all()
    assert np.count_nonzero(found) >= total


def test_many_values_far_apart():
    # A walk from one value to the next would take 200 000 steps, or end early.
    values = np.linspace(-1e9, 1e9, 200_000)
    found = project(values, 1.0, 30_000.25)
    # 1e-6: the shift is about 1e9 and rounds to 1e-7.
    assert found.sum() == pytest.approx(30_000.25, abs=1e-6)


@pytest.mark.parametrize("limit", [math.inf, 1e3])
@pytest.mark.parametrize("total", [1e-200, 1e-3, 1.0, 500.0])
def test_values_that_dwarf_the_total(limit, total):
    # One rounding of the largest is more than the total: a single shift would leave nothing.
    values = np.array([1e22, 2e22, -1e22, 2e22 - 1e7, -3.0])
    np.testing.assert_array_equal(project(values, limit, total), [0, total, 0, 0, 0])
    np.testing.assert_array_equal(project(-values, limit, total), [0, 0, total, 0, 0])


def test_remainder_of_tiny_limit_moves_to_next_value():
    found = project(np.array([-1.0, -0.5, 1e10]), np.array([1.0, 1.0, 1e-30]), 1e-20)
    np.testing.assert_array_equal(found, [0, 1e-20 - 1e-30, 1e-30])
