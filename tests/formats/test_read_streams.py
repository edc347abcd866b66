import os
import socket
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from reading import assert_rejected, write
from roughcontact._tools import files
from roughcontact.formats.read import channels, read_surface, read_with_channels

pytestmark = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes")

# Rows of 64 bytes: a reader that loses its first block loses whole rows, and nothing looks wrong.
HEIGHTS = np.random.default_rng(3).uniform(1e-9, 9e-9, size=(400, 4))
TEXT = "".join(" ".join(f"{z:.8e}" for z in row).ljust(63) + "\n" for row in HEIGHTS)
GIVEN = {"unit": "m", "size": "400 um x 4 um"}


def fifo(tmp_path: Path, name: str, write_to: Callable[[Path], None] | None = None) -> Path:
    """Return a named pipe, with a thread that writes to it."""
    path = tmp_path / name
    os.mkfifo(path)
    if write_to is not None:
        threading.Thread(target=write_to, args=(path,), daemon=True).start()
    return path


def test_a_regular_file_is_itself(tmp_path: Path) -> None:
    path = write(tmp_path, "map.csv", TEXT)
    with files.as_regular_file(path) as file:
        assert file == path


@pytest.mark.parametrize("name", ["map.csv", "map.txt", "map"])
def test_a_pipe_is_read_once_and_to_the_bit(tmp_path: Path, name: str) -> None:
    assert len(TEXT) > 3 * 8192
    expected = read_surface(write(tmp_path, "file.csv", TEXT), **GIVEN)
    read = read_surface(fifo(tmp_path, name, lambda path: path.write_text(TEXT)), **GIVEN)
    assert read.shape == (400, 4)
    np.testing.assert_array_equal(read.heights, expected.heights)
    assert read.pixel == expected.pixel
    assert read.provenance.source == name


@pytest.mark.skipif(not Path("/dev/fd").exists(), reason="a shell makes no <(…) here")
def test_process_substitution_of_shell_is_read(tmp_path: Path) -> None:
    end, start = os.pipe()

    def feed() -> None:
        with os.fdopen(start, "w") as stream:
            stream.write(TEXT)

    thread = threading.Thread(target=feed)
    thread.start()
    try:
        surface, found = read_with_channels(f"/dev/fd/{end}", **GIVEN)
    finally:
        thread.join()
        os.close(end)
    expected = read_surface(write(tmp_path, "file.csv", TEXT), **GIVEN)
    np.testing.assert_array_equal(surface.heights, expected.heights)
    assert [entry.shape for entry in found] == [(400, 4)]
    assert surface.provenance.source == str(end)


def test_every_format_is_read_from_a_pipe(tmp_path: Path) -> None:
    np.savez(tmp_path / "map.npz", heights=HEIGHTS, pixel=[1e-6, 1e-6], unit="m")
    content = (tmp_path / "map.npz").read_bytes()
    path = fifo(tmp_path, "pipe.npz", lambda path: path.write_bytes(content))
    np.testing.assert_array_equal(read_surface(path).heights, HEIGHTS)
    path = fifo(tmp_path, "pipe", lambda path: path.write_bytes(content))
    assert [entry.name for entry in channels(path, "npz")] == ["heights", "pixel", "unit"]


def test_slow_writer_of_pipe_is_read(tmp_path: Path) -> None:
    def slow(path: Path) -> None:
        time.sleep(0.1)
        with path.open("w", buffering=1) as stream:
            for part in (TEXT[:100], TEXT[100:]):
                time.sleep(0.1)
                stream.write(part)

    assert read_surface(fifo(tmp_path, "map.csv", slow), **GIVEN).shape == (400, 4)


def test_a_pipe_without_an_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(files, "MAX_PIPE_BYTES", 2**20)

    def endless(path: Path) -> None:
        with path.open("wb", buffering=0) as stream:
            while True:
                try:
                    stream.write(bytes(2**16))
                except BrokenPipeError:
                    return

    assert_rejected(
        fifo(tmp_path, "map.csv", endless), "map.csv is a pipe that gives more than", **GIVEN
    )


def test_empty_or_invalid_pipe_raises_format_error(tmp_path: Path) -> None:
    path = fifo(tmp_path, "map.csv", lambda path: path.write_text("no numbers\n"))
    assert_rejected(path, "map.csv has 'no' in line 1", **GIVEN)
    path = fifo(tmp_path, "map", lambda path: path.write_bytes(b"\x89PNG\r\n\x1a\n\0"))
    assert_rejected(path, "map is a PNG image")


@pytest.mark.parametrize("device", ["/dev/zero", "/dev/null", "/dev/random"])
def test_devices(device: str) -> None:
    if not Path(device).exists():
        pytest.skip(f"there is no {device}")
    assert_rejected(
        Path(device), f"{device} is not a regular file; copy its content into one", format="text"
    )


def test_sockets(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Names of sockets have to be short.
    monkeypatch.chdir(tmp_path)
    with socket.socket(socket.AF_UNIX) as one:
        one.bind("map.csv")
        assert_rejected(Path("map.csv"), "map.csv is not a regular file")


def test_files_without_a_size(tmp_path: Path) -> None:
    # The kernel's own, which may give anything for ever.
    if sys.platform.startswith("linux"):
        assert_rejected(Path("/proc/self/pagemap"), "is empty", format="text")
