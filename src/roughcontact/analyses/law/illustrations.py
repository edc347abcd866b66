"""Figure in reports on interface laws."""

from __future__ import annotations

from roughcontact.analyses.law.figures import interface_law
from roughcontact.report.figures import FRONT, Illustration, Illustrations
from roughcontact.report.page import WIDE

LAW: Illustrations = (
    Illustration(
        "law",
        interface_law,
        "Pressure over separation, areas, stiffness, and gap. Thick: mean of the maps. Thin: each "
        "map. Dashed: Persson's elastic theory. Gray: not resolved by the maps.",
        FRONT,
        WIDE,
    ),
)
"""Figures of an `InterfaceLaw`."""
