"""Images of heights: Gwyddion Simple Field, TIFF, and JPK's images in HDF5.

Gwyddion Simple Field is a text header, padded by zeros to four bytes, and single precision
(Gwyddion user guide). TIFF is read by tifffile; each page of one value per point is a channel, and
sides are read from the standards that name their unit, ImageJ's description and OME-XML: a
resolution in dots per inch is that of a printer. JPK's files (``.h5-jpk``) have a group
``Measurement_000`` with the grid as attributes ``position-pattern.grid.…``, and a group for each
channel; its array has one column for each frame, with the points of the grid in rows along x from
the smallest y on; ``net-encoder.scaling`` converts the integers into its unit.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from roughcontact._tools import memory, netcdf
from roughcontact._tools.arrays import Shape
from roughcontact.errors import ArgumentRef, FormatError, InputError
from roughcontact.formats import instruments, matrices
from roughcontact.formats.source import (
    Channel,
    ReadOptions,
    damage_as_error,
    import_optional,
    is_length,
    refuse_unit,
    unit_in_meters,
)
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface

_BYTES_PER_POINT = 40
_MAX_HEAD_BYTES = 2**16
# Tag of Park Systems, whose files the instrument reader reads; tag of GDAL with the value of
# missing points.
_PARK, _NO_DATA = 50432, 42113
_GRID, _SCALING = "position-pattern.grid.", "net-encoder.scaling."


@dataclass(frozen=True)
class _Image:
    """Channel of a file."""

    channel: Channel
    load: Callable[[], Any]  # Returns the values
    pixel: tuple[float, float] | None = None  # Pixel edges (dy, dx) [m], if the file has them


def read_image(path: Path, name: str, requested: ReadOptions) -> Surface:
    """Return the map in a file; integers of TIFF need the height of one count."""
    if name == "tiff" and _is_park(path):
        return instruments.read_instrument(path, "ps", requested)
    with _open_images(path, name) as images:
        listed = [image.channel for image in images]
        if name == "tiff" and not any(entry.is_height for entry in listed):
            if not re.match(r"\s*\.?\d", requested.unit or ""):
                raise InputError(
                    f"{path.name} holds integers: brightness, unless one count is a height; give "
                    "that height with ",
                    ArgumentRef("unit", "0.1 nm"),
                    ", or export the heights as 32-bit TIFF, .x3p or text",
                )
            listed = [Channel(entry.name, "", True, entry.shape) for entry in listed]
        image = images[instruments.choose_channel(path, listed, requested.channel, 0)]
        channel = image.channel
        if channel.unit:
            refuse_unit(path, requested)
        memory.require_points(path.name, channel.shape, _BYTES_PER_POINT)
        requested.check_shape(channel.shape)
        values = image.load()
    about = Provenance(path.name, name, channel.name if len(images) > 1 else "")
    return matrices.scale_array(path, values, about, channel.unit, requested, image.pixel)


def channels(path: Path, name: str) -> tuple[Channel, ...]:
    """Return the channels of a file; integers of TIFF are no heights."""
    if name == "tiff" and _is_park(path):
        return instruments.channels(path, "ps")
    with _open_images(path, name) as images:
        return tuple(image.channel for image in images)


@contextmanager
def _open_images(path: Path, name: str) -> Iterator[list[_Image]]:
    """Yield the images of a file while it is open."""
    images = {"gsf": _field, "tiff": _pages, "jpk-hdf5": _frames}[name]
    with damage_as_error(path, f"format {name!r}", "export it again, uncompressed"):
        yield from images(path)


def _pixel(
    path: Path, edges: Iterable[str | float], units: Iterable[str]
) -> tuple[float, float] | None:
    """Return pixel edges [m]; None if one is not positive or its unit is no length."""
    known = [
        float(edge) * unit_in_meters(path, unit)
        for edge, unit in zip(edges, units, strict=True)
        if float(edge) > 0 and is_length(path, unit)
    ]
    return (known[0], known[1]) if len(known) == 2 else None


def _field(path: Path) -> Iterator[list[_Image]]:
    with path.open("rb") as stream:
        text, end, _ = stream.read(_MAX_HEAD_BYTES).partition(b"\0")
    if not end:
        raise ValueError("no header that ends with a zero byte")
    parts = (line.partition("=") for line in text.decode("utf-8", "replace").splitlines()[1:])
    head = {name.strip(): value.strip() for name, _, value in parts}
    ny, nx = int(head["YRes"]), int(head["XRes"])
    offset = len(text) + 4 - len(text) % 4
    if min(ny, nx) < 1 or path.stat().st_size != offset + 4 * ny * nx:
        raise ValueError(f"{ny} × {nx} points from byte {offset} on do not end with the file")
    unit, lateral = head.get("ZUnits", ""), head.get("XYUnits", "")
    dy, dx = float(head.get("YReal", "nan")) / ny, float(head.get("XReal", "nan")) / nx
    pixel = _pixel(path, (dy, dx), (lateral, lateral))
    channel = Channel(head.get("Title", ""), unit, not unit or is_length(path, unit), (ny, nx))
    yield [_Image(channel, partial(np.memmap, path, "<f4", "r", offset, (ny, nx)), pixel)]


@contextmanager
def _open_tiff(path: Path) -> Iterator[Any]:
    tifffile = import_optional(path, "tifffile")
    with damage_as_error(path, "TIFF", "export it again"), tifffile.TiffFile(path) as file:
        yield file


def _is_park(path: Path) -> bool:
    with _open_tiff(path) as file:
        return _PARK in file.pages[0].tags


def _pages(path: Path) -> Iterator[list[_Image]]:
    with _open_tiff(path) as file:
        pages = [page for page in file.pages if len(page.shape) == 2 and page.dtype.kind in "fiu"]
        if not pages:
            raise FormatError(
                f"{path.name} holds a color image, no heights; export the heights as 32-bit TIFF, "
                ".x3p or text"
            )
        yield [
            _Image(
                Channel(f"page {page.index + 1}", "", page.dtype.kind == "f", page.shape),
                partial(_load_page, page),
                _pixel_of_page(path, file, page),
            )
            for page in pages
        ]


def _load_page(page: Any) -> Any:
    values, missing = page.asarray(), page.tags.get(_NO_DATA)
    if missing is None:
        return values
    return np.where(values == float(str(missing.value).strip("\0 ")), np.nan, values)


def _pixel_of_page(path: Path, file: Any, page: Any) -> tuple[float, float] | None:
    """Return the pixel [m] where a description names its unit."""
    if file.is_ome:
        said = dict(re.findall(r'\b(PhysicalSize[XY](?:Unit)?)="([^"]+)"', file.ome_metadata))
        sizes = (said.get(f"PhysicalSize{axis}", "nan") for axis in "YX")
        units = (said.get(f"PhysicalSize{axis}Unit", "um") for axis in "YX")
        return _pixel(path, sizes, units)
    word = str((file.imagej_metadata or {}).get("unit", "")).replace("\\u00B5", "u").strip("\0 ")
    counts = [page.tags.get(f"{axis}Resolution") for axis in "YX"]
    if None in counts:
        return None
    (y, one), (x, other) = (tag.value for tag in counts)
    unit = {"micron": "um", "pixel": ""}.get(word, word)
    return _pixel(path, (one / y, other / x), (unit, unit)) if x and y else None


def _frames(path: Path) -> Iterator[list[_Image]]:
    netcdf.check_hdf5(path)
    import h5py

    with h5py.File(path, "r") as file:
        yield [frame for name in file for frame in _list_frames(path, file[name])]


def _list_frames(path: Path, group: Any) -> Iterator[_Image]:
    about = group.attrs
    if _GRID + "ilength" not in about:
        return
    shape = int(about[_GRID + "jlength"]), int(about[_GRID + "ilength"])
    lateral = _text(about[_GRID + "unit.unit"])
    dy, dx = about[_GRID + "vlength"] / shape[0], about[_GRID + "ulength"] / shape[1]
    pixel = _pixel(path, (dy, dx), (lateral, lateral))
    for part in group.values():
        if "channel.name" not in part.attrs:
            continue
        unit = _text(part.attrs[_SCALING + "unit.unit"])
        factor, offset = (float(part.attrs[_SCALING + key]) for key in ("multiplier", "offset"))
        back = ", retrace" if _text(part.attrs.get("retrace", "")) == "true" else ""
        name = _text(part.attrs.get("channel.fancy-name", part.attrs["channel.name"])) + back
        # The name first: units such as degrees load the library of units.
        is_height = not instruments.is_other_quantity(name) and is_length(path, unit)
        for values in part.values():
            if values.shape[:1] != (shape[0] * shape[1],) or values.ndim != 2:
                continue
            for column in range(values.shape[1]):
                number = f", frame {column + 1}" if values.shape[1] > 1 else ""
                load = partial(_load_frame, values, column, shape, factor, offset)
                yield _Image(Channel(name + number, unit, is_height, shape), load, pixel)


def _load_frame(values: Any, column: int, shape: Shape, factor: float, offset: float) -> Any:
    # Row 0 is on top, as in JPK's other files.
    return (factor * np.asarray(values[:, column], dtype=np.float64) + offset).reshape(shape)[::-1]


def _text(value: Any) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
