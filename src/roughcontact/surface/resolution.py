"""Lateral resolution of a measured map: tip, smoothing, noise.

`tip_cutoff`: The image of a tip of radius R has peaks with a radius of at least R. The curvature at
the scale λ = 2η is the second difference ``[h(x - η) - 2 h(x) + h(x + η)] / η²``; λ_c is the scale
below which its minimum over the map, at the sharpest peak, is less than -1/(2R). The factor ½ was
found with simulated tips in the reference. Peaks at finer scales carry the curvature of the tip or
noise, not of the surface, and the valleys between them were not reached.

The differences are along x, the fast axis of scanning instruments: between scan lines there are
jumps that are no peaks. Scales between two pixels are found by linear interpolation of the
curvature. A single spike can raise λ_c: remove outliers first.

Sanner, Nöhring, Thimons, Jacobs & Pastewka 2022, doi:10.1016/j.apsadv.2021.100190

`noise_cutoff`: White noise of RMS height σ adds σ² Δx Δy to the spectral density C at every wave
number. Where C falls slower than q⁻¹ over the shortest octave, slower than any self-affine surface
(q^(-2-2H), 0 ≤ H ≤ 1), its mean there is the estimate of the noise, and the cut-off is where C
falls below twice that. Steps of a coarse digitization are treated as noise. A surface with a white
spectrum, as above a roll-off wavelength, cannot be distinguished from noise.

Jacobs, Junge & Pastewka 2017, doi:10.1088/2051-672X/aa51f8

`smoothing_cutoff`: From this wave on, the spectral density falls faster than q⁻⁶, two powers faster
than that of any self-affine surface, over an octave and a half or down to the shortest wave. (The
flank of a spectral peak, as of regular grooves, is narrower.) Optics that do not resolve shorter
waves, an instrument that interpolates between its points and a filter have this effect; so does a
smooth surface. For a Gaussian filter it is about the cut-off, with 50 % transmission.

Jacobs, Junge & Pastewka 2017, doi:10.1088/2051-672X/aa51f8
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from roughcontact import units
from roughcontact._tools.arrays import Array, Pixel
from roughcontact.cautions import Caution, CautionTag, as_caution, as_note
from roughcontact.errors import (
    ArgumentRef,
    InputError,
    Part,
    Sentence,
    message_parts,
    require_pixel,
    require_positive,
)
from roughcontact.surface import grid
from roughcontact.surface.cleaning import largest_rectangle
from roughcontact.surface.form import level
from roughcontact.surface.spectrum import radial_spectrum


class LimitCause(StrEnum):
    """Cause that limits the lateral resolution of a map."""

    TIP = "tip"
    UNKNOWN_TIP = "tip of unknown radius"
    NOISE = "noise"
    SMOOTHING = "smoothing"


@dataclass(frozen=True)
class Limit:
    """Lateral scale below which a map does not represent the surface."""

    cause: LimitCause  # Cause of the limit
    wave: float  # Scale [m]
    text: str  # Description in one or two sentences

    @property
    def caution(self) -> Caution:
        """Caution for a contact of the map."""
        false = self.cause in (LimitCause.TIP, LimitCause.NOISE)
        return (as_caution if false else as_note)(
            CautionTag.RESOLUTION, *message_parts(self.text), wave=self.wave
        )


# Fraction of the tip's curvature; sharper peaks are caused by the tip (Sanner et al. 2022).
_SAFETY = 0.5

# Largest pixel [m] for which a usual tip is resolved: scanning probes scan up to about 0.1 mm.
_PROBED = 1e-6

# Local exponents of the spectrum. Self-affine surfaces have -2 (H = 0) to -4 (H = 1), white noise
# 0; the margins are for the scatter of one map and for surfaces that are only nearly self-affine.
_NOISE_EXPONENT = -1.0
_SMOOTH_EXPONENT = -6.0

# Bins of the spectrum per octave.
_BINS = 6

# Minimum number of points along a side for a spectrum with octaves to compare.
_MIN_POINTS = 32

# Names of formats of scanning probes, and terms in files of other formats. BCR-STM is an exchange
# format, which profilometers write as well.
_SCANNING_PROBE = re.compile(
    r"nanoscope|igor binary wave|jpk image scan|nt-mdt|nanosurf|molecular imaging|park systems"
    r"|wsxm|\bafm\b|\bspm\b|(?<!bcr-)\bstm\b|atomic force|scanning probe|scanning tunnel",
    re.IGNORECASE,
)


def shortest_wave(heights: Array, pixel: Pixel) -> float:
    """Return the shortest wavelength that a map shows [m]."""
    require_pixel(pixel)
    finest = 2 * max(pixel)
    if np.isnan(heights).any():
        rows, columns = largest_rectangle(heights)
        heights = heights[slice(*rows), slice(*columns)]
    if min(heights.shape) < _MIN_POINTS:
        return finest
    plane = level(heights)
    cuts = (noise_cutoff(plane, pixel), smoothing_cutoff(plane, pixel))
    return max([finest, *(cut for cut in cuts if cut is not None)])


def tip_cutoff(heights: Array, pixel: Pixel, tip_radius: float) -> float | None:
    """Return the lateral scale below which a map shows the tip instead of the surface."""
    require_pixel(pixel)
    require_positive(tip_radius=tip_radius)
    if heights.shape[1] < 3:
        raise InputError(
            f"must have at least 3 columns, got shape {heights.shape}", argument="heights"
        )
    dx, limit = pixel[1], -_SAFETY / tip_radius
    longest = max(heights.shape[1] // 4, 1)
    # Reach [pixels] and curvature of the sharpest peak below the limit, then above it.
    fine, sharpest = 1, _smallest_curvature(heights, dx, 1)
    if sharpest >= limit:
        return None
    while fine < longest:
        coarse = min(max(fine + 1, fine * 5 // 4), longest)
        value = _smallest_curvature(heights, dx, coarse)
        if value >= limit:
            break
        fine, sharpest = coarse, value
    else:
        return float(2 * fine * dx)
    while coarse - fine > 1:
        middle = (fine + coarse) // 2
        between = _smallest_curvature(heights, dx, middle)
        if between >= limit:
            coarse, value = middle, between
        else:
            fine, sharpest = middle, between
    part = (limit - sharpest) / (value - sharpest)
    return float(2 * (fine + part * (coarse - fine)) * dx)


def noise_cutoff(heights: Array, pixel: Pixel) -> float | None:
    """Return the wavelength below which a map contains more white noise than surface."""
    spectrum = _binned_spectrum(heights, pixel)
    if spectrum is None or not (floor := _plateau(*spectrum)):
        return None
    q, C = spectrum
    above = np.flatnonzero(C > 2 * floor)
    if above.size == 0:
        return float(2 * math.pi / q[0])
    last = int(above[-1])
    return _crossing_wavelength(q[last : last + 2], C[last : last + 2], 2 * floor)


def noise_height(heights: Array, pixel: Pixel) -> float:
    """Return the root-mean-square height of the white noise of a spectrum, or 0."""
    spectrum = _binned_spectrum(heights, pixel)
    floor = 0.0 if spectrum is None else _plateau(*spectrum)
    return math.sqrt(floor / (pixel[0] * pixel[1]))


def _plateau(q: Array, C: Array) -> float:
    """Return the spectral density of white noise; 0 where the shortest octave falls."""
    octave = q > q[-1] / 2
    falls = _exponent(q[octave], C[octave]) <= _NOISE_EXPONENT
    return 0.0 if falls else float(np.mean(C[octave]))


def smoothing_cutoff(heights: Array, pixel: Pixel) -> float | None:
    """Return the wavelength below which a map contains hardly any waves."""
    spectrum = _binned_spectrum(heights, pixel)
    if spectrum is None:
        return None
    q, C = spectrum
    half = _BINS // 2
    start = None
    for k in range(half, q.size - half):
        octave = slice(k - half, k + half + 1)
        if _exponent(q[octave], C[octave]) >= _SMOOTH_EXPONENT:
            start = None
        elif start is None:
            start = k
        elif k - start >= 3 * half:
            break
    return None if start is None else float(2 * math.pi / q[start])


def _smallest_curvature(heights: Array, dx: float, reach: int) -> float:
    """Return the smallest curvature along x at a given reach [1/m]."""
    smallest = math.inf
    for block in grid.row_blocks(heights.shape):
        rows = heights[block]
        bend = rows[:, 2 * reach :] + rows[:, : -2 * reach]
        bend -= 2 * rows[:, reach:-reach]
        # fmin ignores NaN, without a warning where all values are NaN.
        smallest = float(np.fmin(smallest, np.fmin.reduce(bend, axis=None)))
    return smallest / (reach * dx) ** 2


def _binned_spectrum(heights: Array, pixel: Pixel) -> tuple[Array, Array] | None:
    """Return wave numbers and spectral density in bins of equal width in log q."""
    if min(heights.shape) < _MIN_POINTS:
        return None
    # Squared Hann window: leakage from the longest waves falls as q⁻¹⁰, faster than the spectra to
    # be found. Without a window, a map that is not periodic would hide them under q⁻².
    window = [np.sin(math.pi * (np.arange(n) + 0.5) / n) ** 4 for n in heights.shape]
    weighted = level(heights) * window[0][:, None] * window[1]
    weight = float(np.mean(window[0] ** 2) * np.mean(window[1] ** 2))
    q, C, waves = radial_spectrum(weighted, pixel)
    # From the waves that the window does not blur to those that both axes resolve.
    low, high = 4 * q[0], math.pi / max(pixel) * (1 + 1e-9)
    bins = max(int(_BINS * math.log2(high / low)), 1)
    index = np.floor((np.log(q / high) / math.log(low / high)) * bins).astype(int)
    inside = (index >= 0) & (index < bins)
    index = bins - 1 - index[inside]
    count, power, place = (
        np.bincount(index, waves[inside] * values, minlength=bins)
        for values in (1.0, C[inside], np.log(q[inside]))
    )
    full = count > 0
    if np.count_nonzero(full) <= 2 * _BINS:
        return None
    density = power[full] / count[full] / weight
    # A density that rounding could produce is treated as zero.
    tiny = max(1e-30 * float(density.max()), np.finfo(float).tiny)
    return np.exp(place[full] / count[full]), np.maximum(density, tiny)


def _exponent(q: Array, C: Array) -> float:
    """Return the least-squares slope of log C over log q."""
    x, y = np.log(q), np.log(C)
    x = x - x.mean()
    return float((x @ y) / (x @ x))


def _crossing_wavelength(q: Array, C: Array, value: float) -> float:
    """Return the wavelength at which C falls to a value between two wave numbers."""
    if q.size < 2:
        return float(2 * math.pi / q[0])
    part = math.log(C[0] / value) / math.log(C[0] / C[1])
    return float(2 * math.pi / math.exp(math.log(q[0]) + part * math.log(q[1] / q[0])))


def tip_limits(
    heights: Array, pixel: Pixel, tip_radius: float | None, instrument: str
) -> list[Limit]:
    """Return the limits of the resolution of a map by the tip."""
    if tip_radius is None:
        if max(pixel) > _PROBED or not _SCANNING_PROBE.search(instrument):
            return []
        requested = Sentence(
            "Probe measurement without tip radius: finest peaks may show the tip. Give "
            f"{ArgumentRef('tip_radius')}."
        )
        return [Limit(LimitCause.UNKNOWN_TIP, 0.0, requested)]
    scale = tip_cutoff(heights, pixel, tip_radius)
    if scale is None:
        return []
    radius = units.format_engineering(tip_radius, "m", 3)
    text = (
        f"{_below_limit(scale, pixel)} the map shows the tip (radius {radius}), not the surface. "
    )
    return [Limit(LimitCause.TIP, scale, Sentence(text, *_filter_remedy(scale)))]


def wave_limits(heights: Array, pixel: Pixel) -> list[Limit]:
    """Return the limits of the resolution of a map by noise and by missing waves."""
    try:
        rows, columns = largest_rectangle(heights)
    except InputError:
        return []
    part = heights[slice(*rows), slice(*columns)]
    limits = []
    wave = noise_cutoff(part, pixel)
    if wave is not None:
        text = (
            f"Waves {_below_limit(wave, pixel).lower()} are mostly noise: elastic contact area and "
            "pressure depend on them. "
        )
        limits.append(Limit(LimitCause.NOISE, wave, Sentence(text, *_filter_remedy(wave))))
    wave = smoothing_cutoff(part, pixel)
    if wave is not None:
        text = (
            f"No detail {_below_limit(wave, pixel).lower()}: smoothed, oversampled, or a smooth "
            "surface."
        )
        limits.append(Limit(LimitCause.SMOOTHING, wave, text))
    return limits


def _below_limit(length: float, pixel: Pixel) -> str:
    return f"Below {units.format_engineering(length, 'm', 3)} ({length / pixel[1]:.1f} pixels)"


def _filter_remedy(wave: float) -> tuple[Part, ...]:
    return "Use ", ArgumentRef("s", units.format_engineering(wave, "m", 3)), "."
