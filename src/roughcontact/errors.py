"""Errors that a caller may want to tell apart; each message says what, found, do."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from roughcontact.result import ContactResult


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
    result : ContactResult
        The best result found; its ``status`` says why the solver stopped.
    """

    def __init__(self, message: str, result: ContactResult) -> None:
        super().__init__(message)
        self.result = result
