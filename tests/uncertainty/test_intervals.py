"""How sure the headline numbers are: what each cause is said to move, and that it does."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

import ceiling_error
import intervals as benchmark
import roughcontact as rc
from roughcontact.analyses.solve.uncertainty_report import uncertainty_rows
from roughcontact.contact import plausibility
from roughcontact.contact.ceiling import area_change
from roughcontact.contact.result import CalibratedCeiling, Regime
from roughcontact.surface import shapes
from roughcontact.theory import hertz, indenters
from roughcontact.uncertainty.intervals import (
    _ONE_SPHERE,
    Cause,
    ErrorSource,
    Interval,
    joint_interval,
    uncertainty_intervals,
)
from roughcontact.uncertainty.resolution import limits

STORED = json.loads(Path(ceiling_error.STORED).read_text(encoding="utf-8"))
STEEL = rc.Material(210e9, 0.3, 1e9)
Y, X = np.mgrid[-32:32, -32:32] * 3e-6
BALL = rc.Surface(-(X**2 + Y**2) / (2 * 1e-3), (3e-6, 3e-6))


def interval(result, name="contact_fraction", study=None):
    (found,) = (one for one in uncertainty_intervals(result, study) if one.name == name)
    return found


def causes(one):
    return {doubt.cause: doubt for doubt in one.doubts}


def with_plasticity(row):
    """Relative change of the area under three yield strengths to that of the volume model."""
    errors = row["errors"]["contact_area"]
    three = ceiling_error.FACTORS.index(3.0) if len(errors) > 1 else 0
    return 1 / (1 + errors[three]) - 1


@pytest.mark.parametrize("kind", ["spheres", "maps"])
def test_interval_covers_volume_model(kind):
    # Each stored case was followed with plasticity of the volume.
    within = 0
    for row in STORED[kind]:
        law, found = ceiling_error.LAWS[row["law"]], row["calibrated"]
        strength = float(law.strength(np.array(0.0)))
        flow = float(law.strength(np.array(0.15 * found["slope"])))
        advice = CalibratedCeiling(
            found["load_ratio"],
            found["slope"],
            flow,
            1.615 * flow,
            found["factor"] * strength,
            found["factor"],
        )
        modulus = ceiling_error.YOUNG / (1 - ceiling_error.POISSON**2)
        change = area_change(advice, 3 * strength, modulus)
        error = plausibility.SHOWN_ROUGH if kind == "maps" else plausibility.SHOWN_SPHERE
        if row["law"] != "perfect":
            error = plausibility.SHOWN_HARDENING
        error += _ONE_SPHERE
        within += abs(with_plasticity(row) - change) <= error * (1 + change)
    assert within >= 0.95 * len(STORED[kind])


def test_contact_below_first_yield_has_no_yield_cause():
    result = rc.solve(BALL, material=STEEL, load=0.2)
    assert result.regime is Regime.BELOW_FIRST_YIELD
    assert set(causes(interval(result))) == {Cause.RIM, Cause.GRID, Cause.TOLERANCE}


def test_interval_beyond_first_yield_extends_to_larger_area():
    # P/P_c is 40 for about 16 N here: a quarter of the area is missing at three yield strengths.
    result = rc.solve(BALL, material=STEEL, load=12)
    doubt = causes(interval(result))[Cause.YIELDING]
    assert doubt.low == 0
    assert 0.2 < doubt.high < 0.5
    recommended = rc.solve(BALL, material=STEEL, load=12, ceiling="calibrated")
    area = recommended.contact_fraction
    assert interval(result).low < area < interval(result).high
    again = causes(interval(recommended))[Cause.YIELDING]
    assert -0.08 < again.low < 0 < again.high < 0.08
    without = causes(interval(rc.solve(BALL, material=STEEL, load=12, ceiling=None)))
    assert without[Cause.YIELDING].high > doubt.high


@pytest.mark.parametrize("load", [5e5, 7e5, 1.2e6])
@pytest.mark.parametrize("sq", [0.0, 0.4e-6])
def test_interval_of_profile_contains_area_at_first_yield(load, sq):
    x = (np.arange(1024) - 511.5) * 1e-6
    waves = np.random.default_rng(3).normal(size=40) * np.arange(1, 41) ** -1.5
    rough = np.sin(2 * np.pi * np.outer(np.arange(1, 41), x) / 200e-6 + waves[:, None]).T @ waves
    trace = rc.Surface(sq * rough / np.std(rough) - x**2 / 2e-2, 1e-6)
    contact, lower = (
        rc.solve(trace, material=STEEL, load=load, ceiling=ceiling, boundary="periodic-y")
        for ceiling in ("auto", STEEL.line_yield_pressure)
    )
    doubt = causes(interval(contact))[Cause.YIELDING]
    assert doubt.low == 0
    change = lower.contact_area / contact.contact_area - 1
    assert change <= doubt.high < 1.3 * change + 0.15
    hard = rc.Material(210e9, 0.3, 1e9, hardness=3.6e9)
    known = causes(interval(rc.solve(trace, material=hard, load=load, boundary="periodic-y")))
    share = contact.saturated_fraction / contact.contact_fraction
    assert known[Cause.YIELDING].low == pytest.approx(-share / 6)


def test_interval_of_hardness_covers_strengths_from_a_third_of_it():
    surface, load = rc.Surface(*rc.reference_map(128)), "100 MPa"
    given = {"load": load, "boundary": "periodic"}
    brittle = rc.solve(surface, material=rc.Material(160e9, 0.22, hardness=6e9), **given)
    found = interval(brittle)
    assert found.low < brittle.contact_fraction < found.high
    metal = rc.solve(surface, material=rc.Material(160e9, 0.22, 2e9), ceiling="calibrated", **given)
    assert found.low < metal.contact_fraction < found.high


def test_excess_over_first_yield_bounds_area_of_a_sphere():
    for ratio in (1.02, 1.2, 1.6, 3.0, 10.0):
        # Hertz contact of peak pressure ratio under a ceiling of 1, with E* and R of 1.
        elastic = ratio * math.pi / 2
        load = 4 / 3 * elastic**3
        radius = brentq(
            lambda a, load=load: math.pi * a**2 * indenters.mean_under_ceiling(a) - load,
            elastic,
            10 * elastic,
        )
        r = (np.arange(2000) + 0.5) / 2000 * elastic
        excess = np.maximum(ratio * np.sqrt(1 - (r / elastic) ** 2) - 1, 0)
        bound = float((excess * 2 * np.pi * r).sum()) * elastic / 2000
        assert math.pi * (radius**2 - elastic**2) <= bound * 1.001


def test_unknown_causes_are_reported():
    result = rc.solve(BALL, material=STEEL, load=12)
    assert interval(result, "approach").unknown == (Cause.YIELDING, Cause.GRID)
    auxetic = rc.Material(210e9, -0.2, 1e9)
    odd = interval(rc.solve(BALL, material=auxetic, load=12))
    assert math.isnan(causes(odd)[Cause.YIELDING].low)
    limits = np.where(X < 0, 3e9, 2e9)
    by_pixel = rc.solve(BALL, material=STEEL, load=12, ceiling=limits)
    assert Cause.YIELDING in interval(by_pixel).unknown


def test_rows_name_number_ends_and_causes():
    result = rc.solve(BALL, material=STEEL, load=12)
    rows = {name: (ends, why) for name, ends, why in uncertainty_rows(result)}
    ends, why = rows["real contact"]
    assert " to " in ends
    assert "spot perimeter −" in why
    assert "ceiling +" in why
    assert "pixel not studied" in why
    assert "ceiling and pixel not studied" in rows["approach"][1]


def solve_with_study(surface, load, **options):
    given = {"material": STEEL, "load": load, "ceiling": None, **options}
    return rc.solve(surface, **given), rc.resolution_study(surface, **given)


@pytest.mark.parametrize("load", [0.02, 0.2, 3.0])
def test_interval_of_study_covers_hertz(load):
    pixel, radius = 1e-6, 0.01
    ball = rc.Surface(shapes.paraboloid((128, 128), (pixel, pixel), radius), (pixel, pixel))
    result, study = solve_with_study(ball, load)
    modulus = STEEL.young / 0.91
    reach = hertz.contact_radius(load, radius, modulus)
    exact = {
        "contact_fraction": math.pi * reach**2 / (128 * pixel) ** 2,
        "max_pressure": hertz.max_pressure(load, radius, modulus),
        "approach": reach**2 / radius,
    }
    for name, value in exact.items():
        answer = interval(result, name, study)
        assert answer.low <= value <= answer.high < 1.4 * answer.low
        # The contribution of the rim is an error of the grid.
        assert set(causes(answer)) <= {Cause.GRID, Cause.WAVES, Cause.TOLERANCE}


@pytest.mark.long
def test_the_pressure_at_an_edge_has_no_limit():
    # A ball that the edge of the map cuts: the peak in the middle hides that of the edge.
    pixel = 2e-6
    y, x = (np.mgrid[:128, :128] + 0.5) * pixel
    ball = rc.Surface(-((x - 40e-6) ** 2 + (y - 128e-6) ** 2) / 0.02, (pixel, pixel))
    result, study = solve_with_study(ball, 2.0)
    # From the pixel of the map to half of it it hardly changes.
    assert abs(study.changes("max_pressure")[-1]) < 0.05
    assert not study.independent("max_pressure")
    assert not any("Independent" in s and "maximum pressure" in s for s in study.sentences)
    assert study.summary()["independent"]["max_pressure"] is False
    for found in (None, study):
        value = interval(result, "max_pressure", found)
        assert causes(value)[Cause.EDGE].high == value.high == math.inf
    # A ceiling is a limit, and so is a period.
    limited = rc.solve(ball, material=STEEL, load=2.0, ceiling=3e9)
    assert Cause.EDGE not in causes(interval(limited, "max_pressure"))
    assert not rc.resolution_study(ball, material=STEEL, load=2.0, ceiling=3e9).at_edge
    periodic = rc.solve(ball, material=STEEL, load=2.0, ceiling=None, boundary="periodic")
    assert Cause.EDGE not in causes(interval(periodic, "max_pressure"))
    rows = {name: (ends, why) for name, ends, why in uncertainty_rows(result, study)}
    assert rows["largest pressure"][0].endswith("no interval")


def test_the_edge_of_a_punch_within_the_map_has_no_limit():
    y, x = np.mgrid[-64:64, -64:64] + 0.5
    punch = rc.Surface(np.where(np.hypot(x, y) < 20, 0.0, np.nan), (1e-6, 1e-6)).masked()
    result, study = solve_with_study(punch, 0.1)
    value = interval(result, "max_pressure", study)
    assert causes(value)[Cause.GRID].high == math.inf
    assert not study.independent("max_pressure")
    assert interval(result, "approach", study).high < 1.1 * result.approach


def test_a_map_rough_down_to_its_pixel_has_no_last_area():
    rng = np.random.default_rng(3)
    rough = rc.Surface(rng.normal(scale=5e-9, size=(64, 64)), (1e-6, 1e-6))
    result, study = solve_with_study(rough, 0.05, boundary="periodic")
    assert Cause.WAVES in interval(result, "contact_fraction", study).unknown
    assert Cause.WAVES not in interval(result, "mean_gap", study).unknown
    smooth, study = solve_with_study(BALL, 0.2)
    assert interval(smooth, "contact_fraction", study).unknown == ()


def test_pressure_interval_ends_at_ceiling():
    result, study = solve_with_study(BALL, 4.0, ceiling=3e9)
    value = interval(result, "max_pressure", study)
    assert value.value <= value.high <= 3e9 * (1 + 1e-5)


@pytest.mark.parametrize("order", [0.5, 0.7, 1.0, 1.5, 2.0])
def test_limits_cover_limit_of_sequence(order):
    for sign in (1, -1):
        values = [7 + sign * 2.0 ** (-order * n) for n in range(4)]
        low, high = limits(values)
        assert low <= 7 <= high
        # The first order is not left behind by a lower one.
        assert high - low < 4 * abs(values[-1] - values[-2]) / (2 ** min(order, 1) - 1)
        assert limits(values[1:]) == (low, high)


def test_sequence_that_does_not_converge_has_no_limit():
    assert limits([2.0 ** (n / 2) for n in range(4)]) == (-math.inf, math.inf)
    assert limits([1.0, 2.0, 3.0, 4.0]) == (-math.inf, math.inf)
    assert all(map(math.isnan, limits([1.0, 1.1])))
    assert all(map(math.isnan, limits([1.0, math.inf, 1.1])))
    assert limits([2.0, 2.0, 2.0]) == (2.0, 2.0)
    # Two grids that agree by chance: the change before them counts.
    low, high = limits([2.0, 1.6, 1.5999, 1.5])
    assert low < 1.3 < 1.6 < high
    # A change of sign: to either side.
    assert limits([1.0, 1.4, 1.3]) == pytest.approx((0.92, 1.68))


@pytest.mark.long
def test_intervals_cover_finer_grids():
    held = []
    for number in range(4):
        case = benchmark.draw_case(number, 64, 4)
        right = benchmark.truth(case, 64, 4)
        result = benchmark.intervals_of_map(case, 64)
        held += [one.low <= right[name] <= one.high for name, one in result.items()]
    assert len(held) >= 16
    assert np.mean(held) >= 0.9


def test_a_body_that_hardens_has_its_calibrated_area_in_the_interval():
    iron = rc.Material(210e9, 0.3, 1e9, hardness=5e9)
    result = rc.solve(BALL, material=iron, load=25)
    value, other = interval(result), result.calibrated
    assert other is not None
    assert other.differs
    assert value.low <= other.contact_fraction <= value.high


def test_interval_of_merging_spots_uses_solved_change():
    rough = rc.Surface(*rc.reference_map(64))
    result = rc.solve(rough, material=STEEL, load="0.5 GPa", boundary="periodic")
    solved = result.calibrated.contact_area / result.contact_area - 1
    advice = plausibility.recommended_ceiling_of(result)
    assert abs(solved - plausibility.calibrated_area_change(result, advice)) > 0.03
    error = plausibility.shown_error(result) + _ONE_SPHERE
    doubt = causes(interval(result))[Cause.YIELDING]
    assert doubt.high == pytest.approx(solved + error * (1 + solved))


def test_large_changes_multiply_instead_of_adding():
    # Of a map of noise: the rim takes a third, twice the pixel to the pixel nine tenths.
    result = Interval(
        "contact_fraction",
        0.256,
        (ErrorSource(Cause.RIM, -0.33, 0.0), ErrorSource(Cause.GRID, -0.93, 0.0)),
    )
    assert result.low == pytest.approx(0.256 * 0.67 * 0.07)


def test_nearly_full_contact_has_shares_up_to_one_and_no_interval_of_a_closed_gap():
    surface = rc.Surface(*rc.reference_map(64))
    given = {"material": STEEL, "boundary": "periodic"}
    nearly = rc.solve(surface, load="2.95 GPa", calibrated=False, **given)
    assert nearly.contact_fraction > 0.95
    found = interval(nearly)
    assert nearly.contact_fraction < found.high <= 1
    assert found.value * (1 + max(doubt.high for doubt in found.doubts if doubt.known)) <= 1 + 1e-9
    full = rc.solve(surface, load="2.99999 GPa", calibrated=False, **given)
    study = rc.resolution_study(surface, load="2.99999 GPa", **given)
    assert full.mean_gap < 1e-12
    assert "mean_gap" not in [one.name for one in uncertainty_intervals(full, study)]


def test_joint_interval_matches_area_interval_at_equal_change():
    surface = rc.Surface(*rc.reference_map(128))
    contact = rc.solve(surface, material=STEEL, load=1.0, boundary="periodic", calibrated=False)
    change = causes(interval(contact))[Cause.YIELDING].high / 1.11 - 0.11 / 1.11
    alike = joint_interval("length", 1.0, contact, math.nan, (change, change))
    assert causes(alike)[Cause.YIELDING] == causes(interval(contact))[Cause.YIELDING]
    # Half the change has half the error of the rule; two grids count three times.
    half = (1 + change) ** 0.5 - 1
    rooted = joint_interval("length", 1.0, contact, -0.02, (half, change))
    assert rooted.high == pytest.approx((half + (1 + half) * 0.055 + 1) * 1.06)
    assert rooted.doubts[1] == ErrorSource(Cause.GRID, -0.06, 0.06)
    unknown = joint_interval("length", 1.0, contact, 0.01, (math.nan, math.nan))
    assert unknown.unknown == (Cause.YIELDING,)


def test_joint_of_much_contact_has_the_bounds_of_its_area():
    # Above 30 % contact the calibrated ceiling of a metal that hardens was not tested.
    contact = rc.solve(
        rc.Surface(*rc.reference_map(64)),
        material="Cu-ETP",
        load="220 MPa",
        boundary="periodic",
        calibrated=False,
    )
    assert contact.contact_fraction > 0.3
    area = causes(interval(contact))[Cause.YIELDING]
    alike = causes(joint_interval("length", 1.0, contact, 0.0, (-0.2, -0.2)))[Cause.YIELDING]
    assert (alike.low, alike.high) == pytest.approx((min(area.low, -0.2), area.high))
    falls = causes(joint_interval("gap", 1.0, contact, 0.0, (0.25, -0.2)))[Cause.YIELDING]
    assert falls.low == pytest.approx(1 / (1 + area.high) - 1)


def test_elastic_pressure_above_the_strength_of_a_base_leaves_no_interval():
    film = rc.Layer(200e9, 0.3, 2e-6, hardness="20 GPa", name="film")
    terms = {
        "material": rc.Material(210e9, 0.3, 1e9, coating=[film]),
        "boundary": "periodic",
        "ceiling": None,
    }
    surface = rc.Surface(*rc.reference_map(64))
    high = rc.solve(surface, load="100 MPa", **terms)
    assert high.max_pressure > 3e9
    assert Cause.YIELDING in interval(high).unknown
    low = rc.solve(rc.Surface(surface.heights / 100, surface.pixel), load="1 MPa", **terms)
    assert low.max_pressure < 3e9
    assert Cause.YIELDING not in interval(low).unknown
