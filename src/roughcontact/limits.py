"""How much a file or an argument may ask for: one rule, applied before anything is made."""

from __future__ import annotations

import math
from collections.abc import Sequence

from roughcontact import memory
from roughcontact.errors import FormatError, InputError

POINTS = 2**30
"""Most points of one map: 32768 × 32768, or 8 GiB of heights."""

BYTES = 8 * POINTS
"""Most bytes that a file with a map, or all that is packed in it, may take."""

TEXT = 16 * 2**20
"""Most bytes of a text that is taken apart as a whole, such as a header or a project file."""

STEPS = 10_000
"""Most loads, increments or stages of one run that a count may ask for."""

ITERATIONS = 1_000_000
"""Most iterations that a solver may be allowed."""

# Heights that were measured pack a few times smaller. What packs a hundred times smaller is made
# to fill memory, unless it is small anyway.
_PACKED, _SMALL = 100, 2**30


def require_points(name: str, shape: Sequence[int], each: int) -> None:
    """Refuse a map that a file announces where it is too large for any map, or for the memory.

    Parameters
    ----------
    name : str
        The file.
    shape : sequence of int
        Points ``(ny, nx)`` that its header announces.
    each : int
        Bytes that reading takes a point, everything counted.

    Raises
    ------
    FormatError
        If it announces more than `POINTS`.
    InsufficientMemoryError
        If reading it needs more memory than is free.
    """
    grid = " × ".join(map(str, shape))
    if math.prod(shape) > POINTS:
        raise FormatError(
            f"{name} announces {grid} points, more than the {POINTS} (2³⁰) that a map may have; "
            "check that the file is complete, or export a part of it"
        )
    memory.require(
        math.prod(shape) * each,
        f"reading the {grid} points of {name} needs",
        advice=("export a part of it",),
    )


def require_size(name: str, size: int, packed: int | None = None) -> None:
    """Refuse a file that takes, or unpacks to, more bytes than any map or than the memory.

    Parameters
    ----------
    name : str
        The file.
    size : int
        Bytes that are read of it.
    packed : int, optional
        Bytes that they are packed into.

    Raises
    ------
    FormatError
        If they are more than `BYTES`, or packed as nothing that was measured is.
    InsufficientMemoryError
        If they are more than the memory that is free.
    """
    told = f"{name} holds {size / memory.GIB:.1f} GiB"
    if size > BYTES:
        raise FormatError(
            f"{told}, more than the {BYTES / memory.GIB:.0f} GiB that a map may take; export a "
            "part of it"
        )
    if packed is not None:
        require_packing(name, size, packed)
    memory.require(size, f"reading {name} needs", advice=("export a part of it",))


def require_packing(name: str, size: int, packed: int) -> None:
    """Raise `FormatError` for bytes that are packed into so few as nothing that was measured is."""
    if size > most_unpacked(packed):
        raise FormatError(
            f"{name} holds {size / memory.GIB:.1f} GiB or more, packed into "
            f"{packed / 2**20:.1f} MiB as no measurement is; check where the file is from"
        )


def most_unpacked(packed: int) -> int:
    """Return the most bytes that a file of so many may unpack to."""
    return min(BYTES, max(_SMALL, _PACKED * packed))


def require_grid(argument: str, shape: Sequence[float], value: object = None) -> None:
    """Raise `InputError`, naming argument and value, for more points than a map may have.

    Parameters
    ----------
    argument : str
        The argument that asks for the grid.
    shape : sequence of float
        Points ``(ny, nx)``, whole or not.
    value : object, optional
        What was given for the argument; the shape without it.
    """
    # NumPy's integers would overflow, and floats may be infinite.
    points = [n if isinstance(n, float) else int(n) for n in shape]
    if math.prod(points) > POINTS:
        grid = " × ".join(f"{n:.6g}" if isinstance(n, float) else str(n) for n in points)
        raise InputError(
            f"asks for {grid} points, more than the {POINTS} (2³⁰) that a map may have",
            argument=argument,
            value=tuple(shape) if value is None else value,
        )
