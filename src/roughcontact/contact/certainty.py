"""How sure the headline numbers of a contact are: an interval for each, and what it comes from.

The certificate says how exactly the problem as stated is solved. It knows nothing of the pixel,
of the rim of spots and of what the ceiling stands in for, which move the numbers far more; what is
known of these is gathered here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

import numpy as np

from roughcontact.contact import judgment
from roughcontact.contact.ceiling import area_change
from roughcontact.contact.result import ContactResult, Regime
from roughcontact.contact.study import ResolutionStudy
from roughcontact.material.material import softer

# What the change of one sphere is wrong by itself, beside what the rule is.
_ONE_SPHERE = 0.02

QUANTITIES = ("max_pressure", "contact_fraction", "saturated_fraction", "mean_gap", "approach")
"""Names of the numbers that get an interval."""


class Cause(StrEnum):
    """What moves a number away from that of the real contact."""

    RIM = "rim of the spots"
    PIXEL = "pixel"
    YIELDING = "ceiling against plasticity of the volume"
    TOLERANCE = "tolerance"


@dataclass(frozen=True)
class Doubt:
    """How far one cause may move a number.

    Parameters
    ----------
    cause : Cause
        The cause.
    low, high : float
        Relative changes, ``low ≤ 0 ≤ high``; NaN where they are not known.
    """

    cause: Cause
    low: float
    high: float

    @property
    def known(self) -> bool:
        """Whether it can be bounded with what there is."""
        return not math.isnan(self.low)


@dataclass(frozen=True)
class Interval:
    """A number and where it lies as far as is known.

    Parameters
    ----------
    name : str
        One of `QUANTITIES`.
    value : float
        The number of the result [SI].
    doubts : tuple of Doubt
        What moves it; one after the other, so that large changes never leave less than nothing.
    """

    name: str
    value: float
    doubts: tuple[Doubt, ...]

    @property
    def low(self) -> float:
        """Lower end [SI]."""
        return self.value * math.prod(max(1 + d.low, 0.0) for d in self.doubts if d.known)

    @property
    def high(self) -> float:
        """Upper end [SI]."""
        return self.value * math.prod(1 + d.high for d in self.doubts if d.known)

    @property
    def unknown(self) -> tuple[Cause, ...]:
        """Causes that are not in the interval, since nothing is known of their size."""
        return tuple(doubt.cause for doubt in self.doubts if not doubt.known)

    def summary(self) -> dict[str, Any]:
        """Return it ready for JSON: ends, and what each cause is known to do."""
        return {
            "low": self.low,
            "high": self.high,
            "causes": {str(d.cause): [d.low, d.high] if d.known else None for d in self.doubts},
        }


def intervals(result: ContactResult, study: ResolutionStudy | None = None) -> tuple[Interval, ...]:
    """Return how sure the headline numbers of a result are.

    Parameters
    ----------
    result : ContactResult
        A solution.
    study : ResolutionStudy, optional
        The same contact on other grids. Without one the pixel is an unknown cause.

    Returns
    -------
    tuple of Interval
        One for each of `QUANTITIES` that was not given and is not zero.

    Notes
    -----
    Rim: pixels that the rim of a spot crosses count in full; the lower end is
    `ContactResult.corrected_contact_area`. Pixel: the change from the pixel of the map to half of
    it, which is the error of the grid, and that from twice the pixel to the pixel, taken as what
    a measurement twice as fine would change once more. Yielding: `ceiling.area_change`, give or
    take what the recommended ceiling was wrong by on contacts of this kind, and as far as the
    hardness as a ceiling where it is at odds with the yield strength; known of the contact area
    alone, no cause below first yield or where no strength is known. Tolerance: the
    certificate.
    """
    yields = result.regime not in (Regime.BELOW_FIRST_YIELD, Regime.UNKNOWN)
    found = []
    for name in QUANTITIES:
        value = float(getattr(result, name))
        if name == result.control or not (math.isfinite(value) and value):
            continue
        doubts = [
            _pixel(name, study),
            Doubt(Cause.TOLERANCE, -result.certificate, result.certificate),
        ]
        if yields:
            doubts.insert(0, _yielding(name, result))
        if name == "contact_fraction":
            doubts.insert(0, _rim(result))
        found.append(Interval(name, value, tuple(doubts)))
    return tuple(found)


def _rim(result: ContactResult) -> Doubt:
    if result.pair.is_profile:
        # A segment has up to one point more than its length: 0.35 in the mean under a cylinder.
        points = int(np.count_nonzero(result.contact))
        return Doubt(Cause.RIM, -min(result.spots().count / points, 1.0), 0.0)
    return Doubt(Cause.RIM, result.corrected_contact_area / result.contact_area - 1, 0.0)


def _yielding(name: str, result: ContactResult) -> Doubt:
    advice = judgment.advice(result) if name == "contact_fraction" else None
    if advice is None or isinstance(result.ceiling, np.ndarray):
        return Doubt(Cause.YIELDING, math.nan, math.nan)
    change = area_change(advice, result.ceiling, result.contact_modulus)
    error = judgment.shown_error(result) + _ONE_SPHERE
    # Both NaN where the rule was never tried.
    low, high = _around(change, error * (1 + change))
    body = softer(result.material, result.counter_material)
    if body is not None and body.hardness is not None and body.at_odds is not None:
        # The rule knows the yield strength alone; where flow is full the hardness is borne.
        full = replace(advice, ceiling=body.hardness)
        reached = area_change(full, result.ceiling, result.contact_modulus)
        low, high = min(low, reached), max(high, reached)
    return Doubt(Cause.YIELDING, low, high)


def _around(change: float, error: float) -> tuple[float, float]:
    """Return how far a value may move that changes by so much, give or take an error."""
    if math.isnan(change + error):
        return math.nan, math.nan
    return min(0.0, change - error), max(0.0, change + error)


def _pixel(name: str, study: ResolutionStudy | None) -> Doubt:
    changes = () if study is None else study.changes(name)[-2:]
    if len(changes) < 2 or not all(map(math.isfinite, changes)):
        return Doubt(Cause.PIXEL, math.nan, math.nan)
    return Doubt(Cause.PIXEL, min(0.0, *changes), max(0.0, *changes))
