"""Figures of repeated passes: what each adds, what it leaves over the depth and on the surface."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.plots.labels import doubt
from roughcontact.plots.style import (
    DPI,
    LABEL,
    NEUTRAL,
    SERIES,
    TICK,
    TITLE,
    layout,
    plain_axes,
    prefixed,
    prefixed_area,
    shared_legend,
)
from roughcontact.units import engineering
from roughcontact.volume.rolling import Rolling

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[Any]

# Passes that have a line of their own over the depth, and the lightest of their blues.
_LINES = 6
_LIGHTEST = 0.3

# Part of the largest value down to which profiles are drawn, and how much deeper.
_LEAST, _MORE = 0.03, 1.4

_STYLES = ("o-", "s--", "^:")


def passes(rolling: Rolling) -> Figure:
    """Draw what each pass adds to the strain, its largest pressure and area, and the roughness.

    Parameters
    ----------
    rolling : Rolling
        The passes.

    Returns
    -------
    Figure
        Plastic strain that each pass adds and what is left of it, on a logarithmic scale with the
        strain that counts as none; largest pressure; contact area; Sq and Spk of the rough body.
    """
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    figure = Figure(figsize=(10.8, 7.6), dpi=DPI, layout=layout())
    grid = figure.subplots(2, 2, sharex=True)
    number = np.arange(1, len(rolling.passes) + 1)
    _draw_strains(grid[0, 0], rolling, number)
    for axes, keys, unit, label in (
        (grid[0, 1], ("max_pressure",), "Pa", "largest pressure"),
        (grid[1, 0], ("contact_area",), "m²", "largest contact area"),
        (grid[1, 1], ("Sq", "Spk"), "m", "Sq, dashed Spk, after the pass"),
    ):
        lines = [np.array([getattr(one, key) for one in rolling.passes]) for key in keys]
        top = max(float(values.max()) for values in lines)
        factor, shown = prefixed_area(top or 1.0) if unit == "m²" else prefixed(top, unit)
        for values, line, colour in zip(lines, _STYLES, SERIES, strict=False):
            axes.plot(number, values * factor, line, color=colour)
        axes.set_ylabel(f"{label} [{shown}]", fontsize=LABEL)
        axes.set_ylim(0, 1.1 * top * factor or 1.0)
    for axes in grid.ravel():
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        plain_axes(axes)
    for axes in grid[1]:
        axes.set_xlabel("pass", fontsize=LABEL)
        axes.set_xlim(0.5, number[-1] + 0.5)
    shared_legend(figure, grid)
    figure.suptitle(f"{_counted(rolling)}: {rolling.answer}", fontsize=TITLE)
    return figure


def _draw_strains(axes: Axes, rolling: Rolling, number: Array) -> None:
    least = rolling.least_strain
    shear = [abs(one.largest_shear) for one in rolling.passes]
    for values, line, colour, name in (
        ([one.flow for one in rolling.passes], "o-", SERIES[0], "added, there and back counted"),
        ([one.gain for one in rolling.passes], "s--", SERIES[1], "left of it"),
        (shear, "^:", SERIES[2], "mean shear left of it"),
    ):
        # What is zero has no place on a logarithmic scale.
        held = np.array(values)
        axes.plot(number, np.where(held > 0, held, np.nan), line, color=colour, label=name)
    axes.axhline(least, color=NEUTRAL, linewidth=1.2, linestyle="-.", label="counts as none")
    axes.set_yscale("log")
    top = max(one.flow for one in rolling.passes)
    axes.set_ylim(least / 100, 3 * max(top, least))
    axes.set_ylabel("plastic strain by the pass", fontsize=LABEL)


def heights(rolling: Rolling) -> Figure:
    """Draw the heights of the rough body before the passes and after them.

    Parameters
    ----------
    rolling : Rolling
        The passes.

    Returns
    -------
    Figure
        Along x and y through the deepest residual displacement.
    """
    from matplotlib.figure import Figure

    result = rolling.result
    before, after = result.solution.surface, rolling.rolled_surface
    figure = Figure(figsize=(10.8, 6.4), dpi=DPI, layout=layout())
    grid = figure.subplots(2, 1, sharey=True)
    sunk = result.residual_displacement
    row, column = np.unravel_index(int(sunk.argmax()), sunk.shape)
    level = float(np.nanmean(before.heights))
    lines = {
        "x": (before.heights[row], after.heights[row], "y", (row + 0.5) * before.pixel[0]),
        "y": (before.heights[:, column], after.heights[:, column], "x",
              (column + 0.5) * before.pixel[1]),
    }  # fmt: skip
    top = max(float(np.nanmax(np.abs(v - level))) for old, new, *_ in lines.values()
              for v in (old, new))  # fmt: skip
    factor, unit = prefixed(top, "m")
    for axes, (along, (old, new, other, place)) in zip(grid, lines.items(), strict=True):
        edge = before.pixel[1 if along == "x" else 0]
        where = (np.arange(old.size) + 0.5) * edge
        length, length_unit = prefixed(float(where[-1]), "m")
        axes.plot(where * length, (old - level) * factor, color=NEUTRAL, label="before")
        axes.plot(
            where * length, (new - level) * factor, color=SERIES[0], linewidth=1.8,
            label=f"after {len(rolling.passes)}",
        )  # fmt: skip
        axes.set_xlabel(f"{along} [{length_unit}]", fontsize=LABEL)
        axes.set_ylabel(f"height [{unit}]", fontsize=LABEL)
        axes.set_title(f"at {other} = {engineering(place, 'm', 3)}", fontsize=TICK, loc="left")
        axes.set_xlim(0, float(where[-1] + edge / 2) * length)
        plain_axes(axes)
    shared_legend(figure, grid)
    figure.suptitle(
        f"Heights of the body without load{doubt(result)}, Sq {_sq(rolling)}", fontsize=TITLE
    )
    return figure


def _sq(rolling: Rolling) -> str:
    before, after = (engineering(value, "m", 3) for value in
                     (rolling.result.solution.surface.Sq, rolling.passes[-1].Sq))  # fmt: skip
    return f"{before} before, {after} after"


def depths(rolling: Rolling, body: int = 0) -> Figure:
    """Draw the shear strain that passes add over the depth, and the residual stress after them.

    Parameters
    ----------
    rolling : Rolling
        The passes.
    body : int
        Which of the bodies that yield, the rough one first.

    Returns
    -------
    Figure
        Shear strain towards where the counter-body moved on the first pass; residual stress along
        the pass and across it. A line a pass, the later the darker.
    """
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    faces = np.append(0.0, np.cumsum(rolling.result.bodies[body].thickness))
    figure = Figure(figsize=(10.8, 5.8), dpi=DPI, layout=layout())
    grid = figure.subplots(1, 3, sharey=True)
    length, length_unit = prefixed(float(faces[-1]), "m")
    for axes, key, name, unit in (
        (grid[0], "shear", "shear strain by the pass [%]", ""),
        (grid[1], "residual_along", "residual stress along the pass", "Pa"),
        (grid[2], "residual_across", "residual stress across the pass", "Pa"),
    ):
        profiles = [getattr(one, key)[body] for one in rolling.passes]
        factor, shown = 100.0, ""
        if unit:
            factor, prefix = prefixed(max(float(np.abs(p).max()) for p in profiles), unit)
            shown = f" [{prefix}]"
        for number, colour in _chosen(len(profiles)):
            values = profiles[number]
            axes.stairs(
                values * factor, faces[: values.size + 1] * length, orientation="horizontal",
                baseline=None, color=colour, linewidth=1.8, label=f"pass {number + 1}",
            )  # fmt: skip
        axes.axvline(0, color="#000000", linewidth=0.9)
        axes.set_xlabel(f"{name}{shown}", fontsize=LABEL)
        plain_axes(axes)
        axes.xaxis.set_major_locator(MaxNLocator(5))
    grid[0].set_ylabel(f"depth [{length_unit}]", fontsize=LABEL)
    grid[0].set_ylim(_shown(rolling, body, faces) * length, 0)
    shared_legend(figure, grid)
    figure.suptitle(_over_depth(rolling), fontsize=TITLE)
    return figure


def _shown(rolling: Rolling, body: int, faces: Array) -> float:
    """Return how deep to draw [m]: somewhat below where values have died out."""
    deepest = 0
    for key in ("shear", "residual_along", "residual_across"):
        values = np.abs(getattr(rolling.passes[-1 if "res" in key else 0], key)[body])
        held = np.flatnonzero(values > _LEAST * values.max(initial=0.0))
        deepest = max(deepest, int(held.max(initial=0)) + 1)
    return min(_MORE * float(faces[deepest]), float(faces[-1]))


def _chosen(count: int) -> Sequence[tuple[int, Any]]:
    """Return some passes, the first and the last among them, with their colours."""
    from matplotlib import colormaps

    numbers = np.unique(np.geomspace(1, count, min(count, _LINES)).round().astype(int)) - 1
    shades = np.linspace(_LIGHTEST, 1, numbers.size) if numbers.size > 1 else [1.0]
    return [(int(n), colormaps["Blues"](shade)) for n, shade in zip(numbers, shades, strict=True)]


def _over_depth(rolling: Rolling) -> str:
    periodic = len(rolling.result.solution.boundary.periodic_axes) == 2
    return f"{'Means' if periodic else 'Largest values'} of each layer{doubt(rolling.result)}"


def _counted(rolling: Rolling) -> str:
    count = len(rolling.passes)
    return f"{count} {'pass' if count == 1 else 'passes'}{doubt(rolling.result)}"
