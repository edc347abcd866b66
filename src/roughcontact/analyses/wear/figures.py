"""Figure of running-in."""

from __future__ import annotations

from typing import TYPE_CHECKING

from roughcontact.analyses.wear.model import Wear
from roughcontact.drawing import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def running_in(result: Wear) -> Figure:
    """Draw contact, pressure and roughness over the mean wear depth.

    Parameters
    ----------
    result : Wear
        A worn contact.

    Returns
    -------
    Figure
        Four panels over the mean wear depth: contact, pressure, roughness, and skewness. Dotted
        lines are the values before wear.
    """
    figure, grid = style.panels(11.0, 9.4, 2, 2)
    wear, last = result.column("wear")[1:], result.last
    factor, unit = style.axis_unit(float(wear[-1]), "m")
    scale, pascal = style.axis_unit(float(result.column("max_pressure").max()), "Pa")
    height, meter = style.axis_unit(float(result.column("Sq").max()), "m")
    panels: tuple[tuple[str, float, dict[str, str]], ...] = (
        ("contact [%]", 100 / last.touchable_area, {"contact_area": ""}),
        (f"pressure [{pascal}]", scale, {"max_pressure": "largest", "mean_pressure": "mean"}),
        (f"height [{meter}]", height, {"Sq": "Sq", "Spk": "Spk", "mean_gap": "mean gap"}),
        ("skewness Ssk", 1.0, {"Ssk": ""}),
    )
    for axes, (label, times, lines) in zip(grid.ravel(), panels, strict=True):
        for colour, (key, name) in zip(style.SERIES, lines.items(), strict=False):
            before, *values = times * result.column(key)
            axes.axhline(before, color=colour, lw=1.0, ls=":")
            axes.plot(wear * factor, values, "o-", color=colour, ms=4, label=name)
        style.log_scale(axes, "x")
        style.plain_axes(axes, f"mean wear depth [{unit}]", label)
        if len(lines) > 1:
            style.plain_legend(axes)
    style.log_scale(grid[0, 1], "y")
    return figure
