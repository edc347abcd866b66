"""What is known of what leaks through a gap."""

from __future__ import annotations

import math
from collections.abc import Iterator

from roughcontact.contact.cautions import Caution, Kind, careful, noted
from roughcontact.contact.result import ContactResult
from roughcontact.joint.percolation import Constriction
from roughcontact.units import changed_by, engineering, percent

THRESHOLD = 0.42
"""Contact fraction at which isotropic self-affine contact closes all ways.

Dapp, Lücke, Persson and Müser 2012, doi:10.1103/PhysRevLett.108.244301.
"""

_NEAR = 0.1
# Distance from it within which what leaks is that of a few constrictions.

_MOVED = 0.1


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
