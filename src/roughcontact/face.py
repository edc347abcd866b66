"""Functions of higher layers that results and maps call; see `roughcontact.result`."""

from __future__ import annotations

import os
import pkgutil
import sys
from typing import Any

from roughcontact.result import set_presentation

# Modules are imported on the first call.
_PLACES = {
    "contact_cautions": "contact.plausibility:cautions",
    "elastic": "contact.solve:solve_without_ceiling",
    "estimate": "analyses.estimate.model:estimate_result",
    "explore": "desk.explore:explore",
    "html": "report.presentation:headline_html",
    "material": "material.catalog:material",
    "plots": "report.presentation:Plots",
    "presentation_of": "report.presentation:presentation_of",
    "presentations": "analyses.tasks:PRESENTATIONS",
    "stiffness": "contact.stiffness:stiffness",
    "stored_uncertainty": "uncertainty.intervals:from_summary",
    "text": "report.presentation:headline_text",
    "uncertainty": "uncertainty.measurement:uncertainty",
    "volume_cautions": "elastoplastic.plausibility:cautions",
}


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return pkgutil.resolve_name(f"roughcontact.{_PLACES[name]}")


def report(shown: Any, path: str | os.PathLike[str], command: str, **more: Any) -> None:
    """Write a report."""
    from roughcontact.report.page import Edition
    from roughcontact.report.presentation import presentation_of

    presentation_of(shown, **more).report(path, Edition(command))


set_presentation(sys.modules[__name__])
