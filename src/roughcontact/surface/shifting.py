"""Surfaces that have moved over their grid."""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from roughcontact.errors import InputError
from roughcontact.surface import nominal
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface
from roughcontact.units import lengths

Array = NDArray[np.float64]

# Share of a pixel within which a way counts as a whole number of them.
_WHOLE = 1e-6


def shifted(
    surface: Surface, way: tuple[float, float], periodic_axes: tuple[int, ...] = ()
) -> Surface:
    """Return a surface that has moved over its grid.

    Parameters
    ----------
    surface : Surface
        The surface.
    way : (float, float)
        How far along ``(y, x)`` [m].
    periodic_axes : tuple of int
        Axes along which what goes out at one edge comes in at the other. Along the others a
        measured map ends: what comes in is unknown, and never touches; a nominal body goes on.

    Returns
    -------
    Surface
        Moved by whole pixels heights keep their bits. By parts of them nominal bodies are made anew
        at their place, and others are interpolated by cubic splines; those need heights
        everywhere.

    Raises
    ------
    InputError
        If a map with holes is to move by parts of a pixel.
    """
    pixels = [part / edge for part, edge in zip(way, surface.pixel, strict=True)]
    whole = [round(part) for part in pixels]
    rest = [
        part - n if abs(part - n) > _WHOLE else 0.0 for part, n in zip(pixels, whole, strict=True)
    ]
    if _is_nominal(surface):
        for axis in {0, 1} - set(periodic_axes):
            whole[axis], rest[axis] = 0, pixels[axis]
    if any(rest):
        heights = _by_parts(surface, rest, periodic_axes)
    else:
        heights = surface.heights
    for axis, count in enumerate(whole):
        heights = _rolled(heights, count, axis, periodic=axis in periodic_axes)
    step = f"moved by {lengths(way)} along y and x"
    about = Provenance(surface.provenance.source, steps=(*surface.provenance.steps, step))
    masked = surface.holes_masked or bool(np.isnan(heights).any() and not surface.missing)
    return Surface(heights, surface.pixel, about, holes_masked=masked)


def _is_nominal(surface: Surface) -> bool:
    """Return whether a surface is a form that can be made anew at another place."""
    made = surface.provenance.origin
    nominally = made is not None and made.method.startswith("nominal.")
    return nominally and not surface.provenance.operations


def _by_parts(surface: Surface, rest: list[float], periodic_axes: tuple[int, ...]) -> Array:
    """Return heights moved by parts of a pixel, or a nominal body moved."""
    made = surface.provenance.origin
    if made is not None and _is_nominal(surface):
        again: dict[str, Any] = dict(made.arguments)
        middle = [(n - 1) / 2 for n in surface.shape]
        center = again.pop("center", None) or middle
        again["center"] = tuple(c + part for c, part in zip(center, rest, strict=True))
        body = getattr(nominal, made.method.removeprefix("nominal."))
        heights: Array = body(**again).heights
        return heights
    if surface.missing:
        raise InputError(
            f"has {surface.missing} missing points, between which nothing can be interpolated: "
            "fill them, or move by whole pixels",
            argument="surface",
        )
    from scipy import ndimage

    heights = surface.heights
    for axis, part in enumerate(rest):
        if not part:
            continue
        periodic = axis in periodic_axes
        way = (part, 0.0) if axis == 0 else (0.0, part)
        mode: Literal["grid-wrap", "reflect"] = "grid-wrap" if periodic else "reflect"
        heights = ndimage.shift(heights, way, order=3, mode=mode)
        if not periodic:
            # What the edge mirrors is not known.
            edge = [slice(None)] * 2
            edge[axis] = slice(0, 1) if part > 0 else slice(-1, None)
            heights[tuple(edge)] = math.nan
    return heights


def _rolled(heights: Array, count: int, axis: int, *, periodic: bool) -> Array:
    """Return heights moved along an axis by whole pixels."""
    moved: Array = np.roll(heights, count, axis)
    if not periodic and count:
        outside = [slice(None)] * 2
        outside[axis] = slice(0, count) if count > 0 else slice(count, None)
        moved[tuple(outside)] = math.nan
    return moved
