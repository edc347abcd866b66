"""What a study of the resolution found: which results depend on grid, filter and ceiling."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from roughcontact.contact.cautions import Caution, Kind, warned
from roughcontact.errors import InputError
from roughcontact.result import Result
from roughcontact.units import changed_by, engineering

STEADY = 0.05
"""Relative change from one grid to the next below which a quantity counts as independent of it."""

QUANTITIES = {
    "contact_fraction": "contact area",
    "corrected_fraction": "contact area without rim excess",
    "saturated_fraction": "saturated area",
    "max_pressure": "maximum pressure",
    "mean_pressure": "mean pressure",
}


# Not judged: both count from the highest point, which every finer grid finds higher.
_MOVED = ("approach", "mean_gap")

# Least and largest order of convergence that is believed; that of the contact area is one.
_ORDERS = (0.5, 1.0)

# Factors of safety, where three grids agree on an order and where they do not (Roache 1994).
_AGREED, _AT_ODDS = 1.25, 3.0

# Of the change before the last: two grids may agree by chance, and heights between the points of
# a map are made up; benchmarks/intervals.py counts how often intervals hold.
_BY_CHANCE = 0.2


@dataclass(frozen=True)
class Variant:
    """One of the solves of a study.

    Parameters
    ----------
    value : float
        Pixel over that of the map, cut-off [m], or ceiling over the yield strength.
    shape : (int, int)
        Grid points.
    pixel : (float, float)
        Pixel edges [m].
    contact_fraction : float
        Contact area over that of the map (`ContactResult.contact_fraction`).
    corrected_fraction : float
        The same without the excess of its rim (`ContactResult.corrected_contact_area`).
    saturated_fraction : float
        Saturated area over that of the map.
    max_pressure, mean_pressure : float
        Largest pressure, and load over contact area [Pa].
    approach, mean_gap : float
        Of the bodies, and of the open gap [m].
    certificate : float
        How exactly it is solved.
    """

    value: float
    shape: tuple[int, int]
    pixel: tuple[float, float]
    contact_fraction: float
    corrected_fraction: float
    saturated_fraction: float
    max_pressure: float
    mean_pressure: float
    approach: float
    mean_gap: float
    certificate: float


@dataclass(frozen=True, repr=False)
class ResolutionStudy(Result):
    """How far the results of a contact depend on grid, filter and ceiling.

    Parameters
    ----------
    grids : tuple of Variant
        The same load on coarser and finer grids, the coarsest first.
    cutoffs : tuple of Variant
        The map without waves shorter than a cut-off, the longest first.
    ceilings : tuple of Variant
        Ceilings of 2.8 to 3.2 yield strengths, or the same parts of another one; empty for an
        elastic contact or a ceiling that differs from pixel to pixel.
    at_ceiling : bool
        Whether the largest pressure is the ceiling on each of the three finest grids.
    at_edge : bool
        Whether the largest pressure has no limit: without a ceiling, contact reaches an edge at
        which the map ends, on the finest grid.
    notes : tuple of str
        Grids that were left out, and why.
    """

    grids: tuple[Variant, ...]
    cutoffs: tuple[Variant, ...]
    ceilings: tuple[Variant, ...]
    at_ceiling: bool
    at_edge: bool = False
    notes: tuple[str, ...] = ()

    def values(self, name: str) -> tuple[float, ...]:
        """Return a quantity on each grid, the coarsest first."""
        known = (*QUANTITIES, *_MOVED)
        if name not in known:
            raise InputError(
                f"must be one of {', '.join(known)}, got {name!r}", argument="name", value=name
            )
        return tuple(getattr(grid, name) for grid in self.grids)

    def changes(self, name: str) -> tuple[float, ...]:
        """Return the relative changes of a quantity from each grid to the next finer one."""
        return tuple(_change(old, new) for old, new in pairwise(self.values(name)))

    def limits(self, name: str) -> tuple[float, float]:
        """Return between which values a quantity lies on ever finer grids; see `limits`."""
        if self.at_edge and name == "max_pressure":
            return max(self.values(name)), math.inf
        return limits(self.values(name))

    def independent(self, name: str) -> bool:
        """Return whether a quantity no longer changes with the pixel.

        It must change by less than 5 % over the two finest steps: from twice the pixel of the map
        to its own, and from that to half of it. A largest pressure without a limit never is.
        """
        if self.at_edge and name == "max_pressure":
            return False
        return all(abs(change) < STEADY for change in self.changes(name)[-2:])

    @property
    def judged(self) -> tuple[str, ...]:
        """Names of the quantities that say whether the contact depends on the grid.

        A quantity that is nowhere other than zero says nothing, nor does the largest pressure
        where it is the ceiling or has no limit.
        """
        told = (name for name in QUANTITIES if any(self.values(name)))
        known = self.at_ceiling or self.at_edge
        return tuple(name for name in told if not (known and name == "max_pressure"))

    @property
    def cautions(self) -> tuple[Caution, ...]:
        """What a reader of the numbers of the map has to know, from this study."""
        unsteady = [name for name in self.judged if not self.independent(name)]
        if not unsteady:
            return ()
        changes = [
            f"{QUANTITIES[name]} {' and '.join(map(changed_by, self.changes(name)[-2:]))}"
            for name in unsteady
        ]
        return (
            warned(
                Kind.STUDY,
                "the study of the resolution says not converged: from twice the pixel of the map "
                f"to its own and to half of it results change by {100 * STEADY:.0f} % or more ("
                f"{'; '.join(changes)})",
                **{name: self.changes(name)[-1] for name in unsteady},
            ),
        )

    @property
    def sentences(self) -> tuple[str, ...]:
        """What the study says, in plain words."""
        names = [name for name in QUANTITIES if any(self.values(name))]
        judged = self.judged
        steady = [QUANTITIES[name] for name in judged if self.independent(name)]
        pixels = [engineering(max(grid.pixel), "m", 3) for grid in self.grids[-3:]]
        said = []
        if steady:
            said.append(
                f"Independent of the grid (less than {100 * STEADY:.0f} % change at each step over "
                f"pixels of {', '.join(pixels)}): {', '.join(steady)}."
            )
        for name in judged:
            if self.independent(name):
                continue
            steps = [
                f"{changed_by(change)} at {pixel}"
                for change, pixel in zip(self.changes(name)[-2:], pixels[1:], strict=True)
            ]
            said.append(
                f"Not converged: from a pixel of {pixels[0]} on the {QUANTITIES[name]} changes by "
                f"{', '.join(steps)}; it reflects the pixel size, and a finer measurement may give "
                "another value."
            )
        if self.at_ceiling:
            said.append(
                "The maximum pressure is the ceiling on these grids: that it does not change says "
                "nothing about the resolution."
            )
        if self.at_edge:
            said.append(
                "The maximum pressure has no limit: the contact is elastic and reaches an edge of "
                "the map."
            )
        if len(self.cutoffs) > 1:
            said.append(_span("Filtering", "the cut-off", self.cutoffs, judged, "m"))
        if len(self.ceilings) > 1:
            said.append(_span("Ceiling", "the factor", self.ceilings, names, ""))
        return (*said, *self.notes)

    def named(self) -> list[tuple[str, Variant]]:
        """Return every solve with what it is called."""
        names = [(f"pixel {engineering(max(v.pixel), 'm')}", v) for v in self.grids]
        names += [(f"S-filter {engineering(v.value, 'm')}", v) for v in self.cutoffs]
        return names + [(f"ceiling {v.value:.3g} × yield", v) for v in self.ceilings]


def limits(values: Sequence[float]) -> tuple[float, float]:
    """Return between which values a number lies in the limit, from its values on a few grids.

    Parameters
    ----------
    values : sequence of float
        On grids of half the pixel each, the coarsest first; the last four count, three at least.

    Returns
    -------
    (float, float)
        NaN of fewer than three values, infinite where changes of 5 % or more do not fall.

    Notes
    -----
    Grid convergence index. With the last change e, and p the logarithm to base 2 of the change
    before over it, within 0.5 and 1, the limit lies between the last value but one and
    e 1.25/(2ᵖ - 1) beyond the last; or 3 e to either side of the last where the two changes differ
    in sign or e is the larger one, if e is below 5 % or the change before them is larger. The
    interval is wider on either side by 20 % of the change that e is compared with, a margin of this
    package, set on maps that took no part in the count of benchmarks/intervals.py.

    References
    ----------
    Roache 1994, doi:10.1115/1.2910291

    Examples
    --------
    >>> limits([2.0, 1.5, 1.25])
    (0.8375, 1.6)
    >>> limits([1.0, 1.4, 2.0])
    (-inf, inf)
    """
    if len(values) < 3 or not all(map(math.isfinite, values)):
        return math.nan, math.nan
    changes = [new - old for old, new in pairwise(values[-4:])]
    last, before, size = values[-1], changes[-2], abs(changes[-1])
    if size < abs(before) and changes[-1] * before > 0:
        order = min(max(math.log2(abs(before) / size), _ORDERS[0]), _ORDERS[1])
        beyond = last + changes[-1] * _AGREED / (2**order - 1)
        ends = values[-2], beyond
    else:
        if size >= abs(before):
            before = changes[0]
        if size >= abs(before) and size > STEADY * abs(last):
            return -math.inf, math.inf
        ends = last - _AT_ODDS * size, last + _AT_ODDS * size
    margin = _BY_CHANCE * abs(before)
    return min(ends) - margin, max(ends) + margin


def _change(old: float, new: float) -> float:
    if old == new:
        return 0.0
    return new / old - 1 if old else math.inf


def _span(
    what: str, argument: str, variants: tuple[Variant, ...], names: Sequence[str], unit: str
) -> str:
    first, last = variants[0], variants[-1]
    ends = [engineering(v.value, unit) if unit else f"{v.value:.3g}" for v in (first, last)]
    parts = [
        f"{QUANTITIES[name]} {changed_by(_change(getattr(first, name), getattr(last, name)))}"
        for name in names
    ]
    return f"{what}: as {argument} goes from {ends[0]} to {ends[1]}: {', '.join(parts)}."
