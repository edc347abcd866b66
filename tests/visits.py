"""Shared helpers for tests of a page: a contact, keys, and the turns of its loop."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

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
