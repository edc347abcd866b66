"""Interactive views of results: load curve and comparison of two contacts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from bokeh import models
from bokeh.plotting import figure
from numpy.typing import NDArray

from roughcontact.analyses.sweep.fields import CURVE_COLUMNS
from roughcontact.analyses.sweep.model import LoadCurve
from roughcontact.contact.result import ContactResult
from roughcontact.desk import rasters, style
from roughcontact.desk.controls import markup_table
from roughcontact.desk.rasters import Box
from roughcontact.drawing.cells import pressure_colors, pressure_limit
from roughcontact.drawing.style import NEUTRAL, OVER, SATURATED, SERIES, prefixed, prefixed_window
from roughcontact.report.kind import listing_of


class LoadCurveView:
    """Load curve: areas, gap and stiffness over the load, with the current load marked.

    Loads are forces, or nominal pressures of a map if ``over_pressure``.
    """

    def __init__(self, over_pressure: bool = False) -> None:
        self._over_pressure = over_pressure
        names = ("load", "contact", "saturated", "gap", "approach", "stiffness")
        self.source: Any = style.empty_source(*names)
        self.now: Any = models.Span(
            dimension="height",
            line_color=NEUTRAL,
            line_width=1.5,
            line_dash="dashed",
            visible=False,
        )
        self._load, self._factor = math.nan, 1.0
        log: dict[str, Any] = {"x_axis_type": "log"}
        self.area = style.make_chart("Contact and saturated area", y_axis_type="log", **log)
        self.lengths = style.make_chart("Approach and mean gap", x_range=self.area.x_range, **log)
        self.stiffness = style.make_chart(
            "Contact stiffness", y_axis_type="log", x_range=self.area.x_range, **log
        )
        for plot, name, colour, label in (
            (self.area, "contact", SERIES[0], "contact"),
            (self.area, "saturated", SATURATED, "saturated"),
            (self.lengths, "approach", SERIES[0], "approach"),
            (self.lengths, "gap", SERIES[1], "mean gap"),
            (self.stiffness, "stiffness", SERIES[0], "stiffness"),
        ):
            where = {"source": self.source, "legend_label": label, "color": colour}
            plot.line("load", name, line_width=1.6, **where)
            plot.scatter("load", name, size=6, **where)
        self.plots = (self.area, self.lengths, self.stiffness)
        for plot in self.plots:
            style.quiet_legend(plot)
            plot.add_layout(self.now)
        self.area.yaxis.axis_label = "share of the map [%]"
        self.table: Any = style.facts_below()
        self.root = models.Column(
            style.figure_grid([[self.area, self.lengths], [self.stiffness, None]]),
            self.table,
            sizing_mode="stretch_width",
        )

    def show_result(self, curve: LoadCurve) -> None:
        """Show a load curve."""
        load = curve.column("load")
        unit = "N/m" if curve.is_profile else "N"
        over_pressure = self._over_pressure and not curve.is_profile
        size = curve.nominal_area if over_pressure else 1.0
        self._factor, shown = prefixed(float(load.max()) / size, "Pa" if over_pressure else unit)
        self._factor /= size
        lengths = np.concatenate([curve.column("approach"), curve.column("mean_gap")])
        scale, length_unit = prefixed(float(lengths.max()), "m")
        stiffness = curve.column("stiffness")
        # Zero for saturated contact alone, unbounded for full periodic contact: not drawn.
        stiffness[~(np.isfinite(stiffness) & (stiffness > 0))] = np.nan
        stiff, stiffness_unit = prefixed(float(np.nanmax(stiffness, initial=0.0)), f"{unit}/m")
        shares = (
            100 * curve.column(f"{name}_area") / curve.nominal_area
            for name in ("contact", "saturated")
        )
        contact, saturated = (np.where(share > 0, share, np.nan) for share in shares)
        with style.batch_changes(self.area.document):
            self.source.data = {
                "load": load * self._factor,
                "contact": contact,
                "saturated": saturated,
                "gap": curve.column("mean_gap") * scale,
                "approach": curve.column("approach") * scale,
                "stiffness": stiffness * stiff,
            }
            for plot in self.plots:
                name = "nominal pressure" if over_pressure else "load"
                plot.xaxis.axis_label = f"{name} [{shown}]"
            self.lengths.yaxis.axis_label = f"length [{length_unit}]"
            self.stiffness.yaxis.axis_label = f"stiffness dW/dω [{stiffness_unit}]"
            heads, rows = listing_of(CURVE_COLUMNS, curve, brief=True)
            style.set_markup(self.table, markup_table(rows, heads))
            self.mark(self._load)

    def mark(self, load: float) -> None:
        """Mark the current load [N]."""
        self._load = load
        self.now.visible = load > 0
        if load > 0:
            self.now.location = load * self._factor


# Maximum number of cells along each side of a compared map.
_DOTS = 400


class ComparisonView:
    """Pressure of two contacts, its difference, and a swipe view, with linked zoom."""

    def __init__(self, names: Sequence[str]) -> None:
        from matplotlib import colormaps

        steps = np.linspace(0, 1, 256)
        self.mapper: Any = models.LinearColorMapper(
            palette=style.color_palette(pressure_colors()), nan_color=rasters.CLEAR, high_color=OVER
        )
        self.change: Any = models.LinearColorMapper(
            palette=style.color_palette(colormaps["RdBu_r"](steps)), nan_color=rasters.CLEAR
        )
        titles = (*(f"Pressure, {name}" for name in names), " − ".join(names), " | ".join(names))
        mappers = (self.mapper, self.mapper, self.change, self.mapper)
        ranges = {
            "x_range": models.DataRange1d(range_padding=0),
            "y_range": models.DataRange1d(range_padding=0, flipped=True),
        }
        self.sources = [style.empty_source("x", "y", "dw", "dh", "pressure") for _ in titles]
        self.plots = [
            map_picture(title, "pressure", source, mapper, **ranges)
            for title, source, mapper in zip(titles, self.sources, mappers, strict=True)
        ]
        for plot in self.plots[1:3]:
            plot.add_layout(style.color_bar(plot.renderers[0].glyph.color_mapper), "right")
        self.swiped: Any = style.empty_source(*self.sources[0].data)
        over: Any = self.plots[3]
        over.image("pressure", "x", "y", "dw", "dh", source=self.swiped, color_mapper=self.mapper)
        self.edge: Any = models.Span(dimension="height", line_color=NEUTRAL, line_width=2)
        over.add_layout(self.edge)
        self.swipe: Any = models.Slider(
            start=0,
            end=100,
            step=1,
            value=50,
            title="Swipe",
            show_value=False,
            tooltips=False,
            sizing_mode="stretch_width",
            margin=(4, 12),
            stylesheets=[style.TEXT],
        )
        self.swipe.on_change("value", lambda attr, old, new: self._swipe(new))
        self.root = models.Column(
            style.figure_grid([self.plots[:2], self.plots[2:]]),
            self.swipe,
            sizing_mode="stretch_width",
        )

    def _swipe(self, percent: float) -> None:
        """Show the second contact from a place on, in percent of its width."""
        data = self.sources[1].data
        values, wide = data["pressure"][0], data["dw"][0]
        first = min(round(percent / 100 * values.shape[1]), values.shape[1] - 1)
        place = wide * first / values.shape[1]
        with style.batch_changes(self.swipe.document):
            self.swiped.data = {
                **data,
                "x": [data["x"][0] + place],
                "dw": [wide - place],
                "pressure": [values[:, first:]],
            }
            self.edge.location = data["x"][0] + place

    def show_contacts(self, results: Sequence[ContactResult]) -> None:
        """Show two contacts, without the difference if their grids differ."""
        top = pressure_limit(results)
        factor, unit = prefixed(top, "Pa")
        length, length_unit = prefixed_window(0.0, max(results[0].surface.size))
        values = []
        for result, source in zip(results, self.sources, strict=False):
            surface = result.surface
            view = rasters.window_of(
                surface.shape, surface.pixel, rasters.box_of(surface), (_DOTS, _DOTS)
            )
            place = rasters.window_extent(view, surface.pixel)
            values.append(
                rasters.largest_pressure(rasters.result_window(result, view)) * np.float32(factor)
            )
            _put_map(source, "pressure", values[-1], Box(*(edge * length for edge in place)))
        self.sources[3].data = dict(self.sources[0].data)
        self._swipe(self.swipe.value)
        style.set_bar(self.plots[1].right[0], 0.0, top * factor, unit)
        first, other = (np.nan_to_num(value) for value in values)
        self.plots[2].visible = first.shape == other.shape
        if self.plots[2].visible:
            change = np.where((first == 0) & (other == 0), np.nan, first - other)
            _put_map(self.sources[2], "pressure", change, Box(*(edge * length for edge in place)))
            most = float(np.nanmax(np.abs(change), initial=0.0)) or 1.0
            style.set_bar(self.plots[2].right[0], -most, most, unit)
        for plot in self.plots:
            plot.xaxis.axis_label = f"x, y [{length_unit}]"


def map_picture(title: str, name: str, source: Any, mapper: Any, **ranges: Any) -> Any:
    """Return a figure of values on a map, with equal scales of x and y."""
    plot: Any = figure(
        title=title,
        height=340,
        sizing_mode="stretch_width",
        match_aspect=True,
        tools="pan,wheel_zoom,box_zoom,reset",
        active_scroll=None,
        min_border_left=50,
        min_border_right=64,
        **ranges,
    )
    style.apply_style(plot, is_map=True)
    plot.image(name, "x", "y", "dw", "dh", source=source, color_mapper=mapper)
    return plot


def _put_map(source: Any, name: str, values: NDArray[Any], place: Box) -> None:
    source.data = {
        "x": [place.left],
        "y": [place.top],
        "dw": [place.right - place.left],
        "dh": [place.bottom - place.top],
        name: [values.astype(np.float32)],
    }
