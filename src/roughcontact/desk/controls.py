"""Controls: one for each option, made from its row in the table of options."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import panel as pn

from roughcontact.desk import style, words
from roughcontact.desk.reach import Check, Field
from roughcontact.desk.state import Value
from roughcontact.errors import RoughcontactError
from roughcontact.request import parsing
from roughcontact.request.option import Option
from roughcontact.request.solve import TASK as SOLVE
from roughcontact.request.task import Command

Give = Callable[[str, Value], None]
"""``give(name, value)`` sets an option, or raises what is wrong with it."""


_SUGGESTED: dict[str, tuple[str, ...]] = {
    "ceiling": ("auto", "recommended", "none"),
    "channel": (),
    "form": ("sphere", "cylinder", "polynomial 2", "polynomial 4"),
}
"""What is proposed where any text can be given."""


class Control:
    """A labelled control of one option, with what is wrong with its text below it.

    Parameters
    ----------
    name : str
        Of the option.
    give : callable
        What sets it.
    choices : Mapping, optional
        Texts by what they are called, in place of those of the option.
    task : Command
        Whose option it is.
    """

    def __init__(
        self, name: str, give: Give, choices: Mapping[str, str] | None = None, task: Command = SOLVE
    ) -> None:
        self.name, self._give, self._task = name, give, task
        option = task.by_name[name]
        # Where nothing is a choice of its own, the default is no answer.
        asked = option.default is None or "" in (choices or {}).values()
        plain = isinstance(option.default, (str, int, float))
        self._default = option.text(option.default) if plain and not asked else ""
        self.widget = _widget(option, choices)
        self._silent = False
        self.widget.param.watch(self._changed, "value")
        self.root = pn.Column(self.widget, **style.BLOCK)

    def show(self, given: Mapping[str, Value]) -> None:
        """Show what is given; the default where nothing is."""
        if isinstance(self.widget, Check):
            value: Value = bool(given.get(self.name, False))
        else:
            value = str(given.get(self.name, self._default))
        self._silent = True
        try:
            if self.widget.value != value:
                self.widget.value = value
        finally:
            self._silent = False
        self.complain("")

    def suggest(self, texts: Sequence[str]) -> None:
        """Propose texts while one types; others are taken as well."""
        if list(self.widget.options) != list(texts):
            self.widget.options = list(texts)

    def offer(self, choices: Mapping[str, str]) -> None:
        """Let one choose among other texts, by what they are called; what is given stays."""
        given = self.widget.value
        kept = {told: text for told, text in self.widget.options.items() if text == given}
        self._silent = True
        try:
            self.widget.options = {**kept, **choices}
            self.widget.value = given
        finally:
            self._silent = False

    def complain(self, text: str) -> None:
        """Show what is wrong, nothing for an empty text."""
        if not text:
            if len(self.root) > 1:
                self.root[:] = [self.widget]
            return
        said = f'<span role="alert" class="wrong">{words.escaped(text)}</span>'
        self.root[:] = [self.widget, pn.pane.HTML(said, **style.SHEET)]

    def _changed(self, event: Any) -> None:
        if self._silent:
            return
        try:
            self._give(self.name, event.new)
        except RoughcontactError as error:
            self.complain(words.told(error, self._task))
        else:
            self.complain("")


def _widget(option: Option[Any], choices: Mapping[str, str] | None) -> Any:
    about: dict[str, Any] = {
        "label": option.label,
        "description": option.help,
        **style.CONTROL,
    }
    if option.is_flag:
        return Check(words=option.label, **style.BLOCK)
    if choices is not None:
        return pn.widgets.Select(options=dict(choices), **about)
    if isinstance(option.parse, parsing.Choice):
        known = option.parse.known
        default = [] if option.default is not None else [""]
        return pn.widgets.Select(options=[*default, *map(str, known)], **about)
    if option.name in _SUGGESTED:
        return Field(
            words=option.label, help=option.help, placeholder=option.metavar.lower(),
            options=list(_SUGGESTED[option.name]), **style.BLOCK,
        )  # fmt: skip
    return pn.widgets.TextInput(placeholder=option.metavar.lower(), **about)


def button(text: str, done: Callable[[], None], primary: bool = False, **more: Any) -> Any:
    """Return a button that does something."""
    made = pn.widgets.Button(
        label=text, color="primary" if primary else "default", **{**style.BUTTON, **more}
    )
    made.on_click(lambda _: done())
    return made
