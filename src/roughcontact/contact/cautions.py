"""What a reader of the numbers has to know: a kind for programs, a sentence for people."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from roughcontact.errors import Mention, Part, Sentence


class Kind(StrEnum):
    """What a caution is about."""

    NOT_CONVERGED = "not converged"
    EDGE = "contact at the edge of the map"
    BEYOND_CEILING = "pressure beyond the ceiling"
    MISSING = "missing points"
    BEYOND_YIELD = "stress beyond the yield strength"
    DEEPEST = "largest stress at the greatest depth"
    SHALLOW = "largest stress within two pixels of the surface"
    PLASTIC_EDGE = "plastic strain at the edge of the volume"
    PLASTIC_BOTTOM = "plastic strain in the lowest layer"
    UNSEALED = "file without checksums"


@dataclass(frozen=True)
class Caution:
    """Something that a reader of the numbers has to know.

    Parameters
    ----------
    kind : str
        What it is about, one of a `Kind`.
    parts : tuple of str and Mention
        The sentence, without its capital letter and full stop.
    """

    kind: str
    parts: tuple[Part, ...]

    @property
    def text(self) -> str:
        """The sentence in the words of Python."""
        return Sentence(*self.parts)


def at_edge(*more: Part) -> Caution:
    """Return what is said of a contact that reaches the edge of the map, and more where it fits."""
    return Caution(
        Kind.EDGE,
        (
            "contact reaches the edge of the map: either the map is too small for this load, or "
            "the body is meant to end there",
            *more,
        ),
    )


def unsealed() -> Caution:
    """Return what is said of a result that was read from a file without checksums."""
    return Caution(
        Kind.UNSEALED,
        (
            "read from a file without checksums, in which damage goes unseen; ",
            Mention("verify", True),
            " computes load and certificate again",
        ),
    )
