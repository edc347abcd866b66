"""Persson theory of the contact of rough surfaces."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from roughcontact._tools.arrays import Array
from roughcontact.errors import InputError, require_positive


def persson_fractions(
    mean_pressure: float, contact_modulus: float, rms_gradient: float, ceiling: float | None = None
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
        Pressure ceiling p_lim [Pa]; without a ceiling the contact is elastic.

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
    With increasing magnification, the distribution P(p) of the pressure spreads from p̄ by
    diffusion with the variance V = (E* h′/2)² of a full contact, and is absorbed at p = 0
    (detached) and at the ceiling (yielded). Elastic: A/A₀ = erf(p̄/√(2V)), with the low-load slope
    √(8/π) ≈ 1.6 in A = κ W/(E* h′). With a ceiling and s_n = nπ/p_lim, the elastic part is
    Σ 2/(nπ) [1 - (-1)ⁿ] sin(s_n p̄) exp(-s_n² V/2) and the yielded part
    Σ 2/(nπ) (-1)ⁿ⁺¹ sin(s_n p̄) [1 - exp(-s_n² V/2)], which tends to p̄/p_lim for rough bodies.
    The theory treats area that has yielded once as saturated, and neglects correlations of the
    contact spots: computed low-load slopes are near 2 (Hyun et al. 2004; Yastrebov,
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
            f"= {mean_pressure / 1e6:.6g} MPa exceeds the ceiling of {ceiling / 1e6:.6g} MPa: "
            "no such load can be carried",
            argument="mean_pressure",
            value=mean_pressure,
        )
    item = (np.array([value]) for value in (mean_pressure, deviation, ceiling))
    contact, saturated = diffuse_fractions(*item)
    return float(contact[0]), float(saturated[0])


def diffuse_fractions(pressure: Array, deviation: Array, ceiling: Array) -> tuple[Array, Array]:
    """Return Persson's fractions of several contacts; see `persson_fractions`.

    Parameters
    ----------
    pressure : ndarray
        Load over nominal area p̄, in any unit.
    deviation : ndarray
        √V = E* h′/2, the standard deviation of the pressure of a full contact, in the same unit.
    ceiling : ndarray
        Pressure ceiling, in the same unit; infinite without one.

    Returns
    -------
    (ndarray, ndarray)
        Contact area (saturated area included) and saturated area over nominal area.

    Notes
    -----
    Two forms of the same sum: images of the initial distribution beyond both bounds if the spread
    is small, the series of `persson_fractions` if it is large. At the transition, √V = p_lim/2,
    both are exact to rounding with the included terms.
    """
    contact, saturated = np.empty_like(pressure), np.empty_like(pressure)
    near = 2 * deviation < ceiling
    for chosen, form in ((near, _by_images), (~near, _by_waves)):
        if chosen.any():
            specified = (values[chosen] for values in (pressure, deviation, ceiling))
            contact[chosen], saturated[chosen] = form(*specified)
    # Rounding may exceed the possible range.
    np.clip(saturated, 0, 1, out=saturated)
    np.clip(contact, saturated, 1, out=contact)
    return contact, saturated


# Terms below exp(-40) are negligible.
_IMAGES, _WAVES = np.arange(1, 5)[:, None], np.arange(1, 9)[:, None]


def _by_images(pressure: Array, deviation: Array, ceiling: Array) -> tuple[Array, Array]:
    """Return contact and saturated fractions of narrow distributions between the bounds.

    The absorbed fractions follow from the times of first passage, by the method of images
    (Redner, A Guide to First-Passage Processes (2001), doi:10.1017/CBO9780511606014).
    """
    from scipy.special import erf, erfc

    spread = math.sqrt(2) * deviation
    beyond = 2 * _IMAGES * ceiling
    contact = erf(pressure / spread) - np.sum(
        erfc((beyond + pressure) / spread) - erfc((beyond - pressure) / spread), axis=0
    )
    odd = (2 * _IMAGES - 1) * ceiling
    saturated = np.sum(erfc((odd - pressure) / spread) - erfc((odd + pressure) / spread), axis=0)
    return contact, saturated


def _by_waves(pressure: Array, deviation: Array, ceiling: Array) -> tuple[Array, Array]:
    """Return both fractions of wide distributions, by the series of `persson_fractions`."""
    terms = (
        2
        / (_WAVES * math.pi)
        * np.sin(_WAVES * math.pi * pressure / ceiling)
        * np.exp(-((_WAVES * math.pi * deviation / ceiling) ** 2) / 2)
    )
    sign = np.where(_WAVES % 2, 1.0, -1.0)
    # The constant part of the yielded series is p̄/p_lim.
    saturated = pressure / ceiling - np.sum(sign * terms, axis=0)
    return np.sum((1 + sign) * terms, axis=0) + saturated, saturated


GAMMA = 0.45
"""γ of `persson_separation`: ratio of the elastic energy of partial contact to the first form of
Persson of 2001; 0.4 to 0.5 fit simulations."""

# Points of the quadratures: over the waves of a shell, and over the scaled pressure.
_IN_SHELL, _TABLE = 16, 4096
# Scaled pressures below which the integrand equals its limit, and above which it vanishes.
_LEAST, _MOST = 1e-6, 6.5


def persson_separation(
    mean_pressure: ArrayLike,
    contact_modulus: float,
    wave_numbers: ArrayLike,
    variances: ArrayLike,
    gamma: float = GAMMA,
) -> Array:
    """Return Persson's separation of the mean planes of an elastic rough contact.

    Parameters
    ----------
    mean_pressure : array_like, shape (n,)
        Load over nominal area p̄ [Pa], positive.
    contact_modulus : float
        E* [Pa].
    wave_numbers : array_like, shape (k,)
        q of the shells of the spectrum of the gap [rad/m], ascending.
    variances : array_like, shape (k,)
        Variance of height in each shell [m²]; their sum is Sq².
    gamma : float
        γ: 1 for the first form of the theory, about 0.45 by comparison with simulations.

    Returns
    -------
    ndarray, shape (n,)
        Separation ū [m]; infinite where p̄ is 0.

    Raises
    ------
    InputError
        If modulus or γ is not positive.

    Notes
    -----
    With 2π q C dq = dm the variance of height between q and q + dq,

        ū(p̄) = √π ∫ dq q² C w ∫_p̄^∞ dp/p [γ + 3 (1 - γ) erf²(w p/E*)] exp(-(w p/E*)²),

    w(q) = (½ ∫_0^q q² dm)^(-½). It follows from the elastic energy per area
    U = (π/2) E* ∫ q² C W dq, W = P [γ + (1 - γ) P²] with P = erf(w p̄/E*), by p̄ = -dU/dū. At small
    p̄ it is ū = -u₀ ln p̄ + const with the u₀ of `persson_decay`. The variance of a shell is added
    gradually, as if spread over the shell.

    References
    ----------
    Persson 2007, Phys. Rev. Lett. 99, 125502, doi:10.1103/PhysRevLett.99.125502
    Yang and Persson 2008, J. Phys.: Condens. Matter 20, 215214,
    doi:10.1088/0953-8984/20/21/215214
    Almqvist, Campañá, Prodanov and Persson 2011, doi:10.1016/j.jmps.2011.08.004
    """
    require_positive(contact_modulus=contact_modulus, gamma=gamma)
    p = np.atleast_1d(np.asarray(mean_pressure, dtype=np.float64))
    strengths, scales = _weights(wave_numbers, variances)
    argument = np.multiply.outer(p, scales / contact_modulus)
    with np.errstate(divide="ignore"):
        result: Array = (_inner(argument, gamma) * strengths).sum(axis=-1)
    return result


def persson_decay(wave_numbers: ArrayLike, variances: ArrayLike, gamma: float = GAMMA) -> float:
    """Return the length u₀ of Persson's p̄ ∝ exp(-ū/u₀) at small pressure [m].

    Parameters
    ----------
    wave_numbers, variances, gamma
        As for `persson_separation`.

    Returns
    -------
    float
        u₀ = √π γ ∫ q² C w dq; about γ Sq for a spectrum of at least one decade.
    """
    strengths, _ = _weights(wave_numbers, variances)
    return float(gamma * strengths.sum())


def _weights(wave_numbers: ArrayLike, variances: ArrayLike) -> tuple[Array, Array]:
    """Return q dm w/(2 √π) and w of the quadrature points of all shells."""
    q, m = (np.asarray(x, dtype=np.float64) for x in (wave_numbers, variances))
    slopes = q**2 * m
    before = np.concatenate([[0.0], np.cumsum(slopes)[:-1]])
    # With the share of a shell as t², the root of the first shell is no longer singular.
    t, weight = np.polynomial.legendre.leggauss(_IN_SHELL)
    t, weight = (t + 1) / 2, weight / 2
    total = before[:, None] + slopes[:, None] * t**2
    there = m > 0
    w = 1 / np.sqrt(total[there] / 2)
    strengths = (q * m)[there, None] * 2 * t * weight * w / (2 * math.sqrt(math.pi))
    return strengths.ravel(), w.ravel()


def _inner(argument: Array, gamma: float) -> Array:
    """Return ∫_x^∞ [γ + 3 (1 - γ) erf²(t)] exp(-t²) dt/t, from a table over ln x."""
    from scipy.special import erf, exp1

    edges = np.linspace(math.log(_LEAST), math.log(_MOST), _TABLE)
    t = np.exp((edges[1:] + edges[:-1]) / 2)
    pieces = 3 * (1 - gamma) * erf(t) ** 2 * np.exp(-(t**2)) * np.diff(edges)
    beyond = np.concatenate([np.cumsum(pieces[::-1])[::-1], [0.0]])
    log = np.log(np.maximum(argument, 1e-300))
    second = np.interp(log, edges, beyond)
    return gamma * exp1(argument**2) / 2 + second
