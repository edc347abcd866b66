"""Read measured height maps: instrument files, plain matrices, the program's own NetCDF."""

from __future__ import annotations

import contextlib
import io
import itertools
import math
import os
import re
import warnings
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from roughcontact import netcdf, units
from roughcontact.errors import FormatError, InputError
from roughcontact.surface.provenance import Provenance
from roughcontact.surface.surface import Surface

if TYPE_CHECKING:
    from types import ModuleType

Array = NDArray[np.float64]

TEXT_MARK = "# roughcontact map"
"""First line of a text matrix whose head names its quantity, unit and pixel."""

# Plain matrices and the program's own files.
_OWN_SUFFIXES = {
    ".npy": "npy",
    ".npz": "npz",
    ".csv": "text",
    ".txt": "text",
    ".asc": "text",
    ".nc": "netcdf",
}

# Suffix -> name of SurfaceTopography's reader. The suffix decides and the content does not:
# SurfaceTopography takes one vendor's file for another's, and anything at all for `hgt`, which
# is therefore left out, as are its readers of formats without units that are not instruments'
# (MATLAB, HDF5, lists of points) and of single profiles.
_INSTRUMENT_SUFFIXES = {
    ".al3d": "al3d",
    ".apx": "plu",
    ".bcr": "bcr",
    ".bcrf": "bcr",
    ".dat": "metropro",
    ".datx": "datx",
    ".di": "di",
    ".ezd": "ezd",
    ".frt": "frt",
    ".gwy": "gwy",
    ".ibw": "ibw",
    ".jpk": "jpk",
    ".lext": "lext",
    ".mdt": "mdt",
    ".mi": "mi",
    ".mnt": "mnt",
    ".nid": "ezd",
    # Some releases read its lateral sizes 10⁶ too large: such a size is refused as implausible.
    ".nms": "nms",
    ".oir": "oir",
    ".opd": "opd",
    ".opdx": "opdx",
    ".os3d": "os3d",
    ".plu": "plu",
    ".plux": "plux",
    ".poir": "poir",
    ".qep": "qep",
    ".sdf": "sdf",
    ".spm": "di",
    ".stp": "wsxm",
    ".sur": "sur",
    ".tif": "ps",
    ".tiff": "ps",
    ".tmd": "tmd",
    ".top": "wsxm",
    ".vk3": "vk",
    ".vk4": "vk",
    ".vk6": "vk",
    ".vk7": "vk",
    ".x3p": "x3p",
    ".zmg": "zmg",
    ".zon": "zon",
}

SUFFIXES = _OWN_SUFFIXES | _INSTRUMENT_SUFFIXES
"""Suffix of a file -> name of the format; a suffix of three digits is Bruker's ``di`` as well."""

_BRUKER_SUFFIX = re.compile(r"\.\d{3}")

# Units of length as instrument files spell them, where pint does not know the spelling or knows
# another meaning ("A" is the ampere to pint).
_FILE_UNITS = {"A": "angstrom", "Å": "angstrom", "~m": "um"}

# A length unit does not make a channel a height: a calibrated deflection or amplitude error is
# in nm, too. SurfaceTopography 1.27 calls all channels of a Bruker file heights.
_NOT_HEIGHT = re.compile(
    r"phase|ampl|deflection|error|friction|lateral|current|potential|adhesion|modulus|stiffness"
    r"|deformation|indentation|dissipation|force|voltage|intensity|brightness|contrast|quality"
    r"|colou?r|light|laser|noise|separation|input|frequency|excitation|\blfm\b|\btr\b|\bvert\b",
    re.IGNORECASE,
)

# Plausible scales [m]: from a few atoms to a machine bed.
_SIDE_RANGE = (1e-9, 10.0)
_PIXEL_RANGE = (1e-12, 1e-2)
_HEIGHT_OVER_SIDE = 100.0

# Deflate packs 1032 to 1 at most; a header that claims more points than this is damaged.
_POINTS_PER_BYTE = 1100


@dataclass(frozen=True)
class Channel:
    """One channel of a file.

    Parameters
    ----------
    name : str
        Name in the file; empty if the file names none.
    unit : str
        Unit of the values as the file gives it; empty if it gives none.
    is_height : bool
        Whether the channel holds heights, by its name and its unit.
    shape : tuple of int
        Grid points ``(ny, nx)``.
    """

    name: str
    unit: str
    is_height: bool
    shape: tuple[int, ...]


def read_surface(
    path: str | os.PathLike[str],
    format: str | None = None,  # noqa: A002 - the word a user looks for
    channel: str | int | None = None,
    unit: str | None = None,
    size: tuple[float, float] | str | None = None,
) -> Surface:
    """Read a height map from a file.

    Parameters
    ----------
    path : str or path
        Instrument file, matrix of numbers (``.npy``, ``.npz``, ``.csv``, ``.txt``, ``.asc``) or
        NetCDF file of this program.
    format : str, optional
        Name of the format or a suffix that stands for it, see `SUFFIXES`; by default the suffix
        of the file decides.
    channel : str or int, optional
        Name or index of the height channel; by default the one the file proposes, or its first
        height channel.
    unit : str, optional
        Unit of the heights, such as ``"um"``; for files that do not give it, and only these. If
        an instrument file gives lengths of its sides but no unit, they are in this unit as well.
    size : (float, float) or str, optional
        Lengths of the sides ``(y, x)`` [m], or as text in the same order, ``"0.1 mm x 0.2 mm"``;
        one length for a square grid. For files that do not give it, and only these.

    Returns
    -------
    Surface
        Heights [m] and pixel ``(dy, dx)`` [m], NaN where the file marks a point as missing. Rows
        run along y in the direction in which the reader delivers them.

    Raises
    ------
    FormatError
        If the file is missing, empty, damaged, of another type, or holds no height map.
    InputError
        If unit, size or channel are needed and not given, or given and contradicted.

    Notes
    -----
    A text matrix gives its unit and pixel itself if it starts with the lines ``# roughcontact
    map``, ``# quantity: height``, ``# unit: um``, ``# pixel_y: 2 um`` and ``# pixel_x: 1 um``; a
    NumPy archive if it holds arrays ``heights``, ``pixel`` (dy, dx) and ``unit``, the unit of
    both.

    Scales that no measured map has are refused: sides outside 1 nm to 10 m, pixel edges outside
    1 pm to 10 mm, heights that span more than 100 times the longer side, or lie further than 10 m
    from zero, where the digits of roughness are lost.

    So are instrument files whose header contradicts the rest of the file, as far as the format
    says something twice: sizes against grids (metropro, sur, sdf, di), the range of heights
    (sur, mnt); and those in which a scale is missing that the reader would take as 1 (opd).
    """
    path = _existing(path)
    kind = _format_of(path, format)
    if kind == "netcdf":
        _refuse_given(path, unit=unit, size=size)
        surface = _read_netcdf(path)
    elif kind in _OWN_SUFFIXES.values():
        surface = _read_matrix(path, kind, channel, unit, size)
    else:
        surface = _read_instrument(path, kind, channel, unit, size)
    _check_scale(path, surface)
    return surface


def channels(
    path: str | os.PathLike[str],
    format: str | None = None,  # noqa: A002 - the word a user looks for
) -> tuple[Channel, ...]:
    """Return the channels of a file in their order.

    Parameters
    ----------
    path : str or path
        The file.
    format : str, optional
        As in `read_surface`.

    Returns
    -------
    tuple of Channel
        At least one; the position is the index that `read_surface` takes.

    Raises
    ------
    FormatError
        If the file cannot be read.
    """
    path = _existing(path)
    kind = _format_of(path, format)
    if kind == "netcdf":
        return (Channel("height", "m", True, _read_netcdf(path).shape),)
    if kind == "text":
        stated = _head_of_text(path)
        quantity, unit = stated.get("quantity", ""), stated.get("unit", "")
        is_height = not stated or quantity == "height"
        return (Channel(quantity, unit, is_height, _read_text(path)[0].shape),)
    if kind in ("npy", "npz"):
        return tuple(
            Channel(name, "", array.ndim == 2, array.shape)
            for name, array in _read_arrays(path, kind).items()
        )
    with _instrument(path, kind) as reader:
        return tuple(_described(entry) for entry in reader.channels)


# Files and arguments


def _existing(path: str | os.PathLike[str]) -> Path:
    path = Path(path)
    try:
        if path.is_dir():
            raise FormatError(f"{path} is a directory; give the file with the height map")
        if not path.exists():
            raise FormatError(f"{path} does not exist; check the name of the file")
        with path.open("rb") as stream:
            empty = not stream.read(1)
    except FormatError:
        raise
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise FormatError(f"{path} cannot be opened ({reason}); check the file") from None
    if empty:
        raise FormatError(f"{path} is empty; export or copy the measurement again")
    return path


def _format_of(path: Path, format_name: str | None) -> str:
    if format_name is not None:
        name = format_name.lower().removeprefix(".")
        if name in SUFFIXES.values():
            return name
        if f".{name}" in SUFFIXES:
            return SUFFIXES[f".{name}"]
        known = ", ".join(sorted(set(SUFFIXES.values())))
        raise InputError(f"format must be one of {known}, got {format_name!r}")
    suffix = path.suffix.lower()
    if _BRUKER_SUFFIX.fullmatch(suffix):
        return "di"
    if suffix not in SUFFIXES:
        known = ", ".join(sorted(SUFFIXES))
        raise FormatError(
            f"{path.name} has the unknown suffix {suffix!r}; give format= or one of the known "
            f"suffixes {known}, .000 to .999"
        )
    return SUFFIXES[suffix]


def _refuse_given(path: Path, **given: object) -> None:
    for name, value in given.items():
        if value is not None:
            raise InputError(f"{path.name} gives its {name} itself; leave out {name}={value!r}")


def _unit_in_metres(path: Path, unit: str | None) -> float:
    if unit is None:
        raise InputError(f"{path.name} gives no unit of the heights; give it, e.g. unit='um'")
    return units.parse(f"1 {_FILE_UNITS.get(unit, unit)}", "length", "unit")


def pixel_of(
    size: tuple[float, float] | str | None, shape: tuple[int, int], name: str = "the map"
) -> tuple[float, float]:
    """Return the pixel of a grid over an outline.

    Parameters
    ----------
    size : (float, float) or str
        Lengths of the sides ``(y, x)`` [m], or as text; one for a square grid.
    shape : (int, int)
        Points ``(ny, nx)``.
    name : str
        What has these sides, for the message.

    Returns
    -------
    (float, float)
        Pixel edges ``(dy, dx)`` [m].

    Raises
    ------
    InputError
        If the size is missing or cannot be used.
    """
    ny, nx = shape
    if size is None:
        raise InputError(
            "gives no lengths of its sides; give them in the order (y, x), e.g. "
            "size='0.1 mm x 0.2 mm'",
            argument=name,
        )
    if isinstance(size, str):
        # An x before no number is part of a unit.
        parts = re.split(r"\s*[x×]\s*(?=[-+\u2212.\d])", size.strip())
        sides = tuple(units.parse(part, "length", "size") for part in parts)
    else:
        try:
            sides = tuple(float(side) for side in np.atleast_1d(np.asarray(size, dtype=float)))
        except (TypeError, ValueError):
            raise InputError(
                f"must be a pair (y, x) in metres, got {size!r}", argument="size", value=size
            ) from None
    if len(sides) == 1 and ny == nx:
        sides *= 2
    if len(sides) != 2:
        raise InputError(
            f"must give both sides (y, x) of a grid of {ny} × {nx} points, got {size!r}; "
            "write e.g. '0.1 mm x 0.2 mm'",
            argument="size",
            value=size,
        )
    if not all(0 < side < math.inf for side in sides):
        raise InputError(f"must be positive and finite, got {size!r}", argument="size", value=size)
    return sides[0] / ny, sides[1] / nx


def _in_metres(values: NDArray[Any], metre: float) -> Array:
    # Damaged numbers overflow, or are NaN of the signalling kind: `_surface` judges the outcome.
    with np.errstate(all="ignore"):
        heights: Array = values.astype(np.float64) * metre
    return heights


def _surface(
    path: Path, heights: NDArray[Any], pixel: tuple[float, float], provenance: Provenance
) -> Surface:
    try:
        return Surface(heights, pixel, provenance)
    except InputError as error:
        raise FormatError(f"{path.name} holds no height map that can be used: {error}") from None


def _check_scale(path: Path, surface: Surface) -> None:
    what = "check the unit and the size in the file"
    for name, values, (low, high) in (
        ("sides (y, x)", surface.size, _SIDE_RANGE),
        ("pixel (dy, dx)", surface.pixel, _PIXEL_RANGE),
    ):
        if not all(low <= value <= high for value in values):
            first, second = (units.engineering(value, "m") for value in values)
            raise FormatError(
                f"{path.name} was read with {name} of {first} × {second}, which is outside "
                f"{units.engineering(low, 'm')} to {units.engineering(high, 'm')}; {what}"
            )
    top, bottom = float(np.nanmax(surface.heights)), float(np.nanmin(surface.heights))
    span = top - bottom
    if span > _HEIGHT_OVER_SIDE * max(surface.size):
        raise FormatError(
            f"{path.name} was read with heights that span {units.engineering(span, 'm')} on sides "
            f"of {units.engineering(max(surface.size), 'm')}; {what}, or mark outliers as missing"
        )
    if max(top, -bottom) > _SIDE_RANGE[1]:
        raise FormatError(
            f"{path.name} was read with heights from {units.engineering(bottom, 'm')} to "
            f"{units.engineering(top, 'm')}, further than {units.engineering(_SIDE_RANGE[1], 'm')} "
            f"from zero; {what}"
        )


def _one_line(error: BaseException) -> str:
    # Readers quote the bytes they stumble over; keep what can be printed.
    printable = "".join(c if c.isprintable() else " " for c in str(error))
    text = " ".join(printable.split()) or "no reason given"
    return f"{type(error).__name__}: {text if len(text) <= 160 else text[:159] + '…'}"


# Instrument files


def _surface_topography(path: Path) -> ModuleType:
    try:
        import SurfaceTopography.IO
    except ImportError as error:
        raise FormatError(
            f"{path.name} needs SurfaceTopography, which cannot be imported ({_one_line(error)}); "
            "run pip install 'roughcontact[io]'"
        ) from None
    module: ModuleType = SurfaceTopography.IO
    return module


class _Bounded(io.BufferedReader):
    """A stream that reserves no more memory for a read than the file can fill.

    A damaged header may ask for terabytes, which `io.BufferedReader` reserves before it reads.
    """

    def read(self, size: int | None = -1, /) -> bytes:
        if size is not None and size > 0:
            left = os.fstat(self.fileno()).st_size - self.tell()
            size = min(size, max(left, 0))
        return super().read(size)


@contextlib.contextmanager
def _instrument(path: Path, kind: str) -> Iterator[Any]:
    """Give SurfaceTopography's reader of a file, quiet, and with one kind of error."""
    # Parsers print, and log what they cannot read, byte by byte.
    noise = io.StringIO()
    with (
        warnings.catch_warnings(),
        contextlib.redirect_stdout(noise),
        contextlib.redirect_stderr(noise),
    ):
        warnings.simplefilter("ignore")
        try:
            library = _surface_topography(path)
            _check_container(path)
            # Our own stream: a reader that fails half-way leaves files open that it opened.
            with (
                _Bounded(io.FileIO(path)) as stream,
                library.open_topography(stream, format=kind) as reader,
            ):
                yield reader
        except InputError:
            raise
        # Readers of damaged files fail with anything: AssertionError, struct.error, KeyError,
        # MemoryError. All mean the same to the user.
        except Exception as error:
            raise FormatError(
                f"{path.name} cannot be read as format {kind!r} ({_one_line(error)}); check that "
                "the file is complete, or name its format with format="
            ) from error


def _check_container(path: Path) -> None:
    """Refuse ZIP archives with a wrong checksum, and HDF5 files that would be read for ever.

    Several instruments' formats are one or the other. Checksums of an archive are looked at where
    a member is read to its end, and one damaged length is enough that it is not.
    """
    with path.open("rb") as stream:
        start = stream.read(4)
        if start == b"\x89HDF":
            netcdf.check_heaps(path)
        if start != b"PK\x03\x04":
            return
        with zipfile.ZipFile(stream) as archive:
            damaged = archive.testzip()
    if damaged is not None:
        raise ValueError(f"the checksum of {damaged!r} in the archive is wrong")


def _read_instrument(
    path: Path,
    kind: str,
    channel: str | int | None,
    unit: str | None,
    size: tuple[float, float] | str | None,
) -> Surface:
    with _instrument(path, kind) as reader:
        entries = list(reader.channels)
        found = [_described(entry) for entry in entries]
        default = int(reader.default_channel.index)
        index = _chosen(path, found, channel, default)
        entry, described = entries[index], found[index]
        _check_grid(path, described)
        if described.unit:
            _refuse_given(path, unit=unit)
            unit = described.unit
        if entry.physical_sizes is not None:
            _refuse_given(path, size=size)
        metre = _unit_in_metres(path, unit)
        pixel: tuple[float, float]
        if entry.physical_sizes is None:
            ny, nx = described.shape
            pixel = pixel_of(size, (ny, nx), path.name)
            # Any size will do for the reader; ours is in metres whatever its unit.
            topography = entry.topography(physical_sizes=(1.0, 1.0))
        else:
            topography = entry.topography()
            along_x, along_y = (float(edge) for edge in topography.pixel_size)
            pixel = along_y * metre, along_x * metre
        values = np.ma.filled(np.ma.asarray(topography.heights(), dtype=np.float64), np.nan)
        contradiction = _contradiction(path, kind, entry, values)
        if contradiction:
            raise FormatError(
                f"{path.name} contradicts itself: {contradiction}; copy or export it again"
            )
        # SurfaceTopography has [x, y], this program [y, x].
        heights = _in_metres(np.ascontiguousarray(values.T), metre)
        instrument = _instrument_name(reader, entry)
    provenance = Provenance(
        source=path.name,
        instrument=instrument,
        channel=described.name if len(found) > 1 else "",
    )
    return _surface(path, heights, pixel, provenance)


def _described(entry: Any) -> Channel:
    # Bruker's non-height channels have a pair of units, lateral and vertical.
    if isinstance(entry.unit, tuple):
        unit = entry.unit[-1]
        known = False
    else:
        unit = entry.data_unit
        known = unit == entry.unit
    text = "" if unit is None else str(unit)
    is_height = (
        known
        and bool(entry.is_height_channel)
        and entry.dim == 2
        and (not text or _is_length(text))
        and not _NOT_HEIGHT.search(str(entry.name))
    )
    shape = tuple(int(points) for points in reversed(entry.nb_grid_pts or ()))
    return Channel(str(entry.name), text, is_height, shape)


def _is_length(unit: str) -> bool:
    try:
        units.parse(f"1 {_FILE_UNITS.get(unit, unit)}", "length", "unit")
    except InputError:
        return False
    return True


def _chosen(path: Path, found: list[Channel], channel: str | int | None, default: int) -> int:
    heights = [index for index, entry in enumerate(found) if entry.is_height]
    listing = "; ".join(
        f"{index}: {entry.name!r}"
        + (f" [{entry.unit}]" if entry.unit else "")
        + ("" if entry.is_height else " (not a height)")
        for index, entry in enumerate(found)
    )
    if channel is None:
        if not heights:
            raise FormatError(
                f"{path.name} holds no height map, only the channels {listing}; export the heights"
            )
        return default if default in heights else heights[0]
    by_name = [index for index, entry in enumerate(found) if entry.name == channel]
    if len(by_name) > 1:
        # One height among namesakes is no choice.
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
    if not 0 <= index < len(found):
        raise InputError(f"{path.name} has no channel {channel!r}; its channels are {listing}")
    if index not in heights:
        raise InputError(
            f"{channel!r} of {path.name} is not a height; its channels are {listing}",
            argument="channel",
        )
    return index


def _check_grid(path: Path, described: Channel) -> None:
    points = math.prod(described.shape)
    if len(described.shape) != 2 or min(described.shape) < 2:
        raise FormatError(
            f"{path.name} holds a grid of shape {described.shape}, no map of at least 2 × 2 points"
        )
    if points > _POINTS_PER_BYTE * path.stat().st_size:
        ny, nx = described.shape
        raise FormatError(
            f"{path.name} announces {ny} × {nx} points, more than its {path.stat().st_size} bytes "
            "can hold; check that the file is complete"
        )


def _contradiction(path: Path, kind: str, entry: Any, values: Array) -> str:
    """Return what in a header does not fit the rest of the file; empty if everything does.

    What SurfaceTopography does not compare, or replaces where it is missing. Without it one
    damaged byte shears a map or changes its scale by a plausible factor.
    """
    check = _CONTRADICTIONS.get(kind)
    header = entry.info.get("raw_metadata")
    if check is None or not header:
        return ""
    try:
        return check(path, header, entry, values)
    # Another version of SurfaceTopography that keeps less of the header.
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
    if end == length:
        return ""
    stated = header["zmin"], header["zmax"]
    counts = values / entry.height_scale_factor
    low, high = np.nanmin(counts).round(), np.nanmax(counts).round()
    # Some programs append to the file, some leave the range open; not both.
    if (low, high) == stated:
        return ""
    return (
        f"its heights end at byte {end} of {length} and span {low:.0f} to {high:.0f} counts, "
        f"not {stated[0]} to {stated[1]}"
    )


def _opd_contradiction(path: Path, header: dict[str, Any], entry: Any, values: Array) -> str:
    if "Aspect" not in header and "Wavelength" in header:
        return "it has no block 'Aspect', the ratio of the edges of a pixel"
    # Integers are parts of a wavelength, floats whole ones.
    counts = values / entry.height_scale_factor
    if "Mult" not in header and np.nanmax(np.abs(counts - np.rint(counts))) < 1e-6:
        return "its heights are integers, but it has no block 'Mult', their scale"
    return ""


def _bruker_contradiction(path: Path, header: dict[str, Any], entry: Any, values: Array) -> str:
    # Where an image has not the points that its bytes make, SurfaceTopography takes those of the
    # scan, and stretches the sides with them.
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
    # Masked points may lie anywhere in the range; what is lost in the digits of the origin, or is
    # beyond the range, does not.
    if stated <= 0 or 0.01 * stated < counts < 1.01 * stated + 1:
        return ""
    return f"its heights span {counts:.0f} counts, not {stated}"


def _sdf_contradiction(path: Path, header: dict[str, Any], entry: Any, values: Array) -> str:
    # The text variant; the binary one may have anything after its heights.
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


def _instrument_name(reader: Any, entry: Any) -> str:
    about = entry.info.get("instrument") or {}
    named = [str(about[key]) for key in ("vendor", "name") if about.get(key)]
    name = str(reader.name())
    return f"{name} ({' '.join(named)})" if named else name


# Matrices of plain numbers


def _read_matrix(
    path: Path,
    kind: str,
    channel: str | int | None,
    unit: str | None,
    size: tuple[float, float] | str | None,
) -> Surface:
    steps: tuple[str, ...] = ()
    name = ""
    scale: tuple[float, tuple[float, float]] | None
    if kind == "text":
        if channel is not None:
            raise InputError(f"{path.name} has no channels; leave out channel={channel!r}")
        scale = _scale_in_text(path)
        values, steps = _read_text(path, points_possible=scale is None)
    else:
        arrays = _read_arrays(path, kind)
        scale = _scale_in_arrays(path, arrays) if channel in (None, "heights") else None
        name, values = _chosen_array(path, arrays, channel if scale is None else "heights")
    if values.dtype.kind not in "fiu" or values.ndim != 2 or min(values.shape) < 2:
        raise FormatError(
            f"{path.name} must hold a matrix of at least 2 × 2 real numbers, got {values.dtype} "
            f"of shape {values.shape}"
        )
    if scale is None:
        metre = _unit_in_metres(path, unit)
        ny, nx = values.shape
        pixel = pixel_of(size, (ny, nx), path.name)
    else:
        _refuse_given(path, unit=unit, size=size)
        metre, pixel = scale
    provenance = Provenance(path.name, f"matrix ({kind})", name, steps)
    return _surface(path, _in_metres(values, metre), pixel, provenance)


@contextlib.contextmanager
def _naming(path: Path) -> Iterator[None]:
    """Turn the complaint about a quantity into one about the file that states it."""
    try:
        yield
    except InputError as error:
        raise FormatError(f"{path.name} states its scale wrongly: {error}") from None


def _head_of_text(path: Path) -> dict[str, str]:
    """Return what the head of a text matrix states; nothing if it has no head of this program."""
    try:
        with path.open(encoding="utf-8-sig", errors="replace") as stream:
            if stream.readline().strip() != TEXT_MARK:
                return {}
            lines = itertools.takewhile(lambda line: line.startswith("#"), stream)
            parts = (line[1:].partition(":") for line in lines)
            return {name.strip(): value.strip() for name, mark, value in parts if mark}
    except OSError as error:
        raise FormatError(f"{path.name} cannot be read ({_one_line(error)})") from None


def _scale_in_text(path: Path) -> tuple[float, tuple[float, float]] | None:
    """Return the unit [m] and the pixel [m] that the head of a text matrix states."""
    stated = _head_of_text(path)
    if not stated:
        return None
    absent = [name for name in ("quantity", "unit", "pixel_y", "pixel_x") if name not in stated]
    if absent:
        raise FormatError(
            f"{path.name} lacks {', '.join(absent)} in its head; complete it, or remove the line "
            f"{TEXT_MARK!r} and give unit= and size="
        )
    if stated["quantity"] != "height":
        raise FormatError(f"{path.name} holds {stated['quantity']!r}, no heights")
    with _naming(path):
        metre = _unit_in_metres(path, stated["unit"])
        dy, dx = (units.parse(stated[name], "length", name) for name in ("pixel_y", "pixel_x"))
    return metre, (dy, dx)


def _scale_in_arrays(
    path: Path, arrays: dict[str, NDArray[Any]]
) -> tuple[float, tuple[float, float]] | None:
    """Return the unit [m] and the pixel [m] that a NumPy archive holds beside its heights."""
    if not {"heights", "pixel", "unit"} <= arrays.keys():
        return None
    pixel, unit = arrays["pixel"], arrays["unit"]
    if pixel.shape != (2,) or pixel.dtype.kind not in "fiu" or unit.dtype.kind != "U" or unit.ndim:
        raise FormatError(
            f"{path.name} must hold two numbers (dy, dx) as pixel and a word as unit, got "
            f"{pixel.dtype} of shape {pixel.shape} and {unit.dtype} of shape {unit.shape}"
        )
    with _naming(path):
        metre = _unit_in_metres(path, str(unit))
    return metre, (float(pixel[0]) * metre, float(pixel[1]) * metre)


def _read_arrays(path: Path, kind: str) -> dict[str, NDArray[Any]]:
    try:
        if kind == "npy":
            # Mapped, not read: a header that announces more than the file holds fails at once.
            array = np.load(path, mmap_mode="r", allow_pickle=False)
            spare = path.stat().st_size - array.offset - array.nbytes
            if array.size and spare:
                raise ValueError(
                    f"shape {array.shape} of {array.dtype} leaves {spare} bytes of the file over"
                )
            return {"": array}
        # Our own stream: NumPy leaves a damaged archive open.
        _check_container(path)
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as archive:
            return {name: np.asarray(archive[name]) for name in archive.files}
    # Damaged files raise ValueError, BadZipFile, EOFError, SyntaxError, MemoryError and more.
    except Exception as error:
        raise FormatError(
            f"{path.name} cannot be read as NumPy file {kind!r} ({_one_line(error)}); save a real "
            "array with numpy.save or numpy.savez"
        ) from None


def _chosen_array(
    path: Path, arrays: dict[str, NDArray[Any]], channel: str | int | None
) -> tuple[str, NDArray[Any]]:
    names = list(arrays)
    if channel is None and len(names) == 1:
        return names[0], arrays[names[0]]
    listing = "; ".join(f"{index}: {name!r}" for index, name in enumerate(names)) or "none"
    if channel is None:
        raise InputError(f"{path.name} holds the arrays {listing}; choose one with channel=")
    if channel in arrays:
        return str(channel), arrays[str(channel)]
    if not isinstance(channel, bool) and re.fullmatch(r"\d{1,6}", str(channel)):
        index = int(channel)
        if index < len(names):
            return names[index], arrays[names[index]]
    raise InputError(f"{path.name} has no array {channel!r}; it holds {listing}")


_MISSING = re.compile(r"|nan|n/?a|bad|\*+|-{2,}", re.IGNORECASE)
_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?")


def _read_text(path: Path, points_possible: bool = True) -> tuple[Array, tuple[str, ...]]:
    """Return the matrix in a text file, and what was decided in reading it."""
    rows: list[Array] = []
    numbers: list[int] = []
    delimiter: str | None = ""
    trailing = ended = True
    try:
        with path.open(encoding="utf-8-sig") as stream:
            for number, line in enumerate(stream, start=1):
                ended = line.endswith("\n")
                line = line.split("#", 1)[0].strip(" \r\n")
                if not line.strip():
                    continue
                if delimiter == "":
                    delimiter = _delimiter(path, line, number)
                cells = line.split(delimiter)
                trailing = trailing and delimiter is not None and not cells[-1].strip()
                rows.append(_row(path, cells, number, delimiter))
                numbers.append(number)
                if rows[-1].size != rows[0].size:
                    raise FormatError(
                        f"{path.name} has {rows[-1].size} numbers in line {number} but "
                        f"{rows[0].size} in line {numbers[0]}; all rows must be of one length"
                    )
    except UnicodeDecodeError:
        raise FormatError(
            f"{path.name} is no text in UTF-8; save it as a plain text matrix, or name its format "
            "with format="
        ) from None
    except OSError as error:
        raise FormatError(f"{path.name} cannot be read ({_one_line(error)})") from None
    if not rows:
        raise FormatError(f"{path.name} holds no numbers; a matrix of heights was expected")
    matrix = np.stack(rows)
    steps: tuple[str, ...] = ()
    # Many programs end each row with the delimiter; that is no column.
    if trailing and matrix.shape[1] > 1:
        matrix = matrix[:, :-1]
        steps = ("read: the delimiter at the end of every row is no column",)
    if not ended:
        # Rows are missing without a trace where a file was cut off, and the sides are given for
        # all of them.
        steps += ("read: the last row has no line end; check that the file was not cut off",)
    if points_possible:
        _refuse_point_list(path, matrix)
    return matrix, steps


def _delimiter(path: Path, line: str, number: int) -> str | None:
    for mark in (";", "\t"):
        if mark in line:
            return mark
    words = line.split()
    if "," in line and len(words) > 1 and all(_DECIMAL_COMMA.fullmatch(word) for word in words):
        raise _comma_error(path, words[0], number)
    # None splits at any run of white space.
    return "," if "," in line else None


def _row(path: Path, cells: list[str], number: int, delimiter: str | None) -> Array:
    values = []
    for position, cell in enumerate(cells, start=1):
        try:
            value = float(cell)
        except ValueError:
            word = cell.strip()
            if not _MISSING.fullmatch(word):
                if delimiter != "," and _DECIMAL_COMMA.fullmatch(word):
                    raise _comma_error(path, word, number) from None
                raise FormatError(
                    f"{path.name} has {word[:40]!r} in line {number}, cell {position}, where a "
                    "number was expected; start lines that are no data with #"
                ) from None
            value = math.nan
        else:
            # Python's float() takes 1_0 for ten; no instrument writes that.
            if "_" in cell or math.isinf(value):
                raise FormatError(
                    f"{path.name} has {cell.strip()[:40]!r} in line {number}, cell {position}; "
                    "write finite numbers, and nan for missing points"
                )
        values.append(value)
    return np.array(values)


def _comma_error(path: Path, word: str, number: int) -> FormatError:
    return FormatError(
        f"{path.name} has the decimal comma {word!r} in line {number}; write decimal points"
    )


def _refuse_point_list(path: Path, matrix: Array) -> None:
    # Three columns of which two count through a grid would pass for a narrow map.
    if matrix.shape[1] == 3 and matrix.shape[0] >= 9:
        first, second = (np.unique(matrix[:, column]).size for column in (0, 1))
        if min(first, second) > 1 and first * second == matrix.shape[0]:
            raise FormatError(
                f"{path.name} looks like a list of points x, y, z; write the heights as a matrix "
                "with one row of the map per line"
            )


# The program's own files


def _read_netcdf(path: Path) -> Surface:
    """Return the variable ``height`` [m] over ``y`` and ``x`` [m] of a NetCDF file."""
    expected = "expected a NetCDF file with a variable 'height' [m] over (y, x)"
    try:
        with netcdf.opened(path) as dataset:
            height = dataset["height"]
            dimensions, unit = height.dims, height.attrs.get("units")
            values = np.asarray(height.values)
            attributes = dict(dataset.attrs)
            coordinates = [
                np.asarray(dataset[name].values, dtype=float)
                for name in ("y", "x")
                if name in dataset.coords
            ]
    # h5py and xarray fail on damaged files with OSError, KeyError, ValueError and more.
    except Exception as error:
        raise FormatError(f"{path.name} cannot be read ({_one_line(error)}); {expected}") from None
    if dimensions != ("y", "x") or unit != "m" or values.dtype.kind not in "fiu":
        raise FormatError(
            f"{path.name} has 'height' over {dimensions} with units {unit!r}; {expected}"
        )
    try:
        if "pixel_y" in attributes and "pixel_x" in attributes:
            pixel = float(attributes["pixel_y"]), float(attributes["pixel_x"])
        else:
            pixel = _spacing(coordinates[0]), _spacing(coordinates[1])
    except (IndexError, TypeError, ValueError):
        raise FormatError(
            f"{path.name} has neither attributes pixel_y and pixel_x [m] nor evenly spaced "
            f"coordinates y and x; {expected}"
        ) from None
    return _surface(path, values, pixel, Provenance(path.name, "roughcontact NetCDF"))


def _spacing(centres: Array) -> float:
    steps = np.diff(centres)
    mean = float(np.mean(steps))
    if not np.allclose(steps, mean, rtol=1e-6, atol=0.0):
        raise ValueError("coordinates are not evenly spaced")
    return abs(mean)
