"""Processes that work for another one."""

from __future__ import annotations

import os
import platform
import signal
import subprocess
import sys
import threading
import time

import psutil
import pytest

from roughcontact._tools import processes
from roughcontact.errors import InputError

FAULTS = """
import resource, sys
import numpy as np
from roughcontact._tools import processes

def faults():
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt

if sys.argv[1] == "kept":
    processes.keep_freed()
np.ones(500_000)
before = faults()
for _ in range(20):
    np.ones(500_000)
print(faults() - before)
"""


def faults(how: str, **environment: str) -> int:
    """Return the pages that the kernel gave for arrays of 4 MB, one after the other."""
    done = subprocess.run(
        [sys.executable, "-c", FAULTS, how],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=True,
    )
    return int(done.stdout)


@pytest.mark.long
@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="not the GNU C library")
def test_freed_memory_is_reused_despite_dask_setting() -> None:
    # As Dask begins its workers.
    dask = {"MALLOC_TRIM_THRESHOLD_": "65536"}
    assert faults("given back", **dask) > 10_000
    assert faults("kept", **dask) < 1000
    # Who says otherwise has it so.
    assert faults("kept", **dask, MALLOC_MMAP_THRESHOLD_="131072") > 10_000


@pytest.mark.skipif(not hasattr(signal, "pthread_kill"), reason="threads cannot be sent signals")
def test_interrupt_waits_for_process_start() -> None:
    done, begun = threading.Event(), []
    other = threading.Thread(target=done.wait)
    other.start()
    before = signal.getsignal(signal.SIGINT)

    def begin() -> None:
        with processes.sigint_blocked():
            # A thread that was there before lets it through.
            signal.pthread_kill(other.ident or 0, signal.SIGINT)
            time.sleep(0.05)
            begun.append(1)

    try:
        with pytest.raises(KeyboardInterrupt):
            begin()
    finally:
        done.set()
        other.join()
    assert begun
    assert signal.getsignal(signal.SIGINT) is before


def test_run_by_mpiexec_raises_input_error(monkeypatch: pytest.MonkeyPatch) -> None:
    for value in ("", "1"):
        monkeypatch.setenv("PMI_SIZE", value)
        processes.reject_mpi_run()
    monkeypatch.setenv("OMPI_COMM_WORLD_SIZE", "2")
    with pytest.raises(InputError, match="start a single one"):
        processes.reject_mpi_run()


needs_fork = pytest.mark.skipif(not processes.can_fork(), reason="calls are made in this process")


def fail() -> None:
    raise InputError("must be less", argument="load")


def crash() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def run_on() -> None:
    while True:
        pass


@needs_fork
def test_limited_call_returns_result_of_another_process() -> None:
    assert processes.call_limited(os.getpid, seconds=1) != os.getpid()
    assert processes.call_limited(divmod, 7, 2, seconds=1) == (3, 1)
    with pytest.raises(InputError, match="load must be less") as caught:
        processes.call_limited(fail, seconds=1)
    assert caught.value.argument == "load"


@needs_fork
@pytest.mark.parametrize(
    ("function", "args", "words"),
    [
        (crash, (), "it crashes or takes more than 1 s of computing"),
        pytest.param(run_on, (), "more than 1 s of computing", marks=pytest.mark.long),
        (bytearray, (2**50,), "more memory than is free"),
    ],
)
def test_limited_call_that_fails_raises_value_error(function, args, words: str) -> None:
    before = psutil.Process().children()
    with pytest.raises(ValueError, match=words):
        processes.call_limited(function, *args, seconds=1)
    assert psutil.Process().children() == before


def test_calls_without_fork_are_made_here(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(os, "fork", raising=False)
    assert processes.call_limited(os.getpid, seconds=1) == os.getpid()
