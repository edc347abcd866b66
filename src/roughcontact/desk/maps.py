"""Linked maps of a contact: heights, pressure, contact, gap, residual indentation."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import panel as pn
from bokeh import models
from bokeh.core.properties import value
from bokeh.events import DoubleTap
from bokeh.plotting import figure

import roughcontact as rc
from roughcontact import units
from roughcontact.analyses.solve import fields
from roughcontact.desk import rasters, style
from roughcontact.desk.rasters import Box, Window
from roughcontact.desk.session import Line
from roughcontact.desk.style import ACCENT, FONT, INK, read_script
from roughcontact.desk.widgets import TabStrip
from roughcontact.drawing import maps as drawing_maps, style as drawing_style
from roughcontact.report import kind as quantities

_EDGES = ("left", "right", "top", "bottom")
# Side of the handle at each end [dots].
_HANDLE = 16
# Distance of the name from its end [dots].
_LABEL_OFFSET = 10


class MapScale(NamedTuple):
    """Scale of a map: dots per meter, axis units per meter, and extent of the map [m]."""

    dots: float
    factor: float
    home: Box


class SectionLine:
    """Line on the map with draggable ends."""

    def __init__(self, plot: Any) -> None:
        self._view = MapScale(1.0, 1.0, Box(0.0, 0.0, 1.0, 1.0))
        self._line: Line | None = None
        self._drawing = False
        self._call: Callable[[Line], None] | None = None
        self.source: Any = models.ColumnDataSource(
            {"x": [], "y": [], "name": [], "offset": []}, syncable=False
        )
        self.ends: list[Any] = [
            _editable_box(0.55, 0.9, movable="both", resizable="none", use_handles=False)
            for _ in range(2)
        ]
        plot.line("x", "y", source=self.source, line_color="white", line_width=4)
        plot.line("x", "y", source=self.source, line_color=ACCENT, line_width=2)
        plot.text(
            "x",
            "y",
            "name",
            source=self.source,
            x_offset="offset",
            y_offset=-8,
            text_font=value(FONT),
            text_font_size="12px",
            text_font_style="bold",
            text_color=INK,
            background_fill_color="white",
            background_fill_alpha=0.7,
        )
        for end in self.ends:
            plot.add_layout(end)
        follow = models.CustomJS(
            args={"ends": self.ends, "source": self.source}, code=read_script("follow")
        )
        later = style.Debounced(plot, self._handle_drag)
        for end in self.ends:
            for edge in _EDGES:
                end.js_on_change(edge, follow)
            style.watch_changes(end, _EDGES, later)

    @property
    def line(self) -> Line | None:
        """Ends (y0, x0, y1, x1) of the line [m]; None without a line."""
        return self._line

    def set_listener(self, call: Callable[[Line], None]) -> None:
        """Register ``call(line)`` for the ends (y0, x0, y1, x1) [m] of a dragged line."""
        self._call = call

    def set_line(self, line: Line | None) -> None:
        """Set or remove the line; its ends are clipped to the map."""
        self._line = None if line is None else _clip_line(line, self._view.home)
        self._draw()

    def set_scale(self, view: MapScale) -> None:
        """Set the map scale; the handles keep their size on the screen."""
        self._view = view
        if self._line is not None:
            self.set_line(self._line)

    def _draw(self) -> None:
        factor = self._view.factor
        half = _HANDLE / 2 / self._view.dots * factor
        places = [] if self._line is None else [self._line[:2], self._line[2:]]
        middle = (self._view.home.left + self._view.home.right) / 2
        # Set before the handles, whose changes move the line in the browser.
        self.source.data = {
            "x": [x * factor for _, x in places],
            "y": [y * factor for y, _ in places],
            "name": ["A", "B"][: len(places)],
            "offset": [_LABEL_OFFSET if x < middle else -_LABEL_OFFSET - 8 for _, x in places],
        }
        self._drawing = True
        for end, (y, x) in zip(self.ends, places, strict=False):
            y, x = y * factor, x * factor
            end.update(left=x - half, right=x + half, top=y - half, bottom=y + half)
        self._drawing = False
        for end in self.ends:
            end.visible = bool(places)

    def _handle_drag(self) -> None:
        if self._line is None or self._drawing:
            return
        factor = self._view.factor
        y0, x0, y1, x1 = (
            (first + second) / 2 / factor
            for end in self.ends
            for first, second in ((end.top, end.bottom), (end.left, end.right))
        )
        line = _clip_line((y0, x0, y1, x1), self._view.home)
        # A change of scale resizes the handles without moving their centers.
        near = 0.1 / self._view.dots
        if max(abs(new - old) for new, old in zip(line, self._line, strict=True)) < near:
            return
        self._line = line
        if self._call is not None:
            self._call(line)


def _editable_box(alpha: float, hover_alpha: float, **more: Any) -> Any:
    return models.BoxAnnotation(
        **dict.fromkeys(_EDGES, 0.0),
        visible=False,
        editable=True,
        fill_color="white",
        fill_alpha=alpha,
        line_color=ACCENT,
        line_width=2,
        hover_fill_color="white",
        hover_fill_alpha=hover_alpha,
        hover_line_color=ACCENT,
        **more,
    )


def add_crop_box(plot: Any) -> Any:
    """Add a box to a map, drawn with a separate tool, then moved and resized; return it."""
    box, about = _editable_box(0.25, 0.35), "Draw a box, for example to crop to it"
    plot.add_tools(
        models.BoxSelectTool(renderers=[], persistent=True, overlay=box, description=about)
    )
    return box


def _clip_line(line: Line, home: Box) -> Line:
    y0, x0, y1, x1 = np.clip(line, 2 * home[:2], 2 * home[2:]).tolist()
    return y0, x0, y1, x1


HEIGHTS, PRESSURE, TOUCH, GAP, RESIDUAL = "heights", "pressure", "contact", "gap", "residual"
"""Keys of the maps, in their order on the page."""

NAMES = {
    HEIGHTS: "Heights",
    PRESSURE: "Pressure",
    TOUCH: "Contact",
    GAP: "Gap",
    RESIDUAL: "Residual indentation",
}

_MARGIN = 0.15
_MIN_MAP_PIXELS = 60
# Margins of the large map [dots]: title and tools, x-axis, y-axis, color bar.
_ABOVE, _BELOW, _BEFORE, _BEHIND = 24, 44, 46, 76
# Thumbnails [dots]: spacing, smallest and largest side.
_SPACING, _NARROWEST, _WIDEST = 8, 60, 92
# Delay of the thumbnails after the large map [ms].
_OTHERS = 80

_SHORT = {RESIDUAL: "Indentation"}
_FIELDS = {TOUCH: ("touching", "saturated", "missing"), GAP: ("cover",)}
"""Further columns in the data source of a map."""


class ColorLimits(NamedTuple):
    """Limits of the colors of a map [SI], and factor and unit of their labels."""

    low: float
    high: float
    factor: float
    unit: str


def height_scale(surface: rc.Surface) -> tuple[ColorLimits, float]:
    """Return the color limits of heights, as in figures, and the mean height [m]."""
    blocks = drawing_style.cell_size(surface.shape, surface.size, drawing_style.CELLS_ALONE)
    mean = float(np.nanmean(surface.heights)) if surface.missing < surface.heights.size else 0.0
    heights = drawing_style.cell_mean(surface.heights, blocks) - mean
    low, high, *_ = drawing_maps.height_limits(heights)
    return ColorLimits(low, high, *drawing_style.axis_unit(max(abs(low), abs(high)), "m")), mean


def result_scales(result: rc.ContactResult) -> dict[str, ColorLimits]:
    """Return the color limits of the maps of a result, as in figures."""
    size = result.surface.size
    blocks = drawing_style.cell_size(result.gap.shape, size, drawing_style.CELLS_ALONE)
    gap = drawing_maps.open_gap(result.contact, result.gap, blocks)
    highest = {
        PRESSURE: (drawing_maps.pressure_limit([result]), "Pa"),
        GAP: (drawing_maps.gap_limit(gap), "m"),
        RESIDUAL: (float(result.residual_indentation.max()) or 1e-9, "m"),
    }
    return {
        key: ColorLimits(0.0, high, *drawing_style.axis_unit(high, unit))
        for key, (high, unit) in highest.items()
    }


def map_titles(result: rc.ContactResult) -> dict[str, str]:
    """Return the titles of the maps of a result."""

    def value_text(key: str) -> str:
        return quantities.quantity_of(fields.CONTACT, key).row(result).text

    touching = units.format_percent(result.contact_fraction)
    if result.ceiling is not None:
        touching += f", saturated {units.format_percent(result.saturated_fraction)}"
    deepest = value_text("max_residual_indentation") if result.ceiling is not None else "none"
    answer = {
        PRESSURE: f"largest {value_text('max_pressure')}",
        TOUCH: touching,
        GAP: f"mean {value_text('mean_gap')}",
        RESIDUAL: deepest,
    }
    return {key: text + drawing_style.doubt_suffix(result) for key, text in answer.items()}


class MapsView:
    """Linked maps: one of five large, all as thumbnails, with a common view."""

    def __init__(self, is_live: bool = True) -> None:
        self.x_range: Any = models.Range1d(0.0, 1.0)
        self.y_range: Any = models.Range1d(1.0, 0.0)
        self.surface: rc.Surface | None = None
        self.result: rc.ContactResult | None = None
        self._part: rasters.ResultWindow | None = None
        self.mean, self._factor, self._unit = 0.0, 1.0, "m"
        self._titles: dict[str, str] = {}
        self.scales: dict[str, ColorLimits] = {}
        self._is_scaling = False
        self.chosen: dict[str, tuple[float, float]] = {}
        self._home = self._wanted = Box(0.0, 0.0, 1.0, 1.0)
        self._fitted: tuple[float, ...] = ()
        self.sources: dict[str, Any] = {
            key: style.empty_source("x", "y", "dw", "dh", key, *_FIELDS.get(key, ()), "display")
            for key in NAMES
        }
        self.mappers = color_mappers()
        self.bars: dict[str, Any] = {
            key: models.ColorBar(color_mapper=mapper, ticker=models.FixedTicker(ticks=[]))
            for key, mapper in self.mappers.items()
        }
        self.plot = self._figure()
        self._layers = {key: self.draw_layers(self.plot, key) for key in NAMES}
        drawn = len(self.plot.renderers)
        self.section, self.crop = SectionLine(self.plot), add_crop_box(self.plot)
        self._marks = self.plot.renderers[drawn:]
        self.legend, self.readout = (style.make_markup(margin=(4, 0)) for _ in range(2))
        self.readout.update(syncable=False, text=_READOUT_HINT)
        self.show_cursor_values(self.plot)
        self._room, self._large = (640, 420, 0), PRESSURE
        self._frame: tuple[float, float] = (300, 300)
        names = [f"{number} {_SHORT.get(key, NAMES[key])}" for number, key in enumerate(NAMES, 1)]
        self.strip = TabStrip(names=names, active=1, pictured=True, **style.STRIP)
        self.strip.param.watch(lambda event: self.enlarge(list(NAMES)[event.new]), "active")
        self.root = pn.Column(
            pn.pane.Bokeh(self.plot, margin=0), margin=0, stylesheets=[style.TALL]
        )
        self.side = pn.Column(self.strip, self.legend, margin=0, **style.HIGH)
        self._later = style.Debounced(self.plot, self._handle_move)
        self._others = style.Debounced(self.plot, self._draw_others, _OTHERS)
        self._arrange()
        if not is_live:
            return
        for model in (self.x_range, self.y_range):
            style.watch_changes(model, ("start", "end"), self._later)
        self._recolor = style.Debounced(self.plot, self._show_colors, _OTHERS)
        for key, mapper in self.mappers.items():
            style.watch_changes(mapper, ("low", "high"), partial(self._choose_limits, key))

    @property
    def seen(self) -> Box:
        """Visible area [m]."""
        edges = (self.y_range.end, self.x_range.start, self.y_range.start, self.x_range.end)
        return Box(*(float(edge) / self._factor for edge in edges))

    def show_contact(
        self, surface: rc.Surface | None, result: rc.ContactResult | None = None
    ) -> None:
        """Show a surface and a result; maps of ``None`` are empty."""
        with style.batch_changes(self.plot.document):
            before = self.large
            # The section shows a whole profile.
            self.root.visible = surface is None or not surface.is_profile
            self.side.visible = self.readout.visible = self.root.visible
            self.strip.visible = result is not None
            if surface is not self.surface:
                self._put_surface(surface)
            if not rasters.is_drawn_alike(result, self.result):
                self._put_result(result)
            if before != self.large:
                self._arrange()
            self._name()
            self._legend()

    def clear(self) -> None:
        """Clear all maps."""
        self.show_contact(None, None)

    @property
    def large(self) -> str:
        """Key of the large map; the heights without a contact."""
        return HEIGHTS if self.result is None else self._large

    def enlarge(self, key: str) -> None:
        """Show a map as the large map."""
        self._large = key
        with style.batch_changes(self.plot.document):
            self._draw_map(self.large)
            self._arrange()
            self._name()

    def fit(self, width: int, height: int, side: int) -> float:
        """Fit the maps to a width, a height and the least width of the thumbnails [dots].

        Return the height of the large map with its title and axis.
        """
        if (width, height, side) != self._room:
            self._room = width, height, side
            with style.batch_changes(self.plot.document):
                self._arrange()
                self._fit(self._wanted)
                self._draw()
        return self._frame[0] + _ABOVE + _BELOW

    @property
    def cropped(self) -> tuple[tuple[int, int], tuple[int, int]]:
        """Rows and columns of the surface in the drawn box."""
        assert self.surface is not None
        sides = (self.crop.top, self.crop.bottom), (self.crop.left, self.crop.right)
        rows, columns = (
            sorted(min(max(math.floor(end / self._factor / edge + 0.5), 0), points) for end in ends)
            for ends, edge, points in zip(
                sides, self.surface.pixel, self.surface.shape, strict=True
            )
        )
        return (rows[0], rows[1]), (columns[0], columns[1])

    def draw_cells(self, dots: int) -> None:
        """Draw the whole maps with at most some cells along each side, for other figures."""
        self._frame = self._home.bottom, self._home.right
        self._fit(self._home)
        self._frame = dots, dots
        self._draw()

    def _arrange(self) -> None:
        """Set the sizes of the large map and the thumbnails."""
        width, height, side = self._room
        tall, wide = self._home.bottom - self._home.top, self._home.right - self._home.left
        down = max(height - _ABOVE - _BELOW, _MIN_MAP_PIXELS)
        across = width - _BEFORE - _BEHIND
        large = min((across - side) / wide, down / tall)
        large = max(large, _MIN_MAP_PIXELS / min(tall, wide) / 2)
        frame = self._frame = round(tall * large), round(wide * large)
        self.plot.update(frame_height=frame[0], frame_width=frame[1])
        # The most thumbnails in a row that are large enough.
        sides = [(across - frame[1] + _SPACING) / count - _SPACING for count in (5, 3, 2)]
        self.strip.side = math.floor(
            min(next((s for s in sides if s >= _NARROWEST), sides[-1]), _WIDEST)
        )
        for key, bar in self.bars.items():
            bar.visible = key == self.large
        # The browser colors no map that it does not show.
        shown = [*self._layers[self.large], *self._marks]
        if self.plot.renderers != shown:
            self.plot.renderers = shown

    def zoom(self, box: Box | None = None) -> None:
        """Zoom to a box [m]; by default to the whole map."""
        with style.batch_changes(self.plot.document):
            self._fit(box or self._home)
            self._draw()

    def _put_surface(self, surface: rc.Surface | None) -> None:
        before, self.surface = self.surface, surface
        if surface is None:
            self._titles = {}
            style.clear_source(self.sources[HEIGHTS])
            return
        self.scales[HEIGHTS], self.mean = height_scale(surface)
        if before is None or (before.size, before.shape) != (surface.size, surface.shape):
            self._home = rasters.box_of(surface)
            self.chosen = {}
            self.crop.visible = False
            self._factor, self._unit = drawing_style.prefixed_window(0.0, max(surface.size))
            self.plot.xaxis.axis_label = f"x, y [{self._unit}]"
            self._arrange()
            self._fit(self._home)
        self._draw_map(HEIGHTS)

    def _put_result(self, result: rc.ContactResult | None) -> None:
        self.result = result
        self._titles = map_titles(result) if result is not None else {}
        if result is None:
            self._part = None
            style.clear_source(*(self.sources[key] for key in NAMES if key != HEIGHTS))
            return
        self.scales |= result_scales(result)
        self._draw_result()

    def _name(self) -> None:
        """Set the title of the large map; with two maps, heights name the body."""
        result, key = self.result, self.large
        name, text = NAMES[key], self._titles.get(key, "")
        if key == HEIGHTS and self.surface is not None:
            two = result is not None and result.counter_surface is not None
            name = f"{name} of the body" if two else name
            text = f"Sq {units.format_engineering(self.surface.Sq, 'm')}"
        self.plot.title.text = f"{name}, {text}" if text else name

    def _limits(self, key: str) -> tuple[float, float]:
        """Return the color limits of a map, chosen or computed, in the unit of its labels."""
        low, high, factor, _ = self.scales[key]
        low, high = self.chosen.get(key, (low, high))
        return low * factor, high * factor

    def set_scale(self, key: str) -> None:
        """Set the color limits and the color bar of a map."""
        self._is_scaling = True
        style.set_bar(self.bars[key], *self._limits(key), self.scales[key].unit)
        self._is_scaling = False

    def _choose_limits(self, key: str) -> None:
        """Adopt color limits that are dragged in the browser."""
        if key in self.scales and not self._is_scaling:
            mapper, factor = self.mappers[key], self.scales[key].factor
            self.chosen[key] = mapper.low / factor, mapper.high / factor
            self._recolor()

    def _reset_view(self, event: Any) -> None:
        """Show the whole map, or the computed color limits after a double click on their bar."""
        if event.x <= self.x_range.end:
            self.zoom()
        elif self.chosen.pop(self.large, None) is not None:
            self._show_colors()

    def _show_colors(self) -> None:
        with style.batch_changes(self.plot.document):
            if self.large in self.scales:
                self.set_scale(self.large)
            self._legend()
            self._others()

    def _window(self, surface: rc.Surface) -> Window:
        return rasters.window_of(surface.shape, surface.pixel, self.seen, self._frame, _MARGIN)

    def _draw(self) -> None:
        self._draw_map(HEIGHTS)
        self._draw_result()

    def _draw_result(self) -> None:
        """Draw the large map at once, and the other maps later."""
        if self.result is None:
            return
        # A preview has larger pixels than the map.
        self._part = rasters.result_window(self.result, self._window(self.result.surface))
        self._draw_map(self.large)
        self._others()

    def _draw_others(self) -> None:
        if self.result is None:
            return
        with style.batch_changes(self.plot.document):
            for key in NAMES:
                if key not in (HEIGHTS, self.large):
                    self._draw_map(key)
            self.strip.pictures = [self._thumbnail(key) for key in NAMES]

    def _draw_map(self, key: str) -> None:
        """Set the values and the color limits of a map."""
        surface, part = self.surface, self._part
        if surface is None or (part is None and key != HEIGHTS):
            return
        if key == HEIGHTS:
            view = self._window(surface)
            columns = {key: rasters.mean_heights(surface, view, self.mean)}
        else:
            assert part is not None
            assert self.result is not None
            surface, view = self.result.surface, part.view
            columns = _columns(key, part)
        display = {"length": self._unit, "cell": list(view.blocks)}
        if key in self.scales:
            self.set_scale(key)
            display["unit"] = self.scales[key].unit
            columns[key] = columns[key] * np.float32(self.scales[key].factor)
        top, left, bottom, right = (
            edge * self._factor for edge in rasters.window_extent(view, surface.pixel)
        )
        self.sources[key].data = {
            "x": [left],
            "y": [top],
            "dw": [right - left],
            "dh": [bottom - top],
            "display": [display],
            **{name: [values] for name, values in columns.items()},
        }

    def _thumbnail(self, key: str) -> str:
        """Return a thumbnail of a map as a data URL, true to scale."""
        data = self.sources[key].data
        values = data[key][0]
        if key in self.mappers:
            values = rasters.map_colors(values, self.mappers[key])
        sides = data["dh"][0], data["dw"][0]
        return rasters.thumbnail(values, sides, data["cover"][0] if key == GAP else None)

    def _handle_move(self) -> None:
        ranges = self._ranges()
        if self.surface is None or ranges == self._fitted:
            return
        self._fitted, self._wanted = ranges, self.seen
        with style.batch_changes(self.plot.document):
            self._update_scale()
            self._draw()

    def _ranges(self) -> tuple[float, ...]:
        return (self.x_range.start, self.x_range.end, self.y_range.start, self.y_range.end)

    def _fit(self, box: Box) -> None:
        """Set the ranges so that the frame shows a box with equal scales of x and y."""
        self._wanted = box
        height, width = box.bottom - box.top, box.right - box.left
        down, across = self._frame
        dot = max(height / down, width / across) * self._factor
        for item, first, last, half in (
            (self.x_range, box.left, box.right, dot * across / 2),
            (self.y_range, box.bottom, box.top, -dot * down / 2),
        ):
            middle = (first + last) / 2 * self._factor
            # Rounded, so that a tick at an edge stays inside the range.
            start, end = round(middle - half, 9), round(middle + half, 9)
            item.update(start=start, end=end, reset_start=start, reset_end=end)
        self._fitted = self._ranges()
        self._update_scale()

    def _update_scale(self) -> None:
        """Pass the map scale to the section line."""
        dots = self._frame[1] / max(self.seen.right - self.seen.left, 1e-300)
        self.section.set_scale(MapScale(dots, self._factor, self._home))

    def _figure(self) -> Any:
        plot = map_figure("", self.x_range, self.y_range, styles={"flex": "none"})
        plot.min_border = 0
        plot.on_event(DoubleTap, self._reset_view)
        for bar in self.bars.values():
            plot.add_layout(bar, "right")
        args = {"bars": list(self.bars.values()), "x_range": self.x_range, "y_range": self.y_range}
        drag = models.CustomJS(args=args, code=read_script("color_bar"))
        for name in ("panstart", "pan", "panend"):
            plot.js_on_event(name, drag)
        return plot

    def draw_layers(self, plot: Any, key: str) -> list[Any]:
        """Draw a map on a figure, and return its renderers."""
        place: dict[str, Any] = {name: name for name in ("x", "y", "dw", "dh")}
        place["source"] = self.sources[key]
        if key == TOUCH:
            return [plot.image_rgba(image=TOUCH, **place)]
        layers = [plot.image(image=key, color_mapper=self.mappers[key], **place)]
        return [*layers, plot.image_rgba(image="cover", **place)] if key == GAP else layers

    def _legend(self) -> None:
        result = self.result
        shares: dict[str, tuple[float, str]] = {}
        if result is not None:
            lost = float(np.count_nonzero(np.isnan(result.gap))) / result.gap.size
            touching, saturated = result.contact_fraction, result.saturated_fraction
            shares = {
                "no contact": (1 - touching - lost, "var(--ground)"),
                "elastic": (touching - saturated, drawing_style.ELASTIC),
                "saturated": (saturated, drawing_style.SATURATED),
                "closed, in the gap": (touching, drawing_style.CLOSED),
            }
        missing = 0 if self.surface is None else self.surface.missing
        if missing and self.surface is not None:
            shares["missing"] = missing / self.surface.heights.size, drawing_style.MISSING
        names = {f"{name} {units.format_percent(x)}": color for name, (x, color) in shares.items()}
        if result is not None:
            highest = self.chosen.get(PRESSURE, self.scales[PRESSURE])[1]
            # Beyond rounding: a chosen limit was divided by the factor of its unit.
            if result.max_pressure > highest * (1 + 1e-9):
                names["pressure beyond the scale"] = drawing_style.OVER
        self.legend.text = style.color_legend(names)

    def show_cursor_values(self, plot: Any) -> None:
        """Show the values at the cursor on a figure in the readout."""
        args = {**self.sources, "div": self.readout}
        read = models.CustomJS(args=args, code=read_script("readout"))
        leave = models.CustomJS(
            args={"div": self.readout, "text": _READOUT_HINT}, code="div.text = text"
        )
        plot.js_on_event("mousemove", read)
        plot.js_on_event("tap", read)
        plot.js_on_event("mouseleave", leave)


def _columns(key: str, part: rasters.ResultWindow) -> dict[str, Any]:
    """Return the data columns of a map of a result [SI], one value per cell."""
    if key == TOUCH:
        shares = dict(zip(_FIELDS[TOUCH], rasters.contact_shares(part), strict=True))
        return {TOUCH: rasters.contact_colors(part), **shares}
    if key == GAP:
        return {GAP: rasters.mean_gap(part), "cover": rasters.closed_colors(part)}
    extreme = rasters.largest_pressure if key == PRESSURE else rasters.deepest_residual
    return {key: extreme(part)}


def map_figure(title: str, x_range: Any, y_range: Any, **look: Any) -> Any:
    """Return a figure of a map with pan, zoom and crosshair tools."""
    cross: list[Any] = [
        models.Span(
            dimension=d, line_color=drawing_style.NEUTRAL, line_dash="dotted", syncable=False
        )
        for d in ("width", "height")
    ]
    wheel = models.WheelZoomTool(zoom_on_axis=False)
    plot: Any = figure(
        x_range=x_range,
        y_range=y_range,
        title=title,
        active_scroll=wheel,
        frame_align=False,
        tools=[
            models.PanTool(),
            wheel,
            models.BoxZoomTool(match_aspect=True),
            models.ResetTool(),
            models.CrosshairTool(overlay=cross),
        ],
        toolbar_location="right",
        **look,
    )
    plot.grid.visible = False
    return plot


def color_mappers() -> dict[str, Any]:
    """Return the color mappers of the maps, without limits."""
    from matplotlib import colormaps

    steps = np.linspace(0, 1, 256)
    colors = {
        HEIGHTS: colormaps["viridis"](steps),
        PRESSURE: drawing_maps.pressure_colors(),
        GAP: colormaps["Blues"](steps),
        RESIDUAL: colormaps["Reds"](0.25 + 0.75 * steps),
    }
    nothing = {HEIGHTS: drawing_style.MISSING, GAP: drawing_style.MISSING}
    return {
        key: models.LinearColorMapper(
            palette=style.color_palette(ramp),
            nan_color=nothing.get(key, rasters.CLEAR),
            high_color=drawing_style.OVER if key == PRESSURE else None,
        )
        for key, ramp in colors.items()
    }


_READOUT_HINT = '<span class="quiet">Point at a map to read its values.</span>'
