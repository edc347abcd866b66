"""Style of the page: one style sheet, without external fonts."""

from __future__ import annotations

import html
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from bokeh.models import Axis, ColorBar, Column, ColumnDataSource, Div, FixedTicker, HoverTool
from bokeh.plotting import figure
from bokeh.themes import Theme
from numpy.typing import NDArray
from panel.io.document import hold
from panel.io.state import state

from roughcontact.desk.tokens import FONT, INK, read_sheets
from roughcontact.drawing.style import OPEN

CSS = read_sheets(OPEN=OPEN)
"""Style sheets of the page by name; the color scheme of the system selects light or dark."""

TEXT = CSS["TEXT"]
STEP = CSS["FOLD"] + CSS["STEP"]

# Also in the style sheets.
LEFT, WRAPPED, NARROW = 272, 1240, 1560
"""Width of the left column, of a header of one line, of a window with tables right of its maps."""

NEW, OLD = {"opacity": "1"}, {"opacity": "0.45", "transition": "opacity .2s .4s"}
"""Styles of current and outdated results; the delay hides a quick update."""

SHEETS: dict[str, Any] = {"stylesheets": [TEXT]}
SHEET: dict[str, Any] = {"stylesheets": [TEXT], "margin": (0, 0)}
BLOCK: dict[str, Any] = {"sizing_mode": "stretch_width", "margin": (0, 0, 4, 0)}
CONTROL: dict[str, Any] = {
    "stylesheets": [TEXT],
    "sizing_mode": "stretch_width",
    "margin": (0, 0, 4, 0),
}
# Content higher than its column makes the column scroll, without overlap.
TALL = ":host { max-height: none !important; }"
WIDE: dict[str, Any] = {
    "stylesheets": [TEXT, TALL],
    "sizing_mode": "stretch_width",
    "margin": (0, 0, 6, 0),
}
HIGH: dict[str, Any] = {"stylesheets": [TALL], "sizing_mode": "stretch_width"}
TABS: dict[str, Any] = {"stylesheets": [TEXT], "sizing_mode": "stretch_both", "margin": (4, 0)}
STRIP: dict[str, Any] = {"sizing_mode": "stretch_width", "margin": (0, 0, 6, 0)}
BUTTON: dict[str, Any] = {"stylesheets": [TEXT], "margin": (0, 6, 4, 0)}


# --- Style of figures on the page, and changes in place ---


TEXT_SIZE, SMALL = "12px", "11px"

_GROUND = {False: OPEN, True: "#262c34"}
_COLORS = {False: (INK, "#e4e4e4", "#b8b8b8"), True: ("#e8ebef", "#2b313a", "#6d7885")}


def theme(dark: bool) -> Theme:
    """Return the colors of axes, grids, titles and legends of figures."""
    text, grid, frame = _COLORS[dark]
    axis = dict.fromkeys(("axis_label_text_color", "major_label_text_color"), text)
    return Theme(
        json={
            "attrs": {
                "Plot": {"outline_line_color": frame, "background_fill_color": _GROUND[dark]},
                "Axis": {**axis, "major_tick_line_color": frame},
                "Grid": {"grid_line_color": grid},
                "Title": {"text_color": text},
                "Legend": {"label_text_color": text},
                "BaseColorBar": {"major_label_text_color": text},
            }
        }
    )


def apply_style(plot: Any, is_map: bool = False) -> None:
    """Apply the fonts and colors of the page to a figure; a map has the ground of the theme."""
    plot.title.text_font = FONT
    plot.title.text_font_size = TEXT_SIZE
    plot.title.text_font_style = "bold"
    plot.title.offset = 0
    plot.grid.visible = not is_map
    if not is_map:
        plot.background_fill_color = None
    plot.border_fill_color = None
    for axis in plot.select(Axis):
        axis.axis_label_text_font = axis.major_label_text_font = FONT
        axis.axis_label_text_font_size = axis.major_label_text_font_size = SMALL
        axis.axis_label_text_font_style = "normal"
        axis.axis_label_standoff = 4
        axis.axis_line_color = None
        axis.minor_tick_line_color = None
    plot.toolbar.logo = None


def make_chart(title: str, height: int = 260, **options: Any) -> Any:
    """Return an empty chart in the style of the page."""
    plot: Any = figure(
        title=title,
        height=height,
        sizing_mode="stretch_width",
        min_border_left=60,
        tools="pan,box_zoom,wheel_zoom,reset",
        active_scroll=None,
        **options,
    )
    apply_style(plot)
    return plot


def empty_source(*names: str) -> Any:
    """Return a data source with empty columns."""
    return ColumnDataSource({name: [] for name in names})


def clear_source(*sources: Any) -> None:
    """Remove the values of data sources."""
    for item in sources:
        item.data = {name: [] for name in item.data}


def with_note(plot: Any) -> tuple[Any, Any]:
    """Return a column of a figure and a markup model, and this model."""
    plot.toolbar.autohide = True
    note = make_markup(margin=(0, 8, 4, 60))
    return Column(plot, note, sizing_mode="stretch_width"), note


def add_hover(plot: Any, drawn: Any, text: Sequence[tuple[str, str]]) -> Any:
    """Add a hover tool that shows columns by name; `hover_units` sets the units."""
    tool: Any = HoverTool(
        renderers=[drawn],
        tooltips=[(name, f"@{{{column}}}{{%0.4g}}") for name, column in text],
        formatters={f"@{{{column}}}": "printf" for _, column in text},
    )
    plot.add_tools(tool)
    return tool


def hover_units(tool: Any, units: Sequence[str]) -> None:
    """Set the units of the hover tool."""
    tool.tooltips = [
        (name, f"{text.partition(' ')[0]} {unit}")
        for (name, text), unit in zip(tool.tooltips, units, strict=True)
    ]


def quiet_legend(plot: Any) -> None:
    """Move the legend of a figure above the figure, in one line."""
    legend = plot.legend[0]
    plot.add_layout(legend, "above")
    legend.orientation = "horizontal"
    legend.label_text_font = FONT
    legend.label_text_font_size = SMALL
    legend.border_line_color = None
    legend.background_fill_color = None
    legend.padding = legend.margin = 2
    legend.spacing = 12
    legend.glyph_height = legend.glyph_width = 16
    legend.click_policy = "hide"
    legend.location = "left"


def color_bar(mapper: Any) -> Any:
    """Return the color bar of a map."""
    return ColorBar(
        color_mapper=mapper,
        width=9,
        padding=2,
        label_standoff=4,
        bar_line_color=None,
        background_fill_color=None,
        major_tick_line_color=None,
        major_label_text_font=FONT,
        major_label_text_font_size=SMALL,
        ticker=FixedTicker(ticks=[]),
    )


def set_bar(bar: Any, low: float, high: float, unit: str) -> None:
    """Set the limits and ticks of a color bar, with the unit at the uppermost tick."""
    from matplotlib.ticker import MaxNLocator

    bar.color_mapper.update(low=low, high=high)
    edge = 1e-9 * (high - low)
    result = MaxNLocator(5).tick_values(low, high)
    ticks = [float(f"{tick:.6g}") for tick in result if low - edge <= tick <= high + edge]
    labels = {tick: f"{tick:g}".replace("-", "−") for tick in ticks}
    if ticks:
        labels[ticks[-1]] += f" {unit}"
    bar.ticker.ticks = ticks
    bar.major_label_overrides = labels


def color_palette(colours: NDArray[np.float64]) -> list[str]:
    """Return colors, an array of red, green and blue along the last axis, as hex texts."""
    levels = np.rint(np.asarray(colours)[:, :3] * 255).astype(int)
    return [f"#{red:02x}{green:02x}{blue:02x}" for red, green, blue in levels]


def color_patch(colour: str, text: str) -> str:
    """Return a sample of a color with its escaped name, as markup."""
    return (
        f'<span style="display:inline-block;width:11px;height:11px;margin-right:5px;'
        f'border:1px solid #999;vertical-align:-1px;background:{colour}"></span>'
        f"{html.escape(text)}"
    )


def make_markup(**options: Any) -> Any:
    """Return an empty markup model."""
    return Div(disable_math=True, stylesheets=[TEXT], sizing_mode="stretch_width", **options)


@contextmanager
def batch_changes(document: Any) -> Iterator[None]:
    """Send the changes of a block to the browser at its end, as one message."""
    # Changes held before the page reports to be ready would never be sent.
    if document is None or not state.loaded:
        yield
        return
    with hold(document):
        yield


class Debounced:
    """Action that runs once for several calls, some milliseconds after the first."""

    def __init__(self, model: Any, action: Callable[[], None], milliseconds: int = 40) -> None:
        self.model, self.action, self.milliseconds = model, action, milliseconds
        self._waits = False

    def __call__(self) -> None:
        """Schedule the action; run it at once without a browser."""
        document = self.model.document
        if document is None or document.session_context is None:
            self.action()
        elif not self._waits:
            self._waits = True
            document.add_timeout_callback(self._run, self.milliseconds)

    def _run(self) -> None:
        self._waits = False
        self.action()


def watch_changes(model: Any, names: Sequence[str], call: Callable[[], None]) -> None:
    """Register a function for changes of some properties of a model."""

    def changed(attr: str, old: Any, new: Any) -> None:
        call()

    for name in names:
        model.on_change(name, changed)
