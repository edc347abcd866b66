"""The part of a map that stands for a wide joint: without the rim of a free one."""

from __future__ import annotations

import math

from roughcontact.contact.pair import Pair
from roughcontact.errors import InputError, Mention
from roughcontact.surface import spectrum
from roughcontact.units import engineering, lengths

RIM = 3.0
"""Autocorrelation lengths that a rim is wide.

Beyond the edge of a free map nothing touches. What lacks there, the local relation of pressure and
gap feels as far as its longest waves reach: on self-affine maps with a roll-off, three lengths Sal
are about its longest wave, and what is left inside follows the relation of the same map made
periodic to some 2 %, whatever pressure the edge takes on (``tests/physics/test_interface_law``).
"""

LEAST_POINTS = 16
"""Points along each side below which a part of a map has no law."""

# Part of each side that the rims may take at most.
_MOST = 0.5

Window = tuple[slice, slice]


def window_of(pair: Pair) -> tuple[Window | None, float]:
    """Return the part of a map inside its rim, and how wide that rim is.

    Parameters
    ----------
    pair : Pair
        The bodies.

    Returns
    -------
    (slice, slice) or None
        Rows and columns inside; None where all of the map counts.
    float
        Width of the rim along the free edges [m].

    Raises
    ------
    InputError
        If the map is too small, or the rim leaves less than half of a side.
    """
    if min(pair.shape) < LEAST_POINTS:
        ny, nx = pair.shape
        raise InputError(
            f"has {ny} × {nx} points: an interface law needs {LEAST_POINTS} along each side",
            argument="surface",
        )
    free = pair.boundary.free_axes
    if not free:
        return None, 0.0
    length, _, _ = spectrum.texture(pair.initial_gap, pair.pixel)
    rim = RIM * length
    slices = [slice(0, points) for points in pair.shape]
    for axis in free:
        side = pair.size[axis]
        if math.isnan(rim) or 2 * rim > _MOST * side:
            raise _nothing_left(pair, rim)
        margin = math.ceil(rim / pair.pixel[axis])
        slices[axis] = slice(margin, pair.shape[axis] - margin)
    if min(part.stop - part.start for part in slices) < LEAST_POINTS:
        raise _nothing_left(pair, rim)
    return (slices[0], slices[1]), rim


def _nothing_left(pair: Pair, rim: float) -> InputError:
    wide = "without end" if math.isnan(rim) else f"of {engineering(rim, 'm', 3)}"
    return InputError(
        f"of {lengths(pair.size)} is too small for a free boundary: a rim {wide} along each edge, "
        f"{RIM:.0f} autocorrelation lengths, leaves less than half of a side; take long waves out "
        "with ", Mention("l"), ", give a larger map, or ", Mention("boundary", "periodic"),
        argument="surface",
    )  # fmt: skip
