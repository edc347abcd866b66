"""Reading of measured height maps and of saved results."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from roughcontact.errors import ArgumentRef, FormatError, InputError, input_error
from roughcontact.formats import (
    containers,
    content,
    images,
    instruments,
    matrices,
    meshes,
    netcdf,
    spreadsheets,
    text_files,
)
from roughcontact.formats.no_data import NONE, describe_codes, mark_missing
from roughcontact.formats.source import (
    Channel,
    InputFormat,
    ReadOptions,
    check_scale,
    open_existing,
)
from roughcontact.surface.provenance import Operation
from roughcontact.surface.surface import Surface
from roughcontact.units import Quantities


def _read_container(path: Path, name: str, requested: ReadOptions) -> Surface:
    return containers.read_container(path, requested, _format_of)


def _container_channels(path: Path, name: str) -> tuple[Channel, ...]:
    return containers.channels(path, _format_of)


FORMATS: tuple[InputFormat, ...] = (
    InputFormat("netcdf", (".nc",), netcdf.read_netcdf, netcdf.channels),
    InputFormat("npy", (".npy",), matrices.read_arrays, matrices.array_channels, has_codes=True),
    InputFormat("npz", (".npz",), matrices.read_arrays, matrices.array_channels, has_codes=True),
    InputFormat(
        "xlsx", (".xlsx",), spreadsheets.read_workbook, spreadsheets.channels, has_codes=True
    ),
    InputFormat(
        containers.NAME, (".zip", ".cag"), _read_container, _container_channels, has_codes=True
    ),
    InputFormat(
        "hdf5", (".h5", ".hdf5"), matrices.read_hdf5, matrices.hdf5_channels, has_codes=True
    ),
    InputFormat(
        "text",
        (".csv", ".txt", ".asc", ".xyz", ".hfm"),
        matrices.read_text,
        matrices.text_channels,
        has_codes=True,
    ),
    InputFormat("gsf", (".gsf",), images.read_image, images.channels),
    InputFormat("tiff", (".tif", ".tiff"), images.read_image, images.channels, has_codes=True),
    InputFormat("jpk-hdf5", (".h5-jpk",), images.read_image, images.channels),
    *(
        InputFormat(name, (f".{name}",), meshes.read_mesh, meshes.channels, has_codes=True)
        for name in ("stl", "ply", "obj")
    ),
    InputFormat("smd", (".smd", ".sig"), text_files.read_profile, text_files.profile_channels),
    *(
        InputFormat(name, suffixes, instruments.read_instrument, instruments.channels)
        for name, suffixes in instruments.SUFFIXES.items()
    ),
)
"""All input formats of maps."""

SUFFIXES = {suffix: known.name for known in FORMATS for suffix in known.suffixes}
"""Suffix of a file -> name of the format; a suffix of three digits is also Bruker's ``di``."""

_PIPED, _PACKED = ".txt", ".gz"
# Bruker's format, which numbers the scans.
_NUMBERED, _THREE_DIGITS = "di", re.compile(r"\.\d{3}")


def read_surface(
    path: str | os.PathLike[str],
    format: str | None = None,  # noqa: A002 - the word a user looks for
    channel: str | int | None = None,
    unit: str | None = None,
    size: Quantities | str | None = None,
    override_size: bool = False,
    no_data: float | str | None = None,
) -> Surface:
    """Read a height map from a file.

    Parameters
    ----------
    path : str or path
        Instrument file, matrix of numbers (``.npy``, ``.npz``, ``.h5``, ``.xlsx``, ``.csv``,
        ``.txt``, ``.asc``), points x, y, z on a grid (``.xyz``), NetCDF file of this program or of
        SurfaceTopography, container of contact.engineering (``.zip``); optionally compressed by
        gzip.
    format : str, optional
        Name of the format or one of its suffixes, see `SUFFIXES`; by default given by the suffix of
        the file, unless its content shows another format.
    channel : str or int, optional
        Name or index of the height channel, or of a measurement of a container; by default the
        default channel of the file, or its first height channel.
    unit : str, optional
        Unit of the heights, such as ``"um"``, for files without one. It replaces the unit in a text
        of another program, and is rejected for other files with a unit. Sides or coordinates
        without a unit are in this unit, too. Two columns of a profile need two, positions first,
        ``"mm, um"``, unless the file gives the unit of the positions.
    size : (float, float) or str, optional
        Lengths of the sides ``(y, x)`` [m], or with their units, ``"0.1 mm x 0.2 mm"``;
        one length for a square map. For files without a size, or with ``override_size``.
    override_size : bool
        Whether ``size`` replaces a wrong size in the file; the provenance lists both.
    no_data : float, {"auto", "none"}, optional
        Value of missing points, as the number is in the file; ``"auto"`` for all known codes that
        are in it, ``"none"`` if all its values are heights. By default a known code raises.

    Returns
    -------
    Surface
        Heights [m] and pixel ``(dy, dx)`` [m], NaN where the file marks a point as missing. The
        first index is y, in the order of the reader.

    Raises
    ------
    FormatError
        If the file is missing, empty, damaged, of another type, or contains no height map.
    InputError
        If unit, size or channel are missing, or contradict the file; if a known code for missing
        points occurs several times, far from all other heights.

    Notes
    -----
    Known codes are ±999 and longer rows of nines, the limits of integers of 16 and 32 bits and
    their decimal fractions (-32.768), ±1e10 and larger powers of ten, all values beyond ±1e30
    (1.70141e38, 3.4e38), and 0 where all else is far from it.

    A text matrix gives its unit and pixel itself if it starts with the lines ``# roughcontact
    map``, ``# quantity: height``, ``# unit: um``, ``# pixel_y: 2 um`` and ``# pixel_x: 1 um``; a
    NumPy archive if it holds arrays ``heights``, ``pixel`` (dy, dx) and ``unit``, the unit of
    both.

    Scales that no measured map has are rejected: sides outside 1 nm to 10 m, pixel edges outside 1
    pm to 10 mm, heights that span more than 100 times the longer side, or are further than 10 m
    from zero, where the digits of roughness are lost.

    Instrument files whose header contradicts the rest of the file are rejected as well, if the
    format is redundant: sizes and grids (metropro, sur, sdf, di), the range of heights (sur, mnt),
    checksums (x3p); and files without a scale that the reader would set to 1 (opd).
    """
    with _open_with_format(path, format) as (file, known):
        return _read_map(
            file, known, format, ReadOptions(channel, unit, size, override_size, no_data)
        )


def read_announced(
    path: str | os.PathLike[str],
    announced: Callable[[tuple[int, int]], None],
    format: str | None = None,  # noqa: A002 - the word a user looks for
    *options: Any,
) -> Surface:
    """Read a surface like `read_surface`; its size may be rejected before its heights."""
    with _open_with_format(path, format) as (file, known):
        requested = replace(ReadOptions(*options), announced=announced)
        return _read_map(file, known, format, requested)


def read_with_channels(
    path: str | os.PathLike[str],
    format: str | None = None,  # noqa: A002 - the word a user looks for
    **options: Any,
) -> tuple[Surface, tuple[Channel, ...]]:
    """Read a surface and list its channels, also from a pipe, which can be read only once."""
    with _open_with_format(path, format) as (file, known):
        surface = _read_map(file, known, format, ReadOptions(**options))
        return surface, known.channels(file, known.name)


def channels(
    path: str | os.PathLike[str],
    format: str | None = None,  # noqa: A002 - the word a user looks for
) -> tuple[Channel, ...]:
    """Return the channels of a file in their order."""
    with _open_with_format(path, format) as (file, known):
        return known.channels(file, known.name)


@contextmanager
def _open_with_format(
    path: str | os.PathLike[str], wanted: str | None
) -> Iterator[tuple[Path, InputFormat]]:
    """Yield a file that can be opened again, and its format."""
    with open_existing(path) as file:
        yield file, _format_of(file, wanted, piped=file != Path(path))


def _read_map(
    file: Path, known: InputFormat, wanted: str | None, requested: ReadOptions
) -> Surface:
    """Return the map in a file, with the reading in its provenance."""
    if requested.override_size and requested.size is None:
        raise InputError(f"needs a {ArgumentRef('size')}", argument="override_size")
    surface = known.read(file, known.name, requested)
    about = surface.provenance
    read = {} if about.origin is None else dict(about.origin.found)
    has_codes = known.has_codes and not read.pop("marks_missing", False)
    heights, marked = mark_missing(
        file.name,
        surface.heights,
        read.get("unit", 1.0),
        NONE if requested.no_data is None and not has_codes else requested.no_data,
    )
    if marked:
        surface = replace(surface, heights=heights)
    # Those of a profile were marked before it was interpolated.
    marked = {**marked, **dict(read.pop("no_data", ()))}
    check_scale(file, surface)
    specified: dict[str, object] = {
        "path": file.name,
        "format": wanted,
        "channel": requested.channel,
        "unit": requested.unit,
        "size": requested.size,
    }
    if requested.override_size:
        specified["override_size"] = True
    if requested.no_data is not None:
        specified["no_data"] = requested.no_data
    notes = replace(about, origin=None).steps + describe_codes(marked)
    size = surface.size[surface.is_profile :]
    result = {"format": known.name, "size": size, "notes": notes, **read}
    if any(marked.values()):
        result["no_data"] = list(marked.items())
    origin = Operation("read_surface", specified, result)
    return replace(surface, provenance=replace(about, origin=origin, operations=()))


def _format_of(path: Path, wanted: str | None = None, piped: bool = False) -> InputFormat:
    if wanted is not None:
        name = wanted.lower().removeprefix(".")
        for known in FORMATS:
            if name == known.name or f".{name}" in known.suffixes:
                return known
        names = ", ".join(sorted(known.name for known in FORMATS))
        raise input_error("format", wanted, f"must be one of {names}")
    # The name of a process substitution such as <(zcat map.csv.gz) is a number.
    suffix = _suffix(path) or (_PIPED if piped else "")
    hinted = _NUMBERED if _THREE_DIGITS.fullmatch(suffix) else SUFFIXES.get(suffix)
    found = content.format_of(path, hinted)
    for known in FORMATS:
        if known.name == found:
            return known
    if suffix in content.UNREAD:
        raise FormatError(f"{path.name} is {content.UNREAD[suffix]}")
    suffixes = ", ".join(sorted(SUFFIXES))
    raise FormatError(
        f"{path.name} is {content.describe_content(path)}, and has the unknown suffix {suffix!r}; "
        f"give {ArgumentRef('format')} or one of the known suffixes {suffixes}, .000 to .999"
    )


def _suffix(path: Path) -> str:
    """Return the suffix of a file; of a gzip file the suffix before ``.gz``."""
    suffix = path.suffix.lower()
    return Path(path.stem).suffix.lower() if suffix == _PACKED else suffix
