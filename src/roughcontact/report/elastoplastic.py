"""A report on a contact with plasticity of the volume, in the form of `report.contact`.

Everything in it comes from the result that is handed over; nothing is solved here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from roughcontact.cautions import Caution
from roughcontact.elastoplastic import plausibility
from roughcontact.elastoplastic.result import ElastoplasticResult
from roughcontact.formats import export
from roughcontact.plots import elastoplastic as plots
from roughcontact.references import References
from roughcontact.report import (
    assumptions,
    blocks,
    chapters,
    citations,
    contact_fields,
    figures,
    page,
    phrases,
    problem,
    python_script,
    regimes,
)
from roughcontact.report.blocks import Blocks, Cautions
from roughcontact.report.fields import PROBLEM, TRUST, rows_of, tiny
from roughcontact.report.kind import CellTable, Kind
from roughcontact.report.page import PLAIN, Cells, Chapter, Edition, ExtraChapter, PageTable
from roughcontact.units import counted, engineering, percent


@dataclass(frozen=True)
class Lead:
    """What a report says first that is on more than a state of the volume."""

    title: str  # Of the report
    key_numbers: list[Cells]  # Names, values and remarks
    chapter: Chapter  # The first
    references: References  # The works behind it
    cautions: tuple[Caution, ...]  # What a reader has to know
    checked: tuple[str, ...] = ()  # What was looked at besides the state, in a few words each


def render(
    result: ElastoplasticResult,
    edition: Edition = PLAIN,
    *,
    lead: Lead | None = None,
    additions: Sequence[ExtraChapter] = (),
) -> str:
    """Return a report as the text of an HTML file."""
    contact = result.solution
    spots = contact.spots()
    stated = assumptions.volume_statements(result, spots)
    lead = lead or _lead(result)
    answer = [
        *([lead.chapter] if lead.chapter.title else []),
        *chapters.prepared(contact),
        chapters.problem(contact, KIND.rows(result, PROBLEM), "volume"),
        chapters.assumed(stated, lead.cautions),
        _results(result),
        *(_volume(result, body) for body in range(len(result.bodies))),
    ]
    if result.increments:
        answer.append(_path(result))
    if spots.count:
        answer += [*chapters.smooth_beside_rough(contact), chapters.contact_spots(contact, spots)]
    answer += [chapters.added(addition) for addition in additions]
    lines = python_script.repeating_volume(result)
    answer += [_certificate(result), chapters.repetition(result.version, edition.command, lines)]
    answer.append(citations.chapter(lead.references, additions))
    return page.render(
        answer,
        title=lead.title,
        subtitle=chapters.subtitle(contact),
        edition=edition,
        status=result.status,
        key_numbers=lead.key_numbers,
        regime=result.regime,
        regime_text=regimes.volume_regime(result),
        certificate=_certificate_in_short(result),
        cautions=lead.cautions,
        checked=(*lead.checked, *plausibility.checked(result)),
    )


def _lead(result: ElastoplasticResult) -> Lead:
    """Return what a report on a state alone says first."""
    numbers, works = _key_numbers(result), citations.of(KIND, result)
    return Lead(_title(result), numbers, Chapter(""), works, result.cautions)


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
    return engineering(contact_fields.largest_load(result), "N")


def _key_numbers(result: ElastoplasticResult) -> list[Cells]:
    if result.solution.load:
        return chapters.headlines(KIND, result, contact_fields.VOLUME_HEADLINES)
    gone = ("Largest load", _largest_load(result), "on the way; it is gone")
    return [*chapters.headlines(KIND, result, contact_fields.RELEASED_HEADLINES), gone]


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
    chapter.add("table", chapters.quantities(KIND.rows(result)))
    chapters.show(chapter, figures.VOLUME, figures.VolumeScene(result))
    return chapter


def _volume(result: ElastoplasticResult, body: int) -> Chapter:
    scene = figures.VolumeScene(result, body)
    chapter = Chapter(f"Plastic strain and stress{scene.where}")
    rows = rows_of(chapters.YIELDING, chapters.Yielding(result, body))
    chapter.add("table", chapters.quantities(rows))
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
    head, rows = KIND.listing(result)
    chapter.add("table", PageTable(rows, head))
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
    rows = KIND.rows(result, TRUST)
    chapter.add("table", PageTable([(row.title, row.text) for row in rows]))
    chapters.show(chapter, figures.VOLUME, figures.VolumeScene(result), figures.ACCURACY)
    return chapter


# --- What is said first ---


def _answer(result: ElastoplasticResult) -> str:
    """Return how much touches, and how deep plastic strain reaches."""
    if not result.converged:
        return "No solution: the numbers are those of the last load that was reached."
    depth = f"plastic strain reaches {problem.size(result.plastic_depth, 'm')} deep"
    if not result.plastic_volume:
        depth = "nothing yields"
    if not result.solution.load:
        dent = problem.size(float(result.residual_displacement.max()), "m")
        return f"Unloaded: a dent of {dent} remains; {depth}."
    return f"{problem.share(result.solution.contact_fraction)} of the face is in contact; {depth}."


def _numbers(result: ElastoplasticResult) -> CellTable:
    """Return the numbers that are said first."""
    contact, rows = result.solution, []
    if contact.load:
        area, mean = contact.contact_area, contact.load / contact.contact_area
        whole = problem.size(contact.nominal_area, "m²")
        rows = [
            ("Real contact area", f"{problem.size(area, 'm²')} of {whole}"),
            (
                "Contact pressure",
                f"{problem.size(mean, 'Pa')} mean; {problem.size(contact.max_pressure, 'Pa')} peak",
            ),
            ("Approach", f"{problem.size(contact.approach, 'm')} from first contact"),
        ]
    strain = percent(result.max_plastic_strain)
    volume = KIND.row(result, "plastic_volume").text
    return (), [
        *rows,
        ("Plastic depth", problem.size(result.plastic_depth, "m")),
        ("Plastic strain", f"{strain} at most, in {volume}"),
        ("Residual displacement", KIND.row(result, "max_residual_displacement").text),
    ]


def _remarks(result: ElastoplasticResult) -> tuple[str, ...]:
    """Return the error of the load steps, and how exactly it is solved."""
    status = (
        f"Solved: residual {tiny(result.residual)} (limit {result.tolerance:.0e}), "
        f"{counted(len(result.increments), 'increment')}"
        if result.converged
        else f"Not converged: {result.status}. Do not use these numbers."
    )
    return f"Load steps: {phrases.step_error(result)}", status


def shown(result: ElastoplasticResult) -> Blocks:
    """Return what the console shows: problem, answer and trust, then cautions."""
    problem = blocks.problem(KIND, result, result.solution)
    answer = blocks.cells(KIND.rows(result, brief=True))
    return [*blocks.table(problem, answer, blocks.trust(KIND, result)), Cautions(result.cautions)]


KIND = Kind(
    ElastoplasticResult, contact_fields.VOLUME, contact_fields.INCREMENTS, figures=figures.VOLUME,
    scene=figures.VolumeScene,
    plots=(
        plots.section, plots.profile, plots.layers, plots.path, plots.residual_displacement,
        plots.convergence,
    ),
    works=citations.of_volume, save=export.save_volume, report=render, blocks=shown,
    problem=lambda result: problem.line(result.solution), answer=_answer, numbers=_numbers,
    remarks=_remarks,
)  # fmt: skip
