"""Adhesion of a sphere in closed form.

References
----------
Johnson, Kendall and Roberts, Proc. R. Soc. A 324 (1971) 301,
doi:10.1098/rspa.1971.0141; Derjaguin, Muller and Toporov, J. Colloid Interface Sci. 53 (1975) 314,
doi:10.1016/0021-9797(75)90018-1; Tabor, ibid. 58 (1977) 2, doi:10.1016/0021-9797(77)90366-6;
Maugis, ibid. 150 (1992) 243, doi:10.1016/0021-9797(92)90285-T; Carpick, Ogletree and Salmeron,
ibid. 211 (1999) 395, doi:10.1006/jcis.1998.6027
"""

from __future__ import annotations

from typing import Any

import numpy as np

ADHESION_RANGE = 0.2e-9
"""Distance z₀ [m] at which two bodies neither attract nor repel each other."""


def tabor(radius: Any, modulus: float, work: float) -> Any:
    """Return the Tabor parameter: elastic deformation by adhesion over the force range.

    Parameters
    ----------
    radius : float or array
        Radius R of the sphere [m].
    modulus : float
        Contact modulus E* [Pa].
    work : float
        Work of adhesion w [J/m²].

    Returns
    -------
    float or array
        μ = (R w²/(E*² z₀³))^(1/3) (Tabor 1977): above 5 the theory of Johnson, Kendall and Roberts
        holds, below 0.1 that of Derjaguin, Muller and Toporov.
    """
    return np.cbrt(radius * (work / modulus) ** 2) / ADHESION_RANGE


def pull_off(radius: Any, modulus: float, work: float) -> Any:
    """Return the pull-off force of a sphere [N].

    Parameters
    ----------
    radius, modulus, work : float or array
        As for `tabor`.

    Returns
    -------
    float or array
        From 1.5 π w R for soft and large spheres (Johnson, Kendall and Roberts 1971) to 2 π w R for
        hard and small spheres (Carpick, Ogletree and Salmeron 1999, eq. 12b).
    """
    strength = 4.04 * _maugis(radius, modulus, work) ** 1.4
    return np.pi * work * radius * (7 / 4 - (strength - 1) / (strength + 1) / 4)


def enlargement(load: Any, radius: Any, modulus: float, work: float) -> Any:
    """Return the ratio of the contact areas of a sphere with and without adhesion.

    Parameters
    ----------
    load : float or array
        Load W [N], positive.
    radius, modulus, work : float or array
        As for `tabor`.

    Returns
    -------
    float or array
        At least 1. After Carpick, Ogletree and Salmeron (1999), eqs. 9, 12a and 13, with a factor
        1.02 omitted, so that the limit is (1 + 3 x + √(6 x + 9 x²))^(2/3) with x = π w R/W for
        soft and large spheres (Johnson, Kendall and Roberts 1971); within 4 % of Maugis (1992).
    """
    strength = _maugis(radius, modulus, work)
    alpha = 1 - np.exp(-strength / 0.924)
    # Contact radius at zero load, over (π w R²/K)^(1/3) with K = 4 E*/3.
    grown = 2.28 * strength**1.3
    start = 1.54 + 0.279 * (grown - 1) / (grown + 1)
    ratio = load / pull_off(radius, modulus, work)
    drawn = (alpha + np.sqrt(1 + ratio)) / (1 + alpha)
    size = start * np.cbrt(np.pi * work * radius / load) * drawn ** (2 / 3)
    return np.maximum(size, 1.0) ** 2


def _maugis(radius: Any, modulus: float, work: float) -> Any:
    """Return the Maugis parameter λ, 1.157 times the Tabor parameter."""
    return 1.157 * tabor(radius, modulus, work)
