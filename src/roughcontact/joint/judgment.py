"""What is known of the estimates that stand beside what a joint does."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from roughcontact.contact.cautions import Caution, Kind, careful, noted
from roughcontact.contact.pair import Pair
from roughcontact.errors import Mention
from roughcontact.surface import leveling, roughness
from roughcontact.units import changed_by, engineering, percent

CURVED = 0.75
"""Share of the variance of the gap in a quadric from which the bodies are curved as a whole.

Of nine measured maps a mirror has 0.91 and the cylinder of a fired bullet 0.76; flat ones have less
than 0.6, parts of self-affine maps without a roll-off up to 0.73.
"""

_DISCS = (0.8, 1.25)
# Of Greenwood's formula over what is computed: 0.82 to 1 on rough maps up to a tenth in contact.

_MOVED = 0.05


@dataclass(frozen=True, eq=False)
class Texture:
    """Roughness of the gap between two bodies, as the correlations of flat joints take it.

    Parameters
    ----------
    pair : Pair
        The bodies.
    """

    pair: Pair

    @cached_property
    def height(self) -> float:
        """Root-mean-square height σ of the gap [m]."""
        return float(np.nanstd(self.pair.initial_gap))

    @cached_property
    def gradient(self) -> float:
        """Root-mean-square gradient h′ of the gap."""
        return roughness.rms_gradient(self.pair.initial_gap, self.pair.pixel)

    @cached_property
    def curved(self) -> float:
        """Share of the variance of the gap that is in a quadric; 0 where the map is periodic."""
        gap = self.pair.initial_gap
        if self.pair.boundary.periodic_axes or not self.height > 0 or min(gap.shape) < 3:
            return 0.0
        return 1 - float(np.nanvar(leveling.level(gap, "quadric"))) / self.height**2

    @property
    def is_flat(self) -> bool:
        """Whether the bodies are nominally flat, as far as the map tells."""
        return self.curved < CURVED


def form(texture: Texture) -> tuple[Caution, ...]:
    """Return what is said where the correlations of flat joints are left out of bodies."""
    if texture.is_flat:
        return ()
    return (
        noted(
            Kind.FORM,
            f"the bodies are curved as a whole ({percent(texture.curved)} of the variance of the "
            "gap is a quadric, which is no roughness), so that the correlations of flat joints are "
            "left out; for the joint of a flat face remove the form with ",
            Mention("level", "quadric"),
            curved=texture.curved,
        ),
    )


def discs(load: float, contact_fraction: float, estimate: float, length: float) -> Caution | None:
    """Return what is said where Greenwood's formula is far off, of one load [N]."""
    if not (0 < length < np.inf) or _DISCS[0] <= estimate / length <= _DISCS[1]:
        return None
    ratio = estimate / length
    told = "has no meaning" if np.isnan(ratio) else f"gives {ratio:.2g} of what is computed"
    return noted(
        Kind.SPOTS,
        f"Greenwood's formula takes each spot for a disc: with {percent(contact_fraction)} of the "
        f"map in contact the spots are large, of many branches, and close, and it {told}; take the "
        "computed length",
        load=load,
        ratio=ratio,
    )


def grid(change: float, area_change: float, pixel: float) -> Caution | None:
    """Return what is said of a length that changes on a grid of twice the pixel [m]."""
    if abs(change) <= _MOVED:
        return None
    return careful(
        Kind.STUDY,
        f"on a grid with pixels of {engineering(pixel, 'm')} the constriction length changes by "
        f"{changed_by(change)} (contact area {changed_by(area_change)}): the map does not resolve "
        "what conducts",
        change=change,
    )
