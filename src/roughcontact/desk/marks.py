"""What one draws on the maps: a line for a section, a box for a crop."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from bokeh.core.properties import value
from bokeh.events import SelectionGeometry
from bokeh.models import BoxAnnotation, BoxSelectTool, ColumnDataSource, CustomJS

from roughcontact.desk import look
from roughcontact.desk.pictures import Box
from roughcontact.desk.state import Line
from roughcontact.desk.style import ACCENT, FONT, INK

# Dots of the side of the handle at each end.
_HANDLE = 16
# Dots from an end to its name.
_BESIDE = 10


class View(NamedTuple):
    """How lengths stand on the screen: dots a metre, units of the axes a metre, and the map."""

    dots: float
    factor: float
    home: Box


class SectionLine:
    """A line on all maps, whose ends one drags."""

    def __init__(self, plots: Sequence[Any]) -> None:
        self._view = View(1.0, 1.0, Box(0.0, 0.0, 1.0, 1.0))
        self._line: Line | None = None
        self._drawing = False
        self._call: Callable[[Line], None] | None = None
        self.source: Any = ColumnDataSource(
            {"x": [], "y": [], "name": [], "beside": []}, syncable=False
        )
        self.ends: list[Any] = [
            BoxAnnotation(
                left=0, right=1, top=0, bottom=1, visible=False, editable=True, movable="both",
                resizable="none", use_handles=False, fill_color="white", fill_alpha=0.55,
                line_color=ACCENT, line_width=2, hover_fill_color="white", hover_fill_alpha=0.9,
                hover_line_color=INK,
            )
            for _ in range(2)
        ]  # fmt: skip
        for plot in plots:
            plot.line("x", "y", source=self.source, line_color="white", line_width=4)
            plot.line("x", "y", source=self.source, line_color=ACCENT, line_width=2)
            plot.text(
                "x", "y", "name", source=self.source, x_offset="beside", y_offset=-8,
                text_font=value(FONT), text_font_size=look.TEXT, text_font_style="bold",
                text_color=INK, text_outline_color="white",
            )  # fmt: skip
            for end in self.ends:
                plot.add_layout(end)
        follow = CustomJS(args={"ends": self.ends, "source": self.source}, code=_FOLLOW)
        later = look.Later(plots[0], self._dragged)
        for end in self.ends:
            for edge in ("left", "right", "top", "bottom"):
                end.js_on_change(edge, follow)
            look.on_changes(end, ("left", "right", "top", "bottom"), later)

    @property
    def line(self) -> Line | None:
        """Its ends (y0, x0, y1, x1) [m]."""
        return self._line

    def on_change(self, call: Callable[[Line], None]) -> None:
        """Have ``call(line)`` called whenever it is dragged."""
        self._call = call

    def put(self, line: Line | None) -> None:
        """Set or take away the line; its ends go to the nearest places on the map."""
        self._line = None if line is None else _within(line, self._view.home)
        self._draw()

    def look_from(self, view: View) -> None:
        """Keep the handles at their size on the screen."""
        self._view = view
        if self._line is not None:
            self.put(self._line)

    def _draw(self) -> None:
        factor = self._view.factor
        half = _HANDLE / 2 / self._view.dots * factor
        places = [] if self._line is None else [self._line[:2], self._line[2:]]
        middle = (self._view.home.left + self._view.home.right) / 2
        # Before the handles, which the line follows.
        self.source.data = {
            "x": [x * factor for _, x in places],
            "y": [y * factor for y, _ in places],
            "name": ["A", "B"][: len(places)],
            "beside": [_BESIDE if x < middle else -_BESIDE - 8 for _, x in places],
        }
        self._drawing = True
        for end, (y, x) in zip(self.ends, places, strict=False):
            y, x = y * factor, x * factor
            end.update(left=x - half, right=x + half, top=y - half, bottom=y + half)
        self._drawing = False
        for end in self.ends:
            end.visible = bool(places)

    def _dragged(self) -> None:
        if self._line is None or self._drawing:
            return
        factor = self._view.factor
        y0, x0, y1, x1 = (
            (first + second) / 2 / factor
            for end in self.ends
            for first, second in ((end.top, end.bottom), (end.left, end.right))
        )
        line = _within((y0, x0, y1, x1), self._view.home)
        # Handles that were only given another size are still where they were.
        near = 0.1 / self._view.dots
        if max(abs(new - old) for new, old in zip(line, self._line, strict=True)) < near:
            return
        self._line = line
        if self._call is not None:
            self._call(line)


class CropBox:
    """A box on all maps, drawn with a tool of its own, then moved and resized."""

    def __init__(self, plots: Sequence[Any]) -> None:
        self._view = View(1.0, 1.0, Box(0.0, 0.0, 1.0, 1.0))
        self._box: Box | None = None
        self._drawing = False
        self._call: Callable[[Box | None], None] | None = None
        self.frame: Any = BoxAnnotation(
            left=0, right=1, top=0, bottom=1, visible=False, editable=True,
            fill_color="white", fill_alpha=0.25, line_color=ACCENT, line_width=2,
            hover_fill_color="white", hover_fill_alpha=0.35, hover_line_color=ACCENT,
        )  # fmt: skip
        self._later = look.Later(plots[0], self._dragged)
        for plot in plots:
            plot.add_layout(self.frame)
            plot.add_tools(
                BoxSelectTool(renderers=[], description="Draw a box, for example to crop to it")
            )
            plot.on_event(SelectionGeometry, self._drawn)
        look.on_changes(self.frame, ("left", "right", "top", "bottom"), self._later)

    @property
    def box(self) -> Box | None:
        """The box [m]."""
        return self._box

    def on_change(self, call: Callable[[Box | None], None]) -> None:
        """Have ``call(box)`` called whenever it is drawn, moved or taken away."""
        self._call = call

    def put(self, box: Box | None) -> None:
        """Set or take away the box; what reaches beyond the map is cut off."""
        self._box = None if box is None else _cut(box, self._view.home)
        self.frame.visible = self._box is not None
        if self._box is not None:
            top, left, bottom, right = (edge * self._view.factor for edge in self._box)
            self._drawing = True
            self.frame.update(top=top, left=left, bottom=bottom, right=right)
            self._drawing = False

    def look_from(self, view: View) -> None:
        """Take up another map or scale."""
        self._view = view
        if self._box is not None:
            self.put(self._box)

    def _drawn(self, event: Any) -> None:
        geometry = event.geometry
        if not event.final or geometry.get("type") != "rect":
            return
        self._become([geometry[name] for name in ("y0", "x0", "y1", "x1")])

    def _dragged(self) -> None:
        if self._box is not None and not self._drawing:
            frame = self.frame
            self._become([frame.top, frame.left, frame.bottom, frame.right])

    def _become(self, edges: Sequence[float]) -> None:
        y0, x0, y1, x1 = (edge / self._view.factor for edge in edges)
        box = _cut(Box(min(y0, y1), min(x0, x1), max(y0, y1), max(x0, x1)), self._view.home)
        near = 0.1 / self._view.dots
        before = self._box
        if box and before and max(abs(n - o) for n, o in zip(box, before, strict=True)) < near:
            return
        self.put(box)
        if self._call is not None:
            self._call(self._box)


def _within(line: Line, home: Box) -> Line:
    y0, x0, y1, x1 = line
    return (
        min(max(y0, home.top), home.bottom), min(max(x0, home.left), home.right),
        min(max(y1, home.top), home.bottom), min(max(x1, home.left), home.right),
    )  # fmt: skip


def _cut(box: Box, home: Box) -> Box | None:
    y0, x0, y1, x1 = _within((box.top, box.left, box.bottom, box.right), home)
    return Box(y0, x0, y1, x1) if y0 < y1 and x0 < x1 else None


# The line follows the handles at once; the page hears of it later.
_FOLLOW = """
const data = source.data
const x = ends.map((end) => (end.left + end.right) / 2)
const y = ends.map((end) => (end.top + end.bottom) / 2)
const moved = x.some((value, i) => Math.abs(value - data.x[i]) > 1e-9)
  || y.some((value, i) => Math.abs(value - data.y[i]) > 1e-9)
if (data.x.length == 2 && moved) source.data = {...data, x, y}
"""
