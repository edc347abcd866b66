"""What is shown of a load history."""

from __future__ import annotations

from operator import attrgetter
from typing import Any

from roughcontact.plots.load_curve import hysteresis
from roughcontact.report import (
    assumptions,
    chapters,
    contact_fields,
    figures,
    page,
    phrases,
    problem,
)
from roughcontact.report.kind import Kind
from roughcontact.report.page import Block
from roughcontact.studies.load_history import LoadHistory
from roughcontact.units import counted, engineering


def question(history: LoadHistory) -> str:
    """Return the question that a load history answers."""
    name = phrases.source(history.before.surface.provenance)
    load = engineering(history.under_largest.load, "N")
    return f"What does a load history up to {load} leave on {name}?"


def _details(history: LoadHistory, scene: Any, **more: Any) -> list[Block]:
    body = "body" if history.indented_body == "surface" else "counter-body"
    left = figures.MapScene(history.residual, f" of the {body}", "after the path, without load")
    return [
        Block("small", page.sentence(KIND.row(history, "volume_account").text)),
        *chapters.shown((figures.MAP,), left, figures.FILES),
    ]


def _method(history: LoadHistory) -> list[Block]:
    body = "body" if history.indented_body == "surface" else "counter-body"
    return [
        Block(
            "text",
            f"The pressure ceiling acts as perfect plasticity of the surface. The {body} keeps the "
            "indentation; unloading is elastic. Approaches count from first contact before the "
            "path.",
        )
    ]


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
    plots=(hysteresis,), contact=attrgetter("under_largest"), question=question,
    problem=_problem, answer=_answer, remarks=_remarks, details=_details, method=_method,
    case=lambda history: assumptions.of_contact(history.under_largest, history),
)  # fmt: skip
