"""Gwyddion Simple Field: a text header, padded by zeros to four bytes, and single precision.

Layout: Gwyddion user guide, Gwyddion Simple Field (GSF).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from roughcontact._tools import memory
from roughcontact.errors import FormatError
from roughcontact.formats import matrices
from roughcontact.formats.source import (
    Channel,
    ReadOptions,
    damage_as_error,
    is_length,
    unit_in_meters,
)
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface

_MAX_HEAD_BYTES = 2**16
_BYTES_PER_POINT = 20


def _parse_head(path: Path) -> tuple[dict[str, str], tuple[int, int], int]:
    """Return the header, the points (ny, nx) and the offset of the values."""
    with path.open("rb") as stream:
        start = stream.read(_MAX_HEAD_BYTES)
    text, end, _ = start.partition(b"\0")
    if not end:
        raise ValueError("no header that ends with a zero byte")
    parts = (line.partition("=") for line in text.decode("utf-8", "replace").splitlines()[1:])
    head = {name.strip(): value.strip() for name, _, value in parts}
    shape = int(head["YRes"]), int(head["XRes"])
    offset = len(text) + 4 - len(text) % 4
    if min(shape) < 1 or path.stat().st_size != offset + 4 * shape[0] * shape[1]:
        raise ValueError(
            f"{shape[0]} × {shape[1]} points from byte {offset} on do not end with the file"
        )
    return head, shape, offset


def read_gsf(path: Path, name: str, requested: ReadOptions) -> Surface:
    """Return the map in a file; its unit may be missing."""
    with damage_as_error(path, "a Gwyddion Simple Field", "copy or export it again"):
        head, shape, offset = _parse_head(path)
        memory.require_points(path.name, shape, _BYTES_PER_POINT)
        requested.check_shape(shape)
        values = np.memmap(path, "<f4", "r", offset, shape)
        sides = [float(head.get(key, "nan")) for key in ("YReal", "XReal")]
    unit, lateral = head.get("ZUnits", ""), head.get("XYUnits", "")
    if unit and not is_length(path, unit):
        raise FormatError(
            f"{path.name} holds {head.get('Title', 'a map')!r} in {unit!r}, no heights; export "
            "the heights"
        )
    stated = None
    if lateral and min(sides) > 0:
        metre = unit_in_meters(path, lateral)
        stated = sides[0] * metre / shape[0], sides[1] * metre / shape[1]
    about = Provenance(path.name, "Gwyddion Simple Field", head.get("Title", ""))
    return matrices.scale_array(path, values, about, unit, requested, stated)


def channels(path: Path, name: str) -> tuple[Channel, ...]:
    """Return the only channel of a file."""
    with damage_as_error(path, "a Gwyddion Simple Field", "copy or export it again"):
        head, shape, _ = _parse_head(path)
    unit = head.get("ZUnits", "")
    return (Channel(head.get("Title", ""), unit, not unit or is_length(path, unit), shape),)
