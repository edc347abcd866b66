"""Contact with plasticity of the volume: hardening, unloading, residual fields.

`solve_elastoplastic` solves a path of loads, load by load; `roughcontact.elastoplastic.increments`
solves each load.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._tools import memory
from roughcontact._tools.arguments import validate_arguments
from roughcontact._tools.checkpoints import lock_folder
from roughcontact._version import __version__
from roughcontact.contact.load_case import Load, resolve_force
from roughcontact.contact.pair import CounterSurface, Pair
from roughcontact.contact.result import ContactResult
from roughcontact.contact.solve import LOAD_TOLERANCE
from roughcontact.contact.validation import as_finite_row, check_holes
from roughcontact.elastoplastic import increments as stepping, problem as setup
from roughcontact.elastoplastic.checkpoints import Checkpoint, CheckpointSeries, run_record
from roughcontact.elastoplastic.increments import AUTO, IncrementLoop, IterationInfo, points_between
from roughcontact.elastoplastic.problem import (
    MIN_LAYERS,
    ContactSolver,
    ElastoplasticProblem,
    Extent,
    first_extent,
    solve_without_load,
)
from roughcontact.elastoplastic.volume_result import (
    CONVERGED,
    ElastoplasticResult,
    Increment,
    PathPoint,
)
from roughcontact.errors import (
    ArgumentRef,
    CapacityError,
    ConvergenceError,
    InputError,
    Sentence,
    input_error,
    message_parts,
    require_choice,
    require_count,
    require_positive,
)
from roughcontact.halfspace.fft import Workspace
from roughcontact.material.material import RIGID, Material
from roughcontact.solvers.progress import Progress, Status, Tell, shows_progress_bar
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantities, Quantity, to_si

# Upper bound of the mean pressure over the yield strength under a flat punch with the outline of a
# map: the limit load is 2.97 for a strip, 3.28 for a disc (shear strength σ_Y/√3; Hill 1950, Shield
# 1955).
_PUNCH = 3.5


def check_arguments(
    problem: ElastoplasticProblem,
    increments: int | str,
    depth: float | None,
    layers: ArrayLike | None,
    start: ElastoplasticResult | None,
    on_failure: str,
) -> None:
    """Raise `InputError` for an invalid argument of `solve_elastoplastic`."""
    pair = problem.pair
    pair.require_map("plasticity of the volume", coated=False)
    precision, tolerance = problem.precision, problem.tolerance
    pair.boundary.require_known_below("the volume model")
    require_choice(("double", "single"), precision=precision)
    require_choice(("raise", "return"), on_failure=on_failure)
    if isinstance(increments, str) and increments != AUTO:
        raise input_error("increments", increments, f"must be a whole number, or {AUTO!r}")
    if not isinstance(increments, str):
        require_count(1, memory.STEPS, increments=increments)
    require_count(1, memory.ITERATIONS, max_iterations=problem.max_iterations)
    require_positive(tolerance=tolerance)
    if tolerance < 1e-6 and precision == "single":
        raise InputError(
            f"= {tolerance!r} is below the limit of single precision; set 1e-6 or more, or "
            f"{ArgumentRef('precision', 'double')}",
            argument="tolerance",
            value=tolerance,
        )
    _check_layers(depth, layers, min(pair.pixel))
    check_holes(pair)
    for body in (pair.material, pair.counter_material):
        if body.yield_strength is not None and math.isinf(body.young):
            raise InputError("a rigid material cannot yield: give it a Young's modulus")
    if min(pair.shape) < 8:
        raise InputError(f"has {pair.shape} pixels: give at least 8 × 8", argument="surface")
    if start is None:
        return
    if depth is not None or layers is not None:
        raise InputError(
            f"contains its layers: leave out {ArgumentRef('depth')} and {ArgumentRef('layers')}",
            argument="start",
        )
    problem.check_same("start", start)


def _check_layers(depth: float | None, layers: ArrayLike | None, pixel: float) -> None:
    """Raise `InputError` for an invalid depth or layers, or for both at once."""
    if depth is not None:
        require_positive(depth=depth)
        if depth < pixel:
            raise InputError(
                f"= {depth!r} m is less than a pixel, {pixel:.4g} m: give a few "
                "radii of a contact spot, or leave it out",
                argument="depth",
            )
        if layers is not None:
            raise InputError(
                f"give either {ArgumentRef('depth')} or {ArgumentRef('layers')}, not both"
            )
    if layers is not None and not (as_finite_row(layers, "layers") > 0).all():
        raise input_error("layers", layers, "must be positive [m]")


def check_capacity(problem: ElastoplasticProblem, solver: ContactSolver, load: float) -> None:
    """Raise `CapacityError` for a load under which a free map yields without limit."""
    if not problem.pair.boundary.free_axes:
        return
    strain = np.array(1e9)
    strongest = min(float(body.law.strength(strain)) for body in problem.yielding)
    capacity = _PUNCH * strongest * solver.area * np.count_nonzero(np.isfinite(solver.initial_gap))
    if load > capacity:
        raise CapacityError(
            f"= {load:.6g} N is more than the map can carry: even in full contact the body yields "
            f"without limit above {capacity:.4g} N, which is {_PUNCH} times the largest yield "
            "strength times the area",
            argument="load",
        )


def points_of_path(
    problem: ElastoplasticProblem,
    requested: tuple[float | None, Quantities | None, Sequence[PathPoint] | None],
    increments: int | str,
    start: ElastoplasticResult | None,
) -> list[PathPoint]:
    """Return the path points of a load, of loads or of a path, in order."""
    load, loads, path = requested[0], to_si(requested[1], "force", "loads"), requested[2]
    if sum(specified is not None for specified in (load, loads, path)) != 1:
        raise InputError(
            f"give either {ArgumentRef('load')}, {ArgumentRef('loads')} or {ArgumentRef('path')}, "
            "and only one of them"
        )
    if path is not None:
        points = _points(path)
        _check_path(problem, points)
    else:
        # A counter-surface that has moved stays at its last offset.
        last = start.increments[-1].offset if start and start.increments else (0.0, 0.0)
        points = [PathPoint(value, last) for value in _load_list(load, loads)]
    if not any(point.load for point in points) and (start is None or start.solution.load == 0):
        raise InputError(
            "are all zero: give at least one above zero",
            argument="loads" if path is None else "path",
        )
    if load is None or isinstance(increments, str):
        return points
    before = start.increments[-1].point if start and start.increments else PathPoint(0.0)
    return points_between(before, points[0], int(increments))


def _check_path(problem: ElastoplasticProblem, points: Sequence[PathPoint]) -> None:
    """Raise `InputError` for a path on which the counter-surface cannot move or slide."""
    pair = problem.pair
    if pair.counter_surface is None and any(any(point.offset) for point in points):
        raise InputError(
            "moves a counter-surface, but the counter-body is flat: give its heights",
            argument="path",
        )
    yields = pair.counter_material.yield_strength is not None
    if yields and pair.boundary.free_axes and any(point.friction for point in points):
        raise InputError(
            "slides a counter-body that yields, with its plastic strain, over a map with a free "
            "boundary, which the model does not include; give a periodic boundary, or leave out "
            "its yield strength or the friction",
            argument="path",
        )


def _points(path: Sequence[PathPoint]) -> list[PathPoint]:
    points = list(path) if isinstance(path, Sequence) else []
    if not points or not all(isinstance(point, PathPoint) for point in points):
        raise InputError(f"must be a row of PathPoint, got {path!r:.80}", argument="path")
    require_count(1, memory.STEPS, path=len(points))
    return points


def _load_list(load: float | None, loads: Sequence[float] | None) -> list[float]:
    """Return the requested loads."""
    if load is not None:
        require_positive(load=load)
        return [float(load)]
    try:
        path = np.array(loads, float)
    except (TypeError, ValueError):
        raise InputError("must be a row of numbers [N]", argument="loads") from None
    if path.ndim != 1 or not path.size or not ((path >= 0) & np.isfinite(path)).all():
        raise input_error("loads", loads, "must be finite and not negative [N]")
    return [float(value) for value in path]


Array = NDArray[Any]

TOLERANCE = 1e-4
"""Residual of the plastic strain at which the iteration of an increment ends."""

# Smallest number of points of a map for several threads: on smaller maps they wait for the
# interpreter, and two threads take up to 1.6 times as long as one.
MIN_SHARED_POINTS = 1 << 15


@shows_progress_bar
@validate_arguments
def solve_elastoplastic(
    surface: Surface,
    *,
    material: Material,
    load: Quantity | Load | None = None,
    loads: Quantities | None = None,
    path: Sequence[PathPoint] | None = None,
    counter_material: Material = RIGID,
    counter_surface: CounterSurface | None = None,
    boundary: str = "free",
    increments: int | str = AUTO,
    depth: Quantity | None = None,
    layers: Quantities | ArrayLike | None = None,
    tolerance: float = TOLERANCE,
    max_iterations: int = 150,
    precision: str = "single",
    start: ElastoplasticResult | None = None,
    on_failure: str = "raise",
    folder: str | os.PathLike[str] | None = None,
    progress: Tell = None,
    on_step: Callable[[int, ElastoplasticResult], object] | None = None,
) -> ElastoplasticResult:
    """Solve a contact with plastic strain below the surface, along a path of loads.

    Parameters
    ----------
    surface : Surface
        Heights of the rough body, without unhandled holes.
    material, counter_material : Material
        Materials of the rough body and of the counter-body: elastic without a yield strength,
        perfectly plastic with one, hardening with ``hardening``. At least one yields.
    load : float, str, quantity of pint, NominalPressure, LineLoad or HertzPressure
        Last load [N], in any form that `roughcontact.solve` accepts; give either this, ``loads``
        or ``path``.
    loads : sequence of float
        Loads in order [N]; zero separates the bodies.
    path : sequence of PathPoint
        Loads in order, with the offset of the counter-surface and full sliding. To a point
        without friction the counter-body rolls without slip: plastic strain keeps its position in
        both bodies, and the counter-surface is a form. To a point with friction it slides, and
        its plastic strain moves with it, on a periodic map. Points are solved in order;
        ``increments`` is ignored.
    counter_surface : Surface or nominal body, optional
        Heights of the counter-body on the same grid, or its form; a flat without it.
    boundary : {"free", "periodic"}
        Whether the body ends with the map, or the map is one period of an endless surface.
    increments : int or "auto"
        Number of equal steps to ``load``; with a number each of ``loads`` is one step. "auto":
        enough steps to each load to keep the step error below 1 % of approach and contact area,
        at most 48 from zero load; see `ElastoplasticResult.step_error`, which is unknown
        otherwise.
    depth : float, optional
        Depth of the layers [m]; by default three radii of the largest contact spot. More layers
        are added when plastic strain reaches the bottom.
    layers : array_like, optional
        Thickness of each layer [m] instead of graded ones.
    tolerance : float
        Residual of the plastic strain to reach, see `Increment`; the contact is solved to a
        hundredth of it, to 1e-6 at most and 1e-10 at least.
    max_iterations : int
        Iterations at one load; an increment that needs more is halved.
    precision : {"double", "single"}
        Arithmetic of the volume; single changes pressures by about 1e-5.
    start : ElastoplasticResult, optional
        Result to resume from: same bodies, same boundary.
    on_failure : {"raise", "return"}
        Response to a path that cannot be followed to its end.
    folder : path, optional
        Folder for the state at every requested load, saved when it is reached as
        ``step-0001.nc`` and so on; created if missing. If the counter-surface moves or slides,
        only the state at the last point is saved, and before it ``latest.nc``, from which a run
        resumes at the last point reached. The same call with the same folder resumes with the
        same numbers. Loads may be added at the end if the layers, which depend on the largest
        load, are unchanged.
    progress : callable or bool, optional
        ``True`` draws a bar on standard error; a function is called with a `Progress` after every
        iteration, and once for the states already in the folder; its ``step`` is a
        `roughcontact.elastoplastic.increments.IterationInfo`.
    on_step : callable, optional
        ``on_step(number, state)`` is called at every requested load, and for the complete states
        in the folder. The folder then keeps every state complete.

    Returns
    -------
    ElastoplasticResult
        State after the last load.

    Raises
    ------
    InputError
        If an argument is invalid; the message names the argument and its value. If the folder is
        in use or contains another run.
    FormatError
        If a file in the folder is damaged or belongs to another run.
    CapacityError
        If no point can touch, or a map with free edges cannot carry the load.
    InsufficientMemoryError
        If the problem does not fit into free memory.
    ConvergenceError
        If the path was not completed; its ``result`` is the state at the last load reached. The
        states before remain in the folder.

    Notes
    -----
    Small strains on a half-space: contacts are small compared with the radii of the bodies. Stress
    is the average over a layer and, in the plane, the value at the center of a pixel. With perfect
    plasticity the pressure of single pixels scatters by 5 to 10 %, more at the rim of the contact:
    a field without volume change has too few degrees of freedom there. Means over rings or 3 × 3
    pixels are accurate; slight hardening removes the scatter.

    References
    ----------
    Jacq, Nélias, Lormand and Girodin, J. Tribol. 124 (2002) 653, doi:10.1115/1.1467920;
    Frérot, Bonnet, Molinari and Anciaux, CMAME 351 (2019) 951, doi:10.1016/j.cma.2019.04.006

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact import Material, Surface
    >>> y, x = np.mgrid[-6:6, -6:6] * 2e-6
    >>> ball = Surface(-(x**2 + y**2) / (2 * 105e-6), pixel=(2e-6, 2e-6))
    >>> steel = Material(young=210e9, poisson=0.3, yield_strength=1.6e9)
    >>> result = solve_elastoplastic(ball, material=steel, load=0.3, increments=3)
    >>> result.status, str(result.regime)
    ('converged', 'plastic up to the surface')
    """
    began = time.perf_counter()
    volume = to_si(depth, "length", "depth"), to_si(layers, "length", "layers")
    pair = Pair.from_arguments(surface, material, counter_surface, counter_material, boundary)
    problem = ElastoplasticProblem(pair, tolerance, max_iterations, precision)
    check_arguments(problem, increments, *volume, start, on_failure)
    force, specified = resolve_force(load, pair)
    points = points_of_path(problem, (force, loads, path), increments, start)
    automatic = increments == AUTO and path is None
    workspace = Workspace(1 if math.prod(pair.shape) < MIN_SHARED_POINTS else None)
    solver, extent = _prepare_solver(problem, points, *volume, start, workspace)
    layered = [extent.margin, layers is None, *extent.thickness]
    loop_in = partial(IncrementLoop, problem, solver, workspace, deepen=layers is None)
    record = partial(run_record, problem, start, layered, automatic)
    with lock_folder(
        folder, record, kind="run", record="volume.json", pattern="step-*.nc"
    ) as place:
        steps = CheckpointSeries(place, problem, points)
        run = _PathRun(problem, points, automatic, steps, progress, began, on_step)
        result = run.final_state(start, extent, loop_in)
    result = replace(result, solution=replace(result.solution, specified_load=specified))
    return _require_complete(result, on_failure, folder)


def _prepare_solver(
    problem: ElastoplasticProblem,
    path: Sequence[PathPoint],
    depth: float | None,
    layers: ArrayLike | None,
    start: ElastoplasticResult | None,
    workspace: Workspace,
) -> tuple[ContactSolver, Extent]:
    """Return the contact solver and the initial extent of the volume for a path."""
    terms = setup.memory_terms(problem)
    # Check before any allocation of the size of the map, and again with the final volume.
    least = MIN_LAYERS if layers is None else np.size(layers)
    setup.require_memory(problem.pair.shape, least, **terms)
    solver = solve_without_load(problem, workspace)
    load = max(point.load for point in path)
    check_capacity(problem, solver, load)
    if start is None:
        extent = first_extent(problem, solver, load, depth, layers)
    else:
        extent = Extent.from_result(start)
    setup.require_memory(extent.grid(problem.pair.shape), extent.thickness.size, **terms)
    return solver, extent


@dataclass
class _PathRun:
    """Run along a path of loads."""

    problem: ElastoplasticProblem  # Inputs of all loads
    path: list[PathPoint]  # Points of the path
    automatic: bool  # Whether the number of steps follows from their error
    steps: CheckpointSeries  # Stored steps
    progress: Tell  # Called after every iteration
    began: float  # Start time, by `time.perf_counter`
    each: Callable[[int, ElastoplasticResult], object] | None = None

    def final_state(
        self,
        start: ElastoplasticResult | None,
        extent: Extent,
        loop_in: Callable[[Extent], IncrementLoop],
    ) -> ElastoplasticResult:
        """Return the state after the last load reached, computed or from the folder."""
        number, before = self.steps.latest()
        if before is not None:
            self.began -= before.seconds
            if callable(self.progress):
                self.progress(Progress(number, len(self.path), None, kept=True))
            for done, state in self.steps.states(number) if self.each else ():
                self._report_progress(done, state)
            if number == len(self.path) and before.result is not None:
                return before.result
        elif start is not None:
            before = Checkpoint.from_result(start)
        loop = loop_in(extent if before is None else before.extent)
        if before is not None:
            loop.resume(before)
        return self._solve_path(loop, number, before)

    def _solve_path(
        self, loop: IncrementLoop, first: int, before: Checkpoint | None
    ) -> ElastoplasticResult:
        """Solve the loads from a number on."""
        done = [] if before is None else list(before.increments)
        largest = (0.0, None) if before is None else before.largest
        result, status = None, CONVERGED
        reach = stepping.visit_load if self.automatic else IncrementLoop.reach
        for number in range(first, len(self.path)):
            result = None
            # The user may keep the states that `each` receives.
            loop.unfreeze_strain(copy=self.each is not None)
            point = self.path[number]
            status = reach(loop, point, done, self._iteration_callback(number))
            if status != CONVERGED:
                break
            # The result contains the pressure under the largest load, also after unloading.
            lowered = any(p.load < point.load for p in self.path[number + 1 : number + 2])
            whole = self.steps.is_full(number, every=self.each is not None)
            if whole or lowered or self.each:
                result = _result(loop, done, status, self.began, largest)
                largest = result.largest
                self._report_progress(number + 1, result)
            if whole and result is not None:
                self.steps.save(number, result, loop.carried_values())
            elif self.steps:
                seconds = time.perf_counter() - self.began
                self.steps.note(number, loop.checkpoint(done, largest, seconds))
        return result or _result(loop, done, status, self.began, largest)

    def _report_progress(self, number: int, state: ElastoplasticResult) -> None:
        if self.each is not None:
            self.each(number, state)

    def _iteration_callback(self, number: int) -> Callable[[float, int, float], None]:
        """Return the callback that reports the iterations at one load of the path."""

        def watch(load: float, iteration: int, residual: float) -> None:
            if callable(self.progress):
                look = IterationInfo(
                    load, self.path[-1].load, iteration, residual, self.problem.tolerance
                )
                self.progress(Progress(number + 1, len(self.path), look))

        return watch


def _require_complete(
    result: ElastoplasticResult, on_failure: str, folder: str | os.PathLike[str] | None
) -> ElastoplasticResult:
    """Return a result, or raise `ConvergenceError` if its path was not completed."""
    if not result.converged and on_failure == "raise":
        hint = "" if folder is None else f"; earlier loads are saved in {folder}"
        raise ConvergenceError(
            Sentence(
                *message_parts(result.status),
                f"; the state at {result.solution.load:.6g} N is kept{hint}",
            ),
            result,
        )
    return result


def _result(
    loop: IncrementLoop,
    done: list[Increment],
    status: str,
    began: float,
    largest: tuple[float, Array | None],
) -> ElastoplasticResult:
    """Solve the contact again with the accepted strain, and collect the results."""
    load = done[-1].load if done else 0.0
    pair = loop.problem.pair_at(done[-1].offset) if done else loop.problem.pair
    problem, solver = loop.problem, loop.solver
    before, loaded = solver.convolutions, solver.loaded
    displacement = loop.displacement()
    solver.solve(displacement, load)
    # The next load starts from the end of the loop, independent of this additional solve.
    solver.loaded = loaded
    finished = [
        body.final_layers(solver.pressure, loop.pull, loop.extent.margin) for body in loop.bodies
    ]
    seconds = time.perf_counter() - began
    pressed = _displaced_contact(
        pair, solver, displacement, load, solver.convolutions - before, seconds
    )
    if status == CONVERGED and not pressed.converged:
        status = Sentence(
            "the contact did not converge at the last load: ", *message_parts(pressed.status)
        )
    return ElastoplasticResult(
        solution=pressed,
        residual_displacement=displacement[solver.inside].copy(),
        bodies=tuple(body for body, _ in finished),
        increments=tuple(done),
        yield_excess=max(excess for _, excess in finished),
        precision=problem.precision,
        tolerance=problem.tolerance,
        status=status,
        seconds=seconds,
        version=__version__,
        largest_pressure=largest[1] if largest[0] > load else None,
    )


def _displaced_contact(
    pair: Pair,
    solver: ContactSolver,
    displacement: Array,
    load: float,
    convolutions: int,
    seconds: float,
) -> ContactResult:
    """Return the contact result of the last solve on the displaced surface."""
    solution = solver.solution
    gap = solver.initial_gap + displacement - solver.approach if solution is None else solution.gap
    gap = gap[solver.inside].copy()
    gap[np.isinf(gap)] = np.nan
    carried = float(solver.pressure.sum()) * pair.pixel[0] * pair.pixel[1]
    load_error = abs(carried - load) / load if load else 0.0
    status = Status.CONVERGED if solution is None else solution.status
    if status is Status.CONVERGED and load_error > LOAD_TOLERANCE:
        status = Status.STALLED
    return ContactResult(
        pair=pair,
        ceiling=None,
        precision="double",
        tolerance=solver.tolerance,
        control="load",
        load=load,
        approach=solver.approach,
        pressure=solver.pressure[solver.inside].copy(),
        gap=gap,
        certificate=0.0 if solution is None else solution.certificate,
        load_error=load_error,
        status=status.value,
        iterations=0 if solution is None else solution.iterations,
        convolutions=convolutions,
        seconds=seconds,
    )
