"""Random sequences of actions on the pages of a project: page = project file = command."""

from __future__ import annotations

import os
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import panel as pn
import pytest
from hypothesis import HealthCheck, Phase, settings, strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)

import roughcontact as rc

pytest.importorskip("panel", reason="needs roughcontact[desk]")

from roughcontact.desk import header, style
from roughcontact.desk.header import form_of
from roughcontact.desk.maps import NAMES
from roughcontact.desk.page import Page
from roughcontact.desk.projects import ProjectStore
from roughcontact.desk.server import PageVisit
from roughcontact.desk.session import from_script
from roughcontact.desk.workers import WorkerPool
from visits import GIVEN, PATIENCE, Loop, Pressed, compare_contacts, give_all, solve_and_show

_POOL: list[WorkerPool] = []


@pytest.fixture(scope="module", autouse=True)
def pool() -> Iterator[None]:
    _POOL.append(WorkerPool(spare=False))
    yield
    _POOL.pop().close()


class Actions(RuleBasedStateMachine):
    """Random actions on up to three pages of a project in a relative folder."""

    @initialize()
    def begin(self) -> None:
        self.folder = tempfile.TemporaryDirectory()
        self.root = root = Path(self.folder.name)
        rng = np.random.default_rng(1)
        self.maps = []
        for name, shape in (("a.npz", (16, 20)), ("b.npz", (12, 10)), ("long.npz", (1, 64))):
            heights = 1e-7 * rng.standard_normal(shape)
            if name == "b.npz":
                heights[2, 3] = np.nan
            pixel = (1.0 if shape[0] == 1 else 1e-6, 1e-6)
            rc.Surface(heights, pixel).save(root / name)
            self.maps.append(root / name)
        self.work = ProjectStore(Path(os.path.relpath(root / "works"))).create()
        self.pages: list[Any] = []
        self.enter()

    @rule()
    @precondition(lambda self: len(self.pages) < 3)
    def enter(self) -> None:
        """Open the project in another tab."""

        def other_visits() -> list[PageVisit]:
            return [page._visit for page in self.pages if page._visit is not visit]

        visit = PageVisit(self.work, None, _POOL[0], 2**20, lambda: None, list, other_visits)
        self.page = Page(visit)
        self.page._document = Loop()
        self.pages.append(self.page)

    @rule(number=st.integers(0, 2))
    def change_page(self, number: int) -> None:
        self.page = self.pages[number % len(self.pages)]
        self.run_loop()

    def run_loop(self) -> None:
        while self.page._document.waiting:
            self.page._document.waiting.pop(0)()

    @rule(number=st.integers(0, 2), complete=st.booleans())
    def bring(self, number: int, complete: bool) -> None:
        self.page._run_action(lambda: self.page.session.open_map(self.maps[number]))
        if complete:
            load = "1 N/m" if number == 2 else GIVEN["load"]
            self.page._run_action(lambda: give_all(self.page.session, {**GIVEN, "load": load}))

    @rule(place=st.integers(0, 300), done=st.booleans())
    def slide(self, place: int, done: bool) -> None:
        self.page._load.slider.moved = {"value": place, "done": done, "count": place}

    @rule(text=st.sampled_from(["1 mN", "20 MPa", "1 GPa", "-1 N", "much", "600 N/mm", ""]))
    def type_a_load(self, text: str) -> None:
        self.page._load.text.value = text

    @rule(
        given=st.sampled_from(
            [
                ("_bodies", "material", ""),
                ("_bodies", "material", "42CrMo4"),
                ("_model", "boundary", "free"),
                ("_model", "boundary", "periodic"),
                ("_model", "ceiling", "none"),
                ("_model", "ceiling", "1 Pa"),
                ("_preparation", "level", "none"),
                ("_preparation", "missing", "fill"),
                ("_preparation", "missing", "error"),
                ("_preparation", "outliers", "6"),
                ("_preparation", "outliers", "-6"),
            ]
        )
    )
    def choose(self, given: tuple[str, str, str]) -> None:
        part, name, value = given
        if name == "boundary":
            self.page._model._extent.value = value
        else:
            getattr(self.page, part)._group.controls[name].widget.value = value

    @rule(form=st.sampled_from(["", "sphere", "polynomial 2", "polynomial 4"]))
    def take_out_a_form(self, form: str) -> None:
        self.page._preparation._group.controls["form"].widget.value = form

    @rule(name=st.sampled_from(["undo", "redo", "?", "Escape", *"12345"]))
    def press(self, name: str) -> None:
        self.page._handle_shortcut(Pressed({"name": name}))

    @rule(place=st.integers(0, 2))
    def remove_a_step(self, place: int) -> None:
        lines = [line for line in self.page._preparation._steps if isinstance(line, pn.Row)]
        if place < len(lines):
            lines[place][1].clicks += 1

    @rule(place=st.integers(0, 5))
    def turn(self, place: int) -> None:
        self.page._views.strip.active = place

    @rule(place=st.integers(0, 3))
    def look_beside_the_map(self, place: int) -> None:
        self.page.view.detail._tabs.strip.active = place

    @rule(number=st.integers(0, 3))
    def drop(self, number: int) -> None:
        """Drop an uploaded file: one that cannot be read changes nothing."""
        folder = self.work.make_folder()
        path = folder / f"map-{number}.npz"
        if number < 3:
            path.write_bytes(self.maps[number].read_bytes())
        else:
            path.write_text("no map")
        before, ended = self.page.session.state, threading.Event()
        check = self.page._reader.check
        self.page._reader.check = lambda path, end: check(path, lambda e: (end(e), ended.set()))
        count = self.page._window.arrived.get("number", 0) + 1
        self.page._window.arrived = {"file": path.name, "name": "mine.npz", "number": count}
        assert ended.wait(PATIENCE)
        self.page._reader.check = check
        self.run_loop()
        if number == 3:
            assert self.page.session.state == before
        else:
            assert self.page.session.state.file == path

    @rule(do=st.sampled_from(["pin", "unpin", "swap_pinned"]))
    def pin(self, do: str) -> None:
        self.page._run_action(getattr(self.page.session, do))

    @rule(size=st.sampled_from([[1024, 768], [1920, 1080]]))
    def resize(self, size: list[int]) -> None:
        self.page._window.size = size

    @rule()
    def reload(self) -> None:
        self.pages.remove(self.page)
        self.page.close()
        self.enter()

    @rule()
    def look(self) -> None:
        """Wait until the sheet shows the contact of the state."""
        page, session = self.page, self.page.session
        solve_and_show(page)
        state, outcome = session.state, session.outcome
        if outcome is None or outcome.contact is None:
            assert bool(state.missing) or session.failure is not None
            return
        contact = outcome.contact
        form = form_of(state.specified)
        assert page._header.numbers.object == header.key_numbers(contact, form)
        assert page._header.numbers.styles == style.NEW
        assert page.view.maps.result is contact
        assert page.view.maps.large == list(NAMES)[page.view.maps.strip.active]
        if not contact.surface.is_profile:
            assert len(page.view.maps.strip.pictures) == len(NAMES)

    @invariant()
    def the_project_file_holds_the_state_and_the_controls_show_it(self) -> None:
        page, state, path = self.page, self.page.session.state, self.work.project
        assert all(other.session.state == state for other in self.pages)
        if path.exists():
            assert from_script(path.read_text("utf-8"), path.parent) == state
        form = page._preparation._group.controls["form"]
        assert state.specified.get("form", "") == form.widget.value
        # Gray, unless they answer the last request.
        if page._header.numbers.object:
            is_old = page._header.numbers.styles == style.OLD
            assert is_old == (page._answer != page.session.number)

    def teardown(self) -> None:
        if not hasattr(self, "pages"):
            return
        try:
            for number in range(len(self.pages)):
                self.change_page(number)
                self.look()
            compare_contacts(self.page.session, self.root)
        finally:
            for page in self.pages:
                page.close()
            self.folder.cleanup()


_MANY = settings(
    max_examples=500,
    stateful_step_count=12,
    deadline=None,
    # To make a failure smaller takes a hundred times as long as to find it.
    phases=[Phase.generate],
    suppress_health_check=list(HealthCheck),
)


@pytest.mark.slow
def test_page_matches_project_file_and_command_in_500_sequences() -> None:
    run_state_machine_as_test(Actions, settings=_MANY)
