"""Elastic stress below a loaded surface, slice by slice.

The body fills z > 0, tension is positive, and x, y are the axes of the map (``[y, x]``). A
tensor is an array whose first axis holds xx, yy, zz, yz, xz, xy, in this order. The surface
carries the normal pressure p, so that σ_zz = -p there, and with friction the traction
q = μ p on the body in one direction of the plane, so that σ_xz = -q_x and σ_yz = -q_y. The effect
of q on the pressure is neglected, as usual (Goodman's approximation; exact for equal bodies).

A depth is computed on its own: six kernels are sampled, transformed and multiplied with the one
spectrum of the pressure, and a visitor sees the stress row block by row block. Nothing ever holds
the volume.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact import convolution
from roughcontact.convolution import Responses, Symbols, Term, Workspace
from roughcontact.errors import InputError, require_pixel, require_positive

Array = NDArray[np.float64]

COMPONENTS = ("xx", "yy", "zz", "yz", "xz", "xy")
"""Order of the components of a tensor along its first axis."""

XX, YY, ZZ, YZ, XZ, XY = range(6)

# Which components a normal load makes odd, in y and in x; a traction flips one of the two.
_ODD = ((False, False),) * 3 + ((True, False), (False, True), (True, True))

# Depths per octave of an automatic list, its ends in pixels and contact radii, and how often the
# neighbourhood of the largest stress is looked at again.
_PER_OCTAVE = 3
_SHALLOWEST = 0.5
_DEEPEST = 3.0
_REFINEMENTS = 4

# In single precision a kernel is sampled at least this often over its depth: waves of two samples
# are damped to e^(-5π) = 2e-7. It needs room beyond the map where it goes over into its image: a
# quarter of the map, in which an error function is smooth to the same degree at so many samples.
_SAMPLES = 5
_COARSEST = 16
_BLEND = 1.25
_BLEND_SAMPLES = 0.1
_STEEPNESS = 3.8

# Waves on a periodic map are left out where e^(-qz) falls below rounding.
_DAMPED = {"single": 18.0, "double": 40.0}


def influence(
    shape: tuple[int, int],
    pixel: tuple[float, float],
    depth: float,
    poisson: float,
    direction: str = "z",
) -> Array:
    """Return the stress at one depth under a unit traction on the pixel ``[0, 0]``.

    Parameters
    ----------
    shape : (int, int)
        Offsets ``(ny, nx)`` wanted, from 0 on.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    depth : float
        z ≥ 0 [m].
    poisson : float
        Poisson's ratio ν of the body.
    direction : {"z", "x", "y"}
        Of the traction on the body: "z" is a pressure.

    Returns
    -------
    ndarray, shape (6, ny, nx)
        Stress over traction at the pixel centres [1]. Under a pressure yz is odd in y, xz odd in
        x, xy odd in both, the others are even; a traction along x or y flips this in that
        direction.

    Raises
    ------
    InputError
        If an argument is outside its range.

    Notes
    -----
    With V = ∫∫ 1/ρ over the loaded rectangle, χ = ∫∫ ln(ρ + z) and Ω = ∫∫ (z ln(ρ + z) - ρ), a
    unit pressure gives (Love 1929, sec. 4)::

        2π σ_xx = 2ν V_z - z V_xx - (1-2ν) χ_xx       2π σ_zz = V_z - z V_zz
        2π σ_xy = -(1-2ν) χ_xy - z V_xy               2π σ_xz = -z V_xz

    and a unit traction along x (Cerruti; Johnson 1985, eq. 3.76, integrated)::

        2π σ_xx = 2 V_x - 2ν Ω_xyy - z χ_xxx          2π σ_zz = -z V_xz
        2π σ_yy = 2ν V_x + 2ν Ω_xyy - z χ_xyy         2π σ_xz = V_z - z V_xx
        2π σ_xy = V_y + 2ν Ω_xxy - z χ_xxy            2π σ_yz = -z V_xy

    Every derivative is a signed sum over the corners of an elementary function. The functions
    here are odd in each corner coordinate as far as the sum can tell, and free of 0/0 and of
    cancelling logarithms at the surface. The limits at z = 0 are exact: σ_zz = -1 on the loaded
    pixel and 0 elsewhere. Errors are about 1e-15 of the unit traction.

    References
    ----------
    Love, Phil. Trans. R. Soc. A 228 (1929) 377, doi:10.1098/rsta.1929.0009;
    Johnson, Contact Mechanics (1985), secs. 3.2, 3.6, doi:10.1017/CBO9781139171731;
    Liu and Wang, J. Tribol. 124 (2002) 36, doi:10.1115/1.1401017

    Examples
    --------
    >>> influence((1, 1), (1.0, 1.0), depth=0.0, poisson=0.3)[:3, 0, 0].round(12)
    array([-0.8, -0.8, -1. ])
    """
    require_pixel(pixel)
    _require_depth(depth)
    _require_poisson(poisson)
    if direction not in ("x", "y", "z"):
        raise InputError(f"direction must be 'z', 'x' or 'y', got {direction!r}")
    y, x = (_edges(np.arange(n), edge) for n, edge in zip(shape, pixel, strict=True))
    if direction == "z":
        kernels = _under_pressure(x, y, depth, poisson)
    else:
        kernels = _under_traction(x, y, depth, poisson, direction)
    return np.stack([kernel.T for kernel in kernels])


def von_mises(stress: ArrayLike) -> NDArray[Any]:
    """Return the equivalent stress of von Mises, ``√(3 J₂)``.

    Parameters
    ----------
    stress : array_like, shape (6, ...)
        Stress tensors [Pa].

    Returns
    -------
    ndarray, shape (...)
        Equivalent stress [Pa]; √2/3 of it is the octahedral shear stress.

    Examples
    --------
    >>> float(von_mises([3.0, 0.0, 0.0, 0.0, 0.0, 0.0]))
    3.0
    """
    squared: NDArray[Any] = np.sqrt(_von_mises_squared(_tensor(stress)))
    return squared


def principal(stress: ArrayLike) -> Array:
    """Return the principal stresses, the largest first.

    Parameters
    ----------
    stress : array_like, shape (6, ...)
        Stress tensors [Pa].

    Returns
    -------
    ndarray, shape (3, ...)
        σ₁ ≥ σ₂ ≥ σ₃ [Pa].

    Notes
    -----
    With the deviator s, J₂ = ½ s:s and J₃ = det s, the roots are
    ``σ_m + 2 √(J₂/3) cos(φ - 2πk/3)`` with ``tan 3φ = √Δ / (√27 J₃)`` and the discriminant
    Δ = 4 J₂³ - 27 J₃². That difference loses half of the digits where two roots meet, which they
    do on every axis of symmetry. Δ is also the Gram determinant of 1, s and s², hence a sum of
    squares of their minors (Cauchy and Binet), which is what is summed here.

    Examples
    --------
    >>> principal([1.0, 1.0, -2.0, 0.0, 0.0, 0.0]).tolist()
    [1.0, 1.0, -2.0]
    """
    mean, root, angle = _lode(_tensor(stress))
    thirds = np.array([0.0, 2 * math.pi / 3, -2 * math.pi / 3])
    thirds = thirds.reshape((3,) + (1,) * angle.ndim)
    roots: Array = mean + 2 / math.sqrt(3) * root * np.cos(angle - thirds)
    return roots


def tresca(stress: ArrayLike) -> Array:
    """Return the equivalent stress of Tresca, ``σ₁ - σ₃``, twice the largest shear stress.

    Parameters
    ----------
    stress : array_like, shape (6, ...)
        Stress tensors [Pa].

    Returns
    -------
    ndarray, shape (...)
        Equivalent stress [Pa], between one and 2/√3 times that of von Mises.

    Notes
    -----
    ``2 √J₂ sin(φ + π/3)``, with φ as in `principal`.

    Examples
    --------
    >>> float(tresca([0.0, 0.0, 0.0, 0.0, 0.0, 1.0]))
    2.0
    """
    _, root, angle = _lode(_tensor(stress))
    equivalent: Array = 2 * root * np.sin(angle + math.pi / 3)
    return equivalent


def graded_depths(
    pressure: NDArray[Any], pixel: tuple[float, float], *, boundary: str = "free"
) -> Array:
    """Return depths that follow the stress from a single pixel to the whole contact.

    Parameters
    ----------
    pressure : ndarray, shape (ny, nx)
        Pressure [Pa].
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    boundary : {"free", "periodic"}
        Whether the map is all there is, or one period.

    Returns
    -------
    ndarray, shape (nz,)
        0, then a geometric series with three depths an octave, from half the shorter pixel edge,
        below which the stress only shows that pressure is constant on a pixel, to three contact
        radii [m].

    Raises
    ------
    InputError
        If the pixel is not positive, or there is no pressure.

    Notes
    -----
    The stress under a spot of radius r peaks at about r/2 (0.48 r under a Hertz contact) and
    changes by little within a third of an octave. Spots of all sizes from a pixel up may be there,
    so the series is graded alike for all. The contact radius is √5 times the larger standard
    deviation of the pressure's distribution over x and y: a under a Hertz contact, about as much
    as the loaded region measures otherwise. On a periodic map the list ends one side deep, where
    the longest wave is damped to e^(-2π).
    """
    require_pixel(pixel)
    total = float(pressure.sum())
    if not total > 0:
        raise InputError("pressure is zero everywhere: there is no stress to look at")
    reach = 0.0
    for axis, edge in enumerate(pixel):
        weights = pressure.sum(axis=1 - axis) / total
        position = np.arange(weights.size) * edge
        spread = float(weights @ (position - weights @ position) ** 2)
        reach = max(reach, _DEEPEST * math.sqrt(5 * spread))
    if boundary == "periodic":
        reach = min(reach, max(n * edge for n, edge in zip(pressure.shape, pixel, strict=True)))
    first = _SHALLOWEST * min(pixel)
    # A single loaded pixel has no spread; its stress is gone a few pixels below.
    reach = max(reach, _DEEPEST * max(pixel))
    count = math.ceil(_PER_OCTAVE * math.log2(reach / first)) + 1
    return np.concatenate([[0.0], np.geomspace(first, reach, count)])


@dataclass(frozen=True, eq=False)
class Slice:
    """The stress at one depth.

    Parameters
    ----------
    depth : float
        z [m].
    stress : ndarray, shape (6, ny, nx)
        Tensors xx, yy, zz, yz, xz, xy at the pixel centres [Pa].
    """

    depth: float
    stress: NDArray[Any]


def slices(
    pressure: ArrayLike,
    pixel: tuple[float, float],
    depths: ArrayLike,
    poisson: float,
    *,
    boundary: str = "free",
    friction: float = 0.0,
    direction: float = 0.0,
    precision: str = "single",
    workers: int | None = None,
) -> Iterator[Slice]:
    """Yield the stress depth by depth.

    Parameters
    ----------
    pressure : array_like, shape (ny, nx)
        Pressure on the surface [Pa].
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    depths : array_like, shape (nz,)
        Depths z ≥ 0 [m], in any order.
    poisson : float
        Poisson's ratio ν of the body; its other constants do not matter.
    boundary : {"free", "periodic"}
        Whether the map is all there is, or one period.
    friction : float
        Coefficient μ of the traction μ p on this body; the other body carries the opposite.
    direction : float
        Angle of that traction from x towards y [rad].
    precision : {"double", "single"}
        Arithmetic of the transforms. Single is good to about 1e-6 of the largest pressure.
    workers : int, optional
        Threads; by default one for each core that the process may use.

    Yields
    ------
    Slice
        One for each depth; the caller owns it.

    Raises
    ------
    InputError
        If an argument is outside its range.

    Notes
    -----
    Free: pressure is constant on each pixel, and the stress at the pixel centres is exact
    (`influence`). Periodic: pressure is the trigonometric polynomial through the pixel centres,
    and each of its waves p cos(qx) has its exact stress, ``σ_xx = (qz - 1) e^(-qz) p cos(qx)`` and
    so on (Johnson 1985, sec. 13.2; the normal modes for a wave vector in any direction). The mean
    pressure presses a body that cannot expand sideways: σ_xx = σ_yy = -ν/(1-ν) p̄.

    References
    ----------
    Johnson, Contact Mechanics (1985), doi:10.1017/CBO9781139171731
    """
    field = _field(
        pressure, pixel, poisson, boundary, friction, direction, precision, Workspace(workers)
    )
    for depth in _depth_list(depths).tolist():
        stress = np.empty((6, *field.shape), field.real)

        def keep(rows: slice, block: NDArray[Any], stress: NDArray[Any] = stress) -> None:
            np.multiply(block, field.unit, out=stress[:, rows], casting="same_kind")

        responses, symbols = field.at(depth)
        responses.stream(symbols, keep)
        yield Slice(depth, stress)


def sections(
    pressure: ArrayLike,
    pixel: tuple[float, float],
    depths: ArrayLike,
    poisson: float,
    point: tuple[int, int],
    *,
    boundary: str = "free",
    friction: float = 0.0,
    direction: float = 0.0,
    precision: str = "single",
    workers: int | None = None,
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the stress on the two vertical planes through a pixel.

    Parameters
    ----------
    pressure, pixel, depths, poisson, boundary, friction, direction, precision, workers
        As for `slices`.
    point : (int, int)
        Row and column of the pixel.

    Returns
    -------
    along_x : ndarray, shape (6, nz, nx)
        Tensors on the plane of the row [Pa].
    along_y : ndarray, shape (6, nz, ny)
        Tensors on the plane of the column [Pa].

    Raises
    ------
    InputError
        If an argument is outside its range.
    """
    field = _field(
        pressure, pixel, poisson, boundary, friction, direction, precision, Workspace(workers)
    )
    listed, (ny, nx) = _depth_list(depths), field.shape
    if not (0 <= point[0] < ny and 0 <= point[1] < nx):
        raise InputError(f"point must lie on the map of {ny} × {nx} pixels, got {point!r}")
    along_x = np.empty((6, listed.size, nx), field.real)
    along_y = np.empty((6, listed.size, ny), field.real)
    for number, depth in enumerate(listed.tolist()):
        responses, symbols = field.at(depth)
        row, column = responses.cross(symbols, point)
        along_x[:, number], along_y[:, number] = row * field.unit, column * field.unit
    return along_x, along_y


@dataclass(frozen=True, eq=False)
class Summary:
    """What is left of the stress in a volume when its slices have passed.

    Parameters
    ----------
    depths : ndarray, shape (nz,)
        Depths looked at [m], ascending.
    von_mises, tresca : ndarray, shape (nz,)
        Largest equivalent stress at each depth [Pa].
    pixels : ndarray of int, shape (nz, 2)
        Row and column of the largest von Mises stress at each depth.
    orthogonal_shear : ndarray, shape (nz, 2)
        Amplitude of the orthogonal shear stress at each depth [Pa], for passes along y and
        along x: half the range that σ_yz (σ_xz) runs through on the worst line in that direction,
        while the pressure passes by unchanged.
    peak : ndarray, shape (ny, nx)
        Largest von Mises stress over all depths [Pa].
    yield_strength : float or None
        σ_Y [Pa].
    yielded_area : ndarray, shape (nz,), or None
        Area where the von Mises stress exceeds σ_Y at each depth [m²].
    """

    depths: Array
    von_mises: Array
    tresca: Array
    pixels: NDArray[np.int64]
    orthogonal_shear: Array
    peak: NDArray[Any]
    yield_strength: float | None
    yielded_area: Array | None

    @property
    def max_von_mises(self) -> float:
        """Largest von Mises stress [Pa]."""
        return float(self.von_mises.max())

    @property
    def max_tresca(self) -> float:
        """Largest Tresca stress [Pa]."""
        return float(self.tresca.max())

    @property
    def max_orthogonal_shear(self) -> tuple[float, float]:
        """Largest amplitudes of the orthogonal shear stress for passes along y and x [Pa]."""
        along_y, along_x = self.orthogonal_shear.max(axis=0)
        return float(along_y), float(along_x)

    @property
    def depth_of_max(self) -> float:
        """Depth of the largest von Mises stress [m]."""
        return float(self.depths[self.von_mises.argmax()])

    @property
    def pixel_of_max(self) -> tuple[int, int]:
        """Row and column of the largest von Mises stress."""
        row, column = self.pixels[self.von_mises.argmax()]
        return int(row), int(column)

    @property
    def yield_factor(self) -> float | None:
        """Factor by which the whole pressure may grow until the first point yields.

        σ_Y over the largest von Mises stress. A contact whose area grows with the load does not
        simply scale its pressure: its load at first yield takes new solutions.
        """
        if self.yield_strength is None:
            return None
        return self.yield_strength / self.max_von_mises if self.max_von_mises > 0 else math.inf

    @property
    def yielded_volume(self) -> float | None:
        """Volume where the von Mises stress exceeds σ_Y [m³], by the trapezoidal rule in depth."""
        if self.yielded_area is None:
            return None
        return float(np.trapezoid(self.yielded_area, self.depths))


def summarise(
    pressure: ArrayLike,
    pixel: tuple[float, float],
    poisson: float,
    *,
    depths: ArrayLike | None = None,
    yield_strength: float | None = None,
    boundary: str = "free",
    friction: float = 0.0,
    direction: float = 0.0,
    precision: str = "single",
    workers: int | None = None,
) -> Summary:
    """Return the equivalent stresses of a volume, without ever holding it.

    Parameters
    ----------
    pressure, pixel, poisson, boundary, friction, direction, precision, workers
        As for `slices`.
    depths : array_like, optional
        Depths z ≥ 0 [m]; by default those of `graded_depths`, and up to four more that close in
        on the largest von Mises stress.
    yield_strength : float, optional
        σ_Y [Pa].

    Returns
    -------
    Summary
        Largest stresses, their places, and what exceeds the yield strength.

    Raises
    ------
    InputError
        If an argument is outside its range.

    Examples
    --------
    A Hertz contact of radius 20 pixels:

    >>> y, x = np.mgrid[-31.5:32, -31.5:32]
    >>> pressure = np.sqrt(np.maximum(1 - (x**2 + y**2) / 20**2, 0))
    >>> found = summarise(pressure, (1.0, 1.0), 0.3, yield_strength=1.0)
    >>> round(found.max_von_mises, 2), round(found.depth_of_max / 20, 2)
    (0.62, 0.48)
    """
    field = _field(
        pressure, pixel, poisson, boundary, friction, direction, precision, Workspace(workers)
    )
    if yield_strength is not None:
        require_positive(yield_strength=yield_strength)
    peak = np.zeros(field.shape, field.real)
    limit = None if yield_strength is None else (yield_strength / field.unit) ** 2
    if depths is None:
        listed = graded_depths(np.asarray(pressure), pixel, boundary=boundary)
    else:
        listed = _depth_list(depths)
    layers: dict[float, _Layer] = {}
    row = int(np.abs(np.asarray(pressure)).max(axis=1).argmax())
    for depth in listed.tolist():
        layers[depth] = _layer(field, depth, peak, limit, row)
        row = layers[depth].pixel[0]
    if depths is None:
        for _ in range(_REFINEMENTS):
            closer = _between(layers)
            if closer is None:
                break
            layers[closer] = _layer(field, closer, peak, limit, row)
    ordered = [layers[depth] for depth in sorted(layers)]
    np.sqrt(peak, out=peak)
    peak *= field.unit
    unit, cell = field.unit, pixel[0] * pixel[1]
    return Summary(
        depths=np.array(sorted(layers)),
        von_mises=np.array([layer.von_mises for layer in ordered]) * unit,
        tresca=np.array([layer.tresca for layer in ordered]) * unit,
        pixels=np.array([layer.pixel for layer in ordered]),
        orthogonal_shear=np.array([layer.orthogonal_shear for layer in ordered]) * unit,
        peak=peak,
        yield_strength=yield_strength,
        yielded_area=(
            None if limit is None else np.array([layer.yielded * cell for layer in ordered])
        ),
    )


@dataclass(frozen=True, eq=False)
class _Field:
    """The stress of one pressure map, in units of its largest pressure.

    ``at(depth)`` returns the operator and the kernels to stream.
    """

    unit: float
    shape: tuple[int, int]
    real: type
    at: Callable[[float], tuple[Responses, Symbols]]


@dataclass(frozen=True)
class _Layer:
    von_mises: float
    tresca: float
    pixel: tuple[int, int]
    orthogonal_shear: tuple[float, float]
    yielded: int


def _field(
    pressure: ArrayLike,
    pixel: tuple[float, float],
    poisson: float,
    boundary: str,
    friction: float,
    direction: float,
    precision: str,
    workspace: Workspace,
) -> _Field:
    require_pixel(pixel)
    _require_poisson(poisson)
    for name, value, choices in (
        ("boundary", boundary, ("free", "periodic")),
        ("precision", precision, ("double", "single")),
    ):
        if value not in choices:
            raise InputError(f"{name} must be one of {choices}, got {value!r}")
    for name, number in (("friction", friction), ("direction", direction)):
        if not math.isfinite(number):
            raise InputError(f"{name} must be finite, got {number!r}")
    source = np.asarray(pressure, dtype=np.float64)
    if source.ndim != 2 or not source.size or not np.isfinite(source).all():
        raise InputError(
            f"pressure must be a finite map [y, x], got shape {source.shape}"
            + ("" if np.isfinite(source).all() else " with NaN or infinite values")
        )
    # Tractions along x and y; a right angle has a cosine of 6e-17, which is no traction.
    pulls = [
        (axis, friction * share)
        for axis, share in (("x", math.cos(direction)), ("y", math.sin(direction)))
        if abs(friction * share) > 1e-15 * abs(friction)
    ]
    terms = [Term(number, odd) for number, odd in enumerate(_ODD)]
    for axis, _ in pulls:
        terms += [
            Term(number, (odd[0] != (axis == "y"), odd[1] != (axis == "x")))
            for number, odd in enumerate(_ODD)
        ]
    unit = float(np.abs(source).max()) or 1.0
    source = source / unit
    shape = (source.shape[0], source.shape[1])

    def responses(padded: tuple[int, int]) -> Responses:
        return Responses(source, padded, terms, workspace=workspace, precision=precision)

    def kernels(
        depth: float, rows: NDArray[np.int64], columns: NDArray[np.int64]
    ) -> Iterator[Array]:
        y, x = _edges(rows, pixel[0]), _edges(columns, pixel[1])
        yield from _under_pressure(x, y, depth, poisson)
        for axis, share in pulls:
            for kernel in _under_traction(x, y, depth, poisson, axis):
                kernel *= share
                yield kernel

    if boundary == "periodic":
        periodic = responses(shape)
        waves = partial(
            _waves, shape, pixel, damped=_DAMPED[precision], poisson=poisson, pulls=pulls, terms=terms
        )
        return _Field(unit, shape, periodic.real, lambda depth: (periodic, waves(depth)))
    near = responses(convolution.free_period(shape))
    far: list[Responses] = []

    def free(depth: float) -> tuple[Responses, Symbols]:
        every = _steps(shape, pixel, depth) if precision == "single" else (1, 1)
        if max(every) == 1:
            return near, near.sampled(partial(kernels, depth))
        if not far:
            far.append(responses(_blended_period(shape)))
        padded = far[0].padded
        sample = partial(_blended, partial(kernels, depth), terms, shape, padded)
        return far[0], far[0].sampled(sample, every)

    return _Field(unit, shape, near.real, free)


def _steps(shape: tuple[int, int], pixel: tuple[float, float], depth: float) -> tuple[int, int]:
    """Return how many pixels lie from one sample of the kernels to the next."""
    y, x = (
        min(depth / (_SAMPLES * edge), _BLEND_SAMPLES * (_BLEND - 1) * n, _COARSEST)
        for n, edge in zip(shape, pixel, strict=True)
    )
    return 2 ** int(math.log2(max(y, 1))), 2 ** int(math.log2(max(x, 1)))


def _blended_period(shape: tuple[int, int]) -> tuple[int, int]:
    """Return a period that leaves room to blend kernels, and is a multiple of all steps."""
    y, x = (math.ceil(_BLEND * n / _COARSEST) for n in shape)
    period = convolution.free_period((y, x))
    return _COARSEST * period[0], _COARSEST * period[1]


class _Image(NamedTuple):
    """Offsets at which a kernel counts, with what weight, and for which sample."""

    sample: slice
    offsets: NDArray[np.int64]
    weight: Array
    mirrored: bool


def _images(offsets: NDArray[np.int64], points: int, period: int) -> list[_Image]:
    """Return what a periodic kernel is made of that goes over smoothly into its image.

    Half-way between the last offset on the map and its image, the kernel is half itself, half
    its image. The weight is an error function, the smoothest step for its width.
    """

    def weight(distance: NDArray[np.int64]) -> Array:
        reach = (2 * distance - period) / (period - 2 * points)
        return np.array([0.5 * math.erfc(_STEEPNESS * value) for value in reach])

    images = [_Image(slice(None), offsets, weight(offsets), False)]
    late = int(np.searchsorted(offsets, points, side="right"))
    if late < offsets.size:
        beyond = period - offsets[late:]
        images.append(_Image(slice(late, None), beyond, weight(beyond), True))
    return images


def _blended(
    kernels: Callable[[NDArray[np.int64], NDArray[np.int64]], Iterator[Array]],
    terms: list[Term],
    shape: tuple[int, int],
    period: tuple[int, int],
    rows: NDArray[np.int64],
    columns: NDArray[np.int64],
) -> list[Array]:
    """Return kernels that are smooth where they meet their images, beyond the map's offsets."""
    found = [np.zeros((columns.size, rows.size)) for _ in terms]
    for y in _images(rows, shape[0], period[0]):
        for x in _images(columns, shape[1], period[1]):
            weight = np.outer(x.weight, y.weight)
            parts = kernels(y.offsets, x.offsets)
            for term, total, kernel in zip(terms, found, parts, strict=True):
                kernel *= weight
                if (term.odd[0] and y.mirrored) != (term.odd[1] and x.mirrored):
                    np.negative(kernel, out=kernel)
                total[x.sample, y.sample] += kernel
    return found


class _Edges(NamedTuple):
    """Edges of a row of pixels [m]: those between neighbours once, or both of each pixel."""

    position: Array
    shared: bool

    @property
    def sides(self) -> tuple[slice, slice]:
        """Where the lower and the upper edges lie."""
        if self.shared:
            return slice(None, -1), slice(1, None)
        return slice(None, None, 2), slice(1, None, 2)


def _edges(offsets: NDArray[np.int64], edge: float) -> _Edges:
    if offsets.size > 1 and offsets[1] == offsets[0] + 1:
        return _Edges((np.append(offsets, offsets[-1] + 1) - 0.5) * edge, True)
    return _Edges((offsets[:, None] + np.array([-0.5, 0.5])).ravel() * edge, False)


def _under_pressure(x_edges: _Edges, y_edges: _Edges, z: float, poisson: float) -> Iterator[Array]:
    """Yield the stress under unit pressure on one pixel, ``[x, y]``."""
    x, y = x_edges.position[:, None], y_edges.position
    a, b = x * x + z * z, y * y + z * z
    xy = x * y
    radius = np.sqrt(x * x + b)
    zr = z * radius
    # χ_xx and χ_yy; their sum is -V_z.
    chi_xx = np.arctan(xy / (a + zr))
    chi_yy = np.arctan(xy / (b + zr))
    ratio = xy / radius
    v_xx, v_yy = ratio * (z / a), ratio * (z / b)
    for corners in (
        v_xx - chi_xx - 2 * poisson * chi_yy,
        v_yy - chi_yy - 2 * poisson * chi_xx,
        -(chi_xx + chi_yy + v_xx + v_yy),
        v_yy * (z / y),
        v_xx * (z / x),
        -(1 - 2 * poisson) * np.log(radius + z) - z / radius,
    ):
        yield _over_pixels(corners, x_edges, y_edges)


def _under_traction(
    x_edges: _Edges, y_edges: _Edges, z: float, poisson: float, axis: str
) -> Iterator[Array]:
    """Yield the stress under a unit traction on one pixel, ``[x, y]``."""
    if axis == "y":
        swapped = [part.T for part in _under_traction(y_edges, x_edges, z, poisson, "x")]
        yield from (swapped[number] for number in (YY, XX, ZZ, XZ, YZ, XY))
        return
    x, y = x_edges.position[:, None], y_edges.position
    a, b = x * x + z * z, y * y + z * z
    xy = x * y
    radius = np.sqrt(x * x + b)
    # 2ν/(R+z) + z/(R (R+z)), the part that Ω and χ have in common.
    common = (2 * poisson + z / radius) / (radius + z)
    along = np.arcsinh(y / np.sqrt(a))
    v_xz = y / radius * (z * z / a)
    # -V_z by the two angles of `_under_pressure`, which have a limit at the surface.
    v_z = -np.arctan(xy / (a + z * radius)) - np.arctan(xy / (b + z * radius))
    for corners in (
        2 * along + y * common - v_xz,
        2 * poisson * along - y * common,
        v_xz,
        -z / radius,
        v_z + xy / radius * (z / a),
        np.arcsinh(x / np.sqrt(b)) - x * common,
    ):
        yield _over_pixels(corners, x_edges, y_edges)


def _over_pixels(corners: Array, x_edges: _Edges, y_edges: _Edges) -> Array:
    """Return 1/2π times the signed sum over the four corners of each pixel."""
    (left, right), (front, back) = x_edges.sides, y_edges.sides
    strips = corners[right] - corners[left]
    pixels = strips[:, back] - strips[:, front]
    pixels *= 1 / (2 * math.pi)
    return pixels


def _waves(
    shape: tuple[int, int],
    pixel: tuple[float, float],
    z: float,
    damped: float,
    poisson: float,
    pulls: list[tuple[str, float]],
    terms: list[Term],
) -> Symbols:
    """Return the stress of waves of pressure, up to those with q z = ``damped``."""
    (ny, nx), (dy, dx) = shape, pixel
    highest = ny // 2, nx // 2
    if z > 0:
        reach = damped / (2 * math.pi * z)
        highest = (
            min(highest[0], math.ceil(reach * ny * dy)),
            min(highest[1], math.ceil(reach * nx * dx)),
        )
    qy = 2 * math.pi / (ny * dy) * np.arange(highest[0] + 1)[:, None]

    def block(columns: slice) -> Array:
        qx = 2 * math.pi / (nx * dx) * np.arange(columns.start, columns.stop)
        symbols = np.stack(_modes(qy, qx, z, poisson, pulls))
        # The wave of two points a period has no sine.
        for term, symbol in zip(terms, symbols, strict=True):
            if term.odd[0] and 2 * highest[0] == ny:
                symbol[-1] = 0
            if term.odd[1] and 2 * (columns.stop - 1) == nx:
                symbol[:, -1] = 0
        return symbols

    return Symbols(highest, block)


def _modes(
    qy: Array, qx: Array, z: float, poisson: float, pulls: list[tuple[str, float]]
) -> list[Array]:
    """Return the stress of waves of unit pressure and tractions, less the factors of `Symbols`."""
    q = np.hypot(qy, qx)
    inverse = np.divide(1, q, out=np.zeros(q.shape), where=q > 0)
    # Direction cosines of the wave vector.
    c, s = qx * inverse, qy * inverse
    qz = q * z
    damping = np.exp(-qz)
    found = [
        c * c * (qz - 1) - 2 * poisson * s * s,
        s * s * (qz - 1) - 2 * poisson * c * c,
        -(1 + qz),
        -s * qz,
        -c * qz,
        -c * s * (qz - 1 + 2 * poisson),
    ]
    for number in (XX, YY):
        found[number][q == 0] = -poisson / (1 - poisson)
    for axis, share in pulls:
        m, n = (c, s) if axis == "x" else (s, c)
        along = -m * (2 + 2 * poisson * n * n - m * m * qz)
        across = -m * (2 * poisson * m * m - n * n * qz)
        near, far = m * m * qz - 1, -m * n * qz
        pulled = (
            (along, across, -m * qz, far, near) if axis == "x" else (across, along, -m * qz, near, far)
        )
        found += [share * part for part in (*pulled, -n * (1 - 2 * poisson * m * m - m * m * qz))]
    for part in found:
        part *= damping
    return found


def _layer(
    field: _Field, depth: float, peak: NDArray[Any], limit: float | None, row: int
) -> _Layer:
    """Look at one depth: squared von Mises stress into ``peak``, and what the layer adds.

    ``row`` is where the largest stress is thought to be.
    """
    ny, nx = field.shape
    found: list[tuple[float, int, int]] = []
    tresca_squared = [0.0]
    x_range = np.zeros(ny)
    y_ranges: list[tuple[NDArray[Any], NDArray[Any]]] = []

    def visit(rows: slice, stress: NDArray[Any]) -> None:
        squared = _von_mises_squared(stress)
        np.maximum(peak[rows], squared, out=peak[rows])
        place = int(squared.argmax())
        top = float(squared.flat[place])
        # Tresca is between one and 2/√3 times von Mises: few pixels can hold its maximum.
        least = 0.75 * max(top, max(tresca_squared))
        if top >= least:
            near = stress[:, squared >= least]
            tresca_squared.append(float(tresca(near).max()) ** 2)
        yielded = 0 if limit is None else int(np.count_nonzero(squared > limit))
        found.append((top, rows.start * nx + place, yielded))
        x_range[rows] = stress[XZ].max(axis=1) - stress[XZ].min(axis=1)
        y_ranges.append((stress[YZ].max(axis=0), stress[YZ].min(axis=0)))

    responses, symbols = field.at(depth)
    responses.stream(symbols, visit, row)
    top, place = max((entry[0], -entry[1]) for entry in found)
    high = np.max([entry[0] for entry in y_ranges], axis=0)
    low = np.min([entry[1] for entry in y_ranges], axis=0)
    return _Layer(
        von_mises=math.sqrt(top),
        tresca=math.sqrt(max(tresca_squared)),
        pixel=(-place // nx, -place % nx),
        orthogonal_shear=(float((high - low).max()) / 2, float(x_range.max()) / 2),
        yielded=sum(entry[2] for entry in found),
    )


def _between(layers: dict[float, _Layer]) -> float | None:
    """Return the depth where the largest stress should be, or nothing if it is known."""
    depths = sorted(layers)
    values = [layers[depth].von_mises for depth in depths]
    place = int(np.argmax(values))
    if place == len(depths) - 1:
        return None
    if place == 0:
        # The surface carries the largest stress, unless it peaks above the second depth.
        return 0.5 * depths[1] if depths[1] > 0 else None
    (left, middle, right) = depths[place - 1 : place + 2]
    (low, top, high) = values[place - 1 : place + 2]
    # Vertex of the parabola through the three.
    before, behind = middle - left, right - middle
    fall_before, fall_behind = (top - low) / before, (top - high) / behind
    if not fall_before + fall_behind > 0:
        return None
    vertex = middle + 0.5 * (fall_before * behind - fall_behind * before) / (
        fall_before + fall_behind
    )
    # Within half a percent of the depth the stress is flat to 1e-4.
    return vertex if abs(vertex - middle) > 5e-3 * middle else None


def _tensor(stress: ArrayLike) -> NDArray[Any]:
    array = np.asarray(stress)
    if array.dtype.kind != "f":
        array = array.astype(np.float64)
    if array.ndim < 1 or array.shape[0] != 6:
        raise InputError(
            f"stress must hold the components {', '.join(COMPONENTS)} along its first axis, "
            f"got shape {array.shape}"
        )
    return array


def _von_mises_squared(stress: NDArray[Any]) -> NDArray[Any]:
    xx, yy, zz, yz, xz, xy = stress
    squared: NDArray[Any] = np.square(yz)
    part = np.empty_like(squared)
    squared += np.square(xz, out=part)
    squared += np.square(xy, out=part)
    squared *= 6
    for one, other in ((xx, yy), (yy, zz), (zz, xx)):
        np.subtract(one, other, out=part)
        squared += np.square(part, out=part)
    squared *= 0.5
    return squared


def _lode(stress: NDArray[Any]) -> tuple[Array, Array, Array]:
    """Return the mean stress, √J₂ and the angle φ of `principal`."""
    stress = stress.astype(np.float64)
    scale = float(np.abs(stress).max(initial=0)) or 1.0
    stress /= scale
    mean = stress[:3].mean(axis=0)
    a, b, c = stress[:3] - mean
    d, e, f = stress[3:]
    second = 0.5 * (a * a + b * b + c * c) + d * d + e * e + f * f
    third = a * (b * c - d * d) - f * (f * c - d * e) + e * (f * d - b * e)
    # Entries of s and of s² less what a multiple of 1 would change: (diagonal, off-diagonal).
    squares = (a * a + e * e + f * f, b * b + d * d + f * f, c * c + d * d + e * e)
    crossed = (f * e + d * (b + c), f * d + e * (a + c), d * e + f * (a + b))
    diagonal, off = (a, b, c), (d, e, f)
    discriminant = np.zeros(second.shape)
    for i in range(3):
        j = (i + 1) % 3
        linear, quadratic = diagonal[j] - diagonal[i], squares[j] - squares[i]
        for k in range(3):
            discriminant += 2 * (linear * crossed[k] - off[k] * quadratic) ** 2
        discriminant += 12 * (off[i] * crossed[j] - off[j] * crossed[i]) ** 2 / 1
    minor = (b - a) * (squares[2] - squares[0]) - (c - a) * (squares[1] - squares[0])
    discriminant += minor**2
    angle = np.arctan2(np.sqrt(discriminant), math.sqrt(27) * third) / 3
    return mean * scale, np.sqrt(second) * scale, angle


def _depth_list(depths: ArrayLike) -> Array:
    listed = np.asarray(depths, dtype=np.float64)
    if listed.ndim != 1 or not listed.size or not (listed >= 0).all() or np.isinf(listed).any():
        raise InputError(f"depths must be a list of finite depths ≥ 0 [m], got {depths!r}")
    return listed


def _require_depth(depth: float) -> None:
    if not 0 <= depth < math.inf:
        raise InputError(f"depth must be finite and ≥ 0 [m], got {depth!r}")


def _require_poisson(poisson: float) -> None:
    if not -1 < poisson <= 0.5:
        raise InputError(f"poisson must lie in (-1, 0.5], got {poisson!r}")
