"""Tangential loading: arguments, errors, files, command, report."""

from __future__ import annotations

import functools
import json
import shlex
from pathlib import Path

import numpy as np
import pytest
import xarray

import roughcontact as rc
from roughcontact._tools import netcdf
from roughcontact.analyses.tangential.model import dundurs, joint_poisson, shear_strength
from roughcontact.cli import app

STEEL = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
SOFT = rc.Material(young=3e9, poisson=0.4)


@functools.cache
def contact(counter: str = "steel", boundary: str = "free") -> rc.ContactResult:
    heights, pixel = rc.reference_map(32)
    other = {"steel": STEEL, "soft": SOFT, "rigid": rc.Material(np.inf, 0.0)}[counter]
    return rc.solve(
        rc.Surface(heights, pixel),
        material=STEEL,
        counter_material=other,
        load=1.0,
        boundary=boundary,
        calibrated=False,
    )


@functools.cache
def profile() -> rc.ContactResult:
    x = np.arange(128) - 63.5
    heights = 1e-7 * np.cos(x / 5) - (x * 1e-6) ** 2 / 2
    return rc.solve(
        rc.Surface(heights[None], pixel=(1.0, 1e-6)),
        material=STEEL,
        counter_material=STEEL,
        load="20 N/mm",
        calibrated=False,
    )


@pytest.mark.parametrize(
    ("options", "argument"),
    [
        ({"friction": 0.0, "force": 0.05}, "friction"),
        ({"friction": 0.15}, "force"),
        ({"friction": 0.15, "force": 0.05, "shift": 1e-8}, "force"),
        ({"friction": 0.15, "force": float("nan")}, "force"),
        ({"friction": 0.15, "force": "0.05 m"}, "force"),
        ({"friction": 0.15, "stages": [(0.0, 0.05)]}, "stages"),
    ],
)
def test_invalid_options_raise_input_error(options: dict, argument: str) -> None:
    with pytest.raises(rc.InputError) as refused:
        rc.tangential(contact(), **options)
    assert refused.value.argument == argument


@pytest.mark.parametrize("force", [0.15, -0.15, 10.0])
def test_a_force_that_friction_does_not_carry_slides(force: float) -> None:
    with pytest.raises(rc.CapacityError, match="slides at 150 mN"):
        rc.tangential(contact(), friction=0.15, force=force)


def test_a_force_that_is_removed_is_zero() -> None:
    # The sum of the tractions that stay was 4e-17 N.
    result = rc.tangential(contact(), friction=0.15, force=[0.1, 0.0, -0.1, 0.0])
    assert [step.force for step in result.steps] == pytest.approx(
        [0.1, 0.0, -0.1, 0.0], rel=1e-9, abs=0
    )
    assert result.steps[1].shift > 0 > result.steps[3].shift


def test_strip_and_tilt_raise_input_error() -> None:
    with pytest.raises(rc.InputError) as refused:
        rc.tangential(contact(boundary="periodic-x"), friction=0.15, force=0.05)
    assert refused.value.argument == "boundary"
    tilted = rc.solve(
        contact().surface, material=STEEL, load=1.0, moments=(0.0, 0.0), calibrated=False
    )
    with pytest.raises(rc.InputError, match="without tilt"):
        rc.tangential(tilted, friction=0.15, force=0.05)


def test_profile_accepts_line_loads_along_it_only() -> None:
    result = rc.tangential(profile(), friction=0.15, force="1 N/mm")
    assert result.last.force == pytest.approx(1000)
    with pytest.raises(rc.InputError):
        rc.tangential(profile(), friction=0.15, force="1 N")
    with pytest.raises(rc.InputError):
        rc.tangential(profile(), friction=0.15, force="1 N/mm", direction=90.0)
    assert result.plot() is not None
    assert "N/m" in result.to_pandas().attrs["units"]["force"]


def test_constants_of_unlike_bodies() -> None:
    like, unlike, rigid = (contact(name).pair for name in ("steel", "soft", "rigid"))
    assert joint_poisson(like) == pytest.approx(0.3)
    assert joint_poisson(rigid) == pytest.approx(0.3)
    shear = 2.6 / 210e9, 2.8 / 3e9
    assert joint_poisson(unlike) == pytest.approx((0.3 * shear[0] + 0.4 * shear[1]) / sum(shear))
    assert dundurs(like) == 0
    assert dundurs(rigid) == pytest.approx(0.4 / 1.4)
    assert dundurs(unlike) == pytest.approx(
        (0.4 * shear[0] - 0.2 * shear[1]) / (2 * (0.7 * shear[0] + 0.6 * shear[1]))
    )
    assert shear_strength(contact()) == pytest.approx(1e9 / np.sqrt(3))


@pytest.mark.parametrize(("counter", "expected"), [("steel", False), ("rigid", True)])
def test_coupling_of_unlike_bodies_has_a_caution(counter: str, expected: bool) -> None:
    result = rc.tangential(contact(counter), friction=0.15, force=0.05)
    kinds = {caution.kind for caution in result.cautions}
    assert ("unlike-bodies" in kinds) is expected
    assert "junction-growth" in kinds


@pytest.mark.long
def test_files_hold_the_maps_and_the_steps(tmp_path: Path) -> None:
    result = rc.tangential(contact(), friction=0.15, force=[0.05, -0.05, 0.05])
    result.save(tmp_path / "a.nc")
    with xarray.open_dataset(tmp_path / "a.nc") as dataset:
        for axis, field in zip("yx", result.traction, strict=True):
            np.testing.assert_array_equal(dataset[f"traction_{axis}"], field)
        assert dataset["stick"].values.sum() == result.stick.sum()
        np.testing.assert_array_equal(dataset["step_force"], result.column("force"))
        assert netcdf.changed_names(dataset, ["traction_x", "slip_y"]) == ()
    result.save(tmp_path / "a.csv")
    assert len((tmp_path / "a.csv").read_text().splitlines()) >= 4
    result.save(tmp_path / "a.json")
    numbers = json.loads((tmp_path / "a.json").read_text())
    assert numbers["cycle_energy"] == pytest.approx(result.cycle_energy)
    assert numbers["superposition"]["force"][-1] == pytest.approx(0.05)
    with pytest.raises(rc.InputError):
        result.save(tmp_path / "a.txt")


@pytest.mark.long
def test_stress_is_printed_drawn_and_saved(tmp_path: Path) -> None:
    result = rc.tangential(contact(), friction=0.15, force="50 mN", stress=True)
    below = result.fretting
    assert "σ_t τδ" in repr(result)
    # The ceiling is three times the yield strength: pressure alone is enough.
    assert "First yield: under the load alone" in repr(result)
    assert result.summary()["yield_force"] == below.yield_force == 0
    assert result.summary()["max_tension"] == below.stress.max_tension
    assert {"Ruiz1984", "Hamilton1983"} <= {work.key for work in result.references()}
    assert "yielded" in {caution.kind for caution in result.cautions}
    result.report(tmp_path / "a.html")
    assert (tmp_path / "a.html").read_text().count("data:image/png") >= 4
    result.save(tmp_path / "a.nc")
    with xarray.open_dataset(tmp_path / "a.nc") as dataset:
        np.testing.assert_array_equal(dataset["ruiz"], below.ruiz)
        np.testing.assert_array_equal(dataset["von_mises"], below.stress.profile.von_mises)
    assert len(result.plot.fretting().axes) == 2
    line = rc.tangential(profile(), friction=0.15, force="1 N/mm", stress=True)
    assert len(line.plot.fretting().axes) == 2
    assert "at x = " in repr(line)
    with pytest.raises(rc.InputError, match="stress=True"):
        rc.tangential(contact(), friction=0.15, force="50 mN").plot.fretting()


@pytest.mark.long
def test_the_command_writes_and_prints(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    heights, pixel = rc.reference_map(32)
    rc.Surface(heights, pixel).save("map.nc")
    words = shlex.split(
        "tangential map.nc --load '1 N' --material 42CrMo4 --counter-material 42CrMo4 "
        "--friction 0.15"
    )
    assert (
        app.main([*words, "--force", "0.05 N", "--output", "a.nc", "--figure", "a.png", "--json"])
        == 0
    )
    numbers = json.loads(capsys.readouterr().out)
    assert numbers["answer"].startswith("The joint shifts ")
    assert 0 < numbers["stick_fraction"][0] < 1
    assert Path("a.nc").exists()
    assert Path("a.png").exists()
    assert app.main([*words, "--shift", "5 nm", "--stress"]) == 0
    assert "Fretting: " in capsys.readouterr().out
    plain = words[:2] + words[4:]
    capsys.readouterr()
    assert app.main([*plain, "--stages", "0.5 N: 20 mN, 1 N: 0.05 N, 100 MPa: -0.05 N"]) == 0
    output = capsys.readouterr().out
    assert "500 mN  20 mN" in output
    assert "1 N     −50 mN" in output
    for stages in ("1 N", "1 N: 1 m", "1: 1 N"):
        assert app.main([*plain, "--stages", stages]) == 2
        assert "--stages" in capsys.readouterr().err
    assert app.main([*words, "--stages", "1 N: 0.05 N"]) == 2
    assert app.main([*words, "--force", "1 N"]) == 2
    assert "slides" in capsys.readouterr().err
    assert app.main([*words, "--force", "1 N", "--shift", "5 nm"]) == 2
    assert app.main([*words[:-2], "--force", "1 N"]) == 2
