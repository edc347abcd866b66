"""Results are computed again from what they hold, by the library and by `roughcontact verify`."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import h5py
import numpy as np
import pytest

import roughcontact as rc
from roughcontact._tools import netcdf
from roughcontact.cli import app
from roughcontact.contact import archive
from roughcontact.contact.archive import Verification, verify_solution
from roughcontact.elastoplastic.archive import verify_result

STEEL = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9, name="steel")
HEIGHTS, PIXEL = rc.reference_map(32)
SURFACE = rc.Surface(HEIGHTS, PIXEL)
HOLED = HEIGHTS.copy()
HOLED[3:5, 7:10] = np.nan
CASES = {
    "free": {},
    "periodic": {"boundary": "periodic"},
    "strip": {"boundary": "periodic-x"},
    "elastic": {"ceiling": None},
    "ceiling by pixel": {"ceiling": np.where(HEIGHTS > 0, 3e9, 1e9)},
    "two bodies": {"counter_surface": rc.Surface(HEIGHTS[::-1] / 2, PIXEL), "load": 0.3},
    "holes": {"surface": rc.Surface(HOLED, PIXEL).masked()},
    "tilted": {"moments": (1e-6, -2e-6)},
    "approach": {"load": None, "approach": 2e-7},
    "single": {"precision": "single"},
    "not converged": {"tolerance": 1e-14, "max_iterations": 2, "on_failure": "return"},
}


@lru_cache
def solve_case(case: str = "free") -> rc.ContactResult:
    return rc.solve(**{"surface": SURFACE, "material": STEEL, "load": 1.0, **CASES[case]})


@lru_cache
def yielded(*loads: float) -> rc.ElastoplasticResult:
    y, x = (1e-6 * (np.arange(n) - (n - 1) / 2) for n in (12, 10))
    ball = rc.Surface(-(y[:, None] ** 2 + x**2) / (2 * 105e-6), pixel=(1e-6, 1e-6))
    soft = rc.Material(young=210e9, poisson=0.3, yield_strength=1.6e9)
    return rc.solve_elastoplastic(ball, material=soft, increments=1, loads=loads, tolerance=1e-2)


@pytest.mark.parametrize("case", CASES)
def test_result_passes_verification(case: str, tmp_path: Path) -> None:
    result = solve_case(case)
    found = verify_solution(result)
    assert found.differences == ()
    assert found.found_certificate == pytest.approx(result.certificate, rel=0.1)
    assert found.found_load == pytest.approx(result.load, rel=1e-9) or case == "not converged"
    result.save(tmp_path / "out.nc")
    again = rc.read_result(tmp_path / "out.nc", verify=True)
    assert again.pressure.tobytes() == result.pressure.tobytes()


@pytest.mark.slow
@pytest.mark.parametrize("loads", [(0.3,), (0.3, 0.0)])
def test_contact_of_volume_passes_verification(loads: tuple[float, ...], tmp_path: Path) -> None:
    result = yielded(*loads)
    # The volume extends beyond the map, which the contact does not see.
    assert result.bodies[0].margin > 0
    assert verify_result(result).differences == ()
    # On the surface as it was before it yielded it is none.
    assert verify_solution(result.solution).differences
    result.save(tmp_path / "out.nc")
    rc.read_result(tmp_path / "out.nc", verify=True)


def test_changed_quantities_are_reported_as_differences() -> None:
    result = solve_case()
    pressure, gap = result.pressure.copy(), result.gap.copy()
    pressure[result.contact & ~result.saturated] *= 1.001
    gap[5, 5] += 1e-9
    for changed, expected in (
        (replace(result, pressure=pressure), {"load", "certificate", "gap"}),
        (replace(result, gap=gap), {"gap"}),
        (replace(result, approach=1.001 * result.approach), {"certificate", "gap"}),
        (replace(result, certificate=1.01 * result.certificate), {"certificate"}),
        (replace(result, load=1.001), {"load"}),
        (replace(result, tilt=(1e-5, 0.0)), {"certificate", "gap"}),
    ):
        assert set(verify_solution(changed).differences) == expected
    stiff = replace(result.pair, material=replace(STEEL, young=211e9))
    assert set(verify_solution(replace(result, pair=stiff)).differences) == {"certificate", "gap"}


@pytest.mark.long
def test_inconsistent_solution_raises_format_error(tmp_path: Path) -> None:
    # Everything agrees, checksums too, but the heights are another surface's.
    result = solve_case()
    path = tmp_path / "out.nc"
    replace(result, pair=replace(result.pair, surface=SURFACE.rotated(180))).save(path)
    assert rc.read_result(path).converged
    with pytest.raises(rc.FormatError) as caught:
        rc.read_result(path, verify=True)
    sentence = str(caught.value)
    assert sentence.startswith("out.nc does not contain the solution that it states: recomputed")
    assert "the certificate is" in sentence
    assert sentence.endswith("take a copy of the file, or solve again")
    assert "\n" not in sentence


def test_insufficient_memory_raises_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("roughcontact._tools.memory.free_bytes", lambda: 1000)
    with pytest.raises(rc.InsufficientMemoryError, match="points needs about"):
        verify_solution(solve_case())


@pytest.mark.long
def test_separated_bodies_have_no_certificate() -> None:
    found = verify_result(yielded(0.3, 0.0))
    assert (found.found_load, found.found_certificate) == (0.0, 0.0)


# The command --------------------------------------------------------------------------------------


@pytest.mark.long
def test_command_prints_one_row_per_file(tmp_path: Path, capsys, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    solve_case().save("sound.nc")
    yielded(0.3).save("volume.nc")
    solve_case().to_xarray().to_netcdf("old.nc", engine="h5netcdf")
    assert app.main(["verify", "sound.nc", "volume.nc", "old.nc"]) == app.SOLVED
    output = capsys.readouterr()
    rows = {line.split()[0]: line.split() for line in output.out.splitlines() if ".nc" in line}
    certificate = f"{solve_case().certificate:.4g}"
    assert rows["sound.nc"] == [
        "sound.nc",
        "1",
        "N",
        "1",
        "N",
        certificate,
        certificate,
        "agree",
        "sound",
    ]
    assert rows["volume.nc"][-2:] == ["agree", "sound"]
    assert rows["old.nc"][-2:] == ["none", "sound"]
    assert output.err == ""


@pytest.mark.long
def test_failed_files_are_reported_in_one_sentence_each(
    tmp_path: Path, capsys, monkeypatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = solve_case()
    result.save("sound.nc")
    result.save("changed.nc")
    with h5py.File("changed.nc", "a") as file:
        file.attrs["load"] = 2.0
    netcdf.write(archive.to_dataset(replace(result, gap=1.1 * result.gap)), "other.nc")
    SURFACE.save("map.nc")
    files = ["sound.nc", "changed.nc", "other.nc", "map.nc", "absent.nc"]
    assert app.main(["verify", *files]) == app.BAD_INPUT
    output = capsys.readouterr()
    states = [line.split()[-1] for line in output.out.splitlines() if ".nc" in line]
    assert states == ["sound", *["refused"] * 4]
    complaints = output.err.splitlines()
    assert [line.split()[2] for line in complaints] == files[1:]
    for line, words in zip(
        complaints,
        (
            "attributes do not match the checksum",
            "the gap differs by",
            "cannot be read as a result",
            "does not exist",
        ),
        strict=True,
    ):
        assert words in line
    assert app.main(["verify", "sound.nc", "other.nc", "--quiet"]) == app.BAD_INPUT
    output = capsys.readouterr()
    assert (output.out, output.err.count("\n")) == ("", 1)


def test_json_matches_table(tmp_path: Path, capsys, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    solve_case().save("sound.nc")
    assert app.main(["verify", "sound.nc", "absent.nc", "--json"]) == app.BAD_INPUT
    sound, absent = json.loads(capsys.readouterr().out)["files"]
    assert Verification(**sound["found"]) == verify_solution(solve_case())
    assert (sound["sealed"], sound["reason"]) == (True, "")
    assert absent["found"] is None
    assert "does not exist" in absent["reason"]


def test_command_without_file_is_rejected(capsys) -> None:
    assert app.main(["verify"]) == app.BAD_INPUT
    assert "missing argument 'FILE" in capsys.readouterr().err
