"""Hertz contact in closed form: circular, elliptic and line contacts.

Functions without a prefix are for a sphere (or paraboloid) on a half-space, functions with the
prefix ``elliptic`` for a contact with two radii of curvature, and with ``line`` for a cylinder.
Radii ``r`` are measured from the axis; displacement is positive into the body, pressure
positive in compression. Lengths [m], loads [N], line loads [N/m], pressures and moduli [Pa].
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from roughcontact._tools.arrays import Array
from roughcontact._tools.roots import brentq
from roughcontact.errors import input_error, require_positive


@dataclass(frozen=True)
class EllipticContact:
    """Contact of two bodies with two radii of relative curvature.

    Parameters
    ----------
    load : float
        Normal load W [N].
    semi_axes : (float, float)
        Semi-axes of the contact ellipse [m], in the order of the given radii.
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
    """Return the contact of bodies with the gap ``x²/(2R₁) + y²/(2R₂)`` at first touch.

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
    ``R_D(0, 1, k²)/R_D(0, k², 1)``, the ratio of the radii in Carlson's form, without the
    cancellation of Johnson's eq. (4.26) near a circle.

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
    from scipy.special import ellipkm1

    require_positive(load=load, contact_modulus=contact_modulus)
    k, integral = _ellipse(radii)
    b = (3 * load * k * integral / (math.pi * contact_modulus * _curvature(radii))) ** (1 / 3)
    peak = 3 * load * k / (2 * math.pi * b**2)
    depth = peak * b * float(ellipkm1(k**2)) / contact_modulus
    return EllipticContact(load, (b / k, b) if radii[0] >= radii[1] else (b, b / k), peak, depth)


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
        Normal load W [N]; the inverse of `elliptic_contact`.

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
    """Return the ratio k of the semi-axes, at most 1, and the elliptic integral E(k)."""
    # Lazy import: it takes longer than many solves, which seldom need it.
    from scipy.special import ellipe, elliprd

    require_positive(**{"radii[0]": radii[0], "radii[1]": radii[1]})
    ratio = max(radii) / min(radii)
    wanted = math.log(ratio)

    def excess(log_k: float) -> float:
        k2 = math.exp(2 * log_k)
        return float(np.log(elliprd(0, 1, k2) / elliprd(0, k2, 1))) - wanted

    # The ratio of the semi-axes is between those of the radii and of their square roots.
    log_k = brentq(excess, -wanted, 0.0, xtol=1e-15, rtol=1e-15) if ratio > 1 else 0.0
    k = math.exp(log_k)
    return k, float(ellipe((1 - k) * (1 + k)))


def contact_radius(load: float, radius: float, contact_modulus: float) -> float:
    """Return the radius of the contact circle, ``a = (3 W R / (4 E*))^(1/3)``.

    Parameters
    ----------
    load : float
        Normal load W [N].
    radius : float
        Radius of the sphere R [m]; for two spheres 1/R = 1/R₁ + 1/R₂.
    contact_modulus : float
        E* [Pa].

    Returns
    -------
    float
        Contact radius a [m].

    Raises
    ------
    InputError
        If an argument is not positive.

    References
    ----------
    Johnson, Contact Mechanics (1985), eq. (4.22), doi:10.1017/CBO9781139171731

    Examples
    --------
    >>> round(contact_radius(load=1.0, radius=1e-3, contact_modulus=230e9) * 1e6, 2)
    14.83
    """
    require_positive(load=load, radius=radius, contact_modulus=contact_modulus)
    return float((3 * load * radius / (4 * contact_modulus)) ** (1 / 3))


def max_pressure(load: float, radius: float, contact_modulus: float) -> float:
    """Return the pressure on the axis, ``p_H = 3 W / (2 π a²)``.

    Parameters
    ----------
    load : float
        Normal load W [N].
    radius : float
        Radius of the sphere R [m].
    contact_modulus : float
        E* [Pa].

    Returns
    -------
    float
        Peak pressure p_H [Pa], 3/2 of the mean pressure.

    Raises
    ------
    InputError
        If an argument is not positive.

    References
    ----------
    Johnson, Contact Mechanics (1985), eq. (4.24), doi:10.1017/CBO9781139171731
    """
    return 3 * load / (2 * math.pi * contact_radius(load, radius, contact_modulus) ** 2)


def approach(load: float, radius: float, contact_modulus: float) -> float:
    """Return the approach of distant points of the bodies, ``δ = a²/R``.

    Parameters
    ----------
    load : float
        Normal load W [N].
    radius : float
        Radius of the sphere R [m].
    contact_modulus : float
        E* [Pa].

    Returns
    -------
    float
        Approach δ [m] from first touch.

    Raises
    ------
    InputError
        If an argument is not positive.

    References
    ----------
    Johnson, Contact Mechanics (1985), eq. (4.23), doi:10.1017/CBO9781139171731
    """
    return contact_radius(load, radius, contact_modulus) ** 2 / radius


def load(approach: float, radius: float, contact_modulus: float) -> float:
    """Return the load at a given approach, ``W = (4/3) E* R^(1/2) δ^(3/2)``.

    Parameters
    ----------
    approach : float
        Approach δ [m] from first touch.
    radius : float
        Radius of the sphere R [m].
    contact_modulus : float
        E* [Pa].

    Returns
    -------
    float
        Normal load W [N].

    Raises
    ------
    InputError
        If an argument is not positive.

    References
    ----------
    Johnson, Contact Mechanics (1985), eq. (4.23), doi:10.1017/CBO9781139171731
    """
    require_positive(approach=approach, radius=radius, contact_modulus=contact_modulus)
    return 4 / 3 * contact_modulus * math.sqrt(radius * approach) * approach


def pressure(r: ArrayLike, contact_radius: float, max_pressure: float) -> Array:
    """Return the contact pressure, ``p_H (1 - r²/a²)^(1/2)`` inside and 0 outside.

    Parameters
    ----------
    r : array_like
        Distances from the axis [m].
    contact_radius : float
        Contact radius a [m].
    max_pressure : float
        Peak pressure p_H [Pa].

    Returns
    -------
    ndarray, shape of r
        Pressure [Pa].

    Raises
    ------
    InputError
        If the contact radius is not positive.

    References
    ----------
    Johnson, Contact Mechanics (1985), eq. (3.39), doi:10.1017/CBO9781139171731
    """
    require_positive(contact_radius=contact_radius)
    rho = np.asarray(r, dtype=np.float64) / contact_radius
    return max_pressure * np.sqrt(np.maximum(1 - rho**2, 0))


def displacement(
    r: ArrayLike, contact_radius: float, max_pressure: float, contact_modulus: float
) -> Array:
    """Return the surface displacement under Hertz pressure, inside and outside the contact.

    Parameters
    ----------
    r : array_like
        Distances from the axis [m].
    contact_radius : float
        Contact radius a [m].
    max_pressure : float
        Peak pressure p_H [Pa].
    contact_modulus : float
        E* [Pa].

    Returns
    -------
    ndarray, shape of r
        Displacement [m] of both surfaces together, into the bodies, 0 far away.

    Raises
    ------
    InputError
        If the contact radius or the modulus is not positive.

    Notes
    -----
    With ρ = r/a: ``(p_H a / (2 E*)) [(2 - ρ²) asin(1/ρ) + (ρ² - 1)^(1/2)]`` outside, and the same
    with asin → π/2 and root → 0 inside. The relative rounding error grows as ρ².

    References
    ----------
    Johnson, Contact Mechanics (1985), eqs. (3.41a) and (3.42a), doi:10.1017/CBO9781139171731
    """
    require_positive(contact_radius=contact_radius, contact_modulus=contact_modulus)
    rho = np.abs(np.asarray(r, dtype=np.float64)) / contact_radius
    t = _outside(rho)
    scale = max_pressure * contact_radius / (2 * contact_modulus)
    return scale * ((2 - rho**2) * np.arctan2(1, t) + t)


def gap(r: ArrayLike, contact_radius: float, radius: float) -> Array:
    """Return the gap between the bodies, 0 inside the contact.

    Parameters
    ----------
    r : array_like
        Distances from the axis [m].
    contact_radius : float
        Contact radius a [m].
    radius : float
        Radius of the sphere R [m], with the shape of the paraboloid r²/(2R).

    Returns
    -------
    ndarray, shape of r
        Gap [m], never negative.

    Raises
    ------
    InputError
        If a radius is not positive.

    Notes
    -----
    ``(a²/(π R)) [(ρ² - 1)^(1/2) + (ρ² - 2) acos(1/ρ)]`` with ρ = r/a: displacement plus shape
    minus approach, from Johnson eq. (3.42a), without their cancellation near the rim.

    References
    ----------
    Johnson, Contact Mechanics (1985), eqs. (3.42a) and (4.23), doi:10.1017/CBO9781139171731
    """
    require_positive(contact_radius=contact_radius, radius=radius)
    t = _outside(np.abs(np.asarray(r, dtype=np.float64)) / contact_radius)
    # Rounding leaves a few 1e-16 below zero at worst: a gap is never negative.
    bracket = np.maximum(t + (t**2 - 1) * np.arctan(t), 0)
    return contact_radius**2 / (math.pi * radius) * bracket


def load_at_pressure(max_pressure: float, radius: float, contact_modulus: float) -> float:
    """Return the load at a given peak pressure, ``W = π³ R² p_H³ / (6 E*²)``.

    Parameters
    ----------
    max_pressure : float
        Peak pressure p_H [Pa].
    radius : float
        Radius of the sphere R [m].
    contact_modulus : float
        E* [Pa].

    Returns
    -------
    float
        Normal load W [N]; the inverse of `max_pressure`.

    Raises
    ------
    InputError
        If an argument is not positive.

    References
    ----------
    Johnson, Contact Mechanics (1985), eq. (4.24), doi:10.1017/CBO9781139171731
    """
    require_positive(max_pressure=max_pressure, radius=radius, contact_modulus=contact_modulus)
    return math.pi**3 * radius**2 * max_pressure**3 / (6 * contact_modulus**2)


def first_yield_load(radius: float, contact_modulus: float, first_yield_pressure: float) -> float:
    """Return the load at which the sphere first yields, ``π³ R² p_Y³ / (6 E*²)``.

    Parameters
    ----------
    radius : float
        Radius of the sphere R [m].
    contact_modulus : float
        E* [Pa].
    first_yield_pressure : float
        Peak pressure p_Y [Pa] at first yield below the surface, see
        `Material.first_yield_pressure`.

    Returns
    -------
    float
        Load [N], proportional to the cube of the pressure.

    Raises
    ------
    InputError
        If an argument is not positive.

    References
    ----------
    Johnson, Contact Mechanics (1985), eq. (6.10), doi:10.1017/CBO9781139171731
    """
    require_positive(first_yield_pressure=first_yield_pressure)
    return load_at_pressure(first_yield_pressure, radius, contact_modulus)


def saturated_radius_ratio(ceiling_ratio: float) -> float:
    """Return the contact radius of a fully saturated contact, ``a/a_H = (2/(3f))^(1/2)``.

    Parameters
    ----------
    ceiling_ratio : float
        Pressure ceiling over the Hertz peak pressure at the same load, f = p_lim/p_H.

    Returns
    -------
    float
        Radius of a disc under the uniform ceiling that carries the load, over the Hertz radius:
        the limit of the contact radius for low ceilings and a lower bound for every ceiling.

    Raises
    ------
    InputError
        If the ratio is not positive.

    Notes
    -----
    Balance of load: ``p_lim π a² = W = (2/3) p_H π a_H²``.

    Examples
    --------
    >>> round(saturated_radius_ratio(0.3), 3)
    1.491
    """
    require_positive(ceiling_ratio=ceiling_ratio)
    return math.sqrt(2 / (3 * ceiling_ratio))


@dataclass(frozen=True)
class LineContact:
    """Contact of a cylinder along its axis.

    Parameters
    ----------
    line_load : float
        Load per length W' [N/m].
    half_width : float
        Half-width of the contact strip [m].
    max_pressure : float
        Peak pressure p_H [Pa].
    """

    line_load: float
    half_width: float
    max_pressure: float

    @property
    def mean_pressure(self) -> float:
        """Line load over width [Pa], π/4 of the peak."""
        return self.line_load / (2 * self.half_width)


def line_contact(line_load: float, radius: float, contact_modulus: float) -> LineContact:
    """Return the line contact, ``a = (4 W' R/(π E*))^(1/2)``, ``p_H = 2 W'/(π a)``.

    Parameters
    ----------
    line_load : float
        Load per length W' [N/m].
    radius : float
        Radius R [m]; for two parallel cylinders 1/R = 1/R₁ + 1/R₂.
    contact_modulus : float
        E* [Pa].

    Returns
    -------
    LineContact
        Half-width and peak pressure.

    Raises
    ------
    InputError
        If an argument is not positive and finite.

    References
    ----------
    Johnson, Contact Mechanics (1985), eqs. (4.43) and (4.45), doi:10.1017/CBO9781139171731

    Examples
    --------
    >>> contact = line_contact(2e4, 0.01, 230e9)
    >>> round(contact.half_width * 1e6, 2), round(contact.max_pressure / 1e6, 1)
    (33.27, 382.7)
    """
    require_positive(line_load=line_load, radius=radius, contact_modulus=contact_modulus)
    half_width = math.sqrt(4 * line_load * radius / (math.pi * contact_modulus))
    return LineContact(line_load, half_width, 2 * line_load / (math.pi * half_width))


def line_load(max_pressure: float, radius: float, contact_modulus: float) -> float:
    """Return the load per length at a given peak pressure, ``W' = π R p_H²/E*``.

    Parameters
    ----------
    max_pressure : float
        Peak pressure p_H [Pa].
    radius : float
        Radius R [m].
    contact_modulus : float
        E* [Pa].

    Returns
    -------
    float
        W' [N/m]; the inverse of `line_contact`.

    Raises
    ------
    InputError
        If an argument is not positive and finite.

    References
    ----------
    Johnson, Contact Mechanics (1985), eq. (4.45), doi:10.1017/CBO9781139171731
    """
    require_positive(max_pressure=max_pressure, radius=radius, contact_modulus=contact_modulus)
    return math.pi * radius * max_pressure**2 / contact_modulus


def line_approach(line_load: float, radius: float, contact_modulus: float, datum: float) -> float:
    """Return the approach of a cylinder, ``W'/(π E*) (2 ln(2 d/a) + 1)``.

    Parameters
    ----------
    line_load : float
        Load per length W' [N/m].
    radius : float
        Radius R [m].
    contact_modulus : float
        E* [Pa].
    datum : float
        Distance d [m] from the line at which the displacement of the surface is zero: a line load
        displaces a half-space without bound.

    Returns
    -------
    float
        Approach [m] from first touch.

    Raises
    ------
    InputError
        If an argument is not positive and finite, or the datum is inside the contact.

    References
    ----------
    Johnson, Contact Mechanics (1985), secs. 2.2 and 4.2(c), doi:10.1017/CBO9781139171731
    """
    a = line_contact(line_load, radius, contact_modulus).half_width
    if not datum > a:
        raise input_error("datum", datum, f"must be above the half-width of the contact, {a:.6g} m")
    return line_load / (math.pi * contact_modulus) * (2 * math.log(2 * datum / a) + 1)


def _outside(rho: Array) -> Array:
    # sqrt(ρ² - 1) outside, 0 inside; the product keeps its digits near the rim.
    rho = np.maximum(rho, 1)
    return np.sqrt((rho - 1) * (rho + 1))
