"""Python in separate processes, ended with the test."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator

import psutil
import pytest

Start = Callable[..., "subprocess.Popen[str]"]


@pytest.fixture
def start() -> Iterator[Start]:
    """Start Python with some words; it is ended with the test, and its children with it."""
    begun: list[subprocess.Popen[str]] = []

    def begin(*words: object, **more: object) -> subprocess.Popen[str]:
        begun.append(
            subprocess.Popen(  # type: ignore[call-overload]
                [sys.executable, *map(str, words)], text=True, stderr=subprocess.PIPE, **more
            )
        )
        return begun[-1]

    yield begin
    for process in begun:
        if process.poll() is None:
            for child in (*psutil.Process(process.pid).children(recursive=True), process):
                child.kill()
        process.wait()
        if process.stderr is not None:
            process.stderr.close()
