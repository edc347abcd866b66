"""Power spectra of random maps: roll-off, exponent, cut-off and direction."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from roughcontact.errors import InputError
from roughcontact.halfspace import fft
from roughcontact.roots import brentq
from roughcontact.surface import blocks
from roughcontact.surface.alignment import cosine_sine

Array = NDArray[np.float64]

# What rounding of a side over a number of waves is forgiven.
_SLACK = 1e-9


@dataclass(frozen=True)
class Spectrum:
    """The power spectrum of a periodic random map, without a scale.

    Parameters
    ----------
    shape : (int, int)
        Grid points ``(ny, nx)``.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].
    rolloff : float
        Wavelength [m] across the lay above which the spectrum is flat.
    cutoff : float
        Shortest wavelength [m] across the lay.
    hurst : float
        Hurst exponent H.
    ratio : float
        Wavelengths across the lay over those along it: the texture aspect ratio Str of the
        ensemble.
    lay : float
        Direction of the lay [degrees], counter-clockwise from x as the map is drawn.

    Notes
    -----
    ``C(q) = max(κ, 1/λ_rolloff)^(-2-2H)`` for κ ≤ 1/λ_cutoff, with κ² = q_across² + (q_along/Str)²:
    stretched along the lay, the map has an autocorrelation whose contours are ellipses with the
    ratio Str of the axes, and Str is what ISO 25178-2 calls so.

    References
    ----------
    Persson et al. 2005, doi:10.1088/0953-8984/17/1/R01; Jacobs, Junge & Pastewka 2017,
    doi:10.1088/2051-672X/aa51f8
    """

    shape: tuple[int, int]
    pixel: tuple[float, float]
    rolloff: float
    cutoff: float
    hurst: float
    ratio: float = 1.0
    lay: float = 0.0

    @property
    def distances(self) -> Array:
        """Distance κ [1/m] of every wave from zero, in the order of `numpy.fft.rfft2`.

        Infinite for those without a part in the map: the mean, and half a period per pixel, which
        has no phase.
        """
        (ny, nx), (dy, dx) = self.shape, self.pixel
        # Rows count downwards where the map is drawn.
        up = -fft.frequencies(ny, dy)
        right = fft.half_frequencies(nx, dx)
        cosine, sine = cosine_sine(self.lay)
        distances = np.empty((ny, nx // 2 + 1))
        for rows in blocks.of_rows(distances.shape):
            along = right * cosine + up[rows, None] * sine
            across = up[rows, None] * cosine - right * sine
            np.hypot(across, along / self.ratio, out=distances[rows])
        distances[0, 0] = math.inf
        if ny % 2 == 0:
            distances[ny // 2] = math.inf
        if nx % 2 == 0:
            distances[:, -1] = math.inf
        return distances

    @property
    def power(self) -> Array:
        """Power of every wave, shape (ny, nx//2 + 1), in the order of `numpy.fft.rfft2`."""
        power = self.distances
        for rows in blocks.of_rows(power.shape):
            q = power[rows]
            inside = q * self.cutoff <= 1 + _SLACK
            raised = np.maximum(q[inside] * self.rolloff, 1) ** (-2 - 2 * self.hurst)
            q[...] = 0.0
            q[inside] = raised
        return power

    def gradient(self) -> float:
        """Return the root-mean-square gradient over the root-mean-square height [1/m].

        The gradient is that of the first differences, as `roughness.rms_gradient` takes it.
        """
        (ny, nx), (dy, dx) = self.shape, self.pixel
        power = self.power
        # Half of the waves along x stand for both signs.
        power[:, 1:] *= 2
        slope_y = (2 * np.sin(math.pi * np.arange(ny) / ny) / dy) ** 2
        slope_x = (2 * np.sin(math.pi * np.arange(nx // 2 + 1) / nx) / dx) ** 2
        squares = float(np.sum(power.sum(axis=1) * slope_y) + np.sum(power.sum(axis=0) * slope_x))
        return math.sqrt(squares / float(power.sum()))


def with_gradient(spectrum: Spectrum, name: str, gradient: float, height: float) -> Spectrum:
    """Return a spectrum with the roll-off or the cut-off that gives a gradient.

    Parameters
    ----------
    spectrum : Spectrum
        With all that stays as it is.
    name : {"rolloff", "cutoff"}
        What is sought.
    gradient : float
        Root-mean-square gradient Sdq.
    height : float
        Root-mean-square height Sq [m].

    Returns
    -------
    Spectrum
        With the wavelength found.

    Raises
    ------
    InputError
        If no wavelength that the map can hold gives it.
    """
    sides = [n * edge for n, edge in zip(spectrum.shape, spectrum.pixel, strict=True)]
    rolloff = name == "rolloff"
    ends = (spectrum.cutoff, max(sides)) if rolloff else (2 * max(spectrum.pixel), spectrum.rolloff)

    def at(logarithm: float) -> Spectrum:
        wave = math.exp(logarithm)
        return replace(spectrum, rolloff=wave) if rolloff else replace(spectrum, cutoff=wave)

    def excess(logarithm: float) -> float:
        return height * at(logarithm).gradient() - gradient

    low, high = (math.log(end) for end in ends)
    steepest, flattest = (excess(end) + gradient for end in (low, high))
    if not flattest <= gradient <= steepest:
        other = (
            f"cutoff_wavelength = {spectrum.cutoff:.4g} m"
            if rolloff
            else f"a roll-off at {spectrum.rolloff:.4g} m"
        )
        raise InputError(
            f"must lie in {flattest:.4g} to {steepest:.4g}, which this map has with Sq = "
            f"{height:.4g} m, a Hurst exponent of {spectrum.hurst:g} and {other}, got {gradient!r}",
            argument="Sdq",
            value=gradient,
        )
    return at(brentq(excess, low, high, xtol=1e-4))
