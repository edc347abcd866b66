import base64
import dataclasses
import datetime
import io
import re
import shutil
import subprocess
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.image import imread
from matplotlib.text import Text

import roughcontact as rc
from roughcontact.contact import solve
from roughcontact.contact.result import ContactResult
from roughcontact.report import assumptions, page as layout
from roughcontact.report.kind import Headline
from roughcontact.report.presentation import Presentation, presentation_of
from roughcontact.surface import nominal_bodies
from roughcontact.surface.provenance import Operation
from roughcontact.units import format_engineering, format_percent

STEEL = rc.Material(210e9, 0.3, 1e9, name="steel")
EVIL = '<script>alert("1")</script> & \x1b\udcff.opd'
DAY = datetime.date(2024, 2, 29)
VOID = {"meta", "img", "br", "link", "hr", "input"}


class Page(HTMLParser):
    """The elements of a page; fails where a tag is not closed or closed twice."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.attributes: list[tuple[str, dict[str, str]]] = []
        self.texts: dict[str, list[str]] = {}
        self.cells: list[list[str]] = []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        names = [name for name, _ in attrs]
        assert len(names) == len(set(names))
        self.attributes.append((tag, {name: value or "" for name, value in attrs}))
        if tag not in VOID:
            self.open.append(tag)
        self.texts.setdefault(tag, []).append("")
        if tag == "tr":
            self.cells.append([])
        if tag in ("th", "td"):
            self.cells[-1].append("")

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        for tag in set(self.open):
            self.texts[tag][-1] += data
        if self.open and self.open[-1] in ("th", "td"):
            self.cells[-1][-1] += data

    def all(self, tag: str) -> list[dict[str, str]]:
        return [attributes for name, attributes in self.attributes if name == tag]

    @property
    def words(self) -> str:
        return " ".join(self.texts["body"][0].split())

    def rows(self) -> dict[str, str]:
        """Return the cells of every row by its head; of equal heads, the first row."""
        rows: dict[str, str] = {}
        for head, *cells in self.cells:
            rows.setdefault(head, " | ".join(cells))
        return rows


def rough(source: str = "", points: int = 64, seed: int = 0) -> rc.Surface:
    heights, pixel = rc.reference_map(points, seed)
    return rc.Surface(heights, pixel, rc.Provenance(source))


def solve_rough(surface: rc.Surface | None = None, **problem: Any) -> ContactResult:
    return rc.solve(surface or rough(), **{"material": STEEL, "load": 1.0, **problem})


@pytest.fixture(scope="module")
def whole() -> tuple[ContactResult, str]:
    """A result and its report with all there is."""
    result = solve_rough(rough(EVIL, points=128), load=0.4)
    command = "roughcontact solve '<b>.opd' --load \"1 N\""
    return result, presentation_of(result).render(layout.Edition(command, date=DAY))


def report(result: Any, *edition: layout.Edition, **more: Any) -> Page:
    """Return the page of a report on any result."""
    return Page(presentation_of(result, **more).render(*edition))


def test_the_page_is_well_formed(whole: tuple[ContactResult, str]) -> None:
    text = whole[1]
    assert text.startswith("<!DOCTYPE html>")
    page = Page(text)
    assert page.all("html") == [{"lang": "en"}]
    assert {"charset": "utf-8"} in page.all("meta")
    assert len(page.all("h1")) == len(page.all("main")) == len(page.all("title")) == 1
    names = [attributes["id"] for _, attributes in page.attributes if "id" in attributes]
    assert len(names) == len(set(names))
    used = [a["aria-labelledby"] for _, a in page.attributes if "aria-labelledby" in a]
    assert set(used) <= set(names)


def test_page_has_no_external_resources_or_scripts(whole: tuple[ContactResult, str]) -> None:
    text = whole[1]
    page = Page(text)
    tags = {tag for tag, _ in page.attributes}
    assert tags.isdisjoint({"script", "link", "iframe", "object", "embed", "base", "form", "a"})
    assert not any(name.startswith("on") for _, a in page.attributes for name in a)
    assert all(a["src"].startswith("data:image/png;base64,") for a in page.all("img"))
    bare = re.sub(r'src="data:[^"]*"', "", text)
    for word in ("http", "url(", "@import", "src", "file:"):
        assert word not in bare


SECTIONS = (
    "Input",
    "Results",
    "Uncertainty",
    "Assumptions",
    "Method and certificate",
    "How to repeat",
    "References",
)


def test_question_and_answer_precede_seven_sections(whole: tuple[ContactResult, str]) -> None:
    page = Page(whole[1])
    assert page.texts["h1"] == page.texts["title"]
    assert page.texts["h1"][0].startswith("How much of ")
    heads = [text.strip() for text in page.texts["h2"]]
    numbered = [f"{number} {title}" for number, title in enumerate(SECTIONS, start=1)]
    assert heads == ["Key numbers", "Warnings and cautions", *numbered]
    assert "1.5 % of the face is in contact" in page.words.split("Key numbers")[0]


def test_text_of_users_is_escaped(whole: tuple[ContactResult, str]) -> None:
    text = whole[1]
    page = Page(text)
    assert '<script>alert("1")</script> &   .opd' in page.texts["title"][0]
    assert '<script>alert("1")</script>' in page.rows()["Source"]
    assert page.texts["code"] == ["roughcontact solve '<b>.opd' --load \"1 N\""]
    assert "\x1b" not in text
    text.encode("utf-8")


def test_every_figure_has_image_and_caption(whole: tuple[ContactResult, str]) -> None:
    page = Page(whole[1])
    pictures = page.all("img")
    assert 5 <= len(pictures) == len(page.all("figure")) == len(page.all("figcaption")) <= 7
    widths = {float(a["style"].split()[1].removesuffix("mm")) for a in page.all("figure")}
    assert widths <= {layout.HALF, layout.MIDDLE, layout.WIDE}
    for number, (picture, caption) in enumerate(
        zip(pictures, page.texts["figcaption"], strict=True), start=1
    ):
        data = base64.b64decode(picture["src"].split(",", 1)[1], validate=True)
        values = np.asarray(imread(io.BytesIO(data)))[..., :3]
        assert values.shape[:2] == (int(picture["height"]), int(picture["width"]))
        assert 200 < values.shape[0] < 3000
        assert 400 < values.shape[1] < 2500
        assert values.std() > 0.02
        # White paper to the edge: nothing is cut off but what has to go over it.
        assert values.max() == 1
        assert len(picture["alt"]) > 10
        assert caption.startswith(f"Figure {number}. ")
        assert len(caption) > 25
    assert len(whole[1]) < 5e6


@pytest.mark.long
@pytest.mark.parametrize("width", [layout.HALF, layout.MIDDLE, layout.WIDE])
def test_no_text_of_a_figure_prints_below_seven_points(
    whole: tuple[ContactResult, str], width: int
) -> None:
    for entry in presentation_of(whole[0]).own("figures"):
        picture = layout.Picture(
            lambda entry=entry: entry.draw(presentation_of(whole[0]).scene), "", width
        )
        figure = picture.draw_figure()
        printed = width / 25.4 / figure.get_figwidth()
        sizes = [
            text.get_fontsize() * printed
            for text in figure.findobj(Text)
            if text.get_visible() and text.get_text()
        ]
        assert min(sizes) > 7


def test_the_numbers_are_those_of_the_summary(whole: tuple[ContactResult, str]) -> None:
    result, text = whole
    page = Page(text)
    # The table of results comes after the key numbers, which have fewer digits.
    rows = {row[0]: " ".join(row[1:]) for row in page.cells if len(row) > 1}
    summary = result.summary()
    for name, unit, head in (
        ("load", "N", "Load W"),
        ("approach", "m", "Approach ω"),
        ("max_pressure", "Pa", "Largest pressure"),
        ("mean_gap", "m", "Mean gap"),
        ("contact_area", "m²", "Contact area"),
        ("contact_modulus", "Pa", "Contact modulus E*"),
        ("ceiling", "Pa", "Pressure ceiling"),
    ):
        assert format_engineering(summary[name], unit) in rows[head]
    assert format_percent(summary["contact_fraction"]) in rows["Contact area"]
    assert format_percent(summary["saturated_fraction"]) in rows["Saturated area"]
    assert (
        format_engineering(summary["max_residual_indentation"], "m") in rows["Residual indentation"]
    )
    assert f"{summary['certificate']:.1e}" in rows["Certificate ε"]
    assert str(summary["convolutions"]) in rows["Convolutions on the full grid"]
    assert summary["regime"] in rows["Regime"]
    assert ["Status", summary["status"]] in page.cells
    values = page.cells[page.cells.index(["Sq", "Sa", "Sz", "Ssk", "Sku", "Sdq"]) + 1]
    assert values[0].startswith(format_engineering(result.surface.Sq, "m"))
    assert f"numpy {np.__version__}" in page.words
    assert "Report of 2024-02-29" in page.words
    for note in summary["warnings"]:
        assert note[1:] in page.words
    spots = result.spots()
    assert rows["Contact spots"].startswith(str(spots.count))
    assert rows["Largest spot"].startswith(format_engineering(float(spots.area[0]), "m²"))


def test_the_elastic_solution_is_a_column(whole: tuple[ContactResult, str]) -> None:
    result, text = whole
    elastic = result.elastic()
    page = Page(text)
    heads = next(cells for cells in page.cells if cells[-1] == "meaning")
    assert heads[-2] == "elastic"
    assert len(heads) == (5 if result.calibrated is not None and result.calibrated.differs else 4)
    by_head = {cells[0]: cells for cells in page.cells if len(cells) == len(heads)}
    for head, unit, name in (
        ("Largest pressure", "Pa", "max_pressure"),
        ("Contact area", "m²", "contact_area"),
        ("Approach ω", "m", "approach"),
        ("Mean gap", "m", "mean_gap"),
    ):
        assert by_head[head][1].startswith(format_engineering(getattr(result, name), unit))
        assert by_head[head][-2].startswith(format_engineering(getattr(elastic, name), unit))


@pytest.mark.usefixtures("quick")
def test_the_date_is_today_if_none_is_given() -> None:
    before = datetime.date.today()
    text = presentation_of(solve_rough(load=1e-3)).render()
    assert any(f"Report of {day}" in text for day in (before, datetime.date.today()))


def test_head_names_project_and_leaves_a_line_for_the_signature() -> None:
    front = layout.Front("Question", Headline("", "", (), [], ()), "", None, ())
    edition = layout.Edition(date=DAY, head=[("Project", "Pump <7>"), ("Author", "A. B.")])
    rows = [["Project", "Pump <7>"], ["Author", "A. B."], ["Signature", ""]]
    assert Page(layout.render(front, [], edition)).cells == rows
    assert Page(layout.render(front, [])).cells == []


@pytest.mark.long
@pytest.mark.usefixtures("quick")
def test_inapplicable_parts_are_omitted() -> None:
    page = report(solve_rough(ceiling=None))
    assert "elastic" not in page.texts["th"]
    assert "Saturated area" not in page.rows()
    unreached = solve_rough(load=1e-4, ceiling=300e9)
    assert unreached.saturated_fraction == 0
    page = report(unreached)
    assert "elastic" not in page.texts["th"]
    assert page.rows()["Residual indentation"].startswith("none")


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize(
    ("problem", "words"),
    [
        ({"boundary": "periodic"}, "the map is one period"),
        ({"precision": "single"}, "seven digits"),
        ({"load": None, "approach": 2e-7}, "at an approach of 200 nm?"),
        ({"load": "20 MPa"}, "in contact at 20 MPa?"),
        ({"moments": (0.0, 2e-6)}, "0 N m, 2 µN m"),
        ({"material": rc.Material(400e9, 0.2, hardness=15e9)}, "15 GPa, the hardness"),
        ({"ceiling": None}, "elastic pressure beyond three yield strengths"),
        ({"counter_surface": rough("lapped.sur", seed=1)}, "lapped.sur"),
        ({"counter_material": rc.Material(70e9, 0.33, 3e8, "brass")}, "brass"),
        ({"ceiling": np.linspace(1e9, 2e9, 4096).reshape(64, 64)}, "1 GPa to 2 GPa"),
        (
            {
                "surface": rc.Surface(
                    np.where(np.arange(4096).reshape(64, 64) == 70, np.nan, rough().heights),
                    (1e-6, 1e-6),
                ).masked()
            },
            "1 point (0.0244 %) without height are never in contact",
        ),
    ],
    ids=[
        "periodic",
        "single",
        "approach",
        "nominal pressure",
        "moments",
        "hardness",
        "elastic",
        "two maps",
        "two elastic bodies",
        "ceiling by point",
        "masked",
    ],
)
def test_every_case_states_its_assumptions(problem: dict[str, Any], words: str) -> None:
    result = solve_rough(**problem)
    page = report(result, layout.Edition(date=DAY))
    assert words in page.words
    assert result.regime in page.words
    for row in assumptions.assumption_rows(assumptions.contact_case(result)):
        assert list(row) in page.cells
    two = result.counter_surface is not None
    assert ("Roughness of the counter-body" in page.words) is two


@pytest.mark.long
@pytest.mark.usefixtures("quick")
def test_a_nominal_body_has_no_roughness() -> None:
    ball = nominal_bodies.sphere(radius=1e-3, shape=rough().shape, pixel=rough().pixel)
    result = "the added nominal form"
    assert result not in report(solve_rough()).words
    assert result in report(solve_rough(rough().with_form(ball))).words
    smooth = report(solve_rough(ball, load=0.01))
    assert "Sdq" not in smooth.texts["th"]
    beside = report(solve_rough(counter_surface=ball))
    assert "Roughness of the counter-body" not in beside.words


@pytest.mark.long
@pytest.mark.usefixtures("quick")
def test_a_small_contact_is_shown_closely_first() -> None:
    ball = nominal_bodies.sphere(radius=1e-2, shape=(128, 128), pixel=(2e-6, 2e-6))
    small, large = (report(solve_rough(ball, load=load)).all("img") for load in (0.1, 60.0))
    assert small[0]["alt"].startswith("Pressure (left) and state (right) in")
    assert large[0]["alt"].startswith("Where the bodies touch")


@pytest.mark.long
@pytest.mark.usefixtures("quick")
def test_cautions_are_on_the_first_page() -> None:
    steep = rc.Surface(20 * rough().heights, rough().pixel)
    page = report(solve_rough(steep))
    first, _ = page.words.split("1 Input", 1)
    assert "slope" in first.split("Warnings and cautions")[1]
    y, x = np.mgrid[-24:24, -24:24] * 1e-6
    ball = rc.Surface(-(x**2 + y**2) / 0.02, (1e-6, 1e-6))
    smooth = report(solve_rough(ball, load=0.1))
    assert "No warnings and no cautions" in smooth.words.split("1 Input", 1)[0]
    assert "No warnings and no cautions" not in first
    assert "Checked: convergence, contact at the edges" in smooth.words


@pytest.mark.long
@pytest.mark.usefixtures("quick")
def test_unconverged_result_is_not_shown_as_solution() -> None:
    best = solve_rough(max_iterations=2, on_failure="return")
    assert not best.converged
    page = report(best)
    first = page.words.split("Key numbers", 1)[0]
    assert "Not converged" in first
    assert "Do not use these numbers" in first
    assert page.rows()["Status"].startswith("NOT CONVERGED")
    assert "Not converged" not in report(solve_rough()).words


@pytest.mark.long
@pytest.mark.usefixtures("quick")
def test_script_replaces_unknown_command() -> None:
    reading = Operation("read_surface", {"path": "ground.opd"})
    about = rc.Provenance("ground.opd", "Wyko", origin=reading)
    surface = dataclasses.replace(rough(), provenance=about).leveled()
    page = report(solve_rough(surface))
    assert 'surface = rc.read_surface("ground.opd").leveled()' in page.texts["code"][0]
    assert "least-squares plane subtracted" in page.rows()["Preparation"]
    page = report(solve_rough(surface), layout.Edition("roughcontact solve"))
    assert page.texts["code"] == ["roughcontact solve"]
    # A map that was an array in memory.
    assert "supply it as surface.npy" in report(solve_rough()).texts["code"][0]


@pytest.mark.usefixtures("quick")
def test_a_map_without_neighbors_has_no_slope_to_report() -> None:
    heights = np.full((6, 6), np.nan)
    heights[::2, ::2] = 0.0
    result = solve_rough(rc.Surface(heights, (1e-6, 1e-6)).masked(), load=1e-3)
    assert ["not defined on this map"] * 6 in report(result).cells


@pytest.mark.long
@pytest.mark.usefixtures("quick")
def test_save_replaces_only_when_it_is_complete(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "out.html"
    path.write_text("old")
    result = solve_rough(ceiling=None)
    presentation_of(result).report(path, layout.Edition(date=DAY))
    assert path.read_text(encoding="utf-8") == presentation_of(result).render(
        layout.Edition(date=DAY)
    )
    before = path.read_bytes()

    def full(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    # Half of it is in the hidden file when the disk is full.
    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(OSError, match="No space"):
        presentation_of(result).report(path, layout.PLAIN)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("out.pdf", "must end in .html"),
        ("out", "must end in .html"),
        ("no/out.html", "does not exist"),
        ("folder.html", "is a folder"),
    ],
)
def test_invalid_paths_raise_input_error_before_solve(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, message: str
) -> None:
    (tmp_path / "folder.html").mkdir()
    result = solve_rough()

    def refuse_work(*args: Any) -> Any:
        raise AssertionError("work before the path was checked")

    monkeypatch.setattr(solve, "solve_without_ceiling", refuse_work)
    monkeypatch.setattr(Presentation, "render", refuse_work)
    with pytest.raises(rc.InputError, match=message):
        result.report(tmp_path / name)


@pytest.mark.usefixtures("quick")
def test_the_result_writes_its_own_report(tmp_path: Path) -> None:
    path = tmp_path / "out.htm"
    result = solve_rough()
    result.report(path, "roughcontact solve a.opd")
    page = Page(path.read_text(encoding="utf-8"))
    assert page.texts["code"] == ["roughcontact solve a.opd"]
    assert set(page.texts["li"]) >= {work.text for work in result.references() if work.authors}
    assert "EngineeringModel" not in page.words
    assert "@article" not in page.words


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize(
    ("failure", "is_told"),
    [
        (
            lambda: rc.ConvergenceError(
                "no", solve_rough(ceiling=None, max_iterations=2, on_failure="return")
            ),
            True,
        ),
        (lambda: rc.InsufficientMemoryError("no"), False),
    ],
)
def test_failed_elastic_solution_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, failure: Any, is_told: bool
) -> None:
    error = failure()

    def fail(result: ContactResult) -> ContactResult:
        raise error

    monkeypatch.setattr(solve, "solve_without_ceiling", fail)
    path = tmp_path / "out.html"
    solve_rough().report(path)
    page = Page(path.read_text(encoding="utf-8"))
    assert ("The elastic solution did not converge" in page.words) is is_told
    assert ("elastic" in page.texts["th"]) is is_told


# Every kind of result, with the words of its question and the most pages that it may have.


def ground() -> rc.Surface:
    return rc.Surface(*rc.reference_map(64, 0))


def solve_ground(**more: Any) -> ContactResult:
    return solve_rough(ground(), boundary="periodic", load=0.2, **more)


def compare_groups() -> Any:
    maps = [rc.Surface(*rc.reference_map(48, seed)) for seed in range(6)]
    groups = {"ground": maps[:3], "honed": maps[3:]}
    return rc.compare(groups, pressure="20 MPa", material=STEEL, boundary="periodic")


MAKE: dict[str, tuple[Callable[[], Any], str, int]] = {
    "solve": (solve_ground, "is in contact under 200 mN?", 6),
    "free": (lambda: solve_rough(ground(), load=0.2), "is in contact under", 6),
    "ball": (
        lambda: solve_rough(
            ground(),
            load=0.02,
            counter_material=STEEL,
            counter_surface=(
                nominal_bodies.sphere(radius=3e-3, shape=(64, 64), pixel=ground().pixel)
            ),
        ),
        "How large is the contact",
        6,
    ),
    "profile": (
        lambda: solve_rough(rc.Surface(ground().heights[0], ground().pixel[1]), load="1 N/mm"),
        "is in contact under",
        6,
    ),
    "elastic": (lambda: solve_ground(ceiling=None), "is in contact under", 6),
    "sweep": (
        lambda: rc.sweep(ground(), material=STEEL, loads=np.geomspace(0.01, 0.3, 13)),
        "grow from 10 mN to 300 mN?",
        8,
    ),
    "history": (
        lambda: rc.history(ground(), [0.2, 0.05, 0.0, 0.2], material=STEEL),
        "Which indentation does a load history up to 200 mN leave",
        8,
    ),
    "search": (
        lambda: rc.find_load(ground(), contact_fraction=0.05, material=STEEL),
        "Which load gives contact 5",
        8,
    ),
    "conductance": (
        lambda: rc.conductance(solve_ground(), rc.Conductor(1e-7, 50.0), rc.Conductor(1e-7, 50.0)),
        "How well do heat and current cross the joint",
        8,
    ),
    "leakage": (lambda: rc.leakage(solve_ground()), "How permeable is the gap", 8),
    "law": (
        lambda: rc.interface_law(
            solve_rough(ground(), load=load, boundary="periodic") for load in (0.1, 0.3, 1.0)
        ),
        "How far does the joint close",
        8,
    ),
    "stress": (lambda: rc.subsurface_stress(solve_ground()), "How large is the stress below", 8),
    "compare": (compare_groups, "Do ground and honed differ at 20 MPa?", 8),
    "estimate": (
        lambda: rc.estimate(pressure="100 MPa", material=STEEL, Sq="0.5 um", Sdq=0.1),
        "in contact at 100 MPa?",
        8,
    ),
    "volume": (
        lambda: rc.solve_elastoplastic(
            nominal_bodies.sphere(radius=1e-2, shape=(16, 16), pixel=(25e-6, 25e-6)),
            material=STEEL,
            load=80.0,
            increments=2,
            tolerance=1e-2,
        ),
        "How deep does the nominal",
        8,
    ),
}


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("name", MAKE)
def test_a_report_of_any_kind_leads_with_its_question(name: str) -> None:
    make, words, _ = MAKE[name]
    page = report(make())
    assert words in page.texts["h1"][0]
    answer = page.words.split("Key numbers", 1)[0]
    assert re.search(r"\d", answer.replace(page.texts["h1"][0], ""))
    heads = [head.strip().split(" ", 1)[1] for head in page.texts["h2"][2:]]
    assert [title for title in SECTIONS if title in heads] == heads
    assert {"Input", "Results", "References"} <= set(heads)


CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")


# Of a map, of a profile, and the longest.
PRINTED = ("solve", "profile", "sweep")


@pytest.mark.long
@pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium to print")
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[] if name in PRINTED else [pytest.mark.slow]) for name in MAKE],
)
def test_a_report_prints_to_few_pages(name: str, tmp_path: Path) -> None:
    make, _, most = MAKE[name]
    result, source, target = make(), tmp_path / "out.html", tmp_path / "out.pdf"
    result.report(source)
    assert CHROMIUM is not None
    subprocess.run(
        [
            CHROMIUM,
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--no-first-run",
            "--disable-background-networking",
            f"--user-data-dir={tmp_path / 'user'}",
            "--no-pdf-header-footer",
            f"--print-to-pdf={target}",
            source.as_uri(),
        ],
        check=True,
        capture_output=True,
        timeout=120,
    )
    pages = len(re.findall(rb"/Type\s*/Page\b", target.read_bytes()))
    assert 1 < pages <= most
