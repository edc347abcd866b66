"""The load: its form, its text, and the slider that the contact follows."""

from __future__ import annotations

from typing import Any

import panel as pn

from roughcontact.desk import scale, style, words
from roughcontact.desk.controls import Give
from roughcontact.desk.live import Prepared
from roughcontact.desk.reach import Slider
from roughcontact.desk.session import Session
from roughcontact.errors import RoughcontactError
from roughcontact.request.options import APPROACH


class Load:
    """The load in its forms, and its slider."""

    def __init__(self, session: Session, give: Give) -> None:
        self._session, self._give = session, give
        self._prepared: Prepared | None = None
        self._form = scale.NOMINAL
        self._silent = False
        self.form = pn.widgets.Select(
            label="Load given as", options={form.name: form for form in scale.FORMS},
            value=self._form,
            **{**style.CONTROL, "sizing_mode": None, "margin": (0, 8, 4, 0)}, width=150,
        )  # fmt: skip
        self.text = pn.widgets.TextInput(
            label="Value with unit", **{**style.CONTROL, "sizing_mode": None}, width=120
        )
        self.slider = Slider(
            words="Drag the load (logarithmic); arrow keys move it, too", end=scale.STEPS,
            value=scale.STEPS // 2, sizing_mode="stretch_width", margin=(0, 20, 4, 14),
        )  # fmt: skip
        self._wrong = pn.pane.HTML("", visible=False, **style.SHEET)
        self.form.param.watch(self._reform, "value")
        self.text.param.watch(self._typed, "value")
        self.slider.param.watch(self._slid, "value")
        self.root = pn.Column(
            pn.Row(self.form, self.text, self.slider, **style.BLOCK), self._wrong, **style.BLOCK
        )

    def show(self, prepared: Prepared | None) -> None:
        """Show what the state holds."""
        self._prepared = prepared
        given = self._session.state.given
        self._form = scale.form_of(given)
        text = str(given.get(self._form.option, ""))
        self._silent = True
        try:
            if self.form.value is not self._form:
                self.form.value = self._form
            if self.text.value != text:
                self.text.value = text
            self.text.placeholder = self._form.example
            self.slider.said = text
            ends = self._ends()
            value = self._value()
            if ends is not None and value is not None:
                position = scale.position_of(value, ends)
                if scale.text_at(self.slider.value, ends, self._form) != text:
                    self.slider.value = position
        finally:
            self._silent = False

    def _ends(self) -> tuple[float, float] | None:
        return None if self._prepared is None else scale.span(self._form, self._prepared)

    def _value(self) -> float | None:
        """Return the load as it is given [SI]."""
        try:
            value, _ = self._session.state.request().load
            found = self._session.state.request().needed(APPROACH) if value is None else value
        except RoughcontactError:
            return None
        return found if isinstance(found, float) else found.value

    def _reform(self, event: Any) -> None:
        if self._silent:
            return
        outcome, form = self._session.outcome, event.new
        text = None
        if outcome is not None and outcome.contact is not None:
            text = scale.text_of(outcome.contact, form)
        self._form = form
        if text is None:
            ends = self._ends()
            text = form.example if ends is None else scale.text_at(scale.STEPS // 2, ends, form)
        self._set(text)

    def _typed(self, event: Any) -> None:
        if not self._silent:
            self._set(event.new)

    def _slid(self, event: Any) -> None:
        ends = self._ends()
        if not self._silent and ends is not None:
            self._set(scale.text_at(event.new, ends, self._form))

    def _set(self, text: str) -> None:
        try:
            self._give(self._form.option, text)
        except RoughcontactError as error:
            self._wrong.object = (
                f'<span role="alert" class="wrong">{words.escaped(words.told(error))}</span>'
            )
            self._wrong.visible = True
        else:
            self._wrong.visible = False
