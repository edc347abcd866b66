"""Quantities and columns of a load history."""

from __future__ import annotations

from typing import TYPE_CHECKING

from roughcontact._version import __version__
from roughcontact.analyses.history.model import VOLUME_ACCOUNT
from roughcontact.analyses.solve.fields import ceiling_stored, up_to
from roughcontact.analyses.sweep.fields import certificates_of, given_loads_of, share_of
from roughcontact.report import phrases
from roughcontact.report.kind import (
    CAUTIONS,
    Column,
    Columns,
    Quantity,
    Table,
    format_without_rounding,
    stored_columns,
)
from roughcontact.units import format_percent

if TYPE_CHECKING:
    from roughcontact.analyses.history.model import LoadHistory


def passes(history: LoadHistory) -> str:
    """Return the number of passes as text, with the reason if fewer than requested."""
    from roughcontact.analyses.history.model import NEGLIGIBLE_GROWTH

    count, requested = history.passes, history.requested_passes
    if count == requested:
        return f"{count}"
    added = f"adds less than {100 * NEGLIGIBLE_GROWTH:g} % to the indented volume"
    return f"{count} of {requested}: pass {count} {added}, further ones repeat it"


HISTORY_COLUMNS: Columns = (
    Column("number", "step", of=lambda h: range(1, len(h.steps) + 1), stored=False, brief=False),
    Column("load", "load", unit="N"),
    Column("approach", "approach", unit="m"),
    Column("shift_y", unit="m"),
    Column("shift_x", unit="m"),
    Column(
        "contact_area", "contact", unit="m²", shown=share_of("contact_area"), form=format_percent
    ),
    Column(
        "saturated_area", "saturated", "m²", shown=share_of("saturated_area"), form=format_percent
    ),
    Column("max_pressure", "largest pressure", unit="Pa"),
    Column(
        "indentation_volume",
        "newly indented",
        unit="m³",
        shown=format_without_rounding("indentation_volume"),
    ),
    Column(
        "dissipated_energy", "dissipated", "J", shown=format_without_rounding("dissipated_energy")
    ),
    Column("elastic_energy", unit="J"),
    Column("certificate"),
    Column("load_error"),
    Column("convolutions"),
    Column("seconds", unit="s"),
)
"""Columns of the steps of a `LoadHistory`."""


HISTORY: Table = (
    Quantity("source", of=lambda history: history.last.surface.provenance.source),
    Quantity("preparation", of=lambda history: list(history.last.surface.provenance.steps)),
    given_loads_of(),
    Quantity("boundary", of=lambda history: str(history.last.boundary)),
    Quantity("contact_modulus", unit="Pa", of="last.contact_modulus"),
    Quantity(
        "ceiling",
        "pressure ceiling",
        unit="Pa",
        of=lambda h: ceiling_stored(h.last),
        text=lambda h: phrases.ceiling(h.under_largest),
    ),
    Quantity("calibration", of=lambda h: h.calibration and h.calibration.summary()),
    Quantity("tolerance", of="last.tolerance"),
    Quantity("indented_body"),
    Quantity("passes", "passes", text=passes, when=lambda h: h.requested_passes > 1),
    Quantity("requested_passes"),
    Quantity("indentation_volume", "indented volume", unit="m³"),
    Quantity(
        "max_indentation",
        "indentation",
        unit="m",
        of=lambda history: float(history.indentation.max()),
        form=up_to,
    ),
    Quantity("dissipated_energy", "dissipated energy", unit="J"),
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
