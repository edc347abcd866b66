"""Figures of surfaces and results."""

# First, or the module would hide the function of its name once it is loaded.
import roughcontact.plots.comparison  # noqa: F401
from roughcontact.plots.export import save
from roughcontact.plots.joint import (
    conductance,
    flow_factors,
    fretting,
    interface_law,
    leak,
    tangential,
)
from roughcontact.plots.load_curve import hysteresis, load_curve
from roughcontact.plots.maps import (
    close_up,
    comparison,
    contact,
    gap,
    overview,
    pressure,
    spots,
    surface,
)
from roughcontact.plots.sections import bearing_curve, pressure_histogram, section
from roughcontact.plots.subsurface_stress import stress_depth, stress_map, stress_section

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
    "save",
    "section",
    "spots",
    "stress_depth",
    "stress_map",
    "stress_section",
    "surface",
    "tangential",
]
