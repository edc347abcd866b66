"""Figures in reports on conductance."""

from __future__ import annotations

from roughcontact.analyses.conductance.figures import conductance
from roughcontact.drawing import maps
from roughcontact.report.figures import FRONT, Illustration, Illustrations
from roughcontact.report.page import MIDDLE, WIDE

CONDUCTANCE: Illustrations = (
    Illustration(
        "conductance",
        conductance,
        "Resistance over load, computed and by two estimates: Greenwood's formula for circular "
        "spots and the correlation for large flat joints.",
        FRONT,
        WIDE,
        lambda result: len(result.steps) > 1,
    ),
    Illustration(
        "crossed",
        lambda result: maps.pressure(result.largest),
        "Contact pressure. Heat and current cross the spots in color.",
        FRONT,
        MIDDLE,
        lambda result: len(result.steps) == 1,
    ),
)
"""Figures of a `Conductance`."""
