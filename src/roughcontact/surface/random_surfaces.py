"""Self-affine random surfaces, and power spectra of random maps.

Heights [m] are positive out of the material, ``heights[y, x]``; pairs are ``(y, x)``.

`Spectrum`: ``C(q) = max(κ, 1/λ_rolloff)^(-2-2H)`` for κ ≤ 1/λ_cutoff, with κ² = q_across² +
(q_along/Str)²: stretched along the lay, the map has an autocorrelation whose contours are ellipses
with the axis ratio Str of ISO 25178-2.

Persson et al. 2005, doi:10.1088/0953-8984/17/1/R01; Jacobs, Junge & Pastewka 2017,
doi:10.1088/2051-672X/aa51f8
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arguments import as_pair, validate_arguments
from roughcontact._tools.arrays import Array, Pixel, Shape
from roughcontact._tools.roots import brentq
from roughcontact.errors import InputError, input_error, require_count, require_positive
from roughcontact.halfspace import fft
from roughcontact.surface import grid
from roughcontact.surface.alignment import cosine_sine
from roughcontact.surface.shapes import require_grid
from roughcontact.units import Quantities, Quantity, to_si

# Tolerance for rounding of the ratio of a side to a wavelength.
_SLACK = 1e-9
# Upper bound of seeds: they fit into a signed integer of 64 bits.
_SEEDS = 2**63


@validate_arguments
def self_affine(
    shape: tuple[int, int] | int,
    pixel: Quantities | Quantity,
    *,
    rms_height: Quantity,
    rolloff_wavelength: Quantity,
    cutoff_wavelength: Quantity,
    hurst: float = 0.8,
    rng: int | np.random.Generator | None,
) -> Array:
    """Return a periodic, isotropic, Gaussian self-affine map.

    Parameters
    ----------
    shape : (int, int) or int
        Grid points ``(ny, nx)``, or of each side.
    pixel : (float, float) or float
        Pixel edges ``(dy, dx)`` [m], or of a square one.
    rms_height : float
        Root-mean-square height [m] of this map (not of the ensemble), met to rounding.
    rolloff_wavelength : float
        Wavelength [m] above which the spectrum is flat.
    cutoff_wavelength : float
        Shortest wavelength [m] in the map, at least two pixels.
    hurst : float
        Hurst exponent H, in [0, 1].
    rng : int, numpy.random.Generator or None
        Seed or source of the amplitudes; None gives different ones in every call.

    Returns
    -------
    ndarray, shape (ny, nx)
        Heights [m] with zero mean.

    Raises
    ------
    InputError
        If a length is not positive, the Hurst exponent is outside [0, 1], the cut-off is finer
        than the grid or coarser than the roll-off, or no wave fits on the map.

    Notes
    -----
    Every wave vector q = (i/Ly, j/Lx) [waves/m] except 0 has a complex Gaussian amplitude of
    variance ``max(|q|, 1/λ_rolloff)^(-2-2H)`` up to ``|q| = 1/λ_cutoff`` and none beyond; waves of
    half a period per pixel are left out.

    The amplitudes are drawn in shells of growing wave number (square ones on a square map:
    ``max(|i|, |j|)`` = 1, 2, …) that do not depend on the grid. Equal generators, sides and
    wavelengths therefore give the same surface on every grid: point (y, x) of a map is point (2y,
    2x) of the map with half the pixel. With another cut-off the common waves agree up to the factor
    that sets the RMS height.

    References
    ----------
    Persson et al. 2005, doi:10.1088/0953-8984/17/1/R01

    Examples
    --------
    >>> body = dict(rms_height=1e-7, rolloff_wavelength=2e-5, cutoff_wavelength=4e-6)
    >>> coarse = self_affine((64, 64), (1e-6, 1e-6), **body, rng=1)
    >>> fine = self_affine((128, 128), (5e-7, 5e-7), **body, rng=1)
    >>> bool(np.allclose(fine[::2, ::2], coarse, rtol=0, atol=1e-20))
    True
    """
    shape, edges = as_pair(shape, "shape"), as_pair(to_si(pixel, "length", "pixel"), "pixel")
    Sq = to_si(rms_height, "length", "rms_height")
    longest = to_si(rolloff_wavelength, "length", "rolloff_wavelength")
    shortest = to_si(cutoff_wavelength, "length", "cutoff_wavelength")
    require_grid(shape, edges, grid.GENERATED_ARRAYS)
    require_positive(rms_height=Sq)
    check_waves(edges, longest, shortest, hurst)
    waves = _spectrum(shape, edges, longest, shortest, hurst, generator_of(rng))
    return _heights(waves, shape[1], Sq)


@validate_arguments
def reference_map(
    n: int, rng: int | np.random.Generator | None = 0
) -> tuple[Array, tuple[float, float]]:
    """Return the rough test problem R(n): side 0.1 mm, RMS height 0.2 µm, exponent 0.8.

    Parameters
    ----------
    n : int
        Grid points per side, at least 32; the cut-off is at n/8 waves per side, the roll-off at 4.
    rng : int, numpy.random.Generator or None
        Seed of the amplitudes. A generator draws one; None gives a different one in every call.

    Returns
    -------
    heights : ndarray, shape (n, n)
        Heights [m].
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].

    Raises
    ------
    InputError
        If n is below 32, where the cut-off would exceed the roll-off.

    Notes
    -----
    A seed gives the same surface for all n: R(2n) is R(n) with finer waves added, times a factor
    slightly below 1 that keeps the RMS height.

    Examples
    --------
    >>> heights, pixel = reference_map(64)
    >>> round(float(heights.std() * 1e6), 6)
    0.2
    """
    side = 1e-4
    pixel = (side / n, side / n) if n > 0 else (0.0, 0.0)
    heights = self_affine(
        (n, n),
        pixel,
        rms_height=0.2e-6,
        rolloff_wavelength=side / 4,
        cutoff_wavelength=8 * pixel[0],
        hurst=0.8,
        rng=seed_of(rng),
    )
    return heights, pixel


def seed_of(rng: int | np.random.Generator | None) -> int:
    """Return a seed to record: an integer as it is, or one drawn from a generator."""
    if rng is None or isinstance(rng, np.random.Generator):
        return int(np.random.default_rng(rng).integers(_SEEDS))
    require_count(0, _SEEDS - 1, rng=rng)
    return int(rng)


def generator_of(rng: int | np.random.Generator | None) -> np.random.Generator:
    """Return the generator of a seed, or the given generator."""
    if not (rng is None or isinstance(rng, np.random.Generator)):
        require_count(0, _SEEDS - 1, rng=rng)
    return np.random.default_rng(rng)


def random_amplitudes(
    shape: Shape, pixel: Pixel, rng: np.random.Generator
) -> NDArray[np.complex128]:
    """Return a complex Gaussian amplitude for every wave that a grid resolves."""
    shortest = 2 * max(pixel)
    noise = _spectrum(shape, pixel, shortest, shortest, -1.0, rng)
    waves = np.zeros((shape[0], shape[1] // 2 + 1), dtype=np.complex128)
    waves[:, : noise.shape[1]] = noise
    return waves


def check_waves(
    pixel: Pixel, rolloff_wavelength: float, cutoff_wavelength: float, hurst: float
) -> None:
    """Raise `InputError` unless a grid resolves these wavelengths [m] and Hurst exponent."""
    require_positive(rolloff_wavelength=rolloff_wavelength, cutoff_wavelength=cutoff_wavelength)
    if not 0 <= hurst <= 1:
        raise input_error("hurst", hurst, "must be in [0, 1]")
    # The tolerance accepts rounding of the quotient side / waves.
    if cutoff_wavelength < 2 * max(pixel) * (1 - _SLACK):
        raise input_error(
            "cutoff_wavelength",
            cutoff_wavelength,
            f"must be at least two pixels = {2 * max(pixel):g} m",
        )
    if cutoff_wavelength > rolloff_wavelength * (1 + _SLACK):
        raise input_error(
            "cutoff_wavelength",
            cutoff_wavelength,
            f"must not exceed rolloff_wavelength = {rolloff_wavelength!r} m",
        )


def _spectrum(
    shape: Shape,
    pixel: Pixel,
    rolloff_wavelength: float,
    cutoff_wavelength: float,
    hurst: float,
    rng: np.random.Generator,
) -> NDArray[np.complex128]:
    # Fourier coefficients of real heights: rows in FFT order, columns 0, 1, … up to the cut-off.
    side = (shape[0] * pixel[0], shape[1] * pixel[1])
    shells = int(max(side) / cutoff_wavelength * (1 + _SLACK))
    columns = min(int(side[1] / cutoff_wavelength * (1 + _SLACK)), (shape[1] - 1) // 2) + 1
    spectrum = np.zeros((shape[0], columns), dtype=np.complex128)
    for shell in range(1, shells + 1):
        i, j = _half_shell(_box(shell - 1, side), _box(shell, side))
        # The whole shell is drawn, even if part of it is outside; see the notes of `self_affine`.
        noise = rng.standard_normal((i.size, 2)).view(np.complex128)[:, 0]
        q = np.hypot(i / side[0], j / side[1])
        keep = (q * cutoff_wavelength <= 1 + _SLACK) & (2 * np.abs(i) < shape[0]) & (j < columns)
        i, j, q, noise = i[keep], j[keep], q[keep], noise[keep]
        spectrum[i, j] = noise * np.maximum(q * rolloff_wavelength, 1) ** (-1 - hurst)
    if not spectrum.any():
        raise InputError(
            f"no wave between cutoff_wavelength = {cutoff_wavelength!r} m and the sides {side} m"
        )
    # Column 0 contains both signs of the row index; the heights must be real.
    half = (shape[0] - 1) // 2
    spectrum[shape[0] - half :, 0] = spectrum[1 : half + 1, 0][::-1].conj()
    return spectrum


def _heights(spectrum: NDArray[np.complex128], columns: int, rms_height: float) -> Array:
    # Columns above the cut-off are zero: transforming along y first skips them.
    rows = fft.ifft(spectrum, axis=0, norm="forward")
    heights: Array = fft.irfft(rows, columns, axis=1, norm="forward")
    mean_square = float(np.einsum("yx,yx->", heights, heights)) / heights.size
    heights *= rms_height / math.sqrt(mean_square)
    return heights


def _box(shell: int, side: tuple[float, float]) -> tuple[int, int]:
    # Largest |i| and |j| up to this shell: `shell` waves along the longer side, and the same number
    # per length along the other; otherwise most waves drawn for long narrow maps would be
    # unresolved.
    i, j = (math.ceil(shell * length / max(side) - _SLACK) for length in side)
    return i, j


def _half_shell(
    inner: tuple[int, int], outer: tuple[int, int]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    # Wave vectors (i, j) in the outer box but not in the inner one: j ≥ 0, and one of (±i, 0).
    edge = np.arange(-outer[0], outer[0] + 1) if outer[1] > inner[1] else np.arange(0)
    upper = np.arange(inner[1] + 1) if outer[0] > inner[0] else np.arange(0)
    lower = upper[1:]
    i = np.concatenate([edge, np.full(upper.size, outer[0]), np.full(lower.size, -outer[0])])
    j = np.concatenate([np.full(edge.size, outer[1]), upper, lower])
    return i, j


@dataclass(frozen=True)
class Spectrum:
    """Power spectrum of a periodic random map, up to a factor."""

    shape: tuple[int, int]  # Grid points `(ny, nx)`
    pixel: tuple[float, float]  # Pixel edges `(dy, dx)` [m]
    rolloff: float  # Wavelength [m] across the lay above which the spectrum is flat
    cutoff: float  # Shortest wavelength [m] across the lay
    hurst: float  # Hurst exponent H
    ratio: float = 1.0
    lay: float = 0.0  # Direction of the lay [degrees], counter-clockwise from x as the map is drawn

    @property
    def distances(self) -> Array:
        """Distance κ [1/m] of every wave from zero, in the order of `numpy.fft.rfft2`."""
        (ny, nx), (dy, dx) = self.shape, self.pixel
        # Rows count downwards as the map is drawn.
        up = -fft.frequencies(ny, dy)
        right = fft.half_frequencies(nx, dx)
        cosine, sine = cosine_sine(self.lay)
        distances = np.empty((ny, nx // 2 + 1))
        for rows in grid.row_blocks(distances.shape):
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
        for rows in grid.row_blocks(power.shape):
            q = power[rows]
            inside = q * self.cutoff <= 1 + _SLACK
            raised = np.maximum(q[inside] * self.rolloff, 1) ** (-2 - 2 * self.hurst)
            q[...] = 0.0
            q[inside] = raised
        return power

    def gradient(self) -> float:
        """Return the root-mean-square gradient over the root-mean-square height [1/m]."""
        (ny, nx), (dy, dx) = self.shape, self.pixel
        power = self.power
        # Half of the waves along x represent both signs.
        power[:, 1:] *= 2
        slope_y = (2 * np.sin(math.pi * np.arange(ny) / ny) / dy) ** 2
        slope_x = (2 * np.sin(math.pi * np.arange(nx // 2 + 1) / nx) / dx) ** 2
        squares = float(np.sum(power.sum(axis=1) * slope_y) + np.sum(power.sum(axis=0) * slope_x))
        return math.sqrt(squares / float(power.sum()))


def with_gradient(spectrum: Spectrum, name: str, gradient: float, height: float) -> Spectrum:
    """Return a spectrum whose roll-off or cut-off gives a requested gradient."""
    sides = [n * edge for n, edge in zip(spectrum.shape, spectrum.pixel, strict=True)]
    rolloff = name == "rolloff"
    ends = (spectrum.cutoff, max(sides)) if rolloff else (2 * max(spectrum.pixel), spectrum.rolloff)

    def spectrum_at(logarithm: float) -> Spectrum:
        wave = math.exp(logarithm)
        return replace(spectrum, rolloff=wave) if rolloff else replace(spectrum, cutoff=wave)

    def excess(logarithm: float) -> float:
        return height * spectrum_at(logarithm).gradient() - gradient

    low, high = (math.log(end) for end in ends)
    steepest, flattest = (excess(end) + gradient for end in (low, high))
    if not flattest <= gradient <= steepest:
        other = (
            f"cutoff_wavelength = {spectrum.cutoff:.4g} m"
            if rolloff
            else f"a roll-off at {spectrum.rolloff:.4g} m"
        )
        raise input_error(
            "Sdq",
            gradient,
            f"must be in {flattest:.4g} to {steepest:.4g}, which this map has with Sq = "
            f"{height:.4g} m, a Hurst exponent of {spectrum.hurst:g} and {other}",
        )
    return spectrum_at(brentq(excess, low, high, xtol=1e-4))
