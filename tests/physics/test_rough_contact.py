"""Rough maps against the laws of light loads and against Persson's theory."""

import math

import numpy as np
import pytest

import roughcontact as rc
from roughcontact import loading

STEEL = rc.Material(210e9, 0.3, 1e9)


@pytest.fixture(scope="module")
def curve() -> rc.LoadCurve:
    surface = rc.Surface(*rc.reference_map(512))
    loads = loading.spaced(0.03, 30, 13)
    return rc.load_curve(surface, material=STEEL, loads=loads, ceiling=None)


def test_area_grows_with_the_load_over_three_decades(curve: rc.LoadCurve) -> None:
    assert (np.diff(curve.column("contact_area")) > 0).all()
    assert (np.diff(curve.column("approach")) > 0).all()
    assert (np.diff(curve.column("mean_gap")) < 0).all()
    assert max(curve.column("certificate")) <= 1e-6


def test_light_loads_touch_in_proportion(curve: rc.LoadCurve) -> None:
    # Boundary elements in the literature: 1.8 to 2.3 (Hyun et al. 2004); 2.16 measured here.
    assert 1.6 < curve.low_load_slope < 2.3


def test_area_lies_between_persson_and_bush_gibson_thomas(curve: rc.LoadCurve) -> None:
    area, load = curve.column("corrected_contact_area"), curve.column("load")
    many = curve.column("spots") >= 20
    assert many.sum() >= 5
    persson, _ = curve.persson
    steepest = math.sqrt(2 * math.pi) * load / (curve.contact_modulus * curve.rms_gradient)
    assert (area[many] > persson[many]).all()
    assert (area[many] < steepest[many]).all()


def test_stiffness_is_in_proportion_to_the_load_and_ends_at_that_of_the_map(
    curve: rc.LoadCurve,
) -> None:
    # A square of side 2s pressed as a whole is at least as stiff as its inscribed circle, 2 E* s,
    # and at most as its circumscribed one.
    side = math.sqrt(curve.nominal_area)
    stiffness = curve.column("stiffness")
    assert (np.diff(stiffness) > 0).all()
    assert stiffness[-1] < math.sqrt(2) * curve.contact_modulus * side


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_a_low_ceiling_carries_the_load_on_the_area_that_it_needs(boundary: str) -> None:
    surface = rc.Surface(*rc.reference_map(128))
    for ceiling in (3e9, 1e9, 3e8):
        result = rc.solve(surface, load=1.0, material=STEEL, ceiling=ceiling, boundary=boundary)
        # Persson's limit of rough bodies under a ceiling: p̄/p_lim, from above.
        least = 1.0 / ceiling
        assert least <= result.contact_area <= 1.35 * least
    assert result.contact_area == pytest.approx(least, rel=0.03)
