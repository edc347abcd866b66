"""The figures of reports on profiles."""

from __future__ import annotations

from roughcontact.plots import traces
from roughcontact.report.scenes import (
    PREPARATION,
    ContactScene,
    Illustration,
    Illustrations,
    MapScene,
)
from roughcontact.units import engineering


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


MAP: Illustrations = (
    Illustration(
        "surface",
        lambda s: traces.heights(s.surface),
        lambda s: f"Heights of the profile{s.of}, Rq {engineering(s.surface.Sq, 'm', 3)}.",
        _trace,
        PREPARATION,
    ),
)
"""Of a prepared profile."""

CONTACT: Illustrations = (
    Illustration(
        "surface",
        lambda s: traces.heights(s.result.surface),
        lambda s: MAP[0].words(s.map)[0],
        lambda s: MAP[0].words(s.map)[1],
        PREPARATION,
    ),
    Illustration(
        "pressure",
        lambda s: traces.pressed(s.result),
        "The profile before and under load, and its pressure; whole length.",
        _pressed,
    ),
    Illustration(
        "contact",
        lambda s: traces.pressed(s.result, s.most_loaded[1], s.most_loaded[0][1]),
        "The profile before and under load, and its pressure, around the most loaded segment.",
        _close,
    ),
)
"""Of a `ContactResult` of profiles."""

CURVE: Illustrations = (
    Illustration(
        "curve",
        traces.load_curve,
        "Four diagrams over the load: contact length, approach and gap, stiffness, segments.",
        "Contact and saturated length; approach and mean gap; stiffness; number of segments.",
    ),
)
"""Of a `LoadCurve` of profiles."""
