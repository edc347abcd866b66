"""Fretting of a contact in partial slip: stress, surface tension, damage parameters."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from roughcontact._tools.arrays import Array
from roughcontact.analyses.stress.model import StressResult, subsurface_stress, surface_loads
from roughcontact.contact.result import ContactResult
from roughcontact.halfspace.stress import slices
from roughcontact.halfspace.stress_summary import larger_principal
from roughcontact.halfspace.tensors import XX, XY, YY


@dataclass(frozen=True, eq=False, repr=False)
class Fretting:
    """Stress and fretting parameters of the rough body under the last force.

    δ is the slip amplitude in a cycle between that force and its opposite: half of the slip of the
    last step at the end of a cycle, else the total slip. Ruiz, Boddington and Chen 1984,
    Exp. Mech. 24, 208.
    """

    stress: StressResult  # Stress below the contact, with the largest tension at the surface
    tension: Array  # Larger principal stress in the surface at the pixel centers [Pa], (ny, nx)
    work: Array  # Traction times slip τδ [J/m²], (ny, nx); a cycle dissipates four times as much
    ruiz: Array  # σ_t τδ [Pa²·m], (ny, nx), σ_t the stress along the traction; 0 under compression
    # Tangential force of first yield [N]: 0 if the body yields under the load alone, infinite if
    # the contact slides before; None if the load changes, or without a yield strength.
    yield_force: float | None = None

    def __post_init__(self) -> None:
        """Make the maps read-only."""
        for array in (self.tension, self.work, self.ruiz):
            array.flags.writeable = False

    @property
    def max_work(self) -> float:
        """Largest τδ [J/m²]."""
        return float(self.work.max())

    @property
    def max_ruiz(self) -> float:
        """Largest σ_t τδ [Pa²·m]."""
        return float(self.ruiz.max())

    @property
    def max_ruiz_at(self) -> tuple[float, float]:
        """Position of the largest σ_t τδ: y and x [m] from the corner of the map."""
        row, column = np.unravel_index(self.ruiz.argmax(), self.work.shape)
        return self.stress.center((int(row), int(column)))


def fretting(contact: ContactResult, traction: Array, slip: Array) -> Fretting:
    """Return the fretting result of traction [Pa] and slip [m], components (y, x)."""
    below = subsurface_stress(contact, traction=traction)
    surface = next(
        slices(
            contact.pressure,
            contact.pair.pixel,
            [0.0],
            contact.material.poisson,
            traction=traction,
            **surface_loads(contact.pair, "body", 0.0, 0.0),
        )
    ).stress
    in_plane = surface[[XX, YY, XY]].astype(np.float64)
    size = np.hypot(*traction)
    y, x = np.divide(traction, size, out=np.zeros_like(traction), where=size > 0)
    along = x * x * in_plane[0] + y * y * in_plane[1] + 2 * x * y * in_plane[2]
    work = size * np.hypot(*slip)
    return Fretting(below, larger_principal(in_plane), work, np.maximum(along, 0) * work)
