"""Standalone HTML page with linked maps, numbers, cautions, command and script."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from bokeh import models
from bokeh.embed import json_item
from bokeh.resources import Resources
from numpy.typing import NDArray

from roughcontact._tools import files
from roughcontact._version import __version__
from roughcontact.analyses.solve import uncertainty_report as uncertainty
from roughcontact.contact.result import ContactResult
from roughcontact.desk import controls, rasters, style, tokens
from roughcontact.desk.controls import escape_markup, markup_table
from roughcontact.desk.maps import (
    GAP,
    HEIGHTS,
    NAMES,
    PRESSURE,
    RESIDUAL,
    TOUCH,
    ColorLimits,
    color_mappers,
    height_scale,
    map_figure,
    map_titles,
    result_scales,
)
from roughcontact.drawing import style as drawing_style
from roughcontact.errors import InputError
from roughcontact.report import kinds, python_script
from roughcontact.report.kind import TRUST
from roughcontact.request.outcome import Outcome
from roughcontact.request.request import Request
from roughcontact.request.run import run_request
from roughcontact.solvers.progress import Progress
from roughcontact.units import format_engineering

_DOTS = 512
"""Maximum number of cells along the longer side, to keep the file small."""

_FRAME = 280
"""Longer side of a frame [dots]."""

_COLORS = 4096
"""Number of colors of a map, each for a range of codes."""

_FIRST, _LAST = 2**16 // _COLORS, 2**16 - 1
"""Codes of the smallest and the largest value; lower codes are for no value."""


class EncodedMap(NamedTuple):
    """Map as integers: value = low + step × (code − ``_FIRST``); code 0 is missing."""

    codes: NDArray[np.uint16]
    low: float  # [SI]
    step: float  # [SI]


def save_page(tell: Callable[[Progress | str], None], request: Request, path: Path) -> Outcome:
    """Solve a contact and write its page; a job for a `WorkerPool`."""
    outcome = run_request(request, tell, tell)
    if outcome.contact is None:
        return outcome
    tell("writing the page")
    files.write_atomically(path, render_page(outcome.contact, request))
    return replace(outcome, written=(path,))


def render_page(result: ContactResult, request: Request) -> str:
    """Return the page of a contact as the text of a self-contained HTML file."""
    if result.surface.is_profile:
        raise InputError("a profile has no maps: use its report instead")
    maps, legend = _maps(result)
    # Escape closing tags, which a browser would take for the end of the script.
    item = json.dumps(json_item(maps, "maps")).replace("</", "<\\/")
    scripts = "".join(
        f"<script>{text}</script>\n"
        for text in Resources(mode="inline", components=["bokeh"]).js_raw
    )
    source = escape_markup(result.surface.provenance.source)
    ends = uncertainty.intervals_by_key(result)
    rows = [
        (row.title, row.text, ends.get(row.key, ""), row.meaning)
        for row in (*kinds.rows(result), *kinds.rows(result, TRUST))
    ]
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{source}: contact</title>
<meta http-equiv="Content-Security-Policy" content="{_POLICY}">
<style>{_SHEET}</style>
{scripts}</head><body>
<h1>Contact of {source}</h1>
<p class="quiet">Saved by roughcontact {__version__}. Wheel: zoom. Drag: move. Double click: \
reset.</p>
<div class="maps"><div id="maps"></div>
<aside><div id="readout">Point at a map to read its values.</div>{legend}</aside></div>
<h2>Cautions</h2>{controls.caution_list(result.cautions)}
<h2>Numbers</h2>{markup_table(rows, ("", "value", "interval", ""))}
<h2>Command</h2><pre>{escape_markup(request.command)}</pre>
<h2>Python</h2><pre>{escape_markup(python_script.script_of_result(result))}</pre>
<script type="application/json" id="item">{item}</script>
<script>Bokeh.embed.embed_item(JSON.parse(document.getElementById("item").textContent))</script>
</body></html>
"""


def _maps(result: ContactResult) -> tuple[Any, str]:
    """Return the five linked maps, and the legend of their colors and values."""
    surface = result.surface
    view = rasters.whole_window(surface.shape, _DOTS)
    height, mean = height_scale(surface)
    part = rasters.result_window(result, view)
    scales = {HEIGHTS: height, **result_scales(result)}
    layers = {
        HEIGHTS: _layer(rasters.mean_heights(surface, view, mean)),
        PRESSURE: _layer(rasters.largest_pressure(part)),
        GAP: _layer(rasters.mean_gap(part)),
        RESIDUAL: _layer(rasters.deepest_residual(part)),
    }
    box = rasters.window_extent(view, surface.pixel)
    factor, unit = drawing_style.prefixed_window(0.0, max(surface.size))
    tall, wide = (side * factor for side in surface.size)
    source = models.ColumnDataSource(
        {
            "x": [0.0],
            "y": [0.0],
            "dw": [box.right * factor],
            "dh": [box.bottom * factor],
            **{key: [layer.codes] for key, layer in layers.items()},
            TOUCH: [rasters.contact_colors(part)],
            "cover": [rasters.closed_colors(part)],
        }
    )
    ranges = {
        name: models.Range1d(start=start, end=end, reset_start=start, reset_end=end)
        for name, start, end in (("x_range", 0, wide), ("y_range", tall, 0))
    }
    cross: list[Any] = [
        models.Span(dimension=d, line_color=drawing_style.NEUTRAL, line_dash="dotted")
        for d in ("width", "height")
    ]
    side = _FRAME / max(tall, wide)
    titles = map_titles(result)
    named = [
        [
            NAMES[key],
            key,
            layer.low * scales[key].factor,
            layer.step * scales[key].factor,
            scales[key].unit,
        ]
        for key, layer in layers.items()
    ]
    read = models.CustomJS(args={"source": source, "named": named, "unit": unit}, code=_READ)
    reset = models.CustomJS(args=ranges, code=_RESET)
    mappers, plots = color_mappers(), []
    for key, name in NAMES.items():
        plot = map_figure(
            ", ".join(filter(None, (name, titles.get(key)))),
            cross=cross,
            **ranges,
            frame_width=max(round(wide * side), 60),
            frame_height=max(round(tall * side), 60),
            styles={"flex": "none"},
        )
        plot.xaxis.axis_label = f"x, y [{unit}]"
        plot.background_fill_color = drawing_style.OPEN
        _draw(plot, key, source, layers.get(key), scales.get(key), mappers.get(key))
        plot.js_on_event("mousemove", read)
        plot.js_on_event("doubletap", reset)
        plots.append(plot)
    row: Any = models.Row(
        *plots, stylesheets=[":host { flex-wrap: wrap; gap: 8px; }"], sizing_mode="stretch_width"
    )
    return row, _legend(view, layers, scales)


def _draw(
    plot: Any,
    key: str,
    source: Any,
    layer: EncodedMap | None,
    scale: ColorLimits | None,
    mapper: Any,
) -> None:
    """Draw a map, with its color bar if it has color limits."""
    place: dict[str, Any] = {"x": "x", "y": "y", "dw": "dw", "dh": "dh", "source": source}
    if layer is None or scale is None:
        plot.image_rgba(image=key, **place)
        return
    low, high = scale.limits.low, scale.limits.high
    share = (layer.low + layer.step * _FIRST * (np.arange(_COLORS) - 0.5) - low) / (high - low)
    colors = [*mapper.palette, mapper.high_color or mapper.palette[-1]]
    steps = np.clip(share * len(mapper.palette), 0, len(mapper.palette)).astype(int)
    palette = [mapper.nan_color, *(colors[step] for step in steps[1:])]
    coded = models.LinearColorMapper(palette=palette, low=0, high=_LAST + 1)
    plot.image(image=key, color_mapper=coded, **place)
    if key == GAP:
        plot.image_rgba(image="cover", **place)
    bar = style.color_bar(mapper)
    style.set_bar(bar, low * scale.factor, high * scale.factor, scale.unit)
    plot.add_layout(bar, "right")


def _layer(values: NDArray[np.float32]) -> EncodedMap:
    """Return values [SI] as 16-bit integers, with the smallest possible step."""
    there = ~np.isnan(values)
    if not there.any():
        return EncodedMap(np.zeros(values.shape, np.uint16), 0.0, 0.0)
    low, high = float(values[there].min()), float(values[there].max())
    step = (high - low) / (_LAST - _FIRST)
    codes = np.zeros(values.shape, np.uint16)
    codes[there] = _FIRST + np.rint((values[there].astype(float) - low) / (step or 1.0))
    return EncodedMap(codes, low, step)


def _legend(
    view: rasters.Window, layers: dict[str, EncodedMap], scales: dict[str, ColorLimits]
) -> str:
    """Return the legend of the colors, the cells and the precision of values as HTML."""
    rows, columns = view.shape
    block = view.blocks[0]
    cells = f"{rows} × {columns} points."
    if block > 1:
        cells = (
            f"{rows} × {columns} cells of {block} × {block} points: mean height, largest "
            "pressure, mean gap, deepest indentation."
        )
    steps = ", ".join(
        f"{NAMES[key].lower()} "
        f"{format_engineering(layer.step, 'Pa' if key == PRESSURE else 'm', 2)}"
        for key, layer in layers.items()
        if layer.step
    )
    patches = "".join(
        f"<div>{style.color_patch(*entry)}</div>"
        for entry in (
            (drawing_style.OPEN, "no contact"),
            (drawing_style.ELASTIC, "elastic"),
            (drawing_style.SATURATED, "saturated"),
            (drawing_style.CLOSED, "closed, in the gap"),
            (drawing_style.MISSING, "missing"),
            (drawing_style.OVER, "pressure above the scale"),
        )
    )
    return f"{patches}<p>{escape_markup(cells)} Values are in steps of {escape_markup(steps)}.</p>"


_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; style-src 'unsafe-inline'; "
    "img-src data: blob:; font-src data:"
)
_SHEET = f"""
body {{ margin: 16px; font: 13px/1.4 {tokens.FONT}; color: {tokens.INK}; background: white; }}
h1 {{ font-size: 18px; }} h2 {{ font-size: 14px; margin: 20px 0 6px; }}
.maps {{ display: flex; gap: 16px; }} #maps {{ flex: 1; min-width: 0; }}
aside {{ width: 250px; flex: none; position: sticky; top: 16px; align-self: flex-start; }}
#readout {{ min-height: 130px; }}
.quiet {{ color: {tokens.QUIET}; }}
table {{ border-collapse: collapse; }}
td, th {{ padding: 3px 14px 3px 0; text-align: left; vertical-align: top; font-weight: 400; }}
tr + tr td {{ border-top: 1px solid {tokens.LINE}; }}
ul.cautions {{ margin: 0; padding: 0; list-style: none; }}
li.warning b {{ color: {tokens.WARNING}; }}
pre {{ border: 1px solid {tokens.LINE}; border-radius: 4px; padding: 8px; white-space: pre-wrap; }}
"""

_RESET = """
for (const range of [x_range, y_range])
  range.setv({ start: range.reset_start, end: range.reset_end })
"""

# Only numbers and fixed texts: no content of a file enters the markup.
_READ = f"""
const {{ x, y }} = cb_obj, data = source.data
const [ny, nx] = data.heights[0].shape
const j = Math.floor((x / data.dw[0]) * nx), i = Math.floor((y / data.dh[0]) * ny)
const inside = i >= 0 && j >= 0 && i < ny && j < nx
const show = (value, unit) => `${{Number(value.toPrecision(4))}} ${{unit}}`
const rows = [["x, y", `${{Number(x.toPrecision(4))}}, ${{show(y, unit)}}`]]
for (const [name, key, low, step, own] of named) {{
  const code = inside ? data[key][0][i * nx + j] : 0
  rows.push([name, code == 0 ? "\u2013" : show(low + (code - {_FIRST}) * step, own)])
}}
document.getElementById("readout").innerHTML = "<table>" + rows.map(([name, text]) =>
  `<tr><td>${{name}}</td><td>${{text}}</td></tr>`).join("") + "</table>"
"""
