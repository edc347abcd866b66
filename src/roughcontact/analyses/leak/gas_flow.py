"""Isothermal flow of a gas through a gap, from viscous to free molecular.

The throughput of a gap g per width is g³ G p ∇p/(12 η) [Pa m³/s], with G = 6 Q(D)/D by the local
rarefaction D = √π g p/(2 λ p) of `roughcontact.theory.rarefied_gas.channel_flow`; G is 1 where the
gas is viscous. In terms of the potential Φ = ∫ p G dp of the narrowest constriction, the throughput
is g³ ∇Φ/(12 η) for gaps of the same width, and G/G_c times this for others. This factor depends
little on the pressure, and not at all if the gas is viscous or free molecular everywhere.

Along a periodic axis the sample is short compared with the land: its permeability is computed at
one pressure, and averaged by Gauss quadrature over the land, along which Φ falls linearly. Along a
free axis the sample is the land, with the inlet at the first row or column: the mobility depends on
the pressure of each pixel (`roughcontact.analyses.leak.flow.flow` with a mobility).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from roughcontact._tools.arrays import Array
from roughcontact.analyses.leak.flow import Flow, flow
from roughcontact.material.fluids import GAS_CONSTANT
from roughcontact.theory.rarefied_gas import channel_flow, mean_free_path

STANDARD_TEMPERATURE, STANDARD_PRESSURE = 273.15, 101325.0
"""Standard state [K], [Pa] of a cubic centimeter: 0 °C and one atmosphere (SEMI E12)."""

# Test pressures [Pa] of the classes of leak rates of helium, with a margin of 1 %: 1 bar or one
# atmosphere at the inlet, at most 1 mbar at the outlet (Rottländer, Umrath and Voss 2016).
_CLASS_INLET, _CLASS_OUTLET = (0.99e5, 1.01 * STANDARD_PRESSURE), 101.0

# Number of quadrature points over the land, and of points in the table of the potential.
_POINTS, _TABLE = 2, 4001


@dataclass(frozen=True)
class GasState:
    """Gas between two pressures."""

    name: str
    molar_mass: float  # M [kg/mol]
    viscosity: float  # η [Pa s]
    temperature: float  # T [K]
    inlet: float  # Absolute inlet pressure [Pa]
    outlet: float  # Absolute outlet pressure [Pa]

    @property
    def mean_pressure(self) -> float:
        """Mean of the pressures at inlet and outlet [Pa]."""
        return (self.inlet + self.outlet) / 2

    @property
    def has_leak_class(self) -> bool:
        """Whether leak classes hold: helium from 1 bar or an atmosphere into vacuum, 1 mbar."""
        low, high = _CLASS_INLET
        is_test = low <= self.inlet <= high and self.outlet <= _CLASS_OUTLET
        return self.name == "helium" and is_test

    def knudsen(self, gap: float, pressure: float) -> float:
        """Return the Knudsen number Kn = λ/g."""
        path = mean_free_path(self.viscosity, pressure, self.molar_mass, self.temperature)
        return path / gap

    def mobility(self, gap: Array | float, pressure: Array | float) -> Array:
        """Return the mobility G: the flow over the flow of a viscous gas."""
        rarefaction = math.sqrt(math.pi) / 2 * gap * pressure / self.knudsen(1.0, 1.0)
        return 6 * channel_flow(rarefaction) / rarefaction

    def throughput_in(self, unit: str) -> float:
        """Return the throughput of one Pa m³/s of this gas in another unit."""
        warmth = STANDARD_TEMPERATURE / self.temperature
        return {
            "Pa m³/s": 1.0,
            "mbar l/s": 10.0,
            "kg/s": self.molar_mass / (GAS_CONSTANT * self.temperature),
            "sccm": 60e6 * warmth / STANDARD_PRESSURE,
        }[unit]


def gas_factor(
    gap: Array,
    pixel: tuple[float, float],
    viscous: Flow,
    narrowest: float,
    state: GasState,
    periodic_axes: tuple[int, ...] = (),
    points: int = _POINTS,
) -> float:
    """Return the throughput of a gas over its throughput in purely viscous flow."""
    pressures = np.geomspace(state.outlet, state.inlet, _TABLE)
    # dΦ = p G dp = p² G d(ln p)
    slope = pressures**2 * state.mobility(narrowest, pressures)
    step = math.log(state.inlet / state.outlet) / (_TABLE - 1)
    potential = np.concatenate([[0.0], np.cumsum((slope[1:] + slope[:-1]) / 2 * step)])
    rise = float(potential[-1])

    def relative(part: Array, pressure: Array) -> Array:
        return state.mobility(part, pressure) / state.mobility(narrowest, pressure)

    axis = viscous.axis
    if axis in periodic_axes:
        nodes, weights = np.polynomial.legendre.leggauss(points)
        conducted = 0.0
        for pressure, weight in zip(
            np.interp((nodes + 1) / 2 * rise, potential, pressures), weights / 2, strict=True
        ):
            wide = gap.copy()
            wide[gap > 0] *= np.cbrt(relative(gap[gap > 0], pressure))
            conducted += weight * flow(wide, pixel, axis, periodic_axes).permeability[axis]
    else:
        there = gap[np.isfinite(viscous.pressure)]

        def mobility(fallen: Array) -> Array:
            return relative(there, np.interp(np.clip(fallen, 0, 1) * rise, potential, pressures))

        conducted = flow(gap, pixel, axis, periodic_axes, mobility).permeability[axis]
    viscous_rise = state.mean_pressure * (state.inlet - state.outlet)
    return float(conducted * rise / (viscous.permeability[axis] * viscous_rise))
