"""Images of JPK's scanning probe microscopes in HDF5 (``.h5-jpk``).

A group ``Measurement_000`` has the grid as attributes ``position-pattern.grid.…``, and a group for
each channel; its array has one column for each frame, with the points of the grid in rows along x
from the smallest y on. ``net-encoder.scaling`` converts the integers into its unit.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from roughcontact._tools import memory, netcdf
from roughcontact.formats import instruments
from roughcontact.formats.source import (
    Channel,
    ReadOptions,
    damage_as_error,
    is_length,
    make_surface,
    refuse_unit,
    resolve_pixel,
    to_meters,
    unit_in_meters,
)
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface

_GRID = "position-pattern.grid."
_SCALING = "net-encoder.scaling."
_BYTES_PER_POINT = 40


@dataclass(frozen=True)
class _Frame:
    """One frame of a channel."""

    channel: Channel
    values: Any  # Array of all frames in the file
    column: int
    sides: tuple[float, float]  # Sides (y, x) in their unit
    unit: str  # Unit of the sides
    scale: tuple[float, float]  # Factor and offset of the integers


@contextmanager
def _open_frames(path: Path) -> Iterator[list[_Frame]]:
    """Yield the frames of all channels."""
    with damage_as_error(path, "images of JPK in HDF5", "copy or export it again"):
        netcdf.check_hdf5(path)
        import h5py

        with h5py.File(path, "r") as file:
            yield [frame for name in file for frame in _list_frames(file[name])]


def _list_frames(group: Any) -> Iterator[_Frame]:
    about = group.attrs
    if _GRID + "ilength" not in about:
        return
    shape = int(about[_GRID + "jlength"]), int(about[_GRID + "ilength"])
    sides = float(about[_GRID + "vlength"]), float(about[_GRID + "ulength"])
    lateral = _text(about[_GRID + "unit.unit"])
    for part in group.values():
        if "channel.name" not in part.attrs:
            continue
        unit = _text(part.attrs[_SCALING + "unit.unit"])
        scale = tuple(float(part.attrs[_SCALING + key]) for key in ("multiplier", "offset"))
        back = ", retrace" if _text(part.attrs.get("retrace", "")) == "true" else ""
        name = _text(part.attrs.get("channel.fancy-name", part.attrs["channel.name"])) + back
        is_height = is_length(Path(), unit) and not instruments.is_other_quantity(name)
        for values in part.values():
            if values.shape[:1] != (shape[0] * shape[1],) or values.ndim != 2:
                continue
            for column in range(values.shape[1]):
                number = f", frame {column + 1}" if values.shape[1] > 1 else ""
                channel = Channel(name + number, unit, is_height, shape)
                yield _Frame(channel, values, column, sides, lateral, (scale[0], scale[1]))


def _text(value: Any) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def read_jpk_hdf5(path: Path, name: str, requested: ReadOptions) -> Surface:
    """Return a frame of a channel; row 0 is on top, as in JPK's other files."""
    with _open_frames(path) as frames:
        listed = [frame.channel for frame in frames]
        chosen = instruments.choose_channel(path, listed, requested.channel, 0)
        frame = frames[chosen]
        shape = frame.channel.shape
        refuse_unit(path, requested)
        requested.check_shape(shape)
        memory.require_points(path.name, shape, _BYTES_PER_POINT)
        factor, offset = frame.scale
        counts = np.asarray(frame.values[:, frame.column], dtype=np.float64)
    metre = unit_in_meters(path, frame.channel.unit)
    heights = to_meters((factor * counts + offset).reshape(shape)[::-1], metre)
    lateral = unit_in_meters(path, frame.unit)
    stated = frame.sides[0] * lateral / shape[0], frame.sides[1] * lateral / shape[1]
    pixel = resolve_pixel(path, stated, shape, requested)
    about = Provenance(path.name, "JPK HDF5", frame.channel.name)
    return make_surface(path, heights, pixel, about, metre, stated)


def channels(path: Path, name: str) -> tuple[Channel, ...]:
    """Return the frames of all channels."""
    with _open_frames(path) as frames:
        return tuple(frame.channel for frame in frames)
