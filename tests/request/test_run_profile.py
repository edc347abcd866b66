"""Commands on profiles: units and words per length, reports, and what is refused."""

import json
import shlex

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.cli import app

STEEL = ["--young", "210 GPa", "--poisson", "0.3", "--yield-strength", "1 GPa"]


@pytest.fixture
def trace(tmp_path):
    rng = np.random.default_rng(7)
    x = np.arange(1000) * 5e-4
    z = np.convolve(rng.standard_normal(1010), np.ones(11) / 11, "valid") + 2 * x
    path = tmp_path / "trace.txt"
    rows = "\n".join(f"{a:.4f}\t{b:.6f}" for a, b in zip(x, z, strict=True))
    path.write_text(f"X [mm]\tZ [um]\n{rows}\n", encoding="utf-8")
    return path


def run_solve(path, *options):
    return app.main(["solve", str(path), *STEEL, "--load", "20 N/mm", *options])


def test_load_per_length_is_shown_with_its_unit(trace, capsys):
    assert run_solve(trace, "--verbose") == app.SOLVED
    shown = capsys.readouterr().out
    for words in (
        "Load per length W′   20 kN/m (given)",
        "Contact length",
        "leveled: least-squares line",
    ):
        assert words in shown
    for words in ("m²", "area", "1 m ×", " N\n", "map"):
        assert words not in shown
    assert run_solve(trace, "--json") == app.SOLVED
    record = json.loads(capsys.readouterr().out)
    assert (record["kind"], record["load"], record["load_unit"]) == ("profile", 20000.0, "N/m")
    assert record["boundary"] == "free"
    assert record["contact_length"] == pytest.approx(record["contact_fraction"] * 5e-4)
    assert "contact_area" not in record


def test_a_nominal_pressure_is_one_on_the_length(trace, capsys):
    assert app.main(["solve", str(trace), *STEEL, "--load", "40 MPa", "--json"]) == app.SOLVED
    record = json.loads(capsys.readouterr().out)
    assert record["load"] == pytest.approx(40e6 * 5e-4)
    assert record["given_load"]["load"] == record["load"]
    assert app.main(["solve", str(trace), *STEEL, "--load", "40 MPa", "--verbose"]) == app.SOLVED
    shown = " ".join(capsys.readouterr().out.split())
    assert "40 MPa on the whole profile, 500 µm, are 20 kN/m" in shown


def test_force_on_profile_and_line_load_on_map_are_rejected(trace, tmp_path, capsys):
    assert app.main(["solve", str(trace), *STEEL, "--load", "1 N"]) == app.BAD_INPUT
    assert "--load is a force, and the file holds a profile" in capsys.readouterr().err
    ends = ["--from", "1 N", "--to", "2 N"]
    assert app.main(["sweep", str(trace), *STEEL, *ends]) == app.BAD_INPUT
    assert "--from is a force, and the file holds a profile" in capsys.readouterr().err
    heights, pixel = rc.reference_map(32)
    rc.Surface(heights, pixel).save(tmp_path / "map.npz")
    assert run_solve(tmp_path / "map.npz") == app.BAD_INPUT
    assert "--load (line load) needs a nominal cylinder" in capsys.readouterr().err


@pytest.mark.slow
def test_report_on_profile_states_assumptions(trace, tmp_path):
    page, result = tmp_path / "r.html", tmp_path / "r.nc"
    figures = ["--figures", str(tmp_path / "f.png")]
    assert run_solve(trace, "--report", str(page), "--output", str(result), *figures) == app.SOLVED
    text = page.read_text(encoding="utf-8")
    for words in (
        "Straight ridges",
        "the surface is rough in both directions",
        "at a distance of the longer side",
        ">R</th>",
        "ISO 21920-2",
        "How much of trace.txt is in contact under 20 N/mm?",
        "1000 of a profile",
    ):
        assert words in text
    for words in (" of the map", "1 m × ", "m²", "contact area of the map"):
        assert words not in text
    assert {path.name for path in tmp_path.glob("*.png")} == {
        "f-surface.png",
        "f-pressure.png",
        "f-contact.png",
    }
    again = rc.read_result(result)
    assert again.pair.is_profile
    assert again.load == pytest.approx(2e4)
    assert app.main(["verify", str(result)]) == app.SOLVED


@pytest.mark.long
def test_a_load_curve_of_a_profile(trace, tmp_path, capsys):
    page, table = tmp_path / "r.html", tmp_path / "c.csv"
    ends = ["--from", "1 N/mm", "--to", "20 N/mm", "--steps", "3", "--boundary", "periodic"]
    files = ["--report", str(page), "--output", str(table)]
    assert app.main(["sweep", str(trace), *STEEL, *ends, *files, "--verbose"]) == app.SOLVED
    shown = capsys.readouterr().out
    assert "20 kN/m" in shown
    assert "segments" in shown
    assert "m²" not in shown
    head = table.read_text(encoding="utf-8").splitlines()[0]
    assert "load [N/m]" in head
    assert "contact_length [m]" in head
    assert "persson" not in head
    assert "from 1 kN/m to 20 kN/m" in page.read_text(encoding="utf-8")


def test_a_roller_is_a_cylinder_across_the_profile(trace, capsys):
    for form, status in (("cylinder 5 mm", app.SOLVED), ("sphere 5 mm", app.BAD_INPUT)):
        assert run_solve(trace, "--counter-body", form, "--json") == status
        found = capsys.readouterr()
        if status == app.SOLVED:
            record = json.loads(found.out)
            # 2√(4 W′R/(π E*)) wide at most on a smooth line.
            assert record["contact_length"] < 3e-5
        else:
            assert "a profile takes 'flat', a cylinder such as" in found.err


def test_info_has_the_parameters_of_a_profile(trace, capsys):
    assert app.main(["info", str(trace), "--verbose"]) == app.SOLVED
    shown = capsys.readouterr().out
    for words in ("1000 of a profile", "Pq, Rq", "Psm, Rsm", "80 µm, the largest λc"):
        assert words in shown
    assert app.main(["info", str(trace), "--json"]) == app.SOLVED
    record = json.loads(capsys.readouterr().out)
    assert {"Rq", "Ra", "Rz", "Rsk", "Rku", "Rsm", "Rdq"} <= record["roughness"].keys()
    assert record["cutoff"] == 8e-5


def test_map_options_of_profile_are_rejected_in_one_sentence(trace, capsys):
    for command in (
        ["solve", "--load", "20 N/mm", "--model", "elastoplastic"],
        ["solve", "--load", "20 N/mm", "--set", "load-point=0 um, 5 um"],
        ["solve", "--load", "20 N/mm", "--ceiling", "calibrated"],
        ["history", "--path", "1 N, 0 N"],
        ["find", "--contact-fraction", "5 %"],
        shlex.split(
            "conductance --load '20 N/mm' --conductivity '40 W/m/K' "
            "--counter-conductivity '40 W/m/K'"
        ),
        ["solve", "--load", "20 N/mm", "--set", "rotate=90"],
    ):
        task, *options = command
        assert app.main([task, str(trace), *STEEL, *options]) == app.BAD_INPUT, command
        error = capsys.readouterr().err
        assert "is a profile" in error, command
        assert "needs a map" in error, command
        assert error.count("\n") == 1


def test_the_script_of_a_report_repeats_a_profile(trace, monkeypatch):
    from roughcontact.report import python_script

    monkeypatch.chdir(trace.parent)
    surface = rc.read_surface(trace.name).leveled()
    first = rc.solve(surface, material=rc.Material(210e9, 0.3, 1e9), load="20 N/mm")
    lines = python_script.script_of_result(first)
    assert "boundary" not in lines
    found = {}
    exec(lines, found)
    assert np.array_equal(found["result"].pressure, first.pressure)


def test_files_of_a_profile(trace, tmp_path, capsys):
    table = tmp_path / "p.csv"
    assert run_solve(trace, "--quiet", "--output", str(table)) == app.SOLVED
    columns = np.loadtxt(table, delimiter=",")
    assert columns.shape == (1000, 2)
    assert columns[:, 1].sum() * 5e-7 == pytest.approx(2e4)
    assert run_solve(trace, "--quiet", "--output", str(tmp_path / "p.vti")) == app.BAD_INPUT
    assert "for a profile, got" in capsys.readouterr().err
    surface = rc.read_surface(trace)
    for name in ("s.csv", "s.npz", "s.nc"):
        surface.save(tmp_path / name)
        again = rc.read_surface(tmp_path / name)
        assert again.is_profile
        assert np.array_equal(again.heights, surface.heights)
        assert again.pixel == pytest.approx(surface.pixel, rel=1e-12)
    with pytest.raises(rc.InputError, match="for a profile"):
        surface.save(tmp_path / "s.x3p")


def test_profile_is_compared_with_smooth_roller(tmp_path, capsys):
    # A flat line under a cylinder: the reference values are the solved ones.
    x = np.arange(2001) * 2e-4
    np.savetxt(tmp_path / "flat.txt", np.column_stack([x, 0 * x]), header="mm um")
    words = ["--counter-body", "cylinder 5 mm", "--ceiling", "none", "--load", "20 N/mm"]
    assert (
        app.main(["solve", str(tmp_path / "flat.txt"), *STEEL, *words, "--verbose"]) == app.SOLVED
    )
    shown = capsys.readouterr().out
    table = shown[shown.rindex("compared with Hertz") :].splitlines()[1:6]
    ratios = {line.strip().split("  ")[0]: float(line.split()[-1]) for line in table}
    assert ratios["largest pressure"] == pytest.approx(1, abs=1e-3)
    assert ratios["contact length"] == pytest.approx(1, abs=1e-2)
    # From the same reference: the length of the profile.
    assert ratios["approach"] == pytest.approx(1, abs=1e-3)


def test_conductance_of_profile_is_rejected_before_solve(trace, capsys, monkeypatch):
    from roughcontact.contact import solve

    monkeypatch.delattr(solve, "solve")
    words = [
        "conductance",
        str(trace),
        *STEEL,
        *shlex.split(
            "--load '20 N/mm' --conductivity '40 W/m/K' --counter-conductivity '40 W/m/K'"
        ),
    ]
    assert app.main(words) == app.BAD_INPUT
    assert "the resistance of a contact" in capsys.readouterr().err
