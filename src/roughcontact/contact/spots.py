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
    import scipy.ndimage

    require_pixel(pixel)
    found, count = scipy.ndimage.label(pressure > 0)
    label = np.asarray(found, np.int32)
    if periodic_axes:
        label, count = _joined(label, count, periodic_axes)
    numbers = np.arange(1, count + 1)
    pixels = np.bincount(label.ravel(), minlength=count + 1)[1:]
    order = np.argsort(-pixels, kind="stable")
    rank = np.zeros(count + 1, np.int32)
    rank[order + 1] = numbers
    label = rank[label]
    sums = np.bincount(label.ravel(), pressure.ravel(), minlength=count + 1)[1:]
    peaks = np.asarray(scipy.ndimage.maximum(pressure, label, numbers), dtype=float)
    area = pixel[0] * pixel[1]
    areas: Array = pixels[order] * np.float64(area)
    loads: Array = np.asarray(sums, np.float64) * area
    return Spots(areas, loads, peaks.reshape(count), label)


def _joined(
    label: NDArray[np.int32], count: int, periodic_axes: tuple[int, ...]
) -> tuple[NDArray[np.int32], int]:
    """Give spots that meet across opposite edges the same number."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    first, second = (
        np.concatenate([label.take(edge, axis) for axis in periodic_axes]) for edge in (0, -1)
    )
    meet = (first > 0) & (second > 0)
    links = coo_array(
        (np.ones(np.count_nonzero(meet)), (first[meet] - 1, second[meet] - 1)), (count, count)
    )
    total, group = connected_components(links, directed=False)
    return np.concatenate([[0], group + 1]).astype(np.int32)[label], int(total)
