"""Python in separate processes, ended with the test."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Callable, Iterator

import psutil
import pytest

Start = Callable[..., "subprocess.Popen[str]"]
_TIME_LIMIT = 600.0  # Time after which the processes of a test end [s]


@pytest.fixture
def start() -> Iterator[Start]:
    """Start Python with some words; it ends with the test or at a time limit, with its children."""
    begun: list[subprocess.Popen[str]] = []

    def end() -> None:
        for process in begun:
            if process.poll() is None:
                for child in (*psutil.Process(process.pid).children(recursive=True), process):
                    child.kill()

    # A test that waits for the output of a process would wait without end.
    limit = threading.Timer(_TIME_LIMIT, end)
    limit.start()

    def begin(*words: object, **more: object) -> subprocess.Popen[str]:
        begun.append(
            subprocess.Popen(  # type: ignore[call-overload]
                [sys.executable, *map(str, words)], text=True, stderr=subprocess.PIPE, **more
            )
        )
        return begun[-1]

    yield begin
    limit.cancel()
    end()
    for process in begun:
        process.wait()
        if process.stderr is not None:
            process.stderr.close()
