"""Time and peak memory of the stress below a Hertz contact and a rough one."""

from __future__ import annotations

import time

import numpy as np
import scipy.fft

import roughcontact as rc
from roughcontact.halfspace import stress_summary

STEEL = rc.Material(young=210e9, poisson=0.3)


def hertz(points):
    """Hertz pressure on a fifth of the width, pixels of 1."""
    y, x = np.mgrid[:points, :points] - (points - 1) / 2
    return np.sqrt(np.maximum(1 - (y**2 + x**2) / (0.2 * points) ** 2, 0))


def pair_seconds(points):
    """T_pair: one plain padded rfft2 and irfft2 of SciPy on two threads."""
    padded = np.zeros((2 * points, 2 * points))
    padded[:points, :points] = hertz(points)
    times = []
    for _ in range(5):
        began = time.perf_counter()
        scipy.fft.irfft2(scipy.fft.rfft2(padded, workers=2), workers=2)
        times.append(time.perf_counter() - began)
    return float(np.median(times))


class Summary:
    """32 depths, six components reduced to von Mises, Tresca and shear amplitudes."""

    params = ([512, 1024], ["free", "periodic"], [0.0, 0.2])
    param_names = ("points", "boundary", "friction")
    timeout = 300

    def setup(self, points, boundary, friction):
        self.pressure = hertz(points)
        self.depths = np.concatenate([[0], np.geomspace(0.5, 0.6 * points, 31)])

    def time_summary(self, points, boundary, friction):
        stress_summary.summarize(
            self.pressure, (1.0, 1.0), 0.3, depths=self.depths, boundary=boundary, friction=friction
        )

    def peakmem_summary(self, points, boundary, friction):
        self.time_summary(points, boundary, friction)

    def track_pairs(self, points, boundary, friction):
        """Time in units of T_pair, both measured here."""
        before = pair_seconds(points)
        began = time.perf_counter()
        self.time_summary(points, boundary, friction)
        seconds = time.perf_counter() - began
        return 2 * seconds / (before + pair_seconds(points))


class Rough:
    """The contact of R(N) with automatic depths."""

    params = ([512, 1024],)
    param_names = ("points",)
    timeout = 300

    def setup(self, points):
        heights, self.pixel = rc.reference_map(points)
        surface = rc.Surface(heights, self.pixel)
        self.pressure = rc.solve(surface, load=1.0, material=STEEL, ceiling=None).pressure

    def time_summary(self, points):
        stress_summary.summarize(self.pressure, self.pixel, 0.3)
