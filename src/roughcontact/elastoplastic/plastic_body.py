"""Plastic strain and stress of a body that has yielded, layer by layer."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.halfspace import tensors
from roughcontact.material.material import Material

Array = NDArray[Any]


class _Layers:
    """Layers from the surface down."""

    faces: NDArray[np.float64]

    @property
    def depth(self) -> NDArray[np.float64]:
        """Depth of the middle of each layer [m], shape (nz,)."""
        return _layer_centers(self.faces)


class _Stresses(_Layers):
    stress: Array
    residual_stress: Array

    @property
    def von_mises(self) -> Array:
        """Von Mises stress under load [Pa], a value for each tensor."""
        return tensors.equivalent(tensors.components(self.stress))

    @property
    def residual_von_mises(self) -> Array:
        """Von Mises stress by the plastic strain alone [Pa], a value for each tensor."""
        return tensors.equivalent(tensors.components(self.residual_stress))


@dataclass(frozen=True, eq=False)
class DepthProfile(_Stresses):
    """Plastic strain and stress over the depth below a point."""

    point: tuple[int, int]  # Row and column on the map
    place: tuple[float, float]  # Coordinates (y, x) of the point [m]
    faces: NDArray[np.float64]  # (nz + 1,) Depths of the faces of the layers [m], from 0 on
    accumulated: Array  # (nz,) Accumulated plastic strain
    strength: Array  # (nz,) Yield strength at that strain [Pa]
    stress: Array  # (nz, 3, 3) Stress under load [Pa]
    residual_stress: Array  # (nz, 3, 3) Stress by the plastic strain alone [Pa]


@dataclass(frozen=True, eq=False)
class DepthSection(_Stresses):
    """Plastic strain and stress on a vertical plane along a row or a column of the map."""

    along: str  # Horizontal axis of the plane
    index: int  # Row of the plane, or column with `along="y"`
    across: float  # Coordinate of the plane on the other axis [m]
    edges: NDArray[np.float64]  # (n + 1,) Edges of the pixels along the plane [m]
    faces: NDArray[np.float64]  # (nz + 1,) Depths of the faces of the layers [m], from 0 on
    pressure: NDArray[np.float64]  # (n,) Contact pressure [Pa]
    residual_displacement: NDArray[np.float64]  # (n,) Residual displacement [m]
    accumulated: Array  # (nz, n) Accumulated plastic strain
    strength: Array  # (nz, n) Yield strength at that strain [Pa]
    stress: Array  # (nz, n, 3, 3) Stress under load [Pa]
    residual_stress: Array  # (nz, n, 3, 3) Stress by the plastic strain alone [Pa]

    @property
    def place(self) -> NDArray[np.float64]:
        """Centers of the pixels along the plane [m], shape (n,)."""
        return _layer_centers(self.edges)


@dataclass(frozen=True, eq=False)
class LayerProfile(_Layers):
    """Largest values of each layer below the map."""

    faces: NDArray[np.float64]  # (nz + 1,) Depths of the faces of the layers [m], from 0 on
    plastic_fraction: NDArray[np.float64]  # (nz,) Share of the layer with plastic strain
    max_accumulated: Array  # (nz,) Largest accumulated plastic strain
    max_von_mises: Array  # (nz,) Largest von Mises stress under load [Pa]
    max_residual_von_mises: Array  # (nz,) Same by the plastic strain alone [Pa]


def _layer_centers(edges: NDArray[np.float64]) -> NDArray[np.float64]:
    return (edges[1:] + edges[:-1]) / 2


Window = tuple[slice, slice]
Place = tuple[int | slice, int | slice]

GUARD = 2
"""Rows and columns at the edge of the volume that must stay free of plastic strain."""

# Tolerance of the stress after the iteration, over the yield strength.
_ROUNDING = 1e-3


@dataclass(frozen=True, eq=False)
class PlasticBody:
    """Plastic strain and stress of a body, in layers from the surface down."""

    material: Material  # Material of the body
    pixel_area: float  # Area of a pixel [m²]
    margin: int
    thickness: NDArray[np.float64]  # (nz,) Thickness of each layer [m]
    plastic_strain: Array  # (nz, 5, ny, nx) Plastic strain, constant over each layer
    accumulated: Array  # (nz, ny, nx) Accumulated plastic strain e = ∫ √(2/3 dε:dε)
    stress: Array  # (nz, 5, ny, nx) Deviator under load, mean over each layer [Pa]
    mean_stress: Array  # (nz, ny, nx) A third of the trace under load [Pa]
    residual_stress: Array  # (nz, 5, ny, nx) Deviator by the plastic strain alone [Pa]
    mean_residual_stress: Array  # (nz, ny, nx) A third of the trace without load [Pa]

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    @property
    def depth(self) -> NDArray[np.float64]:
        """Depth of the middle of each layer [m], shape (nz,)."""
        return np.cumsum(self.thickness) - self.thickness / 2

    @property
    def von_mises(self) -> Array:
        """Von Mises stress under load [Pa], shape (nz, ny, nx)."""
        return tensors.equivalent(self.stress.swapaxes(0, 1))

    @property
    def residual_von_mises(self) -> Array:
        """Von Mises stress by the plastic strain alone [Pa], shape (nz, ny, nx)."""
        return tensors.equivalent(self.residual_stress.swapaxes(0, 1))

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
        """Pixels with plastic strain in the uppermost layer, shape (ny, nx)."""
        return np.asarray(self.accumulated[0] > 0)

    @property
    def flowed_under(self) -> NDArray[np.bool_]:
        """Pixels with plastic strain in any layer, shape (ny, nx)."""
        return np.asarray(self.accumulated.any(axis=0))

    @property
    def has_reached_bottom(self) -> bool:
        """Whether plastic strain has reached the lowest layer."""
        return bool(self.accumulated[-1].any())

    @property
    def has_reached_rim(self) -> bool:
        """Whether plastic strain has reached the outer rows and columns of the volume."""
        rim = np.ones(self.accumulated.shape[1:], bool)
        rim[GUARD:-GUARD, GUARD:-GUARD] = False
        return bool(self.accumulated[:, rim].any())

    @property
    def flows_back(self) -> bool:
        """Whether the residual stress exceeds the yield strength."""
        strength = self.material.law.strength(self.accumulated)
        return bool((self.residual_von_mises > (1 + _ROUNDING) * strength).any())

    def largest_strain_index(self, inside: Window) -> tuple[int, int, int]:
        """Return layer, row and column of the largest plastic strain in a window.

        Without plastic strain in the window: of the largest von Mises stress.
        """
        values = self.accumulated[:, *inside]
        if not values.any():
            values = self.von_mises[:, *inside]
        layer, row, column = np.unravel_index(values.argmax(), values.shape)
        return int(layer), int(row), int(column)

    def layer_profile(self, inside: Window) -> LayerProfile:
        """Return the largest values of each layer in a window of rows and columns."""
        accumulated, loaded, residual = (
            values[:, *inside]
            for values in (self.accumulated, self.von_mises, self.residual_von_mises)
        )
        return LayerProfile(
            np.append(0.0, np.cumsum(self.thickness)),
            (accumulated > 0).mean(axis=(1, 2)),
            *(values.max(axis=(1, 2)) for values in (accumulated, loaded, residual)),
        )

    def depth_values(self, where: Place) -> tuple[Array, Array, Array, Array, Array]:
        """Return faces [m], accumulated strain, strength and both stresses [Pa] at pixels."""
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
