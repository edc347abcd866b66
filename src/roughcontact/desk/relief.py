"""3-D view: heights colored by pressure."""

from __future__ import annotations

import json
import math
from typing import Any, ClassVar

import numpy as np
import panel as pn
import param
from numpy.typing import NDArray
from panel.custom import JSComponent

import roughcontact as rc
from roughcontact import units
from roughcontact.desk import rasters, style
from roughcontact.desk.controls import show_alert
from roughcontact.desk.header import FORCE, form_of, load_text
from roughcontact.desk.maps import HEIGHTS, NAMES, PRESSURE, MapsView
from roughcontact.desk.session import Session
from roughcontact.desk.widgets import TabPanel
from roughcontact.drawing import style as drawing_style

_DOTS = 512
"""Maximum number of cells along the longer side; larger maps are reduced."""

_HEIGHT_SHARE = 0.3
"""Maximum height of the box over its longer side, at the default scale."""

_LEVELS = 254
"""Number of color levels; two more levels are no value and above the scale."""

_MISSING_HEIGHT = np.float32(-1e30)
"""Value of a missing height in the script."""


class Canvas(JSComponent):  # type: ignore[misc]
    """Canvas of the surface; each list but the palette is a JSON text and bytes, or empty."""

    heights = param.List([])
    colors = param.List([])
    palette = param.List([])

    _esm = style.read_script("relief")
    _stylesheets: ClassVar = [style.CSS["RELIEF"]]


class ReliefView(TabPanel):
    """3-D view in the colors of the maps; it follows the load of the page."""

    def __init__(self, session: Session, maps: MapsView) -> None:
        self._session, self._maps = session, maps
        self._chosen: dict[str, tuple[float, float]] = {}
        self._surface: rc.Surface | None = None
        self._result: rc.ContactResult | None = None
        self._canvas = Canvas(sizing_mode="stretch_both", min_height=420, margin=0)
        self._note = pn.pane.HTML("", visible=False, **style.WIDE)
        self.root = pn.Column(self._note, self._canvas, sizing_mode="stretch_both", margin=(8, 0))

    def refresh(self) -> None:
        """Show what the maps show, but no preview on larger pixels."""
        surface, result = self._maps.surface, self._maps.result
        if surface is not None and result is not None and result.gap.shape != surface.shape:
            return
        is_profile = surface is not None and surface.is_profile
        text = "A profile has no third dimension: its section shows all of it."
        show_alert(self._note, text if is_profile else "")
        if is_profile:
            surface = result = None
        changes: dict[str, Any] = {}
        if surface is not self._surface:
            self._surface = surface
            changes["heights"] = [] if surface is None else _heights(surface)
        is_same = result is self._result and self._maps.chosen == self._chosen
        if surface is not None and ("heights" in changes or not is_same):
            changes |= self._colors(surface, result)
        self._result, self._chosen = result, dict(self._maps.chosen)
        self._canvas.param.update(**changes)

    def _colors(self, surface: rc.Surface, result: rc.ContactResult | None) -> dict[str, Any]:
        """Return the colors of a surface by pressure, or by height without a result."""
        view, maps = rasters.whole_window(surface.shape, _DOTS), self._maps
        if result is None:
            key, values = HEIGHTS, rasters.mean_heights(surface, view, maps.mean)
        else:
            key, values = PRESSURE, rasters.largest_pressure(rasters.result_window(result, view))
        # The map may be drawn later.
        maps.set_scale(key)
        bar, words = maps.bars[key], "" if result is None else self._load_text(result)
        head = json.dumps(_head(key, bar, values.shape, words))
        levels = _levels(values * np.float32(maps.scales[key].factor), bar.color_mapper)
        return {"palette": _palette(bar.color_mapper), "colors": [head, levels.tobytes()]}

    def _load_text(self, result: rc.ContactResult) -> str:
        form = form_of(self._session.state.specified)
        load = load_text(result, form, 4) or load_text(result, FORCE, 4)
        return f"{load}, contact {units.format_percent(result.contact_fraction)}"


def _heights(surface: rc.Surface) -> list[Any]:
    """Return the heights as JSON text and bytes for the script."""
    view = rasters.whole_window(surface.shape, _DOTS)
    # Relative to the mean: single precision would lose digits of large heights.
    values = rasters.mean_heights(surface, view, float(np.nanmean(surface.heights)))
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    box = rasters.window_extent(view, surface.pixel)
    side = box.bottom, box.right
    size, block = max(side), view.blocks[0]
    rows, columns = view.shape
    cells = f"{rows} × {columns} points"
    if block > 1:
        cells = (
            f"{rows} × {columns} cells of {block} × {block} points, each with its mean height and "
            "its largest pressure"
        )
    head = {
        "nx": columns,
        "ny": rows,
        "side": side,
        "low": low,
        "high": high,
        "length": drawing_style.prefixed_window(0.0, size),
        "height": drawing_style.axis_unit(high - low, "m"),
        "factor": _round_down(_HEIGHT_SHARE * size / (high - low)) if high > low else 1.0,
        "note": f"{cells}. Drag or arrow keys: turn. Wheel, + and −: zoom. Double click or 0: "
        "reset.",
    }
    return [json.dumps(head), np.where(np.isnan(values), _MISSING_HEIGHT, values).tobytes()]


def _round_down(value: float) -> float:
    """Return the largest of 1, 2, 5, 10, ... up to a value."""
    power = 10.0 ** math.floor(math.log10(value))
    return power * max(step for step in (1, 2, 5) if step <= value / power * (1 + 1e-9))


def _head(key: str, bar: Any, shape: tuple[int, ...], words: str) -> dict[str, Any]:
    """Return shape, title, color scale and state of a map for the script."""
    low, high = bar.color_mapper.low, bar.color_mapper.high
    ticks = [
        ((tick - low) / (high - low), bar.major_label_overrides[tick]) for tick in bar.ticker.ticks
    ]
    return {"ny": shape[0], "nx": shape[1], "title": NAMES[key], "ticks": ticks, "words": words}


def _palette(mapper: Any) -> list[str]:
    """Return the colors of the levels: no value first, above the scale last."""
    colors = list(mapper.palette)
    steps = np.linspace(0, len(colors) - 1, _LEVELS).round().astype(int)
    nothing = drawing_style.OPEN if mapper.nan_color == rasters.CLEAR else mapper.nan_color
    return [nothing, *(colors[step] for step in steps), mapper.high_color or colors[-1]]


def _levels(values: NDArray[np.float32], mapper: Any) -> NDArray[np.uint8]:
    """Return values as color levels: 0 for no value, 255 above the scale."""
    share = (values - np.float32(mapper.low)) / np.float32(mapper.high - mapper.low)
    levels = 1 + np.clip(np.nan_to_num(share) * _LEVELS, 0, _LEVELS - 1).astype(np.uint8)
    levels[share > 1] = _LEVELS + 1
    levels[np.isnan(values)] = 0
    return levels
