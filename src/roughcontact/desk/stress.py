"""Stress below a contact: against the depth, on a plane, and on a map at a depth one chooses."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from bokeh.layouts import gridplot
from bokeh.models import (
    Column,
    ColumnDataSource,
    DataRange1d,
    LinearColorMapper,
    Range1d,
    Slider,
    Span,
)
from bokeh.plotting import figure
from numpy.typing import NDArray

from roughcontact.contact.stress import StressResult
from roughcontact.desk import look, pictures
from roughcontact.desk.headline import table
from roughcontact.plots.stress import (
    SECTION_ROWS,
    section_rows,
    shown_columns,
    shown_depth,
    stress_colours,
    stress_scale,
)
from roughcontact.plots.style import NEUTRAL, OVER, SERIES, cell_max, prefixed, prefixed_window
from roughcontact.report.quantities import rows_of
from roughcontact.report.tables import STRESS
from roughcontact.units import engineering

_DOTS = 400
# The profile begins with so many times the depth of the largest stress.
_NEAR = 12


class Stress:
    """Von Mises stress: profile over the depth, section through its maximum, map at a depth.

    The slider moves through the depths of the result; ``on_depth`` hears of each, and `show_map`
    takes the map there. Before, the map is that of the largest stress over all depths.
    """

    def __init__(self) -> None:
        self._result: StressResult | None = None
        self._call: Callable[[float], None] | None = None
        self._length = 1.0
        self.slider: Any = Slider(
            start=0, end=1, step=1, value=0, title="Depth", show_value=False, tooltips=False,
            sizing_mode="stretch_width", margin=(4, 12),
        )  # fmt: skip
        self.slider.on_change("value", self._slid)
        names = ("depth", "mises", "tresca", "shear")
        self.source: Any = ColumnDataSource({name: [] for name in names})
        self.mapper: Any = LinearColorMapper(
            palette=look.palette(stress_colours()(np.linspace(0, 1, 256))), high_color=OVER,
        )  # fmt: skip
        self.depth: Any = Span(dimension="height", line_color=NEUTRAL, line_dash="dashed")
        self.level: Any = Span(dimension="width", line_color=NEUTRAL, line_dash="dashed")
        self.strength: Any = Span(
            dimension="width", line_color=SERIES[1], line_dash="dotted", visible=False
        )
        self.profile = look.chart("Largest stress at each depth", height=280, x_range=Range1d(0, 1))
        for name, colour, dash, label in (
            ("mises", SERIES[0], "solid", "von Mises"),
            ("tresca", SERIES[1], "dashed", "Tresca"),
            ("shear", SERIES[2], "dotted", "orthogonal shear"),
        ):
            self.profile.line(
                "depth", name, source=self.source, line_color=colour, line_dash=dash,
                line_width=1.8, legend_label=label,
            )  # fmt: skip
        self.profile.add_layout(self.depth)
        self.profile.add_layout(self.strength)
        self.profile.y_range.start = 0
        look.quiet_legend(self.profile)
        self.cut, self.cut_source = self._picture("Section along x, at the largest stress")
        self.cut.add_layout(self.level)
        self.map, self.map_source = self._picture("Largest over all depths")
        self.map.add_layout(look.bar_of(self.mapper), "right")
        self.table: Any = look.markup(sizing_mode="stretch_width", margin=(4, 8))
        grid = gridplot(
            [[self.profile, self.cut], [self.map, None]], merge_tools=True,
            toolbar_location="above", sizing_mode="stretch_width", toolbar_options={"logo": None},
        )  # fmt: skip
        grid.cols = "minmax(0, 1fr)"
        self.root = Column(self.slider, grid, self.table, sizing_mode="stretch_width")

    def on_depth(self, call: Callable[[float], None]) -> None:
        """Have ``call(depth)`` called with a depth [m] that one chooses."""
        self._call = call

    def clear(self) -> None:
        """Show nothing."""
        self._result = None
        for source in (self.source, self.cut_source, self.map_source):
            source.data = {name: [] for name in source.data}
        look.put(self.table, "")

    def show(self, result: StressResult) -> None:
        """Show the stress below a contact."""
        self._result = result
        profile = result.profile
        top, (factor, unit) = stress_scale(result)
        length, length_unit = prefixed(float(profile.depths[-1]), "m")
        with look.together(self.profile.document):
            self.source.data = {
                "depth": profile.depths * length, "mises": profile.von_mises * factor,
                "tresca": profile.tresca * factor,
                "shear": profile.orthogonal_shear.max(axis=1) * factor,
            }  # fmt: skip
            # Most of the depth there is next to nothing; who wants to see it zooms out.
            near = min(_NEAR * profile.depth_of_max or 1.0, float(profile.depths[-1])) * length
            self.profile.x_range.update(start=0, end=near, reset_start=0, reset_end=near)
            self.profile.xaxis.axis_label = f"depth [{length_unit}]"
            self.profile.yaxis.axis_label = f"stress [{unit}]"
            self.strength.visible = profile.yield_strength is not None
            if profile.yield_strength is not None:
                self.strength.location = profile.yield_strength * factor
            look.set_bar(self.map.right[0], 0.0, top * factor, unit)
            self._show_cut(result, factor)
            self._put_map(profile.peak, factor)
            self.map.title.text = "Largest over all depths"
            at = int(profile.von_mises.argmax())
            self.slider.update(end=max(profile.depths.size - 1, 1), value=at)
            self._mark(at)
            rows = [(row.title, row.text, row.meaning) for row in rows_of(STRESS, result)]
            look.put(self.table, table(rows))

    def show_map(self, values: NDArray[Any], depth: float) -> None:
        """Show the von Mises stress [Pa] at a depth [m], shape (ny, nx)."""
        assert self._result is not None
        with look.together(self.map.document):
            self._put_map(values, stress_scale(self._result)[1][0])
            self.map.title.text = f"At depth {engineering(depth, 'm')}"

    def _picture(self, title: str) -> tuple[Any, Any]:
        source = ColumnDataSource({name: [] for name in ("x", "y", "dw", "dh", "stress")})
        # The browser itself keeps it true to scale.
        plot: Any = figure(
            title=title, height=280, sizing_mode="stretch_width", match_aspect=True,
            x_range=DataRange1d(range_padding=0),
            y_range=DataRange1d(range_padding=0, flipped=True),
            tools="pan,wheel_zoom,box_zoom,reset", active_scroll=None, min_border_left=50,
            min_border_right=64,
        )  # fmt: skip
        look.quiet(plot)
        plot.grid.visible = False
        plot.image("stress", "x", "y", "dw", "dh", source=source, color_mapper=self.mapper)
        return plot, source

    def _show_cut(self, result: StressResult, factor: float) -> None:
        values = result.von_mises_section("x")
        edge = result.solution.surface.pixel[1]
        columns = shown_columns(result, values, edge, None)
        first, last = columns.start * edge, columns.stop * edge
        depth = shown_depth(result, values, None, last - first)
        rows = section_rows(values[:, columns], result.profile.depths, depth)
        length, unit = prefixed_window(first, last)
        left, right, down = first * length, last * length, depth * length
        self._put(self.cut_source, rows * factor, (left, 0.0, right - left, down))
        self.cut.xaxis.axis_label, self.cut.yaxis.axis_label = f"x [{unit}]", f"depth [{unit}]"
        self._length = length
        assert rows.shape[0] == SECTION_ROWS

    def _put_map(self, values: NDArray[Any], factor: float) -> None:
        assert self._result is not None
        surface = self._result.solution.surface
        view = pictures.window(
            surface.shape, surface.pixel, pictures.box_of(surface), (_DOTS / 2, _DOTS / 2)
        )
        length, unit = prefixed_window(0.0, max(surface.size))
        top, left, bottom, right = (edge * length for edge in pictures.extent(view, surface.pixel))
        cells = cell_max(np.asarray(values, dtype=np.float64), view.blocks)
        self._put(self.map_source, cells * factor, (left, top, right - left, bottom - top))
        self.map.xaxis.axis_label = f"x, y [{unit}], the largest stress in each cell"

    def _put(
        self, source: Any, values: NDArray[Any], place: tuple[float, float, float, float]
    ) -> None:
        x, y, dw, dh = place
        source.data = {
            "x": [x], "y": [y], "dw": [dw], "dh": [dh], "stress": [values.astype(np.float32)]
        }  # fmt: skip

    def _mark(self, at: int) -> None:
        assert self._result is not None
        profile = self._result.profile
        depth = float(profile.depths[at])
        self.depth.location = depth * prefixed(float(profile.depths[-1]), "m")[0]
        self.level.location = depth * self._length
        self.slider.title = (
            f"Depth {engineering(depth, 'm')}: largest von Mises stress "
            f"{engineering(float(profile.von_mises[at]), 'Pa')}"
        )

    def _slid(self, attr: str, old: Any, new: Any) -> None:
        if self._result is None or not 0 <= int(new) < self._result.profile.depths.size:
            return
        with look.together(self.profile.document):
            self._mark(int(new))
        if self._call is not None:
            self._call(float(self._result.profile.depths[int(new)]))
