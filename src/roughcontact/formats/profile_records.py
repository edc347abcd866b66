"""Profiles in records: ISO 5436-2 (``.smd``), Taylor Hobson (``.prf``), SigmaSurf (``.sig``).

SMD and PRF describe the axes by lines ``CX`` and ``CZ``: kind of axis, number of points, unit,
factor, type of number, and in SMD the spacing; PRF gives it in a line ``SPACING``. Records end with
the control character ETX or ``EOR``. SigmaSurf, of OmniSurf's maker, names spacing and heights
``…_UM``.
"""

from __future__ import annotations

import itertools
import re
from pathlib import Path

import numpy as np

from roughcontact._tools import memory
from roughcontact._tools.arrays import Array
from roughcontact.errors import FormatError
from roughcontact.formats.source import (
    Channel,
    ReadOptions,
    damage_as_error,
    make_surface,
    refuse_unit,
    resolve_pixel,
    to_meters,
    unit_in_meters,
)
from roughcontact.surface.grid import PROFILE_WIDTH
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface

_END = re.compile(r"^\s*(?:EOR|\x03)\s*$", re.MULTILINE)
_MISSING = re.compile(r"^\s*(?:BAD|NaN|-+)\s*$", re.IGNORECASE | re.MULTILINE)
_BYTES_PER_POINT = 200


# Heights in their unit, NaN where missing, the unit [m], and the distance of the points [m].
_Profile = tuple[Array, float, float]


def _load(path: Path) -> _Profile:
    memory.require_size(path.name, path.stat().st_size)
    with damage_as_error(path, "a profile in records", "copy or export it again"):
        text = path.read_text(encoding="latin-1").replace("\0", " ")
        profile = _sigma_surf(text) if text.startswith("SigmaSurf") else _records(path, text)
    heights, _, spacing = profile
    if heights.size < 2 or not spacing > 0:
        raise FormatError(
            f"{path.name} lists {heights.size} points {spacing:g} m apart, no profile; export it "
            "again"
        )
    return profile


def _records(path: Path, text: str) -> _Profile:
    records = _END.split(text)
    lines = [line.split() for line in itertools.chain(*(part.splitlines() for part in records[:2]))]
    (_, _, count, unit, factor, *_) = axis = next(line for line in lines if line[:1] == ["CZ"])
    along = next(line for line in lines if line[:1] == ["CX"])
    spacing = next((line[2] for line in lines if line[:2] == ["SPACING", "CX"]), along[-1])
    if axis[1] == "R":
        raise FormatError(f"{path.name} holds heights relative to each other; export it again")
    heights = _numbers(records[2])
    if heights.size != round(float(count)):
        raise ValueError(f"{heights.size} heights, {count} announced")
    return (
        heights,
        float(factor) * unit_in_meters(path, unit.lower()),
        float(spacing) * float(along[4]) * unit_in_meters(path, along[3].lower()),
    )


def _sigma_surf(text: str) -> _Profile:
    head, _, body = text.partition("PROFILE_UM:")
    found = re.search(r"SPACING_UM:\s*(\S+)", head)
    if found is None:
        raise ValueError("no SPACING_UM")
    return _numbers(body), 1e-6, float(found[1]) * 1e-6


def _numbers(text: str) -> Array:
    return np.array(_MISSING.sub("nan", text).split(), dtype=np.float64)


def read_profile(path: Path, name: str, requested: ReadOptions) -> Surface:
    """Return the profile in a file."""
    heights, unit, spacing = _load(path)
    refuse_unit(path, requested)
    requested.check_shape((1, heights.size))
    stated = PROFILE_WIDTH, spacing
    pixel = resolve_pixel(path, stated, (1, heights.size), requested)
    about = Provenance(path.name, f"profile ({name})")
    return make_surface(path, to_meters(heights[None], unit), pixel, about, unit, stated)


def channels(path: Path, name: str) -> tuple[Channel, ...]:
    """Return the profile as the only channel."""
    return (Channel("", "", True, (1, _load(path)[0].size)),)
