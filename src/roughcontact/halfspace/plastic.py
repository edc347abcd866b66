"""The elastic half-space with plastic strain, free or periodic: strain and pressure in, stress out.

The operators of a periodic half-space are those of `layers`; how an infinite surface differs from
a periodic one is the task of `images`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact.errors import InputError, require_pixel, require_positive
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.fft import Workspace
from roughcontact.halfspace.images import Images, coarse_grid, periods
from roughcontact.halfspace.layers import NO_PULL, Array, Fill, Layers, Pull, Visit
from roughcontact.halfspace.shares import Share


class HalfSpace:
    """A half-space that deforms plastically: strain and pressure in, displacement and stress out.

    Parameters
    ----------
    shape : (int, int)
        Grid points ``(ny, nx)`` of the surface.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    thickness : array_like, shape (nz,)
        Thickness of each layer [m], from the surface down; the body is elastic below.
    shear_modulus : float
        μ [Pa].
    poisson : float
        ν.
    boundary : {"free", "periodic"}
        Whether the map is all there is, or one period of an endless surface.
    workspace : Workspace, optional
        Threads to use instead of new ones.
    precision : {"double", "single"}
        Arithmetic of transforms and sweeps.
    share : Share, optional
        As for `Layers`.

    Raises
    ------
    InputError
        If an argument is not positive and finite, or the choice is unknown.

    Notes
    -----
    With a free boundary the map is padded with zeros to 1.5 times its edges. What its
    periodic images still add, which falls with the third power of the period and varies on its
    scale, is removed by the difference of two operators on coarse cells and coarse layers, one
    of the same period and one of six times the edge of the map, both of long waves only.
    Restriction is the transpose of the interpolation, which keeps the symmetries.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        pixel: tuple[float, float],
        thickness: ArrayLike,
        *,
        shear_modulus: float,
        poisson: float,
        boundary: str = "free",
        workspace: Workspace | None = None,
        precision: str = "double",
        share: Share | None = None,
    ) -> None:
        require_pixel(pixel)
        require_positive(shear_modulus=shear_modulus)
        layers = np.asarray(thickness, np.float64)
        if layers.ndim != 1 or not layers.size or not (layers > 0).all():
            raise InputError(
                f"must be a row of positive numbers [m], got {thickness!r}",
                argument="thickness",
                value=thickness,
            )
        boundary = Boundary(boundary)
        boundary.require_volume()
        self.shape, self.thickness = shape, layers
        self.workspace = workspace or Workspace()
        free = not boundary.periodic_axes
        padded = shape
        self._images: Images | None = None
        if free:
            coarse, cells = coarse_grid(shape)
            near, far = periods(shape, coarse, cells)
            padded = near[0] * coarse, near[1] * coarse
        self._fine = Layers(
            shape, pixel, layers, float(shear_modulus), float(poisson), padded,
            isolated=free, workspace=self.workspace, precision=precision, share=share,
        )  # fmt: skip
        self.real = self._fine.real
        if free:
            self._images = Images(self._fine, pixel, coarse, cells, near, far, precision)

    def displacement(self, fill: Fill, *, trace: bool = False) -> NDArray[np.float64]:
        """Take in a plastic strain and return the surface displacement that it causes.

        Parameters
        ----------
        fill, trace
            As for `Layers.displacement`.

        Returns
        -------
        ndarray, shape (ny, nx)
            Normal displacement [m], positive into the body.
        """
        if self._images is None:
            return self._fine.displacement(fill, trace=trace)
        self._images.clear()
        displacement = self._fine.displacement(fill, trace=trace, see=self._images.take)
        return displacement + self._images.displacement(trace=trace)

    def stress(self, pressure: Array, visit: Visit, pull: Pull = NO_PULL) -> None:
        """Show the deviator of the stress, layer by layer; see `Layers.stress`."""
        images = self._images
        if images is None:
            self._fine.stress(pressure, visit, pull)
            return
        images.stress(pressure, pull)

        def corrected(layer: int, stress: Array) -> None:
            for component in range(5):
                stress[component] += images.on_layer(layer, component)
            visit(layer, stress)

        self._fine.stress(pressure, corrected, pull)

    def mean_stress(self, pressure: Array, visit: Visit, pull: Pull = NO_PULL) -> None:
        """Show the mean stress, layer by layer, after ``displacement(..., trace=True)``."""
        images = self._images
        if images is None:
            self._fine.mean_stress(pressure, visit, pull)
            return
        images.mean_stress(pressure, pull)
        self._fine.mean_stress(
            pressure, lambda layer, mean: visit(layer, mean + images.on_layer(layer, 0)), pull
        )


def points_transformed(shape: tuple[int, int], boundary: str) -> int:
    """Return the points of all periods in which a `HalfSpace` transforms a layer.

    Parameters
    ----------
    shape : (int, int)
        Grid points ``(ny, nx)`` of the surface.
    boundary : {"free", "periodic"}
        As for `HalfSpace`.

    Returns
    -------
    int
        Points; those of the coarse grids of a free boundary too, as if it had all the layers.
    """
    if not Boundary(boundary).free_axes:
        return shape[0] * shape[1]
    coarse, cells = coarse_grid(shape)
    near, far = periods(shape, coarse, cells)
    return near[0] * near[1] * (coarse**2 + 1) + far[0] * far[1]
