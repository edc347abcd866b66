"""What only a report tells, in rows like those of the tables: spots, and bodies that yield."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

from roughcontact.contact.judgment import carrying_pixels
from roughcontact.contact.result import ContactResult
from roughcontact.contact.spots import Spots
from roughcontact.report.quantities import Quantity, Table
from roughcontact.units import engineering, percent
from roughcontact.volume import depth
from roughcontact.volume.profiles import LayerProfile
from roughcontact.volume.result import ElastoplasticResult

# Spots whose share of the load is told.
_LARGEST = 10


class Spotted(NamedTuple):
    """A contact with its spots."""

    result: ContactResult
    spots: Spots


def _share_of_load(found: Spotted, count: int) -> str:
    load = found.spots.load
    return percent(min(float(load[:count].sum()) / float(load.sum()), 1.0))


def _largest_area(found: Spotted) -> str:
    largest = float(found.spots.area[0])
    share = percent(largest / found.result.contact_area)
    return f"{engineering(largest, 'm²')} ({share} of the contact area)"


SPOTS: Table = (
    Quantity("count", "number of spots", of="spots.count"),
    Quantity("mean_area", "mean area", unit="m²", of=lambda s: float(s.spots.area.mean())),
    Quantity(
        "largest_area", "largest area", unit="m²", of=lambda s: float(s.spots.area[0]),
        text=_largest_area,
    ),
    Quantity(
        "largest_load", "load on the largest", unit="N", of=lambda s: float(s.spots.load[0]),
        text=lambda s: f"{engineering(float(s.spots.load[0]), 'N')} "
        f"({_share_of_load(s, 1)} of the load)",
    ),
    Quantity(
        "largest_loads", f"load on the {_LARGEST} largest",
        of=lambda s: float(s.spots.load[:_LARGEST].sum()),
        text=lambda s: f"{_share_of_load(s, _LARGEST)} of the load",
        when=lambda s: s.spots.count > _LARGEST,
    ),
    Quantity(
        "carrying_pixels", "pixels of a load-carrying spot",
        meaning="spots of at least this size carry half of the load",
        of=lambda s: carrying_pixels(s.result, s.spots),
    ),
)  # fmt: skip
"""Of the contact spots, `Spotted`."""


class Yielding:
    """One body that yields, and what its layers hold at most.

    Parameters
    ----------
    result : ElastoplasticResult
        The result.
    number : int
        Which of its bodies.
    """

    def __init__(self, result: ElastoplasticResult, number: int) -> None:
        self.result = result
        self.number = number
        self.body = result.bodies[number]

    @cached_property
    def layers(self) -> LayerProfile:
        """Largest values of each layer."""
        return depth.layers(self.result, self.number)

    @property
    def loaded(self) -> bool:
        """Whether there is a load in the end."""
        return bool(self.result.solution.load)


def _place(found: Yielding) -> str:
    layer, row, column = depth.most_strained(found.result, found.number)
    dy, dx = found.result.solution.surface.pixel
    deep = engineering(float(found.body.depth[layer]), "m")
    y, x = (engineering(place, "m") for place in ((row + 0.5) * dy, (column + 0.5) * dx))
    return f"{deep} deep, at y, x = {y}, {x}"


def _deepest(found: Yielding, name: str) -> str:
    values = getattr(found.layers, name)
    deep = float(found.body.depth[int(values.argmax())])
    return f"{engineering(float(values.max()), 'Pa')}, {engineering(deep, 'm')} deep"


def _layers(found: Yielding) -> str:
    thickness = found.body.thickness
    return f"{thickness.size}, {engineering(float(thickness.sum()), 'm')} deep in all"


YIELDING: Table = (
    Quantity(
        "max_plastic_strain", "largest accumulated plastic strain", of="body.max_plastic_strain",
        text=lambda b: f"{percent(b.body.max_plastic_strain)}, {_place(b)}",
        when=lambda b: bool(b.body.plastic_volume),
    ),
    Quantity(
        "max_von_mises", "largest stress", unit="Pa", of="body.max_von_mises",
        text=lambda b: f"{engineering(b.body.max_von_mises, 'Pa')}, {_place(b)}",
        when=lambda b: not b.body.plastic_volume,
    ),
    Quantity(
        "plastic_depth", "plastic depth", unit="m", of="body.plastic_depth",
        meaning="lower face of the lowest layer with plastic strain",
    ),
    Quantity(
        "plastic_volume", "plastic volume", unit="m³", of="body.plastic_volume",
        meaning="with any plastic strain",
    ),
    Quantity(
        "max_residual_stress", "largest residual von Mises stress", unit="Pa",
        of=lambda b: float(b.layers.max_residual_von_mises.max()),
        text=lambda b: _deepest(b, "max_residual_von_mises"),
    ),
    Quantity(
        "max_stress_under_load", "largest von Mises stress under load", unit="Pa",
        of=lambda b: float(b.layers.max_von_mises.max()),
        text=lambda b: _deepest(b, "max_von_mises"), when=lambda b: b.loaded,
    ),
    Quantity("layers", "layers", of=lambda b: b.body.thickness.size, text=_layers),
)  # fmt: skip
"""Of one body of the volume model, `Yielding`."""
