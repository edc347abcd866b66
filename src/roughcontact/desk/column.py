"""The column of controls: map, preparation, bodies, load."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import panel as pn

from roughcontact.desk import scale, style, words
from roughcontact.desk.controls import Control, Give, button
from roughcontact.desk.live import Prepared
from roughcontact.desk.session import Session
from roughcontact.desk.state import UNDOING
from roughcontact.errors import RoughcontactError
from roughcontact.material import catalogue
from roughcontact.surface.provenance import Provenance

_QUESTION = {
    "": "–",
    "free": "the whole contact: it ends where the map ends",
    "periodic": "a sample of a larger surface that goes on alike",
    "periodic-x": "a sample along x, the whole contact along y",
    "periodic-y": "a sample along y, the whole contact along x",
}
_HOLES = {
    "error": "–",
    "fill": "fill them smoothly",
    "mask": "let them never touch",
    "crop": "keep the largest rectangle without them",
}
_LEVELS = {
    "plane": "plane, by least squares",
    "robust": "plane, not led by peaks",
    "quadric": "paraboloid",
    "mean": "mean height only",
    "none": "not at all",
}
_TURNS = {"0": "not at all", "90": "90°", "180": "180°", "270": "270°"}


def card(title: str, *parts: Any, collapsed: bool = False) -> Any:
    """Return a part of the column under its heading."""
    return pn.Card(
        *parts,
        title=title,
        collapsed=collapsed,
        sizing_mode="stretch_width",
        margin=(0, 0, 8, 0),
        stylesheets=[style.TEXT, style.CARD],
        header_background="transparent",
        active_header_background="transparent",
    )


class Group:
    """Some controls of the state, which show what it holds.

    Parameters
    ----------
    session : Session
        Whose state it is.
    names : sequence of str
        Options.
    choices : dict
        What the texts of some of them are called.
    """

    def __init__(
        self, session: Session, names: Sequence[str], choices: dict[str, dict[str, str]]
    ) -> None:
        self._session = session
        self.controls = {
            name: Control(name, session.give, _turned(choices.get(name))) for name in names
        }

    def show(self) -> None:
        """Show what the state holds."""
        for control in self.controls.values():
            control.show(self._session.state.given)

    def roots(self, *names: str) -> list[Any]:
        """Return some of the controls, all without names."""
        return [self.controls[name].root for name in names or self.controls]


def _turned(choices: dict[str, str] | None) -> dict[str, str] | None:
    """Return texts by what they are called."""
    return None if choices is None else {told: text for text, told in choices.items()}


class Preparation:
    """What is done to a map before it is pressed, and the steps that were done."""

    def __init__(self, session: Session, changed: Callable[[], None]) -> None:
        self._session, self._changed = session, changed
        self._group = Group(
            session,
            ("level", "form", "outliers", "holes", "s-filter", "l-filter", "crop", "pixel",
             "rotate", "tip-radius"),
            {"level": _LEVELS, "holes": _HOLES, "rotate": _TURNS},
        )  # fmt: skip
        self._steps = pn.Column(**style.BLOCK)
        self._shown: tuple[Provenance, ...] = ()
        first = self._group.roots("level", "form", "holes", "outliers")
        rest = self._group.roots("s-filter", "l-filter", "crop", "pixel", "rotate", "tip-radius")
        self.root = card("Prepare", self._steps, *first, card("Filters, part, grid", *rest,
                                                             collapsed=True))  # fmt: skip

    def show(self, prepared: Prepared | None) -> None:
        """Show the controls as the state holds them, and the steps that were done."""
        self._group.show()
        found = () if prepared is None else tuple(one.provenance for one in prepared.surfaces[:1])
        if found == self._shown:
            return
        self._shown = found
        self._steps[:] = [
            self._line(step.method, sentence)
            for provenance in found
            for step in provenance.operations
            for sentence in step.sentences
        ]

    def _line(self, method: str, sentence: str) -> Any:
        text = pn.pane.HTML(
            f"<span>{words.escaped(sentence)}</span>", sizing_mode="stretch_width", **style.SHEET
        )
        if method not in UNDOING:
            return text

        def undo() -> None:
            self._session.undo_step(method)
            self._changed()

        undoing = button("✕", undo, width=28, height=24, description=f"Undo: {sentence}")
        return pn.Row(text, undoing, **style.BLOCK)


class Bodies:
    """The materials, and the forms of the bodies."""

    def __init__(self, session: Session) -> None:
        self._group = Group(
            session,
            ("material", "young", "poisson", "yield-strength", "counter-material", "counter-young",
             "counter-poisson", "counter-yield-strength", "body", "counter-body", "align",
             "offset", "angle", "mirror"),
            {
                "material": _materials("–"),
                "counter-material": _materials("rigid, or the values below"),
            },
        )  # fmt: skip
        self._session = session
        self._sources = pn.pane.HTML("", **style.SHEET)
        roots = self._group.roots
        self.root = card(
            "Bodies",
            *roots("material"),
            self._sources,
            *roots("counter-material"),
            card("Own values", *roots("young", "poisson", "yield-strength", "counter-young",
                                      "counter-poisson", "counter-yield-strength"),
                 collapsed=True),
            card("Nominal forms, two maps", *roots("body", "counter-body", "align", "offset",
                                                   "angle", "mirror"), collapsed=True),
        )  # fmt: skip

    def show(self) -> None:
        """Show what the state holds, and where the values of its material are from."""
        self._group.show()
        name = self._session.state.given.get("material")
        self._sources.object = "" if name is None else _sources(str(name))


def _materials(nothing: str) -> dict[str, str]:
    told = {entry.key: f"{entry.key} – {entry.condition}" for entry in catalogue.entries()}
    return {"": nothing, **told}


def _sources(name: str) -> str:
    try:
        entry = catalogue.entry(name)
    except RoughcontactError:
        return ""
    values = (entry.young, entry.poisson, entry.yield_strength)
    sources = dict.fromkeys(value.source for value in values if value is not None)
    text = "; ".join(sources)
    return f'<p class="quiet">Values: {words.escaped(text)}</p>'


class Load:
    """The load, its slider, the ceiling, and the question what the map is."""

    def __init__(self, session: Session, give: Give) -> None:
        self._session, self._give = session, give
        self._prepared: Prepared | None = None
        self._form = scale.NOMINAL
        self._silent = False
        self.form = pn.widgets.Select(
            name="Load given as", options={form.name: form for form in scale.FORMS},
            value=self._form, **style.CONTROL,
        )  # fmt: skip
        self.text = pn.widgets.TextInput(name="Load", placeholder="20 MPa", **style.CONTROL)
        self.slider = pn.widgets.IntSlider(
            name="Load, logarithmic", start=0, end=scale.STEPS, show_value=False,
            value=scale.STEPS // 2, **style.CONTROL,
        )  # fmt: skip
        self._wrong = pn.pane.HTML("", visible=False, **style.SHEET)
        self._group = Group(
            session,
            ("boundary", "ceiling", "load-point", "tolerance", "max-iterations", "precision"),
            {"boundary": _QUESTION},
        )
        self.form.param.watch(self._reform, "value")
        self.text.param.watch(self._typed, "value")
        self.slider.param.watch(self._slid, "value")
        roots = self._group.roots
        self.root = card(
            "Load", *roots("boundary"), self.form, self.slider, self.text, self._wrong,
            *roots("ceiling"),
            card("Solver, tilt", *roots("load-point", "tolerance", "max-iterations", "precision"),
                 collapsed=True),
        )  # fmt: skip

    def show(self, prepared: Prepared | None) -> None:
        """Show what the state holds."""
        self._prepared = prepared
        self._group.show()
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
            self.text.name = f"{self._form.name}, with unit"
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
            found = value if value is not None else self._session.state.request()["approach"]
        except RoughcontactError:
            return None
        return found if isinstance(found, float) else found.value

    def _reform(self, event: Any) -> None:
        if self._silent:
            return
        outcome, form = self._session.outcome, event.new
        text = None
        if outcome is not None and outcome.result is not None:
            text = scale.text_of(outcome.result, form)
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
