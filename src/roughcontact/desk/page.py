"""Page of the browser app: layout and event handlers."""

from __future__ import annotations

import secrets
import threading
import time
from collections.abc import Callable
from functools import cached_property, partial
from pathlib import Path
from typing import Any, NamedTuple

import panel as pn

import roughcontact as rc
from roughcontact import cautions as caution_types
from roughcontact.analyses.generate import task as generation
from roughcontact.analyses.solve import report as contact_report
from roughcontact.desk import controls, header, inputs_panel, style, workers
from roughcontact.desk.controls import Run, make_button
from roughcontact.desk.detail_panel import DetailPanel
from roughcontact.desk.header import Header
from roughcontact.desk.live_solver import Event, FailedRequest, LiveSolver, PreparedMaps, Preview
from roughcontact.desk.maps import MapsView
from roughcontact.desk.server import PageVisit
from roughcontact.desk.session import Line, Session, SessionState, Value
from roughcontact.desk.widgets import Frame, TabPanels, watch_connection
from roughcontact.report import kind as quantities, phrases
from roughcontact.report.presentation import presentation_of
from roughcontact.request.outcome import Outcome
from roughcontact.request.request import Request

_SHORT = 0.6
"""Delay [s] before progress is shown."""
# Time after which Panel 1.9 sends what it kept [ms]: of three batches at once maybe the last.
_FLUSH = 200


class ShownResult(NamedTuple):
    """Result with its request, and its main and its other quantities as HTML.

    A preview has no other quantities and no cautions.
    """

    request: Request
    result: rc.ContactResult
    numbers: str
    details: str | None = None
    cautions: tuple[caution_types.Caution, ...] = ()


class Page:
    """Page of one project."""

    def __init__(self, visit: PageVisit) -> None:
        work, bench = visit.work, visit.workers
        self._document = pn.state.curdoc
        self._visit, self._work, self._bench = visit, work, bench
        self._lock = threading.Lock()
        self._news: list[Event | ShownResult] = []
        self._reader = workers.MapReader(bench)
        follow = partial(LiveSolver, reader=self._reader, turns=bench.turns)
        self.session = session = Session(work.project, self._receive_event, follow, visit.share)
        visit.listeners.append(self._adopt)
        self._window = Frame(margin=0)
        self._window.param.watch(self._handle_shortcut, "key")
        self._window.param.watch(lambda event: self._color(event.new), "dark")
        self._map_panel = inputs_panel.MapPanel(
            session,
            visit,
            self._give_option,
            self._generate,
            self._check_map,
            self._show_state,
            self._remove,
        )
        self._window.param.watch(lambda event: self._map_panel.take_map(event.new), "arrived")
        self.view = ContactView(self._handle_line, self._crop, self._run, self._map_panel.start)
        self._window.param.watch(lambda event: self.view.fit(*event.new), "size")
        self._preparation = inputs_panel.PreparationPanel(
            session, self._give_option, self._show_state
        )
        self._bodies = inputs_panel.BodiesPanel(session, self._give_option)
        self._model = inputs_panel.ModelPanel(session, self._give_option)
        self._parts: tuple[Any, ...] = (
            self._map_panel,
            self._preparation,
            self._bodies,
            self._model,
        )
        self._load = header.LoadPanel(session, self._set_option, self._drag)
        self._header = Header(self._load.root, self._remedy, self._focus_control)
        self._notice = pn.pane.HTML("", visible=False, **{**style.WIDE, "margin": (8, 16, 0, 16)})
        self._begun = time.monotonic()
        self._undo, self._redo = (
            make_button(name, partial(self._run_action, step), margin=(0, 4), align="center")
            for name, step in (("Undo", session.undo), ("Redo", session.redo))
        )
        make = self._make_job_panel
        self._views = TabPanels(
            self.view.root,
            {
                "Analyze": partial(make, "AnalysisPanel", self._remedy),
                "Joint": partial(make, "AnalysisPanel", self._remedy, True),
                "Compare": partial(make, "ComparePanel", self._run_action),
                "3-D": self._relief,
                "Export": partial(make, "DownloadPanel"),
            },
        )
        self._answer = 0
        self._has_contact = False
        self._views.strip.param.update(margin=0, height=48)
        self.root = self._layout()
        if self._document is not None:
            self._color(False)
            watch_connection(self._document)
        if visit.file is not None and session.state.file is None:
            session.open_map(visit.file.resolve())
        visit.add_close_callback(self.close)
        self._show_state()
        session.solve()

    def close(self) -> None:
        """Close the views and the session of the page."""
        self._views.close()
        self.session.close()

    def _remove(self) -> None:
        self._visit.share(None)
        self._end()
        self._visit.forget()

    def _end(self) -> None:
        self.close()
        self.root[:] = [pn.pane.HTML("<p>This project is removed.</p>", **style.SHEET)]

    def _adopt(self, state: SessionState | None) -> None:
        """Adopt the state of another page on the same project; None if it was removed."""
        if state is None:
            self.close()
            self._run(self._end)
        else:
            self.session.adopt_state(state)
            self._run(self._update_after_change)

    def _update_after_change(self) -> None:
        self._show_state()
        outcome = self.session.outcome
        if outcome is not None and outcome.contact is not None:
            self.view.show_section(outcome.contact, self.session.state.line)

    # Actions.

    def _set_option(self, name: str, value: Value) -> None:
        number, outcome = self.session.number, self.session.outcome
        self.session.set_option(name, value)
        if self.session.number == number:
            # The state is unchanged, but a preview is shown, or replaced the waiting request.
            if outcome is not None:
                self._receive_event(outcome)
            elif not self.session.state.missing:
                self.session.solve()
        # Panels of preparation and bodies do not depend on the load.
        self._show_load()

    def _drag(self, name: str, value: Value) -> None:
        if not self.session.preview(name, value):
            self._set_option(name, value)

    def _give_option(self, name: str, value: Value) -> None:
        self.session.set_option(name, value)
        self._show_state()

    def _remedy(self, name: str, value: Value) -> None:
        self._run_action(lambda: self.session.set_option(name, value))

    def _focus_control(self, place: str) -> None:
        """Unfold the step of a control, and focus the control."""
        for part in self._parts:
            if place in part.step.root.css_classes:
                part.step.root.collapsed = False
        self._window.sought = {"place": place, "count": self.session.number, "at": time.time()}

    def _color(self, dark: bool) -> None:
        if self._document is not None:
            self._document.theme = style.theme(dark)

    def _handle_shortcut(self, event: Any) -> None:
        name = str(event.new.get("name"))
        if name in ("undo", "redo"):
            self._run_action(self.session.undo if name == "undo" else self.session.redo)
        elif name.isdigit():
            self.view.enlarge(int(name) - 1)
        else:
            self._header.handle_key(name)

    def _run_action(self, action: Callable[[], None]) -> None:
        try:
            action()
        except rc.RoughcontactError as error:
            self._complain(error)
        self._show_state()

    def _complain(self, error: rc.RoughcontactError, aloud: bool = True) -> None:
        text = self.session.state.with_user_names(controls.error_text(error))
        self._notice.object = controls.error_markup(text, ' role="alert"' if aloud else "")
        self._notice.visible = True

    def _handle_line(self, line: Line) -> None:
        self.session.draw_line(line)
        outcome = self.session.outcome
        self.view.show_section(None if outcome is None else outcome.contact, line)

    def _crop(self, rows: tuple[int, int], columns: tuple[int, int]) -> None:
        self._run_action(lambda: self.session.crop_map(rows, columns))

    def _check_map(self, path: Path, name: str, ended: workers.OnEnd) -> None:
        """Read a map in another process before it is taken."""
        self._header.show_state(f"Reading {name} …", "caution")
        self._reader.check(path, lambda end: self._run(lambda: ended(end)))

    def _generate(self, specified: dict[str, Value], done: Callable[[Path], None]) -> None:
        """Generate a map in another thread, so that the server stays responsive."""
        path = self._work.make_folder() / f"generated-{secrets.token_hex(4)}.npz"
        self._header.show_state("Generating a map …", "caution")

        def work() -> None:
            try:
                generation.run_generate({**specified, "output": [str(path)]}, lambda _: None)
            except rc.RoughcontactError as error:
                self._run(partial(self._map_panel.refuse, error))
            else:
                self._run(lambda: done(path))

        threading.Thread(target=work, daemon=True).start()

    # Results from the solver thread.

    def _receive_event(self, event: Event) -> None:
        what: Event | ShownResult = event
        if isinstance(what, (rc.results.Progress, str)):
            if not self._is_slow:
                return
            what = what if isinstance(what, str) else phrases.progress_text(what)
        elif isinstance(what, Outcome) and what.contact is not None:
            # Formatting takes time: in the server thread it would delay other pages.
            what = _shown_result(what.request, what.contact)
        elif isinstance(what, Preview):
            form = header.form_of(what.request.specified)
            what = ShownResult(what.request, what.contact, header.key_numbers(what.contact, form))
        with self._lock:
            first = not self._news
            # Only the last event of a type is handled: an outdated map is not drawn.
            self._news = [item for item in self._news if not isinstance(item, type(what))] + [what]
        if first:
            self._run(self._catch_up)

    def _run(self, done: Callable[[], None]) -> None:
        if self._document is None:
            done()
        else:
            self._document.add_next_tick_callback(done)

    @property
    def _is_slow(self) -> bool:
        """Whether the job is slow enough to show its progress."""
        return time.monotonic() - self._begun > _SHORT

    def _catch_up(self) -> None:
        if self.view.create():
            # Serve other pages before the view is filled.
            self._run(self._catch_up)
            return
        with self._lock:
            news, self._news = self._news, []
        with style.batch_changes(pn.state.curdoc):
            for what in news:
                self._handle_event(what)
        self._flush_later()

    def _flush_later(self) -> None:
        """Schedule a change with which all earlier ones are sent."""
        if self._document is not None:
            self._document.add_timeout_callback(self._flush, _FLUSH)

    def _flush(self) -> None:
        self._window.beat += 1

    def _handle_event(self, what: Event | ShownResult) -> None:
        session = self.session
        match what:
            case PreparedMaps():
                self._show_prepared(what)
            case ShownResult(details=str()):
                is_current = session.is_wanted(what.request)
                if not is_current and (session.state.missing or session.failure):
                    return
                self._notice.visible = False
                surface, line = what.result.surface, session.state.line
                self.view.show_contact(surface, what.result, line, what.details)
                self._header.show_numbers(what.numbers, what.cautions)
                self._views.refresh()
                self._fold_steps()
                self._update_state(is_current)
            case ShownResult():
                prepared = session.prepared
                if prepared is None or session.state.missing or session.failure:
                    return
                self.view.show_contact(prepared.surfaces[0], what.result, session.state.line)
                self._header.numbers.object = what.numbers
                if session.is_wanted(what.request):
                    self._update_state(True)
                    self._header.show_state("Solving under the calibrated ceiling …", "caution")
                else:
                    rows, columns = what.result.pressure.shape
                    self._header.show_state(f"Preview on {rows} × {columns} pixels", "caution")
            case FailedRequest():
                # Announced once, at the control if the error has one.
                requested = self._map_panel.tell_lacking(what.error)
                self._complain(what.error, aloud=not requested)
                self._preparation.refresh()
                self.view.clear()
                self._header.show_lacking(session.state.missing)
                self._update_state(True)
            case str():
                self._show_running(what)

    def _show_prepared(self, what: PreparedMaps) -> None:
        session = self.session
        self._map_panel.refresh()
        file = session.state.file
        self._map_panel.offer_channels(self._reader.channels.get(file, ()) if file else ())
        self._preparation.refresh()
        self._load.refresh()
        failed, missing = session.failure is not None, session.state.missing
        if missing and not failed:
            self._show_missing()
            # The first map: its step makes room for the next ones.
            if self.view.maps.surface is None:
                self._map_panel.step.root.collapsed = True
        if failed or missing:
            self.view.show_contact(what.surfaces[0], None, session.state.line, "")
            self._update_state(True)
        self._views.refresh()

    def _fold_steps(self) -> None:
        """Fold the steps before the model at the first contact."""
        if not self._has_contact:
            self._has_contact = True
            for part in self._parts[:3]:
                part.step.root.collapsed = True

    def _update_state(self, answered: bool = False) -> None:
        """Gray the main quantities if they are out of date, and show the state."""
        session = self.session
        if answered:
            self._answer = session.number
        is_old = self._answer != session.number
        self._header.numbers.styles = style.OLD if is_old else style.NEW
        if is_old and (session.prepared is None or session.state.missing):
            self._header.show_state("Reading the map …", "caution")
        elif is_old:
            self._header.show_state("Out of date, solving …", "caution")
        elif session.failure is not None:
            self._header.show_state("No result", "warning")
        elif session.outcome is not None:
            self._header.show_state("Up to date", "good")
        else:
            self._header.show_state(self._header.next_step)

    def _show_running(self, text: str) -> None:
        """Show the running job."""
        # A shown error stays while only the map is drawn.
        if self.session.failure is None and self._is_slow:
            text = self.session.state.with_user_names(text)
            self._header.show_state(f"{text} …", "caution")

    def _show_missing(self) -> None:
        session = self.session
        wanted = session.state.missing
        if session.prepared is not None and "missing" not in session.state.specified:
            holed = any(surface.missing for surface in session.prepared.surfaces)
            wanted = (*wanted, "missing") if holed else wanted
        self._header.show_lacking(wanted)
        self._has_contact = False

    def _show_state(self) -> None:
        """Update all controls after a change of the state."""
        for part in self._parts:
            part.refresh()
        self._show_load()

    def _show_load(self) -> None:
        session = self.session
        self._flush_later()
        self._begun = time.monotonic()
        self._views.refresh()
        self._load.refresh()
        self._undo.disabled, self._redo.disabled = not session.can_undo, not session.can_redo
        nothing = "file" in session.state.missing
        if nothing:
            self.view.clear()
        if session.state.missing:
            self._show_missing()
        self._update_state(nothing)

    # Imported on first use, to load the first page faster.

    def _relief(self) -> Any:
        from roughcontact.desk.relief import ReliefView

        return ReliefView(self.session, self.view.maps)

    def _make_job_panel(self, name: str, *more: Any) -> Any:
        from roughcontact.desk import job_panels

        return getattr(job_panels, name)(self.session, self._visit, self._run, *more)

    def _layout(self) -> Any:
        title = pn.pane.HTML(
            "<h1>roughcontact</h1>", width=style.LEFT - 32, margin=0, align="center", **style.SHEETS
        )
        keys = make_button("?", partial(self._header.handle_key, "?"), margin=0, align="center")
        first = pn.Row(
            *(title, self._views.strip, self._undo, self._redo, keys),
            sizing_mode="stretch_width",
            min_height=48,
            margin=0,
            stylesheets=[style.CSS["TOP"]],
        )
        steps = (part.step.root for part in self._parts)
        column, both = style.CSS["COLUMN"], {"sizing_mode": "stretch_both", "margin": 0}
        left = pn.Column(
            *steps, width=style.LEFT, margin=0, stylesheets=[column, style.CSS["LEFT_SIDE"]]
        )
        below = pn.Row(
            left,
            pn.Column(self._views.body, stylesheets=[column], **both),
            self._header.drawer,
            styles={"min-height": "0", "overflow": "hidden", "position": "relative"},
            **both,
        )
        parts = first, self._header.root, self._notice, below, self._window
        return pn.Column(*parts, stylesheets=[style.CSS["PAGE"]], **both)


def _shown_result(request: Request, result: rc.ContactResult) -> ShownResult:
    heads, answer = contact_report.ContactPresentation(result).rows_by_ceiling()
    rows = [(row.title, *texts) for row, texts in answer]
    empty = ("",) * (len(heads) - 1)
    rows += [
        (row.title, row.text, *empty) for row in presentation_of(result).rows(quantities.TRUST)
    ]
    return ShownResult(
        request,
        result,
        header.key_numbers(result, header.form_of(request.specified)),
        f"<p>{header.trust_line(result)}</p>"
        f"{controls.markup_table(rows, ('', *heads) if heads else ())}",
        tuple(result.cautions),
    )


def make_page(visit: PageVisit) -> Any:
    """Return the content of a new page."""
    return Page(visit).root


# Height of the section, padding, gap of the columns [dots].
_SECTION, _PADDING, _GAP = 290, 32, 16


class ContactView:
    """View of the contact tab: start panel, heights alone, or maps of a contact."""

    def __init__(
        self,
        draw: Callable[[Line], None],
        keep: Callable[[tuple[int, int], tuple[int, int]], None],
        run: Run,
        start: Any = None,
    ) -> None:
        self._call_draw, self._call_keep, self._call_run = draw, keep, run
        self._surface: rc.Surface | None = None
        self._size = 1280, 800
        self._start = start
        self._keep = make_button("Crop to selection", self._crop_selection, visible=False)
        self.root = pn.Column(start, sizing_mode="stretch_width", margin=0)

    @cached_property
    def maps(self) -> MapsView:
        """Linked maps."""
        created = MapsView()
        created.section.set_listener(self._call_draw)
        style.watch_changes(created.crop, ("visible",), self._handle_crop)
        return created

    @cached_property
    def detail(self) -> DetailPanel:
        """Section and tables."""
        return DetailPanel(self._call_run)

    @cached_property
    def _figures(self) -> Any:
        return pn.Column(self._keep, self.maps.root, margin=0, stylesheets=[style.TALL])

    @cached_property
    def _sheet(self) -> Any:
        """Layout of the maps, their legend and the detail panels."""
        return pn.Row(
            self._figures,
            self.maps.side,
            self.detail.below,
            self.maps.readout,
            self.detail.tabs,
            sizing_mode="stretch_width",
            margin=0,
            stylesheets=[style.CSS["CONTACT"]],
        )

    def create(self) -> bool:
        """Create the empty layout of a contact; return whether it did not exist."""
        before = "_sheet" in self.__dict__
        return not before and self._sheet is not None

    def show_contact(
        self,
        surface: rc.Surface,
        result: rc.ContactResult | None,
        line: Line | None,
        numbers: str | None = None,
    ) -> None:
        """Show a contact, or a surface alone; without a line, the proposed section."""
        self._surface = surface
        with style.batch_changes(self.maps.plot.document):
            self.maps.show_contact(surface, result)
            self._figures.visible = self.maps.root.visible
            self.fit(*self._size)
            self.detail.show_contact(surface, result, line, numbers)
            self.maps.section.set_line(self.detail.line)
            if self._start in self.root.objects or not self.root.objects:
                self.root[:] = [self._sheet]

    def fit(self, width: int, height: int) -> None:
        """Fit the view to a window [dots]."""
        self._size = width, height
        if self._surface is not None:
            side = 140 if width < style.WRAPPED else 240
            if width >= style.NARROW:
                side = int(min(0.27 * width, 460))
            available = max(height - (140 if width >= style.WRAPPED else 204), 380)
            used = self.maps.fit(width - style.LEFT - _PADDING - _GAP, available, side)
            # The section is below the map if there is room, or none to its right.
            below = width < style.WRAPPED or available - used >= _SECTION
            self._sheet.css_classes = ["below"] if below else []

    def enlarge(self, place: int) -> None:
        """Show a map as the large map, by its index."""
        if self._surface is not None:
            self.maps.strip.active = place

    def show_section(self, result: rc.ContactResult | None, line: Line | None) -> None:
        """Show another section, if a surface is shown."""
        if self._surface is None:
            return
        self.detail.show_contact(self._surface, result, line)
        self.maps.section.set_line(self.detail.line)

    def clear(self) -> None:
        """Show the start panel."""
        if self._surface is not None:
            self._surface = None
            self.maps.clear()
            self.detail.show_contact(None, None, None, "")
            self.root[:] = [self._start]

    def _handle_crop(self) -> None:
        self._keep.visible = self.maps.crop.visible

    def _crop_selection(self) -> None:
        if self._surface is not None:
            self._call_keep(*self.maps.cropped)
