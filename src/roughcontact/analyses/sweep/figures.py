"""Figure of a load curve."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from roughcontact._tools.arrays import Array
from roughcontact.analyses.sweep.model import LoadCurve
from roughcontact.drawing import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


Line = tuple[Array, str, Any, str]


def load_curve(curve: LoadCurve, over_pressure: bool = False) -> Figure:
    """Draw a load curve: areas, approach and mean gap, stiffness, and number of spots.

    Parameters
    ----------
    curve : LoadCurve
        The solved loads; of profiles, per length.
    over_pressure : bool, optional
        Whether the axis of maps shows the nominal pressure instead of the load.

    Returns
    -------
    Figure
        Four panels over the load. The areas of maps are compared with Persson's theory and simple
        laws: the line A = κ W/(E* h') through the low loads, see `LoadCurve.low_load_slope`, or
        load over ceiling, if a ceiling is reached.
    """
    figure, grid = style.panels(11.0, 9.4, 2, 2)
    name, symbol, unit, spots = ("load", "W", "N", "spots")
    if curve.is_profile:
        name, symbol, unit, spots = ("load per length", "W′", "N/m", "segments")
    load, size, shown = curve.column("load"), 1.0, unit
    if over_pressure and not curve.is_profile:
        name, size, shown = "nominal pressure", curve.nominal_area, "Pa"
    factor, load_unit = style.axis_unit(float(load.max()) / size, shown)
    factor /= size
    _draw_areas(grid[0, 0], curve, factor)
    lengths = {
        "approach": (curve.column("approach"), style.SERIES[0], "o-"),
        "mean gap": (curve.column("mean_gap"), style.SERIES[1], "s-"),
    }
    longest = max(float(values.max()) for values, *_ in lengths.values())
    scale, length_unit = style.axis_unit(longest, "m")
    for label, (values, colour, marker) in lengths.items():
        grid[0, 1].plot(load * factor, values * scale, marker, color=colour, label=label)
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
    style.name_axes(grid[1, 0], y=f"stiffness d{symbol}/dω [{unit}/m]", title="Contact stiffness")
    number = curve.column("spots")
    grid[1, 1].plot(load * factor, number, "o-", color=style.SERIES[0])
    grid[1, 1].set_ylim(0, 1.1 * max(float(number.max()), 1.0))
    style.name_axes(grid[1, 1], y=f"number of contact {spots}", title=f"Contact {spots}")
    for axes in grid.ravel():
        style.log_scale(axes, "x")
        style.plain_axes(axes, f"{name} [{load_unit}]")
    for axes in grid[0]:
        style.plain_legend(axes)
    return figure


def _theory(curve: LoadCurve) -> list[Line]:
    """Return the laws and the theory of the contact area of maps."""
    if curve.is_profile:
        return []
    load, slope, (contact, saturated) = curve.column("load"), curve.low_load_slope, curve.persson
    # The linear law is for elastic contact; the area of saturated contact is load over ceiling.
    law = slope * load / (curve.contact_modulus * curve.rms_gradient)
    low = curve.low_loads.any()
    lines: list[Line] = [(law, "--", style.NEUTRAL, f"κ W/(E* h′), κ = {slope:.2f}")] if low else []
    if isinstance(curve.ceiling, float) and curve.column("saturated_area").any():
        lines.append((load / curve.ceiling, ":", style.NEUTRAL, "load / ceiling"))
    return [
        *lines,
        (contact, "--", style.SERIES[5], "contact, Persson"),
        (saturated, "--", style.SERIES[3], "saturated, Persson"),
    ]


def _draw_areas(axes: Axes, curve: LoadCurve, factor: float) -> None:
    contact, saturated = curve.column("contact_area"), curve.column("saturated_area")
    lines = [
        *_theory(curve),
        (contact, "o-", style.SERIES[0], "contact"),
        (saturated, "s-", style.SATURATED, "saturated"),
    ]
    computed = 100 * np.concatenate([contact, saturated]) / curve.nominal_area
    computed = computed[computed > 0]
    # Axis limits from the computed points, as theory has area shares down to 1e-300.
    lowest = 0.5 * float(computed.min(initial=100.0))
    for values, marker, colour, name in lines:
        share = 100 * values / curve.nominal_area
        share[~((share > 0) & (share <= 100 * (1 + 1e-9)))] = np.nan
        if (share >= lowest).any():
            axes.plot(curve.column("load") * factor, share, marker, color=colour, label=name)
    style.log_scale(axes, "y")
    if computed.size:
        axes.set_ylim(lowest, min(2.5 * float(computed.max()), 150.0))
    whole, extent = ("profile", "length") if curve.is_profile else ("map", "area")
    style.name_axes(axes, y=f"share of the {whole} [%]", title=f"Contact and saturated {extent}")
