"""Figure of the load curve of a profile."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from roughcontact.analyses.sweep.model import LoadCurve
from roughcontact.drawing import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
    figure, grid = style.panels(11.0, 8.6, 2, 2)
    load = curve.column("load")
    factor, unit = style.prefixed(float(load.max()), "N/m")
    for key, name, colour in (
        ("contact_area", "contact", style.SERIES[0]),
        ("saturated_area", "saturated", style.SATURATED),
    ):
        share = 100 * curve.column(key) / curve.nominal_area
        share[share == 0] = np.nan
        if np.isfinite(share).any():
            grid[0, 0].plot(load * factor, share, "o-", color=colour, label=name)
    style.log_scale(grid[0, 0], "y")
    scale, length_unit = style.prefixed(
        float(max(curve.column("approach").max(), curve.column("mean_gap").max())), "m"
    )
    for key, name, colour in (
        ("approach", "approach", style.SERIES[0]),
        ("mean_gap", "mean gap", style.SERIES[1]),
    ):
        grid[0, 1].plot(load * factor, curve.column(key) * scale, "o-", color=colour, label=name)
    stiffness = curve.column("stiffness")
    stiffness[~(np.isfinite(stiffness) & (stiffness > 0))] = np.nan
    grid[1, 0].plot(load * factor, stiffness, "o-", color=style.SERIES[0])
    if np.isfinite(stiffness).any():
        style.log_scale(grid[1, 0], "y")
    grid[1, 1].plot(load * factor, curve.column("spots"), "o-", color=style.SERIES[0])
    grid[1, 1].set_ylim(bottom=0)
    for axes, title, label in zip(
        grid.ravel(),
        ("Contact length", "Approach and mean open gap", "Contact stiffness", "Contact segments"),
        (
            "share of the profile [%]",
            f"approach, mean gap [{length_unit}]",
            "stiffness dW′/dω [N/m/m]",
            "number of segments",
        ),
        strict=True,
    ):
        style.log_scale(axes, "x")
        style.plain_axes(axes, f"load per length [{unit}]", label, title)
    for axes in grid[0]:
        style.plain_legend(axes)
    return figure
