"""How far the law of an interface can be trusted: what its maps resolve, and whether they do."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughcontact.contact.cautions import Caution, Kind, careful, noted, warned
from roughcontact.errors import Mention
from roughcontact.joint.law_curve import ERROR, Curve
from roughcontact.units import counted, engineering, percent

Array = NDArray[np.float64]

LEAST_SPOTS = 10
"""Contact spots below which the law is that of a few summits, and another map has another."""

LEAST_POINTS = 100
"""Points in contact, and points open, below which the pixel makes them."""

MOST_CONTACT = 0.9
"""Contact fraction above which what stays open is the narrowest dales, which the pixel cuts."""

# Whole and parts that agree to this part of the pressure are alike.
_ALIKE = 0.05
# Maps below which an interval is some ten times the standard error.
_FEW = 3

SPOTS, POINTS, CONTACT, SLOPE = "spots", "points", "contact", "slope"


@dataclass(frozen=True)
class Resolved:
    """The range of nominal pressures that maps resolve.

    Parameters
    ----------
    low, high : float
        Its ends [Pa]; NaN where no pressure is resolved.
    low_by, high_by : str
        What ends it: ``"spots"``, too few of them; ``"points"``, too few in contact, or open;
        ``"contact"``, more than `MOST_CONTACT`; ``"slope"``, a pressure beyond E* h'/2, the scatter
        of that of full contact, where the steepest and so the shortest waves carry; empty where the
        pressures end before the range does.
    """

    low: float
    high: float
    low_by: str = ""
    high_by: str = ""


def resolved(pressures: Array, means: Mapping[str, Array], scatter: float) -> Resolved:
    """Return the range of pressures that maps resolve.

    Parameters
    ----------
    pressures : ndarray, shape (n,)
        Nominal pressures [Pa], ascending.
    means : mapping of str to ndarray, shape (n,)
        Mean ``spots``, ``contact_points``, ``open_points`` and ``contact_fraction`` of a map.
    scatter : float
        E* h'/2 [Pa].

    Returns
    -------
    Resolved
        The range.
    """
    from_below = (
        (SPOTS, means["spots"] >= LEAST_SPOTS), (POINTS, means["contact_points"] >= LEAST_POINTS)
    )  # fmt: skip
    from_above = (
        (CONTACT, means["contact_fraction"] <= MOST_CONTACT),
        (POINTS, means["open_points"] >= LEAST_POINTS),
        (SLOPE, pressures <= scatter),
    )
    # Where the contact closes, its spots become one again: the first pressure with enough counts.
    first = [
        (int(np.argmax(good)) if good.any() else pressures.size, by) for by, good in from_below
    ]
    last = [(int(good.sum()) - 1, by) for by, good in from_above]
    (low, low_by), (high, high_by) = max(first), min(last)
    if low > high:
        return Resolved(math.nan, math.nan, low_by if low else "", high_by)
    return Resolved(
        float(pressures[low]),
        float(pressures[high]),
        low_by if low else "",
        high_by if high < pressures.size - 1 else "",
    )


WHY = {
    SPOTS: f"below it there are fewer than {LEAST_SPOTS} contact spots, and the law is that of a "
    "few summits",
    POINTS: f"beyond it fewer than {LEAST_POINTS} points touch, or are open",
    CONTACT: f"above it more than {100 * MOST_CONTACT:.0f} % touch, and what stays open are the "
    "narrowest dales, which the pixel cuts",
    SLOPE: "above it the pressure exceeds E* h'/2, and the steepest waves carry, which the pixel "
    "cuts",
}


SMOOTH = noted(
    Kind.SMOOTH,
    "the counter-face is smooth: of two rough faces give the other one, too, as ",
    Mention("counter_surface"),
)


def cautions(
    maps: int, pressures: Array, found: Resolved, rim: float, error: float
) -> Iterator[Caution]:
    """Yield what number of maps, range, rim and distance of the pressures give cause for."""
    if error > ERROR:
        yield careful(
            Kind.STEPS,
            f"between the pressures that were solved the law is known to about {percent(error)} "
            "alone, and so are the tables for other programs: give more of them, ",
            Mention("steps"),
            error=error,
        )
    if math.isnan(found.low):
        yield warned(
            Kind.RANGE,
            "the maps resolve the law at none of the pressures: they are too small, or the "
            "pressures too low or too high",
        )
    elif found.low_by or found.high_by:
        ends = f"{engineering(found.low, 'Pa', 3)} to {engineering(found.high, 'Pa', 3)}"
        why = "; ".join(WHY[by] for by in dict.fromkeys((found.low_by, found.high_by)) if by)
        yield careful(
            Kind.RANGE,
            f"the maps resolve the law from {ends}, of {engineering(float(pressures[0]), 'Pa', 3)} "
            f"to {engineering(float(pressures[-1]), 'Pa', 3)}: {why}",
            low=found.low,
            high=found.high,
        )
    if maps < _FEW:
        told = "one map alone tells no scatter" if maps == 1 else (
            "the interval of two maps is 13 standard errors to each side"
        )  # fmt: skip
        yield careful(Kind.FEW, f"{told}: give several maps of the surface", maps=maps)
    if rim:
        yield noted(
            Kind.RIM,
            f"a rim of {engineering(rim, 'm', 3)} along each free edge is left out; pressures are "
            "those inside it",
            rim=rim,
        )


def halved(whole: Curve, parts: Curve, error: Array, count: int, within: Resolved) -> Caution:
    """Return whether maps are large enough, from the law of their parts.

    Parameters
    ----------
    whole, parts : Curve
        Means of the maps and of their parts.
    error : ndarray, shape (n,)
        Half of the interval of the mean separation of the parts at its pressures [m].
    count : int
        Number of parts.
    within : Resolved
        Range of the maps, in which they are compared.

    Returns
    -------
    Caution
        By how much the pressure at the same separation differs, and by how much chance may.
    """
    low = max(within.low, parts.pressure[0])
    high = min(within.high, parts.pressure[-1])
    inside = (whole.pressure >= low) & (whole.pressure <= high)
    at = whole.pressure[inside]
    # A difference of separations as one of pressures, by the slope.
    slope = 1 / np.maximum(whole.slope[inside], 1e-300)
    off = np.abs(parts.separation_at(at) - whole.separation[inside]) * slope
    chance = np.interp(np.log(at), np.log(parts.pressure), error) * slope
    worst = int(np.argmax(off)) if off.size else 0
    numbers = {"off": float(off[worst]), "chance": float(chance[worst])} if off.size else {}
    if off.size and (off > np.maximum(_ALIKE, chance)).any():
        return careful(
            Kind.SCALING,
            f"{counted(count, 'part')} of the maps have another law: at the same separation their "
            f"pressure is up to {percent(float(off[worst]))} off, more than chance "
            f"({percent(float(chance[worst]))}) explains; the law depends on the size of the map, "
            "and a larger one would move it",
            **numbers,
        )
    told = percent(float(off[worst])) if off.size else "nothing"
    return noted(
        Kind.SCALING,
        f"{counted(count, 'part')} of the maps have the same law within {told} of the pressure and "
        "what chance explains: the maps are large enough for it",
        **numbers,
    )
