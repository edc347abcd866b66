"""Figures of the stress below a contact: depth profile, section, map."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from roughcontact.analyses.stress.model import StressResult
from roughcontact.drawing import style
from roughcontact.drawing.sections import window
from roughcontact.errors import InputError, input_error
from roughcontact.halfspace.coating_stress import interfaces
from roughcontact.units import format_percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


SECTION_ROWS = 400


"""Number of rows of a drawn section."""


# Share of the largest stress from which on stress is strong; width of a section over the connected
# strong part around the maximum; minimum width in pixels; share of the map from which on the whole
# map is drawn; minimum depth over width.
_STRONG = 0.25


_AROUND = 2.5


_MIN_PIXELS = 24


_MAX_MAP_SHARE = 0.5


_MIN_DEPTH_RATIO = 0.4


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
        the depth, with the yield strength if known. The depth axis is logarithmic, except at its
        beginning, if the largest stress is close to the surface.
    """
    profile = result.profile
    figure, axes = style.panels(7.2, 6.0)
    strength = profile.yield_strength or 0.0
    factor, unit = style.axis_unit(max(profile.max_tresca, strength), "Pa")
    near = profile.depths.size > 2 and profile.depth_of_max < 0.05 * profile.depths[-1]
    # The unit of a logarithmic axis is that of its center.
    ends = (
        math.sqrt(float(profile.depths[profile.depths > 0][0] * profile.depths[-1])) if near else 0
    )
    length = style.axis_unit(ends or float(profile.depths[-1]), "m")
    depths = profile.depths * length[0]
    for (values, name), colour, line in zip(
        (
            (profile.von_mises, "largest von Mises stress"),
            (profile.tresca, "largest Tresca stress"),
            (profile.orthogonal_shear.max(axis=1), "orthogonal shear amplitude in a pass"),
        ),
        style.SERIES,
        ("-", "--", ":"),
        strict=False,
    ):
        axes.plot(depths, values * factor, line, color=colour, lw=1.8, marker=".", label=name)
    for number, edge in enumerate(interfaces(result.material) if result.parts else ()):
        axes.axvline(float(edge) * length[0], color=style.NEUTRAL, lw=1)
        place = {"xycoords": axes.get_xaxis_transform(), "ha": "right", "va": "top"}
        point, name = (float(edge) * length[0], 1), result.parts[number].name
        style.label_point(axes, name, point, (-3, -3), rotation=90, **place)
    if strength:
        _draw_yield_strength(axes, strength, (factor, unit))
    if near:
        first = 10.0 ** math.ceil(math.log10(float(depths[depths > 0][0])))
        axes.set_xscale("symlog", linthresh=first, linscale=0.5)
    axes.set_xlim(0, float(depths[-1]) or None)
    axes.set_ylim(bottom=0)
    axes.margins(y=0.1)
    style.plain_axes(axes, f"depth [{length[1]}]", f"stress [{unit}]")
    style.legend_below(axes)
    style.name_axes(axes, title=_stress_title(result, (factor, unit), length))
    return figure


def _draw_yield_strength(axes: Axes, strength: float, scale: tuple[float, str]) -> None:
    """Draw the yield strength as a labeled line."""
    height = strength * scale[0]
    axes.axhline(height, color=style.NEUTRAL, ls=(0, (5, 3)), lw=1.5)
    name, place = style.in_unit(strength, scale, "Pa"), axes.get_yaxis_transform()
    style.label_point(
        axes, f"yield strength {name}", (1, height), (-3, 3), xycoords=place, ha="right"
    )


def stress_section(
    result: StressResult, along: str = "x", depth: float | None = None, width: float | None = None
) -> Figure:
    """Draw the von Mises stress on a vertical plane through its maximum.

    Parameters
    ----------
    result : StressResult
        The stress below a contact.
    along : {"x", "y"}
        The horizontal axis of the plane.
    depth : float, optional
        Depth of the section [m]; by default down to a quarter of the largest stress, but at least
        two fifths of the width; limited by the depths of the result.
    width : float, optional
        Width of the section [m], around the maximum but within the map; by default two and a half
        times the connected part with at least a quarter of the largest stress, or the whole map
        if this is more than half of the map.

    Returns
    -------
    Figure
        The stress, true to scale, with a cross on its maximum. Stress above the yield strength is
        black.

    Raises
    ------
    InputError
        If ``along`` is unknown, depth or width is not positive, or there is only one depth.
    """
    values = result.von_mises_section(along)
    axis = 1 if along == "x" else 0
    edge = result.solution.surface.pixel[axis]
    columns = shown_columns(values, edge, width)
    values = values[:, columns]
    first, last = columns.start * edge, columns.stop * edge
    depth = shown_depth(result, values, depth, last - first)
    block = max(math.ceil(values.shape[1] / style.CELLS_ALONE), 1)
    rows = section_rows(
        style.reduce_cells(np.maximum, values, (1, block)), result.profile.depths, depth
    )
    across = np.append(np.arange(columns.start, columns.stop, block), columns.stop) * edge
    aspect = depth / (last - first)
    height = max(5.8 * min(aspect, 1.6), 0.4) + (3.0 if aspect <= style.MIN_LABEL_RATIO else 1.8)
    figure, axes = style.panels(7.2, height)
    top, scale = stress_scale(result)
    length = style.prefixed_window(first, last)
    mesh = _draw_section(axes, across * length[0], depth * length[0], rows * scale[0])
    mesh.set_clim(0, top * scale[0])
    x, y = (result.max_von_mises_at[number] * length[0] for number in (1 + axis, 0))
    style.mark_place(axes, x, y, clip_on=False)
    style.name_axes(axes, f"{along} [{length[1]}]", f"depth [{length[1]}]")
    style.few_ticks(axes, aspect)
    _stress_bar(axes, mesh, result, scale[1])
    style.name_axes(axes, title=_stress_title(result, scale, length))
    return figure


def _draw_section(axes: Axes, across: Any, depth: float, rows: Any) -> Any:
    """Draw rows of stress down to a depth, true to scale; return the mesh."""
    mesh = axes.pcolormesh(
        across,
        np.linspace(0, depth, SECTION_ROWS + 1),
        rows,
        cmap=style.field_colours(over=style.OVER),
        rasterized=True,
    )
    axes.set_aspect("equal")
    axes.set_xlim(across[0], across[-1])
    axes.set_ylim(depth, 0)
    axes.tick_params(labelsize=style.TICK)
    return mesh


def shown_columns(values: Any, edge: float, width: float | None) -> slice:
    """Return the drawn pixels of a section."""
    strongest = values.max(axis=0)
    middle, points = int(strongest.argmax()), values.shape[1]
    if width is None:
        weak = np.flatnonzero(strongest < _STRONG * strongest[middle])
        first = int(weak[weak < middle].max(initial=-1)) + 1
        last = int(weak[weak > middle].min(initial=points))
        middle = (first + last) // 2
        wide = max(math.ceil(_AROUND * (last - first)), _MIN_PIXELS)
        width = wide * edge if wide < _MAX_MAP_SHARE * points else math.inf
    elif not width > 0:
        raise input_error("width", width, "must be positive [m]")
    return slice(*window(middle, edge, points, width))


def shown_depth(result: StressResult, values: Any, depth: float | None, width: float) -> float:
    """Return the depth of a drawn section [m]; raise `InputError` if it is invalid."""
    depths = result.profile.depths
    if depths.size < 2:
        raise InputError("a section needs at least two depths, and the result has one")
    if depth is None:
        strong = int(np.flatnonzero(values.max(axis=1) >= _STRONG * values.max())[-1])
        depth = max(float(depths[min(strong + 1, depths.size - 1)]), _MIN_DEPTH_RATIO * width)
    if not 0 < depth < math.inf:
        raise input_error("depth", depth, "must be positive and finite [m]")
    return min(depth, float(depths[-1]))


def section_rows(cells: Any, depths: Any, depth: float) -> Any:
    """Return the cells of a section, resampled to rows of equal height down to a depth [m]."""
    # Depths are graded: interpolate linearly.
    fine = depth / SECTION_ROWS * (np.arange(SECTION_ROWS) + 0.5)
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
        Maximum over the depth, with a cross at its largest value. Stress above the yield strength
        is black.
    """
    peak, size = result.profile.peak, result.solution.surface.size
    strength = result.profile.yield_strength
    over = strength is not None and result.max_von_mises > strength
    figure, axes = style.single_axes(size, legend=over)
    blocks = style.cell_size(peak.shape, size, style.CELLS_ALONE)
    top, (factor, unit) = stress_scale(result)
    cells = style.cell_max(peak, blocks)
    image = style.draw_map(axes, cells * factor, size, blocks, peak.shape)
    image.set_cmap(style.field_colours(over=style.OVER))
    image.set_clim(0, top * factor)
    length = style.axis_unit(max(size), "m")
    _, y, x = result.max_von_mises_at
    style.mark_place(axes, x * length[0], y * length[0])
    _stress_bar(axes, image, result, unit)
    more = ""
    if over and strength is not None:
        share = format_percent(float(np.count_nonzero(peak > strength)) / peak.size)
        style.patch_legend(
            axes, [(style.OVER, f"yield strength exceeded below {share} of the map")]
        )
        black = float(style.cell_points(peak.shape, blocks)[cells > strength].sum()) / peak.size
        more = f"That makes {format_percent(black)} of the figure black."
    style.name_axes(axes, title=_stress_title(result, (factor, unit), length))
    style.cell_note(figure, blocks, "the largest stress in it", more)
    return figure


def _stress_title(result: StressResult, scale: tuple[float, str], length: tuple[float, str]) -> str:
    stress = style.in_unit(result.max_von_mises, scale, "Pa")
    depth = result.max_von_mises_at[0]
    where = f"at depth {style.in_unit(depth, length, 'm')}" if depth > 0 else "at the surface"
    which = "" if result.body == "body" else " in the counter-body"
    return (
        f"Von Mises stress{which} at {style.load_text(result.solution)}, largest\n"
        f"{stress} {where}{style.doubt_suffix(result.solution)}"
    )


def stress_scale(result: StressResult) -> tuple[float, tuple[float, str]]:
    """Return the end of the color scale [Pa], at most the yield strength, and its unit."""
    strength = result.profile.yield_strength
    top = result.max_von_mises if strength is None else min(result.max_von_mises, strength)
    return top or 1.0, style.axis_unit(top, "Pa")


def _stress_bar(axes: Axes, image: Any, result: StressResult, unit: str) -> None:
    over = result.max_von_mises > stress_scale(result)[0]
    label = f"von Mises stress [{unit}]" + (", black: above yield" if over else "")
    style.colour_bar(axes, image, label, "max" if over else "neither")
