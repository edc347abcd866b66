"""Stress below a contact: against the depth, on a plane, from above."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from roughcontact.contact.stress import StressResult
from roughcontact.errors import InputError
from roughcontact.plots.labels import doubt, load_text
from roughcontact.plots.style import (
    CELLS_ALONE,
    DPI,
    LABEL,
    NEUTRAL,
    OVER,
    SERIES,
    TICK,
    TITLE,
    cell_max,
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
    reduced,
    single_axes,
)
from roughcontact.units import engineering, percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


_SECTION_ROWS = 400


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
    plain_axes(axes)
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
    profile, surface = result.profile, result.solution.surface
    axis = 1 if along == "x" else 0
    side, edge = surface.size[axis], surface.pixel[axis]
    depth = _shown_depth(result, values, depth, side)
    block = max(math.ceil(values.shape[1] / CELLS_ALONE), 1)
    rows = _rows(reduced(np.maximum, values, (1, block)), profile.depths, depth)
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


def _shown_depth(result: StressResult, values: Any, depth: float | None, side: float) -> float:
    """Return how deep a section is drawn [m]; `InputError` where it cannot be."""
    depths = result.profile.depths
    if depths.size < 2:
        raise InputError("a section needs two depths or more, and the result has one")
    if depth is None:
        strong = int(np.flatnonzero(values.max(axis=1) >= 0.25 * values.max())[-1])
        weak = min(strong + 1, depths.size - 1)
        depth = max(float(depths[weak]), 0.2 * side)
    if not 0 < depth < math.inf:
        raise InputError(
            f"must be positive and finite [m], got {depth!r}", argument="depth", value=depth
        )
    return min(depth, float(depths[-1]))


def _rows(cells: Any, depths: Any, depth: float) -> Any:
    """Return the cells of a section in rows of one height down to a depth [m]."""
    # Depths are graded: straight lines lead from one to the next.
    fine = depth / _SECTION_ROWS * (np.arange(_SECTION_ROWS) + 0.5)
    return np.array([np.interp(fine, depths, column) for column in cells.T]).T


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
    peak, size = result.profile.peak, result.solution.surface.size
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
    cell_note(figure, blocks, "the largest stress in it")
    return figure


def _stress_title(result: StressResult) -> str:
    stress = engineering(result.max_von_mises, "Pa", 3)
    depth = result.place[0]
    where = f"at depth {engineering(depth, 'm', 3)}" if depth > 0 else "at the surface"
    which = "" if result.body == "body" else " in the counter-body"
    return (
        f"Von Mises stress{which} at {load_text(result.solution)}, largest\n"
        f"{stress} {where}{doubt(result.solution)}"
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
