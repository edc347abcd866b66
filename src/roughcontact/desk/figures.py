"""Figures of the report on the page: read from Matplotlib, shown by Bokeh."""

from __future__ import annotations

import html
import re
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import panel as pn
from bokeh import models

from roughcontact.desk import rasters, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_DASHES = {"-": "solid", "--": "dashed", ":": "dotted", "-.": "dashdot"}
_MAX_POINTS = 2000
_MARKERS = {"s": "square", "^": "triangle", "x": "x", "+": "cross"}


class Mark(NamedTuple):
    """Mark in a frame: Bokeh glyph, its columns, style and name."""

    glyph: str
    columns: dict[str, Any]
    look: dict[str, Any]
    name: str = ""


class Colors(NamedTuple):
    """Color scale of an image."""

    palette: list[str]
    low: float
    high: float
    missing: str
    over: str | None
    is_log: bool
    label: str


class Frame(NamedTuple):
    """Frame of a figure: one pair of axes."""

    title: str
    labels: tuple[str, str]  # Of the x and y axis
    scales: tuple[str, str]  # "linear" or "log", of the x and y axis
    ends: tuple[tuple[float, float], tuple[float, float]]  # Limits of x and y
    is_map: bool  # Whether x and y have the same scale
    marks: tuple[Mark, ...]
    colors: Colors | None
    patches: tuple[tuple[str, str], ...]  # Colors and their meaning


class Drawing(NamedTuple):
    """Content of a figure: title, frames and note."""

    title: str
    frames: tuple[Frame, ...]
    note: str


def read_figure(figure: Figure) -> Drawing:
    """Return the content of a Matplotlib figure."""
    bars = {
        item.colorbar.ax
        for axes in figure.axes
        for item in (*axes.images, *axes.collections)
        if item.colorbar is not None
    }
    frames = tuple(_frame(axes) for axes in figure.axes if axes not in bars)
    return Drawing(figure.get_suptitle(), frames, figure.get_supxlabel())


def _frame(axes: Any) -> Frame:
    marks: list[Mark] = []
    colors = None
    for image in axes.images:
        marks += _image(image)
        colors = _colors(image) or colors
    for item in axes.collections:
        marks += _collection(item)
        colors = _colors(item) or colors
    for item in axes.patches:
        marks += _patch(item, axes)
    for item in axes.lines:
        marks += _line(item, axes)
    for item in axes.texts:
        x, y = getattr(item, "xy", item.get_position())
        marks.append(Mark("text", {"x": [x], "y": [y], "text": [item.get_text()]}, {}))
    labels = (_label(axes, "x"), _label(axes, "y"))
    title = " ".join((axes.get_title() or axes.get_title("left")).split())
    legend = axes.get_legend()
    known = {mark.name for mark in marks}
    patches = (
        ()
        if legend is None
        else tuple(
            (_hex(handle.get_facecolor())[0], handle.get_label())
            for handle in legend.legend_handles
            if hasattr(handle, "get_facecolor") and handle.get_label() not in known
        )
    )
    return Frame(
        _strip_math(title),
        labels,
        (axes.get_xscale(), axes.get_yscale()),
        (axes.get_xlim(), axes.get_ylim()),
        axes.get_aspect() == 1.0,
        tuple(marks),
        colors,
        patches,
    )


def _label(axes: Axes, way: str) -> str:
    """Return the label of an axis; only one of several linked axes has a label."""
    shared = getattr(axes, f"get_shared_{way}_axes")().get_siblings(axes)
    texts = (getattr(item, f"get_{way}label")() for item in (axes, *shared))
    return _strip_math(next(filter(None, texts), ""))


def _strip_math(text: str) -> str:
    """Return text with the math markup of sigma replaced by plain characters."""
    return re.sub(r"\$\\sigma_\{(\w+)\}\$", "σ \\1", text)


def _name(item: Any) -> str:
    text = str(item.get_label())
    return "" if text.startswith("_") else _strip_math(text)


def _hex(color: Any, alpha: float | None = None) -> tuple[str, float]:
    from matplotlib.colors import to_hex, to_rgba

    return to_hex(color), float(to_rgba(color, alpha)[3])


def _span_side(item: Any, axes: Axes) -> str:
    """Return the side of the frame that an item spans; empty if it is in data coordinates."""
    by_x, by_y = item.get_transform().contains_branch_seperately(axes.transData)
    return "" if by_x and by_y else "height" if by_x else "width"


def _line(item: Any, axes: Axes) -> Iterator[Mark]:
    x, y = (np.asarray(values, float) for values in item.get_data())
    # A curve over all points of a map is sent with as many points as a screen shows.
    step = max(x.size // _MAX_POINTS, 1)
    x, y = x[::step], y[::step]
    color, alpha = _hex(item.get_color(), item.get_alpha())
    columns, name = {"x": x, "y": y}, _name(item)
    dash = _DASHES.get(item.get_linestyle())
    if dash:
        look = {
            "line_color": color,
            "line_alpha": alpha,
            "line_dash": dash,
            "line_width": item.get_linewidth(),
        }
        side = _span_side(item, axes)
        if side:
            at = float((x if side == "height" else y)[0])
            yield Mark("span", {"dimension": side, "location": at}, look)
        else:
            yield Mark("line", columns, look, name)
    if item.get_marker() not in ("None", "", None):
        size = item.get_markersize()
        look = {
            "color": color,
            "alpha": alpha,
            "size": size,
            "marker": _MARKERS.get(item.get_marker(), "circle"),
        }
        yield Mark("scatter", columns, look, name)


def _collection(item: Any) -> Iterator[Mark]:
    from matplotlib.collections import LineCollection, QuadMesh

    if isinstance(item, QuadMesh):
        corners = np.asarray(item.get_coordinates())
        x, y = corners[0, :, 0], corners[:, 0, 1]
        values: Any = np.ma.filled(np.ma.asarray(item.get_array(), float), np.nan)
        yield Mark(
            "image",
            {
                "x": np.full(y.size - 1, x[0]),
                "y": y[:-1],
                "dw": np.full(y.size - 1, x[-1] - x[0]),
                "dh": np.diff(y),
                "image": [row[None] for row in values.astype(np.float32)],
            },
            {},
        )
    elif isinstance(item, LineCollection):
        color, alpha = _hex(item.get_colors()[0])
        lines = [np.asarray(line) for line in item.get_segments()]
        columns = {"xs": [line[:, 0] for line in lines], "ys": [line[:, 1] for line in lines]}
        width = float(np.ravel(item.get_linewidth())[0])
        yield Mark("multi_line", columns, {"line_color": color, "line_width": width})
    else:
        color, alpha = _hex(item.get_facecolor()[0])
        yield _area([path.vertices for path in item.get_paths()], color, alpha, _name(item))


def _patch(item: Any, axes: Axes) -> Iterator[Mark]:
    shape = item.get_patch_transform().transform_path(item.get_path())
    parts = shape.to_polygons(closed_only=False)
    color, alpha = _hex(item.get_facecolor())
    side = _span_side(item, axes)
    if side:
        way = 0 if side == "height" else 1
        first, last = (float(end(parts[0][:, way])) for end in (np.min, np.max))
        names = ("left", "right") if side == "height" else ("top", "bottom")
        yield Mark(
            "band",
            dict(zip(names, (first, last), strict=True)),
            {"fill_color": color, "fill_alpha": alpha, "line_color": None},
        )
    elif item.get_fill():
        yield _area(parts, color, alpha, _name(item))
    else:
        color, alpha = _hex(item.get_edgecolor())
        look = {
            "line_color": color,
            "line_alpha": alpha,
            "line_width": item.get_linewidth(),
            "line_dash": _DASHES.get(item.get_linestyle(), "solid"),
        }
        columns = {"xs": [part[:, 0] for part in parts], "ys": [part[:, 1] for part in parts]}
        yield Mark("multi_line", columns, look, _name(item))


def _area(parts: Sequence[Any], color: str, alpha: float, name: str) -> Mark:
    columns = {"xs": [part[:, 0] for part in parts], "ys": [part[:, 1] for part in parts]}
    return Mark(
        "patches", columns, {"fill_color": color, "fill_alpha": alpha, "line_color": None}, name
    )


def _image(item: Any) -> Iterator[Mark]:
    left, right, bottom, top = item.get_extent()
    first, last = (top, bottom) if item.origin == "upper" else (bottom, top)
    values = item.get_array()
    is_colored = values.ndim == 3
    shown: Any = np.ma.filled(np.ma.asarray(values, float), np.nan).astype(np.float32)
    if is_colored:
        shown = rasters.pack_colors(np.minimum(shown, 1.0).astype(float))
    if last < first:
        first, last, shown = last, first, shown[::-1]
    columns = {
        "x": [left],
        "y": [first],
        "dw": [right - left],
        "dh": [last - first],
        "image": [shown],
    }
    yield Mark("image_rgba" if is_colored else "image", columns, {})


def _colors(item: Any) -> Colors | None:
    """Return the color scale of an image; None if the image contains colors."""
    from matplotlib.colors import LogNorm, to_hex

    values = item.get_array()
    if values is None or (values.ndim == 3 and hasattr(item, "origin")):
        return None
    item.autoscale_None()
    cmap, norm, bar = item.cmap, item.norm, item.colorbar
    over = cmap(2.0) if tuple(cmap(2.0)) != tuple(cmap(1.0)) else None
    label = "" if bar is None else bar.ax.get_ylabel() or bar.ax.get_xlabel()
    missing = to_hex(cmap(np.nan), keep_alpha=True)
    return Colors(
        style.color_palette(cmap(np.linspace(0, 1, 256))),
        float(norm.vmin),
        float(norm.vmax),
        missing,
        None if over is None else to_hex(over),
        isinstance(norm, LogNorm),
        label,
    )


def show_drawing(drawing: Drawing) -> Any:
    """Return a figure as a Bokeh layout."""
    plots = [_plot(frame) for frame in drawing.frames]
    # Titles need half the width of the page.
    titled = any(frame.title for frame in drawing.frames)
    across = min(len(plots), 2 if titled else 3)
    rows: list[list[Any]] = [
        plots[first : first + across] for first in range(0, len(plots), across)
    ]
    rows[-1] += [None] * (across - len(rows[-1]))
    head, foot = style.facts_below(), style.facts_below()
    style.set_markup(
        head, f"<b>{html.escape(_strip_math(drawing.title))}</b>" if drawing.title else ""
    )
    named = dict.fromkeys(entry for frame in drawing.frames for entry in frame.patches)
    patches = " &emsp; ".join(style.color_patch(*entry) for entry in named)
    style.set_markup(foot, f"<p>{patches}</p>{html.escape(drawing.note)}")
    return models.Column(head, style.figure_grid(rows), foot, sizing_mode="stretch_width")


def figure_view(drawing: Drawing) -> Any:
    """Return the view of a figure for a page."""
    return pn.pane.Bokeh(show_drawing(drawing), **style.BLOCK)


def _plot(frame: Frame) -> Any:
    """Return a frame as a Bokeh plot."""
    if frame.is_map:
        down = frame.ends[1][0] > frame.ends[1][1]
        ranges = {
            "x_range": models.DataRange1d(range_padding=0),
            "y_range": models.DataRange1d(range_padding=0, flipped=down),
        }
    else:
        ranges = {
            f"{way}_range": models.Range1d(*ends)
            for way, ends in zip("xy", frame.ends, strict=True)
        }
    scales = {f"{way}_axis_type": scale for way, scale in zip("xy", frame.scales, strict=True)}
    plot = style.make_chart(
        frame.title, 340 if frame.is_map else 280, match_aspect=frame.is_map, **ranges, **scales
    )
    plot.xaxis.axis_label, plot.yaxis.axis_label = frame.labels
    mapper = None if frame.colors is None else _mapper(frame.colors)
    for mark in frame.marks:
        _draw(plot, mark, mapper)
    if frame.colors is not None:
        bar = style.color_bar(mapper)
        style.set_bar(bar, frame.colors.low, frame.colors.high, "")
        if frame.colors.is_log:
            bar.update(ticker="auto", major_label_overrides={})
        bar.title = frame.colors.label
        plot.add_layout(bar, "right")
    if plot.legend:
        style.quiet_legend(plot)
        # More than three names do not fit in a row above a plot of half the page width.
        plot.legend[0].ncols = 2 if len(plot.legend[0].items) > 3 else "auto"
    return plot


def _mapper(colors: Colors) -> Any:
    kind = models.LogColorMapper if colors.is_log else models.LinearColorMapper
    return kind(
        palette=colors.palette,
        low=colors.low,
        high=colors.high,
        nan_color=colors.missing,
        high_color=colors.over,
    )


def _draw(plot: Any, mark: Mark, mapper: Any) -> None:
    if mark.glyph == "span":
        plot.add_layout(models.Span(**mark.columns, **mark.look))
        return
    if mark.glyph == "band":
        plot.add_layout(models.BoxAnnotation(**mark.columns, **mark.look, level="underlay"))
        return
    look: dict[str, Any] = dict(mark.look)
    if mark.glyph == "image":
        look["color_mapper"] = mapper
    if mark.glyph == "text":
        look |= {"text_font_size": style.SMALL, "y_offset": -4}
    if mark.name:
        look["legend_label"] = mark.name
    draw: Callable[..., Any] = getattr(plot, mark.glyph)
    draw(
        **{name: name for name in mark.columns},
        source=models.ColumnDataSource(mark.columns),
        **look,
    )
