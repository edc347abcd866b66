"""Loads and heights of any size: solved alike, to the bit where the size is a power of two."""

import numpy as np
import pytest

import judge
import roughcontact as rc

STEEL = rc.Material(210e9, 0.3, yield_strength=1e9)


def rough(factor=1.0):
    rng = np.random.default_rng(3)
    return rc.Surface(1e-6 * factor * rng.standard_normal((70, 64)), (1e-6, 2e-6))


@pytest.mark.parametrize("boundary", ["free", "periodic", "periodic-x"])
@pytest.mark.parametrize("exponent", [-180, -100, 100, 180])
def test_heights_and_load_times_a_power_of_two(boundary, exponent):
    # Of single precision, that of the coarse grids, numbers end at 2^±128.
    options = {"material": STEEL, "ceiling": None, "boundary": boundary}
    factor = 2.0**exponent
    first = rc.solve(rough(), load=0.1, **options)
    other = rc.solve(rough(factor), load=0.1 * factor, **options)
    np.testing.assert_array_equal(other.pressure, factor * first.pressure)
    np.testing.assert_array_equal(other.gap, factor * first.gap)
    assert other.approach == factor * first.approach
    assert other.convolutions == first.convolutions


@pytest.mark.parametrize("load", [1e-100, 1e-30, 1e-18, 1e-9, 1e20, 1e100])
@pytest.mark.parametrize("boundary", ["free", "periodic", "periodic-x"])
def test_any_load(load, boundary):
    result = rc.solve(rough(), load=load, material=STEEL, ceiling=None, boundary=boundary)
    judge.assert_solved(result, load)
    if load < 1e-9:
        assert np.count_nonzero(result.contact) == 1


@pytest.mark.parametrize("approach", [1e-100, 1e-20, 1e20, 1e100])
def test_any_approach(approach):
    result = rc.solve(rough(), approach=approach, material=STEEL, ceiling=None)
    judge.assert_solved(result)


def test_a_ceiling_too_small_for_the_units_is_met():
    ceiling = np.full((70, 64), np.inf)
    ceiling[:, ::2] = 5e-324
    result = rc.solve(rough(2.0**60), load=1e-3 * 2.0**60, material=STEEL, ceiling=ceiling)
    judge.assert_solved(result, 1e-3 * 2.0**60)
    assert np.count_nonzero(result.saturated) > 0


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"load": 1e-300}, r"load = 1e-300 N is a mean pressure of .* Pa: too small"),
        ({"load": 1e300}, r"load = 1e\+300 N is a mean pressure of .* Pa: too large"),
        ({"approach": 1e-300}, "approach = 1e-300 m: too small"),
        ({"approach": 1e300}, r"approach = 1e\+300 m: too large"),
    ],
)
def test_values_whose_square_overflows_raise_input_error(options, words):
    with pytest.raises(rc.InputError, match=words):
        rc.solve(rough(), material=STEEL, ceiling=None, **options)
