"""Time and peak memory of one solve; run by ``asv run`` in the folder ``benchmarks``."""

from __future__ import annotations

import numpy as np

import roughcontact as rc
from roughcontact.halfspace import convolution
from roughcontact.surface.shapes import paraboloid

STEEL = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)


def rough(points: int, ceiling: float | None, boundary: str, precision: str) -> rc.ContactResult:
    """Solve R(points)."""
    heights, pixel = rc.reference_map(points)
    return rc.solve(
        rc.Surface(heights, pixel),
        load=1.0,
        material=STEEL,
        ceiling=ceiling,
        boundary=boundary,
        precision=precision,
    )


class Rough:
    """R(N) over size, boundary, ceiling and precision."""

    params = (
        [256, 512, 1024, 2048],
        ["free", "periodic", "periodic-x"],
        [3e9, None],
        ["double", "single"],
    )
    param_names = ("points", "boundary", "ceiling", "precision")
    timeout = 600

    def setup(self, points, boundary, ceiling, precision):
        heights, pixel = rc.reference_map(points)
        self.surface = rc.Surface(heights, pixel)

    def time_solve(self, points, boundary, ceiling, precision):
        rc.solve(
            self.surface,
            load=1.0,
            material=STEEL,
            ceiling=ceiling,
            boundary=boundary,
            precision=precision,
        )

    def peakmem_solve(self, points, boundary, ceiling, precision):
        self.time_solve(points, boundary, ceiling, precision)

    def track_convolutions(self, points, boundary, ceiling, precision):
        return rough(points, ceiling, boundary, precision).convolutions


class Hertz:
    """A sphere whose contact covers a fifth of the map."""

    params = ([512, 1024, 2048],)
    param_names = ("points",)

    def setup(self, points):
        side, radius = 1e-4, 1e-2
        pixel = (side / points, side / points)
        self.surface = rc.Surface(paraboloid((points, points), pixel, radius), pixel)
        contact_radius = side * np.sqrt(0.2 / np.pi)
        modulus = rc.contact_modulus(STEEL, rc.RIGID)
        self.load = 4 * modulus * contact_radius**3 / (3 * radius)

    def time_solve(self, points):
        rc.solve(self.surface, load=self.load, material=STEEL, ceiling=None)

    def peakmem_solve(self, points):
        self.time_solve(points)

    def track_convolutions(self, points):
        return rc.solve(self.surface, load=self.load, material=STEEL, ceiling=None).convolutions


class Operator:
    """One application of the free-space operator, and its preparation."""

    params = ([512, 1024, 2048],)
    param_names = ("points",)

    def setup(self, points):
        self.operator = convolution.free((points, points), (1e-7, 1e-7), 2e11)
        self.pressure = np.random.default_rng(0).random((points, points))

    def time_apply(self, points):
        self.operator(self.pressure)

    def time_prepare(self, points):
        convolution.free((points, points), (1e-7, 1e-7), 2e11)
