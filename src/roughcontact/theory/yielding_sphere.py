"""An elastic, perfectly plastic sphere on a half-space, from first yield to full plasticity.

Mean pressures are over the yield strength σ_Y. The index E*a/(σ_Y R) is the strain of the contact
over the yield strain: a radius of the contact, R of the sphere (Johnson 1985, section 6.3).
"""

from __future__ import annotations

import math

from roughcontact.errors import require_positive
from roughcontact.roots import brentq

PLATEAU = 3.0
"""Mean pressure in full plasticity over the yield strength (Tabor 1951)."""

# How the distance to the plateau falls with the logarithm of the index: powers one to three;
# benchmarks/ceiling_rule.py fits them again to solutions with plasticity of the volume.
_FIRST, _SECOND, _THIRD = 1.268, -0.182, 0.0722

# The same of the ceiling model, whose plateau is the ceiling; fitted to its solutions there.
_CEILING_SQUARE = 2.157


def mean_pressure(index: float, first_yield: float = 1.615) -> float:
    """Return the mean contact pressure over the yield strength.

    Parameters
    ----------
    index : float
        E*a/(σ_Y R); E* of the sphere alone if what it is pressed on is rigid.
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
    Hertz's 4 x/(3π) well beyond first yield, at the index x₁ = πC/2, up to about twice its load;
    then the distance to the plateau falls from D = 3 - 2C/3 at first yield as

        p̄/σ_Y = 3 - D exp(-a n l - b l² - c l³),   l = ln(x/x₁),   n = (2C/3)/D.

    With a = 1 it would leave Hertz's line at first yield and without a kink. So Poisson's ratio
    enters by the pressure at first yield alone, and is forgotten in full plasticity. a, b and c
    are fitted to solutions with plasticity of the volume for ν from 0 to 0.49 and 4 to 200 times
    the load of first yield, and within 2 % of them.

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
    """Return the mean contact pressure of a sphere under a pressure ceiling, over the ceiling.

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
    Hertz's up to the index π/2, where the ceiling is reached; beyond it a fit to solutions, right
    to 0.4 %.

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


def left_under_ceiling(load_ratio: float) -> tuple[float, float]:
    """Return what a sphere under a pressure ceiling leaves behind.

    Parameters
    ----------
    load_ratio : float
        Load P over the load P₁ at which Hertz's peak pressure is the ceiling.

    Returns
    -------
    (float, float)
        Largest permanent indentation over the approach ω₁ at P₁, and dissipated energy over
        P₁ ω₁; both zero up to P₁.

    Raises
    ------
    InputError
        If the ratio is not positive.

    Notes
    -----
    With λ = P/P₁ they are λ (1/3 - 0.377 λ^-½ + 0.0437 λ^-3.3) and λ² (1/6 - 0.2205 λ^-½ +
    0.0538 λ^-2.6), fits to solutions that are right to 2 % from λ = 2 on.

    Examples
    --------
    >>> [tuple(round(left, 3) for left in left_under_ceiling(ratio)) for ratio in (1, 2, 30)]
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
    """Return the ceiling that gives a sphere its mean pressure.

    Parameters
    ----------
    index : float
        E*a/(σ_Y R); or E*a/R [Pa] with the pressures in Pa.
    mean : float
        Mean pressure over the yield strength p̄/σ_Y.
    first_yield : float
        Hertz peak pressure at first yield over the yield strength.

    Returns
    -------
    float
        Ceiling over the yield strength; that of first yield before it.

    Raises
    ------
    InputError
        If an argument is not positive.

    Notes
    -----
    Soon after first yield the mean pressure is still Hertz's, and every ceiling above Hertz's peak
    gives it. There the ceiling is bounded by p̄ (1 + (p̄₁/p̄)³/2), with p̄₁ the mean pressure at first
    yield, so that it begins with Hertz's peak at first yield and grows with the load.

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
    found = brentq(lambda limit: limit * mean_under_ceiling(index / limit) - mean, mean, highest)
    return float(found)
