"""What all loads of a path have in common."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughcontact.contact.checks import touchable_gap
from roughcontact.contact.pair import Pair
from roughcontact.errors import InputError
from roughcontact.material.material import Material
from roughcontact.volume.path import moved
from roughcontact.volume.result import ElastoplasticResult


@dataclass(frozen=True, eq=False)
class Problem:
    """What all loads of a path have in common; see `solve_elastoplastic`."""

    pair: Pair
    tolerance: float
    max_iterations: int
    precision: str

    @property
    def contact_tolerance(self) -> float:
        """Tolerance of the contact: a hundredth of that of the strain, 1e-10 to 1e-6."""
        return max(1e-10, min(1e-6, self.tolerance / 100))

    @property
    def yielding(self) -> list[Material]:
        """Materials with a yield strength, that of the rough body first."""
        both = self.pair.material, self.pair.counter_material
        return [body for body in both if body.yield_strength is not None]

    def pair_at(self, offset: tuple[float, float]) -> Pair:
        """Return the bodies with the counter-surface moved along ``(y, x)`` [m]."""
        return moved(self.pair, offset)

    def gap_at(self, offset: tuple[float, float]) -> NDArray[np.float64]:
        """Return their gap at first touch [m], infinite where they never touch."""
        return touchable_gap(self.pair_at(offset))

    def check_same(self, what: str, before: ElastoplasticResult) -> None:
        """Raise `InputError` if a result is one of other bodies or another boundary."""
        last = before.increments[-1].offset if before.increments else (0.0, 0.0)
        old, new = before.solution.pair, self.pair_at(last)
        same = {
            "surface": old.shape == new.shape
            and np.array_equal(old.initial_gap, new.initial_gap, equal_nan=True),
            "pixel": old.pixel == new.pixel,
            "material": old.material == new.material,
            "counter_material": old.counter_material == new.counter_material,
            "boundary": old.boundary == new.boundary,
        }
        for name, agrees in same.items():
            if not agrees:
                raise InputError(
                    f"{what} was solved with another {name}, to which its plastic strain belongs"
                )
