"""Report of a surface."""

from __future__ import annotations

from dataclasses import replace

from roughcontact.drawing import maps, profiles, sections
from roughcontact.formats import export
from roughcontact.report.inputs import SURFACE, TRACE
from roughcontact.report.kind import Presentation, Quantity
from roughcontact.surface.surface import Surface

KIND = Presentation(
    Surface,
    (*SURFACE, Quantity("Sq", "Sq", unit="m"), Quantity("Sdq", "Sdq")),
    brief=False,
    plots=(maps.surface, sections.bearing_curve),
    save=export.save_surface,
)
PROFILE_KIND = replace(
    KIND, table=TRACE, when=lambda surface: surface.is_profile, plots=(profiles.heights,)
)
