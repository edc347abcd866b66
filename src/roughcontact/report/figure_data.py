"""What the figures of reports show, and how a figure is listed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughcontact.contact.result import ContactResult
from roughcontact.contact.spots import Spots
from roughcontact.report.page import MIDDLE
from roughcontact.surface.surface import Surface

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Close-ups show this many times the root of the area of the spot at the peak, or the longer side
# of the most loaded spot, but no fewer pixels; and only where this is a small part of the map.
_AROUND_SPOT = 4
_AROUND_LOADED = 1.5
_SMALL_PART = 0.5
_AROUND_CONTACT = 1.2

# Contact fraction below which a whole map is nearly empty.
_LITTLE = 0.01

_CLOSE_PIXELS = 40

FRONT, RESULTS, BODY, FILES = "front", "results", "body", "files"
"""Where a figure is: on the first page of a report, with its results, there for each body that
yields, or in files alone."""


@dataclass(frozen=True)
class MapScene:
    """A prepared map."""

    surface: Surface  # The map
    of: str = ""  # Whose it is, where there are two
    when: str = "after preparation"  # In which state it is


class Region(NamedTuple):
    """A square of a map."""

    middle: tuple[int, int]  # (y, x)
    width: float  # [m]


@dataclass(frozen=True)
class ContactScene:
    """A contact, and where to look at it closely."""

    result: ContactResult  # The contact

    @cached_property
    def spots(self) -> Spots:
        """Its contact spots."""
        return self.result.spots()

    @property
    def map(self) -> MapScene:
        """The map of the body."""
        return MapScene(self.result.surface)

    @property
    def missing(self) -> str:
        """A sentence on missing points, if there are any."""
        return " Gray points were not measured." if np.isnan(self.result.gap).any() else ""

    @cached_property
    def most_loaded(self) -> Region:
        """The spot that carries most."""
        if self.spots.count == 0:
            return Region((0, 0), math.inf)
        return self._around(self.spots.label == 1 + int(self.spots.load.argmax()), _AROUND_LOADED)

    @cached_property
    def touched(self) -> Region:
        """All of the contact if that is a small part of the map, else the most loaded spot."""
        if self.spots.count == 0:
            return Region((0, 0), math.inf)
        whole = self._around(self.result.contact, _AROUND_CONTACT)
        return whole if self.is_part(whole.width) else self.most_loaded

    @property
    def is_crowded(self) -> bool:
        """Whether the most loaded spot is a small part of what is shown of the contact."""
        whole = self.touched.width if self.is_sparse else self._side
        return self.most_loaded.width < _SMALL_PART * whole

    @property
    def is_sparse(self) -> bool:
        """Whether the map of the contact is nearly empty."""
        if not self.is_part(self.touched.width):
            return False
        return self.touched is not self.most_loaded or self.result.contact_fraction < _LITTLE

    def _around(self, points: NDArray[np.bool_], factor: float) -> Region:
        """Return the square around points, so many times as wide."""
        pixel = self.result.surface.pixel
        if self.result.surface.is_profile:
            pixel = (0.0, pixel[1])
        ends = [(int(place.min()), int(place.max())) for place in np.nonzero(points)]
        sides = [(last - first + 1) * edge for (first, last), edge in zip(ends, pixel, strict=True)]
        middle = sum(ends[0]) // 2, sum(ends[1]) // 2
        return Region(middle, max(factor * max(sides), _CLOSE_PIXELS * max(pixel)))

    @cached_property
    def around_peak(self) -> float:
        """A width that shows the spot at the highest peak [m]."""
        result = self.result
        peak = np.unravel_index(np.nanargmin(result.initial_gap), result.gap.shape)
        number = int(self.spots.label[peak])
        size = math.sqrt(float(self.spots.area[number - 1])) if number else 0.0
        return max(_AROUND_SPOT * size, _CLOSE_PIXELS * max(result.surface.pixel))

    def is_part(self, width: float) -> bool:
        """Return whether a width is so small a part of the map that it is worth a figure."""
        return width < _SMALL_PART * self._side

    @property
    def _side(self) -> float:
        surface = self.result.surface
        return min(surface.size[surface.is_profile :])


@dataclass(frozen=True)
class Illustration:
    """A figure of a report."""

    name: str  # Of its file
    draw: Callable[[Any], Figure]  # `draw(scene)` returns the figure
    caption: str | Callable[[Any], str]  # Text below the figure, and in place of it
    chapter: str = RESULTS  # Where in a report it is
    width: int = MIDDLE  # In a report [mm]
    when: Callable[[Any], bool] = lambda _: True  # `when(scene)` says whether a report shows it

    def text(self, scene: Any) -> str:
        """Return the caption of a scene."""
        return self.caption if isinstance(self.caption, str) else self.caption(scene)


Illustrations = Sequence[Illustration]
