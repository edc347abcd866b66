"""What one sees of a contact beside its maps, and of its surface: drawn where it is looked at."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import cached_property
from typing import Any

import panel as pn

from roughcontact.contact.result import ContactResult
from roughcontact.desk import headline, style
from roughcontact.desk.charts import Bearing, Histogram, Spectrum
from roughcontact.desk.pictures import Box
from roughcontact.desk.reach import Tabs
from roughcontact.desk.section import Section, whole_line
from roughcontact.desk.session import Session
from roughcontact.desk.spots import SpotTable
from roughcontact.desk.state import Line
from roughcontact.desk.words import escaped
from roughcontact.desk.working import Run
from roughcontact.errors import InputError
from roughcontact.report import inputs
from roughcontact.surface.surface import Surface
from roughcontact.units import parse

_SECTION, _SPOTS, _PRESSURES = range(3)
_ENDS = 4


class Detail:
    """Section, spots and distribution of the pressure, of which one is in sight.

    Parameters
    ----------
    zoom : callable
        ``zoom(box)`` brings a part of the maps into sight.
    draw : callable
        ``draw(line)`` takes the line of another section, which was typed.
    """

    def __init__(self, zoom: Callable[[Box], None], draw: Callable[[Line], None]) -> None:
        self.section = Section()
        self._zoom = zoom
        self._call = draw
        self._ends = pn.widgets.TextInput(
            label="Section from y, x to y, x (or drag its ends on a map)",
            placeholder="50 um, 0 um, 50 um, 100 um",
            **{**style.CONTROL, "sizing_mode": None}, width=360,
        )  # fmt: skip
        self._wrong = pn.pane.HTML("", visible=False, **style.SHEET)
        self._ends.param.watch(self._typed, "value")
        self._surface: Surface | None = None
        self._result: ContactResult | None = None
        self._line: Line | None = None
        self._proposed: Line | None = None
        section = pn.Column(
            pn.pane.Bokeh(self.section.root, **style.BLOCK), self._ends, self._wrong, **style.BLOCK
        )
        parts = {
            "Section": section,
            "Contact spots": pn.Column(**style.BLOCK),
            "Pressures": pn.Column(**style.BLOCK),
        }
        self._parts = list(parts.values())
        self._tabs = Tabs(parts, self._draw)
        self.root = self._tabs.root

    @cached_property
    def spots(self) -> SpotTable:
        """The table of spots, made when it is looked at."""
        made = SpotTable()
        made.on_spot(self._zoom)
        self._parts[_SPOTS].append(pn.pane.Bokeh(made.root, **style.BLOCK))
        return made

    @cached_property
    def pressures(self) -> Histogram:
        """The distribution of the pressure, made when it is looked at."""
        made = Histogram()
        self._parts[_PRESSURES].append(pn.pane.Bokeh(made.root, **style.BLOCK))
        return made

    @property
    def line(self) -> Line | None:
        """The line of the section."""
        return self._proposed if self._line is None else self._line

    def show(
        self, surface: Surface | None, result: ContactResult | None, line: Line | None
    ) -> None:
        """Show a contact, or the surface alone; a line of None is the one that is proposed."""
        if surface is not self._surface:
            self._proposed = None if surface is None else whole_line(surface)
        self._surface, self._result, self._line = surface, result, line
        self._draw()

    def _typed(self, event: Any) -> None:
        words = event.new.split(",")
        self._wrong.visible = False
        if not event.new.strip():
            return
        try:
            if len(words) != _ENDS:
                raise InputError("needs four lengths: y, x of one end and y, x of the other")
            y0, x0, y1, x1 = (parse(word, "length", "section", positive=False) for word in words)
        except InputError as error:
            text = f'<span role="alert" class="wrong">{escaped(error.worded())}</span>'
            self._wrong.object, self._wrong.visible = text, True
        else:
            self._call((y0, x0, y1, x1))

    def _draw(self) -> None:
        active, result, surface, line = self._tabs.active, self._result, self._surface, self.line
        if active == _SECTION:
            if surface is None or line is None:
                self.section.clear()
            else:
                self.section.show(surface, result, line)
        else:
            seen = self.spots if active == _SPOTS else self.pressures
            if result is None:
                seen.clear()
            else:
                seen.show(result)


class Texture:
    """Roughness, material ratio curve and spectrum of the surface as it is pressed.

    Parameters
    ----------
    run : callable
        Calls what changes the page.
    session : Session
        Whose surface it is.
    """

    def __init__(self, run: Run, session: Session) -> None:
        self._run, self._session = run, session
        self._bearing, self._spectrum = Bearing(), Spectrum()
        self._numbers = pn.pane.HTML("", width=460, margin=(8, 16, 0, 0), **style.SHEETS)
        self._shown: Surface | None = None
        self.root = pn.Row(
            self._numbers,
            pn.Column(
                pn.pane.Bokeh(self._bearing.root, **style.BLOCK),
                pn.pane.Bokeh(self._spectrum.root, **style.BLOCK),
                sizing_mode="stretch_width",
            ),
            sizing_mode="stretch_width",
        )

    def show(self) -> None:
        """Show the surface, once it is worked out what there is to show."""
        prepared = self._session.prepared
        surface = None if prepared is None else prepared.surfaces[0]
        if surface is self._shown:
            return
        self._shown = surface
        self._numbers.object = ""
        self._bearing.clear()
        self._spectrum.clear()
        if surface is not None and not surface.is_profile:
            # Of a large map it takes seconds, which other pages have not.
            threading.Thread(target=self._work_out, args=(surface,), daemon=True).start()

    def cancel(self) -> None:
        """Nothing that takes long is under way."""

    def _work_out(self, surface: Surface) -> None:
        try:
            values = surface.roughness()
        except InputError:
            # Holes that leave no point both of its neighbours.
            values = {}
        rows = [
            (name, inputs.parameter(name, values), meaning)
            for name, (_, meaning) in inputs.ROUGHNESS.items()
        ]
        note = '<p class="quiet">ISO 25178-2, of the heights as they are pressed.</p>'
        text = note + headline.table(rows)
        self._run(lambda: self._put(surface, text))

    def _put(self, surface: Surface, text: str) -> None:
        if surface is self._shown:
            self._numbers.object = text
            self._bearing.show(surface)
            self._spectrum.show(surface)


class Numbers:
    """Everything that is told of the contact.

    Parameters
    ----------
    session : Session
        Whose contact it is.
    """

    def __init__(self, session: Session) -> None:
        self._session = session
        self.root = pn.pane.HTML("", **style.WIDE)

    def show(self) -> None:
        """Show the numbers of the contact as it is."""
        outcome = self._session.outcome
        result = None if outcome is None else outcome.contact
        self.root.object = "" if result is None else headline.all_numbers(result)

    def cancel(self) -> None:
        """Nothing is under way."""
