"""Registration of export formats by readers: unused here."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class UniformTopographyInterface:
    """Interface of the maps of SurfaceTopography, by name only."""

    @classmethod
    def register_function(cls, name: str, function: Callable[..., Any]) -> None:
        """Take a function that is not needed."""
