"""What one sees of a contact: its maps, what stands beside them, the part of them to keep."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property

import panel as pn

from roughcontact.contact.result import ContactResult
from roughcontact.desk import style
from roughcontact.desk.controls import button
from roughcontact.desk.detail_panel import Detail
from roughcontact.desk.maps import Maps
from roughcontact.desk.rasters import Box
from roughcontact.desk.session import Line
from roughcontact.surface.surface import Surface


class ContactView:
    """Maps and what stands beside them, made when there is something to show."""

    def __init__(
        self,
        draw: Callable[[Line], None],
        keep: Callable[[tuple[int, int], tuple[int, int]], None],
    ) -> None:
        self._call_draw, self._call_keep = draw, keep
        self._surface: Surface | None = None
        self._box: Box | None = None
        self._keep = button("Crop to selection", self._kept, visible=False)
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

    def _kept(self) -> None:
        surface, box = self._surface, self._box
        if surface is None or box is None:
            return
        dy, dx = surface.pixel
        rows = math.floor(box.top / dy + 0.5), math.floor(box.bottom / dy + 0.5)
        columns = math.floor(box.left / dx + 0.5), math.floor(box.right / dx + 0.5)
        self._call_keep(rows, columns)
