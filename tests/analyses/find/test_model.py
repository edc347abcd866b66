"""Inverse problems: the result is compared with a separate solve at the load."""

from __future__ import annotations

import json
import math
import shlex
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import roughcontact as rc
from roughcontact._tools.roots import ACCURACY
from roughcontact.analyses.find import model as load_search
from roughcontact.analyses.find.model import SHARE_ACCURACY
from roughcontact.cli import app
from roughcontact.halfspace.stress_summary import summarize
from roughcontact.report import phrases
from roughcontact.surface import shapes
from roughcontact.theory import hertz

STEEL = rc.Material(210e9, 0.3, 1e9)
HEIGHTS, PIXEL = rc.reference_map(64)
ROUGH = rc.Surface(HEIGHTS, PIXEL)


def fields(result: rc.ContactResult) -> dict[str, float]:
    """Return the possible targets, computed from the maps."""
    touching = np.count_nonzero(result.pressure > 0)
    at_ceiling = np.count_nonzero(result.pressure >= (result.ceiling or math.inf))
    return {
        "contact_fraction": touching / result.pressure.size,
        "saturated_share": at_ceiling / touching,
        "approach": result.approach,
        "mean_gap": np.maximum(result.gap, 0).mean(),
    }


@pytest.mark.long
@settings(max_examples=8, deadline=None)
@given(
    name=st.sampled_from(["approach", "mean_gap"]),
    part=st.floats(0.05, 0.9),
    ceiling=st.sampled_from(["auto", None]),
    boundary=st.sampled_from(["free", "periodic", "periodic-x"]),
)
def test_a_solve_at_the_load_found_has_the_value(
    name: str, part: float, ceiling: str | None, boundary: str
) -> None:
    value = part * float(np.mean(HEIGHTS.max() - HEIGHTS))
    terms = {"material": STEEL, "ceiling": ceiling, "boundary": boundary}
    (answer,) = rc.find_load(ROUGH, **terms, **{name: value}).answers
    forward = rc.solve(ROUGH, load=answer.load, **terms)
    assert fields(forward)[name] == pytest.approx(value, rel=1e-6)
    assert answer.error == pytest.approx(0, abs=ACCURACY)
    assert answer.result.converged
    low, high = answer.bracket
    assert low <= answer.load <= high
    values = answer.bracket_low.value, answer.bracket_high.value
    assert values == pytest.approx((value, value), rel=1.001 * ACCURACY)
    reached = [found <= value if name == "mean_gap" else found >= value for found in values]
    assert reached == [False, True]


@pytest.mark.long
@settings(max_examples=4, deadline=None)
@given(share=st.floats(0.01, 0.6), boundary=st.sampled_from(["free", "periodic"]))
def test_contact_fraction_is_passed_within_bracket(share: float, boundary: str) -> None:
    terms = {"material": STEEL, "boundary": boundary}
    (answer,) = rc.find_load(ROUGH, **terms, contact_fraction=share).answers
    below, above = (
        fields(rc.solve(ROUGH, load=load, **terms))["contact_fraction"] for load in answer.bracket
    )
    assert below < share <= above
    assert (below, above) == (answer.bracket_low.value, answer.bracket_high.value)
    # Both ends are near, or a pixel apart.
    one_pixel = round((above - below) * HEIGHTS.size) <= 1
    assert one_pixel or above - below <= 2.002 * SHARE_ACCURACY * share
    assert answer.load == answer.bracket[1]


@pytest.mark.long
def test_several_targets_share_contacts() -> None:
    one = rc.find_load(ROUGH, material=STEEL, contact_fraction=0.05)
    two = rc.find_load(ROUGH, material=STEEL, contact_fraction=[0.05, 0.05])
    assert two.solves == one.solves
    assert [answer.load for answer in two.answers] == [one.answers[0].load] * 2
    mixed = rc.find_load(ROUGH, material=STEEL, contact_fraction=[0.05, 0.1], approach="300 nm")
    assert [answer.quantity for answer in mixed.answers] == [
        "contact_fraction",
        "contact_fraction",
        "approach",
    ]
    assert mixed.answers[2].target == pytest.approx(300e-9)
    assert mixed.largest.load == max(answer.load for answer in mixed.answers)


@pytest.mark.long
def test_first_yield_load_of_ball_matches_hertz() -> None:
    ball = rc.Surface(shapes.paraboloid((48, 48), (1e-6, 1e-6), 2e-3), (1e-6, 1e-6))
    (answer,) = rc.find_load(ball, material=STEEL, first_yield=True).answers
    expected = hertz.first_yield_load(2e-3, 210e9 / 0.91, STEEL.first_yield_pressure or 0)
    assert answer.load == pytest.approx(expected, rel=0.05)
    assert answer.bracket_low.value < 1 <= answer.bracket_high.value
    assert answer.result.ceiling is None


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_utilization_matches_stress_of_whole_map(boundary: str) -> None:
    contact = rc.solve(ROUGH, material=STEEL, load=0.01, ceiling=None, boundary=boundary)
    whole = summarize(contact.pressure, PIXEL, 0.3, boundary=boundary).max_von_mises
    # In single precision.
    assert load_search._utilization(contact) == pytest.approx(whole / 1e9, rel=1e-5)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_smooth_quantity_needs_few_contacts(boundary: str) -> None:
    for quantity in ({"mean_gap": "300 nm"}, {"approach": "300 nm"}, {"first_yield": True}):
        found = rc.find_load(ROUGH, material=STEEL, boundary=boundary, **quantity)
        assert found.solves <= 6, quantity


def test_unreachable_target_raises_input_error() -> None:
    with pytest.raises(rc.InputError, match="must be below that of the bodies") as caught:
        rc.find_load(ROUGH, material=STEEL, mean_gap=1.0)
    assert caught.value.argument == "mean_gap"
    with pytest.raises(
        rc.InputError, match="not reached at any load: under the smallest"
    ) as caught:
        rc.find_load(ROUGH, material=STEEL, contact_fraction=1e-9)
    assert caught.value.argument == "contact_fraction"
    with pytest.raises(rc.InputError, match="no target"):
        rc.find_load(ROUGH, material=STEEL)
    with pytest.raises(rc.InputError, match="nothing is saturated"):
        rc.find_load(ROUGH, material=STEEL, ceiling=None, saturated_fraction=0.1)
    with pytest.raises(rc.InputError, match="of either body"):
        rc.find_load(ROUGH, material=rc.Material(210e9, 0.3), first_yield=True)
    for given_, name in (
        (0, "contact_fraction"),
        (1.5, "contact_fraction"),
        (-1, "saturated_fraction"),
    ):
        with pytest.raises(rc.InputError, match="share above 0"):
            rc.find_load(ROUGH, material=STEEL, **{name: given_})
    with pytest.raises(rc.InputError, match="positive and finite"):
        rc.find_load(ROUGH, material=STEEL, approach=-1e-6)


@pytest.mark.long
def test_command_prints_table_and_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "map.npy"
    np.save(path, HEIGHTS * 1e6)
    words = [
        "find",
        str(path),
        *shlex.split(
            "--unit um --size '0.1 mm x 0.1 mm' --level none --young '210 GPa' --poisson 0.3 "
            "--yield-strength '1 GPa' --contact-fraction '5 %, 10 %' --approach '300 nm' "
            "--output"
        ),
        str(tmp_path / "loads.csv"),
    ]
    assert app.main(words) == app.SOLVED
    shown = capsys.readouterr().out
    assert all(text in shown for text in ("5 % in contact", "10 % in contact", "approach 300 nm"))
    assert app.main([*words, "--json"]) == app.SOLVED
    record = json.loads(capsys.readouterr().out)
    found = rc.find_load(ROUGH, material=STEEL, contact_fraction=[0.05, 0.1], approach=300e-9)
    assert [one["load"] for one in record["answers"]] == pytest.approx(
        [answer.load for answer in found.answers], rel=1e-5
    )
    head, *lines = (tmp_path / "loads.csv").read_text(encoding="utf-8").splitlines()
    assert head.split(",")[:4] == ["quantity [1]", "unit [1]", "target [1]", "load [N]"]
    assert [line.split(",")[0] for line in lines] == [
        "contact_fraction",
        "contact_fraction",
        "approach",
    ]
    assert float(lines[2].split(",")[3]) == record["answers"][2]["load"]
    assert app.main([*words[:-6], "--mean-gap", "1 m"]) == app.BAD_INPUT
    assert "--mean-gap must be below" in capsys.readouterr().err
    assert app.main(words[:-6]) == app.BAD_INPUT
    assert "no target: give --contact-fraction" in capsys.readouterr().err


def test_shares_are_given_in_per_cent_too() -> None:
    surface, steel = rc.Surface(*rc.reference_map(32)), rc.Material(210e9, 0.3)
    found = rc.find_load(surface, material=steel, contact_fraction="2 %, 5 %")
    same = rc.find_load(surface, material=steel, contact_fraction=[0.02, 0.05])
    assert [answer.load for answer in found.answers] == [answer.load for answer in same.answers]
    with pytest.raises(rc.InputError, match="per cent"):
        rc.find_load(surface, material=steel, contact_fraction="2")


def test_a_bracket_is_the_searches_of_coating_and_base() -> None:
    film = rc.Layer(83e9, 0.37, 5e-6, hardness="264 MPa", name="silver")
    tool = rc.Material(124e9, 0.34, 180e6, coating=[film])
    problem = {"material": tool, "boundary": "periodic", "contact_fraction": 0.05}
    surface = rc.Surface(*rc.reference_map(64))
    both = rc.find_load(surface, ceiling="bracket", **problem)
    loads = [
        rc.find_load(surface, ceiling=name, **problem).answers[0].load
        for name in ("coating", "base")
    ]
    assert both.base is not None
    assert [both.answers[0].load, both.base.answers[0].load] == loads
    assert loads[0] < loads[1]
    record = both.summary()
    assert record["base_answers"][0]["load"] == loads[1]
    # Both ends are in the first line.
    for load in loads:
        assert phrases.format_short(load, "N").split()[0] in str(both).split("wanted")[0]
