"""One contact whose map lies on several ranks, each with a band of its rows.

The solver is the same; what sees all of the map here, from the highest point to the rim of the
contact, is found by each rank on its own rows and added up.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._version import __version__
from roughcontact.contact import area, checks, scale
from roughcontact.contact.advice import RECOMMENDED
from roughcontact.contact.cautions import Caution, Kind, edge, noted, ordered, warned
from roughcontact.contact.ceiling import resolved_ceiling
from roughcontact.contact.loads import GivenLoad, NominalPressure, given
from roughcontact.contact.pair import Pair
from roughcontact.contact.result import Regime, regime_of
from roughcontact.contact.scale import Scale
from roughcontact.contact.solve import LOAD_TOLERANCE
from roughcontact.contact.terms import Terms
from roughcontact.errors import (
    CapacityError,
    ConvergenceError,
    InputError,
    Mention,
    Sentence,
    parts_of,
    require_choice,
    require_pixel,
    require_positive,
)
from roughcontact.halfspace import slabs
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.fft import Workspace, default_workers
from roughcontact.halfspace.slabs import SlabSums
from roughcontact.material.material import RIGID, Material
from roughcontact.ranks import Ranks
from roughcontact.solvers import bounded
from roughcontact.solvers.problem import Problem
from roughcontact.solvers.progress import Step
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantities, Quantity, quantity

Array = NDArray[np.float64]

# Points along the longer side of a map that one place can hold for a picture.
_REDUCED = 512


def bands(shape: tuple[int, int], count: int) -> tuple[int, ...]:
    """Return the first row of each rank, and the number of rows.

    Parameters
    ----------
    shape : (int, int)
        Grid points ``(ny, nx)`` of the map.
    count : int
        Ranks.

    Returns
    -------
    tuple of int
        Multiples of the coarsest pixel with which a solve begins, so that each rank coarsens rows
        of its own; as even as that allows.

    Raises
    ------
    InputError
        If there are fewer such bands than ranks.

    Examples
    --------
    >>> bands((1024, 1024), 3)
    (0, 320, 672, 1024)
    """
    edge = max(2 << bounded.coarser_grids(shape) - 1, 2) if min(shape) > 1 else 2
    most = shape[0] // edge
    if count > most:
        raise InputError(
            f"a map of {shape[0]} × {shape[1]} points can lie on {most} ranks at most, got "
            f"{count}; start fewer of them, each with more threads"
        )
    return (*(edge * (most * rank // count) for rank in range(count)), shape[0])


@dataclass(frozen=True, eq=False)
class Slab:
    """A band of rows of a map of heights, the rest of which other ranks hold.

    Parameters
    ----------
    heights : array_like, shape (rows, nx)
        Heights of the rows of this rank [m]; NaN where missing.
    shape : (int, int)
        Grid points ``(ny, nx)`` of the whole map.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    ranks : Ranks or mpi4py communicator
        Those that hold the map, each the rows that `bands` gives it.
    provenance : Provenance
        Where the map came from.
    holes_masked : bool
        Whether missing points are accepted as points that never touch.

    Raises
    ------
    InputError
        On all ranks if one of them has heights that cannot be used.
    """

    heights: Array
    shape: tuple[int, int]
    pixel: tuple[float, float]
    ranks: Ranks
    provenance: Provenance = field(default_factory=Provenance)
    holes_masked: bool = False

    def __init__(
        self,
        heights: ArrayLike,
        shape: tuple[int, int],
        pixel: Quantities,
        ranks: Any,
        provenance: Provenance | None = None,
        holes_masked: bool = False,
    ) -> None:
        ranks = ranks if isinstance(ranks, Ranks) else Ranks(ranks)
        ny, nx = shape
        dy, dx = quantity(pixel, "length", "pixel")
        values = {
            "shape": (int(ny), int(nx)), "pixel": (float(dy), float(dx)), "ranks": ranks,
            "provenance": provenance or Provenance(), "holes_masked": bool(holes_masked),
        }  # fmt: skip
        for name, value in values.items():
            object.__setattr__(self, name, value)
        object.__setattr__(self, "heights", ranks.agreed(lambda: self._checked(heights)))
        if not self.sums.count(np.isfinite(self.heights)):
            raise InputError("hold no finite value", argument="heights")

    def _checked(self, heights: ArrayLike) -> Array:
        require_pixel(self.pixel)
        wanted = (self.rows.stop - self.rows.start, self.shape[1])
        taken: Array = np.ascontiguousarray(heights, np.float64)
        if taken.shape != wanted:
            raise InputError(
                f"of rank {self.ranks.number} must be {wanted[0]} × {wanted[1]}, rows "
                f"{self.rows.start} to {self.rows.stop} of the map, got {taken.shape}",
                argument="heights",
            )
        if np.isinf(taken).any():
            raise InputError("must not be infinite; mark what is missing by NaN",
                             argument="heights")  # fmt: skip
        return taken

    @cached_property
    def edges(self) -> tuple[int, ...]:
        """First row of each rank, and the number of rows."""
        return bands(self.shape, self.ranks.count)

    @property
    def rows(self) -> slice:
        """Rows of the map that this rank holds."""
        return slice(*self.edges[self.ranks.number : self.ranks.number + 2])

    @property
    def sums(self) -> SlabSums:
        """Sums over all pixels of the map."""
        return SlabSums(self.ranks)

    @property
    def size(self) -> tuple[float, float]:
        """Lengths of the sides ``(ny·dy, nx·dx)`` of the map [m]."""
        return self.shape[0] * self.pixel[0], self.shape[1] * self.pixel[1]

    @cached_property
    def missing(self) -> int:
        """Points of the map that are missing."""
        return self.sums.count(np.isnan(self.heights))

    @cached_property
    def highest(self) -> float:
        """The largest height of the map [m]."""
        return self.sums.largest(self.heights[np.isfinite(self.heights)])

    @property
    def initial_gap(self) -> Array:
        """Gap at first touch of the rows of this rank [m]; NaN where a height is missing."""
        gap: Array = self.highest - self.heights
        return gap

    def reduced(self, values: NDArray[Any], largest: bool = False) -> Array | None:
        """Return a map in blocks of pixels, the mean or the largest of each, on the first rank.

        Parameters
        ----------
        values : ndarray, shape (rows, nx)
            Rows of this rank.
        largest : bool
            Whether to take the largest.

        Returns
        -------
        ndarray or None
            At most 512 points along each side; None on the other ranks.
        """
        edge = 1
        while max(self.shape) > _REDUCED * edge and all(e % (2 * edge) == 0 for e in self.edges):
            edge *= 2
        take = np.fmax if largest else np.add
        blocks = [range(0, points, edge) for points in values.shape]
        here = take.reduceat(take.reduceat(values, blocks[0], axis=0), blocks[1], axis=1)
        if not largest:
            here = here / np.outer(*(
                np.diff([*tops, points]) for tops, points in zip(blocks, values.shape, strict=True)
            ))  # fmt: skip
        counts = [len(range(0, e - s, edge)) for s, e in zip(self.edges, self.edges[1:],
                  strict=False)]  # fmt: skip
        whole = self.ranks.joined(here, counts)
        return whole if self.ranks.first else None


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
class SlabResult:
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
    moments = recommended = None

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


def solve_slab(
    slab: Slab,
    *,
    material: Material,
    load: Quantity | NominalPressure | None = None,
    approach: Quantity | None = None,
    counter_material: Material = RIGID,
    ceiling: Quantity | None = "auto",
    boundary: str = "free",
    tolerance: float | None = None,
    max_iterations: int = 2000,
    precision: str = "double",
    on_failure: str = "raise",
    workers: int | None = None,
    progress: Callable[[Step], None] | None = None,
) -> SlabResult:
    """Press a rough body that lies on several ranks against a flat; all of them call it.

    Parameters
    ----------
    slab : Slab
        The rows of this rank.
    material, load, approach, counter_material, boundary, tolerance, max_iterations, precision, \
on_failure
        As for `roughcontact.solve`; of the forms of a load a force or a nominal pressure.
    ceiling : "auto", float, str, quantity of pint, or None
        As for `roughcontact.solve`: one for all pixels.
    workers : int, optional
        Threads of this rank; by default the cores that it may use, shared with the ranks beside
        it on the machine.
    progress : callable, optional
        Called with a `Step` every time the solver has looked at the whole map.

    Returns
    -------
    SlabResult
        The solution with its certificate, the same numbers on every rank.

    Raises
    ------
    InputError, CapacityError, ConvergenceError
        As for `roughcontact.solve`, on all ranks.
    """
    require_choice(("raise", "return"), on_failure=on_failure)
    # Of a map that lies elsewhere: what depends on it is asked of the slab.
    pair = Pair(
        Surface(np.zeros((2, 2)), slab.pixel), material, None, counter_material, Boundary(boundary)
    )
    force, form = _force(load, slab)
    terms = Terms(
        force, approach, None, ceiling, tolerance, max_iterations, precision,
        None if form is None else GivenLoad(form, force),
    )  # fmt: skip
    began = time.perf_counter()
    before = slab.ranks.seconds, slab.ranks.sent
    problem, units, limit = _stated(slab, pair, terms)
    cores = workers or slab.ranks.workers(default_workers())
    make = slabs.operators(
        pair.boundary, slab.edges, slab.shape, slab.pixel,
        pair.contact_modulus * units.length / units.pressure, slab.ranks,
        precision=terms.precision, workspace=Workspace(cores),
    )  # fmt: skip
    solution = bounded.solve(
        problem, make, tolerance=terms.certificate, max_iterations=int(terms.max_iterations),
        progress=progress,
    )  # fmt: skip
    del problem
    result = _result(slab, pair, terms, units, limit, solution, began, before)
    if not result.converged and on_failure == "raise":
        raise ConvergenceError(unsolved(result), result)
    return result


def unsolved(result: SlabResult) -> Sentence:
    """Return how far a solver came that did not converge, and why it stopped."""
    return Sentence(
        f"not converged: certificate {result.certificate:.1e}, tolerance {result.tolerance:.0e}, "
        f"load error {result.load_error:.1e}; ",
        *parts_of(result.status),
    )


def _force(load: Any, slab: Slab) -> tuple[Any, NominalPressure | None]:
    """Return the load [N], and the form in which it was given if that was no force."""
    asked = given(load)
    if isinstance(asked, NominalPressure):
        return asked.value * slab.size[0] * slab.size[1], asked
    if asked is not None and not isinstance(asked, (int, float)):
        raise InputError(
            "of a map on several ranks must be a force, such as '1 N', or a nominal pressure, such "
            f"as '20 MPa', got {load!r}",
            argument="load",
        )
    return asked, None


def _stated(slab: Slab, pair: Pair, terms: Terms) -> tuple[Problem, Scale, float | None]:
    """Return the problem on the rows of this rank, its units and the ceiling [Pa]."""
    checks.check_terms(terms)
    if np.ndim(terms.ceiling) or terms.ceiling == RECOMMENDED:
        raise InputError(
            "of a map on several ranks must be one number for all pixels, or 'auto'",
            argument="ceiling",
        )
    if slab.missing and not slab.holes_masked:
        raise InputError(
            f"have {slab.missing} missing points: fill them beforehand, or let them never touch "
            "with ",
            Mention("holes_masked", True),
            argument="heights",
        )
    ceiling = resolved_ceiling(terms.ceiling, pair)
    limit = None if ceiling is None else float(ceiling)
    sums, gap = slab.sums, slab.initial_gap
    touchable = ~np.isnan(gap)
    gap[~touchable] = np.inf
    points, pixels = sums.count(touchable), math.prod(slab.shape)
    total = None
    if terms.load is not None:
        require_positive(load=terms.load)
        largest = math.inf if limit is None else limit * points * pair.pixel_area
        checks.require_capacity(terms.load, largest, pair)
        total = min(terms.load, largest) / pair.pixel_area
    else:
        require_positive(approach=terms.approach)
        if not pair.boundary.free_axes and points == pixels and limit is None:
            checks.require_below(terms.approach, sums.total(gap) / points)
    deepest = sums.largest(gap[touchable], least=0.0)
    units = scale.of_depth(pair, terms, pixels, deepest)
    gap /= units.length
    if terms.precision == "single":
        gap = gap.astype(np.float32)
    problem = Problem(
        gap,
        limit=math.inf if limit is None else limit / units.pressure,
        total=None if total is None else total / units.pressure,
        approach=None if terms.approach is None else terms.approach / units.length,
        whole=slab.shape,
    )
    return problem, units, limit


def _result(
    slab: Slab,
    pair: Pair,
    terms: Terms,
    units: Scale,
    limit: float | None,
    solution: bounded.Solution,
    began: float,
    before: tuple[float, int],
) -> SlabResult:
    ranks, sums = slab.ranks, slab.sums
    pressure = np.zeros(solution.gap.shape)
    pressure.ravel()[solution.index] = solution.pressure
    pressure *= units.pressure
    if limit is not None:
        np.minimum(pressure, limit, out=pressure)
    carried = sums.total(pressure) * pair.pixel_area
    load = carried if terms.load is None else terms.load
    load_error = 0.0 if terms.load is None else abs(carried - load) / load
    gap = solution.gap.astype(np.float64, copy=False)
    gap *= units.length
    gap[np.isinf(gap)] = np.nan
    status = solution.status
    if status is bounded.Status.CONVERGED and load_error > LOAD_TOLERANCE:
        status = bounded.Status.STALLED
    totals = _totals(slab, pair.boundary, pressure, gap, limit)
    return SlabResult(
        slab=slab,
        pair=pair,
        pressure=pressure,
        gap=gap,
        totals=totals,
        ceiling=limit,
        precision=terms.precision,
        tolerance=terms.certificate,
        control=terms.control,
        load=load,
        approach=solution.approach * units.length,
        certificate=solution.certificate,
        load_error=load_error,
        status=status.value,
        iterations=solution.iterations,
        convolutions=solution.convolutions,
        seconds=float(ranks.everyone(time.perf_counter() - began).max()),
        communication=ranks.total(ranks.seconds - before[0]) / ranks.count,
        sent=int(ranks.total(ranks.sent - before[1]) / ranks.count),
        given=terms.given,
    )


def _totals(
    slab: Slab, boundary: Boundary, pressure: Array, gap: Array, limit: float | None
) -> Totals:
    """Count over the whole map."""
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
    inner = [slice(None), slice(None)]
    if 0 in boundary.free_axes:
        first, last = int(rows.start == 0), rows.stop - rows.start
        inner[0] = slice(first, last - int(rows.stop == slab.shape[0]))
    if 1 in boundary.free_axes:
        inner[1] = slice(1, -1)
    total = sums.total(pressure)
    within = sums.total(pressure[tuple(inner)])
    return max(1 - within / total, 0.0) if total else 0.0


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
