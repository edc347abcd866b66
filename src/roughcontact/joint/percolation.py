"""Whether a gap leads through: which of its points lie on ways from side to side."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Constriction:
    """The narrowest place of the widest way through a gap.

    Parameters
    ----------
    gap : float
        Its gap [m]: the largest that any way through has at its narrowest point.
    place : (int, int)
        Its pixel ``(y, x)``.
    """

    gap: float
    place: tuple[int, int]


def through(opened: Mask, axis: int, periodic_axes: tuple[int, ...] = ()) -> Mask:
    """Return the open points that hang together with a way through the map.

    Parameters
    ----------
    opened : ndarray of bool, shape (ny, nx)
        Where fluid may be.
    axis : {0, 1}
        Along which the way leads: 0 y, 1 x.
    periodic_axes : tuple of int
        Axes along which the map repeats.

    Returns
    -------
    ndarray of bool, shape (ny, nx)
        All false where there is no way. Along an axis that does not repeat, a way leads from the
        first side to the last; along one that does, it leads on from each period to the next, on
        whatever detour, as a closed path on the torus that winds around it.

    Notes
    -----
    Exact on the pixels: those that share an edge are joined, those that share a corner are not,
    as in the flow. Parts of the map that meet across its seams are joined with the number of
    periods that lie between them; a part winds around where two ways to it differ in that number.

    Examples
    --------
    >>> opened = np.array([[1, 0, 0], [1, 1, 0], [0, 1, 0]], bool)
    >>> through(opened, axis=0).any(), through(opened, axis=0, periodic_axes=(0,)).any()
    (np.True_, np.False_)
    """
    label, parts = _labelled(opened, axis, periodic_axes)
    root = parts.roots()
    leads = np.zeros(root.size, bool)
    if axis in periodic_axes:
        leads[list(parts.winding)] = True
        leads = leads[root]
    else:
        first, last = (root[np.unique(label.take(side, axis))] for side in (0, -1))
        leads = np.isin(root, np.intersect1d(first, last))
    leads[0] = False
    found: Mask = leads[label]
    return found


def components(opened: Mask, periodic_axes: tuple[int, ...] = ()) -> NDArray[np.int32]:
    """Return a number for each part of the open points that hangs together, 0 where not open.

    Parameters
    ----------
    opened, periodic_axes
        As for `through`.

    Returns
    -------
    ndarray of int32, shape (ny, nx)
        Numbers from 1 on, not all of which occur.
    """
    label, parts = _labelled(opened, 0, periodic_axes)
    found: NDArray[np.int32] = parts.roots()[label]
    return found


def constriction(gap: Array, axis: int, periodic_axes: tuple[int, ...] = ()) -> Constriction | None:
    """Return the narrowest place of the widest way through a gap; None without a way.

    Parameters
    ----------
    gap : ndarray, shape (ny, nx)
        Gap [m], zero where the bodies touch.
    axis, periodic_axes
        As for `through`.

    Notes
    -----
    The largest gap at which the points that are at least as wide still lead through, by bisection
    among the gaps that occur. In two dimensions nearly all of the pressure falls over a few of such
    places (Persson and Yang 2008, doi:10.1088/0953-8984/20/31/315011).
    """
    gaps = np.unique(gap[through(gap > 0, axis, periodic_axes)])
    if gaps.size == 0:
        return None
    low, high = 0, gaps.size
    while high - low > 1:
        middle = (low + high) // 2
        if through(gap >= gaps[middle], axis, periodic_axes).any():
            low = middle
        else:
            high = middle
    wide = through(gap >= gaps[low], axis, periodic_axes)
    y, x = np.argwhere(wide & (gap == gaps[low]))[0].tolist()
    return Constriction(float(gaps[low]), (y, x))


def _labelled(
    opened: Mask, axis: int, periodic_axes: tuple[int, ...]
) -> tuple[NDArray[np.int32], _Parts]:
    """Return the parts inside the map, and how they are joined across its seams."""
    from scipy import ndimage

    label = np.empty(opened.shape, np.int32)
    count = int(ndimage.label(opened, output=label))
    parts = _Parts(count + 1)
    for seam in periodic_axes:
        for one, two in _meeting(label, seam):
            parts.join(one, two, int(seam == axis))
    return label, parts


def _meeting(label: NDArray[np.int32], axis: int) -> Iterator[tuple[int, int]]:
    """Yield the parts that meet across the seam of an axis, the one before it first."""
    pairs = np.stack([label.take(-1, axis), label.take(0, axis)], axis=1)
    pairs = pairs[(pairs > 0).all(axis=1)]
    if pairs.size:
        yield from (tuple(pair) for pair in np.unique(pairs, axis=0).tolist())


class _Parts:
    """Parts of a map that are joined across its seams, each with the period it lies in."""

    def __init__(self, count: int) -> None:
        self._parent = list(range(count))
        self._period = [0] * count
        self.winding: set[int] = set()

    def find(self, part: int) -> tuple[int, int]:
        """Return the part that stands for all that are joined, and the periods from it to this."""
        periods = 0
        while self._parent[part] != part:
            periods += self._period[part]
            part = self._parent[part]
        return part, periods

    def roots(self) -> NDArray[np.int32]:
        """Return for each part the one that stands for all that are joined with it."""
        return np.array([self.find(part)[0] for part in range(len(self._parent))], np.int32)

    def join(self, one: int, two: int, periods: int) -> None:
        """Join two parts, the second so many periods further on."""
        (first, before), (second, after) = self.find(one), self.find(two)
        if first == second:
            if before + periods != after:
                self.winding.add(first)
            return
        self._parent[second] = first
        self._period[second] = before + periods - after
        if second in self.winding:
            self.winding.add(first)
