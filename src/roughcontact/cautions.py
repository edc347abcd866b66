"""What a reader of the numbers has to know: a kind for programs, a sentence for people."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from roughcontact.errors import ArgumentRef, Part, Sentence, message_parts, render_message
from roughcontact.units import percent


class Kind(StrEnum):
    """What a caution is about."""

    NOT_CONVERGED = "not converged"
    EDGE = "contact at the edge of the map"
    BEYOND_CEILING = "pressure beyond the ceiling"
    RESOLUTION = "contact not resolved"
    STUDY = "depends on the grid"
    SLOPES = "slopes not small"
    STRAINS = "strains not small"
    UNITS = "numbers that suggest another unit"
    HERTZ = "limits of Hertz's theory"
    CEILING = "ceiling off the recommended one"
    HARDNESS = "yield strength at odds with the hardness"
    IMPRINT = "permanent indentation of a ceiling"
    SPIKES = "spikes of the measurement"
    FILLED = "filled points"
    MISSING = "missing points"
    MEASUREMENT = "lateral resolution of the measurement"
    BEYOND_YIELD = "stress beyond the yield strength"
    DEEPEST = "largest stress at the greatest depth"
    SHALLOW = "largest stress near the surface"
    PLASTIC_EDGE = "plastic strain at the edge of the volume"
    PLASTIC_BOTTOM = "plastic strain in the lowest layer"
    UNSEALED = "file without checksums"
    PLASTIC_STRAINS = "plastic strains not small"
    SCATTER = "pressure of single pixels scatters"
    HARDENING = "plastic strain beyond the table"
    LOAD_STEPS = "error of the load steps"
    RESIDUAL = "residual stress beyond the yield strength"
    UNLIKE = "maps that differ in more than their surfaces"
    FEW = "few maps"
    PARTS = "parts of one map"
    MULTIPLE = "several intervals at once"
    SCALING = "scatter that does not fall with the area"
    SPOTS = "spots that are no discs"
    FORM = "bodies curved as a whole"
    WAYS = "ways through the gap"
    SLIP = "gas that slips"
    RANGE = "pressures that the maps resolve"
    SMOOTH = "smooth counter-face"
    RIM = "rim that is left out"
    STEPS = "pressures that are far apart"
    DOMAIN = "outside the domain of a formula"
    RANKS = "map on several processes"
    WAY = "steps of a pass"
    AXIS = "roller that slides along its axis"
    ATOMS = "contact of few atoms"
    ADHESION = "adhesion"
    MATERIAL = "material beyond the model"


_FOREMOST = (
    Kind.NOT_CONVERGED, Kind.UNITS, Kind.FILLED, Kind.STRAINS, Kind.ATOMS, Kind.ADHESION,
    Kind.MATERIAL,
)  # fmt: skip


class Severity(StrEnum):
    """What a caution does to the numbers."""

    WARNING = "warning"
    """They may be far off, or mean something else than they seem to."""
    CAUTION = "caution"
    """They are estimates."""
    NOTE = "note"
    """They are right for what was given, which holds less than it may seem."""


@dataclass(frozen=True)
class Caution:
    """Something that a reader of the numbers has to know."""

    kind: str  # What it is about, one of a `Kind`
    parts: tuple[Part, ...]  # The sentence, without its capital letter and full stop
    severity: Severity = Severity.WARNING  # What it does to the numbers
    numbers: Mapping[str, float] = field(default_factory=dict, hash=False)

    @property
    def text(self) -> str:
        """The sentence in the words of Python."""
        return Sentence(*self.parts)

    def summary(self) -> dict[str, Any]:
        """Return it ready for JSON: kind, severity, sentence and numbers."""
        return {
            "kind": str(self.kind),
            "severity": str(self.severity),
            "text": render_message(self.parts),
            "numbers": dict(self.numbers),
        }


def as_note(kind: Kind, *parts: Part, **numbers: float) -> Caution:
    """Return a caution that leaves the numbers as they are."""
    return Caution(kind, parts, Severity.NOTE, numbers)


def as_caution(kind: Kind, *parts: Part, **numbers: float) -> Caution:
    """Return a caution that makes the numbers estimates."""
    return Caution(kind, parts, Severity.CAUTION, numbers)


def as_warning(kind: Kind, *parts: Part, **numbers: float) -> Caution:
    """Return a caution that puts the numbers in doubt."""
    return Caution(kind, parts, Severity.WARNING, numbers)


def of_measurement(notes: Iterable[str]) -> tuple[Caution, ...]:
    """Return what limits the lateral resolution of maps; see `Surface.resolution_notes`."""
    return tuple(as_note(Kind.MEASUREMENT, *message_parts(note)) for note in notes)


def ordered(result: Iterable[Caution]) -> tuple[Caution, ...]:
    """Return cautions, each once, the severest first and of these what makes the rest void."""
    severities = list(Severity)
    once = {(c.kind, c.text): c for c in result}

    def rank(caution: Caution) -> tuple[int, int]:
        foremost = caution.kind in _FOREMOST
        place = _FOREMOST.index(Kind(caution.kind)) if foremost else len(_FOREMOST)
        return severities.index(caution.severity), place

    return tuple(sorted(once.values(), key=rank))


def to_text(cautions: Iterable[Caution]) -> str:
    """Return cautions as JSON text, which `from_text` reads."""
    return json.dumps([caution.summary() for caution in cautions], ensure_ascii=False)


def from_text(entry: str) -> tuple[Caution, ...]:
    """Return the cautions in JSON text that `to_text` wrote; arguments are words in it."""
    return tuple(
        Caution(
            str(text["kind"]),
            (str(text["text"]),),
            Severity(text["severity"]),
            {str(key): float(value) for key, value in text["numbers"].items()},
        )
        for text in json.loads(entry)
    )


def no_checksums() -> Caution:
    """Return what is said of a result that was read from a file without checksums."""
    return as_note(
        Kind.UNSEALED,
        "read from a file without checksums, in which damage goes unseen; ",
        ArgumentRef("verify", True),
        " computes load and certificate again",
    )


def edge(whole: str, share: float, *more: str) -> Caution:
    """Return the caution about a contact that reaches the edge at which its map ends."""
    return as_warning(
        Kind.EDGE,
        f"contact reaches the edge of the {whole}, where the body is taken to end: "
        "right for a part that ends there; for a sample of a larger face the rim carries too much "
        f"(here {percent(share)} of the load on the outermost pixels), and approach and stiffness "
        "may be far off: solve with ",
        ArgumentRef("boundary", "periodic"),
        f"; for a body that is curved as a whole measure a larger {whole}",
        *more,
        edge_load=share,
    )
