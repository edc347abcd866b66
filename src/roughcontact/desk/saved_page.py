"""Standalone HTML page with linked maps, numbers, cautions, command and script."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

from bokeh import models
from bokeh.embed import json_item
from bokeh.resources import Resources

import roughcontact as rc
from roughcontact._tools import files
from roughcontact.analyses.solve import uncertainty_report
from roughcontact.desk import controls, style
from roughcontact.desk.controls import escape_markup, markup_table
from roughcontact.desk.maps import NAMES, MapsView, map_figure, map_titles
from roughcontact.desk.workers import Tell
from roughcontact.report import kind as quantities, python_script
from roughcontact.report.presentation import presentation_of
from roughcontact.request import run
from roughcontact.request.outcome import Outcome
from roughcontact.request.request import Request

_DOTS = 512
"""Maximum number of cells along the longer side, to keep the file small."""

_FRAME = 280
"""Longer side of a frame [dots]."""


def save_page(tell: Tell, request: Request, path: Path) -> Outcome:
    """Solve a contact and write its page; a job for a `WorkerPool`."""
    outcome = run.run_request(request, tell, tell)
    if outcome.contact is None:
        return outcome
    tell("writing the page")
    files.write_atomically(path, render_page(outcome.contact, request))
    return replace(outcome, written=(path,))


def render_page(result: rc.ContactResult, request: Request) -> str:
    """Return the page of a contact as the text of a self-contained HTML file."""
    if result.surface.is_profile:
        raise rc.InputError("a profile has no maps: use its report instead")
    item = json_item(_linked_maps(result), "maps", theme=style.theme(dark=False))
    scripts = "".join(
        f"<script>{text}</script>\n"
        for text in Resources(mode="inline", components=["bokeh", "bokeh-widgets"]).js_raw
    )
    ends = uncertainty_report.intervals_by_key(result)
    shown = presentation_of(result)
    rows = [
        (row.title, row.text, ends.get(row.key, ""), row.meaning)
        for row in (*shown.rows(), *shown.rows(quantities.TRUST))
    ]
    return style.read_asset(
        "saved_page.html",
        SHEET=style.CSS["SAVED_PAGE"],
        SCRIPTS=scripts,
        SOURCE=escape_markup(result.surface.provenance.source),
        VERSION=rc.__version__,
        CAUTIONS=controls.caution_list(result.cautions),
        NUMBERS=markup_table(rows, ("", "value", "interval", "")),
        COMMAND=escape_markup(request.command),
        PYTHON=escape_markup(python_script.script_of_result(result)),
        # Escape closing tags, which a browser would take for the end of the script.
        ITEM=json.dumps(item).replace("</", "<\\/"),
    )


def _linked_maps(result: rc.ContactResult) -> Any:
    """Return the five linked maps, with the values at the cursor and the legend."""
    maps = MapsView(is_live=False)
    maps.show_contact(result.surface, result)
    maps.draw_cells(_DOTS)
    tall, wide = (round(side * _FRAME / max(result.surface.size)) for side in result.surface.size)
    ranges = {"x_range": maps.x_range, "y_range": maps.y_range}
    reset = models.CustomJS(args=ranges, code=_RESET)
    titles, plots = map_titles(result), []
    for key, name in NAMES.items():
        title = ", ".join(filter(None, (name, titles.get(key))))
        plot = map_figure(
            title, **ranges, frame_width=wide, frame_height=tall, styles={"flex": "none"}
        )
        plot.xaxis.axis_label = maps.plot.xaxis.axis_label
        maps.draw_layers(plot, key)
        if key in maps.bars:
            maps.bars[key].visible = True
            plot.add_layout(maps.bars[key], "right")
        maps.show_cursor_values(plot)
        plot.js_on_event("doubletap", reset)
        plots.append(plot)
    side = models.Column(maps.readout, maps.legend, width=250, styles={"flex": "none"})
    return models.Row(
        models.Row(*plots, stylesheets=[_WRAPPED], sizing_mode="stretch_width"),
        side,
        sizing_mode="stretch_width",
    )


_WRAPPED = ":host { flex-wrap: wrap; gap: 8px; }"
_RESET = "for (const r of [x_range, y_range]) r.setv({ start: r.reset_start, end: r.reset_end })"
