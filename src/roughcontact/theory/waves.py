"""Contact of wavy surfaces in closed form.

Pressure is positive in compression. Lengths [m], pressures and moduli [Pa]. A wavy surface has the
heights ``Δ cos(2πx/λ)``, a surface of crossed waves ``Δ cos(2πx/λ) cos(2πy/λ)``, so that Δ is half
the peak-to-valley height.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from roughcontact._tools.arrays import Array
from roughcontact.errors import require_positive


def wavy_full_contact_pressure(
    amplitude: float, wavelength: float, contact_modulus: float
) -> float:
    """Return the mean pressure that closes a wavy surface, ``p* = π E* Δ/λ``.

    Parameters
    ----------
    amplitude : float
        Δ [m] of the heights Δ cos(2πx/λ).
    wavelength : float
        λ [m].
    contact_modulus : float
        E* [Pa].

    Returns
    -------
    float
        p* [Pa].

    Raises
    ------
    InputError
        If an argument is not positive.

    Notes
    -----
    The pressure p* cos(qx) displaces the surface by 2 p* cos(qx) / (E* q) with q = 2π/λ, which
    must flatten the wave.

    References
    ----------
    Johnson, Contact Mechanics (1985), sec. 13.2, doi:10.1017/CBO9781139171731
    """
    require_positive(amplitude=amplitude, wavelength=wavelength, contact_modulus=contact_modulus)
    return math.pi * contact_modulus * amplitude / wavelength


def wavy_half_width(mean_pressure: float, full_contact_pressure: float, wavelength: float) -> float:
    """Return half the width of each contact strip, from ``sin²(πa/λ) = p̄/p*``.

    Parameters
    ----------
    mean_pressure : float
        p̄ [Pa], load over nominal area.
    full_contact_pressure : float
        p* [Pa], see `wavy_full_contact_pressure`.
    wavelength : float
        λ [m].

    Returns
    -------
    float
        Half-width a [m]; λ/2 in full contact.

    Raises
    ------
    InputError
        If an argument is not positive.

    References
    ----------
    Westergaard 1939, doi:10.1115/1.4008919;
    Johnson, Contact Mechanics (1985), sec. 13.2, doi:10.1017/CBO9781139171731

    Examples
    --------
    >>> round(wavy_half_width(mean_pressure=0.5, full_contact_pressure=1.0, wavelength=1.0), 3)
    0.25
    """
    require_positive(wavelength=wavelength)
    ratio = _closing_ratio(mean_pressure, full_contact_pressure)
    return wavelength / math.pi * math.asin(math.sqrt(ratio))


def wavy_pressure(
    x: ArrayLike, mean_pressure: float, full_contact_pressure: float, wavelength: float
) -> Array:
    """Return the contact pressure on a wavy surface.

    Parameters
    ----------
    x : array_like
        Positions [m] across the waves; 0 is a crest.
    mean_pressure : float
        p̄ [Pa], load over nominal area.
    full_contact_pressure : float
        p* [Pa], see `wavy_full_contact_pressure`.
    wavelength : float
        λ [m].

    Returns
    -------
    ndarray, shape of x
        Pressure [Pa], 0 outside the strips.

    Raises
    ------
    InputError
        If an argument is not positive.

    Notes
    -----
    ``2 p* |cos ψ| (sin²ψ_a - sin²ψ)^(1/2)`` with ψ = πx/λ, ψ_a = πa/λ; in full contact
    ``p̄ + p* cos 2ψ``.

    References
    ----------
    Westergaard 1939, doi:10.1115/1.4008919;
    Johnson, Contact Mechanics (1985), sec. 13.2, doi:10.1017/CBO9781139171731
    """
    require_positive(wavelength=wavelength)
    ratio = _closing_ratio(mean_pressure, full_contact_pressure)
    psi = math.pi / wavelength * np.asarray(x, dtype=np.float64)
    strip = np.abs(np.cos(psi)) * np.sqrt(np.maximum(ratio - np.sin(psi) ** 2, 0))
    return 2 * full_contact_pressure * strip + max(mean_pressure - full_contact_pressure, 0.0)


def wavy_gap(
    x: ArrayLike,
    mean_pressure: float,
    full_contact_pressure: float,
    wavelength: float,
    amplitude: float,
) -> Array:
    """Return the gap between a wavy surface and a flat one.

    Parameters
    ----------
    x : array_like
        Positions [m] across the waves; 0 is a crest.
    mean_pressure : float
        p̄ [Pa], load over nominal area.
    full_contact_pressure : float
        p* [Pa], see `wavy_full_contact_pressure`.
    wavelength : float
        λ [m].
    amplitude : float
        Δ [m].

    Returns
    -------
    ndarray, shape of x
        Gap [m], never negative, 0 in the strips.

    Raises
    ------
    InputError
        If an argument is not positive.

    Notes
    -----
    The pressure is the real part of a function that is analytic outside the surface and whose
    imaginary part is (E*/2) dg/dx. So the root of `wavy_pressure` gives the slope
    ``(4 p*/E*) cos ψ (sin²ψ - sin²ψ_a)^(1/2)`` outside, whose integral is
    ``2Δ [s (s² - s_a²)^(1/2) - s_a² arcosh(s/s_a)]`` with ``s = |sin ψ|``.
    """
    require_positive(wavelength=wavelength, amplitude=amplitude)
    s_a = math.sqrt(_closing_ratio(mean_pressure, full_contact_pressure))
    s = np.maximum(np.abs(np.sin(math.pi / wavelength * np.asarray(x, dtype=np.float64))), s_a)
    t = np.sqrt((s - s_a) * (s + s_a))
    # Rounding leaves a few 1e-16 below zero at worst: a gap is never negative.
    return 2 * amplitude * np.maximum(s * t - s_a**2 * np.arcsinh(t / s_a), 0)


def wavy_mean_gap(mean_pressure: float, full_contact_pressure: float, amplitude: float) -> float:
    """Return the mean gap, ``Δ (1 - m + m ln m)`` with m = p̄/p*, 0 in full contact.

    Parameters
    ----------
    mean_pressure : float
        p̄ [Pa], load over nominal area.
    full_contact_pressure : float
        p* [Pa], see `wavy_full_contact_pressure`.
    amplitude : float
        Δ [m].

    Returns
    -------
    float
        Mean gap [m]; Δ minus the mean gap is the approach of the mean planes from first touch.

    Raises
    ------
    InputError
        If an argument is not positive.

    Notes
    -----
    The mean of `wavy_gap` over one wavelength.
    """
    require_positive(amplitude=amplitude)
    ratio = _closing_ratio(mean_pressure, full_contact_pressure)
    return amplitude * (1 - ratio + ratio * math.log(ratio))


def crossed_full_contact_pressure(
    amplitude: float, wavelength: float, contact_modulus: float
) -> float:
    """Return the mean pressure that closes crossed waves, ``p* = √2 π E* Δ/λ``.

    Parameters
    ----------
    amplitude : float
        Δ [m] of the heights Δ cos(2πx/λ) cos(2πy/λ).
    wavelength : float
        λ [m], the period along x and along y.
    contact_modulus : float
        E* [Pa].

    Returns
    -------
    float
        p* [Pa].

    Raises
    ------
    InputError
        If an argument is not positive.

    References
    ----------
    Johnson, Greenwood, Higginson 1985, doi:10.1016/0020-7403(85)90029-3
    """
    return math.sqrt(2) * wavy_full_contact_pressure(amplitude, wavelength, contact_modulus)


def crossed_contact_fraction_light(mean_pressure: float, full_contact_pressure: float) -> float:
    """Return the contact fraction of crossed waves for p̄ ≪ p*, ``π (3p̄/(8πp*))^(2/3)``.

    Parameters
    ----------
    mean_pressure : float
        p̄ [Pa], load over nominal area.
    full_contact_pressure : float
        p* [Pa], see `crossed_full_contact_pressure`.

    Returns
    -------
    float
        Contact area over nominal area; every crest (two per λ²) is a separate Hertz contact with
        the radius of curvature λ²/(4π²Δ).

    Raises
    ------
    InputError
        If an argument is not positive.

    References
    ----------
    Johnson, Greenwood, Higginson 1985, doi:10.1016/0020-7403(85)90029-3
    """
    ratio = _closing_ratio(mean_pressure, full_contact_pressure)
    return float(math.pi * (3 * ratio / (8 * math.pi)) ** (2 / 3))


def crossed_contact_fraction_heavy(mean_pressure: float, full_contact_pressure: float) -> float:
    """Return the contact fraction of crossed waves, p̄ → p*: ``1 - (3/(2π)) (1 - p̄/p*)``.

    Parameters
    ----------
    mean_pressure : float
        p̄ [Pa], load over nominal area.
    full_contact_pressure : float
        p* [Pa], see `crossed_full_contact_pressure`.

    Returns
    -------
    float
        Contact area over nominal area, 1 in full contact; every trough (two per λ²) is a
        separate penny-shaped crack whose stress intensity vanishes.

    Raises
    ------
    InputError
        If an argument is not positive.

    References
    ----------
    Johnson, Greenwood, Higginson 1985, doi:10.1016/0020-7403(85)90029-3
    """
    ratio = _closing_ratio(mean_pressure, full_contact_pressure)
    return 1 - 3 / (2 * math.pi) * (1 - ratio)


def _closing_ratio(mean_pressure: float, full_contact_pressure: float) -> float:
    # p̄/p*, at most 1: beyond full contact only the mean of the pressure grows.
    require_positive(mean_pressure=mean_pressure, full_contact_pressure=full_contact_pressure)
    return min(mean_pressure / full_contact_pressure, 1.0)
