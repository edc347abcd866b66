"""Figures of contacts with plasticity of the volume, drawn from stored values.

The style is that of `roughcontact.drawing.maps`, which draws the maps of pressure, gap and heights.
Layers are drawn with their true thickness.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughcontact.drawing import style
from roughcontact.drawing.sections import window
from roughcontact.elastoplastic.volume_result import ElastoplasticResult
from roughcontact.errors import require_positive
from roughcontact.units import count_noun, format_engineering, format_percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from roughcontact.elastoplastic.volume_result import DepthProfile, DepthSection

Array = NDArray[Any]
# Values, name and lowest value of a line; values, name, colors and limits of a field.
_LineOf = tuple[Array, str, float]
_FieldOf = tuple[Array, str, Any, float, float]

# Depth of sections and profiles over the depth of the plastic zone; over the drawn width, minimum
# and maximum.
_BELOW_ZONE = 1.4
_FLATTEST, _STEEPEST = 0.25, 0.8
# Section [inch]: widths of the page and of its panels, left edges of the two columns.
_PAGE, _PANEL, _LEFT = 10.8, 3.6, (0.8, 6.1)
# Margins above, between and below the panels, and the height of the panels of lines.
_ABOVE, _BETWEEN, _BELOW, _LINES = 0.6, 0.42, 0.6, 1.2


def residual_displacement(result: ElastoplasticResult) -> Figure:
    """Draw the residual displacement: the contribution of plastic strain to the gap.

    Parameters
    ----------
    result : ElastoplasticResult
        A state of the volume.

    Returns
    -------
    Figure
        Displacement into the bodies, with the edge of the contact as a line; points raised
        above the initial surface have the opposite color.
    """
    from matplotlib import colormaps
    from matplotlib.colors import TwoSlopeNorm

    contact, values = result.solution, result.residual_displacement
    size, shape = contact.surface.size, values.shape
    figure, axes = style.single_axes(size, legend=False)
    blocks = style.cell_size(shape, size, style.CELLS_ALONE)
    factor, unit = style.axis_unit(float(np.abs(values).max()), "m")
    cells = style.cell_mean(values, blocks) * factor
    deepest, highest = float(cells.max(initial=0.0)), -float(cells.min(initial=0.0))
    image = style.draw_map(axes, cells, size, blocks, shape)
    image.set_cmap(colormaps["RdBu_r"])
    # Symmetric limits: zero is white, and equal heights and depths have colors of equal strength.
    top = max(deepest, highest) or 1.0
    image.set_norm(TwoSlopeNorm(0.0, -top, top))
    if highest < 0.02 * top:
        image.set_norm(None)
        image.set_cmap(style.listed_colormap(colormaps["RdBu_r"](np.linspace(0.5, 1, 256))))
        image.set_clim(0, top)
    style.colour_bar(axes, image, f"residual displacement [{unit}]", "neither")
    # Cells with at least half of their points in contact are inside: the area is about preserved.
    touching = style.cell_share(contact.contact, blocks) >= 0.5
    length, _ = style.axis_unit(max(size), "m")
    y, x = (
        np.append(np.arange(0, points, block), points) * edge * length
        for points, block, edge in zip(shape, blocks, contact.surface.pixel, strict=True)
    )
    style.outline(axes, touching, y, x, style.NEUTRAL)
    largest = format_engineering(float(values.max()), "m", 3)
    style.name_axes(
        axes, title=f"Residual displacement, up to {largest}{style.doubt_suffix(result)}"
    )
    style.cell_note(figure, blocks, "the mean displacement in it")
    return figure


def section(
    result: ElastoplasticResult,
    along: str = "x",
    index: int | None = None,
    body: int = 0,
    width: float | None = None,
) -> Figure:
    """Draw plastic strain and stress on a vertical plane, with the pressure above it.

    Parameters
    ----------
    result : ElastoplasticResult
        A state of the volume.
    along : {"x", "y"}
        The horizontal axis of the plane.
    index : int, optional
        Row of the map, or column with ``along="y"``; by default through the largest plastic
        strain.
    body : int
        Which of the bodies that yield, the rough one first.
    width : float, optional
        Drawn length [m], around the largest plastic strain of the section but within the map; by
        default the whole map.

    Returns
    -------
    Figure
        Pressure and residual displacement along the surface; accumulated plastic strain; von
        Mises stress under load over the yield strength at that strain; residual von Mises stress,
        and normal stress along the plane. True to scale, the plastic zone inside a line, a cross
        on its largest strain. Without load there is neither pressure nor stress under it, and the
        normal stress across the layers instead.

    Raises
    ------
    InputError
        If there is no such body, ``along`` is something else, the plane misses the map, or the
        width is not positive and finite.
    """
    from matplotlib.figure import Figure

    if width is not None:
        require_positive(width=width)
    cut = _window(result.section(along, index, body), width)
    plane, columns = cut.plane, cut.columns
    length = float(plane.edges[columns.stop] - plane.edges[columns.start])
    height = _PANEL * cut.depth / length
    fields, lines = _fields(result, cut), _lines(result, plane)
    lines_tall = (_LINES + _BETWEEN) * bool(lines)
    tall = _ABOVE + lines_tall + 2 * height + _BETWEEN + _BELOW
    figure = Figure(figsize=(_PAGE, tall), dpi=style.DPI)
    factor, unit = style.axis_unit(length, "m")
    for column, line in enumerate(lines):
        _draw_line(_panel(figure, column, _ABOVE, _LINES), line, cut, factor)
    for number, field in enumerate(fields):
        row, column = divmod(number, 2)
        top = _ABOVE + lines_tall + row * (height + _BETWEEN)
        axes = _panel(figure, column, top, height)
        mesh = _draw_field(axes, field, cut, factor)
        axes.tick_params(labelsize=style.TICK, labelbottom=row == 1)
        _few_levels(axes, height)
        style.name_axes(axes, f"{along} [{unit}]" if row else "")
        style.name_axes(axes, y="" if column else f"{'depth' if height > 0.8 else 'z'} [{unit}]")
        _bar(_panel(figure, column, top, height, _PANEL + 0.1, 0.14), mesh, height)
    where = f"at {'y' if along == 'x' else 'x'} = {format_engineering(plane.across, 'm', 4)}"
    title = f"Section{_which(result, body)} along {along} {where}, {_state(result, body)}"
    figure.suptitle(title, fontsize=style.TITLE, y=1 - 0.1 / tall, va="top")
    return figure


def _panel(
    figure: Figure, column: int, top: float, high: float, offset: float = 0.0, wide: float = _PANEL
) -> Axes:
    """Add axes to a page of panels, at a distance from its top [inch]."""
    tall = float(figure.get_figheight())
    corner = (_LEFT[column] + offset) / _PAGE, 1 - (top + high) / tall
    return figure.add_axes((*corner, wide / _PAGE, high / tall))


def _bar(axes: Axes, mesh: Any, height: float) -> None:
    axes.figure.colorbar(mesh, cax=axes)
    axes.tick_params(labelsize=style.TICK)
    _few_levels(axes, height)


def _limits(cut: _Cut, factor: float) -> list[float]:
    return [float(cut.plane.edges[end] * factor) for end in (cut.columns.start, cut.columns.stop)]


def _draw_line(axes: Axes, line: _LineOf, cut: _Cut, factor: float) -> None:
    values, name, lowest = line
    axes.stairs(values, cut.plane.edges * factor, fill=True, color=style.ELASTIC)
    axes.set_xlim(*_limits(cut, factor))
    axes.set_ylim(1.08 * lowest, 1.08 * float(values.max()) or 1.0)
    axes.set_title(name, fontsize=style.TICK, loc="left", pad=4)
    axes.tick_params(labelbottom=False)
    style.plain_axes(axes)
    _few_levels(axes, _LINES)


def _draw_field(axes: Axes, field: _FieldOf, cut: _Cut, factor: float) -> Any:
    values, name, colours, low, high = field
    plane, columns, rows = cut.plane, cut.columns, cut.rows
    across = plane.edges[columns.start : columns.stop + 1] * factor
    down = plane.faces[rows.start : rows.stop + 1] * factor
    mesh = axes.pcolormesh(across, down, np.ma.masked_invalid(values), rasterized=True)
    mesh.set_cmap(colours)
    mesh.set_clim(low, high)
    style.outline(
        axes, plane.accumulated > 0, plane.faces * factor, plane.edges * factor, style.NEUTRAL
    )
    if plane.accumulated.any():
        layer, pixel = cut.largest
        marker = [plane.place[pixel] * factor], [plane.depth[layer] * factor]
        for colour, line in (("#ffffff", 4.0), (style.SERIES[0], 1.8)):
            axes.plot(*marker, "+", color=colour, ms=9, mew=line)
    axes.set_xlim(*_limits(cut, factor))
    axes.set_ylim(cut.depth * factor, 0)
    axes.set_title(name, fontsize=style.TICK, loc="left", pad=4)
    return mesh


def profile(
    result: ElastoplasticResult, point: tuple[int, int] | None = None, body: int = 0
) -> Figure:
    """Draw plastic strain and stress over the depth below a point.

    Parameters
    ----------
    result : ElastoplasticResult
        A state of the volume.
    point : (int, int), optional
        Row and column on the map; by default those of the largest plastic strain.
    body : int
        Which of the bodies that yield, the rough one first.

    Returns
    -------
    Figure
        Accumulated plastic strain; von Mises stress under load, residual, and yield strength;
        residual normal stresses. Every step is a layer.

    Raises
    ------
    InputError
        If there is no such body, or the point is outside the map.
    """
    answer = result.profile(point, body)
    figure, grid = style.panels(10.8, 5.6, 1, 3, sharey=True)
    depths = _label_depths(grid, answer.faces, answer.accumulated)
    draw_steps(grid[0], 100 * answer.accumulated, depths, style.SERIES[0], "-", "")
    grid[0].set_xlim(left=0)
    style.name_axes(grid[0], "accumulated plastic strain [%]")
    _draw_strength(grid[1], answer, depths, loaded=bool(result.solution.load))
    _draw_residual(grid[2], answer, depths)
    for axes in grid[1:]:
        axes.legend(
            loc="lower center",
            bbox_to_anchor=(0.5, 1),
            ncols=3,
            fontsize=style.TICK,
            frameon=False,
            handlelength=1.6,
            columnspacing=1.0,
            handletextpad=0.5,
        )
    y, x = (format_engineering(place, "m", 4) for place in answer.place)
    figure.suptitle(
        f"Below y = {y}, x = {x}{_which(result, body)}, {_state(result, body)}",
        fontsize=style.TITLE,
    )
    return figure


def _draw_strength(axes: Axes, result: DepthProfile, depths: Array, loaded: bool) -> None:
    top = max(float(result.von_mises.max()), float(result.strength[0]))
    factor, unit = style.axis_unit(top, "Pa")
    lines = [(result.residual_von_mises, style.SERIES[1], "--", "residual")]
    if loaded:
        lines.append((result.von_mises, style.SERIES[0], "-", "under load"))
    # Drawn on top: where the material yields, the stress under load equals the yield strength.
    lines.append((result.strength, style.NEUTRAL, ":", "yield strength"))
    for values, colour, line, name in lines:
        draw_steps(axes, values * factor, depths, colour, line, name)
    axes.set_xlim(left=0)
    style.name_axes(axes, f"von Mises stress [{unit}]")


def _draw_residual(axes: Axes, result: DepthProfile, depths: Array) -> None:
    residual = np.diagonal(result.residual_stress, axis1=-2, axis2=-1)
    factor, unit = style.axis_unit(float(np.abs(residual).max()), "Pa")
    for axis, colour, line in zip("xyz", style.SERIES, ("-", "--", ":"), strict=False):
        values = residual[:, "xyz".index(axis)] * factor
        draw_steps(axes, values, depths, colour, line, rf"$\sigma_{{{axis * 2}}}$")
    axes.axvline(0, color="#000000", lw=0.9)
    style.name_axes(axes, f"residual stress [{unit}], tension > 0")


def layers(result: ElastoplasticResult, body: int = 0) -> Figure:
    """Draw the largest plastic strain and stress of each layer over the depth.

    Parameters
    ----------
    result : ElastoplasticResult
        A state of the volume.
    body : int
        Which of the bodies that yield, the rough one first.

    Returns
    -------
    Figure
        Share of the layer that has plastic strain; largest accumulated strain; largest von Mises
        stress under load and residual.

    Raises
    ------
    InputError
        If there is no such body.
    """
    answer = result.layers(body)
    figure, grid = style.panels(10.8, 5.6, 1, 3, sharey=True)
    depths = _label_depths(grid, answer.faces, answer.max_accumulated)
    for axes, values, name in (
        (grid[0], answer.plastic_fraction, "plastic share of the layer [%]"),
        (grid[1], answer.max_accumulated, "largest plastic strain [%]"),
    ):
        draw_steps(axes, 100 * values, depths, style.SERIES[0], "-", "")
        style.name_axes(axes, name)
    factor, unit = style.axis_unit(float(answer.max_von_mises.max()), "Pa")
    residual, loaded = answer.max_residual_von_mises * factor, answer.max_von_mises * factor
    draw_steps(grid[2], residual, depths, style.SERIES[1], "--", "residual")
    if result.solution.load:
        draw_steps(grid[2], loaded, depths, style.SERIES[0], "-", "under load")
    style.name_axes(grid[2], f"largest von Mises stress [{unit}]")
    for axes in grid:
        axes.set_xlim(left=0)
    grid[2].legend(
        loc="lower center", bbox_to_anchor=(0.5, 1), ncols=2, fontsize=style.TICK, frameon=False
    )
    figure.suptitle(
        f"Layer by layer{_which(result, body)}, {_state(result, body)}", fontsize=style.TITLE
    )
    return figure


def path(result: ElastoplasticResult) -> Figure:
    """Draw the increments over the load, or over their number if the bodies slide.

    Parameters
    ----------
    result : ElastoplasticResult
        A state of the volume.

    Returns
    -------
    Figure
        Approach, contact area, largest pressure and largest plastic strain, from first contact
        on; loading and unloading have different colors, a ring marks the end.
    """
    steps = result.increments
    figure, grid = style.panels(10.8, 8.2, 2, 2, sharex=True)
    load = np.array([0.0, *(step.load for step in steps)])
    factor, unit = style.axis_unit(float(load.max()), "N")
    abscissa, over = load * factor, f"load [{unit}]"
    if result.has_moved:
        # Under a constant load, all points would coincide.
        abscissa, over = np.arange(load.size, dtype=float), "increment"
    unloads = np.diff(load) < 0
    quantities = [
        ([step.approach for step in steps], "approach", "m"),
        ([step.contact_area for step in steps], "contact area", "m²"),
        ([step.max_pressure for step in steps], "largest pressure", "Pa"),
        ([100 * step.max_plastic_strain for step in steps], "largest plastic strain", "%"),
    ]
    for axes, (answer, name, dimension) in zip(grid.ravel(), quantities, strict=True):
        values = np.array([0.0, *answer])
        top = float(values.max())
        scale, shown = (1.0, "%") if dimension == "%" else style.axis_unit(top, dimension)
        x, y = abscissa, values * scale
        for kind, colour, line, label in (
            (False, style.SERIES[0], "-", "loading"),
            (True, style.SERIES[1], "--", "unloading"),
        ):
            if (unloads == kind).any():
                gaps = np.full(unloads.size, np.nan)
                parts = np.where(unloads == kind, [x[:-1], x[1:], gaps], np.nan).T.ravel()
                heights = np.array([y[:-1], y[1:], gaps]).T.ravel()
                axes.plot(parts, heights, line, color=colour, lw=1.9, label=label)
        axes.plot(x[1:], y[1:], "o", color=style.NEUTRAL, ms=4)
        axes.plot(x[-1:], y[-1:], "o", color=style.NEUTRAL, ms=9, mfc="none", label="end")
        axes.set_xlim(0, 1.05 * float(x.max()) or 1.0)
        axes.set_ylim(min(0.0, 1.05 * float(y.min())), 1.08 * float(y.max()) or 1.0)
        style.plain_axes(axes, y=f"{name} [{shown}]")
    for axes in grid[1]:
        style.name_axes(axes, over)
    count = count_noun(len(steps), "increment")
    style.shared_legend(
        figure,
        grid,
        f"Path{'' if result.has_moved else ' of loads'}, {count}{style.doubt_suffix(result)}",
    )
    return figure


def convergence(result: ElastoplasticResult) -> Figure:
    """Draw the residual of the plastic strain over the iterations.

    Parameters
    ----------
    result : ElastoplasticResult
        A state of the volume.

    Returns
    -------
    Figure
        One line per increment, one after the other, and the tolerance.
    """
    figure, axes = style.panels(7.6, 4.4)
    largest = max((max(step.residuals) for step in result.increments), default=1.0)
    # Without yielding the residual is 0, which a logarithmic axis cannot show.
    style.log_scale(axes, "y")
    axes.set_ylim(result.tolerance / 10, 3 * max(largest, result.tolerance))
    first = 1
    for number, step in enumerate(result.increments):
        iterations = np.arange(first, first + step.iterations)
        axes.plot(iterations, step.residuals, ".-", color=style.SERIES[number % 2], lw=1.4, ms=4)
        first += step.iterations
    axes.axhline(result.tolerance, color=style.NEUTRAL, lw=1.2, ls=":", label="tolerance")
    axes.set_xlim(0, first)
    style.plain_axes(axes, "iteration, all increments together", "residual of the plastic strain")
    count = count_noun(len(result.increments), "increment")
    style.shared_legend(
        figure, np.array([axes]), f"Convergence, {count}{style.doubt_suffix(result)}"
    )
    return figure


class _Cut(NamedTuple):
    """Section to draw: layers and pixels, depth [m], position of the largest strain."""

    plane: DepthSection
    rows: slice
    columns: slice
    depth: float
    largest: tuple[int, int]


def _window(plane: DepthSection, width: float | None) -> _Cut:
    values = plane.accumulated if plane.accumulated.any() else plane.von_mises
    layer, column = (int(i) for i in np.unravel_index(values.argmax(), values.shape))
    edge = float(plane.edges[1])
    first, end = window(column, edge, plane.place.size, width or math.inf)
    length = (end - first) * edge
    depth = _shown_depth(plane.faces, plane.accumulated)
    depth = min(max(depth, _FLATTEST * length), _STEEPEST * length, float(plane.faces[-1]))
    last = int(np.searchsorted(plane.faces, depth * (1 - 1e-9)))
    return _Cut(plane, slice(0, last), slice(first, end), depth, (layer, column))


def _shown_depth(faces: Array, accumulated: Array) -> float:
    """Return the drawn depth [m]: slightly below the plastic zone, else all layers."""
    plastic = np.flatnonzero(accumulated.reshape(len(accumulated), -1).any(axis=1))
    if not plastic.size:
        return float(faces[-1])
    return min(_BELOW_ZONE * float(faces[plastic[-1] + 1]), float(faces[-1]))


def _lines(result: ElastoplasticResult, plane: DepthSection) -> list[_LineOf]:
    """Return values, names and lowest values of the lines along the surface."""
    if not result.solution.load:
        return []
    lines = []
    for values, name, unit in (
        (plane.pressure, "pressure", "Pa"),
        (plane.residual_displacement, "residual displacement", "m"),
    ):
        factor, shown = style.axis_unit(float(np.abs(values).max()), unit)
        lines.append((values * factor, f"{name} [{shown}]", min(0.0, float(values.min()) * factor)))
    return lines


def _fields(result: ElastoplasticResult, cut: _Cut) -> list[_FieldOf]:
    """Return values, names, colors and limits of the fields on a section."""
    from matplotlib import colormaps

    part, plane = (cut.rows, cut.columns), cut.plane
    colours = style.field_colours(bad=style.OPEN)
    strain = 100 * plane.accumulated[part]
    most, yielded = float(strain.max()) or 1.0, np.where(strain > 0, strain, np.nan)
    residual = plane.residual_von_mises[part]
    factor, unit = style.axis_unit(float(residual.max()), "Pa")
    top = float(residual.max()) * factor or 1.0
    fields = [
        (yielded, "accumulated plastic strain [%]", colours, 0.0, most),
        (residual * factor, f"residual von Mises stress [{unit}]", colours, 0.0, top),
    ]
    if result.solution.load:
        # The residual of the iteration can make the ratio exceed one by about 1e-4.
        ratio = np.minimum(plane.von_mises[part] / plane.strength[part], 1.0)
        fields.insert(1, (ratio, "von Mises stress under load / yield strength", colours, 0.0, 1.0))
    for axis in [plane.along] if result.solution.load else [plane.along, "z"]:
        number = "xyz".index(axis)
        normal = plane.residual_stress[part][..., number, number]
        top = float(np.abs(normal).max())
        factor, unit = style.axis_unit(top, "Pa")
        name = rf"residual stress $\sigma_{{{axis * 2}}}$ [{unit}], red: tension"
        top = top * factor or 1.0
        fields.append((normal * factor, name, colormaps["RdBu_r"], -top, top))
    return fields


def _label_depths(grid: NDArray[Any], faces: Array, accumulated: Array) -> Array:
    """Label panels with the depth of layers as common axis; return the faces in its unit."""
    from matplotlib.ticker import MaxNLocator

    length, unit = style.axis_unit(float(faces[-1]), "m")
    for axes in grid:
        style.plain_axes(axes)
        axes.xaxis.set_major_locator(MaxNLocator(4))
    style.name_axes(grid[0], y=f"depth [{unit}]")
    grid[0].set_ylim(_shown_depth(faces, accumulated) * length, 0)
    return faces * length


def draw_steps(axes: Axes, values: Array, depths: Array, colour: str, line: Any, name: str) -> None:
    """Draw the values of layers over the depth."""
    axes.stairs(
        values,
        depths,
        orientation="horizontal",
        baseline=None,
        color=colour,
        ls=line,
        lw=1.8,
        label=name,
    )


def _few_levels(axes: Axes, height: float) -> None:
    from matplotlib.ticker import MaxNLocator

    axes.yaxis.set_major_locator(MaxNLocator(max(round(2.4 * height), 2)))


def _which(result: ElastoplasticResult, body: int) -> str:
    if len(result.bodies) == 1:
        return ""
    return " in the counter-body" if body else " in the body"


def _state(result: ElastoplasticResult, body: int) -> str:
    load = result.solution.load
    state = f"at {format_engineering(load, 'N', 3)}" if load else "unloaded"
    strain = format_percent(result.bodies[body].max_plastic_strain)
    return f"{state}, largest strain {strain}{style.doubt_suffix(result)}"
