"""The memory that making a map takes."""

from __future__ import annotations

from roughcontact import memory

MADE = 7
"""Maps held at once while a form is laid on a grid."""

GENERATED = 3
"""The same while a random surface is generated."""

TRANSLATED = 17
"""The same while one is brought to a distribution of heights and a spectrum."""

RESAMPLED = 6
"""The same while a map is brought to another grid."""

CORRELATED = 10
"""The same while the autocorrelation of a map is made, for Sal and Str."""

COPIED = 2
"""The same while heights are copied and checked."""

PREPARED = 8
"""The same, at most, in any step of the preparation; the map itself is one of them."""

# Points below which it is not worth asking the system.
_TRIFLE = 2**20


def require(shape: tuple[int, ...], maps: int, what: str = "a map") -> None:
    """Raise an error with advice unless so many maps in double precision fit into the memory."""
    ny, nx = shape
    if ny * nx < _TRIFLE:
        return
    needed = 8 * maps * ny * nx
    side = memory.square_side(needed, (ny, nx))
    memory.require(
        needed,
        f"{what} of {ny} × {nx} points needs",
        advice=(f"a square grid of up to about {side} × {side} points fits",),
    )
