"""Contact of two bodies: surfaces, materials and a load in, a result out."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from numbers import Integral
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._version import __version__
from roughcontact.contact import checks
from roughcontact.contact.area import centre_of_pressure
from roughcontact.contact.ceiling import resolved_ceiling
from roughcontact.contact.pair import initial_gap
from roughcontact.contact.result import ContactResult
from roughcontact.errors import (
    CapacityError,
    ConvergenceError,
    InputError,
    Sentence,
    parts_of,
    require_choice,
    require_positive,
)
from roughcontact.halfspace.boundary import Boundary
from roughcontact.material.material import RIGID, Material, contact_modulus
from roughcontact.solvers import bounded, tilt
from roughcontact.solvers.problem import Problem
from roughcontact.solvers.progress import Step
from roughcontact.surface.surface import Surface

LOAD_TOLERANCE = 1e-10
"""Largest load error of a converged result."""

MOMENT_TOLERANCE = 1e-8
"""Largest moment error of a converged result."""

UNBALANCED = (
    "moments not balanced; the point of the load may lie too near to the edge of the contact"
)
"""Status of a result whose bodies did not come to rest at any tilt."""


def solve(
    surface: Surface,
    *,
    material: Material,
    load: float | None = None,
    approach: float | None = None,
    moments: tuple[float, float] | None = None,
    counter_material: Material = RIGID,
    counter_surface: Surface | None = None,
    ceiling: str | float | ArrayLike | None = "auto",
    boundary: str = "free",
    tolerance: float | None = None,
    max_iterations: int = 500,
    precision: str = "double",
    start: ContactResult | ArrayLike | None = None,
    on_failure: str = "raise",
    progress: Callable[[Step], None] | None = None,
) -> ContactResult:
    """Press a rough body against another one and return pressure, contact and gap.

    Parameters
    ----------
    surface : Surface
        Heights of the rough body, without unhandled holes.
    material, counter_material : Material
        Of the rough body and of its counter-body.
    load : float
        Normal load W [N]; give either this or ``approach``.
    approach : float
        Approach ω of the bodies from the first touch [m].
    moments : (float, float), optional
        Moments ``(W y, W x)`` [N·m] of the load about the centre of the map: a load that acts at
        the point (y, x) away from it, ``(0, 0)`` for one in the middle. The bodies then tilt
        until the pressure balances them. Without it they do not tilt, whatever the moments.
    counter_surface : Surface, optional
        Heights of the counter-body on the same grid, laid on the first map point by point
        (mirror a map that was measured from its own front); a flat without it.
    ceiling : "auto", float, array_like or None
        Largest pressure [Pa], one for all or one a pixel. ``"auto"`` is the smaller of the
        bodies' ceilings, three times the yield strength or, without one, the hardness; no ceiling
        where none is known. ``None`` is purely elastic.
    boundary : {"free", "periodic", "periodic-x", "periodic-y"}
        Whether the map is all there is, or one period of an endless surface, or of a strip that
        is endless along one axis and ends along the other; see `Boundary`.
    tolerance : float, optional
        Certificate ε at which the result counts as converged; 1e-6, or 1e-4 in single precision.
    max_iterations : int
        Most convolutions on any one grid (one more may be needed to judge the best pressure).
    precision : {"double", "single"}
        Arithmetic of the transforms; single needs about two thirds of the memory and promises a
        certificate of 1e-4 (it usually reaches some 1e-6).
    start : ContactResult or array_like of shape (ny, nx), optional
        Solution of a nearby problem on the same grid, or its pressure [Pa], to start from.
    on_failure : {"raise", "return"}
        What to do with a result above the tolerance.
    progress : callable, optional
        Called with a `Step` every time the solver has looked at the whole map.

    Returns
    -------
    ContactResult
        The solution with its certificate.

    Raises
    ------
    InputError
        If an argument cannot be used; the message names it and its value.
    CapacityError
        If the load exceeds the ceiling times the area, nothing can touch, or no pressure
        balances the moments.
    InsufficientMemoryError
        If the problem does not fit into the memory that is free.
    ConvergenceError
        If the tolerance was not reached; its ``result`` is the best found.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact import Material, Surface, solve
    >>> y, x = np.mgrid[-32:32, -32:32] * 1e-6
    >>> ball = Surface(-(x**2 + y**2) / (2 * 0.01), pixel=(1e-6, 1e-6))
    >>> steel = Material(young=210e9, poisson=0.3, yield_strength=1e9)
    >>> result = solve(ball, material=steel, load=0.1)
    >>> result.status, result.regime
    ('converged', 'below first yield')
    """
    began = time.perf_counter()
    stated = _stated(
        surface,
        material=material,
        load=load,
        approach=approach,
        moments=moments,
        counter_material=counter_material,
        counter_surface=counter_surface,
        ceiling=ceiling,
        boundary=boundary,
        tolerance=tolerance,
        max_iterations=max_iterations,
        precision=precision,
        start=start,
        on_failure=on_failure,
    )
    problem, tolerance = stated.problem, stated.tolerance
    area = surface.pixel[0] * surface.pixel[1]
    loaded = None
    if start is not None:
        pressure = start.pressure if isinstance(start, ContactResult) else np.asarray(start)
        index = np.flatnonzero(pressure)
        loaded = index, pressure.ravel()[index]
    options: dict[str, Any] = {
        "tolerance": tolerance,
        "max_iterations": int(max_iterations),
        "start": loaded,
        "progress": progress,
    }
    make = Boundary(boundary).operators(
        surface.shape, surface.pixel, stated.modulus, precision=precision
    )
    slope = 0.0, 0.0
    if stated.target is None:
        solution = bounded.solve(problem, make, **options)
    else:
        if isinstance(start, ContactResult):
            slope = start.tilt
        solution, slope = tilt.solve(
            problem, make, stated.target, surface.pixel, slope,
            moment_tolerance=MOMENT_TOLERANCE, **options,
        )  # fmt: skip
    # An error that is kept would keep the memory of the solve with it.
    del problem, make
    del stated.problem
    pressure = np.zeros(surface.shape)
    pressure.ravel()[solution.index] = solution.pressure
    carried = float(pressure.sum()) * area
    load_error = 0.0 if load is None else abs(carried - load) / load
    status = solution.status
    if status is bounded.Status.CONVERGED and load_error > LOAD_TOLERANCE:
        status = bounded.Status.STALLED
    words = status.value
    if stated.target is not None and status is bounded.Status.CONVERGED:
        centre = np.array(centre_of_pressure(pressure, surface.pixel)) / max(surface.size)
        if np.abs(centre - stated.target).max() > MOMENT_TOLERANCE:
            words = UNBALANCED
    final_gap = solution.gap.astype(np.float64, copy=False)
    if stated.valid < final_gap.size:
        final_gap[np.isinf(final_gap)] = np.nan
    result = ContactResult(
        surface=surface,
        counter_surface=counter_surface,
        material=material,
        counter_material=counter_material,
        contact_modulus=stated.modulus,
        ceiling=stated.ceiling,
        boundary=Boundary(boundary),
        precision=precision,
        tolerance=tolerance,
        control="load" if approach is None else "approach",
        load=carried if load is None else load,
        approach=solution.approach,
        pressure=pressure,
        gap=final_gap,
        certificate=solution.certificate,
        load_error=load_error,
        status=words,
        iterations=solution.iterations,
        convolutions=solution.convolutions,
        seconds=time.perf_counter() - began,
        version=__version__,
        tilt=slope,
        moments=None if moments is None else (float(moments[0]), float(moments[1])),
    )
    if not result.converged and on_failure == "raise":
        raise ConvergenceError(
            Sentence(
                f"not converged: certificate {result.certificate:.1e} (tolerance {tolerance:.0e}), "
                f"load error {load_error:.1e}",
                f", moment error {result.moment_error:.1e}" if moments is not None else "",
                f" after {result.convolutions} convolutions: ",
                *parts_of(result.status),
            ),
            result,
        )
    return result


def check(surface: Surface, **arguments: Any) -> None:
    """Raise what `solve` would raise before it starts.

    Parameters
    ----------
    surface : Surface
        Heights of the rough body.
    **arguments
        Those of `solve`.

    Raises
    ------
    InputError, CapacityError, InsufficientMemoryError
        As for `solve`.
    """
    _stated(surface, **{"load": None, "approach": None, **arguments})


def elastic(result: ContactResult) -> ContactResult:
    """Return the solution of the same problem without a ceiling.

    Parameters
    ----------
    result : ContactResult
        A solution, with a ceiling or without.

    Returns
    -------
    ContactResult
        The result itself if it has no ceiling; else a new solve under the same load.

    Raises
    ------
    ConvergenceError
        If the tolerance was not reached.
    """
    if result.ceiling is None:
        return result
    return solve(
        result.surface,
        load=result.load,
        moments=result.moments,
        material=result.material,
        counter_material=result.counter_material,
        counter_surface=result.counter_surface,
        ceiling=None,
        boundary=result.boundary,
        tolerance=result.tolerance,
        precision=result.precision,
    )


@dataclass
class _Stated:
    """A problem that has passed all checks; the solver may take its arrays away."""

    problem: Problem
    modulus: float
    ceiling: float | NDArray[np.float64] | None
    tolerance: float
    valid: int
    # Where the load acts, as a part of the longer side; None where the bodies do not tilt.
    target: NDArray[np.float64] | None


def _stated(
    surface: Surface,
    *,
    material: Material,
    load: float | None,
    approach: float | None,
    moments: tuple[float, float] | None = None,
    counter_material: Material = RIGID,
    counter_surface: Surface | None = None,
    ceiling: str | float | ArrayLike | None = "auto",
    boundary: str = "free",
    tolerance: float | None = None,
    max_iterations: int = 500,
    precision: str = "double",
    start: ContactResult | ArrayLike | None = None,
    on_failure: str = "raise",
) -> _Stated:
    checks.check_bodies(surface, material, counter_material, counter_surface)
    boundary = Boundary(boundary)
    require_choice(("double", "single"), precision=precision)
    require_choice(("raise", "return"), on_failure=on_failure)
    if tolerance is None:
        tolerance = 1e-6 if precision == "double" else 1e-4
    require_positive(tolerance=tolerance)
    if not isinstance(max_iterations, Integral) or max_iterations < 1:
        raise InputError(
            f"must be a positive integer, got {max_iterations!r}",
            argument="max_iterations",
            value=max_iterations,
        )
    if (load is None) == (approach is None):
        raise InputError("give either load or approach, and only one of them")
    if moments is not None:
        moments = checks.checked_moments(moments, load, boundary, precision)
    checks.check_surfaces(surface, counter_surface)
    modulus = contact_modulus(material, counter_material)
    resolved = resolved_ceiling(ceiling, material, counter_material, surface.shape)
    if start is not None:
        checks.check_start(start, surface.shape)
    checks.check_memory(surface.shape, boundary=boundary, precision=precision)

    gap = initial_gap(surface, counter_surface)
    valid = gap.size
    if surface.missing or (counter_surface is not None and counter_surface.missing):
        holes = np.isnan(gap)
        gap[holes] = np.inf
        valid -= int(np.count_nonzero(holes))
    if valid == 0:
        raise CapacityError(
            "no contact is possible: together the holes of both bodies leave no point to touch"
        )
    area = surface.pixel[0] * surface.pixel[1]
    total = None
    if load is not None:
        require_positive(load=load)
        total = min(load / area, checks.capacity(load, resolved, gap, area, valid) / area)
    target = None
    if moments is not None and load is not None:
        target = np.array(moments) / (load * max(surface.size))
        checks.check_balance(target, load, resolved, gap, surface)
    if approach is not None:
        require_positive(approach=approach)
        if not boundary.free_axes and resolved is None and valid == gap.size:
            full = float(gap.mean())
            if approach >= full:
                raise CapacityError(
                    f"= {approach:.6g} m is beyond full contact of this periodic "
                    f"surface at {full:.6g} m, where the load is undefined; give a load instead",
                    argument="approach",
                )
    if precision == "single":
        gap = gap.astype(np.float32)
    problem = Problem(
        initial_gap=gap,
        limit=np.inf if resolved is None else resolved,
        total=total,
        approach=approach,
    )
    return _Stated(problem, modulus, resolved, tolerance, valid, target)
