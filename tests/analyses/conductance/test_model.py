import dataclasses
import json
import math
import re
import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughcontact as rc
from paths import ROOT
from roughcontact.analyses.conductance.model import (
    CASES,
    GREENWOOD_RANGE,
    filling_of,
    gap_conductance,
    spreading_resistance,
)
from roughcontact.cautions import CautionTag
from roughcontact.cli import app
from roughcontact.contact.series import ONE_ROUGH_FACE
from roughcontact.material import catalog
from roughcontact.report.presentation import presentation_of
from roughcontact.theory import constriction

STEEL = rc.Material(210e9, 0.3, 1e9)
ROUGH = rc.Surface(*rc.reference_map(64, 3))
RESULT = rc.solve(ROUGH, material=STEEL, load=1.0, boundary="periodic")
COPPER = rc.Conductor("17 nohm m", "400 W/m/K", "copper")


def test_resistances_are_resistivities_over_the_length() -> None:
    found = rc.conductance(RESULT, COPPER, rc.Conductor(40e-9, 160))
    (step,) = found.steps
    assert step.length > 2 * RESULT.stiffness() / RESULT.contact_modulus
    assert step.saturated_area > 0
    assert found.electrical_resistance[0] == pytest.approx(57e-9 / step.length)
    assert found.thermal_resistance[0] == pytest.approx((1 / 400 + 1 / 160) / step.length)
    area = ROUGH.size[0] * ROUGH.size[1]
    assert found.thermal_conductance[0] == pytest.approx(1 / (found.thermal_resistance[0] * area))
    oxide = {item for item in found.cautions if item.kind == CautionTag.OXIDE}
    assert {*found.cautions} == {*RESULT.cautions, ONE_ROUGH_FACE, *oxide}


def test_the_length_is_that_of_the_load_curve() -> None:
    loads = [0.3, 1.0]
    curve = rc.sweep(ROUGH, material=STEEL, loads=loads, boundary="periodic")
    contacts = [rc.solve(ROUGH, material=STEEL, load=w, boundary="periodic") for w in loads]
    found = rc.conductance(reversed(contacts), COPPER, COPPER)
    assert found.column("load").tolist() == loads
    assert found.largest.load == 1.0
    np.testing.assert_allclose(found.column("length"), curve.constriction_length, rtol=1e-3)


def test_a_film_adds_its_resistance() -> None:
    bare = rc.conductance(RESULT, COPPER, COPPER)
    film = rc.conductance(
        RESULT, COPPER, COPPER, electrical_film="1e-12 ohm m^2", thermal_film="1e-6 m^2 K/W"
    )
    added = film.electrical_resistance - bare.electrical_resistance
    assert added == pytest.approx(1e-12 / RESULT.contact_area)
    added = film.thermal_resistance - bare.thermal_resistance
    assert added == pytest.approx(1e-6 / RESULT.contact_area)
    # The reported bound of a disc is none if it is below 32/(3π²) to 1.
    text = " ".join(presentation_of(film).sentences())
    bound = float(re.search(r"disk by at most ([\d.]+) % of the constriction", text)[1])
    assert bound == pytest.approx(100 * (32 / (3 * math.pi**2) - 1), abs=0.05)


def test_one_kind_of_conduction_is_enough() -> None:
    found = rc.conductance(RESULT, "Ti-6Al-4V", rc.Conductor(conductivity=40))
    assert math.isnan(found.electrical_resistance[0])
    assert found.thermal_resistance[0] > 0
    assert "electrical_resistance" not in found.summary()


def test_missing_or_invalid_arguments_raise_input_error() -> None:
    with pytest.raises(rc.InputError, match="known are neither of the body and resistivity and"):
        rc.conductance(RESULT, "PEEK", COPPER)
    with pytest.raises(rc.InputError, match="known are resistivity of the body and conductivity"):
        rc.conductance(RESULT, rc.Conductor(1e-8), rc.Conductor(conductivity=3))
    with pytest.raises(rc.InputError, match="film needs the resistivity of both"):
        rc.conductance(RESULT, rc.Conductor(conductivity=3), COPPER, electrical_film=1e-12)
    with pytest.raises(rc.InputError, match="thermal_film must be zero or positive"):
        rc.conductance(RESULT, COPPER, COPPER, thermal_film=-1.0)
    with pytest.raises(rc.InputError, match="is empty"):
        rc.conductance([], COPPER, COPPER)
    with pytest.raises(rc.InputError, match="conductor must be a Conductor"):
        rc.conductance(RESULT, 17e-9, COPPER)  # type: ignore[arg-type]
    with pytest.raises(rc.InputError, match="'nickle' is not in the catalog"):
        rc.conductance(RESULT, "nickle", COPPER)
    with pytest.raises(rc.InputError, match="resistivity must be positive and finite"):
        rc.Conductor(resistivity=0.0)
    with pytest.raises(rc.InputError, match="conductivity needs a conductivity with its unit"):
        rc.Conductor(conductivity="4 W/m")
    small = rc.Surface(*rc.reference_map(32, 1))
    other = rc.solve(small, material=STEEL, load=1.0)
    with pytest.raises(rc.InputError, match="are of different grids, 64 × 64 points"):
        rc.conductance([RESULT, other], COPPER, COPPER)
    row = rc.Surface(ROUGH.heights[0], ROUGH.pixel[1])
    profile = rc.solve(row, material=STEEL, load=1e3, boundary="periodic")
    with pytest.raises(rc.InputError, match="profile"):
        rc.conductance(profile, COPPER, COPPER)


def test_conductance_without_load_is_zero() -> None:
    none = dataclasses.replace(RESULT, pressure=np.zeros(ROUGH.shape), load=0.0)
    found = rc.conductance(none, COPPER, COPPER)
    assert found.steps[0].length == 0
    assert found.electrical_resistance[0] == math.inf
    assert found.electrical_conductance[0] == 0
    assert math.isnan(found.steps[0].greenwood_length)


def test_a_gap_between_plates_conducts_by_its_width_and_the_jump() -> None:
    air, oil = filling_of("air"), filling_of("oil")
    gap = np.full((8, 8), 1e-6)
    assert gap_conductance(gap, oil) == pytest.approx(0.14 / 1e-6)
    # 2 (2 - 0.9)/0.9 · 2.8/2.4/0.713 free paths of 67.8 nm.
    jump = 2 * 1.1 / 0.9 * 2.8 / 2.4 / 0.713 * 67.8e-9
    assert air.jump == pytest.approx(jump, rel=2e-3)
    assert gap_conductance(gap, air) == pytest.approx(0.0261 / (1e-6 + jump), rel=1e-3)
    # Side by side, and none where the bodies touch.
    gap[:2], gap[2:4] = np.nan, 3e-6
    mean = 0.5 * 0.14 / 1e-6 + 0.25 * 0.14 / 3e-6
    assert gap_conductance(gap, oil) == pytest.approx(mean)
    # Of zero width it conducts what the bodies let through; in vacuum nothing passes.
    assert gap_conductance(np.zeros((2, 2)), oil, 1e-8) == pytest.approx(1e8)
    assert gap_conductance(gap, filling_of("vacuum"), 1e-8) == 0


def test_a_square_spreads_as_the_sum_over_its_parts() -> None:
    # Uniform flux on 40² small squares: mean temperature over flux, edge and 1/k.
    middle = (np.arange(40) + 0.5) / 40
    y, x = (one.ravel() for one in np.meshgrid(middle, middle))
    far = np.hypot(y - y[:, None], x - x[:, None])
    np.fill_diagonal(far, 1 / (4 * math.asinh(1) * 40))
    total = (1 / (2 * math.pi * far)).mean()
    assert spreading_resistance(4.0, 0.5) == pytest.approx(2 * 0.5 * total, rel=4e-3)


def test_gap_filling_adds_to_contact_conductance(tmp_path: Path) -> None:
    found = rc.conductance(RESULT, COPPER, COPPER)
    gap = np.where(RESULT.contact, np.nan, np.fmax(RESULT.gap, 0))
    for name in ("air", "oil"):
        whole, alone = found.filled_conductance(name)[0], found.thermal_conductance[0]
        assert whole > alone
        assert found.summary()[f"thermal_conductance_{name}"] == [whole]
        assert whole - alone <= gap_conductance(gap, filling_of(name))
    # Of a ball, or between bodies of which no conductivity is known, there is no number per area.
    free = rc.conductance(rc.solve(ROUGH, material=STEEL, load=1.0), COPPER, COPPER)
    electrical = rc.conductance(RESULT, rc.Conductor(1e-8), rc.Conductor(1e-8))
    for other in (free, electrical):
        assert "thermal_conductance_air" not in other.summary()
        assert np.isnan(other.filled_conductance("air")).all()


def test_contact_and_gap_are_reported_separately_and_together() -> None:
    alone = rc.conductance(RESULT, COPPER, COPPER)
    for fluid in ("helium", "grease", "0.8 W/m/K", 0.8):
        found = rc.conductance(RESULT, COPPER, COPPER, gap=fluid)
        gap = found.column("filled_gap")
        assert gap > 0
        assert found.thermal_conductance == alone.thermal_conductance
        assert found.joint_conductance == pytest.approx(alone.thermal_conductance + gap)
        assert found.summary()["joint_conductance"] == found.joint_conductance.tolist()
    # A gas at a hundredth of the pressure has a jump a hundred times as wide; a liquid has none.
    thin = rc.conductance(RESULT, COPPER, COPPER, gap="air", gap_pressure="10 mbar")
    assert thin.filling.jump == pytest.approx(100 * filling_of("air").jump)
    assert "joint_conductance" not in alone.summary()


def test_radiation_caution_appears_at_low_conductance() -> None:
    # Black faces at 25 °C exchange 6.01 W/(m² K).
    poor = rc.Conductor(conductivity=1e-2)
    for conductor, expected in ((COPPER, False), (poor, True)):
        found = rc.conductance(RESULT, conductor, conductor, gap="vacuum")
        assert found.radiation == pytest.approx(6.01, rel=1e-3)
        assert (CautionTag.RADIATION in kinds(found)) == expected
    (text,) = (caution for caution in found.cautions if caution.kind == CautionTag.RADIATION)
    assert text.numbers["share"] == pytest.approx(6.01 / found.joint_conductance[0], rel=1e-3)
    hot = rc.conductance(RESULT, COPPER, COPPER, gap="vacuum", temperature="323.15 °C")
    assert hot.radiation == pytest.approx(8 * found.radiation, rel=1e-3)


def test_a_current_heats_the_spots() -> None:
    silver = rc.catalog.entry("silver").conductor
    resistance = rc.conductance(RESULT, silver, silver).electrical_resistance[0]
    # Silver softens at 0.09 V and melts at 0.37 V.
    for voltage, severities in ((1e-3, []), (0.15, ["caution"]), (1.0, ["warning"])):
        found = rc.conductance(RESULT, silver, silver, current=voltage / resistance)
        assert found.voltage[0] == pytest.approx(voltage)
        assert found.hottest[0] == pytest.approx(math.hypot(298.15, voltage / 2 / 2.44e-8**0.5))
        found_caution = [
            caution for caution in found.cautions if caution.kind == CautionTag.HOT_SPOTS
        ]
        assert [str(caution.severity) for caution in found_caution] == severities
    assert np.isnan(rc.conductance(RESULT, silver, silver).voltage).all()
    with pytest.raises(rc.InputError, match="current needs the resistivity of both bodies"):
        rc.conductance(RESULT, rc.Conductor(conductivity=1.0), silver, current=1.0)


def test_incomplete_gap_arguments_raise_input_error() -> None:
    free = rc.solve(ROUGH, material=STEEL, load=1.0)
    for result, bodies, fluid, said in (
        (free, COPPER, "air", 'gap needs boundary="periodic"'),
        (RESULT, rc.Conductor(1e-8), "air", "gap needs the conductivity of both bodies"),
        (RESULT, COPPER, "xenon", "gap must be one of air, nitrogen, helium, argon, oil"),
        (RESULT, COPPER, "0.8 W", "gap needs a conductivity with its unit"),
        (RESULT, COPPER, 0.0, "gap must be positive"),
    ):
        with pytest.raises(rc.InputError, match=said):
            rc.conductance(result, bodies, bodies, gap=fluid)  # type: ignore[arg-type]


def kinds(found: rc.results.Conductance) -> list[str]:
    return [str(caution.kind) for caution in found.cautions]


def test_a_ball_that_was_not_declared_has_no_correlation_of_flat_joints() -> None:
    x = (np.arange(96) - 47.5) * 4e-6
    ball = -(x**2 + x[:, None] ** 2) / 0.02
    bumps = 20e-9 * np.random.default_rng(1).standard_normal((96, 96))
    result = rc.solve(rc.Surface(ball + bumps, (4e-6, 4e-6)), material=STEEL, load=1.0)
    found = rc.conductance(result, COPPER, COPPER)
    assert math.isnan(found.steps[0].correlation_length)
    (caution,) = (caution for caution in found.cautions if caution.kind == CautionTag.CURVED)
    assert caution.numbers["curved"] > 0.95
    # Without its form it is a flat rough face, and so is any that is rough enough.
    flat = rc.Surface(bumps, (4e-6, 4e-6)).leveled("quadric")
    found = rc.conductance(rc.solve(flat, material=STEEL, load=1.0), COPPER, COPPER)
    assert found.steps[0].correlation_length > 0
    assert CautionTag.CURVED not in kinds(found)
    assert CautionTag.CURVED not in kinds(rc.conductance(RESULT, COPPER, COPPER))


def test_greenwood_formula_is_omitted_at_large_contact_fraction() -> None:
    much = rc.solve(ROUGH, material=STEEL, load=12.0, boundary="periodic")
    found = rc.conductance([RESULT, much], COPPER, COPPER)
    assert found.steps[1].contact_area > 0.3 * found.nominal_area
    ratios = found.column("greenwood_length") / found.column("length")
    assert 0.5 < ratios[1] < 0.7
    heads, rows = presentation_of(found).listing()
    column = heads.index("Greenwood")
    assert [row[column] for row in rows] == [f"{ratios[0]:.3g}", "–"]


def test_coarser_grid_gives_change_of_spreading_length() -> None:
    other = rc.solve(ROUGH, material=STEEL, load=1.3, boundary="periodic")
    found = rc.conductance(RESULT, COPPER, COPPER).with_coarser_grid(other)
    assert found.coarser is not None
    assert found.coarser.length > 0.05
    assert found.summary()["coarser"] == dataclasses.asdict(found.coarser)
    same = rc.conductance(RESULT, COPPER, COPPER).with_coarser_grid(RESULT)
    assert same.coarser is not None
    assert same.coarser.length == same.coarser.contact_area == 0


def test_the_scatter_of_the_estimates_is_that_of_the_stored_cases() -> None:
    path = ROOT / "calibration" / "constriction.json"
    cases = json.loads(path.read_text("utf-8"))["cases"]
    assert len(cases) == CASES
    for name, expected in (
        ("correlation", constriction.CORRELATION_RANGE),
        ("greenwood", GREENWOOD_RANGE),
    ):
        found = np.quantile([case[name] for case in cases], (0.025, 0.975))
        assert found == pytest.approx(expected, abs=0.006)


def test_documented_fluids_match_the_catalog() -> None:
    page = (ROOT / "docs" / "howto" / "conductance.md").read_text("utf-8")
    rows = re.findall(r"^\| (\w+)[^|]* \| ([\d.]+) W/\(m K\) \| ([\d.]+)", page, re.MULTILINE)
    assert len(rows) == 6
    for name, conductivity, jump in rows:
        found = filling_of(name)
        for shown, value in ((conductivity, found.conductivity), (jump, 1e6 * found.jump)):
            digits = len(shown.partition(".")[2])
            assert round(value, digits) == float(shown), name


def test_conductance_is_saved_as_csv_and_json(tmp_path: Path) -> None:
    found = rc.conductance(RESULT, COPPER, "6061-T6")
    found.save(tmp_path / "joint.csv")
    head, line = (tmp_path / "joint.csv").read_text("utf-8").splitlines()
    assert head.startswith("load [N],contact_area [m²],saturated_area [m²],spots [1],length [m]")
    assert len(line.split(",")) == len(head.split(","))
    found.save(tmp_path / "joint.json")
    record = json.loads((tmp_path / "joint.json").read_text("utf-8"))
    assert record["thermal_conductance"] == found.thermal_conductance.tolist()
    assert record["body"] == {"name": "copper", "resistivity": 1.7e-8, "conductivity": 400.0}
    assert record["boundary"] == "periodic"


def test_correlation_inputs_are_those_of_the_gap_and_the_softer_body() -> None:
    # A steel of 4 GPa on one of 3 GPa; the flat one is rigid in neither.
    hard, soft = (rc.Material(210e9, 0.3, 1e9, hardness=value) for value in (4e9, 3e9))
    result = rc.solve(
        ROUGH, material=hard, counter_material=soft, load=0.01, boundary="periodic", ceiling=None
    )
    values = rc.conductance(result, COPPER, COPPER).correlation_inputs
    slopes = [np.abs(np.diff(ROUGH.heights, axis=a)).mean() / ROUGH.pixel[a] for a in (0, 1)]
    expected = {
        "sigma": ROUGH.heights.std(),
        "slope": math.hypot(*slopes) / math.sqrt(2),
        "hardness": 3e9,
        "c1": 5.1e9,
        "c2": -0.11,
    }
    assert values == pytest.approx(expected, rel=0.02)


def command(path: Path, *more: str) -> list[str]:
    np.save(path, ROUGH.heights * 1e6)
    return [
        "conductance",
        str(path),
        *shlex.split(
            "--unit um --size '0.1 mm x 0.1 mm' --level none --material 42CrMo4 --boundary periodic"
        ),
        *more,
    ]


@pytest.mark.long
def test_command_prints_table_and_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = command(
        tmp_path / "map.npy",
        *shlex.split(
            "--load '1 N, 0.3 N' --counter-resistivity '17 nohm m' --electrical-film "
            f"'1e-13 ohm m^2' --counter-conductivity '400 W/m/K' --output {tmp_path}/joint.csv "
            f"--figure {tmp_path}/joint.png --report {tmp_path}/joint.html"
        ),
    )
    assert app.main([*words, "--verbose"]) == app.SOLVED
    shown = capsys.readouterr().out
    assert "42CrMo4, ρ 220 nΩ m, k 42.6 W/(m K)" in shown
    assert "that of the joint over one period" in " ".join(shown.split())
    assert (tmp_path / "joint.png").stat().st_size > 1000
    text = (tmp_path / "joint.html").read_text("utf-8")
    assert "How well do heat and current cross the joint" in text
    assert len((tmp_path / "joint.csv").read_text("utf-8").splitlines()) == 3
    assert app.main([*words[:-2], "--json"]) == app.SOLVED
    record = json.loads(capsys.readouterr().out)
    steel = rc.catalog.material("42CrMo4")
    contacts = [rc.solve(ROUGH, material=steel, load=w, boundary="periodic") for w in (0.3, 1.0)]
    found = rc.conductance(contacts, "42CrMo4", COPPER, electrical_film=1e-13)
    assert record["load"] == [0.3, 1.0]
    assert record["electrical_resistance"] == pytest.approx(found.electrical_resistance, rel=1e-3)
    assert record["thermal_resistance"] == pytest.approx(found.thermal_resistance, rel=1e-3)


def test_invalid_options_are_rejected_in_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    load = ("--load", "1 N")
    for more, said in (
        (load, "--counter-conductivity is needed: give --counter-conductivity '46 W/m/K'"),
        ((*load, "--set", "gap-pressure=1 Pa"), "gap-pressure needs --gap"),
        ((*load, "--set", "temperature=300 °C"), "temperature needs --gap"),
        ((*load, "--counter-material", "16MnCr5"), "is needed: 16MnCr5 has none"),
        ((), "--load is needed"),
        (("--load", "1 N, 2"), "--load needs a load"),
        (
            (*load, "--counter-conductivity", "3 W/m/K", "--electrical-film", "1e-12 ohm m^2"),
            "--electrical-film needs --resistivity and --counter-resistivity",
        ),
        ((*load, "--counter-conductivity", "3 W"), "--counter-conductivity needs a conductivity"),
        (
            ("--load", "0.1 N, 1 MN", "--counter-material", "6061-T6"),
            "= 1e+06 N is more than the surface can carry",
        ),
    ):
        assert app.main(command(tmp_path / "map.npy", *more)) == app.BAD_INPUT
        assert said in capsys.readouterr().err


def test_the_calibrated_ceiling_moves_the_interval_of_a_conductance() -> None:
    surface = rc.Surface(*rc.reference_map(64))
    steel = rc.Material(210e9, 0.3, 1e9)
    given = {"material": steel, "load": 1.0, "boundary": "periodic", "calibrated": False}
    first, lower = (rc.solve(surface, **given, ceiling=p) for p in ("auto", 2.5e9))
    found = rc.conductance(first, COPPER, COPPER).with_calibrated_ceiling(lower)
    other = rc.conductance(lower, COPPER, COPPER)
    assert found.calibrated is not None
    (change,) = found.calibrated.numbers
    assert other.steps[-1].length / found.steps[-1].length - 1 == pytest.approx(change)
    summary = found.summary()["interval"]
    assert summary["low"] < found.steps[-1].length * (1 + change) < summary["high"]


# --- layers, films


def conduct_plated(*layers: rc.Layer, ceiling: object = "base", **more: object) -> Any:
    """Return the conductance of plated copper on copper."""
    plated = dataclasses.replace(STEEL, coating=layers)
    result = rc.solve(ROUGH, material=plated, load=0.3, ceiling=ceiling if layers else "auto")
    return rc.conductance(result, "Cu-ETP", "Cu-ETP", **more)


def plating(metal: str, thickness: float) -> rc.Layer:
    # Mechanics of the base, so that the outline of the contact does not change.
    return rc.Layer(STEEL.young, STEEL.poisson, thickness, yield_strength=1e9, name=metal)


def test_thin_layer_changes_nothing_and_thick_one_is_the_body() -> None:
    bare, thin, thick = (
        conduct_plated(),
        *(conduct_plated(plating("nickel", t)) for t in (1e-12, 5e-3)),
    )
    assert thin.electrical_resistance == pytest.approx(bare.electrical_resistance, rel=1e-4)
    nickel, copper = (catalog.conductor_of(name) for name in ("nickel", "Cu-ETP"))
    both = (nickel.resistivity + copper.resistivity) / thick.steps[0].length
    assert thick.electrical_resistance[0] == pytest.approx(both, rel=0.01)
    middle = conduct_plated(plating("nickel", 2e-6)).electrical_resistance[0]
    assert bare.electrical_resistance[0] < middle < thick.electrical_resistance[0]


def test_layer_without_conductivity_raises_input_error() -> None:
    with pytest.raises(rc.InputError, match="DLC has no conductivity in the catalog"):
        conduct_plated(plating("DLC", 1e-6))


def test_oxide_is_named_unless_faces_are_gold_or_have_a_film() -> None:
    def kinds(found: Any) -> set[str]:
        return {caution.kind for caution in found.cautions}

    assert CautionTag.OXIDE in kinds(conduct_plated())
    assert CautionTag.OXIDE not in kinds(conduct_plated(electrical_film="1e-12 ohm m^2"))
    assert CautionTag.OXIDE not in kinds(rc.conductance(RESULT, "gold", "hard gold"))


def test_indentation_deeper_than_the_layer_gives_caution() -> None:
    thin, thick = (conduct_plated(plating("nickel", t)).largest.cautions for t in (1e-9, 1e-5))
    assert CautionTag.THIN_COATING in {caution.kind for caution in thin}
    assert CautionTag.THIN_COATING not in {caution.kind for caution in thick}
