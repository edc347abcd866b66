"""What the joint does in the next model, asked of one contact: solved once, answered one by one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import panel as pn

from roughcontact.desk import apart, headline, style, words
from roughcontact.desk.answers import JOINTS, Answer, answers
from roughcontact.desk.ask import Form, picture
from roughcontact.desk.controls import Control
from roughcontact.desk.reach import Check
from roughcontact.desk.session import Session
from roughcontact.desk.state import Value
from roughcontact.desk.take import Offer
from roughcontact.desk.working import Run, Working
from roughcontact.errors import RoughcontactError
from roughcontact.report import estimated
from roughcontact.report.quantities import rows_of
from roughcontact.request.joints import RANGE
from roughcontact.request.request import Request

_UNKNOWN = '<p class="quiet">No estimate: the formulas of flat contact do not know this one.</p>'

_TASK, _ = JOINTS[0]
_RANGE = dict(zip((option.name for option in RANGE), ("1 MPa", "100 MPa", "5"), strict=True))
"""Nominal pressures that are proposed; all questions are asked under the same."""


class Joint:
    """The questions with a box each, the pressures for all of them, and the answers."""

    def __init__(
        self, session: Session, bench: apart.Bench, run: Run, folder: Path, offer: Offer
    ) -> None:
        self._session, self._folder, self._offer = session, folder, offer
        self._asked = 0
        self._range: dict[str, Value] = dict(_RANGE)
        pressures = [Control(name, self._give, task=_TASK) for name in _RANGE]
        for control in pressures:
            control.show(self._range)
        self._boxes = {
            question.name: Check(words=question.name, value=True, **style.BLOCK)
            for _, question in JOINTS
        }
        self._forms = {question.name: Form(task, question) for task, question in JOINTS}
        self._working = Working(bench, run, "Start", self._started, session)
        self._formulas = pn.pane.HTML("", **style.WIDE)
        self._answers = pn.Column(sizing_mode="stretch_both")
        about = pn.pane.HTML(
            '<p class="quiet">Under nominal pressures from one to another, each solved once for '
            "all that is asked.</p>", **style.SHEET,
        )  # fmt: skip
        parts = [
            part for name in self._boxes for part in (self._boxes[name], self._forms[name].root)
        ]
        self.root = pn.Row(
            pn.Column(
                about,
                *(control.root for control in pressures),
                *parts,
                self._working.root,
                width=250,
                margin=(8, 16, 0, 0),
            ),
            pn.Column(self._formulas, self._answers, sizing_mode="stretch_both"),
            sizing_mode="stretch_both",
        )

    def show(self) -> None:
        """Show what formulas say of the contact as it is; what was asked stays as it was."""
        outcome = self._session.outcome
        result = None if outcome is None else outcome.contact
        told = [] if result is None else rows_of(estimated.BESIDE, result)
        rows = [(row.title, row.text) for row in told]
        self._formulas.object = headline.table(rows) if rows else _UNKNOWN

    def cancel(self) -> None:
        """End what is under way."""
        self._working.cancel()

    def _give(self, name: str, value: Value) -> None:
        text = value.strip() if isinstance(value, str) else value
        if text:
            _TASK.parsed({name: text})
        self._range[name] = text

    def _started(self) -> None:
        wanted = [one for one in JOINTS if self._boxes[one[1].name].value]
        if not wanted:
            self._working.refuse("Nothing is asked: tick what the joint is asked.")
            return
        self._asked += 1
        requests = []
        for task, question in wanted:
            try:
                told = {f"{name}_": value for name, value in self._range.items()}
                told |= self._forms[question.name].words
                request = self._session.state.request(task, **told)
                requests.append(self._with_files(request))
            except RoughcontactError as error:
                self._working.refuse_error(error, task)
                return
        self._answers[:] = []
        self._working.begin(answers, self._show, *requests)

    def _with_files(self, request: Request) -> Request:
        """Return a request with the files that one may take away."""
        output = next(one for one in request.task.options if one.suffixes)
        paths = [
            str(self._folder / f"{request.task.name}-{self._asked}{suffix}")
            for suffix in (output.suffixes if output.many else output.suffixes[:1])
        ]
        given = {**request.given, output.name: paths if output.many else paths[0]}
        return replace(Request.from_text(request.task, request.file, given), names=request.names)

    def _show(self, found: tuple[Answer, ...]) -> None:
        self._answers[:] = [part for one in found for part in self._shown(one)]

    def _shown(self, found: Answer) -> list[Any]:
        """Return what shows an answer: title, cautions, figures, numbers, files, the command."""
        request = found.outcome.request
        name = next(question.name for task, question in JOINTS if task is request.task)
        told = "".join(f"<p>{words.escaped(sentence)}</p>" for sentence in found.sentences)
        links = ", ".join(
            f'<a href="{words.escaped(self._offer(path))}" download>{words.escaped(path.name)}</a>'
            for path in found.outcome.written
        )
        own = {
            key: value
            for key, value in request.given.items()
            if not request.task.by_name[key].suffixes
        }
        command = replace(request, given=own).command
        return [
            pn.pane.HTML(f"<h2>{words.escaped(name)}</h2>", **style.WIDE),
            pn.pane.HTML(headline.cautions(found.cautions), **style.WIDE),
            *map(picture, found.pictures),
            pn.pane.HTML(headline.table(found.steps, found.heads), **style.WIDE),
            pn.pane.HTML(headline.table(found.facts) + told, **style.WIDE),
            pn.pane.HTML(f"<p>Files: {links}</p>", **style.WIDE),
            pn.pane.HTML(f"<pre>{words.escaped(command)}</pre>", **style.WIDE),
        ]
