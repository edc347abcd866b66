"""Replacement for SurfaceTopography's registration of export formats, not needed here."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class UniformTopographyInterface:
    """Interface of the maps of SurfaceTopography, needed by name only."""

    @classmethod
    def register_function(cls, name: str, function: Callable[..., Any]) -> None:
        """Ignore a function to register."""
