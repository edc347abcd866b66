"""A report on a result: one HTML file that needs nothing else and prints to A4.

Everything in it comes from the results that are handed over; nothing is solved here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from roughcontact.contact import judgment
from roughcontact.contact.cautions import ordered
from roughcontact.contact.curve import LoadCurve
from roughcontact.contact.result import ContactResult
from roughcontact.contact.slab import Share, Slab
from roughcontact.contact.solve import under
from roughcontact.contact.study import ResolutionStudy
from roughcontact.errors import ConvergenceError, InputError, InsufficientMemoryError
from roughcontact.formats import export
from roughcontact.plots import maps, profiles, reduced, traces as draw
from roughcontact.references import NO_REFERENCES
from roughcontact.report import (
    blocks,
    chapters,
    curve as curves,
    figures,
    inputs,
    page,
    profile,
    regimes,
    script,
    smooth,
    sources,
    studied,
    sureness,
    tables,
    traces,
)
from roughcontact.report.blocks import Block, Blocks, Cautions, Lines
from roughcontact.report.kind import Kind
from roughcontact.report.page import PLAIN, Addition, Cells, Chapter, Edition, Table
from roughcontact.report.quantities import (
    ABSENT,
    ANSWER,
    PROBLEM,
    TRUST,
    Row,
    beside,
    capital,
    quantity_of,
    rows_of,
)
from roughcontact.units import engineering, percent


def render(
    result: ContactResult,
    edition: Edition = PLAIN,
    *,
    elastic: ContactResult | None = None,
    usual: ContactResult | None = None,
    curve: LoadCurve | None = None,
    study: ResolutionStudy | None = None,
    additions: Sequence[Addition] = (),
) -> str:
    """Return a report as the text of an HTML file.

    Parameters
    ----------
    result : ContactResult
        What the report is on.
    edition : Edition
        Command, date, and how it is drawn and worded.
    elastic : ContactResult, optional
        The same problem without a ceiling, to stand beside it; see `ContactResult.elastic`. It
        is left out where the ceiling is reached nowhere.
    usual : ContactResult, optional
        The same problem with three yield strengths, where the ceiling was recommended.
    curve : LoadCurve, optional
        The same contact under other loads, for a chapter of its own.
    study : ResolutionStudy, optional
        The same contact on other grids, for a chapter and for how sure the numbers are.
    additions : sequence of Addition
        Further chapters.

    Returns
    -------
    str
        HTML with its figures inside: no other file, no network and no script is needed.

    Raises
    ------
    InputError
        If the elastic result has another grid.
    """
    _check_alike(result, elastic=elastic, usual=usual)
    found = _chapters(result, elastic, usual, study)
    if curve is not None:
        found.append(curves.chapter(curve))
    if study is not None:
        found.append(_study(study))
    found += [chapters.added(addition) for addition in additions]
    lines = "" if result.pair.is_shared else script.repeating(result)
    found += [exactness(result), chapters.repetition(result.version, edition.command, lines)]
    works = sources.of(KIND, result) + (
        NO_REFERENCES if curve is None else sources.of(curves.KIND, curve)
    )
    found.append(sources.chapter(works, additions))
    return page.render(
        found,
        title=_title(result),
        subtitle=chapters.subtitle(result),
        edition=edition,
        status=result.status,
        key_numbers=_key_numbers(result),
        regime=result.regime,
        regime_text=regimes.regime(result),
        certificate=_certificate_in_short(result),
        cautions=ordered([*result.cautions, *(c for a in additions for c in a.cautions)]),
        checked=judgment.checked(result),
    )


def _chapters(
    result: ContactResult,
    elastic: ContactResult | None,
    usual: ContactResult | None,
    study: ResolutionStudy | None,
) -> list[Chapter]:
    """Return what every report on a contact has."""
    kind = kind_of(result)
    given = [kind.row(result, result.control), *kind.rows(result, PROBLEM)]
    if result.pair.is_shared:
        pressed = chapters.problem(result, given, "ceiling")
        return [_input(result.share), pressed, results_chapter(result, study)]
    spots = result.spots()
    stated = chapters.stated(result, spots)
    found = [
        *chapters.prepared(result),
        chapters.problem(result, given, "ceiling"),
        chapters.assumed(stated, result.cautions),
        results_chapter(result, study),
        *chapters.smooth_beside_rough(result),
        *([] if result.pair.is_profile else [sections(result)]),
        chapters.contact_spots(result, spots),
    ]
    if result.saturated_fraction > 0:
        found.append(comparison(result, elastic, usual))
    return found


def _input(share: Share) -> Chapter:
    """Return the chapter on a map that several ranks hold."""
    chapter = Chapter("Input and preparation")
    rows = rows_of(inputs.table_of(share), share, brief=True)
    chapter.add("table", Table([(row.title, row.text) for row in rows]))
    chapter.add("steps", [page.sentence(step) for step in share.provenance.steps])
    return chapter


def _blocks(result: ContactResult, maps: Sequence[Any]) -> Addition:
    """Return the chapter with reduced maps of a contact whose map several ranks hold."""
    found = reduced.figures(result.share.size, *maps)
    drawn = tuple((f"{name}.", draw()) for name, draw in found.items())
    return Addition("Maps in blocks of points", figures=drawn)


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
    additions: Sequence[Addition] = (),
    study: ResolutionStudy | None = None,
) -> str:
    """Return a report as `render`; one with saturated pixels is solved without a ceiling beside it.

    One with a recommended ceiling is solved with three yield strengths, too.
    """
    elastic = usual = None
    if result.saturated_fraction > 0:
        elastic = _best(result.elastic)
        if result.recommended is not None:
            usual = _best(lambda: under(result, "auto"))
    return render(result, edition, elastic=elastic, usual=usual, additions=additions, study=study)


def _shared(
    result: ContactResult,
    edition: Edition = PLAIN,
    additions: Sequence[Addition] = (),
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
    keys = [*tables.HEADLINES, other]
    beside = under_calibrated(result)
    headlines = chapters.headlines(kind_of(result), result, keys)
    told: list[Cells] = [
        (name, text, f"{meaning}; {beside[key]} with the calibrated ceiling")
        if key in beside
        else (name, text, meaning)
        for key, (name, text, meaning) in zip(keys, headlines, strict=True)
    ]
    if result.ceiling is not None:
        return told
    elastic = ABSENT, "purely elastic: no ceiling"
    saturated = tables.HEADLINES.index("saturated_fraction")
    told[saturated] = (told[saturated][0], *elastic)
    return told


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
    told = [(row.title, *texts, row.meaning) for row, texts in answer]
    chapter.add("table", Table(told, ("quantity", *(heads or ("value",)), "meaning")))
    if result.converged and result.load:
        chapter.add("text", f"{sureness.WHAT} {sureness.NOT_BOUNDED}")
        told = [(capital(name), *texts) for name, *texts in sureness.rows(result, study)]
        chapter.add("table", Table(told, sureness.HEADS))
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
    told = [*_beside(several, ANSWER), *_beside(several, TRUST)]
    chapter.add("table", Table(told, ("", *shown)))
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
                profiles.pressure_histogram, list(shown.values()), list(shown),
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
    told = beside(kind_of(pair[0]).table, pair, part, brief=True)
    # What three yield strengths gave has a column of its own.
    return [(capital(row.name), *texts) for row, texts in told if row.key != "recommended"]


# Elastic over limited pressure from which a linear axis would squeeze one of them.
_WIDE_RANGE = 4.0


def _study(study: ResolutionStudy) -> Chapter:
    chapter = Chapter("Can it be trusted")
    for sentence in study.sentences:
        chapter.add("text", sentence)
    head, rows = studied.KIND.listing(study)
    chapter.add("table", Table(rows, head))
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
    chapter.add("table", Table([(row.title, row.text) for row in rows]))
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
    return {key: quantity_of(tables.CONTACT, key).row(other).text for key in _CALIBRATED}


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
    found, told = kind.rows(result, brief=brief), under_calibrated(result)
    if not told:
        return (), [(row, (row.text,)) for row in found]
    return _ceilings(result), [(row, (row.text, told.get(row.key, ""))) for row in found]


def shown(result: ContactResult, study: ResolutionStudy | None = None) -> Blocks:
    """Return what the console shows: problem, answer, trust and how sure; then cautions, study."""
    kind = kind_of(result)
    heads, answer = beside_calibrated(kind, result, brief=True)
    problem, trust = blocks.problem(kind, result, result), blocks.trust(kind, result)
    told = [(blocks.title(row), *texts) for row, texts in answer]
    parts = blocks.table(problem, told, trust)
    if heads:
        parts = [Block((problem,)), Block((told,), ("", *heads)), Block((trust,))]
    if result.converged and result.load:
        parts += blocks.table(sureness.rows(result, study), heads=sureness.HEADS)
    if smooth.applies(result):
        parts += blocks.table(smooth.rows(result), heads=smooth.HEADS)
    parts.append(Cautions(result.cautions))
    if study is not None:
        parts += [*blocks.steps(studied.KIND, study), Lines(study.sentences)]
    return parts


KIND = Kind(
    ContactResult, tables.CONTACT, figures=figures.CONTACT, scene=figures.ContactScene,
    plots=(
        maps.overview, maps.pressure, maps.contact, maps.gap, maps.close_up, maps.spots,
        profiles.section, profiles.pressure_histogram,
    ),
    works=sources.of_contact, save=export.save_contact, report=compared, blocks=shown,
)  # fmt: skip
PROFILE_KIND = replace(
    KIND, table=profile.CONTACT, when=lambda result: result.pair.is_profile,
    figures=traces.CONTACT, plots=(draw.pressed,),
)  # fmt: skip

SHARED_KIND = replace(
    KIND, table=tables.SHARED, when=lambda result: result.pair.is_shared, figures=(), plots=(),
    report=_shared, ranks=lambda result: result.share.ranks,
)  # fmt: skip


def kind_of(result: ContactResult) -> Kind:
    """Return the kind of a contact: of a map in one place or on several ranks, or of a profile."""
    if result.pair.is_shared:
        return SHARED_KIND
    return PROFILE_KIND if result.pair.is_profile else KIND
