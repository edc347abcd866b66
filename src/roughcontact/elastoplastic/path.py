"""Paths that a contact goes: load, place of the counter-body and friction, point by point."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from numbers import Real
from typing import Any

import numpy as np

from roughcontact.arguments import checked
from roughcontact.contact.pair import Pair
from roughcontact.errors import InputError
from roughcontact.halfspace.layers import Pull
from roughcontact.surface.placement import shifted
from roughcontact.units import Quantities, Quantity, quantity


@dataclass(frozen=True)
class PathPoint:
    """A point of the path of a contact.

    Parameters
    ----------
    load : float, str or quantity of pint
        Normal load [N]; zero separates the bodies.
    offset : (float, float), str or quantity of pint
        How far the counter-surface has moved along ``(y, x)`` [m].
    friction : float
        Coefficient μ of full sliding: traction μ p on the rough body.
    direction : float
        Of that traction [degrees], counter-clockwise from x as seen in the map.

    Raises
    ------
    InputError
        If a value is not finite, the load or the coefficient negative.
    """

    load: float
    offset: tuple[float, float] = (0.0, 0.0)
    friction: float = 0.0
    direction: float = 0.0

    @checked
    def __init__(
        self,
        load: Quantity,
        offset: Quantities = (0.0, 0.0),
        friction: float = 0.0,
        direction: float = 0.0,
    ) -> None:
        object.__setattr__(self, "load", quantity(load, "force", "load"))
        object.__setattr__(self, "offset", _two(quantity(offset, "length", "offset")))
        object.__setattr__(self, "friction", friction)
        object.__setattr__(self, "direction", direction)
        for name, minimum in (("load", 0.0), ("friction", 0.0), ("direction", -math.inf)):
            value = getattr(self, name)
            if not (isinstance(value, Real) and minimum <= float(value) < math.inf):
                raise InputError(
                    f"must be finite{' and not negative' if minimum == 0 else ''}, got {value!r}",
                    argument=name,
                    value=value,
                )
            object.__setattr__(self, name, float(value))

    @property
    def traction(self) -> Pull:
        """Traction on the rough body along x and y over the pressure."""
        angle = math.radians(self.direction)
        # A right angle has a cosine of 6e-17, which is no traction.
        shares = (round(math.cos(angle), 15), round(math.sin(angle), 15))
        return self.friction * shares[0], self.friction * shares[1]

    def between(self, end: PathPoint, part: int, count: int) -> PathPoint:
        """Return a point after some of n equal parts of the straight line to another.

        Friction is that of the other from the start.
        """
        (y, x), (end_y, end_x) = self.offset, end.offset
        ways = (self.load, end.load), (y, end_y), (x, end_x)
        load, y, x = (start + (stop - start) * part / count for start, stop in ways)
        return PathPoint(load, (y, x), end.friction, end.direction)


def moved(pair: Pair, offset: tuple[float, float]) -> Pair:
    """Return a pair whose counter-surface has moved along ``(y, x)`` [m]; see `shifted`."""
    counter = pair.counter_surface
    if counter is None or not any(offset):
        return pair
    return replace(pair, counter_surface=shifted(counter, offset, pair.boundary.periodic_axes))


def _two(values: Any) -> tuple[float, float]:
    if (
        isinstance(values, Sequence | np.ndarray)
        and len(values) == 2
        and all(isinstance(value, Real) and math.isfinite(value) for value in values)
    ):
        return float(values[0]), float(values[1])
    raise InputError(
        f"must be two finite numbers, along y and x [m], got {values!r}",
        argument="offset",
        value=values,
    )
