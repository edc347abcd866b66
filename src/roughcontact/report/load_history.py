"""Reports on many loads: a load curve, a load history. The curve comes first."""

from __future__ import annotations

from operator import attrgetter

from roughcontact.contact import plausibility
from roughcontact.contact.result import ContactResult
from roughcontact.plots.load_curve import hysteresis
from roughcontact.report import (
    assumptions,
    chapters,
    citations,
    contact,
    contact_fields,
    contact_fields as of_profile,
    figures,
    load_curve as curves,
    page,
    problem,
    regimes,
)
from roughcontact.report.fields import PROBLEM, capital, tiny
from roughcontact.report.kind import Kind
from roughcontact.report.page import PLAIN, Cells, Chapter, Edition, PageTable
from roughcontact.studies.load_curve import LoadCurve
from roughcontact.studies.load_history import LoadHistory
from roughcontact.units import counted, engineering

# What a report on a load curve says first: how these go from the first load to the last.
_OF_A_CURVE = ("contact_area", "saturated_area", "max_pressure", "approach", "stiffness")
_OF_A_PROFILE = ("contact_length", "saturated_length", *_OF_A_CURVE[2:])


def render_curve(
    curve: LoadCurve,
    last: ContactResult,
    edition: Edition = PLAIN,
    *,
    elastic: ContactResult | None = None,
) -> str:
    """Return a report on a load curve as the text of an HTML file."""
    spots = last.spots()
    stated = chapters.stated(last, spots)
    under = f"under {engineering(last.load, last.pair.load_unit)}"
    result = [
        curves.chapter(curve),
        *chapters.prepared(last),
        chapters.problem(last, contact.kind_of(last).rows(last, PROBLEM), "ceiling"),
        chapters.assumed(stated, curve.cautions),
        _titled(contact.results_chapter(last, None), f"The contact {under}"),
        *chapters.smooth_beside_rough(last),
        *([] if last.pair.is_profile else [contact.sections(last)]),
        chapters.contact_spots(last, spots),
    ]
    if last.saturated_fraction > 0:
        result.append(contact.comparison(last, elastic))
    exact = contact.exactness(last)
    result += [
        _titled(exact, f"{exact.title} {under}"),
        chapters.repetition(last.version, edition.command, ""),
        citations.chapter(citations.of(contact.KIND, last) + citations.of(curves.KIND, curve)),
    ]
    return page.render(
        result,
        title=_title_of_curve(curve),
        subtitle=chapters.subtitle(last),
        edition=edition,
        status=last.status,
        key_numbers=_from_first_to_last(curve),
        regime=last.regime,
        regime_text=f"{capital(under)}: {regimes.regime(last)}",
        certificate=_worst(curve, last.tolerance),
        cautions=curve.cautions,
        checked=plausibility.checked(last),
    )


def render_history(
    history: LoadHistory,
    edition: Edition = PLAIN,
) -> str:
    """Return a report on a load history as the text of an HTML file."""
    largest = history.under_largest
    stated = assumptions.statements(largest, largest.spots(), history)
    under = f"under the largest load, {engineering(largest.load, 'N')}"
    exact = contact.exactness(history.largest)
    result = [
        _path(history),
        *([_under(largest), *chapters.smooth_beside_rough(largest)] if largest.load else []),
        _left(history),
        *chapters.prepared(largest),
        chapters.problem(largest, contact.kind_of(largest).rows(largest, PROBLEM), "ceiling"),
        chapters.assumed(stated, history.cautions),
        _titled(exact, f"{exact.title} {under}"),
        chapters.repetition(largest.version, edition.command, ""),
        citations.chapter(citations.of(KIND, history)),
    ]
    return page.render(
        result,
        title=_title_of_history(history),
        subtitle=chapters.subtitle(largest),
        edition=edition,
        status=history.last.status,
        key_numbers=[
            ("Largest load", engineering(largest.load, "N"), "of the path"),
            *chapters.headlines(KIND, history, contact_fields.HISTORY_HEADLINES),
        ],
        regime=largest.regime,
        regime_text=f"{capital(under)}: {regimes.regime(largest)}",
        certificate=_worst(history, largest.tolerance),
        cautions=history.cautions,
        checked=plausibility.checked(largest),
    )


def _title_of_curve(curve: LoadCurve) -> str:
    name = curve.source or "an unnamed surface"
    unit = "m"
    if curve.control == "load":
        unit = of_profile.LOAD if curve.is_profile else "N"
    first, last = (engineering(getattr(curve.steps[n], curve.control), unit) for n in (0, -1))
    return f"Load curve of {name} from {first} to {last}"


def _title_of_history(history: LoadHistory) -> str:
    name = history.before.surface.provenance.source or "an unnamed surface"
    return f"Load history of {name} in {counted(len(history.steps), 'step')}"


def _from_first_to_last(curve: LoadCurve) -> list[Cells]:
    kind = curves.PROFILE_KIND if curve.is_profile else curves.KIND
    head, rows = kind.listing(curve)
    names = [column.key for column in kind.columns if column.name]
    result: list[Cells] = []
    for key in _OF_A_PROFILE if curve.is_profile else _OF_A_CURVE:
        if key.startswith("saturated") and curve.ceiling is None:
            continue
        index = names.index(key)
        ends = rows[0][index], rows[-1][index]
        same = ends[0] == ends[1]
        said = "first and last load" if same else "first to last load"
        result.append((capital(head[index]), ends[0] if same else " to ".join(ends), said))
    return result


def _worst(result: LoadCurve | LoadHistory, tolerance: float) -> str:
    worst = max(step.certificate for step in result.steps)
    return (
        f"Certificate of {counted(len(result.steps), 'step')}, the worst: {tiny(worst)}, asked for "
        f"{tolerance:.0e}: pressure and gap fulfil the conditions of contact to within this part "
        f"of the pressure. It says how exactly the problem as stated is solved. "
        f"{chapters.RIGHT_PROBLEM}"
    )


def _path(history: LoadHistory) -> Chapter:
    chapter = Chapter("Load history")
    body = "body" if history.indented_body == "surface" else "counter-body"
    chapter.add(
        "text",
        f"The pressure ceiling acts as perfect plasticity of the surface. The {body} keeps the "
        "indentation; unloading is elastic. Approaches count from the first touch of the bodies "
        "before the path.",
    )
    chapters.show(chapter, figures.HISTORY, history)
    head, rows = KIND.listing(history)
    chapter.add("table", PageTable(rows, head))
    return chapter


def _under(largest: ContactResult) -> Chapter:
    chapter = Chapter(f"The contact under the largest load, {engineering(largest.load, 'N')}")
    chapters.show(chapter, figures.PRESSED, figures.ContactScene(largest))
    return chapter


def _left(history: LoadHistory) -> Chapter:
    chapter = Chapter("What the path left behind")
    chapter.add("table", PageTable(chapters.facts(KIND, history)))
    chapter.add("text", page.sentence(KIND.row(history, "volume_account").text))
    body = "body" if history.indented_body == "surface" else "counter-body"
    scene = figures.MapScene(history.residual, f" of the {body}", "after the path, without load")
    chapters.show(chapter, figures.MAP, scene, figures.PREPARATION)
    return chapter


def _titled(chapter: Chapter, title: str) -> Chapter:
    chapter.title = title
    return chapter


# --- What is said first ---


def _problem(history: LoadHistory) -> str:
    largest = history.under_largest
    path = f"{counted(len(history.steps), 'step')}, largest load {problem.load(largest)}"
    return f"{problem.bodies(largest)}, {path}{problem.boundary(largest)}"


def _answer(history: LoadHistory) -> str:
    """Return what the path leaves behind, and whether more of it would change it."""
    body = "body" if history.indented_body == "surface" else "counter-body"
    depth = float(history.indentation.max())
    if not depth:
        return f"The {body} keeps no indentation: no point reaches the pressure ceiling."
    settled = "; loading again adds none" if history.is_elastic_now else ""
    return f"The {body} keeps an indentation of {problem.size(depth, 'm')} at most{settled}."


def _remarks(history: LoadHistory) -> tuple[str, ...]:
    """Return the energy that is lost, and how exactly the steps are solved."""
    row = KIND.row(history, "dissipated_energy")
    most = max(step.certificate for step in history.steps)
    return (
        f"Dissipated energy: {row.text}",
        problem.worst(most, history.last.tolerance, len(history.steps)),
    )


KIND = Kind(
    LoadHistory, contact_fields.HISTORY, contact_fields.HISTORY_COLUMNS, figures=figures.HISTORY,
    plots=(hysteresis,), contact=attrgetter("under_largest"), report=render_history,
    problem=_problem, answer=_answer, remarks=_remarks,
)  # fmt: skip
