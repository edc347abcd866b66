import io
import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest

from reading import assert_rejected
from roughcontact._tools import memory
from roughcontact.errors import InsufficientMemoryError
from roughcontact.formats.read import channels, read_surface

HEIGHTS = np.arange(12.0).reshape(3, 4) * 1e-9
MAP = {"heights": HEIGHTS, "pixel": np.array([1e-6, 1e-6]), "unit": np.array("m")}
GIVEN = {"unit": "m", "size": "3 um x 4 um"}


def npy(array: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.save(stream, array, allow_pickle=True)
    return stream.getvalue()


def archive(
    path: Path, members: dict[str, bytes] | None = None, packing: int = zipfile.ZIP_STORED
) -> Path:
    """Write a map as this program does, and other members."""
    with zipfile.ZipFile(path, "w", packing) as zipped:
        for name, array in MAP.items():
            zipped.writestr(f"{name}.npy", npy(array))
        for name, content in (members or {}).items():
            zipped.writestr(name, content)
    return path


def state_size(path: Path, name: str, size: int) -> None:
    """State another size of a member in the directory of an archive."""
    content = bytearray(path.read_bytes())
    entry = content.rindex(name.encode()) - 46
    assert content[entry : entry + 4] == b"PK\1\2"
    struct.pack_into("<I", content, entry + 24, size)
    path.write_bytes(content)


def damage(path: Path, wanted: bytes) -> None:
    """Change a byte of what is stored in an archive, and not its checksum."""
    content = bytearray(path.read_bytes())
    content[content.index(wanted)] ^= 1
    path.write_bytes(content)


def test_unused_arrays_are_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # More than the bytes that are read of a header.
    path = archive(tmp_path / "map.npz", {"more.npy": npy(np.full((1000, 99), 7.25))})
    damage(path, struct.pack("<d", 7.25))
    monkeypatch.setattr(memory, "free_bytes", lambda: 1000)
    np.testing.assert_array_equal(read_surface(path).heights, HEIGHTS)
    assert [entry.shape for entry in channels(path)] == [(3, 4), (2,), (), (1000, 99)]
    with pytest.raises(InsufficientMemoryError, match=r"reading the 1000 × 99 points of map.npz"):
        read_surface(path, channel="more", **GIVEN)
    monkeypatch.undo()
    assert_rejected(path, "map.npz cannot be read", "CRC-32", channel="more", **GIVEN)


def test_used_arrays_are_checked_completely(tmp_path: Path) -> None:
    for name, wanted in (("heights", HEIGHTS[2, 3]), ("pixel", 1e-6)):
        path = archive(tmp_path / f"{name}.npz")
        damage(path, struct.pack("<d", wanted))
        assert_rejected(path, f"{name}.npz cannot be read", "CRC-32")


def test_a_size_that_is_a_lie(tmp_path: Path) -> None:
    more = npy(np.zeros((1000, 1000)))
    path = archive(tmp_path / "map.npz", {"more.npy": more}, zipfile.ZIP_DEFLATED)
    state_size(path, "more.npy", len(more) + 8)
    assert_rejected(path, "leaves 8 bytes of the file unused")
    # An array that fits its member as that is stated, of which there is far more.
    less = npy(np.zeros((100, 100))) + bytes(10**6)
    path = archive(tmp_path / "map.npz", {"more.npy": less}, zipfile.ZIP_DEFLATED)
    state_size(path, "more.npy", len(npy(np.zeros((100, 100)))))
    assert read_surface(path).shape == (3, 4)
    assert_rejected(path, "CRC-32", channel="more", **GIVEN)


@pytest.mark.parametrize("packing", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_packings_that_have_no_bounds(tmp_path: Path, packing: int) -> None:
    assert_rejected(
        archive(tmp_path / "map.npz", {}, packing), "packed by another method than deflate"
    )


@pytest.mark.parametrize("kind", ["npy", "npz"])
def test_a_head_without_an_end(tmp_path: Path, kind: str) -> None:
    content = b"\x93NUMPY\x02\x00" + struct.pack("<I", 2**31) + b" " * 2**20
    path = tmp_path / f"map.{kind}"
    if kind == "npy":
        path.write_bytes(content)
        # A sparse file of the stated length.
        with path.open("r+b") as stream:
            stream.truncate(2**31 + 12)
    else:
        archive(path, {"more.npy": content}, zipfile.ZIP_DEFLATED)
    assert_rejected(path, "cannot be read", "reading array header")


def test_an_array_without_an_end(tmp_path: Path) -> None:
    path = tmp_path / "map.npy"
    head = {"descr": "<f8", "fortran_order": False, "shape": (2**20, 2**20)}
    with path.open("wb") as stream:
        np.lib.format.write_array_header_1_0(stream, head)
        stream.truncate(stream.tell() + 2**43)
    assert_rejected(path, "map.npy announces 1048576 × 1048576 points, more than", **GIVEN)


def test_other_members_of_archive_are_listed(tmp_path: Path) -> None:
    stream = io.BytesIO()
    np.lib.format.write_array(stream, np.zeros(3, [("größe", "f8"), ("Δ", "f8")]), (3, 0))
    others = {"readme.txt": b"text", "table.npy": stream.getvalue()}
    path = archive(tmp_path / "map.npz", others)
    assert read_surface(path).shape == (3, 4)
    listed = channels(path)
    assert [entry.name for entry in listed] == ["heights", "pixel", "unit", "readme.txt", "table"]
    assert not any(entry.is_height for entry in listed[1:])
    assert_rejected(path, "must hold a matrix", channel="readme.txt", **GIVEN)
    assert_rejected(path, "must hold a matrix", channel="table", **GIVEN)
    path = archive(tmp_path / "map.npz", {"more.npy": npy(np.array([[None, 1], [2, 3]]))})
    assert_rejected(path, "Python objects")


@pytest.mark.parametrize("order", ["<", ">"])
def test_letters_that_do_not_exist(order: str, tmp_path: Path) -> None:
    path = tmp_path / "map.npz"
    unit = np.array("um", f"{order}U2")
    np.savez(path, **{**MAP, "heights": HEIGHTS * 1e6, "pixel": np.ones(2), "unit": unit})
    assert read_surface(path).pixel == (1e-6, 1e-6)
    raw = npy(unit)
    with zipfile.ZipFile(path, "w") as zipped:
        for name in ("heights", "pixel"):
            zipped.writestr(f"{name}.npy", npy(MAP[name]))
        zipped.writestr("unit.npy", raw[:-4] + b"\xff" * 4)
    assert_rejected(path, "map.npz cannot be read", "invalid characters")
