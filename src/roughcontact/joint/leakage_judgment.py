"""What is known of what leaks through a gap."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from roughcontact.contact.cautions import Caution, Kind, careful, noted
from roughcontact.contact.result import ContactResult
from roughcontact.joint.filling import AIR_MASS, ATMOSPHERE, HELIUM_MASS, slip_factor
from roughcontact.joint.flow import Flow
from roughcontact.joint.percolation import Constriction
from roughcontact.theory.rarefied import mean_free_path
from roughcontact.units import changed_by, engineering, percent

THRESHOLD = 0.42
"""Contact fraction at which isotropic self-affine contact closes all ways.

Dapp, Lücke, Persson and Müser 2012, doi:10.1103/PhysRevLett.108.244301.
"""

_NEAR = 0.1
# Distance from it within which what leaks is that of a few constrictions.

_MOVED = 0.1

GAS = 5e-5
"""Viscosity [Pa s] below which a fluid is a gas: those have 9 to 35 µPa s, liquids 200 and more."""

# Factor by which helium leaks more from which on slip is told.
_SLIPS = 1.05


def of_step(
    result: ContactResult,
    places: tuple[Constriction | None, Constriction | None],
    axes: tuple[int, ...],
) -> Iterator[Caution]:
    """Yield what is known of the leakage of one contact."""
    if not result.contact.any():
        yield noted(Kind.WAYS, "the bodies do not touch: what flows is that of an open gap")
    closed = [axis for axis in axes if places[axis] is None]
    if closed:
        names = " and ".join("yx"[axis] for axis in closed)
        yield noted(
            Kind.WAYS,
            f"no way leads through the gap along {names}: with {percent(result.contact_fraction)} "
            "of the map in contact nothing leaks on these pixels; a larger map may have a way",
            contact_fraction=result.contact_fraction,
        )
    elif abs(result.contact_fraction - THRESHOLD) < _NEAR:
        yield careful(
            Kind.WAYS,
            f"{percent(result.contact_fraction)} of the map are in contact; where about "
            f"{percent(THRESHOLD)} are, an isotropic rough joint closes, and what leaks is that "
            "of a single constriction: another part of the same face may leak many times as much",
            contact_fraction=result.contact_fraction,
        )


def slip(
    gap: NDArray[np.float64], flows: Sequence[Flow], viscosity: float, pressure_difference: float
) -> Iterator[Caution]:
    """Yield by how much a gas leaks more than is told, the lightest and air at its viscosity.

    Parameters
    ----------
    gap : ndarray, shape (ny, nx)
        Gap [m], 0 where it is closed.
    flows : sequence of Flow
        What flows without slip.
    viscosity, pressure_difference : float
        Of the fluid [Pa s], and from inlet to outlet [Pa].
    """
    open_flows = [flow for flow in flows if flow.percolates]
    if viscosity >= GAS or not open_flows:
        return
    # The outlet at the atmosphere, and in vacuum.
    outer, inner = ATMOSPHERE + pressure_difference / 2, pressure_difference / 2
    air, helium = (
        max(
            slip_factor(gap, flow.density, mean_free_path(viscosity, pressure, mass))
            for flow in open_flows
        )
        for pressure, mass in ((outer, AIR_MASS), (inner, HELIUM_MASS))
    )
    if helium < _SLIPS:
        return
    # Of the plane gap that lets as much through.
    knudsen = (air - 1) / 6
    yield careful(
        Kind.SLIP,
        f"gases slip: air with its outlet at 1 atm (Kn {knudsen:.2g}) leaks at least {air:.2g} "
        f"times what is told, helium into vacuum {helium:.2g} times",
        knudsen=knudsen,
        air=air,
        helium=helium,
    )


def grid(changes: tuple[float, float], pixel: float) -> Iterator[Caution]:
    """Yield what is said of permeabilities that change on a grid of twice the pixel [m]."""
    worst: float = max(
        (change for change in changes if not math.isnan(change)), key=abs, default=0.0
    )
    if abs(worst) <= _MOVED:
        return
    yield careful(
        Kind.STUDY,
        f"on a grid with pixels of {engineering(pixel, 'm')} the permeability changes by "
        f"{changed_by(worst)}: it hangs on the narrowest gaps, which the map does not resolve",
        change=worst,
    )
