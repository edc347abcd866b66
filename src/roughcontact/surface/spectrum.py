"""Autocorrelation, texture, lay and power spectrum of a map.

`autocorrelation`: f(t) = ⟨z(r) z(r + t)⟩ / ⟨z²⟩, with z the height above the mean and the upper
average over the pairs of valid points. The map is not continued beyond its edges, and holes need no
filling. In the corners of the map of lags, lags beyond half the sides have less than a quarter of
the pairs: they show chance rather than texture. The transforms need about nine times the memory of
the map.

ISO 25178-2:2021, section 3 (autocorrelation function)

`texture`: ``Sal = min |t|`` over the lags with f(t) ≤ s; ``Str = Sal / max |t|``
over the lags connected to zero lag by a straight line on which f ≥ s. Both follow from the first
crossing of s on the rays from zero lag to every lag on the border of `autocorrelation`, with linear
interpolation. Lengths of about one pixel are therefore determined by the pixel, not by the surface.

ISO 25178-2:2021, section 4.3; the default threshold of 0.2 is from ISO 25178-3.

`lay_direction`: The map has a Hann window, so that edges cause no waves along the axes. The
standard takes the direction of the largest value of the angular spectrum, and leaves its estimation
open. On small maps few long waves decide it by chance. Here each ring of wave numbers has a free
power ``a``, and all rings the same profile over the angle φ from the direction across the lay,
``g = (cos² φ + sin² φ / s²)^(-3/2)``, that of an isotropic surface stretched by ``1/s``. The lay is
that of the largest likelihood ``-Σ (ln a g + |h̃|² / a g)`` over direction and ``s`` (Whittle), with
``a`` the mean of ``|h̃|² / g`` over the ring: every wave counts equally. For grooves (the smallest
``s``), and where another direction has four times the power, such as one of two crossed sets of
grooves, it is that of the largest value of the angular spectrum, the sum of ``|q h̃(q)|²``, averaged
over the waves within 20 degrees. Self-affine maps of 64 × 64 points with lays at 0, 30, 60 and 120
degrees are right to 0.5° for Str 0.1 and to 0.8° (rms) for Str 0.3, of 128 × 128 points to 0.5° and
0.4°, if waves down to a few pixels are above the noise; maps with few waves determine no more.

ISO 25178-2:2021, section 4.3 (texture direction Std); Whittle 1953, Ark. Mat. 2, 423

`radial_spectrum`: ``C(q) = |h̃(q)|² / (Lx Ly)`` with h̃(q) = Δx Δy Σ z exp(-i q·r) and z the height
above the mean. Shell k contains the wave vectors with ``(k - ½) δ ≤ |q| < (k + ½) δ``, δ =
2π/min(Lx, Ly), without q = 0; empty shells do not occur. Hence Sq² = Σ C·waves / (Lx Ly) holds to
rounding; the integral over the plane is Sq² = ∫ C q dq / 2π.

Shells beyond π/max(Δx, Δy) are cut off by the corners of the grid; ``waves`` shows it.

No window is applied: a periodic map is represented exactly. Any other map has a step between its
opposite edges, which adds to C at large q; level it, and do not rely on slopes of log C against log
q below -3 at the fine end.

Jacobs, Junge & Pastewka 2017, doi:10.1088/2051-672X/aa51f8
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array, Pixel
from roughcontact.errors import input_error, require_pixel
from roughcontact.halfspace import fft
from roughcontact.surface import grid
from roughcontact.surface.roughness import mean_and_count, rms_height

# Minimum share of points that have a partner at a lag; a smaller share is not significant.
_MIN_OVERLAP = 0.05


def autocorrelation(heights: Array) -> Array:
    """Return the autocorrelation function of a map, f_ACF, for lags up to half its sides."""
    ny, nx = heights.shape
    grid.require_memory((ny, nx), grid.CORRELATED_ARRAYS, "the autocorrelation of a map")
    half_y, half_x = ny // 2, nx // 2
    mean, count = mean_and_count(heights)
    Sq = rms_height(heights)
    if Sq == 0 or np.nanmax(heights) == np.nanmin(heights):
        return np.full((2 * half_y + 1, half_x + 1), math.nan)
    scratch = np.zeros((fft.fast_length(ny + half_y), fft.fast_length(nx + half_x)))
    for rows in grid.row_blocks(heights.shape):
        z = (heights[rows] - mean) / Sq
        z[np.isnan(z)] = 0.0
        scratch[rows, :nx] = z
    function = _sums_over_pairs(scratch, half_y, half_x)
    if count == heights.size:
        pairs = np.outer(
            ny - np.abs(np.arange(-half_y, half_y + 1.0)), nx - np.arange(half_x + 1.0)
        )
    else:
        for rows in grid.row_blocks(heights.shape):
            scratch[rows, :nx] = ~np.isnan(heights[rows])
        pairs = np.rint(_sums_over_pairs(scratch, half_y, half_x))
    pairs[pairs < max(_MIN_OVERLAP * count, 1)] = math.nan
    function /= pairs
    return function


def texture(heights: Array, pixel: Pixel, threshold: float = 0.2) -> tuple[float, float, float]:
    """Return autocorrelation length, texture aspect ratio and its upper bound."""
    require_pixel(pixel)
    if not 0 < threshold < 1:
        raise input_error("threshold", threshold, "must be between 0 and 1")
    function = autocorrelation(heights)
    if np.isnan(function[function.shape[0] // 2, 0]):
        return math.nan, math.nan, math.nan
    lengths, reached = _crossings(function, pixel, threshold)
    fastest, slowest = float(lengths.min()), float(lengths.max())
    if not math.isfinite(fastest):
        return math.nan, math.nan, math.nan
    determined = math.isfinite(slowest)
    largest = fastest / max(float(reached.max()), fastest)
    return fastest, fastest / slowest if determined else math.nan, largest


# Bins of the angle of a half turn; shells of one fundamental wave, beyond `_LINEAR` in proportion.
_ANGLES, _LINEAR = 360, 32
# Smoothing of the angular spectrum, range around its largest value [degrees], repeated averages.
_SMOOTH, _AROUND, _REPETITIONS = 8, 20, 8
# Power of shells that are evaluated: over the median of the shortest waves, and, times q², over the
# largest one, below which the window shows; least power of the lay over that of any direction.
_ABOVE_NOISE, _ABOVE_WINDOW, _SHARE = 6.0, 1e-3, 0.25
# Floor of the profile, for holes and another set of grooves; ratios s, the first of grooves.
_FLOOR, _RATIOS = 1e-3, (0.025, 0.05, 0.08, 0.12, 0.18, 0.27, 0.4, 0.55, 0.7, 0.85)


def lay_direction(heights: Array, pixel: Pixel) -> float:
    """Return the direction of the lay [degrees], counter-clockwise from x, row 0 on top; Std."""
    require_pixel(pixel)
    if min(heights.shape) < _SMOOTH or not rms_height(heights) > 0:
        return math.nan
    power, waves, square = _angular_shells(heights, pixel)
    if not power.size:
        return math.nan
    wave, ratio = _likeliest_wave(power, waves)
    angular = (square @ power).reshape(180, -1).sum(axis=1)
    smooth = sum(np.roll(angular, shift) for shift in range(-_SMOOTH, _SMOOTH + 1))
    if ratio == _RATIOS[0] or smooth[int(wave)] < _SHARE * np.max(smooth):
        wave = float(np.argmax(smooth)) + 0.5
        for _ in range(_REPETITIONS):
            offset = (np.arange(180) + 0.5 - wave + 90) % 180 - 90
            around = np.where(np.abs(offset) <= _AROUND, angular, 0.0)
            wave += float(np.sum(around * offset) / np.sum(around))
    return (wave + 90) % 180


def _angular_shells(heights: Array, pixel: Pixel) -> tuple[Array, Array, Array]:
    """Return power and number of waves of each shell above the noise by angle, and its q²."""
    (ny, nx), (dy, dx) = heights.shape, pixel
    window = np.outer(np.hanning(ny + 2)[1:-1], np.hanning(nx + 2)[1:-1])
    window[np.isnan(heights)] = 0.0
    z = np.where(window > 0, heights, 0.0)
    z = (z - float(np.sum(window * z) / np.sum(window))) * window
    spectrum = fft.rfft2(z)
    raw = np.square(spectrum.real) + np.square(spectrum.imag)
    qy, qx = fft.frequencies(ny, dy)[:, None], fft.half_frequencies(nx, dx)[None]
    square = np.square(qy) + np.square(qx)
    limit = 0.25 / max(dy, dx) ** 2
    noise = float(np.median(raw[(square > 0.5 * limit) & (square <= limit)]))
    # Same waves in every direction: within the circle of Nyquist, beyond the widest of the window.
    inside = (square <= limit) & ~((np.abs(qy) * ny * dy < 1.5) & (qx * nx * dx < 1.5))
    angle = np.arctan2(-qy, np.broadcast_to(qx, square.shape))[inside] % np.pi
    number = np.sqrt(square[inside]) * min(ny * dy, nx * dx)
    shell = np.where(number < _LINEAR, number, _LINEAR * (1 + np.log(number / _LINEAR)))
    place = (shell + 0.5).astype(np.int64) * _ANGLES
    place += (angle * (_ANGLES / np.pi)).astype(np.int64) % _ANGLES
    weight = np.broadcast_to(_both_signs(nx), square.shape)[inside]
    shape = int(shell.max() + 0.5) + 1, _ANGLES
    waves, power, squares = (
        np.bincount(place, weight * value, minlength=math.prod(shape)).reshape(shape)
        for value in (1.0, raw[inside], square[inside])
    )
    total = np.maximum(waves.sum(axis=1), 1.0)
    mean, squared = power.sum(axis=1) / total, squares.sum(axis=1) / total
    kept = (mean > _ABOVE_NOISE * noise) & (mean * squared > _ABOVE_WINDOW * (mean * squared).max())
    return power[kept], waves[kept], squared[kept]


def _likeliest_wave(power: Array, waves: Array) -> tuple[float, float]:
    """Return direction of the waves [degrees] and ratio of the largest likelihood."""
    turn = np.arange(_ANGLES)
    angle, turned = (turn + 0.5) * (np.pi / _ANGLES), (turn[:, None] - turn) % _ANGLES
    total = waves.sum(axis=1)
    best, found = math.inf, (0.0, 1.0)
    for ratio in _RATIOS:
        profile = _FLOOR + (np.cos(angle) ** 2 + np.sin(angle) ** 2 / ratio**2) ** -1.5
        rings = np.log(power @ (1 / profile)[turned] / total[:, None])
        cost = total @ rings + waves.sum(axis=0) @ np.log(profile)[turned]
        if cost.min() < best:
            best, found = float(cost.min()), (float(np.argmin(cost)) * 180 / _ANGLES, ratio)
    return found


def radial_spectrum(heights: Array, pixel: Pixel) -> tuple[Array, Array, Array]:
    """Return the radially averaged power spectral density of a map."""
    require_pixel(pixel)
    grid.require_complete(heights)
    (ny, nx), (dy, dx) = heights.shape, pixel
    spectrum = fft.rfft2(heights - mean_and_count(heights)[0])
    qy = 2 * np.pi * fft.frequencies(ny, dy)
    qx = 2 * np.pi * fft.half_frequencies(nx, dx)
    delta = 2 * np.pi / min(ny * dy, nx * dx)
    weight = _both_signs(nx)
    # Weight, weight times |q| and weight times power of each shell.
    sums = np.zeros((3, int(math.hypot(np.abs(qy).max(), qx.max()) / delta + 0.5) + 1))
    for rows in grid.row_blocks(spectrum.shape):
        q = np.hypot(qy[rows, None], qx)
        shell = (q / delta + 0.5).astype(np.int64).ravel()
        weights = np.broadcast_to(weight, q.shape).copy()
        if rows.start == 0:
            weights[0, 0] = 0.0
        power = np.square(spectrum[rows].real) + np.square(spectrum[rows].imag)
        for total, values in zip(sums, (weights, weights * q, weights * power), strict=True):
            total += np.bincount(shell, values.ravel(), minlength=len(total))
    waves, wave_number, power = sums[:, sums[0] > 0]
    return wave_number / waves, power / waves * (dx * dy / (nx * ny)), waves


def _both_signs(points: int) -> Array:
    # The half spectrum represents both signs of q_x, except in its first and, if even, last column.
    weight = np.full(points // 2 + 1, 2.0)
    weight[0] = 1.0
    if points % 2 == 0:
        weight[-1] = 1.0
    return weight


def _sums_over_pairs(padded: Array, half_y: int, half_x: int) -> Array:
    """Return Σ z(r) z(r + t) of a map padded with zeros, for lags up to half its sides."""
    spectrum = fft.rfft2(padded)
    for rows in grid.row_blocks(spectrum.shape):
        spectrum[rows] = np.square(spectrum[rows].real) + np.square(spectrum[rows].imag)
    sums: Array = fft.irfft2(spectrum, padded.shape)
    return np.concatenate(
        [sums[padded.shape[0] - half_y :, : half_x + 1], sums[: half_y + 1, : half_x + 1]]
    )


def _crossings(function: Array, pixel: Pixel, threshold: float) -> tuple[Array, Array]:
    """Return the distances [m] of the crossing of each ray from zero lag."""
    half_y, half_x = function.shape[0] // 2, function.shape[1] - 1
    # Rays advance by one pixel along the axis to which they are closer.
    y, x = _border(half_y, half_x)
    reach = np.maximum(np.abs(y), x)
    y, x, reach = y[reach > 0], x[reach > 0], reach[reach > 0]
    uy, ux = y / reach, x / reach
    stride = np.hypot(uy * pixel[0], ux * pixel[1])
    lengths = np.full(reach.size, math.inf)
    reached = np.zeros(reach.size)
    live, before = np.arange(reach.size), np.ones(reach.size)
    for step in range(1, max(half_y, half_x) + 1):
        inside = reach[live] >= step
        live, before = live[inside], before[inside]
        value = _bilinear(function, half_y + step * uy[live], step * ux[live])
        low = value <= threshold
        crossing = step - (threshold - value[low]) / (before[low] - value[low])
        lengths[live[low]] = reached[live[low]] = crossing * stride[live[low]]
        # A ray that reaches lags without enough pairs ends there, undecided.
        high = value > threshold
        live, before = live[high], value[high]
        reached[live] = step * stride[live]
        if live.size == 0:
            break
    return lengths, reached


def _border(half_y: int, half_x: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    # Lags (y, x) on the border of the half plane x ≥ 0.
    y, x = np.arange(-half_y, half_y + 1), np.arange(half_x)
    return (
        np.concatenate([y, np.full(half_x, half_y), np.full(half_x, -half_y)]),
        np.concatenate([np.full(y.size, half_x), x, x]),
    )


def _bilinear(values: Array, y: Array, x: Array) -> Array:
    row = np.clip(y.astype(np.int64), 0, max(values.shape[0] - 2, 0))
    column = np.clip(x.astype(np.int64), 0, max(values.shape[1] - 2, 0))
    below, right = (
        np.minimum(index + 1, length - 1)
        for index, length in zip((row, column), values.shape, strict=True)
    )
    v, u = y - row, x - column
    upper = (1 - u) * values[row, column] + u * values[row, right]
    lower = (1 - u) * values[below, column] + u * values[below, right]
    return (1 - v) * upper + v * lower
