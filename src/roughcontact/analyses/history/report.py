"""Report of a load history."""

from __future__ import annotations

from operator import attrgetter
from typing import Any

from roughcontact.analyses.history import (
    fields as history_fields,
    illustrations as history_illustrations,
)
from roughcontact.analyses.history.figures import hysteresis
from roughcontact.analyses.history.model import LoadHistory
from roughcontact.report import assumptions, chapters, figures, page, phrases
from roughcontact.report.kind import Presentation
from roughcontact.report.page import Block
from roughcontact.units import count_noun, format_engineering


def history_question(history: LoadHistory) -> str:
    """Return the question that a load history answers."""
    name = phrases.source(history.before.surface.provenance)
    load = format_engineering(history.under_largest.load, "N")
    return f"Which indentation does a load history up to {load} leave on {name}?"


def _details(history: LoadHistory, scene: Any, **more: Any) -> list[Block]:
    body = "body" if history.indented_body == "surface" else "counter-body"
    left = figures.MapScene(history.residual, f" of the {body}", "after the path, without load")
    return [
        Block("small", page.as_sentence(KIND.row(history, "volume_account").text)),
        *chapters.figure_blocks((figures.MAP,), left, figures.FILES),
    ]


def _history_method(history: LoadHistory) -> list[Block]:
    body = "body" if history.indented_body == "surface" else "counter-body"
    return [
        Block(
            "text",
            f"The pressure ceiling acts as perfect plasticity of the surface. The {body} keeps the "
            "indentation; unloading is elastic. Approaches count from first contact before the "
            "path.",
        )
    ]


def _history_problem(history: LoadHistory) -> str:
    largest = history.under_largest
    path = f"{count_noun(len(history.steps), 'step')}, largest load {phrases.load(largest)}"
    return f"{phrases.bodies(largest)}, {path}{phrases.boundary(largest)}"


def _history_answer(history: LoadHistory) -> str:
    """Return the residual state after the path, and whether further passes would change it."""
    body = "body" if history.indented_body == "surface" else "counter-body"
    depth = float(history.indentation.max())
    if not depth:
        return f"The {body} keeps no indentation: no point reaches the pressure ceiling."
    settled = "; loading again adds none" if history.is_elastic_now else ""
    return (
        f"The {body} keeps an indentation of {phrases.format_short(depth, 'm')} at most{settled}."
    )


def _history_remarks(history: LoadHistory) -> tuple[str, ...]:
    """Return the dissipated energy, and the accuracy of the steps."""
    row = KIND.row(history, "dissipated_energy")
    most = max(step.certificate for step in history.steps)
    return (
        f"Dissipated energy: {row.text}",
        phrases.worst(most, history.last.tolerance, len(history.steps)),
    )


KIND = Presentation(
    LoadHistory,
    history_fields.HISTORY,
    history_fields.HISTORY_COLUMNS,
    figures=history_illustrations.HISTORY,
    plots=(hysteresis,),
    contact=attrgetter("under_largest"),
    question=history_question,
    problem=_history_problem,
    answer=_history_answer,
    remarks=_history_remarks,
    details=_details,
    method=_history_method,
    case=lambda history: assumptions.contact_case(history.under_largest, history),
)
