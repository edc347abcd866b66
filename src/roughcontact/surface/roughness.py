"""Roughness parameters after ISO 25178-2 and ISO 21920-2, autocorrelation and spectrum of a map.

`height_parameters`: With z the height above the mean and ⟨ ⟩ the average over the valid points:
Sq = √⟨z²⟩, ``Sa = ⟨|z|⟩``, Ssk = ⟨z³⟩/Sq³, Sku = ⟨z⁴⟩/Sq⁴ (3 for a Gaussian surface), Sp = max
z, Sv = -min z, Sz = Sp + Sv.

ISO 25178-2:2021, section 4.2

`rms_height`: ISO 25178-2:2021, root mean square height; only the mean is subtracted here.

`rms_gradient`: The standard defines Sdq² as the mean of ``(∂z/∂x)² + (∂z/∂y)²`` and does not
specify the differences. Here they are the first differences to the preceding neighbors,
``(z[j, i] - z[j, i-1])/dx`` and ``(z[j, i] - z[j-1, i])/dy``, over the (ny - 1)(nx - 1) points
that have both: they include the shortest measured distance in full, which central differences
would skip.

ISO 25178-2:2021, root mean square gradient; the differences after Stout et al., The development
of methods for the characterisation of roughness in three dimensions (1993), EUR 15178 EN.

`developed_area_ratio`: The standard defines Sdr as the mean of ``√(1 + (∂z/∂x)² + (∂z/∂y)²) - 1``.
Here every cell between four points is divided into two triangles along either diagonal, and both
divisions are averaged, so that mirroring the map changes nothing. A triangle with the slopes s_x
and s_y along its two edges on the grid has ``√(1 + s_x² + s_y²)`` times its projected area, hence a
cell has the mean of this factor over its two s_x and its two s_y.

ISO 25178-2:2021, section 4.4; the triangles after Stout et al., The development of methods for
the characterisation of roughness in three dimensions (1993), EUR 15178 EN.

`material_ratio_curve`: Each height is placed at the center of its step in the curve. Equal heights
form one wide step, hence the curve of a map with coarse digits is smooth. More than 2¹⁸ different
heights are averaged in groups of equal number, in their order.

ISO 25178-2:2021, sections 3 and 4.5 (areal material ratio and its inverse)

`core_parameters`: The secant over a material ratio of 40 % with the least slope bounds the
central region; of several, the one at the smallest ratio. The equivalent line is the
least-squares fit, in height, to the curve in that region. It meets the ratios 0 and 1 at the
heights c₁ and c₂: Sk = c₁ - c₂, and the curve has these heights at Smr1 and Smr2. Spk and Svk
are the heights of the right-angled triangles over Smr1 and 1 - Smr2 that have the area between
curve and c₁, or between c₂ and curve.

ISO 25178-2:2021, section 4.5 (areal parameters for stratified surfaces); the construction follows
ISO 13565-2:1996.

`height_differences`: Sxp is the height between the material ratios 2.5 % and 50 %, Sdc here between
10 % and 80 %, the ratios of the volume parameters; the standard leaves those of Sdc open.

ISO 25178-2:2021, section 4.5; the ratios of Sxp are from ISO 25178-3.

`mean_slope`: Mean of the absolute slopes along x and along y, over the same differences as Sdq, and
their root-mean-square: the slope m along a profile of an isotropic surface. Of a Gaussian one it is
Sdq/√π.

Cooper, Mikic and Yovanovich 1969, Int. J. Heat Mass Transfer 12, 279,
doi:10.1016/0017-9310(69)90011-8

`volume_parameters`: With c(r) the height at the material ratio r, the material volume above it
is Vm(r) = ∫₀ʳ (c - c(r)) and the void volume below it Vv(r) = ∫ᵣ¹ (c(r) - c), both over the
ratio. Vmp = Vm(p), Vmc = Vm(q) - Vm(p), Vvc = Vv(p) - Vv(q), Vvv = Vv(q).

ISO 25178-2:2021, section 4.5 (void and material volume); the default ratios of 10 % and 80 % are
from ISO 25178-3.

`summary`: Only the mean is subtracted. R-parameters are those of a profile without its waves
beyond λc (`cutoff`), P-parameters those of the primary profile, whose section length is all of it.
Rp, Rv and Rz are means over the sections: of the
highest peak, of the deepest dale, and of the height between both. Rt is that of all of the
profile. Short waves are not removed (λs). Rsm is the mean width of profile elements:
from one crossing of the mean line to the next in the same direction, where between the two a
peak and a dale reach beyond a tenth of Rz. The slope of Rdq is that of the standard, over three
points to each side.

ISO 21920-2:2021, sections 4.3 and 4.4; ISO 4287:1997, sections 4.1 to 4.4

`autocorrelation`: f(t) = ⟨z(r) z(r + t)⟩ / ⟨z²⟩, with z the height above the mean and the upper
average over the pairs of valid points. The map is not continued beyond its edges, and holes need no
filling. In the corners of the map of lags, lags beyond half the sides have less than a quarter of
the pairs: they show chance rather than texture. The transforms need about nine times the memory of
the map.

ISO 25178-2:2021, section 3 (autocorrelation function)

`autocorrelation_lengths`: ``Sal = min |t|`` over the lags with f(t) ≤ s; ``Str = Sal / max |t|``
over the lags connected to zero lag by a straight line on which f ≥ s. Both follow from the first
crossing of s on the rays from zero lag to every lag on the border of `autocorrelation`, with linear
interpolation. Lengths of about one pixel are therefore determined by the pixel, not by the surface.

ISO 25178-2:2021, section 4.3; the default threshold of 0.2 is from ISO 25178-3.

`texture`: ISO 25178-2:2021, section 4.3

`lay_direction`: Direction of the lay, at a right angle to the largest value of the angular
spectrum.
The standard leaves the weight of the waves open; here it is that of the gradient, the sum of
``|q h̃(q)|²`` over the wave vectors of one direction, so that many waves decide and not the few
longest ones. The map has a Hann window, so that edges cause no waves along the axes. The direction
is the mean of the waves within 20 degrees of it. On maps of 256 × 256 points it is right to 1° for
Str 0.1, to 2° for Str 0.3.

ISO 25178-2:2021, section 4.3 (texture direction Std)

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
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array, Pixel
from roughcontact.errors import (
    ArgumentRef,
    InputError,
    input_error,
    require_pixel,
    require_positive,
)
from roughcontact.halfspace import fft
from roughcontact.surface import grid


def height_parameters(heights: Array) -> dict[str, float]:
    """Return the height parameters Sq, Sa, Ssk, Sku, Sp, Sv and Sz."""
    Sq = rms_height(heights)
    mean, count = mean_and_count(heights)
    top, bottom = float(np.nanmax(heights)), float(np.nanmin(heights))
    flat = top == bottom
    absolute, third, fourth = 0.0, 0.0, 0.0
    for rows in grid.row_blocks(heights.shape):
        z = heights[rows] - mean
        absolute += float(np.nansum(np.abs(z)))
        if not flat:
            z /= Sq
            square = z * z
            third += float(np.nansum(square * z))
            fourth += float(np.nansum(np.square(square, out=square)))
    return {
        "Sq": Sq,
        "Sa": absolute / count,
        "Ssk": math.nan if flat else third / count,
        "Sku": math.nan if flat else fourth / count,
        "Sp": top - mean,
        "Sv": mean - bottom,
        "Sz": top - bottom,
    }


def rms_height(heights: NDArray[np.float64]) -> float:
    """Return the root-mean-square height about the mean, Sq."""
    mean, count = _rounded_mean(heights)
    squares, rest = 0.0, 0.0
    for rows in grid.row_blocks(heights.shape):
        deviation = heights[rows] - mean
        rest += float(np.nansum(deviation))
        squares += float(np.nansum(np.square(deviation, out=deviation)))
    # The second term corrects for the rounding of the mean of a map with a large offset.
    return float(np.sqrt(max(squares / count - (rest / count) ** 2, 0.0)))


def rms_gradient(heights: NDArray[np.float64], pixel: tuple[float, float]) -> float:
    """Return the root-mean-square gradient, Sdq."""
    total, count = 0.0, 0
    for squares in squared_gradients(heights, pixel):
        count += int(np.count_nonzero(~np.isnan(squares)))
        total += float(np.nansum(squares))
    if count == 0:
        raise InputError(
            "has no point with two valid neighbors: the gradient is undefined", argument="heights"
        )
    return float(np.sqrt(total / count))


def mean_slope(heights: Array, pixel: tuple[float, float]) -> float:
    """Return the mean absolute slope along a profile, m."""
    slopes = (np.diff(heights, axis=axis) / pixel[axis] for axis in (0, 1))
    means = [float(np.nanmean(np.abs(s))) for s in slopes if s.size and not np.isnan(s).all()]
    return math.sqrt(float(np.mean(np.square(means)))) if means else math.nan


def median_gradient(heights: Array, pixel: tuple[float, float]) -> float:
    """Return the median of the gradients, which holes, steps and spikes hardly change."""
    squares = np.concatenate([part.ravel() for part in squared_gradients(heights, pixel)])
    known = squares[~np.isnan(squares)]
    return math.sqrt(float(np.median(known))) if known.size else math.nan


def squared_gradients(heights: Array, pixel: tuple[float, float]) -> Iterator[Array]:
    """Yield blocks of rows of the squared gradient, without the first row and column."""
    dy, dx = pixel
    if heights.shape[0] == 1:
        # A profile is uniform across its direction.
        heights = np.repeat(heights, 2, axis=0)
    for rows in grid.row_blocks((heights.shape[0] - 1, heights.shape[1])):
        here = heights[rows.start + 1 : rows.stop + 1]
        slope_y = (here[:, 1:] - heights[rows, 1:]) / dy
        slope_x = np.diff(here, axis=1) / dx
        yield slope_x * slope_x + slope_y * slope_y


def developed_area_ratio(heights: Array, pixel: tuple[float, float]) -> float:
    """Return the developed interfacial area ratio, Sdr, by triangulation."""
    dy, dx = pixel
    total, count = 0.0, 0
    for rows in grid.row_blocks((heights.shape[0] - 1, heights.shape[1])):
        part = heights[rows.start : rows.stop + 1]
        squares_x = np.square(np.diff(part, axis=1) / dx)
        squares_y = np.square(np.diff(part, axis=0) / dy)
        excess = np.zeros((part.shape[0] - 1, part.shape[1] - 1))
        for along_x in (squares_x[:-1], squares_x[1:]):
            for along_y in (squares_y[:, :-1], squares_y[:, 1:]):
                square = along_x + along_y
                # √(1 + s²) - 1 without cancellation at small slopes.
                excess += square / (1 + np.sqrt(1 + square))
        count += int(np.count_nonzero(~np.isnan(excess)))
        total += float(np.nansum(excess)) / 4
    if count == 0:
        raise InputError(
            "has no cell with four valid corners: the area is undefined", argument="heights"
        )
    return total / count


def _rounded_mean(heights: Array) -> tuple[float, int]:
    """Return the mean height, with rounding errors, and the number of valid points."""
    total, count = 0.0, 0
    for rows in grid.row_blocks(heights.shape):
        count += int(np.count_nonzero(~np.isnan(heights[rows])))
        total += float(np.nansum(heights[rows]))
    if count == 0:
        raise InputError("has no finite value: every point is missing", argument="heights")
    return total / count, count


def mean_and_count(heights: Array) -> tuple[float, int]:
    """Return the mean height and the number of valid points."""
    mean, count = _rounded_mean(heights)
    # A second pass, for the rounding of the mean of a map with a large offset.
    rest = sum(float(np.nansum(heights[rows] - mean)) for rows in grid.row_blocks(heights.shape))
    return mean + rest / count, count


# --- Material ratio curve, and the core and volume parameters of ISO 25178-2 ---


# Maximum number of points of a material ratio curve; more heights are averaged in groups.
_CURVE_POINTS = 2**18


def material_ratio_curve(heights: Array) -> tuple[Array, Array]:
    """Return the areal material ratio curve (bearing or Abbott-Firestone curve)."""
    mean, count = mean_and_count(heights)
    order = heights[~np.isnan(heights)]
    order.sort()
    order = order[::-1]
    order -= mean
    starts = np.concatenate([[0], np.flatnonzero(order[1:] != order[:-1]) + 1])
    group = -(-starts.size // _CURVE_POINTS)
    starts = starts[::group]
    ends = np.append(starts[1:], count)
    middle = order[starts]
    if group > 1:
        middle = np.add.reduceat(order, starts) / (ends - starts)
    ratio = np.concatenate([[0.0], (starts + ends) / (2 * count), [1.0]])
    return ratio, np.concatenate([order[:1], middle, order[-1:]])


def core_parameters(ratio: Array, height: Array) -> dict[str, float]:
    """Return the parameters of a stratified surface: Sk, Spk, Svk, Smr1 and Smr2."""
    width = 0.4
    # The fall over the width is piecewise linear: its minimum is where either end has a kink.
    kinks = np.concatenate([ratio, ratio - width, [1 - width]])
    kinks = np.sort(kinks[(kinks >= 0) & (kinks <= 1 - width)])
    fall = np.interp(kinks, ratio, height) - np.interp(kinks + width, ratio, height)
    # With a tolerance, so that rounding does not decide between equal secants.
    tolerance = 1e-12 * (height[0] - height[-1])
    start = float(kinks[np.argmax(fall <= fall.min() + tolerance)])
    part, z = _section(ratio, height, start, start + width)
    t = part - (start + width / 2)
    # Exact integral ∫ t z dt: Simpson's rule on every straight segment.
    middle = (t[1:] + t[:-1]) * (z[1:] + z[:-1])
    moment = float(np.sum(np.diff(t) * (t[1:] * z[1:] + t[:-1] * z[:-1] + middle))) / 6
    slope = 12 * moment / width**3
    center = _integral(part, z) / width
    c1 = center - slope * (start + width / 2)
    c2 = c1 + slope
    Smr1, Smr2 = ratio_at(ratio, height, c1), ratio_at(ratio, height, c2)
    peaks, dales = _section(ratio, height, 0.0, Smr1), _section(ratio, height, Smr2, 1.0)
    peak_area = _integral(peaks[0], np.maximum(peaks[1] - c1, 0.0))
    dale_area = _integral(dales[0], np.maximum(c2 - dales[1], 0.0))
    return {
        "Sk": c1 - c2,
        "Spk": 2 * peak_area / Smr1 if Smr1 > 0 else 0.0,
        "Svk": 2 * dale_area / (1 - Smr2) if Smr2 < 1 else 0.0,
        "Smr1": Smr1,
        "Smr2": Smr2,
    }


def height_differences(ratio: Array, height: Array) -> dict[str, float]:
    """Return the heights between two material ratios, Sxp and Sdc."""
    at = np.interp([0.025, 0.5, 0.1, 0.8], ratio, height)
    return {"Sxp": float(at[0] - at[1]), "Sdc": float(at[2] - at[3])}


def volume_parameters(
    ratio: Array, height: Array, peak: float = 0.1, core: float = 0.8
) -> dict[str, float]:
    """Return the volume parameters Vmp, Vmc, Vvc and Vvv."""
    if not 0 < peak < core < 1:
        raise InputError(
            f"and {ArgumentRef('core')} must satisfy 0 < peak < core < 1, got {peak!r}, {core!r}",
            argument="peak",
            value=peak,
        )

    def material(r: float) -> float:
        part, c = _section(ratio, height, 0.0, r)
        return _integral(part, c - c[-1])

    def void(r: float) -> float:
        part, c = _section(ratio, height, r, 1.0)
        return _integral(part, c[0] - c)

    return {
        "Vmp": material(peak),
        "Vmc": material(core) - material(peak),
        "Vvc": void(peak) - void(core),
        "Vvv": void(core),
    }


def _section(ratio: Array, height: Array, start: float, stop: float) -> tuple[Array, Array]:
    inner = (ratio > start) & (ratio < stop)
    part = np.concatenate([[start], ratio[inner], [stop]])
    return part, np.interp(part, ratio, height)


def _integral(x: Array, y: Array) -> float:
    return float(np.sum(np.diff(x) * (y[1:] + y[:-1]))) / 2


def ratio_at(ratio: Array, height: Array, c: float) -> float:
    """Return the material ratio at a height, Smr(c)."""
    if c >= height[0]:
        return 0.0
    return 1.0 if c <= height[-1] else float(np.interp(-c, -height, ratio))


# --- Parameters of a profile after ISO 21920-2, the successor of ISO 4287 ---


CUTOFFS = (0.08e-3, 0.25e-3, 0.8e-3, 2.5e-3, 8e-3)
"""Nesting indices λc of the standards [m]."""

SECTIONS = 5
"""Section lengths λc in an evaluation length."""

# Fraction of Rz that peaks and dales must exceed to be included in Rsm.
_COUNTED = 0.1
# Weights of the slope over three points to each side, times 60 (ISO 21920-2 and ISO 4287).
_SLOPE = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0])


def summary(
    heights: Array, spacing: float, sections: int = 1, profile: str = "R"
) -> dict[str, float]:
    """Return the parameters of an R or P profile, by the symbols of ISO 21920-2 and in SI units."""
    require_positive(spacing=spacing)
    areal = height_parameters(heights[None])
    z = heights - (float(np.nanmax(heights)) - areal["Sp"])
    parts = _parts(z, sections)
    peak, dale = (float(np.mean([end(part) for part in parts])) for end in (np.nanmax, np.nanmin))
    depth = peak - dale
    values = {
        "q": areal["Sq"],
        "a": areal["Sa"],
        "sk": areal["Ssk"],
        "ku": areal["Sku"],
        "p": peak,
        "v": -dale,
        "t": areal["Sz"],
        "z": depth,
        "sm": element_width(z, spacing, _COUNTED * depth),
        "dq": rms_slope(heights, spacing),
        "da": mean_absolute_slope(heights, spacing),
    }
    return {f"{profile}{name}": value for name, value in values.items()}


def cutoff(length: float) -> float | None:
    """Return the largest standard λc of which five fit into a length [m]."""
    fitting = [wave for wave in CUTOFFS if SECTIONS * wave <= length * (1 + 1e-9)]
    return fitting[-1] if fitting else None


def element_width(heights: Array, spacing: float, minimum: float) -> float:
    """Return the mean width of the elements of a profile, Rsm."""
    beyond = np.flatnonzero(np.abs(heights) > minimum)
    sign = np.sign(heights[beyond])
    turns = np.flatnonzero(sign[1:] != sign[:-1])
    crossings = []
    for turn in turns:
        first, last = int(beyond[turn]), int(beyond[turn + 1])
        part = heights[first : last + 1]
        # The last crossing between a dale and a peak that are both included.
        index = int(np.flatnonzero(part[:-1] * sign[turn] > 0)[-1])
        before, after = float(part[index]), float(part[index + 1])
        share = before / (before - after) if math.isfinite(after) else 0.5
        crossings.append((first + index + share) * spacing)
    widths = [second - first for first, second in zip(crossings, crossings[2:], strict=False)]
    return float(np.mean(widths)) if widths else math.nan


def rms_slope(heights: Array, spacing: float) -> float:
    """Return the root-mean-square slope of a profile, Rdq."""
    known = _slopes(heights, spacing)
    return float(np.sqrt(np.mean(np.square(known)))) if known.size else math.nan


def mean_absolute_slope(heights: Array, spacing: float) -> float:
    """Return the mean absolute slope of a profile, Rda."""
    known = _slopes(heights, spacing)
    return float(np.mean(np.abs(known))) if known.size else math.nan


def _slopes(heights: Array, spacing: float) -> Array:
    if heights.size < _SLOPE.size:
        return np.empty(0)
    slopes = np.convolve(heights, _SLOPE[::-1], "valid") / (60 * spacing)
    return slopes[np.isfinite(slopes)]


def _parts(heights: Array, sections: int) -> list[Array]:
    parts = [part for part in np.array_split(heights, sections) if np.isfinite(part).any()]
    if not parts:
        raise InputError("has no finite value: every point is missing", argument="heights")
    return parts


# --- Autocorrelation and power spectrum of a map ---


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


def autocorrelation_lengths(
    heights: Array, pixel: Pixel, threshold: float = 0.2
) -> tuple[float, float]:
    """Return the distances of fastest and slowest decay of the autocorrelation function."""
    lengths, _ = _decay(heights, pixel, threshold)
    return float(lengths.min()), float(lengths.max())


def texture(heights: Array, pixel: Pixel, threshold: float = 0.2) -> tuple[float, float, float]:
    """Return autocorrelation length, texture aspect ratio and its upper bound."""
    lengths, reached = _decay(heights, pixel, threshold)
    fastest, slowest = float(lengths.min()), float(lengths.max())
    if not math.isfinite(fastest):
        return math.nan, math.nan, math.nan
    determined = math.isfinite(slowest)
    largest = fastest / max(float(reached.max()), fastest)
    return fastest, fastest / slowest if determined else math.nan, largest


# Angles [degrees] over which the angular spectrum is smoothed, and averaged around its largest
# value; repetitions of this mean.
_SMOOTH, _AROUND, _REPETITIONS = 8, 20, 8
# Power of waves that count over the median of the shortest ones.
_ABOVE_NOISE = 10.0


def lay_direction(heights: Array, pixel: Pixel) -> float:
    """Return the direction of the lay [degrees], counter-clockwise from x, row 0 on top; Std."""
    require_pixel(pixel)
    (ny, nx), (dy, dx) = heights.shape, pixel
    if min(ny, nx) < _SMOOTH or not rms_height(heights) > 0:
        return math.nan
    window = np.outer(np.hanning(ny + 2)[1:-1], np.hanning(nx + 2)[1:-1])
    window[np.isnan(heights)] = 0.0
    z = np.where(window > 0, heights, 0.0)
    z = (z - float(np.sum(window * z) / np.sum(window))) * window
    spectrum = fft.rfft2(z)
    qy, qx = fft.frequencies(ny, dy)[:, None], fft.half_frequencies(nx, dx)[None]
    square = np.square(qy) + np.square(qx)
    raw = np.square(spectrum.real) + np.square(spectrum.imag)
    limit = 0.25 / max(dy, dx) ** 2
    # Same waves in every direction: within the circle of Nyquist, beyond the widest of the window,
    # and above the noise, which is that of the shortest waves.
    noise = float(np.median(raw[(square > 0.5 * limit) & (square <= limit)]))
    widest = (np.abs(qy) * ny * dy < 1.5) & (qx * nx * dx < 1.5)
    power = _both_signs(nx) * square * raw
    power[(square > limit) | widest | (raw < _ABOVE_NOISE * noise)] = 0.0
    angle = np.degrees(np.arctan2(-qy, np.broadcast_to(qx, square.shape))) % 180
    if not power.sum() > 0:
        return math.nan
    angular = np.bincount(angle.ravel().astype(np.int64) % 180, power.ravel(), minlength=180)
    smooth = sum(np.roll(angular, shift) for shift in range(-_SMOOTH, _SMOOTH + 1))
    wave = float(np.argmax(smooth)) + 0.5
    for _ in range(_REPETITIONS):
        offset = (angle - wave + 90) % 180 - 90
        around = np.where(np.abs(offset) <= _AROUND, power, 0.0)
        wave += float(np.sum(around * offset) / np.sum(around))
    return (wave + 90) % 180


def _decay(heights: Array, pixel: Pixel, threshold: float) -> tuple[Array, Array]:
    """Return first threshold crossing and length above it, for each ray from zero lag."""
    require_pixel(pixel)
    if not 0 < threshold < 1:
        raise input_error("threshold", threshold, "must be between 0 and 1")
    function = autocorrelation(heights)
    if np.isnan(function[function.shape[0] // 2, 0]):
        return np.full(1, math.nan), np.full(1, math.nan)
    return _crossings(function, pixel, threshold)


def radial_spectrum(heights: Array, pixel: Pixel) -> tuple[Array, Array, Array]:
    """Return the radially averaged power spectral density of a map."""
    require_pixel(pixel)
    missing = int(np.count_nonzero(np.isnan(heights)))
    if missing:
        raise InputError(
            f"has {missing} missing points; fill or crop them first, e.g. surface.filled()",
            argument="heights",
        )
    (ny, nx), (dy, dx) = heights.shape, pixel
    spectrum = fft.rfft2(heights - mean_and_count(heights)[0])
    qy = 2 * np.pi * fft.frequencies(ny, dy)
    qx = 2 * np.pi * fft.half_frequencies(nx, dx)
    delta = 2 * np.pi / min(ny * dy, nx * dx)
    shells = int(math.hypot(np.abs(qy).max(), qx.max()) / delta + 0.5) + 1
    weight = _both_signs(nx)
    sums = _shell_sums(spectrum, (qy, qx), weight, delta, shells)
    waves, wave_number, power = sums[:, sums[0] > 0]
    return wave_number / waves, power / waves * (dx * dy / (nx * ny)), waves


def _shell_sums(
    spectrum: NDArray[np.complex128],
    wave_numbers: tuple[Array, Array],
    weight: Array,
    delta: float,
    shells: int,
) -> Array:
    """Return the sums of weight, weight times |q| and weight times power over each shell."""
    qy, qx = wave_numbers
    sums = np.zeros((3, shells))
    for rows in grid.row_blocks(spectrum.shape):
        q = np.hypot(qy[rows, None], qx)
        shell = (q / delta + 0.5).astype(np.int64).ravel()
        weights = np.broadcast_to(weight, q.shape).copy()
        if rows.start == 0:
            weights[0, 0] = 0.0
        power = np.square(spectrum[rows].real) + np.square(spectrum[rows].imag)
        for total, values in zip(sums, (weights, weights * q, weights * power), strict=True):
            total += np.bincount(shell, values.ravel(), minlength=shells)
    return sums


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
