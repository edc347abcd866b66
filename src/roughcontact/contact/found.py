"""Loads at which a contact has a value that was asked for, each with its bracket."""

from __future__ import annotations

from dataclasses import dataclass

from roughcontact.contact.cautions import Caution, ordered
from roughcontact.contact.judgment import over_loads
from roughcontact.contact.result import ContactResult
from roughcontact.result import Result

CONTACT, SATURATED, APPROACH, GAP, YIELD = (
    "contact_fraction", "saturated_share", "approach", "mean_gap", "first_yield"
)  # fmt: skip
"""What can be asked for."""

COUNTED = (CONTACT, SATURATED)
"""Those of whole pixels: staircases that pass a value rather than have it."""


@dataclass(frozen=True)
class Side:
    """A load that was solved, next to the one asked for.

    Parameters
    ----------
    load : float
        W [N].
    value : float
        The quantity at it [SI].
    """

    load: float
    value: float


@dataclass(frozen=True, eq=False)
class FoundLoad:
    """The load at which one quantity has one value.

    Parameters
    ----------
    quantity : str
        ``"contact_fraction"``: share of the map that touches; ``"saturated_share"``: of the
        contact area that is at the ceiling; ``"approach"`` or ``"mean_gap"`` [m];
        ``"first_yield"``: the largest von Mises stress at or below the surface over the yield
        strength, of the elastic contact.
    target : float
        The value asked for [SI]; 1 for first yield.
    value : float
        The quantity under ``load`` [SI].
    below, above : Side
        Neighboring loads that were solved: at the smaller the value is not reached, at the
        larger it is.
    result : ContactResult
        The contact under ``load``, with its certificate.
    """

    quantity: str
    target: float
    value: float
    below: Side
    above: Side
    result: ContactResult

    @property
    def load(self) -> float:
        """The load [N]: one of the bracket, at which the quantity was computed."""
        return self.result.load

    @property
    def bracket(self) -> tuple[float, float]:
        """The neighboring loads between which the value is passed [N]."""
        return self.below.load, self.above.load

    @property
    def error(self) -> float:
        """Value over target, less one."""
        return self.value / self.target - 1

    @property
    def certificate(self) -> float:
        """Certificate ε of the contact under this load."""
        return self.result.certificate


@dataclass(frozen=True, eq=False, repr=False)
class FoundLoads(Result):
    """The loads that were asked for.

    Parameters
    ----------
    answers : tuple of FoundLoad
        In the order of the questions.
    solves : int
        Contacts that were solved for all of them together.
    convolutions : int
        Of these contacts, on the full grid.
    seconds : float
        Wall time.
    remarks : tuple of Caution
        What else is known of the numbers, from the measurement of the maps.
    """

    answers: tuple[FoundLoad, ...]
    solves: int
    convolutions: int
    seconds: float
    remarks: tuple[Caution, ...] = ()

    @property
    def largest(self) -> ContactResult:
        """The contact under the largest of the loads."""
        return max(self.answers, key=lambda answer: answer.load).result

    @property
    def cautions(self) -> tuple[Caution, ...]:
        """What a reader of the numbers has to know, the severest first."""
        ascending = sorted(self.answers, key=lambda answer: answer.load)
        judged = over_loads([(one.load, one.result.cautions) for one in ascending], "N")
        return ordered(dict.fromkeys([*judged, *self.remarks]))
