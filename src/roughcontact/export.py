"""Maps and results in the formats of other programs: VTK, CSV, X3P, SUR, NumPy, JSON.

========= ============ ============ ==========================================================
suffix    of a surface of a result  what is kept
========= ============ ============ ==========================================================
``.nc``   yes          yes          everything; see `roughcontact.archive`
``.npz``  yes          no           heights and pixel, every bit
``.x3p``  yes          no           heights and pixel, every bit; ISO 25178-72
``.sur``  yes          no           heights to 32 bits, pixel in single precision; Digital Surf
``.csv``  yes          one map      every bit, as text
``.vti``  yes          all maps     every bit; ParaView
``.json`` no           the summary  numbers and words
========= ============ ============ ==========================================================

A missing point is a missing point in each of them, and row 0 is the row of smallest y. What is
written appears under its name only once it is complete. Figures are drawn by `roughcontact.plots`.
"""

from __future__ import annotations

import base64
import csv
import hashlib
import json
import math
import os
import struct
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import IO, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from roughcontact._version import __version__
from roughcontact.archive import replacing, save_result, surface_to_dataset
from roughcontact.errors import InputError
from roughcontact.formats import TEXT_MARK
from roughcontact.result import ContactResult
from roughcontact.surface import Surface

Array = NDArray[np.float64]
Source = TypeVar("Source", Surface, ContactResult)

# Every map of a result, with its unit.
_UNITS = {
    "height": "m",
    "counter_height": "m",
    "initial_gap": "m",
    "pressure": "Pa",
    "gap": "m",
    "contact": "1",
    "saturated": "1",
    "residual_indentation": "m",
    "ceiling": "Pa",
}

_SUMMARY_UNITS = {
    "certificate": "1",
    "load_error": "1",
    "moments": "N m",
    "moment_error": "1",
    "tilt": "rad",
    "tolerance": "1",
    "load": "N",
    "approach": "m",
    "contact_modulus": "Pa",
    "ceiling": "Pa",
    "contact_area": "m2",
    "contact_fraction": "1",
    "saturated_fraction": "1",
    "max_pressure": "Pa",
    "mean_gap": "m",
    "max_residual_indentation": "m",
    "shape": "1",
    "pixel": "m",
    "iterations": "1",
    "convolutions": "1",
    "seconds": "s",
    "young": "Pa",
    "poisson": "1",
    "yield_strength": "Pa",
    "hardness": "Pa",
}

# Bytes handled at a time; divisible by the size of every number.
_BLOCK = 2**20

# Bytes of a member of an archive from which it gets the header for more than 2 GB, which not
# every reader knows.
_LARGE = 2**30


def save_surface(surface: Surface, path: str | os.PathLike[str]) -> None:
    """Write a height map in the format that the suffix of the file names.

    Parameters
    ----------
    surface : Surface
        The map.
    path : str or path
        File to write: ``.npz``, ``.nc``, ``.x3p``, ``.sur``, ``.csv`` or ``.vti``.

    Raises
    ------
    InputError
        If the suffix is none of these, or the map does not fit into the format.
    OSError
        If the file cannot be written; an old file survives.

    See Also
    --------
    roughcontact.read_surface : Reads all of them but ``.vti``.
    """
    _writer(_SURFACE_WRITERS, path, "a surface")(surface, path)


def save(result: ContactResult, path: str | os.PathLike[str]) -> None:
    """Write a result in the format that the suffix of the file names.

    Parameters
    ----------
    result : ContactResult
        The result.
    path : str or path
        File to write: ``.nc`` (everything), ``.vti`` (all maps), ``.csv`` (the pressure) or
        ``.json`` (the summary).

    Raises
    ------
    InputError
        If the suffix is none of these.
    OSError
        If the file cannot be written; an old file survives.

    See Also
    --------
    roughcontact.load_result : Reads ``.nc`` again.
    """
    _writer(_RESULT_WRITERS, path, "a result")(result, path)


def save_netcdf(surface: Surface, path: str | os.PathLike[str]) -> None:
    """Write a height map to a NetCDF file: heights, pixel and provenance.

    Parameters
    ----------
    surface : Surface
        The map.
    path : str or path
        File to write; it must end in ``.nc``.

    Raises
    ------
    InputError
        If the suffix is another.
    OSError
        If the file cannot be written; an old file survives.
    """
    _require_suffix(path, ".nc")
    with replacing(path) as temporary:
        surface_to_dataset(surface).to_netcdf(temporary, engine="h5netcdf")


def save_npz(surface: Surface, path: str | os.PathLike[str]) -> None:
    """Write a height map to a NumPy archive.

    Parameters
    ----------
    surface : Surface
        The map.
    path : str or path
        File to write; it must end in ``.npz``. It holds the arrays ``heights`` [y, x] and
        ``pixel`` (dy, dx), and in ``unit`` the unit of both: an archive with these three needs no
        unit and size when it is read.

    Raises
    ------
    InputError
        If the suffix is another.
    OSError
        If the file cannot be written; an old file survives.
    """
    _require_suffix(path, ".npz")
    with replacing(path) as temporary, temporary.open("wb") as stream:
        np.savez(stream, heights=surface.heights, pixel=np.array(surface.pixel), unit=np.array("m"))


def save_csv(
    source: Surface | ContactResult, path: str | os.PathLike[str], field: str | None = None
) -> None:
    """Write one map as a matrix of numbers, one row of the map a line.

    Parameters
    ----------
    source : Surface or ContactResult
        Where the map is taken from.
    path : str or path
        File to write; it must end in ``.csv``.
    field : str, optional
        Which map: ``"height"``, ``"counter_height"``, ``"initial_gap"``, ``"pressure"``,
        ``"gap"``, ``"contact"``, ``"saturated"``, ``"residual_indentation"``, ``"ceiling"``, as
        far as the source has them. By default the heights of a surface, the pressure of a result.

    Raises
    ------
    InputError
        If the suffix is another, or the source has no such map.
    OSError
        If the file cannot be written; an old file survives.

    Notes
    -----
    Lines that start with # head the file and name quantity, unit and pixel; `read_surface` takes
    unit and size of a file of heights from them. Every number keeps its bits; "nan" is a missing
    point, and masks are 0 and 1.
    """
    _require_suffix(path, ".csv")
    if field is None:
        field = "height" if isinstance(source, Surface) else "pressure"
    known = _names(source)
    if field not in known:
        raise InputError(f"field must be one of {', '.join(known)}, got {field!r}")
    (dy, dx), values = _surface_of(source).pixel, _values(source, field)
    if values.dtype == np.bool_:
        values = values.astype(np.uint8)
    with (
        replacing(path) as temporary,
        temporary.open("w", encoding="utf-8", newline="\n") as stream,
    ):
        stream.write(
            f"{TEXT_MARK}\n"
            f"# quantity: {field}\n"
            f"# unit: {_UNITS[field]}\n"
            f"# pixel_y: {dy!r} m\n"
            f"# pixel_x: {dx!r} m\n"
            f"# {values.shape[0]} rows along y from the smallest y on, {values.shape[1]} columns "
            "along x; nan where missing\n"
        )
        for row in values:
            stream.write(",".join(map(repr, row.tolist())))
            stream.write("\n")


def save_table(result: ContactResult, path: str | os.PathLike[str]) -> None:
    """Write the summary of a result as a table of name, value and unit.

    Parameters
    ----------
    result : ContactResult
        The result.
    path : str or path
        File to write; it must end in ``.csv``. One line a number or word; several values of one
        name are separated by semicolons, pairs in the order (y, x). Units are SI.

    Raises
    ------
    InputError
        If the suffix is another.
    OSError
        If the file cannot be written; an old file survives.
    """
    _require_suffix(path, ".csv")
    rows = [
        (f"{name}_{part}" if part else name, entry)
        for name, value in record(result).items()
        for part, entry in (value.items() if isinstance(value, dict) else [("", value)])
    ]
    with (
        replacing(path) as temporary,
        temporary.open("w", encoding="utf-8", errors="backslashreplace", newline="") as stream,
    ):
        table = csv.writer(stream, lineterminator="\n")
        table.writerow(("name", "value", "unit"))
        for name, value in rows:
            quantity = name.removeprefix("counter_").removeprefix("material_")
            unit = _SUMMARY_UNITS.get(quantity, "")
            table.writerow((name, _cell(value), "" if isinstance(value, str) else unit))


def save_json(result: ContactResult, path: str | os.PathLike[str]) -> None:
    """Write the summary of a result, as `record` gives it, as JSON in SI units.

    Parameters
    ----------
    result : ContactResult
        The result.
    path : str or path
        File to write; it must end in ``.json``. Numbers that are not finite are ``null``.

    Raises
    ------
    InputError
        If the suffix is another.
    OSError
        If the file cannot be written; an old file survives.
    """
    _require_suffix(path, ".json")
    with replacing(path) as temporary:
        temporary.write_text(to_json(record(result)) + "\n", encoding="utf-8")


def record(result: ContactResult) -> dict[str, Any]:
    """Return the summary of a result with the bodies that went in.

    Parameters
    ----------
    result : ContactResult
        The result.

    Returns
    -------
    dict
        `ContactResult.summary` and ``converged``, ``precision``, ``material``,
        ``counter_material``, ``counter_source``, ``counter_preparation``; SI units.
    """
    bodies = {"material": result.material, "counter_material": result.counter_material}
    other = result.counter_surface
    return {
        **result.summary(),
        "converged": result.converged,
        "precision": result.precision,
        **{
            name: {
                "rigid": math.isinf(body.young),
                "young": body.young,
                "poisson": body.poisson,
                "yield_strength": body.yield_strength,
                "hardness": body.hardness,
            }
            for name, body in bodies.items()
        },
        "counter_source": None if other is None else other.provenance.source,
        "counter_preparation": None if other is None else list(other.provenance.steps),
    }


def to_json(values: Mapping[str, Any]) -> str:
    """Return JSON text.

    Parameters
    ----------
    values : mapping
        Numbers, words, lists and dictionaries of them.

    Returns
    -------
    str
        Text that every reader of JSON takes: what is not finite, of which JSON knows nothing,
        is ``null``.

    Examples
    --------
    >>> print(to_json({"young": float("inf"), "poisson": 0.5}))
    {
      "young": null,
      "poisson": 0.5
    }
    """
    return json.dumps(_finite(values), indent=2, allow_nan=False)


def save_vtk(source: Surface | ContactResult, path: str | os.PathLike[str]) -> None:
    """Write all maps to one VTK image, which ParaView opens.

    Parameters
    ----------
    source : Surface or ContactResult
        The heights of a surface; of a result ``height``, ``initial_gap``, ``pressure``, ``gap``,
        ``contact``, ``saturated``, ``residual_indentation``, and ``counter_height`` and
        ``ceiling`` where they are maps. NaN where missing.
    path : str or path
        File to write; it must end in ``.vti``.

    Raises
    ------
    InputError
        If the suffix is another.
    OSError
        If the file cannot be written; an old file survives.

    Notes
    -----
    A pixel is an area, yet its values are stored at its centre, as data of the points of the
    image, not of its cells: *Warp By Scalar*, which turns the flat image into a relief, takes
    nothing else. Choose ``height`` in it and a scale factor to exaggerate the heights, and colour
    by ``pressure``. The image therefore ends half a pixel before the edge of the map on each side.
    *Threshold* over the whole range of ``height`` cuts the missing points out of the relief.

    All lengths are in metres; the field data ``units`` says the unit of each map. The layout is
    VTK's XML ImageData with appended data, base64, zlib, little-endian, headers of 64 bits.

    References
    ----------
    Kitware, VTK File Formats, "XML File Formats", https://docs.vtk.org/en/latest/vtk_file_formats/
    """
    _require_suffix(path, ".vti")
    surface = _surface_of(source)
    (ny, nx), (dy, dx) = surface.shape, surface.pixel
    names = _names(source)
    extent = f"0 {nx - 1} 0 {ny - 1} 0 0"
    units = b"".join(f"{name}: {_UNITS[name]}\0".encode("ascii") for name in names)

    def head(offsets: list[int]) -> bytes:
        arrays = "".join(
            f'        <DataArray type="{_vtk_type(name)}" Name="{name}" format="appended" '
            # Of one length whatever the number is: the head is written again at the end.
            f'offset="{offset:020d}"/>\n'
            for name, offset in zip(names, offsets, strict=True)
        )
        text = (
            '<?xml version="1.0"?>\n'
            '<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian" '
            'header_type="UInt64" compressor="vtkZLibDataCompressor">\n'
            f'  <ImageData WholeExtent="{extent}" Origin="{dx / 2!r} {dy / 2!r} 0" '
            f'Spacing="{dx!r} {dy!r} 1">\n'
            "    <FieldData>\n"
            f'      <Array type="String" Name="units" NumberOfTuples="{len(names)}" '
            f'format="ascii">{" ".join(map(str, units))}</Array>\n'
            "    </FieldData>\n"
            f'    <Piece Extent="{extent}">\n'
            f'      <PointData Scalars="{"pressure" if "pressure" in names else "height"}">\n'
            f"{arrays}"
            "      </PointData>\n"
            "    </Piece>\n"
            "  </ImageData>\n"
            '  <AppendedData encoding="base64">\n'
            "_"
        )
        return text.encode("ascii")

    with replacing(path) as temporary, temporary.open("wb") as stream:
        start = stream.write(head([0] * len(names)))
        offsets = []
        for name in names:
            offsets.append(stream.tell() - start)
            _append(stream, _values(source, name))
        stream.write(b"\n  </AppendedData>\n</VTKFile>\n")
        stream.seek(0)
        stream.write(head(offsets))


def save_x3p(surface: Surface, path: str | os.PathLike[str]) -> None:
    """Write a height map as X3P, the exchange format of ISO 25178-72 (ISO 5436-2).

    Parameters
    ----------
    surface : Surface
        The map.
    path : str or path
        File to write; it must end in ``.x3p``. Heights in metres with all their bits, NaN where
        missing, as the standard has it for data in floating point; source and preparation are in
        the comment. The dates that the standard asks for are those of the writing.

    Raises
    ------
    InputError
        If the suffix is another.
    OSError
        If the file cannot be written; an old file survives.

    References
    ----------
    ISO 25178-72:2017, Geometrical product specifications (GPS), Surface texture: Areal, Part 72:
    XML file format x3p
    """
    _require_suffix(path, ".x3p")
    heights = _bytes(surface.heights)
    document = _x3p_document(surface, _md5(heights)).encode("utf-8")
    members: dict[str, bytes | memoryview] = {
        "main.xml": document,
        "bindata/data.bin": heights,
        "md5checksum.hex": f"{_md5(document)} *main.xml\n".encode("ascii"),
    }
    with (
        replacing(path) as temporary,
        zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
    ):
        for name, content in members.items():
            with archive.open(name, "w", force_zip64=len(content) > _LARGE) as member:
                for block in _blocks(content):
                    member.write(block)


def save_sur(surface: Surface, path: str | os.PathLike[str]) -> None:
    """Write a height map as SUR, the format of Digital Surf's programs.

    Parameters
    ----------
    surface : Surface
        The map.
    path : str or path
        File to write; it must end in ``.sur``.

    Raises
    ------
    InputError
        If the suffix is another, or the map has more points or other scales than the header can
        tell.
    OSError
        If the file cannot be written; an old file survives.

    Notes
    -----
    The format holds integers of 32 bits and their step, hence heights to within half a step of
    max|z| / (2³¹ - 2), and the pixel in single precision, hence to 6 × 10⁻⁸ of itself. X3P and
    NPZ keep every bit. Heights are integer × step; the header's offset is zero, since some readers
    add it, others leave it out, and one counts from the lowest point instead.

    References
    ----------
    Surf file format of Digital Surf, as D. Nečas and P. Klapetek describe it in Gwyddion's
    ``surffile.c``
    """
    _require_suffix(path, ".sur")
    (ny, nx), heights = surface.shape, surface.heights
    if surface.heights.size >= 2**31:
        raise InputError(
            f"{path} can hold fewer than 2³¹ points, got {ny} × {nx}; write .x3p or .npz"
        )
    # Missing points are the least height less 2, which has to be an integer of 32 bits as well.
    limit = 2**31 - 2
    low, high = float(np.nanmin(heights)), float(np.nanmax(heights))
    largest = 1e3 * max(abs(low), abs(high))
    with np.errstate(over="ignore"):
        single = np.float32(max(largest / limit, float(np.finfo(np.float32).tiny)))
        if float(single) * limit < largest:
            single = np.nextafter(single, np.float32(np.inf))
        edges = [float(np.float32(1e3 * edge)) for edge in surface.pixel]
    step = float(single)
    if not all(0 < value < math.inf for value in (step, *edges)):
        raise InputError(
            f"{path} keeps pixel and step of the heights in single precision, got pixel "
            f"{surface.pixel} m and heights up to {largest / 1e3:g} m; write .x3p or .npz"
        )
    lowest, highest = (round(1e3 * extreme / step) for extreme in (low, high))
    missing = lowest - 2
    with replacing(path) as temporary, temporary.open("wb") as stream:
        stream.write(_sur_header(surface, (lowest, highest), (edges[0], edges[1]), step))
        rows = max(1, _BLOCK // (8 * nx))
        for first in range(0, ny, rows):
            block = np.rint(1e3 * heights[first : first + rows] / step)
            stream.write(np.where(np.isnan(block), missing, block).astype("<i4").tobytes())


_SURFACE_WRITERS: dict[str, Callable[[Surface, str | os.PathLike[str]], None]] = {
    ".nc": save_netcdf,
    ".npz": save_npz,
    ".x3p": save_x3p,
    ".sur": save_sur,
    ".csv": save_csv,
    ".vti": save_vtk,
}
_RESULT_WRITERS: dict[str, Callable[[ContactResult, str | os.PathLike[str]], None]] = {
    ".nc": save_result,
    ".vti": save_vtk,
    ".csv": save_csv,
    ".json": save_json,
}

SURFACE_SUFFIXES = tuple(_SURFACE_WRITERS)
"""Suffixes that `save_surface` knows."""

RESULT_SUFFIXES = tuple(_RESULT_WRITERS)
"""Suffixes that `save` knows."""


def _writer(
    writers: Mapping[str, Callable[[Source, str | os.PathLike[str]], None]],
    path: str | os.PathLike[str],
    what: str,
) -> Callable[[Source, str | os.PathLike[str]], None]:
    suffix = Path(path).suffix.lower()
    if suffix not in writers:
        raise InputError(
            f"path must end in one of {', '.join(writers)} for {what}, got {str(path)!r}; figures "
            "are written by roughcontact.plots"
        )
    return writers[suffix]


def _require_suffix(path: str | os.PathLike[str], suffix: str) -> None:
    if Path(path).suffix.lower() != suffix:
        raise InputError(f"path must end in {suffix}, got {str(path)!r}")


# Maps and numbers


def _surface_of(source: Surface | ContactResult) -> Surface:
    return source if isinstance(source, Surface) else source.surface


def _names(source: Surface | ContactResult) -> list[str]:
    if isinstance(source, Surface):
        return ["height"]
    absent = set()
    if source.counter_surface is None:
        absent.add("counter_height")
    if not isinstance(source.ceiling, np.ndarray):
        absent.add("ceiling")
    return [name for name in _UNITS if name not in absent]


def _values(source: Surface | ContactResult, name: str) -> NDArray[Any]:
    if isinstance(source, Surface):
        return source.heights
    if name == "height":
        return source.surface.heights
    if name == "counter_height" and source.counter_surface is not None:
        return source.counter_surface.heights
    values: NDArray[Any] = getattr(source, name)
    return values


def _finite(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _finite(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _cell(value: Any) -> str:
    if isinstance(value, list):
        return "; ".join(map(_cell, value))
    return "" if value is None else str(value)


# Bytes


def _bytes(values: NDArray[Any]) -> memoryview:
    """Return the little-endian bytes of a map; nothing is copied on most machines."""
    little = np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("<"))
    return little.reshape(-1).view(np.uint8).data


def _blocks(content: bytes | memoryview) -> Iterator[memoryview]:
    view = memoryview(content)
    for start in range(0, len(view), _BLOCK):
        yield view[start : start + _BLOCK]


def _md5(content: bytes | memoryview) -> str:
    # A checksum that the standard asks for, no protection.
    return hashlib.md5(content, usedforsecurity=False).hexdigest()


def _vtk_type(name: str) -> str:
    return "UInt8" if name in ("contact", "saturated") else "Float64"


def _append(stream: IO[bytes], values: NDArray[Any]) -> None:
    """Write one array of appended data: its table of blocks, then the blocks, in base64."""
    content = _bytes(values)
    blocks = [zlib.compress(block, 1) for block in _blocks(content)]
    table = (len(blocks), _BLOCK, len(content) % _BLOCK, *map(len, blocks))
    stream.write(base64.b64encode(struct.pack(f"<{len(table)}Q", *table)))
    # Encoded as one stream: three bytes become four letters, and only the end is filled up.
    rest = b""
    for block in blocks:
        joined = rest + block
        whole = len(joined) // 3 * 3
        stream.write(base64.b64encode(joined[:whole]))
        rest = joined[whole:]
    stream.write(base64.b64encode(rest))


# Headers


def _x3p_document(surface: Surface, checksum: str) -> str:
    (ny, nx), (dy, dx), about = surface.shape, surface.pixel, surface.provenance
    now = datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    comment = "\n".join(_xml(line) for line in (about.source, about.channel, *about.steps) if line)
    return f"""<?xml version="1.0" encoding="UTF-8" standalone="no"?>
<p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2"\
 xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"\
 xsi:schemaLocation="http://www.opengps.eu/2008/ISO5436_2\
 http://www.opengps.eu/2008/ISO5436_2/ISO5436_2.xsd">
  <Record1>
    <Revision>ISO5436 - 2000</Revision>
    <FeatureType>SUR</FeatureType>
    <Axes>
      <CX>
        <AxisType>I</AxisType>
        <DataType>L</DataType>
        <Increment>{dx!r}</Increment>
        <Offset>0</Offset>
      </CX>
      <CY>
        <AxisType>I</AxisType>
        <DataType>L</DataType>
        <Increment>{dy!r}</Increment>
        <Offset>0</Offset>
      </CY>
      <CZ>
        <AxisType>A</AxisType>
        <DataType>D</DataType>
        <Increment>1</Increment>
        <Offset>0</Offset>
      </CZ>
    </Axes>
  </Record1>
  <Record2>
    <Date>{now}</Date>
    <Instrument>
      <Manufacturer>unknown</Manufacturer>
      <Model>{_xml(about.instrument) or "unknown"}</Model>
      <Serial>unknown</Serial>
      <Version>roughcontact {__version__}</Version>
    </Instrument>
    <CalibrationDate>{now}</CalibrationDate>
    <ProbingSystem>
      <Type>Software</Type>
      <Identification>unknown</Identification>
    </ProbingSystem>
    <Comment>{comment}</Comment>
  </Record2>
  <Record3>
    <MatrixDimension>
      <SizeX>{nx}</SizeX>
      <SizeY>{ny}</SizeY>
      <SizeZ>1</SizeZ>
    </MatrixDimension>
    <DataLink>
      <PointDataLink>bindata/data.bin</PointDataLink>
      <MD5ChecksumPointData>{checksum.upper()}</MD5ChecksumPointData>
    </DataLink>
  </Record3>
  <Record4>
    <ChecksumFile>md5checksum.hex</ChecksumFile>
  </Record4>
</p:ISO5436_2>
"""


def _xml(text: str) -> str:
    # Imported late: it brings the network with it.
    from xml.sax.saxutils import escape

    return escape(_printable(text))


def _printable(text: str) -> str:
    # XML has no way to write most control characters, and UTF-8 none to write lone surrogates.
    return "".join(c if c.isprintable() else " " for c in text)


def _sur_header(
    surface: Surface, extremes: tuple[int, int], pixel: tuple[float, float], step: float
) -> bytes:
    """Return the 512 bytes ahead of the heights; pixel and step in mm."""
    ny, nx = surface.shape
    source = _printable(surface.provenance.source).encode("latin-1", "replace")[:30]
    return struct.pack(
        "<12s4H30s30s5H8xH5i3f" + 9 * "16s" + "3f3H12x7Hf10x2H128s3f34x",
        b"DIGITAL SURF",
        # PC format, one object, version, surface.
        0, 1, 1, 2,
        # The object and who measured it. Words are filled up with blanks.
        source.ljust(30), b" " * 30,
        # Material, acquisition and range unknown; missing points or none; absolute heights.
        0, 0, 0, int(surface.missing > 0), 1,
        32, *extremes, nx, ny, nx * ny,
        pixel[1], pixel[0], step,
        *(name.ljust(16) for name in (b"X", b"Y", b"Z", *6 * (b"mm",))),
        1.0, 1.0, 1.0,
        # Neither imprint nor inverted nor levelled; date and duration unknown; no comment, no
        # offsets.
        0, 0, 0,
        0, 0, 0, 0, 0, 0, 0, 0.0,
        0, 0, b" " * 128, 0.0, 0.0, 0.0,
    )  # fmt: skip
