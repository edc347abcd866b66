"""A volume on several ranks in one file, as `archive` writes it: layer by layer, rank by rank."""

from __future__ import annotations

import os
from functools import partial

from roughcontact import netcdf
from roughcontact.volume import archive
from roughcontact.volume.result import Array, ElastoplasticResult
from roughcontact.volume.shared_body import SharedBody


def save(result: ElastoplasticResult, path: str | os.PathLike[str]) -> None:
    """Write a result whose layers lie on several ranks to one NetCDF file; all of them call it.

    Parameters
    ----------
    result : ElastoplasticResult
        With the layers of this rank.
    path : str or path
        File to write, by the first rank; the others need not see it.

    Raises
    ------
    InputError
        If the suffix is not ``.nc``.
    OSError
        If the file cannot be written, on all ranks; an old file survives.
    """
    names = archive.yielding(result.solution)
    bodies = [body for body in result.bodies if isinstance(body, SharedBody)]
    maps = {
        netcdf.Streamed(
            f"{name}_{field}", own.dtype.str, (body.thickness.size, *own.shape[1:]), about,
            packed=True, dims=dims,
        ): [
            netcdf.Part(layer % body.share.count, 1, partial(_layer, body, own, layer))
            for layer in range(body.thickness.size)
        ]
        for name, body in zip(names, bodies, strict=True)
        for field, (dims, about) in archive.described().items()
        for own in (getattr(body.own, field),)
    }  # fmt: skip
    netcdf.write_shared(lambda: archive.to_dataset(result)[0], maps, path, bodies[0].share.ranks)


def _layer(body: SharedBody, own: Array, layer: int) -> Array:
    return own[[body.here.index(layer)]]
