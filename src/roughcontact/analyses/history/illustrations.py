"""Figure in reports on load histories."""

from __future__ import annotations

from roughcontact.analyses.history.figures import hysteresis
from roughcontact.report.figures import FRONT, Illustration, Illustrations
from roughcontact.report.page import HALF

HISTORY: Illustrations = (
    Illustration(
        "history",
        hysteresis,
        "Top: load over approach; dots are computed, the area between the lines is no measure of "
        "the energy. Bottom: energy dissipated by each step and volume indented so far.",
        FRONT,
        HALF,
    ),
)
"""Figures of a `LoadHistory`."""
