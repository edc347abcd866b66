"""Figures in reports on stress."""

from __future__ import annotations

from roughcontact.analyses.stress import figures as subsurface_stress
from roughcontact.report.figures import FRONT, RESULTS, Illustration, Illustrations
from roughcontact.report.page import HALF, MIDDLE

STRESS: Illustrations = (
    Illustration(
        "stress-depth",
        subsurface_stress.stress_depth,
        "Largest equivalent stresses at each depth. Look for the depth of the maximum.",
        RESULTS,
        HALF,
    ),
    Illustration(
        "stress-section",
        subsurface_stress.stress_section,
        "Von Mises stress on the plane along x through its maximum (cross), true to scale.",
        FRONT,
        MIDDLE,
    ),
    Illustration(
        "stress-map",
        subsurface_stress.stress_map,
        "Largest von Mises stress over all depths, seen from above. The cross marks the maximum.",
        RESULTS,
        HALF,
    ),
)
"""Figures of a `StressResult`."""
