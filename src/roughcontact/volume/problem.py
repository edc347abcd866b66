"""What all loads of a path have in common."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from roughcontact.contact.pair import initial_gap
from roughcontact.errors import InputError
from roughcontact.halfspace.boundary import Boundary
from roughcontact.material.material import Material
from roughcontact.surface.surface import Surface
from roughcontact.volume.result import ElastoplasticResult


@dataclass(frozen=True, eq=False)
class Problem:
    """What all loads of a path have in common; see `solve_elastoplastic`."""

    surface: Surface
    counter_surface: Surface | None
    material: Material
    counter_material: Material
    boundary: Boundary
    tolerance: float
    max_iterations: int
    precision: str

    @property
    def yielding(self) -> list[Material]:
        """Materials with a yield strength, that of the rough body first."""
        both = self.material, self.counter_material
        return [body for body in both if body.yield_strength is not None]

    def check_same(self, what: str, before: ElastoplasticResult) -> None:
        """Raise `InputError` if a result is one of other bodies or another boundary."""
        old = before.contact
        gap = initial_gap(self.surface, self.counter_surface)
        same = {
            "surface": old.pressure.shape == self.surface.shape
            and np.array_equal(old.initial_gap, gap, equal_nan=True),
            "pixel": old.surface.pixel == self.surface.pixel,
            "material": old.material == self.material,
            "counter_material": old.counter_material == self.counter_material,
            "boundary": old.boundary == self.boundary,
        }
        for name, agrees in same.items():
            if not agrees:
                raise InputError(
                    f"{what} was solved with another {name}: plastic strain stays with it"
                )
