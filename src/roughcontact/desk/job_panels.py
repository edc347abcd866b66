"""Panels of analyses, of the comparison of two states, and of files to download."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import cached_property, partial
from typing import Any

import panel as pn

import roughcontact as rc
from roughcontact.analyses.estimate import fields as formulas
from roughcontact.desk import analysis_jobs, controls, style, workers
from roughcontact.desk.controls import (
    Give,
    JobButton,
    OptionsForm,
    Run,
    caution_list,
    copy_markup,
    error_markup,
    escape_markup,
    make_button,
    markup_table,
    picture_markup,
    spell_sentence,
)
from roughcontact.desk.header import FORCE, NOMINAL, form_of, load_text
from roughcontact.desk.saved_page import save_page
from roughcontact.desk.server import PageVisit
from roughcontact.desk.session import SOLVE, Session, SessionState, Value
from roughcontact.desk.widgets import TabPanel
from roughcontact.report import kind as quantities, python_script
from roughcontact.request import task as commands
from roughcontact.request.outcome import Outcome
from roughcontact.request.request import Request

# Significant digits of a found load.
_DIGITS = 7


_ANALYSIS_HINT = "Set the options, then press Start: numbers, figures and command appear here."
_COMPARISON_HINT = "Compare solves both: their numbers side by side and a figure appear here."


class Answer:
    """Views of a result, gray as soon as other requests are made; before, how to get one."""

    def __init__(self, hint: str) -> None:
        markup = f'<p class="quiet">{escape_markup(hint)}</p>'
        self.root = pn.Column(pn.pane.HTML(markup, **style.WIDE), **style.HIGH)
        self._key: object = None

    def show_parts(self, parts: Sequence[Any], key: object = None) -> None:
        """Show views or markup of the result of the requests with a key, or nothing."""
        self._key = key
        views = [pn.pane.HTML(p, **style.WIDE) if isinstance(p, str) else p for p in parts]
        self.root.param.update(objects=views, styles=style.NEW)

    def compare_key(self, key: object) -> None:
        """Gray the views if the key of the present requests is another one."""
        self.root.styles = style.OLD if self._key not in (None, key) else style.NEW


def request_key(requests: Iterable[Request]) -> object:
    """Return the key of the results of requests; None if a request is invalid."""
    try:
        return [(item.task.name, item.file, dict(item.specified)) for item in requests]
    except rc.RoughcontactError:
        return None


class AnalysisPanel(TabPanel):
    """Selector of analyses, options of the selected one, and its result.

    Analyses of joints are shown with estimates of the current contact by formula.
    """

    def __init__(
        self, session: Session, visit: PageVisit, run: Run, give: Give, is_joint: bool = False
    ) -> None:
        self._session, self._give, self._visit, self._run_count = session, give, visit, 0
        self._forms = {
            question.name: AnalysisForm(task, question, self.refresh)
            for task, question in (analysis_jobs.JOINTS if is_joint else analysis_jobs.ANALYSES)
        }
        self._answers = {name: Answer(_ANALYSIS_HINT) for name in self._forms}
        names = list(self._forms)
        self._choice = pn.widgets.RadioBoxGroup(
            label="Question", options=names, value=names[0], **style.CONTROL
        )
        self._form = pn.Column(**style.BLOCK)
        self._working = JobButton(visit.workers, run, "Start", self._prepare, session)
        self._formulas = pn.pane.HTML("", visible=is_joint, **style.WIDE)
        self._answer = pn.Column(**style.HIGH)
        self._choice.param.watch(self._handle_selection, "value")
        self.root = pn.Row(
            pn.Column(
                self._choice, self._form, self._working.root, width=250, margin=(8, 16, 0, 0)
            ),
            pn.Column(self._formulas, self._answer, **style.HIGH),
            **style.HIGH,
        )
        self._handle_selection()

    def _handle_selection(self, _: Any = None) -> None:
        name = self._choice.value
        self._form[:] = [self._forms[name].root]
        self._answer[:] = [self._answers[name].root]
        self._working.root.visible = not self._forms[name].is_command
        self._working.show_refusal("")
        self.refresh()

    def _request(self, name: str) -> Request:
        form = self._forms[name]
        return self._session.state.request(form.task, **form.words)

    def _prepare(self) -> tuple[Any, ...]:
        name = self._choice.value
        self._working.task = self._forms[name].task
        request = self._request(name)
        written = self._with_files(request)
        self._answers[name].show_parts([])

        def show_outcome(result: analysis_jobs.AnalysisOutcome) -> None:
            key = request_key([request])
            self._answers[name].show_parts(self._make_views(result, request), key)
            self.refresh()

        over_pressure = form_of(self._session.state.specified) is NOMINAL
        return analysis_jobs.run_analysis, show_outcome, written, over_pressure

    def _with_files(self, request: Request) -> Request:
        """Return a request that also writes the files of a joint, to be downloaded."""
        if not request.task.shares_contacts:
            return request
        self._run_count += 1
        output = next(item for item in request.task.options if item.suffixes)
        paths = [
            str(self._visit.folder / f"{request.task.name}-{self._run_count}{suffix}")
            for suffix in output.suffixes
            if suffix != ".xlsx"  # Its library may be missing.
        ]
        specified = {**request.specified, output.name: paths}
        return replace(
            Request.from_text(request.task, request.file, specified), names=request.names
        )

    def refresh(self) -> None:
        """Gray an outdated result, or show the command of an analysis without a result."""
        name, outcome = self._choice.value, self._session.outcome
        contact = None if outcome is None else outcome.contact
        if self._formulas.visible:
            rows = [] if contact is None else quantities.rows_of(formulas.BY_FORMULA, contact)
            text = markup_table((row.title, row.text) for row in rows)
            self._formulas.object = f"<h2>Estimate by formula</h2>{text}" if rows else ""
        if self._forms[name].is_command:
            self._answers[name].show_parts([self._show_command(name)])
        else:
            self._answers[name].compare_key(request_key(map(self._request, [name])))

    def _show_command(self, name: str) -> str:
        try:
            return copy_markup("Command", self._request(name).command)
        except rc.RoughcontactError as error:
            words = controls.error_text(error, self._forms[name].task)
            return error_markup(self._session.state.with_user_names(words))

    def _make_views(self, result: analysis_jobs.AnalysisOutcome, request: Request) -> list[Any]:
        """Return the views of a result."""
        above = f"<h2>{escape_markup(result.lead)}</h2>{caution_list(result.cautions)}"
        if not result.outcome.converged:
            above = error_markup(spell_sentence(result.outcome.shortfall)) + above
        # A load search offers its loads.
        uses = [self._use(item.result) for item in getattr(result.result, "answers", ())]
        below = "".join(map(picture_markup, result.figures))
        if result.steps:
            below += markup_table(result.steps, result.heads)
        below += markup_table(result.facts)
        if result.outcome.written:
            below += "".join(f"<p>{escape_markup(sentence)}</p>" for sentence in result.sentences)
            links = (
                link_markup(self._visit.offer(path), path.name) for path in result.outcome.written
            )
            below += f"<p>Files: {', '.join(links)}</p>"
        return [above, *uses, below + copy_markup("Command", request.command)]

    def _use(self, contact: rc.ContactResult) -> Any:
        """Return a button that sets the load to a found load, in the form of the current load."""
        form = form_of(self._session.state.specified)
        text = load_text(contact, form, _DIGITS)
        if text is None:
            form = FORCE
            text = str(load_text(contact, form, _DIGITS))
        return make_button(f"Use {text} as the load", lambda: self._give(form.option, text))


def link_markup(address: str, name: str) -> str:
    """Return a link to download a file as markup."""
    return f'<a href="{escape_markup(address)}" download>{escape_markup(name)}</a>'


class AnalysisForm(OptionsForm):
    """Form with the options of an analysis."""

    def __init__(
        self,
        task: commands.Task,
        question: commands.Analysis,
        changed: Callable[[], None] = lambda: None,
    ) -> None:
        super().__init__(task, {option.name: value for option, value in question.initial}, changed)
        self.task, self._question = task, question
        self.is_command = question.is_command

    @cached_property
    def root(self) -> Any:
        """Controls of the options, created on first use."""
        question = self._question
        about = f'<p class="quiet">{escape_markup(question.about)}</p>'
        first, more = ([item.name for item in part] for part in (question.options, question.folded))
        parts = [pn.pane.HTML(about, **style.SHEET), *self.make_controls(first)]
        if more:
            parts.append(controls.make_fold("More", partial(self.make_controls, more)))
        return pn.Column(*parts, **style.BLOCK)

    @property
    def words(self) -> dict[str, Value]:
        """Option values of the form, as `SessionState.request` expects them."""
        fixed = {option.name: value for option, value in self._question.fixed}
        text = {**self.values, **fixed}
        return {f"{name.replace('-', '_')}_": value for name, value in text.items()}


_NAMES = ("A", "B")


class ComparePanel(TabPanel):
    """States A and B, their differences, and both contacts compared; one of them is current."""

    def __init__(
        self, session: Session, visit: PageVisit, run: Run, do: Callable[[Callable[[], None]], None]
    ) -> None:
        self._session = session
        self._pin = make_button("Keep this state as A", lambda: do(session.pin))
        self._swap = make_button("Go to A", lambda: do(session.swap_pinned))
        self._unpin = make_button("Remove A", lambda: do(session.unpin))
        self._differences = pn.pane.HTML("", **style.WIDE)
        self._working = JobButton(visit.workers, run, "Compare", self._prepare, session)
        self._answer = Answer(_COMPARISON_HINT)
        self.root = pn.Column(
            pn.Row(self._pin, self._swap, self._unpin, self._working.root, **style.BLOCK),
            self._differences,
            self._answer.root,
            **style.HIGH,
        )

    def refresh(self) -> None:
        """Show the options in which A and B differ, and which of them is current."""
        states, is_first = self._states(), self._session.state.is_first
        self._answer.compare_key(request_key(state.request() for state in states))
        self._swap.disabled = self._unpin.disabled = not states
        self._working.root.visible = bool(states)
        if not states:
            self._differences.object = (
                "<p>Keep this state as A, then change the load, a body or the map: that is B.</p>"
            )
            return
        current, other = _NAMES if is_first else _NAMES[::-1]
        self._swap.label, self._unpin.label = f"Go to {other}", f"Remove {other}"
        first, second = (state.specified for state in states)
        rows = [
            (SOLVE.by_name[name].label, _cell_text(first.get(name)), _cell_text(second.get(name)))
            for name in sorted({*first, *second})
            if first.get(name) != second.get(name)
        ]
        heads = ("what differs", *(f"{n}, shown" if n == current else n for n in _NAMES))
        same = "<p>A and B are the same so far.</p>"
        self._differences.object = markup_table(rows, heads) if rows else same

    def _states(self) -> tuple[SessionState, ...]:
        """Return A and B; nothing if no state is kept."""
        state = self._session.state
        if state.pinned is None:
            return ()
        states = replace(state, specified=state.pinned), state
        return states[::-1] if state.is_first else states

    def _prepare(self) -> tuple[Any, ...]:
        states = self._states()
        if not states:
            raise rc.InputError("there is no A: keep a state as A first")
        requests = [state.request() for state in states]
        self._answer.show_parts([])
        show = partial(self._show_comparison, key=request_key(requests))
        return analysis_jobs.compare_contacts, show, *requests, _NAMES

    def _show_comparison(self, result: analysis_jobs.ContactComparison, key: object) -> None:
        table = markup_table(result.rows, ("", *_NAMES, "A − B in percent of B"))
        cautions = "".join(
            f"<h2>Cautions of {name}</h2>{caution_list(text)}"
            for name, text in zip(_NAMES, result.cautions, strict=True)
        )
        self._answer.show_parts([table + picture_markup(result.figure) + cautions], key)


def _cell_text(value: str | bool | None) -> str:
    return "–" if value is None else "yes" if value is True else str(value)


_PAGE, _REPORT = "page with maps (.html)", "report (.html)"
_FILES = (_PAGE, _REPORT, "result (.nc)", "result (.csv)")
_STEM = "contact"


class DownloadPanel(TabPanel):
    """Files to create, and the contact as command, script and project file."""

    def __init__(self, session: Session, visit: PageVisit, run: Run) -> None:
        self._session, self._visit = session, visit
        self._downloads: list[str] = []
        self._kind = pn.widgets.Select(label="File", options=list(_FILES), **style.CONTROL)
        self._kind.param.watch(self._handle_selection, "value")
        self._working = JobButton(visit.workers, run, "Save page", self._prepare, session)
        self._links = pn.pane.HTML("", **style.WIDE)
        self._words = pn.pane.HTML("", **style.WIDE)
        head = pn.pane.HTML("<h1>Save the contact</h1>", **style.WIDE)
        left: dict[str, Any] = {"width": 300, "margin": (8, 16, 0, 0)}
        self.root = pn.Row(
            pn.Column(head, self._kind, self._working.root, self._links, **left),
            pn.Column(self._words, sizing_mode="stretch_both", margin=(8, 0)),
            sizing_mode="stretch_both",
        )

    def refresh(self) -> None:
        """Show the command, the script and the project file that reproduce the contact."""
        state, outcome = self._session.state, self._session.outcome
        texts = {"Project file, for roughcontact run": state.portable_script}
        if outcome is not None and outcome.contact is not None:
            texts = {"Python": python_script.script_of_result(outcome.contact), **texts}
        if not state.missing:
            with contextlib.suppress(rc.RoughcontactError):
                texts = {"Command": self._session.request.command, **texts}
        parts = (copy_markup(*item) for item in texts.items())
        self._words.object = "<h1>Repeat it without the page</h1>" + "".join(parts)

    def _handle_selection(self, event: Any) -> None:
        self._working.name(f"Save {event.new.partition(' ')[0]}")

    def _prepare(self) -> tuple[Any, ...]:
        kind = self._kind.value
        suffix = kind[kind.index("(") + 1 : -1]
        # A number in the name: later downloads do not change an offered file.
        path = self._visit.folder / f"{_STEM}-{len(self._downloads) + 1}{suffix}"
        if kind == _PAGE:
            return save_page, self._show_outcome, self._session.request, path
        name = "report" if kind == _REPORT else "output"
        request = self._session.state.request(**{name: str(path)})
        return workers.run_request, self._show_outcome, request

    def _show_outcome(self, outcome: Outcome) -> None:
        if outcome.failure is not None:
            self._working.refuse_error(outcome.failure)
        elif not outcome.converged:
            self._working.show_refusal(spell_sentence(outcome.shortfall))
        for path in outcome.written:
            text = f"{path.name} ({path.stat().st_size / 1e6:.1f} MB)"
            self._downloads.append(f"<p>{link_markup(self._visit.offer(path), text)}</p>")
        if self._downloads:
            self._links.object = f"<h2>Ready</h2>{''.join(self._downloads)}"
