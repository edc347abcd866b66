"""The ceiling that is recommended for a contact, and how one was found that agrees with itself."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

RECOMMENDED = "recommended"
"""What `roughcontact.solve` is given as its ceiling to find it itself."""

TOLD_CHANGE = 0.02
"""Relative change of areas or gap from which the calibrated ceiling is told beside another."""


@dataclass(frozen=True)
class RecommendedCeiling:
    """The ceiling that gives the contact area of plasticity in the volume.

    Parameters
    ----------
    load_ratio : float
        How far beyond first yield the contact spots are: load over the load of first yield of
        the sphere with the same slope and mean pressure in contact, its yield strength the flow
        stress.
    slope : float
        Contact radius over radius of that sphere, a/R.
    flow_stress : float
        Yield strength at the strain 0.15 a/R [Pa]; σ_Y if the material does not harden.
    first_yield : float
        Hertz peak pressure at first yield, of the flow stress [Pa].
    ceiling : float
        The recommended ceiling [Pa].
    factor : float
        The same over the yield strength before any plastic strain.
    """

    load_ratio: float
    slope: float
    flow_stress: float
    first_yield: float
    ceiling: float
    factor: float


@dataclass(frozen=True)
class Calibrated:
    """The same contact under the ceiling that gives the contact area of plasticity in the volume.

    Parameters
    ----------
    ceiling : float
        The calibrated ceiling [Pa].
    factor, load_ratio : float
        Of the `RecommendedCeiling`.
    load, approach : float
        Load [N] and approach [m].
    control : {"load", "approach"}
        Which of them was given.
    contact_area : float
        Contact area [m²].
    contact_fraction, saturated_fraction : float
        Contact area and saturated area over that of the map.
    mean_gap : float
        Mean open gap [m].
    change : float
        Largest relative change of contact area, saturated area and mean gap.
    certificate : float
        ε of its solution.
    convolutions : int
        What it cost.
    """

    ceiling: float
    factor: float
    load_ratio: float
    load: float
    approach: float
    control: str
    contact_area: float
    contact_fraction: float
    saturated_fraction: float
    mean_gap: float
    change: float
    certificate: float
    convolutions: int

    @property
    def differs(self) -> bool:
        """Whether it differs by so much that it is told."""
        return self.change > TOLD_CHANGE

    def summary(self) -> dict[str, Any]:
        """Return it by name, in SI units, ready for JSON."""
        return asdict(self)


@dataclass(frozen=True)
class AgreedCeiling:
    """How a ceiling was found that agrees with itself, and what came out with the usual one.

    Parameters
    ----------
    load : float
        Load at which the spots were judged [N].
    load_ratio, factor : float
        Of the `RecommendedCeiling` that was solved with.
    mismatch : float
        Ceiling that the result recommends over the one that it was solved with, less one.
    solves : int
        How many there were, the first with three yield strengths.
    usual_ceiling : float
        Three yield strengths [Pa].
    usual_contact_area, usual_approach, usual_indentation : float
        Contact area [m²], approach [m] and largest residual indentation [m] with it.
    """

    load: float
    load_ratio: float
    factor: float
    mismatch: float
    solves: int
    usual_ceiling: float
    usual_contact_area: float
    usual_approach: float
    usual_indentation: float

    def summary(self) -> dict[str, float]:
        """Return it by name, in SI units, ready for JSON."""
        return asdict(self)
