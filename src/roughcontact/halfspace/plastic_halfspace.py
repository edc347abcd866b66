"""Half-space with plastic strain and a free or a periodic boundary."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._tools.arrays import Pixel, Shape
from roughcontact.errors import input_error, require_pixel, require_positive
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.fft import Workspace, fast_length
from roughcontact.halfspace.layers import NO_PULL, Fill, PeriodicHalfSpace, Pull, Visit

Array = NDArray[Any]
Stress = Callable[[Array, Visit, Pull], None]

# Periods of the three transforms of a free boundary, over the edge of the map.
_NEAR_PERIOD_RATIO = 1.5
_FAR_PERIOD_RATIO = 6.0
# Maximum number of coarse cells along the shorter edge of the map; guard cells on each side, so
# that the interpolation stays central: extrapolation would make the operator indefinite.
_COARSE = 20
_GUARD = 2
# Minimum thickness of coarse layers over the shorter edge of coarse cells.
_COARSE_DEPTH = 0.5


class CoarseCells(NamedTuple):
    """Coarse grid of a map, and the near and the far period on it.

    The near period is a whole number of coarse cells, and the same on both grids.
    """

    points: int  # Points per coarse cell along an edge
    cells: tuple[int, int]  # Cells `(my, mx)` including guard cells
    near: tuple[int, int]  # Cells of the near period
    far: tuple[int, int]  # Cells of the far period

    @classmethod
    def from_shape(cls, shape: Shape) -> CoarseCells:
        """Return the coarse grid of a map."""
        coarse = -(-min(shape) // _COARSE)
        cells = [-(-n // coarse) + 2 * _GUARD for n in shape]
        near = [
            fast_length(max(cell, math.ceil(_NEAR_PERIOD_RATIO * n / coarse)))
            for n, cell in zip(shape, cells, strict=True)
        ]
        far = [fast_length(math.ceil(_FAR_PERIOD_RATIO * cell)) for cell in cells]
        return cls(coarse, (cells[0], cells[1]), (near[0], near[1]), (far[0], far[1]))


def _cubic(points: int, coarse: int, cells: int) -> NDArray[np.float64]:
    """Return the matrix of cubic Lagrange interpolation, shape (points, cells)."""
    # Positions of the points, in cells from the center of the first one.
    place = (np.arange(points) + 0.5) / coarse - 0.5 + _GUARD
    left = np.floor(place).astype(int)
    t = place - left
    weights = (
        -t * (t - 1) * (t - 2) / 6,
        (t + 1) * (t - 1) * (t - 2) / 2,
        -(t + 1) * t * (t - 2) / 2,
        (t + 1) * t * (t - 1) / 6,
    )
    matrix = np.zeros((points, cells))
    for offset, weight in zip((-1, 0, 1, 2), weights, strict=True):
        matrix[np.arange(points), left + offset] = weight
    return matrix


def _linear(fine: NDArray[np.float64], coarse: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the matrix (nz, mz) of interpolation between the centers of layers."""
    below = np.cumsum(coarse) - coarse / 2
    middle = np.cumsum(fine) - fine / 2
    left = np.clip(np.searchsorted(below, middle) - 1, 0, max(0, below.size - 2))
    matrix = np.zeros((fine.size, coarse.size))
    rows = np.arange(fine.size)
    if coarse.size == 1:
        matrix[:, 0] = 1
        return matrix
    share = (middle - below[left]) / (below[left + 1] - below[left])
    matrix[rows, left] = 1 - share
    matrix[rows, left + 1] = share
    return matrix


def _merge_layers(thickness: NDArray[np.float64], minimum: float) -> NDArray[np.float64]:
    """Return the thicknesses of merged layers, all but the last of at least ``minimum``."""
    merged, current = [], 0.0
    for layer in thickness:
        current += layer
        if current >= minimum:
            merged.append(current)
            current = 0.0
    if current:
        merged.append(current)
    return np.array(merged)


class Images:
    """Difference between an infinite and a periodic surface, on coarse cells."""

    def __init__(
        self, fine: PeriodicHalfSpace, pixel: Pixel, grid: CoarseCells, precision: str
    ) -> None:
        import scipy.sparse

        coarse, cells, near, far = grid
        workspace = fine._workspace
        self._workspace, self._fine = workspace, fine
        edges = pixel[0] * coarse, pixel[1] * coarse
        thickness = _merge_layers(fine.thickness, _COARSE_DEPTH * min(edges))
        arguments = (cells, edges, thickness, fine.body.shear_modulus, fine.body.poisson)
        more: dict[str, Any] = dict(
            isolated=True, workspace=workspace, precision=precision, smooth=True
        )
        self._near = PeriodicHalfSpace(*arguments, near, **more)
        self._far = PeriodicHalfSpace(*arguments, far, **more)
        matrix = scipy.sparse.csr_array
        self._up_y = matrix(_cubic(fine.shape[0], coarse, cells[0]).astype(fine.real))
        self._up_x = matrix(_cubic(fine.shape[1], coarse, cells[1]).astype(fine.real))
        self._down_y, self._down_x = self._up_y.T.tocsr(), self._up_x.T.tocsr()
        self._up_z = _linear(fine.thickness, thickness)
        # The transpose under the inner products of both grids: cells times thickness.
        self._down_z = (self._up_z * fine.thickness[:, None]).T / thickness[:, None] / coarse**2
        self._scale = 1 / coarse**2
        self._parts: Array = np.zeros((fine.thickness.size, 5, *cells), fine.real)
        self._strain: Array = np.zeros((thickness.size, 5, *cells), fine.real)
        self._stress = np.zeros_like(self._strain)
        self._cells = cells

    def clear(self) -> None:
        """Reset the strain."""
        self._parts[...] = 0

    def _restrict(self, values: Array) -> Array:
        halfway = self._down_y @ values
        return (self._down_x @ halfway.T).T

    def add_layer_strain(self, layer: int, strain: Array) -> None:
        """Restrict the strain of one layer to the coarse cells."""
        for component, values in enumerate(strain):
            self._parts[layer, component] = self._restrict(values)

    def displacement(self, *, trace: bool) -> Array:
        """Return the correction of the displacement by the restricted strain."""
        self._strain[...] = 0
        for layer in np.flatnonzero(self._parts.any(axis=(1, 2, 3))):
            part = self._parts[layer]
            for into in np.flatnonzero(self._down_z[:, layer]):
                self._strain[into] += self._down_z[into, layer] * part
        rows = slice(0, self._cells[0])

        def fill(layer: int, out: Array) -> slice | None:
            out[...] = self._strain[layer]
            return rows if self._strain[layer].any() else None

        far = self._far.displacement(fill, trace=trace)
        far -= self._near.displacement(fill, trace=trace)
        return self._prolong(far.astype(self._fine.real))

    def stress(self, pressure: Array, pull: Pull) -> None:
        """Compute the correction of the stress on the coarse layers."""
        self._subtract(self._far.stress, self._near.stress, self._stress, pressure, pull)

    def mean_stress(self, pressure: Array, pull: Pull) -> None:
        """Compute the correction of the mean stress on the coarse layers."""
        mean, (far, near) = self._stress[:, 0], (self._far.mean_stress, self._near.mean_stress)
        self._subtract(far, near, mean, pressure, pull)

    def _subtract(self, far: Stress, near: Stress, out: Array, pressure: Array, pull: Pull) -> None:
        """Write the stress of the far period minus that of the near period."""
        coarse = self._restrict(pressure.astype(self._fine.real)) * self._scale
        far(coarse, lambda layer, values: np.copyto(out[layer], values), pull)

        def subtract(layer: int, values: Array) -> None:
            out[layer] -= values

        near(coarse, subtract, pull)

    def layer_correction(self, layer: int, component: int) -> Array:
        """Return the correction on one fine layer."""
        weights = self._up_z[layer]
        near = np.flatnonzero(weights)
        coarse = np.einsum("z,zyx->yx", weights[near], self._stress[near, component])
        return self._prolong(coarse.astype(self._fine.real))

    def _prolong(self, coarse: Array) -> Array:
        halfway = self._up_y @ coarse
        return (self._up_x @ halfway.T).T


class PlasticHalfSpace:
    """Half-space with plastic strain: displacement and stress by strain and pressure.

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
        Whether the map is isolated, or one period of an infinite surface.
    workspace : Workspace, optional
        Threads to use instead of new ones.
    precision : {"double", "single"}
        Arithmetic of transforms and sweeps.

    Raises
    ------
    InputError
        If an argument is not positive and finite, or the choice is unknown.

    Notes
    -----
    With a free boundary the map is padded with zeros to 1.5 times its edges. The remaining effect
    of its periodic images, which falls with the third power of the period and varies on the scale
    of the period, is removed by the difference of two operators on coarse cells and coarse layers,
    one of the same period and one of six times the edge of the map, both of long waves only.
    Restriction is the transpose of the interpolation, which preserves the symmetries.
    """

    def __init__(
        self,
        shape: Shape,
        pixel: Pixel,
        thickness: ArrayLike,
        *,
        shear_modulus: float,
        poisson: float,
        boundary: str = "free",
        workspace: Workspace | None = None,
        precision: str = "double",
    ) -> None:
        require_pixel(pixel)
        require_positive(shear_modulus=shear_modulus)
        layers = np.asarray(thickness, np.float64)
        if layers.ndim != 1 or not layers.size or not (layers > 0).all():
            raise input_error("thickness", thickness, "must be a row of positive numbers [m]")
        boundary = Boundary(boundary)
        boundary.require_known_below("the volume model")
        self.shape, self.thickness = shape, layers
        self.workspace = workspace or Workspace()
        free = not boundary.periodic_axes
        padded = shape
        self._images: Images | None = None
        if free:
            grid = CoarseCells.from_shape(shape)
            padded = grid.near[0] * grid.points, grid.near[1] * grid.points
        self._fine = PeriodicHalfSpace(
            shape,
            pixel,
            layers,
            float(shear_modulus),
            float(poisson),
            padded,
            isolated=free,
            workspace=self.workspace,
            precision=precision,
        )
        self.real = self._fine.real
        if free:
            self._images = Images(self._fine, pixel, grid, precision)

    def displacement(self, fill: Fill, *, trace: bool = False) -> NDArray[np.float64]:
        """Set the plastic strain and return the surface displacement that it causes.

        Parameters
        ----------
        fill, trace
            As for `PeriodicHalfSpace.displacement`.

        Returns
        -------
        ndarray, shape (ny, nx)
            Normal displacement [m], positive into the body.
        """
        if self._images is None:
            return self._fine.displacement(fill, trace=trace)
        self._images.clear()
        displacement = self._fine.displacement(fill, trace=trace, see=self._images.add_layer_strain)
        return displacement + self._images.displacement(trace=trace)

    def stress(self, pressure: Array, visit: Visit, pull: Pull = NO_PULL) -> None:
        """Pass the deviator of the stress to a callback; see `PeriodicHalfSpace.stress`."""
        images = self._images
        if images is None:
            self._fine.stress(pressure, visit, pull)
            return
        images.stress(pressure, pull)

        def corrected(layer: int, stress: Array) -> None:
            for component in range(5):
                stress[component] += images.layer_correction(layer, component)
            visit(layer, stress)

        self._fine.stress(pressure, corrected, pull)

    def mean_stress(self, pressure: Array, visit: Visit, pull: Pull = NO_PULL) -> None:
        """Pass the mean stress to a callback, after ``displacement(..., trace=True)``."""
        images = self._images
        if images is None:
            self._fine.mean_stress(pressure, visit, pull)
            return
        images.mean_stress(pressure, pull)
        self._fine.mean_stress(
            pressure,
            lambda layer, mean: visit(layer, mean + images.layer_correction(layer, 0)),
            pull,
        )


def points_transformed(shape: Shape, boundary: str) -> int:
    """Return the number of points that a `PlasticHalfSpace` transforms per layer.

    Parameters
    ----------
    shape : (int, int)
        Grid points ``(ny, nx)`` of the surface.
    boundary : {"free", "periodic"}
        As for `PlasticHalfSpace`.

    Returns
    -------
    int
        Points, including the coarse grids of a free boundary as if these had all layers.
    """
    if not Boundary(boundary).free_axes:
        return shape[0] * shape[1]
    coarse, _, near, far = CoarseCells.from_shape(shape)
    return near[0] * near[1] * (coarse**2 + 1) + far[0] * far[1]
