"""Intervals of the main quantities of a contact, and their sources.

The certificate bounds the solver error of the problem as stated. It does not include the errors of
the grid, of the rim of spots and of the ceiling as a model of plasticity, which are far larger;
this module collects their bounds. The effect of the measurement is not included:
`measurement.uncertainty` adds it, in intervals of the same form.

`uncertainty_intervals`: Grid: limit of the quantity on ever finer grids of the same heights,
`resolution.limits`. Rim, without such a study: pixels crossed by the rim of a spot are counted
in full; the lower end is `ContactResult.perimeter_corrected_area`. Edge: the largest
pressure of an elastic contact has no limit at an edge at which the map ends (r^-1/2, as of a flat
punch). Shorter waves: contact area and largest pressure of an elastic map that is rough down to
its pixel (a change of 5 % or more from twice its pixel to its pixel) have no limit either; the
size of this error is unknown. Yielding: `ceiling.area_change`, plus or minus the error of the
calibrated ceiling on contacts of this type; known only for the contact area, no cause below first
yield or without a known strength; the solved change where both ceilings are solved. Tolerance: the
certificate.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import TYPE_CHECKING, Any

import numpy as np

from roughcontact.contact import hertz_comparison, plausibility
from roughcontact.contact.ceiling import coated_ceilings
from roughcontact.contact.result import ContactResult, Regime
from roughcontact.material.material import CEILING_FACTOR
from roughcontact.result import Result
from roughcontact.surface.surface import Surface
from roughcontact.uncertainty.resolution import STEADY_TOLERANCE, ResolutionStudy

if TYPE_CHECKING:
    from roughcontact.surface.instrument import Instrument

# Error of the single-sphere correction, in addition to the error of the calibrated ceiling.
_ONE_SPHERE = 0.02

# Safety factor for two grids of first order (Roache 1994).
_TWO_GRIDS = 3.0

# Quantities of an elastic contact without a limit for shorter waves, and their indicators.
_WITHOUT_LIMIT = {"contact_fraction": "corrected_fraction", "max_pressure": "max_pressure"}

# Gap below which the contact is closed [m].
_CLOSED = 1e-12

QUANTITIES = ("max_pressure", "contact_fraction", "saturated_fraction", "mean_gap", "approach")
"""Names of the quantities with an interval."""


class Cause(StrEnum):
    """Error source of a quantity, compared with the real contact."""

    RIM = "rim of the spots"
    GRID = "grid"
    EDGE = "edge of the map"
    WAVES = "shorter waves"
    YIELDING = "ceiling against plasticity of the volume"
    MAPS = "scatter of the maps"
    TOLERANCE = "tolerance"
    RESOLUTION = "resolution"
    TRANSFER = "shape of the transfer"
    TIP = "tip radius"
    NOISE = "noise"
    SHORT_WAVES = "short waves"
    SHORTEST_WAVE = "shortest wave"
    OTHER_MAPS = "finer maps"
    SUMMITS = "roughness of summits"
    CHANCE = "waves not measured"
    SAMPLE = "finite sample"
    MARKS = "marks and edges"
    VALLEYS = "valleys out of reach of the tip"
    CORRECTIONS = "difference of the two corrections"
    METHOD = "method"
    FORM = "choice of form"
    YOUNG = "Young's modulus"
    YIELD = "yield strength"


@dataclass(frozen=True)
class ErrorSource:
    """Error bounds of a quantity due to one cause."""

    cause: Cause  # Cause of the error
    low: float  # Relative change, at most 0
    high: float  # Relative change, at least 0

    @property
    def known(self) -> bool:
        """Whether the error is bounded."""
        return not math.isnan(self.low)


@dataclass(frozen=True)
class Interval:
    """Quantity with its interval, from all known errors.

    As measured, the interval is the worst case of all causes. Corrected, independent causes add in
    squares of logarithms: the coverage of the interval is 95 %.
    """

    name: str  # One of `QUANTITIES`, or of `measurement.NUMBERS`
    value: float  # Value [SI]; corrected if ``measured`` is given
    doubts: tuple[ErrorSource, ...]  # Error sources
    measured: float | None = None  # Value on the map as measured, if corrected [SI]

    @property
    def low(self) -> float:
        """Lower end [SI]."""
        return self.value * self._combined_factor(d.low for d in self.doubts if d.known)

    @property
    def high(self) -> float:
        """Upper end [SI], at most 1 for a share; infinite if there is no bound."""
        high = self.value * self._combined_factor(d.high for d in self.doubts if d.known)
        return min(high, 1.0) if self.name.endswith("fraction") and math.isfinite(high) else high

    def _combined_factor(self, changes: Iterable[float]) -> float:
        factors = [max(1 + change, 0.0) for change in changes]
        if self.measured is None:
            return math.prod(factors)
        logarithms = [math.log(factor) for factor in factors]
        return math.exp(math.copysign(math.hypot(*logarithms), sum(logarithms)))

    @property
    def unknown(self) -> tuple[Cause, ...]:
        """Causes of unknown size, which the interval does not include."""
        return tuple(doubt.cause for doubt in self.doubts if not doubt.known)

    @property
    def budget(self) -> dict[str, float]:
        """Share of each known cause in the sum of squares, the largest first."""
        squares = {
            str(d.cause): math.log((1 + d.high) / (1 + d.low)) ** 2
            for d in self.doubts
            if d.known and d.low > -1 and d.low < d.high < math.inf
        }
        ordered = sorted(squares.items(), key=lambda item: -item[1])
        return {cause: square / sum(squares.values()) for cause, square in ordered}

    def summary(self) -> dict[str, Any]:
        """Return the interval ready for JSON: ends, and effect and share of each cause."""
        return {
            "value": self.value,
            "measured": self.value if self.measured is None else self.measured,
            "low": self.low,
            "high": self.high,
            "causes": {str(d.cause): [d.low, d.high] if d.known else None for d in self.doubts},
            "budget": self.budget,
        }


@dataclass(frozen=True, repr=False)
class Uncertainty(Result):
    """Intervals of the quantities of a contact, and their sources.

    Parameters
    ----------
    intervals : tuple of Interval
        One interval for each quantity.
    closing : dict
        Sum of the variances of the sources over the variance of the draws, by quantity.
    instrument : Instrument or None
        Instrument of the map; without one the intervals include only grid and material.
    shortest_wave : float or None
        Given shortest wave of the surface [m].
    resolved : float
        Shortest wave resolved by the maps [m].
    draws, seed : int
        Number of draws, and the seed.
    remarks : tuple of str
        Limits of the intervals, one sentence each.
    surface : Surface or None
        The corrected map: one draw of the surface behind it. None when read from a file.
    """

    intervals: tuple[Interval, ...]
    closing: Mapping[str, float] = field(hash=False)
    instrument: Instrument | None
    shortest_wave: float | None
    resolved: float
    draws: int
    seed: int
    remarks: tuple[str, ...]
    surface: Surface | None = field(default=None, compare=False)

    def interval(self, name: str) -> Interval | None:
        """Return the interval of a quantity; None if there is none."""
        return next((item for item in self.intervals if item.name == name), None)


def from_summary(record: Mapping[str, Any]) -> Uncertainty:
    """Return the `Uncertainty` of a summary."""
    from roughcontact.surface.instrument import Instrument

    intervals = tuple(
        Interval(
            name,
            interval["value"],
            tuple(ErrorSource(Cause(cause), *ends) for cause, ends in interval["causes"].items()),
            interval["measured"],
        )
        for name, interval in record["intervals"].items()
    )
    tool = record["instrument"]
    closing = {
        name: math.nan if ratio is None else ratio for name, ratio in record["closing"].items()
    }
    return Uncertainty(
        intervals,
        closing,
        tool and Instrument(**tool),
        record["shortest_wave"],
        record["resolved"],
        record["draws"],
        record["seed"],
        tuple(record["remarks"]),
    )


def uncertainty_intervals(
    result: ContactResult, study: ResolutionStudy | None = None
) -> tuple[Interval, ...]:
    """Return the intervals of the main quantities; corrected ones if the result has them."""
    if result.measurement is not None:
        intervals: tuple[Interval, ...] = result.measurement.intervals
        return intervals
    answer = []
    for name in QUANTITIES:
        value = float(getattr(result, name))
        if name == result.control or not (math.isfinite(value) and value):
            continue
        if name == "mean_gap" and value < _CLOSED:
            continue
        grid = _grid(name, result, study)
        doubts = [*grid, ErrorSource(Cause.TOLERANCE, -result.certificate, result.certificate)]
        if (volume := volume_plasticity(name, result)) is not None:
            doubts.insert(0, volume)
        if name == "contact_fraction" and not grid[0].known:
            doubts.insert(0, _rim(result))
        answer.append(Interval(name, value, tuple(_possible(item, name, value) for item in doubts)))
    return tuple(answer)


def _possible(doubt: ErrorSource, name: str, value: float) -> ErrorSource:
    """Return an error limited to possible values: no negative value, no share above 1."""
    high = doubt.high
    if name.endswith("fraction") and math.isfinite(high):
        high = min(high, max(1 / value - 1, 0.0))
    # `max` returns its first argument if this is NaN.
    return replace(doubt, low=max(doubt.low, -1.0), high=high)


def joint_interval(
    name: str, value: float, contact: ContactResult, coarser: float, calibrated: tuple[float, float]
) -> Interval:
    """Return the interval of a joint quantity, from two further solutions of its contact.

    ``coarser`` is its relative change on twice the pixel, ``calibrated`` the relative changes of
    the quantity and of the contact area under the other ceiling; NaN if unknown. Two grids
    give three times their difference to either side (Roache 1994). The error of the calibrated
    ceiling is the error of the area, times the change of the quantity over the change of the area.
    Where that ceiling was not tested, the area has the bounds that it has without it.
    """
    doubts = [ErrorSource(Cause.GRID, -_TWO_GRIDS * abs(coarser), _TWO_GRIDS * abs(coarser))]
    if contact.regime not in (Regime.BELOW_FIRST_YIELD, Regime.UNKNOWN):
        change, area = calibrated
        power = math.log1p(change) / math.log1p(area) if change > -1 and area else math.nan
        # A calibrated contact is compared with three yield strengths for the power alone.
        change = change if contact.calibration is None else 0.0
        shown = plausibility.shown_error(contact)
        if math.isnan(shown):
            ends = [math.expm1(power * math.log1p(end)) for end in _area_bounds(contact)]
            # Unlike `min`, NumPy keeps NaN.
            bounds = float(np.min([0.0, change, *ends])), float(np.max([0.0, change, *ends]))
        else:
            bounds = _change_bounds(change, abs(power) * (shown + _ONE_SPHERE) * (1 + change))
        doubts.insert(0, ErrorSource(Cause.YIELDING, *bounds))
    return Interval(name, value, tuple(_possible(doubt, name, value) for doubt in doubts))


def _rim(result: ContactResult) -> ErrorSource:
    if result.pair.is_profile:
        # A segment exceeds its length by up to one point: 0.35 on average under a cylinder.
        points = result.totals.contact
        return ErrorSource(Cause.RIM, -min(result.spots().count / points, 1.0), 0.0)
    return ErrorSource(Cause.RIM, result.perimeter_corrected_area / result.contact_area - 1, 0.0)


def volume_plasticity(name: str, result: ContactResult) -> ErrorSource | None:
    """Return the error due to plasticity of the volume; None below first yield."""
    limits = coated_ceilings(result.pair).values() if result.pair.is_coated else ()
    if result.ceiling is None and limits and result.max_pressure > min(limits):
        return ErrorSource(Cause.YIELDING, math.nan, math.nan)
    if result.regime in (Regime.BELOW_FIRST_YIELD, Regime.UNKNOWN) and not (
        result.pair.is_coated and result.ceiling is not None
    ):
        return None
    other = result.calibrated
    if other is not None and other.is_of_base and hasattr(other, name):
        # The ceiling of a coated body is between those of its coating and its base.
        change = getattr(other, name) / getattr(result, name) - 1
        return ErrorSource(Cause.YIELDING, min(change, 0.0), max(change, 0.0))
    if name != "contact_fraction" or isinstance(result.ceiling, np.ndarray):
        return ErrorSource(Cause.YIELDING, math.nan, math.nan)
    advice = plausibility.recommended_ceiling_of(result)
    # NaN outside the range of the calibration.
    error = math.nan if advice is None else plausibility.shown_error(result) + _ONE_SPHERE
    if advice is None or math.isnan(error):
        return ErrorSource(Cause.YIELDING, *_area_bounds(result))
    if other is not None and result.calibration is None:
        # The rule of separate spheres overstates the change of spots that merge.
        change = other.contact_area / result.contact_area - 1
    else:
        change = plausibility.calibrated_area_change(result, advice)
    return ErrorSource(Cause.YIELDING, *_change_bounds(change, error * (1 + change)))


def _area_bounds(result: ContactResult) -> tuple[float, float]:
    """Return the error bounds of the contact area without a calibrated ceiling.

    The plateau of a yielding spot is between the peak pressure at first yield p_y and the ceiling
    of full plasticity. Under the ceiling p_y the excess of the pressure over p_y is carried by
    additional area: at most the excess load over p_y, for one sphere or cylinder of any load.
    """
    pair, softer = result.pair, result.pair.softer
    if softer is None or softer.ceiling is None or softer.poisson < 0:
        return math.nan, math.nan
    # The strength of a body with only a hardness is a third of it or more (Tabor 1951).
    weak = replace(softer, yield_strength=softer.yield_strength or softer.ceiling / CEILING_FACTOR)
    known = (pair.yields_at(body) for body in (weak, pair.first_to_yield) if body is not None)
    first = min(pressure for pressure in known if pressure is not None)
    excess = float(np.sum(np.maximum(result.pressure - first, 0.0), dtype=np.float64))
    high = excess * result.pixel_area / first / result.contact_area + _ONE_SPHERE
    largest = max(softer.ceiling, softer.hardness or 0.0)
    share = result.saturated_fraction / result.contact_fraction
    return -share * max(1 - float(result.ceiling or math.inf) / largest, 0.0), high


def _change_bounds(change: float, error: float) -> tuple[float, float]:
    """Return the error bounds of a change that is known within plus or minus an error."""
    if math.isnan(change + error):
        return math.nan, math.nan
    return min(0.0, change - error), max(0.0, change + error)


def _grid(name: str, result: ContactResult, study: ResolutionStudy | None) -> list[ErrorSource]:
    """Return the error bounds of the grid and of scales below the grid."""
    value = float(getattr(result, name))
    elastic = result.ceiling is None
    at_edge = elastic and result.totals.edge_load is not None
    if name == "max_pressure" and (at_edge or (study is not None and study.at_edge)):
        return [ErrorSource(Cause.EDGE, 0.0, math.inf)]
    smooth = _smooth_value(name, result)
    if study is None:
        if smooth is not None:
            change = smooth / value - 1
            return [ErrorSource(Cause.GRID, min(change, 0.0), max(change, 0.0))]
        return [ErrorSource(Cause.GRID, math.nan, math.nan)]
    low, high = study.limits(name)
    if name == "max_pressure" and result.ceiling is not None:
        high = min(high, float(np.max(result.ceiling)))
    limits = (low, high) if smooth is None else (low, high, smooth)
    ends = sorted(limit / value - 1 for limit in limits)
    # `min` and `max` return their first argument if this is NaN.
    answer = [ErrorSource(Cause.GRID, min(ends[0], 0.0), max(ends[-1], 0.0))]
    if elastic and name in _WITHOUT_LIMIT and _rough(_WITHOUT_LIMIT[name], study):
        answer.append(ErrorSource(Cause.WAVES, math.nan, math.nan))
    return answer


def _smooth_value(name: str, result: ContactResult) -> float | None:
    """Return the value of Hertz's theory, which a smooth contact has on fine grids."""
    smooth = hertz_comparison.smooth_reference(result)
    if smooth is None:
        return None
    return {
        "contact_fraction": smooth.area / result.nominal_area,
        "max_pressure": smooth.max_pressure,
        "approach": smooth.approach,
    }.get(name)


def _rough(name: str, study: ResolutionStudy) -> bool:
    """Return whether a quantity changes from twice the pixel of the map to its pixel."""
    coarser = sum(grid.value > 1 for grid in study.grids)
    return (
        0 < coarser < len(study.grids) and abs(study.changes(name)[coarser - 1]) >= STEADY_TOLERANCE
    )
