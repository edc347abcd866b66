"""A volume on several ranks in one file, as `archive` writes it: layer by layer, rank by rank."""

from __future__ import annotations

import os
from collections.abc import Iterator

import numpy as np

from roughcontact import files, netcdf
from roughcontact.ranks import Ranks
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
    files.require_suffix(path, ".nc")
    bodies = [body for body in result.bodies if isinstance(body, SharedBody)]
    ranks = bodies[0].share.ranks
    ranks.agreed(lambda: _written(result, ranks, path) if ranks.first else _sent(bodies, ranks))


def _sent(bodies: list[SharedBody], ranks: Ranks) -> None:
    """Send the first rank what it asks for, until it has all or gives up."""
    for body in bodies:
        for field in archive.described():
            for layer in range(body.thickness.size):
                if not ranks.told(None):
                    return
                if layer in body.here:
                    part = getattr(body.own, field)[body.here.index(layer)]
                    ranks.sent_to_first(part, ranks.number)


def _written(result: ElastoplasticResult, ranks: Ranks, path: str | os.PathLike[str]) -> None:
    names = archive.yielding(result.solution)
    try:
        streamed = [
            netcdf.Streamed(
                f"{name}_{field}", own.dtype.str, (body.thickness.size, *own.shape[1:]),
                _layers(body, own, ranks), about, packed=True, dims=dims,
            )
            for name, body in zip(names, result.bodies, strict=True)
            if isinstance(body, SharedBody)
            for field, (dims, about) in archive.described().items()
            for own in (getattr(body.own, field),)
        ]  # fmt: skip
        netcdf.write_streamed(archive.to_dataset(result)[0], streamed, path)
    except BaseException:
        # The others wait to be asked for their layers.
        ranks.told(False)
        raise


def _layers(body: SharedBody, own: Array, ranks: Ranks) -> Iterator[Array]:
    """Yield the layers of a field, from the ranks that have them."""
    for layer in range(body.thickness.size):
        ranks.told(True)
        if layer in body.here:
            yield own[[body.here.index(layer)]]
        else:
            part = np.empty((1, *own.shape[1:]), own.dtype)
            yield ranks.sent_to_first(part, layer % ranks.count)
