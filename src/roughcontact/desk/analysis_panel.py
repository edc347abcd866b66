"""Panels of analyses: single, joint on one contact, and comparison of two states."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import panel as pn

from roughcontact.analyses.estimate import fields as formulas
from roughcontact.analyses.find.model import LoadSearch
from roughcontact.analyses.solve.task import TASK as SOLVE
from roughcontact.analyses.stress.model import StressResult
from roughcontact.analyses.sweep.model import LoadCurve
from roughcontact.desk import analysis_jobs, controls, style, workers
from roughcontact.desk.controls import (
    Control,
    Give,
    JobButton,
    Run,
    escape_markup,
    make_button,
    spell_sentence,
)
from roughcontact.desk.download_panel import Offer
from roughcontact.desk.figures import Drawing, show_drawing
from roughcontact.desk.result_plots import ComparisonView, LoadCurveView, ResolutionView, StressView
from roughcontact.desk.session import Session, Value
from roughcontact.desk.widgets import Check, TabPanel
from roughcontact.errors import RoughcontactError
from roughcontact.report.kind import rows_of
from roughcontact.request.contacts import RANGE
from roughcontact.request.request import Request
from roughcontact.request.task import Analysis, Task
from roughcontact.uncertainty.resolution import ResolutionStudy
from roughcontact.units import format_engineering

# Significant digits of a found load.
_DIGITS = 7


class AnalysisPanel(TabPanel):
    """Selector of analyses, options of the selected one, and its result."""

    def __init__(self, session: Session, bench: workers.WorkerPool, run: Run, give: Give) -> None:
        self._session, self._give = session, give
        names = [question.name for _, question in analysis_jobs.ANALYSES]
        self._forms: dict[str, OptionsForm] = {}
        self._choice = pn.widgets.RadioBoxGroup(
            label="Question", options=names, value=names[0], **style.CONTROL
        )
        self._form = pn.Column(self._form_of(names[0]).root, **style.BLOCK)
        self._working = JobButton(bench, run, "Start", self._started, session)
        self._answer = pn.Column(**style.HIGH)
        self._curve: LoadCurveView | None = None
        self._choice.param.watch(self._handle_selection, "value")
        self.root = pn.Row(
            pn.Column(
                self._choice, self._form, self._working.root, width=250, margin=(8, 16, 0, 0)
            ),
            self._answer,
            **style.HIGH,
        )

    def _handle_selection(self, event: Any) -> None:
        self._form[:] = [self._form_of(event.new).root]

    def _form_of(self, name: str) -> OptionsForm:
        if name not in self._forms:
            result = next(item for item in analysis_jobs.ANALYSES if item[1].name == name)
            self._forms[name] = OptionsForm(*result)
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
        self._working.start_job(analysis_jobs.run_analysis, self._show_outcome, request)

    def _show_outcome(self, result: analysis_jobs.AnalysisOutcome) -> None:
        if not result.outcome.converged:
            self._working.show_refusal(spell_sentence(result.outcome.shortfall))
        self._curve = None
        self._answer[:] = self._make_views(result)

    def refresh(self) -> None:
        """Mark the current load in the load curve, if one is shown."""
        outcome = self._session.outcome
        if self._curve is not None and outcome is not None and outcome.contact is not None:
            self._curve.mark(outcome.contact.load)

    def _make_views(self, result: analysis_jobs.AnalysisOutcome) -> list[Any]:
        """Return the views of a result."""
        lead = pn.pane.HTML(f"<h2>{escape_markup(result.lead)}</h2>", **style.WIDE)
        cautions = pn.pane.HTML(controls.caution_list(result.cautions), **style.WIDE)
        facts = pn.pane.HTML(controls.markup_table(result.facts), **style.WIDE)
        view = _result_view(result.result)
        if view is not None:
            if isinstance(view, LoadCurveView):
                self._curve = view
                self.refresh()
            seen = [lead, cautions, pn.pane.Bokeh(view.root, **style.BLOCK)]
            # The other views show these quantities themselves.
            return [*seen, facts] if isinstance(view, LoadCurveView) else seen
        loads = result.result.answers if isinstance(result.result, LoadSearch) else ()
        uses = [self._use(item.load) for item in loads]
        parts: list[Any] = [lead, *uses, cautions, *map(figure_view, result.drawings), facts]
        if result.steps:
            parts.append(
                pn.pane.HTML(controls.markup_table(result.steps, result.heads), **style.WIDE)
            )
        return parts

    def _use(self, load: float) -> Any:
        """Return a button that sets the load of the contact to a found load."""
        text = format_engineering(load, "N", _DIGITS)
        return make_button(f"Use {text} as the load", lambda: self._give("load", text))


class OptionsForm:
    """Form with the options of an analysis."""

    def __init__(self, task: Task, question: Analysis) -> None:
        self.task, self._question = task, question
        self._values: dict[str, Value] = {
            option.name: value for option, value in question.short_help
        }
        controls = [
            Control(option.name, self._set_option, task=task) for option in question.options
        ]
        for control in controls:
            control.show_options(self._values)
        about = pn.pane.HTML(f'<p class="quiet">{escape_markup(question.about)}</p>', **style.SHEET)
        self.root = pn.Column(about, *(control.root for control in controls), **style.BLOCK)

    @property
    def words(self) -> dict[str, Value]:
        """Option values of the form, as `SessionState.request` expects them."""
        fixed = {option.name: value for option, value in self._question.fixed}
        text = {**self._values, **fixed}
        return {f"{name.replace('-', '_')}_": value for name, value in text.items()}

    def _set_option(self, name: str, value: Value) -> None:
        if isinstance(value, str) and not self.task.by_name[name].is_flag:
            value = value.strip()
        if value in ("", False):
            self._values.pop(name, None)
            return
        self.task.parse_options({name: value})
        self._values[name] = value


def _result_view(result: Any) -> LoadCurveView | ResolutionView | StressView | None:
    """Return the interactive view of a result; None if its class has none."""
    views: dict[type, Callable[[], Any]] = {
        LoadCurve: LoadCurveView,
        ResolutionStudy: ResolutionView,
        StressResult: StressView,
    }
    for kind, view in views.items():
        if isinstance(result, kind):
            created = view()
            created.show_result(result)
            return cast("LoadCurveView | ResolutionView | StressView", created)
    return None


def figure_view(drawing: Drawing) -> Any:
    """Return the view of a figure."""
    return pn.pane.Bokeh(show_drawing(drawing), **style.BLOCK)


# --- Joint analyses of one contact: solved once, several results ---


_NO_ESTIMATE_HTML = '<p class="quiet">No estimate: the formulas apply to flat contact only.</p>'

_TASK, _ = analysis_jobs.JOINTS[0]
_RANGE = dict(zip((option.name for option in RANGE), ("1 MPa", "100 MPa", "5"), strict=True))
"""Default nominal pressures, common to all joint analyses."""


class JointPanel(TabPanel):
    """Checkboxes of the joint analyses, their common pressures, and their results."""

    def __init__(
        self, session: Session, bench: workers.WorkerPool, run: Run, folder: Path, offer: Offer
    ) -> None:
        self._session, self._folder, self._offer = session, folder, offer
        self._run_count = 0
        self._range: dict[str, Value] = dict(_RANGE)
        pressures = [Control(name, self._set_range_option, task=_TASK) for name in _RANGE]
        for control in pressures:
            control.show_options(self._range)
        self._boxes = {
            question.name: Check(words=question.name, value=True, **style.BLOCK)
            for _, question in analysis_jobs.JOINTS
        }
        self._forms = {
            question.name: OptionsForm(task, question) for task, question in analysis_jobs.JOINTS
        }
        self._working = JobButton(bench, run, "Start", self._started, session)
        self._formulas = pn.pane.HTML("", **style.WIDE)
        self._answers = pn.Column(**style.HIGH)
        about = pn.pane.HTML(
            '<p class="quiet">Range of nominal pressures, each solved once for all selected '
            "analyses.</p>",
            **style.SHEET,
        )
        parts = [
            part for name in self._boxes for part in (self._boxes[name], self._forms[name].root)
        ]
        self.root = pn.Row(
            pn.Column(
                about,
                *(control.root for control in pressures),
                self._working.root,
                *parts,
                width=250,
                margin=(8, 16, 0, 0),
            ),
            pn.Column(self._formulas, self._answers, **style.HIGH),
            **style.HIGH,
        )

    def refresh(self) -> None:
        """Show the estimate of the current contact; the requested analyses stay unchanged."""
        outcome = self._session.outcome
        result = None if outcome is None else outcome.contact
        text = [] if result is None else rows_of(formulas.BESIDE, result)
        rows = [(row.title, row.text) for row in text]
        self._formulas.object = controls.markup_table(rows) if rows else _NO_ESTIMATE_HTML

    def _set_range_option(self, name: str, value: Value) -> None:
        text = value.strip() if isinstance(value, str) else value
        if text:
            _TASK.parse_options({name: text})
        self._range[name] = text

    def _started(self) -> None:
        wanted = [item for item in analysis_jobs.JOINTS if self._boxes[item[1].name].value]
        if not wanted:
            self._working.show_refusal("Select at least one analysis.")
            return
        self._run_count += 1
        requests = []
        for task, question in wanted:
            try:
                text = {f"{name}_": value for name, value in self._range.items()}
                text |= self._forms[question.name].words
                request = self._session.state.request(task, **text)
                requests.append(self._with_files(request))
            except RoughcontactError as error:
                self._working.refuse_error(error, task)
                return
        self._answers[:] = []
        self._working.start_job(analysis_jobs.run_analyses, self._show_outcomes, *requests)

    def _with_files(self, request: Request) -> Request:
        """Return a request that also writes the downloadable files."""
        output = next(item for item in request.task.options if item.suffixes)
        paths = [
            str(self._folder / f"{request.task.name}-{self._run_count}{suffix}")
            for suffix in (output.suffixes if output.many else output.suffixes[:1])
        ]
        specified = {**request.specified, output.name: paths if output.many else paths[0]}
        return replace(
            Request.from_text(request.task, request.file, specified), names=request.names
        )

    def _show_outcomes(self, result: tuple[analysis_jobs.AnalysisOutcome, ...]) -> None:
        self._answers[:] = [part for item in result for part in self._make_views(item)]

    def _make_views(self, result: analysis_jobs.AnalysisOutcome) -> list[Any]:
        """Return the views of a result: title, cautions, figures, quantities, files, command."""
        request = result.outcome.request
        name = next(
            question.name for task, question in analysis_jobs.JOINTS if task is request.task
        )
        text = "".join(
            f"<p>{controls.escape_markup(sentence)}</p>" for sentence in result.sentences
        )
        links = ", ".join(
            f'<a href="{controls.escape_markup(self._offer(path))}" download>'
            f"{controls.escape_markup(path.name)}</a>"
            for path in result.outcome.written
        )
        own = {
            key: value
            for key, value in request.specified.items()
            if not request.task.by_name[key].suffixes
        }
        command = replace(request, specified=own).command
        return [
            pn.pane.HTML(f"<h2>{controls.escape_markup(name)}</h2>", **style.WIDE),
            pn.pane.HTML(controls.caution_list(result.cautions), **style.WIDE),
            *map(figure_view, result.drawings),
            pn.pane.HTML(controls.markup_table(result.steps, result.heads), **style.WIDE),
            pn.pane.HTML(controls.markup_table(result.facts) + text, **style.WIDE),
            pn.pane.HTML(f"<p>Files: {links}</p>", **style.WIDE),
            pn.pane.HTML(f"<pre>{controls.escape_markup(command)}</pre>", **style.WIDE),
        ]


# --- Comparison of two states: one is pinned, the other is current ---


_NAMES = ("this state", "pinned state")


class ComparePanel(TabPanel):
    """Pinned state, its differences from the current state, and both contacts compared."""

    def __init__(
        self,
        session: Session,
        bench: workers.WorkerPool,
        run: Run,
        do: Callable[[Callable[[], None]], None],
    ) -> None:
        self._session = session
        self._pin = make_button("Pin this state", lambda: do(session.pin))
        self._swap = make_button("Go to the pinned state", lambda: do(session.swap_pinned))
        self._unpin = make_button("Unpin", lambda: do(session.unpin))
        self._differences = pn.pane.HTML("", **style.WIDE)
        self._working = JobButton(bench, run, "Compare", self._started, session)
        self._answer = pn.Column(**style.HIGH)
        self.root = pn.Column(
            pn.Row(self._pin, self._swap, self._unpin, self._working.root, **style.BLOCK),
            self._differences,
            self._answer,
            **style.HIGH,
        )

    def refresh(self) -> None:
        """Show the options in which the current and the pinned state differ."""
        state = self._session.state
        pinned = state.pinned
        self._swap.disabled = self._unpin.disabled = pinned is None
        if pinned is None:
            text = "<p>Pin a state, then change the load, a body or the map: both are compared.</p>"
        else:
            names = sorted(
                name
                for name in {*state.specified, *pinned}
                if state.specified.get(name) != pinned.get(name)
            )
            rows = [
                (
                    SOLVE.by_name[name].label,
                    _cell_text(state.specified.get(name)),
                    _cell_text(pinned.get(name)),
                )
                for name in names
            ]
            same = "<p>Both are the same so far.</p>"
            text = controls.markup_table(rows, ("what differs", "this", "pinned")) if rows else same
        self._differences.object = text

    def _started(self) -> None:
        state = self._session.state
        if state.pinned is None:
            self._working.show_refusal("Pin a state first.")
            return
        try:
            requests = state.request(), replace(state, specified=state.pinned).request()
        except RoughcontactError as error:
            self._working.refuse_error(error)
            return
        self._answer[:] = []
        self._working.start_job(
            analysis_jobs.compare_contacts, self._show_comparison, *requests, _NAMES
        )

    def _show_comparison(self, result: analysis_jobs.ContactComparison) -> None:
        cautions = "".join(
            f"<h2>{name}</h2>{controls.caution_list(text)}"
            for name, text in zip(_NAMES, result.cautions, strict=True)
        )
        maps = ComparisonView(_NAMES)
        maps.show_contacts(result.contacts)
        parts: list[Any] = [
            pn.pane.Bokeh(maps.root, **style.BLOCK),
            pn.pane.HTML(
                controls.markup_table(result.rows, ("", *_NAMES, "difference", "in percent")),
                **style.WIDE,
            ),
            pn.pane.HTML(cautions, **style.WIDE),
        ]
        self._answer[:] = parts


def _cell_text(value: str | bool | None) -> str:
    return "–" if value is None else "yes" if value is True else str(value)
