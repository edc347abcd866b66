"""Samples of the files that maps are read from, each with a plain reading: to be damaged."""

import hashlib
import importlib.util
import io
import re
import struct
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import vendors
from plain import (
    Plain,
    plain_archive,
    plain_di,
    plain_hdf5,
    plain_headed,
    plain_metropro,
    plain_netcdf,
    plain_npy,
    plain_npz,
    plain_opd,
    plain_sdf,
    plain_sur,
    plain_text,
    plain_x3p,
)

MEASUREMENTS = Path(__file__).parents[1] / ".." / "shared" / "measurements"


@dataclass(frozen=True)
class Sample:
    """A file to damage.

    ``fields`` are the bytes that state grid and scale, ``stated`` the plain reading, and
    ``checked`` says that checksums in the file protect every height; ``structured`` is the plain
    reading for a file whose parts were moved by the library of its container.
    """

    name: str
    content: bytes
    stated: Callable[[bytes], Plain]
    fields: tuple[tuple[int, int], ...] = ()
    arguments: dict[str, str] = field(default_factory=dict)
    checked: bool = False
    structured: Callable[[bytes], Plain] | None = None


SIZE = (30e-6, 44e-6)


def made_map() -> np.ndarray:
    """Heights of 30 × 22 points [µm] with two holes."""
    heights = np.random.default_rng(4).normal(size=(30, 22)).round(4)
    heights[3, 5] = heights[20, 0] = np.nan
    return heights


def made(folder: Path) -> Iterator[Sample]:
    """Small files of every kind, made here."""
    heights = made_map()
    plain = Plain(heights * 1e-6, (1e-6, 2e-6))
    given = {"unit": "um", "size": "30 um x 44 um"}

    stream = io.BytesIO()
    np.save(stream, heights)
    content = stream.getvalue()
    yield Sample("made.npy", content, plain_npy(SIZE), ((0, 128),), given)
    stream = io.BytesIO()
    np.savez(stream, heights)
    # An archive has checksums: its heights may not change at all.
    stated = plain_archive(SIZE)
    yield Sample("made.npz", stream.getvalue(), stated, ((0, 200),), given, checked=True)
    for name, mark in (("made.csv", ","), ("made.txt", " "), ("made.asc", ";")):
        lines = [mark.join(f"{z:.4f}" for z in row) for row in heights]
        content = ("# made\n" + "\n".join(lines) + "\n").encode()
        yield Sample(name, content, plain_text(SIZE), ((0, 200),), given)

    import xarray

    axes = {
        name: (name, (np.arange(n) + 0.5) * e, {"units": "m"})
        for name, n, e in (("y", 30, 1e-6), ("x", 22, 2e-6))
    }
    for name, attributes in (("bare.nc", {}), ("made.nc", {"pixel_y": 1e-6, "pixel_x": 2e-6})):
        variable = (("y", "x"), plain.heights, {"units": "m"})
        data = xarray.Dataset({"height": variable}, coords=axes, attrs=attributes)
        data.to_netcdf(folder / name, engine="h5netcdf")
        content = (folder / name).read_bytes()
        # Superblock and headers, then the heap of texts and references.
        fields = [(0, 1000), (1000, 2000), (2000, 3000)]
        edges = (re.escape(struct.pack("<d", edge)) for edge in set(plain.pixel))
        starts = {found.start() for edge in edges for found in re.finditer(edge, content)}
        fields += [(start, start + 8) for start in starts]
        yield Sample(name, content, plain_netcdf(content, plain), tuple(fields))

    if importlib.util.find_spec("SurfaceTopography") is None:
        return
    header = {
        "ManufacID": "test",
        "CreateDate": "010120240000",
        "ModDate": "010120240000",
        "NumPoints": 22,
        "NumProfiles": 30,
        "Xscale": 2e-6,
        "Yscale": 1e-6,
        "Zscale": 1e-6,
        "Zresolution": -1,
        "Compression": 0,
        "DataType": 7,
        "CheckType": 0,
    }
    lines = ["aISO-1.0", *(f"{key} = {value}" for key, value in header.items()), "*"]
    lines += [" ".join("BAD" if np.isnan(z) else str(z) for z in row) for row in heights]
    content = ("\n".join([*lines, "*"]) + "\n").encode()
    yield Sample("made.sdf", content, plain_sdf, ((0, 250),))

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
            for member, inside in (("main.xml", text), ("bindata/data.bin", full.tobytes())):
                info = zipfile.ZipInfo(member, (2024, 1, 1, 0, 0, 0))
                info.compress_type = packing
                archive.writestr(info, inside)
        content = stream.getvalue()
        ends = ((0, 200), (len(content) - 200, len(content)))
        yield Sample(name, content, plain_x3p, ends, checked=True)

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
    yield Sample("made.sur", content, plain_sur, ((86, 136), (180, 292), (334, 338)))
    for name, make in {**vendors.MADE, "made.datx": lambda: vendors.datx(folder)}.items():
        content, stated, fields = make()
        yield Sample(name, content, stated, fields, checked=name.endswith("plux"))


def saved(folder: Path) -> Iterator[Sample]:
    """Files that the program writes of a map."""
    import roughcontact as rc

    surface = rc.Surface(made_map() * 1e-6, (1e-6, 2e-6), rc.Provenance("made"))
    for suffix, stated, fields in (
        (".nc", plain_hdf5, ((0, 3000),)),
        (".npz", plain_npz, ((0, 200),)),
        (".csv", plain_headed, ((0, 140),)),
        (".x3p", plain_x3p, ((0, 200),)),
        (".sur", plain_sur, ((86, 136), (180, 292), (334, 338))),
    ):
        if suffix in (".x3p", ".sur") and importlib.util.find_spec("SurfaceTopography") is None:
            continue
        path = folder / f"saved{suffix}"
        surface.save(path)
        content = undated(path.read_bytes()) if suffix == ".x3p" else path.read_bytes()
        yield Sample(path.name, content, stated, fields, checked=suffix in (".nc", ".npz", ".x3p"))


def undated(content: bytes) -> bytes:
    """Return an X3P file of a fixed day: the same bytes in every run."""
    stream = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(content)) as old, zipfile.ZipFile(stream, "w") as new:
        members = {info.filename: old.read(info) for info in old.infolist()}
        day = re.sub(rb"Date>\d[^<]*<", b"Date>2024-01-01T00:00:00<", members["main.xml"])
        word = hashlib.md5(day).hexdigest().encode()
        members |= {"main.xml": day, "md5checksum.hex": word + b" *main.xml\n"}
        for name, inside in members.items():
            info = zipfile.ZipInfo(name, (2024, 1, 1, 0, 0, 0))
            info.compress_type = zipfile.ZIP_DEFLATED
            new.writestr(info, inside)
    return stream.getvalue()


def measured() -> Iterator[Sample]:
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
                    content,
                    re.IGNORECASE,
                )
            )
        if name.endswith("x3p"):
            fields = (*fields, (len(content) - 300, len(content)))
        checked = name.endswith((".x3p", ".mnt"))
        yield Sample(name, content, stated, fields, checked=checked)
