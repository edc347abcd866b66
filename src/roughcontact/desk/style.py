"""Style of the page: colors, fonts, style sheets and scripts, without external fonts."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from bokeh.models import ColumnDataSource, Div
from bokeh.themes import Theme
from numpy.typing import NDArray
from panel.io.document import hold
from panel.io.state import state

from roughcontact.drawing import style as drawing_style

INK, QUIET, LINE, ACCENT, WARNING = "#14181f", "#525b67", "#dfe3e7", "#0b5cad", "#a6320c"
"""Colors of text, lines and marks; the style sheets have further ones for dark pages."""

FONT = "-apple-system, 'Segoe UI', Roboto, 'Noto Sans', 'Helvetica Neue', Arial, sans-serif"

_ASSETS = Path(__file__).parent / "assets"


def read_asset(name: str, **values: str) -> str:
    """Return the text of a file of the browser, with values for words such as ``$INK``."""
    text = (_ASSETS / name).read_text(encoding="utf-8")
    return re.sub(r"\$([A-Z]+)", lambda word: values[word[1]], text) if values else text


def read_script(*names: str) -> str:
    """Return scripts of the browser as one."""
    return "".join(read_asset(f"{name}.js") for name in names)


_COLORS = {"INK": INK, "QUIET": QUIET, "LINE": LINE, "ACCENT": ACCENT, "WARNING": WARNING}
_SHEETS = read_asset("page.css", FONT=FONT, OPEN=drawing_style.OPEN, **_COLORS)
_PARTS = re.split(r"/\* ([A-Z_]+) \*/", _SHEETS)
CSS = dict(zip(_PARTS[1::2], _PARTS[2::2], strict=True))
"""Style sheets of the page by name; the color scheme of the system selects light or dark."""

TEXT = CSS["TEXT"]
STEP = CSS["FOLD"] + CSS["STEP"]

# Also in the style sheets.
LEFT, WRAPPED, NARROW = 272, 1240, 1560
"""Width of the left column, of a header of one line, of a window with tables right of its maps."""

NEW, OLD = {"opacity": "1"}, {"opacity": "0.45", "transition": "opacity .2s .4s"}
"""Styles of current and outdated results; the delay hides a quick update."""

SHEETS: dict[str, Any] = {"stylesheets": [TEXT]}
SHEET: dict[str, Any] = {**SHEETS, "margin": (0, 0)}
BLOCK: dict[str, Any] = {"sizing_mode": "stretch_width", "margin": (0, 0, 4, 0)}
CONTROL: dict[str, Any] = {**SHEETS, **BLOCK}
# Content higher than its column makes the column scroll, without overlap.
TALL = ":host { max-height: none !important; }"
STRIP: dict[str, Any] = {"sizing_mode": "stretch_width", "margin": (0, 0, 6, 0)}
WIDE: dict[str, Any] = {**STRIP, "stylesheets": [TEXT, TALL]}
HIGH: dict[str, Any] = {"stylesheets": [TALL], "sizing_mode": "stretch_width"}
BUTTON: dict[str, Any] = {**SHEETS, "margin": (0, 6, 4, 0)}


# Colors that are visible on light and on dark pages.
NEUTRAL, GAP = "#7d8895", "#3d8fd133"

_SCHEMES = {
    False: {"SCRIPT": INK, "GRID": "#e4e4e4", "FRAME": "#b8b8b8", "SHEET": drawing_style.OPEN},
    True: {"SCRIPT": "#e8ebef", "GRID": "#2b313a", "FRAME": "#6d7885", "SHEET": "#262c34"},
}


def theme(dark: bool) -> Theme:
    """Return the fonts and colors of figures."""
    return Theme(json=json.loads(read_asset("theme.json", FONT=FONT, **_SCHEMES[dark])))


def empty_source(*names: str) -> Any:
    """Return a data source with empty columns."""
    return ColumnDataSource({name: [] for name in names})


def clear_source(*sources: Any) -> None:
    """Remove the values of data sources."""
    for item in sources:
        item.data = {name: [] for name in item.data}


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


def color_legend(colors: Mapping[str, str]) -> str:
    """Return escaped names, each with a sample of its color, as markup."""
    return " ".join(
        f'<span class="patch"><i style="background:{color}"></i>{html.escape(name)}</span>'
        for name, color in colors.items()
    ).replace(" %", "\N{NO-BREAK SPACE}%")


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
    for name in names:
        model.on_change(name, lambda attr, old, new: call())
