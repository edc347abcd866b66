"""Small files of vendors of whom no measurement is at hand, with a plain reading of each.

They are written after the layouts that Gwyddion and SurfaceTopography document.
"""

import io
import re
import struct
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from plain import LENGTHS, InconsistentError, Plain

# A grid and a pixel [m] of unequal sides; heights in steps of 0.1 nm.
SHAPE, PIXEL, STEP = (30, 22), (1e-6, 2e-6), 1e-10


def heights() -> np.ndarray:
    """Return a map [m]."""
    return np.random.default_rng(6).integers(-9000, 9000, SHAPE) * STEP


@dataclass(frozen=True)
class Head:
    """Numbers and bytes in a row, some of them by name."""

    content: bytes
    places: dict[str, tuple[int, str]]

    @classmethod
    def from_parts(cls, *parts: tuple[str, str, object]) -> "Head":
        content, places = b"", {}
        for name, kind, value in parts:
            places[name] = (len(content), kind)
            content += struct.pack(kind, value) if value is not None else bytes(int(kind))
        return cls(content, {name: place for name, place in places.items() if name})

    def numbers(self, content: bytes) -> dict[str, float]:
        return {
            name: struct.unpack_from(kind, content, at)[0]
            for name, (at, kind) in self.places.items()
        }

    @property
    def fields(self) -> tuple[tuple[int, int], ...]:
        return tuple((at, at + struct.calcsize(kind)) for at, kind in self.places.values())


def grid(content: bytes, kind: str, shape: tuple[int, int], start: int = 0) -> np.ndarray:
    """Return the numbers of a map from a byte on, in double precision."""
    return np.frombuffer(content, kind, shape[0] * shape[1], start).reshape(shape).astype(float)


def raster(content: bytes, kind: str, found: dict[str, float], start: int) -> np.ndarray:
    return grid(content, kind, (int(found["ny"]), int(found["nx"])), start)


Made = tuple[bytes, Callable[[bytes], Plain], tuple[tuple[int, int], ...]]


def tmd() -> Made:
    head = Head.from_parts(
        ("", "<32s", b"Binary TrueMap Data File v2.0\r\n"),
        ("", "<24s", b"Created by TrueMap v6"),
        ("nx", "<I", SHAPE[1]),
        ("ny", "<I", SHAPE[0]),
        ("lx", "<f", 1e3 * SHAPE[1] * PIXEL[1]),
        ("ly", "<f", 1e3 * SHAPE[0] * PIXEL[0]),
        ("", "8", None),
    )

    def stated(content: bytes) -> Plain:
        n = head.numbers(content)
        values = raster(content, "<f4", n, len(head.content))
        return Plain(values * 1e-3, (n["ly"] / n["ny"] * 1e-3, n["lx"] / n["nx"] * 1e-3))

    return head.content + (heights() * 1e3).astype("<f4").tobytes(), stated, head.fields


def os3d() -> Made:
    head = Head.from_parts(
        ("", "<10s", b"OmniSurf3D"),
        ("major", "<i", 1),
        ("minor", "<i", 0),
        ("word", "<I", 4),
        ("", "<4s", b"made"),
        ("date", "<I", 4),
        ("", "<4s", b"2024"),
        ("nx", "<i", SHAPE[1]),
        ("ny", "<i", SHAPE[0]),
        ("dx", "<d", 1e6 * PIXEL[1]),
        ("dy", "<d", 1e6 * PIXEL[0]),
        ("", "16", None),
    )

    def stated(content: bytes) -> Plain:
        # Two texts with their lengths precede the numbers.
        at = 18
        for _ in range(2):
            (length,) = struct.unpack_from("<I", content, at)
            at += 4 + length
        nx, ny, dx, dy = struct.unpack_from("<iidd", content, at)
        values = grid(content, "<f4", (ny, nx), at + 40) * 1e-6
        return Plain(np.where(values < -3e32, np.nan, values), (dy * 1e-6, dx * 1e-6))

    return head.content + (heights() * 1e6).astype("<f4").tobytes(), stated, head.fields


def nms() -> Made:
    values = heights() * 1e6
    low, high = values.min(), values.max()
    head = Head.from_parts(
        ("", "16", None),
        ("low", "<d", low),
        ("high", "<d", high),
        ("", "1336", None),
        ("nx", "<I", SHAPE[1]),
        ("ny", "<I", SHAPE[0]),
        ("dx", "<d", 1e3 * PIXEL[1]),
        ("dy", "<d", 1e3 * PIXEL[0]),
        ("", "2076", None),
    )
    counts = np.rint((values - low) / (high - low) * 65534).astype("<u2")

    def stated(content: bytes) -> Plain:
        n = head.numbers(content)
        counts = raster(content, "<u2", n, len(head.content))
        values = counts / 65534 * (n["high"] - n["low"]) + n["low"]
        return Plain(values * 1e-6, (n["dy"] * 1e-3, n["dx"] * 1e-3))

    return head.content + counts.tobytes(), stated, head.fields


def zmg() -> Made:
    head = Head.from_parts(
        ("", "<16s", b"Zeta-Instruments"),
        ("", "69", None),
        ("nx", "<I", SHAPE[1]),
        ("ny", "<I", SHAPE[0]),
        ("", "4", None),
        ("dx", "<f", 1e6 * PIXEL[1]),
        ("dy", "<f", 1e6 * PIXEL[0]),
        ("dz", "<f", 1e6 * STEP),
        ("", "8", None),
        ("comment", "<I", 0),
        ("", "84", None),
    )

    def stated(content: bytes) -> Plain:
        n = head.numbers(content)
        values = raster(content, "<u2", n, len(head.content) + int(n["comment"]))
        return Plain(values * n["dz"] * 1e-6, (n["dy"] * 1e-6, n["dx"] * 1e-6))

    counts = np.rint(heights() / STEP + 9000).astype("<u2")
    return head.content + counts.tobytes(), stated, head.fields


def plu() -> Made:
    head = Head.from_parts(
        ("", "<128s", b"Tue Jan  2 10:20:30 2024"),
        ("", "4", None),
        ("", "256", None),
        ("", "<I", SHAPE[0]),
        ("", "<I", SHAPE[1]),
        ("", "8", None),
        ("dx", "<f", 1e6 * PIXEL[1]),
        ("dy", "<f", 1e6 * PIXEL[0]),
        ("", "16", None),
        ("type", "<I", 3),
        ("", "12", None),
        ("area", "<I", 1),
        ("", "20", None),
        ("", "20", None),
        ("", "<B", 0),
        ("layers", "<B", 1),
        ("", "<B", 0),
        ("", "<B", 1),
        ("images", "<B", 0),
        ("", "7", None),
        ("ny", "<I", SHAPE[0]),
        ("nx", "<I", SHAPE[1]),
    )

    def stated(content: bytes) -> Plain:
        n = head.numbers(content)
        values = raster(content, "<f4", n, len(head.content))
        values[values == 1000001] = np.nan
        return Plain(values * 1e-6, (n["dy"] * 1e-6, n["dx"] * 1e-6))

    values = (heights() * 1e6).astype("<f4")
    values[4, 7] = 1000001
    tail = struct.pack("<ff", values.min(), 1.0)
    return head.content + values.tobytes() + tail, stated, head.fields


def vk4() -> Made:
    # Four letters, versions, offsets with one more, and the numbers of the measurement.
    numbers = 12 + 4 * 17 + 4
    image = numbers + 4 * 80
    words = {38: 0, 42: 1e12 * PIXEL[1], 43: 1e12 * PIXEL[0], 44: 1e12 * STEP, 1: 2024, 2: 1, 3: 2}
    offsets = [0] * 17
    offsets[6] = image
    content = b"VK4_" + bytes(8) + struct.pack("<17I", *offsets) + bytes(4)
    content += b"".join(struct.pack("<I", round(words.get(n, 0))) for n in range(80))
    ny, nx = SHAPE
    content += struct.pack("<7I", nx, ny, 32, 0, 4 * nx * ny, 0, 0) + bytes(768)
    content += np.rint(heights() / STEP + 9000).astype("<u4").tobytes()

    def stated(content: bytes) -> Plain:
        (at,) = struct.unpack_from("<I", content, 12 + 4 * 6)
        dx, dy, dz = struct.unpack_from("<3I", content, numbers + 4 * 42)
        nx, ny, bits = struct.unpack_from("<3I", content, at)
        kind = {8: "<u1", 16: "<u2", 32: "<u4"}[bits]
        values = grid(content, kind, (ny, nx), at + 28 + 768)
        return Plain(values * dz * 1e-12, (dy * 1e-12, dx * 1e-12))

    fields = ((12, 12 + 68), (numbers + 168, numbers + 180), (image, image + 28))
    return content, stated, fields


def al3d() -> Made:
    ny, nx = SHAPE
    tags = {
        "Cols": nx,
        "Rows": ny,
        "PixelSizeXMeter": PIXEL[1],
        "PixelSizeYMeter": PIXEL[0],
        "InvalidPixelValue": -1e30,
    }
    start = 17 + 52 * (3 + len(tags)) + 256
    tags["DepthImageOffset"] = start

    def line(key: str, value: object) -> bytes:
        return struct.pack("20s30s2s", key.encode(), str(value).encode(), b"\r\n")

    head = b"AliconaImaging\0\r\n" + line("Version", 1) + line("TagCount", len(tags))
    head += b"".join(line(key, value) for key, value in tags.items()) + bytes(256)
    values = heights().astype("<f4")
    values[2, 3] = -1e30

    def stated(content: bytes) -> Plain:
        count = int(content[17 + 52 + 20 : 17 + 52 + 50].rstrip(b"\0 "))
        found = {}
        for n in range(count):
            entry = content[17 + 52 * (2 + n) :][:52]
            found[entry[:20].strip(b"\0 ").decode("latin-1")] = entry[20:50].strip(b"\0 ")
        ny, nx = int(found["Rows"]), int(found["Cols"])
        wide = (4 * nx + 7) // 8 * 2
        start = int(found["DepthImageOffset"])
        values = (
            np.frombuffer(content, "<f4", ny * wide, start).reshape(ny, wide).astype(float)[:, :nx]
            * 1.0
        )
        absent = float(found["InvalidPixelValue"])
        values[np.abs(values - absent) < 1.5e-7 * abs(absent)] = np.nan
        pixel = float(found["PixelSizeYMeter"]), float(found["PixelSizeXMeter"])
        return Plain(values, pixel)

    return head + values.tobytes(), stated, ((17, start - 256),)


def bcr() -> Made:
    ny, nx = SHAPE
    words = {
        "fileformat": "bcrstm",
        "headersize": 2048,
        "xpixels": nx,
        "ypixels": ny,
        "xlength": 1e9 * nx * PIXEL[1],
        "ylength": 1e9 * ny * PIXEL[0],
        "xunit": "nm",
        "yunit": "nm",
        "zunit": "nm",
        "bit2nm": 1e9 * STEP,
        "intelmode": 1,
    }
    text = "".join(f"{key} = {value}\n" for key, value in words.items()).encode()
    counts = np.rint(heights() / STEP).astype("<i2")
    counts[5, 6] = 32767

    def stated(content: bytes) -> Plain:
        size = 2048
        for _ in range(2):
            lines = content[:size].decode("latin-1").split("\n")
            pairs = (line.partition("=") for line in lines if not line.startswith(("%", "#")))
            found = {key.strip(): value.strip() for key, mark, value in pairs if mark}
            size = int(found.get("headersize", 2048))
        ny, nx = int(found["ypixels"]), int(found["xpixels"])
        order = "<" if int(found.get("intelmode", 1)) else ">"
        if found["fileformat"] == "bcrf":
            values = grid(content, f"{order}f4", (ny, nx), size) * 1.0
            values[~(values <= 1.7e38)] = np.nan
            scale = 1.0
        else:
            values = grid(content, f"{order}i2", (ny, nx), size) * 1.0
            values[values == 32767] = np.nan
            scale = float(found.get("bit2nm", 1))
        x, z = (LENGTHS[found.get(f"{axis}unit", "nm").encode("latin-1")] for axis in "xz")
        pixel = float(found["ylength"]) * x / ny, float(found["xlength"]) * x / nx
        return Plain(values * scale * z, pixel)

    return text.ljust(2048, b"\0") + counts.tobytes(), stated, ((0, len(text)),)


def wsxm() -> Made:
    ny, nx = SHAPE
    body = (
        f"[Control]\r\nX Amplitude: {1e9 * nx * PIXEL[1]} nm\r\n"
        f"Y Amplitude: {1e9 * ny * PIXEL[0]} nm\r\n\r\n[General Info]\r\n"
        f"Image Data Type: double\r\nNumber of columns: {nx}\r\nNumber of rows: {ny}\r\n"
        "Z Amplitude: 1800 nm\r\n\r\n[Miscellaneous]\r\nMaximum: 900\r\nMinimum: -900\r\n\r\n"
        "[Header end]\r\n"
    ).encode("latin-1")
    head = b"WSxM file copyright Nanotec Electronica\r\nSxM Image file\r\nImage header size: %d\r\n"
    size = len(head) + len(body)
    content = head % size + body

    def stated(content: bytes) -> Plain:
        head, mark, data = content.partition(b"[Header end]\r\n")
        if not mark:
            head, mark, data = content.partition(b"[Header end]\n")
        pairs = [line.partition(b":")[::2] for line in head.splitlines()]
        found = {key.strip(): value.strip() for key, value in pairs}
        ny, nx = int(found[b"Number of rows"]), int(found[b"Number of columns"])
        kind = {b"double": "<f8", b"float": "<f4"}[found[b"Image Data Type"]]
        values = grid(data, kind, (ny, nx))[::-1, ::-1]
        sides = []
        for key in (b"Y Amplitude", b"X Amplitude"):
            value, unit = found.get(key, found[b"X Amplitude"]).split(b" ")
            sides.append(float(value) * LENGTHS[unit])
        metre = LENGTHS[found[b"Z Amplitude"].split(b" ")[-1]]
        return Plain(values * metre, (sides[0] / ny, sides[1] / nx))

    return content + (heights() * 1e9).astype("<f8").tobytes(), stated, ((0, size),)


def mi() -> Made:
    ny, nx = SHAPE
    words = (
        ("fileType", "Image"),
        ("xPixels", nx),
        ("yPixels", ny),
        ("xLength", nx * PIXEL[1]),
        ("yLength", ny * PIXEL[0]),
        ("bufferLabel", "Topography"),
        ("bufferUnit", "um"),
        ("bufferRange", 3.2768),
        ("data", "BINARY"),
    )
    text = "".join(f"{key:14}{value}\n" for key, value in words).encode()

    def stated(content: bytes) -> Plain:
        at, found = 0, {}
        while "data" not in found:
            end = content.index(b"\n", at)
            line = content[at:end].decode("utf-8", "replace")
            if line[:1] != " ":
                found[line[:14].strip()] = line[14:].strip()
            at = end + 1
        ny, nx = int(found["yPixels"]), int(found["xPixels"])
        wide = found["data"] == "BINARY_32"
        values = (
            np.frombuffer(content, "<i4" if wide else "<i2", nx * ny, at)
            .reshape(ny, nx)
            .astype(float)
        )
        scale = float(found["bufferRange"]) / (2147483648 if wide else 32768)
        metre = LENGTHS[found["bufferUnit"].encode("latin-1")]
        pixel = float(found["yLength"]) / ny, float(found["xLength"]) / nx
        return Plain(values[::-1] * scale * metre, pixel)

    counts = np.rint(heights() / STEP).astype("<i2")
    return text + counts.tobytes(), stated, ((0, len(text)),)


def gwy() -> Made:
    ny, nx = SHAPE

    def component(name: str, kind: str, value: bytes) -> bytes:
        return name.encode() + b"\0" + kind.encode() + value

    def item(name: str, *parts: bytes) -> bytes:
        body = b"".join(parts)
        return name.encode() + b"\0" + struct.pack("<I", len(body)) + body

    unit = item("GwySIUnit", component("unitstr", "s", b"m\0"))
    data = struct.pack("<I", nx * ny) + heights().astype("<f8").tobytes()
    field = item(
        "GwyDataField",
        component("xres", "i", struct.pack("<i", nx)),
        component("yres", "i", struct.pack("<i", ny)),
        component("xreal", "d", struct.pack("<d", nx * PIXEL[1])),
        component("yreal", "d", struct.pack("<d", ny * PIXEL[0])),
        component("si_unit_xy", "o", unit),
        component("si_unit_z", "o", unit),
        component("data", "D", data),
    )
    content = b"GWYP" + item(
        "GwyContainer",
        component("/0/data", "o", field),
        component("/0/data/title", "s", b"Topography\0"),
    )
    start = content.index(data) + 4

    def stated(content: bytes) -> Plain:
        def value(name: bytes, kind: str) -> float:
            at = content.index(name + b"\0" + (b"d" if kind == "<d" else b"i"))
            return struct.unpack_from(kind, content, at + len(name) + 2)[0]

        nx, ny = int(value(b"xres", "<i")), int(value(b"yres", "<i"))
        at = content.index(b"data\0D") + 6
        (count,) = struct.unpack_from("<I", content, at)
        values = np.frombuffer(content, "<f8", count, at + 4).reshape(ny, nx)
        metres = [
            LENGTHS[content[found.end() :].split(b"\0")[0]]
            for found in re.finditer(rb"unitstr\0s", content)
        ]
        # A size below zero counts without its sign.
        sides = abs(value(b"yreal", "<d")), abs(value(b"xreal", "<d"))
        return Plain(values * metres[1], (sides[0] / ny * metres[0], sides[1] / nx * metres[0]))

    return content, stated, ((0, start), (len(content) - 40, len(content)))


def plux() -> Made:
    ny, nx = SHAPE
    index = (
        f"<xml><GENERAL><IMAGE_SIZE_X>{nx}</IMAGE_SIZE_X><IMAGE_SIZE_Y>{ny}</IMAGE_SIZE_Y>"
        f"<FOV_X>{1e6 * PIXEL[1]}</FOV_X><FOV_Y>{1e6 * PIXEL[0]}</FOV_Y>"
        "<DATE>2024-01-02 10:20:30</DATE></GENERAL><LAYER_0><FILENAME_Z>LAYER_0.raw</FILENAME_Z>"
        "</LAYER_0><INFO><ITEM_0><NAME>Device</NAME><VALUE>S neox</VALUE></ITEM_0></INFO></xml>"
    )
    values = (heights() * 1e6).astype("<f4")
    values[1, 2] = np.nan
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, inside in (("index.xml", index.encode()), ("LAYER_0.raw", values.tobytes())):
            archive.writestr(zipfile.ZipInfo(name, (2024, 1, 1, 0, 0, 0)), inside)

    def stated(content: bytes) -> Plain:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            text = archive.read("index.xml").decode()

            def word(tag: str) -> str:
                return re.search(rf"<{tag}>(.*?)</{tag}>", text, re.DOTALL)[1]

            nx, ny = int(word("IMAGE_SIZE_X")), int(word("IMAGE_SIZE_Y"))
            data = archive.read(word("FILENAME_Z"))
        values = grid(data, "<f4", (ny, nx)) * 1e-6
        return Plain(values, (float(word("FOV_Y")) * 1e-6, float(word("FOV_X")) * 1e-6))

    return stream.getvalue(), stated, ()


_CONVERTER = np.dtype([("Category", "S16"), ("BaseUnit", "S16"), ("Parameters", "<f8", (4,))])


def datx(folder: Path) -> Made:
    path = folder / "vendor.h5"
    rows = [
        ("Root", "Measurement", "{M}"),
        ("{M}", "Surface", "{S}"),
        ("{S}", "Path", "/Data/Surface/one"),
    ]
    with h5py.File(path, "w") as file:
        file["MetaData"] = np.array(rows, [("Source", "S32"), ("Link", "S32"), ("Target", "S32")])
        surface = file.create_dataset("Data/Surface/one", data=heights() * 1e9)
        surface.attrs["Unit"] = np.array([b"NanoMeters"])
        surface.attrs["No Data"] = np.array([1e300])
        for axis, edge in (("X", PIXEL[1]), ("Y", PIXEL[0])):
            converter = np.array([(b"LateralCat", b"Pixels", (0, edge, 0, 0))], _CONVERTER)
            surface.attrs[f"{axis} Converter"] = converter
        surface.attrs["Z Converter"] = np.array(
            [(b"HeightCat", b"NanoMeters", (0, 1, 0, 0))], _CONVERTER
        )

    def stated(content: bytes) -> Plain:
        with h5py.File(io.BytesIO(content), "r") as file:
            surface = file["/Data/Surface/one"]
            if surface.external or surface.is_virtual:
                raise InconsistentError("the heights are in another file")
            values = surface[()] * 1e-9
            absent = surface.attrs.get("No Data")
            edges = [surface.attrs[f"{axis} Converter"][0][-1][1] for axis in "YX"]
            if surface.attrs["Unit"][0] not in (b"NanoMeters", "NanoMeters"):
                raise InconsistentError("another unit")
        if absent is not None:
            values = np.where(values == np.ravel(absent)[0] * 1e-9, np.nan, values)
        return Plain(np.where(np.isfinite(values), values, np.nan), (edges[0], edges[1]))

    return path.read_bytes(), stated, ((0, 2000),)


MADE: dict[str, Callable[[], Made]] = {
    "made.tmd": tmd,
    "made.os3d": os3d,
    "made.nms": nms,
    "made.zmg": zmg,
    "made.plu": plu,
    "made.vk4": vk4,
    "made.al3d": al3d,
    "made.bcr": bcr,
    "made.stp": wsxm,
    "made.mi": mi,
    "made.gwy": gwy,
    "made.plux": plux,
}
