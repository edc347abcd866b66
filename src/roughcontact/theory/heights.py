"""Heights of a surface cut by a plane: share above it, and the gap below."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Below this skewness heights count as normal: the gap differs by at most 2e-3 of Sq.
_NORMAL = 1e-3


def gap_below_plane(material_ratio: Array, skewness: Array) -> Array:
    """Return the mean open gap between a plane and the surface that it cuts off, over Sq.

    Parameters
    ----------
    material_ratio : ndarray
        Share of the surface above the plane, in (0, 1).
    skewness : ndarray
        Ssk of the heights, of the same shape.

    Returns
    -------
    ndarray
        Mean over the whole surface of how far it lies below the plane, 0 where it is above, over
        the root-mean-square height.

    Notes
    -----
    This is the gap of a surface whose asperities are flattened to the plane and displace nothing
    else: the limit of a very low ceiling. Heights z follow a normal distribution, φ and Φ, or the
    gamma distribution of the same skewness, whose kurtosis is 3 + 1.5 Ssk²: with t the height of
    the plane, ⟨max(t - z, 0)⟩ = t Φ(t) + φ(t) for the normal one; for the gamma one with k =
    4/Ssk² and z = ±(x - k)/√k it is (x P(k, x) - k P(k+1, x))/√k, P the regularised incomplete
    gamma function, and with Q = 1 - P (k Q(k+1, x) - x Q(k, x))/√k where the skewness is negative.

    References
    ----------
    Johnson, Kotz & Balakrishnan, Continuous Univariate Distributions 1 (1994), chapter 17

    Examples
    --------
    >>> gap_below_plane(np.array([0.5]), np.array([0.0])).round(6)
    array([0.398942])
    """
    found = np.empty_like(material_ratio)
    peaked, flat = skewness > _NORMAL, skewness < -_NORMAL
    for chosen, form in ((peaked, _peaked), (flat, _flat), (~(peaked | flat), _normal)):
        if chosen.any():
            found[chosen] = form(material_ratio[chosen], skewness[chosen])
    return found


def _normal(ratio: Array, skewness: Array) -> Array:
    from scipy.special import ndtr, ndtri

    plane = -ndtri(ratio)
    gap: Array = plane * ndtr(plane) + np.exp(-(plane**2) / 2) / math.sqrt(2 * math.pi)
    return gap


def _peaked(ratio: Array, skewness: Array) -> Array:
    from scipy.special import gammainc, gammainccinv

    k = 4 / skewness**2
    plane = gammainccinv(k, ratio)
    gap: Array = (plane * gammainc(k, plane) - k * gammainc(k + 1, plane)) / np.sqrt(k)
    return gap


def _flat(ratio: Array, skewness: Array) -> Array:
    from scipy.special import gammaincc, gammaincinv

    k = 4 / skewness**2
    plane = gammaincinv(k, ratio)
    gap: Array = (k * gammaincc(k + 1, plane) - plane * gammaincc(k, plane)) / np.sqrt(k)
    return gap
