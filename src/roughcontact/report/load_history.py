"""What is shown of a load history."""

from __future__ import annotations

from operator import attrgetter
from typing import Any

from roughcontact.plots.load_curve import hysteresis
from roughcontact.report import assumptions, chapters, contact_fields, figures, page, phrases
from roughcontact.report.kind import Kind
from roughcontact.report.page import Block
from roughcontact.studies.load_history import LoadHistory
from roughcontact.units import engineering


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


KIND = Kind(
    LoadHistory, contact_fields.HISTORY, contact_fields.HISTORY_COLUMNS, figures=figures.HISTORY,
    plots=(hysteresis,), contact=attrgetter("under_largest"), question=question,
    headlines=lambda _: contact_fields.HISTORY_HEADLINES, details=_details, method=_method,
    case=lambda history: assumptions.of_contact(history.under_largest, history),
)  # fmt: skip
