"""Figure of the law of an interface."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from roughcontact._tools.arrays import Array
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
    return style.prefixed(float(law.pressures()[-1]), "Pa")


def _draw_separation(axes: Axes, law: InterfaceLaw) -> None:
    factor, unit = _pressure(law)
    scale, length = style.prefixed(max(abs(item.first_touch) for item in law.maps), "m")
    for branch in law.branches:
        colour = _COLOURS[branch]
        if len(law.maps) > 1:
            for item in law.maps:
                own = item.column(branch, "separation"), item.column(branch, "pressure")
                axes.plot(own[0] * scale, own[1] * factor, color=colour, linewidth=0.7, alpha=0.5)
        p, u = law.curve(branch).fine()
        axes.plot(u * scale, p * factor, color=colour, linewidth=2, label=_NAMES[branch])
        pressures = law.pressures(branch)
        separation = law.values(branch, "separation").mean(axis=0)
        axes.plot(separation * scale, pressures * factor, "o", color=colour, markersize=4)
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
            span(first * factor, last * factor, color=style.NEUTRAL, alpha=0.12, linewidth=0)


def _line(
    axes: Axes, law: InterfaceLaw, branch: str, name: str, scale: float, **look: Any
) -> Array:
    factor, _ = _pressure(law)
    pressures = law.pressures(branch)
    values = law.values(branch, name) * scale
    values[~(np.isfinite(values) & (values > 0))] = np.nan
    if len(law.maps) > 1:
        axes.plot(pressures * factor, values.T, color=look["color"], linewidth=0.7, alpha=0.5)
    mean: Array = values.mean(axis=0)
    axes.plot(pressures * factor, mean, **look)
    return mean


def _draw_areas(axes: Axes, law: InterfaceLaw) -> None:
    _shade(axes.axvspan, law)
    _line(
        axes,
        law,
        LOADING,
        "contact_fraction",
        100,
        color=style.SERIES[0],
        marker="o",
        label="contact",
    )
    if not law.is_elastic:
        _line(
            axes,
            law,
            LOADING,
            "saturated_fraction",
            100,
            color=style.SATURATED,
            marker="s",
            label="saturated",
        )
    if UNLOADING in law.branches:
        _line(
            axes,
            law,
            UNLOADING,
            "contact_fraction",
            100,
            color=style.ELASTIC,
            marker="o",
            label="contact, unloading",
        )
    style.log_scale(axes, "y")
    style.name_axes(axes, y="share of the area [%]", title="Contact and saturated area")


def _draw_stiffness(axes: Axes, law: InterfaceLaw) -> None:
    factor, _ = _pressure(law)
    _shade(axes.axvspan, law)
    scale, unit = 1e-15, "GPa/µm"
    _line(
        axes, law, LOADING, "stiffness", scale, color=style.SERIES[0], marker="o", label="loading"
    )
    if not law.is_elastic:
        _line(
            axes,
            law,
            LOADING,
            "unloading_stiffness",
            scale,
            color=style.SATURATED,
            marker="s",
            label="as the load begins to fall",
        )
    if UNLOADING in law.branches:
        _line(
            axes,
            law,
            UNLOADING,
            "unloading_stiffness",
            scale,
            color=style.ELASTIC,
            marker="o",
            label="unloading, loading again",
        )
    if np.isfinite(law.persson_length):
        line = law.pressures() / law.persson_length * scale
        axes.plot(law.pressures() * factor, line, "--", color=style.NEUTRAL, label="p̄/u₀, Persson")
    style.log_scale(axes, "y")
    style.name_axes(axes, y=f"stiffness per area [{unit}]", title="Stiffness")


def _draw_law_gap(axes: Axes, law: InterfaceLaw) -> None:
    factor, _ = _pressure(law)
    scale, unit = style.prefixed(max(abs(item.first_touch) for item in law.maps), "m")
    _shade(axes.axvspan, law)
    for branch in law.branches:
        own = {LOADING: "", UNLOADING: ", unloading"}[branch]
        pressures = law.pressures(branch) * factor
        for name, marker, label in (
            ("separation", "o-", "separation"),
            ("mean_gap", "s:", "mean gap"),
        ):
            values = law.values(branch, name).mean(axis=0) * scale
            axes.plot(
                pressures, values, marker, color=_COLOURS[branch], markersize=4, label=label + own
            )
        half = np.array([item.high - item.value for item in law.mean(branch, "separation")]) * scale
        if np.isfinite(half).all():
            mean = law.values(branch, "separation").mean(axis=0) * scale
            axes.fill_between(
                pressures, mean - half, mean + half, color=_COLOURS[branch], alpha=0.2, linewidth=0
            )
    style.name_axes(
        axes,
        y=f"separation, mean gap [{unit}]",
        title="Separation of the mean planes and mean open gap",
    )
