"""What a body conducts: electricity and heat."""

from __future__ import annotations

import math
from dataclasses import dataclass
from numbers import Real

from roughcontact.arguments import checked
from roughcontact.errors import InputError
from roughcontact.units import Quantity, quantity


@dataclass(frozen=True)
class Conductor:
    """How well an isotropic body conducts.

    Parameters
    ----------
    resistivity : float, str or quantity of pint, optional
        Electrical resistivity ρ: a number in Ω m, or with its unit, as ``"17 nohm m"``.
    conductivity : float, str or quantity of pint, optional
        Thermal conductivity k: a number in W/(m K), or with its unit, as ``"46 W/m/K"``.
    name : str
        A name for reports.

    Raises
    ------
    InputError
        If a constant is not positive and finite.

    Examples
    --------
    >>> Conductor(resistivity="17 nohm m").resistivity
    1.7e-08
    """

    resistivity: float | None = None
    conductivity: float | None = None
    name: str = ""

    @checked
    def __init__(
        self,
        resistivity: Quantity | None = None,
        conductivity: Quantity | None = None,
        name: str = "",
    ) -> None:
        object.__setattr__(self, "resistivity", _positive(resistivity, "resistivity"))
        object.__setattr__(self, "conductivity", _positive(conductivity, "conductivity"))
        object.__setattr__(self, "name", name)


def _positive(value: Quantity | None, dimension: str) -> float | None:
    found = quantity(value, dimension, dimension)
    if found is None:
        return None
    if not (isinstance(found, Real) and 0 < float(found) < math.inf):
        raise InputError(
            f"must be positive and finite, got {value!r}; leave it out where it is unknown",
            argument=dimension,
            value=value,
        )
    return float(found)
