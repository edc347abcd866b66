"""Where readers register what a map can be written as: nobody asks for it here."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class UniformTopographyInterface:
    """What SurfaceTopography's maps offer, in name."""

    @classmethod
    def register_function(cls, name: str, function: Callable[..., Any]) -> None:
        """Take a function that is not needed."""
