"""Objects of Digital Surf, and X3P as other programs write it."""

import struct
import zipfile
import zlib
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from reading import assert_rejected, needs_reader, write
from roughcontact._tools import memory, processes
from roughcontact.formats.read import channels, read_surface

HEIGHTS = 1e-6 * np.arange(12.0).reshape(3, 4)


@pytest.fixture
def content(tmp_path: Path) -> bytes:
    """Return a SUR file of a map."""
    heights = HEIGHTS.copy()
    heights[1, 2] = np.nan
    rc.Surface(heights, (2e-6, 1e-6)).save(tmp_path / "plain.sur")
    return (tmp_path / "plain.sur").read_bytes()


def pack(content: bytes, streams: int) -> bytes:
    """Return the file with its points in compressed streams."""
    parts = np.array_split(np.frombuffer(content[512:], np.uint8), streams)
    packed = [zlib.compress(part.tobytes()) for part in parts]
    sizes = [size for part, z in zip(parts, packed, strict=True) for size in (part.size, len(z))]
    directory = struct.pack(f"<{1 + len(sizes)}I", streams, *sizes)
    return b"DSCOMPRESSED" + content[12:512] + directory + b"".join(packed) + b"another object"


def edit(content: bytes, place: int, new: bytes) -> bytes:
    return content[:place] + new + content[place + len(new) :]


@needs_reader
@pytest.mark.parametrize("streams", [1, 3])
def test_compressed_map_is_read(content: bytes, streams: int, tmp_path: Path) -> None:
    surface = read_surface(write(tmp_path, "map.sur", pack(content, streams)))
    plain = read_surface(write(tmp_path, "plain.sur", content))
    np.testing.assert_array_equal(surface.heights, plain.heights)
    assert surface.missing == 1
    assert surface.pixel == plain.pixel == pytest.approx((2e-6, 1e-6))


@pytest.mark.long
@needs_reader
@pytest.mark.skipif(not processes.can_fork(), reason="no process has limits here")
def test_stream_larger_than_memory_raises_format_error(
    content: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    packed = zlib.compress(bytes(2**29), 1)
    directory = struct.pack("<3I", 1, len(content) - 512, len(packed))
    path = write(tmp_path, "map.sur", b"DSCOMPRESSED" + content[12:512] + directory + packed)
    monkeypatch.setattr(memory, "free_bytes", lambda: 2**28)
    for read in (read_surface, channels):
        with pytest.raises(rc.FormatError, match=r"^map\.sur cannot .* more memory than is free"):
            read(path)


@needs_reader
@pytest.mark.parametrize("is_packed", [False, True])
def test_profile_without_distance_of_lines_is_read(
    content: bytes, is_packed: bool, tmp_path: Path
) -> None:
    # One line of four points, type 1; distance and units along y are empty.
    head = edit(content[:512], 18, struct.pack("<H", 1))
    head = edit(head, 112, struct.pack("<2i", 1, 4))
    head = edit(edit(head, 124, bytes(4)), 196, bytes(16))
    whole = edit(head, 244, bytes(16)) + content[512 : 512 + 16]
    path = write(tmp_path, "line.pro", pack(whole, 1) if is_packed else whole)
    surface = read_surface(path)
    assert surface.is_profile
    np.testing.assert_allclose(surface.heights[0], HEIGHTS[0], atol=1e-13)
    assert surface.pixel[1] == pytest.approx(1e-6)


@needs_reader
def test_objects_without_heights_are_named(content: bytes, tmp_path: Path) -> None:
    kinds = {10: "an intensity image", 12: "a color image", 20: "curves or spectra"}
    for kind, words in kinds.items():
        path = write(tmp_path, "map.sur", edit(content, 18, struct.pack("<H", kind)))
        assert_rejected(path, f"holds {words}, no heights")
    named = edit(edit(content, 164, b"Intensity".ljust(16)), 212, b"a.u.".ljust(16))
    assert_rejected(write(tmp_path, "map.sur", named), "holds 'Intensity' in 'a.u.', no heights")


@needs_reader
def test_replica_is_noted(content: bytes, tmp_path: Path) -> None:
    path = write(tmp_path, "cast.sur", edit(content, 288, struct.pack("<H", 1)))
    assert "replica" in read_surface(path).provenance.steps[0]


@needs_reader
def test_content_decides_over_another_suffix(content: bytes, tmp_path: Path) -> None:
    for name in ("map.opd", "map.abc", "map.csv"):
        surface = read_surface(write(tmp_path, name, content))
        assert surface.provenance.instrument.startswith("Digital Surf")


@pytest.fixture
def document(tmp_path: Path) -> str:
    """Return the document of an X3P file of a map."""
    rc.Surface(HEIGHTS, (2e-6, 1e-6)).save(tmp_path / "plain.x3p")
    with zipfile.ZipFile(tmp_path / "plain.x3p") as archive:
        return archive.read("main.xml").decode()


def write_x3p(path: Path, document: str, root: str = "") -> Path:
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("__MACOSX/._data", b"")
        archive.writestr(f"{root}main.xml", document)
        # x3ptools omits the name.
        archive.writestr(f"{root}md5checksum.hex", "0" * 32 + "\n")
        if "PointDataLink" in document:
            archive.writestr(f"{root}bindata/data.bin", HEIGHTS.astype("<f8").tobytes())
    return path


def with_list(document: str, factor: float) -> str:
    """Return the document with its heights, one of them missing, as text."""
    cells = [f"<Datum>{factor * z:.6e}</Datum>" for z in HEIGHTS.flat]
    cells[5] = "<Datum/>"
    head, _, rest = document.partition("<DataLink>")
    return head + f"<DataList>{''.join(cells)}</DataList>" + rest.partition("</DataLink>")[2]


@needs_reader
@pytest.mark.parametrize(
    ("old", "new", "root"),
    [
        ("", "", "map/"),
        ("ISO5436 - 2000", "ISO5436 \u2013 2000", ""),
        ("<Increment>1</Increment>", "<Increment/>", ""),
        ("<Offset>0</Offset>", "<Offset />", ""),
        ("<Date>", "<Date>N/A</Date><Date>", "a/b/"),
    ],
)
def test_x3p_of_other_programs_is_read(
    old: str, new: str, root: str, document: str, tmp_path: Path
) -> None:
    path = write_x3p(tmp_path / "map.x3p", document.replace(old, new) if old else document, root)
    surface = read_surface(path)
    np.testing.assert_array_equal(surface.heights, HEIGHTS)
    assert surface.pixel == pytest.approx((2e-6, 1e-6))


@needs_reader
@pytest.mark.parametrize("kind", ["D", "L"])
def test_x3p_with_heights_in_its_document(kind: str, document: str, tmp_path: Path) -> None:
    head, _, axis = with_list(document, 1.0 if kind == "D" else 1e9).partition("<CZ>")
    axis = axis.replace("<DataType>D", f"<DataType>{kind}", 1)
    if kind == "L":
        axis = axis.replace("<Increment>1<", "<Increment>1e-9<", 1).replace("Offset>0", "Offset>1")
    surface = read_surface(write_x3p(tmp_path / "map.x3p", f"{head}<CZ>{axis}"))
    expected = HEIGHTS + (kind == "L")
    expected.flat[5] = np.nan
    np.testing.assert_allclose(surface.heights, expected, rtol=1e-12)


@needs_reader
def test_x3p_profile_is_a_surface_of_one_row(document: str, tmp_path: Path) -> None:
    text = document.replace(">SUR<", ">PRF<").replace("SizeY>3<", "SizeY>1<")
    text = text.replace("SizeX>4<", "SizeX>12<")
    surface = read_surface(write_x3p(tmp_path / "map.x3p", text))
    assert surface.is_profile
    np.testing.assert_array_equal(surface.heights[0], HEIGHTS.ravel())


@needs_reader
@pytest.mark.parametrize(
    ("old", "new"), [(">SUR<", ">PCL<"), ("<CY>\n        <AxisType>I", "<CY>\n        <AxisType>A")]
)
def test_x3p_of_scattered_points_is_named(
    old: str, new: str, document: str, tmp_path: Path
) -> None:
    path = write_x3p(tmp_path / "map.x3p", document.replace(old, new))
    assert_rejected(path, "points with an x and y each", "export it as a surface")
