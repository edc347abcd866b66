"""Approximate inverse of the displacement operator on the pixels that are free to move.

Two parts. Within a contact spot, the inverse wrapped around a map that is hardly padded, about
``|q| E*/2``: spectrally as good as any known, at the cost of a small pair of transforms. Between
spots, what that part cannot see: it takes the surface around the spots for held where it is, but
the spots press it down. This is smooth on the scale of the spots, and so is handled in blocks of
pixels.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from roughcontact.solvers.operator import Operator

Array = NDArray[np.float64]

# Share of pixels that may be new, or gone, before m is computed again.
_STALE = 0.01
# What the forces on the blocks are solved to, and the most steps; both are cheap and rough.
_ROUGHLY, _MOST_STEPS = 0.1, 30
# A block that touches all over yields to the others alone; some of its own keeps it finite.
_STIFFEST = 0.01
# Blocks of which each response is kept: a transform of so few takes longer than their sum.
_FEW = 576


class FreePixelInverse:
    """Approximate inverse of K restricted to changing sets of pixels.

    With M the wrapped inverse on the pixels, m = M 1, R the sum over the pixels of each block and
    D = R diag(m) Rᵀ: to displace the pixels of a block alike, while the surface around them is
    held, takes the force D. If it is not, part θ of a block touches, and C is the displacement of
    a block by the force on another one, the force f displaces them by::

        C f + (1 - θ)² D⁻¹ f

    M answers all of a displacement as if the surface around were held. Its answer to what blocks
    have in common is replaced by that force; with m D⁻¹ R m for the part that is replaced::

        M - diag(m) Rᵀ (D⁻¹ - D⁻¹ (C + (1 - θ)² D⁻¹)⁻¹ D⁻¹) R diag(m)

    m and D are kept while the next sets differ by few pixels: where m counts more than M gives,
    the inverse would not be positive. The forces are found by a few steps of conjugate gradients,
    so that the inverse is not quite linear, nor quite symmetric.

    Parameters
    ----------
    wrapped : Operator
        ``displacement / K₀₀ → pressure``; see `Operator.approximate_inverse`.
    blocks : Operator, optional
        Displacement of the centres of the blocks by the pressure on them; without it only the
        wrapped inverse is used.
    edges : (int, int)
        Pixels along the edges ``(y, x)`` of a block.
    unit : float
        K₀₀ of the map.

    Notes
    -----
    Where the spots are displaced by w_I and the surface around by w_J, both smooth, D couples
    them, and the half-space as a whole resists their mean θ w_I + (1-θ) w_J. No force acts on the
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
        here = (wrapped.rows.stop - wrapped.rows.start) * wrapped.shape[1]
        self._weights = np.full(here, np.nan, np.float16)
        # C displaces by force, in pixels under unit pressure.
        self._softness = 1 / (unit * edges[0] * edges[1])
        # Of each block: D⁻¹, 0 where nothing touches, and how much of it is its own softness.
        self._yielding = self._own = np.zeros(0)
        self._size = 0
        self._coupling: Array | None = None
        if blocks is not None and blocks.shape[0] * blocks.shape[1] <= _FEW:
            self._coupling = _coupling(blocks)

    def on(self, index: NDArray[np.int64]) -> Callable[[Array], Array]:
        """Return the inverse on some pixels, ``displacement / K₀₀ → pressure``, shapes ``(n,)``.

        Parameters
        ----------
        index : ndarray of int, shape (n,)
            Flat indices of the pixels, ascending.
        """
        support, sums = self._wrapped.support(index), self._wrapped.sums
        if self._blocks is None or sums.size(index) < 2:
            return lambda displacement: self._wrapped.gather(support, displacement)
        block = self._block_of(index)
        number = self._blocks.shape[0] * self._blocks.shape[1]
        weight = self._weights[index].astype(np.float64)
        unknown = np.isnan(weight)
        size, new = sums.size(index), sums.count(unknown)
        if new + (self._size - (size - new)) > _STALE * size:
            # Positive but for rounding: a pixel is stiffer than its neighbours are soft.
            weight = np.maximum(self._wrapped.gather(support, np.ones(index.size)), 1e-6)
            self._weights[...] = np.nan
            self._weights[index], self._size = weight, size
            stiffness = sums.added(np.bincount(block, weight, minlength=number))
            touching = sums.added(np.bincount(block, minlength=number))
            free = 1 - touching / (self._edges[0] * self._edges[1])
            self._yielding = np.divide(1, stiffness, out=np.zeros(number), where=stiffness > 0)
            self._own = self._yielding * np.maximum(free**2, _STIFFEST)
        else:
            weight[unknown] = 1e-6
        yielding, own = self._yielding, self._own

        def apply(displacement: Array) -> Array:
            pressure = self._wrapped.gather(support, displacement)
            force = sums.added(np.bincount(block, weight * displacement, minlength=number))
            # As M sees it; where no pixel touched when D was made, M is left alone.
            common = yielding * force
            common -= yielding * self._forces(common, own)
            shared: Array = common[block]
            shared *= weight
            pressure -= shared
            return pressure

        return apply

    def _block_of(self, index: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the flat index of the block that each pixel lies in."""
        assert self._blocks is not None
        # In place: where all of the map touches, these are the largest arrays of all.
        row, block = np.divmod(index, self._wrapped.shape[1])
        row += self._wrapped.rows.start
        row //= self._edges[0]
        row *= self._blocks.shape[1]
        block //= self._edges[1]
        block += row
        return block

    def _forces(self, displacement: Array, own: Array) -> Array:
        """Return the forces on the blocks that touch which displace them so, about."""
        assert self._blocks is not None
        touching = own > 0
        # Alone, a block moves by what it does to itself.
        alone = own + self._softness * self._blocks.self_displacement
        alone = np.divide(1, alone, out=np.zeros(own.size), where=touching)
        force = np.zeros(own.size)
        residual = displacement.copy()
        enough = _ROUGHLY**2 * _dot(residual, residual)
        direction, previous = np.zeros(own.size), 1.0
        for step in range(_MOST_STEPS):
            z = alone * residual
            product = _dot(residual, z)
            if not product > 0:
                break
            direction = z if step == 0 else z + product / previous * direction
            previous = product
            response = self._displaced(direction)
            response *= touching
            response += own * direction
            length = product / _dot(direction, response)
            force += length * direction
            residual -= length * response
            if _dot(residual, residual) <= enough:
                break
        return force

    def _displaced(self, force: Array) -> Array:
        """Return C times the forces on the blocks."""
        assert self._blocks is not None
        if self._coupling is not None:
            found: Array = np.einsum("ij,j->i", self._coupling, force)
        else:
            found = self._blocks(force.reshape(self._blocks.shape)).ravel().astype(np.float64)
        found *= self._softness
        return found


def _coupling(blocks: Operator) -> Array:
    """Return the displacement of each of a few blocks by the pressure on each."""
    (by, bx), unit = blocks.shape, np.zeros(blocks.shape)
    unit[0, 0] = 1
    response = blocks(unit).astype(np.float64)
    i, j = np.divmod(np.arange(by * bx), bx)
    coupling: Array = response[np.abs(i[:, None] - i), np.abs(j[:, None] - j)]
    return coupling


def _dot(first: Array, second: Array) -> float:
    # Not by BLAS, whose last digits depend on its threads.
    return float(np.sum(first * second))
