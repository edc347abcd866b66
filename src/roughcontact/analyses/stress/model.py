"""Elastic stress below a contact, and the load of first yield."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._tools import memory, netcdf
from roughcontact._tools.arguments import validate_arguments
from roughcontact._version import __version__
from roughcontact.cautions import Caution, CautionTag, as_caution, as_warning, sort_cautions
from roughcontact.contact import archive
from roughcontact.contact.load_case import LoadCase
from roughcontact.contact.memory import fixed_bytes
from roughcontact.contact.pair import BODIES, CounterSurface, Pair
from roughcontact.contact.result import ContactResult
from roughcontact.contact.solve import solve_pair
from roughcontact.contact.validation import as_finite_row
from roughcontact.errors import (
    ArgumentRef,
    ConvergenceError,
    InputError,
    input_error,
    require_positive,
)
from roughcontact.halfspace import coating_stress, stress_summary
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.fft import Workspace, default_workers
from roughcontact.halfspace.stress import checked_traction, graded_depths
from roughcontact.halfspace.tensors import COMPONENTS, von_mises
from roughcontact.material.material import CEILING_FACTOR, RIGID, Material
from roughcontact.result import Result
from roughcontact.solvers.progress import Tell, each_part, shows_progress_bar
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantities, Quantity, format_engineering, to_si


class Part(NamedTuple):
    """Largest stress of a layer of a coated body, or of its base."""

    name: str
    max_von_mises: float  # Largest von Mises stress [Pa]
    depth: float  # Depth of the largest von Mises stress [m]
    strength: float | None  # Yield strength, or a third of the hardness [Pa]
    of_hardness: bool  # Whether the strength is a third of the hardness

    @property
    def use(self) -> float:
        """Largest von Mises stress over the strength; NaN if unknown."""
        return math.nan if self.strength is None else self.max_von_mises / self.strength


@dataclass(frozen=True, eq=False, repr=False)
class StressResult(Result):
    """Elastic stress below a contact, with its inputs.

    Arrays are read-only and in SI units; tensors hold xx, yy, zz, yz, xz, xy along their first
    axis, tension positive, z from the surface into the body.

    Parameters
    ----------
    solution : ContactResult
        The contact.
    body : {"body", "counter_body"}
        Body of the stress.
    friction : float
        Coefficient μ of the traction μ p on the rough body in ``direction``; the
        counter-body has the opposite traction.
    direction : float
        Angle from x [degrees], counter-clockwise as seen in the map.
    traction : ndarray, shape (2, ny, nx), optional
        Traction on the rough body [Pa], components (y, x), instead of friction.
    precision : {"double", "single"}
        Arithmetic of the transforms.
    profile : stress_summary.Summary
        Largest stresses over the depths, their positions, and yielded areas.
    section_x : ndarray, shape (6, nz, nx)
        Tensors on the plane along x through the largest von Mises stress [Pa].
    section_y : ndarray, shape (6, nz, ny)
        Tensors on the plane along y through the largest von Mises stress [Pa].
    version : str
        Version of the program.
    faces : tuple of coating_stress.Face
        Largest stresses of the surface and of both sides of the interfaces of a coated body.
    overall : StressResult, optional
        The stress at the automatic depths, if other depths were given: yielding is judged there.
    base : StressResult, optional
        The same stress under the ceiling of the base of a coated body, if both were requested.
    calibrated : StressResult, optional
        The same stress under the calibrated ceiling, if computed.
    """

    solution: ContactResult
    body: str
    friction: float
    direction: float
    precision: str
    profile: stress_summary.Summary
    section_x: NDArray[Any]
    section_y: NDArray[Any]
    version: str = field(default="")
    traction: NDArray[Any] | None = None
    faces: tuple[coating_stress.Face, ...] = ()
    overall: StressResult | None = None
    base: StressResult | None = None
    calibrated: StressResult | None = None

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        held = (*vars(self.profile).values(), self.section_x, self.section_y, self.traction)
        for array in held:
            if isinstance(array, np.ndarray):
                array.flags.writeable = False

    @property
    def contact(self) -> ContactResult:
        """Contact below which the stress is computed."""
        return self.solution

    @property
    def material(self) -> Material:
        """Material of the body."""
        return self.solution.pair.material_of(self.body)

    @property
    def max_von_mises(self) -> float:
        """Largest von Mises stress [Pa]."""
        return self.profile.max_von_mises

    @property
    def max_von_mises_at(self) -> tuple[float, float, float]:
        """Position of the largest von Mises stress: depth, y, x [m] from the map corner."""
        return self.profile.depth_of_max, *self.center(self.profile.pixel_of_max)

    def center(self, pixel: tuple[int, int]) -> tuple[float, float]:
        """Return y and x of the center of a pixel [m], from the corner of the map."""
        (row, column), (dy, dx) = pixel, self.solution.surface.pixel
        return (row + 0.5) * dy, (column + 0.5) * dx

    @property
    def max_tension(self) -> float | None:
        """Largest principal stress in the surface [Pa]; ``None`` if depths exclude the surface."""
        return self.profile.max_tension

    @property
    def max_tension_at(self) -> tuple[float, float]:
        """Position of the largest tension: y and x [m] from the corner of the map."""
        return self.center(self.profile.tension_pixel)

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """Layers of a coated body, the outermost first, and its base; else empty."""
        body, depths = self.material, self.profile.depths
        if not body.coating:
            return ()
        of = np.array([coating_stress.part_of(body, depth) for depth in depths.tolist()])
        result = []
        items = [layer.bulk for layer in body.coating]
        for number, item in enumerate([*items, body.uncoated]):
            within = np.flatnonzero(of == number)
            if within.size:
                place = within[self.profile.von_mises[within].argmax()]
                strength, hard = item.yield_strength, item.hardness
                by_hardness = strength is None and hard is not None
                if strength is None and hard is not None:
                    strength = hard / CEILING_FACTOR
                usual = "base" if number == len(body.coating) else f"layer {number + 1}"
                name = item.name or usual
                largest = float(self.profile.von_mises[place])
                result.append(Part(name, largest, float(depths[place]), strength, by_hardness))
        return tuple(result)

    @property
    def yield_factor(self) -> float | None:
        """Yield strength over the largest von Mises stress; ``None`` if unknown.

        The first point yields if the pressure grows by this factor everywhere. The load may grow
        by it only if the contact area is unchanged; see `first_yield_load`.
        """
        return self.profile.yield_factor

    @property
    def yielded_volume(self) -> float | None:
        """Volume where the von Mises stress exceeds the yield strength [m³]."""
        return self.profile.yielded_volume

    @property
    def cautions(self) -> tuple[Caution, ...]:
        """Cautions on the stress, the most severe first."""
        return sort_cautions([*self.solution.cautions, *self.own_cautions])

    @property
    def own_cautions(self) -> tuple[Caution, ...]:
        """Cautions on the stress, without those on the contact."""
        return tuple(self._own_cautions())

    def _own_cautions(self) -> Iterator[Caution]:
        """Yield cautions on yielding, on the position of the largest stress and on layers."""
        if self.yielded_volume:
            yield as_caution(
                CautionTag.YIELDED,
                "Material yields: this elastic stress is an upper bound. For plastic depth "
                "use the elastoplastic model.",
                volume=self.yielded_volume,
            )
        if self.max_von_mises > 0:
            yield from self._position_cautions()
        edge = max(self.solution.pair.pixel[self.solution.pair.is_profile :])
        thinnest = min((layer.thickness for layer in self.material.coating), default=math.inf)
        if edge > thinnest / 4:
            yield as_caution(
                CautionTag.STRESS_PIXEL,
                f"Pixel {format_engineering(edge, 'm', 3)} exceeds a quarter of a layer "
                f"({format_engineering(thinnest, 'm', 3)}): its stress depends on the grid.",
                depth=thinnest,
            )

    def _position_cautions(self) -> Iterator[Caution]:
        """Yield cautions on a largest stress at the ends of the depths or at the pixel scale."""
        depth, depths = self.profile.depth_of_max, self.profile.depths
        text = format_engineering(depth, "m", 3)
        if depth == depths[-1]:
            yield as_warning(
                CautionTag.STRESS_DEPTH,
                f"Maximum stress is at the deepest layer ({text}). Extend {ArgumentRef('depths')}.",
                depth=depth,
            )
        if depth == 0:
            yield as_caution(
                CautionTag.STRESS_PIXEL,
                "Maximum stress is at a sliding spot edge: error 1 % above 20 pixels per radius, "
                "6 % at 6.",
                depth=depth,
            )
        elif depth < 2 * max(self.solution.pair.pixel[self.solution.pair.is_profile :]):
            yield as_caution(
                CautionTag.STRESS_PIXEL,
                f"Maximum stress is {text} deep, below 2 pixels: it depends on the grid.",
                depth=depth,
            )
        elif depth == depths[0] != depths[-1]:
            yield as_warning(
                CautionTag.STRESS_DEPTH,
                f"Maximum stress is at the shallowest layer ({text}). Add smaller "
                f"{ArgumentRef('depths')}.",
                depth=depth,
            )

    def von_mises_section(self, along: str) -> NDArray[Any]:
        """Return the von Mises stress on a plane through its maximum.

        Parameters
        ----------
        along : {"x", "y"}
            The horizontal axis of the plane.

        Returns
        -------
        ndarray, shape (nz, nx) or (nz, ny)
            Equivalent stress [Pa].

        Raises
        ------
        InputError
            If ``along`` is unknown.
        """
        if along not in ("x", "y"):
            raise input_error("along", along, "must be 'x' or 'y'")
        return von_mises(self.section_x if along == "x" else self.section_y)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write stress and contact to a NetCDF file.

        Parameters
        ----------
        path : str or path
            File to write, ``.nc``; it appears only once it is complete. The dataset is from
            `to_dataset`.

        Raises
        ------
        InputError
            If the suffix is not ``.nc``.
        OSError
            If the file cannot be written; an old file survives.
        """
        netcdf.write(to_dataset(self), path, dict.fromkeys(archive.PACKED, netcdf.PACKED))


def to_dataset(result: StressResult) -> netcdf.Dataset:
    """Return a stress result as a dataset."""
    dataset = archive.to_dataset(result.solution)
    add_profile(dataset, result.profile)
    for axis, section in (("x", result.section_x), ("y", result.section_y)):
        text = f"stress on the plane along {axis} through the largest von Mises stress"
        dataset.add(f"section_{axis}", ("component", "depth", axis), section, "Pa", text)
    if result.traction is not None:
        for axis, values in zip("yx", result.traction, strict=True):
            text = f"tangential traction on the rough body along {axis}"
            dataset.add(f"traction_{axis}", ("y", "x"), values, "Pa", text)
    depth, y, x = result.max_von_mises_at
    if result.faces:
        dataset.attrs["faces"] = json.dumps([asdict(face) for face in result.faces])
    dataset.attrs |= {
        "title": "Stress below a contact of rough surfaces",
        "body": result.body,
        "friction": result.friction,
        "direction": result.direction,
        "direction_units": "degree",
        "stress_precision": result.precision,
        "max_von_mises": result.max_von_mises,
        "max_von_mises_units": "Pa",
        "max_von_mises_depth": depth,
        "max_von_mises_y": y,
        "max_von_mises_x": x,
        "warnings": "\n".join(result.warnings),
    }
    return dataset


def add_profile(dataset: netcdf.Dataset, profile: stress_summary.Summary) -> None:
    """Add the largest stresses over depth and map to a dataset."""
    dataset.add("depth", "depth", profile.depths, "m", "depth below the surface")
    dataset["component"] = ("component", list(COMPONENTS))
    dataset["pass"] = ("pass", ["y", "x"])
    over_depth = {
        "von_mises": (profile.von_mises, "Pa", "largest von Mises stress"),
        "tresca": (profile.tresca, "Pa", "largest Tresca stress"),
        "row": (profile.pixels[:, 0], "1", "row of the largest von Mises stress"),
        "column": (profile.pixels[:, 1], "1", "column of the largest von Mises stress"),
    }
    for name, described in over_depth.items():
        dataset.add(name, "depth", *described)
    text = "largest amplitude of the orthogonal shear stress in a pass along an axis"
    dataset.add("orthogonal_shear", ("depth", "pass"), profile.orthogonal_shear, "Pa", text)
    if profile.yielded_area is not None:
        # Pixels of a profile are one meter wide, so that areas are lengths.
        extent, unit = ("length", "m") if profile.peak.shape[0] == 1 else ("area", "m2")
        text = f"{extent} where the von Mises stress exceeds the yield strength"
        dataset.add("yielded_area", "depth", profile.yielded_area, unit, text)
    text = "largest von Mises stress over depth"
    dataset.add("peak_von_mises", ("y", "x"), profile.peak, "Pa", text)


# Stress below a solved contact.


# Additional memory of the blocks of a thread [bytes], compared with a solve.
_THREAD = 2**23


@shows_progress_bar
@validate_arguments
def subsurface_stress(
    result: ContactResult,
    depths: Quantities | ArrayLike | None = None,
    *,
    in_body: str = "body",
    friction: float = 0.0,
    direction: float = 0.0,
    traction: ArrayLike | None = None,
    precision: str = "single",
    progress: Tell = None,
) -> StressResult:
    """Return the elastic stress below a solved contact.

    Parameters
    ----------
    result : ContactResult
        The contact; its boundary is kept.
    depths : array_like, or sequence of str or quantity of pint, optional
        Depths z > 0 [m]; by default the surface, and from half a pixel to three contact radii,
        finer around the largest stress (`stress_summary.summarize`).
    in_body : {"body", "counter_body"}
        The rough body, or its counter-body. Both have the same pressure; the stress differs by
        Poisson's ratio and by the sign of the friction.
    friction : float
        Coefficient μ of the traction μ p on the rough body. Its small effect on the pressure
        between unlike bodies is neglected.
    direction : float
        Angle of that traction from x [degrees], counter-clockwise as seen in the map, whose first
        row is drawn on top: 90 points to smaller y.
    traction : array_like, shape (2, ny, nx), optional
        Traction of partial slip on the rough body [Pa], components (y, x), instead of friction.
    precision : {"double", "single"}
        Arithmetic of the transforms; single is accurate to 1e-6 of the largest pressure.
    progress : callable or bool, optional
        ``True`` draws a bar on standard error; a function is called with a `Progress`, the number
        of the depth.

    Returns
    -------
    StressResult
        Largest stresses, their positions, and the planes through the largest.

    Raises
    ------
    InputError
        If an argument cannot be used, the body is rigid, or there is no pressure.
    InsufficientMemoryError
        If the free memory is too small for a few layers.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact import Material, Surface, solve
    >>> y, x = np.mgrid[-31.5:32, -31.5:32] * 1e-6
    >>> ball = Surface(-(x**2 + y**2) / (2 * 0.01), pixel=(1e-6, 1e-6))
    >>> steel = Material(young=210e9, poisson=0.3, yield_strength=1e9)
    >>> found = subsurface_stress(solve(ball, material=steel, load=0.1))
    >>> round(found.max_von_mises / found.solution.max_pressure, 2)
    0.62
    """
    material = result.pair.material_of(in_body)
    if math.isinf(material.young) and not material.coating:
        raise InputError(f"the {BODIES[in_body]} is rigid: there is no stress in it to compute")
    wanted = to_si(depths, "length", "depths")
    _check_depths(wanted)
    require_memory(
        result.surface.shape,
        boundary=result.boundary,
        precision=precision,
        friction=friction,
        partial_slip=traction is not None,
    )
    options = {**surface_loads(result.pair, in_body, friction, direction), "precision": precision}
    if traction is not None:
        traction = checked_traction(traction, result.pressure.shape, friction).copy()
        options["traction"] = traction if in_body == "body" else -traction
    options["tell"] = each_part(progress, "stress below the surface")
    (profile, *sections), faces = (_layered_stress if material.coating else _bulk_stress)(
        result, material, wanted, options
    )
    whole = None
    if wanted is not None:
        sliding: dict[str, Any] = {"friction": friction, "direction": direction}
        sliding |= {"traction": traction, "precision": precision}
        whole = subsurface_stress(result, in_body=in_body, **sliding)
    return StressResult(
        result,
        in_body,
        friction,
        direction,
        precision,
        profile,
        sections[0],
        sections[1],
        version=__version__,
        traction=traction,
        faces=faces,
        overall=whole,
    )


def _bulk_stress(
    result: ContactResult, material: Material, depths: Any, options: dict[str, Any]
) -> tuple[Any, tuple[coating_stress.Face, ...]]:
    """Return the summary of a homogeneous body with its sections, without faces."""
    return stress_summary.summarize_with_sections(
        result.pressure,
        result.pair.pixel,
        material.poisson,
        depths=depths,
        yield_strength=material.yield_strength,
        **options,
    ), ()


def _layered_stress(
    result: ContactResult, material: Material, depths: Any, options: dict[str, Any]
) -> tuple[Any, tuple[coating_stress.Face, ...]]:
    """Return the summary of a coated body with its sections, and stresses at its faces."""
    if options["friction"] or "traction" in options:
        raise InputError("is not available for a coated body; leave it out", argument="friction")
    pressure, pixel, boundary = result.pressure, result.pair.pixel, result.boundary
    if result.pair.is_profile and boundary.free_axes:
        raise InputError(
            f"= {str(boundary)!r} is not available for layers below a profile; solve with "
            f"{str(Boundary.PERIODIC)!r}",
            argument="boundary",
            value=boundary,
        )
    if boundary.free_axes:
        # The periodic images of a narrow map are farther away.
        rows, columns = coating_stress.stress_period(pressure.shape, pixel, boundary)
        require_memory((rows // 2, columns // 2), precision=options["precision"])
    stress = coating_stress.field_of(
        pressure, pixel, material, boundary, options["precision"], Workspace()
    )
    if depths is None:
        depths = graded_depths(pressure, pixel, boundary=boundary)
    listed = coating_stress.depths_with_faces(material, np.asarray(depths, dtype=np.float64))
    summary = stress_summary.summarize_field(
        stress, pressure, listed, pixel[0] * pixel[1], options["tell"]
    )
    return summary, coating_stress.faces(stress, material)


def _check_depths(depths: ArrayLike | None) -> None:
    if depths is None:
        return
    minimum = float(as_finite_row(depths, "depths").min())
    if minimum <= 0:
        raise InputError(
            f"must be below the surface, got {minimum!r} m; give depths above 0",
            argument="depths",
            value=minimum,
        )


def surface_loads(pair: Pair, body: str, friction: float, direction: float) -> dict[str, Any]:
    """Return the surface loads of a body in the form of `halfspace.stress`."""
    return {
        "boundary": pair.boundary,
        "friction": friction if body == "body" else -friction,
        # y points down on a map. ``0.0 - direction`` avoids a negative zero.
        "direction": math.radians(0.0 - direction),
    }


def memory_estimate(
    shape: tuple[int, int],
    *,
    boundary: str = "free",
    precision: str = "single",
    friction: float = 0.0,
    partial_slip: bool = False,
) -> int:
    """Return the memory need of `subsurface_stress` in addition to the contact [bytes]."""
    ny, nx = shape
    pixels, real = ny * nx, 4 if precision == "single" else 8
    # With a traction map, three load components have a spectrum and a map.
    loads = 3 if partial_slip else 1
    friction = friction or float(partial_slip)
    # Scaled pressure and largest stress over depth; row spectra of six components.
    maps = (
        8 * (3 * loads - 2) * pixels + real * pixels + fixed_bytes() + _THREAD * default_workers()
    )
    if friction != 0:
        # For friction: scaled pressure, displacement, and the stress along the surface.
        maps += (8 + 8 + 3 * real) * pixels
        maps += max(Boundary(boundary).operator_memory(shape, "double") - 6 * real * pixels, 0)
    if not Boundary(boundary).free_axes:
        return maps + (6 + loads) * real * ny * (nx + 2)
    padded = (2 * ny) * (2 * nx + 2)
    # Spectra of the pressure, the second with memory to blend kernels; samples of the kernels.
    spectra = real * padded + (real * padded * 25 // 16 if precision == "single" else 0)
    spectra *= loads
    kernels = 6 if friction == 0 else 12
    return maps + 6 * real * padded // 2 + spectra + kernels * real * (ny + 1) * (nx + 1)


def require_memory(shape: tuple[int, int], **terms: Any) -> None:
    """Raise `InsufficientMemoryError` unless the stress below a map fits into free memory."""
    memory.require_memory(
        memory_estimate(shape, **terms),
        f"the stress below {shape[0]} × {shape[1]} points needs",
        advice=("solve the contact on a part of the map, surface.cropped(...)",),
    )


# Maximum load factor of a step in the search for first yield, and maximum number of solves.
_MAX_LOAD_FACTOR = 1000.0
_MAX_SOLVES = 40


@validate_arguments
def first_yield_load(
    surface: Surface,
    *,
    material: Material,
    counter_material: Material = RIGID,
    counter_surface: CounterSurface | None = None,
    body: str = "body",
    friction: float = 0.0,
    direction: float = 0.0,
    boundary: str = "free",
    initial_load: Quantity | None = None,
    tolerance: float = 1e-3,
) -> StressResult:
    """Return the contact and the stress at the load of first yield.

    Parameters
    ----------
    surface, material, counter_material, counter_surface, boundary
        As for `contact.solve`; the contact is elastic, without a ceiling.
    body, friction, direction
        As for `subsurface_stress`.
    initial_load : float, optional
        Initial load [N]; by default the load of one pixel at 1.6 times the yield strength.
    tolerance : float
        Relative tolerance of the largest von Mises stress at the yield strength.

    Returns
    -------
    StressResult
        Its ``solution.load`` is the load of first yield.

    Raises
    ------
    InputError
        If the body is rigid or has no yield strength, or an argument cannot be used.
    ConvergenceError
        If no such load is found.

    Notes
    -----
    The largest stress is about a power of the load, with exponent 1/3 for a sphere; each step is
    therefore a secant step of the logarithms, within the bracket of known loads. A surface with
    roughness down to the pixel yields at its sharpest summit under almost no load: the result then
    depends on the pixel.
    """
    pair = Pair.from_arguments(surface, material, counter_surface, counter_material, boundary)
    return solve_first_yield(
        pair, body, friction, direction, start=initial_load, tolerance=tolerance
    )


def solve_first_yield(
    pair: Pair,
    body: str = "body",
    friction: float = 0.0,
    direction: float = 0.0,
    *,
    start: Quantity | None = None,
    tolerance: float = 1e-3,
) -> StressResult:
    """Return the stress below the contact of two bodies at the load of first yield."""
    require_positive(tolerance=tolerance)
    pair.require_uncoated("the stress below the surface")
    if not pair.is_profile:
        pair.boundary.require_known_below("the stress below the surface")
    first = to_si(start, "force", "start")
    if first is not None:
        require_positive(start=first)
    strength = _yield_strength(pair, body)
    load: float = first or 1.6 * strength * pair.pixel[0] * pair.pixel[1]
    known: list[tuple[float, float]] = []
    last: ContactResult | None = None
    for _ in range(_MAX_SOLVES):
        last = solve_pair(pair, LoadCase(load=load, ceiling=None), start=last)
        profile = stress_summary.summarize(
            last.pressure,
            pair.pixel,
            pair.material_of(body).poisson,
            **surface_loads(pair, body, friction, direction),
        )
        excess = math.log(profile.max_von_mises / strength)
        if abs(excess) <= tolerance:
            return subsurface_stress(last, in_body=body, friction=friction, direction=direction)
        known.append((math.log(load), excess))
        load = math.exp(_next_load(known))
    assert last is not None
    raise ConvergenceError(
        f"no load found at which the largest stress is the yield strength: after {_MAX_SOLVES} "
        f"contacts it is {math.exp(known[-1][1]):.4g} of it at {last.load:.6g} {pair.load_unit}",
        last,
    )


def _yield_strength(pair: Pair, body: str) -> float:
    material = pair.material_of(body)
    if material.yield_strength is None or math.isinf(material.young):
        raise InputError(f"the {BODIES[body]} has no yield strength: give its material one")
    return material.yield_strength


def _next_load(known: list[tuple[float, float]]) -> float:
    """Return the estimated root of an increasing function from some of its points."""
    light = max((x for x, y in known if y < 0), default=-math.inf)
    heavy = min((x for x, y in known if y > 0), default=math.inf)
    (index, value), *others = sorted(known, key=lambda point: abs(point[1]))
    slope = 1 / 3
    if others and others[0][0] != index:
        slope = max((others[0][1] - value) / (others[0][0] - index), 0.0) or slope
    maximum = math.log(_MAX_LOAD_FACTOR)
    guess = index + min(max(-value / slope, -maximum), maximum)
    # Bisect if the secant leaves the bracket, or approaches from one side only.
    stuck = len(known) > 3 and len({y > 0 for _, y in known[-3:]}) == 1
    if light < heavy < math.inf and light > -math.inf and (stuck or not light < guess < heavy):
        return 0.5 * (light + heavy)
    return guess
