"""Real contact area of a map of pixels, and where its pressure acts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughcontact.contact.pair import Pair
from roughcontact.halfspace.boundary import Boundary

RIM_EXCESS = (math.pi - 1 + math.log(2)) / 24
"""By how many pixels each edge of an elastic rim makes a contact area too large."""


@dataclass(frozen=True)
class Totals:
    """Numbers of a contact that need all pixels of the map, counted once.

    Parameters
    ----------
    points : int
        Pixels that are there.
    contact, saturated : int
        Pixels with pressure, and those at the ceiling.
    rims : int
        Edges between an elastic pixel and one that does not touch.
    max_pressure : float
        Largest pressure [Pa].
    mean_gap : float
        Mean open gap [m].
    max_indentation : float
        Largest permanent indentation of a saturated pixel [m].
    edge_load : float or None
        Share of the load along the edges at which the map ends; None where no pixel there touches.
    """

    points: int
    contact: int
    saturated: int
    rims: int
    max_pressure: float
    mean_gap: float
    max_indentation: float
    edge_load: float | None


def totals(
    pair: Pair,
    pressure: NDArray[np.float64],
    gap: NDArray[np.float64],
    ceiling: float | NDArray[np.float64] | None,
) -> Totals:
    """Count over all pixels of a map; all processes that hold it call this.

    Parameters
    ----------
    pair : Pair
        The bodies, with the map or the rows of it that this process holds.
    pressure, gap : ndarray, shape (rows, nx)
        Of the rows of this process [Pa], [m].
    ceiling : float, ndarray of shape (rows, nx), or None
        Largest pressure allowed [Pa].
    """
    sums, touching = pair.sums, pressure > 0
    saturated = pressure >= (math.inf if ceiling is None else ceiling)
    points = sums.count(~np.isnan(gap))
    return Totals(
        points=points,
        contact=sums.count(touching),
        saturated=sums.count(saturated),
        rims=_rims(pair, touching, touching & ~saturated),
        max_pressure=sums.largest(pressure, least=0.0),
        mean_gap=sums.total(np.fmax(gap, 0)) / points,
        max_indentation=max(0.0, -sums.smallest(gap[saturated], most=0.0)),
        edge_load=_edge_load(pair, pressure),
    )


def _rims(pair: Pair, touching: NDArray[np.bool_], elastic: NDArray[np.bool_]) -> int:
    """Count the rims, those towards the first row of the next process included."""
    wrapped = pair.boundary.periodic_axes
    found = rims(touching, elastic, 1, 1 in wrapped)
    found += rims(touching, elastic, 0, False)
    beyond = pair.sums.following(np.stack([touching[0], elastic[0]]))
    if pair.rows.stop < pair.shape[0] or 0 in wrapped:
        pairs = np.stack([[touching[-1], elastic[-1]], beyond], axis=1)
        found += rims(pairs[0], pairs[1], 0, False)
    return int(pair.sums.total(np.array(found)))


def _edge_load(pair: Pair, pressure: NDArray[np.float64]) -> float | None:
    sums, rows, free = pair.sums, pair.rows, pair.boundary.free_axes
    if not free:
        return None
    first, last = rows.start == 0, rows.stop == pair.shape[0]
    inner = pressure[
        int(0 in free and first) : len(pressure) - int(0 in free and last),
        slice(1, -1) if 1 in free else slice(None),
    ]
    if sums.count(inner > 0) == sums.count(pressure > 0):
        return None
    return max(1 - sums.total(inner) / sums.total(pressure), 0.0)


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
