"""Catalog of gases and liquids in a gap, with sources, from ``fluids.toml``."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

from roughcontact.errors import input_error
from roughcontact.material.catalog import Value, read_rows

STORED = Path(__file__).with_name("fluids.toml")

GAS_CONSTANT = 8.314462618
"""Gas constant R [J/(mol K)]."""

_TABLE_TEMPERATURE = 300.0


@dataclass(frozen=True)
class Gas:
    """Ideal gas."""

    name: str
    molar_mass: Value  # M [kg/mol]
    viscosity: Value  # η at 300 K [Pa s]
    conductivity: Value  # k at 300 K [W/(m K)]
    exponent: Value  # Exponent of the temperature, in viscosity and conductivity
    heat_capacity_ratio: Value  # γ
    accommodation: Value  # Share a of the molecules that reach the temperature of a metal

    def viscosity_at(self, temperature: float) -> float:
        """Return the viscosity η at a temperature [Pa s]."""
        return self.viscosity.value * self._growth(temperature)

    def conductivity_at(self, temperature: float) -> float:
        """Return the thermal conductivity k at a temperature [W/(m K)]."""
        return self.conductivity.value * self._growth(temperature)

    def _growth(self, temperature: float) -> float:
        return float((temperature / _TABLE_TEMPERATURE) ** self.exponent.value)

    @property
    def prandtl(self) -> float:
        """Prandtl number η c_p/k, with the c_p of an ideal gas."""
        ratio = self.heat_capacity_ratio.value
        heat = ratio / (ratio - 1) * GAS_CONSTANT / self.molar_mass.value
        return heat * self.viscosity.value / self.conductivity.value


@dataclass(frozen=True)
class Liquid:
    """Liquid or paste."""

    name: str
    conductivity: Value  # k at room temperature [W/(m K)]


@cache
def entries() -> dict[str, Gas | Liquid]:
    """Return all fluids by name."""
    fluids = (*read_rows(STORED, "gas", Gas), *read_rows(STORED, "liquid", Liquid))
    return {fluid.name: fluid for fluid in fluids}


def gas(name: str, argument: str = "gas") -> Gas:
    """Return a gas by its name."""
    result = entries().get(name)
    if not isinstance(result, Gas):
        known = ", ".join(item.name for item in entries().values() if isinstance(item, Gas))
        raise input_error(argument, name, f"must be one of {known}")
    return result
