"""The documentation holds every module, every measurement, and no figure made by hand."""

from __future__ import annotations

import importlib
import re
from pathlib import Path
from types import ModuleType

import pytest

import measuring
import peers
import plasticity
import roughcontact as rc
from paths import ROOT

DOCS = ROOT / "docs"
GENERATED = ("_build", "generated", "examples")


def pages() -> list[Path]:
    """Return the written pages."""
    return [
        path
        for suffix in ("md", "rst", "py")
        for path in DOCS.rglob(f"*.{suffix}")
        if not any(part in GENERATED for part in path.relative_to(DOCS).parts)
    ]


@pytest.fixture
def api_pages(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(DOCS / "_ext"))
    return importlib.import_module("api_pages")


def test_every_module_has_its_page(api_pages: ModuleType) -> None:
    listed = set(re.findall(r"^   ([a-z0-9_.]+)$", api_pages.modules_page(), re.MULTILINE))
    package = Path(rc.__file__).parent
    assert listed == {
        ".".join(path.relative_to(package).with_suffix("").parts)
        for path in package.rglob("[a-z]*.py")
    }


def test_every_public_name_is_in_the_first_table(api_pages: ModuleType) -> None:
    table = api_pages.public_table()
    # Packages have no separate page, and are named below the table.
    shown = set(re.findall(r"``?rc\.(\w+)", table))
    assert shown >= set(rc.__all__) - {"RIGID", "__version__"}


@pytest.mark.long
def test_figure_shows_all_layers_and_modules(api_pages: ModuleType) -> None:
    from matplotlib.figure import Figure

    figure = Figure()
    api_pages.draw_layers(figure)
    words = " ".join(text.get_text() for text in figure.axes[0].texts)
    for layer, modules in api_pages.modules_by_layer().items():
        assert layer in words
        assert all(module in words for module in modules)
    assert api_pages.imports_between_layers()


def test_no_figure_is_placed_by_hand() -> None:
    # The README's pictures are what `roughcontact demo` writes and `docs/pages.py` takes.
    pictures = {path.name for path in (DOCS / "images").iterdir()}
    assert pictures == {"demo.png", "desk.png"}
    assert '"desk": (' in (DOCS / "pages.py").read_text(encoding="utf-8")
    for path in pages():
        text = path.read_text(encoding="utf-8")
        assert not re.search(r"!\[.*\]\(|\.\. image::|```{image}|<img", text), path


def test_no_line_of_page_starts_with_percent_sign() -> None:
    for path in pages():
        text = re.sub(r"^```.*?^```$", "", path.read_text("utf-8"), flags=re.DOTALL | re.MULTILINE)
        # MyST leaves out a line that starts with a per cent sign.
        assert path.suffix != ".md" or not re.search(r"^\s*%.*", text, re.MULTILINE), path


def test_every_link_to_a_page_leads_to_one() -> None:
    for path in pages():
        for target in re.findall(r"\]\(([\w./-]+\.(?:md|rst))[#)]", path.read_text("utf-8")):
            found = (path.parent / target).resolve()
            if found.parent == DOCS / "examples":
                # Made from the scripts of the gallery.
                found = DOCS / "gallery" / f"{found.stem}.py"
                assert found.exists() or target.endswith("index.rst"), (path, target)
            else:
                assert found.exists(), (path, target)


def test_every_example_is_numbered_and_has_a_title() -> None:
    scripts = sorted((DOCS / "gallery").glob("*.py"))
    assert len(scripts) >= 8
    for script in scripts:
        number = re.fullmatch(r"plot_(\d\d)_\w+\.py", script.name)
        assert number is not None, script
        title = script.read_text(encoding="utf-8").splitlines()[1]
        assert title.startswith(f"{number[1]} "), script


def test_tables_of_performance_match_stored_measurements() -> None:
    assert measuring.read_part("table") == peers.table(measuring.read_rows(peers.STORED))
    paths, passes = plasticity.tables(measuring.read_rows(plasticity.STORED))
    assert measuring.read_part("volume") == paths
    assert measuring.read_part("rolling") == passes


def test_the_plot_of_times_shows_every_program() -> None:
    from matplotlib.figure import Figure

    figure = Figure()
    rows = measuring.read_rows(peers.STORED)
    peers.plot(rows, figure)
    drawn = {line.get_label() for axes in figure.axes for line in axes.get_lines()}
    timed = {row["program"] for row in rows if "seconds" in row and "rough" in row["case"]}
    assert drawn >= timed


def test_parts_of_page_are_replaced_in_order(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    part = "<!-- a -->\n{}\n<!-- a end -->\ntext\n"
    page.write_text(part.format("one") + part.format("two"), encoding="utf-8")
    measuring.write_parts("a", r"first \1", "second", page=page)
    assert page.read_text("utf-8") == part.format(r"first \1") + part.format("second")


def test_every_check_of_a_joint_names_a_test_that_exists() -> None:
    named = re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", (DOCS / "joint.md").read_text("utf-8"))
    assert len(named) >= 9
    for path, name in named:
        assert f"def {name}(" in (DOCS.parent / path).read_text("utf-8"), (path, name)


def test_links_that_lead_nowhere_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(DOCS))
    built = importlib.import_module("built")
    (tmp_path / "other.html").write_text('<h1 id="here">Here</h1>', encoding="utf-8")
    page = tmp_path / "page.html"
    good = '<a href="other.html#here"><a href="#own"><p id="own"><a href="https://elsewhere.org">'
    page.write_text(good, encoding="utf-8")
    assert built.find_dead_links(tmp_path) == []
    page.write_text(f'{good}<img src="a.png"><a href="other.html#there">', encoding="utf-8")
    assert built.find_dead_links(tmp_path) == [
        "page.html: a.png does not exist",
        "page.html: no place other.html#there",
    ]
