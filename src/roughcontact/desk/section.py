"""A section through a contact along a line: both bodies pressed together, gap and pressure."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from bokeh.layouts import gridplot
from bokeh.models import ColumnDataSource, Range1d
from bokeh.plotting import figure
from numpy.typing import NDArray

from roughcontact.contact.result import ContactResult
from roughcontact.desk import look
from roughcontact.desk.state import Line
from roughcontact.plots.labels import doubt
from roughcontact.plots.style import ELASTIC, NEUTRAL, SATURATED, SERIES, prefixed
from roughcontact.surface.surface import Surface
from roughcontact.units import engineering, lengths

Array = NDArray[np.float64]

# Places along a line, at most: several to a dot of any screen.
_MOST = 4000


class Cut(NamedTuple):
    """The points of a map that lie nearest to evenly spaced places on a line.

    ``place`` is the distance of the places from the first end, ``step`` that between them [m].
    """

    place: Array
    step: float
    rows: NDArray[np.intp]
    columns: NDArray[np.intp]


class Bodies(NamedTuple):
    """What a section shows [SI], at its places; NaN where points are missing."""

    lower: Array
    upper: Array
    gap: Array
    pressure: Array
    saturated: NDArray[np.bool_]


def cut(surface: Surface, line: Line) -> Cut:
    """Return the points of a map along a line (y0, x0, y1, x1) [m].

    Values of a section are those of points, nothing between them is made up: an oblique line has
    those nearest to it.
    """
    y0, x0, y1, x1 = line
    length = math.hypot(y1 - y0, x1 - x0)
    edge = min(surface.pixel[1:] if surface.is_profile else surface.pixel)
    count = min(max(math.ceil(length / edge - 1e-9), 1), _MOST)
    along = (np.arange(count) + 0.5) / count
    rows, columns = (
        np.clip(np.floor((begin + (end - begin) * along) / side), 0, points - 1).astype(np.intp)
        for begin, end, side, points in zip(
            (y0, x0), (y1, x1), surface.pixel, surface.shape, strict=True
        )
    )
    return Cut(along * length, length / count, rows, columns)


def bodies(result: ContactResult, where: Cut) -> Bodies:
    """Return both bodies along a section, as they lie pressed together.

    Each is displaced by its part of the elastic displacement, that of its compliance; what lies
    between them is the gap. Heights count from the mean of the map.
    """
    at = where.rows, where.columns
    surface, pair = result.surface, result.pair
    gap = result.gap[at]
    y, x = ((n + 0.5) * edge - side / 2
            for n, edge, side in zip(at, surface.pixel, surface.size, strict=True))  # fmt: skip
    tilted = result.tilt[0] * y + result.tilt[1] * x
    moved = gap - result.initial_gap[at] - tilted + result.approach
    share = pair.material.compliance * pair.contact_modulus
    lower = surface.heights[at] - np.nanmean(surface.heights) - share * moved
    pressure = result.pressure[at]
    ceiling = math.inf if result.ceiling is None else result.ceiling
    saturated = pressure >= np.broadcast_to(ceiling, result.pressure.shape)[at]
    return Bodies(lower, lower + gap, gap, pressure, saturated)


def whole_line(surface: Surface) -> Line:
    """Return a line along x through the highest point of a map."""
    heights = surface.heights
    row = 0 if np.isnan(heights).all() else int(np.nanargmax(heights)) // heights.shape[1]
    y = (row + 0.5) * surface.pixel[0]
    return (y, 0.0, y, surface.size[1])


class Section:
    """Heights of both bodies above, pressure below, along a line from A to B."""

    def __init__(self) -> None:
        self.source: Any = ColumnDataSource(_EMPTY)
        self.bars: Any = ColumnDataSource(_NO_BARS)
        self.along: Any = Range1d(start=0, end=1)
        self.heights, self.pressure = _plots(self.along, self.source, self.bars)
        self.root = gridplot(
            [[self.heights], [self.pressure]], merge_tools=True, toolbar_location="above",
            sizing_mode="stretch_width", toolbar_options={"logo": None},
        )  # fmt: skip
        self.clear()

    def clear(self) -> None:
        """Show nothing."""
        self.source.data, self.bars.data = dict(_EMPTY), dict(_NO_BARS)
        self.heights.title.text, self.pressure.title.text = "Section", ""

    def show(self, surface: Surface, result: ContactResult | None, line: Line) -> None:
        """Show the bodies along a line; without a result, the surface alone."""
        with look.together(self.heights.document):
            where = cut(surface, line)
            if result is None:
                self._show_surface(surface, where)
            else:
                self._show_contact(bodies(result, where), where, doubt(result))
            self._name(surface, line, where)

    def _show_surface(self, surface: Surface, where: Cut) -> None:
        heights = surface.heights[where.rows, where.columns] - np.nanmean(surface.heights)
        none = np.full(heights.shape, np.nan)
        found = Bodies(heights, none, none, np.zeros(heights.shape), np.zeros(heights.shape, bool))
        self._show_contact(found, where, "")

    def _show_contact(self, found: Bodies, where: Cut, doubtful: str) -> None:
        length = float(where.place[-1] + where.step / 2)
        factor, unit = prefixed(length, "m")
        tall = np.concatenate([found.lower, found.upper])
        scale, height_unit = prefixed(float(np.nanmax(np.abs(tall), initial=0.0)), "m")
        largest = float(found.pressure.max(initial=0.0))
        press, pressure_unit = prefixed(largest, "Pa")
        flows = found.saturated & (found.gap < 0)
        self.source.data = {
            "place": where.place * factor,
            "lower": found.lower * scale,
            "upper": found.upper * scale,
            "gap": found.gap * scale,
            "pressure": found.pressure * press,
            "open": np.where(found.gap > 0, found.upper, found.lower) * scale,
            "flows": np.where(flows, found.upper, found.lower) * scale,
        }
        touching = found.pressure > 0
        place = where.place[touching] * factor
        half = where.step / 2 * factor
        self.bars.data = {
            "left": place - half,
            "right": place + half,
            "top": found.pressure[touching] * press,
            "colour": np.where(found.saturated[touching], SATURATED, ELASTIC),
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
        look.hover_units(
            self.heights.hover[0], [unit, height_unit, height_unit, height_unit, pressure_unit]
        )
        share = float(np.count_nonzero(touching)) / touching.size
        self.pressure.title.text = (
            f"Pressure, largest {engineering(largest, 'Pa')}, {100 * share:.3g} % of the line "
            f"touches{doubtful}"
        )

    def _name(self, surface: Surface, line: Line, where: Cut) -> None:
        y0, x0, y1, x1 = line
        if surface.is_profile:
            ends = f"from x {engineering(x0, 'm')} to {engineering(x1, 'm')}"
        else:
            ends = f"from y, x = {lengths((y0, x0), ', ')} to {lengths((y1, x1), ', ')}"
        oblique = not surface.is_profile and y0 != y1 and x0 != x1
        nearest = ", at the points nearest to it" if oblique else ""
        self.heights.title.text = f"Section {ends}{nearest}"


def _plots(along: Any, source: Any, bars: Any) -> tuple[Any, Any]:
    """Return the figures of heights and of pressure."""
    tools = "xpan,xwheel_zoom,xbox_zoom,reset"
    heights: Any = figure(
        x_range=along, y_range=Range1d(0, 1), height=210, sizing_mode="stretch_width", tools=tools,
        title="Section", min_border_left=64, min_border_right=8,
    )  # fmt: skip
    heights.varea("place", "lower", "open", source=source, color="#dcebf5", legend_label="gap")
    heights.varea(
        "place", "flows", "lower", source=source, color=SATURATED,
        legend_label="has to flow away (saturated)",
    )  # fmt: skip
    heights.line(
        "place", "upper", source=source, color=NEUTRAL, line_width=1.4, legend_label="counter-body"
    )
    lower = heights.line(
        "place", "lower", source=source, color=SERIES[0], line_width=1.6, legend_label="body"
    )
    told = ("along the line", "place"), ("body", "lower"), ("counter-body", "upper")
    look.hover(heights, lower, (*told, ("gap", "gap"), ("pressure", "pressure"))).mode = "vline"
    pressure: Any = figure(
        x_range=along, y_range=Range1d(0, 1), height=150, sizing_mode="stretch_width",
        tools=tools, title="",
        min_border_left=64, min_border_right=8,
    )  # fmt: skip
    pressure.quad(
        left="left", right="right", top="top", bottom=0, color="colour", line_color=None,
        source=bars,
    )  # fmt: skip
    for plot in (heights, pressure):
        look.quiet(plot)
    look.quiet_legend(heights)
    return heights, pressure


_EMPTY: dict[str, list[float]] = {
    name: [] for name in ("place", "lower", "upper", "gap", "pressure", "open", "flows")
}
_NO_BARS: dict[str, list[float]] = {name: [] for name in ("left", "right", "top", "colour")}
