"""Figures of profiles: heights, and the profile under load."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from roughcontact.contact.result import ContactResult
from roughcontact.drawing import style
from roughcontact.drawing.sections import draw_lines, line_of
from roughcontact.errors import require_positive
from roughcontact.surface.surface import Surface

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def heights(surface: Surface) -> Figure:
    """Draw the heights of a profile.

    Parameters
    ----------
    surface : Surface
        A profile; the line is interrupted at missing points.

    Returns
    -------
    Figure
        Heights over the position, not to scale: heights are exaggerated.
    """
    z, spacing = surface.heights[0], surface.pixel[1]
    x = spacing * (np.arange(z.size) + 0.5)
    along, unit_along = style.prefixed(surface.size[1], "m")
    up, unit_up = style.prefixed(float(np.nanmax(np.abs(z))), "m")
    figure, axes = style.panels(10.6, 3.8)
    axes.plot(x * along, z * up, color=style.SERIES[0], linewidth=0.9)
    axes.set_xlim(0, surface.size[1] * along)
    style.plain_axes(axes, f"x [{unit_along}]", f"height [{unit_up}]", "Profile")
    return figure


def loaded_profile(
    result: ContactResult, width: float | None = None, middle: int | None = None
) -> Figure:
    """Draw a profile before and under load, and the contact pressure.

    Parameters
    ----------
    result : ContactResult
        A contact of profiles.
    width : float, optional
        Drawn length [m]; by default the whole profile.
    middle : int, optional
        Index of the central point; by default the point of the largest pressure.

    Returns
    -------
    Figure
        Zero height is the counter-body. For two profiles, the sum of their heights is drawn.

    Raises
    ------
    InputError
        If the width is not positive and finite.
    """
    if width is not None:
        require_positive(width=width)
    place = 0, int(np.argmax(result.pressure)) if middle is None else middle
    line = line_of(result, result.initial_gap, place, 1, width or math.inf)
    factor, unit = style.prefixed_window(*line.limits)
    figure, grid = style.panels(
        10.6, 6.8, 2, 1, sharex=True, height_ratios=(1.25, 1), squeeze=False
    )
    draw_lines(result, [line], grid, factor, ticks=8)
    style.name_axes(grid[1, 0], f"x [{unit}]")
    style.shared_legend(
        figure, grid, f"Profile under {style.load_text(result)}{style.doubt_suffix(result)}"
    )
    return figure
