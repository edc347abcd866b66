"""Maps of surfaces and results, drawn from stored values.

Every function returns a `matplotlib.figure.Figure` that belongs to the caller: no pyplot, no
global state. Maps keep their true aspect, with row 0 at the top as in an image.

A map with more points than a figure has dots is drawn in cells of several points. In maps of
contact and gap, a cell mixes the colors of its points by their shares, so that areas in the figure
are contact areas. In a map of the pressure, a cell shows its largest pressure, so that no peak is
lost; a note below gives the shares of the figure and of the points in contact.
Percentages and areas are always counted on the points.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array
from roughcontact.contact.result import ContactResult
from roughcontact.contact.spots import MIN_SPOT_PIXELS
from roughcontact.drawing import style
from roughcontact.drawing.sections import draw_histogram, window
from roughcontact.errors import input_error, require_positive
from roughcontact.surface.surface import Surface
from roughcontact.units import format_engineering, format_percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.image import AxesImage


Mask = NDArray[np.bool_]

# Share of the contact area within the scale of a pressure map.
_SHOWN = 0.995


class Limits(NamedTuple):
    """Ends of a color scale, and whether there are values beyond the ends."""

    low: float
    high: float
    below: bool
    above: bool


def height_limits(values: Array) -> Limits:
    """Return the limits that span the middle 99 % of the heights of cells [m]."""
    there = values[np.isfinite(values)]
    low, high = np.percentile(there, (0.5, 99.5)) if there.size else (0.0, 0.0)
    if not high > low:
        # Flat map, or a map with few features outside the percentiles.
        low, high = float(there.min(initial=0)), float(there.max(initial=0))
    if not high > low:
        low, high = -0.5e-9, 0.5e-9
    return Limits(float(low), float(high), bool((there < low).any()), bool((there > high).any()))


def gap_limit(values: Array) -> float:
    """Return the upper color limit of an open gap [m], from cell values (NaN where closed)."""
    there = values[np.isfinite(values)]
    top = float(np.percentile(there, 99.5)) if there.size else 0.0
    return top or float(there.max(initial=0.0)) or 1e-9


def pressure_limit(results: Sequence[ContactResult], limit: float | None = None) -> float:
    """Return the upper color limit of pressures [Pa]; see `maps.pressure`."""
    if limit is not None:
        if not 0 < limit < math.inf:
            raise input_error("limit", limit, "must be positive and finite [Pa]")
        return float(limit)
    # If almost no point is saturated, one spike would leave a single color for all other points.
    reached = [
        float(np.quantile(r.pressure[r.contact], _SHOWN))
        for r in results
        if r.saturated_fraction > 0
    ]
    return max(reached or [r.max_pressure for r in results]) or 1.0


def pressure_colors() -> Any:
    """Return the 256 colors of pressures; last axis: red, green, blue, opacity."""
    from matplotlib import colormaps

    # Without the lightest colors, which resemble the background, and the darkest, which resemble
    # values beyond the scale.
    return colormaps["inferno_r"](np.linspace(0.17, 0.63, 256))


class Shares(NamedTuple):
    """Shares of the classes of points in each cell."""

    elastic: Array
    saturated: Array
    missing: Array

    @property
    def touching(self) -> Array:
        """Share of the points in contact."""
        return self.elastic + self.saturated


def cell_shares(contact: Mask, saturated: Mask, gap: Array, blocks: tuple[int, int]) -> Shares:
    """Return the shares of elastic contact, saturated and missing points of each cell."""
    return Shares(
        style.cell_share(contact & ~saturated, blocks),
        style.cell_share(saturated, blocks),
        style.cell_share(np.isnan(gap) & ~contact, blocks),
    )


def class_colors(result: Shares) -> Array:
    """Return the color of each cell: colors of the classes mixed by their shares."""
    colours = (
        (style.ELASTIC, result.elastic),
        (style.SATURATED, result.saturated),
        (style.MISSING, result.missing),
    )
    return style.mix_colors(colours, style.OPEN)


def open_gap(contact: Mask, gap: Array, blocks: tuple[int, int]) -> Array:
    """Return the mean gap of the open points of each cell [m]; NaN without open points."""
    is_open = ~contact & np.isfinite(gap)
    number = style.reduce_cells(np.add, is_open, blocks, np.float64)
    total = style.reduce_cells(np.add, np.where(is_open, np.maximum(gap, 0), 0.0), blocks)
    return np.where(number > 0, total / np.maximum(number, 1), np.nan)


def closed_cover(result: Shares, colour: str) -> Array:
    """Return the overlay of an open gap: colors of closed and of missing points.

    Last axis: red, green, blue, opacity; the opacity is the share of these points in a cell.
    """
    covered = result.touching + result.missing
    cover = style.mix_colors(
        [(style.MISSING, result.missing / np.where(covered > 0, covered, 1.0))], colour
    )
    return np.dstack([cover, np.minimum(covered, 1.0)])


def surface(surface: Surface) -> Figure:
    """Draw the heights of a surface.

    Parameters
    ----------
    surface : Surface
        The map; missing points are gray.

    Returns
    -------
    Figure
        Heights above their mean; the colors span the middle 99 %, with arrows for values
        beyond.
    """
    figure, axes = style.single_axes(surface.size, legend=surface.missing > 0)
    drawn = _draw_surface(axes, surface, style.CELLS_ALONE)
    style.name_axes(
        axes, title=f"Surface heights, Sq {style.in_unit(surface.Sq, drawn.scale, 'm')}"
    )
    style.cell_note(figure, drawn.cell, "the mean height in it")
    return figure


def pressure(result: ContactResult, limit: float | None = None) -> Figure:
    """Draw the contact pressure.

    Parameters
    ----------
    result : ContactResult
        A solved contact.
    limit : float, optional
        Upper limit of the color scale [Pa], for a common scale of several figures; higher
        pressures are black. By default the largest pressure; if points are saturated, the
        pressure that 99.5 % of the contact do not exceed, which is the ceiling unless almost no
        point is saturated.

    Returns
    -------
    Figure
        Pressure in contact; a light neutral color elsewhere.

    Raises
    ------
    InputError
        If the limit is not positive and finite.
    """
    top = pressure_limit([result], limit)
    figure, axes = style.single_axes(result.surface.size, legend=False)
    drawn = _draw_pressure(axes, result.pressure, result.surface.size, top, style.CELLS_ALONE)
    _pressure_bar(axes, drawn.image, top, over=result.max_pressure > top)
    style.name_axes(
        axes,
        title=f"Contact pressure at {style.load_text(result)}, largest "
        f"{style.in_unit(result.max_pressure, drawn.scale, 'Pa')}{style.doubt_suffix(result)}",
    )
    style.cell_note(
        figure, drawn.cell, "the largest pressure in it", _marked_share_text(result, drawn.cell)
    )
    return figure


def contact(result: ContactResult) -> Figure:
    """Draw the contact, with points at the pressure ceiling.

    Parameters
    ----------
    result : ContactResult
        A solved contact.

    Returns
    -------
    Figure
        Classes: no contact, elastic contact, saturated, and missing points. A cell of several
        points mixes their colors by their shares; the legend gives the shares of the map,
        counted on the points.
    """
    figure, axes = style.single_axes(result.surface.size, bar=False)
    drawn = _draw_contact(axes, result, style.CELLS_ALONE)
    style.name_axes(axes, title=f"Contact at {style.load_text(result)}{style.doubt_suffix(result)}")
    style.cell_note(figure, drawn.cell, _IN_SHARES)
    return figure


def gap(result: ContactResult) -> Figure:
    """Draw the gap between the bodies.

    Parameters
    ----------
    result : ContactResult
        A solved contact.

    Returns
    -------
    Figure
        Open gap, linear from zero to the 99.5th percentile; closed points (with pressure) and
        missing points have separate colors. A cell of several points shows the mean gap of its
        open points, covered with the color of the closed points in their share.
    """
    figure, axes = style.single_axes(result.surface.size)
    blocks, scale = draw_gap(axes, result, style.CELLS_ALONE)
    entries = [(style.CLOSED, f"closed {format_percent(result.contact_fraction)}")]
    lost = float(np.count_nonzero(np.isnan(result.gap))) / result.gap.size
    if lost:
        entries.append((style.MISSING, f"missing {format_percent(lost)}"))
    style.patch_legend(axes, entries)
    mean = style.in_unit(result.mean_gap, scale, "m")
    style.name_axes(
        axes,
        title=f"Open gap at {style.load_text(result)}, mean {mean}{style.doubt_suffix(result)}",
    )
    style.cell_note(figure, blocks, "the mean of its open gap, and its closed share")
    return figure


def comparison(
    results: Sequence[ContactResult], labels: Sequence[str], limit: float | None = None
) -> Figure:
    """Draw several results side by side: pressure above, contact below.

    Parameters
    ----------
    results : sequence of ContactResult
        Solved contacts, for example with and without a ceiling.
    labels : sequence of str
        One name per result.
    limit : float, optional
        Upper limit of the common color scale [Pa]; higher pressures are black. By default the
        highest ceiling reached, else the largest pressure.

    Returns
    -------
    Figure
        One column per result, all pressures on the same color scale.

    Raises
    ------
    InputError
        If there is no result, the labels do not fit, or the limit is not positive and finite.
    """
    names = style.result_names(results, labels)
    top = pressure_limit(results, limit)
    aspect = max(style.shown_aspect(result.surface.size) for result in results)
    width, height = 4.9 * len(results) + 1.0, 8.4 * aspect + 2.7
    height += 1.4 if aspect <= style.MIN_LABEL_RATIO else 0.0
    figure, grid = style.panels(width, height, 2, len(results), squeeze=False)
    over = max(result.max_pressure for result in results) > top
    cells = []
    for column, (result, name) in enumerate(zip(results, names, strict=True)):
        upper, lower = grid[:, column]
        size = result.surface.size
        drawn = _draw_pressure(upper, result.pressure, size, top, style.CELLS_IN_PANEL)
        largest = style.in_unit(result.max_pressure, drawn.scale, "Pa")
        load = style.load_text(result)
        title = f"{name}{style.doubt_suffix(result)}\n{load}, largest pressure {largest}"
        style.name_axes(upper, title=title)
        if column == len(results) - 1:
            _pressure_bar(upper, drawn.image, top, over=over)
        cells.append(_draw_contact(lower, result, style.CELLS_IN_PANEL).cell)
    style.cell_note(figure, max(cells), _PRESSURE_OR_SHARES)
    return figure


def overview(result: ContactResult) -> Figure:
    """Draw surface, pressure, contact and pressure distribution of a result on one page.

    Parameters
    ----------
    result : ContactResult
        A solved contact.

    Returns
    -------
    Figure
        Four panels below the main quantities.
    """
    height = 9.6 * max(style.shown_aspect(result.surface.size), 0.6) + 3.2
    figure, grid = style.panels(12.0, height, 2, 2)
    top = pressure_limit([result])
    drawn = _draw_surface(grid[0, 0], result.surface, style.CELLS_IN_PANEL)
    name = "Surface" if result.counter_surface is None else "Surface of the body"
    rms = style.in_unit(result.surface.Sq, drawn.scale, "m")
    style.name_axes(grid[0, 0], title=f"{name}, Sq {rms}")
    size = result.surface.size
    pressures = _draw_pressure(grid[0, 1], result.pressure, size, top, style.CELLS_IN_PANEL)
    _pressure_bar(grid[0, 1], pressures.image, top, over=result.max_pressure > top)
    style.name_axes(grid[0, 1], title="Contact pressure")
    _draw_contact(grid[1, 0], result, style.CELLS_IN_PANEL)
    style.name_axes(grid[1, 0], title="Contact")
    draw_histogram(grid[1, 1], [result], [""], "linear")
    grid[1, 1].set_title("Distribution of the contact pressure", fontsize=style.TITLE, pad=24)
    certificate = f"certificate {result.certificate:.1e}"
    saturated = f"saturated {format_percent(result.saturated_fraction)}"
    words = [
        f"load {style.load_text(result)}",
        f"contact {format_percent(result.contact_fraction)}",
        "no ceiling" if result.ceiling is None else saturated,
        f"largest pressure {format_engineering(result.max_pressure, 'Pa', 3)}",
        certificate if result.converged else f"NOT CONVERGED, {certificate}",
    ]
    figure.suptitle(
        "  ·  ".join(words) + f"\nregime: {result.regime}",
        fontsize=style.TITLE + 1,
        linespacing=1.4,
    )
    shown = f"the mean height, {_PRESSURE_OR_SHARES}"
    style.cell_note(figure, drawn.cell, shown, _marked_share_text(result, pressures.cell))
    return figure


def close_up(result: ContactResult, point: tuple[int, int], width: float) -> Figure:
    """Draw pressure and contact around a point.

    Parameters
    ----------
    result : ContactResult
        A solved contact.
    point : (int, int)
        Indices ``(y, x)`` of the central point.
    width : float
        Side of the drawn square [m], around the point but within the map.

    Returns
    -------
    Figure
        Pressure on the left, on the scale of `pressure`; no contact, elastic contact, saturated
        and missing points on the right, in the colors of `contact`.

    Raises
    ------
    InputError
        If the point is outside the map, or the width is not positive and finite.
    """
    require_positive(width=width)
    if not all(0 <= index < points for index, points in zip(point, result.gap.shape, strict=True)):
        raise input_error("point", point, f"must be inside the map of {result.gap.shape} points")
    rows, columns = (
        slice(*window(point[axis], result.surface.pixel[axis], result.surface.shape[axis], width))
        for axis in (0, 1)
    )
    pixel = result.surface.pixel
    part = result.pressure[rows, columns]
    corner = rows.start * pixel[0], columns.start * pixel[1]
    size = part.shape[0] * pixel[0], part.shape[1] * pixel[1]
    figure, (left, right) = style.panels(10.8, 4.0 * style.shown_aspect(size) + 2.2, 1, 2)
    top = pressure_limit([result])
    image, blocks, _ = _draw_pressure(left, part, size, top, style.CELLS_IN_PANEL, corner)
    _pressure_bar(left, image, top, over=bool(part.max() > top))
    style.name_axes(left, title="Contact pressure")
    gap = result.gap[rows, columns]
    shares = cell_shares(part > 0, result.saturated[rows, columns], gap, blocks)
    style.draw_map(right, class_colors(shares), size, blocks, part.shape, corner)
    entries = [
        (style.OPEN, "no contact"),
        (style.ELASTIC, "elastic"),
        (style.SATURATED, "saturated"),
    ]
    style.patch_legend(right, entries + [(style.MISSING, "missing")] * bool(np.isnan(gap).any()))
    style.name_axes(right, title="Contact")
    figure.suptitle(
        f"Part of the contact at {style.load_text(result)}{style.doubt_suffix(result)}",
        fontsize=style.TITLE,
    )
    style.cell_note(figure, blocks, _PRESSURE_OR_SHARES)
    return figure


def spots(result: ContactResult) -> Figure:
    """Draw the number of contact spots at least as large as a given area.

    Parameters
    ----------
    result : ContactResult
        A solved contact.

    Returns
    -------
    Figure
        Number of spots over area, both logarithmic. The range of spots of fewer than ten pixels,
        whose size depends on the grid, is shaded.
    """
    areas = result.spots().area
    figure, axes = style.panels(7.2, 5.2)
    pixel = result.pixel_area
    largest = float(areas.max(initial=pixel))
    factor, unit = style.prefixed_area(largest)
    # One point for each distinct area: the number of spots at least as large.
    sizes, counts = np.unique(areas, return_counts=True)
    at_least = np.cumsum(counts[::-1])[::-1]
    axes.axvspan(
        0.5 * pixel * factor,
        MIN_SPOT_PIXELS * pixel * factor,
        color="#ececec",
        label=f"fewer than {MIN_SPOT_PIXELS} pixels: size set by the grid",
    )
    axes.plot(sizes * factor, at_least, "o-", color=style.SERIES[0], ms=4, lw=1.2)
    if areas.size:
        mean = float(areas.mean())
        axes.axvline(
            mean * factor,
            color=style.SERIES[1],
            ls=(0, (5, 3)),
            lw=1.6,
            label=f"mean area {style.in_unit(mean, (factor, unit), 'm²')}",
        )
    style.log_scale(axes, "x")
    style.log_scale(axes, "y")
    axes.set_xlim(0.7 * pixel * factor, max(2 * largest, 2 * MIN_SPOT_PIXELS * pixel) * factor)
    axes.set_ylim(0.7, 2.0 * max(areas.size, 5))
    style.name_axes(axes, f"area A of a spot [{unit}]", "spots of at least that area")
    noun = "spot" if areas.size == 1 else "spots"
    title = f"{areas.size} contact {noun} at {style.load_text(result)}"
    style.plain_axes(axes, title=title + style.doubt_suffix(result))
    style.legend_below(axes, columns=2)
    return figure


def draw_gap(
    axes: Axes, result: ContactResult, cells: int
) -> tuple[tuple[int, int], tuple[float, str]]:
    """Draw the open gap of a contact into axes; return points per cell, factor and unit."""
    from matplotlib import colormaps

    size, shape = result.surface.size, result.gap.shape
    blocks = style.cell_size(shape, size, cells)
    values = open_gap(result.contact, result.gap, blocks)
    top = gap_limit(values)
    factor, unit = style.axis_unit(top, "m")
    image = style.draw_map(axes, values * factor, size, blocks, shape)
    image.set_cmap(colormaps["Blues"].with_extremes(bad=style.MISSING))
    image.set_clim(0, top * factor)
    shares = cell_shares(result.contact, result.saturated, result.gap, blocks)
    style.draw_map(axes, closed_cover(shares, style.CLOSED), size, blocks, shape)
    extend = "max" if (values > top).any() else "neither"
    style.colour_bar(axes, image, f"open gap [{unit}]", extend)
    return blocks, (factor, unit)


class _Drawn(NamedTuple):
    image: AxesImage
    cell: tuple[int, int]
    scale: tuple[float, str] = (1.0, "")


def _draw_surface(axes: Axes, surface: Surface, cells: int) -> _Drawn:
    from matplotlib import colormaps

    blocks = style.cell_size(surface.shape, surface.size, cells)
    values = style.cell_mean(surface.heights, blocks)
    values -= np.nanmean(surface.heights)
    low, high, below, above = height_limits(values)
    factor, unit = style.axis_unit(max(abs(low), abs(high)), "m")
    image = style.draw_map(axes, values * factor, surface.size, blocks, surface.shape)
    image.set_cmap(colormaps["viridis"].with_extremes(bad=style.MISSING))
    image.set_clim(low * factor, high * factor)
    extend = {(0, 0): "neither", (1, 0): "min", (0, 1): "max", (1, 1): "both"}[below, above]
    style.colour_bar(axes, image, f"height above mean [{unit}]", extend)
    if surface.missing:
        share = format_percent(surface.missing / surface.heights.size)
        style.patch_legend(axes, [(style.MISSING, f"missing {share}")])
    return _Drawn(image, blocks, (factor, unit))


def _draw_pressure(
    axes: Axes,
    pressure: Array,
    size: tuple[float, float],
    top: float,
    cells: int,
    corner: tuple[float, float] = (0.0, 0.0),
) -> _Drawn:
    blocks = style.cell_size(pressure.shape, size, cells)
    values = style.cell_max(pressure, blocks)
    factor, unit = style.axis_unit(top, "Pa")
    values = np.where(values > 0, values * factor, np.nan)
    image = style.draw_map(axes, values, size, blocks, pressure.shape, corner)
    image.set_cmap(
        style.listed_colormap(pressure_colors()).with_extremes(bad=style.OPEN, over=style.OVER)
    )
    image.set_clim(0, top * factor)
    return _Drawn(image, blocks, (factor, unit))


def _pressure_bar(axes: Axes, image: AxesImage, top: float, over: bool) -> None:
    style.colour_bar(
        axes, image, f"pressure [{style.axis_unit(top, 'Pa')[1]}]", "max" if over else "neither"
    )


def _draw_contact(axes: Axes, result: ContactResult, cells: int) -> _Drawn:
    size, shape = result.surface.size, result.pressure.shape
    blocks = style.cell_size(shape, size, cells)
    missing = int(np.count_nonzero(np.isnan(result.gap)))
    shares = cell_shares(result.contact, result.saturated, result.gap, blocks)
    image = style.draw_map(axes, class_colors(shares), size, blocks, shape)
    lost = missing / result.pressure.size
    touching, saturated = result.contact_fraction, result.saturated_fraction
    entries = [
        (style.OPEN, f"no contact\n{format_percent(1 - touching - lost)}"),
        (style.ELASTIC, f"elastic\n{format_percent(touching - saturated)}"),
        (style.SATURATED, f"saturated\n{format_percent(saturated)}"),
    ]
    if missing:
        entries.append((style.MISSING, f"missing\n{format_percent(lost)}"))
    style.patch_legend(axes, entries)
    return _Drawn(image, blocks)


_IN_SHARES = "the classes in their shares"
_PRESSURE_OR_SHARES = f"the largest pressure in it or {_IN_SHARES}"


def _marked_share_text(result: ContactResult, blocks: tuple[int, int]) -> str:
    """Return the note on a map of largest pressures: marked share, and share in contact."""
    cells = style.cell_max(result.pressure, blocks) > 0
    marked = (
        float(style.cell_points(result.pressure.shape, blocks)[cells].sum()) / result.pressure.size
    )
    return (
        f"That marks {format_percent(marked)} of the figure of the pressure, while "
        f"{format_percent(result.contact_fraction)} of the map is in contact."
    )
