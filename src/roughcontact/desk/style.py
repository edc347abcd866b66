"""How the page looks: one sheet, no fonts and nothing else from elsewhere."""

from __future__ import annotations

import html
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from bokeh.core.property.descriptors import UnsetValueError
from bokeh.layouts import gridplot
from bokeh.models import Axis, ColorBar, Column, ColumnDataSource, FixedTicker, HoverTool
from bokeh.plotting import figure
from numpy.typing import NDArray
from panel.io.document import hold
from panel.io.state import state
from panel.models import HTML

INK, QUIET, LINE, GROUND, ACCENT = "#1f2328", "#59636e", "#d8dee4", "#f6f8fa", "#1f6feb"
WARNING, CAUTION = "#b42318", "#8a5a00"
SIDE = 336
"""Width of the column of controls."""

FONT = 'system-ui, -apple-system, "Segoe UI", Roboto, "Liberation Sans", sans-serif'

TEXT = f"""
:host {{ font-family: {FONT}; font-size: 13px; color: {INK}; }}
.bk-input, .bk-btn, label, .bk-input-group {{ font-family: {FONT}; font-size: 13px; }}
.bk-input {{ border-radius: 5px; border-color: {LINE}; }}
.bk-input:focus {{ border-color: {ACCENT}; outline: 2px solid {ACCENT}33; }}
.wrong, :host(.wrong) {{ color: {WARNING}; font-size: 12px; }}
h1 {{ font-size: 16px; margin: 6px 14px 0 0; font-weight: 600; }}
h2 {{ font-size: 12px; margin: 0 0 4px; font-weight: 600; color: {QUIET};
  text-transform: uppercase; letter-spacing: .05em; }}
p {{ margin: 0 0 6px; }}
.quiet {{ color: {QUIET}; }}
progress {{ height: 6px; }}
.fold {{ font-size: 13px; color: {ACCENT}; }}
.numbers {{ display: flex; flex-wrap: wrap; gap: 4px 22px; }}
.numbers div {{ display: flex; flex-direction: column; }}
.numbers dt {{ color: {QUIET}; font-size: 11px; }}
.numbers dd {{ margin: 0; font-size: 15px; font-weight: 600; font-variant-numeric: tabular-nums; }}
table {{ border-collapse: collapse; font-variant-numeric: tabular-nums; }}
td, th {{ padding: 2px 12px 2px 0; text-align: left; vertical-align: top; font-weight: 400; }}
th {{ color: {QUIET}; }}
tr + tr td {{ border-top: 1px solid {LINE}; }}
ul.cautions {{ margin: 0; padding: 0; list-style: none; max-height: 78px; overflow-y: auto; }}
ul.cautions li {{ margin: 0 0 2px; padding-left: 8px; border-left: 3px solid {LINE}; }}
ul.cautions li.warning {{ border-color: {WARNING}; }}
ul.cautions li.caution {{ border-color: {CAUTION}; }}
ul.cautions b {{ font-weight: 600; }}
.good {{ color: #1a7f37; }} .bad {{ color: {WARNING}; }}
pre {{ background: {GROUND}; border: 1px solid {LINE}; border-radius: 5px; padding: 8px;
  overflow-x: auto; font-size: 12px; white-space: pre-wrap; }}
"""

FOLD = f"""
:host(.card) {{ border: 0 !important; border-radius: 0 !important; box-shadow: none !important;
  outline: none; background: white; }}
.card-header {{ padding: 2px 0 !important; border: 0 !important; min-height: 0 !important;
  background: transparent !important; cursor: pointer; }}
.card-header:focus-visible {{ outline: 2px solid {ACCENT}; }}
"""

OLD = {"opacity": "0.4"}
"""How results look that answer another request than the last."""

SECTION = {"border-top": f"1px solid {LINE}", "padding-top": "8px"}
SHEETS: dict[str, Any] = {"stylesheets": [TEXT]}
SHEET: dict[str, Any] = {"stylesheets": [TEXT], "margin": (0, 0)}
BLOCK: dict[str, Any] = {"sizing_mode": "stretch_width", "margin": (0, 0, 4, 0)}
CONTROL: dict[str, Any] = {
    "stylesheets": [TEXT], "sizing_mode": "stretch_width", "margin": (0, 0, 4, 0),
}  # fmt: skip
WIDE: dict[str, Any] = {
    "stylesheets": [TEXT], "sizing_mode": "stretch_width", "margin": (0, 0, 6, 0),
}  # fmt: skip
TABS: dict[str, Any] = {"stylesheets": [TEXT], "sizing_mode": "stretch_both", "margin": (4, 0)}
STRIP: dict[str, Any] = {"sizing_mode": "stretch_width", "margin": (0, 0, 6, 0)}
BUTTON: dict[str, Any] = {"stylesheets": [TEXT], "margin": (0, 6, 4, 0)}


# --- How figures on the page look, and how they are changed in place ---


TEXT_SIZE, SMALL = "12px", "11px"

GRID, FRAME = "#e4e4e4", "#b8b8b8"

MAP_BORDERS: dict[str, Any] = {"min_border_left": 34, "min_border_right": 64}
"""The same for all maps, so that their frames are equal [dots]."""


def quiet(plot: Any) -> None:
    """Give a figure the house's fonts and colours."""
    plot.title.text_font = FONT
    plot.title.text_font_size = TEXT_SIZE
    plot.title.text_font_style = "bold"
    plot.title.text_color = INK
    plot.title.offset = 0
    plot.outline_line_color = FRAME
    plot.background_fill_color = None
    plot.border_fill_color = None
    for axis in plot.select(Axis):
        axis.axis_label_text_font = axis.major_label_text_font = FONT
        axis.axis_label_text_font_size = axis.major_label_text_font_size = SMALL
        axis.axis_label_text_font_style = "normal"
        axis.axis_label_text_color = axis.major_label_text_color = INK
        axis.axis_label_standoff = 4
        axis.axis_line_color = None
        axis.major_tick_line_color = FRAME
        axis.minor_tick_line_color = None
    plot.grid.grid_line_color = GRID
    plot.toolbar.logo = None


def chart(title: str, height: int = 260, **options: Any) -> Any:
    """Return a figure of lines in the house's style."""
    plot: Any = figure(
        title=title, height=height, sizing_mode="stretch_width", min_border_left=60,
        tools="pan,box_zoom,wheel_zoom,reset", active_scroll=None, **options,
    )  # fmt: skip
    quiet(plot)
    return plot


def source(*names: str) -> Any:
    """Return columns without values."""
    return ColumnDataSource({name: [] for name in names})


def empty(*sources: Any) -> None:
    """Take the values out of columns."""
    for item in sources:
        item.data = {name: [] for name in item.data}


def grid(rows: Sequence[Sequence[Any]]) -> Any:
    """Return figures in rows, with one toolbar."""
    created = gridplot(
        rows, merge_tools=True, toolbar_location="above", sizing_mode="stretch_width",
        toolbar_options={"logo": None},
    )  # fmt: skip
    created.cols = "minmax(0, 1fr)"
    return created


def facts() -> Any:
    """Return room for a table below figures."""
    return markup(sizing_mode="stretch_width", margin=(4, 8))


def noted(plot: Any) -> tuple[Any, Any]:
    """Return a figure with room for markup below it, and the model of that."""
    plot.toolbar.autohide = True
    note = markup(sizing_mode="stretch_width", margin=(0, 8, 4, 60))
    return Column(plot, note, sizing_mode="stretch_width"), note


def hover(plot: Any, drawn: Any, text: Sequence[tuple[str, str]]) -> Any:
    """Have the values under the cursor told: names and columns; `hover_units` tells the units."""
    tool: Any = HoverTool(
        renderers=[drawn],
        tooltips=[(name, f"@{{{column}}}{{%0.4g}}") for name, column in text],
        formatters={f"@{{{column}}}": "printf" for _, column in text},
    )
    plot.add_tools(tool)
    return tool


def hover_units(tool: Any, units: Sequence[str]) -> None:
    """Set the units of what is told under the cursor."""
    tool.tooltips = [
        (name, f"{text.partition(' ')[0]} {unit}")
        for (name, text), unit in zip(tool.tooltips, units, strict=True)
    ]


def quiet_legend(plot: Any) -> None:
    """Put the legend of a figure above it, in one line."""
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


def frame(plot: Any, unknown: tuple[float, float]) -> tuple[float, float]:
    """Return the dots (y, x) of a figure's frame, which the browser tells once it has drawn it."""
    try:
        height, width = plot.inner_height, plot.inner_width
    except UnsetValueError:
        return unknown
    return (height, width) if height and width else unknown


def bar_of(mapper: Any) -> Any:
    """Return the colour bar of a map."""
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
    """Set the limits of a colour bar, in its unit, which stands at its uppermost tick."""
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


def palette(colours: NDArray[np.float64]) -> list[str]:
    """Return colours, red, green, blue first along the end, as texts."""
    levels = np.rint(np.asarray(colours)[:, :3] * 255).astype(int)
    return [f"#{red:02x}{green:02x}{blue:02x}" for red, green, blue in levels]


def patch(colour: str, text: str) -> str:
    """Return a sample of a colour with its name, as markup; the name is text."""
    return (
        f'<span style="display:inline-block;width:11px;height:11px;margin-right:5px;'
        f'border:1px solid #999;vertical-align:-1px;background:{colour}"></span>'
        f"{html.escape(text)}"
    )


def markup(**options: Any) -> Any:
    """Return a model that holds markup; `put` sets it."""
    return HTML(text="", run_scripts=False, disable_math=True, stylesheets=[TEXT], **options)


def put(model: Any, text: str) -> None:
    """Set the markup of a model."""
    model.text = html.escape(text)


@contextmanager
def together(document: Any) -> Iterator[None]:
    """Send the changes of a block to the browser at its end, as one message."""
    # What changes before the page has told that it stands would be held for ever.
    if document is None or not state.loaded:
        yield
        return
    with hold(document):
        yield


class Later:
    """An action that runs once for many calls in a row, some milliseconds after the first."""

    def __init__(self, model: Any, action: Callable[[], None], milliseconds: int = 40) -> None:
        self.model, self.action, self.milliseconds = model, action, milliseconds
        self._waits = False

    def __call__(self) -> None:
        """Ask for the action."""
        document = self.model.document
        if document is None or document.session_context is None:
            self.action()
        elif not self._waits:
            self._waits = True
            document.add_timeout_callback(self._run, self.milliseconds)

    def _run(self) -> None:
        self._waits = False
        self.action()


def on_changes(model: Any, names: Sequence[str], call: Callable[[], None]) -> None:
    """Have changes of some properties call a function."""

    def changed(attr: str, old: Any, new: Any) -> None:
        call()

    for name in names:
        model.on_change(name, changed)
