import hashlib
import re
import struct
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import roughcontact as rc
from reading import measurement
from roughcontact.formats import metrology, source
from written import (
    HAS_READER,
    MEASUREMENTS,
    PIXEL,
    SHAPE,
    SURFACE_SUFFIXES,
    assert_same_bits,
    rough,
    sur_fields,
)


def tags(element: ElementTree.Element) -> list[Any]:
    return [(child.tag, tags(child)) for child in element]


def test_x3p_after_the_standard(tmp_path: Path) -> None:
    surface = rough()
    surface.save(tmp_path / "map.x3p")
    with zipfile.ZipFile(tmp_path / "map.x3p") as archive:
        assert archive.testzip() is None
        names = [entry.filename for entry in archive.infolist()]
        content = {name: archive.read(name) for name in names}
    # As `md5sum main.xml > md5checksum.hex` writes it, with the mark of a binary file.
    digest = hashlib.md5(content["main.xml"]).hexdigest()
    assert content["md5checksum.hex"] == f"{digest} *main.xml\n".encode()
    root = ElementTree.fromstring(content["main.xml"])
    assert root.tag == "{http://www.opengps.eu/2008/ISO5436_2}ISO5436_2"

    def text(path: str) -> str:
        found = root.findtext(path)
        assert found is not None
        return found

    assert text("Record1/FeatureType") == "SUR"
    for axis, edge in (("CX", PIXEL[1]), ("CY", PIXEL[0])):
        assert text(f"Record1/Axes/{axis}/AxisType") == "I"
        assert float(text(f"Record1/Axes/{axis}/Increment")) == edge
        assert float(text(f"Record1/Axes/{axis}/Offset")) == 0
    assert text("Record1/Axes/CZ/AxisType") == "A"
    assert text("Record1/Axes/CZ/DataType") == "D"
    assert [text(f"Record3/MatrixDimension/Size{axis}") for axis in "XYZ"] == ["36", "23", "1"]
    data = content[text("Record3/DataLink/PointDataLink")]
    assert text("Record3/DataLink/MD5ChecksumPointData") == hashlib.md5(data).hexdigest().upper()
    # X runs fastest, metres in little-endian double precision.
    assert_same_bits(np.frombuffer(data, "<f8").reshape(SHAPE).copy(), surface.heights)
    assert text("Record4/ChecksumFile") in names
    assert text("Record2/Instrument/Model") == "Wyko NT1100"
    assert text("Record2/Comment") == "ground.opd\nRaw\nleveled: plane\nsecond step"


def test_x3p_has_the_elements_of_a_file_from_elsewhere(tmp_path: Path) -> None:
    other = MEASUREMENTS / "x3p-2.x3p"
    if not other.exists():
        pytest.skip("shared/measurements/x3p-2.x3p is absent")
    rough().save(tmp_path / "map.x3p")
    found = []
    for path in (tmp_path / "map.x3p", other):
        with zipfile.ZipFile(path) as archive:
            root = ElementTree.fromstring(archive.read("main.xml"))
        axis = root.find("Record1/Axes/CZ")
        assert axis is not None
        # Both may be left out of the axis of the heights.
        for name in ("Increment", "Offset"):
            entry = axis.find(name)
            if entry is not None:
                axis.remove(entry)
        found.append((root.tag, tags(root)))
    assert found[0] == found[1]


def test_names_that_are_no_xml(tmp_path: Path) -> None:
    about = rc.Provenance("a<b>&\x01\udcff\ufffeµ.opd", instrument="<Wyko>\n", steps=("1 < 2",))
    surface = replace(rough(), provenance=about)
    for suffix in SURFACE_SUFFIXES:
        surface.save(tmp_path / f"map{suffix}")
    with zipfile.ZipFile(tmp_path / "map.x3p") as archive:
        root = ElementTree.fromstring(archive.read("main.xml"))
    assert root.findtext("Record2/Comment") == "a<b>&   µ.opd\n1 < 2"
    assert root.findtext("Record2/Instrument/Model") == "<Wyko> "


@pytest.mark.parametrize(
    ("name", "date"),
    [
        ("bullet_land_fixed.x3p", "2018-09-15T17:46:09"),
        ("wyko_nt1100_test_1.opd", "2009-10-26T11:16:55"),
    ],
)
def test_x3p_keeps_the_date_of_the_measurement(tmp_path: Path, name: str, date: str) -> None:
    surface = rc.read_surface(measurement(name)).leveled()
    surface.save(tmp_path / "copy.x3p")
    with zipfile.ZipFile(tmp_path / "copy.x3p") as archive:
        found = ElementTree.fromstring(archive.read("main.xml")).findtext("Record2/Date")
    assert found == date
    again = rc.read_surface(tmp_path / "copy.x3p")
    assert again.provenance.origin is not None
    assert again.provenance.origin.found["acquired"] == date


def test_date_without_time_is_omitted() -> None:
    origin = rc.read_surface(measurement("x3p-2.x3p")).provenance.origin
    assert origin is not None
    assert "acquired" not in origin.found


def test_x3p_of_several_blocks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(source, "BLOCK", 1000)
    rough().save(tmp_path / "map.x3p")
    with zipfile.ZipFile(tmp_path / "map.x3p") as archive:
        data = archive.read("bindata/data.bin")
    assert_same_bits(np.frombuffer(data, "<f8").reshape(SHAPE).copy(), rough().heights)


def test_x3p_beyond_2_gb(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # The bounds of the archive and of this program, both lowered for a map of 6.6 kB.
    monkeypatch.setattr(zipfile, "ZIP64_LIMIT", 4000)
    monkeypatch.setattr(metrology, "_MIN_ZIP64_BYTES", 4000)
    rough().save(tmp_path / "map.x3p")
    with zipfile.ZipFile(tmp_path / "map.x3p") as archive:
        assert [entry.extract_version for entry in archive.infolist()][:2] == [20, 45]
        assert archive.testzip() is None


@pytest.mark.parametrize("block", [2**20, 1000])
@pytest.mark.parametrize("holes", [False, True])
def test_sur_by_its_bytes(
    block: int, holes: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(source, "BLOCK", block)
    surface = rough(holes)
    path = tmp_path / "map.sur"
    surface.save(path)
    assert path.stat().st_size == 512 + 4 * 23 * 36
    assert path.read_bytes()[:20] == b"DIGITAL SURF" + struct.pack("<4H", 0, 1, 1, 2)
    assert path.read_bytes()[20:50] == b"ground.opd".ljust(30)
    found = sur_fields(path)
    assert (found["bits"], found["nx"], found["ny"], found["points"]) == (32, 36, 23, 23 * 36)
    assert found["words"] == [word.ljust(16) for word in (b"X", b"Y", b"Z", *[b"mm"] * 6)]
    assert found["special"] == holes
    assert found["offsets"] == (0, 0, 0)
    assert (found["comment"], found["private"]) == (0, 0)
    assert found["dx"] == pytest.approx(1e3 * PIXEL[1], rel=2**-24, abs=0)
    assert found["dy"] == pytest.approx(1e3 * PIXEL[0], rel=2**-24, abs=0)
    there = ~np.isnan(surface.heights)
    data = found["data"]
    assert (found["zmin"], found["zmax"]) == (data[there].min(), data[there].max())
    assert (data[~there] == found["zmin"] - 2).all()
    assert max(-found["zmin"], found["zmax"]) > 0.99 * 2**31
    np.testing.assert_allclose(
        data[there] * found["dz"], 1e3 * surface.heights[there], rtol=0, atol=0.5001 * found["dz"]
    )


def test_missing_points_of_the_deepest_map_fit_into_32_bits(tmp_path: Path) -> None:
    # Of all largest heights, some round to a step that is too small in single precision.
    for depth in np.linspace(1e-6, 2e-6, 37):
        surface = rc.Surface([[-depth, np.nan], [0.0, depth]], PIXEL)
        surface.save(tmp_path / "map.sur")
        found = sur_fields(tmp_path / "map.sur")
        assert -(2**31) + 2 <= found["zmin"] <= found["data"][0, 0] < 0 < found["zmax"]
        assert found["data"][0, 1] == found["zmin"] - 2
        error = np.abs(found["data"] * found["dz"] - 1e3 * surface.heights)
        assert np.nanmax(error) <= 0.5001 * found["dz"]


@pytest.mark.parametrize(
    ("height", "pixel"),
    [(1e-6, (1e-60, 1e-6)), (1e-6, (1e-6, 1e60)), (1e60, (1.0, 1.0)), (1e306, (1.0, 1.0))],
)
def test_scales_out_of_range_of_sur_raise_input_error(
    height: float, pixel: tuple[float, float], tmp_path: Path
) -> None:
    with pytest.raises(rc.InputError, match=r"map\.sur keeps pixel and step .*\.x3p or \.npz"):
        rc.Surface([[0, height], [0, 0]], pixel).save(tmp_path / "map.sur")
    assert not any(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["main.xml", "bindata/data.bin"])
def test_member_with_wrong_md5_raises_format_error(name: str, tmp_path: Path) -> None:
    """The checksums of the archive hold, those of the standard do not."""
    if not HAS_READER:
        pytest.skip("SurfaceTopography is absent")
    path = tmp_path / "map.x3p"
    rough().save(path)
    with zipfile.ZipFile(path) as archive:
        members = {info.filename: archive.read(info) for info in archive.infolist()}
    old = members[name]
    if name == "main.xml":
        # Another pixel.
        members[name] = re.sub(rb"<Increment>[^<]+<", b"<Increment>2e-06<", old, count=1)
    else:
        members[name] = bytes([old[0] ^ 1]) + old[1:]
    with zipfile.ZipFile(path, "w") as archive:
        for member, content in members.items():
            archive.writestr(member, content)
    with pytest.raises(rc.FormatError, match=f"'{name}' does not match its MD5 checksum"):
        rc.read_surface(path)
    # Without checksums a file is taken as it is.
    document = re.sub(
        rb"<MD5ChecksumPointData>.*?<", b"<MD5ChecksumPointData><", members["main.xml"]
    )
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("main.xml", document)
        archive.writestr("bindata/data.bin", members["bindata/data.bin"])
    assert rc.read_surface(path).shape == rough().shape
    # But not with more points than stated: the first of them would be read, moved.
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("main.xml", document)
        archive.writestr("bindata/data.bin", bytes(8) + members["bindata/data.bin"])
    with pytest.raises(rc.FormatError, match=r"bytes of points in 'bindata/data.bin', but its"):
        rc.read_surface(path)
