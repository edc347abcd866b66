"""Figures of profiles: the trace, the profile under load, load curves per length."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from roughcontact.contact.result import ContactResult
from roughcontact.errors import require_positive
from roughcontact.plots.sections import draw_line_pressure, draw_profile, line_of
from roughcontact.plots.style import (
    DPI,
    LABEL,
    SATURATED,
    SERIES,
    TICK,
    TITLE,
    doubt,
    layout,
    load_text,
    plain_axes,
    prefixed,
    prefixed_window,
    shared_legend,
)
from roughcontact.studies.load_curve import LoadCurve
from roughcontact.surface.surface import Surface

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def heights(surface: Surface) -> Figure:
    """Draw the heights of a profile.

    Parameters
    ----------
    surface : Surface
        A profile; where points are missing the line ends.

    Returns
    -------
    Figure
        Heights over the position. They are exaggerated.
    """
    from matplotlib.figure import Figure

    z, spacing = surface.heights[0], surface.pixel[1]
    x = spacing * (np.arange(z.size) + 0.5)
    along, unit_along = prefixed(surface.size[1], "m")
    up, unit_up = prefixed(float(np.nanmax(np.abs(z))), "m")
    figure = Figure(figsize=(10.6, 3.8), dpi=DPI, layout=layout())
    axes = figure.subplots()
    axes.plot(x * along, z * up, color=SERIES[0], linewidth=0.9)
    axes.set_xlim(0, surface.size[1] * along)
    axes.set_xlabel(f"x [{unit_along}]", fontsize=LABEL)
    axes.set_ylabel(f"height [{unit_up}]", fontsize=LABEL)
    axes.set_title("Profile", fontsize=TITLE)
    plain_axes(axes)
    return figure


def pressed(result: ContactResult, width: float | None = None, middle: int | None = None) -> Figure:
    """Draw a profile before and under load, and the pressure on it.

    Parameters
    ----------
    result : ContactResult
        A contact of profiles.
    width : float, optional
        Length that is drawn [m]; by default all of the profile.
    middle : int, optional
        Point in the middle of it; by default that of the largest pressure.

    Returns
    -------
    Figure
        Zero height is the counter-body. Of two profiles it is the sum of their heights.

    Raises
    ------
    InputError
        If the width is not positive and finite.
    """
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    if width is not None:
        require_positive(width=width)
    place = 0, int(np.argmax(result.pressure)) if middle is None else middle
    line = line_of(result, result.initial_gap, place, 1, width or math.inf)
    first, last = line.limits
    factor, unit = prefixed_window(first, last)
    tall = float(np.nanmax(np.abs([line.before, line.under])))
    up, unit_up = prefixed(tall, "m")
    top = float(line.pressure.max())
    if line.ceiling is not None:
        top = max([top, *line.ceiling[line.ceiling <= 2 * top]])
    press, unit_press = prefixed(top, "Pa")
    figure = Figure(figsize=(10.6, 6.8), dpi=DPI, layout=layout())
    grid = figure.subplots(2, 1, sharex=True, height_ratios=(1.25, 1))
    draw_profile(grid[0], line, factor, up)
    draw_line_pressure(grid[1], line, top, factor, press)
    for axes in grid:
        axes.xaxis.set_major_locator(MaxNLocator(8))
        plain_axes(axes)
    what = "height" if result.counter_surface is None else "sum of heights"
    grid[0].set_ylabel(f"{what} [{unit_up}]", fontsize=LABEL)
    grid[1].set_ylabel(f"pressure [{unit_press}]", fontsize=LABEL)
    grid[1].set_ylim(0, 1.08 * (top or 1.0) * press)
    grid[1].set_xlabel(f"x [{unit}]", fontsize=LABEL)
    grid[1].set_xlim(first * factor, last * factor)
    shared_legend(figure, grid)
    figure.suptitle(f"Profile under {load_text(result)}{doubt(result)}", fontsize=TITLE)
    return figure


def load_curve(curve: LoadCurve) -> Figure:
    """Draw a load curve of profiles: contact, approach and mean gap, stiffness, segments.

    Parameters
    ----------
    curve : LoadCurve
        The solved loads per length.

    Returns
    -------
    Figure
        Four panels over the load.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 8.6), dpi=DPI, layout=layout())
    grid = figure.subplots(2, 2)
    load = curve.column("load")
    factor, unit = prefixed(float(load.max()), "N/m")
    for key, name, colour in (
        ("contact_area", "contact", SERIES[0]), ("saturated_area", "saturated", SATURATED)
    ):  # fmt: skip
        share = 100 * curve.column(key) / curve.nominal_area
        share[share == 0] = np.nan
        if np.isfinite(share).any():
            grid[0, 0].plot(load * factor, share, "o-", color=colour, label=name)
    grid[0, 0].set_yscale("log")
    scale, length_unit = prefixed(
        float(max(curve.column("approach").max(), curve.column("mean_gap").max())), "m"
    )
    for key, name, colour in (
        ("approach", "approach", SERIES[0]), ("mean_gap", "mean gap", SERIES[1])
    ):  # fmt: skip
        grid[0, 1].plot(load * factor, curve.column(key) * scale, "o-", color=colour, label=name)
    stiffness = curve.column("stiffness")
    stiffness[~(np.isfinite(stiffness) & (stiffness > 0))] = np.nan
    grid[1, 0].plot(load * factor, stiffness, "o-", color=SERIES[0])
    if np.isfinite(stiffness).any():
        grid[1, 0].set_yscale("log")
    grid[1, 1].plot(load * factor, curve.column("spots"), "o-", color=SERIES[0])
    grid[1, 1].set_ylim(bottom=0)
    for axes, title, label in zip(
        grid.ravel(),
        ("Contact length", "Approach and mean open gap", "Contact stiffness", "Contact segments"),
        (
            "share of the profile [%]", f"approach, mean gap [{length_unit}]",
            "stiffness dW′/dω [N/m/m]", "number of segments",
        ),
        strict=True,
    ):  # fmt: skip
        axes.set_title(title, fontsize=TITLE)
        axes.set_ylabel(label, fontsize=LABEL)
        axes.set_xlabel(f"load per length [{unit}]", fontsize=LABEL)
        axes.set_xscale("log")
        plain_axes(axes)
    for axes in grid[0]:
        axes.legend(fontsize=TICK, frameon=False)
    return figure
