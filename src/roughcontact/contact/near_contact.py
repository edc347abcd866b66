"""Measured points inside or near a contact; all others have no effect on it.

Near is where the bodies touch, or would overlap without deformation: the gap at first contact is
at most the approach. Under a sphere this is √2 times the Hertz radius.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from roughcontact.surface import roughness

if TYPE_CHECKING:
    from roughcontact.contact.result import ContactResult

EDGE_WIDTH = 0.05
"""Part of a side that is near an edge."""

# Points along a side below which one of them is too much of it.
_MIN_POINTS = 8

# Step between opposite edges over that between neighbors, from which the map is not periodic.
_SEAM = 2.0


def points_near_contact(result: ContactResult) -> NDArray[np.bool_]:
    """Return the measured points inside or near the contact, shape (ny, nx)."""
    near: NDArray[np.bool_] = (result.initial_gap <= result.approach) | result.contact
    return near


def rms_slope(result: ContactResult) -> float:
    """Return the RMS slope of both bodies together from points near the contact to neighbors.

    NaN if no such point has both neighbors.
    """
    near = points_near_contact(result)
    if near.shape[0] == 1:
        near = np.repeat(near, 2, axis=0)
    counted = near[1:, 1:] | near[:-1, 1:] | near[1:, :-1]
    row, total, count = 0, 0.0, 0
    for squares in roughness.squared_gradients(result.initial_gap, result.pair.pixel):
        known = squares[counted[row : row + len(squares)] & ~np.isnan(squares)]
        row, total, count = row + len(squares), total + float(known.sum()), count + known.size
    return math.sqrt(total / count) if count else math.nan


@dataclass(frozen=True)
class PeriodicStep:
    """Step between opposite edges of a periodic map, and the load near them."""

    step: float  # Largest rms step over the standard deviation of the gap
    width: float  # Part of a side next to an edge: `EDGE_WIDTH` or one point
    load: float  # Share of the load near these edges
    area: float  # Share of the area near these edges, hence of an even load


def find_periodic_step(result: ContactResult) -> PeriodicStep | None:
    """Return the step between opposite edges along periodic axes; None where the map has none."""
    gap, pressure = result.initial_gap, result.pressure
    deviation, steps, widths = float(np.nanstd(gap)), [], []
    inner = [slice(None), slice(None)]
    for axis in result.boundary.periodic_axes:
        points = gap.shape[axis]
        if points < _MIN_POINTS:
            continue
        seam = _rms(np.take(gap, 0, axis) - np.take(gap, -1, axis))
        if seam > _SEAM * _rms(np.diff(gap, axis=axis)):
            steps.append(seam / deviation)
            near = max(1, round(EDGE_WIDTH * points))
            inner[axis] = slice(near, points - near)
            widths.append(near / points)
    total = float(pressure.sum())
    if not steps or total == 0:
        return None
    part = pressure[tuple(inner)]
    load, area = 1 - float(part.sum()) / total, 1 - part.size / gap.size
    return PeriodicStep(max(steps), max(widths), load, area)


def _rms(values: NDArray[np.float64]) -> float:
    known = values[~np.isnan(values)]
    return float(np.sqrt(np.mean(np.square(known)))) if known.size else math.nan


def missing_points(result: ContactResult) -> tuple[int, float]:
    """Return the number of missing points near the contact, and their share of all there.

    A missing point is near if the next measured point is.
    """
    total = math.prod(result.pair.shape)
    missing = total - result.totals.points
    if not missing:
        return 0, 0.0
    from scipy import ndimage

    near, absent = points_near_contact(result), np.isnan(result.initial_gap)
    nearest = ndimage.distance_transform_edt(
        absent, result.pair.pixel, return_distances=False, return_indices=True
    )
    count = int(np.count_nonzero(near[tuple(nearest)] & absent))
    return count, count / max(count + int(np.count_nonzero(near)), 1)
