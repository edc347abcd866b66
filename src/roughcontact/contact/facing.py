"""Two bodies that face each other at changing positions, and the indentation one of them keeps."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from roughcontact.errors import CapacityError
from roughcontact.halfspace.boundary import Boundary
from roughcontact.material.material import Material, softer
from roughcontact.surface.provenance import Operation, Provenance
from roughcontact.surface.surface import Surface

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Facing:
    """Two bodies that face each other at changing positions; one of them is indented.

    ``origin`` is the pixel of the counter-body that faces pixel (0, 0) of the surface unshifted.
    """

    surface: Surface
    counter: Surface | None
    on_counter: bool
    boundary: Boundary
    origin: tuple[int, int]

    @property
    def indented(self) -> Surface:
        """The body that keeps the indentation, before it."""
        body = self.counter if self.on_counter else self.surface
        assert body is not None
        return body

    def facing(self, indentation: Array, shift: tuple[int, int]) -> tuple[Surface, Surface | None]:
        """Return the two bodies as they face each other, on the grid of the surface."""
        surface, counter = self.surface, self.counter
        if not self.on_counter and indentation.any():
            surface = replace(surface, heights=surface.heights - indentation)
        if counter is None:
            return surface, None
        heights = counter.heights - indentation if self.on_counter else counter.heights
        moved = np.full(surface.shape, np.nan)
        here, there = self._overlap(shift)
        moved[here] = self._rolled(heights, shift)[there]
        if np.isnan(moved + surface.heights).all():
            raise CapacityError(
                f"no contact is possible: shifted by {shift} pixels the counter-body has no point "
                "left that faces one of the surface"
            )
        return surface, replace(counter, heights=moved, holes_masked=True)

    def _overlap(self, shift: tuple[int, int]) -> tuple[tuple[slice, ...], tuple[slice, ...]]:
        """Return which part of the surface faces the counter-body, and which part of that."""
        assert self.counter is not None
        here, there = [slice(None)] * 2, [slice(None)] * 2
        for axis, (points, own) in enumerate(
            zip(self.surface.shape, self.counter.shape, strict=True)
        ):
            if axis in self.boundary.periodic_axes:
                continue
            ahead = shift[axis] - self.origin[axis]
            first, last = max(0, ahead), min(points, ahead + own)
            here[axis] = slice(first, last)
            there[axis] = slice(first - ahead, last - ahead)
        return tuple(here), tuple(there)

    def _rolled(self, values: Array, shift: tuple[int, int]) -> Array:
        """Return a map shifted along the axes where it goes on beyond its edges."""
        axes = self.boundary.periodic_axes
        return np.roll(values, [shift[axis] for axis in axes], axes) if axes else values

    def indent(self, indentation: Array, new: Array, shift: tuple[int, int]) -> None:
        """Add what was indented on the grid of the surface to the body that keeps it."""
        if not self.on_counter:
            indentation += new
        else:
            here, there = self._overlap(shift)
            back = -shift[0], -shift[1]
            indentation[there] += self._rolled(new, back)[here]


def facing(
    surface: Surface,
    counter: Surface | None,
    material: Material,
    counter_material: Material,
    boundary: Boundary,
    shifts: list[tuple[int, int]],
) -> Facing:
    """Return the two bodies of a path of shifts, the softer one ready to be indented."""
    body = softer(material, counter_material)
    on_counter = material.compliance == 0 if body is None else body is not material
    origin = (0, 0)
    if on_counter and counter is None:
        # A flat without end: as much of it as will face the map.
        ends = boundary.free_axes
        reach = [[shift[axis] * (axis in ends) for shift in shifts] for axis in (0, 1)]
        origin = max(0, *reach[0]), max(0, *reach[1])
        shape = tuple(
            points + most - min(0, *along)
            for points, most, along in zip(surface.shape, origin, reach, strict=True)
        )
        counter = Surface(np.zeros(shape), surface.pixel, Provenance(source="flat"))
    return Facing(surface, counter, on_counter, boundary, origin)


def indented(body: Surface, indentation: Array) -> Surface:
    """Return a body lowered by its indentation."""
    if not indentation.any():
        return body
    step = Operation("indented", found={"depth": indentation.max()})
    provenance = body.provenance.then(step)
    return replace(body, heights=body.heights - indentation, provenance=provenance)


def highest(first: Surface, second: Surface | None) -> float:
    """Return the largest sum of heights that face each other: there they touch first."""
    heights = first.heights if second is None else first.heights + second.heights
    return float(np.fmax.reduce(heights, axis=None))
