"""Figures of tangential loading and of fretting."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from roughcontact.drawing import style
from roughcontact.errors import InputError
from roughcontact.units import format_percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from roughcontact.analyses.tangential.model import Tangential


# Colors of sticking and slipping contact.
_STICK, _SLIP = style.ELASTIC, style.SATURATED


def tangential(result: Tangential) -> Figure:
    """Draw traction, stick and slip, and the force over the shift.

    Parameters
    ----------
    result : Tangential
        A tangentially loaded contact.

    Returns
    -------
    Figure
        Maps of the traction and of stick and slip (for a profile, the traction and its bound along
        x); and force over shift: the steps, the curve by superposition, and its loop (Masing). A
        cell of several points shows the largest traction, and the shares of stick and slip.
    """
    pair = result.solution.pair
    aspect = 0.8 if pair.is_profile else style.shown_aspect(pair.size)
    panels = 2 if pair.is_profile else 3
    figure = style.empty_figure(5.2 * panels, max(1.6 + 3.6 * aspect, 4.4))
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
    blocks = style.cell_size(shape, size, style.CELLS_IN_PANEL)
    values = style.cell_max(np.hypot(*result.traction), blocks)
    factor, unit = style.axis_unit(float(values.max()), "Pa")
    image = style.draw_map(axes, np.where(values > 0, values * factor, np.nan), size, blocks, shape)
    image.set_cmap(colormaps["viridis_r"].with_extremes(bad=style.OPEN))
    style.colour_bar(axes, image, f"traction [{unit}]", "neither")
    style.name_axes(axes, title="Tangential traction")


def _draw_stick(axes: Axes, result: Tangential) -> None:
    size, shape = result.solution.pair.size, result.bound.shape
    blocks = style.cell_size(shape, size, style.CELLS_IN_PANEL)
    shares = [
        (_STICK, style.cell_share(result.stick, blocks)),
        (_SLIP, style.cell_share((result.bound > 0) & ~result.stick, blocks)),
    ]
    style.draw_map(axes, style.mix_colors(shares, style.OPEN), size, blocks, shape)
    style.patch_legend(axes, [(_STICK, "stick"), (_SLIP, "slip"), (style.OPEN, "no contact")])
    style.name_axes(
        axes, title=f"{format_percent(result.last.stick_fraction)} of the contact sticks"
    )


def _draw_profile(axes: Axes, result: Tangential) -> None:
    x = (np.arange(result.bound.size) + 0.5) * result.solution.pair.pixel[1]
    length, name = style.axis_unit(float(x[-1]), "m")
    factor, unit = style.axis_unit(float(result.bound.max()), "Pa")
    axes.plot(
        x * length, result.bound[0] * factor, ":", color=style.SERIES[1], label="largest traction"
    )
    axes.plot(x * length, result.traction[1, 0] * factor, color=style.SERIES[0], label="traction")
    style.plain_axes(axes, f"x [{name}]", f"traction [{unit}]", "Tangential traction")
    style.legend_below(axes)


def _draw_curve(axes: Axes, result: Tangential) -> None:
    shift = np.array([0.0, *result.column("shift")])
    force = np.array([0.0, *result.column("force")])
    length, name = style.axis_unit(float(abs(shift).max()), "m")
    factor, unit = style.axis_unit(float(abs(force).max()), result.solution.pair.load_unit)
    curve = result.superposition
    if curve is not None:
        points = np.array(curve.shift) * length, np.array(curve.force) * factor
        # Interpolate with a polynomial, as the curve is smooth.
        through = np.polynomial.Polynomial.fit(*points, points[0].size - 1)
        along = np.linspace(0, points[0][-1], 50)
        up = through(along)
        sign = np.sign(result.last.force)
        axes.plot(sign * along, sign * up, color=style.SERIES[0], label="superposition")
        # Masing: the branches of the loop are the curve at twice its size, from both ends.
        for end in (1, -1):
            axes.plot(
                end * (along[-1] - 2 * along),
                end * (up[-1] - 2 * up),
                "--",
                color=style.SERIES[2],
                label="cycle" if end == 1 else None,
            )
    axes.plot(shift * length, force * factor, "o", color=style.SERIES[1], label="solved")
    reach = 1.1 * float(abs(shift).max()) * length
    initial = np.array([0.0, abs(force).max()]) / (result.initial_stiffness or 1.0)
    axes.plot(
        np.sign(result.last.force) * initial * length,
        np.sign(result.last.force) * np.array([0.0, abs(force).max()]) * factor,
        ":",
        color=style.SERIES[6],
        label="full stick",
    )
    axes.set_xlim(-reach, reach)
    style.plain_axes(axes, f"shift [{name}]", f"tangential force [{unit}]", "Force over shift")
    style.legend_below(axes, 2)


def fretting(result: Tangential) -> Figure:
    """Draw the tension at the surface and Ruiz' parameter.

    Parameters
    ----------
    result : Tangential
        A tangentially loaded contact with its stress.

    Returns
    -------
    Figure
        Maps of both, or lines for a profile. A cell of several points shows its largest value.

    Raises
    ------
    InputError
        If the result has no stress.
    """
    if result.fretting is None:
        raise InputError("the result has no stress: compute it with stress=True")
    pair, loaded = result.solution.pair, result.bound > 0
    tension = np.maximum(result.fretting.tension, 0)
    panels = (
        ("Tension at the surface", tension, *style.axis_unit(float(tension.max()), "Pa")),
        ("Ruiz' parameter", np.where(loaded, result.fretting.ruiz, np.nan), 1e-9, "MPa²·mm"),
    )
    aspect = 0.8 if pair.is_profile else style.shown_aspect(pair.size)
    figure = style.empty_figure(10.4, max(1.6 + 3.6 * aspect, 4.4))
    for axes, (title, field, factor, unit) in zip(figure.subplots(1, 2), panels, strict=True):
        if pair.is_profile:
            x = (np.arange(field.size) + 0.5) * pair.pixel[1]
            length, name = style.axis_unit(float(x[-1]), "m")
            axes.plot(x * length, field[0] * factor, color=style.SERIES[0])
            style.plain_axes(axes, f"x [{name}]", f"[{unit}]", title)
            continue
        blocks = style.cell_size(field.shape, pair.size, style.CELLS_IN_PANEL)
        cells = style.cell_max(np.nan_to_num(field, nan=-1.0), blocks) * factor
        values = np.where(cells < 0, np.nan, cells)
        image = style.draw_map(axes, values, pair.size, blocks, field.shape)
        image.set_cmap(style.field_colours().with_extremes(bad=style.OPEN))
        style.colour_bar(axes, image, f"[{unit}]", "neither")
        style.name_axes(axes, title=title)
    return figure
