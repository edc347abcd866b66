"""Style of the page: one style sheet, without external fonts."""

from __future__ import annotations

import html
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from bokeh.layouts import gridplot
from bokeh.models import Axis, ColorBar, Column, ColumnDataSource, FixedTicker, HoverTool
from bokeh.plotting import figure
from bokeh.themes import Theme
from numpy.typing import NDArray
from panel.io.document import hold
from panel.io.state import state
from panel.models import HTML

from roughcontact.desk.tokens import ACCENT, FONT, INK, LINE, QUIET, WARNING
from roughcontact.drawing.style import OPEN

_LIGHT = f"""
  --bg: #f5f6f7; --surface: #ffffff; --sunken: #eef0f2; --line: {LINE}; --control: #858e99;
  --text: {INK}; --muted: {QUIET}; --accent: {ACCENT}; --accent-weak: #e6f0fa;
  --on-accent: #ffffff; --ok: #14733f; --caution: #7d5400; --severe: {WARNING};
  --ground: {OPEN};
  --shadow: 0 8px 28px rgba(15, 20, 30, .18);
"""
_DARK = """
  --bg: #101317; --surface: #171b21; --sunken: #1f242b; --line: #2b313a; --control: #6d7885;
  --text: #e8ebef; --muted: #a4adb9; --accent: #74b6ff; --accent-weak: #172a3f;
  --on-accent: #0b1420; --ok: #5fcd92; --caution: #efc163; --severe: #ff9d7a;
  --ground: #262c34;
  --shadow: 0 8px 28px rgba(0, 0, 0, .55);
"""

PAGE = f"""
:host {{ color-scheme: light dark; background: var(--bg); height: 100vh; overflow: hidden;
  {_LIGHT} }}
@media (prefers-color-scheme: dark) {{ :host {{ {_DARK} }} }}
"""
"""Style tokens of the page; the color scheme of the system selects light or dark."""

TEXT = f"""
:host {{ font-family: {FONT}; font-size: 13px; line-height: 1.4; color: var(--text);
  font-variant-numeric: tabular-nums; }}
.bk-input, .bk-btn, label, .bk-input-group {{ font-family: {FONT}; font-size: 13px;
  color: var(--text); }}
.bk-input {{ border-radius: 4px; border-color: var(--control); background-color: var(--surface); }}
label, .bk-input-group > label {{ font-size: 12px; color: var(--muted); }}
.bk-input:focus {{ border-color: var(--accent); outline: 2px solid var(--accent); }}
.bk-btn {{ padding: 4px 10px !important; border-radius: 4px !important; white-space: nowrap; }}
.bk-btn-default {{ background: var(--surface) !important; color: var(--text) !important;
  border: 1px solid var(--control) !important; }}
.bk-btn-default:hover {{ background: var(--sunken) !important; }}
.bk-btn-primary {{ background: var(--accent) !important; border: 1px solid transparent !important;
  color: var(--on-accent) !important; }}
.bk-btn:focus-visible {{ outline: 2px solid var(--accent); outline-offset: 2px; }}
a {{ color: var(--accent); }}
.wrong, :host(.wrong) {{ color: var(--severe); font-size: 12px; }}
h1 {{ font-size: 15px; margin: 0; font-weight: 650; white-space: nowrap; }}
h2 {{ font-size: 13px; margin: 0 0 4px; font-weight: 600; }}
p {{ margin: 0 0 6px; }}
.quiet {{ color: var(--muted); }}
progress {{ display: block; width: 100%; height: 6px; margin: 0 0 4px;
  accent-color: var(--accent); }}
.fold {{ font-size: 12px; color: var(--accent); }}
table {{ border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: 12px; }}
td, th {{ padding: 3px 12px 3px 0; text-align: left; vertical-align: top; font-weight: 400; }}
th {{ color: var(--muted); }}
tr + tr td {{ border-top: 1px solid var(--line); }}
.warning {{ color: var(--severe); }} .caution {{ color: var(--caution); }}
.step {{ display: grid; grid-template-columns: 14px minmax(0, 1fr); gap: 8px; text-align: left; }}
.step h2 {{ margin: 0; }}
.step p {{ margin: 0; font-size: 12px; overflow-wrap: anywhere; }}
.step b {{ font-weight: 500; color: var(--text); }}
.good {{ color: var(--ok); }} .bad {{ color: var(--severe); }}
ul.cautions {{ margin: 0; padding: 0; list-style: none; }}
ul.cautions li {{ margin: 0 0 4px; color: var(--text); }}
ul.cautions b {{ font-weight: 600; }}
h2 > button {{ font: inherit; font-size: 12px; font-weight: 400; margin-left: 8px;
  color: var(--text); background: var(--surface); border: 1px solid var(--control);
  border-radius: 4px; cursor: pointer; }}
.figure {{ display: block; max-width: min(100%, 900px); margin: 0 0 8px; border-radius: 4px; }}
pre {{ background: var(--surface); border: 1px solid var(--line); border-radius: 4px;
  padding: 8px; overflow-x: auto; font-size: 12px; white-space: pre-wrap; }}
"""

NUMBERS = """
dl { display: flex; margin: 0; }
dl div { padding: 0 14px; border-left: 1px solid var(--line); }
dl div:first-child { border-left: 0; padding-left: 0; }
dt { font-size: 12px; line-height: 16px; color: var(--muted); white-space: nowrap; }
dd { margin: 0; font-size: 18px; line-height: 24px; font-weight: 600; white-space: nowrap; }
small { display: block; font-size: 11px; line-height: 15px; color: var(--muted);
  white-space: nowrap; min-height: 15px; }
@media (max-width: 1420px) { dl div { padding: 0 9px; } dd { font-size: 16px; } }
"""

CHIP = """
.chip { display: inline-flex; gap: 7px; align-items: center; font-size: 12px; font-weight: 500;
  line-height: 15px; }
.chip::before { content: ""; width: 8px; height: 8px; border-radius: 50%; flex: none;
  background: currentColor; }
"""

BAR = """
:host { align-items: center; gap: 6px 20px; padding: 6px 16px; background: var(--surface);
  border-bottom: 1px solid var(--line); flex: none; box-sizing: border-box; }
@media (max-width: 1239px) { :host { flex-wrap: wrap; } }
"""

LEFT, WRAPPED, NARROW = 272, 1240, 1560
"""Width of the left column; of a window with a header of one line; with tables beside its maps."""

TOP = """
:host { align-items: center; padding: 0 16px; background: var(--surface);
  border-bottom: 1px solid var(--line); flex: none; box-sizing: border-box; }
"""
LEFT_SIDE = """
:host { background: var(--surface); border-right: 1px solid var(--line); flex: none; }
"""
CONTACT = f"""
:host {{ gap: 16px; padding: 12px 16px; box-sizing: border-box; align-items: flex-start; }}
@media (max-width: {NARROW - 1}px) {{ :host {{ flex-direction: column !important; }} }}
"""
RAIL = f"""
:host {{ border-left: 1px solid var(--line); padding-left: 16px; box-sizing: border-box;
  min-width: 0; }}
@media (max-width: {NARROW - 1}px) {{ :host {{ border: 0; padding: 0; }} }}
"""

MAPS = ":host { flex-wrap: wrap; gap: 8px; align-items: flex-start; }"

VIEW = ":host { padding: 12px 16px; box-sizing: border-box; }"

COLUMN = """
:host { overflow-y: auto; scrollbar-width: thin; height: 100%; box-sizing: border-box; }
"""

DRAWER = """
:host { position: fixed !important; z-index: 20; top: 125px; right: 0; bottom: 0;
  width: min(440px, 100vw) !important; height: auto !important; box-sizing: border-box;
  padding: 16px 24px;
  overflow-y: auto; background: var(--surface); border-left: 1px solid var(--line);
  box-shadow: var(--shadow); }
@media (max-width: 1239px) { :host { top: 186px; } }
"""

GRID = """
.slick-header-column { height: 34px !important; padding: 0 3px !important; }
.slick-header-column, .slick-column-name { white-space: normal !important; line-height: 16px;
  color: var(--muted); }
.slick-row, .slick-row .slick-cell { background: var(--surface) !important;
  color: var(--text) !important; }
.slick-row .slick-cell.selected { background: var(--accent-weak) !important; }
"""

FOLD = """
:host(.card) { border: 0 !important; border-radius: 0 !important; box-shadow: none !important;
  outline: none; background: transparent; flex: none !important; max-height: none !important; }
.card-header { flex: none; position: static !important; padding: 2px 0 !important;
  border: 0 !important; min-height: 0 !important;
  background: transparent !important; cursor: pointer; color: var(--text) !important; }
.card-button { color: var(--muted) !important; }
.card-header:focus-visible { outline: 2px solid var(--accent); }
"""
STEP = f"""{FOLD}
:host(.card) {{ border-bottom: 1px solid var(--line) !important; }}
.card-header {{ padding: 9px 12px !important; align-items: flex-start !important; }}
.card-header:hover {{ background: var(--sunken) !important; }}
"""

BACK = """
:host { position: absolute !important; top: 6px; right: 8px; width: auto !important; }
.bk-btn { border: 0 !important; padding: 2px 6px !important; color: var(--accent) !important;
  background: transparent !important; font-size: 12px; }
"""

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
_TALL = ":host { max-height: none !important; }"
WIDE: dict[str, Any] = {
    "stylesheets": [TEXT, _TALL],
    "sizing_mode": "stretch_width",
    "margin": (0, 0, 6, 0),
}
HIGH: dict[str, Any] = {"stylesheets": [_TALL], "sizing_mode": "stretch_width"}
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


def figure_grid(rows: Sequence[Sequence[Any]]) -> Any:
    """Return a grid of figures with one toolbar."""
    created = gridplot(
        rows,
        merge_tools=True,
        toolbar_location="above",
        sizing_mode="stretch_width",
        toolbar_options={"logo": None},
    )
    created.cols = "minmax(0, 1fr)"
    return created


def facts_below() -> Any:
    """Return an empty markup model for a table below figures."""
    return make_markup(sizing_mode="stretch_width", margin=(4, 8))


def with_note(plot: Any) -> tuple[Any, Any]:
    """Return a column of a figure and a markup model, and this model."""
    plot.toolbar.autohide = True
    note = make_markup(sizing_mode="stretch_width", margin=(0, 8, 4, 60))
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
    """Return an empty markup model; `set_markup` sets its text."""
    return HTML(text="", run_scripts=False, disable_math=True, stylesheets=[TEXT], **options)


def set_markup(model: Any, text: str) -> None:
    """Set the markup of a model."""
    model.text = html.escape(text)


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
