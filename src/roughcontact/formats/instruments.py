"""Instrument files read by SurfaceTopography, and checks of their headers."""

from __future__ import annotations

import contextlib
import io
import math
import re
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np

from roughcontact._tools import memory, netcdf, processes
from roughcontact._tools.arrays import Array
from roughcontact._tools.text import replace_unprintable
from roughcontact.errors import ArgumentRef, FormatError, InputError
from roughcontact.formats import content, metrology, readers, source, text_files
from roughcontact.formats.source import (
    BoundedStream,
    Channel,
    ReadOptions,
    damage_as_error,
    is_length,
    make_surface,
    one_line,
    refuse_unit,
    unit_in_meters,
)
from roughcontact.surface.grid import PROFILE_WIDTH
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface

T = TypeVar("T")

# Name of SurfaceTopography's reader -> suffixes. The suffix decides, not the content:
# SurfaceTopography confuses the files of some vendors, and accepts any file for `hgt`, which is
# therefore excluded, as are its readers of formats without units that are not from instruments
# (MATLAB, HDF5, lists of points) and of single profiles.
_LIKE_SUFFIX = "al3d datx frt gwy ibw lext mdt mi mnt nms oir opd opdx os3d plux poir sdf tmd x3p"
SUFFIXES: dict[str, tuple[str, ...]] = {
    "bcr": (".bcr", ".bcrf"),
    "di": (".di", ".spm"),
    "ezd": (".ezd", ".nid"),
    "jpk": (".jpk", ".jpk-qi-image"),
    "metropro": (".dat",),
    "plu": (".apx", ".plu"),
    "qep": (".prf", ".qep"),
    "sur": (".pro", ".sur"),
    "vk": (".vk3", ".vk4", ".vk6", ".vk7"),
    "wsxm": (".stp", ".top"),
    **{name: (f".{name}",) for name in (*_LIKE_SUFFIX.split(), "zmg", "zon")},
}
SUFFIXES = dict(sorted(SUFFIXES.items()))

# A length unit does not make a channel a height: a calibrated deflection or amplitude error is in
# nm, too. SurfaceTopography 1.27 reports all channels of a Bruker file as heights.
_NOT_HEIGHT = re.compile(
    r"phase|ampl|deflection|error|friction|lateral|current|potential|adhesion|modulus|stiffness"
    r"|deformation|indentation|dissipation|force|voltage|intensity|brightness|contrast|quality"
    r"|colou?r|light|laser|noise|separation|input|frequency|excitation|\blfm\b|\btr\b|\bvert\b",
    re.IGNORECASE,
)

# Formats with compressed content: in ZIP archives, some with leading bytes; in zlib streams; in
# HDF5.
_ARCHIVES = ("plux", "poir", "qep", "vk", "x3p", "zon")
_STREAMS = ("jpk", "lext", "mnt", "ps")
_HDF5 = ("datx",)

# Computing time of a reader of streams [s], and more of it per bytes of the file.
_READING_SECONDS, _READING_RATE = 10, 2**20

# The maximum compression ratio of deflate is 1032; a header with more points is damaged.
_POINTS_PER_BYTE = 1100

# Memory for reading, in bytes per point.
_BYTES_PER_POINT = 40

# Largest pixel [m] of NanoFocus' microscopes, which have fields of 0.1 to 3 mm.
_MAX_NMS_PIXEL = 1e-3

_EPOCH = 1970

# Errors of SurfaceTopography for files of another format, and for contents that it does not read.
_OTHER_FORMAT = ("CannotDetectFileFormat", "FileFormatMismatch")
_UNSUPPORTED = ("UnsupportedFormatFeature", "UnsupportedSchema")


def read_instrument(path: Path, name: str, requested: ReadOptions) -> Surface:
    """Return the map in an instrument's file; ``name`` selects SurfaceTopography's reader."""
    if not _has_streams(path, name):
        return _read_map(path, name, requested)
    # Arrays lose their read-only flag in transit.
    return replace(_call_limited(_read_map, path, name, requested))


def channels(path: Path, name: str) -> tuple[Channel, ...]:
    """Return the channels of an instrument's file."""
    if not _has_streams(path, name):
        return _list_channels(path, name)
    return _call_limited(_list_channels, path, name)


def _has_streams(path: Path, name: str) -> bool:
    """Return whether a file has streams, which may unpack to more than the memory."""
    return name in _STREAMS or (name == "sur" and metrology.is_compressed_sur(path))


def _call_limited(function: Callable[..., T], path: Path, name: str, *args: Any) -> T:
    """Return the result of a reader in a process with limits."""
    with _reader_errors(path, name):
        # Imported before the fork, so that it is loaded once.
        _opener(path, name)
        seconds = _READING_SECONDS + path.stat().st_size // _READING_RATE
        return processes.call_limited(function, path, name, *args, seconds=seconds)


def _read_map(path: Path, name: str, requested: ReadOptions) -> Surface:
    with _open_reader(path, name) as reader:
        entries = list(reader.channels)
        if not entries:
            raise FormatError(
                f"{path.name} holds no channel whose heights and sides have units of length; set "
                "the units in the program that wrote it, or export the heights"
            )
        result = [_channel_from_entry(path, entry) for entry in entries]
        default = int(reader.default_channel.index)
        index = choose_channel(path, result, requested.channel, default)
        entry, described = entries[index], result[index]
        _check_grid(path, described)
        requested.check_shape(described.shape)
        if described.unit:
            refuse_unit(path, requested)
        metre = unit_in_meters(path, described.unit or requested.unit)
        topography, stated = _sized_map(entry, metre)
        if name == "nms" and stated is not None and min(stated) > _MAX_NMS_PIXEL:
            # The library takes the nanometers of the file for millimeters.
            stated = stated[0] * 1e-6, stated[1] * 1e-6
        values = np.ma.filled(np.ma.asarray(topography.heights(), dtype=np.float64), np.nan)
        notes: tuple[str, ...] = ()
        if values.ndim == 1:
            values, stated, notes = _profile_map(topography, values, metre)
        elif described.shape[0] == 1 and stated is not None:
            stated = PROFILE_WIDTH, stated[1]
        contradiction = _header_contradiction(path, name, entry, values)
        if contradiction:
            raise FormatError(
                f"{path.name} contradicts itself: {contradiction}; copy or export it again"
            )
        instrument = _instrument_name(reader, entry)
        acquired = _acquisition_time(entry)
        if name == "sur" and (entry.info.get("raw_metadata") or {}).get("imprint"):
            notes += ("read: a replica, as the file states; invert it for the surface itself",)
    provenance = Provenance(
        source=path.name, instrument=instrument, channel=_channel_name(result, index), steps=notes
    )
    # SurfaceTopography has [x, y], this package [y, x].
    return make_surface(path, values.T, metre, requested, provenance, stated, **acquired)


def _list_channels(path: Path, name: str) -> tuple[Channel, ...]:
    with _open_reader(path, name) as reader:
        return tuple(_channel_from_entry(path, entry) for entry in reader.channels)


def _sized_map(entry: Any, metre: float) -> tuple[Any, tuple[float, float] | None]:
    """Return the map of a channel from SurfaceTopography, and the pixel [m] in its file."""
    if entry.dim == 1:
        return entry.topography(), None
    if entry.physical_sizes is None:
        # The reader requires a size; all sizes are then converted to meters here.
        return entry.topography(physical_sizes=(1.0, 1.0)), None
    topography = entry.topography()
    along_x, along_y = (float(edge) for edge in topography.pixel_size)
    return topography, (along_y * metre, along_x * metre)


def _profile_map(
    profile: Any, values: Array, metre: float
) -> tuple[Array, tuple[float, float], tuple[str, ...]]:
    """Return a profile as a map of SurfaceTopography, its pixel [m], and processing steps."""
    if profile.is_uniform:
        return values[:, None], (PROFILE_WIDTH, float(profile.pixel_size[0]) * metre), ()
    position = np.asarray(profile.positions(), dtype=np.float64) * metre
    even, spacing, notes = text_files.resample_evenly(position, values)
    return even[:, None], (PROFILE_WIDTH, spacing), notes


def _channel_from_entry(path: Path, entry: Any) -> Channel:
    # Bruker's channels of other quantities have a pair of units, lateral and vertical.
    if isinstance(entry.unit, tuple):
        unit = entry.unit[-1]
        known = False
    else:
        unit = entry.data_unit
        known = unit == entry.unit
    text = "" if unit is None else str(unit)
    points = [int(count) for count in np.atleast_1d(entry.nb_grid_pts or ())]
    is_height = (
        known
        and bool(entry.is_height_channel)
        and entry.dim in (1, 2)
        and entry.dim == len(points)
        and not is_other_quantity(str(entry.name))
        and (not text or is_length(path, text))
    )
    shape = (1, *points) if entry.dim == 1 else tuple(reversed(points))
    return Channel(str(entry.name), text, is_height, shape)


def is_other_quantity(name: str) -> bool:
    """Return whether a channel has no heights by its name."""
    return _NOT_HEIGHT.search(name) is not None


def choose_channel(
    path: Path, result: list[Channel], channel: str | int | None, default: int
) -> int:
    """Return the index of the requested channel, or of the default or first height channel."""
    heights = [index for index, entry in enumerate(result) if entry.is_height]
    listing = "; ".join(
        f"{index}: {entry.name!r}"
        + (f" [{replace_unprintable(entry.unit)}]" if entry.unit else "")
        + ("" if entry.is_height else " (not a height)")
        for index, entry in enumerate(result)
    )
    if channel is None:
        if not heights:
            raise FormatError(
                f"{path.name} holds no height map, only the channels {listing}; export the heights"
            )
        return default if default in heights else heights[0]
    by_name = [index for index, entry in enumerate(result) if entry.name == channel]
    if len(by_name) > 1:
        # Among channels of equal name, a single height channel is unambiguous.
        by_name = [index for index in by_name if index in heights] or by_name
    if len(by_name) > 1:
        raise InputError(
            f"{path.name} has several channels named {channel!r}; give an index of {listing}"
        )
    if by_name:
        index = by_name[0]
    elif not isinstance(channel, bool) and re.fullmatch(r"\d{1,6}", str(channel)):
        index = int(channel)
    else:
        index = -1
    if not 0 <= index < len(result):
        raise InputError(f"{path.name} has no channel {channel!r}; its channels are {listing}")
    if index not in heights:
        raise InputError(
            f"{channel!r} of {path.name} is not a height; its channels are {listing}",
            argument="channel",
        )
    return index


def _check_grid(path: Path, described: Channel) -> None:
    points = math.prod(described.shape)
    profile = described.shape[:1] == (1,) and described.is_height
    if len(described.shape) != 2 or min(described.shape[profile:]) < 2:
        raise FormatError(
            f"{path.name} holds a grid of shape {described.shape}, no map of at least 2 × 2 points"
        )
    if points > _POINTS_PER_BYTE * path.stat().st_size:
        ny, nx = described.shape
        raise FormatError(
            f"{path.name} announces {ny} × {nx} points, more than its {path.stat().st_size} bytes "
            "can hold; check that the file is complete"
        )
    memory.require_points(path.name, described.shape, _BYTES_PER_POINT)


def _opener(path: Path, kind: str) -> Callable[[Any], Any]:
    """Return the function that opens a format, from its reader or the whole library."""
    with contextlib.suppress(ImportError):
        return cast("Callable[[Any], Any]", readers.reader(kind))
    library = source.import_optional(path, "SurfaceTopography.IO")
    return partial(library.open_topography, format=kind)


def _check_packed(path: Path, kind: str) -> None:
    """Raise `FormatError` for a damaged archive, or one that would exceed the memory."""
    memory.require_size(path.name, path.stat().st_size)
    with path.open("rb") as stream:
        start = stream.read(4)
    if kind in _HDF5 or start == b"\x89HDF":
        for name, stored in netcdf.check_hdf5(path).items():
            memory.require_size(f"{name!r} in {path.name}", stored.size, packed=path.stat().st_size)
            if stored.kind == "c":
                raise FormatError(
                    f"{path.name} holds complex numbers in {name!r}, no heights; copy or export it "
                    "again"
                )
    elif start == b"PK\x03\x04" or (kind in _ARCHIVES and zipfile.is_zipfile(path)):
        source.check_archive(path)
        if kind == "x3p":
            metrology.check_x3p(path)
    elif kind == "ibw" and start[:2] not in (b"\5\0", b"\0\5"):
        # The reader accepts no other version; its library logs all bytes of other files.
        raise ValueError("it is no binary wave of version 5")


@contextlib.contextmanager
def _open_reader(path: Path, kind: str) -> Iterator[Any]:
    """Open SurfaceTopography's reader of a file, with all errors as `FormatError`."""
    with _reader_errors(path, kind):
        try:
            _check_packed(path, kind)
            opened = _opener(path, kind)
            # The stream is opened here, as a reader that fails does not close files that it opened.
            with (
                np.errstate(all="ignore"),
                _reader_stream(path, kind) as stream,
                opened(stream) as reader,
            ):
                yield reader
        except Exception as error:
            what = type(error).__name__
            if what in _OTHER_FORMAT:
                raise FormatError(
                    f"{path.name} is {content.describe_content(path)}, no whole file of the format "
                    f"{kind!r} ({one_line(error)}); give its {ArgumentRef('format')}, or export "
                    "the heights as .x3p, .sur or text"
                ) from error
            if what in _UNSUPPORTED:
                raise FormatError(
                    f"{path.name} is of the format {kind!r}, with a content that its reader does "
                    f"not support ({one_line(error)}); export the heights as .x3p, .sur or text"
                ) from error
            raise


def _reader_errors(path: Path, kind: str) -> contextlib.AbstractContextManager[None]:
    advice = f"check that the file is complete, or give its {ArgumentRef('format')}"
    return damage_as_error(path, f"format {kind!r}", advice)


def _reader_stream(path: Path, kind: str) -> io.BufferedIOBase:
    """Return the stream of a reader; a bare Mahr profile is put into the expected archive."""
    adapt = {"sur": metrology.open_sur, "x3p": metrology.open_x3p}.get(kind)
    if adapt is not None and (adapted := adapt(path)) is not None:
        return adapted
    if kind != "qep" or zipfile.is_zipfile(path):
        return BoundedStream(io.FileIO(path))
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.write(path, "Kontur1.prf")
    packed.seek(0)
    return packed


def _channel_name(result: list[Channel], index: int) -> str:
    """Return the name that distinguishes a channel; empty if there is only one."""
    name = result[index].name
    namesakes = [entry for entry in result if entry.name == name]
    if len(namesakes) > 1:
        return f"{name} (index {index})"
    return name if len(result) > 1 else ""


def _acquisition_time(entry: Any) -> dict[str, str]:
    """Return the time of measurement; empty if missing or if the clock was not set."""
    when = entry.info.get("acquisition_time")
    # Instruments with an unset clock, and programs without dates, write 1970.
    if not isinstance(when, datetime) or when.year <= _EPOCH:
        return {}
    return {"acquired": when.isoformat(timespec="seconds")}


def _instrument_name(reader: Any, entry: Any) -> str:
    about = entry.info.get("instrument") or {}
    named = [str(about[key]) for key in ("vendor", "name") if about.get(key)]
    name = str(reader.name())
    return f"{name} ({' '.join(named)})" if named else name


def _header_contradiction(path: Path, kind: str, entry: Any, values: Array) -> str:
    """Return the contradiction between a header and its file; empty if there is none."""
    check = _CONTRADICTIONS.get(kind)
    header = entry.info.get("raw_metadata")
    if check is None or not header or np.isnan(values).all():
        return ""
    try:
        return check(path, header, entry, values)
    # Another version of SurfaceTopography keeps less of the header.
    except KeyError:
        return ""


def _metropro_contradiction(path: Path, header: dict[str, Any], entry: Any, values: Array) -> str:
    phases = 4 * header["cn_org_width"] * header["cn_org_height"]
    frames = 2 * header["ac_org_width"] * header["ac_org_height"] * header["ac_n_buckets"]
    for what, size, stated in (
        ("phases", phases, header["cn_n_bytes"]),
        ("camera frames", frames, header["ac_n_bytes"]),
    ):
        if size != stated:
            return f"its {what} take {size} bytes by their grid and {stated} by their size"
    return ""


def _sur_contradiction(path: Path, header: dict[str, Any], entry: Any, values: Array) -> str:
    end = 512 + header["comment_size"] + header["private_size"]
    end += header["nb_points"] * header["itemsize"] // 8
    length = path.stat().st_size
    if end == length or metrology.is_compressed_sur(path):
        return ""
    stated = header["zmin"], header["zmax"]
    counts = values / entry.height_scale_factor
    low, high = np.nanmin(counts).round(), np.nanmax(counts).round()
    # Some programs append to the file, some leave the range open, but none both.
    if (low, high) == stated:
        return ""
    return (
        f"its heights end at byte {end} of {length} and span {low:.0f} to {high:.0f} counts, "
        f"not {stated[0]} to {stated[1]}"
    )


def _opd_contradiction(path: Path, header: dict[str, Any], entry: Any, values: Array) -> str:
    if "Aspect" not in header and "Wavelength" in header:
        return "it has no block 'Aspect', the ratio of the edges of a pixel"
    # Integers are fractions of a wavelength, floats are whole wavelengths.
    counts = values / entry.height_scale_factor
    if "Mult" not in header and np.nanmax(np.abs(counts - np.rint(counts))) < 1e-6:
        return "its heights are integers, but it has no block 'Mult', their scale"
    return ""


def _bruker_contradiction(path: Path, header: dict[str, Any], entry: Any, values: Array) -> str:
    # If the number of points of an image does not match its bytes, SurfaceTopography uses the
    # number of the scan and rescales the sides accordingly.
    stated = int(header["samps/line"]), int(header["number of lines"])
    nx, ny = entry.nb_grid_pts
    if stated == (nx, ny):
        return ""
    width, _, height = header["aspect ratio"].partition(":")
    along_x, along_y = entry.physical_sizes
    if math.isclose(along_x * float(height), along_y * float(width), rel_tol=1e-4):
        return ""
    return f"the image has {stated[0]} × {stated[1]} points by its section, {nx} × {ny} by the scan"


def _mnt_contradiction(path: Path, header: dict[str, Any], entry: Any, values: Array) -> str:
    stated = header["axes"]["z"]["max_count"] - header["axes"]["z"]["min_count"]
    counts = (np.nanmax(values) - np.nanmin(values)) / entry.height_scale_factor
    # Masked points may be anywhere in the range, but heights lost in the digits of the origin or
    # beyond the range are errors.
    if stated <= 0 or 0.01 * stated < counts < 1.01 * stated + 1:
        return ""
    return f"its heights span {counts:.0f} counts, not {stated}"


def _sdf_contradiction(path: Path, header: dict[str, Any], entry: Any, values: Array) -> str:
    # Text variant only; the binary variant may have any content after its heights.
    parts = re.split(rb"^\s*\*\s*$", path.read_bytes(), flags=re.MULTILINE)
    if not parts[0].startswith(b"a") or len(parts) < 2:
        return ""
    count = len(parts[1].split())
    return "" if count == values.size else f"it announces {values.size} heights, but has {count}"


_CONTRADICTIONS: dict[str, Callable[[Path, dict[str, Any], Any, Array], str]] = {
    "di": _bruker_contradiction,
    "metropro": _metropro_contradiction,
    "mnt": _mnt_contradiction,
    "opd": _opd_contradiction,
    "sdf": _sdf_contradiction,
    "sur": _sur_contradiction,
}
