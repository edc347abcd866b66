"""Contact with plasticity of the volume: residual displacement and stress, hardening, unloading.

`solve_elastoplastic` follows a path of loads, load by load; what happens at one of them stands in
`roughcontact.volume.loop`.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._version import __version__
from roughcontact.contact.result import ContactResult
from roughcontact.contact.solve import LOAD_TOLERANCE
from roughcontact.errors import ConvergenceError
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.fft import Workspace
from roughcontact.material.material import RIGID, Material, contact_modulus
from roughcontact.solvers import bounded
from roughcontact.surface.surface import Surface
from roughcontact.volume import checks, steps
from roughcontact.volume.contact_solver import CONTACT_TOLERANCE, untouched
from roughcontact.volume.extent import first_volume
from roughcontact.volume.loop import Loop, Progress
from roughcontact.volume.memory import check_memory
from roughcontact.volume.problem import Problem
from roughcontact.volume.result import ElastoplasticResult, Increment

Array = NDArray[Any]

# No volume of that depth has fewer layers.
_LEAST_LAYERS = 10

TOLERANCE = 1e-4
"""Residual of the plastic strain at which an increment is done."""


def solve_elastoplastic(
    surface: Surface,
    *,
    material: Material,
    load: float | None = None,
    loads: Sequence[float] | None = None,
    counter_material: Material = RIGID,
    counter_surface: Surface | None = None,
    boundary: str = "free",
    increments: int = 10,
    depth: float | None = None,
    layers: ArrayLike | None = None,
    tolerance: float = TOLERANCE,
    max_iterations: int = 150,
    precision: str = "single",
    start: ElastoplasticResult | None = None,
    on_failure: str = "raise",
    folder: str | os.PathLike[str] | None = None,
    progress: Callable[[Progress], None] | None = None,
) -> ElastoplasticResult:
    """Press bodies together that yield in their volume, along a path of loads.

    Parameters
    ----------
    surface : Surface
        Heights of the rough body, without unhandled holes.
    material, counter_material : Material
        Of the rough body and of its counter-body: elastic without a yield strength, perfectly
        plastic with one, hardening with ``hardening``. At least one yields.
    load : float
        Last load [N], reached in ``increments`` equal steps; give either this or ``loads``.
    loads : sequence of float
        Loads one after the other [N]; zero takes the bodies apart.
    counter_surface : Surface, optional
        Heights of the counter-body on the same grid; a flat without it.
    boundary : {"free", "periodic"}
        Whether the map is all there is, or one period of an endless surface.
    increments : int
        Steps to ``load``.
    depth : float, optional
        Depth of the layers [m]; by default three radii of the largest contact spot, and more as
        soon as plastic strain reaches the bottom.
    layers : array_like, optional
        Thickness of each layer [m] instead of graded ones.
    tolerance : float
        Residual of the plastic strain, see `Increment`.
    max_iterations : int
        Iterations at one load; an increment that needs more is halved.
    precision : {"double", "single"}
        Arithmetic of the volume; single changes pressures by about 1e-5.
    start : ElastoplasticResult, optional
        Result to go on from: same bodies, same boundary.
    on_failure : {"raise", "return"}
        What to do if the path cannot be followed to its end.
    folder : path, optional
        Where the state at every load asked for is saved as soon as it is reached, as
        ``step-0001.nc`` and so on; made if it does not exist. The same call on the same folder goes
        on after the last of them and ends with the same numbers. Loads may be added at the end as
        long as the layers stay as they are, which the largest load sets.
    progress : callable, optional
        Called with a `Progress` after every iteration, and once for what stood in the folder.

    Returns
    -------
    ElastoplasticResult
        The state after the last load.

    Raises
    ------
    InputError
        If an argument cannot be used; the message names it and its value. If the folder holds
        another run.
    FormatError
        If a file in the folder is damaged.
    CapacityError
        If nothing can touch.
    InsufficientMemoryError
        If the problem does not fit into the memory that is free.
    ConvergenceError
        If the path was left early; its ``result`` is the state at the last load reached. The
        loads before stay in the folder.

    Notes
    -----
    Small strains on a half-space: contacts small against the radii of the bodies. Stress is the
    average over a layer and, in the plane, the value at the centre of a pixel. With perfect
    plasticity the pressure of single pixels scatters by 5 to 10 %, more at the rim of the
    contact: a field without volume change has too few freedoms there. Means over rings or 3 × 3
    pixels are right; a little hardening removes the scatter.

    References
    ----------
    Jacq, Nélias, Lormand and Girodin, J. Tribol. 124 (2002) 653, doi:10.1115/1.1467920;
    Frérot, Bonnet, Molinari and Anciaux, CMAME 351 (2019) 951, doi:10.1016/j.cma.2019.04.006

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact import Material, Surface
    >>> y, x = np.mgrid[-8:8, -8:8] * 1.5e-6
    >>> ball = Surface(-(x**2 + y**2) / (2 * 105e-6), pixel=(1.5e-6, 1.5e-6))
    >>> steel = Material(young=210e9, poisson=0.3, yield_strength=1.6e9)
    >>> result = solve_elastoplastic(ball, material=steel, loads=[0.3, 0.0])
    >>> result.status, result.regime
    ('converged', 'plastic up to the surface')
    """
    began = time.perf_counter()
    problem = Problem(
        surface, counter_surface, material, counter_material, Boundary(boundary), tolerance,
        max_iterations, precision,
    )  # fmt: skip
    checks.check_arguments(problem, increments, depth, layers, start, on_failure)
    path = checks.path_of(
        load, loads, int(increments), 0.0 if start is None else start.contact.load
    )
    # Before anything of the size of the map is made; again once the volume is known.
    least = np.size(layers) if layers is not None else _LEAST_LAYERS
    check_memory(surface.shape, least, max(len(problem.yielding), 1), boundary, precision)
    workspace = Workspace()
    contact = untouched(problem, workspace)
    checks.check_capacity(problem, contact, max(path))
    if start is None:
        thickness, margin = first_volume(problem, contact, max(path), depth, layers)
    else:
        thickness, margin = start.bodies[0].thickness, start.bodies[0].margin
    grid = surface.shape[0] + 2 * margin, surface.shape[1] + 2 * margin
    check_memory(grid, thickness.size, len(problem.yielding), boundary, precision)
    files: list[Path] = []
    if folder is not None:
        volume = [margin, layers is None, *thickness]
        files = steps.files(folder, len(path), problem, start, volume)
    kept = next((n for n, step in enumerate(files) if not step.exists()), len(files))
    before, carried = start, dict[str, Array]()
    if kept:
        before, carried = steps.kept(files[kept - 1], path[:kept], problem)
        began -= before.seconds
        thickness, margin = before.bodies[0].thickness, before.bodies[0].margin
        if progress is not None:
            residual = before.increments[-1].residual
            progress(Progress(before.contact.load, path[-1], 0, residual, tolerance))
        if kept == len(path):
            return _judged(before, on_failure, folder)
    loop = Loop(problem, contact, workspace, path[-1], progress)
    loop.resize(thickness, margin)
    done: list[Increment] = []
    if before is not None:
        loop.resume(before, carried)
        done = list(before.increments)

    widen = bool(problem.boundary.free_axes)
    result, status = None, "converged"
    for number in range(kept, len(path)):
        result = None
        loop.thaw()
        status = loop.follow([path[number]], done, deepen=layers is None, widen=widen)
        if status != "converged":
            break
        if files:
            result = _result(loop, problem, done, status, began)
            steps.save(
                result, files[number], loop.carried() | {"loads": np.array(path[: number + 1])}
            )
    if result is None:
        result = _result(loop, problem, done, status, began)
    return _judged(result, on_failure, folder)


def _judged(
    result: ElastoplasticResult, on_failure: str, folder: str | os.PathLike[str] | None
) -> ElastoplasticResult:
    """Return a result, or raise if its path was left early."""
    if not result.converged and on_failure == "raise":
        kept = "" if folder is None else f"; the loads before it are kept in {folder}"
        raise ConvergenceError(
            f"{result.status}; the state at {result.contact.load:.6g} N is kept{kept}", result
        )
    return result


def _result(
    loop: Loop, problem: Problem, done: list[Increment], status: str, began: float
) -> ElastoplasticResult:
    """Solve the contact once more on the strain accepted, and collect all."""
    load = done[-1].load if done else 0.0
    surface = problem.surface
    contact = loop.contact
    before, loaded = contact.convolutions, contact.loaded
    nothing, none = loop.nothing()
    displacement = np.zeros(contact.initial_gap.shape)
    for body, places, added in zip(loop.bodies, nothing, none, strict=True):
        displacement += body.displacement(places, added, trace=True)
    contact.press(displacement, load, CONTACT_TOLERANCE)
    # The next load starts from where the loop ended, whether or not anyone looks at this one.
    contact.loaded = loaded
    solution = contact.solution
    gap = (
        contact.initial_gap + displacement - contact.approach if solution is None else solution.gap
    )
    gap = gap[contact.inside].copy()
    gap[np.isinf(gap)] = np.nan
    finished = [body.finished(contact.pressure, loop.margin) for body in loop.bodies]
    carried = float(contact.pressure.sum()) * surface.pixel[0] * surface.pixel[1]
    load_error = abs(carried - load) / load if load else 0.0
    contact_status = bounded.Status.CONVERGED if solution is None else solution.status
    if contact_status is bounded.Status.CONVERGED and load_error > LOAD_TOLERANCE:
        contact_status = bounded.Status.STALLED
    seconds = time.perf_counter() - began
    pressed = ContactResult(
        surface=surface,
        counter_surface=problem.counter_surface,
        material=problem.material,
        counter_material=problem.counter_material,
        contact_modulus=contact_modulus(problem.material, problem.counter_material),
        ceiling=None,
        boundary=problem.boundary,
        precision="double",
        tolerance=CONTACT_TOLERANCE,
        control="load",
        load=load,
        approach=contact.approach,
        pressure=contact.pressure[contact.inside].copy(),
        gap=gap,
        certificate=0.0 if solution is None else solution.certificate,
        load_error=load_error,
        status=contact_status.value,
        iterations=0 if solution is None else solution.iterations,
        convolutions=contact.convolutions - before,
        seconds=seconds,
        version=__version__,
    )
    if status == "converged" and not pressed.converged:
        status = f"the contact did not converge at the last load: {pressed.status}"
    return ElastoplasticResult(
        contact=pressed,
        residual_displacement=displacement[contact.inside].copy(),
        bodies=tuple(body for body, _ in finished),
        increments=tuple(done),
        yield_excess=max(excess for _, excess in finished),
        precision=problem.precision,
        tolerance=problem.tolerance,
        status=status,
        seconds=seconds,
        version=__version__,
    )
