"""Roughness parameters: of a map after ISO 25178-2, of a profile after ISO 21920-2.

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

`mean_slope`: Mean of the absolute slopes along x and along y, over the same differences as Sdq, and
their root-mean-square: the slope m along a profile of an isotropic surface. Of a Gaussian one it is
Sdq/√π.

Cooper, Mikic and Yovanovich 1969, Int. J. Heat Mass Transfer 12, 279,
doi:10.1016/0017-9310(69)90011-8

`profile_parameters`: Only the mean is subtracted. R-parameters are those of a profile without its
waves beyond λc (`profile_cutoff`), P-parameters those of the primary profile, whose section length
is all of it. Rp, Rv and Rz are means over the sections: of the highest peak, of the deepest dale,
and of the height between both. Rt is that of all of the
profile. Short waves are not removed (λs). Rsm is the mean width of profile elements:
from one crossing of the mean line to the next in the same direction, where between the two a
peak and a dale reach beyond a tenth of Rz. The slope of Rdq is that of the standard, over three
points to each side.

ISO 21920-2:2021, sections 4.3 and 4.4; ISO 4287:1997, sections 4.1 to 4.4

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

`volume_parameters`: With c(r) the height at the material ratio r, the material volume above it
is Vm(r) = ∫₀ʳ (c - c(r)) and the void volume below it Vv(r) = ∫ᵣ¹ (c(r) - c), both over the
ratio. Vmp = Vm(p), Vmc = Vm(q) - Vm(p), Vvc = Vv(p) - Vv(q), Vvv = Vv(q).

ISO 25178-2:2021, section 4.5 (void and material volume); the ratios of 10 % and 80 % are from
ISO 25178-3.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array, Pixel
from roughcontact.errors import InputError, require_positive
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


def rms_gradient(heights: NDArray[np.float64], pixel: Pixel) -> float:
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


def mean_slope(heights: Array, pixel: Pixel) -> float:
    """Return the mean absolute slope along a profile, m."""
    slopes = (np.diff(heights, axis=axis) / pixel[axis] for axis in (0, 1))
    means = [float(np.nanmean(np.abs(s))) for s in slopes if s.size and not np.isnan(s).all()]
    return math.sqrt(float(np.mean(np.square(means)))) if means else math.nan


def median_gradient(heights: Array, pixel: Pixel) -> float:
    """Return the median of the gradients, which holes, steps and spikes hardly change."""
    squares = np.concatenate([part.ravel() for part in squared_gradients(heights, pixel)])
    known = squares[~np.isnan(squares)]
    return math.sqrt(float(np.median(known))) if known.size else math.nan


def squared_gradients(heights: Array, pixel: Pixel) -> Iterator[Array]:
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


def developed_area_ratio(heights: Array, pixel: Pixel) -> float:
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


CUTOFFS = (0.08e-3, 0.25e-3, 0.8e-3, 2.5e-3, 8e-3)
"""Nesting indices λc of the standards [m]."""

SECTIONS = 5
"""Section lengths λc in an evaluation length."""

# Fraction of Rz that peaks and dales must exceed to be included in Rsm.
_COUNTED = 0.1
# Weights of the slope over three points to each side, times 60 (ISO 21920-2 and ISO 4287).
_SLOPE = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0])


def profile_parameters(
    heights: Array, spacing: float, sections: int = 1, profile: str = "R"
) -> dict[str, float]:
    """Return the parameters of an R or P profile, by the symbols of ISO 21920-2 and in SI units."""
    require_positive(spacing=spacing)
    areal = height_parameters(heights[None])
    z = heights - (float(np.nanmax(heights)) - areal["Sp"])
    parts = _parts(z, sections)
    peak, dale = (float(np.mean([end(part) for part in parts])) for end in (np.nanmax, np.nanmin))
    depth, slopes = peak - dale, _slopes(heights, spacing)
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
        "dq": math.sqrt(float(np.mean(np.square(slopes)))) if slopes.size else math.nan,
        "da": float(np.mean(np.abs(slopes))) if slopes.size else math.nan,
    }
    return {f"{profile}{name}": value for name, value in values.items()}


def profile_cutoff(length: float) -> float | None:
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


def volume_parameters(ratio: Array, height: Array) -> dict[str, float]:
    """Return the volume parameters Vmp, Vmc, Vvc and Vvv."""
    peak, core = 0.1, 0.8

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
