"""Greenwood and Williamson's theory of rough contact, from the spectral moments of a surface."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughcontact.errors import InputError, require_positive

Array = NDArray[np.float64]

# Variance of the summits of a Gaussian surface: 1 - 0.8968/α of that of its heights.
_SUMMITS = 0.8968
LEAST_BANDWIDTH = 1.5
"""Least α of an isotropic Gaussian surface, that of waves of one length (Nayak 1971)."""


@dataclass(frozen=True)
class Summits:
    """The summits of an isotropic Gaussian surface, taken as spheres of one radius.

    Parameters
    ----------
    density : float
        Summits per area η [1/m²].
    radius : float
        R [m].
    deviation : float
        Standard deviation of their heights σ_s [m].
    mean_height : float
        Height of their mean above that of the surface [m].
    """

    density: float
    radius: float
    deviation: float
    mean_height: float

    def contact_fraction(self, separation: Array) -> Array:
        """Return A/A₀ at separations of the flat from the mean of the summits, over σ_s."""
        return math.pi * self.density * self.radius * self.deviation * excess(1, separation)

    def pressure(self, separation: Array) -> Array:
        """Return p̄/E* at separations of the flat from the mean of the summits, over σ_s."""
        strength = 4 / 3 * self.density * math.sqrt(self.radius) * self.deviation**1.5
        return strength * excess(1.5, separation)

    def gap(self, separation: Array) -> Array:
        """Return the distance of the flat from the mean of the surface [m]; see `pressure`."""
        return separation * self.deviation + self.mean_height


def summits(m0: float, m2: float, m4: float) -> Summits:
    """Return the summits of an isotropic Gaussian surface.

    Parameters
    ----------
    m0, m2, m4 : float
        Mean squares of height [m²], slope [1] and curvature [1/m²] of a profile of it.

    Returns
    -------
    Summits
        Their density, radius, standard deviation and mean height.

    Raises
    ------
    InputError
        If a moment is not positive, or no Gaussian surface has them: α = m₀ m₄/m₂² below 1.5.

    Notes
    -----
    η = m₄/(6π√3 m₂), R = 3√π/(8√m₄), σ_s² = (1 - 0.8968/α) m₀, and their mean lies 4√(m₀/(πα))
    above that of the surface. m₄ is set by the shortest wave, so that all but the last hang on the
    pixel.

    References
    ----------
    Nayak 1971, J. Lubr. Technol. 93, 398, doi:10.1115/1.3451608 (density);
    Bush, Gibson and Keogh 1976, Mech. Res. Commun. 3, 169, doi:10.1016/0093-6413(76)90006-9, and
    McCool 1986, Wear 107, 37, doi:10.1016/0043-1648(86)90045-1 (radius, heights)
    """
    require_positive(m0=m0, m2=m2, m4=m4)
    bandwidth = m0 * m4 / m2**2
    if bandwidth < LEAST_BANDWIDTH:
        raise InputError(
            f"is too small: m0 m4/m2² = {bandwidth:.4g}, and at least {LEAST_BANDWIDTH:g} on any "
            "isotropic Gaussian surface",
            argument="m4",
            value=m4,
        )
    return Summits(
        density=m4 / (6 * math.pi * math.sqrt(3) * m2),
        radius=3 * math.sqrt(math.pi) / (8 * math.sqrt(m4)),
        deviation=math.sqrt((1 - _SUMMITS / bandwidth) * m0),
        mean_height=4 * math.sqrt(m0 / (math.pi * bandwidth)),
    )


def excess(power: float, separation: Array) -> Array:
    """Return F_n(h) = ∫ (s - h)ⁿ φ(s) ds over s > h, φ the normal distribution.

    Parameters
    ----------
    power : float
        n > -1.
    separation : ndarray
        h.

    Notes
    -----
    Γ(n+1)/√(2π) exp(-h²/4) D_{-n-1}(h), D the parabolic cylinder function.

    References
    ----------
    Greenwood and Williamson 1966, doi:10.1098/rspa.1966.0242; Gradshteyn and Ryzhik, Table of
    Integrals, 3.462

    Examples
    --------
    >>> excess(1, np.array([0.0])).round(6)
    array([0.398942])
    """
    from scipy.special import pbdv

    cylinder, _ = pbdv(-power - 1, separation)
    return math.gamma(power + 1) / math.sqrt(2 * math.pi) * np.exp(-(separation**2) / 4) * cylinder
