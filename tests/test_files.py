"""Files that are whole or not there."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Barrier

import pytest

from roughcontact.files import replacing


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "out.txt"
    path.write_text("old")

    def fail() -> None:
        with replacing(path) as temporary:
            temporary.write_text("half")
            raise OSError("full")

    with pytest.raises(OSError, match="full"):
        fail()
    assert path.read_text() == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["out.txt"]


def test_two_threads_may_write_one_file(tmp_path: Path) -> None:
    path, both = tmp_path / "out.txt", Barrier(2)

    def write(letter: str) -> None:
        with replacing(path) as temporary:
            temporary.write_text(letter * 1000)
            both.wait(timeout=30)
            assert temporary.read_text() == letter * 1000

    with ThreadPoolExecutor(2) as pool:
        for written in [pool.submit(write, letter) for letter in "ab"]:
            written.result()
    assert path.read_text() in ("a" * 1000, "b" * 1000)
    assert [entry.name for entry in tmp_path.iterdir()] == ["out.txt"]
