import csv
import dataclasses
import json
import math
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.analyses.law import curve as law_curve
from roughcontact.analyses.law.curve import Curve, thin_points
from roughcontact.analyses.law.model import LOADING, UNLOADING
from roughcontact.cautions import CautionTag
from roughcontact.cli import app

SOFT = rc.Material(210e9, 0.3, 1e9)
PRESSURES = [30e6, 100e6, 300e6, 600e6]
MAPS = [rc.Surface(*rc.reference_map(64, seed)) for seed in (3, 4)]


def solve_contacts(
    surface: rc.Surface, boundary: str = "periodic", **more: object
) -> list[rc.ContactResult]:
    return [
        rc.solve(
            surface,
            load=rc.NominalPressure(p),
            boundary=boundary,
            **{"material": SOFT, **more},  # type: ignore[arg-type]
        )
        for p in PRESSURES
    ]


CONTACTS = [solve_contacts(surface) for surface in MAPS]
AGAIN = [solve_contacts(rc.indented_surface(contacts[-1]), ceiling=None) for contacts in CONTACTS]
LAW = rc.interface_law(
    (one for contacts in CONTACTS for one in reversed(contacts)),
    (one for contacts in AGAIN for one in contacts),
    conductor="42CrMo4",
    counter_conductor=rc.Conductor(resistivity="17 nohm m", conductivity=400),
)


def test_points_are_those_of_the_contacts() -> None:
    assert len(LAW.maps) == 2
    one, contacts = LAW.maps[0], CONTACTS[0]
    gap = contacts[0].initial_gap
    assert one.first_touch == pytest.approx(gap.mean())
    for point, result in zip(one.loading, contacts, strict=True):
        assert point.pressure == pytest.approx(result.load / 1e-8)
        assert point.separation == pytest.approx(gap.mean() - result.approach)
        assert point.separation == pytest.approx(result.gap.mean())
        assert point.mean_gap == pytest.approx(result.mean_gap)
        assert point.contact_fraction == pytest.approx(result.contact_fraction)
        assert point.saturated_fraction == pytest.approx(result.saturated_fraction)
        assert point.stiffness == pytest.approx(result.stiffness() / 1e-8, rel=1e-6)
        assert point.spots == result.spots().count
        assert point.contact_points + point.open_points == 64**2
    assert LAW.largest.load == max(result.load for result in contacts)
    assert {step.branch for step in LAW.steps} == {LOADING, UNLOADING}
    down = LAW.branch_steps(UNLOADING)
    assert [step.saturated_fraction for step in down] == [0.0] * 4
    lowered = (one.pair.heights - AGAIN[0][0].pair.heights).mean()
    assert one.unloading_touch == pytest.approx(AGAIN[0][0].initial_gap.mean() - lowered)
    assert one.unloading_touch < 0.99 * one.first_touch
    # Indentations are permanent: the same pressure holds the bodies closer together.
    for before, after in zip(LAW.branch_steps(LOADING)[:-1], down[:-1], strict=True):
        assert after.separation < before.separation


def test_a_law_of_elastic_contacts_has_one_branch() -> None:
    law = rc.interface_law(solve_contacts(MAPS[0], ceiling=None))
    assert law.is_elastic
    assert law.branches == (LOADING,)
    lacking = rc.interface_law(CONTACTS[0])
    assert not lacking.is_elastic
    assert lacking.branches == (LOADING,)
    assert math.isnan(law.steps[0].separation_half)


@pytest.mark.parametrize("branch", [LOADING, UNLOADING])
def test_a_thinned_table_is_right_to_one_per_cent_and_monotone(branch: str) -> None:
    curve, table = LAW.curve(branch), LAW.table(branch)
    assert table.pressure[0] == 0
    assert table.separation[0] == curve.first_touch
    assert (np.diff(table.pressure) > 0).all()
    assert (np.diff(table.separation) < 0).all()
    p = np.geomspace(PRESSURES[0], PRESSURES[-1], 5000)[1:-1]
    u = curve.separation_at(p)
    line = np.interp(-u, -table.separation[1:], table.pressure[1:])
    off = np.abs(line / p - 1).max()
    assert 0.005 < off < 0.01 * (1 + 1e-3)
    # A table of twice the error needs fewer rows.
    assert LAW.table(branch, 0.02).pressure.size < table.pressure.size < p.size / 50
    assert table.mean_gap[0] == table.separation[0]


def test_thinned_curve_matches_linear_interpolation() -> None:
    x = np.linspace(0, 1, 101)
    assert thin_points(x, 1 + x, 0.01).tolist() == [0, 100]
    bent = np.where(x < 0.5, 1 + x, 1.5 + 4 * (x - 0.5))
    assert 50 in thin_points(x, bent, 1e-9)
    x = np.linspace(0, 1, 10001)
    rows = thin_points(x, np.exp(5 * x), 0.01)
    # Each line spans √(8 · 0.01) of the exponent.
    assert rows.size == pytest.approx(1 + 5 / math.sqrt(0.08), abs=1.5)


def test_curve_is_monotone_for_any_slopes() -> None:
    p = np.array([1e6, 2e6, 4e6, 8e6])
    u = np.array([3.0, 2.9, 1.0, 0.99]) * 1e-7
    for compliance in (np.zeros(4), np.full(4, 1e-10), np.full(4, math.inf)):
        pressure, separation = Curve(p, u, compliance, 5e-7).fine()
        assert (np.diff(separation) < 0).all()
        assert (np.diff(pressure) > 0).all()
    # Closed: further pressure changes nothing, and the table ends.
    closed = Curve(p, np.array([3.0, 1.0, 0.0, 0.0]) * 1e-7, np.full(4, 1e-15), 5e-7)
    assert closed.table()[0][-1] <= 4e6 * (1 + 1e-12)


@pytest.mark.parametrize("points", [4, 6, 9])
def test_curve_error_matches_interpolation_error(points: int) -> None:
    # ū = Δ (1 - m + m ln m): Westergaard's, whose slope is Δ m ln m.
    def separation_of(m: np.ndarray) -> np.ndarray:
        return 1e-7 * (1 - m + m * np.log(m))

    m = np.geomspace(0.05, 0.8, points)
    fine = np.geomspace(0.05, 0.8, 999)
    for compliance in (-1e-7 * np.log(m), None):
        curve = Curve(m, separation_of(m), compliance, 1e-7)
        off = np.abs(curve.separation_at(fine) - separation_of(fine)) / (
            -1e-7 * fine * np.log(fine)
        )
        assert 0.6 * off.max() < curve.error < 1.6 * off.max()


def test_the_range_ends_where_too_few_spots_or_too_much_touch() -> None:
    p = np.array([1.0, 2.0, 3.0, 4.0])
    means = {
        "spots": np.array([3.0, 20, 40, 1]),
        "contact_points": np.array([5.0, 90, 500, 900]),
        "open_points": np.array([995.0, 900, 500, 20]),
        "contact_fraction": np.array([0.005, 0.1, 0.5, 0.98]),
    }
    found = law_curve.resolved_range(p, means, 10.0)
    assert (found.low, found.high) == (3.0, 3.0)
    assert (found.low_by, found.high_by) == ("points", "contact")
    found = law_curve.resolved_range(p, {**means, "contact_points": np.full(4, 1e3)}, 2.5)
    assert (found.low, found.high, found.low_by, found.high_by) == (2.0, 2.0, "spots", "slope")
    found = law_curve.resolved_range(p, means, 1.5)
    assert math.isnan(found.low)
    kinds = {str(caution.kind) for caution in LAW.cautions}
    assert CautionTag.FEW_MAPS in kinds


def test_law_reports_smooth_counter_face() -> None:
    assert sum(caution.kind == CautionTag.ONE_ROUGH_FACE for caution in LAW.cautions) == 1
    rough = rc.interface_law(solve_contacts(MAPS[0], counter_surface=MAPS[1]))
    assert CautionTag.ONE_ROUGH_FACE not in {caution.kind for caution in rough.cautions}


@pytest.mark.long
def test_parts_give_caution_for_too_small_map() -> None:
    def quarters(surface: rc.Surface) -> rc.results.InterfaceLaw:
        parts = rc.partition(surface, 2, "mean")
        return rc.interface_law(one for part in parts for one in solve_contacts(part, ceiling=None))

    def law_with_parts(surface: rc.Surface) -> rc.results.InterfaceLaw:
        law = rc.interface_law(solve_contacts(surface, ceiling=None))
        return dataclasses.replace(law, parts=quarters(surface))

    tiled = rc.Surface(np.tile(MAPS[0].heights, (2, 2)), MAPS[0].pixel)
    law = law_with_parts(tiled)
    assert law.part_size is not None
    assert law.part_size.sufficient
    assert law.part_size.off < 1e-3
    assert CautionTag.LAW_SIZE not in {caution.kind for caution in law.cautions}
    # A hill as wide as the map, which its quarters lack.
    x = np.cos(2 * np.pi * np.arange(128) / 128)
    wavy = rc.Surface(tiled.heights + 0.6e-6 * x * x[:, None], tiled.pixel)
    (other,) = (
        caution for caution in law_with_parts(wavy).cautions if caution.kind == CautionTag.LAW_SIZE
    )
    assert other.severity == "caution"
    assert other.numbers["off"] > other.numbers["chance"]


def test_each_branch_has_conductance_of_its_contacts() -> None:
    bodies = ("42CrMo4", rc.Conductor(conductivity=400))
    for branch, solved_ones in ((LOADING, CONTACTS), (UNLOADING, AGAIN)):
        each = [rc.conductance(one, *bodies).thermal_conductance for one in solved_ones]
        assert LAW.thermal_conductance(branch) == pytest.approx(np.mean(each, axis=0), rel=1e-6)
        lines = [step.thermal_conductance for step in LAW.branch_steps(branch)]
        assert lines == LAW.thermal_conductance(branch).tolist()
        table = LAW.table(branch)
        assert table.thermal_conductance[0] == 0
        between = np.interp(PRESSURES, table.pressure, table.thermal_conductance)
        assert between == pytest.approx(LAW.thermal_conductance(branch), rel=0.02)
    # Under the largest load both are one contact, below it what flowed conducts on.
    ratio = LAW.thermal_conductance(UNLOADING) / LAW.conductance
    assert ratio[-1] == pytest.approx(1, abs=0.02)
    assert (ratio[:-1] > 1.2).all()


def test_negative_film_raises_input_error() -> None:
    with pytest.raises(rc.InputError, match="thermal_film must be zero or positive"):
        rc.interface_law(CONTACTS[0], thermal_film=-1e-6)


def test_closed_joint_has_no_resistance() -> None:
    p = [0.05e6, 0.5e6, 50e9]
    contacts = [
        rc.solve(
            MAPS[0], load=rc.NominalPressure(x), material=SOFT, ceiling=None, boundary="periodic"
        )
        for x in p
    ]
    law = rc.interface_law(contacts, conductor="42CrMo4", counter_conductor="42CrMo4")
    assert contacts[-1].contact_fraction == 1
    assert law.conductance[-1] == math.inf
    between = law.table().thermal_conductance
    assert not np.isnan(between).any()
    assert (np.diff(between[np.isfinite(between)]) >= 0).all()


def rows(text: str, keyword: str, which: int = 0) -> np.ndarray:
    """Return the data below a keyword of a deck."""
    blocks = re.findall(rf"^{re.escape(keyword)}\n((?:[-+\d].*\n)+)", text, re.MULTILINE)
    return np.array(
        [[float(word) for word in line.split(",")] for line in blocks[which].split("\n") if line]
    )


def test_decks_hold_the_table_in_their_units(tmp_path: Path) -> None:
    behavior = "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TABULAR"
    for suffix in (".inp", ".ccx"):
        LAW.save(tmp_path / f"law{suffix}")
        text = (tmp_path / f"law{suffix}").read_text("ascii")
        assert "Units: mm, N, s, t, K; pressure in MPa" in text
        assert max(map(len, text.splitlines())) < 132
        for number, branch in enumerate((LOADING, UNLOADING)):
            table = LAW.table(branch)
            found = rows(text, behavior, number)
            assert f"NAME=ROUGH_{branch.upper()}" in text
            assert found[:, 0] == pytest.approx(table.pressure * 1e-6)
            shift = 0.0 if suffix == ".inp" else table.separation[0]
            assert found[:, 1] == pytest.approx(1e3 * (shift - table.separation), abs=1e-12)
            assert found[0].tolist() == [0.0, pytest.approx(1e3 * (shift - table.separation[0]))]
            assert (np.diff(found, axis=0) > 0).all()
        # CalculiX takes the first row of such a table, 0, for any pressure.
        assert ("\n*GAP CONDUCTANCE" in text) == (suffix == ".inp")
        if suffix == ".ccx":
            text = text.replace("the row of your pressure.\n** ", "\n*X\n").replace("\n** ", "\n")
        for number, branch in enumerate((LOADING, UNLOADING)):
            keyword = "*GAP CONDUCTANCE, PRESSURE" if suffix == ".inp" else "*X"
            conductance, own = rows(text, keyword, number), LAW.thermal_conductance(branch)
            assert conductance[0].tolist() == [0.0, 0.0]
            assert conductance[-1, 0] == pytest.approx(own[-1] * 1e-3)
            p = np.array(PRESSURES) * 1e-6
            result = np.interp(p, conductance[:, 1], conductance[:, 0])
            assert result == pytest.approx(own * 1e-3, rel=0.011)


def apdl_tables(text: str) -> dict[str, np.ndarray]:
    """Return the tables of a deck for Ansys by name, shape (n, 2)."""
    cells = re.findall(r"(\w+)\((\d+),([01])\)=(\S+)", text)
    tables: dict[str, dict[tuple[int, int], float]] = {}
    for name, row, column, value in cells:
        tables.setdefault(name, {})[int(row), int(column)] = float(value)
    found = {}
    for name, size in re.findall(r"\*DIM,(\w+),TABLE,(\d+),1,1,\w+", text):
        grid = [[tables[name][row + 1, column] for column in (0, 1)] for row in range(int(size))]
        found[name] = np.array(grid)
    return found


def test_the_deck_for_ansys_gives_the_pressure_of_the_law(tmp_path: Path) -> None:
    law = dataclasses.replace(LAW, friction=rc.interface_law(CONTACTS[0], friction=0.15).friction)
    law.save(tmp_path / "law.mac")
    text = (tmp_path / "law.mac").read_text("ascii")
    assert max(map(len, text.splitlines())) < 132
    found = apdl_tables(text)
    for branch in law.branches:
        curve = law.curve(branch)
        gap, secant = found[f"ROUGH_{branch.upper()}_FKN"].T
        pressure = np.geomspace(PRESSURES[0], PRESSURES[-1], 50)
        closure = 1e3 * (curve.first_touch - curve.separation_at(pressure))
        result = -np.interp(closure, gap, secant) * closure
        assert result == pytest.approx(pressure * 1e-6, rel=0.015)
        own, conductance = found[f"ROUGH_{branch.upper()}_TCC"].T
        result = np.interp(np.array(PRESSURES) * 1e-6, own, conductance)
        assert result == pytest.approx(law.thermal_conductance(branch) * 1e-3, rel=0.011)
        own, slopes = found[f"ROUGH_{branch.upper()}_FKT"].T
        steps = law.branch_steps(branch)
        assert -slopes == pytest.approx([step.tangential_stiffness * 1e-9 for step in steps])
    # Real constants hold one branch.
    assert re.findall(r"^RMODIF,CID,(\d+),%(\w+)%", text, re.MULTILINE) == [
        ("3", "ROUGH_LOADING_FKN"),
        ("12", "ROUGH_LOADING_FKT"),
        ("14", "ROUGH_LOADING_TCC"),
        ("19", "ROUGH_LOADING_ECC"),
    ]


def test_the_functions_for_moose_are_the_law_in_si_units(tmp_path: Path) -> None:
    LAW.save(tmp_path / "law.i")
    text = (tmp_path / "law.i").read_text("ascii")
    blocks = re.findall(
        r"\[rough_(\w+?)_(\w+)\]\n    type = PiecewiseLinear\n    x = '(.*)'\n    y = '(.*)'\n",
        text,
    )
    assert {name for _, name, *_ in blocks} == {
        "pressure",
        "thermal_conductance",
        "electrical_conductance",
    }
    for branch, name, first, second in blocks:
        x, y = (np.array(words.split(), dtype=float) for words in (first, second))
        assert (np.diff(x) > 0).all()
        if name == "pressure":
            table = LAW.table(branch)
            assert y == pytest.approx(table.pressure)
            assert x == pytest.approx(table.separation[0] - table.separation, abs=1e-15)
        else:
            result = np.interp(PRESSURES, x, y)
            assert result == pytest.approx(getattr(LAW, name)(branch), rel=0.011)


def test_tables_and_numbers_are_written(tmp_path: Path) -> None:
    LAW.save(tmp_path / "law.csv")
    with (tmp_path / "law.csv").open(encoding="utf-8", newline="") as stream:
        read = list(csv.DictReader(stream))
    assert {row["branch"] for row in read} == {LOADING, UNLOADING}
    first = read[0]
    assert float(first["pressure [Pa]"]) == 0
    assert float(first["overclosure [m]"]) == -float(first["separation [m]"])
    assert len(read) == sum(LAW.table(branch).pressure.size for branch in LAW.branches)
    last = [row for row in read if row["branch"] == UNLOADING][-1]
    assert float(last["thermal_conductance [W/(m² K)]"]) == pytest.approx(
        LAW.thermal_conductance(UNLOADING)[-1]
    )
    bare = dataclasses.replace(LAW, bodies=None)
    bare.save(tmp_path / "bare.csv")
    assert (tmp_path / "bare.csv").read_text("utf-8").splitlines()[0].endswith("fraction [1]")

    LAW.save(tmp_path / "law.json")
    record = json.loads((tmp_path / "law.json").read_text("utf-8"))
    assert record["branches"]["loading"]["pressure"] == pytest.approx(PRESSURES)
    assert record["tables"]["unloading"]["error"] == 0.01
    assert record["thermal_conductance"] == pytest.approx(LAW.conductance)
    for branch in LAW.branches:
        own = record["branches"][branch]["thermal_conductance"]
        assert own == pytest.approx(LAW.thermal_conductance(branch))
        assert record["tables"][branch]["thermal_conductance"][-1] == pytest.approx(own[-1])

    LAW.save(tmp_path / "law.npz")
    with np.load(tmp_path / "law.npz") as held:
        for branch in LAW.branches:
            for name in ("pressure", "separation", "thermal_conductance"):
                values = [getattr(step, name) for step in LAW.branch_steps(branch)]
                assert held[f"{branch}_{name}"].tolist() == values

    LAW.save(tmp_path / "law.txt")
    text = (tmp_path / "law.txt").read_text("utf-8")
    found = LAW.asperities
    assert f"# bandwidth alpha = m0 m4/m2^2 = {found.bandwidth:.4g}" in text
    assert "WARNING: m4" in text
    last = text.splitlines()[-1].split(",")
    assert float(last[0]) == pytest.approx(LAW.table().separation[-1] / found.deviation)
    with pytest.raises(rc.InputError, match=r".npz, .csv, .json, .inp, .ccx, .mac, .i"):
        LAW.save(tmp_path / "law.xlsx")
    assert repr(LAW).startswith("InterfaceLaw:")
    assert len(LAW.plot().axes) == 4


@pytest.mark.long
def test_contacts_without_law_raise_input_error() -> None:
    def law(*contacts: rc.ContactResult, after: tuple[rc.ContactResult, ...] = ()) -> None:
        rc.interface_law(contacts, after)

    first = CONTACTS[0]
    with pytest.raises(rc.InputError, match="is empty: give at least two contacts"):
        law()
    with pytest.raises(rc.InputError, match="map 1 has contact inside its rim: a law needs"):
        law(first[0])
    small = rc.Surface(*rc.reference_map(32, 1))
    with pytest.raises(rc.InputError, match="are of different grids, 64 × 64 points of"):
        law(*first, *solve_contacts(small))
    coarse = rc.Surface(MAPS[1].heights, (2e-6, 2e-6))
    with pytest.raises(rc.InputError, match="different grids"):
        law(*first, *solve_contacts(coarse))
    with pytest.raises(rc.InputError, match="differ in the material of the body, E 210 GPa"):
        law(*first, *solve_contacts(MAPS[1], material=rc.Material(70e9, 0.3)))
    tiny = rc.Surface(MAPS[0].heights[:8, :8], MAPS[0].pixel)
    with pytest.raises(rc.InputError, match="has 8 × 8 points: an interface law needs 16"):
        law(*solve_contacts(tiny))
    with pytest.raises(rc.InputError, match="too small for a free boundary: a rim of"):
        law(*solve_contacts(small, "free"))
    with pytest.raises(rc.InputError, match="map 1 is not map 1 of the contacts after its largest"):
        law(*first, after=tuple(CONTACTS[1]))
    with pytest.raises(rc.InputError, match="has 1 maps, and there are 2"):
        rc.interface_law([*first, *CONTACTS[1]], AGAIN[0])
    row = rc.Surface(MAPS[0].heights[0], MAPS[0].pixel[1])
    with pytest.raises(rc.InputError, match="profile"):
        law(*(rc.solve(row, material=SOFT, load=p, boundary="periodic") for p in (1e3, 2e3)))


def command(folder: Path, *more: str) -> list[str]:
    defaults = {"--from": "30 MPa", "--to": "600 MPa", "--boundary": "periodic"}
    for number, surface in enumerate(MAPS):
        np.save(folder / f"map{number}.npy", surface.heights * 1e6)
    return [
        "law",
        *(str(folder / f"map{number}.npy") for number in range(2)),
        *shlex.split(
            "--unit um --size '0.1 mm x 0.1 mm' --level none --steps 2 --material 42CrMo4"
        ),
        *(word for name, value in defaults.items() if name not in more for word in (name, value)),
        *more,
    ]


@pytest.mark.long
def test_command_prints_draws_and_writes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = [str(tmp_path / f"law{suffix}") for suffix in (".inp", ".ccx", ".csv", ".txt", ".json")]
    words = command(
        tmp_path,
        *(word for path in out for word in ("--output", path)),
        "--quarters",
        "--counter-material",
        "6061-T6",
        "--figure",
        str(tmp_path / "law.png"),
    )
    assert app.main([*words, "--verbose"]) == app.SOLVED
    shown = " ".join(capsys.readouterr().out.split())
    assert "Overclosure is minus the separation." in shown
    assert "Map size" in shown
    # Two pressures give no error of the law between them.
    assert "nan" not in re.findall(r"\w+", shown.lower())
    assert all(Path(path).stat().st_size > 500 for path in out)
    assert "*GAP CONDUCTANCE" in Path(out[0]).read_text("ascii")
    assert (tmp_path / "law.png").stat().st_size > 1000
    assert app.main([*command(tmp_path), "--json"]) == app.SOLVED
    record = json.loads(capsys.readouterr().out)
    steel = rc.catalog.material("42CrMo4")
    pressures = record["branches"]["loading"]["pressure"]
    contacts = (
        rc.solve(surface, material=steel, load=rc.NominalPressure(p), boundary="periodic")
        for surface in MAPS
        for p in pressures
    )
    law = rc.interface_law(contacts)
    for name in ("separation", "contact_fraction", "separation_half"):
        own = [getattr(step, name) for step in law.steps]
        assert record["branches"]["loading"][name] == pytest.approx(own, rel=1e-3)
    assert set(record["branches"]) == {LOADING, UNLOADING}
    assert record["maps"] == ["map0.npy", "map1.npy"]


def test_invalid_options_are_rejected_in_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for more, said in (
        (("--to", "10 MPa"), "--from must be positive and below --to, got '30 MPa' and '10 MPa'"),
        (("--from", "30"), "--from needs a nominal pressure such as '20 MPa'"),
        (("--to", "1 TPa"), "is more than the surface can carry"),
        (("--thermal-film", "1e-6 m^2 K/W"), "--thermal-film needs --conductivity and"),
        (("--counter-surface", "other.npy"), "--counter-surface needs a single map"),
        (("--output", "law.xyz"), "--output needs a name that ends in .npz, .csv, .json, .inp"),
        (("--boundary", "free"), "too small for a free boundary"),
        (
            ("--body", "sphere 10 mm"),
            "are of curved bodies, and an interface law requires nominally flat",
        ),
    ):
        assert app.main(command(tmp_path, *more)) == app.BAD_INPUT, more
        assert said in capsys.readouterr().err
    words = command(tmp_path)
    del words[words.index("--from") : words.index("--from") + 2]
    assert app.main(words) == app.BAD_INPUT
    assert "--from is needed" in capsys.readouterr().err


@pytest.mark.slow
def test_project_runs_law(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command(tmp_path)
    project = tmp_path / "project.toml"
    text = (
        'folder = "out"\nwrite = ["inp", "csv", "png"]\n[[contact]]\nname = "joint"\n'
        'files = ["map0.npy", "map1.npy"]\ntask = "law"\nunit = "um"\nlevel = "none"\n'
        'size = "0.1 mm x 0.1 mm"\nmaterial = "42CrMo4"\nboundary = "periodic"\n'
        'from = "100 MPa"\nto = "400 MPa"\nsteps = 2\n'
    )
    project.write_text(text, encoding="utf-8")
    assert app.main(["run", str(project), "--json"]) == app.SOLVED
    record = json.loads(capsys.readouterr().out)["contacts"][0]["summary"]
    assert len(record["branches"]["loading"]["pressure"]) == 2
    assert "ROUGH_LOADING" in (tmp_path / "out" / "joint.inp").read_text("ascii")
    project.write_text(re.sub(r"files = .*\n", "", text), encoding="utf-8")
    assert app.main(["run", str(project)]) == app.BAD_INPUT
    assert 'task = "law" needs a file, or files, a list' in capsys.readouterr().err


def test_variants_give_change_of_closing_and_stiffness() -> None:
    contact = CONTACTS[0][-1]
    stiffer, last = contact.stiffness() / 1e-8, LAW.maps[0].loading[-1]
    same = LAW.with_coarser_grid(contact)
    assert same.coarser is not None
    assert same.coarser.closing == pytest.approx(0, abs=1e-9)
    assert stiffer / last.stiffness == pytest.approx(1 + same.coarser.stiffness)
    lower = rc.solve(MAPS[0], load=contact.load, boundary="periodic", material=SOFT, ceiling=2e9)
    changed = LAW.with_calibrated_ceiling(lower).calibrated
    assert changed is not None
    closing = LAW.maps[0].loading[0].separation - last.separation
    shift = float(contact.gap.mean() - lower.gap.mean())
    assert shift > 0
    assert changed.numbers[0] == pytest.approx(shift / closing)
    assert changed.numbers[1] == pytest.approx(lower.stiffness() / contact.stiffness() - 1)
    assert changed.contact_area == pytest.approx(lower.contact_area / contact.contact_area - 1)


def test_the_tangential_stiffness_is_that_of_all_that_sticks() -> None:
    found = rc.interface_law(CONTACTS[0], friction=0.2)
    assert found.friction is not None
    last = found.steps[-1]
    shear = {
        axis: rc.tangential(CONTACTS[0][-1], friction=0.2, force="1 mN", direction=angle)
        for axis, angle in (("y", 90.0), ("x", 0.0))
    }
    for ratio, axis in zip(found.friction.ratios, "yx", strict=True):
        exact = shear[axis].stiffness_per_area / last.unloading_stiffness
        assert ratio == pytest.approx(exact, rel=1e-4)
    # Mindlin's ratio of a circle; a few spots on a small map are off by some percent.
    assert found.friction.ratio == pytest.approx(2 * (1 - 0.3) / (2 - 0.3), rel=0.03)
    # At the ceiling the traction is at most σ_Y/√3: 0.192 of the pressure.
    assert 1 / (3 * math.sqrt(3)) < found.friction.sliding < 0.2
    slip = found.friction.sliding * last.pressure / last.tangential_stiffness
    assert found.elastic_slip()[-1] == pytest.approx(slip)
    assert CautionTag.SHEAR_YIELD in [item.kind for item in found.cautions]
    assert found.friction.shear_strength == pytest.approx(1e9 / math.sqrt(3))


def test_the_decks_hold_friction_and_elastic_slip(tmp_path: Path) -> None:
    found = rc.interface_law(CONTACTS[0], friction=0.15)
    for suffix in (".inp", ".ccx"):
        found.save(tmp_path / f"law{suffix}")
    first, second = ((tmp_path / f"law{suffix}").read_text() for suffix in (".inp", ".ccx"))
    slip, limit, friction = re.findall(
        r"\*FRICTION, ELASTIC SLIP=(\S+), TAUMAX=(\S+)\n(\S+)\n", first
    )[0]
    assert float(slip) == pytest.approx(found.elastic_slip()[-1] * 1e3)
    assert float(limit) == pytest.approx(1e3 / math.sqrt(3))
    friction_too, slope = re.findall(r"\*FRICTION\n(\S+), (\S+)\n", second)[0]
    assert float(friction) == float(friction_too) == 0.15
    last = found.steps[-1]
    # The same stiffness at the largest pressure.
    assert float(slope) == pytest.approx(0.15 * last.pressure * 1e-6 / float(slip))
    with pytest.raises(rc.InputError, match="friction"):
        rc.interface_law(CONTACTS[0], friction=-1.0)


def test_the_backbone_is_that_of_the_solved_contact() -> None:
    # Ridges along x: along them and across them the stiffness differs by a third.
    ridged = rc.generate(128, "2 um", Sq="0.4 um", Sal="10 um", Str=0.1, rng=1)
    steel = {"material": "42CrMo4", "counter_material": "42CrMo4", "boundary": "periodic"}
    pressures = [rc.NominalPressure(p) for p in ("10 MPa", "60 MPa", "200 MPa", "300 MPa")]
    contacts = [rc.solve(ridged, load=p, **steel) for p in pressures]
    left = rc.indented_surface(contacts[-1])
    after = [rc.solve(left, load=p, ceiling=None, **steel) for p in pressures]
    law, last = rc.interface_law(contacts, after, friction=0.15), contacts[-1]
    for axis, direction in enumerate((90.0, 0.0)):
        backbone = law.backbone(axis)
        assert backbone.shift[0] == backbone.shear_stress[0] == 0
        assert np.all(np.diff(backbone.shift) > 0)
        assert backbone.shear_stress[-1] == pytest.approx(0.15 * last.load / last.nominal_area)
        assert np.all(backbone.iwan_density > 0)
        # All of the joint slips in the end.
        lost = (backbone.iwan_density * np.diff(backbone.shift)).sum()
        assert lost == pytest.approx(backbone.stiffness[0])
        for shift, stress in zip(backbone.shift[1:-1], backbone.shear_stress[1:-1], strict=True):
            force = stress * last.nominal_area
            exact = rc.tangential(last, friction=0.15, force=force, direction=direction)
            # The superposition neglects the traction across the force.
            assert shift == pytest.approx(exact.last.shift, rel=0.03)
    with pytest.raises(rc.InputError, match="friction"):
        LAW.backbone()
