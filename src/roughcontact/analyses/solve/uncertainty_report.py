"""Report of the uncertainty of the main quantities."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from roughcontact._tools.statistics import Mean
from roughcontact.analyses.solve import fields as contact_fields
from roughcontact.contact.result import ContactResult
from roughcontact.drawing import style
from roughcontact.errors import ArgumentRef, Sentence
from roughcontact.report import page
from roughcontact.report.kind import Column, Quantity, capitalize_first, quantity_of
from roughcontact.report.phrases import format_share, format_short, range_text
from roughcontact.report.presentation import Presentation
from roughcontact.uncertainty import intervals as uncertainty
from roughcontact.uncertainty.intervals import Cause, ErrorSource, Interval, Uncertainty
from roughcontact.uncertainty.resolution import QUANTITIES, ResolutionStudy
from roughcontact.units import format_change, format_engineering, format_percent, join_ends

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def uncertainty_budget(rows: Sequence[tuple[str, Mapping[str, float]]]) -> Figure:
    """Draw one bar per quantity, with the share of each source in its squared interval."""
    figure, axes = style.panels(7.2, 1.6 + 0.35 * len(rows))
    sources = list(dict.fromkeys(source for _, budget in rows for source in budget))
    left = np.zeros(len(rows))
    for number, source in enumerate(sources):
        shares = np.array([100 * budget.get(source, 0.0) for _, budget in rows])
        axes.barh(
            range(len(rows)),
            shares,
            left=left,
            color=style.SERIES[number % len(style.SERIES)],
            label=source,
            hatch="///" if number >= len(style.SERIES) else None,
            edgecolor="white",
            height=0.7,
        )
        left += shares
    axes.set_yticks(range(len(rows)), [name for name, _ in rows], fontsize=style.TICK)
    axes.invert_yaxis()
    axes.set_xlim(0, 100)
    style.name_axes(axes, "share of the squared interval [%]")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=style.NOTE, frameon=False)
    return figure


STUDY = (
    Quantity("grids"),
    Quantity("cutoffs"),
    Quantity("ceilings"),
    Quantity("independent", of=lambda s: {name: s.independent(name) for name in QUANTITIES}),
    Quantity("at_ceiling"),
    Quantity("sentences"),
)
"""Quantities of a `ResolutionStudy`."""


def _case(key: str, label: str, **more: Any) -> Column:
    """Return the column of a quantity of each solve of a study."""
    return Column(
        key, label, of=lambda s: [getattr(case, key) for _, case in s.labeled_variants()], **more
    )


STUDY_COLUMNS = (
    Column("case", "case", of=lambda study: [name for name, _ in study.labeled_variants()]),
    _case("contact_fraction", "contact", form=format_percent),
    _case("corrected_fraction", "perimeter-corrected", form=format_percent),
    _case("saturated_fraction", "saturated", form=format_percent),
    _case("max_pressure", "largest pressure [Pa]"),
    _case("mean_pressure", "mean pressure [Pa]"),
)
"""Columns of the solves of a `ResolutionStudy`."""


class StudyPresentation(Presentation):
    """Presentation of a resolution study; the report on its contact has the references."""

    result: ResolutionStudy
    table = STUDY
    columns = STUDY_COLUMNS

    def answer(self) -> str:
        """Return the main sentence of the study."""
        return "".join(self.result.sentences[:1])


NOT_INCLUDED = (
    "Not included: another place on the part, another part. Measure at least three maps for these."
)

_MORE = (
    Quantity("stiffness", "stiffness [N/m]"),
    Quantity("constriction_length", "constriction length [m]"),
)

# Smaller changes and shares are negligible compared with the others.
_MIN_VISIBLE_CHANGE = 5e-4
_SHOWN_SHARE = 0.05


def uncertainty_rows(
    result: ContactResult, study: ResolutionStudy | None = None
) -> list[tuple[str, str, str]]:
    """Return name, interval and contributions of the main quantities of a result."""
    return [
        (quantity.name, _ends(quantity, interval), "; ".join(filter(None, _parts(interval))))
        for quantity, interval in _interval_quantities(result, study)
    ]


def _interval_quantities(
    result: ContactResult, study: ResolutionStudy | None
) -> list[tuple[Quantity, Interval]]:
    table = contact_fields.PROFILE_CONTACT if result.pair.is_profile else contact_fields.CONTACT
    return [
        (quantity_of((*table, *_MORE), interval.name), interval)
        for interval in uncertainty.uncertainty_intervals(result, study)
    ]


CORRECTED = ("", "corrected", "in 95 of 100", "as measured")
"""Heads of `corrected_rows`."""


def corrected_rows(result: ContactResult) -> list[tuple[str, ...]]:
    """Return name, corrected value, interval and uncorrected value of each quantity."""
    rows: list[tuple[str, ...]] = []
    for quantity, item in _interval_quantities(result, None):
        # Both follow from the contact area.
        if item.name in ("mean_pressure", "constriction_length"):
            continue
        is_share = item.name.endswith("fraction")
        form = format_share if is_share else partial(format_short, unit=quantity.unit)
        ends = range_text(item.low, item.high, form)
        measured = form(item.value if item.measured is None else item.measured)
        rows.append((capitalize_first(quantity.name), form(item.value), ends, measured))
    return rows


def area_interval(result: ContactResult, study: ResolutionStudy | None = None) -> Interval | None:
    """Return the interval of the contact area; None without contact."""
    intervals = uncertainty.uncertainty_intervals(result, study)
    return next((item for item in intervals if item.name == "contact_fraction"), None)


def area_ends(result: ContactResult) -> tuple[float, float] | None:
    """Return the ends of the contact fraction; None if an end or the yielding is unknown."""
    interval = area_interval(result)
    if interval is None or Cause.YIELDING in interval.unknown:
        return None
    ends = interval.low, interval.high
    return ends if ends[0] < ends[1] < math.inf else None


_SHORT = {
    Cause.RIM: "spot perimeter",
    Cause.GRID: "pixel",
    Cause.EDGE: "map edge",
    Cause.WAVES: "shorter waves",
    Cause.YIELDING: "ceiling",
    Cause.MAPS: "maps",
}


STUDY_REF = ArgumentRef("rc.resolution_study")
"""Reference to the option that studies the pixel."""

INSTRUMENT_REF = ArgumentRef("result.uncertainty")
"""Reference to the options that include the instrument."""


def is_correctable(result: ContactResult) -> bool:
    """Return whether the result can be corrected for a measuring instrument."""
    pair = result.pair
    is_measured = not str(result.surface.provenance.source).startswith(("nominal ", "generated "))
    alone = pair.counter_surface is None and not pair.is_profile
    return is_measured and alone and result.control == "load" and result.moments is None


def sources(interval: Interval, hint: bool = True, instrument: bool = False) -> Sentence:
    """Return the contributions to an interval in one line."""
    known, other = _parts(interval)
    if hint and Cause.GRID in interval.unknown:
        other += f" ({STUDY_REF})"
    if instrument and interval.measured is None:
        other += f"{', ' if other else ''}instrument not given ({INSTRUMENT_REF})"
    lacking = Cause.YIELDING in interval.unknown
    text = f"{'Known' if lacking else 'Interval from'}: {known}" if known else ""
    if lacking:
        return Sentence(". ".join(filter(None, (f"No interval: {other}", text))))
    return Sentence("; ".join(filter(None, (text, other))))


def _parts(interval: Interval) -> tuple[str, str]:
    """Return the contributions to an interval, and the effects it leaves out."""
    unknown = " and ".join(_SHORT[cause] for cause in interval.unknown)
    known = []
    if interval.measured is not None:
        known = [
            f"{_SHORT.get(Cause(cause), cause)} {100 * share:.0f} %"
            for cause, share in interval.budget.items()
            if share >= _SHOWN_SHARE
        ]
    else:
        for item in interval.doubts:
            if item.cause is Cause.TOLERANCE or not item.known:
                continue
            ends = dict.fromkeys(
                format_change(end)
                for end in (item.low, item.high)
                if abs(end) >= _MIN_VISIBLE_CHANGE
            )
            text = "without limit" if math.isinf(item.high) else " to ".join(ends) or "below 0.1 %"
            known.append(f"{_SHORT[item.cause]} {text}")
    return ", ".join(known), f"{unknown} not studied" if unknown else ""


def joint_interval(
    joint: Any,
    name: str,
    value: float,
    index: int,
    coarser: float,
    over: Mean | None = None,
    *,
    base: float = math.nan,
) -> Interval:
    """Return the interval of a quantity of a joint under its largest load.

    With its relative change ``base`` under the ceiling of the base of a coated body the true value
    is between both.
    """
    known = joint.calibrated
    calibrated = (known.numbers[index], known.contact_area) if known else (math.nan, math.nan)
    interval = uncertainty.joint_interval(name, value, joint.largest, coarser, calibrated)
    if not math.isnan(base):
        ceiling = ErrorSource(Cause.YIELDING, min(base, 0.0), max(base, 0.0))
        others = (doubt for doubt in interval.doubts if doubt.cause is not Cause.YIELDING)
        interval = replace(interval, doubts=(ceiling, *others))
    if over is None or over.count < 2 or not over.value:
        return interval
    half = (over.high - over.value) / over.value
    scatter = ErrorSource(Cause.MAPS, -min(half, 1.0), half)
    return replace(interval, doubts=(*interval.doubts, scatter))


def under_calibrated(joint: Any, index: int) -> str:
    """Return the change of a quantity of a joint under the calibrated ceiling as text."""
    known = joint.calibrated
    change = format_change(known.numbers[index])
    name = "calibrated ceiling" if joint.largest.calibration is None else "ceiling of 3 σ_Y"
    return f"{name} ({format_engineering(known.ceiling, 'Pa', 3)}) {change}"


def has_ends(interval: Interval) -> bool:
    """Return whether both ends of an interval are known and finite."""
    return not interval.unknown and interval.low < interval.high < math.inf


def with_interval(interval: Interval, form: Callable[[float], str]) -> str:
    """Return a formatted value, with its interval if known."""
    text = form(interval.value)
    if not has_ends(interval):
        return text
    return f"{text} ({range_text(interval.low, interval.high, form)})"


def intervals_by_key(result: ContactResult, study: ResolutionStudy | None = None) -> dict[str, str]:
    """Return the known intervals of the main quantities of a contact as text, by key."""
    if not (result.converged and result.load):
        return {}
    return {
        interval.name: text
        for quantity, interval in _interval_quantities(result, study)
        if " to " in (text := _ends(quantity, interval))
    }


def brief_ends(result: ContactResult) -> dict[str, str]:
    """Return the finite intervals of the main quantities, by key, without remarks."""
    if not (result.converged and result.load):
        return {}
    return {
        interval.name: range_text(interval.low, interval.high, quantity.format_value)
        for quantity, interval in _interval_quantities(result, None)
        if interval.high < math.inf
        and quantity.format_value(interval.low) != quantity.format_value(interval.high)
    }


def _ends(quantity: Quantity, interval: Interval) -> str:
    if math.isinf(interval.high):
        return f"{quantity.format_value(interval.value)}, no interval"
    low, high = (quantity.format_value(value) for value in (interval.low, interval.high))
    if interval.unknown and low == high:
        return f"{low}, no interval"
    text = low if low == high else join_ends(low, high)
    if interval.measured is not None:
        center, measured = map(quantity.format_value, (interval.value, interval.measured))
        text = f"{center} ({text}); as measured {measured}"
    unknown = _parts(interval)[1]
    return f"{text} ({unknown})" if unknown else text


MEASURED = (
    Quantity("instrument", of=lambda known: known.instrument and vars(known.instrument)),
    Quantity("shortest_wave", "[m]"),
    Quantity("resolved", "[m]"),
    Quantity("draws"),
    Quantity("seed"),
    Quantity("remarks"),
    Quantity("closing", of=lambda known: dict(known.closing)),
    Quantity("intervals", of=lambda known: {i.name: i.summary() for i in known.intervals}),
)
"""Quantities of an `Uncertainty`."""

MEASURED_COLUMNS = (
    Column("name", "quantity", of="intervals.name"),
    Column("measured", "as measured", of="intervals.measured"),
    Column("value", "corrected", of="intervals.value"),
    Column("low", "lower end", of="intervals.low"),
    Column("high", "upper end", of="intervals.high"),
)
"""Columns of the intervals of an `Uncertainty`."""


_TRANSFERS = {
    "optical": "transfer of a round pupil",
    "coherent": "transfer in coherent light",
    "gaussian": "Gaussian transfer",
    "measured": "measured transfer",
}


def measurement_text(known: Uncertainty) -> str:
    """Return the instrument of a map and the method of the intervals as text."""
    tool = known.instrument
    if tool is None:
        return "Intervals of grid and material, without the instrument."
    resolved = f"the map shows waves down to {format_short(known.resolved, 'm')}"
    if known.shortest_wave is not None:
        waves = format_short(known.shortest_wave, "m")
        resolved += f", the surface has waves down to {waves}"
    stated = [_TRANSFERS[tool.kind]] if tool.kind in _TRANSFERS else []
    stated += [
        f"{name.replace('_', ' ')} {format_short(value, 'm')}"
        for name in ("resolution", "tip_radius", "noise")
        if (value := getattr(tool, name))
    ]
    name = tool.name or f"{tool.kind} instrument"
    return f"{name} ({', '.join(stated)}): {resolved}. {known.draws} draws, seed {known.seed}."


def budget_block(result: ContactResult, study: ResolutionStudy | None) -> list[page.Block]:
    """Return the figure block of the uncertainty budget; none without known intervals."""
    rows = [
        (capitalize_first(quantity.name), interval.budget)
        for quantity, interval in _interval_quantities(result, study)
        if has_ends(interval)
    ]
    caption = "Sources of each interval. The shares of a bar add to 100 %."
    picture = page.Picture(partial(uncertainty_budget, rows), caption, page.WIDE)
    return [page.Block("figure", picture)] if rows else []


class UncertaintyPresentation(Presentation):
    """Presentation of the uncertainty of a contact."""

    table = MEASURED
    columns = MEASURED_COLUMNS
