"""Gases in gaps that are not much wider than the free path of their molecules."""

from __future__ import annotations

import math

from roughcontact.errors import require_positive

GAS_CONSTANT = 8.314462618
"""R [J/(mol K)]."""

ROOM = 293.15
"""Room temperature [K]."""


def mean_free_path(
    viscosity: float, pressure: float, molar_mass: float, temperature: float = ROOM
) -> float:
    """Return the mean free path of the molecules of a gas, λ = η/p √(π R T/(2 M)) [m].

    Parameters
    ----------
    viscosity : float
        η [Pa s].
    pressure : float
        p [Pa].
    molar_mass : float
        M [kg/mol].
    temperature : float
        T [K].

    References
    ----------
    Burgdorfer 1959, J. Basic Eng. 81, 94

    Examples
    --------
    >>> round(1e9 * mean_free_path(18.2e-6, 101325, 0.02896), 1)
    65.3
    """
    require_positive(
        viscosity=viscosity, pressure=pressure, molar_mass=molar_mass, temperature=temperature
    )
    speed = math.sqrt(math.pi * GAS_CONSTANT * temperature / (2 * molar_mass))
    return viscosity / pressure * speed


def jump_distance(
    path: float, accommodation: float, heat_capacity_ratio: float, prandtl: float
) -> float:
    """Return by how much the jumps of temperature at both walls widen a gap for heat [m].

    Parameters
    ----------
    path : float
        Mean free path λ [m].
    accommodation : float
        Share a of the molecules that take on the temperature of a wall.
    heat_capacity_ratio, prandtl : float
        γ and Pr of the gas.

    Returns
    -------
    float
        M = 2 (2 - a)/a · 2γ/(γ + 1) · λ/Pr, with which a gap g conducts k/(g + M) per area.

    References
    ----------
    Song, Yovanovich and Goodman 1993, J. Heat Transfer 115, 533, doi:10.1115/1.2910719
    """
    require_positive(path=path, accommodation=accommodation, prandtl=prandtl)
    walls = 2 * (2 - accommodation) / accommodation
    return walls * 2 * heat_capacity_ratio / (heat_capacity_ratio + 1) * path / prandtl
