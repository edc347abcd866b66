"""Profiles in files of instruments, written after the layouts that SurfaceTopography documents."""

import io
import struct
import zipfile

import numpy as np
import openpyxl
import pytest

import roughcontact as rc
from reading import needs_reader
from roughcontact.formats import metrology

pytestmark = needs_reader

# Points, their distance [m] and heights [m].
POINTS, SPACING = 60, 5e-7
HEIGHTS = 1e-9 * np.random.default_rng(9).integers(-900, 900, POINTS)


def name(text):
    return struct.pack("<I", len(text.encode())) + text.encode()


def sized(content):
    return b"\4" + struct.pack("<I", len(content)) + content


def item(label, kind, content):
    return name(label) + bytes([kind]) + content


def container(label, *items):
    # Two bytes of unknown purpose end it, behind an item that ends the list.
    return item(label, 0x7D, sized(b"".join(items) + name("") + b"\x7f" + b"\xff\xff"))


def unit(value, symbol):
    return sized(name(symbol) + name(symbol) + struct.pack("<d", value) + bytes(12))


def opdx():
    text = "Surface Profile"
    listed = name("StringList") + sized(name("Raw"))
    about = container(
        "MetaData",
        item("DataKind", 0x12, sized(text.encode())),
        container("1D_Channels", item("Height", 0x42, listed)),
    )
    array = name("DoubleArray") + sized(bytes(5) + (1e9 * HEIGHTS).astype("<f8").tobytes())
    data = container(
        "1D_Data",
        container(
            "Raw",
            item("DataKind", 0x12, sized(b"Height")),
            item("NumPoints", 0x07, struct.pack("<I", POINTS)),
            # From the first point to the last.
            item("Extent", 0x18, unit(1e6 * SPACING * (POINTS - 1), "um")),
            item("DataScale", 0x18, unit(1.0, "nm")),
            item("Array", 0x40, array),
        ),
    )
    return b"VCA DATA\1\0\0\x55" + about + data + name("") + b"\x7f"


def prf(position=None):
    x = 1e3 * (SPACING * np.arange(POINTS) if position is None else position)
    head = b"[p3dlin]".ljust(0x14, b"\0") + struct.pack("<i", POINTS)
    text = b">DateTime=2026-03-20  02:44:41"
    table = struct.pack("<ii", 1, len(text)) + text
    marks = b"[sellsg]" + bytes(9) + b"[Trajec]" + bytes(41)
    arrays = [x.astype("<f8"), np.zeros(POINTS), (1e3 * HEIGHTS).astype("<f8")]
    flags = np.zeros(POINTS, "<f4")
    return (
        head.ljust(0xC4, b"\0")
        + table
        + marks
        + b"".join(a.tobytes() for a in arrays)
        + flags.tobytes()
    )


def qep(position=None):
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr("Kontur1.prf", prf(position))
    return packed.getvalue()


def xlsx():
    book = openpyxl.Workbook()
    data, certificate = book.active, book.create_sheet("Certificate")
    data.title = "DATA"
    data["A1"] = "Ra 0.1 um"
    for row in range(POINTS):
        data.cell(row + 1, 5, 1e3 * SPACING * (row + 1))
        data.cell(row + 1, 6, 1e6 * HEIGHTS[row])
    certificate["E2"], certificate["E48"] = "20 March 2024", "0.8mm"
    packed = io.BytesIO()
    book.save(packed)
    return packed.getvalue()


@pytest.mark.parametrize(
    ("file", "made", "instrument"),
    [
        ("trace.opdx", opdx, "Dektak OPDx (Bruker)"),
        ("trace.qep", qep, "Mahr"),
        ("trace.prf", prf, "Mahr"),
        ("trace.xlsx", xlsx, "Mitutoyo"),
    ],
)
def test_a_profile_of_an_instrument(tmp_path, file, made, instrument):
    path = tmp_path / file
    path.write_bytes(made())
    surface = rc.read_surface(path)
    assert surface.is_profile
    assert surface.pixel[1] == pytest.approx(SPACING, rel=1e-9)
    np.testing.assert_allclose(surface.heights[0], HEIGHTS, atol=1e-15)
    assert instrument in surface.provenance.instrument
    (channel,) = rc.formats.read.channels(path)
    assert channel.is_height
    assert channel.shape == (1, POINTS)
    assert rc.solve(surface, material=rc.Material(210e9, 0.3), load=1.0).converged


def test_uneven_positions_of_instrument_add_step(tmp_path):
    position = np.sort(SPACING * (np.arange(POINTS) + np.random.default_rng(1).random(POINTS) / 2))
    path = tmp_path / "trace.qep"
    path.write_bytes(qep(position))
    surface = rc.read_surface(path)
    assert surface.is_profile
    (note,) = surface.provenance.steps
    assert f"{POINTS} points" in note
    assert "linear interpolation" in note


def test_one_row_of_an_x3p_is_a_profile(tmp_path):
    path = tmp_path / "trace.x3p"
    metrology.save_x3p(rc.Surface(HEIGHTS, SPACING), path)
    surface = rc.read_surface(path)
    assert surface.is_profile
    assert surface.pixel == (1.0, pytest.approx(SPACING, rel=1e-9))
    np.testing.assert_allclose(surface.heights[0], HEIGHTS, atol=1e-20)


def test_invalid_mahr_profile_raises_format_error(tmp_path):
    path = tmp_path / "trace.prf"
    path.write_bytes(b"PRF 1 2\nmm 1.0\n" * 9)
    with pytest.raises(rc.FormatError, match=r"trace\.prf cannot be read as format 'qep'"):
        rc.read_surface(path)
