"""Shared helpers for tests of a page: a contact, keys, and the turns of its loop."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import roughcontact as rc
from roughcontact.batch import project
from roughcontact.cli import app
from roughcontact.request.run import run_request

if TYPE_CHECKING:
    from roughcontact.desk.page import Page
    from roughcontact.desk.session import Session

PATIENCE = 60.0
GIVEN = {"material": "100Cr6", "boundary": "periodic", "load": "10 mN"}


class Pressed(NamedTuple):
    """A key."""

    new: dict[str, str]


class Loop:
    """Scheduler of the changes of a page: here, a test runs them."""

    def __init__(self) -> None:
        self.waiting: list[Callable[[], None]] = []

    def add_next_tick_callback(self, done: Callable[[], None]) -> None:
        self.waiting.append(done)

    def add_timeout_callback(self, done: Callable[[], None], milliseconds: int) -> None:
        self.waiting.append(done)


def solve_and_show(page: Page) -> None:
    """Run the requested solves of a page, and show them."""
    assert page.session.wait(PATIENCE)
    waiting = page._document.waiting
    while waiting:
        waiting.pop(0)()


def give_all(session: Session, specified: dict[str, str | bool]) -> None:
    """Set several options of a session as one step."""
    state = session.state
    for name, value in specified.items():
        state = state.with_option(name, value)
    session._change_state(state)


def compare_contacts(session: Session, folder: Path) -> None:
    """Solve the contact of a session by the command and by the project file; compare the bits."""
    outcome = session.outcome
    if outcome is None or outcome.contact is None or not outcome.converged:
        return
    # The files stand under the names that the program gave them.
    words = shlex.split(replace(session.request, names={}).command)
    output = folder / "own.nc"
    assert app.main([*words[1:], "--output", str(output), "--quiet"]) == app.SOLVED
    (session.project.parent / "results").mkdir(exist_ok=True)
    entries = {entry.name: entry for entry in project.read_project(session.project)}
    from_file = run_request(entries["contact"].request, lambda _: None).contact
    assert from_file is not None
    for other in (rc.read_result(output), from_file):
        for name in ("pressure", "gap"):
            own = getattr(outcome.contact, name)
            assert own.tobytes() == getattr(other, name).tobytes()
        assert (other.load, other.approach) == (outcome.contact.load, outcome.contact.approach)
