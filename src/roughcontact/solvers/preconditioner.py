"""Approximate inverse of the displacement operator on the free pixels.

Two parts. Within a contact spot, the inverse wrapped around a map with little padding, about
``|q| E*/2``: spectrally as good as any known inverse, at the cost of a small pair of transforms.
Between spots, the interaction that this part neglects: it treats the surface around the spots as
fixed, but the spots press it down. This effect is smooth on the scale of the spots, and so is
handled in blocks of pixels.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array, Shape
from roughcontact.solvers.operator import Family, Operator

# Share of new or removed pixels above which m is computed again.
_STALE = 0.01
# Relative tolerance of the forces on the blocks, and maximum number of steps; both are rough.
_ROUGHLY, _MOST_STEPS = 0.1, 30
# Minimum of (1 - θ)²: in full contact a block would respond only to the forces on other blocks.
_STIFFEST = 0.01
# Maximum number of blocks with stored responses: for fewer, a transform takes longer than a sum.
_MAX_STORED_BLOCKS = 576


class FreePixelInverse:
    """Approximate inverse of K restricted to changing sets of pixels.

    With M the wrapped inverse on the pixels, m = M 1, R the sum over the pixels of each block and
    D = R diag(m) Rᵀ: a uniform displacement of the pixels of a block, with the surface around them
    fixed, requires the force D. If the surface is free, a fraction θ of a block is in contact, and
    C is the displacement of a block by the force on another one, the force f displaces them by::

        C f + (1 - θ)² D⁻¹ f

    M responds to a displacement as if the surface around were fixed. Its response to the common
    displacement of a block is replaced by this force; with m D⁻¹ R m for the replaced part::

        M - diag(m) Rᵀ (D⁻¹ - D⁻¹ (C + (1 - θ)² D⁻¹)⁻¹ D⁻¹) R diag(m)

    m and D are reused while the next sets differ by few pixels: if m exceeded the response of M,
    the inverse would not be positive. The forces are found by a few steps of conjugate gradients,
    so that the inverse is not quite linear, nor quite symmetric.

    Parameters
    ----------
    wrapped : Operator
        ``displacement / K₀₀ → pressure``; see `Operator.approximate_inverse`.
    blocks : Operator, optional
        Displacement of the centers of the blocks by the pressure on them; without it only the
        wrapped inverse is used.
    edges : (int, int)
        Pixels along the edges ``(y, x)`` of a block.
    unit : float
        K₀₀ of the map.

    Notes
    -----
    If the spots are displaced by w_I and the surface around by w_J, both smooth, D couples them,
    and the half-space as a whole resists their mean θ w_I + (1-θ) w_J. No force acts on the
    surface around: D (w_I - w_J) = (1-θ) f and θ w_I + (1-θ) w_J = C f, hence w_I above.
    """

    def __init__(
        self,
        wrapped: Operator,
        blocks: Operator | None = None,
        edges: tuple[int, int] = (1, 1),
        unit: float = 1.0,
    ) -> None:
        self._wrapped, self._blocks, self._edges = wrapped, blocks, edges
        self._weights = np.full(wrapped.shape[0] * wrapped.shape[1], np.nan, np.float16)
        # Factor of C for forces in units of unit pressure on a pixel.
        self._softness = 1 / (unit * edges[0] * edges[1])
        # For each block: D⁻¹, 0 without contact, and (1 - θ)² D⁻¹.
        self._yielding = self._own = np.zeros(0)
        self._size = 0
        self._coupling: Array | None = None
        if blocks is not None and blocks.shape[0] * blocks.shape[1] <= _MAX_STORED_BLOCKS:
            self._coupling = _coupling(blocks)

    def restrict_inverse(self, index: NDArray[np.int64]) -> Callable[[Array], Array]:
        """Return the inverse ``displacement / K₀₀ → pressure`` on some pixels, shape ``(n,)``.

        Parameters
        ----------
        index : ndarray of int, shape (n,)
            Flat indices of the pixels, ascending.
        """
        support = self._wrapped.support(index)
        block = self.block_of(index)
        if self._blocks is None or block is None or index.size < 2:
            return lambda displacement: self._wrapped.gather(support, displacement)
        number = self._blocks.shape[0] * self._blocks.shape[1]
        weight = self._weights[index].astype(np.float64)
        unknown = np.isnan(weight)
        size, new = index.size, np.count_nonzero(unknown)
        stale = new + (self._size - (size - new)) > _STALE * size
        # If long waves are far more compliant, the remainder of M is smaller than the error of m.
        if stale or self._blocks.is_long_wave_soft:
            # Positive except for rounding: a pixel is stiffer than its neighbors are soft.
            weight = np.maximum(self._wrapped.gather(support, np.ones(index.size)), 1e-6)
            self._weights[...] = np.nan
            # Layers on a rigid base may be stiffer to long waves than the stored type can hold. A
            # smaller weight keeps the inverse positive.
            self._weights[index] = np.minimum(weight, np.finfo(self._weights.dtype).max)
            self._size = size
            stiffness = np.bincount(block, weight, minlength=number)
            touching = np.bincount(block, minlength=number)
            self._yielding = np.divide(1, stiffness, out=np.zeros(number), where=stiffness > 0)
            self._own = self._yielding * own_part(touching, self._edges)
        else:
            weight[unknown] = 1e-6
        yielding, own = self._yielding, self._own
        itself = self._softness * self._blocks.self_displacement

        def apply(displacement: Array) -> Array:
            pressure = self._wrapped.gather(support, displacement)
            force = np.bincount(block, weight * displacement, minlength=number)
            # Mean displacement weighted by M; without contact when D was made, M is unchanged.
            common = yielding * force
            common -= yielding * forces_on_blocks(self._displacement, common, own, itself)
            shared: Array = common[block]
            shared *= weight
            pressure -= shared
            return pressure

        return apply

    def block_of(self, index: NDArray[np.int64]) -> NDArray[np.int64] | None:
        """Return the flat index of the block of each pixel; None without blocks."""
        if self._blocks is None:
            return None
        return block_of(index, self._wrapped.shape[1], self._edges, self._blocks.shape[1])

    def _displacement(self, force: Array) -> Array:
        """Return C times the forces on the blocks."""
        assert self._blocks is not None
        if self._coupling is not None:
            result: Array = np.einsum("ij,j->i", self._coupling, force)
        else:
            result = self._blocks(force.reshape(self._blocks.shape)).ravel().astype(np.float64)
        result *= self._softness
        return result


def block_of(
    index: NDArray[np.int64], width: int, edges: tuple[int, int], across: int
) -> NDArray[np.int64]:
    """Return the flat index of the block of each pixel of a map.

    Parameters
    ----------
    index : ndarray of int, shape (n,)
        Flat indices of the pixels.
    width : int
        Number of pixels in a row of the map.
    edges : (int, int)
        Pixels along the edges ``(y, x)`` of a block.
    across : int
        Number of blocks in a row.
    """
    # In place: in full contact these are the largest arrays.
    row, block = np.divmod(index, width)
    row //= edges[0]
    row *= across
    block //= edges[1]
    block += row
    return block


def own_part(touching: NDArray[Any], edges: tuple[int, int]) -> Array:
    """Return (1 - θ)² of blocks from their number of pixels in contact."""
    part: Array = np.maximum((1 - touching / (edges[0] * edges[1])) ** 2, _STIFFEST)
    return part


def forces_on_blocks(
    displaced: Callable[[Array], Array], displacement: Array, own: Array, itself: float
) -> Array:
    """Return the approximate forces that displace the blocks in contact.

    Parameters
    ----------
    displaced : callable
        Returns C times the forces.
    displacement : ndarray
        Displacement of the blocks.
    own : ndarray, of the same shape
        Compliance of each block to its force in addition to C; 0 without contact.
    itself : float
        Self-displacement of a block in C.
    """
    touching = own > 0
    # Preconditioner: inverse compliance of each block without the others.
    alone = np.divide(1, own + itself, out=np.zeros(own.shape), where=touching)
    force = np.zeros(own.shape)
    residual = displacement.copy()
    enough = _ROUGHLY**2 * _dot(residual, residual)
    direction, previous = np.zeros(own.shape), 1.0
    for step in range(_MOST_STEPS):
        z = alone * residual
        product = _dot(residual, z)
        if not product > 0:
            break
        direction = z if step == 0 else z + product / previous * direction
        previous = product
        response = displaced(direction)
        response *= touching
        response += own * direction
        length = product / _dot(direction, response)
        force += length * direction
        residual -= length * response
        if _dot(residual, residual) <= enough:
            break
    return force


def _coupling(blocks: Operator) -> Array:
    """Return the displacement of each of a few blocks by the pressure on each."""
    (by, bx), unit = blocks.shape, np.zeros(blocks.shape)
    unit[0, 0] = 1
    response = blocks(unit).astype(np.float64)
    i, j = np.divmod(np.arange(by * bx), bx)
    return response[np.abs(i[:, None] - i), np.abs(j[:, None] - j)]


def _dot(first: Array, second: Array) -> float:
    # Not by BLAS, whose last digits depend on its threads.
    return float(np.sum(first * second))


# Pixels along the edge of a block, and minimum points along each side of a map with blocks: on
# smaller maps the wrapped inverse is as good, and better if pixels are far from square.
_BLOCK, _SMALL = 8, 64


def block_edges(shape: Shape) -> tuple[int, int] | None:
    """Return the edges of the blocks of a map, or None if the map is too small."""
    # A profile has a single row.
    if min(points for points in (*shape, _SMALL) if points > 1) < _SMALL:
        return None
    return min(_BLOCK, shape[0]), min(_BLOCK, shape[1])


@dataclass(frozen=True, eq=False)
class Patch:
    """Part of the map with its operator and approximate inverse."""

    first: tuple[int, int]
    map_width: int
    operator: Operator
    inverse: FreePixelInverse

    def holds(self, low: tuple[int, int], high: tuple[int, int]) -> bool:
        """Return whether the part contains the rows and columns from ``low`` to ``high``."""
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
        return (row - self.first[0]) * width + (column - self.first[1])


class Patches:
    """Smallest useful patch that contains the pixels of a linear solve.

    A pressure causes the same displacement of a pixel on any map that contains both, and acts
    along the whole of a periodic axis: if the contact is confined, so are the transforms.
    """

    def __init__(self, operator: Operator, family: Family, pixel: tuple[int, int]) -> None:
        self._family, self._pixel, self._width = family, pixel, operator.shape[1]
        self._whole = self._patch((0, 0), operator.to_single_precision())
        self._last = self._whole

    def make_patch(self, index: NDArray[np.int64]) -> Patch:
        """Return a patch that contains these pixels."""
        whole = self._whole.operator
        ny, nx = whole.shape
        if all(whole.periodic_axes) or not index.size:
            return self._whole
        # Indices ascend: the first pixel is in the lowest row, the last one in the highest.
        row, column = index[[0, -1]] // nx, index % nx
        low, high = (int(row[0]), int(column.min())), (int(row[1]), int(column.max()))
        if self._last is not self._whole and self._last.holds(low, high):
            return self._last
        first, points = [], []
        for start, end, maximum, wrapped in zip(
            low, high, whole.shape, whole.periodic_axes, strict=True
        ):
            # Margin for the contact to grow by a few pixels from step to step.
            margin = maximum if wrapped else 2 + (end - start) // 32
            first.append(max(0, start - margin))
            points.append(min(maximum, end + 1 + margin) - first[-1])
        if 2 * points[0] * points[1] > ny * nx:
            return self._whole
        operator = self._family((points[0], points[1]), self._pixel).to_single_precision()
        self._last = self._patch((first[0], first[1]), operator)
        return self._last

    def _patch(self, first: tuple[int, int], operator: Operator) -> Patch:
        inverse, unit = operator.approximate_inverse(), operator.self_displacement
        edges = block_edges(operator.shape)
        if edges is None:
            return Patch(first, self._width, operator, FreePixelInverse(inverse))
        number = [-(-points // edge) for points, edge in zip(operator.shape, edges, strict=True)]
        pixel = (edges[0] * self._pixel[0], edges[1] * self._pixel[1])
        blocks = self._family((number[0], number[1]), pixel)
        blockwise = FreePixelInverse(inverse, blocks, edges, unit)
        return Patch(first, self._width, operator, blockwise)
