"""Errors about files that are no maps."""

import zipfile
from pathlib import Path

import pytest

from reading import assert_rejected, needs_reader, write

CONTENTS = {
    b"%PDF-1.7\nx": "is a PDF document",
    b"\x89PNG\r\n\x1a\n\0": "is a PNG image",
    b"<!DOCTYPE html>\n": "is a web page, not the file itself",
    b"version https://git-lfs.github.com/spec/v1\n": "is a pointer of Git LFS",
    b"MATLAB 5.0 MAT-file": "is a MATLAB file",
}


@pytest.mark.parametrize("name", ["map.x3p", "map.csv", "map.tif", "map.unknown", "map"])
@pytest.mark.parametrize("content", CONTENTS)
def test_content_that_is_no_map_is_named_under_any_suffix(
    name: str, content: bytes, tmp_path: Path
) -> None:
    assert_rejected(write(tmp_path, name, content), name, CONTENTS[content], ".x3p")


@needs_reader
@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("map.opd", "is a ZIP archive, no whole file of the format 'opd'"),
        ("map.plux", "plux"),
        ("map.lext", "is a ZIP archive, no whole file of the format 'lext'"),
    ],
)
def test_whole_file_of_another_format_is_named(name: str, words: str, tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / name, "w") as archive:
        archive.writestr("notes.txt", "no heights" * 99)
    assert_rejected(tmp_path / name, words)


def test_unknown_suffix_names_content(tmp_path: Path) -> None:
    path = write(tmp_path, "map.abc", bytes(300))
    assert_rejected(path, "is of an unknown binary format, and has the unknown suffix '.abc'")
