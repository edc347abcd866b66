"""Figures in reports on load curves."""

from __future__ import annotations

from roughcontact.analyses.sweep import profile_figures
from roughcontact.analyses.sweep.figures import load_curve
from roughcontact.report.figures import FRONT, Illustration, Illustrations
from roughcontact.report.page import WIDE

CURVE: Illustrations = (
    Illustration(
        "curve",
        load_curve,
        "Contact and saturated area with Persson's theory; approach and mean gap; stiffness of the "
        "next small load; contact spots.",
        FRONT,
        WIDE,
    ),
)
"""Figures of a `LoadCurve`."""


PROFILE_CURVE: Illustrations = (
    Illustration(
        "curve",
        profile_figures.load_curve,
        "Contact and saturated length; approach and mean gap; stiffness; number of segments.",
        FRONT,
        WIDE,
    ),
)
"""Figures of a `LoadCurve` of profiles."""
