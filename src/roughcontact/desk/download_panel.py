"""Panel of downloads: files of the contact, its command, script and project file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import panel as pn

from roughcontact.desk import controls, style, workers
from roughcontact.desk.controls import JobButton, Run
from roughcontact.desk.saved_page import save_page
from roughcontact.desk.session import Session
from roughcontact.desk.widgets import TabPanel
from roughcontact.errors import RoughcontactError
from roughcontact.report import python_script
from roughcontact.request.outcome import Outcome

_PAGE, _REPORT = "page with maps (.html)", "report (.html)"
_FILES = (_PAGE, _REPORT, "result (.nc)", "result (.csv)")
_STEM = "contact"

Offer = Callable[[Path], str]
"""``offer(path)`` returns the address at which the browser downloads a file."""


class DownloadPanel(TabPanel):
    """Files to create, and the contact as command, script and project file."""

    def __init__(
        self, session: Session, bench: workers.WorkerPool, run: Run, folder: Path, offer: Offer
    ) -> None:
        self._session, self._folder, self._offer = session, folder, offer
        self._downloads: dict[str, str] = {}
        self._kind = pn.widgets.Select(label="File", options=list(_FILES), **style.CONTROL)
        self._kind.param.watch(self._handle_selection, "value")
        self._working = JobButton(bench, run, "Save page", self._started, session)
        self._links = pn.pane.HTML("", **style.WIDE)
        self._words = pn.pane.HTML("", **style.WIDE)
        self.root = pn.Row(
            pn.Column(self._kind, self._working.root, self._links, width=300, margin=(8, 16, 0, 0)),
            pn.Column(self._words, sizing_mode="stretch_both", margin=(8, 0)),
            sizing_mode="stretch_both",
        )

    def refresh(self) -> None:
        """Show the command, the script and the project file that reproduce the contact."""
        session = self._session
        parts = [
            controls.copy_markup(
                "Project file, for roughcontact run", session.state.portable_script
            )
        ]
        if not session.state.missing:
            try:
                command = session.request.command
            except RoughcontactError:
                command = ""
            if command:
                parts.insert(0, controls.copy_markup("Command", command))
        outcome = session.outcome
        if outcome is not None and outcome.contact is not None:
            parts.insert(
                1, controls.copy_markup("Python", python_script.script_of_result(outcome.contact))
            )
        self._words.object = "".join(parts)

    def _handle_selection(self, event: Any) -> None:
        self._working.name(f"Save {event.new.partition(' ')[0]}")

    def _started(self) -> None:
        kind = self._kind.value
        suffix = kind[kind.index("(") + 1 : -1]
        # A number in the name: later downloads do not change an offered file.
        path = self._folder / f"{_STEM}-{len(self._downloads) + 1}{suffix}"
        name = "report" if kind == _REPORT else "output"
        wanted = {} if kind == _PAGE else {name: str(path)}
        try:
            request = self._session.state.request(**wanted)
        except RoughcontactError as error:
            self._working.refuse_error(error)
            return
        if kind == _PAGE:
            self._working.start_job(save_page, self._show_outcome, request, path)
        else:
            self._working.start_job(workers.run_request, self._show_outcome, request)

    def _show_outcome(self, outcome: Outcome) -> None:
        if outcome.failure is not None:
            self._working.refuse_error(outcome.failure)
        elif not outcome.converged:
            self._working.show_refusal(controls.spell_sentence(outcome.shortfall))
        for path in outcome.written:
            self._add(path, path.name)
        self._list()

    def _add(self, path: Path, name: str) -> None:
        self._downloads[f"{name} ({path.stat().st_size / 1e6:.1f} MB)"] = self._offer(path)

    def _list(self) -> None:
        items = "".join(
            f'<p><a href="{controls.escape_markup(address)}" '
            f"download>{controls.escape_markup(name)}</a></p>"
            for name, address in self._downloads.items()
        )
        self._links.object = f"<h2>Ready</h2>{items}" if items else ""
