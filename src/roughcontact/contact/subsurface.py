"""Stress below a solved contact: where each body is strained most, and when it first yields.

The stress is elastic. Where it exceeds the yield strength it says how far the body is from being
elastic, not what the body carries.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact._version import __version__
from roughcontact.contact import archive
from roughcontact.contact import solve as contact
from roughcontact.contact.result import ContactResult
from roughcontact.errors import (
    ConvergenceError,
    InputError,
    InsufficientMemoryError,
    require_positive,
)
from roughcontact.files import replacing
from roughcontact.halfspace import stress, stress_summary
from roughcontact.halfspace.tensors import COMPONENTS, von_mises
from roughcontact.material.material import RIGID, Material
from roughcontact.surface.surface import Surface

if TYPE_CHECKING:
    import xarray

_BODIES = ("first", "second")
# Largest step of the search for first yield, and most contacts that it solves.
_STEP = 1000.0
_SOLVES = 40


@dataclass(frozen=True, eq=False)
class StressResult:
    """Elastic stress below a contact, with everything that went in.

    Arrays are read-only and in SI units; tensors hold xx, yy, zz, yz, xz, xy along their first
    axis, tension positive, z from the surface into the body.

    Parameters
    ----------
    contact : ContactResult
        The contact.
    body : {"first", "second"}
        The body that was looked into.
    friction : float
        Coefficient μ of the traction μ p that the first body feels in ``direction``; the second
        feels the opposite.
    direction : float
        Angle from x towards y [rad].
    precision : {"double", "single"}
        Arithmetic of the transforms.
    profile : stress_summary.Summary
        Largest stresses over the depths, their places, what exceeds the yield strength.
    section_x : ndarray, shape (6, nz, nx)
        Tensors on the plane along x through the largest von Mises stress [Pa].
    section_y : ndarray, shape (6, nz, ny)
        Tensors on the plane along y through it [Pa].
    version : str
        Version of the program.
    """

    contact: ContactResult
    body: str
    friction: float
    direction: float
    precision: str
    profile: stress_summary.Summary
    section_x: NDArray[Any]
    section_y: NDArray[Any]
    version: str = field(default="")

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        held = (*vars(self.profile).values(), self.section_x, self.section_y)
        for array in held:
            if isinstance(array, np.ndarray):
                array.flags.writeable = False

    @property
    def material(self) -> Material:
        """Material of the body."""
        return _body(self.contact, self.body)

    @property
    def max_von_mises(self) -> float:
        """Largest von Mises stress [Pa]."""
        return self.profile.max_von_mises

    @property
    def place(self) -> tuple[float, float, float]:
        """Where it is: depth, y and x [m], counted from the corner of the map."""
        (row, column), (dy, dx) = self.profile.pixel_of_max, self.contact.surface.pixel
        return self.profile.depth_of_max, (row + 0.5) * dy, (column + 0.5) * dx

    @property
    def yield_factor(self) -> float | None:
        """Yield strength over the largest von Mises stress; ``None`` if it is unknown.

        The whole pressure may grow by this factor until the first point yields. The load may
        only where the contact area stays as it is; see `yield_onset`.
        """
        return self.profile.yield_factor

    @property
    def yielded_volume(self) -> float | None:
        """Volume where the von Mises stress exceeds the yield strength [m³]."""
        return self.profile.yielded_volume

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a reader of the numbers has to know, one sentence each."""
        notes = list(self.contact.warnings)
        if self.yielded_volume:
            notes.append(
                "the stress exceeds the yield strength: it is that of an elastic body, which this "
                "one no longer is"
            )
        if self.max_von_mises > 0 and self.profile.depth_of_max == self.profile.depths[-1]:
            notes.append("the largest stress lies at the greatest depth: look deeper")
        if 0 < self.profile.depth_of_max < 2 * max(self.contact.surface.pixel):
            notes.append(
                "the largest stress lies within two pixels of the surface: it is one of the "
                "resolution of the map"
            )
        return tuple(notes)

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
            If ``along`` is something else.
        """
        if along not in ("x", "y"):
            raise InputError(f"must be 'x' or 'y', got {along!r}", argument="along", value=along)
        return von_mises(self.section_x if along == "x" else self.section_y)

    def summary(self) -> dict[str, Any]:
        """Return the scalar results by name, in SI units, ready for JSON."""
        profile = self.profile
        along_y, along_x = profile.max_orthogonal_shear
        return {
            "body": self.body,
            "friction": self.friction,
            "direction": self.direction,
            "load": self.contact.load,
            "max_pressure": self.contact.max_pressure,
            "max_von_mises": profile.max_von_mises,
            "max_von_mises_place": list(self.place),
            "max_tresca": profile.max_tresca,
            "max_orthogonal_shear_along_y": along_y,
            "max_orthogonal_shear_along_x": along_x,
            "yield_strength": profile.yield_strength,
            "yield_factor": profile.yield_factor,
            "yielded_volume": profile.yielded_volume,
            "depths": [float(profile.depths[0]), float(profile.depths[-1])],
            "warnings": list(self.warnings),
            "precision": self.precision,
            "version": self.version,
        }

    def save(self, path: str | Path) -> None:
        """Write everything to a NetCDF file.

        Parameters
        ----------
        path : str or path
            File to write, ``.nc``; it appears only once it is complete. The dataset is that of
            `to_dataset`.

        Raises
        ------
        InputError
            If the suffix is not ``.nc``.
        OSError
            If the file cannot be written; an old file survives.
        """
        if Path(path).suffix.lower() != ".nc":
            raise InputError(
                f"must end in .nc, got {str(path)!r}", argument="path", value=str(path)
            )
        dataset = to_dataset(self)
        packed = {name: {"zlib": True, "complevel": 1} for name in ("pressure", "saturated")}
        with replacing(path) as temporary:
            dataset.to_netcdf(temporary, engine="h5netcdf", encoding=packed)


def subsurface_stress(
    result: ContactResult,
    depths: ArrayLike | None = None,
    *,
    body: str = "first",
    friction: float = 0.0,
    direction: float = 0.0,
    precision: str = "single",
) -> StressResult:
    """Return the elastic stress below a solved contact.

    Parameters
    ----------
    result : ContactResult
        The contact; its boundary is kept.
    depths : array_like, optional
        Depths z > 0 [m]; by default the surface and from half a pixel to three contact radii, with
        more around the largest stress (`stress_summary.summarise`).
    body : {"first", "second"}
        The rough body, or its counter-body. Both feel the same pressure; the stress differs by
        Poisson's ratio and by the sign of the friction.
    friction : float
        Coefficient μ of the traction μ p on the first body. That it alters the pressure a little
        between unlike bodies is neglected.
    direction : float
        Angle of that traction from x towards y [rad].
    precision : {"double", "single"}
        Arithmetic of the transforms; single is good to 1e-6 of the largest pressure.

    Returns
    -------
    StressResult
        Largest stresses, their places, and the planes through the largest.

    Raises
    ------
    InputError
        If an argument cannot be used, the body is rigid, or there is no pressure.
    InsufficientMemoryError
        If the memory that is free does not hold a few layers.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact import Material, Surface, solve
    >>> y, x = np.mgrid[-31.5:32, -31.5:32] * 1e-6
    >>> ball = Surface(-(x**2 + y**2) / (2 * 0.01), pixel=(1e-6, 1e-6))
    >>> steel = Material(young=210e9, poisson=0.3, yield_strength=1e9)
    >>> found = subsurface_stress(solve(ball, material=steel, load=0.1))
    >>> round(found.max_von_mises / found.contact.max_pressure, 2)
    0.62
    """
    if not isinstance(result, ContactResult):
        raise InputError(f"must be a ContactResult, got {type(result).__name__}", argument="result")
    material = _body(result, body)
    if math.isinf(material.young):
        raise InputError(f"the {body} body is rigid: there is no stress in it to compute")
    if depths is not None and not (np.asarray(depths, dtype=float) > 0).all():
        raise InputError(
            f"must lie below the surface, got {float(np.min(depths))!r} m; the "
            "surface itself is `stress.slices` at 0",
            argument="depths",
            value=float(np.min(depths)),
        )
    _check_memory(result, precision, friction)
    pull = friction if body == "first" else -friction
    options: dict[str, Any] = {
        "boundary": result.boundary,
        "friction": pull,
        "direction": direction,
        "precision": precision,
    }
    pressure, pixel = result.pressure, result.surface.pixel
    profile = stress_summary.summarise(
        pressure,
        pixel,
        material.poisson,
        depths=depths,
        yield_strength=material.yield_strength,
        **options,
    )
    section_x, section_y = stress.sections(
        pressure, pixel, profile.depths, material.poisson, profile.pixel_of_max, **options
    )
    return StressResult(
        contact=result,
        body=body,
        friction=friction,
        direction=direction,
        precision=precision,
        profile=profile,
        section_x=section_x,
        section_y=section_y,
        version=__version__,
    )


def memory_estimate(
    shape: tuple[int, int],
    *,
    boundary: str = "free",
    precision: str = "single",
    friction: float = 0.0,
) -> int:
    """Return the memory that `subsurface_stress` needs beyond the contact itself.

    Parameters
    ----------
    shape : (int, int)
        Grid points ``(ny, nx)``.
    boundary, precision, friction
        As for `subsurface_stress`.

    Returns
    -------
    int
        Bytes, however many depths there are.
    """
    ny, nx = shape
    pixels, real = ny * nx, 4 if precision == "single" else 8
    # Scaled pressure and largest stress over depth; row spectra of six components.
    maps = 8 * pixels + real * pixels
    if boundary == "periodic":
        return maps + (6 + 1) * real * ny * (nx + 2)
    padded = (2 * ny) * (2 * nx + 2)
    # Spectra of the pressure, the second with room to blend kernels; samples of the kernels.
    spectra = real * padded + (real * padded * 25 // 16 if precision == "single" else 0)
    kernels = 6 if friction == 0 else 18
    return maps + 6 * real * padded // 2 + spectra + kernels * real * (ny + 1) * (nx + 1)


def yield_onset(
    surface: Surface,
    *,
    material: Material,
    counter_material: Material = RIGID,
    counter_surface: Surface | None = None,
    body: str = "first",
    friction: float = 0.0,
    direction: float = 0.0,
    boundary: str = "free",
    start: float | None = None,
    tolerance: float = 1e-3,
) -> StressResult:
    """Return the contact at the load at which the first point of a body yields.

    Parameters
    ----------
    surface, material, counter_material, counter_surface, boundary
        As for `contact.solve`; the contact is elastic, without a ceiling.
    body, friction, direction
        As for `subsurface_stress`.
    start : float, optional
        Load to begin with [N]; by default that of one pixel at 1.6 times the yield strength.
    tolerance : float
        How close the largest von Mises stress must come to the yield strength, relatively.

    Returns
    -------
    StressResult
        Its ``contact.load`` is the load of first yield.

    Raises
    ------
    InputError
        If the body is rigid or has no yield strength, or an argument cannot be used.
    ConvergenceError
        If no such load is found.

    Notes
    -----
    The largest stress grows with the load as a power that is 1/3 for a sphere and depends on the
    shape else, so each step is a secant of their logarithms, kept between the loads known to be
    too light and too heavy. A surface that is rough down to the pixel yields at its sharpest summit
    under next to no load: the answer then is one of the resolution.
    """
    require_positive(tolerance=tolerance)
    if start is not None:
        require_positive(start=start)
    if body not in _BODIES:
        raise InputError(f"must be 'first' or 'second', got {body!r}", argument="body", value=body)
    yielding = material if body == "first" else counter_material
    strength = yielding.yield_strength
    if strength is None or math.isinf(yielding.young):
        raise InputError(
            f"the {body} body has no yield strength: give its material one, "
            "Material(..., yield_strength=...)"
        )
    load = start or 1.6 * strength * surface.pixel[0] * surface.pixel[1]
    known: list[tuple[float, float]] = []
    last: ContactResult | None = None
    for _ in range(_SOLVES):
        last = contact.solve(
            surface,
            material=material,
            counter_material=counter_material,
            counter_surface=counter_surface,
            ceiling=None,
            boundary=boundary,
            load=load,
            start=last,
        )
        profile = stress_summary.summarise(
            last.pressure,
            surface.pixel,
            yielding.poisson,
            boundary=boundary,
            friction=friction if body == "first" else -friction,
            direction=direction,
        )
        excess = math.log(profile.max_von_mises / strength)
        if abs(excess) <= tolerance:
            return subsurface_stress(last, body=body, friction=friction, direction=direction)
        known.append((math.log(load), excess))
        load = math.exp(_next(known))
    assert last is not None
    raise ConvergenceError(
        f"no load found at which the largest stress is the yield strength: after {_SOLVES} "
        f"contacts it is {math.exp(known[-1][1]):.4g} of it at {last.load:.6g} N",
        last,
    )


def _next(known: list[tuple[float, float]]) -> float:
    """Return where an increasing function should vanish, from points of it."""
    light = max((x for x, y in known if y < 0), default=-math.inf)
    heavy = min((x for x, y in known if y > 0), default=math.inf)
    (at, value), *others = sorted(known, key=lambda point: abs(point[1]))
    slope = 1 / 3
    if others and others[0][0] != at:
        slope = max((others[0][1] - value) / (others[0][0] - at), 0.0) or slope
    most = math.log(_STEP)
    guess = at + min(max(-value / slope, -most), most)
    # A secant that leaves the bracket, or creeps along it from one side, is halved instead.
    stuck = len(known) > 3 and len({y > 0 for _, y in known[-3:]}) == 1
    if light < heavy < math.inf and light > -math.inf and (stuck or not light < guess < heavy):
        return 0.5 * (light + heavy)
    return guess


def to_dataset(result: StressResult) -> xarray.Dataset:
    """Return a stress result as an xarray dataset.

    Parameters
    ----------
    result : StressResult
        The result.

    Returns
    -------
    xarray.Dataset
        The dataset of the contact (`archive.to_dataset`), and over ``depth`` the largest
        ``von_mises`` and ``tresca``, their pixel, ``orthogonal_shear`` for passes along y and x,
        and ``yielded_area``; the map ``peak_von_mises``; tensors on the planes ``section_x`` and
        ``section_y``, whose place is in the attributes.
    """
    profile = result.profile
    dataset = archive.to_dataset(result.contact)

    def add(name: str, axes: tuple[str, ...], values: Any, unit: str, long_name: str) -> None:
        dataset[name] = (axes, values, {"units": unit, "long_name": long_name})

    dataset.coords["depth"] = (
        "depth", profile.depths, {"units": "m", "long_name": "depth below the surface"},
    )  # fmt: skip
    dataset.coords["component"] = ("component", list(COMPONENTS))
    dataset.coords["pass"] = ("pass", ["y", "x"])
    add("von_mises", ("depth",), profile.von_mises, "Pa", "largest von Mises stress")
    add("tresca", ("depth",), profile.tresca, "Pa", "largest Tresca stress")
    add("row", ("depth",), profile.pixels[:, 0], "1", "row of the largest von Mises stress")
    add("column", ("depth",), profile.pixels[:, 1], "1", "column of the largest von Mises stress")
    add(
        "orthogonal_shear", ("depth", "pass"), profile.orthogonal_shear, "Pa",
        "largest amplitude of the orthogonal shear stress in a pass along an axis",
    )  # fmt: skip
    if profile.yielded_area is not None:
        add(
            "yielded_area", ("depth",), profile.yielded_area, "m2",
            "area where the von Mises stress exceeds the yield strength",
        )  # fmt: skip
    add("peak_von_mises", ("y", "x"), profile.peak, "Pa", "largest von Mises stress over depth")
    for axis, section in (("x", result.section_x), ("y", result.section_y)):
        add(
            f"section_{axis}", ("component", "depth", axis), section, "Pa",
            f"stress on the plane along {axis} through the largest von Mises stress",
        )  # fmt: skip
    depth, y, x = result.place
    dataset.attrs |= {
        "title": "Stress below a contact of rough surfaces",
        "body": result.body,
        "friction": result.friction,
        "direction": result.direction,
        "direction_units": "rad",
        "stress_precision": result.precision,
        "max_von_mises": result.max_von_mises,
        "max_von_mises_units": "Pa",
        "max_von_mises_depth": depth,
        "max_von_mises_y": y,
        "max_von_mises_x": x,
        "warnings": "\n".join(result.warnings),
    }
    return dataset


def _check_memory(result: ContactResult, precision: str, friction: float) -> None:
    import psutil

    shape = result.surface.shape
    needed = memory_estimate(
        shape, boundary=result.boundary, precision=precision, friction=friction
    )
    free = psutil.virtual_memory().available
    if needed > free:
        raise InsufficientMemoryError(
            f"the stress below {shape[0]} × {shape[1]} points needs about "
            f"{needed / 2**30:.1f} GiB, and {free / 2**30:.1f} GiB are free: "
            "solve the contact on a part of the map, surface.cropped(...)"
        )


def _body(result: ContactResult, body: str) -> Material:
    if body not in _BODIES:
        raise InputError(f"must be 'first' or 'second', got {body!r}", argument="body", value=body)
    return result.material if body == "first" else result.counter_material
