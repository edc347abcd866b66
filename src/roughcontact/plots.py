"""Figures of surfaces and results."""

# Imported first: a later import of the module would hide the function of the same name.
import roughcontact.analyses.compare.figures  # noqa: F401
from roughcontact.analyses.conductance.figures import conductance as conductance
from roughcontact.analyses.history.figures import hysteresis as hysteresis
from roughcontact.analyses.law.figures import interface_law as interface_law
from roughcontact.analyses.leak.figures import flow_factors as flow_factors, leak as leak
from roughcontact.analyses.stress.figures import (
    stress_depth as stress_depth,
    stress_map as stress_map,
    stress_section as stress_section,
)
from roughcontact.analyses.sweep.figures import load_curve as load_curve
from roughcontact.analyses.tangential.figures import fretting as fretting, tangential as tangential
from roughcontact.analyses.wear.figures import running_in as running_in
from roughcontact.drawing.export import save as save
from roughcontact.drawing.maps import (
    close_up as close_up,
    comparison as comparison,
    contact as contact,
    gap as gap,
    overview as overview,
    pressure as pressure,
    spots as spots,
    surface as surface,
)
from roughcontact.drawing.sections import (
    bearing_curve as bearing_curve,
    pressure_histogram as pressure_histogram,
    section as section,
)
