"""Greenwood's estimate of what contact spots conduct, and how far the estimates are off."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from roughcontact.contact.result import ContactResult
from roughcontact.contact.spots import Spots
from roughcontact.halfspace.fft import Workspace

CASES = 108
"""Contacts of rough maps on which the estimates were tried; see ``benchmarks/constriction.py``.

Periodic maps of Gaussian heights, eight waves of the roll-off a side, Hurst exponents 0.5 and 0.8,
roll-off over cut-off 4 to 16, elastic and under a ceiling, 1 to 12 % in contact.
"""

CORRELATED = (0.99, 1.44)
"""The correlations over what is computed, in 95 % of the cases.

Spots come in clusters, of which the theory of the correlations knows nothing: they tell too much.
"""

SPOTTED = (0.82, 1.0)
"""Greenwood's formula over what is computed, in 95 % of the cases: less where more touches."""


def greenwood(result: ContactResult) -> float:
    """Return the constriction length of a contact from radii and places of its spots.

    Parameters
    ----------
    result : ContactResult
        A solution.

    Returns
    -------
    float
        L [m], with 1/L = 1/(4 Σ aᵢ) + Σᵢ Σⱼ aᵢ aⱼ / sᵢⱼ / (2π (Σ aᵢ)²), aᵢ the radius of the
        circle of the area of a spot and sᵢⱼ the distance of two of them; on a periodic map their
        copies are among the others. NaN without spots, and where spots are so many that this
        has no meaning.

    Notes
    -----
    Each spot is taken for a circle that carries its share as if it were alone. For two bodies of
    resistivity ρ each this is R = ρ/(2 Σ aᵢ) + ρ/(π (Σ aᵢ)²) ΣΣ aᵢ aⱼ/sᵢⱼ. That suits
    spots that are round and further apart than they are wide; large ones of many branches it does
    not. The double sum is one convolution with the kernel of the contact, the middle of each spot
    rounded to a pixel.

    References
    ----------
    Greenwood 1966, Constriction resistance and the real area of contact, Brit. J. Appl. Phys. 17,
    1621, doi:10.1088/0508-3443/17/12/310
    """
    spots = result.spots()
    if spots.count == 0:
        return math.nan
    radii = np.sqrt(spots.area / math.pi)
    pair = result.pair
    family = pair.operators(result.precision, Workspace())
    operator = family(pair.shape, (1, 1))
    pressure = np.zeros(pair.shape)
    middle = _middles(spots, pair.boundary.periodic_axes)
    np.add.at(pressure.ravel(), middle, radii / result.pixel_area)
    near = pressure.ravel()[middle]
    # What a spot does to itself stands in the first term; its copies are in the kernel.
    alone = _self_displacement(pair.pixel, pair.contact_modulus)
    others = operator(pressure).ravel()[middle] - alone * near
    total = radii.sum()
    shared = (radii * others).sum() / total**2
    inverse = 1 / (4 * total) + pair.contact_modulus / 2 * shared
    return float(1 / inverse) if inverse > 0 else math.nan


def _middles(spots: Spots, periodic_axes: tuple[int, ...]) -> NDArray[np.int64]:
    """Return the flat indices of the pixels nearest to the middles of the spots, shape (n,)."""
    shape = spots.label.shape
    places = np.nonzero(spots.label)
    number = spots.label[places] - 1
    count = np.bincount(number, minlength=spots.count)
    middle = []
    for axis, place in enumerate(places):
        if axis in periodic_axes:
            # On a circle, so that a spot across the seam is whole.
            turn = np.exp(2j * math.pi / shape[axis] * np.arange(shape[axis]))[place]
            total = np.bincount(number, turn.real) + 1j * np.bincount(number, turn.imag)
            mean = np.angle(total) / (2 * math.pi) * shape[axis]
        else:
            mean = np.bincount(number, place) / count
        middle.append(np.rint(mean).astype(np.int64) % shape[axis])
    flat: NDArray[np.int64] = np.ravel_multi_index((middle[0], middle[1]), shape)
    return flat


def _self_displacement(pixel: tuple[float, float], contact_modulus: float) -> float:
    """Return what unit pressure on a pixel displaces its middle by, alone on a half-space."""
    dy, dx = pixel
    return 2 / (math.pi * contact_modulus) * (dx * math.asinh(dy / dx) + dy * math.asinh(dx / dy))
