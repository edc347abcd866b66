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

from roughcontact.errors import InputError, RoughcontactError
from roughcontact.result import ContactResult
from roughcontact.surface import Surface
from roughcontact.units import engineering

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import ListedColormap
    from matplotlib.figure import Figure
    from matplotlib.image import AxesImage
    from matplotlib.layout_engine import ConstrainedLayoutEngine
    from matplotlib.transforms import Transform

    from roughcontact.subsurface import StressResult

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

DPI = 150
"""Dots per inch of every figure."""

# Cells along the longer side of a map. The axes have more dots than that, so that drawing to the
# nearest cell leaves none out.
_CELLS_ALONE = 600
_CELLS_IN_PANEL = 520
_SECTION_ROWS = 400

_TITLE = 13.0
_LABEL = 12.0
_TICK = 11.0
_NOTE = 9.5

_MISSING = "#c4c4c4"
_OPEN = "#f1f1ee"
# Light, middle and dark grey when printed without colour; blue and dark red for all eyes.
_ELASTIC = "#4aa3df"
_SATURATED = "#7f0d1b"
_OVER = "#000000"
_CLOSED = "#d55e00"
_NEUTRAL = "#444444"
# Okabe and Ito's colours for all kinds of colour vision, darkest first.
_SERIES = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")

_PREFIXES = {-12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}
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
    figure, axes = _single(surface.size, legend=surface.missing > 0)
    drawn = _draw_surface(axes, surface, _CELLS_ALONE)
    axes.set_title(f"Surface heights, Sq {engineering(surface.Sq, 'm', 3)}", fontsize=_TITLE)
    _note(figure, drawn.cell, "the mean height")
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
    figure, axes = _single(result.surface.size, legend=False)
    drawn = _draw_pressure(axes, result, top, _CELLS_ALONE)
    _pressure_bar(axes, drawn.image, top, over=result.max_pressure > top)
    axes.set_title(
        f"Contact pressure at {_load(result)}, largest "
        f"{engineering(result.max_pressure, 'Pa', 3)}{_doubt(result)}",
        fontsize=_TITLE,
    )
    _note(figure, drawn.cell, "the largest pressure")
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
    figure, axes = _single(result.surface.size)
    drawn = _draw_contact(axes, result, _CELLS_ALONE)
    axes.set_title(f"Contact at {_load(result)}{_doubt(result)}", fontsize=_TITLE)
    _note(figure, drawn.cell, "the most severe class")
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

    figure, axes = _single(result.surface.size)
    size = result.surface.size
    blocks = _blocks(result.gap.shape, size, _CELLS_ALONE)
    values = _cell_mean(np.maximum(result.gap, 0), blocks)
    closed = _cell_any(result.contact, blocks)
    values[closed] = np.nan
    there = values[np.isfinite(values)]
    top = float(np.percentile(there, 99.5)) if there.size else 0.0
    top = top or float(there.max(initial=0.0)) or 1e-9
    factor, unit = _scale(top, "m")
    image = _image(axes, values * factor, size, blocks, result.gap.shape)
    image.set_cmap(colormaps["Blues"].with_extremes(bad=_MISSING))
    image.set_clim(0, top * factor)
    marks = _image(axes, np.where(closed, 1.0, np.nan), size, blocks, result.gap.shape)
    marks.set_cmap(_listed([_CLOSED]))
    _bar(axes, image, f"open gap [{unit}]", "max" if (there > top).any() else "neither")
    entries = [(_CLOSED, f"closed {_percent(result.contact_fraction)}")]
    missing = int(np.count_nonzero(np.isnan(result.gap)))
    if missing:
        entries.append((_MISSING, f"missing {_percent(missing / result.gap.size)}"))
    _legend(axes, entries)
    axes.set_title(
        f"Open gap at {_load(result)}, mean {engineering(result.mean_gap, 'm', 3)}{_doubt(result)}",
        fontsize=_TITLE,
    )
    _note(figure, blocks, "the mean gap, or closed for any closed point")
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
        raise InputError(f"scale must be 'linear' or 'log', got {scale!r}")
    figure = Figure(figsize=(7.2, 5.2), dpi=DPI, layout=_layout())
    axes = figure.subplots()
    _draw_histogram(axes, results, names, scale)
    axes.set_title("Distribution of the contact pressure", fontsize=_TITLE, pad=24)
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
    aspect = max(_aspect(result.surface.size) for result in results)
    width, height = 4.9 * len(results) + 1.0, 8.4 * aspect + 2.7
    figure = Figure(figsize=(width, height), dpi=DPI, layout=_layout())
    grid = figure.subplots(2, len(results), squeeze=False)
    over = max(result.max_pressure for result in results) > top
    cells = []
    for column, (result, name) in enumerate(zip(results, names, strict=True)):
        upper, lower = grid[:, column]
        drawn = _draw_pressure(upper, result, top, _CELLS_IN_PANEL)
        largest = engineering(result.max_pressure, "Pa", 3)
        upper.set_title(
            f"{name}{_doubt(result)}\n{_load(result)}, largest pressure {largest}", fontsize=_TITLE
        )
        if column == len(results) - 1:
            _pressure_bar(upper, drawn.image, top, over=over)
        cells.append(_draw_contact(lower, result, _CELLS_IN_PANEL).cell)
    _note(figure, max(cells), "the largest pressure or the most severe class")
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
    figure = Figure(figsize=(7.2, 6.0), dpi=DPI, layout=_layout())
    axes = figure.subplots()
    strength = profile.yield_strength or 0.0
    factor, unit = _scale(max(profile.max_tresca, strength), "Pa")
    length_factor, length_unit = _scale(float(profile.depths[-1]), "m")
    depths = profile.depths * length_factor
    for (values, name), colour, line in zip(
        (
            (profile.von_mises, "largest von Mises stress"),
            (profile.tresca, "largest Tresca stress"),
            (profile.orthogonal_shear.max(axis=1), "orthogonal shear amplitude in a pass"),
        ),
        _SERIES,
        ("-", "--", ":"),
        strict=False,
    ):
        axes.plot(
            depths, values * factor, line, color=colour, linewidth=1.8, marker=".", label=name
        )
    if strength:
        axes.axhline(strength * factor, color=_NEUTRAL, linestyle=(0, (5, 3)), linewidth=1.5)
        axes.annotate(
            f"yield strength {engineering(strength, 'Pa', 3)}",
            (1, strength * factor),
            xycoords=axes.get_yaxis_transform(),
            xytext=(-3, 3),
            textcoords="offset points",
            ha="right",
            fontsize=_TICK,
            color=_NEUTRAL,
        )
    if depths.size > 2 and profile.depth_of_max < 0.05 * profile.depths[-1]:
        first = 10.0 ** math.ceil(math.log10(float(depths[depths > 0][0])))
        axes.set_xscale("symlog", linthresh=first, linscale=0.5)
    axes.set_xlim(0, float(depths[-1]) or None)
    axes.set_ylim(bottom=0)
    axes.margins(y=0.1)
    axes.set_xlabel(f"depth [{length_unit}]", fontsize=_LABEL)
    axes.set_ylabel(f"stress [{unit}]", fontsize=_LABEL)
    axes.tick_params(labelsize=_TICK)
    axes.grid(True, color="#dddddd", linewidth=0.8)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    axes.legend(
        loc="upper center",
        bbox_to_anchor=(0.5, 0),
        bbox_transform=_below(axes),
        borderaxespad=0,
        fontsize=_TICK,
        frameon=False,
    )
    axes.set_title(_stress_title(result), fontsize=_TITLE)
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
        raise InputError(f"depth must be positive and finite [m], got {depth!r}")
    depth = min(depth, float(profile.depths[-1]))
    block = max(math.ceil(values.shape[1] / _CELLS_ALONE), 1)
    cells = _reduced(np.maximum, values, (1, block))
    # Depths are graded: straight lines lead from one to the next.
    fine = depth / _SECTION_ROWS * (np.arange(_SECTION_ROWS) + 0.5)
    rows = np.array([np.interp(fine, profile.depths, column) for column in cells.T]).T
    factor, unit = _scale(side, "m")
    across = np.append(np.arange(0, values.shape[1], block), values.shape[1]) * edge * factor
    aspect = depth / side
    height = max(5.8 * min(aspect, 1.6), 0.4) + (3.0 if aspect <= 0.45 else 1.8)
    figure = Figure(figsize=(7.2, height), dpi=DPI, layout=_layout())
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
        color=_SERIES[0],
        markersize=11,
        markeredgewidth=2,
        clip_on=False,
    )
    axes.set_aspect("equal")
    axes.set_xlim(0, side * factor)
    axes.set_ylim(depth * factor, 0)
    axes.set_xlabel(f"{along} [{unit}]", fontsize=_LABEL)
    axes.set_ylabel(f"depth [{unit}]", fontsize=_LABEL)
    axes.tick_params(labelsize=_TICK)
    _few_ticks(axes, aspect)
    _stress_bar(axes, mesh, result, stress_unit)
    axes.set_title(_stress_title(result), fontsize=_TITLE)
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
    figure, axes = _single(size, legend=over)
    blocks = _blocks(peak.shape, size, _CELLS_ALONE)
    _, factor, unit = _stress_scale(result)
    image = _image(axes, _cell_max(peak, blocks) * factor, size, blocks, peak.shape)
    image.set_cmap(_stress_colours())
    image.set_clim(0, _stress_scale(result)[0] * factor)
    length_factor, _ = _scale(max(size), "m")
    _, y, x = result.place
    axes.plot(
        [x * length_factor], [y * length_factor], "+",
        color=_SERIES[0], markersize=11, markeredgewidth=2,
    )  # fmt: skip
    _stress_bar(axes, image, result, unit)
    if over:
        share = _percent(float(np.count_nonzero(peak > strength)) / peak.size)
        _legend(axes, [(_OVER, f"yield strength exceeded below {share} of the map")])
    axes.set_title(_stress_title(result), fontsize=_TITLE)
    _note(figure, blocks, "the largest stress")
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

    height = 9.6 * max(_aspect(result.surface.size), 0.6) + 3.2
    figure = Figure(figsize=(12.0, height), dpi=DPI, layout=_layout())
    grid = figure.subplots(2, 2)
    top = _limit([result], None)
    drawn = _draw_surface(grid[0, 0], result.surface, _CELLS_IN_PANEL)
    name = "Surface" if result.counter_surface is None else "Surface of the first body"
    grid[0, 0].set_title(f"{name}, Sq {engineering(result.surface.Sq, 'm', 3)}", fontsize=_TITLE)
    pressures = _draw_pressure(grid[0, 1], result, top, _CELLS_IN_PANEL)
    _pressure_bar(grid[0, 1], pressures.image, top, over=result.max_pressure > top)
    grid[0, 1].set_title("Contact pressure", fontsize=_TITLE)
    _draw_contact(grid[1, 0], result, _CELLS_IN_PANEL)
    grid[1, 0].set_title("Contact", fontsize=_TITLE)
    _draw_histogram(grid[1, 1], [result], [""], "linear")
    grid[1, 1].set_title("Distribution of the contact pressure", fontsize=_TITLE, pad=24)
    certificate = f"certificate {result.certificate:.1e}"
    saturated = f"saturated {_percent(result.saturated_fraction)}"
    words = [
        f"load {_load(result)}",
        f"contact {_percent(result.contact_fraction)}",
        "no ceiling" if result.ceiling is None else saturated,
        f"largest pressure {engineering(result.max_pressure, 'Pa', 3)}",
        certificate if result.converged else f"NOT CONVERGED, {certificate}",
    ]
    figure.suptitle(
        "  ·  ".join(words) + f"\nregime: {result.regime}", fontsize=_TITLE + 1, linespacing=1.4
    )
    shown = "the mean height, the largest pressure or the most severe class"
    _note(figure, drawn.cell, shown)
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


def _draw_surface(axes: Axes, surface: Surface, cells: int) -> _Drawn:
    from matplotlib import colormaps

    blocks = _blocks(surface.shape, surface.size, cells)
    values = _cell_mean(surface.heights, blocks)
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
    factor, unit = _scale(max(abs(low), abs(high)), "m")
    image = _image(axes, values * factor, surface.size, blocks, surface.shape)
    image.set_cmap(colormaps["viridis"].with_extremes(bad=_MISSING))
    image.set_clim(low * factor, high * factor)
    below, above = bool((there < low).any()), bool((there > high).any())
    extend = {(0, 0): "neither", (1, 0): "min", (0, 1): "max", (1, 1): "both"}[below, above]
    _bar(axes, image, f"height above mean [{unit}]", extend)
    if surface.missing:
        share = _percent(surface.missing / surface.heights.size)
        _legend(axes, [(_MISSING, f"missing {share}")])
    return _Drawn(image, blocks)


def _draw_pressure(axes: Axes, result: ContactResult, top: float, cells: int) -> _Drawn:
    from matplotlib import colormaps

    size, shape = result.surface.size, result.pressure.shape
    blocks = _blocks(shape, size, cells)
    values = _cell_max(result.pressure, blocks)
    factor, _ = _scale(top, "Pa")
    image = _image(axes, np.where(values > 0, values * factor, np.nan), size, blocks, shape)
    # Without the lightest colours, which drown in the ground, and the darkest, which would pass
    # for what is beyond the scale.
    colours = colormaps["inferno_r"](np.linspace(0.17, 0.63, 256))
    image.set_cmap(_listed(colours).with_extremes(bad=_OPEN, over=_OVER))
    image.set_clim(0, top * factor)
    return _Drawn(image, blocks)


def _pressure_bar(axes: Axes, image: AxesImage, top: float, over: bool) -> None:
    _bar(axes, image, f"pressure [{_scale(top, 'Pa')[1]}]", "max" if over else "neither")


def _draw_contact(axes: Axes, result: ContactResult, cells: int) -> _Drawn:
    size, shape = result.surface.size, result.pressure.shape
    blocks = _blocks(shape, size, cells)
    classes = np.zeros(_cell_any(result.contact, blocks).shape)
    missing = int(np.count_nonzero(np.isnan(result.gap)))
    if missing:
        classes[np.isnan(_cell_mean(result.gap, blocks))] = 3
    classes[_cell_any(result.contact, blocks)] = 1
    classes[_cell_any(result.saturated, blocks)] = 2
    image = _image(axes, classes, size, blocks, shape)
    image.set_cmap(_listed([_OPEN, _ELASTIC, _SATURATED, _MISSING]))
    image.set_clim(-0.5, 3.5)
    lost = missing / result.pressure.size
    touching, saturated = result.contact_fraction, result.saturated_fraction
    entries = [
        (_OPEN, f"no contact\n{_percent(1 - touching - lost)}"),
        (_ELASTIC, f"elastic\n{_percent(touching - saturated)}"),
        (_SATURATED, f"saturated\n{_percent(saturated)}"),
    ]
    if missing:
        entries.append((_MISSING, f"missing\n{_percent(lost)}"))
    _legend(axes, entries)
    return _Drawn(image, blocks)


def _draw_histogram(
    axes: Axes, results: Sequence[ContactResult], names: Sequence[str], scale: str
) -> None:
    below = [result.pressure[result.contact & ~result.saturated] for result in results]
    largest = max(result.max_pressure for result in results) or 1.0
    # Ceilings far above all pressures are named but do not stretch the axis.
    ceilings = sorted({_uniform_ceiling(r) for r in results} - {math.inf})
    shown = [ceiling for ceiling in ceilings if ceiling <= 2 * largest]
    top = max([largest, *shown])
    factor, unit = _scale(top, "Pa")
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
            color=_SERIES[index % len(_SERIES)],
            linewidth=1.8,
            linestyle=("-", "--", ":")[index // len(_SERIES) % 3],
            fill=len(results) == 1,
            label=_histogram_label(result, name),
        )
    for row, ceiling in enumerate(shown):
        text = f"ceiling {engineering(ceiling, 'Pa', 3)}"
        if len(results) == 1 and results[0].saturated_fraction > 0:
            text = f"{_share_at_ceiling(results[0])} at the {text}"
        axes.axvline(ceiling * factor, color=_NEUTRAL, linestyle=(0, (5, 3)), linewidth=1.5)
        axes.annotate(
            text,
            (ceiling * factor, 1),
            xycoords=axes.get_xaxis_transform(),
            xytext=(0, 3 + 14 * (row % 2)),
            textcoords="offset points",
            ha="right" if ceiling > 0.85 * top else "center",
            fontsize=_TICK,
            color=_NEUTRAL,
        )
    if scale == "log":
        axes.set_xscale("log")
    else:
        axes.set_xlim(0, 1.03 * float(edges[-1]) * factor)
    axes.set_ylim(bottom=0)
    axes.margins(y=0.1)
    axes.set_xlabel(f"pressure [{unit}]", fontsize=_LABEL)
    axes.set_ylabel(f"density of contact area [% per {per}]", fontsize=_LABEL)
    axes.tick_params(labelsize=_TICK)
    axes.grid(True, color="#dddddd", linewidth=0.8)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    axes.legend(
        loc="upper center",
        bbox_to_anchor=(0.5, 0),
        bbox_transform=_below(axes),
        borderaxespad=0,
        fontsize=_TICK,
        frameon=False,
    )


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
    text += f"{_percent(result.contact_fraction)} of the map in contact{_doubt(result)}"
    if result.ceiling is None:
        return text
    ceiling = _uniform_ceiling(result)
    which = "its" if math.isinf(ceiling) else f"the {engineering(ceiling, 'Pa', 3)}"
    if result.saturated_fraction == 0:
        return f"{text},\nnone of it at {which} ceiling"
    return f"{text},\n{_share_at_ceiling(result)} of it at {which} ceiling (not drawn)"


def _share_at_ceiling(result: ContactResult) -> str:
    return _percent(result.saturated_fraction / result.contact_fraction)


def _uniform_ceiling(result: ContactResult) -> float:
    # Infinite where there is none, or one that differs from point to point.
    ceiling = result.ceiling
    return ceiling if isinstance(ceiling, (int, float)) else math.inf


# Share of the contact that lies within the scale of a pressure map.
_SHOWN = 0.995


def _limit(results: Sequence[ContactResult], limit: float | None) -> float:
    if limit is not None:
        if not 0 < limit < math.inf:
            raise InputError(f"limit must be positive and finite [Pa], got {limit!r}")
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
        raise InputError("results is empty: give at least one")
    if labels is None:
        return [""] if len(results) == 1 else [f"result {i + 1}" for i in range(len(results))]
    if isinstance(labels, str) or len(labels) != len(results):
        raise InputError(f"labels must hold one text a result, got {labels!r} for {len(results)}")
    return list(labels)


def _load(result: ContactResult) -> str:
    return engineering(result.load, "N", 3)


def _doubt(result: ContactResult) -> str:
    return "" if result.converged else " (NOT CONVERGED)"


def _percent(share: float) -> str:
    # Three digits of the share or of what it lacks to the whole: 99.97 % never reads as 100 %.
    rest = min(share, 1 - share)
    if rest <= 1e-12:
        return f"{100 * share:.0f} %"
    if share < 5e-7:
        return "< 0.0001 %"
    if 1 - share < 5e-7:
        return "> 99.9999 %"
    decimals = min(max(2 - math.floor(math.log10(100 * rest)), 0), 4)
    return f"{100 * share:.{decimals}f} %"


def _scale(largest: float, unit: str) -> tuple[float, str]:
    # The rounding keeps 999.9999999 µm, which is a sum of pixels, from missing its prefix.
    exponent = 3 * math.floor(math.log10(largest * (1 + 1e-9)) / 3) if largest > 0 else 0
    exponent = min(max(exponent, min(_PREFIXES)), max(_PREFIXES))
    return float(10.0**-exponent), _PREFIXES[exponent] + unit


def _layout() -> ConstrainedLayoutEngine:
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    return ConstrainedLayoutEngine(w_pad=0.1, h_pad=0.1)


def _aspect(size: tuple[float, float]) -> float:
    return min(max(size[0] / size[1], 0.2), 1.6)


def _single(size: tuple[float, float], legend: bool = True) -> tuple[Figure, Axes]:
    from matplotlib.figure import Figure

    # Large enough that the longer side of the map has more dots than the map has cells, and wide
    # enough for the note whatever the map.
    aspect = size[0] / size[1]
    height = 5.2 * min(aspect, 1.0)
    figure = Figure(
        figsize=(7.2, max(height, 1.0) + (2.6 if legend else 1.8)),
        dpi=DPI,
        layout=_layout(),
    )
    return figure, figure.subplots()


def _blocks(shape: tuple[int, ...], size: tuple[float, float], cells: int) -> tuple[int, int]:
    # Points (y, x) to a cell, given the most cells on the longer side.
    longer = max(size)
    by, bx = (
        max(math.ceil(points / max(cells * side / longer, 1)), 1)
        for points, side in zip(shape, size, strict=True)
    )
    return by, bx


def _reduced(
    ufunc: np.ufunc,
    values: NDArray[Any],
    blocks: tuple[int, int],
    dtype: type[np.generic] | None = None,
) -> NDArray[Any]:
    for axis, block in enumerate(blocks):
        if block > 1:
            values = ufunc.reduceat(values, np.arange(0, values.shape[axis], block), axis, dtype)
    return values


def _cell_max(values: Array, blocks: tuple[int, int]) -> Array:
    return _reduced(np.maximum, values, blocks)


def _cell_any(mask: Mask, blocks: tuple[int, int]) -> Mask:
    return _reduced(np.logical_or, mask, blocks)


def _cell_mean(values: Array, blocks: tuple[int, int]) -> Array:
    # Mean of the points that are there; NaN where half of a cell or more is missing.
    if blocks == (1, 1):
        return values.copy()
    there = np.isfinite(values)
    count = _reduced(np.add, there, blocks, np.float64)
    total = _reduced(np.add, values if there.all() else np.where(there, values, 0.0), blocks)
    rows, columns = (
        np.diff([*range(0, points, block), points])
        for points, block in zip(values.shape, blocks, strict=True)
    )
    most = np.outer(rows, columns)
    mean: Array = np.where(2 * count > most, total / np.maximum(count, 1), np.nan)
    return mean


def _image(
    axes: Axes,
    values: Array,
    size: tuple[float, float],
    blocks: tuple[int, int],
    shape: tuple[int, ...],
) -> AxesImage:
    factor, unit = _scale(max(size), "m")
    height, width = size[0] * factor, size[1] * factor
    # Cells at the far edges may reach beyond the map; the limits cut them off.
    bottom = values.shape[0] * blocks[0] * height / shape[0]
    right = values.shape[1] * blocks[1] * width / shape[1]
    image = axes.imshow(
        np.ma.masked_invalid(values),
        extent=(0, right, bottom, 0),
        interpolation="nearest",
        aspect="equal",
    )
    axes.set_xlim(0, width)
    axes.set_ylim(height, 0)
    axes.set_xlabel(f"x [{unit}]", fontsize=_LABEL)
    axes.set_ylabel(f"y [{unit}]", fontsize=_LABEL)
    axes.tick_params(labelsize=_TICK)
    _few_ticks(axes, height / width)
    return image


def _few_ticks(axes: Axes, aspect: float) -> None:
    from matplotlib.ticker import MaxNLocator

    axes.xaxis.set_major_locator(MaxNLocator(max(round(5 / max(aspect, 1)), 2)))
    axes.yaxis.set_major_locator(MaxNLocator(max(round(5 * min(aspect, 1)), 1)))


def _bar(axes: Axes, image: AxesImage, label: str, extend: str) -> None:
    # An inset follows the map's own box, whatever its aspect; wide strips get the bar on top.
    left, right = axes.get_xlim()
    bottom, top = axes.get_ylim()
    aspect = abs(bottom - top) / abs(right - left)
    upright = aspect > 0.45
    thickness = 0.045 * max(aspect, 1) if upright else 0.045 / aspect
    place = (1 + 0.6 * thickness, 0, thickness, 1) if upright else (0, 1 + thickness, 1, thickness)
    inset = axes.inset_axes(place)
    bar = axes.figure.colorbar(
        image,
        cax=inset,
        extend=extend,
        orientation="vertical" if upright else "horizontal",
        ticklocation="right" if upright else "top",
    )
    bar.set_label(label, fontsize=_LABEL)
    bar.ax.tick_params(labelsize=_TICK)


def _listed(colours: Any) -> ListedColormap:
    from matplotlib.colors import ListedColormap

    return ListedColormap(colours)


def _legend(axes: Axes, entries: Sequence[tuple[str, str]]) -> None:
    from matplotlib.patches import Patch

    axes.legend(
        handles=[
            Patch(facecolor=colour, edgecolor="#777777", linewidth=0.8, label=text)
            for colour, text in entries
        ],
        loc="upper center",
        bbox_to_anchor=(0.5, 0),
        bbox_transform=_below(axes),
        borderaxespad=0,
        ncols=len(entries),
        fontsize=_TICK,
        frameon=False,
        handlelength=1.2,
        handleheight=1.2,
        columnspacing=1.4,
    )


def _below(axes: Axes) -> Transform:
    from matplotlib.transforms import ScaledTranslation

    figure = axes.get_figure(root=True)
    assert figure is not None
    # Under the axis label, at a distance in inches that no aspect changes.
    return axes.transAxes + ScaledTranslation(0, -0.52, figure.dpi_scale_trans)


def _note(figure: Figure, cell: tuple[int, int], shown: str) -> None:
    if cell == (1, 1):
        return
    figure.supxlabel(
        f"Drawn in cells of {cell[0]} × {cell[1]} points (y × x): a cell shows {shown} in it.",
        fontsize=_NOTE,
        color=_NEUTRAL,
    )


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
    return top or 1.0, *_scale(top, "Pa")


def _stress_colours() -> Any:
    from matplotlib import colormaps

    # As for pressures, but from the lightest on: a field has no ground to drown in.
    return _listed(colormaps["inferno_r"](np.linspace(0, 0.63, 256))).with_extremes(over=_OVER)


def _stress_bar(axes: Axes, image: Any, result: StressResult, unit: str) -> None:
    over = result.max_von_mises > _stress_scale(result)[0]
    label = f"von Mises stress [{unit}]" + (", black: above yield" if over else "")
    _bar(axes, image, label, "max" if over else "neither")
