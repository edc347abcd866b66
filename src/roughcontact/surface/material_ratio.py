"""Material ratio curve, and the core and volume parameters of ISO 25178-2.

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

ISO 25178-2:2021, section 4.5 (void and material volume); the default ratios of 10 % and 80 % are
from ISO 25178-3.
"""

from __future__ import annotations

import numpy as np

from roughcontact._tools.arrays import Array
from roughcontact.errors import ArgumentRef, InputError
from roughcontact.surface.roughness import mean_and_count

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
