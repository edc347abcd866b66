"""Tangential displacement of a half-space under tractions, both components at once.

Fields have the components (y, x). The operator follows the protocol of
`roughcontact.solvers.operator`, with two rows of values instead of one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array, Pixel, Shape
from roughcontact.halfspace import fft, kernels
from roughcontact.halfspace.boundary import Boundary, longer_side
from roughcontact.halfspace.convolution import BAND, SPECTRA, Convolution
from roughcontact.halfspace.fft import Workspace


class TangentialConvolution(Convolution):
    """Circular convolution of two-component fields with a symmetric kernel.

    Parameters
    ----------
    spectra : ndarray, shape (3, my//2 + 1, mx//2 + 1)
        Transforms of K_yy, K_xx, which are even, and of K_xy, which is odd in x and in y.
    shape, padded, **options
        As for `Convolution`.
    coarser : callable, optional
        ``coarser((ky, kx))`` returns the operator on pixels ``ky × kx`` times as large.
    """

    def __init__(
        self,
        spectra: NDArray[Any],
        shape: Shape,
        padded: Shape,
        coarser: Callable[[tuple[int, int]], TangentialConvolution] | None = None,
        **options: Any,
    ) -> None:
        super().__init__(spectra[0], shape, padded, **options)
        self._coarser = coarser
        other = Convolution(spectra[1], shape, padded, **options)
        self.spectra: NDArray[Any] = spectra.astype(self.real, copy=False)
        self.self_displacement = max(self.self_displacement, other.self_displacement)

    def _multiply(self, waves: list[NDArray[Any]], block: slice) -> None:
        """Multiply some columns of the waves of both fields by the spectra, in place."""
        symbols, half = self.spectra[:, :, block], self.spectra.shape[1]
        upper = slice(self.padded[0] - half, 0, -1)
        # The own terms are even in y; the mixed one is odd.
        for rows, part, sign in ((slice(half), slice(None), 1), (slice(half, None), upper, -1)):
            own_y, own_x, mixed = symbols[:, part]
            along_y, along_x = waves[0][rows], waves[1][rows]
            coupled = sign * mixed
            turned = coupled * along_y
            along_y *= own_y
            along_y += coupled * along_x
            along_x *= own_x
            along_x += turned

    def to_single_precision(self) -> TangentialConvolution:
        """Return the operator in single precision, with a shared buffer."""
        return TangentialConvolution(
            self.spectra,
            self.shape,
            self.padded,
            self._coarser,
            workspace=self.workspace,
            softness=self.softness,
            precision="single",
        )

    def coarser(self, times: tuple[int, int]) -> TangentialConvolution:
        """Return the operator on pixels ``times[0] × times[1]`` times as large."""
        assert self._coarser is not None
        return self._coarser(times)

    def approximate_inverse(self) -> TangentialConvolution:
        """Return ``displacement / K₀₀ → traction`` with little padding.

        See `Convolution.approximate_inverse`; the matrix of each wave is inverted.
        """
        period, waves = self.inverse_grid()
        own_y, own_x, mixed = (spectrum[np.ix_(*waves)] for spectrum in self.spectra)
        determinant = own_y * own_x - mixed**2
        still = (own_y <= 0) | (own_x <= 0) | (determinant <= 0)
        inverse = np.stack([own_x, own_y, -mixed]) / np.where(still, 1.0, determinant)
        softest = [1 / spectrum.max() for spectrum in self.spectra[:2]]
        inverse[:, still] = np.array([*softest, 0.0])[:, None]
        inverse *= self.self_displacement / self.softness
        return TangentialConvolution(
            inverse, self.shape, period, workspace=self.workspace, precision="single"
        )


def operator(
    boundary: Boundary,
    shape: Shape,
    pixel: Pixel,
    contact_modulus: float,
    poisson: float,
    workspace: Workspace | None = None,
) -> TangentialConvolution:
    """Return the operator ``traction → tangential displacement`` of a map or a profile.

    Parameters
    ----------
    boundary : Boundary
        Boundary condition: free or periodic along both axes; any for a profile.
    shape, pixel, contact_modulus
        As for `Boundary.operator`.
    poisson : float
        As for `kernels.cerruti`; without effect on a profile, whose traction acts in its plane.
    workspace : Workspace, optional
        Threads and memory to use instead of new ones.
    """
    work = workspace or Workspace()

    def coarser(times: tuple[int, int]) -> TangentialConvolution:
        (ny, nx), (dy, dx) = shape, pixel
        fewer = (-(-ny // times[0]), -(-nx // times[1]))
        larger = (dy * times[0], dx * times[1])
        return operator(boundary, fewer, larger, contact_modulus, poisson, work)

    if shape[0] == 1:
        datum = longer_side(shape, pixel)
        normal = boundary.operator(shape, pixel, contact_modulus, datum=datum, workspace=work)
        own = normal.spectrum
        return TangentialConvolution(
            np.stack([own, own, np.zeros_like(own)]),
            shape,
            normal.padded,
            coarser,
            workspace=work,
            softness=normal.softness,
        )
    if boundary == Boundary.PERIODIC:
        symbols = kernels.periodic_tangential(shape, pixel, contact_modulus, poisson)
        return TangentialConvolution(symbols, shape, shape, coarser, workspace=work)
    boundary.require_known_below("tangential loading")
    half = (fft.fast_length(shape[0]), fft.fast_length(shape[1]))
    edges = (1.0, pixel[1] / pixel[0])

    def make() -> Array:
        table = np.empty((3, half[0] + 1, half[1] + 1))

        def fill(top: int) -> None:
            rows = table[:, top : top + BAND]
            rows[...] = kernels.cerruti(rows.shape[1:], edges, 1.0, poisson, first_row=top)

        work.each(fill, range(0, table.shape[1], BAND))
        for part, odd in zip(table, (False, False, True), strict=True):
            fft.quadrant_spectrum(part, work, odd=odd)
        # Each of the two odd transforms has a factor i.
        table[2] *= -1
        return table

    return TangentialConvolution(
        SPECTRA.get(("cerruti", half, edges, poisson), make),
        shape,
        (2 * half[0], 2 * half[1]),
        coarser,
        workspace=work,
        softness=pixel[0] / contact_modulus,
    )
