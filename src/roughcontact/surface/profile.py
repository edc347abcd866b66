"""Parameters of a profile after ISO 21920-2, the successor of ISO 4287."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from roughcontact.errors import InputError, require_positive
from roughcontact.surface.roughness import height_parameters

Array = NDArray[np.float64]

CUTOFFS = (0.08e-3, 0.25e-3, 0.8e-3, 2.5e-3, 8e-3)
"""Nesting indices λc of the standards [m]."""

SECTIONS = 5
"""Section lengths λc in an evaluation length."""

# Part of Rz that a peak must rise, and a dale fall, to count for Rsm.
_COUNTED = 0.1
# Weights of the slope over three points to each side, times 60 (ISO 21920-2, and ISO 4287).
_SLOPE = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0])


def summary(heights: Array, spacing: float, sections: int = 1) -> dict[str, float]:
    """Return the parameters of a profile, under the standard's symbols and in SI units.

    Parameters
    ----------
    heights : ndarray, shape (n,)
        Heights [m] at equal distances, leveled and, if wanted, filtered before; NaN where missing.
    spacing : float
        Distance of the points [m].
    sections : int
        Equal parts of the profile over which Rz is a mean.

    Returns
    -------
    dict
        ``Rq, Ra, Rp, Rv, Rt, Rz`` [m], ``Rsk, Rku``, ``Rsm`` [m] and ``Rdq``. Rsk and Rku of a flat
        profile are NaN, as is Rsm of one with fewer than two elements, and Rdq of one in which no
        seven points stand together.

    Raises
    ------
    InputError
        If the distance is not positive, or every point is missing.

    Notes
    -----
    Only the mean is subtracted. The letter R is right for a profile without its waves beyond λc
    (`cutoff`); of one that was only leveled these are Pa, Pq and so on of the primary profile.
    Rp, Rv and Rt are those of all of the profile, Rz is the mean over the sections of their
    heights from the lowest to the highest point. Rsm is the mean width of profile elements: from
    one crossing of the mean line to the next in the same direction, where between the two a peak
    and a dale reach beyond a tenth of Rz. The slope of Rdq is that of the standard, over three
    points to each side.

    References
    ----------
    ISO 21920-2:2021, sections 4.3 and 4.4; ISO 4287:1997, sections 4.1 to 4.4

    Examples
    --------
    >>> x = np.arange(4000) * 1e-6
    >>> found = summary(1e-6 * np.sin(2 * np.pi * x / 1e-4), 1e-6)
    >>> round(1e6 * found["Rq"], 4), round(1e6 * found["Rsm"], 3), round(found["Rdq"], 4)
    (0.7071, 100.0, 0.0444)
    """
    require_positive(spacing=spacing)
    values = height_parameters(heights[None])
    top = [float(np.nanmax(part)) - float(np.nanmin(part)) for part in _parts(heights, sections)]
    depth = float(np.mean(top))
    z = heights - (float(np.nanmax(heights)) - values["Sp"])
    return {
        "Rq": values["Sq"],
        "Ra": values["Sa"],
        "Rsk": values["Ssk"],
        "Rku": values["Sku"],
        "Rp": values["Sp"],
        "Rv": values["Sv"],
        "Rt": values["Sz"],
        "Rz": depth,
        "Rsm": element_width(z, spacing, _COUNTED * depth),
        "Rdq": rms_slope(heights, spacing),
    }


def cutoff(length: float) -> float | None:
    """Return the largest λc of the standards of which five fit into a length [m].

    Parameters
    ----------
    length : float
        Of the profile [m].

    Returns
    -------
    float or None
        λc [m]; ``None`` where not even the smallest fits.

    Examples
    --------
    >>> cutoff(4.8e-3), cutoff(0.1e-3)
    (0.0008, None)
    """
    fitting = [wave for wave in CUTOFFS if SECTIONS * wave <= length * (1 + 1e-9)]
    return fitting[-1] if fitting else None


def element_width(heights: Array, spacing: float, least: float) -> float:
    """Return the mean width of the elements of a profile, Rsm.

    Parameters
    ----------
    heights : ndarray, shape (n,)
        Heights above the mean line [m].
    spacing : float
        Distance of the points [m].
    least : float
        Height and depth [m] beyond which a peak and a dale count.

    Returns
    -------
    float
        In metres; NaN where no crossing in the same direction follows another.
    """
    beyond = np.flatnonzero(np.abs(heights) > least)
    sign = np.sign(heights[beyond])
    turns = np.flatnonzero(sign[1:] != sign[:-1])
    crossings = []
    for turn in turns:
        first, last = int(beyond[turn]), int(beyond[turn + 1])
        part = heights[first : last + 1]
        # The last of the crossings between a dale and a peak that both count.
        at = int(np.flatnonzero(part[:-1] * sign[turn] > 0)[-1])
        before, after = float(part[at]), float(part[at + 1])
        share = before / (before - after) if math.isfinite(after) else 0.5
        crossings.append((first + at + share) * spacing)
    widths = [second - first for first, second in zip(crossings, crossings[2:], strict=False)]
    return float(np.mean(widths)) if widths else math.nan


def rms_slope(heights: Array, spacing: float) -> float:
    """Return the root-mean-square slope of a profile, Rdq.

    Parameters
    ----------
    heights : ndarray, shape (n,)
        Heights [m], NaN where missing.
    spacing : float
        Distance of the points [m].

    Returns
    -------
    float
        Without unit; NaN where no seven points stand together.
    """
    if heights.size < _SLOPE.size:
        return math.nan
    slopes = np.convolve(heights, _SLOPE[::-1], "valid") / (60 * spacing)
    known = slopes[np.isfinite(slopes)]
    return float(np.sqrt(np.mean(np.square(known)))) if known.size else math.nan


def _parts(heights: Array, sections: int) -> list[Array]:
    parts = [part for part in np.array_split(heights, sections) if np.isfinite(part).any()]
    if not parts:
        raise InputError("has no finite value: every point is missing", argument="heights")
    return parts
