"""Figures of surfaces and results."""

# Imported first: a later import of the module would hide the function of the same name.
import roughcontact.analyses.compare.figures  # noqa: F401
from roughcontact.analyses.conductance.figures import conductance
from roughcontact.analyses.history.figures import hysteresis
from roughcontact.analyses.law.figures import interface_law
from roughcontact.analyses.leak.figures import flow_factors, leak
from roughcontact.analyses.stress.figures import stress_depth, stress_map, stress_section
from roughcontact.analyses.sweep.figures import load_curve
from roughcontact.analyses.tangential.figures import fretting, tangential
from roughcontact.analyses.wear.figures import running_in
from roughcontact.drawing.export import save
from roughcontact.drawing.maps import (
    close_up,
    comparison,
    contact,
    gap,
    overview,
    pressure,
    spots,
    surface,
)
from roughcontact.drawing.sections import bearing_curve, pressure_histogram, section

__all__ = [
    "bearing_curve",
    "close_up",
    "comparison",
    "conductance",
    "contact",
    "flow_factors",
    "fretting",
    "gap",
    "hysteresis",
    "interface_law",
    "leak",
    "load_curve",
    "overview",
    "pressure",
    "pressure_histogram",
    "running_in",
    "save",
    "section",
    "spots",
    "stress_depth",
    "stress_map",
    "stress_section",
    "surface",
    "tangential",
]
