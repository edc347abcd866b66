"""How sure the headline numbers are: what each cause is said to move, and that it does."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

import ceiling_error
import roughcontact as rc
from roughcontact.contact import certainty, judgment
from roughcontact.contact.advice import RecommendedCeiling
from roughcontact.contact.ceiling import area_change
from roughcontact.contact.certainty import Cause, Doubt, Interval
from roughcontact.contact.result import Regime
from roughcontact.report import sureness

STORED = json.loads(Path(ceiling_error.STORED).read_text(encoding="utf-8"))
STEEL = rc.Material(210e9, 0.3, 1e9)
Y, X = np.mgrid[-32:32, -32:32] * 3e-6
BALL = rc.Surface(-(X**2 + Y**2) / (2 * 1e-3), (3e-6, 3e-6))


def interval(result, name="contact_fraction", study=None):
    (found,) = (one for one in certainty.intervals(result, study) if one.name == name)
    return found


def causes(one):
    return {doubt.cause: doubt for doubt in one.doubts}


def with_plasticity(row):
    """Relative change of the area under three yield strengths to that of the volume model."""
    errors = row["errors"]["contact_area"]
    three = ceiling_error.FACTORS.index(3.0) if len(errors) > 1 else 0
    return 1 / (1 + errors[three]) - 1


@pytest.mark.parametrize("kind", ["spheres", "maps"])
def test_plasticity_of_the_volume_lies_in_what_is_said(kind):
    # Each stored case was followed with plasticity of the volume.
    within = 0
    for row in STORED[kind]:
        law, found = ceiling_error.LAWS[row["law"]], row["recommended"]
        strength = float(law.strength(np.array(0.0)))
        flow = float(law.strength(np.array(0.15 * found["slope"])))
        advice = RecommendedCeiling(
            found["load_ratio"], found["slope"], flow, 1.615 * flow, found["factor"] * strength,
            found["factor"],
        )  # fmt: skip
        modulus = ceiling_error.YOUNG / (1 - ceiling_error.POISSON**2)
        change = area_change(advice, 3 * strength, modulus)
        error = judgment.SHOWN_ROUGH if kind == "maps" else judgment.SHOWN_SPHERE
        if row["law"] != "perfect":
            error = judgment.SHOWN_HARDENING
        error += certainty._ONE_SPHERE
        within += abs(with_plasticity(row) - change) <= error * (1 + change)
    assert within >= 0.95 * len(STORED[kind])


def test_a_contact_below_first_yield_has_no_doubt_about_yielding():
    result = rc.solve(BALL, material=STEEL, load=0.2)
    assert result.regime is Regime.BELOW_FIRST_YIELD
    assert set(causes(interval(result))) == {Cause.RIM, Cause.PIXEL, Cause.TOLERANCE}


def test_beyond_first_yield_the_area_is_said_to_be_larger():
    # P/P_c is 40 for about 16 N here: a quarter of the area is missing at three yield strengths.
    result = rc.solve(BALL, material=STEEL, load=12)
    doubt = causes(interval(result))[Cause.YIELDING]
    assert doubt.low == 0
    assert 0.2 < doubt.high < 0.5
    recommended = rc.solve(BALL, material=STEEL, load=12, ceiling="recommended")
    area = recommended.contact_fraction
    assert interval(result).low < area < interval(result).high
    again = causes(interval(recommended))[Cause.YIELDING]
    assert -0.08 < again.low < 0 < again.high < 0.08
    without = causes(interval(rc.solve(BALL, material=STEEL, load=12, ceiling=None)))
    assert without[Cause.YIELDING].high > doubt.high


def test_what_is_not_known_is_said():
    result = rc.solve(BALL, material=STEEL, load=12)
    assert interval(result, "approach").unknown == (Cause.YIELDING, Cause.PIXEL)
    auxetic = rc.Material(210e9, -0.2, 1e9)
    odd = interval(rc.solve(BALL, material=auxetic, load=12))
    assert math.isnan(causes(odd)[Cause.YIELDING].low)
    limits = np.where(X < 0, 3e9, 2e9)
    by_pixel = rc.solve(BALL, material=STEEL, load=12, ceiling=limits)
    assert Cause.YIELDING in interval(by_pixel).unknown


def test_rows_name_number_ends_and_causes():
    result = rc.solve(BALL, material=STEEL, load=12)
    rows = {name: (ends, why) for name, ends, why in sureness.rows(result)}
    ends, why = rows["real contact"]
    assert " to " in ends
    assert "rim of the spots -" in why
    assert "ceiling against plasticity of the volume +" in why
    assert "pixel not studied" in why
    assert "ceiling against plasticity of the volume not known" in rows["approach"][1]


def test_a_study_tells_what_the_pixel_moves():
    result = rc.solve(BALL, material=STEEL, load=0.2)
    study = rc.resolution_study(BALL, material=STEEL, load=0.2)
    doubt = causes(interval(result, study=study))[Cause.PIXEL]
    assert doubt.known
    changes = study.changes("contact_fraction")[-2:]
    assert (doubt.low, doubt.high) == (min(0.0, *changes), max(0.0, *changes))
    told = interval(result, study=study)
    assert told.low <= told.value <= told.high


def test_the_hardness_lies_in_what_is_said_of_a_body_that_hardens():
    # Three yield strengths are 0.6 of the hardness: the area under it is not beyond what is said.
    iron = rc.Material(210e9, 0.3, 1e9, hardness=5e9)
    told = interval(rc.solve(BALL, material=iron, load=25))
    full = rc.solve(BALL, material=iron, load=25, ceiling=5e9)
    assert told.low <= full.contact_fraction < 0.9 * told.value
    assert told.high == pytest.approx(interval(rc.solve(BALL, material=STEEL, load=25)).high)


def test_a_number_that_nothing_bounds_is_not_given_as_sure():
    result = rc.solve(BALL, material=STEEL, load=12)
    ends = {name: told for name, told, _ in sureness.rows(result)}
    assert ends["approach"].endswith("m, not bounded")
    assert ends["real contact"].endswith(" or beyond")


def test_large_changes_do_not_add_up_to_no_contact_at_all():
    # Of a map of noise: the rim takes a third, twice the pixel to the pixel nine tenths.
    told = Interval("contact_fraction", 0.256, (Doubt(Cause.RIM, -0.33, 0.0),
                                                Doubt(Cause.PIXEL, -0.93, 0.0)))  # fmt: skip
    assert told.low == pytest.approx(0.256 * 0.67 * 0.07)
