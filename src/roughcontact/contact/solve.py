"""Contact of two bodies: surfaces, materials and a load in, a result out."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from numbers import Integral
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._version import __version__
from roughcontact.contact.result import ContactResult, centre_of_pressure, initial_gap
from roughcontact.errors import (
    CapacityError,
    ConvergenceError,
    InputError,
    InsufficientMemoryError,
    require_positive,
)
from roughcontact.halfspace import convolution
from roughcontact.halfspace.fft import Workspace
from roughcontact.material.material import RIGID, Material, contact_modulus, softer
from roughcontact.solvers import bounded, tilt
from roughcontact.solvers.operator import Family
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

_BOUNDARIES = {"free": convolution.free, "periodic": convolution.periodic}


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
    boundary : {"free", "periodic"}
        Whether the map is all there is, or one period of an endless surface.
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
    make = operators(boundary, surface.pixel, stated.modulus, precision, Workspace())
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
        boundary=boundary,
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
            f"not converged: certificate {result.certificate:.1e} (tolerance {tolerance:.0e}), "
            f"load error {load_error:.1e}"
            + (f", moment error {result.moment_error:.1e}" if moments is not None else "")
            + f" after {result.convolutions} convolutions: {result.status}",
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


def stiffness(result: ContactResult) -> float:
    """Return the contact stiffness dW/dω of a solution.

    Parameters
    ----------
    result : ContactResult
        A solution.

    Returns
    -------
    float
        Increase of the load with the approach [N/m] as the load grows and the tilt stays.
        Saturated pixels carry no more; 0 where every touching pixel is saturated, infinite in a
        full periodic contact.

    Notes
    -----
    Within the small step the contact does not change: its elastic pixels are pressed like a
    rigid flat punch of that outline, which is one more contact problem with a gap of zero on them
    and no contact elsewhere. A circle of radius a gives 2 E* a.

    References
    ----------
    Barber 2003, Proc. R. Soc. A 459, 53, doi:10.1098/rspa.2002.1038
    """
    index = np.flatnonzero(result.contact & ~result.saturated)
    if index.size == 0:
        return 0.0
    gap = np.full(result.pressure.shape, np.inf)
    gap.ravel()[index] = 0.0
    total = 1 / result.pixel_area
    solution = bounded.solve(
        Problem(initial_gap=gap, limit=np.inf, total=total),
        operators(
            result.boundary,
            result.surface.pixel,
            result.contact_modulus,
            result.precision,
            Workspace(),
        ),
        tolerance=max(result.tolerance, 1e-6),
        max_iterations=500,
        start=(index, np.full(index.size, total / index.size)),
    )
    if solution.status is not bounded.Status.CONVERGED:
        raise ConvergenceError(
            f"stiffness not converged: certificate {solution.certificate:.1e}: "
            f"{solution.status.value}",
            result,
        )
    # In full periodic contact the flat moves without displacing anything.
    smallest = np.finfo(float).eps * result.pixel_area * total / result.contact_modulus
    return math.inf if solution.approach <= smallest else 1 / solution.approach


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
    check_bodies(surface, material, counter_material, counter_surface)
    check_choice("boundary", boundary, tuple(_BOUNDARIES))
    check_choice("precision", precision, ("double", "single"))
    check_choice("on_failure", on_failure, ("raise", "return"))
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
        moments = _checked_moments(moments, load, boundary, precision)
    check_surfaces(surface, counter_surface)
    modulus = contact_modulus(material, counter_material)
    resolved = resolved_ceiling(ceiling, material, counter_material, surface.shape)
    if start is not None:
        _check_start(start, surface.shape)
    check_memory(surface.shape, boundary=boundary, precision=precision)

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
        total = min(load / area, _capacity(load, resolved, gap, area, valid) / area)
    target = None
    if moments is not None and load is not None:
        target = np.array(moments) / (load * max(surface.size))
        _check_balance(target, load, resolved, gap, surface)
    if approach is not None:
        require_positive(approach=approach)
        if boundary == "periodic" and resolved is None and valid == gap.size:
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


def _checked_moments(
    moments: tuple[float, float], load: float | None, boundary: str, precision: str
) -> tuple[float, float]:
    try:
        about_y, about_x = (float(moment) for moment in moments)
    except (TypeError, ValueError):
        about_y = about_x = math.nan
    if not (math.isfinite(about_y) and math.isfinite(about_x)):
        raise InputError(
            f"must be a pair (y, x) of numbers [N m], got {moments!r}",
            argument="moments",
            value=moments,
        )
    if load is None:
        raise InputError(
            "need a load to balance; give load instead of approach", argument="moments"
        )
    if boundary == "periodic":
        raise InputError("need boundary='free': a tilt has no period", argument="moments")
    if precision == "single":
        raise InputError("need precision='double' to be balanced to 1e-8", argument="moments")
    return about_y, about_x


def _check_balance(
    target: NDArray[np.float64],
    load: float,
    ceiling: float | NDArray[np.float64] | None,
    gap: NDArray[np.float64],
    surface: Surface,
) -> None:
    """Raise if no admissible pressure has its centre where the load acts."""
    touchable = np.isfinite(gap)
    y, x = (np.broadcast_to(v, gap.shape)[touchable] for v in tilt.levers(gap.shape, surface.pixel))
    share: float | NDArray[np.float64] = math.inf
    if ceiling is not None:
        part = np.asarray(ceiling) * (surface.pixel[0] * surface.pixel[1] / load)
        share = part[touchable] if part.ndim else float(part)
    side = max(surface.size)
    outside = tilt.excess(target, y, x, share) * side
    if outside > 0:
        at_y, at_x = target * side
        what = "points that can touch" if ceiling is None else "pressures up to the ceiling"
        raise CapacityError(
            f"moments = ({target[0] * load * side:.6g}, {target[1] * load * side:.6g}) N m put the "
            f"load of {load:.6g} N at ({at_y:.6g}, {at_x:.6g}) m from the centre of the map, "
            f"{outside:.3g} m beyond what {what} can balance; move it inwards"
        )


def operators(
    boundary: str,
    pixel: tuple[float, float],
    modulus: float,
    precision: str,
    workspace: Workspace,
) -> Family:
    """Return what makes the displacement operator of a map on any grid.

    Parameters
    ----------
    boundary : {"free", "periodic"}
        As for `solve`.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` of the map [m].
    modulus : float
        E* [Pa].
    precision : {"double", "single"}
        Arithmetic on the grid of the map.
    workspace : Workspace
        Threads and memory that they share.

    Returns
    -------
    callable
        ``operator(shape, (ky, kx))`` as `solver.solve` wants it.
    """

    def operator(shape: tuple[int, int], coarsening: tuple[int, int]) -> convolution.Convolution:
        coarse = (coarsening[0] * pixel[0], coarsening[1] * pixel[1])
        # On coarse grids the error of the grid outweighs that of the arithmetic.
        arithmetic = precision if coarsening == (1, 1) else "single"
        make = _BOUNDARIES[boundary]
        return make(shape, coarse, modulus, precision=arithmetic, workspace=workspace)

    return operator


def check_choice(name: str, value: str, known: tuple[str, ...]) -> None:
    """Raise `InputError` unless a value is one of those known."""
    if value not in known:
        choices = " or ".join(repr(choice) for choice in known)
        raise InputError(f"must be {choices}, got {value!r}", argument=name, value=value)


def check_bodies(
    surface: Surface,
    material: Material,
    counter_material: Material,
    counter_surface: Surface | None,
) -> None:
    """Raise `InputError` for bodies of another type."""
    for name, value, kind in (
        ("surface", surface, Surface),
        ("counter_surface", counter_surface, Surface),
        ("material", material, Material),
        ("counter_material", counter_material, Material),
    ):
        if not (isinstance(value, kind) or (name == "counter_surface" and value is None)):
            raise InputError(f"{name} must be a {kind.__name__}, got {type(value).__name__}")


def check_surfaces(surface: Surface, counter_surface: Surface | None) -> None:
    """Raise `InputError` for unhandled holes or surfaces on different grids."""
    for name, body in (("surface", surface), ("counter_surface", counter_surface)):
        if body is not None and body.missing and not body.holes_masked:
            raise InputError(
                f"{name} has {body.missing} missing points: fill them (.filled()), crop them away "
                "(.cropped(...)) or let them never touch (.masked())"
            )
    if counter_surface is None:
        return
    if counter_surface.shape != surface.shape or not np.allclose(
        counter_surface.pixel, surface.pixel, rtol=1e-9, atol=0
    ):
        raise InputError(
            f"has {counter_surface.shape} pixels of {counter_surface.pixel} m, "
            f"surface {surface.shape} of {surface.pixel} m: both bodies need the same grid",
            argument="counter_surface",
        )


def _check_start(start: ContactResult | ArrayLike, shape: tuple[int, int]) -> None:
    pressure = np.asarray(start.pressure if isinstance(start, ContactResult) else start)
    if pressure.dtype.kind not in "fiu":
        raise InputError(
            f"must be a ContactResult or a map of pressures [Pa], got {type(start).__name__}",
            argument="start",
        )
    if pressure.shape != shape:
        raise InputError(
            f"has {pressure.shape} pixels and the surface {shape}; "
            "start from a solution on the same grid",
            argument="start",
        )
    if not (np.isfinite(pressure).all() and (pressure >= 0).all()):
        raise InputError("must hold finite pressures that are not negative", argument="start")


def resolved_ceiling(
    ceiling: str | float | ArrayLike | None,
    material: Material,
    counter_material: Material,
    shape: tuple[int, int],
) -> float | NDArray[np.float64] | None:
    """Return the ceiling as `solve` uses it.

    Parameters
    ----------
    ceiling : "auto", float, array_like or None
        As for `solve`.
    material, counter_material : Material
        Of the two bodies.
    shape : (int, int)
        Grid points ``(ny, nx)``.

    Returns
    -------
    float, ndarray of shape (ny, nx), or None
        Largest pressure [Pa]; ``None`` without a ceiling.

    Raises
    ------
    InputError
        If it is neither of these, not positive, or does not fit the grid.
    """
    if isinstance(ceiling, str):
        check_choice("ceiling", ceiling, ("auto",))
        body = softer(material, counter_material)
        return None if body is None else body.ceiling
    if ceiling is None:
        return None
    try:
        given = np.asarray(ceiling)
    except ValueError:
        raise InputError(
            "must be a number or a map, got rows of unequal length", argument="ceiling"
        ) from None
    if given.dtype.kind not in "fiu" or isinstance(ceiling, np.ma.MaskedArray):
        raise InputError(
            f"must be real numbers [Pa], got {type(ceiling).__name__}", argument="ceiling"
        )
    values = given.astype(np.float64)
    if values.ndim == 0:
        require_positive(ceiling=float(values))
        return float(values)
    if values.shape != shape:
        raise InputError(f"has shape {values.shape}, the surface {shape}", argument="ceiling")
    if not (values > 0).all():
        smallest = float(values.min())
        raise InputError(
            f"must be positive everywhere [Pa], its smallest is {smallest!r}", argument="ceiling"
        )
    if np.isinf(values).all():
        return None
    values.flags.writeable = False
    return values


def _capacity(
    load: float,
    ceiling: float | NDArray[np.float64] | None,
    gap: NDArray[np.float64],
    area: float,
    valid: int,
) -> float:
    """Return the largest load that can be carried, or raise if this one is larger."""
    if ceiling is None:
        return math.inf
    if isinstance(ceiling, np.ndarray):
        capacity = float(ceiling[np.isfinite(gap)].sum()) * area
    else:
        capacity = ceiling * valid * area
    # The full capacity is a load like any other; rounding must not refuse it.
    if load > capacity * (1 + 1e-12):
        raise CapacityError(
            f"= {load:.6g} N is more than the surface can carry: the ceiling times the "
            f"area of its valid pixels is {capacity:.6g} N",
            argument="load",
        )
    return capacity


def memory_estimate(
    shape: tuple[int, int], *, boundary: str = "free", precision: str = "double"
) -> int:
    """Return the memory that `solve` needs beyond the surface itself.

    Parameters
    ----------
    shape : (int, int)
        Grid points ``(ny, nx)``.
    boundary : {"free", "periodic"}
        As for `solve`.
    precision : {"double", "single"}
        As for `solve`.

    Returns
    -------
    int
        Bytes, for a contact on a small part of the map; a map in full contact needs about
        twice as much.
    """
    ny, nx = shape
    real = 8 if precision == "double" else 4
    pixels = ny * nx
    spectra = 2 if boundary == "free" else 1
    rows = 2 * real * ny * (nx * spectra // 2 + 1)
    kernel = 8 * (ny + 1) * (nx + 1) // (1 if boundary == "free" else 4)
    if precision == "single":
        kernel += kernel // 2
    # Initial gap and open gap, coarse grids, then the pressure that is returned.
    maps = 2 * real * pixels + real * pixels // 2 + 8 * pixels
    return rows + kernel + maps


def check_memory(
    shape: tuple[int, int], *, boundary: str = "free", precision: str = "double"
) -> None:
    """Raise an error with a suggestion if a solve on this grid would not fit.

    Parameters
    ----------
    shape, boundary, precision
        As for `memory_estimate`.

    Raises
    ------
    InsufficientMemoryError
        If the estimate exceeds the memory that is free.
    """
    import psutil

    needed = memory_estimate(shape, boundary=boundary, precision=precision)
    free = psutil.virtual_memory().available
    if needed <= free:
        return
    gib = 2**30
    points = int(math.sqrt(free / needed * shape[0] * shape[1]))
    advice = f"a square grid of up to about {points} × {points} points fits"
    if (
        precision == "double"
        and memory_estimate(shape, boundary=boundary, precision="single") < free
    ):
        advice += '; precision="single" fits the whole map'
    raise InsufficientMemoryError(
        f"a map of {shape[0]} × {shape[1]} points needs about {needed / gib:.1f} GiB, "
        f"and {free / gib:.1f} GiB are free: {advice}"
    )
