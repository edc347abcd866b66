"""Figures of the resistances of a contact."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from roughcontact._tools.arrays import Array
from roughcontact.analyses.conductance.model import CASES
from roughcontact.drawing import style
from roughcontact.theory.constriction import CORRELATION_RANGE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from roughcontact.analyses.conductance.model import Conductance


_RESISTANCES = (
    ("length", "o-", style.SERIES[0], "computed"),
    ("greenwood_length", "s--", style.SERIES[1], "Greenwood's formula"),
    ("correlation_length", ":", style.NEUTRAL, "correlation for flat joints"),
)


def _band(axes: Axes, load: Array, correlated: Array) -> None:
    """Draw the band about the correlation that holds 95 % of the rough maps."""
    known = np.isfinite(correlated) & (correlated > 0)
    if np.count_nonzero(known) > 1:
        low, high = (factor * correlated[known] for factor in CORRELATION_RANGE)
        label = f"95 % of {CASES} rough maps about it"
        axes.fill_between(load[known], low, high, color=style.NEUTRAL, alpha=0.2, lw=0, label=label)


def conductance(result: Conductance) -> Figure:
    """Draw the resistances of a contact over the load.

    Parameters
    ----------
    result : Conductance
        The resistances.

    Returns
    -------
    Figure
        One panel for each known resistance, electrical and thermal: computed, by Greenwood's
        formula, and by the correlation for flat joints with its scatter over rough maps.
    """
    kinds = [
        (title, unit, kind)
        for title, unit, kind in (
            ("Electrical resistance", "Ω", "electrical"),
            ("Thermal resistance", "K/W", "thermal"),
        )
        if not np.isnan(result.resistance(kind)).all()
    ]
    figure = style.empty_figure(5.6 * len(kinds), 4.6)
    load = result.column("load")
    factor, load_unit = style.axis_unit(float(load.max()), "N")
    for axes, (title, unit, kind) in zip(
        figure.subplots(1, len(kinds), squeeze=False)[0], kinds, strict=True
    ):
        for name, marker, colour, label in _RESISTANCES:
            values = result.resistance(kind, name)
            values[~(np.isfinite(values) & (values > 0))] = np.nan
            if not np.isnan(values).all():
                line = marker if load.size > 1 else "o"
                axes.plot(load * factor, values, line, color=colour, label=label)
                style.log_scale(axes, "y")
        _band(axes, load * factor, result.resistance(kind, "correlation_length"))
        style.log_scale(axes, "x")
        style.plain_axes(axes, f"load [{load_unit}]", f"resistance [{unit}]", title)
        if axes.lines:
            style.plain_legend(axes)
    return figure
