"""How sure the headline numbers of a contact are: an interval for each, and what it comes from.

The certificate says how exactly the problem as stated is solved. It knows nothing of the grid,
of the rim of spots and of what the ceiling stands in for, which move the numbers far more; what is
known of these is gathered here. What the measurement left out of the map is not in it.

`uncertainty_intervals`: Grid: where the number lies on ever finer grids of the same heights,
`resolution_study.limits`. Rim, where there is no such study: pixels that the rim of a spot
crosses count in full; the lower end is `ContactResult.perimeter_corrected_area`. Edge: the largest
pressure of an elastic contact has no limit at an edge at which the map ends (r^-1/2, as of a flat
punch). Shorter waves: contact area and largest pressure of an elastic map that is rough down to
its pixel, which is where they change by 5 % or more from twice its pixel to its own, have none
either; how far they would go is not known. Yielding: `ceiling.area_change`, give or take what the
calibrated ceiling was wrong by on contacts of this kind; known of the contact area alone, no
cause below first yield or where no strength is known. Tolerance: the certificate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

import numpy as np

from roughcontact.contact import plausibility
from roughcontact.contact.ceiling import area_change
from roughcontact.contact.result import ContactResult, Regime
from roughcontact.studies.resolution_study import STEADY, ResolutionStudy

# What the change of one sphere is wrong by itself, beside what the rule is.
_ONE_SPHERE = 0.02

# Factor of safety of two grids of first order (Roache 1994).
_TWO_GRIDS = 3.0

# Numbers of an elastic contact that each shorter wave moves on, and what tells so.
_WITHOUT_LIMIT = {"contact_fraction": "corrected_fraction", "max_pressure": "max_pressure"}

# Parts of the map, at most all of it; and lengths below which a gap is closed [m].
_SHARES = ("contact_fraction", "saturated_fraction")
_CLOSED = 1e-12

QUANTITIES = ("max_pressure", "contact_fraction", "saturated_fraction", "mean_gap", "approach")
"""Names of the numbers that get an interval."""


class Cause(StrEnum):
    """What moves a number away from that of the real contact of the map as measured."""

    RIM = "rim of the spots"
    GRID = "grid"
    EDGE = "edge of the map"
    WAVES = "shorter waves"
    YIELDING = "ceiling against plasticity of the volume"
    MAPS = "scatter of the maps"
    TOLERANCE = "tolerance"


@dataclass(frozen=True)
class ErrorSource:
    """How far one cause may move a number."""

    cause: Cause  # The cause
    low: float  # Relative change, at most 0
    high: float  # Relative change, at least 0

    @property
    def known(self) -> bool:
        """Whether it can be bounded with what there is."""
        return not math.isnan(self.low)


@dataclass(frozen=True)
class Interval:
    """A number and where it lies as far as is known."""

    name: str  # One of `QUANTITIES`
    value: float  # The number of the result [SI]
    doubts: tuple[ErrorSource, ...]  # What moves it

    @property
    def low(self) -> float:
        """Lower end [SI]."""
        return self.value * math.prod(max(1 + d.low, 0.0) for d in self.doubts if d.known)

    @property
    def high(self) -> float:
        """Upper end [SI], of a share at most 1; infinite where there is none."""
        high = self.value * math.prod(1 + d.high for d in self.doubts if d.known)
        return min(high, 1.0) if self.name in _SHARES and math.isfinite(high) else high

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


def uncertainty_intervals(
    result: ContactResult, study: ResolutionStudy | None = None
) -> tuple[Interval, ...]:
    """Return how sure the headline numbers of a result are."""
    yields = result.regime not in (Regime.BELOW_FIRST_YIELD, Regime.UNKNOWN)
    answer = []
    for name in QUANTITIES:
        value = float(getattr(result, name))
        if name == result.control or not (math.isfinite(value) and value):
            continue
        if name == "mean_gap" and value < _CLOSED:
            continue
        grid = _grid(name, result, study)
        doubts = [*grid, ErrorSource(Cause.TOLERANCE, -result.certificate, result.certificate)]
        if yields:
            doubts.insert(0, _yielding(name, result))
        if name == "contact_fraction" and not grid[0].known:
            doubts.insert(0, _rim(result))
        answer.append(Interval(name, value, tuple(_possible(item, name, value) for item in doubts)))
    return tuple(answer)


def _possible(doubt: ErrorSource, name: str, value: float) -> ErrorSource:
    """Return an error within what a number can be: none is negative, no share above 1."""
    high = doubt.high
    if name in _SHARES and math.isfinite(high):
        high = min(high, max(1 / value - 1, 0.0))
    # NaN stays, since it comes first.
    return replace(doubt, low=max(doubt.low, -1.0), high=high)


def of_joint(
    name: str, value: float, contact: ContactResult, coarser: float, calibrated: tuple[float, float]
) -> Interval:
    """Return the interval of what a joint does, from two more solutions of its contact.

    ``coarser`` is its relative change on twice the pixel, ``calibrated`` its own and that of the
    contact area under the calibrated ceiling; NaN where that is not known. Two grids give three
    times their difference to either side (Roache 1994). The error of the calibrated ceiling is
    that of the area, times the change of the number over that of the area.
    """
    doubts = [ErrorSource(Cause.GRID, -_TWO_GRIDS * abs(coarser), _TWO_GRIDS * abs(coarser))]
    if contact.regime not in (Regime.BELOW_FIRST_YIELD, Regime.UNKNOWN):
        change, area = calibrated
        rate = abs(math.log1p(change) / math.log1p(area)) if change > -1 and area else math.nan
        error = rate * (plausibility.shown_error(contact) + _ONE_SPHERE) * (1 + change)
        doubts.insert(0, ErrorSource(Cause.YIELDING, *_around(change, error)))
    return Interval(name, value, tuple(_possible(doubt, name, value) for doubt in doubts))


def _rim(result: ContactResult) -> ErrorSource:
    if result.pair.is_profile:
        # A segment has up to one point more than its length: 0.35 in the mean under a cylinder.
        points = result.totals.contact
        return ErrorSource(Cause.RIM, -min(result.spots().count / points, 1.0), 0.0)
    return ErrorSource(Cause.RIM, result.perimeter_corrected_area / result.contact_area - 1, 0.0)


def _yielding(name: str, result: ContactResult) -> ErrorSource:
    advice = plausibility.advice(result) if name == "contact_fraction" else None
    if advice is None or isinstance(result.ceiling, np.ndarray):
        return ErrorSource(Cause.YIELDING, math.nan, math.nan)
    change = area_change(advice, result.ceiling, result.contact_modulus)
    error = plausibility.shown_error(result) + _ONE_SPHERE
    # Both NaN where the rule was never tried.
    low, high = _around(change, error * (1 + change))
    return ErrorSource(Cause.YIELDING, low, high)


def _around(change: float, error: float) -> tuple[float, float]:
    """Return how far a value may move that changes by so much, give or take an error."""
    if math.isnan(change + error):
        return math.nan, math.nan
    return min(0.0, change - error), max(0.0, change + error)


def _grid(name: str, result: ContactResult, study: ResolutionStudy | None) -> list[ErrorSource]:
    """Return what the grid, and what is below it, may move."""
    value = float(getattr(result, name))
    elastic = result.ceiling is None
    at_edge = elastic and result.totals.edge_load is not None
    if name == "max_pressure" and (at_edge or (study is not None and study.at_edge)):
        return [ErrorSource(Cause.EDGE, 0.0, math.inf)]
    if study is None:
        return [ErrorSource(Cause.GRID, math.nan, math.nan)]
    low, high = study.limits(name)
    if name == "max_pressure" and result.ceiling is not None:
        high = min(high, float(np.max(result.ceiling)))
    ends = sorted((low / value - 1, high / value - 1))
    # NaN stays, since it comes first.
    answer = [ErrorSource(Cause.GRID, min(ends[0], 0.0), max(ends[1], 0.0))]
    if elastic and name in _WITHOUT_LIMIT and _rough(_WITHOUT_LIMIT[name], study):
        answer.append(ErrorSource(Cause.WAVES, math.nan, math.nan))
    return answer


def _rough(name: str, study: ResolutionStudy) -> bool:
    """Return whether a number changes from twice the pixel of the map to its own."""
    coarser = sum(grid.value > 1 for grid in study.grids)
    return 0 < coarser < len(study.grids) and abs(study.changes(name)[coarser - 1]) >= STEADY
