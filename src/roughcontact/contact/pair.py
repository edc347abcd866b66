"""What is pressed on what: two surfaces, two materials, and how the maps end."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from roughcontact.surface.surface import Surface


def initial_gap(surface: Surface, counter_surface: Surface | None = None) -> NDArray[np.float64]:
    """Return the gap at first touch.

    Parameters
    ----------
    surface : Surface
        The first body.
    counter_surface : Surface, optional
        The second body on the same grid; without it, a flat.

    Returns
    -------
    ndarray, shape (ny, nx)
        ``max(z) - z`` [m] with z the heights, or the sum of both; NaN where a height is missing.
    """
    heights = surface.heights
    if counter_surface is not None:
        heights = heights + counter_surface.heights
    # An empty maximum, unlike np.nanmax's warning, leaves NaN everywhere.
    highest = np.fmax.reduce(heights, axis=None)
    gap: NDArray[np.float64] = highest - heights
    return gap
