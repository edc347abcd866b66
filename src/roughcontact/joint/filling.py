"""What fills the gap of a joint: the heat that it conducts, and gases that slip through it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.theory.rarefied import jump_distance, mean_free_path

Array = NDArray[np.float64]

AIR_MASS, HELIUM_MASS = 28.96e-3, 4.003e-3
"""Molar masses [kg/mol]."""

ATMOSPHERE = 101325.0
"""Pressure of the atmosphere [Pa]."""

# Mean temperature of a square of unit side and flux on a half-space of unit conductivity.
_SQUARE = 2 / math.pi * (math.asinh(1) - (math.sqrt(2) - 1) / 3)


@dataclass(frozen=True)
class Filling:
    """What may fill a gap.

    Parameters
    ----------
    conductivity : float
        Thermal conductivity k [W/(m K)].
    jump : float
        By how much jumps of temperature at the walls widen the gap [m]; 0 of a liquid.
    """

    conductivity: float
    jump: float = 0.0


AIR = Filling(0.026, jump_distance(mean_free_path(18.4e-6, 1e5, AIR_MASS, 298.15), 0.9, 1.4, 0.71))
"""At 25 °C and 1 bar between engineering metals: a jump of 0.27 µm."""

OIL = Filling(0.14)
"""Mineral oil."""


def gap_conductance(gap: Array, filling: Filling, spreading: float = 0.0) -> float:
    """Return what a filled gap conducts per area [W/(m² K)], its faces at one temperature each.

    Parameters
    ----------
    gap : ndarray
        Gap [m]; NaN where the bodies touch, which counts as none.
    filling : Filling
        What fills it.
    spreading : float
        What the bodies resist to the heat of one point, times its area [m² K/W]: it bounds what a
        liquid conducts where the gap is narrow; see `spreading`.

    Notes
    -----
    Beside the contact, whose conductance is computed without it. Against the contact and the gap
    solved together on rough maps of up to a tenth in contact, the part of the gap comes out 0.8 to
    1.0 times as large with air, and 1.1 to 1.3 times with oil.

    References
    ----------
    Song, Yovanovich and Goodman 1993, J. Heat Transfer 115, 533, doi:10.1115/1.2910719
    """
    there = gap[~np.isnan(gap)]
    with np.errstate(divide="ignore"):
        local = 1 / ((there + filling.jump) / filling.conductivity + spreading)
    return float(local.sum() / gap.size)


def spreading(pixel_area: float, resistivity: float) -> float:
    """Return what two bodies resist to a uniform flux through one pixel, times its area [m² K/W].

    Parameters
    ----------
    pixel_area : float
        Area of a pixel, taken for a square [m²].
    resistivity : float
        Sum of 1/k of both bodies [m K/W].
    """
    return _SQUARE * math.sqrt(pixel_area) * resistivity


def slip_factor(gap: Array, density: NDArray[Any], path: float) -> float:
    """Return how many times more of a gas that slips leaks than of one that does not.

    Parameters
    ----------
    gap : ndarray, shape (ny, nx)
        Gap [m], 0 where it is closed.
    density : ndarray, shape (ny, nx)
        Amount of the flow density without slip, in any unit.
    path : float
        Mean free path λ at the mean of the pressures at inlet and outlet [m].

    Returns
    -------
    float
        1 + 6 λ/g between plates; NaN where nothing flows.

    Notes
    -----
    Slip of first order at walls that reflect diffusely: a gap g lets g³ (1 + 6 λ/g) through. Local
    gaps count by what the flow without slip dissipates in them, |q|²/g³, as their harmonic mean:
    that is right for gaps in series, and a lower bound for all others (Thomson's principle): the
    flow through rough gaps solved anew with slip is up to a sixth more. Above λ/g of about one
    the true flow is larger still.

    References
    ----------
    Burgdorfer 1959, J. Basic Eng. 81, 94
    """
    open_gap = gap > 0
    g, q = gap[open_gap], density[open_gap].astype(np.float64)
    dissipated = q**2 / g**3
    total = dissipated.sum()
    if not total > 0:
        return math.nan
    return float(total / (dissipated / (1 + 6 * path / g)).sum())
