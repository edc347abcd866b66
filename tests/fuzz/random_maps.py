"""Random maps, and holes in them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Maps, of height and length about one in units of their pixels ------------------------------------


def _self_affine(rng: np.random.Generator, y: Array, x: Array) -> Array:
    """Power-law spectrum, by a transform of white noise: down to the pixel, any aspect."""
    ny, nx = y.shape
    edges = (y[1, 0] - y[0, 0], x[0, 1] - x[0, 0])
    q = np.hypot(np.fft.fftfreq(ny, edges[0])[:, None], np.fft.rfftfreq(nx, edges[1]))
    shortest = 0.5 / max(edges)
    rolloff = shortest * rng.choice([0.02, 0.1, 0.5])
    cutoff = shortest * rng.choice([0.25, 1.0, math.inf])
    power = np.maximum(q, rolloff) ** -(1 + rng.choice([0.1, 0.5, 0.8, 1.0]))
    power[(q > max(cutoff, 2 * rolloff)) | (q == 0)] = 0
    if not power.any():
        power[:] = 1
    return np.fft.irfft2(np.fft.rfft2(rng.standard_normal((ny, nx))) * power, (ny, nx))


def _spikes(rng: np.random.Generator, y: Array, x: Array) -> Array:
    return np.where(rng.random(y.shape) < 0.02, rng.uniform(5, 50), 1.0) * rng.random(y.shape)


def _spike(rng: np.random.Generator, y: Array, x: Array) -> Array:
    heights = 1e-3 * rng.random(y.shape)
    heights[tuple(rng.integers(0, y.shape))] = 1.0
    return heights


def _punch(rng: np.random.Generator, y: Array, x: Array) -> Array:
    """A flat of any outline; nothing outside."""
    a, b = rng.uniform(0.1, 0.45, 2)
    v, u = y / max(np.ptp(y), 1e-9), x / max(np.ptp(x), 1e-9)
    inside = (
        (u / a) ** 2 + (v / b) ** 2 <= 1
        if rng.random() < 0.5
        else (np.abs(u) <= a) & (np.abs(v) <= b)
    )
    if not inside.any():
        inside[y.shape[0] // 2, y.shape[1] // 2] = True
    return np.where(inside, 0.0, np.nan)


def _honed(rng: np.random.Generator, y: Array, x: Array) -> Array:
    """A plateau with valleys: most points equally high."""
    heights = _self_affine(rng, y, x)
    return np.minimum(heights, np.quantile(heights, rng.uniform(0.1, 0.6)))


def _quantised(rng: np.random.Generator, y: Array, x: Array) -> Array:
    """Heights in steps of the instrument: ties everywhere."""
    heights = _self_affine(rng, y, x)
    step = np.ptp(heights) / rng.choice([3, 30, 1000])
    return np.round(heights / step) * step


def _dirty(rng: np.random.Generator, y: Array, x: Array) -> Array:
    """A rough map with a few particles, of some pixels, high above it."""
    heights = _self_affine(rng, y, x)
    heights /= heights.std()
    for _ in range(rng.integers(1, 5)):
        row, column = rng.integers(0, y.shape)
        extent = rng.integers(1, 4)
        heights[row : row + extent, column : column + extent] += 10 ** rng.uniform(0.5, 3)
    return heights


KINDS = {
    "self-affine": _self_affine,
    "white noise": lambda rng, y, x: rng.standard_normal(y.shape),
    "flat": lambda rng, y, x: np.zeros(y.shape),
    "checkerboard": lambda rng, y, x: (np.indices(y.shape).sum(0) % 2).astype(float),
    "terraces": lambda rng, y, x: np.floor(3 * rng.uniform(0.5, 2) * (x - x.min()) / np.ptp(x)),
    "spikes": _spikes,
    "one spike": _spike,
    "punch": _punch,
    "sphere": lambda rng, y, x: -(x**2 + y**2),
    "bowl": lambda rng, y, x: x**2 + 0.5 * y**2,
    "cone": lambda rng, y, x: -np.hypot(x, y),
    "waves": lambda rng, y, x: np.cos(2 * math.pi * rng.integers(1, 4) * x / (np.ptp(x) + 1)),
    "crossed waves": lambda rng, y, x: (
        np.cos(2 * math.pi * x / (np.ptp(x) + 1)) * np.cos(2 * math.pi * y / (np.ptp(y) + 1))
    ),
    "tilted": lambda rng, y, x: 0.05 * (x + 0.3 * y) + rng.standard_normal(y.shape),
    "honed": _honed,
    "quantised": _quantised,
    "dirty": _dirty,
}


def drawn_shape(rng: np.random.Generator, largest: int) -> tuple[int, int]:
    """Return grid points: a strip, a few points, or a map of any outline."""
    draw = rng.random()
    if draw < 0.1:
        # A strip: no coarse grid helps, everything is rim.
        shape = (int(rng.integers(2, 5)), int(rng.integers(2, 4 * largest)))
    elif draw < 0.2:
        shape = (int(rng.integers(2, 12)), int(rng.integers(2, 12)))
    else:
        ny, nx = np.exp(rng.uniform(math.log(8), math.log(largest), 2)).astype(int)
        shape = (int(ny), int(nx))
    return shape if rng.random() < 0.5 else shape[::-1]


def drawn_heights(
    rng: np.random.Generator, kind: str, shape: tuple[int, int], pixel: tuple[float, float]
) -> Array:
    """Return a map [m] whose slopes are drawn over six decades."""
    edge = math.sqrt(pixel[0] * pixel[1])
    y = (np.arange(shape[0]) - (shape[0] - 1) / 2) * pixel[0] / edge
    x = (np.arange(shape[1]) - (shape[1] - 1) / 2) * pixel[1] / edge
    heights = KINDS[kind](rng, *np.meshgrid(y, x, indexing="ij"))
    steps = [np.diff(heights, axis=axis) / (pixel[axis] / edge) for axis in (0, 1)]
    slopes = np.concatenate([step[np.isfinite(step)] for step in steps])
    slope = math.sqrt(float((slopes**2).mean())) if slopes.size else 0.0
    scale = 10 ** rng.uniform(-5, 0.5) / slope if slope > 0 else 1.0
    heights = heights * scale * edge
    if rng.random() < 0.1:
        # Measured from somewhere else: the digits below are lost.
        heights = heights + 1e3 * np.nanstd(heights)
    return np.asarray(heights)


def drawn_holes(rng: np.random.Generator, heights: Array) -> tuple[Array, str]:
    """Return the map with holes of some kind, at least one point left."""
    kind = str(rng.choice(["scattered", "patch", "border", "almost everything"]))
    holes = np.zeros(heights.shape, bool)
    ny, nx = heights.shape
    if kind == "scattered":
        holes = rng.random(heights.shape) < rng.choice([0.01, 0.3, 0.7])
    elif kind == "patch":
        holes[rng.integers(0, ny) :, rng.integers(0, nx) :] = True
    elif kind == "border":
        holes[:] = True
        holes[ny // 4 : ny - ny // 4, nx // 4 : nx - nx // 4] = False
    else:
        holes = rng.random(heights.shape) < 0.99
    keep = np.argwhere(np.isfinite(heights))
    holes[tuple(keep[rng.integers(len(keep))])] = False
    return np.where(holes, np.nan, heights), kind


def rms_slope(heights: Array, pixel: tuple[float, float]) -> float:
    """Return the root-mean-square slope."""
    parts = [np.diff(heights, axis=axis) / pixel[axis] for axis in (0, 1)]
    slopes = np.concatenate([part[np.isfinite(part)] for part in parts])
    return math.sqrt(float((slopes**2).mean())) if slopes.size else 0.0
