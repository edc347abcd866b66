"""Zeros and crossings of functions, the zeros compared with SciPy's."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable

import pytest
from hypothesis import example, given, settings, strategies as st
from scipy import optimize

from roughcontact._tools.roots import NotPassedError, bracket_crossing, brentq

SHAPES: tuple[Callable[[float], float], ...] = (
    lambda x: x,
    lambda x: x**3,
    lambda x: math.expm1(min(x, 600.0)),
    lambda x: math.tanh(50 * x),
    lambda x: math.copysign(1.0, x),
    lambda x: math.copysign(abs(x) ** 0.2, x),
    lambda x: math.sin(x) + 2 * x,
)


@pytest.mark.long
@given(
    shape=st.sampled_from(SHAPES),
    zero=st.floats(-5, 5),
    sides=st.tuples(st.floats(1e-6, 1e3), st.floats(1e-6, 1e3)),
    height=st.floats(1e-12, 1e12),
    accuracy=st.sampled_from(({}, {"rtol": 1e-12}, {"xtol": 1e-15, "rtol": 1e-15}, {"xtol": 1e-6})),
)
@settings(max_examples=300, deadline=None)
def test_steps_match_scipy(
    shape: Callable[[float], float],
    zero: float,
    sides: tuple[float, float],
    height: float,
    accuracy: dict[str, float],
) -> None:
    seen: list[list[float]] = [[], []]

    def watched(places: list[float]) -> Callable[[float], float]:
        def function(x: float) -> float:
            places.append(x)
            return height * shape(x - zero)

        return function

    ends = zero - sides[0], zero + sides[1]
    found: list[float | None] = [None, None]
    for number, finder in enumerate((brentq, optimize.brentq)):
        # Steep roots and jumps take more steps than either has.
        with contextlib.suppress(RuntimeError):
            found[number] = finder(watched(seen[number]), *ends, **accuracy)
    assert found[0] == found[1]
    assert seen[0] == seen[1]


def test_end_of_interval_can_be_root() -> None:
    assert brentq(lambda x: x - 1, 1.0, 2.0) == 1.0
    assert brentq(lambda x: x - 2, 1.0, 2.0) == 2.0


def test_function_without_root_raises_error() -> None:
    with pytest.raises(ValueError, match="one sign"):
        brentq(lambda x: x, 1.0, 2.0)
    with pytest.raises(ValueError, match="NaN at 2"):
        brentq(lambda x: math.nan if x == 2 else -x, 1.0, 2.0)
    with pytest.raises(RuntimeError, match="in 100 steps"):
        brentq(lambda x: math.copysign(1.0, x - math.pi), 0.0, 1e300, xtol=1e-300)


@settings(max_examples=60, deadline=None)
@given(
    root=st.floats(-20, 20),
    first=st.floats(-20, 20),
    power=st.floats(0.2, 3),
    tread=st.sampled_from([0.0, 1e-3, 0.1]),
)
@example(root=0.0, first=1.0, power=0.5, tread=0.1)
def test_crossing_of_curve_and_step_function_is_found(
    root: float, first: float, power: float, tread: float
) -> None:
    def excess(x: float) -> float:
        x = tread * math.floor(x / tread) if tread else x
        looked.append(x)
        return power * (x - root) + 0.1 * math.atan(x - root)

    looked: list[float] = []
    low, high = bracket_crossing(excess, first, (-25, 25), accuracy=1e-6)
    assert excess(low[0]) < 0 <= excess(high[0])
    assert max(-low[1], high[1]) <= 1e-6 or high[0] - low[0] <= 1e-6
    assert len(looked) < 60


def test_a_curve_that_never_passes_ends_at_the_end() -> None:
    for sign, end in ((1, -9.0), (-1, 9.0)):
        with pytest.raises(NotPassedError) as caught:
            bracket_crossing(lambda x, s=sign: s * 0.5, 0.0, (-9, 9), accuracy=1e-6)
        assert caught.value.end == (end, sign * 0.5)
