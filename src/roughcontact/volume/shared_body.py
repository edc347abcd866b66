"""A body that has yielded and whose layers lie on several ranks: what is told of all of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.errors import InputError
from roughcontact.halfspace.shares import Shared
from roughcontact.material.material import Material
from roughcontact.volume.plastic_body import Array, Place, PlasticBody, Window
from roughcontact.volume.profiles import LayerProfile


@dataclass(frozen=True, eq=False)
class SharedBody:
    """A body whose layers lie on several ranks; all numbers are those of the whole of it.

    It tells what a `PlasticBody` does but for the fields, which stand in ``own``; planes are those
    through the point of the largest plastic strain.

    Parameters
    ----------
    own : PlasticBody
        The layers of this rank.
    share : Shared
        The ranks.
    thickness : ndarray, shape (nz,)
        Thickness of all layers [m].
    cells : ndarray of int, shape (nz,)
        Pixels of each layer that have flowed.
    layers : LayerProfile
        What each holds at most below the map.
    most : (int, int, int)
        Layer, row and column of the largest plastic strain below the map.
    planes : (ndarray, ndarray)
        Accumulated strain, strength, and both stresses on the row and on the column through it,
        whole rows and columns of the volume, each as a tuple.
    flowed_at_top, flowed_under : ndarray of bool, shape (ny, nx)
        Where the uppermost layer has flowed, and where any has.
    max_plastic_strain, max_von_mises, max_residual_von_mises, at_rim, at_bottom, flows_back
        As of a `PlasticBody`.
    """

    own: PlasticBody
    share: Shared
    thickness: NDArray[np.float64]
    cells: NDArray[np.int64]
    layers: LayerProfile
    most: tuple[int, int, int]
    planes: tuple[tuple[Array, ...], tuple[Array, ...]]
    flowed_at_top: NDArray[np.bool_]
    flowed_under: NDArray[np.bool_]
    max_plastic_strain: float
    max_von_mises: float
    max_residual_von_mises: float
    at_rim: bool
    at_bottom: bool
    flows_back: bool

    @property
    def here(self) -> range:
        """Which of the layers are on this rank."""
        return self.share.layers(self.thickness.size)

    @property
    def material(self) -> Material:
        """Of the body."""
        return self.own.material

    @property
    def margin(self) -> int:
        """Rows and columns of the volume beyond each edge of the map."""
        return self.own.margin

    @property
    def depth(self) -> NDArray[np.float64]:
        """Depth of the middle of each layer [m], shape (nz,)."""
        middle: NDArray[np.float64] = np.cumsum(self.thickness) - self.thickness / 2
        return middle

    @property
    def plastic_volume(self) -> float:
        """Volume with plastic strain [m³]."""
        return float(self.cells @ self.thickness) * self.own.pixel_area

    @property
    def plastic_depth(self) -> float:
        """Depth that plastic strain reaches [m]: the lower face of its lowest layer."""
        layers = np.flatnonzero(self.cells)
        return float(self.thickness[: layers[-1] + 1].sum()) if layers.size else 0.0

    def most_strained(self, inside: Window) -> tuple[int, int, int]:
        """Return layer, row and column of the largest plastic strain below the map."""
        return self.most

    def of_layers(self, inside: Window) -> LayerProfile:
        """Return what each layer holds at most below the map."""
        return self.layers

    def at(self, where: Place) -> tuple[Array, Array, Array, Array, Array]:
        """Return faces, accumulated strain, strength and both stresses at some pixels.

        Raises
        ------
        InputError
            If they do not lie on the row or the column through the largest plastic strain.
        """
        (_, row, column), (y, x) = self.most, where
        faces = np.append(0.0, np.cumsum(self.thickness))
        if y == row + self.margin:
            one, two, three, four = (field[:, x] for field in self.planes[0])
        elif x == column + self.margin:
            one, two, three, four = (field[:, y] for field in self.planes[1])
        else:
            raise InputError(
                "of a volume on several ranks only the row and the column through the largest "
                f"plastic strain are kept, {row} and {column}; save the result, and load it where "
                "it fits"
            )
        return faces, one, two, three, four


def gathered(
    own: PlasticBody, share: Shared, thickness: NDArray[np.float64], shape: tuple[int, int]
) -> SharedBody:
    """Return what all ranks tell of a body; all of them call it.

    Parameters
    ----------
    own : PlasticBody
        The layers of this rank.
    share : Shared
        The ranks.
    thickness : ndarray, shape (nz,)
        Thickness of all layers [m].
    shape : (int, int)
        Grid points of the map.
    """
    layers = thickness.size
    inside = tuple(slice(own.margin, own.margin + points) for points in shape)
    window = inside[0], inside[1]
    here = own.of_layers(window)

    def whole(values: Any) -> Array:
        return share.whole(np.asarray(values), layers)

    profile = LayerProfile(
        np.append(0.0, np.cumsum(thickness)),
        *(whole(getattr(here, name)) for name in (
            "plastic_fraction", "max_accumulated", "max_von_mises", "max_residual_von_mises")),
    )  # fmt: skip
    most = _most_strained(own, window, profile, whole)
    row, column = most[1] + own.margin, most[2] + own.margin
    rows, columns = (own.at(where)[1:] for where in ((row, slice(None)), (slice(None), column)))
    lowest = share.layers(layers)[-1] == layers - 1
    top = own.flowed_at_top & (share.layers(layers)[0] == 0)
    under = own.flowed_under
    if share.count > 1:
        top, under = (share.ranks.added(found.astype(np.int32)) > 0 for found in (top, under))
    return SharedBody(
        own=own,
        share=share,
        thickness=thickness,
        cells=whole(np.count_nonzero(own.accumulated, axis=(1, 2))),
        layers=profile,
        most=most,
        planes=(tuple(map(whole, rows)), tuple(map(whole, columns))),
        flowed_at_top=top,
        flowed_under=under,
        max_plastic_strain=share.largest(own.max_plastic_strain),
        max_von_mises=share.largest(own.max_von_mises),
        max_residual_von_mises=share.largest(own.max_residual_von_mises),
        at_rim=share.any(own.at_rim),
        at_bottom=share.any(lowest and own.at_bottom),
        flows_back=share.any(own.flows_back),
    )


def _most_strained(
    own: PlasticBody, window: Window, profile: LayerProfile, whole: Callable[[Any], Array]
) -> tuple[int, int, int]:
    """Return the first place, layer by layer, where the largest value of all layers is."""
    found = profile.max_accumulated
    values = own.accumulated[:, *window]
    if not found.any():
        found, values = profile.max_von_mises, own.von_mises[:, *window]
    first = values.reshape(len(values), -1).argmax(axis=1)
    layer = int(found.argmax())
    row, column = divmod(int(whole(first)[layer]), values.shape[2])
    return layer, row, column
