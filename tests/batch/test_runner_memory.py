"""Contacts that need more memory than their worker has: the rest is done, and says why."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from fleets import LARGE_CONTACT, limited, write_large, write_project
from roughcontact.batch import runner
from roughcontact.batch.executors import Engine, LocalExecutor
from roughcontact.cli import app

resource = pytest.importorskip("resource", reason="this system limits no address space")


class Narrow(Executor):
    """A process whose address space has little room for the large contact, which has no limit."""

    def __init__(self) -> None:
        self._pool = LocalExecutor(1)

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        return self._pool.submit(limited, *args)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        self._pool.shutdown(wait, cancel_futures=cancel_futures)


@contextmanager
def narrow(workers: int) -> Iterator[Engine]:
    executor = Narrow()
    stop = partial(executor.shutdown, cancel_futures=True)
    try:
        yield Engine(executor, lambda: workers, 1, stop)
    finally:
        stop()


@pytest.mark.slow
@pytest.mark.process
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="RLIMIT_AS is heeded on Linux")
def test_only_contact_exceeding_memory_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_project(tmp_path, 2, LARGE_CONTACT)
    write_large(tmp_path, 1024)
    monkeypatch.setattr(runner, "local_processes", narrow)
    assert app.main(["run", str(path)]) == app.NOT_CONVERGED
    out, err = capsys.readouterr()
    assert out.startswith("4 contacts: 3 solved, 1 failed\n")
    rows = {line.split()[0]: line for line in out.splitlines() if line.startswith("  ")}
    assert rows["large"].split()[1] == "failed"
    assert out.count("of the face is in contact") == 2
    assert err.count("\n") == 1
    assert "error: large: its worker ran out of memory (" in err
    assert "give each worker more" in err
    monkeypatch.undo()
    assert app.main(["run", str(path), "--json", "--workers", "1"]) == app.SOLVED
    assert capsys.readouterr().out.count('"solved before"') == 3
