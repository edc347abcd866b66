"""Contact spots: the connected parts of a contact area, their sizes and loads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughcontact.errors import require_pixel

Array = NDArray[np.float64]

FEW_PIXELS = 10
"""Pixels below which the size of a contact spot is a property of the grid."""


@dataclass(frozen=True, eq=False)
class Spots:
    """The contact spots of one solution, the largest first.

    Parameters
    ----------
    area : ndarray, shape (n,)
        Area of each spot [m²].
    load : ndarray, shape (n,)
        Load on each spot [N].
    peak : ndarray, shape (n,)
        Largest pressure on each spot [Pa].
    label : ndarray of int, shape (ny, nx)
        Number of the spot that a pixel belongs to, from 1; 0 where there is no contact.
    """

    area: Array
    load: Array
    peak: Array
    label: NDArray[np.int32]

    @property
    def count(self) -> int:
        """Number of spots."""
        return self.area.size

    def halfway(self, values: Array) -> float:
        """Return the value which the spots that carry half of the load have or exceed."""
        order = np.argsort(-values, kind="stable")
        carried = np.cumsum(self.load[order])
        index = int(np.searchsorted(carried, 0.5 * carried[-1]))
        return float(values[order[min(index, self.count - 1)]])


def find(pressure: Array, pixel: tuple[float, float], periodic_axes: tuple[int, ...] = ()) -> Spots:
    """Return the connected parts of the contact.

    Parameters
    ----------
    pressure : ndarray, shape (ny, nx)
        Contact pressure [Pa]; pixels with a positive pressure touch.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    periodic_axes : tuple of int
        Axes along which a spot goes on beyond an edge of the map on the opposite side: 0 y, 1 x.

    Returns
    -------
    Spots
        Pixels that share an edge belong together, those that share only a corner do not: a
        spot is a set that current could flow through.

    Raises
    ------
    InputError
        If a pixel edge is not positive and finite.

    Notes
    -----
    Hyun, Pei, Molinari and Robbins 2004, doi:10.1103/PhysRevE.70.026117, count connected clusters
    of touching nodes in the same way. Spots of a few pixels are a property of the grid.

    Examples
    --------
    >>> pressure = np.array([[1.0, 1.0, 0.0], [0.0, 0.0, 3.0]])
    >>> found = find(pressure, (1.0, 1.0))
    >>> found.count, found.area.tolist(), found.load.tolist()
    (2, [2.0, 1.0], [2.0, 3.0])
    """
    require_pixel(pixel)
    touching = pressure > 0
    run, lengths = _runs(touching)
    first, second = _meeting(run, lengths.size, periodic_axes)
    number = _joined(lengths.size, first, second)
    count = int(number.max(initial=-1)) + 1
    pixels = np.bincount(number, lengths, count).astype(np.intp)
    order = np.argsort(-pixels, kind="stable")
    rank = np.empty(count, np.int32)
    rank[order] = np.arange(count)
    spot = rank[number]
    label = np.concatenate([[0], spot + 1]).astype(np.int32)[run]
    pressures = pressure[touching]
    sums = np.bincount(np.repeat(spot, lengths), pressures, count)
    peaks = np.zeros(count)
    if lengths.size:
        highest = np.maximum.reduceat(pressures, np.cumsum(lengths) - lengths)
        np.maximum.at(peaks, spot, highest)
    area = pixel[0] * pixel[1]
    areas: Array = pixels[order] * np.float64(area)
    loads: Array = np.asarray(sums, np.float64) * area
    return Spots(areas, loads, peaks, label)


# SciPy labels maps as well; its import takes as long as a small solve, and it looks at every pixel
# where most of them touch nothing.


def _runs(touching: NDArray[np.bool_]) -> tuple[NDArray[np.int32], NDArray[np.intp]]:
    """Return a map of numbers of the runs along x, from 1 in their order, and their lengths."""
    edges = np.diff(touching.astype(np.int8), axis=1, prepend=0, append=0)
    lengths = np.nonzero(edges < 0)[1] - np.nonzero(edges > 0)[1]
    run = np.zeros(touching.shape, np.int32)
    run[touching] = np.repeat(np.arange(1, lengths.size + 1, dtype=np.int32), lengths)
    return run, lengths


def _meeting(
    run: NDArray[np.int32], count: int, periodic_axes: tuple[int, ...]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the runs, from 0, that share an edge of a pixel with each other."""
    first = np.concatenate([run[:-1].ravel(), *(run.take(0, axis) for axis in periodic_axes)])
    second = np.concatenate([run[1:].ravel(), *(run.take(-1, axis) for axis in periodic_axes)])
    meet = (first > 0) & (second > 0)
    pairs = first[meet].astype(np.int64) * (count + 1) + second[meet]
    # Two runs meet in many pixels, one after the other.
    pairs = pairs[np.diff(pairs, prepend=-1) != 0]
    return pairs // (count + 1) - 1, pairs % (count + 1) - 1


def _joined(count: int, first: NDArray[np.int64], second: NDArray[np.int64]) -> NDArray[np.intp]:
    """Return for each of ``count`` things the number of its group, given which belong together.

    Groups are numbered from 0 in the order of their first members.
    """
    least = np.arange(count)
    while True:
        one, two = least[first], least[second]
        apart = one != two
        if not apart.any():
            return np.unique(least, return_inverse=True)[1]
        one, two = one[apart], two[apart]
        np.minimum.at(least, np.maximum(one, two), np.minimum(one, two))
        # Each follows those it points to, to the end.
        while (further := least[least]).tobytes() != least.tobytes():
            least = further
