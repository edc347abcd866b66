"""Virtual microscopes and styli of the judge of intervals; nothing is imported from the package.

Surfaces of six finishes on 384² points, each one period of an endless surface without waves shorter
than λs (8 to 32 points), RMS slope 0.05 to 0.15. An instrument shows 96² pixels of 4 × 4 points: a
microscope with the incoherent transfer of a round pupil or with a Gaussian transfer (λ50 of 2 to 6
pixels), or a ball (radius times RMS mean curvature of 0.2 to 1.2), with white noise of 0.1 to 3 %
of Sq and 0, 1 or 4 % of missing points, clustered where the surface is steep. The resolution is
stated wrong by 15 %, tip radius and noise by 20 % (one standard deviation of the logarithm).

All lengths are in points of the surface. The finish follows from the number; a number has the same
surface, resolution, noise and statements under all instruments.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, optimize

Array = NDArray[np.floating]
Generator = np.random.Generator

POINTS, BINNING = 384, 4
KINDS = ("diffraction", "gaussian", "tip")


@dataclass(frozen=True)
class Measurement:
    """A surface, its map, and what is stated of the instrument; lengths in points."""

    number: int
    kind: str
    finish: str
    heights: Array
    image: Array  # NaN where missing
    shortest_wave: float
    resolution: float
    tip_radius: float
    noise: float
    stated_resolution: float
    stated_tip_radius: float
    stated_noise: float
    pressure: float  # over E* and the RMS slope, as the ceiling
    ceiling: float


def draw_measurement(number: int, kind: str) -> Measurement:
    """Draw a surface and measure it."""
    finish = tuple(FINISHES)[number % len(FINISHES)]
    rng = np.random.default_rng([20260, number])
    shortest_wave = 8 * 4 ** rng.random()
    slope = 0.05 * 3 ** rng.random()
    heights = remove_short_waves(FINISHES[finish](rng), shortest_wave)
    return measure(number, kind, finish, heights * slope / rms_slope(heights), shortest_wave)


def measure(
    number: int, kind: str, finish: str, heights: Array, shortest_wave: float
) -> Measurement:
    """Measure one period of a surface with the instrument of a number."""
    rng = np.random.default_rng([20261, number])
    resolution = rng.uniform(2, 6) * BINNING
    tip_radius = rng.uniform(0.2, 1.2) / float(np.std(curvature(heights)))
    noise = 0.001 * 30 ** rng.random() * float(np.std(heights))
    missing = rng.choice([0.0, 0.01, 0.04])
    wrong = np.exp([0.15, 0.2, 0.2] * rng.standard_normal(3))
    pressure = 0.008 * 10 ** rng.random()
    ceiling = max(0.06 * (0.4 / 0.06) ** rng.random(), 2 * pressure)
    seen = (
        dilate_with_ball(heights, tip_radius) if kind == "tip" else blur(heights, kind, resolution)
    )
    image = average_pixels(seen)
    lost = find_missing(image, missing, rng)
    image = np.where(lost, np.nan, image + noise * rng.standard_normal(image.shape))
    return Measurement(
        number=number,
        kind=kind,
        finish=finish,
        heights=heights,
        image=image,
        shortest_wave=shortest_wave,
        resolution=resolution,
        tip_radius=tip_radius,
        noise=noise,
        stated_resolution=resolution * wrong[0],
        stated_tip_radius=tip_radius * wrong[1],
        stated_noise=noise * wrong[2],
        pressure=pressure,
        ceiling=ceiling,
    )


def blur(heights: Array, kind: str, resolution: float) -> Array:
    """Return the transfer of a microscope at one period of a surface."""
    waves = wave_number(heights.shape) * resolution
    transfer = pupil_transfer(HALF * waves) if kind == "diffraction" else 0.5 ** (waves**2)
    return np.fft.irfft2(np.fft.rfft2(heights) * transfer, heights.shape)


def pupil_transfer(frequency: Array | float) -> Array:
    """Return the overlap of two discs of unit diameter at a distance, over their area.

    It is the incoherent transfer of a round pupil at q λ/(2 NA); Goodman, Introduction to Fourier
    Optics (2005), section 6.3.
    """
    distance = np.minimum(frequency, 1.0)
    return 2 / np.pi * (np.arccos(distance) - distance * np.sqrt(1 - distance**2))


HALF: float = optimize.brentq(lambda frequency: float(pupil_transfer(frequency)) - 0.5, 0, 1)
"""Frequency of half the transfer, 0.404: λ50 = λ/(2 NA HALF) = 1.24 λ/NA."""


def dilate_with_ball(heights: Array, radius: float) -> Array:
    """Return the height of the lowest point of a ball that touches one period of a surface.

    A ball touches a smooth surface where both have one slope: points farther from its axis than
    the steepest slope allows need no trial. Two points are added for the grid.
    """
    steepest = float(np.hypot(*gradient(heights)).max())
    reach = math.floor(min(radius, radius * steepest / math.hypot(1, steepest) + 2))
    square = np.add.outer(*[np.arange(-reach, reach + 1.0) ** 2] * 2)
    drop = radius - np.sqrt(np.maximum(radius**2 - square, 0))
    return ndimage.grey_dilation(
        heights, footprint=square <= reach**2, structure=-drop, mode="wrap"
    )


def average_pixels(heights: Array) -> Array:
    """Return the mean heights of the pixels."""
    rows, columns = (points // BINNING for points in heights.shape)
    return heights.reshape(rows, BINNING, columns, BINNING).mean(axis=(1, 3))


def find_missing(image: Array, share: float, rng: Generator) -> NDArray[np.bool_]:
    """Return points in clusters where the map is steep."""
    cloud = ndimage.gaussian_filter(rng.standard_normal(image.shape), 1.5, mode="wrap")
    steep = ndimage.gaussian_filter(np.hypot(*gradient(image)), 1.0, mode="wrap")
    score = cloud / cloud.std() + 1.5 * (steep - steep.mean()) / steep.std()
    return score > np.quantile(score, 1 - share)


# --- Periodic fields ---


def wave_number(shape: tuple[int, ...]) -> Array:
    """Return the wave number of each coefficient of a real transform, in waves per point."""
    return np.hypot(*_wave_vectors(shape))


def _wave_vectors(shape: tuple[int, ...]) -> tuple[Array, Array]:
    return np.fft.fftfreq(shape[0])[:, None], np.fft.rfftfreq(shape[1])[None, :]


def gradient(heights: Array) -> tuple[Array, Array]:
    """Return both slopes of the waves of one period."""
    spectrum = np.fft.rfft2(heights)
    down, across = (2j * np.pi * waves * spectrum for waves in _wave_vectors(heights.shape))
    return np.fft.irfft2(down, heights.shape), np.fft.irfft2(across, heights.shape)


def curvature(heights: Array) -> Array:
    """Return the mean curvature of small slopes, ∇²h/2."""
    waves = 2 * np.pi * wave_number(heights.shape)
    return np.fft.irfft2(-0.5 * waves**2 * np.fft.rfft2(heights), heights.shape)


def rms_slope(heights: Array) -> float:
    """Return the RMS gradient of one period."""
    return math.hypot(*(float(np.std(slope)) for slope in gradient(heights)))


def remove_short_waves(heights: Array, shortest_wave: float) -> Array:
    """Return the waves from ``shortest_wave`` on, without their mean."""
    keep = wave_number(heights.shape) * shortest_wave <= 1
    keep[0, 0] = False
    return np.fft.irfft2(np.fft.rfft2(heights) * keep, heights.shape)


def random_field(amplitude: Array, rng: Generator) -> Array:
    """Return a Gaussian field of unit variance with the amplitudes of a spectrum."""
    noise = np.fft.rfft2(rng.standard_normal((POINTS, POINTS)))
    noise[0, 0] = 0
    field = np.fft.irfft2(noise * amplitude, (POINTS, POINTS))
    return field / field.std()


def self_affine_amplitude(hurst: float, rolloff: float) -> Array:
    """Return amplitudes of a self-affine spectrum, constant above a wavelength."""
    return np.maximum(wave_number((POINTS, POINTS)), 1 / rolloff) ** -(1 + hurst)


# --- Finishes: heights of one period in any unit, with all waves of the grid ---


def _lapped(rng: Generator) -> Array:
    hurst, rolloff = rng.uniform(0.5, 0.9), POINTS / rng.uniform(2.5, 8)
    return random_field(self_affine_amplitude(hurst, rolloff), rng)


def _bifractal(rng: Generator) -> Array:
    hurst, rolloff, crossover = rng.uniform(0.2, 0.5), POINTS / rng.uniform(2.5, 5), 30.0
    steeper = np.maximum(wave_number((POINTS, POINTS)) * crossover, 1) ** -rng.uniform(0.3, 0.5)
    return random_field(self_affine_amplitude(hurst, rolloff) * steeper, rng)


def _ground(rng: Generator) -> Array:
    down, across = _wave_vectors((POINTS, POINTS))
    angle = np.arctan2(down, across) - rng.uniform(0, np.pi)
    angle -= np.pi * np.round(angle / np.pi)
    share = np.exp(-0.5 * (angle / rng.uniform(0.15, 0.3)) ** 2) + rng.uniform(0.02, 0.06)
    amplitude = self_affine_amplitude(rng.uniform(0.5, 0.8), POINTS / rng.uniform(4, 8))
    return random_field(amplitude * np.sqrt(share), rng)


def _turned(rng: Generator) -> Array:
    marks = int(rng.integers(6, 13))
    place = np.arange(POINTS) / POINTS * marks
    depth = np.exp(0.15 * rng.standard_normal(marks))[place.astype(int)]
    feed = depth * (2 * (place % 1) - 1) ** 2
    return feed / feed.std() + rng.uniform(0.3, 0.8) * _lapped(rng)


def _blasted(rng: Generator) -> Array:
    """Overlapping craters: each replaces the heights in its circle by a bowl at their mean."""
    heights = np.zeros((POINTS, POINTS))
    for _ in range(rng.integers(800, 1500)):
        radius = 8 * rng.random() ** -0.5
        if radius > POINTS / 10:
            continue
        side = np.arange(-int(radius), int(radius) + 1)
        place = np.ix_(*((side + corner) % POINTS for corner in rng.integers(POINTS, size=2)))
        distance = np.add.outer(side**2, side**2) / radius**2
        patch = heights[place]
        inside = distance < 1
        bowl = patch[inside].mean() + 0.15 * radius * (distance - 0.5)
        heights[place] = np.where(inside, bowl, patch)
    return heights / heights.std() + rng.uniform(0.1, 0.3) * _lapped(rng)


def _honed(rng: Generator) -> Array:
    """Two processes: crossed grooves on roughness, cut by a smoother plateau."""
    x, y = np.meshgrid(*[np.arange(POINTS) / POINTS] * 2)
    steps = [(1, 1), (1, 2)][rng.integers(2)]
    valley = 0.2 * _lapped(rng)
    for sign in (-1, 1):
        across = steps[0] * x + sign * steps[1] * y
        for _ in range(rng.integers(3, 7)):
            apart = (across - rng.random() + 0.5) % 1 - 0.5
            groove = apart * POINTS / math.hypot(*steps) / rng.uniform(5, 14)
            valley -= np.exp(0.4 * rng.standard_normal() - groove**2)
    level = float(np.quantile(valley, rng.uniform(0.2, 0.5)))
    return np.minimum(level + rng.uniform(0.1, 0.25) * _lapped(rng), valley)


FINISHES: dict[str, Callable[[Generator], Array]] = {
    "honed": _honed,
    "turned": _turned,
    "blasted": _blasted,
    "bifractal": _bifractal,
    "ground": _ground,
    "lapped": _lapped,
}
