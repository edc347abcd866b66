"""Figure of a load curve."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from roughcontact.analyses.sweep.model import LoadCurve
from roughcontact.drawing import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def load_curve(curve: LoadCurve) -> Figure:
    """Draw a load curve: areas, approach and mean gap, stiffness, and number of spots.

    Parameters
    ----------
    curve : LoadCurve
        The solved loads.

    Returns
    -------
    Figure
        Four panels over the load. The areas are compared with Persson's theory and simple laws:
        the line A = κ W/(E* h') through the low loads, see `LoadCurve.low_load_slope`, or load
        over ceiling, if a ceiling is reached.
    """
    figure, grid = style.panels(11.0, 9.4, 2, 2)
    load = curve.column("load")
    factor, unit = style.prefixed(float(load.max()), "N")
    _draw_areas(grid[0, 0], curve, factor)
    lengths = {
        "approach": (curve.column("approach"), style.SERIES[0], "o-"),
        "mean gap": (curve.column("mean_gap"), style.SERIES[1], "s-"),
    }
    longest = max(float(values.max()) for values, *_ in lengths.values())
    scale, length_unit = style.prefixed(longest, "m")
    for name, (values, colour, marker) in lengths.items():
        grid[0, 1].plot(load * factor, values * scale, marker, color=colour, label=name)
    grid[0, 1].set_ylim(0, 1.08 * (longest or 1.0) * scale)
    style.name_axes(
        grid[0, 1], y=f"approach, mean gap [{length_unit}]", title="Approach and mean open gap"
    )
    stiffness = curve.column("stiffness")
    # Fully saturated contact has zero stiffness, full periodic contact an infinite one.
    stiffness[~(np.isfinite(stiffness) & (stiffness > 0))] = np.nan
    grid[1, 0].plot(load * factor, stiffness, "o-", color=style.SERIES[0])
    if np.isfinite(stiffness).any():
        style.log_scale(grid[1, 0], "y")
    style.name_axes(grid[1, 0], y="stiffness dW/dω [N/m]", title="Contact stiffness")
    number = curve.column("spots")
    grid[1, 1].plot(load * factor, number, "o-", color=style.SERIES[0])
    grid[1, 1].set_ylim(0, 1.1 * max(float(number.max()), 1.0))
    style.name_axes(grid[1, 1], y="number of contact spots", title="Contact spots")
    for axes in grid.ravel():
        style.log_scale(axes, "x")
        style.plain_axes(axes, f"load [{unit}]")
    for axes in grid[0]:
        style.plain_legend(axes)
    return figure


def _draw_areas(axes: Axes, curve: LoadCurve, factor: float) -> None:
    load, nominal, slope = curve.column("load"), curve.nominal_area, curve.low_load_slope
    contact, saturated = curve.column("contact_area"), curve.column("saturated_area")
    contact_theory, saturated_theory = curve.persson
    # The linear law is for elastic contact; the area of saturated contact is load over ceiling.
    law = slope * load / (curve.contact_modulus * curve.rms_gradient)
    low = curve.low_loads.any()
    lines = [(law, "--", style.NEUTRAL, f"κ W/(E* h′), κ = {slope:.2f}")] if low else []
    if isinstance(curve.ceiling, float) and saturated.any():
        lines.append((load / curve.ceiling, ":", style.NEUTRAL, "load / ceiling"))
    lines += [
        (contact_theory, "--", style.SERIES[5], "contact, Persson"),
        (saturated_theory, "--", style.SERIES[3], "saturated, Persson"),
        (contact, "o-", style.SERIES[0], "contact"),
        (saturated, "s-", style.SATURATED, "saturated"),
    ]
    computed = 100 * np.concatenate([contact, saturated]) / nominal
    computed = computed[computed > 0]
    # Axis limits from the computed points, as theory has area shares down to 1e-300.
    lowest = 0.5 * float(computed.min(initial=100.0))
    for values, marker, colour, name in lines:
        share = 100 * values / nominal
        share[~((share > 0) & (share <= 100 * (1 + 1e-9)))] = np.nan
        if (share >= lowest).any():
            axes.plot(load * factor, share, marker, color=colour, label=name)
    style.log_scale(axes, "y")
    if computed.size:
        axes.set_ylim(lowest, min(2.5 * float(computed.max()), 150.0))
    style.name_axes(axes, y="share of the map [%]", title="Contact and saturated area")
