"""Damaged files are refused or read at the scale that they state, whatever is damaged.

Every measurement is copied with damage of many kinds and read by a second process, under a limit
of time and of memory. What comes back is compared with the undamaged map, and where it differs in
more points than bytes were damaged, with a plain reading of the damaged file: one per format,
written here after the format's definition, without the libraries that the package uses.
"""

import ast
import importlib.util
import io
import json
import math
import os
import re
import select
import struct
import subprocess
import sys
import zipfile
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest

MEASUREMENTS = Path(__file__).parents[1] / ".." / "shared" / "measurements"
SECONDS = 20.0
MEMORY = 4 * 2**30

# Sides, pixels and heights of these are what read_surface promises to keep to.
SIDES, PIXELS, HEIGHT_OVER_SIDE = (1e-9, 10.0), (1e-12, 1e-2), 100.0


@dataclass(frozen=True)
class Plain:
    """A map as a file states it: heights [m], NaN where missing, and pixel (dy, dx) [m]."""

    heights: np.ndarray
    pixel: tuple[float, float]


@dataclass(frozen=True)
class Case:
    """A file to damage.

    ``fields`` are the bytes that state grid and scale, ``stated`` the plain reading, and
    ``checked`` says that checksums in the file protect every height.
    """

    name: str
    content: bytes
    stated: Callable[[bytes], Plain]
    fields: tuple[tuple[int, int], ...] = ()
    arguments: dict[str, str] = field(default_factory=dict)
    checked: bool = False


class InconsistentError(Exception):
    """The file contradicts itself, or lacks what states its scale."""


# Plain readings, one per format


def plain_opd(content: bytes) -> Plain:
    """Wyko: a directory of named blocks; nm per count and mm per pixel are blocks of their own."""
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


_LENGTHS = {b"m": 1.0, b"mm": 1e-3, b"nm": 1e-9, b"\xb5m": 1e-6, b"um": 1e-6, b"\xe6m": 1e-6,
            b"pm": 1e-12, b"fm": 1e-15, b"cm": 1e-2, b"dm": 0.1, b"km": 1e3, b"~m": 1e-6,
            b"\xc5": 1e-10, b"A": 1e-10, b"Mm": 1e6, b"Gm": 1e9, b"am": 1e-18}  # fmt: skip


def plain_sur(content: bytes) -> Plain:
    """Digital Surf: a header of 512 bytes, a comment, private data, integers row by row."""
    if content[:12] != b"DIGITAL SURF":
        raise InconsistentError("magic")
    (special,) = struct.unpack_from("<H", content, 86)
    bits, low, high, nx, ny, points = struct.unpack_from("<HiiiiI", content, 98)
    dx, dy, dz = struct.unpack_from("<fff", content, 120)
    x, y, z = (_LENGTHS[content[at : at + 16].split(b"\0")[0].strip()] for at in (180, 196, 212))
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
    scales = {key: value for name, part in sections if name in (b"scanner list", b"ciao scan list")
              for key, value in part.items() if key.startswith(b"@sens")}  # fmt: skip
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
        if unit not in _LENGTHS:
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
        scale = float(volts) / 256**itemsize * float(factor) * _LENGTHS[unit]
        along_x, along_y, length = part[b"scan size"].split()
        metre = _LENGTHS[length]
        pixel = float(along_y) * metre / ny, float(along_x) * metre / nx
        return Plain(counts[::-1] * scale, pixel)
    raise InconsistentError("no height")


def plain_x3p(content: bytes) -> Plain:
    """ISO 25178-72: XML and doubles in an archive with checksums."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        text = archive.read("main.xml").decode()
        raw = archive.read("bindata/data.bin")

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
            steps.append(step * _LENGTHS[unit.strip(b"\0")])
        dx, dy, dz = steps
        return Plain(counts * dz, (dy, dx))

    return stated


def plain_npy(size: tuple[float, float]) -> Callable[[bytes], Plain]:
    def stated(content: bytes) -> Plain:
        if content[:8] != b"\x93NUMPY\x01\x00":
            raise InconsistentError("magic")
        (length,) = struct.unpack_from("<H", content, 8)
        header = ast.literal_eval(content[10 : 10 + length].decode("latin-1"))
        dtype, shape = np.dtype(header["descr"]), header["shape"]
        if 10 + length + math.prod(shape) * dtype.itemsize != len(content):
            raise InconsistentError("length")
        values = np.frombuffer(content, dtype, math.prod(shape), 10 + length)
        values = values.reshape(shape, order="F" if header["fortran_order"] else "C") * 1e-6
        return Plain(values, (size[0] / shape[0], size[1] / shape[1]))

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


# Files to damage

SIZE = (30e-6, 44e-6)


def made_map() -> np.ndarray:
    """Heights of 30 × 22 points [µm] with two holes."""
    heights = np.random.default_rng(4).normal(size=(30, 22)).round(4)
    heights[3, 5] = heights[20, 0] = np.nan
    return heights


def made_cases(folder: Path) -> Iterator[Case]:
    """Small files of every kind, made here."""
    heights = made_map()
    plain = Plain(heights * 1e-6, (1e-6, 2e-6))
    given = {"unit": "um", "size": "30 um x 44 um"}

    stream = io.BytesIO()
    np.save(stream, heights)
    content = stream.getvalue()
    yield Case("made.npy", content, plain_npy(SIZE), ((0, 128),), given)
    stream = io.BytesIO()
    np.savez(stream, heights)
    # An archive has checksums: its heights may not change at all.
    yield Case("made.npz", stream.getvalue(), lambda _: plain, ((0, 200),), given, True)
    for name, mark in (("made.csv", ","), ("made.txt", " "), ("made.asc", ";")):
        lines = [mark.join(f"{z:.4f}" for z in row) for row in heights]
        content = ("# made\n" + "\n".join(lines) + "\n").encode()
        yield Case(name, content, plain_text(SIZE), ((0, 200),), given)

    import xarray

    axes = {name: (name, (np.arange(n) + 0.5) * e, {"units": "m"})
            for name, n, e in (("y", 30, 1e-6), ("x", 22, 2e-6))}  # fmt: skip
    for name, attributes in (("bare.nc", {}), ("made.nc", {"pixel_y": 1e-6, "pixel_x": 2e-6})):
        variable = (("y", "x"), plain.heights, {"units": "m"})
        data = xarray.Dataset({"height": variable}, coords=axes, attrs=attributes)
        data.to_netcdf(folder / name, engine="h5netcdf")
        content = (folder / name).read_bytes()
        # Superblock and headers, then the heap of texts and references.
        fields = [(0, 1000), (1000, 2000), (2000, 3000)]
        for number in {
            found.start()
            for edge in plain.pixel
            for found in re.finditer(re.escape(struct.pack("<d", edge)), content)
        }:
            fields.append((number, number + 8))  # fmt: skip
        yield Case(name, content, plain_netcdf(content, plain), tuple(fields))

    if importlib.util.find_spec("SurfaceTopography") is None:
        return
    header = {"ManufacID": "test", "CreateDate": "010120240000", "ModDate": "010120240000",
              "NumPoints": 22, "NumProfiles": 30, "Xscale": 2e-6, "Yscale": 1e-6, "Zscale": 1e-6,
              "Zresolution": -1, "Compression": 0, "DataType": 7, "CheckType": 0}  # fmt: skip
    lines = ["aISO-1.0", *(f"{key} = {value}" for key, value in header.items()), "*"]
    lines += [" ".join("BAD" if np.isnan(z) else str(z) for z in row) for row in heights]
    content = ("\n".join([*lines, "*"]) + "\n").encode()
    yield Case("made.sdf", content, plain_sdf, ((0, 250),))

    full = np.nan_to_num(heights) * 1e-6
    text = (
        "<?xml version='1.0' encoding='UTF-8'?>\n"
        "<p:ISO5436_2 xmlns:p='http://www.opengps.eu/2008/ISO5436_2'><Record1>"
        "<Revision>ISO5436 - 2000</Revision><FeatureType>SUR</FeatureType><Axes>"
        "<CX><AxisType>I</AxisType><DataType>D</DataType><Increment>2e-6</Increment></CX>"
        "<CY><AxisType>I</AxisType><DataType>D</DataType><Increment>1e-6</Increment></CY>"
        "<CZ><AxisType>A</AxisType><DataType>D</DataType></CZ></Axes></Record1><Record3>"
        "<MatrixDimension><SizeX>22</SizeX><SizeY>30</SizeY><SizeZ>1</SizeZ></MatrixDimension>"
        "<DataLink><PointDataLink>bindata/data.bin</PointDataLink></DataLink></Record3>"
        "</p:ISO5436_2>"
    )
    for name, packing in (("made.x3p", zipfile.ZIP_DEFLATED), ("stored.x3p", zipfile.ZIP_STORED)):
        stream = io.BytesIO()
        with zipfile.ZipFile(stream, "w", packing) as archive:
            archive.writestr("main.xml", text)
            archive.writestr("bindata/data.bin", full.astype("<f8").tobytes())
        content = stream.getvalue()
        ends = ((0, 200), (len(content) - 200, len(content)))
        yield Case(name, content, plain_x3p, ends, checked=True)

    counts = np.where(np.isnan(heights), -32002, np.nan_to_num(heights) * 1e4).astype("<i4")
    valid = counts[counts != -32002]
    low, high = -32000, int(valid.max())
    counts[5, 5] = low
    head = bytearray(512)
    struct.pack_into("<12sHHHH", head, 0, b"DIGITAL SURF", 0, 1, 1, 2)
    struct.pack_into("<H", head, 86, 1)
    struct.pack_into("<HiiiiI", head, 98, 32, low, high, 22, 30, 22 * 30)
    struct.pack_into("<fff", head, 120, 2e-3, 1e-3, 1e-7)
    for at in range(180, 276, 16):
        head[at : at + 2] = b"mm"
    struct.pack_into("<fffHH", head, 276, 1, 1, 1, 0, 0)
    struct.pack_into("<HH", head, 334, 13, 0)
    content = bytes(head) + b"made for test" + counts.tobytes()
    yield Case("made.sur", content, plain_sur, ((86, 136), (180, 292), (334, 338)))


def measured_cases() -> Iterator[Case]:
    """The instruments' files, where they are there."""
    if importlib.util.find_spec("SurfaceTopography") is None:
        return
    for name, stated, fields in (
        ("wyko_nt1100_test_1.opd", plain_opd, ((0, 2000),)),
        ("opd-1.opd", plain_opd, ((0, 1100),)),
        ("sur-2.sur", plain_sur, ((86, 136), (180, 292), (334, 338))),
        ("dvd_afm.sur", plain_sur, ((86, 136), (180, 292), (334, 338))),
        ("metropro-1.dat", plain_metropro, ((0, 80), (160, 240))),
        ("uncd_afm.001", plain_di, ()),
        ("mnt-1.mnt", None, ((160300, 160700), (1586280, 1586400), (0, 600))),
        ("x3p-2.x3p", plain_x3p, ((0, 100),)),
        ("bullet_land_fixed.x3p", plain_x3p, ((0, 1000),)),
    ):
        path = MEASUREMENTS / name
        if not path.exists():
            continue
        content = path.read_bytes()
        if name.endswith(".001"):
            fields = tuple(
                (found.start(), found.end())
                for found in re.finditer(
                    rb"\\(Samps/line|Lines|Number of lines|Scan size|Bytes/pixel|Data offset|"
                    rb"Data length|Aspect ratio|Version|@2:Z scale|@Sens. Zsens|"
                    rb"\*\w+ \w+ list)[^\r]*",
                    content, re.IGNORECASE,
                )
            )  # fmt: skip
        if name.endswith("x3p"):
            fields = (*fields, (len(content) - 300, len(content)))
        checked = name.endswith((".x3p", ".mnt"))
        yield Case(name, content, stated, fields, checked=checked)


# The second process


def serve() -> None:
    """Read the files that are named on standard input, and answer in one line each."""
    import resource

    from roughcontact.errors import InputError
    from roughcontact.formats.read import read_surface

    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    # Whatever a library prints, in Python or in C, goes to a file and is seen.
    noise = os.open(sys.argv[1], os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    os.dup2(noise, 1)
    os.dup2(noise, 2)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    for line in sys.stdin:
        order = json.loads(line)
        answer: dict[str, object] = {}
        try:
            surface = read_surface(order["path"], **order["arguments"])
            np.save(order["path"] + ".read.npy", surface.heights)
            answer = {"pixel": surface.pixel}
        except InputError as error:
            answer = {"refused": str(error), "cause": repr(error.__cause__)}
        except BaseException as error:
            answer = {"raised": repr(error)}
        sys.stdout.flush()
        answer["printed"] = os.lseek(noise, 0, os.SEEK_CUR)
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


class Reader:
    """A process that reads files, replaced by another where it hangs or dies."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.process: subprocess.Popen[str] | None = None
        self.printed = 0

    def read(self, path: Path, arguments: dict[str, str]) -> dict[str, object]:
        if self.process is None:
            self.start()
        assert self.process is not None
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        order = json.dumps({"path": str(path), "arguments": arguments})
        self.process.stdin.write(order + "\n")
        self.process.stdin.flush()
        ready, _, _ = select.select([self.process.stdout], [], [], SECONDS)
        line = self.process.stdout.readline() if ready else ""
        if not line:
            died = self.process.wait(SECONDS) if ready else None
            self.close()
            return {"raised": f"died with {died}" if ready else f"took more than {SECONDS} s"}
        answer: dict[str, object] = json.loads(line)
        printed = answer.pop("printed")
        if printed != self.printed:
            noise = (self.folder / "noise").read_bytes()[self.printed :]
            answer = {"raised": f"printed {noise[:300]!r}"}
            self.printed = printed
        if "pixel" in answer:
            answer["heights"] = np.load(f"{path}.read.npy")
        return answer

    def start(self) -> None:
        import roughcontact

        (self.folder / "noise").write_bytes(b"")
        self.printed = 0
        source = Path(roughcontact.__file__).parents[1]
        environment = os.environ | {
            "PYTHONPATH": os.pathsep.join([str(source), os.environ.get("PYTHONPATH", "")]),
            "OPENBLAS_NUM_THREADS": "1",
            "OMP_NUM_THREADS": "1",
            "PYTHONUNBUFFERED": "1",
        }
        self.process = subprocess.Popen(
            [sys.executable, __file__, str(self.folder / "noise")],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment,
        )  # fmt: skip

    def close(self) -> None:
        if self.process is not None:
            self.process.kill()
            self.process.communicate()
            self.process = None


# Damage


def damaged(case: Case, rng: np.random.Generator) -> tuple[str, bytes]:
    """Return what was done to a file, and the result."""
    content = bytearray(case.content)
    length = len(content)

    def anywhere() -> int:
        return int(rng.integers(length))

    def in_header() -> int:
        # Headers stand at the start, directories of archives at the end.
        where = rng.random()
        if where < 0.5 and case.fields:
            start, stop = case.fields[int(rng.integers(len(case.fields)))]
            return int(rng.integers(start, min(stop, length)))
        if where < 0.8:
            return int(rng.integers(min(2048, length)))
        if where < 0.9:
            return int(rng.integers(min(48 * 1024, length)))
        return int(rng.integers(max(length - 4096, 0), length))

    def flip(place: int) -> str:
        old = content[place]
        if rng.random() < 0.5:
            content[place] ^= 1 << int(rng.integers(8))
        else:
            content[place] = int(rng.integers(256))
        return f"{place}: {old:#04x} to {content[place]:#04x}"

    kinds = {"truncate": 0.13, "flip": 0.06, "header": 0.4, "headers": 0.1, "flips": 0.05,
             "zero": 0.08, "noise": 0.06, "swap": 0.06, "tail": 0.06}  # fmt: skip
    kind = str(rng.choice(list(kinds), p=list(kinds.values())))
    if kind == "truncate":
        keep = anywhere() if rng.random() < 0.7 else in_header()
        return f"truncated to {keep} of {length} bytes", bytes(content[:keep])
    if kind in ("flip", "header"):
        return "flipped " + flip(anywhere() if kind == "flip" else in_header()), bytes(content)
    if kind in ("flips", "headers"):
        places = [anywhere() if kind == "flips" else in_header() for _ in range(rng.integers(2, 9))]
        return "flipped " + ", ".join(flip(place) for place in places), bytes(content)
    start = in_header() if rng.random() < 0.5 else anywhere()
    size = min(int(2 ** rng.uniform(0, 12)), length - start)
    if kind == "zero":
        content[start : start + size] = bytes(size)
        return f"zeroed {size} bytes at {start}", bytes(content)
    if kind == "noise":
        content[start : start + size] = rng.bytes(size)
        return f"noise in {size} bytes at {start}", bytes(content)
    if kind == "swap":
        other = min(anywhere(), length - size)
        block = content[start : start + size]
        content[start : start + size] = content[other : other + size]
        content[other : other + size] = block
        return f"swapped {size} bytes at {start} and {other}", bytes(content[:length])
    size = min(int(2 ** rng.uniform(0, 18)), length)
    return f"last {size} bytes twice", bytes(content + content[length - size :])


def finding(case: Case, original: Plain, content: bytes, answer: dict[str, object]) -> str:
    """Return what is wrong with an answer; empty if nothing is."""
    if "raised" in answer:
        return str(answer["raised"])
    if "refused" in answer:
        return wrong_in_message(case, answer)
    heights, pixel = np.asarray(answer["heights"]), tuple(answer["pixel"])  # type: ignore[arg-type]
    wrong = implausible(heights, pixel)
    if wrong:
        return wrong
    if heights.shape == original.heights.shape and pixel == original.pixel:
        same = (heights == original.heights) | (np.isnan(heights) & np.isnan(original.heights))
        changed = int(np.count_nonzero(~same))
        common = min(len(content), len(case.content))
        bytes_changed = int(
            np.count_nonzero(
                np.frombuffer(content[:common], "u1") != np.frombuffer(case.content[:common], "u1")
            )
        )
        if changed <= (0 if case.checked else bytes_changed):
            return ""
    try:
        stated = case.stated(content)
    except Exception as error:
        return f"read, while a plain reading fails with {error!r}: {described(original, answer)}"
    wrong = differing(Plain(heights, pixel), stated)
    return f"{wrong}: {described(original, answer)}, stated {stated.pixel}" if wrong else ""


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


def wrong_in_message(case: Case, answer: dict[str, object]) -> str:
    message = str(answer["refused"])
    if "\n" in message or not message.isprintable() or len(message) > 700:
        return f"no sentence: {message!r}"
    if case.name.split(".")[0] not in message:
        return f"does not name the file: {message!r}"
    # Memory asked for is asked of a larger machine in vain too.
    if "MemoryError" in message + str(answer["cause"]):
        return f"out of memory: {message!r}"
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


def described(original: Plain, answer: dict[str, object]) -> str:
    heights = np.asarray(answer["heights"])
    text = f"{heights.shape} of pixel {answer['pixel']} for {original.heights.shape} of "
    text += f"{original.pixel}, span {np.nanmin(heights)} to {np.nanmax(heights)}"
    if heights.shape == original.heights.shape:
        differ = heights != original.heights
        differ &= ~(np.isnan(heights) & np.isnan(original.heights))
        text += f", {np.count_nonzero(differ)} heights differ"
    return text


def sound(reader: Reader, case: Case, path: Path) -> tuple[Case, Plain]:
    """Return a case with its undamaged map, and check the judge itself on it."""
    path.write_bytes(case.content)
    answer = reader.read(path, case.arguments)
    assert "heights" in answer, answer
    original = Plain(np.asarray(answer["heights"]), tuple(answer["pixel"]))  # type: ignore[arg-type]
    if case.name.endswith(".mnt"):
        counts = (original.heights - np.mean(original.heights)) / 1e-13
        case = replace(case, stated=plain_mnt(case.content, counts))
    assert not differing(original, case.stated(case.content))
    return case, original


def campaign(reader: Reader, case: Case, folder: Path, count: int, seed: int) -> list[str]:
    """Return the findings of so many damaged copies of a file."""
    path = folder / case.name
    case, original = sound(reader, case, path)
    findings = []
    for index in range(count):
        rng = np.random.default_rng([seed, zlib.crc32(case.name.encode()), index])
        what, content = damaged(case, rng)
        if content == case.content:
            continue
        path.write_bytes(content)
        wrong = finding(case, original, content, reader.read(path, case.arguments))
        if wrong:
            findings.append(f"{case.name} #{index}, {what}: {wrong}")
    return findings


# Tests

MADE = ("made.npy", "made.npz", "made.csv", "made.txt", "made.asc", "bare.nc", "made.nc",
        "made.sdf", "made.x3p", "stored.x3p", "made.sur")  # fmt: skip
MEASURED = ("wyko_nt1100_test_1.opd", "opd-1.opd", "sur-2.sur", "dvd_afm.sur", "metropro-1.dat",
            "uncd_afm.001", "mnt-1.mnt", "x3p-2.x3p", "bullet_land_fixed.x3p")  # fmt: skip


@pytest.fixture(scope="module")
def reader(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Reader]:
    pytest.importorskip("resource", reason="limits of memory are POSIX")
    reader = Reader(tmp_path_factory.mktemp("reader"))
    yield reader
    reader.close()


@pytest.fixture(scope="module")
def cases(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Case]:
    made = made_cases(tmp_path_factory.mktemp("made"))
    return {case.name: case for case in (*made, *measured_cases())}


@pytest.fixture(params=(*MADE, *MEASURED))
def case(request: pytest.FixtureRequest, cases: dict[str, Case]) -> Case:
    if request.param not in cases:
        pytest.skip(f"{request.param} or its reader is absent")
    return cases[request.param]


def test_damaged_files(case: Case, reader: Reader, tmp_path: Path) -> None:
    findings = campaign(reader, case, tmp_path, 20, seed=1)
    assert not findings, "\n".join(findings)


@pytest.mark.slow
def test_many_damaged_files(case: Case, reader: Reader, tmp_path: Path) -> None:
    findings = campaign(reader, case, tmp_path, 500, seed=2)
    assert not findings, "\n".join(findings)


def misnamed(reader: Reader, case: Case, folder: Path, suffixes: list[str]) -> list[str]:
    """Return the findings of a file under other suffixes: refused, or the same map."""
    case, original = sound(reader, case, folder / case.name)
    findings = []
    for suffix in suffixes:
        path = folder / f"{case.name.split('.')[0]}{suffix}"
        path.write_bytes(case.content)
        matrix = suffix in (".npy", ".npz", ".csv", ".txt", ".asc")
        given = {"unit": "um", "size": "30 um x 44 um"} if matrix else {}
        answer = reader.read(path, given)
        if "heights" in answer:
            heights, pixel = np.asarray(answer["heights"]), answer["pixel"]
            wrong = differing(Plain(heights, tuple(pixel)), original)  # type: ignore[arg-type]
        else:
            wrong = str(answer.get("raised", "")) or wrong_in_message(case, answer)
        if wrong:
            findings.append(f"{case.name} as {suffix}: {wrong}")
    return findings


def suffixes_for(case: Case) -> list[str]:
    from roughcontact.formats.read import SUFFIXES

    return sorted({*SUFFIXES, ".000"} - {case.name[case.name.rindex(".") :]})


def test_misnamed_files(case: Case, reader: Reader, tmp_path: Path) -> None:
    rng = np.random.default_rng(zlib.crc32(case.name.encode()))
    some = sorted(rng.choice(suffixes_for(case), 5, replace=False))
    findings = misnamed(reader, case, tmp_path, [str(suffix) for suffix in some])
    assert not findings, "\n".join(findings)


@pytest.mark.slow
def test_files_under_every_suffix(case: Case, reader: Reader, tmp_path: Path) -> None:
    findings = misnamed(reader, case, tmp_path, suffixes_for(case))
    assert not findings, "\n".join(findings)


@pytest.mark.parametrize(
    ("name", "changes", "words"),
    [
        # Scales that a reader replaces by 1 where their names are damaged.
        ("wyko_nt1100_test_1.opd", {26: 0x72}, "no block 'Mult'"),
        ("wyko_nt1100_test_1.opd", {736: 0x60}, "no block 'Aspect'"),
        # Grids and lengths that shear the map.
        ("metropro-1.dat", {53: 0x6C}, "camera frames take"),
        ("metropro-1.dat", {71: 0xB8}, "phases take"),
        ("dvd_afm.sur", {334: 0x11}, "heights end at byte"),
        ("made.sur", {334: 0x0C}, "heights end at byte"),
        ("uncd_afm.001", {23284: 0x33}, "the image has 513 × 512 points by its section"),
        ("made.npy", {61: 0x32}, "bytes of the file over"),
        ("made.sdf", {104: 0x32}, "announces 440 heights, but has 660"),
        # A length with which a reader never comes to where checksums are compared.
        ("x3p-2.x3p", {3236014: 0x5C, 1205: 0x40, 1084: 0x34}, "checksum of 'bindata/data.bin'"),
        # An origin in whose digits the heights are lost, and a step.
        ("mnt-1.mnt", {1586381: 0xE4}, "heights span 0 counts, not 22237587"),
        ("mnt-1.mnt", {1586315: 0x3B}, "heights span 0 counts, not 22237587"),
        # More bytes than any memory has.
        ("metropro-1.dat", {68: 0x82, 70: 0x81}, "cannot be read"),
        # A unit of no letters.
        ("made.sur", dict.fromkeys(range(180, 276), 0), "gives no unit"),
        # h5netcdf leaves half a file behind, which complains when it is collected.
        ("made.nc", {246: 0xA2}, ""),
        # A number that is none, of the kind that raises a signal.
        ("made.npy", {134: 0xF0, 135: 0x7F}, ""),
    ],
)
def test_what_was_found_before(
    name: str,
    changes: dict[int, int],
    words: str,
    cases: dict[str, Case],
    reader: Reader,
    tmp_path: Path,
) -> None:
    if name not in cases:
        pytest.skip(f"{name} or its reader is absent")
    case = cases[name]
    content = bytearray(case.content)
    for place, value in changes.items():
        content[place] = value
    path = tmp_path / name
    path.write_bytes(content)
    answer = reader.read(path, case.arguments)
    assert "raised" not in answer
    if words:
        assert words in str(answer.get("refused"))
        assert not wrong_in_message(case, answer)


@pytest.mark.parametrize("suffix", [".nc", ".datx"])
def test_hdf5_does_not_stand_still(
    suffix: str, cases: dict[str, Case], reader: Reader, tmp_path: Path
) -> None:
    if suffix == ".datx" and "made.sdf" not in cases:
        pytest.skip("the readers of instruments' files are absent")
    content = bytearray(cases["made.nc"].content)
    heap = content.index(b"GCOL")
    # The size of its first object, and what follows.
    content[heap + 24 : heap + 36] = bytes(12)
    path = tmp_path / f"made{suffix}"
    path.write_bytes(content)
    assert "the free space of a heap" in str(reader.read(path, {})["refused"])


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"import time; time.sleep(60)", "took more than"),
        (b"import os; os.kill(os.getpid(), 11)", "died with -11"),
        (b"import os; os.write(1, b'hello')", "printed b'hello"),
        (b"1 / 0", "ZeroDivisionError"),
        (b"bytes(5 * 2**30)", "MemoryError"),
    ],
)
def test_the_judge_sees_it(
    content: bytes, words: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    pytest.importorskip("resource")
    monkeypatch.setitem(globals(), "SECONDS", 4.0)
    (tmp_path / "sitecustomize.py").write_text(
        "import roughcontact.formats.read as f, pathlib\n"
        "f.read_surface = lambda path, **_: exec(pathlib.Path(path).read_text())\n"
    )
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    reader = Reader(tmp_path)
    path = tmp_path / "map.npy"
    path.write_bytes(content)
    try:
        assert words in str(reader.read(path, {})["raised"])
    finally:
        reader.close()


def test_the_judge_sees_other_scales(cases: dict[str, Case]) -> None:
    case = cases["made.npy"]
    original = case.stated(case.content)
    good = {"heights": original.heights, "pixel": original.pixel}
    assert finding(case, original, case.content, good) == ""
    dy, dx = original.pixel
    for wrong in (
        {"pixel": (dx, dy)},
        {"pixel": (dy * 1.001, dx)},
        {"heights": original.heights * 1.001},
        {"heights": original.heights[:-1]},
        {"heights": np.where(np.isnan(original.heights), 0, original.heights)},
        {"pixel": (1.0, 1.0)},
        {"heights": original.heights * 1e6},
    ):
        assert finding(case, original, case.content, good | wrong)
    # One damaged byte may change one height.
    content = bytearray(case.content)
    content[-1] ^= 1
    other = original.heights.copy()
    other[-1, -1] *= 2
    assert finding(case, original, bytes(content), good | {"heights": other}) == ""
    other[0, 0] *= 2
    assert finding(case, original, bytes(content), good | {"heights": other})
    for refused in ("two\nlines", "another.npy is bad", "made.npy (MemoryError)"):
        assert finding(case, original, case.content, {"refused": refused, "cause": ""})


if __name__ == "__main__":
    serve()
