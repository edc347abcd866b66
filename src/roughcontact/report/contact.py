"""A report on a result: one HTML file that needs nothing else and prints to A4.

Everything in it comes from the results that are handed over; nothing is solved here.
"""

from __future__ import annotations

import datetime
import os
from collections.abc import Callable, Sequence
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
from roughcontact.errors import ConvergenceError, InputError, InsufficientMemoryError, Spell
from roughcontact.files import write
from roughcontact.plots import maps, profiles, reduced
from roughcontact.references import NO_REFERENCES
from roughcontact.report import (
    chapters,
    figures,
    inputs,
    page,
    regimes,
    results,
    script,
    sources,
    sureness,
    tables,
)
from roughcontact.report.page import Addition, Cells, Chapter, Table
from roughcontact.report.quantities import ABSENT, ANSWER, PROBLEM, TRUST, beside, capital, rows_of
from roughcontact.units import engineering, percent


def render(
    result: ContactResult,
    *,
    elastic: ContactResult | None = None,
    usual: ContactResult | None = None,
    curve: LoadCurve | None = None,
    study: ResolutionStudy | None = None,
    additions: Sequence[Addition] = (),
    command: str = "",
    date: datetime.date | None = None,
    spell: Spell = str,
    processes: int = 1,
) -> str:
    """Return a report as the text of an HTML file.

    Parameters
    ----------
    result : ContactResult
        What the report is on.
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
    command : str
        What was typed to get the result. Without it a Python script is given, see
        `script.repeating`.
    date : date, optional
        Date of the report; today by default.
    spell : callable
        ``spell(mention)`` returns the words for an argument; those of Python without.
    processes : int
        How many may draw its figures; see `sharing.pngs`.

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
        found.append(chapters.load_curve(curve))
    if study is not None:
        found.append(_study(study))
    found += [chapters.added(addition) for addition in additions]
    lines = "" if result.pair.is_shared else script.repeating(result)
    found += [exactness(result), chapters.repetition(result.version, command, lines)]
    works = sources.of(result) + (NO_REFERENCES if curve is None else sources.of(curve))
    found.append(sources.chapter(works, additions))
    return page.render(
        found,
        title=_title(result),
        subtitle=chapters.subtitle(result),
        date=date,
        status=result.status,
        key_numbers=_key_numbers(result),
        regime=result.regime,
        regime_text=regimes.regime(result),
        certificate=_certificate_in_short(result),
        cautions=ordered([*result.cautions, *(c for a in additions for c in a.cautions)]),
        checked=judgment.checked(result),
        spell=spell,
        processes=processes,
    )


def _chapters(
    result: ContactResult,
    elastic: ContactResult | None,
    usual: ContactResult | None,
    study: ResolutionStudy | None,
) -> list[Chapter]:
    """Return what every report on a contact has."""
    if result.pair.is_shared:
        given = [results.row(result, result.control), *results.rows(result, PROBLEM)]
        pressed = chapters.problem(result, given, "ceiling")
        return [_input(result.share), pressed, results_chapter(result, study)]
    spots = result.spots()
    stated = chapters.stated(result, spots)
    given = [results.row(result, result.control), *results.rows(result, PROBLEM)]
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


def save(
    result: ContactResult,
    path: str | os.PathLike[str],
    *,
    elastic: ContactResult | None = None,
    usual: ContactResult | None = None,
    curve: LoadCurve | None = None,
    study: ResolutionStudy | None = None,
    additions: Sequence[Addition] = (),
    command: str = "",
    date: datetime.date | None = None,
    spell: Spell = str,
    processes: int = 1,
) -> None:
    """Write a report to an HTML file.

    Parameters
    ----------
    result, elastic, usual, curve, study, additions, command, date, spell, processes
        As for `render`.
    path : str or path
        File to write, ``.html`` or ``.htm``; it appears only once it is complete, and a file
        that was there stays as it was until then.

    Raises
    ------
    InputError
        If the suffix is another one, the folder does not exist, or the elastic result has
        another grid.
    OSError
        If the file cannot be written.
    """
    page.check_path(path)
    text = render(
        result,
        elastic=elastic,
        usual=usual,
        curve=curve,
        study=study,
        additions=additions,
        command=command,
        date=date,
        spell=spell,
        processes=processes,
    )
    write(path, text)


def save_compared(
    result: ContactResult,
    path: str | os.PathLike[str],
    command: str,
    additions: Sequence[Addition],
    study: ResolutionStudy | None,
    spell: Spell = str,
    processes: int = 1,
) -> None:
    """Write a report of a result; one with saturated pixels is solved without a ceiling beside it.

    Parameters
    ----------
    result, path, command, additions, study, spell, processes
        As for `save`; of a map that several ranks hold all of them call this. One with a
        recommended ceiling is solved with three yield strengths, too.
    """
    page.check_path(path)
    if isinstance(result.share, Slab):
        share, gap, pressure = result.share, result.gap, result.pressure
        blocks = [share.reduced(values, largest=values is pressure)
                  for values in (share.heights, pressure, gap)]  # fmt: skip

        def write_first() -> None:
            found = [*additions, _blocks(result, blocks)]
            save(result, path, command=command, additions=found, spell=spell, processes=processes)

        share.ranks.agreed(write_first if share.ranks.first else lambda: None)
        return
    elastic = usual = None
    if result.saturated_fraction > 0:
        elastic = _best(result.elastic)
        if result.recommended is not None:
            usual = _best(lambda: under(result, "auto"))
    save(
        result,
        path,
        elastic=elastic,
        usual=usual,
        command=command,
        additions=additions,
        study=study,
        spell=spell,
        processes=processes,
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
    beside = results.under_calibrated(result)
    told: list[Cells] = [
        (name, text, f"{meaning}; {beside[key]} with the calibrated ceiling")
        if key in beside
        else (name, text, meaning)
        for key, (name, text, meaning) in zip(keys, chapters.headlines(result, keys), strict=True)
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
    heads, answer = results.beside_calibrated(result)
    told = [(row.title, *texts, row.meaning) for row, texts in answer]
    chapter.add("table", Table(told, ("quantity", *(heads or ("value",)), "meaning")))
    if result.converged and result.load:
        chapter.add("text", f"{sureness.WHAT} {sureness.NOT_BOUNDED}")
        told = [(capital(name), *texts) for name, *texts in sureness.rows(result, study)]
        chapter.add("table", Table(told, sureness.HEADS))
    if not result.pair.is_shared:
        chapters.show(chapter, figures.of_contact(result), figures.ContactScene(result))
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
    told = beside(results.table_of(pair[0]), pair, part, brief=True)
    # What three yield strengths gave has a column of its own.
    return [(capital(row.name), *texts) for row, texts in told if row.key != "recommended"]


# Elastic over limited pressure from which a linear axis would squeeze one of them.
_WIDE_RANGE = 4.0


def _study(study: ResolutionStudy) -> Chapter:
    chapter = Chapter("Can it be trusted")
    for sentence in study.sentences:
        chapter.add("text", sentence)
    head, rows = results.listing(study)
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
    rows = results.rows(result, TRUST)
    chapter.add("table", Table([(row.title, row.text) for row in rows]))
    return chapter
