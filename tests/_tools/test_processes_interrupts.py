"""Interrupts that come where Python drops them."""

from __future__ import annotations

import os
import signal
import sys
import time
from pathlib import Path

import pytest

from roughcontact._tools import netcdf
from roughcontact._tools.processes import redeliver_interrupts
from roughcontact.batch.executors import LocalExecutor, LostWorkerError
from roughcontact.cli.terminal import handle_stop_signals


class Dropping:
    """Something in whose end an interrupt comes, or that fails there."""

    def __init__(self, kind: type[BaseException]) -> None:
        self.kind = kind

    def __del__(self) -> None:
        raise self.kind


def drop(kind: type[BaseException]) -> None:
    """Drop an exception, and wait for what comes of it."""
    Dropping(kind)
    time.sleep(10)


@pytest.mark.parametrize("kind", [KeyboardInterrupt, SystemExit])
def test_dropped_interrupt_is_raised_again(kind: type[BaseException]) -> None:
    def ended(number: int, frame: object) -> None:
        raise SystemExit

    before = signal.signal(signal.SIGTERM, ended)
    try:
        with pytest.raises(kind), redeliver_interrupts():
            drop(kind)
    finally:
        signal.signal(signal.SIGTERM, before)


@pytest.mark.parametrize("number", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_destructor_error_after_interrupt_is_not_reported(
    number: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not hasattr(signal, number):
        pytest.skip(f"no {number} on this system")
    messages: list[type[BaseException]] = []
    monkeypatch.setattr(sys, "unraisablehook", lambda given: messages.append(given.exc_type))
    with redeliver_interrupts(), handle_stop_signals():
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(getattr(signal, number))
        Dropping(AttributeError)
        # And an interrupt is still heard.
        with pytest.raises(KeyboardInterrupt):
            drop(KeyboardInterrupt)
    assert messages == []
    Dropping(AttributeError)
    assert messages == [AttributeError]


def interrupted_file(folder: str) -> None:
    """Terminate where a file of h5netcdf has no more than its name."""
    import h5netcdf

    h5netcdf.File.__init__ = lambda *given, **more: os.kill(os.getpid(), signal.SIGTERM)
    netcdf.write(netcdf.Dataset(), f"{folder}/one.nc")


@pytest.mark.long
def test_terminated_worker_removes_partial_file_silently(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    executor = LocalExecutor(1)
    with pytest.raises(LostWorkerError, match="status 143"):
        executor.submit(interrupted_file, str(tmp_path)).result()
    executor.shutdown()
    assert capfd.readouterr().err == ""
    assert list(tmp_path.iterdir()) == []


def test_other_destructor_errors_are_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    messages: list[type[BaseException]] = []
    monkeypatch.setattr(sys, "unraisablehook", lambda given: messages.append(given.exc_type))
    with redeliver_interrupts():
        Dropping(ValueError)
    assert messages == [ValueError]
