"""Parameters of a profile after ISO 21920-2, the successor of ISO 4287.

`summary`: Only the mean is subtracted. R-parameters are those of a profile without its waves
beyond λc (`cutoff`), P-parameters those of the primary profile, whose section length is all of it.
Rp, Rv and Rz are means over the sections: of the
highest peak, of the deepest dale, and of the height between both. Rt is that of all of the
profile. Short waves are not removed (λs). Rsm is the mean width of profile elements:
from one crossing of the mean line to the next in the same direction, where between the two a
peak and a dale reach beyond a tenth of Rz. The slope of Rdq is that of the standard, over three
points to each side.

ISO 21920-2:2021, sections 4.3 and 4.4; ISO 4287:1997, sections 4.1 to 4.4
"""

from __future__ import annotations

import math

import numpy as np

from roughcontact._tools.arrays import Array
from roughcontact.errors import InputError, require_positive
from roughcontact.surface.roughness import height_parameters

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
