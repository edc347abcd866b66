"""What a reader of the numbers has to know: a kind for programs, a sentence for people."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from roughcontact.errors import Part, worded


class Kind(StrEnum):
    """What a caution is about."""

    NOT_CONVERGED = "not converged"
    EDGE = "contact at the edge of the map"
    BEYOND_CEILING = "pressure beyond the ceiling"
    MISSING = "missing points"
    BEYOND_YIELD = "stress beyond the yield strength"
    DEEPEST = "largest stress at the greatest depth"
    SHALLOW = "largest stress within two pixels of the surface"


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
        return worded(self.parts)
