"""Details of a contact: section along a line, spots, pressures and surface texture."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import panel as pn
from bokeh import models
from bokeh.plotting import figure
from numpy.typing import NDArray

import roughcontact as rc
from roughcontact import units
from roughcontact.desk import controls, style
from roughcontact.desk.controls import Run
from roughcontact.desk.rasters import Array, is_drawn_alike, saturated_at
from roughcontact.desk.session import Line
from roughcontact.desk.widgets import Tabs
from roughcontact.drawing import export, style as drawing_style
from roughcontact.report import inputs, kind as quantities
from roughcontact.surface import spectrum

# Maximum number of points along a line: several per pixel of any screen.
_SECTION_MOST = 4000


class SectionPoints(NamedTuple):
    """Points of a map nearest to evenly spaced positions on a line [m]."""

    place: Array
    step: float
    rows: NDArray[np.intp]
    columns: NDArray[np.intp]


class SectionBodies(NamedTuple):
    """Heights, gap and pressure along a section [SI]; NaN at missing points."""

    lower: Array
    upper: Array
    gap: Array
    pressure: Array
    saturated: NDArray[np.bool_]


def points_on_line(surface: rc.Surface, line: Line) -> SectionPoints:
    """Return the nearest map points along a line (y0, x0, y1, x1) [m]."""
    y0, x0, y1, x1 = line
    length = math.hypot(y1 - y0, x1 - x0)
    edge = min(surface.pixel[1:] if surface.is_profile else surface.pixel)
    count = min(max(math.ceil(length / edge - 1e-9), 1), _SECTION_MOST)
    along = (np.arange(count) + 0.5) / count
    rows, columns = (
        np.clip(np.floor((begin + (end - begin) * along) / side), 0, points - 1).astype(np.intp)
        for begin, end, side, points in zip(
            (y0, x0), (y1, x1), surface.pixel, surface.shape, strict=True
        )
    )
    return SectionPoints(along * length, length / count, rows, columns)


def bodies_on_line(result: rc.ContactResult, where: SectionPoints) -> SectionBodies:
    """Return both bodies along a section, under load."""
    index = where.rows, where.columns
    surface, pair = result.surface, result.pair
    gap = result.gap[index]
    y, x = (
        (n + 0.5) * edge - side / 2
        for n, edge, side in zip(index, surface.pixel, surface.size, strict=True)
    )
    tilted = result.tilt[0] * y + result.tilt[1] * x
    moved = gap - result.initial_gap[index] - tilted + result.approach
    share = pair.material.compliance * pair.contact_modulus
    lower = surface.heights[index] - np.nanmean(surface.heights) - share * moved
    pressure, saturated = result.pressure[index], saturated_at(result, index)
    return SectionBodies(lower, lower + gap, gap, pressure, saturated)


def whole_line(surface: rc.Surface) -> Line:
    """Return the full line along x through the highest point of a map."""
    heights = surface.heights
    row = 0 if np.isnan(heights).all() else int(np.nanargmax(heights)) // heights.shape[1]
    y = (row + 0.5) * surface.pixel[0]
    return (y, 0.0, y, surface.size[1])


class SectionPlot:
    """Heights of both bodies, and pressure below, along a line from A to B."""

    def __init__(self) -> None:
        columns = ("place", "lower", "upper", "gap", "pressure", "open", "flows")
        self.source: Any = style.empty_source(*columns)
        self.bars: Any = style.empty_source("left", "right", "top", "colour")
        self.along: Any = models.Range1d(start=0, end=1)
        self.heights, self.pressure = self._make_plot(150), self._make_plot(104)
        self.pressure.toolbar_location = None
        where = {"x": "place", "source": self.source}
        colors = {"gap": style.GAP, "plastic overlap": drawing_style.SATURATED}
        colors |= {"counter-body": style.NEUTRAL, "body": drawing_style.SERIES[0]}
        for name, lower, upper in (("gap", "lower", "open"), ("plastic overlap", "flows", "lower")):
            self.heights.varea(y1=lower, y2=upper, color=colors[name], **where)
        for name, column in (("counter-body", "upper"), ("body", "lower")):
            drawn = self.heights.line(y=column, line_color=colors[name], line_width=1.5, **where)
        self.legend = style.make_markup(margin=0)
        self.legend.text = style.color_legend(colors)
        self._hover: Any = models.HoverTool(
            renderers=[drawn],
            mode="vline",
            formatters={f"@{column}": "printf" for column, _ in _HOVER},
        )
        self.heights.add_tools(self._hover)
        self.pressure.quad(
            left="left",
            right="right",
            top="top",
            bottom=0,
            color="colour",
            line_color=None,
            source=self.bars,
        )
        parts = self.legend, self.heights, self.pressure
        self.root: Any = models.Column(*parts, sizing_mode="stretch_width")
        self.clear()

    def _make_plot(self, height: int) -> Any:
        plot: Any = figure(
            x_range=self.along,
            y_range=models.Range1d(0, 1),
            height=height,
            sizing_mode="stretch_width",
            tools="xpan,xwheel_zoom,xbox_zoom,reset",
            background_fill_color=None,
            min_border_left=40,
            min_border_right=8,
        )
        plot.yaxis.ticker.desired_num_ticks = 3
        return plot

    def clear(self) -> None:
        """Clear both plots."""
        style.clear_source(self.source, self.bars)
        self.heights.title.text, self.pressure.title.text = "Section", ""

    def show_section(
        self, surface: rc.Surface, result: rc.ContactResult | None, line: Line
    ) -> None:
        """Show both bodies along a line, or the surface alone without a result."""
        with style.batch_changes(self.heights.document):
            where = points_on_line(surface, line)
            self.pressure.visible = self.legend.visible = result is not None
            if result is None:
                self._show_surface(surface, where)
            else:
                self._show_contact(
                    bodies_on_line(result, where), where, drawing_style.doubt_suffix(result)
                )
            if not surface.is_profile:
                self.heights.title.text += _place_text(line)

    def _show_surface(self, surface: rc.Surface, where: SectionPoints) -> None:
        heights = surface.heights[where.rows, where.columns] - np.nanmean(surface.heights)
        none = np.full(heights.shape, np.nan)
        result = SectionBodies(
            heights, none, none, np.zeros(heights.shape), np.zeros(heights.shape, bool)
        )
        self._show_contact(result, where, "")

    def _show_contact(self, result: SectionBodies, where: SectionPoints, doubtful: str) -> None:
        length = float(where.place[-1] + where.step / 2)
        factor, unit = drawing_style.axis_unit(length, "m")
        tall = np.concatenate([result.lower, result.upper])
        scale, height_unit = drawing_style.axis_unit(
            float(np.nanmax(np.abs(tall), initial=0.0)), "m"
        )
        largest = float(result.pressure.max(initial=0.0))
        press, pressure_unit = drawing_style.axis_unit(largest, "Pa")
        flows = result.saturated & (result.gap < 0)
        self.source.data = {
            "place": where.place * factor,
            "lower": result.lower * scale,
            "upper": result.upper * scale,
            "gap": result.gap * scale,
            "pressure": result.pressure * press,
            "open": np.where(result.gap > 0, result.upper, result.lower) * scale,
            "flows": np.where(flows, result.upper, result.lower) * scale,
        }
        touching = result.pressure > 0
        place = where.place[touching] * factor
        half = where.step / 2 * factor
        self.bars.data = {
            "left": place - half,
            "right": place + half,
            "top": result.pressure[touching] * press,
            "colour": np.where(
                result.saturated[touching], drawing_style.SATURATED, drawing_style.ELASTIC
            ),
        }
        whole = length * factor
        self.along.update(start=0, end=whole, reset_start=0, reset_end=whole)
        high, low = np.nanmax(tall, initial=-np.inf), np.nanmin(tall, initial=np.inf)
        room = 0.06 * (high - low)
        if np.isfinite(room):
            self.heights.y_range.update(start=(low - room) * scale, end=(high + room) * scale)
        self.pressure.y_range.end = 1.08 * (largest or 1.0) * press
        self.pressure.xaxis.axis_label = f"from A to B [{unit}]"
        shown = (unit, height_unit, height_unit, height_unit, pressure_unit)
        self._hover.tooltips = [
            (name, f"@{column}{{%0.4g}} {unit}")
            for (column, name), unit in zip(_HOVER, shown, strict=True)
        ]
        share = units.format_percent(float(np.count_nonzero(touching)) / touching.size)
        self.heights.title.text = f"Heights [{height_unit}]"
        self.pressure.title.text = f"Pressure [{pressure_unit}], contact {share}{doubtful}"


def _place_text(line: Line) -> str:
    """Return the coordinate of a line along x or y, or how points off the grid are read."""
    y0, x0, y1, x1 = line
    for name, first, last in (("y", y0, y1), ("x", x0, x1)):
        if first == last:
            return f" at {name} = {units.format_engineering(first, 'm')}"
    return " at the nearest points"


_HOVER = (
    ("place", "along the line"),
    ("lower", "body"),
    ("upper", "counter-body"),
    ("gap", "gap"),
    ("pressure", "pressure"),
)
"""Columns of the values at the cursor, and their names."""


_MAX_SPOTS = 100


def spot_table(result: rc.ContactResult) -> str:
    """Return the largest contact spots, each with the place of its peak, as markup."""
    spots = result.spots()
    count = min(spots.count, _MAX_SPOTS)
    inside = np.flatnonzero((spots.label > 0) & (spots.label <= count))
    label = spots.label.ravel()[inside] - 1
    # The last point of a spot is assigned: the one of the largest pressure.
    order = np.argsort(result.pressure.ravel()[inside], kind="stable")
    place = np.zeros(count, np.intp)
    place[label[order]] = inside[order]
    rows, columns = np.divmod(place, result.pressure.shape[1])
    saturated = np.bincount(label, result.saturated.ravel()[inside], count) / np.bincount(label)
    dy, dx = result.surface.pixel
    window = drawing_style.prefixed_window(0.0, max(result.surface.size))

    def largest(values: Array) -> float:
        return float(values.max(initial=0.0))

    known: dict[str, tuple[Array, tuple[float, str]]] = {
        "area": (spots.area, drawing_style.prefixed_area(largest(spots.area))),
        "load": (spots.load, drawing_style.axis_unit(largest(spots.load), result.pair.load_unit)),
        "largest pressure": (spots.peak, drawing_style.axis_unit(largest(spots.peak), "Pa")),
        "saturated": (saturated, (100.0, "%")),
        "y of its peak": ((rows + 0.5) * dy, window),
        "x": ((columns + 0.5) * dx, window),
    }
    heads = ("spot", *(f"{name} [{unit}]" for name, (_, (_, unit)) in known.items()))
    table = [
        (
            str(n + 1),
            *(units.plain_decimal(values[n] * scale, 4) for values, (scale, _) in known.values()),
        )
        for n in range(count)
    ]
    shown = f", the {count} largest of them here" if count < spots.count else ""
    text = f"<p>{units.count_noun(spots.count, 'contact spot')}{shown}.</p>"
    return text + controls.markup_table(table, heads)


_RESULTS, _SPOTS, _PRESSURES, _SURFACE = range(4)


class DetailPanel:
    """Section along a line, and tabs of tables and charts."""

    def __init__(self, run: Run) -> None:
        self.section = SectionPlot()
        self._run = run
        self._surface: rc.Surface | None = None
        self._result: rc.ContactResult | None = None
        self._line: Line | None = None
        self._proposed: Line | None = None
        self.below = pn.pane.Bokeh(self.section.root, **style.BLOCK)
        names = ("Results", "Spots", "Pressures", "Surface")
        self._parts = [pn.pane.HTML("", **style.WIDE) for _ in names]
        self._drawn: dict[int, Any] = {}
        self._tabs = Tabs(dict(zip(names, self._parts, strict=True)), self._draw_tab)
        self._tabs.strip.visible = False
        self.tabs = pn.Column(self._tabs.strip, self._tabs.body, **style.HIGH)

    @property
    def line(self) -> Line | None:
        """Line of the section: the requested line, or else the proposed one."""
        return self._proposed if self._line is None else self._line

    def show_contact(
        self,
        surface: rc.Surface | None,
        result: rc.ContactResult | None,
        line: Line | None,
        numbers: str | None = None,
    ) -> None:
        """Show a contact, or the surface alone; ``line=None`` selects the proposed line.

        Without ``numbers``, for a preview or another section, tables and charts stay unchanged.
        """
        if surface is not self._surface:
            self._proposed = None if surface is None else whole_line(surface)
        before = self._surface is None, self._result is None
        alike = is_drawn_alike(result, self._result)
        is_drawn = alike and surface is self._surface and line == self._line
        self._surface, self._result, self._line = surface, result, line
        if not is_drawn:
            self._draw_section()
        if (surface is None, result is None) != before:
            self._tabs.strip.visible = result is not None
            self._tabs.strip.active = _SURFACE if result is None else _RESULTS
        if numbers is not None:
            self._parts[_RESULTS].object = numbers
            self._draw_tab()

    def _draw_section(self) -> None:
        surface, line, result = self._surface, self.line, self._result
        if surface is None or line is None:
            self.section.clear()
        else:
            # A preview has larger pixels than the map.
            shown = surface if result is None else result.surface
            self.section.show_section(shown, result, line)

    def _draw_tab(self) -> None:
        """Fill the active panel, in a separate thread: a large map takes seconds."""
        active = int(self._tabs.strip.active)
        shown: Any = self._surface if active == _SURFACE else self._result
        if active == _RESULTS or self._drawn.get(active) is shown:
            return
        self._drawn[active] = shown
        if shown is None or active == _SURFACE:
            self._parts[active].object = ""
        if shown is not None:
            threading.Thread(target=self._work_out, args=(active, shown), daemon=True).start()

    def _work_out(self, active: int, shown: Any) -> None:
        text = _MAKERS[active](shown)

        def show_text() -> None:
            if self._drawn.get(active) is shown:
                self._parts[active].object = text

        self._run(show_text)


# Matplotlib shares fonts and layouts between figures.
_DRAWING = threading.Lock()


def _draw_picture(draw: Callable[[], Any]) -> str:
    with _DRAWING:
        return controls.picture_markup(export.png(draw()))


def surface_texture(surface: rc.Surface) -> str:
    """Return material ratio curve, file, roughness and spectrum of a surface as markup."""
    if surface.is_profile:
        return ""
    try:
        values = surface.roughness()
    except rc.InputError:
        # Missing points leave no point with both neighbors.
        values = {}
    file = [(row.name, row.text, "") for row in quantities.rows_of(inputs.SURFACE, surface)]
    rows = [
        (name, inputs.parameter(name, values), meaning)
        for name, (_, meaning) in inputs.ROUGHNESS.items()
    ]
    spectrum = "<p>The power spectrum needs a map without missing points: fill them.</p>"
    if not surface.missing:
        spectrum = _draw_picture(lambda: draw_spectrum(surface))
    return (
        f"{_draw_picture(lambda: rc.plots.bearing_curve(surface))}<h2>File</h2>"
        f"{controls.markup_table(file)}<h2>Roughness, ISO 25178-2, as prepared</h2>"
        f"{controls.markup_table(rows)}{spectrum}"
    )


def draw_spectrum(surface: rc.Surface) -> Any:
    """Draw the radially averaged power spectral density of a map."""
    q, power, _ = spectrum.radial_spectrum(surface.heights, surface.pixel)
    plot, axes = drawing_style.panels(7.2, 5.2)
    axes.plot(q[power > 0], power[power > 0], color=drawing_style.SERIES[0])
    # Beyond, only the corners of the grid contribute.
    axes.axvline(np.pi / max(surface.pixel), color=drawing_style.NEUTRAL, linestyle=":")
    for way in "xy":
        drawing_style.log_scale(axes, way)
    drawing_style.plain_axes(
        axes, "wave number q [rad/m]", "C(q), mean of all directions [m⁴]", "Power spectrum"
    )
    return plot


_MAKERS: dict[int, Callable[[Any], str]] = {
    _SPOTS: spot_table,
    _PRESSURES: lambda result: _draw_picture(lambda: rc.plots.pressure_histogram(result)),
    _SURFACE: surface_texture,
}
"""Functions that return the content of a panel."""
