"""Where the model itself ends: invented heights, large strains, few atoms, adhesion, materials."""

from __future__ import annotations

import numpy as np

from roughcontact.contact.cautions import Caution, Kind, careful, noted, warned
from roughcontact.contact.result import ContactResult
from roughcontact.errors import Mention
from roughcontact.theory import adhesion as adhesive
from roughcontact.units import engineering, percent

LARGE_STRAIN, SENSELESS_STRAIN = 0.1, 0.3
"""Pressure over contact modulus, which the strain is of the order of; plastic strain.

Above the first linear elasticity is inaccurate, above the second its pressures mean nothing.
"""

MANY_MISSING = 0.05
"""Share of a map that is missing or filled from which its numbers are not those of the surface."""

ATOM = 0.25e-9
"""Distance of neighboring atoms of a solid [m]."""

FEW_ATOMS = 1000
"""Atoms in contact, some 9 nm across, below which a spot is no continuum.

The area of smaller ones is off by a factor of two and more (Luan and Robbins, Nature 435 (2005)
929, doi:10.1038/nature03700).
"""

WORK_OF_ADHESION = 0.05
"""Work of adhesion of bodies in air [J/m²], as dirt and water leave it."""

SMOOTHEST = 10e-9
"""Roughness [m] that nearly every body has, of waves too short for its map.

It keeps apart whatever adhesion draws out by less (Fuller and Tabor, Proc. R. Soc. A 345 (1975)
327, doi:10.1098/rspa.1975.0138), hence all smooth metals and ceramics. Below a pixel it is at most
a tenth of the pixel.
"""

ENLARGED, DECIDED = 1.1, 1.5
"""Contact area with adhesion over that without that is worth a word, and that makes it decide."""


def filled(result: ContactResult) -> Caution | None:
    """Return what is said of points that were not measured but filled."""
    bodies = [body for body in (result.surface, result.counter_surface) if body is not None]
    share = max(body.provenance.filled_share(body.heights.size) for body in bodies)
    if share == 0:
        return None
    text = f"{percent(share)} of the {result.pair.whole} was not measured but filled smoothly"
    if share <= MANY_MISSING:
        return noted(Kind.FILLED, text, filled=share)
    return warned(
        Kind.FILLED,
        f"{text}: contact there is invented; crop the {result.pair.whole}, or let its missing "
        "points never touch, ",
        Mention("holes", "mask"),
        filled=share,
    )


def strains(result: ContactResult) -> Caution | None:
    """Return what is said of pressures that strain the bodies beyond linear elasticity."""
    ratio = result.max_pressure / result.contact_modulus
    if not ratio > LARGE_STRAIN:
        return None
    said = warned if ratio > SENSELESS_STRAIN else careful
    effect = "pressures mean nothing, areas are" if ratio > SENSELESS_STRAIN else "numbers are"
    return said(
        Kind.STRAINS,
        f"the largest pressure is {percent(ratio) if ratio <= 1 else f'{ratio:.3g} times'} "
        f"{'of ' if ratio <= 1 else ''}the contact modulus, beyond linear elasticity: {effect} "
        "estimates",
        strain=ratio,
    )


def atoms(result: ContactResult) -> Caution | None:
    """Return what is said of spots that have too few atoms to be a continuum."""
    spots = result.spots()
    if spots.count == 0:
        return None
    size = spots.halfway(spots.area)
    count = size / ATOM**2
    if not count < FEW_ATOMS:
        return None
    return warned(
        Kind.ATOMS,
        f"half of the load is on spots of about {max(count, 1):.2g} atoms "
        f"({1e18 * size:.3g} nm²) or fewer: "
        "below some nanometers no body is a continuum, and these numbers are estimates",
        atoms=count,
    )


def adhesion(result: ContactResult) -> Caution | None:
    """Return what adhesion, which is left out, does to the spots that carry half of the load.

    Each spot is taken for that of a sphere, whose radius follows from its area and load by Hertz'
    theory. Adhesion counts where it draws a body out by more than its roughness, see `SMOOTHEST`.
    """
    spots, modulus, work = result.spots(), result.contact_modulus, WORK_OF_ADHESION
    carrying = spots.load > 0
    if not carrying.any() or result.contact.all():
        return None
    load = np.where(carrying, spots.load, np.inf)
    radius = 4 * modulus * (spots.area / np.pi) ** 1.5 / (3 * load)
    drawn = adhesive.RANGE * np.maximum(adhesive.tabor(radius, modulus, work), 1.0)
    felt = carrying & (drawn > min(SMOOTHEST, 0.1 * min(result.surface.pixel)))
    grown, pull = np.ones(load.shape), np.zeros(load.shape)
    grown[felt] = adhesive.enlargement(load[felt], radius[felt], modulus, work)
    pull[felt] = adhesive.pull_off(radius[felt], modulus, work) / load[felt]
    times, share = spots.halfway(grown), spots.halfway(pull)
    if not times > ENLARGED:
        return None
    return (warned if times > DECIDED else careful)(
        Kind.ADHESION,
        f"adhesion is left out: at {engineering(work, 'J/m²')} it would enlarge the contact area "
        f"{times:.3g} times, and pull-off would take "
        f"{percent(share) if share <= 1 else f'{share:.3g} times'} "
        f"{'of ' if share <= 1 else ''}the load",
        enlargement=times,
        pull_off_over_load=share,
    )


def materials(result: ContactResult) -> Caution | None:
    """Return what the materials do that no contact here includes."""
    both = (result.material, result.counter_material)
    told = dict.fromkeys((body.name or "the body", body.caveat) for body in both if body.caveat)
    if not told:
        return None
    return warned(Kind.MATERIAL, "; ".join(f"{name}: {caveat}" for name, caveat in told))
