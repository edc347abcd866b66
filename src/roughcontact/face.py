"""Methods of results and maps that need higher layers; see `roughcontact.result`."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from roughcontact.result import set_presentation

if TYPE_CHECKING:
    import pandas
    import xarray

    from roughcontact.analyses.estimate.model import Estimate
    from roughcontact.cautions import Caution
    from roughcontact.contact.result import ContactResult
    from roughcontact.elastoplastic.plastic_body import DepthProfile, DepthSection, LayerProfile
    from roughcontact.elastoplastic.volume_result import ElastoplasticResult
    from roughcontact.material.material import Material
    from roughcontact.references import References
    from roughcontact.uncertainty.intervals import Uncertainty

Path = str | os.PathLike[str]


def text(shown: object) -> str:
    """Return the main quantities as text, one line each."""
    from roughcontact.report import kinds

    return kinds.headline_text(shown)


def html(shown: object) -> str:
    """Return the main quantities as HTML."""
    from roughcontact.report import kinds

    return kinds.headline_html(shown)


def plots(shown: object) -> Any:
    """Return the figures as methods."""
    from roughcontact.report import kinds

    return kinds.Plots(shown, kinds.presentation_of(shown).plots)


def explore(shown: Any) -> Any:
    """Open the page in the browser."""
    from roughcontact.desk import explore

    return explore.explore(shown)


def save(shown: Any, path: Path) -> None:
    """Write a file in the format that its suffix names."""
    from roughcontact.report import kinds

    kinds.save(shown, path)


def presentations() -> Mapping[str, tuple[str, ...]]:
    """Return the locations of the presentations, by class of results."""
    from roughcontact.analyses.tasks import PRESENTATIONS

    return PRESENTATIONS


def to_pandas(shown: object) -> pandas.DataFrame:
    """Return the table of steps."""
    from roughcontact.report import kinds

    return kinds.presentation_of(shown).to_pandas(shown)


def to_xarray(shown: object) -> xarray.Dataset:
    """Return the content of a NetCDF file."""
    from roughcontact.report import kinds

    return kinds.presentation_of(shown).to_xarray(shown)


def summary(shown: object) -> dict[str, Any]:
    """Return the quantities by name."""
    from roughcontact.report import kinds

    return kinds.summary(shown)


def references(shown: object) -> References:
    """Return the references."""
    from roughcontact.report import kinds

    return kinds.references(shown)


def report(shown: Any, path: Path, command: str, **more: Any) -> None:
    """Write a report."""
    from roughcontact.report import kinds
    from roughcontact.report.page import Edition

    kinds.report(shown, path, Edition(command), **more)


def contact_cautions(shown: ContactResult) -> tuple[Caution, ...]:
    """Return the cautions on a contact."""
    from roughcontact.contact.plausibility import cautions

    return cautions(shown)


def volume_cautions(shown: ElastoplasticResult) -> tuple[Caution, ...]:
    """Return the cautions on an elastoplastic contact."""
    from roughcontact.elastoplastic import plausibility as judgment

    return judgment.cautions(shown)


def elastic(shown: ContactResult) -> ContactResult:
    """Return the contact solved without a ceiling."""
    from roughcontact.contact import solve

    return solve.solve_without_ceiling(shown)


def stiffness(shown: ContactResult) -> float:
    """Return the contact stiffness."""
    from roughcontact.contact import stiffness

    return stiffness.stiffness(shown)


def uncertainty(shown: ContactResult, *how: Any) -> Uncertainty:
    """Return the uncertainty intervals of a contact of a measured map."""
    from roughcontact.uncertainty import measurement

    return measurement.uncertainty(shown, *how)


def stored_uncertainty(record: Mapping[str, Any]) -> Uncertainty:
    """Return the uncertainty intervals stored in a summary."""
    from roughcontact.uncertainty import intervals as uncertainty

    return uncertainty.from_summary(record)


def estimate(shown: ContactResult) -> Estimate | None:
    """Return the analytical estimate of a contact, if there is one."""
    from roughcontact.analyses.estimate import model as estimate

    return estimate.estimate_result(shown)


def profile(shown: ElastoplasticResult, point: tuple[int, int] | None, body: int) -> DepthProfile:
    """Return plastic strain and stress over the depth."""
    from roughcontact.elastoplastic import volume_result as result

    return result.profile(shown, point, body)


def section(shown: ElastoplasticResult, along: str, index: int | None, body: int) -> DepthSection:
    """Return plastic strain and stress on a vertical plane."""
    from roughcontact.elastoplastic import volume_result as result

    return result.section_of(shown, along, index, body)


def layers(shown: ElastoplasticResult, body: int) -> LayerProfile:
    """Return the largest plastic strain and stress of each layer."""
    from roughcontact.elastoplastic import volume_result as result

    return result.layers(shown, body)


def material(name: str) -> Material:
    """Return a material of the catalog."""
    from roughcontact.material import catalog

    return catalog.material(name)


set_presentation(sys.modules[__name__])
