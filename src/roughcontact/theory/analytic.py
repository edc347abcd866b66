"""Closed-form contacts besides Hertz: wavy surfaces, flat punch, cone, Persson's theory.

Displacement is positive into the body, pressure positive in compression. Lengths [m], loads [N],
pressures and moduli [Pa]. A wavy surface has the heights ``Δ cos(2πx/λ)``, a crossed one
``Δ cos(2πx/λ) cos(2πy/λ)``, so that Δ is half its peak-to-valley height.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact.errors import InputError, require_positive

Array = NDArray[np.float64]


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
    The pressure p* cos(qx) displaces the surface by 2 p* cos(qx) / (E* q) with q = 2π/λ, and has
    to flatten the wave.

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
    """Return the gap left between a wavy surface and a flat one.

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
    The pressure is the real part of a function that is analytic off the surface and whose
    imaginary part is (E*/2) dg/dx. The root of `wavy_pressure` hence gives the slope
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
        Mean gap [m]; Δ minus it is the approach of the mean planes from first touch.

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
    """Return the contact fraction of crossed waves for p̄ → p*, ``1 - (3/(2π)) (1 - p̄/p*)``.

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


def punch_load(approach: float, contact_radius: float, contact_modulus: float) -> float:
    """Return the load on a flat circular punch, ``W = 2 a E* δ``.

    Parameters
    ----------
    approach : float
        Approach δ [m].
    contact_radius : float
        Radius of the punch a [m].
    contact_modulus : float
        E* [Pa].

    Returns
    -------
    float
        Normal load W [N].

    Raises
    ------
    InputError
        If an argument is not positive.

    References
    ----------
    Johnson, Contact Mechanics (1985), eqs. (3.34) to (3.36), doi:10.1017/CBO9781139171731
    """
    require_positive(
        approach=approach, contact_radius=contact_radius, contact_modulus=contact_modulus
    )
    return 2 * contact_radius * contact_modulus * approach


def punch_pressure(r: ArrayLike, load: float, contact_radius: float) -> Array:
    """Return the pressure under a flat circular punch, ``W/(2πa²) (1 - r²/a²)^(-1/2)``.

    Parameters
    ----------
    r : array_like
        Distances from the axis [m].
    load : float
        Normal load W [N].
    contact_radius : float
        Radius of the punch a [m].

    Returns
    -------
    ndarray, shape of r
        Pressure [Pa], without bound towards the rim, 0 on and outside it.

    Raises
    ------
    InputError
        If the load or the radius is not positive.

    References
    ----------
    Johnson, Contact Mechanics (1985), eq. (3.34), doi:10.1017/CBO9781139171731
    """
    require_positive(load=load, contact_radius=contact_radius)
    rho = np.abs(np.asarray(r, dtype=np.float64)) / contact_radius
    root = np.sqrt(np.maximum((1 - rho) * (1 + rho), 0))
    unit = np.divide(1.0, root, out=np.zeros_like(root), where=root > 0)
    return load / (2 * math.pi * contact_radius**2) * unit


def punch_displacement(r: ArrayLike, approach: float, contact_radius: float) -> Array:
    """Return the surface displacement by a flat circular punch, ``(2δ/π) asin(a/r)`` outside.

    Parameters
    ----------
    r : array_like
        Distances from the axis [m].
    approach : float
        Approach δ [m].
    contact_radius : float
        Radius of the punch a [m].

    Returns
    -------
    ndarray, shape of r
        Displacement [m] into the body, δ under the punch.

    Raises
    ------
    InputError
        If the radius is not positive.

    References
    ----------
    Sneddon 1965, doi:10.1016/0020-7225(65)90019-4;
    Johnson, Contact Mechanics (1985), eq. (3.37), doi:10.1017/CBO9781139171731
    """
    require_positive(contact_radius=contact_radius)
    rho = np.maximum(np.abs(np.asarray(r, dtype=np.float64)) / contact_radius, 1)
    return 2 * approach / math.pi * np.arcsin(1 / rho)


def cone_contact_radius(load: float, slope: float, contact_modulus: float) -> float:
    """Return the contact radius of a cone, ``a = (2 W / (π E* m))^(1/2)``.

    Parameters
    ----------
    load : float
        Normal load W [N].
    slope : float
        Slope m of the shape m·r: the cotangent of the half-angle at the tip.
    contact_modulus : float
        E* [Pa].

    Returns
    -------
    float
        a [m].

    Raises
    ------
    InputError
        If an argument is not positive.

    References
    ----------
    Johnson, Contact Mechanics (1985), sec. 5.2, doi:10.1017/CBO9781139171731
    """
    require_positive(load=load)
    return math.sqrt(load / (math.pi * cone_mean_pressure(slope, contact_modulus)))


def cone_mean_pressure(slope: float, contact_modulus: float) -> float:
    """Return the mean pressure under a cone, ``E* m / 2`` at every load.

    Parameters
    ----------
    slope : float
        Slope m of the shape m·r.
    contact_modulus : float
        E* [Pa].

    Returns
    -------
    float
        Load over contact area [Pa].

    Raises
    ------
    InputError
        If an argument is not positive.

    References
    ----------
    Love 1939, doi:10.1093/qmath/os-10.1.161;
    Johnson, Contact Mechanics (1985), sec. 5.2, doi:10.1017/CBO9781139171731
    """
    require_positive(slope=slope, contact_modulus=contact_modulus)
    return contact_modulus * slope / 2


def cone_approach(contact_radius: float, slope: float) -> float:
    """Return the approach of a cone, ``δ = π a m / 2``.

    Parameters
    ----------
    contact_radius : float
        a [m].
    slope : float
        Slope m of the shape m·r.

    Returns
    -------
    float
        δ [m] from first touch.

    Raises
    ------
    InputError
        If an argument is not positive.

    References
    ----------
    Sneddon 1965, doi:10.1016/0020-7225(65)90019-4
    """
    require_positive(contact_radius=contact_radius, slope=slope)
    return math.pi * contact_radius * slope / 2


def cone_load(approach: float, slope: float, contact_modulus: float) -> float:
    """Return the load at a given approach of a cone, ``W = 2 E* δ² / (π m)``.

    Parameters
    ----------
    approach : float
        δ [m] from first touch.
    slope : float
        Slope m of the shape m·r.
    contact_modulus : float
        E* [Pa].

    Returns
    -------
    float
        Normal load W [N].

    Raises
    ------
    InputError
        If an argument is not positive.

    References
    ----------
    Sneddon 1965, doi:10.1016/0020-7225(65)90019-4
    """
    require_positive(approach=approach, slope=slope, contact_modulus=contact_modulus)
    return 2 * contact_modulus * approach**2 / (math.pi * slope)


def cone_pressure(r: ArrayLike, contact_radius: float, mean_pressure: float) -> Array:
    """Return the pressure under a cone, ``p̄ arcosh(a/r)`` inside and 0 outside.

    Parameters
    ----------
    r : array_like
        Distances from the axis [m].
    contact_radius : float
        a [m].
    mean_pressure : float
        p̄ [Pa], see `cone_mean_pressure`.

    Returns
    -------
    ndarray, shape of r
        Pressure [Pa], infinite at the tip.

    Raises
    ------
    InputError
        If the contact radius is not positive.

    References
    ----------
    Love 1939, doi:10.1093/qmath/os-10.1.161;
    Johnson, Contact Mechanics (1985), sec. 5.2, doi:10.1017/CBO9781139171731
    """
    require_positive(contact_radius=contact_radius)
    rho = np.abs(np.asarray(r, dtype=np.float64)) / contact_radius
    inverse = np.divide(1.0, rho, out=np.full_like(rho, np.inf), where=rho > 0)
    return mean_pressure * np.arccosh(np.maximum(inverse, 1))


def cone_displacement(r: ArrayLike, contact_radius: float, slope: float) -> Array:
    """Return the surface displacement by a cone, inside and outside the contact.

    Parameters
    ----------
    r : array_like
        Distances from the axis [m].
    contact_radius : float
        a [m].
    slope : float
        Slope m of the shape m·r.

    Returns
    -------
    ndarray, shape of r
        Displacement [m] into the body: ``δ - m r`` inside,
        ``m [a asin(a/r) + (r² - a²)^(1/2) - r]`` outside.

    Raises
    ------
    InputError
        If an argument is not positive.

    References
    ----------
    Sneddon 1965, doi:10.1016/0020-7225(65)90019-4
    """
    require_positive(contact_radius=contact_radius, slope=slope)
    rho = np.abs(np.asarray(r, dtype=np.float64)) / contact_radius
    outside = np.maximum(rho, 1)
    root = np.sqrt((outside - 1) * (outside + 1))
    unit: Array = np.arcsin(1 / outside) + root - rho
    return slope * contact_radius * unit


def _closing_ratio(mean_pressure: float, full_contact_pressure: float) -> float:
    # p̄/p*, capped at 1: beyond full contact only the mean of the pressure still grows.
    require_positive(mean_pressure=mean_pressure, full_contact_pressure=full_contact_pressure)
    return min(mean_pressure / full_contact_pressure, 1.0)


def persson_fractions(
    mean_pressure: float,
    contact_modulus: float,
    rms_gradient: float,
    ceiling: float | None = None,
) -> tuple[float, float]:
    """Return Persson's fractions of the nominal area in contact and at the ceiling.

    Parameters
    ----------
    mean_pressure : float
        Load over nominal area p̄ [Pa].
    contact_modulus : float
        E* [Pa].
    rms_gradient : float
        Root-mean-square gradient h′ of the gap between the bodies.
    ceiling : float, optional
        Largest pressure p_lim [Pa]; without it the contact is elastic.

    Returns
    -------
    (float, float)
        Contact area (saturated area included) and saturated area over nominal area.

    Raises
    ------
    InputError
        If an argument is not positive, or the ceiling is below the mean pressure.

    Notes
    -----
    Magnified more and more, the distribution P(p) of the pressure spreads from p̄ by diffusion with
    the variance V = (E* h′/2)² of a full contact, and is absorbed at p = 0 (detached) and at the
    ceiling (yielded). Elastic: A/A₀ = erf(p̄/√(2V)), with the low-load slope √(8/π) ≈ 1.6 in
    A = κ W/(E* h′). With a ceiling and s_n = nπ/p_lim, the elastic part is
    Σ 2/(nπ) [1 - (-1)ⁿ] sin(s_n p̄) exp(-s_n² V/2) and the yielded one
    Σ 2/(nπ) (-1)ⁿ⁺¹ sin(s_n p̄) [1 - exp(-s_n² V/2)], which tends to p̄/p_lim for rough bodies.
    The theory counts what has once yielded as saturated, and neglects correlations of the
    contact spots: boundary elements give a low-load slope near 2 (Hyun et al. 2004; Yastrebov,
    Anciaux and Molinari 2015).

    References
    ----------
    Persson 2001, J. Chem. Phys. 115, 3840, doi:10.1063/1.1388626
    Hyun, Pei, Molinari and Robbins 2004, doi:10.1103/PhysRevE.70.026117
    Yastrebov, Anciaux and Molinari 2015, doi:10.1016/j.ijsolstr.2014.09.019

    Examples
    --------
    >>> contact, saturated = persson_fractions(1e6, 100e9, 0.1)
    >>> round(contact / (1e6 / (100e9 * 0.1)), 3), saturated
    (1.596, 0.0)
    """
    require_positive(
        mean_pressure=mean_pressure, contact_modulus=contact_modulus, rms_gradient=rms_gradient
    )
    deviation = contact_modulus * rms_gradient / 2
    if ceiling is None:
        return math.erf(mean_pressure / (math.sqrt(2) * deviation)), 0.0
    require_positive(ceiling=ceiling)
    if mean_pressure > ceiling:
        raise InputError(
            f"= {mean_pressure:.6g} Pa exceeds the ceiling of {ceiling:.6g} Pa: "
            "no such load can be carried",
            argument="mean_pressure",
        )
    # Terms beyond exp(-40) do not count; the plain part of the yielded series is p̄/p_lim.
    last = math.ceil(math.sqrt(80) * ceiling / (math.pi * deviation)) + 1
    n = np.arange(1, last + 1)
    terms = (
        2 / (n * math.pi)
        * np.sin(n * math.pi * mean_pressure / ceiling)
        * np.exp(-((n * math.pi * deviation / ceiling) ** 2) / 2)
    )  # fmt: skip
    sign = np.where(n % 2, 1.0, -1.0)
    elastic = float(np.sum((1 + sign) * terms))
    yielded = mean_pressure / ceiling - float(np.sum(sign * terms))
    return min(elastic + max(yielded, 0.0), 1.0), min(max(yielded, 0.0), 1.0)
