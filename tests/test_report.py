import base64
import dataclasses
import datetime
import io
import re
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread

import roughcontact as rc
from roughcontact.contact import solve
from roughcontact.contact.result import ContactResult
from roughcontact.report import contact as report, kinds, page as layout
from roughcontact.report.page import ExtraChapter
from roughcontact.surface import nominal_bodies
from roughcontact.surface.provenance import Operation
from roughcontact.units import engineering, percent

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


def solved(surface: rc.Surface | None = None, **problem: Any) -> ContactResult:
    return rc.solve(surface or rough(), **{"material": STEEL, "load": 1.0, **problem})


@pytest.fixture(scope="module")
def whole() -> tuple[ContactResult, str]:
    """A result and its report with every chapter there is."""
    surface = rough(EVIL, points=128)
    result = solved(surface, load=0.4)
    curve = rc.sweep(surface, material=STEEL, loads=[0.01, 0.1, 1.0], ceiling=None)
    figure = Figure(figsize=(3, 2))
    figure.subplots().plot([1, 2])
    addition = ExtraChapter(
        "Grid <study>",
        ("One & two.", "Three."),
        (("points", "area"), ("64", "<1>"), ("128", "2")),
        (("A line < that rises.", figure),),
    )
    text = report.render(
        result, layout.Edition("roughcontact solve '<b>.opd' --load \"1 N\"", date=DAY),
        elastic=result.elastic(), curve=curve, additions=[addition],
    )  # fmt: skip
    return result, text


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave the figures undrawn: they take most of the time of a report."""

    def undrawn(draw: Callable[[], Figure], alt: str, caption: str) -> Any:
        assert draw().axes
        return layout.Picture(caption, alt, "AAAA", 1, 1)

    monkeypatch.setattr(layout, "picture", undrawn)


def test_the_page_is_well_formed(whole: tuple[ContactResult, str]) -> None:
    text = whole[1]
    assert text.startswith("<!DOCTYPE html>")
    page = Page(text)
    assert page.all("html") == [{"lang": "en"}]
    assert {"charset": "utf-8"} in page.all("meta")
    assert len(page.all("h1")) == len(page.all("main")) == len(page.all("title")) == 1
    names = [attributes["id"] for _, attributes in page.attributes if "id" in attributes]
    assert len(names) == len(set(names))
    used = [a["href"].removeprefix("#") for a in page.all("a")]
    used += [a["aria-labelledby"] for _, a in page.attributes if "aria-labelledby" in a]
    assert set(used) <= set(names)


def test_nothing_is_fetched_and_nothing_is_run(whole: tuple[ContactResult, str]) -> None:
    text = whole[1]
    page = Page(text)
    tags = {tag for tag, _ in page.attributes}
    assert tags.isdisjoint({"script", "link", "iframe", "object", "embed", "base", "form"})
    assert not any(name.startswith("on") for _, a in page.attributes for name in a)
    assert all(a["href"].startswith("#") for a in page.all("a"))
    assert all(a["src"].startswith("data:image/png;base64,") for a in page.all("img"))
    bare = re.sub(r'src="data:[^"]*"', "", text)
    for word in ("http", "url(", "@import", "src", "file:"):
        assert word not in bare


def test_the_chapters_are_there_and_in_the_contents(whole: tuple[ContactResult, str]) -> None:
    page = Page(whole[1])
    titles = [
        "Input and preparation", "Roughness of the prepared surface", "Materials and load",
        "What is assumed", "Results", "Sections through the highest peak", "Contact spots",
        "Elastic beside ceiling", "Load curve", "Grid <study>", "How exactly it is solved",
        "How to repeat it", "References",
    ]  # fmt: skip
    heads = [text.strip() for text in page.texts["h2"]]
    assert heads == [
        "Summary", "Contents", *(f"{i} {title}" for i, title in enumerate(titles, start=1))
    ]  # fmt: skip
    assert [text.strip() for text in page.texts["a"]] == titles


def test_what_users_wrote_is_text(whole: tuple[ContactResult, str]) -> None:
    text = whole[1]
    page = Page(text)
    assert '<script>alert("1")</script> & ��.opd' in page.texts["title"][0]
    assert '<script>alert("1")</script>' in page.rows()["Source"]
    assert "roughcontact solve '<b>.opd' --load \"1 N\"" in page.texts["code"]
    assert page.rows()["64"] == "<1>"
    assert "\x1b" not in text
    text.encode("utf-8")


def test_every_figure_is_a_picture_with_words(whole: tuple[ContactResult, str]) -> None:
    page = Page(whole[1])
    pictures = page.all("img")
    assert len(pictures) == len(page.all("figure")) == len(page.all("figcaption")) == 14
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


def test_the_numbers_are_those_of_the_summary(whole: tuple[ContactResult, str]) -> None:
    result, text = whole
    page = Page(text)
    rows, summary = page.rows(), result.summary()
    for name, unit, head in (
        ("load", "N", "Load W"), ("approach", "m", "Approach ω"),
        ("max_pressure", "Pa", "Largest pressure"), ("mean_gap", "m", "Mean gap"),
        ("contact_area", "m²", "Contact area"), ("contact_modulus", "Pa", "Contact modulus E*"),
        ("ceiling", "Pa", "Pressure ceiling"),
    ):  # fmt: skip
        assert engineering(summary[name], unit) in rows[head]
    assert percent(summary["contact_fraction"]) in rows["Contact area"]
    assert percent(summary["saturated_fraction"]) in rows["Saturated area"]
    assert engineering(summary["max_residual_indentation"], "m") in rows["Residual indentation"]
    assert f"{summary['certificate']:.1e}" in rows["Certificate ε"]
    assert str(summary["convolutions"]) in rows["Convolutions on the full grid"]
    assert summary["regime"] in rows["Regime"]
    assert ["Status", summary["status"]] in page.cells
    assert rows["Sq"].startswith(engineering(result.surface.Sq, "m"))
    assert rows["Smr1"].startswith(f"{100 * result.surface.roughness()['Smr1']:.4g} %")
    assert rc.__version__ in rows["roughcontact"]
    assert np.__version__ in rows["numpy"]
    assert "Report of 2024-02-29" in page.words
    for note in summary["warnings"]:
        assert note in page.words


def test_the_spots_are_told(whole: tuple[ContactResult, str]) -> None:
    result, text = whole
    page, spots = Page(text), result.spots()
    rows = page.rows()
    assert ["Number of spots", str(spots.count), ""] in page.cells
    assert ["Mean area", engineering(float(spots.area.mean()), "m²"), ""] in page.cells
    assert rows["Largest area"].startswith(engineering(float(spots.area[0]), "m²"))
    largest = float(spots.load[:10].sum() / spots.load.sum())
    assert rows["Load on the 10 largest"].startswith(percent(largest))


def test_the_elastic_solution_stands_beside(whole: tuple[ContactResult, str]) -> None:
    result, text = whole
    elastic = result.elastic()
    page = Page(text)
    for head, unit, name in (
        ("Largest pressure", "Pa", "max_pressure"), ("Contact area", "m²", "contact_area"),
        ("Approach", "m", "approach"), ("Mean gap", "m", "mean_gap"),
    ):  # fmt: skip
        both = [engineering(getattr(r, name), unit) for r in (elastic, result)]
        beside = [cells[1:] for cells in page.cells if cells[0] == head and len(cells) == 3]
        # The area has its share of the map behind it, the largest pressure that it is the ceiling.
        texts = [[re.split(r" \(|, ceiling", text)[0] for text in row] for row in beside]
        assert both in texts
    inside = np.count_nonzero(elastic.contact & result.contact) / np.count_nonzero(elastic.contact)
    assert f"{percent(inside)} of the elastic contact" in page.words


def test_the_load_curve_is_a_table(whole: tuple[ContactResult, str]) -> None:
    page = Page(whole[1])
    assert {"load", "stiffness", "certificate"} <= set(page.texts["th"])
    assert "under 3 loads" in page.words
    row = page.rows()["10 mN"]
    assert re.search(r"nm.*%.*GPa", row)
    assert len(next(cells for cells in page.cells if cells[0] == "10 mN")) == 9


@pytest.mark.usefixtures("quick")
def test_the_date_is_today_if_none_is_given() -> None:
    before = datetime.date.today()
    text = report.render(solved(load=1e-3))
    assert any(f"Report of {day}" in text for day in (before, datetime.date.today()))


@pytest.mark.usefixtures("quick")
def test_chapters_that_do_not_apply_are_left_out() -> None:
    elastic = solved(ceiling=None)
    page = Page(report.render(elastic))
    assert "Elastic beside ceiling" not in page.words
    assert "Load curve" not in page.words
    assert "Saturated area" not in page.rows()
    unreached = solved(load=1e-4, ceiling=300e9)
    assert unreached.saturated_fraction == 0
    page = Page(report.render(unreached, elastic=unreached.elastic()))
    assert "Elastic beside ceiling" not in page.words
    assert page.rows()["Residual indentation"].startswith("none")
    page = Page(report.render(solved()))
    assert "No solution of the same problem without a ceiling was given" in page.words


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize(
    ("problem", "words"),
    [
        ({"boundary": "periodic"}, "one period of an endless surface"),
        ({"precision": "single"}, "seven digits"),
        ({"load": None, "approach": 2e-7}, "Contact of an unnamed surface at an approach of 200"),
        ({"moments": (0.0, 2e-6)}, "0 N m, 2 µN m"),
        ({"material": rc.Material(400e9, 0.2, hardness=15e9)}, "15 GPa, the hardness"),
        ({"ceiling": None}, "elastic pressure beyond three yield strengths"),
        ({"counter_surface": rough("lapped.sur", seed=1)}, "against lapped.sur (rigid)"),
        ({"counter_material": rc.Material(70e9, 0.33, 3e8, "brass")}, "(brass, E 70 GPa)"),
        ({"ceiling": np.linspace(1e9, 2e9, 4096).reshape(64, 64)}, "1 GPa to 2 GPa"),
        ({"surface": rc.Surface(np.where(np.arange(4096).reshape(64, 64) == 70, np.nan,
                                         rough().heights), (1e-6, 1e-6)).masked()},
         "1 point (0.0244 % of the map) was not measured"),
    ],
    ids=["periodic", "single", "approach", "moments", "hardness", "elastic",
         "two maps", "two elastic bodies", "ceiling by point", "masked"],
)  # fmt: skip
def test_every_case_is_told_as_it_is(problem: dict[str, Any], words: str) -> None:
    result = solved(**problem)
    page = Page(report.render(result, layout.Edition(date=DAY)))
    assert words in page.words
    assert result.regime in page.words
    for statement in report.chapters.stated(result, result.spots()):
        assert statement.text in page.words
    assert ("Preparation of the counter-body" in page.words) is (result.counter_surface is not None)


@pytest.mark.usefixtures("quick")
def test_roughness_with_a_nominal_form_is_told_as_such() -> None:
    ball = nominal_bodies.sphere(radius=1e-3, shape=rough().shape, pixel=rough().pixel)
    told = "the form is in them"
    assert told not in Page(report.render(solved())).words
    assert told in Page(report.render(solved(rough().with_form(ball)))).words
    beside = Page(report.render(solved(counter_surface=rough(seed=1).with_form(ball)))).words
    assert "A nominal form was added to the heights of the counter-body" in beside


@pytest.mark.usefixtures("quick")
def test_cautions_stand_on_the_first_page() -> None:
    steep = rc.Surface(20 * rough().heights, rough().pixel)
    page = Page(report.render(solved(steep)))
    first, rest = page.words.split("Contents", 1)
    assert "RMS slope" in first
    assert "RMS slope" in rest
    y, x = np.mgrid[-24:24, -24:24] * 1e-6
    ball = rc.Surface(-(x**2 + y**2) / 0.02, (1e-6, 1e-6))
    smooth = Page(report.render(solved(ball, load=0.1)))
    told = "Looked at, without cause for a caution: convergence, contact at the edges"
    assert told in smooth.words.split("Contents", 1)[0]
    assert "Looked at: convergence" in first


@pytest.mark.usefixtures("quick")
def test_what_did_not_converge_is_never_shown_as_a_solution() -> None:
    best = solved(max_iterations=2, on_failure="return")
    assert not best.converged
    page = Page(report.render(best))
    first = page.words.split("Contents", 1)[0]
    assert "Not converged: these numbers are not a solution." in first
    assert "Do not use these numbers" in first
    assert page.rows()["Status"].startswith("NOT CONVERGED")
    assert "Not converged: these numbers" not in Page(report.render(solved())).words


@pytest.mark.usefixtures("quick")
def test_a_script_stands_in_for_the_command() -> None:
    reading = Operation("read_surface", {"path": "ground.opd"})
    about = rc.Provenance("ground.opd", "Wyko", origin=reading)
    surface = dataclasses.replace(rough(), provenance=about).leveled()
    page = Page(report.render(solved(surface)))
    assert 'surface = rc.read_surface("ground.opd").leveled()' in page.texts["code"][0]
    assert "Leveled: least-squares plane subtracted." in page.words
    page = Page(report.render(solved(surface), edition=layout.Edition("roughcontact solve")))
    assert page.texts["code"][0] == "roughcontact solve"
    # A map that was an array in memory.
    assert "supply it as surface.npy" in Page(report.render(solved())).texts["code"][0]


@pytest.mark.usefixtures("quick")
def test_a_map_without_neighbours_has_no_slope_to_report() -> None:
    heights = np.full((6, 6), np.nan)
    heights[::2, ::2] = 0.0
    result = solved(rc.Surface(heights, (1e-6, 1e-6)).masked(), load=1e-3)
    page = Page(report.render(result))
    assert page.rows()["Sdq"].startswith("not defined on this map |")


@pytest.mark.usefixtures("quick")
def test_the_share_of_elastic_contact_that_touches_again_is_counted() -> None:
    result = solved()
    elastic = result.elastic()
    moved = dataclasses.replace(elastic, pressure=np.roll(elastic.pressure, 3, axis=1))
    share = np.count_nonzero(moved.contact & result.contact) / np.count_nonzero(moved.contact)
    assert 0.05 < share < 0.95
    assert (
        f"{percent(share)} of the elastic contact"
        in Page(report.render(result, elastic=moved)).words
    )


@pytest.mark.usefixtures("quick")
def test_elastic_results_of_another_grid_are_refused() -> None:
    with pytest.raises(rc.InputError, match=r"elastic has \(32, 32\) pixels and the result"):
        report.render(solved(), elastic=solved(rough(points=32), ceiling=None))


@pytest.mark.usefixtures("quick")
def test_save_replaces_only_when_it_is_complete(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "out.html"
    path.write_text("old")
    result = solved(ceiling=None)
    kinds.report(result, path, layout.Edition(date=DAY))
    assert path.read_text(encoding="utf-8") == report.render(result, layout.Edition(date=DAY))
    before = path.read_bytes()

    def full(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    # Half of it lies in the hidden file when the disk turns out to be full.
    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(OSError, match="No space"):
        kinds.report(result, path, layout.PLAIN)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("name", "message"),
    [("out.pdf", "must end in .html"), ("out", "must end in .html"),
     ("no/out.html", "does not exist"), ("folder.html", "is a folder")],
)  # fmt: skip
def test_unfit_paths_are_refused_before_anything_is_solved(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, message: str
) -> None:
    (tmp_path / "folder.html").mkdir()
    result = solved()

    def never(*args: Any) -> Any:
        raise AssertionError("work before the path was checked")

    monkeypatch.setattr(solve, "without_ceiling", never)
    monkeypatch.setattr(report, "render", never)
    with pytest.raises(rc.InputError, match=message):
        result.report(tmp_path / name)


@pytest.mark.usefixtures("quick")
def test_the_result_writes_its_own_report(tmp_path: Path) -> None:
    path = tmp_path / "out.htm"
    result = solved()
    result.report(path, "roughcontact solve a.opd")
    page = Page(path.read_text(encoding="utf-8"))
    command, works = page.texts["code"]
    assert command == "roughcontact solve a.opd"
    assert works.strip() == result.references().bibtex.strip()
    both = [engineering(r.max_pressure, "Pa") for r in (result.elastic(), result)]
    assert ["Largest pressure", both[0], f"{both[1]}, ceiling (given)"] in page.cells


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize(
    ("failure", "words"),
    [
        (lambda: rc.ConvergenceError(
            "no", solved(ceiling=None, max_iterations=2, on_failure="return")),
         "The elastic solution did not converge"),
        (lambda: rc.InsufficientMemoryError("no"), "No solution of the same problem"),
    ],
)  # fmt: skip
def test_a_failed_elastic_twin_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, failure: Any, words: str
) -> None:
    error = failure()

    def fail(result: ContactResult) -> ContactResult:
        raise error

    monkeypatch.setattr(solve, "without_ceiling", fail)
    path = tmp_path / "out.html"
    solved().report(path)
    assert words in Page(path.read_text(encoding="utf-8")).words
