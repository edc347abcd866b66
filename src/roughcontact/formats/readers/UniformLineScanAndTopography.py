"""Maps and profiles that readers create, with the interface of SurfaceTopography."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np


class Topography:
    """Heights ``[x, y]`` and sides ``(x, y)`` in the unit of the file."""

    def __init__(
        self,
        heights: Any,
        physical_sizes: Sequence[float],
        periodic: bool | None = False,
        unit: str | None = None,
        info: Mapping[str, Any] | None = None,
    ) -> None:
        if np.ndim(heights) != 2:
            raise ValueError("the heights are no map")
        if not np.ma.is_masked(heights) and not np.isfinite(heights).all():
            heights = np.ma.masked_invalid(heights)
        self._heights = np.asanyarray(heights, dtype=float)
        self._sizes = physical_sizes
        self._factor: float | None = None

    def scale(self, factor: float) -> Topography:
        """Return the map with its heights multiplied."""
        scaled = Topography(self._heights, self._sizes)
        scaled._factor = factor
        return scaled

    @property
    def pixel_size(self) -> tuple[float, float]:
        """Edges of a pixel, ``(x, y)``."""
        (nx, ny), (x, y) = self._heights.shape, self._sizes
        return x / nx, y / ny

    def heights(self) -> Any:
        """Return the heights, masked where some are missing."""
        return self._heights if self._factor is None else self._factor * self._heights


class UniformLineScan:
    """Heights and length of a profile in the unit of the file; see `Topography`."""

    is_uniform = True

    def __init__(
        self,
        heights: Any,
        physical_sizes: float | Sequence[float],
        periodic: bool | None = False,
        unit: str | None = None,
        info: Mapping[str, Any] | None = None,
    ) -> None:
        if np.ndim(heights) != 1:
            raise ValueError("the heights are no profile")
        self._heights: Any = np.ma.masked_invalid(np.ma.asanyarray(heights, dtype=float))
        self._size = float(np.ravel(physical_sizes)[0])

    @classmethod
    def register_function(cls, name: str, function: Any) -> None:
        """Ignore a function to register."""

    def scale(self, factor: float) -> UniformLineScan:
        """Return the profile with its heights multiplied."""
        return UniformLineScan(factor * self._heights, self._size)

    @property
    def pixel_size(self) -> tuple[float]:
        """Distance between the points."""
        return (self._size / self._heights.size,)

    def heights(self) -> Any:
        """Return the heights, masked where some are missing."""
        return self._heights
