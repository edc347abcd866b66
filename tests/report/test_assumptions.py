import dataclasses
import math
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import roughcontact as rc
from paths import ROOT
from roughcontact.cautions import CautionTag
from roughcontact.contact import plausibility
from roughcontact.contact.ceiling import recommended_ceiling
from roughcontact.contact.result import ContactResult
from roughcontact.material.hardening import Swift
from roughcontact.report import assumptions, phrases
from roughcontact.surface import shapes
from roughcontact.theory import hertz

STEEL = rc.Material(210e9, 0.3, 1e9, name="steel")
SOFT = rc.Material(70e9, 0.33, 0.3e9, name="aluminium")
CERAMIC = rc.Material(400e9, 0.2, hardness=15e9)
PIXEL = (1e-6, 1e-6)


def rough(seed: int = 0, points: int = 64) -> rc.Surface:
    heights, pixel = rc.reference_map(points, seed)
    return rc.Surface(heights, pixel)


def ball(radius: float = 0.01) -> rc.Surface:
    y, x = np.mgrid[-24:24, -24:24] * 1e-6
    return rc.Surface(-(x**2 + y**2) / (2 * radius), PIXEL)


def solve_surface(surface: rc.Surface, **problem: Any) -> ContactResult:
    return rc.solve(surface, **{"material": STEEL, "load": 0.1, **problem})


def stated_assumptions(result: ContactResult) -> dict[str, str]:
    """Return the assumptions on a result by name."""
    rows = assumptions.assumption_rows(assumptions.contact_case(result))
    assert len({name for name, _, _ in rows}) == len(rows)
    assert all(len(row) == 3 and all(row) for row in rows)
    return {name: case for name, case, _ in rows}


def errors(result: ContactResult) -> tuple[float, float]:
    return assumptions.slope_errors(assumptions.contact_case(result))


def cautions(result: ContactResult) -> list[str]:
    return [caution.text for caution in result.cautions]


def test_the_table_fits_half_a_page() -> None:
    assert all(
        len(text.split()) <= 12
        for item in assumptions.ASSUMPTIONS
        for text in (item.name, item.matters)
    )
    for problem in ({}, {"boundary": "periodic"}, {"counter_surface": rough(1)}):
        rows = stated_assumptions(solve_surface(rough(), **problem))
        assert len(rows) <= 12
        assert sum(len(case.split()) for case in rows.values()) < 200


def test_boundary_and_second_body_are_stated() -> None:
    free = stated_assumptions(solve_surface(rough()))
    assert {"No contact beyond the map edge", "Smooth counter-body"} <= set(free)
    assert "Periodic sample" not in free
    periodic = stated_assumptions(solve_surface(rough(), boundary="periodic"))
    assert "Periodic sample" in periodic
    assert "No contact beyond the map edge" not in periodic
    strip = stated_assumptions(solve_surface(rough(), boundary="periodic-x"))
    assert "Periodic sample" in strip
    assert "Datum of the approach" in strip
    assert "Datum of the approach" not in periodic
    two = stated_assumptions(solve_surface(rough(), counter_surface=rough(1)))
    assert "Two surfaces in one position" in two
    assert "Smooth counter-body" not in two


def test_a_profile_has_ridges_and_a_datum() -> None:
    surface = rc.Surface(rough().heights[0], PIXEL[1])
    profile = stated_assumptions(solve_surface(surface, load="1 N/mm"))
    assert {"Straight ridges", "Datum of the approach", "No contact beyond the map edge"} <= set(
        profile
    )
    periodic = stated_assumptions(solve_surface(surface, load="1 N/mm", boundary="periodic"))
    assert "Periodic sample" in periodic
    assert "Datum of the approach" not in periodic
    assert "Straight ridges" not in stated_assumptions(solve_surface(rough()))


def test_single_precision_is_stated_where_it_is_used() -> None:
    assert "Single precision" not in stated_assumptions(solve_surface(rough()))
    assert "Single precision" in stated_assumptions(solve_surface(rough(), precision="single"))


def test_missing_points_are_counted_and_fillings_called_so() -> None:
    assert "Missing points" not in stated_assumptions(solve_surface(rough()))
    heights = rough().heights.copy()
    heights[3:5, 7:10] = np.nan
    holed = rc.Surface(heights, PIXEL)
    assert stated_assumptions(solve_surface(holed.masked()))["Missing points"].startswith(
        "6 points (0.146 %)"
    )
    filled = stated_assumptions(solve_surface(holed.filled()))["Missing points"]
    assert "interpolated, not measured" in filled
    assert "never in contact" not in filled


@pytest.mark.parametrize(
    ("slope", "error"),
    # Of the cone of Hay, Bolshakov and Pharr to first order, 0.179 h', and half the square.
    [(0.05, "1.02 %"), (0.2, "5.59 %"), (0.5, "21.5 %")],
)
def test_slopes_have_their_error(slope: float, error: str) -> None:
    # A ramp of teeth: every first difference along x is ± slope.
    teeth = np.tile(np.array([0.0, slope * 1e-6]), (32, 16))
    result = solve_surface(rc.Surface(teeth, PIXEL), load=1e-9)
    assert result.pair.rms_slope == pytest.approx(slope)
    assert (
        stated_assumptions(result)["Small slopes"]
        == f"rms slope {slope:.3g} at the contact: error {error}"
    )


def test_the_slopes_of_a_report_are_those_of_the_page_on_assumptions() -> None:
    page = ROOT / "docs" / "assumptions.md"
    table = re.search(r"small slopes \| slope ([\d.]+) \| (\d+) % of the load", page.read_text())
    assert table is not None
    result = solve_surface(rough())
    shapes, loads = errors(result)
    ratio = float(table[1]) / plausibility.rms_slope(result)
    assert round(100 * (shapes * ratio**2 + loads * ratio)) == int(table[2])
    # "Allow for 5 to 10 % at 0.3."
    ratio = 0.3 / plausibility.rms_slope(result)
    assert 0.05 <= shapes * ratio**2 + loads * ratio <= 0.1


def test_sideways_displacement_counts_where_bodies_differ() -> None:
    slope = plausibility.rms_slope(solve_surface(rough()))
    # Hay, Bolshakov and Pharr 1999, eq. (12).
    c = (1 - 2 * 0.3) / (4 * (1 - 0.3)) * slope
    cone = math.pi * (math.pi / 4 + 0.15483073 * c) / (math.pi / 2 - 0.83119312 * c) ** 2 - 1

    def sideways(**problem: Any) -> float:
        return errors(solve_surface(rough(), **problem))[1]

    assert sideways() == pytest.approx(cone, rel=0.02)
    assert sideways(counter_material=STEEL) == 0
    assert sideways(counter_material=rc.Material(STEEL.young, 0.5)) > 0
    assert sideways(material=rc.Material(1e6, 0.5)) == 0
    assert 0 < sideways(counter_material=SOFT) < cone


def test_sideways_displacement_under_a_cylinder() -> None:
    # Johnson 1985, eq. (2.24a): half the load on either side moves the edge, here by quadrature.
    result = solve_surface(rc.Surface(rough().heights[0], PIXEL[1]), load="1 N/mm", ceiling=None)
    x = (np.arange(20000) + 0.5) / 20000
    carried = 2 * float(np.sqrt(1 - x**2).mean())
    peak = 1 / (2 * (1 - 0.3**2))  # over E a/R
    moved = (1 - 2 * 0.3) * (1 + 0.3) / 2 * carried * peak * plausibility.rms_slope(result)
    assert errors(result)[1] == pytest.approx(moved, rel=0.01)


def test_two_bodies_add_their_slopes() -> None:
    one = rough()
    twice = solve_surface(one, counter_surface=one)
    assert twice.pair.rms_slope == pytest.approx(2 * one.Sdq)


def stiffened(result: ContactResult, modulus: float) -> ContactResult:
    """Return a result whose bodies are said to have another contact modulus."""
    material = dataclasses.replace(
        result.material, young=modulus * (1 - result.material.poisson**2)
    )
    return dataclasses.replace(result, pair=dataclasses.replace(result.pair, material=material))


def test_large_strains_give_caution() -> None:
    elastic = solve_surface(rough(points=128), ceiling=None, load=1.0)
    result = stiffened(elastic, 5 * elastic.max_pressure)
    (found_caution,) = (c for c in result.cautions if c.kind == CautionTag.STRAIN)
    assert found_caution.numbers["strain"] == pytest.approx(0.2)
    result = stiffened(elastic, elastic.max_pressure / 2)
    (found_caution,) = (c for c in result.cautions if c.kind == CautionTag.STRAIN)
    assert found_caution.numbers["strain"] == pytest.approx(2.0)
    result = stiffened(elastic, 100 * elastic.max_pressure)
    assert stated_assumptions(result)["Small strains"] == "peak pressure / E* = 0.01"
    assert not any("modulus" in note for note in cautions(result))


@pytest.mark.parametrize(
    ("make", "name", "text"),
    [
        (lambda: solve_surface(ball(), ceiling=None), "No plastic flow", "elastic"),
        (
            lambda: solve_surface(ball(), material=rc.Material(210e9, 0.3)),
            "No plastic flow",
            "elastic",
        ),
        (lambda: solve_surface(ball()), "Ceiling for plastic flow", "no point reaches it"),
        (
            lambda: solve_surface(rough(), load=1.0),
            "Ceiling for plastic flow",
            "some points reach it; E*h′/σ_Y = ",
        ),
    ],
)
def test_yielding_is_stated_for_each_case(
    make: Callable[[], ContactResult], name: str, text: str
) -> None:
    rows = stated_assumptions(make())
    assert text in rows[name]
    assert len({"No plastic flow", "Ceiling for plastic flow"} & set(rows)) == 1


@pytest.mark.parametrize(
    ("problem", "text"),
    [
        ({"ceiling": 2e9}, "2 GPa, as given: 2 times the yield strength"),
        ({"counter_material": SOFT}, "900 MPa, three times the yield strength of the softer body"),
        (
            {"ceiling": np.linspace(1e9, 2e9, 64**2).reshape(64, 64)},
            "given point by point, 1 GPa to 2 GPa",
        ),
        ({"ceiling": 2e9, "material": rc.Material(210e9, 0.3)}, "2 GPa, as given"),
        ({"material": CERAMIC}, "15 GPa, the hardness"),
        ({"material": CERAMIC, "ceiling": 7.5e9}, "7.5 GPa, as given: 0.5 times the hardness"),
        (
            {"material": CERAMIC, "counter_material": STEEL},
            "3 GPa, three times the yield strength of the softer body",
        ),
    ],
)
def test_ceiling_is_named_by_its_origin(problem: dict[str, Any], text: str) -> None:
    assert phrases.ceiling(solve_surface(rough(), load=1.0, **problem)) == text


def test_the_ceiling_is_compared_with_the_body_that_yields() -> None:
    result = solve_surface(rough(), counter_material=SOFT, load=1.0)
    index = result.contact_modulus * result.pair.rms_slope / 0.3e9
    assert stated_assumptions(result)["Ceiling for plastic flow"].endswith(
        f"E*h′/σ_Y = {index:.3g}"
    )


def test_every_regime_is_a_sentence_with_its_numbers() -> None:
    below = solve_surface(ball())
    assert below.regime == "below first yield"
    assert "Nothing yields" in phrases.regime(below)
    assert "1.61 GPa" in phrases.regime(below)
    beneath = solve_surface(ball(1e-3), load=0.8)
    assert beneath.regime == "yielding below the surface"
    assert "reaches the ceiling" in phrases.regime(beneath)
    without = solve_surface(ball(1e-3), load=0.8, ceiling=None)
    assert "reaches three yield strengths" in phrases.regime(without)
    saturated = solve_surface(rough(), load=1.0)
    share = saturated.saturated_fraction / saturated.contact_fraction
    assert f"{100 * share:.1f} %" in phrases.regime(saturated)
    beyond = solve_surface(rough(), load=1.0, ceiling=None)
    assert f"{beyond.max_pressure / 1e9:.3g} times the yield" in phrases.regime(beyond)
    unknown = solve_surface(ball(), material=rc.Material(210e9, 0.3))
    assert "unknown without a yield strength" in phrases.regime(unknown)


def test_hardness_replaces_yield_strength() -> None:
    saturated = solve_surface(rough(), material=CERAMIC, load=1.0)
    assert saturated.regime == "saturated at the surface"
    below = solve_surface(ball(), material=CERAMIC)
    assert "stays below the hardness" in phrases.regime(below)
    beyond = solve_surface(rough(), material=CERAMIC, load=1.0, ceiling=None)
    assert beyond.regime == "elastic pressure beyond the hardness"
    assert "exceeds the hardness of the softer body, 15 GPa" in phrases.regime(beyond)


def test_spots_that_carry_are_the_load_median() -> None:
    pressure = np.zeros((8, 30))
    for start, size in ((0, 6), (8, 3), (13, 2), (17, 1), (20, 1), (23, 1), (26, 1)):
        pressure[2, start : start + size] = 1e9
    # 6 of 15 equal loads on the largest spot: the second one carries the median.
    result = dataclasses.replace(
        solve_surface(rc.Surface(np.zeros((8, 30)), PIXEL), load=1e-6), pressure=pressure
    )
    spots = result.spots()
    assert plausibility.load_bearing_spot_pixels(result, spots) == 3
    assert any("spots of 3 pixels or fewer" in note for note in cautions(result))
    pressure = pressure.copy()
    pressure[4:8] = 1e9
    result = dataclasses.replace(result, pressure=pressure)
    assert plausibility.load_bearing_spot_pixels(result, result.spots()) == 120
    assert not any("pixels or fewer" in note for note in cautions(result))


def test_map_without_slopes_is_stated() -> None:
    heights = np.full((4, 4), np.nan)
    heights[::2, ::2] = 0.0
    result = solve_surface(rc.Surface(heights, PIXEL).masked(), load=1e-6)
    assert math.isnan(plausibility.rms_slope(result))
    assert stated_assumptions(result)["Small slopes"] == "no slope is known on this map"


def loaded_ball(ratio: float, **more: Any) -> ContactResult:
    """Return a well-resolved ball at a multiple of the load of first yield."""
    modulus, radius = rc.contact_modulus(STEEL, rc.RIGID), 1e-3
    load = ratio * hertz.first_yield_load(radius, modulus, 1.295 * math.exp(0.736 * 0.3) * 1e9)
    side = 3 * max(hertz.contact_radius(load, radius, modulus), math.sqrt(load / math.pi / 3e9))
    pixel = (side / 64, side / 64)
    surface = rc.Surface(shapes.paraboloid((64, 64), pixel, radius), pixel)
    return solve_surface(surface, load=load, **more)


def caution(result: ContactResult) -> str:
    return " ".join(c.text for c in result.cautions if c.kind == CautionTag.CEILING)


@pytest.mark.parametrize(
    ("ratio", "more", "factor"),
    [(3, {}, 1.78), (40, {}, 2.22), (300, {}, 2.63), (300, {"ceiling": 2.2e9}, 2.63)],
)
def test_unsuitable_ceiling_shows_calibrated_ceiling(
    ratio: float, more: dict[str, Any], factor: float
) -> None:
    result = loaded_ball(ratio, **more)
    assert result.calibrated is not None
    assert result.calibrated.differs
    assert result.calibrated.factor == pytest.approx(factor, abs=0.01)
    assert result.calibrated.load_ratio == pytest.approx(ratio, rel=0.05)
    (solved,) = (c for c in result.cautions if c.kind == CautionTag.CEILING)
    change = result.calibrated.contact_area / result.contact_area - 1
    assert solved.numbers["area_change"] == change
    assert f"{100 * abs(change):.2g} %" in solved.text
    assert solved.numbers["recommended_ceiling"] == result.calibrated.ceiling
    # The same message without the second solve, by the rule of single spheres.
    first = loaded_ball(ratio, calibrated=False, **more)
    (by_rule,) = (c for c in first.cautions if c.kind == CautionTag.CEILING)
    assert by_rule.severity == solved.severity
    assert (by_rule.severity == "caution") is (abs(by_rule.numbers["area_change"]) >= 0.1)
    assert by_rule.numbers["area_change"] == pytest.approx(change, abs=0.02)
    assert by_rule.numbers["recommended_ceiling"] == pytest.approx(factor * 1e9, rel=0.01)


@pytest.mark.parametrize(
    ("ratio", "more"),
    [
        (0.5, {}),
        (1.5, {}),
        # The ceiling that was recommended, and three where they are right.
        (40, {"ceiling": 2.2e9}),
        (1500, {}),
        (40, {"ceiling": None}),
        (40, {"ceiling": np.full((64, 64), 3e9)}),
        (40, {"material": rc.Material(210e9, 0.3), "ceiling": 3e9}),
        (40, {"material": rc.Material(210e9, 0.3, hardness=3e9)}),
    ],
)
def test_suitable_or_unjudged_ceiling_gives_no_caution(ratio: float, more: dict[str, Any]) -> None:
    assert caution(loaded_ball(ratio, **more)) == ""


def test_the_calibrated_ceiling_agrees_with_its_own_solution() -> None:
    first = solve_surface(rough(points=128), load=1.0)
    assert first.calibrated is not None
    own = solve_surface(rough(points=128), load=1.0, ceiling="calibrated")
    assert first.calibrated.ceiling == pytest.approx(own.ceiling, rel=2e-3)
    assert first.calibrated.contact_area == pytest.approx(own.contact_area, rel=5e-3)
    assert own.calibrated is None


def test_hardening_raises_calibrated_factor_above_four() -> None:
    swift = rc.Material(210e9, 0.3, hardening=Swift(500e6, 30, 0.2))
    result = loaded_ball(1000, material=swift)
    assert result.calibrated is not None
    assert result.calibrated.factor > 4
    assert result.calibrated.contact_area < result.contact_area


def test_spots_of_few_pixels_give_no_ceiling_caution() -> None:
    result = solve_surface(rough(), load=0.02)
    spots = result.spots()
    assert 0 < plausibility.load_bearing_spot_pixels(result, spots) < 10
    assert recommended_ceiling(result).load_ratio > 2
    assert caution(result) == ""
