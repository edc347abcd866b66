"""Contact of two bodies: surfaces, materials and a load in, a result out."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from numbers import Integral

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact import convolution, solver
from roughcontact._version import __version__
from roughcontact.errors import (
    CapacityError,
    ConvergenceError,
    InputError,
    InsufficientMemoryError,
    require_positive,
)
from roughcontact.material import CEILING_FACTOR, RIGID, Material, contact_modulus, softer
from roughcontact.result import ContactResult, initial_gap
from roughcontact.solver import Step
from roughcontact.surface import Surface

LOAD_TOLERANCE = 1e-10
"""Largest load error of a converged result."""

_BOUNDARIES = {"free": convolution.free, "periodic": convolution.periodic}


def solve(
    surface: Surface,
    *,
    material: Material,
    load: float | None = None,
    approach: float | None = None,
    counter_material: Material = RIGID,
    counter_surface: Surface | None = None,
    ceiling: str | float | ArrayLike | None = "auto",
    boundary: str = "free",
    tolerance: float | None = None,
    max_iterations: int = 500,
    precision: str = "double",
    start: ContactResult | None = None,
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
    counter_surface : Surface, optional
        Heights of the counter-body on the same grid, laid on the first map point by point
        (mirror a map that was measured from its own front); a flat without it.
    ceiling : "auto", float, array_like or None
        Largest pressure [Pa], one for all or one a pixel. ``"auto"`` is three times the smaller
        yield strength, and no ceiling where none is known; ``None`` is purely elastic.
    boundary : {"free", "periodic"}
        Whether the map is all there is, or one period of an endless surface.
    tolerance : float, optional
        Certificate ε at which the result counts as converged; 1e-6, or 1e-4 in single precision.
    max_iterations : int
        Most convolutions on any one grid (one more may be needed to judge the best pressure).
    precision : {"double", "single"}
        Arithmetic of the transforms; single needs about two thirds of the memory and promises a
        certificate of 1e-4 (it usually reaches some 1e-6).
    start : ContactResult, optional
        Solution of a nearby problem on the same grid, to start from.
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
        If the load exceeds the ceiling times the area, or nothing can touch.
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
    for name, value, kind in (
        ("surface", surface, Surface),
        ("counter_surface", counter_surface, Surface),
        ("material", material, Material),
        ("counter_material", counter_material, Material),
        ("start", start, ContactResult),
    ):
        optional = name in ("counter_surface", "start")
        if not (isinstance(value, kind) or (optional and value is None)):
            raise InputError(f"{name} must be a {kind.__name__}, got {type(value).__name__}")
    check_choice("boundary", boundary, tuple(_BOUNDARIES))
    check_choice("precision", precision, ("double", "single"))
    check_choice("on_failure", on_failure, ("raise", "return"))
    if tolerance is None:
        tolerance = 1e-6 if precision == "double" else 1e-4
    require_positive(tolerance=tolerance)
    if not isinstance(max_iterations, Integral) or max_iterations < 1:
        raise InputError(f"max_iterations must be a positive integer, got {max_iterations!r}")
    if (load is None) == (approach is None):
        raise InputError("give either load or approach, and only one of them")
    check_surfaces(surface, counter_surface)
    modulus = contact_modulus(material, counter_material)
    resolved = _ceiling(ceiling, material, counter_material, surface.shape)
    if start is not None and start.pressure.shape != surface.shape:
        raise InputError(
            f"start has {start.pressure.shape} pixels and the surface {surface.shape}; "
            "start from a solution on the same grid"
        )
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
    if approach is not None:
        require_positive(approach=approach)
        if boundary == "periodic" and resolved is None and valid == gap.size:
            full = float(gap.mean())
            if approach >= full:
                raise CapacityError(
                    f"approach = {approach:.6g} m is beyond full contact of this periodic "
                    f"surface at {full:.6g} m, where the load is undefined; give a load instead"
                )
    if precision == "single":
        gap = gap.astype(np.float32)

    problem = solver.Problem(
        initial_gap=gap,
        limit=np.inf if resolved is None else resolved,
        total=total,
        approach=approach,
    )
    loaded = None
    if start is not None:
        index = np.flatnonzero(start.pressure)
        loaded = index, start.pressure.ravel()[index]
    make = operators(boundary, surface.pixel, modulus, precision, convolution.Workspace())
    solution = solver.solve(
        problem,
        make,
        tolerance=tolerance,
        max_iterations=int(max_iterations),
        start=loaded,
        progress=progress,
    )
    # An error that is kept would keep the threads and the memory of the solve with it.
    del problem, gap, make
    pressure = np.zeros(surface.shape)
    pressure.ravel()[solution.index] = solution.pressure
    carried = float(pressure.sum()) * area
    load_error = 0.0 if load is None else abs(carried - load) / load
    status = solution.status
    if status is solver.Status.CONVERGED and load_error > LOAD_TOLERANCE:
        status = solver.Status.STALLED
    final_gap = solution.gap.astype(np.float64, copy=False)
    if valid < final_gap.size:
        final_gap[np.isinf(final_gap)] = np.nan
    result = ContactResult(
        surface=surface,
        counter_surface=counter_surface,
        material=material,
        counter_material=counter_material,
        contact_modulus=modulus,
        ceiling=resolved,
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
        status=status.value,
        iterations=solution.iterations,
        convolutions=solution.convolutions,
        seconds=time.perf_counter() - began,
        version=__version__,
    )
    if not result.converged and on_failure == "raise":
        raise ConvergenceError(
            f"not converged: certificate {result.certificate:.1e} (tolerance {tolerance:.0e}), "
            f"load error {load_error:.1e} after {result.convolutions} convolutions: "
            f"{result.status}",
            result,
        )
    return result


def operators(
    boundary: str,
    pixel: tuple[float, float],
    modulus: float,
    precision: str,
    workspace: convolution.Workspace,
) -> solver.Operator:
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
        raise InputError(f"{name} must be {choices}, got {value!r}")


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
            f"counter_surface has {counter_surface.shape} pixels of {counter_surface.pixel} m, "
            f"surface {surface.shape} of {surface.pixel} m: both bodies need the same grid"
        )


def _ceiling(
    ceiling: str | float | ArrayLike | None,
    material: Material,
    counter_material: Material,
    shape: tuple[int, int],
) -> float | NDArray[np.float64] | None:
    if isinstance(ceiling, str):
        check_choice("ceiling", ceiling, ("auto",))
        body = softer(material, counter_material)
        return None if body is None else CEILING_FACTOR * (body.yield_strength or math.inf)
    if ceiling is None:
        return None
    try:
        given = np.asarray(ceiling)
    except ValueError:
        raise InputError("ceiling must be a number or a map, got rows of unequal length") from None
    if given.dtype.kind not in "fiu" or isinstance(ceiling, np.ma.MaskedArray):
        raise InputError(f"ceiling must be real numbers [Pa], got {type(ceiling).__name__}")
    values = given.astype(np.float64)
    if values.ndim == 0:
        require_positive(ceiling=float(values))
        return float(values)
    if values.shape != shape:
        raise InputError(f"ceiling has shape {values.shape}, the surface {shape}")
    if not (values > 0).all():
        smallest = float(values.min())
        raise InputError(f"ceiling must be positive everywhere [Pa], its smallest is {smallest!r}")
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
            f"load = {load:.6g} N is more than the surface can carry: the ceiling times the "
            f"area of its valid pixels is {capacity:.6g} N"
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
