"""Display of a surface."""

from __future__ import annotations

import os

from roughcontact.drawing import maps, profiles, sections
from roughcontact.formats import export
from roughcontact.report.inputs import SURFACE, TRACE
from roughcontact.report.kind import Quantity
from roughcontact.report.presentation import Presentation
from roughcontact.surface.surface import Surface


class SurfacePresentation(Presentation):
    """Presentation of a map or a profile."""

    result: Surface
    table = (*SURFACE, Quantity("Sq", "Sq [m]"), Quantity("Sdq", "Sdq"))
    plots = (maps.surface, sections.bearing_curve)
    profile_table = TRACE
    profile_plots = (profiles.heights,)

    @property
    def is_profile(self) -> bool:
        """Whether the surface is a profile."""
        return self.result.is_profile

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the heights; the suffix selects the format."""
        export.save_surface(self.result, path)
