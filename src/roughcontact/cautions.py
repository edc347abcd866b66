"""Messages on results: a tag for programs, one or two sentences for users."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from pathlib import Path
from typing import Any

from roughcontact.errors import InputError, Part, Sentence, read_message, split_message


class CautionTag(StrEnum):
    """Tag of a message: its stable name, in the order of importance."""

    NOT_CONVERGED = "not-converged"
    UNITS = "units"
    MOSTLY_FILLED = "mostly-filled"
    STRAIN = "strain"
    FEW_ATOMS = "few-atoms"
    ADHESION = "adhesion"
    MATERIAL = "material"
    ABOVE_CEILING = "above-ceiling"
    CYLINDER_SLIDES = "cylinder-slides"
    SPIKES = "spikes"
    PIXEL = "pixel"
    ROLLING_PIXEL = "rolling-pixel"
    STEP_LENGTH = "step-length"
    EDGE = "edge"
    PERIODIC_EDGE = "periodic-edge"
    HERTZ = "hertz"
    PLASTIC_EDGE = "plastic-edge"
    YIELD_EXCESS = "yield-excess"
    STRESS_DEPTH = "stress-depth"
    LAW_RANGE = "law-range"
    NEAR_THRESHOLD = "near-threshold"
    FLUID_PRESSURE = "fluid-pressure"
    HOT_SPOTS = "hot-spots"
    RAREFIED = "rarefied"
    LEAK_PIXEL = "leak-pixel"
    SHEAR_YIELD = "shear-yield"
    JUNCTION_GROWTH = "junction-growth"
    UNLIKE_BODIES = "unlike-bodies"
    CEILING = "ceiling"
    HARDNESS = "hardness"
    INDENTATION = "indentation"
    THIN_COATING = "thin-coating"
    SLOPES = "slopes"
    HARDENING_RANGE = "hardening-range"
    YIELDED = "yielded"
    STRESS_PIXEL = "stress-pixel"
    RESIDUAL_YIELD = "residual-yield"
    FEW_MAPS = "few-maps"
    UNLIKE_PIXEL = "unlike-pixel"
    UNLIKE_SIZE = "unlike-size"
    LAW_SIZE = "law-size"
    SAMPLING = "sampling"
    MISSING = "missing"
    RESOLUTION = "resolution"
    CEILING_EXTRAPOLATED = "ceiling-extrapolated"
    PARTS = "parts"
    PIXEL_SCATTER = "pixel-scatter"
    ONE_ROUGH_FACE = "one-rough-face"
    LAW_MARGIN = "law-margin"
    CURVED = "curved"
    OXIDE = "oxide"
    RADIATION = "radiation"
    OPEN_GAP = "open-gap"
    ESTIMATE_DOMAIN = "estimate-domain"
    GENERATE_MISSED = "generate-missed"
    NARROW_SPECTRUM = "narrow-spectrum"
    NO_CHECKSUMS = "no-checksums"


_PLACES: dict[str, int] = {kind: place for place, kind in enumerate(CautionTag)}

# Tags for which a smaller first number is worse.
_SMALLER_IS_WORSE = (
    CautionTag.FEW_ATOMS,
    CautionTag.PIXEL,
    CautionTag.ROLLING_PIXEL,
    CautionTag.FEW_MAPS,
    CautionTag.NARROW_SPECTRUM,
)


class Severity(StrEnum):
    """Effect of a caution on the results."""

    WARNING = "warning"
    """Results may be far off, or not mean what they seem to mean."""
    CAUTION = "caution"
    """Results are estimates."""
    NOTE = "note"
    """Results hold for the given input, which may be incomplete."""


_EXPLANATIONS = Path(__file__).with_name("explanations.toml")

# End of the first sentence.
_SENTENCE_END = re.compile(r"[.?](?=\s|$)")


@dataclass(frozen=True)
class Caution:
    """Message about a result: cause with its value, effect, action."""

    kind: str  # Tag, one of `CautionTag`; files of other versions may have other tags
    parts: tuple[Part, ...]  # One or two sentences, at most 20 words together
    severity: Severity = Severity.WARNING  # Effect on the results
    numbers: Mapping[str, float] = field(default_factory=dict, hash=False)  # Size first
    where: str = ""  # Number of contacts or maps with this message, and the worst of them
    place: str = ""  # The worst contact or map

    @property
    def text(self) -> str:
        """Message with names of Python arguments."""
        for index, part in enumerate(self.parts if self.where else ()):
            if isinstance(part, str) and (end := _SENTENCE_END.search(part)):
                placed = f"{part[: end.start()]} ({self.where}){part[end.start() :]}"
                return Sentence(*self.parts[:index], placed, *self.parts[index + 1 :])
        return Sentence(*self.parts)

    @property
    def rank(self) -> tuple[int, int, float]:
        """Sort key: severity, tag, size."""
        size = abs(next(iter(self.numbers.values()), 0.0))
        return (
            list(Severity).index(self.severity),
            _PLACES.get(self.kind, len(_PLACES)),
            0.0 if math.isnan(size) else size if self.kind in _SMALLER_IS_WORSE else -size,
        )

    def summary(self) -> dict[str, Any]:
        """Return the caution ready for JSON: tag, severity, text and values."""
        return {
            "kind": str(self.kind),
            "severity": str(self.severity),
            "text": str(self.text),
            "numbers": dict(self.numbers),
        }


def as_note(kind: CautionTag, *parts: Part, **numbers: float) -> Caution:
    """Return a note: the results hold."""
    return Caution(kind, split_message(*parts), Severity.NOTE, numbers)


def as_caution(kind: CautionTag, *parts: Part, **numbers: float) -> Caution:
    """Return a caution: the results are estimates."""
    return Caution(kind, split_message(*parts), Severity.CAUTION, numbers)


def as_warning(kind: CautionTag, *parts: Part, **numbers: float) -> Caution:
    """Return a warning: the results may be far off."""
    return Caution(kind, split_message(*parts), Severity.WARNING, numbers)


def sort_cautions(result: Iterable[Caution]) -> tuple[Caution, ...]:
    """Return the worst message of each tag, the most severe and most important tag first."""
    once: dict[str, Caution] = {}
    for caution in sorted(result, key=lambda caution: caution.rank):
        once.setdefault(caution.kind, caution)
    return tuple(once.values())


def merge_cautions(
    results: Sequence[tuple[str, Iterable[Caution]]], noun: str
) -> tuple[Caution, ...]:
    """Return the worst message of each tag over several places, with place and count."""
    once: dict[str, list[tuple[str, Caution]]] = {}
    for place, cautions in results:
        for caution in sort_cautions(cautions):
            once.setdefault(caution.kind, []).append((place, caution))
    return sort_cautions(_worst_caution(text, len(results), noun) for text in once.values())


def _worst_caution(text: Sequence[tuple[str, Caution]], count: int, noun: str) -> Caution:
    place, worst = min(text, key=lambda item: item[1].rank)
    if len(text) == count and len({caution.text for _, caution in text}) == 1:
        return worst
    place = f"{place} at {worst.place}" if worst.place else place
    which = f", {'worst ' if len(text) > 1 else ''}{place}" if worst.numbers else ""
    return replace(worst, where=f"{len(text)} of {count} {noun}{which}", place=place)


def to_text(cautions: Iterable[Caution]) -> str:
    """Return cautions as JSON text, which `from_text` reads."""
    return json.dumps([caution.summary() for caution in cautions], ensure_ascii=False)


def from_text(entry: str) -> tuple[Caution, ...]:
    """Return the cautions in JSON text that `to_text` wrote."""
    return tuple(from_summary(text) for text in json.loads(entry))


def from_summary(text: Mapping[str, Any]) -> Caution:
    """Return a caution from its `Caution.summary`."""
    numbers = {str(key): float(value) for key, value in text["numbers"].items()}
    parts = read_message(str(text["text"]))
    return Caution(str(text["kind"]), parts, Severity(text["severity"]), numbers)


def explain_tag(tag: str) -> str:
    """Return the paragraph on a tag: cause, effect and remedies."""
    # Imported late: only explanations need it.
    import tomllib

    paragraphs = tomllib.loads(_EXPLANATIONS.read_text(encoding="utf-8"))
    if tag not in paragraphs:
        raise InputError(f"{tag!r} is no tag; the tags are {', '.join(paragraphs)}")
    return " ".join(str(paragraphs[tag]).split())


def no_checksums() -> Caution:
    """Return the note on a result that was read from a file without checksums."""
    return as_note(
        CautionTag.NO_CHECKSUMS,
        "File has no checksums: damage would go unnoticed. Run roughcontact verify.",
    )


MIN_MAPS = 3
"""Number of maps below which an interval is about ten times the standard error."""


def few_maps(count: int, what: str = "map", of: str = "") -> Caution:
    """Return the caution about results from only one or two maps."""
    known = "scatter unknown" if count == 1 else "the 95 % interval is ±13 standard errors"
    return as_caution(
        CautionTag.FEW_MAPS,
        f"{'One' if count == 1 else 'Two'} {what}{'' if count == 1 else 's'}{of}: {known}. Give "
        "three or more.",
        maps=count,
    )
