import json
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from roughcontact import comparison, generate, hertz

STEEL = rc.Material(210e9, 0.3, 1e9, "steel")
MODULUS = rc.contact_modulus(STEEL, rc.RIGID)
RADIUS = 0.01


def ball(points: int = 32) -> tuple[rc.Surface, float]:
    """Return a ball whose contact fills a third of the map at twelve times first yield."""
    first = hertz.first_yield_load(RADIUS, MODULUS, STEEL.first_yield_pressure)
    side = 6 * hertz.contact_radius(12 * first, RADIUS, MODULUS)
    pixel = (side / points, side / points)
    heights = generate.paraboloid((points, points), pixel, RADIUS)
    return rc.Surface(heights, pixel), first


@pytest.fixture(scope="module")
def compared() -> rc.ModelComparison:
    surface, first = ball()
    return rc.compare_models(surface, material=STEEL, loads=[0.5 * first, 4 * first, 12 * first])


def test_below_first_yield_both_are_elastic(compared: rc.ModelComparison) -> None:
    for name in comparison.QUANTITIES:
        assert compared.excess(name)[0] == pytest.approx(0, abs=1e-4)
    assert compared.volume[0].max_plastic_strain == 0


def test_the_ceiling_is_too_high_in_the_transition(compared: rc.ModelComparison) -> None:
    # Perfectly plastic spheres: 1.90 yield strengths at twelve loads of first yield (the page of
    # assumptions); the contact of five pixels in radius is known to some per cent.
    assert compared.factor[2] == pytest.approx(1.9, rel=0.06)
    assert compared.excess("mean_pressure")[2] == pytest.approx(0.31, abs=0.08)
    # On so coarse a grid the areas at four loads of first yield may have as many pixels.
    assert (compared.excess("mean_pressure") >= 0).all()
    assert (compared.excess("contact_area") <= 0).all()
    assert np.diff(compared.factor).min() > 0


def test_columns_are_those_of_the_results(compared: rc.ModelComparison) -> None:
    assert compared.column("volume", "approach")[1] == compared.volume[1].contact.approach
    assert compared.column("ceiling", "max_pressure")[2] == compared.ceiling[2].max_pressure
    assert compared.column("volume", "mean_pressure") == pytest.approx(
        compared.loads / compared.column("volume", "contact_area")
    )
    alone = rc.solve(compared.ceiling[2].surface, material=STEEL, load=compared.loads[2])
    assert compared.ceiling[2].approach == pytest.approx(alone.approach, rel=1e-5)


def test_it_is_written(compared: rc.ModelComparison, tmp_path: Path) -> None:
    compared.save(tmp_path / "c.json")
    read = json.loads((tmp_path / "c.json").read_text(encoding="utf-8"))
    assert read["factor"] == compared.factor.tolist()
    assert len(read["volume_contact_area"]) == 3
    with pytest.raises(rc.InputError, match=r"\.json"):
        compared.save(tmp_path / "c.csv")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"material": rc.Material(210e9, 0.3)}, "no body has a yield strength"),
        ({"loads": []}, "loads must be positive and ascend"),
        ({"loads": [1.0, 0.5]}, "loads must be positive and ascend"),
        ({"loads": [0.0, 1.0]}, "loads must be positive and ascend"),
        ({"loads": [1.0, 1e9]}, "more than the surface can carry"),
    ],
)
def test_bad_input_is_refused_before_anything_runs(change: dict, message: str) -> None:
    with pytest.raises(rc.InputError, match=message):
        rc.compare_models(ball()[0], **{"material": STEEL, "loads": [1.0], **change})


def test_unknown_names(compared: rc.ModelComparison) -> None:
    with pytest.raises(rc.InputError, match="model must be"):
        compared.column("elastic", "approach")
    with pytest.raises(rc.InputError, match="name must be one of"):
        compared.column("volume", "gap")
