"""Figures of a comparison: load curves, quantities, and the required area of a map."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from roughcontact._tools import statistics
from roughcontact.analyses.compare.fields import name_of, scale_of
from roughcontact.analyses.compare.model import Comparison, rows_by_ceiling
from roughcontact.analyses.compare.sampling import CONTACT, WANTED, SamplingStudy
from roughcontact.drawing import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

_COLUMNS = 3
_PANEL = (3.6, 3.1)
_SHOWN = (*CONTACT, "Sq", "Ssk", "Sdq", "Spk")
"""Quantities with a panel; tables list all quantities."""


def overview(comparison: Comparison) -> Figure:
    """Draw load curves and quantities of all groups; see `curves` and `numbers`."""
    followed = comparison.curves if len(comparison.pressures) > 1 else ()
    return _figure(comparison, followed, _drawn_names(comparison))


def curves(comparison: Comparison) -> Figure:
    """Draw the load curves of all maps over each other.

    Parameters
    ----------
    comparison : Comparison
        Comparison under several pressures.

    Returns
    -------
    Figure
        Quantities over the nominal pressure: each map a thin line, the mean of a group a thick
        line with the band of its interval.
    """
    return _figure(comparison, comparison.curves, ())


def numbers(comparison: Comparison) -> Figure:
    """Draw the quantities of all maps under the last pressure; parameters as for `curves`.

    Returns
    -------
    Figure
        One panel per quantity: each map a dot, the mean of a group a line with its interval.
    """
    return _figure(comparison, (), _drawn_names(comparison))


def _drawn_names(comparison: Comparison) -> Sequence[str]:
    return [name for name in comparison.names if name in _SHOWN]


def _figure(comparison: Comparison, followed: Sequence[str], compared: Sequence[str]) -> Figure:
    columns = 2 if followed and not compared else _COLUMNS
    cases = rows_by_ceiling(comparison)
    panels = [(_draw_curves, case) for case in cases if case[0] in followed]
    panels += [(_draw_numbers, case) for case in cases if case[0] in compared]
    rows = math.ceil(len(panels) / columns)
    width = _PANEL[0] * (1.45 if columns == 2 else 1.0)
    figure, grid = style.panels(
        columns * width, rows * _PANEL[1] + 0.5, rows, columns, squeeze=False
    )
    free = iter(grid.ravel())
    for draw, (name, ceiling, case) in panels:
        draw(next(free), case, name, name_of(name, ceiling))
    for axes in free:
        axes.set_axis_off()
    if len(comparison.groups) > 1 and followed:
        style.shared_legend(figure, grid)
    return figure


def _draw_curves(axes: Axes, comparison: Comparison, name: str, title: str) -> None:
    pressures = np.array(comparison.pressures)
    across, pressure_unit = style.axis_unit(float(pressures[-1]), "Pa")
    values = [sample.over_pressure(name) for sample in comparison.samples]
    up, symbol = scale_of(name, float(np.max(values)))
    for index, group in enumerate(comparison.groups):
        colour = style.SERIES[index % len(style.SERIES)]
        for sample in group.samples:
            own = np.array(sample.over_pressure(name))
            axes.plot(pressures * across, own * up, color=colour, lw=0.7, alpha=0.6)
        result = comparison.curve(index, name)
        middle = np.array([item.value for item in result])
        axes.plot(pressures * across, middle * up, color=colour, lw=2.2, label=group.name or None)
        low, high = (np.array([getattr(item, end) for item in result]) for end in ("low", "high"))
        if np.isfinite(low).all():
            axes.fill_between(
                pressures * across, low * up, high * up, color=colour, alpha=0.2, lw=0
            )
    style.log_scale(axes, "x")
    _plain_ticks(axes.xaxis, between=False)
    axes.set_ylim(0, 1.08 * float(np.max(values)) * up or 1)
    style.name_axes(axes, f"nominal pressure [{pressure_unit}]")
    _set_title(axes, title, symbol)


def _draw_numbers(axes: Axes, comparison: Comparison, name: str, title: str) -> None:
    values = [np.array(group.values(name)) for group in comparison.groups]
    up, symbol = scale_of(name, float(max(np.abs(own).max() for own in values)))
    if comparison.paired:
        pairs = [
            [sample.numbers[name] * up for sample in group.samples] for group in comparison.groups
        ]
        axes.plot([0, 1], pairs, color=style.NEUTRAL, lw=0.7, alpha=0.6)
    for index, own in enumerate(values):
        colour = style.SERIES[index % len(style.SERIES)]
        result = comparison.mean(index, name)
        # Side by side, so that equal values are visible.
        places = index + np.linspace(-0.14, 0.14, own.size) if own.size > 1 else np.array([index])
        if comparison.paired:
            places = np.full(own.size, index)
        axes.plot(places, own * up, "o", color=colour, ms=3.5, alpha=0.7)
        axes.plot([index - 0.26, index + 0.26], [result.value * up] * 2, color=colour, lw=2.2)
        if not math.isnan(result.low):
            axes.errorbar(
                index + 0.3,
                result.value * up,
                (result.high - result.value) * up,
                color=colour,
                capsize=3,
                lw=1.6,
            )
    _limit(axes, comparison, name, values, up)
    names = [
        group.name if len(group.name) <= 14 else f"{group.name[:13]}…"
        for group in comparison.groups
    ]
    axes.set_xlim(-0.6, len(values) - 0.4)
    axes.set_xticks(range(len(values)), names)
    _set_title(axes, title, symbol)


def _set_title(axes: Axes, title: str, symbol: str) -> None:
    style.plain_axes(axes, title=f"{title} [{symbol}]" if symbol else title)


_ROUNDING = 1e-9


def _limit(axes: Axes, comparison: Comparison, name: str, values: Sequence[Any], up: float) -> None:
    """Set axis limits at which the maps stay visible next to a much wider interval."""
    every = np.concatenate(values)
    ends = [comparison.mean(index, name) for index in range(len(values))]
    reach = [x for item in ends for x in (item.low, item.high) if not math.isnan(x)]
    low, high = float(min([*every, *reach])), float(max([*every, *reach]))
    # Identical maps differ by rounding.
    scale = abs(high) or 1.0
    spread = float(np.ptp(every)) if np.ptp(every) > _ROUNDING * scale else scale
    low = max(low, float(every.min()) - 1.5 * spread)
    high = min(high, float(every.max()) + 1.5 * spread)
    margin = 0.08 * (high - low if high - low > _ROUNDING * scale else scale)
    axes.set_ylim((low - margin) * up, (high + margin) * up)


def sampling(study: SamplingStudy) -> Figure:
    """Draw the sampling error of a map over its size.

    Parameters
    ----------
    study : SamplingStudy
        The parts of a map.

    Returns
    -------
    Figure
        Errors over the side of a square: the interval of a single part of each size (dots), and
        the line through the interval of the whole map, which falls with the root of the area,
        down to 5 %.
    """
    figure, axes = style.panels(7.2, 5.2)
    side = math.sqrt(study.whole.curve.nominal_area)
    sizes = np.array([side / divisions for divisions in study.levels])
    factor, unit = style.axis_unit(side, "m")
    ends = [float(sizes.min()), side]
    for index, item in enumerate(study.errors):
        colour = style.SERIES[index % len(style.SERIES)]
        parts = [study.values(divisions, item.name) for divisions in study.levels]
        halves = [statistics.prediction_half_width(values) / abs(item.value) for values in parts]
        axes.plot(sizes * factor, np.array(halves) * 100, "o", color=colour, ms=5)
        needed = math.sqrt(item.area)
        ends = [min(ends[0], needed), max(ends[1], needed)]
        line = np.array([min(side / math.sqrt(item.parts), needed), max(side, needed)])
        axes.plot(
            line * factor,
            100 * item.relative * side / line,
            color=colour,
            lw=1.6,
            label=name_of(item.name),
        )
        axes.plot(side * factor, 100 * item.relative, "s", color=colour, ms=7)
    axes.axhline(100 * WANTED, color=style.NEUTRAL, lw=1.0, ls="--")
    axes.axvline(side * factor, color=style.NEUTRAL, lw=1.0, ls=":")
    style.log_scale(axes, "x")
    style.log_scale(axes, "y")
    _plain_ticks(axes.xaxis)
    _plain_ticks(axes.yaxis)
    style.plain_axes(
        axes,
        f"side of a square [{unit}]; dotted: this map",
        f"half of the {100 * statistics.LEVEL:.0f} % interval [%]",
    )
    axes.tick_params(which="minor", labelsize=style.TICK - 2)
    style.plain_legend(axes)
    return figure


def _plain_ticks(axis: Axis, between: bool = True) -> None:
    """Write numbers in full; between powers of ten only if the axis spans few."""
    from matplotlib.ticker import LogFormatter, NullFormatter

    axis.set_major_formatter(LogFormatter())
    few = LogFormatter(minor_thresholds=(2.0, 0.5))
    axis.set_minor_formatter(few if between else NullFormatter())
