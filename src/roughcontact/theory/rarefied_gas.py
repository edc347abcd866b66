"""Gases in gaps that are not much wider than the mean free path of the molecules."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from roughcontact._tools.arrays import Array
from roughcontact.errors import require_positive
from roughcontact.material.fluids import GAS_CONSTANT

ROOM = 293.15
"""Room temperature [K]."""

# Flow rate Q(D) of a plane channel: start of each range of D, and factors of D, 1, 1/D and 1/D².
_CHANNEL = (
    (0.01, -2.22919, 2.10673, 0.01653, -0.0000694),
    (0.15, 0.13852, 1.25087, 0.15653, -0.00969),
    (5.0, 1 / 6, 1.0162, 1.0653, -2.1354),
)


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
    """Return the temperature-jump distance, the widening of a gap for heat flow [m].

    Parameters
    ----------
    path : float
        Mean free path λ [m].
    accommodation : float
        Share a of the molecules that reach the temperature of a wall.
    heat_capacity_ratio, prandtl : float
        γ and Pr of the gas.

    Returns
    -------
    float
        M = 2 (2 - a)/a · 2γ/(γ + 1) · λ/Pr, for both walls; a gap g conducts k/(g + M) per area.

    References
    ----------
    Song, Yovanovich and Goodman 1993, J. Heat Transfer 115, 533, doi:10.1115/1.2910719
    """
    require_positive(path=path, accommodation=accommodation, prandtl=prandtl)
    walls = 2 * (2 - accommodation) / accommodation
    return walls * 2 * heat_capacity_ratio / (heat_capacity_ratio + 1) * path / prandtl


def channel_flow(rarefaction: ArrayLike) -> Array:
    """Return the flow rate Q of a gas through a plane channel at any rarefaction.

    Parameters
    ----------
    rarefaction : array_like
        D = √π/(2 Kn), the gap over the free path λ, Kn = λ/g.

    Returns
    -------
    ndarray
        Q(D), of the shape of D: the flow through a gap g is Q g² √(R T/(2 M)) ∂p [Pa m³/s per
        width]. The viscous limit of Q is D/6; the minimum, 1.54, is near D = 1.

    Notes
    -----
    Fits by Fukui and Kaneko to solutions of the linearized Boltzmann equation of Bhatnagar, Gross
    and Krook with diffusely reflecting walls, accurate to 0.7 % for D ≥ 0.01. Below, Q grows by
    -ln(D)/√π, like the flow of free molecules in an infinite channel.

    References
    ----------
    Cercignani and Daneri 1963, J. Appl. Phys. 34, 3509
    Fukui and Kaneko 1990, J. Tribol. 112, 78, doi:10.1115/1.2920234

    Examples
    --------
    >>> channel_flow([0.01, 1.0, 100.0]).round(2)
    array([ 3.04,  1.54, 17.69])
    """
    d = np.asarray(rarefaction, dtype=float)
    first = _CHANNEL[0][0]
    within = np.maximum(d, first)
    row = np.array(_CHANNEL)[
        np.searchsorted([start for start, *_ in _CHANNEL], within, "right") - 1
    ]
    _, linear, constant, inverse, square = np.moveaxis(row, -1, 0)
    flow: Array = linear * within + constant + inverse / within + square / within**2
    return flow - np.log(d / within) / math.sqrt(math.pi)
