"""A run on its way: what the next point of a path starts from, in memory and on disk."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact import netcdf
from roughcontact.contact import archive as contact_archive
from roughcontact.volume.archive import add_increments, increments_of
from roughcontact.volume.extent import Extent
from roughcontact.volume.result import ElastoplasticResult, Increment

Array = NDArray[Any]

_BODY = ("places", "strain", "accumulated")


@dataclass(frozen=True, eq=False)
class Going:
    """What the next point of a path starts from.

    Parameters
    ----------
    extent : Extent
        The volume.
    bodies : list of (ndarray, ndarray)
        Plastic strain, shape (nz, 5, ny, nx), and accumulated, shape (nz, ny, nx), of each body
        that yields.
    pressure : ndarray
        On the map [Pa].
    increments : tuple of Increment
        Those so far.
    largest : (float, ndarray or None)
        Largest load so far [N], and its pressure if the path came down from it.
    seconds : float
        Time that it took to come here.
    carried : mapping of ndarray
        What `Loop.carried` gave, if that is known.
    result : ElastoplasticResult, optional
        The state itself, where it is held whole.
    """

    extent: Extent
    bodies: list[tuple[Array, Array]]
    pressure: Array
    increments: tuple[Increment, ...]
    largest: tuple[float, Array | None] = (0.0, None)
    seconds: float = 0.0
    carried: Mapping[str, Array] = field(default_factory=dict)
    result: ElastoplasticResult | None = None

    @classmethod
    def of(cls, result: ElastoplasticResult, carried: Mapping[str, Array] | None = None) -> Going:
        """Return what goes on from a result, and from what the loop carried with it."""
        bodies = [(body.plastic_strain, body.accumulated) for body in result.whole_bodies]
        return cls(
            Extent.of(result), bodies, result.solution.pressure, result.increments, result.largest,
            result.seconds, carried or {}, result,
        )  # fmt: skip


def save(going: Going, path: str | os.PathLike[str]) -> None:
    """Write it to a NetCDF file: of the volume only what has yielded, and no stress.

    Parameters
    ----------
    going : Going
        What the next point starts from.
    path : str or path
        The file; an old one is replaced when the new one is complete.
    """
    import xarray

    dataset = xarray.Dataset()
    arrays = {
        "thickness": going.extent.thickness,
        "grid": np.array(going.bodies[0][1].shape[1:]),
        "pressure": going.pressure,
    }
    if going.largest[1] is not None:
        arrays["largest_pressure"] = going.largest[1]
    for number, (strain, accumulated) in enumerate(going.bodies):
        places = np.flatnonzero(accumulated)
        by_component = np.moveaxis(strain, 1, 0).reshape(5, -1)
        held = places, by_component[:, places], accumulated.ravel()[places]
        arrays |= {f"{name}_{number}": part for name, part in zip(_BODY, held, strict=True)}
    arrays |= {f"carried_{name}": array for name, array in going.carried.items()}
    for name, array in arrays.items():
        # HDF5 is left alone with arrays without numbers.
        if array.size:
            dataset[name] = ([f"{name}_{axis}" for axis in range(array.ndim)], array)
    add_increments(dataset, going.increments)
    dataset.attrs = {
        "margin": going.extent.margin,
        "largest_load": going.largest[0],
        "seconds": going.seconds,
        "bodies": len(going.bodies),
    }
    netcdf.write(dataset, path)


def load(path: Path) -> Going:
    """Read what `save` wrote; every number keeps its bits.

    Parameters
    ----------
    path : Path
        The file.

    Raises
    ------
    FormatError
        If it is damaged, or no such file.
    """
    dataset = contact_archive.opened(path)
    with contact_archive.refused(path, "solve_elastoplastic"):
        arrays = {str(name): np.array(values) for name, values in dataset.data_vars.items()}
        thickness, shape = arrays["thickness"], tuple(arrays["grid"].tolist())
        bodies = []
        for number in range(int(dataset.attrs["bodies"])):
            strain = np.zeros((5, thickness.size * shape[0] * shape[1]))
            accumulated = np.zeros(strain.shape[1])
            if f"places_{number}" in arrays:
                places, yielded, amount = (arrays[f"{name}_{number}"] for name in _BODY)
                strain[:, places], accumulated[places] = yielded, amount
            whole = strain.reshape(5, thickness.size, *shape).swapaxes(0, 1)
            bodies.append((whole, accumulated.reshape(thickness.size, *shape)))
        prefix = "carried_"
        carried = {
            name.removeprefix(prefix): array
            for name, array in arrays.items()
            if name.startswith(prefix)
        }
        return Going(
            Extent(thickness, int(dataset.attrs["margin"])), bodies, arrays["pressure"],
            increments_of(dataset),
            (float(dataset.attrs["largest_load"]), arrays.get("largest_pressure")),
            float(dataset.attrs["seconds"]), carried,
        )  # fmt: skip
