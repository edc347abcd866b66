"""Gaussian filters after ISO 16610, and resampling over the same outline.

`gaussian_lowpass`: Weights exp(-π (x² + y²)/(α λ)²)/(α λ)², α = √(ln 2/π), sampled at the pixels
and cut off at 1.5 λ, where they are 1e-14 of the central one. Below about five pixels the sampled
weights transmit more than 50 %; their width is then adjusted per axis to transmit exactly 50 %.

Edges and holes: normalized convolution, that is, the weights of the valid points are scaled to the
sum 1 (a regression of order zero). Constants pass everywhere; a tilt or a form passes unchanged
only where the whole window of ±1.5 λ is on the map. At an edge or a large hole a slope is biased
towards the mean by slope × α λ/π = 0.15 λ × slope, and at λ/2 from it by 0.002 λ × slope. Level the
map and remove its form first.

ISO 16610-61:2015; ISO 16610-21:2011 for the weighting function.

`along_axes`: ISO 16610-21:2011.
"""

from __future__ import annotations

import math

import numpy as np

from roughcontact._tools import memory
from roughcontact._tools.arrays import Array, Pixel, Shape
from roughcontact._tools.roots import brentq
from roughcontact.errors import (
    ArgumentRef,
    InputError,
    input_error,
    require_pixel,
    require_positive,
)
from roughcontact.halfspace import fft
from roughcontact.surface import grid
from roughcontact.units import format_engineering

# Width of the weighting function over the cut-off, for a transmission of 50 % at the cut-off.
ALPHA = math.sqrt(math.log(2) / math.pi)

# Truncation of the weights, in cut-offs: exp(-π (1.5/α)²) = 1e-14 of the central weight.
_REACH = 1.5

# Values per block of rows or columns in transforms: temporaries of about 20 MiB.
_BLOCK = 2**20


def gaussian_lowpass(heights: Array, pixel: Pixel, cutoff: float) -> Array:
    """Return the map after the areal Gaussian low-pass filter of ISO 16610-61."""
    require_pixel(pixel)
    heights = np.asarray(heights, dtype=np.float64)
    _check_cutoff(heights.shape, pixel, cutoff)
    return _smooth(heights, (cutoff / pixel[0], cutoff / pixel[1]))


def along_axes(heights: Array, cutoffs: tuple[float, float]) -> Array:
    """Return the map smoothed along y and along x by the Gaussian filter of ISO 16610-21."""
    for cutoff in cutoffs:
        if not (cutoff == 0 or 2 * (1 - 1e-12) <= cutoff < math.inf):
            raise input_error("cutoffs", cutoffs, "must be 0 or at least two pixels")
    return _smooth(np.asarray(heights, dtype=np.float64), cutoffs)


def gaussian_band(
    heights: Array,
    pixel: Pixel,
    s: float | None = None,
    l: float | None = None,  # noqa: E741
) -> Array:
    """Return the map with the waves between two cut-offs."""
    require_pixel(pixel)
    if s is None and l is None:
        raise InputError(
            "or l must be given: the cut-off below or above which waves are removed", argument="s"
        )
    for name, cutoff in (("s", s), ("l", l)):
        if cutoff is not None:
            _check_cutoff(heights.shape, pixel, cutoff, name)
    if s is not None and l is not None and not s < l:
        raise InputError(
            f"must be below l, got s = {format_engineering(s, 'm')} and l = "
            f"{format_engineering(l, 'm')}: no waves are left",
            argument="s",
        )
    if s is not None:
        heights = gaussian_lowpass(heights, pixel, s)
    return heights if l is None else heights - gaussian_lowpass(heights, pixel, l)


def resample(heights: Array, shape: Shape, method: str = "bandlimited") -> Array:
    """Return the map with another number of points over the same outline."""
    if method not in ("bandlimited", "spline"):
        raise input_error("method", method, "must be one of bandlimited, spline")
    heights = np.asarray(heights, dtype=np.float64)
    line = heights.shape[0] == 1
    new = _checked_shape(shape, line)
    grid.require_complete(heights)
    if method == "spline" and min(heights.shape[line:]) < 4:
        raise InputError(
            f"a spline needs at least 4 × 4 points, got {heights.shape[0]} × {heights.shape[1]}; "
            f"use {ArgumentRef('method', 'bandlimited')}"
        )
    grid.require_memory(max(heights.shape, new, key=math.prod), grid.RESAMPLED_ARRAYS)
    values = heights.copy()
    # The axis that shrinks most comes first, for the smallest intermediate array.
    axes = sorted((0, 1), key=lambda axis: new[axis] / heights.shape[axis])
    for axis in axes:
        if new[axis] != values.shape[axis]:
            change = _change_waves if method == "bandlimited" else _change_spline
            values = change(values, new[axis], axis)
    return values


def _checked_shape(shape: Shape, line: bool) -> tuple[int, int]:
    pair = tuple(shape) if np.iterable(shape) else ()
    whole = all(
        isinstance(points, (int, np.integer)) and not isinstance(points, bool) for points in pair
    )
    if len(pair) != 2 or not whole or min(pair[line:]) < 2 or (line and pair[0] != 1):
        raise input_error(
            "shape",
            shape,
            f"must be two integers (ny, nx) {'of a profile (1, nx)' if line else 'of at least 2'}",
        )
    memory.require_grid("shape", pair)
    return int(pair[0]), int(pair[1])


def _smooth(heights: Array, cutoffs: tuple[float, float]) -> Array:
    """Return the normalized convolution along both axes; cut-offs in pixels, 0 for none."""
    kernels = {
        axis: _weights(heights.shape[axis], cutoff)
        for axis, cutoff in enumerate(cutoffs)
        if cutoff and heights.shape[axis] > 1
    }
    there = np.isfinite(heights)
    full = bool(there.all())
    # A large offset would cost digits; the filter is invariant to a constant.
    offset = float(np.mean(heights if full else heights[there]))
    values = heights - offset
    if full:
        for axis, kernel in kernels.items():
            total = _convolve(np.ones((1, values.shape[axis])), kernel, 1)[0]
            values = _convolve(values, kernel, axis)
            values /= total[:, None] if axis == 0 else total
        return values + offset
    values[~there] = 0
    total = there.astype(np.float64)
    for axis, kernel in kernels.items():
        values = _convolve(values, kernel, axis)
        total = _convolve(total, kernel, axis)
    smooth = np.full(heights.shape, np.nan)
    # A valid point has at least its own weight, so the division is safe.
    np.divide(values, total, out=smooth, where=there)
    smooth += offset
    return smooth


def _check_cutoff(
    shape: tuple[int, ...], pixel: Pixel, cutoff: float, name: str = "cutoff"
) -> None:
    require_positive(**{name: cutoff})
    shortest = 2 * max(edge for length, edge in zip(shape, pixel, strict=True) if length > 1)
    longest = min(length * edge for length, edge in zip(shape, pixel, strict=True) if length > 1)
    # The tolerance accepts rounding of a cut-off of two pixels or of the whole side.
    if not shortest * (1 - 1e-12) <= cutoff <= longest * (1 + 1e-12):
        raise InputError(
            "must be between two pixels and the shorter side of the map, "
            f"{format_engineering(shortest, 'm')} to {format_engineering(longest, 'm')}, got "
            f"{format_engineering(cutoff, 'm')}",
            argument=name,
            value=cutoff,
        )


def _weights(length: int, cutoff: float) -> Array:
    """Return the weights at 0, 1, … pixels from the center; the cut-off is in pixels."""
    distance = np.arange(min(length, math.ceil(_REACH * cutoff) + 1), dtype=np.float64)
    # Above 8, aliasing of the spectrum changes the transmission at the cut-off by 2^-(cutoff - 1)²
    # only.
    width = ALPHA * cutoff if cutoff > 8 else _matched_width(cutoff)
    weights: Array = np.exp(-math.pi * np.square(distance / width))
    weights /= 2 * weights.sum() - 1
    return weights


def _matched_width(cutoff: float) -> float:
    distance = np.arange(1.0, 40.0)
    wave = np.cos(2 * math.pi * distance / cutoff)

    def excess(width: float) -> float:
        weights = np.exp(-math.pi * np.square(distance / width))
        return float((1 + 2 * weights @ wave) / (1 + 2 * weights.sum()) - 0.5)

    return float(brentq(excess, 0.5 * ALPHA * cutoff, 2 * ALPHA * cutoff, xtol=1e-14))


def _convolve(values: Array, weights: Array, axis: int) -> Array:
    """Return the convolution with symmetric weights along an axis, zero beyond the edge."""
    length, reach = values.shape[axis], weights.size - 1
    points = fft.fast_length(length + reach)
    circle = np.zeros(points)
    circle[: reach + 1] = weights
    circle[points - reach :] = weights[:0:-1]
    # The weights are even, so their spectrum is real.
    spectrum = fft.rfft(circle).real
    if axis == 0:
        spectrum = spectrum[:, None]
    result = np.empty_like(values)
    for part in _parts(values.shape, axis, points):
        transformed = fft.rfft(values[part], points, axis)
        transformed *= spectrum
        part_of_map = (slice(length), slice(None)) if axis == 0 else (slice(None), slice(length))
        result[part] = fft.irfft(transformed, points, axis)[part_of_map]
    return result


def _parts(shape: tuple[int, ...], axis: int, points: int) -> list[tuple[slice, slice]]:
    other = shape[1 - axis]
    step = max(1, _BLOCK // points)
    slices = [slice(start, min(start + step, other)) for start in range(0, other, step)]
    return [(slice(None), part) if axis == 0 else (part, slice(None)) for part in slices]


def _change_waves(values: Array, points: int, axis: int) -> Array:
    old = values.shape[axis]
    spectrum = np.moveaxis(fft.rfft(values, axis=axis, norm="forward"), axis, -1)
    waves = min(old, points) // 2 + 1
    # Offset of the center of the first new pixel from that of the first old one, in old pixels.
    shift = 0.5 * (old / points - 1)
    factor = np.exp(2j * math.pi * shift / old * np.arange(waves))
    if min(old, points) % 2 == 0:
        # The wave of two pixels has one coefficient for both signs on the coarser grid, and one for
        # each sign on the finer.
        factor[-1] *= 0.5 if old < points else 2.0
    changed = fft.irfft(spectrum[..., :waves] * factor, points, norm="forward")
    return np.ascontiguousarray(np.moveaxis(changed, -1, axis))


def _change_spline(values: Array, points: int, axis: int) -> Array:
    from scipy.interpolate import make_interp_spline

    old = values.shape[axis]
    centres = (np.arange(points) + 0.5) * (old / points) - 0.5
    spline = make_interp_spline(np.arange(old, dtype=np.float64), values, k=3, axis=axis)
    return np.ascontiguousarray(spline(centres))
