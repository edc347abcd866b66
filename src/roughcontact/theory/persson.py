"""Persson's theory of the contact of rough surfaces."""

from __future__ import annotations

import math

import numpy as np

from roughcontact.errors import InputError, require_positive


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
            value=mean_pressure,
        )
    elastic, yielded = _between_bounds(mean_pressure, deviation, ceiling)
    return min(elastic + max(yielded, 0.0), 1.0), min(max(yielded, 0.0), 1.0)


def _between_bounds(mean_pressure: float, deviation: float, ceiling: float) -> tuple[float, float]:
    """Return the fractions between zero and the ceiling, and absorbed at the ceiling."""
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
    return elastic, yielded
