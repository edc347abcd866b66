"""Chapters of a report that its result does not hold by itself."""

from __future__ import annotations

from roughcontact.contact.history import LoadHistory
from roughcontact.contact.stress import StressResult
from roughcontact.report import chapters, figures, results, tables
from roughcontact.report.page import Addition, sentence
from roughcontact.report.quantities import rows_of


def of_stress(stress: StressResult, onset: StressResult | None = None) -> Addition:
    """Return the chapter on the stress below the surface, and on the load of first yield."""
    told = results.rows(stress)
    if onset is not None:
        told += rows_of(tables.FIRST_YIELD, onset)
    rows = (("quantity", "value"), *((row.title, row.text) for row in told))
    text = (
        "Elastic stress under the pressure found. Tension is positive.",
        *(sentence(c.text) for c in stress.cautions if c not in stress.solution.cautions),
    )
    return Addition("Stress below the surface", text, rows, figures.drawn(figures.STRESS, stress))


def of_history(history: LoadHistory) -> Addition:
    """Return the chapter on a load history."""
    head, rows = results.listing(history)
    body = "body" if history.indented_body == "surface" else "counter-body"
    text = (
        f"The pressure ceiling acts as perfect plasticity of the surface. The {body} keeps the "
        "indentation; unloading is elastic. The rest of this report is on the last step.",
        sentence(results.row(history, "volume_account").text),
    )
    facts = chapters.facts(history)
    return Addition(
        "Load history", text, (head, *rows), figures.drawn(figures.HISTORY, history), facts
    )
