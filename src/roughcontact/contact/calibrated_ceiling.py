"""The calibrated ceiling for a contact, and how one was found that agrees with itself."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

CALIBRATED = "calibrated"
"""What `roughcontact.solve` is given as its ceiling to find it itself."""

TOLD_CHANGE = 0.02
"""Relative change of areas or gap from which the calibrated ceiling is told beside another."""


@dataclass(frozen=True)
class CalibratedCeiling:
    """The ceiling that gives the contact area of plasticity in the volume."""

    load_ratio: float
    slope: float  # Contact radius over radius of that sphere, a/R
    flow_stress: float  # Yield strength at the strain 0.15 a/R [Pa]
    first_yield: float  # Hertz peak pressure at first yield, of the flow stress [Pa]
    ceiling: float  # The calibrated ceiling [Pa]
    factor: float  # The same over the yield strength before any plastic strain


@dataclass(frozen=True)
class Calibrated:
    """The same contact under the ceiling that gives the contact area."""

    ceiling: float  # The calibrated ceiling [Pa]
    factor: float  # Of the `CalibratedCeiling`
    load_ratio: float  # Of the `CalibratedCeiling`
    load: float  # Load [N] and approach [m]
    approach: float  # Load [N] and approach [m]
    control: str  # Which of them was given
    contact_area: float  # Contact area [m²]
    contact_fraction: float  # Contact area and saturated area over that of the map
    saturated_fraction: float  # Contact area and saturated area over that of the map
    mean_gap: float  # Mean open gap [m]
    change: float  # Largest relative change of contact area, saturated area and mean gap
    certificate: float  # ε of its solution
    convolutions: int  # What it cost

    @property
    def differs(self) -> bool:
        """Whether it differs by so much that it is told."""
        return self.change > TOLD_CHANGE

    def summary(self) -> dict[str, Any]:
        """Return it by name, in SI units, ready for JSON."""
        return asdict(self)


@dataclass(frozen=True)
class CalibrationRecord:
    """How a ceiling was found that agrees with itself, and what came out with the usual one."""

    load: float  # Load at which the spots were judged [N]
    load_ratio: float  # Of the `CalibratedCeiling` that was solved with
    factor: float  # Of the `CalibratedCeiling` that was solved with
    mismatch: float
    solves: int  # How many there were, the first with three yield strengths
    usual_ceiling: float  # Three yield strengths [Pa]
    usual_contact_area: float  # [m²]
    usual_approach: float  # [m²]
    usual_indentation: float  # [m²]

    def summary(self) -> dict[str, float]:
        """Return it by name, in SI units, ready for JSON."""
        return asdict(self)
