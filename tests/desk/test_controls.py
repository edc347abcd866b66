"""Messages and controls of the page have one name for each option."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

import roughcontact as rc

pytest.importorskip("panel", reason="needs roughcontact[desk]")

import panel as pn

from roughcontact.analyses.solve.task import TASK as SOLVE
from roughcontact.desk.analysis_jobs import ANALYSES, JOINTS
from roughcontact.desk.controls import (
    SHOWN_OPTIONS,
    Control,
    error_text,
    picture_markup,
    spell_for_page,
)
from roughcontact.desk.page import Page
from roughcontact.desk.projects import ProjectStore
from roughcontact.desk.server import PageVisit
from roughcontact.desk.session import LOADS
from roughcontact.desk.workers import WorkerPool
from roughcontact.errors import ArgumentRef, InputError, RoughcontactError

SOURCES = Path(rc.__file__).parent
QUESTIONS = (*ANALYSES, *JOINTS)


def test_messages_have_the_terms_of_the_page_or_of_the_command() -> None:
    """Check all arguments that any message of the package names."""
    names = {
        name
        for path in SOURCES.rglob("*.py")
        for name in re.findall(r"""ArgumentRef\(\s*["']([^"']+)["']""", path.read_text("utf-8"))
    }
    assert len(names) > 50
    labels = {SOLVE.by_name[name].label for name in SHOWN_OPTIONS}
    labels |= {o.label for _, item in QUESTIONS for o in (*item.options, *item.folded)}
    labels |= {item.name for _, item in QUESTIONS}
    for task in {SOLVE, *(task for task, _ in QUESTIONS)}:
        for name in names:
            text = spell_for_page(ArgumentRef(name), task)
            assert "rc." not in text
            if text.startswith("“"):
                assert text.strip("“”") in labels, text
            elif task.option_of_argument(name) is not None:
                assert text.startswith(("--", "the map", "map of")), text


def test_analyses_are_named_as_on_the_page() -> None:
    assert spell_for_page(ArgumentRef("rc.resolution_study")) == "“Resolution study”"
    assert spell_for_page(ArgumentRef("rc.solve_elastoplastic")) == "“Elastoplastic model”"
    assert spell_for_page(ArgumentRef("ceiling", "none")) == "“Pressure ceiling” none"


@pytest.mark.parametrize(
    ("name", "value", "remedy"),
    [("load", "-20 MPa", "'20 MPa'"), ("load", "-3 N", "'3 N'"), ("pixel", "-2 um", "'2 um'")],
)
def test_negative_value_is_answered_with_the_positive(name: str, value: str, remedy: str) -> None:
    with pytest.raises(RoughcontactError) as caught:
        SOLVE.parse_options({name: value})
    assert caught.value.message_for().endswith(f"write {remedy}")


def test_every_shown_option_has_a_control(tmp_path: Path) -> None:
    bench = WorkerPool(spare=False)
    work = ProjectStore(tmp_path).create()
    page: Any = Page(PageVisit(work, None, bench, 1, lambda: None, list))
    panels = page._map_panel, page._preparation, page._bodies, page._model
    for panel in panels:
        for card in panel.step.root.select(pn.Card):
            card.collapsed = False
    groups = [panel._group for panel in panels] + [page._map_panel._nominal]
    found = {name for group in groups for name in group.controls}
    assert found == SHOWN_OPTIONS - set(LOADS)
    page.close()
    bench.close()


def test_missing_properties_of_a_file_are_requested_at_their_controls() -> None:
    from roughcontact.desk import inputs_panel

    error = InputError("gives no value; give it, e.g. ", ArgumentRef("no_data", "auto"))
    assert inputs_panel._lacking_properties(error) == ["no-data"]
    assert "“Value of missing points” auto" in error_text(error)


def test_control_shows_a_value_that_it_does_not_list() -> None:
    control = Control("form", lambda name, value: None, {"–": "", "sphere": "sphere"})
    control.show_options({"form": "polynomial 12"})
    assert control.widget.value == "polynomial 12"
    control.show_options({})
    assert control.widget.value == ""


def test_figure_is_embedded() -> None:
    assert 'src="data:image/png;base64,AQI="' in picture_markup(b"\x01\x02")
