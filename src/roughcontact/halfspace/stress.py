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
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact.errors import InputError, require_pixel, require_positive
from roughcontact.halfspace import stress_kernels
from roughcontact.halfspace.fft import Workspace, free_period
from roughcontact.halfspace.responses import Responses, Symbols, Term
from roughcontact.halfspace.tensors import XZ, YZ, tresca, von_mises_squared

Array = NDArray[np.float64]
Offsets = NDArray[np.int64]

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
        raise InputError("is zero everywhere: there is no stress to look at", argument="pressure")
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
    """Return the stress depth by depth.

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

    Returns
    -------
    iterator of Slice
        One for each depth, computed when it is asked for; the caller owns it.

    Raises
    ------
    InputError
        If an argument is outside its range.

    Notes
    -----
    Free: pressure is constant on each pixel, and the stress at the pixel centres is exact
    (`influence.coefficients`). In single precision, kernels that are smooth at their depth are
    sampled at fewer points, which keeps the stress within 1e-6 of the largest pressure.

    Periodic: pressure is the trigonometric polynomial through the pixel centres, and each of its
    waves has its exact stress (`influence.waves`). The mean pressure presses on a body that
    cannot expand sideways: σ_xx = σ_yy = -ν/(1-ν) p̄.
    """
    field = _field(
        pressure, pixel, poisson, boundary, friction, direction, precision, Workspace(workers)
    )
    return (_slice(field, depth) for depth in _depth_list(depths).tolist())


def _slice(field: _Field, depth: float) -> Slice:
    stress: NDArray[Any] = np.empty((6, *field.shape), field.real)

    def keep(rows: slice, block: NDArray[Any]) -> None:
        np.multiply(block, field.unit, out=stress[:, rows], casting="same_kind")

    responses, symbols = field.at(depth)
    responses.stream(symbols, keep)
    return Slice(depth, stress)


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
        raise InputError(
            f"must lie on the map of {ny} × {nx} pixels, got {point!r}",
            argument="point",
            value=point,
        )
    along_x: NDArray[Any] = np.empty((6, listed.size, nx), field.real)
    along_y: NDArray[Any] = np.empty((6, listed.size, ny), field.real)
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
        means = 0.5 * (self.yielded_area[1:] + self.yielded_area[:-1])
        return float((means * np.diff(self.depths)).sum())


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
    peak: NDArray[Any] = np.zeros(field.shape, field.real)
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
    stress_kernels.require_poisson(poisson)
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
    loads = _Loads(pixel, poisson, tuple(pulls))

    def responses(padded: tuple[int, int]) -> Responses:
        return Responses(source, padded, terms, workspace=workspace, precision=precision)

    if boundary == "periodic":
        period = responses(shape)
        damped = _DAMPED[precision]
        return _Field(
            unit,
            shape,
            period.real,
            lambda depth: (period, _waves(loads, terms, shape, depth, damped)),
        )
    near = responses(free_period(shape))
    far: list[Responses] = []

    def free(depth: float) -> tuple[Responses, Symbols]:
        every = _steps(shape, pixel, depth) if precision == "single" else (1, 1)
        if max(every) == 1:
            return near, near.sampled(partial(loads.on_pixels, depth))
        if not far:
            far.append(responses(_blended_period(shape)))
        sample = partial(_blended, partial(loads.on_points, depth), terms, shape, far[0].padded)
        return far[0], _spread(far[0].sampled(sample, every), pixel, far[0].padded)

    return _Field(unit, shape, near.real, free)


@dataclass(frozen=True)
class _Loads:
    """A unit pressure and the tractions it brings along; arrays of offsets are in pixels."""

    pixel: tuple[float, float]
    poisson: float
    pulls: tuple[tuple[str, float], ...]

    def on_pixels(self, z: float, rows: Offsets, columns: Offsets) -> Iterator[Array]:
        """Yield the stress under loads spread over the pixel at the origin."""
        y: Array = (np.append(rows, rows[-1] + 1) - 0.5) * self.pixel[0]
        x: Array = (np.append(columns, columns[-1] + 1) - 0.5) * self.pixel[1]
        yield from stress_kernels.uniform_pressure(x, y, z, self.poisson)
        for axis, share in self.pulls:
            for part in stress_kernels.uniform_traction(x, y, z, self.poisson, axis):
                yield share * part

    def on_points(self, z: float, rows: Offsets, columns: Offsets) -> Iterator[Array]:
        """Yield the stress under unit forces at the origin."""
        y = rows.astype(np.float64) * self.pixel[0]
        x = columns.astype(np.float64) * self.pixel[1]
        yield from stress_kernels.normal_force(x, y, z, self.poisson)
        for axis, share in self.pulls:
            for part in stress_kernels.tangential_force(x, y, z, self.poisson, axis):
                yield share * part


def _spread(symbols: Symbols, pixel: tuple[float, float], period: tuple[int, int]) -> Symbols:
    """Return the kernels of forces spread over pixels: the transform of a rectangle is exact."""
    wave_y, wave_x = (
        edge * np.sinc(np.arange(highest + 1) / length)
        for edge, highest, length in zip(pixel, symbols.highest, period, strict=True)
    )

    def block(columns: slice) -> NDArray[Any]:
        found = symbols.block(columns)
        found *= np.outer(wave_y, wave_x[columns]).astype(found.dtype)
        return found

    return Symbols(symbols.highest, block)


def _steps(shape: tuple[int, int], pixel: tuple[float, float], depth: float) -> tuple[int, int]:
    """Return how many pixels lie from one sample of the kernels to the next, at most."""
    y, x = (
        min(depth / (_SAMPLES * edge), _BLEND_SAMPLES * (_BLEND - 1) * n, _COARSEST)
        for n, edge in zip(shape, pixel, strict=True)
    )
    if min(y, x) < 1:
        return 1, 1
    return 2 ** int(math.log2(y)), 2 ** int(math.log2(x))


def _blended_period(shape: tuple[int, int]) -> tuple[int, int]:
    """Return a period that leaves room to blend kernels, and is a multiple of all steps."""
    y, x = (math.ceil(_BLEND * n / _COARSEST) for n in shape)
    period = free_period((y, x))
    return _COARSEST * period[0], _COARSEST * period[1]


class _Image(NamedTuple):
    """Offsets at which a kernel counts, with what weight, and for which sample."""

    sample: slice
    offsets: Offsets
    weight: Array
    mirrored: bool


def _images(offsets: Offsets, points: int, period: int) -> list[_Image]:
    """Return what a periodic kernel is made of that goes over smoothly into its image.

    Half-way between the last offset on the map and its image, the kernel is half itself, half
    its image. The weight is an error function, the smoothest step for its width.
    """

    def weight(distance: Offsets) -> Array:
        reach = (2 * distance - period) / (period - 2 * points)
        return np.array([0.5 * math.erfc(_STEEPNESS * value) for value in reach])

    images = [_Image(slice(None), offsets, weight(offsets), False)]
    late = int(np.searchsorted(offsets, points, side="right"))
    if late < offsets.size:
        beyond = period - offsets[late:]
        images.append(_Image(slice(late, None), beyond, weight(beyond), True))
    return images


def _blended(
    kernels: Callable[[Offsets, Offsets], Iterator[Array]],
    terms: list[Term],
    shape: tuple[int, int],
    period: tuple[int, int],
    rows: Offsets,
    columns: Offsets,
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


def _waves(
    loads: _Loads, terms: list[Term], shape: tuple[int, int], z: float, damped: float
) -> Symbols:
    """Return the stress of waves of pressure, up to those with q z = ``damped``."""
    (ny, nx), (dy, dx) = shape, loads.pixel
    highest = ny // 2, nx // 2
    if z > 0:
        reach = damped / (2 * math.pi * z)
        highest = (
            math.ceil(min(highest[0], reach * ny * dy)),
            math.ceil(min(highest[1], reach * nx * dx)),
        )
    qy = 2 * math.pi / (ny * dy) * np.arange(highest[0] + 1, dtype=np.float64)[:, None]

    def block(columns: slice) -> Array:
        qx: Array = 2 * math.pi / (nx * dx) * np.arange(columns.start, columns.stop)
        symbols = np.stack(stress_kernels.waves(qy, qx, z, loads.poisson, loads.pulls))
        # The wave of two points a period has no sine. Along x the transform of a real map knows.
        if 2 * highest[0] == ny:
            for term, symbol in zip(terms, symbols, strict=True):
                symbol[-1] *= not term.odd[0]
        return symbols

    return Symbols(highest, block)


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
        squared = von_mises_squared(stress)
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
    if place in (0, len(depths) - 1):
        return None
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


def _depth_list(depths: ArrayLike) -> Array:
    listed = np.asarray(depths, dtype=np.float64)
    if listed.ndim != 1 or not listed.size or not (listed >= 0).all() or np.isinf(listed).any():
        raise InputError(
            f"must be a list of finite depths ≥ 0 [m], got {depths!r}",
            argument="depths",
            value=depths,
        )
    return listed
