"""Questions beside the solution: asked, worked on apart with progress, cancelled, answered."""

from __future__ import annotations

import base64
from collections.abc import Callable
from typing import Any, cast

import panel as pn

from roughcontact.contact.curve import LoadCurve
from roughcontact.contact.history import LoadHistory
from roughcontact.contact.stress import StressResult
from roughcontact.contact.study import ResolutionStudy
from roughcontact.desk import apart, headline, style, words
from roughcontact.desk.answers import QUESTIONS, Answer, answer
from roughcontact.desk.controls import Control
from roughcontact.desk.curves import Curve, History, Study
from roughcontact.desk.session import Session
from roughcontact.desk.state import Value
from roughcontact.desk.stress import Stress
from roughcontact.desk.working import Run, Working
from roughcontact.errors import RoughcontactError
from roughcontact.request.task import Question, Task


class Ask:
    """The questions, the form of the one that is chosen, and its answer."""

    def __init__(self, session: Session, bench: apart.Bench, run: Run) -> None:
        self._session = session
        names = [question.name for _, question in QUESTIONS]
        self._forms: dict[str, Form] = {}
        self._choice = pn.widgets.RadioBoxGroup(
            label="Question", options=names, value=names[0], **style.CONTROL
        )
        self._form = pn.Column(self._form_of(names[0]).root, **style.BLOCK)
        self._working = Working(bench, run, "Start", self._started, session)
        self._answer = pn.Column(sizing_mode="stretch_both")
        self._curve: Curve | None = None
        self._choice.param.watch(self._chosen, "value")
        self.root = pn.Row(
            pn.Column(
                self._choice, self._form, self._working.root, width=250, margin=(8, 16, 0, 0)
            ),
            self._answer,
            sizing_mode="stretch_both",
        )

    def cancel(self) -> None:
        """End what is under way."""
        self._working.cancel()

    def _chosen(self, event: Any) -> None:
        self._form[:] = [self._form_of(event.new).root]

    def _form_of(self, name: str) -> Form:
        if name not in self._forms:
            found = next(one for one in QUESTIONS if one[1].name == name)
            self._forms[name] = Form(*found)
        return self._forms[name]

    def _started(self) -> None:
        form = self._form_of(self._choice.value)
        task = form.task
        try:
            request = self._session.state.request(task, **form.words)
        except RoughcontactError as error:
            self._working.refuse_error(error, task)
            return
        self._answer[:] = []
        self._working.begin(answer, self._show, request)

    def _show(self, found: Answer) -> None:
        if not found.outcome.converged:
            self._working.refuse(words.spelled(found.outcome.shortfall))
        self._curve = None
        self._answer[:] = self._shown(found)

    def show(self) -> None:
        """Mark the load that is worked with in a load curve, if one is there."""
        outcome = self._session.outcome
        if self._curve is not None and outcome is not None and outcome.contact is not None:
            self._curve.mark(outcome.contact.load)

    def _shown(self, found: Answer) -> list[Any]:
        """Return what shows an answer."""
        cautions = pn.pane.HTML(headline.cautions(found.cautions), **style.WIDE)
        facts = pn.pane.HTML(headline.table(found.facts), **style.WIDE)
        view = _view(found.found)
        if view is not None:
            if isinstance(view, Curve):
                self._curve = view
                self.show()
            seen = [cautions, pn.pane.Bokeh(view.root, **style.BLOCK)]
            # The others tell these numbers themselves.
            return [*seen, facts] if isinstance(view, (Curve, History)) else seen
        parts: list[Any] = [cautions, *map(picture, found.pictures), facts]
        if found.steps:
            parts.append(pn.pane.HTML(headline.table(found.steps, found.heads), **style.WIDE))
        return parts


class Form:
    """What can be told of a question."""

    def __init__(self, task: Task, question: Question) -> None:
        self.task, self._question = task, question
        self._given: dict[str, Value] = {option.name: value for option, value in question.first}
        controls = [Control(option.name, self._give, task=task) for option in question.options]
        for control in controls:
            control.show(self._given)
        about = pn.pane.HTML(f'<p class="quiet">{words.escaped(question.about)}</p>', **style.SHEET)
        self.root = pn.Column(about, *(control.root for control in controls), **style.BLOCK)

    @property
    def words(self) -> dict[str, Value]:
        """What is told, as `State.request` takes it."""
        fixed = {option.name: value for option, value in self._question.fixed}
        told = {**self._given, **fixed}
        return {f"{name.replace('-', '_')}_": value for name, value in told.items()}

    def _give(self, name: str, value: Value) -> None:
        if isinstance(value, str) and not self.task.by_name[name].is_flag:
            value = value.strip()
        if value in ("", False):
            self._given.pop(name, None)
            return
        self.task.parsed({name: value})
        self._given[name] = value


def _view(found: Any) -> Curve | History | Study | Stress | None:
    """Return the page's own view of a result, if it has one."""
    views: dict[type, Callable[[], Any]] = {
        LoadCurve: Curve, LoadHistory: History, ResolutionStudy: Study, StressResult: Stress,
    }  # fmt: skip
    for kind, view in views.items():
        if isinstance(found, kind):
            made = view()
            made.show(found)
            return cast("Curve | History | Study | Stress", made)
    return None


def picture(figure: tuple[str, bytes]) -> Any:
    """Return what shows a figure, given with its name as PNG."""
    name, data = figure
    text = base64.b64encode(data).decode("ascii")
    alt = words.escaped(name.replace("-", " "))
    return pn.pane.HTML(
        f'<img alt="{alt}" style="max-width: 100%; height: auto" '
        f'src="data:image/png;base64,{text}">',
        **style.WIDE,
    )
