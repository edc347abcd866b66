"""The stress field below one map of pressure: which kernels to sample at which depth.

A depth is computed on its own: kernels are sampled, transformed and multiplied with the one
spectrum of the pressure, six for a pressure, twelve with friction in any direction. Free boundary:
closed forms of a loaded pixel, or, where the kernels are smooth, those of forces on coarser points.
Periodic boundary: waves.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact.errors import InputError, require_choice, require_pixel
from roughcontact.halfspace import stress_kernels
from roughcontact.halfspace.boundary import Boundary
from roughcontact.halfspace.fft import Workspace, free_period
from roughcontact.halfspace.responses import Responses, Symbols, Term

Array = NDArray[np.float64]
Offsets = NDArray[np.int64]

# Which components a normal load makes odd, in y and in x; a traction flips one of the two.
_ODD = ((False, False),) * 3 + ((True, False), (False, True), (True, True))
# In single precision a kernel is sampled at least this often over its depth: waves of two samples
# are damped to e^(-5π) = 2e-7. It needs room beyond the map where it goes over into its image: a
# quarter of the map, in which an error function is smooth to the same degree at so many samples.
_SAMPLES = 5
_COARSEST = 16
_BLEND = 1.25
_BLEND_SAMPLES = 0.1
_STEEPNESS = 3.8
# Pixels of a profile over its length: stress differs from plane strain by the inverse of it.
_LONG = 1e6
# Waves on a periodic map are left out where e^(-qz) falls below rounding.
_DAMPED = {"single": 18.0, "double": 40.0}


@dataclass(frozen=True, eq=False)
class Field:
    """The stress of one pressure map, in units of its largest pressure.

    ``at(depth)`` returns the operator and the kernels to stream.
    """

    unit: float
    shape: tuple[int, int]
    real: type
    at: Callable[[float], tuple[Responses, Symbols]]


def field_of(
    pressure: ArrayLike,
    pixel: tuple[float, float],
    poisson: float,
    boundary: str,
    friction: float,
    direction: float,
    precision: str,
    workspace: Workspace,
) -> Field:
    """Return the stress field below a pressure; arguments as for `stress.slices`.

    A single row that is periodic along y is a profile: its pixels are made so long that what lies
    beyond their ends is not felt, which is plane strain.
    """
    require_pixel(pixel)
    stress_kernels.require_poisson(poisson)
    source = _checked_source(pressure)
    boundary = Boundary(boundary)
    if source.shape[0] == 1 and boundary is Boundary.PERIODIC_Y:
        boundary, pixel = Boundary.FREE, (_LONG * source.shape[1] * pixel[1], pixel[1])
    boundary.require_stress()
    require_choice(("double", "single"), precision=precision)
    pulls = pulls_of(friction, direction)
    unit = float(np.abs(source).max()) or 1.0
    source = source / unit
    shape = (source.shape[0], source.shape[1])
    loads = _Loads(pixel, poisson, tuple(pulls))
    terms = loads.wave_terms() if not boundary.free_axes else loads.terms()

    def responses(padded: tuple[int, int]) -> Responses:
        return Responses(source, padded, terms, workspace=workspace, precision=precision)

    if not boundary.free_axes:
        period = responses(shape)
        damped = _DAMPED[precision]
        return Field(
            unit,
            shape,
            period.real,
            lambda depth: (period, _waves(loads, terms, shape, depth, damped)),
        )
    near = responses(free_period(shape))
    far: list[Responses] = []

    def free(depth: float) -> tuple[Responses, Symbols]:
        every = steps(shape, pixel, depth) if precision == "single" else (1, 1)
        if max(every) == 1:
            return near, near.sampled(partial(loads.on_pixels, depth))
        if not far:
            far.append(responses(_blended_period(shape)))
        sample = partial(blended, partial(loads.on_points, depth), terms, shape, far[0].padded)
        return far[0], _spread(far[0].sampled(sample, every), pixel, far[0].padded)

    return Field(unit, shape, near.real, free)


def _checked_source(pressure: ArrayLike) -> Array:
    source = np.asarray(pressure, dtype=np.float64)
    finite = np.isfinite(source).all()
    if source.ndim != 2 or not source.size or not finite:
        raise InputError(
            f"must be a finite map [y, x], got shape {source.shape}"
            f"{'' if finite else ' with NaN or infinite values'}",
            argument="pressure",
        )
    return source


def pulls_of(friction: float, direction: float) -> list[tuple[str, float]]:
    """Return the tractions along x and y per pressure, those that are none left out.

    Parameters
    ----------
    friction, direction : float
        As for `stress.slices`.

    Raises
    ------
    InputError
        If one of them is not finite.
    """
    for name, number in (("friction", friction), ("direction", direction)):
        if not math.isfinite(number):
            raise InputError(f"must be finite, got {number!r}", argument=name, value=number)
    # A right angle has a cosine of 6e-17, which is no traction.
    return [
        (axis, friction * share)
        for axis, share in (("x", math.cos(direction)), ("y", math.sin(direction)))
        if abs(friction * share) > 1e-15 * abs(friction)
    ]


@dataclass(frozen=True)
class _Loads:
    """A unit pressure and the tractions it brings along; arrays of offsets are in pixels."""

    pixel: tuple[float, float]
    poisson: float
    pulls: tuple[tuple[str, float], ...]

    def terms(self) -> list[Term]:
        """Return the kernels that `on_pixels` and `on_points` yield."""
        if not self.pulls:
            return [Term(odd, [(number, 1.0)]) for number, odd in enumerate(_ODD)]
        shares = stress_kernels.shares_of_parts(self.poisson, 1.0, self.pulls)
        return [Term(*term) for term in zip(stress_kernels.PARTS_ODD, shares, strict=True)]

    def wave_terms(self) -> list[Term]:
        """Return those of `stress_kernels.waves`: of a pressure, then of each traction."""
        flips = [(False, False), *((axis == "y", axis == "x") for axis, _ in self.pulls)]
        return [
            Term((odd[0] != flip[0], odd[1] != flip[1]), [(number, 1.0)])
            for flip in flips
            for number, odd in enumerate(_ODD)
        ]

    def on_pixels(self, z: float, rows: Offsets, columns: Offsets) -> Iterator[Array]:
        """Yield kernels of the stress under loads spread over the pixel at the origin."""
        y: Array = (np.append(rows, rows[-1] + 1) - 0.5) * self.pixel[0]
        x: Array = (np.append(columns, columns[-1] + 1) - 0.5) * self.pixel[1]
        kernels = stress_kernels.uniform_parts if self.pulls else stress_kernels.uniform_pressure
        return kernels(x, y, z, self.poisson)

    def on_points(self, z: float, rows: Offsets, columns: Offsets) -> Iterator[Array]:
        """Yield kernels of the stress under unit forces at the origin."""
        y = rows.astype(np.float64) * self.pixel[0]
        x = columns.astype(np.float64) * self.pixel[1]
        kernels = stress_kernels.force_parts if self.pulls else stress_kernels.normal_force
        return kernels(x, y, z, self.poisson)


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


def steps(shape: tuple[int, int], pixel: tuple[float, float], depth: float) -> tuple[int, int]:
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


def blended(
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
