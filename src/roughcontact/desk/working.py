"""Work under way: begun apart, shown with its progress, cancelled, ended."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import panel as pn

from roughcontact.desk import apart, style, words
from roughcontact.desk.controls import button
from roughcontact.desk.session import Session
from roughcontact.errors import RoughcontactError
from roughcontact.report import underway
from roughcontact.request.request import Request
from roughcontact.request.solve import TASK as SOLVE
from roughcontact.request.task import Task

Run = Callable[[Callable[[], None]], None]
"""``run(done)`` calls ``done`` where the page may be changed."""


class Working:
    """A button that begins a job, and what is seen of it until it ends.

    Parameters
    ----------
    bench : apart.Bench
        Where jobs are done.
    run : callable
        Calls what changes the page.
    name : str
        Of the button.
    begin : callable
        Called when it is pressed; it calls `begin` or `refuse`.
    session : Session
        Whose files are told by the user's names.
    """

    def __init__(
        self, bench: apart.Bench, run: Run, name: str, begin: Callable[[], None], session: Session
    ) -> None:
        self._bench, self._run, self._session = bench, run, session
        self._job: apart.Job | None = None
        self._task: Task = SOLVE
        self._take: Callable[[Any], None] = lambda _: None
        self._start = button(name, begin, primary=True)
        self._cancel = button("Cancel", self.cancel, disabled=True)
        self._bar = pn.indicators.Progress(
            active=True, value=-1, visible=False, **{**style.CONTROL, "height": 8}
        )
        self._said = pn.pane.HTML("", **style.WIDE)
        self.root = pn.Column(
            pn.Row(self._start, self._cancel), self._bar, self._said, **style.BLOCK
        )

    def begin(
        self, work: Callable[..., Any], take: Callable[[Any], None], request: Request, *more: Any
    ) -> None:
        """Begin a job on a request (and more), and have what it gives taken."""
        self._task, self._take = request.task, take
        self._start.disabled, self._cancel.disabled = True, False
        self._bar.visible, self._bar.value = True, -1
        self._said.object = _quiet("starting …")
        self._job = self._bench.begin(
            work,
            request,
            *more,
            told=self._told,
            ended=self._ended,
            folders=apart.folders_of(request),
        )

    def cancel(self) -> None:
        """End what is under way."""
        if self._job is not None:
            self._job.cancel()

    def refuse(self, text: str) -> None:
        """Say why there is nothing."""
        self._said.object = f'<span role="alert" class="wrong">{words.escaped(text)}</span>'

    def refuse_error(self, error: RoughcontactError, task: Task = SOLVE) -> None:
        """Say why there is nothing, in the words of the page."""
        self.refuse(self._session.state.named(words.told(error, task)))

    # Called from the thread of the job.

    def _told(self, stage: apart.Stage) -> None:
        self._run(lambda: self._show(stage))

    def _ended(self, end: apart.End) -> None:
        self._run(lambda: self._close(end))

    # Where the page may be changed.

    def _show(self, stage: apart.Stage) -> None:
        text = stage.at if isinstance(stage.at, str) else underway.described(stage.at)
        left = "" if stage.left is None else f"; about {stage.left:.0f} s left"
        self._said.object = _quiet(f"{text}; {stage.seconds:.0f} s so far{left}")
        self._bar.value = -1 if stage.share is None else round(100 * stage.share)

    def _close(self, end: apart.End) -> None:
        self._job = None
        self._start.disabled, self._cancel.disabled = False, True
        self._bar.visible = False
        if end.canceled:
            self._said.object = _quiet("Cancelled; nothing was kept.")
        elif end.error is not None:
            self.refuse_error(end.error, self._task)
        else:
            self._said.object = _quiet(f"Done in {end.seconds:.1f} s.")
            self._take(end.value)


def _quiet(text: str) -> str:
    return f'<span class="quiet" role="status">{words.escaped(text)}</span>'
