"""Interrupts that come where Python drops them."""

from __future__ import annotations

import signal
import sys
import time

import pytest

from roughcontact.interrupts import heard


class Dropping:
    """Something in whose end an interrupt comes."""

    def __init__(self, kind: type[BaseException]) -> None:
        self.kind = kind

    def __del__(self) -> None:
        raise self.kind


@pytest.mark.parametrize("kind", [KeyboardInterrupt, SystemExit])
def test_an_interrupt_that_python_drops_comes_again(kind: type[BaseException]) -> None:
    def ended(number: int, frame: object) -> None:
        raise SystemExit

    def work() -> None:
        with heard():
            Dropping(kind)
            time.sleep(10)

    before = signal.signal(signal.SIGTERM, ended)
    try:
        with pytest.raises(kind):
            work()
    finally:
        signal.signal(signal.SIGTERM, before)


def test_other_errors_in_destructors_are_told_as_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[type[BaseException]] = []
    monkeypatch.setattr(sys, "unraisablehook", lambda given: told.append(given.exc_type))
    with heard():
        Dropping(ValueError)
    assert told == [ValueError]
