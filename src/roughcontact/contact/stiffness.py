"""Contact stiffness: how fast the load grows with the approach."""

from __future__ import annotations

import numpy as np

from roughcontact.contact.memory import Room
from roughcontact.contact.result import ContactResult
from roughcontact.errors import ConvergenceError
from roughcontact.halfspace.fft import Workspace
from roughcontact.solvers.punch import load_of_unit_approach


def stiffness(result: ContactResult) -> float:
    """Return the contact stiffness dW/dω of a solution.

    Parameters
    ----------
    result : ContactResult
        A solution.

    Returns
    -------
    float
        Increase of the load with the approach [N/m] as the load grows and the tilt stays.
        Saturated pixels carry no more; 0 where every touching pixel is saturated, infinite in a
        full periodic contact.

    Raises
    ------
    ConvergenceError
        If the tolerance was not reached.
    InsufficientMemoryError
        If the problem does not fit into the memory that is free.

    Notes
    -----
    Within the small step the contact does not change: its elastic pixels are pressed like a
    rigid flat punch of that outline, one more linear problem. A circle of radius a gives 2 E* a.
    The stiffness is good to about 1e-9.

    References
    ----------
    Barber 2003, Proc. R. Soc. A 459, 53, doi:10.1098/rspa.2002.1038
    """
    index = np.flatnonzero(result.contact & ~result.saturated)
    if index.size == 0:
        return 0.0
    shape, pair = result.surface.shape, result.pair
    Room(shape, pair.boundary, result.precision).require(index.size / result.pressure.size)
    resisted = load_of_unit_approach(shape, index, pair.operators(result.precision, Workspace()))
    if resisted is None:
        raise ConvergenceError("stiffness not converged", result)
    return resisted * result.pixel_area
