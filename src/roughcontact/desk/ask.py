"""Questions beside the solution: asked, worked on apart with progress, cancelled, answered."""

from __future__ import annotations

import base64
from collections.abc import Callable
from typing import Any, Protocol

import panel as pn

from roughcontact.desk import headline, style, words
from roughcontact.desk.answers import QUESTIONS, Answer, Question
from roughcontact.desk.controls import Control, button
from roughcontact.desk.session import Session
from roughcontact.desk.state import Value
from roughcontact.errors import RoughcontactError
from roughcontact.request.options import offered, parsed
from roughcontact.request.request import Request


class Running(Protocol):
    """Work under way in another process."""

    def cancel(self) -> None:
        """End it within a second."""


class Told(Protocol):
    """Whom the work tells how it goes."""

    def progress(self, text: str, share: float | None) -> None:
        """Hear a few words, and the part that is done where that is known."""

    def done(self, found: Any) -> None:
        """Hear what was found."""

    def failed(self, sentence: str) -> None:
        """Hear why nothing was found."""


Begin = Callable[[Request, Told], Running]
"""``begin(request, told)`` begins to work on a request."""


class Ask:
    """The questions, the form of the one that is chosen, and its answer."""

    def __init__(self, session: Session, begin: Begin, run: Callable[..., None]) -> None:
        self._session, self._begin, self._run = session, begin, run
        self._forms = {question.name: _Form(question) for question in QUESTIONS}
        self._running: Running | None = None
        self._choice = pn.widgets.RadioBoxGroup(
            name="Question", options=list(self._forms), value=QUESTIONS[0].name, **style.CONTROL
        )
        self._form = pn.Column(self._forms[QUESTIONS[0].name].root, **style.BLOCK)
        self._start = button("Start", self._started, primary=True)
        self._cancel = button("Cancel", self.cancel, disabled=True)
        self._bar = pn.indicators.Progress(
            active=True, value=-1, visible=False, height=8, **style.CONTROL
        )
        self._said = pn.pane.HTML("", **style.WIDE)
        self._answer = pn.Column(sizing_mode="stretch_both")
        self._choice.param.watch(self._chosen, "value")
        self.root = pn.Row(
            pn.Column(
                self._choice, self._form, pn.Row(self._start, self._cancel), width=300,
                margin=(8, 16, 0, 0),
            ),
            pn.Column(
                self._bar, self._said, self._answer, sizing_mode="stretch_both", margin=(8, 0),
            ),
            sizing_mode="stretch_both",
        )  # fmt: skip

    def cancel(self) -> None:
        """End what is under way."""
        if self._running is not None:
            self._running.cancel()
            self._running = None
            self._rest("Cancelled; nothing was kept.")

    def progress(self, text: str, share: float | None) -> None:
        """Show how it goes; see `Told`."""
        self._run(lambda: self._go_on(text, share))

    def done(self, found: Answer) -> None:
        """Show what was found; see `Told`."""
        self._run(lambda: self._show(found))

    def failed(self, sentence: str) -> None:
        """Show why nothing was found; see `Told`."""
        self._run(lambda: self._refuse(sentence))

    @property
    def _question(self) -> Question:
        return self._forms[self._choice.value].question

    def _chosen(self, event: Any) -> None:
        self._form[:] = [self._forms[event.new].root]

    def _started(self) -> None:
        question, form = self._question, self._forms[self._choice.value]
        try:
            request = self._session.state.request(question.task, **form.words)
            request.check_places()
        except RoughcontactError as error:
            self._refuse(words.told(error, question.task))
            return
        self._answer[:] = []
        self._start.disabled, self._cancel.disabled = True, False
        self._bar.visible, self._bar.value = True, -1
        self._said.object = '<span class="quiet">starting …</span>'
        self._running = self._begin(request, self)

    def _go_on(self, text: str, share: float | None) -> None:
        if self._running is not None:
            self._said.object = f'<span class="quiet">{words.escaped(text)}</span>'
            self._bar.value = -1 if share is None else round(100 * share)

    def _rest(self, text: str) -> None:
        self._start.disabled, self._cancel.disabled = False, True
        self._bar.visible = False
        self._said.object = f'<span class="quiet">{words.escaped(text)}</span>' if text else ""

    def _refuse(self, sentence: str) -> None:
        self._running = None
        self._rest("")
        self._said.object = f'<span role="alert" class="wrong">{words.escaped(sentence)}</span>'

    def _show(self, found: Answer) -> None:
        if self._running is None:
            return
        self._running = None
        self._rest("")
        if not found.outcome.converged:
            self._refuse(words.spelled(found.outcome.shortfall))
        self._answer[:] = _shown(found)


class _Form:
    """What can be told of a question."""

    def __init__(self, question: Question) -> None:
        self.question = question
        self._given: dict[str, Value] = dict(question.first)
        controls = [Control(name, self._give, task=question.task) for name in question.options]
        for control in controls:
            control.show(self._given)
        about = pn.pane.HTML(f'<p class="quiet">{words.escaped(question.about)}</p>', **style.SHEET)
        self.root = pn.Column(about, *(control.root for control in controls), **style.BLOCK)

    @property
    def words(self) -> dict[str, Value]:
        """What is told, as `State.request` takes it."""
        told = {**self._given, **dict(self.question.fixed)}
        return {f"{name.replace('-', '_')}_": value for name, value in told.items()}

    def _give(self, name: str, value: Value) -> None:
        if isinstance(value, str) and offered(self.question.task)[name].is_flag is False:
            value = value.strip()
        if value in ("", False):
            self._given.pop(name, None)
            return
        parsed({name: value}, self.question.task)
        self._given[name] = value


def _shown(found: Answer) -> list[Any]:
    """Return what shows an answer."""
    parts = [headline.cautions(found.cautions), headline.table(found.facts)]
    if found.steps:
        parts.append(headline.table(found.steps, found.heads))
    panes = [pn.pane.HTML(part, **style.WIDE) for part in parts]
    return [*panes[:1], *map(_picture, found.pictures), *panes[1:]]


def _picture(figure: tuple[str, bytes]) -> Any:
    name, data = figure
    text = base64.b64encode(data).decode("ascii")
    alt = words.escaped(name.replace("-", " "))
    return pn.pane.HTML(
        f'<img alt="{alt}" style="max-width: 100%; height: auto" '
        f'src="data:image/png;base64,{text}">',
        **style.WIDE,
    )
