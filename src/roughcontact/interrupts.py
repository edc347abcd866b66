"""Interrupts that come where Python drops them, and what they leave half made."""

from __future__ import annotations

import _thread
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

# Seconds after which an interrupt that was dropped comes again.
_MOMENT = 0.01


@contextmanager
def heard() -> Iterator[None]:
    """Have an end that is asked for where Python drops exceptions come again a moment later.

    A signal may come in a destructor or the callback of a weak reference; what its handler raises
    there is told of on standard error, and forgotten.
    """
    before = sys.unraisablehook
    soon: list[threading.Timer] = []
    main = threading.current_thread() is threading.main_thread()
    undecided = main and signal.getsignal(signal.SIGINT) is signal.default_int_handler

    def again(dropped: Any) -> None:
        if not _is_end(dropped):
            before(dropped)
            return
        asked = signal.SIGINT if dropped.exc_type is KeyboardInterrupt else signal.SIGTERM
        soon.append(threading.Timer(_MOMENT, _ask, (asked,)))
        soon[-1].daemon = True
        soon[-1].start()

    sys.unraisablehook = again
    if undecided:
        signal.signal(signal.SIGINT, _interrupted)
    try:
        yield
    finally:
        for timer in soon:
            timer.cancel()
        if undecided:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        sys.unraisablehook = before


def quiet() -> None:
    """Tell of nothing else that Python drops, until the end of `heard`.

    To be called by what answers a signal: what is half made when an end is asked for, such as a
    file of h5netcdf, has destructors that fail.
    """
    before = sys.unraisablehook
    sys.unraisablehook = lambda dropped: before(dropped) if _is_end(dropped) else None


def _is_end(dropped: Any) -> bool:
    return issubclass(dropped.exc_type, KeyboardInterrupt | SystemExit)


def _ask(number: signal.Signals) -> None:
    """Send a signal to the first thread, which it wakes where that can be done."""
    first = threading.main_thread().ident
    if first is not None and hasattr(signal, "pthread_kill"):
        signal.pthread_kill(first, number)
    else:
        _thread.interrupt_main(number)


def _interrupted(number: int, frame: object) -> None:
    """Do what Python does at Ctrl-C."""
    quiet()
    raise KeyboardInterrupt
