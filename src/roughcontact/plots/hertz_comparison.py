"""The pressure of a rough contact beside Hertz's of its nominal bodies."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from roughcontact.contact import hertz_comparison
from roughcontact.contact.nominal_hertz import LINE, Smooth
from roughcontact.contact.result import ContactResult
from roughcontact.errors import InputError
from roughcontact.plots import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

# How far the axis goes beyond Hertz's contact, at least.
_AROUND = 1.5


def versus_hertz(result: ContactResult) -> Figure:
    """Draw the pressure against the distance from the middle of the contact, here and smooth.

    Parameters
    ----------
    result : ContactResult
        A solved contact of nominal bodies, with pressure.

    Returns
    -------
    Figure
        Mean and largest pressure on lines along a cylinder, or on rings of the shape of Hertz's
        contact about the centre of pressure, one pixel wide, and Hertz's pressure.

    Raises
    ------
    InputError
        If the bodies have no contact of Hertz's to stand beside.
    """
    smooth = result.hertz
    if smooth is None:
        raise InputError("has no nominal bodies that Hertz's theory knows", argument="result")
    line = smooth.shape.kind == LINE
    distance, mean, largest = _lines(result, smooth) if line else _rings(result, smooth)
    half = smooth.semi_axes[0]
    ends = _ends(distance, largest, half, line)
    factor, unit = style.prefixed(max(map(abs, ends)), "m")
    scale, pressure_unit = style.prefixed(max(float(largest.max()), smooth.max_pressure), "Pa")
    figure, axes = style.panels(7.2, 5.0)
    where = "along the axis" if line else "on the ring"
    axes.plot(
        distance * factor, largest * scale, color=style.SATURATED, linewidth=1.0,
        label=f"largest {where}",
    )  # fmt: skip
    axes.plot(
        distance * factor, mean * scale, color=style.ELASTIC, linewidth=2.2, label=f"mean {where}"
    )
    position = np.linspace(-half if line else 0.0, half, 400)
    pressure = smooth.max_pressure * np.sqrt(np.maximum(1 - (position / half) ** 2, 0))
    axes.plot(position * factor, pressure * scale, color=style.NEUTRAL, linewidth=1.8,
              linestyle="--", label="Hertz, smooth")  # fmt: skip
    axes.set_xlim(ends[0] * factor, ends[1] * factor)
    axes.set_ylim(bottom=0)
    name = "distance across from the middle" if line else "distance from the middle"
    if smooth.shape.kind == "ellipse":
        name += " along the longer side"
    style.plain_axes(
        axes,
        f"{name} [{unit}]",
        f"pressure [{pressure_unit}]",
        f"Beside Hertz at {style.load_text(result)}{style.doubt(result)}",
    )
    style.legend_below(axes, columns=1)
    return figure


def _lines(result: ContactResult, smooth: Smooth) -> tuple[Array, Array, Array]:
    """Return distances across a cylinder, and mean and largest pressure along it."""
    axis = smooth.shape.axis
    assert axis is not None
    across = hertz_comparison.places(result, result.center_of_pressure)[1 - axis].ravel()
    return across, result.pressure.mean(axis=axis), result.pressure.max(axis=axis)


def _rings(result: ContactResult, smooth: Smooth) -> tuple[Array, Array, Array]:
    """Return distances from the middle, and mean and largest pressure on rings."""
    a, b = smooth.semi_axes[0], smooth.semi_axes[-1]
    along, across = hertz_comparison.directions(smooth)
    y, x = hertz_comparison.places(result, result.center_of_pressure)
    u, v = (cy * y + cx * x for cy, cx in (along, across))
    distance = np.sqrt(u**2 + (v * (a / b)) ** 2).ravel()
    width = max(result.surface.pixel) * (a / b)
    ring = (distance / width).astype(np.intp)
    count = np.bincount(ring)
    mean = np.bincount(ring, result.pressure.ravel()) / np.maximum(count, 1)
    largest = np.zeros(count.size)
    np.maximum.at(largest, ring, result.pressure.ravel())
    filled = count > 0
    middle = (np.flatnonzero(filled) + 0.5) * width
    return middle.astype(np.float64), mean[filled], largest[filled]


def _ends(distance: Array, largest: Array, half: float, line: bool) -> tuple[float, float]:
    """Return where the axis begins and ends: around both contacts, within the map."""
    touched = np.abs(distance[largest > 0])
    far = max(_AROUND * half, float(touched.max(initial=0.0)) * 1.05)
    low, high = float(distance.min()), float(distance.max())
    return (max(-far, low) if line else 0.0), min(far, max(high, half))
