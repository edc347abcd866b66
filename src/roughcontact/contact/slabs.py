"""One contact whose map lies on several ranks, each with a band of its rows.

The solver is the same; what sees all of the map here, from the highest point to the rim of the
contact, is found by each rank on its own rows and added up.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact import memory as ground
from roughcontact.arguments import checked
from roughcontact.contact import checks, memory, scale
from roughcontact.contact.advice import RECOMMENDED
from roughcontact.contact.ceiling import resolved_ceiling
from roughcontact.contact.loads import GivenLoad, Load, NominalPressure, given
from roughcontact.contact.pair import Pair
from roughcontact.contact.scale import Scale
from roughcontact.contact.slab import Slab
from roughcontact.contact.slab_result import SlabResult, totals_of, unsolved
from roughcontact.contact.solve import LOAD_TOLERANCE
from roughcontact.contact.terms import Terms
from roughcontact.errors import (
    ConvergenceError,
    InputError,
    Mention,
    require_choice,
    require_positive,
)
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.fft import Workspace, default_workers
from roughcontact.material.material import RIGID, Material
from roughcontact.solvers import bounded
from roughcontact.solvers.problem import Problem
from roughcontact.solvers.progress import Step
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantity

Array = NDArray[np.float64]


@checked
def solve_slab(
    slab: Slab,
    *,
    material: Material,
    load: Quantity | Load | None = None,
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
    _require_memory(slab, pair.boundary, terms.precision)
    began = time.perf_counter()
    before = slab.ranks.seconds, slab.ranks.sent
    problem, units, limit = _stated(slab, pair, terms)
    solution = _solved(slab, pair, terms, problem, units, workers, progress)
    del problem
    result = _result(slab, pair, terms, units, limit, solution, began, before)
    if not result.converged and on_failure == "raise":
        raise ConvergenceError(unsolved(result), result)
    return result


def _solved(
    slab: Slab,
    pair: Pair,
    terms: Terms,
    problem: Problem,
    units: Scale,
    workers: int | None,
    progress: Callable[[Step], None] | None,
) -> bounded.Solution:
    cores = workers or max(1, default_workers() // slab.ranks.beside())
    make = pair.boundary.slab_operators(
        slab.edges,
        slab.shape,
        slab.pixel,
        pair.contact_modulus * units.length / units.pressure,
        slab.ranks,
        precision=terms.precision,
        workspace=Workspace(cores),
    )
    return bounded.solve(
        problem,
        make,
        tolerance=terms.certificate,
        max_iterations=int(terms.max_iterations),
        progress=progress,
    )


def _require_memory(slab: Slab, boundary: Boundary, precision: str) -> None:
    """Raise on all ranks if the share of one of them does not fit into its machine."""
    needed = memory.memory_estimate(
        slab.shape, boundary=boundary, precision=precision, contact_fraction=0.0
    )
    beside = slab.ranks.beside()
    ny, nx = slab.shape
    slab.ranks.agreed(
        lambda: ground.require(
            needed * beside // slab.ranks.count,
            f"a map of {ny} × {nx} points on {slab.ranks.count} ranks, {beside} of them on this "
            "machine, needs",
            advice=("spread the ranks over more machines",),
        )
    )


def _force(load: Any, slab: Slab) -> tuple[Any, NominalPressure | None]:
    """Return the load [N], and the form in which it was given if that was no force."""
    asked = given(load)
    if isinstance(asked, NominalPressure):
        return asked.value * slab.size[0] * slab.size[1], asked
    if asked is not None and not isinstance(asked, (int, float)):
        raise InputError(
            "of a map on several ranks must be a force, such as '1 N', or a nominal pressure, such "
            "as '20 MPa'; Hertz's pressure and loads on a line are of bodies that one process has",
            argument="load",
        )
    return asked, None


def _stated(slab: Slab, pair: Pair, terms: Terms) -> tuple[Problem, Scale, float | None]:
    """Return the problem on the rows of this rank, its units and the ceiling [Pa]."""
    checks.check_terms(terms)
    number = isinstance(terms.ceiling, (str, float, int, type(None)))
    if not number or terms.ceiling == RECOMMENDED:
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
    if terms.approach is not None:
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
    totals = totals_of(slab, pair.boundary, pressure, gap, limit)
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
