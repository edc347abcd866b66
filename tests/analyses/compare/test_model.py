"""Comparison of maps: means, differences, and the shares of surface and instrument."""

from __future__ import annotations

import html
import json
import re
import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from roughcontact._tools import statistics
from roughcontact.analyses.compare import report as comparison
from roughcontact.cautions import CautionTag
from roughcontact.cli import app
from roughcontact.errors import ArgumentRef
from roughcontact.surface import form, roughness

STEEL = rc.Material(210e9, 0.3, 1e9)
PIXEL = (1e-6, 1e-6)
PRESSURE = 200e6
MAPS = [rc.Surface(*rc.reference_map(64, seed)) for seed in range(6)]
SMOOTH = [rc.Surface(0.5 * one.heights, one.pixel) for one in MAPS[3:]]

Capture = pytest.CaptureFixture[str]


def patches(count: int, side: int, rms: float, rolloff: float, seed: int) -> list[rc.Surface]:
    """Return square parts of random surfaces, each leveled, in no order.

    Parts of one surface are not quite independent: the whole of it has the requested RMS height.
    """
    found: list[rc.Surface] = []
    for number in range(count):
        heights = rc.self_affine(
            (512, 512),
            PIXEL,
            rms_height=rms,
            rolloff_wavelength=rolloff,
            cutoff_wavelength=4e-6,
            rng=np.random.default_rng([seed, number]),
        )
        step = side + 16
        found += [
            rc.Surface(form.level(heights[i : i + side, j : j + side]), PIXEL)
            for i in range(0, 512 - side + 1, step)
            for j in range(0, 512 - side + 1, step)
        ]
        if len(found) >= count:
            break
    order = np.random.default_rng(seed).permutation(len(found))
    return [found[at] for at in order[:count]]


@pytest.mark.slow
def test_intervals_of_the_command_hold_over_400_groups_of_maps() -> None:
    rough, smooth = patches(1600, 48, 0.3e-6, 12e-6, 1), patches(2000, 48, 0.2e-6, 24e-6, 2)
    found = [
        rc.compare(
            {"rough": rough[4 * n : 4 * n + 4], "smooth": smooth[5 * n : 5 * n + 5]},
            material=STEEL,
            pressure=PRESSURE,
            steps=1,
            tolerance=1e-4,
        )
        for n in range(400)
    ]
    for name in ("contact_fraction", "mean_gap", "Sq"):
        values = [
            [value for one in found for value in one.groups[at].values(name)] for at in (0, 1)
        ]
        first, second = (float(np.mean(one)) for one in values)
        means = [one.mean(0, name) for one in found]
        apart = [one.differences(name)[0, 1] for one in found]
        held = sum(one.low <= first <= one.high for one in means)
        assert 0.93 <= held / 400 <= 0.97, name
        held = sum(one.low <= second - first <= one.high for one in apart)
        assert 0.93 <= held / 400 <= 0.97, name


def test_every_number_is_that_of_a_solve_under_the_same_nominal_pressure() -> None:
    wide = rc.Surface(np.tile(MAPS[2].heights, 2), MAPS[2].pixel)
    found = rc.compare([MAPS[0], wide], material=STEEL, pressure="100 MPa", steps=3)
    assert found.pressures == pytest.approx((1e6, 1e7, 1e8))
    (group,) = found.groups
    for surface, sample in zip([MAPS[0], wide], group.samples, strict=True):
        alone = rc.solve(surface, material=STEEL, load=1e8 * surface.size[0] * surface.size[1])
        for name in ("contact_fraction", "saturated_fraction", "max_pressure", "approach"):
            assert sample.numbers[name] == pytest.approx(getattr(alone, name), rel=1e-3), name
        assert sample.numbers["Sq"] == surface.Sq
        assert sample.over_pressure("mean_gap")[-1] == sample.numbers["mean_gap"]
    both = [one.numbers["mean_gap"] for one in group.samples]
    assert found.mean(0, "mean_gap").value == pytest.approx(np.mean(both))
    assert found.curve(0, "mean_gap")[-1] == found.mean(0, "mean_gap")
    (sizes,) = (c for c in found.cautions if c.kind == CautionTag.UNLIKE_SIZE)
    assert sizes.numbers["smallest"] == pytest.approx(1e-8)
    assert sizes.numbers["largest"] == pytest.approx(2e-8)


def test_smoother_surface_has_significantly_larger_contact() -> None:
    found = rc.compare({"rough": MAPS[:3], "smooth": SMOOTH}, material=STEEL, pressure=1e8, steps=1)
    apart = found.differences("contact_fraction")[0, 1]
    assert apart.excludes_zero
    assert apart.value > 0
    values = [group.values("contact_fraction") for group in found.groups]
    assert apart == statistics.differences(values)[0, 1]
    assert "smooth against rough" in " ".join(repr(found).split())
    pairs = replace(found, paired=True)
    assert pairs.differences("Sdq")[0, 1] == statistics.paired_difference(
        *(group.values("Sdq") for group in found.groups)
    )
    split = found.components("contact_fraction")
    assert split is not None
    assert 0.5 < split.share < 1
    kinds = [caution.kind for caution in found.cautions]
    # Holm: the smallest p of all numbers counts once for each number.
    smallest = min(found.differences(name)[0, 1].p for name in found.names)
    assert min(found.corrected.values()) == pytest.approx(len(found.names) * smallest)
    assert not {CautionTag.FEW_MAPS, CautionTag.UNLIKE_PIXEL, CautionTag.UNLIKE_SIZE} & {*kinds}


@pytest.mark.slow
@pytest.mark.long
def test_three_groups_are_compared_in_pairs() -> None:
    groups = {"a": MAPS[:2], "b": MAPS[2:4], "c": MAPS[4:]}
    found = rc.compare(groups, material=STEEL, pressure=1e8, steps=1)
    assert list(found.differences("Sdq")) == [(0, 1), (0, 2), (1, 2)]
    found_caution = {caution.kind: caution for caution in found.cautions}
    assert len(found.corrected) == 14 * 3
    assert found_caution[CautionTag.FEW_MAPS].numbers == {"maps": 2}
    assert "of a, b, c" in found_caution[CautionTag.FEW_MAPS].text
    rows = comparison.differences(found)[1]
    # Numbers of contacts have a second row under the calibrated ceiling.
    assert sum("calibrated" not in row[0] for row in rows) == 14 * 3


def test_before_and_after_a_first_loading_are_pairs() -> None:
    found = rc.compare(
        MAPS[:3], material=STEEL, pressure="50 MPa", steps=1, preload_pressure="400 MPa"
    )
    before, after = found.groups
    assert (before.name, after.name, found.paired) == ("before", "after", True)
    history = rc.history(MAPS[0], [4e8 * 1e-8, 0.0], material=STEEL)
    assert after.samples[0].numbers["Sq"] == history.residual.Sq
    change = found.differences("contact_fraction")[0, 1]
    values = (group.values("contact_fraction") for group in found.groups)
    assert change == statistics.paired_difference(*values)
    # Flattened summits carry the smaller load on more area, and below the ceiling.
    assert change.value > 0
    assert after.values("saturated_fraction") == [0, 0, 0]
    # No share falls by more than all of it.
    assert "(−100 to " in comparison._change(found, "saturated_fraction")
    assert found.components("Sq") is None


def test_different_pixels_and_cutoffs_give_caution() -> None:
    coarse = MAPS[1].resampled((32, 32))
    found = rc.compare([MAPS[0], coarse], material=STEEL, pressure=1e8, steps=1)
    (pixels,) = (c for c in found.cautions if c.kind == CautionTag.UNLIKE_PIXEL)
    assert pixels.numbers["largest"] == pytest.approx(3.125e-6)
    assert ArgumentRef("pixel") in pixels.parts
    smoothed = MAPS[1].filtered(s="40 um")
    found = rc.compare([MAPS[0], smoothed], material=STEEL, pressure=1e8, steps=1)
    (waves,) = (c for c in found.cautions if c.kind == CautionTag.UNLIKE_PIXEL)
    assert ArgumentRef("s") in waves.parts


def test_incomparable_groups_raise_input_error() -> None:
    with pytest.raises(rc.InputError, match="single map") as caught:
        rc.compare([MAPS[0]], material=STEEL, pressure=1e8)
    assert caught.value.argument == "maps"
    with pytest.raises(rc.InputError, match="group without maps"):
        rc.compare({"a": MAPS[:2], "b": []}, material=STEEL, pressure=1e8)
    with pytest.raises(rc.InputError, match="two groups with the same number of maps"):
        rc.compare({"a": MAPS[:2], "b": MAPS[:1]}, material=STEEL, pressure=1e8, paired=True)
    with pytest.raises(rc.InputError, match="a single group of maps"):
        rc.compare(
            {"a": MAPS[:1], "b": MAPS[1:2]}, material=STEEL, pressure=1e8, preload_pressure=1
        )
    soft = rc.Material(70e9, 0.3, 1e8)
    with pytest.raises(rc.InputError, match="indents the counter-body"):
        rc.compare(
            MAPS[:2], material=STEEL, counter_material=soft, pressure=1e6, preload_pressure=1e8
        )
    coated = rc.Material(210e9, 0.3, 1e9, coating=[rc.Layer(450e9, 0.25, 2e-6)])
    for bodies in ({"material": coated}, {"material": STEEL, "counter_material": coated}):
        with pytest.raises(rc.InputError, match="bodies without a coating") as caught:
            rc.compare(MAPS[:2], **bodies, ceiling=1e9, pressure=1e6, preload_pressure=1e8)
        assert caught.value.argument == "preload_pressure"
    for pressure in ("1 N", 0, -1.0):
        with pytest.raises(rc.InputError) as caught:
            rc.compare(MAPS[:2], material=STEEL, pressure=pressure)
        assert caught.value.argument == "pressure"


def test_a_map_is_cut_into_equal_parts() -> None:
    surface = rc.Surface(MAPS[0].heights[:, :50], PIXEL)
    parts = rc.partition(surface, 3, "none")
    assert [part.shape for part in parts] == [(21, 16)] * 9
    assert np.array_equal(parts[5].heights, surface.heights[21:42, 32:48])
    tilted = rc.Surface(np.add.outer(np.arange(64.0), np.arange(64.0)), PIXEL)
    assert all(np.abs(part.heights).max() < 1e-9 for part in rc.partition(tilted))
    holes = MAPS[0].heights.copy()
    holes[:32, :20] = np.nan
    left = rc.partition(rc.Surface(holes, PIXEL).masked())
    assert len(left) == 3
    with pytest.raises(rc.InputError, match="16 points") as caught:
        rc.partition(surface, 4)
    assert caught.value.argument == "divisions"


# The command


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, surface in zip(
        ("g1", "g2", "g3", "h1", "h2", "h3"), [*MAPS[:3], *SMOOTH], strict=True
    ):
        np.save(tmp_path / f"{name}.npy", surface.heights * 1e6)
    return tmp_path


OPTIONS = (
    *shlex.split(
        "--unit um --size '0.1 mm x 0.1 mm' --young '210 GPa' --poisson 0.3 "
        "--yield-strength '1 GPa' --load '100 MPa'"
    ),
)


@pytest.mark.long
def test_the_command_compares_groups(folder: Path, capsys: Capture) -> None:
    groups = (
        f"--group ground={folder}/g1.npy,{folder}/g2.npy --group ground={folder}/g3.npy "
        f"--group honed={folder}/h*.npy"
    )
    words = ["compare", *groups.split(), *OPTIONS]
    assert app.main([*words, "--steps", "1"]) == app.SOLVED
    shown = capsys.readouterr().out
    assert shown.startswith("3 ground and 3 honed maps, ")
    assert "honed against ground" in shown
    assert max(map(len, shown.splitlines())) <= 80
    places = {kind: folder / f"out.{kind}" for kind in ("csv", "html")}
    written = ["--output", str(places["csv"]), "--report", str(places["html"])]
    assert app.main([*words, "--steps", "2", *written, "--json"]) == app.SOLVED
    record = json.loads(capsys.readouterr().out)
    assert [len(group["maps"]) for group in record["groups"]] == [3, 3]
    contact = record["differences"][0]
    assert (contact["quantity"], contact["first"], contact["second"], contact["excludes_zero"]) == (
        "contact_fraction",
        "ground",
        "honed",
        True,
    )
    assert len(record["groups"][0]["curves"]["mean_gap"]) == 2
    head, *lines = places["csv"].read_text("utf-8").splitlines()
    assert head.startswith("quantity [1],unit [1],group [1],maps [1],mean [1]")
    row = next(line.split(",") for line in lines if "honed − ground" in line)
    assert row[0] == "contact_fraction"
    assert float(row[4]) == contact["value"]
    report = places["html"].read_text("utf-8")
    assert "Honed − ground: significant (95 %, Holm) in" in report
    assert report.count("<figure") == 2
    record = " ".join(html.unescape(re.sub(r"<[^>]+>", " ", report)).split())
    for words in (
        "honed − ground difference 95 % interval relative significant",
        "Young's modulus E 210 GPa rigid",
        "yield strength σ_Y 1 GPa",
        "Contact modulus E* 230.8 GPa",
        "3 GPa, three times the yield strength",
        "free: no contact beyond the map edge",
        "leveled: least-squares plane subtracted",
        "The model assumes In this case Matters if",
        "rms slope",
    ):
        assert words.lower() in record.lower(), words


@pytest.mark.long
def test_command_compares_quarters_and_sampling(folder: Path, capsys: Capture) -> None:
    files = [str(folder / name) for name in ("g1.npy", "h1.npy")]
    words = ["compare", *files, *OPTIONS, "--quarters", "--sampling", "--steps", "1", "--json"]
    assert app.main(words) == app.SOLVED
    record = json.loads(capsys.readouterr().out)
    assert [group["name"] for group in record["groups"]] == ["g1.npy", "h1.npy"]
    assert [len(group["maps"]) for group in record["groups"]] == [4, 4]
    assert 0 <= record["components"]["Sq"]["share"] <= 1
    assert [study["source"] for study in record["sampling"]] == ["g1.npy", "h1.npy"]
    kinds = [caution["kind"] for caution in record["cautions"]]
    assert kinds.count(CautionTag.PARTS) == 1
    # One map has a mean, and no interval.
    alone = ["compare", "--group", f"a={files[0]}", "--group", f"b={files[1]}", *OPTIONS]
    assert app.main([*alone, "--steps", "1", "--json"]) == app.SOLVED
    record = json.loads(capsys.readouterr().out)
    assert record["groups"][0]["means"]["Sq"]["low"] is None
    assert record["differences"][0]["excludes_zero"] is False
    assert record["components"] == {}


def test_command_rejects_incomparable_groups_in_one_sentence(folder: Path, capsys: Capture) -> None:
    first, second = str(folder / "g1.npy"), str(folder / "g2.npy")
    profile = folder / "trace.txt"
    np.savetxt(profile, np.column_stack([np.arange(64.0), 1e3 * MAPS[0].heights[0] * 1e3]))
    for words, said in (
        (["compare", first, *OPTIONS], "or --quarters for its four quarters, or --sampling"),
        (["compare", first, second, *OPTIONS[:-2]], "--load is needed: a nominal pressure"),
        (["compare", first, second, *OPTIONS[:-1], "1 N"], "--load needs a nominal pressure"),
        (["compare", "--group", first, *OPTIONS], "--group must be a name and files"),
        (
            ["compare", "--group", f"a={first}", "--group", f"b={second}", "--quarters", *OPTIONS],
            "--quarters cannot be combined with --group and --paired",
        ),
        (["compare", first, second, "--paired", *OPTIONS], "--paired needs two groups"),
        (["compare", *OPTIONS], "FILE is missing"),
        (
            ["compare", str(profile), str(profile), "--unit", "um, um", *OPTIONS[4:]],
            "is a profile; a comparison needs a map",
        ),
    ):
        assert app.main(words) == app.BAD_INPUT, words
        output = capsys.readouterr().err
        assert output.count("\n") == 1
        assert said in output


def make_group(slope: float, seeds: range, points: int = 128) -> list[rc.Surface]:
    """Return maps of one root-mean-square slope."""
    pixel = (1e-6, 1e-6)
    heights = [
        rc.self_affine(
            (points, points),
            pixel,
            rms_height=1e-7,
            rolloff_wavelength=points * pixel[0] / 3.2,
            cutoff_wavelength=8e-6,
            rng=np.random.default_rng(seed),
        )
        for seed in seeds
    ]
    return [rc.Surface(h * slope / roughness.rms_gradient(h, pixel), pixel) for h in heights]


@pytest.mark.long
def test_a_difference_whose_sign_depends_on_the_ceiling_is_not_significant() -> None:
    steel = rc.Material(210e9, 0.3, 1e9)
    groups = {"fine": make_group(0.02, range(4)), "coarse": make_group(0.06, range(10, 14))}
    found = rc.compare(groups, material=steel, pressure="100 MPa", boundary="periodic")
    # With 3 σ_Y the flat maps stay elastic; with the calibrated ceiling they saturate the most.
    assert found.corrected["saturated_fraction", (0, 1)] < 0.05
    assert found.is_ceiling_dependent("saturated_fraction")
    assert not found.is_significant("saturated_fraction")
    assert found.is_significant("mean_gap")
    assert not found.is_ceiling_dependent("mean_gap")
    fixed = rc.compare(groups, material=steel, pressure="100 MPa", boundary="periodic", ceiling=3e9)
    assert fixed.is_significant("saturated_fraction")


FILM = rc.Layer(210e9, 0.3, 5e-7, hardness="20 GPa", name="film")
COATED = {
    "material": rc.Material(210e9, 0.3, 1e9, coating=[FILM]),
    "pressure": "100 MPa",
    "boundary": "periodic",
    "steps": 1,
}


@pytest.mark.usefixtures("quick")
def test_bracket_compares_under_both_ceilings(tmp_path: Path) -> None:
    groups = {"fine": make_group(0.02, range(4), 48), "coarse": make_group(0.06, range(10, 14), 48)}
    both = rc.compare(groups, ceiling="bracket", **COATED)
    assert both.base is not None
    coating, base = (rc.compare(groups, ceiling=name, **COATED) for name in ("coating", "base"))
    for case, alone in ((both, coating), (both.base, base)):
        for name in alone.names:
            assert case.differences(name) == alone.differences(name)
            assert [case.mean(index, name) for index in (0, 1)] == [
                alone.mean(index, name) for index in (0, 1)
            ]
    clear = {
        name: [case.corrected[name, (0, 1)] < 0.05 for case in (both, both.base)]
        for name in both.names
    }
    # Nothing is at the ceiling of the coating.
    assert clear["saturated_fraction"] == [False, True]
    assert clear["contact_fraction"] == [True, True]
    assert all(both.is_significant(name) == all(found) for name, found in clear.items())
    record = both.summary()
    assert record["base"]["groups"] == base.summary()["groups"]
    for case in (record, record["base"]):
        values = {item["quantity"]: item["significant"] for item in case["differences"]}
        assert values == {name: both.is_significant(name) for name in both.names}
    both.save(tmp_path / "table.csv")
    head, *lines = (tmp_path / "table.csv").read_text("utf-8").splitlines()
    assert head.endswith("ceiling [1]")
    ceilings = {line.rsplit(",", 1)[1] for line in lines if line.startswith("contact_fraction,")}
    assert ceilings == {"coating", "base"}
    _, rows = comparison.differences(both)
    significant = {row[0]: row[-1] for row in rows}
    assert significant["saturated area, base"] == "no, not under both ceilings"
    both.report(tmp_path / "report.html")
    text = " ".join(re.sub(r"<[^>]+>", " ", (tmp_path / "report.html").read_text("utf-8")).split())
    assert "20 GPa, as given (coating); 3 GPa" in text
    assert "nan" not in text


def test_difference_whose_sign_depends_on_the_ceiling_of_the_base_is_not_significant() -> None:
    groups = {"fine": make_group(0.02, range(2), 64), "coarse": make_group(0.06, range(10, 12), 64)}
    both = rc.compare(groups, ceiling="bracket", **COATED)
    fine, coarse = (group.samples for group in both.groups)
    # The same maps, with the contacts of the base exchanged between the groups.
    exchanged = [
        replace(group, samples=tuple(replace(a, base=b.base) for a, b in pairs))
        for group, pairs in zip(
            both.groups,
            (zip(fine, coarse, strict=True), zip(coarse, fine, strict=True)),
            strict=True,
        )
    ]
    other = replace(both, groups=tuple(exchanged))
    assert not both.is_ceiling_dependent("contact_fraction")
    assert other.is_ceiling_dependent("contact_fraction")
    assert not other.is_significant("contact_fraction")
