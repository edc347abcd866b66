"""Contact spots: the connected parts of a contact area, their sizes and loads.

`find_spots`: Hyun, Pei, Molinari and Robbins 2004, doi:10.1103/PhysRevE.70.026117, count connected
clusters of touching nodes with the same definition. Spots of a few pixels are a property of the
grid.

`rim_excess`: Yastrebov, Anciaux and Molinari 2017, doi:10.1016/j.triboint.2017.04.023
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array, Pixel
from roughcontact.errors import require_pixel
from roughcontact.halfspace.boundary import Boundary

MIN_SPOT_PIXELS = 10
"""Number of pixels below which the size of a contact spot is a property of the grid."""


# Number of points that are copied at once.
_PART = 2**16


@dataclass(frozen=True, eq=False)
class Spots:
    """The contact spots of one solution, the largest first."""

    area: Array  # (n,) Area of each spot [m²]
    load: Array  # (n,) Load on each spot [N]
    peak: Array  # (n,) Largest pressure on each spot [Pa]
    label: NDArray[np.int32]  # (ny, nx) Number of the spot that a pixel belongs to, from 1

    @property
    def count(self) -> int:
        """Number of spots."""
        return self.area.size

    def load_weighted_median(self, values: Array) -> float:
        """Return the value that spots with half of the load have or exceed."""
        order = np.argsort(-values, kind="stable")
        carried = np.cumsum(self.load[order])
        middle = int(np.searchsorted(carried, 0.5 * carried[-1]))
        return float(values[order[min(middle, self.count - 1)]])


def find_spots(pressure: Array, pixel: Pixel, periodic_axes: tuple[int, ...] = ()) -> Spots:
    """Return the connected parts of the contact."""
    require_pixel(pixel)
    touching = np.flatnonzero(pressure > 0)
    run, lengths = _label_runs(touching, pressure.shape)
    first, second = _adjacent_runs(touching, run, periodic_axes)
    number = _merge_groups(lengths.size, first, second)
    count = int(number.max(initial=-1)) + 1
    pixels = np.bincount(number, lengths, count).astype(np.intp)
    order = np.argsort(-pixels, kind="stable")
    rank = np.empty(count, np.int32)
    rank[order] = np.arange(count)
    spot = rank[number]
    label = np.concatenate([[0], spot + 1]).astype(np.int32)[run]
    pressures = pressure.ravel()[touching]
    sums = np.bincount(np.repeat(spot, lengths), pressures, count)
    peaks = np.zeros(count)
    if lengths.size:
        np.maximum.at(peaks, spot, np.maximum.reduceat(pressures, np.cumsum(lengths) - lengths))
    area = pixel[0] * pixel[1]
    areas: Array = pixels[order] * np.float64(area)
    loads: Array = np.asarray(sums, np.float64) * area
    return Spots(areas, loads, peaks, label)


# SciPy also labels maps, but its import takes as long as a small solve, and it visits every pixel
# although most are not in contact.


def _label_runs(
    touching: NDArray[np.intp], shape: tuple[int, ...]
) -> tuple[NDArray[np.int32], NDArray[np.intp]]:
    """Return a map of the numbers of runs along x, from 1, and the lengths of the runs."""
    begins = (np.diff(touching, prepend=-2) != 1) | (touching % shape[1] == 0)
    run = np.zeros(shape, np.int32)
    run.ravel()[touching] = np.cumsum(begins, dtype=np.int32)
    return run, np.diff(np.flatnonzero(begins), append=touching.size)


def _adjacent_runs(
    touching: NDArray[np.intp], run: NDArray[np.int32], periodic_axes: tuple[int, ...]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the pairs of runs, from 0, that share an edge of a pixel."""
    number, width = run.ravel(), run.shape[1]
    lower = touching[touching >= width]
    first = np.concatenate([number[lower - width], *(run.take(0, axis) for axis in periodic_axes)])
    second = np.concatenate([number[lower], *(run.take(-1, axis) for axis in periodic_axes)])
    meet = (first > 0) & (second > 0)
    first, second = first[meet].astype(np.int64) - 1, second[meet].astype(np.int64) - 1
    # Two runs meet in many consecutive pixels.
    other = (np.diff(first, prepend=-1) != 0) | (np.diff(second, prepend=-1) != 0)
    return first[other], second[other]


def _merge_groups(
    count: int, first: NDArray[np.int64], second: NDArray[np.int64]
) -> NDArray[np.intp]:
    """Return the group number of each of ``count`` items, given pairs in the same group."""
    minimum = np.arange(count)
    while True:
        item, two = minimum[first], minimum[second]
        differ = item != two
        if not differ.any():
            return np.unique(minimum, return_inverse=True)[1]
        item, two = item[differ], two[differ]
        np.minimum.at(minimum, np.maximum(item, two), np.minimum(item, two))
        # Follow the pointers of each item to their end.
        while (further := minimum[minimum]).tobytes() != minimum.tobytes():
            minimum = further


RIM_EXCESS = (math.pi - 1 + math.log(2)) / 24
"""Number of pixels by which each edge of an elastic rim makes a contact area too large."""


@dataclass(frozen=True)
class Totals:
    """Quantities of a contact that need all pixels of the map, evaluated once."""

    points: int  # Valid pixels
    contact: int  # Pixels with pressure
    saturated: int  # Pixels at the ceiling
    rims: int  # Edges between an elastic pixel and one without contact
    max_pressure: float  # Largest pressure [Pa]
    mean_gap: float  # Mean open gap [m]
    max_indentation: float  # Largest permanent indentation of a saturated pixel [m]
    edge_load: float | None  # Load share along the edges at which the map ends


def count_totals(
    boundary: Boundary, pressure: Array, gap: Array, ceiling: float | Array | None
) -> Totals:
    """Return the totals of a map."""
    touching = pressure > 0
    saturated = pressure >= (math.inf if ceiling is None else ceiling)
    points = int(np.count_nonzero(~np.isnan(gap)))
    return Totals(
        points=points,
        contact=int(np.count_nonzero(touching)),
        saturated=int(np.count_nonzero(saturated)),
        rims=_count_rim(boundary, touching, touching & ~saturated),
        max_pressure=float(pressure.max(initial=0.0)),
        mean_gap=_open_volume(gap.ravel()) / points if points else math.nan,
        max_indentation=max(0.0, -float(gap[saturated].min(initial=0.0))),
        edge_load=_edge_load(boundary, pressure),
    )


def _open_volume(gap: Array) -> float:
    """Return the sum of the open gaps, identical to the sum of a clipped copy of the map.

    NumPy adds by halves, split at multiples of eight. The parts do the same with less memory.
    """
    if gap.size <= _PART:
        return float(np.fmax(gap, 0).sum())
    half = gap.size // 2
    half -= half % 8
    return _open_volume(gap[:half]) + _open_volume(gap[half:])


def _count_rim(boundary: Boundary, touching: NDArray[np.bool_], elastic: NDArray[np.bool_]) -> int:
    """Return the number of edges of the rim, with little memory."""
    wrapped = boundary.periodic_axes
    rows, result = max(1, _PART // touching.shape[1]), 0
    for top in range(0, len(touching), rows):
        own, next_too = slice(top, top + rows), slice(top, top + rows + 1)
        result += rim_edges(touching[own], elastic[own], 1, 1 in wrapped)
        result += rim_edges(touching[next_too], elastic[next_too], 0, False)
    if 0 in wrapped:
        result += rim_edges(touching[[-1, 0]], elastic[[-1, 0]], 0, False)
    return result


def _edge_load(boundary: Boundary, pressure: Array) -> float | None:
    if not boundary.free_axes:
        return None
    if not any((pressure.take([0, -1], axis) > 0).any() for axis in boundary.free_axes):
        return None
    inner = pressure[
        tuple(slice(1, -1) if axis in boundary.free_axes else slice(None) for axis in (0, 1))
    ]
    return max(1 - float(inner.sum()) / float(pressure.sum()), 0.0)


def rim_excess(
    touching: NDArray[np.bool_], elastic: NDArray[np.bool_], boundary: Boundary
) -> float:
    """Return the number of pixels by which an elastic rim makes a contact area too large."""
    return RIM_EXCESS * sum(
        rim_edges(touching, elastic, axis, axis in boundary.periodic_axes) for axis in (0, 1)
    )


def rim_edges(
    touching: NDArray[np.bool_], elastic: NDArray[np.bool_], axis: int, wrapped: bool
) -> int:
    """Return the number of edges along an axis between elastic and separated pixels."""
    beyond, elastic_beyond = np.roll(touching, -1, axis), np.roll(elastic, -1, axis)
    rim = (elastic & ~beyond) | (~touching & elastic_beyond)
    return int(np.count_nonzero(rim if wrapped else np.delete(rim, -1, axis)))


def center_of_pressure(pressure: Array, pixel: Pixel) -> tuple[float, float]:
    """Return the point of action of a pressure."""
    total = float(pressure.sum())
    if total == 0:
        return math.nan, math.nan
    y, x = (
        float(np.einsum("i,i->", np.arange(line.size) - (line.size - 1) / 2, line)) * edge / total
        for line, edge in zip((pressure.sum(axis=1), pressure.sum(axis=0)), pixel, strict=True)
    )
    return y, x
