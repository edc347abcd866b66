"""Types of arrays and grids."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Shape = tuple[int, int]  # Points along y and x
Pixel = tuple[float, float]  # Edges of a pixel along y and x [m]
