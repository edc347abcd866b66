"""Objects that the tests of formats write: a map, a contact, two bodies, a volume."""

import base64
import importlib.util
import struct
import zlib
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import roughcontact as rc
from roughcontact.material.hardening import Linear

MEASUREMENTS = Path(__file__).parents[1] / ".." / "shared" / "measurements"

# ny ≠ nx and dy ≠ dx, neither of them a binary fraction.
SHAPE, PIXEL = (23, 36), (0.7e-6, 0.9e-6)
STEEL = rc.Material(young=210e9, poisson=0.3, yield_strength=1e9)

HAS_READER = importlib.util.find_spec("SurfaceTopography") is not None

EXACT = (".npz", ".nc", ".x3p", ".csv")
READABLE = (*EXACT, ".sur")
SURFACE_SUFFIXES = (*READABLE, ".vti")
RESULT_SUFFIXES = (".nc", ".vti", ".csv", ".json")
VOLUME_SUFFIXES = (".nc", ".vtr", ".vti", ".csv", ".json")


def rough(holes: bool = True) -> rc.Surface:
    heights = rc.self_affine(
        SHAPE, PIXEL, rms_height=0.1e-6, rolloff_wavelength=9e-6, cutoff_wavelength=2e-6, rng=5
    )
    if holes:
        heights = heights.copy()
        heights[3:5, 7:10] = np.nan
        heights[0, 0] = heights[-1, -1] = np.nan
    about = rc.Provenance("ground.opd", "Wyko NT1100", "Raw", ("leveled: plane", "second step"))
    return rc.Surface(heights, PIXEL, about)


@cache
def contact() -> rc.ContactResult:
    found = rc.solve(rough().masked(), material=STEEL, load=0.15)
    assert found.saturated.any()
    assert found.contact.sum() > found.saturated.sum()
    return found


@cache
def two_bodies() -> rc.ContactResult:
    """Two measured bodies, and a ceiling of each pixel, infinite in places."""
    ceiling = np.full(SHAPE, 3e9)
    ceiling[:, 18:] = np.inf
    counter = rc.Surface(rough(False).heights[::-1] / 2, PIXEL, rc.Provenance("other.opd"))
    return rc.solve(
        rough(False), counter_surface=counter, material=STEEL, ceiling=ceiling, load=0.1
    )


def assert_same_bits(one: np.ndarray, two: np.ndarray) -> None:
    assert one.dtype == two.dtype
    np.testing.assert_array_equal(np.isnan(one), np.isnan(two))
    # A zero keeps its sign; only the payload of NaN means nothing.
    assert np.nan_to_num(one).tobytes() == np.nan_to_num(two).tobytes()


def saved_and_read(surface: rc.Surface, path: Path) -> rc.Surface:
    surface.save(path)
    if path.suffix in (".x3p", ".sur") and not HAS_READER:
        pytest.skip("SurfaceTopography is absent")
    return rc.read_surface(path)


def sur_fields(path: Path) -> dict[str, Any]:
    """Bytes at fixed places, as Gwyddion's surffile.c lists them."""
    content = path.read_bytes()
    fields = dict(
        zip(
            ("bits", "zmin", "zmax", "nx", "ny", "points", "dx", "dy", "dz"),
            struct.unpack_from("<H5i3f", content, 98),
            strict=True,
        )
    )
    fields["special"], fields["absolute"] = struct.unpack_from("<2H", content, 86)
    fields["words"] = [content[132 + 16 * n :][:16] for n in range(9)]
    fields["comment"], fields["private"] = struct.unpack_from("<2H", content, 334)
    fields["offsets"] = struct.unpack_from("<3f", content, 466)
    fields["data"] = np.frombuffer(content, "<i4", offset=512).reshape(fields["ny"], fields["nx"])
    return fields


VOLUME_SHAPE = (20, 16)


@cache
def volume() -> rc.ElastoplasticResult:
    """Two balls that yield, in a volume that extends beyond the map."""
    y, x = (
        edge * (np.arange(n) - (n - 1) / 2) for edge, n in zip(PIXEL, VOLUME_SHAPE, strict=True)
    )
    ball = rc.Surface(-(y[:, None] ** 2 + x**2) / (2 * 50e-6), PIXEL)
    hard, soft = (
        replace(STEEL, yield_strength=None, hardening=Linear(strength, 50e9))
        for strength in (1e9, 0.7e9)
    )
    found = rc.solve_elastoplastic(
        ball, material=hard, counter_material=soft, increments=1, loads=[0.25], tolerance=1e-3
    )
    assert found.bodies[0].margin > 0
    return found


def vtk_image(
    path: Path, kind: str = "ImageData", groups: tuple[str, ...] = ("PointData",)
) -> tuple[ElementTree.Element, dict[str, np.ndarray]]:
    """Return the head of a VTK file and its arrays, by the description of the format."""
    root = ElementTree.parse(path).getroot()
    assert root.attrib == {
        "type": kind,
        "version": "1.0",
        "byte_order": "LittleEndian",
        "header_type": "UInt64",
        "compressor": "vtkZLibDataCompressor",
    }
    image, appended = root.find(kind), root.find("AppendedData")
    assert image is not None
    assert appended is not None
    assert appended.attrib == {"encoding": "base64"}
    text = (appended.text or "").strip()
    assert text[0] == "_"
    arrays = {}
    assert [group.tag for group in image.iterfind("Piece/*")] == list(groups)
    for entry in image.iterfind("Piece/*/DataArray"):
        rest = text[1 + int(entry.attrib["offset"]) :]
        # Base64 comes in fours: the count of blocks gives the length of the table.
        (count,) = struct.unpack("<Q", base64.b64decode(rest[:12])[:8])
        letters = (8 * (3 + count) + 2) // 3 * 4
        table = struct.unpack(f"<{3 + count}Q", base64.b64decode(rest[:letters], validate=True))
        sizes = table[3:]
        data = rest[letters : letters + (sum(sizes) + 2) // 3 * 4]
        packed = base64.b64decode(data, validate=True)
        assert len(packed) == sum(sizes)
        blocks = []
        for size in sizes:
            blocks.append(zlib.decompress(packed[:size]))
            packed = packed[size:]
        assert all(len(block) == table[1] for block in blocks[:-1])
        assert len(blocks[-1]) == (table[2] or table[1])
        number = {"Float64": "<f8", "Float32": "<f4", "UInt8": "u1"}[entry.attrib["type"]]
        arrays[entry.attrib["Name"]] = np.frombuffer(b"".join(blocks), number)
    return image, arrays


MAPS = {"height", "initial_gap", "pressure", "gap", "contact", "saturated", "residual_indentation"}
