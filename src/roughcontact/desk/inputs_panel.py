"""Column of input controls: map, preparation, bodies and model."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Any

import panel as pn

import roughcontact as rc
from roughcontact import errors
from roughcontact.analyses.generate import task as generation
from roughcontact.desk import controls, style
from roughcontact.desk.controls import GROUPS, Control, Give, OptionsForm, make_button
from roughcontact.desk.projects import KEPT, SavedProject
from roughcontact.desk.server import PageVisit
from roughcontact.desk.session import (
    OPTIONS_OF_STEP,
    PAGE,
    SOLVE,
    Session,
    SessionState,
    Value,
    from_script,
)
from roughcontact.desk.widgets import FileDrop
from roughcontact.desk.workers import JobResult, OnEnd
from roughcontact.request import options

_CHOICES: dict[str, dict[str, str]] = PAGE["choices"]
_COMMON = ("free", "periodic")


class StepCard:
    """Collapsible card of a step, with its title and a one-line summary."""

    def __init__(self, title: str, *parts: Any, collapsed: bool = False) -> None:
        self._title = title
        self._head = pn.pane.HTML("", margin=0, sizing_mode="stretch_width", **style.SHEETS)
        self.root = pn.Card(
            pn.Column(*parts, sizing_mode="stretch_width", margin=(0, 16, 8, 34)),
            header=self._head,
            collapsed=collapsed,
            sizing_mode="stretch_width",
            margin=0,
            stylesheets=[style.TEXT, style.STEP],
            css_classes=["card", f"step-{title.lower()}"],
            header_background="transparent",
            active_header_background="transparent",
        )

    def summarize(self, done: bool, text: str, name: str = "") -> None:
        """Show whether the step is complete, and its summary: a name in bold and a text."""
        mark = '<span class="good">✓</span>' if done else '<span class="quiet">○</span>'
        bold = f"<b>{controls.escape_markup(name)}</b>" if name else ""
        self._head.object = (
            f'<div class="step"><span>{mark}</span><div><h2>{self._title}</h2>'
            f'<p class="quiet">{bold}{controls.escape_markup(text)}</p></div></div>'
        )


class ControlGroup:
    """Group of option controls that show the values of the session state."""

    def __init__(
        self, session: Session, give: Give, choices: Mapping[str, Mapping[str, str]] = _CHOICES
    ) -> None:
        self._session, self._give, self._choices = session, give, choices
        self.controls: dict[str, Any] = {}

    def refresh(self) -> None:
        """Show the values of the session state."""
        for control in self.controls.values():
            control.show_options(self._session.state.specified)

    def roots(self, *names: str) -> list[Any]:
        """Return the controls of options, each created at its first use."""
        for name in names:
            if name not in self.controls:
                created = Control(name, self._give, self._choices.get(name))
                self.controls[name] = created
                created.show_options(self._session.state.specified)
        return [self.controls[name].root for name in names]


class PreparationPanel:
    """Controls of the preparation of a map, and the recorded steps."""

    def __init__(self, session: Session, give: Give, changed: Callable[[], None]) -> None:
        self._session, self._changed = session, changed
        self._group = ControlGroup(session, give)
        self._steps = pn.Column(**style.BLOCK)
        self._shown: tuple[rc.Provenance | None, bool, dict[str, str]] | None = None
        names, last = GROUPS["first"], GROUPS["preparation"]
        first, rest = self._group.roots(*names), [name for name in last if name not in names]
        folded = controls.make_fold("Filters, part, grid", partial(self._group.roots, *rest))
        self.step = StepCard("Prepare", self._steps, *first, folded, collapsed=True)

    def refresh(self) -> None:
        """Show the preparation options of the state, and the recorded steps."""
        self._group.refresh()
        prepared = self._session.prepared
        provenance = None if prepared is None else prepared.surfaces[0].provenance
        # A preview masks missing points before the user decides on them: that step is not listed.
        text = "missing" in self._session.state.specified
        failed = {} if self._session.failure is None else self._requested_steps()
        if (provenance, text, failed) == self._shown:
            return
        self._shown = provenance, text, failed
        steps = [
            (sentence, step.method)
            for step in (() if provenance is None else provenance.operations)
            if text or step.method != "masked"
            for sentence in step.sentences
        ]
        self._steps[:] = [self._line(*step) for step in list(failed.items()) or steps]
        done = "; ".join(sentence for sentence, _ in steps)
        self.step.summarize(prepared is not None and not failed, done or "nothing so far")

    def _requested_steps(self) -> dict[str, str]:
        """Return the requested preparation steps with their labels and methods."""
        specified = self._session.state.specified
        methods = {name: method for method, names in OPTIONS_OF_STEP.items() for name in names}
        return {
            f"{SOLVE.by_name[name].label}: {specified[name]}": methods[name]
            for name in methods
            if name in specified
        }

    def _line(self, sentence: str, method: str) -> Any:
        text = pn.pane.HTML(
            f"<span>{controls.escape_markup(sentence)}</span>",
            sizing_mode="stretch_width",
            **style.SHEET,
        )
        if method not in OPTIONS_OF_STEP:
            return text

        def undo() -> None:
            self._session.undo_step(method)
            self._changed()

        undoing = make_button("Remove", undo, description=f"Remove: {sentence}")
        return pn.Row(text, undoing, **style.BLOCK)


class BodiesPanel:
    """Controls of the materials and the nominal forms of the bodies."""

    def __init__(self, session: Session, give: Give) -> None:
        choices = {name: _materials(nothing) for name, nothing in PAGE["no-material"].items()}
        self._group = ControlGroup(session, give, choices)
        self._session = session
        self._sources = pn.pane.HTML("", **style.SHEET)
        roots = self._group.roots
        self._search = pn.widgets.TextInput(
            label="Search the catalog", placeholder="steel, 42CrMo4, bronze …", **style.CONTROL
        )
        self._search.param.watch(self._handle_search, "value_input")
        self.step = StepCard(
            "Bodies",
            self._search,
            *roots("material"),
            self._sources,
            *roots("counter-material"),
            controls.make_fold("Own values, coatings", partial(roots, *GROUPS["values"])),
            controls.make_fold("Nominal forms, two maps", partial(roots, *GROUPS["forms"])),
        )

    def _handle_search(self, event: Any) -> None:
        """Offer the materials that match the search text."""
        for name, nothing in PAGE["no-material"].items():
            self._group.controls[name].offer(_materials(nothing, event.new))

    def refresh(self) -> None:
        """Show the bodies of the state, and the sources of the material values."""
        self._group.refresh()
        state = self._session.state
        name = state.specified.get("material")
        self._sources.object = "" if name is None else _sources(str(name))
        done = "material" not in state.missing
        other = state.specified.get("counter-material", "rigid")
        text = f"{name or 'own values'} on {other}" if done else "no material so far"
        self.step.summarize(done, text)


class ModelPanel:
    """Controls of the boundary condition, the ceiling and the solver."""

    def __init__(self, session: Session, give: Give) -> None:
        self._session, self._give = session, give
        self._group = ControlGroup(session, give)
        self._extent = pn.widgets.RadioBoxGroup(
            label="Boundary",
            options={_CHOICES["boundary"][name]: name for name in _COMMON},
            value=None,
            **style.CONTROL,
        )
        self._extent.param.watch(self._choose_extent, "value")
        rest = partial(self._group.roots, "boundary", *GROUPS["solver"])
        extent = pn.pane.HTML('<p class="quiet">Boundary: extent of the body</p>', **style.SHEET)
        parts = extent, self._extent, *self._group.roots("ceiling")
        self.step = StepCard("Model", *parts, controls.make_fold("Tilt, solver", rest))

    def refresh(self) -> None:
        """Show the model options of the state."""
        self._group.refresh()
        state = self._session.state
        specified = state.specified.get("boundary")
        self._extent.value = specified if specified in _COMMON else None
        boundary = specified or "no extent so far"
        text = f"{boundary}, ceiling {state.specified.get('ceiling', 'auto')}"
        self.step.summarize("boundary" not in state.missing, text)

    def _choose_extent(self, event: Any) -> None:
        if event.new not in (None, self._session.state.specified.get("boundary")):
            self._give("boundary", event.new)


def _materials(nothing: str, search: str = "") -> dict[str, str]:
    """Return the materials that match a search: labels by key."""
    wanted = search.lower().split()
    labels = {"": nothing}
    for entry in rc.catalog.entries():
        text = f"{entry.key} – {entry.condition}"
        words_of = " ".join((text, *entry.names, entry.note)).lower()
        if all(word in words_of for word in wanted):
            labels[entry.key] = text
    return labels


def _sources(name: str) -> str:
    try:
        entry = rc.catalog.entry(name)
    except rc.RoughcontactError:
        return ""
    values = (entry.young, entry.poisson, entry.yield_strength, entry.exponent)
    sources = dict.fromkeys(value.source for value in values if value is not None)
    text = "; ".join(sources)
    return f'<p class="quiet">Values: {controls.escape_markup(text)}</p>'


EXAMPLES: dict[str, dict[str, Value]] = PAGE["examples"]
"""Example maps: options of ``roughcontact generate`` by name."""

_LISTED = 12


class MapPanel:
    """Controls of the map: its file, its properties, and the sources of another map."""

    def __init__(
        self,
        session: Session,
        visit: PageVisit,
        give: Give,
        generate: Callable[[dict[str, Value], Callable[[Path], None]], None],
        check: Callable[[Path, str, OnEnd], None],
        changed: Callable[[], None],
        removed: Callable[[], None],
    ) -> None:
        self._session, self._visit, self._changed = session, visit, changed
        self._check, self._removed = check, removed
        self._coming: Path | None = None
        self._generate = generate
        self._wrong = pn.pane.HTML("", visible=False, **style.SHEET)
        self._drop = _make_file_drop("Drop a height map, or choose a file", self.take_map)
        self._nominal = ControlGroup(session, give)
        self._demonstration = pn.widgets.Select(
            label="Or a demonstration map", options=["", *EXAMPLES], **style.CONTROL
        )
        self._demonstration.param.watch(lambda event: self._demonstrate(event.new), "value")
        self._group = ControlGroup(session, give)
        self._channels: Sequence[str] = ()
        self._wanted = OptionsForm(generation.COMMAND, PAGE["generate"]["first"])
        self._of_file = controls.make_fold("Channel, unit, sides", self._about_file)
        self.start = self._start_view()
        self.step = StepCard(
            "Map",
            self._drop,
            self._wrong,
            self._demonstration,
            self._of_file,
            controls.make_fold("Earlier projects, or remove this one", self._about_works),
            controls.make_fold("Counter-body with its own map", self._about_other),
            controls.make_fold("Generate a surface", self._about_generated),
            controls.make_fold("A smooth body without a map", self._about_smooth),
        )

    def _start_view(self) -> Any:
        """Return the start view, shown until there is a map."""
        examples = (make_button(name, partial(self._demonstrate, name)) for name in EXAMPLES)
        about = (
            "<h1>1. Open a height map</h1><p>A file of a profilometer, an AFM or a stylus. "
            "It stays on this computer.</p>"
        )
        then = (
            "<h1>2, 3. Choose the material and the extent on the left</h1>"
            "<h1>4. Give the load above</h1><p>The contact is then solved at once, and again after "
            "each change.</p>"
        )
        return pn.Column(
            pn.pane.HTML(about, **style.SHEET),
            _make_file_drop("Drop the file, or choose it", self.take_map, margin=(8, 0, 16, 0)),
            pn.pane.HTML("<h2>Examples</h2>", **style.SHEET),
            pn.Row(*examples, margin=(0, 0, 24, 0)),
            pn.pane.HTML(then, **style.SHEET),
            max_width=620,
            sizing_mode="stretch_width",
            margin=(40, 16),
        )

    def _about_file(self) -> list[Any]:
        created = self._group.roots(*GROUPS["map"])
        self.offer_channels(self._channels)
        return created

    def _about_works(self) -> list[Any]:
        links = "".join(
            f'<p><a href="?work={work.key}">{controls.escape_markup(_work_title(work))}</a></p>'
            for work in self._visit.earlier()[:_LISTED]
        )
        text = pn.pane.HTML(
            links or '<p class="quiet">No other project is saved.</p>', **style.SHEET
        )
        requested = pn.widgets.TextInput(
            label='To remove this project with all its files, type "remove"', **style.CONTROL
        )
        requested.param.watch(self._remove, "value")
        return [text, requested]

    def _remove(self, event: Any) -> None:
        if event.new.strip().lower() == "remove":
            self._removed()

    def _about_other(self) -> list[Any]:
        drop = _make_file_drop(
            "Drop the map of the counter-body",
            lambda text: self._take_file(text, self._session.open_counter_map),
        )
        remove = partial(self._session.open_counter_map, None)
        return [drop, make_button("Remove counter-map", partial(self._run_action, remove))]

    def _about_generated(self) -> list[Any]:
        created = self._wanted.make_controls(PAGE["generate"]["options"])
        return [*created, make_button("Generate", self._make, primary=True)]

    def _about_smooth(self) -> list[Any]:
        words = '<p class="quiet">Its form is set under Bodies.</p>'
        nominal = self._nominal.roots("points", "size")
        use = partial(self._run_action, partial(self._session.open_map, None))
        return [pn.pane.HTML(words, **style.SHEET), *nominal, make_button("Use no map", use)]

    def refresh(self) -> None:
        """Show the state, and the properties of the map."""
        state, prepared = self._session.state, self._session.prepared
        self._group.refresh()
        self._nominal.refresh()
        surface = None if prepared is None else prepared.surfaces[0]
        size = "" if surface is None else " × ".join(map(str, surface.shape))
        if state.file is not None:
            self.step.summarize(True, f" · {size}" if size else "", state.name_of(state.file))
        else:
            done = "file" not in state.missing
            self.step.summarize(done, f"nominal body, {size}" if done else "no map so far")

    def offer_channels(self, names: Sequence[str]) -> None:
        """Suggest the channels of the file."""
        self._channels = names
        if "channel" in self._group.controls:
            self._group.controls["channel"].suggest(names)

    def tell_lacking(self, error: rc.RoughcontactError) -> bool:
        """Show an error at the file property that it names; return whether it names one."""
        lacking = _lacking_properties(error)
        if lacking:
            self.step.root.collapsed = self._of_file.collapsed = False
            text = self._session.state.with_user_names(controls.error_text(error))
            self._group.controls[lacking[0]].show_error(text)
        return bool(lacking)

    def take_map(self, text: dict[str, Any]) -> None:
        """Take an uploaded map after it is read; the answer of the server is not trusted."""
        self._take_file(text, self._session.open_map)

    def _take_file(self, text: dict[str, Any], open_map: Callable[[Path, str], None]) -> None:
        try:
            path, name = self._uploaded_file(text)
        except rc.InputError as error:
            self.refuse(error)
            return
        self._coming = path

        def ended(end: JobResult) -> None:
            if end.canceled or path != self._coming:
                return
            # A file that lacks its unit is taken: the unit is requested next.
            lacking = [] if end.error is None else _lacking_properties(end.error)
            if end.error is None or (lacking and options.FORMAT.name not in lacking):
                self._run_action(lambda: open_map(path, name))
                return
            path.unlink(missing_ok=True)
            self.refuse(end.error, SessionState().with_map(path, name))
            self._changed()

        self._check(path, name, ended)

    def _uploaded_file(self, text: dict[str, Any]) -> tuple[Path, str]:
        """Return the path of an uploaded file, and its name on the user's side."""
        if "error" in text:
            raise rc.InputError(str(text["error"]))
        path = self._visit.work.folder / Path(str(text.get("file", ""))).name
        # The browser is not trusted: accept only files that the server stored for this project.
        if not path.is_file() or not path.name.startswith(KEPT):
            raise rc.InputError("the file was not received; upload it again")
        return path, str(text.get("name", ""))

    def _demonstrate(self, name: str) -> None:
        if name:
            self._generate(EXAMPLES[name], self._map_opener(f"{name}.npz"))

    def _make(self) -> None:
        self._generate(dict(self._wanted.values), self._map_opener("generated.npz"))

    def _map_opener(self, name: str) -> Callable[[Path], None]:
        return lambda path: self._run_action(lambda: self._session.open_map(path, name))

    def _run_action(self, action: Callable[[], object]) -> None:
        try:
            action()
        except rc.RoughcontactError as error:
            self.refuse(error)
        else:
            self._wrong.visible = False
        self._changed()

    def refuse(self, error: rc.RoughcontactError, state: SessionState | None = None) -> None:
        """Show the reason why no map was opened, with the names of a state."""
        self.step.root.collapsed = False
        text = (state or self._session.state).with_user_names(controls.error_text(error))
        controls.show_alert(self._wrong, text)


def _lacking_properties(error: rc.RoughcontactError) -> list[str]:
    """Return the properties of a file that an error requests."""
    about = {part.name for part in error.sentence if isinstance(part, errors.ArgumentRef)}
    return [name for name in GROUPS["map"] if SOLVE.by_name[name].argument in about]


def _make_file_drop(text: str, arrived: Callable[[dict[str, Any]], None], **more: Any) -> Any:
    """Return a widget for dropping or choosing a file."""
    created = FileDrop(words=text, **{**style.BLOCK, **more})
    created.param.watch(lambda event: arrived(event.new), "arrived")
    return created


def _work_title(work: SavedProject) -> str:
    """Return the title of a project: its map, and the time of its last use."""
    used = datetime.fromtimestamp(work.folder.stat().st_mtime).strftime("%Y-%m-%d %H:%M")
    try:
        state = from_script(work.project.read_text(encoding="utf-8"), work.folder)
    except (rc.InputError, OSError):
        return f"cannot be read, {used}"
    return f"{'no map' if state.file is None else state.name_of(state.file)}, {used}"
