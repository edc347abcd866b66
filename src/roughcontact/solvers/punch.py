"""A rigid flat that some pixels follow: which pressures its approach takes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact.solvers.operator import Family
from roughcontact.solvers.patches import Patches

# Curvature over K₀₀ below which nothing resists a pressure.
_FLAT = 1e-12
# Part of the load that the last step may have added: what is left to add is far less.
_GAIN = 1e-7
_MOST_STEPS = 2000


@dataclass(frozen=True, eq=False)
class Punch:
    """What displaces some pixels alike, by a unit length.

    Parameters
    ----------
    total : float
        Sum of the pressures [Pa/m]; infinite where nothing resists, as on all of a periodic map.
    pressure : ndarray, shape (n,)
        Pressure on the pixels [Pa/m].
    displacement : ndarray, shape (ny, nx)
        Displacement of the map [1], 1 on the pixels.
    unit : float
        K₀₀, the displacement of a pixel under unit pressure on itself [m/Pa].
    """

    total: float
    pressure: NDArray[np.float64]
    displacement: NDArray[Any]
    unit: float


def flat_punch(shape: tuple[int, int], index: NDArray[np.int64], family: Family) -> Punch | None:
    """Return the pressures that displace some pixels by a unit length.

    Parameters
    ----------
    shape : (int, int)
        Grid points ``(ny, nx)`` of the map.
    index : ndarray of int, shape (n,)
        Flat indices of the pixels, ascending, one at least.
    family : callable
        As for `roughcontact.solvers.bounded.solve`.

    Returns
    -------
    Punch or None
        None where the search ends too early.

    Notes
    -----
    Conjugate gradients from no pressure on, in single precision. The total is a maximum,
    ``(Σp)² / ⟨p, K p⟩``, and so off by the square of what the pressure is off by: taken once in
    the arithmetic of the problem, it is good to more digits than the pressure.
    """
    operator = family(shape, (1, 1))
    patch = Patches(operator, family, (1, 1)).around(index)
    local = patch.index(index)
    support, precondition = patch.operator.support(local), patch.inverse.on(local)
    sums, unit = operator.sums, operator.self_displacement
    pressure, residual = np.zeros(index.size), np.ones(index.size)
    direction, response = pressure, residual
    previous, carried, first = math.inf, 0.0, 0.0
    for _ in range(_MOST_STEPS):
        z = precondition(residual)
        product = sums.dot(residual, z)
        if not product > 0:
            # Hardly more than rounding is left, or the inverse is none there: straight down.
            z, product = residual.copy(), sums.dot(residual, residual)
        first = first or product
        if product <= _GAIN**2 * first:
            break
        # The inverse is not quite linear: see `roughcontact.solvers.active_set`.
        direction = z - sums.dot(response, z) / previous * direction
        previous = product
        response = patch.operator.gather(support, direction) / unit
        curvature = sums.dot(direction, response)
        if curvature <= _FLAT * sums.dot(direction, direction):
            return Punch(math.inf, direction, residual, unit)
        length = product / curvature
        pressure += length * direction
        response *= length
        residual -= response
        carried += length * product
        if length * product <= _GAIN * carried:
            break
    else:
        return None
    rows = operator.rows.stop - operator.rows.start
    displacement: NDArray[Any] = np.empty((rows, shape[1]), operator.real)

    def keep(number: int, rows: slice, block: NDArray[Any]) -> None:
        displacement[rows] = block

    pressure /= unit
    operator.spread(operator.support(index), pressure, keep)
    work = sums.dot(pressure, displacement.ravel()[index].astype(np.float64))
    return Punch(sums.total(pressure) ** 2 / work, pressure, displacement, unit)
