"""How deep and how wide the volume is in which bodies may yield."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact.errors import InputError
from roughcontact.halfspace.layers import graded_layers
from roughcontact.material.material import Material
from roughcontact.volume.contact_solver import ContactSolver
from roughcontact.volume.plastic_body import GUARD
from roughcontact.volume.problem import Problem
from roughcontact.volume.result import ElastoplasticResult

LAYER_RATIO = 1.08
"""Thickness of a layer over that of the one above."""

LEAST_LAYERS = 10
"""No volume has fewer layers unless they are given."""

# Layers: the first over the shorter edge of a pixel, the depth of them all over the radius of the
# largest contact spot, and in pixels at least.
_FIRST_LAYER = 0.5
_DEPTH = 3.0
_LEAST_DEPTH = 8.0
# Depth of the layers over that before, when plastic strain has reached the lowest; growth of the
# volume to each side when it has reached the edge, over the edge of the map.
_DEEPER = 1.3
_WIDER = 0.1
# Distance of the edge of the volume from the contact, over the radius of the largest spot.
_SPAN = 0.8


class Extent(NamedTuple):
    """The layers of the volume, and how far it goes beyond the map.

    Parameters
    ----------
    thickness : ndarray, shape (nz,)
        Thickness of each layer [m].
    margin : int
        Rows and columns beyond each edge of the map.
    """

    thickness: NDArray[np.float64]
    margin: int

    @classmethod
    def of(cls, result: ElastoplasticResult) -> Extent:
        """Return that of a result."""
        body = result.bodies[0]
        return cls(body.thickness, body.margin)

    def grid(self, shape: tuple[int, int]) -> tuple[int, int]:
        """Return the points of a layer over a map of some shape."""
        return shape[0] + 2 * self.margin, shape[1] + 2 * self.margin

    def grown(
        self, shape: tuple[int, int], pixel: tuple[float, float], *, deeper: bool, wider: bool
    ) -> Extent:
        """Return a larger one over a map, as far as it may still become deeper or wider."""
        thickness, margin = list(self.thickness), self.margin
        (ny, nx), (dy, dx) = self.grid(shape), pixel
        if deeper:
            depth = min(_DEEPER * sum(thickness), 2 * max(ny * dy, nx * dx))
            while sum(thickness) < depth:
                thickness.append(thickness[-1] * LAYER_RATIO)
        if wider and 4 * margin < max(ny, nx):
            margin += max(GUARD, math.ceil(_WIDER * min(ny, nx)))
        return Extent(np.array(thickness), margin)


def first_extent(
    problem: Problem,
    solver: ContactSolver,
    load: float,
    depth: float | None,
    layers: ArrayLike | None,
) -> Extent:
    """Return the volume for loads up to this one."""
    pixel = problem.pair.pixel
    weaker = problem.pair.softer
    radius, margin = _spots(solver, load, weaker, pixel)
    margin = margin if problem.pair.boundary.free_axes else 0
    if layers is None:
        if depth is None:
            depth = max(_DEPTH * radius, _LEAST_DEPTH * max(pixel))
        return Extent(graded_layers(_FIRST_LAYER * min(pixel), depth, LAYER_RATIO), margin)
    thickness = np.array(layers, float)
    if thickness.sum() < radius:
        raise InputError(
            f"reach {thickness.sum():.4g} m deep, less than the radius {radius:.4g} m of "
            "the largest contact spot: plastic strain would go deeper; let them reach "
            f"{_DEPTH * radius:.4g} m, or leave them out",
            argument="layers",
        )
    return Extent(thickness, margin)


def _spots(
    solver: ContactSolver, load: float, body: Material | None, pixel: tuple[float, float]
) -> tuple[float, int]:
    """Return the radius of the largest contact spot [m] and the margin that its volume needs.

    The contact is that under a ceiling of three yield strengths.
    """
    from scipy import ndimage

    pressed = solver.pressed(load, (body.yield_strength or math.inf) if body else math.inf)
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
