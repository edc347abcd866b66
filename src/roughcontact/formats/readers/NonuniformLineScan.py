"""Profiles with unequally spaced points, as readers create them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np


class NonuniformLineScan:
    """Positions and heights of a profile in the unit of the file."""

    is_uniform = False

    def __init__(
        self, x: Any, y: Any, unit: str | None = None, info: Mapping[str, Any] | None = None
    ) -> None:
        self._x, self._y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)

    @classmethod
    def register_function(cls, name: str, function: Any) -> None:
        """Ignore a function to register."""

    def scale(self, factor: float) -> NonuniformLineScan:
        """Return the profile with its heights multiplied."""
        return NonuniformLineScan(self._x, factor * self._y)

    def positions(self) -> Any:
        """Return the positions."""
        return self._x

    def heights(self) -> Any:
        """Return the heights."""
        return self._y
