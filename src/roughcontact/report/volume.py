"""A report on a contact with plasticity of the volume, in the form of `report.contact`.

Everything in it comes from the result that is handed over; nothing is solved here.
"""

from __future__ import annotations

import datetime
import os
from collections.abc import Sequence
from dataclasses import dataclass

from roughcontact.contact.cautions import Caution
from roughcontact.errors import Spell
from roughcontact.files import write
from roughcontact.references import References
from roughcontact.report import (
    assumptions_volume,
    chapters,
    details,
    figures,
    page,
    regimes,
    results,
    script,
    sources,
    tables,
)
from roughcontact.report.page import Addition, Cells, Chapter, Table
from roughcontact.report.quantities import PROBLEM, TRUST, rows_of
from roughcontact.units import engineering
from roughcontact.volume import judgment
from roughcontact.volume.result import ElastoplasticResult


@dataclass(frozen=True)
class Lead:
    """What a report says first that is on more than a state of the volume.

    Parameters
    ----------
    title : str
        Of the report.
    key_numbers : list of tuple of str
        Names, values and remarks.
    chapter : Chapter
        The first.
    references : References
        The works behind it.
    cautions : tuple of Caution
        What a reader has to know.
    checked : tuple of str
        What was looked at besides the state, in a few words each.
    """

    title: str
    key_numbers: list[Cells]
    chapter: Chapter
    references: References
    cautions: tuple[Caution, ...]
    checked: tuple[str, ...] = ()


def render(
    result: ElastoplasticResult,
    *,
    lead: Lead | None = None,
    additions: Sequence[Addition] = (),
    command: str = "",
    date: datetime.date | None = None,
    spell: Spell = str,
    processes: int = 1,
) -> str:
    """Return a report as the text of an HTML file.

    Parameters
    ----------
    result : ElastoplasticResult
        What the report is on.
    lead : Lead, optional
        What it says first, where the result is the end of something.
    additions : sequence of Addition
        Further chapters.
    command : str
        What was typed to get the result. Without it a Python script is given, see
        `script.repeating_volume`.
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
    """
    contact = result.solution
    spots = contact.spots()
    stated = assumptions_volume.statements(result, spots)
    lead = lead or _lead(result)
    found = [
        *([lead.chapter] if lead.chapter.title else []),
        *chapters.prepared(contact),
        chapters.problem(contact, results.rows(result, PROBLEM), "volume"),
        chapters.assumed(stated, lead.cautions),
        _results(result),
        *(_volume(result, body) for body in range(len(result.bodies))),
    ]
    if result.increments:
        found.append(_path(result))
    if spots.count:
        found += [*chapters.smooth_beside_rough(contact), chapters.contact_spots(contact, spots)]
    found += [chapters.added(addition) for addition in additions]
    lines = script.repeating_volume(result)
    found += [_certificate(result), chapters.repetition(result.version, command, lines)]
    found.append(sources.chapter(lead.references, additions))
    return page.render(
        found,
        title=lead.title,
        subtitle=chapters.subtitle(contact),
        date=date,
        status=result.status,
        key_numbers=lead.key_numbers,
        regime=result.regime,
        regime_text=regimes.volume_regime(result),
        certificate=_certificate_in_short(result),
        cautions=lead.cautions,
        checked=(*lead.checked, *judgment.checked(result)),
        spell=spell,
        processes=processes,
    )


def _lead(result: ElastoplasticResult) -> Lead:
    """Return what a report on a state alone says first."""
    numbers, works = _key_numbers(result), sources.of(result)
    return Lead(_title(result), numbers, Chapter(""), works, result.cautions)


def save(
    result: ElastoplasticResult,
    path: str | os.PathLike[str],
    *,
    additions: Sequence[Addition] = (),
    command: str = "",
    date: datetime.date | None = None,
    spell: Spell = str,
    processes: int = 1,
) -> None:
    """Write a report to an HTML file.

    Parameters
    ----------
    result, additions, command, date, spell, processes
        As for `render`.
    path : str or path
        File to write, ``.html`` or ``.htm``; it appears only once it is complete, and a file
        that was there stays as it was until then.

    Raises
    ------
    InputError
        If the suffix is another one, or the folder does not exist.
    OSError
        If the file cannot be written.
    """
    page.check_path(path)
    text = render(
        result, additions=additions, command=command, date=date, spell=spell, processes=processes
    )
    write(path, text)


def _title(result: ElastoplasticResult) -> str:
    name = result.solution.surface.provenance.source or "an unnamed surface"
    if result.solution.load:
        return (
            f"Contact of {name} under {engineering(result.solution.load, 'N')}, with plastic flow"
        )
    if not result.increments:
        return f"Contact of {name}, whose first load was not reached"
    return f"What a load of {_largest_load(result)} left on {name}"


def _largest_load(result: ElastoplasticResult) -> str:
    return engineering(tables.largest_load(result), "N")


def _key_numbers(result: ElastoplasticResult) -> list[Cells]:
    if result.solution.load:
        return chapters.headlines(result, tables.VOLUME_HEADLINES)
    gone = ("Largest load", _largest_load(result), "on the way; it is gone")
    return [*chapters.headlines(result, tables.RELEASED_HEADLINES), gone]


def _certificate_in_short(result: ElastoplasticResult) -> str:
    if not result.converged:
        return (
            "The numbers are those of the last load that was reached, "
            f"{engineering(result.solution.load, 'N')}."
        )
    text = (
        "In the last iteration of each increment the plastic strain changed by "
        f"{result.residual:.1e} of itself or less, asked for {result.tolerance:.0e}"
    )
    if result.solution.load:
        text += (
            f"; certificate of the contact {result.solution.certificate:.1e}. Both say how exactly "
            "the problem as stated is solved"
        )
    return f"{text}. {chapters.RIGHT_PROBLEM}"


def _results(result: ElastoplasticResult) -> Chapter:
    chapter = Chapter("Results")
    chapter.add("table", chapters.quantities(results.rows(result)))
    chapters.show(chapter, figures.VOLUME, figures.VolumeScene(result))
    return chapter


def _volume(result: ElastoplasticResult, body: int) -> Chapter:
    scene = figures.VolumeScene(result, body)
    chapter = Chapter(f"Plastic strain and stress{scene.where}")
    told = rows_of(details.YIELDING, details.Yielding(result, body))
    chapter.add("table", chapters.quantities(told))
    chapters.show(chapter, figures.VOLUME, scene.close(), figures.BODY)
    return chapter


def _path(result: ElastoplasticResult) -> Chapter:
    chapter = Chapter("Path of loads")
    chapter.add(
        "text",
        "Every increment starts from what the one before has left. Increments that did not settle "
        "were halved.",
    )
    chapters.show(chapter, figures.VOLUME, figures.VolumeScene(result), figures.PATH)
    head, rows = results.listing(result)
    chapter.add("table", Table(rows, head))
    return chapter


def _certificate(result: ElastoplasticResult) -> Chapter:
    chapter = Chapter("How exactly it is solved")
    chapter.add(
        "text",
        "Residual: the largest change of the plastic strain in the last iteration of an increment "
        "over the largest strain of that increment, or over the yield strain σ_Y/(2μ) if that is "
        "more. Yield excess: the largest von Mises stress over the yield strength at that place, "
        "less one, from stresses that were computed afresh from strain and pressure; it should be "
        "about 0 where something has yielded under load, and negative otherwise.",
    )
    chapter.add(
        "text",
        "Certificate of the contact: ε = ‖p − max(p − g/K₀₀, 0)‖ / ‖p‖, with p the pressure, K₀₀ "
        "the displacement of a pixel under unit pressure of its own, and g the gap, the residual "
        "displacement included, computed afresh from p after the solver had ended.",
    )
    rows = results.rows(result, TRUST)
    chapter.add("table", Table([(row.title, row.text) for row in rows]))
    chapters.show(chapter, figures.VOLUME, figures.VolumeScene(result), figures.ACCURACY)
    return chapter
