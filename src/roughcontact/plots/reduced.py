"""Maps that no process holds as a whole, drawn from blocks of their points."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from roughcontact.plots.cells import gap_limit, height_limits, pressure_colours
from roughcontact.plots.style import (
    MISSING,
    OPEN,
    TITLE,
    colour_bar,
    draw_map,
    listed,
    prefixed,
    single_axes,
)

if TYPE_CHECKING:
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure

Array = NDArray[np.float64]


def figures(
    size: tuple[float, float], heights: Array, pressure: Array, gap: Array
) -> dict[str, Callable[[], Figure]]:
    """Return what draws the reduced maps of a contact, by what they show.

    Parameters
    ----------
    size : (float, float)
        Lengths of the sides (y, x) of the map [m].
    heights, pressure, gap : ndarray
        Mean height [m], largest pressure [Pa] and mean gap [m] of each block of points.
    """
    from matplotlib import colormaps

    heights = heights - np.nanmean(heights)
    low, high, *_ = height_limits(heights)
    top = float(pressure.max()) or 1.0
    viridis = colormaps["viridis"].with_extremes(bad=MISSING)
    open_gap = np.maximum(gap, 0)
    loaded = np.where(pressure > 0, pressure, np.nan)
    colours = listed(pressure_colours()).with_extremes(bad=OPEN)
    draw = partial(_map, size)
    return {
        "Mean height of each block": partial(draw, heights, "height", "m", low, high, viridis),
        "Largest pressure in each block": partial(draw, loaded, "pressure", "Pa", 0, top, colours),
        "Mean gap of each block": partial(
            draw, open_gap, "gap", "m", 0, gap_limit(open_gap), viridis
        ),
    }


def _map(
    size: tuple[float, float],
    values: Array,
    name: str,
    unit: str,
    low: float,
    high: float,
    colours: Colormap,
) -> Figure:
    figure, axes = single_axes(size, legend=False)
    factor, named = prefixed(max(abs(low), abs(high)), unit)
    image = draw_map(axes, values * factor, size, (1, 1), values.shape)
    image.set_cmap(colours)
    image.set_clim(low * factor, high * factor)
    colour_bar(axes, image, f"{name} [{named}]", "neither")
    axes.set_title(name.capitalize(), fontsize=TITLE)
    return figure
