import dataclasses
import html
import json
import tomllib
from pathlib import Path

import numpy as np
import pytest
import xarray

import roughcontact as rc
from messages import fault
from reading import measurement
from roughcontact import cautions
from roughcontact.cautions import (
    Caution,
    CautionTag,
    Severity,
    as_caution,
    as_note,
    as_warning,
    merge_cautions,
    sort_cautions,
)
from roughcontact.contact import plausibility
from roughcontact.contact.result import Regime
from roughcontact.errors import ArgumentRef, InputError, render_message
from roughcontact.material import catalog
from roughcontact.material.material import contact_modulus
from roughcontact.report import phrases
from roughcontact.surface import nominal_bodies, provenance, random_surfaces, shapes

STEEL = rc.Material(210e9, 0.3, 1e9, "steel")
PIXEL = (1e-6, 1e-6)


def ball(points: int = 32) -> rc.Surface:
    return rc.Surface(shapes.paraboloid((points, points), PIXEL, 1e-3), PIXEL)


def kinds(result: rc.ContactResult | rc.results.StressResult) -> list[str]:
    return [caution.kind for caution in result.cautions]


def test_each_caution_has_its_tag_and_its_numbers() -> None:
    result = rc.solve(ball(16), material=STEEL, load=2.0, ceiling=None)
    assert kinds(result) == [CautionTag.ABOVE_CEILING, CautionTag.EDGE]
    assert result.regime is Regime.BEYOND_CEILING
    first = result.cautions[0]
    assert first.numbers["ratio"] == pytest.approx(result.max_pressure / 3e9)
    assert ArgumentRef("ceiling", "calibrated") in first.parts
    heights = np.array(ball().heights)
    heights[16, 16] = np.nan
    holed = rc.solve(rc.Surface(heights, PIXEL).masked(), material=STEEL, load=1e-2)
    (missing,) = holed.cautions
    assert (missing.kind, missing.severity) == (CautionTag.MISSING, Severity.NOTE)
    # Of the points near the contact.
    assert missing.numbers == {"share": pytest.approx(1 / 60), "missing": 1}


def test_every_tag_has_one_paragraph() -> None:
    """Each tag that the package uses is explained, and each explained tag is used."""
    text = Path(cautions.__file__).with_name("explanations.toml").read_text(encoding="utf-8")
    assert list(tomllib.loads(text)) == [str(kind) for kind in CautionTag]
    assert all(len(cautions.explain_tag(kind)) > 60 for kind in CautionTag)
    with pytest.raises(InputError, match="not-converged, units"):
        cautions.explain_tag("edges")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("Twenty " + "words " * 19 + "and one.", "22 words"),
        ("no capital.", "no sentence"),
        ("No stop", "no sentence"),
        ("Two; clauses.", "several clauses"),
        ("One: two: three.", "several clauses"),
        ("1.9 % of the load is at the map edge. Use it.", ""),
    ],
)
def test_messages_are_short(text: str, words: str) -> None:
    old = Caution("an old kind", (text,))
    assert fault(old).startswith(words) if words else fault(old) == ""
    if words:
        with pytest.raises(AssertionError):
            Caution(CautionTag.EDGE, (text,))


def test_messages_recommend_one_value_per_option() -> None:
    roller = nominal_bodies.cylinder(radius=5e-3, shape=(64, 16), pixel=(4e-6, 4e-6))
    sphere = rc.Surface(shapes.paraboloid((32, 32), PIXEL, 1e-4), PIXEL)
    mixed = dataclasses.replace(STEEL, hardness=2e9)
    results = [
        rc.solve(body, load=load, material=material, ceiling=ceiling, calibrated=False)
        for body, load in ((roller, rc.HertzPressure(2.5e9)), (sphere, 0.5), (sphere, 0.2))
        for material in (STEEL, mixed)
        for ceiling in ("auto", None, 6e9)
    ]
    several = set()
    for result in results:
        values: dict[str, set[object]] = {}
        for caution in result.cautions:
            for part in caution.parts:
                if isinstance(part, ArgumentRef):
                    values.setdefault(part.name, set()).add(part.value)
        assert all(len(found) == 1 for found in values.values()), values
        assert len(set(kinds(result))) == len(result.cautions)
        several.add(tuple(kinds(result)))
    # The edge of the map and the ends of the roller need one boundary.
    assert any({CautionTag.EDGE, CautionTag.HERTZ} <= {*of} for of in several)
    assert any(CautionTag.ABOVE_CEILING in of for of in several)
    assert any(CautionTag.HARDNESS in of for of in several)


@pytest.mark.parametrize(
    ("boundary", "edges"), [("free", 2), ("periodic-x", 1), ("periodic-y", 1), ("periodic", 0)]
)
def test_edge_caution_applies_to_free_edges_only(boundary: str, edges: int) -> None:
    result = rc.solve(ball(), material=STEEL, load=1e-2, boundary=boundary)
    count = 0
    for axis in (0, 1):
        pressure = np.zeros((32, 32))
        pressure[(0, 5) if axis == 0 else (5, 0)] = 1e8
        count += CautionTag.EDGE in kinds(dataclasses.replace(result, pressure=pressure))
    assert count == edges


def test_unconverged_result_has_caution_with_option() -> None:
    result = rc.solve(ball(64), material=STEEL, load=1e-2, max_iterations=2, on_failure="return")
    (caution,) = (c for c in result.cautions if c.kind == CautionTag.NOT_CONVERGED)
    assert caution.numbers["certificate"] == result.certificate
    assert ArgumentRef("max_iterations") in caution.parts
    assert "Increase --max-iterations." in render_message(
        caution.parts, lambda mention: f"--{mention.name.replace('_', '-')}"
    )


def test_cautions_of_the_stress_are_those_of_the_contact_and_its_own() -> None:
    result = rc.solve(ball(16), material=STEEL, load=2.0, ceiling=None)
    stress = rc.subsurface_stress(result)
    assert set(stress.cautions) == {*result.cautions, *stress.own_cautions}
    assert CautionTag.YIELDED in kinds(stress)
    assert stress.cautions == sort_cautions(stress.cautions)
    assert stress.warnings == tuple(caution.text for caution in stress.cautions)


def test_regime_considers_both_bodies() -> None:
    # The weaker body first yields at 1.63 of its strength, the stronger one already at 1.39.
    weak = rc.Material(210e9, 0.31, 913e6)
    early = rc.Material(210e9, 0.1, 930e6)
    result = rc.solve(ball(64), material=weak, counter_material=early, load=1e-2)
    first = early.first_yield_pressure
    assert first is not None
    between = 0.5 * (first + (weak.first_yield_pressure or 0.0))
    scaled = dataclasses.replace(result, pressure=result.pressure * between / result.max_pressure)
    assert scaled.regime is Regime.YIELDING_BELOW
    assert "a sphere of the counter-body first yields" in phrases.regime(scaled)
    below = dataclasses.replace(result, pressure=scaled.pressure * 0.99 * first / between)
    assert below.regime is Regime.BELOW_FIRST_YIELD


def test_regime_compares_strength_and_hardness() -> None:
    ceramic = rc.Material(300e9, 0.25, hardness=2e9)
    steel = rc.Material(210e9, 0.3, 1e9)
    result = rc.solve(ball(64), material=steel, counter_material=ceramic, load=1e-2, ceiling=None)
    scaled = dataclasses.replace(result, pressure=result.pressure * 1.8e9 / result.max_pressure)
    assert scaled.regime is Regime.YIELDING_BELOW
    assert "reaches the hardness" in phrases.regime(scaled)
    weak = dataclasses.replace(result, pressure=result.pressure * 1.5e9 / result.max_pressure)
    assert weak.regime is Regime.UNKNOWN


@pytest.mark.long
def test_all_outputs_have_same_cautions(tmp_path: Path) -> None:
    heights = np.array(ball(32).heights)
    heights[10:20, 3:12] = np.nan
    surface = rc.Surface(heights, PIXEL).filled()
    result = rc.solve(surface, material=STEEL, load=1e-7)
    assert {CautionTag.PIXEL, CautionTag.MOSTLY_FILLED} <= set(kinds(result))
    result.save(tmp_path / "result.nc")
    result.report(tmp_path / "result.html")
    again = rc.read_result(tmp_path / "result.nc")
    assert again.warnings == result.warnings == tuple(result.summary()["warnings"])
    with xarray.open_dataset(tmp_path / "result.nc") as dataset:
        assert dataset.attrs["warnings"] == "\n".join(result.warnings)
        assert json.loads(dataset.attrs["cautions"]) == [c.summary() for c in result.cautions]
    page = html.unescape((tmp_path / "result.html").read_text(encoding="utf-8"))
    assert all(text in page for text in result.warnings)


def test_cautions_are_sorted_by_severity_without_repeated_tag() -> None:
    note, warning = (
        as_note(CautionTag.RESOLUTION, "A."),
        as_warning(CautionTag.EDGE, "B.", edge_load=0.02),
    )
    worse = as_warning(CautionTag.EDGE, "C.", edge_load=0.2)
    old = Caution("contact at the edge of the map", ("of version 0.2.0",))
    assert sort_cautions([note, warning, old, worse, note]) == (worse, old, note)
    every = [as_caution(kind, "A.") for kind in CautionTag]
    assert sort_cautions(reversed(every)) == tuple(every)


def test_results_of_version_0_2_0_keep_their_kinds_and_texts() -> None:
    text = {
        "kind": "lateral resolution of the measurement",
        "severity": "note",
        "text": "waves shorter than 2 µm are mostly noise",
        "numbers": {},
    }
    (old,) = cautions.from_text(json.dumps([text]))
    assert old.summary() == text


def test_merged_cautions_keep_worst_and_count() -> None:
    def merge_at_shares(*shares: float) -> tuple[Caution, ...]:
        several = [
            (
                f"{n} N",
                [as_warning(CautionTag.EDGE, "So. Use ", ArgumentRef("a"), ".", share=share)],
            )
            for n, share in enumerate(shares, start=1)
        ]
        return merge_cautions([*several, ("9 N", [])], "loads")

    (worst,) = merge_at_shares(0.1, 0.3, 0.2)
    assert (worst.numbers["share"], worst.place) == (0.3, "2 N")
    assert worst.text == "So (3 of 4 loads, worst 2 N). Use a."
    assert ArgumentRef("a") in worst.text.parts
    (one,) = merge_at_shares(0.1)
    assert one.text == "So (1 of 2 loads, 1 N). Use a."
    (maps,) = merge_cautions(
        [("a.x3p", merge_at_shares(0.1)), ("b.x3p", merge_at_shares(0.2, 0.3))], "maps"
    )
    assert maps.text == "So (2 of 2 maps, worst b.x3p at 2 N). Use a."
    # Equal cautions need no place; the fewest pixels are the worst.
    same = as_note(CautionTag.ONE_ROUGH_FACE, "A.")
    assert merge_cautions([("a", [same]), ("b", [same])], "maps") == (same,)
    assert merge_cautions([("a", [same]), ("b", [])], "maps")[0].text == "A (1 of 2 maps)."
    few, many = (as_warning(CautionTag.PIXEL, f"{n}.", pixels=n) for n in (2, 9))
    assert merge_cautions([("a", [many]), ("b", [few])], "maps")[0].place == "b"


def test_many_filled_points_give_warning_with_share() -> None:
    heights = np.array(ball(32).heights)
    heights[2:4, 2:5] = np.nan
    few = rc.solve(rc.Surface(heights, PIXEL).filled(), material=STEEL, load=1e-2)
    assert few.cautions == ()
    heights[10:30, 2:12] = np.nan
    many = rc.solve(rc.Surface(heights, PIXEL).filled(), material=STEEL, load=1e-7)
    first = many.cautions[0]
    assert (first.kind, first.severity) == (CautionTag.MOSTLY_FILLED, Severity.WARNING)
    assert first.numbers["filled"] == 206 / 1024
    assert CautionTag.PIXEL in kinds(many)


def test_the_share_of_filled_points_is_that_of_the_file() -> None:
    heights = np.array(ball(32).heights)
    heights[2:4, 2:5] = np.nan
    filled = rc.Surface(heights, PIXEL).filled()
    coarse = filled.resampled(pixel=(2e-6, 2e-6), method="spline")
    for surface in (filled, filled.leveled(), filled.rotated(), coarse):
        assert surface.provenance.filled_share(surface.heights.size) == 6 / 1024
    # Of a part the share is its own.
    part = filled.leveled().cropped((0, 8), (0, 4))
    assert part.provenance.filled_share(part.heights.size) == 4 / 32
    assert part.cropped((4, 8), (0, 4)).provenance.filled_share(16) == 0
    assert coarse.cropped((0, 4), (0, 4)).provenance.filled_share(16) == 6 / 1024
    again = provenance.from_text(provenance.to_text(part.provenance))
    assert again.filled_share(32) == 4 / 32
    # Files of an earlier version have no number of points.
    old = rc.Provenance(operations=[provenance.Operation("filled", found={"missing": 6})])
    assert old.filled_share(60) == 0.1


def test_a_map_of_few_measured_points_is_filled_on_request_only() -> None:
    heights = np.array(ball(32).heights)
    heights[:, 3:] = np.nan
    holed = rc.Surface(heights, PIXEL)
    with pytest.raises(InputError) as refused:
        holed.filled()
    assert refused.value.value == 29 / 32
    assert holed.filled(most=1.0).missing == 0
    assert holed.cropped((0, 32), (0, 4)).filled().provenance.filled_share(128) == 0.25


def test_large_strains_warn_before_all_but_wrong_units() -> None:
    rubber = rc.Material(3e6, 0.5)
    modulus = contact_modulus(rubber, rc.RIGID)
    result = rc.solve(ball(16), material=rubber, load=1e-5)
    for strain, severity in ((0.09, None), (0.29, Severity.CAUTION), (0.31, Severity.WARNING)):
        factor = strain * modulus / result.max_pressure
        scaled = dataclasses.replace(result, pressure=result.pressure * factor)
        cautions = {caution.kind: caution for caution in scaled.cautions}
        assert (
            cautions[CautionTag.STRAIN].severity if severity else cautions.get(CautionTag.STRAIN)
        ) is severity
        if severity:
            assert cautions[CautionTag.STRAIN].numbers["strain"] == pytest.approx(strain)
    assert scaled.cautions[0].kind == CautionTag.STRAIN


def test_decisive_adhesion_gives_warning() -> None:
    big = rc.Surface(shapes.paraboloid((64, 64), (2e-5, 2e-5), 1e-2), (2e-5, 2e-5))
    rubber = rc.Material(3e6, 0.5)
    soft = rc.solve(big, material=rubber, load=1e-2)
    first = soft.cautions[0]
    assert (first.kind, first.severity) == (CautionTag.ADHESION, Severity.WARNING)
    # 1.5 π w R = 2.36 mN (Johnson, Kendall and Roberts 1971), with w = 50 mJ/m².
    assert first.numbers["pull_off_over_load"] == pytest.approx(0.236, rel=0.05)
    less = rc.solve(big, material=rubber, load=0.05)
    (milder,) = (c for c in less.cautions if c.kind == CautionTag.ADHESION)
    assert milder.severity is Severity.CAUTION
    # The roughness of a smooth metal, too short for any map, keeps it from sticking.
    assert rc.solve(ball(), material=STEEL, load=1e-3).cautions == ()


def test_spots_of_few_atoms_give_caution() -> None:
    pixel = (2e-10, 2e-10)
    tip = rc.Surface(shapes.paraboloid((32, 32), pixel, 1e-8), pixel)
    result = rc.solve(tip, material=STEEL, load=1e-9)
    (caution,) = (c for c in result.cautions if c.kind == CautionTag.FEW_ATOMS)
    assert caution.severity is Severity.WARNING
    assert caution.numbers["atoms"] == pytest.approx(result.contact_area / 6.25e-20)
    assert CautionTag.ADHESION in kinds(result)


def test_caveat_of_material_is_saved_with_result(tmp_path: Path) -> None:
    bearing = catalog.material("PTFE")
    result = rc.solve(ball(), material=bearing, counter_material=bearing, load=1e-2)
    (caution,) = (item for item in result.cautions if item.kind == CautionTag.MATERIAL)
    assert caution.severity is Severity.WARNING
    assert caution.text.startswith("PTFE is viscoelastic: ")
    result.save(tmp_path / "result.nc")
    again = rc.read_result(tmp_path / "result.nc")
    assert again.material == bearing
    assert again.cautions == result.cautions
    assert CautionTag.MATERIAL not in kinds(rc.solve(ball(), material=STEEL, load=1e-2))


def test_edge_caution_states_effect_and_remedy() -> None:
    result = rc.solve(ball(16), material=STEEL, load=0.5)
    (caution,) = (c for c in result.cautions if c.kind == CautionTag.EDGE)
    assert ArgumentRef("boundary", "periodic") in caution.parts
    assert caution.severity is Severity.WARNING
    inner = float(result.pressure[1:-1, 1:-1].sum() / result.pressure.sum())
    assert caution.numbers["edge_load"] == pytest.approx(1 - inner)


def test_yield_strength_hardness_and_law_are_consistent() -> None:
    """The calibrated ceiling does not depend on the first one."""
    iron = rc.Material(210e9, 0.3, 5e8, "iron", hardness=2.5e9)
    small = rc.Surface(shapes.paraboloid((48, 48), PIXEL, 1e-4), PIXEL)
    usual = rc.solve(small, material=iron, load=0.3)
    full = rc.solve(small, material=iron, load=0.3, ceiling=iron.hardness)
    own = rc.solve(small, material=iron, load=0.3, ceiling="calibrated")
    assert usual.calibrated is not None
    assert full.calibrated is not None
    assert 1.5e9 < own.ceiling <= 2.5e9
    for calibrated in (usual.calibrated, full.calibrated):
        assert calibrated.ceiling == pytest.approx(own.ceiling, rel=5e-3)
        assert calibrated.contact_area == pytest.approx(own.contact_area, rel=0.02)
    for result in (usual, full):
        (message,) = (c for c in result.cautions if c.kind == CautionTag.CEILING)
        assert message.numbers["recommended_ceiling"] == pytest.approx(own.ceiling, rel=0.02)
    assert CautionTag.CEILING not in kinds(own)
    assert not any(CautionTag.HARDNESS in kinds(result) for result in (usual, full, own))


def test_ceiling_above_hardness_gives_caution() -> None:
    steel = rc.Material(210e9, 0.3, 3.25e9, "M2", hardness=8.8e9)
    assert steel.tabor_ratio is None
    mixed = dataclasses.replace(steel, hardness=7e9)
    assert mixed.tabor_ratio == pytest.approx(9.75 / 7)
    small = rc.Surface(shapes.paraboloid((32, 32), PIXEL, 1e-4), PIXEL)
    (caution,) = (
        c
        for c in rc.solve(small, material=mixed, load=1.0).cautions
        if c.kind == CautionTag.HARDNESS
    )
    assert caution.numbers["hardness"] == 7e9
    law = rc.hardening.Linear(3.25e9, 1e9)
    assert rc.Material(210e9, 0.3, hardness=7e9, hardening=law).tabor_ratio is None


def rough() -> np.ndarray:
    waves = {"rms_height": 1e-7, "rolloff_wavelength": 3e-5, "cutoff_wavelength": 4e-6}
    return random_surfaces.self_affine((128, 128), PIXEL, **waves, rng=np.random.default_rng(3))


def test_spikes_give_caution_with_outlier_option() -> None:
    heights = rough()
    heights[20:30:3, 40] += 1e-5
    pressed = {"material": STEEL, "load": 0.1, "boundary": "periodic", "ceiling": None}
    spiky = rc.solve(rc.Surface(heights, PIXEL), **pressed)
    (caution,) = (c for c in spiky.cautions if c.kind == CautionTag.SPIKES)
    assert ArgumentRef("outliers", 6.0) in caution.parts
    assert caution.numbers["kurtosis"] > 20
    assert caution.numbers["peak"] > 10
    cleaned = rc.Surface(heights, PIXEL).without_outliers(6.0).filled()
    sound = rc.solve(cleaned, **pressed)
    assert CautionTag.SPIKES not in kinds(sound)
    # The spikes alone carry a light load.
    assert sound.contact_fraction > 10 * spiky.contact_fraction


def test_pits_and_single_bumps_are_no_spikes() -> None:
    pitted = rough()
    pitted[20:30:3, 40] -= 1e-5
    bump = np.zeros((128, 128))
    bump[60:64, 60:64] = 1e-6
    for heights in (rough(), pitted, bump):
        assert plausibility.spike_statistics(rc.Surface(heights, PIXEL)) is None


@pytest.mark.parametrize(
    ("name", "spiky"),
    [
        ("sur-2.sur", True),
        ("metropro-1.dat", True),
        ("mnt-1.mnt", True),
        ("wyko_nt1100_test_1.opd", False),
        ("x3p-2.x3p", False),
        ("opd-1.opd", False),
        ("bullet_land_fixed.x3p", False),
        ("dvd_afm.sur", False),
        ("uncd_afm.001", False),
    ],
)
def test_measured_maps_are_spiky_only_until_their_outliers_are_out(name: str, spiky: bool) -> None:
    surface = rc.read_surface(measurement(name)).leveled()
    assert (plausibility.spike_statistics(surface) is not None) == spiky
    if spiky:
        assert plausibility.spike_statistics(surface.without_outliers(6.0).leveled()) is None


def test_leading_spike_of_wavy_surface_gives_warning() -> None:
    # The waves hide it from the kurtosis; the approach is that of two pixels of dust.
    y, x = np.mgrid[:64, :64] * (2 * np.pi / 64)
    waves = 2e-6 * (np.cos(2 * x) + np.cos(y))
    waves += 2e-8 * np.random.default_rng(1).standard_normal(waves.shape)
    sound = rc.Surface(waves, PIXEL)
    spiked = waves.copy()
    spiked[32, 16] += 9e-6
    result = rc.solve(rc.Surface(spiked, PIXEL), material=STEEL, load=0.05, boundary="periodic")
    assert plausibility.spike_statistics(result.surface) is None
    (caution,) = (c for c in result.cautions if c.kind == CautionTag.SPIKES)
    lead = np.sort(spiked.ravel())[-1] - np.sort(spiked.ravel())[-2]
    assert caution.numbers["lead"] == pytest.approx(lead)
    assert caution.severity is Severity.WARNING
    before = rc.solve(sound, material=STEEL, load=0.05, boundary="periodic")
    assert CautionTag.SPIKES not in kinds(before)
    assert before.approach < 0.5 * result.approach


@pytest.mark.parametrize("load", [1e-5, 1e-3, 0.1, 3.0])
def test_the_summits_of_a_rough_surface_are_no_spikes(load: float) -> None:
    for seed in range(3):
        rough = random_surfaces.self_affine(
            (64, 64),
            PIXEL,
            rms_height=0.3e-6,
            rolloff_wavelength=32e-6,
            cutoff_wavelength=4e-6,
            rng=np.random.default_rng(seed),
        )
        result = rc.solve(rc.Surface(rough, PIXEL), material=STEEL, load=load, boundary="periodic")
        assert CautionTag.SPIKES not in kinds(result)
