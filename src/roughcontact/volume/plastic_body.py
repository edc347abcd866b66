"""A body that has yielded: its plastic strain and stress, layer by layer."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.halfspace import tensors
from roughcontact.material.material import Material
from roughcontact.volume.profiles import LayerProfile

Array = NDArray[Any]
Window = tuple[slice, slice]
Place = tuple[int | slice, int | slice]

GUARD = 2
"""Rows and columns at the edge of the volume that plastic strain may not reach."""

# Share of the yield strength by which the iteration may miss it.
_ROUNDING = 1e-3


@dataclass(frozen=True, eq=False)
class PlasticBody:
    """Plastic strain and stress of one body; layers from its surface down.

    Tensors without trace have the components zz, (xx - yy)/2, xy, xz, yz, z into the body;
    `roughcontact.halfspace.tensors.tensor` makes matrices of them. Arrays are read-only.

    Parameters
    ----------
    material : Material
        Of the body.
    pixel_area : float
        Area of a pixel [m²].
    margin : int
        Rows and columns of the volume beyond each edge of the map, included in the arrays.
    thickness : ndarray, shape (nz,)
        Thickness of each layer [m].
    plastic_strain : ndarray, shape (nz, 5, ny, nx)
        Plastic strain, constant over each layer.
    accumulated : ndarray, shape (nz, ny, nx)
        Accumulated plastic strain e = ∫ √(2/3 dε:dε).
    stress, mean_stress : ndarray, shapes (nz, 5, ny, nx) and (nz, ny, nx)
        Deviator and a third of the trace of the stress under load, averages over the layers [Pa].
    residual_stress, mean_residual_stress : ndarray
        Those by the plastic strain alone [Pa]: what the load leaves when it is gone, unless the
        body flows again on unloading.
    """

    material: Material
    pixel_area: float
    margin: int
    thickness: NDArray[np.float64]
    plastic_strain: Array
    accumulated: Array
    stress: Array
    mean_stress: Array
    residual_stress: Array
    mean_residual_stress: Array

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    @property
    def depth(self) -> NDArray[np.float64]:
        """Depth of the middle of each layer [m], shape (nz,)."""
        middle: NDArray[np.float64] = np.cumsum(self.thickness) - self.thickness / 2
        return middle

    @property
    def von_mises(self) -> Array:
        """Von Mises stress under load [Pa], shape (nz, ny, nx)."""
        return tensors.equivalent(self.stress.swapaxes(0, 1))

    @property
    def residual_von_mises(self) -> Array:
        """Von Mises stress by the plastic strain alone [Pa], shape (nz, ny, nx)."""
        return tensors.equivalent(self.residual_stress.swapaxes(0, 1))

    @property
    def elastic_stress(self) -> Array:
        """Deviator of the stress by the pressure alone [Pa], shape (nz, 5, ny, nx)."""
        elastic: Array = self.stress - self.residual_stress
        return elastic

    @cached_property
    def max_plastic_strain(self) -> float:
        """Largest accumulated plastic strain."""
        return float(self.accumulated.max())

    @cached_property
    def plastic_volume(self) -> float:
        """Volume with plastic strain [m³]."""
        cells = np.count_nonzero(self.accumulated, axis=(1, 2))
        return float(cells @ self.thickness) * self.pixel_area

    @cached_property
    def plastic_depth(self) -> float:
        """Depth that plastic strain reaches [m]: the lower face of its lowest layer."""
        layers = np.flatnonzero(self.accumulated.any(axis=(1, 2)))
        return float(self.thickness[: layers[-1] + 1].sum()) if layers.size else 0.0

    @cached_property
    def max_von_mises(self) -> float:
        """Largest von Mises stress under load [Pa]."""
        return float(self.von_mises.max())

    @cached_property
    def max_residual_von_mises(self) -> float:
        """Largest von Mises stress by the plastic strain alone [Pa]."""
        return float(self.residual_von_mises.max())

    @property
    def flowed_at_top(self) -> NDArray[np.bool_]:
        """Where the uppermost layer has flowed, shape (ny, nx)."""
        return np.asarray(self.accumulated[0] > 0)

    @property
    def flowed_under(self) -> NDArray[np.bool_]:
        """Where any layer has flowed, shape (ny, nx)."""
        return np.asarray(self.accumulated.any(axis=0))

    @property
    def at_bottom(self) -> bool:
        """Whether plastic strain has reached the lowest layer."""
        return bool(self.accumulated[-1].any())

    @property
    def at_rim(self) -> bool:
        """Whether plastic strain has come to the outer rows and columns of the volume."""
        rim = np.ones(self.accumulated.shape[1:], bool)
        rim[GUARD:-GUARD, GUARD:-GUARD] = False
        return bool(self.accumulated[:, rim].any())

    @property
    def flows_back(self) -> bool:
        """Whether the residual stress passes the yield strength."""
        strength = self.material.law.strength(self.accumulated)
        return bool((self.residual_von_mises > (1 + _ROUNDING) * strength).any())

    def most_strained(self, inside: Window) -> tuple[int, int, int]:
        """Return layer, row and column of the largest plastic strain in a window of rows, columns.

        Counted from the window; those of the largest von Mises stress where nothing has flowed.
        """
        values = self.accumulated[:, *inside]
        if not values.any():
            values = self.von_mises[:, *inside]
        layer, row, column = np.unravel_index(values.argmax(), values.shape)
        return int(layer), int(row), int(column)

    def of_layers(self, inside: Window) -> LayerProfile:
        """Return what each layer holds at most in a window of rows and columns."""
        accumulated, loaded, residual = (
            values[:, *inside]
            for values in (self.accumulated, self.von_mises, self.residual_von_mises)
        )
        return LayerProfile(
            np.append(0.0, np.cumsum(self.thickness)),
            (accumulated > 0).mean(axis=(1, 2)),
            *(values.max(axis=(1, 2)) for values in (accumulated, loaded, residual)),
        )

    def at(self, where: Place) -> tuple[Array, Array, Array, Array, Array]:
        """Return faces [m], accumulated strain, strength and both stresses [Pa] at some pixels.

        Parameters
        ----------
        where : (int or slice, int or slice)
            Rows and columns of the volume.
        """
        accumulated = self.accumulated[:, *where].copy()
        stress, residual = (
            tensors.tensor(np.moveaxis(deviator[:, :, *where], 1, 0), mean[:, *where])
            for deviator, mean in (
                (self.stress, self.mean_stress),
                (self.residual_stress, self.mean_residual_stress),
            )
        )
        faces = np.append(0.0, np.cumsum(self.thickness))
        return faces, accumulated, self.material.law.strength(accumulated), stress, residual
