"""A report on a result: one HTML file that needs nothing else and prints to A4.

Everything in it comes from the results that are handed over; nothing is solved here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from roughcontact.cautions import ordered
from roughcontact.contact import plausibility
from roughcontact.contact.result import ContactResult, Regime
from roughcontact.contact.share import Share, Slab
from roughcontact.contact.solve import with_ceiling
from roughcontact.errors import ConvergenceError, InputError, InsufficientMemoryError
from roughcontact.formats import export
from roughcontact.plots import cells, maps, profiles as draw
from roughcontact.plots.sections import pressure_histogram, section
from roughcontact.references import NO_REFERENCES
from roughcontact.report import (
    blocks,
    chapters,
    citations,
    contact_fields,
    figures,
    hertz_comparison,
    inputs,
    load_curve as curves,
    page,
    problem,
    python_script,
    regimes,
    uncertainty,
)
from roughcontact.report.blocks import Block, Blocks, Cautions, Lines
from roughcontact.report.fields import (
    ABSENT,
    ANSWER,
    PROBLEM,
    TRUST,
    Row,
    capital,
    quantity_of,
    rows_of,
    side_by_side,
)
from roughcontact.report.kind import CellTable, Kind
from roughcontact.report.page import PLAIN, Cells, Chapter, Edition, ExtraChapter, PageTable
from roughcontact.studies.load_curve import LoadCurve
from roughcontact.studies.resolution_study import ResolutionStudy
from roughcontact.studies.uncertainty import Interval
from roughcontact.units import changed_by, counted, engineering, percent


def render(
    result: ContactResult,
    edition: Edition = PLAIN,
    *,
    elastic: ContactResult | None = None,
    usual: ContactResult | None = None,
    curve: LoadCurve | None = None,
    study: ResolutionStudy | None = None,
    additions: Sequence[ExtraChapter] = (),
) -> str:
    """Return a report as the text of an HTML file."""
    _check_alike(result, elastic=elastic, usual=usual)
    answer = _chapters(result, elastic, usual, study)
    if curve is not None:
        answer.append(curves.chapter(curve))
    if study is not None:
        answer.append(_study(study))
    answer += [chapters.added(addition) for addition in additions]
    lines = "" if result.pair.is_shared else python_script.repeating(result)
    answer += [exactness(result), chapters.repetition(result.version, edition.command, lines)]
    works = citations.of(KIND, result) + (
        NO_REFERENCES if curve is None else citations.of(curves.KIND, curve)
    )
    answer.append(citations.chapter(works, additions))
    return page.render(
        answer,
        title=_title(result),
        subtitle=chapters.subtitle(result),
        edition=edition,
        status=result.status,
        key_numbers=_key_numbers(result),
        regime=result.regime,
        regime_text=regimes.regime(result),
        certificate=_certificate_in_short(result),
        cautions=ordered([*result.cautions, *(c for a in additions for c in a.cautions)]),
        checked=plausibility.checked(result),
    )


def _chapters(
    result: ContactResult,
    elastic: ContactResult | None,
    usual: ContactResult | None,
    study: ResolutionStudy | None,
) -> list[Chapter]:
    """Return what every report on a contact has."""
    kind = kind_of(result)
    specified = [kind.row(result, result.control), *kind.rows(result, PROBLEM)]
    if result.pair.is_shared:
        pressed = chapters.problem(result, specified, "ceiling")
        return [_input(result.share), pressed, results_chapter(result, study)]
    spots = result.spots()
    stated = chapters.stated(result, spots)
    answer = [
        *chapters.prepared(result),
        chapters.problem(result, specified, "ceiling"),
        chapters.assumed(stated, result.cautions),
        results_chapter(result, study),
        *chapters.smooth_beside_rough(result),
        *([] if result.pair.is_profile else [sections(result)]),
        chapters.contact_spots(result, spots),
    ]
    if result.saturated_fraction > 0:
        answer.append(comparison(result, elastic, usual))
    return answer


def _input(share: Share) -> Chapter:
    """Return the chapter on a map that several ranks hold."""
    chapter = Chapter("Input and preparation")
    rows = rows_of(inputs.table_of(share), share, brief=True)
    chapter.add("table", PageTable([(row.title, row.text) for row in rows]))
    chapter.add("steps", [page.sentence(step) for step in share.provenance.steps])
    return chapter


def _blocks(result: ContactResult, maps: Sequence[Any]) -> ExtraChapter:
    """Return the chapter with reduced maps of a contact whose map several ranks hold."""
    answer = cells.figures(result.share.size, *maps)
    drawn = tuple((f"{name}.", draw()) for name, draw in answer.items())
    return ExtraChapter("Maps in blocks of points", figures=drawn)


def _check_alike(result: ContactResult, **others: ContactResult | None) -> None:
    for name, other in others.items():
        if other is not None and other.pressure.shape != result.pressure.shape:
            raise InputError(
                f"has {other.pressure.shape} pixels and the result {result.pressure.shape}; "
                "give the solution of the same problem, such as result.elastic()",
                argument=name,
            )


def compared(
    result: ContactResult,
    edition: Edition = PLAIN,
    additions: Sequence[ExtraChapter] = (),
    study: ResolutionStudy | None = None,
) -> str:
    """Return a report as `render`."""
    elastic = usual = None
    if result.saturated_fraction > 0:
        elastic = _best(result.elastic)
        if result.calibration is not None:
            usual = _best(lambda: with_ceiling(result, "auto"))
    return render(result, edition, elastic=elastic, usual=usual, additions=additions, study=study)


def _shared(
    result: ContactResult,
    edition: Edition = PLAIN,
    additions: Sequence[ExtraChapter] = (),
    study: ResolutionStudy | None = None,
) -> str:
    """Return a report as `render`, with reduced maps; all ranks that hold the map call it."""
    share, gap, pressure = result.share, result.gap, result.pressure
    assert isinstance(share, Slab)
    blocks = [share.reduced(values, largest=values is pressure)
              for values in (share.heights, pressure, gap)]  # fmt: skip
    return share.ranks.by_first(
        lambda: render(
            result, edition, study=study, additions=[*additions, _blocks(result, blocks)]
        )
    )


def _best(solve: Callable[[], ContactResult]) -> ContactResult | None:
    """Return the same problem under another ceiling, or the best that was found of it."""
    try:
        return solve()
    except ConvergenceError as error:
        # The chapter shows it as what it is.
        return error.result if isinstance(error.result, ContactResult) else None
    except InsufficientMemoryError:
        # The chapter says that there is none; the report stays worth having.
        return None


def _title(result: ContactResult) -> str:
    name = result.share.provenance.source or "an unnamed surface"
    if result.control == "load":
        return f"Contact of {name} under {engineering(result.load, result.pair.load_unit)}"
    return f"Contact of {name} at an approach of {engineering(result.approach, 'm')}"


def _key_numbers(result: ContactResult) -> list[Cells]:
    other = "approach" if result.control == "load" else "load"
    keys = [*contact_fields.HEADLINES, other]
    reference = under_calibrated(result)
    headlines = chapters.headlines(kind_of(result), result, keys)
    cells: list[Cells] = [
        (name, text, f"{meaning}; {reference[key]} with the calibrated ceiling")
        if key in reference
        else (name, text, meaning)
        for key, (name, text, meaning) in zip(keys, headlines, strict=True)
    ]
    if result.ceiling is not None:
        return cells
    elastic = ABSENT, "purely elastic: no ceiling"
    saturated = contact_fields.HEADLINES.index("saturated_fraction")
    cells[saturated] = (cells[saturated][0], *elastic)
    return cells


def _certificate_in_short(result: ContactResult) -> str:
    if result.converged:
        return (
            f"Certificate {result.certificate:.1e}, asked for {result.tolerance:.0e}: pressure and "
            "gap fulfil the conditions of contact to within this part of the pressure. It says how "
            f"exactly the problem as stated is solved. {chapters.RIGHT_PROBLEM}"
        )
    return (
        f"Certificate {result.certificate:.1e}, asked for {result.tolerance:.0e}: the solver "
        "stopped before it had a solution. Do not use these numbers."
    )


def results_chapter(result: ContactResult, study: ResolutionStudy | None) -> Chapter:
    """Return the chapter on what came out, and how sure it is."""
    chapter = Chapter("Results")
    heads, answer = beside_calibrated(kind_of(result), result)
    rows = [(row.title, *texts, row.meaning) for row, texts in answer]
    chapter.add("table", PageTable(rows, ("quantity", *(heads or ("value",)), "meaning")))
    if result.converged and result.load:
        chapter.add("text", f"{uncertainty.WHAT} {uncertainty.NOT_BOUNDED}")
        rows = [
            (capital(name), *texts) for name, *texts in uncertainty.uncertainty_rows(result, study)
        ]
        chapter.add("table", PageTable(rows, uncertainty.HEADS))
    if not result.pair.is_shared:
        chapters.show(chapter, kind_of(result).figures, figures.ContactScene(result))
    return chapter


def sections(result: ContactResult) -> Chapter:
    """Return the chapter on sections through the highest peak."""
    chapter = Chapter("Sections through the highest peak")
    scene = figures.ContactScene(result)
    chapters.show(chapter, figures.CONTACT, scene, figures.SECTIONS)
    return chapter


def comparison(
    result: ContactResult, elastic: ContactResult | None, usual: ContactResult | None = None
) -> Chapter:
    """Return the chapter that sets the same problem under other ceilings beside it."""
    chapter = Chapter("Elastic beside ceiling")
    if elastic is None:
        chapter.add(
            "text",
            "No solution of the same problem without a ceiling was given to this report.",
        )
        return chapter
    chapter.add(
        "text",
        "The same surfaces under the same load, once without a ceiling, once with it. The ceiling "
        "takes load from the highest peaks and lays it on their surroundings: the contact grows, "
        "and the bodies come closer."
        + (" Between them stands the usual ceiling, three yield strengths." if usual else ""),
    )
    between = {} if usual is None else {_label(usual): usual}
    shown = {"elastic": elastic, **between, _label(result): result}
    for name, other in (("elastic solution", elastic), ("solution with three", usual)):
        if other is not None and not other.converged:
            chapter.add(
                "warning",
                f"The {name} did not converge: certificate {other.certificate:.1e}, asked for "
                f"{other.tolerance:.0e} ({other.status}). Its column and its maps show the best "
                "that was found, not a solution.",
            )
    inside = int(np.count_nonzero(elastic.contact & result.contact))
    touching = int(np.count_nonzero(elastic.contact))
    several = tuple(shown.values())
    rows = [*_beside(several, ANSWER), *_beside(several, TRUST)]
    chapter.add("table", PageTable(rows, ("", *shown)))
    if touching:
        chapter.add(
            "text",
            f"{percent(inside / touching)} of the elastic contact also touches with the ceiling.",
        )
    if not result.pair.is_profile:
        _draw_comparison(chapter, shown)
    return chapter


def _draw_comparison(chapter: Chapter, shown: dict[str, ContactResult]) -> None:
    """Add maps of the first and the last of some solutions, and histograms of all."""
    (name, elastic), *_, (label, result) = shown.items()
    chapter.add(
        "figure",
        page.picture(
            partial(maps.comparison, (elastic, result), [name, label]),
            "Maps of pressure and contact, elastic on the left and with the ceiling on the right.",
            "Pressure above, contact below; elastic on the left, with the ceiling on the right. "
            "Both pressures have the same colours; where the elastic pressure exceeds what the "
            "ceiling allows it is black.",
        ),
    )
    wide = elastic.max_pressure > _WIDE_RANGE * result.max_pressure
    chapter.add(
        "figure",
        page.picture(
            partial(
                pressure_histogram, list(shown.values()), list(shown),
                scale="log" if wide else "linear",
            ),
            "Histograms of the contact pressure, elastic and with the ceiling.",
            "How the contact area is spread over the pressure, without and with the ceiling"
            + (", on a logarithmic pressure axis." if wide else "."),
        ),
    )  # fmt: skip


def _label(result: ContactResult) -> str:
    if isinstance(result.ceiling, np.ndarray):
        return "with ceiling"
    return f"ceiling {engineering(float(result.ceiling or 0), 'Pa', 3)}"


def _beside(pair: Sequence[ContactResult], part: str) -> list[Cells]:
    rows = side_by_side(kind_of(pair[0]).table, pair, part, brief=True)
    # What three yield strengths gave has a column of its own.
    return [(capital(row.name), *texts) for row, texts in rows if row.key != "calibration"]


# Elastic over limited pressure from which a linear axis would squeeze one of them.
_WIDE_RANGE = 4.0


def _study(study: ResolutionStudy) -> Chapter:
    chapter = Chapter("Can it be trusted")
    for sentence in study.sentences:
        chapter.add("text", sentence)
    head, rows = uncertainty.KIND.listing(study)
    chapter.add("table", PageTable(rows, head))
    return chapter


def exactness(result: ContactResult) -> Chapter:
    """Return the chapter on the certificate."""
    chapter = Chapter("How exactly it is solved")
    chapter.add(
        "text",
        "Certificate: ε = ‖p − clip(p − g/K₀₀, 0, p_lim)‖ / ‖p‖, with p the pressure that is "
        "reported, p_lim its ceiling, K₀₀ the displacement of a pixel under unit pressure of its "
        "own, and g a gap that was computed afresh from p after the solver had ended. It is 0 if "
        "no point overlaps without pressure, no point that is pressed stands off, and only "
        "points at the ceiling sink in. It has no unit.",
    )
    rows = kind_of(result).rows(result, TRUST)
    chapter.add("table", PageTable([(row.title, row.text) for row in rows]))
    return chapter


_CALIBRATED = (
    "contact_area", "contact_fraction", "saturated_fraction", "mean_pressure", "mean_gap",
    "approach",
)  # fmt: skip


def under_calibrated(result: Any) -> dict[str, str]:
    """Return what is told under the calibrated ceiling, by key; nothing where it is the same."""
    other = getattr(result, "calibrated", None)
    if other is None or not other.differs:
        return {}
    return {key: quantity_of(contact_fields.CONTACT, key).row(other).text for key in _CALIBRATED}


def _ceilings(result: ContactResult) -> tuple[str, str]:
    """Return the heads of two columns: the ceiling of a result, and the calibrated one."""
    assert result.calibrated is not None
    factors = (result.calibrated.factor * float(result.ceiling or 0) / result.calibrated.ceiling,
               result.calibrated.factor)  # fmt: skip
    own, other = (f"{factor:.3g} σ_Y" for factor in factors)
    return f"ceiling {own}", f"calibrated, {other}"


def beside_calibrated(
    kind: Kind, result: Any, brief: bool = False
) -> tuple[Cells, list[tuple[Row, Cells]]]:
    """Return heads and rows of an answer, with a second column where another ceiling changes it."""
    answer, calibrated = kind.rows(result, brief=brief), under_calibrated(result)
    if not calibrated:
        return (), [(row, (row.text,)) for row in answer]
    return _ceilings(result), [(row, (row.text, calibrated.get(row.key, ""))) for row in answer]


# --- What is said first ---

# Contact areas of rough and smooth bodies that are the same within this.
_ALIKE = 0.05


def answer(result: ContactResult, study: ResolutionStudy | None = None) -> str:
    """Return how much of a face touches, with its interval, and whether it yields."""
    if not result.converged:
        return "No solution: do not use these numbers."
    if not result.contact_area:
        return "The bodies do not touch."
    interval = uncertainty.of_area(result, study)
    smooth = result.hertz if hertz_comparison.applies(result) else None
    if smooth is not None:
        return _beside_hertz(result, smooth.area, interval)
    what = "profile" if result.pair.is_profile else "face"
    ends = _ends(interval, lambda value: problem.share(value))
    share = problem.share(result.contact_fraction)
    return f"{share} of the {what} is in contact{ends}{_yields(result)}"


def _ends(interval: Interval | None, form: Callable[[float], str]) -> str:
    if interval is None or interval.low == interval.high:
        return ""
    if math.isinf(interval.high):
        return " (depends on the pixel, no limit)"
    text = problem.between(interval.low, interval.high, form)
    return f" ({text})" if text.partition(" to ")[0] != text.rpartition(" to ")[2] else ""


def _beside_hertz(result: ContactResult, smooth: float, interval: Interval | None) -> str:
    unit = "m" if result.pair.is_profile else "m²"
    ends = _ends(interval, lambda value: problem.size(value * result.nominal_area, unit))
    area, ratio = problem.size(result.contact_area, unit), result.contact_area / smooth
    if abs(ratio - 1) < _ALIKE:
        return f"The bodies touch on {area}{ends}, as Hertz's theory has it{_yields(result)}"
    return (
        f"Roughness carries the load on {area}{ends}, {problem.share(ratio)} of the Hertz contact."
    )


_YIELDING = {
    Regime.BELOW_FIRST_YIELD: "nothing yields",
    Regime.YIELDING_BELOW: "it yields below the surface",
    Regime.BEYOND_CEILING: "the elastic pressure exceeds what the metal can carry",
    Regime.BEYOND_HARDNESS: "the elastic pressure exceeds the hardness",
    Regime.UNKNOWN: "yielding is unknown without a yield strength",
}


def _yields(result: ContactResult) -> str:
    if result.regime is Regime.SATURATED:
        share = problem.share(result.saturated_fraction / result.contact_fraction)
        return f"; {share} of that is at the pressure ceiling."
    return f"; {_YIELDING[result.regime]}."


def numbers(result: ContactResult, study: ResolutionStudy | None = None) -> CellTable:
    """Return the numbers of a contact that are said first."""
    if not result.contact_area:
        return (), [("Load", problem.size(result.load, result.pair.load_unit))]
    if hertz_comparison.applies(result):
        return hertz_comparison.HEADS, hertz_comparison.rows(result)
    unit, what = ("m", "length") if result.pair.is_profile else ("m²", "area")
    nominal = problem.size(result.nominal_area, unit)
    area = f"{problem.size(result.contact_area, unit)} of {nominal}"
    if not result.pair.is_shared:
        area += f", {counted(result.spots().count, 'spot')}"
    rows = [
        (f"Real contact {what}", area),
        (
            "Contact pressure",
            f"{problem.size(result.load / result.contact_area, 'Pa')} mean; {_upper(result)}",
        ),
        ("Mean gap", problem.size(result.mean_gap, "m")),
    ]
    if result.control == "load":
        rows.append(("Approach", f"{problem.size(result.approach, 'm')} from first contact"))
    else:
        rows.insert(0, ("Load", problem.size(result.load, result.pair.load_unit)))
    if result.saturated_fraction:
        depth = problem.size(result.totals.max_indentation, "m")
        rows.append(("Residual indentation", f"{depth} at most"))
    if result.moments is not None:
        rows.append(("Tilt (y, x)", ", ".join(problem.size(value, "rad") for value in result.tilt)))
    return (), rows


def _upper(result: ContactResult) -> str:
    """Return the ceiling that is reached, or the largest pressure below it."""
    if not result.saturated_fraction or isinstance(result.ceiling, np.ndarray):
        return f"{problem.size(result.max_pressure, 'Pa')} peak"
    assert result.ceiling is not None
    return f"ceiling {problem.size(float(result.ceiling), 'Pa')}{_in_strengths(result)}"


def _in_strengths(result: ContactResult) -> str:
    body = result.pair.softer
    if body is None or body.yield_strength is None:
        return ""
    return f" ({float(result.ceiling or 0) / body.yield_strength:.3g} σ_Y)"


def remarks(result: ContactResult, study: ResolutionStudy | None = None) -> tuple[str, ...]:
    """Return what the interval comes from, the numbers of the other ceiling, and the status."""
    if not result.converged:
        return (problem.status(result),)
    interval = uncertainty.of_area(result, study) if result.load else None
    lines = [] if interval is None else [uncertainty.sources(interval)]
    return tuple(filter(None, (*lines, _calibrated(result), problem.status(result))))


def _calibrated(result: ContactResult) -> str:
    """Return contact and gap under the calibrated ceiling; nothing where they are the same."""
    other = result.calibrated
    if other is None or not other.differs:
        return ""
    area = changed_by(other.contact_fraction / result.contact_fraction - 1)
    gap = changed_by(other.mean_gap / result.mean_gap - 1) if result.mean_gap else "0 %"
    return (
        f"With the calibrated ceiling ({other.factor:.3g} σ_Y): contact "
        f"{problem.share(other.contact_fraction)} ({area}), mean gap "
        f"{problem.size(other.mean_gap, 'm')} ({gap})"
    )


def shown(result: ContactResult, study: ResolutionStudy | None = None) -> Blocks:
    """Return what the console shows: problem, answer, trust and how sure; then cautions, study."""
    kind = kind_of(result)
    heads, answer = beside_calibrated(kind, result, brief=True)
    stated, trust = blocks.problem(kind, result, result), blocks.trust(kind, result)
    rows = [(blocks.title(row), *texts) for row, texts in answer]
    parts = blocks.table(stated, rows, trust)
    if heads:
        parts = [Block((stated,)), Block((rows,), ("", *heads)), Block((trust,))]
    if result.converged and result.load:
        parts += blocks.table(uncertainty.uncertainty_rows(result, study), heads=uncertainty.HEADS)
    if hertz_comparison.applies(result):
        parts += blocks.table(hertz_comparison.rows(result), heads=hertz_comparison.HEADS)
    parts.append(Cautions(result.cautions))
    if study is not None:
        parts += [*blocks.steps(uncertainty.KIND, study), Lines(study.sentences)]
    return parts


KIND = Kind(
    ContactResult, contact_fields.CONTACT, figures=figures.CONTACT, scene=figures.ContactScene,
    plots=(
        maps.overview, maps.pressure, maps.contact, maps.gap, maps.close_up, maps.spots,
        section, pressure_histogram,
    ),
    works=citations.of_contact, save=export.save_contact, report=compared, blocks=shown,
    problem=problem.line, answer=answer, numbers=numbers, remarks=remarks,
)  # fmt: skip
PROFILE_KIND = replace(
    KIND, table=contact_fields.PROFILE_CONTACT, when=lambda result: result.pair.is_profile,
    figures=figures.PROFILE_CONTACT, plots=(draw.pressed,),
)  # fmt: skip

SHARED_KIND = replace(
    KIND,
    table=contact_fields.SHARED,
    when=lambda result: result.pair.is_shared,
    figures=(),
    plots=(),
    report=_shared,
    ranks=lambda result: result.share.ranks,
)


def kind_of(result: ContactResult) -> Kind:
    """Return the kind of a contact: of a map in one place or on several ranks, or of a profile."""
    if result.pair.is_shared:
        return SHARED_KIND
    return PROFILE_KIND if result.pair.is_profile else KIND
