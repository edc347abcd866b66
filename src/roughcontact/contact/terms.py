"""What is asked of a solve besides the bodies."""

from __future__ import annotations

from dataclasses import dataclass

from numpy.typing import ArrayLike

from roughcontact.contact.loads import GivenLoad
from roughcontact.material.hardness import stress
from roughcontact.units import Quantities, Quantity, quantity


@dataclass(frozen=True, eq=False)
class Terms:
    """How two bodies are pressed together, and how exactly that is solved.

    Parameters
    ----------
    load, approach, moments, ceiling, tolerance, max_iterations, precision
        As for `roughcontact.solve`; the load is a force.
    given : GivenLoad or None
        The load in the form in which it was given, where that was no force.
    """

    load: float | None = None
    approach: float | None = None
    moments: tuple[float, float] | None = None
    ceiling: str | float | ArrayLike | None = "auto"
    tolerance: float | None = None
    max_iterations: int = 2000
    precision: str = "double"
    given: GivenLoad | None = None

    def __init__(
        self,
        load: Quantity | None = None,
        approach: Quantity | None = None,
        moments: Quantities | None = None,
        ceiling: Quantity | ArrayLike | None = "auto",
        tolerance: float | None = None,
        max_iterations: int = 2000,
        precision: str = "double",
        given: GivenLoad | None = None,
    ) -> None:
        object.__setattr__(self, "load", quantity(load, "force", "load"))
        object.__setattr__(self, "approach", quantity(approach, "length", "approach"))
        object.__setattr__(self, "moments", quantity(moments, "moment", "moments"))
        if not (isinstance(ceiling, str) and ceiling.isalpha()):
            ceiling = stress(ceiling, "ceiling")
        object.__setattr__(self, "ceiling", ceiling)
        object.__setattr__(self, "tolerance", tolerance)
        object.__setattr__(self, "max_iterations", max_iterations)
        object.__setattr__(self, "precision", precision)
        object.__setattr__(self, "given", given)

    @property
    def control(self) -> str:
        """Which of load and approach is given."""
        return "load" if self.approach is None else "approach"

    @property
    def target(self) -> float:
        """The load [N] or approach [m] given."""
        target = self.load if self.approach is None else self.approach
        assert target is not None
        return target

    @property
    def certificate(self) -> float:
        """Tolerance given, or that of the precision."""
        if self.tolerance is not None:
            return self.tolerance
        return 1e-6 if self.precision == "double" else 1e-4
