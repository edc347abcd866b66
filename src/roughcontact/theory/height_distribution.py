"""Height distributions with given skewness and kurtosis: the Johnson system.

Heights are functions of a standard normal variable ``z``, so that a Gaussian map gets the
distribution by a pointwise transformation (translation).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from roughcontact._tools.arrays import Array
from roughcontact._tools.roots import brentq
from roughcontact.errors import InputError, input_error

STEP = 0.3
"""Minimum excess of the kurtosis over its lower bound Ssk² + 1.

A surface at the bound has only two heights with a cliff between them, which no spectrum of a rough
surface has.
"""

MAX_KURTOSIS = 60.0
"""Maximum kurtosis: above, a map of a million points has too few of the peaks that set it."""

# Normal variables and weights for averages over the distribution.
_Z = np.linspace(-12, 12, 1201)
_WEIGHTS = np.exp(-0.5 * _Z**2)
_WEIGHTS /= _WEIGHTS.sum()

# Shapes δ from two heights (bounded) or infinite tails (unbounded) to the normal distribution.
_SHAPES = {"bounded": (0.02, 200.0), "unbounded": (0.35, 200.0)}
# Largest γ/δ and γ of the search: S_U and S_B become lognormal below the first, and S_B a peak of
# zero width below the second.
_STEEPEST, _FARTHEST = 40.0, 8.0
# Tolerance of skewness and kurtosis for a family of one parameter.
_KURTOSIS_TOLERANCE = 1e-3


@dataclass(frozen=True)
class Johnson:
    """Translation of the standard normal variable to a height distribution.

    Parameters
    ----------
    family : {"normal", "lognormal", "unbounded", "bounded"}
        Johnson's S_N, S_L, S_U and S_B.
    gamma, delta : float
        Location and shape, for u = (z - γ)/δ: the height is u, exp u, sinh u or
        1/(1 + exp(-u)), up to a scale.
    mirrored : bool
        Whether heights and z change their signs, for negative skewness.

    References
    ----------
    Johnson 1949, doi:10.1093/biomet/36.1-2.149
    """

    family: str
    gamma: float
    delta: float
    mirrored: bool = False

    def heights(self, z: Array) -> Array:
        """Return the heights of normal variables, increasing, of arbitrary mean and scale."""
        sign = -1.0 if self.mirrored else 1.0
        return sign * _FORMS[self.family]((sign * z - self.gamma) / self.delta)


def least_kurtosis(skewness: float) -> float:
    """Return the minimum kurtosis of a distribution with a skewness, that of two heights."""
    return skewness**2 + 1


def usual_kurtosis(skewness: float) -> float:
    """Return the kurtosis of a gamma distribution with this skewness; 3 at zero skewness."""
    return 3 + 1.5 * skewness**2


def fit_johnson(skewness: float, kurtosis: float) -> Johnson:
    """Return the distribution of the Johnson system with given skewness and kurtosis.

    Parameters
    ----------
    skewness, kurtosis : float
        Ssk and Sku, which is 3 for a Gaussian surface; a pair that `require` accepts.

    Returns
    -------
    Johnson
        The translation; there is exactly one.

    Examples
    --------
    >>> [fit_johnson(*pair).family for pair in ((0.0, 3.0), (-1.0, 6.0), (0.0, 1.8))]
    ['normal', 'unbounded', 'bounded']
    """
    strength = abs(skewness)
    if strength < _KURTOSIS_TOLERANCE and abs(kurtosis - 3) < _KURTOSIS_TOLERANCE:
        return Johnson("normal", 0.0, 1.0)
    lognormal, shape = _lognormal(strength)
    if abs(kurtosis - lognormal) < _KURTOSIS_TOLERANCE:
        return Johnson("lognormal", 0.0, shape, skewness < 0)
    family = "unbounded" if kurtosis > lognormal else "bounded"
    return _solve_two_parameters(family, skewness, kurtosis)


def require(skewness: float, kurtosis: float, families: int = 1) -> None:
    """Raise `InputError` for a pair that no distribution or no rough surface has.

    Parameters
    ----------
    skewness, kurtosis : float
        Ssk and Sku.
    families : int
        Number of independent maps of one distribution that are added to the map.
    """
    if not math.isfinite(skewness):
        raise input_error("Ssk", skewness, "must be finite")
    minimum = least_kurtosis(skewness)
    if not minimum < kurtosis < math.inf:
        raise input_error(
            "Sku",
            kurtosis,
            f"must exceed Ssk² + 1 = {minimum:.4g}, as that of any distribution does",
        )
    reached = kurtosis_of_mean(least_kurtosis(skewness * math.sqrt(families)) + STEP, families)
    if kurtosis < reached:
        what = "a translated Gaussian surface" if families == 1 else "a sum of two groove patterns"
        raise InputError(
            f"must be at least {reached:.4g} with Ssk = {skewness:g}, got {kurtosis!r}: below, "
            f"cliffs part two heights, which {what} does not have",
            argument="Sku",
            value=kurtosis,
        )
    if kurtosis > MAX_KURTOSIS:
        raise InputError(
            f"must be at most {MAX_KURTOSIS:g}, got {kurtosis!r}: beyond, single points make "
            "the kurtosis",
            argument="Sku",
            value=kurtosis,
        )


def kurtosis_of_mean(kurtosis: float, families: int) -> float:
    """Return the kurtosis of the mean of independent maps, each with this kurtosis."""
    return 3 + (kurtosis - 3) / families


def moments(values: Array, weights: Array | None = None) -> tuple[float, float]:
    """Return the skewness and the kurtosis of values.

    Parameters
    ----------
    values : ndarray
        The values.
    weights : ndarray, optional
        Weights of the same shape, with a sum of 1; equal by default.

    Returns
    -------
    (float, float)
        Skewness and kurtosis about the mean; 3 is the kurtosis of a normal distribution.
    """
    deviation = values - np.average(values, weights=weights)
    square = deviation * deviation
    variance = float(np.average(square, weights=weights))
    third = float(np.average(square * deviation, weights=weights))
    fourth = float(np.average(square * square, weights=weights))
    return third / variance**1.5, fourth / variance**2


def _sigmoid(u: Array) -> Array:
    # Also exact far below zero, where skewed distributions have most of their heights.
    from scipy.special import expit

    return expit(u)


_FORMS: dict[str, Callable[[Array], Array]] = {
    "normal": lambda u: u,
    "lognormal": np.exp,
    "unbounded": np.sinh,
    "bounded": _sigmoid,
}


def _lognormal(skewness: float) -> tuple[float, float]:
    """Return the kurtosis of the lognormal distribution of a skewness ≥ 0, and its shape δ."""
    if skewness < _KURTOSIS_TOLERANCE:
        return 3.0, math.inf
    # The only real root w > 1 of (w - 1)(w + 2)² = skewness².
    w = float(max(np.roots([1, 3, 0, -4 - skewness**2]).real))
    return w**4 + 2 * w**3 + 3 * w**2 - 3, 1 / math.sqrt(math.log(w))


def _solve_two_parameters(family: str, skewness: float, kurtosis: float) -> Johnson:
    """Return the member of a family with skewness and kurtosis, by nested roots in δ and γ."""
    strength = abs(skewness)

    def located(delta: float) -> Johnson:
        # Skewness increases with -γ in S_U and with γ in S_B, from 0 at γ = 0.
        sign = -1.0 if family == "unbounded" else 1.0

        def skewness_error(gamma: float) -> float:
            return moments(Johnson(family, sign * gamma, delta).heights(_Z), _WEIGHTS)[0] - strength

        top = 1.0
        while skewness_error(top) < 0 and top < max(_STEEPEST * delta, _FARTHEST):
            top *= 2
        if strength < _KURTOSIS_TOLERANCE or skewness_error(top) < 0:
            return Johnson(family, 0.0 if strength < _KURTOSIS_TOLERANCE else sign * top, delta)
        return Johnson(family, sign * brentq(skewness_error, 0.0, top, xtol=1e-6), delta)

    def excess(logarithm: float) -> float:
        result = located(math.exp(logarithm))
        return moments(result.heights(_Z), _WEIGHTS)[1] - kurtosis

    # The lognormal distribution of this skewness bounds the shapes that can have it.
    low, high = _SHAPES[family]
    low, high = math.log(low), math.log(min(high, _lognormal(strength)[1]))
    result = located(math.exp(brentq(excess, low, high, xtol=1e-5)))
    return Johnson(family, result.gamma, result.delta, skewness < 0)


# Normal scores for integrals over the heights, and the volume below each.
_SCORES = np.linspace(-9, 9, 7201)


def gap_below_plane(material_ratio: Array, skewness: Array, kurtosis: Array) -> Array:
    """Return the mean open gap between a truncating plane and the surface, over Sq.

    Parameters
    ----------
    material_ratio : ndarray
        Share of the surface above the plane, in (0, 1).
    skewness, kurtosis : ndarray
        Ssk and Sku of the heights, of the same shape.

    Returns
    -------
    ndarray
        Mean over the whole surface of the depth below the plane, 0 where the surface is above, over
        the root-mean-square height.

    Notes
    -----
    This is the gap of a surface whose asperities are flattened to the plane and displace nothing
    else: the limit of a very low ceiling. Heights follow the distribution of the Johnson system
    with this skewness and kurtosis, h(z) of a standard normal variable z; the mean gap below the
    plane at z_p is ∫ max(h(z_p) - h(z), 0) φ(z) dz, by the trapezoidal rule.

    References
    ----------
    Johnson 1949, doi:10.1093/biomet/36.1-2.149

    Examples
    --------
    >>> gap_below_plane(np.array([0.5]), np.array([0.0]), np.array([3.0])).round(5)
    array([0.39894])
    """
    from scipy.special import ndtri

    result = np.empty_like(material_ratio)
    planes = -ndtri(material_ratio)
    pairs, number = np.unique(np.stack([skewness, kurtosis]), axis=1, return_inverse=True)
    for place, (third, fourth) in enumerate(pairs.T):
        chosen = number.ravel() == place
        result[chosen] = np.interp(planes[chosen], _SCORES, _gaps(float(third), float(fourth)))
    return result


@lru_cache(maxsize=512)
def _gaps(skewness: float, kurtosis: float) -> Array:
    """Return the mean gap below planes at all normal scores, over Sq."""
    heights = fit_johnson(skewness, kurtosis).heights(_SCORES)
    density = np.exp(-(_SCORES**2) / 2) / math.sqrt(2 * math.pi)
    step = float(_SCORES[1] - _SCORES[0])
    mean = float(np.sum(heights * density)) * step
    spread = math.sqrt(float(np.sum((heights - mean) ** 2 * density)) * step)
    # The gap grows by the area below a plane times the rise of the plane.
    below = np.cumsum(density) * step - density * step / 2
    rises = np.diff(heights) / spread
    return np.concatenate([[0.0], np.cumsum((below[1:] + below[:-1]) / 2 * rises)])
