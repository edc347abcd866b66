"""Real contact area of a map of pixels, and where its pressure acts."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from roughcontact.halfspace.boundary import Boundary

RIM_EXCESS = (math.pi - 1 + math.log(2)) / 24
"""By how many pixels each edge of an elastic rim makes a contact area too large."""


def at_edge(touching: NDArray[np.bool_], boundary: Boundary) -> bool:
    """Return whether a contact reaches an edge at which its map ends.

    Parameters
    ----------
    touching : ndarray of bool, shape (ny, nx)
        Pixels with pressure.
    boundary : Boundary
        Along which axes the map ends.
    """
    return any(bool(touching.take((0, -1), axis).any()) for axis in boundary.free_axes)


def edge_load(pressure: NDArray[np.float64], boundary: Boundary) -> float:
    """Return the share of the load on the outermost pixels along edges at which a map ends.

    Parameters
    ----------
    pressure : ndarray, shape (ny, nx)
        Contact pressure [Pa].
    boundary : Boundary
        Along which axes the map ends.
    """
    inner = pressure[
        tuple(slice(1, -1) if a in boundary.free_axes else slice(None) for a in (0, 1))
    ]
    total = float(pressure.sum())
    return max(1 - float(inner.sum()) / total, 0.0) if total else 0.0


def rim_excess(
    touching: NDArray[np.bool_], elastic: NDArray[np.bool_], boundary: Boundary
) -> float:
    """Return by how many pixels an elastic rim makes a contact area too large.

    Parameters
    ----------
    touching : ndarray of bool, shape (ny, nx)
        Pixels with pressure.
    elastic : ndarray of bool, shape (ny, nx)
        Those of them at whose rim the pressure falls to zero.
    boundary : Boundary
        Whether the map goes on beyond its edges.

    Returns
    -------
    float
        (π - 1 + ln 2)/24 times the edges between an elastic pixel and one that does not touch.

    References
    ----------
    Yastrebov, Anciaux and Molinari 2017, doi:10.1016/j.triboint.2017.04.023
    """
    return RIM_EXCESS * sum(
        rims(touching, elastic, axis, axis in boundary.periodic_axes) for axis in (0, 1)
    )


def rims(touching: NDArray[np.bool_], elastic: NDArray[np.bool_], axis: int, wrapped: bool) -> int:
    """Return the edges along an axis between an elastic pixel and one that does not touch.

    Parameters
    ----------
    touching, elastic : ndarray of bool, shape (ny, nx)
        As for `rim_excess`.
    axis : {0, 1}
        Along which pixels follow each other.
    wrapped : bool
        Whether the first follows the last.
    """
    beyond, elastic_beyond = np.roll(touching, -1, axis), np.roll(elastic, -1, axis)
    rim = (elastic & ~beyond) | (~touching & elastic_beyond)
    return int(np.count_nonzero(rim if wrapped else np.delete(rim, -1, axis)))


def centre_of_pressure(
    pressure: NDArray[np.float64], pixel: tuple[float, float]
) -> tuple[float, float]:
    """Return the point where the resultant of a pressure acts.

    Parameters
    ----------
    pressure : ndarray, shape (ny, nx)
        Contact pressure [Pa].
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].

    Returns
    -------
    (float, float)
        Its ``(y, x)`` from the centre of the map [m]; NaN without pressure.

    Examples
    --------
    >>> centre_of_pressure(np.array([[0.0, 1.0], [0.0, 3.0]]), (1e-6, 2e-6))
    (2.5e-07, 1e-06)
    """
    total = float(pressure.sum())
    if total == 0:
        return math.nan, math.nan
    y, x = (
        float(np.einsum("i,i->", np.arange(line.size) - (line.size - 1) / 2, line)) * edge / total
        for line, edge in zip((pressure.sum(axis=1), pressure.sum(axis=0)), pixel, strict=True)
    )
    return y, x
