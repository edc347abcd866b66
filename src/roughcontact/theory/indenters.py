"""Sphere with plasticity or with adhesion on a half-space, in closed form.

Displacement is positive into the body, pressure positive in compression. Lengths [m], loads [N],
pressures and moduli [Pa].

References
----------
Johnson, Kendall and Roberts, Proc. R. Soc. A 324 (1971) 301,
doi:10.1098/rspa.1971.0141; Derjaguin, Muller and Toporov, J. Colloid Interface Sci. 53 (1975) 314,
doi:10.1016/0021-9797(75)90018-1; Tabor, ibid. 58 (1977) 2, doi:10.1016/0021-9797(77)90366-6;
Maugis, ibid. 150 (1992) 243, doi:10.1016/0021-9797(92)90285-T; Carpick, Ogletree and Salmeron,
ibid. 211 (1999) 395, doi:10.1006/jcis.1998.6027
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from roughcontact._tools.roots import brentq
from roughcontact.errors import require_positive

PLATEAU = 3.0
"""Mean pressure in full plasticity over the yield strength (Tabor 1951)."""

# Decrease of the distance to the plateau with the logarithm of the index: powers one to three;
# calibration/ceiling_rule.py fits them to solutions with plasticity of the volume.
_FIRST, _SECOND, _THIRD = 1.268, -0.182, 0.0722

# Second power for the ceiling model, whose plateau is the ceiling; fitted there to its solutions.
_CEILING_SQUARE = 2.157


def mean_pressure(index: float, first_yield: float = 1.615) -> float:
    """Return the mean contact pressure over the yield strength.

    Parameters
    ----------
    index : float
        E*a/(σ_Y R); E* is that of the sphere alone on a rigid body.
    first_yield : float
        Hertz peak pressure at first yield over the yield strength C; 1.615 at ν = 0.3.

    Returns
    -------
    float
        p̄/σ_Y, between 0 and 3.

    Raises
    ------
    InputError
        If an argument is not positive.

    Notes
    -----
    4 x/(3π) of the Hertz contact beyond first yield, at the index x₁ = πC/2, up to about twice the
    load of first yield; then the distance to the plateau falls from D = 3 - 2C/3 at first yield as

        p̄/σ_Y = 3 - D exp(-a n l - b l² - c l³),   l = ln(x/x₁),   n = (2C/3)/D.

    With a = 1 the curve would leave the Hertz line at first yield and without a kink. Poisson's
    ratio enters only by the pressure at first yield, and has no effect in full plasticity. a, b and
    c are fitted to solutions with plasticity of the volume for ν from 0 to 0.49 and 4 to 200 times
    the load of first yield, within 2 %.

    Examples
    --------
    >>> [round(mean_pressure(index), 2) for index in (1.0, 5.0, 11.0, 30.0, 100.0)]
    [0.42, 1.74, 2.2, 2.66, 2.95]
    """
    require_positive(index=index, first_yield=first_yield)
    hertz = 4 * index / (3 * math.pi)
    first = math.pi * first_yield / 2
    if index <= first:
        return hertz
    distance = PLATEAU - 2 * first_yield / 3
    steepness = _FIRST * (2 * first_yield / 3) / distance
    way = math.log(index / first)
    fall = math.exp(-way * (steepness + way * (_SECOND + way * _THIRD)))
    return min(hertz, PLATEAU - distance * fall)


def mean_under_ceiling(index: float) -> float:
    """Return the mean pressure of a sphere under a pressure ceiling, over the ceiling.

    Parameters
    ----------
    index : float
        E*a/(p_lim R), with the ceiling p_lim.

    Returns
    -------
    float
        p̄/p_lim, between 0 and 1.

    Raises
    ------
    InputError
        If the index is not positive.

    Notes
    -----
    The Hertz value up to the index π/2, where the ceiling is reached; beyond, a fit to solutions,
    accurate to 0.4 %.

    Examples
    --------
    >>> [round(mean_under_ceiling(index), 3) for index in (1.0, 2.0, 4.0, 10.0)]
    [0.424, 0.819, 0.992, 1.0]
    """
    require_positive(index=index)
    if index <= math.pi / 2:
        return 4 * index / (3 * math.pi)
    way = math.log(2 * index / math.pi)
    return 1 - math.exp(-way * (2 + _CEILING_SQUARE * way)) / 3


def residual_indentation(load_ratio: float) -> tuple[float, float]:
    """Return the residual indentation of a sphere under a pressure ceiling.

    Parameters
    ----------
    load_ratio : float
        Load P over the load P₁ at which the Hertz peak pressure equals the ceiling.

    Returns
    -------
    (float, float)
        Largest residual indentation over the approach ω₁ at P₁, and dissipated energy over
        P₁ ω₁; both zero up to P₁.

    Raises
    ------
    InputError
        If the ratio is not positive.

    Notes
    -----
    With λ = P/P₁ they are λ (1/3 - 0.377 λ^-½ + 0.0437 λ^-3.3) and λ² (1/6 - 0.2205 λ^-½ +
    0.0538 λ^-2.6), fits to solutions that are accurate to 2 % for λ ≥ 2.

    Examples
    --------
    >>> [tuple(round(left, 3) for left in residual_indentation(ratio)) for ratio in (1, 2, 30)]
    [(0.0, 0.0), (0.142, 0.078), (7.935, 113.775)]
    """
    require_positive(load_ratio=load_ratio)
    if load_ratio <= 1:
        return 0.0, 0.0
    root = math.sqrt(load_ratio)
    depth = load_ratio * (1 / 3 - 0.377 / root + 0.0437 / load_ratio**3.3)
    energy = load_ratio**2 * (1 / 6 - 0.2205 / root + 0.0538 / load_ratio**2.6)
    return max(depth, 0.0), max(energy, 0.0)


def ceiling(index: float, mean: float, first_yield: float = 1.615) -> float:
    """Return the ceiling at which a sphere has a given mean pressure.

    Parameters
    ----------
    index : float
        E*a/(σ_Y R), or E*a/R [Pa] if the pressures are in Pa.
    mean : float
        Mean pressure over the yield strength p̄/σ_Y.
    first_yield : float
        Hertz peak pressure at first yield over the yield strength.

    Returns
    -------
    float
        Ceiling over the yield strength; ``first_yield`` before first yield.

    Raises
    ------
    InputError
        If an argument is not positive.

    Notes
    -----
    Shortly after first yield the mean pressure is still that of Hertz, and every ceiling above the
    Hertz peak gives this value. There the ceiling is bounded by p̄ (1 + (p̄₁/p̄)³/2), with p̄₁ the
    mean pressure at first yield, so that it starts from the Hertz peak at first yield and grows
    with the load.

    Examples
    --------
    >>> [round(ceiling(index, mean_pressure(index)), 2) for index in (3.0, 5.0, 11.0, 30.0)]
    [1.66, 1.85, 2.2, 2.66]
    """
    require_positive(index=index, mean=mean, first_yield=first_yield)
    highest = mean * (1 + (2 * first_yield / (3 * mean)) ** 3 / 2)
    if mean <= 2 * first_yield / 3:
        return first_yield
    if highest * mean_under_ceiling(index / highest) <= mean:
        return highest
    result = brentq(lambda limit: limit * mean_under_ceiling(index / limit) - mean, mean, highest)
    return float(result)


ADHESION_RANGE = 0.2e-9
"""Distance z₀ [m] at which two bodies neither attract nor repel each other."""


def tabor(radius: Any, modulus: float, work: float) -> Any:
    """Return the Tabor parameter: elastic deformation by adhesion over the force range.

    Parameters
    ----------
    radius : float or array
        Radius R of the sphere [m].
    modulus : float
        Contact modulus E* [Pa].
    work : float
        Work of adhesion w [J/m²].

    Returns
    -------
    float or array
        μ = (R w²/(E*² z₀³))^(1/3) (Tabor 1977): above 5 the theory of Johnson, Kendall and Roberts
        holds, below 0.1 that of Derjaguin, Muller and Toporov.
    """
    return np.cbrt(radius * (work / modulus) ** 2) / ADHESION_RANGE


def pull_off(radius: Any, modulus: float, work: float) -> Any:
    """Return the pull-off force of a sphere [N].

    Parameters
    ----------
    radius, modulus, work : float or array
        As for `tabor`.

    Returns
    -------
    float or array
        From 1.5 π w R for soft and large spheres (Johnson, Kendall and Roberts 1971) to 2 π w R for
        hard and small spheres (Carpick, Ogletree and Salmeron 1999, eq. 12b).
    """
    strength = 4.04 * _maugis(radius, modulus, work) ** 1.4
    return np.pi * work * radius * (7 / 4 - (strength - 1) / (strength + 1) / 4)


def enlargement(load: Any, radius: Any, modulus: float, work: float) -> Any:
    """Return the ratio of the contact areas of a sphere with and without adhesion.

    Parameters
    ----------
    load : float or array
        Load W [N], positive.
    radius, modulus, work : float or array
        As for `tabor`.

    Returns
    -------
    float or array
        At least 1. After Carpick, Ogletree and Salmeron (1999), eqs. 9, 12a and 13, with a factor
        1.02 omitted, so that the limit is (1 + 3 x + √(6 x + 9 x²))^(2/3) with x = π w R/W for
        soft and large spheres (Johnson, Kendall and Roberts 1971); within 4 % of Maugis (1992).
    """
    strength = _maugis(radius, modulus, work)
    alpha = 1 - np.exp(-strength / 0.924)
    # Contact radius at zero load, over (π w R²/K)^(1/3) with K = 4 E*/3.
    grown = 2.28 * strength**1.3
    start = 1.54 + 0.279 * (grown - 1) / (grown + 1)
    ratio = load / pull_off(radius, modulus, work)
    drawn = (alpha + np.sqrt(1 + ratio)) / (1 + alpha)
    size = start * np.cbrt(np.pi * work * radius / load) * drawn ** (2 / 3)
    return np.maximum(size, 1.0) ** 2


def _maugis(radius: Any, modulus: float, work: float) -> Any:
    """Return the Maugis parameter λ, 1.157 times the Tabor parameter."""
    return 1.157 * tabor(radius, modulus, work)
