"""A solved contact whose maps lie on several ranks, and what is counted over all of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from roughcontact._version import __version__
from roughcontact.contact import area
from roughcontact.contact.cautions import Caution, Kind, edge, noted, ordered, warned
from roughcontact.contact.loads import GivenLoad
from roughcontact.contact.pair import Pair
from roughcontact.contact.result import Regime, regime_of
from roughcontact.contact.slab import Slab
from roughcontact.errors import (
    Mention,
    Sentence,
    parts_of,
)
from roughcontact.halfspace.boundary import Boundary
from roughcontact.material.material import Material
from roughcontact.result import Result

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Totals:
    """What is counted over the whole map.

    Parameters
    ----------
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
    edge_load : float
        Share of the load along edges at which the map ends.
    """

    contact: int
    saturated: int
    rims: int
    max_pressure: float
    mean_gap: float
    max_indentation: float
    edge_load: float


@dataclass(frozen=True, eq=False)
class SlabResult(Result):
    """A solved contact whose maps lie on several ranks; all numbers are those of the whole map.

    Parameters
    ----------
    slab : Slab
        The rows of this rank.
    pair : Pair
        The bodies' materials and the boundary; its own surface stands for none.
    pressure, gap : ndarray, shape (rows, nx)
        Of the rows of this rank [Pa], [m]; as in `ContactResult`.
    totals : Totals
        What is counted over all ranks.
    ceiling, precision, tolerance, control, load, approach, certificate, load_error, status, \
iterations, convolutions, seconds, version, given
        As in `ContactResult`.
    communication : float
        Time that the ranks spent in communication and in waiting for each other, on average [s].
    sent : int
        Bytes that a rank sent to others in transforms, on average.
    """

    slab: Slab
    pair: Pair
    pressure: Array
    gap: Array
    totals: Totals
    ceiling: float | None
    precision: str
    tolerance: float
    control: str
    load: float
    approach: float
    certificate: float
    load_error: float
    status: str
    iterations: int
    convolutions: int
    seconds: float
    communication: float
    sent: int
    version: str = __version__
    given: GivenLoad | None = None

    tilt = (0.0, 0.0)
    moments = recommended = calibrated = None

    @property
    def converged(self) -> bool:
        """Whether certificate and load are within what was asked for."""
        return self.status == "converged"

    @property
    def boundary(self) -> Boundary:
        """What lies beyond the edges of the map."""
        return self.pair.boundary

    @property
    def material(self) -> Material:
        """Material of the body that was pressed."""
        return self.pair.material

    @property
    def counter_material(self) -> Material:
        """Material of the counter-body."""
        return self.pair.counter_material

    @property
    def contact_modulus(self) -> float:
        """E* [Pa]."""
        return self.pair.contact_modulus

    @property
    def shape(self) -> tuple[int, int]:
        """Grid points ``(ny, nx)`` of the whole map."""
        return self.slab.shape

    @property
    def nominal_area(self) -> float:
        """Area of the whole map [m²]."""
        return self.slab.size[0] * self.slab.size[1]

    @property
    def contact_area(self) -> float:
        """Real contact area [m²]."""
        return self.totals.contact * self.pair.pixel_area

    @property
    def corrected_contact_area(self) -> float:
        """Contact area without the excess that its elastic rim gains from the pixels [m²]."""
        excess = area.RIM_EXCESS * self.totals.rims
        return max(self.totals.contact - excess, 0.0) * self.pair.pixel_area

    @property
    def contact_fraction(self) -> float:
        """Contact area over the area of the whole map."""
        return self.totals.contact / math.prod(self.shape)

    @property
    def saturated_fraction(self) -> float:
        """Saturated area over the area of the whole map."""
        return self.totals.saturated / math.prod(self.shape)

    @property
    def max_pressure(self) -> float:
        """Largest pressure [Pa]."""
        return self.totals.max_pressure

    @property
    def mean_gap(self) -> float:
        """Mean open gap [m] over the points that are there."""
        return self.totals.mean_gap

    @property
    def regime(self) -> Regime:
        """How far the bodies are from elastic."""
        return regime_of(self.pair, self.max_pressure, self.totals.saturated > 0)

    @property
    def saturated(self) -> NDArray[np.bool_]:
        """Pixels of this rank whose pressure is at the ceiling."""
        return self.pressure >= (math.inf if self.ceiling is None else self.ceiling)

    @cached_property
    def cautions(self) -> tuple[Caution, ...]:
        """What a reader of the numbers has to know: what shows without a place for all maps."""
        told = [
            noted(
                Kind.RANKS,
                "the map lies on several ranks: what takes all of it in one place was not looked "
                "at, such as spots, slopes, spikes and its spectrum",
            )
        ]
        if self.totals.edge_load > 0:
            told.append(edge("map", self.totals.edge_load))
        if self.regime in (Regime.BEYOND_CEILING, Regime.BEYOND_HARDNESS):
            told.append(warned(Kind.BEYOND_CEILING, f"{self.regime}: give a ", Mention("ceiling")))
        return ordered(told)


def unsolved(result: SlabResult) -> Sentence:
    """Return how far a solver came that did not converge, and why it stopped."""
    return Sentence(
        f"not converged: certificate {result.certificate:.1e}, tolerance {result.tolerance:.0e}, "
        f"load error {result.load_error:.1e}; ",
        *parts_of(result.status),
    )


def totals_of(
    slab: Slab, boundary: Boundary, pressure: Array, gap: Array, limit: float | None
) -> Totals:
    """Count over the whole map.

    Parameters
    ----------
    slab : Slab
        The rows of this rank.
    boundary : Boundary
        What lies beyond the edges of the map.
    pressure, gap : ndarray, shape (rows, nx)
        Of the rows of this rank [Pa], [m].
    limit : float or None
        Ceiling [Pa].
    """
    sums, touching = slab.sums, pressure > 0
    saturated = pressure >= (math.inf if limit is None else limit)
    open_gap = np.fmax(gap, 0, where=~np.isnan(gap), out=np.zeros_like(gap))
    return Totals(
        contact=sums.count(touching),
        saturated=sums.count(saturated),
        rims=_rims(slab, boundary, touching, touching & ~saturated),
        max_pressure=sums.largest(pressure, least=0.0),
        mean_gap=sums.total(open_gap) / (math.prod(slab.shape) - slab.missing),
        max_indentation=max(-sums.smallest(gap[saturated], most=0.0), 0.0),
        edge_load=_edge_load(slab, boundary, pressure),
    )


def _rims(
    slab: Slab,
    boundary: Boundary,
    touching: NDArray[np.bool_],
    elastic: NDArray[np.bool_],
) -> int:
    """Count the rims, those towards the first row of the next rank included."""
    along_x = area.rims(touching, elastic, 1, 1 in boundary.periodic_axes)
    following = slab.ranks.following(np.stack([touching[:1], elastic[:1]]))
    last = slab.ranks.number == slab.ranks.count - 1
    if not last or 0 in boundary.periodic_axes:
        touching, elastic = (
            np.concatenate([here, row])
            for here, row in zip((touching, elastic), following, strict=True)
        )
    along_y = area.rims(touching, elastic, 0, False)
    return int(slab.ranks.total(along_x + along_y))


def _edge_load(slab: Slab, boundary: Boundary, pressure: Array) -> float:
    """Return the share of the load on the outermost pixels along edges at which the map ends."""
    sums, rows = slab.sums, slab.rows
    first = int(0 in boundary.free_axes and rows.start == 0)
    last = len(pressure) - int(0 in boundary.free_axes and rows.stop == slab.shape[0])
    # What lies within is not taken from the total: rounding would leave a load where there is none.
    ends = [pressure[:first], pressure[last:]]
    if 1 in boundary.free_axes:
        ends += [pressure[first:last, :1], pressure[first:last, -1:]]
    total = sums.total(pressure)
    outermost = sums.total(np.concatenate([part.ravel() for part in ends]))
    return outermost / total if total else 0.0


def reduced(result: SlabResult) -> Sequence[Array | None]:
    """Return heights, pressure and gap for pictures, on the first rank; all ranks call it.

    Returns
    -------
    tuple of ndarray or None
        Mean height [m], largest pressure [Pa] and mean gap [m] in blocks of pixels.
    """
    slab = result.slab
    return (
        slab.reduced(slab.heights),
        slab.reduced(result.pressure, largest=True),
        slab.reduced(result.gap),
    )
