"""Figure of the uncertainty budget."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from roughcontact.drawing import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def uncertainty_budget(rows: Sequence[tuple[str, Mapping[str, float]]]) -> Figure:
    """Draw one bar per quantity, with the share of each source in its squared interval."""
    figure, axes = style.panels(7.2, 1.6 + 0.35 * len(rows))
    sources = list(dict.fromkeys(source for _, budget in rows for source in budget))
    left = np.zeros(len(rows))
    for number, source in enumerate(sources):
        shares = np.array([100 * budget.get(source, 0.0) for _, budget in rows])
        color = style.SERIES[number % len(style.SERIES)]
        hatch = "///" if number >= len(style.SERIES) else None
        axes.barh(
            range(len(rows)),
            shares,
            left=left,
            color=color,
            label=source,
            hatch=hatch,
            edgecolor="white",
            height=0.7,
        )
        left += shares
    axes.set_yticks(range(len(rows)), [name for name, _ in rows], fontsize=style.TICK)
    axes.invert_yaxis()
    axes.set_xlim(0, 100)
    style.name_axes(axes, "share of the squared interval [%]")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=style.NOTE, frameon=False)
    return figure
