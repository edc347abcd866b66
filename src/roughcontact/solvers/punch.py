"""A rigid flat that some pixels follow: how much load its approach takes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from roughcontact.solvers.operator import Family
from roughcontact.solvers.patches import Patches

# Curvature over K₀₀ below which nothing resists a pressure.
_FLAT = 1e-12
# Part of the load that the last step may have added: what is left to add is far less.
_GAIN = 1e-7
_MOST_STEPS = 2000


def load_of_unit_approach(
    shape: tuple[int, int], index: NDArray[np.int64], family: Family
) -> float | None:
    """Return the sum of the pressures that displace some pixels by a unit length.

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
    float or None
        Σp over the displacement [Pa/m]; infinite where nothing resists, as on all of a periodic
        map; None where the search ends too early.

    Notes
    -----
    Conjugate gradients from no pressure on, in single precision. The sum is a maximum,
    ``(Σp)² / ⟨p, K p⟩``, and so off by the square of what the pressure is off by: taken once in
    the arithmetic of the problem, it is good to more digits than the pressure.
    """
    operator = family(shape, (1, 1))
    patch = Patches(operator, family, (1, 1)).around(index)
    if patch.operator.shape != operator.shape:
        operator = family(patch.operator.shape, (1, 1))
    index = patch.index(index)
    support, precondition = patch.operator.support(index), patch.inverse.on(index)
    sums, unit = operator.sums, patch.operator.self_displacement
    pressure, residual = np.zeros(index.size), np.ones(index.size)
    direction, response = pressure, residual
    previous, carried = math.inf, 0.0
    for _ in range(_MOST_STEPS):
        z = precondition(residual)
        product = sums.dot(residual, z)
        if not product > 0:
            return None
        # The inverse is not quite linear: see `roughcontact.solvers.active_set`.
        direction = z - sums.dot(response, z) / previous * direction
        previous = product
        response = patch.operator.gather(support, direction) / unit
        curvature = sums.dot(direction, response)
        if curvature <= _FLAT * sums.dot(direction, direction):
            return math.inf
        length = product / curvature
        pressure += length * direction
        response *= length
        residual -= response
        carried += length * product
        if length * product <= _GAIN * carried:
            break
    else:
        return None
    displacement = operator.gather(operator.support(index), pressure)
    return sums.total(pressure) ** 2 / sums.dot(pressure, displacement)
