"""What a body holds over its depth: below a point, on a vertical plane, layer by layer.

Coordinates are those of the map, counted from its corner; rows and columns that the volume has
beyond the map are left out. Strain and stress are averages over a layer, at the centre of a pixel.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.halfspace import tensors

Array = NDArray[Any]


@dataclass(frozen=True, eq=False)
class DepthProfile:
    """Plastic strain and stress over the depth below one point.

    Parameters
    ----------
    point : (int, int)
        Row and column on the map.
    place : (float, float)
        Its coordinates (y, x) [m].
    faces : ndarray, shape (nz + 1,)
        Depths of the faces of the layers [m], from 0 on.
    accumulated : ndarray, shape (nz,)
        Accumulated plastic strain.
    strength : ndarray, shape (nz,)
        Yield strength at that strain [Pa].
    stress, residual_stress : ndarray, shape (nz, 3, 3)
        Stress under load, and that by the plastic strain alone [Pa]; axes x, y, z, tension is
        positive.
    """

    point: tuple[int, int]
    place: tuple[float, float]
    faces: NDArray[np.float64]
    accumulated: Array
    strength: Array
    stress: Array
    residual_stress: Array

    @property
    def depth(self) -> NDArray[np.float64]:
        """Depth of the middle of each layer [m], shape (nz,)."""
        return _middles(self.faces)

    @property
    def von_mises(self) -> Array:
        """Von Mises stress under load [Pa], shape (nz,)."""
        return _von_mises(self.stress)

    @property
    def residual_von_mises(self) -> Array:
        """Von Mises stress by the plastic strain alone [Pa], shape (nz,)."""
        return _von_mises(self.residual_stress)


@dataclass(frozen=True, eq=False)
class DepthSection:
    """Plastic strain and stress on a vertical plane along a row or a column of the map.

    Parameters
    ----------
    along : {"x", "y"}
        The horizontal axis of the plane.
    index : int
        The row that it follows, or the column with ``along="y"``.
    across : float
        Where the plane lies on the other axis [m].
    edges : ndarray, shape (n + 1,)
        Edges of the pixels along the plane [m].
    faces : ndarray, shape (nz + 1,)
        Depths of the faces of the layers [m], from 0 on.
    pressure, residual_displacement : ndarray, shape (n,)
        On the surface above: pressure [Pa], and what plastic strain adds to the gap [m].
    accumulated : ndarray, shape (nz, n)
        Accumulated plastic strain.
    strength : ndarray, shape (nz, n)
        Yield strength at that strain [Pa].
    stress, residual_stress : ndarray, shape (nz, n, 3, 3)
        Stress under load, and that by the plastic strain alone [Pa]; axes x, y, z, tension is
        positive.
    """

    along: str
    index: int
    across: float
    edges: NDArray[np.float64]
    faces: NDArray[np.float64]
    pressure: NDArray[np.float64]
    residual_displacement: NDArray[np.float64]
    accumulated: Array
    strength: Array
    stress: Array
    residual_stress: Array

    @property
    def place(self) -> NDArray[np.float64]:
        """Centres of the pixels along the plane [m], shape (n,)."""
        return _middles(self.edges)

    @property
    def depth(self) -> NDArray[np.float64]:
        """Depth of the middle of each layer [m], shape (nz,)."""
        return _middles(self.faces)

    @property
    def von_mises(self) -> Array:
        """Von Mises stress under load [Pa], shape (nz, n)."""
        return _von_mises(self.stress)

    @property
    def residual_von_mises(self) -> Array:
        """Von Mises stress by the plastic strain alone [Pa], shape (nz, n)."""
        return _von_mises(self.residual_stress)


@dataclass(frozen=True, eq=False)
class LayerProfile:
    """What each layer below the map holds at most.

    Parameters
    ----------
    faces : ndarray, shape (nz + 1,)
        Depths of the faces of the layers [m], from 0 on.
    plastic_fraction : ndarray, shape (nz,)
        Share of the layer that has plastic strain.
    max_accumulated : ndarray, shape (nz,)
        Largest accumulated plastic strain.
    max_von_mises, max_residual_von_mises : ndarray, shape (nz,)
        Largest von Mises stress under load, and of that by the plastic strain alone [Pa].
    """

    faces: NDArray[np.float64]
    plastic_fraction: NDArray[np.float64]
    max_accumulated: Array
    max_von_mises: Array
    max_residual_von_mises: Array

    @property
    def depth(self) -> NDArray[np.float64]:
        """Depth of the middle of each layer [m], shape (nz,)."""
        return _middles(self.faces)


def _middles(edges: NDArray[np.float64]) -> NDArray[np.float64]:
    middles: NDArray[np.float64] = (edges[1:] + edges[:-1]) / 2
    return middles


def _von_mises(tensor: Array) -> Array:
    return tensors.equivalent(tensors.components(tensor))
