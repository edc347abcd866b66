"""Interrupts that come where Python drops them."""

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

    def again(dropped: Any) -> None:
        if not issubclass(dropped.exc_type, KeyboardInterrupt | SystemExit):
            before(dropped)
            return
        asked = signal.SIGINT if dropped.exc_type is KeyboardInterrupt else signal.SIGTERM
        timer = threading.Timer(_MOMENT, _thread.interrupt_main, (asked,))
        timer.daemon = True
        timer.start()

    sys.unraisablehook = again
    try:
        yield
    finally:
        sys.unraisablehook = before
