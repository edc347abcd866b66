"""The page: where everything stands, and what happens when something changes."""

from __future__ import annotations

import math
import secrets
import threading
import time
from collections.abc import Callable
from functools import cached_property, partial
from pathlib import Path
from typing import Any, NamedTuple

import panel as pn

from roughcontact.contact.result import ContactResult
from roughcontact.desk import controls, inputs_panel, load_panel, style, workers
from roughcontact.desk.controls import button
from roughcontact.desk.detail_panel import Detail, Numbers, Texture
from roughcontact.desk.live_solver import Event, Failed, Live, Prepared
from roughcontact.desk.maps import Maps
from roughcontact.desk.rasters import Box
from roughcontact.desk.server import Visit
from roughcontact.desk.session import Line, Session, State, Value
from roughcontact.desk.widgets import Views, reload_when_broken, tell_when_lost
from roughcontact.errors import RoughcontactError
from roughcontact.report import phrases
from roughcontact.request import generation
from roughcontact.request.outcome import Outcome
from roughcontact.request.request import Request
from roughcontact.solvers.progress import Progress
from roughcontact.surface.surface import Surface

_SHORT = 0.6
"""Seconds for which nothing is said of what is under way."""


class Shown(NamedTuple):
    """A result, the request it answers, and what is told of it as HTML."""

    request: Request
    result: ContactResult
    numbers: str
    trust: str
    cautions: str


class Page:
    """One page on one piece of work."""

    def __init__(self, visit: Visit) -> None:
        work, bench = visit.work, visit.bench
        self._document = pn.state.curdoc
        self._visit, self._work, self._bench = visit, work, bench
        self._looked_up: Path | None = None
        self._lock = threading.Lock()
        self._news: list[Event | Shown] = []
        self.session = session = Session(
            work.project, self._hear, partial(Live, reader=workers.reader(bench)), visit.share
        )
        visit.heard.append(self._adopt)
        self.sight = ContactView(self._drawn, self._crop)
        self._bring = inputs_panel.MapPanel(
            session, visit, self._generate, self._show, self._remove
        )
        self._preparation = inputs_panel.Preparation(session, self._show)
        self._bodies = inputs_panel.Bodies(session)
        self._model = inputs_panel.Model(session, self._show)
        self._load = load_panel.Load(session, self._give)
        self._numbers = pn.pane.HTML("", **style.WIDE)
        self._trust = pn.pane.HTML("", **style.WIDE)
        self._cautions = pn.pane.HTML("", **style.WIDE)
        self._begun = time.monotonic()
        self._bar = pn.indicators.Progress(
            active=True, value=-1, visible=False, **{**style.CONTROL, "height": 6}
        )
        self._undo = button("Undo", partial(self._do, session.undo))
        self._redo = button("Redo", partial(self._do, session.redo))
        self._views = Views(
            self.sight.root,
            {
                "Surface": lambda: Texture(self._run, session),
                "All numbers": lambda: Numbers(session),
                "Analyze": self._ask,
                "Joint": self._joint,
                "Compare": self._compare,
                "Download": self._take_away,
                "3-D": self._relief,
            },
        )
        self._answer = 0
        self._answers = pn.Column(
            self._numbers, self._trust, self._cautions, self._views.root,
            sizing_mode="stretch_both", margin=0,
        )  # fmt: skip
        self.root = self._laid_out()
        if self._document is not None:
            tell_when_lost(self._document)
            reload_when_broken(self._document)
            # The controls are there before the frames that wait for a map.
            pn.state.onload(self.sight.make)
        if visit.file is not None and session.state.file is None:
            session.bring(visit.file.resolve())
        visit.at_end(self.close)
        self._show()
        session.solve()

    def close(self) -> None:
        """End what the page holds."""
        self._views.close()
        self.session.close()

    def _remove(self) -> None:
        self._visit.share(None)
        self._end()
        self._visit.forget()

    def _end(self) -> None:
        self.close()
        self.root[:] = [pn.pane.HTML("<p>This project is removed.</p>", **style.SHEET)]

    def _adopt(self, state: State | None) -> None:
        """Follow another page on the same work; None where that removed it."""
        if state is None:
            self.close()
            self._run(self._end)
        else:
            self.session.adopt(state)
            self._run(self._follow)

    def _follow(self) -> None:
        self._show()
        outcome = self.session.outcome
        if outcome is not None and outcome.contact is not None:
            self.sight.cut(outcome.contact, self.session.state.line)

    # What one does.

    def _give(self, name: str, value: Value) -> None:
        self.session.give(name, value)
        # What prepares, and the bodies, a load leaves as they are.
        self._show_load()

    def _do(self, action: Callable[[], None]) -> None:
        try:
            action()
        except RoughcontactError as error:
            self._trust.object = controls.wrong(
                self.session.state.named(controls.error_text(error))
            )
        self._show()

    def _drawn(self, line: Line) -> None:
        self.session.draw_line(line)
        outcome = self.session.outcome
        self.sight.cut(None if outcome is None else outcome.contact, line)

    def _crop(self, rows: tuple[int, int], columns: tuple[int, int]) -> None:
        self._do(lambda: self.session.keep(rows, columns))

    def _look_up_channels(self) -> None:
        """Propose the channels of the file, once for each file."""
        path = self.session.state.file
        if path is None or path == self._looked_up:
            return
        self._looked_up = path

        def ended(end: workers.JobResult) -> None:
            names = [channel.name for channel in end.value or () if channel.name]
            self._run(lambda: self._bring.tell_channels(names))

        self._bench.begin(workers.channels, path, ended=ended, limits=workers.READING)

    def _generate(self, specified: dict[str, Value], done: Callable[[Path], None]) -> None:
        """Make a map, beside the page's own thread: that of others would wait."""
        path = self._work.folder / f"generated-{secrets.token_hex(4)}.npz"

        def work() -> None:
            try:
                generation.run_generate({**specified, "output": [str(path)]}, lambda _: None)
            except RoughcontactError as error:
                self._run(partial(self._bring.refuse, error))
            else:
                self._run(lambda: done(path))

        threading.Thread(target=work, daemon=True).start()

    # What is heard from the thread that solves.

    def _hear(self, what: Event | Shown) -> None:
        if isinstance(what, (Progress, str)) and not self._is_slow:
            return
        if isinstance(what, Outcome) and what.contact is not None:
            # Words cost time, which the other pages of the server have not.
            what = _shown(what.request, what.contact)
        with self._lock:
            first = not self._news
            # Only the last of a kind matters: a picture that is late is not drawn.
            self._news = [item for item in self._news if type(item) is not type(what)] + [what]
        if first:
            self._run(self._catch_up)

    def _run(self, done: Callable[[], None]) -> None:
        if self._document is None:
            done()
        else:
            self._document.add_next_tick_callback(done)

    @property
    def _is_slow(self) -> bool:
        """Whether one waits long enough to read what is under way."""
        return time.monotonic() - self._begun > _SHORT

    def _catch_up(self) -> None:
        with self._lock:
            news, self._news = self._news, []
        with style.together(pn.state.curdoc):
            for what in news:
                if not isinstance(what, (Progress, str)):
                    self._bar.visible = False
                self._take(what)

    def _take(self, what: Event | Shown) -> None:
        match what:
            case Prepared():
                self._bring.show(what)
                self._look_up_channels()
                self._preparation.show(what)
                self._views.show()
                self._load.show(what)
                failed, missing = self.session.failure is not None, self.session.state.missing
                if failed or missing:
                    self.sight.show(what.surfaces[0], None, self.session.state.line)
                if missing and not failed:
                    self._tell_missing()
                if failed or missing:
                    self._mark(True)
            case Shown():
                is_current = self.session.is_wanted(what.request)
                if not is_current and (self.session.state.missing or self.session.failure):
                    return
                self.sight.show(what.result.surface, what.result, self.session.state.line)
                self._numbers.object = what.numbers
                self._trust.object = what.trust
                self._cautions.object = what.cautions
                self._views.show()
                self._mark(is_current)
            case Failed():
                text = self.session.state.named(controls.error_text(what.error))
                # Said aloud once, at the control if there is one for it.
                requested = self._bring.tell_lacking(what.error)
                self._numbers.object = ""
                self._cautions.object = ""
                self._trust.object = controls.wrong(text, "") if requested else controls.wrong(text)
                self._preparation.show(self.session.prepared)
                self.sight.clear()
                self._mark(True)
            case Progress():
                self._wait_on(phrases.described(what))
            case str():
                self._wait_on(what)

    def _mark(self, answered: bool = False) -> None:
        """Gray what is seen unless it answers the last request."""
        if answered:
            self._answer = self.session.number
        styles = {} if self._answer == self.session.number else style.OLD
        self._answers.param.update(styles=styles, css_classes=[f"request-{self._answer}"])

    def _wait_on(self, text: str) -> None:
        """Show what is under way."""
        # What failed is said before the map alone is made.
        if self.session.failure is None and self._is_slow:
            self._bar.visible = True
            self._trust.object = controls.quiet(f"{text} …", "")

    def _tell_missing(self) -> None:
        self._numbers.object = ""
        self._cautions.object = ""
        session = self.session
        wanted = session.state.missing
        if session.prepared is not None and "missing" not in session.state.specified:
            holed = any(surface.missing for surface in session.prepared.surfaces)
            wanted = (*wanted, "missing") if holed else wanted
        self._trust.object = controls.missing(wanted)

    def _show(self) -> None:
        """Show what the state holds in all controls, after it changed."""
        session = self.session
        self._bring.show(session.prepared)
        self._preparation.show(session.prepared)
        self._bodies.show()
        self._model.show()
        self._show_load()

    def _show_load(self) -> None:
        session = self.session
        self._begun = time.monotonic()
        self._views.show()
        self._load.show(session.prepared)
        self._undo.disabled, self._redo.disabled = not session.can_undo, not session.can_redo
        nothing = "file" in session.state.missing
        if nothing:
            self.sight.clear()
        self._mark(nothing)
        if session.state.missing:
            self._tell_missing()

    # What is imported when it is looked at, lest the first page wait for it.

    def _relief(self) -> Any:
        from roughcontact.desk.relief import Relief

        visit = self._visit
        return Relief(
            self.session, self._bench, self._run, visit.folder, visit.offer,
            self.sight.maps.figures,
        )  # fmt: skip

    def _ask(self) -> Any:
        from roughcontact.desk.analysis_panel import Ask

        return Ask(self.session, self._bench, self._run)

    def _joint(self) -> Any:
        from roughcontact.desk.analysis_panel import Joint

        visit = self._visit
        return Joint(self.session, self._bench, self._run, visit.folder, visit.offer)

    def _compare(self) -> Any:
        from roughcontact.desk.analysis_panel import Compare

        return Compare(self.session, self._bench, self._run, self._do)

    def _take_away(self) -> Any:
        from roughcontact.desk.download_panel import DownloadPanel

        return DownloadPanel(
            self.session, self._bench, self._run, self._visit.folder, self._visit.offer
        )

    def _laid_out(self) -> Any:
        side = pn.Column(
            pn.Row(
                pn.pane.HTML("<h1>roughcontact</h1>", **style.SHEET), pn.Spacer(),
                self._undo, self._redo, **style.BLOCK,
            ),
            self._bring.root, self._preparation.root, self._bodies.root, self._model.root,
            width=style.SIDE, margin=(8, 12, 8, 12),
        )  # fmt: skip
        main = pn.Column(
            self._load.root, self._bar, self._answers,
            sizing_mode="stretch_both", margin=(10, 12, 8, 0),
        )  # fmt: skip
        return pn.Row(side, main, sizing_mode="stretch_both")


def _shown(request: Request, result: ContactResult) -> Shown:
    return Shown(
        request,
        result,
        controls.numbers(result),
        controls.trust(result),
        controls.cautions(result.cautions),
    )


def page(visit: Visit) -> Any:
    """Return what a new page shows."""
    return Page(visit).root


# --- Views of a contact: maps, detail panels, and the part to save ---


class ContactView:
    """Maps and detail panels, made when there is a contact to show."""

    def __init__(
        self, draw: Callable[[Line], None], keep: Callable[[tuple[int, int], tuple[int, int]], None]
    ) -> None:
        self._call_draw, self._call_keep = draw, keep
        self._surface: Surface | None = None
        self._box: Box | None = None
        self._keep = button("Crop to selection", self._crop_selection, visible=False)
        self.root = pn.Column(self._keep, **style.BLOCK)

    @cached_property
    def maps(self) -> Maps:
        """The maps."""
        created = Maps()
        created.on_section(self._call_draw)
        created.on_box(self._boxed)
        return created

    @cached_property
    def detail(self) -> Detail:
        """What stands beside the maps."""
        created = Detail(self.maps.zoom, self._call_draw)
        self.root.extend([self.maps.root, created.root])
        return created

    def make(self) -> None:
        """Have the empty frames there."""
        _ = self.detail

    def show(self, surface: Surface, result: ContactResult | None, line: Line | None) -> None:
        """Show a contact, or a surface alone; a line of None is the one that is proposed."""
        self._surface = surface
        self.make()
        with style.together(self.maps.root.document):
            self.maps.show(surface, result)
            self.detail.show(surface, result, line)
            self.maps.section.put(self.detail.line)

    def cut(self, result: ContactResult | None, line: Line | None) -> None:
        """Show another section, if there is anything to cut."""
        if self._surface is None:
            return
        self.detail.show(self._surface, result, line)
        self.maps.section.put(self.detail.line)

    def clear(self) -> None:
        """Show nothing."""
        if self._surface is not None:
            self._surface = None
            self.maps.clear()
            self.detail.show(None, None, None)

    def _boxed(self, box: Box | None) -> None:
        self._box = box
        self._keep.visible = box is not None

    def _crop_selection(self) -> None:
        surface, box = self._surface, self._box
        if surface is None or box is None:
            return
        dy, dx = surface.pixel
        rows = math.floor(box.top / dy + 0.5), math.floor(box.bottom / dy + 0.5)
        columns = math.floor(box.left / dx + 0.5), math.floor(box.right / dx + 0.5)
        self._call_keep(rows, columns)
