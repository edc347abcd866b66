"""Arguments, resumed runs, files and reports of wear."""

from __future__ import annotations

import csv
import json
import math
import re
import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.analyses.wear.model import WearStep, wear
from roughcontact.cli import app
from roughcontact.report import assumptions
from roughcontact.report.presentation import presentation_of
from roughcontact.surface import nominal_bodies

STEEL = rc.Material(210e9, 0.3)
TERMS: dict[str, Any] = {
    "material": STEEL,
    "load": "50 MPa",
    "wear_coefficient": "1e-15 m2/N",
    "distance": "0.5 m",
    "boundary": "periodic",
}


def rough(n: int = 32) -> rc.Surface:
    return rc.Surface(*rc.reference_map(n))


@pytest.fixture(scope="module")
def worn() -> rc.results.Wear:
    return wear(rough(), **TERMS, friction=0.1)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"wear_coefficient": "1e-4"}, "which has no unit"),
        ({"wear_coefficient": 1e-4}, "divide K by the hardness"),
        ({"wear_coefficient": "1e-15 m"}, "a length"),
        ({"wear_coefficient": 0.0}, "wear_coefficient is needed"),
        ({"distance": ["2 m", "1 m"]}, "must be positive and ascending"),
        ({"distance": 0.0}, "must be positive and ascending"),
        ({"motion": "rolling"}, "'sliding' or 'fretting'"),
        ({"counter_surface": rough()}, 'motion="fretting"'),
        ({"wear_coefficient": 0.0, "counter_wear_coefficient": 1e-15}, "keeps its shape"),
        ({"max_moved": 1.0}, "between 0 and 1"),
        ({"friction": -0.1}, "must not be negative"),
    ],
)
def test_invalid_arguments_raise_input_error(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(rc.InputError, match=message):
        wear(rough(), **{**TERMS, **changes})


def test_noise_limited_map_raises_input_error() -> None:
    surface = rough(64)
    noise = np.random.default_rng(1).normal(scale=5e-9, size=surface.shape)
    noisy = rc.Surface(surface.heights + noise, surface.pixel)
    with pytest.raises(rc.InputError, match=r"1 nm on average, less than the noise of the map, "):
        wear(noisy, **{**TERMS, "distance": "20 mm"})
    assert wear(noisy, **{**TERMS, "distance": "0.2 m"}).steps


def test_wear_ends_at_each_distance() -> None:
    distances = [0.1, 0.15, 0.5]
    result = wear(rough(), **{**TERMS, "distance": distances})
    assert set(distances) <= set(result.column("distance"))
    assert result.distance == 0.5
    assert result.column("wear") == pytest.approx(50e-9 * result.column("distance"), rel=1e-9)


def test_sliding_counter_body_wears_without_change_of_shape(worn: rc.results.Wear) -> None:
    both = wear(rough(), **TERMS, counter_wear_coefficient="2e-15 m2/N")
    assert both.worn.heights == pytest.approx(worn.worn.heights, abs=0)
    assert both.volumes[1] == pytest.approx(2 * both.volumes[0])
    assert both.worn_counter is None


def test_masked_points_do_not_wear() -> None:
    heights, pixel = rc.reference_map(32)
    heights[3, 4] = np.nan
    result = wear(rc.Surface(heights, pixel).masked(), **TERMS)
    assert np.count_nonzero(np.isnan(result.depth)) == 1
    assert np.nansum(result.depth) * result.last.pixel_area == pytest.approx(result.volumes[0])


def test_friction_work(worn: rc.results.Wear) -> None:
    assert worn.friction_work == pytest.approx(0.1 * worn.last.load * 0.5)


def plain(step: WearStep) -> WearStep:
    return replace(step, seconds=0.0)


def test_interrupted_wear_resumes_with_same_numbers(worn: rc.results.Wear, tmp_path: Path) -> None:
    def stop(state: rc.Progress) -> None:
        if state.number == 3 and state.step is not None:
            raise KeyboardInterrupt

    arguments = {**TERMS, "friction": 0.1, "folder": tmp_path}
    with pytest.raises(KeyboardInterrupt):
        wear(rough(), **arguments, progress=stop)
    kept: list[int] = []
    again = wear(
        rough(), **arguments, progress=lambda state: kept.append(state.number) if state.kept else 0
    )
    assert kept == [1, 2]
    assert list(map(plain, again.steps)) == list(map(plain, worn.steps))
    assert again.worn.heights.tobytes() == worn.worn.heights.tobytes()
    with pytest.raises(rc.InputError, match="another wear: distance differs"):
        wear(rough(), **{**arguments, "distance": "1 m"})


def test_files_hold_steps_and_maps(worn: rc.results.Wear, tmp_path: Path) -> None:
    for suffix in (".csv", ".json", ".nc"):
        worn.save(tmp_path / f"wear{suffix}")
    with (tmp_path / "wear.csv").open(newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row["wear [m]"]) for row in rows] == worn.column("wear").tolist()
    stored = json.loads((tmp_path / "wear.json").read_text(encoding="utf-8"))
    assert stored["steps"]["Ssk"] == worn.column("Ssk").tolist()
    assert stored["coefficients"] == [1e-15, 0.0]
    assert stored["friction_work"] == worn.friction_work
    dataset = worn.to_xarray()
    assert dataset["wear_depth"].values == pytest.approx(worn.depth, abs=0)
    assert dataset["step_distance"].values.tolist() == worn.column("distance").tolist()
    contact = rc.read_result(tmp_path / "wear.nc")
    assert isinstance(contact, rc.ContactResult)
    assert contact.surface.heights.tobytes() == worn.worn.heights.tobytes()


def test_worn_surface_has_contact_of_last_step(worn: rc.results.Wear) -> None:
    again = rc.solve(worn.worn, material=STEEL, load=worn.last.load, boundary="periodic")
    assert again.contact_area == pytest.approx(worn.last.contact_area, rel=5e-3)
    assert "worn by 25 nm on average" in worn.worn.provenance.steps


COMMAND = shlex.split(
    "wear ground.nc --load '50 MPa' --boundary periodic --young '210 GPa' --poisson 0.3 "
    "--level none --distance '0.5 m'"
)


def test_headline_covers_both_ceilings_of_bare_and_coated_bodies(tmp_path: Path) -> None:
    layer = rc.Layer(160e9, 0.2, 2e-6, hardness=16e9)
    short: dict[str, Any] = {**TERMS, "distance": "3 mm"}
    for material, ceiling, other in (
        (rc.Material(210e9, 0.3, 1e9), "auto", "calibrated"),
        (rc.Material(210e9, 0.3, 1e9, coating=[layer]), "bracket", "base"),
    ):
        given = {**short, "material": material}
        worn = wear(rough(), **given, ceiling=ceiling, folder=tmp_path / ceiling)
        answer = presentation_of(worn).answer()
        low, high = map(float, re.findall(r"([0-9.]+) to ([0-9.]+) %\)", answer)[-1])
        second = wear(rough(), **given, ceiling=other)
        assert low <= 100 * second.last.contact_fraction * 1.03
        assert 100 * second.last.contact_fraction <= 1.03 * high
        assert low <= 100 * worn.last.contact_fraction * 1.03 < 1.06 * high
        again = wear(rough(), **given, ceiling=ceiling, folder=tmp_path / ceiling)
        assert presentation_of(again).answer() == answer
        if ceiling == "bracket":
            assert worn.base.last.contact_fraction == second.last.contact_fraction
            assert worn.summary()["base"]["contact_area"][-1] == second.steps[-1].contact_area


@pytest.fixture
def ground(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    rough().save("ground.nc")


@pytest.mark.usefixtures("ground")
def test_command_prints_answer_and_writes_worn_surface(capsys: pytest.CaptureFixture[str]) -> None:
    files = ["--worn-surface", "worn.x3p", "--output", "running-in.csv"]
    assert app.main([*COMMAND, "--wear", "1e-15 m2/N", *files]) == app.SOLVED
    shown = " ".join(capsys.readouterr().out.split())
    assert "Runs in after 500 mm: contact 1.5 % (1." in shown
    assert "200 to 161 nm, 25 nm mean wear." in shown
    assert "Do not level the worn map again: --level none; a plane would tilt" in shown
    assert rc.read_surface("worn.x3p").Sq == pytest.approx(161e-9, rel=0.01)
    assert Path("running-in.csv").exists()
    assert app.main([*COMMAND, "--wear", "1e-4"]) != app.SOLVED
    assert "which has no unit" in capsys.readouterr().err
    assert app.main(COMMAND) != app.SOLVED
    assert "--wear is needed: a wear coefficient" in capsys.readouterr().err


@pytest.mark.long
@pytest.mark.usefixtures("ground")
def test_fretting_command_writes_both_bodies_and_report() -> None:
    rc.Surface(rough().heights[::-1], rough().pixel).save("counter.nc")
    words = "--wear|1e-15 m2/N|--counter-wear|2e-15 m2/N|--motion|fretting|--friction|0.2"
    words += "|--counter-surface|counter.nc|--worn-counter-surface|other.nc|--figure|wear.png"
    assert app.main([*COMMAND, *words.split("|"), "--report", "wear.html"]) == app.SOLVED
    before, after = rc.read_surface("counter.nc"), rc.read_surface("other.nc")
    assert float((before.heights - after.heights).mean()) == pytest.approx(50e-9, rel=1e-6)
    page = Path("wear.html").read_text(encoding="utf-8")
    assert "Archard" in page
    assert "2e-15 m²/N" in page


def test_curved_body_reports_depth_and_peak_pressure(capsys: pytest.CaptureFixture[str]) -> None:
    command = "--body|sphere 10 mm|--points|32|--size|0.4 mm|--load|1 N|--material|100Cr6"
    command += "|--wear|1e-15 m2/N|--distance|1 m, 10 m"
    assert app.main(["wear", *command.split("|")]) == app.SOLVED
    shown = " ".join(capsys.readouterr().out.split())
    assert "Wears by up to " in shown
    assert " Sq " not in shown


def test_profile_wears(worn: rc.results.Wear) -> None:
    line = rc.Surface(rough().heights[0], 1e-6)
    result = wear(line, **{**TERMS, "load": "1 N/mm"})
    assert result.last.contact_fraction > result.first.contact_fraction
    assert math.isclose(
        float(result.depth.sum()) * result.last.pixel_area, 1e-15 * 1e3 * 0.5, rel_tol=1e-9
    )


def test_report_assumes_wear_instead_of_one_loading(worn: rc.results.Wear) -> None:
    case = presentation_of(worn).case()
    assert case is not None
    names = [name for name, *_ in assumptions.assumption_rows(case)]
    assert "Archard's law of wear" in names
    assert "One slow loading" not in names


def test_worn_ball_is_not_compared_with_hertz() -> None:
    # The interval of the worn contact began with the contact of the unworn ball.
    grid: dict[str, Any] = {"shape": (32, 32), "pixel": (3e-6, 3e-6)}
    ball = nominal_bodies.sphere(radius=3e-3, **grid)
    result = wear(ball, **{**TERMS, "load": 1.0, "boundary": "free", "distance": "1 m"})
    assert result.first.hertz is not None
    assert result.last.hertz is None
    assert result.last.contact_fraction > 2 * result.first.contact_fraction
    assert result.last.surface.provenance.steps[-1].startswith("worn by ")
