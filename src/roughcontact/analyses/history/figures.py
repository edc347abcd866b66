"""Figure of a load history."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from roughcontact.analyses.history.model import NEGLIGIBLE_GROWTH, LoadHistory
from roughcontact.drawing import style
from roughcontact.units import count_noun

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def hysteresis(history: LoadHistory) -> Figure:
    """Draw load against approach along a history, and the dissipated energy of each step.

    Parameters
    ----------
    history : LoadHistory
        A solved path.

    Returns
    -------
    Figure
        The computed points, joined by curves: elastic ones between points of the same shape and
        position, in another color than new indentation. Below them, the dissipated energy of
        each step and the volume indented so far.
    """
    from matplotlib.ticker import MaxNLocator

    figure, (upper, lower) = style.panels(7.2, 8.6, 2, 1, height_ratios=(1.7, 1.0))
    _draw_loop(upper, history)

    number = np.arange(1, len(history.steps) + 1)
    energy = history.column("dissipated_energy")
    volume = np.cumsum(history.column("indentation_volume"))
    factor, unit = style.axis_unit(float(energy.max()), "J")
    lower.bar(number, energy * factor, width=0.7, color=style.SATURATED)
    style.name_axes(lower, "step")
    lower.set_ylabel(f"dissipated energy [{unit}]", fontsize=style.LABEL, color=style.SATURATED)
    lower.xaxis.set_major_locator(MaxNLocator(integer=True))
    lower.set_xlim(0.3, number[-1] + 0.7)
    lower.set_ylim(0, 1.15 * float(energy.max()) * factor or 1)
    # Cubic micrometers: SI prefixes of m³ are ambiguous.
    total = lower.twinx()
    total.plot(number, volume * 1e18, color=style.SERIES[0], marker="o", ms=4, lw=1.8)
    total.set_ylabel("indented volume so far [µm³]", fontsize=style.LABEL, color=style.SERIES[0])
    total.set_ylim(0, 1.15 * float(volume[-1]) * 1e18 or 1)
    for axes in (lower, total):
        axes.tick_params(labelsize=style.TICK)
        axes.spines["top"].set_visible(False)
    style.name_axes(
        lower,
        title=f"{style.in_unit(history.dissipated_energy, (factor, unit), 'J')} dissipated, "
        + ("shaken down" if history.is_elastic_now else "shakedown not shown"),
    )
    return figure


class State(NamedTuple):
    """Computed point of a path or first touch, with the index of the shape of the bodies."""

    approach: float
    load: float
    shift: tuple[float, float]
    shape: int


def states(history: LoadHistory) -> list[State]:
    """Return the points of a path in order; each new indentation gives a new shape index."""
    indents = history.column("indentation_volume") > NEGLIGIBLE_GROWTH * history.indentation_volume
    result = []
    if not any(history.path[0].shift):
        # First touch at the first position, before the first step.
        result.append(State(0.0, 0.0, history.path[0].shift, 0))
    for step, stage, shape in zip(history.steps, history.path, np.cumsum(indents), strict=True):
        result.append(State(step.approach, step.load, stage.shift, int(shape)))
    return result


def branches(points: list[State]) -> dict[str, list[list[State]]]:
    """Return the curves through the points: elastic branches, and new indentations.

    An elastic branch has the points of one shape at one position; unloading and reloading
    coincide. A new indentation starts at the largest load of the previous shape.
    """
    elastic: dict[tuple[int, tuple[float, float]], list[State]] = {}
    indenting = []
    shape = 0
    for state in points:
        if state.shape > shape:
            before = elastic.get((shape, state.shift))
            shape = state.shape
            if before:
                indenting.append([max(before, key=_by_load), state])
        elastic.setdefault((state.shape, state.shift), []).append(state)
    several = [sorted(branch, key=_by_load) for branch in elastic.values() if len(branch) > 1]
    return {"elastic": several, "new indentation": indenting}


def _by_load(state: State) -> tuple[float, float]:
    return state.load, state.approach


def _draw_loop(axes: Axes, history: LoadHistory) -> None:
    result = states(history)
    approach, load = (
        np.array([getattr(state, name) for state in result]) for name in ("approach", "load")
    )
    across, unit_across = style.axis_unit(float(np.abs(approach).max()), "m")
    up, unit_up = style.axis_unit(float(load.max()), "N")
    x, y = approach * across, load * up
    lines = branches(result)
    for name, colour, width in (
        ("elastic", style.ELASTIC, 1.8),
        ("new indentation", style.SATURATED, 2.2),
    ):
        if not lines[name]:
            continue
        # One line with gaps gives one legend entry.
        points = [
            (state.approach * across, state.load * up) if state else (math.nan, math.nan)
            for branch in lines[name]
            for state in (*branch, None)
        ]
        axes.plot(*np.array(points).T, color=colour, lw=width, label=name)
    axes.plot(x, y, "o", color=style.NEUTRAL, ms=4)
    for place, text, side in ((0, "start ", "right"), (-1, " end", "left")):
        style.label_point(axes, text, (x[place], y[place]), (0, 3), ha=side)
    axes.margins(x=0.1)
    axes.set_ylim(bottom=0)
    style.plain_axes(axes, f"approach from first touch [{unit_across}]", f"load [{unit_up}]")
    if any(lines.values()):
        axes.legend(fontsize=style.TICK, frameon=False, loc="upper left")
    positions = len({stage.shift for stage in history.path})
    where = f", {positions} lateral positions" if positions > 1 else ""
    steps = count_noun(len(history.steps), "step")
    style.name_axes(axes, title=f"Load history, {steps}{where}")
