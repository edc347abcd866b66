"""Report of a load history."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from roughcontact._version import __version__
from roughcontact.analyses.history.figures import hysteresis
from roughcontact.analyses.history.model import NEGLIGIBLE_GROWTH, VOLUME_ACCOUNT, LoadHistory
from roughcontact.analyses.solve.fields import ceiling_stored, up_to
from roughcontact.analyses.sweep.report import certificates_of, given_loads_of, share_of
from roughcontact.report import assumptions, chapters, figures, page, phrases
from roughcontact.report.figures import FRONT, Illustration
from roughcontact.report.kind import (
    CAUTIONS,
    Column,
    Quantity,
    always,
    format_without_rounding,
    stored_columns,
)
from roughcontact.report.page import HALF, Block
from roughcontact.report.presentation import Presentation
from roughcontact.units import count_noun, format_engineering, format_percent


def passes(history: LoadHistory) -> str:
    """Return the number of passes as text, with the reason if fewer than requested."""
    count, requested = history.passes, history.requested_passes
    if count == requested:
        return f"{count}"
    added = f"adds less than {100 * NEGLIGIBLE_GROWTH:g} % to the indented volume"
    return f"{count} of {requested}: pass {count} {added}, further ones repeat it"


HISTORY_COLUMNS = (
    Column("number", "step", of=lambda h: range(1, len(h.steps) + 1), stored=False, brief=False),
    Column("load", "load [N]"),
    Column("approach", "approach [m]"),
    Column("shift_y", "[m]"),
    Column("shift_x", "[m]"),
    Column("contact_area", "contact [m²]", shown=share_of("contact_area"), form=format_percent),
    Column(
        "saturated_area", "saturated [m²]", shown=share_of("saturated_area"), form=format_percent
    ),
    Column("max_pressure", "largest pressure [Pa]"),
    Column(
        "indentation_volume",
        "newly indented [m³]",
        shown=format_without_rounding("indentation_volume"),
    ),
    Column(
        "dissipated_energy", "dissipated [J]", shown=format_without_rounding("dissipated_energy")
    ),
    Column("elastic_energy", "[J]"),
    Column("certificate"),
    Column("load_error"),
    Column("convolutions"),
    Column("seconds", "[s]"),
)
"""Columns of the steps of a `LoadHistory`."""


HISTORY = (
    Quantity("source", of="last.surface.provenance.source"),
    Quantity("preparation", of="last.surface.provenance.steps"),
    given_loads_of(),
    Quantity("boundary", of="last.boundary"),
    Quantity("contact_modulus", "[Pa]", of="last.contact_modulus"),
    Quantity(
        "ceiling",
        "pressure ceiling [Pa]",
        of=lambda h: ceiling_stored(h.last),
        text=lambda h: phrases.ceiling(h.under_largest),
        when=always,
    ),
    Quantity("calibration"),
    Quantity("calibrated", of="largest.calibrated"),
    Quantity("tolerance", of="last.tolerance"),
    Quantity("indented_body"),
    Quantity("passes", "passes", text=passes, when=lambda h: h.requested_passes > 1),
    Quantity("requested_passes"),
    Quantity("indentation_volume", "indented volume [m³]"),
    Quantity(
        "max_indentation",
        "indentation [m]",
        of=lambda history: float(history.indentation.max()),
        form=up_to,
    ),
    Quantity("dissipated_energy", "dissipated energy [J]"),
    Quantity(
        "is_elastic_now",
        "shaken down",
        form=lambda v: (
            f"{'yes: more cycles are elastic' if v else 'no: more cycles may indent further'}"
        ),
    ),
    Quantity("volume_account", of=lambda _: VOLUME_ACCOUNT),
    *CAUTIONS,
    Quantity("control", of=lambda h: ["approach" if s.load is None else "load" for s in h.path]),
    Quantity("steps", of=lambda history: stored_columns(HISTORY_COLUMNS, history)),
    Quantity("version", of=lambda _: __version__),
    certificates_of(),
)
"""Quantities of a `LoadHistory`."""


_FIGURES = (
    Illustration(
        "history",
        hysteresis,
        "Top: load over approach; dots are computed, the area between the lines is no measure of "
        "the energy. Bottom: energy dissipated by each step and volume indented so far.",
        FRONT,
        HALF,
    ),
)


class HistoryPresentation(Presentation):
    """Presentation of a load history."""

    result: LoadHistory
    table = HISTORY
    columns = HISTORY_COLUMNS
    figures = _FIGURES
    plots = (hysteresis,)
    contact_name = "under_largest"

    def question(self) -> str:
        """Return the question that a load history answers."""
        name = phrases.source(self.result.before.surface.provenance)
        load = format_engineering(self.result.under_largest.load, "N")
        return f"Which indentation does a load history up to {load} leave on {name}?"

    def problem(self) -> str:
        """Return bodies and load in one line."""
        largest = self.result.under_largest
        path = f"{count_noun(len(self.result.steps), 'step')}, largest load {phrases.load(largest)}"
        return f"{phrases.bodies(largest)}, {path}{phrases.boundary(largest)}"

    def answer(self) -> str:
        """Return the residual state after the path, and whether further passes would change it."""
        history = self.result
        body = "body" if history.indented_body == "surface" else "counter-body"
        depth = float(history.indentation.max())
        if not depth:
            return f"The {body} keeps no indentation: no point reaches the pressure ceiling."
        settled = "; loading again adds none" if history.is_elastic_now else ""
        calibrated = history.under_largest.calibrated
        other = None if calibrated is None else calibrated.max_indentation
        deepest = phrases.with_range(depth, other, partial(phrases.format_short, unit="m"))
        return f"The {body} keeps an indentation of {deepest} at most{settled}."

    def remarks(self) -> tuple[str, ...]:
        """Return the dissipated energy, and the accuracy of the steps."""
        history = self.result
        row = self.row("dissipated_energy")
        most = max(step.certificate for step in history.steps)
        return (
            f"Dissipated energy: {row.text}",
            phrases.worst(most, history.last.tolerance, len(history.steps)),
        )

    def details(self) -> list[Block]:
        """Return further blocks of results."""
        history = self.result
        body = "body" if history.indented_body == "surface" else "counter-body"
        left = figures.MapScene(history.residual, f" of the {body}", "after the path, without load")
        return [
            Block("small", page.as_sentence(self.row("volume_account").text)),
            *chapters.figure_blocks((figures.MAP,), left, figures.FILES),
        ]

    def method(self) -> Iterator[str]:
        """Yield the paragraphs on the method."""
        body = "body" if self.result.indented_body == "surface" else "counter-body"
        yield (
            f"The pressure ceiling acts as perfect plasticity of the surface. The {body} keeps the "
            "indentation; unloading is elastic. Approaches count from first contact before the "
            "path."
        )

    def case(self) -> assumptions.Case:
        """Return the case of the largest load of the history."""
        return assumptions.contact_case(self.result.under_largest, self.result)
