"""What the figures of reports show, and how a figure is listed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from roughcontact.contact.result import ContactResult
from roughcontact.contact.spots import Spots
from roughcontact.surface.surface import Surface

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Close-ups show this many times the root of the area of the spot at the peak, or the longer side
# of the most loaded spot, but no fewer pixels; and only where this is a small part of the map.
_AROUND_SPOT = 4
_AROUND_LOADED = 1.5
_SMALL_PART = 0.5
_CLOSE_PIXELS = 40

PREPARATION, ROUGHNESS, RESULTS, SECTIONS, SPOTS, BODY, PATH, ACCURACY = (
    "preparation", "roughness", "results", "sections", "spots", "body", "path", "accuracy",
)  # fmt: skip
"""Chapters that have figures."""


@dataclass(frozen=True)
class MapScene:
    """A prepared map."""

    surface: Surface  # The map
    of: str = ""  # Whose it is, where there are two
    when: str = "as they were pressed, after preparation"  # In which state it is


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
        return " Grey points were not measured." if np.isnan(self.result.gap).any() else ""

    @cached_property
    def most_loaded(self) -> tuple[tuple[int, int], float]:
        """Middle (y, x) of the spot that carries most, and a width that shows it [m]."""
        pixel, spots = self.result.surface.pixel, self.spots
        if spots.count == 0:
            return (0, 0), math.inf
        if self.result.surface.is_profile:
            pixel = (0.0, pixel[1])
        places = np.nonzero(spots.label == 1 + int(spots.load.argmax()))
        ends = [(int(place.min()), int(place.max())) for place in places]
        sides = [(last - first + 1) * edge for (first, last), edge in zip(ends, pixel, strict=True)]
        middle = sum(ends[0]) // 2, sum(ends[1]) // 2
        return middle, max(_AROUND_LOADED * max(sides), _CLOSE_PIXELS * max(pixel))

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
        surface = self.result.surface
        return width < _SMALL_PART * min(surface.size[surface.is_profile :])


@dataclass(frozen=True)
class Illustration:
    """A figure of a report."""

    name: str  # Of its file
    draw: Callable[[Any], Figure]  # `draw(scene)` returns the figure
    alt: str | Callable[[Any], str]  # Text in place of the figure
    caption: str | Callable[[Any], str]  # Text below the figure
    chapter: str = RESULTS  # Where in a report it stands
    when: Callable[[Any], bool] = lambda _: True  # `when(scene)` says whether a report shows it

    def words(self, scene: Any) -> tuple[str, str]:
        """Return what stands for the figure, and what stands below it."""
        alt, caption = (w if isinstance(w, str) else w(scene) for w in (self.alt, self.caption))
        return alt, caption


Illustrations = Sequence[Illustration]
