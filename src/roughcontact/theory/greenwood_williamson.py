"""Theory of rough contact of Greenwood and Williamson, from the spectral moments."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from roughcontact._tools.arrays import Array
from roughcontact.errors import InputError, require_positive

# The variance of the summits of a Gaussian surface is 1 - 0.8968/α of the variance of its heights.
_SUMMITS = 0.8968
MIN_BANDWIDTH = 1.5
"""Minimum α of an isotropic Gaussian surface, for waves of one length (Nayak 1971)."""


@dataclass(frozen=True)
class Summits:
    """Summits of an isotropic Gaussian surface, approximated by spheres of one radius.

    Parameters
    ----------
    density : float
        Summits per area η [1/m²].
    radius : float
        Radius R of the spheres [m].
    deviation : float
        Standard deviation of the summit heights σ_s [m].
    mean_height : float
        Height of the mean of the summits above the mean plane of the surface [m].
    """

    density: float
    radius: float
    deviation: float
    mean_height: float

    def contact_fraction(self, separation: Array) -> Array:
        """Return A/A₀ at separations of the flat from the mean of the summits, in σ_s."""
        return math.pi * self.density * self.radius * self.deviation * excess(1, separation)

    def pressure(self, separation: Array) -> Array:
        """Return p̄/E* at separations of the flat from the mean of the summits, in σ_s."""
        strength = 4 / 3 * self.density * math.sqrt(self.radius) * self.deviation**1.5
        return strength * excess(1.5, separation)

    def gap(self, separation: Array) -> Array:
        """Return the distance of the flat from the mean plane [m]; see `pressure`."""
        return separation * self.deviation + self.mean_height


def summits(m0: float, m2: float, m4: float) -> Summits:
    """Return the summits of an isotropic Gaussian surface.

    Parameters
    ----------
    m0, m2, m4 : float
        Mean squares of height [m²], slope [1] and curvature [1/m²] of a profile of the surface.

    Returns
    -------
    Summits
        Density, radius, standard deviation and mean height of the summits.

    Raises
    ------
    InputError
        If a moment is not positive, or no Gaussian surface has these moments: α = m₀ m₄/m₂² below
        1.5.

    Notes
    -----
    η = m₄/(6π√3 m₂), R = 3√π/(8√m₄), σ_s² = (1 - 0.8968/α) m₀, and the mean of the summits is
    4√(m₀/(πα)) above the mean plane. m₄ is set by the shortest wave, so that η and R depend
    strongly on the pixel size.

    References
    ----------
    Nayak 1971, J. Lubr. Technol. 93, 398, doi:10.1115/1.3451608 (density);
    Bush, Gibson and Keogh 1976, Mech. Res. Commun. 3, 169, doi:10.1016/0093-6413(76)90006-9, and
    McCool 1986, Wear 107, 37, doi:10.1016/0043-1648(86)90045-1 (radius, heights)
    """
    require_positive(m0=m0, m2=m2, m4=m4)
    bandwidth = m0 * m4 / m2**2
    if bandwidth < MIN_BANDWIDTH:
        raise InputError(
            f"is too small: m0 m4/m2² = {bandwidth:.4g}, and at least {MIN_BANDWIDTH:g} on any "
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
    """Return F_n(h) = ∫ (s - h)ⁿ φ(s) ds over s > h, with the normal density φ.

    Parameters
    ----------
    power : float
        n > -1.
    separation : ndarray
        h.

    Notes
    -----
    Γ(n+1)/√(2π) exp(-h²/4) D_{-n-1}(h), with the parabolic cylinder function D.

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
