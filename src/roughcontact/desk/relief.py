"""3-D view: heights colored by pressure, under one load or several."""

from __future__ import annotations

import base64
import io
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np
import panel as pn
import param
from numpy.typing import NDArray
from panel.custom import JSComponent

from roughcontact.contact.result import ContactResult
from roughcontact.desk import rasters, style, tokens, workers
from roughcontact.desk.controls import JobButton, Run, escape_markup
from roughcontact.desk.download_panel import Offer
from roughcontact.desk.maps import HEIGHTS, NAMES, PRESSURE, height_scale, result_scales
from roughcontact.desk.session import LOADS, Session, SessionState
from roughcontact.desk.widgets import TabPanel
from roughcontact.drawing.style import prefixed, prefixed_window
from roughcontact.errors import ConvergenceError, RoughcontactError
from roughcontact.request import preparation as maps
from roughcontact.request.request import Request
from roughcontact.request.run import solve_request
from roughcontact.solvers.progress import Progress
from roughcontact.surface.surface import Surface
from roughcontact.units import format_engineering, format_percent

_DOTS = 512
"""Maximum number of cells along the longer side; larger maps are reduced."""

_LOADS = 16
"""Number of loads of a movie: equal steps up to the load of the page."""

_HEIGHT_SHARE = 0.3
"""Maximum height of the box over its longer side, at the default scale."""

_LEVELS = 254
"""Number of color levels; two more levels are no value and above the scale."""

_MISSING_HEIGHT = np.float32(-1e30)
"""Value of a missing height in the script."""

_MILLISECONDS = 250
"""Duration of a frame in the file of a movie [ms]."""


class Canvas(JSComponent):  # type: ignore[misc]
    """Canvas of the surface; each list but the palette is a JSON text and bytes, or empty."""

    heights = param.List([])
    colors = param.List([])
    palette = param.List([])
    film = param.List([])

    _esm = (Path(__file__).parent / "relief.js").read_text(encoding="utf-8")
    _stylesheets: ClassVar = [
        f"""
:host {{ color: var(--text, {tokens.INK}); font-family: {tokens.FONT}; font-size: 13px; }}
.relief {{ display: flex; flex-direction: column; gap: 8px; height: 100%; min-height: 360px; }}
.scene {{ position: relative; flex: 1; min-height: 0; cursor: grab; touch-action: none;
  background: var(--surface, white); border: 1px solid var(--line, {tokens.LINE});
  border-radius: 6px; overflow: hidden; }}
.scene:focus-visible {{ outline: 2px solid var(--accent, {tokens.ACCENT}); }}
canvas {{ position: absolute; inset: 0; width: 100%; height: 100%; }}
.below {{ display: flex; flex-wrap: wrap; gap: 6px 20px; align-items: center; }}
[hidden] {{ display: none !important; }}
label {{ display: flex; gap: 8px; align-items: center; }}
input {{ accent-color: var(--accent, {tokens.ACCENT}); margin: 0; }}
output {{ min-width: 50px; font-variant-numeric: tabular-nums; }}
button {{ font: inherit; color: inherit; background: var(--surface, white); padding: 4px 10px;
  border: 1px solid var(--control, {tokens.LINE}); border-radius: 4px; cursor: pointer; }}
p {{ margin: 0; width: 100%; color: var(--muted, {tokens.QUIET}); }}
"""
    ]


class LoadFrame(NamedTuple):
    """Pressure under one load, in the cells of the view."""

    load: float  # [N]
    contact_fraction: float
    pressure: NDArray[np.float32]  # [Pa], NaN without contact


def solve_frames(
    tell: Callable[[Progress | str], None], request: Request, requests: Sequence[Request]
) -> list[LoadFrame]:
    """Solve the maps of a request under several loads; a job for a `WorkerPool`."""
    surfaces = maps.surfaces(request, tell)
    pictures = []
    for number, item in enumerate(requests, start=1):
        tell(Progress(number, len(requests), None))
        result = solve_request(item, surfaces, lambda _: None).contact
        if result is None or not result.converged:
            raise ConvergenceError(f"load {number} of {len(requests)} did not converge", result)
        part = rasters.result_window(result, _whole(result.surface))
        pressure = rasters.largest_pressure(part)
        pictures.append(LoadFrame(result.load, result.contact_fraction, pressure))
    return pictures


class ReliefView(TabPanel):
    """3-D view, with a movie of loads, in the colors of the maps."""

    def __init__(
        self,
        session: Session,
        bench: workers.WorkerPool,
        run: Run,
        folder: Path,
        offer: Offer,
        bars: Mapping[str, Any],
    ) -> None:
        self._session, self._folder, self._offer, self._bars = session, folder, offer, bars
        self._surface: Surface | None = None
        self._result: ContactResult | None = None
        self._filmed: SessionState | None = None
        self._pictures: list[bytes] = []
        self._saved = 0
        self._canvas = Canvas(sizing_mode="stretch_both", min_height=420, margin=0)
        self._canvas.on_msg(self._record)
        self._working = JobButton(bench, run, "Solve loads to play", self._started, session)
        self._link = pn.pane.HTML("", **style.WIDE)
        self.root = pn.Column(
            self._canvas, self._working.root, self._link, sizing_mode="stretch_both", margin=(8, 0)
        )

    def refresh(self) -> None:
        """Show the contact, or only the map if options are missing or the solve failed."""
        session = self._session
        outcome, prepared = session.outcome, session.prepared
        result = None if outcome is None else outcome.contact
        if result is None and not (session.state.missing or session.failure):
            # A new result is expected: keep the current view.
            return
        surface = prepared.surfaces[0] if result is None and prepared is not None else None
        surface = surface if result is None else result.surface
        if surface is not None and surface.is_profile:
            self._working.show_refusal(
                "A profile has no third dimension: its section shows all of it."
            )
            surface = result = None
        changes: dict[str, Any] = {}
        if self._filmed != _frames_key(session.state):
            changes["film"] = []
        if surface is not self._surface:
            self._surface = surface
            changes["heights"] = [] if surface is None else _heights(surface)
        if surface is not None and ("heights" in changes or result is not self._result):
            changes |= self._colors(surface, result)
        self._result = result
        self._canvas.param.update(**changes)

    def _colors(self, surface: Surface, result: ContactResult | None) -> dict[str, Any]:
        """Return the colors of a surface by pressure, or by height without a result."""
        view = _whole(surface)
        if result is None:
            scale, mean = height_scale(surface)
            key, values = HEIGHTS, rasters.mean_heights(surface, view, mean)
        else:
            key, scale = PRESSURE, result_scales(result)[PRESSURE]
            values = rasters.largest_pressure(rasters.result_window(result, view))
        bar = self._bars[key]
        if bar.color_mapper.low is None:
            # The map was not drawn yet, so its color bar has no limits.
            (low, high, _, _), factor, unit = scale
            style.set_bar(bar, low * factor, high * factor, unit)
        head = json.dumps(_head(key, bar, values.shape, _load_text(result)))
        levels = _levels(values * np.float32(scale.factor), bar.color_mapper)
        return {"palette": _palette(bar.color_mapper), "colors": [head, levels.tobytes()]}

    def _started(self) -> None:
        result, state = self._result, self._session.state
        if result is None:
            self._working.show_refusal("There is no contact to play.")
            return
        unit = "N/m" if result.pair.is_profile else "N"
        try:
            requests = [
                state.with_option("load", f"{result.load * number / _LOADS!r} {unit}").request()
                for number in range(1, _LOADS + 1)
            ]
        except RoughcontactError as error:
            self._working.refuse_error(error)
            return
        self._filmed = _frames_key(state)
        self._working.start_job(solve_frames, self._play, requests[-1], requests)

    def _play(self, pictures: list[LoadFrame]) -> None:
        if self._result is None or self._filmed != _frames_key(self._session.state):
            # The contact changed during the solve.
            return
        bar = self._bars[PRESSURE]
        factor = np.float32(result_scales(self._result)[PRESSURE].factor)
        heads = [
            _head(PRESSURE, bar, picture.pressure.shape, _load_text(picture))
            for picture in pictures
        ]
        levels = [_levels(picture.pressure * factor, bar.color_mapper) for picture in pictures]
        self._canvas.film = [json.dumps(heads), np.stack(levels).tobytes()]

    def _record(self, event: Any) -> None:
        """Store a frame that the browser drew, and offer the complete movie as a file."""
        message = event.data
        if message["number"] == 0:
            self._pictures = []
        if len(self._pictures) < _LOADS:
            self._pictures.append(base64.b64decode(message["picture"].partition(",")[2]))
        if len(self._pictures) == message["count"]:
            self._saved += 1
            path = self._folder / f"loads-{self._saved}.gif"
            path.write_bytes(make_gif(self._pictures))
            self._pictures = []
            address = escape_markup(self._offer(path))
            self._link.object = (
                f'<p><a href="{address}" download>{escape_markup(path.name)}</a></p>'
            )


def make_gif(pictures: Sequence[bytes]) -> bytes:
    """Return PNG images as a looping GIF, with a longer last frame."""
    from PIL import Image

    frames = []
    for data in pictures:
        with Image.open(io.BytesIO(data), formats=["PNG"]) as picture:
            frames.append(picture.convert("RGB").quantize(128, dither=Image.Dither.NONE))
    durations = [_MILLISECONDS] * (len(frames) - 1) + [4 * _MILLISECONDS]
    stream = io.BytesIO()
    frames[0].save(
        stream, "gif", save_all=True, append_images=frames[1:], duration=durations, loop=0
    )
    return stream.getvalue()


def _frames_key(state: SessionState) -> SessionState:
    """Return the cache key of the frames: all options but the load and the display."""
    return replace(state.remove_options(*LOADS), pinned=None, line=None)


def _whole(surface: Surface) -> rasters.Window:
    return rasters.whole_window(surface.shape, _DOTS)


def _heights(surface: Surface) -> list[Any]:
    """Return the heights as JSON text and bytes for the script."""
    view = _whole(surface)
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
        "length": prefixed_window(0.0, size),
        "height": prefixed(high - low, "m"),
        "factor": _rounded(_HEIGHT_SHARE * size / (high - low)) if high > low else 1.0,
        "note": f"{cells}. Drag or arrow keys: turn. Wheel, + and −: zoom. Double click or 0: "
        "reset.",
    }
    return [json.dumps(head), np.where(np.isnan(values), _MISSING_HEIGHT, values).tobytes()]


def _rounded(value: float) -> float:
    """Return the largest of 1, 2, 5, 10, ... up to a value."""
    power = 10.0 ** math.floor(math.log10(value))
    return power * max(step for step in (1, 2, 5) if step <= value / power * (1 + 1e-9))


def _load_text(state: ContactResult | LoadFrame | None) -> str:
    if state is None:
        return ""
    return (
        f"{format_engineering(state.load, 'N')}, contact {format_percent(state.contact_fraction)}"
    )


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
    return [mapper.nan_color, *(colors[step] for step in steps), mapper.high_color or colors[-1]]


def _levels(values: NDArray[np.float32], mapper: Any) -> NDArray[np.uint8]:
    """Return values as color levels: 0 for no value, 255 above the scale."""
    share = (values - np.float32(mapper.low)) / np.float32(mapper.high - mapper.low)
    levels = 1 + np.clip(np.nan_to_num(share) * _LEVELS, 0, _LEVELS - 1).astype(np.uint8)
    levels[share > 1] = _LEVELS + 1
    levels[np.isnan(values)] = 0
    return levels
