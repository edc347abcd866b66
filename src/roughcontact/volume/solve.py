"""Contact with plasticity of the volume: residual displacement and stress, hardening, unloading.

`solve_elastoplastic` follows a path of loads, load by load; what happens at one of them stands in
`roughcontact.volume.loop`.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from numbers import Integral
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._version import __version__
from roughcontact.contact.result import ContactResult, initial_gap, rim_excess
from roughcontact.contact.solve import (
    LOAD_TOLERANCE,
    check_bodies,
    check_choice,
    check_surfaces,
    operators,
)
from roughcontact.errors import (
    CapacityError,
    ConvergenceError,
    FormatError,
    InputError,
    InsufficientMemoryError,
    require_positive,
)
from roughcontact.halfspace import plastic
from roughcontact.halfspace.fft import Workspace
from roughcontact.material.material import RIGID, Material, contact_modulus, softer
from roughcontact.solvers import bounded
from roughcontact.surface.surface import Surface
from roughcontact.volume import depth as sections
from roughcontact.volume.depth import DepthProfile, DepthSection, LayerProfile
from roughcontact.volume.loop import (
    CONTACT_TOLERANCE,
    GUARD,
    LAYER_RATIO,
    Contact,
    Increment,
    Loop,
    PlasticBody,
    Problem,
    Progress,
    law_of,
    memory_estimate,
)

if TYPE_CHECKING:
    from roughcontact.report.chapters import Section

Array = NDArray[Any]

# Layers: the first over the shorter edge of a pixel, the depth of them all over the radius of the
# largest contact spot, and in pixels at least.
_FIRST_LAYER = 0.5
_DEPTH = 3.0
_LEAST_DEPTH = 8.0
# No volume of that depth has fewer layers.
_LEAST_LAYERS = 10

TOLERANCE = 1e-4
"""Residual of the plastic strain at which an increment is done."""

# Stress beyond the yield strength, over it, that is worth a word.
_EXCESS = 0.05
# Mean pressure over the yield strength that no flat punch with the outline of a map reaches: it
# flows at 2.97 on a strip and 3.28 on a disc (shear strength σ_Y/√3; Hill 1950, Shield 1955).
_PUNCH = 3.5
# Distance of the edge of the volume from the contact, over the radius of the largest spot.
_SPAN = 0.8


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
            if any(_rim(body.accumulated, GUARD) for body in self.bodies):
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
            `roughcontact.contact.archive.load_elastoplastic`. ``.vtr``: strain and stress of
            the volume, ``.vti``: the maps of the surface, both for ParaView. ``.csv``: the
            pressure. ``.json``: the summary.

        Raises
        ------
        InputError
            If the suffix is none of these.
        OSError
            If the file cannot be written; an old file survives.
        """
        from roughcontact.formats import export

        export.save(self, path)

    def profile(self, point: tuple[int, int] | None = None, body: int = 0) -> DepthProfile:
        """Return plastic strain and stress over the depth; see `depth.profile`."""
        return sections.profile(self, point, body)

    def section(self, along: str = "x", index: int | None = None, body: int = 0) -> DepthSection:
        """Return them on a vertical plane; see `roughcontact.volume.depth.section`."""
        return sections.section(self, along, index, body)

    def layers(self, body: int = 0) -> LayerProfile:
        """Return what each layer holds at most; see `roughcontact.volume.depth.layers`."""
        return sections.layers(self, body)

    def report(self, path: str | Path, command: str = "", sections: Sequence[Section] = ()) -> None:
        """Write a report that needs no other file; see `roughcontact.report.volume.save`.

        Parameters
        ----------
        path : str or path
            HTML file to write; it appears only once it is complete.
        command : str
            What was typed to get this result.
        sections : sequence of `roughcontact.report.chapters.Section`
            Further chapters.
        """
        from roughcontact.report import volume as volume_report

        volume_report.save(self, path, command=command, sections=sections)


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
        surface, counter_surface, material, counter_material, boundary, tolerance, max_iterations,
        precision,
    )  # fmt: skip
    _check_arguments(problem, increments, depth, layers, start, on_failure)
    path = _path(load, loads, int(increments), 0.0 if start is None else start.contact.load)
    # Before anything of the size of the map is made; again once the volume is known.
    least = np.size(layers) if layers is not None else _LEAST_LAYERS
    _check_memory(surface.shape, least, max(len(problem.yielding), 1), boundary, precision)
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
    loop = Loop(problem, contact, workspace, path[-1], progress)
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
    problem: Problem,
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
        raise InputError(
            f"must be an ElastoplasticResult, got {type(start).__name__}", argument="start"
        )
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
                f"= {depth!r} m is less than a pixel, {min(surface.pixel):.4g} m: give some "
                "radii of a contact spot, or leave it out",
                argument="depth",
            )
        if layers is not None:
            raise InputError("give either depth or layers, not both")
    if layers is not None:
        try:
            thickness = np.array(layers, float)
        except (TypeError, ValueError):
            raise InputError("must be a row of numbers [m]", argument="layers") from None
        if thickness.ndim != 1 or not thickness.size or not (thickness > 0).all():
            raise InputError(
                f"must be a row of positive numbers [m], got {layers!r}",
                argument="layers",
                value=layers,
            )
        if not np.isfinite(thickness).all():
            raise InputError(f"must be finite [m], got {layers!r}", argument="layers", value=layers)
    check_surfaces(surface, counter_surface)
    for body in (material, counter_material):
        if body.yield_strength is not None and math.isinf(body.young):
            raise InputError("a rigid material cannot yield: give it a Young's modulus")
    if min(surface.shape) < 8:
        raise InputError(f"surface has {surface.shape} pixels: give at least 8 × 8")
    if start is None:
        return
    if depth is not None or layers is not None:
        raise InputError("brings its layers along: leave out depth and layers", argument="start")
    problem.check_same("start", start)


def _untouched(problem: Problem, workspace: Workspace) -> Contact:
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
    return Contact(gap, make, pixel[0] * pixel[1])


def _check_capacity(problem: Problem, contact: Contact, load: float) -> None:
    """Refuse a load under which a map that ends flows without end."""
    if problem.boundary == "periodic":
        return
    strain = np.array(1e9)
    strongest = min(float(law.strength(strain)) for law in map(law_of, problem.yielding))
    capacity = (
        _PUNCH * strongest * contact.area * np.count_nonzero(np.isfinite(contact.initial_gap))
    )
    if load > capacity:
        raise CapacityError(
            f"= {load:.6g} N is more than the map can carry: even in full contact its body "
            f"flows without end above {capacity:.4g} N, {_PUNCH} times the largest yield strength "
            "on its area",
            argument="load",
        )


def _first_volume(
    problem: Problem,
    contact: Contact,
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
        return plastic.graded_layers(_FIRST_LAYER * min(pixel), depth, LAYER_RATIO), margin
    thickness = np.array(layers, float)
    if thickness.sum() < radius:
        raise InputError(
            f"reach {thickness.sum():.4g} m deep, less than the radius {radius:.4g} m of "
            "the largest contact spot: plastic strain would pass through them; reach "
            f"{_DEPTH * radius:.4g} m, or leave them out",
            argument="layers",
        )
    return thickness, margin


# Steps on disk


def _steps(
    folder: str | os.PathLike[str],
    count: int,
    problem: Problem,
    start: ElastoplasticResult | None,
    volume: list[float],
) -> list[Path]:
    """Return the files of all loads, after a look at what stands in the folder.

    The volume is the margin, whether it may become deeper, and the thickness of its layers.
    """
    from roughcontact.contact import resume

    described = resume.contact(
        problem.surface, problem.counter_surface, problem.material, problem.counter_material
    )
    described |= {
        "boundary": problem.boundary,
        "layers": resume.digest(volume),
        "tolerance": float(problem.tolerance),
        "max_iterations": int(problem.max_iterations),
        "precision": problem.precision,
        "start": None,
    }
    if start is not None:
        layers = [strain for body in start.bodies for strain in body.plastic_strain]
        flowed = [layer for body in start.bodies for layer in body.accumulated]
        described["start"] = resume.digest(start.contact.pressure, *layers, *flowed)
    place = resume.claim(folder, described, kind="run", record="volume.json", pattern="step-*.nc")
    return [place / f"step-{number:04d}.nc" for number in range(1, count + 1)]


def _kept(
    path: Path, loads: list[float], problem: Problem
) -> tuple[ElastoplasticResult, dict[str, Array]]:
    """Return the state after some loads, and what the loop carries on from it."""
    from roughcontact.contact.archive import load_step

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
    from roughcontact.contact.archive import save_elastoplastic

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
        raise InputError("must be a row of numbers [N]", argument="loads") from None
    if path.ndim != 1 or not path.size or not ((path >= 0) & np.isfinite(path)).all():
        raise InputError(
            f"must be finite and not negative [N], got {loads!r}", argument="loads", value=loads
        )
    if not path.any() and first == 0:
        raise InputError(
            "are all zero: at least one must press the bodies together", argument="loads"
        )
    return [float(value) for value in path]


def _spots(
    contact: Contact, load: float, body: Material | None, pixel: tuple[float, float]
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
