"""What a study of the resolution found: which results depend on grid, filter and ceiling."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from roughcontact.contact.cautions import Caution, Kind, warned
from roughcontact.errors import InputError
from roughcontact.shown import Shown
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
class ResolutionStudy(Shown):
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
    notes : tuple of str
        Grids that were left out, and why.
    """

    grids: tuple[Variant, ...]
    cutoffs: tuple[Variant, ...]
    ceilings: tuple[Variant, ...]
    at_ceiling: bool
    notes: tuple[str, ...] = ()

    def changes(self, name: str) -> tuple[float, ...]:
        """Return the relative changes of a quantity from each grid to the next finer one."""
        known = (*QUANTITIES, *_MOVED)
        if name not in known:
            raise InputError(
                f"must be one of {', '.join(known)}, got {name!r}", argument="name", value=name
            )
        values = [getattr(grid, name) for grid in self.grids]
        return tuple(_change(old, new) for old, new in pairwise(values))

    def independent(self, name: str) -> bool:
        """Return whether a quantity no longer changes with the pixel.

        It must change by less than 5 % over the two finest steps: from twice the pixel of the map
        to its own, and from that to half of it.
        """
        return all(abs(change) < STEADY for change in self.changes(name)[-2:])

    @property
    def judged(self) -> tuple[str, ...]:
        """Names of the quantities that say whether the contact depends on the grid.

        A quantity that is nowhere other than zero says nothing, nor does the largest pressure
        where it is the ceiling.
        """
        told = (name for name in QUANTITIES if any(getattr(grid, name) for grid in self.grids))
        return tuple(name for name in told if not (self.at_ceiling and name == "max_pressure"))

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
        names = [name for name in QUANTITIES if any(getattr(grid, name) for grid in self.grids)]
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

    def summary(self) -> dict[str, Any]:
        """Return the study by name, in SI units, ready for JSON."""
        from roughcontact.report import results

        return results.summary(self)


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
