"""A lock is one process's alone, and gone with it."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from roughcontact._tools import files

HOLDER = """
import sys
from roughcontact._tools import files
with files.file_lock(sys.argv[1]):
    print("held", flush=True)
    sys.stdin.read()
"""


def is_free(path: Path) -> bool:
    try:
        with files.file_lock(path):
            return True
    except BlockingIOError:
        return False


def test_lock_is_exclusive_and_removed(tmp_path: Path) -> None:
    path = tmp_path / "run.lock"
    with files.file_lock(path):
        assert not is_free(path)
        seen: list[bool] = []
        thread = threading.Thread(target=lambda: seen.append(is_free(path)))
        thread.start()
        thread.join()
        assert seen == [False]
        # A process without the lock removes nothing.
        assert path.exists()
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(KeyError), files.file_lock(path):
        raise KeyError
    assert list(tmp_path.iterdir()) == []


def test_a_lock_ends_with_its_process(tmp_path: Path) -> None:
    path = tmp_path / "run.lock"
    child = subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    with child:
        assert child.stdout is not None
        assert child.stdout.readline() == "held\n"
        assert not is_free(path)
        child.send_signal(getattr(signal, "SIGKILL", signal.SIGTERM))
        child.wait()
    # Its file exists without an owner.
    assert path.exists()
    assert is_free(path)
    assert list(tmp_path.iterdir()) == []


def test_only_one_of_many_holds_it(tmp_path: Path) -> None:
    # Each holds, removes and makes the file again while the others try.
    path, inside, most = tmp_path / "run.lock", [0], [0]

    def work() -> None:
        for _ in range(50):
            try:
                with files.file_lock(path):
                    inside[0] += 1
                    most[0] = max(most[0], inside[0])
                    inside[0] -= 1
            except BlockingIOError:
                pass

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert most == [1]
    assert list(tmp_path.iterdir()) == []
