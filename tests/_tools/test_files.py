"""Files that are whole or not there."""

import errno
import os
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Barrier

import pytest

import roughcontact as rc
from roughcontact._tools import files
from roughcontact._tools.files import atomic_write, remove_unfinished, write_atomically

SOURCE = str(Path(rc.__file__).parents[1])

locks = pytest.mark.skipif(sys.platform == "win32", reason="no locks on this system")


def names(folder: Path) -> list[str]:
    return sorted(entry.name for entry in folder.iterdir())


def test_failed_write_keeps_old_file_only(tmp_path: Path) -> None:
    path = tmp_path / "out.txt"
    path.write_text("old")

    def fail() -> None:
        with atomic_write(path) as stream:
            stream.write(b"half")
            raise OSError("full")

    with pytest.raises(OSError, match="full"):
        fail()
    assert path.read_text() == "old"
    assert names(tmp_path) == ["out.txt"]


def test_two_threads_may_write_one_file(tmp_path: Path) -> None:
    path, both = tmp_path / "out.txt", Barrier(2)

    def save(letter: bytes) -> None:
        with atomic_write(path) as stream:
            stream.write(letter * 1000)
            both.wait(timeout=30)

    with ThreadPoolExecutor(2) as pool:
        for written in [pool.submit(save, letter) for letter in (b"a", b"b")]:
            written.result()
    assert path.read_text() in ("a" * 1000, "b" * 1000)
    assert names(tmp_path) == ["out.txt"]


def test_a_failure_names_the_file_wanted(tmp_path: Path) -> None:
    def fail() -> None:
        with atomic_write(tmp_path / "out.txt"):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with pytest.raises(OSError, match="No space left") as caught:
        fail()
    assert caught.value.filename == str(tmp_path / "out.txt")
    with pytest.raises(FileNotFoundError) as missing:
        write_atomically(tmp_path / "absent" / "out.txt", "text")
    assert missing.value.filename == str(tmp_path / "absent" / "out.txt")
    (tmp_path / "folder").mkdir()
    with pytest.raises(OSError) as taken:  # noqa: PT011 - the kind differs between systems
        write_atomically(tmp_path / "folder", "text")
    assert (taken.value.filename, taken.value.filename2) == (str(tmp_path / "folder"), None)
    assert names(tmp_path) == ["folder"]


def test_text_and_bytes_are_written_as_they_are(tmp_path: Path) -> None:
    write_atomically(tmp_path / "text", "µm\n")
    write_atomically(tmp_path / "bytes", memoryview(b"\r\n"))
    assert (tmp_path / "text").read_bytes() == "µm\n".encode()
    assert (tmp_path / "bytes").read_bytes() == b"\r\n"


def test_longest_file_name_is_written(tmp_path: Path) -> None:
    path = tmp_path / ("n" * 251 + ".txt")
    write_atomically(path, "text")
    assert path.read_text() == "text"


# Files of a killed process

WRITER = """
import sys, time
from roughcontact._tools.files import atomic_write
with atomic_write(sys.argv[1]) as stream:
    stream.write(b"half")
    stream.flush()
    print("begun", flush=True)
    time.sleep(60)
"""


@pytest.fixture
def writer(tmp_path: Path):
    """A process that has begun to write a file."""
    environment = {**os.environ, "PYTHONPATH": SOURCE}
    command = [sys.executable, "-c", WRITER, str(tmp_path / "out.txt")]
    process = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "begun\n"
    yield process
    process.kill()
    process.communicate()


@locks
def test_next_writer_removes_file_of_killed_process(writer, tmp_path: Path) -> None:
    (left,) = names(tmp_path)
    write_atomically(tmp_path / "other.txt", "text")
    # Its writer lives.
    assert names(tmp_path) == sorted([left, "other.txt"])
    writer.send_signal(signal.SIGKILL)
    writer.wait()
    write_atomically(tmp_path / "other.txt", "text")
    assert names(tmp_path) == ["other.txt"]


@locks
def test_only_unfinished_files_are_removed(tmp_path: Path) -> None:
    own = ".roughcontact-0123456789abcdef.part"
    kept = [
        ".roughcontact-0123456789abcdef.part.nc",
        ".roughcontact-mine.part",
        "out.part",
        ".hidden",
        own.removeprefix("."),
    ]
    for name in [*kept, own]:
        (tmp_path / name).write_text("text")
    folder = tmp_path / ".roughcontact-ffffffffffffffff.part"
    folder.mkdir()
    link = tmp_path / ".roughcontact-eeeeeeeeeeeeeeee.part"
    link.symlink_to(tmp_path / ".hidden")
    remove_unfinished(tmp_path)
    assert names(tmp_path) == sorted([*kept, folder.name, link.name])
    remove_unfinished(tmp_path / "absent")


@locks
def test_writer_lists_few_files_of_large_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    left = [f".roughcontact-{number:016x}.part" for number in range(50)]
    for name in left:
        (tmp_path / name).touch()
    monkeypatch.setattr(files, "_MAX_LISTED", 10)
    write_atomically(tmp_path / "out.txt", "text")
    assert len(names(tmp_path)) == 41
    remove_unfinished(tmp_path)
    assert names(tmp_path) == ["out.txt"]


@locks
def test_temporary_file_removed_by_other_process_is_renamed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lock, removed = files._lock, []

    def lock_late(stream, **options) -> None:
        # Another process looks between the making of the file and its lock.
        if not removed:
            removed.extend(names(tmp_path))
            remove_unfinished(tmp_path)
        lock(stream, **options)

    monkeypatch.setattr(files, "_lock", lock_late)
    write_atomically(tmp_path / "out.txt", "text")
    assert len(removed) == 1
    assert names(tmp_path) == ["out.txt"]
    assert (tmp_path / "out.txt").read_text() == "text"


def test_signal_while_a_file_is_created_leaves_no_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupt(_: object, **options: bool) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(files, "_lock", interrupt)
    with pytest.raises(KeyboardInterrupt):
        files.write_atomically(tmp_path / "a.json", "{}")
    assert not list(tmp_path.iterdir())
