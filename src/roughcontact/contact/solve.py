"""Solution of the contact of two bodies."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._tools.arguments import validate_arguments
from roughcontact.contact import plausibility, validation
from roughcontact.contact.ceiling import (
    confinement,
    first_ceiling,
    is_bracket,
    resolve_ceiling,
    solve_calibrated,
)
from roughcontact.contact.load_case import Load, LoadCase, ProblemUnits, resolve_force
from roughcontact.contact.pair import CounterSurface, Pair
from roughcontact.contact.result import BASE, CALIBRATED, Calibrated, ContactResult
from roughcontact.contact.spots import center_of_pressure
from roughcontact.errors import (
    CapacityError,
    ConvergenceError,
    InsufficientMemoryError,
    Sentence,
    message_parts,
    require_choice,
)
from roughcontact.halfspace.fft import Workspace
from roughcontact.halfspace.gpu import runs_on_device
from roughcontact.material.material import RIGID, Material
from roughcontact.solvers import bounded, rigid_tilt
from roughcontact.solvers.problem import Loaded, project
from roughcontact.solvers.progress import Status, Step, Tell, progress_callback, shows_progress_bar
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantities, Quantity, to_si

CALIBRATED_TOLERANCE = 4e-2
"""Certificate for the calibrated ceiling: areas to 5e-3, a tenth of the error of the rule."""

LOAD_TOLERANCE = 1e-10
"""Maximum load error of a converged result."""

MOMENT_TOLERANCE = 1e-8
"""Maximum moment error of a converged result."""

Watch = Callable[[Step], None] | None

MOMENT_ERROR_TEXT = (
    "moments not balanced; the point of the load may be too close to the edge of the contact"
)
"""Status of a result whose moments are not balanced at any tilt."""


@shows_progress_bar
@runs_on_device
@validate_arguments
def solve(
    surface: Surface,
    *,
    material: Material,
    load: Quantity | Load | None = None,
    approach: Quantity | None = None,
    moments: Quantities | None = None,
    counter_material: Material = RIGID,
    counter_surface: CounterSurface | None = None,
    ceiling: Quantity | ArrayLike | None = "auto",
    boundary: str = "free",
    tolerance: float | None = None,
    max_iterations: int = 2000,
    precision: str = "double",
    device: str | None = None,
    initial_guess: ContactResult | ArrayLike | None = None,
    on_failure: str = "raise",
    on_interrupt: str = "raise",
    progress: Tell = None,
    calibrated: bool = True,
    workers: int | None = None,
) -> ContactResult:
    """Solve the contact of two bodies: pressure, real contact area and gap.

    Parameters
    ----------
    surface : Surface
        Heights of the rough body, without missing points.
    material, counter_material : Material
        Material of the rough body and of its counter-body, or its name in the catalog, such as
        ``"42CrMo4"``; the counter-body is rigid by default.
    load : float, str, quantity of pint, NominalPressure, LineLoad or HertzPressure
        Normal load W: a number in N, or a text with its unit, as for all quantities. Give either
        ``load`` or ``approach``. ``"50 N"`` is a force, ``"20 MPa"`` a pressure on the area of the
        whole map, ``"600 N/mm"`` a load per length of the map along a nominal cylinder.
        ``"hertz 1.5 GPa"`` is the load at which the smooth nominal bodies have this peak pressure.
        For a profile, a load per length, in N/m or as ``"600 N/mm"``.
    approach : float, str or quantity of pint
        Approach ω of the bodies from the first touch [m].
    moments : (float, float), optional
        Moments ``(W y, W x)`` [N·m] of a load at the point (y, x) from the map center. The bodies
        tilt until the pressure balances them. By default they do not tilt.
    counter_surface : Surface or nominal body, optional
        Heights of the counter-body on the same grid, point by point over the first map (mirror a
        map that was measured from its own front), or a body such as ``rc.sphere("6 mm")``; a
        flat by default.
    ceiling : "auto", "calibrated", float, str, quantity of pint, array_like or None
        Largest pressure [Pa], a number or an array of one per pixel; or a hardness, such as
        ``"62 HRC"``. ``"auto"`` is the smaller ceiling of the bodies: three times the yield
        strength or, without one, the hardness; none if neither is known. ``"calibrated"`` starts
        with it and repeats the solve until the ceiling reproduces the contact area of the
        elastoplastic model (`recommended_ceiling`). ``None`` is purely elastic. A coated body needs
        one, unless an uncoated counter-body is the softest: ``"coating"`` or ``"base"``, the
        ceiling of the outermost layer or of the material below all layers; ``"bracket"`` solves
        with both, the second for ``calibrated`` of the result.
    boundary : {"free", "periodic", "periodic-x", "periodic-y"}
        Whether contact occurs only inside the map, or the map is one period of an endless surface
        or of a strip that is endless along one axis; see `Boundary`.
    tolerance : float, optional
        Certificate ε at which the result is converged; 1e-6, or 1e-4 in single precision.
    max_iterations : int
        Maximum number of convolutions per grid (two more may be needed to check the result).
    precision : {"double", "single"}
        Arithmetic of the transforms; single needs about two thirds of the memory, with a
        certificate of 1e-4 (it usually reaches a few 1e-6).
    device : {"cpu", "cuda"}, optional
        Device that computes the displacement: the processor by default, or a GPU with PyTorch
        (extra ``gpu``). The certificate is computed in the same way on both.
    initial_guess : ContactResult or array_like of shape (ny, nx), optional
        Solution of a similar problem on the same grid, or its pressure [Pa].
    on_failure : {"raise", "return"}
        Response to a result above the tolerance.
    on_interrupt : {"raise", "return"}
        Response to Ctrl-C: raise ``KeyboardInterrupt``, or return the best result so far, marked
        as not converged.
    progress : callable or bool, optional
        ``True`` draws a bar on standard error; a function is called with a `Progress`, whose step
        is a `Step`, every time the solver has checked the whole map.
    calibrated : bool
        Whether to solve again under the calibrated ceiling (`recommended_ceiling`) if it changes
        the contact area, for ``calibrated`` of the result. It takes about half as long as the
        solve itself.
    workers : int, optional
        Threads; by default one for each core that the process may use.

    Returns
    -------
    ContactResult
        The solution with its certificate.

    Raises
    ------
    InputError
        If an argument cannot be used; the message names it and its value. Without PyTorch or a
        CUDA device, ``device="cuda"`` is one.
    CapacityError
        If the load exceeds the ceiling times the area, no contact is possible, or no pressure
        balances the moments.
    InsufficientMemoryError
        If the problem does not fit into the free memory.
    ConvergenceError
        If the tolerance was not reached; its ``result`` is the best one.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact import Material, Surface, solve
    >>> y, x = np.mgrid[-32:32, -32:32] * 1e-6
    >>> ball = Surface(-(x**2 + y**2) / (2 * 0.01), pixel=(1e-6, 1e-6))
    >>> steel = Material(young=210e9, poisson=0.3, yield_strength=1e9)
    >>> result = solve(ball, material=steel, load=0.1)
    >>> print(result.status, "and", result.regime)
    converged and below first yield
    """
    pair = Pair.from_arguments(surface, material, counter_surface, counter_material, boundary)
    force, specified = resolve_force(load, pair)
    moved, turned = to_si(approach, "length", "approach"), to_si(moments, "moment", "moments")
    result = solve_case(
        pair,
        LoadCase(force, moved, turned, ceiling, tolerance, max_iterations, precision, specified),
        progress,
        start=initial_guess,
        on_failure=on_failure,
        on_interrupt=on_interrupt,
        workers=workers,
    )
    return result if not calibrated else add_calibrated(result, ceiling, max_iterations, progress)


def solve_case(pair: Pair, terms: LoadCase, progress: Tell = None, **how: Any) -> ContactResult:
    """Return the contact of two bodies, of a coated one under the first of both ceilings."""
    terms = replace(terms, ceiling=first_ceiling(pair, terms.ceiling))
    return solve_pair(pair, terms, progress=progress_callback(progress, 1, 1), **how)


def add_calibrated(
    first: ContactResult,
    ceiling: Quantity | ArrayLike | None = "auto",
    max_iterations: int = 2000,
    progress: Tell = None,
) -> ContactResult:
    """Return a contact with its changes under the calibrated ceiling, if needed."""
    bracket = is_bracket(first.pair, ceiling)
    label = "ceiling of the base" if bracket else "calibrated ceiling"
    watch = progress_callback(progress, 1, 1, label)
    terms = LoadCase(
        **{first.control: getattr(first, first.control)},
        moments=first.moments,
        tolerance=first.tolerance,
        max_iterations=max_iterations,
        precision=first.precision,
    )
    other = _under_base(first, terms, watch) if bracket else _solve_calibrated(first, terms, watch)
    result = replace(first, calibrated=other)
    # Its spots and totals are those of the first solve.
    vars(result).update({n: v for n, v in vars(first).items() if n in ("_spots", "totals")})
    return result


def solve_pair(
    pair: Pair,
    terms: LoadCase,
    *,
    start: ContactResult | ArrayLike | None = None,
    on_failure: str = "raise",
    on_interrupt: str = "raise",
    progress: Watch = None,
    workers: int | None = None,
) -> ContactResult:
    """Solve the contact of a pair; see `solve`."""
    require_choice(("raise", "return"), on_failure=on_failure, on_interrupt=on_interrupt)
    validation.check_profile(pair, terms)
    if isinstance(terms.ceiling, str) and terms.ceiling == CALIBRATED:
        return _solve_self_consistent_ceiling(pair, terms, start, on_failure, progress)
    began = time.perf_counter()
    stated = validation.build_problem(pair, terms, start)
    work = Workspace(workers)
    watch = {"progress": progress, "interruptible": on_interrupt == "return"}
    solution, slope = _solve_problem(pair, terms, stated, work, start, **watch)
    # A stored error would keep the memory of the solve alive.
    del stated.problem, work
    result = _make_result(pair, terms, stated, solution, slope, began)
    requested = solution.status is Status.INTERRUPTED
    if not result.converged and on_failure == "raise" and not requested:
        raise _error_result(result)
    return result


def _solve_self_consistent_ceiling(
    pair: Pair,
    terms: LoadCase,
    start: ContactResult | ArrayLike | None,
    on_failure: str,
    progress: Watch,
) -> ContactResult:
    """Return the contact under its calibrated ceiling, with the cost of all solves."""
    solves: list[ContactResult] = []

    def solve_at_ceiling(ceiling: Any, start: ContactResult | ArrayLike | None) -> ContactResult:
        fixed = replace(terms, ceiling=ceiling)
        result = solve_pair(pair, fixed, start=start, on_failure=on_failure, progress=progress)
        solves.append(result)
        return result

    result = solve_calibrated(
        solve_at_ceiling(_first_ceiling(pair, terms), start), solve_at_ceiling
    )
    return replace(
        result,
        iterations=sum(item.iterations for item in solves),
        convolutions=sum(item.convolutions for item in solves),
        seconds=sum(item.seconds for item in solves),
    )


def _first_ceiling(pair: Pair, terms: LoadCase) -> Any:
    """Return the usual ceiling [Pa], or that of confined spots if the load exceeds the usual."""
    ceiling = resolve_ceiling(terms.ceiling, pair)
    if terms.load is None or pair.boundary.free_axes or not isinstance(ceiling, float):
        return ceiling
    touchable = np.count_nonzero(np.isfinite(pair.initial_gap)) * pair.pixel_area
    ratio = terms.load / touchable / ceiling
    return ceiling if ratio < 1 else ceiling * confinement(ratio)


def _solve_calibrated(first: ContactResult, terms: LoadCase, watch: Watch) -> Calibrated | None:
    """Return the contact under the ceiling calibrated from its solution."""
    advice = plausibility.deviating_ceiling(first) if first.converged else None
    if advice is None:
        return None
    start = first.pressure
    if first.control == "load":
        start = _predicted_pressure(first, advice.ceiling)
        ahead = replace(first, pressure=start, ceiling=advice.ceiling)
        advice = plausibility.recommended_ceiling_of(ahead) or advice
    tolerance = max(terms.certificate, CALIBRATED_TOLERANCE)
    terms = replace(terms, ceiling=advice.ceiling, tolerance=tolerance)
    if terms.moments is None:
        terms = replace(terms, precision="single")
    return _solve_again(first, terms, start, watch, advice.factor, advice.load_ratio)


def _under_base(first: ContactResult, terms: LoadCase, watch: Watch) -> Calibrated | None:
    """Return the contact of a coated body under the ceiling of its base."""
    if not first.converged:
        return None
    terms = replace(terms, ceiling=BASE)
    return _solve_again(first, terms, first.pressure, watch)


def _solve_again(
    first: ContactResult,
    terms: LoadCase,
    start: NDArray[np.float64],
    watch: Watch,
    factor: float = math.nan,
    load_ratio: float = math.nan,
) -> Calibrated | None:
    """Return the same contact under another ceiling."""
    try:
        result = solve_pair(first.pair, terms, start=start, on_failure="return", progress=watch)
    except (CapacityError, InsufficientMemoryError):
        return None
    if not result.converged:
        return None
    changes = (
        abs(getattr(result, n) - getattr(first, n)) / (getattr(first, n) or math.inf)
        for n in ("contact_fraction", "saturated_fraction", "mean_gap")
    )
    named = {n: getattr(result, n) for n in Calibrated.__dataclass_fields__ if hasattr(result, n)}
    named["max_indentation"] = result.totals.max_indentation
    return Calibrated(**named, factor=factor, load_ratio=load_ratio, change=max(changes))


def _predicted_pressure(first: ContactResult, ceiling: float) -> NDArray[np.float64]:
    """Return the pressure after a projected gradient step under another ceiling [Pa]."""
    # K₀₀ of a square pixel of this area.
    unit = 4 * math.log1p(math.sqrt(2)) / math.pi
    unit *= math.sqrt(first.pixel_area) / first.contact_modulus
    target = first.pressure - np.nan_to_num(first.gap, nan=math.inf) / unit
    total = first.load / first.pixel_area
    # Pixels that may touch, widened until they can carry the load.
    reach = ceiling
    near = np.nonzero(target > -reach)
    while near[0].size * ceiling < total and reach < math.inf:
        reach *= 2
        near = np.nonzero(target > -reach)
    pressure = np.zeros_like(target)
    pressure[near] = project(target[near], ceiling, total)
    return pressure


def _solve_problem(
    pair: Pair,
    terms: LoadCase,
    stated: validation.ContactProblem,
    workspace: Workspace,
    start: ContactResult | ArrayLike | None,
    **options: Any,
) -> tuple[bounded.BoundedSolution, tuple[float, float]]:
    """Return the solution and the tilt."""
    units = stated.scale
    options |= {
        "tolerance": terms.certificate,
        "max_iterations": int(terms.max_iterations),
        "start": None if start is None else _loaded_pixels(start, units),
    }
    make = pair.operators(terms.precision, workspace, units.pressure / units.length)
    if stated.target is None:
        return bounded.solve(stated.problem, make, **options), (0.0, 0.0)
    pixel = pair.pixel[0] / units.length, pair.pixel[1] / units.length
    return rigid_tilt.solve(stated.problem, make, stated.target, pixel, **options)


def _loaded_pixels(start: ContactResult | ArrayLike, units: ProblemUnits) -> Loaded:
    """Return the indices of pixels with pressure, and the pressure in solver units."""
    pressure = start.pressure if isinstance(start, ContactResult) else np.asarray(start)
    index = np.flatnonzero(pressure)
    return index, pressure.ravel()[index] / units.pressure


def _make_result(
    pair: Pair,
    terms: LoadCase,
    stated: validation.ContactProblem,
    solution: bounded.BoundedSolution,
    slope: tuple[float, float],
    began: float,
) -> ContactResult:
    units = stated.scale
    pressure = np.zeros(solution.gap.shape)
    pressure.ravel()[solution.index] = solution.pressure
    pressure *= units.pressure
    if stated.ceiling is not None:
        # A ceiling too small for the units of the solver is kept to the last digit, too.
        np.minimum(pressure, stated.ceiling, out=pressure)
    carried = float(pressure.sum()) * pair.pixel_area
    load = carried if terms.load is None else terms.load
    load_error = 0.0 if terms.load is None else abs(carried - load) / load
    gap = solution.gap.astype(np.float64, copy=False)
    gap *= units.length
    if stated.holes:
        gap[np.isinf(gap)] = np.nan
    moments = terms.moments
    return ContactResult(
        pair=pair,
        ceiling=stated.ceiling,
        precision=terms.precision,
        tolerance=terms.certificate,
        control=terms.control,
        load=load,
        approach=solution.approach * units.length,
        pressure=pressure,
        gap=gap,
        certificate=solution.certificate,
        load_error=load_error,
        status=_solve_status(pair, stated, solution, pressure, load_error),
        iterations=solution.iterations,
        convolutions=solution.convolutions,
        seconds=time.perf_counter() - began,
        tilt=slope,
        moments=None if moments is None else (float(moments[0]), float(moments[1])),
        specified_load=terms.specified,
    )


def _solve_status(
    pair: Pair,
    stated: validation.ContactProblem,
    solution: bounded.BoundedSolution,
    pressure: NDArray[np.float64],
    load_error: float,
) -> str:
    """Return why the solver stopped, or another reason against convergence."""
    status = solution.status
    if status is Status.CONVERGED and load_error > LOAD_TOLERANCE:
        status = Status.STALLED
    if status is Status.CONVERGED and stated.target is not None:
        centre = np.array(center_of_pressure(pressure, pair.pixel)) / max(pair.size)
        if np.abs(centre - stated.target).max() > MOMENT_TOLERANCE:
            return MOMENT_ERROR_TEXT
    return status.value


def _error_result(result: ContactResult) -> ConvergenceError:
    moments = f", moment error {result.moment_error:.1e}" if result.moments is not None else ""
    text = (
        f"not converged: certificate {result.certificate:.1e} (tolerance {result.tolerance:.0e}), "
        f"load error {result.load_error:.1e}{moments} after {result.convolutions} convolutions: "
    )
    return ConvergenceError(Sentence(text, *message_parts(result.status)), result)


def solve_without_ceiling(result: ContactResult) -> ContactResult:
    """Return the solution of the same problem without a ceiling."""
    if result.ceiling is None:
        return result
    terms = LoadCase(
        load=result.load,
        moments=result.moments,
        ceiling=None,
        tolerance=result.tolerance,
        precision=result.precision,
    )
    return solve_pair(result.pair, terms)
