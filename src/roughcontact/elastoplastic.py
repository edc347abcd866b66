"""Contact with plasticity of the volume: residual displacement and stress, hardening, unloading.

A load increment is one convex problem in the plastic strain that it adds: the elastic energy with
the contact solved for its pressure, plus what plastic flow dissipates and hardening stores. Its
gradient is minus the stress, with Lipschitz constant 2μ on deviators, and the proximal map of
dissipation and hardening is the radial return. So one loop holds all::

    strain → displacement of the surface → pressure of the contact → stress → radial return

A step of it is a proximal gradient step with step size 1/(2μ), which never fails to descend;
Anderson's acceleration makes it fast. Nothing is relaxed and nothing is nested but the solver of
the contact, which starts each time from the pressure before.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from numbers import Integral
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact import halfspace, sections, solver
from roughcontact._version import __version__
from roughcontact.contact import (
    LOAD_TOLERANCE,
    check_bodies,
    check_choice,
    check_surfaces,
    operators,
)
from roughcontact.convolution import Workspace, default_workers
from roughcontact.errors import (
    CapacityError,
    ConvergenceError,
    FormatError,
    InputError,
    InsufficientMemoryError,
    require_positive,
)
from roughcontact.halfspace import HalfSpace
from roughcontact.material import CEILING_FACTOR, RIGID, Material, contact_modulus, softer
from roughcontact.plasticity import Hardening, Perfect, plastic_increment
from roughcontact.result import ContactResult, initial_gap, rim_excess
from roughcontact.sections import DepthProfile, DepthSection, LayerProfile
from roughcontact.surface import Surface

if TYPE_CHECKING:
    from roughcontact.chapters import Section

Array = NDArray[Any]
Parts = list[Array]

# Layers: the first over the shorter edge of a pixel, the growth from one to the next, the depth of
# them all over the radius of the largest contact spot, and in pixels at least.
_FIRST_LAYER = 0.5
_LAYER_RATIO = 1.08
_DEPTH = 3.0
_LEAST_DEPTH = 8.0
# Iterates that Anderson's acceleration remembers; growth of the defect at which it forgets.
_MEMORY = 6
_GROWTH = 3.0
# Iterations without a smaller defect after which plain steps take over, and how many of these.
_PATIENCE = 10
_PLAIN_STEPS = 8
# Relative size below which directions of the memory count as linearly dependent.
_DEPENDENT = 1e-7
# How often a load increment may be halved.
_CUTS = 5
# Depth of the layers over that before, when plastic strain has reached the lowest; growth of the
# volume to each side when it has reached the edge, over the edge of the map.
_DEEPER = 1.3
_WIDER = 0.1

TOLERANCE = 1e-4
"""Residual of the plastic strain at which an increment is done."""

# The contact is solved to this part of the tolerance of the plastic strain while that is sought.
_CONTACT_TOLERANCE = 1e-6
_CONTACT_CONVOLUTIONS = 500
# Rows and columns at the edge of the volume that plastic strain may not reach.
_GUARD = 2
# Stress beyond the yield strength, over it, that is worth a word.
_EXCESS = 0.05
# Mean pressure over the yield strength that no flat punch with the outline of a map reaches: it
# flows at 2.97 on a strip and 3.28 on a disc (shear strength σ_Y/√3; Hill 1950, Shield 1955).
_PUNCH = 3.5
# Distance of the edge of the volume from the contact, over the radius of the largest spot.
_SPAN = 0.8


@dataclass(frozen=True)
class Increment:
    """What one load of the path gave.

    Parameters
    ----------
    load : float
        Normal load [N].
    approach : float
        Approach of the bodies from the first touch [m].
    contact_area : float
        Real contact area [m²].
    max_pressure : float
        Largest pressure [Pa].
    max_plastic_strain : float
        Largest accumulated plastic strain so far.
    plastic_volume : float
        Volume with plastic strain so far, of both bodies [m³].
    residuals : tuple of float
        Largest change of the plastic strain in each iteration over the largest of this increment,
        or over the yield strain σ_Y/(2μ) if that is more.
    convolutions : int
        Convolutions of the contact solver.
    """

    load: float
    approach: float
    contact_area: float
    max_pressure: float
    max_plastic_strain: float
    plastic_volume: float
    residuals: tuple[float, ...]
    convolutions: int

    @property
    def residual(self) -> float:
        """Residual after the last iteration."""
        return self.residuals[-1]

    @property
    def iterations(self) -> int:
        """Iterations of the loop."""
        return len(self.residuals)


@dataclass(frozen=True)
class Progress:
    """One iteration while the loop runs.

    Parameters
    ----------
    load : float
        Load at work [N].
    target : float
        Last load of the path [N].
    iteration : int
        Iterations at this load so far; 0 if this load and those before it stood in the folder.
    residual : float
        See `Increment`.
    tolerance : float
        Residual at which the load is done.
    """

    load: float
    target: float
    iteration: int
    residual: float
    tolerance: float


@dataclass(frozen=True, eq=False)
class PlasticBody:
    """Plastic strain and stress of one body; layers from its surface down.

    Tensors without trace have the components zz, (xx - yy)/2, xy, xz, yz, z into the body;
    `roughcontact.halfspace.tensor` makes matrices of them. Arrays are read-only.

    Parameters
    ----------
    material : Material
        Of the body.
    pixel_area : float
        Area of a pixel [m²].
    margin : int
        Rows and columns of the volume beyond each edge of the map, included in the arrays.
    thickness : ndarray, shape (nz,)
        Thickness of each layer [m].
    plastic_strain : ndarray, shape (nz, 5, ny, nx)
        Plastic strain, constant over each layer.
    accumulated : ndarray, shape (nz, ny, nx)
        Accumulated plastic strain e = ∫ √(2/3 dε:dε).
    stress, mean_stress : ndarray, shapes (nz, 5, ny, nx) and (nz, ny, nx)
        Deviator and a third of the trace of the stress under load, averages over the layers [Pa].
    residual_stress, mean_residual_stress : ndarray
        Those by the plastic strain alone [Pa]: what the load leaves when it is gone, unless the
        body flows again on unloading.
    """

    material: Material
    pixel_area: float
    margin: int
    thickness: NDArray[np.float64]
    plastic_strain: Array
    accumulated: Array
    stress: Array
    mean_stress: Array
    residual_stress: Array
    mean_residual_stress: Array

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    @property
    def depth(self) -> NDArray[np.float64]:
        """Depth of the middle of each layer [m], shape (nz,)."""
        middle: NDArray[np.float64] = np.cumsum(self.thickness) - self.thickness / 2
        return middle

    @property
    def von_mises(self) -> Array:
        """Von Mises stress under load [Pa], shape (nz, ny, nx)."""
        return halfspace.equivalent(self.stress.swapaxes(0, 1))

    @property
    def residual_von_mises(self) -> Array:
        """Von Mises stress by the plastic strain alone [Pa], shape (nz, ny, nx)."""
        return halfspace.equivalent(self.residual_stress.swapaxes(0, 1))

    @property
    def elastic_stress(self) -> Array:
        """Deviator of the stress by the pressure alone [Pa], shape (nz, 5, ny, nx)."""
        elastic: Array = self.stress - self.residual_stress
        return elastic

    @cached_property
    def max_plastic_strain(self) -> float:
        """Largest accumulated plastic strain."""
        return float(self.accumulated.max())

    @cached_property
    def plastic_volume(self) -> float:
        """Volume with plastic strain [m³]."""
        cells = np.count_nonzero(self.accumulated, axis=(1, 2))
        return float(cells @ self.thickness) * self.pixel_area

    @cached_property
    def plastic_depth(self) -> float:
        """Depth that plastic strain reaches [m]: the lower face of its lowest layer."""
        layers = np.flatnonzero(self.accumulated.any(axis=(1, 2)))
        return float(self.thickness[: layers[-1] + 1].sum()) if layers.size else 0.0


@dataclass(frozen=True, eq=False)
class ElastoplasticResult:
    """A contact after a path of loads, with the plastic strain that it left.

    Parameters
    ----------
    contact : ContactResult
        Pressure, gap, approach and certificate at the last load; the gap includes the residual
        displacement.
    residual_displacement : ndarray, shape (ny, nx)
        What plastic strain adds to the gap [m], positive into the bodies.
    bodies : tuple of PlasticBody
        Those that yield, the rough one first.
    increments : tuple of Increment
        The loads in order, those of a run continued included.
    yield_excess : float
        Largest von Mises stress over the yield strength at that place, less one; negative if
        nothing is at yield.
    precision : {"double", "single"}
        Arithmetic of the volume; the contact is solved in double.
    tolerance : float
        Residual asked for.
    status : str
        ``"converged"``, or why the path was left.
    seconds : float
        Wall time.
    """

    contact: ContactResult
    residual_displacement: NDArray[np.float64]
    bodies: tuple[PlasticBody, ...]
    increments: tuple[Increment, ...]
    yield_excess: float
    precision: str
    tolerance: float
    status: str
    seconds: float
    version: str = field(default="")

    def __post_init__(self) -> None:
        """Make the map read-only."""
        self.residual_displacement.flags.writeable = False

    @property
    def converged(self) -> bool:
        """Whether the whole path was followed within the tolerances."""
        return self.status == "converged"

    @property
    def residual(self) -> float:
        """Largest residual of the plastic strain along the path; see `Increment`."""
        return max((step.residual for step in self.increments), default=0.0)

    @property
    def iterations(self) -> int:
        """Iterations of the loop, all loads together."""
        return sum(step.iterations for step in self.increments)

    @property
    def max_plastic_strain(self) -> float:
        """Largest accumulated plastic strain in any body."""
        return max(body.max_plastic_strain for body in self.bodies)

    @property
    def plastic_volume(self) -> float:
        """Volume with plastic strain, of all bodies [m³]."""
        return sum(body.plastic_volume for body in self.bodies)

    @property
    def plastic_depth(self) -> float:
        """Depth that plastic strain reaches in any body [m]."""
        return max(body.plastic_depth for body in self.bodies)

    @property
    def flowed(self) -> NDArray[np.bool_]:
        """Pixels under which the uppermost layer of a body has flowed, shape (ny, nx)."""
        first = self.bodies[0].margin
        ny, nx = self.contact.pressure.shape
        inside = slice(first, first + ny), slice(first, first + nx)
        mask: NDArray[np.bool_] = np.any(
            [b.accumulated[0][inside] > 0 for b in self.bodies], axis=0
        )
        return mask

    @property
    def corrected_contact_area(self) -> float:
        """Contact area without the excess that an elastic rim gains from the pixels [m²].

        See `ContactResult.corrected_contact_area`; the rim of pixels that have flowed, where the
        pressure falls from the plateau to zero at once, is left alone.
        """
        contact = self.contact
        elastic = contact.contact & ~self.flowed
        excess = rim_excess(contact.contact, elastic, contact.boundary) * contact.pixel_area
        return max(contact.contact_area - excess, 0.0)

    @property
    def regime(self) -> str:
        """How far plastic strain has come, in words."""
        if not self.plastic_volume:
            return "elastic"
        return f"plastic {'up to' if self.plastic_at_surface else 'below'} the surface"

    @property
    def plastic_at_surface(self) -> bool:
        """Whether plastic strain has come up to the contact, or to the free surface without one."""
        contact = self.contact.contact
        flowed = self.flowed
        return bool((flowed & contact if contact.any() else flowed).any())

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a reader of the numbers has to know, one sentence each."""
        notes = [] if self.converged else [self.status]
        if self.yield_excess > _EXCESS:
            notes.append(
                "the von Mises stress passes the yield strength by up to "
                f"{100 * self.yield_excess:.3g} %: plastic strain is so large beside the yield "
                "strain that it takes a smaller tolerance"
            )
        if self.contact.boundary == "free":
            if _rim(self.contact.contact, 1):
                notes.append(
                    "contact reaches the edge of the map: either the map is too small for this "
                    "load, or the body is meant to end there; the volume goes on beyond the edge"
                )
            if any(_rim(body.accumulated, _GUARD) for body in self.bodies):
                notes.append(
                    "plastic strain reaches the edge of the volume: enlarge the map, or solve it "
                    "as periodic"
                )
        if any(body.accumulated[-1].any() for body in self.bodies):
            notes.append(
                "plastic strain reaches the lowest layer: enlarge the map, or give a larger depth"
            )
        return tuple(notes)

    def summary(self) -> dict[str, Any]:
        """Return the scalar results by name, in SI units, ready for JSON."""
        contact = self.contact
        return {
            "status": self.status,
            "residual": self.residual,
            "yield_excess": self.yield_excess,
            "tolerance": self.tolerance,
            "certificate": contact.certificate,
            "load": contact.load,
            "load_error": contact.load_error,
            "approach": contact.approach,
            "contact_area": contact.contact_area,
            "contact_fraction": contact.contact_fraction,
            "max_pressure": contact.max_pressure,
            "max_residual_displacement": float(self.residual_displacement.max()),
            "max_plastic_strain": self.max_plastic_strain,
            "plastic_volume": self.plastic_volume,
            "plastic_depth": self.plastic_depth,
            "regime": self.regime,
            "warnings": list(self.warnings),
            "boundary": contact.boundary,
            "precision": self.precision,
            "layers": [body.thickness.size for body in self.bodies],
            "shape": list(contact.pressure.shape),
            "pixel": list(contact.surface.pixel),
            "increments": len(self.increments),
            "iterations": self.iterations,
            "seconds": self.seconds,
            "version": self.version,
        }

    def save(self, path: str | Path) -> None:
        """Write the result in the format that the suffix of the file names.

        Parameters
        ----------
        path : str or path
            File to write; it appears only once it is complete. ``.nc``: everything, see
            `roughcontact.archive.load_elastoplastic`. ``.vtr``: strain and stress of the volume,
            ``.vti``: the maps of the surface, both for ParaView. ``.csv``: the pressure.
            ``.json``: the summary.

        Raises
        ------
        InputError
            If the suffix is none of these.
        OSError
            If the file cannot be written; an old file survives.
        """
        from roughcontact import export

        export.save(self, path)

    def profile(self, point: tuple[int, int] | None = None, body: int = 0) -> DepthProfile:
        """Return plastic strain and stress over the depth; see `roughcontact.sections.profile`."""
        return sections.profile(self, point, body)

    def section(self, along: str = "x", index: int | None = None, body: int = 0) -> DepthSection:
        """Return them on a vertical plane; see `roughcontact.sections.section`."""
        return sections.section(self, along, index, body)

    def layers(self, body: int = 0) -> LayerProfile:
        """Return what each layer holds at most; see `roughcontact.sections.layers`."""
        return sections.layers(self, body)

    def report(self, path: str | Path, command: str = "", sections: Sequence[Section] = ()) -> None:
        """Write a report that needs no other file; see `roughcontact.volume_report.save`.

        Parameters
        ----------
        path : str or path
            HTML file to write; it appears only once it is complete.
        command : str
            What was typed to get this result.
        sections : sequence of `roughcontact.chapters.Section`
            Further chapters.
        """
        from roughcontact import volume_report

        volume_report.save(self, path, command=command, sections=sections)


@dataclass(frozen=True, eq=False)
class _Problem:
    """What all loads of a path have in common; see `solve_elastoplastic`."""

    surface: Surface
    counter_surface: Surface | None
    material: Material
    counter_material: Material
    boundary: str
    tolerance: float
    max_iterations: int
    precision: str

    @property
    def yielding(self) -> list[Material]:
        """Materials with a yield strength, that of the rough body first."""
        both = self.material, self.counter_material
        return [body for body in both if body.yield_strength is not None]

    def check_same(self, what: str, before: ElastoplasticResult) -> None:
        """Raise `InputError` if a result is one of other bodies or another boundary."""
        old = before.contact
        gap = initial_gap(self.surface, self.counter_surface)
        same = {
            "surface": old.pressure.shape == self.surface.shape
            and np.array_equal(old.initial_gap, gap, equal_nan=True),
            "pixel": old.surface.pixel == self.surface.pixel,
            "material": old.material == self.material,
            "counter_material": old.counter_material == self.counter_material,
            "boundary": old.boundary == self.boundary,
        }
        for name, agrees in same.items():
            if not agrees:
                raise InputError(
                    f"{what} was solved with another {name}: plastic strain stays with it"
                )


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
    problem = _Problem(
        surface, counter_surface, material, counter_material, boundary, tolerance, max_iterations,
        precision,
    )  # fmt: skip
    _check_arguments(problem, increments, depth, layers, start, on_failure)
    path = _path(load, loads, int(increments), 0.0 if start is None else start.contact.load)
    workspace = Workspace()
    contact = _untouched(problem, workspace)
    _check_capacity(problem, contact, max(path))
    if start is None:
        thickness, margin = _first_volume(problem, contact, max(path), depth, layers)
    else:
        thickness, margin = start.bodies[0].thickness, start.bodies[0].margin
    grid = surface.shape[0] + 2 * margin, surface.shape[1] + 2 * margin
    _check_memory(grid, thickness.size, len(problem.yielding), boundary, precision)
    steps: list[Path] = []
    if folder is not None:
        volume = [margin, layers is None, *thickness]
        steps = _steps(folder, len(path), problem, start, volume)
    kept = next((n for n, step in enumerate(steps) if not step.exists()), len(steps))
    before, carried = start, dict[str, Array]()
    if kept:
        before, carried = _kept(steps[kept - 1], path[:kept], problem)
        began -= before.seconds
        thickness, margin = before.bodies[0].thickness, before.bodies[0].margin
        if progress is not None:
            residual = before.increments[-1].residual
            progress(Progress(before.contact.load, path[-1], 0, residual, tolerance))
        if kept == len(path):
            return _judged(before, on_failure, folder)
    loop = _Loop(problem, contact, workspace, path[-1], progress)
    loop.resize(thickness, margin)
    done: list[Increment] = []
    if before is not None:
        loop.resume(before, carried)
        done = list(before.increments)

    result, status = None, "converged"
    for number in range(kept, len(path)):
        result = None
        loop.thaw()
        status = loop.follow([path[number]], done, deepen=layers is None, widen=boundary == "free")
        if status != "converged":
            break
        if steps:
            result = _result(loop, problem, done, status, began)
            _save(result, steps[number], loop.carried() | {"loads": np.array(path[: number + 1])})
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


def _check_arguments(
    problem: _Problem,
    increments: int,
    depth: float | None,
    layers: ArrayLike | None,
    start: ElastoplasticResult | None,
    on_failure: str,
) -> None:
    surface, counter_surface = problem.surface, problem.counter_surface
    material, counter_material = problem.material, problem.counter_material
    precision, tolerance = problem.precision, problem.tolerance
    check_bodies(surface, material, counter_material, counter_surface)
    if not (start is None or isinstance(start, ElastoplasticResult)):
        raise InputError(f"start must be an ElastoplasticResult, got {type(start).__name__}")
    check_choice("boundary", problem.boundary, ("free", "periodic"))
    check_choice("precision", precision, ("double", "single"))
    check_choice("on_failure", on_failure, ("raise", "return"))
    counts = ("increments", increments), ("max_iterations", problem.max_iterations)
    for name, count in counts:
        if not isinstance(count, Integral) or count < 1:
            raise InputError(f"{name} must be a positive integer, got {count!r}")
    require_positive(tolerance=tolerance)
    if tolerance < 1e-6 and precision == "single":
        raise InputError(
            f"tolerance = {tolerance!r} lies below what single precision can reach; "
            'ask for 1e-6 or more, or for precision="double"'
        )
    if depth is not None:
        require_positive(depth=depth)
        if depth < min(surface.pixel):
            raise InputError(
                f"depth = {depth!r} m is less than a pixel, {min(surface.pixel):.4g} m: give some "
                "radii of a contact spot, or leave it out"
            )
        if layers is not None:
            raise InputError("give either depth or layers, not both")
    if layers is not None:
        try:
            thickness = np.array(layers, float)
        except (TypeError, ValueError):
            raise InputError("layers must be a row of numbers [m]") from None
        if thickness.ndim != 1 or not thickness.size or not (thickness > 0).all():
            raise InputError(f"layers must be a row of positive numbers [m], got {layers!r}")
        if not np.isfinite(thickness).all():
            raise InputError(f"layers must be finite [m], got {layers!r}")
    check_surfaces(surface, counter_surface)
    for body in (material, counter_material):
        if body.yield_strength is not None and math.isinf(body.young):
            raise InputError("a rigid material cannot yield: give it a Young's modulus")
    if min(surface.shape) < 8:
        raise InputError(f"surface has {surface.shape} pixels: give at least 8 × 8")
    if start is None:
        return
    if depth is not None or layers is not None:
        raise InputError("start brings its layers along: leave out depth and layers")
    problem.check_same("start", start)


def _untouched(problem: _Problem, workspace: Workspace) -> _Contact:
    """Return the contact without pressure, if there can be one that yields."""
    modulus = contact_modulus(problem.material, problem.counter_material)
    if not problem.yielding:
        raise InputError(
            "neither material has a yield strength: nothing can yield; give one, or use solve"
        )
    gap = initial_gap(problem.surface, problem.counter_surface)
    gap[np.isnan(gap)] = np.inf
    if not np.isfinite(gap).any():
        raise CapacityError(
            "no contact is possible: together the holes of both bodies leave no point to touch"
        )
    pixel = problem.surface.pixel
    # The contact is solved again and again on the same few grids.
    make = lru_cache(maxsize=12)(operators(problem.boundary, pixel, modulus, "double", workspace))
    return _Contact(gap, make, pixel[0] * pixel[1])


def _check_capacity(problem: _Problem, contact: _Contact, load: float) -> None:
    """Refuse a load under which a map that ends flows without end."""
    if problem.boundary == "periodic":
        return
    strain = np.array(1e9)
    strongest = min(float(law.strength(strain)) for law in map(_law, problem.yielding))
    capacity = (
        _PUNCH * strongest * contact.area * np.count_nonzero(np.isfinite(contact.initial_gap))
    )
    if load > capacity:
        raise CapacityError(
            f"load = {load:.6g} N is more than the map can carry: even in full contact its body "
            f"flows without end above {capacity:.4g} N, {_PUNCH} times the largest yield strength "
            "on its area"
        )


def _law(body: Material) -> Hardening:
    return body.hardening or Perfect(body.yield_strength or math.inf)


def _first_volume(
    problem: _Problem,
    contact: _Contact,
    load: float,
    depth: float | None,
    layers: ArrayLike | None,
) -> tuple[NDArray[np.float64], int]:
    """Return the thickness of the layers [m] and the margin for loads up to this one."""
    pixel = problem.surface.pixel
    weaker = softer(problem.material, problem.counter_material)
    radius, margin = _spots(contact, load, weaker, pixel)
    margin = margin if problem.boundary == "free" else 0
    if layers is None:
        if depth is None:
            depth = max(_DEPTH * radius, _LEAST_DEPTH * max(pixel))
        return halfspace.graded_layers(_FIRST_LAYER * min(pixel), depth, _LAYER_RATIO), margin
    thickness = np.array(layers, float)
    if thickness.sum() < radius:
        raise InputError(
            f"layers reach {thickness.sum():.4g} m deep, less than the radius {radius:.4g} m of "
            "the largest contact spot: plastic strain would pass through them; reach "
            f"{_DEPTH * radius:.4g} m, or leave them out"
        )
    return thickness, margin


# Steps on disk


def _steps(
    folder: str | os.PathLike[str],
    count: int,
    problem: _Problem,
    start: ElastoplasticResult | None,
    volume: list[float],
) -> list[Path]:
    """Return the files of all loads, after a look at what stands in the folder.

    The volume is the margin, whether it may become deeper, and the thickness of its layers.
    """
    from roughcontact import checkpoint

    described = checkpoint.contact(
        problem.surface, problem.counter_surface, problem.material, problem.counter_material
    )
    described |= {
        "boundary": problem.boundary,
        "layers": checkpoint.digest(volume),
        "tolerance": float(problem.tolerance),
        "max_iterations": int(problem.max_iterations),
        "precision": problem.precision,
        "start": None,
    }
    if start is not None:
        layers = [strain for body in start.bodies for strain in body.plastic_strain]
        flowed = [layer for body in start.bodies for layer in body.accumulated]
        described["start"] = checkpoint.digest(start.contact.pressure, *layers, *flowed)
    place = checkpoint.claim(
        folder, described, kind="run", record="volume.json", pattern="step-*.nc"
    )
    return [place / f"step-{number:04d}.nc" for number in range(1, count + 1)]


def _kept(
    path: Path, loads: list[float], problem: _Problem
) -> tuple[ElastoplasticResult, dict[str, Array]]:
    """Return the state after some loads, and what the loop carries on from it."""
    from roughcontact.archive import load_step

    try:
        result, carried = load_step(path)
        asked = carried.pop("loads")
    except FormatError as error:
        raise FormatError(f"{error}; remove {path} to solve it again") from None
    except KeyError:
        raise FormatError(f"{path} is no step of a run; remove it to solve it again") from None
    if asked.tolist() != loads:
        raise InputError(
            f"folder {path.parent} holds another run: loads differ; give another folder, or remove "
            "this one to start again"
        )
    problem.check_same(str(path), result)
    return result, carried


def _save(result: ElastoplasticResult, path: Path, carried: Mapping[str, Array]) -> None:
    from roughcontact.archive import save_elastoplastic

    try:
        save_elastoplastic(result, path, carried)
    except OSError as error:
        reason = error.strerror or " ".join(str(error).split())
        raise InputError(
            f"{path} cannot be written ({reason}); the loads before it are kept"
        ) from None


def _path(
    load: float | None, loads: Sequence[float] | None, increments: int, first: float
) -> list[float]:
    """Return the loads to visit, one after the other."""
    if (load is None) == (loads is None):
        raise InputError("give either load or loads, and only one of them")
    if load is not None:
        require_positive(load=load)
        before = [first + (load - first) * i / increments for i in range(1, increments)]
        # The last is as given, and not what rounding makes of it.
        return [*before, float(load)]
    try:
        path = np.array(loads, float)
    except (TypeError, ValueError):
        raise InputError("loads must be a row of numbers [N]") from None
    if path.ndim != 1 or not path.size or not ((path >= 0) & np.isfinite(path)).all():
        raise InputError(f"loads must be finite and not negative [N], got {loads!r}")
    if not path.any() and first == 0:
        raise InputError("loads are all zero: at least one must press the bodies together")
    return [float(value) for value in path]


def _spots(
    contact: _Contact, load: float, body: Material | None, pixel: tuple[float, float]
) -> tuple[float, int]:
    """Return the radius of the largest contact spot [m] and the margin that its volume wants.

    The contact is that under a ceiling of three yield strengths.
    """
    from scipy import ndimage

    pressed = contact.pressed(load, (body.yield_strength or math.inf) if body else math.inf)
    spots, number = ndimage.label(pressed, np.ones((3, 3)))
    largest = int(np.bincount(spots.ravel())[1:].max()) if number else 0
    radius = math.sqrt(largest * pixel[0] * pixel[1] / math.pi)
    margin = 0
    for axis, edge in enumerate(pixel):
        lines = np.flatnonzero(pressed.any(axis=1 - axis))
        if lines.size:
            near = min(int(lines[0]), pressed.shape[axis] - 1 - int(lines[-1]))
            margin = max(margin, math.ceil(_SPAN * radius / edge) - near)
    return radius, margin


def _rim(values: Array, width: int) -> bool:
    """Return whether anything but zero lies in the outer rows and columns."""
    lines = (values[..., :width, :], values[..., -width:, :])
    columns = (values[..., :width], values[..., -width:])
    return any(bool(part.any()) for part in (*lines, *columns))


def memory_estimate(
    shape: tuple[int, int],
    layers: int,
    *,
    bodies: int = 1,
    boundary: str = "free",
    precision: str = "single",
) -> int:
    """Return about the memory that `solve_elastoplastic` needs.

    Parameters
    ----------
    shape : (int, int)
        Grid points ``(ny, nx)``.
    layers : int
        Number of layers.
    bodies : int
        How many of the two yield.
    boundary, precision
        As for `solve_elastoplastic`.

    Returns
    -------
    int
        Bytes, if a quarter of the volume yields.
    """
    real = 8 if precision == "double" else 4
    points = shape[0] * shape[1]
    padded = halfspace.points_transformed(shape, boundary)
    # Spectra of strain and mean stress and the tables; strain, stresses, and what Anderson's
    # acceleration remembers of a quarter of the points. The bodies share what threads sweep with.
    swept = min(default_workers() * halfspace.SWEEP_POINTS, padded / 4)
    volume = bodies * layers * (7.5 * padded + 35 * points) + (6 * layers + 28) * swept
    return int(real * volume) + 200 * points


def _check_memory(
    shape: tuple[int, int], layers: int, bodies: int, boundary: str, precision: str
) -> None:
    import psutil

    needed = memory_estimate(shape, layers, bodies=bodies, boundary=boundary, precision=precision)
    free = psutil.virtual_memory().available
    if needed > free:
        gib = 2**30
        points = int(math.sqrt(free / needed * shape[0] * shape[1]))
        raise InsufficientMemoryError(
            f"{shape[0]} × {shape[1]} points in {layers} layers need about {needed / gib:.1f} GiB, "
            f"{free / gib:.1f} GiB are free; a square grid of up to about {points} × {points} "
            "points fits, or fewer layers"
        )


class _Contact:
    """The contact solver, started each time from the pressure before."""

    def __init__(self, gap: NDArray[np.float64], make: solver.Operator, area: float) -> None:
        self._map = gap
        self._make, self.area = make, area
        self.resize(0)
        self.approach = 0.0
        self.convolutions = 0
        self.solution: solver.Solution | None = None

    def resize(self, margin: int) -> None:
        """Add points that never touch around the map, and forget the pressure."""
        self.initial_gap = np.pad(self._map, margin, constant_values=np.inf)
        self.inside = tuple(slice(margin, margin + n) for n in self._map.shape)
        self.loaded: solver.Loaded | None = None
        self.pressure = np.zeros(self.initial_gap.shape)

    def resume(self, pressure: NDArray[np.float64]) -> None:
        """Start from a pressure on the map."""
        self.pressure[self.inside] = pressure
        index = np.flatnonzero(self.pressure)
        if index.size:
            self.loaded = index, self.pressure.ravel()[index]

    def pressed(self, load: float, strength: float) -> NDArray[np.bool_]:
        """Return the contact under a ceiling of three yield strengths, roughly."""
        total = load / self.area
        limit = CEILING_FACTOR * strength
        if total > 0.9 * limit * np.count_nonzero(np.isfinite(self.initial_gap)):
            return np.isfinite(self.initial_gap)
        problem = solver.Problem(self.initial_gap, limit, total)
        rough = solver.solve(problem, self._make, tolerance=1e-2, max_iterations=200)
        pressed = np.zeros(self.initial_gap.shape, bool)
        pressed.ravel()[rough.index] = True
        return pressed

    @property
    def solved(self) -> bool:
        """Whether the last contact, if there is any, is within its tolerance."""
        return self.solution is None or self.solution.status is solver.Status.CONVERGED

    def press(self, displacement: NDArray[np.float64], load: float, tolerance: float) -> None:
        """Find the pressure that carries a load on the surface as plastic strain left it."""
        gap = self.initial_gap + displacement
        self.pressure = np.zeros(gap.shape)
        if load == 0:
            self.loaded, self.solution = None, None
            self.approach = float(gap.min())
            return
        solution = solver.solve(
            solver.Problem(gap, np.inf, load / self.area),
            self._make,
            tolerance=tolerance,
            max_iterations=_CONTACT_CONVOLUTIONS,
            start=self.loaded,
        )
        self.convolutions += solution.convolutions
        self.loaded = solution.index, solution.pressure
        self.pressure.ravel()[solution.index] = solution.pressure
        self.approach, self.solution = solution.approach, solution


class _Body:
    """A body that yields: its plastic strain up to now, and its volume operator."""

    def __init__(
        self,
        material: Material,
        pixel: tuple[float, float],
        boundary: str,
        precision: str,
        workspace: Workspace,
    ) -> None:
        self.material, self.pixel = material, pixel
        self.boundary, self.precision, self._workspace = boundary, precision, workspace
        self.law = _law(material)
        self.shear_modulus = material.young / (2 * (1 + material.poisson))
        self.real: type = np.float32 if precision == "single" else np.float64
        self.strain: Array = np.zeros((0, 5, 0, 0), self.real)
        self.accumulated: Array = np.zeros((0, 0), self.real)

    def resize(self, thickness: NDArray[np.float64], shape: tuple[int, int]) -> None:
        """Take on more layers below and more points around those there are."""
        self.operator = HalfSpace(
            shape, self.pixel, thickness,
            shear_modulus=self.shear_modulus, poisson=self.material.poisson,
            boundary=self.boundary, precision=self.precision, workspace=self._workspace,
        )  # fmt: skip
        old, accumulated = self.strain, self.accumulated
        ny, nx = old.shape[-2:]
        top, left = (shape[0] - ny) // 2, (shape[1] - nx) // 2
        place = np.s_[: len(old), ..., top : top + ny, left : left + nx]
        self.thickness, self.shape = thickness, shape
        self.strain = np.zeros((thickness.size, 5, *shape), self.real)
        self.strain[place] = old
        fields: Array = np.zeros((thickness.size, *shape), self.real)
        fields[place] = accumulated.reshape(len(old), ny, nx)
        self.accumulated = fields.reshape(thickness.size, -1)
        self._hardened(range(thickness.size))

    def _hardened(self, layers: range) -> None:
        if layers.start == 0:
            self._square_strength: Array = np.empty_like(self.accumulated)
            self._rows: list[slice | None] = [None] * len(layers)
        for layer in layers:
            strength = self.law.strength(self.accumulated[layer])
            # A square beyond the range of the numbers is one that no stress reaches.
            with np.errstate(over="ignore"):
                np.square(strength, out=self._square_strength[layer])
            rows = np.flatnonzero(self.strain[layer].any(axis=(0, 2)))
            self._rows[layer] = slice(int(rows[0]), int(rows[-1]) + 1) if rows.size else None

    def resume(self, old: PlasticBody) -> None:
        """Take over the plastic strain of a result."""
        self.strain[...] = old.plastic_strain
        self.accumulated[...] = old.accumulated.reshape(self.accumulated.shape)
        self._hardened(range(len(self.strain)))

    def displacement(
        self, places: Parts, added: Parts, *, trace: bool = False
    ) -> NDArray[np.float64]:
        """Return the surface displacement by the strain so far and some more."""
        nx = self.shape[1]

        def fill(layer: int, out: Array) -> slice | None:
            rows, place = self._rows[layer], places[layer]
            if not place.size:
                if rows is not None:
                    out[...] = self.strain[layer]
                return rows
            out[...] = self.strain[layer]
            out.reshape(5, -1)[:, place] += added[layer]
            low, high = int(place[0] // nx), int(place[-1] // nx) + 1
            if rows is None:
                return slice(low, high)
            return slice(min(low, rows.start), max(high, rows.stop))

        return self.operator.displacement(fill, trace=trace)

    def flow(self, pressure: Array, places: Parts, added: Parts) -> tuple[Parts, Parts]:
        """Return where the stress is returned to the yield surface, and the strain that does it.

        Parameters
        ----------
        pressure : ndarray, shape (ny, nx)
            Pressure on the surface [Pa].
        places, added : list of ndarray, shapes (n,) and (5, n)
            Pixels of each layer, ascending, and the strain of this increment in the stress.

        Returns
        -------
        places, strain : list of ndarray
            The same, after the return; no pixel is lost.
        """
        new_places: Parts = [np.empty(0, np.int64)] * len(places)
        flowed: Parts = [np.empty((5, 0), self.real)] * len(places)
        twice = self.real(2 * self.shear_modulus)

        def visit(layer: int, stress: Array) -> None:
            trial, place = stress.reshape(5, -1), places[layer]
            if place.size:
                trial[:, place] += twice * added[layer]
            square = trial[1] * trial[1]
            for component in trial[2:]:
                square += component * component
            square *= 3
            square += self.real(2.25) * (trial[0] * trial[0])
            yields = square > self._square_strength[layer]
            yields[place] = True
            place = np.flatnonzero(yields)
            if not place.size:
                return
            q = np.sqrt(square[place])
            step = plastic_increment(
                q, self.accumulated[layer, place], self.law, self.shear_modulus
            )
            factor = self.real(1.5) * step / np.where(q > 0, q, 1)
            new_places[layer], flowed[layer] = place, trial[:, place] * factor

        self.operator.stress(pressure, visit)
        return new_places, flowed

    def accept(self, places: Parts, added: Parts) -> None:
        """Add the strain of an increment."""
        for layer, (place, strain) in enumerate(zip(places, added, strict=True)):
            if place.size:
                self.strain[layer].reshape(5, -1)[:, place] += strain
                self.accumulated[layer, place] += _equivalent_strain(strain)
        self._hardened(range(len(self.strain)))

    @property
    def plastic_volume(self) -> float:
        """Volume with plastic strain [m³]."""
        cells = np.count_nonzero(self.accumulated, axis=1)
        dy, dx = self.pixel
        return float(cells @ self.thickness) * dy * dx

    def finished(self, pressure: Array, margin: int) -> tuple[PlasticBody, float]:
        """Return the body with its stresses, and how far the stress passes the yield strength."""
        fields = self.strain.shape[0], *self.strain.shape[2:]
        excess = np.full(fields[0], -1.0)
        stress, residual = np.empty_like(self.strain), np.empty_like(self.strain)
        mean, mean_residual = np.empty(fields, self.real), np.empty(fields, self.real)

        def keep(layer: int, values: Array) -> None:
            stress[layer] = values
            q = halfspace.equivalent(values).ravel()
            excess[layer] = np.sqrt((q * q / self._square_strength[layer]).max()) - 1

        nothing = np.zeros(fields[1:])
        self.operator.stress(pressure, keep)
        self.operator.mean_stress(pressure, lambda layer, v: np.copyto(mean[layer], v))
        self.operator.stress(nothing, lambda layer, v: np.copyto(residual[layer], v))
        self.operator.mean_stress(nothing, lambda layer, v: np.copyto(mean_residual[layer], v))
        dy, dx = self.pixel
        body = PlasticBody(
            self.material, dy * dx, margin, self.thickness, self.strain,
            self.accumulated.reshape(fields), stress, mean, residual, mean_residual,
        )  # fmt: skip
        return body, float(excess.max())


def _equivalent_strain(strain: Array) -> Array:
    """Return √(2/3 e:e) of traceless strains, shape (5, n)."""
    result: Array = halfspace.equivalent(strain) * strain.dtype.type(2 / 3)
    return result


class _Mixer:
    """Anderson's acceleration of a fixed point y = x(y) whose unknowns may become more.

    The next iterate is the combination of the last ones whose defect f = x - y would be the
    smallest if x were linear (Anderson 1965, doi:10.1145/321296.321305; Walker and Ni 2011,
    doi:10.1137/10078356X), in the norm of the energy: tensor product, thickness, modulus. Where
    the defect grows the memory is cleared and a plain step follows; where it has not fallen for a
    while, several. Plain steps never raise the defect: they are averaged nonexpansive.
    """

    def __init__(self, weights: list[float], workspace: Workspace) -> None:
        self._weights, self._workspace = weights, workspace
        self._last: tuple[Parts, Parts] | None = None
        self._steps: list[tuple[Parts, Parts]] = []
        self._gram = np.zeros((0, 0))
        self._least = self._best = math.inf
        self._fruitless = self._plain = 0

    def grow(self, part: int, old: Array, new: Array) -> None:
        """Make room for the unknowns that a part has won."""
        place = np.searchsorted(new, old)
        pairs = list(self._steps) if self._last is None else [*self._steps, self._last]
        for pair in pairs:
            for parts in pair:
                parts[part] = embedded(parts[part], place, new.size)

    def mix(self, x: Parts, defect: Parts) -> Parts:
        """Return the next iterate."""
        each, count = self._workspace.each, range(len(x))
        size = math.sqrt(self._products([(defect, defect)])[0])
        self._fruitless = 0 if size < self._best else self._fruitless + 1
        self._best = min(self._best, size)
        if self._fruitless == _PATIENCE:
            self._fruitless, self._plain = 0, _PLAIN_STEPS
        if self._plain or not size <= _GROWTH * self._least:
            self._steps, self._last, self._gram = [], None, np.zeros((0, 0))
            self._least = math.inf
        if self._plain:
            self._plain -= 1
            return [part.copy() for part in x]
        self._least = min(self._least, size)
        if self._last is not None:
            old_x, old_defect = self._last
            if len(self._steps) == _MEMORY:
                del self._steps[0]
                self._gram = self._gram[1:, 1:]

            def subtract(part: int) -> None:
                np.subtract(x[part], old_x[part], out=old_x[part])
                np.subtract(defect[part], old_defect[part], out=old_defect[part])

            each(subtract, count)
            self._steps.append((old_x, old_defect))
            row = self._products([(old_defect, step[1]) for step in self._steps])
            gram = np.empty((len(row), len(row)))
            gram[:-1, :-1], gram[-1], gram[:, -1] = self._gram, row, row
            self._gram = gram
        self._last = x, defect
        if not self._steps:
            return [part.copy() for part in x]
        right = self._products([(defect, step[1]) for step in self._steps])
        share = _least_squares(self._gram, right)
        mixed: Parts = [np.empty(0)] * len(x)

        def combine(part: int) -> None:
            result = x[part].copy()
            for factor, (step, _) in zip(share, self._steps, strict=True):
                result -= result.dtype.type(factor) * step[part]
            mixed[part] = result

        each(combine, count)
        return mixed

    def _products(self, pairs: list[tuple[Parts, Parts]]) -> NDArray[np.float64]:
        """Return the inner products of pairs of vectors."""
        sums = np.zeros((len(self._weights), len(pairs)))
        tensor = np.array(halfspace.WEIGHTS)

        def add(part: int) -> None:
            if pairs and pairs[0][0][part].size:
                for number, (one, other) in enumerate(pairs):
                    each = np.einsum("ki,ki->k", one[part], other[part], dtype=np.float64)
                    sums[part, number] = self._weights[part] * (tensor @ each)

        self._workspace.each(add, range(len(self._weights)))
        total: NDArray[np.float64] = sums.sum(axis=0)
        return total


def embedded(values: Array, place: Array, size: int) -> Array:
    """Return columns moved to some places among more of them, the new ones zero."""
    wider = np.zeros((5, size), values.dtype)
    wider[:, place] = values
    return wider


def _least_squares(gram: NDArray[np.float64], right: NDArray[np.float64]) -> NDArray[np.float64]:
    """Solve normal equations, leaving out directions that depend on others."""
    scale = np.sqrt(np.diag(gram))
    scale[scale == 0] = 1
    value, vector = np.linalg.eigh(gram / scale / scale[:, None])
    keep = value > _DEPENDENT * value[-1]
    share = vector[:, keep] @ ((vector[:, keep].T @ (right / scale)) / value[keep])
    result: NDArray[np.float64] = share / scale
    return result


class _Loop:
    """The loop over increments and iterations."""

    def __init__(
        self,
        problem: _Problem,
        contact: _Contact,
        workspace: Workspace,
        target: float,
        progress: Callable[[Progress], None] | None,
    ) -> None:
        pixel, boundary = problem.surface.pixel, problem.boundary
        self.bodies = [
            _Body(material, pixel, boundary, problem.precision, workspace)
            for material in problem.yielding
        ]
        self.contact = contact
        self._workspace, self._tolerance = workspace, problem.tolerance
        self._max_iterations = int(problem.max_iterations)
        self._target, self._progress = target, progress
        # Strain of the increment before, and its load: the first guess of the next.
        self._places: list[Parts] = []
        self._added: list[Parts] = []
        self._stride = 0.0

    def carried(self) -> dict[str, Array]:
        """Return what one load hands on to the next beside the state."""
        held = {"stride": np.array([self._stride])}
        if self.contact.loaded is not None:
            held["index"], held["pressure"] = self.contact.loaded
        for body, (places, added) in enumerate(zip(self._places, self._added, strict=True)):
            held[f"sizes_{body}"] = np.array([place.size for place in places])
            held[f"places_{body}"] = np.concatenate(places)
            held[f"added_{body}"] = np.concatenate(added, axis=1)
        return held

    def resume(self, before: ElastoplasticResult, held: Mapping[str, Array]) -> None:
        """Go on from a result, and from what `carried` returned with it if that is known."""
        for yielding, old in zip(self.bodies, before.bodies, strict=True):
            yielding.resume(old)
        self.contact.resume(before.contact.pressure)
        if not held:
            return
        # Arrays without numbers may be missing.
        self._stride = float(held["stride"][0])
        if "index" in held:
            self.contact.loaded = held["index"], held["pressure"]
        for body in range(len(self.bodies)):
            if f"places_{body}" in held:
                cuts = np.cumsum(held[f"sizes_{body}"])[:-1]
                self._places[body] = np.split(held[f"places_{body}"], cuts)
                self._added[body] = np.split(held[f"added_{body}"], cuts, axis=1)

    def resize(self, thickness: NDArray[np.float64], margin: int) -> None:
        """Enlarge the volume of all bodies, and start the increment again."""
        self.margin = margin
        self.contact.resize(margin)
        ny, nx = self.contact.initial_gap.shape
        for body in self.bodies:
            body.resize(thickness, (ny, nx))
        self._places, self._added = self.nothing()
        self._stride = 0.0

    def thaw(self) -> None:
        """Let the strain change that a result has frozen, when that is on disk."""
        for body in self.bodies:
            body.strain.flags.writeable = True

    def nothing(self) -> tuple[list[Parts], list[Parts]]:
        places: list[Parts] = []
        added: list[Parts] = []
        for body in self.bodies:
            layers = len(body.strain)
            places.append([np.empty(0, np.int64)] * layers)
            added.append([np.empty((5, 0), body.real)] * layers)
        return places, added

    def follow(self, path: list[float], done: list[Increment], *, deepen: bool, widen: bool) -> str:
        """Visit loads one after the other; return why it stopped."""
        todo = path[::-1]
        before = done[-1].load if done else 0.0
        cuts = 0
        while todo:
            load = todo[-1]
            kept = self.contact.loaded
            found = self._relax(load, before)
            if found is None:
                self.contact.loaded = kept
                self._places, self._added = self.nothing()
                self._stride = 0.0
                if cuts == _CUTS or (not done and load == 0):
                    what = "plastic strain" if self.contact.solved else "contact"
                    return (
                        f"stopped on the way to {load:.6g} N: the {what} did not settle in "
                        f"{self._max_iterations} iterations, though the step was halved {cuts} "
                        "times; raise max_iterations, or ask for a larger tolerance"
                    )
                cuts += 1
                todo.append((before + load) / 2)
                continue
            if self._enlarged(deepen, widen):
                continue
            todo.pop()
            cuts = max(0, cuts - 1)
            for body, places, added in zip(self.bodies, self._places, self._added, strict=True):
                body.accept(places, added)
            residuals, convolutions = found
            self._stride, before = load - before, load
            contact = self.contact
            dy, dx = self.bodies[0].pixel
            done.append(
                Increment(
                    load=load,
                    approach=contact.approach,
                    contact_area=int(np.count_nonzero(contact.pressure)) * dy * dx,
                    max_pressure=float(contact.pressure.max()),
                    max_plastic_strain=max(float(b.accumulated.max()) for b in self.bodies),
                    plastic_volume=sum(body.plastic_volume for body in self.bodies),
                    residuals=residuals,
                    convolutions=convolutions,
                )
            )
        return "converged"

    def _enlarged(self, deepen: bool, widen: bool) -> bool:
        """Enlarge the volume if plastic strain has come to its bottom or its edge."""
        body = self.bodies[0]
        thickness, margin = list(body.thickness), self.margin
        (ny, nx), (dy, dx) = body.shape, body.pixel
        deepest, widest = 2 * max(ny * dy, nx * dx), max(ny, nx)
        if deepen and any(parts[-1].any() for parts in self._added):
            depth = min(_DEEPER * sum(thickness), deepest)
            while sum(thickness) < depth:
                thickness.append(thickness[-1] * _LAYER_RATIO)
        if widen and 4 * margin < widest and self._at_edge():
            margin += max(_GUARD, math.ceil(_WIDER * min(ny, nx)))
        if len(thickness) == body.thickness.size and margin == self.margin:
            return False
        wider = ny + 2 * (margin - self.margin), nx + 2 * (margin - self.margin)
        if not self._fits(wider, len(thickness)):
            # The result says that plastic strain has come to the bottom or to the edge.
            return False
        self.resize(np.array(thickness), margin)
        return True

    def _fits(self, shape: tuple[int, int], layers: int) -> bool:
        import psutil

        body = self.bodies[0]
        more: dict[str, Any] = dict(
            bodies=len(self.bodies), boundary=body.boundary, precision=body.precision
        )
        needed = memory_estimate(shape, layers, **more)
        held = memory_estimate(body.shape, body.thickness.size, **more)
        return needed - held < psutil.virtual_memory().available

    def _at_edge(self) -> bool:
        ny, nx = self.bodies[0].shape
        edge = np.ones((ny, nx), bool)
        edge[_GUARD:-_GUARD, _GUARD:-_GUARD] = False
        flat = edge.ravel()
        return any(
            bool(strain[:, flat[place]].any())
            for places, added in zip(self._places, self._added, strict=True)
            for place, strain in zip(places, added, strict=True)
        )

    def _relax(self, load: float, before: float) -> tuple[tuple[float, ...], int] | None:
        """Find the plastic strain of one increment; keep it beside that accepted.

        Returns the residuals of the iterations and the convolutions of the contact.
        """
        bodies, contact = self.bodies, self.contact
        stride = load - before
        if self._stride * stride > 0:
            factor = min(stride / self._stride, 1.0)
            self._added = [[part * part.dtype.type(factor) for part in a] for a in self._added]
        elif self._stride:
            self._places, self._added = self.nothing()
        self._stride = 0.0
        weights = [
            body.shear_modulus / bodies[0].shear_modulus * float(h / bodies[0].thickness[0])
            for body in bodies
            for h in body.thickness
        ]
        mixer = _Mixer(weights, self._workspace)
        convolutions = contact.convolutions
        residuals: list[float] = []
        for iteration in range(1, self._max_iterations + 1):
            displacement = sum(
                body.displacement(places, added)
                for body, places, added in zip(bodies, self._places, self._added, strict=True)
            )
            contact.press(np.asarray(displacement), load, _CONTACT_TOLERANCE)
            x: Parts = []
            y: Parts = []
            for number, body in enumerate(bodies):
                old_places, old = self._places[number], self._added[number]
                places, flowed = body.flow(contact.pressure, old_places, old)
                for layer, place in enumerate(places):
                    if place.size > old_places[layer].size:
                        mixer.grow(len(x) + layer, old_places[layer], place)
                        at = np.searchsorted(place, old_places[layer])
                        old[layer] = embedded(old[layer], at, place.size)
                self._places[number] = places
                x += flowed
                y += old
            defect = [one - other for one, other in zip(x, y, strict=True)]
            residual = self._residual(x, defect)
            residuals.append(residual)
            if self._progress is not None:
                self._progress(Progress(load, self._target, iteration, residual, self._tolerance))
            settled = residual <= self._tolerance and contact.solved
            if not settled:
                x = mixer.mix(x, defect)
            cut = 0
            for number, body in enumerate(bodies):
                self._added[number] = x[cut : cut + len(body.strain)]
                cut += len(body.strain)
            if settled:
                return tuple(residuals), contact.convolutions - convolutions
        return None

    def _residual(self, x: Parts, defect: Parts) -> float:
        """Return the largest change over the largest strain, or over the yield strain."""
        changes, sizes = np.zeros(len(x)), np.zeros(len(x))

        def measure(part: int) -> None:
            if x[part].size:
                changes[part] = _equivalent_strain(defect[part]).max()
                sizes[part] = _equivalent_strain(x[part]).max()

        self._workspace.each(measure, range(len(x)))
        least = max(body.law.initial / (2 * body.shear_modulus) for body in self.bodies)
        return float(changes.max() / max(least, sizes.max()))


def _result(
    loop: _Loop, problem: _Problem, done: list[Increment], status: str, began: float
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
    contact.press(displacement, load, _CONTACT_TOLERANCE)
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
    contact_status = solver.Status.CONVERGED if solution is None else solution.status
    if contact_status is solver.Status.CONVERGED and load_error > LOAD_TOLERANCE:
        contact_status = solver.Status.STALLED
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
        tolerance=_CONTACT_TOLERANCE,
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
