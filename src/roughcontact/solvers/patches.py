"""Parts of the map that hold the contact, each with an operator of its own.

In single precision: a linear solve need only bring the pressure nearer, and what it lacks the next
look at the whole map shows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughcontact.solvers.operator import Family, Operator
from roughcontact.solvers.preconditioner import FreePixelInverse

# Pixels along the edge of a block, and the points along each side of a map that has blocks: on
# smaller ones the wrapped inverse does as well, and better where pixels are far from square.
_BLOCK, _SMALL = 8, 64


@dataclass(frozen=True, eq=False)
class Patch:
    """A part of the map with an operator and an approximate inverse of its own."""

    first: tuple[int, int]
    map_width: int
    operator: Operator
    inverse: FreePixelInverse

    def holds(self, low: tuple[int, int], high: tuple[int, int]) -> bool:
        """Return whether the rows and columns from ``low`` to ``high`` lie on it."""
        return all(
            first <= start and end < first + points
            for first, points, start, end in zip(
                self.first, self.operator.shape, low, high, strict=True
            )
        )

    def index(self, index: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return flat indices on the patch for flat indices on the map."""
        width = self.operator.shape[1]
        if width == self.map_width:
            return index - self.first[0] * width if self.first[0] else index
        row, column = np.divmod(index, self.map_width)
        local: NDArray[np.int64] = (row - self.first[0]) * width + (column - self.first[1])
        return local


class Patches:
    """The smallest patch worth having that holds the pixels of a linear solve.

    A pressure displaces a pixel alike on any map that holds both, and reaches along the whole of
    an axis that is wrapped: where the contact is confined, so are the transforms.
    """

    def __init__(self, operator: Operator, family: Family, pixel: tuple[int, int]) -> None:
        self._family, self._pixel, self._width = family, pixel, operator.shape[1]
        self._whole = self._patch((0, 0), operator.in_single())
        self._last = self._whole

    def around(self, index: NDArray[np.int64]) -> Patch:
        """Return a patch that holds these pixels."""
        whole = self._whole.operator
        (ny, nx), sums = whole.shape, whole.sums
        if all(whole.wrapped) or not sums.size(index):
            return self._whole
        # Indices ascend: the rows of the first and of the last are the lowest and the highest.
        row, column = index[[0, -1]] // nx, index % nx
        low = int(sums.smallest(row)), int(sums.smallest(column))
        high = int(sums.largest(row)), int(sums.largest(column))
        if self._last is not self._whole and self._last.holds(low, high):
            return self._last
        first, points = [], []
        for start, end, most, wrapped in zip(low, high, whole.shape, whole.wrapped, strict=True):
            # Room for the contact to grow by a few pixels from step to step.
            margin = most if wrapped else 2 + (end - start) // 32
            first.append(max(0, start - margin))
            points.append(min(most, end + 1 + margin) - first[-1])
        if 2 * points[0] * points[1] > ny * nx:
            return self._whole
        operator = self._family((points[0], points[1]), self._pixel).in_single()
        self._last = self._patch((first[0], first[1]), operator)
        return self._last

    def _patch(self, first: tuple[int, int], operator: Operator) -> Patch:
        inverse, unit = operator.approximate_inverse(), operator.self_displacement
        # A profile has a single row.
        if min(points for points in (*operator.shape, _SMALL) if points > 1) < _SMALL:
            return Patch(first, self._width, operator, FreePixelInverse(inverse))
        edges = [min(_BLOCK, points) for points in operator.shape]
        number = [-(-points // edge) for points, edge in zip(operator.shape, edges, strict=True)]
        pixel = (edges[0] * self._pixel[0], edges[1] * self._pixel[1])
        blocks = self._family((number[0], number[1]), pixel)
        blockwise = FreePixelInverse(inverse, blocks, (edges[0], edges[1]), unit)
        return Patch(first, self._width, operator, blockwise)
