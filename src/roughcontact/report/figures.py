"""Figures of reports and their captions.

The figures also define the names of the files that ``--figures`` writes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from operator import attrgetter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from roughcontact.contact.pair import BODIES
from roughcontact.contact.plausibility import load_bearing_spot_pixels
from roughcontact.contact.result import ContactResult
from roughcontact.contact.spots import Spots
from roughcontact.drawing import elastoplastic, maps, sections
from roughcontact.elastoplastic.volume_result import ElastoplasticResult
from roughcontact.report.page import HALF, MIDDLE, WIDE
from roughcontact.surface.surface import Surface
from roughcontact.units import count_noun, format_engineering, format_percent

if TYPE_CHECKING:
    from matplotlib.figure import Figure


# Width of close-ups over the square root of the area of the spot at the peak, and over the longer
# side of the most loaded spot; largest part of a map that gets a close-up; width of a close-up over
# the longer side of the contact.
_AROUND_SPOT = 4
_AROUND_LOADED = 1.5
_SMALL_PART = 0.5
_AROUND_CONTACT = 1.2

# Contact fraction below which a whole map is nearly empty.
_MIN_FILLED_FRACTION = 0.01

_CLOSE_PIXELS = 40

FRONT, RESULTS, BODY, FILES = "front", "results", "body", "files"
"""Places of figures: first page, results (also per yielding body), or only in files."""


@dataclass(frozen=True)
class MapScene:
    """Scene of a prepared map."""

    surface: Surface  # The map
    of: str = ""  # Body of the map, if there are two
    when: str = "after preparation"  # State of the map


class Region(NamedTuple):
    """Square region of a map."""

    middle: tuple[int, int]  # Row and column (y, x) of the center
    width: float  # Side [m]


@dataclass(frozen=True)
class ContactScene:
    """Scene of a contact, with the regions of its close-ups."""

    result: ContactResult  # The contact

    @cached_property
    def spots(self) -> Spots:
        """Contact spots."""
        return self.result.spots()

    @property
    def map(self) -> MapScene:
        """Scene of the map of the body."""
        return MapScene(self.result.surface)

    @property
    def missing(self) -> str:
        """Sentence on missing points, if any."""
        return " Gray points were not measured." if np.isnan(self.result.gap).any() else ""

    @cached_property
    def most_loaded(self) -> Region:
        """Region of the spot that carries the largest load."""
        if self.spots.count == 0:
            return Region((0, 0), math.inf)
        return self._square_region(
            self.spots.label == 1 + int(self.spots.load.argmax()), _AROUND_LOADED
        )

    @cached_property
    def touched(self) -> Region:
        """Region of the contact if a small part of the map, else of the most loaded spot."""
        if self.spots.count == 0:
            return Region((0, 0), math.inf)
        whole = self._square_region(self.result.contact, _AROUND_CONTACT)
        return whole if self.is_part(whole.width) else self.most_loaded

    @property
    def is_crowded(self) -> bool:
        """Whether the most loaded spot is a small part of the shown contact."""
        whole = self.touched.width if self.is_sparse else self._side
        return self.most_loaded.width < _SMALL_PART * whole

    @property
    def is_sparse(self) -> bool:
        """Whether the map of the contact is nearly empty."""
        if not self.is_part(self.touched.width):
            return False
        return (
            self.touched is not self.most_loaded
            or self.result.contact_fraction < _MIN_FILLED_FRACTION
        )

    def _square_region(self, points: NDArray[np.bool_], factor: float) -> Region:
        """Return the square around points, widened by a factor."""
        pixel = self.result.surface.pixel
        if self.result.surface.is_profile:
            pixel = (0.0, pixel[1])
        ends = [(int(place.min()), int(place.max())) for place in np.nonzero(points)]
        sides = [(last - first + 1) * edge for (first, last), edge in zip(ends, pixel, strict=True)]
        middle = sum(ends[0]) // 2, sum(ends[1]) // 2
        return Region(middle, max(factor * max(sides), _CLOSE_PIXELS * max(pixel)))

    @cached_property
    def around_peak(self) -> float:
        """Width that shows the spot at the highest peak [m]."""
        result = self.result
        peak = np.unravel_index(np.nanargmin(result.initial_gap), result.gap.shape)
        number = int(self.spots.label[peak])
        size = math.sqrt(float(self.spots.area[number - 1])) if number else 0.0
        return max(_AROUND_SPOT * size, _CLOSE_PIXELS * max(result.surface.pixel))

    def is_part(self, width: float) -> bool:
        """Return whether a width is a part of the map small enough for a close-up."""
        return width < _SMALL_PART * self._side

    @property
    def _side(self) -> float:
        surface = self.result.surface
        return min(surface.size[surface.is_profile :])


@dataclass(frozen=True)
class Illustration:
    """Figure of a report."""

    name: str  # Name of its file
    draw: Callable[[Any], Figure]  # `draw(scene)` returns the figure
    caption: str | Callable[[Any], str]  # Text below the figure, and its alternative text
    chapter: str = RESULTS  # Place in a report
    width: int = MIDDLE  # Width in a report [mm]
    when: Callable[[Any], bool] = lambda _: True  # `when(scene)`: whether a report shows it

    def text(self, scene: Any) -> str:
        """Return the caption for a scene."""
        return self.caption if isinstance(self.caption, str) else self.caption(scene)


Illustrations = Sequence[Illustration]
PlotFunctions = Sequence[Callable[..., Any]]  # Functions that draw a result


# Sections get a close-up if the plastic zone is less deep than this part of the map width; width
# of the close-up over that depth, and its minimum in pixels.
_SMALL_ZONE = 0.1
_AROUND_ZONE = 6.0
_CLOSE_ZONE_PIXELS = 24

# Number of largest spots whose share of the load is given.
_MAX_SHARED_SPOTS = 10


@dataclass(frozen=True)
class VolumeScene:
    """Scene of an elastoplastic contact and one of its bodies."""

    result: ElastoplasticResult  # The result
    body: int = 0  # Index of the body
    width: float | None = None  # Width of the sections around the largest plastic strain [m]

    @property
    def contact(self) -> ContactScene:
        """Scene of the contact in the final state."""
        return ContactScene(self.result.solution)

    @property
    def loaded_contact(self) -> ContactScene:
        """Scene of the final contact; if unloaded, under the largest load (the gap is not)."""
        load, pressure = self.result.largest
        solution = self.result.solution
        if self.loaded or not load:
            return self.contact
        return ContactScene(replace(solution, load=load, pressure=pressure))

    @property
    def known(self) -> bool:
        """Whether there is a pressure to draw under the largest load."""
        return bool(self.result.largest[0])

    @property
    def loaded(self) -> bool:
        """Whether the bodies are loaded in the final state."""
        return bool(self.result.solution.load)

    @property
    def where(self) -> str:
        """Name of the body in a caption, if there are two."""
        return f" of the {tuple(BODIES.values())[self.body]}" if len(self.result.bodies) > 1 else ""

    def close(self) -> VolumeScene:
        """Return the scene of a close-up of the plastic zone, if it is a small part of the map."""
        zone = self.result.profile(body=self.body)
        plastic = np.flatnonzero(zone.accumulated)
        if not plastic.size:
            return self
        deep = float(zone.faces[plastic[-1] + 1])
        surface = self.result.solution.surface
        size = min(surface.size)
        width = max(_AROUND_ZONE * deep, _CLOSE_ZONE_PIXELS * max(surface.pixel))
        return replace(self, width=width if deep < _SMALL_ZONE * size and width < size else None)


def _nested_figure(attribute: str, inner: Illustration) -> Illustration:
    """Return a figure of a scene that is an attribute of another scene."""
    return within_scene(attrgetter(attribute), inner)


def within_scene(within: Callable[[Any], Any], inner: Illustration) -> Illustration:
    """Return a figure of a scene that ``within`` computes from another scene."""
    return replace(
        inner,
        draw=lambda scene: inner.draw(within(scene)),
        caption=lambda scene: inner.text(within(scene)),
        when=lambda scene: inner.when(within(scene)),
    )


# The maps


def _heights(scene: MapScene) -> str:
    missing = " Gray points are missing." if scene.surface.missing else ""
    return f"Heights{scene.of} {scene.when}. Yellow is high: contact starts there.{missing}"


MAP = Illustration("surface", lambda s: maps.surface(s.surface), _heights, FILES, HALF)
"""Figure of a prepared map."""


# The contact


def _load(scene: ContactScene) -> str:
    return format_engineering(scene.result.total_load, scene.result.pair.load_unit, 3)


def _classes(scene: ContactScene) -> str:
    result, spots = scene.result, scene.spots
    yields = ""
    if result.saturated_fraction > 0:
        yields = " Dark red: pressure at the ceiling, the material yields."
    carried = ""
    if spots.count > _MAX_SHARED_SPOTS:
        share = format_percent(float(spots.load[:_MAX_SHARED_SPOTS].sum() / spots.load.sum()))
        carried = f" The {_MAX_SHARED_SPOTS} largest spots carry {share} of the load."
    return (
        f"Where the bodies touch under {_load(scene)}: {count_noun(spots.count, 'spot')}. Blue: "
        f"elastic.{yields}{carried}{scene.missing}"
    )


def _gap(scene: ContactScene) -> str:
    mean = format_engineering(scene.result.mean_gap, "m", 3)
    return (
        f"Open gap under {_load(scene)}, mean {mean}. Orange: closed. Dark blue: widest, room for "
        f"fluid or wear debris.{scene.missing}"
    )


def _pressure(scene: ContactScene) -> str:
    largest = format_engineering(scene.result.max_pressure, "Pa", 3)
    return (
        f"Contact pressure under {_load(scene)}, maximum {largest}. Darker is higher; the lightest "
        "ground is not in contact."
    )


def _close_up(scene: ContactScene, region: Region) -> str:
    about = format_engineering(region.width, "m", 3)
    where = "the most loaded spot" if region is scene.most_loaded else "the contact"
    pixels = load_bearing_spot_pixels(scene.result, scene.spots)
    return (
        f"Pressure (left) and state (right) in {about} around {where}. Count the pixels: half of "
        f"the load is on spots of {count_noun(pixels, 'pixel')} or more."
    )


def _sections(scene: ContactScene) -> str:
    what = "profile" if scene.result.counter_surface is None else "sum of both profiles"
    yields = ""
    if scene.result.saturated_fraction > 0:
        yields = "; dark red is the material that yields"
    return (
        f"Sections through the highest summit. Top: {what} before loading (gray), moved by the "
        f"approach, and under load (blue){yields}. Bottom: pressure on the same line."
    )


def _closely(region: str, chapter: str, when: Callable[[Any], bool]) -> Illustration:
    """Return the figure of a close-up of a contact."""
    get = attrgetter(region)
    return Illustration(
        "",
        lambda s: maps.close_up(s.result, *get(s)),
        lambda s: _close_up(s, get(s)),
        chapter,
        MIDDLE,
        when,
    )


CONTACT = (
    _nested_figure("map", MAP),
    _closely("touched", FRONT, lambda s: s.is_sparse),
    Illustration(
        "pressure",
        lambda s: maps.pressure(s.result),
        _pressure,
        width=HALF,
        # A sparse contact is shown by a close-up.
        when=lambda s: not s.is_sparse,
    ),
    Illustration("contact", lambda s: maps.contact(s.result), _classes, FRONT, HALF),
    Illustration("gap", lambda s: maps.gap(s.result), _gap, width=HALF),
    Illustration(
        "histogram",
        lambda s: sections.pressure_histogram(s.result),
        "Contact area over pressure. The area at the ceiling has no width on this axis: see the "
        "label.",
        FILES,
        HALF,
    ),
    _closely("most_loaded", RESULTS, lambda s: s.is_crowded),
    Illustration(
        "",
        lambda s: sections.section(s.result, s.around_peak if s.is_part(s.around_peak) else None),
        _sections,
        width=WIDE,
        when=lambda s: s.result.load > 0,
    ),
)
"""Figures of a `ContactResult`."""


# The volume model


def _contact_figure(name: str) -> Illustration:
    """Return a figure of the contact for the volume model."""
    return _nested_figure("contact", _in_contact(name))


def _pressure_figure(name: str) -> Illustration:
    """Return a figure of the pressure, under the largest load if unloaded in the end."""
    entry = _nested_figure("loaded_contact", _in_contact(name))

    def caption(scene: VolumeScene) -> str:
        gone = "" if scene.loaded else " This was the largest load; the body is now unloaded."
        return f"{entry.text(scene)}{gone}"

    return replace(entry, caption=caption, when=lambda scene: scene.known)


def _in_contact(name: str) -> Illustration:
    return next(entry for entry in CONTACT if entry.name == name)


def _displacement(scene: VolumeScene) -> str:
    text = "Residual displacement adds to the gap. Red: down. Blue: up."
    return f"{text} The line is the contact edge." if scene.loaded else text


def _section_figure(along: str) -> Illustration:
    title = f"Section along {along} through the largest plastic strain"
    return Illustration(
        f"section-{along}",
        lambda scene: elastoplastic.section(
            scene.result, along, body=scene.body, width=scene.width
        ),
        lambda scene: (
            f"{title}{scene.where}, true to scale. The gray line bounds the plastic zone; the "
            "cross marks the largest plastic strain. Material yields where the stress over the "
            "yield strength is 1."
        ),
        FILES,
        WIDE,
    )


_CUT = _section_figure("x")

SECTION = replace(_CUT, name="", chapter=FRONT, draw=lambda scene: _CUT.draw(scene.close()))
"""Section of an elastoplastic body, as a close-up if the plastic zone is small."""


VOLUME = (
    _contact_figure("surface"),
    SECTION,
    _pressure_figure("pressure"),
    Illustration(
        "displacement",
        lambda scene: elastoplastic.residual_displacement(scene.result),
        _displacement,
        width=HALF,
    ),
    replace(_contact_figure("gap"), chapter=FILES),
    _pressure_figure("histogram"),
    _CUT,
    _section_figure("y"),
    Illustration(
        "profile",
        lambda scene: elastoplastic.profile(scene.result, body=scene.body),
        "Below the largest plastic strain: the strain (left), von Mises stress and yield strength "
        "(middle), residual normal stresses (right). Steps are layers.",
        BODY,
        WIDE,
    ),
    Illustration(
        "layers",
        lambda scene: elastoplastic.layers(scene.result, scene.body),
        "Layer by layer: plastic share, largest strain, and largest stresses.",
        FILES,
        WIDE,
    ),
    Illustration(
        "path",
        lambda scene: elastoplastic.path(scene.result),
        "Approach, contact area, maximum pressure and maximum plastic strain from first contact. "
        "The ring is the state of this report.",
        width=WIDE,
        when=lambda scene: bool(scene.result.increments),
    ),
    Illustration(
        "convergence",
        lambda scene: elastoplastic.convergence(scene.result),
        "Residual of the plastic strain, increment by increment.",
        FILES,
    ),
)
"""Figures of an `ElastoplasticResult`."""


# Other results


def _trace(scene: MapScene) -> str:
    missing = " The line ends where points are missing." if scene.surface.missing else ""
    return f"Heights{scene.of} {scene.when}, exaggerated. Contact starts at the highest.{missing}"


def _profile_caption(scene: ContactScene) -> str:
    yields = ""
    if scene.result.saturated_fraction > 0:
        yields = " Dark red is at the ceiling."
    return (
        "Top: the profile before loading (gray), moved by the approach, and under load (blue), "
        f"heights exaggerated. Bottom: the pressure.{yields}"
    )


def _close(scene: ContactScene) -> str:
    width = format_engineering(scene.most_loaded.width, "m", 3)
    return f"{width} around the segment that carries most. Check that points resolve the contact."


PROFILE_MAP = Illustration("surface", lambda s: sections.heights(s.surface), _trace, FILES, WIDE)
"""Figures of a prepared profile."""

PROFILE_CONTACT = (
    _nested_figure("map", PROFILE_MAP),
    Illustration(
        "pressure", lambda s: sections.loaded_profile(s.result), _profile_caption, FRONT, WIDE
    ),
    Illustration(
        "contact",
        lambda s: sections.loaded_profile(s.result, s.most_loaded.width, s.most_loaded.middle[1]),
        _close,
        width=WIDE,
    ),
)
"""Figures of a `ContactResult` of profiles."""
