"""Errors that a caller may want to tell apart; each message says what, found, do."""

from __future__ import annotations

import math
from numbers import Real
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from roughcontact.contact.result import ContactResult
    from roughcontact.volume.solve import ElastoplasticResult


class RoughcontactError(Exception):
    """Base of every error that this package raises on purpose."""


class InputError(RoughcontactError, ValueError):
    """An argument, a quantity or the content of a file cannot be used."""


class FormatError(InputError):
    """A file is missing, unreadable, truncated or of another type than expected."""


class CapacityError(InputError):
    """The load or approach asked for has no solution."""


class InsufficientMemoryError(RoughcontactError, MemoryError):
    """The problem needs more memory than the machine has."""


class ConvergenceError(RoughcontactError, RuntimeError):
    """The solver stopped above its tolerance.

    Attributes
    ----------
    result : ContactResult or ElastoplasticResult
        The best result found; its ``status`` says why the solver stopped.
    """

    def __init__(self, message: str, result: ContactResult | ElastoplasticResult) -> None:
        super().__init__(message, result)
        self.result = result

    def __str__(self) -> str:
        """Return the message alone."""
        return str(self.args[0])


def require_positive(**values: float) -> None:
    """Raise `InputError`, naming argument and value, unless all values are positive and finite."""
    for name, value in values.items():
        if not isinstance(value, Real) or not 0 < value < math.inf:
            raise InputError(f"{name} must be positive and finite, got {value!r}")


def require_pixel(pixel: tuple[float, float]) -> None:
    """Raise `InputError` unless both edges of a pixel are positive and finite."""
    if len(pixel) != 2 or not all(0 < edge < math.inf for edge in pixel):
        raise InputError(f"pixel must be positive and finite (dy, dx) [m], got {pixel!r}")
