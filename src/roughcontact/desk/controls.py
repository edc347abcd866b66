"""Controls of the page: one for each option, made from its entry in the task."""

from __future__ import annotations

import base64
import html
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any

import panel as pn

import roughcontact as rc
from roughcontact import cautions as caution_types, errors
from roughcontact.desk import style, workers
from roughcontact.desk.session import LOADS, PAGE, SOLVE, Session, Value
from roughcontact.report import phrases
from roughcontact.request import options, task as commands

GROUPS: dict[str, list[str]] = {
    **PAGE["groups"],
    "preparation": [option.name for option in (*options.PREPARATION, options.TIP_RADIUS)],
}
"""Names of options by group."""
SHOWN_OPTIONS = {*LOADS, *(name for group in GROUPS.values() for name in group)}
"""Options of the contact that have a control on the page."""

_MAPS = {"file": "the map", "counter_surface": "map of the counter-body"}


def spell_for_page(mention: errors.ArgumentRef, task: commands.Command = SOLVE) -> str:
    """Return an argument in the terms of the page, or of the command if the page has it not."""
    if mention.name in _MAPS:
        return _MAPS[mention.name]
    questions = (*getattr(task, "questions", ()), *SOLVE.questions)
    shown = {option for item in questions for option in (*item.options, *item.folded)}
    option = task.option_of_argument(mention.name)
    if option is not None and (option.name in SHOWN_OPTIONS or option in shown):
        # Tasks may label an option of the contact otherwise.
        option = SOLVE.by_name[option.name] if option.name in SHOWN_OPTIONS else option
        if mention.value is None or mention.value is True:
            return f"“{option.label}”"
        return f"“{option.label}” {option.text(mention.value)}"
    text = task.spell_argument(mention)
    for question in questions:
        for option, value in question.fixed:
            if text.endswith(f"--{option.name}" + ("" if option.is_flag else f" {value}")):
                return f"“{question.name}”"
    return text


def error_text(error: rc.RoughcontactError, task: commands.Command = SOLVE) -> str:
    """Return the message of an error for the page."""
    return error.message_for(partial(spell_for_page, task=task))


def spell_sentence(text: str, task: commands.Command = SOLVE) -> str:
    """Return a sentence of the library in the terms of the page."""
    return errors.render_message(errors.message_parts(text), partial(spell_for_page, task=task))


def escape_markup(text: str) -> str:
    """Return text with markup escaped."""
    return html.escape(text)


def error_markup(text: str, role: str = ' role="alert"') -> str:
    """Return an error as markup that screen readers announce."""
    return f'<span{role} class="wrong">{escape_markup(text)}</span>'


def note_markup(text: str) -> str:
    """Return a note as markup that screen readers announce."""
    return f'<span class="quiet" role="status">{escape_markup(text)}</span>'


def show_alert(pane: Any, text: str) -> None:
    """Show an error in a pane, or hide the pane if the text is empty."""
    pane.object, pane.visible = error_markup(text), bool(text)


def mark_field(widget: Any, text: str) -> None:
    """Mark a field as invalid, or remove the mark if its error is empty."""
    widget.css_classes = ["invalid"] if text else []


def copy_markup(title: str, text: str) -> str:
    """Return text to copy, with its title, as markup."""
    copy = (
        "navigator.clipboard?.writeText(this.closest('section').lastChild.textContent)"
        ".then(() => { this.textContent = 'Copied' })"
    )
    return (
        f'<section><h2>{escape_markup(title)} <button onclick="{copy}">Copy</button></h2>'
        f"<pre>{escape_markup(text)}</pre></section>"
    )


def picture_markup(png: bytes) -> str:
    """Return a figure (PNG) as markup; its numbers are in the tables next to it."""
    data = base64.b64encode(png).decode("ascii")
    return f'<img class="figure" alt="figure of the report" src="data:image/png;base64,{data}">'


Give = Callable[[str, Value], None]
"""``give(name, value)`` sets an option, or raises the error of an invalid value."""


_SUGGESTED: dict[str, tuple[str, ...]] = {"ceiling": ("auto", "calibrated", "none"), "channel": ()}
"""Suggested texts of options that accept any text."""


class Control:
    """Labelled control of an option, with the error of its value below."""

    def __init__(
        self,
        name: str,
        give: Give,
        choices: Mapping[str, str] | None = None,
        task: commands.Command = SOLVE,
    ) -> None:
        self.name, self._give, self._task = name, give, task
        option = task.by_name[name]
        # Without a default, or with an empty choice for it, the control starts empty.
        requested = option.default is None or "" in (choices or {})
        plain = isinstance(option.default, (str, int, float))
        self._default = option.text(option.default) if plain and not requested else ""
        self.widget = _widget(option, choices)
        self._silent = False
        self.widget.param.watch(self._handle_change, "value")
        # The box for a flag has no button for help.
        texts = [note_markup(option.help)] if option.is_flag else []
        self._parts = [self.widget, *(pn.pane.HTML(text, **style.SHEET) for text in texts)]
        self.root = pn.Column(*self._parts, **style.BLOCK)

    def show_options(self, specified: Mapping[str, Value]) -> None:
        """Show the value of the option, or its default."""
        value: Any = str(specified.get(self.name, self._default))
        if self._task.by_name[self.name].is_flag:
            value = self.widget.options if specified.get(self.name) else []
        self._silent = True
        try:
            choices = getattr(self.widget, "options", None)
            if isinstance(choices, dict) and value not in choices.values():
                self.widget.options = {**choices, str(value): value}
            if self.widget.value != value:
                self.widget.value = value
        finally:
            self._silent = False
        self.show_error("")

    def suggest(self, texts: Sequence[str]) -> None:
        """Set the texts suggested during typing; other texts are accepted as well."""
        if list(self.widget.options) != list(texts):
            self.widget.options = list(texts)

    def offer(self, choices: Mapping[str, str]) -> None:
        """Set the choices, labels by value; the selected value is kept."""
        specified = self.widget.value
        kept = {label: value for label, value in self.widget.options.items() if value == specified}
        self._silent = True
        try:
            self.widget.options = {**kept, **_by_label(choices)}
            self.widget.value = specified
        finally:
            self._silent = False

    def show_error(self, text: str) -> None:
        """Show an error below the control, or remove it if the text is empty."""
        mark_field(self.widget, text)
        below = [pn.pane.HTML(error_markup(text), **style.SHEET)] if text else []
        if below or len(self.root) > len(self._parts):
            self.root[:] = [*self._parts, *below]

    def _handle_change(self, event: Any) -> None:
        if self._silent:
            return
        try:
            self._give(self.name, bool(event.new) if isinstance(event.new, list) else event.new)
        except rc.RoughcontactError as error:
            self.show_error(error_text(error, self._task))
        else:
            self.show_error("")


class OptionsForm:
    """Values of the options of a command, with controls; ``changed`` is called after a change."""

    def __init__(
        self,
        task: commands.Command,
        initial: Mapping[str, Value],
        changed: Callable[[], None] = lambda: None,
    ) -> None:
        self.command, self.values, self._handle_change = task, dict(initial), changed

    def make_controls(self, names: Iterable[str]) -> list[Any]:
        """Return controls of options, with their values."""
        created = [Control(name, self.set_option, task=self.command) for name in names]
        for control in created:
            control.show_options(self.values)
        return [control.root for control in created]

    def set_option(self, name: str, value: Value) -> None:
        """Set an option; an empty value removes it."""
        value = value.strip() if isinstance(value, str) else value
        if value in ("", False):
            self.values.pop(name, None)
        else:
            self.command.parse_options({name: value})
            self.values[name] = value
        self._handle_change()


def _widget(option: options.Option[Any], choices: Mapping[str, str] | None) -> Any:
    about: dict[str, Any] = {"label": option.label, "description": option.help, **style.CONTROL}
    if option.is_flag:
        # A single checkbox of Bokeh has no name for screen readers.
        return pn.widgets.CheckBoxGroup(options=[option.label], **style.CONTROL)
    if choices is not None:
        return pn.widgets.Select(options=_by_label(choices), **about)
    if known := option.parse.known:
        default = [] if option.default is not None else [""]
        return pn.widgets.Select(options=[*default, *map(str, known)], **about)
    if option.name in _SUGGESTED:
        return pn.widgets.AutocompleteInput(
            placeholder=option.metavar.lower(),
            options=list(_SUGGESTED[option.name]),
            restrict=False,
            min_characters=0,
            **about,
        )
    return pn.widgets.TextInput(placeholder=option.metavar.lower(), **about)


def _by_label(choices: Mapping[str, str]) -> dict[str, str]:
    return {label: value for value, label in choices.items()}


def make_button(text: str, done: Callable[[], None], primary: bool = False, **more: Any) -> Any:
    """Return a button that calls a function when clicked."""
    created = pn.widgets.Button(
        label=text, color="primary" if primary else "default", **{**style.BUTTON, **more}
    )
    created.on_click(lambda _: done())
    return created


def make_fold(title: str, make: Callable[[], list[Any]]) -> Any:
    """Return a collapsed card of rarely used controls, created when it is first opened."""
    heading = pn.pane.HTML(
        f'<span class="fold">{escape_markup(title)}</span>', margin=0, **style.SHEETS
    )
    folded = pn.Card(
        header=heading,
        collapsed=True,
        sizing_mode="stretch_width",
        margin=(0, 0, 2, 0),
        stylesheets=[style.TEXT, style.CSS["FOLD"]],
        header_background="transparent",
        active_header_background="transparent",
    )

    def fill_fold(event: Any) -> None:
        if not event.new and not folded.objects:
            folded.objects = make()

    folded.param.watch(fill_fold, "collapsed")
    return folded


def caution_list(text: Iterable[caution_types.Caution]) -> str:
    """Return cautions as the markup of a list, the most severe first."""
    items = "".join(
        f'<li><b class="{item.severity}">{item.severity}</b> '
        f"{escape_markup(spell_sentence(item.text))}</li>"
        for item in gravest_first(text)
    )
    return f'<ul class="cautions">{items}</ul>' if items else '<p class="quiet">No cautions.</p>'


def gravest_first(text: Iterable[caution_types.Caution]) -> list[caution_types.Caution]:
    """Return cautions by severity, without non-convergence, which the status shows."""
    known = [item for item in text if item.kind != caution_types.CautionTag.NOT_CONVERGED]
    return sorted(known, key=lambda item: list(caution_types.Severity).index(item.severity))


def markup_table(rows: Iterable[Iterable[str]], heads: Iterable[str] = ()) -> str:
    """Return rows of text as the markup of a table."""
    head = "".join(f"<th>{escape_markup(cell)}</th>" for cell in heads)
    body = "".join(
        "<tr>" + "".join(f"<td>{escape_markup(cell)}</td>" for cell in row) + "</tr>"
        for row in rows
    )
    return f"<table>{f'<tr>{head}</tr>' if head else ''}{body}</table>"


def _progress_markup(text: str, share: float | None) -> str:
    """Return a progress bar, of unknown extent without a share, above a text."""
    value = "" if share is None else f' value="{share:.3f}"'
    return f'<progress aria-label="progress"{value}></progress><p>{note_markup(text)}</p>'


Run = Callable[[Callable[[], None]], None]
"""``run(done)`` calls ``done`` in the thread that may change the page."""


class JobButton:
    """Button that starts a job, with its progress and a cancel button.

    ``prepare()`` returns the function of the job, a function that receives its result, and its
    arguments, first the request; `task` has the terms of an error that it raises.
    """

    def __init__(
        self,
        bench: workers.WorkerPool,
        run: Run,
        name: str,
        prepare: Callable[[], tuple[Any, ...]],
        session: Session,
    ) -> None:
        self._bench, self._run, self._session = bench, run, session
        self._prepare = prepare
        self._job: workers.Job | None = None
        self.task: commands.Task = SOLVE
        self._take: Callable[[Any], None] = lambda _: None
        self._start = make_button(name, self.start, primary=True)
        self._cancel = make_button("Cancel", self.cancel, disabled=True)
        self._status = pn.pane.HTML("", **style.WIDE)
        self.root = pn.Column(pn.Row(self._start, self._cancel), self._status, **style.BLOCK)

    def start(self) -> None:
        """Start the job, or show why it cannot start."""
        try:
            work, self._take, request, *more = self._prepare()
        except rc.RoughcontactError as error:
            self.refuse_error(error)
            return
        self._start.disabled, self._cancel.disabled = True, False
        self._status.object = _progress_markup("starting …", None)
        self._job = self._bench.submit(
            work,
            request,
            *more,
            on_stage=lambda stage: self._run(lambda: self._show_stage(stage)),
            ended=lambda end: self._run(lambda: self._close(end)),
            folders=workers.output_folders(request),
        )

    def name(self, text: str) -> None:
        """Set the text of the button."""
        self._start.label = text

    def cancel(self) -> None:
        """Cancel the running job."""
        if self._job is not None:
            self._job.cancel()

    def show_refusal(self, text: str) -> None:
        """Show the reason why there is no result, nothing if it is empty."""
        self._status.object = error_markup(text) if text else ""

    def refuse_error(self, error: rc.RoughcontactError) -> None:
        """Show the error of a job in the terms of the page."""
        self.show_refusal(self._session.state.with_user_names(error_text(error, self.task)))

    def _show_stage(self, stage: workers.JobStage) -> None:
        text = stage.progress
        if not isinstance(text, str):
            text = phrases.progress_text(text)
        remaining = "" if stage.remaining is None else f"; about {stage.remaining:.0f} s left"
        text = self._session.state.with_user_names(text)
        text = f"{text}; {stage.seconds:.0f} s so far{remaining}"
        self._status.object = _progress_markup(text, stage.share)

    def _close(self, end: workers.JobResult) -> None:
        self._job = None
        self._start.disabled, self._cancel.disabled = False, True
        if end.canceled:
            self._status.object = note_markup("Canceled; nothing is saved.")
        elif end.error is not None:
            self.refuse_error(end.error)
        else:
            self._status.object = note_markup(f"Done in {end.seconds:.1f} s.")
            self._take(end.value)
