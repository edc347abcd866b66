"""Approximate inverse of the displacement operator on the pixels that are free to move.

Two parts. Within a contact spot, the inverse wrapped around the unpadded map, about ``|q| E*/2``:
spectrally as good as any known, at the cost of a small pair of transforms. Between spots, what that
part cannot see: on a rough surface the other spots together press a spot down about as far as it
presses itself. These few collective modes are handled on a coarse grid of blocks.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.solvers.operator import Operator

Array = NDArray[np.float64]

# Share of pixels that may be new before m is computed again.
_STALE = 0.01
# Blocks of the map whose collective mode is stiffened at once: so few that every row of the
# products stays in cache.
_AT_A_TIME = 24


class FreePixelInverse:
    """Approximate inverse of K restricted to changing sets of pixels.

    With M the wrapped inverse on the pixels, R the sum over the pixels of each block, and C the
    displacement of a block by the force on another one, K ≈ M⁻¹ + Rᵀ C R. By Woodbury's identity,
    and with M Rᵀ taken as diag(m) Rᵀ, m = M 1, its inverse is::

        M - diag(m) Rᵀ (C⁻¹ + D)⁻¹ R diag(m),   D = R diag(m) Rᵀ

    m and D are kept while the next sets hold few other pixels: where m counts more than M gives,
    the inverse would not be positive.

    Parameters
    ----------
    wrapped : Operator
        ``displacement / K₀₀ → pressure``; see `Operator.approximate_inverse`.
    response : ndarray, shape (by, bx), optional
        Displacement over K₀₀ of the pixels of each block under unit pressure on one pixel of the
        first block; without it only the wrapped inverse is used.
    """

    def __init__(self, wrapped: Operator, response: Array | None = None) -> None:
        self._wrapped, self._response = wrapped, response
        here = (wrapped.rows.stop - wrapped.rows.start) * wrapped.shape[1]
        self._weights = np.full(here, np.nan, np.float16)
        self._coarse = np.empty((0, 0))

    def on(self, index: NDArray[np.int64]) -> Callable[[Array], Array]:
        """Return the inverse on some pixels, ``displacement / K₀₀ → pressure``, shapes ``(n,)``.

        Parameters
        ----------
        index : ndarray of int, shape (n,)
            Flat indices of the pixels, ascending.
        """
        support, sums = self._wrapped.support(index), self._wrapped.sums
        if self._response is None or sums.size(index) < 2:
            return lambda displacement: self._wrapped.gather(support, displacement)
        block, (by, bx) = self._blocks(index), self._response.shape
        weight = self._weights[index].astype(np.float64)
        unknown = np.isnan(weight)
        if sums.count(unknown) > _STALE * sums.size(index):
            # Positive but for rounding: a pixel is stiffer than its neighbours are soft.
            weight = np.maximum(self._wrapped.gather(support, np.ones(index.size)), 1e-6)
            self._weights[...] = np.nan
            self._weights[index] = weight
            stiffness = sums.added(np.bincount(block, weight, minlength=by * bx))
            self._coarse = self._collective(stiffness)
        else:
            weight[unknown] = 1e-6
        coarse = self._coarse

        def apply(displacement: Array) -> Array:
            pressure = self._wrapped.gather(support, displacement)
            force = np.bincount(block, weight * displacement, minlength=by * bx)
            shared = _product(coarse, sums.added(force))[block]
            shared *= weight
            pressure -= shared
            return pressure

        return apply

    def _blocks(self, index: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the flat index of the block that each pixel lies in."""
        assert self._response is not None
        (ny, nx), (by, bx) = self._wrapped.shape, self._response.shape
        # In place: where all of the map touches, these are the largest arrays of all.
        row, block = np.divmod(index, nx)
        row += self._wrapped.rows.start
        row //= -(-ny // by)
        row *= bx
        block //= -(-nx // bx)
        block += row
        return block

    def _collective(self, stiffness: NDArray[Any]) -> Array:
        """Return (C⁻¹ + D)⁻¹ for the diagonal of D."""
        assert self._response is not None
        by, bx = self._response.shape
        i, j = np.divmod(np.arange(by * bx), bx)
        coupling = self._response[np.abs(i[:, None] - i), np.abs(j[:, None] - j)]
        return _stiffened(coupling, stiffness)


def _stiffened(compliance: Array, stiffness: Array) -> Array:
    """Return (C⁻¹ + D)⁻¹ for a symmetric C, of which the upper part is read, and the diagonal of D.

    A few entries of D after the others, by Woodbury's identity, so that C is never inverted; the
    last digits must not depend on how many threads share the work, as those of LAPACK do.
    """
    matrix = compliance.copy()
    for first in range(0, stiffness.size, _AT_A_TIME):
        part = slice(first, first + _AT_A_TIME)
        strip = np.concatenate([matrix[:first, part].T, matrix[part, first:]], axis=1)
        corner = _stiffened_one_by_one(strip[:, part], stiffness[part])
        forces = stiffness[part, None] * strip
        strip -= _product(corner, forces)
        for top in range(0, stiffness.size, _AT_A_TIME):
            rows = slice(top, top + _AT_A_TIME)
            matrix[rows, top:] -= _product(forces[:, rows].T, strip[:, top:])
    matrix = np.triu(matrix)
    matrix += np.triu(matrix, 1).T
    return matrix


def _stiffened_one_by_one(compliance: Array, stiffness: Array) -> Array:
    matrix = compliance.copy()
    for i, added in enumerate(stiffness):
        row = matrix[i] * (added / (1 + added * matrix[i, i]))
        matrix -= matrix[:, i, None] * row
    return matrix


def _product(matrix: Array, values: Array) -> Array:
    # Not by BLAS: its threads spin for a while after each call, and change the last digits.
    product: Array = np.einsum("ij,j...->i...", matrix, values)
    return product
