"""Style of figures: sizes, colors, units of axes, maps in cells, bars and legends.

`roughcontact.drawing.maps` describes maps in cells.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array
from roughcontact.contact.result import ContactResult
from roughcontact.elastoplastic.volume_result import ElastoplasticResult
from roughcontact.errors import InputError
from roughcontact.units import format_engineering

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import ListedColormap
    from matplotlib.figure import Figure
    from matplotlib.image import AxesImage
    from matplotlib.layout_engine import ConstrainedLayoutEngine
    from matplotlib.transforms import Transform


Mask = NDArray[np.bool_]

DPI = 150
"""Dots per inch of every figure."""

CELLS_ALONE, CELLS_IN_PANEL = 600, 520
"""Maximum number of cells along the longer side of a map.

The axes have more dots, so that nearest-neighbor drawing does not skip a cell.
"""

MIN_LABEL_RATIO = 0.45
"""Height over width of a map up to which the color bar is on top of the map."""

TITLE, LABEL, TICK, NOTE = 13.0, 12.0, 11.0, 10.5
"""Sizes of text [points]."""

MISSING, OPEN, CLOSED, OVER, NEUTRAL = "#c4c4c4", "#f1f1ee", "#d55e00", "#000000", "#444444"
"""Colors of missing, open, closed and out-of-range points, and of remarks."""

ELASTIC, SATURATED = "#4aa3df", "#7f0d1b"
"""Blue and dark red: distinct when printed in gray and for all types of color vision."""

HALF_A_STEP = 0.5 / 255
"""Offset of drawn colors, against truncation to steps of 1/255; see `draw_map`."""

SERIES = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
"""Colors of Okabe and Ito for all types of color vision, darkest first."""

_PREFIXES = {-12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}


def axis_unit(largest: float, unit: str) -> tuple[float, str]:
    """Return factor and prefixed unit of a quantity for an axis."""
    # The margin gives 999.9999999 µm, a sum of pixels, the prefix of 1 mm.
    if unit == "m²":
        return prefixed_area(largest or 1.0)
    exponent = 3 * math.floor(math.log10(largest * (1 + 1e-9)) / 3) if largest > 0 else 0
    exponent = min(max(exponent, min(_PREFIXES)), max(_PREFIXES))
    return float(10.0**-exponent), _PREFIXES[exponent] + unit


def prefixed_window(first: float, last: float) -> tuple[float, str]:
    """Return factor and unit for an axis of lengths between two positions [m].

    They suit the shown length, unless positions far from zero would need too many digits.
    """
    return axis_unit(max(last - first, 0.1 * abs(last)), "m")


def in_unit(value: float, scale: tuple[float, str], symbol: str) -> str:
    """Return a quantity [SI] as text with three digits, in the unit of an axis.

    The scale is the factor and name of the unit of the axis, and the symbol the unit without a
    prefix, for values that are too small or too large in the unit of the axis.
    """
    factor, unit = scale
    scaled = float(f"{value * factor:.3g}")
    fits = scaled == 0 or 1e-3 <= abs(scaled) < 1e4
    return f"{scaled:.7g} {unit}" if fits else format_engineering(value, symbol, 3)


def prefixed_area(largest: float) -> tuple[float, str]:
    """Return factor and prefixed unit of an area for an axis."""
    # A prefix of areas spans six decades: use the next prefix from a tenth of its unit.
    exponent = min(max(3 * math.floor(math.log10(10 * largest * (1 + 1e-9)) / 6), -12), 0)
    return float(10.0 ** (-2 * exponent)), _PREFIXES[exponent] + "m²"


def layout() -> ConstrainedLayoutEngine:
    """Return the layout engine of figures of several axes."""
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    return ConstrainedLayoutEngine(w_pad=0.1, h_pad=0.1)


def empty_figure(width: float, height: float) -> Figure:
    """Return an empty figure of a size [inch]."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), dpi=DPI, layout=layout())


def panels(
    width: float, height: float, rows: int = 1, columns: int = 1, **more: Any
) -> tuple[Figure, Any]:
    """Return a figure of a size [inch], and its axes as from ``Figure.subplots``."""
    figure = empty_figure(width, height)
    return figure, figure.subplots(rows, columns, **more)


def shown_aspect(size: tuple[float, float]) -> float:
    """Return the aspect ratio (height/width) of a map (y, x), limited by the page."""
    return min(max(size[0] / size[1], 0.2), 1.6)


def single_axes(
    size: tuple[float, float], legend: bool = True, bar: bool = True
) -> tuple[Figure, Axes]:
    """Return a figure for one map of a size (y, x), and its axes."""
    # Large enough for more dots than cells along the longer side of the map, and wide enough for
    # the note below any map.
    aspect = size[0] / size[1]
    height = max(5.2 * min(aspect, 1.0), 1.0) + (2.6 if legend else 1.8)
    return panels(7.2, height + (1.0 if bar and aspect <= MIN_LABEL_RATIO else 0.0))


def name_axes(axes: Axes, x: str = "", y: str = "", title: str = "") -> None:
    """Set the labels and the title of axes."""
    if x:
        axes.set_xlabel(x, fontsize=LABEL)
    if y:
        axes.set_ylabel(y, fontsize=LABEL)
    if title:
        axes.set_title(title, fontsize=TITLE)


# Ratios of the ends of an axis up to which 1, 2 and 5 of each decade are labeled, or every line.
_FEW_DECADES, _PART_OF_ONE = 300, 6


def log_scale(axes: Axes, way: str) -> None:
    """Make an axis, "x" or "y", logarithmic; a short axis has plain decimal labels."""
    from matplotlib.ticker import FuncFormatter, LogFormatterSciNotation

    axes.set(**{f"{way}scale": "log"})
    axis = getattr(axes, f"{way}axis")
    power = LogFormatterSciNotation(labelOnlyBase=True)
    power.set_axis(axis)

    def format_tick(value: float, _: Any = None) -> str:
        low, high = sorted(axis.get_view_interval())
        if not high < _FEW_DECADES * low:
            return str(power(value))
        return f"{value:g}" if f"{value:e}"[0] in "125" or high < _PART_OF_ONE * low else ""

    axis.set_major_formatter(FuncFormatter(format_tick))
    axis.set_minor_formatter(FuncFormatter(format_tick))


def plain_axes(axes: Axes, x: str = "", y: str = "", title: str = "") -> None:
    """Set grid, ticks, labels and title of line plots."""
    name_axes(axes, x, y, title)
    axes.tick_params(which="both", labelsize=TICK)
    axes.grid(True, color="#dddddd", lw=0.8)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def cell_size(shape: tuple[int, ...], size: tuple[float, float], cells: int) -> tuple[int, int]:
    """Return the points (y, x) per cell for at most ``cells`` cells on the longer side."""
    longer = max(size)
    by, bx = (
        max(math.ceil(points / max(cells * side / longer, 1)), 1)
        for points, side in zip(shape, size, strict=True)
    )
    return by, bx


def reduce_cells(
    ufunc: np.ufunc,
    values: NDArray[Any],
    blocks: tuple[int, int],
    dtype: type[np.generic] | None = None,
) -> NDArray[Any]:
    """Return the reduction of the points of each cell by a ufunc."""
    result = values if dtype is None else values.astype(dtype, copy=False)
    for axis, block in enumerate(blocks):
        if block > 1:
            result = _reduce_blocks(ufunc, np.moveaxis(result, axis, 0), block)
            result = np.moveaxis(result, 0, axis)
    return result


def _reduce_blocks(ufunc: np.ufunc, values: NDArray[Any], block: int) -> NDArray[Any]:
    """Return a ufunc reduced over blocks of rows; the last block may be shorter."""
    # Over the first rows of all blocks, then the second rows: ten times as fast as `reduceat`.
    result = values[::block].copy()
    for row in range(1, min(block, len(values))):
        there = values[row::block]
        ufunc(result[: len(there)], there, out=result[: len(there)])
    return result


def cell_max(values: Array, blocks: tuple[int, int]) -> Array:
    """Return the largest value of each cell."""
    return reduce_cells(np.maximum, values, blocks)


def cell_points(shape: tuple[int, ...], blocks: tuple[int, int]) -> Array:
    """Return the number of points of each cell; the last cells may have fewer."""
    rows, columns = (
        np.diff([*range(0, points, block), points])
        for points, block in zip(shape, blocks, strict=True)
    )
    return np.outer(rows, columns).astype(np.float64)


def cell_share(mask: Mask, blocks: tuple[int, int]) -> Array:
    """Return the share of marked points in each cell."""
    marked = np.asarray(reduce_cells(np.add, mask, blocks, np.float64), dtype=np.float64)
    return marked / cell_points(mask.shape, blocks)


def mix_colors(shares: Sequence[tuple[str, Array]], ground: str) -> Array:
    """Return the mixed color of each cell over a background; last axis: red, green, blue.

    The mean color of the figure is then the mean of the points for any size of the cells.
    """
    from matplotlib.colors import to_rgb

    result = np.full((*shares[0][1].shape, 3), to_rgb(ground))
    for colour, share in shares:
        result += share[..., None] * (np.array(to_rgb(colour)) - to_rgb(ground))
    return np.clip(result, 0.0, 1.0)


def cell_mean(values: Array, blocks: tuple[int, int]) -> Array:
    """Return the mean of the present points of each cell; NaN if half or more are missing."""
    if blocks == (1, 1):
        return values.copy()
    there = np.isfinite(values)
    count = reduce_cells(np.add, there, blocks, np.float64)
    total = reduce_cells(np.add, values if there.all() else np.where(there, values, 0.0), blocks)
    maximum = cell_points(values.shape, blocks)
    return np.where(2 * count > maximum, total / np.maximum(count, 1), np.nan)


def draw_map(
    axes: Axes,
    values: Array,
    size: tuple[float, float],
    blocks: tuple[int, int],
    shape: tuple[int, ...],
    corner: tuple[float, float] = (0.0, 0.0),
) -> AxesImage:
    """Draw a map in cells, true to scale, with axes in meters.

    A cell has one value on a color scale, or red, green, blue and opacity. Size and shape are
    those of the drawn part of the map, which begins at the corner.
    """
    far = max(begin + side for begin, side in zip(corner, size, strict=True))
    factor, unit = prefixed_window(far - max(size), far)
    height, width = size[0] * factor, size[1] * factor
    top, left = corner[0] * factor, corner[1] * factor
    # Cells at the far edges may extend beyond the map; the limits crop them.
    bottom = top + values.shape[0] * blocks[0] * height / shape[0]
    right = left + values.shape[1] * blocks[1] * width / shape[1]
    # Matplotlib truncates colors to steps of 1/255, which would shift their mean: half a step
    # more rounds them.
    coloured = values.ndim == 3
    image = axes.imshow(
        np.minimum(values + HALF_A_STEP, 1.0) if coloured else np.ma.masked_invalid(values),
        extent=(left, right, bottom, top),
        interpolation="nearest",
        aspect="equal",
    )
    axes.set_xlim(left, left + width)
    axes.set_ylim(top + height, top)
    name_axes(axes, f"x [{unit}]", f"y [{unit}]")
    axes.tick_params(which="both", labelsize=TICK)
    few_ticks(axes, height / width)
    return image


def outline(axes: Axes, mask: Mask, rows: Array, columns: Array, colour: str) -> None:
    """Draw a line around the cells of a mask, given the edges of its rows and columns."""
    from matplotlib.collections import LineCollection

    across, down = np.diff(mask, axis=1), np.diff(mask, axis=0)
    lines = [
        ((columns[j + 1], rows[i]), (columns[j + 1], rows[i + 1])) for i, j in np.argwhere(across)
    ] + [((columns[j], rows[i + 1]), (columns[j + 1], rows[i + 1])) for i, j in np.argwhere(down)]
    axes.add_collection(LineCollection(lines, colors=colour, linewidths=0.9), autolim=False)


def few_ticks(axes: Axes, aspect: float) -> None:
    """Set the number of ticks that fits the sides of a map of this aspect ratio."""
    from matplotlib.ticker import MaxNLocator

    axes.xaxis.set_major_locator(MaxNLocator(max(round(5 / max(aspect, 1)), 2)))
    axes.yaxis.set_major_locator(MaxNLocator(max(round(5 * min(aspect, 1)), 1 + (aspect > 0.2))))


def colour_bar(axes: Axes, image: AxesImage, label: str, extend: str) -> None:
    """Add a color bar next to the box of the map; on top of wide maps."""
    left, right = axes.get_xlim()
    bottom, top = axes.get_ylim()
    aspect = abs(bottom - top) / abs(right - left)
    upright = aspect > MIN_LABEL_RATIO
    thickness = 0.045 * max(aspect, 1) if upright else 0.045 / aspect
    place = (1 + 0.6 * thickness, 0, thickness, 1) if upright else (0, 1 + thickness, 1, thickness)
    bar = axes.figure.colorbar(
        image,
        cax=axes.inset_axes(place),
        extend=extend,
        orientation="vertical" if upright else "horizontal",
        ticklocation="right" if upright else "top",
    )
    bar.set_label(label, fontsize=LABEL)
    bar.ax.tick_params(labelsize=TICK)


def mark_place(axes: Axes, x: float, y: float, **more: Any) -> None:
    """Mark a place by a cross."""
    axes.plot([x], [y], "+", color=SERIES[0], ms=11, mew=2, **more)


def label_point(
    axes: Axes, text: str, point: tuple[float, float], offset: tuple[float, float], **more: Any
) -> None:
    """Write a small text at an offset [points] from a point; with arguments of ``annotate``."""
    axes.annotate(
        text, point, offset, textcoords="offset points", fontsize=TICK, color=NEUTRAL, **more
    )


def field_colours(**beyond: Any) -> Any:
    """Return the full color map of a field: no background color has to be distinct."""
    from matplotlib import colormaps

    return listed_colormap(colormaps["inferno_r"](np.linspace(0, 0.63, 256))).with_extremes(
        **beyond
    )


def listed_colormap(colours: Any) -> ListedColormap:
    """Return a color map of listed colors."""
    from matplotlib.colors import ListedColormap

    return ListedColormap(colours)


def patch_legend(axes: Axes, entries: Sequence[tuple[str, str]]) -> None:
    """Add a legend of colors below a map."""
    from matplotlib.patches import Patch

    handles = [
        Patch(facecolor=colour, edgecolor="#777777", lw=0.8, label=text) for colour, text in entries
    ]
    sizes = {"handlelength": 1.2, "handleheight": 1.2, "columnspacing": 1.4}
    legend_below(axes, len(entries), handles=handles, **sizes)


def plain_legend(axes: Axes) -> None:
    """Add a legend within axes."""
    axes.legend(fontsize=TICK, frameon=False)


def shared_legend(figure: Figure, grid: NDArray[Any], title: str = "") -> None:
    """Add one legend of all axes below the figure, and a title above."""
    entries: dict[str, Any] = {}
    for axes in grid.ravel():
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    figure.legend(
        entries.values(),
        entries.keys(),
        loc="outside lower center",
        ncols=3,
        fontsize=TICK,
        frameon=False,
    )
    if title:
        figure.suptitle(title, fontsize=TITLE)


def below_label(axes: Axes) -> Transform:
    """Return the transform of positions below the axis label, for any aspect ratio."""
    from matplotlib.transforms import ScaledTranslation

    figure = axes.get_figure()
    assert figure is not None
    return axes.transAxes + ScaledTranslation(0, -0.52, figure.dpi_scale_trans)


def legend_below(axes: Axes, columns: int = 1, **more: Any) -> None:
    """Add a legend below the axis label; with further arguments of Matplotlib."""
    axes.legend(
        loc="upper center",
        bbox_to_anchor=(0.5, 0),
        bbox_transform=below_label(axes),
        borderaxespad=0,
        ncols=columns,
        fontsize=TICK,
        frameon=False,
        **more,
    )


def cell_note(figure: Figure, cell: tuple[int, int], shown: str, more: str = "") -> None:
    """Add a note on cells below a figure; none if each cell is one point."""
    if cell == (1, 1):
        return
    text = f"Drawn in cells of {cell[0]} × {cell[1]} points (y × x): a cell shows {shown}."
    figure.supxlabel(f"{text}\n{more}" if more else text, fontsize=NOTE, color=NEUTRAL)


def result_names(results: Sequence[ContactResult], labels: Sequence[str] | None) -> list[str]:
    """Return one name per result; raise `InputError` unless the labels match the results."""
    if not results:
        raise InputError("is empty: give at least one", argument="results")
    if labels is None:
        return [""] if len(results) == 1 else [f"result {i + 1}" for i in range(len(results))]
    if isinstance(labels, str) or len(labels) != len(results):
        raise InputError(
            f"must hold one text a result, got {labels!r} for {len(results)}",
            argument="labels",
            value=labels,
        )
    return list(labels)


def load_text(result: ContactResult) -> str:
    """Return the load of a result as text for a title."""
    return format_engineering(result.total_load, result.pair.load_unit, 3)


def doubt_suffix(result: ContactResult | ElastoplasticResult) -> str:
    """Return the suffix of a title for a result that is not reliable; else an empty text."""
    return "" if result.converged else " (NOT CONVERGED)"
