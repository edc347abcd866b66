"""Asperities of a surface after Greenwood and Tripp, from moments of its spectrum."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Asperities:
    """What programs of mixed lubrication ask of a rough surface.

    Parameters
    ----------
    m0, m2, m4 : float
        Mean squares of height [m²], of slope, and of curvature [1/m²] along profiles; the mean of
        both directions. m₄, and with it density and radius, is set by the smallest scales, which
        the pixel cuts.

    Notes
    -----
    η = m₄/(6π√3 m₂) and R = 3√π/(8√m₄) are those of an isotropic Gaussian surface.

    References
    ----------
    Greenwood and Tripp 1970, doi:10.1243/PIME_PROC_1970_185_069_02
    Nayak 1971, doi:10.1115/1.3451608;
    McCool 1987, J. Tribol. 109, 264
    """

    m0: float
    m2: float
    m4: float

    @property
    def deviation(self) -> float:
        """Standard deviation of the heights σ [m]."""
        return math.sqrt(self.m0)

    @property
    def density(self) -> float:
        """Summits per area η [1/m²]."""
        return self.m4 / (6 * math.pi * math.sqrt(3) * self.m2)

    @property
    def radius(self) -> float:
        """Mean radius of the summits R [m]."""
        return 3 * math.sqrt(math.pi) / (8 * math.sqrt(self.m4))

    @property
    def bandwidth(self) -> float:
        """α = m₀ m₄/m₂², 1.5 of a single wavelength and growing with the breadth of a spectrum."""
        return self.m0 * self.m4 / self.m2**2

    @property
    def roughness_parameter(self) -> float:
        """η R σ."""
        return self.density * self.radius * self.deviation


def asperities(heights: Array, pixel: tuple[float, float]) -> Asperities:
    """Return the moments of a map.

    Parameters
    ----------
    heights : ndarray, shape (ny, nx)
        Heights or gap [m], leveled; NaN where missing.
    pixel : (float, float)
        Pixel edges ``(dy, dx)`` [m].

    Returns
    -------
    Asperities
        From differences of neighbors.
    """
    slopes, curvatures = [], []
    for axis, edge in enumerate(pixel):
        slopes.append(np.nanmean((np.diff(heights, axis=axis) / edge) ** 2))
        curvatures.append(np.nanmean((np.diff(heights, 2, axis=axis) / edge**2) ** 2))
    return Asperities(float(np.nanvar(heights)), float(np.mean(slopes)), float(np.mean(curvatures)))
