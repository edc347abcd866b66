import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import roughcontact as rc
from roughcontact.analyses.history.model import history as load_history
from roughcontact.contact.ceiling import (
    CEILING_TOLERANCE,
    MAX_SOLVES,
    ceiling_factor,
    recommend_ceiling,
    recommended_ceiling,
)
from roughcontact.contact.plausibility import calibrated_area_change, recommended_ceiling_of
from roughcontact.contact.result import Regime
from roughcontact.errors import InputError
from roughcontact.material.hardening import Linear, Swift
from roughcontact.report import phrases, python_script
from roughcontact.report.kind import PROBLEM
from roughcontact.report.presentation import presentation_of
from roughcontact.surface import shapes
from roughcontact.surface.roughness import rms_gradient
from roughcontact.theory import hertz
from roughcontact.uncertainty.intervals import uncertainty_intervals

STEEL = rc.Material(210e9, 0.3, 1e9, "steel")
FLAT = rc.Surface(np.zeros((8, 8)), (1e-6, 1e-6))
MODULUS = rc.contact_modulus(STEEL, rc.RIGID)
RADIUS = 0.01


def sphere(
    ratio: float, material: rc.Material = STEEL, points: int = 64, **more
) -> rc.ContactResult:
    """Return a solved ball at a number of loads of first yield, its contact well resolved."""
    modulus = rc.contact_modulus(material, rc.RIGID)
    load = ratio * hertz.first_yield_load(RADIUS, modulus, material.first_yield_pressure)
    # Hertz's radius, or that of a disc under the ceiling of three yield strengths.
    plastic = math.sqrt(load / (math.pi * 3 * material.yield_strength))
    side = 3 * max(hertz.contact_radius(load, RADIUS, modulus), plastic)
    pixel = (side / points, side / points)
    surface = rc.Surface(shapes.paraboloid((points, points), pixel, RADIUS), pixel)
    return rc.solve(surface, material=material, load=load, **more)


# Factors that give the area of plasticity in the volume, by calibration/ceiling_error.py; the mean
# pressures of Kogut and Etsion 2002 are 1.96, 2.19, 2.42, 2.64 and 2.85 σ_Y at these loads.
@pytest.mark.parametrize(
    ("ratio", "factor"), [(12, 1.96), (40, 2.19), (120, 2.46), (300, 2.65), (700, 2.80)]
)
def test_the_factor_of_a_sphere(ratio: float, factor: float) -> None:
    assert ceiling_factor(ratio) == pytest.approx(factor, abs=0.04)
    advice = recommended_ceiling(sphere(ratio))
    # The load is read from slope and mean pressure: 20 pixels in a contact radius.
    assert advice.load_ratio == pytest.approx(ratio, rel=0.03)
    assert advice.factor == pytest.approx(factor, abs=0.04)
    assert advice.ceiling == advice.factor * STEEL.yield_strength
    assert advice.flow_stress == STEEL.yield_strength


@given(low=st.floats(1e-3, 1e5), step=st.floats(1, 1e3), poisson=st.floats(0, 0.5))
def test_the_factor_grows_with_the_load_between_its_bounds(
    low: float, step: float, poisson: float
) -> None:
    first = rc.Material(1.0, poisson, 1.0).first_yield_pressure
    factors = [ceiling_factor(ratio, first) for ratio in (low, low * step)]
    # Where Hertz's pressure ends the factor may stand still, and fall by a little.
    assert first * (1 - 1e-12) <= factors[0] <= factors[1] * (1 + 1e-3) <= 3 * (1 + 1e-3)


def test_a_tilted_map_and_a_second_ball_change_nothing() -> None:
    flat = sphere(40)
    heights, pixel = flat.surface.heights, flat.surface.pixel
    x = np.arange(heights.shape[1]) * pixel[1]
    more = {"material": STEEL, "load": flat.load}
    # A slope moves the summit of a paraboloid, here by five pixels.
    tilted = rc.solve(rc.Surface(heights + 5 * pixel[1] / RADIUS * x, pixel), **more)
    half = rc.Surface(heights / 2, pixel)
    shared = rc.solve(half, counter_surface=half, **more)
    expected = recommended_ceiling(flat)
    for other in (tilted, shared):
        advice = recommended_ceiling(other)
        assert advice.load_ratio == pytest.approx(expected.load_ratio, rel=1e-3)


def test_hardening_material_uses_flow_stress_at_contact_strain() -> None:
    linear = rc.Material(210e9, 0.3, hardening=Linear(1e9, 210e9 / 20))
    advice = recommended_ceiling(sphere(300, linear))
    assert advice.flow_stress == pytest.approx(1e9 + 210e9 / 20 * 0.15 * advice.slope)
    # P_c grows as the cube of the strength.
    again = 300 / (advice.flow_stress / 1e9) ** 3
    assert advice.load_ratio == pytest.approx(again, rel=0.03)
    assert advice.factor == pytest.approx(
        advice.flow_stress / 1e9 * ceiling_factor(advice.load_ratio), rel=1e-3
    )


@pytest.mark.parametrize(
    ("law", "ratio", "true"),
    [
        # Factors that give the area of plasticity in the volume, calibration/ceiling_error.py.
        (Linear(1e9, 210e9 / 50), 300, 2.90),
        (Linear(1e9, 210e9 / 50), 700, 3.18),
        (Swift(1240e6, 30, 0.085), 120, 3.45),
        (Swift(1240e6, 30, 0.085), 700, 4.35),
    ],
)
def test_hardening_raises_the_ceiling(law: Linear | Swift, ratio: float, true: float) -> None:
    # With the strain that suits both laws the one comes out 4 % low, the other as much high.
    advice = recommended_ceiling(sphere(ratio, rc.Material(210e9, 0.3, hardening=law)))
    assert advice.factor == pytest.approx(true, rel=0.055)


def test_without_strength_or_slope_nothing_is_recommended() -> None:
    ceramic = rc.Material(400e9, 0.2, hardness=15e9)
    assert recommended_ceiling(sphere(40, ceiling=3e9)) is not None
    result = rc.solve(sphere(12).surface, material=ceramic, load=1.0)
    assert recommended_ceiling(result) is None
    assert recommended_ceiling(rc.solve(FLAT, material=STEEL, load=1e-3)) is None


def test_the_rounding_of_heights_is_no_slope() -> None:
    y, x = np.mgrid[:24, :24] * 1e-6
    punch = np.where((abs(y - 12e-6) < 5e-6) & (abs(x - 12e-6) < 5e-6), 1e-5 * x + 3e-6 * y, np.nan)
    surface = rc.Surface(punch, (1e-6, 1e-6)).masked()
    result = rc.solve(surface, material=STEEL, load=0.3)
    assert result.spots().count == 1
    assert recommended_ceiling(result) is None


@pytest.mark.parametrize("ratio", [0.0, -1.0, math.nan])
def test_a_load_ratio_is_positive(ratio: float) -> None:
    with pytest.raises(rc.InputError, match="load_ratio"):
        ceiling_factor(ratio)


# --- a ceiling that agrees with itself -----------------------------------------------------------


def solve_calibrated_sphere(
    ratio: float, material: rc.Material = STEEL, **more
) -> rc.ContactResult:
    return sphere(ratio, material, ceiling="calibrated", **more)


@pytest.mark.parametrize(
    "body",
    [
        STEEL,
        rc.Material(210e9, 0.0, 1e9),
        rc.Material(3e9, 0.45, 1e8),
        rc.Material(210e9, 0.3, hardening=Linear(1e9, 210e9 / 50)),
        rc.Material(210e9, 0.3, hardening=Swift(1240e6, 30, 0.085)),
    ],
)
@pytest.mark.parametrize("ratio", [3, 40, 300])
def test_calibrated_ceiling_is_self_consistent(ratio: float, body: rc.Material) -> None:
    result = solve_calibrated_sphere(ratio, body)
    assert result.converged
    assert 1 <= result.calibration.solves <= 4
    own = recommended_ceiling(result)
    assert own.ceiling == pytest.approx(result.ceiling, rel=2e-3)
    assert result.calibration.mismatch == pytest.approx(own.ceiling / result.ceiling - 1)
    assert result.calibration.factor == pytest.approx(result.ceiling / body.yield_strength)
    # A start from there or from anywhere gives the same.
    again = rc.solve(
        result.surface, material=body, load=result.load, ceiling="calibrated", initial_guess=result
    )
    assert again.ceiling == pytest.approx(result.ceiling, rel=4e-3)
    np.testing.assert_allclose(again.pressure, result.pressure, atol=5e-3 * result.ceiling)


@pytest.mark.long
@settings(max_examples=20, deadline=None)
@given(
    seed=st.integers(0, 1000),
    load=st.floats(-3, 0.7),
    strength=st.floats(8.5, 10.5),
    poisson=st.floats(0, 0.49),
)
def test_ceiling_of_rough_maps_converges_or_reports_mismatch(
    seed: int, load: float, strength: float, poisson: float
) -> None:
    heights, pixel = rc.reference_map(32, rng=seed)
    body = rc.Material(210e9, poisson, 10**strength)
    surface = rc.Surface(heights, pixel)
    terms = {"material": body, "load": 10**load, "boundary": "periodic"}
    usual = rc.solve(surface, **terms)
    if recommended_ceiling(usual) is None and usual.regime is not Regime.BELOW_FIRST_YIELD:
        # Single pixels have no slope to be judged by.
        with pytest.raises(InputError, match="single pixels"):
            rc.solve(surface, **terms, ceiling="calibrated")
        return
    result = rc.solve(surface, **terms, ceiling="calibrated")
    if usual.regime is Regime.BELOW_FIRST_YIELD:
        assert result.calibration is None
        np.testing.assert_array_equal(result.pressure, usual.pressure)
        return
    found = result.calibration
    assert found.solves <= MAX_SOLVES
    assert abs(found.mismatch) <= CEILING_TOLERANCE or found.solves == MAX_SOLVES
    assert body.first_yield_pressure * (1 - 1e-9) <= result.ceiling <= 3 * body.yield_strength
    assert found.usual_contact_area == usual.contact_area
    assert result.contact_area >= usual.contact_area


def test_below_first_yield_the_contact_stays_as_it_is() -> None:
    usual, result = sphere(0.9), solve_calibrated_sphere(0.9)
    assert result.calibration is None
    assert result.ceiling == 3e9
    np.testing.assert_array_equal(result.pressure, usual.pressure)


def test_the_cost_is_that_of_all_solves() -> None:
    result = solve_calibrated_sphere(40)
    assert result.calibration.solves > 1
    assert result.convolutions > sphere(40).convolutions


def test_calibration_keeps_results_with_three_yield_strengths() -> None:
    usual, result = sphere(40), solve_calibrated_sphere(40)
    found = result.calibration
    assert found.usual_ceiling == usual.ceiling == 3e9
    assert found.usual_contact_area == usual.contact_area < result.contact_area
    assert found.usual_approach == usual.approach < result.approach
    deepest = usual.residual_indentation.max()
    assert found.usual_indentation == deepest < result.residual_indentation.max()
    assert found.load == result.load
    assert result.summary()["calibration"]["factor"] == found.factor


def solve_egg_box(pressure: str, **terms) -> rc.ContactResult:
    """Return a contact of a bi-sinusoidal period with E*h′/σ_Y = 25."""
    wave = np.cos(2 * np.pi * np.arange(64) / 64)
    material, pixel = rc.Material(200e9, 0.3, 1e9), (1e-6, 1e-6)
    heights = np.outer(wave, wave)
    slope = 25 * 1e9 / rc.contact_modulus(material, rc.RIGID)
    surface = rc.Surface(heights * slope / rms_gradient(heights, pixel), pixel)
    return rc.solve(surface, load=pressure, material=material, boundary="periodic", **terms)


# Contact fraction of the elastoplastic model (calibration/ceiling_rule.py): bi-sinusoidal, 25.
@pytest.mark.parametrize(
    ("pressure", "volume"),
    [("1 GPa", 0.362), ("2 GPa", 0.675), ("2.9 GPa", 0.865), ("3.3 GPa", 0.917)],
)
def test_confined_spots_have_the_area_of_the_elastoplastic_model(pressure, volume) -> None:
    result = solve_egg_box(pressure, ceiling="calibrated")
    assert result.perimeter_corrected_area / result.nominal_area == pytest.approx(volume, rel=0.05)
    (interval,) = (i for i in uncertainty_intervals(result) if i.name == "contact_fraction")
    assert interval.low < volume < interval.high <= 1


# Under the heavier load, pixels far from the first contact carry load under the lower ceiling.
@pytest.mark.parametrize("load", [1.0, 5.0])
def test_calibrated_solve_matches_self_consistent_ceiling(load: float) -> None:
    heights, pixel = rc.reference_map(256)
    more = {"material": STEEL, "load": load, "boundary": "periodic"}
    surface = rc.Surface(heights, pixel)
    calibrated = rc.solve(surface, **more).calibrated
    wanted = rc.solve(surface, **more, ceiling="calibrated")
    assert calibrated.factor == pytest.approx(wanted.ceiling / 1e9, rel=2e-3)
    assert calibrated.contact_fraction == pytest.approx(wanted.contact_fraction, rel=5e-3)
    assert calibrated.mean_gap == pytest.approx(wanted.mean_gap, rel=2e-3)


def test_interval_and_calibrated_area_are_within_face() -> None:
    for pressure in ("2 GPa", "2.5 GPa", "2.9 GPa", "2.99 GPa"):
        result = solve_egg_box(pressure)
        (interval,) = (i for i in uncertainty_intervals(result) if i.name == "contact_fraction")
        assert interval.high <= 1
        advice = recommended_ceiling(result)
        assert advice is not None
        assert calibrated_area_change(result, advice) <= 1 / result.contact_fraction - 1
        # The second solve has the same interval and is never refused.
        assert result.calibrated is not None
        assert interval.low < result.calibrated.contact_fraction < interval.high


def test_a_load_above_three_yield_strengths_names_the_calibrated_ceiling() -> None:
    with pytest.raises(rc.CapacityError, match="calibrated"):
        solve_egg_box("3.3 GPa")
    result = solve_egg_box("3.3 GPa", ceiling="calibrated")
    assert result.ceiling > 3.3e9
    # It was never solved with three yield strengths.
    assert "with three yield strengths" not in str(result)


def test_too_low_calibrated_ceiling_keeps_the_usual_one() -> None:
    heights, pixel = rc.reference_map(32)
    surface = rc.Surface(heights, pixel)
    body = rc.Material(210e9, 0.3, 1e9)
    load = 2.9e9 * surface.size[0] * surface.size[1]
    usual = rc.solve(surface, material=body, load=load)
    assert recommended_ceiling(usual).ceiling < 2.9e9
    # No message recommends what is refused.
    assert recommended_ceiling_of(usual) is None
    kept = rc.solve(surface, material=body, load=load, ceiling="calibrated")
    assert (kept.ceiling, kept.contact_area) == (usual.ceiling, usual.contact_area)
    assert "Ceiling stays at 3 σ_Y: the calibrated one" in str(kept.cautions)


def test_spots_without_slope_keep_the_usual_ceiling() -> None:
    usual, kept = (
        rc.solve(FLAT, material=STEEL, load=0.16, ceiling=ceiling)
        for ceiling in ("auto", "calibrated")
    )
    assert kept.ceiling == usual.ceiling
    assert math.isnan(kept.calibration.mismatch)
    assert "Ceiling stays at 3 σ_Y: single pixels" in str(kept.cautions)
    assert "3 yield strengths, not calibrated" in phrases.ceiling(kept)


@pytest.mark.parametrize("body", [rc.Material(210e9, 0.3), rc.Material(400e9, 0.2, hardness=15e9)])
def test_calibrated_ceiling_without_strength_raises_input_error(body: rc.Material) -> None:
    with pytest.raises(rc.InputError, match='ceiling="calibrated" needs the yield'):
        rc.solve(sphere(12).surface, material=body, load=0.16, ceiling="calibrated")


def test_elastic_counter_body_lowers_ceiling_below_equal_bodies() -> None:
    ball = sphere(40).surface
    load = 40 * hertz.first_yield_load(RADIUS, MODULUS, STEEL.first_yield_pressure)
    # Half the modulus: four times the load of first yield, so 20 times it.
    found = {
        name: recommended_ceiling(
            rc.solve(ball, material=STEEL, counter_material=body, load=2 * load)
        )
        for name, body in {"alike": STEEL, "elastic": rc.Material(210e9, 0.3)}.items()
    }
    alike, elastic = found["alike"], found["elastic"]
    assert alike.load_ratio == pytest.approx(elastic.load_ratio, rel=1e-3)
    assert alike.factor == pytest.approx(ceiling_factor(alike.load_ratio), rel=1e-4)
    assert alike.load_ratio == pytest.approx(20, rel=0.03)
    assert 1.05 < elastic.factor / alike.factor < 1.1


def test_coated_body_on_softer_one_has_the_calibrated_ceiling_of_an_elastic_body() -> None:
    soft = rc.Material(70e9, 0.33, 0.3e9)
    layer = rc.Layer(210e9, 0.3, 2e-6, hardness=20e9)
    coated = rc.Material(210e9, 0.3, 2e9, coating=[layer])
    plain, plated = (
        rc.solve(
            sphere(0.1).surface, material=body, counter_material=soft, load=1.0, ceiling="auto"
        )
        for body in (rc.Material(210e9, 0.3), coated)
    )
    known, found = recommended_ceiling(plain), recommended_ceiling(plated)
    assert found is not None
    assert found.ceiling == pytest.approx(known.ceiling, rel=2e-3)
    (area,) = (x for x in uncertainty_intervals(plated) if x.name == "contact_fraction")
    assert area.low < area.high
    assert "ceiling of" not in str(area.unknown)
    weak = replace(coated, coating=[replace(layer, hardness=0.5e9)])
    under = rc.solve(
        sphere(0.1).surface, material=weak, counter_material=soft, load=1.0, ceiling="coating"
    )
    assert recommended_ceiling(under) is None


def test_a_history_has_the_ceiling_of_its_largest_load() -> None:
    ball, load = sphere(40).surface, sphere(40).load
    fresh = rc.solve(ball, material=STEEL, load=load, ceiling="calibrated", tolerance=1e-9)
    history = load_history(
        ball,
        [load / 3, 0.0, load, rc.Stage(approach=fresh.approach / 2), 0.0],
        material=STEEL,
        ceiling="calibrated",
    )
    assert history.last.ceiling == pytest.approx(fresh.ceiling, rel=1e-9)
    assert history.calibration.load == load
    assert history.summary()["ceiling"] == history.last.ceiling
    assert load_history(ball, [0.0], material=STEEL, ceiling="calibrated").calibration is None


def test_a_sweep_has_a_ceiling_for_each_load(tmp_path: Path) -> None:
    ball, load = sphere(40).surface, sphere(40).load
    more = {"material": STEEL, "ceiling": "calibrated"}
    curve = rc.sweep(ball, loads=[load / 60, load / 8, load], folder=tmp_path, **more)
    assert curve.ceiling == "calibrated"
    ceilings = curve.column("ceiling")
    assert ceilings[0] == 3e9 > ceilings[2] > ceilings[1]
    alone = rc.solve(ball, load=load, **more)
    assert ceilings[2] == pytest.approx(alone.ceiling, rel=4e-3)
    assert curve.summary()["ceiling"] == "calibrated"
    assert curve.steps[2].contact_area == pytest.approx(alone.contact_area, rel=0.01)
    np.testing.assert_allclose(
        curve.persson[1][1:] * ceilings[1:], curve.column("load")[1:], rtol=0.2
    )
    again = rc.sweep(ball, loads=[load / 60, load / 8, load], folder=tmp_path, **more)
    np.testing.assert_array_equal(again.column("ceiling"), ceilings)


def test_a_study_keeps_the_ceiling_of_the_map() -> None:
    ball, load = sphere(40).surface, sphere(40).load
    more = {"material": STEEL, "load": load, "ceiling": "calibrated"}
    alone = rc.solve(ball, **more)
    study = rc.resolution_study(ball, **more)
    assert study.grids[-1].max_pressure == alone.ceiling
    factors = [variant.value for variant in study.ceilings]
    assert factors == pytest.approx(
        [part / 3 * alone.calibration.factor for part in (2.8, 3.0, 3.2)]
    )


def test_calibration_is_saved_and_shown(tmp_path: Path) -> None:
    result = solve_calibrated_sphere(40)
    result.save(tmp_path / "ball.nc")
    assert rc.read_result(tmp_path / "ball.nc").calibration == result.calibration
    values = {row.name: row.text for row in presentation_of(result).rows(PROBLEM)}
    assert re.fullmatch(
        r"2\.2\d+ GPa, calibrated: 2\.2\d yield strengths at 4\d times first yield",
        values["pressure ceiling"],
    )
    (row,) = (row for row in presentation_of(result).rows() if row.key == "calibration")
    assert "(−2" in row.text
    assert row.name == "with three yield strengths"
    lines = python_script.script_of_result(result)
    assert 'ceiling="calibrated"' in lines


@pytest.mark.parametrize("young", [1e-50, 1e-3, 100.0, 210e9, 1e30, math.inf])
@pytest.mark.parametrize("counter_young", [1e-50, 1e-3, 210e9, 1e50])
@pytest.mark.parametrize("strengths", [(None, 1e9), (1e9, 1e9), (1e-50, None), (1e50, 1e-50)])
def test_a_ceiling_is_recommended_for_any_moduli(
    young: float, counter_young: float, strengths: tuple[float | None, float | None]
) -> None:
    bodies = (rc.Material(young, 0.3, strengths[0]), rc.Material(counter_young, 0.3, strengths[1]))
    for mean in (1e-6, 1e3, 1e12):
        found = recommend_ceiling(bodies, 0.01, mean)
        assert 0 < found.ceiling < math.inf
        assert 0 < found.slope < math.inf
