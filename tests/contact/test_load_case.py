"""Loads as engineers have them: forces, pressures on the map, loads per length, Hertz's peaks."""

from __future__ import annotations

import json
import math
import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.batch import project
from roughcontact.cli import app
from roughcontact.contact import load_case
from roughcontact.contact.pair import Pair
from roughcontact.request.options import LOAD
from roughcontact.surface import nominal_bodies
from roughcontact.theory import hertz

STEEL = rc.Material(210e9, 0.3)
MODULUS = 210e9 / 0.91
GRID: dict[str, Any] = {"shape": (64, 48), "pixel": (1e-6, 0.5e-6)}
# Its length along x is 24 µm, along y 64 µm.
ROLLER = nominal_bodies.cylinder(radius=0.01, **GRID)
ROUGH = rc.Surface(1e-9 * np.random.default_rng(1).standard_normal(GRID["shape"]), GRID["pixel"])

Capture = pytest.CaptureFixture[str]


def pair(surface: rc.Surface, counter: rc.Surface | None = None) -> Pair:
    return Pair(surface, STEEL, counter)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("50 N", 50.0),
        ("20 MPa", rc.NominalPressure(20e6)),
        ("20 N/mm^2", rc.NominalPressure(20e6)),
        ("600 N/mm", rc.LineLoad(6e5)),
        ("0.6 kN/mm", rc.LineLoad(6e5)),
        ("hertz 1.5 GPa", rc.HertzPressure(1.5e9)),
        ("Hertz 1500 MPa", rc.HertzPressure(1.5e9)),
    ],
)
def test_a_text_is_a_load_by_its_unit(text: str, value: object) -> None:
    assert load_case.parse_load(text) == value
    assert load_case.parse_required_load(text, "load") == value


def test_a_quantity_of_pint_is_a_load_by_its_unit() -> None:
    import pint

    unit = pint.UnitRegistry()
    assert load_case.parse_load(20 * unit.MPa) == rc.NominalPressure(20e6)
    assert load_case.parse_load(600 * unit.N / unit.mm) == rc.LineLoad(6e5)
    assert load_case.parse_load(5 * unit.kN) == 5e3
    with pytest.raises(rc.InputError, match="force"):
        load_case.parse_load(5 * unit.s)


@pytest.mark.parametrize("text", ["5", "5 m", "hertz 5 N", "hertz", "-20 MPa", "0 N/mm", "0 N"])
def test_invalid_load_raises_input_error(text: str) -> None:
    with pytest.raises(rc.InputError) as refused:
        load_case.parse_required_load(text, "load")
    assert refused.value.argument == "load"


@pytest.mark.parametrize("form", [rc.NominalPressure, rc.LineLoad, rc.HertzPressure])
def test_a_form_needs_a_positive_number_of_its_dimension(form: Any) -> None:
    for wrong in (0.0, -1.0, math.inf, math.nan, "3 m", None):
        with pytest.raises(rc.InputError):
            form(wrong)


def test_the_force_of_each_form() -> None:
    area = 64e-6 * 24e-6
    assert (
        load_case.force_on_pair(rc.NominalPressure("20 MPa"), pair(ROUGH)) == 20e6 * 64e-6 * 24e-6
    )
    assert load_case.force_on_pair(rc.LineLoad("600 N/mm"), pair(ROLLER)) == pytest.approx(
        6e5 * 24e-6
    )
    upright = nominal_bodies.cylinder(radius=0.01, angle=90, **GRID)
    assert load_case.force_on_pair(rc.LineLoad("600 N/mm"), pair(upright)) == pytest.approx(
        6e5 * 64e-6
    )
    line = hertz.line_load(1e9, 0.01, MODULUS) * 64e-6
    assert load_case.force_on_pair(
        rc.HertzPressure("1 GPa"), pair(ROUGH, upright)
    ) == pytest.approx(line)
    ball = nominal_bodies.sphere(radius=0.01, **GRID)
    expected = hertz.load_at_pressure(1e9, 0.01, MODULUS)
    assert load_case.force_on_pair(rc.HertzPressure("1 GPa"), pair(ball)) == pytest.approx(expected)
    # Two parallel cylinders are one of their relative radius, crossed ones an ellipse.
    parallel = hertz.line_load(1e9, 0.005, MODULUS) * 24e-6
    assert load_case.force_on_pair(rc.HertzPressure(1e9), pair(ROLLER, ROLLER)) == pytest.approx(
        parallel
    )
    crossed = load_case.force_on_pair(rc.HertzPressure(1e9), pair(ROLLER, upright))
    assert crossed == pytest.approx(expected, rel=1e-9)
    barrel = nominal_bodies.ellipsoid(radii=(0.004, 0.03), angle=20, **GRID)
    ellipse = hertz.elliptic_load(1e9, (0.03, 0.004), MODULUS)
    assert load_case.force_on_pair(rc.HertzPressure(1e9), pair(barrel)) == pytest.approx(ellipse)
    assert area > 0


@pytest.mark.parametrize(
    ("form", "surface", "found"),
    [
        (rc.LineLoad(1.0), ROUGH, "no curved one"),
        (rc.HertzPressure(1.0), ROUGH, "no curved one"),
        (rc.LineLoad(1.0), nominal_bodies.sphere(radius=0.01, **GRID), "touch in a circle"),
        (
            rc.LineLoad(1.0),
            nominal_bodies.ellipsoid(radii=(1e-2, 2e-2), **GRID),
            "touch in an ellipse",
        ),
        (rc.HertzPressure(1.0), nominal_bodies.cone(slope=0.01, **GRID), "no curved one"),
        (rc.LineLoad(1.0), nominal_bodies.cylinder(radius=0.01, angle=30, **GRID), "at 30 degrees"),
        (
            rc.HertzPressure(1.0),
            nominal_bodies.cylinder(radius=0.01, angle=30, **GRID),
            "at 30 degrees",
        ),
    ],
)
def test_load_form_unfit_for_bodies_raises_input_error(
    form: Any, surface: rc.Surface, found: str
) -> None:
    with pytest.raises(rc.InputError, match=found) as refused:
        rc.solve(surface, material=STEEL, load=form)
    assert refused.value.argument == "load"
    assert "needs a nominal" in str(refused.value)


@pytest.mark.parametrize("load", ["20 MPa", rc.LineLoad("2 N/mm"), "hertz 200 MPa"])
def test_result_keeps_specified_load(load: Any, tmp_path: Path) -> None:
    result = rc.solve(ROLLER, material=STEEL, load=load, boundary="periodic-x")
    assert result.specified_load is not None
    assert result.specified_load.form == load_case.parse_load(load)
    assert (
        result.load
        == result.specified_load.force
        == load_case.force_on_pair(result.specified_load.form, result.pair)
    )
    summary = result.summary()["given_load"]
    assert summary["load"] == result.load
    assert summary["value"] == result.specified_load.form.value
    result.save(tmp_path / "out.nc")
    assert rc.read_result(tmp_path / "out.nc").specified_load == result.specified_load
    plain = rc.solve(ROLLER, material=STEEL, load=result.load, boundary="periodic-x")
    assert plain.specified_load is None
    assert plain.summary()["given_load"] is None
    assert plain.pressure.tobytes() == result.pressure.tobytes()


def test_curves_and_histories_accept_every_form() -> None:
    options: dict[str, Any] = {"material": rc.Material(210e9, 0.3, 1e9), "boundary": "periodic-x"}
    curve = rc.sweep(ROLLER, loads=["5 MPa", rc.NominalPressure("20 MPa")], **options)
    area = ROLLER.size[0] * ROLLER.size[1]
    assert [step.load for step in curve.steps] == pytest.approx([5e6 * area, 20e6 * area])
    assert [one.form.value for one in curve.specified_load] == [5e6, 20e6]
    assert [one["form"] for one in curve.summary()["given_loads"]] == 2 * ["nominal pressure"]
    with pytest.raises(rc.InputError, match="ascend"):
        rc.sweep(ROLLER, loads=["5 MPa", "1 nN"], **options)
    history = rc.history(ROLLER, ["hertz 300 MPa", 0.0, rc.Stage("2 N/mm")], **options)
    force = hertz.line_load(300e6, 0.01, MODULUS) * 24e-6
    assert [step.load for step in history.steps] == pytest.approx([force, 0.0, 2e3 * 24e-6])
    assert [type(one.form) for one in history.specified_load] == [rc.HertzPressure, rc.LineLoad]
    assert history.summary()["given_loads"][1]["value"] == 2e3


def test_profile_accepts_loads_per_length() -> None:
    x = (np.arange(200) - 99.5) * 1e-6
    profile = rc.Surface(-(x**2) / 0.02, 1e-6)
    asked = {form: rc.solve(profile, material=STEEL, load=form) for form in ("20 N/mm", "100 MPa")}
    assert [one.load for one in asked.values()] == pytest.approx([2e4, 100e6 * 200e-6])
    assert asked["20 N/mm"].specified_load is None
    assert asked["100 MPa"].specified_load is not None
    with pytest.raises(rc.InputError, match="line load"):
        rc.solve(profile, material=STEEL, load="20 N")


# --- the command line ----------------------------------------------------------------------------

STRIP = (
    *shlex.split(
        "--body 'cylinder 10 mm' --points 64x16 --size '0.1 mm x 25 um' --material 100Cr6 "
        "--boundary periodic-x"
    ),
)


def json_output(capsys: Capture, *words: str) -> dict[str, Any]:
    assert app.main([*words, "--json"]) == app.SOLVED
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


def test_a_line_load_and_a_peak_of_hertz_on_the_command_line(capsys: Capture) -> None:
    line = json_output(capsys, "solve", *STRIP, "--load", "20 N/mm")
    assert line["load"] == pytest.approx(0.5)
    assert line["given_load"] == {"form": "line load", "value": 2e4, "unit": "N/m", "load": 0.5}
    peak = json_output(capsys, "solve", *STRIP, "--load", "hertz 400 MPa")
    assert peak["given_load"]["form"] == "Hertz's peak pressure"
    # Discretization: 21 pixels to the half-width.
    assert peak["max_pressure"] == pytest.approx(400e6, rel=1e-3)
    assert peak["hertz"]["max_pressure"] == pytest.approx(400e6)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("--load", "1 N", "--approach", "1 um"), "give one of --load and --approach"),
        ((), "give one of --load and --approach"),
        (("--load", "hertz 5 N"), "peak pressure such as 'hertz 1.5 GPa', got '5 N'"),
        (("--hertz", "1 GPa"), "--hertz is gone: give --load 'hertz 1 GPa'"),
        (("--load", "5 s"), "a line load such as '600 N/mm'"),
        (("--load", "hertz 1 GPa"), "--load (Hertz's peak pressure) needs a nominal sphere"),
        (("--load", "1 N/mm"), "--load (line load) needs a nominal cylinder"),
    ],
)
def test_invalid_loads_are_rejected_in_one_sentence(
    words: tuple[str, ...], sentence: str, capsys: Capture
) -> None:
    flat = ("--body", "flat", *STRIP[2:])
    assert app.main(["solve", *flat, *words]) == app.BAD_INPUT
    complaint = capsys.readouterr().err
    assert sentence in complaint
    assert complaint.count("\n") == 1


def test_command_line_accepts_every_form_of_load(capsys: Capture) -> None:
    sweep = ("sweep", *STRIP, "--steps", "3", "--from", "hertz 100 MPa", "--to", "hertz 400 MPa")
    curve = json_output(capsys, *sweep)
    forces = [hertz.line_load(p, 0.01, MODULUS) * 25e-6 for p in (1e8, 2e8, 4e8)]
    assert curve["load"] == pytest.approx(forces, rel=1e-9)
    assert [one["value"] for one in curve["given_loads"]] == pytest.approx([1e8, 2e8, 4e8])
    assert app.main([*sweep, "--verbose"]) == app.SOLVED
    shown = " ".join(capsys.readouterr().out.split())
    assert "Hertz's peak pressure 100 MPa (34.03 mN), 200 MPa (136.1 mN), 400 MPa (" in shown
    mixed = ["sweep", *STRIP, "--from", "1 MPa", "--to", "1 N"]
    assert app.main(mixed) == app.BAD_INPUT
    assert "loads of one form" in capsys.readouterr().err
    history = json_output(capsys, "history", *STRIP, "--path", "20 N/mm, 0 N, 20 MPa")
    assert history["steps"]["load"] == pytest.approx([0.5, 0, 20e6 * 2.5e-9])
    assert [one["form"] for one in history["given_loads"]] == ["line load", "nominal pressure"]


def test_project_accepts_lists_of_peaks(tmp_path: Path) -> None:
    path = tmp_path / "project.toml"
    path.write_text(
        '[[contact]]\nname = "roller"\nbody = "cylinder 10 mm"\npoints = "64x16"\n'
        'size = "0.1 mm x 25 um"\nmaterial = "100Cr6"\nload = ["hertz 1 GPa", "hertz 2 GPa"]\n',
        encoding="utf-8",
    )
    entries = project.read_project(path)
    assert [entry.name for entry in entries] == ["roller hertz 1 GPa", "roller hertz 2 GPa"]
    assert [entry.request[LOAD] for entry in entries] == [
        rc.HertzPressure(1e9),
        rc.HertzPressure(2e9),
    ]
