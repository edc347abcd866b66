"""Figures of surfaces and results; they show what is stored and compute nothing new.

Every function returns a `matplotlib.figure.Figure` that belongs to the caller: no pyplot, no
global state. Maps keep their true aspect, with row 0 at the top as in an image.

A map with more points than a figure has dots is drawn in cells of several points. A cell shows the
largest pressure, or the most severe class of contact, of its points, so that the smallest spot
stays visible; spots then look larger than they are, which a note below the map says. Percentages
and areas are always counted on the points.
"""

from __future__ import annotations

import contextlib
import math
import os
import secrets
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughcontact.contact.load_curve import LoadCurve
from roughcontact.contact.load_history import SHAKEN_DOWN, LoadHistory
from roughcontact.contact.result import ContactResult
from roughcontact.contact.spots import FEW_PIXELS
from roughcontact.errors import InputError, RoughcontactError, require_positive
from roughcontact.plots.style import (
    CELLS_ALONE,
    CELLS_IN_PANEL,
    CLOSED,
    DPI,
    ELASTIC,
    LABEL,
    MISSING,
    NEUTRAL,
    OPEN,
    OVER,
    SATURATED,
    SERIES,
    TICK,
    TITLE,
    UPRIGHT,
    cell_any,
    cell_max,
    cell_mean,
    cell_note,
    cell_size,
    colour_bar,
    draw_map,
    few_ticks,
    layout,
    legend_below,
    listed,
    patch_legend,
    plain_axes,
    prefixed,
    prefixed_area,
    reduced,
    shared_legend,
    shown_aspect,
    single_axes,
)
from roughcontact.solvers import tilt
from roughcontact.surface import roughness
from roughcontact.surface.surface import Surface
from roughcontact.units import engineering, percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.image import AxesImage

    from roughcontact.contact.subsurface import StressResult

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_SECTION_ROWS = 400
_SUFFIXES = {".png": "png", ".svg": "svg", ".pdf": "pdf"}


def surface(surface: Surface) -> Figure:
    """Draw the heights of a surface.

    Parameters
    ----------
    surface : Surface
        The map; missing points are drawn grey.

    Returns
    -------
    Figure
        Heights above their mean; the colours span the middle 99 % of them, with arrows where
        there are more.
    """
    figure, axes = single_axes(surface.size, legend=surface.missing > 0)
    drawn = _draw_surface(axes, surface, CELLS_ALONE)
    axes.set_title(f"Surface heights, Sq {engineering(surface.Sq, 'm', 3)}", fontsize=TITLE)
    cell_note(figure, drawn.cell, "the mean height")
    return figure


def pressure(result: ContactResult, limit: float | None = None) -> Figure:
    """Draw the contact pressure.

    Parameters
    ----------
    result : ContactResult
        A solved contact.
    limit : float, optional
        Top of the colour scale [Pa], the same for figures that are to be compared; pressures
        above it are black. By default the largest pressure; where some pixels are saturated,
        the pressure that 99.5 % of the contact do not exceed, which is the ceiling unless next
        to nothing reaches it.

    Returns
    -------
    Figure
        Pressure where there is contact; a neutral light colour elsewhere.

    Raises
    ------
    InputError
        If the limit is not positive and finite.
    """
    top = _limit([result], limit)
    figure, axes = single_axes(result.surface.size, legend=False)
    drawn = _draw_pressure(axes, result, top, CELLS_ALONE)
    _pressure_bar(axes, drawn.image, top, over=result.max_pressure > top)
    axes.set_title(
        f"Contact pressure at {_load(result)}, largest "
        f"{engineering(result.max_pressure, 'Pa', 3)}{_doubt(result)}",
        fontsize=TITLE,
    )
    cell_note(figure, drawn.cell, "the largest pressure")
    return figure


def contact(result: ContactResult) -> Figure:
    """Draw where the bodies touch, and where the pressure is at its ceiling.

    Parameters
    ----------
    result : ContactResult
        A solved contact.

    Returns
    -------
    Figure
        Three classes: no contact, elastic contact, saturated; and a fourth for missing points.
        The legend gives their shares of the map, counted on the points.
    """
    figure, axes = single_axes(result.surface.size, bar=False)
    drawn = _draw_contact(axes, result, CELLS_ALONE)
    axes.set_title(f"Contact at {_load(result)}{_doubt(result)}", fontsize=TITLE)
    cell_note(figure, drawn.cell, "the most severe class")
    return figure


def gap(result: ContactResult) -> Figure:
    """Draw the gap that is left between the bodies.

    Parameters
    ----------
    result : ContactResult
        A solved contact.

    Returns
    -------
    Figure
        Open gap, linear from zero up to the 99.5th percentile; closed points (those with
        pressure) and missing ones have colours of their own.
    """
    from matplotlib import colormaps

    figure, axes = single_axes(result.surface.size)
    size = result.surface.size
    blocks = cell_size(result.gap.shape, size, CELLS_ALONE)
    values = cell_mean(np.maximum(result.gap, 0), blocks)
    closed = cell_any(result.contact, blocks)
    values[closed] = np.nan
    there = values[np.isfinite(values)]
    top = float(np.percentile(there, 99.5)) if there.size else 0.0
    top = top or float(there.max(initial=0.0)) or 1e-9
    factor, unit = prefixed(top, "m")
    image = draw_map(axes, values * factor, size, blocks, result.gap.shape)
    image.set_cmap(colormaps["Blues"].with_extremes(bad=MISSING))
    image.set_clim(0, top * factor)
    marks = draw_map(axes, np.where(closed, 1.0, np.nan), size, blocks, result.gap.shape)
    marks.set_cmap(listed([CLOSED]))
    colour_bar(axes, image, f"open gap [{unit}]", "max" if (there > top).any() else "neither")
    entries = [(CLOSED, f"closed {percent(result.contact_fraction)}")]
    missing = int(np.count_nonzero(np.isnan(result.gap)))
    if missing:
        entries.append((MISSING, f"missing {percent(missing / result.gap.size)}"))
    patch_legend(axes, entries)
    axes.set_title(
        f"Open gap at {_load(result)}, mean {engineering(result.mean_gap, 'm', 3)}{_doubt(result)}",
        fontsize=TITLE,
    )
    cell_note(figure, blocks, "the mean gap, or closed for any closed point")
    return figure


def pressure_histogram(
    results: ContactResult | Sequence[ContactResult],
    labels: Sequence[str] | None = None,
    scale: str = "linear",
) -> Figure:
    """Draw how the contact area is spread over the pressure.

    Parameters
    ----------
    results : ContactResult or sequence of them
        One or several solved contacts, drawn over the same bins.
    labels : sequence of str, optional
        One name a result.
    scale : {"linear", "log"}
        Of the pressure axis. With ``"log"`` the density is per decade of pressure.

    Returns
    -------
    Figure
        Density of contact area over pressure, in percent of the result's contact area. Points
        at the ceiling, a peak without width, are not drawn but stated in the legend.

    Raises
    ------
    InputError
        If there is no result, the labels do not fit, or the scale is unknown.
    """
    from matplotlib.figure import Figure

    if isinstance(results, ContactResult):
        results = [results]
    names = _names(results, labels)
    if scale not in ("linear", "log"):
        raise InputError(f"must be 'linear' or 'log', got {scale!r}", argument="scale", value=scale)
    figure = Figure(figsize=(7.2, 5.2), dpi=DPI, layout=layout())
    axes = figure.subplots()
    _draw_histogram(axes, results, names, scale)
    axes.set_title("Distribution of the contact pressure", fontsize=TITLE, pad=24)
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
        One name a result.
    limit : float, optional
        Top of the common colour scale [Pa]; pressures above it are black. By default the highest
        ceiling that is reached, else the largest pressure.

    Returns
    -------
    Figure
        One column a result, all pressures with the same colours.

    Raises
    ------
    InputError
        If there is no result, the labels do not fit, or the limit is not positive and finite.
    """
    from matplotlib.figure import Figure

    names = _names(results, labels)
    top = _limit(results, limit)
    aspect = max(shown_aspect(result.surface.size) for result in results)
    width, height = 4.9 * len(results) + 1.0, 8.4 * aspect + 2.7
    height += 1.4 if aspect <= UPRIGHT else 0.0
    figure = Figure(figsize=(width, height), dpi=DPI, layout=layout())
    grid = figure.subplots(2, len(results), squeeze=False)
    over = max(result.max_pressure for result in results) > top
    cells = []
    for column, (result, name) in enumerate(zip(results, names, strict=True)):
        upper, lower = grid[:, column]
        drawn = _draw_pressure(upper, result, top, CELLS_IN_PANEL)
        largest = engineering(result.max_pressure, "Pa", 3)
        upper.set_title(
            f"{name}{_doubt(result)}\n{_load(result)}, largest pressure {largest}", fontsize=TITLE
        )
        if column == len(results) - 1:
            _pressure_bar(upper, drawn.image, top, over=over)
        cells.append(_draw_contact(lower, result, CELLS_IN_PANEL).cell)
    cell_note(figure, max(cells), "the largest pressure or the most severe class")
    return figure


def stress_depth(result: StressResult) -> Figure:
    """Draw the largest stresses at each depth below a contact.

    Parameters
    ----------
    result : StressResult
        The stress below a contact.

    Returns
    -------
    Figure
        Largest von Mises and Tresca stress and amplitude of the orthogonal shear stress against
        the depth, with the yield strength where it is known. The depth axis is logarithmic, but
        for its beginning, if the largest stress would else drown at the surface.
    """
    from matplotlib.figure import Figure

    profile = result.profile
    figure = Figure(figsize=(7.2, 6.0), dpi=DPI, layout=layout())
    axes = figure.subplots()
    strength = profile.yield_strength or 0.0
    factor, unit = prefixed(max(profile.max_tresca, strength), "Pa")
    length_factor, length_unit = prefixed(float(profile.depths[-1]), "m")
    depths = profile.depths * length_factor
    for (values, name), colour, line in zip(
        (
            (profile.von_mises, "largest von Mises stress"),
            (profile.tresca, "largest Tresca stress"),
            (profile.orthogonal_shear.max(axis=1), "orthogonal shear amplitude in a pass"),
        ),
        SERIES,
        ("-", "--", ":"),
        strict=False,
    ):
        axes.plot(
            depths, values * factor, line, color=colour, linewidth=1.8, marker=".", label=name
        )
    if strength:
        axes.axhline(strength * factor, color=NEUTRAL, linestyle=(0, (5, 3)), linewidth=1.5)
        axes.annotate(
            f"yield strength {engineering(strength, 'Pa', 3)}",
            (1, strength * factor),
            xycoords=axes.get_yaxis_transform(),
            xytext=(-3, 3),
            textcoords="offset points",
            ha="right",
            fontsize=TICK,
            color=NEUTRAL,
        )
    if depths.size > 2 and profile.depth_of_max < 0.05 * profile.depths[-1]:
        first = 10.0 ** math.ceil(math.log10(float(depths[depths > 0][0])))
        axes.set_xscale("symlog", linthresh=first, linscale=0.5)
    axes.set_xlim(0, float(depths[-1]) or None)
    axes.set_ylim(bottom=0)
    axes.margins(y=0.1)
    axes.set_xlabel(f"depth [{length_unit}]", fontsize=LABEL)
    axes.set_ylabel(f"stress [{unit}]", fontsize=LABEL)
    axes.tick_params(labelsize=TICK)
    axes.grid(True, color="#dddddd", linewidth=0.8)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    legend_below(axes)
    axes.set_title(_stress_title(result), fontsize=TITLE)
    return figure


def stress_section(result: StressResult, along: str = "x", depth: float | None = None) -> Figure:
    """Draw the von Mises stress on a vertical plane through its maximum.

    Parameters
    ----------
    result : StressResult
        The stress below a contact.
    along : {"x", "y"}
        The horizontal axis of the plane.
    depth : float, optional
        How deep to draw [m]; by default to where a quarter of the largest stress is left, but no
        less than a fifth of the side of the map; never deeper than there are depths.

    Returns
    -------
    Figure
        The stress, true to scale, with a cross on its maximum. What exceeds the yield strength
        is black.

    Raises
    ------
    InputError
        If ``along`` is something else, the depth is not positive, or there is but one.
    """
    from matplotlib.figure import Figure

    values = result.von_mises_section(along)
    profile, surface = result.profile, result.contact.surface
    axis = 1 if along == "x" else 0
    side, edge = surface.size[axis], surface.pixel[axis]
    if profile.depths.size < 2:
        raise InputError("a section needs two depths or more, and the result has one")
    if depth is None:
        strong = int(np.flatnonzero(values.max(axis=1) >= 0.25 * values.max())[-1])
        weak = min(strong + 1, profile.depths.size - 1)
        depth = max(float(profile.depths[weak]), 0.2 * side)
    if not 0 < depth < math.inf:
        raise InputError(
            f"must be positive and finite [m], got {depth!r}", argument="depth", value=depth
        )
    depth = min(depth, float(profile.depths[-1]))
    block = max(math.ceil(values.shape[1] / CELLS_ALONE), 1)
    cells = reduced(np.maximum, values, (1, block))
    # Depths are graded: straight lines lead from one to the next.
    fine = depth / _SECTION_ROWS * (np.arange(_SECTION_ROWS) + 0.5)
    rows = np.array([np.interp(fine, profile.depths, column) for column in cells.T]).T
    factor, unit = prefixed(side, "m")
    across = np.append(np.arange(0, values.shape[1], block), values.shape[1]) * edge * factor
    aspect = depth / side
    height = max(5.8 * min(aspect, 1.6), 0.4) + (3.0 if aspect <= 0.45 else 1.8)
    figure = Figure(figsize=(7.2, height), dpi=DPI, layout=layout())
    axes = figure.subplots()
    top, stress_factor, stress_unit = _stress_scale(result)
    mesh = axes.pcolormesh(
        across,
        np.linspace(0, depth * factor, _SECTION_ROWS + 1),
        rows * stress_factor,
        rasterized=True,
    )
    mesh.set_cmap(_stress_colours())
    mesh.set_clim(0, top * stress_factor)
    place = result.place
    axes.plot(
        [place[2 if along == "x" else 1] * factor],
        [place[0] * factor],
        "+",
        color=SERIES[0],
        markersize=11,
        markeredgewidth=2,
        clip_on=False,
    )
    axes.set_aspect("equal")
    axes.set_xlim(0, side * factor)
    axes.set_ylim(depth * factor, 0)
    axes.set_xlabel(f"{along} [{unit}]", fontsize=LABEL)
    axes.set_ylabel(f"depth [{unit}]", fontsize=LABEL)
    axes.tick_params(labelsize=TICK)
    few_ticks(axes, aspect)
    _stress_bar(axes, mesh, result, stress_unit)
    axes.set_title(_stress_title(result), fontsize=TITLE)
    return figure


def stress_map(result: StressResult) -> Figure:
    """Draw the largest von Mises stress below each point of the map.

    Parameters
    ----------
    result : StressResult
        The stress below a contact.

    Returns
    -------
    Figure
        Maximum over the depth, with a cross where it is largest. What exceeds the yield strength
        is black.
    """
    peak, size = result.profile.peak, result.contact.surface.size
    strength = result.profile.yield_strength
    over = strength is not None and result.max_von_mises > strength
    figure, axes = single_axes(size, legend=over)
    blocks = cell_size(peak.shape, size, CELLS_ALONE)
    _, factor, unit = _stress_scale(result)
    image = draw_map(axes, cell_max(peak, blocks) * factor, size, blocks, peak.shape)
    image.set_cmap(_stress_colours())
    image.set_clim(0, _stress_scale(result)[0] * factor)
    length_factor, _ = prefixed(max(size), "m")
    _, y, x = result.place
    axes.plot(
        [x * length_factor], [y * length_factor], "+",
        color=SERIES[0], markersize=11, markeredgewidth=2,
    )  # fmt: skip
    _stress_bar(axes, image, result, unit)
    if over:
        share = percent(float(np.count_nonzero(peak > strength)) / peak.size)
        patch_legend(axes, [(OVER, f"yield strength exceeded below {share} of the map")])
    axes.set_title(_stress_title(result), fontsize=TITLE)
    cell_note(figure, blocks, "the largest stress")
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
        Four panels under the numbers that matter.
    """
    from matplotlib.figure import Figure

    height = 9.6 * max(shown_aspect(result.surface.size), 0.6) + 3.2
    figure = Figure(figsize=(12.0, height), dpi=DPI, layout=layout())
    grid = figure.subplots(2, 2)
    top = _limit([result], None)
    drawn = _draw_surface(grid[0, 0], result.surface, CELLS_IN_PANEL)
    name = "Surface" if result.counter_surface is None else "Surface of the first body"
    grid[0, 0].set_title(f"{name}, Sq {engineering(result.surface.Sq, 'm', 3)}", fontsize=TITLE)
    pressures = _draw_pressure(grid[0, 1], result, top, CELLS_IN_PANEL)
    _pressure_bar(grid[0, 1], pressures.image, top, over=result.max_pressure > top)
    grid[0, 1].set_title("Contact pressure", fontsize=TITLE)
    _draw_contact(grid[1, 0], result, CELLS_IN_PANEL)
    grid[1, 0].set_title("Contact", fontsize=TITLE)
    _draw_histogram(grid[1, 1], [result], [""], "linear")
    grid[1, 1].set_title("Distribution of the contact pressure", fontsize=TITLE, pad=24)
    certificate = f"certificate {result.certificate:.1e}"
    saturated = f"saturated {percent(result.saturated_fraction)}"
    words = [
        f"load {_load(result)}",
        f"contact {percent(result.contact_fraction)}",
        "no ceiling" if result.ceiling is None else saturated,
        f"largest pressure {engineering(result.max_pressure, 'Pa', 3)}",
        certificate if result.converged else f"NOT CONVERGED, {certificate}",
    ]
    figure.suptitle(
        "  ·  ".join(words) + f"\nregime: {result.regime}", fontsize=TITLE + 1, linespacing=1.4
    )
    shown = "the mean height, the largest pressure or the most severe class"
    cell_note(figure, drawn.cell, shown)
    return figure


def hysteresis(history: LoadHistory) -> Figure:
    """Draw load against approach along a history, and what each step dissipates.

    Parameters
    ----------
    history : LoadHistory
        A solved path.

    Returns
    -------
    Figure
        The loop, with the parts that indent in another colour than the elastic ones; below it
        the dissipated energy of every step and the volume indented so far.
    """
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    figure = Figure(figsize=(7.2, 8.6), dpi=DPI, layout=layout())
    upper, lower = figure.subplots(2, 1, height_ratios=(1.7, 1.0))
    _draw_loop(upper, history)

    number = np.arange(1, len(history.steps) + 1)
    energy = history.column("dissipated_energy")
    volume = np.cumsum(history.column("indentation_volume"))
    factor, unit = prefixed(float(energy.max()), "J")
    lower.bar(number, energy * factor, width=0.7, color=SATURATED)
    lower.set_xlabel("step", fontsize=LABEL)
    lower.set_ylabel(f"dissipated energy [{unit}]", fontsize=LABEL, color=SATURATED)
    lower.xaxis.set_major_locator(MaxNLocator(integer=True))
    lower.set_xlim(0.3, number[-1] + 0.7)
    lower.set_ylim(0, 1.15 * float(energy.max()) * factor or 1)
    # Cubic micrometres: prefixes of m³ mislead.
    total = lower.twinx()
    total.plot(number, volume * 1e18, color=SERIES[0], marker="o", markersize=4, linewidth=1.8)
    total.set_ylabel("indented volume so far [µm³]", fontsize=LABEL, color=SERIES[0])
    total.set_ylim(0, 1.15 * float(volume[-1]) * 1e18 or 1)
    for axes in (lower, total):
        axes.tick_params(labelsize=TICK)
        axes.spines["top"].set_visible(False)
    lower.set_title(
        f"{engineering(history.dissipated_energy, 'J', 3)} dissipated, "
        + ("shaken down" if history.shaken_down else "shakedown not shown"),
        fontsize=TITLE,
    )
    return figure


def close_up(result: ContactResult, point: tuple[int, int], width: float) -> Figure:
    """Draw pressure and contact around a point.

    Parameters
    ----------
    result : ContactResult
        A solved contact.
    point : (int, int)
        Indices ``(y, x)`` of the point in the middle.
    width : float
        Side of the square that is drawn [m], around the point but within the map.

    Returns
    -------
    Figure
        Pressure on the left, on the scale of `pressure`; no contact, elastic contact, saturated
        and missing points on the right, in the colours of `contact`.

    Raises
    ------
    InputError
        If the point does not lie on the map, or the width is not positive and finite.
    """
    from matplotlib.figure import Figure

    require_positive(width=width)
    if not all(0 <= index < points for index, points in zip(point, result.gap.shape, strict=True)):
        raise InputError(
            f"must lie on the map of {result.gap.shape} points, got {point!r}",
            argument="point",
            value=point,
        )
    rows, columns = (
        slice(*_window(point[axis], result.surface.pixel[axis], result.surface.shape[axis], width))
        for axis in (0, 1)
    )
    pixel = result.surface.pixel
    part = result.pressure[rows, columns]
    corner = rows.start * pixel[0], columns.start * pixel[1]
    size = part.shape[0] * pixel[0], part.shape[1] * pixel[1]
    blocks = cell_size(part.shape, size, CELLS_IN_PANEL)
    figure = Figure(figsize=(10.8, 4.0 * shown_aspect(size) + 2.2), dpi=DPI, layout=layout())
    left, right = figure.subplots(1, 2)
    top = _limit([result], None)
    values = cell_max(part, blocks)
    factor, _ = prefixed(top, "Pa")
    values = np.where(values > 0, values * factor, np.nan)
    image = draw_map(left, values, size, blocks, part.shape, corner)
    _colour_pressure(image, top * factor)
    _pressure_bar(left, image, top, over=bool(part.max() > top))
    left.set_title("Contact pressure", fontsize=TITLE)
    gap = result.gap[rows, columns]
    classes = _classes(part > 0, result.saturated[rows, columns], gap, blocks)
    _colour_classes(draw_map(right, classes, size, blocks, part.shape, corner))
    entries = [(OPEN, "no contact"), (ELASTIC, "elastic"), (SATURATED, "saturated")]
    patch_legend(right, entries + [(MISSING, "missing")] * bool(np.isnan(gap).any()))
    right.set_title("Contact", fontsize=TITLE)
    figure.suptitle(f"Part of the contact at {_load(result)}{_doubt(result)}", fontsize=TITLE)
    cell_note(figure, blocks, "the largest pressure or the most severe class")
    return figure


def section(result: ContactResult, width: float | None = None) -> Figure:
    """Draw sections through the highest peak: the profile before and under load, the pressure.

    Parameters
    ----------
    result : ContactResult
        A solved contact.
    width : float, optional
        Length that is drawn [m], around the peak but within the map; by default all of it.

    Returns
    -------
    Figure
        Along x on the left, along y on the right. Zero height is the counter-body: the profile
        before loading, moved as a whole by approach and tilt, overlaps it; under load it does not,
        but for the indentation of saturated points. Of two measured bodies it is the sum of their
        heights. Heights are exaggerated.

    Raises
    ------
    InputError
        If the width is not positive and finite.
    """
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    if width is not None:
        require_positive(width=width)
    before = result.initial_gap
    peak = _highest(before)
    length = min(width or math.inf, max(result.surface.size))
    factor, unit = prefixed(length, "m")
    lines = [_line(result, before, peak, axis, width or math.inf) for axis in (1, 0)]
    figure = Figure(figsize=(10.6, 7.2), dpi=DPI, layout=layout())
    grid = figure.subplots(2, 2, sharex="col", sharey="row", height_ratios=(1.25, 1))
    tall = max(_largest(line.before, line.under) for line in lines)
    height_factor, height_unit = prefixed(tall, "m")
    top = max(_largest(line.pressure) for line in lines)
    # Ceilings far above all pressures do not stretch the axis.
    ceilings = [line.ceiling for line in lines if line.ceiling is not None]
    top = max([top, *(_largest(values[values <= 2 * top]) for values in ceilings)])
    pressure_factor, pressure_unit = prefixed(top, "Pa")
    for column, (line, name, other) in enumerate(zip(lines, "xy", "yx", strict=True)):
        upper, lower = grid[:, column]
        _draw_profile(upper, line, factor, height_factor)
        _draw_line_pressure(lower, line, top, factor, pressure_factor)
        upper.set_title(
            f"along {name}, at {other} = {engineering(line.across, 'm', 4)}", fontsize=TITLE
        )
        lower.set_xlabel(f"{name} [{unit}]", fontsize=LABEL)
        lower.set_xlim(line.limits[0] * factor, line.limits[1] * factor)
        for axes in (upper, lower):
            axes.axvline(line.peak * factor, color=NEUTRAL, linewidth=0.9, linestyle=":")
            axes.xaxis.set_major_locator(MaxNLocator(6))
            plain_axes(axes)
    what = "height" if result.counter_surface is None else "sum of heights"
    grid[0, 0].set_ylabel(f"{what} [{height_unit}]", fontsize=LABEL)
    grid[1, 0].set_ylabel(f"pressure [{pressure_unit}]", fontsize=LABEL)
    grid[1, 0].set_ylim(0, 1.08 * (top or 1.0) * pressure_factor)
    shared_legend(figure, grid)
    figure.suptitle(
        f"Sections through the highest peak at {_load(result)}{_doubt(result)}", fontsize=TITLE
    )
    return figure


def bearing_curve(surface: Surface) -> Figure:
    """Draw the areal material ratio curve of a surface (bearing or Abbott-Firestone curve).

    Parameters
    ----------
    surface : Surface
        The map; missing points are left out.

    Returns
    -------
    Figure
        Height above the mean over the share of the points that lie above it, with the
        equivalent straight line of the core and the triangles of reduced peaks and dales, see
        `roughness.core_parameters`.
    """
    from matplotlib.figure import Figure

    ratio, height = roughness.material_ratio_curve(surface.heights)
    core = roughness.core_parameters(ratio, height)
    # The line meets the curve at Smr1 and Smr2, unless it leaves the heights of the map before.
    if core["Smr1"] > 0:
        upper = float(np.interp(core["Smr1"], ratio, height))
    elif core["Smr2"] < 1:
        upper = float(np.interp(core["Smr2"], ratio, height)) + core["Sk"]
    else:
        upper = core["Sk"] / 2
    lower = upper - core["Sk"]
    factor, unit = prefixed(float(np.abs(height).max()), "m")
    figure = Figure(figsize=(7.2, 5.2), dpi=DPI, layout=layout())
    axes = figure.subplots()
    first, second = 100 * core["Smr1"], 100 * core["Smr2"]
    axes.plot(100 * ratio, height * factor, color=SERIES[0], linewidth=2.2, zorder=3)
    axes.fill(
        [0, 0, first],
        [upper * factor, (upper + core["Spk"]) * factor, upper * factor],
        color=SERIES[4],
        label=f"reduced peaks: Spk {engineering(core['Spk'], 'm', 3)}, Smr1 {first:.1f} %",
    )
    axes.plot(
        [0, 100],
        [upper * factor, lower * factor],
        color=NEUTRAL,
        linestyle=(0, (5, 3)),
        linewidth=1.5,
        label=f"core: Sk {engineering(core['Sk'], 'm', 3)}",
    )
    axes.fill(
        [100, 100, second],
        [lower * factor, (lower - core["Svk"]) * factor, lower * factor],
        color=SERIES[5],
        label=f"reduced dales: Svk {engineering(core['Svk'], 'm', 3)}, Smr2 {second:.1f} %",
    )
    for value in (upper, lower):
        axes.axhline(value * factor, color=NEUTRAL, linewidth=0.8, linestyle=":")
    axes.set_xlim(0, 100)
    axes.set_xlabel("material ratio [%]", fontsize=LABEL)
    axes.set_ylabel(f"height above mean [{unit}]", fontsize=LABEL)
    axes.set_title("Material ratio curve", fontsize=TITLE)
    plain_axes(axes)
    legend_below(axes)
    return figure


def spots(result: ContactResult) -> Figure:
    """Draw how many contact spots are at least as large as a given area.

    Parameters
    ----------
    result : ContactResult
        A solved contact.

    Returns
    -------
    Figure
        Number of spots over area, both logarithmic. Spots of fewer than ten pixels, whose size is
        the grid's, lie on a shaded ground.
    """
    from matplotlib.figure import Figure

    areas = result.spots().area
    figure = Figure(figsize=(7.2, 5.2), dpi=DPI, layout=layout())
    axes = figure.subplots()
    pixel = result.pixel_area
    largest = float(areas.max(initial=pixel))
    factor, unit = prefixed_area(largest)
    # Equal areas make one point: how many spots are at least that large.
    sizes, counts = np.unique(areas, return_counts=True)
    at_least = np.cumsum(counts[::-1])[::-1]
    axes.axvspan(
        0.5 * pixel * factor,
        FEW_PIXELS * pixel * factor,
        color="#ececec",
        label=f"fewer than {FEW_PIXELS} pixels: size set by the grid",
    )
    axes.plot(sizes * factor, at_least, "o-", color=SERIES[0], markersize=4, linewidth=1.2)
    if areas.size:
        mean = float(areas.mean())
        axes.axvline(
            mean * factor,
            color=SERIES[1],
            linestyle=(0, (5, 3)),
            linewidth=1.6,
            label=f"mean area {engineering(mean, 'm²', 3)}",
        )
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(0.7 * pixel * factor, max(2 * largest, 2 * FEW_PIXELS * pixel) * factor)
    axes.set_ylim(0.7, 2.0 * max(areas.size, 5))
    axes.set_xlabel(f"area A of a spot [{unit}]", fontsize=LABEL)
    axes.set_ylabel("spots of at least that area", fontsize=LABEL)
    noun = "spot" if areas.size == 1 else "spots"
    axes.set_title(
        f"{areas.size} contact {noun} at {_load(result)}{_doubt(result)}", fontsize=TITLE
    )
    plain_axes(axes)
    legend_below(axes, columns=2)
    return figure


def load_curve(curve: LoadCurve) -> Figure:
    """Draw a load curve: areas, approach and mean gap, stiffness, and number of spots.

    Parameters
    ----------
    curve : LoadCurve
        The solved loads.

    Returns
    -------
    Figure
        Four panels over the load. Beside the areas stand Persson's theory and simple laws: the
        line A = κ W/(E* h') through the low loads, see `LoadCurve.low_load_slope`, or load over
        ceiling, where a ceiling is reached.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 9.4), dpi=DPI, layout=layout())
    grid = figure.subplots(2, 2)
    load = curve.column("load")
    factor, unit = prefixed(float(load.max()), "N")
    _draw_areas(grid[0, 0], curve, factor)
    lengths = {
        "approach": (curve.column("approach"), SERIES[0], "o-"),
        "mean gap": (curve.column("mean_gap"), SERIES[1], "s-"),
    }
    longest = max(float(values.max()) for values, *_ in lengths.values())
    scale, length_unit = prefixed(longest, "m")
    for name, (values, colour, marker) in lengths.items():
        grid[0, 1].plot(load * factor, values * scale, marker, color=colour, label=name)
    grid[0, 1].set_ylim(0, 1.08 * (longest or 1.0) * scale)
    grid[0, 1].set_ylabel(f"approach, mean gap [{length_unit}]", fontsize=LABEL)
    grid[0, 1].set_title("Approach and mean open gap", fontsize=TITLE)
    stiffness = curve.column("stiffness")
    # Nothing but saturated pixels has none, full periodic contact has no bound.
    stiffness[~(np.isfinite(stiffness) & (stiffness > 0))] = np.nan
    grid[1, 0].plot(load * factor, stiffness, "o-", color=SERIES[0])
    if np.isfinite(stiffness).any():
        grid[1, 0].set_yscale("log")
    grid[1, 0].set_ylabel("stiffness dW/dω [N/m]", fontsize=LABEL)
    grid[1, 0].set_title("Contact stiffness", fontsize=TITLE)
    number = curve.column("spots")
    grid[1, 1].plot(load * factor, number, "o-", color=SERIES[0])
    grid[1, 1].set_ylim(0, 1.1 * max(float(number.max()), 1.0))
    grid[1, 1].set_ylabel("number of contact spots", fontsize=LABEL)
    grid[1, 1].set_title("Contact spots", fontsize=TITLE)
    for axes in grid.ravel():
        axes.set_xscale("log")
        axes.set_xlabel(f"load [{unit}]", fontsize=LABEL)
        plain_axes(axes)
    for axes in grid[0]:
        axes.legend(fontsize=TICK, frameon=False)
    return figure


def save(figure: Figure, path: str | os.PathLike[str]) -> None:
    """Write a figure to a PNG, SVG or PDF file.

    Parameters
    ----------
    figure : Figure
        The figure.
    path : str or path
        File to write, its type told by the suffix; it appears only once it is complete, and a
        file that was there stays as it was until then.

    Raises
    ------
    InputError
        If the suffix is none of ``.png``, ``.svg``, ``.pdf``, or the folder does not exist.
    RoughcontactError
        If the file cannot be written.
    """
    target = Path(path)
    kind = _SUFFIXES.get(target.suffix.lower())
    if kind is None:
        raise InputError(
            f"cannot tell the type of the figure {str(target)!r} from its suffix; "
            f"use one of {', '.join(_SUFFIXES)}"
        )
    if not target.parent.is_dir():
        raise InputError(
            f"the folder of the figure {str(target)!r} does not exist; create it first"
        )
    unfinished = target.with_name(f".{target.name}.{secrets.token_hex(4)}.part")
    try:
        with unfinished.open("xb") as stream:
            figure.savefig(stream, format=kind, dpi=DPI)
        os.replace(unfinished, target)
    except OSError as error:
        reason = error.strerror or str(error)
        raise RoughcontactError(
            f"the figure {str(target)!r} could not be written: {reason}"
        ) from error
    finally:
        with contextlib.suppress(OSError):
            unfinished.unlink(missing_ok=True)


class _Drawn(NamedTuple):
    image: AxesImage
    cell: tuple[int, int]


class _Line(NamedTuple):
    """Points on a section; lengths and heights in metres, heights above the counter-body."""

    place: Array
    pixel: float
    peak: float
    across: float
    limits: tuple[float, float]
    before: Array
    under: Array
    pressure: Array
    saturated: Mask
    ceiling: Array | None


def _tilted(result: ContactResult, where: tuple[int | slice, ...]) -> Array:
    """Return what the tilt adds to the gap on a section [m]."""
    y, x = tilt.levers(result.gap.shape, result.surface.pixel)
    slope_y, slope_x = (slope * max(result.surface.size) for slope in result.tilt)
    raised: Array = (slope_y * y + slope_x * x)[where]
    return raised


def _highest(initial_gap: Array) -> tuple[int, int]:
    y, x = np.unravel_index(np.nanargmin(initial_gap), initial_gap.shape)
    return int(y), int(x)


def _window(centre: int, pixel: float, points: int, width: float) -> tuple[int, int]:
    """Return the first point and the point after the last of a length around a point."""
    if width >= points * pixel:
        return 0, points
    shown = min(max(math.ceil(width / pixel - 1e-9), 2), points)
    first = min(max(centre - shown // 2, 0), points - shown)
    return first, first + shown


def _line(
    result: ContactResult, before: Array, peak: tuple[int, int], axis: int, width: float
) -> _Line:
    here: list[int | slice] = list(peak)
    pixel, points = result.surface.pixel[axis], result.surface.shape[axis]
    first, last = _window(peak[axis], pixel, points, width)
    here[axis] = slice(first, last)
    where = tuple(here)
    ceiling = result.ceiling
    return _Line(
        place=pixel * (np.arange(first, last, dtype=np.float64) + 0.5),
        pixel=pixel,
        peak=(peak[axis] + 0.5) * pixel,
        across=(peak[1 - axis] + 0.5) * result.surface.pixel[1 - axis],
        limits=(first * pixel, last * pixel),
        before=result.approach - before[where] - _tilted(result, where),
        under=-result.gap[where],
        pressure=result.pressure[where],
        saturated=result.saturated[where],
        ceiling=None
        if ceiling is None
        else np.broadcast_to(ceiling, result.pressure.shape)[where].astype(np.float64),
    )


def _largest(*values: Array) -> float:
    return max(float(np.nanmax(np.abs(v), initial=0.0)) for v in values)


def _draw_profile(axes: Axes, line: _Line, factor: float, height_factor: float) -> None:
    place = line.place * factor
    before, under = line.before * height_factor, line.under * height_factor
    axes.fill_between(place, under, 0, where=under < 0, color="#dcebf5", label="gap left")
    axes.plot(place, before, color="#8a8a8a", linewidth=1.1, label="before loading, moved together")
    axes.axhline(0, color="#000000", linewidth=1.2, label="counter-body")
    axes.plot(place, under, color=SERIES[0], linewidth=1.6, label="under load")
    if line.saturated.any():
        sunk = np.where(line.saturated, np.maximum(under, 0), 0.0)
        axes.fill_between(
            place, sunk, 0, step="mid", color=SATURATED, label="has to flow away (saturated)"
        )


def _draw_line_pressure(
    axes: Axes, line: _Line, top: float, factor: float, pressure_factor: float
) -> None:
    edges = np.append(line.place - line.pixel / 2, line.place[-1] + line.pixel / 2) * factor
    for mask, colour in ((~line.saturated, ELASTIC), (line.saturated, SATURATED)):
        values = np.where(mask, line.pressure, 0.0) * pressure_factor
        axes.stairs(values, edges, fill=True, color=colour)
    if line.ceiling is not None and (line.ceiling <= top).any():
        axes.plot(
            line.place * factor,
            np.where(line.ceiling <= top, line.ceiling, np.nan) * pressure_factor,
            color=NEUTRAL,
            linestyle=(0, (5, 3)),
            linewidth=1.3,
            label="ceiling",
        )


def _draw_areas(axes: Axes, curve: LoadCurve, factor: float) -> None:
    load, nominal, slope = curve.column("load"), curve.nominal_area, curve.low_load_slope
    contact, saturated = curve.column("contact_area"), curve.column("saturated_area")
    contact_theory, saturated_theory = curve.persson
    # The law is one of elastic contact; the area of a saturated one is load over ceiling.
    law = slope * load / (curve.contact_modulus * curve.rms_gradient)
    lines = [(law, "--", NEUTRAL, f"κ W/(E* h′), κ = {slope:.2f}")]
    if isinstance(curve.ceiling, float) and saturated.any():
        lines.append((load / curve.ceiling, ":", NEUTRAL, "load / ceiling"))
    lines += [
        (contact_theory, "--", SERIES[5], "contact, Persson"),
        (saturated_theory, "--", SERIES[3], "saturated, Persson"),
        (contact, "o-", SERIES[0], "contact"),
        (saturated, "s-", SATURATED, "saturated"),
    ]
    for values, marker, colour, name in lines:
        share = 100 * values / nominal
        share[~((share > 0) & (share <= 100 * (1 + 1e-9)))] = np.nan
        if np.isfinite(share).any():
            axes.plot(load * factor, share, marker, color=colour, label=name)
    axes.set_yscale("log")
    axes.set_ylabel("share of the map [%]", fontsize=LABEL)
    axes.set_title("Contact and saturated area", fontsize=TITLE)


def _draw_loop(axes: Axes, history: LoadHistory) -> None:
    approach, load = history.hysteresis
    indents = history.column("indentation_volume") > SHAKEN_DOWN * history.indentation_volume
    if not any(history.path[0].shift):
        # The bodies touch at the first position before the first step.
        approach, load = np.append(0.0, approach), np.append(0.0, load)
    else:
        indents = indents[1:]
    across, unit_across = prefixed(float(np.abs(approach).max()), "m")
    up, unit_up = prefixed(float(load.max()), "N")
    x, y = approach * across, load * up
    for kind, colour, name in ((False, ELASTIC, "elastic"), (True, SATURATED, "new indentation")):
        if not (indents == kind).any():
            continue
        # One line with gaps, so that the legend names each kind once.
        gaps = np.full(indents.size, np.nan)
        parts = np.where(indents == kind, [x[:-1], x[1:], gaps], np.nan)
        axes.plot(parts.T.ravel(), np.array([y[:-1], y[1:], gaps]).T.ravel(),
                  color=colour, linewidth=2.2 if kind else 1.8, label=name)  # fmt: skip
    axes.plot(x, y, "o", color=NEUTRAL, markersize=4)
    for place, text, side in ((0, "start ", "right"), (-1, " end", "left")):
        axes.annotate(
            text, (x[place], y[place]), xytext=(0, 3), textcoords="offset points", ha=side,
            fontsize=TICK, color=NEUTRAL,
        )  # fmt: skip
    axes.margins(x=0.1)
    axes.set_xlabel(f"approach from first touch [{unit_across}]", fontsize=LABEL)
    axes.set_ylabel(f"load [{unit_up}]", fontsize=LABEL)
    axes.set_ylim(bottom=0)
    axes.tick_params(labelsize=TICK)
    axes.grid(True, color="#dddddd", linewidth=0.8)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    if indents.size:
        axes.legend(fontsize=TICK, frameon=False, loc="upper left")
    positions = len({stage.shift for stage in history.path})
    where = f", {positions} lateral positions" if positions > 1 else ""
    axes.set_title(f"Load history, {len(history.steps)} steps{where}", fontsize=TITLE)


def _draw_surface(axes: Axes, surface: Surface, cells: int) -> _Drawn:
    from matplotlib import colormaps

    blocks = cell_size(surface.shape, surface.size, cells)
    values = cell_mean(surface.heights, blocks)
    values -= np.nanmean(surface.heights)
    there = values[np.isfinite(values)]
    low, high = np.percentile(there, (0.5, 99.5)) if there.size else (0.0, 0.0)
    span = float(max(high - low, 0.0))
    if span == 0:
        # A flat map, or one whose few features the percentiles cut away.
        low, high = float(there.min(initial=0)), float(there.max(initial=0))
        span = high - low
    if span == 0:
        low, high = -0.5e-9, 0.5e-9
    factor, unit = prefixed(max(abs(low), abs(high)), "m")
    image = draw_map(axes, values * factor, surface.size, blocks, surface.shape)
    image.set_cmap(colormaps["viridis"].with_extremes(bad=MISSING))
    image.set_clim(low * factor, high * factor)
    below, above = bool((there < low).any()), bool((there > high).any())
    extend = {(0, 0): "neither", (1, 0): "min", (0, 1): "max", (1, 1): "both"}[below, above]
    colour_bar(axes, image, f"height above mean [{unit}]", extend)
    if surface.missing:
        share = percent(surface.missing / surface.heights.size)
        patch_legend(axes, [(MISSING, f"missing {share}")])
    return _Drawn(image, blocks)


def _draw_pressure(axes: Axes, result: ContactResult, top: float, cells: int) -> _Drawn:
    size, shape = result.surface.size, result.pressure.shape
    blocks = cell_size(shape, size, cells)
    values = cell_max(result.pressure, blocks)
    factor, _ = prefixed(top, "Pa")
    image = draw_map(axes, np.where(values > 0, values * factor, np.nan), size, blocks, shape)
    _colour_pressure(image, top * factor)
    return _Drawn(image, blocks)


def _colour_pressure(image: AxesImage, top: float) -> None:
    from matplotlib import colormaps

    # Without the lightest colours, which drown in the ground, and the darkest, which would pass
    # for what is beyond the scale.
    colours = colormaps["inferno_r"](np.linspace(0.17, 0.63, 256))
    image.set_cmap(listed(colours).with_extremes(bad=OPEN, over=OVER))
    image.set_clim(0, top)


def _pressure_bar(axes: Axes, image: AxesImage, top: float, over: bool) -> None:
    colour_bar(axes, image, f"pressure [{prefixed(top, 'Pa')[1]}]", "max" if over else "neither")


def _draw_contact(axes: Axes, result: ContactResult, cells: int) -> _Drawn:
    size, shape = result.surface.size, result.pressure.shape
    blocks = cell_size(shape, size, cells)
    missing = int(np.count_nonzero(np.isnan(result.gap)))
    classes = _classes(result.contact, result.saturated, result.gap, blocks)
    image = draw_map(axes, classes, size, blocks, shape)
    _colour_classes(image)
    lost = missing / result.pressure.size
    touching, saturated = result.contact_fraction, result.saturated_fraction
    entries = [
        (OPEN, f"no contact\n{percent(1 - touching - lost)}"),
        (ELASTIC, f"elastic\n{percent(touching - saturated)}"),
        (SATURATED, f"saturated\n{percent(saturated)}"),
    ]
    if missing:
        entries.append((MISSING, f"missing\n{percent(lost)}"))
    patch_legend(axes, entries)
    return _Drawn(image, blocks)


def _classes(contact: Mask, saturated: Mask, gap: Array, blocks: tuple[int, int]) -> Array:
    touching = cell_any(contact, blocks)
    classes = np.zeros(touching.shape)
    if np.isnan(gap).any():
        classes[np.isnan(cell_mean(gap, blocks))] = 3
    classes[touching] = 1
    classes[cell_any(saturated, blocks)] = 2
    return classes


def _colour_classes(image: AxesImage) -> None:
    image.set_cmap(listed([OPEN, ELASTIC, SATURATED, MISSING]))
    image.set_clim(-0.5, 3.5)


def _draw_histogram(
    axes: Axes, results: Sequence[ContactResult], names: Sequence[str], scale: str
) -> None:
    below = [result.pressure[result.contact & ~result.saturated] for result in results]
    largest = max(result.max_pressure for result in results) or 1.0
    # Ceilings far above all pressures are named but do not stretch the axis.
    ceilings = sorted({_uniform_ceiling(r) for r in results} - {math.inf})
    shown = [ceiling for ceiling in ceilings if ceiling <= 2 * largest]
    top = max([largest, *shown])
    factor, unit = prefixed(top, "Pa")
    edges = _edges(below, shown, top, scale)
    widths, per = np.diff(edges) * factor, unit
    if scale == "log":
        widths, per = np.diff(np.log10(edges)), "decade"
    for index, (result, name, values) in enumerate(zip(results, names, below, strict=True)):
        counts, _ = np.histogram(np.clip(values, edges[0], edges[-1]), edges)
        points = max(int(np.count_nonzero(result.contact)), 1)
        axes.stairs(
            100 * counts / points / widths,
            edges * factor,
            color=SERIES[index % len(SERIES)],
            linewidth=1.8,
            linestyle=("-", "--", ":")[index // len(SERIES) % 3],
            fill=len(results) == 1,
            label=_histogram_label(result, name),
        )
    for row, ceiling in enumerate(shown):
        text = f"ceiling {engineering(ceiling, 'Pa', 3)}"
        if len(results) == 1 and results[0].saturated_fraction > 0:
            text = f"{_share_at_ceiling(results[0])} at the {text}"
        axes.axvline(ceiling * factor, color=NEUTRAL, linestyle=(0, (5, 3)), linewidth=1.5)
        axes.annotate(
            text,
            (ceiling * factor, 1),
            xycoords=axes.get_xaxis_transform(),
            xytext=(0, 3 + 14 * (row % 2)),
            textcoords="offset points",
            ha="right" if ceiling > 0.85 * top else "center",
            fontsize=TICK,
            color=NEUTRAL,
        )
    if scale == "log":
        axes.set_xscale("log")
    else:
        axes.set_xlim(0, 1.03 * float(edges[-1]) * factor)
    axes.set_ylim(bottom=0)
    axes.margins(y=0.1)
    axes.set_xlabel(f"pressure [{unit}]", fontsize=LABEL)
    axes.set_ylabel(f"density of contact area [% per {per}]", fontsize=LABEL)
    plain_axes(axes)
    legend_below(axes)


def _edges(pressures: Sequence[Array], ceilings: Sequence[float], top: float, scale: str) -> Array:
    # About as many bins as the points bear (Rice's rule); the lowest ceiling is an edge, so that
    # no bin seems to reach beyond it.
    count = min(max(2 * max(p.size for p in pressures) ** (1 / 3), 10), 60)
    if scale == "log":
        lowest = min((float(p.min()) for p in pressures if p.size), default=0.1 * top)
        decades = min(max(math.log10(top / lowest), 0.5), 4.0)
        step, anchor = decades / count, math.log10(ceilings[0] if ceilings else top)
        before = math.ceil((decades - math.log10(top) + anchor) / step)
        after = math.ceil((math.log10(top) - anchor) / step - 1e-9)
        exponents = anchor + step * np.arange(-max(before, 1), after + 1)
        return np.asarray(10.0**exponents)
    step = top / count
    if ceilings:
        step = ceilings[0] / max(round(ceilings[0] / step), 1)
    edges: Array = step * np.arange(math.ceil(top / step - 1e-9) + 1)
    return edges


def _histogram_label(result: ContactResult, name: str) -> str:
    text = f"{name}: " if name else ""
    text += f"{percent(result.contact_fraction)} of the map in contact{_doubt(result)}"
    if result.ceiling is None:
        return text
    ceiling = _uniform_ceiling(result)
    which = "its" if math.isinf(ceiling) else f"the {engineering(ceiling, 'Pa', 3)}"
    if result.saturated_fraction == 0:
        return f"{text},\nnone of it at {which} ceiling"
    return f"{text},\n{_share_at_ceiling(result)} of it at {which} ceiling (not drawn)"


def _share_at_ceiling(result: ContactResult) -> str:
    return percent(result.saturated_fraction / result.contact_fraction)


def _uniform_ceiling(result: ContactResult) -> float:
    # Infinite where there is none, or one that differs from point to point.
    ceiling = result.ceiling
    return ceiling if isinstance(ceiling, (int, float)) else math.inf


# Share of the contact that lies within the scale of a pressure map.
_SHOWN = 0.995


def _limit(results: Sequence[ContactResult], limit: float | None) -> float:
    if limit is not None:
        if not 0 < limit < math.inf:
            raise InputError(
                f"must be positive and finite [Pa], got {limit!r}", argument="limit", value=limit
            )
        return float(limit)
    # Where next to nothing is saturated, one spike would leave a single shade for all the rest.
    reached = [
        float(np.quantile(r.pressure[r.contact], _SHOWN))
        for r in results
        if r.saturated_fraction > 0
    ]
    return max(reached or [r.max_pressure for r in results]) or 1.0


def _names(results: Sequence[ContactResult], labels: Sequence[str] | None) -> list[str]:
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


def _load(result: ContactResult) -> str:
    return engineering(result.load, "N", 3)


def _doubt(result: ContactResult) -> str:
    return "" if result.converged else " (NOT CONVERGED)"


def _stress_title(result: StressResult) -> str:
    stress = engineering(result.max_von_mises, "Pa", 3)
    depth = result.place[0]
    where = f"at depth {engineering(depth, 'm', 3)}" if depth > 0 else "at the surface"
    which = "" if result.body == "first" else " in the counter-body"
    return (
        f"Von Mises stress{which} at {_load(result.contact)}, largest\n"
        f"{stress} {where}{_doubt(result.contact)}"
    )


def _stress_scale(result: StressResult) -> tuple[float, float, str]:
    # Top of the colours, which end at the yield strength, and the unit.
    strength = result.profile.yield_strength
    top = result.max_von_mises if strength is None else min(result.max_von_mises, strength)
    return top or 1.0, *prefixed(top, "Pa")


def _stress_colours() -> Any:
    from matplotlib import colormaps

    # As for pressures, but from the lightest on: a field has no ground to drown in.
    return listed(colormaps["inferno_r"](np.linspace(0, 0.63, 256))).with_extremes(over=OVER)


def _stress_bar(axes: Axes, image: Any, result: StressResult, unit: str) -> None:
    over = result.max_von_mises > _stress_scale(result)[0]
    label = f"von Mises stress [{unit}]" + (", black: above yield" if over else "")
    colour_bar(axes, image, label, "max" if over else "neither")
