"""The calibrated ceiling against plasticity of the volume: area, and what stays behind."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
import pytest

import ceiling_rule
import roughcontact as rc
from roughcontact.analyses.history.model import history as load_history
from roughcontact.cautions import Caution, CautionTag, Severity
from roughcontact.contact import plausibility
from roughcontact.contact.ceiling import recommended_ceiling
from roughcontact.contact.result import CalibratedCeiling
from roughcontact.theory import indenters
from roughcontact.uncertainty import intervals as uncertainty

# Quick ones: half a dozen loads, a contact of six pixels in radius whose middle is on none.
POINTS, STEP = 26, 1.6
METAL = rc.Conductor(resistivity=1e-7)


def steel(poisson: float) -> rc.Material:
    return rc.Material(210e9, poisson, 1e9)


@lru_cache
def volume(poisson: float, ratio: float) -> tuple[ceiling_rule.Case, dict[str, Any]]:
    """Return a sphere at a number of loads of first yield, and what the volume gives."""
    case = ceiling_rule.sphere(
        ratio, steel(poisson), step=STEP, points=POINTS, kind="sphere", poisson=poisson
    )
    return case, list(ceiling_rule.volume_results(case))[-1]


def imprint_caution(history: rc.results.LoadHistory) -> Caution:
    """Return the caution on what the ceiling leaves behind."""
    (caution,) = (caution for caution in history.cautions if caution.kind == CautionTag.INDENTATION)
    return caution


SPHERES = [
    pytest.param(0.1, 40, marks=pytest.mark.long),
    pytest.param(0.45, 40, marks=pytest.mark.long),
    pytest.param(0.2, 12, marks=pytest.mark.slow),
    pytest.param(0.0, 120, marks=pytest.mark.slow),
    pytest.param(0.3, 40, marks=pytest.mark.slow),
    pytest.param(0.4, 300, marks=pytest.mark.slow),
]


@pytest.mark.slow
@pytest.mark.parametrize(("poisson", "ratio"), SPHERES)
def test_area_of_sphere_for_any_poisson_ratio(poisson: float, ratio: float) -> None:
    case, found = volume(poisson, ratio)
    usual, advised = (
        ceiling_rule.ceiling_ratio(case, found, name) for name in ("auto", "calibrated")
    )
    # The rule is right to 3 %; steps this large and whole pixels add some. The one before, which
    # knew ν = 0.3 alone, missed by -11 % at 0.1 and by +9 % at 0.45.
    assert usual["area"] < -0.1
    assert abs(advised["area"]) < 0.045
    assert abs(advised["approach"]) < 0.06
    assert advised["judged"] == pytest.approx(ratio, rel=0.06)


@pytest.mark.slow
@pytest.mark.parametrize(("poisson", "ratio"), SPHERES[:2])
def test_residual_indentation_of_sphere_matches_caution(poisson: float, ratio: float) -> None:
    case, found = volume(poisson, ratio)
    for ceiling in ("auto", "calibrated"):
        result = ceiling_rule.ceiling_ratio(case, found, ceiling)
        advice = recommended_ceiling(
            rc.solve(case.surface, load=found["load"], ceiling=ceiling, **case.bodies)
        )
        limit = 3e9 if ceiling == "auto" else result["factor"] * 1e9
        depth, energy = plausibility.ratio_to_elastoplastic(advice, limit)
        assert result["depth"] == pytest.approx(depth, abs=0.1)
        assert result["energy"] == pytest.approx(energy, abs=0.1)
    # With the calibrated ceiling of the result.
    assert 1 <= result["depth"] <= 1.3
    assert 1.2 <= result["energy"] <= 1.5


def test_three_yield_strengths_match_full_plasticity() -> None:
    # At 400 times first yield they leave 1.0 and 1.1 times as much.
    advice = CalibratedCeiling(400, 0.1, 1e9, 1.615e9, 2.68e9, 2.68)
    caution = plausibility.indentation_caution(advice, 3e9)
    assert caution is not None
    assert caution.severity is Severity.CAUTION
    assert caution.numbers["indentation_over_volume"] == pytest.approx(1.0, abs=0.05)
    assert caution.numbers["energy_over_volume"] == pytest.approx(1.1, abs=0.05)
    far = plausibility.indentation_caution(advice, 6e9)
    assert far is not None
    assert far.severity is Severity.WARNING


def test_caution_of_stepped_path_uses_initial_bodies() -> None:
    case = ceiling_rule.sphere(40, steel(0.3), points=POINTS)
    load = case.path[-1]
    at_once, in_steps = (
        load_history(case.surface, path, material=case.material)
        for path in ([load, 0.0], [load / 2, 0.0, 0.8 * load, load, load])
    )
    ratios = [imprint_caution(one).numbers["load_ratio"] for one in (at_once, in_steps)]
    assert ratios[1] == pytest.approx(ratios[0], rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["both yield, 1 : 1.15", "elastic counter-body, E"])
def test_two_bodies(name: str) -> None:
    counter, _, _ = ceiling_rule.PAIRS[name]
    case = ceiling_rule.sphere(40, steel(0.3), counter, step=STEP, points=POINTS, kind=name)
    found = list(ceiling_rule.volume_results(case))[-1]
    # The rule before knew only the softer body: -4 % and -8 % in the plateau.
    assert abs(ceiling_rule.ceiling_ratio(case, found, "calibrated")["area"]) < 0.04


@pytest.mark.slow
def test_a_line_contact() -> None:
    case = ceiling_rule.line(0.3, 10, points=96)
    found = list(ceiling_rule.volume_results(case))[-1]
    assert ceiling_rule.ceiling_ratio(case, found, "auto")["area"] < -0.15
    assert abs(ceiling_rule.ceiling_ratio(case, found, "calibrated")["area"]) < 0.06


def test_the_law_begins_with_hertz_and_ends_at_three() -> None:
    assert indenters.mean_pressure(1.0) == 4 / (3 * math.pi)
    assert indenters.mean_pressure(1e6) == pytest.approx(3, abs=1e-9)
    for first in (1.295, 1.615, 1.87):
        means = [indenters.mean_pressure(1.05**n, first) for n in range(150)]
        assert means == sorted(means)
        assert all(m <= 4 * 1.05**n / (3 * math.pi) + 1e-12 for n, m in enumerate(means))


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "load"), [(1, 0.3), (3, 1.0)])
def test_interval_of_joint_covers_volume_model(seed: int, load: float) -> None:
    n = 48
    heights = rc.self_affine(
        (n, n),
        (1e-4 / n,) * 2,
        rms_height=3e-7,
        rolloff_wavelength=5e-5,
        cutoff_wavelength=1.2e-5,
        rng=np.random.default_rng(seed),
    )
    options: Any = {"material": steel(0.3), "load": load, "boundary": "periodic"}
    rough = rc.Surface(heights, (1e-4 / n,) * 2)
    given = rc.solve(rough, **options)
    advice = plausibility.deviating_ceiling(given)
    assert advice is not None
    other = rc.solve(rough, **options, ceiling=advice.ceiling)
    volume = rc.solve_elastoplastic(rough, **options).solution
    fluid = {"viscosity": 1e-3, "pressure_difference": 1e6}

    def numbers(contact: rc.ContactResult) -> tuple[float, float]:
        flow = rc.leakage([contact], **fluid).steps[-1]
        length = rc.conductance([contact], METAL, METAL).steps[-1].length
        return float(np.ravel(flow.permeability)[0]), length

    area = other.contact_area / given.contact_area - 1
    for value, changed, right in zip(*map(numbers, (given, other, volume)), strict=True):
        interval = uncertainty.joint_interval("", value, given, 0.0, (changed / value - 1, area))
        assert interval.low < right < interval.high
        assert abs(right / value - 1) > 0.02
