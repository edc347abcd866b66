"""Units in which a contact is solved: powers of two, which change no digit.

Coarse grids are transformed in single precision, whose numbers end at 1e38, and norms are sums of
squares: what is pressed may be 1e-30 m high, and a load 1e-100 N.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from roughcontact.contact.pair import Pair
from roughcontact.contact.terms import Terms
from roughcontact.errors import InputError

# The largest gap in these units, at most: single precision holds it with room for sums.
_DEEPEST = 2.0**64
# Beyond it, and below its inverse, sums of squares overflow or vanish even in double precision.
_RANGE = 1e120


@dataclass(frozen=True)
class Scale:
    """What one stands for while a contact is solved.

    Parameters
    ----------
    length : float
        Unit of gaps and displacements [m], a power of two.
    pressure : float
        Unit of pressures [Pa], a power of two.
    """

    length: float
    pressure: float


def of(pair: Pair, terms: Terms, gap: NDArray[np.float64]) -> Scale:
    """Return units in which pressures and displacements are near one, and no gap is out of range.

    Parameters
    ----------
    pair : Pair
        The bodies.
    terms : Terms
        How they are pressed together.
    gap : ndarray, shape (rows, nx)
        Gap at first touch [m], infinite where the bodies never touch.

    Raises
    ------
    InputError
        If the load is a mean pressure, or the approach a length, whose square no number holds.
    """
    here = np.max(gap, where=np.isfinite(gap), initial=0.0, keepdims=True)
    deepest = pair.sums.largest(here)
    softness = math.sqrt(pair.pixel_area) / pair.contact_modulus
    if terms.load is not None:
        mean = terms.load / pair.pixel_area / math.prod(pair.shape)
        _require_range(
            "load", f"{terms.load:.6g} {pair.load_unit} is a mean pressure of {mean:.3g} Pa", mean
        )
        sunk = softness * mean
    else:
        assert terms.approach is not None
        sunk = terms.approach
        _require_range("approach", f"{sunk:.6g} m", sunk)
    length = _power_of_two(max(sunk, deepest / _DEEPEST))
    return Scale(length, _power_of_two(length / softness))


def _require_range(argument: str, words: str, value: float) -> None:
    if not 1 / _RANGE < value < _RANGE:
        raise InputError(
            f"= {words}: too {'small' if value < 1 else 'large'} to be computed with; "
            "check its unit and those of the map",
            argument=argument,
            value=value,
        )


def _power_of_two(value: float) -> float:
    return math.ldexp(1.0, math.frexp(value)[1])
