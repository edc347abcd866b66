"""Report of a contact, and its blocks in the reports of other results.

All blocks are from the result, except the elastic solution, which is computed for the report.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np

from roughcontact._tools.netcdf import Dataset
from roughcontact.analyses.estimate import fields as formulas
from roughcontact.analyses.solve import fields as contact_fields, uncertainty_report
from roughcontact.contact import archive
from roughcontact.contact.hertz_comparison import comparison_limits, is_beyond_map, is_unresolved
from roughcontact.contact.nominal_hertz import is_smooth
from roughcontact.contact.plausibility import load_bearing_spot_pixels
from roughcontact.contact.result import ContactResult, Regime
from roughcontact.contact.spots import Spots
from roughcontact.drawing import maps, sections
from roughcontact.drawing.sections import loaded_profile, pressure_histogram, section, versus_hertz
from roughcontact.errors import ConvergenceError, InsufficientMemoryError, Sentence
from roughcontact.formats import export
from roughcontact.references import make_use
from roughcontact.report import chapters, page, phrases
from roughcontact.report.figures import CONTACT, FRONT, PROFILE_CONTACT, ContactScene
from roughcontact.report.inputs import SURFACE, TRACE
from roughcontact.report.kind import (
    ABSENT,
    Cells,
    CellTable,
    Quantity,
    Row,
    Use,
    capitalize_first,
    quantity_of,
    rows_of,
)
from roughcontact.report.page import Block, PageTable, Picture
from roughcontact.report.phrases import format_share, format_short, range_text
from roughcontact.report.presentation import Presentation
from roughcontact.surface.surface import Surface
from roughcontact.uncertainty.intervals import QUANTITIES, Cause, Interval
from roughcontact.units import count_noun, format_engineering, format_percent


class SurfacePresentation(Presentation):
    """Presentation of a map or a profile."""

    result: Surface
    table = (*SURFACE, Quantity("Sq", "Sq [m]"), Quantity("Sdq", "Sdq"))
    plots = (maps.surface, sections.bearing_curve)
    profile_table = TRACE
    profile_plots = (sections.heights,)

    @property
    def is_profile(self) -> bool:
        """Whether the surface is a profile."""
        return self.result.is_profile

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the heights; the suffix selects the format."""
        export.save_surface(self.result, path)


class ContactWithSpots(NamedTuple):
    """A contact with its spots."""

    result: ContactResult
    spots: Spots


def _share_of_load(result: ContactWithSpots, count: int) -> str:
    load = result.spots.load
    return format_percent(min(float(load[:count].sum()) / float(load.sum()), 1.0))


SPOTS = (
    Quantity("count", "contact spots: connected pixels in contact", of="spots.count"),
    Quantity(
        "largest_area",
        "largest spot [m²]: area, and the load that it carries",
        of=lambda s: float(s.spots.area[0]),
        text=lambda s: (
            f"{format_engineering(float(s.spots.area[0]), 'm²')}, "
            f"{_share_of_load(s, 1)} of the load"
        ),
    ),
    Quantity(
        "carrying_pixels",
        "pixels of a load-bearing spot: spots of at least this size carry half of the load",
        of=lambda s: load_bearing_spot_pixels(s.result, s.spots),
    ),
)
"""Quantities of the contact spots of a `ContactWithSpots`."""


def spot_rows(result: ContactResult) -> list[Cells]:
    """Return the rows of number, size and load of the spots."""
    found = result.spots()
    if found.count == 0:
        return [("Contact spots", "none", "the bodies do not touch")]
    if result.pair.is_profile:
        return list(contact_fields.segments(result, found))
    return chapters.cells(rows_of(SPOTS, ContactWithSpots(result, found)))


def hertz_blocks(result: ContactResult) -> list[Block]:
    """Return the blocks that compare with Hertz; none without nominal bodies."""
    contact = result.hertz
    if contact is None or not contact_fields.is_hertz_compared(result):
        return []
    rows = [(capitalize_first(name), *texts) for name, *texts in contact_fields.hertz_rows(result)]
    picture = Picture(
        partial(versus_hertz, result),
        "Mean and maximum pressure over the distance from the middle, and that of the smooth "
        "bodies. Compare how far roughness spreads the load.",
        page.HALF,
    )
    shapes = capitalize_first(contact_fields.hertz_shapes(contact))
    return [
        Block("head", "Compared with the smooth bodies (Hertz)"),
        Block("small", f"{shapes}. {contact_fields.HERTZ_SIZE}"),
        Block("aside", (picture, [PageTable(rows, ("", *contact_fields.hertz_heads(result)[1:]))])),
        *(Block("small", page.as_sentence(limit.text)) for limit in comparison_limits(result)),
    ]


def _ceiling_head(result: ContactResult) -> str:
    if isinstance(result.ceiling, np.ndarray):
        return "with ceiling"
    return f"ceiling {format_engineering(float(result.ceiling or 0), 'Pa', 3)}"


def _elastic_or_best(solve: Callable[[], ContactResult]) -> ContactResult | None:
    """Return the elastic solution, the best iterate without convergence, or None."""
    try:
        return solve()
    except ConvergenceError as error:
        # The report marks the column as not converged.
        return error.result if isinstance(error.result, ContactResult) else None
    except InsufficientMemoryError:
        # The elastic column is optional.
        return None


_CALIBRATED = (
    "contact_area",
    "contact_fraction",
    "saturated_fraction",
    "mean_pressure",
    "mean_gap",
    "approach",
)


def calibrated_numbers(result: Any) -> dict[str, str]:
    """Return the values under the calibrated ceiling, by key; empty if it changes nothing."""
    other = getattr(result, "calibrated", None)
    if other is None or not other.differs:
        return {}
    return {key: quantity_of(contact_fields.CONTACT, key).row(other).text for key in _CALIBRATED}


# Relative difference up to which rough and smooth contact areas are treated as equal.
_AREA_TOLERANCE = 0.05


def _ends(interval: Interval | None, form: Callable[[float], str]) -> str:
    # A quantity that plasticity changes by an unknown amount has no interval.
    if interval is None or Cause.YIELDING in interval.unknown or interval.low == interval.high:
        return ""
    if math.isinf(interval.high):
        return " (depends on the pixel, no limit)"
    text = range_text(interval.low, interval.high, form)
    if interval.measured is not None:
        return f" ({text} in 95 of 100; as measured {form(interval.measured)})"
    return f" ({text})" if text.partition(" to ")[0] != text.rpartition(" to ")[2] else ""


def _hertz_comparison(result: ContactResult, smooth: float, interval: Interval | None) -> str:
    unit = "m" if result.pair.is_profile else "m²"
    ends = _ends(interval, lambda value: format_short(value * result.nominal_area, unit))
    value = result.nominal_area * interval.value if interval else result.contact_area
    area, ratio = format_short(value, unit), value / smooth
    if abs(ratio - 1) < _AREA_TOLERANCE:
        return f"The bodies touch on {area}{ends}, as in Hertz's theory{_yields(result)}"
    known = format_short(smooth, unit)
    if is_beyond_map(result):
        return f"The Hertz contact of {known} is larger than the map; solved: {area}{ends}."
    share = f", {format_share(ratio)} of the Hertz contact{_yields(result)}"
    if not is_smooth(result.pair):
        return f"Roughness carries the load on {area}{ends}{share}"
    if not is_unresolved(result):
        return f"The bodies touch on {area}{ends}{share}"
    return f"The grid does not resolve the Hertz contact of {known}; solved: {area}{ends}{share}"


_YIELDING = {
    Regime.BELOW_FIRST_YIELD: "nothing yields",
    Regime.YIELDING_BELOW: "it yields below the surface",
    Regime.BEYOND_CEILING: "the elastic pressure exceeds what the metal can carry",
    Regime.BEYOND_HARDNESS: "the elastic pressure exceeds the hardness",
    Regime.UNKNOWN: "yielding is unknown without a yield strength",
}


def _yields(result: ContactResult) -> str:
    if result.regime is Regime.SATURATED:
        saturated, area = (_value(result, f"{what}_fraction") for what in ("saturated", "contact"))
        return f"; {format_share(min(saturated / area, 1.0))} of that is at the pressure ceiling."
    return "." if result.pair.is_coated else f"; {_YIELDING[result.regime]}."


def _value(result: ContactResult, name: str) -> float:
    """Return a quantity of a contact, corrected for the instrument if known."""
    item = result.measurement and result.measurement.interval(name)
    return float(item.value if item else getattr(result, name))


def _upper(result: ContactResult) -> str:
    """Return the ceiling if it is reached, else the largest pressure, as text."""
    if not result.saturated_fraction or isinstance(result.ceiling, np.ndarray):
        edge = result.ceiling is None and result.totals.edge_load is not None
        limit = ", no limit at the map edge" if edge else ""
        return f"{format_short(result.max_pressure, 'Pa')} peak{limit}"
    assert result.ceiling is not None
    return f"ceiling {format_short(float(result.ceiling), 'Pa')}{_in_strengths(result)}"


def _in_strengths(result: ContactResult) -> str:
    body = result.pair.softer
    if body is None or body.yield_strength is None:
        return ""
    return f" ({float(result.ceiling or 0) / body.yield_strength:.3g} σ_Y)"


class ContactPresentation(Presentation):
    """Presentation of a contact, alone and in the reports of other results."""

    result: ContactResult
    table = contact_fields.CONTACT
    figures = CONTACT
    plots = (
        maps.overview,
        maps.pressure,
        maps.contact,
        maps.gap,
        maps.close_up,
        maps.spots,
        section,
        pressure_histogram,
    )
    profile_table = contact_fields.PROFILE_CONTACT
    profile_figures = PROFILE_CONTACT
    profile_plots = (loaded_profile,)

    def works(self) -> Iterator[Use]:
        """Yield the works on the study of the grid."""
        if self.study is not None:
            yield make_use("grid convergence index", "Roache1994")

    @cached_property
    def contact(self) -> ContactResult:
        """The result."""
        return self.result

    @cached_property
    def scene(self) -> ContactScene:
        """Scene of the contact."""
        return ContactScene(self.result)

    def question(self) -> str:
        """Return the question that a contact answers."""
        result = self.result
        name, under = phrases.source(result.surface.provenance), phrases.load_phrase(result)
        if result.control == "approach":
            return f"Which load does {name} carry {under}?"
        if result.hertz is not None:
            return f"How large is the contact of {name} {under}?"
        return f"How much of {name} is in contact {under}?"

    def answer(self) -> str:
        """Return contact area with its interval, and yielding, as a sentence."""
        result = self.result
        if not result.converged:
            return "No solution: do not use these numbers."
        if not result.contact_area:
            return "The bodies do not touch."
        interval = uncertainty_report.area_interval(result, self.study)
        smooth = result.hertz if contact_fields.is_hertz_compared(result) else None
        if smooth is not None:
            return _hertz_comparison(result, smooth.area, interval)
        what = "profile" if result.pair.is_profile else "face"
        ends = _ends(interval, format_share)
        share = format_share(interval.value if interval else result.contact_fraction)
        return f"{share} of the {what} is in contact{ends}{_yields(result)}"

    def numbers(self) -> CellTable:
        """Return the main quantities of a contact."""
        result = self.result
        if not result.contact_area:
            return (), [("Load", format_short(result.load, result.pair.load_unit))]
        if result.measurement is not None:
            return uncertainty_report.CORRECTED, uncertainty_report.corrected_rows(result)
        if contact_fields.is_hertz_compared(result):
            return contact_fields.hertz_heads(result), contact_fields.hertz_rows(result)
        unit, what = ("m", "length") if result.pair.is_profile else ("m²", "area")
        nominal = format_short(result.nominal_area, unit)
        area = f"{format_short(result.contact_area, unit)} of {nominal}"
        area += f", {count_noun(result.spots().count, 'spot')}"
        rows = [
            (f"Real contact {what}", area),
            (
                "Contact pressure",
                f"{format_short(result.load / result.contact_area, 'Pa')} mean; {_upper(result)}",
            ),
            ("Mean gap", format_short(result.mean_gap, "m")),
        ]
        if result.control == "load":
            rows.append(("Approach", f"{format_short(result.approach, 'm')} from first contact"))
        else:
            rows.insert(0, ("Load", format_short(result.load, result.pair.load_unit)))
        if result.saturated_fraction:
            depth = format_short(result.totals.max_indentation, "m")
            rows.append(("Residual indentation", f"{depth} at most"))
        if result.moments is not None:
            rows.append(
                ("Tilt (y, x)", ", ".join(format_short(value, "rad") for value in result.tilt))
            )
        return (), rows

    def remarks(self) -> Iterator[str]:
        """Yield the sources of the interval, the calibrated results, and the status."""
        result = self.result
        if result.converged:
            interval = uncertainty_report.area_interval(result, self.study) if result.load else None
            if interval is not None:
                yield uncertainty_report.sources(
                    interval,
                    hint=not result.pair.is_profile,
                    instrument=uncertainty_report.is_correctable(result),
                )
            if result.measurement is not None:
                yield from result.measurement.remarks
        yield phrases.status(result)

    def meaning(self) -> str:
        """Return the regime of the contact."""
        return phrases.regime(self.result)

    def results(self) -> list[Block]:
        """Return the blocks with all results of a contact, with an elastic column if drawn."""
        elastic = None
        if self.is_drawn and self.result.saturated_fraction > 0:
            elastic = _elastic_or_best(self.result.elastic)
        answer = self._results_table(elastic)
        if elastic is not None and not elastic.converged:
            answer.append(
                Block(
                    "warning",
                    "The elastic solution did not converge: certificate "
                    f"{elastic.certificate:.1e}, limit {elastic.tolerance:.0e}. Its column is not "
                    "a solution.",
                )
            )
        answer += self.figure_blocks(FRONT)[1:]
        answer += self.figure_blocks()
        return [*answer, *hertz_blocks(self.result)]

    def _results_table(self, elastic: ContactResult | None) -> list[Block]:
        """Return the block of all results: a column for each ceiling, the elastic one last."""
        result = self.result
        heads, answer = self.rows_by_ceiling(brief=True)
        others = {}
        if elastic is not None:
            heads = (*(heads or (_ceiling_head(result),)), "elastic")
            others = {row.key: row.text for row in type(self)(elastic).rows(brief=True)}
        rows = [
            (row.title, *texts, *((others.get(row.key, ABSENT),) if others else ()), row.meaning)
            for row, texts in answer
        ]
        if result.load:
            empty = ("",) * (len(heads or ("value",)) - 1)
            rows += [(name, text, *empty, note) for name, text, note in spot_rows(result)]
        return chapters.table(rows, ("quantity", *(heads or ("value",)), "meaning"), "wide")

    def rows_by_ceiling(self, brief: bool = False) -> tuple[Cells, list[tuple[Row, Cells]]]:
        """Return heads and rows, with a second column if the calibrated ceiling differs."""
        answer, calibrated = self.rows(brief=brief), calibrated_numbers(self.result)
        if not calibrated:
            return (), [(row, (row.text,)) for row in answer]
        return phrases.ceiling_heads(self.result, self.result.calibrated), [
            (row, (row.text, calibrated.get(row.key, ""))) for row in answer
        ]

    def contact_blocks(self) -> list[Block]:
        """Return the blocks on the contact under the largest load, for other results."""
        result, scene = self.result, self.scene
        other = "approach" if result.control == "load" else "load"
        keys = (*contact_fields.HEADLINES, other, "max_residual_indentation")
        known = [key for key in keys if quantity_of(self.own("table"), key).is_shown(result)]
        rows = [
            *chapters.cells(replace(self.row(key), symbol="") for key in known),
            *spot_rows(result),
        ]
        load = format_engineering(result.total_load, result.pair.load_unit)
        head = f"Contact under {load}, the largest load"
        front = self.figure_blocks(FRONT)
        if not (result.pair.is_profile or scene.is_sparse):
            # The gap is that of the deformed bodies, also after a load history.
            front += self.figure_blocks()
        count = 1 if result.pair.is_profile or scene.is_sparse else 2
        shown = [*chapters.table(rows, style="key"), *front[:count], *hertz_blocks(result)]
        return [Block("head", head), *shown]

    def uncertainty(self) -> list[Block]:
        """Return the blocks on the intervals of a contact and their contributions."""
        result, study = self.result, self.study
        if not (result.converged and result.load):
            return []
        measured, known = result.measurement, uncertainty_report.intervals_by_key(result, study)
        rows = [
            (capitalize_first(name), interval, causes)
            for name, interval, causes in uncertainty_report.uncertainty_rows(result, study)
            if interval in known.values()
        ]
        head = "interval" if measured is None else "95 % interval"
        blocks = chapters.table(rows, ("quantity", head, "contributions"))
        blocks += uncertainty_report.budget_block(result, study)
        others = [
            quantity_of(self.own("table"), key).name for key in QUANTITIES if key not in known
        ]
        if measured is not None:
            blocks.append(Block("small", uncertainty_report.measurement_text(measured)))
            blocks += [Block("small", remark) for remark in measured.remarks]
        else:
            hint = ""
            if study is None:
                hint = f" The pixel was not studied ({uncertainty_report.STUDY_REF})."
            if uncertainty_report.is_correctable(result):
                hint += f" The instrument was not given ({uncertainty_report.INSTRUMENT_REF})."
            text = Sentence(f"No interval is known of: {', '.join(others)}.{hint}")
            blocks.append(Block("small", text))
        formula = chapters.cells(rows_of(formulas.BY_FORMULA, result))
        blocks += chapters.table([(name, text) for name, text, _ in formula])
        if study is not None:
            blocks += [Block("text", " ".join(study.sentences))]
            blocks += uncertainty_report.StudyPresentation(study).steps()
        return [*blocks, Block("small", uncertainty_report.NOT_INCLUDED)]

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write maps or quantities; the suffix selects the format."""
        export.save_contact(self.result, path)

    def dataset(self) -> Dataset:
        """Return maps and quantities."""
        return archive.to_dataset(self.result)
