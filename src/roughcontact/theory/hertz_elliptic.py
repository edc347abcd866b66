"""Hertz contact of two bodies with two radii of curvature, in closed form.

`roughcontact.theory.hertz` offers these functions beside those of circles and lines.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from roughcontact.errors import require_positive
from roughcontact.roots import brentq


@dataclass(frozen=True)
class EllipticContact:
    """Contact of two bodies with two radii of relative curvature.

    Parameters
    ----------
    load : float
        Normal load W [N].
    semi_axes : (float, float)
        Semi-axes of the ellipse of contact [m], each in the direction of the radius that was given
        in its place.
    max_pressure : float
        Peak pressure p_H [Pa].
    approach : float
        Approach δ [m] from first touch.
    """

    load: float
    semi_axes: tuple[float, float]
    max_pressure: float
    approach: float

    @property
    def area(self) -> float:
        """Area of the ellipse [m²]."""
        return math.pi * self.semi_axes[0] * self.semi_axes[1]

    @property
    def mean_pressure(self) -> float:
        """Load over area [Pa], 2/3 of the peak."""
        return self.load / self.area


def elliptic_contact(
    load: float, radii: tuple[float, float], contact_modulus: float
) -> EllipticContact:
    """Return the contact of two bodies whose gap at first touch is ``x²/(2R₁) + y²/(2R₂)``.

    Parameters
    ----------
    load : float
        Normal load W [N].
    radii : (float, float)
        Radii of relative curvature R₁, R₂ [m], in any order; for principal curvatures of two
        bodies in the same directions 1/R₁ = 1/R₁' + 1/R₁''.
    contact_modulus : float
        E* [Pa].

    Returns
    -------
    EllipticContact
        Ellipse, peak pressure and approach.

    Raises
    ------
    InputError
        If an argument is not positive and finite.

    Notes
    -----
    With semi-axes a ≥ b and k = b/a, complete elliptic integrals of parameter 1 - k²:
    ``p_H = 3W/(2πab)``, ``p_H E(k) = b E* (1/R₁ + 1/R₂)/2``, ``δ = p_H b K(k)/E*``, and k from
    ``R_D(0, 1, k²)/R_D(0, k², 1)``, the ratio of the radii in Carlson's form, where what Johnson's
    eq. (4.26) loses to cancellation next to a circle has gone.

    References
    ----------
    Johnson, Contact Mechanics (1985), eqs. (4.26) to (4.29), doi:10.1017/CBO9781139171731;
    Carlson 1995, doi:10.1007/BF02198293

    Examples
    --------
    >>> contact = elliptic_contact(1.0, (1e-3, 1e-3), 230e9)
    >>> contact.semi_axes[0] == contact.semi_axes[1], round(contact.semi_axes[0] * 1e6, 2)
    (True, 14.83)
    """
    require_positive(load=load, contact_modulus=contact_modulus)
    k, integral = _ellipse(radii)
    b = (3 * load * k * integral / (math.pi * contact_modulus * _curvature(radii))) ** (1 / 3)
    return _elliptic(b, k, radii, contact_modulus, load)


def elliptic_load(max_pressure: float, radii: tuple[float, float], contact_modulus: float) -> float:
    """Return the load at a given peak pressure of an elliptic contact.

    Parameters
    ----------
    max_pressure : float
        Peak pressure p_H [Pa].
    radii : (float, float)
        Radii of relative curvature R₁, R₂ [m].
    contact_modulus : float
        E* [Pa].

    Returns
    -------
    float
        Normal load W [N]; see `elliptic_contact`, whose inverse it is.

    Raises
    ------
    InputError
        If an argument is not positive and finite.
    """
    require_positive(max_pressure=max_pressure, contact_modulus=contact_modulus)
    k, integral = _ellipse(radii)
    b = 2 * max_pressure * integral / (contact_modulus * _curvature(radii))
    return 2 / 3 * math.pi * max_pressure * b**2 / k


def _curvature(radii: tuple[float, float]) -> float:
    return 1 / radii[0] + 1 / radii[1]


def _ellipse(radii: tuple[float, float]) -> tuple[float, float]:
    """Return the ratio of the semi-axes, up to 1, and E of it."""
    # Imported late: together they take longer than many a solve, which seldom needs them.
    from scipy.special import ellipe, elliprd

    require_positive(**{"radii[0]": radii[0], "radii[1]": radii[1]})
    ratio = max(radii) / min(radii)
    wanted = math.log(ratio)

    def excess(log_k: float) -> float:
        k2 = math.exp(2 * log_k)
        return float(np.log(elliprd(0, 1, k2) / elliprd(0, k2, 1))) - wanted

    # The ratio of the semi-axes lies between those of the radii and of their square roots.
    log_k = brentq(excess, -wanted, 0.0, xtol=1e-15, rtol=1e-15) if ratio > 1 else 0.0
    k = math.exp(log_k)
    return k, float(ellipe((1 - k) * (1 + k)))


def _elliptic(
    b: float, k: float, radii: tuple[float, float], contact_modulus: float, load: float
) -> EllipticContact:
    from scipy.special import ellipkm1

    peak = 3 * load * k / (2 * math.pi * b**2)
    longer = radii[0] >= radii[1]
    return EllipticContact(
        load=load,
        semi_axes=(b / k, b) if longer else (b, b / k),
        max_pressure=peak,
        approach=peak * b * float(ellipkm1(k**2)) / contact_modulus,
    )
