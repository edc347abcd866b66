"""Figures of a tangentially loaded contact: traction, stick and slip, force over shift."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from roughcontact.plots.style import (
    CELLS_IN_PANEL,
    DPI,
    ELASTIC,
    LABEL,
    OPEN,
    SATURATED,
    SERIES,
    TICK,
    TITLE,
    cell_max,
    cell_share,
    cell_size,
    colour_bar,
    draw_map,
    layout,
    legend_below,
    mixed,
    patch_legend,
    plain_axes,
    prefixed,
    shown_aspect,
)
from roughcontact.units import percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from roughcontact.joint.tangential import Tangential

STICK, SLIP = ELASTIC, SATURATED
"""Colours of contact that sticks and that slips."""


def tangential(result: Tangential) -> Figure:
    """Draw traction, stick and slip, and the force over the shift.

    Parameters
    ----------
    result : Tangential
        A tangentially loaded contact.

    Returns
    -------
    Figure
        Maps of the traction and of stick and slip, of a profile the traction and its bound along
        it; and force over shift: the steps, the curve of superposition, and its loop (Masing). A
        cell of several points shows the largest traction, and the shares that stick and slip.
    """
    from matplotlib.figure import Figure

    pair = result.solution.pair
    aspect = 0.8 if pair.is_profile else shown_aspect(pair.size)
    panels = 2 if pair.is_profile else 3
    size = (5.2 * panels, max(1.6 + 3.6 * aspect, 4.4))
    figure = Figure(figsize=size, dpi=DPI, layout=layout())
    first, *middle, last = figure.subplots(1, panels)
    if pair.is_profile:
        _draw_profile(first, result)
    else:
        _draw_traction(first, result)
        _draw_stick(middle[0], result)
    _draw_curve(last, result)
    return figure


def _draw_traction(axes: Axes, result: Tangential) -> None:
    from matplotlib import colormaps

    size, shape = result.solution.pair.size, result.bound.shape
    blocks = cell_size(shape, size, CELLS_IN_PANEL)
    values = cell_max(np.hypot(*result.traction), blocks)
    factor, unit = prefixed(float(values.max()), "Pa")
    image = draw_map(axes, np.where(values > 0, values * factor, np.nan), size, blocks, shape)
    image.set_cmap(colormaps["viridis_r"].with_extremes(bad=OPEN))
    colour_bar(axes, image, f"traction [{unit}]", "neither")
    axes.set_title("Tangential traction", fontsize=TITLE)


def _draw_stick(axes: Axes, result: Tangential) -> None:
    size, shape = result.solution.pair.size, result.bound.shape
    blocks = cell_size(shape, size, CELLS_IN_PANEL)
    slips = (result.bound > 0) & ~result.stick
    shares = [(STICK, cell_share(result.stick, blocks)), (SLIP, cell_share(slips, blocks))]
    draw_map(axes, mixed(shares, OPEN), size, blocks, shape)
    patch_legend(axes, [(STICK, "stick"), (SLIP, "slip"), (OPEN, "no contact")])
    axes.set_title(f"{percent(result.last.stick_fraction)} of the contact sticks", fontsize=TITLE)


def _draw_profile(axes: Axes, result: Tangential) -> None:
    x = (np.arange(result.bound.size) + 0.5) * result.solution.pair.pixel[1]
    length, name = prefixed(float(x[-1]), "m")
    factor, unit = prefixed(float(result.bound.max()), "Pa")
    axes.plot(x * length, result.bound[0] * factor, ":", color=SERIES[1], label="largest traction")
    axes.plot(x * length, result.traction[1, 0] * factor, color=SERIES[0], label="traction")
    axes.set_xlabel(f"x [{name}]", fontsize=LABEL)
    axes.set_ylabel(f"traction [{unit}]", fontsize=LABEL)
    axes.set_title("Tangential traction", fontsize=TITLE)
    plain_axes(axes)
    legend_below(axes)


def _draw_curve(axes: Axes, result: Tangential) -> None:
    shift = np.array([0.0, *result.column("shift")])
    force = np.array([0.0, *result.column("force")])
    length, name = prefixed(float(abs(shift).max()), "m")
    factor, unit = prefixed(float(abs(force).max()), result.solution.pair.load_unit)
    curve = result.superposition
    if curve is not None:
        along, up = np.array(curve.shift) * length, np.array(curve.force) * factor
        sign = np.sign(result.last.force)
        axes.plot(sign * along, sign * up, color=SERIES[0], label="superposition")
        # Masing: the loop is the curve at twice its size, from either end.
        for end in (1, -1):
            label = "cycle" if end == 1 else None
            axes.plot(end * (along[-1] - 2 * along), end * (up[-1] - 2 * up), "--",
                      color=SERIES[2], label=label)  # fmt: skip
    axes.plot(shift * length, force * factor, "o", color=SERIES[1], label="solved")
    reach = 1.1 * float(abs(shift).max()) * length
    initial = np.array([0.0, abs(force).max()]) / (result.initial_stiffness or 1.0)
    axes.plot(np.sign(result.last.force) * initial * length,
              np.sign(result.last.force) * np.array([0.0, abs(force).max()]) * factor,
              ":", color=SERIES[6], label="full stick")  # fmt: skip
    axes.set_xlim(-reach, reach)
    axes.set_xlabel(f"shift [{name}]", fontsize=LABEL)
    axes.set_ylabel(f"tangential force [{unit}]", fontsize=LABEL)
    axes.set_title("Force over shift", fontsize=TITLE)
    plain_axes(axes)
    legend_below(axes, 2)
    axes.tick_params(labelsize=TICK)
