"""Heights of a surface cut by a plane: share above it, and the gap below."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from roughcontact.theory import johnson

Array = NDArray[np.float64]

# Normal scores for integrals over the heights, and what of the surface lies below each.
_SCORES = np.linspace(-9, 9, 7201)


def gap_below_plane(material_ratio: Array, skewness: Array, kurtosis: Array) -> Array:
    """Return the mean open gap between a plane and the surface that it cuts off, over Sq.

    Parameters
    ----------
    material_ratio : ndarray
        Share of the surface above the plane, in (0, 1).
    skewness, kurtosis : ndarray
        Ssk and Sku of the heights, of the same shape.

    Returns
    -------
    ndarray
        Mean over the whole surface of how far it lies below the plane, 0 where it is above, over
        the root-mean-square height.

    Notes
    -----
    This is the gap of a surface whose asperities are flattened to the plane and displace nothing
    else: the limit of a very low ceiling. Heights follow the distribution of Johnson's system that
    has this skewness and kurtosis, h(z) of a standard normal variable z; the plane at z_p lies
    ∫ max(h(z_p) - h(z), 0) φ(z) dz above them on average, by the trapezoidal rule.

    References
    ----------
    Johnson 1949, doi:10.1093/biomet/36.1-2.149

    Examples
    --------
    >>> gap_below_plane(np.array([0.5]), np.array([0.0]), np.array([3.0])).round(5)
    array([0.39894])
    """
    from scipy.special import ndtri

    found = np.empty_like(material_ratio)
    planes = -ndtri(material_ratio)
    pairs, number = np.unique(np.stack([skewness, kurtosis]), axis=1, return_inverse=True)
    for place, (third, fourth) in enumerate(pairs.T):
        chosen = number.ravel() == place
        found[chosen] = np.interp(planes[chosen], _SCORES, _gaps(float(third), float(fourth)))
    return found


@lru_cache(maxsize=512)
def _gaps(skewness: float, kurtosis: float) -> Array:
    """Return the gap below planes at all scores."""
    heights = johnson.fitted(skewness, kurtosis).heights(_SCORES)
    density = np.exp(-(_SCORES**2) / 2) / math.sqrt(2 * math.pi)
    step = float(_SCORES[1] - _SCORES[0])
    mean = float(np.sum(heights * density)) * step
    spread = math.sqrt(float(np.sum((heights - mean) ** 2 * density)) * step)
    # What lies below a plane, times how far the plane rises, is by how much the gap grows.
    below = np.cumsum(density) * step - density * step / 2
    rises = np.diff(heights) / spread
    gaps: Array = np.concatenate([[0.0], np.cumsum((below[1:] + below[:-1]) / 2 * rises)])
    return gaps
