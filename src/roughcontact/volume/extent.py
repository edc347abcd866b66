"""How deep and how wide the volume is in which bodies may yield."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact.errors import InputError
from roughcontact.halfspace.layers import graded_layers
from roughcontact.material.material import Material, softer
from roughcontact.volume.contact_solver import ContactSolver
from roughcontact.volume.problem import Problem

LAYER_RATIO = 1.08
"""Thickness of a layer over that of the one above."""

# Layers: the first over the shorter edge of a pixel, the depth of them all over the radius of the
# largest contact spot, and in pixels at least.
_FIRST_LAYER = 0.5
_DEPTH = 3.0
_LEAST_DEPTH = 8.0
# Distance of the edge of the volume from the contact, over the radius of the largest spot.
_SPAN = 0.8


def first_volume(
    problem: Problem,
    contact: ContactSolver,
    load: float,
    depth: float | None,
    layers: ArrayLike | None,
) -> tuple[NDArray[np.float64], int]:
    """Return the thickness of the layers [m] and the margin for loads up to this one."""
    pixel = problem.surface.pixel
    weaker = softer(problem.material, problem.counter_material)
    radius, margin = _spots(contact, load, weaker, pixel)
    margin = margin if problem.boundary.free_axes else 0
    if layers is None:
        if depth is None:
            depth = max(_DEPTH * radius, _LEAST_DEPTH * max(pixel))
        return graded_layers(_FIRST_LAYER * min(pixel), depth, LAYER_RATIO), margin
    thickness = np.array(layers, float)
    if thickness.sum() < radius:
        raise InputError(
            f"reach {thickness.sum():.4g} m deep, less than the radius {radius:.4g} m of "
            "the largest contact spot: plastic strain would pass through them; reach "
            f"{_DEPTH * radius:.4g} m, or leave them out",
            argument="layers",
        )
    return thickness, margin


def _spots(
    contact: ContactSolver, load: float, body: Material | None, pixel: tuple[float, float]
) -> tuple[float, int]:
    """Return the radius of the largest contact spot [m] and the margin that its volume wants.

    The contact is that under a ceiling of three yield strengths.
    """
    from scipy import ndimage

    pressed = contact.pressed(load, (body.yield_strength or math.inf) if body else math.inf)
    spots, number = ndimage.label(pressed, np.ones((3, 3)))
    largest = int(np.bincount(spots.ravel())[1:].max()) if number else 0
    radius = math.sqrt(largest * pixel[0] * pixel[1] / math.pi)
    margin = 0
    for axis, edge in enumerate(pixel):
        lines = np.flatnonzero(pressed.any(axis=1 - axis))
        if lines.size:
            near = min(int(lines[0]), pressed.shape[axis] - 1 - int(lines[-1]))
            margin = max(margin, math.ceil(_SPAN * radius / edge) - near)
    return radius, margin
