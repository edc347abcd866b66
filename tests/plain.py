"""Plain readings of maps, one per format: after its definition, without the package's libraries."""

import ast
import hashlib
import io
import math
import re
import struct
import zipfile
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

# Sides, pixels and heights of these are what read_surface promises to keep to.
SIDES, PIXELS, HEIGHT_OVER_SIDE = (1e-9, 10.0), (1e-12, 1e-2), 100.0


@dataclass(frozen=True)
class Plain:
    """A map as a file states it: heights [m], NaN where missing, and pixel (dy, dx) [m]."""

    heights: np.ndarray
    pixel: tuple[float, float]


class InconsistentError(Exception):
    """The file contradicts itself, or lacks what states its scale."""


# Plain readings, one per format


def plain_opd(content: bytes) -> Plain:
    """Wyko: a directory of named blocks; nm per count and mm per pixel are separate blocks."""
    name, _, length, _ = struct.unpack("<16shlH", content[2:26])
    if name.rstrip(b"\0") != b"Directory":
        raise InconsistentError("no directory")
    blocks: dict[bytes, tuple[int, bytes]] = {}
    position = 2 + length
    for index in range(1, length // 24):
        entry = struct.unpack("<16shlH", content[2 + 24 * index : 26 + 24 * index])
        if entry[2] > 0:
            payload = content[position : position + entry[2]]
            if len(payload) < entry[2]:
                raise InconsistentError("a block ends beyond the file")
            blocks.setdefault(entry[0].split(b"\0")[0], (entry[1], payload))
            position += entry[2]

    def number(name: bytes) -> float:
        kind, payload = blocks[name]
        if (kind, len(payload)) not in ((6, 2), (7, 4)):
            raise InconsistentError(f"{name!r} is no number")
        return float(struct.unpack("<h" if kind == 6 else "<f", payload)[0])

    rasters = [
        payload
        for name, (kind, payload) in blocks.items()
        if kind == 3 and name in (b"RAW DATA", b"RAW_DATA", b"OPD", b"Raw", b"SAMPLE_DATA")
    ]
    nx, ny, itemsize = struct.unpack("<HHH", rasters[0][:6])
    counts = np.frombuffer(rasters[0], {2: "<i2", 4: "<f4"}[itemsize], nx * ny, 6)
    values = counts.reshape(nx, ny)[:, ::-1].T.astype(float)
    values[~(values < (32766 if itemsize == 2 else 1e38))] = np.nan
    scale = number(b"Wavelength") * 1e-9
    if itemsize == 2 or b"Mult" in blocks:
        scale /= number(b"Mult")
    edge = number(b"Pixel_size") * 1e-3
    return Plain(values * scale, (edge * number(b"Aspect"), edge))


LENGTHS = {
    b"m": 1.0,
    b"mm": 1e-3,
    b"nm": 1e-9,
    b"\xb5m": 1e-6,
    b"um": 1e-6,
    b"\xe6m": 1e-6,
    b"pm": 1e-12,
    b"fm": 1e-15,
    b"cm": 1e-2,
    b"dm": 0.1,
    b"km": 1e3,
    b"~m": 1e-6,
    b"\xc5": 1e-10,
    b"A": 1e-10,
    b"Mm": 1e6,
    b"Gm": 1e9,
    b"am": 1e-18,
}


def plain_sur(content: bytes) -> Plain:
    """Digital Surf: a header of 512 bytes, a comment, private data, integers row by row."""
    if content[:12] != b"DIGITAL SURF":
        raise InconsistentError("magic")
    (special,) = struct.unpack_from("<H", content, 86)
    bits, low, high, nx, ny, points = struct.unpack_from("<HiiiiI", content, 98)
    dx, dy, dz = struct.unpack_from("<fff", content, 120)
    x, y, z = (LENGTHS[content[at : at + 16].split(b"\0")[0].strip()] for at in (180, 196, 212))
    (inversion,) = struct.unpack_from("<H", content, 290)
    comment, private = struct.unpack_from("<HH", content, 334)
    start = 512 + comment + private
    if points != nx * ny or bits not in (16, 32):
        raise InconsistentError("grid")
    counts = np.frombuffer(content, f"<i{bits // 8}", points, start).reshape(ny, nx)
    values = counts.astype(float)
    if special == 1:
        values[counts == low - 2] = np.nan
    if start + points * bits // 8 != len(content) and (
        np.nanmin(values) != low or np.nanmax(values) != high
    ):
        raise InconsistentError("the data end before the file and leave zmin to zmax")
    if inversion in (1, 2, 3):
        values = -values
    values = {2: values[:, ::-1], 3: values[::-1]}.get(inversion, values)
    return Plain(values * dz * z, (dy * y, dx * x))


def plain_metropro(content: bytes) -> Plain:
    """Zygo: big-endian header, camera frames of uint16, phases of int32."""
    (magic,) = struct.unpack_from(">I", content, 0)
    size = {0x881B036F: 834, 0x881B0370: 834, 0x881B0371: 4096}[magic]
    (header,) = struct.unpack_from(">I", content, 6)
    width, height, frames = struct.unpack_from(">HHH", content, 52)
    (frame_bytes,) = struct.unpack_from(">I", content, 60)
    nx, ny = struct.unpack_from(">HH", content, 68)
    (phase_bytes,) = struct.unpack_from(">I", content, 72)
    scale, wavelength, _, obliquity, _, edge = struct.unpack_from(">6f", content, 164)
    (resolution,) = struct.unpack_from(">h", content, 218)
    (sign,) = struct.unpack_from(">h", content, 232)
    if (header, frame_bytes, phase_bytes) != (size, 2 * width * height * frames, 4 * nx * ny):
        raise InconsistentError("lengths")
    counts = np.frombuffer(content, ">i4", nx * ny, size + frame_bytes).reshape(ny, nx)
    values = counts.astype(float)
    values[counts >= 2147483640] = np.nan
    values *= scale * obliquity * wavelength / {0: 4096, 1: 32768, 2: 131072}[resolution]
    return Plain(-values if sign else values, (edge, edge))


def plain_di(content: bytes) -> Plain:
    """Bruker: sections of lines in ASCII; the first image whose scale is a length."""
    header = content.split(b"\\*File list end", 1)[0]
    sections: list[tuple[bytes, dict[bytes, bytes]]] = []
    for line in header.split(b"\n"):
        line = line.strip()
        if line.startswith(b"\\*"):
            sections.append((line[2:].lower(), {}))
        else:
            key, _, value = line[1:].partition(b": ")
            sections[-1][1][key.lower()] = value.strip()
    scales = {
        key: value
        for name, part in sections
        if name in (b"scanner list", b"ciao scan list")
        for key, value in part.items()
        if key.startswith(b"@sens")
    }
    scan = next((part for name, part in sections if name == b"ciao scan list"), {})
    for name, part in sections:
        if name != b"ciao image list":
            continue
        quantity, volts, volt = re.fullmatch(
            rb"V \[(.*)\] \(.*\) (\S+) (\S+)", part[b"@2:z scale"]
        ).groups()
        scale = scales.get(b"@" + quantity.lower(), b"V 1")
        factor, unit = re.fullmatch(rb"V (\S+)\s*(\S*)", scale).groups()
        unit, _, per = unit.partition(b"/")
        if unit not in LENGTHS:
            continue
        if per != volt:
            raise InconsistentError("units of the heights")
        nx, ny = int(part[b"samps/line"]), int(part[b"number of lines"])
        itemsize, start = int(part.get(b"bytes/pixel", b"2")), int(part[b"data offset"])
        if int(part[b"data length"]) < nx * ny * itemsize or (
            (int(scan.get(b"samps/line", nx)), int(scan.get(b"lines", ny))) != (nx, ny)
        ):
            raise InconsistentError("lengths")
        counts = np.frombuffer(content, f"<i{itemsize}", nx * ny, start).reshape(ny, nx)
        scale = float(volts) / 256**itemsize * float(factor) * LENGTHS[unit]
        along_x, along_y, length = part[b"scan size"].split()
        metre = LENGTHS[length]
        pixel = float(along_y) * metre / ny, float(along_x) * metre / nx
        return Plain(counts[::-1] * scale, pixel)
    raise InconsistentError("no height")


def plain_x3p(content: bytes) -> Plain:
    """ISO 25178-72: XML and doubles in an archive with checksums."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        document, raw = archive.read("main.xml"), archive.read("bindata/data.bin")
        names = archive.namelist()
        sums = archive.read("md5checksum.hex") if "md5checksum.hex" in names else b""
    text = document.decode()
    for content, stated in (
        (document, re.search(rb"^(\w{32}) \*?main.xml", sums, re.MULTILINE)),
        (raw, re.search(r"<MD5ChecksumPointData>(\w+)<", text)),
    ):
        if stated:
            word = stated[1] if isinstance(stated[1], str) else stated[1].decode()
            if hashlib.md5(content).hexdigest() != word.lower():
                raise InconsistentError("a checksum is wrong")

    def number(path: str) -> float:
        pattern = "".join(f"<{name}>.*?" for name in path.split("/")[:-1])
        return float(re.search(rf"{pattern}<{path.split('/')[-1]}>(.*?)<", text, re.DOTALL)[1])

    ny, nx = int(number("SizeY")), int(number("SizeX"))
    values = np.frombuffer(raw, "<f8").reshape(ny, nx)
    return Plain(values, (number("CY/Increment"), number("CX/Increment")))


def plain_mnt(pristine: bytes, counts: np.ndarray) -> Callable[[bytes], Plain]:
    """MountainsMap: steps and origin at their places in one file, whose counts are known.

    The heights lie compressed, with checksums, in a tree in a compound document; to read it in
    full would be to write its reader again.
    """
    # Each record: step, tag and size, marker, unit.
    places = {}
    for axis, step in (("X", 1.853393117831074), ("Y", 1.8545542570951588), ("Z", 0.0001)):
        mark = b"\x04" + axis.encode() + b"\0\x01\0\x08\0\0\0\0\0\0\0" + struct.pack("<d", step)
        places[axis] = pristine.index(mark) + len(mark) - 8

    def stated(content: bytes) -> Plain:
        steps = []
        for place in places.values():
            (step,) = struct.unpack_from("<d", content, place)
            unit = content[place + 19 : place + 23].decode("utf-16-le").encode("latin-1")
            steps.append(step * LENGTHS[unit.strip(b"\0")])
        dx, dy, dz = steps
        return Plain(counts * dz, (dy, dx))

    return stated


def array_of(content: bytes) -> np.ndarray:
    """NumPy's format, version 1: a header of a dictionary, then nothing but the numbers."""
    if content[:8] != b"\x93NUMPY\x01\x00":
        raise InconsistentError("magic")
    (length,) = struct.unpack_from("<H", content, 8)
    header = ast.literal_eval(content[10 : 10 + length].decode("latin-1"))
    dtype, shape = np.dtype(header["descr"]), header["shape"]
    if 10 + length + math.prod(shape) * dtype.itemsize != len(content):
        raise InconsistentError("length")
    values = np.frombuffer(content, dtype, math.prod(shape), 10 + length)
    return values.reshape(shape, order="F" if header["fortran_order"] else "C")


def plain_npy(size: tuple[float, float]) -> Callable[[bytes], Plain]:
    def stated(content: bytes) -> Plain:
        # Damaged numbers may be NaN of the signalling kind.
        with np.errstate(invalid="ignore"):
            values = array_of(content) * 1e-6
        return Plain(values, (size[0] / values.shape[0], size[1] / values.shape[1]))

    return stated


def plain_archive(size: tuple[float, float]) -> Callable[[bytes], Plain]:
    def stated(content: bytes) -> Plain:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            # Of two members of one name the last is meant.
            return plain_npy(size)(archive.read(archive.namelist()[0]))

    return stated


def plain_text(size: tuple[float, float]) -> Callable[[bytes], Plain]:
    def stated(content: bytes) -> Plain:
        rows = [
            [float(cell or "nan") for cell in re.split(r"[;,\s]\s*", line.split("#")[0].strip())]
            for line in content.decode().splitlines()
            if line.split("#")[0].strip()
        ]
        values = np.array(rows) * 1e-6
        return Plain(values, (size[0] / values.shape[0], size[1] / values.shape[1]))

    return stated


def plain_sdf(content: bytes) -> Plain:
    head, data = content.decode().split("*\n")[:2]
    found = dict(re.findall(r"(\w+) = (\S+)", head))
    nx, ny = int(found["NumPoints"]), int(found["NumProfiles"])
    values = np.array([math.nan if word == "BAD" else float(word) for word in data.split()])
    if not head.startswith("aISO-1.0\n") or int(found["Compression"]):
        raise InconsistentError("header")
    pixel = float(found["Yscale"]), float(found["Xscale"])
    return Plain(values.reshape(ny, nx) * float(found["Zscale"]), pixel)


def plain_netcdf(pristine: bytes, made: Plain) -> Callable[[bytes], Plain]:
    """The program's own file: numbers at their places in a file without compression."""
    (ny, nx), (dy, dx) = made.heights.shape, made.pixel
    arrays = (made.heights, (np.arange(ny) + 0.5) * dy, (np.arange(nx) + 0.5) * dx)
    places = [pristine.index(array.astype("<f8").tobytes()) for array in arrays]

    def stated(content: bytes) -> Plain:
        heights, y, x = (
            np.frombuffer(content, "<f8", array.size, place)
            for array, place in zip(arrays, places, strict=True)
        )
        pixel = float(np.mean(np.diff(y))), float(np.mean(np.diff(x)))
        return Plain(heights.reshape(ny, nx), pixel)

    return stated


def plain_hdf5(content: bytes) -> Plain:
    """The program's own file after a change by HDF5 itself."""
    import h5py

    with h5py.File(io.BytesIO(content), "r") as file:
        for name in ("height", "y", "x"):
            own = isinstance(file.get(name, getlink=True), h5py.HardLink)
            if not own or file[name].external or file[name].is_virtual:
                raise InconsistentError(f"{name} is not in the file")
        heights, y, x = (np.asarray(file[name][()], float) for name in ("height", "y", "x"))
        edges = [file.attrs.get(f"pixel_{axis}") for axis in "yx"]
        if file["height"].attrs["units"] != "m":
            raise InconsistentError("no metres")
    if None in edges:
        edges = [abs(float(np.mean(np.diff(axis)))) for axis in (y, x)]
    dy, dx = (float(np.asarray(edge).item()) for edge in edges)
    return Plain(heights, (dy, dx))


def plain_npz(content: bytes) -> Plain:
    """The program's own archive: heights and the pixel in a unit."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        heights, pixel, unit = (
            array_of(archive.read(f"{name}.npy")) for name in ("heights", "pixel", "unit")
        )
    metre = LENGTHS[str(unit).encode("latin-1")]
    dy, dx = (float(edge) * metre for edge in pixel)
    return Plain(np.asarray(heights, float) * metre, (dy, dx))


def plain_headed(content: bytes) -> Plain:
    """The program's own text: the scale in a head."""
    lines = content.decode().splitlines()
    head = (line[1:].partition(":") for line in lines if line.startswith("#"))
    found = {name.strip(): value.strip() for name, mark, value in head if mark}
    metre = LENGTHS[found["unit"].encode("latin-1")]
    edges = []
    for axis in "yx":
        value, unit = re.fullmatch(r"(\S+?)\s*([^\d.+-]+)", found[f"pixel_{axis}"]).groups()
        edges.append(float(value) * LENGTHS[unit.encode("latin-1")])
    rows = [line.split("#")[0].strip() for line in lines]
    cells = [[float(cell or "nan") for cell in row.split(",")] for row in rows if row]
    return Plain(np.array(cells) * metre, (edges[0], edges[1]))


# Differences of two maps


def differing(read: Plain, stated: Plain) -> str:
    """Return in what two maps differ; their zero levels, which mean nothing, may."""
    if read.heights.shape != stated.heights.shape:
        return "another grid than the file states"
    # Single precision in many headers.
    if not np.allclose(read.pixel, stated.pixel, rtol=1e-6, atol=0):
        return "another pixel than the file states"
    a, b = (heights - np.nanmean(heights) for heights in (read.heights, stated.heights))
    scale = np.nanmax(np.abs(b))
    if not np.allclose(a, b, rtol=1e-6, atol=1e-9 * scale, equal_nan=True):
        return "other heights than the file states"
    return ""


def implausible(heights: np.ndarray, pixel: tuple[float, float]) -> str:
    sides = np.multiply(heights.shape, pixel)
    span = np.nanmax(heights) - np.nanmin(heights)
    if not (
        all(SIDES[0] <= side <= SIDES[1] for side in sides)
        and all(PIXELS[0] <= edge <= PIXELS[1] for edge in pixel)
        and span <= HEIGHT_OVER_SIDE * max(sides)
    ):
        return f"implausible: pixel {pixel}, sides {sides}, span {span}"
    return ""
