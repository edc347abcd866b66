"""Flat punch and cone on a half-space, in closed form.

Displacement is positive into the body, pressure positive in compression. Lengths [m], loads [N],
pressures and moduli [Pa].
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from roughcontact.errors import require_positive

Array = NDArray[np.float64]


def punch_load(approach: float, contact_radius: float, contact_modulus: float) -> float:
    """Return the load on a flat circular punch, ``W = 2 a E* δ``.

    Parameters
    ----------
    approach : float
        Approach δ [m].
    contact_radius : float
        Radius of the punch a [m].
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
    Johnson, Contact Mechanics (1985), eqs. (3.34) to (3.36), doi:10.1017/CBO9781139171731
    """
    require_positive(
        approach=approach, contact_radius=contact_radius, contact_modulus=contact_modulus
    )
    return 2 * contact_radius * contact_modulus * approach


def punch_pressure(r: ArrayLike, load: float, contact_radius: float) -> Array:
    """Return the pressure under a flat circular punch, ``W/(2πa²) (1 - r²/a²)^(-1/2)``.

    Parameters
    ----------
    r : array_like
        Distances from the axis [m].
    load : float
        Normal load W [N].
    contact_radius : float
        Radius of the punch a [m].

    Returns
    -------
    ndarray, shape of r
        Pressure [Pa], without bound towards the rim, 0 on and outside it.

    Raises
    ------
    InputError
        If the load or the radius is not positive.

    References
    ----------
    Johnson, Contact Mechanics (1985), eq. (3.34), doi:10.1017/CBO9781139171731
    """
    require_positive(load=load, contact_radius=contact_radius)
    rho = np.abs(np.asarray(r, dtype=np.float64)) / contact_radius
    root = np.sqrt(np.maximum((1 - rho) * (1 + rho), 0))
    unit = np.divide(1.0, root, out=np.zeros_like(root), where=root > 0)
    return load / (2 * math.pi * contact_radius**2) * unit


def punch_displacement(r: ArrayLike, approach: float, contact_radius: float) -> Array:
    """Return the surface displacement by a flat circular punch, ``(2δ/π) asin(a/r)`` outside.

    Parameters
    ----------
    r : array_like
        Distances from the axis [m].
    approach : float
        Approach δ [m].
    contact_radius : float
        Radius of the punch a [m].

    Returns
    -------
    ndarray, shape of r
        Displacement [m] into the body, δ under the punch.

    Raises
    ------
    InputError
        If the radius is not positive.

    References
    ----------
    Sneddon 1965, doi:10.1016/0020-7225(65)90019-4;
    Johnson, Contact Mechanics (1985), eq. (3.37), doi:10.1017/CBO9781139171731
    """
    require_positive(contact_radius=contact_radius)
    rho = np.maximum(np.abs(np.asarray(r, dtype=np.float64)) / contact_radius, 1)
    return 2 * approach / math.pi * np.arcsin(1 / rho)


def cone_contact_radius(load: float, slope: float, contact_modulus: float) -> float:
    """Return the contact radius of a cone, ``a = (2 W / (π E* m))^(1/2)``.

    Parameters
    ----------
    load : float
        Normal load W [N].
    slope : float
        Slope m of the shape m·r: the cotangent of the half-angle at the tip.
    contact_modulus : float
        E* [Pa].

    Returns
    -------
    float
        a [m].

    Raises
    ------
    InputError
        If an argument is not positive.

    References
    ----------
    Johnson, Contact Mechanics (1985), sec. 5.2, doi:10.1017/CBO9781139171731
    """
    require_positive(load=load)
    return math.sqrt(load / (math.pi * cone_mean_pressure(slope, contact_modulus)))


def cone_mean_pressure(slope: float, contact_modulus: float) -> float:
    """Return the mean pressure under a cone, ``E* m / 2`` at every load.

    Parameters
    ----------
    slope : float
        Slope m of the shape m·r.
    contact_modulus : float
        E* [Pa].

    Returns
    -------
    float
        Load over contact area [Pa].

    Raises
    ------
    InputError
        If an argument is not positive.

    References
    ----------
    Love 1939, doi:10.1093/qmath/os-10.1.161;
    Johnson, Contact Mechanics (1985), sec. 5.2, doi:10.1017/CBO9781139171731
    """
    require_positive(slope=slope, contact_modulus=contact_modulus)
    return contact_modulus * slope / 2


def cone_approach(contact_radius: float, slope: float) -> float:
    """Return the approach of a cone, ``δ = π a m / 2``.

    Parameters
    ----------
    contact_radius : float
        a [m].
    slope : float
        Slope m of the shape m·r.

    Returns
    -------
    float
        δ [m] from first touch.

    Raises
    ------
    InputError
        If an argument is not positive.

    References
    ----------
    Sneddon 1965, doi:10.1016/0020-7225(65)90019-4
    """
    require_positive(contact_radius=contact_radius, slope=slope)
    return math.pi * contact_radius * slope / 2


def cone_load(approach: float, slope: float, contact_modulus: float) -> float:
    """Return the load at a given approach of a cone, ``W = 2 E* δ² / (π m)``.

    Parameters
    ----------
    approach : float
        δ [m] from first touch.
    slope : float
        Slope m of the shape m·r.
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
    Sneddon 1965, doi:10.1016/0020-7225(65)90019-4
    """
    require_positive(approach=approach, slope=slope, contact_modulus=contact_modulus)
    return 2 * contact_modulus * approach**2 / (math.pi * slope)


def cone_pressure(r: ArrayLike, contact_radius: float, mean_pressure: float) -> Array:
    """Return the pressure under a cone, ``p̄ arcosh(a/r)`` inside and 0 outside.

    Parameters
    ----------
    r : array_like
        Distances from the axis [m].
    contact_radius : float
        a [m].
    mean_pressure : float
        p̄ [Pa], see `cone_mean_pressure`.

    Returns
    -------
    ndarray, shape of r
        Pressure [Pa], infinite at the tip.

    Raises
    ------
    InputError
        If the contact radius is not positive.

    References
    ----------
    Love 1939, doi:10.1093/qmath/os-10.1.161;
    Johnson, Contact Mechanics (1985), sec. 5.2, doi:10.1017/CBO9781139171731
    """
    require_positive(contact_radius=contact_radius)
    rho = np.abs(np.asarray(r, dtype=np.float64)) / contact_radius
    inverse = np.divide(1.0, rho, out=np.full_like(rho, np.inf), where=rho > 0)
    return mean_pressure * np.arccosh(np.maximum(inverse, 1))


def cone_displacement(r: ArrayLike, contact_radius: float, slope: float) -> Array:
    """Return the surface displacement by a cone, inside and outside the contact.

    Parameters
    ----------
    r : array_like
        Distances from the axis [m].
    contact_radius : float
        a [m].
    slope : float
        Slope m of the shape m·r.

    Returns
    -------
    ndarray, shape of r
        Displacement [m] into the body: ``δ - m r`` inside,
        ``m [a asin(a/r) + (r² - a²)^(1/2) - r]`` outside.

    Raises
    ------
    InputError
        If an argument is not positive.

    References
    ----------
    Sneddon 1965, doi:10.1016/0020-7225(65)90019-4
    """
    require_positive(contact_radius=contact_radius, slope=slope)
    rho = np.abs(np.asarray(r, dtype=np.float64)) / contact_radius
    outside = np.maximum(rho, 1)
    root = np.sqrt((outside - 1) * (outside + 1))
    unit: Array = np.arcsin(1 / outside) + root - rho
    return slope * contact_radius * unit
