"""Figure of the law of an interface."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from roughcontact.analyses.law.curve import refine_geometrically
from roughcontact.analyses.law.model import LOADING, UNLOADING, InterfaceLaw
from roughcontact.drawing import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


_COLOURS = {LOADING: style.SERIES[0], UNLOADING: style.ELASTIC}


_NAMES = {LOADING: "first loading", UNLOADING: "unloading, loading again"}


def interface_law(law: InterfaceLaw) -> Figure:
    """Draw the law of an interface.

    Parameters
    ----------
    law : InterfaceLaw
        The law.

    Returns
    -------
    Figure
        Pressure over separation, and areas, stiffness and gap over pressure. Thick lines are means
        of the maps, thin lines single maps; Persson's theory of the elastic joint is dashed, and
        pressures that the maps do not resolve are gray.
    """
    figure, grid = style.panels(11.0, 9.4, 2, 2)
    _draw_separation(grid[0, 0], law)
    _draw_areas(grid[0, 1], law)
    _draw_stiffness(grid[1, 0], law)
    _draw_law_gap(grid[1, 1], law)
    factor, unit = _pressure(law)
    for axes in (grid[0, 1], grid[1, 0], grid[1, 1]):
        style.log_scale(axes, "x")
        style.name_axes(axes, f"nominal pressure [{unit}]")
        axes.set_xlim(*(law.pressures()[[0, -1]] * factor * np.array([0.9, 1.1])))
    for axes in grid.ravel():
        style.plain_axes(axes)
        style.plain_legend(axes)
    return figure


def _pressure(law: InterfaceLaw) -> tuple[float, str]:
    return style.axis_unit(float(law.pressures()[-1]), "Pa")


def _draw_separation(axes: Axes, law: InterfaceLaw) -> None:
    factor, unit = _pressure(law)
    scale, length = style.axis_unit(max(abs(item.first_touch) for item in law.maps), "m")
    for branch in law.branches:
        colour = _COLOURS[branch]
        if len(law.maps) > 1:
            for item in law.maps:
                own = item.column(branch, "separation"), item.column(branch, "pressure")
                axes.plot(own[0] * scale, own[1] * factor, color=colour, lw=0.7, alpha=0.5)
        p, u = law.curve(branch).fine()
        axes.plot(u * scale, p * factor, color=colour, lw=2, label=_NAMES[branch])
        pressures = law.pressures(branch)
        separation = law.values(branch, "separation").mean(axis=0)
        axes.plot(separation * scale, pressures * factor, "o", color=colour, ms=4)
    fine = refine_geometrically(law.pressures(), 8)
    theory = law.persson(fine)
    if np.isfinite(theory).all():
        axes.plot(
            theory * scale, fine * factor, "--", color=style.NEUTRAL, label="Persson, elastic"
        )
    _shade(axes.axhspan, law)
    style.log_scale(axes, "y")
    style.name_axes(
        axes,
        f"separation of the mean planes [{length}]",
        f"nominal pressure [{unit}]",
        "Pressure and separation",
    )


def _shade(span: Callable[..., Any], law: InterfaceLaw) -> None:
    factor, _ = _pressure(law)
    low, high = law.pressures()[[0, -1]]
    result = law.resolved
    for first, last in ((low, result.low), (result.high, high)):
        if last > first:
            span(first * factor, last * factor, color=style.NEUTRAL, alpha=0.12, lw=0)


# Field of the points, label, color and marker of a line.
_Line = tuple[str, str, str, str]


def _draw_lines(
    axes: Axes, law: InterfaceLaw, scale: float, loading: _Line, yielding: _Line, unloading: _Line
) -> None:
    """Draw a line of all laws, one of those with saturated points, and one of unloading."""
    _shade(axes.axvspan, law)
    factor, _ = _pressure(law)
    lines = [(LOADING, loading), (LOADING, yielding)][: 1 + (not law.is_elastic)]
    lines += [(UNLOADING, unloading)] if UNLOADING in law.branches else []
    for branch, (name, label, color, marker) in lines:
        pressures = law.pressures(branch) * factor
        values = law.values(branch, name) * scale
        values[~(np.isfinite(values) & (values > 0))] = np.nan
        if len(law.maps) > 1:
            axes.plot(pressures, values.T, color=color, lw=0.7, alpha=0.5)
        axes.plot(pressures, values.mean(axis=0), color=color, marker=marker, label=label)
    style.log_scale(axes, "y")


def _draw_areas(axes: Axes, law: InterfaceLaw) -> None:
    _draw_lines(
        axes,
        law,
        100,
        ("contact_fraction", "contact", style.SERIES[0], "o"),
        ("saturated_fraction", "saturated", style.SATURATED, "s"),
        ("contact_fraction", "contact, unloading", style.ELASTIC, "o"),
    )
    style.name_axes(axes, y="share of the area [%]", title="Contact and saturated area")


def _draw_stiffness(axes: Axes, law: InterfaceLaw) -> None:
    scale, unit = 1e-15, "GPa/µm"
    _draw_lines(
        axes,
        law,
        scale,
        ("stiffness", "loading", style.SERIES[0], "o"),
        ("unloading_stiffness", "as the load begins to fall", style.SATURATED, "s"),
        ("unloading_stiffness", "unloading, loading again", style.ELASTIC, "o"),
    )
    if np.isfinite(law.persson_length):
        pressures = law.pressures()
        factor, _ = _pressure(law)
        line = pressures / law.persson_length * scale
        axes.plot(pressures * factor, line, "--", color=style.NEUTRAL, label="p̄/u₀, Persson")
    style.name_axes(axes, y=f"stiffness per area [{unit}]", title="Stiffness")


def _draw_law_gap(axes: Axes, law: InterfaceLaw) -> None:
    factor, _ = _pressure(law)
    scale, unit = style.axis_unit(max(abs(item.first_touch) for item in law.maps), "m")
    _shade(axes.axvspan, law)
    for branch in law.branches:
        own = {LOADING: "", UNLOADING: ", unloading"}[branch]
        pressures = law.pressures(branch) * factor
        for name, marker, label in (
            ("separation", "o-", "separation"),
            ("mean_gap", "s:", "mean gap"),
        ):
            values = law.values(branch, name).mean(axis=0) * scale
            axes.plot(pressures, values, marker, color=_COLOURS[branch], ms=4, label=label + own)
        half = np.array([item.high - item.value for item in law.mean(branch, "separation")]) * scale
        if np.isfinite(half).all():
            mean = law.values(branch, "separation").mean(axis=0) * scale
            axes.fill_between(
                pressures, mean - half, mean + half, color=_COLOURS[branch], alpha=0.2, lw=0
            )
    style.name_axes(axes, y=f"separation, mean gap [{unit}]", title="Separation and mean open gap")
