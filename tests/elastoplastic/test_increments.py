"""Load steps of the volume model are chosen, and their error is given."""

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.analyses.solve import fields as contact_fields
from roughcontact.elastoplastic import archive, increments as stepping
from roughcontact.elastoplastic.solve import solve_elastoplastic
from roughcontact.material.hardening import Linear
from roughcontact.report import phrases
from roughcontact.report.kind import quantity_of
from roughcontact.theory import hertz

STEEL = rc.Material(210e9, 0.3, yield_strength=1e9)
HARDENING = rc.Material(210e9, 0.3, yield_strength=1e9, hardening=Linear(1e9, 20e9))
RADIUS = 1e-3
MODULUS = rc.contact_modulus(STEEL, rc.RIGID)
FIRST = hertz.first_yield_load(RADIUS, MODULUS, STEEL.first_yield_pressure)


def sphere(ratio: float, points: int, material: rc.Material = STEEL) -> dict[str, Any]:
    """Return a sphere and layers for some times the load of first yield, without that load."""
    radius = (ratio * FIRST / (np.pi * 2 * STEEL.yield_strength)) ** 0.5
    pixel = 3.6 * radius / points
    x = (np.arange(points) - (points - 1) / 2) * pixel
    layers = np.geomspace(0.5, 1, 8)
    return {
        "surface": rc.Surface(-(x[:, None] ** 2 + x**2) / (2 * RADIUS), (pixel, pixel)),
        "material": material,
        "layers": layers / layers.sum() * 2.2 * radius,
        "tolerance": 1e-3,
        # Without the images of a free map: a tenth of the time.
        "boundary": "periodic",
    }


def near(result: rc.ElastoplasticResult) -> float:
    """Return the area that all but touches, in pixels."""
    pressed = result.contact
    gap = np.nan_to_num(pressed.gap, nan=np.inf)
    return float(np.clip(1 - gap / (0.05 * pressed.approach), 0, 1).sum())


@pytest.fixture(scope="module")
def automatic() -> rc.ElastoplasticResult:
    return solve_elastoplastic(**sphere(12, 16), load=12 * FIRST)


@pytest.mark.long
@pytest.mark.parametrize(
    ("ratio", "points", "steps"), [(12, 16, 32), pytest.param(40, 24, 64, marks=pytest.mark.slow)]
)
def test_the_estimate_is_the_error(
    ratio: float, points: int, steps: int, automatic: rc.ElastoplasticResult
) -> None:
    problem, found = sphere(ratio, points), automatic
    if ratio != 12:
        problem["boundary"] = "free"
        found = solve_elastoplastic(**problem, load=ratio * FIRST)
    fine = solve_elastoplastic(**problem, load=ratio * FIRST, increments=steps)
    assert fine.step_error is None
    assert found.step_error is not None
    # Both fall with the size of the steps: what the fine ones leave is known to a part.
    left = 1 - len(found.increments) / steps
    error = max(
        abs(found.contact.approach / fine.contact.approach - 1), abs(near(found) / near(fine) - 1)
    )
    assert 0.5 < found.step_error / (error / left) < 2
    assert found.step_error < 0.01


@pytest.fixture(scope="module")
def hardened() -> rc.ElastoplasticResult:
    return solve_elastoplastic(**sphere(4, 12, HARDENING), load=4 * FIRST)


def test_elastic_run_takes_one_increment(automatic: rc.ElastoplasticResult) -> None:
    problem = sphere(12, 16)
    del problem["layers"]
    released = solve_elastoplastic(**problem, loads=[0.0, 8 * FIRST], start=automatic)
    assert len(released.increments) == len(automatic.increments) + 2
    assert released.step_error == pytest.approx(automatic.step_error)
    elastic = solve_elastoplastic(**sphere(12, 16), load=0.5 * FIRST)
    assert elastic.step_error == 0
    assert phrases.step_error(elastic) == "none"


@pytest.mark.slow
def test_increments_shrink_with_error_estimate(
    hardened: rc.ElastoplasticResult, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert hardened.step_error is not None
    monkeypatch.setattr(stepping, "STEP_ERROR", 0.7 * hardened.step_error)
    finer = solve_elastoplastic(**sphere(4, 12, HARDENING), load=4 * FIRST)
    assert finer.step_error is not None
    assert 18 <= len(finer.increments) <= 48
    assert finer.step_error < hardened.step_error


@pytest.mark.slow
def test_step_error_is_reported(automatic: rc.ElastoplasticResult, tmp_path: Path) -> None:
    assert "of approach and contact area" in phrases.step_error(automatic)
    assert quantity_of(contact_fields.VOLUME, "step_error").value(automatic) == automatic.step_error
    assert json.loads(json.dumps(automatic.summary()))["step_error"] == automatic.step_error

    def with_error(error: float | None) -> rc.ElastoplasticResult:
        last = dataclasses.replace(automatic.increments[-1], step_error=error)
        return dataclasses.replace(automatic, increments=(*automatic.increments[:-1], last))

    assert "about 3 % of" in phrases.step_error(with_error(0.03))
    given = with_error(None)
    assert "not estimated" in phrases.step_error(given)
    for result in (automatic, given):
        result.save(tmp_path / "kept.nc")
        assert archive.load_elastoplastic(tmp_path / "kept.nc").increments == result.increments


@pytest.mark.long
def test_comparison_reports_step_errors() -> None:
    surface = sphere(3, 12)["surface"]
    both = rc.compare_models(
        surface, material=HARDENING, loads=[FIRST, 3 * FIRST], boundary="periodic"
    )
    summary = both.summary()["step_error"]
    assert summary == [state.step_error for state in both.volume]
    assert all(error is not None and error < 0.01 for error in summary)


@pytest.mark.parametrize("increments", ["some", 0, 2.5])
def test_increments_that_cannot_be_used(increments: Any) -> None:
    with pytest.raises(rc.InputError, match="increments"):
        solve_elastoplastic(**sphere(3, 16), load=FIRST, increments=increments)
