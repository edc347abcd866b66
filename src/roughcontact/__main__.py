"""Entry point of the command line: ``roughcontact``, or ``python -m roughcontact``."""

# As few imports as possible: Ctrl-C during these prints a traceback.
import gc
import importlib.util
import os
import signal
import sys

# Exit statuses with which a shell reports a program ended by SIGHUP, SIGINT or SIGTERM.
_HUNG_UP, _INTERRUPTED, _TERMINATED = 129, 130, 143

# Modules and figures are hundreds of thousands of permanent objects: the default frequency of
# garbage collection takes a tenth of the time of a report.
_OBJECTS, _ROUNDS = 50_000, 20


def main() -> int:
    """Run the command line; return its exit status."""
    heard = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if heard:
        signal.signal(signal.SIGINT, lambda number, frame: _leave())
    _settle_figures()
    gc.set_threshold(_OBJECTS, _ROUNDS, _ROUNDS)
    from roughcontact.cli import app

    try:
        if heard:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        status = app.main()
        if status in (_HUNG_UP, _INTERRUPTED, _TERMINATED):
            # If the interrupt has passed through C code that runs Python, Python would end by
            # SIGINT instead of returning this status.
            os._exit(status)
        return status
    except KeyboardInterrupt:
        _leave()
        raise
    finally:
        # A signal must not interrupt the cleanup of the interpreter.
        for name in ("SIGINT", "SIGTERM", "SIGHUP"):
            if hasattr(signal, name):
                signal.signal(getattr(signal, name), signal.SIG_IGN)


def _leave() -> None:
    """Exit at once, before any file has been written."""
    try:
        os.write(2, b"roughcontact: interrupted; nothing was written\n")
    finally:
        os._exit(_INTERRUPTED)


def _settle_figures() -> None:
    """Configure Matplotlib to draw figures into files only, with its own settings."""
    os.environ["MPLBACKEND"] = "agg"
    result = importlib.util.find_spec("matplotlib")
    if result is not None and result.origin is not None:
        own = os.path.join(os.path.dirname(result.origin), "mpl-data", "matplotlibrc")
        os.environ["MATPLOTLIBRC"] = own


if __name__ == "__main__":
    sys.exit(main())
