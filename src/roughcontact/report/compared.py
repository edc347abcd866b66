"""What is told of maps that are compared, and of the area that a map needs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Any

from roughcontact import statistics
from roughcontact._version import __version__
from roughcontact.contact.compared import Comparison
from roughcontact.contact.sampling import WANTED, SamplingError, SamplingStudy
from roughcontact.plots.style import prefixed
from roughcontact.report import inputs, tables
from roughcontact.report.quantities import (
    ABSENT,
    PROBLEM,
    TRUST,
    Column,
    Columns,
    Quantity,
    Table,
    quantity_of,
    stored,
)
from roughcontact.statistics import Difference, Mean
from roughcontact.units import changed_by, counted, engineering, lengths, plain

LEVEL = f"{100 * statistics.LEVEL:.0f} %"
"""Confidence of all intervals, as it is told."""

MEANS = f"mean ± half of its {LEVEL} interval (s: standard deviation)"
"""What a cell of the means holds."""

_ROUNDING = 1e-6
_SHARES = ("contact_fraction", "saturated_fraction")
_PRESSURES = ("max_pressure",)
_LENGTHS = ("mean_gap", "approach")

Cells = tuple[str, ...]


def unit_of(name: str) -> str:
    """Return the SI unit of a number that is compared."""
    if name in _PRESSURES:
        return "Pa"
    if name in _LENGTHS:
        return "m"
    return inputs.ROUGHNESS[name][0] or "1" if name in inputs.ROUGHNESS else "1"


def name_of(name: str) -> str:
    """Return what a number that is compared is called."""
    return name if name in inputs.ROUGHNESS else quantity_of(tables.CONTACT, name).name


def scale_of(name: str, largest: float) -> tuple[float, str]:
    """Return what a number is multiplied with where it is told, and its unit."""
    if name in _SHARES:
        return 100.0, "%"
    unit = unit_of(name)
    return (1.0, "") if unit == "1" else prefixed(abs(largest), unit)


def told(name: str, *values: float, digits: int = 4) -> str:
    """Return a number that is compared in words; of several, from the first to the last."""
    if any(map(math.isnan, values)):
        return ABSENT
    factor, unit = scale_of(name, max(values, key=abs))
    return f"{' to '.join(plain(value * factor, digits) for value in values)} {unit}".rstrip()


def _mean(name: str, found: Mean) -> str:
    if math.isnan(found.deviation):
        return told(name, found.value)
    # The solver leaves as much.
    if found.deviation <= _ROUNDING * abs(found.value):
        return f"{told(name, found.value)} (all alike)"
    factor, unit = scale_of(name, found.value or found.deviation)
    half = found.high - found.value
    # Two digits of the half; up to three of a mean that is smaller.
    places = 1 - math.floor(math.log10(half * factor))
    if found.value:
        own = 2 - math.floor(math.log10(abs(found.value) * factor))
        places = max(places, min(own, places + 2))
    places = max(places, 0)
    mean, sides, spread = (f"{x * factor:.{places}f}" for x in (found.value, half, found.deviation))
    return f"{mean} ± {sides} {unit}".rstrip() + f" (s {spread})"


def group_heads(comparison: Comparison) -> list[str]:
    """Return the groups with how many maps they have."""
    found = []
    for group in comparison.groups:
        maps = counted(len(group.samples), "map")
        found.append(f"{group.name}, {maps}" if group.name else maps)
    return found


def means(comparison: Comparison) -> tuple[Cells, list[Cells]]:
    """Return head and rows of the means: a number a row, a group a column."""
    rows = [
        (
            name_of(name),
            *(_mean(name, comparison.mean(at, name)) for at in range(len(comparison.groups))),
        )
        for name in comparison.names
    ]
    return ("", *group_heads(comparison)), rows


def differences(comparison: Comparison, clear: bool = False) -> tuple[Cells, list[Cells]]:
    """Return head and rows of the differences, or only of those clear of zero: a pair a row.

    The relative difference is that over the mean of the group which is subtracted.
    """
    several = len(comparison.groups) > 2
    rows = []
    for name in comparison.names:
        for (first, second), found in comparison.differences(name).items():
            if clear and not found.excludes_zero:
                continue
            base = comparison.mean(first, name).value
            pair = (pair_of(comparison, first, second),) if several else ()
            rows.append((name_of(name), *pair, *_difference(name, found, base)))
    pairs = ("", "groups") if several else (pair_of(comparison, 0, 1),)
    return (*pairs, "difference", f"{LEVEL} interval", "relative", "excludes zero"), rows


def pair_of(comparison: Comparison, first: int, second: int) -> str:
    """Return two groups as the difference between them."""
    names = [group.name or "maps" for group in comparison.groups]
    return f"{names[second]} less {names[first]}"


def _difference(name: str, found: Difference, base: float) -> Cells:
    # A skewness near zero has no parts.
    change = changed_by(found.value / base) if base > 0 and name != "Ssk" else ABSENT
    value = told(name, found.value, digits=3)
    if not found.known:
        return value, "not known", change, "not known"
    ends = told(name, found.low, found.high, digits=3)
    return value, ends, change, "yes" if found.excludes_zero else "no"


def components(comparison: Comparison) -> tuple[Cells, list[Cells]]:
    """Return head and rows of how the scatter splits; no rows where it cannot."""
    rows = []
    for name in comparison.names:
        found = comparison.components(name)
        if found is None or math.isnan(found.share):
            continue
        spread = (told(name, x, digits=3) for x in (found.between, found.within))
        share, low, high = (f"{100 * x:.0f}" for x in (found.share, found.low, found.high))
        rows.append((name_of(name), *spread, f"{share} %", f"{low} to {high} %"))
    head = ("scatter", "between groups", "within", "share between", f"{LEVEL} interval")
    return head, rows


def tables_of(comparison: Comparison) -> list[tuple[Cells, list[Cells]]]:
    """Return heads and rows that a console has room for: of many pairs those clear of zero."""
    found = [means(comparison)]
    if len(comparison.groups) > 1:
        found.append(differences(comparison, clear=len(comparison.groups) > 2))
    shares = components(comparison)
    return [one for one in (*found, shares) if one[1]]


def left_out(comparison: Comparison) -> str:
    """Return in a sentence what `tables_of` leaves out; nothing where it has all."""
    pairs = len(comparison.groups) * (len(comparison.groups) - 1) // 2
    if pairs < 2:
        return ""
    clear = len(differences(comparison, clear=True)[1])
    return (
        f"{clear} of {pairs * len(comparison.names)} differences exclude zero and are shown; "
        "report, CSV and JSON have all."
    )


# Files


def _groups(comparison: Comparison) -> list[dict[str, Any]]:
    return [
        {
            "name": group.name,
            "maps": [
                {
                    "name": sample.name,
                    "size": list(sample.size),
                    "pixel": list(sample.pixel),
                    "shortest_wave": sample.shortest_wave,
                    "numbers": sample.numbers,
                }
                for sample in group.samples
            ],
            "means": {name: asdict(comparison.mean(at, name)) for name in comparison.names},
            "curves": {
                name: [asdict(found) for found in comparison.curve(at, name)]
                for name in comparison.curves
            },
        }
        for at, group in enumerate(comparison.groups)
    ]


def _differences(comparison: Comparison) -> list[dict[str, Any]]:
    return [
        {
            "quantity": name,
            "unit": unit_of(name),
            "first": comparison.groups[first].name,
            "second": comparison.groups[second].name,
            **asdict(found),
            "excludes_zero": found.excludes_zero,
        }
        for name in comparison.names
        for (first, second), found in comparison.differences(name).items()
    ]


def _components(comparison: Comparison) -> dict[str, Any]:
    found = {name: comparison.components(name) for name in comparison.names}
    return {name: asdict(one) for name, one in found.items() if one is not None}


def _pressures(values: Sequence[float]) -> str:
    first, last = (engineering(value, "Pa") for value in (values[0], values[-1]))
    below = f"; curves from {first} in {len(values)} steps" if len(values) > 1 else ""
    return f"{last} on every map{below}"


def _cautions() -> Table:
    return tuple(quantity_of(tables.CONTACT, key) for key in ("warnings", "cautions"))


COMPARISON: Table = (
    Quantity(
        "pressures", "nominal pressure", unit="Pa", of=lambda c: list(c.pressures), part=PROBLEM,
        form=_pressures,
    ),
    Quantity(
        "first_pressure", "first loading", unit="Pa", part=PROBLEM,
        meaning="nominal pressure between before and after",
        when=lambda c: c.first_pressure is not None,
    ),
    Quantity("paired"),
    Quantity("confidence", of=lambda _: statistics.LEVEL),
    Quantity("groups", of=_groups),
    Quantity("differences", of=lambda c: _differences(c) if len(c.groups) > 1 else []),
    Quantity("components", of=_components),
    Quantity(
        "worst_certificate", "certificates", symbol="ε", part=TRUST,
        form=lambda v: f"{v:.1e} at most",
    ),
    Quantity("sampling", of=lambda c: [stored(SAMPLING, study) for study in c.sampling]),
    *_cautions(),
    Quantity("version", of=lambda _: __version__),
)  # fmt: skip
"""Of a `Comparison`."""


def _lines(comparison: Comparison) -> list[tuple[str, str, int, float, float, float, float, str]]:
    """Return what a table in text holds: means of groups, then differences."""
    found = []
    for name in comparison.names:
        for at, group in enumerate(comparison.groups):
            one = comparison.mean(at, name)
            label = group.name or "all"
            ends = one.value, one.deviation, one.low, one.high
            found.append((name, label, one.count, *ends, ""))
        if len(comparison.groups) < 2:
            continue
        for (first, second), gap in comparison.differences(name).items():
            pair = pair_of(comparison, first, second)
            count = sum(len(comparison.groups[at].samples) for at in (first, second))
            said = "" if not gap.known else "yes" if gap.excludes_zero else "no"
            found.append((name, pair, count, gap.value, math.nan, gap.low, gap.high, said))
    return found


def _cell(at: int) -> Callable[[Comparison], list[Any]]:
    return lambda comparison: [_plain(line[at]) for line in _lines(comparison)]


def _plain(cell: Any) -> Any:
    """Return a cell that no comma takes apart."""
    return cell.replace(",", " ") if isinstance(cell, str) else cell


def _told(comparison: Comparison) -> list[str]:
    """Return what is told of each line: means of groups, then differences."""
    found = []
    for name in comparison.names:
        found += [_mean(name, comparison.mean(at, name)) for at in range(len(comparison.groups))]
        if len(comparison.groups) > 1:
            for gap in comparison.differences(name).values():
                value, ends, _, _ = _difference(name, gap, 0.0)
                found.append(f"{value} ({ends})")
    return found


COMPARISON_COLUMNS: Columns = (
    Column("name", "number", of=lambda c: [name_of(line[0]) for line in _lines(c)], stored=False),
    Column("of", "of", of=lambda c: [line[1] for line in _lines(c)], stored=False),
    Column("told", f"mean ± half of its {LEVEL} interval", of=_told, stored=False),
    Column("quantity", of=_cell(0)),
    Column("unit", of=lambda c: [unit_of(line[0]) for line in _lines(c)]),
    Column("group", of=_cell(1)),
    Column("maps", of=_cell(2)),
    Column("mean", of=_cell(3)),
    Column("deviation", of=_cell(4)),
    Column("low", of=_cell(5)),
    Column("high", of=_cell(6)),
    Column("excludes_zero", of=_cell(7)),
)
"""Of the means and differences of a `Comparison`."""


# The area that is needed


FIVE = f"{100 * WANTED:.0f} %"
"""The error that an area is told for."""


def part(share: float) -> str:
    """Return a relative error in two digits."""
    return f"{plain(100 * share, 2)} %"


def side(area: float) -> str:
    """Return an area as a square."""
    length = _side(area)
    return f"{length} × {length}"


def _side(area: float) -> str:
    return engineering(math.sqrt(area), "m", 2)


def _error(one: SamplingError) -> str:
    return f"{told(one.name, one.half, digits=2)} ({part(one.relative)})"


def _needed(one: SamplingError) -> str:
    return f"{_side(one.area)} ({_side(one.area_low)} to {_side(one.area_high)})"


def _each(read: Callable[[SamplingError], Any]) -> Callable[[SamplingStudy], list[Any]]:
    return lambda study: [read(one) for one in study.errors]


def _from(one: SamplingError) -> str:
    return f"{one.parts} parts; {one.bound}" if one.bound else f"{one.parts} parts"


SAMPLING: Table = (
    Quantity("source", of="whole.source"),
    Quantity("size", unit="m", of=lambda s: list(s.whole.size)),
    Quantity("pressure", "nominal pressure", unit="Pa", part=PROBLEM),
    Quantity("wanted", of=lambda _: WANTED),
    Quantity("confidence", of=lambda _: statistics.LEVEL),
    Quantity(
        "errors", of=lambda s: [{**asdict(one), "unit": unit_of(one.name)} for one in s.errors],
    ),
    Quantity(
        "parts",
        of=lambda s: {
            str(n * n): {one.name: s.values(n, one.name) for one in s.errors} for n in s.levels
        },
    ),
    *_cautions(),
    Quantity("version", of=lambda _: __version__),
)  # fmt: skip
"""Of a `SamplingStudy`."""

SAMPLING_COLUMNS: Columns = (
    Column("quantity", of=_each(lambda one: one.name)),
    Column("unit", of=_each(lambda one: unit_of(one.name))),
    Column("name", "sampling", of=_each(lambda one: name_of(one.name)), stored=False),
    Column(
        "value", "this map", of=_each(lambda one: one.value),
        shown=_each(lambda one: told(one.name, one.value)),
    ),
    Column("half", f"± ({LEVEL})", of=_each(lambda one: one.half), shown=_each(_error)),
    Column(
        "area", f"side for {FIVE}", unit="m²", of=_each(lambda one: one.area),
        shown=_each(_needed),
    ),
    Column("area_low", unit="m²", of=_each(lambda one: one.area_low)),
    Column("area_high", unit="m²", of=_each(lambda one: one.area_high)),
    Column("parts", "from", of=_each(lambda one: one.parts), shown=_each(_from)),
    Column("drift", of=_each(lambda one: one.drift)),
    Column("scaling", of=_each(lambda one: one.scaling)),
)  # fmt: skip
"""Of the errors of a `SamplingStudy`."""


def answer(study: SamplingStudy) -> str:
    """Return in one sentence what area the contact area needs."""
    one = study.error("contact_fraction")
    bound = f"{one.bound} " if one.bound else ""
    return (
        f"{study.whole.name}: for {FIVE} ({LEVEL} interval) of the contact area "
        f"{bound}{side(one.area)}; this map, {lengths(study.whole.size)}, gives "
        f"±{part(one.relative)}"
    )
