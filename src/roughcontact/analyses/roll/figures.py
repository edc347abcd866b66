"""Figures of repeated passes: strain per pass, depth profiles and residual roughness."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.files import atomic_write, require_suffix
from roughcontact.analyses.roll.model import MovieFrame, RollingResult
from roughcontact.drawing import style
from roughcontact.drawing.elastoplastic import draw_steps
from roughcontact.errors import InputError
from roughcontact.units import count_noun, format_engineering

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


Array = NDArray[Any]

# Maximum number of passes in the depth profiles, and the lightest blue of their lines.
_LINES = 6
_LIGHTEST = 0.3

# Share of the largest value down to which profiles are drawn, and factor of the depth.
_LEAST, _MORE = 0.03, 1.4

_STYLES = ("o-", "s--", "^:")


def passes(rolling: RollingResult) -> Figure:
    """Draw strain, largest pressure, contact area and roughness pass by pass.

    Parameters
    ----------
    rolling : RollingResult
        The passes.

    Returns
    -------
    Figure
        Plastic strain that each pass adds, and its net part, on a logarithmic scale with the
        threshold of strain; largest pressure; contact area; Sq and Spk of the rough body.
    """
    from matplotlib.ticker import MaxNLocator

    figure, grid = style.panels(10.8, 7.6, 2, 2, sharex=True)
    number = np.arange(1, len(rolling.passes) + 1)
    _draw_strains(grid[0, 0], rolling, number)
    for axes, keys, unit, label in (
        (grid[0, 1], ("max_pressure",), "Pa", "largest pressure"),
        (grid[1, 0], ("contact_area",), "m²", "largest contact area"),
        (grid[1, 1], ("Sq", "Spk"), "m", "Sq, dashed Spk, after the pass"),
    ):
        lines = [np.array([getattr(item, key) for item in rolling.passes]) for key in keys]
        top = max(float(values.max()) for values in lines)
        factor, shown = style.axis_unit(top, unit)
        for values, line, colour in zip(lines, _STYLES, style.SERIES, strict=False):
            axes.plot(number, values * factor, line, color=colour)
        style.name_axes(axes, y=f"{label} [{shown}]")
        axes.set_ylim(0, 1.1 * top * factor or 1.0)
    for axes in grid.ravel():
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        style.plain_axes(axes)
    for axes in grid[1]:
        style.name_axes(axes, "pass")
        axes.set_xlim(0.5, number[-1] + 0.5)
    style.shared_legend(figure, grid, f"{_passes_text(rolling)}: {rolling.outcome_text}")
    return figure


def _draw_strains(axes: Axes, rolling: RollingResult, number: Array) -> None:
    minimum = rolling.strain_threshold
    names = {
        "strain_added": "added, forward and backward",
        "strain_net": "net",
        "largest_shear": "net mean shear",
    }
    for (key, name), line, colour in zip(names.items(), _STYLES, style.SERIES, strict=False):
        # A logarithmic scale has no zero.
        held = np.array([abs(getattr(item, key)) for item in rolling.passes])
        axes.plot(number, np.where(held > 0, held, np.nan), line, color=colour, label=name)
    axes.axhline(minimum, color=style.NEUTRAL, lw=1.2, ls="-.", label="threshold")
    style.log_scale(axes, "y")
    top = max(item.strain_added for item in rolling.passes)
    axes.set_ylim(minimum / 100, 3 * max(top, minimum))
    style.name_axes(axes, y="plastic strain by the pass")


def heights(rolling: RollingResult) -> Figure:
    """Draw the heights of the rough body before and after the passes.

    Parameters
    ----------
    rolling : RollingResult
        The passes.

    Returns
    -------
    Figure
        Height profiles along x and y through the deepest residual displacement.
    """
    result = rolling.result
    before, after = result.solution.surface, rolling.rolled_surface
    figure, grid = style.panels(10.8, 6.4, 2, 1, sharey=True)
    sunk = result.residual_displacement
    deepest = np.unravel_index(int(sunk.argmax()), sunk.shape)
    level = float(np.nanmean(before.heights))
    # Along x, then along y: the heights before and after.
    lines = [
        np.array([np.take(body.heights, deepest[axis], axis) for body in (before, after)])
        for axis in (0, 1)
    ]
    top = max(float(np.nanmax(np.abs(both - level))) for both in lines)
    factor, unit = style.axis_unit(top, "m")
    for axis, (axes, (old, new)) in enumerate(zip(grid, lines, strict=True)):
        other, along = "yx"[axis], "xy"[axis]
        place, edge = (deepest[axis] + 0.5) * before.pixel[axis], before.pixel[1 - axis]
        where = (np.arange(old.size) + 0.5) * edge
        length, length_unit = style.axis_unit(float(where[-1]), "m")
        axes.plot(where * length, (old - level) * factor, color=style.NEUTRAL, label="before")
        axes.plot(
            where * length,
            (new - level) * factor,
            color=style.SERIES[0],
            lw=1.8,
            label=f"after {len(rolling.passes)}",
        )
        style.name_axes(axes, f"{along} [{length_unit}]", f"height [{unit}]")
        axes.set_title(
            f"at {other} = {format_engineering(place, 'm', 3)}", fontsize=style.TICK, loc="left"
        )
        axes.set_xlim(0, float(where[-1] + edge / 2) * length)
        style.plain_axes(axes)
    style.shared_legend(
        figure,
        grid,
        f"Heights of the body without load{style.doubt_suffix(result)}, Sq {_sq(rolling)}",
    )
    return figure


def _sq(rolling: RollingResult) -> str:
    before, after = (
        format_engineering(value, "m", 3)
        for value in (rolling.result.solution.surface.Sq, rolling.passes[-1].Sq)
    )
    return f"{before} before, {after} after"


def depths(rolling: RollingResult, body: int = 0) -> Figure:
    """Draw depth profiles of the added shear strain and of the residual stress.

    Parameters
    ----------
    rolling : RollingResult
        The passes.
    body : int
        Index of the yielding body, the rough body first.

    Returns
    -------
    Figure
        Shear strain in the direction of the first pass; residual stress along and across the
        pass. One line per pass, darker for later passes.
    """
    from matplotlib.ticker import MaxNLocator

    faces = np.append(0.0, np.cumsum(rolling.result.bodies[body].thickness))
    figure, grid = style.panels(10.8, 5.8, 1, 3, sharey=True)
    length, length_unit = style.axis_unit(float(faces[-1]), "m")
    for axes, key, name, unit in (
        (grid[0], "shear", "shear strain by the pass [%]", ""),
        (grid[1], "residual_along", "residual stress along the pass", "Pa"),
        (grid[2], "residual_across", "residual stress across the pass", "Pa"),
    ):
        profiles = [getattr(item, key)[body] for item in rolling.passes]
        factor, shown = 100.0, ""
        if unit:
            factor, prefix = style.axis_unit(max(float(np.abs(p).max()) for p in profiles), unit)
            shown = f" [{prefix}]"
        for number, colour in _choose_passes(len(profiles)):
            values = profiles[number]
            depth = faces[: values.size + 1] * length
            draw_steps(axes, values * factor, depth, colour, "-", f"pass {number + 1}")
        axes.axvline(0, color="#000000", lw=0.9)
        style.plain_axes(axes, f"{name}{shown}")
        axes.xaxis.set_major_locator(MaxNLocator(5))
    style.name_axes(grid[0], y=f"depth [{length_unit}]")
    grid[0].set_ylim(_figure_depth(rolling, body, faces) * length, 0)
    style.shared_legend(figure, grid, _over_depth(rolling))
    return figure


def _figure_depth(rolling: RollingResult, body: int, faces: Array) -> float:
    """Return the depth of the profiles [m], slightly below the last large value."""
    deepest = 0
    for key in ("shear", "residual_along", "residual_across"):
        values = np.abs(getattr(rolling.passes[-1 if "res" in key else 0], key)[body])
        held = np.flatnonzero(values > _LEAST * values.max(initial=0.0))
        deepest = max(deepest, int(held.max(initial=0)) + 1)
    return min(_MORE * float(faces[deepest]), float(faces[-1]))


def _choose_passes(count: int) -> Sequence[tuple[int, Any]]:
    """Return the indices of the drawn passes, including first and last, with their colors."""
    from matplotlib import colormaps

    numbers = np.unique(np.geomspace(1, count, min(count, _LINES)).round().astype(int)) - 1
    shades = np.linspace(_LIGHTEST, 1, numbers.size) if numbers.size > 1 else [1.0]
    return [(int(n), colormaps["Blues"](shade)) for n, shade in zip(numbers, shades, strict=True)]


def _over_depth(rolling: RollingResult) -> str:
    periodic = len(rolling.result.solution.boundary.periodic_axes) == 2
    return (
        f"{'Means' if periodic else 'Largest values'} of each "
        f"layer{style.doubt_suffix(rolling.result)}"
    )


def _passes_text(rolling: RollingResult) -> str:
    return f"{count_noun(len(rolling.passes), 'pass')}{style.doubt_suffix(rolling.result)}"


# Maximum number of frames of a movie, duration of each and of the last [ms], and resolution [dpi].
MAX_FRAMES = 240
_SHOWN, _LAST = 100, 1500
_DPI = 72


def save(
    rolling: RollingResult, frames: Sequence[MovieFrame], path: str | os.PathLike[str]
) -> None:
    """Write a movie of passes as an animated GIF.

    Parameters
    ----------
    rolling : RollingResult
        The passes.
    frames : sequence of MovieFrame
        One frame per step; more than 240 frames are thinned evenly.
    path : str or path
        File to write; it must end in ``.gif``.

    Raises
    ------
    InputError
        If the suffix is another, or there are no frames.
    OSError
        If the file cannot be written; an old file survives.
    """
    require_suffix(path, ".gif")
    if not frames:
        raise InputError("must hold a picture at least", argument="frames")
    chosen = np.unique(np.linspace(0, len(frames) - 1, min(len(frames), MAX_FRAMES)).astype(int))
    first, *more = _pictures(rolling, [frames[number] for number in chosen])
    with atomic_write(Path(path)) as stream:
        first.save(
            stream,
            "gif",
            save_all=True,
            append_images=more,
            loop=0,
            optimize=False,
            duration=[_SHOWN] * len(more) + [_LAST],
        )


def _pictures(rolling: RollingResult, frames: Sequence[MovieFrame]) -> list[Any]:
    """Return the images of the frames, with a common color scale."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from PIL import Image

    ny, nx = rolling.result.solution.surface.shape
    wide = 9.0
    tall = min(max(wide * ny / nx, 1.6), 6.0)
    figure = Figure(figsize=(wide, tall + 3.6), dpi=_DPI, layout=style.layout())
    canvas: Any = FigureCanvasAgg(figure)
    above, below = figure.subplots(2, 1, height_ratios=(tall, 3.0))
    pressure = _draw_pressure(above, rolling, frames)
    strain = _draw_strain(below, rolling, frames)
    title = figure.suptitle(" ", fontsize=style.TITLE)
    count = len(rolling.passes)
    pictures: list[Any] = []
    for frame in frames:
        pressure.set_data(_mask_open(frame.pressure))
        values = np.zeros((rolling.result.bodies[0].thickness.size, frame.strain.shape[1]))
        values[: len(frame.strain)] = 100 * frame.strain
        strain.set_array(np.ma.masked_equal(values, 0))
        title.set_text(f"pass {frame.number} of {count}, step {frame.step}")
        canvas.draw()
        # Freeze the layout after the first frame, so that the axes do not move.
        figure.set_layout_engine("none")
        dots = Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3].copy())
        # A common palette prevents flicker.
        pictures.append(dots.quantize(palette=pictures[0]) if pictures else _with_palette(dots))
    return pictures


def _with_palette(picture: Any) -> Any:
    """Return the first image, with a palette for all images."""
    from matplotlib import colormaps
    from PIL import Image

    scale = (255 * colormaps["inferno_r"](np.linspace(0, 0.63, 200))[:, :3]).astype(np.uint8)
    greys = np.linspace(0, 255, 50).astype(np.uint8)[:, None].repeat(3, axis=1)
    rest = np.array([[255, 255, 255], _rgb(style.OPEN), [0, 0, 0]], np.uint8)
    colours = Image.new("P", (1, 1))
    colours.putpalette(np.concatenate([scale, greys, rest]).ravel().tolist())
    return picture.quantize(palette=colours, dither=Image.Dither.NONE)


def _rgb(colour: Any) -> list[int]:
    from matplotlib.colors import to_rgb

    return [round(255 * part) for part in to_rgb(colour)]


def _mask_open(pressure: NDArray[Any]) -> Any:
    return np.ma.masked_equal(pressure, 0)


def _draw_pressure(axes: Any, rolling: RollingResult, frames: Sequence[MovieFrame]) -> Any:
    size = rolling.result.solution.surface.size
    length, unit = style.axis_unit(max(size), "m")
    top = max(float(frame.pressure.max()) for frame in frames)
    factor, shown = style.axis_unit(top, "Pa")
    image = axes.imshow(
        _mask_open(frames[0].pressure),
        origin="lower",
        vmin=0,
        vmax=top,
        cmap=style.field_colours(bad=style.OPEN),
        extent=(0, size[1] * length, 0, size[0] * length),
        aspect="auto",
        interpolation="nearest",
    )
    style.name_axes(axes, y=f"y [{unit}]")
    _add_bar(axes, image, "contact pressure", shown, lambda value, _: f"{value * factor:.3g}")
    return image


def _add_bar(axes: Any, drawn: Any, title: str, unit: str, form: Any = None) -> None:
    axes.set_title(title, fontsize=style.TICK, loc="left")
    bar = axes.figure.colorbar(drawn, ax=axes, format=form)
    bar.set_label(f"[{unit}]", fontsize=style.TICK)
    bar.ax.tick_params(labelsize=style.TICK)


def _draw_strain(axes: Any, rolling: RollingResult, frames: Sequence[MovieFrame]) -> Any:
    size = rolling.result.solution.surface.size
    along = along_of(rolling.direction)
    length, unit = style.axis_unit(max(size), "m")
    faces = np.append(0.0, np.cumsum(rolling.result.bodies[0].thickness)) * length
    points = frames[-1].strain.shape[1]
    edges = np.linspace(0, size[1 if along == "x" else 0] * length, points + 1)
    top = 100 * max(float(frame.strain.max()) for frame in frames)
    mesh = axes.pcolormesh(
        edges,
        faces,
        np.zeros((faces.size - 1, points)),
        cmap=style.field_colours(bad=style.OPEN),
        vmin=0,
        vmax=top or 1.0,
    )
    axes.set_ylim(faces[-1], 0)
    style.name_axes(axes, f"{along} [{unit}]", f"depth [{unit}]")
    _add_bar(axes, mesh, f"accumulated plastic strain, the largest across {along}", "%")
    return mesh


def along_of(direction: float) -> str:
    """Return the axis of the map that is closest to a direction [degrees]."""
    return "x" if abs(np.cos(np.radians(direction))) >= np.sqrt(0.5) - 1e-9 else "y"
