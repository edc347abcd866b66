"""Coated bodies as users meet them: materials, ceilings, options, files, refusals."""

from __future__ import annotations

import json
import math
import shlex
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.cautions import CautionTag
from roughcontact.cli import app
from roughcontact.material import catalog
from roughcontact.request import parsing
from roughcontact.uncertainty import intervals as uncertainty

ROUGH = rc.Surface(*rc.reference_map(64))
COARSE = rc.Surface(ROUGH.heights[::2, ::2], (2 * ROUGH.pixel[0], 2 * ROUGH.pixel[1]))
FILM = rc.Layer("166 GPa", 0.2, "2 um", hardness="16.7 GPa", name="DLC")
TOOL = rc.Material("210 GPa", 0.3, "1 GPa", name="steel", coating=[FILM])


def solve_coated(surface: rc.Surface = ROUGH, **more: object) -> rc.ContactResult:
    return rc.solve(surface, **{"material": TOOL, "load": 1.0, "ceiling": None, **more})


def test_a_layer_is_a_material_of_some_thickness() -> None:
    assert FILM.thickness == 2e-6
    assert TOOL.outermost == FILM.bulk
    assert TOOL.compliance == pytest.approx(0.96 / 166e9)
    assert TOOL.uncoated == rc.Material(210e9, 0.3, 1e9, name="steel")
    assert TOOL.ceiling is None
    assert TOOL.first_yield_pressure is None


@pytest.mark.parametrize(
    "values", [{"young": math.inf}, {"poisson": 0.6}, {"thickness": 0.0}, {"thickness": "2 GPa"}]
)
def test_invalid_layer_raises_input_error(values: dict[str, object]) -> None:
    with pytest.raises(rc.InputError):
        rc.Layer(**{"young": 1e9, "poisson": 0.3, "thickness": 1e-6, **values})


def test_invalid_coating_or_base_raises_input_error() -> None:
    for more in ({"coating": [1.0]}, {"base": "glued"}, {"base": "frictionless"}):
        with pytest.raises(rc.InputError):
            rc.Material(210e9, 0.3, **more)


def test_coated_body_needs_choice_of_ceiling() -> None:
    for ceiling in ("auto", "calibrated"):
        with pytest.raises(rc.InputError) as error:
            solve_coated(ceiling=ceiling)
        for offered in ("'coating' (16.7 GPa)", "'base' (3 GPa)", "'bracket'"):
            assert offered in str(error.value)
    assert solve_coated(ceiling="coating").ceiling == 16.7e9
    assert solve_coated(ceiling="base").ceiling == 3e9
    with pytest.raises(rc.InputError, match="a pressure"):
        solve_coated(ceiling="base", material=rc.Material(210e9, 0.3, coating=[FILM]))


def test_bracket_solves_both_ceilings() -> None:
    both, base = solve_coated(ceiling="bracket"), solve_coated(ceiling="base")
    assert both.ceiling == 16.7e9
    assert both.calibrated is not None
    assert both.calibrated.is_of_base
    assert both.calibrated.ceiling == 3e9
    assert both.calibrated.contact_area == pytest.approx(base.contact_area, rel=1e-3)
    intervals = {item.name: item for item in uncertainty.uncertainty_intervals(both)}
    assert intervals["contact_fraction"].high == pytest.approx(base.contact_fraction, rel=1e-2)


def test_softer_counter_body_sets_ceiling() -> None:
    counter = rc.Material(210e9, 0.3, 0.5e9)
    for ceiling in ("auto", "bracket", "coating", "base"):
        result = solve_coated(ceiling=ceiling, counter_material=counter)
        assert result.ceiling == 1.5e9
        assert result.calibrated is not None
        (interval, *_) = uncertainty.uncertainty_intervals(result)
        assert uncertainty.Cause.YIELDING in {source.cause for source in interval.doubts}


def test_saved_coating_is_loaded(tmp_path: Path) -> None:
    result = solve_coated(ceiling="bracket")
    result.save(tmp_path / "tool.nc")
    again = rc.read_result(tmp_path / "tool.nc")
    assert again.material == TOOL
    np.testing.assert_array_equal(again.pressure, result.pressure)
    assert again.calibrated.is_of_base


def test_script_repeats_coated_contact(tmp_path: Path) -> None:
    from roughcontact.report import python_script

    text = python_script._material(TOOL)
    assert eval(text, {"rc": rc}) == TOOL


REFUSED = {
    "an estimate": lambda: rc.estimate(ROUGH, pressure="10 MPa", material=TOOL),
    "a law": lambda: rc.interface_law([solve_coated(boundary="periodic")]),
    "tangential": lambda: rc.tangential(solve_coated(), friction=0.1, force=0.01),
    "conductance": lambda: rc.conductance(solve_coated(), "42CrMo4", "42CrMo4"),
    "the volume model": lambda: rc.solve_elastoplastic(ROUGH, material=TOOL, load=1.0),
    "a history": lambda: rc.history(ROUGH, [1.0, 0.0], material=TOOL, ceiling=None),
    "first yield": lambda: rc.first_yield_load(ROUGH, material=TOOL),
    "a Hertz pressure": lambda: solve_coated(
        load="hertz 1 GPa", counter_surface=rc.sphere("10 mm")
    ),
    "friction": lambda: rc.subsurface_stress(solve_coated(), friction=0.1),
}


@pytest.mark.parametrize("what", REFUSED)
def test_unsupported_analyses_of_coating_raise_input_error(what: str) -> None:
    with pytest.raises(rc.InputError):
        REFUSED[what]()


def test_formulas_for_bare_bodies_are_absent() -> None:
    ball = solve_coated(counter_surface=rc.sphere("10 mm"))
    assert ball.hertz is None
    curve = rc.sweep(ROUGH, material=TOOL, loads=[0.5, 1.0], ceiling=None)
    assert np.isnan(curve.persson[0]).all()
    assert not {CautionTag.ADHESION, CautionTag.CEILING} & {
        caution.kind for caution in solve_coated().cautions
    }


def test_stress_is_reported_by_layer() -> None:
    stress = rc.subsurface_stress(solve_coated(COARSE))
    film, steel = stress.parts
    assert (film.name, steel.name) == ("DLC", "steel")
    assert film.strength == pytest.approx(16.7e9 / 3)
    assert (film.of_hardness, steel.of_hardness) == (True, False)
    assert steel.depth >= 2e-6 > film.depth
    assert [face.part for face in stress.faces] == [0, 0, 1]
    assert stress.faces[1].shear.value == pytest.approx(stress.faces[2].shear.value, rel=1e-3)
    coarse = rc.Material(210e9, 0.3, coating=[rc.Layer(1e11, 0.3, "1 um")])
    cautions = rc.subsurface_stress(solve_coated(COARSE, material=coarse)).own_cautions
    assert any("quarter of a layer" in str(caution) for caution in cautions)


def test_stress_of_coated_profile_is_reported_by_layer() -> None:
    trace = rc.Surface(ROUGH.heights[0], 2e-7)
    result = rc.solve(trace, material=TOOL, load="10 N/mm", ceiling=None, boundary="periodic")
    stress = rc.subsurface_stress(result)
    assert [part.name for part in stress.parts] == ["DLC", "steel"]
    assert not any("quarter of a layer" in str(caution) for caution in stress.own_cautions)
    free = rc.solve(trace, material=TOOL, load="10 N/mm", ceiling=None)
    with pytest.raises(rc.InputError, match="solve with 'periodic'"):
        rc.subsurface_stress(free)


def test_a_rigid_base_has_no_stress() -> None:
    mat = rc.Material(math.inf, 0.0, coating=[rc.Layer("10 MPa", 0.49, "20 um", name="rubber")])
    stress = rc.subsurface_stress(solve_coated(COARSE, material=mat, load=1e-3))
    assert [part.name for part in stress.parts] == ["rubber"]
    assert [face.part for face in stress.faces] == [0, 0]
    assert stress.profile.depths.max() < 20e-6


@pytest.mark.parametrize("film", catalog.films(), ids=lambda film: film.key)
def test_every_value_of_a_film_has_its_source(film: catalog.Film) -> None:
    for value in (film.young, film.poisson, film.hardness):
        assert value is None or len(value.source) > 5
    assert film.layer(1e-6).name == film.key


def test_layer_is_parsed_from_text() -> None:
    assert parsing.coating("DLC 2 um", "coating") == catalog.layer("DLC", 2e-6)
    own = parsing.coating("E=350 GPa, nu=0.22, H=25 GPa, name=AlTiN, 3 um", "coating")
    assert own == rc.Layer(350e9, 0.22, 3e-6, hardness=25e9, name="AlTiN")
    assert parsing.coating("tin 1 um", "coating").young == 50e9
    assert parsing.coating("TiN 1 um", "coating").young == 397e9
    for text in ("DLC", "TIN 1 um", "TiAlN 2 um", "E=1 GPa, 2 um", "E=1 GPa, nu=0.3, X=1, 2 um"):
        with pytest.raises(rc.InputError) as error:
            parsing.coating(text, "coating")
        assert error.value.argument == "coating"


def test_film_as_material_raises_input_error() -> None:
    with pytest.raises(rc.InputError, match="is a coating"):
        catalog.material("TiN")
    assert catalog.material("tin").young == 50e9


@pytest.mark.usefixtures("quick")
@pytest.mark.long
def test_command_solves_coated_body(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    np.save(tmp_path / "map.npy", ROUGH.heights)
    words = [
        str(tmp_path / "map.npy"),
        *shlex.split(
            "--size '100 um x 100 um' --unit m --load '1 N' --material 100Cr6 "
            "--coating 'CrN 2 um' --coating 'Cr 500 nm'"
        ),
    ]
    assert app.main(["solve", *words]) == app.BAD_INPUT
    assert "bracket" in capsys.readouterr().err
    assert app.main(["solve", *words, "--ceiling", "bracket"]) == app.SOLVED
    shown = " ".join(capsys.readouterr().out.split())
    assert "CrN 2 µm on Cr 500 nm on 100Cr6" in shown
    assert "Ceiling of the base (6.1 GPa)" in shown
    assert app.main(["stress", *words, "--ceiling", "bracket", "--json"]) == app.SOLVED
    both = json.loads(capsys.readouterr().out)["stress"]
    for name, record in (("coating", both), ("base", both["base"])):
        assert app.main(["stress", *words, "--ceiling", name, "--json"]) == app.SOLVED
        alone = json.loads(capsys.readouterr().out)["stress"]
        assert record["parts"] == alone["parts"]
        assert record["faces"] == alone["faces"]
    assert app.main(["stress", *words, "--ceiling", "bracket"]) == app.SOLVED
    assert "ceiling of the coating ceiling of the base" in " ".join(capsys.readouterr().out.split())
    report = tmp_path / "stress.html"
    words += ["--ceiling", "none", "--report", str(report), "--json"]
    assert app.main(["stress", *words]) == app.SOLVED
    stored = json.loads(capsys.readouterr().out)["stress"]
    assert [part["name"] for part in stored["parts"]] == ["CrN", "Cr", "100Cr6"]
    assert len(stored["faces"]) == 5
    assert "Bottom of Cr" in report.read_text("utf-8")
    assert "Yielding of a coated body needs" not in report.read_text("utf-8")
