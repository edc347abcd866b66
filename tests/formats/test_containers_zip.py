import struct
import zipfile
from pathlib import Path

import numpy as np
import pytest

import roughcontact as rc
from reading import assert_rejected, needs_reader
from roughcontact.errors import FormatError
from roughcontact.formats import source
from roughcontact.formats.read import read_surface

SURFACE = rc.Surface(np.random.default_rng(1).normal(size=(20, 30)) * 1e-7, (1e-6, 1e-6))


@pytest.fixture
def x3p(tmp_path: Path) -> Path:
    path = tmp_path / "map.x3p"
    SURFACE.save(path)
    return path


def add(path: Path, name: str, content: bytes, packing: int = zipfile.ZIP_DEFLATED) -> None:
    with zipfile.ZipFile(path, "a", packing) as archive:
        archive.writestr(name, content)


def state_sizes(path: Path, size: int) -> None:
    """State another size of the large members in the directory of an archive."""
    content = bytearray(path.read_bytes())
    entry = content.find(b"PK\1\2")
    while entry >= 0:
        if struct.unpack_from("<I", content, entry + 24)[0] > 10**6:
            struct.pack_into("<I", content, entry + 24, size)
        entry = content.find(b"PK\1\2", entry + 4)
    path.write_bytes(content)


def test_a_sound_archive(x3p: Path) -> None:
    source.check_archive(x3p)
    add(x3p, "flat.bin", bytes(2**24))
    source.check_archive(x3p)


def test_archive_bombs_raise_format_error(x3p: Path) -> None:
    for number in range(3):
        add(x3p, f"{number}.bin", bytes(2 * 10**6))
    state_sizes(x3p, 2**32 - 2)
    with pytest.raises(FormatError, match=r"^map.x3p holds 12.0 GiB, more than the 8 GiB"):
        source.check_archive(x3p)
    # Fewer bytes, packed more densely than any measurement.
    state_sizes(x3p, 10**9)
    with pytest.raises(FormatError, match=r"holds 2.8 GiB or more, packed into 0.0 MiB"):
        source.check_archive(x3p)
    # Read no further than stated, and not to the end then.
    state_sizes(x3p, 10**6 + 1)
    with pytest.raises(ValueError, match=r"the checksum of '0.bin' in the archive is wrong"):
        source.check_archive(x3p)


def test_a_header_too_long_for_a_tree(x3p: Path) -> None:
    add(x3p, "notes.xml", b"<a>" + b"<b/>" * 2**22)
    with pytest.raises(FormatError, match=r"the text 'notes.xml' of 16 MiB, too long for a head"):
        source.check_archive(x3p)


@pytest.mark.parametrize("packing", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_packings_that_have_no_bounds(x3p: Path, packing: int) -> None:
    add(x3p, "more.bin", bytes(100), packing)
    with pytest.raises(FormatError, match=r"'more.bin' packed by another method than deflate"):
        source.check_archive(x3p)


@needs_reader
def test_archives_after_other_bytes_are_checked(x3p: Path) -> None:
    for number in range(3):
        add(x3p, f"{number}.bin", bytes(2 * 10**6))
    state_sizes(x3p, 2**32 - 2)
    for front in (b"", b"front"):
        x3p.write_bytes(front + x3p.read_bytes())
        assert_rejected(x3p, "map.x3p holds 12.0 GiB, more than the 8 GiB")


@needs_reader
def test_a_flat_map_is_read_back(tmp_path: Path) -> None:
    # A thousand times smaller, as it is packed.
    heights = np.zeros((1500, 1500))
    heights[0, 0] = 1e-6
    rc.Surface(heights, (1e-6, 1e-6)).save(tmp_path / "flat.x3p")
    assert (tmp_path / "flat.x3p").stat().st_size < 8 * 1500**2 / 100
    np.testing.assert_array_equal(read_surface(tmp_path / "flat.x3p").heights, heights)
