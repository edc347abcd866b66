"""Reports of a comparison of maps, and of the sampling error of a map."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, replace
from operator import attrgetter
from typing import Any

from roughcontact._tools import statistics
from roughcontact._tools.statistics import Difference, Mean
from roughcontact._version import __version__
from roughcontact.analyses.compare import figures
from roughcontact.analyses.compare.fields import name_of, scale_of, unit_of
from roughcontact.analyses.compare.model import Comparison, rows_by_ceiling
from roughcontact.analyses.compare.sampling import (
    CONTACT,
    WANTED,
    Sample,
    SamplingError,
    SamplingStudy,
)
from roughcontact.analyses.solve import fields as contact_fields
from roughcontact.analyses.sweep.report import curve_references
from roughcontact.contact.result import BASE, CALIBRATED, COATING
from roughcontact.errors import ArgumentRef, Sentence
from roughcontact.references import make_use
from roughcontact.report import assumptions, chapters, phrases
from roughcontact.report.citations import Uses
from roughcontact.report.figures import FILES, FRONT, RESULTS, Illustration
from roughcontact.report.kind import (
    ABSENT,
    CAUTIONS,
    PROBLEM,
    TRUST,
    Cells,
    CellTable,
    Column,
    Quantity,
    Row,
    Table,
    capitalize_first,
    delegate_quantity,
    quantity_of,
    rows_of,
    stored_values,
)
from roughcontact.report.page import WIDE, Block
from roughcontact.report.phrases import range_text
from roughcontact.report.presentation import Presentation
from roughcontact.units import (
    count_noun,
    format_change,
    format_engineering,
    format_lengths,
    plain_decimal,
)

LEVEL = f"{100 * statistics.LEVEL:.0f} %"
"""Confidence level of all intervals, as text."""

MEANS = f"mean ± half of its {LEVEL} interval (s: standard deviation)"
"""Content of a cell of the means."""

_ROUNDING = 1e-6


def quantity_text(name: str, *values: float, digits: int = 4) -> str:
    """Return a compared value as text; of several values, the first and the last."""
    if any(map(math.isnan, values)):
        return ABSENT
    factor, unit = scale_of(name, max(values, key=abs))
    return (
        f"{' to '.join(plain_decimal(value * factor, digits) for value in values)} {unit}".rstrip()
    )


def _mean(name: str, result: Mean) -> str:
    if math.isnan(result.deviation):
        return quantity_text(name, result.value)
    # Solver tolerance.
    if result.deviation <= _ROUNDING * abs(result.value):
        return f"{quantity_text(name, result.value)} (all equal)"
    factor, unit = scale_of(name, result.value or result.deviation)
    half = result.high - result.value
    # Two digits of the half-width; up to three of a smaller mean.
    places = 1 - math.floor(math.log10(half * factor))
    if result.value:
        own = 2 - math.floor(math.log10(abs(result.value) * factor))
        places = max(places, min(own, places + 2))
    places = max(places, 0)
    mean, sides, spread = (
        f"{x * factor:.{places}f}" for x in (result.value, half, result.deviation)
    )
    return f"{mean} ± {sides} {unit}".rstrip() + f" (s {spread})"


def group_heads(comparison: Comparison) -> list[str]:
    """Return the name and the number of maps of each group."""
    result = []
    for group in comparison.groups:
        maps = count_noun(len(group.samples), "map")
        result.append(f"{group.name}, {maps}" if group.name else maps)
    return result


def means(comparison: Comparison) -> tuple[Cells, list[Cells]]:
    """Return head and rows of the means: one row per quantity, one column per group."""
    rows = [
        (
            name_of(name, ceiling),
            *(_mean(name, case.mean(index, name)) for index in range(len(case.groups))),
        )
        for name, ceiling, case in rows_by_ceiling(comparison)
    ]
    return ("", *group_heads(comparison)), rows


def differences(comparison: Comparison) -> tuple[Cells, list[Cells]]:
    """Return head and rows of the differences: one row per pair."""
    several = len(comparison.groups) > 2
    rows = []
    for name, ceiling, case in rows_by_ceiling(comparison):
        for (first, second), result in case.differences(name).items():
            base = case.mean(first, name).value
            pair = (pair_of(comparison, first, second),) if several else ()
            said = _significance(comparison, name, (first, second)) if result.known else "not known"
            rows.append((name_of(name, ceiling), *pair, *_difference(name, result, base), said))
    pairs = ("", "groups") if several else (pair_of(comparison, 0, 1),)
    return (*pairs, "difference", f"{LEVEL} interval", "relative", "significant"), rows


def _significance(comparison: Comparison, name: str, pair: tuple[int, int]) -> str:
    """Return whether a difference is significant, or the reason if the ceiling prevents it."""
    if comparison.is_ceiling_dependent(name, pair):
        return "no, sign depends on the ceiling"
    if comparison.is_significant(name, pair):
        return "yes"
    cases = [comparison] if comparison.base is None else [comparison, comparison.base]
    is_clear = any(case.corrected[name, pair] < 1 - statistics.LEVEL for case in cases)
    return "no, not under both ceilings" if is_clear else "no"


def pair_of(comparison: Comparison, first: int, second: int) -> str:
    """Return the difference of two groups as text."""
    names = [group.name or "maps" for group in comparison.groups]
    return f"{names[second]} − {names[first]}"


def _difference(name: str, result: Difference, base: float) -> Cells:
    # A relative change of a skewness near zero is meaningless.
    change = format_change(result.value / base) if base > 0 and name != "Ssk" else ABSENT
    value = quantity_text(name, result.value, digits=3)
    if not result.known:
        return value, "not known", change
    return value, quantity_text(name, result.low, result.high, digits=3), change


def components(comparison: Comparison) -> tuple[Cells, list[Cells]]:
    """Return head and rows of the variance components; no rows where they are unknown."""
    rows = []
    for name, ceiling, case in rows_by_ceiling(comparison):
        result = case.components(name)
        if result is None or math.isnan(result.share):
            continue
        spread = (quantity_text(name, x, digits=3) for x in (result.between, result.within))
        share, low, high = (f"{100 * x:.0f}" for x in (result.share, result.low, result.high))
        rows.append((name_of(name, ceiling), *spread, f"{share} %", f"{low} to {high} %"))
    head = ("scatter", "between groups", "within", "share between", f"{LEVEL} interval")
    return head, rows


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
            "means": {name: asdict(comparison.mean(index, name)) for name in comparison.names},
            "curves": {
                name: [asdict(result) for result in comparison.curve(index, name)]
                for name in comparison.curves
            },
        }
        for index, group in enumerate(comparison.groups)
    ]


def _differences(comparison: Comparison, case: Comparison) -> list[dict[str, Any]]:
    """Return the differences of a comparison or of its base; none of a single group."""
    if len(case.groups) < 2:
        return []
    return [
        {
            "quantity": name,
            "unit": unit_of(name),
            "first": comparison.groups[first].name,
            "second": comparison.groups[second].name,
            **asdict(result),
            "excludes_zero": result.excludes_zero,
            "p_corrected": case.corrected[name, (first, second)],
            "significant": comparison.is_significant(name, (first, second)),
            "ceiling_dependent": comparison.is_ceiling_dependent(name, (first, second)),
        }
        for name in case.names
        for (first, second), result in case.differences(name).items()
    ]


def _components(comparison: Comparison) -> dict[str, Any]:
    result = {name: comparison.components(name) for name in comparison.names}
    return {name: asdict(item) for name, item in result.items() if item is not None}


def _pressures(values: Sequence[float]) -> str:
    first, last = (format_engineering(value, "Pa") for value in (values[0], values[-1]))
    below = f"; curves from {first} in {len(values)} steps" if len(values) > 1 else ""
    return f"{last} on every map{below}"


COMPARISON = (
    Quantity("pressures", "nominal pressure [Pa]", part=PROBLEM, form=_pressures),
    Quantity(
        "preload_pressure",
        "first loading [Pa]: nominal pressure between before and after",
        part=PROBLEM,
    ),
    Quantity("paired"),
    Quantity("confidence", of=lambda _: statistics.LEVEL),
    Quantity("groups", of=_groups),
    Quantity("differences", of=lambda c: _differences(c, c)),
    Quantity("components", of=_components),
    Quantity(
        "base",
        of=lambda c: (
            c.base
            and {
                "groups": _groups(c.base),
                "differences": _differences(c, c.base),
                "components": _components(c.base),
            }
        ),
    ),
    Quantity(
        "worst_certificate", "certificates $ε$", part=TRUST, form=lambda v: f"{v:.1e} at most"
    ),
    Quantity("sampling", of=lambda c: [stored_values(SAMPLING, study) for study in c.sampling]),
    *CAUTIONS,
    Quantity("version", of=lambda _: __version__),
)
"""Quantities of a `Comparison`."""


def _lines(comparison: Comparison) -> list[tuple[Any, ...]]:
    """Return the lines of a text table: means of groups, then differences."""
    result: list[tuple[Any, ...]] = []
    for name, ceiling, case in rows_by_ceiling(comparison):
        unit = unit_of(name)
        for index, group in enumerate(case.groups):
            item = case.mean(index, name)
            ends = item.value, item.deviation, item.low, item.high
            result.append((name, unit, group.name or "all", item.count, *ends, "", ceiling))
        if len(case.groups) < 2:
            continue
        for (first, second), gap in case.differences(name).items():
            pair = pair_of(comparison, first, second)
            count = sum(len(comparison.groups[index].samples) for index in (first, second))
            said = "" if not gap.known else "yes" if gap.excludes_zero else "no"
            ends = gap.value, math.nan, gap.low, gap.high
            result.append((name, unit, pair, count, *ends, said, ceiling))
    return result


def _cell(index: int) -> Callable[[Comparison], list[Any]]:
    """Return the cells of a column, with commas replaced by spaces for CSV."""

    def cells(comparison: Comparison) -> list[Any]:
        values = [line[index] for line in _lines(comparison)]
        return [cell.replace(",", " ") if isinstance(cell, str) else cell for cell in values]

    return cells


_CELLS = ("quantity", "unit", "group", "maps", "mean", "deviation", "low", "high", "excludes_zero")

COMPARISON_COLUMNS = (
    *(Column(key, of=_cell(index)) for index, key in enumerate(_CELLS)),
    Column("ceiling", of=_cell(len(_CELLS)), when=lambda c: bool(c.base or c.calibrated)),
)
"""Columns of the means and differences of a `Comparison`."""


# Required area


FIVE = f"{100 * WANTED:.0f} %"
"""Sampling error for which the required area is given, as text."""


def part(share: float) -> str:
    """Return a relative error in per cent, with two digits."""
    return f"{plain_decimal(100 * share, 2)} %"


def _side(area: float) -> str:
    return format_engineering(math.sqrt(area), "m", 2)


def _square(item: SamplingError) -> str:
    """Return the required area as the sides of a square, with the kind of bound."""
    return f"{item.bound} {_side(item.area)} × {_side(item.area)}".lstrip()


def _error(item: SamplingError) -> str:
    return f"{quantity_text(item.name, item.half, digits=2)} ({part(item.relative)})"


def _area_text(item: SamplingError) -> str:
    return f"{_side(item.area)} ({range_text(item.area_low, item.area_high, _side)})"


def _each(read: Callable[[SamplingError], Any]) -> Callable[[SamplingStudy], list[Any]]:
    return lambda study: [read(item) for _, item in _errors(study)]


def _errors(study: SamplingStudy) -> list[tuple[str, SamplingError]]:
    """Return ceiling and error of each row; see `rows_by_ceiling`."""
    if study.base is None:
        return [("", item) for item in study.errors]
    return [
        (ceiling if item.name in CONTACT else "", case.error(item.name))
        for item in study.errors
        for ceiling, case in ((COATING, study), (BASE, study.base))
        if ceiling == COATING or item.name in CONTACT
    ]


def _parts_text(item: SamplingError) -> str:
    return f"{item.parts} parts; {item.bound}" if item.bound else f"{item.parts} parts"


SAMPLING: Table = (
    Quantity("source", of="whole.source"),
    Quantity("size", "[m]", of="whole.size"),
    Quantity("pressure", "nominal pressure [Pa]", part=PROBLEM),
    Quantity("wanted", of=lambda _: WANTED),
    Quantity("confidence", of=lambda _: statistics.LEVEL),
    Quantity(
        "errors", of=lambda s: [{**asdict(item), "unit": unit_of(item.name)} for item in s.errors]
    ),
    Quantity(
        "parts",
        of=lambda s: {
            str(n * n): {item.name: s.values(n, item.name) for item in s.errors} for n in s.levels
        },
    ),
    Quantity("base", of=lambda s: s.base and stored_values(SAMPLING, s.base)),
    *CAUTIONS,
    Quantity("version", of=lambda _: __version__),
)
"""Quantities of a `SamplingStudy`."""


def _error_column(
    key: str, label: str = "", shown: Callable[[SamplingError], Any] | None = None
) -> Column:
    """Return the column of an attribute of each error, with another text if ``shown``."""
    return Column(key, label, of=_each(attrgetter(key)), shown=shown and _each(shown))


SAMPLING_COLUMNS = (
    Column("quantity", of=_each(lambda item: item.name)),
    Column("unit", of=_each(lambda item: unit_of(item.name))),
    Column(
        "name",
        "sampling",
        of=lambda study: [name_of(item.name, ceiling) for ceiling, item in _errors(study)],
        stored=False,
    ),
    _error_column("value", "this map", lambda item: quantity_text(item.name, item.value)),
    _error_column("half", f"± ({LEVEL})", _error),
    _error_column("area", f"side for {FIVE} [m²]", _area_text),
    _error_column("area_low", "[m²]"),
    _error_column("area_high", "[m²]"),
    _error_column("parts", "from", _parts_text),
    _error_column("drift"),
    _error_column("scaling"),
    Column(
        "ceiling",
        of=lambda study: [ceiling for ceiling, _ in _errors(study)],
        when=lambda study: study.base is not None,
    ),
)
"""Columns of the errors of a `SamplingStudy`."""


def answer(study: SamplingStudy) -> str:
    """Return the required map size for the contact area as a sentence."""
    item = study.error("contact_fraction")
    sides, gives = _square(item), f"±{part(item.relative)}"
    if study.base is not None:
        other = study.base.error("contact_fraction")
        sides += f" under the ceiling of the coating, {_square(other)} under that of the base"
        gives += f" and ±{part(other.relative)}"
    return (
        f"{study.whole.name}: for {FIVE} ({LEVEL} interval) of the contact area {sides}; this map, "
        f"{format_lengths(study.whole.size)}, gives {gives}"
    )


# Largest number of groups that a title lists by name.
_NAMED = 3


def _ceiling_text(sample: Sample) -> str:
    """Return the ceiling of a map, or both of a coated body, as text."""
    text = phrases.ceiling_text(sample.curve.ceiling, *sample.bodies)
    return text if sample.base is None else f"{text} (coating); {_ceiling_text(sample.base)} (base)"


# Quantities of a `Sample` that are common to all maps.
_TERMS = (
    delegate_quantity("curve", quantity_of(contact_fields.CONTACT, "boundary")),
    replace(
        delegate_quantity("curve", quantity_of(contact_fields.CONTACT, "contact_modulus")),
        when=lambda item: math.isfinite(item.curve.contact_modulus),
    ),
    replace(quantity_of(contact_fields.CONTACT, "ceiling"), of="curve.ceiling", text=_ceiling_text),
)

_FIRST = ("contact_fraction", "saturated_fraction", "mean_gap", "Sdq")


def _maps(result: Comparison) -> list[Cells]:
    return [
        (
            sample.name,
            group.name,
            format_lengths(sample.size),
            format_lengths(sample.pixel),
            format_engineering(sample.shortest_wave, "m", 3),
        )
        for group in result.groups
        for sample in group.samples
    ]


def _preparation(samples: Sequence[Sample]) -> list[Block]:
    """Return the preparation of the maps, once if it is the same for all."""
    steps = ["; ".join(item.curve.preparation) or "none recorded" for item in samples]
    if len(set(steps)) > 1:
        rows = [(item.name, text) for item, text in zip(samples, steps, strict=True)]
        return chapters.table(rows, ("map", "preparation"))
    return [Block("text", f"Preparation of each map: {steps[0]}.")]


# Largest number of maps in the list of a report.
_MAX_LISTED_MAPS = 16


def _load_case(samples: Sequence[Sample], specified: Sequence[Row]) -> list[Block]:
    """Return the blocks on the preparation and the load case of maps."""
    rows = [*specified, *rows_of(_TERMS, samples[0], PROBLEM)]
    return [*_preparation(samples), *chapters.body_blocks(samples[0].bodies, rows, "ceiling")]


def _nominal(pressure: float) -> str:
    return f"{phrases.format_short(pressure, 'Pa')} nominal"


def _change(result: Comparison, name: str, case: Comparison | None = None) -> str:
    """Return the difference of the first two groups with its interval; empty if unknown.

    The case is the ``base`` of the comparison, if its values are wanted.
    """
    case = case or result
    difference, base = case.differences(name)[0, 1], case.mean(0, name).value
    if not (difference.known and base > 0):
        return ""
    # Student's interval of a quantity that cannot be negative may pass zero.
    value, low, high = (
        f"{float(f'{max(100 * end / base, -100):.2g}'):+g}"
        for end in (difference.value, difference.low, difference.high)
    )
    mark = " *" if result.is_significant(name) else ""
    return f"{value} % ({low} to {high} %){mark}".replace("-", "−")


class ComparisonPresentation(Presentation):
    """Presentation of a comparison of maps."""

    result: Comparison
    table = COMPARISON
    columns = COMPARISON_COLUMNS
    figures = (
        Illustration("comparison", figures.overview, "", FILES),
        Illustration(
            "",
            figures.numbers,
            f"Dots are maps, thick lines means, bars their {LEVEL} intervals.",
            FRONT,
            WIDE,
        ),
        Illustration(
            "",
            figures.curves,
            f"Thin: maps over the nominal pressure. Thick: group means with {LEVEL} bands.",
            RESULTS,
            WIDE,
            lambda result: len(result.pressures) > 1,
        ),
    )

    def question(self) -> str:
        """Return the question that a comparison answers."""
        result = self.result
        pressure = format_engineering(result.pressure, "Pa")
        names = [group.name for group in result.groups if group.name]
        if result.preload_pressure is not None:
            count = count_noun(len(result.groups[0].samples), "map")
            return f"How does a first loading change {count} at {pressure}?"
        if len(result.groups) < 2:
            return f"How much do {count_noun(len(result.samples), 'map')} scatter at {pressure}?"
        if not 1 < len(names) <= _NAMED:
            return f"Do {len(result.groups)} groups of maps differ at {pressure}?"
        return f"Do {', '.join(names[:-1])} and {names[-1]} differ at {pressure}?"

    def problem(self) -> str:
        """Return the numbers of maps and the pressure."""
        groups = [f"{len(group.samples)} {group.name}".rstrip() for group in self.result.groups]
        return f"{' and '.join(groups)} maps, {_nominal(self.result.pressure)}"

    def answer(self) -> str:
        """Return the difference of the contact area, or its mean."""
        result = self.result
        name = result.names[0]
        if len(result.groups) < 2:
            share, under = _mean(name, result.mean(0, name)), ""
            if result.base is not None:
                other = _mean(name, result.base.mean(0, name))
                under = f" under the ceiling of the coating, {other} under that of the base"
            elif result.calibrated is not None:
                other = _mean(name, result.calibrated.mean(0, name)).partition(" (s ")[0]
                under = f", {other} under the calibrated ceiling"
            return f"On average {share} of the face is in contact{under}."
        groups, change = result.groups, _change(result, name)
        cases = [result] if result.base is None else [result, result.base]
        pair = f"{groups[1].name or 'the second group'} against {groups[0].name or 'the first'}"
        if not change:
            return f"Too few maps to compare {pair}."
        if result.base is not None:
            change = (
                f"{change} under the ceiling of the coating, {_change(result, name, result.base)} "
                "under that of the base"
            )
        elif result.calibrated is not None:
            other = _change(result, name, result.calibrated)
            change = f"{change}, {other} under the calibrated ceiling"
        if result.is_significant(name):
            return f"The contact area differs: {pair} {change.replace(' *', '')}, {LEVEL}."
        if result.is_ceiling_dependent(name):
            sign = "The sign of the difference in contact area"
            return f"{sign} depends on the ceiling: {pair} {change}."
        if all(case.differences(name)[0, 1].excludes_zero for case in cases):
            alone = f"only if tested alone, not with all {len(result.names)} quantities"
            return f"The contact area differs {alone}: {pair} {change}, {LEVEL}."
        return f"No difference shown in contact area: {pair} {change}, {LEVEL}."

    def numbers(self) -> CellTable:
        """Return the means of the main quantities and their difference."""
        result = self.result
        several = len(result.groups) > 1
        heads = tuple(group.name or "mean" for group in result.groups)
        rows = [
            (
                f"– {ceiling}"
                if ceiling == CALIBRATED
                else capitalize_first(name_of(name, ceiling)),
                *(
                    _mean(name, case.mean(index, name)).partition(" (s ")[0]
                    for index in range(len(result.groups))
                ),
                *([_change(result, name, case)] if several else ()),
            )
            for name, ceiling, case in rows_by_ceiling(result)
            if name in _FIRST and (ceiling != CALIBRATED or name == _FIRST[0])
        ]
        return ("", *heads, *(["difference"] if several else ())), rows

    def remarks(self) -> tuple[str, ...]:
        """Return the meaning of the marks, and the number of quantities."""
        mark = f"* significant ({LEVEL}, Holm); " if len(self.result.groups) > 1 else ""
        rest = f"{len(self.result.names)} quantities: {ArgumentRef('to_pandas()')}"
        return (Sentence(f"{mark}±: half the interval; {rest}"),)

    def meaning(self) -> str:
        """Return which differences are significant."""
        result = self.result
        if len(result.groups) < 2:
            return f"Means with their {LEVEL} intervals (s: standard deviation)."
        text = []
        for first, second in result.differences(result.names[0]):
            differ = [
                name_of(name)
                for name in result.names
                if result.is_significant(name, (first, second))
            ]
            text.append(
                f"{capitalize_first(pair_of(result, first, second))}: significant ({LEVEL}, Holm) "
                f"in {', '.join(differ) or 'nothing'}."
            )
        return " ".join(text)

    def inputs(self) -> list[Block]:
        """Return the blocks on the maps, their preparation and the load case."""
        rows = chapters.evenly_spaced(_maps(self.result), _MAX_LISTED_MAPS)
        head = ("map", "group", "size (y × x)", "pixel (y × x)", "shortest wave")
        return [*chapters.table(rows, head), *_load_case(self.result.samples, self.rows(PROBLEM))]

    def details(self) -> list[Block]:
        """Return means, differences, components and required areas."""
        result = self.result
        head, rows = means(result)
        blocks = [Block("head", f"Means ({MEANS})"), *chapters.table(rows, head)]
        if len(result.groups) > 1:
            head, rows = differences(result)
            how = (
                "Student's t of the pairs"
                if result.paired
                else "Welch's t"
                if len(result.groups) == 2
                else "Games and Howell, for all pairs at once"
            )
            blocks += [Block("head", f"Differences ({LEVEL} intervals by {how})")]
            blocks += chapters.table(rows, head)
            shares, split = components(result)
            if split:
                blocks += [
                    Block("head", "Scatter between and within groups (one-way, random effects)")
                ]
                blocks += chapters.table(split, shares)
        for study in result.sampling:
            blocks += [Block("head", f"Required area: {study.name}")]
            sampled = SamplingPresentation(study)
            blocks += [Block("text", f"{answer(study)}."), *sampled.steps()]
            blocks += sampled.figure_blocks(FRONT)
        return blocks

    def case(self) -> assumptions.Case:
        """Return the worst of each value of all maps."""
        return assumptions.sample_case(self.result.samples)

    def method(self) -> Iterator[str]:
        """Yield how certificates and intervals are understood."""
        yield (
            "Each map is solved separately under the nominal pressure. The certificates give the "
            "accuracy of the solutions, the intervals how well the maps represent their surfaces."
        )

    def works(self) -> Uses:
        """Yield the works on the maps and the statistics."""
        for sample in self.result.samples:
            yield from curve_references(sample.curve)
        yield make_use("intervals of the means", "Student1908")
        if len(self.result.groups) > 1 and not self.result.paired:
            wide = len(self.result.groups) > 2
            yield make_use("intervals of the differences", "Games1976" if wide else "Welch1947")
        if any(self.result.components(name) for name in self.result.names):
            yield make_use("scatter between groups and within", "Searle1992")


class SamplingPresentation(Presentation):
    """Presentation of a sampling study."""

    result: SamplingStudy
    table = SAMPLING
    columns = SAMPLING_COLUMNS
    figures = (
        Illustration(
            "sampling",
            figures.sampling,
            "Half of the interval over the side of a square: parts (dots), this map (squares), "
            f"root of the area (lines). {FIVE} is dashed.",
            FRONT,
        ),
    )

    def question(self) -> str:
        """Return the question that the study answers."""
        pressure = format_engineering(self.result.pressure, "Pa")
        return f"Is {self.result.whole.name} large enough at {pressure}?"

    def problem(self) -> str:
        """Return the map and the pressure."""
        return f"{self.result.name}, {_nominal(self.result.pressure)}"

    def answer(self) -> str:
        """Return the required map size for the contact area as a sentence."""
        return f"{answer(self.result)}."

    def inputs(self) -> list[Block]:
        """Return the blocks on the map, its preparation and the load case."""
        return _load_case([self.result.whole], self.rows(PROBLEM))

    def case(self) -> assumptions.Case:
        """Return the case of the whole map."""
        return assumptions.sample_case([self.result.whole])

    def method(self) -> Iterator[str]:
        """Yield how the map was divided."""
        parts = ", ".join(str(len(level)) for level in self.result.levels.values())
        yield (
            f"The map was divided into {parts} equal parts; each was leveled and solved "
            "separately. Their scatter gives the error of the whole map, which decreases with the "
            "root of the area if the parts are independent."
        )

    def works(self) -> Uses:
        """Yield the works on the map and the statistics."""
        yield from curve_references(self.result.whole.curve)
        yield make_use("intervals of the means", "Student1908")
