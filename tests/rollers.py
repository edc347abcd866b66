"""Rollers on a flat that yields, for the tests of what rolls."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

import roughcontact as rc
from roughcontact.material.hardening import Hardening
from roughcontact.surface import nominal_bodies

STRENGTH, YOUNG, POISSON = 1e9, 210e9, 0.3
SHEAR = STRENGTH / math.sqrt(3)
PIXEL = (1e-6, 1e-6)


class Line:
    """A roller on a flat, one period of a row of rollers.

    Parameters
    ----------
    peak : float
        Hertz pressure over the shear strength k.
    half_width : int
        Of the contact, in pixels.
    """

    def __init__(
        self, peak: float, half_width: int = 7, points: int = 64, law: Hardening | None = None
    ) -> None:
        shape, pressure, width = (8, points), peak * SHEAR, half_width * PIXEL[1]
        modulus = YOUNG / (1 - POISSON**2)
        radius = width * modulus / (2 * pressure)
        self.load = math.pi / 2 * width * pressure * shape[0] * PIXEL[0]
        self.points, self.width = points, width
        self.steel = rc.Material(YOUNG, POISSON, None if law else STRENGTH, hardening=law)
        self.flat = rc.Surface(np.zeros(shape), PIXEL)
        self.roller = nominal_bodies.cylinder(radius=radius, angle=90.0, shape=shape, pixel=PIXEL)
        self.layers = np.full(16, 3 * width / 16)

    def point_at(self, x: float, friction: float = 0.0, direction: float = 0.0) -> rc.PathPoint:
        """Return the point with the roller moved by ``x`` pixels."""
        return rc.PathPoint(self.load, (0.0, x * PIXEL[1]), friction, direction)

    def solve_path(
        self,
        path: Sequence[rc.PathPoint],
        start: rc.ElastoplasticResult | None = None,
        precision: str = "double",
        tolerance: float = 1e-4,
        folder: Path | None = None,
    ) -> rc.ElastoplasticResult:
        return rc.solve_elastoplastic(
            self.flat,
            material=self.steel,
            counter_surface=self.roller,
            path=path,
            boundary="periodic",
            precision=precision,
            tolerance=tolerance,
            start=start,
            layers=None if start else self.layers,
            folder=folder,
        )

    def passes(self, count: int, stride: int = 2, friction: float = 0.0) -> list[float]:
        """Return by how much the largest accumulated strain has grown in each of some passes."""
        result, strains = None, [0.0]
        for _ in range(count):
            path = [self.point_at(x, friction) for x in range(0, self.points, stride)]
            result = self.solve_path(path, result, "single", 1e-3)
            strains.append(result.max_plastic_strain)
        return np.diff(strains).tolist()
