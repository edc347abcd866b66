"""The figures of the reports: how each is drawn, and what stands below it.

The names of the files that ``--figures`` writes come from here, too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from roughcontact.contact.pair import BODIES
from roughcontact.elastoplastic.result import ElastoplasticResult, profile
from roughcontact.plots import elastoplastic, maps, profiles, sections, subsurface_stress
from roughcontact.plots.conductance import conductance
from roughcontact.plots.interface_law import interface_law
from roughcontact.plots.load_curve import hysteresis, load_curve
from roughcontact.report import rolling_table
from roughcontact.report.figure_data import (
    ACCURACY as ACCURACY,
    BODY as BODY,
    PATH as PATH,
    PREPARATION as PREPARATION,
    RESULTS as RESULTS,
    ROUGHNESS as ROUGHNESS,
    SECTIONS as SECTIONS,
    SPOTS as SPOTS,
    ContactScene as ContactScene,
    Illustration as Illustration,
    Illustrations as Illustrations,
    MapScene as MapScene,
)
from roughcontact.report.kind import Kind
from roughcontact.units import engineering, percent

if TYPE_CHECKING:
    from matplotlib.figure import Figure


# Sections are drawn a second time around the largest plastic strain where the zone there is so
# small a part of the map, and then as wide as so many of its depths or pixels.
_SMALL_ZONE = 0.1
_AROUND_ZONE = 6.0
_CLOSE_ZONE_PIXELS = 24

_ENOUGH_SPOTS = 3


@dataclass(frozen=True)
class VolumeScene:
    """A contact with plasticity of the volume, and the body to look into."""

    result: ElastoplasticResult  # The result
    body: int = 0  # Which of its bodies
    width: float | None = None  # Width of the sections around the largest plastic strain [m]

    @property
    def contact(self) -> ContactScene:
        """The contact alone."""
        return ContactScene(self.result.solution)

    @property
    def pressed(self) -> ContactScene:
        """The contact in the end, or under the largest load where none is left; no gap of it."""
        load, pressure = self.result.largest
        solution = self.result.solution
        if self.loaded or not load:
            return self.contact
        return ContactScene(replace(solution, load=load, pressure=pressure))

    @property
    def known(self) -> bool:
        """Whether there is a pressure to draw."""
        return bool(self.result.largest[0])

    @property
    def loaded(self) -> bool:
        """Whether there is a load in the end."""
        return bool(self.result.solution.load)

    @property
    def where(self) -> str:
        """Which body, if there are two."""
        names = tuple(BODIES.values())
        return f" of the {names[self.body]}" if len(self.result.bodies) > 1 else ""

    def close(self) -> VolumeScene:
        """Return the scene around the largest plastic strain, if that is a small part of it."""
        zone = profile(self.result, body=self.body)
        plastic = np.flatnonzero(zone.accumulated)
        if not plastic.size:
            return self
        deep = float(zone.faces[plastic[-1] + 1])
        surface = self.result.solution.surface
        size = min(surface.size)
        width = max(_AROUND_ZONE * deep, _CLOSE_ZONE_PIXELS * max(surface.pixel))
        small = deep < _SMALL_ZONE * size and width < size
        return replace(self, width=width if small else None)


def _of(attribute: str, inner: Illustration) -> Illustration:
    """Return a figure of a scene within another one."""
    return _within(attrgetter(attribute), inner)


def _within(within: Callable[[Any], Any], inner: Illustration) -> Illustration:
    return replace(
        inner,
        draw=lambda scene: inner.draw(within(scene)),
        alt=lambda scene: inner.words(within(scene))[0],
        caption=lambda scene: inner.words(within(scene))[1],
        when=lambda scene: inner.when(within(scene)),
    )


# The maps


def _heights(scene: MapScene) -> str:
    missing = " Grey points are missing." if scene.surface.missing else ""
    return f"Heights{scene.of} {scene.when}. Light is high: contact begins there.{missing}"


MAP: Illustrations = (
    Illustration(
        "surface",
        lambda s: maps.surface(s.surface),
        lambda s: (
            f"Map of the heights{s.of}, root-mean-square height "
            f"{engineering(s.surface.Sq, 'm', 3)}."
        ),
        _heights,
        PREPARATION,
    ),
    Illustration(
        "",
        lambda s: sections.bearing_curve(s.surface),
        lambda s: f"Material ratio curve{s.of}.",
        lambda s: (
            f"Material ratio curve{s.of} (bearing curve): which share of the map lies above a "
            "height. Steep ends mean few high peaks or deep dales; contact begins at the left end."
        ),
        ROUGHNESS,
    ),
)
"""Of a prepared map."""


# The contact


def _classes(scene: ContactScene) -> str:
    result = scene.result
    limited = ", dark red is at the pressure ceiling" if result.ceiling is not None else ""
    return (
        f"Where the bodies touch. Blue touches elastically{limited}.{scene.missing} The shares are "
        "counted on all points."
    )


def _classes_alt(scene: ContactScene) -> str:
    touching, saturated = (
        percent(share) for share in (scene.result.contact_fraction, scene.result.saturated_fraction)
    )
    return f"Map of the contact: {touching} of the map touches, {saturated} is saturated."


def _gap(scene: ContactScene) -> str:
    state = "" if scene.result.load else ", which just touch"
    return (
        f"Gap that is left between the bodies{state}. Orange is closed; the darker the blue, the "
        f"wider the gap: this is the room left for a fluid or for wear debris.{scene.missing}"
    )


def _spread(scene: ContactScene) -> str:
    return "How the contact area is spread over the pressure. " + (
        "The share at the ceiling has no width on this axis and is stated instead of drawn."
        if scene.result.saturated_fraction > 0
        else "What lies beyond the axis is stated below it."
    )


def _close_up(scene: ContactScene) -> str:
    about = engineering(scene.most_loaded[1], "m", 3)
    return (
        f"A part of the maps of pressure and contact, {about} wide, around the spot that carries "
        "most. It shows whether the pixels of the map resolve the contact."
    )


_SECTIONS_ALT = (
    "Sections along x and y through the highest peak: heights before and under load, pressure"
)


def _sections(scene: ContactScene) -> str:
    result = scene.result
    what = "profile" if result.counter_surface is None else "sum of both profiles"
    text = (
        f"Above: the {what} before loading (grey), moved as a whole by the approach, and under "
        "load (blue), against the counter-body at zero height. What is grey above zero had to give "
        "way. Below: the pressure on the same line. Heights are exaggerated; the dotted line marks "
        "the highest peak."
    )
    if result.saturated_fraction > 0:
        text += " Dark red is saturated: that much material has to flow away."
    return text


CONTACT: Illustrations = (
    _of("map", MAP[0]),
    Illustration(
        "pressure",
        lambda s: maps.pressure(s.result),
        lambda s: (
            f"Map of the contact pressure, largest {engineering(s.result.max_pressure, 'Pa', 3)}."
        ),
        "Contact pressure: the darker, the higher; the lightest ground is not in contact. Black, "
        "where it occurs, is beyond the scale.",
    ),
    Illustration("contact", lambda s: maps.contact(s.result), _classes_alt, _classes),
    Illustration(
        "",
        lambda s: maps.close_up(s.result, *s.most_loaded),
        lambda s: (
            f"Pressure and contact in a part of {engineering(s.most_loaded[1], 'm', 3)} around "
            "the most loaded spot."
        ),
        _close_up,
        when=lambda s: s.is_part(s.most_loaded[1]),
    ),
    Illustration(
        "gap",
        lambda s: maps.gap(s.result),
        lambda s: f"Map of the open gap, mean {engineering(s.result.mean_gap, 'm', 3)}.",
        _gap,
    ),
    Illustration(
        "histogram",
        lambda s: sections.pressure_histogram(s.result),
        "Histogram of the contact pressure over the contact area.",
        _spread,
    ),
    Illustration(
        "",
        lambda s: sections.section(s.result),
        f"{_SECTIONS_ALT}; whole length.",
        _sections,
        SECTIONS,
    ),
    Illustration(
        "",
        lambda s: sections.section(s.result, s.around_peak),
        lambda s: f"{_SECTIONS_ALT}; {engineering(s.around_peak, 'm', 3)} around the peak.",
        lambda s: f"The same sections, {engineering(s.around_peak, 'm', 3)} around the peak.",
        SECTIONS,
        when=lambda s: s.is_part(s.around_peak),
    ),
    Illustration(
        "",
        lambda s: maps.spots(s.result),
        lambda s: f"Number of contact spots of at least a given area; {s.spots.count} in all.",
        "How many spots have at least a given area, both axes logarithmic. On the shaded ground "
        "spots have so few pixels that the grid decides on their size.",
        SPOTS,
        when=lambda s: s.spots.count >= _ENOUGH_SPOTS,
    ),
)
"""Of a `ContactResult`."""


# The volume model


def _of_contact(name: str) -> Illustration:
    """Return a figure of the contact as one of the volume model."""
    return _of("contact", _in_contact(name))


def _of_pressure(name: str) -> Illustration:
    """Return a figure of the pressure, under the largest load where there is none in the end."""
    entry = _of("pressed", _in_contact(name))

    def words(scene: VolumeScene) -> tuple[str, str]:
        alt, caption = entry.words(scene)
        if scene.loaded:
            return alt, caption
        load = engineering(scene.pressed.result.load, "N", 3)
        under = f"Under the largest load of the path, {load}, which is gone"
        return f"{under}: {alt}", f"{under}. {caption}"

    return replace(
        entry,
        alt=lambda scene: words(scene)[0],
        caption=lambda scene: words(scene)[1],
        when=lambda scene: scene.known,
    )


def _in_contact(name: str) -> Illustration:
    return next(entry for entry in CONTACT if entry.name == name)


def _displacement(scene: VolumeScene) -> str:
    text = "What plastic strain adds to the gap: red is pressed in, blue is raised."
    if scene.loaded:
        text += (
            " It stays when the load is gone, unless the bodies flow again on unloading. The line "
            "is the edge of the contact."
        )
    return text


def _cut(along: str) -> Illustration:
    title = f"Section along {along} through the largest plastic strain"

    def caption(scene: VolumeScene) -> str:
        cell = "each cell is one layer of one pixel" if scene.loaded else "each cell a layer"
        text = (
            f"{title}{scene.where}. True to scale, {cell}; the plastic zone lies inside the grey "
            "line, the cross marks the largest plastic strain of the section."
        )
        if scene.loaded:
            text += " Where the stress over the yield strength is 1 the material flows."
        return text

    return Illustration(
        f"section-{along}",
        lambda scene: elastoplastic.section(
            scene.result, along, body=scene.body, width=scene.width
        ),
        f"{title}: strain, stress under load, residual stress.",
        caption,
        BODY,
    )


def _dent(scene: VolumeScene) -> str:
    deepest = engineering(float(scene.result.residual_displacement.max()), "m")
    return f"Map of the residual displacement, up to {deepest}."


VOLUME: Illustrations = (
    _of_contact("surface"),
    _of_pressure("pressure"),
    Illustration(
        "displacement",
        lambda scene: elastoplastic.residual_displacement(scene.result),
        _dent,
        _displacement,
    ),
    _of_contact("gap"),
    _of_pressure("histogram"),
    _cut("x"),
    _cut("y"),
    Illustration(
        "profile",
        lambda scene: elastoplastic.profile(scene.result, body=scene.body),
        "Profiles with depth below the largest plastic strain.",
        "Below the point of the largest plastic strain: the strain; the von Mises stress and the "
        "yield strength at this strain; the normal stresses by the plastic strain alone. Steps are "
        "layers.",
        BODY,
    ),
    Illustration(
        "layers",
        lambda scene: elastoplastic.layers(scene.result, scene.body),
        "Largest values of each layer over the depth.",
        "Layer by layer: how much of it has plastic strain, its largest strain, and its largest "
        "stresses, wherever they are.",
        BODY,
    ),
    Illustration(
        "path",
        lambda scene: elastoplastic.path(scene.result),
        "Four diagrams over the load: approach, contact area, pressure, plastic strain.",
        "Approach, contact area, largest pressure and largest plastic strain, from the first touch "
        "on. The ring is the state that this report is on.",
        PATH,
    ),
    Illustration(
        "convergence",
        lambda scene: elastoplastic.convergence(scene.result),
        "Residual of the plastic strain over the iterations",
        "How the plastic strain settled, increment by increment. Attempts that were given up for a "
        "smaller step or a larger volume are not shown.",
        ACCURACY,
    ),
)
"""Of an `ElastoplasticResult`."""

ROLLING: Illustrations = (
    *rolling_table.FIGURES,
    *(_within(lambda rolling: VolumeScene(rolling.result), entry) for entry in VOLUME),
)
"""Of a `RollingResult`."""


# Other results


def _plain(name: str, draw: Callable[[Any], Figure], caption: str) -> Illustration:
    return Illustration(name, draw, caption, caption)


STRESS: Illustrations = (
    _plain(
        "stress-depth", subsurface_stress.stress_depth, "Largest equivalent stresses at each depth."
    ),
    _plain(
        "stress-section",
        subsurface_stress.stress_section,
        "Von Mises stress on a plane along x through its maximum, which the cross marks: the part "
        "around it where it is strong, true to scale.",
    ),
    _plain(
        "stress-map",
        subsurface_stress.stress_map,
        "Largest von Mises stress over all depths, from above; the cross marks the largest of all.",
    ),
)
"""Of a `StressResult`."""

HISTORY: Illustrations = (
    Illustration(
        "history",
        hysteresis,
        "Load over approach along the path; energy dissipated and volume indented, step by step.",
        "Above: load over approach. The dots are computed; lines join those that lie on one curve, "
        "straight for want of dots between them, so that the area they enclose is no measure of "
        "the energy. Below: what each step dissipates, and the volume indented so far.",
    ),
)
"""Of a `LoadHistory`."""

PRESSED: Illustrations = tuple(
    entry for entry in CONTACT if entry.chapter == RESULTS and entry.name not in ("surface", "gap")
)
"""Of the contact at a stage of a `LoadHistory`; its heights and gap are of bodies on the way."""

CURVE: Illustrations = (
    Illustration(
        "curve",
        load_curve,
        "Four diagrams over the load: areas, approach and gap, stiffness, number of spots.",
        "Contact and saturated area beside Persson's theory; approach and mean gap; stiffness; "
        "number of spots. Stiffness is what the next small load meets: saturated points carry no "
        "more of it.",
    ),
)
"""Of a `LoadCurve`."""

CONDUCTANCE: Illustrations = (
    Illustration(
        "conductance",
        conductance,
        "Resistance of the contact over the load, beside two estimates.",
        "Resistance over load. Greenwood's formula takes each spot for a circle; the correlation "
        "(Cooper, Mikic and Yovanovich under a ceiling, Mikic without) knows roughness, slope and "
        "nominal pressure alone, of a surface that is flat and large.",
    ),
)
"""Of a `Conductance`."""

LAW: Illustrations = (
    Illustration(
        "law",
        interface_law,
        "Four diagrams of the law: pressure over separation, areas, stiffness and gap.",
        "Pressure over the separation of the mean planes, contact and saturated area, stiffness, "
        "and separation with mean gap. Thick lines are means of the maps, thin ones single maps; "
        "Persson's theory of the elastic joint is dashed. Grey: pressures that the maps do not "
        "resolve.",
    ),
)
"""Of an `InterfaceLaw`."""


def names(table: Illustrations) -> tuple[str, ...]:
    """Return the names of the figures that are written to files."""
    return tuple(entry.name for entry in table if entry.name)


def drawings(kind: Kind, result: Any) -> dict[str, Callable[[], Figure]]:
    """Return what draws the figures of a result that are written to files, by name."""
    scene = kind.scene(result)
    return {entry.name: _later(entry, scene) for entry in kind.figures if entry.name}


def _later(entry: Illustration, scene: Any) -> Callable[[], Figure]:
    return lambda: entry.draw(scene)


def drawn(table: Illustrations, result: Any) -> tuple[tuple[str, Figure], ...]:
    """Return captions with their figures."""
    return tuple((entry.words(result)[1], entry.draw(result)) for entry in table)


# --- The figures of reports on profiles ---


def _trace(scene: MapScene) -> str:
    missing = " Where points are missing the line ends." if scene.surface.missing else ""
    return f"Heights{scene.of} {scene.when}, exaggerated. Contact begins at the highest.{missing}"


def _pressed(scene: ContactScene) -> str:
    result = scene.result
    text = (
        "Above: the profile before loading (grey), moved as a whole by the approach, and under "
        "load (blue), against the counter-body at zero height. Below: the pressure on it. Heights "
        "are exaggerated."
    )
    if result.saturated_fraction > 0:
        text += " Dark red is at the pressure ceiling: that much material has to flow away."
    return text


def _close(scene: ContactScene) -> str:
    width = engineering(scene.most_loaded[1], "m", 3)
    return (
        f"The same in {width} around the segment that carries most. It shows whether the points "
        "resolve the contact."
    )


PROFILE_MAP: Illustrations = (
    Illustration(
        "surface",
        lambda s: profiles.heights(s.surface),
        lambda s: f"Heights of the profile{s.of}, Rq {engineering(s.surface.Sq, 'm', 3)}.",
        _trace,
        PREPARATION,
    ),
)
"""Of a prepared profile."""

PROFILE_CONTACT: Illustrations = (
    Illustration(
        "surface",
        lambda s: profiles.heights(s.result.surface),
        lambda s: PROFILE_MAP[0].words(s.map)[0],
        lambda s: PROFILE_MAP[0].words(s.map)[1],
        PREPARATION,
    ),
    Illustration(
        "pressure",
        lambda s: profiles.pressed(s.result),
        "The profile before and under load, and its pressure; whole length.",
        _pressed,
    ),
    Illustration(
        "contact",
        lambda s: profiles.pressed(s.result, s.most_loaded[1], s.most_loaded[0][1]),
        "The profile before and under load, and its pressure, around the most loaded segment.",
        _close,
    ),
)
"""Of a `ContactResult` of profiles."""

PROFILE_CURVE: Illustrations = (
    Illustration(
        "curve",
        profiles.load_curve,
        "Four diagrams over the load: contact length, approach and gap, stiffness, segments.",
        "Contact and saturated length; approach and mean gap; stiffness; number of segments.",
    ),
)
"""Of a `LoadCurve` of profiles."""
