"""The column of controls: map, preparation, bodies, load."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import panel as pn

from roughcontact.desk import style, words
from roughcontact.desk.controls import Control, button
from roughcontact.desk.live import Prepared
from roughcontact.desk.session import Session
from roughcontact.desk.state import UNDOING
from roughcontact.errors import InputError, RoughcontactError
from roughcontact.material import catalogue
from roughcontact.material.material import Material
from roughcontact.request import options, parsing
from roughcontact.request.solve import TASK as SOLVE
from roughcontact.surface.provenance import Provenance
from roughcontact.units import engineering

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
    "fill-all": "fill them smoothly, even above 30 %",
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
# Of a ceiling that is worked out.
_DIGITS = 6
_TURNS = {"0": "not at all", "90": "90°", "180": "180°", "270": "270°"}

_FIRST = tuple(
    option.name for option in (options.LEVEL, options.FORM, options.HOLES, options.OUTLIERS)
)
"""Of the preparation; all others are folded away."""
_VALUES = (
    "young", "poisson", "yield-strength", "counter-young", "counter-poisson",
    "counter-yield-strength",
)  # fmt: skip
_FORMS = ("body", "counter-body", "align", "offset", "angle", "mirror")
_NOTHING = {"material": "–", "counter-material": "rigid, or the values below"}


def card(title: str, *parts: Any) -> Any:
    """Return a part of the column under its heading."""
    heading = pn.pane.HTML(f"<h2>{words.escaped(title)}</h2>", **style.BLOCK, **style.SHEETS)
    return pn.Column(
        heading, *parts, sizing_mode="stretch_width", margin=(0, 0, 10, 0), styles=style.SECTION
    )


def fold(title: str, make: Callable[[], list[Any]]) -> Any:
    """Return controls that few need, folded away under a line, and made when that is opened."""
    heading = pn.pane.HTML(
        f'<span class="fold">{words.escaped(title)}</span>', margin=0, **style.SHEETS
    )
    folded = pn.Card(
        header=heading,
        collapsed=True,
        sizing_mode="stretch_width",
        margin=(0, 0, 2, 0),
        stylesheets=[style.TEXT, style.FOLD],
        header_background="transparent",
        active_header_background="transparent",
    )

    def opened(event: Any) -> None:
        if not event.new and not folded.objects:
            folded.objects = make()

    folded.param.watch(opened, "collapsed")
    return folded


class Group:
    """Some controls of the state, which show what it holds.

    Parameters
    ----------
    session : Session
        Whose state it is.
    choices : Mapping, optional
        What the texts of some of them are called, by option.
    """

    def __init__(
        self, session: Session, choices: Mapping[str, Mapping[str, str]] | None = None
    ) -> None:
        self._session, self._choices = session, choices or {}
        self.controls: dict[str, Control] = {}

    def show(self) -> None:
        """Show what the state holds."""
        for control in self.controls.values():
            control.show(self._session.state.given)

    def roots(self, *names: str) -> list[Any]:
        """Return the controls of some options, made the first time that they are wanted."""
        for name in names:
            if name not in self.controls:
                choices = _turned(self._choices.get(name))
                self.controls[name] = made = Control(name, self._session.give, choices)
                made.show(self._session.state.given)
        return [self.controls[name].root for name in names]


def _turned(choices: Mapping[str, str] | None) -> dict[str, str] | None:
    """Return texts by what they are called."""
    return None if choices is None else {told: text for text, told in choices.items()}


class Preparation:
    """What is done to a map before it is pressed, and the steps that were done."""

    def __init__(self, session: Session, changed: Callable[[], None]) -> None:
        self._session, self._changed = session, changed
        choices = {"level": _LEVELS, "holes": _HOLES, "rotate": _TURNS}
        self._group = Group(session, choices)
        self._steps = pn.Column(**style.BLOCK)
        self._shown: tuple[tuple[Provenance, ...], bool, dict[str, str]] = (), False, {}
        first = self._group.roots(*_FIRST)
        rest = [option.name for option in (*options.PREPARATION, options.TIP_RADIUS)
                if option.name not in _FIRST]  # fmt: skip
        folded = fold("Filters, part, grid", partial(self._group.roots, *rest))
        self.root = card("Prepare", self._steps, *first, folded)

    def show(self, prepared: Prepared | None) -> None:
        """Show the controls as the state holds them, and the steps that were done."""
        self._group.show()
        found = () if prepared is None else tuple(one.provenance for one in prepared.surfaces[:1])
        # A map is seen before it is said what its holes are.
        told = "holes" in self._session.state.given
        failed = {} if self._session.failure is None else self._asked()
        if (found, told, failed) == self._shown:
            return
        self._shown = found, told, failed
        steps = [
            (sentence, step.method)
            for provenance in found
            for step in provenance.operations
            if told or step.method != "masked"
            for sentence in step.sentences
        ]
        self._steps[:] = [self._line(*step) for step in list(failed.items()) or steps]

    def _asked(self) -> dict[str, str]:
        """Return the steps that are asked for, in the words of the controls, with their methods."""
        given = self._session.state.given
        methods = {name: method for method, names in UNDOING.items() for name in names}
        return {f"{SOLVE.by_name[name].label}: {given[name]}": methods[name] for name in methods
                if name in given}  # fmt: skip

    def _line(self, sentence: str, method: str) -> Any:
        text = pn.pane.HTML(
            f"<span>{words.escaped(sentence)}</span>", sizing_mode="stretch_width", **style.SHEET
        )
        if method not in UNDOING:
            return text

        def undo() -> None:
            self._session.undo_step(method)
            self._changed()

        undoing = button("Take out", undo, description=f"Take out: {sentence}")
        return pn.Row(text, undoing, **style.BLOCK)


class Bodies:
    """The materials, and the forms of the bodies."""

    def __init__(self, session: Session) -> None:
        choices = {name: _materials(nothing) for name, nothing in _NOTHING.items()}
        self._group = Group(session, choices)
        self._session = session
        self._sources = pn.pane.HTML("", **style.SHEET)
        roots = self._group.roots
        self._search = pn.widgets.TextInput(
            label="Search the catalogue", placeholder="steel, 42CrMo4, bronze …", **style.CONTROL
        )
        self._search.param.watch(self._searched, "value_input")
        self.root = card(
            "Bodies",
            self._search,
            *roots("material"),
            self._sources,
            *roots("counter-material"),
            fold("Own values", partial(roots, *_VALUES)),
            fold("Nominal forms, two maps", partial(roots, *_FORMS)),
        )

    def _searched(self, event: Any) -> None:
        """Offer the materials whose names or conditions have what is typed."""
        for name, nothing in _NOTHING.items():
            self._group.controls[name].offer(_turned(_materials(nothing, event.new)) or {})

    def show(self) -> None:
        """Show what the state holds, and where the values of its material are from."""
        self._group.show()
        name = self._session.state.given.get("material")
        self._sources.object = "" if name is None else _sources(str(name))


class Model:
    """What lies beyond the map, and what holds the pressure."""

    def __init__(self, session: Session, changed: Callable[[], None]) -> None:
        self._session, self._changed = session, changed
        self._group = Group(session, {"boundary": _QUESTION})
        roots = self._group.roots
        self._ceiling = ""
        self._factor = pn.widgets.TextInput(
            label="Ceiling as a multiple of the yield strength", placeholder="3", **style.CONTROL
        )
        self._factor.param.watch(self._multiplied, "value")
        self._wrong = pn.pane.HTML("", visible=False, **style.SHEET)
        rest = partial(roots, "load-point", "tolerance", "max-iterations", "precision")
        self.root = card(
            "Model", *roots("boundary", "ceiling"), self._factor, self._wrong,
            fold("Tilt, solver", rest),
        )  # fmt: skip

    def show(self) -> None:
        """Show what the state holds."""
        self._group.show()
        if self._session.state.given.get("ceiling") != self._ceiling:
            self._ceiling = self._factor.value = ""

    def _multiplied(self, event: Any) -> None:
        """Give the ceiling as the pressure that a multiple of the yield strength is."""
        self._wrong.visible = False
        if not event.new.strip():
            return
        try:
            self._ceiling = _multiple(event.new, self._session)
            self._session.give("ceiling", self._ceiling)
        except RoughcontactError as error:
            told = words.escaped(words.told(error))
            self._wrong.object = f'<span role="alert" class="wrong">{told}</span>'
            self._wrong.visible = True
        else:
            self._changed()


def _multiple(text: str, session: Session) -> str:
    """Return a multiple of the smaller yield strength of the bodies, as one would type it."""
    factor = parsing.number(text, "ceiling")
    prepared = session.prepared
    known: tuple[Material, ...] = ()
    if prepared is not None and "material" not in session.state.missing:
        known = prepared.request.bodies()
    strengths = [body.yield_strength for body in known if body.yield_strength is not None]
    if not strengths:
        raise InputError(
            "as a multiple needs a body with a yield strength, and a map: choose them first, or "
            "give the ceiling as a pressure", argument="ceiling",
        )  # fmt: skip
    return engineering(factor * min(strengths), "Pa", _DIGITS)


def _materials(nothing: str, search: str = "") -> dict[str, str]:
    """Return the materials that a search finds, as they are told, by their keys."""
    wanted = search.lower().split()
    told = {"": nothing}
    for entry in catalogue.entries():
        text = f"{entry.key} – {entry.condition}"
        words_of = " ".join((text, *entry.names, entry.note)).lower()
        if all(word in words_of for word in wanted):
            told[entry.key] = text
    return told


def _sources(name: str) -> str:
    try:
        entry = catalogue.entry(name)
    except RoughcontactError:
        return ""
    values = (entry.young, entry.poisson, entry.yield_strength, entry.exponent)
    sources = dict.fromkeys(value.source for value in values if value is not None)
    text = "; ".join(sources)
    return f'<p class="quiet">Values: {words.escaped(text)}</p>'
