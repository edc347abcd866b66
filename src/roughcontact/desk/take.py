"""What one takes away: files of the contact, and the words that make it again elsewhere."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import panel as pn

from roughcontact.desk import style, words
from roughcontact.desk.answers import Answer
from roughcontact.desk.ask import Begin, Running
from roughcontact.desk.controls import button
from roughcontact.desk.session import Session
from roughcontact.errors import RoughcontactError
from roughcontact.formats import export
from roughcontact.formats.export import Kind
from roughcontact.report import script

_REPORT = "report (.html)"
_STEM = "contact"

Offer = Callable[[Path], str]
"""``offer(path)`` returns the address under which the browser gets a file."""


class Take:
    """Files to make, and the same contact as command, script and project file."""

    def __init__(
        self,
        session: Session,
        begin: Begin,
        offer: Offer,
        folder: Path,
        run: Callable[[Callable[[], None]], None],
    ) -> None:
        self._session, self._begin, self._offer, self._run = session, begin, offer, run
        self._folder = folder
        self._running: Running | None = None
        names = [_REPORT, *(f"result ({suffix})" for suffix in export.suffixes(Kind.CONTACT))]
        self._kind = pn.widgets.Select(name="File", options=names, **style.CONTROL)
        self._make = button("Make the file", self._started, primary=True)
        self._said = pn.pane.HTML("", **style.WIDE)
        self._links = pn.pane.HTML("", **style.WIDE)
        self._words = pn.pane.HTML("", **style.WIDE)
        self.root = pn.Row(
            pn.Column(self._kind, self._make, self._said, self._links, width=300,
                      margin=(8, 16, 0, 0)),
            pn.Column(self._words, sizing_mode="stretch_both", margin=(8, 0)),
            sizing_mode="stretch_both",
        )  # fmt: skip
        self._made: list[Path] = []

    def show(self) -> None:
        """Show the words that make the contact again."""
        session = self._session
        parts = [_block("Project file, for roughcontact run", session.state.script)]
        if not session.state.missing:
            try:
                command = session.request.command
            except RoughcontactError:
                command = ""
            if command:
                parts.insert(0, _block("Command", command))
        outcome = session.outcome
        if outcome is not None and outcome.result is not None:
            parts.insert(1, _block("Python", script.repeating(outcome.result)))
        self._words.object = "".join(parts)

    def progress(self, text: str, share: float | None) -> None:
        """Show how it goes; see `ask.Told`."""
        self._run(lambda: self._say(text))

    def done(self, found: Answer) -> None:
        """Offer the files; see `ask.Told`."""
        self._run(lambda: self._show(found))

    def failed(self, sentence: str) -> None:
        """Say why there is none; see `ask.Told`."""
        self._run(lambda: self._refuse(sentence))

    def _started(self) -> None:
        kind = self._kind.value
        suffix = kind[kind.index("(") + 1 : -1]
        path = self._folder / f"{_STEM}{suffix}"
        wanted = {"report": str(path)} if kind == _REPORT else {"output": str(path)}
        try:
            request = self._session.state.request(**wanted)
        except RoughcontactError as error:
            self._refuse(words.told(error))
            return
        self._make.disabled = True
        self._say("starting …")
        self._running = self._begin(request, self)

    def _show(self, found: Answer) -> None:
        self._rest("")
        if not found.outcome.converged:
            self._refuse(words.spelled(found.outcome.shortfall))
            return
        self._made = [*dict.fromkeys([*self._made, *found.outcome.written])]
        items = "".join(
            f'<p><a href="{words.escaped(self._offer(path))}" download>'
            f"{words.escaped(path.name)}</a></p>"
            for path in self._made
        )
        self._links.object = f"<h2>Ready</h2>{items}"

    def _say(self, text: str) -> None:
        self._said.object = f'<span class="quiet">{words.escaped(text)}</span>' if text else ""

    def _rest(self, text: str) -> None:
        self._running = None
        self._make.disabled = False
        self._say(text)

    def _refuse(self, sentence: str) -> None:
        self._rest("")
        self._said.object = f'<span role="alert" class="wrong">{words.escaped(sentence)}</span>'


def _block(title: str, text: str) -> Any:
    return f"<h2>{words.escaped(title)}</h2><pre>{words.escaped(text)}</pre>"
