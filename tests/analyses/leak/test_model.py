import dataclasses
import json
import math
import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.analyses.conductance.model import slip_factor
from roughcontact.analyses.leak.flow import flow, flow_gap
from roughcontact.analyses.leak.model import MIN_FLUID_SHARE
from roughcontact.analyses.leak.task import GAS
from roughcontact.cautions import CautionTag
from roughcontact.cli import app
from roughcontact.material import fluids
from roughcontact.report.presentation import presentation_of
from roughcontact.uncertainty.intervals import Cause

STEEL = rc.Material(210e9, 0.3, 1e9)
ROUGH = rc.Surface(*rc.reference_map(64, 3))
RESULT = rc.solve(ROUGH, material=STEEL, load=1.0, boundary="periodic")
WATER = {"viscosity": "1 mPa s", "pressure_difference": "1 bar"}


def near(expected: Any, rel: float = 1e-6) -> Any:
    """Return a relative tolerance: numbers are small in SI units, and 1e-12 is much."""
    return pytest.approx(expected, rel=rel, abs=0.0)


def test_numbers_are_those_of_the_flow_through_the_gap() -> None:
    found = rc.leakage(RESULT, **WATER)
    (step,) = found.steps
    gap = flow_gap(RESULT)
    assert (gap[RESULT.contact] == 0).all()
    for axis in (0, 1):
        k = flow(gap, ROUGH.pixel, axis, (0, 1)).permeability
        assert (step.permeability[0][axis], step.permeability[1][axis]) == k
        assert found.flow_factor(axis)[0] == near(k[axis] / RESULT.mean_gap**3)
        # A square map: width and length are the same.
        assert found.rate(axis)[0] == near(k[axis] * 1e5 / (12 * 1e-3))
        place = step.constriction[axis]
        assert place is not None
        assert gap[place.place] == place.gap == found.critical_gap(axis)[0]
        assert 0 < place.gap < gap.max()
    assert found.gap_ratio[0] == near(RESULT.mean_gap / np.std(RESULT.initial_gap))
    assert step.unbalanced <= 1e-8
    assert found.largest is RESULT


def test_rate_scales_with_seal_size_and_fluid() -> None:
    of_map = rc.leakage(RESULT, flow_axis="x", **WATER)
    ring = rc.leakage(RESULT, flow_axis="x", **WATER, seal_width="20 mm", seal_length="2 mm")
    assert ring.rate(1)[0] == near(10 * of_map.rate(1)[0])
    oil = rc.leakage(RESULT, flow_axis="x", viscosity=0.1, pressure_difference=2e5)
    assert oil.rate(1)[0] == near(0.02 * of_map.rate(1)[0])
    assert math.isnan(ring.rate(0)[0])
    assert math.isnan(rc.leakage(RESULT, flow_axis="x").rate(1)[0])


def test_loads_close_the_gap_and_a_ceiling_closes_it_more() -> None:
    loads = [0.3, 3.0, 1.0]
    ceiling, elastic = (
        rc.leakage(
            rc.solve(ROUGH, material=STEEL, load=w, boundary="periodic", ceiling=limit)
            for w in loads
        )
        for limit in (3e9, None)
    )
    assert ceiling.column("load").tolist() == sorted(loads)
    assert ceiling.largest.load == 3.0
    for axis in (0, 1):
        assert (np.diff(ceiling.permeability(axis)) < 0).all()
        assert (np.diff(ceiling.critical_gap(axis)) < 0).all()
        assert (ceiling.permeability(axis) < elastic.permeability(axis)).all()


HELIUM = {"viscosity": 19.6e-6, "pressure_difference": 1e5}


def test_a_gas_between_plates_slips_by_the_closed_form() -> None:
    # Flow between plates with slip of λ ∂u/∂z at the walls: g³/12 + g² λ/2, of g³/12.
    path = 0.2e-6
    gap = np.full((8, 12), 1e-6)
    for axis in (0, 1):
        driven = flow(gap, (1e-6, 1e-6), axis, (0, 1)).density
        assert slip_factor(gap, driven, path) == near((1e-18 / 12 + 1e-12 * path / 2) * 12 / 1e-18)
    # Gaps one after the other, where all the flow passes each of them.
    gap[:, ::2] = 0.3e-6
    bare = flow(gap, (1e-6, 1e-6), 1, (0, 1))
    slipping = flow((gap**3 + 6 * path * gap**2) ** (1 / 3), (1e-6, 1e-6), 1, (0, 1))
    expected = slipping.permeability[1] / bare.permeability[1]
    assert slip_factor(gap, bare.density, path) == near(expected, rel=0.06)
    assert math.isnan(slip_factor(np.zeros((4, 4)), np.zeros((4, 4)), path))


def test_gas_slip_gives_rarefied_caution() -> None:
    found = rc.leakage(RESULT, **HELIUM)
    (caution,) = (caution for caution in found.cautions if caution.kind == CautionTag.RAREFIED)
    # λ = η/p √(π R T/2M) at 20 °C.
    speed = math.sqrt(math.pi * 8.314462618 * 293.15 / 2)
    for name, mass, p in (("air", 28.96e-3, 151325.0), ("helium", 4.003e-3, 5e4)):
        path = 19.6e-6 / p * speed / math.sqrt(mass)
        gap = flow_gap(RESULT)
        factors = [slip_factor(gap, one.density, path) for one in found.flows]
        assert caution.numbers[name] == near(max(factors))
    assert caution.numbers["knudsen"] == near((caution.numbers["air"] - 1) / 6)
    assert caution.numbers["helium"] > 2
    # A liquid does not slip, and without a rate there is no caution.
    for other in (rc.leakage(RESULT, **WATER), rc.leakage(RESULT)):
        assert CautionTag.RAREFIED not in [caution.kind for caution in other.cautions]
    # Under a high pressure the molecules are near each other.
    dense = rc.leakage(RESULT, viscosity=19.6e-6, pressure_difference=1e9)
    assert CautionTag.RAREFIED not in [caution.kind for caution in dense.cautions]


SEAL = {"gas": "helium", "inlet": "2 bar", "outlet": "1 mbar", "temperature": "20 °C"}


def test_a_named_gas_leaks_in_units_of_leak_detection() -> None:
    found = rc.leakage(RESULT, **SEAL, ring="40 mm", seal_length="2 mm")
    viscosity = 20e-6 * (293.15 / 300) ** 0.69
    for axis in (0, 1):
        factor = found.steps[0].gas_factor[axis]
        assert factor > 5
        face = math.pi / math.atanh(2 / 40)
        viscous = found.permeability(axis)[0] * face / (24 * viscosity) * (4e10 - 1e4)
        flow = found.throughput(axis)[0]
        assert flow == near(factor * viscous)
        assert found.throughput(axis, "mbar l/s")[0] == near(10 * flow)
        # One Pa m³ at 20 °C holds 1/(R T) mol; a mole fills 22,414 standard cubic centimeters.
        moles = flow / (8.314462618 * 293.15)
        assert found.throughput(axis, "kg/s")[0] == near(4.003e-3 * moles)
        assert found.throughput(axis, "sccm")[0] == near(60 * 22413.97 * moles)
        assert found.summary()[f"throughput_{'yx'[axis]}"] == [flow]
    # Slip is in the rate, without a caution; the gap is unchanged.
    assert CautionTag.RAREFIED not in [caution.kind for caution in found.cautions]
    assert found.permeability(0) == rc.leakage(RESULT).permeability(0)
    # A dense gas is viscous: its volume at the mean pressure is that of a liquid as thin.
    dense = {"inlet": "2001 bar", "outlet": "2000 bar", "gas": "helium"}
    viscosity = 20e-6 * (298.15 / 300) ** 0.69
    liquid = rc.leakage(RESULT, viscosity=viscosity, pressure_difference=1e5)
    assert rc.leakage(RESULT, **dense).rate(0) == near(liquid.rate(0), rel=5e-3)


def test_gas_option_lists_catalog_gases() -> None:
    gases = [row.name for row in fluids.entries().values() if isinstance(row, fluids.Gas)]
    assert list(GAS.parse.known) == gases  # type: ignore[attr-defined]


def test_seal_of_known_size_has_class_of_larger_leak() -> None:
    surface = rc.Surface(ROUGH.heights[::2, ::2], (2 * ROUGH.pixel[0], 2 * ROUGH.pixel[1]))
    small = rc.solve(surface, material=STEEL, load=1.0, boundary="periodic")
    assert rc.leakage(small, **SEAL).leak_class is None
    assert rc.leakage(small, **WATER, ring="40 mm").leak_class is None
    test = {"gas": "helium", "inlet": "1 bar", "outlet": "1 mbar"}
    # Classes are for the gas and the pressures of their test alone.
    for other in ({"gas": "air"}, {"inlet": "2 bar"}, {"inlet": "0.5 bar"}, {"outlet": "0.5 bar"}):
        found = rc.leakage(small, **(test | other), ring="40 mm")
        assert found.leak_class is None
        assert found.throughput(0)[0] > 0
        assert "Class" not in str(found)
    atmosphere = test | {"inlet": 101325.0, "outlet": 1.0}
    assert rc.leakage(small, **atmosphere, ring="40 mm").leak_class is not None
    for width, expected in (
        ("1 m", "not watertight"),
        ("40 mm", "watertight"),
        ("1 um", "gas-tight"),
    ):
        found = rc.leakage(small, **test, seal_width=width, seal_length="2 mm")
        name, limit = found.leak_class
        assert name.startswith(expected)
        assert max(found.throughput(axis)[0] for axis in (0, 1)) < limit


def test_a_fluid_that_carries_the_load_opens_the_gap() -> None:
    area = ROUGH.size[0] * ROUGH.size[1]
    for difference, carried in (("1 bar", 5e4), ("200 bar", 1e7)):
        found = rc.leakage(RESULT, viscosity=1e-3, pressure_difference=difference)
        assert found.fluid_share[0] == near(carried * area / 1.0)
        found_caution = [
            caution for caution in found.cautions if caution.kind == CautionTag.FLUID_PRESSURE
        ]
        assert bool(found_caution) == (found.fluid_share[0] > MIN_FLUID_SHARE)
    fluid = carried * area
    rest = rc.solve(ROUGH, material=STEEL, load=1.0 - fluid, boundary="periodic")
    opened = rc.leakage(rest, viscosity=1e-3, pressure_difference="200 bar")
    assert opened.rate(0) > 1.05 * found.rate(0)


@pytest.mark.parametrize("load", [0.3, 8.0, 12.0])
def test_neglected_share_of_fluid_is_within_the_interval(load: float) -> None:
    coarser = ROUGH.resampled(pixel=(2 * ROUGH.pixel[0], 2 * ROUGH.pixel[1]))
    whole, rest, coarse = (
        rc.solve(surface, material=STEEL, load=part * load, boundary="periodic")
        for surface, part in ((ROUGH, 1), (ROUGH, 1 - MIN_FLUID_SHARE), (coarser, 1))
    )
    found = rc.leakage(whole, **WATER).with_coarser_grid(coarse)
    after = rc.leakage(rest, **WATER)
    for axis, interval in enumerate(found.summary()["intervals"]):
        assert found.permeability(axis)[0] < after.permeability(axis)[0] < interval["high"]


def test_blocked_direction_has_zero_leak_rate() -> None:
    wall = RESULT.pressure.copy()
    wall[20] = 1e6
    closed = dataclasses.replace(RESULT, pressure=wall)
    found = rc.leakage(closed, **WATER)
    assert found.permeability(0)[0] == found.rate(0)[0] == found.critical_gap(0)[0] == 0
    assert found.permeability(1)[0] > 0
    (row,) = (row for row in presentation_of(found).rows() if row.key == "narrowest_y")
    assert row.text == "no way through"
    assert found.summary()["narrowest_y"] is None


def test_without_contact_the_gap_is_open() -> None:
    none = dataclasses.replace(RESULT, pressure=np.zeros(ROUGH.shape), load=0.0)
    found = rc.leakage(none)
    assert found.permeability(0)[0] > 0
    assert CautionTag.OPEN_GAP in [caution.kind for caution in found.cautions]


def test_near_the_threshold_one_constriction_decides() -> None:
    result = rc.solve(ROUGH, material=STEEL, load=24.0, ceiling=8e9, boundary="periodic")
    assert 0.32 < result.contact_fraction < 0.52
    assert CautionTag.NEAR_THRESHOLD in {caution.kind for caution in rc.leakage(result).cautions}


def test_coarser_grid_gives_change_of_permeability() -> None:
    coarse = rc.Surface(ROUGH.heights[::2, ::2], tuple(2 * edge for edge in ROUGH.pixel))
    other = rc.solve(coarse, material=STEEL, load=1.0, boundary="periodic")
    found = rc.leakage(RESULT, flow_axis="y").with_coarser_grid(other)
    assert found.coarser is not None
    k, coarser = (one.permeability(0)[0] for one in (found, rc.leakage(other, flow_axis="y")))
    assert found.coarser.permeability[0] == near(coarser / k - 1)
    assert math.isnan(found.coarser.permeability[1])


def test_missing_or_invalid_arguments_raise_input_error() -> None:
    for given, said in (
        ({"flow_axis": "z"}, "flow_axis must be 'y' or 'x'"),
        ({"viscosity": 1e-3}, "pressure_difference is needed for a leak rate"),
        ({"pressure_difference": 1e5}, "viscosity is needed for a leak rate"),
        ({"seal_width": 1e-2}, "viscosity is needed for a leak rate"),
        ({**WATER, "viscosity": 0.0}, "viscosity must be positive"),
        ({**WATER, "viscosity": "1 mPa"}, "viscosity needs a viscosity with its unit"),
        ({**WATER, "seal_length": -1.0}, "seal_length must be positive"),
        ({"gas": "helium"}, "inlet is needed for a leak rate, such as '2 bar'"),
        ({**SEAL, "gas": "xenon"}, "gas must be one of air, nitrogen, helium, argon"),
        ({**SEAL, "outlet": "3 bar"}, "outlet must be below the inlet pressure"),
        ({**SEAL, "viscosity": 1e-5}, "viscosity cannot be combined with gas"),
        ({"inlet": 1e5}, 'inlet needs gas="helium"'),
        ({**SEAL, "temperature": "20 C"}, "temperature needs a temperature with its unit"),
        ({**SEAL, "ring": 0.04, "seal_width": 0.1}, "seal_width cannot be combined with ring"),
        ({**SEAL, "ring": 0.04, "seal_length": 0.04}, "seal_length must be below the diameter"),
    ):
        with pytest.raises(rc.InputError, match=said):
            rc.leakage(RESULT, **given)  # type: ignore[arg-type]
    with pytest.raises(rc.InputError, match="is empty"):
        rc.leakage([])
    other = rc.solve(rc.Surface(*rc.reference_map(32, 1)), material=STEEL, load=1.0)
    with pytest.raises(rc.InputError, match="are of different grids, 64 × 64 points"):
        rc.leakage([RESULT, other])
    row = rc.Surface(ROUGH.heights[0], ROUGH.pixel[1])
    profile = rc.solve(row, material=STEEL, load=1e3, boundary="periodic")
    with pytest.raises(rc.InputError, match="profile"):
        rc.leakage(profile)


def test_leakage_is_saved_as_csv_and_json(tmp_path: Path) -> None:
    found = rc.leakage(RESULT, **WATER)
    found.save(tmp_path / "leak.csv")
    head, line = (tmp_path / "leak.csv").read_text("utf-8").splitlines()
    assert "permeability_y [m³],flow_factor_y [1],critical_gap_y [m],leak_rate_y [m³/s]" in head
    assert len(line.split(",")) == len(head.split(","))
    found.save(tmp_path / "leak.json")
    record = json.loads((tmp_path / "leak.json").read_text("utf-8"))
    assert record["leak_rate_x"] == found.rate(1).tolist()
    assert record["permeability_tensor"][0][0][1] == near(record["permeability_yx"][0])
    assert record["sealing"]["viscosity"] == 1e-3
    assert record["boundary"] == "periodic"


def command(path: Path, *more: str) -> list[str]:
    np.save(path, ROUGH.heights * 1e6)
    return [
        "leak",
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
            "--load '1 N, 0.3 N' --viscosity '1 mPa s' --pressure-difference '1 bar' "
            f"--seal-width '20 mm' --seal-length '2 mm' --output {tmp_path}/leak.csv "
            f"--figure {tmp_path}/leak.png --report {tmp_path}/leak.html"
        ),
    )
    assert app.main([*words, "--verbose"]) == app.SOLVED
    shown = " ".join(capsys.readouterr().out.split())
    assert "η 1 mPa s, Δp 100 kPa, width 20 mm, length 2 mm" in shown
    assert "Narrowest place along y" in shown
    assert "Flow out of balance" in shown
    assert (tmp_path / "leak.png").stat().st_size > 1000
    assert "How much leaks past" in (tmp_path / "leak.html").read_text("utf-8")
    assert len((tmp_path / "leak.csv").read_text("utf-8").splitlines()) == 3
    assert app.main([*words[:-2], "--json"]) == app.SOLVED
    record = json.loads(capsys.readouterr().out)
    steel = rc.catalog.material("42CrMo4")
    contacts = [rc.solve(ROUGH, material=steel, load=w, boundary="periodic") for w in (0.3, 1.0)]
    found = rc.leakage(contacts, **WATER, seal_width=20e-3, seal_length=2e-3)
    assert record["load"] == [0.3, 1.0]
    assert record["leak_rate_y"] == near(found.rate(0), rel=1e-3)
    assert record["coarser"]["pixel"] == near(2 * ROUGH.pixel[0])


def test_bracket_shows_both_ceilings(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = command(tmp_path / "map.npy", "--load", "30 MPa, 100 MPa", "--coating", "silver 5 um")
    words += ["--viscosity", "1 mPa s", "--pressure-difference", "1 bar", "--set", "flow-axis=y"]

    def output_under(ceiling: str, *more: str) -> Any:
        assert app.main([*words, "--ceiling", ceiling, *more]) == app.SOLVED
        return capsys.readouterr().out

    coating, base, both = (
        json.loads(output_under(c, "--json")) for c in ("coating", "base", "bracket")
    )
    assert base["leak_rate_y"][-1] > 1.1 * coating["leak_rate_y"][-1]
    for key in ("contact_area", "mean_gap", "permeability_y", "leak_rate_y"):
        assert both[key] == coating[key]
        assert both[f"base_{key}"] == base[key]
        assert f"base_{key}" not in coating
    (interval,) = both["intervals"]
    low, high = interval["causes"][Cause.YIELDING]
    assert low == 0
    assert high == near(base["leak_rate_y"][-1] / coating["leak_rate_y"][-1] - 1, rel=1e-3)
    shown = " ".join(output_under("bracket").split())
    assert "contact (base) leak along y leak along y (base)" in shown
    assert "Ceiling of the coating: It leaks" in shown
    assert "Ceiling of the base: It leaks" in shown


def test_invalid_options_are_rejected_in_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    load = ("--load", "1 N")
    for more, said in (
        ((), "--load is needed"),
        ((*load, "--set", "flow-axis=z"), "--set flow-axis"),
        ((*load, "--viscosity", "1 mPa s"), "--pressure-difference is needed for a leak rate"),
        ((*load, "--seal-width", "1 mm"), "--viscosity is needed for a leak rate"),
        (
            (*load, "--viscosity", "0 Pa s", "--pressure-difference", "1 bar"),
            "--viscosity must be positive",
        ),
        ((*load, "--viscosity", "1 mPa"), "--viscosity needs a viscosity with its unit"),
    ):
        assert app.main(command(tmp_path / "map.npy", *more)) == app.BAD_INPUT
        assert said in capsys.readouterr().err


@pytest.mark.long
def test_the_command_opens_the_gap_by_the_pressure_of_a_gas(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = command(
        tmp_path / "map.npy",
        *shlex.split(
            "--load '30 MPa' --gas helium --inlet '100 bar' --outlet '1 bar' --ring '40 mm' "
            "--seal-length '2 mm' --set flow-axis=x"
        ),
    )
    assert app.main(words) == app.SOLVED
    shown = " ".join(capsys.readouterr().out.split())
    for text in ("Helium leaks", "No leak class", "sccm", "(included)"):
        assert text in shown
    assert app.main([*words, "--json"]) == app.SOLVED
    record = json.loads(capsys.readouterr().out)
    mean = 2 / 3 * (100**3 - 1) / (100**2 - 1) * 1e5 - 1e5
    assert record["fluid_share"] == [near(mean / 30e6, rel=1e-3)]
    steel = rc.catalog.material("42CrMo4")
    load = 0.3 - mean * 1e-8
    rest = rc.solve(ROUGH, material=steel, load=load, boundary="periodic")
    found = rc.leakage(
        rest, gas="helium", inlet=1e7, outlet=1e5, ring=0.04, seal_length=2e-3, flow_axis="x"
    )
    assert record["load"] == [near(0.3, rel=1e-3)]
    assert record["throughput_x"] == near(found.throughput(1), rel=1e-3)
    words[words.index("30 MPa")] = "5 MPa"
    assert app.main(words) == app.BAD_INPUT
    assert "lifts the bodies" in capsys.readouterr().err
