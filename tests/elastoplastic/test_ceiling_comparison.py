import json
import math
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.elastoplastic import ceiling_comparison
from roughcontact.surface import shapes
from roughcontact.theory import hertz

pytestmark = pytest.mark.long

STEEL = rc.Material(210e9, 0.3, 1e9, "steel")
MODULUS = rc.contact_modulus(STEEL, rc.RIGID)
RADIUS = 0.01


def ball(points: int = 32) -> tuple[rc.Surface, float]:
    """Return a ball whose contact fills a third of the map at twelve times first yield."""
    first = hertz.first_yield_load(RADIUS, MODULUS, STEEL.first_yield_pressure)
    side = 6 * hertz.contact_radius(12 * first, RADIUS, MODULUS)
    pixel = (side / points, side / points)
    heights = shapes.paraboloid((points, points), pixel, RADIUS)
    return rc.Surface(heights, pixel), first


@pytest.fixture(scope="module")
def compared() -> rc.results.ModelComparison:
    surface, first = ball()
    return rc.compare_models(
        surface,
        material=STEEL,
        increments=1,
        loads=[0.5 * first, 4 * first, 12 * first],
        factors=[1.6, 1.8, 2.0, 2.4, 3.0],
    )


def test_below_first_yield_both_are_elastic(compared: rc.results.ModelComparison) -> None:
    for name in ceiling_comparison.QUANTITIES:
        assert compared.excess(name)[:, 0] == pytest.approx(0, abs=1e-4)
        # No ceiling is felt: none is better than another.
        assert math.isnan(compared.best_factor(name)[0])
    assert compared.map_error()[:, 0] == pytest.approx(0, abs=1e-4)
    assert compared.volume[0].max_plastic_strain == 0


def test_the_ceiling_is_too_high_in_the_transition(compared: rc.results.ModelComparison) -> None:
    # Perfectly plastic spheres: 1.90 yield strengths at twelve loads of first yield (the page of
    # assumptions); the contact of five pixels in radius is known to some per cent.
    assert compared.mean_pressure_ratio[2] == pytest.approx(1.9, rel=0.06)
    assert compared.excess("mean_pressure")[-1, 2] == pytest.approx(0.31, abs=0.08)
    # On so coarse a grid the areas at four loads of first yield may be equal in pixels.
    assert (compared.excess("mean_pressure")[-1] >= 0).all()
    assert (compared.excess("contact_area")[-1] <= 0).all()
    assert np.diff(compared.mean_pressure_ratio).min() > 0


def test_a_higher_ceiling_has_less_area_and_approach(compared: rc.results.ModelComparison) -> None:
    for name, sign in (("contact_area", -1), ("approach", -1), ("plateau_pressure", 1)):
        steps = sign * np.diff(compared.column("ceiling", name)[:, 2])
        assert (steps >= 0).all()
        assert steps.sum() > 0


def test_the_best_factor_is_where_the_error_changes_sign(
    compared: rc.results.ModelComparison,
) -> None:
    for name in ("contact_area", "approach"):
        error = compared.excess(name)[:, 2]
        best = compared.best_factor(name)[2]
        assert error[0] > 0 > error[-1]
        assert np.interp(best, compared.factors, error) == pytest.approx(0, abs=1e-12)
    # The area of so few pixels gives the factor to some per cent.
    assert compared.best_factor("contact_area")[2] == pytest.approx(1.9, abs=0.15)
    # A ceiling that fits removes most of the error of the map of pressures.
    error = compared.map_error()[:, 2]
    assert error.min() < 0.5 * error[-1]
    assert compared.factors[int(error.argmin())] in (1.8, 2.0, 2.4)


def test_outside_of_the_factors_the_nearest_is_best() -> None:
    surface, first = ball(16)
    both = rc.compare_models(
        surface, material=STEEL, increments=1, loads=[12 * first], factors=[2.6, 3.0]
    )
    assert both.best_factor("contact_area") == pytest.approx([2.6])
    alone = rc.compare_models(surface, material=STEEL, increments=1, loads=[12 * first])
    assert alone.factors == (3.0,)
    assert alone.best_factor("approach") == pytest.approx([3.0])
    assert alone.excess("approach") == pytest.approx(both.excess("approach")[1:], rel=1e-5)


def test_columns_are_those_of_the_results(compared: rc.results.ModelComparison) -> None:
    assert compared.column("elastoplastic", "approach")[1] == compared.volume[1].contact.approach
    last = compared.ceiling[-1][2]
    assert compared.column("ceiling", "max_pressure")[-1, 2] == last.max_pressure
    assert compared.column("elastoplastic", "mean_pressure") == pytest.approx(
        compared.loads / compared.column("elastoplastic", "contact_area")
    )
    pressure = last.pressure[last.contact]
    assert compared.column("ceiling", "plateau_pressure")[-1, 2] == pytest.approx(
        np.average(pressure, weights=pressure)
    )
    alone = rc.solve(last.surface, material=STEEL, load=compared.loads[2])
    assert last.approach == pytest.approx(alone.approach, rel=1e-5)
    assert alone.ceiling == last.ceiling


def test_yielded_rims_enlarge_corrected_area(compared: rc.results.ModelComparison) -> None:
    elastic, _, plastic = compared.volume
    assert elastic.perimeter_corrected_area == elastic.contact.perimeter_corrected_area
    assert plastic.yielded.any()
    assert (
        plastic.contact.perimeter_corrected_area
        < plastic.perimeter_corrected_area
        <= plastic.contact.contact_area
    )


def test_comparison_is_saved(compared: rc.results.ModelComparison, tmp_path: Path) -> None:
    compared.save(tmp_path / "c.json")
    read = json.loads((tmp_path / "c.json").read_text(encoding="utf-8"))
    assert read["mean_pressure_ratio"] == compared.mean_pressure_ratio.tolist()
    assert read["approach_excess"] == compared.excess("approach").tolist()
    assert len(read["elastoplastic_contact_area"]) == 3
    with pytest.raises(rc.InputError, match=r"\.json"):
        compared.save(tmp_path / "c.csv")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"material": rc.Material(210e9, 0.3)}, "no body has a yield strength"),
        ({"loads": []}, "loads must be positive and ascend"),
        ({"loads": [1.0, 0.5]}, "loads must be positive and ascend"),
        ({"loads": [0.0, 1.0]}, "loads must be positive and ascend"),
        ({"loads": [[1.0]]}, "loads must be a list of quantities"),
        ({"loads": [{}]}, "loads must be a list of quantities"),
        ({"loads": ["1 m"]}, "loads needs a force with its unit"),
        ({"loads": None}, "loads must be a list of quantities"),
        ({"loads": [1.0, 1e9]}, "more than the surface can carry"),
        ({"factors": []}, "factors must be positive and ascend"),
        ({"factors": [3.0, 2.0]}, "factors must be positive and ascend"),
        ({"factors": [3.0, math.nan]}, "factors must be positive and ascend"),
        ({"factors": [3.0, math.inf]}, "factors must be positive and ascend"),
        ({"material": None}, "material must be a Material"),
        ({"counter_material": "stone"}, "is not in the catalog"),
        ({"factors": [1e-9, 3.0]}, "more than the surface can carry"),
    ],
)
def test_invalid_input_raises_input_error_before_solve(change: dict, message: str) -> None:
    with pytest.raises(rc.InputError, match=message):
        rc.compare_models(ball()[0], **{"material": STEEL, "loads": [1.0], **change})


def test_progress_numbers_the_loads() -> None:
    surface, first = ball(16)
    messages: list[rc.results.Progress] = []
    loads = [0.5 * first, 2 * first]
    rc.compare_models(surface, material=STEEL, increments=1, loads=loads, progress=messages.append)
    assert sorted({(at.number, at.count, at.step.load) for at in messages}) == [
        (1, 2, loads[0]),
        (2, 2, loads[1]),
    ]


def test_unknown_names(compared: rc.results.ModelComparison) -> None:
    with pytest.raises(rc.InputError, match="model must be"):
        compared.column("elastic", "approach")
    with pytest.raises(rc.InputError, match="name must be one of"):
        compared.column("elastoplastic", "gap")
