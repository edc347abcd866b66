"""Repeated passes from the command line to their files, figures and reports."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import roughcontact as rc
from reading import measurement, needs_reader
from rollers import Line
from roughcontact.analyses.roll import figures as movie, task as request
from roughcontact.analyses.roll.model import (
    Shakedown,
    load_rolling,
    make_frame,
    pass_result,
    rolled_surface,
)
from roughcontact.cautions import CautionTag
from roughcontact.cli import app
from roughcontact.elastoplastic import plausibility
from roughcontact.report.presentation import presentation_of
from roughcontact.surface import nominal_bodies

pytestmark = pytest.mark.long

GRID: Any = {"shape": (8, 24), "pixel": (8e-6, 8e-6)}
STEEL = rc.Material(young=210e9, poisson=0.3, hardening=rc.hardening.Linear("1 GPa", "20 GPa"))
WORDS = (
    *shlex.split(
        "roll --body flat --points 8x24 --size '64 um x 192 um' "
        "--counter-body 'cylinder 1.5 mm 90 deg' --load 'hertz 2.2 GPa' --young '210 GPa' "
        "--poisson 0.3 --yield-strength '1 GPa' --hardening 'linear 20 GPa' --boundary periodic "
        "--steps 3 --quiet"
    ),
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("passes")


@pytest.fixture(scope="module")
def seen() -> list[tuple[int, int, float]]:
    return []


@pytest.fixture(scope="module")
def rolled(folder: Path, seen: list[tuple[int, int, float]]) -> rc.results.RollingResult:
    """Two passes of a roller that pulls with a tenth of its pressure."""
    return rc.roll(
        nominal_bodies.flat(**GRID),
        counter_surface=nominal_bodies.cylinder(radius=1.5e-3, angle=90.0, **GRID),
        material=STEEL,
        load=5.0,
        passes=2,
        steps=3,
        boundary="periodic",
        friction=0.1,
        folder=folder / "kept",
        on_step=lambda number, step, state: seen.append((number, step, state.max_plastic_strain)),
    )


@pytest.mark.parametrize("to_and_fro", [False, True])
def test_passes_end_with_one_that_adds_no_plastic_strain(to_and_fro: bool, tmp_path: Path) -> None:
    numbers: list[tuple[int, int, str]] = []
    rolled_on = rc.roll(
        nominal_bodies.flat(**GRID),
        counter_surface=nominal_bodies.cylinder(radius=1.5e-3, angle=90.0, **GRID),
        material=STEEL,
        load=0.5,
        passes=1000,
        steps=2,
        boundary="periodic",
        reciprocating=to_and_fro,
        progress=lambda at: numbers.append((at.number, at.count, at.label)),
    )
    # The way back may flow where the way there does not.
    assert len(rolled_on.passes) == 1 + to_and_fro
    assert rolled_on.requested == 1000
    assert rolled_on.shakedown is Shakedown.ELASTIC
    # Steps are counted over all passes for the remaining time.
    assert numbers[0] == (1, 2000, "pass 1 of 1000")
    assert numbers[-1] == (2 + 2 * to_and_fro, 2000, f"pass {1 + to_and_fro} of 1000")
    rolled_on.save(tmp_path / "passes.nc")
    assert rc.read_result(tmp_path / "passes.nc").requested == 1000


@pytest.mark.slow
def test_each_step_is_shown_once_and_in_order(
    rolled: rc.results.RollingResult, seen: list[tuple[int, int, float]]
) -> None:
    assert [place[:2] for place in seen] == [(n, k) for n in (1, 2) for k in (1, 2, 3)]
    assert seen[-1][2] == rolled.result.max_plastic_strain
    # Stored steps are shown as well.
    again = [(n, k, state.max_plastic_strain) for n, k, state in rolled.states()]
    assert again == seen


def test_pass_quantities_match_volume_result(rolled: rc.results.RollingResult) -> None:
    last, state = rolled.passes[-1], rolled.result
    (body,) = state.bodies
    after = rolled_surface(state)
    np.testing.assert_array_equal(after.heights, -state.residual_displacement)
    values = after.roughness()
    assert last.Sq == pytest.approx(values["Sq"])
    assert last.Spk == pytest.approx(values["Spk"], abs=1e-15)
    assert [one.steps for one in rolled.passes] == [3, 3]
    assert last.max_pressure == max(step.max_pressure for step in state.increments[3:])
    assert last.contact_area == max(step.contact_area for step in state.increments[3:])
    # The sum over passes is the total: γ = 2 ε, the mean of each layer.
    total = sum(one.shear[0] for one in rolled.passes)
    np.testing.assert_allclose(total, -2 * body.plastic_strain[:, 3].mean(axis=(1, 2)), atol=1e-9)
    # The normal stresses of a layer, from the tensor that sections have.
    section = state.section("x", 3)
    for along, axis in ((last.residual_along, 0), (last.residual_across, 1)):
        normal = section.residual_stress[..., axis, axis].mean(axis=1)
        np.testing.assert_allclose(along[0], normal, rtol=1e-3, atol=1e-3 * np.abs(normal).max())


def test_friction_drags_the_surface_along(rolled: rc.results.RollingResult) -> None:
    assert rolled.passes[0].largest_shear > 0


def test_profiles_turn_with_the_direction(rolled: rc.results.RollingResult) -> None:
    there = pass_result(rolled.result, None, 0.0)
    back, aside = (pass_result(rolled.result, None, angle) for angle in (180.0, 90.0))
    np.testing.assert_allclose(back.shear, -there.shear, atol=1e-12)
    np.testing.assert_allclose(aside.residual_across, there.residual_along, rtol=1e-5)


@pytest.mark.slow
def test_passes_are_loaded_as_they_were_saved(
    rolled: rc.results.RollingResult, folder: Path
) -> None:
    rolled.save(folder / "out.nc")
    loaded = rc.read_result(folder / "out.nc")
    assert loaded.passes == rolled.passes
    assert (loaded.outcome_text, loaded.direction) == (rolled.outcome_text, rolled.direction)
    for old, new in zip(rolled.passes, loaded.passes, strict=True):
        for name in ("shear", "residual_along", "residual_across"):
            np.testing.assert_array_equal(getattr(new, name), getattr(old, name))
    np.testing.assert_array_equal(
        rc.read_result(folder / "out.nc").result.bodies[0].plastic_strain,
        rolled.result.bodies[0].plastic_strain,
    )
    rolled.result.save(folder / "state.nc")
    with pytest.raises(rc.FormatError, match=r"state\.nc cannot be read .* Rolling\.save"):
        load_rolling(folder / "state.nc")


def test_json_and_csv_match_result(rolled: rc.results.RollingResult, folder: Path) -> None:
    rolled.save(folder / "out.json")
    rolled.save(folder / "out.csv")
    record = json.loads((folder / "out.json").read_text())
    assert record["shakedown"] == str(rolled.shakedown)
    assert record["each"]["strain_added"] == [one.strain_added for one in rolled.passes]
    assert record["volume"]["max_plastic_strain"] == rolled.result.max_plastic_strain
    assert len(record["shear_over_depth"][0]) == len(record["depth"])
    head, *rows = (folder / "out.csv").read_text().splitlines()
    assert head.startswith("number [1],strain_added [1],strain_net [1],largest_shear [1]")
    assert [float(row.split(",")[1]) for row in rows] == record["each"]["strain_added"]


@pytest.mark.slow
def test_paraview_plays_every_step(rolled: rc.results.RollingResult, folder: Path) -> None:
    rolled.save(folder / "out.pvd")
    named = re.findall(
        r'timestep="(\d)" part="(\d)" file="([^"]+)"', (folder / "out.pvd").read_text()
    )
    assert [place[:2] for place in named] == [(str(t), p) for t in range(1, 7) for p in "01"]
    assert all((folder / file).stat().st_size for *_, file in named)
    with pytest.raises(rc.InputError, match=r"^folder is needed"):
        replace(rolled, folder=None).save(folder / "none.pvd")
    assert not (folder / "none.pvd").exists()


@pytest.mark.slow
def test_movie_has_one_frame_per_step(rolled: rc.results.RollingResult, folder: Path) -> None:
    from PIL import Image

    frames = [make_frame(state, n, k, "x") for n, k, state in rolled.states()]
    np.testing.assert_allclose(
        frames[-1].strain, rolled.result.bodies[0].accumulated.max(axis=1), rtol=1e-6
    )
    movie.save(rolled, frames, folder / "movie.gif")
    with Image.open(folder / "movie.gif") as shown:
        # Pictures that are alike would be one.
        assert shown.n_frames == len(frames) == 6
        assert shown.info["loop"] == 0
    with pytest.raises(rc.InputError, match=r"\.gif"):
        movie.save(rolled, frames, folder / "movie.mp4")


@pytest.mark.parametrize(
    ("direction", "along"), [(0, "x"), (45, "x"), (90, "y"), (180, "x"), (-80, "y")]
)
def test_movies_follow_the_nearer_axis(direction: float, along: str) -> None:
    assert movie.along_of(direction) == along


def test_the_report_leads_with_the_passes(rolled: rc.results.RollingResult) -> None:
    text = " ".join(presentation_of(rolled).render().split())
    front = text[: text.index('id="messages"')]
    assert "shake down in 2 passes?" in front
    assert presentation_of(rolled).meaning() in front
    for number in range(2):
        assert f'<th scope="row">{number + 1}</th>' in front
    assert "Rolling without slip zones" in text


def test_hardening_carries_load_only_in_bodies_that_harden(
    rolled: rc.results.RollingResult, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(type(rolled), "shakedown", Shakedown.ELASTIC_SHAKEDOWN)
    hardens = any(body.material.hardens for body in rolled.result.bodies)
    text = presentation_of(rolled).meaning()
    assert "residual stress" in text
    assert ("hardening" in text) is hardens


def test_reversed_strain_is_not_large(rolled: rc.results.RollingResult) -> None:
    (body,) = rolled.result.bodies
    worn = replace(rolled.result, bodies=(replace(body, accumulated=body.accumulated + 0.5),))
    assert plausibility.largest_strain(worn) < 0.1 < worn.max_plastic_strain
    assert CautionTag.STRAIN not in {caution.kind for caution in worn.cautions}
    torn = replace(rolled.result, bodies=(replace(body, plastic_strain=100 * body.plastic_strain),))
    assert plausibility.largest_strain(torn) > 0.1
    assert CautionTag.STRAIN in {caution.kind for caution in torn.cautions}


def test_hardness_does_not_hide_ratcheting() -> None:
    line = Line(4.6, points=32)
    steel = replace(line.steel, hardness=4e9)
    assert steel.hardens
    found = rc.roll(
        line.flat,
        counter_surface=line.roller,
        material=steel,
        load=line.load,
        passes=1,
        steps=2,
        boundary="periodic",
        layers=line.layers,
        start_at_center=True,
    )
    assert not found.result.bodies[0].material.hardens


def test_reciprocating_travel_is_centered_on_counter_body() -> None:
    elastic = rc.roll(
        nominal_bodies.flat(**GRID),
        counter_surface=nominal_bodies.sphere(radius=1e-3, **GRID),
        material=STEEL,
        load=0.05,
        passes=2,
        steps=4,
        travel="32 um",
        start_at_center=True,
        reciprocating=True,
    )
    offsets = [step.offset[1] for step in elastic.result.increments]
    ahead = [-12e-6, -4e-6, 4e-6, 12e-6]
    assert offsets == pytest.approx([*ahead, *ahead[::-1]])
    assert elastic.outcome_text == "elastic"


# The command


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.chdir(tmp_path)
    return tmp_path  # type: ignore[return-value]


@pytest.mark.slow
def test_command_writes_outputs_and_resumes(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = [word for word in WORDS if word != "--quiet"]
    files = ("--output", "out.nc", "--output", "out.csv", "--movie", "out.gif")
    asked = [*words, "--folder", "kept", *files, "--passes", "2"]
    assert app.main([*asked[:-1], "1"]) == app.SOLVED
    capsys.readouterr()
    assert app.main(asked) == app.SOLVED
    out = capsys.readouterr().out
    assert max(map(len, out.splitlines())) <= 80
    assert "solved by an earlier run: 3 loads" in out
    loaded = rc.read_result("out.nc")
    assert "Not resolved: the steps are longer" in " ".join(out.split())
    assert len(Path("out.csv").read_text().splitlines()) == 3
    # The same in one go.
    fresh = rc.roll(
        nominal_bodies.flat(**GRID),
        counter_surface=nominal_bodies.cylinder(radius=1.5e-3, angle=90.0, **GRID),
        material=STEEL,
        load=loaded.result.solution.load,
        passes=2,
        steps=3,
        boundary="periodic",
    )
    assert fresh.passes == loaded.passes


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"--counter-body": None}, "--counter-body is needed: the body that rolls over the map"),
        ({"--load": None}, "--load is needed: such as '1 N' or 'hertz 1.5 GPa'"),
        ({"--friction": "-0.1"}, "--friction must not be negative, got '-0.1'"),
        ({"--yield-strength": None, "--hardening": None}, "needs a --yield-strength"),
        ({"--output": "out.pvd"}, "--folder is needed for .pvd"),
        ({"--movie": "out.mp4"}, "--movie needs a name that ends in .gif"),
        ({"--boundary": "free"}, "--travel is needed where the map is not periodic"),
        ({"--passes": "0"}, "--passes"),
    ],
)
def test_invalid_options_are_rejected(
    changed: dict[str, str | None], said: str, home: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = dict(zip(WORDS[1:-1:2], WORDS[2:-1:2], strict=True)) | changed
    words = [word for name, value in given.items() if value for word in (name, value)]
    assert app.main(["roll", *words]) == app.BAD_INPUT
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert said in err
    assert not list(home.iterdir())


def test_long_run_needs_confirmation(
    home: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(request, "_LONG", 0.0)
    words = [*WORDS, "--passes", "2", "--folder", "steps"]
    assert app.main(words) == app.BAD_INPUT
    assert "--yes is needed: 6 steps take about" in capsys.readouterr().err
    first = [path.name for path in home.rglob("*.nc")]
    assert len(first) == 1, first
    assert app.main([*words, "--yes"]) == 0


@pytest.mark.slow
@needs_reader
def test_measured_map_is_rolled(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, kept = measurement("x3p-2.x3p"), tmp_path / "rolled.nc"
    assert (
        app.main(
            [
                "roll",
                str(path),
                *shlex.split(
                    "--crop '300:312, 300:332' --counter-body 'cylinder 0.5 mm 90 deg' "
                    "--load '5 mN' --material 42CrMo4 --hardening 'linear 20 GPa' "
                    "--boundary periodic --passes 2 --steps 3 --output"
                ),
                str(kept),
                "--quiet",
            ]
        )
        == 0
    )
    assert capsys.readouterr().err == ""
    found = rc.read_result(kept)
    before = rc.read_surface(path).cropped((300, 312), (300, 332)).leveled()
    surface = found.result.solution.surface
    np.testing.assert_array_equal(surface.heights, before.heights)
    assert surface.provenance.source == "x3p-2.x3p"
    # Its peaks are pressed in, and nothing else: Sq is that of waves that the roller follows.
    first, last = found.passes
    assert 0.3 * before.roughness()["Spk"] < last.Spk < first.Spk < 0.6 * before.roughness()["Spk"]
    assert last.Sq == pytest.approx(before.roughness()["Sq"], rel=0.01)
    assert last.strain_added < 0.05 * first.strain_added
    pressed = found.rolled_surface.heights - before.heights
    yielded = found.result.bodies[0].accumulated.max(axis=0) > 0
    assert pressed[yielded].mean() < pressed[~yielded].mean()
    assert "Rottger2022" in {work.key for work in found.references()}
