"""Two bodies that face each other at changing positions, and the indentation one of them keeps."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from roughcontact.arguments import checked
from roughcontact.contact.pair import Pair
from roughcontact.contact.result import ContactResult
from roughcontact.errors import CapacityError
from roughcontact.surface.provenance import Operation, Provenance
from roughcontact.surface.surface import Surface

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SlidingPair:
    """Two bodies that face each other at changing positions; one of them is indented."""

    pair: Pair  # The bodies at the first position, not yet indented
    counter: Surface | None  # The counter-body as it is moved
    on_counter: bool  # Whether the counter-body keeps the indentation
    origin: tuple[int, int]

    @property
    def indented(self) -> Surface:
        """The body that keeps the indentation, before it."""
        body = self.counter if self.on_counter else self.pair.surface
        assert body is not None
        return body

    def facing(self, indentation: Array, shift: tuple[int, int]) -> Pair:
        """Return the two bodies as they face each other, on the grid of the surface."""
        surface, counter = self.pair.surface, self.counter
        if not self.on_counter and indentation.any():
            surface = replace(surface, heights=surface.heights - indentation)
        if counter is None:
            return replace(self.pair, share=surface)
        heights = counter.heights - indentation if self.on_counter else counter.heights
        moved = np.full(surface.shape, np.nan)
        here, there = self._overlap(shift)
        moved[here] = self._rolled(heights, shift)[there]
        if np.isnan(moved + surface.heights).all():
            raise CapacityError(
                f"no contact is possible: shifted by {shift} pixels the counter-body has no point "
                "left that faces one of the surface"
            )
        facing = replace(counter, heights=moved, holes_masked=True)
        return replace(self.pair, share=surface, counter_surface=facing)

    def indent(self, indentation: Array, new: Array, shift: tuple[int, int]) -> None:
        """Add what was indented on the grid of the surface to the body that keeps it."""
        if not self.on_counter:
            indentation += new
            return
        here, there = self._overlap(shift)
        own = np.zeros(indentation.shape)
        own[there] = new[here]
        indentation += self._rolled(own, (-shift[0], -shift[1]))

    def _rolled(self, values: Array, shift: tuple[int, int]) -> Array:
        """Return a map shifted along its periodic axes."""
        axes = self.pair.boundary.periodic_axes
        return np.roll(values, [shift[axis] for axis in axes], axes) if axes else values

    def _overlap(self, shift: tuple[int, int]) -> tuple[tuple[slice, ...], tuple[slice, ...]]:
        """Return which part of the surface faces the counter-body, and which part of that."""
        assert self.counter is not None
        here, there = [], []
        for axis, (points, own) in enumerate(zip(self.pair.shape, self.counter.shape, strict=True)):
            ahead = shift[axis] - self.origin[axis]
            if axis in self.pair.boundary.periodic_axes:
                ahead = 0
            first, last = max(0, ahead), min(points, ahead + own)
            here.append(slice(first, last))
            there.append(slice(first - ahead, last - ahead))
        return tuple(here), tuple(there)


def facing(pair: Pair, shifts: list[tuple[int, int]]) -> SlidingPair:
    """Return the two bodies of a path of shifts, the softer one ready to be indented."""
    body = pair.softer
    on_counter = pair.material.compliance == 0 if body is None else body is not pair.material
    counter = pair.counter_surface
    if not on_counter or counter is not None:
        return SlidingPair(pair, counter, on_counter, (0, 0))
    # A flat without end: as much of it as will face the map.
    shape, origin = list(pair.shape), [0, 0]
    for axis in pair.boundary.free_axes:
        along = [shift[axis] for shift in shifts]
        origin[axis] = max(0, *along)
        shape[axis] += origin[axis] - min(0, *along)
    flat = Surface(np.zeros(shape), pair.pixel, Provenance(source="flat"))
    return SlidingPair(pair, flat, on_counter, (origin[0], origin[1]))


def indented(body: Surface, indentation: Array) -> Surface:
    """Return a body lowered by its indentation."""
    if not indentation.any():
        return body
    step = Operation("indented", found={"depth": indentation.max()})
    provenance = body.provenance.then(step)
    return replace(body, heights=body.heights - indentation, provenance=provenance)


# --- What a contact leaves behind for unloading and the next loading ---


@checked
def indented_surface(result: ContactResult) -> Surface:
    """Return the surface of a contact with the permanent indentation that the contact leaves.

    Parameters
    ----------
    result : ContactResult
        A solution.

    Returns
    -------
    Surface
        Heights less `ContactResult.residual_indentation`; the surface itself where nothing is
        saturated. Pressed under smaller loads it is elastic: unloading and loading again follow
        `roughcontact.studies.load_history`. All of the indentation is on the surface, whichever
        body is softer, which changes no contact of the two at this position.

    Examples
    --------
    >>> import roughcontact as rc
    >>> steel = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)
    >>> rough = rc.Surface(*rc.reference_map(32))
    >>> loaded = rc.solve(rough, material=steel, load=1.0)
    >>> again = rc.solve(rc.indented_surface(loaded), material=steel, load=1.0)
    >>> loaded.saturated_fraction > 0, round(again.contact_area / loaded.contact_area, 2)
    (True, 1.0)
    """
    return indented(result.surface, result.residual_indentation)
