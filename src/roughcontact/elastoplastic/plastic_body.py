"""Plastic strain and stress of a body that has yielded, layer by layer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.errors import InputError
from roughcontact.halfspace import tensors
from roughcontact.halfspace.volume_partition import DistributedPartition
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


# --- Plastic strain and stress of a body that has yielded, layer by layer ---


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


# --- A yielded body whose layers are distributed over several ranks ---


@dataclass(frozen=True, eq=False)
class SharedBody:
    """Body whose layers are distributed over several ranks; all values are global."""

    own: PlasticBody  # The layers of this rank
    share: DistributedPartition  # The ranks
    thickness: NDArray[np.float64]  # (nz,) Thickness of all layers [m]
    cells: NDArray[np.int64]  # (nz,) Number of pixels with plastic strain in each layer
    layers: LayerProfile  # Largest values of each layer below the map
    maximum_place: tuple[
        int, int, int
    ]  # Layer, row and column of the largest plastic strain below the map
    planes: tuple[tuple[Array, ...], tuple[Array, ...]]
    flowed_at_top: NDArray[np.bool_]  # (ny, nx)
    flowed_under: NDArray[np.bool_]  # (ny, nx)
    max_plastic_strain: float  # As of a `PlasticBody`
    max_von_mises: float  # As of a `PlasticBody`
    max_residual_von_mises: float  # As of a `PlasticBody`
    has_reached_rim: bool  # As of a `PlasticBody`
    has_reached_bottom: bool  # As of a `PlasticBody`
    flows_back: bool  # As of a `PlasticBody`

    @property
    def local_layers(self) -> range:
        """Local layers, by number."""
        return self.share.layers(self.thickness.size)

    @property
    def material(self) -> Material:
        """Material of the body."""
        return self.own.material

    @property
    def margin(self) -> int:
        """Rows and columns of the volume beyond each edge of the map."""
        return self.own.margin

    @property
    def depth(self) -> NDArray[np.float64]:
        """Depth of the middle of each layer [m], shape (nz,)."""
        return np.cumsum(self.thickness) - self.thickness / 2

    @property
    def plastic_volume(self) -> float:
        """Volume with plastic strain [m³]."""
        return float(self.cells @ self.thickness) * self.own.pixel_area

    @property
    def plastic_depth(self) -> float:
        """Depth that plastic strain reaches [m]: the lower face of its lowest layer."""
        layers = np.flatnonzero(self.cells)
        return float(self.thickness[: layers[-1] + 1].sum()) if layers.size else 0.0

    def largest_strain_index(self, inside: Window) -> tuple[int, int, int]:
        """Return layer, row and column of the largest plastic strain below the map."""
        return self.maximum_place

    def layer_profile(self, inside: Window) -> LayerProfile:
        """Return the largest values of each layer below the map."""
        return self.layers

    def depth_values(self, where: Place) -> tuple[Array, Array, Array, Array, Array]:
        """Return faces [m], accumulated strain, strength and both stresses [Pa] at pixels.

        Only the row and the column through the largest plastic strain are available.
        """
        (_, row, column), (y, x) = self.maximum_place, where
        faces = np.append(0.0, np.cumsum(self.thickness))
        if y == row + self.margin:
            item, two, three, four = (field[:, x] for field in self.planes[0])
        elif x == column + self.margin:
            item, two, three, four = (field[:, y] for field in self.planes[1])
        else:
            raise InputError(
                "of a volume on several ranks only the row and the column through the largest "
                f"plastic strain are kept, {row} and {column}; save the result as .nc, and read it "
                "in one process"
            )
        return faces, item, two, three, four


def gather_body(
    own: PlasticBody,
    share: DistributedPartition,
    thickness: NDArray[np.float64],
    shape: tuple[int, int],
) -> SharedBody:
    """Return the global view of a body from the layers of all ranks; all ranks call this."""
    layers = thickness.size
    inside = tuple(slice(own.margin, own.margin + points) for points in shape)
    window = inside[0], inside[1]
    here = own.layer_profile(window)

    def whole(values: Any) -> Array:
        return share.gather_layers(np.asarray(values), layers)

    profile = LayerProfile(
        np.append(0.0, np.cumsum(thickness)),
        *(
            whole(getattr(here, name))
            for name in (
                "plastic_fraction",
                "max_accumulated",
                "max_von_mises",
                "max_residual_von_mises",
            )
        ),
    )
    maximum = _most_strained(own, window, profile, whole)
    row, column = maximum[1] + own.margin, maximum[2] + own.margin
    rows, columns = (
        own.depth_values(where)[1:] for where in ((row, slice(None)), (slice(None), column))
    )
    lowest = share.layers(layers)[-1] == layers - 1
    top = own.flowed_at_top & (share.layers(layers)[0] == 0)
    under = own.flowed_under
    if share.count > 1:
        top, under = (share.ranks.allreduce(result.astype(np.int32)) > 0 for result in (top, under))
    return SharedBody(
        own=own,
        share=share,
        thickness=thickness,
        cells=whole(np.count_nonzero(own.accumulated, axis=(1, 2))),
        layers=profile,
        maximum_place=maximum,
        planes=(tuple(map(whole, rows)), tuple(map(whole, columns))),
        flowed_at_top=top,
        flowed_under=under,
        max_plastic_strain=share.largest(own.max_plastic_strain),
        max_von_mises=share.largest(own.max_von_mises),
        max_residual_von_mises=share.largest(own.max_residual_von_mises),
        has_reached_rim=share.any(own.has_reached_rim),
        has_reached_bottom=share.any(lowest and own.has_reached_bottom),
        flows_back=share.any(own.flows_back),
    )


def _most_strained(
    own: PlasticBody, window: Window, profile: LayerProfile, whole: Callable[[Any], Array]
) -> tuple[int, int, int]:
    """Return layer, row and column of the largest strain, or stress without any strain."""
    result = profile.max_accumulated
    values = own.accumulated[:, *window]
    if not result.any():
        result, values = profile.max_von_mises, own.von_mises[:, *window]
    first = values.reshape(len(values), -1).argmax(axis=1)
    layer = int(result.argmax())
    row, column = divmod(int(whole(first)[layer]), values.shape[2])
    return layer, row, column
