"""What one sees of a contact: its maps, what stands beside them, the part of them to keep."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property

import panel as pn

from roughcontact.contact.result import ContactResult
from roughcontact.desk import look, style
from roughcontact.desk.controls import button
from roughcontact.desk.detail import Detail
from roughcontact.desk.maps import Maps
from roughcontact.desk.pictures import Box
from roughcontact.desk.state import Line
from roughcontact.surface.surface import Surface


class Sight:
    """Maps and what stands beside them, made when there is something to show, or `make` is called.

    Parameters
    ----------
    draw : callable
        ``draw(line)`` takes the line of another section.
    keep : callable
        ``keep(rows, columns)`` takes the part of the map that is to be kept.
    """

    def __init__(
        self,
        draw: Callable[[Line], None],
        keep: Callable[[tuple[int, int], tuple[int, int]], None],
    ) -> None:
        self._call_draw, self._call_keep = draw, keep
        self._surface: Surface | None = None
        self._box: Box | None = None
        self._keep = button("Keep the part that is drawn", self._kept, visible=False)
        self.root = pn.Column(self._keep, **style.BLOCK)

    @cached_property
    def maps(self) -> Maps:
        """The maps."""
        made = Maps()
        made.on_section(self._call_draw)
        made.on_box(self._boxed)
        return made

    @cached_property
    def detail(self) -> Detail:
        """What stands beside the maps."""
        made = Detail(self.maps.zoom, self._call_draw)
        self.root.extend([self.maps.root, made.root])
        return made

    def make(self) -> None:
        """Have the empty frames there."""
        _ = self.detail

    def show(self, surface: Surface, result: ContactResult | None, line: Line | None) -> None:
        """Show a contact, or a surface alone; a line of None is the one that is proposed."""
        self._surface = surface
        self.make()
        with look.together(self.maps.root.document):
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

    def _kept(self) -> None:
        surface, box = self._surface, self._box
        if surface is None or box is None:
            return
        dy, dx = surface.pixel
        rows = math.floor(box.top / dy + 0.5), math.floor(box.bottom / dy + 0.5)
        columns = math.floor(box.left / dx + 0.5), math.floor(box.right / dx + 0.5)
        self._call_keep(rows, columns)
