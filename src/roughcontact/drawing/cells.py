"""Cells of several points of a map: shares of classes, and limits of colors.

`roughcontact.drawing.maps` describes maps in cells; this module is independent of the backend.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array
from roughcontact.contact.result import ContactResult
from roughcontact.drawing import style
from roughcontact.errors import input_error

Mask = NDArray[np.bool_]

# Share of the contact area within the scale of a pressure map.
_SHOWN = 0.995


class Limits(NamedTuple):
    """Ends of a color scale, and whether there are values beyond the ends."""

    low: float
    high: float
    below: bool
    above: bool


def height_limits(values: Array) -> Limits:
    """Return the limits that span the middle 99 % of the heights of cells [m]."""
    there = values[np.isfinite(values)]
    low, high = np.percentile(there, (0.5, 99.5)) if there.size else (0.0, 0.0)
    if not high > low:
        # Flat map, or a map with few features outside the percentiles.
        low, high = float(there.min(initial=0)), float(there.max(initial=0))
    if not high > low:
        low, high = -0.5e-9, 0.5e-9
    return Limits(float(low), float(high), bool((there < low).any()), bool((there > high).any()))


def gap_limit(values: Array) -> float:
    """Return the upper color limit of an open gap [m], from cell values (NaN where closed)."""
    there = values[np.isfinite(values)]
    top = float(np.percentile(there, 99.5)) if there.size else 0.0
    return top or float(there.max(initial=0.0)) or 1e-9


def pressure_limit(results: Sequence[ContactResult], limit: float | None = None) -> float:
    """Return the upper color limit of pressures [Pa]; see `maps.pressure`."""
    if limit is not None:
        if not 0 < limit < math.inf:
            raise input_error("limit", limit, "must be positive and finite [Pa]")
        return float(limit)
    # If almost no point is saturated, one spike would leave a single color for all other points.
    reached = [
        float(np.quantile(r.pressure[r.contact], _SHOWN))
        for r in results
        if r.saturated_fraction > 0
    ]
    return max(reached or [r.max_pressure for r in results]) or 1.0


def pressure_colors() -> Any:
    """Return the 256 colors of pressures; last axis: red, green, blue, opacity."""
    from matplotlib import colormaps

    # Without the lightest colors, which resemble the background, and the darkest, which resemble
    # values beyond the scale.
    return colormaps["inferno_r"](np.linspace(0.17, 0.63, 256))


class Shares(NamedTuple):
    """Shares of the classes of points in each cell."""

    elastic: Array
    saturated: Array
    missing: Array

    @property
    def touching(self) -> Array:
        """Share of the points in contact."""
        return self.elastic + self.saturated


def cell_shares(contact: Mask, saturated: Mask, gap: Array, blocks: tuple[int, int]) -> Shares:
    """Return the shares of elastic contact, saturated and missing points of each cell."""
    missing = np.isnan(gap) & ~contact
    return Shares(
        style.cell_share(contact & ~saturated, blocks),
        style.cell_share(saturated, blocks),
        style.cell_share(missing, blocks),
    )


def class_colors(result: Shares) -> Array:
    """Return the color of each cell: colors of the classes mixed by their shares."""
    colours = (
        (style.ELASTIC, result.elastic),
        (style.SATURATED, result.saturated),
        (style.MISSING, result.missing),
    )
    return style.mix_colors(colours, style.OPEN)


def open_gap(contact: Mask, gap: Array, blocks: tuple[int, int]) -> Array:
    """Return the mean gap of the open points of each cell [m]; NaN without open points."""
    is_open = ~contact & np.isfinite(gap)
    number = style.reduce_cells(np.add, is_open, blocks, np.float64)
    total = style.reduce_cells(np.add, np.where(is_open, np.maximum(gap, 0), 0.0), blocks)
    return np.where(number > 0, total / np.maximum(number, 1), np.nan)


def closed_cover(result: Shares, colour: str) -> Array:
    """Return the overlay of an open gap: colors of closed and of missing points.

    Last axis: red, green, blue, opacity; the opacity is the share of these points in a cell.
    """
    covered = result.touching + result.missing
    cover = style.mix_colors(
        [(style.MISSING, result.missing / np.where(covered > 0, covered, 1.0))], colour
    )
    return np.dstack([cover, np.minimum(covered, 1.0)])
