"""Figures of a leakage: flow through the gap, and flow factors."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from roughcontact._tools.arrays import Array
from roughcontact.drawing import maps, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from roughcontact.analyses.leak.flow import Flow
    from roughcontact.analyses.leak.model import Leakage


# Decades of flow density in the figure; smaller flow densities are negligible for the leak rate.
_DECADES = 4


def leak(result: Leakage) -> Figure:
    """Draw the gap under the largest load, and the flow density in it.

    Parameters
    ----------
    result : Leakage
        The leakage.

    Returns
    -------
    Figure
        The open gap with the contact, and the flow density over its mean, over four decades, for
        each direction that percolates. A cross marks the narrowest constriction. A cell of several
        points shows its largest flow density.
    """
    flows = [flow for flow in result.flows if flow.percolates]
    aspect = style.shown_aspect(result.largest.pair.size)
    figure = style.empty_figure(4.9 * (1 + len(flows)), 1.0 + 3.6 * aspect)
    first, *others = figure.subplots(1, 1 + len(flows), squeeze=False)[0]
    _draw_leak(first, result, bool(flows))
    for axes, flow in zip(others, flows, strict=True):
        _draw_flow(axes, result, flow)
    return figure


def flow_factors(result: Leakage) -> Figure:
    """Draw the flow factors over the mean gap, and the narrowest gap over the load.

    Parameters
    ----------
    result : Leakage
        The leakage.

    Returns
    -------
    Figure
        Pressure flow factors φ = k/ū³ over ū/σ; mean gap and narrowest gap over the load.
    """
    figure, (left, right) = style.panels(11.2, 4.6, 1, 2)
    load = result.column("load")
    mean = result.column("mean_gap")
    load_factor, load_unit = style.axis_unit(float(load.max()), "N")
    factor, unit = style.axis_unit(float(mean.max()), "m")
    right.plot(load * load_factor, mean * factor, "k:", label="mean gap")
    for axis in result.axes:
        line, colour = ("o-", "s--")[axis], style.SERIES[axis]
        label = f"along {'yx'[axis]}"
        left.plot(
            result.gap_ratio, _positive(result.flow_factor(axis)), line, color=colour, label=label
        )
        narrow = _positive(result.critical_gap(axis)) * factor
        right.plot(load * load_factor, narrow, line, color=colour, label=f"narrowest, {label}")
    for axes, x, y, title in (
        (left, "mean gap over roughness ū/σ", "flow factor φ", "Pressure-flow factors"),
        (right, f"load [{load_unit}]", f"gap [{unit}]", "Gap at the narrowest place"),
    ):
        if any(np.isfinite(line.get_ydata()).any() for line in axes.lines):
            style.log_scale(axes, "y")
        style.plain_axes(axes, x, y, title)
        style.plain_legend(axes)
    style.log_scale(right, "x")
    return figure


def _positive(values: Array) -> Array:
    return np.where(values > 0, values, np.nan)


def _draw_leak(axes: Axes, answer: Leakage, flows: bool) -> None:
    result = answer.largest
    maps.draw_gap(axes, result, style.CELLS_IN_PANEL)
    for axis in answer.axes:
        _mark(axes, answer, axis)
    more = "" if flows else ", no way through"
    style.name_axes(axes, title=f"Gap and contact at {style.load_text(result)}{more}")


def _draw_flow(axes: Axes, answer: Leakage, flow: Flow) -> None:
    from matplotlib import colormaps
    from matplotlib.colors import LogNorm

    size = answer.largest.surface.size
    blocks = style.cell_size(flow.density.shape, size, style.CELLS_IN_PANEL)
    values = style.cell_max(flow.density.astype(float), blocks) / flow.permeability[flow.axis]
    maximum = float(values.max())
    image = style.draw_map(
        axes, np.maximum(values, maximum * 10.0**-_DECADES), size, blocks, flow.density.shape
    )
    image.set_cmap(colormaps["inferno"])
    image.set_norm(LogNorm(maximum * 10.0**-_DECADES, maximum))
    style.colour_bar(axes, image, "flow density over its mean", "min")
    _mark(axes, answer, flow.axis)
    style.name_axes(axes, title=f"Flow along {'yx'[flow.axis]}")


def _mark(axes: Axes, result: Leakage, axis: int) -> None:
    """Mark the narrowest constriction under the largest load."""
    place = result.steps[-1].constriction[axis]
    if place is None:
        return
    pixel = result.largest.pair.pixel
    factor, _ = style.prefixed_window(0.0, max(result.largest.pair.size))
    y, x = ((index + 0.5) * edge * factor for index, edge in zip(place.place, pixel, strict=True))
    for colour, width in (("white", 3.0), (style.SERIES[1], 1.5)):
        axes.plot([x], [y], "x", color=colour, ms=9, mew=width)
