"""Approximate inverse of the displacement operator on the pixels that are free to move.

Two parts. Within a contact spot, the inverse wrapped around the unpadded map, about ``|q| E*/2``:
spectrally as good as is known at the price of a small pair of transforms. Between spots, what that
part cannot see: on a rough surface the other spots together press a spot down about as far as it
presses itself. These few collective modes are handled on a coarse grid of blocks.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from roughcontact.convolution import Convolution

Array = NDArray[np.float64]


class FreePixelInverse:
    """Approximate inverse of K restricted to some pixels.

    With M the wrapped inverse on the pixels, R the sum over the pixels of each block, and C the
    displacement of a block by the force on another one, K ≈ M⁻¹ + Rᵀ C R. By Woodbury's identity,
    and with M Rᵀ taken as diag(m) Rᵀ, m = M 1, its inverse is::

        M - diag(m) Rᵀ (C⁻¹ + D)⁻¹ R diag(m),   D = R diag(m) Rᵀ

    Parameters
    ----------
    wrapped : Convolution
        ``displacement / K₀₀ → pressure``; see `Convolution.approximate_inverse`.
    index : ndarray of int, shape (n,)
        Flat indices of the pixels, ascending.
    response : ndarray, shape (by, bx), optional
        Displacement over K₀₀ of the pixels of each block under unit pressure on one pixel of the
        first block; without it only the wrapped inverse is used.
    """

    def __init__(
        self, wrapped: Convolution, index: NDArray[np.int64], response: Array | None = None
    ) -> None:
        self._wrapped = wrapped
        self._support = wrapped.support(index)
        self._factor = None
        if response is None or index.size < 2:
            return
        (ny, nx), (by, bx) = wrapped.shape, response.shape
        row, column = np.divmod(index, nx)
        row //= -(-ny // by)
        column //= -(-nx // bx)
        used, self._block = np.unique(row * bx + column, return_inverse=True)
        # Imported late: most of the time of `import roughcontact` would be SciPy's.
        from scipy.linalg import cho_factor

        # Positive but for rounding: a pixel is stiffer than its neighbours are soft.
        self._weight = np.maximum(wrapped.gather(self._support, np.ones(index.size)), 1e-6)
        self._stiffness = np.bincount(self._block, self._weight)
        i, j = np.divmod(used, bx)
        coupling = response[np.abs(i[:, None] - i), np.abs(j[:, None] - j)]
        coupling[np.diag_indices_from(coupling)] += 1 / self._stiffness
        self._factor = cho_factor(coupling, overwrite_a=True, check_finite=False)

    def __call__(self, displacement: Array) -> Array:
        """Return the pressure that causes about this displacement over K₀₀, shape ``(n,)``."""
        pressure = self._wrapped.gather(self._support, displacement)
        if self._factor is None:
            return pressure
        from scipy.linalg import cho_solve

        force = np.bincount(self._block, self._weight * displacement)
        mean = force / self._stiffness
        # (C⁻¹ + D)⁻¹ = D⁻¹ - D⁻¹ (C + D⁻¹)⁻¹ D⁻¹
        rest = mean - cho_solve(self._factor, mean, check_finite=False) / self._stiffness
        correction: Array = self._weight * rest[self._block]
        pressure -= correction
        return pressure
