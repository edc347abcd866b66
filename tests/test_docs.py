"""The documentation holds every module, every measurement, and no figure made by hand."""

from __future__ import annotations

import importlib.util
import re
import sys
from pathlib import Path
from types import ModuleType

import pytest

import roughcontact as rc

ROOT = Path(__file__).parents[1]
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


def test_every_module_has_its_page() -> None:
    modules = {path.stem for path in Path(rc.__file__).parent.glob("[a-z]*.py")}
    index = (DOCS / "api" / "index.rst").read_text(encoding="utf-8")
    listed = set(re.findall(r"^   ([a-z_]+)$", index, re.MULTILINE))
    assert listed == modules, "add new modules to docs/api/index.rst, take old ones out"


def test_every_public_name_is_in_the_first_table() -> None:
    index = (DOCS / "api" / "index.rst").read_text(encoding="utf-8")
    shown = {
        name.rpartition(".")[2] for name in re.findall(r"^   (\w+\.\w+)$", index, re.MULTILINE)
    }
    assert shown >= set(rc.__all__) - {"RIGID", "__version__"}


def test_no_figure_is_placed_by_hand() -> None:
    # The README's picture is what `roughcontact demo` writes.
    pictures = {path.name for path in (DOCS / "images").iterdir()}
    assert pictures == {"demo.png"}
    for path in pages():
        text = path.read_text(encoding="utf-8")
        assert not re.search(r"!\[.*\]\(|\.\. image::|```{image}|<img", text), path


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


@pytest.fixture
def report(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    folder = ROOT / "benchmarks"
    monkeypatch.syspath_prepend(str(folder))
    spec = importlib.util.spec_from_file_location("benchmarks_report", folder / "report.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    finally:
        sys.modules.pop("peers", None)
    return module


def test_the_table_of_times_is_that_of_the_stored_measurements(report: ModuleType) -> None:
    text = report.PAGE.read_text(encoding="utf-8")
    shown = text[text.index(report.START) + len(report.START) : text.index(report.END)]
    assert shown.strip() == report.table(report.stored())


def test_the_plot_of_times_shows_every_program(report: ModuleType) -> None:
    from matplotlib.figure import Figure

    figure = Figure()
    rows = report.stored()
    report.plot(rows, figure)
    drawn = {line.get_label() for axes in figure.axes for line in axes.get_lines()}
    timed = {row["program"] for row in rows if "seconds" in row and "rough" in row["case"]}
    assert drawn >= timed
