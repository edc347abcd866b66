"""One reader of SurfaceTopography at a time returns the same as the whole library."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Any

import pytest

import samples
from reading import needs_reader
from roughcontact.formats import instruments, readers
from roughcontact.formats.read import SUFFIXES, read_with_channels

pytestmark = needs_reader

HEAVY = (
    "SurfaceTopography",
    "NuMPI",
    "scipy.optimize",
    "matplotlib",
    "pandas",
    "openpyxl",
    "pint",
    "pydantic",
)


def files(folder: Path) -> Iterator[tuple[Path, dict[str, str]]]:
    """Yield the files of all instruments with their arguments."""
    for sample in (*samples.made(folder), *samples.measured()):
        path = folder / sample.name
        if SUFFIXES.get(path.suffix, "di") in instruments.SUFFIXES:
            path.write_bytes(sample.content)
            yield path, sample.arguments


@pytest.mark.long
def test_separate_reader_matches_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("SurfaceTopography.IO", exc_type=ImportError)
    from SurfaceTopography.IO import open_topography

    given = list(files(tmp_path))
    assert len({path.suffix for path, _ in given}) > 14
    alone = [read_with_channels(path, **words) for path, words in given]
    monkeypatch.setattr(
        instruments, "_opener", lambda path, kind: partial(open_topography, format=kind)
    )
    for (path, words), (surface, channels) in zip(given, alone, strict=True):
        same, named = read_with_channels(path, **words)
        assert surface.heights.tobytes() == same.heights.tobytes(), path.name
        assert (surface.pixel, surface.provenance) == (same.pixel, same.provenance)
        assert channels == named


@pytest.mark.parametrize("name", sorted(instruments.SUFFIXES))
def test_every_reader_loads_separately(name: str) -> None:
    assert readers.reader(name).format() == name


@pytest.mark.parametrize(
    "expected",
    [
        {},
        {"acquisition_time": datetime(2024, 5, 6, 7, 8, 9), "channel_name": "Z", "raw": None},
        {"acquisition_time": "2024-05-06T07:08:09", "raw_metadata": {"a": {"b": None}}},
        {"instrument": {"name": "NT", "vendor": "Veeco"}},
    ],
)
def test_metadata_match_library(expected: dict[str, Any]) -> None:
    library = pytest.importorskip("SurfaceTopography.Metadata", exc_type=ImportError).InfoModel
    assert readers.InfoModel(**expected).model_dump() == library(**expected).model_dump(
        exclude_none=True
    )


def test_other_readers_use_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, words = next(iter(files(tmp_path)))

    def absent(name: str) -> None:
        raise ImportError(name)

    alone, _ = read_with_channels(path, **words)
    monkeypatch.setattr(readers, "reader", absent)
    whole, _ = read_with_channels(path, **words)
    assert alone.heights.tobytes() == whole.heights.tobytes()


def test_reading_does_not_import_rest_of_library(tmp_path: Path) -> None:
    path, _ = next(iter(files(tmp_path)))
    code = (
        "import sys; from roughcontact.formats.read import read_surface; "
        f"read_surface({str(path)!r}); print(*sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert set(done.stdout.split()).isdisjoint(HEAVY)
