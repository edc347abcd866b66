"""Contact stiffness: how fast the load grows with the approach."""

from __future__ import annotations

import math

import numpy as np

from roughcontact.contact.memory import Room
from roughcontact.contact.result import ContactResult
from roughcontact.errors import ConvergenceError, Sentence, parts_of
from roughcontact.halfspace.fft import Workspace
from roughcontact.solvers import bounded
from roughcontact.solvers.problem import Problem

# Of the pressure; that of the stiffness is about its square.
_TOLERANCE = 1e-4


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
    rigid flat punch of that outline, which is one more contact problem with a gap of zero on them
    and no contact elsewhere. A circle of radius a gives 2 E* a.

    References
    ----------
    Barber 2003, Proc. R. Soc. A 459, 53, doi:10.1098/rspa.2002.1038
    """
    index = np.flatnonzero(result.contact & ~result.saturated)
    if index.size == 0:
        return 0.0
    shape, pair = result.surface.shape, result.pair
    Room(shape, pair.boundary, result.precision).require(index.size / result.pressure.size)
    gap = np.full(shape, np.inf)
    gap.ravel()[index] = 0.0
    total = 1 / result.pixel_area
    solution = bounded.solve(
        Problem(initial_gap=gap, limit=np.inf, total=total),
        pair.operators(result.precision, Workspace()),
        tolerance=max(result.tolerance, _TOLERANCE),
        max_iterations=2000,
        start=(index, np.full(index.size, total / index.size)),
    )
    if solution.status is not bounded.Status.CONVERGED:
        text = f"stiffness not converged: certificate {solution.certificate:.1e}: "
        raise ConvergenceError(Sentence(text, *parts_of(solution.status.value)), result)
    # Twice the energy, over the load: an error of the pressure counts by its square.
    pressed = solution.approach + solution.gap.ravel()[solution.index]
    approach = float(np.sum(solution.pressure * pressed)) / float(np.sum(solution.pressure))
    # In full periodic contact the flat moves without displacing anything.
    smallest = np.finfo(float).eps * result.pixel_area * total / result.contact_modulus
    return math.inf if approach <= smallest else 1 / approach
