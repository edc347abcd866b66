"""Height maps in formats of metrology: X3P of ISO 25178-72, SUR of Digital Surf.

`save_x3p`: ISO 25178-72:2017, Geometrical product specifications (GPS), Surface texture: Areal,
Part 72: XML file format x3p

`save_sur`: The format stores integers of 32 bits and their step, hence heights to within half a
step of max|z| / (2³¹ - 2), and the pixel in single precision, with a relative error of 6 × 10⁻⁸.
X3P and NPZ are exact. Heights are integer × step; the header's offset is zero, since some readers
add it, others ignore it, and one measures from the lowest point instead.

Surf file format of Digital Surf, as described by D. Nečas and P. Klapetek in Gwyddion's
``surffile.c``
"""

from __future__ import annotations

import hashlib
import io
import math
import os
import re
import struct
import zipfile
import zlib
from collections.abc import Sequence
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import numpy as np

from roughcontact._tools.arrays import Pixel
from roughcontact._tools.files import atomic_write, require_suffix
from roughcontact._tools.text import replace_unprintable
from roughcontact._version import __version__
from roughcontact.errors import FormatError, InputError
from roughcontact.formats.source import BLOCK, is_length, iter_blocks, little_endian
from roughcontact.surface.surface import Surface
from roughcontact.units import format_engineering, format_lengths

# Size of a member from which its header is of the format for more than 2 GB, which some readers do
# not support.
_MIN_ZIP64_BYTES = 2**30

# Checksum required by the standard, not for security.
_md5 = partial(hashlib.md5, usedforsecurity=False)

# Members of an X3P archive.
_DOCUMENT, _POINTS, _SUMS = "main.xml", "bindata/data.bin", "md5checksum.hex"
# Axis of absolute coordinates, increment of heights in floating point, which openGPS ignores, and
# elements that the reader of X3P expects.
_ABSOLUTE = rb"<C[XY]>(?:(?!</C[XY]>).)*<AxisType>\s*A\s*<"
_SCALED = rb"<CZ>(?:(?!</CZ>).)*<DataType>\s*[FD]\s*<(?:(?!</CZ>).)*<Increment>\s*([^<\s]+)\s*<"
_EXPECTED = {
    rb"<Revision>[^<]*<": b"<Revision>ISO5436 - 2000<",
    rb"<FeatureType>\s*PRF\s*<": b"<FeatureType>SUR<",
    # Without a value.
    rb"<(?:Increment|Offset)\s*/>|<Date>\s*[^\d\s<][^<]*</Date>": b"",
}
_LINK = b"<DataLink><PointDataLink>%s</PointDataLink></DataLink>" % _POINTS.encode()


def save_x3p(surface: Surface, path: str | os.PathLike[str]) -> None:
    """Write a height map as X3P, the exchange format of ISO 25178-72 (ISO 5436-2)."""
    require_suffix(path, ".x3p")
    heights = little_endian(surface.heights)
    document = _x3p_document(surface, _md5(heights).hexdigest()).encode("utf-8")
    members: dict[str, bytes | memoryview] = {
        _DOCUMENT: document,
        _POINTS: heights,
        _SUMS: f"{_md5(document).hexdigest()} *{_DOCUMENT}\n".encode("ascii"),
    }
    with (
        atomic_write(path) as stream,
        zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
    ):
        for name, content in members.items():
            with archive.open(name, "w", force_zip64=len(content) > _MIN_ZIP64_BYTES) as member:
                for block in iter_blocks(content):
                    member.write(block)


def check_x3p(path: Path) -> None:
    """Raise `FormatError` for an X3P file whose members do not match their MD5 checksums."""
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
        root = _x3p_root(names)
        stated = archive.read(root + _SUMS).splitlines() if root + _SUMS in names else []
        # "<sum> *<name>", as written by md5sum.
        sums = [(line[:32], line[32:].strip(b" *")) for line in stated]
        document = archive.read(root + _DOCUMENT) if root + _DOCUMENT in names else b""
        for what in (b"PointData", b"ValidPoints"):
            result = [
                re.search(rb"<%s>\s*([^<\s]+)\s*<" % tag, document)
                for tag in (b"MD5Checksum" + what, what + b"Link")
            ]
            sums += [(item[1], two[1]) for item, two in [result] if item and two]
        for stated_sum, member in sums:
            name = root + member.decode("utf-8", "replace")
            if not (member and name in names):
                continue
            with archive.open(name) as stream:
                found = hashlib.file_digest(stream, _md5).hexdigest()  # type: ignore[arg-type]
            if found.encode() != stated_sum.lower():
                raise FormatError(
                    f"{path.name} was damaged or changed after it was written: {name!r} does not "
                    "match its MD5 checksum; take a copy of the file, or export it again"
                )
        name, text = _x3p_points(document)
        name = root + name
        if name in names and (found_there := archive.getinfo(name).file_size) != text:
            raise FormatError(
                f"{path.name} holds {found_there} bytes of points in {name!r}, but its document "
                f"states {text}; take a copy of the file, or export it again"
            )


def _x3p_root(names: Sequence[str]) -> str:
    """Return the folder of the document in an X3P archive, which belongs into its root."""
    documents = [name for name in names if f"/{name}".endswith(f"/{_DOCUMENT}")]
    return min(documents, key=len, default="").removesuffix(_DOCUMENT)


def open_x3p(path: Path) -> io.BytesIO | None:
    """Return a rewritten X3P file if its reader does not accept the original.

    The reader expects the document in the root of the archive, one spelling of the revision, a
    surface and points in binary form. A profile is a surface of one row.
    """
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
        root = _x3p_root(names)
        original = document = archive.read(root + _DOCUMENT) if root + _DOCUMENT in names else b""
        if re.search(rb">\s*PCL\s*<", document) or re.search(_ABSOLUTE, document, re.DOTALL):
            raise FormatError(
                f"{path.name} holds points with an x and y each, no map; export it as a surface, "
                "FeatureType SUR, or as text x y z"
            )
        scaled = re.search(_SCALED, document, re.DOTALL)
        if scaled is not None and float(scaled[1]) != 1:
            raise FormatError(
                f"{path.name} states an increment of {float(scaled[1]):g} for heights in floating "
                "point, which programs apply or ignore; export it with 1"
            )
        for pattern, stated in _EXPECTED.items():
            document = re.sub(pattern, stated, document)
        points = b""
        parts = re.split(rb"<DataList>(.*)</DataList>", document, maxsplit=1, flags=re.DOTALL)
        if len(parts) == 3:
            cells = re.findall(rb"<Datum\s*(?:/|>([^<]*))", parts[1])
            points = np.array([float(cell or "nan") for cell in cells], "<f8").tobytes()
            head = re.sub(rb"(<CZ>.*<DataType>)\s*\w", rb"\1D", parts[0], flags=re.DOTALL)
            document = head + _LINK + parts[2]
        if not root and document == original:
            return None
        packed = io.BytesIO()
        with zipfile.ZipFile(packed, "w") as rewritten:
            rewritten.writestr(_DOCUMENT, document)
            if points:
                rewritten.writestr(_POINTS, points)
            for name in names:
                if name.startswith(f"{root}bindata/") and not name.endswith("/"):
                    rewritten.writestr(name.removeprefix(root), archive.read(name))
    packed.seek(0)
    return packed


def _x3p_points(document: bytes) -> tuple[str, int]:
    """Return member and number of bytes of the points of an X3P document; "" if not given."""
    link = re.search(rb"<PointDataLink>\s*([^<\s]+)\s*<", document)
    sides = [re.search(rb"<Size%s>\s*(\d+)\s*<" % axis, document) for axis in (b"X", b"Y", b"Z")]
    kind = re.search(rb"<CZ>.*?<DataType>\s*([IFDL])\s*<", document, re.DOTALL)
    if link is None or kind is None or not all(sides):
        return "", 0
    each = {b"I": 2, b"L": 4, b"F": 4, b"D": 8}[kind[1]]
    name = link[1].decode("utf-8", "replace")
    return name, math.prod(int(side[1]) for side in sides if side) * each


def save_sur(surface: Surface, path: str | os.PathLike[str]) -> None:
    """Write a height map as SUR, the format of Digital Surf's programs."""
    require_suffix(path, ".sur")
    (ny, nx), heights = surface.shape, surface.heights
    if surface.heights.size >= 2**31:
        raise InputError(
            f"{path} can hold fewer than 2³¹ points, got {ny} × {nx}; write .x3p or .npz"
        )
    # Missing points are the smallest height minus 2, which must be an integer of 32 bits as well.
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
            f"{format_lengths(surface.pixel)} and heights up to "
            f"{format_engineering(largest / 1e3, 'm')}; write .x3p or .npz"
        )
    lowest, highest = (round(1e3 * extreme / step) for extreme in (low, high))
    missing = lowest - 2
    with atomic_write(path) as stream:
        stream.write(_sur_header(surface, (lowest, highest), (edges[0], edges[1]), step))
        rows = max(1, BLOCK // (8 * nx))
        for first in range(0, ny, rows):
            block = np.rint(1e3 * heights[first : first + rows] / step)
            stream.write(np.where(np.isnan(block), missing, block).astype("<i4").tobytes())


# Places in the header: type of the object, lines and their distance, sizes of the comments between
# header and points, name of the heights, units.
_TYPE, _LINES, _STEP_Y, _COMMENTS = 18, 112, 124, 334
_NAME_Z, _UNIT_Y, _UNIT_Z = 164, 196, 212
_SUR_BYTES = 512
# Types of objects without heights.
_NO_HEIGHTS = {
    10: "an intensity image",
    12: "a color image",
    **dict.fromkeys((3, 18), "an image"),
    **dict.fromkeys((4, 5), "a series; export each,"),
    **dict.fromkeys((14, 15, 19, 20, 21), "curves or spectra"),
}


def is_compressed_sur(path: Path) -> bool:
    """Return whether a file of Digital Surf is compressed."""
    with path.open("rb") as stream:
        return stream.read(12) == b"DSCOMPRESSED"


def open_sur(path: Path) -> io.BytesIO | None:
    """Return the first object of a compressed SUR file, or of a profile; None for other files.

    Compressed points are the number of streams, raw and packed size of each, and the streams. A
    profile may leave the distance of its lines and their unit open; they are those of its points.
    """
    with path.open("rb") as stream:
        head = bytearray(stream.read(_SUR_BYTES))
        if len(head) < _SUR_BYTES or not head.startswith((b"DIGITAL SURF", b"DSCOMPRESSED")):
            return None
        _check_sur(path, head)
        is_packed, is_profile = head[:2] == b"DS", struct.unpack_from("<i", head, _LINES)[0] == 1
        if not (is_packed or is_profile):
            return None
        content = stream.read()
    if is_profile:
        for place, source, size in (
            (_STEP_Y, _STEP_Y - 4, 4),
            *((place, place - 16, 16) for place in (_UNIT_Y, _UNIT_Y + 48)),
        ):
            head[place : place + size] = head[source : source + size]
    start = sum(struct.unpack_from("<2H", head, _COMMENTS))
    remarks, points = content[:start], content[start:]
    if is_packed:
        head[:12] = b"DIGITAL SURF"
        count = struct.unpack_from("<I", points)[0]
        sizes = struct.unpack_from(f"<{2 * count}I", points, 4)[1::2]
        place, packed, points = 4 + 8 * count, points, b""
        for size in sizes:
            points += zlib.decompress(packed[place : place + size])
            place += size
    return io.BytesIO(bytes(head) + remarks + points)


def _check_sur(path: Path, head: bytearray) -> None:
    """Raise `FormatError` for a SUR file without heights."""
    kind = struct.unpack_from("<H", head, _TYPE)[0]
    if kind in _NO_HEIGHTS:
        raise FormatError(f"{path.name} holds {_NO_HEIGHTS[kind]}, no heights of one surface")
    name, unit = (
        head[place : place + 16].partition(b"\0")[0].decode("latin-1").strip()
        for place in (_NAME_Z, _UNIT_Z)
    )
    # Old files have the micro sign of MS-DOS.
    if unit and not is_length(path, unit.replace("\xe6", "u")):
        raise FormatError(f"{path.name} holds {name!r} in {unit!r}, no heights; export the heights")


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
    <Date>{_time_of_measurement(surface) or now}</Date>
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
      <PointDataLink>{_POINTS}</PointDataLink>
      <MD5ChecksumPointData>{checksum.upper()}</MD5ChecksumPointData>
    </DataLink>
  </Record3>
  <Record4>
    <ChecksumFile>{_SUMS}</ChecksumFile>
  </Record4>
</p:ISO5436_2>
"""


def _time_of_measurement(surface: Surface) -> str:
    """Return the time of measurement from the file; empty if not given."""
    origin = surface.provenance.origin
    return "" if origin is None else str(origin.found.get("acquired", ""))


def _sur_header(surface: Surface, extremes: tuple[int, int], pixel: Pixel, step: float) -> bytes:
    """Return the 512 bytes before the heights; pixel and step in mm."""
    ny, nx = surface.shape
    source = replace_unprintable(surface.provenance.source).encode("latin-1", "replace")[:30]
    names = (b"X", b"Y", b"Z", *6 * (b"mm",))
    return struct.pack(
        "<12s4H30s30s5H8xH5i3f" + 9 * "16s" + "3f3H12x7Hf10x2H128s3f34x",
        # PC format, one object, version, surface.
        *(b"DIGITAL SURF", 0, 1, 1, 2),
        # Name of the object and of the operator, padded with blanks.
        *(source.ljust(30), b" " * 30),
        # Material, acquisition and range unknown; missing points or none; absolute heights.
        *(0, 0, 0, int(surface.missing > 0), 1, 32),
        *(*extremes, nx, ny, nx * ny),
        *(pixel[1], pixel[0], step),
        *(name.ljust(16) for name in names),
        *(1.0, 1.0, 1.0),
        # Neither imprint nor inverted nor leveled; date and duration unknown; no comment, no
        # offsets.
        *10 * (0,),
        *(0.0, 0, 0, b" " * 128, 0.0, 0.0, 0.0),
    )


def _xml(text: str) -> str:
    # XML cannot represent most control characters, and UTF-8 no lone surrogates. Imported here, as
    # the module imports network libraries.
    from xml.sax.saxutils import escape

    return escape(replace_unprintable(text))
