"""Interactive views of results: load curve, resolution study, comparison, stress."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from bokeh import models
from bokeh.plotting import figure
from bokeh.transform import dodge
from numpy.typing import NDArray

from roughcontact.analyses.solve.uncertainty_report import STUDY_COLUMNS
from roughcontact.analyses.stress import figures as stress_plots
from roughcontact.analyses.stress.fields import STRESS
from roughcontact.analyses.stress.model import StressResult
from roughcontact.analyses.sweep.fields import CURVE_COLUMNS
from roughcontact.analyses.sweep.model import LoadCurve
from roughcontact.contact.result import ContactResult
from roughcontact.desk import rasters, style
from roughcontact.desk.controls import escape_markup, markup_table
from roughcontact.desk.rasters import Box
from roughcontact.drawing.cells import pressure_colors, pressure_limit
from roughcontact.drawing.style import (
    ELASTIC,
    NEUTRAL,
    OPEN,
    OVER,
    SATURATED,
    SERIES,
    cell_max,
    field_colours,
    prefixed,
    prefixed_window,
)
from roughcontact.report.kind import listing_of, rows_of
from roughcontact.uncertainty.resolution import ResolutionStudy
from roughcontact.units import format_engineering


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


class ResolutionView:
    """Resolution study: contact on each grid, with conclusions."""

    def __init__(self) -> None:
        self.source: Any = style.empty_source("case", "contact", "saturated")
        self.plot = style.make_chart(
            "Contact on other grids", x_range=models.FactorRange(), height=240
        )
        for name, colour, place in (("contact", ELASTIC, -0.18), ("saturated", SATURATED, 0.18)):
            self.plot.vbar(
                dodge("case", place, range=self.plot.x_range),
                top=name,
                width=0.32,
                source=self.source,
                color=colour,
                line_color=None,
                legend_label=name,
            )
        style.quiet_legend(self.plot)
        self.plot.yaxis.axis_label = "share of the map [%]"
        self.plot.y_range.start = 0
        self.plot.xaxis.major_label_orientation = 0.6
        self.table: Any = style.facts_below()
        self.root = models.Column(self.plot, self.table, sizing_mode="stretch_width")

    def show_result(self, study: ResolutionStudy) -> None:
        """Show a resolution study."""
        cases = study.named()
        names = [name for name, _ in cases]
        with style.batch_changes(self.plot.document):
            self.plot.x_range.factors = names
            self.source.data = {
                "case": names,
                "contact": [100 * case.contact_fraction for _, case in cases],
                "saturated": [100 * case.saturated_fraction for _, case in cases],
            }
            heads, rows = listing_of(STUDY_COLUMNS, study)
            said = "".join(f"<p>{escape_markup(text)}</p>" for text in study.sentences)
            style.set_markup(self.table, said + markup_table(rows, heads))


class ComparisonView:
    """Pressure of two contacts, its difference, and a swipe view, with linked zoom."""

    def __init__(self, names: Sequence[str]) -> None:
        from matplotlib import colormaps

        steps = np.linspace(0, 1, 256)
        self.mapper: Any = models.LinearColorMapper(
            palette=style.color_palette(pressure_colors()), nan_color=OPEN, high_color=OVER
        )
        self.change: Any = models.LinearColorMapper(
            palette=style.color_palette(colormaps["RdBu_r"](steps)), nan_color=OPEN
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
    style.apply_style(plot)
    plot.grid.visible = False
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


# Stress below a contact: over the depth, in a section, and as a map


_DOTS = 400
# Depth range shown at first, over the depth of the largest stress.
_PROFILE_DEPTH_FACTOR = 12


class StressView:
    """Stress below a contact: profile over the depth, section, map of the largest stress."""

    def __init__(self) -> None:
        self._result: StressResult | None = None
        self._length = 1.0
        self.slider: Any = models.Slider(
            start=0,
            end=1,
            step=1,
            value=0,
            title="Depth",
            show_value=False,
            tooltips=False,
            sizing_mode="stretch_width",
            margin=(4, 12),
            stylesheets=[style.TEXT],
        )
        self.slider.on_change("value", self._slid)
        names = ("depth", "mises", "tresca", "shear")
        self.source: Any = style.empty_source(*names)
        self.mapper: Any = models.LinearColorMapper(
            palette=style.color_palette(field_colours()(np.linspace(0, 1, 256))), high_color=OVER
        )
        self.depth: Any = models.Span(dimension="height", line_color=NEUTRAL, line_dash="dashed")
        self.level: Any = models.Span(dimension="width", line_color=NEUTRAL, line_dash="dashed")
        self.strength: Any = models.Span(
            dimension="width", line_color=SERIES[1], line_dash="dotted", visible=False
        )
        self.profile = style.make_chart(
            "Largest stress at each depth", height=280, x_range=models.Range1d(0, 1)
        )
        for name, colour, dash, label in (
            ("mises", SERIES[0], "solid", "von Mises"),
            ("tresca", SERIES[1], "dashed", "Tresca"),
            ("shear", SERIES[2], "dotted", "orthogonal shear"),
        ):
            self.profile.line(
                "depth",
                name,
                source=self.source,
                line_color=colour,
                line_dash=dash,
                line_width=1.8,
                legend_label=label,
            )
        self.profile.add_layout(self.depth)
        self.profile.add_layout(self.strength)
        self.profile.y_range.start = 0
        style.quiet_legend(self.profile)
        self.cut, self.cut_source = self._picture("Section along x, at the largest stress")
        self.cut.add_layout(self.level)
        self.map, self.map_source = self._picture("Largest over all depths")
        self.map.add_layout(style.color_bar(self.mapper), "right")
        self.table: Any = style.facts_below()
        self.root = models.Column(
            self.slider,
            style.figure_grid([[self.profile, self.cut], [self.map, None]]),
            self.table,
            sizing_mode="stretch_width",
        )

    def show_result(self, result: StressResult) -> None:
        """Show the stress below a contact."""
        self._result = result
        profile = result.profile
        top, (factor, unit) = stress_plots.stress_scale(result)
        length, length_unit = prefixed(float(profile.depths[-1]), "m")
        with style.batch_changes(self.profile.document):
            self.source.data = {
                "depth": profile.depths * length,
                "mises": profile.von_mises * factor,
                "tresca": profile.tresca * factor,
                "shear": profile.orthogonal_shear.max(axis=1) * factor,
            }
            # The stress is negligible at most depths; zooming out shows all of them.
            near = (
                min(_PROFILE_DEPTH_FACTOR * profile.depth_of_max or 1.0, float(profile.depths[-1]))
                * length
            )
            self.profile.x_range.update(start=0, end=near, reset_start=0, reset_end=near)
            self.profile.xaxis.axis_label = f"depth [{length_unit}]"
            self.profile.yaxis.axis_label = f"stress [{unit}]"
            self.strength.visible = profile.yield_strength is not None
            if profile.yield_strength is not None:
                self.strength.location = profile.yield_strength * factor
            style.set_bar(self.map.right[0], 0.0, top * factor, unit)
            self._show_cut(result, factor)
            self._put_map(profile.peak, factor)
            self.map.title.text = "Largest over all depths"
            index = int(profile.von_mises.argmax())
            self.slider.update(end=max(profile.depths.size - 1, 1), value=index)
            self._mark(index)
            rows = [(row.title, row.text, row.meaning) for row in rows_of(STRESS, result)]
            style.set_markup(self.table, markup_table(rows))

    def _picture(self, title: str) -> tuple[Any, Any]:
        source = style.empty_source("x", "y", "dw", "dh", "stress")
        plot = map_picture(
            title,
            "stress",
            source,
            self.mapper,
            x_range=models.DataRange1d(range_padding=0),
            y_range=models.DataRange1d(range_padding=0, flipped=True),
        )
        return plot, source

    def _show_cut(self, result: StressResult, factor: float) -> None:
        values = result.von_mises_section("x")
        edge = result.solution.surface.pixel[1]
        columns = stress_plots.shown_columns(result, values, edge, None)
        first, last = columns.start * edge, columns.stop * edge
        depth = stress_plots.shown_depth(result, values, None, last - first)
        rows = stress_plots.section_rows(values[:, columns], result.profile.depths, depth)
        length, unit = prefixed_window(first, last)
        left, right, down = first * length, last * length, depth * length
        _put_map(self.cut_source, "stress", rows * factor, Box(0.0, left, down, right))
        self.cut.xaxis.axis_label, self.cut.yaxis.axis_label = f"x [{unit}]", f"depth [{unit}]"
        self._length = length
        assert rows.shape[0] == stress_plots.SECTION_ROWS

    def _put_map(self, values: NDArray[Any], factor: float) -> None:
        assert self._result is not None
        surface = self._result.solution.surface
        view = rasters.window_of(
            surface.shape, surface.pixel, rasters.box_of(surface), (_DOTS / 2, _DOTS / 2)
        )
        length, unit = prefixed_window(0.0, max(surface.size))
        place = Box(*(edge * length for edge in rasters.window_extent(view, surface.pixel)))
        cells = cell_max(np.asarray(values, dtype=np.float64), view.blocks)
        _put_map(self.map_source, "stress", cells * factor, place)
        self.map.xaxis.axis_label = f"x, y [{unit}], the largest stress in each cell"

    def _mark(self, index: int) -> None:
        assert self._result is not None
        profile = self._result.profile
        depth = float(profile.depths[index])
        self.depth.location = depth * prefixed(float(profile.depths[-1]), "m")[0]
        self.level.location = depth * self._length
        self.slider.title = (
            f"Depth {format_engineering(depth, 'm')}: largest von Mises stress "
            f"{format_engineering(float(profile.von_mises[index]), 'Pa')}"
        )

    def _slid(self, attr: str, old: Any, new: Any) -> None:
        if self._result is None or not 0 <= int(new) < self._result.profile.depths.size:
            return
        with style.batch_changes(self.profile.document):
            self._mark(int(new))
