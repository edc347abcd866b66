"""Contact stiffness: derivatives of load and pressure with respect to the approach.

`stiffness`: In an infinitesimal step the contact does not change: its elastic pixels are displaced
as by a rigid flat punch of the same outline, a linear problem. A circle of radius a gives 2 E* a.
The stiffness is accurate to 1e-7 at least, usually to 1e-9.

Barber 2003, Proc. R. Soc. A 459, 53, doi:10.1098/rspa.2002.1038

`unloading_stiffness`: It depends on the outline of the contact only, as does the conductance: see
`roughcontact.analyses.sweep.model.LoadCurve.constriction_length`.

`local_stiffness`: Where the outline of the contact approaches by dω and is displaced by du, the gap
closes by dω - du. Over a whole periodic map the mean of du is zero, which gives the contact
stiffness over the nominal area; over a part of a free map the compliance of the bodies below it,
which displaces all of the part, cancels.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roughcontact._tools.arrays import Array
from roughcontact.contact.memory import MemoryNeed
from roughcontact.contact.result import ContactResult
from roughcontact.errors import ConvergenceError
from roughcontact.halfspace.coating import Coatings
from roughcontact.halfspace.fft import Workspace
from roughcontact.solvers.problem import project
from roughcontact.solvers.rigid_tilt import Punch, flat_punch


@dataclass(frozen=True, eq=False)
class ContactGrowth:
    """Derivatives of a contact with respect to the approach, for a constant outline."""

    stiffness: float  # dW/dω [N/m]
    unit: float = math.nan  # K₀₀ [m/Pa]
    rate: Array | None = None  # dp/dω [Pa/m], (ny, nx)


def stiffness(result: ContactResult) -> float:
    """Return the contact stiffness dW/dω of a solution."""
    return contact_growth(result).stiffness


def unloading_stiffness(result: ContactResult) -> float:
    """Return the contact stiffness dW/dω at the beginning of unloading."""
    index = np.flatnonzero(result.contact)
    punch = _flat_punch(result, index) if index.size else None
    return 0.0 if punch is None else punch.total * result.pixel_area


def constriction_length(result: ContactResult, coatings: Coatings | None = None) -> float:
    """Return 2 K/E* of the outline of a contact on half-spaces, or on conducting layers [m].

    Divided by the sum of the resistivities of the outermost layers this is the conductance.
    """
    index, pair = np.flatnonzero(result.contact), result.pair
    if not index.size:
        return 0.0
    modulus = pair.contact_modulus
    how: dict[str, Any] = {"precision": result.precision, "workspace": Workspace()}
    operators = pair.boundary.operators(pair.shape, pair.pixel, modulus, coatings=coatings, **how)
    return 2 * _flat_punch(result, index, operators).total * result.pixel_area / modulus


def local_stiffness(
    result: ContactResult, window: tuple[slice, slice] | None = None
) -> tuple[float, float]:
    """Return the local stiffness of a part of a map [Pa/m] in loading and in unloading."""
    whole = _local_stiffness(result, np.flatnonzero(result.contact), window)
    if not result.saturated.any():
        return whole, whole
    return _local_stiffness(
        result, np.flatnonzero(result.contact & ~result.saturated), window
    ), whole


def _local_stiffness(
    result: ContactResult, index: NDArray[np.int64], window: tuple[slice, slice] | None
) -> float:
    if index.size == 0:
        return 0.0
    punch = _flat_punch(result, index)
    if math.isinf(punch.total):
        return math.inf
    if window is None and len(result.boundary.periodic_axes) == len(result.pressure.shape):
        return punch.total / result.pressure.size
    pressure = np.zeros(result.pressure.size)
    pressure[index] = punch.pressure
    part = window or (slice(None), slice(None))
    closing = 1 - punch.displacement.astype(np.float64)[part][~np.isnan(result.gap[part])]
    return float(pressure.reshape(result.pressure.shape)[part].mean() / closing.mean())


def contact_growth(result: ContactResult) -> ContactGrowth:
    """Return the contact stiffness of a solution and its rate of pressure; see `stiffness`."""
    index = np.flatnonzero(result.contact & ~result.saturated)
    if index.size == 0:
        return ContactGrowth(0.0)
    punch = _flat_punch(result, index)
    if math.isinf(punch.total):
        return ContactGrowth(math.inf)
    rate: Array = (1 - punch.displacement) / punch.unit
    rate.ravel()[index] = punch.pressure
    return ContactGrowth(punch.total * result.pixel_area, punch.unit, rate)


def _flat_punch(result: ContactResult, index: NDArray[np.int64], operators: Any = None) -> Punch:
    """Return the rigid flat punch of the given pixels of a solution."""
    shape, pair = result.pair.shape, result.pair
    MemoryNeed(shape, pair.boundary, result.precision).require(index.size / result.pressure.size)
    operators = operators or pair.operators(result.precision, Workspace())
    punch = flat_punch(shape, index, operators)
    if punch is None:
        raise ConvergenceError("stiffness not converged", result)
    return punch


def predict_pressure(
    result: ContactResult,
    grown: ContactGrowth,
    *,
    load: float | None = None,
    approach: float = math.nan,
) -> Array:
    """Return an initial guess of the pressure under another load or at another approach."""
    if grown.rate is None:
        return result.pressure
    rise = (approach - result.approach) if load is None else (load - result.load) / grown.stiffness
    values = result.pressure - result.gap / grown.unit + rise * grown.rate
    limit = np.inf if result.ceiling is None else result.ceiling
    limit = np.broadcast_to(np.float64(limit), values.shape)
    # Pixels with a gap larger than the largest value are certainly not in contact.
    near = (values > -np.nanmax(values)) & (limit > 0)
    values, limit = values[near], limit[near]
    start = np.zeros(near.shape)
    if load is None:
        start[near] = np.clip(values, 0, limit)
        return start
    total = load / result.pixel_area
    if limit.sum() < total:
        return result.pressure
    start[near] = project(values, limit, total)
    return start
