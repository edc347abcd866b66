"""The maps of a surface or a result by name, each with its unit."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.contact.result import ContactResult
from roughcontact.surface.surface import Surface
from roughcontact.volume.result import ElastoplasticResult

Result = ContactResult | ElastoplasticResult

UNITS = {
    "height": "m",
    "counter_height": "m",
    "initial_gap": "m",
    "pressure": "Pa",
    "gap": "m",
    "contact": "1",
    "saturated": "1",
    "residual_indentation": "m",
    "ceiling": "Pa",
    "residual_displacement": "m",
}
"""Every map that a result may have, with its unit."""

# Those that only one of the two models has.
_CEILING_ONLY = {"saturated", "residual_indentation", "ceiling"}
_VOLUME_ONLY = {"residual_displacement"}


def surface_of(source: Surface | Result) -> Surface:
    """Return the map itself, or that of the rough body of a result."""
    if isinstance(source, ElastoplasticResult):
        return source.solution.surface
    return source if isinstance(source, Surface) else source.surface


def names(source: Surface | Result) -> list[str]:
    """Return which maps there are."""
    if isinstance(source, Surface):
        return ["height"]
    if isinstance(source, ElastoplasticResult):
        pressed, absent = source.solution, set(_CEILING_ONLY)
    else:
        pressed, absent = source, set(_VOLUME_ONLY)
    if pressed.counter_surface is None:
        absent.add("counter_height")
    if not isinstance(pressed.ceiling, np.ndarray):
        absent.add("ceiling")
    return [name for name in UNITS if name not in absent]


def values(source: Surface | Result, name: str) -> NDArray[Any]:
    """Return one of the maps that `names` lists, in the unit of `UNITS`."""
    if isinstance(source, Surface):
        return source.heights
    if isinstance(source, ElastoplasticResult):
        if name in _VOLUME_ONLY:
            return source.residual_displacement
        return values(source.solution, name)
    if name == "height":
        return source.surface.heights
    if name == "counter_height" and source.counter_surface is not None:
        return source.counter_surface.heights
    found: NDArray[Any] = getattr(source, name)
    return found
