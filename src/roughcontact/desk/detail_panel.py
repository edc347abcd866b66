"""Details of a contact: section along a line, spots, pressures and surface texture."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import panel as pn
from bokeh import models
from bokeh.plotting import figure
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array
from roughcontact.contact.result import ContactResult
from roughcontact.desk import controls, style
from roughcontact.desk.controls import Run
from roughcontact.desk.rasters import Box, is_drawn_alike
from roughcontact.desk.session import Line
from roughcontact.desk.widgets import Tabs
from roughcontact.drawing.export import png
from roughcontact.drawing.sections import bearing_curve, pressure_histogram
from roughcontact.drawing.style import (
    ELASTIC,
    NEUTRAL,
    SATURATED,
    SERIES,
    doubt_suffix,
    prefixed,
    prefixed_area,
    prefixed_window,
)
from roughcontact.errors import InputError
from roughcontact.report import inputs
from roughcontact.report.kind import rows_of
from roughcontact.surface.roughness import radial_spectrum
from roughcontact.surface.surface import Surface
from roughcontact.units import count_noun, format_engineering, format_lengths


class SpectrumPlot:
    """Radially averaged power spectral density of a surface."""

    def __init__(self) -> None:
        self.source: Any = style.empty_source("q", "C", "wavelength")
        self.plot: Any = style.make_chart("Power spectrum", x_axis_type="log", y_axis_type="log")
        self.plot.xaxis.axis_label = "wave number q [rad/m]"
        self.plot.yaxis.axis_label = "C(q), mean of all directions [m⁴]"
        drawn = self.plot.line("q", "C", source=self.source, line_color=SERIES[0], line_width=1.6)
        self.root, self.note = style.with_note(self.plot)
        self._hover = style.add_hover(
            self.plot, drawn, [("wavelength", "wavelength"), ("q", "q"), ("C", "C")]
        )

    def clear(self) -> None:
        """Clear the plot."""
        style.clear_source(self.source)
        self.note.text = ""

    def show_surface(self, surface: Surface) -> None:
        """Show the spectrum of a map; profiles and missing points give a note instead."""
        if surface.missing or surface.is_profile:
            self.clear()
            what = "a map" if surface.is_profile else "a map without missing points: fill them"
            self.note.text = f"The spectrum needs {what}."
            return
        q, power, _ = radial_spectrum(surface.heights, surface.pixel)
        there = power > 0
        factor, unit = prefixed(float(2 * np.pi / q.min()), "m")
        with style.batch_changes(self.plot.document):
            self.source.data = {
                "q": q[there],
                "C": power[there],
                "wavelength": 2 * np.pi / q[there] * factor,
            }
            finest = np.pi / max(surface.pixel)
            self.note.text = f"Beyond {finest:.3g} rad/m only the corners of the grid contribute."
            style.hover_units(self._hover, [unit, "rad/m", "m⁴"])


# --- Section of a contact along a line: both bodies under load, gap and pressure ---


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


def points_on_line(surface: Surface, line: Line) -> SectionPoints:
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


def bodies_on_line(result: ContactResult, where: SectionPoints) -> SectionBodies:
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
    pressure = result.pressure[index]
    ceiling = math.inf if result.ceiling is None else result.ceiling
    saturated = pressure >= np.broadcast_to(ceiling, result.pressure.shape)[index]
    return SectionBodies(lower, lower + gap, gap, pressure, saturated)


def whole_line(surface: Surface) -> Line:
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
        self.heights, self.pressure = _plots(self.along, self.source, self.bars)
        self.root: Any = models.Column(self.heights, self.pressure, sizing_mode="stretch_width")
        self.clear()

    def clear(self) -> None:
        """Clear both plots."""
        style.clear_source(self.source, self.bars)
        self.heights.title.text, self.pressure.title.text = "Section", ""

    def show_section(self, surface: Surface, result: ContactResult | None, line: Line) -> None:
        """Show both bodies along a line, or the surface alone without a result."""
        with style.batch_changes(self.heights.document):
            where = points_on_line(surface, line)
            self.pressure.visible = self.heights.legend.visible = result is not None
            if result is None:
                self._show_surface(surface, where)
            else:
                self._show_contact(bodies_on_line(result, where), where, doubt_suffix(result))
            self._name(surface, line, where)

    def _show_surface(self, surface: Surface, where: SectionPoints) -> None:
        heights = surface.heights[where.rows, where.columns] - np.nanmean(surface.heights)
        none = np.full(heights.shape, np.nan)
        result = SectionBodies(
            heights, none, none, np.zeros(heights.shape), np.zeros(heights.shape, bool)
        )
        self._show_contact(result, where, "")

    def _show_contact(self, result: SectionBodies, where: SectionPoints, doubtful: str) -> None:
        length = float(where.place[-1] + where.step / 2)
        factor, unit = prefixed(length, "m")
        tall = np.concatenate([result.lower, result.upper])
        scale, height_unit = prefixed(float(np.nanmax(np.abs(tall), initial=0.0)), "m")
        largest = float(result.pressure.max(initial=0.0))
        press, pressure_unit = prefixed(largest, "Pa")
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
            "colour": np.where(result.saturated[touching], SATURATED, ELASTIC),
        }
        whole = length * factor
        self.along.update(start=0, end=whole, reset_start=0, reset_end=whole)
        high, low = np.nanmax(tall, initial=-np.inf), np.nanmin(tall, initial=np.inf)
        room = 0.06 * (high - low)
        if np.isfinite(room):
            ends = {"start": (low - room) * scale, "end": (high + room) * scale}
            self.heights.y_range.update(**ends)
        self.pressure.y_range.end = 1.08 * (largest or 1.0) * press
        self.heights.yaxis.axis_label = f"height [{height_unit}]"
        self.pressure.yaxis.axis_label = f"pressure [{pressure_unit}]"
        self.pressure.xaxis.axis_label = f"along the line from A to B [{unit}]"
        style.hover_units(
            self.heights.hover[0], [unit, height_unit, height_unit, height_unit, pressure_unit]
        )
        share = float(np.count_nonzero(touching)) / touching.size
        self.pressure.title.text = (
            f"Pressure, largest {format_engineering(largest, 'Pa')}, {100 * share:.3g} % of the "
            f"line is in contact{doubtful}"
        )

    def _name(self, surface: Surface, line: Line, where: SectionPoints) -> None:
        y0, x0, y1, x1 = line
        if surface.is_profile:
            ends = f"from x {format_engineering(x0, 'm')} to {format_engineering(x1, 'm')}"
        else:
            ends = (
                f"from y, x = {format_lengths((y0, x0), ', ')} to {format_lengths((y1, x1), ', ')}"
            )
        oblique = not surface.is_profile and y0 != y1 and x0 != x1
        nearest = ", at the points nearest to it" if oblique else ""
        self.heights.title.text = f"Section {ends}{nearest}"


def _plots(along: Any, source: Any, bars: Any) -> tuple[Any, Any]:
    """Return the plots of heights and of pressure."""
    tools = "xpan,xwheel_zoom,xbox_zoom,reset"
    heights: Any = figure(
        x_range=along,
        y_range=models.Range1d(0, 1),
        height=150,
        sizing_mode="stretch_width",
        tools=tools,
        title="Section",
        min_border_left=64,
        min_border_right=8,
    )
    heights.varea("place", "lower", "open", source=source, color="#dcebf5", legend_label="gap")
    heights.varea(
        "place",
        "flows",
        "lower",
        source=source,
        color=SATURATED,
        legend_label="overlap that flows plastically (saturated)",
    )
    heights.line(
        "place", "upper", source=source, color=NEUTRAL, line_width=1.4, legend_label="counter-body"
    )
    lower = heights.line(
        "place", "lower", source=source, color=SERIES[0], line_width=1.6, legend_label="body"
    )
    text = ("along the line", "place"), ("body", "lower"), ("counter-body", "upper")
    style.add_hover(
        heights, lower, (*text, ("gap", "gap"), ("pressure", "pressure"))
    ).mode = "vline"
    pressure: Any = figure(
        x_range=along,
        y_range=models.Range1d(0, 1),
        height=104,
        sizing_mode="stretch_width",
        tools=tools,
        title="",
        toolbar_location=None,
        min_border_left=64,
        min_border_right=8,
    )
    pressure.quad(
        left="left",
        right="right",
        top="top",
        bottom=0,
        color="colour",
        line_color=None,
        source=bars,
    )
    for plot in (heights, pressure):
        style.apply_style(plot)
        plot.yaxis.ticker.desired_num_ticks = 3
    style.quiet_legend(heights)
    return heights, pressure


# --- Sortable table of contact spots; a selected row zooms to its spot ---


# Maximum number of rows: the largest spots are listed.
_SPOTS_MOST = 1000
# The window of a spot has _AROUND + 0.5 times its size, and at least _FEWEST points.
_AROUND, _FEWEST = 1.5, 24


class SpotRows(NamedTuple):
    """Largest spots of a contact [SI]; y and x are those of the maximum pressure."""

    area: NDArray[np.float64]
    load: NDArray[np.float64]
    peak: NDArray[np.float64]
    saturated: NDArray[np.float64]
    y: NDArray[np.float64]
    x: NDArray[np.float64]


def list_spots(result: ContactResult, maximum: int = _SPOTS_MOST) -> SpotRows:
    """Return the largest contact spots of a result, the largest first."""
    spots = result.spots()
    count = min(spots.count, maximum)
    inside = np.flatnonzero(spots.label)
    label = spots.label.ravel()[inside] - 1
    pressure = result.pressure.ravel()[inside]
    # The last point of a spot is assigned: the one of the largest pressure.
    order = np.argsort(pressure, kind="stable")
    place = np.zeros(spots.count, np.intp)
    place[label[order]] = inside[order]
    rows, columns = np.divmod(place[:count], result.pressure.shape[1])
    pixels = np.bincount(label, minlength=spots.count)
    full = np.bincount(label, result.saturated.ravel()[inside], spots.count)
    dy, dx = result.surface.pixel
    return SpotRows(
        spots.area[:count],
        spots.load[:count],
        spots.peak[:count],
        (full / np.maximum(pixels, 1))[:count],
        (rows + 0.5) * dy,
        (columns + 0.5) * dx,
    )


def box_around(result: ContactResult, number: int) -> Box:
    """Return the box around a spot and its surroundings [m], by its row in the table."""
    mask = result.spots().label == number + 1
    place = np.unravel_index(np.argmax(np.where(mask, result.pressure, -1.0)), mask.shape)
    edges = []
    for axis in (0, 1):
        along = np.flatnonzero(mask.any(axis=1 - axis))
        # A spot across a periodic edge has two parts: the one with the maximum pressure is shown.
        parts = np.split(along, np.flatnonzero(np.diff(along) > 1) + 1)
        part = next(item for item in parts if place[axis] in item)
        middle = (part[0] + part[-1] + 1) / 2
        half = max((_AROUND + 0.5) * (part[-1] + 1 - part[0]), _FEWEST) / 2
        edges.append(
            (
                (middle - half) * result.surface.pixel[axis],
                (middle + half) * result.surface.pixel[axis],
            )
        )
    (top, bottom), (left, right) = edges
    return Box(top, left, bottom, right)


class SpotTable:
    """Table of the largest contact spots."""

    def __init__(self) -> None:
        self._result: ContactResult | None = None
        self._call: Callable[[Box], None] | None = None
        self.source: Any = style.empty_source("number", *_NAMES)
        self.columns = {
            name: models.TableColumn(
                field=name, title=title, formatter=models.NumberFormatter(format="0.[000000]")
            )
            for name, title in (("number", "spot"), *_NAMES.items())
        }
        self.columns["number"].formatter = models.NumberFormatter(format="0")
        self.columns["number"].width = 40
        self.table: Any = models.DataTable(
            source=self.source,
            columns=list(self.columns.values()),
            index_position=None,
            sortable=True,
            reorderable=False,
            selectable=True,
            height=300,
            sizing_mode="stretch_width",
            autosize_mode="force_fit",
            stylesheets=[style.CSS["GRID"]],
        )
        self.note: Any = style.make_markup()
        self.root = models.Column(self.note, self.table, sizing_mode="stretch_width")
        self.source.selected.on_change("indices", self._handle_selection)

    def set_spot_listener(self, call: Callable[[Box], None]) -> None:
        """Register ``call(box)`` for the box [m] around a selected spot."""
        self._call = call

    def clear(self) -> None:
        """Clear the table."""
        self._result = None
        style.clear_source(self.source)
        self.note.text = ""

    def show_result(self, result: ContactResult) -> None:
        """Show the contact spots of a result."""
        self._result = result
        answer = list_spots(result)
        count = answer.area.size
        units = _units(result, answer)
        with style.batch_changes(self.table.document):
            self.source.selected.indices = []
            self.source.data = {
                "number": np.arange(1, count + 1),
                **{name: _round_digits(getattr(answer, name) * units[name][0]) for name in _NAMES},
            }
            for name, title in _NAMES.items():
                self.columns[name].title = f"{title} [{units[name][1]}]"
            whole = count_noun(result.spots().count, "contact spot")
            shown = f", the {count} largest of them here" if count < result.spots().count else ""
            self.note.text = (
                f"{whole}{shown}. Select a row to see its spot; its position is that of its "
                "largest pressure."
            )

    def _handle_selection(self, attr: str, old: Any, new: Any) -> None:
        if new and self._result is not None and self._call is not None:
            self._call(box_around(self._result, int(new[0])))


def _round_digits(values: NDArray[np.float64]) -> list[float]:
    # Four digits, as in all tables; rows are sorted by the displayed value.
    return [float(f"{value:.4g}") for value in values]


_NAMES = {
    "area": "area",
    "load": "load",
    "peak": "largest pressure",
    "saturated": "saturated",
    "y": "y",
    "x": "x",
}


def _units(result: ContactResult, answer: SpotRows) -> dict[str, tuple[float, str]]:
    def largest(values: NDArray[np.float64]) -> float:
        return float(values.max(initial=0.0))

    place = prefixed_window(0.0, max(result.surface.size))
    return {
        "area": prefixed_area(largest(answer.area)),
        "load": prefixed(largest(answer.load), result.pair.load_unit),
        "peak": prefixed(largest(answer.peak), "Pa"),
        "saturated": (100.0, "%"),
        "y": place,
        "x": place,
    }


# --- Detail panels of a contact and its surface, drawn when they are opened ---


_RESULTS, _SPOTS, _PRESSURES, _SURFACE = range(4)


class DetailPanel:
    """Section below the maps, and tabs of tables and charts to the right of the maps."""

    def __init__(self, zoom: Callable[[Box], None], run: Run) -> None:
        self.section = SectionPlot()
        self._zoom, self._run = zoom, run
        self._surface: Surface | None = None
        self._result: ContactResult | None = None
        self._line: Line | None = None
        self._proposed: Line | None = None
        self.below = pn.pane.Bokeh(self.section.root, **style.BLOCK)
        self._numbers = pn.pane.HTML("", **style.WIDE)
        self._pressures = pn.pane.HTML("", **style.WIDE)
        parts = {
            "Results": self._numbers,
            "Contact spots": pn.Column(**style.BLOCK),
            "Pressures": self._pressures,
            "Surface": pn.Column(**style.BLOCK),
        }
        self._parts = list(parts.values())
        self._tabs = Tabs(parts, self._draw_tab)
        self._tabs.strip.visible = False
        self.tabs = pn.Column(self._tabs.strip, self._tabs.body, **style.BLOCK)

    @cached_property
    def spots(self) -> SpotTable:
        """Table of spots, created when it is first shown."""
        created = SpotTable()
        created.set_spot_listener(self._zoom)
        self._parts[_SPOTS].append(pn.pane.Bokeh(created.root, **style.BLOCK))
        return created

    @cached_property
    def texture(self) -> TexturePanel:
        """Height parameters and curves, created when they are first shown."""
        created = TexturePanel(self._run)
        self._parts[_SURFACE].append(created.root)
        return created

    @property
    def line(self) -> Line | None:
        """Line of the section: the requested line, or else the proposed one."""
        return self._proposed if self._line is None else self._line

    def show_contact(
        self,
        surface: Surface | None,
        result: ContactResult | None,
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
            self._numbers.object = numbers
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
        active, result = self._tabs.active, self._result
        if active == _SURFACE:
            self.texture.show_surface(self._surface)
        elif active == _PRESSURES and result is not None:
            threading.Thread(target=self._draw_pressures, args=(result,), daemon=True).start()
        elif active == _SPOTS and result is not None:
            self.spots.show_result(result)
        elif active == _SPOTS:
            self.spots.clear()

    def _draw_pressures(self, result: ContactResult) -> None:
        """Draw the distribution of the pressure, in a separate thread."""
        picture = _draw_picture(lambda: pressure_histogram(result))

        def show_picture() -> None:
            if result is self._result:
                self._pressures.object = picture

        self._run(show_picture)


# Matplotlib shares fonts and layouts between figures.
_DRAWING = threading.Lock()


def _draw_picture(draw: Callable[[], Any]) -> str:
    with _DRAWING:
        return controls.picture_markup(png(draw()))


class TexturePanel:
    """Material ratio curve, file, roughness and spectrum of a surface."""

    def __init__(self, run: Run) -> None:
        self._run = run
        self._spectrum = SpectrumPlot()
        self._numbers = pn.pane.HTML("", **style.WIDE)
        self._shown: Surface | None = None
        self._curve = pn.pane.HTML("", **style.WIDE)
        spectrum = pn.pane.Bokeh(self._spectrum.root, **style.BLOCK)
        self.root = pn.Column(self._curve, self._numbers, spectrum, **style.BLOCK)

    def show_surface(self, surface: Surface | None) -> None:
        """Show a surface as soon as its parameters are computed, in a separate thread."""
        if surface is self._shown:
            return
        self._shown = surface
        self._numbers.object = ""
        self._curve.object = ""
        self._spectrum.clear()
        if surface is not None and not surface.is_profile:
            # A large map takes seconds, which would block other pages.
            threading.Thread(target=self._work_out, args=(surface,), daemon=True).start()

    def _work_out(self, surface: Surface) -> None:
        try:
            values = surface.roughness()
        except InputError:
            # Missing points leave no point with both neighbors.
            values = {}
        file = [(row.name, row.text, "") for row in rows_of(inputs.SURFACE, surface)]
        rows = [
            (name, inputs.parameter(name, values), meaning)
            for name, (_, meaning) in inputs.ROUGHNESS.items()
        ]
        text = (
            f"<h2>File</h2>{controls.markup_table(file)}<h2>Roughness, ISO 25178-2, as "
            "prepared</h2>"
            f"{controls.markup_table(rows)}"
        )
        curve = _draw_picture(lambda: bearing_curve(surface))
        self._run(lambda: self._show_curves(surface, text, curve))

    def _show_curves(self, surface: Surface, text: str, curve: str) -> None:
        if surface is self._shown:
            self._numbers.object = text
            self._curve.object = curve
            self._spectrum.show_surface(surface)
