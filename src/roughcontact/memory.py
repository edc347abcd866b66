"""How much memory is free, and what to say where a job needs more."""

from __future__ import annotations

import math

from roughcontact.errors import InsufficientMemoryError, Part

GIB = 2**30


def free() -> int:
    """Return the bytes that a new array may take now."""
    import psutil

    return int(psutil.virtual_memory().available)


def require(needed: int, *what: Part, advice: tuple[Part, ...]) -> None:
    """Raise an error with advice unless a job fits into the memory that is free.

    Parameters
    ----------
    needed : int
        Bytes, by the job's own estimate.
    *what : str or Mention
        The job, as the subject of a sentence: ``"a map of 512 × 512 points needs"``.
    advice : tuple of str or Mention
        What would fit.

    Raises
    ------
    InsufficientMemoryError
        If the estimate exceeds the memory that is free.
    """
    there = free()
    if needed > there:
        raise InsufficientMemoryError(
            *what,
            f" about {needed / GIB:.1f} GiB, and {there / GIB:.1f} GiB are free: ",
            *advice,
        )


def square_side(needed: int, shape: tuple[int, int]) -> int:
    """Return the points along the largest square grid that fits, by an estimate for another.

    Parameters
    ----------
    needed : int
        Bytes for a grid of ``shape``; taken as proportional to its points.
    shape : (int, int)
        Grid points ``(ny, nx)``.
    """
    return int(math.sqrt(free() / needed * shape[0] * shape[1]))
