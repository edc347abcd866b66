"""TIFF images of heights, read by tifffile: each page of one value per point is a channel.

The sides are read from the standards that name their unit: ImageJ's description and OME-XML. A
resolution in dots per inch is that of a printer.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from roughcontact._tools import memory
from roughcontact.errors import ArgumentRef, FormatError, InputError
from roughcontact.formats import instruments, matrices
from roughcontact.formats.source import (
    Channel,
    ReadOptions,
    damage_as_error,
    is_length,
    unit_in_meters,
)
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface

# Tag of Park Systems, whose files the instrument reader reads; tag of GDAL with the value of
# missing points.
_PARK, _NO_DATA = 50432, 42113

_BYTES_PER_POINT = 40
_WORDS = {"micron": "um", "pixel": "", "cm": "cm"}


@contextmanager
def _open_pages(path: Path) -> Iterator[tuple[Any, list[Any]]]:
    """Yield the file and its pages of one value per point."""
    try:
        import tifffile
    except ImportError as error:
        raise FormatError(
            f"{path.name} needs tifffile, which cannot be imported ({error}); run pip install "
            "'roughcontact[io]'"
        ) from None
    with (
        damage_as_error(path, "TIFF", "export it again, uncompressed"),
        tifffile.TiffFile(path) as file,
    ):
        pages: list[Any] = list(file.pages)
        flat = [page for page in pages if len(page.shape) == 2 and page.dtype.kind in "fiu"]
        if pages[0].tags.get(_PARK) is None and not flat:
            raise FormatError(
                f"{path.name} holds a color image, no heights; export the heights as 32-bit TIFF, "
                ".x3p or text"
            )
        yield file, flat


def read_tiff(path: Path, name: str, requested: ReadOptions) -> Surface:
    """Return the map in a page; integers need the height of one count."""
    with _open_pages(path) as (file, pages):
        is_park = file.pages[0].tags.get(_PARK) is not None
        if not is_park:
            names = [_page_name(page) for page in pages]
            wanted = names[0] if requested.channel is None else requested.channel
            channel = matrices.choose_array(path, names, wanted)
            page = pages[names.index(channel)]
            if page.dtype.kind != "f" and not re.match(r"\s*[\d.]", requested.unit or ""):
                raise InputError(
                    f"{path.name} holds integers of {page.dtype.itemsize * 8} bits: brightness, "
                    "unless one count is a height; give that height with ",
                    ArgumentRef("unit", "0.1 nm"),
                    ", or export the heights as 32-bit TIFF, .x3p or text",
                )
            memory.require_points(path.name, page.shape, _BYTES_PER_POINT)
            requested.check_shape(page.shape)
            values = page.asarray()
            stated = _pixel(path, file, page)
            missing = page.tags.get(_NO_DATA)
    if is_park:
        return instruments.read_instrument(path, "ps", requested)
    if missing is not None:
        values = np.where(values == float(str(missing.value).strip("\0 ")), np.nan, values)
    about = Provenance(path.name, "TIFF", channel if len(pages) > 1 else "")
    return matrices.scale_array(path, values, about, "", requested, stated)


def channels(path: Path, name: str) -> tuple[Channel, ...]:
    """Return the pages of a file, heights if they are real numbers."""
    with _open_pages(path) as (file, pages):
        is_park = file.pages[0].tags.get(_PARK) is not None
        found = tuple(
            Channel(_page_name(page), "", page.dtype.kind == "f", page.shape) for page in pages
        )
    return instruments.channels(path, "ps") if is_park else found


def _page_name(page: Any) -> str:
    return f"page {page.index + 1}"


def _pixel(path: Path, file: Any, page: Any) -> tuple[float, float] | None:
    """Return the pixel [m] where a description names its unit."""
    if file.is_ome:
        sides = []
        for axis in "YX":
            size = re.search(rf'\bPhysicalSize{axis}="([^"]+)"', file.ome_metadata)
            unit = re.search(rf'\bPhysicalSize{axis}Unit="([^"]+)"', file.ome_metadata)
            word = unit[1] if unit else "um"
            if size is None or not is_length(path, word):
                return None
            sides.append(float(size[1]) * unit_in_meters(path, word))
        return sides[0], sides[1]
    word = str((file.imagej_metadata or {}).get("unit", "")).replace("\\u00B5", "u").strip("\0 ")
    word = _WORDS.get(word, word)
    counts = [page.tags.get(f"{axis}Resolution") for axis in "YX"]
    if not word or not is_length(path, word) or None in counts:
        return None
    metre = unit_in_meters(path, word)
    (y, one), (x, other) = (tag.value for tag in counts)
    return (metre * one / y, metre * other / x) if x and y else None
