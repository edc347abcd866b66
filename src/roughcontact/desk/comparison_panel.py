"""Two states side by side: one is pinned, the other goes on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import panel as pn

from roughcontact.desk import controls, style, workers
from roughcontact.desk.analysis_jobs import Pair, compare
from roughcontact.desk.analysis_panel import picture
from roughcontact.desk.controls import Run, Working, button
from roughcontact.desk.session import Session
from roughcontact.errors import RoughcontactError
from roughcontact.request.solve import TASK as SOLVE

_NAMES = ("this state", "pinned state")


class Compare:
    """What is pinned, what differs, and both contacts beside each other."""

    def __init__(
        self,
        session: Session,
        bench: workers.WorkerPool,
        run: Run,
        do: Callable[[Callable[[], None]], None],
    ) -> None:
        self._session = session
        self._pin = button("Pin this state", lambda: do(session.pin))
        self._swap = button("Go to the pinned state", lambda: do(session.swap))
        self._unpin = button("Unpin", lambda: do(session.unpin))
        self._differences = pn.pane.HTML("", **style.WIDE)
        self._working = Working(bench, run, "Compare", self._started, session)
        self._answer = pn.Column(sizing_mode="stretch_both")
        self.root = pn.Row(
            pn.Column(
                pn.Row(self._pin, self._unpin), self._swap, self._differences,
                self._working.root, width=300, margin=(8, 16, 0, 0),
            ),
            self._answer,
            sizing_mode="stretch_both",
        )  # fmt: skip

    def show(self) -> None:
        """Show what is pinned, and in what it differs."""
        state = self._session.state
        pinned = state.pinned
        self._swap.disabled = self._unpin.disabled = pinned is None
        if pinned is None:
            text = "<p>Pin a state, then change the load, a body or the map: both are compared.</p>"
        else:
            names = sorted(
                name
                for name in {*state.given, *pinned}
                if state.given.get(name) != pinned.get(name)
            )
            rows = [
                (SOLVE.by_name[name].label, _told(state.given.get(name)), _told(pinned.get(name)))
                for name in names
            ]
            same = "<p>Both are the same so far.</p>"
            text = controls.table(rows, ("what differs", "this", "pinned")) if rows else same
        self._differences.object = text

    def cancel(self) -> None:
        """End what is under way."""
        self._working.cancel()

    def _started(self) -> None:
        state = self._session.state
        if state.pinned is None:
            self._working.refuse("Pin a state first.")
            return
        try:
            requests = state.request(), replace(state, given=state.pinned).request()
        except RoughcontactError as error:
            self._working.refuse_error(error)
            return
        self._answer[:] = []
        self._working.begin(compare, self._show, *requests, _NAMES)

    def _show(self, result: Pair) -> None:
        cautions = "".join(
            f"<h2>{name}</h2>{controls.cautions(text)}"
            for name, text in zip(_NAMES, result.cautions, strict=True)
        )
        parts: list[Any] = [
            picture(("both contacts", result.picture)),
            pn.pane.HTML(controls.table(result.rows, ("", *_NAMES)), **style.WIDE),
            pn.pane.HTML(cautions, **style.WIDE),
        ]
        self._answer[:] = parts


def _told(value: str | bool | None) -> str:
    return "–" if value is None else "yes" if value is True else str(value)
